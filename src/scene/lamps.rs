//! Lamps that lie in the plane of another surface, such as a panel in a ceiling.
//!
//! Rounding would decide which of the two a ray meets, while an emitter sample ends just before its lamp and
//! arrives: MIS of the two techniques would lose what the surface hides from one of them. So flat lamps are
//! raised a little above whatever they lie in.

use super::Shape;
use crate::math::DVec3;
use crate::math::ray::position_error;
use crate::shape::Geometry;

/// By how many times the error of a computed point a lamp is raised: beyond the errors of both surfaces along
/// a ray, and beyond where emitter samples end ([`way_between`](crate::math::ray::way_between)).
const ERRORS: f64 = 16.0;

/// Raises rectangles and disks that emit towards their front, by less than can be seen and more than
/// rounding. Lamps of triangles stay: their vertices have fewer digits, and share edges with others.
/// `instances` are the boxes of the instances, which are not among the shapes.
pub fn raise(shapes: &mut [Shape], instances: impl Iterator<Item = (DVec3, DVec3)>) {
    let flat = |shape: &Shape| shape.emitter.is_some() && matches!(shape.geometry, Geometry::Patch(_));
    if !shapes.iter().any(flat) {
        return;
    }
    let boxes = shapes.iter().map(|shape| shape.geometry.bounds()).chain(instances);
    let most = boxes.map(|(lo, hi)| lo.abs().max(hi.abs())).fold(DVec3::ZERO, DVec3::max);
    let height = ERRORS * position_error(most);
    for shape in shapes.iter_mut().filter(|shape| shape.emitter.is_some()) {
        if let Geometry::Patch(patch) = &mut shape.geometry {
            patch.centre += patch.n * height;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::render::{Progress, Settings, render};
    use crate::scene::load_text;
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
}
