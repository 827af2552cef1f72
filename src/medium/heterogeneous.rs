//! A medium whose density varies in space, within a box.
//!
//! *Flights* are drawn by delta tracking (Woodcock et al. 1965): collisions at the rate μ̄ of a bound of the
//! density, of which some are with nothing. A collision at density σᵢ is real for wavelength i with
//! probability σᵢ/μ̄; with the shares c of [`Shares`] it is taken for real with p = Σ cᵢ σᵢ/μ̄, and weighted by
//! σᵢ/(μ̄ p) or, if not, by (1 − σᵢ/μ̄)/(1 − p). Both keep the sum of what the wavelengths carry, ΣT.
//!
//! *Transmittances* are estimated by ratio tracking (Novák, Selle and Jarosz 2014, "Residual Ratio Tracking
//! for Estimating Attenuation in Participating Media"): the product of 1 − σᵢ/μ̄ over collisions at rate μ̄.
//!
//! The bound is one for each block of a few cells ([`Majorants`]). As in Mitsuba the medium ends with the box
//! along the world's axes around the unit cube of its density, so a density that is turned goes on beyond
//! its cube, by its `wrap_mode`.

use super::majorants::Majorants;
use super::{AnyExtinction, FlightNumbers, Shares, flight};
use crate::math::{DVec3, Ray, Transform, bounds};
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::volume::AnyVolume;

/// Flights are drawn as steps at the greatest density in a part of the box: more of them than this along one
/// ray would be waited for in vain.
const MOST_DEPTH: f64 = 1e6;

pub const NAME: &str = "heterogeneous";
pub const ABOUT: &str = "A medium whose density varies, within the box around its density.";
pub const EXAMPLES: &[&str] = &[
    r#"<medium type="heterogeneous"/>"#,
    r#"<medium type="heterogeneous">
        <volume type="constvolume" name="sigma_t">
            <spectrum name="value" value="400:4, 700:0.5"/>
            <transform name="to_world"><rotate y="1" angle="30"/><scale value="2, 1, 1"/></transform>
        </volume>
        <float name="albedo" value="0.5"/><phase type="rayleigh"/>
    </medium>"#,
    r#"<medium type="heterogeneous"><float name="albedo" value="0"/></medium>"#,
];

/// A medium whose density and albedo vary in space.
#[derive(Debug)]
pub struct Heterogeneous {
    /// σₜ/`scale`.
    sigma_t: AnyVolume,
    scale: f32,
    /// From the unit cube to the box in which the medium is.
    place: Transform,
    /// Bounds of σₜ over that.
    majorants: Majorants,
}

pub fn parse(params: &mut Params) -> Result<AnyExtinction, SceneError> {
    let about =
        "extinction coefficient, per unit of length; the medium ends with the box around its unit cube";
    let sigma_t = AnyVolume::parameter(params, "sigma_t", 1.0, Usage::Unbounded, about)?;
    let scale = params.amount("scale", 1.0, "factor of `sigma_t`")?;
    // Values are interpolated and multiplied in `f32`: their bound is a little above.
    let above = scale * (1.0 + 1e-5);
    let unit_cube = bounds::corners((DVec3::ZERO, DVec3::ONE));
    let (lo, hi) = bounds::around(unit_cube.map(|corner| sigma_t.to_world().point(corner)));
    let place = Transform::scale(hi - lo).map(|scale| Transform::translate(lo).after(&scale));
    let place =
        place.ok_or_else(|| params.error("sigma_t", "the density has no extent", "expected a larger box"))?;
    let to_density = sigma_t.to_world().inverted().after(&place);
    let bound = |lo, hi| {
        let (lo, hi) = bounds::around(bounds::corners((lo, hi)).map(|corner| to_density.point(corner)));
        (sigma_t.majorant(lo, hi) * above) as f32
    };
    let majorants = Majorants::new(sigma_t.resolution(), bound);
    let depth = f64::from(majorants.most()) * crate::math::length(hi - lo);
    if depth.is_nan() || depth > MOST_DEPTH {
        let message = format!("the medium is {depth:e} free paths across where it is densest");
        return Err(params.error("sigma_t", message, format!("expected at most {MOST_DEPTH:e}")));
    }
    let medium = Heterogeneous { sigma_t, scale: scale as f32, place, majorants };
    Ok(AnyExtinction::Heterogeneous(Box::new(medium)))
}

impl Heterogeneous {
    /// Where the path collides, if it does before the ray's end, and the ratio of σₜ exp(−∫σₜ), or of what comes
    /// through, to the density with which it was drawn.
    pub fn fly(
        &self,
        ray: &Ray,
        mut shares: Shares,
        λ: &Wavelengths,
        numbers: &mut FlightNumbers,
    ) -> (Option<f64>, Spectrum) {
        let mut weight = Spectrum::ONE;
        let collision = self.collisions(ray, numbers, |t, majorant, numbers| {
            let real = self.extinction(ray, t, λ).map(|rate| rate / majorant);
            let p = shares.mean(real);
            let is_real = numbers.draw() < f64::from(p);
            let factor = if is_real { real * (1.0 / p) } else { real.map(|r| (1.0 - r) / (1.0 - p)) };
            weight *= factor;
            shares = shares.after(factor, λ);
            is_real
        });
        (collision, weight)
    }

    /// An estimate of the share of light that comes straight through.
    pub fn transmittance(&self, ray: &Ray, λ: &Wavelengths, numbers: &mut FlightNumbers) -> Spectrum {
        let mut passed = Spectrum::ONE;
        self.collisions(ray, numbers, |t, majorant, _| {
            passed *= self.extinction(ray, t, λ).map(|rate| 1.0 - rate / majorant);
            passed.is_zero()
        });
        passed
    }

    #[inline]
    fn extinction(&self, ray: &Ray, t: f64, λ: &Wavelengths) -> Spectrum {
        self.sigma_t.eval(ray.at(t), λ) * self.scale
    }

    /// Calls `last` with collisions at the rate of the bound and with that rate, in order along the ray,
    /// until it says so; returns the distance of that one.
    fn collisions(
        &self,
        ray: &Ray,
        numbers: &mut FlightNumbers,
        mut last: impl FnMut(f64, f32, &mut FlightNumbers) -> bool,
    ) -> Option<f64> {
        let to_local = &self.place.inverse;
        let origin = to_local.transform_point3(ray.origin);
        let direction = to_local.transform_vector3(ray.direction);
        let mut left = flight::optical_depth(numbers.draw());
        for part in self.majorants.walk(origin, direction, ray.end) {
            // From where the part begins: far from the ray's origin, steps would be lost in a distance from there.
            let mut travelled = 0.0;
            loop {
                let rate = f64::from(part.majorant);
                let depth = (part.end - part.begin - travelled) * rate;
                if depth <= left {
                    left -= depth;
                    break;
                }
                travelled += left / rate;
                let t = part.begin + travelled;
                if last(t, part.majorant, numbers) {
                    return Some(t);
                }
                left = flight::optical_depth(numbers.draw());
            }
        }
        None
    }
}
