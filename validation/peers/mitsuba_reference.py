#!/usr/bin/env python3
"""Makes the reference images of validation/references with Mitsuba 3.

    python3 validation/peers/mitsuba_reference.py                 all scenes, both colour modes
    python3 validation/peers/mitsuba_reference.py conductor aov   these scenes
    python3 validation/peers/mitsuba_reference.py --coverage      features by scene; fails if one is missing
    python3 validation/peers/mitsuba_reference.py --stale         references whose inputs have changed

A scene NAME.xml gives NAME.rgb.exr and NAME.spectral.exr. Their channels are the film's, in linear sRGB, and
for each channel X the variance of the pixel's mean as variance.X. references.json records how each was made.

The scene's own reconstruction filter is kept, because filters are under test. A sample then counts in several
pixels, so the variance is estimated from independent replicates instead of from samples. Replicate r gives in
each pixel the filtered sum A_r and the sum of filter weights W_r. The pixel is the ratio m = sum A_r / sum
W_r of all of them, whose bias decreases with the number of all samples, not with that of a single replicate;
this matters for filters with negative lobes. Its variance is that of the linearised ratio (Cochran, Sampling
Techniques, 3rd ed. 1977, section 2.11):

    e_r = (A_r - m W_r) / mean(W),        variance = sum e_r^2 / (R (R - 1)).

The standard error of the image's mean follows from the replicates' means of e_r, which include the
correlation between neighbouring pixels; the sum of the pixels' variances would not.
"""
import argparse
import hashlib
import json
import sys
import time
from pathlib import Path

import numpy as np

import scene_features

REFERENCES = Path(__file__).resolve().parents[1] / "references"
SCENES = REFERENCES / "scenes"
RECORD = REFERENCES / "references.json"


def select_variant(mi, mode):
    """Selects the compiled variant, which is fast and evaluates filters exactly, or else the scalar one,
    which tabulates them in 31 steps.
    """
    for variant in (f"llvm_ad_{mode}", f"scalar_{mode}"):
        try:
            mi.set_variant(variant)
            mi.Float(1) + 1  # loads LLVM, or fails to
            return variant
        except Exception as reason:
            print(f"{variant} is not available: {reason}", file=sys.stderr)
    sys.exit(2)


def seeds(name, mode, count):
    """Consecutive seeds from a hash of the reference's name, so that no two references share their noise."""
    first = int.from_bytes(hashlib.sha256(f"{name}.{mode}".encode()).digest()[:3], "big")
    return range(first, first + count)


def render(mi, scene, name, mode, spp, count):
    """Sums of samples and of weights of the replicates, and the names of the channels.

    The arrays have the shapes (count, height, width, channels) and (count, height, width, 1).
    """
    integrator, sensor = scene.integrator(), scene.sensors()[0]
    assert "IndependentSampler" in str(sensor.sampler()), "the replicates must be independent"
    sums, weights = [], []
    for k, seed in enumerate(seeds(name, mode, count)):
        integrator.render(scene, sensor, seed=seed, spp=spp, develop=False)
        raw = np.array(sensor.film().develop(raw=True), dtype=np.float64)
        if k == 0:
            channels = [field.name for field in sensor.film().bitmap(raw=True).struct_()]
            w = channels.index("W")  # the sum of the filter weights
            developed = np.array(sensor.film().develop(), dtype=np.float64)
            divided = np.delete(raw / raw[..., w:w + 1], w, axis=2)
            assert np.allclose(divided, developed, rtol=1e-4, atol=1e-6), "the film does more than divide by the weights"
            # An aov integrator repeats the nested integrator's channels R, G, B under its name.
            keep = [i for i, c in enumerate(channels) if i != w and not c.startswith("image.")]
        sums.append(raw[..., keep])
        weights.append(raw[..., w:w + 1])
    return np.stack(sums), np.stack(weights), [channels[i] for i in keep]


