//! Light from an image that surrounds the scene.

use super::{AnyEmitter, DirectSample};
use crate::math::frame::unit;
use crate::math::function::{acos, atan2, cos, sin_cos_turn};
use crate::math::{DVec2, DVec3, Discrete, INV_PI, Transform, warp};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spectrum::upsample::Sigmoid;
use crate::spectrum::{ColorMode, Spectrum, Wavelengths, observer};
use crate::texture::color_scale;
use std::f64::consts::PI;

pub const NAME: &str = "envmap";
pub const ABOUT: &str =
    "A latitude–longitude image around the scene; +y is up, the centre of the image lies towards −z.";
pub const EXAMPLES: &[&str] = &[];

/// A texel: a colour and its scale.
#[derive(Clone, Copy, Debug)]
enum Texel {
    Rgb([f32; 3]),
    Illuminant { scale: f32, color: Sigmoid },
}

/// Texel centres are at the middle of columns and at the ends of rows (the first and last row are the poles), as in
/// Mitsuba; between them all is bilinear.
#[derive(Debug)]
pub struct EnvironmentMap {
    texels: Vec<Texel>,
    width: usize,
    height: usize,
    scale: f32,
    to_local: Transform,
    to_world: Transform,
    /// Of the texels.
    luminance: Vec<f64>,
    /// Chooses a row of cells, then a cell in it. A cell lies between four texel centres, and within it the density is
    /// bilinear in the turn and the height, as the luminance nearly is.
    rows: Discrete,
    columns: Vec<Discrete>,
    mean: f64,
}

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let found = params.file("filename", "an EXR, HDR, PNG or JPEG file")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "an envmap needs a `filename`", "add one"))?;
    let scale = params.float_where("scale", 1.0, "factor", "no negative number", |v| v >= 0.0)?;
    let to_world = params.transform("to_world", "turns the image")?;
    params.boolean("mis_compensation", false, "Mitsuba's sampling option; ignored")?;
    let pixels = params.loader.bitmap(&path).map_err(|e| e.or_at(&place.value_span))?;
    if pixels.width < 2 || pixels.height < 3 {
        return Err(params.error("filename", "the image is too small", "expected at least 2 × 3 texels"));
    }
    let rgb: Vec<[f32; 3]> = (0..pixels.width * pixels.height).map(|i| pixels.linear(i, false)).collect();
    if let Some(i) = rgb.iter().position(|c| c.iter().any(|v| *v < 0.0)) {
        let message = format!("the texel ({}, {}) is negative", i % pixels.width, i / pixels.width);
        return Err(params.error("filename", message, ""));
    }
    let texel = |rgb: &[f32; 3]| match params.loader.mode {
        ColorMode::Rgb => Texel::Rgb(*rgb),
        ColorMode::Spectral => {
            let (scale, color) = color_scale(rgb.map(|v| v as f64));
            Texel::Illuminant { scale, color: params.loader.upsampler.fit(color) }
        }
    };
    let texels = rgb.iter().map(texel).collect();
    let luminance: Vec<f64> = rgb.iter().map(|c| observer::luminance(c.map(|v| v as f64))).collect();
    let map = EnvironmentMap::new(texels, &luminance, pixels.width, scale, to_world);
    Ok(AnyEmitter::Envmap(Box::new(map)))
}

impl EnvironmentMap {
    fn new(texels: Vec<Texel>, luminance: &[f64], width: usize, scale: f64, to_world: Transform) -> Self {
        let height = texels.len() / width;
        let weight = |row: usize, column: usize| {
            let corners = corners(luminance, width, (row, column));
            0.25 * corners.as_flattened().iter().sum::<f64>() * strip(row, height)
        };
        let columns: Vec<Discrete> =
            (0..height - 1).map(|row| Discrete::new((0..width).map(|column| weight(row, column)))).collect();
        let rows = Discrete::new(columns.iter().map(Discrete::total));
        let mean = rows.total() * scale / (2.0 * width as f64);
        let to_local = to_world.inverted();
        let (luminance, scale) = (luminance.to_vec(), scale as f32);
        Self { texels, width, height, scale, to_local, to_world, luminance, rows, columns, mean }
    }

    pub fn sample(&self, u: DVec2, λ: &Wavelengths) -> Option<DirectSample> {
        let (row, row_probability, v) = self.rows.sample(u.y);
        let (column, column_probability, across) = self.columns[row].sample(u.x);
        let [above, below] = corners(&self.luminance, self.width, (row, column));
        let across = warp::linear(across, above[0] + below[0], above[1] + below[1]);
        let v = warp::linear(v, lerp(above, across), lerp(below, across));
        let turn = (column as f64 + 0.5 + across) / self.width as f64;
        let turn = if turn < 1.0 { turn } else { turn - 1.0 };
        let top = cos(PI * row as f64 / (self.height - 1) as f64);
        let z = top - v * strip(row, self.height);
        let (sin, cos) = sin_cos_turn(turn);
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let wi = unit(self.to_world.vector(DVec3::new(r * sin, z, -r * cos)));
        let pdf = row_probability * column_probability * self.density((row, column), (across, v));
        let place = DVec2::new(turn, INV_PI * acos(z.clamp(-1.0, 1.0)));
        (pdf > 0.0).then(|| DirectSample {
            wi,
            distance: f64::INFINITY,
            radiance: self.eval(place, λ),
            pdf,
            delta: false,
            n: DVec3::ZERO,
        })
    }

