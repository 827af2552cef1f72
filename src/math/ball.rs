//! Bounding balls.

use super::bounds::{self, Bounds, union};
use super::{DVec3, Transform, length};

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

    /// A ball that contains this one where a transform puts it. With the axes' images as the columns of M no vector is
    /// stretched by more than the root of the largest row sum of |MᵀM| (Gershgorin), which is exact for similarities.
    pub fn placed(&self, place: &Transform) -> Self {
        let axes = DVec3::AXES.map(|axis| place.vector(axis));
        let row = |a: DVec3| axes.iter().map(|b| a.dot(*b).abs()).sum::<f64>();
        let stretch = axes.map(row).into_iter().fold(0.0, f64::max).sqrt();
        Self { centre: place.point(self.centre), radius: self.radius * stretch }
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
    use crate::math::Frame;
    use crate::math::bounds::corners;
    use crate::math::frame::unit;
    use glam::{DMat4, DVec4};

    /// Points all over a box that is no cube.
    fn points() -> Vec<DVec3> {
        let corner =
            |i: u32| DVec3::new(f64::from(i * 37 % 101), f64::from(i * 61 % 47), f64::from(i * 13 % 89));
        (0..200).map(corner).collect()
    }

    #[test]
    fn a_placed_ball_holds_what_the_ball_held() {
        let shear = [DVec3::new(0.3, -2.0, 0.1), DVec3::new(4.0, 0.2, 0.0), DVec3::new(1.0, 1.0, -0.7)];
        let frame = Frame::about(unit(DVec3::new(1.0, 1.0, -0.7)));
        let turn = DVec3::AXES.map(|axis| 2.5 * frame.to_world(axis));
        let of_columns = |[x, y, z]: [DVec3; 3]| {
            let at = DVec4::new(1.0, 2.0, 3.0, 1.0);
            Transform::from_matrix(DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), at)).unwrap()
        };
        let (shear, turn) = (of_columns(shear), of_columns(turn));
        let ball = Ball { centre: DVec3::new(1.0, 2.0, -3.0), radius: 0.5 };
        for place in [&shear, &turn] {
            let placed = ball.placed(place);
            for p in points() {
                let on = ball.centre + ball.radius * unit(p - DVec3::splat(40.5));
                assert!(holds(placed, place.point(on)), "{p}");
            }
        }
        assert!((ball.placed(&turn).radius - 2.5 * ball.radius).abs() < 1e-12);
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
