//! How well the mean of an image is known, and how that grows with the number of samples, from the scatter of
//! batches.
//!
//! Let v(m) be the variance of a square's mean over m samples whose numbers begin at a multiple of m, a power of two.
//! Of four such batches in a row with the means a, b, c, d
//!
//!   ⟨(a − b)²/2⟩ = ⟨(c − d)²/2⟩ = 2 (v(m) − v(2m)),   ⟨((a + b)/2 − (c + d)/2)²/2⟩ = 2 (v(2m) − v(4m)),
//!
//! whatever the batches know of each other, for (a + b)/2 has the variance v(2m). Sums of these over squares and
//! channels are W and H. If each doubling divides v by the same g, W/H is g, and the variance of all 4m samples is
//!
//!   v(4m) = H/(2 (g − 1)) = W/(2 g (g − 1)),
//!
//! of which the first is known from one difference a square and the second from two. Independent samples have g = 2,
//! stratified ones up to 4 and, of what is smooth, 8. As W/H is a ratio of noisy numbers, g is taken for as small as it
//! may well be (by `CAUTION` deviations), never for less than 2, and for 2 where few squares tell it (`VAGUE`): then
//! nothing is extrapolated, and v(4m) is the mean of H/2 and twice W/4, the scatter of four independent batches. So the
//! error is rather too large than too small.
//!
//! *Other numbers.* For more samples v falls by g, and for fewer it is taken to rise by as much as g may well be at most.
//! A number that is no power of two is a sum of such, whose batches are taken for independent, though those of a sequence
//! make up for each other: v(n) = Σ (m/n)² v(m), where v rises like that from the largest m downwards.
//!
//! *How sure this is.* Σ q² over the squares' shares q of a sum with k degrees of freedom each has the mean (1 + 2/k)
//! Σ v², and the variance of the sum is (2/k) Σ v²; heavy tails are seen in it.

use super::history::History;
use crate::scene::Scene;
use std::ops::Range;

/// By how many standard deviations the gain of a doubling is taken for smaller than it looks.
const CAUTION: f64 = 2.0;

/// Relative deviation of a gain beyond which it is not looked for: some fifty squares that are alike.
const VAGUE: f64 = 0.25;

/// What a doubling of the samples divides the variance by at least: that of independent ones.
const INDEPENDENT: f64 = 2.0;

/// That of an integrand with steps and of one that looks like one, where more is not known.
const STEPS: f64 = 4.0;

/// At most: that of a smooth integrand with scrambled nets (Owen, "Scrambled Net Variance for Integrals of Smooth
/// Functions", Annals of Statistics 25(4), 1997).
const SMOOTH: f64 = 8.0;

/// Fewer batches of the whole image than this say nothing of what all of it has in common.
const FEWEST: usize = 4;

/// How the variance of the sum over pixels falls with the number of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// So many samples, a power of two,
    samples: u64,
    /// have a mean with this variance, summed over channels.
    of_sum: f64,
    /// What each doubling divides it by, at least.
    pub gain: f64,
    /// What each halving multiplies it by, at most.
    pub loss: f64,
    /// Standard deviation of the gain, relative to it; none of a gain that is not looked for.
    pub gain_deviation: f64,
    /// Variance of the estimated variance, relative to its square.
    pub uncertainty: f64,
}

/// What is known of samples before they are looked at.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Whether they know of each other.
    pub stratified: bool,
    /// Variance of a sum of squares over the sum of theirs: more than one where samples count for several pixels.
    pub correlation: f64,
}

impl Known {
    pub fn of(scene: &Scene, history: &History) -> Self {
        let correlation = scene.sensor.film.correlation(history.edge());
        Self { stratified: scene.sensor.sampler.kind.stratifies(), correlation }
    }
}

/// A sum over squares of what each shares in it, by so many degrees of freedom.
struct Total {
    sum: f64,
    /// Its variance, relative to its square.
    uncertainty: f64,
}

impl Total {
    fn of(shares: impl Iterator<Item = f64>, degrees: f64) -> Self {
        let (sum, squares) = shares.fold((0.0, 0.0), |(sum, squares), q| (sum + q, squares + q * q));
        let uncertainty = if sum == 0.0 { 0.0 } else { 2.0 / (2.0 + degrees) * squares / (sum * sum) };
        Self { sum, uncertainty }
    }
}

