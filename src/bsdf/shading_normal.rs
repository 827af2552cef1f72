//! A material whose normal is not the surface's: what `normalmap` and `bumpmap` share.
//!
//! The nested material works in a frame about the perturbed normal. Where that makes a direction change
//! sides, or where neighbouring normals would cut a hard edge into the light, the surface's own frame
//! decides.

use super::{AnyMaterial, Bsdf, Evaluation, Lobe, Sample, Traits};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, Frame};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// The parameters that both adapters have.
pub struct Adapter {
    nested: Box<AnyMaterial>,
    flip_invalid: bool,
    shadowing: bool,
}

/// A nested material about another normal, at a point.
pub struct PerturbedBsdf<'a> {
    adapter: &'a Adapter,
    point: &'a SurfacePoint,
    λ: &'a Wavelengths,
    /// The surface's own frame, in whose coordinates directions arrive.
    surface: Frame,
    /// The perturbed normal, unit length, in the coordinates of `surface`.
    normal: DVec3,
}

impl Adapter {
    /// Reads the nested material, `flip_invalid_normals` and `use_shadowing_function`.
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "turn normals that face away from the direction of view about the surface's normal";
        let flip_invalid = params.boolean("flip_invalid_normals", true, about)?;
        let about = "soften the shadow's edge where the surface's normal turns away from the light";
        let shadowing = params.boolean("use_shadowing_function", true, about)?;
        Ok(Self { nested: Box::new(AnyMaterial::parse_nested(params)?), flip_invalid, shadowing })
    }

    /// The nested material about a normal in the coordinates of `surface`; where there is no such direction,
    /// about the surface's own.
    pub fn about<'a>(
        &'a self,
        normal: DVec3,
        surface: Frame,
        point: &'a SurfacePoint,
        λ: &'a Wavelengths,
    ) -> PerturbedBsdf<'a> {
        let length2 = normal.length_squared();
        let normal = if length2 > 0.0 && length2.is_finite() { unit(normal) } else { DVec3::Z };
        PerturbedBsdf { adapter: self, point, λ, surface, normal }
    }

    /// Traits of the nested material, with a relief, and always anisotropic, as the tangent is needed.
    pub fn traits(&self, textured: bool) -> Traits {
        self.nested.traits().or(Traits { anisotropic: true, textured, relief: true, ..Traits::default() })
    }
}

impl PerturbedBsdf<'_> {
    /// The normal that is seen from ωo. One that faces away is turned by half a turn about the surface's
    /// normal (Schüßler et al. 2017, "Microfacet-based Normal Mapping for Robust Monte Carlo Path Tracing").
    #[inline]
    fn normal_seen_from(&self, wo: DVec3) -> DVec3 {
        let n = self.normal;
        if self.adapter.flip_invalid && wo.z * wo.dot(n) <= 0.0 { DVec3::new(-n.x, -n.y, n.z) } else { n }
    }

    /// Calls `f` with the nested material and the frame, in the surface's coordinates, in which it works.
    #[inline]
    fn with_nested<T>(&self, normal: DVec3, f: impl FnOnce(&super::AnyBsdf, &Frame) -> T) -> T {
        let frame = Frame::along(normal, self.surface.to_local(self.point.dp_du));
        let point = SurfacePoint { ns: self.surface.to_world(normal), ..*self.point };
        f(&self.adapter.nested.at(&point, self.λ), &frame)
    }

    /// The share of light from ωi that neighbouring bumps let through: masking by a GGX surface that is as
    /// rough as the normal is inclined (Estevez et al. 2019, "A Microfacet-Based Shadowing Function to Solve
    /// the Bump Terminator Problem", Ray Tracing Gems, chapter 12): α² = min(tan²θₙ/8, 1), 2/(1 + √(1 + α²
    /// tan²θᵢ)).
    #[inline]
    fn shadowing(&self, normal: DVec3, wi: DVec3) -> f64 {
        if !self.adapter.shadowing {
            return 1.0;
        }
        let tan2 = |w: DVec3| (w.x * w.x + w.y * w.y) / (w.z * w.z);
        let alpha2 = (0.125 * tan2(normal)).min(1.0);
        2.0 / (1.0 + (1.0 + alpha2 * tan2(wi)).sqrt())
    }
}

