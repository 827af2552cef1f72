"""The features of a Mitsuba scene file as a set of words, and the list of those that the references must
cover.

The words, for a shape of type sphere with a mask BSDF:

    shape:sphere  sphere.radius  sphere.flip_normals  sphere.to_world  sphere.mirrored
    bsdf:mask  mask.opacity=0.4 (numbers and strings)  mask.opacity:bitmap (a nested plugin)  area@sphere (an emitter on it)
    translate/xyz  translate/value (how the vector was written)  <include>  <default>  <path>  <ref>  id
"""
import xml.etree.ElementTree as ElementTree
from pathlib import Path

REQUIRED = {
    "shapes": [f"{shape}{what}" for shape in ("rectangle", "sphere", "disk", "cube", "cylinder", "obj", "ply", "serialized")
               for what in (".to_world", ".flip_normals", ".mirrored")]
    + ["sphere.center", "sphere.radius", "cylinder.p0", "cylinder.p1", "cylinder.radius", "serialized.shape_index",
       "ply.face_normals", "shape:shapegroup", "instance.to_world", "instance.mirrored"],
    "bsdfs": """bsdf:diffuse diffuse.reflectance:rgb diffuse.reflectance:spectrum diffuse.reflectance:bitmap
        diffuse.reflectance:checkerboard conductor.material=Au conductor.material=Cu conductor.material=none
        conductor.eta conductor.k conductor.specular_reflectance dielectric.int_ior:float dielectric.int_ior:string
        dielectric.ext_ior:float dielectric.ext_ior:string dielectric.specular_reflectance
        dielectric.specular_transmittance thindielectric.int_ior:float thindielectric.int_ior:string
        thindielectric.specular_transmittance roughconductor.distribution=ggx roughconductor.distribution=beckmann
        roughconductor.alpha:float roughconductor.alpha:checkerboard roughconductor.alpha_u roughconductor.alpha_v
        roughconductor.material=none roughconductor.sample_visible=false roughdielectric.distribution=ggx
        roughdielectric.distribution=beckmann roughdielectric.alpha roughdielectric.alpha_u roughdielectric.alpha_v
        roughdielectric.specular_transmittance bsdf:plastic plastic.nonlinear=true plastic.int_ior
        plastic.specular_reflectance roughplastic.distribution=ggx roughplastic.distribution=beckmann
        roughplastic.nonlinear=true roughplastic.int_ior:string roughplastic.diffuse_reflectance:bitmap bsdf:null
        twosided/1 twosided/2 mask.opacity:float mask.opacity:bitmap blendbsdf.weight:float
        blendbsdf.weight:bitmap normalmap.normalmap:bitmap normalmap.flip_invalid_normals=false
        normalmap.use_shadowing_function=false bsdf:bumpmap bumpmap.scale bumpmap.flip_invalid_normals=false
        bumpmap.use_shadowing_function=false principled.base_color:rgb principled.base_color:bitmap
        principled.roughness principled.anisotropic principled.metallic:float principled.metallic:checkerboard
        principled.spec_trans principled.eta principled.specular principled.flatness principled.sheen
        principled.clearcoat principled.clearcoat_gloss principled.spec_tint principled.sheen_tint
        principled.main_specular_sampling_rate principled.diffuse_reflectance_sampling_rate
        principled.clearcoat_sampling_rate principledthin.base_color:rgb principledthin.base_color:bitmap
        principledthin.roughness principledthin.anisotropic principledthin.spec_trans:float
        principledthin.spec_trans:checkerboard principledthin.eta principledthin.flatness principledthin.sheen
        principledthin.diff_trans principledthin.diffuse_transmittance_sampling_rate
        principledthin.specular_reflectance_sampling_rate
        principledthin.specular_transmittance_sampling_rate""".split(),
    "emitters": """area@rectangle area@sphere area@disk area@cylinder area@obj area@ply area.radiance:bitmap
        area.radiance:rgb point.position point.to_world spot.cutoff_angle spot.beam_width spot.texture:bitmap
        spot.to_world projector.irradiance:bitmap projector.irradiance:rgb projector.irradiance:checkerboard
        projector.scale projector.fov projector.fov_axis=y projector.focal_length projector.to_world
        directional.direction directional.to_world emitter:constant envmap.filename envmap.to_world
        envmap.scale""".split(),
    "sensors": """sensor:perspective perspective.fov_axis=x perspective.fov_axis=y perspective.fov_axis=diagonal
        perspective.fov_axis=smaller perspective.fov_axis=larger perspective.focal_length
        perspective.principal_point_offset_x perspective.principal_point_offset_y perspective.near_clip
        perspective.far_clip thinlens.aperture_radius thinlens.focus_distance sensor:orthographic""".split(),
    "films": """film:hdrfilm hdrfilm.crop_offset_x hdrfilm.crop_offset_y hdrfilm.crop_width hdrfilm.crop_height
        hdrfilm.sample_border hdrfilm.pixel_format=rgba film:specfilm rfilter:box rfilter:tent tent.radius
        rfilter:gaussian gaussian.stddev rfilter:mitchell mitchell.B mitchell.C rfilter:catmullrom rfilter:lanczos
        lanczos.lobes""".split(),
    "textures": """bitmap.filename=*.png bitmap.filename=*.exr bitmap.filename=*.jpg bitmap.filename=*.hdr
        bitmap.filter_type=bilinear bitmap.filter_type=nearest bitmap.wrap_mode=repeat bitmap.wrap_mode=mirror
        bitmap.wrap_mode=clamp bitmap.raw=true bitmap.to_uv checkerboard.to_uv checkerboard.color1:bitmap
        mesh_attribute.name=vertex_color mesh_attribute.name=face_color mesh_attribute.name=vertex_grain
        mesh_attribute.scale""".split(),
    "media": """medium:homogeneous medium:heterogeneous homogeneous.albedo:float homogeneous.albedo:rgb
        homogeneous.albedo:gridvolume homogeneous.albedo=0 homogeneous.sigma_t:float homogeneous.sigma_t:rgb
        homogeneous.scale homogeneous.sample_emitters=false heterogeneous.sigma_t:gridvolume
        heterogeneous.sigma_t:constvolume heterogeneous.albedo:constvolume heterogeneous.scale phase:isotropic
        phase:hg hg.g phase:rayleigh tabphase.values blendphase.weight:float
        blendphase.weight:gridvolume gridvolume.use_grid_bbox=true gridvolume.filter_type=nearest
        gridvolume.filter_type=trilinear gridvolume.wrap_mode=repeat gridvolume.wrap_mode=mirror
        gridvolume.to_world constvolume.to_world perspective.medium sphere.exterior sphere.interior
        cube.interior""".split(),
    "spectra": """spectrum:uniform spectrum:regular spectrum:irregular spectrum:srgb spectrum:d65 spectrum:blackbody
        <spectrum>/value <spectrum>/filename""".split(),
    "transforms": """translate/xyz translate/value rotate/xyz rotate/value scale/xyz scale/value matrix/value
        lookat/origin""".split(),
    "file": "<default> <include> <path> <ref> id".split(),
    "integrators": """integrator:volpath path.max_depth path.max_depth=16 path.rr_depth path.hide_emitters=true integrator:direct
        direct.emitter_samples direct.bsdf_samples integrator:depth aov:depth aov:position aov:uv aov:geo_normal
        aov:sh_normal""".split(),
}

