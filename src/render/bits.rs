//! Numbers as their bits, for JSON: it has neither infinities nor NaN, and decimals may be rounded when they are read.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub fn serialize<S: Serializer>(numbers: &[f64; 3], to: S) -> Result<S::Ok, S::Error> {
    numbers.map(f64::to_bits).serialize(to)
}

pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<[f64; 3], D::Error> {
    Ok(<[u64; 3]>::deserialize(from)?.map(f64::from_bits))
}
