//! Lamps that lie in the plane of another surface, such as a panel in a ceiling.
//!
//! Rounding would decide which of the two a ray meets, while an emitter sample ends just before its lamp and
//! arrives: MIS of the two techniques would lose what the surface hides from one of them. So flat lamps are
//! raised a little above whatever they lie in, and cubes that shine grow as much. How little depends on what they
//! lie in: the corners of meshes are rounded to `f32`, which may have put a ceiling before its lamp. Of several
//! lamps in one plane that face the same way, each lies upon those that the file has before it.

use super::Shape;
use super::instances::Instances;
use crate::math::bounds::{around, union};
use crate::math::ray::position_error;
use crate::math::{Bounds, DVec3, bounds};
use crate::shape::{Geometry, Patch};

/// By how many times the errors of computed points a lamp is raised: beyond the errors of both surfaces along a
/// ray, and beyond where emitter samples end ([`free_way`](crate::math::ray::free_way)).
const ERRORS: f64 = 16.0;

/// What a number loses when it is rounded to `f32`, relative to it.
const SINGLE: f64 = 1.0 / (1u64 << 24) as f64;

/// A flat piece of a surface (world), which a lamp may lie in.
struct Facet<'a> {
    corners: &'a [DVec3],
    /// A bound of the rounding error of its points.
    error: f64,
    /// The sizes of the numbers along each axis of space of which its corners have been rounded to `f32`; zero if
    /// they were not.
    rounded: DVec3,
}

impl<'a> Facet<'a> {
    fn new(corners: &'a [DVec3], single: bool) -> Self {
        let size = corners.iter().fold(DVec3::ZERO, |most, corner| most.max(corner.abs()));
        Self::of_size(corners, size, if single { size } else { DVec3::ZERO })
    }

    fn of_size(corners: &'a [DVec3], size: DVec3, rounded: DVec3) -> Self {
        Self { corners, error: position_error(size), rounded }
    }

    /// How far a lamp must be raised to lie upon this, if it lies in it: if all corners are in its plane, by what
    /// both are rounded.
    fn height(&self, lamp: &Patch) -> Option<f64> {
        // Across a level ceiling it is how high it is that has been rounded, not how wide.
        let height =
            ERRORS * (self.error + lamp.point_error()) + 2.0 * SINGLE * self.rounded.dot(lamp.n.abs());
        let in_plane = |corner: &DVec3| lamp.n.dot(*corner - lamp.centre).abs() <= height;
        let meet = |a: Bounds, b: Bounds| {
            (a.0 - DVec3::splat(height)).cmple(b.1).all() && b.0.cmple(a.1 + DVec3::splat(height)).all()
        };
        let lies_in_it =
            self.corners.iter().all(in_plane) && meet(around(self.corners.iter().copied()), lamp.bounds());
        lies_in_it.then_some(height)
    }
}

/// A side of a lamp that emits towards its front.
struct Face {
    /// The number of its shape.
    shape: usize,
    patch: Patch,
    bounds: Bounds,
}

/// The sides of all lamps that are made of patches, so that those near something are found quickly.
struct Faces {
    /// By the least first coordinate.
    sorted: Vec<Face>,
    /// The greatest first coordinate of each and all before it.
    reach: Vec<f64>,
    all: Bounds,
    /// The largest error of their points.
    error: f64,
}

impl Faces {
    fn of(shapes: &[Shape]) -> Self {
        let lamps = shapes.iter().enumerate().filter(|(_, shape)| shape.emitter.is_some());
        let faces = lamps.flat_map(|(number, shape)| {
            let face = move |patch: &Patch| Face { shape: number, patch: *patch, bounds: patch.bounds() };
            patches(&shape.geometry).iter().map(face)
        });
        let mut sorted: Vec<Face> = faces.collect();
        sorted.sort_by(|a, b| a.bounds.0.x.total_cmp(&b.bounds.0.x));
        let reach = sorted.iter().scan(f64::NEG_INFINITY, |reach, face| {
            *reach = reach.max(face.bounds.1.x);
            Some(*reach)
        });
        let reach = reach.collect();
        let all = sorted.iter().map(|face| face.bounds).fold(bounds::NOTHING, union);
        let error = sorted.iter().map(|face| face.patch.point_error()).fold(0.0, f64::max);
        Self { sorted, reach, all, error }
    }

