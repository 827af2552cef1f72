//! Contact sheets: several pictures on one.

use super::Rgb8;
use super::font::{HEIGHT, WIDTH, ink};

/// Pixels between pictures and around letters.
const GAP: u32 = 2;

const PAPER: [u8; 3] = [32, 32, 32];
const INK: [u8; 3] = [224, 224, 224];

/// Pictures with captions, side by side from left to right in rows of `columns` (at least one), in cells of
/// the largest width and height. An empty caption leaves its line blank; without any caption there is no line
/// for them.
pub fn contact_sheet(pictures: &[(String, Rgb8)], columns: u32) -> Rgb8 {
    let columns = columns.clamp(1, (pictures.len() as u32).max(1));
    let rows = (pictures.len() as u32).div_ceil(columns);
    let captioned = pictures.iter().any(|(caption, _)| !caption.is_empty());
    let line = if captioned { HEIGHT + 2 * GAP } else { 0 };
    let largest =
        |side: fn(&Rgb8) -> u32| pictures.iter().map(|(_, picture)| side(picture)).max().unwrap_or(0);
    let (width, height) = (largest(|picture| picture.width), largest(|picture| picture.height) + line);
    let mut sheet =
        Rgb8::filled(columns * (width + GAP) - GAP, (rows * (height + GAP)).saturating_sub(GAP), PAPER);
    for (i, (caption, picture)) in (0..).zip(pictures) {
        let (left, top) = (i % columns * (width + GAP), i / columns * (height + GAP));
        if captioned {
            sheet.paste(&letter(caption, width), left, top);
        }
        sheet.paste(picture, left, top + line);
    }
    sheet
}

/// One line of text, as wide as told; what does not fit is cut off.
fn letter(caption: &str, width: u32) -> Rgb8 {
    let mut strip = Rgb8::filled(width, HEIGHT + 2 * GAP, PAPER);
    for (i, character) in (0..).zip(caption.chars()) {
        for y in 0..HEIGHT {
            for x in (0..WIDTH).filter(|&x| ink(character, x, y)) {
                strip.paste(&Rgb8::filled(1, 1, INK), GAP + i * (WIDTH + 1) + x, GAP + y);
            }
        }
    }
    strip
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(picture: &Rgb8, x: u32, y: u32) -> [u8; 3] {
        picture.pixels[(y * picture.width + x) as usize]
    }

    #[test]
    fn pictures_stand_in_a_grid() {
        let pictures: Vec<_> = (0..5).map(|i| (String::new(), Rgb8::filled(4, 3, [i; 3]))).collect();
        let sheet = contact_sheet(&pictures, 3);
        assert_eq!((sheet.width, sheet.height), (3 * 4 + 2 * GAP, 2 * 3 + GAP));
        assert_eq!([at(&sheet, 0, 0), at(&sheet, 15, 2), at(&sheet, 6, 5)], [[0; 3], [2; 3], [4; 3]]);
        assert_eq!([at(&sheet, 4, 0), at(&sheet, 0, 3), at(&sheet, 15, 7)], [PAPER; 3]);
    }

    #[test]
    fn captions_stand_above() {
        let sheet = contact_sheet(&[("L".into(), Rgb8::filled(20, 3, [1; 3]))], 1);
        let line = HEIGHT + 2 * GAP;
        assert_eq!((sheet.width, sheet.height), (20, 3 + line));
        assert_eq!([at(&sheet, GAP, GAP), at(&sheet, GAP + 4, GAP + 6)], [INK; 2]);
        assert_eq!(
            [at(&sheet, GAP + 4, GAP), at(&sheet, 0, line - 1), at(&sheet, 0, line)],
            [PAPER, PAPER, [1; 3]]
        );
    }

    #[test]
    fn odd_sheets() {
        assert_eq!(contact_sheet(&[], 4).pixels.len(), 0);
        let sizes =
            [Rgb8::filled(1, 5, [1; 3]), Rgb8::filled(6, 2, [2; 3])].map(|picture| (String::new(), picture));
        let sheet = contact_sheet(&sizes, 0);
        assert_eq!((sheet.width, sheet.height), (6, 12));
    }
}
