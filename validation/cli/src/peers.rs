//! The checks on another program's scattering distributions, over the protocol of docs/peer-protocol.md.

use std::f64::consts::TAU;
use std::time::Duration;

use validation::checks::{CHECKS, Effort};
use validation::peer::{Peer, PeerError, Process, judge};
use validation::scatterer::{DVec3, direction};
use validation::statistics::{Stream, seed_for, sidak};
use validation::{Outcome, Report, Scatterer};

use crate::trial::{angles, from};

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

/// A direction above the surface, another for every check and every number: faults may be anywhere.
fn drawn(about: &str, number: u64) -> DVec3 {
    let mut stream = Stream::named(&format!("direction of {about}"), number);
    let cos = stream.uniform();
    direction(cos, TAU * stream.uniform())
}

/// Starts `command` and runs every check that applies on each of its configurations, for each direction of
/// [`angles`], and for one that is drawn. `progress` gets each outcome as it becomes known.
pub fn run(command: &str, settings: &Settings, progress: impl Fn(&Outcome)) -> Result<Report, PeerError> {
    let asked: Vec<_> = CHECKS
        .iter()
        .filter(|check| !STEP_BY_STEP.contains(&check.name) && !WITHOUT_WORDS.contains(&check.name))
        .collect();
    if let Some(stranger) = settings.check.filter(|name| asked.iter().all(|check| check.name != *name)) {
        let names: Vec<_> = asked.iter().map(|check| check.name).collect();
        return Err(PeerError(format!(
            "no check {stranger:?} of peers, expected one of {}",
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
    let directions: usize = configurations.iter().map(|(_, c)| angles(&c.laws.laws()).len() + 1).sum();
    let level = sidak(0.01, directions * CHECKS.len());
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
            let usual =
                angles(&configuration.laws.laws()).into_iter().map(|angle| (angle.to_string(), from(angle)));
            let about = format!("{}::{}", configuration.name, check.name);
            for (direction, wo) in usual.chain([("drawn".to_owned(), drawn(&about, settings.number))]) {
                let name = format!("{about}::{direction}");
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
