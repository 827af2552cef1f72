//! Building the scratch copy, and reading what cargo says of it.

use super::plant::Place;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A compiled test program.
#[derive(Clone, Debug)]
pub struct Program {
    /// The package, and the file of tests unless it is the library itself.
    pub name: String,
    pub path: PathBuf,
    /// Where cargo would run it.
    pub folder: PathBuf,
}

/// Programs that cannot see a bug of the renderer, or that watch over the museum itself.
const BLIND: [&str; 2] = ["validation", "validate::museum"];

fn run(scratch: &Path, arguments: &[&str]) -> Result<Output, String> {
    Command::new("nice")
        .args(["-n", "15", "cargo"])
        .args(arguments)
        .args(["--release", "--message-format=json"])
        .env("CARGO_TARGET_DIR", scratch.join("build"))
        .current_dir(scratch.join("tree"))
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cargo: {e}"))
}

fn messages(output: &Output) -> Vec<Value> {
    String::from_utf8_lossy(&output.stdout).lines().filter_map(|l| serde_json::from_str(l).ok()).collect()
}

/// Which changes the compiler refuses, by index. An error elsewhere is an error.
pub fn refused(scratch: &Path, places: &[Place]) -> Result<BTreeSet<usize>, String> {
    let output = run(scratch, &["build", "--package", "etalon", "--lib"])?;
    let mut refused = BTreeSet::new();
    for message in messages(&output).iter().map(|m| &m["message"]).filter(|m| m["level"] == "error") {
        let before = refused.len();
        let spans = message["spans"].as_array().into_iter().flatten();
        for span in spans.filter(|span| span["is_primary"] == true) {
            let (start, file) = (span["byte_start"].as_u64().unwrap_or(0) as usize, &span["file_name"]);
            let met = |(name, range): &Place| file == name.as_str() && range.contains(&start);
            refused.extend((0..places.len()).filter(|&i| met(&places[i])));
        }
        let summary = message["spans"].as_array().is_none_or(|spans| spans.is_empty());
        if refused.len() == before && !summary && refused.is_empty() {
            return Err(message["rendered"].to_string());
        }
    }
    match output.status.success() || !refused.is_empty() {
        true => Ok(refused),
        false => Err("the scratch copy does not compile".into()),
    }
}

/// Compiles all test programs of the workspace.
pub fn test_programs(scratch: &Path) -> Result<Vec<Program>, String> {
    let output = run(scratch, &["test", "--workspace", "--no-run"])?;
    if !output.status.success() {
        return Err("the tests of the scratch copy do not compile".into());
    }
    let programs = messages(&output).into_iter().filter_map(|message| {
        let path = PathBuf::from(message["executable"].as_str()?);
        let test = message["profile"]["test"] == true && message["target"]["kind"][0] != "bench";
        let manifest = PathBuf::from(message["manifest_path"].as_str()?);
        let folder = manifest.parent()?.to_owned();
        let package = match folder.strip_prefix(scratch.join("tree")).ok()?.to_str()? {
            "" => "etalon",
            "validation/cli" => "validate",
            other => other,
        };
        let kind = message["target"]["kind"][0].as_str()?;
        let name = match kind {
            "lib" => package.to_owned(),
            _ => format!("{package}::{}", message["target"]["name"].as_str()?),
        };
        (test && matches!(kind, "lib" | "test")).then_some(Program { name, path, folder })
    });
    Ok(programs.filter(|program| !BLIND.contains(&program.name.as_str())).collect())
}