    /// Calls `f` with every face that lies in a facet, and how far it must be raised to lie upon it.
    fn in_facet(&self, facet: &Facet, mut f: impl FnMut(&Face, f64)) {
        // No face needs more than this.
        let slack = ERRORS * (facet.error + self.error) + 2.0 * SINGLE * facet.rounded.element_sum();
        let (lo, hi) = around(facet.corners.iter().copied());
        let (lo, hi) = (lo - DVec3::splat(slack), hi + DVec3::splat(slack));
        if !(lo.cmple(self.all.1).all() && self.all.0.cmple(hi).all()) {
            return;
        }
        let first = self.reach.partition_point(|reach| *reach < lo.x);
        let near = self.sorted[first..].iter().take_while(|face| face.bounds.0.x <= hi.x);
        for face in near {
            if let Some(height) = facet.height(&face.patch) {
                f(face, height);
            }
        }
    }
}

/// The flat sides of a lamp that can be moved: vertices of meshes have fewer digits, and triangles share edges with
/// others.
fn patches(geometry: &Geometry) -> &[Patch] {
    match geometry {
        Geometry::Patch(patch) => std::slice::from_ref(patch),
        Geometry::Cube(cube) => cube.faces(),
        Geometry::Mesh(_) | Geometry::Sphere(_) | Geometry::Cylinder(_) => &[],
    }
}

/// Calls `f` with the corners of every flat piece, and whether they were rounded to `f32`.
fn facets(geometry: &Geometry, mut f: impl FnMut(&[DVec3], bool)) {
    if let Geometry::Mesh(mesh) = geometry {
        (0..mesh.triangles.len() as u32).for_each(|triangle| f(&mesh.corners(triangle), true));
    }
    patches(geometry).iter().for_each(|patch| f(&patch.corners(), false));
}

