//! Irradiance from an environment map, by quadrature over its texels.

use super::ClosedForm;
use super::irradiance::{floor_under, shown};
use crate::stage::*;
use etalon::spectrum::observer::luminance;
use std::f64::consts::PI;
use validation::scatterer::DVec3;

pub fn cases() -> Vec<ClosedForm> {
    let source = "E = ∫ L cos θ dω, L bilinear between texels whose rows span pole to pole (midpoint rule)";
    let case = |name, turns: &[String], to_map: fn(DVec3) -> DVec3| {
        let file = "<string name=\"filename\" value=\"textures/sky.exr\"/>";
        let scene = floor_under(&emitter("envmap", &(file.to_string() + &to_world(turns))));
        ClosedForm::new(name, source, scene, shown(irradiance(to_map))).samples(1 << 14)
    };
    vec![
        // World up is z; the map's up is y.
        case("upright", &[rotate('x', 90.0)], |w| DVec3::new(w.x, w.z, -w.y)),
        case("lying", &[], |w| w),
        case("turned", &[rotate('y', 130.0)], |w| {
            let (sin, cos) = libm::sincos(130f64.to_radians());
            DVec3::new(cos * w.x - sin * w.z, w.y, sin * w.x + cos * w.z)
        }),
    ]
}

/// The irradiance from the map; NaN, which no verdict passes, if the map cannot be read.
fn irradiance(to_map: fn(DVec3) -> DVec3) -> f64 {
    let file = crate::references::folder().join("scenes/textures/sky.exr");
    let Ok(image) = validation::image::load(&file) else { return f64::NAN };
    let channel = |name: &str| image.channels.iter().find(|c| c.name == name);
    let [Some(r), Some(g), Some(b)] = ["R", "G", "B"].map(channel) else { return f64::NAN };
    let (width, height) = (image.width, image.height);
    let texel = |x: usize, y: usize| {
        let i = y * width + x % width;
        luminance([r.mean[i], g.mean[i], b.mean[i]])
    };
    const STEPS: usize = 1500;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let cos = (i as f64 + 0.5) / STEPS as f64;
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..2 * STEPS {
            let (s, c) = libm::sincos(PI * (j as f64 + 0.5) / STEPS as f64);
            let w = to_map(DVec3::new(sin * c, sin * s, cos));
            // The middle of the image is towards −z, and columns increase towards +x.
            let turn = libm::atan2(w.x, -w.z) / (2.0 * PI) + 1.0;
            let x = turn * width as f64 + width as f64 - 0.5;
            let y = libm::acos(w.y.clamp(-1.0, 1.0)) / PI * (height - 1) as f64;
            let (x0, y0) = (x.floor() as usize, (y.floor() as usize).min(height - 2));
            let (u, v) = (x - x.floor(), y - y0 as f64);
            let row = |y: usize| texel(x0, y) * (1.0 - u) + texel(x0 + 1, y) * u;
            sum += (row(y0) * (1.0 - v) + row(y0 + 1) * v) * cos;
        }
    }
    // dω = d(cos θ) dφ
    sum * PI / (STEPS * STEPS) as f64
}
