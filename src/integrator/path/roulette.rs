//! Russian roulette.

/// From this many edges on no path is sure to survive, not even one that has lost nothing: total reflection
/// keeps a quarter of all light in a cube of glass, and nothing would end it before
/// [`MAX_VERTICES`](super::MAX_VERTICES).
///
/// An nth edge is survived with a chance of 1 − 2/n at most, so n of them with (LONG/n)²: such a path has
/// 2·LONG edges on average, and what has come through a light guide by 200 total reflections weighs ten times
/// as much, not thousands of times, as by a fixed chance.
pub const LONG: u32 = 64;

/// Ends a path after so many edges, by a number in [0, 1), with what it has lost as the chance: `carried` is
/// the part left of what it might carry. Otherwise what its throughput is to be multiplied with, for those that
/// have ended.
///
/// What a lossless path has lost to rounding is no loss: in a thousand reflections it would end one path in
/// thousands.
#[inline(always)]
pub fn roulette(carried: f64, edges: u32, u: f64) -> Option<f32> {
    let survival = if edges < LONG { carried } else { carried.min(1.0 - 2.0 / f64::from(edges)) };
    if survival >= 1.0 - 4.0 * f64::from(edges) * f64::from(f32::EPSILON) {
        return Some(1.0);
    }
    (u < survival).then_some((1.0 / survival) as f32)
}

#[cfg(test)]
mod tests {
    use super::{LONG, roulette};

    #[test]
    fn survivors_stand_for_all() {
        for carried in [0.001, 0.3, 0.75, 0.999, 1.0, 2.0] {
            for edges in [5, 100] {
                let sum: f64 = (0..1 << 16)
                    .filter_map(|i| roulette(carried, edges, (f64::from(i) + 0.5) / 65536.0))
                    .map(f64::from)
                    .sum();
                assert!((sum / 65536.0 - 1.0).abs() < 0.01, "{carried} {edges} {sum}");
            }
        }
    }

    #[test]
    fn no_path_is_endless_and_none_ends_by_rounding() {
        let nearly = 0.999_999_999;
        assert_eq!(roulette(1.0 - 50.0 * f64::from(f32::EPSILON), LONG - 1, nearly), Some(1.0));
        assert_eq!(roulette(1.0, LONG, nearly), None);
        // The chance of ten times as many edges, and what survivors of all of them weigh.
        let factors = (LONG..10 * LONG).map(|edges| f64::from(roulette(1.0, edges, 0.0).unwrap()));
        let weight: f64 = factors.product();
        assert!((weight / 100.0 - 1.0).abs() < 0.05, "{weight}");
    }
}
