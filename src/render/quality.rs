//! How well an image is known, from its pixels' variances.

use super::law::Law;
use super::light_path_noise::Excess;
use super::passes::Partial;
use super::squares::Squares;
use crate::film::Window;
use crate::image::{Attribute, Image, Provenance};
use crate::integrator::path::reuse::correlated_edge;
use crate::scene::Scene;
use crate::spectrum::ColorMode;
use std::collections::BTreeMap;
use std::ops::Range;

/// With fewer effective pixels than this, the noise is put down to a few outlier samples.
const FEW: f64 = 20.0;

/// The attribute of an image that says how many pixels shared what their paths found.
const REUSE: &str = "reuse";

/// The attribute of an image whose samples counted for several pixels; see [`Correlation::gain`].
const SPREAD: &str = "spread";

/// How errors of pixels depend on one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// Edge of the squares of the film beyond which no two pixels share paths: within these, errors may be
    /// correlated by however much.
    pub edge: u32,
    /// Variance of a sum of many pixels over the sum of their variances, where samples count for several
    /// pixels; otherwise 1. At borders of the film this is a little too much.
    pub gain: f64,
}

impl Correlation {
    pub const NONE: Self = Self { edge: 1, gain: 1.0 };

    /// That of the images of a scene.
    pub fn of(scene: &Scene) -> Self {
        let edge = correlated_edge(scene.integrator.reuse(), scene.mode);
        Self { edge, gain: scene.sensor.film.correlation(1) }
    }

    /// That which an image tells: at least as much as there is, for it does not say whether it was rendered
    /// in spectra.
    pub fn told(provenance: Option<&Provenance>) -> Self {
        let attribute = |name| provenance.and_then(|provenance| provenance.extra.get(name));
        let pixels = if let Some(Attribute::Integer(pixels)) = attribute(REUSE) { *pixels as u32 } else { 1 };
        let gain = if let Some(Attribute::Real(gain)) = attribute(SPREAD) { f64::from(*gain) } else { 1.0 };
        Self { edge: correlated_edge(pixels.max(1), ColorMode::Spectral), gain }
    }

    /// What an image of the scene tells.
    pub fn attributes(scene: &Scene) -> BTreeMap<String, Attribute> {
        let mut attributes = BTreeMap::new();
        if scene.integrator.reuse() > 1 {
            attributes.insert(REUSE.into(), Attribute::Integer(scene.integrator.reuse() as i32));
        }
        if scene.sensor.film.spread.is_some() {
            attributes.insert(SPREAD.into(), Attribute::Real(scene.sensor.film.correlation(1) as f32));
        }
        attributes
    }
}

/// The image's mean and how well it is known, over its first three channels, or as many as it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Mean of each channel; 0 of one that the image does not have.
    pub mean: [f64; 3],
    /// Root mean square over pixels of the standard error, relative to the absolute value of the image's
    /// mean.
    pub relative_standard_error: f64,
    /// Standard error of the image's mean, relative to its absolute value.
    pub relative_standard_error_of_mean: f64,
    /// How many pixels, were they all alike, would make as uncertain a variance: (Σ v)²/Σ v². Of pixels that
    /// share, how many squares of them; of samples that count for several, how many pixels had them alone. What light
    /// paths give pixels in common counts with its own uncertainty.
    pub effective_pixels: f64,
    /// That number, if all were alike.
    pub pixels: usize,
    /// Variance of the estimated variance of the image's mean, relative to its square.
    pub uncertainty: f64,
    /// By what law the variance of the image's mean falls; `None` of an image that says no more than the variances of
    /// its pixels, from which follows the most that it can be.
    pub law: Option<Law>,
    /// The share of that variance which falls by the law; the rest falls as with independent samples.
    pub by_law: f64,
}

/// Sums over pixels from which a [`Quality`] follows; those of parts of a window whose borders cut no square
/// of correlated pixels add up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Number of channels that are summed over.
    channels: usize,
    sum: [f64; 3],
    /// Sum of the variances of pixels.
    variance: f64,
    /// Largest variance that the sum of pixels can have: the sum of those of squares of correlated pixels.
    of_sum: f64,
    /// Sum of the squared variances of those squares.
    fourth: f64,
    /// Number of squares that are independent.
    squares: f64,
}

impl Noise {
    /// Sums up values and variances of the pixels of a window, channel by channel; of more than three
    /// channels the first three.
    pub fn of<C, V>(window: Window, Correlation { edge, gain }: Correlation, channels: C) -> Self
    where
        C: IntoIterator<Item = V>,
        V: IntoIterator<Item = (f64, f64)>,
    {
        let squares_of_film = Squares::of(window, edge);
        let count = squares_of_film.count();
        let mut noise = Self { squares: count as f64 / gain, ..Self::default() };
        // The variance of a sum is at most the square of the sum of standard errors; for squares of one pixel
        // it is just that.
        let mut squares = vec![0.0; count];
        for (sum, channel) in noise.sum.iter_mut().zip(channels) {
            noise.channels += 1;
            let mut deviations = vec![0.0; count];
            for (i, (value, v)) in channel.into_iter().enumerate() {
                *sum += value;
                noise.variance += v;
                deviations[squares_of_film.index_of(window.pixel(i))] += v.sqrt();
            }
            squares.iter_mut().zip(&deviations).for_each(|(sum, deviation)| *sum += deviation * deviation);
        }
        noise.of_sum = gain * squares.iter().sum::<f64>();
        // Alike as errors of neighbours are, so are estimates of their variances.
        noise.fourth = gain * squares.iter().map(|v| (gain * v) * (gain * v)).sum::<f64>();
        noise
    }

