//! Values on a grid, and straight lines between the middles of its cells.

use super::{AnyVolume, Voxels};
use crate::math::{DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::{EXPECTED_AMOUNT, MOST, Params, Usage};
use crate::spectrum::upsample::Sigmoid;
use crate::spectrum::{ColorMode, Spectrum, Wavelengths};
use crate::texture::{Lookup, color_scale};

pub const NAME: &str = "gridvolume";
pub const ABOUT: &str = "Values on a grid, from a file: numbers, or sRGB colours.";
pub const EXAMPLES: &[&str] = &[];

/// The values of the cells, x fastest.
#[derive(Clone, Debug)]
enum Cells {
    /// One number for all wavelengths.
    Grey(Vec<f32>),
    /// Linear sRGB.
    Rgb(Vec<[f32; 3]>),
    /// Spectra made from RGB, each with what it is multiplied by.
    Spectral(Vec<(Sigmoid, f32)>),
}

/// Values on a grid, and between its cells' centres by interpolation.
#[derive(Clone, Debug)]
pub struct Grid {
    cells: Cells,
    size: [usize; 3],
    lookup: Lookup,
    /// From the unit cube, which the grid fills.
    to_world: Transform,
}

/// Of the cells about a point: the first along each axis, the next, and how far it is towards the next.
struct Between {
    cells: [[usize; 2]; 3],
    weights: [f64; 3],
}

pub fn parse(params: &mut Params) -> Result<AnyVolume, SceneError> {
    let found = params.file("filename", "a .vol file")?;
    let wraps = ["clamp", "repeat", "mirror"];
    let lookup = Lookup::parse(params, ["trilinear", "nearest"], wraps, "beyond the grid")?;
    let own_box = params.boolean("use_grid_bbox", false, "the grid fills the box that the file names")?;
    let to_world = params.transform("to_world", "from the unit cube, or the file's box, to the world")?;
    let raw = params.boolean("raw", false, "whether three channels are numbers and not sRGB colours")?;
    params.boolean("accel", true, "Mitsuba's hardware interpolation; ignored")?;
    params.optional_float("max_value", "Mitsuba's; ignored, for the values are looked at")?;
    let (path, place) =
        found.ok_or_else(|| params.error("filename", "a gridvolume needs a `filename`", "add one"))?;
    let voxels = params.loader.voxels(&path, place)?;
    if raw && voxels.channels == 3 && params.loader.mode == ColorMode::Spectral {
        let message = "three channels that are no colour";
        return Err(params.error("raw", message, "expected one channel, no `raw`, or RGB mode"));
    }
    let (top, expected) = match params.usage {
        Usage::Reflectance => (1.0, "expected 0 to 1"),
        _ => (MOST, EXPECTED_AMOUNT),
    };
    if let Some(i) = voxels.values.iter().position(|v| !(0.0..=top).contains(&f64::from(*v))) {
        let (cell, value) = (i / voxels.channels, voxels.values[i]);
        let [x, y, _] = voxels.size;
        let (i, j, k) = (cell % x, cell / x % y, cell / (x * y));
        let message = format!("cell ({i}, {j}, {k}) of {} is {value}", path.display());
        return Err(SceneError::at(&place.value_span, message, expected));
    }
    let fills = match own_box {
        false => Transform::IDENTITY,
        true => {
            let (lo, hi) = voxels.bounds;
            let scale = Transform::scale(hi - lo).filter(|_| (hi - lo).min_element() > 0.0);
            let scale = scale.ok_or_else(|| {
                params.error("use_grid_bbox", "the file's box is empty", "expected corners that differ")
            })?;
            Transform::translate(lo).after(&scale)
        }
    };
    let cells = cells(&voxels, params);
    let grid = Grid { cells, size: voxels.size, lookup, to_world: to_world.after(&fills) };
    Ok(AnyVolume::Grid(Box::new(grid)))
}

fn cells(voxels: &Voxels, params: &Params) -> Cells {
    let (colors, _) = voxels.values.as_chunks::<3>();
    match (voxels.channels, params.loader.mode) {
        (1, _) => Cells::Grey(voxels.values.clone()),
        (_, ColorMode::Rgb) => Cells::Rgb(colors.to_vec()),
        (_, ColorMode::Spectral) => {
            let spectrum = |rgb: &[f32; 3]| {
                // Spectra of amounts may exceed their largest component; what reflected so would make light of nothing.
                let (scale, color) = match params.usage {
                    Usage::Reflectance => (1.0, *rgb),
                    _ => color_scale(rgb.map(f64::from)),
                };
                (params.loader.upsampler.fit(color), scale)
            };
            Cells::Spectral(colors.iter().map(spectrum).collect())
        }
    }
}

impl Grid {
    /// From the cube [0, 1]³ of the grid to world space.
    pub fn to_world(&self) -> &Transform {
        &self.to_world
    }

    /// Numbers of cells along x, y and z.
    pub fn resolution(&self) -> [usize; 3] {
        self.size
    }

    /// Whether the cells have one number each, for all wavelengths.
    pub fn is_scalar(&self) -> bool {
        matches!(self.cells, Cells::Grey(_))
    }

    /// The value at a point (world).
    pub fn eval(&self, p: DVec3, λ: &Wavelengths) -> Spectrum {
        let between = self.between(self.to_world.inverse.transform_point3(p));
        match &self.cells {
            Cells::Grey(values) => Spectrum::splat(self.sum(&between, |i| f64::from(values[i])) as f32),
            Cells::Rgb(colors) => {
                let [r, g, b] = [0, 1, 2].map(|c| self.sum(&between, |i| f64::from(colors[i][c])) as f32);
                Spectrum([r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0])
            }
            // Mitsuba interpolates shape and scale of the upsampled spectra apart.
            Cells::Spectral(spectra) => {
                let scale = self.sum(&between, |i| f64::from(spectra[i].1));
                let mut shape = Spectrum::ZERO;
                self.each(&between, |i, weight| {
                    shape += Spectrum(spectra[i].0.eval_lanes(&λ.nm)) * weight as f32;
                });
                shape * scale as f32
            }
        }
    }

    /// No value in a box, in the coordinates of the unit cube, is above this.
    pub fn majorant(&self, lo: DVec3, hi: DVec3) -> f64 {
        // One cell more on either side is enough for any rounding and any filter.
        let range = |axis: usize| {
            let size = self.size[axis] as f64;
            let (first, last) = ((lo[axis] * size - 0.5).floor() - 1.0, (hi[axis] * size + 0.5).ceil() + 1.0);
            self.lookup.range(first, last, self.size[axis])
        };
        let mut most = 0.0f32;
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    most = most.max(self.largest((k * self.size[1] + j) * self.size[0] + i));
                }
            }
        }
        f64::from(most)
    }

    /// The largest value of a cell, or a bound of it.
    fn largest(&self, cell: usize) -> f32 {
        match &self.cells {
            Cells::Grey(values) => values[cell],
            Cells::Rgb(colors) => colors[cell].into_iter().fold(0.0, f32::max),
            // A sigmoid is never above one.
            Cells::Spectral(spectra) => spectra[cell].1,
        }
    }

    /// Where a point of the unit cube lies between cells.
    fn between(&self, p: DVec3) -> Between {
        let (mut cells, mut weights) = ([[0; 2]; 3], [0.0; 3]);
        for axis in 0..3 {
            (cells[axis], weights[axis]) = self.lookup.between(p[axis], self.size[axis]);
        }
        Between { cells, weights }
    }

    /// Calls `f` with the cells about a point and their weights, which sum to one.
    #[inline]
    fn each(&self, Between { cells, weights }: &Between, mut f: impl FnMut(usize, f64)) {
        for corner in 0..8 {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = |axis: usize| if side[axis] == 1 { weights[axis] } else { 1.0 - weights[axis] };
            let [i, j, k] = [0, 1, 2].map(|axis| cells[axis][side[axis]]);
            f((k * self.size[1] + j) * self.size[0] + i, weight(0) * weight(1) * weight(2));
        }
    }

    #[inline]
    fn sum(&self, between: &Between, value: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        self.each(between, |i, weight| sum += weight * value(i));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::loader::Loader;
    use crate::scene::xml;
    use crate::volume::file_of;

    /// The volume of a file of 3 × 2 × 4 cells, with these parameters; the error if it is refused.
    fn grid(channels: u32, parameters: &str, mode: ColorMode) -> Result<AnyVolume, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grid.vol");
        let values: Vec<f32> = (0..24 * channels).map(|i| (i * 7 % 24) as f32 / 23.0).collect();
        std::fs::write(&path, file_of([3, 2, 4], channels, &values)).unwrap();
        let file = format!(r#"<string name="filename" value="{}"/>"#, path.display());
        let text = format!(r#"<volume version="3.0.0" type="gridvolume">{file}{parameters}</volume>"#);
        let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
        let loader = Loader::new(&document, mode).map_err(|e| e.to_string())?;
        let mut params =
            Params::new(&document.root, &loader, Usage::Reflectance).map_err(|e| e.to_string())?;
        parse(&mut params).map_err(|e| e.to_string())
    }

    fn value(volume: &AnyVolume, p: [f64; 3]) -> f32 {
        volume.eval(DVec3::from(p), &Wavelengths::rgb()).0[0]
    }

    #[test]
    fn values_stand_in_the_middle_of_cells_and_lines_between_them() {
        let volume = grid(1, "", ColorMode::Rgb).unwrap();
        let cell = |i: u32, j: u32, k: u32| ((k * 2 + j) * 3 + i) * 7 % 24;
        let at = |i: f64, j: f64, k: f64| value(&volume, [(i + 0.5) / 3.0, (j + 0.5) / 2.0, (k + 0.5) / 4.0]);
        for (i, j, k) in [(0, 0, 0), (2, 1, 3), (1, 0, 2), (2, 0, 1)] {
            let expected = cell(i, j, k) as f32 / 23.0;
            assert!((at(i.into(), j.into(), k.into()) - expected).abs() < 1e-6, "{i} {j} {k}");
        }
        let half_way = 0.5 * (cell(0, 1, 2) + cell(1, 1, 2)) as f32 / 23.0;
        assert!((at(0.5, 1.0, 2.0) - half_way).abs() < 1e-6);
        let half_way = 0.5 * (cell(2, 1, 0) + cell(2, 1, 1)) as f32 / 23.0;
        assert!((at(2.0, 1.0, 0.5) - half_way).abs() < 1e-6);
    }

    #[test]
    fn beyond_the_grid_it_goes_on_as_it_is_told() {
        let wrapped = |wrap: &str| {
            grid(1, &format!(r#"<string name="wrap_mode" value="{wrap}"/>"#), ColorMode::Rgb).unwrap()
        };
        let [clamp, repeat, mirror] = ["clamp", "repeat", "mirror"].map(wrapped);
        let place = [0.4, 0.3, 0.6];
        assert_eq!(value(&clamp, [7.0, 0.3, 0.6]), value(&clamp, [1.0, 0.3, 0.6]));
        assert!((value(&repeat, [2.4, -0.7, 0.6]) - value(&repeat, place)).abs() < 1e-6);
        assert!((value(&mirror, [-0.4, 1.7, 2.6]) - value(&mirror, place)).abs() < 1e-6);
        let moved = r#"<transform name="to_world"><scale value="2, 1, 1"/><translate x="-3"/></transform>"#;
        let moved = grid(1, moved, ColorMode::Rgb).unwrap();
        assert!((value(&moved, [-2.2, 0.3, 0.6]) - value(&clamp, place)).abs() < 1e-6);
    }

    #[test]
    fn nothing_exceeds_its_majorant() {
        for (channels, mode) in [(1, ColorMode::Rgb), (3, ColorMode::Rgb), (3, ColorMode::Spectral)] {
            for (wrap, filter) in [("clamp", "trilinear"), ("repeat", "trilinear"), ("mirror", "nearest")] {
                let parameters = format!(
                    r#"<string name="wrap_mode" value="{wrap}"/><string name="filter_type" value="{filter}"/>"#
                );
                let volume = grid(channels, &parameters, mode).unwrap();
                let λ = match mode {
                    ColorMode::Rgb => Wavelengths::rgb(),
                    ColorMode::Spectral => Wavelengths::sample_visible(0.4),
                };
                for i in 0..200 {
                    let part = |step: f64| (0.5 + f64::from(i) * step).fract();
                    let lo = DVec3::new(part(0.618), part(0.755), part(0.57)) * 5.0 - 2.0;
                    let size =
                        DVec3::new(part(0.82), part(0.67), part(0.55)) * if i % 7 == 0 { 9.0 } else { 0.3 };
                    let bound = volume.majorant(lo, lo + size) * (1.0 + 1e-6);
                    for j in 0..64 {
                        let inside = [j & 3, j >> 2 & 3, j >> 4].map(|k| f64::from(k) / 3.0);
                        let found = volume.eval(lo + size * DVec3::from(inside), &λ).max();
                        assert!(f64::from(found) <= bound, "{wrap} {lo} {size}: {found} above {bound}");
                    }
                }
            }
        }
    }

    #[test]
    fn colours_that_reflect_are_the_spectra_of_such_colours() {
        let volume = grid(3, "", ColorMode::Spectral).unwrap();
        let document = xml::read_text("colour.xml", "<volume version=\"3.0.0\"/>").unwrap();
        let loader = Loader::new(&document, ColorMode::Spectral).unwrap();
        for hero in [0.1, 0.4, 0.9, 0.999] {
            let λ = Wavelengths::sample_visible(hero);
            for cell in 0..3 {
                let rgb = [0, 1, 2].map(|c| ((3 * cell + c) * 7 % 24) as f32 / 23.0);
                let middle = DVec3::new((f64::from(cell) + 0.5) / 3.0, 0.25, 0.125);
                let (found, expected) =
                    (volume.eval(middle, &λ), loader.upsampler.fit(rgb).eval_lanes(&λ.nm));
                assert!(found.max() <= 1.0, "{rgb:?}: {found:?}");
                assert!(
                    found.0.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
                    "{rgb:?}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn grids_that_cannot_be_meant_are_refused() {
        let refused =
            |channels: u32, parameters: &str| grid(channels, parameters, ColorMode::Rgb).unwrap_err();
        let raw = r#"<boolean name="raw" value="true"/>"#;
        assert!(grid(3, raw, ColorMode::Spectral).unwrap_err().contains("no colour"));
        assert!(grid(3, raw, ColorMode::Rgb).is_ok());
        assert!(refused(1, r#"<string name="wrap_mode" value="bend"/>"#).contains("unknown wrap_mode"));
        assert!(refused(2, "").contains("2 channels"));
        assert!(grid(1, r#"<boolean name="use_grid_bbox" value="true"/>"#, ColorMode::Rgb).is_ok());
    }
}
