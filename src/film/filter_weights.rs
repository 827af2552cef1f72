//! Filters splatted instead of sampled: a sample counts for every pixel whose filter reaches its place.
//!
//! All pixels have their sample at the same ξ within them, so a pixel's filter f meets its own sample at
//! ξ − ½ from its middle and those of its neighbours at k + ξ − ½, k = ±1, ±2 …. With the density p of ξ,
//!
//!   Σₖ f(k + ξ − ½) L(k + ξ) / (p(ξ) ∫f)
//!
//! has the mean ∫f L / ∫f. If p(ξ) is Σₖ f(k + ξ − ½) / ∫f, which is 1 with tents and cubics and nearly so
//! with other filters, these weights sum to one, and where light is even, so is the picture.

use super::filter::Profile;
use super::filter_sampler::FilterSampler;

/// Parts of a pixel in each of which ξ has the same density.
const PARTS: usize = 1024;

/// How many pixels away a filter may reach.
const FARTHEST: usize = 4;

/// Weights of pixels side by side, as many before one as after it; those that are left over are zero.
pub type Weights = [f64; 2 * FARTHEST + 1];

/// One axis of a filter, for samples that count for all pixels that it reaches.
#[derive(Clone, Debug)]
pub struct FilterWeights {
    profile: Profile,
    reach: u32,
    /// Running sums of the probabilities of the parts.
    parts: Vec<f64>,
}

/// The place of all samples of a number along one axis of their pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// In [0, 1).
    pub ξ: f64,
    pub density: f64,
}

impl FilterWeights {
    /// None of a filter that reaches no other pixel, or too many, or leaves gaps between pixels.
    pub fn new(profile: Profile) -> Option<Self> {
        const GAP: f64 = 0.5;
        let reach = (profile.radius() - 0.5).ceil().max(0.0) as usize;
        if profile == Profile::Box || !(1..=FARTHEST).contains(&reach) {
            return None;
        }
        let mut this = Self { profile, reach: reach as u32, parts: vec![] };
        let sums: Vec<f64> = (0..PARTS).map(|part| this.values(middle(part)).iter().sum()).collect();
        let all: f64 = sums.iter().sum();
        if sums.iter().any(|sum| sum / all * (PARTS as f64) < GAP) {
            return None;
        }
        let below = sums.iter().scan(0.0, |below, sum| {
            *below += sum;
            Some(*below / all)
        });
        this.parts = std::iter::once(0.0).chain(below).collect();
        Some(this)
    }

    /// How many pixels away a sample may lie that the filter of a pixel reaches.
    pub fn reach(&self) -> u32 {
        self.reach
    }

    /// The place for a number in [0, 1).
    pub fn place(&self, u: f64) -> Place {
        let part = self.parts.partition_point(|below| *below <= u).clamp(1, PARTS) - 1;
        let probability = self.parts[part + 1] - self.parts[part];
        let within = ((u - self.parts[part]) / probability).clamp(0.0, 1.0 - f64::EPSILON);
        Place { ξ: (part as f64 + within) / PARTS as f64, density: probability * PARTS as f64 }
    }

    /// The weights of the samples around a pixel, which is in the middle. The film, where the filter ends,
    /// has `before` and `after` further pixels on each side; `sampler` is that of the same filter.
    pub fn at(&self, place: Place, sampler: &FilterSampler, (before, after): (u32, u32)) -> Weights {
        let all = place.density * sampler.integral(before, after);
        let reach = self.reach as usize;
        let mut weights = self.values(place.ξ);
        for (i, weight) in weights.iter_mut().enumerate().take(2 * reach + 1) {
            let on_film = i + before as usize >= reach && i <= reach + after as usize;
            *weight = if on_film { *weight / all } else { 0.0 };
        }
        weights
    }

    /// The variance of the mean of so many pixels side by side, times their number, if that of each sample is one: the
    /// mean of Σ wᵢ wⱼ (1 − |i − j|/`pixels`), which for one pixel is the sum of squared weights, and for many one.
    pub fn squares(&self, sampler: &FilterSampler, pixels: u32) -> f64 {
        let of = |part: usize| {
            let place = self.place(0.5 * (self.parts[part] + self.parts[part + 1]));
            let weights = self.at(place, sampler, (u32::MAX, u32::MAX));
            let of_pair = |i: usize, j: usize| {
                let pixels = f64::from(pixels);
                weights[i] * weights[j] * (1.0 - i.abs_diff(j) as f64 / pixels).max(0.0)
            };
            let pairs = (0..weights.len()).flat_map(|i| (0..weights.len()).map(move |j| (i, j)));
            pairs.map(|(i, j)| of_pair(i, j)).sum::<f64>() * place.density / PARTS as f64
        };
        (0..PARTS).map(of).sum()
    }

