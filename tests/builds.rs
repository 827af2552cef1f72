//! Different builds of the same source must write the same file: every optimisation level, processors with
//! less and with more than AVX2, a processor emulated by valgrind, and any other on which a given command
//! runs the program.
//!
//! Slow tests are ignored by default: `cargo test --release --test builds -- --ignored processor valgrind`
//! runs them; another machine is tested by `tests/aarch64.sh`.

mod scenes;

use scenes::{SCENES, Units};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name, optimisation level and processor of the builds that the default test makes.
const BUILDS: &[(&str, &str, &str)] = &[("unoptimised-without-avx", "0", "x86-64")];

/// Further builds: little or no optimisation, all features of this machine, no AVX2, and no AVX.
const FURTHER: &[(&str, &str, &str)] = &[
    ("unoptimised", "0", "x86-64-v3"),
    ("hardly-optimised", "1", "x86-64-v3"),
    ("native", "3", "native"),
    ("without-avx2", "3", "x86-64-v3 -C target-feature=-avx2,-fma"),
    ("plain", "3", "x86-64"),
];

/// Builds the program; its dependencies stay in the target folder for the next run.
fn build((name, level, processor): &(&str, &str, &str)) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/builds").join(name);
    let status = Command::new(env!("CARGO"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["build", "--quiet", "--release", "--package", "etalon", "--bin", "etalon", "--target-dir"])
        .arg(&folder)
        .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", level)
        .env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16")
        .env("CARGO_PROFILE_RELEASE_DEBUG", "0")
        .env("RUSTFLAGS", format!("-C target-cpu={processor}"))
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status()
        .unwrap();
    assert!(status.success(), "{name} does not build");
    folder.join("release/etalon")
}

/// Renders a scene with a command (a program, or an emulator and a program) and returns the file.
fn render(command: &[&str], scene: &Path, mode: &str) -> Vec<u8> {
    let image = scene.with_extension("exr");
    let output = Command::new(command[0])
        .args(&command[1..])
        .args(["render", "--quiet", "--spp", "8", "--color", mode, "-o"])
        .args([&image, scene])
        .output()
        .unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::read(image).unwrap()
}

/// Compares the files of all scenes with those of the usual build.
fn require_same(name: &str, command: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for trial in SCENES {
        let scene = folder.path().join("scene.xml");
        std::fs::write(&scene, trial.text(Units::default())).unwrap();
        let usual = render(&[env!("CARGO_BIN_EXE_etalon")], &scene, trial.mode.name());
        let same = usual == render(command, &scene, trial.mode.name());
        assert!(same, "`{}` differs between the usual build and the {name} one", trial.name);
    }
}

#[test]
#[cfg(target_arch = "x86_64")]
fn no_build_changes_a_bit() {
    for (name, level, processor) in BUILDS {
        require_same(name, &[&build(&(name, level, processor)).to_string_lossy()]);
    }
}

#[test]
#[ignore = "five builds more"]
#[cfg(target_arch = "x86_64")]
fn no_processor_changes_a_bit() {
    for (name, level, processor) in FURTHER {
        require_same(name, &[&build(&(name, level, processor)).to_string_lossy()]);
    }
}

#[test]
#[ignore = "needs valgrind"]
fn valgrind_changes_no_bit() {
    let quiet = ["valgrind", "--tool=none", "--quiet", env!("CARGO_BIN_EXE_etalon")];
    require_same("valgrind's", &quiet);
}

/// `ETALON_OTHER` is a command that runs the program built for another processor, as tests/aarch64.sh makes
/// one.
#[test]
#[ignore = "needs the variable ETALON_OTHER"]
fn another_machine_changes_no_bit() {
    let command = std::env::var("ETALON_OTHER").expect("ETALON_OTHER is a command");
    require_same("other", &command.split_whitespace().collect::<Vec<_>>());
}
