"""Etalon's rays a second beside Embree's, on the very same rays, single rays on one thread: A B C A B C …,
medians of pairs.

    python3 benches/rays_side_by_side.py [--folder F] [--rounds N] [--json F] [--markdown F] [--tables F] [--library NAME]... [MESH...]

Needs `cargo build --release --example rays`, a C++ compiler, and for Embree Debian's `libembree-dev` or
PyPI's `embreex`; what is missing is said in the table. Records the rays if the folder has none. Times are the
processor time of the tracing thread, so that other work on the machine disturbs little. Every ray that the
programs disagree on is judged in exact rational arithmetic.
"""

import argparse
import glob
import importlib.util
import json
import os
import statistics
import subprocess
import sys
from fractions import Fraction

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
ETALON = os.path.join(ROOT, "target", "release", "examples", "rays")
MESHES = ["urchin-1k", "twigs-60k", "urchins-164k", "landscape-524k", "urchins-2500k"]
QUESTIONS = [("closest", "primary"), ("closest", "bounce"), ("occluded", "shadow"), ("occluded", "bounce")]


def embree_libraries():
    """The newest Embree of each kind of installation."""
    found = glob.glob("/usr/lib/*/libembree[34].so.[34]")
    package = importlib.util.find_spec("embreex")
    if package:
        folder = os.path.join(os.path.dirname(os.path.dirname(package.origin)), "embreex.libs")
        found += glob.glob(os.path.join(folder, "libembree4*"))
    return found


