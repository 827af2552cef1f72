//! The maps from the unit square on which models are based.

use crate::trial::Source;
use etalon::math::{DVec2, DVec3, warp};
use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;
use validation::chart::{Chart, Place, Planar};
use validation::quadrature::Cell;
use validation::scatterer::coordinates;
use validation::{Sample, Scatterer};

/// A map to directions with its density.
struct Directions {
    map: fn(DVec2) -> DVec3,
    pdf: fn(DVec3) -> f64,
}

impl Scatterer for Directions {
    fn value(&self, _: DVec3, wi: DVec3) -> f64 {
        (self.pdf)(wi)
    }

    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        (self.pdf)(wi)
    }

    fn sample(&self, _: DVec3, u: [f64; 3]) -> Option<Sample> {
        let wi = (self.map)(DVec2::new(u[1], u[2]));
        let pdf = (self.pdf)(wi);
        (pdf > 0.0).then_some(Sample { wi, weight: 1.0, pdf, delta: false })
    }

    fn is_phase_function(&self) -> bool {
        true
    }
}

/// A map to points of a rectangle, in which its density is constant.
struct Places {
    map: fn(DVec2) -> [f64; 2],
    bounds: Cell,
}

impl Planar for Places {
    fn bounds(&self) -> Cell {
        self.bounds
    }

    fn value(&self, at: [f64; 2]) -> f64 {
        self.pdf(at)
    }

    fn pdf(&self, _: [f64; 2]) -> f64 {
        let Cell { low, high } = self.bounds;
        1.0 / ((high[0] - low[0]) * (high[1] - low[1]))
    }

    fn sample(&self, u: [f64; 3]) -> Option<Place> {
        let at = (self.map)(DVec2::new(u[1], u[2]));
        Some(Place { at, weight: 1.0, pdf: self.pdf(at) })
    }
}

/// Sizes of cones as 1 − cos: a quarter of the sphere, and a lamp across a room.
const CONES: [f64; 2] = [0.5, 1e-4];

fn within(w: DVec3, one_minus_cos: f64) -> f64 {
    if 1.0 - w.z <= one_minus_cos { warp::cone_pdf(one_minus_cos) } else { 0.0 }
}

fn directions(map: fn(DVec2) -> DVec3, pdf: fn(DVec3) -> f64) -> Source {
    Arc::new(move || Ok(Box::new(Directions { map, pdf }) as Box<dyn Scatterer>))
}

fn places(map: fn(DVec2) -> [f64; 2], bounds: Cell) -> Source {
    Arc::new(move || Ok(Box::new(Chart(Places { map, bounds })) as Box<dyn Scatterer>))
}

/// Every warp by name.
pub fn sources() -> Vec<(&'static str, Source)> {
    vec![
        ("cosine-hemisphere", directions(warp::cosine_hemisphere, warp::cosine_hemisphere_pdf)),
        ("sphere", directions(warp::sphere, |_| 0.25 * FRAC_1_PI)),
        ("cone", directions(|u| warp::cone(u, CONES[0]), |w| within(w, CONES[0]))),
        ("narrow-cone", directions(|u| warp::cone(u, CONES[1]), |w| within(w, CONES[1]))),
        // Squared radius and azimuth: equal rectangles are equal areas of the disk.
        (
            "disk-concentric",
            places(
                |u| {
                    let d = warp::disk_concentric(u).extend(0.0);
                    [d.length_squared().min(1.0), coordinates(d)[1]]
                },
                Cell { low: [0.0, -PI], high: [1.0, PI] },
            ),
        ),
        // (a, b) with a = (u + v)² and b = u/(u + v): equal rectangles are equal areas of the triangle.
        (
            "triangle",
            places(
                |u| {
                    let t = warp::triangle(u);
                    let sum = t.x + t.y;
                    [(sum * sum).min(1.0), if sum > 0.0 { t.x / sum } else { 0.0 }]
                },
                Cell { low: [0.0, 0.0], high: [1.0, 1.0] },
            ),
        ),
    ]
}
