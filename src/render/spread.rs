//! Samples that count for every pixel whose filter reaches them.
//!
//! Drawn from its own pixel's filter ([`Film::place`]), a sample counts for that pixel alone, and errors of
//! pixels are independent. Where pixels may share, samples lie evenly in their own pixels instead, and what a
//! pixel has of sample number s is a sum over its neighbours' samples s, weighted by its filter
//! ([`filter_weights`](crate::film::filter_weights)). White noise then has ∫f² of its variance: 4/9 with a tent
//! of radius one, 1/π with Mitsuba's default, a gaussian.
//!
//! That sum is still a function of scene, seed, pixel and number, and all that holds for samples (merging,
//! blocks, variances) holds for it. It needs samples of the same number of pixels all around, so the whole
//! window makes a few numbers at a time.

use super::sample::Camera;
use super::splats::Splats;
use super::tile::{BATCH, add, batches};
use super::{Progress, Report};
use crate::film::filter_weights::{Place, Weights};
use crate::film::{Accumulators, ChannelAccumulator, Film};
use crate::image::Window;
use crate::integrator::Counters;
use crate::integrator::path::reuse::CELL;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Bytes that the samples which are made together may take, if there is more than one of each pixel.
const TOGETHER: usize = 1 << 26;

/// Most samples of a pixel that are made together: enough for many threads.
const MOST: usize = 16;

/// The samples of a window.
pub struct Spread<'a> {
    camera: &'a Camera<'a>,
    film: &'a Film,
    window: Window,
    /// The pixels that count for any of the window.
    around: Window,
    reach: u32,
    channels: usize,
    /// Sample by sample and row by row of those pixels, for each column of the window: all channels, summed
    /// along the row.
    columns: Vec<f64>,
}

/// A sample that is not finite. It counts for its own pixel only, where it is found and named.
struct Lost {
    pixel: (u32, u32),
    sample: u64,
    values: Vec<f64>,
}

impl<'a> Spread<'a> {
    pub fn new(camera: &'a Camera<'a>, window: Window, channels: usize) -> Self {
        let film = camera.film();
        let reach = film.spread.as_ref().map_or(0, |spread| spread.reach());
        let around = around(window, film.crop, reach);
        let size = channels * (around.height * window.width) as usize;
        let together = (TOGETHER / (size * size_of::<f64>())).clamp(1, MOST);
        Self { camera, film, window, around, reach, channels, columns: vec![0.0; together * size] }
    }

    /// Adds these samples of all pixels of the window to their sums, and what light paths bring to them. `None`
    /// if told to stop.
    pub fn add(
        &mut self,
        samples: &Range<u64>,
        splats: &Splats,
        sums: &mut Accumulators,
        progress: &Progress,
    ) -> Option<Report> {
        let mut report = Report::default();
        let together = (self.columns.len() / self.size()) as u64;
        for first in samples.clone().step_by(together as usize) {
            let some = first..samples.end.min(first + together);
            let (counters, lost) = self.trace(&some, progress)?;
            report.count(&counters);
            let length = self.channels * self.window.width as usize;
            let row = |(y, sums): (usize, &mut [ChannelAccumulator])| {
                let mut report = Report::default();
                let mut values = vec![0.0; length];
                for sample in some.clone() {
                    self.gather(
                        (sample - first) as usize,
                        sample,
                        self.window.y + y as u32,
                        &lost,
                        &mut values,
                    );
                    let pixels =
                        values.chunks_exact_mut(self.channels).zip(sums.chunks_exact_mut(self.channels));
                    for (x, (values, sums)) in (self.window.x..).zip(pixels) {
                        let of = ((x, self.window.y + y as u32), sample);
                        add(self.camera, splats, of, values, sums, &mut report);
                    }
                }
                report
            };
            let rows = sums.all_mut().par_chunks_exact_mut(length).enumerate();
            rows.map(row).collect::<Vec<_>>().iter().for_each(|more| report.add(more));
            progress.done.fetch_add((some.end - first) * self.window.pixels() as u64, Ordering::Relaxed);
        }
        report.list_first();
        Some(report)
    }

