//! What is chosen, how often, and that nothing that shines is left out.

use super::*;
use crate::bsdf::Lobe;
use crate::emitter::Gathers;
use crate::math::DVec3;
use crate::math::cone::Cone;
use crate::math::frame::unit;
use crate::math::random::{direction, uniform};
use rand_pcg::Pcg32;

/// Points, small boxes with a normal, and spots, of many intensities.
fn emitters(count: usize, rng: &mut Pcg32) -> Vec<Cluster> {
    let emitter = |i: usize| {
        let at = direction(rng) * (3.0 * uniform(rng));
        let half = if i.is_multiple_of(3) { DVec3::ZERO } else { DVec3::splat(0.1 * uniform(rng)) };
        let (normals, cos_beyond) = match i % 3 {
            0 => (Cone::EVERYWHERE, 0.0),
            1 => (Cone::along(direction(rng)), 0.0),
            _ => (Cone::along(direction(rng)), uniform(rng)),
        };
        Cluster {
            bounds: (at - half, at + half),
            normals,
            cos_beyond,
            intensity: uniform(rng) / count as f64,
        }
    };
    (0..count).map(emitter).collect()
}

fn receiver(rng: &mut Pcg32) -> (DVec3, Gathers) {
    let n = if uniform(rng) < 0.3 { DVec3::ZERO } else { direction(rng) };
    let glossy = Lobe { axis: direction(rng), alpha2: 0.25 * uniform(rng), share: uniform(rng) };
    let lobe = if uniform(rng) < 0.5 { Lobe::NONE } else { glossy };
    (direction(rng) * (4.0 * uniform(rng)), Gathers { n, lobe })
}

