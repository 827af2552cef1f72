//! Reference scenes with three images to switch between: Mitsuba's, Etalon's, and their difference in
//! standard errors.

use super::Effort;
use super::charts::figure;
use super::evidence::MARGIN;
use crate::references::{folder, references, settings};
use etalon::image::{Rgb8, encode_png, encode_srgb};
use validation::html::escape;
use validation::image::{self, Image};

/// Scenes that together contain most plugins.
const SCENES: [&str; 8] =
    ["cornell", "adapters", "dielectric", "roughconductor", "plastic", "textures", "emitters-area", "envmap"];

/// A scene's three pictures as data URIs, and the verdict on them.
#[derive(Clone, Debug)]
pub struct Pictures {
    pub name: String,
    pub message: String,
    pub mitsuba: String,
    pub etalon: String,
    pub scores: String,
}

/// Renders the scenes and compares each with its reference; half as many scenes if the effort is sparse.
pub fn pictures(effort: Effort) -> Result<Vec<Pictures>, String> {
    let count = if effort.sparse { SCENES.len() / 2 } else { SCENES.len() };
    let names: Vec<String> = SCENES[..count].iter().map(|scene| format!("{scene}::rgb")).collect();
    let mut pictures = vec![];
    for reference in references(&folder())?.iter().filter(|r| names.contains(&r.name)) {
        let theirs = reference.image()?;
        let ours = reference.render(effort.spp, 0)?;
        let settings = settings(MARGIN);
        let comparison = image::compare(&theirs, &ours, &settings).map_err(|e| e.to_string())?;
        let scores = image::difference_map(&theirs, &ours, &settings).map_err(|e| e.to_string())?;
        let scores = data_uri(&scores);
        let white = white(&theirs);
        let [mitsuba, etalon] = [as_png(&theirs, white)?, as_png(&ours, white)?];
        let message = format!("{}: {}", comparison.verdict, comparison.message);
        pictures.push(Pictures { name: reference.name.clone(), message, mitsuba, etalon, scores });
    }
    Ok(pictures)
}

impl Pictures {
    /// The pictures in one place with buttons; without a script they are shown one below the other.
    pub fn html(&self) -> String {
        let layers = [
            ("A · Mitsuba", &self.mitsuba, "rendered by Mitsuba"),
            ("B · Etalon", &self.etalon, "rendered by Etalon"),
            ("z", &self.scores, "signed z-scores: red where Etalon is brighter, blue where darker"),
        ];
        let name = escape(&self.name);
        let layer = |(label, data, about): &(&str, &String, &str)| {
            format!("<img data-label=\"{}\" alt=\"{name}, {about}\" src=\"{data}\">", escape(label))
        };
        let drawing = format!("<div class=\"flip\">{}</div>", layers.iter().map(layer).collect::<String>());
        figure(&self.name, &drawing, &escape(&self.message))
    }
}

/// A picture as a data URI; the value `white` is shown white.
pub(super) fn as_png(image: &Image, white: f64) -> Result<String, String> {
    Ok(data_uri(&encode_png(&develop(image, white)).map_err(|e| e.to_string())?))
}

/// The 98th percentile of a picture's values, which is shown white.
pub(super) fn white(image: &Image) -> f64 {
    let mut values: Vec<f64> =
        colors(image).into_iter().flatten().copied().filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() * 98 / 100).copied().filter(|v| *v > 0.0).unwrap_or(1.0)
}

fn colors(image: &Image) -> [&[f64]; 3] {
    ["R", "G", "B"].map(|name| image.channels.iter().find(|c| c.name == name).map_or(&[][..], |c| &c.mean))
}

fn develop(image: &Image, white: f64) -> Rgb8 {
    let planes = colors(image);
    let code = |plane: &[f64], i: usize| encode_srgb((plane.get(i).copied().unwrap_or(0.0) / white) as f32);
    let pixels = (0..image.width * image.height).map(|i| planes.map(|plane| code(plane, i))).collect();
    Rgb8 { width: image.width as u32, height: image.height as u32, pixels }
}

/// The bytes of a PNG file as a data URI.
pub(crate) fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(png))
}

/// Base64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0usize, |word, i| word << 8 | usize::from(chunk.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let letter = LETTERS[word >> (18 - 6 * i) & 63] as char;
            text.push(if i <= chunk.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        let known = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (bytes, text) in known {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn all_scenes_exist_and_have_colours() {
        let all = references(&folder()).unwrap();
        for scene in SCENES {
            let found = all.iter().find(|r| r.name == format!("{scene}::rgb")).unwrap();
            assert!(
                colors(&image::load(&found.image).unwrap()).iter().all(|plane| !plane.is_empty()),
                "{scene}"
            );
        }
    }
}
