//! Instances: a tree that is stored once and searched in many places.
//!
//! A ray is transformed into the coordinates of the group, where lengths differ from the world's by a factor
//! of its own, and the group is searched as if it were the scene. Each instance offers its closest hit, so by
//! (distance, primitive) nothing depends on the order in which instances are searched.

use super::stack::Query;
use super::{Accel, Search};
use crate::math::bounds::{around, corners};
use crate::math::ray::{Ends, position_error};
use crate::math::{Bounds, DVec3, Ray, Transform, length};
use crate::shape::Hit;
use std::sync::Arc;

/// A group, placed in the world.
#[derive(Clone)]
pub struct Instance {
    group: Arc<Accel>,
    to_world: Transform,
    /// The number of this instance's first primitive.
    first: u32,
}

/// Factor by which a search in a group goes farther, so that what lies at the best distance is not lost:
/// distances are multiplied once for the group and divided once after it, each with an error of at most 2⁻⁵³.
const TWO_ROUNDINGS: f64 = 1.0 + 1.0 / (1u64 << 51) as f64;

impl Instance {
    /// A group placed by an affine map. [`Accel::with_instances`] numbers its primitives.
    pub fn new(group: Arc<Accel>, to_world: Transform) -> Self {
        Self { group, to_world, first: 0 }
    }

    /// Numbers the primitives from `first` on; returns the first number after them.
    pub(super) fn number(&mut self, first: u32) -> u32 {
        self.first = first;
        first + self.group.primitives
    }

    /// How many primitives there are.
    pub fn primitives(&self) -> u32 {
        self.group.primitives
    }

    /// The corners of a box around the placed box of the group.
    pub fn bounds(&self) -> Bounds {
        around(corners(self.group.bounds).map(|corner| self.to_world.point(corner)))
    }

    /// The ray in the group's coordinates, and by how much distances are longer there.
    fn enter(&self, ray: &Ray, end: f64) -> (Ray, f64) {
        let to_group = self.to_world.inverted();
        let origin = to_group.point(ray.origin);
        let direction = to_group.vector(ray.direction);
        let stretch = length(direction);
        let from = ray.from.wrapping_sub(self.first);
        let local = Ray {
            origin,
            direction: direction / stretch,
            start: if ray.start > 0.0 { ray.start * stretch + self.rounding(ray.origin) } else { 0.0 },
            end: end * stretch * TWO_ROUNDINGS,
            from: if from < self.group.primitives { from } else { Ray::FREE },
            // The walls of a group are no walls of the scene.
            ends: Ends::Anywhere,
        };
        (local, stretch)
    }

    /// A bound of the rounding error of a point that is transformed into the group: Σ|mᵢⱼ||pⱼ| + |tᵢ| bounds
    /// the terms of each coordinate, of which a few are rounded here and a few were when the point was
    /// transformed out of a group.
    fn rounding(&self, p: DVec3) -> f64 {
        let m = &self.to_world.inverse;
        let terms = m.x_axis.abs() * p.x.abs() + m.y_axis.abs() * p.y.abs() + m.z_axis.abs() * p.z.abs();
        position_error(terms.truncate() + m.w_axis.truncate().abs())
    }

