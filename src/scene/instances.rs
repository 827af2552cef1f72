//! Groups of shapes that are stored once and seen in many places.

use super::Shape;
use super::owners::Owners;
use crate::math::frame::unit;
use crate::math::ray::{NO_PRIMITIVE, position_error};
use crate::math::{DVec3, Ray, Transform};
use crate::shape::accel::{Accel, Instance};
use crate::shape::{Geometry, Hit, SurfacePoint};
use std::sync::Arc;

/// Shapes in coordinates of their own, numbered from 0.
pub struct ShapeGroup {
    shapes: Vec<Shape>,
    owners: Owners,
    tree: Arc<Accel>,
    /// How many shapes the groups before this one have.
    shapes_before: usize,
}

impl ShapeGroup {
    /// Arranges shapes for searching.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let geometries: Vec<&Geometry> = shapes.iter().map(|s| &s.geometry).collect();
        let tree = Arc::new(Accel::new(&geometries));
        let owners = Owners::new(shapes.iter().map(|s| s.geometry.primitives()));
        Self { shapes, owners, tree, shapes_before: 0 }
    }

    /// The shape that a primitive of the group belongs to, and its number there.
    fn shape_of(&self, primitive: u32) -> (&Shape, u32) {
        let shape = &self.shapes[self.owners.of(primitive)];
        (shape, primitive - shape.first_primitive)
    }
}

/// All groups and all their instances. The primitives of every instance have numbers of their own, after
/// those of the scene's other shapes.
#[derive(Default)]
pub struct Instances {
    groups: Vec<ShapeGroup>,
    /// The group of each instance, and the transform from the group's coordinates to the world's.
    placements: Vec<(u32, Transform)>,
    /// Instances by primitive, counted from `first`.
    owners: Owners,
    /// Number of the first primitive of all instances.
    first: u32,
}

impl Instances {
    /// Adds a group without placements; returns its number.
    pub fn add_group(&mut self, group: ShapeGroup) -> u32 {
        let shapes_before = self.groups.last().map_or(0, |last| last.shapes_before + last.shapes.len());
        self.groups.push(ShapeGroup { shapes_before, ..group });
        self.groups.len() as u32 - 1
    }

    /// Whether a group has no shapes, so that there is nothing to place.
    pub fn is_empty_group(&self, group: u32) -> bool {
        self.groups[group as usize].shapes.is_empty()
    }

    /// Adds an instance of a group; returns its box and its number of primitives.
    pub fn place(&mut self, group: u32, to_world: Transform) -> ((DVec3, DVec3), u32) {
        self.placements.push((group, to_world));
        let tree = self.tree(group, to_world);
        (tree.bounds(), tree.primitives())
    }

    fn tree(&self, group: u32, to_world: Transform) -> Instance {
        Instance::new(self.groups[group as usize].tree.clone(), to_world)
    }

    /// The acceleration structure of each instance.
    pub fn trees(&self) -> Vec<Instance> {
        self.placements.iter().map(|&(group, to_world)| self.tree(group, to_world)).collect()
    }

    /// The shapes of each group, in coordinates of its own.
    pub fn groups(&self) -> impl Iterator<Item = &[Shape]> {
        self.groups.iter().map(|group| &group.shapes[..])
    }

    /// The number of each instance's group, and the transform from the group's coordinates to the world's.
    pub fn placements(&self) -> impl Iterator<Item = (usize, &Transform)> {
        self.placements.iter().map(|(group, to_world)| (*group as usize, to_world))
    }

    /// Numbers all primitives, after `first` others.
    pub fn after(mut self, first: u32) -> Self {
        self.owners = Owners::new(
            self.placements.iter().map(|&(group, _)| self.groups[group as usize].tree.primitives()),
        );
        self.first = if self.placements.is_empty() { NO_PRIMITIVE } else { first };
        self
    }

    /// Number of instances.
    pub fn len(&self) -> usize {
        self.placements.len()
    }

    pub fn is_empty(&self) -> bool {
        self.placements.is_empty()
    }

    /// The shapes of all groups.
    pub fn shapes(&self) -> impl Iterator<Item = &Shape> {
        self.groups.iter().flat_map(|group| &group.shapes)
    }

    /// Bytes of the groups' search structures.
    pub fn search_bytes(&self) -> usize {
        self.groups.iter().map(|group| group.tree.bytes()).sum()
    }

    /// Whether a primitive is one of an instance.
    #[inline(always)]
    pub fn have(&self, primitive: u32) -> bool {
        primitive >= self.first
    }

