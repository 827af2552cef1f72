//! Images with known truth, for the tests of this module.

use super::{Channel, Image};
use crate::statistics::{Estimate, Stream};

/// The distribution of a sample whose mean is 1.
#[derive(Clone, Copy, Debug)]
pub enum Noise {
    /// Standard deviation 1.
    Normal,
    /// Standard deviation 1, skewness 2.
    Exponential,
    /// 20 with probability 1/40, else 20/39: a light seldom hit; standard deviation 3, skewness 6.
    Firefly,
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
        }
    }
}

/// One channel `Y` with the same variance everywhere.
pub fn grey(width: usize, mean: &[f64], variance: f64) -> Image {
    let channel =
        Channel { name: "Y".into(), mean: mean.to_vec(), variance: Some(vec![variance; mean.len()]) };
    Image { width, height: mean.len() / width, channels: vec![channel] }
}

/// `scene` seen through `samples` samples a pixel with estimated variances; `name` and `number` give the
/// seed.
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
