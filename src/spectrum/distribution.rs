//! Wavelengths drawn where a film responds.
//!
//! Each response gets two of the eight wavelengths of a path, drawn in proportion to it, but all together at most half
//! of them; the others are spread evenly over what is visible, for a spectral film has colours too, and these want many
//! wavelengths. The density is constant over each of many parts of the range, so it is known exactly; where nothing
//! responds it is zero, and no part reaches over such a gap.

use super::LANES;
use super::observer::{self, WAVELENGTH_MAX, WAVELENGTH_MIN};
use super::table::Tabulated;
use super::wavelengths::Wavelengths;
use crate::math::{Chosen, Discrete};

/// Even steps over each response between which its density is taken for constant.
const STEPS: u16 = 64;

/// A density of wavelengths.
#[derive(Clone, Debug)]
pub struct Distribution {
    /// In nm, increasing; the parts lie between them.
    ends: Vec<f32>,
    parts: Discrete,
}

impl Distribution {
    /// Of wavelengths for these responses.
    pub fn new<'a>(responses: impl Iterator<Item = &'a Tabulated>) -> Self {
        let visible = Curve { nodes: vec![(WAVELENGTH_MIN, 1.0), (WAVELENGTH_MAX, 1.0)] };
        let mut curves: Vec<Curve> =
            responses.map(Curve::of).filter(|response| response.area() > 0.0).collect();
        let share = share(curves.len());
        let of_visible = 1.0 - share * curves.len() as f64;
        curves.push(visible);
        let mut ends: Vec<f32> =
            curves.iter().flat_map(|curve| curve.nodes.iter().map(|node| node.0)).collect();
        ends.sort_by(f32::total_cmp);
        ends.dedup();
        let mut parts = vec![0.0; ends.len() - 1];
        for (i, curve) in curves.iter().enumerate() {
            curve.add_to(&ends, &mut parts, if i + 1 < curves.len() { share } else { of_visible });
        }
        Self { ends, parts: Discrete::new(parts) }
    }

    /// Eight wavelengths, evenly rotated in the cumulative distribution about the one that u in [0, 1) picks,
    /// which is lane 0. Others than spectral films do not pay for it.
    #[inline(never)]
    pub fn sample(&self, u: f64) -> Wavelengths {
        let (mut nm, mut pdf) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let v = u + i as f64 / LANES as f64;
            (nm[i], pdf[i]) = self.wavelength(if v >= 1.0 { v - 1.0 } else { v });
        }
        let [r, g, b, d65] = observer::responses(&nm);
        let response =
            [r, g, b].map(|c| std::array::from_fn(|i| c[i] * (Wavelengths::RESPONSE_SCALE / pdf[i])));
        Wavelengths { nm, pdf, d65, response, mean_factor: 1.0 / LANES as f32, collapsed: 0 }
    }

    /// The wavelength below which the fraction v in [0, 1) lies, and the density there.
    fn wavelength(&self, v: f64) -> (f32, f32) {
        let Chosen { index, probability, rest } = self.parts.sample(v);
        let (from, to) = (f64::from(self.ends[index]), f64::from(self.ends[index + 1]));
        let nm = from + (to - from) * rest;
        // A density beneath the range of `f32` is that of a response as wide as this range.
        (nm as f32, ((probability / (to - from)) as f32).max(f32::MIN_POSITIVE))
    }
}

/// The part of all wavelengths that is drawn for each of so many responses.
fn share(responses: usize) -> f64 {
    (2.0 / LANES as f64).min(0.5 / responses.max(1) as f64)
}

/// Below a straight line.
fn area(from: (f32, f64), to: (f32, f64)) -> f64 {
    0.5 * (from.1 + to.1) * f64::from(to.0 - from.0)
}

/// The size of a response at increasing wavelengths.
struct Curve {
    nodes: Vec<(f32, f64)>,
}

impl Curve {
    fn of(response: &Tabulated) -> Self {
        let (first, last) = response.range();
        let even = (0..=STEPS).map(|i| first + (last - first) * (f32::from(i) / f32::from(STEPS)));
        let mut ends: Vec<f32> = response.nodes().map(|node| node.0).chain(even).collect();
        ends.sort_by(f32::total_cmp);
        ends.dedup();
        Self { nodes: ends.into_iter().map(|λ| (λ, f64::from(response.eval(λ).abs()))).collect() }
    }

    fn area(&self) -> f64 {
        self.nodes.windows(2).map(|pair| area(pair[0], pair[1])).sum()
    }

