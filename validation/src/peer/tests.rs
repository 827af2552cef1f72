//! Tests with peers without a process (a function from line to line), and with processes that misbehave.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{Lines, Peer, PeerError, Process, judge};
use crate::{
    checks::{CHECKS, Effort, find},
    report::Outcome,
    scatterer::{DVec3, Laws, Sample, Scatterer, direction},
    statistics::{Verdict, seed_for, sidak},
    subjects::{Conductor, Fault, Sabotaged},
};

/// A peer that answers with a subject of this crate, through the text of the protocol.
struct Local<'a>(&'a dyn Scatterer);

fn vectors(value: &Value) -> Vec<[f64; 3]> {
    serde_json::from_value(value.clone()).unwrap()
}

impl Lines for Local<'_> {
    fn exchange(&mut self, request: String) -> Result<String, PeerError> {
        let request: Value = serde_json::from_str(&request).unwrap();
        let wo = || vectors(&request["wo"]).into_iter().map(DVec3::from);
        let reply = match request["request"].as_str().unwrap() {
            "hello" => json!({"protocol": 1, "name": "local", "configurations":
                [{"name": "only", "laws": {"reciprocal": true}}]}),
            "evaluate" => {
                let pairs: Vec<_> = wo().zip(vectors(&request["wi"]).into_iter().map(DVec3::from)).collect();
                json!({"value": pairs.iter().map(|(wo, wi)| self.0.value(*wo, *wi)).collect::<Vec<_>>(),
                    "pdf": pairs.iter().map(|(wo, wi)| self.0.pdf(*wo, *wi)).collect::<Vec<_>>()})
            }
            _ => {
                let drawn: Vec<_> =
                    wo().zip(vectors(&request["u"])).map(|(wo, u)| self.0.sample(wo, u)).collect();
                json!({"wi": drawn.iter().map(|s| s.map(|s| s.wi.to_array())).collect::<Vec<_>>(),
                    "weight": drawn.iter().map(|s| s.map_or(0.0, |s| s.weight)).collect::<Vec<_>>(),
                    "pdf": drawn.iter().map(|s| s.map_or(0.0, |s| s.pdf)).collect::<Vec<_>>(),
                    "delta": drawn.iter().map(|s| s.is_some_and(|s| s.delta)).collect::<Vec<_>>()})
            }
        };
        Ok(reply.to_string())
    }
}

fn effort() -> Effort {
    Effort { samples: 1 << 14, level: sidak(0.01, CHECKS.len()), ..Effort::default() }
}

fn through_lines(subject: &dyn Scatterer, check: &str) -> Outcome {
    let check = find(check).unwrap();
    let mut peer = Peer::meet(Local(subject)).unwrap();
    judge(&mut peer, 0, |s| check.run(s, direction(0.6, 0.7), seed_for(check.name, 0), &effort())).unwrap()
}

#[test]
fn a_check_says_the_same_through_the_protocol() {
    let subject = Conductor { alpha: 0.7, r0: 0.9 };
    for check in CHECKS {
        let direct = check.run(&subject, direction(0.6, 0.7), seed_for(check.name, 0), &effort());
        assert_eq!(through_lines(&subject, check.name), direct);
    }
}

#[test]
fn a_saboteur_is_found_through_the_protocol() {
    let honest = Conductor { alpha: 0.7, r0: 0.9 };
    let subject = Sabotaged { honest: &honest, fault: Fault::PdfScaled };
    assert_eq!(through_lines(&subject, "normalisation").verdict, Verdict::Different);
}

/// A conductor whose values change from one question to the next.
struct Moody(Conductor, AtomicU32);

impl Scatterer for Moody {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.0.value(wo, wi) * (1.0 + 1e-3 * f64::from(self.1.fetch_add(1, Ordering::Relaxed)))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.0.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        self.0.sample(wo, u)
    }

    fn laws(&self) -> Laws {
        self.0.laws()
    }
}

#[test]
fn a_peer_that_gives_two_answers_to_one_question_is_told_so() {
    let moody = Moody(Conductor { alpha: 0.7, r0: 0.9 }, AtomicU32::new(0));
    let check = find("reciprocity").unwrap();
    let mut peer = Peer::meet(Local(&moody)).unwrap();
    let error = judge(&mut peer, 0, |s| check.run(s, direction(0.6, 0.7), 0, &effort())).unwrap_err().0;
    assert!(error.contains("two answers to the same question: `evaluate` with wo = "), "{error}");
}

