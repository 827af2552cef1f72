//! Where on a texture a point of a surface is.

use crate::math::{DVec2, DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::shape::Chart;
use std::sync::Arc;

/// The parameter `to_uv`, and the mesh that coordinates belong to if they are those of its [`Chart`].
#[derive(Clone, Debug)]
pub struct Placement {
    to_uv: Transform,
    chart: Option<Arc<Chart>>,
}

impl Placement {
    #[cfg(test)]
    pub fn new(to_uv: Transform) -> Self {
        Self { to_uv, chart: None }
    }

    pub fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let to_uv = params.transform("to_uv", "applied to the surface's uv")?;
        Ok(Self { to_uv, chart: params.loader.chart() })
    }

    /// The point of the texture at a surface's coordinates.
    #[inline(always)]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        let uv = match &self.chart {
            None => uv,
            Some(chart) => chart.uv(uv),
        };
        self.to_uv.point(DVec3::new(uv.x, uv.y, 0.0))
    }

    /// (∂/∂u, ∂/∂v) of what has the derivatives (dx, dy) on the texture; u and v are those of the file. With J
    /// the linear part of `to_uv` it is Jᵀ (dx, dy).
    pub fn gradient(&self, dx: f64, dy: f64) -> DVec2 {
        let (u, v) = (self.to_uv.vector(DVec3::X), self.to_uv.vector(DVec3::Y));
        DVec2::new(u.x * dx + u.y * dy, v.x * dx + v.y * dy)
    }
}
