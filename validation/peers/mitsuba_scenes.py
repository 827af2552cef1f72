#!/usr/bin/env python3
"""Renders scenes with Mitsuba 3 on request.

A line of standard input is {"scene", "out", "name", "mode", "spp", "replicates"}; the EXR of means and their
variances, estimated as in mitsuba_reference.py, is written to `out`. The reply is a line {"channels", "mean",
"standard_error"} or {"error"}.
"""
import json
import sys
from pathlib import Path

import numpy as np

import mitsuba_reference


def answer(mi, job):
    mi.set_variant(f"scalar_{job['mode']}")
    # Merging meshes does not change the picture, but fails for equal materials with flipped normals.
    scene = mi.load_file(job["scene"], optimize=False)
    sums, weights, channels = mitsuba_reference.render(mi, scene, job["name"], job["mode"], job["spp"], job["replicates"])
    if not np.isfinite(sums).all():
        return {"error": "a pixel is not finite"}
    mean, variance, image_mean, error = mitsuba_reference.estimate(sums, weights)
    mitsuba_reference.write(mi, Path(job["out"]), mean, variance, channels, {})
    return {"channels": channels, "mean": image_mean.tolist(), "standard_error": error.tolist()}


def main():
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    for line in sys.stdin:
        try:
            reply = answer(mi, json.loads(line))
        except Exception as reason:
            reply = {"error": str(reason).strip()[-600:] or repr(reason)}
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
