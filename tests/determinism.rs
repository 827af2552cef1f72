//! A render is a function of scene, seed and sample range: neither the number of threads nor a division of
//! work, the kernel, the unit of light or the unit of length may change a bit of it.

mod scenes;

use etalon::image::{Image, read_exr};
use etalon::integrator::KERNELS;
use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::scene::Scene;
use scenes::{SCENES, Trial, Units};
use std::fs;
use std::path::Path;
use std::process::Command;

const SAMPLES: u64 = 16;

/// Runs the program in a folder, asserts that it succeeds, and returns its standard output.
fn etalon(folder: &Path, arguments: &[&str]) -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_etalon")).current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn render_file(folder: &Path, trial: &Trial, name: &str, more: &[&str]) -> Vec<u8> {
    let fixed = ["render", "scene.xml", "--quiet", "--color", trial.mode.name(), "-o", name];
    etalon(folder, &[&fixed, more].concat());
    fs::read(folder.join(name)).unwrap()
}

/// A folder that contains the scene.
fn folder(trial: &Trial) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.xml"), trial.text(Units::default())).unwrap();
    folder
}

/// The bits of every channel: name, means, variances.
fn bits(image: &Image) -> Vec<(String, Vec<u32>, Vec<u32>)> {
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<u32>>();
    let mut channels: Vec<_> = image
        .channels
        .iter()
        .map(|c| (c.name.clone(), bits(&c.mean), c.variance.as_deref().map(bits).unwrap_or_default()))
        .collect();
    channels.sort();
    channels
}

fn load(trial: &Trial, units: Units) -> Scene {
    load_text("scene.xml", &trial.text(units), trial.mode).unwrap_or_else(|e| panic!("{}: {e}", trial.name))
}

fn settings(scene: &Scene) -> Settings {
    Settings { threads: 2, ..Settings::of(scene, 0..SAMPLES) }
}

fn image(scene: &Scene, settings: &Settings) -> Image {
    let (image, report) = render(scene, settings, &Progress::default()).unwrap();
    assert_eq!(report.non_finite, 0);
    image
}

/// Asserts that equality is meaningful: the image is neither black nor the same in every pixel.
fn require_content(trial: &Trial, image: &Image) {
    for channel in image.channels.iter().filter(|c| ["R", "G", "B"].contains(&c.name.as_str())) {
        let first = channel.mean[0];
        assert!(channel.mean.iter().any(|v| *v != first), "{}: {} is flat", trial.name, channel.name);
        let variance = channel.variance.as_ref().expect("variance");
        assert!(variance.iter().any(|v| *v > 0.0), "{}: {} has no noise", trial.name, channel.name);
    }
}

#[test]
fn samples_count_for_several_pixels_with_and_without_shared_paths() {
    let pixels_that_share = |trial: &Trial| {
        let scene = load_text("scene.xml", &trial.text(Units::default()), trial.mode).unwrap();
        scene.sensor.film.spread.is_some().then(|| scene.integrator.reuse())
    };
    let mut found: Vec<u32> = SCENES.iter().filter_map(pixels_that_share).collect();
    found.sort_unstable();
    assert!(found.len() == 2 && found[0] == 1 && found[1] > 1, "{found:?}");
}

