//! Numerical integration of smooth functions, for constants that are computed once.

/// Nodes and weights of the 16-point Gauss–Legendre rule on [−1, 1], positive half.
const RULE: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_5),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_7),
    (0.755_404_408_355_003, 0.124_628_971_255_533_9),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_8),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_9),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_1),
];

/// ∫ₐᵇ f. The substitution x = a + (b − a)s² makes a square-root kink at `a`, as interfaces have at their
/// critical angle, a polynomial.
pub fn gauss_legendre(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PANELS: usize = 8;
    let mut total = 0.0;
    for panel in 0..PANELS {
        let (lo, hi) = (panel as f64 / PANELS as f64, (panel + 1) as f64 / PANELS as f64);
        let (centre, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        for (node, weight) in RULE {
            for s in [centre - half * node, centre + half * node] {
                total += weight * half * f(a + (b - a) * s * s) * 2.0 * s * (b - a);
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::gauss_legendre;

    #[test]
    fn polynomials_and_square_roots_are_exact() {
        assert!((gauss_legendre(1.0, 3.0, |x| x * x * x) - 20.0).abs() < 1e-12);
        assert!((gauss_legendre(2.0, 6.0, |x| (x - 2.0).sqrt()) - 16.0 / 3.0).abs() < 1e-12);
    }
}
