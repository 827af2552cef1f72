//! Tests that every phase function must pass, on every example of the registry.

use super::*;
use crate::math::length;
use crate::scene::catalogue::versioned;
use crate::scene::loader::Loader;
use crate::scene::params::{Params, Usage};
use crate::scene::xml;
use crate::spectrum::ColorMode;
use std::f64::consts::TAU;

/// Calls `f` with every example.
fn each(mut f: impl FnMut(&str, &AnyPhase)) {
    for (entry, example) in PHASES.iter().flat_map(|entry| entry.examples.iter().map(move |e| (entry, e))) {
        let text = versioned(example);
        let document = xml::read_text("example.xml", &text).unwrap();
        let loader = Loader::new(&document, ColorMode::Spectral).unwrap();
        let mut params = Params::new(&document.root, &loader, Usage::Unbounded).unwrap();
        let phase = (entry.parse)(&mut params).unwrap();
        assert_eq!(phase.name(), entry.name);
        f(example, &phase);
    }
}

const STEPS: usize = 4096;

/// The mean of a function over [0, 1], by the midpoints of so many steps.
fn mean(steps: usize, f: impl Fn(f64) -> f64) -> f64 {
    (0..steps).map(|i| f((i as f64 + 0.5) / steps as f64)).sum::<f64>() / steps as f64
}

/// Where the examples are asked: they are the same everywhere.
const PLACE: DVec3 = DVec3::new(0.3, -2.0, 0.7);

/// As u goes from 0 to 1 the cosine falls from 1 to −1, by du = −2π p(cos) dcos: density and samples are one
/// distribution, of which nothing is left out.
#[test]
fn cosines_follow_the_density() {
    let unmixed = |phase: &AnyPhase| !matches!(phase, AnyPhase::Blend(_));
    each(|name, phase| {
        let cosine = |u: f64| phase.sample_cosine(PLACE, 0.5, u);
        assert!((cosine(0.0) - 1.0).abs() < 1e-12, "{name}");
        assert!((cosine(1.0 - f64::EPSILON) + 1.0).abs() < 1e-6, "{name}");
        for i in (1..STEPS).filter(|_| unmixed(phase)) {
            let (u, h) = (i as f64 / STEPS as f64, 1e-3 / STEPS as f64);
            let slope = (cosine(u - h) - cosine(u + h)) / (2.0 * h);
            let jacobian = TAU * phase.density(PLACE, cosine(u)) * slope;
            assert!((jacobian - 1.0).abs() < 1e-5, "{name} at {u}: {jacobian}");
        }
    });
}

/// The same of mixtures, whose cosines depend on two numbers: each of 64 ranges of cosines has its share.
#[test]
fn ranges_of_cosines_have_their_shares() {
    const RANGES: usize = 64;
    const PARTS: usize = 1000;
    each(|name, phase| {
        let mut shares = [0.0; RANGES];
        for (i, j) in (0..PARTS).flat_map(|i| (0..RANGES * 8).map(move |j| (i, j))) {
            let [part, u] = [(i, PARTS), (j, RANGES * 8)].map(|(i, of)| (i as f64 + 0.5) / of as f64);
            let cos = phase.sample_cosine(PLACE, part, u);
            let range = (0.5 * (1.0 + cos) * RANGES as f64) as usize;
            shares[range.min(RANGES - 1)] += 1.0 / (PARTS * RANGES * 8) as f64;
        }
        for (range, share) in shares.into_iter().enumerate() {
            let cos = |u: f64| 2.0 * (range as f64 + u) / RANGES as f64 - 1.0;
            let expected = mean(STEPS, |u| phase.density(PLACE, cos(u))) * 2.0 * TAU / RANGES as f64;
            // Each of the parts puts at most two of its cosines into a range that are of its neighbours.
            let close = 2.0 / (RANGES * 8) as f64;
            assert!((share - expected).abs() < close, "{name}, range {range}: {share}, not {expected}");
        }
    });
}

