//! Escaping of text in HTML.

/// `text` escaped for elements and quoted attributes.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_letter_ends_an_element_or_an_attribute() {
        assert_eq!(escape("<a b='c' d=\"e\"> & λ"), "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt; &amp; λ");
    }
}
