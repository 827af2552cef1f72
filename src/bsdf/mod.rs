//! How surfaces scatter light. Each file of this folder is a model: what a scene file declares (its
//! *material*, perhaps textured), and that at a point, with textures and spectra evaluated (its *BSDF*).
//!
//! *How to add one*: write `bsdf/<name>.rs` with a [`Material`] and its [`Bsdf`], and add its line to
//! `materials!`. The parser, error texts, `etalon plugins`, the contract tests and the comparison with
//! Mitsuba follow from it.

mod coat;
pub mod fresnel;
mod ior;
mod lobe;
mod metal;
pub mod microfacet;
mod roughness;
mod shading_normal;
mod sides;
mod slope;
mod tints;
mod transmittance;

#[cfg(test)]
mod contract;
#[cfg(test)]
mod prism;

use crate::math::{BELOW_ONE, DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
use crate::shape::SurfacePoint;
use crate::spectrum::{Spectrum, Wavelengths};
pub use lobe::Lobe;

/// A model as a scene file declares it.
pub trait Material: Sized {
    /// The `type` in scene files.
    const NAME: &'static str;
    /// What the model is, physically, in a sentence.
    const ABOUT: &'static str;
    /// Scene-file snippets that span the parameters.
    const EXAMPLES: &'static [&'static str];
    /// Snippets that absorb nothing, from either side.
    const WHITE: &'static [&'static str] = &[];
    /// Whether f(ω, ω′)/η² is symmetric. Where it is not, the model's documentation says why.
    const RECIPROCAL: bool = true;

    /// The model at a point.
    type Bsdf<'a>: Bsdf
    where
        Self: 'a;

    /// Reads its parameters from a scene file.
    ///
    /// # Errors
    /// If one has no such value, with its place.
    fn parse(params: &mut Params) -> Result<Self, SceneError>;

    /// Evaluates textures and spectra, once for each vertex of a path.
    fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> Self::Bsdf<'a>;

    /// What is known of it wherever it is, from its parameters.
    fn traits(&self) -> Traits;
}

/// What the rest of the renderer must know of a material wherever it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traits {
    /// Has a lobe of finite density, for which light sampling makes sense.
    pub has_density: bool,
    /// Needs the surface's tangent, not any frame about the normal.
    pub anisotropic: bool,
    /// A parameter varies over the surface.
    pub textured: bool,
    /// Refraction may separate the wavelengths.
    pub dispersive: bool,
    /// Samples do not depend on the number that chooses between lobes.
    pub one_lobe: bool,
    /// Only reflects, only through lobes with a density, about the normal it is given.
    pub only_rough: bool,
    /// Lets light through.
    pub transmits: bool,
    /// Lets some of it straight on, as if there were no surface.
    pub has_null: bool,
    /// Has a lobe that is narrow, but not without density.
    pub glossy: bool,
    /// Transmits light, and all of that leaves in one direction, the same for all wavelengths.
    pub refracts: bool,
    /// Reflects light, and all of that leaves in the mirror direction.
    pub mirrors: bool,
    /// Scatters about another normal than that of the frame it is given. Its shadowing depends on the
    /// direction to the light alone, so lobes without density are not the same from either end, and only
    /// camera paths can follow them.
    pub relief: bool,
    /// Its sides are materials of their own, and light goes from one to the other: a path is scattered by
    /// another material from its other end, so only camera paths can follow it.
    pub irreversible: bool,
}

impl Traits {
    /// Whether it is a caster: light from an emitter leaves it in few directions.
    pub fn is_caster(&self) -> bool {
        !self.irreversible && (self.glossy || !self.has_density && !self.relief)
    }

    /// Traits of a material made of both: `one_lobe`, `only_rough`, `refracts` and `mirrors` if both have
    /// them, the others if either has.
    pub fn or(self, other: Self) -> Self {
        Self {
            has_density: self.has_density || other.has_density,
            anisotropic: self.anisotropic || other.anisotropic,
            textured: self.textured || other.textured,
            dispersive: self.dispersive || other.dispersive,
            transmits: self.transmits || other.transmits,
            has_null: self.has_null || other.has_null,
            glossy: self.glossy || other.glossy,
            relief: self.relief || other.relief,
            irreversible: self.irreversible || other.irreversible,
            one_lobe: self.one_lobe && other.one_lobe,
            only_rough: self.only_rough && other.only_rough,
            refracts: self.refracts && other.refracts,
            mirrors: self.mirrors && other.mirrors,
        }
    }
}

