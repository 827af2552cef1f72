//! Mitsuba in a separate process: `validation/peers/mitsuba_scenes.py`.

use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A request: what to render.
#[derive(Serialize)]
pub struct Job<'a> {
    pub scene: &'a Path,
    /// The image file to write, with the means and their variances.
    pub out: &'a Path,
    /// The name from which seeds are derived.
    pub name: &'a str,
    /// `rgb` or `spectral`.
    pub mode: &'a str,
    /// Samples per pixel of each replicate.
    pub spp: u32,
    pub replicates: u32,
}

/// The reply to a [`Job`].
#[derive(Debug, Default, Deserialize)]
pub struct Reply {
    /// Mitsuba's error message, if it rendered no image.
    pub error: Option<String>,
    #[serde(default)]
    pub channels: Vec<String>,
    /// Standard error of each channel's mean.
    #[serde(default)]
    pub standard_error: Vec<f64>,
}

/// The running process.
pub struct Mitsuba {
    child: Child,
    requests: ChildStdin,
    replies: BufReader<ChildStdout>,
}

impl Mitsuba {
    /// Starts Python. Errors: no `python3`.
    pub fn start() -> Result<Self, String> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/mitsuba_scenes.py");
        let mut command = Command::new("python3");
        command.arg(script).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|e| format!("python3 does not start: {e}"))?;
        let (Some(requests), Some(replies)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("python3 has no pipes".into());
        };
        Ok(Self { child, requests, replies: BufReader::new(replies) })
    }

    /// Sends a request; [`Self::receive`] waits for the reply.
    pub fn send(&mut self, job: &Job) -> Result<(), String> {
        let line = serde_json::to_string(job).map_err(|e| e.to_string())?;
        writeln!(self.requests, "{line}").and_then(|()| self.requests.flush()).map_err(|e| e.to_string())
    }

    pub fn receive(&mut self) -> Result<Reply, String> {
        let mut line = String::new();
        let length = self.replies.read_line(&mut line).map_err(|e| e.to_string())?;
        if length == 0 {
            return Err(format!("Mitsuba's process ended: {:?}", self.child.wait()));
        }
        serde_json::from_str(&line).map_err(|e| format!("{e}: {line}"))
    }
}

impl Drop for Mitsuba {
    fn drop(&mut self) {
        // Both fail only if the process has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
