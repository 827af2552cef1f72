//! Renders that are killed, interrupted or cannot write go on to the same bytes, by the commands that they print.

mod folder;

use folder::{Folder, text};
use std::fs;
use std::process::{Child, Command, Output};
use std::time::Duration;

const SCENE: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="6"/></integrator>
<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film></sensor>
<shape type="sphere"><transform name="to_world"><translate z="4"/></transform><bsdf type="dielectric"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate x="1" angle="-90"/><translate y="-1"/></transform></shape>
<emitter type="constant"/></scene>"#;

const ETALON: &str = env!("CARGO_BIN_EXE_etalon");

/// A folder with a scene that takes about one and a half seconds to render with one thread.
fn folder() -> Folder {
    Folder::new(SCENE)
}

impl Folder {
    fn start(&self, arguments: &[&str]) -> Child {
        self.start_by(ETALON, &[], arguments)
    }

    /// Starts a program that is etalon, or that starts it with the arguments `before`.
    fn start_by(&self, program: &str, before: &[&str], arguments: &[&str]) -> Child {
        let fixed = ["render", "scene.xml", "--threads", "1"];
        self.command(program, &[before, &fixed, arguments].concat()).spawn().unwrap()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.start(arguments).wait_with_output().unwrap()
    }

    fn done(&self, arguments: &[&str]) -> Output {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
        output
    }

    fn refused(&self, arguments: &[&str], words: &[&str]) {
        let before = self.names();
        let output = self.run(arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "no `{word}`: {error}");
        }
        assert_eq!(self.names(), before);
    }
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output.stdout)))
}

const LONG: [&str; 2] = ["--spp", "1500"];

