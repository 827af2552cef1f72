//! From a scene file and definitions to pictures on disk.

use etalon::film::Film;
use etalon::image::{self, Image, Rgb8};
use etalon::render::{Progress, Settings, render};
use etalon::scene::{Overrides, Scene};
use etalon::spectrum::ColorMode;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Settings that all pictures of the series share.
pub struct Studio {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Samples per pixel.
    pub samples: u32,
    /// Folder for the pictures.
    pub output: PathBuf,
}

impl Studio {
    /// Reads a scene at the series' size, with values for some of its `$parameters`.
    pub fn load(&self, path: &Path, definitions: &[(&str, String)]) -> Result<Scene, Box<dyn Error>> {
        let definitions: Vec<_> =
            definitions.iter().map(|(name, value)| ((*name).into(), value.clone())).collect();
        let overrides = Overrides { size: Some(self.size), ..Overrides::default() };
        Ok(etalon::load(path, &definitions, ColorMode::Spectral, &overrides)?)
    }

    /// Renders samples 0 to `samples` of every pixel.
    pub fn render(&self, scene: &Scene, samples: u32, seed: u32) -> Result<Image, Box<dyn Error>> {
        let settings = Settings { seed, threads: 0, ..Settings::of(scene, 0..u64::from(samples)) };
        let (image, report) = render(scene, &settings, &Progress::default())?;
        if report.non_finite > 0 {
            return Err(format!("{} samples are not finite", report.non_finite).into());
        }
        Ok(image)
    }

    /// Renders a picture, writes it as `name`.exr and `name`.png, and returns it with its caption.
    pub fn picture(
        &self,
        path: &Path,
        definitions: &[(&str, String)],
        name: &str,
        caption: &str,
    ) -> Result<(String, Rgb8), Box<dyn Error>> {
        let scene = self.load(path, definitions)?;
        let start = Instant::now();
        let image = self.render(&scene, self.samples, scene.sensor.sampler.seed)?;
        println!("{caption}: {:.1} s", start.elapsed().as_secs_f64());
        let picture = image::develop(&image)?;
        self.write(name, &image, &picture)?;
        Ok((caption.into(), picture))
    }

    /// Writes `name`.exr and `name`.png.
    pub fn write(&self, name: &str, image: &Image, picture: &Rgb8) -> Result<(), Box<dyn Error>> {
        image::write_exr(&self.output.join(format!("{name}.exr")), image)?;
        Ok(image::write_png(&self.output.join(format!("{name}.png")), picture)?)
    }
}

/// Parses `WxH`.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height): (u32, u32) = parsed.ok_or("expected such as 480x360")?;
    Film::check_size(width.into(), height.into())?;
    Ok((width, height))
}
