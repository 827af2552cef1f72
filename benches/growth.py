"""How time and memory grow with triangles, lights, resolution, samples, depth, channels of the spectrum and
threads, one at a time.

    python3 benches/growth.py [PLOT …] [--json F] [--svg FOLDER] [--largest TRIANGLES] [--runs N]

Needs `cargo build --release`. Every point is the median of three runs of `etalon render`. All seconds are
processor time, so that other work on the machine does not count. The slope is the exponent of growth of
tracing since the previous point. *Start-up* is a render of one sample of one pixel: everything that is read
and built. Memory is the peak that the program itself reports: the kernel's figure for a child includes memory
of its parent. Draws one SVG plot for each parameter, prints a Markdown table, and draws the results of an
earlier run with `--from F`.
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
ROOT = os.path.dirname(HERE)
ETALON = os.path.join(ROOT, "target", "release", "etalon")
SCENE = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="{roulette}"/></integrator>
  <sensor type="perspective"><float name="fov" value="60"/>
    <transform name="to_world"><lookat origin="0, 3, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="{spp}"/></sampler>
    <film type="{film}"><integer name="width" value="{width}"/><integer name="height" value="{width}"/>{responses}</film></sensor>
  {lights}
  {room}
  <shape type="ply"><string name="filename" value="{mesh}"/><boolean name="face_normals" value="true"/>
    <bsdf type="diffuse"/></shape>
  <shape type="sphere"><point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.5"/>
    <bsdf type="diffuse"/></shape>
</scene>"""
# Walls that absorb a tenth of the light, so that paths are long.
ROOM = """<shape type="cube"><boolean name="flip_normals" value="true"/><transform name="to_world"><scale value="8"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf></shape>"""
USUAL = {"triangles": 20000, "lights": 1, "light": "point", "width": 128, "spp": 16, "depth": 8, "roulette": 5, "threads": 1, "bands": 0, "room": ""}
# The values on the axis, its name, and the curves with their further settings.
PLOTS = {
    "triangles": ([1e3, 1e4, 1e5, 1e6, 1e7], "triangles", {"": {"spp": 256}}),
    "lights": ([1, 10, 100, 1000, 10000, 100000], "lights", {"points": {}, "spheres": {"light": "sphere"}}),
    "width": ([32, 64, 128, 256, 512, 1024], "pixels along a side", {"": {}}),
    "spp": ([4, 16, 64, 256, 1024], "samples a pixel", {"": {}}),
    "depth": ([1, 2, 4, 8, 16, 32, 64], "greatest depth",
              {"roulette": {"room": ROOM}, "no roulette": {"room": ROOM, "roulette": 1000}}),
    "bands": ([1, 4, 16, 64, 256], "channels of the spectrum", {"": {}}),
    "threads": ([1, 2, 4, 8], "threads", {"": {"spp": 256}}),
}


def write_hills(path, triangles):
    """Writes a PLY file of a square of hills with about this number of triangles."""
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


def lights(count, kind):
    """This number of lights with a constant total power: points, or small luminous spheres."""
    def light(i):
        angle, height = 2.399963 * i, 2 + (i % 7) / 7
        x, z = 2.5 * math.cos(angle) * math.sqrt((i + 1) / count), 2.5 * math.sin(angle) * math.sqrt((i + 1) / count)
        place = f'x="{x:.6f}" y="{height:.6f}" z="{z:.6f}"/>'
        if kind == "point":
            return (f'<emitter type="point"><point name="position" {place}'
                    f'<spectrum name="intensity" value="{20 / count:.8f}"/></emitter>')
        radius = 0.1 / math.sqrt(count)
        return (f'<shape type="sphere"><point name="center" {place}<float name="radius" value="{radius:.8f}"/>'
                f'<emitter type="area"><spectrum name="radiance" value="{20 / math.pi / 0.01:.8f}"/></emitter></shape>')
    return "\n".join(light(i) for i in range(count))


def responses(count):
    """This number of triangular sensitivities side by side over the visible range."""
    step = 300 / count if count else 0
    def response(i):
        middle = 400 + (i + 0.5) * step
        return f'<spectrum name="b{i:03}" value="{middle - step:.3f}:0, {middle:.3f}:1, {middle + step:.3f}:0"/>'
    return "\n".join(response(i) for i in range(count))


def scene_file(folder, settings):
    mesh = os.path.join(folder, f"{settings['triangles']:.0f}.ply")
    if not os.path.exists(mesh):
        write_hills(mesh, settings["triangles"])
    scene = os.path.join(folder, "scene.xml")
    film = "specfilm" if settings["bands"] else "hdrfilm"
    filled = {**settings, "lights": lights(settings["lights"], settings["light"]), "responses": responses(settings["bands"])}
    with open(scene, "w") as file:
        file.write(SCENE.format(mesh=mesh, film=film, **filled))
    return scene


def run(command):
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    document = json.loads(process.stdout.read())
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = status
    if status:
        raise SystemExit(f"{' '.join(command)} failed")
    return {"clock": time.perf_counter() - start, "processor": usage.ru_utime + usage.ru_stime,
            "megabytes": document["peak_memory_bytes"] / 1e6, "rays": document["rays"], "samples": document["samples"]}


