//! The scratch copy of the sources, and how bugs are planted in it.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An expression and its replacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    pub name: String,
    pub about: String,
    pub source: String,
    /// The source file, relative to the root of the repository.
    pub file: String,
    /// The chapter of the catalogue, which may be part of the names of tests; `None` for mutants.
    pub chapter: Option<String>,
    /// Byte range of the expression.
    pub range: Range<usize>,
    /// The wrong expression.
    pub replace: String,
}

impl Change {
    fn meets(&self, other: &Change) -> bool {
        self.file == other.file && self.range.start < other.range.end && other.range.start < self.range.end
    }
}

/// The place of a planted change: file, and byte range.
pub type Place = (String, Range<usize>);

/// The environment variable with the number of the active bug.
pub const VARIABLE: &str = "MUSEUM_BUG";

/// Code that is appended to the crate: reads the variable once and makes the choice.
const SWITCH: &str = r#"
pub mod museum_switch {
    static OUT: std::sync::LazyLock<u32> =
        std::sync::LazyLock::new(|| std::env::var("MUSEUM_BUG").ok().and_then(|v| v.parse().ok()).unwrap_or(0));

    #[inline(always)]
    pub fn on(bug: u32) -> bool {
        *OUT == bug
    }
}
"#;

/// Profile with which the crate under test compiles faster, and its tests are still fast enough; its
/// dependencies are compiled as usual.
const PROFILE: &str = "
[profile.release.package.etalon]
opt-level = 2
codegen-units = 16
debug = false
";

/// Divides changes into a set that can be planted together and the rest, which overlap it.
pub fn apart(changes: Vec<Change>) -> (Vec<Change>, Vec<Change>) {
    let (mut together, mut later): (Vec<Change>, Vec<Change>) = (vec![], vec![]);
    for change in changes {
        let list = if together.iter().any(|other| other.meets(&change)) { &mut later } else { &mut together };
        list.push(change);
    }
    (together, later)
}

