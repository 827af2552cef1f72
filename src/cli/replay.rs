//! `etalon replay`

use super::scene_arguments::SceneArguments;
use super::size::parse_pixel;
use super::{Outcome, say};
use etalon::integrator::{CameraPath, kernel_for};
use etalon::render::sample::SampleMaker;
use etalon::sensor::Optics;
use std::process::ExitCode;

/// Prints one sample as it was rendered, bit for bit: what it adds to each channel, and the vertices of its
/// path if the integrator is `path`
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Column and row
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: (u32, u32),
    /// Number of the sample, from 0
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u64).range(..u64::from(u32::MAX)))]
    sample: u64,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        let scene = self.scene.load(0)?;
        let (film, (x, y)) = (scene.sensor.film.crop, self.pixel);
        if x < film.x || y < film.y || x >= film.x + film.width || y >= film.y + film.height {
            let (right, bottom) = (film.x + film.width - 1, film.y + film.height - 1);
            let message = format!("the pixel {x},{y} is not on the film");
            return Err(format!("{message}: expected {},{} to {right},{bottom}", film.x, film.y).into());
        }
        let maker = SampleMaker::new(&scene, scene.sensor.sampler.seed, kernel_for(scene.features()));
        let replay = maker.replay(self.pixel, self.sample);
        let CameraPath { ray, λ, radiance, .. } = replay.path;
        say!("pixel {x},{y} sample {}", self.sample);
        say!("wavelengths {:?} nm", λ.nm);
        say!("ray from {:?} along {:?}", ray.origin.to_array(), ray.direction.to_array());
        for (i, event) in replay.vertices.iter().enumerate() {
            let place = match event.primitive {
                None => "in a medium".into(),
                Some(primitive) => {
                    let (_, local) = scene.shape_of(primitive);
                    format!("shape {}, primitive {local}", scene.shape_index(primitive))
                }
            };
            say!("vertex {} at {:?}, {place}, t = {:?}", i + 1, event.p.to_array(), event.t);
            say!("  throughput {:?}", event.throughput.0);
            say!("  radiance so far {:?}", event.radiance.0);
        }
        say!("radiance {:?}", radiance.0);
        let response = scene.sensor.camera.response();
        if response != 1.0 {
            say!("response {response:?} sr");
        }
        match maker.place_in_pixels(self.sample) {
            None => say!("filter weight {:?}", replay.weight),
            Some([x, y]) => {
                say!("counts for all pixels whose filters reach {:?}, {:?} within its own", x.ξ, y.ξ)
            }
        }
        for (number, added) in &replay.light_paths {
            say!("light path {number} adds {added:?}");
        }
        for (name, value) in maker.channel_names().iter().zip(&replay.values) {
            say!("channel {name} {value:?}");
        }
        Ok(ExitCode::SUCCESS)
    }
}
