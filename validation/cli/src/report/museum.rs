//! The bug museum's latest results, if there are some.

use serde_json::Value;
use std::path::{Path, PathBuf};

/// A bug and what became of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bug {
    pub name: String,
    pub about: String,
    pub source: String,
    /// The test that noticed, if one did.
    pub killed_by: Option<String>,
}

/// A run of the museum.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Date, machine and commit.
    pub made: String,
    pub bugs: Vec<Bug>,
}

/// Where the results are.
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../museum/results.json")
}

/// The results, `None` if there is no such file.
pub fn read(path: &Path) -> Result<Option<Findings>, String> {
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(None) };
    let document: Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let bug = |value: &Value| {
        let killed = &value["fate"]["killed"];
        let [name, about, source] = ["name", "about", "source"].map(|key| text(&value[key]));
        Bug { name, about, source, killed_by: killed["test"].as_str().map(String::from) }
    };
    let made = ["date", "machine", "commit"].map(|key| text(&document[key])).join(" · ");
    let bugs = document["bugs"].as_array().into_iter().flatten().map(bug).collect();
    Ok(Some(Findings { made, bugs }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fates_are_read() {
        let path = std::env::temp_dir().join(format!("etalon-museum-{}.json", std::process::id()));
        let bugs = r#"[{"name":"a","about":"b","source":"c","fate":{"killed":{"program":"p","test":"t","seconds":1.0}}},
                       {"name":"d","about":"e","source":"f","fate":"survived"}]"#;
        let text = format!(r#"{{"date":"2026-01-01","machine":"m","commit":"abc","bugs":{bugs}}}"#);
        std::fs::write(&path, text).unwrap();
        let findings = read(&path).unwrap().unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(findings.made, "2026-01-01 · m · abc");
        let killed: Vec<Option<&str>> = findings.bugs.iter().map(|bug| bug.killed_by.as_deref()).collect();
        assert_eq!(killed, [Some("t"), None]);
        assert_eq!(read(&path), Ok(None));
    }
}
