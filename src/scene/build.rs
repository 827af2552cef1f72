//! From a document to a [`Scene`].

use super::error::{SceneError, Span, known};
use super::hash::hash;
use super::loader::Loader;
use super::objects::Objects;
use super::owners::Owners;
use super::params::Usage;
use super::registry::construct;
use super::xml::{self, Document, Element};
use super::{Features, Overrides, Scene, lamps, overrides};
use crate::bsdf::Traits;
use crate::emitter::Emitters;
use crate::film::filter::FILTERS;
use crate::film::{FILMS, Film};
use crate::image::check_names;
use crate::integrator::caustics::Caustics;
use crate::integrator::links::{LinkPolicy, Links};
use crate::integrator::{AnyIntegrator, INTEGRATORS, Techniques};
use crate::phase::PHASES;
use crate::sampler::SAMPLERS;
use crate::sensor::{Optics, Sensor};
use crate::shape::Geometry;
use crate::shape::accel::Accel;
use crate::spectrum::ColorMode;
use crate::texture::AnyTexture;
use crate::volume::VOLUMES;
use std::path::Path;
use std::time::Duration;

/// Checks that a file can hold all channels of the image. Models have checked their own; this is about those
/// of film and integrator together.
fn check_channels(film: &Film, integrator: &AnyIntegrator, place: &Span) -> Result<(), SceneError> {
    let names = integrator.channel_names(film);
    check_names(&names).map_err(|(index, why)| {
        let of_film = index < names.len() - integrator.extra_channels().len();
        let band = film.bands.iter().rfind(|band| of_film && band.channel == names[index]);
        SceneError::at(band.map_or(place, |band| &band.place), why, "expected another name")
    })
}

/// Tags of the elements of a scene.
const TOP_LEVEL: [&str; 13] = [
    "shape",
    "emitter",
    "sensor",
    "integrator",
    "bsdf",
    "medium",
    "phase",
    "texture",
    "volume",
    "spectrum",
    "film",
    "rfilter",
    "sampler",
];

/// Parameters of a scene about Mitsuba's acceleration structures; ignored.
const OF_SEARCHES: [&str; 12] = [
    "allow_thread_reordering",
    "compact_acceleration_structures",
    "embree_use_robust_intersections",
    "kd_clip",
    "kd_empty_space_bonus",
    "kd_exact_primitive_threshold",
    "kd_intersection_cost",
    "kd_max_depth",
    "kd_min_max_bins",
    "kd_retract_bad_splits",
    "kd_stop_prims",
    "kd_traversal_cost",
];

/// Reads a scene file, but settles nothing that it leaves open: [`crate::load`] does. `definitions` are values for
/// its `$parameters`.
///
/// # Errors
/// As [`crate::load`] has them.
pub fn read(
    path: &Path,
    definitions: &[(String, String)],
    mode: ColorMode,
    overrides: &Overrides,
) -> Result<Scene, SceneError> {
    let mut document = xml::read(path, definitions)?;
    // What overrides add would be missed elsewhere.
    check_root(&document.root)?;
    overrides::apply(&mut document, overrides)?;
    build(&document, mode)
}

/// The same from text, as if it stood in a file called `name`.
///
/// # Errors
/// As [`crate::load`] has them.
pub fn read_text(name: &str, text: &str, mode: ColorMode) -> Result<Scene, SceneError> {
    let document = xml::read_text(name, text)?;
    check_root(&document.root)?;
    build(&document, mode)
}

/// What a document declares, read but not yet put together.
struct Declared<'a, 'd> {
    objects: Objects<'a, 'd>,
    sensor: Sensor,
    integrator: AnyIntegrator,
}

fn build(document: &Document, mode: ColorMode) -> Result<Scene, SceneError> {
    let loader = Loader::new(document, mode)?;
    let Declared { objects, sensor, integrator } = declared(&document.root, &loader)?;
    let hash = hash(document, &loader, mode)?;
    let files = [&document.files[..], &loader.files()].concat();
    Ok(Scene { hash, files, ..assemble(objects, sensor, integrator, mode) })
}

fn check_root(root: &Element) -> Result<(), SceneError> {
    if root.tag != "scene" {
        return Err(SceneError::at(&root.span, format!("the root is a <{}>", root.tag), "expected <scene>"));
    }
    Ok(())
}

