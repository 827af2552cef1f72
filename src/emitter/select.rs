//! The choice of the emitter that is sampled.

use super::AnyEmitter;
use super::tree::{Cluster, Receiver, Tree};
use crate::math::{DVec2, Discrete};
use crate::shape::Geometry;

/// Fewest emitters, of those not infinitely far, for which there is a [`Tree`].
const MANY: usize = 2;

/// All emitters of a scene.
#[derive(Debug, Default)]
pub struct Emitters {
    pub list: Vec<Entry>,
    /// The one that surrounds the scene.
    pub environment: Option<usize>,
    /// The choice between all emitters; if there is a tree, between those that it does not hold, and the
    /// tree.
    choice: Discrete,
    local: Option<Local>,
}

/// An emitter, and the shape it belongs to.
#[derive(Debug)]
pub struct Entry {
    pub emitter: AnyEmitter,
    pub shape: Option<u32>,
}

/// The emitters within the scene, in a tree, and those infinitely far.
#[derive(Debug)]
struct Local {
    tree: Tree,
    /// The emitter of each leaf, by the leaf's number.
    emitters: Vec<u32>,
    /// Emitters that are infinitely far.
    distant: Vec<u32>,
    /// For each emitter its number in the tree, or among the distant ones.
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Tree(u32),
    Distant(u32),
}

impl Emitters {
    /// Emitters are chosen by power, one part in ten evenly, so that an estimate of power that is wrong for
    /// some corner of the scene costs at most a tenth of its samples; where there are many, also by where
    /// they are.
    pub fn new<'a>(list: Vec<Entry>, radius: f64, shape: impl Fn(u32) -> &'a Geometry) -> Self {
        const EVEN: f64 = 0.1;
        let powers: Vec<f64> = list.iter().map(|e| e.emitter.power(e.shape.map(&shape), radius)).collect();
        let total: f64 = powers.iter().sum();
        let n = list.len() as f64;
        let known = total > 0.0 && total.is_finite();
        let weight = |p: &f64| if known { (1.0 - EVEN) * p / total + EVEN / n } else { 1.0 / n };
        let weights: Vec<f64> = powers.iter().map(weight).collect();
        let clusters =
            list.iter().zip(&weights).map(|(e, weight)| e.emitter.cluster(e.shape.map(&shape), *weight));
        let local = Local::new(&clusters.collect::<Vec<_>>());
        let choice = match &local {
            None => Discrete::new(weights),
            Some(local) => {
                let of = |emitters: &[u32]| emitters.iter().map(|i| weights[*i as usize]).collect::<Vec<_>>();
                let of_tree = of(&local.emitters).iter().sum();
                Discrete::new(of(&local.distant).into_iter().chain([of_tree]))
            }
        };
        let environment = list.iter().position(|e| e.emitter.is_environment());
        Self { list, environment, choice, local }
    }

    /// Whether the choice depends on where light is gathered.
    #[inline(always)]
    pub fn chosen_by_place(&self) -> bool {
        self.local.is_some()
    }

    /// The emitter that the first of two numbers in [0, 1) falls on, its probability, and the numbers,
    /// rescaled for reuse; see [`Discrete::sample_strip`]. `None` if no emitter lights the point.
    #[inline]
    pub fn sample(&self, at: Receiver, u: DVec2, digits: f64) -> Option<(usize, f64, DVec2)> {
        match (&self.local, self.list.len()) {
            (None, 0) => None,
            (None, 1) => Some((0, 1.0, u)),
            (None, _) => Some(self.choice.sample_strip(u, digits)),
            (Some(local), _) => local.sample(self.choice.sample_strip(u, digits), at),
        }
    }

    /// The probability of choosing emitter `index`.
    #[inline]
    pub fn probability(&self, index: usize, at: Receiver) -> f64 {
        match &self.local {
            None if self.list.len() == 1 => 1.0,
            None => self.choice.probability(index),
            Some(local) => match local.places[index] {
                Place::Distant(slot) => self.choice.probability(slot as usize),
                Place::Tree(leaf) => {
                    self.choice.probability(local.distant.len()) * local.tree.probability(leaf as usize, at)
                }
            },
        }
    }
}

impl Local {
    /// `None` if too few emitters are within the scene.
    fn new(clusters: &[Option<Cluster>]) -> Option<Self> {
        let (mut emitters, mut distant, mut places, mut inner) = (vec![], vec![], vec![], vec![]);
        for (i, cluster) in (0..).zip(clusters) {
            match cluster {
                Some(cluster) => {
                    places.push(Place::Tree(emitters.len() as u32));
                    emitters.push(i);
                    inner.push(*cluster);
                }
                None => {
                    places.push(Place::Distant(distant.len() as u32));
                    distant.push(i);
                }
            }
        }
        (inner.len() >= MANY).then(|| Self { tree: Tree::new(&inner), emitters, distant, places })
    }

    /// From a choice between the distant emitters and the tree.
    #[inline(never)]
    fn sample(
        &self,
        (slot, probability, u): (usize, f64, DVec2),
        at: Receiver,
    ) -> Option<(usize, f64, DVec2)> {
        if let Some(index) = self.distant.get(slot) {
            return Some((*index as usize, probability, u));
        }
        let (leaf, chance, rest) = self.tree.sample(at, u.x)?;
        Some((self.emitters[leaf] as usize, probability * chance, DVec2::new(rest, u.y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    #[test]
    fn near_and_distant_emitters_are_chosen_as_often_as_is_said() {
        let point = |x: f64| {
            format!(r#"<emitter type="point"><point name="position" x="{x}" y="0" z="1"/></emitter>"#)
        };
        let sky = r#"<emitter type="constant"><rgb name="radiance" value="0.05"/></emitter>"#;
        let sun = r#"<emitter type="directional"><rgb name="irradiance" value="2"/></emitter>"#;
        let text = [point(-1.0), sky.into(), point(0.0), sun.into(), point(3.0)].concat();
        let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{text}</scene>"#);
        let emitters = load_text("scene.xml", &text, ColorMode::Rgb).unwrap().emitters;
        assert_eq!(emitters.environment, Some(1));
        for x in [-1.0, 0.5, 3.0] {
            const NUMBERS: usize = 10_000;
            let at = (DVec3::X * x, DVec3::Z);
            let mut shares = [0.0; 5];
            for i in 0..NUMBERS {
                let u = DVec2::new((i as f64 + 0.5) / NUMBERS as f64, 0.25);
                let (index, probability, rest) = emitters.sample(at, u, 0.0).unwrap();
                assert!((probability - emitters.probability(index, at)).abs() < 1e-15);
                assert!((0.0..1.0).contains(&rest.x) && rest.y == u.y);
                shares[index] += 1.0 / NUMBERS as f64;
            }
            for (i, share) in shares.into_iter().enumerate() {
                assert!((share - emitters.probability(i, at)).abs() < 2.0 / NUMBERS as f64, "{i}: {share}");
            }
            let nearest = if x > 1.5 { 4 } else { 2 * usize::from(x > -0.5) };
            assert!([0, 2, 4].iter().all(|i| shares[*i] <= shares[nearest]), "{shares:?}");
        }
    }
}
