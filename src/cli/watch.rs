//! What accompanies a render: the progress bar, the checkpoint, the preview, and Ctrl-C or the end of a
//! terminal.

use super::render::Arguments;
use etalon::image::{Image, ImageError};
use etalon::render::checkpoint::OwnCheckpoint;
use etalon::render::passes::{Partial, render_passes};
use etalon::render::preview::Preview;
use etalon::render::{Progress, RenderError, Report, Settings, checkpoint, render};
use etalon::scene::Scene;
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::cell::RefCell;
use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Shortest time between two savings of the checkpoint, unless another is given.
const SELDOM: Duration = Duration::from_secs(5);

/// Largest share of the time that saving checkpoints may take.
const SHARE: f64 = 0.01;

/// A signal that comes again after less than this is still the first: who stops a whole group of processes
/// may signal its members twice.
const ECHO: Duration = Duration::from_millis(500);

/// Bytes a second at which checkpoints are written, until it is known.
const SPEED: f64 = 1e8;

/// Whether `nohup` has told the process to outlive its terminal, which a handler would undo. Where the system
/// does not say, that is assumed.
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok());
    mask.is_none_or(|mask| mask >> (SIGHUP - 1) & 1 == 1)
}

/// Watches one render.
pub struct Watch<'a> {
    arguments: &'a Arguments,
    silent: bool,
    progress: &'a Progress,
    /// Ctrl-C was pressed, or the system asked for an end.
    interrupted: Arc<AtomicBool>,
    checkpoint: Option<OwnCheckpoint>,
    /// The complete sums, kept until the image is safely written.
    complete: RefCell<Option<Partial>>,
}

impl<'a> Watch<'a> {
    pub fn new(
        arguments: &'a Arguments,
        silent: bool,
        progress: &'a Progress,
        checkpoint: Option<OwnCheckpoint>,
    ) -> Result<Self, Box<dyn Error>> {
        let interrupted = Arc::new(AtomicBool::new(false));
        let mut signals = Signals::new([SIGINT, SIGTERM])?;
        if !hang_up_is_ignored() {
            signals.handle().add_signal(SIGHUP)?;
        }
        let flag = interrupted.clone();
        std::thread::spawn(move || {
            let mut first = None;
            for _ in signals.forever() {
                flag.store(true, Ordering::Relaxed);
                if first.get_or_insert_with(Instant::now).elapsed() > ECHO {
                    std::process::exit(i32::from(super::INTERRUPTED));
                }
            }
        });
        Ok(Self { arguments, silent, progress, interrupted, checkpoint, complete: RefCell::new(None) })
    }

