//! Integrals of the Gaussian bell curve, and their inverse.

use super::function::ln;

/// exp(x²) erfc(x) for x in [0, 8], where erfc alone would lose the digits that a ratio to the bell curve needs.
///
/// The minimax quotient of polynomials of degrees 8 and 9, within 6e-17 of the function before rounding. All
/// coefficients are positive, so nothing cancels. (Found by linear least squares for P − f Q with weights from
/// the last Q, at Chebyshev's nodes, with 60 digits.)
#[inline]
pub fn erfcx(x: f64) -> f64 {
    const P: [f64; 9] = [
        1.0,
        1.9130246145019485,
        1.8195512860151433,
        1.0869149896522985,
        0.440402932429719,
        0.12331346585232472,
        0.023302104007739056,
        0.002729504336612899,
        0.00015334869289448792,
    ];
    const Q: [f64; 10] = [
        1.0,
        3.041403781597477,
        4.251407951894548,
        3.5949641498727347,
        2.0333820775139877,
        0.801107954554983,
        0.2209864542648857,
        0.041437802476308655,
        0.004837920572261646,
        0.0002718034798038612,
    ];
    polynomial(&P, x) / polynomial(&Q, x)
}

/// The number below which a share `p` in (0, 1) of the standard normal distribution lies, to some units of the
/// last place (Wichura 1988, "Algorithm AS 241: The Percentage Points of the Normal Distribution", PPND16).
#[inline]
pub fn normal_quantile(p: f64) -> f64 {
    let from_middle = p - 0.5;
    if from_middle.abs() <= 0.425 {
        let r = 0.180625 - from_middle * from_middle;
        return from_middle * polynomial(&MIDDLE.0, r) / polynomial(&MIDDLE.1, r);
    }
    let r = (-ln(if from_middle < 0.0 { p } else { 1.0 - p })).sqrt();
    let tail = if r <= 5.0 {
        polynomial(&TAIL.0, r - 1.6) / polynomial(&TAIL.1, r - 1.6)
    } else {
        polynomial(&FAR_TAIL.0, r - 5.0) / polynomial(&FAR_TAIL.1, r - 5.0)
    };
    if from_middle < 0.0 { -tail } else { tail }
}

type Quotient = ([f64; 8], [f64; 8]);

const MIDDLE: Quotient = (
    [
        3.387_132_872_796_366_5,
        1.331_416_678_917_843_8e2,
        1.971_590_950_306_551_3e3,
        1.373_169_376_550_946e4,
        4.592_195_393_154_987e4,
        6.726_577_092_700_87e4,
        3.343_057_558_358_813e4,
        2.509_080_928_730_122_7e3,
    ],
    [
        1.0,
        4.231_333_070_160_091e1,
        6.871_870_074_920_579e2,
        5.394_196_021_424_751e3,
        2.121_379_430_158_659_7e4,
        3.930_789_580_009_271e4,
        2.872_908_573_572_194_3e4,
        5.226_495_278_852_545e3,
    ],
);

const TAIL: Quotient = (
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        2.417_807_251_774_506e-1,
        2.272_384_498_926_918_4e-2,
        7.745_450_142_783_414e-4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        6.897_673_349_851e-1,
        1.481_039_764_274_800_8e-1,
        1.519_866_656_361_645_7e-2,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ],
);

const FAR_TAIL: Quotient = (
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        2.965_605_718_285_048_7e-1,
        2.653_218_952_657_612_4e-2,
        1.242_660_947_388_078_4e-3,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        5.998_322_065_558_88e-1,
        1.369_298_809_227_358e-1,
        1.487_536_129_085_061_5e-2,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ],
);

/// c₀ + c₁x + c₂x² + …
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::function::exp;

    #[test]
    fn erfcx_meets_libm() {
        for i in 0..=4000 {
            let x = i as f64 / 500.0;
            // What rounds x² to begin with is as large in the exponential as x² times that.
            let bound = 1e-15 * (1.0 + x * x);
            assert!((erfcx(x) / (exp(x * x) * libm::erfc(x)) - 1.0).abs() < bound, "{x}");
        }
    }

    #[test]
    fn the_normal_quantile_inverts_erfc() {
        let meets = |p: f64| {
            let y = normal_quantile(p);
            // Where y is large, a rounding error of it is about y² times as large in the share.
            let bound = 1e-15 * (2.0 + y * y);
            let share = 0.5 * libm::erfc(-y * std::f64::consts::FRAC_1_SQRT_2);
            assert!((share / p - 1.0).abs() < bound, "{p} {share}");
        };
        for i in 1..10_000 {
            let p = i as f64 / 10_000.0;
            meets(p);
        }
        (1..1000).for_each(|exponent| meets(0.5f64.powi(exponent)));
        for i in 1..1024 {
            let p = i as f64 / 1024.0;
            assert_eq!(normal_quantile(1.0 - p), -normal_quantile(p), "{p}");
        }
    }
}
