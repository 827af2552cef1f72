//! Upgrades of old names in files of Mitsuba 0.6, as Mitsuba itself does them.

use super::xml::Element;

/// Mitsuba 0.6 wrote `specularReflectance` where 2.0 and later write `specular_reflectance`.
pub fn name(name: &str, node: roxmltree::Node) -> String {
    let mut result = String::new();
    let mut previous = ' ';
    // Within capitals behind a small letter, which all become small.
    let mut lowered = false;
    for c in name.chars() {
        let begins = c.is_ascii_uppercase() && previous.is_ascii_lowercase();
        if begins {
            result.push('_');
        }
        lowered = begins || lowered && c.is_ascii_uppercase();
        result.push(if lowered { c.to_ascii_lowercase() } else { c });
        previous = c;
    }
    let parent = node.parent().and_then(|p| p.attribute("type"));
    if result == "diffuse_reflectance" && parent == Some("diffuse") { "reflectance".into() } else { result }
}

/// Parameters that placed a bitmap in Mitsuba 0.6; later versions have one `to_uv`.
const PLACING: [&str; 4] = ["uoffset", "voffset", "uscale", "vscale"];

/// Replaces the parameters that placed a bitmap by a `to_uv`.
pub fn texture_offsets(element: &mut Element) {
    let value = |name: &str| {
        let number = |c: &&Element| c.name() == Some(name) && ["float", "integer"].contains(&c.tag.as_str());
        element.children.iter().find(number)?.attribute("value").map(|a| a.value.clone())
    };
    let found = PLACING.map(value);
    if found.iter().all(Option::is_none) {
        return;
    }
    let [u, v, su, sv] = found.each_ref().map(Option::as_deref);
    let step = |tag: &str, x: Option<&str>, y: Option<&str>, rest: &str| {
        Element::made_at(element, tag, &[("x", x.unwrap_or(rest)), ("y", y.unwrap_or(rest))])
    };
    let mut transform = Element::made_at(element, "transform", &[("name", "to_uv")]);
    transform.children = vec![step("translate", u, v, "0"), step("scale", su, sv, "1")];
    element.children.retain(|c| !c.name().is_some_and(|name| PLACING.contains(&name)));
    element.children.push(transform);
}

#[cfg(test)]
mod tests {
    use crate::scene::xml;

    #[test]
    fn names_of_old_versions_are_upgraded() {
        let text = r#"<scene version="0.6.0"><bsdf type="diffuse"><rgb name="diffuseReflectance" value="1"/></bsdf>
            <transform name="toWorld"/><texture type="bitmap"><float name="uscale" value="4"/></texture></scene>"#;
        let root = xml::read_text("t", text).unwrap().root;
        assert_eq!(root.children[0].children[0].name(), Some("reflectance"));
        assert_eq!(root.children[1].name(), Some("to_world"));
        assert_eq!(root.children[2].children[0].name(), Some("to_uv"));
        assert_eq!(root.children[2].children[0].children[1].attribute("x").unwrap().value, "4");
    }

    #[test]
    fn only_capitals_behind_small_letters_become_small() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIORValue", "int_iorvalue"),
            ("RGBimage", "RGBimage"),
            ("a_B", "a_B"),
            ("ABcD", "ABc_d"),
        ] {
            let text = format!(r#"<scene version="0.6.0"><float name="{old}" value="1"/></scene>"#);
            let root = xml::read_text("t", &text).unwrap().root;
            assert_eq!(root.children[0].name(), Some(new));
        }
    }

    #[test]
    fn parameters_keep_their_names_and_integers_scale_textures() {
        let text = r#"<scene version="0.6.0"><default name="timesTwo" value="2"/>
            <texture type="bitmap"><integer name="uscale" value="$timesTwo"/></texture></scene>"#;
        let root = xml::read_text("t", text).unwrap().root;
        assert_eq!(root.children[0].children[0].children[1].attribute("x").unwrap().value, "2");
    }
}
