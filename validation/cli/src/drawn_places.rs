//! Points on lenses and in filters, and wavelengths, as distributions over rectangles.

use etalon::film::filter::{FILTERS, Profile};
use etalon::film::filter_sampler::FilterSampler;
use etalon::math::DVec2;
use etalon::math::quadrature::integrate_from_kink;
use etalon::scene::loader::Loader;
use etalon::scene::params::Usage;
use etalon::scene::{registry::construct, xml};
use etalon::sensor::{AnySensor, Optics, SENSORS, Sensor};
use etalon::spectrum::{ColorMode, Wavelengths};
use std::f64::consts::PI;
use validation::chart::{Place, Planar};
use validation::quadrature::Cell;

fn parse<T>(
    snippet: &str,
    read: impl for<'d> Fn(&'d xml::Element, &Loader<'d>) -> Result<T, etalon::scene::error::SceneError>,
) -> Result<T, String> {
    let text = format!("<scene version=\"3.0.0\">{snippet}</scene>");
    let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
    let loader = Loader::new(&document, ColorMode::Rgb).map_err(|e| e.to_string())?;
    read(&document.root.children[0], &loader).map_err(|e| e.to_string())
}

/// The point where a ray leaves the lens, or the disk that a meter is aimed at: squared radius, in units of its own
/// squared, and azimuth, in which a disk is a rectangle. Sensors without a lens draw nothing.
pub struct Lens {
    camera: AnySensor,
}

impl Lens {
    pub fn new(snippet: &str) -> Result<Self, String> {
        let read = |element: &xml::Element, loader: &Loader| {
            construct(SENSORS, element, loader, Usage::Unbounded).map(|sensor: Sensor| sensor.camera)
        };
        parse(snippet, read).map(|camera| Self { camera })
    }

    /// The ray's point in the plane of the lens, for sensors that look along z from the origin. Directions from a
    /// surface are drawn as points of a disk below them.
    fn place(&self, lens: DVec2) -> DVec2 {
        let ray = self.camera.ray(DVec2::new(0.3, 0.6), lens);
        if let AnySensor::IrradianceMeter(_) = self.camera {
            return DVec2::new(ray.direction.x, ray.direction.y);
        }
        let p = ray.at(-ray.origin.z / ray.direction.z);
        DVec2::new(p.x, p.y)
    }

    /// The lens's radius: half the largest distance between two rays.
    fn radius(&self) -> f64 {
        0.5 * (self.place(DVec2::new(0.0, 0.5)) - self.place(DVec2::new(1.0, 0.5))).length()
    }
}

impl Planar for Lens {
    fn bounds(&self) -> Cell {
        Cell { low: [0.0, -PI], high: [1.0, PI] }
    }

    fn value(&self, _: [f64; 2]) -> f64 {
        self.pdf([0.0; 2])
    }

    fn pdf(&self, _: [f64; 2]) -> f64 {
        if self.camera.has_lens() { 0.5 / PI } else { 0.0 }
    }

    fn sample(&self, u: [f64; 3]) -> Option<Place> {
        if !self.camera.has_lens() {
            return None;
        }
        let p = self.place(DVec2::new(u[1], u[2])) / self.radius();
        let at = [p.length_squared().min(1.0), etalon::math::function::atan2(p.y, p.x)];
        Some(Place { at, weight: 1.0, pdf: self.pdf(at) })
    }
}