    /// The instance that a primitive belongs to: its transform and its group, and the number of the primitive
    /// there.
    fn find(&self, primitive: u32) -> (&Transform, &ShapeGroup, u32) {
        let placement = self.owners.of(primitive - self.first);
        let (group, to_world) = &self.placements[placement];
        (to_world, &self.groups[*group as usize], primitive - self.first - self.owners.start(placement))
    }

    /// The number of the shape that a primitive belongs to, among those of all groups.
    pub fn shape_index(&self, primitive: u32) -> usize {
        let (_, group, local) = self.find(primitive);
        group.shapes_before + group.owners.of(local)
    }

    /// See [`Scene::point_error`](super::Scene::point_error): that of the group's point, placed, and that of
    /// placing it.
    pub fn point_error(&self, primitive: u32, p: DVec3) -> f64 {
        let (to_world, group, local) = self.find(primitive);
        let there = to_world.inverted().point(p);
        error_of_placing(to_world, there, group.shape_of(local).0.geometry.point_error())
    }

    /// The shape that a primitive belongs to, and its number there.
    pub fn shape_of(&self, primitive: u32) -> (&Shape, u32) {
        let (_, group, local) = self.find(primitive);
        group.shape_of(local)
    }

    /// The surface at a hit: that of the group, placed. Normals are transformed by the inverse transpose, so
    /// that they keep their side under a mirroring transform.
    #[inline(never)]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        let (to_world, group, local) = self.find(hit.primitive);
        let (shape, local) = group.shape_of(local);
        // Quadrics compute their point from that of the ray, and need nothing else of it.
        let there = Ray::free(to_world.inverted().point(ray.at(hit.t)), ray.direction);
        let point = shape.geometry.point::<true>(&there, &Hit { t: 0.0, ..*hit }, local);
        let placed = SurfacePoint {
            p: to_world.point(point.p),
            ng: unit(to_world.normal(point.ng)),
            ns: unit(to_world.normal(point.ns)),
            uv: point.uv,
            dp_du: to_world.vector(point.dp_du),
            dp_dv: to_world.vector(point.dp_dv),
            error: error_of_placing(to_world, point.p, point.error),
        };
        (shape, placed)
    }
}

