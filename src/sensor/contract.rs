//! Tests that every example of every camera must pass.

use super::{AnySensor, Optics, SENSORS};
use crate::load_text;
use crate::math::{DVec2, DVec3, Ray, length};
use crate::spectrum::ColorMode;

/// Every example that makes an image, and each turned, moved and, if it bears it, stretched.
fn cameras() -> Vec<(String, AnySensor)> {
    let mut cameras = sensors();
    cameras.retain(|(_, camera)| camera.has_image());
    cameras
}

/// Every example, and each turned, moved and, if it bears it, stretched.
fn sensors() -> Vec<(String, AnySensor)> {
    let mut cameras = vec![];
    for entry in SENSORS {
        for example in entry.examples {
            let moved = "<lookat origin=\"3, 2, -4\" target=\"0, 1, 0.5\" up=\"0.1, 1, 0\"/>";
            let stretched = format!("<scale x=\"3\" y=\"2\" z=\"0.5\"/>{moved}");
            for place in ["", moved, &stretched] {
                let mut text = (*example).to_owned();
                if !place.is_empty() {
                    if text.contains("<transform") {
                        text = text.replace("</transform>", &format!("{place}</transform>"));
                    } else {
                        let transform = format!("<transform name=\"to_world\">{place}</transform></sensor>");
                        text = text.replace("</sensor>", &transform);
                    }
                }
                // What measures a surface belongs to a shape; it has a place only there.
                let of_shape = entry.name == super::irradiancemeter::NAME;
                let stands =
                    if of_shape { format!("<shape type=\"disk\">{example}</shape>") } else { text.clone() };
                let scene = format!("<scene version=\"3.0.0\">{stands}</scene>");
                // Only parallel rays can be stretched, and what has a direction is not turned.
                match load_text("camera.xml", &scene, ColorMode::Rgb) {
                    Ok(scene) => cameras.push((text, scene.sensor.camera)),
                    Err(e) => assert!(place == stretched || text.contains("\"direction\""), "{e}"),
                }
            }
        }
    }
    assert!(cameras.len() > SENSORS.len(), "too few to tell");
    cameras
}

fn places() -> impl Iterator<Item = (DVec2, DVec2)> {
    (0..64).map(|i| {
        let part = |step: u32| f64::from(i * step % 64) / 64.0 + 1.0 / 128.0;
        (DVec2::new(part(1), part(7)), DVec2::new(part(19), part(27)))
    })
}

#[test]
fn what_a_ray_meets_is_seen_through_the_same_place() {
    for (text, camera) in cameras() {
        for (film, lens) in places() {
            let ray = camera.ray(film, lens);
            let t = 5.0;
            let p = ray.at(t);
            let view = camera.connect(p, lens).unwrap_or_else(|| panic!("{text}: unseen"));
            assert!(length(view.towards + ray.direction) < 1e-12, "{text}");
            assert!((view.distance - t).abs() < 1e-12, "{text}: {} for {t}", view.distance);
            assert!((view.film - film).abs().max_element() < 1e-12, "{text}: {} for {film}", view.film);
            let seen = camera.seen_per_area(&ray, p);
            assert!((view.per_area / seen - 1.0).abs() < 1e-12, "{text}");
            assert!(camera.connect(ray.at(-0.1 * t), lens).is_none(), "{text}: seen before the near plane");
            assert!(
                camera.connect(ray.at(2.0 * ray.end), lens).is_none(),
                "{text}: seen beyond the far plane"
            );
        }
    }
}

/// Nothing has a place on their film, and light paths cannot be connected with them.
#[test]
fn what_makes_no_image_sees_along_unit_rays_and_nothing_from_a_point() {
    let meters: Vec<_> = sensors().into_iter().filter(|(_, sensor)| !sensor.has_image()).collect();
    assert!(meters.len() > 4, "too few to tell");
    for (text, meter) in meters {
        for (film, lens) in places() {
            let ray = meter.ray(film, lens);
            assert!((length(ray.direction) - 1.0).abs() < 1e-15 && ray.end == f64::INFINITY, "{text}");
            assert!(meter.connect(ray.at(5.0), lens).is_none(), "{text}");
        }
        let origin = |(film, lens)| meter.ray(film, lens).origin;
        let first = places().map(origin).next();
        assert_eq!(meter.has_lens(), places().map(origin).any(|other| Some(other) != first), "{text}");
    }
}

#[test]
fn area_on_the_film_is_what_the_density_says() {
    for (text, camera) in cameras() {
        for (film, lens) in places() {
            let ray = camera.ray(film, lens);
            let p = ray.at(5.0);
            // The plane across the ray, and where the rays of two neighbours cut it.
            let cut = |by: DVec2| {
                let other: Ray = camera.ray(film + by, lens);
                other.at((p - other.origin).dot(ray.direction) / other.direction.dot(ray.direction))
            };
            let h = 1e-4;
            let edge = |by: DVec2| -> DVec3 { (cut(by * h) - cut(-by * h)) / (2.0 * h) };
            let area = length(edge(DVec2::X).cross(edge(DVec2::Y)));
            let seen = camera.seen_per_area(&ray, p);
            assert!((area * seen - 1.0).abs() < 1e-6, "{text}: {} at {film}", area * seen);
        }
    }
}
