//! What a link may lead by, where a point seen in it can be found directly: a flat mirror, a mirroring ball,
//! or a ball of glass.
//!
//! **Flat.** The image x′ of a point x lies as far behind the plane as x before it; x sees y where the
//! segment x′y crosses the plane.
//!
//! **A ball,** seen from outside: x, y, the centre and the place z of the reflection lie in one plane. On the
//! arc from the direction to x to that to y, the angle to the normal grows at x and shrinks at y as z moves
//! on, so as long as both see z there is one place where the two are equal (Alhazen's problem); it is found
//! by false position. Light for x comes from about the image of x: with the distance s from the surface, rays
//! near the axis meet s r/(2s + r) below it.

use super::glass_ball::GlassBall;
use crate::math::{Ball, DVec2, DVec3, length, root};

/// Factor by which a ball of glass may bring more light than its solid angle suggests: behind it, at a diameter from
/// its centre, all light is taken to come by it. (Four times this factor gave no less noise.)
const GATHERED: f64 = 4.0;

/// The geometry of an element.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// All points p with n·p = height.
    Plane {
        n: DVec3,
        height: f64,
    },
    Ball(Ball),
    /// See [`glass_ball`](super::glass_ball).
    GlassBall(GlassBall),
}

/// A mirror or a ball of glass.
#[derive(Clone, Debug)]
pub struct Element {
    pub form: Form,
    /// Bounding ball.
    pub around: Ball,
    /// Approximate share of the light that it reflects (a ball of glass: transmits), on the side of the normal (of a
    /// ball: outside) and on the other.
    pub strength: [f64; 2],
    /// Its primitives, numbered over the whole scene, in ascending order.
    pub primitives: Vec<u32>,
}

impl Element {
    pub fn has(&self, primitive: u32) -> bool {
        self.primitives.binary_search(&primitive).is_ok()
    }

    pub fn glass_ball(&self) -> Option<&GlassBall> {
        match &self.form {
            Form::GlassBall(glass_ball) => Some(glass_ball),
            _ => None,
        }
    }

    /// Whether light goes through it without a reflection.
    pub fn gathers(&self) -> bool {
        self.glass_ball().is_some_and(|glass_ball| glass_ball.inner == 0)
    }

    /// The point as from which emitters are sampled for x: the image of x in the mirror, or the centre of a
    /// ball of glass, which gathers what meets it. `None` if x is inside a ball.
    pub fn image(&self, x: DVec3) -> Option<DVec3> {
        match self.form {
            Form::Plane { n, height } => Some(x - n * (2.0 * (n.dot(x) - height))),
            Form::Ball(Ball { centre, radius }) => {
                let from_centre = x - centre;
                let distance = length(from_centre);
                let s = distance - radius;
                let below = s * radius / (2.0 * s + radius);
                (s > 0.0).then(|| centre + from_centre * ((radius - below) / distance))
            }
            Form::GlassBall(GlassBall { ball: Ball { centre, radius }, .. }) => {
                (length(x - centre) > radius).then_some(centre)
            }
        }
    }

    /// The point of the mirror in which x sees y; `None` if there is none, or if this is a ball of glass.
    pub fn reflection(&self, x: DVec3, y: DVec3) -> Option<DVec3> {
        match self.form {
            Form::Plane { n, height } => {
                let (a, b) = (n.dot(x) - height, n.dot(y) - height);
                // The weights of y's foot and x's.
                (a * b > 0.0).then(|| {
                    let part = a / (a + b);
                    (x - n * a) * (1.0 - part) + (y - n * b) * part
                })
            }
            Form::Ball(Ball { centre, radius }) => {
                on_unit_ball((x - centre) / radius, (y - centre) / radius).map(|n| centre + n * radius)
            }
            Form::GlassBall(_) => None,
        }
    }

    /// Approximate share of the light at x that comes by it: its strength, times the part of the surroundings
    /// that it fills.
    pub fn weight(&self, x: DVec3) -> f64 {
        let behind = match self.form {
            Form::Plane { n, height } => n.dot(x) < height,
            Form::Ball(Ball { centre, radius })
            | Form::GlassBall(GlassBall { ball: Ball { centre, radius }, .. }) => {
                length(x - centre) <= radius
            }
        };
        let Ball { centre, radius } = self.around;
        let gathered = if self.gathers() { GATHERED } else { 1.0 };
        self.strength[usize::from(behind)]
            * (gathered * radius * radius / (x - centre).length_squared()).min(1.0)
    }
}

