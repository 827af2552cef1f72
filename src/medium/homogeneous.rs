//! A medium that is equally dense everywhere.

use super::{AnyExtinction, FlightNumbers, Shares, flight};
use crate::scene::error::SceneError;
use crate::scene::params::{MOST, Params, Usage};
use crate::spectrum::{SpectralFunction, Spectrum, Wavelengths};
use crate::volume::AnyVolume;

pub const NAME: &str = "homogeneous";
pub const ABOUT: &str = "A medium that is equally dense everywhere; its albedo may vary.";
pub const EXAMPLES: &[&str] = &[
    r#"<medium type="homogeneous"/>"#,
    r#"<medium type="homogeneous">
        <rgb name="albedo" value="0.99, 0.9, 0.96"/><rgb name="sigma_t" value="0.5, 0.25, 0.8"/>
        <float name="scale" value="3"/><phase type="hg"><float name="g" value="0.7"/></phase>
    </medium>"#,
    r#"<medium type="homogeneous"><float name="albedo" value="0"/></medium>"#,
    r#"<medium type="homogeneous">
        <float name="albedo" value="1"/><spectrum name="sigma_t" value="400:4, 700:0.5"/>
    </medium>"#,
    r#"<medium type="homogeneous"><float name="sigma_t" value="0"/></medium>"#,
];

/// A medium that is the same everywhere.
#[derive(Debug)]
pub struct Homogeneous {
    /// σₜ/`scale`.
    sigma_t: SpectralFunction,
    scale: f32,
}

pub fn parse(params: &mut Params) -> Result<AnyExtinction, SceneError> {
    let about = "extinction coefficient, per unit of length";
    let sigma_t = AnyVolume::parameter(params, "sigma_t", 1.0, Usage::Unbounded, about)?;
    let scale = params.amount("scale", 1.0, "factor of `sigma_t`")?;
    let sigma_t = sigma_t.constant().cloned().ok_or_else(|| {
        params.error("sigma_t", "the density varies", "expected a constant, or a `heterogeneous` medium")
    })?;
    if f64::from(sigma_t.bound()) * scale > MOST {
        return Err(params.error(
            "scale",
            "`sigma_t` × `scale` is too large",
            "expected a product up to 1.7e38",
        ));
    }
    Ok(AnyExtinction::Homogeneous(Homogeneous { sigma_t, scale: scale as f32 }))
}

impl Homogeneous {
    #[inline]
    fn extinction(&self, λ: &Wavelengths) -> Spectrum {
        self.sigma_t.eval(λ) * self.scale
    }

    /// The share of light that comes straight through, exp(−σₜ d).
    #[inline]
    pub fn transmittance(&self, length: f64, λ: &Wavelengths) -> Spectrum {
        passed(self.extinction(λ), length)
    }

    /// Where the path collides, if it does before `length`, and the ratio of σₜ exp(−σₜ t), or of what comes
    /// through, to the density with which it was drawn.
    pub fn fly(
        &self,
        length: f64,
        shares: Shares,
        λ: &Wavelengths,
        numbers: &mut FlightNumbers,
    ) -> (Option<f64>, Spectrum) {
        let extinction = self.extinction(λ);
        let (lane, u) = shares.choose(numbers.draw());
        let t = flight::optical_depth(u) / f64::from(extinction.0[lane]);
        let (collision, value) = if t < length {
            // Relative to the lane of the distance, whose own value cannot underflow.
            let density = passed(extinction, t);
            let relative = |i: usize| f64::from(extinction.0[i]) / f64::from(extinction.0[lane]);
            (Some(t), Spectrum::from_fn(|i| (relative(i) * f64::from(density.0[i])) as f32))
        } else {
            (None, passed(extinction, length))
        };
        (collision, value * (1.0 / shares.mean(value)))
    }
}

/// exp(−σ d), also where one of them is zero and the other infinite.
#[inline]
fn passed(extinction: Spectrum, length: f64) -> Spectrum {
    extinction.map(|rate| if rate == 0.0 { 0.0 } else { -(f64::from(rate) * length) as f32 }).exp()
}
