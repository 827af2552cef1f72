use super::*;
use crate::render::light_path_noise::Excess;
use crate::render::{Progress, Settings, render};
use crate::scene::Overrides;
use crate::scene::trial::ball_of_glass;
use crate::spectrum::ColorMode;
use crate::{load, load_text};
use std::path::Path;

/// Pixels that share within squares of this edge.
fn squares(edge: u32) -> Correlation {
    Correlation { edge, ..Correlation::NONE }
}

#[test]
fn few_pixels_with_all_the_variance_are_heavy_tails() {
    let quality = |variances: &[f64]| {
        let channel = || variances.iter().map(|&v| (1.0, v));
        let window = Window { x: 3, y: 1, width: variances.len() as u32 / 4, height: 4 };
        Quality::new(window, Correlation::NONE, [channel(), channel(), channel()])
    };
    let even = quality(&[2.0; 1000]);
    assert!((even.effective_pixels - 1000.0).abs() < 1e-6 && !even.heavy_tailed());
    assert!((even.relative_standard_error - 2f64.sqrt()).abs() < 1e-12);
    // The channels see the same light: there are as many independent values as pixels.
    assert!((even.relative_standard_error_of_mean - 0.002f64.sqrt()).abs() < 1e-12);
    let mut outliers = [1e-6; 1000];
    outliers[..3].fill(5.0);
    let heavy = quality(&outliers);
    assert!(heavy.heavy_tailed() && (heavy.effective_pixels - 3.0).abs() < 0.01);
    assert!(!quality(&[0.0; 100]).heavy_tailed());
    // Nine squares of pixels that share, all alike, are few, but none of them stands out.
    let channel = (0..24 * 24).map(|_| (1.0, 2.0));
    let shared = Quality::new(Window { x: 0, y: 0, width: 24, height: 24 }, squares(8), [channel]);
    assert!((shared.effective_pixels - 9.0).abs() < 1e-9 && !shared.heavy_tailed());
}

#[test]
fn errors_are_those_of_the_channels_that_there_are_and_positive() {
    let window = Window { x: 0, y: 0, width: 10, height: 10 };
    let quality = |value: f64, channels: usize| {
        Quality::new(window, Correlation::NONE, vec![std::iter::repeat_n((value, 4.0), 100); channels])
    };
    let three = quality(5.0, 3);
    assert!((three.relative_standard_error - 0.4).abs() < 1e-12);
    assert!((three.relative_standard_error_of_mean - 0.04).abs() < 1e-12);
    for channels in 1..=3 {
        for sign in [1.0, -1.0] {
            let found = quality(5.0 * sign, channels);
            let mean = std::array::from_fn(|i| if i < channels { 5.0 * sign } else { 0.0 });
            assert_eq!(found, Quality { mean, ..three }, "{channels} channels");
        }
    }
}

#[test]
fn errors_of_pixels_that_share_paths_may_add_up() {
    let channel = || (0..24).map(|i| (2.0, f64::from(1 + i % 4)));
    let quality = |edge| Quality::new(Window { x: 3, y: 2, width: 6, height: 4 }, squares(edge), [channel()]);
    let (alone, together) = (quality(1), quality(2));
    assert_eq!(alone.relative_standard_error, together.relative_standard_error);
    // Columns 3 | 4 5 | 6 7 | 8 and rows 2 3 | 4 5, by hand.
    let deviation = |i: usize| f64::from(1 + i as u32 % 4).sqrt();
    let rows = [[0, 6], [12, 18]].map(|rows| {
        [vec![0], vec![1, 2], vec![3, 4], vec![5]].map(|columns| {
            let pixels = columns.iter().flat_map(|c| rows.map(|r| r + c));
            pixels.map(deviation).sum::<f64>()
        })
    });
    let sum: f64 = rows.iter().flatten().map(|deviation| deviation * deviation).sum();
    let expected = sum.sqrt() / 24.0 / 2.0;
    assert!((together.relative_standard_error_of_mean / expected - 1.0).abs() < 1e-12);
    assert!(together.relative_standard_error_of_mean > 1.7 * alone.relative_standard_error_of_mean);
}

