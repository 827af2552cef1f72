"""Renders a Mitsuba scene with LuxCore's path tracer or its bidirectional one.

    python3 validation/peers/luxcore_render.py path|bidir SCENE.xml OUT.exr SPP SEED THREADS

Needs `pip install pyluxcore==2.11.2 'numpy<2'`, in a separate environment. Nothing is clamped, no sampling is
adaptive, and `path` traces no light paths. The bidirectional path length cannot be limited. LuxCore seldom
tests whether it is done, so it may render more samples than requested; the time is that of the rendered
samples.
"""
import json
import os
import sys
import time

import numpy as np
import pyluxcore

import neutral


def words(values):
    return " ".join(repr(float(value)) for value in values)


class Translation:
    def __init__(self, scene):
        self.lines, self.images = [], {}
        sensor = scene["sensor"]
        origin, forward = np.array(sensor["origin"]), np.array(sensor["forward"])
        aspect = sensor["height"] / sensor["width"]
        self.add("scene.camera", type="perspective", lookat__orig=words(origin), lookat__target=words(origin + forward),
                 up=words(sensor["up"]), fieldofview=float(np.degrees(2 * np.arctan(sensor["tan_half_width"]))),
                 screenwindow=words([-1, 1, -aspect, aspect]),
                 lensradius=sensor["lens_radius"], focaldistance=sensor["focus_distance"], autofocus__enable=0)
        for number, mesh in enumerate(scene["meshes"]):
            self.material(f"m{number}", mesh)
            self.add(f"scene.shapes.s{number}", type="mesh", ply=mesh["file"])
            self.add(f"scene.objects.o{number}", shape=f"s{number}", material=f"m{number}")
        self.environment(scene["environment"])

    def add(self, prefix, **values):
        self.lines += [f"{prefix}.{key.replace('__', '.')} = {value}" for key, value in values.items()]

    def color(self, value):
        """Three numbers, or the name of an image texture, as LuxCore writes them."""
        if isinstance(value, list):
            return words(value)
        name = self.images.setdefault(value["image"], f"t{len(self.images)}")
        self.add(f"scene.textures.{name}", type="imagemap", file=value["image"], gamma=2.2, mapping__type="uvmapping2d",
                 mapping__uvscale="1 -1")
        return name

    def material(self, name, mesh):
        material, prefix = mesh["material"], f"scene.materials.{name}"
        if material["type"] == "diffuse":
            self.add(prefix, type="matte", kd=self.color(material["reflectance"]))
        elif material["type"] == "glass":
            self.add(prefix, type="glass", kr="1 1 1", kt="1 1 1", interiorior=material["interior"],
                     exteriorior=material["exterior"])
        elif material["roughness"] == 0.0:
            self.add(prefix, type="mirror", kr=words(reflectance(material)))
        else:
            tinted = material["reflectance"] != [1.0] * 3
            if material["eta"] is None or tinted and isinstance(material["reflectance"], list):
                sys.exit("not translated: a rough metal without indices, or tinted")
            inner = f"{prefix}bare" if tinted else prefix
            self.add(inner, type="metal2", n=words(material["eta"]), k=words(material["k"]),
                     uroughness=material["roughness"], vroughness=material["roughness"])
            if tinted:
                # A grey texture scales the metal, which is mixed with black.
                self.add(f"{prefix}black", type="matte", kd="0 0 0")
                self.add(prefix, type="mix", material1=f"{name}black", material2=f"{name}bare",
                         amount=self.color(material["reflectance"]))
        if mesh["radiance"]:
            self.add(prefix, emission=words(mesh["radiance"]), emission__gain="1 1 1")

    def environment(self, environment):
        if environment is None:
            return
        if "color" in environment:
            self.add("scene.lights.sky", type="constantinfinite", color=words(environment["color"]), gain="1 1 1")
        else:
            # In LuxCore's images z is up, and they begin elsewhere: its x, y, z are Mitsuba's −z, −x, y.
            turn = "0 0 -1 0  -1 0 0 0  0 1 0 0  0 0 0 1"
            self.add("scene.lights.sky", type="infinite", file=environment["image"], gamma=1.0, transformation=turn,
                     gain=words([environment["scale"]] * 3), visibilitymap__enable=0)

    def properties(self):
        found = pyluxcore.Properties()
        found.SetFromString("\n".join(self.lines) + "\n")
        return found


def reflectance(material):
    """A smooth metal's reflectance at normal incidence: LuxCore's mirror does not depend on the angle."""
    if material["eta"] is None:
        return material["reflectance"]
    n, k = np.array(material["eta"]), np.array(material["k"])
    return ((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k) * np.array(material["reflectance"])


def configuration(engine, sensor, depth, spp, seed, threads):
    found = pyluxcore.Properties()
    depth = depth if depth > 0 else 1000
    settings = {"renderengine.type": {"path": "PATHCPU", "bidir": "BIDIRCPU"}[engine], "renderengine.seed": max(seed, 1),
                "sampler.type": "SOBOL", "sampler.sobol.adaptive.strength": 0.0, "film.width": sensor["width"],
                "film.height": sensor["height"], "film.filter.type": "BOX", "film.filter.xwidth": 0.5,
                "film.filter.ywidth": 0.5, "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr",
                "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth, "path.pathdepth.glossy": depth,
                "path.pathdepth.specular": depth, "path.clamping.variance.maxvalue": 0.0,
                "path.hybridbackforward.enable": 0, "light.maxdepth": min(depth, 64), "path.maxdepth": min(depth, 64),
                "batch.haltspp": spp, "film.noiseestimation.warmup": 1 << 30}
    if threads > 0:
        settings["native.threads.count"] = threads
    found.SetFromString("".join(f"{key} = {value}\n" for key, value in settings.items()))
    return found


def main():
    engine, path, out, spp, seed, threads = sys.argv[1:7]
    start = time.perf_counter()
    pyluxcore.Init()
    pyluxcore.SetLogHandler(lambda _: None)
    source = neutral.scene(path)
    scene = pyluxcore.Scene()
    scene.Parse(Translation(source).properties())
    settings = configuration(engine, source["sensor"], source["max_depth"], int(spp), int(seed), int(threads))
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    session.Start()
    # The engine's own clock starts with its threads.
    begun, busy = time.perf_counter(), time.process_time()
    while not session.HasDone():
        time.sleep(0.005)
        session.UpdateStats()
    seconds = session.GetStats().Get("stats.renderengine.time").GetFloat()
    samples = session.GetStats().Get("stats.renderengine.pass").GetInt()
    cpu = time.process_time() - busy
    session.Stop()
    height, width = source["sensor"]["height"], source["sensor"]["width"]
    pixels = np.zeros((height, width, 3), dtype=np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0)
    neutral.write_exr(out, pixels[::-1])
    print(json.dumps({"seconds": seconds, "startup": begun - start, "cpu_seconds": cpu, "samples": samples}), flush=True)
    # Shutting down the engine sometimes crashes; the picture has been written.
    os._exit(0)


if __name__ == "__main__":
    main()
