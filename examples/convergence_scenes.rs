//! Makes the files of the scenes of `scenes/convergence` that are too large for the repository, or easier to
//! compute than to draw: two meshes with 1 966 080 triangles in three bodies, a sky with a sun, and the
//! interior's textures.
//!
//! ```sh
//! cargo run --release --example convergence_scenes
//! ```

use etalon::film::Window;
use etalon::image::{self, Channel, Image, Rgb8};
use etalon::shape::mesh_data::{sea_urchin, write_ply};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;

/// Width in pixels of the sky's image; its height is half of it.
const SKY: u32 = 512;
/// Direction to the sun, with +y up.
const SUN: [f64; 3] = [0.45, 0.62, 0.64];
/// Angular radius of the sun in radians: a haze makes it four times as large as the true one.
const SUN_RADIUS: f64 = 0.019;
/// Width and height of a texture in pixels.
const TEXTURE: u32 = 96;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let textures = root.join("scenes/convergence/textures");
    let made = root.join("target/convergence");
    std::fs::create_dir_all(&made)?;
    image::write_png(&textures.join("wallpaper.png"), &texture(wallpaper))?;
    image::write_png(&textures.join("planks.png"), &texture(planks))?;
    image::write_exr(&made.join("sky.exr"), &sky())?;
    for subdivision in [7, 8] {
        write_ply(&sea_urchin(subdivision), &made.join(format!("urchin-{subdivision}.ply")))?;
    }
    println!("{}", made.display());
    Ok(())
}

/// A latitude–longitude image: the direction (sin θ sin φ, cos θ, −sin θ cos φ) is at (φ/2π, θ/π), where φ =
/// 0 is the centre.
fn sky() -> Image {
    let (width, height) = (SKY, SKY / 2);
    let length = SUN.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut colors = [Vec::new(), Vec::new(), Vec::new()];
    for row in 0..height {
        let (sine, cosine) = libm::sincos(PI * (f64::from(row) + 0.5) / f64::from(height));
        for column in 0..width {
            let phi = 2.0 * PI * ((f64::from(column) + 0.5) / f64::from(width) - 0.5);
            let direction = [sine * libm::sin(phi), cosine, -sine * libm::cos(phi)];
            let toward = direction.iter().zip(SUN).map(|(a, b)| a * b).sum::<f64>() / length;
            for (values, value) in colors.iter_mut().zip(radiance(cosine, toward)) {
                values.push(value as f32);
            }
        }
    }
    let channel = |(name, mean): (&str, Vec<f32>)| Channel { name: name.into(), mean, variance: None };
    Image {
        full: (width, height),
        crop: Window { x: 0, y: 0, width, height },
        channels: ["R", "G", "B"].into_iter().zip(colors).map(channel).collect(),
        provenance: None,
        accumulators: None,
    }
}

/// Radiance from a height above the horizon and the cosine of the angle to the sun: blue above, pale at the
/// horizon, brown below.
fn radiance(height: f64, toward: f64) -> [f64; 3] {
    if toward > libm::cos(SUN_RADIUS) {
        return [1600.0, 1450.0, 1200.0];
    }
    if height < 0.0 {
        return [0.16, 0.14, 0.11];
    }
    let pale = libm::exp(-4.0 * height);
    let glow = 0.6 * libm::exp(-12.0 * (1.0 - toward));
    [0.14 + 0.46 * pale + glow, 0.28 + 0.36 * pale + 0.9 * glow, 0.62 + 0.12 * pale + 0.7 * glow]
}

fn texture(color: fn(f64, f64) -> [f64; 3]) -> Rgb8 {
    let mut picture = Rgb8::filled(TEXTURE, TEXTURE, [0; 3]);
    let place = |index: u32| (f64::from(index) + 0.5) / f64::from(TEXTURE);
    for row in 0..TEXTURE {
        for column in 0..TEXTURE {
            let bytes = color(place(column), place(row)).map(|value| image::encode_srgb(value as f32));
            picture.paste(&Rgb8::filled(1, 1, bytes), column, row);
        }
    }
    picture
}

/// Dots within lozenges, periodic over the edges.
fn wallpaper(x: f64, y: f64) -> [f64; 3] {
    let [across, along] = [x, y].map(|t| libm::cos(2.0 * PI * 2.0 * t));
    if (across + along).abs() < 0.18 {
        [0.62, 0.52, 0.30]
    } else if across * along > 0.86 {
        [0.45, 0.12, 0.14]
    } else {
        [0.22, 0.36, 0.34]
    }
}

/// Four boards with joints between them and a grain along them.
fn planks(x: f64, y: f64) -> [f64; 3] {
    let board = (4.0 * y).floor();
    let within = 4.0 * y - board;
    let grain = libm::sin(60.0 * within + 5.0 * libm::sin(2.0 * PI * x + 2.0 * board) + 9.0 * board);
    let shade = 0.75 + 0.12 * grain + 0.06 * libm::sin(31.0 * board);
    let joint = if within < 0.04 { 0.3 } else { 1.0 };
    [0.50, 0.29, 0.14].map(|value| value * shade * joint)
}
