//! The numbers of a PLY body, one after the other, from text or from bytes.

use super::super::{MeshError, Place};
use super::header::{Element, Scalar};
use crate::spelling::shortened;

/// A body that is read from its beginning to its end.
pub(super) trait Values {
    /// The next number, which is stored as the float type `kind`.
    fn float(&mut self, kind: Scalar) -> Result<f32, MeshError>;
    /// The next number, which is stored as the integer type `kind`.
    fn integer(&mut self, kind: Scalar) -> Result<i64, MeshError>;
    /// The next numbers, which are stored as 32-bit floats.
    fn floats(&mut self, numbers: &mut [f32]) -> Result<(), MeshError> {
        numbers.iter_mut().try_for_each(|number| self.float(Scalar::F32).map(|next| *number = next))
    }
    /// Three 32-bit indices behind a one-byte length of 3, should these be what comes next and be within
    /// `limit`. It is the face that most files have, which so need not be taken apart number by number.
    fn triangle(&mut self, limit: u32) -> Option<[u32; 3]>;
    /// Passes over `count` numbers.
    fn skip(&mut self, kind: Scalar, count: u64) -> Result<(), MeshError>;
    /// The most records of `element` that what is left could hold, each list taken to be empty.
    fn room(&self, element: &Element) -> u64;
    /// The most numbers of type `kind` that what is left could hold.
    fn room_for(&self, kind: Scalar) -> u64;
    /// Whether all has been read.
    fn at_end(&self) -> bool;
    /// An error at the number that was read last.
    fn error(&self, message: String) -> MeshError;
}

/// A binary body. `BIG` is whether the most significant byte comes first.
pub(super) struct Binary<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
    previous: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub(super) fn new(bytes: &'a [u8], begin: usize) -> Self {
        Self { bytes, at: begin, previous: begin }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let Some(&taken) = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>()) else {
            return Err(self.ended());
        };
        self.previous = self.at;
        self.at += N;
        let mut bytes = taken;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }

    #[cold]
    fn ended(&self) -> MeshError {
        MeshError::new(Place::Byte(self.at as u64), "the file ends in the middle of its data")
    }

    fn left(&self) -> u64 {
        (self.bytes.len() - self.at) as u64
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    #[inline]
    fn float(&mut self, kind: Scalar) -> Result<f32, MeshError> {
        Ok(match kind {
            Scalar::F32 => f32::from_le_bytes(self.take()?),
            Scalar::F64 => f64::from_le_bytes(self.take()?) as f32,
            Scalar::F16 => half(u16::from_le_bytes(self.take()?)),
            integer => self.integer(integer)? as f32,
        })
    }

    #[inline]
    fn integer(&mut self, kind: Scalar) -> Result<i64, MeshError> {
        Ok(match kind {
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I64 => i64::from_le_bytes(self.take()?),
            // No count or index that a file could honour is past 2⁶³.
            Scalar::U64 => i64::try_from(u64::from_le_bytes(self.take()?)).unwrap_or(i64::MAX),
            float => self.float(float)? as i64,
        })
    }

    #[inline]
    fn floats(&mut self, numbers: &mut [f32]) -> Result<(), MeshError> {
        let Some(bytes) = self.bytes.get(self.at..).and_then(|rest| rest.get(..4 * numbers.len())) else {
            return Err(self.ended());
        };
        for (number, stored) in numbers.iter_mut().zip(bytes.as_chunks().0) {
            *number = if BIG { f32::from_be_bytes(*stored) } else { f32::from_le_bytes(*stored) };
        }
        self.previous = self.at;
        self.at += bytes.len();
        Ok(())
    }

    #[inline]
    fn triangle(&mut self, limit: u32) -> Option<[u32; 3]> {
        let [length, indices @ ..] = self.bytes.get(self.at..)?.first_chunk::<13>()?;
        let [a, b, c] = *indices.as_chunks().0 else { return None };
        let triangle = [a, b, c].map(if BIG { u32::from_be_bytes } else { u32::from_le_bytes });
        if *length != 3 || triangle.iter().any(|index| *index >= limit) {
            return None;
        }
        self.at += 13;
        Some(triangle)
    }

    fn skip(&mut self, kind: Scalar, count: u64) -> Result<(), MeshError> {
        if count > self.room_for(kind) {
            return Err(self.ended());
        }
        self.at += count as usize * kind.size();
        Ok(())
    }

    fn room(&self, element: &Element) -> u64 {
        let sizes = element.properties.iter().map(|property| property.length.unwrap_or(property.kind).size());
        self.left().checked_div(sizes.sum::<usize>() as u64).unwrap_or(u64::MAX)
    }

    fn room_for(&self, kind: Scalar) -> u64 {
        self.left() / kind.size() as u64
    }

    fn at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    fn error(&self, message: String) -> MeshError {
        MeshError::new(Place::Byte(self.previous as u64), message)
    }
}

