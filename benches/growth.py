"""How time and memory grow: with triangles, resolution, samples, depth, threads and lights, one at a time.

    python3 benches/growth.py [--json F] [--svg FOLDER] [--largest TRIANGLES]

Needs `cargo build --release`. Every point is the median of three runs of `etalon render`; the seconds are of the processor, start-up
included, and for threads those of the clock. Draws one SVG plot for each.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import tempfile
import time

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
ETALON = os.path.join(os.path.dirname(HERE), "target", "release", "etalon")
SCENE = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>
  <sensor type="perspective"><float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0, 3, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="{spp}"/></sampler>
    <film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{width}"/></film></sensor>
  {lights}
  <shape type="ply"><string name="filename" value="{mesh}"/><boolean name="face_normals" value="true"/>
    <bsdf type="diffuse"/></shape>
  <shape type="sphere"><point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.5"/>
    <bsdf type="diffuse"/></shape>
</scene>"""
USUAL = {"triangles": 20000, "lights": 1, "width": 96, "spp": 16, "depth": 8, "threads": 1}
PLOTS = {
    "triangles": [1e3, 1e4, 1e5, 1e6, 1e7],
    "lights": [1, 10, 100, 1000, 10000, 100000],
    "width": [24, 48, 96, 192, 384],
    "spp": [4, 16, 64, 256],
    "depth": [1, 2, 4, 8, 16, 32],
    "threads": [1, 2],
}
NAMES = {"triangles": "triangles", "lights": "point lights", "width": "pixels along a side", "spp": "samples a pixel",
         "depth": "greatest depth", "threads": "threads"}


def write_hills(path, triangles):
    """A square of hills with about so many triangles."""
    side = max(1, round(math.sqrt(triangles / 2)))
    x, z = numpy.meshgrid(numpy.linspace(-3, 3, side + 1), numpy.linspace(-3, 3, side + 1))
    y = 0.2 * numpy.sin(3 * x) * numpy.sin(3 * z) + 0.02 * numpy.sin(31 * x + 2) * numpy.sin(29 * z) - 0.2
    first = (numpy.arange(side)[:, None] * (side + 1) + numpy.arange(side)).reshape(-1)
    corners = [(0, side + 1, 1), (1, side + 1, side + 2)]
    faces = numpy.empty(2 * len(first), dtype=[("count", "u1"), ("indices", "<u4", 3)])
    faces["count"] = 3
    for half, offsets in enumerate(corners):
        faces["indices"][half::2] = first[:, None] + numpy.array(offsets)
    with open(path, "wb") as file:
        file.write((f"ply\nformat binary_little_endian 1.0\nelement vertex {x.size}\nproperty float x\nproperty float y\n"
                    f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n").encode())
        file.write(numpy.stack([x, y, z], -1).astype("<f4").tobytes())
        file.write(faces.tobytes())


def lights(count):
    """The same light in all, however many there are."""
    def light(i):
        angle, height = 2.399963 * i, 2 + (i % 7) / 7
        x, z = 2.5 * math.cos(angle) * math.sqrt((i + 1) / count), 2.5 * math.sin(angle) * math.sqrt((i + 1) / count)
        return (f'<emitter type="point"><point name="position" x="{x:.6f}" y="{height:.6f}" z="{z:.6f}"/>'
                f'<spectrum name="intensity" value="{20 / count:.8f}"/></emitter>')
    return "\n".join(light(i) for i in range(count))


def measure(folder, settings, runs):
    mesh = os.path.join(folder, f"{settings['triangles']:.0f}.ply")
    if not os.path.exists(mesh):
        write_hills(mesh, settings["triangles"])
    scene = os.path.join(folder, "scene.xml")
    with open(scene, "w") as file:
        file.write(SCENE.format(mesh=mesh, **{**settings, "lights": lights(settings["lights"])}))
    command = [ETALON, "render", "--quiet", "--threads", str(settings["threads"]), "-o", os.path.join(folder, "o.exr"), scene]
    points = []
    for _ in range(runs):
        start = time.perf_counter()
        process = subprocess.Popen(command)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
        if status:
            raise SystemExit(f"{' '.join(command)} failed")
        points.append((time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024))
    clock, processor, memory = (statistics.median(column) for column in zip(*points))
    return {"clock": clock, "processor": processor, "megabytes": memory}


def ticks(low, high):
    return [10.0**e for e in range(math.floor(low), math.ceil(high) + 1)]


def label(value):
    return f"{value:g}" if 0.01 <= value < 10000 else f"10<tspan dy='-5' font-size='9'>{round(math.log10(value))}</tspan>"


def plot(name, curves, path):
    """A plot with logarithmic axes: {curve: [(x, y)]}."""
    width, height, left, bottom, top = 420, 280, 56, 44, 26
    xs = [math.log10(x) for points in curves.values() for x, _ in points]
    ys = [math.log10(y) for points in curves.values() for _, y in points]
    x0, x1 = min(xs), max(max(xs), min(xs) + 0.3)
    y0, y1 = math.floor(min(ys)), max(math.ceil(max(ys)), math.floor(min(ys)) + 1)
    px = lambda x: left + (math.log10(x) - x0) / (x1 - x0) * (width - left - 16)
    py = lambda y: height - bottom - (math.log10(y) - y0) / (y1 - y0) * (height - bottom - top)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for y in ticks(y0, y1):
        out.append(f'<path d="M{left} {py(y):.1f}H{width - 16}" stroke="#ddd"/>'
                   f'<text x="{left - 6}" y="{py(y) + 4:.1f}" text-anchor="end">{label(y)}</text>')
    for x in sorted({x for points in curves.values() for x, _ in points}):
        out.append(f'<text x="{px(x):.1f}" y="{height - bottom + 18}" text-anchor="middle">{label(x)}</text>')
    out.append(f'<text x="{(left + width) / 2}" y="{height - 8}" text-anchor="middle">{NAMES[name]}</text>')
    for i, (curve, points) in enumerate(curves.items()):
        colour, dash = [("#1b6ca8", ""), ("#c8553d", ' stroke-dasharray="6 3"')][i % 2]
        line = " ".join(f"{px(x):.1f},{py(y):.1f}" for x, y in points)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
        out += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="3" fill="{colour}"/>' for x, y in points]
        out.append(f'<text x="{left + 8 + 170 * i}" y="16" fill="{colour}">{curve}</text>')
    out.append("</svg>")
    with open(path, "w") as file:
        file.write("\n".join(out) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plots", nargs="*", default=list(PLOTS))
    parser.add_argument("--json")
    parser.add_argument("--svg")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--largest", type=float, default=1e7)
    arguments = parser.parse_args()
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.plots:
            points = [x for x in PLOTS[name] if name != "triangles" or x <= arguments.largest]
            results[name] = [{"x": x, **measure(folder, {**USUAL, name: x}, arguments.runs)} for x in points]
            print(name, *(f"{p['x']:g}: {p['processor']:.2f} s, {p['megabytes']:.0f} MB;" for p in results[name]), flush=True)
            time_is = "clock" if name == "threads" else "processor"
            curves = {f"{time_is} time, s": [(p["x"], p[time_is]) for p in results[name]]}
            if name in ("triangles", "width", "lights"):
                curves["peak memory, MB"] = [(p["x"], p["megabytes"]) for p in results[name]]
            if arguments.svg:
                plot(name, curves, os.path.join(arguments.svg, f"growth-{name}.svg"))
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(results, file, indent=1)


if __name__ == "__main__":
    main()
