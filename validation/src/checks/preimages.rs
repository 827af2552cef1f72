//! Sampling as a map from the unit square to directions: its Jacobian, its lobes, and its inverse.

use crate::{
    quadrature::Integral,
    scatterer::{DVec3, Scatterer},
    statistics::Stream,
};

/// Distance below which directions count as the same draw; the map is evaluated twice with the same numbers.
const SAME: f64 = 1e-12;

/// Rounding error in f64 of a sixth-order difference of directions, in units of 1/step: (45 + 9 + 1)/30 of a
/// coordinate's rounding, three times for the operations that computed it, and as much again for the rounding
/// of a point of the square times the slope there, which is steep where the disk's rim becomes the horizon.
const ROUNDING: f64 = 6.0 * 0.5 * f64::EPSILON;

/// Number of intervals of the first number whose ends are tried to find the lobes at a point of the square.
const SCAN: usize = 32;

/// The largest number below 1.
const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

/// Number of points of the square in the table of start values.
const TABLE: usize = 4096;
/// Largest number of start values from each interval of the first number: few are needed except where the map
/// is discontinuous between a start value and the preimage.
const STARTS: usize = 40;

/// Distance in stretched coordinates below which preimages in one lobe count as the same.
const NEAR: f64 = 1e-3;

/// The map from random numbers to directions for one `wo`, without delta lobes.
pub(super) struct Map<'a> {
    pub scatterer: &'a dyn Scatterer,
    pub wo: DVec3,
}

impl Map<'_> {
    /// The direction of the point `v` of the square in the lobe that the first number `lobe` chooses; `None`
    /// for no draw or a delta lobe.
    pub fn at(&self, lobe: f64, v: [f64; 2]) -> Option<DVec3> {
        let sample = self.scatterer.sample(self.wo, [lobe, v[0], v[1]])?;
        (!sample.delta && sample.wi.is_finite()).then_some(sample.wi)
    }

    /// The density, with a relative error, of the directions near the one at `v` in the lobe that `lobe`
    /// chooses.
    pub fn density(&self, lobe: f64, v: [f64; 2]) -> Option<Integral> {
        let (share, middle) = self.share(lobe, v)?;
        let area = self.area_factor(middle, v)?;
        Some(Integral { value: share / area.value, error: area.error })
    }

    /// The share of all first numbers that lead from `v` to the same direction as `lobe` does, and the
    /// midpoint of their interval around `lobe`.
    fn share(&self, lobe: f64, v: [f64; 2]) -> Option<(f64, f64)> {
        let target = self.at(lobe, v)?;
        let same = |number: f64| self.at(number, v).is_some_and(|wi| (wi - target).length() <= SAME);
        let mut numbers: Vec<f64> = (0..=SCAN).map(|i| (i as f64 / SCAN as f64).min(LAST)).collect();
        numbers.push(lobe);
        numbers.sort_by(f64::total_cmp);
        let (mut share, mut own, mut start) = (0.0, [0.0, 1.0], same(numbers[0]).then_some(0.0));
        let mut close = |start: f64, end: f64| {
            share += end - start;
            if start <= lobe && lobe <= end {
                own = [start, end];
            }
        };
        for pair in numbers.windows(2) {
            let inside = same(pair[1]);
            if inside != start.is_some() {
                let edge = edge(pair[0], pair[1], |number| same(number) == inside);
                if let Some(start) = start {
                    close(start, edge);
                }
                start = inside.then_some(edge);
            }
        }
        if let Some(start) = start {
            close(start, 1.0);
        }
        Some((share, 0.5 * (own[0] + own[1])))
    }

    /// Every direction that `v` leads to, with a first number that leads there, in the order of these
    /// numbers.
    fn directions(&self, v: [f64; 2]) -> Vec<(f64, DVec3)> {
        let mut found: Vec<(f64, DVec3)> = vec![];
        for number in (0..=SCAN).map(|i| (i as f64 / SCAN as f64).min(LAST)) {
            if let Some(wi) = self.at(number, v)
                && found.iter().all(|(_, other)| (*other - wi).length() > SAME)
            {
                found.push((number, wi));
            }
        }
        found
    }

    /// |∂ω/∂u × ∂ω/∂v| and its relative error. Steps are halved until the sixth-order differences agree or
    /// rounding makes them disagree more. Two of eighteen quotients may agree by chance, so their error is at
    /// least the rounding error of directions in them plus a sixty-fourth of the error of the previous
    /// quotient; and they agree at a kink, where they are the mean of two slopes, so the jump of the slope
    /// counts as error.
    fn area_factor(&self, lobe: f64, v: [f64; 2]) -> Option<Integral> {
        let middle = self.at(lobe, v)?;
        let mut steps = v.map(|x| (0.25 * x.min(1.0 - x)).min(1.0 / 32.0));
        let mut best = Integral { value: f64::NAN, error: f64::INFINITY };
        let (mut last, mut last_apart) = (f64::NAN, f64::INFINITY);
        for _ in 0..18 {
            let slope = |axis: usize| self.slope(middle, lobe, v, axis, steps[axis]);
            if let (Some((du, jump_u)), Some((dv, jump_v))) = (slope(0), slope(1)) {
                let value = du.cross(dv).length();
                let (along_u, along_v) = (du.length(), dv.length());
                let rounding =
                    ROUNDING * (along_v * (1.0 + along_u) / steps[0] + along_u * (1.0 + along_v) / steps[1]);
                let jump = jump_u.cross(dv).length() + du.cross(jump_v).length();
                let apart = (value - last).abs();
                // Not `max`, which ignores the NaN of a first quotient and would take the rounding for its
                // error.
                let error = if apart < rounding { rounding } else { apart } + last_apart / 64.0 + jump;
                let error = (error / value).abs();
                if error < best.error {
                    best = Integral { value, error };
                }
                (last, last_apart) = (value, apart);
            }
            if best.error < 1e-9 {
                break;
            }
            steps = steps.map(|step| 0.5 * step);
        }
        (best.value > 0.0).then_some(best)
    }

    /// ∂ω at `middle` along one axis by (−1, 9, −45, 0, 45, −9, 1)/60, and the jump of the slope there: the
    /// second differences over 1, 2 and 3 steps, each divided by its step, extrapolated to a step of zero.
    /// Without a kink they are odd in the step, and (5, −4, 1)/2 cancels its first and third power.
    fn slope(&self, middle: DVec3, lobe: f64, v: [f64; 2], axis: usize, step: f64) -> Option<(DVec3, DVec3)> {
        let moved = |by: f64| {
            let mut v = v;
            v[axis] += by;
            Some(self.at(lobe, v)? - middle)
        };
        let (mut slope, mut jump) = (DVec3::ZERO, DVec3::ZERO);
        for (times, first, second) in [(1.0, 45.0, 2.5), (2.0, -9.0, -2.0), (3.0, 1.0, 0.5)] {
            let (ahead, behind) = (moved(times * step)?, moved(-times * step)?);
            slope += first / (60.0 * step) * (ahead - behind);
            jump += second / (times * step) * (ahead + behind);
        }
        Some((slope, jump))
    }
}

