//! Command lines that are printed, to be given to a shell.

use std::fmt;
use std::path::Path;

/// The words of a command line.
#[derive(Default)]
pub struct Words(Vec<String>);

impl Words {
    pub fn push(&mut self, word: impl Into<String>) {
        self.0.push(word.into());
    }

    /// Adds an option, if it has a value.
    pub fn option(&mut self, name: &str, value: Option<impl ToString>) {
        self.0.extend(value.into_iter().flat_map(|value| [name.to_owned(), value.to_string()]));
    }

    /// Adds an option without a value, if it is set.
    pub fn flag(&mut self, name: &str, set: bool) {
        self.0.extend(set.then(|| name.to_owned()));
    }

    /// These words before others.
    pub fn then(mut self, others: Words) -> Words {
        self.0.extend(others.0);
        self
    }
}

impl fmt::Display for Words {
    /// Quoted for a shell.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = |word: &str| {
            !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./=,:".contains(c))
        };
        for (i, word) in self.0.iter().enumerate() {
            let space = if i > 0 { " " } else { "" };
            if plain(word) {
                write!(formatter, "{space}{word}")?;
            } else {
                write!(formatter, "{space}'{}'", word.replace('\'', "'\\''"))?;
            }
        }
        Ok(())
    }
}

/// A path as an argument: one that begins like an option is none where it begins with its folder.
pub fn shown(path: &Path) -> String {
    match path.display().to_string() {
        name if name.starts_with('-') => format!("./{name}"),
        name => name,
    }
}
