//! `etalon explain`

use super::{Outcome, SceneArguments, say, tax};
use etalon::integrator::Roulette;
use etalon::integrator::kernel_for;
use etalon::sampler::SamplerKind;
use etalon::scene::Features;
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
        let mut materials: Vec<&str> = scene.materials.iter().map(|m| m.name()).collect();
        materials.sort_unstable();
        materials.dedup();
        let mut emitters: Vec<&str> = scene.emitters.list.iter().map(|e| e.emitter.name()).collect();
        emitters.sort_unstable();
        emitters.dedup();
        let path = scene.integrator.path();
        let mut document = serde_json::json!({
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
            "materials": materials,
            "emitters": emitters,
            "light_paths": scene.techniques.light_paths(),
            "links": match &scene.techniques.links {
                None if scene.techniques.guide.is_some() => "guided",
                None => "never",
                Some(links) if links.everywhere => "everywhere",
                // Without light paths, `unaided` is every vertex.
                Some(_) if scene.techniques.caustics.is_none() => "everywhere",
                Some(_) => "unaided",
            },
            "pixels_that_share": scene.integrator.reuse(),
            "samples_count_for": match &scene.sensor.film.spread {
                None => "their own pixel",
                Some(_) => "all pixels that the filter reaches",
            },
            "shared_light_paths": scene.techniques.light_sources.as_ref().map_or(0, |sources| sources.paths),
            "roulette": path.map(|path| match path.roulette {
                Roulette { edges, vertices: u32::MAX, .. } => format!("after {edges} edges"),
                Roulette { edges, vertices, chance } => format!(
                    "after {edges} edges, or {vertices} vertices from the first rough one on; below {} of the throughput",
                    1.0 / chance
                ),
            }),
            "emitter_samples": path.map(|path| [path.first_emitter_samples, path.emitter_samples]),
            "emitter_count": scene.emitters.list.len(),
            "emitter_choice": if scene.emitters.chosen_by_place() { "by place and power" } else { "none" },
            "uses": scene.features().names(),
            "kernel": kernel.name,
            "left_out": left_out.names(),
        });
        let tax = tax::of(&scene, left_out);
        if self.json {
            let tax = tax.into_iter().map(|(feature, percent)| (feature.to_owned(), percent.into()));
            document["tax_percent"] = serde_json::Value::Object(tax.collect());
            say!("{document}");
            return Ok(ExitCode::SUCCESS);
        }
        let width = document.as_object().into_iter().flatten().map(|(key, _)| key.len()).max().unwrap_or(0);
        for (key, value) in document.as_object().into_iter().flatten() {
            let value = match value {
                serde_json::Value::String(text) => text.clone(),
                serde_json::Value::Array(list) if list.is_empty() => "nothing".into(),
                serde_json::Value::Array(list) => {
                    let word = |v: &serde_json::Value| v.as_str().map_or_else(|| v.to_string(), String::from);
                    list.iter().map(word).collect::<Vec<_>>().join(", ")
                }
                serde_json::Value::Null => "none".into(),
                other => other.to_string(),
            };
            say!("{:<width$} {value}", key.replace('_', " "));
        }
        let figure = |(feature, percent): &(&str, Option<f64>)| match percent {
            Some(percent) => format!("{feature} {percent:+.2} %"),
            None => format!("{feature} not measured"),
        };
        let tax: Vec<String> = tax.iter().map(figure).collect();
        say!("{:<width$} {}", "tax", tax.join(", "));
        Ok(ExitCode::SUCCESS)
    }
}
