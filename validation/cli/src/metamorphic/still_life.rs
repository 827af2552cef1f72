//! A small room that most relations use: every kind of transport with little noise.

use crate::stage::*;

/// Pixels along each side of the film.
pub const SIZE: u32 = 24;

/// Independent samples, for which the image's variances are unbiased.
pub const INDEPENDENT: &str = "<sampler type=\"independent\"/>";

/// The file of a mesh.
pub const CUBE_OF_TRIANGLES: &str = "<string name=\"filename\" value=\"meshes/cube.obj\"/>";

/// Position of the camera.
pub const EYE: Point = [0.2, -4.5, 1.6];

pub fn camera() -> String {
    camera_at(&[look_at(EYE, [0.0, 0.0, 0.6], [0.0, 0.0, 1.0])])
}

/// The camera under these transforms.
pub fn camera_at(steps: &[String]) -> String {
    pinhole(&steps.concat(), 42.0, &(film(SIZE, SIZE) + INDEPENDENT))
}

/// A square lamp above.
pub fn lamp(radiance: f64) -> String {
    shape("rectangle", &lamp_steps(), &area(radiance))
}

/// A point light in front of the objects and above them.
pub fn point_light(x: f64, intensity: f64) -> String {
    let place = format!("<point name=\"position\" x=\"{x}\" y=\"-1\" z=\"2\"/>");
    emitter("point", &(place + &grey("intensity", intensity)))
}

pub fn lamp_steps() -> Vec<String> {
    vec![scale([0.7, 0.7, 1.0]), rotate('x', 180.0), translate([0.0, 0.0, 2.5])]
}

/// The objects, each moved by further transforms.
pub fn objects(more: &[String]) -> Vec<String> {
    let placed = |kind: &str, steps: &[String], wears: &str| shape(kind, &[steps, more].concat(), wears);
    vec![
        placed("rectangle", &[scale([3.0, 3.0, 1.0])], &diffuse(0.6)),
        placed(
            "rectangle",
            &[scale([3.0, 3.0, 1.0]), rotate('x', 90.0), translate([0.0, 1.5, 1.0])],
            &diffuse(0.4),
        ),
        placed("sphere", &[scale([0.5; 3]), translate([-0.8, 0.0, 0.5])], &diffuse(0.7)),
        placed("sphere", &[scale([0.4; 3]), translate([0.3, -0.6, 0.4])], &rough_metal()),
        placed(
            "obj",
            &[scale([0.35; 3]), rotate('z', 25.0), translate([1.0, 0.2, 0.35])],
            &(CUBE_OF_TRIANGLES.to_owned() + &diffuse(0.3)),
        ),
    ]
}

pub fn rough_metal() -> String {
    bsdf("roughconductor", &(float("alpha", 0.3) + &float("eta", 0.2) + &float("k", 3.0)))
}

/// The room with these lights; objects come first, in their order.
pub fn with_light(lights: &str) -> String {
    scene(&[&path(4), &camera(), &objects(&[]).concat(), lights])
}

/// The room under its lamp with further elements.
pub fn with(more: &str) -> String {
    with_light(&(lamp(8.0) + more))
}

/// The room with these objects, scaled by a factor and translated. Lamps have a given radiance, so the image
/// does not change.
pub fn placed(objects: fn(&[String]) -> Vec<String>, factor: f64, by: Point) -> String {
    let steps = [scale([factor; 3]), translate(by)];
    let at = |p: Point| [0, 1, 2].map(|i| p[i] * factor + by[i]);
    let place = look_at(at(EYE), at([0.0, 0.0, 0.6]), [0.0, 0.0, 1.0]);
    let clip = float("near_clip", 0.01 * factor) + &float("far_clip", 1e4 * factor);
    let camera = camera_at(&[place]).replace("\"perspective\">", &format!("\"perspective\">{clip}"));
    let lamp = shape("rectangle", &[lamp_steps(), steps.to_vec()].concat(), &area(8.0));
    scene(&[&path(4), &camera, &objects(&steps).concat(), &lamp])
}
