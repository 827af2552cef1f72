#!/usr/bin/env python3
"""Writes the meshes and textures of validation/references/scenes: small, computed from formulae,
reproducible.

    python3 validation/peers/reference_assets.py

Meshes are written byte by byte, so that the readers under test get files that no renderer wrote. Images are
written by Mitsuba's own encoders, because the reference renderer decodes them too.
"""
import argparse
import math
import struct
import zlib
from pathlib import Path

import numpy as np

SCENES = Path(__file__).resolve().parents[1] / "references" / "scenes"
MESHES = SCENES / "meshes"
TEXTURES = SCENES / "textures"
VOLUMES = SCENES / "volumes"


def normalize(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def vase(rings=9, sides=12):
    """A surface of revolution, as quads with its own normals and texture coordinates. The u seam is
    doubled."""
    points, normals, uvs, quads = [], [], [], []
    for j in range(rings):
        t = j / (rings - 1)
        radius = 0.55 + 0.3 * math.sin(math.pi * (0.15 + 1.5 * t))
        slope = 0.3 * math.pi * 1.5 * math.cos(math.pi * (0.15 + 1.5 * t)) / 1.8  # dr/dy over a height of 1.8
        for i in range(sides + 1):
            phi = 2 * math.pi * i / sides
            c, s = math.cos(phi), math.sin(phi)
            points.append((radius * c, 1.8 * t - 0.9, -radius * s))
            normals.append(normalize((c, -slope, -s)))
            uvs.append((i / sides, t))
    for j in range(rings - 1):
        for i in range(sides):
            a, b = j * (sides + 1) + i, (j + 1) * (sides + 1) + i
            quads.append((a, a + 1, b + 1, b))
    return points, normals, uvs, quads


def icosphere(levels=1):
    """A subdivided icosahedron whose vertex normals are the sphere's; texture coordinates project along z."""
    g = (1 + math.sqrt(5)) / 2
    points = [normalize(p) for p in [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
                                     (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10),
             (8, 6, 7), (9, 8, 1)]
    for _ in range(levels):
        middle = {}

        def split(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append(normalize(tuple(x + y for x, y in zip(points[a], points[b]))))
            return middle[key]

        faces = [f for a, b, c in faces for ab, bc, ca in [(split(a, b), split(b, c), split(c, a))]
                 for f in [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]]
    uvs = [((x + 1) / 2, (y + 1) / 2) for x, y, _ in points]
    return points, points, uvs, faces


def torus(around=16, tube=8, radius=0.7, thickness=0.3):
    points, normals, uvs, faces = [], [], [], []
    for i in range(around + 1):
        phi = 2 * math.pi * i / around
        for j in range(tube + 1):
            theta = 2 * math.pi * j / tube
            n = (math.cos(theta) * math.cos(phi), math.cos(theta) * math.sin(phi), math.sin(theta))
            points.append((radius * math.cos(phi) + thickness * n[0], radius * math.sin(phi) + thickness * n[1],
                           thickness * n[2]))
            normals.append(n)
            uvs.append((i / around, j / tube))
    for i in range(around):
        for j in range(tube):
            a, b = i * (tube + 1) + j, (i + 1) * (tube + 1) + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    return points, normals, uvs, faces


OCTAHEDRON = ([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
              [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])


def write_obj(path, mesh):
    points, normals, uvs, faces = mesh
    lines = ["# quads with normals and texture coordinates", "o vase"]
    lines += ["v %.9g %.9g %.9g" % p for p in points]
    lines += ["vt %.9g %.9g" % t for t in uvs]
    lines += ["vn %.9g %.9g %.9g" % n for n in normals]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}/{i + 1}" for i in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_seamed_obj(path, sides=8):
    """Writes a closed barrel without normals, whose points have several texture coordinates at its seams."""
    heights, radii = (-0.8, 0.0, 0.8), (0.5, 0.7, 0.5)
    lines = ["# texture coordinates that part along a line and at the lids, and no normals"]
    for y, radius in zip(heights, radii):
        angles = (2 * math.pi * i / sides for i in range(sides))
        lines += ["v %.9g %.9g %.9g" % (radius * math.cos(a), y, -radius * math.sin(a)) for a in angles]
    lines += ["v 0 -1 0", "v 0 1 0"]
    lines += ["vt %.9g %.9g" % (i / sides, j / 2) for j in range(3) for i in range(sides + 1)]
    lines += ["vt 0.5 0.5"]
    around, uv = [*range(sides), 0], lambda j, i: j * (sides + 1) + i + 1
    for j in range(2):
        for i in range(sides):
            corners = [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)]
            lines.append("f " + " ".join(f"{j * sides + around[i] + 1}/{uv(j, i)}" for j, i in corners))
    for i in range(sides):
        a, b, middle = around[i + 1] + 1, around[i] + 1, 3 * (sides + 1) + 1
        lines.append(f"f {a}/{middle} {b}/{middle} {3 * sides + 1}/{middle}")
        lines.append(f"f {2 * sides + b}/{middle} {2 * sides + a}/{middle} {3 * sides + 2}/{middle}")
    path.write_text("\n".join(lines) + "\n")


def write_ply(path, mesh):
    """Writes a binary, little-endian PLY: float32 x y z nx ny nz u v; faces are a uchar count and int32
    indices."""
    points, normals, uvs, faces = mesh
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    header += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz", "u", "v")]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    body = b"".join(struct.pack("<8f", *p, *n, *t) for p, n, t in zip(points, normals, uvs))
    body += b"".join(struct.pack("<B3i", 3, *f) for f in faces)
    path.write_bytes("\n".join(header).encode() + body)


def write_ascii_ply(path, points, faces):
    """Writes a text PLY with positions only, so that the reader has to compute the normals."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", "property float x", "property float y",
             "property float z", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += ["%.9g %.9g %.9g" % p for p in points] + [f"{len(f)} " + " ".join(map(str, f)) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def serialized_shape(name, points, faces, normals=None, uvs=None):
    """The bytes of one mesh in Mitsuba's serialized format, version 4, single precision."""
    flags = 0x1000 | (0x0001 if normals else 0) | (0x0002 if uvs else 0)
    data = struct.pack("<I", flags) + name.encode() + b"\0" + struct.pack("<QQ", len(points), len(faces))
    for array in (points, normals, uvs):
        if array:
            data += np.asarray(array, "<f4").tobytes()
    data += np.asarray(faces, "<u4").tobytes()
    return struct.pack("<HH", 0x041C, 4) + zlib.compress(data, 9)


def write_serialized(path, shapes):
    """Writes the meshes one after another, then their offsets (uint64 from version 4 on) and number
    (uint32)."""
    offsets = np.cumsum([0] + [len(s) for s in shapes])[:-1]
    path.write_bytes(b"".join(shapes) + b"".join(struct.pack("<Q", int(o)) for o in offsets)
                     + struct.pack("<I", len(shapes)))


def tiles(size=8):
    """A small picture without symmetry: no flip or rotation of it equals itself."""
    v, u = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    picture = np.stack([0.15 + 0.8 * u / (size - 1), 0.15 + 0.8 * v / (size - 1), 0.9 - 0.7 * (u * v) / (size - 1) ** 2], 2)
    picture[: size // 4, : size // 2] = (0.9, 0.85, 0.1)  # a yellow bar at the top left
    picture[size // 2, :] *= 0.3
    return picture


def smooth(size=32):
    """A slow gradient, which all JPEG decoders decode equally."""
    v, u = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")
    return np.stack([0.2 + 0.6 * u, 0.3 + 0.4 * v, 0.7 - 0.5 * u * v], 2)


def sky(width=32, height=16):
    """Blue above, brown below, and a sun of 2 x 2 texels: most of the light comes from 0.4 % of the
    picture."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    up = np.clip(1 - 2 * v, 0, 1)[..., None]
    picture = np.where(v[..., None] < 0.5, (0.55, 0.62, 0.70) + up * np.array((-0.35, -0.25, 0.15)), (0.18, 0.14, 0.10))
    picture = picture * (1 + 0.3 * np.sin(2 * np.pi * u))[..., None]
    picture[4:6, 7:9] = (95, 82, 60)
    return picture


def height_map(size=32):
    """Humps and a ramp that is discontinuous where the picture repeats, between 0 and 1."""
    v, u = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")
    return 0.5 + 0.3 * np.sin(4 * np.pi * u) * np.sin(2 * np.pi * v) + 0.15 * (u - 0.5) + 0.05 * np.cos(6 * np.pi * v)


def normal_map(size=32):
    """Normals of steeper humps, inclined by up to 55 degrees, as colours (n + 1) / 2."""
    v, u = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")
    slopes = 1.4 * np.cos(2 * np.pi * u) * np.sin(2 * np.pi * v), 0.9 * np.sin(4 * np.pi * u) * np.cos(2 * np.pi * v) + 0.3
    n = np.stack([-slopes[0], -slopes[1], np.ones_like(u)], 2)
    return 0.5 + 0.5 * n / np.linalg.norm(n, axis=2, keepdims=True)


def write_volume(path, values, low=(0, 0, 0), high=(1, 1, 1)):
    """Values[z, y, x, channel], little-endian, and the box that they fill."""
    depth, height, width, channels = values.shape
    header = b"VOL\x03" + struct.pack("<5i6f", 1, width, height, depth, channels, *low, *high)
    path.write_bytes(header + values.astype("<f4").tobytes())


def puff(size=10):
    """A cloud that is dense in its middle and has lumps, nothing at its rim."""
    z, y, x = (np.indices((size, size, size)) + 0.5) / size - 0.5
    lumps = 0.6 + 0.4 * np.sin(9 * x + 1) * np.sin(7 * y) * np.cos(8 * z)
    return (np.maximum(0.5 - np.sqrt(x * x + y * y + z * z), 0) * 2 * lumps)[..., None]


def hues(size=4):
    """Colours that change along each axis."""
    z, y, x = (np.indices((size, size, size)) + 0.5) / size
    return np.stack([0.15 + 0.8 * x, 0.2 + 0.7 * y, 0.9 - 0.7 * z], axis=-1)


def shades(size=4):
    """Greys of an albedo that change along each axis."""
    return hues(size).mean(axis=-1, keepdims=True)


def main():
    import mitsuba as mi
    mi.set_variant("scalar_rgb")
    MESHES.mkdir(parents=True, exist_ok=True)
    TEXTURES.mkdir(parents=True, exist_ok=True)
    VOLUMES.mkdir(parents=True, exist_ok=True)
    write_volume(VOLUMES / "puff.vol", puff(), (-2.6, 0.15, -0.7), (-1.2, 1.6, 0.75))
    write_volume(VOLUMES / "hues.vol", hues())
    write_volume(VOLUMES / "shades.vol", shades())
    write_obj(MESHES / "vase.obj", vase())
    write_seamed_obj(MESHES / "barrel.obj")
    write_ply(MESHES / "ball.ply", icosphere())
    write_ascii_ply(MESHES / "octahedron.ply", *OCTAHEDRON)
    points, normals, uvs, faces = torus()
    write_serialized(MESHES / "pair.serialized", [serialized_shape("octahedron", *OCTAHEDRON),
                                                  serialized_shape("torus", points, faces, normals, uvs)])

    def save(name, picture, component=mi.Struct.Type.UInt8, gamma=True):
        bitmap = mi.Bitmap(np.ascontiguousarray(picture, dtype=np.float32))
        bitmap.set_srgb_gamma(False)
        bitmap.convert(component_format=component, srgb_gamma=gamma).write(str(TEXTURES / name))

    float32 = mi.Struct.Type.Float32
    save("tiles.png", tiles())
    save("smooth.jpg", smooth())
    save("tiles.exr", tiles(), float32, gamma=False)
    save("smooth.hdr", smooth() * 1.25, float32, gamma=False)
    save("sky.exr", sky(), float32, gamma=False)
    holes = (0.15 + 0.8 * (np.indices((6, 6)).sum(0) % 2))[..., None]
    save("holes.png", holes, gamma=False)
    save("heights.png", height_map()[..., None], gamma=False)
    save("normals.png", normal_map(), gamma=False)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    main()
