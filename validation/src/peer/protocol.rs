//! The messages of harness and peer: docs/peer-protocol.md.

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;

use super::{PeerError, process::beginning};
use crate::scatterer::{DVec3, Laws, Sample};

/// The version of the protocol.
pub const PROTOCOL: u32 = 1;

/// Largest number of queries in a request.
const BATCH: usize = 4096;

/// A channel that answers a line with a line.
pub trait Lines {
    fn exchange(&mut self, request: String) -> Result<String, PeerError>;
}

#[derive(Serialize)]
#[serde(tag = "request", rename_all = "lowercase")]
enum Request {
    Hello { protocol: u32 },
    Evaluate { configuration: usize, wo: Vec<[f64; 3]>, wi: Vec<[f64; 3]> },
    Sample { configuration: usize, wo: Vec<[f64; 3]>, u: Vec<[f64; 3]> },
}

/// The peer's introduction: its name and its configurations.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    pub protocol: u32,
    pub name: String,
    #[serde(default)]
    pub version: String,
    pub configurations: Vec<Configuration>,
}

/// A distribution with all of its parameters, at one wavelength.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Configuration {
    pub name: String,
    #[serde(default)]
    pub laws: Claims,
    /// See [`crate::checks::Effort::tolerance`].
    #[serde(default = "single_precision")]
    pub tolerance: f64,
    /// See [`crate::checks::Effort::smallest`].
    #[serde(default)]
    pub smallest: f64,
}

fn single_precision() -> f64 {
    1e-5
}

/// The laws that a configuration claims to obey, in addition to being consistent.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Claims {
    pub reciprocal: bool,
    pub lossless: bool,
    pub eta: Option<f64>,
    pub phase_function: bool,
}

impl Claims {
    /// The same claims as [`Laws`].
    pub fn laws(&self) -> Laws {
        Laws { reciprocal: self.reciprocal, lossless: self.lossless, eta: self.eta }
    }
}

#[derive(Deserialize)]
struct Evaluated {
    value: Vec<Option<f64>>,
    pdf: Vec<Option<f64>>,
}

#[derive(Deserialize)]
struct Sampled {
    wi: Vec<Option<[Option<f64>; 3]>>,
    // Whatever they hold where there is no sample.
    weight: Vec<Value>,
    pdf: Vec<Value>,
    delta: Vec<Value>,
}

impl Sampled {
    /// Error: there is a sample, and something of it is of another kind than it should be.
    fn sample(&self, i: usize) -> Result<Option<Sample>, PeerError> {
        let Some(wi) = self.wi[i] else { return Ok(None) };
        let strange = |name: &str, value: &Value, kind: &str| {
            PeerError(format!("the peer's \"{name}\" has {value} where there is a sample; expected {kind}"))
        };
        let quantity = |name: &str, value: &Value| match value {
            Value::Null => Ok(f64::NAN),
            _ => value.as_f64().ok_or_else(|| strange(name, value, "a number or null")),
        };
        let delta = self.delta[i].as_bool();
        Ok(Some(Sample {
            wi: DVec3::from(wi.map(number)),
            weight: quantity("weight", &self.weight[i])?,
            pdf: quantity("pdf", &self.pdf[i])?,
            delta: delta.ok_or_else(|| strange("delta", &self.delta[i], "true or false"))?,
        }))
    }
}

#[derive(Deserialize)]
struct Failed {
    error: String,
}

/// A program that has introduced itself.
pub struct Peer<L> {
    lines: L,
    pub hello: Hello,
}

