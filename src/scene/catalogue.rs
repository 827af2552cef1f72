//! Every model with its parameters, read off the registries.
//!
//! A parameter table is not written down anywhere: a model is parsed from an empty element, and what it asks
//! for is its table. A model that refuses the empty element has asked for its required parameter by then.

use super::error::SceneError;
use super::loader::Loader;
use super::params::{Parameter, Params, Usage};
use super::registry::Entry;
use super::xml;
use crate::spectrum::ColorMode;

/// A model as `etalon plugins` shows it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Model {
    /// Tag of the model's element: `bsdf`, `shape`, …
    pub kind: &'static str,
    pub name: &'static str,
    pub about: &'static str,
    pub parameters: Vec<Parameter>,
    pub examples: &'static [&'static str],
}

/// All models, by kind and in the order of the registries.
pub fn catalogue() -> Vec<Model> {
    let mut models = Models(vec![]);
    visit(&mut models);
    models.0
}

/// What is done with every registry, whatever its models become.
trait Visitor {
    fn registry<T>(&mut self, kind: &'static str, table: &[Entry<T>]);
}

fn visit(visitor: &mut impl Visitor) {
    visitor.registry("integrator", crate::integrator::INTEGRATORS);
    visitor.registry("sensor", crate::sensor::SENSORS);
    visitor.registry("film", crate::film::FILMS);
    visitor.registry("rfilter", crate::film::filter::FILTERS);
    visitor.registry("sampler", crate::sampler::SAMPLERS);
    visitor.registry("emitter", crate::emitter::EMITTERS);
    visitor.registry("shape", crate::shape::SHAPES);
    visitor.registry("bsdf", crate::bsdf::MATERIALS);
    visitor.registry("medium", crate::medium::MEDIA);
    visitor.registry("phase", crate::phase::PHASES);
    visitor.registry("texture", crate::texture::TEXTURES);
    visitor.registry("volume", crate::volume::VOLUMES);
}

struct Models(Vec<Model>);

impl Visitor for Models {
    fn registry<T>(&mut self, kind: &'static str, table: &[Entry<T>]) {
        for entry in table {
            let empty = format!(r#"<{kind} version="3.0.0" type="{}"/>"#, entry.name);
            let mut parameters = asked(entry, &empty).unwrap_or_default();
            for example in entry.examples {
                for parameter in asked(entry, &versioned(example)).unwrap_or_default() {
                    if !parameters.iter().any(|p: &Parameter| p.name == parameter.name) {
                        parameters.push(parameter);
                    }
                }
            }
            let Entry { name, about, examples, .. } = *entry;
            self.0.push(Model { kind, name, about, parameters, examples });
        }
    }
}

/// An example as the root of a document.
pub(crate) fn versioned(example: &str) -> String {
    example.replacen(" type=", " version=\"3.0.0\" type=", 1)
}

/// The parameters that a model asks for when it is parsed, whether or not that succeeds.
fn asked<T>(entry: &Entry<T>, text: &str) -> Result<Vec<Parameter>, SceneError> {
    let document = xml::read_text("example", text)?;
    let loader = Loader::new(&document, ColorMode::Spectral)?;
    let mut params = Params::new(&document.root, &loader, Usage::Reflectance)?;
    drop((entry.parse)(&mut params));
    Ok(params.asked().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_of_every_model_is_accepted() {
        struct Checked(usize);
        impl Visitor for Checked {
            fn registry<T>(&mut self, kind: &'static str, table: &[Entry<T>]) {
                let all = table.iter().flat_map(|entry| entry.examples.iter().map(move |e| (entry, e)));
                for (entry, example) in all {
                    for mode in [ColorMode::Spectral, ColorMode::Rgb] {
                        let document = xml::read_text("example", &versioned(example)).unwrap();
                        let loader = Loader::new(&document, mode).unwrap();
                        let mut params = Params::new(&document.root, &loader, Usage::Reflectance).unwrap();
                        let parsed = (entry.parse)(&mut params).map(drop).and_then(|()| params.finish());
                        assert!(parsed.is_ok(), "{kind} {}: {}\n{example}", entry.name, parsed.unwrap_err());
                        self.0 += 1;
                    }
                }
            }
        }
        let mut checked = Checked(0);
        visit(&mut checked);
        assert!(checked.0 > 100, "{}", checked.0);
    }

    #[test]
    fn parameters_are_found_without_being_listed() {
        let models = catalogue();
        let sphere = models.iter().find(|m| m.kind == "shape" && m.name == "sphere").unwrap();
        let names: Vec<&str> = sphere.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names, ["to_world", "flip_normals", "center", "radius"]);
    }

    #[test]
    fn what_stands_for_none_is_no_default() {
        let models = catalogue();
        let path = models.iter().find(|m| m.kind == "integrator" && m.name == "path").unwrap();
        let default = |name| &path.parameters.iter().find(|p| p.name == name).unwrap().default;
        assert_eq!(["emitter_samples", "first_emitter_samples"].map(default), ["1", "none"]);
    }
}
