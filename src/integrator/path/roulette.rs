//! Russian roulette.

/// From this many edges on no path is sure to go on from a mirror or from glass. Total reflection keeps a
/// quarter of all light in a cube of glass, and such a path finds nothing on its way.
const LONG: u32 = 64;

/// From this many on no path is sure to go on at all, or it would not end before
/// [`MAX_VERTICES`](super::MAX_VERTICES) where nothing is absorbed and nothing leads out.
pub const ENDLESS: u32 = 1 << 16;

/// With which chance a path of so many edges goes on that has lost nothing.
///
/// By 1 − 2/n for the nth edge it comes through n of them with (`LONG`/n)²: what nothing leads out of has
/// 2·`LONG` edges on average, and what comes through a light guide by 200 reflections weighs ten times as much,
/// not thousands of times, as by a fixed chance. Who has long light guides asks for a larger `rr_depth`.
fn most(edges: u32, specular: bool) -> f64 {
    match edges {
        ENDLESS.. => 0.95,
        LONG.. if specular => 1.0 - 2.0 / f64::from(edges),
        _ => 1.0,
    }
}

/// Ends a path after so many edges, by a number in [0, 1), with what it has lost as the chance: `carried` is
/// the part left of what it might carry. Otherwise what its throughput is to be multiplied with, for those that
/// have ended. `specular` is whether the next direction has no density.
///
/// What a lossless path has lost to rounding is no loss: in a thousand reflections it would end one path in
/// thousands.
#[inline(always)]
pub fn roulette(carried: f64, edges: u32, specular: bool, u: f64) -> Option<f32> {
    let rounding = 4.0 * f64::from(edges) * f64::from(f32::EPSILON);
    let kept = if carried < 1.0 - rounding { carried } else { 1.0 };
    let survival = kept.min(most(edges, specular));
    if survival == 1.0 {
        return Some(1.0);
    }
    (u < survival).then_some((1.0 / survival) as f32)
}

#[cfg(test)]
mod tests {
    use super::{ENDLESS, LONG, roulette};

    #[test]
    fn survivors_stand_for_all() {
        for carried in [0.001, 0.3, 0.75, 0.999, 1.0, 2.0] {
            for (edges, specular) in [(5, false), (100, false), (100, true), (ENDLESS, false)] {
                let sum: f64 = (0..1 << 16)
                    .filter_map(|i| roulette(carried, edges, specular, (f64::from(i) + 0.5) / 65536.0))
                    .map(f64::from)
                    .sum();
                assert!((sum / 65536.0 - 1.0).abs() < 0.01, "{carried} {edges} {sum}");
            }
        }
    }

    #[test]
    fn no_path_is_endless_and_none_ends_by_rounding() {
        let nearly = 0.999_999_9;
        for edges in [5, 50, 5000] {
            let rounded = 1.0 - f64::from(edges) * f64::from(f32::EPSILON);
            assert_eq!(roulette(rounded, edges, false, nearly), Some(1.0));
        }
        assert!([LONG, 1 << 10, 1 << 20].iter().all(|edges| roulette(1.0, *edges, true, nearly).is_none()));
        assert!(roulette(1.0, ENDLESS, false, nearly).is_none());
        // What survivors of ten times as many edges weigh, which is one over their chance.
        let factors = (LONG..10 * LONG).map(|edges| f64::from(roulette(1.0, edges, true, 0.0).unwrap()));
        let weight: f64 = factors.product();
        assert!((weight / 100.0 - 1.0).abs() < 0.05, "{weight}");
    }
}
