//! A sum of floating-point numbers that does not depend on their order.
//!
//! After Demmel and Nguyen, "Parallel Reproducible Summation" (IEEE Transactions on Computers 64(7), 2015),
//! with integer instead of floating-point bins.
//!
//! The exponent axis of an f64 is divided, once and for all, into bins of 32 bits: bin `b` holds the bits
//! whose biased exponent lies in `32 b .. 32 b + 32`. A finite value is cut at the bin borders into at most
//! three integers below 2³², one a bin. The sum of all pieces that fall into a bin is kept in an `i64`, its
//! *limb*, and only for the four highest bins: the one that holds the leading bit of the largest magnitude
//! seen (`top`) and the three below it. Pieces beneath are dropped.
//!
//! Why order cannot matter: which pieces a value has, and which of them survive, depends on the value and the
//! final `top` alone, and `top` is a maximum. A piece dropped early lay beneath an earlier, lower `top`, so
//! the final one drops it too; a piece kept early is shifted out when `top` rises. Limbs never carry into
//! each other (only a copy does, in [`ExactSum::value`]), so integer addition is all that happens, and that
//! commutes.
//!
//! How exact: the largest magnitude M has its leading bit in the top bin, so at least 96 bits below that bit
//! are kept. A value loses something only if it is smaller than 2⁻⁴⁴ M, and then less than 2⁻⁹⁶ M. For N
//! values the error is below N 2⁻⁹⁶ M, and zero (the sum is exact) where all magnitudes lie within a factor
//! of 2⁴⁴.
//!
//! Scaling all values by a power of two scales an exact sum exactly. Where pieces were dropped, it does not
//! quite: the bins stay where they are, so other pieces are dropped. The two sums then differ by less than N
//! 2⁻⁹⁶ M, which reaches a 32-bit float only if the sum lies as near as that to the border between two of
//! them.

use crate::math::function::scalbn;

/// Number of bins kept.
const LIMBS: usize = 4;

/// Width of a bin in bits.
const BIN_BITS: i32 = 32;

/// The `top` of a sum that was given an infinity or a NaN. It is above every bin, so all pieces fall beneath
/// it.
const POISONED: u8 = u8::MAX;

/// What stands for the bin of an infinity or a NaN: above all bins, and not next to [`POISONED`].
const NO_BIN: u8 = 128;

/// Biased exponent of infinities and NaNs.
const NON_FINITE: u32 = 0x7ff;

/// A sum whose bits depend only on the multiset of the values added, not on their order or grouping.
///
/// Holds up to [`ExactSum::MOST_TERMS`] additions (those of merged sums included). An infinity or a NaN makes the sum
/// a NaN for good, in whatever order it arrives: nothing is swallowed and no caller has to check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExactSum {
    /// Signed sums of the pieces in bins `top`, `top - 1`, `top - 2`, `top - 3`.
    limbs: [i64; LIMBS],
    /// Bin of the leading bit of the largest magnitude so far, or [`POISONED`].
    top: u8,
}

impl ExactSum {
    /// Number of 32-bit words in the stored form.
    pub const WORDS: usize = 2 * LIMBS + 1;

    /// How many values it can be a sum of.
    pub const MOST_TERMS: u64 = 1 << 31;