impl Law {
    /// That of a render, with the samples that it has.
    pub fn of_render(
        scene: &Scene,
        history: Option<&History>,
        samples: &Range<u64>,
    ) -> Option<(Self, Range<u64>)> {
        let law = history.and_then(|history| Self::of(history, samples, Known::of(scene, history)));
        law.map(|law| (law, samples.clone()))
    }

    /// From the longest four batches in a row among these samples; `None` if there are no two.
    pub fn of(history: &History, samples: &Range<u64>, known: Known) -> Option<Self> {
        let longest = samples.end.checked_sub(samples.start)?.checked_ilog2()?;
        let aligned = |log: u32| {
            let begin = samples.start.next_multiple_of(1 << log);
            (begin + (1 << log) <= samples.end).then(|| begin..begin + (1 << log))
        };
        let all = (0..=longest).rev().find_map(aligned)?;
        let law =
            Self::of_quarters(history, &all, known).or_else(|| Self::of_halves(history, &all, known))?;
        Some(law.with_common(history, known.correlation))
    }

    fn of_halves(history: &History, all: &Range<u64>, known: Known) -> Option<Self> {
        let [a, b] = parts(history, all)?;
        let total = Total::of(a.iter().zip(&b).map(|(a, b)| scatter(a, b)), 1.0);
        Some(Self {
            samples: all.end - all.start,
            of_sum: total.sum / 2.0,
            gain: INDEPENDENT,
            loss: if known.stratified { STEPS } else { INDEPENDENT },
            gain_deviation: 0.0,
            uncertainty: total.uncertainty,
        })
    }

    fn of_quarters(history: &History, all: &Range<u64>, known: Known) -> Option<Self> {
        let [a, b, c, d] = parts(history, all)?;
        let middle = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        let squares = || a.iter().zip(&b).zip(c.iter().zip(&d));
        let within = || squares().map(|((a, b), (c, d))| 0.5 * (scatter(a, b) + scatter(c, d)));
        let between = || squares().map(|((a, b), (c, d))| scatter(&middle(a, b), &middle(c, d)));
        let (w, h) = (within().sum::<f64>(), between().sum::<f64>());
        // Were they independent: of V squares that are alike H has V degrees of freedom, W two, and both three times as
        // many. Together they tell V; H alone would look certain of too little where it is small by chance.
        let together = Total::of(within().zip(between()).map(|(w, h)| w + h), 3.0);
        let deviation = (3.0 * 1.5 * together.uncertainty).sqrt();
        let (least, most) = (1.0 / (1.0 + CAUTION * deviation), 1.0 + CAUTION * deviation);
        let [gain, loss] = match known.stratified {
            false => [INDEPENDENT, INDEPENDENT],
            true if h > 0.0 && deviation <= VAGUE => [w / h * least, w / h * most],
            true => [INDEPENDENT, STEPS],
        };
        let [gain, loss] = [gain, loss].map(|factor| factor.clamp(INDEPENDENT, SMOOTH));
        let total = Total::of(within().zip(between()).map(|(w, h)| h + 2.0 * w / gain), 3.0);
        let gain_deviation = if gain > INDEPENDENT { deviation } else { 0.0 };
        let by_gain = (gain / (gain - 1.0) + 2.0 / 3.0) * gain_deviation;
        Some(Self {
            samples: all.end - all.start,
            of_sum: total.sum / (6.0 * (gain - 1.0)),
            gain,
            loss,
            gain_deviation,
            uncertainty: total.uncertainty + by_gain * by_gain,
        })
    }

