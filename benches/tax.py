"""The cost of a feature for a scene that does not use it, in instructions.

    python3 benches/tax.py [FEATURE …] [--json F] [--csv] [--all-kernels] [--check] [--compile]

Needs valgrind, and the Python package OpenEXR. Each `benches/tax/*.json` removes a feature from a copy of the
sources (in `target/tax`), by edits whose `find` occurs exactly `count` times (once by default). Both
programs, with and without it, render the same paths of two scenes under callgrind; the images must be
bit-identical. The instructions of a render of few samples are subtracted, so that reading, building and
writing do not count. A tax of 1 % means that the program with the feature takes 1 % more instructions per
sample.

`--check` only tests whether the edits still apply; `--csv` writes the table that `etalon explain` shows,
`src/cli/tax.csv`, and needs all features.
"""

import argparse
import glob
import hashlib
import json
import os
import re
import shutil
import subprocess

import growth

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
FOLDER = os.path.join(ROOT, "target", "tax")
CSV = os.path.join(ROOT, "src", "cli", "tax.csv")
FEW, MANY = 16, 48
ALONE = ["--threads", "1", "--light-paths", "0", "--links", "never", "--reuse", "1"]
BAR = 1.0


def removals():
    found = []
    for path in sorted(glob.glob(os.path.join(HERE, "tax", "*.json"))):
        with open(path) as file:
            found.append(json.load(file))
    return found


def with_one_kernel(files):
    """The files with only the smallest kernel, which compile several times faster."""
    name = "src/integrator/mod.rs"
    text, count = re.subn(rb"\nkernels! \{\n.*?\n\}\n", b'\nkernels! {\n    "plain": 0,\n}\n', files[name], flags=re.DOTALL)
    assert count == 1
    return {**files, name: text}


