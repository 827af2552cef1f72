//! Thermal radiation.

use crate::math::function::exp;

/// The light of a black body, in a range of wavelengths.
#[derive(Clone, Debug)]
pub struct Blackbody {
    /// Temperature in K.
    pub kelvin: f64,
    /// A factor of its radiance.
    pub scale: f64,
    /// First and last wavelength in nm; outside there is no light.
    pub range: (f32, f32),
}

impl Blackbody {
    /// Spectral radiance in W·m⁻²·sr⁻¹·nm⁻¹ at λ in nm.
    #[inline]
    pub fn eval(&self, λ: f32) -> f32 {
        let within = (self.range.0..=self.range.1).contains(&λ);
        if within { (self.scale * radiance(self.kelvin, f64::from(λ))) as f32 } else { 0.0 }
    }

    /// The largest value: that at the wavelength of Wien's law, or at the end of the range that is nearest.
    pub fn bound(&self) -> f32 {
        const WIEN: f64 = 2.897_772_9e6;
        let λ = (WIEN / self.kelvin).clamp(self.range.0.into(), self.range.1.into());
        // The constant is rounded, by far less than this.
        (self.scale * radiance(self.kelvin, λ) * (1.0 + 1e-9)) as f32
    }
}

/// Planck's law: spectral radiance in W·m⁻²·sr⁻¹·nm⁻¹ of a black body at a temperature in K, at λ in nm.
///
/// L = 2hc²λ⁻⁵ / (exp(hc/λkT) − 1). The constants are those of CODATA 2014, which Mitsuba uses.
#[inline]
pub fn radiance(kelvin: f64, λ_nm: f64) -> f64 {
    const C: f64 = 2.99792458e8;
    const H: f64 = 6.62607004e-34;
    const K: f64 = 1.38064852e-23;
    let λ = λ_nm * 1e-9;
    let λ5 = λ * λ * (λ * λ) * λ;
    1e-9 * 2.0 * H * C * C / (λ5 * (exp(H * C / (K * λ * kelvin)) - 1.0))
}

#[cfg(test)]
mod tests {
    use super::radiance;

    #[test]
    fn wien_and_stefan_boltzmann_hold() {
        let t = 5800.0;
        let peak =
            (300..900).max_by(|&a, &b| radiance(t, a as f64).total_cmp(&radiance(t, b as f64))).unwrap();
        assert!((peak as f64 - 2.897772e6 / t).abs() < 1.0);
        let total: f64 = (10..2_000_000).map(|i| radiance(t, i as f64 * 0.1) * 0.1).sum();
        let expected = 5.670367e-8 * t * t * (t * t) / std::f64::consts::PI;
        assert!((total / expected - 1.0).abs() < 2e-4, "{total} {expected}");
    }

    #[test]
    fn radiance_is_that_of_mitsuba() {
        // Mitsuba 3.9.1's `blackbody` in scalar_spectral, computed in f32 with an exponential of relative
        // error 1e-6.
        for (kelvin, λ, expected) in [
            (2700.0, 360.0, 7.343_215),
            (2700.0, 830.0, 493.136_14),
            (5000.0, 560.0, 12_762.176),
            (12_000.0, 360.0, 730_831.9),
        ] {
            assert!(
                (radiance(kelvin, λ) / expected - 1.0).abs() < 3e-6,
                "{kelvin} {λ} {}",
                radiance(kelvin, λ)
            );
        }
    }
}
