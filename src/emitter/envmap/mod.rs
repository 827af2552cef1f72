//! Light from an image that surrounds the scene.

mod directions;
mod normals;
mod steps;

use super::{AnyEmitter, DirectSample, OF_EVEN_LIGHT, Radiance};
use crate::math::frame::unit;
use crate::math::function::{acos, turn};
use crate::math::simd::prefetch;
use crate::math::{DVec2, DVec3, INV_PI, Transform};
use crate::pages::Pages;
use crate::scene::error::SceneError;
use crate::scene::params::{EXPECTED_AMOUNT, MOST, Params};
use crate::shape::require_orthogonal;
use crate::spectrum::upsample::Sigmoid;
use crate::spectrum::{ColorMode, Spectrum, Wavelengths, observer};
use crate::texture::color_scale;
use bytemuck::{Pod, Zeroable};
pub use directions::MapPlace;
use directions::{Cell, Corners, Directions};

pub const NAME: &str = "envmap";
pub const ABOUT: &str =
    "A latitude–longitude image around the scene; +y is up, the centre of the image lies towards +z.";
pub const EXAMPLES: &[&str] = &[];

/// Fraction of its brightness with which an image is sampled where it is darker than its mean.
const DARK: f64 = 1.0 / 32.0;

/// Everything about a texel in one place, for a lookup waits for memory.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(16))]
struct Texel {
    /// Coefficients of a [`Sigmoid`], or R, G and B.
    color: [f32; 3],
    /// Twice the largest of R, G and B: what the sigmoid is multiplied by, and the brightness.
    scale: f32,
}

/// Texel centres are at the middle of columns and at the ends of rows (the first and last row are the poles),
/// as in Mitsuba; between them all is bilinear.
#[derive(Debug)]
pub struct EnvironmentMap {
    texels: Pages<Texel>,
    width: usize,
    scale: f32,
    to_local: Transform,
    to_world: Transform,
    directions: Directions,
    /// Mean brightness, which importances leave out; see [`importance`].
    common: f64,
    /// Mean radiance over all directions that is sought by emitter samples, as luminance.
    sought: f64,
}

/// Most texels along a side: a block of [`directions`] then has fewer cells along a side than a choice has
/// steps.
const MOST_TEXELS: usize = 1 << 16;

pub fn parse(params: &mut Params) -> Result<AnyEmitter, SceneError> {
    let found = params.file("filename", "an EXR, HDR, PNG or JPEG file")?;
    let scale = params.amount("scale", 1.0, "factor")?;
    let to_world = params.transform("to_world", "turns the image")?;
    params.boolean("mis_compensation", true, "Mitsuba's sampling option; ignored, for it is always on")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "an envmap needs a `filename`", "add one"))?;
    // A density per solid angle of the image would be another one in the world.
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    require_orthogonal(params, axes, &[(0, 1), (1, 2)])?;
    let to_world = Transform::of_axes(axes).unwrap_or(to_world);
    let pixels = params.loader.bitmap(&path, place)?;
    if pixels.width < 2 || pixels.height < 3 {
        return Err(params.error("filename", "the image is too small", "expected at least 2 × 3 texels"));
    }
    if pixels.width.max(pixels.height) > MOST_TEXELS {
        let expected = format!("expected at most {MOST_TEXELS} texels along a side");
        return Err(params.error("filename", "the image is too large", expected));
    }
    let rgb: Vec<[f32; 3]> = (0..pixels.width * pixels.height).map(|i| pixels.linear(i, false)).collect();
    if let Some(i) = rgb.iter().position(|c| c.iter().any(|v| !(0.0..=MOST).contains(&f64::from(*v)))) {
        let message = format!("the texel ({}, {}) is {:?}", i % pixels.width, i / pixels.width, rgb[i]);
        return Err(params.error("filename", message, EXPECTED_AMOUNT));
    }
    let texel = |rgb: &[f32; 3]| {
        let (scale, color) = color_scale(rgb.map(f64::from));
        match params.loader.mode {
            ColorMode::Rgb => Texel { color: *rgb, scale },
            ColorMode::Spectral => Texel { color: params.loader.upsampler.fit(color).0, scale },
        }
    };
    let mut texels = Pages::zeroed(rgb.len());
    texels.iter_mut().zip(&rgb).for_each(|(place, rgb)| *place = texel(rgb));
    let (width, rows) = (pixels.width, pixels.height - 1);
    let common = mean(width, texels.iter().map(|texel| f64::from(texel.scale)));
    let directions = Directions::new(width, rows, |cell| importances(&corners(&texels, width, cell), common));
    let luminance = mean(width, rgb.iter().map(|c| observer::luminance(c.map(f64::from))));
    let important = mean(width, texels.iter().map(|texel| importance(texel, common)));
    let uneven = if common > 0.0 { important / common } else { 0.0 };
    let sought = scale * luminance * (uneven + OF_EVEN_LIGHT * (1.0 - uneven));
    let scale = scale as f32;
    let (to_local, to_world) = (to_world.inverted(), to_world);
    let map = EnvironmentMap { texels, width, scale, to_local, to_world, directions, common, sought };
    Ok(AnyEmitter::Envmap(Box::new(map)))
}

/// The mean over all directions of what is bilinear between texels.
fn mean(width: usize, values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    let sums: Vec<f64> = values.chunks(width).map(|row| row.iter().sum()).collect();
    let rows = sums.len() - 1;
    let of_cells = |row: usize| 0.5 * (sums[row] + sums[row + 1]) * directions::strip(row, rows).0;
    (0..rows).map(of_cells).sum::<f64>() / (2.0 * width as f64)
}

