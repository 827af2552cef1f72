//! `validate renderer`: any renderer of `renderers.toml` on the reference scenes and the closed forms.
//!
//! The images of other renderers have no variances, so every scene is rendered with several seeds. A scene
//! that a renderer cannot render is reported with the reason and is inconclusive: it is no fault, and no
//! pass. One that renders none at all is an error.

use crate::closed_forms::{self, ClosedForm, LEVEL};
use crate::console::{percentage, positive_seconds, print};
use crate::documents::Documents;
use crate::references::{self, Reference};
use crate::renderers::{self, Job, Renderer};
use etalon::spectrum::ColorMode;
use std::cell::{Cell, OnceCell};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;
use validation::image::{Image, Settings, compare, load};
use validation::statistics::{seed_for, sidak};
use validation::{Outcome, Report, Verdict};

#[derive(clap::Args)]
pub struct Arguments {
    /// Its name in the file of renderers
    renderer: String,
    /// Only scenes whose name contains this
    name: Option<String>,
    /// Another file of renderers
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Which references it is held against: those that are spectral, or those of three channels. By default
    /// as the file of renderers says of it, or those of three channels
    #[arg(long, value_name = "spectral|rgb")]
    color: Option<ColorMode>,
    /// Samples a pixel of each picture of a reference scene
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Pictures of each scene, of which variances are made
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..))]
    seeds: u32,
    /// Largest relative difference of a channel's mean that is none
    #[arg(long, default_value = "0.5%", value_parser = percentage)]
    margin: f64,
    /// Seconds that one picture may take
    #[arg(long, value_name = "SECONDS", value_parser = positive_seconds)]
    timeout: Option<Duration>,
    /// Another number, other seeds
    #[arg(long, default_value_t = 0, value_parser = crate::console::number)]
    number: u64,
    #[command(flatten)]
    documents: Documents,
}

/// Compares a renderer with the references, and with the closed forms of the same kind of colours.
pub fn run(arguments: Arguments) -> Result<Verdict, Box<dyn Error>> {
    let Arguments { renderer, name, file, color, spp, seeds, margin, timeout, number, documents } = arguments;
    let file = file.unwrap_or_else(renderers::file);
    let known = renderers::load(&file)?;
    let template = known.get(&renderer).ok_or_else(|| {
        let names: Vec<&str> = known.keys().map(String::as_str).collect();
        format!("{} has no renderer {renderer:?}; known are {}", file.display(), names.join(", "))
    })?;
    documents.check_writable(&[&file], &[])?;
    let color = match (color, template.color) {
        (Some(asked), Some(own)) if asked != own => {
            let own = own.name();
            return Err(format!("{} says that {renderer} carries colour as {own}", file.display()).into());
        }
        (asked, own) => asked.or(own).unwrap_or(ColorMode::Rgb),
    };
    let chosen = |mode: ColorMode, other: &str| {
        mode == color && name.as_ref().is_none_or(|name| other.contains(name.as_str()))
    };
    let mut references = references::references(&references::folder())?;
    references.retain(|reference| chosen(reference.mode, &reference.name));
    let mut cases = closed_forms::cases();
    cases.retain(|case| chosen(case.mode, &case.name));
    let questions = references.len() + cases.len();
    if questions == 0 {
        return Err(format!("there is no such scene among those of --color {}", color.name()).into());
    }
    let folder = tempfile::tempdir()?;
    let level = sidak(LEVEL, questions);
    let guest = Guest {
        renderer: template,
        folder: folder.path(),
        number,
        level,
        limit: timeout,
        heeds_seeds: OnceCell::new(),
        has_rendered: Cell::new(false),
    };
    let mut outcomes = vec![];
    let mut tell = |outcome: Outcome| {
        print(&outcome);
        outcomes.push(outcome);
    };
    for reference in &references {
        tell(guest.meets(reference, spp, seeds, margin));
    }
    for case in &cases {
        tell(guest.knows(case, seeds));
    }
    let nothing = format!("{renderer} has rendered none of {questions} scenes");
    let verdict = documents.finish(Report::new(renderer, outcomes))?;
    if guest.has_rendered.get() { Ok(verdict) } else { Err(nothing.into()) }
}

/// A renderer under test.
struct Guest<'a> {
    renderer: &'a Renderer,
    /// Folder for its pictures, and for scenes that are in no file.
    folder: &'a Path,
    number: u64,
    /// Level of each comparison, chosen so that a correct renderer is called different anywhere with
    /// probability 1 %.
    level: f64,
    /// How long a picture may take.
    limit: Option<Duration>,
    /// Whether its pictures of different seeds differ, once that is known.
    heeds_seeds: OnceCell<bool>,
    /// Whether there has been a picture of any scene.
    has_rendered: Cell<bool>,
}

/// A reference scene that no renderer renders without noise.
const NOISY: &str = "cornell.xml";