    /// All channels of one sample of a window of one pixel, without what light paths bring.
    pub fn one(mut self, sample: u64) -> Vec<f64> {
        let mut values = vec![0.0; self.channels];
        if let Some((_, lost)) = self.trace(&(sample..sample + 1), &Progress::default()) {
            self.gather(0, sample, self.window.y, &lost, &mut values);
        }
        values
    }

    /// Numbers of a sample's columns.
    fn size(&self) -> usize {
        self.channels * (self.around.height * self.window.width) as usize
    }

    /// Traces these samples of all pixels around, and sums them along rows.
    fn trace(&mut self, samples: &Range<u64>, progress: &Progress) -> Option<(Counters, Vec<Lost>)> {
        let length = self.channels * self.window.width as usize;
        let mut columns = std::mem::take(&mut self.columns);
        let mut jobs = vec![];
        let mut rest = columns.as_mut_slice();
        for (sample, band) in
            samples.clone().flat_map(|sample| bands(self.around).map(move |band| (sample, band)))
        {
            let (sums, others) = rest.split_at_mut(band.height as usize * length);
            jobs.push((sample, band, sums));
            rest = others;
        }
        let job = |(sample, band, sums): (u64, Window, &mut [f64])| self.band(sample, band, sums, progress);
        let done = jobs.into_par_iter().map(job).collect::<Option<Vec<_>>>();
        self.columns = columns;
        let (mut counters, mut lost) = (Counters::default(), vec![]);
        for (more, found) in done? {
            counters.rays += more.rays;
            counters.cut += more.cut;
            lost.extend(found);
        }
        Some((counters, lost))
    }

    /// Traces one sample of some whole rows of pixels.
    fn band(
        &self,
        sample: u64,
        band: Window,
        sums: &mut [f64],
        progress: &Progress,
    ) -> Option<(Counters, Vec<Lost>)> {
        let (mut counters, mut lost) = (Counters::default(), vec![]);
        let (channels, width) = (self.channels, band.width as usize);
        let mut row_by_row = vec![0.0; channels * band.pixels()];
        let mut values = vec![0.0; channels * BATCH];
        batches(self.camera, band, &(sample..sample + 1), |which| {
            if progress.stop.load(Ordering::Relaxed) {
                return None;
            }
            let values = &mut values[..channels * which.len()];
            self.camera.samples(which, &mut counters, values);
            for (&(pixel, _), values) in which.iter().zip(values.chunks_exact(channels)) {
                let Some(at) = place_in(band, pixel) else { continue };
                if values.iter().all(|value| value.is_finite()) {
                    row_by_row[at * channels..][..channels].copy_from_slice(values);
                } else {
                    lost.push(Lost { pixel, sample, values: values.to_vec() });
                }
            }
            Some(())
        })?;
        let place = self.camera.place_in_pixels(sample)?;
        let weights = |x: u32| self.film.weights((x, self.window.y), place).map(|[columns, _]| columns);
        let weights: Vec<_> = (self.window.x..).take(self.window.width as usize).map(weights).collect();
        let shift = self.window.x - self.around.x;
        let rows = row_by_row.chunks_exact(channels * width);
        for (row, sums) in rows.zip(sums.chunks_exact_mut(channels * self.window.width as usize)) {
            for ((x, sums), weights) in (shift..).zip(sums.chunks_exact_mut(channels)).zip(&weights) {
                sums.fill(0.0);
                for (from, weight) in neighbours(x, weights, self.reach) {
                    let values = &row[from * channels..][..channels];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
                }
            }
        }
        Some((counters, lost))
    }

