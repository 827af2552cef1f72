//! Replay of one sample: its vertices and its contributions.

use super::sample::SampleMaker;
use super::spread::Spread;
use crate::film::Window;
use crate::integrator::path::reuse;
use crate::integrator::{CameraPath, Counters, Event};
use crate::sampler::SampleId;

/// A sample of a pixel that was replayed.
pub struct Replay {
    pub path: CameraPath,
    /// Weight of the reconstruction filter, which the path's radiance does not include; 1 where the filter
    /// spreads the sample over several pixels.
    pub weight: f64,
    /// The vertices of the path, if the integrator traces any.
    pub vertices: Vec<Event>,
    /// Light paths that reach the pixel, by number, and what they add to the colour channels.
    pub light_paths: Vec<(u64, Vec<f64>)>,
    /// What is added to each channel, all in all: also by samples of other pixels, where these count for
    /// several.
    pub values: Vec<f64>,
}

impl SampleMaker<'_> {
    /// Makes a sample as it was made in the image. Its vertices are those of its own path; what it shares
    /// with others is in its radiance only.
    pub fn replay(&self, pixel: (u32, u32), sample: u64) -> Replay {
        let channels = self.channel_names().len();
        let trace = |which: &[SampleId], counters: &mut Counters| {
            let mut values = vec![0.0; channels * which.len()];
            let (paths, weights) = self.samples(which, counters, &mut values);
            let mine = which.iter().position(|of| of.pixel == pixel).unwrap_or_default();
            (paths[mine], weights[mine], values[channels * mine..][..channels].to_vec())
        };
        let mut counters = Counters { log: Some(vec![]), ..Counters::default() };
        let mut traced = trace(&[SampleId { pixel, sample }], &mut counters);
        if self.reuse() > 1 {
            // Those without which this one would be another.
            let together: Vec<_> = reuse::cell(pixel, sample, self.film().size).collect();
            traced = trace(&together, &mut Counters::default());
        }
        let (path, weight, mut values) = traced;
        if self.film().spread.is_some() {
            let window = Window { x: pixel.0, y: pixel.1, width: 1, height: 1 };
            values = Spread::new(self, window, channels).one(sample);
        }
        let mut light_paths = vec![];
        let numbers = sample * self.light_paths()..(sample + 1) * self.light_paths();
        self.trace_light(numbers, &mut Counters::default(), |number, reached, added| {
            if reached == pixel {
                light_paths.push((number, added.to_vec()));
            }
        });
        for (_, added) in &light_paths {
            values.iter_mut().zip(added).for_each(|(value, added)| *value += added);
        }
        self.complete(&mut values);
        Replay { path, weight, vertices: counters.log.unwrap_or_default(), light_paths, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::kernel_for;
    use crate::load_text;
    use crate::render::{Progress, Settings, render};
    use crate::scene::trial::ball_of_glass;
    use crate::spectrum::ColorMode;

    #[test]
    fn a_sample_is_what_an_image_of_it_shows() {
        for reuse in ["1", "16"] {
            // With channels that follow from others.
            let text = ball_of_glass(&format!(
                r#"<integrator type="moment"><integrator type="path"><float name="light_paths" value="8"/>
                    <integer name="reuse" value="{reuse}"/></integrator></integrator>"#
            ));
            let scene = load_text("scene.xml", &text, ColorMode::Spectral).unwrap();
            let window = scene.sensor.film.crop;
            let settings = Settings::of(&scene, 0..1);
            let (image, _) = render(&scene, &settings, &Progress::default()).unwrap();
            let maker = SampleMaker::new(&scene, 0, kernel_for(scene.features()));
            let mut thrown = 0;
            for (i, (x, y)) in
                (0..window.height).flat_map(|y| (0..window.width).map(move |x| (x, y))).enumerate()
            {
                let replay = maker.replay((x, y), 0);
                let shown: Vec<f32> = image.channels.iter().map(|channel| channel.mean[i]).collect();
                let again: Vec<f32> = replay.values.iter().map(|value| *value as f32).collect();
                assert_eq!(shown, again, "{x} {y}, shared by {reuse}");
                thrown += replay.light_paths.len();
            }
            assert!(thrown > 0 && image.channels.len() > 3);
        }
    }
}
