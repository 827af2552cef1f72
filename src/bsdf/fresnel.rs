//! Reflection at interfaces, without cancellation.
//!
//! The textbook form subtracts nearly equal numbers when the relative index η is near 1 or the angle near
//! grazing. With q = (η − 1)(η + 1) and g = √(c² + q), c = cos θ, the amplitudes are exact products: r_s =
//! −q/(g + c)², and r_p = r_s·(c·g − s²)/(c·g + s²); the transmittance is computed, not subtracted from 1.

use crate::math::DVec3;

/// Reflection and transmission at an interface, for light from one side.
#[derive(Clone, Copy, Debug)]
pub struct Refraction {
    /// Fraction of the flux reflected (unpolarised).
    pub reflectance: f64,
    /// Fraction transmitted, 1 − reflectance to full relative precision.
    pub transmittance: f64,
    /// |cos θ| on the far side; 0 under total internal reflection.
    pub cos_transmitted: f64,
}

/// The exact Fresnel equations; `cos` = |cos θ| on the near side, `eta` = η far / η near.
#[inline]
pub fn dielectric(cos: f64, eta: f64) -> Refraction {
    let q = (eta - 1.0) * (eta + 1.0);
    let g2 = far_side(cos, eta, q);
    if g2 <= 0.0 {
        return Refraction { reflectance: 1.0, transmittance: 0.0, cos_transmitted: 0.0 };
    }
    let g = g2.sqrt();
    let (sum, sin2) = (g + cos, (1.0 - cos) * (1.0 + cos));
    let rs = q / (sum * sum);
    let rp_over_rs = (cos * g - sin2) / (cos * g + sin2);
    // c·g + s² > 0: g > 0 here, and c and s do not vanish together.
    let reflectance = 0.5 * rs * rs * (1.0 + rp_over_rs * rp_over_rs);
    // T_s = 4cg/(c + g)², T_p = 4η²cg/(η²c + g)².
    let eta2 = eta * eta;
    let p = eta2 * cos + g;
    let transmittance = 2.0 * cos * g * (1.0 / (sum * sum) + eta2 / (p * p));
    Refraction { reflectance, transmittance, cos_transmitted: g / eta }
}

/// g² = cos² + q = η² − sin² = (η cos θ′)², of the two sums the one with the smaller terms; negative under
/// total internal reflection.
#[inline]
fn far_side(cos: f64, eta: f64, q: f64) -> f64 {
    if cos > eta { eta * eta - (1.0 - cos) * (1.0 + cos) } else { cos * cos + q }
}

/// Schlick's approximation R₀ + (1 − R₀)(1 − cos)⁵ with R₀ = ((η − 1)/(η + 1))², taken on the optically
/// thinner side: from inside the denser medium the cosine is that of the refracted ray, so that total
/// internal reflection is met continuously. This is the approximation of the course path tracer that Etalon
/// grew out of.
#[inline]
pub fn schlick(cos: f64, eta: f64) -> Refraction {
    let exact = dielectric(cos, eta);
    if exact.transmittance == 0.0 && exact.cos_transmitted == 0.0 {
        return exact;
    }
    let r0 = (eta - 1.0) / (eta + 1.0);
    let r0 = r0 * r0;
    let thin_cos = if eta >= 1.0 { cos } else { exact.cos_transmitted };
    let reflectance = r0 + (1.0 - r0) * schlick_weight(thin_cos);
    Refraction { reflectance, transmittance: 1.0 - reflectance, cos_transmitted: exact.cos_transmitted }
}

/// (1 − cos θ)⁵, the weight of total reflection in Schlick's approximation.
#[inline]
pub fn schlick_weight(cos: f64) -> f64 {
    let rest = (1.0 - cos).clamp(0.0, 1.0);
    rest * rest * (rest * rest) * rest
}

/// The direction refracted at a normal `m` on ω's side; `cos` = ω·m, `eta` = η far / η near.
///
/// ω′ = −ω/η + (cos/η − cos′)m, with the difference written as −q/(η(g + c)), and one Newton step of
/// renormalisation.
#[inline]
pub fn refract(w: DVec3, m: DVec3, cos: f64, eta: f64) -> Option<DVec3> {
    let q = (eta - 1.0) * (eta + 1.0);
    let g2 = far_side(cos, eta, q);
    if g2 <= 0.0 {
        return None;
    }
    let t = -w / eta - m * (q / (eta * (g2.sqrt() + cos)));
    Some(t * (1.5 - 0.5 * t.dot(t)))
}

/// Reflectance of a conductor with complex index η + ik in a medium of index 1; `cos` = |cos θ|.
///
/// The algebra of |r|² in real numbers: with A = η² − k² − s² and B = 4η²k², a² + b² = √(A² + B).
#[inline]
pub fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let cos2 = cos * cos;
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let a0 = eta * eta - k * k - sin2;
    let sum = (a0 * a0 + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (sum + a0)).max(0.0).sqrt();
    let (t1, t2) = (sum + cos2, 2.0 * a * cos);
    // Where nothing is reflected, rounding must not reflect less.
    let rs = (t1 - t2).max(0.0) / (t1 + t2);
    let (t3, t4) = (cos2 * sum + sin2 * sin2, t2 * sin2);
    // t₃ vanishes only at normal incidence on η = k = 0, where the two polarisations are the same.
    let rp = if t3 > 0.0 { rs * (t3 - t4).max(0.0) / (t3 + t4) } else { rs };
    0.5 * (rs + rp)
}

