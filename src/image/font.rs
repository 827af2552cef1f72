//! A font of 5 × 7 pixels for captions; its glyphs are drawn in `font.txt`.

/// Columns of a glyph.
pub(super) const WIDTH: u32 = 5;

/// Rows of a glyph.
pub(super) const HEIGHT: u32 = 7;

const GLYPHS: &str = include_str!("font.txt");

/// Whether the glyph of a character has ink in this column and row. Small letters look like capitals;
/// characters the font lacks, and the space, are blank.
pub(super) fn ink(character: char, x: u32, y: u32) -> bool {
    let character = character.to_ascii_uppercase() as u32;
    let lines: Vec<&[u8]> = GLYPHS.lines().map(str::as_bytes).collect();
    // Bands of glyphs, side by side with a space between: first a line with the characters, then the rows.
    lines.chunks_exact(1 + HEIGHT as usize).any(|band| {
        let starts = (0..band[0].len()).step_by(WIDTH as usize + 1);
        starts
            .filter(|&start| u32::from(band[0][start]) == character)
            .any(|start| band[1 + y as usize].get(start + x as usize) == Some(&b'#'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn shape(character: char) -> Vec<bool> {
        (0..WIDTH * HEIGHT).map(|i| ink(character, i % WIDTH, i / WIDTH)).collect()
    }

    #[test]
    fn glyphs_are_complete_and_distinct() {
        let lines: Vec<&str> = GLYPHS.lines().collect();
        assert!(lines.len().is_multiple_of(8));
        for band in lines.chunks(8) {
            let glyphs = band[0].split_whitespace().count();
            for row in &band[1..] {
                assert!(
                    row.split(' ').count() == glyphs && row.split(' ').all(|cells| cells.len() == 5),
                    "{row}"
                );
            }
        }
        let characters: Vec<char> =
            lines.chunks(8).flat_map(|band| band[0].chars().filter(|c| !c.is_whitespace())).collect();
        let shapes: BTreeSet<Vec<bool>> = characters.iter().map(|&character| shape(character)).collect();
        assert_eq!(shapes.len(), characters.len());
    }

    #[test]
    fn small_letters_are_capitals_and_unknown_ones_blank() {
        assert_eq!(shape('a'), shape('A'));
        assert!(shape(' ').iter().chain(&shape('λ')).all(|ink| !ink));
        assert!(ink('L', 0, 0) && !ink('L', 1, 0) && ink('L', 4, 6));
    }
}
