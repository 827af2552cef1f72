//! Puts the attributes of an OpenEXR header in order.
//!
//! The crate `exr` keeps custom attributes in a hash map, so they reach the file in an order that changes
//! from run to run. The format gives the order no meaning (OpenEXR file layout, "Header"), and sorting the
//! attributes by name moves no byte behind the header, so the chunk offsets stay right.

/// Sorts the attributes of each header by name. `None` if the bytes are not an OpenEXR file.
pub(super) fn sort_attributes(file: &mut [u8]) -> Option<()> {
    const MULTIPART: u8 = 0x10;
    // Four bytes of magic number, then the version and three bytes of flags.
    let multipart = file.get(5)? & MULTIPART != 0;
    let mut start = 8;
    // A multipart file ends its list of headers with an empty one.
    while !multipart || *file.get(start)? != 0 {
        start = sort_header(file, start)?;
        if !multipart {
            break;
        }
    }
    Some(())
}

/// Sorts the header that begins at `start` and tells where it ends.
fn sort_header(file: &mut [u8], start: usize) -> Option<usize> {
    let mut attributes = Vec::new();
    let mut position = start;
    while *file.get(position)? != 0 {
        let end = attribute_end(file, position)?;
        attributes.push(file.get(position..end)?.to_vec());
        position = end;
    }
    // Names are distinct and end in a zero byte, so comparing whole attributes compares names.
    attributes.sort_unstable();
    file.get_mut(start..position)?.copy_from_slice(&attributes.concat());
    Some(position + 1)
}

/// An attribute is a name and a type, each with a zero byte behind it, the size of the value, and the value.
fn attribute_end(file: &[u8], start: usize) -> Option<usize> {
    let after_text = |start: usize| Some(start + file.get(start..)?.iter().position(|&byte| byte == 0)? + 1);
    let size_at = after_text(after_text(start)?)?;
    let size = u32::from_le_bytes(file.get(size_at..size_at + 4)?.try_into().ok()?);
    Some(size_at + 4 + size as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(flags: u8, headers: &[&[&str]], end: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, flags, 0, 0];
        for header in headers {
            for name in *header {
                bytes.extend(name.bytes().chain(*b"\0int\0\x04\0\0\0"));
                bytes.extend([0, name.len() as u8, 0, 7]);
            }
            bytes.push(0);
        }
        bytes.extend(end);
        bytes
    }

    #[test]
    fn single_part() {
        let mut bytes = file(0, &[&["b", "c", "a", "aa"]], b"pixels\0");
        assert_eq!(sort_attributes(&mut bytes), Some(()));
        assert_eq!(bytes, file(0, &[&["a", "aa", "b", "c"]], b"pixels\0"));
    }

    #[test]
    fn several_parts() {
        let mut bytes = file(0x10, &[&["b", "a"], &["z", "y", "x"]], b"\0pixels\0");
        assert_eq!(sort_attributes(&mut bytes), Some(()));
        assert_eq!(bytes, file(0x10, &[&["a", "b"], &["x", "y", "z"]], b"\0pixels\0"));
    }

    #[test]
    fn every_truncation_is_noticed() {
        let bytes = file(0x10, &[&["b", "a"], &["z", "y"]], b"\0");
        for length in 0..bytes.len() {
            assert_eq!(sort_attributes(&mut bytes[..length].to_vec()), None, "{length}");
        }
    }
}
