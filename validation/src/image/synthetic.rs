//! Synthetic images with known truth, for the tests of this module.

use super::{Channel, Image};
use crate::statistics::{Estimate, Stream};

/// The distribution of a sample with mean 1.
#[derive(Clone, Copy, Debug)]
pub enum Noise {
    /// Normal, with standard deviation 1.
    Normal,
    /// Exponential, with standard deviation 1 and skewness 2.
    Exponential,
    /// 20 with probability 1/40, else 20/39, as of a light that is rarely hit; standard deviation 3, skewness
    /// 6.
    Firefly,
    /// 13 with probability 1/128, else 115/127, as of a lamp's edge in a block of few samples; standard deviation 1.1.
    Edge,
    /// Log-normal, with a deviation of 2.5 of the logarithm: the standard deviation is 23, and half of all
    /// light comes by one sample in 160.
    Lognormal,
    /// Even from 0.79 to 1.19, but 300 more once in 30 000 samples: the standard deviation is 1.7.
    Spark,
}

impl Noise {
    pub fn sample(self, stream: &mut Stream) -> f64 {
        match self {
            Noise::Normal => 1.0 + stream.normal(),
            Noise::Exponential => stream.exponential(),
            Noise::Firefly => {
                if stream.uniform() < 0.025 {
                    20.0
                } else {
                    20.0 / 39.0
                }
            }
            Noise::Edge => {
                if stream.uniform() < 1.0 / 128.0 {
                    13.0
                } else {
                    115.0 / 127.0
                }
            }
            Noise::Lognormal => libm::exp(2.5 * stream.normal() - 3.125),
            Noise::Spark => {
                let spark = if stream.uniform() < 1.0 / 30_000.0 { 300.0 } else { 0.0 };
                0.79 + 0.4 * stream.uniform() + spark
            }
        }
    }
}

/// An image of one channel `Y` with the same variance everywhere.
pub fn grey(width: usize, mean: &[f64], variance: f64) -> Image {
    let channel =
        Channel { name: "Y".into(), mean: mean.to_vec(), variance: Some(vec![variance; mean.len()]) };
    Image { width, height: mean.len() / width, channels: vec![channel] }
}

/// `scene` rendered with normal noise that a filter of these weights has spread along rows and columns, and with the
/// right variances of pixels.
pub fn filtered(width: usize, scene: &[f64], weights: &[f64], name: &str, number: u64) -> Image {
    let mut stream = Stream::named(name, number);
    let height = scene.len() / width;
    let noise: Vec<f64> = scene.iter().map(|_| stream.normal()).collect();
    let spread = |noise: &[f64], step: usize, index: usize, at: usize, count: usize| -> f64 {
        let taps = (0..weights.len()).map(|k| (at + count + k - weights.len() / 2) % count);
        taps.zip(weights).map(|(there, weight)| weight * noise[index - at * step + there * step]).sum()
    };
    let along: Vec<f64> = (0..noise.len()).map(|i| spread(&noise, 1, i, i % width, width)).collect();
    let both = (0..noise.len()).map(|i| spread(&along, width, i, i / width, height));
    let mean: Vec<f64> = scene.iter().zip(both).map(|(mean, noise)| mean + 0.1 * noise).collect();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    grey(width, &mean, 0.01 * squares * squares)
}

/// `scene` rendered with `samples` samples per pixel and estimated variances; `name` and `number` determine
/// the seed.
pub fn render(width: usize, scene: &[f64], noise: Noise, samples: usize, name: &str, number: u64) -> Image {
    let mut stream = Stream::named(name, number);
    let mut image = grey(width, scene, 0.0);
    let mut variances = Vec::new();
    for mean in &mut image.channels[0].mean {
        let estimate = Estimate::of((0..samples).map(|_| *mean * noise.sample(&mut stream)));
        *mean = estimate.mean;
        variances.push(estimate.variance);
    }
    image.channels[0].variance = Some(variances);
    image
}