/// Raises flat lamps, by less than can be seen and more than rounding.
pub fn raise(shapes: &mut [Shape], instances: &Instances) {
    let faces = Faces::of(shapes);
    if faces.sorted.is_empty() {
        return;
    }
    let mut heights = vec![0.0f64; shapes.len()];
    let mut raised = |face: &Face, height: f64| heights[face.shape] = heights[face.shape].max(height);
    for shape in shapes.iter().filter(|shape| shape.emitter.is_none() || patches(&shape.geometry).is_empty())
    {
        facets(&shape.geometry, |corners, single| {
            faces.in_facet(&Facet::new(corners, single), &mut raised);
        });
    }
    for (group, to_world) in instances.placed() {
        for shape in group {
            facets(&shape.geometry, |corners, single| {
                let place = |corner: &DVec3| to_world.point(*corner);
                let placed: Vec<DVec3> = corners.iter().map(place).collect();
                // What its coordinates are sums of, whose roundings do not cancel where they do.
                let size = corners.iter().fold(DVec3::ZERO, |most, corner| most.max(corner.abs()));
                let axes = DVec3::AXES.map(|axis| to_world.vector(axis).abs());
                let spread = axes[0] * size.x + axes[1] * size.y + axes[2] * size.z;
                let rounded = if single { spread } else { DVec3::ZERO };
                let facet = Facet::of_size(&placed, spread + to_world.point(DVec3::ZERO).abs(), rounded);
                faces.in_facet(&facet, &mut raised);
            });
        }
    }
    for number in 0..shapes.len() {
        for patch in patches(&shapes[number].geometry).iter().filter(|_| shapes[number].emitter.is_some()) {
            let mut most = heights[number];
            faces.in_facet(&Facet::new(&patch.corners(), false), |face, height| {
                if face.patch.n.dot(patch.n) < 0.0 {
                    // Back to back: each of the two leaves the plane by its own front.
                    most = most.max(height);
                } else if face.shape < number {
                    most = most.max(heights[face.shape] + height);
                }
            });
            heights[number] = most;
        }
    }
    for (shape, height) in shapes.iter_mut().zip(heights).filter(|(_, height)| *height > 0.0) {
        match &mut shape.geometry {
            Geometry::Patch(patch) => patch.centre += patch.n * height,
            Geometry::Cube(cube) => cube.grow(height),
            Geometry::Mesh(_) | Geometry::Sphere(_) | Geometry::Cylinder(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::render::{Progress, Settings, render};
    use crate::spectrum::ColorMode;

    /// Direct light on a floor by one technique alone, and its standard error.
    fn floor(ceiling_and_lamp: &str, emitter_samples: u32, bsdf_samples: u32) -> (f64, f64) {
        let text = format!(
            r#"<scene version="3.0.0">
                <integrator type="direct"><integer name="emitter_samples" value="{emitter_samples}"/>
                    <integer name="bsdf_samples" value="{bsdf_samples}"/></integrator>
                <sensor type="perspective"><transform name="to_world">
                    <lookat origin="0.3, 0.7, 0" target="0.3, 0, 0" up="0, 0, 1"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>
                    <sampler type="independent"/>
                    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
                <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/>
                    <rotate x="1" y="2" z="-1" angle="$turn"/></transform></shape>
                {ceiling_and_lamp}</scene>"#
        );
        let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
        for turn in ["0", "37"] {
            let scene = load_text("scene.xml", &text.replace("$turn", turn), ColorMode::Rgb).unwrap();
            let (image, _) = render(&scene, &Settings::of(&scene, 0..256), &Progress::default()).unwrap();
            for value in &image.channel("G").unwrap().mean {
                let value = f64::from(*value);
                (sum, square, count) = (sum + value, square + value * value, count + 1.0);
            }
        }
        let mean = sum / count;
        (mean, ((square / count - mean * mean) / count).sqrt())
    }

    /// Both techniques see all of the lamp, or none, whatever lies in its plane, and whichever comes first.
    #[test]
    fn a_lamp_lies_upon_what_it_lies_in() {
        let shape = |kind: &str, scale: f64, more: &str| {
            format!(
                r#"<shape type="{kind}"><transform name="to_world"><rotate x="1" angle="90"/><scale value="{scale}"/>
                    <translate y="1"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
            )
        };
        let emitter = r#"<emitter type="area"/>"#;
        let ceiling = shape("rectangle", 2.7, "");
        // Its lower side is in the plane.
        let beam = r#"<shape type="cube"><transform name="to_world"><scale x="2" y="0.3" z="1"/><translate y="1.3"/>
            <rotate x="1" y="2" z="-1" angle="$turn"/></transform></shape>"#;
        for lamp in [shape("rectangle", 0.45, emitter), shape("disk", 0.45, emitter)] {
            for scene in [format!("{ceiling}{lamp}"), format!("{lamp}{ceiling}"), format!("{beam}{lamp}")] {
                let (by_emitter, e) = floor(&scene, 1, 0);
                let (by_bsdf, b) = floor(&scene, 0, 1);
                assert!(by_emitter > 0.01, "{by_emitter}");
                assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{by_emitter} {by_bsdf} {scene}");
            }
        }
    }

    /// What shines in a plane with another lamp, or with one of its faces in a plane.
    #[test]
    fn lamps_and_cubes_lie_upon_what_they_lie_in_too() {
        let at = |kind: &str, placed: &str, more: &str| {
            format!(
                r#"<shape type="{kind}"><transform name="to_world">{placed}<translate y="1"/>
                    <rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
            )
        };
        let lamp = |radiance: f64| {
            format!(r#"<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>"#)
        };
        let down = |scale: f64, more: &str| {
            at("rectangle", &format!(r#"<rotate x="1" angle="90"/><scale value="{scale}"/>"#), more)
        };
        let up = at("rectangle", r#"<rotate x="1" angle="-90"/><scale value="0.45"/>"#, &lamp(1.0));
        let cube = at("cube", r#"<scale value="0.45"/><translate y="0.45"/>"#, &lamp(1.0));
        let (ceiling, panel) = (down(2.7, ""), down(0.45, &lamp(1.0)));
        let (brighter, darker) = (down(0.45, &lamp(2.0)), down(0.45, &lamp(0.5)));
        for (scene, same) in [
            (format!("{ceiling}{cube}"), &cube),
            (format!("{cube}{ceiling}"), &cube),
            (format!("{up}{panel}"), &panel),
            (format!("{panel}{up}"), &panel),
            (format!("{panel}{cube}"), &cube),
            // The last one is seen.
            (format!("{brighter}{panel}{darker}"), &darker),
            (format!("{panel}{darker}{brighter}"), &brighter),
        ] {
            let ((by_emitter, e), (by_bsdf, b)) = (floor(&scene, 1, 0), floor(&scene, 0, 1));
            let (alone, a) = floor(same, 1, 0);
            assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{by_emitter} {by_bsdf} {scene}");
            assert!((by_emitter - alone).abs() < 5.0 * e.hypot(a), "{by_emitter} {alone} {scene}");
        }
    }

    /// Rounded to `f32`, some of these ceilings are before their lamps.
    #[test]
    fn a_lamp_lies_upon_a_mesh_too() {
        let square = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_index\nend_header\n\
                      -1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n4 0 1 2 3\n";
        let file = std::env::temp_dir().join(format!("etalon-ceiling-{}.ply", std::process::id()));
        std::fs::write(&file, square).unwrap();
        let at = |height: &str, kind: &str, scale: f64, more: &str| {
            format!(
                r#"<shape type="{kind}"><transform name="to_world"><rotate x="1" angle="90"/><scale value="{scale}"/>
                    <translate y="{height}"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
            )
        };
        let name = format!(r#"<string name="filename" value="{}"/>"#, file.display());
        for height in ["1", "2.3", "2.6", "2.7"] {
            let lamp = at(height, "rectangle", 0.45, r#"<emitter type="area"/>"#);
            let scene = at(height, "ply", 2.7, &name) + &lamp;
            let ((by_emitter, e), (by_bsdf, b)) = (floor(&scene, 1, 0), floor(&scene, 0, 1));
            let (alone, a) = floor(&lamp, 1, 0);
            assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{height}: {by_emitter} {by_bsdf}");
            // Nothing of it is hidden.
            assert!((by_emitter - alone).abs() < 5.0 * e.hypot(a), "{height}: {by_emitter} {alone}");
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn lamps_are_raised_by_what_they_lie_in_and_by_nothing_far_away() {
        let lamp = |more: &str| {
            let text = format!(
                r#"<scene version="3.0.0"><sensor type="perspective"/>
                    <shape type="rectangle"><transform name="to_world"><translate z="2"/></transform>
                    <emitter type="area"/></shape>{more}</scene>"#
            );
            let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
            scene.shapes[0].geometry.bounds().0.z - 2.0
        };
        let place = |scale: &str, x: &str, z: &str| {
            format!(
                r#"<shape type="rectangle"><transform name="to_world"><scale value="{scale}"/><translate x="{x}" z="{z}"/></transform></shape>"#
            )
        };
        let sun = r#"<shape type="sphere"><point name="center" z="1.5e11"/><float name="radius" value="1e9"/></shape>"#;
        assert_eq!(lamp(&(place("5", "0", "1.9") + sun)), 0.0);
        assert_eq!(lamp(&place("5", "1e9", "2")), 0.0);
        let height = lamp(&place("5", "0", "2"));
        assert!(height > 0.0 && height < 1e-12, "{height}");
        // A hill that goes far up and down about it, and a level plain that does not reach it.
        let hill = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 2\nproperty list uchar int vertex_index\nend_header\n\
                    -1e5 -1e5 -1e5\n1e5 -1e5 1e5\n1e5 1e5 2e5\n-9e4 2e4 2\n3 0 1 2\n3 0 2 3\n";
        let file = std::env::temp_dir().join(format!("etalon-hill-{}.ply", std::process::id()));
        std::fs::write(&file, hill).unwrap();
        let mesh =
            format!(r#"<shape type="ply"><string name="filename" value="{}"/></shape>"#, file.display());
        let group = format!(r#"<shape type="shapegroup" id="g">{mesh}</shape>"#);
        let instance = r#"<shape type="instance"><ref id="g"/></shape>"#;
        let heights = [lamp(&mesh), lamp(&format!("{group}{instance}"))];
        std::fs::remove_file(&file).unwrap();
        assert_eq!(heights, [0.0; 2]);
    }
}
