//! Camera samples: from (seed, pixel, sample number) to the values of all channels.

use crate::film::filter_weights::Place;
use crate::film::{Band, Film};
use crate::integrator::path::reuse;
use crate::integrator::{CameraPath, Counters, KernelEntry};
use crate::math::DVec2;
use crate::sampler::{ManyNumbers, Numbers, RandomSource, SampleId, Sampler, blocks};
use crate::scene::Scene;
use crate::sensor::Optics;
use crate::spectrum::{LANES, Spectrum, Wavelengths};
use std::ops::Range;

/// Everything that makes samples of a scene.
pub struct SampleMaker<'a> {
    scene: &'a Scene,
    numbers: RandomSource,
    kernel: &'a KernelEntry,
    radiance: bool,
    /// Of the sensor.
    response: f64,
    /// Number of channels besides light that the integrator fills.
    extra: usize,
}

impl<'a> SampleMaker<'a> {
    pub fn new(scene: &'a Scene, seed: u32, kernel: &'a KernelEntry) -> Self {
        let extra = scene.integrator.extra_channels().len();
        let numbers = RandomSource { kind: scene.sensor.sampler.kind, seed };
        let response = scene.sensor.camera.response();
        Self { scene, numbers, kernel, radiance: scene.integrator.has_radiance(), response, extra }
    }

    /// The names of the channels that are filled.
    pub fn channel_names(&self) -> Vec<String> {
        self.scene.integrator.channel_names(&self.scene.sensor.film)
    }

    /// How many there are of these.
    pub fn channels(&self) -> usize {
        self.color_channels() + self.extra
    }

    /// The values of camera samples: for each all channels, weighted by the reconstruction filter unless that
    /// spreads them. Also their paths, and those weights.
    pub fn samples(
        &self,
        which: &[SampleId],
        counters: &mut Counters,
        values: &mut [f64],
    ) -> (Vec<CameraPath>, Vec<f64>) {
        let (mut paths, weights) = self.generate(which);
        let channels = values.len() / which.len();
        let colors = channels - self.extra;
        if self.extra > 0 {
            for ((path, weight), values) in paths.iter().zip(&weights).zip(values.chunks_mut(channels)) {
                let values = &mut values[colors..];
                self.scene.integrator.extra_values(self.scene, &path.ray, counters, values);
                values.iter_mut().for_each(|v| *v *= weight);
            }
        }
        if self.radiance {
            (self.kernel.run)(self.scene, &self.scene.integrator, &mut paths, counters);
            for ((path, weight), values) in paths.iter().zip(&weights).zip(values.chunks_mut(channels)) {
                let covered = f64::from(u8::from(path.covered));
                self.colors(&path.λ, path.radiance, covered, *weight, &mut values[..colors]);
            }
        }
        (paths, weights)
    }

    /// Fills the channels that follow from a sample's others, once light paths have been added to those.
    #[inline]
    pub fn complete(&self, values: &mut [f64]) {
        self.scene.integrator.complete(values);
    }

    /// How many channels hold light: R, G, B, alpha and the bands.
    pub fn color_channels(&self) -> usize {
        let film = &self.scene.sensor.film;
        if self.radiance { 3 + usize::from(film.alpha) + film.bands.len() } else { 0 }
    }

