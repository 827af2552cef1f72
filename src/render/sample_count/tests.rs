use super::*;
use crate::load_text;
use crate::render::{RenderError, render};
use crate::spectrum::ColorMode;

fn scene(content: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="3"/></integrator>
        <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="18"/></film></sensor>
        {content}</scene>"#
    );
    load_text("scene.xml", &text, ColorMode::Spectral).expect("it loads")
}

const LIT: &str = r#"<emitter type="constant"/>
    <shape type="sphere"><transform name="to_world"><translate z="4"/></transform></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="2"/><translate x="2" y="2" z="8"/></transform>
      <emitter type="area"><rgb name="radiance" value="4"/></emitter></shape>"#;

fn settings(scene: &Scene, seed: u32) -> Settings {
    Settings { seed, ..Settings::of(scene, 0..BLOCK) }
}

/// What `etalon render` prints of an image.
fn printed(scene: &Scene, settings: &Settings) -> Quality {
    let (image, report) = render(scene, settings, &Progress::default()).expect("it renders");
    let quality = report.quality.expect("it is known");
    let of_image = Quality::of_image(&image);
    let [a, b] = [quality, of_image].map(|quality| quality.relative_standard_error_of_mean);
    assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    quality
}

/// A file holds variances in single precision, which ends at 10⁻⁴⁵ and 10³⁸: light of 10⁻²⁵ has smaller ones
/// and light of 10²⁵ larger ones.
#[test]
fn errors_are_known_of_the_dimmest_and_of_the_brightest_light() {
    let of = |power: i32, shared: &str, shard: bool| {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="3"/>{shared}</integrator>
            <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="18"/></film></sensor>
            <shape type="sphere"><transform name="to_world"><translate z="4"/></transform></shape>
            <emitter type="point"><rgb name="intensity" value="{}"/><point name="position" x="2" y="3" z="-1"/></emitter></scene>"#,
            libm::exp2(f64::from(power))
        );
        let scene = load_text("scene.xml", &text, ColorMode::Spectral).expect("it loads");
        let settings = Settings { samples: 0..4 * BLOCK, shard, ..settings(&scene, 0) };
        let (_, report) = render(&scene, &settings, &Progress::default()).expect("it renders");
        let Quality { relative_standard_error, relative_standard_error_of_mean, effective_pixels, .. } =
            report.quality.expect("it is known");
        [relative_standard_error, relative_standard_error_of_mean, effective_pixels]
    };
    for (shared, shard) in [("", false), ("", true), (r#"<integer name="reuse" value="16"/>"#, false)] {
        let known = of(0, shared, shard);
        assert!(known.iter().all(|v| v.is_finite() && *v > 0.0), "{known:?}");
        // Powers of two change no digit.
        assert_eq!([of(-84, shared, shard), of(84, shared, shard)], [known, known]);
    }
}

#[test]
fn the_error_asked_for_is_attained() {
    let scene = scene(LIT);
    // With a chance of 95 % each, fewer than 50 of 60 come once in 3000 times.
    let (runs, target) = (60, 0.001);
    let mut counts = vec![];
    let attained = (0..runs).filter(|&seed| {
        let settings = settings(&scene, seed);
        let pilot = for_error(&scene, &settings, target, &Progress::default()).expect("a count");
        assert_eq!(pilot.count % BLOCK, 0);
        assert!(!pilot.quality.heavy_tailed());
        counts.push(pilot.count);
        let quality = printed(&scene, &Settings { samples: 0..pilot.count, ..settings });
        // Nor is far more rendered than is needed: half the error is four times the samples.
        assert!(quality.relative_standard_error_of_mean > target / 2.0, "{quality:?}");
        quality.relative_standard_error_of_mean <= target
    });
    let attained = attained.count();
    assert!(attained >= 50, "{attained} of {runs}");
    // The pilot does not know the image's samples, but it is a function of the seed.
    assert!(counts.iter().any(|&c| c != counts[0]));
    let again = for_error(&scene, &settings(&scene, 0), target, &Progress::default());
    assert_eq!(again.map(|pilot| pilot.count), Ok(counts[0]));
}

