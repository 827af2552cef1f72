#!/usr/bin/env python3
"""Etalon on the test scenes of Mitsuba 3, against the references that Mitsuba's authors made.

    python3 validation/peers/mitsuba_suite.py FOLDER [--budget SAMPLES] [--margin 1%] [NAME]...

FOLDER is `tests/scenes` of https://github.com/mitsuba-renderer/mitsuba-data. A scene SCENE_INTEGRATOR.xml has
references refs/SCENE_ref_MODE.exr, a mean over 32 000 samples a pixel, and refs/SCENE_ref_MODE_var.exr, the
variance of a single sample (Mitsuba's src/render/tests/test_renders.py, which makes both and compares renders
of two million samples a picture with them). Here `validate images` compares, with the variances of both
sides. Writes a Markdown table to standard output: a scene with what Etalon does not have is named with the
error. Exit code 1 if a picture differs.
"""
import argparse
import collections
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import mitsuba_reference

PROGRAMS = Path(__file__).resolve().parents[2] / "target" / "release"
REFERENCE_SAMPLES = 32000
INTEGRATORS = re.compile(r"_(path|direct|depth|ptracer|volpath|volpathmis|stokes)$")


XYZ_OF_RGB = np.array([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]])


def variance_of_rgb(stored):
    """The variances of R, G and B.

    The stored values are the variances of X, Y and Z, converted as if they were a colour (so they may be
    negative). The correlations of X, Y and Z are unknown; they are assumed to be 0, which overestimates the
    variances where light is white.
    """
    xyz = np.maximum(stored @ XYZ_OF_RGB.T, 0)
    return xyz @ (np.linalg.inv(XYZ_OF_RGB) ** 2).T


def reference(mi, scene, mode, folder):
    """The scene's reference with its variances in one file, and its number of pixels; None without one."""
    mean = scene.parent / "refs" / f"{INTEGRATORS.sub('', scene.stem)}_ref_{mode}.exr"
    variance = mean.with_name(mean.stem + "_var.exr")
    if not mean.exists() or not variance.exists():
        return None
    mean, variance = (np.array(mi.Bitmap(str(path)), dtype=np.float64)[..., :3] for path in (mean, variance))
    path = Path(folder) / "reference.exr"
    mitsuba_reference.write(mi, path, mean, variance_of_rgb(variance) / REFERENCE_SAMPLES, ["R", "G", "B"], {})
    return path, mean.shape[0] * mean.shape[1]


def without_moments(mi, picture):
    """Removes all channels but colours and variances: the integrator `moment`, which most scenes have, adds
    channels that no reference has.
    """
    bitmap = mi.Bitmap(str(picture))
    values = dict(zip((field.name for field in bitmap.struct_()), np.moveaxis(np.array(bitmap), 2, 0)))
    mean, variance = (np.stack([values[prefix + c] for c in "RGB"], axis=2) for prefix in ("", "variance."))
    mitsuba_reference.write(mi, picture, mean, variance, ["R", "G", "B"], {})


def judge(mi, scene, mode, arguments):
    """A verdict, and details or the reason."""
    with tempfile.TemporaryDirectory() as folder:
        found = reference(mi, scene, mode, folder)
        if found is None:
            return "no reference", ""
        expected, pixels = found
        picture, answer = Path(folder) / "etalon.exr", Path(folder) / "answer.json"
        spp = max(arguments.budget // pixels, 2)
        command = [PROGRAMS / "etalon", "render", scene, "-o", picture, "--spp", str(spp), "--color", mode, "--quiet"]
        render = subprocess.run(command, capture_output=True, text=True)
        if render.returncode:
            return "not read", render.stderr.split("\n")[0].removeprefix("error: ")
        without_moments(mi, picture)
        command = [PROGRAMS / "validate", "images", expected, picture, "--margin", arguments.margin, "--json", answer]
        compared = subprocess.run(command, capture_output=True, text=True)
        if not answer.exists():
            return "not compared", compared.stderr.strip()
        return described(json.loads(answer.read_text()))


def described(answer):
    if answer["faults"]["not_finite"]:
        return answer["verdict"], answer["message"].split(";")[0]
    means = [channel["mean"] for channel in answer["channels"] if channel["name"] in "RGB"]
    low, high = (pick(mean["interval"][end] for mean in means) for pick, end in ((min, "low"), (max, "high")))
    return answer["verdict"], f"means {100 * low:.2f} to {100 * high:.2f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*", metavar="NAME", help="only scenes whose path contains one of these")
    parser.add_argument("--budget", type=int, default=2_000_000, help="samples a picture")
    parser.add_argument("--margin", default="1%", help="largest relative difference of a channel's mean that is none")
    arguments = parser.parse_args()
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    print("| scene | rgb | spectral |\n|---|---|---|")
    counts = collections.Counter()
    for scene in sorted(arguments.folder.glob("*/*.xml")):
        name = str(scene.relative_to(arguments.folder))
        if arguments.names and not any(wanted in name for wanted in arguments.names):
            continue
        answers = [judge(mi, scene, mode, arguments) for mode in ("rgb", "spectral")]
        counts.update(verdict for verdict, _ in answers)
        print(f"| {name} | " + " | ".join(": ".join(filter(None, answer)) for answer in answers) + " |", flush=True)
    print("\n" + ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    sys.exit(1 if counts["different"] else 0)


if __name__ == "__main__":
    main()
