//! Surfaces that are close together, coincident, or almost without area.

use super::Case;
use crate::closed_forms::ClosedForm;
use crate::closed_forms::interfaces::{GROUND, SKY, reflectance, stage};
use crate::closed_forms::irradiance::{floor_under, shown};
use crate::metamorphic::still_life::{lamp, objects, with_light};
use crate::stage::*;
use std::f64::consts::PI;

const ETA: f64 = 1.5;
const STOKES: &str = "m interfaces reflect mR/(1 + (m − 1)R) (Stokes 1862)";

pub fn cases() -> Vec<Case> {
    let mut cases = glass();
    let room = with_light(&lamp(8.0));
    let all = objects(&[]);
    let [floor, .., cube] = &all[..] else { return cases };
    for (name, z) in [("coincident_floor", 0.0), ("floor_at_1e-12", -1e-12), ("floor_at_1e-5", -1e-5)] {
        let second = shape("rectangle", &[scale([4.0, 3.7, 1.0]), translate([0.1, 0.2, z])], &diffuse(0.6));
        let expectation = "a floor within or close beneath the floor, of the same make, changes nothing";
        // The second floor is wider and visible beyond the first, so it is in both scenes; one has both
        // floors.
        let only = with_light(&lamp(8.0)).replace(floor, &second);
        let both = with_light(&lamp(8.0)).replace(floor, &(floor.clone() + &second));
        cases.push(Case::same(name, expectation, [only, both], 1e-3));
    }
    let twice = room.replace(cube, &cube.repeat(2));
    cases.push(Case::same("coincident_cubes", "a mesh twice is the mesh", [room.clone(), twice], 1e-3));
    let nothing = "triangles without area and needles of 10⁻⁹ change nothing";
    let wears = diffuse(0.3) + "<string name=\"filename\" value=\"meshes/slivers.obj\"/>";
    let slivers = |place: Point| shape("obj", &[translate(place)], &wears);
    let scenes = [room.clone(), room.replace("</scene>", &(slivers([0.0, -1.0, 1.0]) + "</scene>"))];
    cases.push(Case::same("triangles_without_area", nothing, scenes, 1e-3));
    cases.extend(tilted_twice());
    cases.push(coincident_glass());
    cases.extend(mixed_scales().into_iter().map(Case::answer));
    cases
}

/// Shapes that are in the scene twice, seen where their points are computed from numbers much larger than these are.
/// The two surfaces cross the line of a ray that leaves either at distances that are rounding alone.
fn tilted_twice() -> Vec<Case> {
    let tilt = || vec![rotate('x', 31.0), rotate('y', 17.0), rotate('z', 23.0)];
    let wide = || [vec![scale([100.0; 3]), translate([90.0, 80.0, 0.0])], tilt()].concat();
    let edge = || [vec![translate([1.0, 0.3, 0.2])], tilt()].concat();
    let matte = diffuse(0.5);
    let ball = sphere([0.0, 0.0, -1000.0], 1000.0, &matte);
    let bodies = [
        ("rectangle", shape("rectangle", &wide(), &matte)),
        ("disk", shape("disk", &wide(), &matte)),
        ("cube", shape("cube", &edge(), &matte)),
        ("cylinder", shape("cylinder", &edge(), &matte)),
        ("ball", ball),
        ("mask", shape("rectangle", &wide(), &bsdf("mask", &(float("opacity", 0.5) + &matte)))),
        ("nothing", shape("rectangle", &wide(), &bsdf("null", ""))),
    ];
    let case = |(name, body): (&str, String)| {
        let camera = pinhole(&look_at([3.0, 4.0, 5.0], [0.0; 3], [0.0, 0.0, 1.0]), 8.0, &film(12, 12));
        let seen = |body: &str| {
            let integrator = if name == "nothing" { "<integrator type=\"volpath\"/>" } else { &path(-1) };
            scene(&[integrator, &camera, body, &constant(1.0)])
        };
        let expectation = "two shapes in one place are one, however far their points are from their middles";
        Case::same(format!("twice_{name}"), expectation, [seen(&body), seen(&body.repeat(2))], 1e-3)
    };
    bodies.map(case).into()
}

/// A ball of glass in a film of water without thickness: two coincident interfaces.
fn coincident_glass() -> Case {
    let ball = |inside: f64, outside: f64| {
        sphere([0.0; 3], 1.0, &bsdf("dielectric", &(float("int_ior", inside) + &float("ext_ior", outside))))
    };
    let camera = pinhole(&look_at([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0]), 20.0, &film(6, 6));
    let balls = ball(1.33, 1.0) + &ball(1.5, 1.33);
    let furnace = scene(&[&path(-1), &camera, &balls, &constant(1.0)]);
    let source = "lossless bodies in a furnace of radiance 1 cannot be seen (Kirchhoff)";
    let case = ClosedForm::new("coincident_glass", source, furnace, 1.0).samples(1 << 10);
    Case::answer(case).limit(
        "of surfaces in one place a ray meets the first alone, and what the others do to radiance, η², is missing; 10⁻⁹ apart they are met",
        0.1,
    )
}

