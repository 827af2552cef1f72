"""Mitsuba 3's own BSDFs as a peer: validate bsdf --peer "python3 validation/peers/mitsuba_bsdf.py"

    python3 validation/peers/mitsuba_bsdf.py [VARIANT]

VARIANT is a compiled spectral one (llvm_ad_spectral by default). Mitsuba's Python packages compute in single
precision, to which received directions and random numbers are rounded. See docs/peer-protocol.md and
docs/mitsuba-bsdfs.md.
"""
import json
import sys

import drjit as dr
import mitsuba as mi
import numpy as np

WAVELENGTH = 550.0
BELOW_ONE = np.float32(1 - 2.0**-24)
RECIPROCAL = {"reciprocal": True}

REDDISH = {"type": "rgb", "value": [0.9, 0.5, 0.2]}


def glass(eta=1.5, **more):
    """Claims and parameters of an interface from air to a medium of index eta."""
    return {"reciprocal": True, "eta": eta}, {"int_ior": eta, "ext_ior": 1.0, **more}


def image(rows):
    """A texture with these numbers as raw values."""
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.array(rows, dtype=np.float32)), "raw": True}


def configurations():
    """Name, claims and Mitsuba's dictionary of each configuration."""
    def add(name, type_, claims, **parameters):
        found.append((name, claims, {"type": type_, **parameters}))

    found = []
    add("diffuse", "diffuse", RECIPROCAL, reflectance=REDDISH)
    add("conductor", "conductor", RECIPROCAL, material="Au")
    for distribution in ("beckmann", "ggx"):
        for alpha in (0.05, 0.3, 1.0):
            add(f"roughconductor {distribution} {alpha}", "roughconductor", RECIPROCAL, material="Au",
                distribution=distribution, alpha=alpha)
    add("roughconductor ggx 0.1 0.4", "roughconductor", RECIPROCAL, distribution="ggx", alpha_u=0.1, alpha_v=0.4)
    add("roughconductor ggx 0.3 all normals", "roughconductor", RECIPROCAL, distribution="ggx", alpha=0.3,
        sample_visible=False)
    claims, parameters = glass()
    add("dielectric", "dielectric", claims | {"lossless": True}, **parameters)
    add("thindielectric", "thindielectric", {"reciprocal": True, "lossless": True}, **parameters)
    for distribution in ("beckmann", "ggx"):
        for alpha in (0.05, 0.3, 1.0):
            add(f"roughdielectric {distribution} {alpha}", "roughdielectric", claims, distribution=distribution,
                alpha=alpha, **parameters)
    add("roughdielectric ggx 0.2 0.5", "roughdielectric", claims, distribution="ggx", alpha_u=0.2, alpha_v=0.5,
        **parameters)
    add("roughdielectric ggx 0.3 all normals", "roughdielectric", claims, distribution="ggx", alpha=0.3,
        sample_visible=False, **parameters)
    add("plastic", "plastic", RECIPROCAL, diffuse_reflectance=REDDISH, int_ior=1.5, ext_ior=1.0)
    add("plastic nonlinear", "plastic", RECIPROCAL, diffuse_reflectance=REDDISH, nonlinear=True)
    for alpha in (0.05, 0.3):
        add(f"roughplastic ggx {alpha}", "roughplastic", RECIPROCAL, distribution="ggx", alpha=alpha,
            diffuse_reflectance=REDDISH)
    add("roughplastic beckmann nonlinear", "roughplastic", RECIPROCAL, alpha=0.2, nonlinear=True,
        diffuse_reflectance=REDDISH)
    # Artistic models: nothing is documented but that sampling and evaluation are consistent.
    add("principled", "principled", {}, base_color=REDDISH, roughness=0.4)
    add("principled metallic anisotropic", "principled", {}, base_color=REDDISH, roughness=0.4, metallic=0.7,
        anisotropic=0.8)
    add("principled clearcoat sheen", "principled", {}, base_color=REDDISH, roughness=0.5, clearcoat=0.8,
        clearcoat_gloss=0.6, sheen=0.7, flatness=0.3)
    add("principled transmission", "principled", {"eta": 1.5}, base_color=REDDISH, roughness=0.4, spec_trans=0.8,
        eta=1.5)
    add("principledthin", "principledthin", {}, base_color=REDDISH, roughness=0.4, diff_trans=0.6)
    add("principledthin transmission", "principledthin", {}, base_color=REDDISH, roughness=0.4, spec_trans=0.7,
        diff_trans=0.6, eta=1.5)
    add("blendbsdf", "blendbsdf", RECIPROCAL, weight=0.3, first={"type": "diffuse"},
        second={"type": "roughconductor", "alpha": 0.3})
    add("mask", "mask", RECIPROCAL, opacity=0.6, nested={"type": "diffuse"})
    add("twosided", "twosided", RECIPROCAL, nested={"type": "roughconductor", "alpha": 0.3})
    add("null", "null", {"reciprocal": True, "lossless": True})
    # A normal tilted by 17 degrees, and heights that rise by 1/2 along u and fall by 1/4 along v.
    leaning = image([[[0.62, 0.41, 0.94]] * 2] * 2)
    slope = image([[[0.5 * (x + 0.5) / 64 - 0.25 * (y + 0.5) / 64] for x in range(64)] for y in range(64)])
    metal = {"type": "roughconductor", "alpha": 0.3}
    for name, nested in (("diffuse", {"type": "diffuse"}), ("roughconductor", metal)):
        add(f"normalmap {name}", "normalmap", {}, normalmap=leaning, nested=nested)
        add(f"bumpmap {name}", "bumpmap", {}, heights=slope, nested=nested)
    return found


