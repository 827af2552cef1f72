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

    /// With x = 1 + g − 2gu and s = (1 − g²)/x the inverse is (1 + g² − s²)/(2g). Divided out, with x written as a sum,
    ///
    /// 1 − cos θ = (1 − g)² u (1 + g + x)/x², x = (1 − g) + 2g(1 − u),
    ///
    /// which is 2u where g is zero, and where g is near one has all digits of the small angles that it is about. Behind
    /// is forwards mirrored.
    #[inline]
    fn sample_cosine(&self, _p: DVec3, _part: f64, u: f64) -> f64 {
        let forward = self.g >= 0.0;
        let (towards, u) = (self.g.abs(), if forward { u } else { 1.0 - u });
        let spread = 1.0 - towards;
        let x = spread + 2.0 * towards * (1.0 - u);
        let turned = spread / x;
        let cos = 1.0 - turned * turned * u * (1.0 + towards + x);
        if forward { cos } else { -cos }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of light that is turned by less than an angle, in closed form, is the number that gives its cosine.
    #[test]
    fn next_to_all_goes_on_where_g_is_next_to_one() {
        for spread in [1e-3, 1e-6, 1e-9, 1e-12, 1.0 / (1u64 << 53) as f64] {
            for g in [1.0 - spread, spread - 1.0] {
                let phase = HenyeyGreenstein { g };
                for u in [1e-6, 0.1, 0.5, 0.9, 0.999_999] {
                    // u = (1 − g)/(2g) ((1 + g)/√(1 + g² − 2g cos θ) − 1) seen from the other end.
                    let way = if g > 0.0 { u } else { 1.0 - u };
                    let away = 1.0 - g.signum() * phase.sample_cosine(DVec3::ZERO, 0.0, u);
                    let root = (spread * spread + 2.0 * (1.0 - spread) * away).sqrt();
                    let found = 1.0 - spread / (2.0 * (1.0 - spread)) * ((2.0 - spread) / root - 1.0);
                    // A cosine near one has no more digits than this of what it lacks.
                    let lost = f64::EPSILON / (spread * spread + away);
                    assert!((found - way).abs() < 1e-9 + lost, "{g} {u}: {found} {way}");
                }
            }
        }
    }
}
