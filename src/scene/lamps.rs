//! Lamps that lie in the plane of another surface, such as a panel in a ceiling.
//!
//! Rounding would decide which of the two a ray meets, while an emitter sample ends just before its lamp and
//! arrives: MIS of the two techniques would lose what the surface hides from one of them. So flat lamps are
//! raised a little above whatever they lie in. How little depends on that: the corners of meshes are rounded to
//! `f32`, which may have put a ceiling before its lamp.

use super::Shape;
use crate::math::ray::position_error;
use crate::math::{Bounds, DVec3};
use crate::shape::{Geometry, Patch};

/// By how many times the errors of computed points a lamp is raised: beyond the errors of both surfaces along a
/// ray, and beyond where emitter samples end ([`free_way`](crate::math::ray::free_way)).
const ERRORS: f64 = 16.0;

/// What a number loses when it is rounded to `f32`, relative to it.
const SINGLE: f64 = 1.0 / (1u64 << 24) as f64;

/// Something that a lamp may lie in.
struct Flat {
    bounds: Bounds,
    /// A bound of the rounding error of its points.
    error: f64,
    /// Whether its corners were rounded to `f32`.
    single: bool,
}

impl Flat {
    fn of(geometry: &Geometry) -> Option<Self> {
        let single = match geometry {
            Geometry::Mesh(_) => true,
            Geometry::Patch(_) | Geometry::Cube(_) => false,
            Geometry::Sphere(_) | Geometry::Cylinder(_) => return None,
        };
        Some(Self { bounds: geometry.bounds(), error: geometry.point_error(), single })
    }

    /// How far a lamp must be raised if it lies in this.
    fn height(&self, lamp: &Patch) -> f64 {
        let (lo, hi) = self.bounds;
        // Across a level ceiling it is how high it is that has been rounded, not how wide.
        let rounded = if self.single { 2.0 * SINGLE * lo.abs().max(hi.abs()).dot(lamp.n.abs()) } else { 0.0 };
        ERRORS * (self.error + lamp.point_error()) + rounded
    }

    /// Whether a lamp may lie in it, in boxes.
    fn may_hold(&self, lamp: &Patch) -> bool {
        let (lo, hi) = lamp.bounds();
        let slack = DVec3::splat(self.height(lamp));
        (self.bounds.0 - slack).cmple(hi).all() && lo.cmple(self.bounds.1 + slack).all()
    }
}

/// Raises rectangles and disks that emit towards their front, by less than can be seen and more than
/// rounding. Lamps of triangles stay: their vertices have fewer digits, and share edges with others.
/// `instances` are the boxes of the instances, which are not among the shapes.
pub fn raise(shapes: &mut [Shape], instances: impl Iterator<Item = Bounds>) {
    let lamp = |shape: &Shape| shape.emitter.is_some() && matches!(shape.geometry, Geometry::Patch(_));
    if !shapes.iter().any(lamp) {
        return;
    }
    let placed = instances.map(|bounds| {
        let error = position_error(bounds.0.abs().max(bounds.1.abs()));
        Flat { bounds, error, single: true }
    });
    let own = shapes.iter().filter(|shape| !lamp(shape)).filter_map(|shape| Flat::of(&shape.geometry));
    let flats: Vec<Flat> = own.chain(placed).collect();
    for shape in shapes.iter_mut().filter(|shape| shape.emitter.is_some()) {
        if let Geometry::Patch(patch) = &mut shape.geometry {
            let heights = flats.iter().filter(|flat| flat.may_hold(patch)).map(|flat| flat.height(patch));
            let height = heights.fold(0.0, f64::max);
            patch.centre += patch.n * height;
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
    }
}
