"""Paths per second of Etalon and Mitsuba 3 side by side: A B A B on each scene, median of pairs.

    python3 benches/peers.py [SCENE.xml]... [--spp N] [--pairs K] [--size WxH]

Needs `pip install mitsuba` and, for the llvm variants, a libLLVM; a variant that cannot run is reported as
missing. Those compile for the processor at hand, so the width of its registers decides much: where it has
AVX-512 they are measured once more compiled for AVX2, which is what Etalon is built for. Start-up and scene
loading are left out on both sides. Writes a Markdown table to standard output. Without scenes: mirror and
glass, a textured interior, glass, rough metals, and, once `cargo run --release --example convergence_scenes`
has made them, two million triangles.
"""

import argparse
import ctypes
import glob
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ETALON = os.path.join(HERE, "..", "target", "release", "etalon")


def etalon(scene, spp, color, size):
    with tempfile.TemporaryDirectory() as folder:
        command = [ETALON, "render", scene, "-o", os.path.join(folder, "o.exr"), "--spp", str(spp), "--json"]
        # Both do the same work: Mitsuba's path tracer has no light paths.
        command += ["--light-paths", "0", "--links", "never"]
        command += ["--color", color, "--size", f"{size[0]}x{size[1]}"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["seconds"]


class Target:
    """The processor that Dr.Jit compiles for, by its C++ interface; its Python interface does not offer
    it."""

    AVX2 = (b"x86-64-v3", None, 8)

    def __init__(self):
        import drjit

        self.library = ctypes.CDLL(glob.glob(os.path.join(os.path.dirname(drjit.__file__), "libdrjit-core.*"))[0])
        self.native = (self.text("_Z19jit_llvm_target_cpuv"), self.text("_Z24jit_llvm_target_featuresv"), self.width())

    def text(self, name):
        function = self.library[name]
        function.restype = ctypes.c_char_p
        return function()

    def width(self):
        return self.library["_Z21jit_llvm_vector_widthv"]()

    def set(self, target):
        function = self.library["_Z19jit_llvm_set_targetPKcS0_j"]
        function.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint32]
        function(*target)
        if self.width() != target[2]:
            raise RuntimeError(f"Dr.Jit does not compile for {target[2]} lanes")


class Mitsuba:
    """A variant of Mitsuba; the scene is loaded and rendered once before anything is timed."""

    def __init__(self, variant, avx2, scene, spp, size):
        import mitsuba

        self.mitsuba, self.variant, self.spp, self.seed = mitsuba, variant, spp, 0
        mitsuba.set_variant(variant)
        if variant.startswith("llvm"):
            target = Mitsuba.target = getattr(Mitsuba, "target", None) or Target()
            if avx2 and target.native[2] <= Target.AVX2[2]:
                raise RuntimeError("the processor has nothing wider")
            target.set(Target.AVX2 if avx2 else target.native)
        self.scene = mitsuba.load_file(scene, width=size[0], height=size[1])
        self.render()

    def render(self):
        import drjit

        self.mitsuba.set_variant(self.variant)
        self.seed += 1
        start = time.perf_counter()
        image = self.mitsuba.render(self.scene, spp=self.spp, seed=self.seed)
        drjit.eval(image)
        drjit.sync_thread()
        image.numpy()
        return time.perf_counter() - start


# The variants, and whether they are compiled for AVX2.
VARIANTS = [
    ("scalar_spectral", False),
    ("llvm_ad_spectral", False),
    ("llvm_ad_spectral", True),
    ("scalar_rgb", False),
    ("llvm_ad_rgb", False),
    ("llvm_ad_rgb", True),
]
SCENES = ["cornell-spheres", "convergence/interior", "convergence/inside-glass", "cornell-glossy", "convergence/sunny-urchins"]


def measure(scene, variant, avx2, spp, size, pairs):
    """Million paths per second of both, and the median of their ratios; or what is missing."""
    color = "spectral" if variant.endswith("spectral") else "rgb"
    try:
        peer = Mitsuba(variant, avx2, scene, spp, size)
    except Exception as error:
        return str(error).splitlines()[0]
    seconds = [(peer.render(), etalon(scene, spp, color, size)) for _ in range(pairs)]
    theirs, ours = (statistics.median(column) for column in zip(*seconds))
    samples = size[0] * size[1] * spp / 1e6
    return samples / theirs, samples / ours, statistics.median(a / b for a, b in seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=[os.path.join(HERE, "..", "scenes", f"{name}.xml") for name in SCENES])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--size", default="480x360")
    arguments = parser.parse_args()
    size = tuple(map(int, arguments.size.split("x")))
    print(f"{arguments.size}, {arguments.spp} spp, {arguments.pairs} pairs\n")
    print("| scene | Mitsuba | million paths/s | Etalon, same colour mode | ratio |\n|---|---|--:|--:|--:|")
    for scene in arguments.scenes:
        name = os.path.splitext(os.path.basename(scene))[0]
        for variant, avx2 in VARIANTS:
            found = measure(scene, variant, avx2, arguments.spp, size, arguments.pairs)
            variant += ", AVX2" if avx2 else ""
            if isinstance(found, str):
                print(f"| {name} | {variant} | missing: {found} | | |")
            else:
                print(f"| {name} | {variant} | {found[0]:.2f} | {found[1]:.2f} | {found[2]:.2f} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
