//! Renders that are killed a hundred times, a full disk, a folder without write permission, a checkpoint of
//! another version, and the report of samples that are not finite.

mod folder;

use folder::{Folder, text};
use std::fs;
use std::process::{Child, Command, Output};
use std::time::Duration;

const SCENE: &str = r#"<scene version="3.0.0">
<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film></sensor>
<shape type="sphere"><transform name="to_world"><translate z="4"/></transform><bsdf type="roughconductor"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate x="1" angle="-90"/><translate y="-1"/></transform></shape>
<emitter type="constant"/></scene>"#;

/// Random numbers that depend on the index only (SplitMix64).
fn uniform(index: u64) -> f64 {
    let mut z = (index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

const ETALON: &str = env!("CARGO_BIN_EXE_etalon");

impl Folder {
    fn start(&self, arguments: &[&str]) -> Child {
        let fixed = ["render", "scene.xml", "--threads", "1", "--quiet"];
        self.command(ETALON, &[&fixed, arguments].concat()).spawn().unwrap()
    }

    fn done(&self, arguments: &[&str]) {
        let output = self.start(arguments).wait_with_output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    }
}

/// Kills a render `times` times at arbitrary moments, resumes it each time, and compares with an
/// uninterrupted one.
fn killed(times: u64, samples: &str) {
    let folder = Folder::new(SCENE);
    folder.done(&["--spp", samples, "-o", "whole.exr"]);
    let arguments =
        ["--spp", samples, "-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001", "--resume"];
    let mut alive = 0;
    for index in 0..times {
        let mut child = folder.start(&arguments);
        std::thread::sleep(Duration::from_micros((200_000.0 * uniform(index)) as u64));
        alive += u64::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert_eq!(alive, times, "a render ended before it could be killed: give it more samples");
    folder.done(&arguments);
    assert!(folder.bytes("out.exr") == folder.bytes("whole.exr"));
}

#[test]
fn who_has_read_enough_may_close_the_pipe() {
    let folder = Folder::new(SCENE);
    for arguments in
        [&["plugins"][..], &["explain", "scene.xml"], &["render", "scene.xml", "--spp", "1", "-o", "a.exr"]]
    {
        let mut child = folder.command(ETALON, arguments).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let complaint = text(&output.stderr);
        assert!(!complaint.contains("panicked"), "{arguments:?}: {complaint}");
    }
    assert!(folder.path("a.exr").exists());
}

#[test]
fn a_few_deaths_change_no_bit() {
    killed(5, "4000");
}

#[test]
#[ignore = "takes a minute: cargo test --release --test nothing_lost -- --ignored"]
fn a_hundred_deaths_change_no_bit() {
    killed(100, "60000");
}

/// Renders over an existing image under a shell's `limit`, and asserts that there is one error that contains
/// these words, and that all files are unchanged.
#[cfg(unix)]
fn refused_within(limit: &str, arguments: &str, words: &[&str]) {
    let folder = Folder::new(SCENE);
    folder.done(&["--spp", "4", "-o", "out.exr", "--png", "out.png"]);
    let before = [folder.bytes("out.exr"), folder.bytes("out.png")];
    let names = folder.names();
    let script = format!(
        "{limit}; exec '{}' render scene.xml --quiet --spp 8 -o out.exr --png out.png {arguments}",
        ETALON
    );
    let output = Command::new("sh").current_dir(folder.0.path()).args(["-c", &script]).output().unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(words.iter().all(|word| error.contains(word)), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!([folder.bytes("out.exr"), folder.bytes("out.png")] == before);
    assert_eq!(folder.names(), names);
}

/// A process that may write at most 8 KiB to a file and gets an error beyond, as on a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_image_before_as_it_was() {
    for handled in ["", "trap '' XFSZ; "] {
        refused_within(&format!("{handled}ulimit -f 8"), "", &["out.exr", "too large"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_film_beyond_the_limit_of_memory_leaves_the_image_before_as_it_was() {
    refused_within(
        "ulimit -v 800000",
        "--size 8000x8000",
        &["8000 × 8000 pixels", "GiB are available", "--crop"],
    );
}

/// Runs as nobody if the tests run as root, who may write everywhere.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_cannot_be_written_is_refused_and_stays_as_it_was() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::os::unix::process::CommandExt;
    let folder = Folder::new(SCENE);
    let program = folder.path("etalon");
    fs::copy(ETALON, &program).unwrap();
    folder.done(&["--spp", "4", "-o", "out.exr"]);
    let (before, names) = (folder.bytes("out.exr"), folder.names());
    fs::set_permissions(folder.0.path(), fs::Permissions::from_mode(0o555)).unwrap();
    for options in
        [["-o", "new.exr"].as_slice(), &["-o", "out.exr"], &["-o", "/dev/null", "--checkpoint", "c"]]
    {
        let mut command = Command::new(&program);
        command
            .current_dir(folder.0.path())
            .args(["render", "scene.xml", "--spp", "4000000000"])
            .args(options);
        if fs::metadata("/proc/self").unwrap().uid() == 0 {
            command.uid(65534).gid(65534);
        }
        let Output { status, stderr, .. } = command.output().unwrap();
        assert_eq!(status.code(), Some(2), "{}", text(&stderr));
        assert!(text(&stderr).contains("cannot write"), "{}", text(&stderr));
    }
    assert!(folder.bytes("out.exr") == before);
    assert_eq!(folder.names(), names);
    fs::set_permissions(folder.0.path(), fs::Permissions::from_mode(0o755)).unwrap();
}

/// The image is complete and written: what cannot be printed of it changes nothing about that.
#[cfg(target_os = "linux")]
#[test]
fn no_checkpoint_stays_where_the_summary_cannot_be_printed() {
    let folder = Folder::new(SCENE);
    let arguments = ["render", "scene.xml", "--spp", "512", "-o", "out.exr", "--checkpoint", "c"];
    for options in [[].as_slice(), &["--json"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = folder
            .command(ETALON, &[&arguments, ["--checkpoint-every", "0.001"].as_slice(), options].concat());
        let Output { status, stderr, .. } = command.stdout(full).output().unwrap();
        assert_eq!(status.code(), Some(2), "{}", text(&stderr));
        assert_eq!(folder.names(), ["out.exr", "scene.xml"], "{options:?}");
    }
}

#[test]
fn the_checkpoint_of_another_version_is_refused() {
    let folder = Folder::new(SCENE);
    let arguments = ["--spp", "1000000", "-o", "out.exr", "--checkpoint", "c", "--checkpoint-every", "0.001"];
    let mut child = folder.start(&arguments);
    while !folder.path("c").exists() {
        std::thread::sleep(Duration::from_millis(5));
        assert!(child.try_wait().unwrap().is_none(), "it ended");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let mut bytes = folder.bytes("c");
    let version = format!("\"version\":\"{}\"", etalon::VERSION).into_bytes();
    let at =
        bytes.windows(version.len()).position(|w| w == version).expect("the version") + version.len() - 2;
    bytes[at] += 1;
    fs::write(folder.path("c"), bytes).unwrap();
    let output = folder.start(&[&arguments[..], &["--resume"]].concat()).wait_with_output().unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("another version"), "{error}");
    assert!(!folder.path("out.exr").exists());
}

/// Lights whose sum exceeds the largest `f32`: samples that see all of them are counted, listed, and
/// reproduced by the command that is printed with them.
#[test]
fn a_sample_that_is_not_finite_is_counted_and_its_path_is_shown() {
    // Each light is representable in `f32`; the sum of a luminous veil, a luminous mirror behind it and the
    // sky that the mirror reflects is not.
    let bright =
        |kind: &str| format!("<emitter type=\"{kind}\"><rgb name=\"radiance\" value=\"1.7e38\"/></emitter>");
    let ball = "<shape type=\"sphere\"><transform name=\"to_world\"><translate z=\"4\"/></transform>";
    let veil = ball.replace("<translate", "<scale value=\"1.01\"/><translate");
    let veil = format!("{veil}<bsdf type=\"null\"/>{}</shape>{ball}", bright("area"));
    let glowing = SCENE
        .replace("<emitter type=\"constant\"/>", &bright("constant"))
        .replace("<bsdf type=\"roughconductor\"/>", &format!("<bsdf type=\"conductor\"/>{}", bright("area")))
        .replace(ball, &veil);
    let folder = Folder::new(&glowing);
    let child = folder.start(&["--spp", "4", "--color", "rgb", "-o", "out.exr"]);
    let output = child.wait_with_output().unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    let replay = error.split('\n').find_map(|line| line.split_once("etalon replay ")).expect("a command").1;
    let arguments: Vec<&str> = std::iter::once("replay").chain(replay.split_whitespace()).collect();
    let shown = folder.command(ETALON, &arguments).output().unwrap();
    let path = text(&shown.stdout);
    assert!(shown.status.success() && path.contains("vertex 1") && path.contains("inf"), "{replay}: {path}");
    // The neighbouring sample, which sees one light only, is finite.
    let beside =
        folder.command(ETALON, &["replay", "scene.xml", "--color", "rgb", "--pixel", "0,0", "--sample", "0"]);
    assert!(!text(&{ beside }.output().unwrap().stdout).contains("inf"));
    // Nor does it pass in a merged file.
    for (part, samples) in [("a.exr", "0..4"), ("b.exr", "4..8")] {
        folder.start(&["--samples", samples, "--color", "rgb", "-o", part]).wait().unwrap();
    }
    let merged = folder.command(ETALON, &["merge", "a.exr", "b.exr", "-o", "ab.exr"]).output().unwrap();
    let error = text(&merged.stderr);
    assert!(merged.status.code() == Some(1) && error.contains("pixels are not finite"), "{error}");
    assert!(folder.path("ab.exr").exists());
}