/// A bound of the error of a placed point, given that of the point `p` of a group.
fn error_of_placing(to_world: &Transform, p: DVec3, error: f64) -> f64 {
    let (m, at) = (to_world.matrix, p.abs());
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().abs());
    let terms = axes[0] * at.x + axes[1] * at.y + axes[2] * at.z + m.w_axis.truncate().abs();
    let stretch = (axes[0] + axes[1] + axes[2]).max_element();
    stretch * error + position_error(terms)
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::math::{DVec2, DVec3, Ray, length, warp};
    use crate::render::{Progress, Settings, render};
    use crate::scene::{Features, Scene};
    use crate::spectrum::ColorMode;
    use rand_pcg::{Pcg32, rand_core::Rng};

    /// Two places, and the shapes that stand in them.
    const PLACES: [&str; 2] = [
        r#"<scale value="0.5"/><rotate x="1" y="2" angle="40"/><translate x="-0.8" y="0.3"/>"#,
        r#"<rotate z="1" angle="-110"/><scale value="0.75"/><translate x="0.9" z="0.4"/>"#,
    ];
    const SHAPES: [(&str, &str); 4] = [
        ("cube", r#"<scale value="0.4"/><translate y="0.5"/>"#),
        ("sphere", r#"<scale value="0.3"/><translate x="0.6"/>"#),
        ("cylinder", r#"<scale value="0.3"/><rotate x="1" angle="25"/><translate x="-0.6"/>"#),
        ("rectangle", r#"<scale x="1.2" y="0.7"/><translate z="-0.5"/>"#),
    ];

    fn shape(kind: &str, steps: &str) -> String {
        let material = r#"<bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha_u" value="0.4"/>
            <float name="alpha_v" value="0.1"/></bsdf></bsdf>"#;
        format!(r#"<shape type="{kind}"><transform name="to_world">{steps}</transform>{material}</shape>"#)
    }

    fn scene(content: &str) -> Scene {
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"><transform name="to_world">
            <lookat origin="0, 1, -5" target="0, 0, 0" up="0, 1, 0"/></transform><film type="hdrfilm">
            <integer name="width" value="24"/><integer name="height" value="16"/></film></sensor>
            <emitter type="point"><point name="position" x="1" y="3" z="-3"/></emitter>{content}</scene>"#
        );
        load_text("scene.xml", &text, ColorMode::Rgb).unwrap()
    }

    fn instanced() -> Scene {
        let members: String = SHAPES.iter().map(|(kind, steps)| shape(kind, steps)).collect();
        let placements = PLACES.map(|place| {
            format!(r#"<shape type="instance"><ref id="g"/><transform name="to_world">{place}</transform></shape>"#)
        });
        scene(&format!(r#"<shape type="shapegroup" id="g">{members}</shape>{}"#, placements.concat()))
    }

    #[test]
    fn a_group_may_be_empty() {
        let ball = shape("sphere", "");
        let empty = r#"<shape type="shapegroup" id="g"/><shape type="instance"><ref id="g"/></shape>"#;
        let (with, without) = (scene(&format!("{empty}{ball}")), scene(&ball));
        assert_eq!((with.instances.len(), with.accel.primitives()), (0, without.accel.primitives()));
    }

    #[test]
    fn an_instance_may_stand_anywhere_in_the_file() {
        let (group, placement) = (
            format!(r#"<shape type="shapegroup" id="g">{}</shape>"#, shape("cube", "")),
            r#"<shape type="instance"><ref id="g"/></shape>"#,
        );
        let others: Vec<String> = PLACES
            .iter()
            .flat_map(|p| SHAPES.map(|(kind, steps)| shape(kind, &[steps, p].concat())))
            .collect();
        let last = scene(&format!("{group}{}{placement}", others.concat()));
        for first in 0..others.len() {
            let (before, after) = others.split_at(first);
            let moved = scene(&format!("{group}{}{placement}{}", before.concat(), after.concat()));
            for primitive in 0..last.accel.primitives() {
                let [a, b] = [&last, &moved].map(|s| {
                    let (shape, local) = s.shape_of(primitive);
                    (s.shape_index(primitive), local, shape.geometry.bounds())
                });
                assert_eq!(a, b, "primitive {primitive} where {first} shapes stand before the instance");
            }
        }
    }

    fn flattened() -> Scene {
        let placed =
            |place: &&str| SHAPES.map(|(kind, steps)| shape(kind, &[steps, place].concat())).concat();
        scene(&PLACES.iter().map(placed).collect::<String>())
    }

    #[test]
    fn an_instance_has_the_surface_of_its_shapes_in_that_place() {
        let (a, b) = (flattened(), instanced());
        assert_eq!((a.instances.len(), b.instances.len(), b.shapes.len()), (0, 2, 0));
        assert_eq!(a.accel.primitives(), b.accel.primitives());
        let mut rng = Pcg32::new(21, 1);
        let mut uniform = || rng.next_u32() as f64 / 4294967296.0;
        let mut hits = 0;
        for _ in 0..20_000 {
            let origin = warp::sphere(DVec2::new(uniform(), uniform())) * 3.0;
            let target = warp::sphere(DVec2::new(uniform(), uniform())) * uniform();
            let ray = Ray::free(origin, crate::math::frame::unit(target - origin));
            let (Some(hit), Some(other)) = (a.accel.closest(&ray), b.accel.closest(&ray)) else { continue };
            if a.shape_of(hit.primitive).1 != b.shape_of(other.primitive).1 || (hit.t - other.t).abs() > 1e-5
            {
                // Within the rounding of vertices of an edge.
                continue;
            }
            hits += 1;
            let (p, q) = (
                a.surface::<{ Features::ALL }>(&ray, &hit).1,
                b.surface::<{ Features::ALL }>(&ray, &other).1,
            );
            let close = |x: DVec3, y: DVec3| length(x - y) <= 1e-5 * (1.0 + length(x));
            assert!(close(p.p, q.p) && close(p.ng, q.ng) && close(p.ns, q.ns), "{p:?} {q:?}");
            assert!(close(p.dp_du, q.dp_du) && close(p.dp_dv, q.dp_dv), "{p:?} {q:?}");
            assert!((p.uv - q.uv).length() < 1e-5, "{p:?} {q:?}");
        }
        assert!(hits > 5_000, "{hits}");
    }

    /// The same numbers choose the same paths but for rounding, so the images differ by far less than their
    /// noise.
    #[test]
    fn an_instance_looks_like_its_shapes() {
        let image = |scene: &Scene| {
            let settings = Settings { seed: 3, ..Settings::of(scene, 0..16) };
            render(scene, &settings, &Progress::default()).unwrap().0
        };
        let (a, b) = (image(&flattened()), image(&instanced()));
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        for (p, q) in a.channels.iter().zip(&b.channels) {
            let apart: f64 = p.mean.iter().zip(&q.mean).map(|(x, y)| f64::from((x - y).abs())).sum();
            assert!(sum(&p.mean) > 0.0 && apart < 1e-3 * sum(&p.mean), "{}: {apart}", p.name);
        }
    }
}
