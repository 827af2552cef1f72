//! Russian roulette.

/// From this many edges on no path is sure to survive, not even one that has lost nothing: where nothing is
/// absorbed and nothing leads out, it would go on to [`MAX_VERTICES`](super::MAX_VERTICES). With so many edges
/// hardly a path of a scene that light can leave is concerned: the few that come through are bright.
const LONG: u32 = 1 << 16;

/// Ends a path after so many edges, by a number in [0, 1), with what it has lost as the chance: `carried` is
/// the part left of what it might carry. Otherwise what its throughput is to be multiplied with, for those that
/// have ended.
///
/// What a lossless path has lost to rounding is no loss: in a thousand reflections it would end one path in
/// thousands.
#[inline(always)]
pub fn roulette(carried: f64, edges: u32, u: f64) -> Option<f32> {
    let survival = if edges < LONG { carried } else { carried.min(0.95) };
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
        assert_eq!(roulette(1.0 - 100.0 * f64::from(f32::EPSILON), 100, 0.999_999_999), Some(1.0));
        assert_eq!(roulette(1.0, LONG, 0.96), None);
    }
}
