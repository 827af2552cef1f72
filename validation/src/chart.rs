//! Distributions over rectangles, such as points in a filter or on a lens, mapped to distributions over the
//! sphere.
//!
//! The cylindrical coordinates z = cos θ and φ preserve area (Archimedes), so a density over a rectangle is
//! proportional to a density over the sphere, and every check of directions also checks points of a
//! rectangle.

use std::f64::consts::PI;

use crate::{
    quadrature::Cell,
    scatterer::{DVec3, Laws, Sample, Scatterer, coordinates, direction},
};

/// One sampled point of the rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Coordinates of the point.
    pub at: [f64; 2],
    /// The estimated function over the density.
    pub weight: f64,
    /// Density in the rectangle's own measure.
    pub pdf: f64,
}

/// A distribution over a rectangle, and the function that it samples.
pub trait Planar {
    /// The rectangle that contains all points.
    fn bounds(&self) -> Cell;

    /// The function that weights estimate; finite and not negative.
    fn value(&self, at: [f64; 2]) -> f64;

    /// Density of [`Planar::sample`] in the rectangle's own measure.
    fn pdf(&self, at: [f64; 2]) -> f64;

    /// A point for the three uniform numbers `u`, which have the same roles as in [`Scatterer::sample`];
    /// `None` if no point is drawn.
    fn sample(&self, u: [f64; 3]) -> Option<Place>;
}

/// A [`Planar`] distribution on the sphere.
pub struct Chart<P>(pub P);

impl<P: Planar> Chart<P> {
    /// Area of the rectangle per steradian.
    fn scale(&self) -> f64 {
        let Cell { low, high } = self.0.bounds();
        (high[0] - low[0]) * (high[1] - low[1]) / (4.0 * PI)
    }

    fn place(&self, wi: DVec3) -> [f64; 2] {
        let Cell { low, high } = self.0.bounds();
        let [z, phi] = coordinates(wi);
        let share = [0.5 + 0.5 * z, 0.5 + 0.5 * phi / PI];
        [0, 1].map(|axis| low[axis] + share[axis] * (high[axis] - low[axis]))
    }

    fn direction(&self, at: [f64; 2]) -> DVec3 {
        let Cell { low, high } = self.0.bounds();
        let share = [0, 1].map(|axis| (at[axis] - low[axis]) / (high[axis] - low[axis]));
        direction(2.0 * share[0] - 1.0, PI * (2.0 * share[1] - 1.0))
    }
}

impl<P: Planar> Scatterer for Chart<P> {
    fn value(&self, _: DVec3, wi: DVec3) -> f64 {
        self.0.value(self.place(wi)) * self.scale()
    }

    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        self.0.pdf(self.place(wi)) * self.scale()
    }

    fn sample(&self, _: DVec3, u: [f64; 3]) -> Option<Sample> {
        let place = self.0.sample(u)?;
        let (wi, pdf) = (self.direction(place.at), place.pdf * self.scale());
        Some(Sample { wi, weight: place.weight, pdf, delta: false })
    }

    fn laws(&self) -> Laws {
        Laws::default()
    }

    fn is_phase_function(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        checks::{Effort, find},
        statistics::{Verdict, seed_for},
    };

    /// Density 2x/a² · 1/b over [0, a] × [0, b], stated with another slope if `tilt` is not 1.
    struct Ramp {
        tilt: f64,
    }

    impl Planar for Ramp {
        fn bounds(&self) -> Cell {
            Cell { low: [0.0, 0.0], high: [3.0, 0.5] }
        }

        fn value(&self, [x, _]: [f64; 2]) -> f64 {
            x * x / 20.0
        }

        fn pdf(&self, [x, _]: [f64; 2]) -> f64 {
            let t = x / 3.0;
            (2.0 * t * self.tilt + (1.0 - self.tilt)) / 1.5
        }

        fn sample(&self, u: [f64; 3]) -> Option<Place> {
            let at = [3.0 * u[1].sqrt(), 0.5 * u[2]];
            let pdf = self.pdf(at);
            Some(Place { at, weight: self.value(at) / pdf, pdf })
        }
    }

    #[test]
    fn the_checks_accept_a_ramp_and_reject_a_tilted_one() {
        let effort = Effort { samples: 1 << 17, ..Effort::default() };
        for name in ["chi2", "normalisation", "jacobian", "moments", "furnace", "weight"] {
            let run = |tilt: f64| {
                find(name).unwrap().run(&Chart(Ramp { tilt }), DVec3::Z, seed_for(name, 0), &effort)
            };
            assert_eq!(run(1.0).verdict, Verdict::Equivalent, "{:?}", run(1.0));
            if name == "chi2" || name == "jacobian" {
                assert_eq!(run(0.9).verdict, Verdict::Different, "{:?}", run(0.9));
            }
        }
    }
}
