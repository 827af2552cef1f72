//! Shapes beside which all others are tiny.

use super::*;

/// Beside the tree, whose coordinates they do not spoil: rays come from far outside these, and shafts reach there.
#[test]
fn grounds_and_skies_are_kept_out_of_a_tree_of_small_things() {
    for size in [1e3, 1e6, 1e12] {
        let place = |y| Transform::translate(DVec3::new(0.0, y, 0.0));
        let vast = Transform::scale(DVec3::splat(size)).unwrap();
        let flat = vast.after(&Transform::rotate(DVec3::X, 90.0).unwrap());
        let mut shapes = zoo();
        shapes.push(Geometry::Patch(Patch::new(&place(-5.0).after(&flat), false, Outline::Square)));
        shapes.push(Geometry::Sphere(Sphere::new(&vast, DVec3::ZERO, 1.5, true)));
        let refs: Vec<&Geometry> = shapes.iter().collect();
        let (accel, whole) = (Accel::new(&refs), Accel::limited(&refs, vec![], ALL_TRIED));
        assert_eq!(
            (accel.outside_tree.patches, accel.outside_tree.spheres, accel.outside_tree.cubes),
            (1, 1, 0),
            "{size}"
        );
        let small = Accel::new(&refs[..refs.len() - 2]);
        assert!(size > 1e9 || accel.space.scale() == small.space.scale());
        let mut rng = Pcg32::new(1, 1);
        // A shaft is never clear within a sphere.
        let without_sky = Accel::new(&refs[..refs.len() - 1]);
        let (mut clear, mut shaft) = (0, Shaft::default());
        for _ in 0..20_000 {
            let near = DVec3::from([0; 3].map(|_| 8.0 * uniform(&mut rng) - 4.0));
            let far = 1.4 * size * uniform(&mut rng) * uniform(&mut rng);
            let far = DVec3::new(far, 0.0, 0.3 * far) + near;
            for ray in [Ray::free(far, unit(near - far)), Ray::free(near, unit(far - near))] {
                assert_eq!(accel.closest(&ray), whole.closest(&ray), "{ray:?}");
            }
            shaft.begin([near, near + DVec3::X].into_iter());
            if without_sky.is_clear(&mut shaft, far, u32::MAX) {
                clear += 1;
                let ray = Ray { end: length(far - near), ..Ray::free(near, unit(far - near)) };
                // A plane within a rounding error of `far` from a point counts as beside it.
                assert!(size > 1e9 || !without_sky.occluded(&ray), "{near} {far}");
            }
        }
        assert!((1000..19_000).contains(&clear), "{clear} at {size}");
    }
}