class Tracer:
    """A program that has built the tree of a mesh and traces sets of rays on request."""

    def __init__(self, command, library_folder=None):
        environment = dict(os.environ)
        if library_folder:
            environment["LD_LIBRARY_PATH"] = library_folder
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        self.about = json.loads(self.process.stdout.readline())
        self.about["processor_seconds"] = sum(map(self.seconds_of, os.listdir(f"/proc/{self.process.pid}/task")))

    def seconds_of(self, thread):
        with open(f"/proc/{self.process.pid}/task/{thread}/schedstat") as file:
            return int(file.read().split()[0]) * 1e-9

    def cpu(self):
        return self.seconds_of(self.process.pid)

    def ask(self, *words):
        before = self.cpu()
        self.process.stdin.write(" ".join(words) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        # A running thread's time is up to date only when it waits for the next request.
        while open(f"/proc/{self.process.pid}/stat").read().rsplit(")", 1)[1].split()[0] != "S":
            pass
        answer["cpu"] = self.cpu() - before
        return answer

    def hits(self, kind, path):
        self.ask("hits", kind, path)
        return numpy.fromfile(path, dtype=[("t", "<f8"), ("primitive", "<u8")])

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def read_mesh(path):
    with open(path, "rb") as file:
        vertices, triangles = numpy.fromfile(file, "<u4", 2)
        positions = numpy.fromfile(file, "<f4", 3 * vertices).reshape(-1, 3)
        return positions[numpy.fromfile(file, "<u4", 3 * triangles).reshape(-1, 3)]


def exact_distance(ray, corners):
    """The exact distance at which the ray meets the triangle, edges included; None where it misses."""
    number = [Fraction(float(x)) for x in ray[:7]]
    origin, start, direction = number[0:3], number[3], number[4:7]
    a, b, c = [[Fraction(float(x)) - o for x, o in zip(p, origin)] for p in corners]

    def volume(p, q):
        cross = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        return sum(d * x for d, x in zip(direction, cross))

    edges = [volume(b, c), volume(c, a), volume(a, b)]
    total = sum(edges)
    if total == 0 or (min(edges) < 0 and max(edges) > 0):
        return None
    axis = max(range(3), key=lambda i: abs(direction[i]))
    t = sum(e * p[axis] for e, p in zip(edges, (a, b, c))) / total / direction[axis]
    return t if t > start and not t > (Fraction(float(ray[7])) if numpy.isfinite(ray[7]) else t) else None


def disagreements(corners, rays, etalon, embree):
    """Counts of rays by whether the two programs agree, and if not, which of them is right."""
    counts = {"same": 0, "the same point of a shared edge": 0, "Embree misses": 0, "Embree farther": 0,
              "Etalon misses": 0, "Etalon farther": 0, "neither meets it exactly": 0}
    differ = etalon["primitive"] != embree["primitive"]
    counts["same"] = int((~differ).sum())
    nothing = numpy.uint64(2**64 - 1)
    for i in numpy.flatnonzero(differ):
        ours, theirs = [None if h[i]["primitive"] == nothing else exact_distance(rays[i], corners[int(h[i]["primitive"])])
                        for h in (etalon, embree)]
        if ours is None and theirs is None:
            counts["neither meets it exactly"] += 1
        elif theirs is None:
            counts["Embree misses"] += 1
        elif ours is None:
            counts["Etalon misses"] += 1
        elif ours == theirs:
            counts["the same point of a shared edge"] += 1
        else:
            counts["Embree farther" if ours < theirs else "Etalon farther"] += 1
    both = (etalon["primitive"] == embree["primitive"]) & (etalon["primitive"] != nothing)
    error = numpy.abs(etalon["t"][both] - embree["t"][both]) / etalon["t"][both]
    counts["largest relative difference of distances"] = float(error.max()) if both.any() else 0.0
    return counts


def started(mesh, folder, libraries, isa):
    """Every program, when it has built its tree."""
    tracers = {"etalon": Tracer([ETALON, "replay", folder, mesh])}
    for library in libraries:
        for mode in ["robust", "fast"]:
            command = [os.path.join(ROOT, "target", "rays-embree"), library, folder, mesh, mode, isa, "2"]
            tracer = Tracer(command, os.path.dirname(library))
            version = str(tracer.about["version"])
            tracers[f"embree {version[0]}.{int(version[1:3])}.{int(version[3:5])} {mode}"] = tracer
    return tracers


def build_times(mesh, folder, libraries, rounds, isa):
    """Medians over starts in turn: seconds of building by the clock; those of the processor, with reading; and how
    many times Etalon's either is."""
    rows = []
    for _ in range(rounds):
        tracers = started(mesh, folder, libraries, isa)
        rows.append({name: tracer.about for name, tracer in tracers.items()})
        for tracer in tracers.values():
            tracer.close()
    kinds = {"clock": "build_seconds", "processor": "processor_seconds"}
    def median(of):
        return {kind: statistics.median(of(row, key) for row in rows) for kind, key in kinds.items()}
    return {name: {"seconds": median(lambda row, key: row[name][key]),
                   "ratio": median(lambda row, key: row["etalon"][key] / row[name][key])} for name in rows[0]}


def measure(mesh, folder, libraries, rounds, isa):
    builds = build_times(mesh, folder, libraries, rounds, isa)
    tracers = started(mesh, folder, libraries, isa)
    corners = read_mesh(os.path.join(folder, f"{mesh}.mesh"))
    result = {"mesh": mesh, "about": {name: tracer.about for name, tracer in tracers.items()}, "builds": builds, "rates": [], "agreement": []}
    for question, kind in QUESTIONS:
        rays = numpy.fromfile(os.path.join(folder, f"{mesh}-{kind}.rays"), "<f4").reshape(-1, 8)
        times = {name: [] for name in tracers}
        for tracer in tracers.values():
            tracer.ask(question, kind)
        for _ in range(rounds):
            for name, tracer in tracers.items():
                times[name].append(tracer.ask(question, kind)["cpu"])
        row = {"question": question, "kind": kind, "rays": len(rays)}
        row["mrays"] = {name: len(rays) / statistics.median(seconds) * 1e-6 for name, seconds in times.items()}
        row["ratio"] = {name: statistics.median(b / a for a, b in zip(times["etalon"], seconds))
                        for name, seconds in times.items() if name != "etalon"}
        result["rates"].append(row)
        print(f"{mesh} {question} {kind}", {n: round(v, 2) for n, v in row["mrays"].items()},
              {n: round(v, 3) for n, v in row["ratio"].items()}, file=sys.stderr)
        if question == "closest":
            path = os.path.join(folder, "hits")
            ours = tracers["etalon"].hits(kind, path)
            for name, tracer in tracers.items():
                if name != "etalon":
                    counts = disagreements(corners, rays, ours, tracer.hits(kind, path))
                    result["agreement"].append({"kind": kind, "peer": name, **counts})
                    print("   ", name, counts, file=sys.stderr)
    for tracer in tracers.values():
        tracer.close()
    return result


def geometric_mean(values):
    return statistics.geometric_mean(values) if values else float("nan")


def markdown(results):
    peers = [name for name in results[0]["about"] if name != "etalon"]
    if not peers:
        yield "Embree is not installed: `apt-get install libembree-dev` or `pip install embreex`."
        yield ""
    yield "| mesh | question | rays | Etalon, M/s | " + "".join(f"{p}, M/s | " for p in peers) + " | ".join(f"× {p}" for p in peers) + " |"
    yield "|---|---|---|--:|" + "--:|" * (2 * len(peers))
    for result in results:
        for row in result["rates"]:
            cells = [f"{row['mrays'][p]:.2f}" for p in ["etalon"] + peers] + [f"{row['ratio'][p]:.2f}" for p in peers]
            yield f"| {result['mesh']} | {row['question']} | {row['kind']} | " + " | ".join(cells) + " |"
    if peers:
        means = [geometric_mean([row["ratio"][p] for result in results for row in result["rates"]]) for p in peers]
        yield "| **geometric mean** | | | | " + "| " * len(peers) + " | ".join(f"**{m:.2f}**" for m in means) + " |"
        yield ""
        yield "Building by the clock, and reading and building in processor time, two threads:"
        yield ""
        programs = ["etalon"] + peers
        columns = ["{}, clock s", "{}, processor s"]
        heads = [c.format(p) for p in programs for c in columns]
        heads += [f"Etalon's over {p}, clock" for p in peers] + [f"Etalon's over {p}, processor" for p in peers]
        heads += [f"{p}, bytes a triangle" for p in programs]
        yield "| mesh | triangles | " + " | ".join(heads) + " |"
        yield "|---|--:|" + "--:|" * len(heads)
        for result in results:
            builds, about = result["builds"], result["about"]
            cells = [f"{builds[p]['seconds'][kind]:.3f}" for p in programs for kind in ("clock", "processor")]
            cells += [f"{builds[p]['ratio'][kind]:.2f}" for kind in ("clock", "processor") for p in peers]
            cells += [f"{about[p]['bytes'] / about[p]['triangles']:.0f}" for p in programs]
            yield f"| {result['mesh']} | {about['etalon']['triangles']} | " + " | ".join(cells) + " |"
        yield ""
        yield "Where the closest hits differ, and who is right in exact arithmetic; all other sets agree on every triangle:"
        yield ""
        reasons = [key for key in results[0]["agreement"][0] if key not in ("kind", "peer")]
        yield "| mesh | rays | beside | " + " | ".join(reasons) + " |"
        yield "|---|---|---|" + "--:|" * len(reasons)
        for result in results:
            for row in result["agreement"]:
                if row["same"] == sum(row[r] for r in reasons[:-1]):
                    continue
                cells = [f"{row[r]:.1e}" if isinstance(row[r], float) else str(row[r]) for r in reasons]
                yield f"| {result['mesh']} | {row['kind']} | {row['peer']} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="*", default=MESHES)
    parser.add_argument("--folder", default=os.path.join(ROOT, "target", "rays"))
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--isa", default="avx2", help="what Embree may use")
    parser.add_argument("--library", action="append", help="an Embree library, instead of those found")
    parser.add_argument("--json")
    parser.add_argument("--tables", help="measure nothing, print the tables of such a JSON file")
    parser.add_argument("--markdown")
    arguments = parser.parse_args()
    if arguments.tables:
        with open(arguments.tables) as file:
            print("\n".join(markdown(json.load(file))))
        return
    libraries = arguments.library or embree_libraries()
    if libraries:
        source, program = os.path.join(HERE, "rays", "embree.cpp"), os.path.join(ROOT, "target", "rays-embree")
        subprocess.run(["g++", "-O3", "-march=native", "-o", program, source, "-ldl"], check=True)
    if not all(os.path.exists(os.path.join(arguments.folder, f"{m}.mesh")) for m in arguments.meshes):
        subprocess.run([ETALON, "record", arguments.folder, *arguments.meshes], check=True)
    results = [measure(mesh, arguments.folder, libraries, arguments.rounds, arguments.isa) for mesh in arguments.meshes]
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(results, file, indent=1)
    table = "\n".join(markdown(results)) + "\n"
    if arguments.markdown:
        with open(arguments.markdown, "w") as file:
            file.write(table)
    print(table)


if __name__ == "__main__":
    main()