    /// Adds one value.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.add_signed(value, (value.to_bits() as i64) >> 63);
    }

    /// Adds the square of a value, whose sign need not be asked for.
    #[inline]
    pub fn add_square(&mut self, value: f64) {
        self.add_signed(value * value, 0);
    }

    /// Adds a value; `sign` is −1 if it is negative, otherwise 0.
    #[inline(always)]
    fn add_signed(&mut self, value: f64, sign: i64) {
        let bits = value.to_bits();
        let exponent = (bits >> 52) as u32 & NON_FINITE;
        let fraction = bits & ((1 << 52) - 1);
        // A subnormal has the scale of exponent 1 and no hidden bit; both exponents lie in bin 0.
        let mantissa = if exponent == 0 { fraction << 1 } else { fraction | 1 << 52 };
        let bin = if exponent == NON_FINITE { NO_BIN } else { (exponent / 32) as u8 };
        // Bit 52 of the mantissa belongs at bit `exponent % 32` of its bin; 64 bits follow beneath.
        let position = exponent % 32;
        let low = mantissa << (12 + position);
        let signed = |piece: u64| (piece as i64 ^ sign) - sign;
        let pieces = [signed(mantissa >> (52 - position)), signed(low >> 32), signed(low & 0xffff_ffff)];
        // Values of one pixel are about as large as each other, though a border between bins may part them.
        if bin == self.top {
            self.limbs[0] += pieces[0];
            self.limbs[1] += pieces[1];
            self.limbs[2] += pieces[2];
        } else if bin + 1 == self.top {
            self.limbs[1] += pieces[0];
            self.limbs[2] += pieces[1];
            self.limbs[3] += pieces[2];
        } else {
            self.add_far(bin, pieces);
        }
    }

    /// Adds the pieces of a value whose highest bin is neither `top` nor the next below.
    #[cold]
    #[inline(never)]
    fn add_far(&mut self, bin: u8, pieces: [i64; 3]) {
        if bin == NO_BIN {
            *self = Self { limbs: [0; LIMBS], top: POISONED };
            return;
        }
        if bin > self.top {
            self.raise(bin);
        }
        let beneath = usize::from(self.top - bin);
        for (limb, piece) in self.limbs.iter_mut().skip(beneath).zip(pieces) {
            *limb += piece;
        }
    }

    /// Adds all values of another sum.
    #[inline]
    pub fn merge(&mut self, other: &ExactSum) {
        // Sums of neighbouring pixels are about as large as each other.
        if self.top == other.top {
            self.add_limbs(other);
        } else {
            self.merge_unlike(other);
        }
    }

    /// Adds a sum whose highest bin is another.
    #[inline(never)]
    fn merge_unlike(&mut self, other: &ExactSum) {
        let mut other = *other;
        if self.top < other.top {
            self.raise(other.top);
        } else {
            other.raise(self.top);
        }
        self.add_limbs(&other);
    }

    #[inline]
    fn add_limbs(&mut self, other: &ExactSum) {
        for (limb, addend) in self.limbs.iter_mut().zip(other.limbs) {
            // Wraps only where a damaged file claims limbs that 2³¹ additions cannot reach.
            *limb = limb.wrapping_add(addend);
        }
    }

    /// The sum, rounded once to the nearest f64 (ties to even). NaN if any value was not finite; infinite if
    /// the sum exceeds the range of f64. A subnormal sum is rounded twice.
    pub fn value(&self) -> f64 {
        if !self.is_finite() {
            return f64::NAN;
        }
        let digits = normalised(self.limbs.map(i128::from));
        let negative = digits[0] < 0;
        let digits = if negative { normalised(digits.map(|digit| -digit)) } else { digits };
        let [first, second, third, fourth] = digits.map(|digit| digit as u128);
        let lowest_bin = i32::from(self.top) - 3;
        // Below the first non-zero 2⁶⁴ the fourth digit is needed for rounding only as "something is left"
        // (sticky).
        let (magnitude, bin) = if first == 0 {
            (second << 64 | third << 32 | fourth, lowest_bin)
        } else {
            (first << 64 | second << 32 | third | u128::from(fourth != 0), lowest_bin + 1)
        };
        let value = scalbn(magnitude as f64, BIN_BITS * bin - 1023);
        if negative { -value } else { value }
    }

    /// Whether every value added was finite.
    pub fn is_finite(&self) -> bool {
        self.top != POISONED
    }

    /// The raw state, for storage: the limbs from the highest to the lowest, each as low and high word; then
    /// `top`.
    pub fn to_words(&self) -> [u32; Self::WORDS] {
        let mut words = [u32::from(self.top); Self::WORDS];
        for (pair, limb) in words.chunks_exact_mut(2).zip(self.limbs) {
            pair[0] = limb as u32;
            pair[1] = (limb >> 32) as u32;
        }
        words
    }

    /// The sum with this raw state, or `None` if no sequence of additions leads to its `top`.
    pub fn from_words(words: &[u32; Self::WORDS]) -> Option<ExactSum> {
        let top = u8::try_from(words[2 * LIMBS]).ok()?;
        let mut limbs = [0; LIMBS];
        for (limb, pair) in limbs.iter_mut().zip(words.chunks_exact(2)) {
            *limb = i64::from(pair[1] as i32) << 32 | i64::from(pair[0]);
        }
        let reachable = top <= (NON_FINITE / 32) as u8 || top == POISONED && limbs == [0; LIMBS];
        reachable.then_some(ExactSum { limbs, top })
    }

    /// Moves the window of kept bins up so that `top` is its highest.
    #[cold]
    fn raise(&mut self, top: u8) {
        let shift = usize::from(top.saturating_sub(self.top));
        for i in (0..LIMBS).rev() {
            self.limbs[i] = if i >= shift { self.limbs[i - shift] } else { 0 };
        }
        self.top = self.top.max(top);
    }
}

