//! One camera sample: from (seed, pixel, sample number) to the values of all channels.

use crate::integrator::{Counters, KernelEntry};
use crate::math::{DVec2, Ray};
use crate::sampler::{CAMERA, Sampler};
use crate::scene::Scene;
use crate::spectrum::observer::{WAVELENGTH_MAX, WAVELENGTH_MIN};
use crate::spectrum::{ColorMode, LANES, Spectrum, Wavelengths};

/// Everything that makes samples of a scene.
pub struct Camera<'a> {
    scene: &'a Scene,
    seed: u32,
    kernel: &'a KernelEntry,
    radiance: bool,
    /// How many channels the integrator fills besides.
    extra: usize,
    /// The range that a spectral film makes wavelengths be drawn from; visible light is always within.
    band_range: Option<(f32, f32)>,
}

impl<'a> Camera<'a> {
    pub fn new(scene: &'a Scene, seed: u32, kernel: &'a KernelEntry) -> Self {
        let film = &scene.sensor.film;
        let band_range = (!film.bands.is_empty()).then(|| {
            let (lo, hi) = film.band_range();
            (lo.min(WAVELENGTH_MIN), hi.max(WAVELENGTH_MAX))
        });
        let extra = scene.integrator.extra_channels().len();
        Self { scene, seed, kernel, radiance: scene.integrator.has_radiance(), extra, band_range }
    }

    /// R, G, B, the spectral bands, and what the integrator adds.
    pub fn channel_names(&self) -> Vec<String> {
        let mut names: Vec<String> = vec![];
        if self.radiance {
            names.extend(["R", "G", "B"].map(String::from));
            names.extend(self.scene.sensor.film.bands.iter().map(|b| b.name.clone()));
        }
        names.extend(self.scene.integrator.extra_channels());
        names
    }

    /// The values of a sample, weighted by the reconstruction filter.
    #[inline]
    pub fn sample(&self, pixel: (u32, u32), sample: u64, counters: &mut Counters, values: &mut [f64]) {
        let (ray, weight, mut λ, sampler) = self.generate(pixel, sample);
        let (colors, extra) = values.split_at_mut(values.len() - self.extra);
        if self.extra > 0 {
            self.scene.integrator.extra_values(self.scene, &ray, counters, extra);
            extra.iter_mut().for_each(|v| *v *= weight);
        }
        if self.radiance {
            let radiance =
                (self.kernel.run)(self.scene, &self.scene.integrator, ray, &mut λ, &sampler, counters);
            let (rgb, bands) = colors.split_at_mut(3);
            for (value, c) in rgb.iter_mut().zip(λ.to_rgb(radiance)) {
                *value = c * weight;
            }
            for (value, band) in bands.iter_mut().zip(&self.scene.sensor.film.bands) {
                let responded =
                    |i: usize| radiance.0[i] as f64 * band.response.eval(λ.nm[i]) as f64 / λ.pdf[i] as f64;
                *value = weight * (0..LANES).map(responded).sum::<f64>() / LANES as f64;
            }
        }
    }

    /// The radiance of a sample before the filter's weight, its wavelengths, and the camera ray.
    pub fn replay(
        &self,
        pixel: (u32, u32),
        sample: u64,
        counters: &mut Counters,
    ) -> (Ray, Wavelengths, Spectrum, f64) {
        let (ray, weight, mut λ, sampler) = self.generate(pixel, sample);
        let radiance = (self.kernel.run)(self.scene, &self.scene.integrator, ray, &mut λ, &sampler, counters);
        (ray, λ, radiance, weight)
    }

    #[inline]
    fn generate(&self, (x, y): (u32, u32), sample: u64) -> (Ray, f64, Wavelengths, Sampler) {
        let film = &self.scene.sensor.film;
        let sampler = Sampler::new(self.scene.sensor.sampler.kind, self.seed, (x, y), sample as u32);
        let u = sampler.block(CAMERA);
        let (place, weight) = film.place((x, y), DVec2::new(u[0], u[1]));
        let place = place / DVec2::new(film.size.0 as f64, film.size.1 as f64);
        let λ = match (self.scene.mode, self.band_range) {
            (ColorMode::Rgb, _) => Wavelengths::rgb(),
            (ColorMode::Spectral, None) => Wavelengths::sample_visible(u[4]),
            (ColorMode::Spectral, Some((lo, hi))) => Wavelengths::sample_uniform(u[4], lo, hi),
        };
        (self.scene.sensor.camera.ray(place, DVec2::new(u[2], u[3])), weight, λ, sampler)
    }
}