fn face(steps: &[String], z: f64) -> String {
    let glass = bsdf("dielectric", &(float("int_ior", ETA) + &float("ext_ior", 1.0)));
    shape("rectangle", &[&[scale([100.0; 3])], steps, &[translate([0.0, 0.0, z])]].concat(), &glass)
}

/// Panes with a thickness: one face up, one face down.
pub fn panes(count: i32, thickness: f64, distance: f64) -> String {
    let pane = |i: i32| {
        let top = -distance * f64::from(i);
        face(&[], top) + &face(&[rotate('x', 180.0)], top - thickness)
    };
    (0..count).map(pane).collect()
}

fn pile(interfaces: f64, r: f64) -> f64 {
    interfaces * r / (1.0 + (interfaces - 1.0) * r)
}

fn glass() -> Vec<Case> {
    let mut cases = vec![];
    for (name, thickness, distance) in [
        ("gaps_of_1e-5", 0.05, 0.05 + 1e-5),
        ("panes_of_1e-5", 1e-5, 0.1),
        ("panes_and_gaps_of_1e-9", 1e-9, 2e-9),
    ] {
        let r = pile(6.0, reflectance(50.0, ETA));
        let scene = stage(50.0, GROUND, &panes(3, thickness, distance));
        let case = ClosedForm::new(name, STOKES, scene, 1.0 - r);
        cases.push(Case::answer(case.margin(0.0025).samples(1 << 16)));
    }
    let glass = bsdf("dielectric", &(float("int_ior", ETA) + &float("ext_ior", 1.0)));
    for thickness in [1e-5, 1e-9] {
        let outer = sphere([0.0; 3], 1.0, &glass);
        let inner = sphere(
            [0.0; 3],
            1.0 - thickness,
            &("<boolean name=\"flip_normals\" value=\"true\"/>".to_string() + &glass),
        );
        let ball = outer + &inner;
        for (what, light, r) in [("reflects", SKY, 0.0), ("transmits", GROUND, 1.0)] {
            let reflected = pile(4.0, reflectance(0.0, ETA));
            let scene = stage(0.0, light, &ball);
            let name = format!("shell_of_{thickness:e}_{what}");
            let case = ClosedForm::new(name, STOKES, scene, (r - reflected).abs());
            cases.push(Case::answer(case.margin(0.0025).samples(1 << 19)));
        }
    }
    cases
}

/// Objects that are 10⁷ times as large as others beside them.
fn mixed_scales() -> Vec<ClosedForm> {
    let disk = |radius: f64, height: f64| {
        shape("disk", &[scale([radius; 3]), rotate('x', 180.0), translate([0.0, 0.0, height])], &area(1.0))
    };
    let source = "E = πLr²/(r² + h²) under the middle of a disk";
    let under = |name: &str, radius: f64, height: f64| {
        let e = PI * radius * radius / (radius * radius + height * height);
        ClosedForm::new(name, source, floor_under(&disk(radius, height)), shown(e)).samples(1 << 14)
    };
    // A ball of 10⁻⁷ beside the wall of 1, seen from 6·10⁻⁷: the ball's disk on the film has the area π
    // tan²σ, sin σ = 1/6.
    let radius = 1e-7;
    let (place, eye) = ([0.3, 0.2, 0.5], [0.3, 0.2, 0.5 - 6.0 * radius]);
    let camera = pinhole(&look_at(eye, place, [0.0, 1.0, 0.0]), 40.0, &film(6, 6))
        .replace("\"perspective\">", "\"perspective\"><float name=\"near_clip\" value=\"1e-9\"/>");
    let half = libm::tan(f64::to_radians(20.0));
    let ball = sphere(place, radius, &area(1.0))
        + &shape("rectangle", &[scale([1.0; 3]), translate([0.0, 0.0, -1.0])], &diffuse(0.5));
    vec![
        under("lamp_of_1e7_above_1", 1e7, 2.0),
        // Where it is closest to the floor, its surface passes the world's origin, and its coordinates are
        // 1000 times as large as those of its points there.
        ClosedForm::new(
            "ball_of_1000_past_the_origin",
            "E = πLr²/d² under a ball",
            floor_under(&sphere([0.0, 0.0, 1010.0], 1000.0, &area(1.0))),
            shown(PI * (1000.0 / 1010.0) * (1000.0 / 1010.0)),
        )
        .samples(1 << 14),
        ClosedForm::new(
            "ball_of_1e-7_in_1",
            "π tan²σ of a film 4 tan²(fov/2) large, sin σ = r/d",
            scene(&[&path(1), &camera, &ball]),
            PI / 35.0 / (4.0 * half * half),
        )
        .samples(1 << 15),
    ]
}
