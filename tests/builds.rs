//! The same file from builds that share nothing but the source: every optimisation level, and a processor without AVX.

mod scenes;

use scenes::{SCENES, Units};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name, optimisation level and processor of a build that this test makes.
const BUILDS: &[(&str, &str, &str)] = &[("unoptimised", "0", "x86-64-v3"), ("without-avx", "1", "x86-64")];

/// Builds the program; its dependencies stay in the target folder for the next time.
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

fn render(program: &Path, scene: &Path, mode: &str) -> Vec<u8> {
    let image = scene.with_extension("exr");
    let status = Command::new(program)
        .args(["render", "--quiet", "--spp", "8", "--color", mode, "-o"])
        .args([&image, scene])
        .status()
        .unwrap();
    assert!(status.success(), "{} fails at {}", program.display(), scene.display());
    std::fs::read(image).unwrap()
}

#[test]
#[cfg(target_arch = "x86_64")]
fn no_build_changes_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    for (name, level, processor) in BUILDS {
        let other = build(&(name, level, processor));
        for trial in SCENES {
            let scene = folder.path().join("scene.xml");
            std::fs::write(&scene, trial.text(Units::default())).unwrap();
            let usual = render(Path::new(env!("CARGO_BIN_EXE_etalon")), &scene, trial.mode.name());
            let same = usual == render(&other, &scene, trial.mode.name());
            assert!(same, "`{}` differs between the usual build and the {name} one", trial.name);
        }
    }
}
