//! The command that resumes a render that ended early.

use super::Arguments;
use crate::cli::words::{Words, shown};
use std::ops::Range;

impl Arguments {
    /// The whole command line that resumes from the checkpoint. No pilot runs again: the samples are those
    /// that were chosen.
    pub fn go_on(&self, samples: &Range<u64>) -> Words {
        // All of them, so that none can be forgotten.
        let Self {
            scene,
            output,
            png,
            spp,
            time: _,
            target_error: _,
            samples: range,
            crop,
            checkpoint,
            checkpoint_every,
            resume: _,
            preview,
            threads,
            quiet,
            json,
        } = self;
        let mut words = Words::default();
        words.push("etalon");
        words.push("render");
        let mut words = words.then(scene.words());
        words.option("-o", Some(shown(output)));
        words.option("--png", png.as_deref().map(shown));
        words.option("--spp", (spp.is_some() || self.asks_pilot()).then_some(samples.end));
        words.option("--samples", range.as_ref().map(|range| format!("{}..{}", range.start, range.end)));
        words.option("--crop", crop.map(|c| format!("{},{},{},{}", c.x, c.y, c.width, c.height)));
        words.option("--preview", preview.as_ref());
        words.option("--threads", Some(threads).filter(|threads| **threads > 0));
        words.option("--checkpoint-every", *checkpoint_every);
        words.option("--checkpoint", checkpoint.as_deref().map(shown));
        words.flag("--quiet", *quiet);
        words.flag("--json", *json);
        words.flag("--resume", true);
        words
    }
}

#[cfg(test)]
mod tests {
    use crate::cli::Command;
    use clap::Parser;

    /// What is printed for `etalon render` with these arguments, after a pilot that chose 400 samples.
    fn printed(arguments: &str) -> String {
        let words = ["etalon", "render"].into_iter().chain(arguments.split(' '));
        let Command::Render(arguments) = Command::try_parse_from(words).unwrap() else { panic!() };
        arguments.go_on(&(0..400)).to_string()
    }

    #[test]
    fn the_command_that_goes_on_is_whole_and_is_one() {
        let scene = "a.xml -D spp=4 --color rgb --integrator path --max-depth 9 --light-paths 0.5 --reuse auto \
                     --shared-light-paths 2 --links guided --sensor 1 --size 64x48 --sampler sobol --seed 7 -o b.exr \
                     --png c.png";
        let rest = "--crop 0,1,2,3 --preview localhost:14158 --threads 1 --checkpoint-every 0.5 --checkpoint ck --json";
        for chosen in ["--time 60", "--target-error 0.5%", "--spp 400"] {
            let command = printed(&format!("{scene} {chosen} {rest}"));
            assert_eq!(command, format!("etalon render {scene} --spp 400 {rest} --resume"));
            // It is a command, and leads to itself.
            assert_eq!(printed(command.strip_prefix("etalon render ").unwrap()), command);
        }
        assert_eq!(
            printed("a.xml -o b.exr --samples 8..400 --checkpoint ck --quiet"),
            "etalon render a.xml -o b.exr --samples 8..400 --checkpoint ck --quiet --resume"
        );
        assert_eq!(
            printed("-o=-b.exr --spp 400 --checkpoint=-ck -- -a.xml"),
            "etalon render ./-a.xml -o ./-b.exr --spp 400 --checkpoint ./-ck --resume"
        );
    }
}
