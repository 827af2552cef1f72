//! The film of a scene: its size, and where on it a sample lies.

use super::bands::Band;
use super::filter::Profile;
use super::filter_sampler::FilterSampler;
use super::filter_weights::{FilterWeights, Place, Weights};
use crate::film::Window;
use crate::math::DVec2;
use crate::spectrum::distribution::Distribution;
use std::sync::Arc;

/// A film larger than this is refused: its accumulators alone would take tens of gigabytes.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The film: its size, and what it records.
#[derive(Clone, Debug)]
pub struct Film {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The part of the film that the scene file asks for.
    pub crop: Window,
    pub filter: FilterSampler,
    /// Whether filters reach beyond the crop; otherwise they end there, as in Mitsuba.
    pub border: bool,
    /// Where samples count for all pixels that the filter reaches, instead of lying where a pixel's filter
    /// says; see [`crate::render::plan::reuse`], which settles it.
    pub spread: Option<FilterWeights>,
    /// Whether there is a channel `A`, which says how much of a pixel is covered.
    pub alpha: bool,
    /// The responses of a spectral film, by name; an RGB film has none.
    pub bands: Vec<Band>,
    /// The wavelengths of a spectral film.
    pub wavelengths: Option<Arc<Distribution>>,
}

impl Default for Film {
    fn default() -> Self {
        Self::new((768, 576), Profile::Gaussian { deviation: 0.5 })
    }
}

impl Film {
    pub fn new(size: (u32, u32), profile: Profile) -> Self {
        let crop = Window { x: 0, y: 0, width: size.0, height: size.1 };
        let filter = FilterSampler::new(profile);
        Self {
            size,
            crop,
            filter,
            border: false,
            spread: None,
            alpha: false,
            bands: vec![],
            wavelengths: None,
        }
    }

    /// Where a sample of pixel (x, y) lies, in pixels of the film, and its weight; u is in [0, 1)².
    #[inline]
    pub fn place(&self, (x, y): (u32, u32), u: DVec2) -> (DVec2, f64) {
        let [(left, right), (above, below)] = self.sides((x, y));
        let (dx, wx) = self.filter.sample(u.x, left, right);
        let (dy, wy) = self.filter.sample(u.y, above, below);
        (DVec2::new(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy), wx * wy)
    }

    /// The place of all samples of a number within their pixels, by column and by row, if samples count for
    /// all pixels that the filter reaches; u is in [0, 1)².
    pub fn place_in_pixels(&self, u: DVec2) -> Option<[Place; 2]> {
        self.spread.as_ref().map(|spread| [spread.place(u.x), spread.place(u.y)])
    }

    /// The weights, by column and by row, that samples at this place within their pixels have for pixel
    /// (x, y), which is in the middle.
    pub fn weights(&self, pixel: (u32, u32), [column, row]: [Place; 2]) -> Option<[Weights; 2]> {
        let [columns, rows] = self.sides(pixel);
        let spread = self.spread.as_ref()?;
        Some([spread.at(column, &self.filter, columns), spread.at(row, &self.filter, rows)])
    }

    /// How filters can be splatted, if they can. Beyond the film there are no samples.
    pub fn spreadable(&self) -> Option<FilterWeights> {
        if self.border { None } else { FilterWeights::new(self.filter.profile()) }
    }

    /// Variance of a sum of many squares of pixels over the sum of the variances of squares of this edge: where
    /// samples count for several pixels, errors of these are alike.
    pub fn correlation(&self, edge: u32) -> f64 {
        self.spread.as_ref().map_or(1.0, |spread| {
            let along = spread.squares(&self.filter, edge);
            1.0 / (along * along)
        })
    }

    /// How many further pixels the filter of pixel (x, y) may reach: left and right, above and below.
    #[inline]
    fn sides(&self, (x, y): (u32, u32)) -> [(u32, u32); 2] {
        let (c, all) = (self.crop, (u32::MAX, u32::MAX));
        // Pixels that share with those of the crop may lie beyond it.
        let sides = |pixel: u32, begin: u32, size: u32| {
            (pixel.saturating_sub(begin), (begin + size - 1).saturating_sub(pixel))
        };
        if self.border { [all, all] } else { [sides(x, c.x, c.width), sides(y, c.y, c.height)] }
    }

    /// The pixel that light at a place of the film (in pixels) is given to, and its weight: the inverse of
    /// [`Film::place`].
    pub fn pixel_at(&self, place: DVec2, u: DVec2) -> Option<((u32, u32), f64)> {
        let c = self.crop;
        let limits = |count: u32| {
            move |pixel: u32| if self.border { (u32::MAX, u32::MAX) } else { (pixel, count - 1 - pixel) }
        };
        let (x, wx) = self.filter.pixel_at(place.x - f64::from(c.x), u.x, c.width, limits(c.width))?;
        let (y, wy) = self.filter.pixel_at(place.y - f64::from(c.y), u.y, c.height, limits(c.height))?;
        Some(((c.x + x, c.y + y), wx * wy))
    }

    /// Width over height.
    pub fn aspect(&self) -> f64 {
        self.size.0 as f64 / self.size.1 as f64
    }

    /// Refuses sizes that no film can have.
    pub fn check_size(width: u64, height: u64) -> Result<(), String> {
        if width == 0 || height == 0 {
            return Err(format!("a film of {width} × {height} pixels has no pixels"));
        }
        if width.saturating_mul(height) > MAX_PIXELS {
            return Err(format!(
                "a film of {width} × {height} pixels is too large; at most {MAX_PIXELS} are possible"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u32, u32) = (7, 5);

    #[test]
    fn samples_lie_about_the_centre_of_their_pixel() {
        for profile in [Profile::Box, Profile::Gaussian { deviation: 0.5 }] {
            let (place, weight) = Film::new(SIZE, profile).place((3, 2), DVec2::splat(0.5));
            assert!((place - DVec2::new(3.5, 2.5)).length() < 1e-12, "{place}");
            assert!((weight - 1.0).abs() < 0.01, "{weight}");
        }
    }

    #[test]
    fn filters_end_at_the_film_unless_they_may_reach_beyond() {
        let mut film = Film::new(SIZE, Profile::Gaussian { deviation: 0.5 });
        for border in [false, true] {
            film.border = border;
            let (first, _) = film.place((0, 0), DVec2::splat(1e-6));
            let (last, _) = film.place((6, 4), DVec2::splat(1.0 - 1e-6));
            let beyond = [first.x < 0.0, first.y < 0.0, last.x > 7.0, last.y > 5.0];
            assert_eq!(beyond, [border; 4], "{first} {last}");
        }
    }

    /// Light goes to the pixels whose samples lie where it falls: over all places, as often as their weights
    /// say.
    #[test]
    fn light_is_given_to_the_pixel_that_gathers_it() {
        let mut film = Film::new(SIZE, Profile::Box);
        film.crop = Window { x: 2, y: 1, width: 3, height: 2 };
        for pixel in [(2, 1), (4, 1), (3, 2), (4, 2)] {
            let (place, _) = film.place(pixel, DVec2::new(0.1, 0.9));
            assert_eq!(film.pixel_at(place, DVec2::splat(0.4)), Some((pixel, 1.0)));
        }
        assert_eq!(film.pixel_at(DVec2::new(1.9, 1.5), DVec2::splat(0.4)), None);
    }
}
