//! The same value everywhere.

use super::{AnyVolume, constant};
use crate::math::Transform;
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::SpectralFunction;

pub const NAME: &str = "constvolume";
pub const ABOUT: &str = "The same value everywhere.";
pub const EXAMPLES: &[&str] =
    &[r#"<volume type="constvolume"><rgb name="value" value="0.9, 0.8, 0.7"/></volume>"#];

/// The same value everywhere.
#[derive(Clone, Debug)]
pub struct Constant {
    pub value: SpectralFunction,
    /// From the unit cube to where a medium that is bounded by its density has this one.
    pub to_world: Transform,
}

pub fn parse(params: &mut Params) -> Result<AnyVolume, SceneError> {
    let texture = params.texture("value", 1.0, params.usage, "a colour or spectrum")?;
    let to_world = params.transform("to_world", "from the unit cube to the world")?;
    let value = constant(texture, params.element)?;
    Ok(AnyVolume::Constant(Box::new(Constant { value, to_world })))
}
