//! Rays that leave a convex body outwards hit nothing; inside a sphere they hit the opposite side.

use super::Case;
use crate::stage::*;
use etalon::math::{DVec2, DVec3, Frame, Ray, warp};
use etalon::scene::{Features, Scene};
use etalon::spectrum::ColorMode;
use validation::statistics::seed_for;

/// Number of rays of a test run per body; all ten bodies together 10⁷.
const RAYS: u64 = 1_000_000;

pub fn cases() -> Vec<Case> {
    let mesh = |file: &str| format!("<string name=\"filename\" value=\"meshes/{file}\"/>");
    let far = translate([310.0, -150.0, 77.0]);
    let inside = "<boolean name=\"flip_normals\" value=\"true\"/>";
    let turned = [scale([0.7, 1.3, 1.0]), rotate('x', 33.0), rotate('z', 71.0)];
    // The triangles of a ball are pairwise coplanar except for the rounding of their corners, so no ray may
    // be flatter than that.
    let bodies: Vec<(&str, String, f64)> = vec![
        ("sphere", sphere([0.1, 0.2, -0.3], 1.0, ""), 1e-12),
        ("hollow_sphere", sphere([0.1, 0.2, -0.3], 1.0, inside), 1e-6),
        ("sphere_far_away", shape("sphere", &[scale([0.3; 3]), far.clone()], ""), 1e-9),
        ("patch", shape("rectangle", &[turned.as_slice(), std::slice::from_ref(&far)].concat(), ""), 1e-12),
        ("cube", shape("cube", &[scale([0.35, 0.7, 0.11])], ""), 1e-9),
        ("needle", shape("cube", &[scale([1e-5, 1e-5, 10.0])], ""), 1e-9),
        ("cube_of_triangles", shape("obj", &[scale([0.35, 0.7, 0.11])], &mesh("cube.obj")), 1e-9),
        ("needle_of_triangles", shape("obj", &[scale([1e-5, 1e-5, 10.0])], &mesh("cube.obj")), 1e-9),
        ("ball_of_triangles", shape("ply", &[], &mesh("ball.ply")), 1e-3),
        ("octahedron_of_needles", shape("ply", &[scale([1e-4, 1e-4, 10.0])], &mesh("octahedron.ply")), 1e-6),
    ];
    // Only the surface of an emitter can be sampled.
    let shines = area(1.0) + "</shape>";
    let case = |(name, body, least): (&'static str, String, f64)| {
        let text =
            scene(&[&path(1), &pointed([9.0, 0.0, 0.0], [0.0; 3]), &body.replace("</shape>", &shines)]);
        let hollow = name.starts_with("hollow");
        let expectation =
            format!("0 false hits of {RAYS} rays that leave it (ten times as many with --thorough)");
        let worst = move |effort: u64| {
            let scene = load(&text, ColorMode::Rgb)?;
            Ok(false_hits(&scene, RAYS * effort.min(super::THOROUGH), least, hollow)? as f64)
        };
        Case::at_most(name, expectation, 0.0, Box::new(worst))
    };
    bodies.into_iter().map(case).collect()
}

/// The number of `rays` rays with a false hit. Cosines to the normal are log-uniform above `least`.
fn false_hits(scene: &Scene, rays: u64, least: f64, hollow: bool) -> Result<u64, String> {
    let body = &scene.shapes.first().ok_or("no shape")?.geometry;
    let (mut left, mut wrong) = (0, 0);
    for index in 0..100 * rays {
        if left == rays {
            return Ok(wrong);
        }
        let uniform = |k: u64| (seed_for("self hits", 8 * index + k) >> 11) as f64 / (1u64 << 53) as f64;
        let target = body.sample_area::<false>(DVec2::new(uniform(0), uniform(1))).p;
        let side = if hollow { 0.5 } else { 1e3 };
        let towards = warp::sphere(DVec2::new(uniform(2), uniform(3)));
        let first = Ray::free(target - towards * side, towards);
        let Some(hit) = scene.accel.closest(&first) else { continue };
        let (_, point) = scene.surface::<{ Features::ALL }>(&first, &hit);
        if point.ng.dot(towards) >= 0.0 {
            continue;
        }
        let cos = libm::pow(least, uniform(4));
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (s, c) = libm::sincos(std::f64::consts::TAU * uniform(5));
        let direction = Frame::about(point.ng).to_world(DVec3::new(sin * c, sin * s, cos));
        let onward = point.ray(direction, f64::INFINITY, hit.primitive);
        let met = scene.accel.closest(&onward);
        // The expected distance is the chord of the unit sphere.
        let right = if hollow {
            met.is_some_and(|met| (met.t / (2.0 * cos) - 1.0).abs() < 1e-6)
        } else {
            met.is_none()
        };
        wrong += u64::from(!right);
        left += 1;
    }
    Err(format!("{left} rays of {rays} met the body"))
}
