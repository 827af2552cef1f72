//! Whether nothing stands between many points and one.
//!
//! All ways from points near each other to a common one lie in the hull of the one and a box around the many. Where no primitive
//! reaches into it, one question spares as many shadow rays (Haines and Wallace 1991, "Shaft Culling for Efficient
//! Ray-Cast Radiosity"). "Not clear" is no answer: then rays have to tell.

use super::hull::Hull;
use super::node::{Node, NodeRef, Target};
use super::{Accel, Mixed};
use crate::math::ray::position_error;
use crate::math::{DVec3, frame};

/// So many nodes are looked at before rays are thought cheaper.
const PATIENCE: usize = 48;

/// What a flat primitive lies in.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    at: DVec3,
    /// Unit length; NaN where there is no area, which no comparison takes for one side.
    normal: DVec3,
}

impl Plane {
    /// Through `at`, with any length of normal.
    pub fn new(at: DVec3, normal: DVec3) -> Self {
        Self { at, normal: frame::unit(normal) }
    }

    pub fn of_corners([a, b, c]: [DVec3; 3]) -> Self {
        Self::new(a, (b - a).cross(c - a))
    }

    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.at)
    }
}

/// Many points, and what has been found out about them.
#[derive(Default)]
pub struct Shaft {
    points: Vec<DVec3>,
    /// The corners of a box around them.
    bounds: (DVec3, DVec3),
    /// How far they lie before the plane of a primitive: least and most.
    heights: Vec<(u32, [f64; 2])>,
    waiting: Vec<NodeRef>,
}

impl Shaft {
    /// Begins anew with other points.
    pub fn begin(&mut self, points: impl Iterator<Item = DVec3>) {
        self.points.clear();
        self.points.extend(points);
        self.heights.clear();
        let nothing = (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
        self.bounds = self.points.iter().fold(nothing, |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    }

    /// How many points there are.
    pub fn count(&self) -> usize {
        self.points.len()
    }

    /// Whether all points and `to` lie on one side of a primitive's plane, or on it as far as rounding lets one tell.
    fn is_beside(&mut self, primitive: u32, plane: &Plane, to: DVec3) -> bool {
        let known = self.heights.iter().find(|known| known.0 == primitive);
        let [least, most] = known.map(|known| known.1).unwrap_or_else(|| {
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            let heights =
                self.points.iter().map(|p| plane.height(*p)).fold(start, |[least, most], height| {
                    // Unlike `f64::min`, this lets a NaN stay.
                    [if height >= least { least } else { height }, if height <= most { most } else { height }]
                });
            self.heights.push((primitive, heights));
            heights
        });
        let farthest = self.bounds.0.abs().max(self.bounds.1.abs()).max(to.abs());
        let error = 4.0 * (position_error(farthest) + position_error(plane.at));
        let height = plane.height(to);
        (least >= -error && height >= -error) || (most <= error && height <= error)
    }
}

/// All primitives of a scene that has no tree, for shafts.
#[derive(Default)]
pub struct Few {
    pub boxes: Vec<Node>,
    /// In the order of the boxes: the number, and the plane if it is flat.
    pub primitives: Vec<(u32, Option<Plane>)>,
}

/// What is asked: whether something comes between the points of a shaft and `to`, which lies on primitive `on`.
struct Question<'a> {
    shaft: &'a mut Shaft,
    hull: Hull,
    to: DVec3,
    on: u32,
}

impl Question<'_> {
    /// Whether a flat primitive cannot come between.
    fn is_beside(&mut self, (primitive, plane): (u32, Plane)) -> bool {
        primitive == self.on || self.shaft.is_beside(primitive, &plane, self.to)
    }
}

impl Accel {
    /// Whether nothing can come between `to` and any of the points. `to` lies on primitive `on`, which cannot do so if it is flat.
    pub fn is_clear(&self, shaft: &mut Shaft, to: DVec3, on: u32) -> bool {
        let hull = Hull::new(&self.space, shaft.bounds, to);
        let mut waiting = std::mem::take(&mut shaft.waiting);
        let mut question = Question { shaft, hull, to, on };
        let clear = if self.nodes.is_empty() {
            self.few.is_clear(&mut question)
        } else {
            self.tree_is_clear(&mut question, &mut waiting)
        };
        shaft.waiting = waiting;
        clear
    }