/// Reads the elements of a scene.
fn declared<'a, 'd>(root: &'d Element, loader: &'a Loader<'d>) -> Result<Declared<'a, 'd>, SceneError> {
    root.only(&["version", "type", "id", "name"])?;
    let mut objects = Objects::new(loader);
    let (mut sensors, mut integrators) = (vec![], vec![]);
    for child in &root.children {
        let element = loader.resolve(child)?;
        match element.tag.as_str() {
            "shape" => sensors.extend(objects.shape(element)?),
            "emitter" => objects.emitter(element)?,
            "sensor" => sensors.push(Sensor::parse(element, loader)?),
            "integrator" => integrators.push(element),
            // Read where they are referred to, and here for the sake of their errors.
            // What has attributes of a mesh is read where a mesh has it.
            "bsdf" | "texture" | "spectrum" if loader.needs_chart(element)? => {}
            "bsdf" => {
                objects.material(element)?;
            }
            "spectrum" if element.attribute("type").is_none() => {
                let message = "a <spectrum> that is a value has no place here";
                return Err(SceneError::at(
                    &element.span,
                    message,
                    "expected it within an object, or with a `type`",
                ));
            }
            "texture" | "spectrum" => {
                AnyTexture::parse(element, loader, Usage::Any)?;
            }
            "medium" => loader.medium(element).map(drop)?,
            "phase" => construct(PHASES, element, loader, Usage::Unbounded).map(drop)?,
            "volume" => construct(VOLUMES, element, loader, Usage::Any).map(drop)?,
            "film" => construct(FILMS, element, loader, Usage::Unbounded).map(drop)?,
            "rfilter" => construct(FILTERS, element, loader, Usage::Unbounded).map(drop)?,
            "sampler" => construct(SAMPLERS, element, loader, Usage::Unbounded).map(drop)?,
            "boolean" | "integer" | "float" if element.name().is_some_and(|n| OF_SEARCHES.contains(&n)) => {
                element.only(&["name", "value"])?;
                element.require("value")?;
            }
            other => {
                return Err(SceneError::at(
                    &element.span,
                    format!("<{other}> has no place here"),
                    known(other, &TOP_LEVEL),
                ));
            }
        }
    }
    // The first is used, as in Mitsuba.
    let sensor = sensors.into_iter().next();
    let sensor =
        sensor.ok_or_else(|| SceneError::at(&root.span, "the scene has no sensor", "add a <sensor>"))?;
    let integrator = match integrators[..] {
        [] => AnyIntegrator::default(),
        [one] => construct(INTEGRATORS, one, loader, Usage::Unbounded)?,
        [_, second, ..] => {
            return Err(SceneError::at(&second.span, "a second integrator", "expected only one"));
        }
    };
    let integrator = if media_matter(&objects, &sensor) { integrator } else { integrator.without_media() };
    let place = integrators.first().map_or(&root.span, |one| &one.span);
    check_channels(&sensor.film, &integrator, place)?;
    Ok(Declared { objects, sensor, integrator })
}

/// Puts together what was read: with all techniques that its integrator allows, before pilots choose among
/// them.
fn assemble(mut objects: Objects, mut sensor: Sensor, integrator: AnyIntegrator, mode: ColorMode) -> Scene {
    let features = features(&objects, &integrator);
    let choosing = |traits: Traits| traits.has_density && !traits.one_lobe;
    let several_lobes = objects.sides().any(choosing);
    let trees = objects.instances.trees();
    lamps::raise(&mut objects.shapes, &objects.instances);
    let geometries: Vec<&Geometry> = objects.shapes.iter().map(|s| &s.geometry).collect();
    let accel = Accel::with_instances(&geometries, trees);
    sensor.camera.look_at(accel.bounds());
    let Objects { shapes, instances, materials, emitters, .. } = &mut objects;
    let emitters = Emitters::new(std::mem::take(emitters), |i| &shapes[i as usize].geometry);
    let (shapes, materials) = (std::mem::take(shapes), std::mem::take(materials));
    let owners = Owners::new(shapes.iter().map(|s| s.geometry.primitives()));
    let instances = std::mem::take(instances).after(shapes.iter().map(|s| s.geometry.primitives()).sum());
    let caustics = Caustics::plan(&integrator, &sensor, &shapes, &instances, &emitters);
    let wanted = integrator.path().map_or(LinkPolicy::Never, |path| path.links);
    let mut links = Links::of(&shapes, &materials, mode)
        .filter(|_| !matches!(wanted, LinkPolicy::Never | LinkPolicy::Guided));
    links.iter_mut().for_each(|links| links.everywhere = wanted == LinkPolicy::Everywhere);
    Scene {
        shapes,
        owners,
        instances,
        materials,
        emitters,
        accel,
        sensor,
        integrator,
        techniques: Techniques { caustics, links, ..Techniques::default() },
        mode,
        features,
        several_lobes,
        planning: Duration::ZERO,
        hash: String::new(),
        files: vec![],
    }
}