#[test]
fn a_smaller_error_needs_quadratically_more_samples() {
    let scene = scene(LIT);
    let count = |target| {
        let pilot = for_error(&scene, &settings(&scene, 1), target, &Progress::default());
        pilot.expect("a count").count as f64
    };
    let ratio = count(0.0005) / count(0.001);
    // The margin differs, by what the two pilots know: at most 1 + 2 √(2 r² + 4 R²), and not below 1.
    assert!(ratio > 3.0 && ratio < 5.3, "{ratio}");
}

#[test]
fn what_has_no_error_has_no_count() {
    let black = scene("");
    let asked = |scene: &Scene, target| {
        for_error(scene, &settings(scene, 0), target, &Progress::default()).map(|pilot| pilot.count)
    };
    assert_eq!(asked(&black, 0.01), Err(NoCount::Black));
    assert_eq!(asked(&scene(LIT), 1e-12), Err(NoCount::TooMany));
    let stopped = Progress::default();
    stopped.stop.store(true, std::sync::atomic::Ordering::Relaxed);
    let scene = scene(LIT);
    let pilot = for_error(&scene, &settings(&scene, 0), 0.01, &stopped);
    assert_eq!(pilot.map(|pilot| pilot.count), Err(NoCount::Unfinished(RenderError::Stopped)));
}

#[test]
fn the_image_draws_other_samples_than_the_pilot() {
    let scene = scene(LIT);
    let settings = settings(&scene, 0);
    let pilot = for_error(&scene, &settings, 0.01, &Progress::default()).expect("a count");
    let image = printed(&scene, &Settings { samples: 0..pilot.samples, ..settings });
    // The same samples would have the same mean, but for its rounding to single precision.
    let apart = (image.mean[1] / pilot.quality.mean[1] - 1.0).abs();
    assert!(apart > 1e-5, "{apart}");
}

#[test]
fn the_pilots_time_is_part_of_the_time() {
    // Half a second of ten for 8 samples: 152 more are as dear.
    assert_eq!(affordable(8, 0.5, 10.0), 152);
    assert_eq!(
        [affordable(8, 0.75, 10.0), affordable(8, 9.0, 10.0), affordable(8, 11.0, 10.0)],
        [96, BLOCK, BLOCK]
    );
    assert_eq!(affordable(MOST, 1.0, 1e9), MOST);
}

#[test]
fn a_time_becomes_whole_blocks() {
    let scene = scene(LIT);
    for seconds in [1e-9, 0.05] {
        let pilot = for_time(&scene, &settings(&scene, 0), seconds, &Progress::default()).expect("a count");
        assert!(pilot.count >= BLOCK && pilot.count.is_multiple_of(BLOCK));
    }
}

#[test]
fn the_count_is_that_of_the_last_look_with_its_margin() {
    let scene = scene(LIT);
    for (seed, target) in [(0, 0.0003), (1, 0.0002), (2, 0.0001), (3, 0.0001)] {
        let pilot =
            for_error(&scene, &settings(&scene, seed), target, &Progress::default()).expect("a count");
        let relative = pilot.quality.relative_standard_error_of_mean;
        let n = pilot.samples as f64;
        let plain = n * (relative / target).powi(2);
        let r2 = 1.0 / pilot.quality.effective_pixels;
        let margin = 2.0 * (r2 * (1.0 + (n / plain).min(1.0)) + 4.0 * relative * relative).sqrt();
        // Rounding must not hide a margin that is left out, nor a look that is luckier than the last.
        assert!(plain * margin > 5.0 * BLOCK as f64, "{plain} {margin}");
        let beyond = pilot.count as f64 - plain * (1.0 + margin);
        assert!((-1e-6..BLOCK as f64 + 1e-6).contains(&beyond), "{pilot:?}: {beyond}");
    }
}
