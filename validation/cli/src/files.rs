//! Files that are read, and records that grow line by line; errors begin with the path.

use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// The text of a file.
pub fn text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// The content of a JSON document.
pub fn json<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    serde_json::from_str(&text(path)?).map_err(|e| format!("{}: {e}", path.display()))
}

/// The content of a TOML document.
pub fn toml<T: DeserializeOwned>(path: &Path) -> Result<T, String> {
    toml::from_str(&text(path)?).map_err(|e| format!("{}: {}", path.display(), e.to_string().trim_end()))
}

/// The lines of a file of JSON documents; one that an interruption has left unfinished is passed over. Error: a line
/// that is none of `what`, with its number.
pub fn lines<T: DeserializeOwned>(path: &Path, what: &str) -> Result<Vec<T>, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    // A torn line may end within a character, so it is no text.
    let is_torn = |line: &[u8]| serde_json::from_slice::<Value>(line).is_err_and(|error| error.is_eof());
    let whole = bytes.split(|&byte| byte == b'\n').enumerate().filter(|(_, line)| !is_torn(line));
    let wrong = |number: usize| format!("{}:{}: expected {what}", path.display(), number + 1);
    whole.map(|(i, line)| serde_json::from_slice(line).map_err(|_| wrong(i))).collect()
}

/// Appends lines to a file, on a new line if an interruption has left an unfinished one.
pub fn append(path: &Path, lines: &str) -> Result<(), String> {
    let append = || -> io::Result<()> {
        let mut file = File::options().create(true).read(true).append(true).open(path)?;
        let mut last = [b'\n'];
        if file.metadata()?.len() > 0 {
            file.seek(SeekFrom::End(-1))?;
            file.read_exact(&mut last)?;
        }
        let whole = if last == [b'\n'] { "" } else { "\n" };
        file.write_all(format!("{whole}{lines}\n").as_bytes())
    };
    append().map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_but_for_torn_ones() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.jsonl");
        let read = || lines::<String>(&path, "a word");
        assert!(read().is_err_and(|error| error.contains("x.jsonl")));
        std::fs::write(&path, "\"one\"\n\"χ\"\n\"torn\n\"three\"\n").unwrap();
        assert_eq!(read(), Ok(["one", "χ", "three"].map(String::from).to_vec()));
        for end in 1..=5 {
            std::fs::write(&path, [b"\"one\"\n".as_slice(), &"\"χ²".as_bytes()[..end]].concat()).unwrap();
            assert_eq!(read(), Ok(vec!["one".to_owned()]), "{end}");
        }
        std::fs::write(&path, "\"one\"\n2\n").unwrap();
        assert!(read().unwrap_err().ends_with("x.jsonl:2: expected a word"));
    }

    #[test]
    fn a_torn_line_takes_no_other_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.jsonl");
        append(&path, "one").unwrap();
        std::fs::write(&path, "one\ntw").unwrap();
        append(&path, "two").unwrap();
        append(&path, "three").unwrap();
        assert_eq!(text(&path).unwrap(), "one\ntw\ntwo\nthree\n");
    }

    #[test]
    fn errors_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        let missing = json::<u32>(&path).unwrap_err();
        std::fs::write(&path, "[1").unwrap();
        let faulty = [json::<u32>(&path).unwrap_err(), toml::<u32>(&path).unwrap_err()];
        std::fs::write(&path, "7").unwrap();
        assert_eq!(json(&path), Ok(7));
        let begin = format!("{}: ", path.display());
        assert!([missing].iter().chain(&faulty).all(|error| error.starts_with(&begin)), "{faulty:?}");
    }
}
