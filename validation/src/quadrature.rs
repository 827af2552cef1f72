//! Integrals over rectangles to a given tolerance.
//!
//! The rule is Genz and Malik's (1980) of degree 7 with an embedded one of degree 5, 17 points per rectangle:
//! the difference of both is a pessimistic error estimate, and fourth differences select the side to halve.
//! Rectangles are refined where the error is largest, so kinks and steps cost evaluations, not accuracy.
//!
//! No point of the rule lies in the outer 5 % of a rectangle, where the edge of a density could be missed. A
//! straight edge there cuts off a corner, so the corners are evaluated too, and their deviation from the
//! extrapolation along the diagonal counts as an error of the strip beside them.

use crate::statistics::worst_of;
use std::{cmp::Ordering, collections::BinaryHeap};

/// An axis-parallel rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Cell {
    /// Both parts of the cell, split across `axis` at `position`.
    pub fn split(&self, axis: usize, position: f64) -> [Cell; 2] {
        let mut parts = [*self; 2];
        parts[0].high[axis] = position;
        parts[1].low[axis] = position;
        parts
    }

    /// The middle along `axis`.
    pub fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }
}

/// An integral with a bound on its error that holds for all but adversarial integrands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integral {
    pub value: f64,
    pub error: f64,
}

impl std::iter::Sum for Integral {
    fn sum<I: Iterator<Item = Integral>>(integrals: I) -> Integral {
        integrals.fold(Integral::default(), |sum, next| Integral {
            value: sum.value + next.value,
            error: sum.error + next.error,
        })
    }
}

/// Integrates `function` over the union of `cells` until the error is below `tolerance` or about `budget`
/// evaluations are spent; the result has the error that was reached. A value that is not finite makes the
/// integral NaN.
pub fn integrate(
    cells: &[Cell],
    tolerance: f64,
    budget: usize,
    function: impl Fn([f64; 2]) -> f64,
) -> Integral {
    integrate_known(cells, tolerance, budget, |point| Some(function(point)))
}

/// The same of a function of which not all is known yet. Rectangles with an unknown value have no part in the
/// integral, and are not refined: so all that one refinement asks for is asked at once.
pub fn integrate_known(
    cells: &[Cell],
    tolerance: f64,
    budget: usize,
    function: impl Fn([f64; 2]) -> Option<f64>,
) -> Integral {
    let function = |point| function(point).map(|value| [value]);
    let parts: Vec<Part<1>> = refine(cells, tolerance, budget, function).collect();
    let first: f64 = parts.iter().map(|part| part.value[0]).sum();
    let estimate: f64 = parts.iter().map(|part| part.error).sum();
    let cut = |part: &Part<1>| {
        let Cell { low, high } = part.cell;
        let at = low[part.axis] + GOLDEN * (high[part.axis] - low[part.axis]);
        part.cell.split(part.axis, at).map(|cell| Part::new(cell, &function).value[0])
    };
    // Rules can agree by chance, as they do on staircases; they do not agree again on other cells.
    let value: f64 = parts.iter().flat_map(cut).sum();
    let doubt = (value - first).abs();
    // The second cells may miss the one place where a value is not finite.
    if !doubt.is_finite() || !estimate.is_finite() {
        return Integral { value: f64::NAN, error: f64::NAN };
    }
    Integral { value, error: estimate.max(doubt) }
}

/// Integrates `N` functions at once; the second value bounds the error of each. As of [`integrate_known`],
/// some of it may be unknown.
pub fn integrate_all<const N: usize>(
    cells: &[Cell],
    tolerance: f64,
    budget: usize,
    function: impl Fn([f64; 2]) -> Option<[f64; N]>,
) -> ([f64; N], f64) {
    refine(cells, tolerance, budget, function).fold(([0.0; N], 0.0), |(mut sum, error), part| {
        sum.iter_mut().zip(part.value).for_each(|(sum, value)| *sum += value);
        (sum, error + part.error)
    })
}

fn refine<const N: usize>(
    cells: &[Cell],
    tolerance: f64,
    budget: usize,
    function: impl Fn([f64; 2]) -> Option<[f64; N]>,
) -> impl Iterator<Item = Part<N>> {
    let mut heap: BinaryHeap<Part<N>> = cells.iter().map(|&cell| Part::new(cell, &function)).collect();
    let mut error: f64 = heap.iter().map(|part| part.error).sum();
    let mut evaluations = POINTS * heap.len();
    while error > tolerance && evaluations < budget {
        let Some(worst) = heap.pop() else { break };
        error -= worst.error;
        for cell in worst.cell.split(worst.axis, worst.cell.middle(worst.axis)) {
            let part = Part::new(cell, &function);
            error += part.error;
            heap.push(part);
        }
        evaluations += 2 * POINTS;
    }
    heap.into_iter()
}

