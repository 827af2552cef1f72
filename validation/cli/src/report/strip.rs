//! A strip of pictures: the views of the cameras of stiff and extreme scenes.

use super::Effort;
use super::pictures::{as_png, white};
use crate::stability;
use validation::html::escape;

/// Samples per pixel; the pictures are illustrations, the verdicts are in the table.
const SAMPLES: u64 = 256;

/// The image of a case, as a data URI.
#[derive(Clone, Debug)]
pub struct Still {
    pub name: String,
    pub picture: String,
}

/// A picture of each case, whether it is run or not, except those whose film is a single pixel.
pub fn stills(effort: Effort) -> Result<Vec<Still>, String> {
    let samples = if effort.sparse { SAMPLES / 4 } else { SAMPLES };
    let mut stills = vec![];
    for case in stability::cases() {
        let Some(scene) = case.scene() else { continue };
        // A case that cannot be rendered is different already, and the table gives the reason.
        let Ok(image) = scene.image(samples, 0) else { continue };
        if image.width * image.height > 1 {
            let picture = as_png(&image, white(&image))?;
            stills.push(Still { name: case.name, picture });
        }
    }
    Ok(stills)
}

/// The pictures in a row that wraps, each with the name of its case.
pub fn html(stills: &[Still]) -> String {
    let frame = |still: &Still| {
        let name = escape(&still.name);
        let seen = format!("<img alt=\"seen in {name}\" src=\"{}\">", still.picture);
        format!("<figure>{seen}<figcaption>{name}</figcaption></figure>")
    };
    format!("<div class=\"strip\">{}</div>", stills.iter().map(frame).collect::<String>())
}