    /// Offers the first primitive along the ray, or any one before its end.
    #[inline(never)]
    pub(super) fn intersect<O: Query>(&self, search: &mut Search) {
        let (local, stretch) = self.enter(search.ray, search.best.t);
        let mut offer = |hit: Option<Hit>| {
            if let Some(hit) = hit {
                search.offer(hit.t / stretch, hit.u, hit.v, self.first + hit.primitive);
            }
            search.found()
        };
        // The hit found may lie beyond the end by a rounding error, while another one lies before it.
        if !(O::ANY && offer(self.group.any(&local))) {
            offer(self.group.closest(&local));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::closest_hit::ClosestHit;
    use super::*;
    use crate::math::random::{direction, uniform};
    use crate::shape::mesh_data::MeshData;
    use crate::shape::patch::Outline;
    use crate::shape::{Cylinder, Geometry, Mesh, Normals, Patch, Sphere};
    use rand_pcg::Pcg32;

    /// A convex ball of triangles, its vertices rounded to a grid.
    fn ball(place: &Transform, grid: f64) -> Geometry {
        const RINGS: u32 = 12;
        let (mut positions, mut triangles) = (vec![], vec![]);
        for i in 0..=RINGS {
            for j in 0..RINGS {
                let (sin, cos) = libm::sincos(std::f64::consts::PI * i as f64 / RINGS as f64);
                let (s, c) = libm::sincos(std::f64::consts::TAU * j as f64 / RINGS as f64);
                positions.push([sin * c, sin * s, cos].map(|v| ((v / grid).round() * grid) as f32));
                if i < RINGS {
                    let (k, next) = (i * RINGS, (j + 1) % RINGS);
                    triangles.push([k + j, k + RINGS + j, k + RINGS + next]);
                    triangles.push([k + j, k + RINGS + next, k + next]);
                }
            }
        }
        let data = MeshData { positions, triangles, ..MeshData::default() };
        Geometry::Mesh(Mesh::new(data, place, Normals::OF_FACES))
    }

    /// One of each kind of shape, placed.
    fn pieces(place: &Transform) -> Vec<Geometry> {
        let aside = place.after(&Transform::translate(DVec3::new(1.5, 0.5, 0.0)));
        vec![
            ball(place, 1.0 / 1024.0),
            Geometry::Patch(Patch::new(&aside, false, Outline::Square)),
            Geometry::Sphere(Sphere::new(place, DVec3::new(-1.5, 0.0, 0.5), 0.5, false)),
            Geometry::Cylinder(Cylinder::new(
                place,
                DVec3::new(0.0, 2.0, 0.0),
                DVec3::new(0.5, 2.5, 1.0),
                0.25,
                false,
            )),
        ]
    }

    fn group() -> Arc<Accel> {
        let shapes = pieces(&Transform::IDENTITY);
        Arc::new(Accel::new(&shapes.iter().collect::<Vec<_>>()))
    }

    fn turned(rng: &mut Pcg32) -> Transform {
        let scale = Transform::scale(DVec3::splat(0.5 + uniform(rng))).unwrap();
        let turn = Transform::rotate(direction(rng), 360.0 * uniform(rng)).unwrap();
        Transform::translate(direction(rng) * 4.0).after(&turn).after(&scale)
    }

    #[test]
    fn instances_are_met_where_their_shapes_would_be() {
        // Powers of two and quarter turns of vertices on a grid: f32 holds the flattened ones exactly.
        let mirror = Transform::scale(DVec3::new(-2.0, 2.0, 2.0)).unwrap();
        let quarter = Transform::from_matrix(glam::DMat4::from_cols_array(&[
            0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 4.0, -2.0, 1.0, 1.0,
        ]));
        let places = [
            Transform::IDENTITY,
            Transform::translate(DVec3::new(-6.0, 0.0, 2.0)).after(&mirror),
            quarter.unwrap(),
        ];
        let flat: Vec<Geometry> = places.iter().flat_map(pieces).collect();
        let flat = Accel::new(&flat.iter().collect::<Vec<_>>());
        let group = group();
        let placed =
            Accel::with_instances(&[], places.map(|place| Instance::new(group.clone(), place)).to_vec());
        assert_eq!(flat.primitives(), placed.primitives());
        let mut rng = Pcg32::new(11, 1);
        let mut hits = 0;
        for _ in 0..50_000 {
            let ray = Ray::free(direction(&mut rng) * 12.0 * uniform(&mut rng), direction(&mut rng));
            match (flat.closest(&ray), placed.closest(&ray)) {
                (None, None) => {}
                (Some(a), Some(b)) => {
                    hits += 1;
                    // A ray within rounding of a shared edge may meet either triangle.
                    assert!((a.t - b.t).abs() <= 1e-12 * (1.0 + a.t), "{ray:?}: {a:?} {b:?}");
                    assert!(a.primitive == b.primitive || (a.u * a.v * (1.0 - a.u - a.v)).abs() < 1e-9);
                }
                (a, b) => panic!("{ray:?}: {a:?} {b:?}"),
            }
        }
        assert!(hits > 5_000, "{hits}");
    }

    #[test]
    fn the_tree_finds_what_trying_every_instance_finds() {
        let mut rng = Pcg32::new(12, 1);
        let group = group();
        let uneven = Transform::scale(DVec3::new(0.5, 2.0, -1.0)).unwrap();
        let mut places: Vec<Transform> = (0..40).map(|_| turned(&mut rng).after(&uneven)).collect();
        // Twice the same: every hit is a tie.
        places.push(places[0]);
        let own = [Geometry::Sphere(Sphere::new(&Transform::IDENTITY, DVec3::ZERO, 0.7, false))];
        let own: Vec<&Geometry> = own.iter().collect();
        let all =
            |range: &[Transform]| range.iter().map(|p| Instance::new(group.clone(), *p)).collect::<Vec<_>>();
        let scene = Accel::with_instances(&own, all(&places));
        let exhaustive = |ray: &Ray| {
            let mut search = Search::new(ray);
            for instance in scene.instances.iter().rev() {
                instance.intersect::<ClosestHit>(&mut search);
            }
            if let Some(hit) = Accel::new(&own).closest(ray) {
                search.offer(hit.t, hit.u, hit.v, hit.primitive);
            }
            search.found().then_some(search.best)
        };
        let mut hits = 0;
        for _ in 0..20_000 {
            let mut ray = Ray::free(direction(&mut rng) * 6.0 * uniform(&mut rng), direction(&mut rng));
            let found = scene.closest(&ray);
            assert_eq!(found, exhaustive(&ray), "{ray:?}");
            assert_eq!(found.is_some(), scene.occluded(&ray));
            if let Some(hit) = found {
                hits += 1;
                ray.end = hit.t;
                assert!(!scene.occluded(&ray), "{ray:?}");
                ray.end = hit.t.next_up();
                assert!(scene.occluded(&ray), "{ray:?}");
                let onward = Ray::leaving(ray.at(hit.t), direction(&mut rng), f64::INFINITY, hit.primitive);
                assert_eq!(scene.closest(&onward), exhaustive(&onward), "{onward:?}");
            }
        }
        assert!(hits > 5_000, "{hits}");
    }

    #[test]
    fn rays_that_leave_a_convex_instance_do_not_meet_it() {
        let shape = ball(&Transform::IDENTITY, 1e-9);
        let group = Arc::new(Accel::new(&[&shape]));
        let Geometry::Mesh(mesh) = &shape else { unreachable!() };
        let far = Transform::translate(DVec3::new(3e7, -1e7, 2e7));
        for place in [turned(&mut Pcg32::new(5, 1)), far] {
            let scene = Accel::with_instances(&[], vec![Instance::new(group.clone(), place)]);
            let mut rng = Pcg32::new(13, 1);
            for i in 0..20_000u32 {
                let triangle = i % mesh.triangles.len() as u32;
                // Near a corner, where neighbours are close.
                let (u, v) = (1e-9 * uniform(&mut rng), 1e-9 * uniform(&mut rng));
                let point = mesh.point::<false>(triangle, u, v);
                if !point.ng.is_finite() {
                    continue;
                }
                let ng = crate::math::frame::unit(place.normal(point.ng));
                let outward = direction(&mut rng);
                let outward = if outward.dot(ng) < 0.0 { -outward } else { outward };
                // Two triangles that are a quad may enclose a little less than 180°: vertices are f32.
                if outward.dot(ng) < 1e-3 {
                    continue;
                }
                let ray = Ray::leaving(place.point(point.p), outward, f64::INFINITY, triangle);
                assert!(scene.closest(&ray).is_none(), "{ray:?}");
            }
        }
    }

    #[test]
    fn scaling_by_a_power_of_two_scales_every_hit_exactly() {
        let group = group();
        let place = turned(&mut Pcg32::new(6, 1));
        for exponent in [-40, 27] {
            let factor = libm::scalbn(1.0, exponent);
            let larger = Transform::scale(DVec3::splat(factor)).unwrap().after(&place);
            let one = Accel::with_instances(&[], vec![Instance::new(group.clone(), place)]);
            let scaled = Accel::with_instances(&[], vec![Instance::new(group.clone(), larger)]);
            let mut rng = Pcg32::new(14, 1);
            for _ in 0..5_000 {
                let (o, d) = (direction(&mut rng) * 8.0, direction(&mut rng));
                let found = one.closest(&Ray::free(o, d));
                let expected = found.map(|hit| Hit { t: hit.t * factor, ..hit });
                assert_eq!(scaled.closest(&Ray::free(o * factor, d)), expected);
            }
        }
    }
}
