//! `etalon render`

mod go_on;

use super::scene_arguments::SceneArguments;
use super::size::{parse_positive, parse_samples, parse_share, parse_window};
use super::summary::{self, Summary};
use super::watch::Watch;
use super::{INTERRUPTED, NOT_FINITE, Outcome, UNATTAINED, say};
use etalon::files::{self, FileError};
use etalon::film::Window;
use etalon::image::{self, Image};
use etalon::render::checkpoint::OwnCheckpoint;
use etalon::render::passes::Partial;
use etalon::render::quality::Quality;
use etalon::render::sample_count::{self, NoCount, Pilot};
use etalon::render::{Progress, RenderError, Report, Settings, checkpoint, memory};
use etalon::scene::Scene;
use std::error::Error;
use std::io;
use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Renders a scene to an OpenEXR file
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// OpenEXR file to write
    #[arg(short, long, value_name = "OUT.exr", value_parser = super::exr_file())]
    pub output: PathBuf,
    /// Also write an 8-bit picture
    #[arg(long, value_name = "OUT.png", value_parser = super::png_file())]
    png: Option<PathBuf>,
    /// Samples a pixel, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "samples")]
    spp: Option<u32>,
    /// Render for about this long; prints the number of samples that makes the image again
    #[arg(long, value_name = "SECONDS", value_parser = parse_positive, conflicts_with_all = ["spp", "samples"])]
    time: Option<f64>,
    /// Render until the image's mean has this relative standard error, such as 0.5% or 0.005; prints the
    /// number of samples
    #[arg(long, value_name = "E", value_parser = parse_share, conflicts_with_all = ["spp", "samples", "time"])]
    target_error: Option<f64>,
    /// Only these samples of every pixel; the file can be merged with others
    #[arg(long, value_name = "A..B", value_parser = parse_samples)]
    samples: Option<Range<u64>>,
    /// Only this part of the film
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_window, allow_hyphen_values = true)]
    crop: Option<Window>,
    /// Save the render in this file now and then, so that it can go on after an end of any kind
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between two savings; by default as often as costs at most 1 %
    #[arg(long, value_name = "SECONDS", value_parser = parse_positive, requires = "checkpoint")]
    pub checkpoint_every: Option<f64>,
    /// Go on from the checkpoint, if there is one yet, to the number of samples that it was begun with
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
    /// Show the render in the image viewer tev, which listens at port 14158
    #[arg(long, value_name = "HOST:PORT", value_parser = super::address)]
    pub preview: Option<String>,
    /// Threads, at most 1024; one for each processor by default
    #[arg(long, value_name = "T", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// Print nothing but warnings and errors
    #[arg(long)]
    quiet: bool,
    /// Print a JSON document about the render to standard output
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Outcome {
        let start = Instant::now();
        let scene = self.scene.load(usize::from(self.threads))?;
        let load_seconds = start.elapsed().as_secs_f64();
        let mut settings = self.settings(&scene)?;
        self.check(&scene, &settings)?;
        let (checkpoint, resumed) = self.resumed(&scene, &mut settings)?;
        let begun = resumed.as_ref().map(|partial| partial.samples.end);
        let start = Instant::now();
        let progress = Progress::default();
        let watch = Watch::new(&self, self.says_little(), &progress, checkpoint)?;
        // What is resumed has its number of samples.
        let pilot = match resumed {
            Some(_) => None,
            None => watch.aside(|| self.pilot(&scene, &settings, &progress))?,
        };
        let pilot_seconds = start.elapsed().as_secs_f64();
        if let Some(pilot) = &pilot {
            settings.samples = 0..pilot.count;
            self.tell_count(pilot)?;
        }
        let start = Instant::now();
        let (image, report) = match watch.render(&scene, &settings, resumed) {
            Err(RenderError::Stopped) => {
                let advice = if self.checkpoint.is_none() {
                    " With --checkpoint FILE a render can go on."
                } else {
                    ""
                };
                eprintln!("interrupted; no file was touched.{advice}");
                return Ok(ExitCode::from(INTERRUPTED));
            }
            rendered => rendered?,
        };
        let seconds = start.elapsed().as_secs_f64();
        self.write(&image).map_err(|error| watch.keep(&scene, &settings, error))?;
        let summary = Summary {
            scene: &scene,
            image: &image,
            asked: settings.samples.clone(),
            report: &report,
            quality: report.quality.unwrap_or_else(|| Quality::of_image(&image)),
            seconds,
            load_seconds,
            begun,
            pilot: pilot.map(|pilot| (pilot, pilot_seconds)),
            chosen: self.asks_pilot(),
            target_error: self.target_error,
        };
        if !summary.interrupted() {
            // Before anything is printed, which may fail.
            watch.finish();
        }
        self.tell(&summary, &watch)
    }

    /// Finds out before anything is rendered what would be lost at the end.
    fn check(&self, scene: &Scene, settings: &Settings) -> Result<(), Box<dyn Error>> {
        let outputs = [Some(&self.output), self.png.as_ref(), self.checkpoint.as_ref()];
        files::check_outputs(&scene.files, &outputs)?;
        if self.target_error.is_some() && !scene.integrator.has_radiance() {
            return Err(
                "--target-error: the integrator sees no light, and the error is that of light; use --spp"
                    .into(),
            );
        }
        let channels = scene.integrator.channel_names(&scene.sensor.film);
        if self.png.is_some() {
            image::check_developable(&channels)?;
        }
        let passes = self.in_passes() || self.asks_pilot() || scene.techniques.caustics.is_some();
        let light_paths = scene.techniques.light_paths().into();
        let spreads = scene.sensor.film.spread.is_some();
        let needs = memory::Needs { channels: channels.len(), passes, light_paths, spreads };
        memory::check(settings, needs, memory::available())?;
        Ok(())
    }

    /// Prints what came of the render.
    fn tell(&self, summary: &Summary, watch: &Watch) -> Outcome {
        if self.json {
            say!("{}", summary.document());
        } else if !self.quiet {
            summary.print()?;
        }
        let not_finite = summary.image.not_finite();
        self.warn(summary, not_finite);
        if summary.interrupted() {
            eprintln!("interrupted: the image has samples {:?} of {:?}", summary.samples(), summary.asked);
            if watch.is_kept() {
                eprintln!("go on with: {}", self.go_on(&summary.asked));
            }
            return Ok(ExitCode::from(INTERRUPTED));
        }
        if not_finite > 0 {
            return Ok(ExitCode::from(NOT_FINITE));
        }
        Ok(ExitCode::from(if summary.attained() == Some(false) { UNATTAINED } else { 0 }))
    }

    /// Whether the render must stop between passes, or can run through.
    pub fn in_passes(&self) -> bool {
        self.checkpoint.is_some() || self.preview.is_some()
    }

    /// Whether a pilot is to choose the number of samples.
    fn asks_pilot(&self) -> bool {
        self.time.is_some() || self.target_error.is_some()
    }

    fn says_little(&self) -> bool {
        self.quiet || self.json
    }

    fn settings(&self, scene: &Scene) -> Result<Settings, String> {
        let film = &scene.sensor.film;
        let window = self.crop.unwrap_or(film.crop);
        if !film.crop.encloses(&window) {
            let c = film.crop;
            let place = format!("{},{},{},{}", c.x, c.y, c.width, c.height);
            return Err(format!("--crop is not inside the film's {place}"));
        }
        let all = 0..u64::from(self.spp.unwrap_or(scene.sensor.sampler.samples));
        Ok(Settings {
            samples: self.samples.clone().unwrap_or(all),
            seed: scene.sensor.sampler.seed,
            window,
            threads: usize::from(self.threads),
            shard: self.samples.is_some(),
            kernel: None,
        })
    }

    /// The checkpoint, and the render in it; its samples are those that a pilot chose, if one was to. Without
    /// `--resume` there must be none, nor any other file in its place.
    fn resumed(
        &self,
        scene: &Scene,
        settings: &mut Settings,
    ) -> Result<(Option<OwnCheckpoint>, Option<Partial>), FileError> {
        let Some(path) = &self.checkpoint else { return Ok((None, None)) };
        if !self.resume || !path.exists() {
            let own = OwnCheckpoint::begin(path)?;
            if self.resume && !self.quiet {
                eprintln!(
                    "{}: there is no checkpoint yet; the render begins at the beginning",
                    path.display()
                );
            }
            return Ok((Some(own), None));
        }
        if self.asks_pilot() {
            settings.samples = checkpoint::chosen_samples(path)?;
        }
        let (own, partial) = OwnCheckpoint::resume(path, scene, settings)?;
        Ok((Some(own), Some(partial)))
    }

    fn pilot(
        &self,
        scene: &Scene,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<Option<Pilot>, String> {
        let count = match (self.time, self.target_error) {
            (Some(seconds), _) => sample_count::for_time(scene, settings, seconds, progress),
            (_, Some(target)) => sample_count::for_error(scene, settings, target, progress),
            _ => return Ok(None),
        };
        match count {
            Ok(pilot) => Ok(Some(pilot)),
            // The render will be stopped in the same way.
            Err(NoCount::Unfinished(RenderError::Stopped)) => Ok(None),
            Err(NoCount::Unfinished(error)) => Err(error.to_string()),
            Err(NoCount::Black) => Err(
                "--target-error: the pilot saw no visible light, and an error is relative to it; use --spp"
                    .into(),
            ),
            Err(NoCount::NonFinite) => {
                Err("--target-error: samples of the pilot are not finite; use --spp, which lists them".into())
            }
            Err(NoCount::TooMany) => {
                Err("--target-error: more samples would be needed than a pixel can have".into())
            }
        }
    }

    /// Prints the number of samples as soon as it is known: a render that is killed can then go on.
    fn tell_count(&self, pilot: &Pilot) -> io::Result<()> {
        if !self.says_little() {
            say!("pilot of {} samples a pixel, {} rays: --spp {}", pilot.samples, pilot.rays, pilot.count);
        }
        if self.target_error.is_some() && pilot.quality.heavy_tailed() {
            eprintln!("warning: {}", summary::heavy(&pilot.quality, "the pilot's"));
        }
        if self.target_error.is_some() && pilot.quality.relative_standard_error_of_mean == 0.0 {
            eprintln!(
                "warning: the pilot's {} samples of a pixel are all alike; of light that none of them has met nothing is known",
                pilot.samples
            );
        }
        Ok(())
    }

    fn write(&self, image: &Image) -> Result<(), image::ImageError> {
        image::write_exr(&self.output, image)?;
        match &self.png {
            Some(path) => image::write_png(path, &image::develop(image)?),
            None => Ok(()),
        }
    }

    fn warn(&self, summary: &Summary, not_finite: usize) {
        let report: &Report = summary.report;
        if self.target_error.is_some() && summary.quality.heavy_tailed() {
            eprintln!("warning: {}", summary::heavy(&summary.quality, "the image's"));
        }
        if report.cut > 0 {
            eprintln!(
                "warning: {} paths were cut at {} vertices",
                report.cut,
                etalon::integrator::MAX_VERTICES
            );
        }
        if report.non_finite == 0 {
            if not_finite > 0 {
                eprintln!("warning: {not_finite} pixels are beyond what a file of single precision holds");
            }
            return;
        }
        eprintln!("warning: {} samples are not finite; the first:", report.non_finite);
        for found in &report.first_non_finite {
            let ((x, y), sample) = (found.pixel, found.sample);
            eprintln!("  etalon replay {} --pixel {x},{y} --sample {sample}", self.scene.words());
        }
    }
}
