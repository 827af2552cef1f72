//! The checks on another program's scattering distributions, over the protocol of docs/peer-protocol.md.

use std::time::Duration;

use validation::checks::{CHECKS, Effort};
use validation::peer::{Peer, PeerError, Process, judge};
use validation::statistics::{seed_for, sidak};
use validation::{Outcome, Report, Scatterer};

use crate::direction::directions;

/// The selection and the effort of checks on a peer.
pub struct Settings<'a> {
    /// Only configurations whose name contains this.
    pub name: Option<&'a str>,
    /// Only this check.
    pub check: Option<&'a str>,
    /// Samples per check.
    pub samples: usize,
    /// Number that determines the seeds.
    pub number: u64,
    /// Time limit of an answer.
    pub limit: Duration,
}

/// Checks left out for peers: each of their many thousands of queries depends on the last answers, which
/// takes minutes over a pipe.
const STEP_BY_STEP: [&str; 2] = ["jacobian", "moments"];

/// Checks whose questions the protocol has no words for: other wavelengths, and parameters that tend to a limit.
const WITHOUT_WORDS: [&str; 2] = ["spectral", "limits"];

/// Starts `command` and runs every check that applies on each of its configurations, for each of its
/// [`directions`]. `progress` gets each outcome as it becomes known.
pub fn run(command: &str, settings: &Settings, progress: impl Fn(&Outcome)) -> Result<Report, PeerError> {
    let asked: Vec<_> = CHECKS
        .iter()
        .filter(|check| !STEP_BY_STEP.contains(&check.name) && !WITHOUT_WORDS.contains(&check.name))
        .collect();
    if let Some(unknown) = settings.check.filter(|name| asked.iter().all(|check| check.name != *name)) {
        let names: Vec<_> = asked.iter().map(|check| check.name).collect();
        return Err(PeerError(format!(
            "no check {unknown:?} of peers, expected one of {}",
            names.join(", ")
        )));
    }
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
    let asked_from: usize = configurations.iter().map(|(_, c)| directions(&c.laws.laws()).len()).sum();
    let level = sidak(0.01, asked_from * CHECKS.len());
    let mut outcomes = vec![];
    for (index, configuration) in &configurations {
        let effort = Effort {
            samples: settings.samples,
            level,
            tolerance: configuration.tolerance,
            smallest: configuration.smallest,
            ..Effort::default()
        };
        for check in asked.iter().filter(|check| settings.check.is_none_or(|name| name == check.name)) {
            for direction in directions(&configuration.laws.laws()) {
                let name = format!("{}::{}::{direction}", configuration.name, check.name);
                let wo = direction.vector(&name, settings.number);
                let seed = seed_for(&name, settings.number);
                let run = |s: &dyn Scatterer| (check.applies)(s).then(|| check.run(s, wo, seed, &effort));
                let outcome =
                    judge(&mut peer, *index, run).map_err(|e| PeerError(format!("{name}: {}", e.0)))?;
                let Some(outcome) = outcome else { continue };
                let outcome = outcome.of(name);
                progress(&outcome);
                outcomes.push(outcome);
            }
        }
    }
    let title = format!("{} {}", peer.hello.name, peer.hello.version);
    Ok(Report::new(title.trim(), outcomes))
}