/// Whether light goes through media, or straight through surfaces.
fn media_matter(objects: &Objects, sensor: &Sensor) -> bool {
    sensor.medium.is_some()
        || objects.sides().any(|traits| traits.has_null)
        || objects.surfaces().any(|shape| shape.interface.is_some())
}

/// The features that a kernel for the scene needs.
fn features(objects: &Objects, integrator: &AnyIntegrator) -> Features {
    let mut bits = 0;
    for traits in objects.sides() {
        bits |= if traits.textured { Features::TEXTURES } else { 0 };
        bits |= if traits.anisotropic { Features::TEXTURES | Features::ANISOTROPY } else { 0 };
        bits |= if traits.dispersive { Features::DISPERSION } else { 0 };
    }
    for entry in &objects.emitters {
        bits |= if entry.emitter.varies() { Features::TEXTURES } else { 0 };
        bits |= if entry.emitter.is_environment() { Features::ENVIRONMENT } else { 0 };
    }
    bits |= if integrator.needs_uv() { Features::TEXTURES } else { 0 };
    bits |= if objects.instances.is_empty() { 0 } else { Features::INSTANCES };
    Features(bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_says_how_mitsuba_works_is_ignored() {
        let of_integrators = r#"<boolean name="hide_emitters" value="true"/><float name="timeout" value="5"/>
            <integer name="block_size" value="16"/><integer name="samples_per_pass" value="4"/>"#;
        let (aovs, path) = (r#"<string name="aovs" value="d:depth"/>"#, r#"<integrator type="path"/>"#);
        for (kind, within) in [("path", ""), ("direct", ""), ("depth", ""), ("aov", aovs), ("moment", path)] {
            let text = format!(
                r#"<scene version="3.0.0"><boolean name="allow_thread_reordering" value="false"/>
                <integer name="kd_max_depth" value="9"/><float name="kd_traversal_cost" value="1.5"/>
                <integrator type="{kind}">{of_integrators}{within}</integrator>
                <sensor type="perspective"><sampler type="orthogonal"><integer name="strength" value="3"/></sampler></sensor>
                <shape type="cube"><boolean name="face_normals" value="true"/></shape>
                <shape type="rectangle"><boolean name="face_normals" value="true"/></shape></scene>"#
            );
            let loaded = read_text("scene.xml", &text, ColorMode::Rgb).map(drop);
            assert!(loaded.is_ok(), "{kind}: {}", loaded.unwrap_err());
        }
    }

    #[test]
    fn materials_that_nothing_is_made_of_decide_nothing() {
        let text = |unused: &str| {
            format!(
                r#"<scene version="3.0.0"><integrator type="volpath"/><sensor type="perspective"/>{unused}
                <shape type="sphere"/></scene>"#
            )
        };
        let load = |unused: &str| read_text("scene.xml", &text(unused), ColorMode::Spectral).unwrap();
        let null = r#"<bsdf type="null" id="null"/>"#;
        let glass = r#"<bsdf type="dielectric" id="glass"><string name="dispersion" value="BK7"/></bsdf>"#;
        for unused in [null, glass] {
            let scene = load(unused);
            assert_eq!((scene.features(), scene.several_lobes), (load("").features(), false), "{unused}");
            assert_eq!(scene.integrator.name(), "path", "{unused}");
        }
    }
}
