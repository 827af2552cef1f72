//! The arguments that say what is rendered.

use super::size;
use super::words::{Words, shown};
use clap::builder::PossibleValuesParser;
use etalon::integrator::INTEGRATORS;
use etalon::integrator::links::LinkPolicy;
use etalon::integrator::path::reuse::{AUTO, PIXELS};
use etalon::sampler::SAMPLERS;
use etalon::sampler::blocks::MOST_SHARED_LIGHT_PATHS;
use etalon::scene::registry::Entry;
use etalon::scene::{self, Scene};
use etalon::spectrum::ColorMode;
use std::collections::BTreeSet;
use std::error::Error;
use std::path::PathBuf;

/// Arguments that name a scene and override its settings.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// Mitsuba 3 scene file
    pub scene: PathBuf,
    /// Value of a `$parameter` of the scene; may be repeated
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = definition)]
    define: Vec<(String, String)>,
    /// What a path carries
    #[arg(long, value_name = "spectral|rgb", default_value = "spectral")]
    color: ColorMode,
    /// Integrator to use instead of the scene's, with its default settings
    #[arg(long, value_name = "NAME", value_parser = integrator())]
    integrator: Option<String>,
    /// Edges of the longest path, instead of the scene's; -1 means no limit
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(i64).range(-1..=i64::from(u32::MAX)))]
    max_depth: Option<i64>,
    /// Light paths to a camera path, to find caustics; 0 leaves all to camera paths
    #[arg(long, value_name = "SHARE", value_parser = light_paths)]
    light_paths: Option<f64>,
    /// Neighbouring pixels that share what their paths find: a power of two up to 64, or `auto`, with which
    /// samples also count for all pixels that the filter reaches, and roulette begins earlier; less noise, but
    /// no longer independent
    #[arg(long, value_name = "PIXELS", value_parser = reuse)]
    reuse: Option<u32>,
    /// Light paths per group of sharing pixels, at most one per pixel; they find light that all of the group
    /// can use
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_SHARED_LIGHT_PATHS)))]
    shared_light_paths: Option<u32>,
    /// Where emitters are sampled through glass and by mirrors; `unaided`: where light paths cannot help;
    /// `guided`: there, along ways that these have shown
    #[arg(long, value_name = "WHERE", value_parser = LinkPolicy::ALL.map(|(name, _)| name))]
    links: Option<String>,
    /// Which of the scene's sensors, counted from 0, instead of the first
    #[arg(long, value_name = "N")]
    sensor: Option<usize>,
    /// Size of the film instead of the scene's, such as 640x480; all of it is rendered, whatever crop the
    /// scene has
    #[arg(long, value_name = "WxH", value_parser = size::parse_size)]
    size: Option<(u32, u32)>,
    /// Sampler to use instead of the scene's
    #[arg(long, value_name = "NAME", value_parser = one_of(SAMPLERS))]
    sampler: Option<String>,
    /// Another seed, another noise; 0 by default, or the scene's
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(..))]
    seed: Option<u32>,
}

impl SceneArguments {
    /// Reads the scene by so many threads; 0 means one for each processor.
    pub fn load(&self, threads: usize) -> Result<Scene, Box<dyn Error>> {
        let overrides = scene::Overrides {
            integrator: self.integrator.clone(),
            max_depth: self.max_depth,
            sensor: self.sensor,
            size: self.size,
            seed: self.seed,
            sampler: self.sampler.clone(),
            light_paths: self.light_paths,
            reuse: self.reuse,
            shared_light_paths: self.shared_light_paths,
            links: self.links.clone(),
        };
        if let Some(twice) = self.repeated_definition() {
            return Err(format!("-D {twice} is given twice").into());
        }
        let load = || etalon::load(&self.scene, &self.define, self.color, &overrides);
        Ok(etalon::render::with_threads(threads, load)??)
    }

    /// A parameter of the scene that has two values.
    fn repeated_definition(&self) -> Option<&str> {
        let mut seen = BTreeSet::new();
        self.define.iter().map(|(name, _)| name.as_str()).find(|name| !seen.insert(*name))
    }

    /// Arguments of a command line that give the same scene.
    pub fn words(&self) -> Words {
        // All of them, so that none can be forgotten.
        let Self {
            scene,
            define,
            color,
            integrator,
            max_depth,
            light_paths,
            reuse,
            shared_light_paths,
            links,
            sensor,
            size,
            sampler,
            seed,
        } = self;
        let mut words = Words::default();
        words.push(shown(scene));
        define.iter().for_each(|(name, value)| words.option("-D", Some(format!("{name}={value}"))));
        words.option("--color", Some(color.name()).filter(|_| *color != ColorMode::Spectral));
        words.option("--integrator", integrator.as_ref());
        words.option("--max-depth", *max_depth);
        words.option("--light-paths", *light_paths);
        words.option(
            "--reuse",
            reuse.map(|pixels| if pixels == AUTO { "auto".into() } else { pixels.to_string() }),
        );
        words.option("--shared-light-paths", *shared_light_paths);
        words.option("--links", links.as_ref());
        words.option("--sensor", *sensor);
        words.option("--size", size.map(|(width, height)| format!("{width}x{height}")));
        words.option("--sampler", sampler.as_ref());
        words.option("--seed", *seed);
        words
    }
}

/// Takes the name of an integrator that needs nothing to be said of it.
fn integrator() -> PossibleValuesParser {
    let alone = |name: &str| format!("<integrator type=\"{name}\"/>");
    let all = INTEGRATORS.iter().filter(|entry| entry.examples.contains(&alone(entry.name).as_str()));
    all.map(|entry| entry.name).collect::<Vec<_>>().into()
}

/// Takes the name of a model.
fn one_of<T>(models: &'static [Entry<T>]) -> PossibleValuesParser {
    models.iter().map(|model| model.name).collect::<Vec<_>>().into()
}

fn definition(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    if name.is_empty() { Err("expected a name before `=`".into()) } else { Ok((name.into(), value.into())) }
}

fn light_paths(text: &str) -> Result<f64, String> {
    let range = etalon::integrator::path::RATIOS;
    let share = text.parse().ok().filter(|share| range.contains(share));
    share.ok_or_else(|| format!("expected a number from {} to {}", range.start(), range.end()))
}

fn reuse(text: &str) -> Result<u32, String> {
    if text == "auto" {
        return Ok(AUTO);
    }
    let pixels = text.parse().ok().filter(|pixels| PIXELS.contains(pixels));
    pixels.ok_or_else(|| "expected a power of two up to 64, or `auto`".into())
}
