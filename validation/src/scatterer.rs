//! The interface of BSDFs and phase functions to the checks: value, density, sampling, and the laws they
//! claim.

pub use glam::DVec3;

/// One sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit vector, away from the surface.
    pub wi: DVec3,
    /// f(wo, wi) |cos θi| / pdf; for a delta lobe, its coefficient over the probability of choosing it.
    pub weight: f64,
    /// Density in solid angle, including the probability of choosing the lobe; for a delta lobe, that
    /// probability.
    pub pdf: f64,
    /// True if `wi` comes from a delta lobe.
    pub delta: bool,
}

/// The laws a model claims to obey. Checks hold it to these and to nothing else.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Laws {
    /// f(wo, wi) / η(wo)² = f(wi, wo) / η(wi)² (Veach 1997, eq. 5.14).
    pub reciprocal: bool,
    /// All light that arrives leaves again.
    pub lossless: bool,
    /// Index of refraction below the surface (z < 0) relative to above, if radiance is scaled by η² on
    /// crossing; `None` for opaque models and for those that do not scale.
    pub eta: Option<f64>,
}

impl Laws {
    /// The relative index of refraction on the side of `direction`.
    pub fn index(&self, direction: DVec3) -> f64 {
        if direction.z < 0.0 { self.eta.unwrap_or(1.0) } else { 1.0 }
    }

    /// (η(wi)/η(wo))²: converts a radiance weight to a flux weight, to which energy conservation applies.
    pub fn flux_factor(&self, wo: DVec3, wi: DVec3) -> f64 {
        let ratio = self.index(wi) / self.index(wo);
        ratio * ratio
    }
}

/// A scattering distribution at one wavelength, in a local frame whose z axis is the normal. `wo` and `wi`
/// are unit vectors away from the surface; `wo` points towards the previous vertex of a camera path, `wi`
/// towards the light. The value of a phase function has no cosine.
pub trait Scatterer {
    /// f(wo, wi) |cos θi|, without delta lobes.
    fn value(&self, wo: DVec3, wi: DVec3) -> f64;

    /// Density in solid angle of [`Scatterer::sample`], without delta lobes.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64;

    /// A direction for the three uniform numbers `u`, or `None` where the path ends. By convention the first
    /// number chooses the lobe and the others the direction in it; the check `jacobian` relies on that.
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample>;

    /// The same distribution with what no direction changes worked out once, such as its textures and spectra at
    /// the point. None for models that have nothing to keep.
    fn prepared(&self) -> Option<Box<dyn Scatterer + '_>> {
        None
    }

    /// Number of queries so far that got a placeholder, where answers come later ([`crate::peer`]).
    fn unanswered(&self) -> usize {
        0
    }

    /// The laws that it claims; none by default.
    fn laws(&self) -> Laws {
        Laws::default()
    }

    /// True for phase functions, whose value has no cosine.
    fn is_phase_function(&self) -> bool {
        false
    }

    /// The same distribution at the same wavelength, on paths that carry other wavelengths beside it. None
    /// for models that know one wavelength only.
    fn companions(&self) -> Vec<Box<dyn Scatterer + '_>> {
        vec![]
    }

    /// The model's limit as a parameter goes to the end of its range, if the parameter is near that end.
    fn limit(&self) -> Option<Limit<'_>> {
        None
    }
}

/// The limit of a model.
pub struct Limit<'a> {
    pub scatterer: &'a dyn Scatterer,
    /// The largest difference of a flux moment (see the check `limits`) that the distance from the limit can
    /// explain.
    pub within: f64,
}

/// The unit vector of `cosine` = z and azimuth `phi`. These coordinates preserve area: dω = dz dφ.
pub fn direction(cosine: f64, phi: f64) -> DVec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    DVec3::new(sine * libm::cos(phi), sine * libm::sin(phi), cosine)
}

/// Inverse of [`direction`], with φ in \[−π, π\].
pub fn coordinates(direction: DVec3) -> [f64; 2] {
    [direction.z.clamp(-1.0, 1.0), libm::atan2(direction.y, direction.x)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_invert_direction() {
        for (z, phi) in [(0.3, 1.0), (-0.9, -3.0), (1.0 - 1e-9, 2.0)] {
            let [z_back, phi_back] = coordinates(direction(z, phi));
            assert!((z - z_back).abs() < 1e-15 && (phi - phi_back).abs() < 1e-9);
            assert!((direction(z, phi).length() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn flux_leaves_the_dense_side_larger() {
        let laws = Laws { eta: Some(1.5), ..Laws::default() };
        assert_eq!(laws.flux_factor(DVec3::Z, -DVec3::Z), 2.25);
        assert_eq!(laws.flux_factor(DVec3::Z, DVec3::X), 1.0);
        assert_eq!(Laws::default().flux_factor(DVec3::Z, -DVec3::Z), 1.0);
    }
}
