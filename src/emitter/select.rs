//! The choice of the emitter that is sampled: by estimates of the light that each may bring where it is
//! gathered.
//!
//! Emitters within the scene are in a [`tree`](super::tree), which is one choice; each of those infinitely
//! far is another. All estimates are of irradiance, as far as a surface scatters it to the viewer, in the
//! same unit, so a lamp outshines the sky in a room and not in the street. Of the sky only that counts which
//! scattering would not find by itself.

use super::tree::{Cluster, SeenTree, Tree};
use super::{AnyEmitter, GatherPoint, Gathers, MapPlace, View};
use crate::math::discrete::with_digits;
use crate::math::{BELOW_ONE, Chosen, DVec2, DVec3};
use crate::sampler::EmitterNumbers;
use crate::shape::Geometry;
use crate::spectrum::{Spectrum, Wavelengths};

/// The part of all choices that is made evenly, so that an estimate that is wrong for some corner of the
/// scene costs at most a tenth of its samples.
const EVEN: f64 = 0.1;

/// All emitters of a scene.
#[derive(Debug, Default)]
pub struct Emitters {
    pub list: Vec<SceneEmitter>,
    /// The one that surrounds the scene.
    pub environment: Option<usize>,
    /// Those within the scene; of each leaf, by its number, the emitter.
    near: Option<(Tree, Vec<u32>)>,
    /// Those infinitely far, with their numbers.
    far: Vec<(u32, Distant)>,
    /// Of each emitter, its number among the near or the far ones.
    places: Vec<Place>,
}

/// An emitter, and the shape it belongs to.
#[derive(Debug)]
pub struct SceneEmitter {
    pub emitter: AnyEmitter,
    pub shape: Option<u32>,
}

/// What may be expected of an emitter, whoever gathers its light.
#[derive(Clone, Copy, Debug)]
pub enum Expected {
    Near(Cluster),
    Far(Distant),
}

/// What may be expected of an emitter that is infinitely far.
#[derive(Clone, Copy, Debug)]
pub struct Distant {
    /// On a surface that faces it, as far as emitter samples are wanted for it.
    pub irradiance: f64,
    /// Where it is; zero if it is on all sides.
    pub towards: DVec3,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Near(u32),
    Far(u32),
}

/// The choice between all emitters at a point.
#[derive(Clone, Copy, Debug)]
pub struct Choice<'a> {
    pub at: GatherPoint<'a>,
    /// What is expected, if it is remembered.
    known: Option<Estimates<'a>>,
}

/// What several emitters are expected to bring to a point.
#[derive(Clone, Copy, Debug)]
struct Estimates<'a> {
    /// Those within the scene, if light of any can arrive.
    near: Option<SeenTree<'a>>,
    /// How many choices there are, and the sum of what they are expected to bring.
    count: f64,
    total: f64,
}

impl Estimates<'_> {
    /// The probability of a choice of which this irradiance is expected.
    #[inline]
    fn probability(&self, irradiance: f64) -> f64 {
        if self.total > 0.0 && self.total.is_finite() {
            EVEN / self.count + (1.0 - EVEN) * (irradiance / self.total)
        } else {
            1.0 / self.count
        }
    }
}

impl Distant {
    /// An estimate of the irradiance of a surface, as far as it is scattered to the viewer; `None` if none
    /// arrives.
    #[inline]
    fn irradiance_of(&self, Gathers { n, lobe }: &Gathers) -> Option<f64> {
        if self.towards == DVec3::ZERO {
            return Some(self.irradiance);
        }
        let cos = if *n == DVec3::ZERO { 1.0 } else { n.dot(self.towards) };
        let gain = if lobe.share > 0.0 { lobe.gain(lobe.axis.dot(self.towards)) } else { 1.0 };
        (cos > 0.0).then_some(self.irradiance * cos * gain)
    }
}