    pub fn film(&self) -> &'a Film {
        &self.scene.sensor.film
    }

    /// The place of all samples of this number within their pixels, if these count for several; see
    /// [`super::spread`].
    pub fn place_in_pixels(&self, sample: u64) -> Option<[Place; 2]> {
        let film = self.film();
        film.spread.as_ref()?;
        let numbers = self.numbers.place_in_pixels(sample).block(blocks::START);
        film.place_in_pixels(numbers.place_on_film())
    }

    /// How many neighbouring pixels share what their paths find.
    pub fn reuse(&self) -> u32 {
        self.scene.integrator.reuse()
    }

    /// Number of light paths per sample number.
    pub fn light_paths(&self) -> u64 {
        u64::from(self.scene.techniques.light_paths())
    }

    /// Traces the light paths with these numbers, counted over all samples, and passes to `splat`, for each
    /// contribution, the path's number, the pixel, and the values of the colour channels.
    pub fn trace_light(
        &self,
        numbers: Range<u64>,
        counters: &mut Counters,
        mut splat: impl FnMut(u64, (u32, u32), &[f64]),
    ) {
        let Some(caustics) = &self.scene.techniques.caustics else { return };
        let mut values = vec![0.0; self.color_channels()];
        caustics.trace(
            self.scene,
            self.numbers,
            numbers,
            |u| self.wavelengths(u),
            counters,
            |number, found| {
                self.colors(&found.λ, found.radiance, 0.0, found.weight, &mut values);
                splat(number, found.pixel, &values);
            },
        );
    }

    /// Fills linear sRGB, alpha (`covered`) and the bands from the light along a path.
    #[inline]
    fn colors(&self, λ: &Wavelengths, radiance: Spectrum, covered: f64, weight: f64, values: &mut [f64]) {
        let film = &self.scene.sensor.film;
        let (rgb, more) = values.split_at_mut(3);
        let (alpha, bands) = more.split_at_mut(usize::from(film.alpha));
        alpha.fill(covered * weight);
        let weight = weight * self.response;
        for (value, c) in rgb.iter_mut().zip(λ.to_rgb(radiance)) {
            *value = c * weight;
        }
        if !film.bands.is_empty() {
            respond(&film.bands, λ, radiance, weight, bands);
        }
    }

    fn generate(&self, which: &[SampleId]) -> (Vec<CameraPath>, Vec<f64>) {
        let mut last = None;
        let samplers: Vec<Sampler> = which
            .iter()
            .map(|&SampleId { pixel, sample }| {
                let of_pixel = match last {
                    Some((known, sampler)) if known == pixel => sampler,
                    _ => self.numbers.camera(SampleId { pixel, sample: 0 }),
                };
                last = Some((pixel, of_pixel));
                of_pixel.at(sample as u32)
            })
            .collect();
        let (mut paths, mut weights) = (Vec::with_capacity(which.len()), Vec::with_capacity(which.len()));
        let groups = self.groups(which);
        let mut numbers = ManyNumbers::<8>::default();
        // Pairs for the place, the wavelengths and the lens.
        let pairs = if self.scene.sensor.camera.has_lens() { 3 } else { 2 };
        let mut common = None;
        for (first, (which, samplers)) in (0..).step_by(8).zip(which.chunks(8).zip(samplers.chunks(8))) {
            numbers.fill(which.len(), pairs, |i| (&samplers[i], blocks::START));
            for (i, (&SampleId { pixel, sample }, sampler)) in which.iter().zip(samplers).enumerate() {
                if self.film().spread.is_some() && common.is_none_or(|(of, _)| of != sample) {
                    common = self.place_in_pixels(sample).map(|place| (sample, place));
                }
                let place = common.map(|(_, place)| place);
                let (path, weight) = self.path(pixel, place, *sampler, numbers.of(i), groups.get(first + i));
                paths.push(path);
                weights.push(weight);
            }
        }
        (paths, weights)
    }

    /// Of samples whose pixels share what they find: the number of each one's group. All samples of a cell
    /// have the wavelengths of its corner, which come second.
    fn groups(&self, which: &[SampleId]) -> Vec<(u32, Wavelengths)> {
        let pixels = self.scene.integrator.reuse();
        if pixels == 1 {
            return vec![];
        }
        let mut last: Option<(reuse::GroupId, u32, Wavelengths)> = None;
        let of = |&id: &SampleId| {
            let group = reuse::group(id, pixels);
            let (number, λ) = match last {
                Some((known, number, λ)) if known == group => (number, λ),
                Some((known, number, λ)) if known.cell == group.cell && known.sample == group.sample => {
                    (number + 1, λ)
                }
                _ => {
                    let corner = SampleId { pixel: group.corner(), sample: group.sample };
                    let number = last.map_or(0, |(_, number, _)| number + 1);
                    (number, self.wavelengths(self.numbers.camera(corner).block(blocks::START).wavelengths()))
                }
            };
            last = Some((group, number, λ));
            (number, λ)
        };
        which.iter().map(of).collect()
    }

    #[inline]
    fn wavelengths(&self, u: f64) -> Wavelengths {
        match &self.scene.sensor.film.wavelengths {
            Some(distribution) => distribution.sample(u),
            None => self.scene.mode.wavelengths(u),
        }
    }

    #[inline]
    fn path(
        &self,
        pixel: (u32, u32),
        place: Option<[Place; 2]>,
        sampler: Sampler,
        u: &Numbers,
        group: Option<&(u32, Wavelengths)>,
    ) -> (CameraPath, f64) {
        let film = &self.scene.sensor.film;
        let (place, weight) = match place {
            None => film.place(pixel, u.place_on_film()),
            Some([x, y]) => (DVec2::new(f64::from(pixel.0) + x.ξ, f64::from(pixel.1) + y.ξ), 1.0),
        };
        let place = place / DVec2::new(film.size.0 as f64, film.size.1 as f64);
        let (group, λ) = group.copied().unwrap_or_else(|| (0, self.wavelengths(u.wavelengths())));
        let ray = self.scene.sensor.camera.ray(place, u.place_on_lens());
        (CameraPath { ray, λ, sampler, group, radiance: Spectrum::ZERO, covered: false }, weight)
    }
}

