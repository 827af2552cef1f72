//! Directional transmittance and diffuse reflectance of a rough dielectric interface, by numerical
//! integration over the facets that a direction sees.

use super::fresnel;
use super::microfacet::{Distribution, reflect};
use crate::math::quadrature::gauss_legendre;
use crate::math::{DVec2, DVec3};

/// Directions at which Mitsuba tabulates: cos θ = 0, 1/63, …, 1. What is between is part of the model's
/// definition.
const DIRECTIONS: usize = 64;

/// Share of the light from a direction that gets into the material, for cos θ from 0 to 1.
pub struct Transmittance([f64; DIRECTIONS]);

impl Transmittance {
    /// The transmittance of an interface with `eta` = η far / η near.
    pub fn new(facets: &Distribution, eta: f64) -> Self {
        let rule = gauss_legendre(32);
        Self(directions().map(|wo| {
            over_facets(facets, wo, &rule, |m| {
                let cos = wo.dot(m);
                let wi = fresnel::refract(wo, m, cos, eta).filter(|wi| wi.z < 0.0);
                wi.map_or(0.0, |wi| facets.masking(wi, m) * fresnel::dielectric(cos, eta).transmittance)
            })
        }))
    }

    /// Linear between the tabulated directions.
    #[inline]
    pub fn at(&self, cos: f64) -> f64 {
        let x = cos * (DIRECTIONS - 1) as f64;
        let i = (x as usize).min(DIRECTIONS - 2);
        let t = x - i as f64;
        self.0[i] * (1.0 - t) + self.0[i + 1] * t
    }
}

/// Reflectance for diffuse light, 2∫R(c)c dc, as the mean over the tabulated directions that Mitsuba takes.
pub fn internal_reflectance(facets: &Distribution, eta: f64) -> f64 {
    // Finer, for the kink at the critical angle.
    let rule = gauss_legendre(48);
    let weighted = directions().map(|wo| {
        let reflected = over_facets(facets, wo, &rule, |m| {
            let wi = reflect(wo, m);
            if wi.z <= 0.0 {
                0.0
            } else {
                facets.masking(wi, m) * fresnel::dielectric(wo.dot(m), eta).reflectance
            }
        });
        reflected * wo.z
    });
    weighted.iter().sum::<f64>() * 2.0 / DIRECTIONS as f64
}

fn directions() -> [DVec3; DIRECTIONS] {
    std::array::from_fn(|i| {
        // At cos θ = 0 nothing is seen; Mitsuba takes this angle instead.
        let z = (i as f64 / (DIRECTIONS - 1) as f64).max(1e-6);
        DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z)
    })
}

/// The mean of `f` over the facets that `wo`, in the plane y = 0, sees. `f` must be even in y: facets come in
/// mirrored pairs, u.y and 1 − u.y, of which one is evaluated.
fn over_facets(facets: &Distribution, wo: DVec3, rule: &[(f64, f64)], f: impl Fn(DVec3) -> f64) -> f64 {
    let one_side = &rule[rule.len() / 2..];
    let row = |x: f64| {
        one_side.iter().map(|&(y, weight)| 2.0 * weight * f(facets.sample(wo, DVec2::new(x, y)))).sum::<f64>()
    };
    rule.iter().map(|&(x, weight)| weight * row(x)).sum()
}

#[cfg(test)]
mod tests {
    use super::super::microfacet::Shape;
    use super::*;

    #[test]
    fn a_nearly_smooth_surface_is_smooth() {
        for shape in [Shape::Beckmann, Shape::Ggx] {
            let facets = Distribution::new(shape, 1e-4, 1e-4);
            let table = Transmittance::new(&facets, 1.5);
            for i in 8..64 {
                let cos = i as f64 / 63.0;
                let smooth = fresnel::dielectric(cos, 1.5).transmittance;
                assert!((table.at(cos) - smooth).abs() < 2e-5, "{shape:?} {cos}");
            }
        }
    }

    /// The numbers are those of 512 nodes.
    #[test]
    fn known_values() {
        for (shape, alpha, at_half, inside) in
            [(Shape::Beckmann, 0.1, 0.910688, 0.574913), (Shape::Ggx, 0.5, 0.840856, 0.284930)]
        {
            let facets = Distribution::new(shape, alpha, alpha);
            assert!((Transmittance::new(&facets, 1.49).at(0.5) - at_half).abs() < 2e-4);
            assert!((internal_reflectance(&facets, 1.0 / 1.49) - inside).abs() < 2e-4);
        }
    }
}
