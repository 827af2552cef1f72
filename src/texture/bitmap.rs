//! Images on surfaces.

use super::{AnyTexture, Lookup, Placement};
use crate::image::Pixels;
use crate::math::{DVec2, DVec3};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::upsample::{Sigmoid, Upsampler};
use crate::spectrum::{Spectrum, Wavelengths, observer};
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};
use std::sync::Arc;

pub const NAME: &str = "bitmap";
pub const ABOUT: &str =
    "An image file (EXR, PNG, JPEG, HDR, BMP); in spectral mode each texel is a smooth reflectance.";
pub const EXAMPLES: &[&str] = &[];

/// The values of texels. A look at them waits for memory, so they are short.
#[derive(Debug)]
enum Texels {
    /// One number for all wavelengths: the luminance.
    Grey,
    /// Linear sRGB.
    Rgb(Vec<[f32; 3]>),
    /// The same of a file with eight bits a channel, and what each of their values is.
    Bytes(Vec<[u8; 3]>, Box<[f32; 256]>),
    /// Coefficients of reflectance spectra.
    Reflectance(Vec<Sigmoid>),
    /// Reflectance spectra and factors upon them, where some texels are beyond 1.
    Scaled(Vec<(f32, Sigmoid)>),
}

/// What textures of one file share, if they take its texels for the same.
#[derive(Debug)]
pub struct Stored {
    texels: Texels,
    /// Luminance of each texel, for textures that are used as numbers.
    scalar: Vec<f32>,
}

/// An image.
#[derive(Clone, Debug)]
pub struct Bitmap {
    stored: Arc<Stored>,
    width: usize,
    height: usize,
    lookup: Lookup,
    placement: Placement,
}

pub fn parse(params: &mut Params) -> Result<AnyTexture, SceneError> {
    let found = params.file("filename", "an EXR, PNG, JPEG, HDR or BMP file")?;
    let wraps = ["repeat", "mirror", "clamp"];
    let lookup = Lookup::parse(params, ["bilinear", "nearest"], wraps, "beyond the unit square")?;
    let raw = params.boolean("raw", false, "whether the values are numbers and not sRGB colours")?;
    let placement = Placement::parse(params)?;
    params.choice(
        "format",
        &["auto", "variant", "float16", "fp16", "uint8"],
        "Mitsuba's storage; ignored",
    )?;
    params.boolean("accel", true, "Mitsuba's hardware interpolation; ignored")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "a bitmap needs a `filename`", "add one"))?;
    let pixels = params.loader.bitmap(&path, place)?;
    let count = pixels.width * pixels.height;
    let texels = || (0..count).into_par_iter();
    let (allowed, expected) = params.usage.allowed();
    let strange = |i: &usize| !pixels.linear(*i, raw).iter().all(|v| allowed.contains(v));
    if let Some(i) = texels().find_first(strange) {
        let (x, y, values) = (i % pixels.width, i / pixels.width, pixels.linear(i, raw));
        let message = format!("texel ({x}, {y}) of {} is {values:?}", path.display());
        return Err(SceneError::at(&place.value_span, message, expected));
    }
    let numbers = params.usage.is_numbers(params.loader.mode);
    let upsampler = (!numbers).then_some(&*params.loader.upsampler);
    let stored = params.loader.texels((path, raw, numbers), || Stored::new(&pixels, raw, upsampler));
    let (width, height) = (pixels.width, pixels.height);
    Ok(AnyTexture::Bitmap(Box::new(Bitmap { stored, width, height, lookup, placement })))
}

impl Stored {
    /// Texels as spectra of the upsampler, or, without one, as linear sRGB.
    fn new(pixels: &Pixels, raw: bool, upsampler: Option<&Upsampler>) -> Self {
        let scalar = (0..pixels.width * pixels.height).into_par_iter().map(|i| {
            let rgb = pixels.linear(i, raw);
            if pixels.channels == 1 { rgb[0] } else { observer::luminance(rgb.map(|v| v as f64)) as f32 }
        });
        let scalar = scalar.collect();
        let texels = match upsampler {
            None if pixels.channels > 1 => Texels::rgb(pixels, raw),
            Some(upsampler) if pixels.channels > 1 && !raw => Texels::spectra(pixels, upsampler),
            _ => Texels::Grey,
        };
        Self { texels, scalar }
    }
}

impl Texels {
    /// Reflectances, as in Mitsuba, and beyond 1 in proportion.
    fn spectra(pixels: &Pixels, upsampler: &Upsampler) -> Self {
        let colors = || (0..pixels.width * pixels.height).into_par_iter().map(|i| pixels.linear(i, false));
        if colors().any(|rgb| rgb.iter().any(|v| *v > 1.0)) {
            Self::Scaled(colors().map(|rgb| upsampler.fit_in_proportion(rgb.map(f64::from))).collect())
        } else {
            Self::Reflectance(colors().map(|rgb| upsampler.fit(rgb)).collect())
        }
    }

