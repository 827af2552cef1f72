//! No seed is picked by hand: trying seeds until a test passes would invalidate it.
//!
//! A seed is a name's hash (`Stream::named`), or counts from 0. So the only literals are 0 and 1, and a
//! search of all sources finds any other.

use std::path::{Path, PathBuf};

/// Texts that precede a literal seed.
const MARKS: [&str; 12] = [
    "seed: ",
    "seed = ",
    "Some(seed",
    "settings(&scene, ",
    "Stream::new(",
    "Sampler::new(SamplerKind::Independent, ",
    "Sampler::new(SamplerKind::Sobol, ",
    "Pcg32::new(",
    "Pcg64::new(",
    "Pcg64Mcg::new(",
    "\"--seed\", \"",
    "name=\\\"seed\\\" value=\\\"",
];

/// Texts that precede a name and then a literal seed.
const NAMED: [&str; 2] = ["Stream::named(\"", "seed_for(\""];

/// Literals on which no statistic depends, by file.
const EXCEPTIONS: [(&str, &str); 10] = [
    (
        "src/shape/accel/tests.rs",
        "what is drawn differs from test to test; what is asserted holds of every ray",
    ),
    (
        "src/shape/accel/instances.rs",
        "what is drawn differs from test to test; what is asserted holds of every ray",
    ),
    ("src/shape/accel/splits.rs", "shapes are drawn, and what is asserted of them is geometry"),
    ("src/scene/instances.rs", "what is asserted holds of every ray, or of bits"),
    ("src/image/merge/tests.rs", "another seed must be refused"),
    ("src/render/checkpoint/tests.rs", "another seed must be refused"),
    ("tests/resume.rs", "another seed must be refused"),
    ("tests/refusal/files.rs", "a seed of more than 32 bits must be refused"),
    ("validation/src/statistics/seed.rs", "the hash itself"),
    ("validation/cli/tests/seeds.rs", "the marks themselves"),
];

/// The literals of a text that are seeds, and neither 0 nor 1.
fn picked(text: &str) -> Vec<String> {
    let after = |mark: &str, rest: &str| {
        let literal: String = rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        let digits = literal.replace('_', "");
        let number = digits.trim_end_matches("u64").trim_end_matches("u32");
        // A number that is part of an expression is a count, not a seed.
        let alone = !rest[literal.len()..].trim_start().starts_with(['*', '+', '-', '/']);
        (alone && number.starts_with(|c: char| c.is_ascii_digit()) && !["0", "1"].contains(&number))
            .then(|| format!("{mark}{literal}"))
    };
    let plain =
        MARKS.iter().flat_map(|mark| text.match_indices(mark).map(move |(at, _)| (*mark, at + mark.len())));
    let named = NAMED.iter().flat_map(|mark| {
        text.match_indices(mark).filter_map(move |(at, _)| {
            let start = at + mark.len();
            Some((*mark, start + text[start..].find("\", ")? + 3))
        })
    });
    plain.chain(named).filter_map(|(mark, at)| after(mark, &text[at..])).collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().filter_map(Result::ok) {
        let path = entry.path();
        if path.is_dir() && path.file_name().is_none_or(|name| name != "target") {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn no_seed_is_picked_by_hand() {
    let root = validate::museum::root().canonicalize().unwrap();
    let mut files = vec![];
    for folder in ["src", "tests", "benches", "examples", "validation"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 200, "{} sources", files.len());
    let (mut found, mut excused) = (vec![], vec![]);
    for file in files {
        let name = file.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&file).unwrap();
        let literals = picked(&text);
        if EXCEPTIONS.iter().all(|(exception, _)| *exception != name) {
            found.extend(literals.iter().map(|literal| format!("{name}: {literal}")));
        } else if !literals.is_empty() {
            excused.push(name);
        }
    }
    assert!(found.is_empty(), "seeds picked by hand:\n{}", found.join("\n"));
    let idle =
        EXCEPTIONS.iter().map(|(name, _)| *name).filter(|name| !excused.iter().any(|used| used == name));
    let idle: Vec<&str> = idle.collect();
    assert!(idle.is_empty(), "exceptions that nothing needs: {}", idle.join(", "));
}

#[test]
fn picked_seeds_are_seen() {
    assert_eq!(picked("Settings { seed: 42, .. }"), ["seed: 42"]);
    assert_eq!(picked("Stream::new(0xcafe)"), ["Stream::new(0xcafe"]);
    assert_eq!(picked("Stream::named(\"a test\", 17)"), ["Stream::named(\"17"]);
    let honest = "Stream::named(\"a test\", number); seed: 0, seed: 1u64, seed_for(\"x\", 8 * index)";
    assert!(picked(honest).is_empty());
}
