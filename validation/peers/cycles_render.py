"""Renders a Mitsuba scene with Blender's Cycles, as an unbiased path tracer.

    python3 validation/peers/cycles_render.py SCENE.xml OUT.exr SPP SEED THREADS

Needs `pip install bpy==5.0.1`, in a separate environment. No clamping, no denoiser, no adaptive sampling, no
glossy filter, no light threshold, all bounces; caustics and the light tree are on. Time is measured from the
moment when Cycles reports sample 0, with the acceleration structure built.
"""
import json
import math
import sys
import tempfile
import time
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

import neutral


def node(tree, kind, **inputs):
    made = tree.nodes.new(kind)
    for name, value in inputs.items():
        made.inputs[name.replace("_", " ")].default_value = value
    return made


def rgba(color):
    return [*map(float, color), 1.0]


def connect_color(tree, value, socket):
    """Sets a socket to three numbers, or to an image texture with the mesh's coordinates."""
    if isinstance(value, list):
        socket.default_value = rgba(value)
        return
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(value["image"], check_existing=True)
    flip = node(tree, "ShaderNodeMapping", Scale=(1.0, -1.0, 1.0))
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], flip.inputs["Vector"])
    tree.links.new(flip.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], socket)


def connect_value(tree, value, socket):
    """Sets a socket to one number, or to the mean of an image texture's colours."""
    color = tree.nodes.new("ShaderNodeRGBToBW")
    connect_color(tree, value, color.inputs["Color"])
    tree.links.new(color.outputs["Val"], socket)


def scatterer(tree, material):
    if material["type"] == "diffuse":
        made = node(tree, "ShaderNodeBsdfDiffuse", Roughness=0.0)
        connect_color(tree, material["reflectance"], made.inputs["Color"])
    elif material["type"] == "glass":
        made = node(tree, "ShaderNodeBsdfGlass", Color=rgba([1, 1, 1]), Roughness=0.0,
                    IOR=material["interior"] / material["exterior"])
    elif material["eta"] is None:
        made = node(tree, "ShaderNodeBsdfAnisotropic", Roughness=math.sqrt(material["roughness"]))
        made.distribution = "GGX"
        connect_color(tree, material["reflectance"], made.inputs["Color"])
    else:
        tinted = material["reflectance"] != [1.0] * 3
        if tinted and isinstance(material["reflectance"], list):
            sys.exit("not translated: a tinted metal with indices")
        made = node(tree, "ShaderNodeBsdfMetallic", Roughness=math.sqrt(material["roughness"]))
        made.distribution, made.fresnel_type = "GGX", "PHYSICAL_CONDUCTOR"
        made.inputs["IOR"].default_value, made.inputs["Extinction"].default_value = material["eta"], material["k"]
        if tinted:
            # A grey texture scales the metal, which is mixed with black.
            mixed = tree.nodes.new("ShaderNodeMixShader")
            black = node(tree, "ShaderNodeBsdfDiffuse", Color=rgba([0, 0, 0]))
            connect_value(tree, material["reflectance"], mixed.inputs["Fac"])
            tree.links.new(black.outputs[0], mixed.inputs[1])
            tree.links.new(made.outputs[0], mixed.inputs[2])
            made = mixed
    return made.outputs[0]


def make_material(name, mesh):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    surface = scatterer(tree, mesh["material"])
    if mesh["radiance"]:
        # The mesh emits from its front only, and its surface also reflects.
        made.cycles.emission_sampling = "FRONT"
        emission = node(tree, "ShaderNodeEmission", Color=rgba(mesh["radiance"]), Strength=1.0)
        side = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], side.inputs["Fac"])
        tree.links.new(emission.outputs[0], side.inputs[1])
        add = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(side.outputs[0], add.inputs[0])
        tree.links.new(surface, add.inputs[1])
        surface = add.outputs[0]
    tree.links.new(surface, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def add_mesh(number, mesh):
    known = set(bpy.data.objects)
    bpy.ops.wm.ply_import(filepath=mesh["file"], forward_axis="Y", up_axis="Z", import_colors="NONE")
    made = next(iter(set(bpy.data.objects) - known))
    made.data.materials.clear()
    made.data.materials.append(make_material(f"material {number}", mesh))
    if not mesh["smooth"]:
        made.data.shade_flat()


def add_environment(environment):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = [0, 0, 0, 1]
    if environment is None:
        return
    if "color" in environment:
        background.inputs["Color"].default_value = rgba(environment["color"])
        return
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(environment["image"])
    # In Blender's images z is up: its x, y, z are Mitsuba's −z, −x, y.
    turn = node(tree, "ShaderNodeMapping", Rotation=Matrix(((0, 0, -1), (-1, 0, 0), (0, 1, 0))).to_euler())
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = environment["scale"]


def add_camera(sensor):
    data = bpy.data.cameras.new("camera")
    made = bpy.data.objects.new("camera", data)
    bpy.context.collection.objects.link(made)
    bpy.context.scene.camera = made
    forward, up = Vector(sensor["forward"]), Vector(sensor["up"])
    right = forward.cross(up)
    made.matrix_world = Matrix.Translation(sensor["origin"]) @ Matrix((right, up, -forward)).transposed().to_4x4()
    data.sensor_fit = "HORIZONTAL"
    data.angle = 2 * math.atan(sensor["tan_half_width"])
    data.clip_start, data.clip_end = 1e-4, 1e6
    if sensor["lens_radius"] > 0:
        data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_blades = True, sensor["focus_distance"], 0
        data.dof.aperture_fstop = data.lens / 1000 / (2 * sensor["lens_radius"])


def settings(scene, source, seed, threads):
    scene.render.engine = "CYCLES"
    sensor, cycles = source["sensor"], scene.cycles
    scene.render.resolution_x, scene.render.resolution_y = sensor["width"], sensor["height"]
    scene.render.resolution_percentage = 100
    if threads > 0:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    bounces = source["max_depth"] - 1 if source["max_depth"] > 0 else 1024
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, name, bounces)
    cycles.device, cycles.seed, cycles.pixel_filter_type = "CPU", seed, "BOX"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_guiding = cycles.use_fast_gi = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = cycles.use_light_tree = True
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    scene.view_settings.view_transform = "Standard"


def main():
    path, out, spp, seed, threads = sys.argv[1:6]
    start = time.perf_counter()
    source = neutral.scene(path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for number, mesh in enumerate(source["meshes"]):
        add_mesh(number, mesh)
    add_environment(source["environment"])
    add_camera(source["sensor"])
    scene = bpy.context.scene
    settings(scene, source, int(seed), int(threads))
    scene.cycles.samples = int(spp)
    times = []
    clocks = lambda: times.append((time.perf_counter(), time.process_time()))
    bpy.app.handlers.render_stats.append(lambda text, *_: clocks() if "Sample" in str(text) else None)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        bpy.ops.render.render(write_still=True)
        Path(out).write_bytes(Path(scene.render.filepath).read_bytes())
    seconds, cpu = (last - first for first, last in zip(times[0], times[-1]))
    print(json.dumps({"seconds": seconds, "startup": times[0][0] - start, "cpu_seconds": cpu}), flush=True)


if __name__ == "__main__":
    main()