impl Bsdf for PerturbedBsdf<'_> {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        self.with_nested(self.normal_seen_from(wo), |nested, frame| {
            let lobe = nested.lobe(frame.to_local(wo));
            Lobe { axis: frame.to_world(lobe.axis), ..lobe }
        })
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let normal = self.normal_seen_from(wo);
        let Evaluation { value, pdf } = self.with_nested(normal, |nested, frame| {
            let seen = frame.to_local(wi);
            // Above the bump and below the surface, or the other way round: light cannot have come from
            // there.
            if seen.z * wi.z > 0.0 { nested.evaluate(frame.to_local(wo), seen) } else { Evaluation::ZERO }
        });
        if value.is_zero() {
            return Evaluation { value, pdf };
        }
        Evaluation { value: value * self.shadowing(normal, wi) as f32, pdf }
    }

    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        let normal = self.normal_seen_from(wo);
        let passed = self.with_nested(normal, |nested, frame| {
            let seen = frame.to_local(wo);
            if seen.z * wo.z > 0.0 { nested.null_transmission(seen) } else { Spectrum::ZERO }
        });
        if passed.is_zero() { passed } else { passed * self.shadowing(normal, -wo) as f32 }
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        let normal = self.normal_seen_from(wo);
        let (sample, wi) = self.with_nested(normal, |nested, frame| {
            let sample = nested.sample(frame.to_local(wo), lobe, u)?;
            // Straight on is straight on, whatever the frame; rounding must not bend it.
            Some((sample, if sample.null { -wo } else { frame.to_world(sample.wi) }))
        })?;
        if sample.wi.z * wi.z <= 0.0 {
            return None;
        }
        Some(Sample { wi, weight: sample.weight * self.shadowing(normal, wi) as f32, ..sample })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::length;
    use crate::scene::loader::Loader;
    use crate::scene::params::Usage;
    use crate::scene::xml;
    use crate::spectrum::ColorMode;

    /// Calls `f` with a nested material about a normal, on a flat surface.
    fn with(nested: &str, settings: &str, normal: DVec3, f: impl FnOnce(PerturbedBsdf)) {
        let text = format!("<bsdf version=\"3.0.0\" type=\"normalmap\">{settings}{nested}</bsdf>");
        let document = xml::read_text("example", &text).unwrap();
        let loader = Loader::new(&document, ColorMode::Rgb).unwrap();
        let mut params = Params::new(&document.root, &loader, Usage::Reflectance).unwrap();
        let adapter = Adapter::parse(&mut params).unwrap();
        let (point, λ) = (SurfacePoint::flat(), Wavelengths::rgb());
        f(adapter.about(normal, point.frame(true), &point, &λ));
    }

    const MIRROR: &str = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
    const MATTE: &str = r#"<bsdf type="diffuse"><float name="reflectance" value="1"/></bsdf>"#;
    const AS_THEY_COME: &str = r#"<boolean name="flip_invalid_normals" value="false"/>
        <boolean name="use_shadowing_function" value="false"/>"#;
    const U: DVec2 = DVec2::new(0.3, 0.6);

    #[test]
    fn a_mirror_reflects_about_the_given_normal() {
        let n = unit(DVec3::new(0.3, -0.2, 1.0));
        with(MIRROR, AS_THEY_COME, n * 7.0, |bsdf| {
            let wo = unit(DVec3::new(-0.1, 0.4, 0.8));
            let sample = bsdf.sample(wo, 0.5, U).unwrap();
            assert!(length(sample.wi - (n * (2.0 * wo.dot(n)) - wo)) < 1e-15);
            assert_eq!(sample.weight.0[0], 1.0);
        });
    }

    #[test]
    fn what_would_pass_through_the_surface_is_lost() {
        // The mirror image of the direction lies above the bump and below the surface.
        let n = unit(DVec3::new(1.0, 0.0, 1.0));
        with(MIRROR, AS_THEY_COME, n, |bsdf| {
            let wo = unit(DVec3::new(-0.3, 0.0, 1.0));
            assert!((n * (2.0 * wo.dot(n)) - wo).z < 0.0);
            assert!(bsdf.sample(wo, 0.5, U).is_none());
        });
        with(MATTE, AS_THEY_COME, n, |bsdf| {
            let below = unit(DVec3::new(1.0, 0.0, -0.5));
            assert!(below.dot(n) > 0.0 && bsdf.evaluate(DVec3::Z, below).pdf == 0.0);
        });
    }

    #[test]
    fn normals_that_face_away_are_turned_about_the_surfaces() {
        let (n, turned) = (unit(DVec3::new(1.0, 0.5, 0.4)), unit(DVec3::new(-1.0, -0.5, 0.4)));
        let (wo, wi) = (unit(DVec3::new(-1.0, 0.0, 0.3)), unit(DVec3::new(-0.4, 0.1, 0.9)));
        assert!(wo.dot(n) < 0.0);
        with(MATTE, r#"<boolean name="use_shadowing_function" value="false"/>"#, n, |bsdf| {
            let pdf = bsdf.evaluate(wo, wi).pdf;
            assert!((pdf - turned.dot(wi) * crate::math::INV_PI).abs() < 1e-15, "{pdf}");
        });
        with(MATTE, AS_THEY_COME, n, |bsdf| assert_eq!(bsdf.evaluate(wo, wi).pdf, 0.0));
    }

    /// Values worked out by hand: tan²θₙ = 1/4 gives α² = 1/32; tan²θᵢ = 96 gives 2/(1 + √4) = 2/3; tan²θₙ ≥
    /// 8 is cut.
    #[test]
    fn shadowing_is_maskings_share() {
        let towards = |tan2: f64| unit(DVec3::new(-tan2.sqrt(), 0.0, 1.0));
        for (normal, wi, expected) in
            [(0.25, 96.0, 2.0 / 3.0), (0.0, 1e6, 1.0), (8.0, 3.0, 2.0 / 3.0), (80.0, 3.0, 2.0 / 3.0)]
        {
            with(MATTE, "", towards(normal), |bsdf| {
                assert!((bsdf.shadowing(towards(normal), towards(wi)) - expected).abs() < 1e-12);
            });
        }
    }

    #[test]
    fn without_a_normal_the_surface_has_its_own() {
        for normal in [DVec3::ZERO, DVec3::NAN] {
            with(MIRROR, "", normal, |bsdf| {
                let wo = unit(DVec3::new(0.4, 0.1, 0.5));
                assert!(length(bsdf.sample(wo, 0.5, U).unwrap().wi - super::super::mirror(wo)) < 1e-15);
            });
        }
    }
}