# Elements whose spelling is described as well, because a vector can be written in two forms.
TRANSFORMS = ("translate", "rotate", "scale", "matrix", "lookat")
SPECTRAL_ONLY = {"film:specfilm", "spectrum:blackbody", "spectrum:regular", "spectrum:irregular"}
# Channels of depth and aov have no colour; Mitsuba's luminance of a base colour depends on the path's
# wavelengths.
RGB_ONLY = {"integrator:depth", "integrator:aov", "principled.spec_tint", "principled.sheen_tint"}


def determinant_sign(transform):
    """The sign of a to_world's determinant, which rotations, translations and lookats do not change."""
    sign = 1
    for step in transform:
        if step.tag == "scale":
            numbers = (step.get("value") or " ".join(step.get(axis, "1") for axis in "xyz")).replace(",", " ").split()
            for number in numbers * (3 if len(numbers) == 1 else 1):
                sign = -sign if float(number) < 0 else sign
        elif step.tag == "matrix":
            m = [float(x) for x in step.get("value").replace(",", " ").split()]
            n = 4 if len(m) == 16 else 3
            a, b, c = (m[i * n:i * n + 3] for i in range(3))
            value = (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                     + a[2] * (b[0] * c[1] - b[1] * c[0]))
            sign = -sign if value < 0 else sign
    return sign


