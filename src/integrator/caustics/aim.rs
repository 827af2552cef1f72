//! Directions from an emitter towards what is specular.

use crate::math::bounds::{NOTHING, union};
use crate::math::discrete::with_digits;
use crate::math::{BELOW_ONE, DVec2, DVec3, Frame, INV_PI, length, warp};

/// How many balls stand for all casters: their densities are summed at every light path's beginning and end.
const BALLS: usize = 16;

/// The share of directions that are not aimed, so that nothing can be missed or be found too rarely.
const UNAIMED: f64 = 0.1;

/// Balls that together hold all casters.
///
/// From a point p with normal n, ball k fills a cone of solid angle Ωₖ (or all directions, where p is
/// inside). It is aimed at with probability in proportion to Ωₖ cₖ, cₖ being the largest cosine to n in its
/// cone, and uniformly within:
///
/// p(ω) = a cos/π + (1 − a) Σₖ [ω in cone k] cₖ / Σₖ Ωₖ cₖ.
///
/// A ball about p counts with Ω c = π and cos/π for its density.
#[derive(Debug)]
pub struct Aim {
    balls: Vec<(DVec3, f64)>,
}

/// A ball as it is seen from a point: the axis of its cone, 1 − cos of its opening, and its largest cosine;
/// `None` for one all around.
struct Cone {
    axis: DVec3,
    one_minus_cos: f64,
    largest: f64,
}

impl Aim {
    /// From the bounding boxes of the casters, halved along their longest extent until there are few groups.
    pub fn new(boxes: &[(DVec3, DVec3)]) -> Self {
        let mut groups = vec![boxes.to_vec()];
        while groups.len() < BALLS {
            // The group whose box is largest is the worst to aim at.
            let extent = |group: &Vec<(DVec3, DVec3)>| {
                if group.len() < 2 { 0.0 } else { size(around(group)).max_element() }
            };
            let Some((worst, _)) = groups
                .iter()
                .enumerate()
                .filter(|(_, group)| extent(group) > 0.0)
                .max_by(|(i, a), (j, b)| extent(a).total_cmp(&extent(b)).then(j.cmp(i)))
            else {
                break;
            };
            let mut group = std::mem::take(&mut groups[worst]);
            let axis = size(around(&group)).max_position();
            group.sort_by(|a, b| (a.0[axis] + a.1[axis]).total_cmp(&(b.0[axis] + b.1[axis])));
            groups.push(group.split_off(group.len() / 2));
            groups[worst] = group;
        }
        let ball = |group: &Vec<(DVec3, DVec3)>| {
            let (lo, hi) = around(group);
            (0.5 * (lo + hi), 0.5 * length(hi - lo))
        };
        Self { balls: groups.iter().map(ball).collect() }
    }

    /// Aimed at nothing: by the cosine.
    pub fn everywhere() -> Self {
        Self { balls: vec![] }
    }

    fn cone(&self, ball: usize, p: DVec3, n: DVec3) -> Option<Cone> {
        let (centre, radius) = self.balls[ball];
        let towards = centre - p;
        let distance = length(towards);
        if distance <= radius {
            return None;
        }
        let (axis, sin) = (towards / distance, radius / distance);
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let height = axis.dot(n);
        // The cone's direction nearest to the normal: the cosine of the difference of two angles.
        let largest =
            if height >= cos { 1.0 } else { height * cos + (1.0 - height * height).max(0.0).sqrt() * sin };
        Some(Cone { axis, one_minus_cos: sin * sin / (1.0 + cos), largest: largest.max(0.0) })
    }

    /// Ω c of a ball.
    fn weight(cone: &Option<Cone>) -> f64 {
        match cone {
            None => std::f64::consts::PI,
            Some(cone) => 2.0 * std::f64::consts::PI * cone.one_minus_cos * cone.largest,
        }
    }

    /// A direction from the point p of an emitter with normal n, by three numbers in [0, 1); a strip of the
    /// first two falls to each cone, as in [`Discrete::sample_strip`](crate::math::Discrete::sample_strip).
    pub fn sample(&self, p: DVec3, n: DVec3, u: DVec2, digits: f64) -> DVec3 {
        let cosine = |x: f64| Frame::about(n).to_world(warp::cosine_hemisphere(DVec2::new(x, u.y)));
        let choice = with_digits(u.x, digits);
        if self.balls.is_empty() {
            return cosine(choice);
        }
        if choice < UNAIMED {
            return cosine(choice / UNAIMED);
        }
        let total: f64 = (0..self.balls.len()).map(|k| Self::weight(&self.cone(k, p, n))).sum();
        let aimed = (choice - UNAIMED) / (1.0 - UNAIMED);
        let mut rest = aimed * total;
        for k in 0..self.balls.len() {
            let cone = self.cone(k, p, n);
            let weight = Self::weight(&cone);
            if rest < weight {
                let x = (rest / weight).min(BELOW_ONE);
                return match cone {
                    None => cosine(x),
                    Some(cone) => {
                        Frame::about(cone.axis).to_world(warp::cone(DVec2::new(x, u.y), cone.one_minus_cos))
                    }
                };
            }
            rest -= weight;
        }
        // No ball is in front, or rounding has left a little beyond the last.
        cosine(aimed)
    }