def estimate(sums, weights):
    """Pixel means, the variance of each, the image's mean and its standard error, by the ratio estimator
    above.
    """
    count = len(sums)
    mean = sums.sum(0) / weights.sum(0)
    residuals = (sums - mean * weights) / weights.mean(0)
    scale = 1 / (count * (count - 1))
    variance = (residuals**2).sum(0) * scale
    error = np.sqrt((residuals.mean((1, 2)) ** 2).sum(0) * scale)
    return mean, variance, mean.mean((0, 1)), error


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def input_hashes(path):
    return {str(file.relative_to(REFERENCES)): sha256(file) for file in scene_features.inputs(path)}


def write(mi, path, mean, variance, channels, header):
    names = channels + [f"variance.{c}" for c in channels]
    pixels = np.ascontiguousarray(np.concatenate([mean, variance], axis=2), dtype=np.float32)
    bitmap = mi.Bitmap(pixels, mi.Bitmap.PixelFormat.MultiChannel, names)
    for key, value in header.items():
        bitmap.metadata()[key] = value
    bitmap.write(str(path))


def make(mi, path, mode, spp, count, record):
    name = f"{path.stem}.{mode}"
    variant = select_variant(mi, mode)
    start = time.time()
    scene = mi.load_file(str(path))
    sums, weights, channels = render(mi, scene, path.stem, mode, spp, count)
    if not (np.isfinite(sums).all() and (weights.sum(0) > 0).all()):
        sys.exit(f"{name}: a pixel is not finite or has no samples")
    mean, variance, image_mean, error = estimate(sums, weights)
    made = {"mitsuba": mi.__version__, "variant": variant, "spp": spp * count, "replicates": count,
            "first_seed": seeds(path.stem, mode, count)[0], "scene_sha256": sha256(path)}
    write(mi, REFERENCES / f"{name}.exr", mean, variance, channels, {k: str(v) for k, v in made.items()})
    record[name] = made | {"inputs": input_hashes(path), "channels": channels,
                           "mean": [float(f"{x:.7g}") for x in image_mean],
                           "standard_error": [float(f"{x:.3g}") for x in error]}
    relative = error / np.maximum(np.abs(image_mean), 1e-30)
    print(f"{name:28} " + " ".join(f"{c}={m:.5g}±{100 * r:.3f}%" for c, m, r in zip(channels, image_mean, relative))
          + f"  {time.time() - start:.1f} s", flush=True)


def stale(record):
    """References that are missing, or whose scene, or a file that it reads, has changed since."""
    found = [name for name, made in sorted(record.items())
             if not (SCENES / f"{name.rsplit('.', 1)[0]}.xml").exists()
             or made["inputs"] != input_hashes(SCENES / f"{name.rsplit('.', 1)[0]}.xml")]
    expected = [f"{scene.stem}.{mode}" for scene in SCENES.glob("*.xml") for mode in scene_features.modes(scene)]
    return found + sorted(name for name in expected if name not in record or not (REFERENCES / f"{name}.exr").exists())


def main():
    parser = argparse.ArgumentParser(description="Makes reference images with Mitsuba 3.")
    parser.add_argument("names", nargs="*", help="scenes, without .xml; all if none is given")
    parser.add_argument("--modes", nargs="+", choices=["rgb", "spectral"], default=["rgb", "spectral"])
    parser.add_argument("--replicates", type=int, default=64, help="independent renders of each scene")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel of each of them")
    parser.add_argument("--coverage", action="store_true", help="print what the scenes cover, and stop")
    parser.add_argument("--stale", action="store_true", help="print the references to be made anew, and stop")
    arguments = parser.parse_args()

    scenes = sorted(SCENES.glob("*.xml"))
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    if arguments.coverage:
        sys.exit(1 if scene_features.print_coverage(scenes) else 0)
    if arguments.stale:
        names = stale(record)
        print("\n".join(names) or "every reference is up to date")
        sys.exit(1 if names else 0)
    unknown = set(arguments.names) - {scene.stem for scene in scenes}
    if unknown:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}")

    import mitsuba as mi
    for scene in scenes:
        if arguments.names and scene.stem not in arguments.names:
            continue
        for mode in scene_features.modes(scene):
            if mode in arguments.modes:
                make(mi, scene, mode, arguments.spp, arguments.replicates, record)
                RECORD.write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
