//! What a checkpoint says of itself before the sums.

use crate::render::Settings;
use crate::render::history::History;
use crate::render::light_path_noise::LightPathNoise;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// All that stands before the sums.
#[derive(Serialize, Deserialize)]
pub struct Head {
    pub identity: Identity,
    /// Samples of every pixel that are in the sums: from the beginning of the range to this one.
    pub done: u64,
    pub rays: u64,
    pub cut: u64,
    pub non_finite: u64,
    /// Column, row, sample.
    pub first_non_finite: Vec<(u32, u32, u64)>,
    pub history: Option<History>,
    pub light_paths: LightPathNoise,
}

/// Everything that decides the image. Two equal ones are the same render; threads and the kernel decide
/// nothing. The version is looked at before all else, for with another one anything else may mean something else.
#[derive(Serialize, Deserialize)]
pub struct Identity {
    version: String,
    seed: u32,
    pub samples: (u64, u64),
    film: (u32, u32),
    /// First column and row, columns, rows.
    window: (u32, u32, u32, u32),
    integrator: String,
    channels: Vec<String>,
    /// Hash of the scene. It covers the seed and the integrator too, so it says the least and comes last.
    scene: String,
}

impl Identity {
    pub fn new(scene: &Scene, settings: &Settings, channels: &[String]) -> Self {
        let w = settings.window;
        Self {
            version: crate::VERSION.into(),
            seed: settings.seed,
            samples: (settings.samples.start, settings.samples.end),
            film: scene.sensor.film.size,
            window: (w.x, w.y, w.width, w.height),
            integrator: scene.integrator.name().into(),
            channels: channels.to_vec(),
            scene: scene.hash.clone(),
        }
    }

    /// The first difference between the checkpoint's render (`self`) and the one that is asked for.
    pub fn difference(&self, asked: &Identity) -> Option<String> {
        let list = |i: &Identity| {
            let (x, y, width, height) = i.window;
            [
                ("seed", i.seed.to_string()),
                ("range of samples", format!("{}..{}", i.samples.0, i.samples.1)),
                ("film", format!("{}x{}", i.film.0, i.film.1)),
                ("crop", format!("{x},{y},{width},{height}")),
                ("integrator", i.integrator.clone()),
                ("list of channels", i.channels.join(" ")),
                ("scene", i.scene.clone()),
            ]
        };
        let pairs = list(self).into_iter().zip(list(asked));
        pairs
            .filter(|(ours, theirs)| ours.1 != theirs.1)
            .map(|((name, ours), (_, theirs))| another(name, &ours, &theirs))
            .next()
    }
}

/// The part of a head that all versions have.
#[derive(Deserialize)]
pub struct OfAnyVersion {
    pub identity: Version,
}

#[derive(Deserialize)]
pub struct Version {
    pub version: String,
}

/// Refuses what is of another version, scene, … than asked for.
pub fn another(name: &str, ours: &str, theirs: &str) -> String {
    format!("it is of another {name}: `{ours}`, and `{theirs}` is asked for")
}
