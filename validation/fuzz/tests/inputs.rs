//! A short run over every format: the regressions, the seeds, and some mutated inputs.

use std::process::Command;

#[test]
fn damaged_files_break_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fuzz"));
    command.args(["input", "--count", "300", "--seconds", "3", "--folder"]).arg(folder.path());
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(text.lines().count(), 8, "{text}");
}
