//! Films as scene files describe them.

use super::bands::parse_bands;
use super::filter::{FILTERS, Profile};
use super::filter_sampler::FilterSampler;
use super::settings::{Film, MAX_PIXELS};
use crate::film::Window;
use crate::scene::error::{SceneError, known};
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::spectrum::distribution::Distribution;
use std::sync::Arc;

macro_rules! films {
    ($($name:literal, $about:literal, $parse:expr;)*) => {
        /// Every film.
        pub static FILMS: &[Entry<Film>] = &[$(Entry {
            name: $name,
            about: $about,
            examples: &[],
            parse: $parse,
        }),*];
    };
}
films! {
    "hdrfilm", "Linear sRGB in f32, with the variance of every pixel.", |p| parse(p, false);
    "specfilm", "Radiance weighted by spectral responses, one channel each.", |p| parse(p, true);
}

/// Whether `pixel_format` asks for a channel of coverage. As in Mitsuba, it may be written in capitals.
fn has_alpha(params: &mut Params) -> Result<bool, SceneError> {
    const FORMATS: [&str; 6] = ["rgb", "rgba", "luminance", "luminance_alpha", "xyz", "xyza"];
    let about = "with alpha, a channel `A` is added; the colours are RGB in any case";
    let Some(given) = params.string("pixel_format", about)? else { return Ok(false) };
    let format = given.value.to_lowercase();
    if !FORMATS.contains(&format.as_str()) {
        let message = format!("unknown pixel_format `{}`", given.value);
        return Err(SceneError::at(&given.value_span, message, known(&format, &FORMATS)));
    }
    Ok(format.ends_with('a'))
}

fn parse(params: &mut Params, spectral: bool) -> Result<Film, SceneError> {
    let width = params.count("width", 768, 1..=MAX_PIXELS as u32, "pixels")?;
    let height = params.count("height", 576, 1..=MAX_PIXELS as u32, "pixels")?;
    let (longer, beside) = if width < height { ("height", width) } else { ("width", height) };
    let most = MAX_PIXELS / u64::from(beside);
    Film::check_size(width as u64, height as u64)
        .map_err(|e| params.error(longer, e, format!("expected 1 to {most}")))?;
    let x = params.count("crop_offset_x", 0, 0..=width - 1, "first column that is rendered")?;
    let y = params.count("crop_offset_y", 0, 0..=height - 1, "first row that is rendered")?;
    // A number that no crop can have stands for all that is left.
    let mut along = |name, left: u32, about| match params.count(name, 0, 1..=left, about)? {
        0 => Ok(left),
        given => Ok(given),
    };
    let crop = Window {
        x,
        y,
        width: along("crop_width", width - x, "columns that are rendered; by default all from the first")?,
        height: along("crop_height", height - y, "rows that are rendered; by default all from the first")?,
    };
    let (components, files) = (["float16", "float32", "uint32"], ["openexr", "exr", "pfm", "rgbe"]);
    params.word("component_format", &components, "Mitsuba's; the file always holds f32")?;
    params.word("file_format", &files, "Mitsuba's; the file is always EXR")?;
    let alpha = has_alpha(params)?;
    let border = params.boolean("sample_border", false, "whether filters reach beyond the film")?;
    for name in ["compensate", "banner", "high_quality_edges"] {
        params.boolean(name, false, "Mitsuba's; ignored")?;
    }
    let profile = match params.object("rfilter", "the reconstruction filter; `gaussian` by default")? {
        None => Profile::Gaussian { deviation: 0.5 },
        Some(element) => construct(FILTERS, element, params.loader, Usage::Unbounded)?,
    };
    let filter = FilterSampler::new(profile);
    let seen = |pixels: u32| if border { u32::MAX } else { pixels };
    if filter.cancels(seen(crop.width)) || filter.cancels(seen(crop.height)) {
        let message = "the filter's weights cancel at the border of the film";
        return Err(params.error("rfilter", message, "expected another filter, or a larger film"));
    }
    let bands = if spectral { parse_bands(params)? } else { vec![] };
    let wavelengths = spectral.then(|| Arc::new(Distribution::new(bands.iter().map(|band| &band.response))));
    Ok(Film { size: (width, height), crop, filter, border, spread: None, alpha, bands, wavelengths })
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::spectrum::ColorMode;

    /// The side that cannot be is the one that is told.
    #[test]
    fn sizes_that_cannot_be_are_refused_where_they_stand() {
        for (width, height, column, expected) in [
            ("0", "4", 1, "1 to 134217728"),
            ("4", "0", 2, "1 to 134217728"),
            ("4", "-1", 2, "1 to 134217728"),
            ("20000", "10000", 1, "1 to 13421"),
            ("10000", "20000", 2, "1 to 13421"),
        ] {
            let text = format!(
                "<scene version=\"3.0.0\"><sensor type=\"perspective\"><film type=\"hdrfilm\">\n\
                 <integer name=\"width\" value=\"{width}\"/>\n<integer name=\"height\" value=\"{height}\"/></film></sensor></scene>"
            );
            let error = load_text("film.xml", &text, ColorMode::Rgb).err().expect("it is refused");
            assert_eq!(error.line_column().map(|(line, _)| line), Some(1 + column), "{error}");
            assert!(error.expected.ends_with(expected), "{error}");
        }
    }
}