    fn tree_is_clear(&self, question: &mut Question, waiting: &mut Vec<NodeRef>) -> bool {
        waiting.clear();
        waiting.push(NodeRef::ROOT);
        for _ in 0..PATIENCE {
            let Some(next) = waiting.pop() else { return true };
            match next.target() {
                Target::Node(index) => {
                    let node = &self.nodes[index];
                    let met = lanes(question.hull.meets(node));
                    waiting.extend(met.map(|lane| node.children[lane]));
                }
                Target::Triangles(index) if self.block_is_beside(index, question) => {}
                Target::Mixed(index) if self.mixed_is_beside(&self.mixed[index], question) => {}
                _ => return false,
            }
        }
        false
    }

    fn block_is_beside(&self, block: usize, question: &mut Question) -> bool {
        self.triangles[block].corners().all(|(primitive, corners)| {
            question.is_beside((primitive, Plane::of_corners(corners))) || {
                let [a, b, c] = corners;
                !question.hull.meets_box(&self.space, (a.min(b).min(c), a.max(b).max(c)))
            }
        })
    }

    fn mixed_is_beside(&self, mixed: &Mixed, question: &mut Question) -> bool {
        let block = |block: Option<u32>| block.map(|block| block as usize);
        let spheres = block(mixed.spheres).into_iter().flat_map(|block| self.spheres[block].bounds());
        let cylinders = self.cylinders[mixed.cylinders.start as usize..mixed.cylinders.end as usize].iter();
        let instances = mixed.instances.iter().map(|i| self.instances[*i as usize].bounds());
        let mut round = spheres.chain(cylinders.map(|(cylinder, _)| cylinder.bounds())).chain(instances);
        let mut patches = block(mixed.patches).into_iter().flat_map(|block| self.patches[block].outlines());
        round.all(|bounds| !question.hull.meets_box(&self.space, bounds))
            && patches.all(|(primitive, plane, bounds)| {
                question.is_beside((primitive, plane)) || !question.hull.meets_box(&self.space, bounds)
            })
            && block(mixed.triangles).is_none_or(|block| self.block_is_beside(block, question))
    }
}

impl Few {
    fn is_clear(&self, question: &mut Question) -> bool {
        self.boxes.iter().zip(self.primitives.chunks(8)).all(|(node, primitives)| {
            lanes(question.hull.meets(node)).all(|lane| {
                let (primitive, plane) = primitives[lane];
                plane.is_some_and(|plane| question.is_beside((primitive, plane)))
            })
        })
    }
}

