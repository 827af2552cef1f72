//! The header of a PLY file: lines of text that name the elements, their counts and their properties.

use super::super::MeshError;
use crate::spelling::shortened;

/// How the body stores its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of one stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" | "int64" => Self::I64,
            "ulong" | "uint64" => Self::U64,
            "half" | "float16" => Self::F16,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one number in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }
}

/// One named number of a record, or one named list of numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the number, or of a list's items.
    pub(super) kind: Scalar,
    /// The type of a list's length, for a list.
    pub(super) length: Option<Scalar>,
}

/// One table of the body: `count` records with the same properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The byte where the body begins.
    pub(super) end: usize,
}

/// Reads the header that `bytes` begin with.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, MeshError> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    let mut first = true;
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let begin = at;
        at += line.len();
        let fail = |message: String| MeshError::line(bytes, begin, message);
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_whitespace().collect();
        if std::mem::take(&mut first) {
            if words != ["ply"] {
                return Err(fail("a PLY file begins with a line `ply`".into()));
            }
            continue;
        }
        match words.as_slice() {
            [] | ["comment", ..] | ["obj_info", ..] => {}
            ["format", name, "1.0"] if encoding.is_none() => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(fail(format!("unknown format `{name}`"))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| fail(format!("`{count}` is not a count")))?;
                if elements.iter().any(|element| element.name == *name) {
                    return Err(fail(format!("a second element `{name}`")));
                }
                elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
            }
            ["property", rest @ ..] => {
                let element =
                    elements.last_mut().ok_or_else(|| fail("a property before any element".into()))?;
                element.properties.push(property(rest).map_err(fail)?);
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| fail("the header has no `format` line".into()))?;
                return Ok(Header { encoding, elements, end: at });
            }
            _ => {
                return Err(fail(format!(
                    "`{}` does not belong in a PLY 1.0 header",
                    shortened(text.trim_end())
                )));
            }
        }
    }
    Err(MeshError::line(bytes, at, "the header has no `end_header` line"))
}

fn property(words: &[&str]) -> Result<Property, String> {
    let scalar = |name: &str| Scalar::from_name(name).ok_or_else(|| format!("unknown number type `{name}`"));
    match words {
        ["list", length, kind, name] => {
            let length = scalar(length)?;
            if length.is_float() {
                return Err("the length of a list must be an integer".into());
            }
            Ok(Property { name: (*name).into(), kind: scalar(kind)?, length: Some(length) })
        }
        [kind, name] => Ok(Property { name: (*name).into(), kind: scalar(kind)?, length: None }),
        _ => Err("a property reads `property TYPE NAME` or `property list TYPE TYPE NAME`".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::{super::super::Place, *};

    #[test]
    fn names_types_and_the_end_are_read() {
        let text = b"ply\r\nformat binary_big_endian 1.0\ncomment \xff\nobj_info x\nelement face 3\n\
            property list uchar int vertex_index\nproperty double w\nend_header\n\x00";
        let header = parse(text).unwrap();
        assert_eq!(header.encoding, Encoding::BigEndian);
        assert_eq!(header.end, text.len() - 1);
        let properties = [("vertex_index", Scalar::I32, Some(Scalar::U8)), ("w", Scalar::F64, None)]
            .map(|(name, kind, length)| Property { name: name.into(), kind, length });
        let element = Element { name: "face".into(), count: 3, properties: properties.into() };
        assert_eq!(header.elements, [element]);
    }

    #[test]
    fn each_fault_names_its_line() {
        for (text, line) in [
            ("", 1),
            ("plx\n", 1),
            ("ply\nformat ascii 2.0\n", 2),
            ("ply\nformat utf8 1.0\n", 2),
            ("ply\nformat ascii 1.0\nproperty float x\n", 3),
            ("ply\nformat ascii 1.0\nelement vertex -1\n", 3),
            ("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", 4),
            ("ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n", 4),
            ("ply\nelement vertex 1\nelement vertex 1\n", 3),
            ("ply\nend_header\n", 2),
        ] {
            assert_eq!(parse(text.as_bytes()).unwrap_err().place, Place::Line(line), "{text:?}");
        }
    }
}
