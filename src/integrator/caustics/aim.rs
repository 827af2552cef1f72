//! Sampling of directions from an emitter towards the casters: shapes with narrow lobes.

use crate::math::ball::{self, Ball};
use crate::math::discrete::with_digits;
use crate::math::{BELOW_ONE, DVec2, DVec3, Frame, INV_PI, length, warp};
use std::f64::consts::PI;

/// Most balls that bound the casters; every evaluation of the density sums over all of them.
pub const BALLS: usize = 16;

/// Probability of sampling by the cosine instead, so that no direction is impossible or has too low a
/// density.
const UNAIMED: f64 = 0.1;

/// Balls that together contain all casters.
///
/// From a point p with normal n, ball k fills a cone of solid angle Ωₖ (or all directions, where p is
/// inside). It is aimed at with probability in proportion to Ωₖ cₖ, cₖ being the largest cosine to n in its
/// cone, and uniformly within:
///
/// p(ω) = a cos/π + (1 − a) Σₖ [ω in cone k] cₖ / Σₖ Ωₖ cₖ.
///
/// A ball that contains p counts with Ω c = π and the density cos/π.
#[derive(Debug)]
pub struct Aim {
    balls: Vec<Ball>,
}

impl Aim {
    /// From a ball around each caster.
    pub fn new(casters: Vec<Ball>) -> Self {
        Self { balls: bundled(casters, BALLS) }
    }

    /// Without casters: directions are sampled by the cosine alone.
    pub fn everywhere() -> Self {
        Self { balls: vec![] }
    }

    /// The distribution of directions from a point with the normal n (world, unit length).
    pub fn from(&self, p: DVec3, n: DVec3) -> Aimed {
        let mut aimed = Aimed { n, cones: [Cone::NONE; BALLS], count: self.balls.len(), total: 0.0 };
        for (cone, &ball) in aimed.cones.iter_mut().zip(&self.balls) {
            *cone = Cone::of(ball, p, n);
            aimed.total += cone.weight;
        }
        aimed
    }
}

/// At most `most` balls around all: the group of balls with the largest box is halved along its longest extent until
/// there are so many groups, each of which gets one ball.
pub fn bundled(balls: Vec<Ball>, most: usize) -> Vec<Ball> {
    let size = |group: &[Ball]| {
        let (lo, hi) = ball::bounds_of(group);
        hi - lo
    };
    let mut groups = vec![balls];
    groups.retain(|group| !group.is_empty());
    while groups.len() < most {
        // The group whose box is largest is the worst to aim at.
        let several = groups.iter().enumerate().filter(|(_, group)| group.len() > 1);
        let extents = several.map(|(i, group)| (i, size(group).max_element()));
        let Some((worst, _)) = extents.max_by(|(i, a), (j, b)| a.total_cmp(b).then(j.cmp(i))) else {
            break;
        };
        let mut group = std::mem::take(&mut groups[worst]);
        let axis = size(&group).max_position();
        group.sort_by(|a, b| a.centre[axis].total_cmp(&b.centre[axis]));
        groups.push(group.split_off(group.len() / 2));
        groups[worst] = group;
    }
    groups.iter().map(|group| Ball::around(group)).collect()
}

/// The cone of directions in which a ball is seen from a point.
#[derive(Clone, Copy)]
struct Cone {
    /// Whether the ball contains the point; then of the other fields only `weight` has a meaning.
    surrounds: bool,
    axis: DVec3,
    /// 1 − cos of the angle between its axis and its surface.
    one_minus_cos: f64,
    /// cₖ: the largest cosine to the normal of its directions, 0 if all are below the horizon.
    largest: f64,
    /// Ωₖ cₖ; π if the ball contains the point.
    weight: f64,
}

impl Cone {
    const NONE: Self =
        Self { surrounds: false, axis: DVec3::Z, one_minus_cos: 0.0, largest: 0.0, weight: 0.0 };

    fn of(Ball { centre, radius }: Ball, p: DVec3, n: DVec3) -> Self {
        let towards = centre - p;
        let distance = length(towards);
        if distance <= radius {
            return Self { surrounds: true, weight: PI, ..Self::NONE };
        }
        let (axis, sin) = (towards / distance, radius / distance);
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let height = axis.dot(n);
        // The cone's direction nearest to the normal: the cosine of the difference of two angles.
        let largest =
            if height >= cos { 1.0 } else { height * cos + (1.0 - height * height).max(0.0).sqrt() * sin };
        let (one_minus_cos, largest) = (sin * sin / (1.0 + cos), largest.max(0.0));
        Self { surrounds: false, axis, one_minus_cos, largest, weight: 2.0 * PI * one_minus_cos * largest }
    }

