//! Bounding balls.

use super::bounds::{self, Bounds, union};
use super::{DVec3, length};

/// All points no farther from the centre than the radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    pub centre: DVec3,
    pub radius: f64,
}

impl Ball {
    /// The smallest ball that contains a box.
    pub fn of_box((lo, hi): Bounds) -> Self {
        Self { centre: 0.5 * (lo + hi), radius: 0.5 * length(hi - lo) }
    }

    /// A ball that contains points, about the middle of their box. There may be a smaller one, but none of
    /// less than 1/√3 of its radius.
    pub fn of_points(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let (lo, hi) = bounds::around(points.clone());
        let centre = 0.5 * (lo + hi);
        Self { centre, radius: points.map(|p| length(p - centre)).fold(0.0, f64::max) }
    }

    /// A ball that contains other balls, about the middle of their box.
    pub fn around(balls: &[Self]) -> Self {
        if let [one] = balls {
            return *one;
        }
        let (lo, hi) = bounds_of(balls);
        let centre = 0.5 * (lo + hi);
        let reach = balls.iter().map(|ball| length(ball.centre - centre) + ball.radius);
        Self { centre, radius: reach.fold(0.0, f64::max) }
    }
}

/// The box around balls.
pub fn bounds_of(balls: &[Ball]) -> Bounds {
    balls
        .iter()
        .map(|ball| (ball.centre - ball.radius, ball.centre + ball.radius))
        .fold(bounds::NOTHING, union)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::bounds::corners;

    /// Points all over a box that is no cube.
    fn points() -> Vec<DVec3> {
        let corner =
            |i: u32| DVec3::new(f64::from(i * 37 % 101), f64::from(i * 61 % 47), f64::from(i * 13 % 89));
        (0..200).map(corner).collect()
    }

    fn holds(ball: Ball, p: DVec3) -> bool {
        length(p - ball.centre) <= ball.radius * (1.0 + 1e-12)
    }

    #[test]
    fn all_is_held_and_little_else() {
        let points = points();
        let bounds = bounds::around(points.iter().copied());
        let (of_box, of_points) = (Ball::of_box(bounds), Ball::of_points(points.iter().copied()));
        assert!(corners(bounds).iter().all(|p| holds(of_box, *p)));
        assert!(points.iter().all(|p| holds(of_points, *p)));
        assert!(of_points.radius <= of_box.radius && of_points.radius >= of_box.radius / f64::sqrt(3.0));
    }

    #[test]
    fn a_ball_around_balls_holds_each() {
        let balls: Vec<Ball> = points()
            .into_iter()
            .enumerate()
            .map(|(i, centre)| Ball { centre, radius: i as f64 / 50.0 })
            .collect();
        let all = Ball::around(&balls);
        for ball in &balls {
            let away = ball.centre - all.centre;
            let farthest = ball.centre + away * (ball.radius / length(away));
            assert!(holds(all, farthest));
        }
        let one = Ball { centre: DVec3::new(1.0, 2.0, 4.0), radius: 0.5 };
        assert_eq!(Ball::around(&[one]), one);
    }
}