/// The places of the bits that are set.
fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec2, Ray, Transform, length, warp};
    use crate::shape::mesh_data::MeshData;
    use crate::shape::{Geometry, Mesh, Patch, Sphere, patch::Outline};
    use rand_pcg::{Pcg32, rand_core::Rng};

    fn uniform(rng: &mut Pcg32) -> f64 {
        rng.next_u32() as f64 / 4294967296.0
    }

    /// Patches, balls and a mesh of single triangles, somewhere in a cube.
    fn clutter(rng: &mut Pcg32, count: usize) -> Vec<Geometry> {
        let mut data = MeshData::default();
        let mut shapes = vec![];
        for i in 0..count {
            let at = DVec3::new(uniform(rng), uniform(rng), uniform(rng)) * 4.0;
            let axis = warp::sphere(DVec2::new(uniform(rng), uniform(rng)));
            let size = Transform::scale(DVec3::splat(0.1 + 0.4 * uniform(rng))).unwrap();
            let turn = Transform::rotate(axis, 360.0 * uniform(rng)).unwrap();
            let place = Transform::translate(at).after(&turn).after(&size);
            match i % 4 {
                0 => shapes.push(Geometry::Patch(Patch::new(&place, false, Outline::Square))),
                1 => shapes.push(Geometry::Sphere(Sphere::new(&place, DVec3::ZERO, 0.3, false))),
                2 => shapes.push(Geometry::Patch(Patch::new(&place, false, Outline::Circle))),
                _ => {
                    let first = data.positions.len() as u32;
                    let corners = [DVec3::X, DVec3::Y, -DVec3::X].map(|corner| place.point(corner));
                    data.positions.extend(corners.map(|p| p.to_array().map(|x| x as f32)));
                    data.triangles.push([first, first + 1, first + 2]);
                }
            }
        }
        shapes.push(Geometry::Mesh(Mesh::new(data, &Transform::IDENTITY, false, true)));
        shapes
    }

    /// A spot of a flat primitive, and the point that another is asked about: positions and primitives.
    type Places = (Vec<DVec3>, u32, DVec3, u32);

    fn places(rng: &mut Pcg32, shapes: &[Geometry]) -> Places {
        let mut pick = || {
            let shape = (uniform(rng) * shapes.len() as f64) as usize;
            (shape as u32, DVec2::new(uniform(rng), uniform(rng)))
        };
        let ((from, at), (to, there)) = (pick(), pick());
        let near = |i: u32| {
            let part = DVec2::new(f64::from(i % 4), f64::from(i / 4)) * 0.02;
            shapes[from as usize].sample_area(0.9 * at + part).p
        };
        ((0..16).map(near).collect(), from, shapes[to as usize].sample_area(there).p, to)
    }

    #[test]
    fn what_is_clear_is_seen_by_all() {
        for count in [16, 32, 80, 300] {
            let mut rng = Pcg32::new(0, count as u64);
            let shapes = clutter(&mut rng, count);
            let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
            assert_eq!(accel.node_count() == 0, count < 40);
            let (mut shaft, mut clear, mut free) = (Shaft::default(), 0, 0);
            for _ in 0..5000 {
                let (points, from, to, on) = places(&mut rng, &shapes[..shapes.len() - 1]);
                // Inside of a ball, and behind what one lies on, nothing is asked about.
                let round = |shape: u32| matches!(shapes[shape as usize], Geometry::Sphere(_));
                if from == on || round(from) || round(on) {
                    continue;
                }
                shaft.begin(points.iter().copied());
                let sees = |p: &DVec3| {
                    // A ray meets what it aims at early by its rounding over a small cosine.
                    let end = length(to - *p) * (1.0 - 1e-9);
                    !accel.occluded(&Ray::leaving(*p, (to - *p) / length(to - *p), end, from))
                };
                let all = points.iter().all(sees);
                free += u32::from(all);
                if accel.is_clear(&mut shaft, to, on) {
                    clear += 1;
                    assert!(all, "{points:?} {to}");
                }
            }
            assert!(clear > 100, "{clear} of {free} with {count}");
        }
    }

    #[test]
    fn in_an_empty_room_everything_is_clear_and_a_needle_ends_that() {
        let wall = |axis: DVec3, angle: f64| {
            let turn = Transform::rotate(axis, angle).unwrap();
            Patch::new(&turn.after(&Transform::translate(-DVec3::Z)), false, Outline::Square)
        };
        let walls = [
            (DVec3::X, 0.0),
            (DVec3::X, 90.0),
            (DVec3::X, 180.0),
            (DVec3::X, 270.0),
            (DVec3::Y, 90.0),
            (DVec3::Y, 270.0),
        ];
        let mut shapes: Vec<Geometry> = walls.map(|(axis, angle)| Geometry::Patch(wall(axis, angle))).into();
        let mut rng = Pcg32::new(0, 1);
        let needle = MeshData {
            positions: vec![[0.0, 0.0, -0.3], [0.0, 1e-3, 0.3], [1e-3, 0.0, 0.3]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        let mut shaft = Shaft::default();
        for with_needle in [false, true] {
            if with_needle {
                shapes.push(Geometry::Mesh(Mesh::new(needle.clone(), &Transform::IDENTITY, false, true)));
            }
            let accel = Accel::new(&shapes.iter().collect::<Vec<_>>());
            let mut clear = [0; 2];
            for _ in 0..2000 {
                let (points, from, to, on) = places(&mut rng, &shapes[..6]);
                if from != on {
                    shaft.begin(points.into_iter());
                    clear[usize::from(accel.is_clear(&mut shaft, to, on))] += 1;
                }
            }
            assert_eq!(clear[0] > 0, with_needle, "{clear:?}");
            assert!(clear[1] > 1000, "{clear:?}");
            if with_needle {
                shaft.begin([DVec3::new(-1.0, 0.01, 0.0), DVec3::new(-1.0, -0.01, 0.0)].into_iter());
                assert!(!accel.is_clear(&mut shaft, DVec3::new(1.0, 0.0, 0.0), 0));
            }
        }
    }
}