/// The same number with all digits but the first in `0 .. 2³²`.
fn normalised(mut digits: [i128; LIMBS]) -> [i128; LIMBS] {
    for i in (1..LIMBS).rev() {
        let carry = digits[i] >> BIN_BITS;
        digits[i] -= carry << BIN_BITS;
        digits[i - 1] += carry;
    }
    digits
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    fn sum(values: &[f64]) -> ExactSum {
        let mut sum = ExactSum::default();
        values.iter().for_each(|&value| sum.add(value));
        sum
    }

    /// A finite value as an integer multiple of 2⁻¹⁰⁷⁴.
    fn integer(value: f64) -> BigInt {
        let bits = value.abs().to_bits();
        let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
        let magnitude = if exponent == 0 {
            BigInt::from(fraction)
        } else {
            BigInt::from(fraction | 1 << 52) << (exponent - 1)
        };
        if value < 0.0 { -magnitude } else { magnitude }
    }

    /// Any sign, any exponent, any mantissa.
    fn wide() -> impl Strategy<Value = f64> {
        (any::<bool>(), 1e-300f64.to_bits()..1e300f64.to_bits()).prop_map(|(negative, bits)| {
            let value = f64::from_bits(bits);
            if negative { -value } else { value }
        })
    }

    /// Magnitudes within a factor of 2⁴⁰ of each other, where the sum must be exact.
    fn narrow() -> impl Strategy<Value = Vec<f64>> {
        let mantissas = prop::collection::vec((any::<bool>(), 0u64..1 << 52, 0i64..40), 1..50);
        (-900i64..900, mantissas).prop_map(|(base, parts)| {
            let value = |(negative, fraction, step)| {
                let bits = ((1023 + base + step) as u64) << 52 | fraction;
                if negative { -f64::from_bits(bits) } else { f64::from_bits(bits) }
            };
            parts.into_iter().map(value).collect()
        })
    }

    proptest! {
        #[test]
        fn order_and_grouping_do_not_matter(
            (values, shuffled) in prop::collection::vec(wide(), 1..60)
                .prop_flat_map(|values| (Just(values.clone()), Just(values).prop_shuffle())),
            cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
        ) {
            let expected = sum(&values);
            prop_assert_eq!(sum(&shuffled), expected);
            let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(shuffled.len())).collect();
            cuts.extend([0, shuffled.len()]);
            cuts.sort_unstable();
            let parts: Vec<ExactSum> = cuts.windows(2).map(|ends| sum(&shuffled[ends[0]..ends[1]])).collect();
            let fold = |into: &mut ExactSum, part: &ExactSum| into.merge(part);
            let mut forward = ExactSum::default();
            parts.iter().for_each(|part| fold(&mut forward, part));
            let mut backward = ExactSum::default();
            parts.iter().rev().for_each(|part| fold(&mut backward, part));
            prop_assert_eq!(forward, expected);
            prop_assert_eq!(backward, expected);
        }

        #[test]
        fn the_error_is_below_the_stated_bound(values in prop::collection::vec(wide(), 1..60)) {
            let exact: BigInt = values.iter().map(|&value| integer(value)).sum();
            let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let error = integer(sum(&values).value()) - &exact;
            // N 2⁻⁹⁶ M of dropped pieces, and half an ulp of the result.
            let dropped: BigInt = (integer(largest) * values.len()) >> 96;
            let rounding: BigInt = BigInt::from(exact.magnitude().clone()) >> 53;
            let size = BigInt::from(error.magnitude().clone());
            prop_assert!(size <= dropped + rounding + 1, "error {} of {}", error, exact);
        }

        #[test]
        fn a_narrow_range_is_summed_exactly_and_rounded_once(values in narrow()) {
            let exact: BigInt = values.iter().map(|&value| integer(value)).sum();
            let rounded = sum(&values).value();
            let error = BigInt::from((integer(rounded) - &exact).magnitude().clone());
            let gap = integer(rounded.abs().next_up()) - integer(rounded.abs());
            prop_assert!(error * 2 <= gap);
        }

        #[test]
        fn powers_of_two_scale_the_sum_exactly(values in narrow(), shift in -60i32..60) {
            let scaled: Vec<f64> = values.iter().map(|&value| libm::scalbn(value, shift)).collect();
            prop_assert_eq!(sum(&scaled).value(), libm::scalbn(sum(&values).value(), shift));
        }

        #[test]
        fn negation_negates(values in prop::collection::vec(wide(), 1..60)) {
            let negated: Vec<f64> = values.iter().map(|value| -value).collect();
            prop_assert_eq!(sum(&negated).value(), -sum(&values).value());
        }

        #[test]
        fn words_bring_the_sum_back(values in prop::collection::vec(wide(), 0..20)) {
            let sum = sum(&values);
            prop_assert_eq!(ExactSum::from_words(&sum.to_words()), Some(sum));
        }

        #[test]
        fn a_single_value_is_kept(value in any::<f64>()) {
            let kept = sum(&[value]).value();
            prop_assert!(kept == value || !value.is_finite() && kept.is_nan());
        }
    }

    #[test]
    fn halves_do_not_stall() {
        let mut sum = ExactSum::default();
        (0..10_000_000).for_each(|_| sum.add(0.5));
        assert_eq!(sum.value(), 5_000_000.0);
    }

    #[test]
    fn the_lowest_limb_decides_a_tie() {
        // 2⁻⁵² is half an ulp of 2; 2⁻⁸⁰ lies in the lowest of the bins kept beneath 2.
        let [half_ulp, little] = [libm::scalbn(1.0, -52), libm::scalbn(1.0, -80)];
        assert_eq!(sum(&[2.0, half_ulp]).value(), 2.0);
        assert_eq!(sum(&[2.0, half_ulp, little]).value(), 2f64.next_up());
        assert_eq!(sum(&[-2.0, -half_ulp, -little]).value(), -2f64.next_up());
    }

    #[test]
    fn cancellation_leaves_the_small_term() {
        assert_eq!(sum(&[1e20, 1.0, -1e20]).value(), 1.0);
        assert_eq!(sum(&[f64::MAX, -f64::MAX, f64::MAX]).value(), f64::MAX);
        assert_eq!(sum(&[f64::MAX, f64::MAX]).value(), f64::INFINITY);
        assert_eq!(sum(&[]).value(), 0.0);
    }

    #[test]
    fn non_finite_values_are_never_swallowed() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let orders = [sum(&[bad, 1.0, -2e300]), sum(&[1.0, bad, -2e300]), sum(&[1.0, -2e300, bad])];
            assert!(orders.iter().all(|sum| *sum == orders[0] && sum.value().is_nan() && !sum.is_finite()));
            let mut merged = sum(&[3.0]);
            merged.merge(&orders[0]);
            assert_eq!(merged, orders[0]);
            assert_eq!(ExactSum::from_words(&merged.to_words()), Some(merged));
        }
    }

    #[test]
    fn damaged_words_are_refused() {
        let mut words = sum(&[1.0]).to_words();
        words[2 * LIMBS] = 64;
        assert_eq!(ExactSum::from_words(&words), None);
        words[2 * LIMBS] = 256;
        assert_eq!(ExactSum::from_words(&words), None);
    }
}