    /// Sums the nth of the samples that were traced, whose number is `sample`, along the columns at row `y`.
    fn gather(&self, n: usize, sample: u64, y: u32, lost: &[Lost], sums: &mut [f64]) {
        let place: Option<[Place; 2]> = self.camera.place_in_pixels(sample);
        let weights = place.and_then(|place| self.film.weights((self.window.x, y), place));
        let columns = &self.columns[n * self.size()..];
        sums.fill(0.0);
        for (from, weight) in neighbours(y - self.around.y, &weights.map(|[_, rows]| rows), self.reach) {
            let row = &columns[from * sums.len()..][..sums.len()];
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
        for Lost { pixel, values, .. } in
            lost.iter().filter(|lost| lost.sample == sample && lost.pixel.1 == y)
        {
            let row = Window { y, height: 1, ..self.window };
            if let Some(at) = place_in(row, *pixel) {
                sums[at * self.channels..][..self.channels].copy_from_slice(values);
            }
        }
    }
}

/// The places around `at`, along one side of those that are kept, that have a weight.
fn neighbours(at: u32, weights: &Option<Weights>, reach: u32) -> impl Iterator<Item = (usize, f64)> {
    let weights = weights.unwrap_or_default().into_iter().enumerate();
    let weighty = weights.filter(|(_, weight)| *weight != 0.0);
    weighty.map(move |(i, weight)| (at as usize + i - reach as usize, weight))
}

/// Which pixel of a window this is, row by row, if it is one.
fn place_in(window: Window, (x, y): (u32, u32)) -> Option<usize> {
    let (x, y) = (x.wrapping_sub(window.x), y.wrapping_sub(window.y));
    (x < window.width && y < window.height).then(|| (y * window.width + x) as usize)
}

/// The rows of a window in bands that cut no cell of pixels that share.
fn bands(window: Window) -> impl Iterator<Item = Window> {
    let end = window.y + window.height;
    let begin = (window.y / CELL * CELL..end).step_by(CELL as usize);
    begin.map(move |at| {
        let y = at.max(window.y);
        Window { y, height: (at + CELL).min(end) - y, ..window }
    })
}

/// A window with `reach` pixels more on each side, as far as they are on the film.
fn around(window: Window, crop: Window, reach: u32) -> Window {
    let grow = |begin: u32, size: u32, first: u32, all: u32| {
        let low = begin.saturating_sub(reach).max(first);
        let high = (begin + size + reach).min(first + all);
        (low, high - low)
    };
    let (x, width) = grow(window.x, window.width, crop.x, crop.width);
    let (y, height) = grow(window.y, window.height, crop.y, crop.height);
    Window { x, y, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::integrator::kernel_for;
    use crate::render::pixel;
    use crate::render::quality::{Correlation, Quality};
    use crate::render::{Progress, Settings, render};
    use crate::scene::{Scene, load_text};
    use crate::spectrum::ColorMode;

    const FILTERS: [&str; 4] = [
        r#"<rfilter type="tent"/>"#,
        r#"<rfilter type="gaussian"/>"#,
        r#"<rfilter type="mitchell"/>"#,
        r#"<rfilter type="lanczos"/>"#,
    ];

    /// Twice: with samples that count for one pixel each, and for all that the filter reaches. The film shows a
    /// part that begins within it.
    fn scenes(filter: &str, content: &str) -> [Scene; 2] {
        sharing(1, filter, content)
    }

    /// The same where so many pixels share paths.
    fn sharing(pixels: u32, filter: &str, content: &str) -> [Scene; 2] {
        let depth = if pixels > 1 { 4 } else { 2 };
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="{depth}"/>
                <integer name="reuse" value="{pixels}"/></integrator>
            <sensor type="perspective"><float name="fov" value="40"/><sampler type="independent"/><film type="hdrfilm">
                <integer name="width" value="14"/><integer name="height" value="12"/>
                <integer name="crop_offset_x" value="1"/><integer name="crop_offset_y" value="2"/>
                <integer name="crop_width" value="12"/><integer name="crop_height" value="9"/>{filter}</film></sensor>
            {content}</scene>"#
        );
        let scene = || load_text("scene.xml", &text, ColorMode::Rgb).expect("it loads");
        let (own, mut spread) = (scene(), scene());
        spread.sensor.film.spread = spread.sensor.film.spreadable();
        assert!(spread.sensor.film.spread.is_some());
        [own, spread]
    }

    fn image(scene: &Scene, seed: u32, samples: u64) -> Image {
        let settings = Settings { seed, ..Settings::of(scene, 0..samples) };
        render(scene, &settings, &Progress::default()).expect("it renders").0
    }

    /// Mean and variance of green, pixel by pixel.
    fn green(image: &Image) -> impl Iterator<Item = (f64, f64)> {
        let variances = image.channels[1].variance.as_deref().expect("there are variances");
        image.channels[1].mean.iter().zip(variances).map(|(mean, v)| (f64::from(*mean), f64::from(*v)))
    }

    const BALL: &str = r#"<shape type="sphere"><transform name="to_world"><scale value="0.8"/><translate x="0.3" y="0.2" z="4"/></transform></shape>
        <shape type="rectangle"><transform name="to_world"><scale x="0.1" y="9"/><translate x="-0.9" z="4"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
        <emitter type="constant"/>"#;

    #[test]
    fn pixels_are_what_their_filters_say_up_to_the_film_s_borders() {
        for filter in FILTERS {
            let [own, spread] = scenes(filter, BALL).map(|scene| image(&scene, 0, 1 << 14));
            for (i, ((a, va), (b, vb))) in green(&own).zip(green(&spread)).enumerate() {
                // Four filters of 108 pixels; beyond five deviations is one in four thousand.
                let z = (a - b) / (va + vb).sqrt();
                assert!(z.abs() < 5.0, "{filter}, pixel {i}: {a} {b}, {z} deviations");
            }
        }
    }

    #[test]
    fn pixels_that_share_paths_are_what_their_filters_say() {
        let room = r#"<shape type="cube"><transform name="to_world"><scale value="3"/><translate z="2.5"/></transform>
                <boolean name="flip_normals" value="true"/><bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></shape>
            <shape type="sphere"><point name="center" x="0.6" y="0.4" z="4"/><float name="radius" value="0.4"/><emitter type="area"/></shape>"#;
        for pixels in [4, 64] {
            let [own, spread] = sharing(pixels, FILTERS[0], room).map(|scene| image(&scene, 0, 4096));
            for (i, ((a, va), (b, vb))) in green(&own).zip(green(&spread)).enumerate() {
                let z = (a - b) / (va + vb).sqrt();
                assert!(z.abs() < 5.0, "{pixels} share, pixel {i}: {a} {b}, {z} deviations");
            }
        }
    }

    #[test]
    fn a_pixel_is_the_weighted_sum_of_the_samples_around_it() {
        for filter in FILTERS {
            let [_, scene] = scenes(filter, BALL);
            let film = &scene.sensor.film;
            let camera = Camera::new(&scene, 1, kernel_for(scene.features));
            let settings = Settings { seed: 1, ..Settings::of(&scene, 4..5) };
            let (image, _) = render(&scene, &settings, &Progress::default()).expect("it renders");
            let place = camera.place_in_pixels(4).expect("it is the same in all pixels");
            let reach = film.spread.as_ref().map_or(0, |spread| spread.reach());
            for i in 0..film.crop.pixels() {
                let (x, y) = pixel(film.crop, i);
                let [columns, rows] = film.weights((x, y), place).expect("there are some");
                let mut sum = 0.0;
                for (j, row) in rows.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                    for (i, column) in columns.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                        let from = (x + i as u32 - reach, y + j as u32 - reach);
                        let path = camera.replay(from, 4).path;
                        sum += column * row * f64::from(path.radiance.0[1]);
                    }
                }
                let shown = f64::from(image.channels[1].mean[i]);
                assert!((shown - sum).abs() <= 1e-6 * shown.abs(), "{filter}, {x} {y}: {shown} {sum}");
            }
        }
    }

    #[test]
    fn even_light_makes_an_even_picture() {
        for filter in FILTERS {
            let [_, spread] = scenes(filter, r#"<emitter type="constant"/>"#);
            let image = image(&spread, 0, 8);
            let reach = spread.sensor.film.spread.as_ref().map_or(0, |spread| spread.reach());
            for (i, (mean, _)) in green(&image).enumerate() {
                let (x, y) = (i as u32 % 12, i as u32 / 12);
                let inside = |at: u32, size: u32| (reach..size - reach).contains(&at);
                if inside(x, 12) && inside(y, 9) {
                    assert!((mean - 1.0).abs() < 1e-3, "{filter}, {x} {y}: {mean}");
                }
            }
        }
    }

    /// Noise that is the same in all pixels: a wall that emits little, seen by an unlikely lamp.
    const NOISE: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/><translate z="4"/></transform></shape>
        <shape type="sphere"><point name="center" x="0" y="8" z="-9"/><float name="radius" value="3"/><emitter type="area"/></shape>
        <shape type="sphere"><point name="center" x="0" y="4" z="-1"/><float name="radius" value="1.4"/></shape>"#;

    #[test]
    fn noise_is_less_by_the_square_of_the_filter_and_the_mean_knows_of_it() {
        for (filter, expected) in [(FILTERS[0], 4.0 / 9.0), (FILTERS[1], std::f64::consts::FRAC_1_PI)] {
            let [own, spread] = scenes(filter, NOISE);
            let gain = spread.sensor.film.correlation();
            assert!((gain * expected - 1.0).abs() < 0.01, "{filter} {gain}");
            // Away from the film's borders.
            let variance = |image: &Image| -> f64 {
                let inside = |i: usize| (2..10).contains(&(i % 12)) && (2..7).contains(&(i / 12));
                green(image).enumerate().filter(|(i, _)| inside(*i)).map(|(_, (_, v))| v).sum()
            };
            let ratio = variance(&image(&spread, 0, 4096)) / variance(&image(&own, 0, 4096));
            assert!((ratio / expected - 1.0).abs() < 0.1, "{filter} {ratio}");
            // The scatter of the image's mean over seeds, whose square is uncertain by √(2/255), a twelfth.
            let quality = |seed| Quality::of_image(&image(&spread, seed, 16));
            let seen: Vec<Quality> = (0..256).map(quality).collect();
            let mean = seen.iter().map(|q| q.mean[1]).sum::<f64>() / 256.0;
            let scatter = seen.iter().map(|q| (q.mean[1] / mean - 1.0).powi(2)).sum::<f64>() / 255.0;
            let told = seen.iter().map(|q| q.relative_standard_error_of_mean.powi(2)).sum::<f64>() / 256.0;
            // At borders more samples are counted for one pixel only, so it is told a little too large.
            assert!((0.85..1.6).contains(&(told / scatter)), "{filter} {told} {scatter}");
        }
    }

    #[test]
    fn an_image_tells_that_its_samples_count_for_several_pixels() {
        let [own, spread] = scenes(FILTERS[1], BALL);
        assert_eq!(Correlation::of(&own), Correlation::NONE);
        let [own, spread] = [own, spread].map(|scene| (Correlation::of(&scene), image(&scene, 0, 8)));
        for (correlation, image) in [own, spread] {
            let known = Quality::new(image.crop, correlation, [green(&image)]);
            let told = Quality::of_image(&Image { channels: vec![image.channels[1].clone()], ..image });
            let ratio = told.relative_standard_error_of_mean / known.relative_standard_error_of_mean;
            assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
        }
    }

    #[test]
    fn what_is_not_finite_is_found_in_its_own_pixel_only() {
        // What the lamp emits and what it reflects together are more than single precision holds.
        let lamp = r#"<emitter type="constant"><rgb name="radiance" value="1.6e38"/></emitter>
            <emitter type="directional"><vector name="direction" z="1"/><rgb name="irradiance" value="1.6e38"/></emitter>
            <shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate z="4"/></transform>
                <bsdf type="diffuse"><rgb name="reflectance" value="0.99"/></bsdf>
                <emitter type="area"><rgb name="radiance" value="1.6e38"/></emitter></shape>"#;
        let [_, spread] = scenes(FILTERS[1], lamp);
        let settings = Settings::of(&spread, 0..64);
        let (image, report) = render(&spread, &settings, &Progress::default()).expect("it renders");
        let infinite = |x: u32, y: u32| !image.channels[1].mean[((y - 2) * 12 + x - 1) as usize].is_finite();
        assert!(!report.first_non_finite.is_empty());
        assert!(report.first_non_finite.iter().all(|found| infinite(found.pixel.0, found.pixel.1)));
        // The lamp's outline on the film: its radius over the film's half width, which is seven pixels.
        let radius = 7.0 * (0.5f64 / 4.0).asin().tan() / 20f64.to_radians().tan();
        let distance = |x: u32, y: u32| (f64::from(x) - 7.0).hypot(f64::from(y) - 6.0);
        for (x, y) in (2..11).flat_map(|y| (1..13).map(move |x| (x, y))) {
            let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| distance(x, y));
            let [nearest, farthest] =
                [f64::min, f64::max].map(|f| corners.into_iter().reduce(f).unwrap_or(0.0));
            assert!(!infinite(x, y) || nearest < radius, "{x} {y}");
            assert!(infinite(x, y) || farthest > radius, "{x} {y}");
        }
    }
}
