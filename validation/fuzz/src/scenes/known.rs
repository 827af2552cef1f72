//! Known differences from Mitsuba 3.9.1, by what a scene must contain for them to show.
//!
//! `docs/scenes.md` explains each. A scene with one of them is drawn again.

use super::node::Node;

/// A known difference: why Mitsuba gives another image or none, and the elements at which it does.
pub struct Known {
    pub cause: &'static str,
    pub shows: fn(&Node) -> bool,
}

/// All known differences.
pub const KNOWN: &[Known] = &[
    Known {
        cause: "an extension that Mitsuba refuses",
        shows: |n| {
            n.child("emitter_samples").is_some() && n.is("integrator", "path")
                || n.is("spectrum", "blackbody") && n.child("scale").is_some()
                || n.is("bsdf", "dielectric")
                    && (["fresnel", "dispersion", "sellmeier", "cauchy"].iter().any(|p| n.child(p).is_some())
                        || n.child("int_ior").is_some_and(|i| i.tag == "spectrum"))
        },
    },
    Known {
        cause: "blendbsdf loses light where a delta lobe is blended",
        shows: |n| n.is("bsdf", "blendbsdf") && n.children.iter().any(has_delta_lobe),
    },
    Known {
        cause: "roughdielectric without sample_visible leaves the widening out of its weight",
        shows: |n| {
            let off = |c: &Node| c.get("value") == Some("false");
            n.is("bsdf", "roughdielectric") && n.child("sample_visible").is_some_and(off)
        },
    },
    Known {
        cause: "a normal map or relief that is not raw has no spectrum",
        shows: |n| {
            let raw = |m: &Node| m.child("raw").is_some_and(|r| r.get("value") == Some("true"));
            n.is("bsdf", "normalmap") && !n.child("normalmap").is_some_and(raw)
                || n.is("bsdf", "bumpmap") && n.children.iter().any(|c| c.tag == "texture" && !raw(c))
        },
    },
    Known {
        cause: "bumpmap wants a bitmap",
        shows: |n| n.is("bsdf", "bumpmap") && !n.children.iter().any(|c| c.is("texture", "bitmap")),
    },
    Known {
        cause: "bumpmap around an anisotropic material mixes coordinates in the tangent",
        shows: |n| n.is("bsdf", "bumpmap") && n.all().iter().any(anisotropic),
    },
    Known {
        cause: "tangents of an instance are not placed with it",
        shows: |n| {
            let tangent = |m: &&Node| anisotropic(m) || m.is("bsdf", "normalmap") || m.is("bsdf", "bumpmap");
            (n.is("shape", "instance") || n.is("shape", "shapegroup")) && n.all().iter().any(tangent)
        },
    },
    Known {
        cause: "the luminance of a principled material's base depends on the wavelengths that a path carries",
        shows: |n| {
            let tints = ["spec_tint", "sheen_tint"];
            let principled = n.is("bsdf", "principled") || n.is("bsdf", "principledthin");
            principled && tints.iter().any(|tint| n.child(tint).is_some())
        },
    },
    Known {
        cause: "sh_normal of an aov is that of the normal map or relief",
        shows: |n| {
            let inclined = |m: &&Node| m.is("bsdf", "normalmap") || m.is("bsdf", "bumpmap");
            n.tag == "scene"
                && n.all().iter().any(|m| m.is("integrator", "aov"))
                && n.all().iter().any(inclined)
        },
    },
    Known {
        cause: "path, with hide_emitters or without surroundings: light gathered at a mask is lost if the path passes it and leaves",
        shows: |n| {
            let passed = ["mask", "null", "thindielectric"];
            n.tag == "scene"
                && (n.all().iter().any(hides) || !n.all().iter().any(surrounds))
                && n.all().iter().any(|m| passed.iter().any(|kind| m.is("bsdf", kind)))
        },
    },
    Known {
        cause: "hide_emitters in a scene with an instance: the process dies",
        shows: |n| {
            n.tag == "scene" && n.all().iter().any(hides) && n.all().iter().any(|m| m.is("shape", "instance"))
        },
    },
    Known {
        cause: "direct counts point, spot and directional lights once for each of its emitter samples",
        shows: |n| {
            let several = ["emitter_samples", "shading_samples"];
            let chosen =
                |m: &&Node| m.is("integrator", "direct") && several.iter().any(|p| m.child(p).is_some());
            let small = ["point", "spot", "directional"];
            n.tag == "scene"
                && n.all().iter().any(chosen)
                && n.all().iter().any(|m| small.iter().any(|kind| m.is("emitter", kind)))
        },
    },
];

/// Whether a material is anisotropic and so needs a tangent.
fn anisotropic(node: &&Node) -> bool {
    node.child("alpha_u").is_some() || node.child("anisotropic").is_some()
}

fn hides(node: &&Node) -> bool {
    node.child("hide_emitters").is_some_and(|h| h.get("value") == Some("true"))
}

fn surrounds(node: &&Node) -> bool {
    node.is("emitter", "constant") || node.is("emitter", "envmap")
}

/// Whether a material, or a nested one, has a delta lobe.
fn has_delta_lobe(material: &Node) -> bool {
    let delta = ["conductor", "dielectric", "thindielectric", "plastic", "null", "mask"];
    material.all().iter().any(|m| delta.iter().any(|kind| m.is("bsdf", kind)))
}

/// The causes of known differences in an element or its descendants.
pub fn causes(node: &Node) -> Vec<&'static str> {
    let all = node.all();
    KNOWN.iter().filter(|k| all.iter().any(|n| (k.shows)(n))).map(|k| k.cause).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blend_with_glass_is_known_and_one_without_is_not() {
        let blend = |other: &str| {
            let text = format!(
                "<bsdf type=\"twosided\"><bsdf type=\"blendbsdf\"><bsdf type=\"diffuse\"/>\
                 <bsdf type=\"{other}\"/></bsdf></bsdf>"
            );
            causes(&Node::parse(&text).unwrap()).len()
        };
        assert_eq!([blend("dielectric"), blend("roughplastic")], [1, 0]);
    }
}