impl<L: Lines> Peer<L> {
    /// Sends the greeting. Errors: no valid answer, another version of the protocol, no configurations, or
    /// values out of range.
    pub fn meet(mut lines: L) -> Result<Self, PeerError> {
        let hello: Hello = ask(&mut lines, &Request::Hello { protocol: PROTOCOL })?;
        if hello.protocol != PROTOCOL {
            let message = format!("the peer speaks protocol {}, not {PROTOCOL}", hello.protocol);
            return Err(PeerError(message));
        }
        if hello.configurations.is_empty() {
            return Err(PeerError("the peer offers no configuration".into()));
        }
        for (number, c) in hello.configurations.iter().enumerate() {
            if hello.configurations[..number].iter().any(|other| other.name == c.name) {
                return Err(PeerError(format!("two configurations are called {:?}", c.name)));
            }
            let index = c.laws.eta.unwrap_or(1.0);
            let sound = c.tolerance > 0.0 && c.tolerance <= 0.01 && (0.0..=1e-6).contains(&c.smallest);
            if !sound || !index.is_finite() || index <= 0.0 {
                let message = format!(
                    "configuration {:?}: tolerance must lie in (0, 0.01], smallest in [0, 1e-6], and eta be positive",
                    c.name
                );
                return Err(PeerError(message));
            }
        }
        Ok(Self { lines, hello })
    }

    /// f |cos θi| and density for pairs (wo, wi), in their order.
    pub fn evaluate(
        &mut self,
        configuration: usize,
        queries: &[[DVec3; 2]],
    ) -> Result<Vec<[f64; 2]>, PeerError> {
        let mut answers = vec![];
        for batch in queries.chunks(BATCH) {
            let request = Request::Evaluate {
                configuration,
                wo: batch.iter().map(|q| q[0].to_array()).collect(),
                wi: batch.iter().map(|q| q[1].to_array()).collect(),
            };
            let reply: Evaluated = ask(&mut self.lines, &request)?;
            same_length("value", batch.len(), reply.value.len())?;
            same_length("pdf", batch.len(), reply.pdf.len())?;
            answers.extend(reply.value.iter().zip(&reply.pdf).map(|(v, p)| [number(*v), number(*p)]));
        }
        Ok(answers)
    }

    /// Directions for pairs (wo, u), in their order.
    pub fn sample(
        &mut self,
        configuration: usize,
        queries: &[(DVec3, [f64; 3])],
    ) -> Result<Vec<Option<Sample>>, PeerError> {
        let mut answers = vec![];
        for batch in queries.chunks(BATCH) {
            let request = Request::Sample {
                configuration,
                wo: batch.iter().map(|q| q.0.to_array()).collect(),
                u: batch.iter().map(|q| q.1).collect(),
            };
            let reply: Sampled = ask(&mut self.lines, &request)?;
            let lengths = [
                ("wi", reply.wi.len()),
                ("weight", reply.weight.len()),
                ("pdf", reply.pdf.len()),
                ("delta", reply.delta.len()),
            ];
            for (what, length) in lengths {
                same_length(what, batch.len(), length)?;
            }
            for i in 0..batch.len() {
                answers.push(reply.sample(i)?);
            }
        }
        Ok(answers)
    }
}

/// JSON has no NaN; `null` stands for it.
fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn same_length(what: &str, asked: usize, answered: usize) -> Result<(), PeerError> {
    let message = || format!("the peer was asked {asked} questions; its \"{what}\" has {answered} entries");
    if asked == answered { Ok(()) } else { Err(PeerError(message())) }
}

fn ask<T: DeserializeOwned>(lines: &mut impl Lines, request: &Request) -> Result<T, PeerError> {
    let text = serde_json::to_string(request).map_err(|e| PeerError(e.to_string()))?;
    let reply = lines.exchange(text)?;
    if let Ok(failed) = serde_json::from_str::<Failed>(&reply) {
        // It is another program's text, and goes to a terminal.
        let said: String = failed.error.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        return Err(PeerError(format!("the peer says: {said}")));
    }
    serde_json::from_str(&reply).map_err(|error| {
        let bare = ["NaN", "Infinity"].iter().any(|word| reply.contains(word));
        let hint =
            if bare { "; JSON has no NaN or Infinity, write null for a number that is none" } else { "" };
        PeerError(format!("the peer's answer {} is not understood: {error}{hint}", beginning(&reply)))
    })
}