/// Fills bands: light along a path, weighted by their spectral responses. It is a function of its own, so
/// that other films do not pay for it.
#[inline(never)]
fn respond(bands: &[Band], λ: &Wavelengths, radiance: Spectrum, weight: f64, values: &mut [f64]) {
    for (value, band) in values.iter_mut().zip(bands) {
        let responded =
            |i: usize| radiance.0[i] as f64 * band.response.eval(λ.nm[i]) as f64 / λ.pdf[i] as f64;
        *value = weight * (0..LANES).map(responded).sum::<f64>() / LANES as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::kernel_for;
    use crate::load_text;
    use crate::spectrum::ColorMode;

    #[test]
    fn film_lens_and_wavelengths_know_nothing_of_one_another() {
        const SAMPLES: u64 = 4096;
        let text = r#"<scene version="3.0.0"><sensor type="thinlens"><float name="aperture_radius" value="1"/><float name="focus_distance" value="2"/>
                <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
                    <rfilter type="box"/></film><sampler type="independent"/></sensor></scene>"#;
        let scene = load_text("scene.xml", text, ColorMode::Spectral).unwrap();
        let maker = SampleMaker::new(&scene, 0, kernel_for(scene.features()));
        let which: Vec<_> = (0..SAMPLES).map(|sample| SampleId { pixel: (0, 0), sample }).collect();
        let drawn = |path: &CameraPath| {
            let (lens, way) = (path.ray.origin, path.ray.direction);
            // The lens is in the plane z = 0, and what is on the film is sharp at z = 2.
            let sharp = lens + way * (2.0 / way.z);
            [lens.x, lens.y, sharp.x, sharp.y, f64::from(path.λ.nm[0])]
        };
        let drawn: Vec<[f64; 5]> = maker.generate(&which).0.iter().map(drawn).collect();
        let mean = |f: &dyn Fn(&[f64; 5]) -> f64| drawn.iter().map(f).sum::<f64>() / SAMPLES as f64;
        let means: [f64; 5] = std::array::from_fn(|i| mean(&|v| v[i]));
        let covariance = |i: usize, j: usize| mean(&|v| (v[i] - means[i]) * (v[j] - means[j]));
        for (i, j) in (0..5).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let correlation = covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt();
            assert!(correlation.abs() < 5.0 / (SAMPLES as f64).sqrt(), "{i} {j}: {correlation}");
        }
    }
}
