//! The pictures of the course path tracer from which Etalon developed: mirror and glass by number of bounces,
//! a thin lens by aperture and focus, and the error of Schlick's approximation to Fresnel's equations.
//!
//! ```sh
//! cargo run --release --example series            # all of it, into target/series
//! cargo run --release --example series -- --size 160x120 --spp 8
//! ```

mod comparison;
mod picture;

use clap::Parser;
use etalon::image::{self, Rgb8};
use etalon::shape::mesh_data::{sea_urchin, write_ply};
use picture::Studio;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Bounces, in the course's count.
const BOUNCES: [u32; 7] = [0, 1, 2, 3, 4, 5, 100];
/// Radius b of the lens and depth d of the plane of focus.
const LENSES: [(f64, f64); 6] = [(0.18, 3.5), (0.18, 4.0), (0.18, 4.5), (0.18, 5.0), (0.15, 4.5), (0.2, 4.5)];

#[derive(Parser)]
struct Arguments {
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "480x360", value_parser = picture::parse_size)]
    size: (u32, u32),
    /// Samples a pixel; the comparison of the Fresnel terms takes four times as many
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Folder for the pictures
    #[arg(long, default_value = "target/series")]
    output: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/assignment");
    std::fs::create_dir_all(&arguments.output)?;
    let studio = Studio { size: arguments.size, samples: arguments.spp, output: arguments.output };
    let mut pictures = spheres(&studio, &scenes.join("spheres.xml"))?;
    pictures.extend(lenses(&studio, &scenes.join("focus.xml"))?);
    pictures.extend(comparison::run(&studio, &scenes.join("spheres.xml"))?);
    let sheet = studio.output.join("sheet.png");
    image::write_png(&sheet, &image::contact_sheet(&pictures, 4))?;
    println!("{}", sheet.display());
    Ok(())
}

type Captioned = Vec<(String, Rgb8)>;

/// Mirror and glass: a path of m bounces has m + 1 edges, which is what Mitsuba's `max_depth` counts.
fn spheres(studio: &Studio, scene: &Path) -> Result<Captioned, Box<dyn Error>> {
    let picture = |m: u32| {
        let definitions = [("max_depth", (m + 1).to_string())];
        studio.picture(scene, &definitions, &format!("spheres-m{m}"), &format!("spheres, m = {m}"))
    };
    BOUNCES.into_iter().map(picture).collect()
}

/// Depth of field, on a mesh that is generated here.
fn lenses(studio: &Studio, scene: &Path) -> Result<Captioned, Box<dyn Error>> {
    let mesh = std::path::absolute(studio.output.join("urchin.ply"))?;
    write_ply(&sea_urchin(7), &mesh)?;
    let picture = |(b, d): (f64, f64)| {
        let definitions = [
            ("mesh", mesh.display().to_string()),
            ("aperture_radius", b.to_string()),
            ("focus_distance", d.to_string()),
        ];
        studio.picture(scene, &definitions, &format!("focus-b{b}-d{d}"), &format!("lens b = {b}, d = {d}"))
    };
    LENSES.into_iter().map(picture).collect()
}
