//! Builds the scratch copy, and parses cargo's messages.

use super::plant::Place;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A compiled test program.
#[derive(Clone, Debug)]
pub struct Program {
    /// The package, and the test file unless it is the library itself.
    pub name: String,
    pub path: PathBuf,
    /// The folder in which cargo would run it.
    pub folder: PathBuf,
}

/// Programs that cannot detect a bug of the renderer, that compare builds which all have it, or that read
/// sources.
const BLIND: [&str; 5] = ["validation", "validate", "etalon::builds", "validate::museum", "validate::seeds"];

/// The result of compiling a scratch copy.
pub enum Compiled {
    /// The test programs of the workspace.
    Programs(Vec<Program>),
    /// The changes that the compiler rejects, by index.
    Refused(BTreeSet<usize>),
}

/// Compiles all test programs. Errors: a compiler error outside of the changes.
pub fn compile(scratch: &Path, places: &[Place]) -> Result<Compiled, String> {
    let output = Command::new("nice")
        .args(["-n", "15", "cargo", "test", "--workspace", "--no-run", "--release", "--message-format=json"])
        .env("CARGO_TARGET_DIR", scratch.join("build"))
        .current_dir(scratch.join("tree"))
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cargo: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let messages = || text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    if output.status.success() {
        return Ok(Compiled::Programs(messages().filter_map(|message| program(scratch, &message)).collect()));
    }
    let errors: Vec<Value> =
        messages().map(|m| m["message"].clone()).filter(|m| m["level"] == "error").collect();
    let refused: BTreeSet<usize> = errors.iter().flat_map(|error| met(error, places)).collect();
    if refused.is_empty() {
        let told: Vec<&str> = errors.iter().filter_map(|error| error["rendered"].as_str()).collect();
        return Err(format!("the scratch copy does not compile:\n{}", told.join("\n")));
    }
    Ok(Compiled::Refused(refused))
}

/// The changes that contain an error.
fn met(error: &Value, places: &[Place]) -> Vec<usize> {
    let primary = error["spans"].as_array().into_iter().flatten().filter(|span| span["is_primary"] == true);
    let lies = |span: &Value, (file, range): &Place| {
        let start = span["byte_start"].as_u64().unwrap_or(0) as usize;
        span["file_name"] == file.as_str() && range.contains(&start)
    };
    primary.flat_map(|span| (0..places.len()).filter(|&i| lies(span, &places[i]))).collect()
}

/// The test program that a message of cargo announces.
fn program(scratch: &Path, message: &Value) -> Option<Program> {
    let path = PathBuf::from(message["executable"].as_str()?);
    let kind = message["target"]["kind"][0].as_str().filter(|kind| ["lib", "test"].contains(kind))?;
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?.to_owned();
    let package = match folder.strip_prefix(scratch.join("tree")).ok()?.to_str()? {
        "" => "etalon",
        "validation/cli" => "validate",
        other => other,
    };
    let name = match kind {
        "lib" => package.to_owned(),
        _ => format!("{package}::{}", message["target"]["name"].as_str()?),
    };
    (message["profile"]["test"] == true && !BLIND.contains(&name.as_str())).then_some(Program {
        name,
        path,
        folder,
    })
}