def sources():
    """The files that cargo needs, read once, so that all programs are built from the same sources."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    files = {}
    for name in listed:
        path = os.path.join(ROOT, name)
        if re.match(r"Cargo|build\.rs$|src/|benches/.*rs$|examples/|validation/.*(toml|rs)$", name) and os.path.isfile(path):
            with open(path, "rb") as file:
                files[name] = file.read()
    return files


def removed(removal, files):
    """The files that a removal changes, with their new content. What is removed `with` it goes first: code
    that cannot be without the feature, and that no scene of the table runs.
    """
    others = [other for other in removals() if other["feature"] in removal.get("with", [])]
    changed = {}
    for edit in [edit for part in [*others, removal] for edit in part["edits"]]:
        name, expected = edit["file"], edit.get("count", 1)
        text = changed.get(name, files.get(name, b""))
        count = text.count(edit["find"].encode())
        if count != expected:
            raise SystemExit(f"{removal['feature']}: `{edit['find']}` occurs {count} times in {name}, not {expected}")
        changed[name] = text.replace(edit["find"].encode(), edit["replace"].encode())
    return changed


def write_if_new(path, data):
    """Writes a file unless it has this content already, so that cargo compiles only what differs."""
    if os.path.exists(path):
        with open(path, "rb") as file:
            if file.read() == data:
                return
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data)


def cargo(what, files, removal, whole=False):
    """Builds or checks the sources without a feature. Checks have a separate folder, so that both can run at
    the same time.
    """
    tree = os.path.join(FOLDER, what, "tree")
    files = {**files, **(removed(removal, files) if removal else {})}
    files = files if whole else with_one_kernel(files)
    for name, data in files.items():
        write_if_new(os.path.join(tree, name), data)
    for path in glob.glob(os.path.join(tree, "**", "*.*"), recursive=True):
        if os.path.relpath(path, tree) not in files:
            os.remove(path)
    environment = {**os.environ, "CARGO_TARGET_DIR": os.path.join(FOLDER, what)}
    told = subprocess.run(["cargo", what, "--release", "--quiet", "--bin", "etalon"], cwd=tree, env=environment, capture_output=True, text=True)
    if told.returncode:
        raise SystemExit("\n".join(block for block in told.stderr.split("\n\n") if block.startswith("error")))


def build(files, removal, whole=False):
    """The program without a feature."""
    cargo("build", files, removal, whole)
    program = os.path.join(FOLDER, "-".join(["etalon", *(["whole"] if whole else []), *(removal["feature"].split() if removal else [])]))
    shutil.copy(os.path.join(FOLDER, "build", "release", "etalon"), program)
    return program


def scenes():
    """Names of scenes, with the arguments to render each."""
    hills = growth.scene_file(FOLDER, {**growth.USUAL, "width": 64})
    box = os.path.join(ROOT, "scenes", "cornell-spheres.xml")
    return {"cornell-spheres": [box, "--size", "64x48"], "hills": [hills]}


def image(program, scene):
    """The colour channels that a program renders, its kernel, and its number of rays."""
    import OpenEXR

    path = os.path.join(FOLDER, "o.exr")
    command = [program, "render", *scene, *ALONE, "--spp", str(FEW), "--json", "-o", path]
    document = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = file.channels()
        return [channels[name].pixels.tobytes() for name in "RGB"], document["kernel"], document["rays"]


def instructions(program, scene, samples):
    out = os.path.join(FOLDER, "callgrind.out")
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", program, "render", *scene, *ALONE,
               "--spp", str(samples), "--quiet", "-o", os.path.join(FOLDER, "o.exr")]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    return int(re.search(r"Collected : (\d+)", told).group(1))


def measure(program, scene):
    found, kernel, rays = image(program, scene)
    few, many = (instructions(program, scene, samples) for samples in (FEW, MANY))
    return {"image": found, "kernel": kernel, "rays": rays, "start_up": few - (many - few) * FEW / (MANY - FEW), "rendering": many - few}


def table(results, names):
    lines = [f"| without | {' | '.join(names)} |", f"|---|{'--:|' * len(names)}"]
    for feature, taxes in results.items():
        lines.append(f"| {feature} | {' | '.join(f'{taxes[name]:+.2f} %' for name in names)} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("features", nargs="*", metavar="FEATURE")
    parser.add_argument("--json", help="keeps results; those of the same sources are added to")
    parser.add_argument("--csv", action="store_true", help="write src/cli/tax.csv")
    parser.add_argument("--all-kernels", action="store_true", help="leave the other kernels in the programs; compiles for minutes")
    parser.add_argument("--check", action="store_true", help="only see whether the edits still apply")
    parser.add_argument("--compile", action="store_true", help="only see whether what is left compiles")
    arguments = parser.parse_args()
    files = sources()
    known = {removal["feature"]: removal for removal in removals()}
    if unknown := [feature for feature in arguments.features if feature not in known]:
        parser.error(f"no feature {unknown[0]!r}, expected of {', '.join(known)}")
    chosen = [known[feature] for feature in arguments.features or known]
    if arguments.check:
        for removal in chosen:
            removed(removal, files)
        return
    os.makedirs(FOLDER, exist_ok=True)
    if arguments.compile:
        for removal in chosen:
            print(removal["feature"], flush=True)
            cargo("check", files, removal)
        return
    rendered = scenes()
    whole = build(files, None, arguments.all_kernels)
    before = {name: measure(whole, scene) for name, scene in rendered.items()}
    for name, measured in before.items():
        per_ray = measured["rendering"] / measured["rays"] * FEW / (MANY - FEW)
        print(f"{name}: kernel {measured['kernel']}, {measured['rendering']:,} instructions, {per_ray:.0f} a ray", flush=True)
    renderer = [data for name, data in sorted(files.items()) if name.startswith("src/") and not name.startswith("src/cli/")]
    renderer.append(str(arguments.all_kernels).encode())
    digest = hashlib.sha256(b"".join(renderer)).hexdigest()
    results = {}
    if arguments.json and os.path.exists(arguments.json):
        with open(arguments.json) as file:
            earlier = json.load(file)
        results = earlier["percent"] if earlier["sources"] == digest else {}
    for removal in chosen:
        feature = removal["feature"]
        program = build(files, removal, arguments.all_kernels)
        results[feature] = {}
        for name, scene in rendered.items():
            after = measure(program, scene)
            if (after["image"], after["rays"]) != (before[name]["image"], before[name]["rays"]):
                raise SystemExit(f"{name} without {feature} is another image")
            results[feature][name] = 100 * (before[name]["rendering"] / after["rendering"] - 1)
        over = [name for name, tax in results[feature].items() if tax > BAR]
        print(feature, *(f"{name} {tax:+.3f} %" for name, tax in results[feature].items()), "above the bar" if over else "", flush=True)
        if arguments.json:
            kept = {name: {key: value for key, value in m.items() if key != "image"} for name, m in before.items()}
            with open(arguments.json, "w") as file:
                json.dump({"sources": digest, "whole": kept, "percent": results}, file, indent=1)
    results = {feature: results[feature] for feature in known if feature in results}
    print(table(results, list(rendered)))
    if arguments.csv and len(results) == len(known):
        with open(CSV, "w") as file:
            file.write(f"feature,{','.join(rendered)}\n")
            for feature, taxes in results.items():
                file.write(f"{feature},{','.join(f'{tax:.2f}' for tax in taxes.values())}\n")


if __name__ == "__main__":
    main()