/// The number at which `beyond` becomes true, by bisection between `low`, where it is false, and `high`,
/// where it is true.
fn edge(mut low: f64, mut high: f64, beyond: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if beyond(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// Coordinates of the square mapped to the real line by the logit, which spreads out the ends.
fn stretched(v: [f64; 2]) -> [f64; 2] {
    v.map(|x| libm::log(x / (1.0 - x)))
}

fn unstretched(t: [f64; 2]) -> [f64; 2] {
    t.map(|t| 1.0 / (1.0 + libm::exp(-t)))
}

struct Entry {
    lobe: f64,
    t: [f64; 2],
    wi: DVec3,
}

/// A table of start values for the preimages of directions; empty if only one lobe makes them.
pub(super) struct Preimages {
    /// Table entries by the interval of first numbers in which their lobe begins.
    lobes: Vec<Vec<Entry>>,
}

impl Preimages {
    pub fn new(map: &Map, stream: &mut Stream) -> Self {
        if !several_lobes(map, stream) {
            return Self { lobes: vec![] };
        }
        let mut lobes: Vec<Vec<Entry>> = (0..=SCAN).map(|_| vec![]).collect();
        for i in 0..TABLE {
            // Half of the points are uniform, half far in the tails.
            let t = [0, 1].map(|_| match i % 2 {
                0 => stretched([stream.uniform(); 2])[0],
                _ => 24.0 * (stream.uniform() - 0.5),
            });
            if t.iter().all(|t| t.is_finite()) {
                for (lobe, wi) in map.directions(unstretched(t)) {
                    lobes[(lobe * SCAN as f64).round() as usize].push(Entry { lobe, t, wi });
                }
            }
        }
        Self { lobes }
    }

    /// Whether directions may come from more than one lobe.
    pub fn several(&self) -> bool {
        !self.lobes.is_empty()
    }

    /// The sum of the densities at `wi` of all preimages found, including the known one at `v` with density
    /// `own`; the search ends as soon as the sum reaches `stated`.
    pub fn sum(&self, map: &Map, wi: DVec3, own: f64, v: [f64; 2], stated: f64, tolerance: f64) -> f64 {
        let mut found = vec![(stretched(v), own)];
        let starts: Vec<Vec<&Entry>> = self.lobes.iter().map(|entries| nearest(entries, wi)).collect();
        let in_turn =
            (0..STARTS).flat_map(|rank| starts.iter().filter_map(move |lobe| lobe.get(rank).copied()));
        for entry in in_turn {
            let Some(t) = invert(map, entry, wi) else { continue };
            // The same point, from which this lobe leads to the same direction: where two lobes spread
            // equally far, each has a preimage nearby that maps to `wi` only approximately in the other.
            let same = |other: [f64; 2]| {
                (0..2).all(|i| (other[i] - t[i]).abs() < NEAR)
                    && map
                        .at(entry.lobe, unstretched(other))
                        .is_some_and(|w| (w - wi).length() < 2.0 * ARRIVED)
            };
            if found.iter().any(|(other, _)| same(*other)) {
                continue;
            }
            if let Some(density) = map.density(entry.lobe, unstretched(t)) {
                found.push((t, density.value));
            }
            let total: f64 = found.iter().map(|part| part.1).sum();
            if total > stated * (1.0 - tolerance) {
                return total;
            }
        }
        found.iter().map(|part| part.1).sum()
    }
}

/// Whether some point of the square leads to two directions outside delta lobes.
fn several_lobes(map: &Map, stream: &mut Stream) -> bool {
    (0..64).any(|_| map.directions([stream.uniform(), stream.uniform()]).len() > 1)
}

fn nearest(entries: &[Entry], wi: DVec3) -> Vec<&Entry> {
    let distance = |entry: &Entry| (entry.wi - wi).length_squared();
    let mut best: Vec<(f64, &Entry)> = vec![];
    for entry in entries {
        let distance = distance(entry);
        if best.len() < STARTS || distance < best[best.len() - 1].0 {
            let place = best.partition_point(|(other, _)| *other <= distance);
            best.insert(place, (distance, entry));
            best.truncate(STARTS);
        }
    }
    best.into_iter().map(|(_, entry)| entry).collect()
}

/// Largest distance of a preimage's direction from the target, in units of the slopes but never above 1:
/// where the map is discontinuous, a difference quotient across the discontinuity is arbitrarily large, and
/// points beside it would pass for preimages.
const ARRIVED: f64 = 1e-7;

/// Newton's method with halved steps in stretched coordinates, from a table entry to the preimage of `wi`.
fn invert(map: &Map, entry: &Entry, wi: DVec3) -> Option<[f64; 2]> {
    const STEP: f64 = 1e-5;
    let at = |t: [f64; 2]| map.at(entry.lobe, unstretched(t));
    let mut t = entry.t;
    let mut rest = wi - at(t)?;
    for _ in 0..40 {
        let slope = |axis: usize| {
            let moved = |by: f64| {
                let mut t = t;
                t[axis] += by;
                at(t)
            };
            Some((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP))
        };
        let (a, b) = (slope(0)?, slope(1)?);
        // Least squares in the tangent plane.
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let determinant = aa * bb - ab * ab;
        let (ra, rb) = (a.dot(rest), b.dot(rest));
        let step = [(bb * ra - ab * rb) / determinant, (aa * rb - ab * ra) / determinant];
        let length = step[0].abs().max(step[1].abs());
        let arrived = rest.length() <= ARRIVED * (aa + bb).sqrt().min(1.0);
        if !length.is_finite() {
            return None;
        }
        if length < 1e-9 {
            return arrived.then_some(t);
        }
        let mut factor = (2.0 / length).min(1.0);
        let better = loop {
            let next = [t[0] + factor * step[0], t[1] + factor * step[1]];
            if let Some(moved) = at(next).map(|found| wi - found).filter(|r| r.length() < rest.length()) {
                break Some((next, moved));
            }
            factor *= 0.5;
            if factor < 1e-3 {
                break None;
            }
        };
        match better {
            Some((next, moved)) => (t, rest) = (next, moved),
            // The iteration has either converged to rounding or stagnated.
            None => return arrived.then_some(t),
        }
    }
    None
}
