#!/usr/bin/env python3
"""The cost of --checkpoint: user time of renders with and without it, in interleaved pairs.

    python3 benches/checkpoint.py [--pairs N] [--spp N] [--size WxH] [SCENE]

Prints the ratio of each pair, and their median with its 95 % interval from order statistics (Conover 1999,
section 3.2). The last line is JSON.
"""
import argparse
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ETALON = ROOT / "target/release/etalon"


def user_time(command):
    before = os.times().children_user
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    return os.times().children_user - before


def interval(count):
    """Index of the order statistic that is below the median with probability 97.5 % at least."""
    below, k = 0.0, 0
    while below + math.comb(count, k) / 2**count <= 0.025:
        below += math.comb(count, k) / 2**count
        k += 1
    return max(k - 1, 0)


def main():
    parser = argparse.ArgumentParser(description="What --checkpoint costs.")
    parser.add_argument("scene", nargs="?", default=ROOT / "scenes/cornell-spheres.xml")
    parser.add_argument("--pairs", type=int, default=9)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="480x360")
    arguments = parser.parse_args()
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        base = [ETALON, "render", arguments.scene, "--quiet", "--threads", "1", "--spp", str(arguments.spp),
                "--size", arguments.size, "-o", f"{folder}/out.exr"]
        kept = base + ["--checkpoint", f"{folder}/checkpoint"]
        for pair in range(arguments.pairs):
            # The order alternates, so that drifts affect both alike.
            order = [kept, base] if pair % 2 else [base, kept]
            times = {len(command): user_time(command) for command in order}
            ratios.append(times[len(kept)] / times[len(base)])
            print(f"{times[len(base)]:.2f} s without, {times[len(kept)]:.2f} s with: {ratios[-1]:.4f}", flush=True)
    ratios.sort()
    k = interval(len(ratios))
    print(json.dumps({"median": ratios[len(ratios) // 2], "low": ratios[k], "high": ratios[-1 - k], "pairs": len(ratios)}))


if __name__ == "__main__":
    main()
