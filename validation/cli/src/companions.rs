//! A material at one wavelength, on paths that carry seven other wavelengths.

use crate::materials::{HERO, Subject};
use etalon::bsdf::{AnyBsdf, Bsdf};
use etalon::math::DVec2;
use etalon::spectrum::{LANES, Wavelengths};
use validation::scatterer::DVec3;
use validation::{Laws, Sample, Scatterer};

/// Wavelengths of a path: the subject's in each lane in turn, with the same others.
pub type Company = [Wavelengths; LANES];

/// Companies of the other wavelengths that a path draws, and of wavelengths from all of the range.
pub fn companies() -> [Company; 2] {
    let drawn = Wavelengths::sample_visible(HERO);
    let mut strange = drawn;
    for lane in 1..LANES {
        let other = Wavelengths::sample_visible((HERO + 0.618 * lane as f64).fract());
        take(&mut strange, lane, &other, 0);
    }
    [drawn, strange].map(|company| std::array::from_fn(|by| turned(&company, by)))
}

/// Copies lane `from` of `other` to lane `to`.
fn take(λ: &mut Wavelengths, to: usize, other: &Wavelengths, from: usize) {
    (λ.nm[to], λ.pdf[to], λ.d65[to]) = (other.nm[from], other.pdf[from], other.d65[from]);
    for (response, other) in λ.response.iter_mut().zip(other.response) {
        response[to] = other[from];
    }
}

/// Moves lane 0 to lane `by`, and all other lanes cyclically with it.
fn turned(λ: &Wavelengths, by: usize) -> Wavelengths {
    let mut turned = *λ;
    for lane in 0..LANES {
        take(&mut turned, (lane + by) % LANES, λ, lane);
    }
    turned
}

/// A subject in company: its wavelength's lane is drawn with each sample.
pub struct Companion<'a> {
    subject: &'a Subject,
    /// With the subject's wavelength in each lane.
    bsdfs: [AnyBsdf<'a>; LANES],
}

impl<'a> Companion<'a> {
    pub fn new(subject: &'a Subject, company: &'a Company) -> Self {
        Self { subject, bsdfs: std::array::from_fn(|lane| subject.at(&company[lane])) }
    }
}

impl Scatterer for Companion<'_> {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        let values = self.bsdfs.iter().enumerate();
        let values = values.map(|(lane, bsdf)| bsdf.evaluate(wo, wi).value.0[lane] as f64);
        // The values should be equal; one that differs by more than rounding shows in the mean.
        values.sum::<f64>() / LANES as f64
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.bsdfs[0].evaluate(wo, wi).pdf
    }

    /// A path's estimate is the mean over its lanes, so a wavelength's contribution is the mean over the
    /// lanes it may be in. The lane comes from the late digits of a number whose early digits determine the
    /// direction.
    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let lane = ((u[1] * (1u32 << 24) as f64).fract() * LANES as f64) as usize;
        let sample = self.bsdfs[lane].sample(wo, u[0], DVec2::new(u[1], u[2]))?;
        let weight = sample.weight.0[lane] as f64;
        Some(Sample { wi: sample.wi, weight, pdf: sample.pdf, delta: sample.delta })
    }

    fn laws(&self) -> Laws {
        self.subject.laws()
    }
}