    /// Linear sRGB, of three channels.
    fn rgb(pixels: &Pixels, raw: bool) -> Self {
        let byte = |value: f32| {
            let byte = (value * 255.0 + 0.5) as u8;
            (f32::from(byte) / 255.0 == value).then_some(byte)
        };
        let bytes = |texel: &[f32]| Some([byte(texel[0])?, byte(texel[1])?, byte(texel[2])?]);
        match pixels.values.par_chunks_exact(3).map(bytes).collect() {
            Some(texels) => {
                let decoded = |byte: usize| pixels.decoded(byte as f32 / 255.0, raw);
                Self::Bytes(texels, Box::new(std::array::from_fn(decoded)))
            }
            None => {
                let texels = (0..pixels.width * pixels.height).into_par_iter();
                Self::Rgb(texels.map(|i| pixels.linear(i, raw)).collect())
            }
        }
    }

    /// Linear sRGB of a texel; `None` of numbers and spectra.
    #[inline(always)]
    fn linear(&self, texel: usize) -> Option<[f32; 3]> {
        match self {
            Self::Rgb(values) => Some(values[texel]),
            Self::Bytes(texels, values) => Some(texels[texel].map(|byte| values[usize::from(byte)])),
            Self::Grey | Self::Reflectance(_) | Self::Scaled(_) => None,
        }
    }
}

impl Bitmap {
    /// See [`AnyTexture::aspect`].
    pub fn aspect(&self) -> f64 {
        self.width as f64 / self.height as f64
    }

    /// The four texels about a place, row by row, and how far it lies from the first towards the others.
    #[inline(always)]
    fn square(&self, uv: DVec2) -> ([usize; 4], f64, f64) {
        let p = self.placement.point(uv);
        let (columns, x) = self.lookup.between(p.x, self.width);
        let (rows, y) = self.lookup.between(p.y, self.height);
        let rows = rows.map(|row| row * self.width);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y): (usize, usize)| rows[y] + columns[x]);
        (corners, x, y)
    }

    /// The texels about a place and their weights.
    #[inline(always)]
    fn corners(&self, uv: DVec2) -> [(usize, f32); 4] {
        let ([a, b, c, d], x, y) = self.square(uv);
        let (tx, ty) = (x as f32, y as f32);
        [(a, (1.0 - tx) * (1.0 - ty)), (b, tx * (1.0 - ty)), (c, (1.0 - tx) * ty), (d, tx * ty)]
    }

    /// The value in each lane at texture coordinates `uv`.
    pub fn eval(&self, uv: DVec2, λ: &Wavelengths) -> Spectrum {
        let corners = self.corners(uv);
        match &self.stored.texels {
            Texels::Grey => Spectrum::splat(weighted(&corners, 0.0, |texel| self.stored.scalar[texel])),
            Texels::Rgb(_) | Texels::Bytes(..) => weighted(&corners, Spectrum::ZERO, |texel| {
                let [r, g, b] = self.stored.texels.linear(texel).unwrap_or_default();
                Spectrum([r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0])
            }),
            Texels::Reflectance(values) => {
                weighted(&corners, Spectrum::ZERO, |texel| Spectrum(values[texel].eval_lanes(&λ.nm)))
            }
            Texels::Scaled(values) => weighted(&corners, Spectrum::ZERO, |texel| {
                let (scale, color) = &values[texel];
                Spectrum(color.eval_lanes(&λ.nm)) * *scale
            }),
        }
    }

    /// The value at texture coordinates `uv` where one number is asked for: the luminance of colours.
    pub fn eval_scalar(&self, uv: DVec2) -> f64 {
        self.corners(uv).into_iter().map(|(texel, weight)| (self.stored.scalar[texel] * weight) as f64).sum()
    }

    /// The three channels as numbers; `None` unless there are three that were not turned into spectra.
    pub fn eval_vector(&self, uv: DVec2) -> Option<DVec3> {
        let weighted = |(texel, weight): (usize, f32)| {
            self.stored.texels.linear(texel).map(|rgb| DVec3::from(rgb.map(f64::from)) * weight as f64)
        };
        self.corners(uv).into_iter().map(weighted).sum()
    }

    /// (∂/∂u, ∂/∂v) of the interpolated luminance; 0 where texels are not interpolated.
    pub fn gradient(&self, uv: DVec2) -> DVec2 {
        if self.lookup.nearest {
            return DVec2::ZERO;
        }
        let (texels, x, y) = self.square(uv);
        let [a, b, c, d] = texels.map(|texel| self.stored.scalar[texel] as f64);
        let dx = ((b - a) * (1.0 - y) + (d - c) * y) * self.width as f64;
        let dy = ((c - a) * (1.0 - x) + (d - b) * x) * self.height as f64;
        self.placement.gradient(dx, dy)
    }

    /// The mean over the texture of what [`eval_scalar`](Self::eval_scalar) is there.
    pub fn mean(&self) -> f64 {
        let scalar = &self.stored.scalar;
        scalar.iter().map(|&v| v as f64).sum::<f64>() / scalar.len() as f64
    }
}

