//! What is chosen, how often, and that nothing that shines is left out.

use super::*;
use crate::math::cone::Cone;
use crate::math::random::{direction, uniform};
use rand_pcg::Pcg32;

/// Points, small boxes with a normal, and spots, of many powers.
fn emitters(count: usize, rng: &mut Pcg32) -> Vec<Cluster> {
    let emitter = |i: usize| {
        let at = direction(rng) * (3.0 * uniform(rng));
        let half = if i.is_multiple_of(3) { DVec3::ZERO } else { DVec3::splat(0.1 * uniform(rng)) };
        let (normals, cos_beyond) = match i % 3 {
            0 => (Cone::EVERYWHERE, 0.0),
            1 => (Cone::along(direction(rng)), 0.0),
            _ => (Cone::along(direction(rng)), uniform(rng)),
        };
        Cluster { bounds: (at - half, at + half), normals, cos_beyond, power: uniform(rng) / count as f64 }
    };
    (0..count).map(emitter).collect()
}

fn receiver(rng: &mut Pcg32) -> Receiver {
    let n = if uniform(rng) < 0.3 { DVec3::ZERO } else { direction(rng) };
    (direction(rng) * (4.0 * uniform(rng)), n)
}

#[test]
fn emitters_are_chosen_as_often_as_is_said() {
    let mut rng = Pcg32::new(0, 0);
    for count in [1, 2, 3, 17, 200] {
        let tree = Tree::new(&emitters(count, &mut rng));
        for _ in 0..50 {
            let at = receiver(&mut rng);
            let probabilities: Vec<f64> = (0..count).map(|i| tree.probability(i, at)).collect();
            let total: f64 = probabilities.iter().sum();
            // The numbers that fall on an emitter are as many as its probability says, and go on from 0 to 1 within.
            const NUMBERS: usize = 20_000;
            let mut shares = vec![0.0; count];
            let mut last: Option<(usize, f64)> = None;
            for i in 0..NUMBERS {
                let Some((emitter, probability, rest)) = tree.sample(at, (i as f64 + 0.5) / NUMBERS as f64)
                else {
                    last = None;
                    continue;
                };
                assert!((probability / probabilities[emitter] - 1.0).abs() < 1e-12);
                shares[emitter] += 1.0 / NUMBERS as f64;
                if let Some((_, before)) = last.filter(|last| last.0 == emitter) {
                    assert!(((rest - before) * probability * NUMBERS as f64 - 1.0).abs() < 1e-6);
                }
                last = Some((emitter, rest));
            }
            for (share, probability) in shares.iter().zip(&probabilities) {
                assert!((share - probability).abs() <= 1.0 / NUMBERS as f64 + 1e-12, "{share} {probability}");
            }
            // Where bounds promise light that no emitter has, nothing is chosen.
            assert!(total <= 1.0 + 1e-12 && (total - shares.iter().sum::<f64>()).abs() < 0.01, "{total}");
        }
    }
}

#[test]
fn what_shines_at_a_point_has_a_chance() {
    let mut rng = Pcg32::new(1, 1);
    let clusters = emitters(200, &mut rng);
    let tree = Tree::new(&clusters);
    let mut lit = 0;
    for _ in 0..200 {
        let (p, n) = receiver(&mut rng);
        for (i, cluster) in clusters.iter().enumerate() {
            let (lo, hi) = cluster.bounds;
            let from = lo + (hi - lo) * DVec3::from([0; 3].map(|_| uniform(&mut rng)));
            let w = crate::math::frame::unit(p - from);
            let leaves =
                cluster.normals == Cone::EVERYWHERE || cluster.normals.axis.dot(w) > cluster.cos_beyond;
            let arrives = n == DVec3::ZERO || n.dot(w) < 0.0;
            if leaves && arrives {
                lit += 1;
                assert!(tree.probability(i, (p, n)) > 0.0, "{cluster:?} at {p} about {n}");
            }
        }
    }
    assert!(lit > 5000, "{lit}");
}

#[test]
fn the_nearest_of_many_is_chosen_most() {
    let lamp = |x: f64| Cluster {
        bounds: (DVec3::X * x, DVec3::X * x),
        normals: Cone::EVERYWHERE,
        cos_beyond: 0.0,
        power: 1e-3,
    };
    let lamps: Vec<Cluster> = (0..1000).map(|i| lamp(f64::from(i))).collect();
    let tree = Tree::new(&lamps);
    let at = (DVec3::new(500.0, 0.5, 0.0), DVec3::ZERO);
    let exact = |i: usize| 1.0 / ((i as f64 - 500.0) * (i as f64 - 500.0) + 0.25);
    let total: f64 = (0..1000).map(exact).sum();
    for i in 495..=505 {
        let ratio = tree.probability(i, at) / (exact(i) / total);
        assert!((0.3..3.0).contains(&ratio), "{i}: {ratio}");
    }
}

#[test]
fn scaling_by_a_power_of_two_changes_no_choice() {
    let mut rng = Pcg32::new(1, 0);
    let clusters = emitters(100, &mut rng);
    let factor = libm::scalbn(1.0, 40);
    let scaled = |c: &Cluster| Cluster { bounds: (c.bounds.0 * factor, c.bounds.1 * factor), ..*c };
    let (a, b) = (Tree::new(&clusters), Tree::new(&clusters.iter().map(scaled).collect::<Vec<_>>()));
    for _ in 0..1000 {
        let ((p, n), u) = (receiver(&mut rng), uniform(&mut rng));
        assert_eq!(a.sample((p, n), u), b.sample((p * factor, n), u));
    }
}
