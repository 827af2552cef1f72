//! Hints for words that are not known.

/// "known: a, b, c" for a word that is none of them, after "did you mean `a`?" if one is close.
pub fn known(word: &str, names: &[&str]) -> String {
    let near = names.iter().filter(|n| distance(word, n) <= 2).min_by_key(|n| distance(word, n));
    let list = if names.is_empty() { "none".into() } else { names.join(", ") };
    match near {
        Some(near) => format!("did you mean `{near}`? known: {list}"),
        None => format!("known: {list}"),
    }
}

/// The beginning of a text, as an error message can quote it even if it is a megabyte.
pub fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    match text.char_indices().nth(MOST) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

/// Levenshtein distance, for the spelling hint.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
