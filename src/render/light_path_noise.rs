//! What errors of pixels have in common because one light path reaches several of them.
//!
//! Let a light path bring sₚ to pixel p, and T = Σₚ sₚ to the image. With ⟨⟩ for expectations, it adds
//! ⟨T²⟩ − ⟨T⟩² to the variance of the sum over pixels, and to those of the pixels ⟨sₚ²⟩ − ⟨sₚ⟩² each. Their sum
//! falls short of the former by ⟨T² − Σₚ sₚ²⟩ − ⟨T⟩², but for Σₚ ⟨sₚ⟩², which is small against ⟨T⟩² where no
//! pixel gets much of all light. Means over all light paths estimate both terms.

use serde::{Deserialize, Serialize};

/// Sums over light paths, of the first three channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightPathNoise {
    /// Of T.
    #[serde(with = "super::bits")]
    sum: [f64; 3],
    /// Of T² − Σₚ sₚ².
    #[serde(with = "super::bits")]
    common: [f64; 3],
    /// Of (T² − Σₚ sₚ²)².
    #[serde(with = "super::bits")]
    squares: [f64; 3],
}

/// By how much the variance of the sum over pixels exceeds the sum of their variances, summed over channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    pub of_sum: f64,
    /// Standard deviation of that estimate: channels see the same light paths, so theirs add up.
    pub deviation: f64,
}

impl LightPathNoise {
    /// Adds a light path by what it brings to each pixel that it reaches.
    fn add_path<'a>(&mut self, brought: impl Iterator<Item = &'a [f64; 3]>) {
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for pixel in brought {
            for c in 0..3 {
                sum[c] += pixel[c];
                squares[c] += pixel[c] * pixel[c];
            }
        }
        for c in 0..3 {
            let common = sum[c] * sum[c] - squares[c];
            self.sum[c] += sum[c];
            self.common[c] += common;
            self.squares[c] += common * common;
        }
    }

    /// Adds other light paths.
    pub fn add(&mut self, other: &Self) {
        self.sum.iter_mut().zip(other.sum).for_each(|(sum, more)| *sum += more);
        self.common.iter_mut().zip(other.common).for_each(|(sum, more)| *sum += more);
        self.squares.iter_mut().zip(other.squares).for_each(|(sum, more)| *sum += more);
    }

    /// What errors have in common, if these are the sums over so many light paths, and the pixels are means over so
    /// many samples.
    ///
    /// Where light paths rarely reach two pixels it is negative: the more of them go to one pixel, the fewer go
    /// to others. Such channels are left out, so that no error is underestimated.
    pub fn excess(&self, light_paths: u64, samples: u64) -> Excess {
        let (mut of_sum, mut deviation) = (0.0, 0.0);
        for c in 0..3 {
            let excess = self.common[c] - self.sum[c] * self.sum[c] / light_paths as f64;
            if excess > 0.0 {
                (of_sum, deviation) = (of_sum + excess, deviation + self.squares[c].sqrt());
            }
        }
        let scale = 1.0 / (samples as f64 * samples as f64);
        Excess { of_sum: of_sum * scale, deviation: deviation * scale }
    }
}

/// Collects the noise of light paths, sample by sample, from their contributions as these arrive.
#[derive(Debug, Default)]
pub struct Collector {
    /// Of each sample whose light paths have contributed.
    of_samples: Vec<LightPathNoise>,
    /// Number of the last sample and of its last light path.
    last: Option<(u64, u64)>,
    /// The pixels that this light path has reached, and what it has brought to each.
    pixels: Vec<u32>,
    brought: Vec<[f64; 3]>,
}

