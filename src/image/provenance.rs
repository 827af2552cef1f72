//! Provenance of an image: everything that determines its bits.

use super::ImageError;
use std::collections::BTreeMap;
use std::ops::Range;

/// What was rendered and how, as stored in the header of the file. Two images with equal provenance and
/// window are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Version of Etalon.
    pub version: String,
    /// Hash of the scene and of all files it uses.
    pub scene: String,
    /// Seed of the sampler.
    pub seed: u64,
    /// The samples of each pixel, `start` included, `end` excluded.
    pub samples: Range<u64>,
    /// The compiled kernel that ran.
    pub kernel: String,
    /// Name of the integrator.
    pub integrator: String,
    /// Further attributes, by name.
    pub extra: BTreeMap<String, Attribute>,
}

/// The value of a further attribute, in one of OpenEXR's types.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// `string`
    Text(String),
    /// `int`
    Integer(i32),
    /// `float`
    Real(f32),
}

const REQUIRED: [&str; 6] = ["version", "scene", "seed", "samples", "kernel", "integrator"];

impl Provenance {
    /// All attributes by name. The seed and the sample range are text because OpenEXR's integers have 32
    /// bits.
    pub(super) fn to_attributes(&self) -> Result<BTreeMap<String, Attribute>, ImageError> {
        let mut attributes = self.extra.clone();
        let samples = format!("{}..{}", self.samples.start, self.samples.end);
        let values =
            [&self.version, &self.scene, &self.seed.to_string(), &samples, &self.kernel, &self.integrator];
        for (name, value) in REQUIRED.into_iter().zip(values) {
            if attributes.insert(name.to_owned(), Attribute::Text(value.clone())).is_some() {
                return Err(ImageError::new(format!("the attribute `{name}` is reserved")));
            }
        }
        Ok(attributes)
    }

    /// The provenance with these attributes.
    pub(super) fn from_attributes(
        mut attributes: BTreeMap<String, Attribute>,
    ) -> Result<Provenance, ImageError> {
        let mut text = |name: &str| match attributes.remove(name) {
            Some(Attribute::Text(text)) => Ok(text),
            _ => Err(ImageError::new(format!("the text attribute `{name}` is missing"))),
        };
        let (seed, samples) = (text("seed")?, text("samples")?);
        let damaged = |name, text| ImageError::new(format!("the attribute `{name}` is damaged: `{text}`"));
        let range =
            samples.split_once("..").and_then(|(start, end)| Some(start.parse().ok()?..end.parse().ok()?));
        Ok(Provenance {
            version: text("version")?,
            scene: text("scene")?,
            seed: seed.parse().map_err(|_| damaged("seed", &seed))?,
            samples: range
                .filter(|range| range.start <= range.end)
                .ok_or_else(|| damaged("samples", &samples))?,
            kernel: text("kernel")?,
            integrator: text("integrator")?,
            extra: attributes,
        })
    }

    /// The first attribute other than the sample range in which two images differ: its name and both values.
    pub(super) fn difference(
        &self,
        other: &Provenance,
    ) -> Result<Option<(String, String, String)>, ImageError> {
        let (ours, theirs) = (self.to_attributes()?, other.to_attributes()?);
        let show = |value: Option<&Attribute>| value.map_or("none".to_owned(), Attribute::to_string);
        let names = || ours.keys().chain(theirs.keys());
        let differs = |name: &&String| *name != "samples" && ours.get(*name) != theirs.get(*name);
        // The scene's hash covers the seed and the integrator too, so it says the least and comes last.
        let first = names().filter(|name| *name != "scene").find(differs);
        Ok(first
            .or_else(|| names().find(differs))
            .map(|name| (name.clone(), show(ours.get(name)), show(theirs.get(name)))))
    }
}

impl std::fmt::Display for Attribute {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Attribute::Text(text) => write!(formatter, "`{text}`"),
            Attribute::Integer(value) => write!(formatter, "{value}"),
            Attribute::Real(value) => write!(formatter, "{value}"),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn example(samples: Range<u64>) -> Provenance {
        Provenance {
            version: "0.1.0".into(),
            scene: "9f86d081884c7d65".into(),
            seed: u64::MAX,
            samples,
            kernel: "spectral-8".into(),
            integrator: "path".into(),
            extra: BTreeMap::from([
                ("color".into(), Attribute::Text("spectral".into())),
                ("max_depth".into(), Attribute::Integer(-1)),
                ("clamp".into(), Attribute::Real(0.1)),
            ]),
        }
    }

    #[test]
    fn attributes_bring_the_provenance_back() {
        let provenance = example(8..1 << 40);
        assert_eq!(provenance.to_attributes().and_then(Provenance::from_attributes), Ok(provenance));
    }

    #[test]
    fn damaged_attributes_are_named() {
        for (name, value) in [("seed", "-1"), ("samples", "8"), ("samples", "8..4")] {
            let mut attributes = example(0..8).to_attributes().unwrap_or_default();
            attributes.insert(name.into(), Attribute::Text(value.into()));
            let error = Provenance::from_attributes(attributes).map_err(|error| error.to_string());
            assert_eq!(error, Err(format!("the attribute `{name}` is damaged: `{value}`")));
        }
    }

    #[test]
    fn reserved_names_are_refused() {
        let mut provenance = example(0..8);
        provenance.extra.insert("seed".into(), Attribute::Integer(1));
        let refused = provenance.to_attributes().map_err(|error| error.to_string());
        assert!(refused.is_err_and(|why| why.contains("`seed`")));
    }

    #[test]
    fn the_first_difference_is_told() {
        let (a, mut b) = (example(0..8), example(8..16));
        assert_eq!(a.difference(&b), Ok(None));
        b.extra.remove("max_depth");
        assert_eq!(a.difference(&b), Ok(Some(("max_depth".into(), "-1".into(), "none".into()))));
        assert_eq!(b.difference(&a), Ok(Some(("max_depth".into(), "none".into(), "-1".into()))));
    }
}