#[test]
fn samples_say_what_evaluation_says() {
    each(|name, phase| {
        let (phase, wo) = (phase.at(PLACE), DVec3::Z);
        for (i, j) in (0..64).flat_map(|i| (0..16).map(move |j| (i, j))) {
            let u = DVec2::new((f64::from(i) + 0.5) / 64.0, (f64::from(j) + 0.5) / 16.0);
            let sample = phase.sample(wo, f64::from(i % 7) / 7.0, u).unwrap();
            let evaluation = phase.evaluate(wo, sample.wi);
            assert!((length(sample.wi) - 1.0).abs() < 1e-12, "{name}");
            assert!(
                (sample.pdf / evaluation.pdf - 1.0).abs() < 1e-6,
                "{name} {u}: {sample:?} {evaluation:?}"
            );
            let weight = evaluation.value.0[0] as f64 / evaluation.pdf;
            assert!((weight - sample.weight.0[0] as f64).abs() < 1e-6, "{name}");
            assert!(!sample.delta && !sample.null && sample.eta == 1.0, "{name}");
            // Reciprocity.
            assert_eq!(phase.evaluate(sample.wi, wo).pdf, evaluation.pdf, "{name}");
        }
    });
}

/// The first moments that are known in closed form: the mean cosine is g, 0 by symmetry, or a sum over the table.
#[test]
fn mean_cosines_are_known() {
    let mut found = vec![];
    each(|name, phase| {
        // So many that the borders between parts of the examples lie between two of them.
        let parts = if matches!(phase, AnyPhase::Blend(_)) { 80 } else { 1 };
        let cosine = mean(parts, |part| mean(16 * STEPS, |u| phase.sample_cosine(PLACE, part, u)));
        let value = name.split("value=\"").nth(1).and_then(|rest| rest.split('"').next());
        let expected = match (phase, value) {
            (AnyPhase::HenyeyGreenstein(_), None) => 0.8,
            (AnyPhase::HenyeyGreenstein(_), Some(g)) => g.parse().unwrap(),
            (AnyPhase::Tabulated(_), Some(values)) => mean_cosine_of_a_table(values),
            (AnyPhase::Blend(_), Some("0.3")) => 0.3 * 0.6,
            (AnyPhase::Blend(_), Some("0.25")) => {
                0.75 * (0.25 * -0.5 + 0.75 * mean_cosine_of_a_table("1, 0, 2"))
            }
            (AnyPhase::Isotropic(_) | AnyPhase::Rayleigh(_), _) | (AnyPhase::Blend(_), Some("0")) => 0.0,
            (AnyPhase::Tabulated(_), None) | (AnyPhase::Blend(_), _) => panic!("{name}: add its mean cosine"),
        };
        assert!((cosine - expected).abs() < 1e-6, "{name}: {cosine}, not {expected}");
        found.push(expected);
    });
    assert_eq!(found.len(), PHASES.iter().map(|entry| entry.examples.len()).sum::<usize>());
}

/// ∫ p c dc / ∫ p dc from −1 to 1 where p is linear between these values, by Simpson's rule, which is exact for
/// the parabolas between them.
fn mean_cosine_of_a_table(values: &str) -> f64 {
    let values: Vec<f64> = values.split(',').map(|value| value.trim().parse().unwrap()).collect();
    let step = 2.0 / (values.len() - 1) as f64;
    let mut sums = [0.0; 2];
    for (i, pair) in values.windows(2).enumerate() {
        let [low, high] = [i, i + 1].map(|knot| -1.0 + knot as f64 * step);
        let middle = (0.5 * (low + high), 0.5 * (pair[0] + pair[1]));
        for ((cos, value), weight) in [((low, pair[0]), 1.0), (middle, 4.0), ((high, pair[1]), 1.0)] {
            sums[0] += weight * value;
            sums[1] += weight * value * cos;
        }
    }
    sums[1] / sums[0]
}
