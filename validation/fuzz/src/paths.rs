//! Very many paths through random scenes: none of them may yield a value that is not finite or is negative.

use crate::scenes::grammar;
use crate::scenes::models::Models;
use etalon::render::{Progress, Settings, render};
use etalon::spectrum::ColorMode;
use serde::Serialize;

/// Samples per pixel of each scene.
const SAMPLES: u64 = 1024;

/// Counts of a run.
#[derive(Debug, Default, Serialize)]
pub struct Record {
    pub scenes: u64,
    /// Scenes that the grammar draws and Etalon refuses.
    pub refused: u64,
    pub paths: u64,
    /// Paths that end at the hard limit on vertices.
    pub cut: u64,
    /// Samples whose value is not finite.
    pub not_finite: u64,
    /// Pixels below 0, counted in RGB images with a box filter only: other filters have negative lobes, and
    /// in other colours a sum may be negative.
    pub negative: u64,
    /// The first faulty samples or pixels, with their scene.
    pub first: Vec<String>,
}

/// Renders the scenes from number `first` on until `paths` paths were traced; `told` gets the record after
/// each.
///
/// # Errors
/// If the grammar has a dead end, or a render does not end.
pub fn follow(
    models: &Models,
    folder: &str,
    first: u64,
    paths: u64,
    mut told: impl FnMut(&Record),
) -> Result<Record, String> {
    let mut record = Record::default();
    for number in first.. {
        if record.paths >= paths {
            break;
        }
        let scene = grammar::scene(models, folder, number).ok_or("the grammar has a dead end")?;
        let mode = if scene.mode == "rgb" { ColorMode::Rgb } else { ColorMode::Spectral };
        let Ok(loaded) = etalon::load_text("scene.xml", &scene.text, mode) else {
            record.refused += 1;
            continue;
        };
        let settings = Settings { seed: number as u32, ..Settings::of(&loaded, 0..SAMPLES) };
        let (image, report) = render(&loaded, &settings, &Progress::default()).map_err(|e| e.to_string())?;
        record.scenes += 1;
        record.paths += report.samples;
        record.cut += report.cut;
        record.not_finite += report.non_finite;
        record.first.extend(report.first_non_finite.iter().map(|found| format!("scene {number}: {found:?}")));
        if scene.boxed && scene.mode == "rgb" {
            let colours = image.channels.iter().filter(|c| ["R", "G", "B"].contains(&c.name.as_str()));
            let below = colours.flat_map(|c| &c.mean).filter(|v| **v < 0.0).count() as u64;
            record.negative += below;
            record.first.extend((below > 0).then(|| format!("scene {number}: {below} pixels below 0")));
        }
        told(&record);
    }
    Ok(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_followed_and_nothing_is_found() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../references/scenes");
        let record = follow(&Models::read().unwrap(), folder, 0, 1_000_000, |_| ()).unwrap();
        assert!(record.paths >= 1_000_000 && record.scenes >= 2 && record.first.is_empty(), "{record:?}");
    }
}
