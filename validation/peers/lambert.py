"""A diffuse reflector as a peer: `validate bsdf --peer "python3 validation/peers/lambert.py"`.

See docs/peer-protocol.md.
"""
import json
import math
import sys

ALBEDO = 0.8
HELLO = {"protocol": 1, "name": "lambert", "version": "1",
         "configurations": [{"name": "albedo 0.8", "laws": {"reciprocal": True}}]}


def pdf(wo, wi):
    return wi[2] / math.pi if wo[2] > 0 and wi[2] > 0 else 0.0


def sample(wo, u):
    """A direction of density cos/pi, or None below the surface. u[0] would choose a lobe; there is only
    one."""
    cosine, angle = math.sqrt(1 - u[1]), 2 * math.pi * u[2]
    sine = math.sqrt(u[1])
    wi = [sine * math.cos(angle), sine * math.sin(angle), cosine]
    return wi if pdf(wo, wi) > 0 else None


def answer(request):
    if request["request"] == "hello":
        return HELLO
    if request["request"] == "evaluate":
        density = [pdf(wo, wi) for wo, wi in zip(request["wo"], request["wi"])]
        return {"value": [ALBEDO * p for p in density], "pdf": density}
    if request["request"] == "sample":
        wi = [sample(wo, u) for wo, u in zip(request["wo"], request["u"])]
        density = [pdf(o, i) if i else 0.0 for o, i in zip(request["wo"], wi)]
        return {"wi": wi, "weight": [ALBEDO] * len(wi), "pdf": density, "delta": [False] * len(wi)}
    return {"error": f"unknown request {request['request']}"}


def main():
    for line in sys.stdin:
        print(json.dumps(answer(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