    /// The filter at places ξ of neighbouring pixels.
    fn values(&self, ξ: f64) -> Weights {
        let reach = self.reach as usize;
        let mut values = Weights::default();
        for (i, value) in values.iter_mut().enumerate().take(2 * reach + 1) {
            *value = self.profile.eval(i as f64 - reach as f64 + ξ - 0.5);
        }
        values
    }
}

fn middle(part: usize) -> f64 {
    (part as f64 + 0.5) / PARTS as f64
}

#[cfg(test)]
mod tests {
    use super::super::filter::ALL;
    use super::*;

    const MANY: (u32, u32) = (u32::MAX, u32::MAX);

    fn all() -> impl Iterator<Item = (FilterWeights, FilterSampler)> {
        let odd = [Profile::Tent { radius: 0.77 }, Profile::Gaussian { deviation: 0.7 }];
        let profiles = [ALL.as_slice(), &odd].concat();
        profiles.into_iter().filter_map(|profile| {
            FilterWeights::new(profile).map(|weights| (weights, FilterSampler::new(profile)))
        })
    }

    #[test]
    fn filters_of_one_pixel_and_those_with_gaps_are_left_out() {
        assert_eq!(all().count(), 7);
        for profile in [
            Profile::Box,
            Profile::Tent { radius: 0.5 },
            Profile::Tent { radius: 0.55 },
            Profile::Gaussian { deviation: 0.2 },
            Profile::Lanczos { lobes: 5.0 },
        ] {
            assert!(FilterWeights::new(profile).is_none(), "{profile:?}");
        }
    }

    #[test]
    fn weights_sum_to_one() {
        for (weights, sampler) in all() {
            for i in 0..1000 {
                let place = weights.place(f64::from(i) / 1000.0);
                let sum: f64 = weights.at(place, &sampler, MANY).iter().sum();
                // What the density changes within one of its parts.
                assert!((sum - 1.0).abs() < 1e-3, "{:?} {sum}", weights.profile);
            }
        }
    }

    #[test]
    fn even_light_and_a_slope_are_as_the_filter_sees_them() {
        for (weights, sampler) in all() {
            for (before, after) in [(100, 100), (0, 100), (1, 0), (0, 0), (2, 1)] {
                // The mean of the place under the filter, by sampling.
                const N: u32 = 100_000;
                let (mut sum, mut moment, mut expected) = (0.0, 0.0, 0.0);
                for i in 0..N {
                    let u = (f64::from(i) + 0.5) / f64::from(N);
                    let place = weights.place(u);
                    let (x, weight) = sampler.sample(u, before, after);
                    expected += weight * x / f64::from(N);
                    let at = weights.at(place, &sampler, (before, after));
                    for (k, weight) in (-(weights.reach as i32)..).zip(at) {
                        sum += weight / f64::from(N);
                        moment += weight * (f64::from(k) + place.ξ - 0.5) / f64::from(N);
                    }
                }
                let of = (weights.profile, before, after);
                assert!((sum - 1.0).abs() < 1e-4, "{of:?} {sum}");
                assert!((moment - expected).abs() < 1e-4, "{of:?} {moment} {expected}");
            }
        }
    }

    #[test]
    fn squares_are_those_of_tent_and_gaussian() {
        let squares = |profile: Profile| {
            FilterWeights::new(profile).map(|weights| weights.squares(&FilterSampler::new(profile), 1))
        };
        // ∫f² = ⅔ of a tent; 1/(2σ√π) of a gaussian, but for its missing foot.
        let tent = squares(Profile::Tent { radius: 1.0 });
        assert!(tent.is_some_and(|sum| (sum - 2.0 / 3.0).abs() < 1e-5), "{tent:?}");
        let gaussian = squares(Profile::Gaussian { deviation: 0.5 });
        let expected = 1.0 / std::f64::consts::PI.sqrt();
        assert!(gaussian.is_some_and(|sum| (sum / expected - 1.0).abs() < 2e-3), "{gaussian:?}");
    }
}