/// The weighted sum of the values of texels; one with weight 0 is not looked up.
#[inline(always)]
fn weighted<T: Mul<f32, Output = T> + AddAssign>(
    corners: &[(usize, f32); 4],
    mut sum: T,
    value: impl Fn(usize) -> T,
) -> T {
    for &(texel, weight) in corners {
        if weight != 0.0 {
            sum += value(texel) * weight;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::math::Transform;
    use crate::spectrum::ColorMode;

    /// Five by three texels of no pattern, under a map that turns and stretches.
    fn picture(nearest: bool) -> Bitmap {
        let scalar: Vec<f32> = (0..15).map(|i| ((i * i * 7) % 11) as f32 / 11.0).collect();
        let turn = Transform::rotate(DVec3::Z, 25.0).unwrap();
        let to_uv = Transform::scale(DVec3::new(2.0, 0.5, 1.0)).unwrap().after(&turn);
        let stored = Arc::new(Stored { texels: Texels::Grey, scalar });
        Bitmap {
            stored,
            width: 5,
            height: 3,
            lookup: Lookup::repeated(nearest),
            placement: Placement::new(to_uv),
        }
    }

    #[test]
    fn gradients_are_differences() {
        let bitmap = picture(false);
        /// Bilinear in between texels, so that central differences are exact there but for `f32` weights.
        const STEP: f64 = 1e-3;
        let mut compared = 0;
        for i in 0..400 {
            let uv = DVec2::new((i % 20) as f64 / 20.0 + 0.013, (i / 20) as f64 / 20.0 + 0.007);
            let around = [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|d| uv + d * STEP);
            if around.iter().any(|p| bitmap.square(*p).0 != bitmap.square(uv).0) {
                continue;
            }
            compared += 1;
            let [right, left, up, down] = around.map(|p| bitmap.eval_scalar(p));
            let differences = DVec2::new(right - left, up - down) / (2.0 * STEP);
            let gradient = bitmap.gradient(uv);
            // Values of size 1 in f32 over a step of 2e-3: 2⁻²⁴/1e-3 in each of four terms.
            assert!((gradient - differences).length() < 5e-4, "{uv}: {gradient} {differences}");
        }
        assert!(compared > 200, "{compared}");
        assert_eq!(picture(true).gradient(DVec2::new(0.3, 0.4)), DVec2::ZERO);
    }

    /// What stands by itself may be for any use: one that refuses its texels does so where it refers to it.
    #[test]
    fn heights_below_zero_may_stand_at_the_top() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("heights.exr");
        exr::prelude::write_rgb_file(&path, 2, 1, |x, _| (x as f32 - 0.5, 0.25f32, 0.0f32)).unwrap();
        let load = |material: &str, mode| {
            let file = path.display();
            let text = format!(
                r#"<scene version="3.0.0"><sensor type="perspective"/><texture type="bitmap" id="h"><string name="filename" value="{file}"/>
                <boolean name="raw" value="true"/></texture><bsdf {material}</bsdf></scene>"#
            );
            load_text("scene.xml", &text, mode).map(drop)
        };
        for mode in [ColorMode::Spectral, ColorMode::Rgb] {
            let bump = load(r#"type="bumpmap"><ref id="h"/><bsdf type="diffuse"/>"#, mode);
            assert!(bump.is_ok(), "{}", bump.unwrap_err());
            let matte = load(r#"type="diffuse"><ref name="reflectance" id="h"/>"#, mode).unwrap_err();
            assert!(matte.to_string().contains("expected 0 to 1"), "{matte}");
        }
    }

    #[test]
    fn bytes_hold_what_a_file_of_eight_bits_has() {
        for encoded in [false, true] {
            let pixels = |values: Vec<f32>| Pixels { width: 16, height: 16, channels: 3, values, encoded };
            let whole = pixels((0..768).map(|i| (i * 7 % 256) as f32 / 255.0).collect());
            // One value between two bytes, and one beyond the last.
            let finer = [0.5, 300.0 / 255.0].map(|other| {
                pixels(whole.values.iter().map(|v| if *v == 1.0 { other } else { *v }).collect())
            });
            for raw in [false, true] {
                let stored = Texels::rgb(&whole, raw);
                assert!(matches!(stored, Texels::Bytes(..)));
                assert!((0..256).all(|texel| stored.linear(texel) == Some(whole.linear(texel, raw))));
                for finer in &finer {
                    let stored = Texels::rgb(finer, raw);
                    assert!(matches!(stored, Texels::Rgb(_)));
                    assert!((0..256).all(|texel| stored.linear(texel) == Some(finer.linear(texel, raw))));
                }
            }
        }
    }

    #[test]
    fn only_three_channels_make_a_vector() {
        let mut bitmap = picture(true);
        assert!(bitmap.eval_vector(DVec2::ZERO).is_none());
        bitmap.placement = Placement::new(Transform::IDENTITY);
        let texels = Texels::Rgb((0..15).map(|i| [i as f32, 0.5, -(i as f32)]).collect());
        bitmap.stored = Arc::new(Stored { texels, scalar: vec![] });
        assert_eq!(bitmap.eval_vector(DVec2::new(0.5, 0.5)), Some(DVec3::new(7.0, 0.5, -7.0)));
    }
}
