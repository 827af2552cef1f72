//! Makes what Mitsuba's parser ignores and ours refuses harmless, byte for byte, so that all places stay what
//! they are in the file.

use std::ops::Range;

/// The same text with blanks for the hyphens within comments, of which XML allows no two in a row, and
/// another word for the `xml` of a declaration that is not the very first thing. The error is the place where
/// a comment begins that does not end.
pub fn forgive(text: &str) -> Result<String, Range<usize>> {
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    let mut before_root = true;
    while let Some(begin) = rest.find('<') {
        result.push_str(&rest[..begin]);
        let (piece, after) = rest[begin..].split_at(length(&rest[begin..]));
        rest = after;
        let first = result.is_empty();
        if let Some(comment) = piece.strip_prefix("<!--") {
            let start = result.len();
            let body = comment.strip_suffix("-->").ok_or(start..start + "<!--".len())?;
            result.push_str("<!--");
            result.push_str(&body.replace('-', " "));
            result.push_str("-->");
        } else if let Some(declaration) = piece.strip_prefix("<?xml ").filter(|_| before_root && !first) {
            result.push_str("<?_ml ");
            result.push_str(declaration);
        } else {
            result.push_str(piece);
            before_root &= piece.starts_with("<!") || piece.starts_with("<?");
        }
    }
    result.push_str(rest);
    Ok(result)
}

/// The length of the comment, instruction or tag that a text begins with: all of it if there is no end.
fn length(markup: &str) -> usize {
    let until = |end: &str, from: usize| {
        let found = markup[from..].find(end);
        found.map_or(markup.len(), |i| from + i + end.len())
    };
    if markup.starts_with("<!--") {
        until("-->", 4)
    } else if markup.starts_with("<![CDATA[") {
        until("]]>", 9)
    } else if markup.starts_with("<?") {
        until("?>", 2)
    } else {
        tag(markup)
    }
}

/// The length of a tag: up to the first `>` that is not within quotation marks.
fn tag(markup: &str) -> usize {
    let mut quoted = None;
    for (i, byte) in markup.bytes().enumerate() {
        match quoted {
            Some(mark) if mark == byte => quoted = None,
            Some(_) => {}
            None if byte == b'>' => return i + 1,
            None if byte == b'"' || byte == b'\'' => quoted = Some(byte),
            None => {}
        }
    }
    markup.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hyphens_within_comments_become_blanks_and_all_else_stays() {
        for (text, expected) in [
            ("<a><!-- ---- é --><!----><!-----></a>", "<a><!--      é --><!----><!-- --></a>"),
            ("<!-- a -- b\n--->\n<a-b/>", "<!-- a    b\n -->\n<a-b/>"),
            ("<a b='<!-- -- -->'/><!-- -- -->", "<a b='<!-- -- -->'/><!--    -->"),
            ("<a b=\"'>\" c='\"'/><!-- -- -->", "<a b=\"'>\" c='\"'/><!--    -->"),
            ("<a><![CDATA[<!-- -- ]]><b c=\"--\"/></a>", "<a><![CDATA[<!-- -- ]]><b c=\"--\"/></a>"),
            ("<a><?b <!-- -- ?><c d='--'/></a>", "<a><?b <!-- -- ?><c d='--'/></a>"),
            ("no markup -- at all", "no markup -- at all"),
            ("<a b='--", "<a b='--"),
        ] {
            let forgiven = forgive(text).unwrap();
            assert_eq!(forgiven, expected);
            assert_eq!(forgiven.len(), text.len());
        }
        for unfinished in ["<!-- a", "<!-->", "<!--->", "<!-- -- >"] {
            assert_eq!(forgive(&format!("<a>é{unfinished}")), Err(5..9), "{unfinished}");
        }
    }

    #[test]
    fn a_declaration_may_come_after_blanks_and_comments() {
        let declaration = "<?xml version=\"1.0\"?><a/>";
        assert_eq!(forgive(declaration).as_deref(), Ok(declaration));
        for before in [" \r\n\t", "<!-- a -->\n"] {
            let text = format!("{before}{declaration}");
            assert_eq!(forgive(&text), Ok(text.replace("<?xml", "<?_ml")));
        }
        let within = format!("<b>{declaration}</b>");
        assert_eq!(forgive(&within), Ok(within));
    }
}
