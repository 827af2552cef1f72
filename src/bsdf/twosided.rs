//! Gives a one-sided material a back: the same again, or another.

use super::{AnyMaterial, Bsdf, Evaluation, Lobe, Material, Sample, Traits};
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};

/// A material on each side of a surface.
pub struct TwoSided {
    front: Box<AnyMaterial>,
    /// Absent where the back is like the front.
    back: Option<Box<AnyMaterial>>,
}

/// The two sides at a point.
pub struct TwoSidedBsdf<'a> {
    material: &'a TwoSided,
    point: &'a SurfacePoint,
    λ: &'a Wavelengths,
}

impl Material for TwoSided {
    const NAME: &'static str = "twosided";
    const ABOUT: &'static str = "An opaque sheet whose sides are two materials, or one and the same.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>"#,
        r#"<bsdf type="twosided">
            <bsdf type="diffuse"><rgb name="reflectance" value="0.9, 0.2, 0.1"/></bsdf>
            <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>
        </bsdf>"#,
        r#"<bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value="0.2"/></bsdf></bsdf>"#,
        r#"<bsdf type="twosided"><bsdf type="conductor"/></bsdf>"#,
    ];
    type Bsdf<'a> = TwoSidedBsdf<'a>;

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let allow = params.boolean(
            "allow_transmission",
            false,
            "let light through, although sides have no inside",
        )?;
        let elements = params.objects("bsdf", "the material of the front, and of the back if it differs");
        if let Some(third) = elements.get(2) {
            return Err(SceneError::at(&third.span, "a third <bsdf>", "expected one or two"));
        }
        let mut sides = vec![];
        for element in elements {
            let side = AnyMaterial::parse(element, params.loader)?;
            if side.traits().transmits && !allow {
                let message = format!("`{}` lets light through and cannot be made two-sided", side.name());
                return Err(SceneError::at(&element.span, message, "expected an opaque material"));
            }
            sides.push(Box::new(side));
        }
        let mut sides = sides.into_iter();
        match sides.next() {
            Some(front) => Ok(Self { front, back: sides.next() }),
            None => Err(params.lacks("bsdf", "expected one <bsdf> or two")),
        }
    }

    #[inline]
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> TwoSidedBsdf<'a> {
        TwoSidedBsdf { material: self, point, λ }
    }

    fn traits(&self) -> Traits {
        let both = self.back.iter().fold(self.front.traits(), |traits, back| traits.or(back.traits()));
        Traits { irreversible: both.transmits, ..both }
    }
}

impl TwoSided {
    /// The materials of the front and, where it differs, the back.
    pub fn into_sides(self) -> (AnyMaterial, Option<AnyMaterial>) {
        (*self.front, self.back.map(|back| *back))
    }

    /// The material that faces a direction at a height `z` above (or, negative, below) the surface.
    #[inline]
    fn facing(&self, z: f64) -> &AnyMaterial {
        match &self.back {
            Some(back) if z < 0.0 => back,
            _ => &self.front,
        }
    }
}

/// A direction as the side that faces `z` sees it.
#[inline]
fn from_side(z: f64, w: DVec3) -> DVec3 {
    if z < 0.0 { DVec3::new(w.x, w.y, -w.z) } else { w }
}

impl Bsdf for TwoSidedBsdf<'_> {
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        let lobe = self.material.facing(wo.z).at(self.point, self.λ).lobe(from_side(wo.z, wo));
        Lobe { axis: from_side(wo.z, lobe.axis), ..lobe }
    }

    #[inline]
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
        let side = self.material.facing(wo.z).at(self.point, self.λ);
        side.evaluate(from_side(wo.z, wo), from_side(wo.z, wi))
    }

    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        self.material.facing(wo.z).at(self.point, self.λ).null_transmission(from_side(wo.z, wo))
    }

    #[inline]
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
        let side = self.material.facing(wo.z).at(self.point, self.λ);
        let sample = side.sample(from_side(wo.z, wo), lobe, u)?;
        Some(Sample { wi: from_side(wo.z, sample.wi), ..sample })
    }
}