#[test]
fn threads_and_repetition_change_no_byte() {
    for trial in SCENES {
        let folder = folder(trial);
        let file = |threads: &str| {
            render_file(folder.path(), trial, "out.exr", &["--spp", "8", "--threads", threads])
        };
        let first = file("1");
        require_content(trial, &read_exr(&folder.path().join("out.exr")).unwrap());
        for threads in ["1", "2", "3", "7", "1"] {
            assert!(file(threads) == first, "{} with {threads} threads", trial.name);
        }
        // The test can fail: another seed gives another image.
        render_file(folder.path(), trial, "other.exr", &["--spp", "8", "--seed", "1"]);
        let images = ["out.exr", "other.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
        assert_ne!(bits(&images[0]), bits(&images[1]), "{}", trial.name);
    }
}

#[test]
fn parts_merge_to_the_file_of_one_run() {
    for trial in SCENES {
        let folder = folder(trial);
        let path = folder.path();
        let whole = render_file(path, trial, "whole.exr", &["--samples", "0..16"]);
        // Boxes in (column, row, sample) that are not on a regular grid, over the film of 24 × 20 pixels.
        let parts = [
            ("0,0,24,20", "0..4"),
            ("0,0,9,20", "4..16"),
            ("9,0,15,7", "4..8"),
            ("9,0,15,7", "8..16"),
            ("9,7,15,13", "4..12"),
            ("9,7,15,13", "12..16"),
        ];
        let names: Vec<String> = (0..parts.len()).map(|i| format!("part{i}.exr")).collect();
        for (name, (crop, samples)) in names.iter().zip(parts) {
            render_file(path, trial, name, &["--crop", crop, "--samples", samples]);
        }
        for order in [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [3, 0, 5, 1, 4, 2]] {
            let mut arguments = vec!["merge", "-o", "merged.exr"];
            arguments.extend(order.map(|i| names[i].as_str()));
            etalon(path, &arguments);
            assert!(fs::read(path.join("merged.exr")).unwrap() == whole, "{} in order {order:?}", trial.name);
        }
        render_file(path, trial, "plain.exr", &["--spp", "16"]);
        let [plain, whole] = ["plain.exr", "whole.exr"].map(|name| read_exr(&path.join(name)).unwrap());
        assert_eq!(bits(&plain), bits(&whole), "{}", trial.name);
        // Merged in two stages.
        etalon(path, &["merge", &names[2], &names[3], "-o", "a.exr"]);
        etalon(path, &["merge", &names[5], &names[4], "-o", "b.exr"]);
        etalon(path, &["merge", "b.exr", &names[1], "a.exr", "-o", "c.exr"]);
        etalon(path, &["merge", "c.exr", &names[0], "-o", "d.exr"]);
        assert!(
            fs::read(path.join("d.exr")).unwrap() == fs::read(path.join("merged.exr")).unwrap(),
            "{}",
            trial.name
        );
    }
}

#[test]
fn windows_without_shards_merge_too() {
    let trial = &SCENES[0];
    let folder = folder(trial);
    let whole = render_file(folder.path(), trial, "whole.exr", &["--spp", "5"]);
    render_file(folder.path(), trial, "a.exr", &["--spp", "5", "--crop", "0,0,24,7"]);
    render_file(folder.path(), trial, "b.exr", &["--spp", "5", "--crop", "0,7,24,13"]);
    etalon(folder.path(), &["merge", "b.exr", "a.exr", "-o", "merged.exr"]);
    assert!(fs::read(folder.path().join("merged.exr")).unwrap() == whole);
}

#[test]
fn every_sufficient_kernel_gives_the_same_bits() {
    let mut compared = 0;
    for trial in SCENES {
        let scene = load(trial, Units::default());
        let least = image(&scene, &settings(&scene));
        for kernel in KERNELS.iter().filter(|k| k.features.cover(scene.features())) {
            let other = image(&scene, &Settings { kernel: Some(kernel), ..settings(&scene) });
            assert_eq!(bits(&least), bits(&other), "{} with kernel {}", trial.name, kernel.name);
            compared += 1;
        }
    }
    assert!(compared > 2 * SCENES.len(), "only {compared} kernels were compared");
}

#[test]
fn powers_of_two_of_light_scale_the_image_exactly() {
    for trial in SCENES {
        let unit = load(trial, Units::default());
        let unit = image(&unit, &settings(&unit));
        for exponent in [-20, 20] {
            let factor = 2.0f32.powi(exponent);
            let scene = load(trial, Units { light: f64::from(factor), ..Units::default() });
            let scaled = image(&scene, &settings(&scene));
            for (a, b) in unit.channels.iter().zip(&scaled.channels) {
                let place = format!("{}, {} times 2^{exponent}", trial.name, a.name);
                require_scaled(&a.mean, &b.mean, factor, &format!("mean of {place}"));
                let [a, b] = [a, b].map(|c| c.variance.as_deref().expect("variance"));
                require_scaled(a, b, factor * factor, &format!("variance of {place}"));
            }
        }
    }
}

/// Asserts equality to the bit, except below the smallest normal number of f32, where values may differ by a
/// step of the denormal grid.
fn require_scaled(unit: &[f32], scaled: &[f32], factor: f32, place: &str) {
    let step = f32::from_bits(1) * factor.max(1.0);
    for (a, b) in unit.iter().zip(scaled) {
        let equal = (a * factor).to_bits() == b.to_bits();
        let tiny = !(a.is_normal() && b.is_normal()) && (a * factor - b).abs() <= step;
        assert!(equal || tiny, "{place}: {a:e} and {b:e}");
    }
}

#[test]
fn powers_of_two_of_length_change_no_bit() {
    for trial in SCENES {
        let unit = load(trial, Units::default());
        let unit = bits(&image(&unit, &settings(&unit)));
        for exponent in [-20, 20] {
            let scene = load(trial, Units { length: 2.0f64.powi(exponent), ..Units::default() });
            let scaled = bits(&image(&scene, &settings(&scene)));
            let differing =
                unit.iter().zip(&scaled).flat_map(|(a, b)| a.1.iter().zip(&b.1)).filter(|(a, b)| a != b);
            assert_eq!(differing.count(), 0, "values of {} differ at 2^{exponent}", trial.name);
            assert_eq!(unit, scaled, "{} at 2^{exponent}", trial.name);
        }
    }
}

#[test]
fn replay_prints_what_was_rendered() {
    for trial in SCENES {
        let folder = folder(trial);
        render_file(folder.path(), trial, "out.exr", &["--samples", "0..1"]);
        let image = read_exr(&folder.path().join("out.exr")).unwrap();
        for (x, y) in [(0, 0), (12, 10), (7, 15), (23, 19)] {
            let pixel = format!("{x},{y}");
            let mode = trial.mode.name();
            let arguments = ["replay", "scene.xml", "--color", mode, "--pixel", &pixel, "--sample", "0"];
            let printed = etalon(folder.path(), &arguments);
            let values = printed.lines().filter_map(|line| line.strip_prefix("channel ")?.rsplit_once(' '));
            let values: Vec<(&str, f32)> =
                values.map(|(name, v)| (name, v.parse::<f64>().unwrap() as f32)).collect();
            assert!(values.len() >= 3, "{printed}");
            for (name, value) in values {
                let channel = image.channels.iter().find(|c| c.name == name).unwrap();
                let pixel = channel.mean[(y * image.crop.width + x) as usize];
                assert_eq!(
                    pixel.to_bits(),
                    value.to_bits(),
                    "{} ({x}, {y}) {name}: {pixel} and {value}",
                    trial.name
                );
            }
        }
    }
}
