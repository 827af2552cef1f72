//! Directions that were seen, as a density that can be sampled.

use crate::math::function::turn;
use crate::math::{BELOW_ONE, DVec2, DVec3, INV_PI, warp};

/// Fewest directions in a quarter that is divided further.
const DIVIDED: usize = 16;

/// How often a square is divided at most: to a 512th of a turn.
const DEEPEST: u32 = 8;

/// A density over the sphere of directions, mapped to a square with equal areas ([`warp::sphere`]): that is
/// divided into quarters, and these again where many directions were seen (as in the trees of Müller, Gross &
/// Novák 2017, §3.2); the density is constant within the smallest.
#[derive(Clone, Debug)]
pub struct Directions(Vec<Quarters>);

/// The four quarters of a square: left and right of the upper half, then of the lower.
#[derive(Clone, Copy, Debug, Default)]
struct Quarters {
    /// Share of the square's weight that each quarter has.
    parts: [f64; 4],
    /// Index of the quarters that each is divided into; 0 if it is not divided.
    further: [u32; 4],
}

impl Directions {
    /// From directions with weights, which are positive.
    pub fn new(seen: impl IntoIterator<Item = (DVec3, f64)>) -> Self {
        let mut places: Vec<_> = seen.into_iter().map(|(w, weight)| (square(w), weight)).collect();
        let mut squares = vec![];
        divide(&mut places, 0, &mut squares);
        Self(squares)
    }

    /// The density of a direction (world), in sr⁻¹.
    pub fn density(&self, w: DVec3) -> f64 {
        let mut place = square(w);
        let mut density = 0.25 * INV_PI;
        let mut index = 0;
        loop {
            let quarters = &self.0[index as usize];
            let i = quarter(place);
            density *= 4.0 * quarters.parts[i];
            index = quarters.further[i];
            if index == 0 {
                return density;
            }
            place = within(place, i);
        }
    }

    /// A direction and its density in sr⁻¹, by two numbers in [0, 1).
    pub fn sample(&self, mut u: DVec2) -> (DVec3, f64) {
        let (mut corner, mut size, mut density, mut index) = (DVec2::ZERO, 1.0, 0.25 * INV_PI, 0);
        loop {
            let quarters = &self.0[index as usize];
            let [a, b, c, d] = quarters.parts;
            let upper = first(&mut u.y, a + b, c + d);
            let (left, right) = if upper { (a, b) } else { (c, d) };
            let i = usize::from(!first(&mut u.x, left, right)) + if upper { 0 } else { 2 };
            size *= 0.5;
            corner += corner_of(i) * size;
            density *= 4.0 * quarters.parts[i];
            index = quarters.further[i];
            if index == 0 {
                return (warp::sphere(corner + u * size), density);
            }
        }
    }
}

/// The inverse of [`warp::sphere`].
fn square(w: DVec3) -> DVec2 {
    DVec2::new(turn(w.y, w.x), 0.5 - 0.5 * w.z)
}

fn quarter(place: DVec2) -> usize {
    usize::from(place.x >= 0.5) + if place.y >= 0.5 { 2 } else { 0 }
}

fn corner_of(quarter: usize) -> DVec2 {
    DVec2::new((quarter % 2) as f64, (quarter / 2) as f64)
}

/// A place in a quarter, in coordinates that fill the quarter as a unit square.
fn within(place: DVec2, quarter: usize) -> DVec2 {
    place * 2.0 - corner_of(quarter)
}

/// Whether a number chooses the first of two by their weights; it is stretched to [0, 1) within the choice.
fn first(u: &mut f64, a: f64, b: f64) -> bool {
    let part = a / (a + b);
    let chosen = *u < part;
    *u = if chosen { *u / part } else { (*u - part) / (1.0 - part) };
    *u = u.min(BELOW_ONE);
    chosen
}

fn divide(places: &mut [(DVec2, f64)], depth: u32, squares: &mut Vec<Quarters>) -> u32 {
    let index = squares.len();
    squares.push(Quarters::default());
    let weight = |places: &[(DVec2, f64)]| places.iter().map(|(_, weight)| weight).sum::<f64>();
    let all = weight(places);
    places.sort_by_key(|(place, _)| quarter(*place));
    for own in places.chunk_by_mut(|(a, _), (b, _)| quarter(*a) == quarter(*b)) {
        let i = quarter(own[0].0);
        squares[index].parts[i] = weight(own) / all;
        if own.len() >= DIVIDED && depth < DEEPEST {
            own.iter_mut().for_each(|(place, _)| *place = within(*place, i));
            squares[index].further[i] = divide(own, depth + 1, squares);
        }
    }
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::unit;
    use crate::sampler::{Sampler, SamplerKind};

    /// Directions about two places, one of them where the square's sides meet.
    fn example() -> Directions {
        let seen = (0..3000u32).map(|i| {
            let u = Sampler::new(SamplerKind::Independent, 0, (0, 0), i).block(0);
            let about = if i % 3 == 0 { DVec3::new(0.2, -0.6, 0.7) } else { DVec3::new(1.0, 0.0, 0.1) };
            (unit(about + warp::sphere(u.pair(0)) * 0.1 * u.one(2)), 1.0 + f64::from(i % 5))
        });
        Directions::new(seen)
    }

    #[test]
    fn places_and_directions_are_each_others() {
        for i in 0..1000 {
            let u = Sampler::new(SamplerKind::Sobol, 0, (0, 0), i).block(0).pair(0);
            assert!((square(warp::sphere(u)) - u).abs().max_element() < 1e-12, "{u}");
        }
    }

    #[test]
    fn densities_are_those_of_samples() {
        let directions = example();
        const N: u32 = 1 << 16;
        let mut mean = DVec3::ZERO;
        for i in 0..N {
            let u = Sampler::new(SamplerKind::Sobol, 0, (0, 0), i).block(0).pair(0);
            let (w, density) = directions.sample(u);
            assert!((directions.density(w) / density - 1.0).abs() < 1e-9, "{w}");
            mean += w / f64::from(N);
        }
        // At the middles of squares of the last division, within which the density is even.
        let side = 2 << DEEPEST;
        let area = 4.0 / INV_PI / f64::from(side * side);
        let (mut all, mut expected) = (0.0, DVec3::ZERO);
        for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
            let w = warp::sphere(DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(side));
            all += directions.density(w) * area;
            expected += w * directions.density(w) * area;
        }
        assert!((all - 1.0).abs() < 1e-9, "{all}");
        assert!((mean - expected).abs().max_element() < 1e-3, "{mean} {expected}");
    }

    #[test]
    fn little_is_seen_evenly() {
        let one = Directions::new([(DVec3::new(0.6, 0.0, 0.8), 2.0)]);
        // The quarter in which it lies, of the sphere's area.
        assert_eq!(one.density(DVec3::new(0.0, 0.6, 0.8)), INV_PI);
        assert_eq!(one.density(DVec3::new(0.0, 0.6, -0.8)), 0.0);
    }
}
