//! The command that resumes a render that ended early.

use super::Arguments;
use crate::cli::{quoted, shown};
use std::ops::Range;

impl Arguments {
    /// The whole command line that resumes from the checkpoint. No pilot runs again: the samples are those
    /// that were chosen.
    pub fn go_on(&self, samples: &Range<u64>) -> String {
        let mut words = ["etalon", "render"].map(String::from).to_vec();
        words.extend(self.scene.words());
        let mut say = |option: &str, value: Option<String>| {
            words.extend(value.into_iter().flat_map(|value| [option.to_owned(), value]));
        };
        say("-o", Some(shown(&self.output)));
        say("--png", self.png.as_deref().map(shown));
        let told = self.spp.is_some() || self.asks_pilot();
        say("--spp", told.then(|| samples.end.to_string()));
        say("--samples", self.samples.as_ref().map(|s| format!("{}..{}", s.start, s.end)));
        say("--crop", self.crop.map(|c| format!("{},{},{},{}", c.x, c.y, c.width, c.height)));
        say("--preview", self.preview.clone());
        say("--threads", Some(self.threads.to_string()).filter(|_| self.threads > 0));
        say("--checkpoint-every", self.checkpoint_every.map(|seconds| seconds.to_string()));
        say("--checkpoint", self.checkpoint.as_deref().map(shown));
        let flags = [("--quiet", self.quiet), ("--json", self.json), ("--resume", true)];
        words.extend(flags.iter().filter(|(_, set)| *set).map(|(flag, _)| (*flag).to_owned()));
        quoted(&words)
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
        arguments.go_on(&(0..400))
    }

    #[test]
    fn the_command_that_goes_on_is_whole_and_is_one() {
        let scene = "a.xml --color rgb --seed 7 -o b.exr --png c.png";
        let rest = "--crop 0,1,2,3 --threads 1 --checkpoint-every 0.5 --checkpoint ck --json";
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