/// The value and density of the lobes of finite density, for one pair of directions.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// f(ωo, ωi)·|cos θi| in sr⁻¹, for radiance travelling from ωi to ωo.
    pub value: Spectrum,
    /// The density with which [`Bsdf::sample`] makes ωi, in sr⁻¹, all lobes together.
    pub pdf: f64,
}

impl Evaluation {
    pub const ZERO: Self = Self { value: Spectrum::ZERO, pdf: 0.0 };
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Sampled direction to where light comes from (local, unit length).
    pub wi: DVec3,
    /// f·|cos θi| / pdf, or the ratio of the delta coefficients.
    pub weight: Spectrum,
    /// Density of `wi` in sr⁻¹; for a delta lobe, the discrete probability of the lobe.
    pub pdf: f64,
    /// Whether the lobe has no density: that of a mirror, of a pane, or of no surface at all.
    pub delta: bool,
    /// Relative index of refraction that the path crossed, seen from ωo: 1 for reflection.
    pub eta: f64,
    /// The direction is that of lane 0 only; all other lanes end here (their weight is zero).
    pub dispersed: bool,
    /// The direction goes straight on as if there were no surface.
    pub null: bool,
}

impl Sample {
    /// A sample of a lobe with density, by reflection.
    #[inline]
    pub fn with_density(wi: DVec3, weight: Spectrum, pdf: f64) -> Self {
        Self { wi, weight, pdf, delta: false, eta: 1.0, dispersed: false, null: false }
    }

    /// A sample of a delta lobe, chosen with probability `probability`.
    #[inline]
    pub fn delta(wi: DVec3, weight: Spectrum, probability: f64, eta: f64) -> Self {
        Self { wi, weight, pdf: probability, delta: true, eta, dispersed: false, null: false }
    }

    /// Straight on, chosen with probability `probability`.
    #[inline]
    pub fn null(wo: DVec3, weight: Spectrum, probability: f64) -> Self {
        Self { null: true, ..Self::delta(-wo, weight, probability, 1.0) }
    }
}

/// A function of a material of any type: there is one `match`, and everything behind it is compiled for each
/// type by itself.
pub trait Visitor {
    type Output;

    fn visit<M: Material>(self, material: &M) -> Self::Output;
}

/// Scattering at a point, in the local frame whose z axis is the shading normal.
///
/// ωo points to where the light goes (the camera's side of a path), ωi to where it comes from.
pub trait Bsdf {
    /// The value and density of all lobes that have a density, for unit directions on either side of the surface.
    fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation;
    /// Draws ωi from three numbers in [0, 1): `lobe` chooses between lobes, `u` the direction in one.
    fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample>;

    /// The share of light from behind that goes straight on, as if there were no surface: the mean weight of
    /// [`Sample::null`] over all samples.
    #[inline]
    fn null_transmission(&self, wo: DVec3) -> Spectrum {
        let _ = wo;
        Spectrum::ZERO
    }

    /// ρ, if f = ρ/π for all directions above the surface, none comes through it, and samples follow the
    /// cosine.
    #[inline]
    fn albedo(&self) -> Option<Spectrum> {
        None
    }

    /// The directions (local) from which most of what goes to ωo is scattered, by which emitters are chosen.
    #[inline]
    fn lobe(&self, wo: DVec3) -> Lobe {
        let _ = wo;
        Lobe::NONE
    }
}

pub use diffuse::DiffuseBsdf;

