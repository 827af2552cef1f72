//! Bad input: the program gives the reason and the place, exits with 2, and changes nothing.

mod documents;
mod files;
mod numbers;
mod structure;

use std::fs;
use std::path::Path;
use std::process::Command;

/// A sensor with a small film, so that a scene accepted by mistake renders quickly.
const SENSOR: &str = r#"<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>"#;

const OLD: &[u8] = b"the image of yesterday";

/// A folder with `scene.xml` and an `out.exr` that must not change.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(scene: &[u8]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("scene.xml"), scene).expect("written");
        fs::write(folder.path().join("out.exr"), OLD).expect("written");
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Asserts that rendering the scene is refused.
    fn refused(&self, words: &[&str]) {
        self.refused_given(&[], words);
    }

    /// Asserts that rendering the scene with further arguments is refused.
    fn refused_given(&self, arguments: &[&str], words: &[&str]) {
        let all = [&["render", "scene.xml", "-o", "out.exr", "--threads", "1"], arguments].concat();
        self.command_refused(&all, words);
    }

    /// Asserts that the program exits with 2 after one error that contains all the words, and that the folder
    /// is unchanged.
    fn command_refused(&self, arguments: &[&str], words: &[&str]) {
        let before = self.list();
        let mut command = Command::new(env!("CARGO_BIN_EXE_etalon"));
        // The memory is limited: a refusal needs little.
        let output =
            limited(&mut command).current_dir(self.path()).args(arguments).output().expect("it runs");
        let error = String::from_utf8_lossy(&output.stderr);
        let scene = fs::read_to_string(self.path().join("scene.xml")).unwrap_or_default();
        let scene: String = scene.chars().take(2000).collect();
        let context = format!("{arguments:?}\n{scene}\n--- exit {:?}\n{error}", output.status.code());
        assert_eq!(output.status.code(), Some(2), "{context}");
        assert!(output.stdout.is_empty(), "something on standard output: {context}");
        let errors = error.lines().filter(|line| line.starts_with("error")).count();
        assert_eq!(errors, 1, "not one error: {context}");
        assert!(error.len() < 4000, "an error of {} bytes: {context:.3000}", error.len());
        for word in words {
            assert!(error.contains(word), "no `{word}`: {context}");
        }
        assert_eq!(before, self.list(), "the folder has changed: {context}");
    }

    fn list(&self) -> Vec<(String, Option<Vec<u8>>)> {
        let entries = fs::read_dir(self.path()).expect("listed").map(|e| e.expect("an entry").path());
        let mut list: Vec<_> = entries.map(|p| (p.display().to_string(), fs::read(&p).ok())).collect();
        list.sort();
        list
    }
}

#[cfg(target_os = "linux")]
fn limited(command: &mut Command) -> Command {
    let mut shell = Command::new("sh");
    shell.arg("-c").arg("ulimit -v 2000000; exec \"$0\" \"$@\"").arg(command.get_program());
    shell
}

#[cfg(not(target_os = "linux"))]
fn limited(command: &mut Command) -> Command {
    Command::new(command.get_program())
}

/// A scene with the small film and this body.
fn scene(body: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{SENSOR}\n{body}\n</scene>\n")
}

/// Asserts that a scene is refused with an error that points at the first line that contains `place` and
/// shows it.
fn refused(scene: &str, place: &str, words: &[&str]) {
    let line = scene.lines().position(|line| line.contains(place)).unwrap_or(0) + 1;
    let at = format!("scene.xml:{line}:");
    Folder::new(scene.as_bytes()).refused(&[words, &[at.as_str(), place]].concat());
}

/// `(where, body, words)`: a scene with this body is refused with a message that points at the line of
/// `where` and contains all the words.
type Trial<'a> = (&'a str, &'a str, &'a [&'a str]);

fn all_refused(trials: &[Trial]) {
    for (place, body, words) in trials {
        refused(&scene(body), place, words);
    }
}

/// Asserts that a scene with other files beside it is refused.
fn refused_with(scene: &str, files: &[(&str, &[u8])], words: &[&str]) {
    let folder = Folder::new(scene.as_bytes());
    for (name, content) in files {
        fs::write(folder.path().join(name), content).expect("written");
    }
    folder.refused(words);
}
