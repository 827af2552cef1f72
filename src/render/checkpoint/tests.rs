use super::reader::load;
use super::*;
use crate::load_text;
use crate::render::light_path_noise::LightPathNoise;
use crate::render::passes::render_passes;
use crate::render::quality::Quality;
use crate::render::{Progress, render};
use crate::scene::trial::ball_of_glass;
use crate::spectrum::ColorMode;
use std::fs;
use std::ops::ControlFlow;

fn scene(radius: f64) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0">
        <sensor type="perspective"><sampler type="sobol"/><film type="hdrfilm"><integer name="width" value="9"/>
            <integer name="height" value="7"/></film></sensor>
        <shape type="sphere"><float name="radius" value="{radius}"/><transform name="to_world"><translate z="4"/></transform></shape>
        <emitter type="constant"/></scene>"#
    );
    load_text("scene.xml", &text, ColorMode::Spectral).expect("it loads")
}

fn settings(scene: &Scene) -> Settings {
    Settings { seed: 3, ..Settings::of(scene, 4..53) }
}

fn go_on(scene: &Scene, settings: &Settings, partial: Partial, passes: u32) -> Partial {
    let mut left = passes;
    let counted = |_: &Partial| {
        left -= 1;
        if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    render_passes(scene, settings, partial, &Progress::default(), counted).expect("it renders")
}

/// A checkpoint after two passes, and its bytes.
fn saved(folder: &tempfile::TempDir) -> (std::path::PathBuf, Vec<u8>) {
    let (scene, path) = (scene(1.0), folder.path().join("c"));
    let settings = settings(&scene);
    let partial = go_on(&scene, &settings, Partial::new(&scene, &settings), 2);
    save(&path, &scene, &settings, &partial, || Ok(())).expect("written");
    let bytes = fs::read(&path).expect("read");
    (path, bytes)
}

#[test]
fn a_render_goes_on_as_if_nothing_had_happened() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, bytes) = saved(&folder);
    let scene = scene(1.0);
    let settings = settings(&scene);
    let (resumed, _) = load(&path, &scene, &settings).expect("it loads");
    // How long the second pass is depends on the time that the first one took.
    assert!(resumed.samples == (4..16) || resumed.samples == (4..12), "{:?}", resumed.samples);
    // Up to four times the image's history, in the digits of three numbers a square.
    let most = size(&settings, 3) + 1000 + 4 * 3 * 21 * settings.window.pixels() as u64;
    assert!(bytes.len() as u64 > size(&settings, 3) && (bytes.len() as u64) < most, "{}", bytes.len());
    let resumed = go_on(&scene, &settings, resumed, 100);
    let (image, report) = (resumed.image(&scene, &settings), resumed.report.clone());
    let whole = go_on(&scene, &settings, Partial::new(&scene, &settings), 100);
    let (expected, expected_report) = (whole.image(&scene, &settings), whole.report.clone());
    assert_eq!(image, expected);
    assert_eq!((report.rays, report.samples), (expected_report.rays, expected_report.samples));
    // To the bit, wherever passes began and in whatever order threads came.
    assert_eq!(resumed.history, whole.history);
    let (_, report) = render(&scene, &settings, &Progress::default()).expect("it renders");
    assert_eq!(report.quality, Some(Quality::of(&whole, &scene, settings.window)));
}

/// Of a caustic, whose error is not that of its pixels alone.
#[test]
fn what_pixels_have_in_common_goes_on_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("c");
    let caustic = r#"<integrator type="path"><float name="light_paths" value="1"/></integrator>"#;
    let scene = load_text("scene.xml", &ball_of_glass(caustic), ColorMode::Rgb).expect("it loads");
    let settings = Settings::of(&scene, 0..64);
    let begun = go_on(&scene, &settings, Partial::new(&scene, &settings), 2);
    save(&path, &scene, &settings, &begun, || Ok(())).expect("written");
    let (resumed, _) = load(&path, &scene, &settings).expect("it loads");
    assert!(begun.light_paths != LightPathNoise::default() && resumed.light_paths == begun.light_paths);
    let resumed = go_on(&scene, &settings, resumed, 100);
    let whole = go_on(&scene, &settings, Partial::new(&scene, &settings), 100);
    // To the bit, wherever passes began.
    assert_eq!(resumed.light_paths, whole.light_paths);
}

