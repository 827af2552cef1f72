//! Russian roulette.

/// From this many edges on, no path is sure to survive at a mirror or at glass. Total reflection keeps a
/// quarter of all light in a cube of glass, and such a path never finds anything.
const LONG: u32 = 64;

/// From this many edges on, no path is sure to survive at all, or it would not end where nothing is absorbed and nothing
/// leads out.
pub const ENDLESS: u32 = 1 << 16;

/// From this many edges on, survival is less likely still, so that paths end before
/// [`MAX_VERTICES`](super::MAX_VERTICES).
const LAST: u32 = 15 * ENDLESS;

/// Which paths go through Russian roulette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Edges before it begins.
    pub edges: u32,
    /// Vertices from the first matte or glossy one on before it begins, if that is earlier.
    pub vertices: u32,
    /// The chance to survive over what is left of the throughput, up to certainty.
    pub chance: f64,
}

impl Roulette {
    /// As Mitsuba has it, after so many edges.
    pub const fn after(edges: u32) -> Self {
        Self { edges, vertices: u32::MAX, chance: 1.0 }
    }

    /// The one for images whose noise is to be least in a given time.
    ///
    /// In the place of a path that ends early another one begins. So roulette begins behind the two vertices
    /// that paths share, whose chances must not be those of one pixel. But a path that has lost little is
    /// worth its cost: it plays once more than half of its throughput is lost (see the notebook).
    pub const fn early(self) -> Self {
        Self { vertices: 3, chance: 2.0, ..self }
    }

    /// Whether it may have begun after so many edges.
    #[inline(always)]
    pub fn may_have_begun(&self, edges: u32) -> bool {
        edges >= self.edges.min(self.vertices)
    }

    /// The function `roulette`, if it has begun.
    #[inline(always)]
    pub fn play(&self, carried: f64, edges: u32, vertices: u32, specular: bool, u: f64) -> Option<f32> {
        if edges < self.edges && vertices < self.vertices {
            return Some(1.0);
        }
        roulette(carried * self.chance, edges, specular, u)
    }
}

/// The survival probability of a path with so many edges that has lost no throughput.
///
/// With 1 − 2/n at the nth edge a path survives n edges with probability (`LONG`/n)²: where nothing leads
/// out, paths have 2·`LONG` edges on average, and a path that comes through a light guide by 200 reflections
/// weighs ten times as much, not thousands of times, as it would with a constant probability. Scenes with
/// long light guides need a larger `rr_depth`.
///
/// In thick white media light is scattered so often: of what enters a half-space, H(μ)/√(πn) has not left after n
/// scatterings, 0.6 % after `ENDLESS`. By a constant probability nothing of that would be seen in practice.
fn most(edges: u32, specular: bool) -> f64 {
    match edges {
        LAST.. => 0.95,
        ENDLESS.. => 1.0 - 2.0 / f64::from(edges),
        LONG.. if specular => 1.0 - 2.0 / f64::from(edges),
        _ => 1.0,
    }
}

/// Russian roulette after so many edges, by a number `u` in [0, 1): `None` ends the path; `Some(w)` continues
/// it with throughput × w = 1/survival. The survival probability is `carried` (what is left of the
/// throughput), capped by `most`. `specular` is whether the next direction has no density.
///
/// Throughputs that differ from 1 by rounding alone count as 1: in a thousand reflections it would end one
/// path in thousands.
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
    use super::{ENDLESS, LAST, LONG, Roulette, roulette};

    #[test]
    fn survivors_stand_for_all() {
        for carried in [0.001, 0.3, 0.75, 0.999, 1.0, 2.0] {
            for (edges, specular) in [(5, false), (100, false), (100, true), (ENDLESS, false), (LAST, false)]
            {
                let sum: f64 = (0..1 << 16)
                    .filter_map(|i| roulette(carried, edges, specular, (f64::from(i) + 0.5) / 65536.0))
                    .map(f64::from)
                    .sum();
                assert!((sum / 65536.0 - 1.0).abs() < 0.01, "{carried} {edges} {sum}");
            }
        }
    }

    #[test]
    fn early_roulette_spares_what_has_lost_little() {
        let early = Roulette::after(5).early();
        let survive = |carried, edges, vertices| early.play(carried, edges, vertices, false, 0.7);
        assert_eq!((survive(0.5, 3, 3), survive(0.2, 3, 3)), (Some(1.0), None));
        // Through two panes, and at the vertex that light comes from which pixels share.
        assert_eq!((survive(0.2, 4, 2), survive(0.2, 5, 0)), (Some(1.0), None));
        assert_eq!(early.play(0.25, 3, 3, false, 0.4), Some(2.0));
        assert_eq!(Roulette::after(5).play(0.5, 4, 4, false, 0.7), Some(1.0));
        assert_eq!(Roulette::after(5).play(0.5, 5, 4, false, 0.4), Some(2.0));
    }

    #[test]
    fn no_path_is_endless_and_none_ends_by_rounding() {
        let nearly = 0.999_999_9;
        for edges in [5, 50, 5000] {
            let rounded = 1.0 - f64::from(edges) * f64::from(f32::EPSILON);
            assert_eq!(roulette(rounded, edges, false, nearly), Some(1.0));
        }
        assert!([LONG, 1 << 10, 1 << 20].iter().all(|edges| roulette(1.0, *edges, true, nearly).is_none()));
        assert!([ENDLESS, LAST].iter().all(|edges| roulette(1.0, *edges, false, 1.0 - 1e-6).is_none()));
        // And from where even matter without loss ends paths, to twice as many, four.
        let factors =
            (ENDLESS..2 * ENDLESS).map(|edges| f64::from(roulette(1.0, edges, false, 0.0).unwrap()));
        let weight: f64 = factors.product();
        assert!((weight / 4.0 - 1.0).abs() < 0.05, "{weight}");
        // What survivors of ten times as many edges weigh, which is one over their chance.
        let factors = (LONG..10 * LONG).map(|edges| f64::from(roulette(1.0, edges, true, 0.0).unwrap()));
        let weight: f64 = factors.product();
        assert!((weight / 100.0 - 1.0).abs() < 0.05, "{weight}");
    }
}