def vectors(rows):
    columns = np.ascontiguousarray(np.array(rows, dtype=np.float64).T)
    return mi.Vector3f(*(mi.Float(column.astype(np.float32)) for column in columns))


def interaction(wo):
    """A point of a flat surface, seen from wo (which Mitsuba calls wi)."""
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wo))
    si.t, si.wi, si.wavelengths = 1, wo, WAVELENGTH
    si.n, si.uv = mi.Normal3f(0, 0, 1), mi.Point2f(0.5, 0.5)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Normal3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


def column(numbers, count):
    """A list of numbers, with null where one is not finite."""
    values = np.broadcast_to(np.array(numbers, dtype=np.float64).ravel(), count)
    return [v if finite else None for v, finite in zip(values.tolist(), np.isfinite(values).tolist())]


def evaluate(bsdf, request):
    wo, wi = vectors(request["wo"]), vectors(request["wi"])
    value, pdf = bsdf.eval_pdf(mi.BSDFContext(), interaction(wo), wi)
    count = len(request["wo"])
    return {"value": column(value[0], count), "pdf": column(pdf, count)}


def sample(bsdf, request):
    numbers = np.minimum(np.array(request["u"], dtype=np.float64).astype(np.float32), BELOW_ONE)
    lobe, u, v = (mi.Float(np.ascontiguousarray(c)) for c in numbers.T)
    drawn, weight = bsdf.sample(mi.BSDFContext(), interaction(vectors(request["wo"])), lobe, mi.Point2f(u, v))
    count = len(request["wo"])
    delta = np.broadcast_to(np.array(mi.has_flag(drawn.sampled_type, mi.BSDFFlags.Delta)).ravel(), count)
    pdf, wi = column(drawn.pdf, count), zip(*(column(c, count) for c in (drawn.wo.x, drawn.wo.y, drawn.wo.z)))
    # Mitsuba reports by a density or a weight of 0 that there is no sample.
    weight = column(weight[0], count)
    wi = [None if p == 0 or w == 0 else list(d) for p, w, d in zip(pdf, weight, wi)]
    return {"wi": wi, "weight": weight, "pdf": pdf, "delta": delta.astype(bool).tolist()}


def main():
    mi.set_variant(sys.argv[1] if len(sys.argv) > 1 else "llvm_ad_spectral")
    offered = configurations()
    bsdfs = [mi.load_dict(dictionary) for _, _, dictionary in offered]
    hello = {"protocol": 1, "name": "Mitsuba", "version": f"{mi.__version__} {mi.variant()}",
             "configurations": [{"name": n, "laws": c, "smallest": 1e-30} for n, c, _ in offered]}
    for line in sys.stdin:
        request = json.loads(line)
        if request["request"] == "hello":
            reply = hello
        else:
            answer = {"evaluate": evaluate, "sample": sample}[request["request"]]
            reply = answer(bsdfs[request["configuration"]], request)
        print(json.dumps(reply, allow_nan=False), flush=True)


if __name__ == "__main__":
    main()
