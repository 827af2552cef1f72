//! The blur of a thin lens: at depth z the rays of a pixel cover a disk of radius b|1 − z/d|, where b is the
//! aperture's radius and d the focus distance.

use super::ClosedForm;
use crate::stage::*;
use std::f64::consts::PI;
use validation::image::Image;

const APERTURE: f64 = 0.2;
const FOCUS: f64 = 2.0;
const SOURCE: &str =
    "circle of confusion b|1 − z/d| at depth z (similar triangles; Potmesil & Chakravarty 1981, eq. 5)";

pub fn cases() -> Vec<ClosedForm> {
    let mut cases = vec![];
    for (name, depth) in [("behind", 5.0), ("before", 1.0)] {
        let blur = blur(depth);
        // The light's outline lies within the blur, so every pixel near the axis sees the same share of it.
        let light = shape(
            "disk",
            &[scale([0.4 * blur; 3]), rotate('x', 180.0), translate([0.0, 0.0, depth])],
            &area(1.0),
        );
        let scene = scene(&[&path(1), &camera(1e-3, &film(1, 1)), &light]);
        cases
            .push(ClosedForm::new(format!("small_light_{name}_focus"), SOURCE, scene, 0.16).samples(1 << 14));
        for offset in [-0.5, 0.0, 0.3] {
            // A half-plane of light whose edge is `offset` blur radii from the axis.
            let edge =
                [scale([100.0; 3]), rotate('x', 180.0), translate([100.0 + offset * blur, 0.0, depth])];
            let scene =
                self::scene(&[&path(1), &camera(1e-4, &film(1, 1)), &shape("rectangle", &edge, &area(1.0))]);
            let source = "segment of the circle of confusion: (acos t − t√(1 − t²))/π";
            let expected = (libm::acos(offset) - offset * (1.0 - offset * offset).sqrt()) / PI;
            cases.push(
                ClosedForm::new(format!("edge_{name}_focus_{offset}"), source, scene, expected)
                    .samples(1 << 14),
            );
        }
        // A light of half the blur's radius on a wide film: its image is the convolution of the two disks,
        // whose mean square radius is (a² + c²)/2.
        let a = 0.5 * blur;
        let light =
            shape("disk", &[scale([a; 3]), rotate('x', 180.0), translate([0.0, 0.0, depth])], &area(1.0));
        let degrees = 2.0 * libm::atan(2.0 * blur / depth).to_degrees();
        let scene = self::scene(&[&path(1), &camera(degrees, &film(64, 64)), &light]);
        // In pixels of the film, which is 4 blur radii wide, plus 1/12 per axis for the grouping into pixels
        // (Sheppard's correction).
        let pixel = 4.0 / 64.0;
        let expected = 0.5 * (0.25 + 1.0) / (pixel * pixel) + 1.0 / 6.0;
        let source = "mean square radius (a² + c²)/2 of a disk blurred by a disk (variances add)";
        cases.push(
            ClosedForm::new(format!("radius_{name}_focus"), source, scene, expected)
                .measure(mean_square_radius)
                .margin(0.0025)
                .samples(1 << 8),
        );
    }
    cases
}

fn blur(depth: f64) -> f64 {
    APERTURE * (1.0 - depth / FOCUS).abs()
}

/// A camera at the origin, looking along +z with +x to the left.
fn camera(degrees: f64, film: &str) -> String {
    pinhole(&look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), degrees, film)
        .replace("\"perspective\">", &format!("\"thinlens\">{}", lens()))
}

fn lens() -> String {
    float("aperture_radius", APERTURE) + &float("focus_distance", FOCUS)
}

/// Mean square distance of the light in the image from its centre, in pixels.
fn mean_square_radius(image: &Image) -> f64 {
    let Some(channel) = image.channels.first() else { return f64::NAN };
    let middle = (0.5 * image.width as f64, 0.5 * image.height as f64);
    let (mut sum, mut moment) = (0.0, 0.0);
    for (i, value) in channel.mean.iter().enumerate() {
        let x = (i % image.width) as f64 + 0.5 - middle.0;
        let y = (i / image.width) as f64 + 0.5 - middle.1;
        sum += value;
        moment += value * (x * x + y * y);
    }
    moment / sum
}