impl EnvironmentMap {
    /// A direction from which a surface of normal `n` (world, zero for none) may be lit.
    pub fn sample(&self, n: DVec3, u: DVec2) -> Option<DirectSample> {
        let (place, pdf) = self.directions.sample(self.to_local.vector(n), u, self.importances())?;
        let (turn, height) = self.directions.turn_and_height(&place);
        (pdf > 0.0).then(|| {
            self.prefetch_texels(place.cell);
            DirectSample {
                wi: unit(self.to_world.vector(directions::direction(turn, height))),
                distance: f64::INFINITY,
                radiance: Radiance::Mapped(place),
                pdf,
                delta: false,
                n: DVec3::ZERO,
            }
        })
    }

    /// The place in direction ω (unit, world); what is there is prefetched.
    pub fn place(&self, w: DVec3) -> MapPlace {
        let w = unit(self.to_local.vector(w));
        let half_turns = INV_PI * acos(w.y.clamp(-1.0, 1.0));
        let place = self.directions.place(turn(w.x, -w.z), half_turns, w.y);
        self.prefetch_texels(place.cell);
        self.directions.prefetch(place.cell);
        place
    }

    /// The density with which a place is sampled for a surface of normal `n`, in sr⁻¹.
    pub fn pdf(&self, n: DVec3, place: &MapPlace) -> f64 {
        self.directions.pdf(self.to_local.vector(n), place, self.importances())
    }

    fn importances(&self) -> impl Fn(Cell) -> Corners {
        |cell| importances(&self.corners(cell), self.common)
    }

    fn corners(&self, cell: Cell) -> [[Texel; 2]; 2] {
        corners(&self.texels, self.width, cell)
    }

    fn prefetch_texels(&self, cell: Cell) {
        corner_numbers(self.width, cell)
            .as_flattened()
            .iter()
            .for_each(|number| prefetch(&self.texels, *number));
    }

    /// The radiance of a place, bilinear between the centres of texels.
    pub fn radiance(&self, place: &MapPlace, λ: &Wavelengths) -> Spectrum {
        let corners = self.corners(place.cell);
        let (_, height) = self.directions.turn_and_height(place);
        let half_turns = INV_PI * acos(height.clamp(-1.0, 1.0));
        let rows = (self.texels.len() / self.width - 1) as f64;
        let x = place.across as f32;
        let y = (half_turns * rows - place.cell.row as f64).clamp(0.0, 1.0) as f32;
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        // Mitsuba interpolates shape and scale of the upsampled spectra apart.
        let (mut shape, mut scale) = (Spectrum::ZERO, 0.0);
        for (texel, weight) in corners.as_flattened().iter().zip(weights) {
            scale += texel.scale * weight;
            let [r, g, b] = texel.color;
            let here = match λ.mode() {
                ColorMode::Rgb => [r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0],
                ColorMode::Spectral => Sigmoid(texel.color).eval_lanes(&λ.nm),
            };
            shape += Spectrum(here) * weight;
        }
        match λ.mode() {
            ColorMode::Rgb => shape * self.scale,
            ColorMode::Spectral => shape * Spectrum(λ.d65) * (scale * self.scale),
        }
    }

    /// The part of its mean radiance that is sought by emitter samples.
    pub fn sought(&self) -> f64 {
        self.sought
    }
}

/// The texels at the corners of a cell: of the row above, left and right, and of the row below.
fn corners(texels: &[Texel], width: usize, cell: Cell) -> [[Texel; 2]; 2] {
    corner_numbers(width, cell).map(|row| row.map(|number| texels[number]))
}

fn corner_numbers(width: usize, cell: Cell) -> [[usize; 2]; 2] {
    let right = if cell.column + 1 < width { cell.column + 1 } else { 0 };
    [cell.row, cell.row + 1].map(|row| [row * width + cell.column, row * width + right])
}

/// The importance by which directions are sampled: the brightness beyond the mean, for scattering finds the
/// rest as well (Karlík et al. 2019, "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance
/// Sampling"); and a fraction of the brightness everywhere, for no light may be left out where directions are
/// sampled in no other way.
fn importance(texel: &Texel, common: f64) -> f64 {
    let brightness = f64::from(texel.scale);
    (brightness - common).max(DARK * brightness)
}

fn importances(corners: &[[Texel; 2]; 2], common: f64) -> Corners {
    corners.map(|row| row.map(|texel| importance(&texel, common)))
}

#[cfg(test)]
mod tests {
    use crate::emitter::Radiance;
    use crate::load_text;
    use crate::math::{DVec2, DVec3};
    use crate::spectrum::{ColorMode, Wavelengths};

    /// Black texels are no light, and no error: all samples go to where there is some.
    #[test]
    fn a_map_may_be_black_in_places() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sky.png");
        let texel = |x: u32, y: u32| ::image::Rgb(if (x, y) == (2, 1) { [255; 3] } else { [0; 3] });
        ::image::RgbImage::from_fn(4, 3, texel).save(&path).unwrap();
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/>
            <emitter type="envmap"><string name="filename" value="{}"/></emitter></scene>"#,
            path.display()
        );
        let scene = load_text("scene.xml", &text, ColorMode::Spectral).unwrap();
        let emitter = &scene.emitters.list[scene.emitters.environment.expect("there is one")].emitter;
        let λ = Wavelengths::sample_visible(0.3);
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            let u = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / 8.0;
            let light = emitter.sample(None, DVec3::ZERO, DVec3::ZERO, u, &λ).expect("there is light");
            let Radiance::Mapped(place) = light.radiance else { panic!("it is looked up later") };
            let radiance = scene.emitters.mapped(&place, &λ);
            assert!(light.pdf > 0.0 && light.pdf.is_finite() && !radiance.is_zero(), "{u}: {light:?}");
        }
    }
}
