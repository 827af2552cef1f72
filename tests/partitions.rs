//! However a render is divided by samples and by crop windows, and in whatever order the parts are merged,
//! the bits must be the same.

mod scenes;

use etalon::film::BLOCK;
use etalon::film::Window;
use etalon::image::{Image, merge};
use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::scene::Scene;
use proptest::prelude::*;
use scenes::{SCENES, Units};
use std::ops::Range;
use std::path::PathBuf;

/// A box in (column, row, sample).
type Part = (Window, Range<u64>);

/// Divides a box at random places along random axes.
fn divide((window, samples): Part, cuts: &mut impl Iterator<Item = (u8, f64)>, depth: u32) -> Vec<Part> {
    let Some((axis, place)) = cuts.next().filter(|_| depth > 0) else { return vec![(window, samples)] };
    let within = |length: u64| 1 + (place * (length - 1) as f64) as u64;
    let w = window;
    let halves = match axis % 3 {
        0 if w.width > 1 => {
            let left = within(u64::from(w.width)) as u32;
            let right = Window { x: w.x + left, width: w.width - left, ..w };
            [(Window { width: left, ..w }, samples.clone()), (right, samples)]
        }
        1 if w.height > 1 => {
            let top = within(u64::from(w.height)) as u32;
            let bottom = Window { y: w.y + top, height: w.height - top, ..w };
            [(Window { height: top, ..w }, samples.clone()), (bottom, samples)]
        }
        2 if samples.end - samples.start > BLOCK => {
            let blocks = (samples.end - samples.start).div_ceil(BLOCK);
            let middle = samples.start + BLOCK * within(blocks);
            [(w, samples.start..middle.min(samples.end)), (w, middle.min(samples.end)..samples.end)]
        }
        _ => return vec![(window, samples)],
    };
    let parts = halves.into_iter().filter(|(_, samples)| !samples.is_empty());
    parts.flat_map(|part| divide(part, cuts, depth - 1)).collect()
}

fn part(scene: &Scene, (window, samples): Part) -> Image {
    let settings = Settings { window, shard: true, ..Settings::of(scene, samples) };
    render(scene, &settings, &Progress::default()).unwrap().0
}

/// The bits of means, variances and exact sums.
fn bits(image: &Image) -> (Vec<Vec<u32>>, String) {
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<u32>>();
    let variance = |c: &etalon::image::Channel| bits(c.variance.as_deref().unwrap_or_default());
    let channels = image.channels.iter().flat_map(|c| [bits(&c.mean), variance(c)]).collect();
    (channels, format!("{:?}", image.accumulators))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_partition_in_any_order_is_the_whole(
        number in 0..SCENES.len(),
        end in 5u64..30,
        cuts in proptest::collection::vec((any::<u8>(), 0.0..1.0), 1..12),
        keys in proptest::collection::vec(any::<u32>(), 64),
    ) {
        let trial = &SCENES[number];
        let scene = load_text("scene.xml", &trial.text(Units::default()), trial.mode).unwrap();
        let whole = (scene.sensor.film.crop, 0..end);
        let mut parts = divide(whole.clone(), &mut cuts.into_iter(), 5);
        let mut order: Vec<(u32, Part)> = keys.into_iter().cycle().zip(parts.drain(..)).collect();
        order.sort_by_key(|(key, _)| *key);
        let count = order.len();
        let images = order.into_iter().map(|(_, p)| (PathBuf::from("part"), part(&scene, p)));
        let merged = merge(images.collect()).unwrap_or_else(|e| panic!("{e}"));
        prop_assert!(bits(&merged) == bits(&part(&scene, whole)), "{} in {count} parts", trial.name);
    }
}
