//! Place and date of a report.

use crate::provenance::{Provenance, UNKNOWN, processor, today};

/// Names and values of facts about the machine and the sources, for people.
pub fn here() -> Vec<(&'static str, String)> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut facts = vec![
        ("date", today()),
        ("validate", env!("CARGO_PKG_VERSION").to_string()),
        ("processor", processor().unwrap_or_else(|| std::env::consts::ARCH.into())),
        ("cores", cores.to_string()),
        ("system", format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)),
    ];
    let commit = Provenance::here().commit;
    if commit != UNKNOWN {
        facts.insert(2, ("commit", commit));
    }
    facts
}

/// The commit and the processor in a few words, to be stored with measurements.
pub fn in_short() -> String {
    let wanted = |(name, value): (&str, String)| match name {
        "commit" | "processor" => Some(value),
        "cores" => Some(format!("{value} cores")),
        _ => None,
    };
    here().into_iter().filter_map(wanted).collect::<Vec<_>>().join(", ")
}