    /// The density of [`Aim::sample`] in sr⁻¹; zero behind the emitter.
    pub fn density(&self, p: DVec3, n: DVec3, w: DVec3) -> f64 {
        let cosine = w.dot(n) * INV_PI;
        if cosine <= 0.0 {
            return 0.0;
        }
        let (mut total, mut aimed) = (0.0, 0.0);
        for k in 0..self.balls.len() {
            let cone = self.cone(k, p, n);
            total += Self::weight(&cone);
            aimed += match cone {
                None => std::f64::consts::PI * cosine,
                // |w − axis|² / 2 is 1 − cos without its cancellation.
                Some(cone) if 0.5 * (w - cone.axis).length_squared() <= cone.one_minus_cos => cone.largest,
                Some(_) => 0.0,
            };
        }
        if total > 0.0 { UNAIMED * cosine + (1.0 - UNAIMED) * aimed / total } else { cosine }
    }
}

fn around(group: &[(DVec3, DVec3)]) -> (DVec3, DVec3) {
    group.iter().copied().fold(NOTHING, union)
}

fn size((lo, hi): (DVec3, DVec3)) -> DVec3 {
    hi - lo
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Kind, Sampler};

    fn example() -> Aim {
        let cube = |x: f64, y: f64, z: f64, r: f64| {
            let c = DVec3::new(x, y, z);
            (c - r, c + r)
        };
        Aim::new(&[
            cube(0.0, 0.0, 2.0, 0.3),
            cube(1.5, 0.2, 1.0, 0.4),
            cube(0.1, 0.0, -3.0, 0.5),
            cube(2.0, 2.0, 0.1, 0.6),
        ])
    }

    #[test]
    fn averages_over_directions_are_those_of_the_hemisphere() {
        for (p, n) in [(DVec3::ZERO, DVec3::Z), (DVec3::new(0.1, 0.0, 1.9), DVec3::X)] {
            let aim = example();
            // ∫ g dω of functions that are large within, across and beside the cones, by sampling; each is
            // known.
            const N: u32 = 1 << 18;
            let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
            for i in 0..N {
                let u = Sampler::new(Kind::Independent, 0, (0, 0), i).block(0);
                let w = aim.sample(p, n, u.pair(0), u.one(4));
                let density = aim.density(p, n, w);
                let cos = w.dot(n);
                if cos <= 0.0 {
                    assert_eq!(density, 0.0);
                    continue;
                }
                assert!(density > 0.0);
                for (k, g) in [1.0, cos, cos * cos].into_iter().enumerate() {
                    sums[k] += g / density / N as f64;
                    squares[k] += (g / density) * (g / density) / N as f64;
                }
            }
            let pi = std::f64::consts::PI;
            for (k, expected) in [2.0 * pi, pi, 2.0 * pi / 3.0].into_iter().enumerate() {
                let error = ((squares[k] - sums[k] * sums[k]) / N as f64).sqrt();
                // Six standard errors: exceeded once in 5·10⁸.
                assert!(
                    (sums[k] - expected).abs() < 6.0 * error,
                    "{k}: {} for {expected}, ± {error}",
                    sums[k]
                );
            }
        }
    }

    #[test]
    fn few_balls_hold_many_boxes() {
        let corner =
            |i: u32| DVec3::new(f64::from(i * 37 % 101), f64::from(i * 61 % 97), f64::from(i * 13 % 89));
        let boxes: Vec<_> = (0..500).map(|i| (corner(i), corner(i) + 1.0)).collect();
        let aim = Aim::new(&boxes);
        assert_eq!(aim.balls.len(), BALLS);
        for (lo, hi) in boxes {
            let holds = |(centre, radius): &(DVec3, f64)| {
                length((lo - centre).abs().max((hi - centre).abs())) <= radius * (1.0 + 1e-12)
            };
            assert!(aim.balls.iter().any(holds));
        }
    }
}