#[test]
fn killed_at_any_moment_a_render_goes_on_to_the_same_bytes() {
    let folder = folder();
    folder.done(&[&LONG[..], &["-o", "whole.exr", "--quiet"]].concat());
    let begin = ["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001", "--json", "--resume"];
    let arguments = [&LONG[..], &begin].concat();
    // Arbitrary moments, some of them before any save and one of them possibly after the end.
    for milliseconds in [3, 170, 41, 290, 97, 230, 350, 60, 310] {
        let mut child = folder.start(&arguments);
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let saved = folder.path("c").exists();
    let document = json(&folder.done(&arguments));
    assert_eq!(saved, document["resumed_at"].as_u64().is_some_and(|at| at > 0), "{document}");
    assert!(folder.bytes("out.exr") == folder.bytes("whole.exr"));
    assert_eq!(document["samples"], 1500 * 40 * 30);
    // The checkpoint is removed at the end. A process killed while writing may have left a partial one.
    assert!(!folder.path("c").exists());
}

/// The number of samples that a pilot has chosen is in the checkpoint: the same command goes on.
#[test]
fn killed_after_its_pilot_a_render_goes_on_to_as_many_samples() {
    let folder = folder();
    for chosen in [["--time", "3"], ["--target-error", "0.02%"]] {
        let arguments = [
            &chosen[..],
            &["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001", "--json", "--resume"],
        ]
        .concat();
        let mut child = folder.start(&arguments);
        while !folder.path("c").exists() {
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let output = folder.run(&arguments);
        let document = json(&output);
        assert!(document["resumed_at"].as_u64().is_some_and(|at| at > 0), "{document}");
        let samples = document["samples"].as_u64().unwrap() / (40 * 30);
        folder.done(&["--spp", &samples.to_string(), "-o", "whole.exr", "--quiet"]);
        assert!(folder.bytes("out.exr") == folder.bytes("whole.exr"));
    }
}

/// Two renders may have been given one name: what another has written is neither replaced nor removed.
#[test]
fn a_checkpoint_that_has_become_anothers_is_left_alone() {
    let folder = folder();
    let arguments = ["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.05", "--quiet"];
    let child = folder.start(&[&LONG[..], &arguments].concat());
    while !folder.path("c").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    // Renamed into its place, as another render's would be.
    fs::write(folder.path("other"), "the work of another").unwrap();
    fs::rename(folder.path("other"), folder.path("c")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("another process has written it"), "{}", text(&output.stderr));
    assert_eq!(folder.bytes("c"), b"the work of another");
}

/// What a pilot chooses begins with sample 0, so another part of a render is none of its.
#[test]
fn a_pilot_goes_on_with_nothing_that_none_has_chosen() {
    let folder = folder();
    let arguments = ["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001"];
    let mut child = folder.start(&[&arguments[..], &["--samples", "8..1000000"]].concat());
    while !folder.path("c").exists() {
        std::thread::sleep(Duration::from_millis(5));
        assert!(child.try_wait().unwrap().is_none(), "it ended");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    for chosen in [["--time", "1"], ["--target-error", "1%"]] {
        let arguments = [&arguments[..], &["--resume"], &chosen].concat();
        folder.refused(&arguments, &["c: the checkpoint cannot be resumed: it is of samples 8..1000000"]);
    }
}

#[test]
fn the_checkpoint_of_another_render_is_refused() {
    let folder = folder();
    let arguments = ["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001"];
    let mut child = folder.start(&[&arguments[..], &["--spp", "1000000"]].concat());
    while !folder.path("c").exists() {
        std::thread::sleep(Duration::from_millis(5));
        assert!(child.try_wait().unwrap().is_none(), "it ended");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let _ = fs::remove_file(folder.path("c.partial"));
    let resume = [&arguments[..], &["--resume"]].concat();
    let refused = |more: &[&str], words: &[&str]| folder.refused(&[&resume[..], more].concat(), words);
    refused(&["--spp", "2000"], &["c: the checkpoint cannot be resumed", "another range of samples"]);
    refused(&["--spp", "1000000", "--seed", "7"], &["another seed: `0`, and `7` is asked for"]);
    refused(&["--spp", "1000000", "--size", "41x30"], &["another film: `40x30`"]);
    refused(&["--spp", "1000000", "--crop", "0,0,9,9"], &["another crop"]);
    refused(&["--spp", "1000000", "--max-depth", "3"], &["another scene"]);
    refused(&["--spp", "1000000", "--color", "rgb"], &["another scene"]);
    let bytes = folder.bytes("c");
    fs::write(folder.path("c"), &bytes[..bytes.len() - 9]).unwrap();
    refused(&["--spp", "1000000"], &["c: the checkpoint is damaged: it ends too early"]);
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    fs::write(folder.path("c"), &damaged).unwrap();
    refused(&["--spp", "1000000"], &["c: the checkpoint is damaged"]);
    // Nor is it overwritten without an error, or another file replaced by it.
    let begin = |words: &[&str]| folder.refused(&[&arguments[..], &["--spp", "8"]].concat(), words);
    fs::write(folder.path("c"), &bytes).unwrap();
    begin(&["c: there is a checkpoint already", "--resume"]);
    assert!(folder.bytes("c") == bytes);
    fs::write(folder.path("c"), "something else").unwrap();
    begin(&["c: there is a file already, and it is no checkpoint"]);
    refused(&["--spp", "1000000"], &["it is no checkpoint"]);
    assert_eq!(folder.bytes("c"), b"something else");
    assert!(!folder.path("out.exr").exists());
}

const SAVED: [&str; 7] = ["-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001", "--json"];

/// Waits for the first checkpoint.
#[cfg(unix)]
fn begun(folder: &Folder, child: Child) -> Child {
    while !folder.path("c").exists() {
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

/// Sends a signal twice at once, as when a process and then its whole group are stopped.
#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let process = child.id().to_string();
    Command::new("kill").args([name, &process, &process]).status().unwrap();
}

#[cfg(unix)]
fn what_ends_a_render_loses_nothing(name: &str, start: impl FnOnce(&Folder, &[&str]) -> Child) {
    let folder = folder();
    let arguments = [&LONG[..], &SAVED].concat();
    let child = begun(&folder, start(&folder, &arguments));
    signal(&child, name);
    let output = child.wait_with_output().unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    assert!(error.contains("--checkpoint c --json --resume"), "{error}");
    let document = json(&output);
    let samples = document["samples_per_pixel"].to_string();
    folder.done(&["-o", "short.exr", "--quiet", "--spp", &samples]);
    assert!(folder.bytes("out.exr") == folder.bytes("short.exr"), "after {samples} samples");
    folder.done(&[&arguments[..], &["--resume"]].concat());
    folder.done(&[&LONG[..], &["-o", "whole.exr", "--quiet"]].concat());
    assert!(folder.bytes("out.exr") == folder.bytes("whole.exr"));
}

#[cfg(unix)]
#[test]
fn ctrl_c_writes_the_image_so_far_and_says_how_to_go_on() {
    what_ends_a_render_loses_nothing("-INT", Folder::start);
}

/// A pilot has chosen the number of samples, and must not choose again.
#[cfg(unix)]
#[test]
fn the_command_that_is_printed_goes_on() {
    let folder = folder();
    let child = begun(&folder, folder.start(&[&SAVED[..], &["--time", "3"]].concat()));
    signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let (error, document) = (text(&output.stderr), json(&output));
    // What there is can be made again, too.
    let so_far = document["samples_per_pixel"].to_string();
    assert_eq!(document["reproduce"], format!("--spp {so_far}"));
    let command = error.split('\n').find_map(|line| line.strip_prefix("go on with: etalon ")).expect(&error);
    let words: Vec<&str> = command.split(' ').collect();
    let output = folder.command(ETALON, &words).output().unwrap();
    let samples = json(&output)["samples_per_pixel"].to_string();
    assert!(command.contains(&format!("--spp {samples} ")), "{command}");
    folder.done(&["-o", "whole.exr", "--quiet", "--spp", &samples]);
    assert!(folder.bytes("out.exr") == folder.bytes("whole.exr"));
}

#[cfg(target_os = "linux")]
#[test]
fn the_end_of_the_terminal_writes_the_image_so_far() {
    // If the tests run under `nohup`, its disposition of the signal is inherited, which `env` resets.
    let undo = ["--default-signal=HUP", ETALON];
    what_ends_a_render_loses_nothing("-HUP", |folder, arguments| folder.start_by("env", &undo, arguments));
}

#[cfg(target_os = "linux")]
#[test]
fn nohup_lets_a_render_outlive_its_terminal() {
    let folder = folder();
    let arguments = [&LONG[..], &SAVED].concat();
    let child = begun(&folder, folder.start_by("nohup", &[ETALON], &arguments));
    signal(&child, "-HUP");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn a_time_and_an_error_become_a_count_that_makes_the_image_again() {
    let folder = folder();
    for (option, value) in [("--time", "0.3"), ("--target-error", "0.2%")] {
        let document = json(&folder.done(&["-o", "out.exr", "--json", option, value]));
        let reproduce = document["reproduce"].as_str().unwrap().to_owned();
        let again: Vec<&str> = reproduce.split(' ').collect();
        assert_eq!(again[0], "--spp");
        assert_eq!(document["samples_per_pixel"].as_u64().unwrap() % 4, 0);
        folder.done(&[&again[..], &["-o", "again.exr", "--quiet"]].concat());
        assert!(folder.bytes("out.exr") == folder.bytes("again.exr"));
        if option == "--target-error" {
            let error = document["relative_standard_error_of_mean"].as_f64().unwrap();
            assert_eq!(document["attained"].as_bool(), Some(error <= 0.002));
        }
    }
    folder.refused(&["-o", "new.exr", "--time", "1", "--spp", "4"], &["cannot be used with"]);
    folder.refused(&["-o", "new.exr", "--target-error", "0"], &["expected a number above 0"]);
}

/// Nothing could go on from a short image in the place of a whole one.
#[cfg(unix)]
#[test]
fn without_a_checkpoint_ctrl_c_touches_no_file() {
    let folder = folder();
    folder.done(&["-o", "out.exr", "--spp", "4", "--quiet"]);
    let before = folder.bytes("out.exr");
    for shown in [&[][..], &["--preview", "127.0.0.1:1"]] {
        let child = folder.start(&[&["-o", "out.exr", "--spp", "1000000"], shown].concat());
        std::thread::sleep(Duration::from_millis(500));
        signal(&child, "-INT");
        let output = child.wait_with_output().unwrap();
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{error}");
        assert!(error.contains("interrupted; no file was touched"), "{error}");
        assert!(folder.bytes("out.exr") == before && folder.names() == ["out.exr", "scene.xml"]);
    }
}

#[test]
fn a_viewer_that_does_not_answer_is_a_warning() {
    let folder = folder();
    let output = folder.done(&["-o", "out.exr", "--spp", "4", "--preview", "127.0.0.1:1"]);
    assert!(text(&output.stderr).contains("warning: no preview at 127.0.0.1:1"));
    folder.done(&["-o", "plain.exr", "--spp", "4", "--quiet"]);
    assert!(folder.bytes("out.exr") == folder.bytes("plain.exr"));
}

#[cfg(target_os = "linux")]
#[test]
fn places_that_cannot_be_written_are_refused_before_the_render() {
    let folder = folder();
    // Not even root can create files here. This number of samples would take days.
    let endless = ["--spp", "4000000000"];
    let refused = |files: &[&str]| folder.refused(&[files, &endless].concat(), &["/proc/x", "cannot write"]);
    refused(&["-o", "/proc/x.exr"]);
    refused(&["-o", "out.exr", "--png", "/proc/x.png"]);
    refused(&["-o", "out.exr", "--checkpoint", "/proc/x"]);
    let stdout = ["standard output cannot be: expected a file.exr"];
    folder.refused(&["-o", "-", "--spp", "4"], &stdout);
    // A full disk is detected only when it is full; the checkpoint keeps the work.
    let full = ["-o", "/dev/full", "--spp", "8", "--quiet"];
    folder.refused(&full, &["/dev/full: cannot write"]);
    let output = folder.run(&[&full[..], &["--checkpoint", "c"]].concat());
    assert_eq!(output.status.code(), Some(2));
    let command = "etalon render scene.xml -o /dev/full --spp 8 --threads 1 --checkpoint c --quiet --resume";
    let kept = format!("the render is kept in c; this writes the image: {command}");
    assert!(text(&output.stderr).contains(&kept), "{}", text(&output.stderr));
    folder.done(&["-o", "out.exr", "--spp", "8", "--quiet", "--checkpoint", "c", "--resume"]);
    folder.done(&["-o", "plain.exr", "--spp", "8", "--quiet"]);
    assert!(folder.bytes("out.exr") == folder.bytes("plain.exr"));
    assert_eq!(folder.names(), ["out.exr", "plain.exr", "scene.xml"]);
}
