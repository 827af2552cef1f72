"""Triangle meshes of the shapes that `neutral_scene.py` translates, and their PLY files."""
import numpy as np

IOR = {"vacuum": 1.0, "air": 1.000277, "water": 1.333, "bk7": 1.5046, "diamond": 2.419}
# Segments around a round shape; an emitter has few, because each of its triangles becomes a light.
SEGMENTS, LIGHT_SEGMENTS = 128, 24


def ior(value):
    return IOR[value] if isinstance(value, str) else float(value)


class Mesh:
    def __init__(self, points, faces, normals=None, uv=None):
        self.points, self.faces, self.normals, self.uv = points, faces, normals, uv

    def placed(self, matrix):
        points = self.points @ matrix[:3, :3].T + matrix[:3, 3]
        normals = self.normals
        if normals is not None:
            normals = normals @ np.linalg.inv(matrix[:3, :3])
            normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        faces = self.faces if np.linalg.det(matrix[:3, :3]) > 0 else self.faces[:, ::-1]
        return Mesh(points, faces, normals, self.uv)


def of_mitsuba(shape):
    import mitsuba as mi

    parts = mi.traverse(shape)
    array = lambda name, width: np.array(parts[name]).reshape(-1, width) if len(parts[name]) else None
    uv = array("vertex_texcoords", 2)
    return Mesh(array("vertex_positions", 3), array("faces", 3), array("vertex_normals", 3), uv)


def grid(rows, columns, point):
    """Triangles over the unit square, mapped by `point`, which takes and returns arrays."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    corner = np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)[None, :]
    a, b, c, d = corner, corner + 1, corner + columns + 2, corner + columns + 1
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    points = np.stack(np.broadcast_arrays(*point(u.ravel(), v.ravel())), -1)
    return points, faces, np.stack([u.ravel(), v.ravel()], -1)


def rectangle(_, matrix, emits):
    points, faces, uv = grid(1, 1, lambda u, v: (2 * u - 1, 2 * v - 1, 0 * u))
    return Mesh(points, faces, None, uv).placed(matrix)


def disk(_, matrix, emits):
    circle = lambda u, v: (v * np.cos(2 * np.pi * u), v * np.sin(2 * np.pi * u), 0 * u)
    points, faces, uv = grid(1, LIGHT_SEGMENTS if emits else SEGMENTS, circle)
    return Mesh(points, without_points(points, faces)[:, ::-1], None, uv).placed(matrix)


def sphere(props, matrix, emits):
    segments = LIGHT_SEGMENTS if emits else SEGMENTS
    ball = lambda u, v: (-np.sin(np.pi * v) * np.cos(2 * np.pi * u), -np.sin(np.pi * v) * np.sin(2 * np.pi * u),
                         -np.cos(np.pi * v))
    points, faces, uv = grid(segments // 2, segments, ball)
    faces = without_points(points, faces)
    normals = None if emits else points
    center = np.array(props.get("center", [0.0, 0.0, 0.0]), dtype=float).ravel()
    place = matrix @ np.block([[np.eye(3) * props.get("radius", 1.0), center[:, None]], [np.zeros(3), 1]])
    return Mesh(points, faces, normals, uv).placed(place)


def cylinder(props, matrix, emits):
    tube = lambda u, v: (np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), v)
    points, faces, uv = grid(1, SEGMENTS, tube)
    p0, p1 = (np.array(props.get(key, [0.0, 0.0, end]), dtype=float).ravel() for key, end in (("p0", 0.0), ("p1", 1.0)))
    axis = p1 - p0
    across = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.5 * np.linalg.norm(axis) else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    other, radius = np.cross(axis / np.linalg.norm(axis), across), props.get("radius", 1.0)
    place = np.eye(4)
    place[:3] = np.stack([across * radius, other * radius, axis, p0], 1)
    return Mesh(points, faces, points * [1, 1, 0], uv).placed(matrix @ place)


ROUND = {"rectangle": rectangle, "disk": disk, "sphere": sphere, "cylinder": cylinder}


def without_points(points, faces):
    """The faces without degenerate triangles, which occur at the poles."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return faces[area > 1e-9 * area.max()]


def write(path, mesh, scale):
    """Writes a binary PLY with x y z, nx ny nz if the mesh is smooth, and s t if it has texture
    coordinates."""
    parts, names = [mesh.points], ["x", "y", "z"]
    if mesh.normals is not None:
        parts, names = parts + [mesh.normals], names + ["nx", "ny", "nz"]
    if mesh.uv is not None:
        parts, names = parts + [mesh.uv * scale], names + ["s", "t"]
    vertices = np.concatenate(parts, 1).astype("<f4")
    faces = np.empty(len(mesh.faces), dtype=[("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, mesh.faces
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}",
              *(f"property float {name}" for name in names), f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header\n"]
    path.write_bytes("\n".join(header).encode() + vertices.tobytes() + faces.tobytes())
