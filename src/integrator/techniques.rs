//! What finds light besides the camera's own paths. A scene begins with every technique that its integrator
//! allows, and pilots keep those that pay; see [`crate::render::plan`].

use super::caustics::Caustics;
use super::guide::Guide;
use super::links::Links;
use super::path::reuse::LightSources;

/// The techniques that a scene is rendered by, each absent where it is not used.
#[derive(Debug, Default)]
pub struct Techniques {
    /// The light paths that find caustics.
    pub caustics: Option<Caustics>,
    /// The light paths that find sources for pixels that share what their paths find.
    pub light_sources: Option<LightSources>,
    /// The specular shapes by which emitters are sampled.
    pub links: Option<Links>,
    /// The directions in which links are searched for instead, where light paths have left photons.
    pub guide: Option<Guide>,
}

impl Techniques {
    /// Whether surfaces that gather light need to know the specular ones that bring it to them.
    pub fn seek_casters(&self) -> bool {
        self.caustics.is_some() || self.links.is_some() || self.guide.is_some()
    }

    /// Light paths that find caustics, for each sample number.
    pub fn light_paths(&self) -> u32 {
        self.caustics.as_ref().map_or(0, |caustics| caustics.paths)
    }
}