impl Emitters {
    pub fn new<'a>(list: Vec<SceneEmitter>, shape: impl Fn(u32) -> &'a Geometry) -> Self {
        let (mut near, mut leaves, mut far, mut places) = (vec![], vec![], vec![], vec![]);
        for (index, entry) in (0..).zip(&list) {
            match entry.emitter.expected(entry.shape.map(&shape)) {
                Expected::Near(cluster) => {
                    places.push(Place::Near(near.len() as u32));
                    near.push(cluster);
                    leaves.push(index);
                }
                Expected::Far(distant) => {
                    places.push(Place::Far(far.len() as u32));
                    far.push((index, distant));
                }
            }
        }
        let mean = near.iter().map(|cluster| cluster.intensity).sum::<f64>() / near.len() as f64;
        let known = mean > 0.0 && mean.is_finite();
        for cluster in &mut near {
            let own = cluster.intensity;
            cluster.intensity = if known { (1.0 - EVEN) * own + EVEN * mean } else { 1.0 };
        }
        let environment = list.iter().position(|e| e.emitter.is_environment());
        let near = (!near.is_empty()).then(|| (Tree::new(&near), leaves));
        Self { list, environment, near, far, places }
    }

    /// What is to be seen in direction ω (unit, world) of a ray that leaves the scene; `None` if that is
    /// nothing.
    #[inline]
    pub fn view(&self, direction: DVec3) -> Option<View> {
        self.environment.map(|index| self.list[index].emitter.view(direction))
    }

    /// The radiance of a place in the environment map, zero if there is no map.
    #[inline]
    pub fn mapped(&self, place: &MapPlace, λ: &Wavelengths) -> Spectrum {
        match self.environment.map(|index| &self.list[index].emitter) {
            Some(AnyEmitter::Envmap(map)) => map.radiance(place, λ),
            _ => Spectrum::ZERO,
        }
    }

    /// Whether the choice depends on where light is gathered.
    #[inline(always)]
    pub fn chosen_by_place(&self) -> bool {
        self.list.len() > 1
    }

    #[inline]
    fn estimates<'a>(&self, at: GatherPoint<'a>) -> Estimates<'a> {
        let near = self.near.as_ref().map(|(tree, _)| tree.seen_from(at)).filter(|seen| seen.total() > 0.0);
        let (mut count, mut total) = (0.0, 0.0);
        let far = self.far.iter().filter_map(|(_, distant)| distant.irradiance_of(at.gathers));
        for irradiance in far.chain(near.as_ref().map(SeenTree::total)) {
            count += 1.0;
            total += irradiance;
        }
        Estimates { near, count, total }
    }
}

impl<'a> Choice<'a> {
    /// The choice by one sample, or its probability.
    #[inline(always)]
    pub fn at(at: GatherPoint<'a>) -> Self {
        Self { at, known: None }
    }

    /// The same choice by several samples, for which what is expected is remembered.
    #[inline(never)]
    pub fn of_several(emitters: &Emitters, at: GatherPoint<'a>) -> Self {
        Self { at, known: emitters.chosen_by_place().then(|| emitters.estimates(at)) }
    }