    /// Adds to each interval, which lies within one of the curve's or beyond all of them, its part of `share`.
    fn add_to(&self, ends: &[f32], parts: &mut [f64], share: f64) {
        let per_area = share / self.area();
        let mut i = ends.partition_point(|&λ| λ < self.nodes[0].0);
        for pair in self.nodes.windows(2) {
            let per_nm = per_area * area(pair[0], pair[1]) / f64::from(pair[1].0 - pair[0].0);
            while ends[i] < pair[1].0 {
                parts[i] += per_nm * f64::from(ends[i + 1] - ends[i]);
                i += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard deviation, relative to the integral, of what one path finds of a response in white light.
    fn noise(bands: &[&Tabulated], response: &Tabulated) -> f64 {
        const PATHS: usize = 1 << 16;
        let distribution = Distribution::new(bands.iter().copied());
        let found = |i: usize| {
            let λ = distribution.sample((i as f64 + 0.5) / PATHS as f64);
            let of_lane = |i: usize| f64::from(response.eval(λ.nm[i])) / f64::from(λ.pdf[i]);
            (0..LANES).map(of_lane).sum::<f64>() / LANES as f64
        };
        let (lowest, highest) = response.range();
        let exact = response.mean(lowest, highest) * f64::from(highest - lowest);
        let mean = (0..PATHS).map(found).sum::<f64>() / PATHS as f64;
        assert!((mean / exact - 1.0).abs() < 1e-3, "{mean} {exact}");
        let squares = (0..PATHS).map(|i| (found(i) / exact - 1.0) * (found(i) / exact - 1.0));
        (squares.sum::<f64>() / PATHS as f64).sqrt()
    }

    fn table(nodes: &[(f32, f32)]) -> Tabulated {
        let (nm, values) = nodes.iter().copied().unzip();
        Tabulated::new(nm, values).unwrap()
    }

    #[test]
    fn each_response_is_found_by_its_share_of_the_lanes() {
        let line = table(&[(588.0, 1.0), (590.0, 1.0)]);
        let peak = table(&[(580.0, 0.0), (587.0, 1.0), (590.0, 0.0)]);
        let infrared = table(&[(700.0, 1.0), (20_000.0, 0.5)]);
        let visible = table(&[(WAVELENGTH_MIN, 1.0), (WAVELENGTH_MAX, 1.0)]);
        let all = [&line, &peak, &infrared, &visible];
        for (bands, response) in [(&all[..1], &line), (&all[1..2], &peak)]
            .into_iter()
            .chain(all.map(|response| (&all[..], response)))
        {
            // At least its share of the lanes, as even as whole lanes can be: half a lane of noise.
            let lanes = LANES as f64 * share(bands.len());
            let noise = noise(bands, response);
            assert!(noise < 0.5 / lanes, "{noise} of {lanes} lanes");
        }
    }

    /// By the square of what one lane finds: it has a bound wherever the response is not far above its density.
    #[test]
    fn gaps_and_dark_tails_make_no_rare_paths() {
        let near = table(&[(200.0, 1.0), (210.0, 1.0)]);
        let far = table(&[(1500.0, 1.0), (1501.0, 1.0)]);
        let narrow = table(&[(589.0, 1.0), (589.01, 1.0)]);
        let padded = table(&[(400.0, 0.0), (401.0, 1.0), (1000.0, 1.0), (1001.0, 0.0), (2500.0, 0.0)]);
        let tail = table(&[(400.0, 0.0), (401.0, 1.0), (1000.0, 1.0), (1001.0, 1e-5), (2500.0, 1e-5)]);
        let triangle = table(&[(900.0, 0.0), (1000.0, 1.0), (1100.0, 0.0)]);
        for bands in
            [vec![&near, &far], vec![&narrow], vec![&padded], vec![&tail], vec![&triangle, &near, &far]]
        {
            let distribution = Distribution::new(bands.iter().copied());
            for response in &bands {
                let curve = Curve::of(response);
                let square = |i: usize| {
                    let (from, to) = (distribution.ends[i], distribution.ends[i + 1]);
                    let [a, b] = [from, to].map(|λ| f64::from(response.eval(λ)));
                    let probability = distribution.parts.probability(i);
                    let inside = from >= curve.nodes[0].0 && to <= curve.nodes[curve.nodes.len() - 1].0;
                    let width = f64::from(to - from);
                    // ∫ r² dλ of a straight line, over the density.
                    let found = width * (a * a + a * b + b * b) / 3.0 * (width / probability);
                    if inside && a + b > 0.0 { found } else { 0.0 }
                };
                let square = (0..distribution.ends.len() - 1).map(square).sum::<f64>();
                let relative = square / (curve.area() * curve.area()) * share(bands.len());
                assert!(relative < 1.1, "{relative}");
            }
        }
    }

    #[test]
    fn the_widest_response_has_a_density() {
        let wide = table(&[(1.0, 1.0), (1e38, 1.0)]);
        let λ = Distribution::new([&wide].into_iter()).sample(0.99);
        assert!(
            λ.pdf.iter().all(|pdf| *pdf > 0.0) && λ.response.as_flattened().iter().all(|v| v.is_finite())
        );
    }

    #[test]
    fn responses_of_nothing_and_of_a_line_leave_the_others_alone() {
        let nothing = table(&[(400.0, 0.0), (500.0, 0.0)]);
        let line = table(&[(589.0, 1.0), (589.000_1, 1.0)]);
        let band = table(&[(500.0, 1.0), (520.0, 1.0)]);
        assert!(noise(&[&nothing, &line, &band], &band) < 0.25);
    }
}
