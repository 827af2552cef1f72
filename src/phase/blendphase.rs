//! A mixture of two phase functions, in a proportion that may vary in space.

use super::{AnyPhase, PHASES, Phase};
use crate::bsdf::rescale;
use crate::math::DVec3;
use crate::scene::error::SceneError;
use crate::scene::params::{Params, Usage};
use crate::scene::registry::construct;
use crate::volume::AnyVolume;

/// (1 − w) p₀ + w p₁.
#[derive(Clone, Debug)]
pub struct Blend {
    /// The share w of the second, a number at each place.
    weight: AnyVolume,
    nested: [Box<AnyPhase>; 2],
}

impl Phase for Blend {
    const NAME: &'static str = "blendphase";
    const ABOUT: &'static str = "A mixture of two phase functions.";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<phase type="blendphase"><float name="weight" value="0.3"/><phase type="rayleigh"/>
            <phase type="hg"><float name="g" value="0.6"/></phase></phase>"#,
        r#"<phase type="blendphase"><float name="weight" value="0"/><phase type="isotropic"/><phase type="hg"/></phase>"#,
        r#"<phase type="blendphase"><float name="weight" value="0.25"/>
            <phase type="blendphase"><float name="weight" value="0.75"/><phase type="hg"><float name="g" value="-0.5"/></phase>
            <phase type="tabphase"><string name="values" value="1, 0, 2"/></phase></phase><phase type="isotropic"/></phase>"#,
    ];

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let about = "share of the second, from 0 to 1, wherever light is scattered";
        let weight = AnyVolume::parameter(params, "weight", 0.5, Usage::Reflectance, about)?;
        if !weight.is_scalar() {
            let message = "the share of a phase function is no colour";
            return Err(params.error("weight", message, "expected a number or a volume of one channel"));
        }
        let [first, second] = params.objects("phase", "the two phase functions")[..] else {
            let message = "a blend of other than two phase functions";
            return Err(SceneError::at(&params.element.span, message, "expected two"));
        };
        let nested = |element| construct(PHASES, element, params.loader, Usage::Unbounded).map(Box::new);
        Ok(Self { weight, nested: [nested(first)?, nested(second)?] })
    }

    #[inline]
    fn density(&self, p: DVec3, cos: f64) -> f64 {
        let weight = self.weight.eval_scalar(p);
        let part = |index: usize, share: f64| {
            if share == 0.0 { 0.0 } else { share * self.nested[index].density(p, cos) }
        };
        part(0, 1.0 - weight) + part(1, weight)
    }

    #[inline]
    fn sample_cosine(&self, p: DVec3, part: f64, u: f64) -> f64 {
        let weight = self.weight.eval_scalar(p);
        if part < weight {
            self.nested[1].sample_cosine(p, rescale(part, 0.0, weight), u)
        } else {
            self.nested[0].sample_cosine(p, rescale(part, weight, 1.0), u)
        }
    }
}
