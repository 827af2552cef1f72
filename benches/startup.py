"""From the command line to the first picture of a large PLY mesh, beside Mitsuba: seconds of the processor
and of the clock, and peak memory, each run a process of its own, A B C A B C …, medians.

    python3 benches/startup.py [--folder F] [--rounds N] [--json F] [--variants LIST]

Needs `cargo build --release` with `--example rays`, and `pip install mitsuba`; a variant that cannot run is
reported as missing. The picture has 16x16 pixels and one sample each, so that nearly all is reading and
building.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
SCENE = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective"><float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="-4.5, 1.5, -4.5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>
  <emitter type="point"><point name="position" x="1" y="2.4" z="-2"/><spectrum name="intensity" value="10"/></emitter>
  <shape type="ply"><string name="filename" value="{mesh}"/><boolean name="face_normals" value="true"/>
    <bsdf type="diffuse"/></shape>
</scene>"""
MITSUBA = """import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
mi.render(mi.load_file(sys.argv[2]), spp=1).numpy()"""


def write_ply(source, target):
    with open(source, "rb") as file:
        vertices, triangles = numpy.fromfile(file, "<u4", 2)
        positions = numpy.fromfile(file, "<f4", 3 * vertices)
        indices = numpy.fromfile(file, "<u4", 3 * triangles).reshape(-1, 3)
    faces = numpy.empty(len(indices), dtype=[("count", "u1"), ("indices", "<u4", 3)])
    faces["count"], faces["indices"] = 3, indices
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
              f"property float z\nelement face {triangles}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(target, "wb") as file:
        file.write(header.encode())
        file.write(positions.tobytes())
        file.write(faces.tobytes())
    return int(triangles)


def measure(command):
    """Times and memory of a command run in a process of its own; None if it fails."""
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    if status:
        return None
    return {"clock": time.perf_counter() - start, "processor": usage.ru_utime + usage.ru_stime,
            "megabytes": usage.ru_maxrss / 1024}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", default=os.path.join(ROOT, "target", "rays"))
    parser.add_argument("--mesh", default="urchins-2500k")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--variants", default="scalar_rgb,llvm_ad_rgb")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    source = os.path.join(arguments.folder, f"{arguments.mesh}.mesh")
    if not os.path.exists(source):
        rays = os.path.join(ROOT, "target", "release", "examples", "rays")
        subprocess.run([rays, "record", arguments.folder, arguments.mesh], check=True)
    mesh, scene = (os.path.join(arguments.folder, f"startup.{end}") for end in ("ply", "xml"))
    triangles = write_ply(source, mesh)
    with open(scene, "w") as file:
        file.write(SCENE.format(mesh=mesh))
    picture = os.path.join(arguments.folder, "startup.exr")
    etalon = os.path.join(ROOT, "target", "release", "etalon")
    commands = {"etalon": [etalon, "render", "--quiet", "--color", "rgb", "--spp", "1", "-o", picture, scene]}
    for variant in arguments.variants.split(","):
        commands[f"mitsuba {variant}"] = [sys.executable, "-c", MITSUBA, variant, scene]
    runs = {name: [] for name in commands}
    for _ in range(arguments.rounds):
        for name, command in commands.items():
            runs[name].append(measure(command))
    print(f"| {triangles} triangles | clock, s | processor, s | peak memory, MB |\n|---|--:|--:|--:|")
    results = {}
    for name, measured in runs.items():
        if None in measured:
            print(f"| {name} | missing | | |")
            continue
        results[name] = {key: statistics.median(run[key] for run in measured) for key in measured[0]}
        print(f"| {name} | {results[name]['clock']:.2f} | {results[name]['processor']:.2f} | {results[name]['megabytes']:.0f} |")
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump({"triangles": triangles, "results": results}, file, indent=1)


if __name__ == "__main__":
    main()
