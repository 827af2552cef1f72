//! Henyey and Greenstein's phase function (1941, "Diffuse radiation in the galaxy", equation 2):
//!
//! p(cos θ) = (1 − g²) / (4π (1 + g² − 2g cos θ)^(3/2)), with mean cosine g.

use super::Phase;
use crate::math::{DVec3, INV_PI};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

/// Scattering forwards or backwards by one parameter.
#[derive(Clone, Copy, Debug)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl Phase for HenyeyGreenstein {
    const NAME: &'static str = "hg";
    const ABOUT: &'static str = "Henyey and Greenstein's phase function, from backward (−1) to forward (1).";
    const EXAMPLES: &'static [&'static str] = &[
        r#"<phase type="hg"/>"#,
        r#"<phase type="hg"><float name="g" value="-0.35"/></phase>"#,
        r#"<phase type="hg"><float name="g" value="0"/></phase>"#,
        r#"<phase type="hg"><float name="g" value="1e-9"/></phase>"#,
        r#"<phase type="hg"><float name="g" value="0.97"/></phase>"#,
    ];

    fn parse(params: &mut Params) -> Result<Self, SceneError> {
        let expected = "a number above −1 and below 1";
        let g = params.float_where("g", 0.8, "mean cosine", expected, |g| g.abs() < 1.0)?;
        Ok(Self { g })
    }

    #[inline]
    fn density(&self, _p: DVec3, cos: f64) -> f64 {
        // 1 + g² − 2g cos θ without cancellation where both are near one.
        let forward = if self.g > 0.0 { 1.0 - cos } else { 1.0 + cos };
        let towards = self.g.abs();
        let square = (1.0 - towards) * (1.0 - towards) + 2.0 * towards * forward;
        0.25 * INV_PI * (1.0 - towards) * (1.0 + towards) / (square * square.sqrt())
    }

    /// With v = 1 − 2u and s = (1 − g²)/(1 + gv) the inverse is (1 + g² − s²)/(2g). Divided out,
    ///
    /// cos θ = (2v(1 + g²) + g(v² + 3) + g³(v² − 1)) / (2(1 + gv)²),
    ///
    /// which is v where g is zero and loses nothing where it is small.
    #[inline]
    fn sample_cosine(&self, _p: DVec3, _part: f64, u: f64) -> f64 {
        let (g, v) = (self.g, 1.0 - 2.0 * u);
        let (g2, v2) = (g * g, v * v);
        let denominator = 1.0 + g * v;
        0.5 * (2.0 * v * (1.0 + g2) + g * (v2 + 3.0) + g * g2 * (v2 - 1.0)) / (denominator * denominator)
    }
}
