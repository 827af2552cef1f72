use super::*;
use crate::load_text;
use crate::render::{RenderError, render};
use crate::spectrum::ColorMode;

fn scene(content: &str) -> Scene {
    sampled("independent", content)
}

fn sampled(sampler: &str, content: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="3"/></integrator>
        <sensor type="perspective"><sampler type="{sampler}"/><film type="hdrfilm"><integer name="width" value="24"/>
            <integer name="height" value="18"/></film></sensor>
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
    let [a, b] = [quality, of_image].map(|quality| quality.relative_standard_error);
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
fn the_count_is_the_least_that_the_last_look_promises_with_its_margin() {
    for (sampler, targets) in
        [("independent", [0.0003, 0.0002, 0.0001]), ("sobol", [0.0002, 0.0001, 0.00005])]
    {
        let scene = sampled(sampler, LIT);
        for (seed, target) in (0..).zip(targets) {
            let pilot =
                for_error(&scene, &settings(&scene, seed), target, &Progress::default()).expect("a count");
            let (quality, n) = (pilot.quality, pilot.samples as f64);
            assert_eq!(quality.law.is_some(), sampler == "sobol");
            let promised = |count: u64| {
                let (relative, r2) = (quality.relative_standard_error_of_mean, quality.uncertainty);
                let deviation = quality.law.map_or(0.0, |law| law.gain_deviation);
                let beyond = deviation * (count as f64 / n).max(1.0).log2().ceil();
                let margin =
                    r2 * (1.0 + (n / count as f64).min(1.0)) + beyond * beyond + 4.0 * relative * relative;
                let falls = quality.law.map_or(n / count as f64, |law| {
                    law.variance(&(0..count)) / law.variance(&(0..pilot.samples))
                });
                relative * relative * falls * (1.0 + 2.0 * margin.sqrt()) / (target * target)
            };
            assert!(promised(pilot.count) <= 1.0 + 1e-9, "{sampler} {pilot:?}: {}", promised(pilot.count));
            let fewer = counts().take_while(|count| *count < pilot.count);
            assert!(fewer.map(promised).all(|promised| promised > 1.0 - 1e-9), "{sampler} {pilot:?}");
            // Rounding must not hide a margin that is left out.
            assert!(pilot.count > 64, "{pilot:?}");
        }
    }
}

/// Powers of two and little more between them: up to seven hundred are looked at.
#[test]
fn counts_are_of_few_digits() {
    let all: Vec<u64> = counts().collect();
    assert_eq!(all[..12], [8, 12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 52]);
    assert!(all.windows(2).all(|pair| pair[0] < pair[1] && pair[1] - pair[0] <= BLOCK.max(pair[0] / 16)));
    assert!(all.iter().all(|count| count.is_multiple_of(BLOCK) && count >> count.trailing_zeros() < 32));
    assert!(all.len() < 700 && all.last().is_some_and(|last| *last <= MOST && *last > MOST / 16 * 15));
}

/// What a sequence gains by being long is known before it is rendered.
#[test]
fn a_stratified_sequence_needs_fewer_samples() {
    let counts = ["independent", "sobol"].map(|sampler| {
        let scene = sampled(sampler, LIT);
        let target = 0.0002;
        let count = |seed| {
            let settings = settings(&scene, seed);
            let pilot = for_error(&scene, &settings, target, &Progress::default()).expect("a count");
            let quality = printed(&scene, &Settings { samples: 0..pilot.count, ..settings });
            (pilot.count, quality.relative_standard_error_of_mean <= target)
        };
        let seen: Vec<(u64, bool)> = (0..20).map(count).collect();
        // With a chance of 95 % each, fewer than 15 of 20 come once in 3000 times.
        assert!(seen.iter().filter(|(_, attained)| *attained).count() >= 15, "{sampler} {seen:?}");
        seen.iter().map(|(count, _)| *count).sum::<u64>()
    });
    assert!(counts[1] * 2 < counts[0], "{counts:?}");
}