/// The files below `root` that git tracks, and new ones that it does not ignore.
pub fn known_to_git(root: &Path) -> Result<Vec<String>, String> {
    let output = Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("git: {e}"))?;
    if !output.status.success() {
        return Err(format!("git: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let names = output.stdout.split(|byte| *byte == 0).filter(|name| !name.is_empty());
    Ok(names.map(|name| String::from_utf8_lossy(name).into_owned()).collect())
}

/// Copies the files `names` that exist. Byte positions in `to` stay valid whatever happens to `from`
/// afterwards.
pub fn copy(from: &Path, names: &[String], to: &Path) -> Result<(), String> {
    let mut kept = BTreeSet::new();
    for name in names.iter().filter(|name| from.join(name).is_file()) {
        write_if_new(&to.join(name), &read(&from.join(name))?)?;
        kept.insert(to.join(name));
    }
    forget(to, &kept)
}

/// Makes `to` a copy of `sources`, a folder that [`copy`] has made, with the changes planted; bug `i + 1` of
/// the variable is `changes[i]`. Returns the place of each. A file that equals that of an earlier `to` is not
/// written, so that cargo compiles only what differs.
pub fn plant(sources: &Path, to: &Path, changes: &[Change]) -> Result<Vec<Place>, String> {
    let mut places = vec![(String::new(), 0..0); changes.len()];
    let (mut paths, mut kept) = (vec![], BTreeSet::new());
    list(sources, &mut paths)?;
    for path in paths {
        let name = path.strip_prefix(sources).unwrap_or(&path).to_string_lossy().into_owned();
        let mut bytes = read(&path)?;
        let own: Vec<usize> = (0..changes.len()).filter(|&i| changes[i].file == name).collect();
        if !own.is_empty() {
            let text = String::from_utf8(bytes).map_err(|e| format!("{name}: {e}"))?;
            bytes = with_choices(&text, changes, own, &mut places).into_bytes();
        }
        bytes.extend_from_slice(match name.as_str() {
            "Cargo.toml" => PROFILE.as_bytes(),
            "src/lib.rs" => SWITCH.as_bytes(),
            _ => &[],
        });
        write_if_new(&to.join(&name), &bytes)?;
        kept.insert(to.join(&name));
    }
    forget(to, &kept)?;
    Ok(places)
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(told)? {
        let path = entry.map_err(told)?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

/// Removes files of an earlier copy that this one does not have; build products of tests stay.
fn forget(folder: &Path, kept: &BTreeSet<PathBuf>) -> Result<(), String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(told)? {
        let path = entry.map_err(told)?.path();
        if path.is_dir() && path.file_name().is_none_or(|name| name != "target") {
            forget(&path, kept)?;
        } else if path.is_file() && !kept.contains(&path) {
            std::fs::remove_file(&path).map_err(told)?;
        }
    }
    Ok(())
}

/// The text of a file with its `own` changes as choices.
fn with_choices(text: &str, changes: &[Change], mut own: Vec<usize>, places: &mut [Place]) -> String {
    own.sort_by_key(|&i| changes[i].range.start);
    let (mut changed, mut done) = (String::new(), 0);
    for i in own {
        let Change { range, replace, file, .. } = &changes[i];
        changed.push_str(&text[done..range.start]);
        let start = changed.len();
        let (number, right) = (i + 1, &text[range.clone()]);
        changed
            .push_str(&format!("(if crate::museum_switch::on({number}) {{ {replace} }} else {{ {right} }})"));
        places[i] = (file.to_owned(), start..changed.len());
        done = range.end;
    }
    changed + &text[done..]
}

fn write_if_new(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let told = |e: std::io::Error| format!("{}: {e}", path.display());
    if std::fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(told)?;
    }
    std::fs::write(path, bytes).map_err(told)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(name: &str, range: Range<usize>) -> Change {
        let (about, source) = (String::new(), String::new());
        let (file, replace) = ("a.rs".into(), "2".into());
        Change { name: name.into(), about, source, file, chapter: None, range, replace }
    }

    #[test]
    fn overlapping_changes_are_kept_apart() {
        let all = vec![change("a", 0..4), change("b", 2..6), change("c", 4..8)];
        let (together, later) = apart(all);
        let names = |list: &[Change]| list.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        assert_eq!((names(&together), names(&later)), (vec!["a".into(), "c".into()], vec!["b".into()]));
    }

    #[test]
    fn files_that_are_gone_do_not_stay_in_the_copy() {
        let folder = std::env::temp_dir().join(format!("etalon-plant-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("a/target")).unwrap();
        for name in ["a/kept.rs", "a/gone.rs", "a/target/built"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        forget(&folder, &BTreeSet::from([folder.join("a/kept.rs")])).unwrap();
        let exists = |name: &str| folder.join(name).exists();
        assert!(exists("a/kept.rs") && !exists("a/gone.rs") && exists("a/target/built"));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn editing_the_sources_meanwhile_does_not_move_the_changes() {
        let folder = std::env::temp_dir().join(format!("etalon-edited-{}", std::process::id()));
        let (original, sources, tree) =
            (folder.join("original"), folder.join("sources"), folder.join("tree"));
        std::fs::create_dir_all(&original).unwrap();
        std::fs::write(original.join("a.rs"), "f(λ, 1)").unwrap();
        copy(&original, &["a.rs".into(), "removed.rs".into()], &sources).unwrap();
        for earlier in ["", "// A line that someone adds between two builds.\n"] {
            std::fs::write(original.join("a.rs"), format!("{earlier}f(λ, 1)")).unwrap();
            plant(&sources, &tree, &[change("x", 6..7)]).unwrap();
            let planted = std::fs::read_to_string(tree.join("a.rs")).unwrap();
            assert_eq!(planted, "f(λ, (if crate::museum_switch::on(1) { 2 } else { 1 }))");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn expressions_become_choices() {
        let mut places = vec![(String::new(), 0..0); 2];
        let changes = [change("x", 5..6), change("y", 2..3)];
        let text = with_choices("f(1, 1)", &changes, vec![0, 1], &mut places);
        let choice = |n| format!("(if crate::museum_switch::on({n}) {{ 2 }} else {{ 1 }})");
        assert_eq!(text, format!("f({}, {})", choice(2), choice(1)));
        assert_eq!(&text[places[0].1.clone()], choice(1));
        assert!(SWITCH.contains(VARIABLE));
    }
}
