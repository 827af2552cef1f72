//! Any renderer, by a command template of `validation/renderers.toml`.

mod render;
mod said;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use etalon::spectrum::ColorMode;
pub use render::{Job, Rendered, Took, read};
use serde::Deserialize;

/// An entry of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Renderer {
    /// Program and arguments, with placeholders in braces.
    pub command: String,
    /// Another renderer whose pictures have the same mean, and whose converged mean is therefore the
    /// reference of this one, which may not converge in any feasible time. By default its own converged mean
    /// is the reference.
    pub mean_of: Option<String>,
    /// Whether it carries spectra or three channels: the same scene has another mean in each.
    pub color: Option<ColorMode>,
}

/// The committed file.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("renderers.toml")
}

/// All renderers of a file, by name.
pub type Renderers = BTreeMap<String, Renderer>;

/// Reads a file of renderers.
pub fn load(path: &Path) -> Result<Renderers, String> {
    let all: Renderers = crate::files::toml(path)?;
    let unknown = |renderer: &Renderer| renderer.mean_of.clone().filter(|name| !all.contains_key(name));
    // Files are named after renderers.
    let is_part_of_names = |c: char| c.is_alphanumeric() || "-_+.".contains(c);
    let fault = |name: &str, renderer: &Renderer| match unknown(renderer) {
        _ if name.starts_with('.') || name.is_empty() || !name.chars().all(is_part_of_names) => {
            Some("no name for files, expected letters, digits, and - _ + . within".to_owned())
        }
        Some(unknown) => Some(format!("there is no renderer {unknown:?}")),
        None => fault_of(&renderer.command),
    };
    match all.iter().find_map(|(name, renderer)| Some((name, fault(name, renderer)?))) {
        Some((name, fault)) => Err(format!("{}: {name}: {fault}", path.display())),
        None => Ok(all),
    }
}

/// What is wrong with the placeholders of a command: one that has no meaning would be handed on as it
/// stands, and a misspelt seed would be the same for every picture. A shell's variables have a `$` before them.
fn fault_of(command: &str) -> Option<String> {
    let braces = command.match_indices('{').filter(|(at, _)| !command[..*at].ends_with('$'));
    let names = braces.filter_map(|(at, _)| Some(command[at + 1..].split_once('}')?.0));
    let is_name = |name: &&str| name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    let unknown = names.filter(is_name).find(|name| !PLACEHOLDERS.contains(name));
    if let Some(unknown) = unknown {
        return Some(format!(
            "{{{unknown}}} is no placeholder, expected one of {{{}}} or {{env:NAME:default}}",
            PLACEHOLDERS.join("}, {")
        ));
    }
    (!command.contains("{out}")).then(|| "its command has no {out}, the file to write".into())
}

/// What may stand in braces in a command, besides `env:NAME:default`; [`fill`] has the values.
const PLACEHOLDERS: [&str; 6] = ["scene", "out", "spp", "seed", "threads", "peers"];

/// The renderer whose converged mean is the reference of `name`.
pub fn mean_of<'a>(all: &'a Renderers, name: &'a str) -> &'a str {
    all.get(name).and_then(|renderer| renderer.mean_of.as_deref()).unwrap_or(name)
}

/// Replaces `{env:NAME:default}` by the value of the environment variable `NAME`.
fn from_environment(command: &str) -> Result<String, String> {
    let mut parts = command.split("{env:");
    let mut filled = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (inside, rest) = part.split_once('}').ok_or("a brace of the command is not closed")?;
        let (name, default) = inside.split_once(':').map_or((inside, None), |(name, by)| (name, Some(by)));
        let value = std::env::var(name).ok().or_else(|| default.map(str::to_owned));
        filled += &value.ok_or_else(|| format!("the variable {name} is not set, and has no default"))?;
        filled += rest;
    }
    Ok(filled)
}

fn fill(word: &str, job: &Job, out: &Path) -> String {
    let peers = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers");
    let path = |path: &Path| path.to_string_lossy().into_owned();
    let [samples, seed] = [job.samples, job.seed].map(|n| n.to_string());
    let values = [path(job.scene), path(out), samples, seed, job.threads.to_string(), path(&peers)];
    // From left to right, so that a value in braces stays as it is.
    let (mut filled, mut rest) = (String::new(), word);
    while let Some((before, after)) = rest.split_once('{') {
        filled += before;
        let inside = after.split_once('}');
        let place = inside.and_then(|(name, _)| PLACEHOLDERS.iter().position(|known| *known == name));
        match (place, inside) {
            (Some(place), Some((_, beyond))) => {
                filled += &values[place];
                rest = beyond;
            }
            _ => {
                filled.push('{');
                rest = after;
            }
        }
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_file_is_read() {
        let all = load(&file()).unwrap();
        assert_eq!(all.keys().filter(|name| name.starts_with("mitsuba-")).count(), 12);
        assert!(
            all.values()
                .all(|r| ["{scene}", "{out}", "{spp}", "{seed}"].iter().all(|w| r.command.contains(w)))
        );
    }

    #[test]
    fn means_of_others_are_those_of_known_renderers() {
        let file = std::env::temp_dir().join(format!("etalon-renderers-{}.toml", std::process::id()));
        let read =
            |text: &str| std::fs::write(&file, text).map_err(|e| e.to_string()).and_then(|()| load(&file));
        let all = read("[a]\ncommand = \"x {out}\"\nmean_of = \"b\"\n[b]\ncommand = \"y {out}\"").unwrap();
        assert_eq!(["a", "b", "c"].map(|name| mean_of(&all, name)), ["b", "b", "c"]);
        let refused = read("[a]\ncommand = \"x\"\nmean_of = \"b\"").unwrap_err();
        assert!(refused.ends_with("a: there is no renderer \"b\""), "{refused}");
        for (command, fault) in [
            ("x {out} {sed}", "{sed} is no placeholder, expected one of {scene}, {out}"),
            ("x {out} {SEED}", "{SEED} is no placeholder"),
            ("x {out} {seed2}", "{seed2} is no placeholder"),
            ("x {seed} > {env:OUT:y}", "no {out}"),
        ] {
            let refused = read(&format!("[a]\ncommand = \"{command}\"")).unwrap_err();
            assert!(refused.contains(fault), "{refused}");
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn the_environment_fills_in() {
        assert_eq!(from_environment("{env:ETALON_NO_SUCH:python3} x").unwrap(), "python3 x");
        assert_eq!(
            from_environment("a {env:CARGO_PKG_NAME:b} c").unwrap(),
            format!("a {} c", env!("CARGO_PKG_NAME"))
        );
        assert!(from_environment("{env:open").is_err());
        assert!(
            from_environment("{env:ETALON_NO_SUCH} x").unwrap_err().contains("ETALON_NO_SUCH is not set")
        );
        assert_eq!(from_environment("{env:ETALON_NO_SUCH:}x").unwrap(), "x");
    }
}