/// The place on a ball of radius 1 about the origin where x sees y.
fn on_unit_ball(x: DVec3, y: DVec3) -> Option<DVec3> {
    let (a, b) = (length(x), length(y));
    if !(a > 1.0 && b > 1.0) {
        return None;
    }
    let e1 = x / a;
    let along = y.dot(e1);
    let across = length(y - e1 * along);
    if across == 0.0 {
        return (along > 0.0).then_some(e1);
    }
    let e2 = (y - e1 * along) / across;
    // In the plane of the two: x = (a, 0), y = (along, across), and the normal leads from (1, 0) to y/|y| as
    // t from 0 to 1.
    let normal = |t: f64| {
        let n = DVec2::new(1.0 - t + t * along / b, t * across / b);
        n / n.length()
    };
    // The sine of the angle to the normal; for a direction below the horizon, continued beyond ±1.
    let sine = |n: DVec2, p: DVec2| {
        let way = p - n;
        let sine = n.perp_dot(way) / way.length();
        let above = n.dot(way) > 0.0;
        (if above { sine } else { sine.signum() * 2.0 - sine }, above)
    };
    // Angles to the two sides are equal where their sines, of opposite signs, sum to zero.
    let at = |t: f64| {
        let n = normal(t);
        let ((of_x, above_x), (of_y, above_y)) =
            (sine(n, DVec2::new(a, 0.0)), sine(n, DVec2::new(along, across)));
        (of_x + of_y, above_x && above_y, n)
    };
    let (low, high) = (at(0.0).0, at(1.0).0);
    if !(low > 0.0 && high < 0.0) {
        return None;
    }
    let t = root::between((0.0, low), (1.0, high), 4.0 * f64::EPSILON, |t| at(t).0)?;
    let (_, seen, n) = at(t);
    seen.then(|| e1 * n.x + e2 * n.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::frame::unit;

    /// Angles to the normal, signed, and whether both are above the horizon.
    fn angles(n: DVec3, x: DVec3, y: DVec3) -> (f64, bool) {
        let (to_x, to_y) = (unit(x - n), unit(y - n));
        (to_x.dot(n) - to_y.dot(n), to_x.dot(n) > 0.0 && to_y.dot(n) > 0.0)
    }

    #[test]
    fn a_sheet_that_reflects_in_front_is_asked_from_there() {
        let form = Form::Plane { n: DVec3::Z, height: 2.0 };
        let mirror = Element {
            form,
            around: Ball { centre: DVec3::new(0.0, 0.0, 2.0), radius: 1.0 },
            strength: [0.9, 0.0],
            primitives: vec![],
        };
        // The part of the surroundings: radius² over distance².
        assert!((mirror.weight(DVec3::new(0.0, 0.0, 4.0)) - 0.9 / 4.0).abs() < 1e-15);
        assert_eq!(mirror.weight(DVec3::ZERO), 0.0);
    }

    #[test]
    fn on_a_ball_both_angles_are_equal() {
        let (mut found, mut none) = (0, 0);
        for i in 0..4000 {
            let part = |step: f64| (f64::from(i) * step).fract();
            // Distances from close above the ball to far from it, on all sides.
            let away = |u: f64| 1.0 + 1e-9 * 1e12f64.powf(u);
            let turn = std::f64::consts::TAU * part(0.618_033_989);
            let x = DVec3::new(0.6, 0.0, 0.8) * away(part(0.754_877_666));
            let y = DVec3::new(turn.cos(), 0.6 * turn.sin(), 0.8 * turn.sin()) * away(part(0.569_840_291));
            match on_unit_ball(x, y) {
                Some(n) => {
                    let (difference, above) = angles(n, x, y);
                    assert!(above && (length(n) - 1.0).abs() < 1e-12, "{x} {y}");
                    // The way from a point close to the ball is known as well as the point.
                    let known = 1e-13 / (length(x) - 1.0).min(length(y) - 1.0).min(1.0);
                    assert!(difference.abs() < 1e-9 + 100.0 * known, "{x} {y}: {difference}");
                    found += 1;
                }
                None => {
                    // No place on the arc between sees both.
                    let (a, b) = (unit(x), unit(y));
                    let sees = |i: i32| {
                        let n = unit(a * (1.0 - f64::from(i) / 1e3) + b * (f64::from(i) / 1e3));
                        x.dot(n) > 1.0 + 1e-6 && y.dot(n) > 1.0 + 1e-6
                    };
                    assert!(!(0..=1000).any(sees), "{x} {y}");
                    none += 1;
                }
            }
        }
        assert!(found > 500 && none > 500, "{found} {none}");
    }
}