#[test]
fn an_image_whose_pixels_share_paths_knows_that_their_errors_are_correlated() {
    let sharing = r#"<integrator type="path"><integer name="reuse" value="16"/></integrator>"#;
    let scene = load_text("scene.xml", &ball_of_glass(sharing), ColorMode::Spectral).expect("it loads");
    let settings = Settings::of(&scene, 0..16);
    let (image, _) = render(&scene, &settings, &Progress::default()).expect("it renders");
    let double = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect::<Vec<_>>();
    let quality = |edge| {
        let channels = image.channels.iter().map(|channel| {
            let variance = channel.variance.as_deref().expect("variances");
            double(&channel.mean).into_iter().zip(double(variance))
        });
        Quality::new(settings.window, squares(edge), channels)
    };
    assert_eq!(Quality::of_image(&image), quality(8));
    let ratio =
        |edge| quality(edge).relative_standard_error_of_mean / quality(1).relative_standard_error_of_mean;
    assert!(ratio(4) > 1.5, "{}", ratio(4));
}

#[test]
fn pixels_that_share_wavelengths_are_known_to_be_correlated() {
    // All that a white sky differs by from pixel to pixel is wavelengths, which all of a cell have in common.
    let sky = r#"<scene version="3.0.0"><integrator type="path"><integer name="reuse" value="4"/></integrator>
        <sensor type="perspective"><sampler type="independent"/><film type="hdrfilm"><integer name="width" value="32"/>
            <integer name="height" value="32"/><rfilter type="box"/></film></sensor>
        <emitter type="constant"/></scene>"#;
    let scene = load_text("sky.xml", sky, ColorMode::Spectral).expect("it loads");
    let quality = |seed| {
        let settings = Settings { seed, ..Settings::of(&scene, 0..16) };
        let (_, report) = render(&scene, &settings, &Progress::default()).expect("it renders");
        report.quality.expect("it has samples")
    };
    let seen: Vec<Quality> = (0..128).map(quality).collect();
    let relative = |c: usize| {
        let mean = seen.iter().map(|q| q.mean[c]).sum::<f64>() / 128.0;
        let squares = seen.iter().map(|q| (q.mean[c] - mean) * (q.mean[c] - mean)).sum::<f64>() / 127.0;
        (mean, squares)
    };
    let channels = [0, 1, 2].map(relative);
    let mean = channels.iter().map(|(mean, _)| mean).sum::<f64>() / 3.0;
    let scatter = channels.iter().map(|(_, squares)| squares).sum::<f64>() / 3.0 / (mean * mean);
    let told = seen.iter().map(|q| q.relative_standard_error_of_mean.powi(2)).sum::<f64>() / 128.0;
    // The scatter's square is uncertain by √(2/127), an eighth.
    assert!((0.7..1.4).contains(&(told / scatter)), "{told} {scatter}");
}

#[test]
fn what_light_paths_give_in_common_is_as_uncertain_as_they_make_it() {
    let window = Window { x: 0, y: 0, width: 10, height: 10 };
    let quality = |excess: Option<Excess>| {
        let channel = (0..100).map(|_| (1.0, 2.0));
        Noise::of(window, Correlation::NONE, [channel]).quality(window, None, excess.unwrap_or_default())
    };
    let alone = quality(None);
    assert_eq!((alone.effective_pixels, alone.uncertainty), (100.0, 0.01));
    // As much again, and known to a tenth of it as the rest is.
    let common = quality(Some(Excess { of_sum: 200.0, deviation: 20.0 }));
    assert!(
        (common.relative_standard_error_of_mean / alone.relative_standard_error_of_mean - 2f64.sqrt()).abs()
            < 1e-12
    );
    assert!((common.effective_pixels - 100.0).abs() < 1e-9);
    // Exactly known it makes no pixels, and by a single light path nearly none.
    assert_eq!(quality(Some(Excess { of_sum: 200.0, deviation: 0.0 })).effective_pixels, 100.0);
    let rare = quality(Some(Excess { of_sum: 1e4, deviation: 1e4 }));
    assert!((1.0..1.1).contains(&rare.effective_pixels) && rare.heavy_tailed());
}

/// A room lit through a pane: a light path goes from wall to wall, and brings light to a pixel at each.
#[test]
fn errors_of_light_paths_are_known_to_be_common() {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/convergence/pane.xml");
    let overrides = Overrides { size: Some((24, 18)), light_paths: Some(1.0), ..Overrides::default() };
    let scene = load(&room, &[], ColorMode::Rgb, &overrides).expect("it loads");
    let settings = Settings::of(&scene, 0..32);
    let (image, report) = render(&scene, &settings, &Progress::default()).expect("it renders");
    let (told, of_pixels) = (report.quality.expect("it has samples"), Quality::of_image(&image));
    assert!(
        told.relative_standard_error_of_mean > 1.1 * of_pixels.relative_standard_error_of_mean,
        "{told:?} {of_pixels:?}"
    );
    assert!((told.relative_standard_error / of_pixels.relative_standard_error - 1.0).abs() < 1e-5);
    assert!(told.effective_pixels <= told.pixels as f64);
}
