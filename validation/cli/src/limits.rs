//! Materials near the end of a parameter's range, and their limits there.

use crate::direction::Direction;
use crate::materials::Subject;
use crate::trial::{Source, Trial, trials_of};
use std::sync::Arc;
use validation::Scatterer;

/// Vanishing roughness.
const ROUGH: &str = r#"<float name="alpha" value="1e-4"/>"#;
const GGX: &str = r#"<string name="distribution" value="ggx"/>"#;
/// Indices that hardly differ.
const ALIKE: &str = r#"<float name="int_ior" value="1.000001"/><float name="ext_ior" value="1"/>"#;
const GLASS: &str = r#"<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>"#;

/// Mitsuba's rough plastic takes the reflectance from inside, F = 2∫R(c) c dc, as the mean over 64
/// directions, and Etalon follows: at α → 0 and η = 1.5 that is F′ = 0.58755 instead of 0.59635, so the base
/// is darker than the smooth one's by (1 − F)/(1 − F′) = 0.97868 (Mitsuba 3.9.1 evaluates to 0.9786 at α =
/// 10⁻³). The limit is a smooth plastic whose reflectance is that much lower.
const DARKER: &str = r#"<spectrum name="diffuse_reflectance" value="0.48934"/>"#;

fn bsdf(kind: &str, inside: &str) -> String {
    format!("<bsdf type=\"{kind}\">{inside}</bsdf>")
}

/// Name, near model, limit, and the largest difference of the flux that the distance from the limit explains.
fn pairs() -> Vec<(String, String, String, f64)> {
    let mut pairs = vec![];
    let mut add = |name: &str, near: String, limit: String, within: f64| {
        pairs.push((name.to_string(), near, limit, within));
    };
    for (law, name) in [("", "beckmann"), (GGX, "ggx")] {
        for (model, smooth, rest) in [
            ("roughconductor", "conductor", r#"<string name="material" value="Cu"/>"#),
            ("roughdielectric", "dielectric", GLASS),
            ("roughplastic", "plastic", GLASS),
        ] {
            let near = bsdf(model, &format!("{law}{ROUGH}{rest}"));
            let limit =
                bsdf(smooth, &if model == "roughplastic" { format!("{rest}{DARKER}") } else { rest.into() });
            // α² tan² θ at 75° is 1e-7; the long tails of GGX move about 1e-4 of the flux.
            add(&format!("{model}-{name}-smooth"), near, limit, 1e-3);
        }
        let near = bsdf("roughdielectric", &format!("{law}{ROUGH}{ALIKE}"));
        add(&format!("roughdielectric-{name}-nothing"), near, bsdf("null", ""), 1e-3);
    }
    for model in ["dielectric", "thindielectric"] {
        add(&format!("{model}-nothing"), bsdf(model, ALIKE), bsdf("null", ""), 1e-4);
    }
    let dispersive = r#"<string name="cauchy" value="1.5 1e-9 0"/><float name="ext_ior" value="1"/>"#;
    add("undispersed", bsdf("dielectric", dispersive), bsdf("dielectric", GLASS), 1e-4);
    let table =
        r#"<spectrum name="int_ior" value="360:1.5, 830:1.500001"/><float name="ext_ior" value="1"/>"#;
    add("undispersed-table", bsdf("dielectric", table), bsdf("dielectric", GLASS), 1e-4);
    let matte = bsdf("diffuse", "");
    let mask = |opacity: f64| bsdf("mask", &format!("<float name=\"opacity\" value=\"{opacity}\"/>{matte}"));
    add("mask-nothing", mask(1e-5), bsdf("null", ""), 1e-3);
    add("mask-opaque", mask(0.99999), matte.clone(), 1e-3);
    let metal = bsdf("roughconductor", r#"<float name="alpha" value="0.3"/>"#);
    let blend = |w: f64| bsdf("blendbsdf", &format!("<float name=\"weight\" value=\"{w}\"/>{matte}{metal}"));
    add("blend-first", blend(1e-5), matte.clone(), 1e-3);
    add("blend-second", blend(0.99999), metal.clone(), 1e-3);
    pairs
}

/// All trials, or those whose name begins with `name`. The near models also go through every other check.
pub fn trials(name: Option<&str>) -> Vec<Trial> {
    let wanted = pairs().into_iter().filter(|pair| name.is_none_or(|name| pair.0.starts_with(name)));
    let trials = wanted.flat_map(|(name, near, limit, within)| {
        let source: Source = Arc::new(move || {
            let subject = Subject::new(&near)?.near(Subject::new(&limit)?, within);
            Ok(Box::new(subject) as Box<dyn Scatterer>)
        });
        trials_of(&format!("limit-{name}"), &source, &[35.0, 75.0, 150.0].map(Direction::At), &["spectral"])
    });
    trials.collect()
}