def describe_property(owner, child):
    """Words for one child of a plugin of type `owner`."""
    name, value, kind = child.get("name"), child.get("value", ""), child.get("type") or child.tag
    if name:
        yield f"{owner}.{name}"
        yield f"{owner}.{name}:{kind}"
        if value:
            yield f"{owner}.{name}={value}"
        if name == "filename":
            yield f"{owner}.filename=*{Path(value).suffix}"
        if name == "aovs":
            yield from (f"aov:{item.split(':')[1]}" for item in value.split(","))
        if name == "to_world" and determinant_sign(child) < 0:
            yield f"{owner}.mirrored"
    if child.tag == "emitter":
        yield f"{child.get('type')}@{owner}"


def describe(element, directories):
    """All words of an element and of the files that it includes."""
    kind = element.get("type")
    if kind:
        yield f"{element.tag}:{kind}"
    if element.get("id") and element.tag != "ref":
        yield "id"
    if element.tag in ("default", "include", "path", "ref"):
        yield f"<{element.tag}>"
    if element.tag == "spectrum" and not kind:
        yield "<spectrum>/filename" if element.get("filename") else "<spectrum>/value"
    if element.tag in TRANSFORMS:
        spelling = next((a for a in ("value", "origin") if element.get(a)), "xyz")
        yield f"{element.tag}/{spelling}"
    if element.tag == "include":
        yield from features(find(element.get("filename"), directories), directories)
    if kind == "twosided":
        yield f"twosided/{sum(child.tag in ('bsdf', 'ref') for child in element)}"
    for child in element:
        if kind:
            yield from describe_property(kind, child)
        yield from describe(child, directories)


def find(name, directories):
    """The path of a file, searched as Mitsuba does: beside the scene, then in its <path> folders."""
    return next(d / name for d in directories if (d / name).exists())


def search_directories(scene):
    root = ElementTree.parse(scene).getroot()
    return [scene.parent] + [scene.parent / p.get("value") for p in root.iter("path")]


def features(scene, directories=None):
    directories = directories or search_directories(scene)
    return set(describe(ElementTree.parse(scene).getroot(), directories))


def inputs(scene, directories=None):
    """The scene and every file that it reads, directly or through an include."""
    directories = directories or search_directories(scene)
    files = [scene]
    for element in ElementTree.parse(scene).getroot().iter():
        name = element.get("value") if element.get("name") == "filename" else element.get("filename")
        if name:
            path = find(name, directories)
            files += inputs(path, directories) if element.tag == "include" else [path]
    return sorted(set(files))


def modes(scene):
    """The colour modes, rgb and spectral, in which Mitsuba can render this scene and it is worthwhile."""
    used = features(scene)
    return [m for m, bar in (("rgb", SPECTRAL_ONLY), ("spectral", RGB_ONLY)) if not used & bar]


def print_coverage(scenes):
    """Prints every required word with the scenes that use it; returns the words that none uses."""
    used = {scene.stem: features(scene) for scene in scenes}
    missing = []
    for group, words in REQUIRED.items():
        print(f"\n{group}")
        for word in words:
            where = [name for name, found in used.items() if word in found]
            shown = ", ".join(where[:4]) + (f" and {len(where) - 4} more" if len(where) > 4 else "")
            print(f"  {word:42} {shown or 'MISSING'}")
            missing += [] if where else [word]
    print(f"\n{sum(map(len, REQUIRED.values())) - len(missing)} covered, {len(missing)} missing")
    return missing