/// A 16-bit float (IEEE 754-2008 binary16); both parts of it are exact in 32 bits.
fn half(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let exponent = u32::from((bits >> 10) & 0x1f);
    let fraction = u32::from(bits & 0x3ff);
    let magnitude = match exponent {
        // Subnormal: a multiple of 2⁻²⁴.
        0 => return f32::from_bits(sign | (fraction as f32 / 16_777_216.0).to_bits()),
        31 => 0x7f80_0000 | (fraction << 13),
        // The bias goes from 15 to 127.
        _ => ((exponent + 112) << 23) | (fraction << 13),
    };
    f32::from_bits(sign | magnitude)
}

/// A body in text: numbers with white space between them.
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    at: usize,
    previous: usize,
}

impl<'a> Ascii<'a> {
    pub(super) fn new(bytes: &'a [u8], begin: usize) -> Self {
        Self { bytes, at: begin, previous: begin }
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn word(&mut self) -> Result<&'a str, MeshError> {
        let rest = self.rest();
        let begin = rest.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(rest.len());
        let length =
            rest[begin..].iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(rest.len() - begin);
        self.previous = self.at + begin;
        self.at = self.previous + length;
        if length == 0 {
            return Err(self.error("the file ends in the middle of its data".into()));
        }
        // What is not UTF-8 is no number either.
        Ok(std::str::from_utf8(&rest[begin..begin + length]).unwrap_or("?"))
    }

    fn not_a_number(&self, word: &str, what: &str) -> MeshError {
        self.error(format!("`{}` is not {what}", shortened(word)))
    }
}

impl Values for Ascii<'_> {
    fn float(&mut self, kind: Scalar) -> Result<f32, MeshError> {
        let word = self.word()?;
        // Text is rounded once, to the type the header states, as a binary file would have been.
        let number = match kind {
            Scalar::F64 => word.parse::<f64>().map(|number| number as f32),
            _ => word.parse::<f32>(),
        };
        number.map_err(|_| self.not_a_number(word, "a number"))
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, MeshError> {
        let word = self.word()?;
        word.parse().map_err(|_| self.not_a_number(word, "an integer"))
    }

    fn triangle(&mut self, _: u32) -> Option<[u32; 3]> {
        None
    }

    fn skip(&mut self, _: Scalar, count: u64) -> Result<(), MeshError> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    fn room(&self, element: &Element) -> u64 {
        self.room_for(Scalar::U8).checked_div(element.properties.len() as u64).unwrap_or(u64::MAX)
    }

    /// A number is at least one digit and, but for the last, one blank.
    fn room_for(&self, _: Scalar) -> u64 {
        (self.rest().len() as u64).div_ceil(2)
    }

    fn at_end(&self) -> bool {
        self.rest().iter().all(u8::is_ascii_whitespace)
    }

    fn error(&self, message: String) -> MeshError {
        MeshError::line(self.bytes, self.previous, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_keep_their_value() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960_464_5e-8),
            (0x0400, 6.103_515_6e-5),
            (0x8000, -0.0),
        ] {
            assert_eq!(half(bits).to_bits(), f32::to_bits(value), "{bits:#x}");
        }
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan());
    }

    #[test]
    fn both_byte_orders_give_the_same_numbers() {
        let mut little = Binary::<false>::new(&[0, 0, 128, 63, 254, 255, 7], 0);
        let mut big = Binary::<true>::new(&[63, 128, 0, 0, 255, 254, 7], 0);
        for (kind, value) in [(Scalar::I16, -2), (Scalar::U8, 7)] {
            if kind == Scalar::I16 {
                assert_eq!(little.float(Scalar::F32).unwrap(), 1.0);
                assert_eq!(big.float(Scalar::F32).unwrap(), 1.0);
            }
            assert_eq!(little.integer(kind).unwrap(), value);
            assert_eq!(big.integer(kind).unwrap(), value);
        }
        assert!(little.at_end() && little.integer(Scalar::U8).is_err());
    }

    #[test]
    fn text_is_rounded_once() {
        // 10⁻²⁴ past the midpoint of 1 and 1 + 2⁻²³: f64 would lose that, and the tie would then go down to
        // 1.
        let mut text = Ascii::new(b"1.000000059604644775390626 12 ", 0);
        assert_eq!(text.float(Scalar::F32).unwrap(), 1.0 + f32::EPSILON);
        assert_eq!(text.integer(Scalar::U8).unwrap(), 12);
        assert!(text.at_end());
    }
}