/// Neighbouring numbers in [0, 1) between which a monotonic map reaches `target`, by so many bisections.
fn numbers_that_lead_to(target: f64, steps: u32, map: impl Fn(f64) -> f64) -> [f64; 2] {
    let (mut low, mut high) = (0.0, 1.0 - f64::EPSILON);
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if map(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}

/// Positions along one axis of a reconstruction filter; the other axis is uniform. Weights and values are
/// magnitudes.
pub struct Filter {
    profile: Profile,
    sampler: FilterSampler,
    margins: [u32; 2],
    /// Both ends in pixels.
    ends: [f64; 2],
    /// ∫f.
    integral: f64,
}

impl Filter {
    /// A filter at a pixel with `margins` pixels of the film before and after it.
    pub fn new(snippet: &str, margins: [u32; 2]) -> Result<Self, String> {
        let profile =
            parse(snippet, |element, loader| construct(FILTERS, element, loader, Usage::Unbounded))?;
        let end = |pixels: u32| profile.radius().min(f64::from(pixels) + 0.5);
        let ends = [-end(margins[0]), end(margins[1])];
        // Not the sampler's own sum, which is what is asked about.
        const PARTS: f64 = 32.0;
        let count = (PARTS * (ends[1] - ends[0])).round() as usize;
        let at = |i: usize| ends[0] + i as f64 / PARTS;
        let integral = (0..count).map(|i| integrate_from_kink(at(i), at(i + 1), |x| profile.eval(x))).sum();
        Ok(Self { profile, sampler: FilterSampler::new(profile), margins, ends, integral })
    }

    fn drawn(&self, u: f64) -> (f64, f64) {
        self.sampler.sample(u, self.margins[0], self.margins[1])
    }
}

impl Planar for Filter {
    fn bounds(&self) -> Cell {
        Cell { low: [self.ends[0], 0.0], high: [self.ends[1], 1.0] }
    }

    fn value(&self, [x, _]: [f64; 2]) -> f64 {
        // Halved, so that the magnitudes of a filter with negative lobes integrate to at most 1.
        0.5 * (self.profile.eval(x) / self.integral).abs()
    }

    /// The density that the weight there states. The place is monotonic in the random number, so bisection finds the
    /// number.
    fn pdf(&self, [x, _]: [f64; 2]) -> f64 {
        let [low, _] = numbers_that_lead_to(x, 50, |u| self.drawn(u).0);
        let (found, weight) = self.drawn(low);
        let value = self.profile.eval(found);
        if value.abs() > 1e-6 * self.profile.eval(0.0) {
            return (value / (weight * self.integral)).abs();
        }
        // Next to a zero of the filter a weight states nothing. There it is how far apart numbers lead.
        const STEP: f64 = 1e-9;
        let (before, after) = ((low - STEP).max(0.0), (low + STEP).min(1.0 - f64::EPSILON));
        (after - before) / (self.drawn(after).0 - self.drawn(before).0)
    }

    fn sample(&self, u: [f64; 3]) -> Option<Place> {
        let (x, weight) = self.drawn(u[1]);
        let at = [x, u[2]];
        Some(Place { at, weight: 0.5 * weight.abs(), pdf: self.pdf(at) })
    }
}

/// The first wavelength of a path in nm; the second axis is uniform and unused.
pub struct Hero {
    /// Whether the wavelength is drawn as for colours; otherwise uniformly, as for films of bands.
    pub visible: bool,
}

const RANGE: [f64; 2] = [360.0, 830.0];

impl Hero {
    fn lanes(&self, u: f64) -> Wavelengths {
        if self.visible {
            Wavelengths::sample_visible(u)
        } else {
            Wavelengths::sample_uniform(u, RANGE[0] as f32, RANGE[1] as f32)
        }
    }
}

impl Planar for Hero {
    fn bounds(&self) -> Cell {
        Cell { low: [RANGE[0], 0.0], high: [RANGE[1], 1.0] }
    }

    fn value(&self, [nm, _]: [f64; 2]) -> f64 {
        0.5 / (RANGE[1] - RANGE[0]) * (nm - RANGE[0]) / (RANGE[1] - RANGE[0])
    }

    /// The density that a path with this first wavelength states. The wavelength is monotonic in the random
    /// number, so bisection finds the number.
    fn pdf(&self, [nm, _]: [f64; 2]) -> f64 {
        let [_, high] = numbers_that_lead_to(nm, 40, |u| f64::from(self.lanes(u).nm[0]));
        f64::from(self.lanes(high).pdf[0])
    }

    fn sample(&self, u: [f64; 3]) -> Option<Place> {
        let λ = self.lanes(u[1]);
        let (at, pdf) = ([f64::from(λ.nm[0]), u[2]], f64::from(λ.pdf[0]));
        Some(Place { at, weight: self.value(at) / pdf, pdf })
    }
}