impl Collector {
    /// Notes a contribution of a light path to a pixel. Those of one path must come together, and so must those
    /// of one sample.
    pub fn note(&mut self, sample: u64, light_path: u64, pixel: u32, channels: &[f64]) {
        if self.last != Some((sample, light_path)) {
            self.end_path();
            if self.last.is_none_or(|(last, _)| last != sample) {
                self.of_samples.push(LightPathNoise::default());
            }
            self.last = Some((sample, light_path));
        }
        let at = self.pixels.iter().position(|known| *known == pixel).unwrap_or_else(|| {
            self.pixels.push(pixel);
            self.brought.push([0.0; 3]);
            self.brought.len() - 1
        });
        self.brought[at].iter_mut().zip(channels).for_each(|(sum, value)| *sum += value);
    }

    /// The noise of each sample, in the order in which they came.
    pub fn finish(mut self) -> Vec<LightPathNoise> {
        self.end_path();
        self.of_samples
    }

    fn end_path(&mut self) {
        if let Some(noise) = self.of_samples.last_mut() {
            noise.add_path(self.brought.iter());
        }
        self.pixels.clear();
        self.brought.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::{Pcg32, rand_core::Rng};

    /// Light paths that reach few of many pixels, several at a time: the variance of the sum over pixels is that
    /// of the pixels and the excess.
    #[test]
    fn the_excess_is_what_pixels_do_not_know_of_each_other() {
        const PIXELS: u32 = 64;
        let mut rng = Pcg32::new(0, 1);
        let mut uniform = || f64::from(rng.next_u32()) / 4294967296.0;
        let (paths, samples) = (1 << 16, 16);
        const SAMPLE: u64 = (1 << 16) / 16;
        let mut collector = Collector::default();
        let mut squares = 0.0;
        let mut moments = vec![[0.0; 2]; PIXELS as usize];
        let mut sum = 0.0;
        for number in 0..paths {
            let mut total = 0.0;
            let mut of_pixels = [0.0; PIXELS as usize];
            if uniform() < 0.25 {
                for _ in 0..4 {
                    let (pixel, value) = ((uniform() * f64::from(PIXELS)) as u32, uniform());
                    collector.note(number / SAMPLE, number, pixel, &[value, 0.0, 0.0, 1.0]);
                    of_pixels[pixel as usize] += value;
                    total += value;
                }
            }
            for (moments, value) in moments.iter_mut().zip(of_pixels) {
                moments[0] += value;
                moments[1] += value * value;
            }
            (sum, squares) = (sum + total, squares + total * total);
        }
        let mut noise = LightPathNoise::default();
        let of_samples = collector.finish();
        of_samples.iter().for_each(|of_sample| noise.add(of_sample));
        assert_eq!(of_samples.len(), samples as usize);
        let n = paths as f64;
        let variance = |sum: f64, squares: f64| (squares - sum * sum / n) / 256.0;
        let of_pixels: f64 = moments.iter().map(|[sum, squares]| variance(*sum, *squares)).sum();
        let of_sum = variance(sum, squares);
        let excess = noise.excess(paths, samples);
        let told = of_pixels + excess.of_sum;
        assert!(
            (told / of_sum - 1.0).abs() < 0.01 && of_pixels < 0.5 * of_sum,
            "{told} {of_sum} {of_pixels}"
        );
        // c = T² − Σ s² of a quarter of the paths: √⟨c²⟩ is 3.52 times ⟨c⟩ − ⟨T⟩² (by 4·10⁵ draws of these).
        let relative = excess.deviation / excess.of_sum * n.sqrt();
        assert!((relative / 3.52 - 1.0).abs() < 0.1, "{relative}");
    }

    #[test]
    fn paths_that_reach_one_pixel_each_have_nothing_in_common() {
        let mut collector = Collector::default();
        for number in 0..100 {
            collector.note(number / 25, number, number as u32 % 7, &[1.0, 2.0, 3.0]);
            collector.note(number / 25, number, number as u32 % 7, &[1.0, 2.0, 3.0]);
        }
        let of_samples = collector.finish();
        assert_eq!(of_samples.len(), 4);
        assert!(of_samples.iter().all(|noise| noise.excess(25, 1) == Excess { of_sum: 0.0, deviation: 0.0 }));
    }
}
