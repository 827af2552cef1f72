//! Bytes of scene files as text: UTF-8, UTF-16 if they begin as it does, or Latin-1 if the file says so.

use super::error::{SceneError, Source, Span};
use std::path::Path;
use std::sync::Arc;

/// U+FEFF, which some programs write first, to say that and how a file is Unicode.
pub const MARK: &str = "\u{feff}";

/// The text of a file; an error if bytes are neither UTF-8 nor UTF-16 and the file does not declare them to be Latin-1.
pub fn decode(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    if let Some(unit) = utf_16(&bytes) {
        let units: Vec<u16> = bytes.as_chunks().0.iter().map(|pair| unit(*pair)).collect();
        let whole = bytes.len().is_multiple_of(2);
        return String::from_utf16(&units).ok().filter(|_| whole).ok_or_else(|| {
            SceneError::nowhere(format!("{} begins as UTF-16 and is none; expected UTF-8", path.display()))
        });
    }
    if !bytes.starts_with(MARK.as_bytes()) && declares_latin_1(&bytes) {
        return Ok(bytes.into_iter().map(char::from).collect());
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.into_bytes();
        let message = format!("the byte {:#04x} is no UTF-8", bytes[valid]);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let source = Arc::new(Source { path: path.to_owned(), text });
        let expected = "expected UTF-8, or <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?> in the first line";
        let range = valid..valid + char::REPLACEMENT_CHARACTER.len_utf8();
        SceneError::at(&Span { source, range }, message, expected)
    })
}

/// How two bytes are a unit of UTF-16, if a file begins with U+FEFF or `<` in it.
fn utf_16(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, b'<', ..] => Some(u16::from_be_bytes),
        _ => None,
    }
}

fn declares_latin_1(bytes: &[u8]) -> bool {
    let bytes = bytes.trim_ascii_start();
    if !bytes.get(..5).is_some_and(|first| first.eq_ignore_ascii_case(b"<?xml")) {
        return false;
    }
    let end = bytes.windows(2).position(|pair| pair == b"?>").unwrap_or(0);
    let declaration = String::from_utf8_lossy(&bytes[..end]).to_ascii_lowercase();
    ["iso-8859-1", "latin1", "latin-1"].iter().any(|name| declaration.contains(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latin_1_is_read_where_it_is_declared_and_refused_with_its_place_elsewhere() {
        let body = b"\n<scene><!-- caf\xe9 --></scene>";
        let declared = [b"<?xml version='1.0' encoding='ISO-8859-1'?>".as_slice(), body].concat();
        assert!(decode(Path::new("a.xml"), declared).unwrap().contains("café"));
        let late = b"\n <?xml version='1.0' encoding='latin1'?><!-- \xe9 -->".to_vec();
        assert!(decode(Path::new("a.xml"), late).unwrap().contains('é'));
        // Bytes that would be UTF-8 as well.
        let twice = b"<?xml version='1.0' encoding='latin1'?><!-- caf\xc3\xa9 -->".to_vec();
        assert!(decode(Path::new("a.xml"), twice).unwrap().contains("cafÃ©"));
        let error =
            decode(Path::new("a.xml"), [b"<?xml version='1.0'?>".as_slice(), body].concat()).unwrap_err();
        assert_eq!(error.line_column(), Some((2, 16)));
        assert!(error.message.contains("0xe9"), "{}", error.message);
        assert_eq!(decode(Path::new("a.xml"), "<é/>".into()).unwrap(), "<é/>");
    }

    #[test]
    fn utf_16_is_read_either_way_and_a_mark_decides() {
        let text = "<scene é='𝄞'/>";
        let encoded = |text: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        for text in [text.to_owned(), format!("{MARK}{text}")] {
            for bytes in
                [encoded(&text, u16::to_le_bytes), encoded(&text, u16::to_be_bytes), text.clone().into()]
            {
                assert_eq!(decode(Path::new("a.xml"), bytes).unwrap(), text);
            }
        }
        let declared = format!("{MARK}<?xml version='1.0' encoding='ISO-8859-1'?><a id='café'/>");
        assert_eq!(decode(Path::new("a.xml"), declared.clone().into()).unwrap(), declared);
        let mut cut = encoded(text, u16::to_le_bytes);
        cut.pop();
        assert!(decode(Path::new("a.xml"), cut).unwrap_err().message.contains("UTF-16"));
    }
}
