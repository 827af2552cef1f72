//! `validate bsdf --peer` on the example of the documentation. Without `python3` these tests say so and pass;
//! the protocol itself is tested in the crate `validation` without it.

use std::process::{Command, Output};

fn validate(peer: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_validate"));
    command.args(["bsdf", "--samples", "256", "--peer", peer]);
    command.output().expect("the binary of this package starts")
}

fn script(name: &str) -> Option<String> {
    let found = Command::new("python3").arg("--version").output().is_ok_and(|o| o.status.success());
    if !found {
        eprintln!("skipped: there is no python3");
    }
    found.then(|| format!("python3 '{}/../peers/{name}'", env!("CARGO_MANIFEST_DIR")))
}

#[test]
fn the_example_holds() {
    let Some(peer) = script("lambert.py") else { return };
    let output = validate(&peer);
    let text = String::from_utf8_lossy(&output.stdout);
    // Exit code 3 means too few samples for the stated power, which is no fault of the example.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{text}");
    assert!(text.contains(" 0 differ"), "{text}");
}

#[test]
fn a_density_two_per_cent_too_large_is_found() {
    let Some(peer) = script("lambert_wrong.py") else { return };
    let output = validate(&peer);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.lines().any(|l| l.starts_with("different") && l.contains("::normalisation::")), "{text}");
}

#[test]
fn a_peer_that_is_none_is_bad_input() {
    for peer in ["no-such-program-anywhere", "", "python3 'open"] {
        let output = validate(peer);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}
