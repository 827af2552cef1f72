//! Trees large enough to be planned and laid out by several threads, with leaves of more than triangles.

use super::*;
use crate::shape::accel::Instance;
use std::sync::Arc;

/// Two balls of triangles, and `count` small shapes of all other kinds on the first and far from it.
fn crowd(rings: u32, count: usize) -> Vec<Geometry> {
    let mut rng = Pcg32::new(0, 1);
    let mut shapes = vec![ball(rings, 1.0, DVec3::ZERO), ball(rings, 0.5, DVec3::X)];
    for i in 0..count {
        let (distance, size) = if i % 2 == 0 { (1.0, 0.01) } else { (2.0, 0.02) };
        let scale = Transform::scale(DVec3::splat(size)).unwrap();
        shapes.push(of_kind(i, &somewhere(&mut rng, distance).after(&scale)));
    }
    shapes
}

/// Small balls on the first ball.
fn instances(count: usize) -> Vec<Instance> {
    let mut rng = Pcg32::new(0, 2);
    let group = Arc::new(Accel::new(&[&ball(6, 1.0, DVec3::ZERO)]));
    let mut place = || {
        Transform::translate(direction(&mut rng) * 1.02).after(&Transform::scale(DVec3::splat(0.02)).unwrap())
    };
    (0..count).map(|_| Instance::new(group.clone(), place())).collect()
}

/// Leaves hold up to four items without instances, and one with them.
#[test]
fn large_trees_find_what_trying_everything_finds_for_any_number_of_threads() {
    for (rings, count) in [(130, 0), (70, 300)] {
        let shapes = crowd(rings, 600);
        let refs: Vec<&Geometry> = shapes.iter().collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Accel::limited(&refs, instances(count), NONE_TRIED))
        };
        let (tree, other) = (with(1), with(3));
        assert!(bytemuck::cast_slice::<_, u8>(&tree.nodes) == bytemuck::cast_slice::<_, u8>(&other.nodes));
        let together = tree.mixed.iter().filter(|mixed| mixed.triangles.is_some()).count();
        assert!(tree.mixed.len() > 100 && together > 10, "{together} of {}", tree.mixed.len());
        let (flat, few) =
            (Accel::limited(&refs, vec![], ALL_TRIED), Accel::with_instances(&[], instances(count)));
        let mut rng = Pcg32::new(0, 3);
        let mut met = [0; 3];
        for i in 0..3000 {
            let (lo, hi) = shapes[2 + i % 600].bounds();
            let to = 0.5 * (lo + hi) + direction(&mut rng) * 0.02;
            let from = direction(&mut rng) * 3.0;
            let ray = Ray::free(from, unit(to - from));
            let of_instances =
                few.closest(&ray).map(|hit| Hit { primitive: hit.primitive + flat.primitives(), ..hit });
            let expected = match (flat.closest(&ray), of_instances) {
                (Some(one), Some(other)) => Some(if other.t < one.t { other } else { one }),
                (one, other) => one.or(other),
            };
            assert_eq!(tree.closest(&ray), expected, "{ray:?}");
            assert_eq!(tree.occluded(&ray), expected.is_some(), "{ray:?}");
            let triangles = shapes[0].primitives() + shapes[1].primitives();
            if let Some(hit) = expected {
                let ends = [triangles, flat.primitives(), u32::MAX];
                met[ends.partition_point(|end| *end <= hit.primitive)] += 1;
            }
        }
        let enough = met.map(|times| times > 50);
        assert_eq!(enough, [true, true, count > 0], "{met:?}");
    }
}
