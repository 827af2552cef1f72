"""Translates a Mitsuba scene for the adapters of other renderers: meshes as PLY, everything else as JSON.

    python3 validation/peers/neutral_scene.py SCENE.xml FOLDER

Round shapes become triangles with smooth normals, checkerboards become images, spectra become RGB, named
metals their RGB indices. A feature that the adapters do not support ends the program with a line that names
it, before scene.json is written. Mitsuba itself reads the scene; it must be installed.
"""
import json
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

import neutral_mesh

# An emitter's <spectrum value="1"/> in linear sRGB: equal energy with the renderer's white D65.
EQUAL_ENERGY = [1.205, 0.948, 0.909]
MESHES = {"ply", "obj", "serialized", "cube"}


def refuse(what):
    sys.exit(f"not translated: {what}")


class Reader:
    def __init__(self, path, folder):
        config = mi.parser.ParserConfig("scalar_rgb")
        config.merge_meshes = config.merge_equivalent = False
        self.state = mi.parser.parse_file(config, str(path))
        for step in (mi.parser.transform_upgrade, mi.parser.transform_resolve_references):
            step(config, self.state)
        self.home, self.folder, self.images = Path(path).parent, Path(folder), 0

    def children(self, node):
        for key, value in node.props.items():
            if isinstance(value, mi.Properties.ResolvedReference):
                yield key, self.state.nodes[value.index()]

    def child(self, node, kind):
        found = [child for _, child in self.children(node) if child.type == kind]
        return found[0] if found else None

    def file(self, node):
        return str((self.home / node.props["filename"]).resolve())

    def color(self, node, key, default, emits=False):
        """An RGB value, or {"image": file, "scale": to_uv} for a texture."""
        if key not in node.props:
            return [default] * 3
        value = node.props[key]
        if isinstance(value, mi.Properties.ResolvedReference):
            return self.texture(self.state.nodes[value.index()])
        if hasattr(value, "is_uniform"):
            if not value.is_uniform():
                refuse(f"the spectrum {key!r}")
            value = value.values[0]
        if isinstance(value, (int, float)):
            return [value * part for part in EQUAL_ENERGY] if emits else [value] * 3
        return [float(part) for part in np.array(value).ravel()[:3]]

    def texture(self, node):
        plugin, props = node.props.plugin_name(), node.props
        if plugin not in ("bitmap", "checkerboard"):
            refuse(f"texture {plugin!r}")
        scale = np.array(props["to_uv"].matrix).diagonal()[:2].tolist() if "to_uv" in props else [1, 1]
        if plugin == "bitmap":
            return {"image": self.file(node), "scale": scale}
        cells = np.indices((64, 64)) // 32
        same = (cells[0] == cells[1])[..., None]
        pixels = np.where(same, self.color(node, "color0", 0.4), self.color(node, "color1", 0.2)).astype(np.float32)
        path = self.folder / f"checkerboard-{self.images}.png"
        self.images += 1
        mi.Bitmap(pixels).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True).write(str(path))
        return {"image": str(path.resolve()), "scale": scale}

    def material(self, node, emits=False):
        if node is None:
            return {"type": "diffuse", "reflectance": [0.0 if emits else 0.5] * 3}
        plugin, props = node.props.plugin_name(), node.props
        if plugin == "twosided":
            return self.material(self.child(node, mi.ObjectType.BSDF), emits)
        if plugin == "diffuse":
            return {"type": "diffuse", "reflectance": self.color(node, "reflectance", 0.5)}
        if plugin == "dielectric":
            ior = lambda key, default: neutral_mesh.ior(props.get(key, default))
            return {"type": "glass", "interior": ior("int_ior", "bk7"), "exterior": ior("ext_ior", "air")}
        if plugin in ("conductor", "roughconductor"):
            found = {"type": "metal", "roughness": 0.0, "reflectance": self.color(node, "specular_reflectance", 1.0)}
            if plugin == "roughconductor":
                if props.get("distribution", "beckmann") != "ggx":
                    refuse("a rough metal whose distribution is not `ggx`")
                if "alpha_u" in props and props["alpha_u"] != props.get("alpha_v", 0.1):
                    refuse("an anisotropic metal")
                found["roughness"] = float(props.get("alpha", props.get("alpha_u", 0.1)))
            ideal = "eta" not in props and props.get("material", "none") == "none"
            return {**found, **({"eta": None, "k": None} if ideal else self.metal(node))}
        refuse(f"BSDF {plugin!r}")

    def metal(self, node):
        if "eta" in node.props:
            return {"eta": self.color(node, "eta", 0), "k": self.color(node, "k", 1)}
        bsdf = mi.load_dict({"type": "conductor", "material": node.props["material"]})
        parts = mi.traverse(bsdf)
        return {key: [float(v) for v in np.array(parts[f"{key}.value"]).ravel()] for key in ("eta", "k")}

    def mesh(self, node):
        plugin, props = node.props.plugin_name(), node.props
        transform = props.get("to_world", mi.ScalarTransform4f())
        emits = self.child(node, mi.ObjectType.Emitter) is not None
        if plugin in MESHES:
            asked = {key: props[key] for key in ("face_normals", "shape_index", "flip_normals", "flip_tex_coords")
                     if key in props}
            if "filename" in props:
                asked["filename"] = self.file(node)
            return neutral_mesh.of_mitsuba(mi.load_dict({"type": plugin, "to_world": transform, **asked}))
        if plugin not in neutral_mesh.ROUND:
            refuse(f"shape {plugin!r}")
        return neutral_mesh.ROUND[plugin](props, np.array(transform.matrix, dtype=float), emits)

    def sensor(self, node):
        props = node.props
        plugin = props.plugin_name()
        if plugin not in ("perspective", "thinlens"):
            refuse(f"sensor {plugin!r}")
        film = self.child(node, mi.ObjectType.Film).props
        width, height = film.get("width", 768), film.get("height", 576)
        axis, tangent = props.get("fov_axis", "x"), np.tan(np.radians(props["fov"]) / 2)
        if axis == "larger" and width < height or axis == "smaller" and width > height:
            axis = "y"
        across = tangent * width / height if axis == "y" else tangent
        matrix = np.array(props["to_world"].matrix, dtype=float)
        lens = props.get("aperture_radius", 0.0) if plugin == "thinlens" else 0.0
        return {"origin": matrix[:3, 3].tolist(), "forward": unit(matrix[:3, 2]), "up": unit(matrix[:3, 1]),
                "width": width, "height": height, "tan_half_width": float(across), "lens_radius": lens,
                "focus_distance": props.get("focus_distance", 1.0)}

    def read(self):
        scene = {"meshes": [], "environment": None, "max_depth": -1}
        for _, node in self.children(self.state.nodes[0]):
            if node.type == mi.ObjectType.Integrator:
                scene["max_depth"] = node.props.get("max_depth", -1)
            elif node.type == mi.ObjectType.Sensor:
                scene["sensor"] = self.sensor(node)
            elif node.type == mi.ObjectType.Emitter:
                scene["environment"] = self.environment(node)
            elif node.type == mi.ObjectType.Shape:
                self.shape(node, scene["meshes"])
        return scene

    def environment(self, node):
        plugin = node.props.plugin_name()
        if plugin == "constant":
            return {"color": self.color(node, "radiance", 1.0, emits=True)}
        if plugin == "envmap" and "to_world" not in node.props:
            return {"image": self.file(node), "scale": node.props.get("scale", 1.0)}
        refuse(f"emitter {plugin!r}" + (" with a to_world" if plugin == "envmap" else ""))

    def shape(self, node, meshes):
        emitter = self.child(node, mi.ObjectType.Emitter)
        material, mesh = self.material(self.child(node, mi.ObjectType.BSDF), emitter is not None), self.mesh(node)
        radiance = emitter and self.color(emitter, "radiance", 1.0, emits=True)
        if isinstance(radiance, dict):
            refuse("a textured area light")
        image = material.get("reflectance")
        scale = image["scale"] if isinstance(image, dict) else [1, 1]
        path = self.folder / f"mesh-{len(meshes)}.ply"
        neutral_mesh.write(path, mesh, scale)
        meshes.append({"file": str(path.resolve()), "material": material, "radiance": radiance,
                       "smooth": mesh.normals is not None})


def unit(vector):
    return (vector / np.linalg.norm(vector)).tolist()


def main():
    mi.set_variant("scalar_rgb")
    path, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    scene = Reader(path, folder).read()
    (folder / "scene.json").write_text(json.dumps(scene, indent=1))


if __name__ == "__main__":
    main()