    /// With what squares have in common: as much as `correlation` says, or more if the means of the whole image
    /// scatter more.
    fn with_common(self, history: &History, correlation: f64) -> Self {
        if correlation == 1.0 {
            return self;
        }
        let batches: Option<Vec<_>> = history.batches().map(|batch| history.means(batch)).collect();
        let (of_all, of_squares, count) = batches.map_or((0.0, 0.0, 0), |batches| {
            let whole: Vec<_> = batches.iter().map(|squares| vec![sum(squares)]).collect();
            (scatters(&whole), scatters(&batches), batches.len())
        });
        let (seen, degrees) = (of_all / of_squares, count as f64 - 1.0);
        if count < FEWEST || seen.is_nan() || seen <= correlation {
            return Self { of_sum: correlation * self.of_sum, ..self };
        }
        if seen <= correlation * (1.0 + CAUTION * (2.0 / degrees).sqrt()) {
            let uncertainty = self.uncertainty + 2.0 / degrees;
            return Self { of_sum: seen * self.of_sum, uncertainty, ..self };
        }
        // What all squares share is one number, and no law can be read from it.
        let of_sum = of_all * history.length() as f64 / self.samples as f64;
        let uncertainty = 2.0 / degrees;
        Self { of_sum, gain: INDEPENDENT, loss: INDEPENDENT, gain_deviation: 0.0, uncertainty, ..self }
    }

    /// The variance, summed over channels, of the mean of the sum over pixels after these samples.
    pub fn variance(&self, samples: &Range<u64>) -> f64 {
        let count = (samples.end - samples.start) as f64;
        let largest = pieces(samples).max().unwrap_or(1);
        let factor = if largest < self.samples { self.loss } else { 1.0 / self.gain };
        let of_largest = self.of_sum * power(factor, largest.ilog2().abs_diff(self.samples.ilog2()));
        // What a smaller piece loses is as uncertain, whatever the samples that were looked at.
        let of_piece = |piece: u64| {
            let share = piece as f64 / count;
            share * share * power(self.loss, largest.ilog2() - piece.ilog2())
        };
        of_largest * pieces(samples).map(of_piece).sum::<f64>()
    }

    /// Variance of the estimated variance after so many samples, relative to its square: doublings beyond those that
    /// were looked at are as uncertain as their gain.
    pub fn uncertainty_after(&self, samples: u64) -> f64 {
        let doublings = samples.div_ceil(self.samples).next_power_of_two().ilog2();
        let by_gain = f64::from(doublings) * self.gain_deviation;
        self.uncertainty + by_gain * by_gain
    }
}

/// The lengths of the longest powers of two, each beginning at a multiple of itself, that samples consist of.
fn pieces(samples: &Range<u64>) -> impl Iterator<Item = u64> + use<> {
    let (mut at, end) = (samples.start, samples.end);
    std::iter::from_fn(move || {
        let longest = 1 << end.checked_sub(at)?.checked_ilog2()?;
        let piece = if at == 0 { longest } else { longest.min(1 << at.trailing_zeros()) };
        at += piece;
        Some(piece)
    })
}

fn power(factor: f64, exponent: u32) -> f64 {
    (0..exponent).fold(1.0, |power, _| power * factor)
}

/// The means of N parts of equal length, of all squares.
fn parts<const N: usize>(history: &History, all: &Range<u64>) -> Option<[Vec<[f64; 3]>; N]> {
    let length = (all.end - all.start) / N as u64;
    let part = |i: u64| (length > 0).then(|| all.start + i * length..all.start + (i + 1) * length);
    let means: Option<Vec<_>> = (0..N as u64).map(|i| history.means(part(i)?)).collect();
    means?.try_into().ok()
}

/// The variance of one of two values, estimated from both and summed over channels.
fn scatter(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| 0.5 * (a[i] - b[i]) * (a[i] - b[i])).sum()
}

/// The variance of a batch, estimated from all batches and summed over channels and squares.
fn scatters(batches: &[Vec<[f64; 3]>]) -> f64 {
    let count = batches.len() as f64;
    let of = |square: usize, c: usize| {
        let mean = batches.iter().map(|batch| batch[square][c]).sum::<f64>() / count;
        batches.iter().map(|batch| (batch[square][c] - mean) * (batch[square][c] - mean)).sum::<f64>()
    };
    let squares = batches.first().map_or(0, Vec::len);
    (0..squares).flat_map(|square| (0..3).map(move |c| (square, c))).map(|(q, c)| of(q, c)).sum::<f64>()
        / (count - 1.0)
}

fn sum(squares: &[[f64; 3]]) -> [f64; 3] {
    squares.iter().fold([0.0; 3], |sum, square| std::array::from_fn(|c| sum[c] + square[c]))
}

#[cfg(test)]
mod tests;
