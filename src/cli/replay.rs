//! `etalon replay`

use super::size::parse_pixel;
use super::{Outcome, SceneArguments, say};
use etalon::integrator::{CameraPath, Counters, kernel_for};
use etalon::render::sample::Camera;
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
            return Err(format!("the pixel {x},{y} is not on the film").into());
        }
        let camera = Camera::new(&scene, scene.sensor.sampler.seed, kernel_for(scene.features));
        let mut counters = Counters { log: Some(vec![]), ..Counters::default() };
        let (path, weight) = camera.replay(self.pixel, self.sample, &mut counters);
        let CameraPath { ray, λ, radiance, .. } = path;
        say!("pixel {x},{y} sample {}", self.sample);
        say!("wavelengths {:?} nm", λ.nm);
        say!("ray from {:?} along {:?}", ray.origin.to_array(), ray.direction.to_array());
        for (i, event) in counters.log.iter().flatten().enumerate() {
            let (shape, local) = scene.shape_of(event.hit.primitive);
            let index = scene.index_of(shape);
            say!(
                "vertex {} at {:?}, shape {index}, primitive {local}, t = {:?}",
                i + 1,
                event.p.to_array(),
                event.hit.t
            );
            say!("  throughput {:?}", event.throughput.0);
            say!("  radiance so far {:?}", event.radiance.0);
        }
        say!("radiance {:?}", radiance.0);
        say!("filter weight {weight:?}");
        for (name, value) in camera.channel_names().iter().zip(camera.values(self.pixel, self.sample)) {
            say!("channel {name} {value:?}");
        }
        let paths = camera.light_paths();
        let numbers = self.sample * paths..(self.sample + 1) * paths;
        let mut additions = vec![];
        camera.trace_light(numbers, &mut Counters::default(), |number, pixel, values| {
            if pixel == self.pixel {
                additions.push(format!("light path {number} adds {values:?}"));
            }
        });
        for addition in additions {
            say!("{addition}");
        }
        Ok(ExitCode::SUCCESS)
    }
}