    /// Does some work that has no passes and that Ctrl-C stops at once.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        self.beside(None, true, work)
    }

    /// Renders, from the checkpoint if there is one. An interrupted render has an image of fewer samples than
    /// were asked for, or none.
    pub fn render(
        &self,
        scene: &Scene,
        settings: &Settings,
        resumed: Option<Partial>,
    ) -> Result<(Image, Report), RenderError> {
        let done = resumed.as_ref().map_or(0, |partial| partial.report.samples);
        self.progress.done.store(done, Ordering::Relaxed);
        let pixels = settings.window.pixels() as u64;
        let bar = ProgressBar::new(pixels * (settings.samples.end - settings.samples.start));
        let template = "{bar:40} {percent:>3} %  {elapsed} elapsed, {eta} to go  {per_sec}";
        bar.set_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar()));
        let bar = (!self.silent).then_some(bar);
        if !self.arguments.in_passes() {
            return self.beside(bar, true, || render(scene, settings, self.progress));
        }
        let begun = resumed.unwrap_or_else(|| Partial::new(scene, settings));
        let preview = self.arguments.preview.as_ref().and_then(|address| {
            let name = self.arguments.output.display().to_string();
            let film = scene.sensor.film.size;
            Preview::connect(address, &name, film, settings.window, &begun.channels)
                .inspect_err(|error| eprintln!("warning: no preview at {address}: {error}"))
                .ok()
        });
        let saver = |own| Saver::new(own, self.arguments, settings, begun.channels.len());
        let mut saver = self.checkpoint.as_ref().map(saver);
        let interrupted = &self.interrupted;
        // What nothing could go on from is not worth a file in the place of a whole one.
        let kept = self.checkpoint.is_some();
        let partial = self.beside(bar, !kept, || {
            render_passes(scene, settings, begun, self.progress, |partial| {
                if let Some(preview) = &preview {
                    preview.show(partial);
                }
                let ends = kept && interrupted.load(Ordering::Relaxed);
                let last = partial.samples.end == settings.samples.end;
                if let Some(saver) = &mut saver
                    && (ends || saver.is_due() && !last)
                {
                    saver.save(scene, settings, partial);
                }
                if ends { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        })?;
        if let Some(Err(error)) = preview.map(|preview| preview.finish(&partial)) {
            eprintln!("warning: the preview broke off: {error}");
        }
        let (image, report) = partial.finished(scene, settings);
        self.complete.replace(Some(partial));
        Ok((image, report))
    }

    /// After the image could not be written: saves the sums, so that the work is not lost, and says so.
    pub fn keep(&self, scene: &Scene, settings: &Settings, error: ImageError) -> String {
        let (Some(own), Some(partial)) = (&self.checkpoint, &*self.complete.borrow()) else {
            return error.to_string();
        };
        match own.save(scene, settings, partial) {
            Ok(()) => {
                let command = self.arguments.go_on(&settings.samples);
                let path = own.path().display();
                format!("{error}\nthe render is kept in {path}; this writes the image: {command}")
            }
            Err(also) => format!("{error}\nthe checkpoint neither: {also}"),
        }
    }

    /// Whether there is a checkpoint from which this render can go on.
    pub fn is_kept(&self) -> bool {
        self.checkpoint.as_ref().is_some_and(|own| own.exists().unwrap_or(false))
    }

    /// After the image has been written: removes the checkpoint, which is not needed any more.
    pub fn finish(&self) {
        if let Some(Err(error)) = self.checkpoint.as_ref().map(OwnCheckpoint::remove) {
            eprintln!("warning: {error}");
        }
    }

    /// Does some work while another thread shows its progress. `at_once` says whether Ctrl-C stops it within
    /// a pass.
    fn beside<T>(&self, bar: Option<ProgressBar>, at_once: bool, work: impl FnOnce() -> T) -> T {
        let finished = AtomicBool::new(false);
        let (interrupted, progress) = (&self.interrupted, self.progress);
        std::thread::scope(|threads| {
            // However the work ends, a panic included: the scope waits for the watcher.
            let end = Finished(&finished);
            let watcher = threads.spawn(|| {
                while !finished.load(Ordering::Relaxed) {
                    if at_once && interrupted.load(Ordering::Relaxed) {
                        progress.stop.store(true, Ordering::Relaxed);
                    }
                    if let Some(bar) = &bar {
                        bar.set_position(progress.done.load(Ordering::Relaxed));
                    }
                    std::thread::park_timeout(Duration::from_millis(50));
                }
            });
            let result = work();
            drop(end);
            watcher.thread().unpark();
            if let Some(bar) = &bar {
                bar.finish_and_clear();
            }
            result
        })
    }
}

/// Tells the watcher that the work is over.
struct Finished<'a>(&'a AtomicBool);

impl Drop for Finished<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Saves checkpoints, not too often.
struct Saver<'a> {
    own: &'a OwnCheckpoint,
    /// Pause between two savings that was asked for.
    every: Option<Duration>,
    last: Instant,
    /// How long a saving takes.
    cost: Duration,
    warned: bool,
}

impl<'a> Saver<'a> {
    fn new(own: &'a OwnCheckpoint, arguments: &Arguments, settings: &Settings, channels: usize) -> Self {
        let cost = Duration::from_secs_f64(checkpoint::size(settings, channels) as f64 / SPEED);
        // What no duration can hold means never.
        let duration = |seconds| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        let every = arguments.checkpoint_every.map(duration);
        Self { own, every, last: Instant::now(), cost, warned: false }
    }

    fn is_due(&self) -> bool {
        self.last.elapsed() >= self.every.unwrap_or(SELDOM.max(self.cost.div_f64(SHARE)))
    }

    /// A checkpoint that cannot be written does not end the render.
    fn save(&mut self, scene: &Scene, settings: &Settings, partial: &Partial) {
        let begin = Instant::now();
        if let Err(error) = self.own.save(scene, settings, partial)
            && !self.warned
        {
            eprintln!("warning: {error}");
            self.warned = true;
        }
        self.cost = begin.elapsed();
        self.last = Instant::now();
    }
}
