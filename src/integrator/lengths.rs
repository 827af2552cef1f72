//! How long paths may become.

use crate::scene::error::SceneError;
use crate::scene::params::Params;

/// What `path` and `volpath` have in common, with Mitsuba's meaning of each.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// Edges of the longest path: 1 sees emitters, 2 direct light, and so on.
    pub max_depth: u32,
    /// Edges before Russian roulette begins.
    pub rr_depth: u32,
    /// Emitters are not seen directly.
    pub hide_emitters: bool,
}

impl Default for Lengths {
    fn default() -> Self {
        Self { max_depth: u32::MAX, rr_depth: 5, hide_emitters: false }
    }
}

impl Lengths {
    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let usual = Self::default();
        let about = "edges of the longest path; −1 means no limit";
        let max_depth = params.integer("max_depth", -1, -1..=i64::from(u32::MAX), about)?;
        let max_depth = u32::try_from(max_depth).unwrap_or(usual.max_depth);
        let about = "edges before Russian roulette begins";
        let rr_depth = params.count("rr_depth", usual.rr_depth, 1..=u32::MAX, about)?;
        let about = "emitters are not seen directly";
        let hide_emitters = params.boolean("hide_emitters", usual.hide_emitters, about)?;
        Ok(Self { max_depth, rr_depth, hide_emitters })
    }
}
