//! Means of textures.

use super::ClosedForm;
use crate::stage::*;
use etalon::spectrum::observer::luminance;

pub fn cases() -> Vec<ClosedForm> {
    let place = to_world(&[look_at([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0])]);
    // The film sees exactly the rectangle's unit square of uv.
    let camera = format!("<sensor type=\"orthographic\">{place}{}</sensor>", film(8, 8));
    let card = |texture: &str| {
        let lit = scene(&[&path(2), &camera, &shape("rectangle", &[], &bsdf("diffuse", texture))]);
        let light = "<vector name=\"direction\" x=\"0\" y=\"0\" z=\"-1\"/>".to_string();
        let light = emitter("directional", &(light + &grey("irradiance", std::f64::consts::PI)));
        lit.replace("</scene>", &format!("{light}</scene>"))
    };
    let checkerboard = |scaled: &str| {
        let colors = grey("color0", 0.9) + &grey("color1", 0.1);
        let to_uv = format!("<transform name=\"to_uv\">{scaled}</transform>");
        format!("<texture type=\"checkerboard\" name=\"reflectance\">{colors}{to_uv}</texture>")
    };
    let bitmap = |filter: &str| {
        format!(
            "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"textures/tiles.exr\"/>\
             <string name=\"filter_type\" value=\"{filter}\"/></texture>"
        )
    };
    let even = "every texel has the same weight in the mean of a repeated image";
    vec![
        ClosedForm::new("checkerboard", "(a + b)/2", card(&checkerboard("<scale x=\"3\" y=\"5\"/>")), 0.5)
            .samples(1 << 12),
        ClosedForm::new(
            "checkerboard_cut",
            "shares of the squares in a part of the pattern",
            card(&checkerboard("<scale x=\"0.8\" y=\"0.7\"/>")),
            cut(0.8, 0.7),
        )
        .samples(1 << 12),
        ClosedForm::new("bilinear", even, card(&bitmap("bilinear")), texels()).samples(1 << 12),
        ClosedForm::new("nearest", even, card(&bitmap("nearest")), texels()).samples(1 << 12),
    ]
}

/// Each half of the unit square along an axis has one colour; of a square s × t the shares are those of its
/// corners.
fn cut(s: f64, t: f64) -> f64 {
    let (a, b) = (0.5 / s, 0.5 / t);
    let first = a * b + (1.0 - a) * (1.0 - b);
    0.9 * first + 0.1 * (1.0 - first)
}

/// Mean luminance of the texels; NaN if they cannot be read.
fn texels() -> f64 {
    let file = crate::references::folder().join("scenes/textures/tiles.exr");
    validation::image::load(&file)
        .map_or(f64::NAN, |image| luminance(["R", "G", "B"].map(|channel| super::mean(&image, channel))))
}
