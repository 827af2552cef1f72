//! Groups of shapes that are held once and seen in many places.

use super::Shape;
use super::owners::Owners;
use crate::math::frame::unit;
use crate::math::{DVec3, Ray, Transform};
use crate::shape::accel::{Accel, Instance};
use crate::shape::{Geometry, Hit, SurfacePoint};
use std::sync::Arc;

/// Shapes in coordinates of their own, numbered from 0.
pub struct Group {
    shapes: Vec<Shape>,
    owners: Owners,
    tree: Arc<Accel>,
}

impl Group {
    /// Arranges shapes for searching.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let geometries: Vec<&Geometry> = shapes.iter().map(|s| &s.geometry).collect();
        let tree = Arc::new(Accel::new(&geometries));
        let owners = Owners::new(shapes.iter().map(|s| s.geometry.primitives()));
        Self { shapes, owners, tree }
    }
}

/// All groups and all their looks. The primitives of every look have numbers of their own, which follow upon
/// those of the scene's other shapes.
#[derive(Default)]
pub struct Instances {
    groups: Vec<Group>,
    /// The group, and from its coordinates to the world's.
    looks: Vec<(u32, Transform)>,
    /// Looks by primitive, counted from `first`.
    owners: Owners,
    /// The first of all primitives here.
    first: u32,
}

impl Instances {
    /// Adds a group that nothing is seen of yet; answers with its number.
    pub fn add_group(&mut self, group: Group) -> u32 {
        self.groups.push(group);
        self.groups.len() as u32 - 1
    }

    /// Adds a look of a group; answers with its box and how many primitives it has.
    pub fn place(&mut self, group: u32, to_world: Transform) -> ((DVec3, DVec3), u32) {
        self.looks.push((group, to_world));
        let tree = Instance::new(self.groups[group as usize].tree.clone(), to_world);
        (tree.bounds(), tree.primitives())
    }

    /// What is to be searched for each look.
    pub fn trees(&self) -> Vec<Instance> {
        let tree = |&(group, to_world): &(u32, Transform)| {
            Instance::new(self.groups[group as usize].tree.clone(), to_world)
        };
        self.looks.iter().map(tree).collect()
    }

    /// Numbers all primitives, after `first` others.
    pub fn after(mut self, first: u32) -> Self {
        self.owners =
            Owners::new(self.looks.iter().map(|&(group, _)| self.groups[group as usize].tree.primitives()));
        self.first = if self.looks.is_empty() { Ray::FREE } else { first };
        self
    }

    /// How many looks there are.
    pub fn len(&self) -> usize {
        self.looks.len()
    }

    pub fn is_empty(&self) -> bool {
        self.looks.is_empty()
    }

    /// The shapes of all groups.
    pub fn shapes(&self) -> impl Iterator<Item = &Shape> {
        self.groups.iter().flat_map(|group| &group.shapes)
    }

    /// The bounding boxes of the looks of groups that have such a shape.
    pub fn bounds_of_groups_with(&self, wanted: impl Fn(&Shape) -> bool) -> Vec<(DVec3, DVec3)> {
        let has = |look: &&(u32, Transform)| self.groups[look.0 as usize].shapes.iter().any(&wanted);
        let bounds = |&(group, to_world): &(u32, Transform)| {
            Instance::new(self.groups[group as usize].tree.clone(), to_world).bounds()
        };
        self.looks.iter().filter(has).map(bounds).collect()
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

    fn find(&self, primitive: u32) -> (&Transform, &Shape, u32) {
        let look = self.owners.of(primitive - self.first);
        let (group, to_world) = &self.looks[look];
        let group = &self.groups[*group as usize];
        let local = primitive - self.first - self.owners.start(look);
        let shape = &group.shapes[group.owners.of(local)];
        (to_world, shape, local - shape.first_primitive)
    }

    /// The shape that a primitive belongs to, and its number there.
    pub fn shape_of(&self, primitive: u32) -> (&Shape, u32) {
        let (_, shape, local) = self.find(primitive);
        (shape, local)
    }

    /// The surface at a hit: that of the group, placed. Normals go with the inverse transpose, so that they
    /// keep their side under a mirroring transform.
    #[inline(never)]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        let (to_world, shape, local) = self.find(hit.primitive);
        // Quadrics find their point by that of the ray, of which nothing else is asked.
        let there = Ray::free(to_world.inverted().point(ray.at(hit.t)), ray.direction);
        let point = shape.geometry.point::<true>(&there, &Hit { t: 0.0, ..*hit }, local);
        let placed = SurfacePoint {
            p: to_world.point(point.p),
            ng: unit(to_world.normal(point.ng)),
            ns: unit(to_world.normal(point.ns)),
            uv: point.uv,
            dp_du: to_world.vector(point.dp_du),
            dp_dv: to_world.vector(point.dp_dv),
        };
        (shape, placed)
    }
}

#[cfg(test)]
mod tests {
    use crate::math::{DVec2, DVec3, Ray, length, warp};
    use crate::render::{Progress, Settings, render};
    use crate::scene::{Features, Scene, load_text};
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
        let looks = PLACES.map(|place| {
            format!(r#"<shape type="instance"><ref id="g"/><transform name="to_world">{place}</transform></shape>"#)
        });
        scene(&format!(r#"<shape type="shapegroup" id="g">{members}</shape>{}"#, looks.concat()))
    }

    #[test]
    fn an_instance_may_stand_anywhere_in_the_file() {
        let (group, look) = (
            format!(r#"<shape type="shapegroup" id="g">{}</shape>"#, shape("cube", "")),
            r#"<shape type="instance"><ref id="g"/></shape>"#,
        );
        let others: Vec<String> = PLACES
            .iter()
            .flat_map(|p| SHAPES.map(|(kind, steps)| shape(kind, &[steps, p].concat())))
            .collect();
        let last = scene(&format!("{group}{}{look}", others.concat()));
        for first in 0..others.len() {
            let (before, after) = others.split_at(first);
            let moved = scene(&format!("{group}{}{look}{}", before.concat(), after.concat()));
            for primitive in 0..last.accel.primitives() {
                let [a, b] = [&last, &moved].map(|s| {
                    let (shape, local) = s.shape_of(primitive);
                    (s.index_of(shape), local, shape.geometry.bounds())
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
