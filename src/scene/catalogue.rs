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
    /// The element: `bsdf`, `shape`, …
    pub kind: &'static str,
    pub name: &'static str,
    pub about: &'static str,
    pub parameters: Vec<Parameter>,
    pub examples: &'static [&'static str],
}

/// All models, by kind and in the order of the registries.
pub fn catalogue() -> Vec<Model> {
    let mut models = vec![];
    collect("integrator", crate::integrator::INTEGRATORS, &mut models);
    collect("sensor", crate::sensor::SENSORS, &mut models);
    collect("film", crate::film::FILMS, &mut models);
    collect("rfilter", crate::film::filter::FILTERS, &mut models);
    collect("sampler", crate::sampler::SAMPLERS, &mut models);
    collect("emitter", crate::emitter::EMITTERS, &mut models);
    collect("shape", crate::shape::SHAPES, &mut models);
    collect("bsdf", crate::bsdf::MATERIALS, &mut models);
    collect("texture", crate::texture::TEXTURES, &mut models);
    models
}

fn collect<T>(kind: &'static str, table: &[Entry<T>], models: &mut Vec<Model>) {
    for entry in table {
        let empty = format!(r#"<{kind} version="3.0.0" type="{}"/>"#, entry.name);
        let mut parameters = asked(entry, &empty).unwrap_or_default();
        for example in entry.examples {
            let versioned = example.replacen(" type=", " version=\"3.0.0\" type=", 1);
            for parameter in asked(entry, &versioned).unwrap_or_default() {
                if !parameters.iter().any(|p: &Parameter| p.name == parameter.name) {
                    parameters.push(parameter);
                }
            }
        }
        models.push(Model {
            kind,
            name: entry.name,
            about: entry.about,
            parameters,
            examples: entry.examples,
        });
    }
}

/// What a model asks for when it is parsed, whether or not it is content with the answers.
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
        fn check<T>(kind: &str, table: &[Entry<T>]) {
            for entry in table {
                for example in entry.examples {
                    let text = example.replacen(" type=", " version=\"3.0.0\" type=", 1);
                    for mode in [ColorMode::Spectral, ColorMode::Rgb] {
                        let document = xml::read_text("example", &text).unwrap();
                        let loader = Loader::new(&document, mode).unwrap();
                        let mut params = Params::new(&document.root, &loader, Usage::Reflectance).unwrap();
                        let parsed = (entry.parse)(&mut params).map(drop).and_then(|()| params.finish());
                        assert!(parsed.is_ok(), "{kind} {}: {}\n{example}", entry.name, parsed.unwrap_err());
                    }
                }
            }
        }
        check("integrator", crate::integrator::INTEGRATORS);
        check("sensor", crate::sensor::SENSORS);
        check("film", crate::film::FILMS);
        check("rfilter", crate::film::filter::FILTERS);
        check("sampler", crate::sampler::SAMPLERS);
        check("emitter", crate::emitter::EMITTERS);
        check("shape", crate::shape::SHAPES);
        check("bsdf", crate::bsdf::MATERIALS);
        check("texture", crate::texture::TEXTURES);
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
