//! Files that are read; their errors begin with the path.

use serde::de::DeserializeOwned;
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
    toml::from_str(&text(path)?).map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

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
