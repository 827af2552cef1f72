//! Random rooms of glass and mirrors, rendered by every technique and by path tracing without any: techniques
//! change the noise only.

use crate::scenes::casters::{Scene, scene};
use crate::scenes::models::Models;
use crate::scenes::node::Node;
use etalon::spectrum::ColorMode;
use serde::Serialize;
use validate::metamorphic::{Relation, Term, one_of};
use validate::stage::load;
use validation::image::Image;
use validation::{Outcome, Verdict};

/// Largest relative difference of a mean that counts as equivalent.
const MARGIN: f64 = 0.02;

/// A parameter of the integrator: tag, name, value.
type Parameter = (&'static str, &'static str, &'static str);

const NO_LIGHT_PATHS: Parameter = ("float", "light_paths", "0");
const LIGHT_PATHS: Parameter = ("float", "light_paths", "1");
const NO_LINKS: Parameter = ("string", "links", "never");

/// The parameter that has pixels share, here groups of 2 × 2.
const REUSE: &str = "reuse";

/// What all others are compared with.
const PLAIN: &[Parameter] = &[NO_LIGHT_PATHS, NO_LINKS];

/// The techniques, by name.
pub const TECHNIQUES: &[(&str, &[Parameter])] = &[
    ("as chosen", &[]),
    ("light paths", &[LIGHT_PATHS, NO_LINKS]),
    ("links", &[NO_LIGHT_PATHS, ("string", "links", "everywhere")]),
    ("light paths and links", &[LIGHT_PATHS, ("string", "links", "everywhere")]),
    ("guided", &[NO_LIGHT_PATHS, ("string", "links", "guided")]),
    ("re-use", &[("integer", REUSE, "4"), ("integer", "shared_light_paths", "4")]),
];

/// A technique on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Number of the scene.
    pub number: u64,
    pub technique: &'static str,
    pub verdict: Verdict,
    pub message: String,
    /// The scene as the technique renders it.
    #[serde(skip)]
    pub text: String,
}

/// All techniques on scene `number`, with so many samples per pixel; none if Etalon refuses what the grammar
/// has drawn. What differs was confirmed by four times the samples and other seeds; so does a sample that is
/// not finite. Error: the grammar has a dead end.
pub fn judge(models: &Models, folder: &str, number: u64, samples: u64) -> Result<Vec<Finding>, String> {
    let scene = scene(models, folder, number).ok_or("the grammar has a dead end")?;
    let plain = told(&scene, PLAIN);
    if load(&plain, ColorMode::Rgb).is_err() {
        return Ok(vec![]);
    }
    let judged = |(technique, parameters): &(&'static str, &'static [Parameter])| {
        let text = told(&scene, parameters);
        let relation = relation(&format!("{number} {technique}"), &scene, [&plain, &text], samples);
        let different = |found: &Outcome| found.verdict == Verdict::Different;
        let first = relation.check(1, 0);
        let found = if first.as_ref().is_ok_and(different) { relation.check(4, 1) } else { first };
        let (verdict, message) =
            found.map_or_else(|why| (Verdict::Different, why), |found| (found.verdict, found.message));
        Finding { number, technique, verdict, message, text }
    };
    Ok(TECHNIQUES.iter().map(judged).collect())
}

/// The scene with these parameters of its integrator.
fn told(scene: &Scene, parameters: &[Parameter]) -> String {
    let mut root = scene.root.clone();
    let integrators = root.children.iter_mut().filter(|child| child.tag == "integrator");
    for integrator in integrators {
        let node = |(tag, name, value): &Parameter| Node::new(tag, &[("name", name), ("value", value)]);
        integrator.children.extend(parameters.iter().map(node));
    }
    root.to_string()
}

fn relation(name: &str, scene: &Scene, sides: [&String; 2], samples: u64) -> Relation {
    let mode = if scene.spectral { ColorMode::Spectral } else { ColorMode::Rgb };
    // Of pixels that share what their paths find only one of each group, so that their noise is independent.
    let shares = sides.iter().any(|text| text.contains(REUSE));
    let view = shares.then_some(one_of::<2> as fn(&Image) -> Image);
    let [left, right] = sides.map(|text| vec![Term { mode, view, ..Term::new(text.clone()) }]);
    Relation::expectation(name, left, right).within(MARGIN).samples(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> String {
        concat!(env!("CARGO_MANIFEST_DIR"), "/../references/scenes").into()
    }

    #[test]
    fn techniques_change_the_noise_only() {
        let models = Models::read().unwrap();
        let found: Vec<Finding> =
            (0..4).flat_map(|number| judge(&models, &folder(), number, 256).unwrap()).collect();
        let of = |verdict| found.iter().filter(move |f| f.verdict == verdict);
        assert!(of(Verdict::Different).next().is_none(), "{:?}", of(Verdict::Different).collect::<Vec<_>>());
        assert!(of(Verdict::Equivalent).count() > 4, "{found:?}");
    }
}
