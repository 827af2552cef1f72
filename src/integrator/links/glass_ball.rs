//! A ball of glass: all paths through it from one point to another.
//!
//! A path that enters a ball, is reflected within it k times and leaves it lies in the plane of its two ends
//! and the centre. Let the radius be 1, the index relative to what is around η, the ends x and y, and in the
//! plane v × w the number vₓ w_y − v_y wₓ. A ray of direction d at a point p has b = p × d, its distance from
//! the centre with a sign, which is the sine of the angle θ that it makes with the normal; within the ball
//! the sine is b/η, that of θ′. At every surface the ray is turned in the same sense, by θ − θ′ where it
//! enters and leaves and by π − 2θ′ where it is reflected, so in all by
//!
//! Δ(b) = 2(θ − θ′) + k (π − 2θ′),
//!
//! and then it is as far from the centre as before. It passes through y where y × d′(b) = b, in front of
//! where it leaves the ball if y · d′ > cos θ. That is one equation in one unknown, of which all solutions
//! are looked for, between places where signs differ; how many there are (three and more within a caustic,
//! none outside) need not be known.

use crate::math::simd::F64x4;
use crate::math::{Ball, DVec2, DVec3, length, root};

/// Most paths through a ball that are found; no configuration tried had more.
const MOST_WAYS: usize = 8;

/// Values of t at which the sign is evaluated, four at once.
const PLACES: [[f64; 4]; 4] = {
    let mut places = [[0.0; 4]; 4];
    let all = places.as_flattened().len();
    let mut i = 0;
    while i < all {
        places[i / 4][i % 4] = 2.0 * i as f64 / (all - 1) as f64 - 1.0;
        i += 1;
    }
    places
};

/// A ball that lets light through.
#[derive(Clone, Copy, Debug)]
pub struct GlassBall {
    pub ball: Ball,
    /// The index inside over that outside.
    pub eta: f64,
    /// Reflections within it.
    pub inner: u32,
}

/// Start directions of links (world, unit length).
#[derive(Clone, Copy, Debug)]
pub struct Starts {
    list: [DVec3; MOST_WAYS],
    count: usize,
}

impl Starts {
    pub const NONE: Self = Self { list: [DVec3::ZERO; MOST_WAYS], count: 0 };

    pub fn one(direction: DVec3) -> Self {
        let mut one = Self::NONE;
        one.push(direction);
        one
    }

    fn push(&mut self, direction: DVec3) {
        if let Some(place) = self.list.get_mut(self.count) {
            *place = direction;
            self.count += 1;
        }
    }

    pub fn list(&self) -> &[DVec3] {
        &self.list[..self.count]
    }
}

impl GlassBall {
    /// The directions in which paths through the ball to y leave x.
    pub fn ways(&self, x: DVec3, y: DVec3) -> Starts {
        let Self { ball: Ball { centre, radius }, eta, inner } = *self;
        let mut found = Starts::NONE;
        let (x, y) = ((x - centre) / radius, (y - centre) / radius);
        let a = length(x);
        let e1 = x / a;
        let along = y.dot(e1);
        let aside = y - e1 * along;
        let across = length(aside);
        // If both ends lie on a line through the centre the plane is not known; such ends have measure zero.
        if !(a > 1.0 && along * along + across * across > 1.0) || across == 0.0 {
            return found;
        }
        let e2 = aside / across;
        let plane = Plane { a, y: DVec2::new(along, across), eta, inner };
        let error = 4.0 * f64::EPSILON * (1.0 + length(y));
        let passes = |t: f64| plane.crossing(F64x4::splat(t)).passes.to_array()[0];
        let values = PLACES.map(|t| plane.crossing(F64x4::new(t)).passes.to_array());
        let (places, values) = (PLACES.as_flattened(), values.as_flattened());
        let mut last = (places[0], values[0]);
        let mut look_before = |next: (f64, f64)| {
            if let Some(t) = root::between(last, next, error, passes) {
                let crossing = plane.crossing(F64x4::splat(t));
                if crossing.leads.to_array()[0] > 0.0 {
                    let [along, across] = crossing.before.map(|lanes| lanes.to_array()[0]);
                    found.push(e1 * along + e2 * across);
                }
            }
            last = next;
        };
        for (t, value) in places.windows(3).zip(values.windows(3)) {
            let here = (t[1], value[1]);
            let extremum = extremum([t[0], t[1], t[2]], [value[0], value[1], value[2]]);
            match extremum.map(|t| (t, passes(t))).filter(|extremum| extremum.1 * here.1 < 0.0) {
                Some(extremum) if extremum.0 < here.0 => {
                    [extremum, here].into_iter().for_each(&mut look_before)
                }
                Some(extremum) => [here, extremum].into_iter().for_each(&mut look_before),
                None => look_before(here),
            }
        }
        look_before((places[places.len() - 1], values[values.len() - 1]));
        found
    }
}

/// Where a function may cross zero twice between three equidistant places: where the parabola through its
/// values is nearest to zero, if all values have one sign and the middle one is the nearest to zero.
fn extremum([before, here, _]: [f64; 3], [a, b, c]: [f64; 3]) -> Option<f64> {
    let near = a * b > 0.0 && b * c > 0.0 && b.abs() <= a.abs() && b.abs() <= c.abs();
    let curvature = a - 2.0 * b + c;
    (near && curvature != 0.0).then(|| here + 0.5 * (here - before) * (a - c) / curvature)
}

/// The plane of both ends and the centre, with x at (a, 0).
struct Plane {
    a: f64,
    y: DVec2,
    eta: f64,
    inner: u32,
}

