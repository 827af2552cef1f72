//! The checks on another program's scattering distributions, over the protocol of docs/peer-protocol.md.

use std::time::Duration;

use validation::checks::{CHECKS, Effort};
use validation::peer::{Peer, PeerError, Process, judge};
use validation::statistics::{seed_for, sidak};
use validation::{Outcome, Report, Scatterer};

use crate::trial::{ANGLES, from};

/// What to ask of a peer.
pub struct Settings<'a> {
    /// Only configurations whose name contains this.
    pub name: Option<&'a str>,
    /// Samples a check.
    pub samples: usize,
    /// Another number, other seeds.
    pub number: u64,
    /// How long the peer may take for one answer.
    pub limit: Duration,
}

/// What asks questions by the answers to the last ones, many thousands in all: over a pipe that takes
/// minutes.
const STEP_BY_STEP: [&str; 2] = ["jacobian", "moments"];

/// Starts `command` and runs every check that applies on each of its configurations, from each direction of
/// [`ANGLES`]. `progress` sees each outcome as it comes.
pub fn run(command: &str, settings: &Settings, progress: impl Fn(&Outcome)) -> Result<Report, PeerError> {
    let mut peer = Peer::meet(Process::start(command, settings.limit)?)?;
    let configurations: Vec<_> = peer
        .hello
        .configurations
        .iter()
        .cloned()
        .enumerate()
        .filter(|(_, c)| settings.name.is_none_or(|name| c.name.contains(name)))
        .collect();
    if configurations.is_empty() {
        return Err(PeerError("the peer has no configuration of that name".into()));
    }
    // Every trial shares the suite's level of 1 % (Šidák).
    let level = sidak(0.01, configurations.len() * CHECKS.len() * ANGLES.len());
    let mut outcomes = vec![];
    for (index, configuration) in &configurations {
        let effort = Effort {
            samples: settings.samples,
            level,
            tolerance: configuration.tolerance,
            smallest: configuration.smallest,
            ..Effort::default()
        };
        for check in CHECKS.iter().filter(|check| !STEP_BY_STEP.contains(&check.name)) {
            for angle in ANGLES {
                let name = format!("{}::{}::{angle}", configuration.name, check.name);
                let (wo, seed) = (from(angle), seed_for(&name, settings.number));
                let run = |s: &dyn Scatterer| (check.applies)(s).then(|| check.run(s, wo, seed, &effort));
                let Some(outcome) = judge(&mut peer, *index, run)? else { continue };
                let outcome = outcome.of(name);
                progress(&outcome);
                outcomes.push(outcome);
            }
        }
    }
    let title = format!("{} {}", peer.hello.name, peer.hello.version);
    Ok(Report::new(title.trim(), outcomes))
}