def measure(folder, settings, runs):
    scene = scene_file(folder, settings)
    command = [ETALON, "render", "--json", "--threads", str(settings["threads"]), "-o", os.path.join(folder, "o.exr"), scene]
    median = lambda points: {key: statistics.median(point[key] for point in points) for key in points[0]}
    whole, start_up = [], []
    for _ in range(runs):
        whole.append(run(command))
        start_up.append(run([*command, "--crop", "0,0,1,1", "--spp", "1"]))
    return {**median(whole), "start_up": median(start_up)}


def slope(points, key):
    """The exponent of growth between the last two points."""
    (x0, a), (x1, b) = [(p["x"], key(p)) for p in points[-2:]]
    return math.log(b / a) / math.log(x1 / x0) if a > 0 and b > 0 else float("nan")


def tracing(point):
    return point["processor"] - point["start_up"]["processor"]


def table(results):
    lines = ["| along | | | start-up, s | tracing, s | µs a sample | ns a ray | slope | peak memory, MB |", "|---|---|--:|--:|--:|--:|--:|--:|--:|"]
    for name, curves in results.items():
        for curve, points in curves.items():
            for i, point in enumerate(points):
                seconds = tracing(point)
                grown = f"{slope(points[: i + 1], tracing):.2f}" if i else ""
                lines.append(f"| {PLOTS[name][1]} | {curve} | {point['x']:,.0f} | {point['start_up']['processor']:.2f} | {seconds:.2f} | "
                             f"{seconds / point['samples'] * 1e6:.2f} | {seconds / point['rays'] * 1e9:.0f} | {grown} | {point['megabytes']:.0f} |")
    return "\n".join(lines)


def ticks(low, high):
    return [10.0**e for e in range(math.floor(low), math.ceil(high) + 1)]


def label(value):
    return f"{value:g}" if 0.01 <= value < 10000 else f"10<tspan dy='-5' font-size='9'>{round(math.log10(value))}</tspan>"


def plot(axis, curves, path):
    """A plot with logarithmic axes: {curve: [(x, y)]}."""
    width, height, left, bottom, top = 420, 300, 56, 44, 20 + 16 * ((len(curves) + 1) // 2)
    curves = {curve: [(x, y) for x, y in points if y > 0] for curve, points in curves.items()}
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
    out.append(f'<text x="{(left + width) / 2}" y="{height - 8}" text-anchor="middle">{axis}</text>')
    looks = [(colour, dash) for dash in ("", ' stroke-dasharray="6 3"') for colour in ("#1b6ca8", "#c8553d", "#5b8c3a")]
    for i, (curve, points) in enumerate(curves.items()):
        colour, dash = looks[i % len(looks)]
        line = " ".join(f"{px(x):.1f},{py(y):.1f}" for x, y in points)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
        out += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="3" fill="{colour}"/>' for x, y in points]
        x, y = left + 170 * (i % 2), 12 + 16 * (i // 2)
        out.append(f'<path d="M{x} {y}h22" stroke="{colour}" stroke-width="2"{dash}/><text x="{x + 28}" y="{y + 4}" fill="{colour}">{curve}</text>')
    out.append("</svg>")
    with open(path, "w") as file:
        file.write("\n".join(out) + "\n")


def draw(name, curves, folder):
    lines = {}
    for curve, points in curves.items():
        whose = f", {curve}" if curve else ""
        lines[f"tracing, s{whose}"] = [(p["x"], tracing(p)) for p in points]
        if name in ("triangles", "lights"):
            lines[f"start-up, s{whose}"] = [(p["x"], p["start_up"]["processor"]) for p in points]
        if name in ("triangles", "width", "lights", "bands", "threads"):
            lines[f"memory, MB{whose}"] = [(p["x"], p["megabytes"]) for p in points]
    plot(PLOTS[name][1], lines, os.path.join(folder, f"growth-{name}.svg"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plots", nargs="*", default=list(PLOTS), metavar="PLOT", help=", ".join(PLOTS))
    parser.add_argument("--json")
    parser.add_argument("--from", dest="source", help="results of an earlier run, to be drawn again")
    parser.add_argument("--svg")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--largest", type=float, default=1e7)
    arguments = parser.parse_args()
    results = {}
    if arguments.source:
        with open(arguments.source) as file:
            results = json.load(file)
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.plots if not arguments.source else []:
            xs, _, curves = PLOTS[name]
            points = [x for x in xs if name != "triangles" or x <= arguments.largest]
            results[name] = {}
            for curve, settings in curves.items():
                measured = [{"x": x, **measure(folder, {**USUAL, **settings, name: x}, arguments.runs)} for x in points]
                results[name][curve] = measured
                print(name, curve, *(f"{p['x']:g}: {p['start_up']['processor']:.2f} + {tracing(p):.2f} s, {p['megabytes']:.0f} MB;" for p in measured),
                      f"slope {slope(measured, tracing):.2f}", flush=True)
            if arguments.json:
                with open(arguments.json, "w") as file:
                    json.dump(results, file, indent=1)
    if arguments.svg:
        for name, curves in results.items():
            draw(name, curves, arguments.svg)
    print(table(results))


if __name__ == "__main__":
    main()
