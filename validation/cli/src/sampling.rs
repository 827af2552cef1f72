//! Trials of all sampled distributions besides materials: light, points on lenses and in filters,
//! wavelengths, and the warps that they use.

use crate::direction::Direction;
use crate::trial::{Source, Trial, trials_of};
use crate::{drawn_light, drawn_places, warps};
use etalon::emitter::EMITTERS;
use etalon::film::filter::FILTERS;
use etalon::sensor::SENSORS;
use etalon::shape::SHAPES;
use std::sync::Arc;
use validation::Scatterer;
use validation::scatterer::DVec3;

/// Angles in degrees of the directions from which a shape or a map is sampled; trials are named after them.
const AROUND: [Direction; 3] = [Direction::At(20.0), Direction::At(75.0), Direction::At(150.0)];

/// Receivers of the light of emitters without a surface: one without a normal, and surfaces with these
/// normals.
const RECEIVERS: [(&str, DVec3); 3] =
    [("", DVec3::ZERO), ("-from-above", DVec3::Y), ("-aslant", DVec3::new(0.61, -0.29, 0.74))];

/// The angle for distributions that do not depend on a direction.
const ONCE: [Direction; 1] = [Direction::At(0.0)];

/// Shapes that cannot be emitters: groups, whose shapes must not emit.
const GROUPS: [&str; 2] = ["shapegroup", "instance"];

/// Checks that apply to scattering only.
const SCATTERING: [&str; 3] = ["reciprocity", "spectral", "limits"];

fn wrap<S: Scatterer + 'static>(make: impl Fn() -> Result<S, String> + Send + Sync + 'static) -> Source {
    Arc::new(move || make().map(|subject| Box::new(subject) as Box<dyn Scatterer>))
}

/// All trials, or those whose name contains `name`.
pub fn trials(name: Option<&str>) -> Vec<Trial> {
    let mut trials = vec![];
    for shape in SHAPES.iter().filter(|shape| !GROUPS.contains(&shape.name)) {
        for (i, snippet) in shape.examples.iter().enumerate() {
            let source = wrap(|| drawn_light::area(snippet));
            trials.extend(trials_of(&format!("area-{}[{i}]", shape.name), &source, &AROUND, &SCATTERING));
        }
    }
    let sky = drawn_light::sky();
    let files = [format!("<emitter type=\"envmap\"><string name=\"filename\" value=\"{sky}\"/></emitter>")];
    for emitter in EMITTERS.iter().filter(|emitter| emitter.name != "area") {
        let registered = emitter.examples.iter().map(|snippet| snippet.to_string());
        let own = files.iter().filter(|_| emitter.name == "envmap").cloned();
        for (i, snippet) in registered.chain(own).enumerate() {
            for (facing, n) in RECEIVERS {
                let snippet = snippet.clone();
                let source = wrap(move || drawn_light::distant(&snippet, n.normalize_or_zero()));
                let name = format!("{}[{i}]{facing}", emitter.name);
                trials.extend(trials_of(&name, &source, &AROUND, &SCATTERING));
            }
        }
    }
    for sensor in SENSORS {
        for (i, snippet) in sensor.examples.iter().enumerate() {
            let source = wrap(|| drawn_places::Lens::new(snippet).map(validation::chart::Chart));
            trials.extend(trials_of(&format!("{}[{i}]", sensor.name), &source, &ONCE, &SCATTERING));
        }
    }
    for filter in FILTERS {
        for (i, snippet) in filter.examples.iter().enumerate() {
            // In the middle of the film, and at its border, where the filter is cut off.
            for (place, margins) in [("inside", [100, 100]), ("border", [1, 0])] {
                let source =
                    wrap(move || drawn_places::Filter::new(snippet, margins).map(validation::chart::Chart));
                trials.extend(trials_of(
                    &format!("{}[{i}]-{place}", filter.name),
                    &source,
                    &ONCE,
                    &SCATTERING,
                ));
            }
        }
    }
    // Wavelengths are f32, so difference quotients have no significant digits; `importance.rs` tests their
    // density piece by piece.
    let without = [&SCATTERING[..], &["jacobian"]].concat();
    for (name, visible) in [("wavelengths-visible", true), ("wavelengths-uniform", false)] {
        let source = wrap(move || Ok(validation::chart::Chart(drawn_places::Hero { visible })));
        trials.extend(trials_of(name, &source, &ONCE, &without));
    }
    for (name, source) in warps::sources() {
        trials.extend(trials_of(&format!("warp-{name}"), &source, &ONCE, &SCATTERING));
    }
    trials.retain(|trial| name.is_none_or(|name| trial.name.contains(name)));
    trials
}
