"""Makes validation/references/golden/bsdf.json: Mitsuba 3's values for every example of Etalon's materials.

    cargo build --release && python3 validation/peers/golden_bsdf.py

For each `<bsdf>` example of `etalon plugins --json` that Mitsuba reads: value (cosine included) at four
wavelengths and density, on a fixed grid of directions. Directions are exact in single precision, so that both
programs have the same input. An example that Mitsuba does not read is listed with the reason.
"""
import argparse
import json
import math
import subprocess
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "validation/references/golden/bsdf.json"
WAVELENGTHS = [430.0, 510.0, 570.0, 650.0]


def direction(cosine, phi):
    sine = math.sqrt(1 - cosine * cosine)
    return [float(np.float32(c)) for c in (sine * math.cos(phi), sine * math.sin(phi), cosine)]


def grid():
    """Pairs (wo, wi): five angles of wo, with wi in all directions, and near the mirror direction."""
    pairs = []
    for degrees in (0, 35, 75, 89, 150):
        cosine = math.cos(math.radians(degrees))
        wo = direction(cosine, 0.7)
        around = [direction(c, phi) for c in (0.98, 0.8, 0.45, 0.1, -0.3, -0.9) for phi in (0.3, 2.1, 0.7 + math.pi, 5.2)]
        pairs += [(wo, wi) for wi in around + [direction(0.99 * cosine + 0.004, 0.75 + math.pi)]]
    return pairs


def interaction(wo):
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.t, si.wi, si.wavelengths = 1, mi.Vector3f(wo), mi.Spectrum(WAVELENGTHS)
    si.n, si.uv = mi.Normal3f(0, 0, 1), mi.Point2f(0.25, 0.25)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Normal3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


def digits(number):
    """The number of the shortest text that denotes the same single-precision number."""
    return float(str(np.float32(number)))


def evaluate(snippet, pairs):
    bsdf = mi.load_string(snippet.replace("<bsdf ", '<bsdf version="3.0.0" ', 1))
    values, densities = [], []
    for wo, wi in pairs:
        value, pdf = bsdf.eval_pdf(mi.BSDFContext(), interaction(wo), mi.Vector3f(wi))
        values.append([digits(v) for v in value])
        densities.append(digits(pdf))
    return {"value": values, "pdf": densities}


def main():
    mi.set_variant("scalar_spectral")
    etalon = ROOT / "target/release/etalon"
    models = json.loads(subprocess.run([etalon, "plugins", "--json"], check=True, capture_output=True).stdout)
    pairs, examples = grid(), []
    for model in models:
        for index, snippet in enumerate(model["examples"] if model["kind"] == "bsdf" else []):
            example = {"name": f"{model['name']}[{index}]", "snippet": snippet}
            try:
                if '<rgb name="normalmap"' in snippet:
                    raise ValueError("in spectral variants Mitsuba makes a spectrum of a constant colour, not a normal")
                example |= evaluate(snippet, pairs)
            except Exception as reason:
                example["missing"] = str(reason).strip().splitlines()[-1].strip()
            print(example["name"], example.get("missing", "made"), flush=True)
            examples.append(example)
    golden = {"mitsuba": mi.__version__, "variant": mi.variant(), "wavelengths": WAVELENGTHS,
              "wo": [wo for wo, _ in pairs], "wi": [wi for _, wi in pairs]}
    lines = ",\n".join(json.dumps(example) for example in examples)
    head = json.dumps(golden)[:-1]
    GOLDEN.parent.mkdir(exist_ok=True)
    GOLDEN.write_text(f'{head}, "examples": [\n{lines}\n]}}\n')


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    main()
