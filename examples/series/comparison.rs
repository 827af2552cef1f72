//! Comparison of Schlick's approximation with Fresnel's equations, in a picture and in closed form.
//!
//! Both pictures use the same random numbers, so that most of their noise cancels in the difference. The
//! remaining noise is measured: the comparison is repeated with other seeds, and the mean over seeds is
//! printed with its standard error.

use crate::picture::Studio;
use etalon::bsdf::fresnel;
use etalon::image::{self, Channel, Image, Rgb8};
use etalon::math::{DVec2, Ray};
use etalon::scene::Scene;
use etalon::sensor::Optics;
use std::error::Error;
use std::path::Path;

const SEEDS: u32 = 4;
/// A linear difference of ±1/`GAIN` is white or black in the picture; 0 is grey.
const GAIN: f32 = 10.0;

/// Compares the two on a scene with a parameter `fresnel`, prints the figures, and returns three captioned
/// pictures.
pub fn run(studio: &Studio, path: &Path) -> Result<Vec<(String, Rgb8)>, Box<dyn Error>> {
    let read = |term: &str| studio.load(path, &[("fresnel", term.into())]);
    let (schlick, exact) = (read("schlick")?, read("exact")?);
    let glass = glass_pixels(&exact);
    let (mut whole, mut sphere) = (vec![], vec![]);
    let mut sums: Option<[Image; 2]> = None;
    for seed in 0..SEEDS {
        let pair =
            [studio.render(&schlick, studio.samples, seed)?, studio.render(&exact, studio.samples, seed)?];
        let [a, b] = [0, 1].map(|i| mean(&pair[i], |_| true));
        whole.push(a / b - 1.0);
        let [a, b] = [0, 1].map(|i| mean(&pair[i], |pixel| glass[pixel]));
        sphere.push(a / b - 1.0);
        sums = Some(match sums {
            None => pair,
            Some([a, b]) => [combine(&a, &pair[0], |x, y| x + y), combine(&b, &pair[1], |x, y| x + y)],
        });
    }
    let [a, b] = sums.ok_or("no seeds")?;
    let average = |sum: &Image| combine(sum, sum, |x, _| x / SEEDS as f32);
    let (a, b) = (average(&a), average(&b));
    let difference = combine(&a, &b, |x, y| x - y);
    println!(
        "Schlick against Fresnel, {SEEDS} seeds of {} samples a pixel, (schlick - exact) / exact:",
        studio.samples
    );
    print("of the picture's mean", &whole);
    print("of the glass sphere's mean", &sphere);
    let distance = |select: &dyn Fn(usize) -> bool| {
        mean(&combine(&difference, &b, |d, _| d.abs()), select) / mean(&b, select)
    };
    println!("  mean |difference| of a pixel: {:.3} %", 100.0 * distance(&|_| true));
    println!(
        "  mean |difference| of a pixel of the glass sphere: {:.3} %",
        100.0 * distance(&|pixel| glass[pixel])
    );
    closed_form(1.5);
    let (signed, of_schlick, of_exact) = (show(&difference), image::develop(&a)?, image::develop(&b)?);
    studio.write("fresnel-schlick", &a, &of_schlick)?;
    studio.write("fresnel-exact", &b, &of_exact)?;
    studio.write("fresnel-difference", &difference, &signed)?;
    let caption = format!("schlick - exact, x {GAIN}, 0 = grey");
    Ok(vec![("schlick".into(), of_schlick), ("exact".into(), of_exact), (caption, signed)])
}

/// Prints the mean over seeds and its standard error, of a figure computed once for each seed.
fn print(what: &str, values: &[f64]) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
    println!("  {what}: {:+.4} % ± {:.4} %", 100.0 * mean, 100.0 * (variance / n).sqrt());
}

/// Prints the largest |R_schlick − R_exact| over angles of incidence, entering glass of index η and leaving
/// it.
fn closed_form(eta: f64) {
    const STEPS: u32 = 90_000;
    for (way, eta) in [("entering", eta), ("leaving", 1.0 / eta)] {
        let error = |step: u32| {
            let degrees = 90.0 * f64::from(step) / f64::from(STEPS);
            let cos = libm::cos(degrees.to_radians());
            (
                (fresnel::schlick(cos, eta).reflectance - fresnel::dielectric(cos, eta).reflectance).abs(),
                degrees,
            )
        };
        let (worst, at) = (0..=STEPS).map(error).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        println!("  largest |R_schlick - R_exact|, {way} (eta = {eta:.4}): {worst:.5} at {at:.2} degrees");
    }
}

/// The pixels whose centre ray hits glass.
fn glass_pixels(scene: &Scene) -> Vec<bool> {
    let (width, height) = scene.sensor.film.size;
    let sees_glass = |ray: &Ray| {
        let hit = scene.accel.closest(ray);
        let material = hit.map(|hit| scene.shape_of(hit.primitive).0.sides[0].material as usize);
        material.is_some_and(|material| scene.materials[material].name() == "dielectric")
    };
    let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let rows =
        (0..height).flat_map(|y| (0..width).map(move |x| DVec2::new(centre(x, width), centre(y, height))));
    rows.map(|place| sees_glass(&scene.sensor.camera.ray(place, DVec2::splat(0.5)))).collect()
}

/// The mean of all channels over some of the pixels.
fn mean(image: &Image, select: impl Fn(usize) -> bool) -> f64 {
    let chosen = |channel: &Channel| -> (f64, usize) {
        let values = channel.mean.iter().enumerate().filter(|(pixel, _)| select(*pixel));
        values.fold((0.0, 0), |(sum, n), (_, value)| (sum + f64::from(*value), n + 1))
    };
    let (sum, n) = image.channels.iter().map(chosen).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    sum / n as f64
}

/// A function of each pixel and channel of two images. The result is no render, so it has no variance and no
/// provenance.
fn combine(a: &Image, b: &Image, f: impl Fn(f32, f32) -> f32) -> Image {
    let channel = |(a, b): (&Channel, &Channel)| Channel {
        name: a.name.clone(),
        mean: a.mean.iter().zip(&b.mean).map(|(x, y)| f(*x, *y)).collect(),
        variance: None,
    };
    let channels = a.channels.iter().zip(&b.channels).map(channel).collect();
    Image { full: a.full, crop: a.crop, channels, provenance: None, accumulators: None }
}

/// A difference as a picture; 0 is grey.
fn show(difference: &Image) -> Rgb8 {
    let code = |value: f32| (127.5 + 127.5 * (GAIN * value).clamp(-1.0, 1.0) + 0.5) as u8;
    let channels = &difference.channels;
    let pixel =
        |i: usize| [0, 1, 2].map(|c: usize| channels.get(c).map_or(0, |channel| code(channel.mean[i])));
    let pixels = (0..difference.crop.pixels()).map(pixel).collect();
    Rgb8 { width: difference.crop.width, height: difference.crop.height, pixels }
}