impl Guest<'_> {
    /// Compares a reference scene with the stored image.
    fn meets(&self, reference: &Reference, samples: u32, seeds: u32, margin: f64) -> Outcome {
        let judged = || {
            let pictures = self.pictures(&reference.name, &reference.scene, samples, seeds)?;
            let theirs = reference.image()?;
            // Size and channels of the pictures must agree before anything else.
            let mut ours = Image::from_replicates(&pictures).map_err(|e| e.to_string())?;
            let names =
                |of: &Image| of.channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>().join(", ");
            let found = names(&ours);
            ours.channels.retain(|own| theirs.channels.iter().any(|other| other.name == own.name));
            if ours.channels.is_empty() {
                return Err(format!(
                    "the picture has channels {found}, and {} are asked for",
                    names(&theirs)
                ));
            }
            let settings = Settings { level: self.level, ..references::settings(margin) };
            let comparison = compare(&theirs, &ours, &settings).map_err(|e| e.to_string())?;
            match comparison.uncompared.first() {
                Some(lost) => Err(format!("there is no channel {lost}")),
                None if !comparison.identical => {
                    self.noise_is_known(&pictures).map(|()| comparison.outcome())
                }
                None => Ok(comparison.outcome()),
            }
        };
        judged().unwrap_or_else(|why| unable("images", &why)).of(&reference.name)
    }

    /// Compares a scene with its analytic solution.
    fn knows(&self, case: &ClosedForm, seeds: u32) -> Outcome {
        let judged = || {
            let scene = self.folder.join("scene.xml");
            std::fs::write(&scene, case.standing_alone()).map_err(|e| e.to_string())?;
            let samples = u32::try_from(case.samples).map_err(|e| e.to_string())?;
            let pictures = self.pictures(&case.name, &scene, samples, seeds)?;
            self.noise_is_known(&pictures).map(|()| case.judge_images(&pictures, self.level))
        };
        judged().unwrap_or_else(|why: String| unable("closed form", &why)).of(&case.name)
    }

    /// Error: the pictures are all the same, and so are others of a scene with noise: then they are one
    /// picture, whose noise would pass for an error, or an error for noise.
    fn noise_is_known(&self, pictures: &[Image]) -> Result<(), String> {
        let same = |pictures: &[Image]| pictures.windows(2).all(|pair| pair[0] == pair[1]);
        if !same(pictures) {
            let _known = self.heeds_seeds.set(true);
            return Ok(());
        }
        let heeds = match self.heeds_seeds.get() {
            Some(known) => *known,
            None => {
                let noisy = references::folder().join("scenes").join(NOISY);
                !same(&self.pictures("whether seeds have an effect", &noisy, 1, 2)?)
            }
        };
        if *self.heeds_seeds.get_or_init(|| heeds) {
            Ok(())
        } else {
            Err("its pictures of different seeds are the same: the seed has no effect, so their noise is unknown".into())
        }
    }

    /// Renders pictures with different seeds.
    fn pictures(&self, name: &str, scene: &Path, samples: u32, count: u32) -> Result<Vec<Image>, String> {
        let out = self.folder.join("picture.exr");
        let picture = |index: u32| {
            let number = self.number * u64::from(count) + u64::from(index);
            // Many programs accept no more than 31 bits.
            let seed = seed_for(name, number) as u32 >> 1;
            let job = Job { limit: self.limit, ..Job::new(scene, samples, seed) };
            self.renderer.run(&job, &out)?;
            let image = load(&out).map_err(|e| e.to_string())?;
            self.has_rendered.set(true);
            Ok(image)
        };
        (0..count).map(picture).collect()
    }
}

fn unable(check: &str, why: &str) -> Outcome {
    Outcome::new(check, Verdict::Inconclusive, format!("not rendered: {why}"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// The outcome for a renderer with this command, of which is known, or not, whether it heeds seeds.
    fn verdict_on(command: String, heeds_seeds: Option<bool>, ask: impl Fn(&Guest) -> Outcome) -> Outcome {
        static FOLDERS: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let number = FOLDERS.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("etalon-guest-test-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let renderer = Renderer { command, mean_of: None, color: None };
        let heeds_seeds = heeds_seeds.map_or(OnceCell::new(), OnceCell::from);
        let guest = Guest {
            renderer: &renderer,
            folder: &folder,
            number: 0,
            level: LEVEL,
            limit: None,
            heeds_seeds,
            has_rendered: Cell::new(false),
        };
        let outcome = ask(&guest);
        assert_eq!(guest.has_rendered.get(), !outcome.message.starts_with("not rendered: \"false\" failed"));
        std::fs::remove_dir_all(&folder).unwrap();
        outcome
    }

    fn reference(name: &str) -> Reference {
        let all = references::references(&references::folder()).unwrap();
        all.into_iter().find(|reference| reference.name == name).unwrap()
    }

    #[test]
    fn the_right_picture_holds_another_differs_and_none_is_no_answer() {
        let asked = reference("camera-x::rgb");
        let copying = |name: &str| {
            let command = format!("cp {:?} {{out}}", reference(name).image);
            verdict_on(command, Some(true), |guest| guest.meets(&asked, 1, 4, 0.005))
        };
        assert_eq!(copying("camera-x::rgb").verdict, Verdict::Equivalent);
        assert_eq!(copying("camera-y::rgb").verdict, Verdict::Different);
        let failing = verdict_on("false".into(), None, |guest| guest.meets(&asked, 1, 4, 0.005));
        assert_eq!(failing.verdict, Verdict::Inconclusive);
        assert!(failing.message.starts_with("not rendered: \"false\" failed"), "{}", failing.message);
    }

    #[test]
    fn a_closed_form_finds_its_files_and_judges_what_it_is_shown() {
        let sky = closed_forms::cases().into_iter().find(|case| case.name == "envmap::turned").unwrap();
        let place = format!("<path value=\"{}\"/>", references::folder().join("scenes").display());
        assert!(sky.standing_alone().starts_with(&format!("<scene version=\"3.0.0\">{place}")));
        // Any other picture is wrong.
        let command = format!("cp {:?} {{out}}", reference("camera-x::rgb").image);
        let verdict = |known| verdict_on(command.clone(), known, |guest| guest.knows(&sky, 4));
        assert_eq!(verdict(Some(true)).verdict, Verdict::Different);
        // But not by a program that makes the same picture of whatever seed.
        let deaf = verdict(None);
        assert!(deaf.verdict == Verdict::Inconclusive && deaf.message.contains("the seed has no effect"));
    }
}