/// A ray before and after the ball.
struct Crossing {
    /// Unit direction before the ball, in the plane.
    before: [F64x4; 2],
    /// Signed distance by which the ray behind the ball passes y.
    passes: F64x4,
    /// Distance along that ray from where it leaves the ball to y.
    leads: F64x4,
}

/// The product of complex numbers; by one of magnitude 1 the other is turned.
#[inline(always)]
fn turned([a, b]: [F64x4; 2], [c, d]: [F64x4; 2]) -> [F64x4; 2] {
    [a * c - b * d, a * d + b * c]
}

impl Plane {
    /// The rays for t in [−1, 1]: b is the sine of 2 arctan t, times min(η, 1), the largest b that can enter.
    #[inline(always)]
    fn crossing(&self, t: F64x4) -> Crossing {
        let (zero, one) = (F64x4::splat(0.0), F64x4::splat(1.0));
        let other = |sine: F64x4| (one - sine * sine).max(zero).sqrt();
        let b = F64x4::splat(2.0 * self.eta.min(1.0)) * t / (one + t * t);
        let inside = b * F64x4::splat(1.0 / self.eta);
        let (cos, cos_inside) = (other(b), other(inside));
        let in_or_out = turned([cos_inside, -inside], [cos, b]);
        let back = turned([cos_inside, -inside], [-cos_inside, inside]);
        let turn = (0..self.inner).fold(turned(in_or_out, in_or_out), |turn, _| turned(turn, back));
        let aside = b * F64x4::splat(1.0 / self.a);
        let before = [-other(aside), aside];
        let [x, y] = turned(before, turn);
        let to = [self.y.x, self.y.y].map(F64x4::splat);
        Crossing { before, passes: to[0] * y - to[1] * x - b, leads: to[0] * x + to[1] * y - cos }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::unit;

    fn refract(d: DVec3, n: DVec3, ratio: f64) -> DVec3 {
        let cos = -d.dot(n);
        let other = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
        d * ratio + n * (ratio * cos - other)
    }

    /// Follows a ray by Snell's law through a ball of radius 1 about the origin, as if nobody knew of planes.
    fn follow(x: DVec3, d: DVec3, eta: f64, inner: u32) -> (DVec3, DVec3) {
        let t = -x.dot(d) - (x.dot(d) * x.dot(d) - x.dot(x) + 1.0).sqrt();
        let mut p = x + d * t;
        let mut d = refract(d, p, 1.0 / eta);
        for _ in 0..inner {
            p += d * (-2.0 * p.dot(d));
            d -= p * (2.0 * p.dot(d));
        }
        p += d * (-2.0 * p.dot(d));
        (p, refract(d, -p, eta))
    }

    /// A point away from the ball.
    fn point(i: u32, steps: [f64; 3], farthest: f64) -> DVec3 {
        let part = |step: f64| (f64::from(i) * step).fract();
        let direction = unit(DVec3::from(steps.map(|step| 2.0 * part(step) - 1.0)));
        direction * (1.0 + 1e-3 + farthest * part(steps[0] + steps[1]))
    }

    const X: [f64; 3] = [0.618_033_989, 0.754_877_666, 0.569_840_291];
    const Y: [f64; 3] = [0.414_213_562, 0.732_050_808, 0.236_067_977];

    #[test]
    fn all_ways_that_rays_take_are_found() {
        let ball = Ball { centre: DVec3::new(1.0, -2.0, 0.5), radius: 0.25 };
        for (eta, inner) in [(1.5, 0), (1.5, 1), (1.5, 2), (1.33, 1), (2.4, 0), (0.7, 0), (0.7, 1)] {
            let glass_ball = GlassBall { ball, eta, inner };
            let (mut tried, mut missed, mut several) = (0, 0, 0);
            for i in 1..4000 {
                let x = point(i, X, 4.0);
                // A ray that meets the ball, and a point on it behind.
                let aim = unit(x.any_orthogonal_vector()) * (f64::from(i) * 0.307_8).fract() * eta.min(1.0);
                let (p, d) = follow(x, unit(aim - x), eta, inner);
                if !d.is_finite() {
                    continue;
                }
                let y = p + d * (0.01 + 5.0 * (f64::from(i) * 0.445_1).fract());
                let ways = glass_ball.ways(ball.centre + x * ball.radius, ball.centre + y * ball.radius);
                let found = ways.list().iter().any(|way| length(*way - unit(aim - x)) < 1e-6);
                tried += 1;
                missed += u32::from(!found);
                several += u32::from(ways.list().len() > 1);
            }
            // Close to a caustic two ways may lie between two of the places.
            assert!(tried > 2000 && missed * 50 < tried, "{eta} {inner}: {missed} of {tried}");
            assert!(several * 20 > tried || eta < 1.0 && inner == 0, "{eta} {inner}: {several} of {tried}");
        }
    }

    #[test]
    fn what_is_found_leads_there() {
        let ball = Ball { centre: DVec3::ZERO, radius: 1.0 };
        for (eta, inner) in [(1.5, 0), (1.5, 1), (1.5, 2), (2.4, 0), (0.7, 0)] {
            let mut found = 0;
            for i in 1..4000 {
                let (x, y) = (point(i, X, 4.0), point(i, Y, 4.0));
                for way in (GlassBall { ball, eta, inner }).ways(x, y).list() {
                    let (p, d) = follow(x, *way, eta, inner);
                    let missed = length((y - p) - d * (y - p).dot(d));
                    assert!(missed < 1e-7 && (y - p).dot(d) > 0.0, "{eta} {inner} {x} {y}: {missed}");
                    found += 1;
                }
            }
            assert!(found > 100, "{eta} {inner}: {found}");
        }
    }
}