const POINTS: usize = 21;

/// Where cells are split for the second evaluation; no multiple of it is near a half.
const GOLDEN: f64 = 0.382;

struct Part<const N: usize> {
    cell: Cell,
    value: [f64; N],
    /// The largest error among the functions.
    error: f64,
    /// The axis along which the cell is halved.
    axis: usize,
}

impl<const N: usize> Part<N> {
    fn new(cell: Cell, function: &impl Fn([f64; 2]) -> Option<[f64; N]>) -> Self {
        let unknown = std::cell::Cell::new(false);
        let function = |point| {
            function(point).unwrap_or_else(|| {
                unknown.set(true);
                [0.0; N]
            })
        };
        let part = Self::of(cell, &function);
        if unknown.get() { Self { value: [0.0; N], error: 0.0, ..part } } else { part }
    }

    fn of(cell: Cell, function: &impl Fn([f64; 2]) -> [f64; N]) -> Self {
        let centre = [cell.middle(0), cell.middle(1)];
        let half = [0, 1].map(|axis| 0.5 * (cell.high[axis] - cell.low[axis]));
        let at = |x: f64, y: f64| function([centre[0] + x * half[0], centre[1] + y * half[1]]);
        let along = |axis: usize, by: f64| {
            if axis == 0 { sum(at(by, 0.0), at(-by, 0.0)) } else { sum(at(0.0, by), at(0.0, -by)) }
        };
        let corners = |by: f64| [at(by, by), at(by, -by), at(-by, by), at(-by, -by)];
        // Genz and Malik's abscissae λ₂, λ₃ = λ₄ and λ₅.
        let (inner, outer, diagonal) =
            ((9.0f64 / 70.0).sqrt(), (9.0f64 / 10.0).sqrt(), (9.0f64 / 19.0).sqrt());
        let middle = at(0.0, 0.0);
        let near = [along(0, inner), along(1, inner)];
        let far = [along(0, outer), along(1, outer)];
        let (wide, narrow, ends) = (corners(outer), corners(diagonal), corners(1.0));
        let area = 4.0 * half[0] * half[1];
        let (mut value, mut error, mut fourth) = ([0.0; N], 0.0f64, [0.0f64; 2]);
        for i in 0..N {
            let (near_sum, far_sum) = (near[0][i] + near[1][i], far[0][i] + far[1][i]);
            let all = |values: &[[f64; N]; 4]| values.iter().map(|value| value[i]).sum::<f64>();
            let jump: f64 = (0..4)
                .map(|corner| {
                    let slope = (wide[corner][i] - narrow[corner][i]) / (outer - diagonal);
                    (ends[corner][i] - wide[corner][i] - slope * (1.0 - outer)).abs()
                })
                .sum();
            let seventh = (-3816.0 * middle[i] + 2940.0 * near_sum + 1020.0 * far_sum + 200.0 * all(&wide))
                / 19683.0
                + 6859.0 / 78732.0 * all(&narrow);
            let fifth = -971.0 / 729.0 * middle[i]
                + 245.0 / 486.0 * near_sum
                + 65.0 / 1458.0 * far_sum
                + 25.0 / 729.0 * all(&wide);
            // Two corners share a strip of (1 − outer)/2 of the area.
            let strips = 0.25 * (1.0 - outer) * jump;
            let doubt = area * ((seventh - fifth).abs() + strips);
            // The corners have no part in the value, which must not be finite if theirs is not.
            value[i] = if doubt.is_finite() { area * seventh } else { f64::NAN };
            error = worst_of(error, doubt);
            for (axis, fourth) in fourth.iter_mut().enumerate() {
                let bend = near[axis][i] - 2.0 * middle[i] - (far[axis][i] - 2.0 * middle[i]) / 7.0;
                *fourth = fourth.max(bend.abs());
            }
        }
        let longer = usize::from(half[1] > half[0]);
        let axis = if fourth[0] == fourth[1] { longer } else { usize::from(fourth[1] > fourth[0]) };
        Self { cell, value, error, axis }
    }
}

fn sum<const N: usize>(mut a: [f64; N], b: [f64; N]) -> [f64; N] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

