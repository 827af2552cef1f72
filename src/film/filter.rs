//! Reconstruction filters.

use super::filter_sampler::BINS;
use crate::math::function::{exp, sin};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::scene::registry::Entry;
use std::f64::consts::PI;

/// A separable filter by its profile along one axis, in pixels from the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    Box,
    Tent {
        radius: f64,
    },
    /// Lowered so that it reaches zero at the radius.
    Gaussian {
        deviation: f64,
    },
    Mitchell {
        b: f64,
        c: f64,
    },
    CatmullRom,
    Lanczos {
        lobes: f64,
    },
}

macro_rules! filters {
    ($($name:literal, $about:literal, $parse:expr;)*) => {
        /// Every reconstruction filter.
        pub static FILTERS: &[Entry<Profile>] = &[$(Entry {
            name: $name,
            about: $about,
            examples: &[concat!(r#"<rfilter type=""#, $name, r#""/>"#)],
            parse: $parse,
        }),*];
    };
}
filters! {
    "box", "The pixel's own square.", |_| Ok(Profile::Box);
    "tent", "Linear interpolation.", |p| Ok(Profile::Tent { radius: width(p, "radius", 1.0, NARROWEST)? });
    "gaussian", "A Gaussian cut at four deviations; Mitsuba's default.",
        |p| Ok(Profile::Gaussian { deviation: width(p, "stddev", 0.5, NARROWEST / 4.0)? });
    "mitchell", "Mitchell & Netravali 1988, a compromise of blur and ringing.", |p| {
        let in_range = |v: f64| (-10.0..=10.0).contains(&v);
        let b = p.float_where("B", 1.0 / 3.0, "blur", "-10 to 10", in_range)?;
        Ok(Profile::Mitchell { b, c: p.float_where("C", 1.0 / 3.0, "ringing", "-10 to 10", in_range)? })
    };
    "catmullrom", "The cubic of Catmull & Rom 1974: sharp, rings.", |_| Ok(Profile::CatmullRom);
    "lanczos", "A windowed sinc: sharpest, rings most.", |p| {
        Ok(Profile::Lanczos { lobes: p.integer("lobes", 3, 1..=16, "lobes on each side")? as f64 })
    };
}

/// Smallest radius, in pixels: one bin. What is narrower is no more than the middle of its pixel.
const NARROWEST: f64 = 1.0 / BINS as f64;

fn width(params: &mut Params, name: &'static str, default: f64, least: f64) -> Result<f64, SceneError> {
    let expected = format!("{least} to 16");
    params.float_where(name, default, "in pixels", &expected, |v| (least..=16.0).contains(&v))
}

impl Profile {
    /// How far from its centre it reaches, in pixels.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { deviation } => 4.0 * deviation,
            Self::Mitchell { .. } | Self::CatmullRom => 2.0,
            Self::Lanczos { lobes } => lobes,
        }
    }

    /// The filter's value; it need not integrate to 1.
    pub fn eval(&self, x: f64) -> f64 {
        let x = x.abs();
        if x > self.radius() {
            return 0.0;
        }
        match *self {
            Self::Box => 1.0,
            Self::Tent { radius } => (1.0 - x / radius).max(0.0),
            Self::Gaussian { deviation } => {
                let g = |x: f64| exp(-x * x / (2.0 * deviation * deviation));
                (g(x) - g(4.0 * deviation)).max(0.0)
            }
            Self::Mitchell { b, c } => cubic(x, b, c),
            Self::CatmullRom => cubic(x, 0.0, 0.5),
            Self::Lanczos { lobes } => {
                if x == 0.0 {
                    return 1.0;
                }
                let (p, w) = (PI * x, PI * x / lobes);
                sin(p) * sin(w) / (p * w)
            }
        }
    }
}

/// The family of Mitchell & Netravali 1988, equation 8, times 6.
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let (x2, x3) = (x * x, x * x * x);
    if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x3 + (6.0 * b + 30.0 * c) * x2 + (-12.0 * b - 48.0 * c) * x + (8.0 * b + 24.0 * c)
    }
}

/// One of each kind.
#[cfg(test)]
pub const ALL: [Profile; 6] = [
    Profile::Box,
    Profile::Tent { radius: 1.0 },
    Profile::Gaussian { deviation: 0.5 },
    Profile::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 },
    Profile::CatmullRom,
    Profile::Lanczos { lobes: 3.0 },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_end_where_they_are_nothing() {
        for profile in ALL.into_iter().filter(|profile| *profile != Profile::Box) {
            let foot = profile.eval(profile.radius() * (1.0 - 1e-9));
            assert!(foot.abs() < 1e-7 * profile.eval(0.0), "{profile:?} {foot}");
        }
    }

    #[test]
    fn cubics_interpolate_where_they_should() {
        assert!(
            (Profile::CatmullRom.eval(0.0) - 6.0).abs() < 1e-12
                && Profile::CatmullRom.eval(1.0).abs() < 1e-12
        );
        assert!(Profile::Lanczos { lobes: 3.0 }.eval(2.0).abs() < 1e-15);
    }
}