/// Diffuse reflectance of a smooth interface for light from the near side: 2∫R(c)c dc, by Gauss–Legendre in
/// two pieces so that the kink at the critical angle falls on a boundary.
pub fn diffuse_reflectance(eta: f64) -> f64 {
    let critical = if eta < 1.0 { ((1.0 - eta) * (1.0 + eta)).sqrt() } else { 0.0 };
    let rest = crate::math::quadrature::integrate_from_kink(critical, 1.0, |c| {
        2.0 * c * dielectric(c, eta).reflectance
    });
    critical * critical + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::length;

    fn angles() -> impl Iterator<Item = f64> {
        (0..=1000).map(|i| i as f64 / 1000.0).chain([1e-12, 1e-6, 1.0 - 1e-12])
    }

    #[test]
    fn nothing_is_lost_or_made() {
        for eta in [1e-3, 0.5, 1.0 / 1.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 2.4, 1e4] {
            for cos in angles() {
                let f = dielectric(cos, eta);
                assert!((f.reflectance + f.transmittance - 1.0).abs() < 4e-15, "{eta} {cos} {f:?}");
            }
        }
    }

    #[test]
    fn the_textbook_form_agrees_where_it_has_digits() {
        for eta in [0.4, 0.8, 1.3, 1.5, 2.4] {
            for cos in angles() {
                let f = dielectric(cos, eta);
                let (ct, c) = (f.cos_transmitted, cos);
                if ct == 0.0 {
                    continue;
                }
                let rs = (c - eta * ct) / (c + eta * ct);
                let rp = (eta * c - ct) / (eta * c + ct);
                assert!((f.reflectance - 0.5 * (rs * rs + rp * rp)).abs() < 1e-14);
            }
        }
        // Normal incidence: ((η − 1)/(η + 1))².
        assert!((dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-16);
    }

    #[test]
    fn refraction_obeys_snell_and_stays_unit() {
        for eta in [1e-2, 1.0 / 1.5, 1.0 + 1e-12, 1.5, 1e4] {
            for cos in angles().filter(|c| *c > 0.0) {
                let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
                let Some(t) = refract(DVec3::new(sin, 0.0, cos), DVec3::Z, cos, eta) else { continue };
                assert!((length(t) - 1.0).abs() < 1e-14, "{eta} {cos}");
                assert!((t.x * eta + sin).abs() < 1e-13 * eta.max(1.0), "{eta} {cos}");
                assert!(t.z < 0.0);
            }
        }
    }

    #[test]
    fn a_conductor_without_absorption_is_a_dielectric() {
        for cos in angles() {
            assert!((conductor(cos, 1.5, 0.0) - dielectric(cos, 1.5).reflectance).abs() < 1e-14);
        }
        let normal: f64 = conductor(1.0, 0.2, 3.0);
        assert!((normal - (0.8f64.powi(2) + 9.0) / (1.2f64.powi(2) + 9.0)).abs() < 1e-14);
    }

    #[test]
    fn schlick_meets_the_exact_value_at_normal_incidence_and_at_the_critical_angle() {
        assert!((schlick(1.0, 1.5).reflectance - 0.04).abs() < 1e-16);
        let critical = (1.0f64 - 1.0 / 2.25).sqrt();
        assert!(schlick(critical + 1e-12, 1.0 / 1.5).reflectance > 0.999);
        assert_eq!(schlick(critical - 1e-9, 1.0 / 1.5).reflectance, 1.0);
    }

    #[test]
    fn schlick_is_a_fifth_power_of_the_cosine_in_the_thinner_medium() {
        // 0.04 + 0.96/2⁵ at 60°, from either side.
        let inside = (1.0f64 - 0.75 / 2.25).sqrt();
        for (cos, eta) in [(0.5, 1.5), (inside, 1.0 / 1.5)] {
            assert!((schlick(cos, eta).reflectance - 0.07).abs() < 1e-15, "{cos} {eta}");
        }
    }

    #[test]
    fn diffuse_reflectance_meets_published_values() {
        // Egan & Hilgeman's fit is Mitsuba's source; Walsh's closed form gives 0.09178 at 1.5.
        assert!((diffuse_reflectance(1.5) - 0.091_781).abs() < 2e-5);
        // F(1/η) = 1 − (1 − F(η))/η².
        for eta in [1.1, 1.33, 1.5, 2.4] {
            let inside = 1.0 - (1.0 - diffuse_reflectance(eta)) / (eta * eta);
            assert!((diffuse_reflectance(1.0 / eta) - inside).abs() < 1e-7, "{eta}");
        }
    }
}