    #[inline(always)]
    fn estimates(&self, emitters: &Emitters) -> Estimates<'a> {
        self.known.unwrap_or_else(|| emitters.estimates(self.at))
    }

    /// The emitter that the first number of the place falls on; what is left of the numbers is for the place on
    /// it, see [`Discrete::sample_strip`](crate::math::Discrete::sample_strip). `None` if no emitter lights the
    /// point.
    #[inline]
    pub fn sample(&self, emitters: &Emitters, numbers: EmitterNumbers) -> Option<Chosen<DVec2>> {
        match emitters.list.len() {
            0 => None,
            1 => Some(Chosen { index: 0, probability: 1.0, rest: numbers.place }),
            _ => self.sample_several(emitters, numbers),
        }
    }

    /// The density in sr⁻¹ of `count` samples together, if that of one that has chosen emitter `index` is
    /// `pdf`.
    #[inline(always)]
    pub fn density_of_samples(&self, emitters: &Emitters, index: usize, pdf: f64, count: u32) -> f64 {
        self.probability(emitters, index) * pdf * f64::from(count)
    }

    /// The probability of choosing emitter `index`.
    #[inline]
    pub fn probability(&self, emitters: &Emitters, index: usize) -> f64 {
        if emitters.list.len() == 1 { 1.0 } else { self.probability_of_several(emitters, index) }
    }

    #[inline(never)]
    fn sample_several(
        &self,
        emitters: &Emitters,
        EmitterNumbers { place: u, digits }: EmitterNumbers,
    ) -> Option<Chosen<DVec2>> {
        let estimates = self.estimates(emitters);
        let mut left = with_digits(u.x, digits);
        // Rounding may lead past the last.
        let mut last = None;
        for (emitter, distant) in &emitters.far {
            let Some(irradiance) = distant.irradiance_of(self.at.gathers) else { continue };
            let probability = estimates.probability(irradiance);
            let index = *emitter as usize;
            let chosen = |rest: f64| Some(Chosen { index, probability, rest: DVec2::new(rest, u.y) });
            if left < probability {
                return chosen(left / probability);
            }
            last = chosen(BELOW_ONE);
            left -= probability;
        }
        let (Some((tree, leaves)), Some(seen)) = (&emitters.near, &estimates.near) else { return last };
        let probability = estimates.probability(seen.total());
        let leaf = tree.sample(seen, (left / probability).min(BELOW_ONE))?;
        Some(Chosen {
            index: leaves[leaf.index] as usize,
            probability: probability * leaf.probability,
            rest: DVec2::new(leaf.rest, u.y),
        })
    }

    #[inline(never)]
    fn probability_of_several(&self, emitters: &Emitters, index: usize) -> f64 {
        let estimates = self.estimates(emitters);
        let chance = match emitters.places[index] {
            Place::Near(leaf) => estimates.near.zip(emitters.near.as_ref()).map(|(seen, (tree, _))| {
                estimates.probability(seen.total()) * tree.probability(&seen, leaf as usize)
            }),
            Place::Far(number) => {
                let (_, distant) = emitters.far[number as usize];
                distant.irradiance_of(self.at.gathers).map(|irradiance| estimates.probability(irradiance))
            }
        };
        chance.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::math::DVec3;
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
            let gathers = Gathers::about(DVec3::Z);
            let at = gathers.at(DVec3::X * x);
            let (choice, of_several) = (Choice::at(at), Choice::of_several(&emitters, at));
            let mut shares = [0.0; 5];
            for i in 0..NUMBERS {
                let u = DVec2::new((i as f64 + 0.5) / NUMBERS as f64, 0.25);
                let numbers = EmitterNumbers { place: u, digits: 0.0 };
                let chosen = choice.sample(&emitters, numbers).unwrap();
                assert_eq!(of_several.sample(&emitters, numbers), Some(chosen));
                let Chosen { index, probability, rest } = chosen;
                assert!((probability - choice.probability(&emitters, index)).abs() < 1e-15);
                assert!((0.0..1.0).contains(&rest.x) && rest.y == u.y);
                shares[index] += 1.0 / NUMBERS as f64;
            }
            for (i, share) in shares.into_iter().enumerate() {
                assert!(
                    (share - choice.probability(&emitters, i)).abs() < 2.0 / NUMBERS as f64,
                    "{i}: {share}"
                );
            }
            let nearest = if x > 1.5 { 4 } else { 2 * usize::from(x > -0.5) };
            assert!([0, 2, 4].iter().all(|i| shares[*i] <= shares[nearest]), "{shares:?}");
        }
    }

    #[test]
    fn a_lamp_outshines_the_sky_near_by_alone() {
        let text = r#"<scene version="3.0.0"><sensor type="perspective"/>
            <emitter type="constant"><rgb name="radiance" value="0.3"/></emitter>
            <emitter type="point"><rgb name="intensity" value="1"/></emitter>
            <emitter type="directional"><vector name="direction" x="0" y="0" z="1"/></emitter></scene>"#;
        let emitters = load_text("scene.xml", text, ColorMode::Rgb).unwrap().emitters;
        let chosen = |p, n, emitter| Choice::at(Gathers::about(n).at(p)).probability(&emitters, emitter);
        let of_lamp = |z: f64| chosen(DVec3::Z * z, -DVec3::Z, 1);
        let of_sun = |n: DVec3| chosen(DVec3::X, n, 2);
        assert!(
            of_lamp(0.1) > 0.9 && (0.4..0.7).contains(&of_lamp(1.0)),
            "{} {}",
            of_lamp(0.1),
            of_lamp(1.0)
        );
        // From a tenth of the choices, made evenly, all get some.
        assert!((0.03..0.05).contains(&of_lamp(100.0)), "{}", of_lamp(100.0));
        assert!(of_sun(-DVec3::Z) > 0.3 && of_sun(DVec3::Z) == 0.0 && of_sun(DVec3::ZERO) > 0.3);
    }
}
