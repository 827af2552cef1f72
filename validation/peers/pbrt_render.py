"""Renders a Mitsuba scene with pbrt-v4, if it is installed.

    python3 validation/peers/pbrt_render.py path|bdpt SCENE.xml OUT.exr SPP SEED THREADS

The program is the one named by the environment variable `PBRT`, or `pbrt` on the path. The seed is written to
the scene file, because a seed there overrides that of the command line. The rendering time is the one that
pbrt reports; reading the scene counts as start-up.
"""
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import neutral


def words(values):
    return " ".join(repr(float(value)) for value in values)


def material(entry, textures):
    kind, reflectance = entry["type"], entry.get("reflectance")
    if kind == "diffuse":
        if isinstance(reflectance, dict):
            name = f"image{len(textures)}"
            textures.append(f'Texture "{name}" "spectrum" "imagemap" "string filename" "{reflectance["image"]}"')
            return f'Material "diffuse" "texture reflectance" "{name}"'
        return f'Material "diffuse" "rgb reflectance" [{words(reflectance)}]'
    if kind == "glass":
        # pbrt has no exterior index, but refraction depends on the ratio only.
        return f'Material "dielectric" "float eta" {entry["interior"] / entry["exterior"]}'
    if isinstance(reflectance, dict) or entry["eta"] is not None and reflectance != [1.0] * 3:
        sys.exit("not translated: a metal with a texture, or tinted")
    if entry["eta"] is None:
        if entry["roughness"] > 0:
            sys.exit("not translated: a rough ideal mirror")
        return f'Material "conductor" "rgb reflectance" [{words(min(v, 0.9999) for v in reflectance)}] "float roughness" 0'
    return (f'Material "conductor" "rgb eta" [{words(entry["eta"])}] "rgb k" [{words(entry["k"])}] '
            f'"float roughness" {entry["roughness"]} "bool remaproughness" false')


def translation(scene, engine, out, spp, seed):
    sensor = scene["sensor"]
    target = [a + b for a, b in zip(sensor["origin"], sensor["forward"])]
    aspect = sensor["height"] / sensor["width"]
    # pbrt's field of view refers to the smaller side.
    fov = math.degrees(2 * math.atan(sensor["tan_half_width"] * min(1.0, aspect)))
    # In pbrt's camera space x points to the right; Scale -1 restores the handedness.
    lines = ["Scale -1 1 1", f'LookAt {words(sensor["origin"])} {words(target)} {words(sensor["up"])}',
             f'Camera "perspective" "float fov" {fov} "float lensradius" {sensor["lens_radius"]} '
             f'"float focaldistance" {sensor["focus_distance"]}',
             f'Film "rgb" "integer xresolution" {sensor["width"]} "integer yresolution" {sensor["height"]} '
             f'"string filename" "{out}" "float iso" 100 "string sensor" "cie1931" "bool savefp16" false',
             'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5',
             f'Sampler "zsobol" "integer pixelsamples" {spp} "integer seed" {seed}',
             f'Integrator "{engine}" "integer maxdepth" {scene["max_depth"] - 1 if scene["max_depth"] > 0 else 1000}',
             "WorldBegin"]
    environment = scene["environment"]
    if environment and "color" in environment:
        lines.append(f'LightSource "infinite" "rgb L" [{words(environment["color"])}]')
    elif environment:
        sys.exit("not translated: pbrt wants environment maps in an equal-area square")
    textures, shapes = [], []
    for mesh in scene["meshes"]:
        shapes += ["AttributeBegin", material(mesh["material"], textures)]
        if mesh["radiance"]:
            shapes.append(f'AreaLightSource "diffuse" "rgb L" [{words(mesh["radiance"])}]')
        shapes += [f'Shape "plymesh" "string filename" "{mesh["file"]}"', "AttributeEnd"]
    return "\n".join(lines + textures + shapes) + "\n"


def render_time(image):
    """The rendering time that pbrt writes into its image, in seconds; its progress bar shows only tenths."""
    name = b"renderTimeSeconds\0float\0" + struct.pack("<i", 4)
    head = Path(image).read_bytes()[:1 << 16]
    place = head.find(name)
    return struct.unpack_from("<f", head, place + len(name))[0] if place >= 0 else None


def main():
    engine, path, out, spp, seed, threads = sys.argv[1:7]
    if int(spp) & int(spp) - 1:
        # With other counts its sampler gives neighbouring pixels the same numbers.
        sys.exit(f"pbrt's sampler wants a power of two, not {spp} samples")
    start = time.perf_counter()
    program = os.environ.get("PBRT") or shutil.which("pbrt")
    if not program:
        sys.exit("no pbrt: put it on the path or name it in PBRT")
    scene = neutral.scene(path)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.pbrt"
        file.write_text(translation(scene, {"path": "path", "bdpt": "bdpt"}[engine], out, spp, seed))
        command = [program, "--spp", spp, "--nthreads", threads, str(file)] if int(threads) else [program, "--spp", spp, str(file)]
        begun = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True)
        seconds = time.perf_counter() - begun
        if done.returncode != 0:
            sys.exit((done.stderr.strip() or "pbrt failed").splitlines()[-1])
    rendering = render_time(out) or seconds
    print(json.dumps({"seconds": rendering, "startup": time.perf_counter() - start - rendering}))


if __name__ == "__main__":
    main()
