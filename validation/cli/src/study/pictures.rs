//! Pictures of renderers side by side, with maps of their error.

use etalon::image::{Rgb8, encode_png, encode_srgb};
use validation::converge::page::figures;
use validation::converge::{Picture, Reference, relative_squares};
use validation::html::escape;

use super::bench::Bench;
use super::line::Line;
use crate::renderers::{mean_of, read};
use crate::report::pictures::data_uri;

/// Relative squared error from which a map is brightest.
const BRIGHTEST: f64 = 1.0;
/// Number of decades below [`BRIGHTEST`] that a map spans.
const DECADES: f64 = 5.0;

/// Pictures and error maps of the longest rung, as HTML; empty if there are none.
pub fn pictures(names: &[String], lines: &[Line], bench: &Bench) -> Result<String, String> {
    let mut shown = String::new();
    for name in names {
        shown += &figure(name, lines, bench)?;
    }
    if shown.is_empty() {
        return Ok(shown);
    }
    Ok(format!(
        "<h3>After {}</h3><p class=\"note\">Above the picture, below the relative squared error, from 10⁻⁵ (black) to 1 \
         (white).</p><div class=\"pictures\">{shown}</div>",
        bench.settings.ladder.rungs().last().map_or("", String::as_str)
    ))
}

fn figure(name: &str, lines: &[Line], bench: &Bench) -> Result<String, String> {
    let file = bench.folder.join("pictures").join(format!("{name}.exr"));
    let Some(reference) = bench.stored_reference(mean_of(bench.renderers, name))?.filter(|_| file.is_file())
    else {
        return Ok(String::new());
    };
    let (picture, width, height) = read(&file)?;
    if picture.len() != reference.mean.len() || picture.len() != 3 * width * height {
        return Err(format!("{name}: its pictures differ in size"));
    }
    let uri = |pixels: Vec<[u8; 3]>| {
        let image = Rgb8 { width: width as u32, height: height as u32, pixels };
        Ok::<_, String>(data_uri(&encode_png(&image).map_err(|e| e.to_string())?))
    };
    let (seen, map) = (uri(develop(&picture, &reference))?, uri(error_map(&picture, &reference))?);
    let line = lines.iter().find(|line| line.renderer == name);
    let last = line.and_then(|l| l.trimmed.as_ref()).and_then(|c| c.errors.last());
    let (name, error) = (escape(name), last.map_or("–".into(), |i| figures(i.value)));
    let samples = line.and_then(|l| l.samples.last()).copied().unwrap_or(0);
    Ok(format!(
        "<figure><img alt=\"{name}\" src=\"{seen}\"><img alt=\"error of {name}\" src=\"{map}\"><figcaption>{name}<br>\
         {samples} samples, relMSE {error} (trimmed)</figcaption></figure>"
    ))
}

/// A picture in sRGB, white at the 98th percentile of the reference's values.
fn develop(picture: &Picture, reference: &Reference) -> Vec<[u8; 3]> {
    let mut values = reference.mean.clone();
    values.sort_by(f64::total_cmp);
    let white = values.get(values.len() * 98 / 100).copied().filter(|v| *v > 0.0).unwrap_or(1.0);
    let count = picture.len() / 3;
    (0..count).map(|i| [0, 1, 2].map(|c| encode_srgb((picture[c * count + i] / white) as f32))).collect()
}

/// The mean over the channels of the relative squared error, on a logarithmic scale from black over red and
/// yellow to white.
fn error_map(picture: &Picture, reference: &Reference) -> Vec<[u8; 3]> {
    let (squares, count) = (relative_squares(picture, reference), picture.len() / 3);
    let heat = |value: f64| {
        let share = 1.0 + libm::log10((value / BRIGHTEST).max(f64::MIN_POSITIVE)) / DECADES;
        [0.0, 1.0, 2.0].map(|first| (255.0 * (3.0 * share - first).clamp(0.0, 1.0)) as u8)
    };
    (0..count).map(|i| heat((0..3).map(|c| squares[c * count + i]).sum::<f64>() / 3.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::converge::reference;

    #[test]
    fn a_map_is_black_without_error_and_white_with_much() {
        let flat = vec![1.0; 6];
        let reference = reference(&[flat.clone(), flat.clone()]).unwrap();
        let mut spoiled = flat;
        spoiled[0] = 9.0;
        assert_eq!(error_map(&spoiled, &reference), [[255; 3], [0; 3]]);
        assert_eq!(develop(&spoiled, &reference)[1], [255; 3]);
    }
}
