//! `etalon explain`

use super::scene_arguments::SceneArguments;
use super::{Outcome, say, tax};
use etalon::integrator::{KernelEntry, Roulette, kernel_for};
use etalon::sampler::SamplerKind;
use etalon::scene::{Features, Scene};
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::ExitCode;

/// Says what a scene uses, what is left out, and which kernel runs
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Print a JSON document
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        let scene = self.scene.load(0)?;
        let kernel = kernel_for(scene.features());
        let left_out = Features(Features::ALL).without(kernel.features);
        let mut document = describe(&scene, kernel, left_out);
        let tax = tax::of(&scene, left_out);
        if self.json {
            let tax = tax.into_iter().map(|(feature, percent)| (feature.to_owned(), percent.into()));
            document["tax_percent"] = Value::Object(tax.collect());
            say!("{document}");
        } else {
            let figure = |(feature, percent): &(&str, Option<f64>)| match percent {
                Some(percent) => format!("{feature} {percent:+.2} %"),
                None => format!("{feature} not measured"),
            };
            let tax: Vec<String> = tax.iter().map(figure).collect();
            document["tax"] = tax.into();
            for line in lines(&document) {
                say!("{line}");
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// What a scene is and how it is rendered, by key.
fn describe(scene: &Scene, kernel: &KernelEntry, left_out: Features) -> Value {
    let path = scene.integrator.path();
    serde_json::json!({
        "scene_hash": scene.hash,
        "color": scene.mode.name(),
        "integrator": scene.integrator.name(),
        "sensor": scene.sensor.camera.name(),
        "sampler": match scene.sensor.sampler.kind {
            SamplerKind::Independent => "independent; with --sampler sobol there is less noise",
            SamplerKind::Sobol => "sobol",
        },
        "film": [scene.sensor.film.size.0, scene.sensor.film.size.1],
        "shapes": scene.shapes.len(),
        "instances": scene.instances.len(),
        "primitives": scene.accel.primitives(),
        "search": match (scene.accel.node_count(), scene.accel.tries_beside_tree()) {
            (0, _) => "none: every block is tried",
            (_, true) => "tree of eight-wide nodes; all but triangles is tried",
            (_, false) => "tree of eight-wide nodes",
        },
        "nodes": scene.accel.node_count(),
        "geometry_bytes": scene.geometry_bytes(),
        "materials": sorted_names(scene.materials.iter().map(|material| material.name())),
        "emitters": sorted_names(scene.emitters.list.iter().map(|listed| listed.emitter.name())),
        "light_paths": scene.techniques.light_paths(),
        "links": links(scene),
        "pixels_that_share": scene.integrator.reuse(),
        "samples_count_for": match &scene.sensor.film.spread {
            None => "their own pixel",
            Some(_) => "all pixels that the filter reaches",
        },
        "shared_light_paths": scene.techniques.light_sources.as_ref().map_or(0, |sources| sources.paths),
        "roulette": path.map(|path| roulette(&path.roulette)),
        "emitter_samples": path.map(|path| [path.first_emitter_samples, path.emitter_samples]),
        "emitter_count": scene.emitters.list.len(),
        "emitter_choice": if scene.emitters.chosen_by_place() { "by place and power" } else { "none" },
        "uses": scene.features().names(),
        "kernel": kernel.name,
        "left_out": left_out.names(),
    })
}

/// Each name once, in alphabetical order.
fn sorted_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    names.collect::<BTreeSet<_>>().into_iter().collect()
}

/// Which vertices look for emitters through glass and by mirrors.
fn links(scene: &Scene) -> &'static str {
    let techniques = &scene.techniques;
    match &techniques.links {
        None if techniques.guide.is_some() => "guided",
        None => "never",
        Some(links) if links.everywhere => "everywhere",
        // Without light paths, `unaided` is every vertex.
        Some(_) if techniques.caustics.is_none() => "everywhere",
        Some(_) => "unaided",
    }
}

fn roulette(roulette: &Roulette) -> String {
    match *roulette {
        Roulette { edges, vertices: u32::MAX, .. } => format!("after {edges} edges"),
        Roulette { edges, vertices, chance } => format!(
            "after {edges} edges, or {vertices} vertices from the first rough one on; below {} of the throughput",
            1.0 / chance
        ),
    }
}

/// A line for each entry, with the values below each other.
fn lines(document: &Value) -> Vec<String> {
    let entries: Vec<(&String, &Value)> = document.as_object().into_iter().flatten().collect();
    let width = entries.iter().map(|(key, _)| key.len()).max().unwrap_or(0);
    entries
        .iter()
        .map(|(key, value)| format!("{:<width$} {}", key.replace('_', " "), in_words(value)))
        .collect()
}

fn in_words(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        Value::Array(list) if list.is_empty() => "nothing".into(),
        Value::Array(list) => list.iter().map(in_words).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}
