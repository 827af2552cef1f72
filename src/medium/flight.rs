//! Free flights for all wavelengths of a path at once.
//!
//! A distance t that is drawn for one wavelength i has the density pᵢ(t), which suits the others badly: the
//! weight σⱼ exp(−σⱼ t)/pᵢ(t) of another wavelength is unbounded. Drawn for wavelength i with probability
//! cᵢ, t has the density Σ cᵢ pᵢ(t), and with it weights are bounded by 1/cⱼ (the balance heuristic; Wilkie
//! et al. 2014, "Hero Wavelength Spectral Sampling", and Miller, Georgiev and Jarosz 2019, "A null-scattering
//! path integral formulation of light transport").
//!
//! The cᵢ may be anything that the path knows. Here they are what the path carries: cᵢ = Tᵢ/ΣT, with the
//! throughput T. Then the sum of the throughputs after the flight,
//!
//! Σ Tⱼ fⱼ(t) / (Σ cᵢ pᵢ(t)) = ΣT · Σ Tⱼ fⱼ(t) / Σ Tᵢ pᵢ(t) ≤ ΣT, since fⱼ is pⱼ times an albedo,
//!
//! never exceeds that before, along any number of flights. Where extinction is all that tells wavelengths
//! apart the Tᵢ are in the ratios of the densities of the whole path, so this is the balance heuristic over
//! whole paths; beyond that it follows what surfaces and albedos leave. A lane that carries nothing needs no
//! density.

use crate::math::function::ln;
use crate::math::random::uniform;
use crate::sampler::Sampler;
use crate::spectrum::{Spectrum, Wavelengths};
use rand_pcg::Pcg32;

/// How likely each lane is to be the one that a distance is drawn for.
#[derive(Clone, Copy, Debug)]
pub struct Shares(Spectrum);

impl Shares {
    /// In proportion to what a path carries.
    pub fn of(carried: Spectrum, λ: &Wavelengths) -> Self {
        let counted = carried * λ.ones();
        // The largest first, so that no sum overflows and none is lost.
        let largest = counted.max();
        let scaled = counted.map(|v| v / largest);
        Self(if largest > 0.0 { scaled * (1.0 / scaled.sum()) } else { Spectrum::ZERO })
    }

    /// Shares after the throughput has been multiplied by `weight`.
    pub fn after(self, weight: Spectrum, λ: &Wavelengths) -> Self {
        Self::of(self.0 * weight, λ)
    }

    /// The mean of a quantity over lanes.
    #[inline]
    pub fn mean(self, of: Spectrum) -> f32 {
        (self.0 * of).sum()
    }

    /// The lane that a number in [0, 1) falls on, and the number rescaled to [0, 1) for reuse.
    #[inline]
    pub fn choose(self, u: f64) -> (usize, f64) {
        let mut rest = u;
        let mut chosen = (0, 0.0);
        for (lane, share) in self.0.0.into_iter().map(f64::from).enumerate() {
            if share == 0.0 {
                continue;
            }
            if rest < share {
                return (lane, rest / share);
            }
            rest -= share;
            // Rounding may leave a little beyond the last.
            chosen = (lane, crate::math::BELOW_ONE);
        }
        chosen
    }
}

/// The numbers for one flight, or for one shadow ray.
pub struct FlightNumbers<'a> {
    /// The first, if one is well spread over samples.
    first: Option<f64>,
    sampler: &'a Sampler,
    block: u32,
    /// Independent ones after it, if any were asked for.
    others: Option<Pcg32>,
}

impl<'a> FlightNumbers<'a> {
    /// Numbers of a block, after one that is well spread over samples.
    pub fn after(first: f64, sampler: &'a Sampler, block: u32) -> Self {
        Self { first: Some(first), ..Self::independent(sampler, block) }
    }

    /// Independent numbers of a block.
    pub fn independent(sampler: &'a Sampler, block: u32) -> Self {
        Self { first: None, sampler, block, others: None }
    }

    /// The next number in [0, 1).
    #[inline]
    pub fn draw(&mut self) -> f64 {
        if let Some(first) = self.first.take() {
            return first;
        }
        let others = self.others.get_or_insert_with(|| self.sampler.generator(self.block));
        uniform(others)
    }
}

/// The optical depth that a number in [0, 1) stands for: it is reached with probability 1 − u.
#[inline]
pub fn optical_depth(u: f64) -> f64 {
    -ln(1.0 - u)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::LANES;

    #[test]
    fn lanes_are_chosen_by_what_they_carry() {
        let λ = Wavelengths::sample_visible(0.3);
        let carried = Spectrum([0.0, 1.0, 0.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
        let shares = Shares::of(carried, &λ);
        let mut found = [0.0; LANES];
        const COUNT: usize = 1 << 14;
        for i in 0..COUNT {
            let (lane, rest) = shares.choose((i as f64 + 0.5) / COUNT as f64);
            assert!((0.0..1.0).contains(&rest));
            found[lane] += 8.0 / COUNT as f64;
        }
        assert_eq!(found.map(|v| v.round() as f32), carried.0);
        assert_eq!(shares.choose(crate::math::BELOW_ONE).0, 4);
        // Neither the size of what is carried nor what colours do not have counts.
        let large = Shares::of(carried * 1e30, &λ);
        assert!(large.0.0.iter().zip(shares.0.0).all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(Shares::of(Spectrum::ONE, &Wavelengths::rgb()).mean(Spectrum::ONE), 1.0);
        assert_eq!(Shares::of(Spectrum::ONE, &Wavelengths::rgb()).choose(0.999).0, 2);
        assert_eq!(Shares::of(Spectrum::ZERO, &λ).mean(Spectrum::ONE), 0.0);
    }
}