/// Pixels hold what is not finite apart; sums over the image are of it as well.
#[test]
fn what_is_not_finite_is_no_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, scene) = (folder.path().join("c"), scene(1.0));
    let settings = settings(&scene);
    let mut partial = Partial::new(&scene, &settings);
    for (sum, value) in partial.sums.pixel_mut(1, 2).iter_mut().zip([f64::INFINITY, f64::NAN, 0.1]) {
        (4..8).for_each(|number| sum.add(number, value));
    }
    let history = partial.history.as_mut().expect("samples are stratified");
    history.note(8, settings.window, partial.sums.all());
    save(&path, &scene, &settings, &partial, || Ok(())).expect("written");
    let (resumed, _) = load(&path, &scene, &settings).expect("it loads");
    // Not a number is not equal to itself.
    assert_eq!(format!("{:?}", resumed.history), format!("{:?}", partial.history));
    assert_eq!(format!("{:?}", resumed.history).matches("NaN").count(), 2);
}

#[test]
fn another_render_is_refused_by_what_differs() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, _) = saved(&folder);
    let (same, other) = (scene(1.0), scene(1.5));
    let asked = settings(&same);
    let mut crop = asked.window;
    crop.width -= 1;
    let cases = [
        (&other, asked.clone(), "another scene"),
        (&same, Settings { seed: 4, ..asked.clone() }, "another seed: `3`, and `4` is asked for"),
        (&same, Settings { samples: 0..53, ..asked.clone() }, "another range of samples: `4..53`"),
        (&same, Settings { samples: 4..57, ..asked.clone() }, "another range of samples"),
        (&same, Settings { window: crop, ..asked.clone() }, "another crop: `0,0,9,7`"),
    ];
    for (scene, settings, words) in cases {
        let error = match load(&path, scene, &settings) {
            Ok(_) => panic!("{words}: it must be refused"),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(words) && error.contains("cannot be resumed"), "{error}");
    }
    let threads = Settings { threads: 2, ..asked };
    assert!(load(&path, &same, &threads).is_ok());
}

#[test]
fn every_damage_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, bytes) = saved(&folder);
    let scene = scene(1.0);
    let settings = settings(&scene);
    let refused = |damaged: &[u8]| {
        fs::write(&path, damaged).expect("written");
        load(&path, &scene, &settings).err().map(|error| error.to_string())
    };
    assert_eq!(refused(&bytes), None);
    for length in [0, 7, 12, 100, bytes.len() / 2, bytes.len() - 1] {
        let error = refused(&bytes[..length]).expect("truncated");
        assert!(error.contains("it ends too early"), "{length}: {error}");
    }
    assert!(refused(&[&bytes[..], b"x"].concat()).is_some_and(|e| e.contains("something follows")));
    for at in (0..bytes.len()).step_by(41).chain(bytes.len() - 8..bytes.len()) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        assert!(refused(&damaged).is_some(), "byte {at}");
    }
    assert!(load(&folder.path().join("none"), &scene, &settings).is_err());
}

/// Another process may write a file of the same name at any time, also while this one reads or writes.
#[test]
fn what_has_become_anothers_is_not_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, bytes) = saved(&folder);
    let scene = scene(1.0);
    let settings = settings(&scene);
    let (own, resumed) = OwnCheckpoint::resume(&path, &scene, &settings).expect("it loads");
    let theirs = [&bytes[..], b"x"].concat();
    let is_refused = |saved: Result<(), FileError>| {
        assert!(saved.is_err_and(|error| error.to_string().contains("another process has written it")));
        assert_eq!(fs::read(&path).expect("read"), theirs);
    };
    own.save(&scene, &settings, &resumed).expect("its own");
    // After it was looked at for the first time.
    let meanwhile = || {
        fs::write(&path, &theirs).expect("written");
        own.exists().map(drop)
    };
    is_refused(save(&path, &scene, &settings, &resumed, meanwhile).map(drop));
    is_refused(own.save(&scene, &settings, &resumed));
    is_refused(own.remove());
    // One that has begun before there was a file, and saved none.
    fs::remove_file(&path).expect("removed");
    let own = OwnCheckpoint::begin(&path).expect("no file");
    fs::write(&path, &theirs).expect("written");
    is_refused(own.save(&scene, &settings, &resumed));
    assert!(own.remove().is_ok() && fs::read(&path).expect("read") == theirs);
    assert!(OwnCheckpoint::begin(&path).is_err());
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "a partial file stays");
}

/// Heads change from version to version, and only what all have can be read of another one.
#[test]
fn another_version_is_no_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("c");
    let head = br#"{"identity": {"version": "0.0.1", "seed": [1, 2]}}"#;
    fs::write(&path, [&MAGIC[..], &(head.len() as u64).to_le_bytes(), head].concat()).expect("written");
    let scene = scene(1.0);
    let Err(error) = load(&path, &scene, &settings(&scene)) else { panic!("it must be refused") };
    let error = error.to_string();
    assert!(error.contains("it is of another version: `0.0.1`"), "{error}");
}