    pub fn add(&mut self, other: &Self) {
        self.channels = self.channels.max(other.channels);
        self.sum.iter_mut().zip(other.sum).for_each(|(sum, more)| *sum += more);
        self.variance += other.variance;
        self.of_sum += other.of_sum;
        self.fourth += other.fourth;
        self.squares += other.squares;
    }

    /// What is known of the pixels of a window and of their mean: from its law, if that is known, and else from the
    /// most that it can be by the variances of pixels. What these have in common by light paths comes to it, and its
    /// uncertainty is at worst together with theirs.
    pub fn quality(
        &self,
        window: Window,
        law: Option<(Law, Range<u64>)>,
        Excess { of_sum: common, deviation }: Excess,
    ) -> Quality {
        let pixels = window.pixels();
        let channels = self.channels as f64;
        let mean = self.sum.map(|sum| sum / pixels as f64);
        // Properties of what is seen, unlike light, may be negative.
        let scale = mean.iter().sum::<f64>().abs() / channels;
        // No more than there are, however well known it is what they have in common.
        let (most, fourth) = (self.of_sum + common, self.fourth.sqrt() + deviation);
        let effective_pixels =
            if fourth > 0.0 { (most * most / (fourth * fourth)).min(self.squares) } else { self.squares };
        let (of_sum, uncertainty, by_law) = match &law {
            None => (most, 1.0 / effective_pixels, 0.0),
            Some((law, samples)) => {
                let v = law.variance(samples);
                let relative = |part: f64| if v + common > 0.0 { part / (v + common) } else { 0.0 };
                let together = relative(v * law.uncertainty.sqrt() + deviation);
                (v + common, together * together, relative(v))
            }
        };
        Quality {
            mean,
            relative_standard_error: (self.variance / pixels as f64 / channels).sqrt() / scale,
            relative_standard_error_of_mean: (of_sum / channels).sqrt() / pixels as f64 / scale,
            effective_pixels,
            pixels: self.squares.round() as usize,
            uncertainty,
            law: law.map(|(law, _)| law),
            by_law,
        }
    }
}

impl Quality {
    /// The quality of pixels with these values and variances; see [`Noise::of`].
    pub fn new<C, V>(window: Window, correlation: Correlation, channels: C) -> Self
    where
        C: IntoIterator<Item = V>,
        V: IntoIterator<Item = (f64, f64)>,
    {
        Noise::of(window, correlation, channels).quality(window, None, Excess::default())
    }

    /// The quality of an image; without variances nothing is known, and the errors are infinite.
    pub fn of_image(image: &Image) -> Self {
        let channels = image.channels.iter().map(|channel| {
            let variance = |i: usize| channel.variance.as_ref().map_or(f64::INFINITY, |v| f64::from(v[i]));
            channel.mean.iter().enumerate().map(move |(i, &mean)| (f64::from(mean), variance(i)))
        });
        Self::new(image.crop, Correlation::told(image.provenance.as_ref()), channels)
    }

    /// The quality of what is rendered so far.
    pub fn of(partial: &Partial, scene: &Scene, window: Window) -> Self {
        let samples = partial.samples.end - partial.samples.start;
        let channels = (0..partial.channels.len())
            .map(|c| partial.sums.channel(c).map(move |s| (s.mean(samples), s.variance(samples))));
        let noise = Noise::of(window, Correlation::of(scene), channels);
        let light_paths = samples * u64::from(scene.techniques.light_paths());
        let common = match light_paths {
            0 => Excess::default(),
            _ => partial.light_paths.excess(light_paths, samples),
        };
        noise.quality(window, Law::of_render(scene, partial.history.as_ref(), &partial.samples), common)
    }

    /// The variance of the image's mean after other samples, the first so many, over that after these.
    pub fn growth(&self, from: &Range<u64>, samples: u64) -> f64 {
        let independent = (from.end - from.start) as f64 / samples as f64;
        let by_law = self.law.map_or(independent, |law| law.variance(&(0..samples)) / law.variance(from));
        if self.by_law > 0.0 { self.by_law * by_law + (1.0 - self.by_law) * independent } else { independent }
    }

    /// Whether a few pixels hold most of the variance, so that the error is likely underestimated.
    pub fn heavy_tailed(&self) -> bool {
        self.effective_pixels < FEW && self.effective_pixels < self.pixels as f64 / 8.0
    }
}

#[cfg(test)]
mod tests;