    /// The ball's term of the sum in the density, `cosine` being cos/π: cₖ if the direction w is in the cone;
    /// π times the density, if the ball contains the point.
    fn part(&self, w: DVec3, cosine: f64) -> f64 {
        // |w − axis|² / 2 is 1 − cos without its cancellation.
        if self.surrounds {
            PI * cosine
        } else if 0.5 * (w - self.axis).length_squared() <= self.one_minus_cos {
            self.largest
        } else {
            0.0
        }
    }
}

/// The density p(ω) at one point of an emitter.
pub struct Aimed {
    n: DVec3,
    cones: [Cone; BALLS],
    count: usize,
    total: f64,
}

impl Aimed {
    fn cones(&self) -> &[Cone] {
        &self.cones[..self.count]
    }

    /// A direction by three numbers in [0, 1); a strip of the first two falls to each cone, as in
    /// [`Discrete::sample_strip`](crate::math::Discrete::sample_strip).
    pub fn sample(&self, u: DVec2, digits: f64) -> DVec3 {
        let cosine = |x: f64| Frame::about(self.n).to_world(warp::cosine_hemisphere(DVec2::new(x, u.y)));
        let choice = with_digits(u.x, digits);
        if self.count == 0 {
            return cosine(choice);
        }
        if choice < UNAIMED {
            return cosine(choice / UNAIMED);
        }
        let aimed = (choice - UNAIMED) / (1.0 - UNAIMED);
        let mut rest = aimed * self.total;
        for cone in self.cones() {
            if rest < cone.weight {
                let x = (rest / cone.weight).min(BELOW_ONE);
                return if cone.surrounds {
                    cosine(x)
                } else {
                    Frame::about(cone.axis).to_world(warp::cone(DVec2::new(x, u.y), cone.one_minus_cos))
                };
            }
            rest -= cone.weight;
        }
        // No ball is in front, or rounding has left a little beyond the last.
        cosine(aimed)
    }

    /// The density of [`Aimed::sample`] in sr⁻¹; zero behind the emitter.
    pub fn density(&self, w: DVec3) -> f64 {
        let cosine = w.dot(self.n) * INV_PI;
        if cosine <= 0.0 {
            return 0.0;
        }
        if self.total == 0.0 {
            return cosine;
        }
        let aimed: f64 = self.cones().iter().map(|cone| cone.part(w, cosine)).sum();
        UNAIMED * cosine + (1.0 - UNAIMED) * aimed / self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Sampler, SamplerKind};

    fn example() -> Aim {
        let ball = |x: f64, y: f64, z: f64, radius: f64| Ball { centre: DVec3::new(x, y, z), radius };
        Aim::new(vec![
            ball(0.0, 0.0, 2.0, 0.5),
            ball(1.5, 0.2, 1.0, 0.7),
            ball(0.1, 0.0, -3.0, 0.9),
            ball(2.0, 2.0, 0.1, 1.0),
        ])
    }

    #[test]
    fn averages_over_directions_are_those_of_the_hemisphere() {
        for (p, n) in [(DVec3::ZERO, DVec3::Z), (DVec3::new(0.1, 0.0, 1.9), DVec3::X)] {
            let aimed = example().from(p, n);
            // ∫ g dω of functions that are large within, across and beside the cones, by sampling; each is
            // known.
            const N: u32 = 1 << 18;
            let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
            for i in 0..N {
                let u = Sampler::new(SamplerKind::Independent, 0, (0, 0), i).block(0);
                let w = aimed.sample(u.pair(0), u.one(4));
                let density = aimed.density(w);
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
    fn few_balls_hold_many() {
        let centre =
            |i: u32| DVec3::new(f64::from(i * 37 % 101), f64::from(i * 61 % 97), f64::from(i * 13 % 89));
        let casters: Vec<_> =
            (0..500).map(|i| Ball { centre: centre(i), radius: f64::from(i % 7) / 4.0 }).collect();
        let aim = Aim::new(casters.clone());
        assert_eq!(aim.balls.len(), BALLS);
        for caster in casters {
            let holds = |ball: &Ball| {
                length(caster.centre - ball.centre) + caster.radius <= ball.radius * (1.0 + 1e-12)
            };
            assert!(aim.balls.iter().any(holds));
        }
    }

    #[test]
    fn nothing_is_aimed_beside_a_single_ball() {
        let ball = Ball { centre: DVec3::new(0.3, 0.1, 4.0), radius: 0.5 };
        let aimed = Aim::new(vec![ball]).from(DVec3::ZERO, DVec3::Z);
        let meets = |w: DVec3| length(ball.centre - w * ball.centre.dot(w)) <= ball.radius * (1.0 + 1e-12);
        let number = |i: u32| Sampler::new(SamplerKind::Independent, 0, (0, 0), i).block(0);
        const N: u32 = 1000;
        let met = (0..N).filter(|&i| meets(aimed.sample(number(i).pair(0), number(i).one(4)))).count();
        let expected = (1.0 - UNAIMED) * f64::from(N);
        assert!(met as f64 > expected - 4.0 * (expected * UNAIMED).sqrt(), "{met}");
    }
}