    /// The density in sr⁻¹ within a cell, at parts of its width and of its height in z.
    fn density(&self, (row, column): (usize, usize), (across, v): (f64, f64)) -> f64 {
        let [above, below] = corners(&self.luminance, self.width, (row, column));
        let here = lerp([lerp(above, across), lerp(below, across)], v);
        let mean = 0.25 * (above[0] + above[1] + below[0] + below[1]);
        if mean > 0.0 { here / mean * self.cells_per_steradian(row) } else { 0.0 }
    }

    fn cells_per_steradian(&self, row: usize) -> f64 {
        self.width as f64 / (2.0 * PI * strip(row, self.height))
    }

    /// Radiance seen in direction ω (unit, world), and the density with which it is sampled.
    pub fn radiance(&self, w: DVec3, λ: &Wavelengths) -> (Spectrum, f64) {
        let w = unit(self.to_local.vector(w));
        let turn = 0.5 * INV_PI * atan2(w.x, -w.z);
        let turn = if turn < 0.0 { turn + 1.0 } else { turn };
        let place = DVec2::new(turn, INV_PI * acos(w.y.clamp(-1.0, 1.0)));
        let row = ((place.y * (self.height - 1) as f64) as usize).min(self.height - 2);
        let x = turn * self.width as f64 - 0.5;
        let x = if x < 0.0 { x + self.width as f64 } else { x };
        let column = (x as usize).min(self.width - 1);
        let top = cos(PI * row as f64 / (self.height - 1) as f64);
        let v = ((top - w.y) / strip(row, self.height)).clamp(0.0, 1.0);
        let probability = self.rows.probability(row) * self.columns[row].probability(column);
        let density = self.density((row, column), (x - column as f64, v));
        (self.eval(place, λ), probability * density)
    }

    /// The bilinear value at a turn about +y and a polar angle in half turns.
    fn eval(&self, place: DVec2, λ: &Wavelengths) -> Spectrum {
        let x = place.x * self.width as f64 - 0.5;
        let y = place.y.clamp(0.0, 1.0) * (self.height - 1) as f64;
        let row = (y as usize).min(self.height - 2);
        let (tx, ty) = ((x - x.floor()) as f32, (y - row as f64) as f32);
        let column = |dx: i64| (x.floor() as i64 + dx).rem_euclid(self.width as i64) as usize;
        let corners = [
            (self.texels[row * self.width + column(0)], (1.0 - tx) * (1.0 - ty)),
            (self.texels[row * self.width + column(1)], tx * (1.0 - ty)),
            (self.texels[(row + 1) * self.width + column(0)], (1.0 - tx) * ty),
            (self.texels[(row + 1) * self.width + column(1)], tx * ty),
        ];
        // Mitsuba interpolates shape and scale of the upsampled spectra apart.
        let (mut shape, mut scale) = (Spectrum::ZERO, 0.0);
        for (texel, weight) in corners {
            match texel {
                Texel::Rgb([r, g, b]) => shape += Spectrum([r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0]) * weight,
                Texel::Illuminant { scale: s, color } => {
                    shape += Spectrum(color.eval_lanes(&λ.nm)) * weight;
                    scale += s * weight;
                }
            }
        }
        match λ.mode() {
            ColorMode::Rgb => shape * self.scale,
            ColorMode::Spectral => shape * Spectrum(λ.d65) * (scale * self.scale),
        }
    }

    /// Mean radiance over all directions, as luminance.
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

/// The luminance at the corners of a cell: of the row above, left and right, and of the row below.
fn corners(luminance: &[f64], width: usize, (row, column): (usize, usize)) -> [[f64; 2]; 2] {
    let at = |row: usize, column: usize| luminance[row * width + column % width];
    [row, row + 1].map(|row| [at(row, column), at(row, column + 1)])
}

fn lerp([a, b]: [f64; 2], t: f64) -> f64 {
    a + t * (b - a)
}

/// cos of a strip's upper polar angle minus that of its lower: 2 sin(mid) sin(half), free of cancellation.
fn strip(row: usize, height: usize) -> f64 {
    let step = PI / (height - 1) as f64;
    2.0 * libm::sin((row as f64 + 0.5) * step) * libm::sin(0.5 * step)
}
