//! Reading of files, and places in their text.

use std::path::{Path, PathBuf};

/// The bytes of a file. A device or pipe may have no end, and is no file.
pub fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(std::io::Error::other(if metadata.is_dir() {
            "it is a folder"
        } else {
            "it is no regular file"
        }));
    }
    std::fs::read(path)
}

/// The text of a file in UTF-8, or why there is none.
pub fn read_utf8(path: &Path) -> Result<String, String> {
    let bytes = read_file(path).map_err(|e| e.to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}

/// The first of `folders` that has `name`.
pub fn find(folders: &[PathBuf], name: &str) -> Option<PathBuf> {
    folders.iter().map(|folder| folder.join(name)).find(|path| path.exists())
}

/// Says where a file was looked for that is not there: in which of `folders`, each once.
pub fn looked_in<'a>(folders: impl Iterator<Item = &'a PathBuf>) -> String {
    let mut looked: Vec<String> = vec![];
    for folder in folders {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let folder = format!("`{}`", folder.display());
        if !looked.contains(&folder) {
            looked.push(folder);
        }
    }
    format!("looked in {}", looked.join(", "))
}

/// The bytes of a node's start tag.
pub fn start_tag(node: roxmltree::Node) -> std::ops::Range<usize> {
    let range = node.range();
    let text = &node.document().input_text()[range.clone()];
    let end = node.attributes().next_back().map_or(0, |a| a.range().end - range.start);
    range.start..range.start + end + text[end..].find('>').map_or(0, |i| i + 1)
}

/// The byte range of one character at a line and column (both from 1).
pub fn offset(text: &str, position: roxmltree::TextPos) -> std::ops::Range<usize> {
    let mut start = 0;
    for _ in 1..position.row {
        start += text[start..].find('\n').map_or(text.len() - start, |i| i + 1);
    }
    let column = (position.col as usize).saturating_sub(1);
    start += text[start..].char_indices().nth(column).map_or(text.len() - start, |(i, _)| i);
    start..(start + text[start..].chars().next().map_or(0, char::len_utf8))
}