impl<const N: usize> Ord for Part<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl<const N: usize> PartialOrd for Part<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const N: usize> PartialEq for Part<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<const N: usize> Eq for Part<N> {}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Cell = Cell { low: [0.0, 0.0], high: [1.0, 1.0] };

    #[test]
    fn the_rule_is_exact_to_degree_seven() {
        for (i, j) in [(0, 0), (7, 0), (3, 4), (2, 5), (0, 6), (4, 2)] {
            let found = integrate(&[UNIT], f64::INFINITY, 0, |[x, y]| x.powi(i) * y.powi(j));
            let exact = 1.0 / (f64::from(i + 1) * f64::from(j + 1));
            assert!((found.value - exact).abs() < 1e-14, "x^{i} y^{j}: {} is not {exact}", found.value);
        }
    }

    #[test]
    fn what_cannot_be_integrated_beside_what_can_has_no_bound() {
        let (_, error) =
            integrate_all(&[UNIT], 1e-3, 1000, |[x, _]| Some([f64::INFINITY - f64::INFINITY, x]));
        assert!(error.is_nan(), "{error}");
    }

    #[test]
    fn steps_peaks_and_kinks_reach_the_tolerance() {
        let cells = UNIT.split(0, 0.5);
        let step = |[x, y]: [f64; 2]| f64::from(x * x + y * y < 1.0);
        let found = integrate(&cells, 1e-4, 4_000_000, step);
        assert!((found.value - std::f64::consts::FRAC_PI_4).abs() < 1e-4 && found.error <= 1e-4);
        let peak = |[x, y]: [f64; 2]| 1e-3 / ((x - 0.3) * (x - 0.3) + 1e-6) * (0.5 - y).abs();
        let exact = 0.25 * (libm::atan(700.0) + libm::atan(300.0));
        let found = integrate(&cells, 1e-8, 1_000_000, peak);
        assert!((found.value - exact).abs() < 1e-8, "{}", found.value - exact);
    }

    #[test]
    fn the_error_of_an_edge_is_within_its_bound() {
        for i in 0..10 {
            // A half plane whose edge is rotated.
            let (sin, cos) = libm::sincos(0.2 * f64::from(i));
            let edge = |[x, y]: [f64; 2]| f64::from(sin * (x - 0.47) + cos * (y - 0.31) < 0.0);
            let exact = integrate(&[UNIT], 1e-5, 1_000_000, edge).value;
            let found = integrate(&[UNIT], 1e-3, 1_000_000, edge);
            assert!((found.value - exact).abs() <= found.error + 1e-5, "{i}: {found:?} {exact}");
        }
    }

    /// Answers that come later: each pass asks for one refinement, and the last finds what is found at once.
    #[test]
    fn what_is_unknown_is_asked_for_and_left_alone() {
        let step = |[x, y]: [f64; 2]| f64::from(x * x + y * y < 1.0);
        let bits = |point: [f64; 2]| point.map(f64::to_bits);
        let (mut known, mut passes) = (std::collections::HashMap::new(), 0);
        let found = loop {
            let asked = std::cell::RefCell::new(vec![]);
            let found = integrate_known(&[UNIT], 1e-4, 4_000_000, |point| {
                let answer = known.get(&bits(point)).copied();
                if answer.is_none() {
                    asked.borrow_mut().push(point);
                }
                answer
            });
            passes += 1;
            if asked.borrow().is_empty() {
                break found;
            }
            known.extend(asked.into_inner().into_iter().map(|point| (bits(point), step(point))));
        };
        let evaluations = std::cell::Cell::new(0);
        let counted = |point| {
            evaluations.set(evaluations.get() + 1);
            step(point)
        };
        assert_eq!(found, integrate(&[UNIT], 1e-4, 4_000_000, counted));
        assert!(passes < 60 && known.len() < 2 * evaluations.get(), "{passes} {}", known.len());
    }

    #[test]
    fn not_a_number_comes_through() {
        let found = integrate(&[UNIT], 1e-6, 10_000, |[x, _]| if x > 0.5 { f64::NAN } else { 1.0 });
        assert!(found.value.is_nan());
        // At one place that the rule looks at, and the second cells do not.
        for place in [[0.5, 0.5], [1.0, 1.0]] {
            for wrong in [f64::NAN, f64::INFINITY] {
                let function = |point: [f64; 2]| if point == place { wrong } else { 1.0 };
                assert!(integrate(&[UNIT], 1e-6, 10_000, function).value.is_nan(), "{place:?} {wrong}");
                let both = |point| Some([1.0, function(point)]);
                let (values, _) = integrate_all(&[UNIT], 1e-6, 10_000, both);
                assert!(values[0] == 1.0 && values[1].is_nan(), "{place:?} {wrong}");
            }
        }
    }
}
