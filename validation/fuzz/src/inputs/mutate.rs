//! Mutations: from valid files to almost valid ones.

use crate::draw::Draw;
use flate2::Compression;
use flate2::read::{ZlibDecoder, ZlibEncoder};
use std::io::Read;

/// Changes a file once; the second argument is another seed file, a source of pieces to insert.
pub type Mutate = fn(Vec<u8>, &[u8], &mut Draw) -> Vec<u8>;

/// Largest size of an input in bytes.
pub const LONGEST: usize = 1 << 18;

/// Numbers that readers tend to mishandle, as text.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "1e308",
    "-1e308",
    "1e-320",
    "1e39",
    "nan",
    "inf",
    "-inf",
    "255",
    "256",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "99999999999999999999999",
    "0x10",
    "1.5.2",
    "+",
    "",
    "1e",
    "1e999999999",
    "\u{e9}",
];

/// Numbers that readers tend to mishandle, in binary.
const INTEGERS: &[u64] = &[
    0,
    1,
    2,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x10000,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
    0x7f80_0000,
    0x7fc0_0000,
    0x0000_0001_0000,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
];

/// Mutates binary data: bits, bytes, numbers, pieces.
pub fn bytes(mut data: Vec<u8>, other: &[u8], draw: &mut Draw) -> Vec<u8> {
    if data.is_empty() {
        return other.to_vec();
    }
    // Headers are short and decide most of what a reader does, so half of the mutations go there.
    let reach = if draw.chance(0.5) { data.len().min(600) } else { data.len() };
    let at = draw.below(reach);
    match draw.below(8) {
        0 => data[at] ^= 1 << draw.below(8),
        1 => data[at] = draw.byte(),
        2 | 3 => {
            let (width, value) = (*draw.of(&[1, 2, 4, 8]), *draw.of(INTEGERS));
            let (little, big) = (value.to_le_bytes(), value.to_be_bytes());
            let number = if draw.chance(0.7) { &little[..width] } else { &big[8 - width..] };
            data[at..].iter_mut().zip(number).for_each(|(old, new)| *old = *new);
        }
        4 => data.truncate(at),
        5 => drop(data.drain(at..(at + draw.few(64)).min(data.len()))),
        6 => {
            let piece = piece(&data, draw);
            data.splice(at..at, piece);
        }
        _ => {
            let piece = piece(other, draw);
            let end = if draw.chance(0.5) { at } else { (at + piece.len()).min(data.len()) };
            data.splice(at..end, piece);
        }
    }
    data
}

/// Mutates text: words, numbers and lines.
pub fn words(data: Vec<u8>, other: &[u8], draw: &mut Draw) -> Vec<u8> {
    if draw.chance(0.05) {
        return bytes(data, other, draw);
    }
    let mut tokens = tokens(&data);
    if tokens.is_empty() {
        return other.to_vec();
    }
    let at = draw.below(tokens.len());
    let number = |token: &[u8]| token.first().is_some_and(|c| c.is_ascii_digit() || *c == b'-');
    match draw.below(7) {
        0 | 1 => {
            // The next number, if there is one.
            let at = (at..tokens.len()).find(|&i| number(tokens[i])).unwrap_or(at);
            tokens[at] = draw.of(NUMBERS).as_bytes();
        }
        2 => {
            let theirs = self::tokens(other);
            if !theirs.is_empty() {
                tokens[at] = *draw.of(&theirs);
            }
        }
        3 => tokens[at] = *draw.of(&tokens.clone()),
        4 => drop(tokens.drain(at..(at + draw.few(40)).min(tokens.len()))),
        5 => {
            let end = (at + draw.few(60)).min(tokens.len());
            let piece = tokens[at..end].repeat(draw.few(300));
            tokens.splice(at..at, piece);
        }
        _ => {
            let theirs = self::tokens(other);
            let from = draw.below(theirs.len());
            let to = (from + draw.few(80)).min(theirs.len());
            tokens.splice(at..at, theirs[from..to].iter().copied());
        }
    }
    tokens.concat()
}

/// Mutates a file whose header is text and whose body is binary.
pub fn headed(data: Vec<u8>, other: &[u8], draw: &mut Draw) -> Vec<u8> {
    const END: &[u8] = b"end_header\n";
    let end = data.windows(END.len()).position(|w| w == END).map_or(data.len(), |at| at + END.len());
    if draw.chance(0.5) {
        let body = data[end..].to_vec();
        let head = words(data[..end].to_vec(), other, draw);
        [head, body].concat()
    } else {
        let body = bytes(data[end..].to_vec(), other, draw);
        [data[..end].to_vec(), body].concat()
    }
}

/// Mutates a file of four header bytes and a deflated stream: the content is changed and deflated again, or
/// the compressed file itself is changed.
pub fn deflated(data: Vec<u8>, other: &[u8], draw: &mut Draw) -> Vec<u8> {
    let mut content = vec![];
    let whole =
        data.len() > 4 && ZlibDecoder::new(&data[4..]).take(LONGEST as u64).read_to_end(&mut content).is_ok();
    if !whole || draw.chance(0.3) {
        return bytes(data, other, draw);
    }
    let changed = bytes(content, other, draw);
    let mut packed = data[..4].to_vec();
    // Reading from memory does not fail.
    let _ = ZlibEncoder::new(changed.as_slice(), Compression::fast()).read_to_end(&mut packed);
    // The dictionary of a file of meshes is at its end.
    packed.extend(&data[data.len().saturating_sub(20)..]);
    packed
}

fn piece(data: &[u8], draw: &mut Draw) -> Vec<u8> {
    let from = draw.below(data.len());
    data[from..(from + draw.few(4096)).min(data.len())].to_vec()
}

/// Splits into runs of letters and digits, and single bytes between them.
fn tokens(data: &[u8]) -> Vec<&[u8]> {
    let word = |c: &u8| c.is_ascii_alphanumeric() || [b'_', b'.', b'-', b'+'].contains(c) || *c >= 128;
    data.chunk_by(|a, b| word(a) && word(b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_kept_together() {
        assert_eq!(tokens(b"a=\"-1.5e3\" />").concat(), b"a=\"-1.5e3\" />");
        assert!(tokens(b"v -1.5e3 2").contains(&b"-1.5e3".as_slice()));
    }

    #[test]
    fn a_deflated_stream_stays_one() {
        let mut file = vec![0x1c, 4, 4, 0];
        let _ = ZlibEncoder::new([7u8; 500].as_slice(), Compression::fast()).read_to_end(&mut file);
        let mut draw = Draw::named("deflated", 0);
        let whole = (0..200).filter(|_| {
            let mut content = vec![];
            let changed = deflated(file.clone(), &[1, 2, 3], &mut draw);
            changed.len() > 4 && ZlibDecoder::new(&changed[4..]).read_to_end(&mut content).is_ok()
        });
        assert!(whole.count() > 100);
    }
}
