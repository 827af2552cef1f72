//! Parsers of the command line's short notations.

use etalon::film::Window;
use etalon::film::{BLOCK, Film};
use std::ops::Range;

/// `WxH`.
pub fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let (width, height): (u32, u32) = parsed.ok_or("expected such as 640x480")?;
    Film::check_size(width as u64, height as u64)?;
    Ok((width, height))
}

/// `X,Y,W,H`.
pub fn parse_window(text: &str) -> Result<Window, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Window { x, y, width, height }),
        _ => Err("expected X,Y,W,H: the first column and row, and a size of at least 1x1".into()),
    }
}

/// `A..B`.
pub fn parse_samples(text: &str) -> Result<Range<u64>, String> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    let (a, b): (u64, u64) = parsed.ok_or("expected such as 0..64")?;
    if a >= b {
        return Err(format!("{a}..{b} is empty"));
    }
    if a % BLOCK != 0 {
        return Err(format!(
            "a range must begin at a multiple of {BLOCK}, the length of a block; {a} is none"
        ));
    }
    if b > u64::from(u32::MAX) {
        return Err(format!("at most {} samples are possible", u32::MAX));
    }
    Ok(a..b)
}

/// A finite number above zero.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if number > 0.0 && f64::is_finite(number) => Ok(number),
        _ => Err("expected a number above 0".into()),
    }
}

/// A number above zero, or percents.
pub fn parse_share(text: &str) -> Result<f64, String> {
    match text.strip_suffix('%') {
        Some(percents) => parse_positive(percents.trim_end()).map(|number| number / 100.0),
        None => match parse_positive(text)? {
            number if number < 1.0 => Ok(number),
            number => Err(format!("{number} is {}%; write {number}% if that is meant", 100.0 * number)),
        },
    }
}

/// `X,Y`.
pub fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    let parsed =
        text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    parsed.ok_or_else(|| "expected X,Y".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notations_are_read_and_nonsense_is_refused() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert!(
            parse_size("0x5").is_err() && parse_size("100000x100000").is_err() && parse_size("5").is_err()
        );
        assert_eq!(parse_samples("64..128"), Ok(64..128));
        assert!(parse_samples("3..8").unwrap_err().contains("multiple"));
        assert!(parse_samples("8..8").is_err() && parse_samples("0..5000000000").is_err());
        assert_eq!(parse_window("1,2,3,4"), Ok(Window { x: 1, y: 2, width: 3, height: 4 }));
        assert!(parse_window("1,2,0,4").is_err());
        assert_eq!(
            [parse_share("0.5%"), parse_share("0.005"), parse_share("2 %")],
            [0.005, 0.005, 0.02].map(Ok)
        );
        for nonsense in ["0", "-1", "nan", "inf", "1e400", "", "%", "x"] {
            assert!(parse_share(nonsense).is_err() && parse_positive(nonsense).is_err(), "{nonsense}");
        }
    }
}