/// A peer that greets and then always gives the same answer.
struct Parrot(&'static str);

impl Lines for Parrot {
    fn exchange(&mut self, request: String) -> Result<String, PeerError> {
        let hello = r#"{"protocol": 1, "name": "parrot", "configurations": [{"name": "a"}]}"#;
        Ok(if request.contains("hello") { hello.into() } else { self.0.into() })
    }
}

fn parroted(answer: &'static str) -> String {
    Peer::meet(Parrot(answer)).unwrap().evaluate(0, &[[DVec3::Z; 2]; 2]).unwrap_err().0
}

#[test]
fn an_answer_that_is_none_is_named() {
    assert!(parroted("hello?").contains("not understood"));
    assert!(parroted(r#"{"value": [NaN, 1], "pdf": [1, 1]}"#).contains("write null"));
    assert!(parroted(r#"{"value": [1, 1], "pdf": [1]}"#).contains("asked 2 questions; its \"pdf\" has 1"));
    assert!(parroted(r#"{"value": [1, 1]}"#).contains("missing field `pdf`"));
    assert!(parroted(r#"{"error": "no such configuration"}"#).contains("says: no such configuration"));
    assert!(parroted(r#"{"value": [1e999, 1], "pdf": [1, 1]}"#).contains("out of range"));
    assert!(parroted(r#"{"error": "red \u001b[31m, and\nmore"}"#).contains("says: red  [31m, and more"));
}

/// A peer whose greeting is this.
struct Greeter(&'static str);

impl Lines for Greeter {
    fn exchange(&mut self, _: String) -> Result<String, PeerError> {
        Ok(self.0.into())
    }
}

#[test]
fn configurations_of_one_name_are_refused() {
    let hello = r#"{"protocol": 1, "name": "twins", "configurations": [{"name": "a"}, {"name": "b"}, {"name": "a"}]}"#;
    let error = Peer::meet(Greeter(hello)).err().unwrap().0;
    assert_eq!(error, "two configurations are called \"a\"");
}

#[test]
fn what_stands_beside_no_sample_is_nobody_s_concern() {
    let drawn = |delta: &'static str, weight: &'static str, wi: &'static str| {
        let reply = format!(r#"{{"wi": [{wi}], "weight": [{weight}], "pdf": [1], "delta": [{delta}]}}"#);
        let mut peer = Peer::meet(Parrot(Box::leak(reply.into_boxed_str()))).unwrap();
        peer.sample(0, &[(DVec3::Z, [0.5; 3])])
    };
    assert_eq!(drawn("null", "\"none\"", "null"), Ok(vec![None]));
    assert!(drawn("true", "null", "[0, 0, 1]").is_ok_and(|s| s[0].is_some_and(|s| s.weight.is_nan())));
    let error = |delta, weight| drawn(delta, weight, "[0, 0, 1]").unwrap_err().to_string();
    assert!(error("null", "1").contains("\"delta\" has null"), "{}", error("null", "1"));
    assert!(error("true", "\"none\"").contains("expected a number or null"));
}

#[test]
fn null_is_not_a_number_and_is_judged() {
    let mut peer = Peer::meet(Parrot(r#"{"value": [null, 1], "pdf": [1, 1]}"#)).unwrap();
    let answers = peer.evaluate(0, &[[DVec3::Z; 2]; 2]).unwrap();
    assert!(answers[0][0].is_nan() && answers[1] == [1.0, 1.0]);
}

/// The error of a shell script that is no peer. Scripts that would run without end must not make this test do
/// so.
#[cfg(unix)]
fn fails(script: &str) -> String {
    let start = Instant::now();
    let process = Process::start(&format!("sh -c '{script}'"), Duration::from_millis(500)).unwrap();
    let error = Peer::meet(process).err().expect(script).0;
    assert!(start.elapsed() < Duration::from_secs(20), "{script}");
    error
}

#[cfg(unix)]
#[test]
fn a_program_that_is_no_peer_gives_one_error_and_no_wait() {
    assert!(fails("exit 3").contains("exit status: 3"));
    assert!(fails("read line; exec 1>&-; exit 0").contains("before it answered"));
    assert!(fails("exec sleep 100").contains("within 0.5 s"));
    assert!(fails("read line; echo Segmentation fault; exec sleep 100").contains("Segmentation fault"));
    assert!(fails("read line; echo {}; exec sleep 100").contains("missing field"));
    assert!(fails("read line; printf \"\\377\\n\"; exec sleep 100").contains("UTF-8"));
    assert!(fails("echo unasked; exec sleep 100").contains("unasked"));
    assert!(fails("exec cat /dev/zero").contains("peer"));
    assert!(Process::start("no-such-program-anywhere", Duration::from_secs(1)).is_err());
    assert!(Process::start("  ", Duration::from_secs(1)).is_err());
}

#[cfg(unix)]
#[test]
fn a_program_that_does_not_read_does_not_block() {
    let script = r#"read line; echo "{\"protocol\":1,\"name\":\"n\",\"configurations\":[{\"name\":\"a\"}]}"; exec sleep 100"#;
    let process = Process::start(&format!("sh -c '{script}'"), Duration::from_millis(500)).unwrap();
    let mut peer = Peer::meet(process).unwrap();
    let error = peer.evaluate(0, &vec![[direction(0.3, 0.2); 2]; 4096]).unwrap_err().0;
    assert!(error.contains("within 0.5 s"), "{error}");
}