macro_rules! materials {
    ($($module:ident::$Model:ident),* $(,)?) => {
        $(mod $module;)*

        /// Any material. Dispatch is a `match`, so every call can be inlined.
        pub enum AnyMaterial { $($Model($module::$Model)),* }

        /// Any BSDF at a point.
        pub enum AnyBsdf<'a> { $($Model(<$module::$Model as Material>::Bsdf<'a>)),* }

        impl AnyMaterial {
            #[inline]
            pub fn at<'a>(&'a self, point: &'a SurfacePoint, λ: &'a Wavelengths) -> AnyBsdf<'a> {
                match self { $(Self::$Model(material) => AnyBsdf::$Model(material.at(point, λ))),* }
            }

            #[inline(always)]
            pub fn visit<V: Visitor>(&self, visitor: V) -> V::Output {
                match self { $(Self::$Model(material) => visitor.visit(material)),* }
            }

            pub fn traits(&self) -> Traits {
                match self { $(Self::$Model(material) => material.traits()),* }
            }

            /// See [`Material::RECIPROCAL`].
            pub fn is_reciprocal(&self) -> bool {
                match self { $(Self::$Model(_) => <$module::$Model as Material>::RECIPROCAL),* }
            }

            pub fn name(&self) -> &'static str {
                match self { $(Self::$Model(_) => <$module::$Model as Material>::NAME),* }
            }
        }

        impl Bsdf for AnyBsdf<'_> {
            #[inline]
            fn evaluate(&self, wo: DVec3, wi: DVec3) -> Evaluation {
                match self { $(Self::$Model(bsdf) => bsdf.evaluate(wo, wi)),* }
            }

            #[inline]
            fn sample(&self, wo: DVec3, lobe: f64, u: DVec2) -> Option<Sample> {
                match self { $(Self::$Model(bsdf) => bsdf.sample(wo, lobe, u)),* }
            }

            #[inline]
            fn null_transmission(&self, wo: DVec3) -> Spectrum {
                match self { $(Self::$Model(bsdf) => bsdf.null_transmission(wo)),* }
            }

            #[inline]
            fn albedo(&self) -> Option<Spectrum> {
                match self { $(Self::$Model(bsdf) => bsdf.albedo()),* }
            }

            #[inline]
            fn lobe(&self, wo: DVec3) -> Lobe {
                match self { $(Self::$Model(bsdf) => bsdf.lobe(wo)),* }
            }
        }

        /// Every material.
        pub static MATERIALS: &[Entry<AnyMaterial>] = &[$(Entry {
            name: <$module::$Model as Material>::NAME,
            about: <$module::$Model as Material>::ABOUT,
            examples: <$module::$Model as Material>::EXAMPLES,
            parse: |params| <$module::$Model as Material>::parse(params).map(AnyMaterial::$Model),
        }),*];

        /// The names of all materials, and their snippets that absorb nothing.
        pub static WHITE: &[(&str, &[&str])] =
            &[$((<$module::$Model as Material>::NAME, <$module::$Model as Material>::WHITE)),*];
    };
}

materials! {
    diffuse::Diffuse,
    conductor::Conductor,
    roughconductor::RoughConductor,
    dielectric::Dielectric,
    thindielectric::ThinDielectric,
    roughdielectric::RoughDielectric,
    plastic::Plastic,
    roughplastic::RoughPlastic,
    principled::Principled,
    principledthin::PrincipledThin,
    null::Null,
    twosided::TwoSided,
    mask::Mask,
    blendbsdf::Blend,
    normalmap::NormalMap,
    bumpmap::BumpMap,
}

pub use twosided::TwoSided;

impl AnyMaterial {
    /// A matte material of one reflectance, for surfaces to which the file gives none.
    pub fn matte(reflectance: f64) -> Self {
        Self::Diffuse(diffuse::Diffuse::matte(reflectance))
    }

    /// Reads a `<bsdf>`.
    pub fn parse<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<Self, SceneError> {
        if element.tag != "bsdf" {
            let message = format!("expected a BSDF, not <{}>", element.tag);
            return Err(SceneError::at(&element.span, message, "expected <bsdf>"));
        }
        construct(MATERIALS, element, loader, Usage::Reflectance)
    }

    /// Reads the single nested `<bsdf>` of an adapter.
    pub fn parse_nested(params: &mut Params) -> Result<Self, SceneError> {
        let element = params.object("bsdf", "the nested material")?;
        let element = element.ok_or_else(|| params.lacks("bsdf", "expected one <bsdf>"))?;
        Self::parse(element, params.loader)
    }
}

/// A number of [low, high) stretched to [0, 1), so that a nested choice can use it again.
#[inline]
pub fn rescale(lobe: f64, low: f64, high: f64) -> f64 {
    ((lobe - low) / (high - low)).min(BELOW_ONE)
}

/// ω mirrored at the normal.
#[inline]
pub fn mirror(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}