#[test]
fn emitters_are_chosen_as_often_as_is_said() {
    let mut rng = Pcg32::new(0, 0);
    for count in [1, 2, 3, 17, 200] {
        let tree = Tree::new(&emitters(count, &mut rng));
        for _ in 0..50 {
            let (p, gathers) = receiver(&mut rng);
            let at = gathers.at(p);
            let probabilities: Vec<f64> =
                (0..count).map(|i| tree.probability(&tree.seen_from(at), i)).collect();
            let total: f64 = probabilities.iter().sum();
            // The numbers that fall on an emitter are as many as its probability says, and go on from 0 to 1
            // within.
            const NUMBERS: usize = 20_000;
            let mut shares = vec![0.0; count];
            let mut last: Option<(usize, f64)> = None;
            for i in 0..NUMBERS {
                let Some(Chosen { index: emitter, probability, rest }) =
                    tree.sample(&tree.seen_from(at), (i as f64 + 0.5) / NUMBERS as f64)
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
        let (p, gathers) = receiver(&mut rng);
        let (at, n) = (gathers.at(p), gathers.n);
        for (i, cluster) in clusters.iter().enumerate() {
            let (lo, hi) = cluster.bounds;
            let from = lo + (hi - lo) * DVec3::from([0; 3].map(|_| uniform(&mut rng)));
            let w = unit(p - from);
            let leaves =
                cluster.normals == Cone::EVERYWHERE || cluster.normals.axis.dot(w) > cluster.cos_beyond;
            let arrives = n == DVec3::ZERO || n.dot(w) < 0.0;
            if leaves && arrives {
                lit += 1;
                assert!(tree.probability(&tree.seen_from(at), i) > 0.0, "{cluster:?} from {at:?}");
            }
        }
    }
    assert!(lit > 5000, "{lit}");
}

/// How much the light of one chosen emitter scatters, squared and relative to the light of all: 0 if it is
/// chosen exactly in proportion.
fn scatter(light: &[f64], probability: impl Fn(usize) -> f64) -> f64 {
    let total: f64 = light.iter().sum();
    let squares = light.iter().enumerate().filter(|(_, l)| **l > 0.0).map(|(i, l)| l * l / probability(i));
    squares.sum::<f64>() / (total * total) - 1.0
}

/// Places on a square with sides of this length, at a height that is asked for.
fn places(side: f64) -> impl FnMut(f64) -> DVec3 {
    let mut rng = Pcg32::new(0, 1);
    move |height| DVec3::new(side * uniform(&mut rng), side * uniform(&mut rng), height)
}

/// So many points that shine alike, at a height of one.
fn ceiling(count: usize, normals: Cone, place: &mut impl FnMut(f64) -> DVec3) -> Vec<Cluster> {
    let lamp = |p: DVec3| Cluster { bounds: (p, p), normals, cos_beyond: 0.0, intensity: 1.0 / count as f64 };
    (0..count).map(|_| lamp(place(1.0))).collect()
}

#[test]
fn emitters_are_chosen_nearly_in_proportion_to_their_light() {
    const LAMPS: usize = 400;
    let mut place = places(20.0);
    let lamps = ceiling(LAMPS, Cone::along(-DVec3::Z), &mut place);
    let tree = Tree::new(&lamps);
    let mut sums = [0.0; 2];
    for _ in 0..200 {
        let gathers = Gathers::about(DVec3::Z);
        let at = gathers.at(place(0.0));
        let light: Vec<f64> =
            lamps.iter().map(|lamp| (lamp.bounds.0 - at.p).length_squared().powi(-2)).collect();
        let scatters = [
            scatter(&light, |i| tree.probability(&tree.seen_from(at), i)),
            scatter(&light, |_| 1.0 / LAMPS as f64),
        ];
        sums = [0, 1].map(|i| sums[i] + scatters[i] / 200.0);
    }
    assert!(sums[0] < 0.4 && sums[1] > 40.0 * sums[0], "{sums:?}");
}

#[test]
fn scaling_by_a_power_of_two_changes_no_choice() {
    let mut rng = Pcg32::new(1, 0);
    let clusters = emitters(100, &mut rng);
    let factor = libm::scalbn(1.0, 40);
    let scaled = |c: &Cluster| Cluster { bounds: (c.bounds.0 * factor, c.bounds.1 * factor), ..*c };
    let (a, b) = (Tree::new(&clusters), Tree::new(&clusters.iter().map(scaled).collect::<Vec<_>>()));
    for _ in 0..1000 {
        let ((p, gathers), u) = (receiver(&mut rng), uniform(&mut rng));
        let (at, far) = (gathers.at(p), gathers.at(p * factor));
        assert_eq!(a.sample(&a.seen_from(at), u), b.sample(&b.seen_from(far), u));
    }
}

/// Lamps over a glossy floor, most of which a viewer does not see in it.
#[test]
fn lamps_that_a_glossy_floor_mirrors_are_chosen() {
    let mut place = places(4.0);
    let lamps = ceiling(100, Cone::EVERYWHERE, &mut place);
    let tree = Tree::new(&lamps);
    let mut sums = [0.0; 2];
    for _ in 0..200 {
        let (p, wo) = (place(0.0), unit(DVec3::new(0.3, 0.2, 1.0)));
        let lobe = Lobe::of_facets(wo, 0.2, 1.0);
        let shines = |lamp: &Cluster| {
            let way = lamp.bounds.0 - p;
            let w = unit(way);
            w.z * lobe.gain(lobe.axis.dot(w)) / way.length_squared()
        };
        let light: Vec<f64> = lamps.iter().map(shines).collect();
        let scatters = [lobe, Lobe::NONE].map(|lobe| {
            let gathers = Gathers { n: DVec3::Z, lobe };
            let seen = tree.seen_from(gathers.at(p));
            scatter(&light, |i| tree.probability(&seen, i))
        });
        sums = [0, 1].map(|i| sums[i] + scatters[i] / 200.0);
    }
    assert!(sums[0] < 1.0 && sums[1] > 4.0 * sums[0], "{sums:?}");
}
