//! What a scene says of its film.

use super::filter::{FILTERS, Profile};
use super::filter_sampler::FilterSampler;
use super::filter_weights::{FilterWeights, Place, Weights};
use crate::film::Window;
use crate::math::DVec2;
use crate::scene::error::{SceneError, Span, known};
use crate::scene::params::{Params, Usage};
use crate::scene::registry::{Entry, construct};
use crate::spectrum::distribution::Distribution;
use crate::spectrum::table::Tabulated;
use crate::spectrum::{ColorMode, SpectralFunction};
use crate::texture::AnyTexture;
use std::sync::Arc;

/// A film larger than this is refused: its accumulators alone would take tens of gigabytes.
const MAX_PIXELS: u64 = 1 << 27;

/// The film: its size, and what it records.
#[derive(Clone, Debug)]
pub struct Film {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The part of the film that the scene file asks for.
    pub crop: Window,
    pub filter: FilterSampler,
    /// Whether filters reach beyond the crop; otherwise they end there, as in Mitsuba.
    pub border: bool,
    /// Where samples count for all pixels that the filter reaches, instead of lying where a pixel's filter
    /// says; see [`crate::render::plan::reuse`], which settles it.
    pub spread: Option<FilterWeights>,
    /// Whether there is a channel `A`, which says how much of a pixel is covered.
    pub alpha: bool,
    /// The responses of a spectral film, by name; an RGB film has none.
    pub bands: Vec<Band>,
    /// The wavelengths of a spectral film.
    pub wavelengths: Option<Arc<Distribution>>,
}

/// A spectral channel: the mean radiance weighted by a response.
#[derive(Clone, Debug)]
pub struct Band {
    /// Its name in the scene file.
    pub name: String,
    /// Its channel in the image.
    pub channel: String,
    /// Where the scene file names it.
    pub place: Span,
    pub response: Tabulated,
}

/// The channel of a response: `S0.` and its centroid, as in `S0.550,000nm` (Fichet et al. 2021, "An OpenEXR
/// Layout for Spectral Images", §3). It keeps its own name if it has no centroid.
fn channel_of(name: &str, response: &Tabulated) -> String {
    let (lowest, highest) = response.range();
    const STEPS: usize = 4096;
    let (mut area, mut moment) = (0.0, 0.0);
    for step in 0..STEPS {
        let λ = lowest as f64 + (step as f64 + 0.5) / STEPS as f64 * (highest - lowest) as f64;
        let value = response.eval(λ as f32) as f64;
        area += value;
        moment += value * λ;
    }
    let centroid = moment / area;
    if !centroid.is_finite() {
        return name.to_owned();
    }
    let thousandths = (1000.0 * centroid).round() as u64;
    format!("S0.{},{:03}nm", thousandths / 1000, thousandths % 1000)
}

impl Default for Film {
    fn default() -> Self {
        Self::new((768, 576), Profile::Gaussian { deviation: 0.5 })
    }
}

impl Film {
    pub fn new(size: (u32, u32), profile: Profile) -> Self {
        let crop = Window { x: 0, y: 0, width: size.0, height: size.1 };
        let filter = FilterSampler::new(profile);
        Self {
            size,
            crop,
            filter,
            border: false,
            spread: None,
            alpha: false,
            bands: vec![],
            wavelengths: None,
        }
    }

    /// Where a sample of pixel (x, y) lies, in pixels of the film, and its weight; u is in [0, 1)².
    #[inline]
    pub fn place(&self, (x, y): (u32, u32), u: DVec2) -> (DVec2, f64) {
        let [(left, right), (above, below)] = self.sides((x, y));
        let (dx, wx) = self.filter.sample(u.x, left, right);
        let (dy, wy) = self.filter.sample(u.y, above, below);
        (DVec2::new(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy), wx * wy)
    }

    /// The place of all samples of a number within their pixels, by column and by row, if samples count for
    /// all pixels that the filter reaches; u is in [0, 1)².
    pub fn place_in_pixels(&self, u: DVec2) -> Option<[Place; 2]> {
        self.spread.as_ref().map(|spread| [spread.place(u.x), spread.place(u.y)])
    }

    /// The weights, by column and by row, that samples at this place within their pixels have for pixel
    /// (x, y), which is in the middle.
    pub fn weights(&self, pixel: (u32, u32), [column, row]: [Place; 2]) -> Option<[Weights; 2]> {
        let [columns, rows] = self.sides(pixel);
        let spread = self.spread.as_ref()?;
        Some([spread.at(column, &self.filter, columns), spread.at(row, &self.filter, rows)])
    }

    /// How filters can be splatted, if they can. Beyond the film there are no samples.
    pub fn spreadable(&self) -> Option<FilterWeights> {
        if self.border { None } else { FilterWeights::new(self.filter.profile()) }
    }

    /// Variance of a sum of many pixels over the sum of their variances: where samples count for several
    /// pixels, errors of these are alike.
    pub fn correlation(&self) -> f64 {
        let along = |spread: &FilterWeights| spread.squares(&self.filter);
        self.spread.as_ref().map_or(1.0, |spread| 1.0 / (along(spread) * along(spread)))
    }

    /// How many further pixels the filter of pixel (x, y) may reach: left and right, above and below.
    #[inline]
    fn sides(&self, (x, y): (u32, u32)) -> [(u32, u32); 2] {
        let (c, all) = (self.crop, (u32::MAX, u32::MAX));
        // Pixels that share with those of the crop may lie beyond it.
        let sides = |pixel: u32, begin: u32, size: u32| {
            (pixel.saturating_sub(begin), (begin + size - 1).saturating_sub(pixel))
        };
        if self.border { [all, all] } else { [sides(x, c.x, c.width), sides(y, c.y, c.height)] }
    }

    /// The pixel that light at a place of the film (in pixels) is given to, and its weight: the inverse of
    /// [`Film::place`].
    pub fn pixel_at(&self, place: DVec2, u: DVec2) -> Option<((u32, u32), f64)> {
        let c = self.crop;
        let limits = |count: u32| {
            move |pixel: u32| if self.border { (u32::MAX, u32::MAX) } else { (pixel, count - 1 - pixel) }
        };
        let (x, wx) = self.filter.pixel_at(place.x - f64::from(c.x), u.x, c.width, limits(c.width))?;
        let (y, wy) = self.filter.pixel_at(place.y - f64::from(c.y), u.y, c.height, limits(c.height))?;
        Some(((c.x + x, c.y + y), wx * wy))
    }

    /// Width over height.
    pub fn aspect(&self) -> f64 {
        self.size.0 as f64 / self.size.1 as f64
    }

    /// Refuses sizes that no film can have.
    pub fn check_size(width: u64, height: u64) -> Result<(), String> {
        if width == 0 || height == 0 {
            return Err(format!("a film of {width} × {height} pixels has no pixels"));
        }
        if width.saturating_mul(height) > MAX_PIXELS {
            return Err(format!(
                "a film of {width} × {height} pixels is too large; at most {MAX_PIXELS} are possible"
            ));
        }
        Ok(())
    }
}

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

/// Every nested spectrum or texture is a channel, named as [`channel_of`] says.
fn parse_bands(params: &mut Params) -> Result<Vec<Band>, SceneError> {
    if params.loader.mode == ColorMode::Rgb {
        return Err(SceneError::at(
            &params.element.span,
            "a specfilm needs spectral mode",
            "drop `--color rgb`",
        ));
    }
    let mut bands = vec![];
    let about = "a response; its channel is called by its centroid, such as S0.550,000nm, or if another has the same, by its own name";
    let responses = params.nested("spectrum", about, |e| ["spectrum", "texture"].contains(&e.tag.as_str()));
    for (element, site) in responses {
        let name = site.require("name")?;
        let response = match AnyTexture::parse(element, params.loader, Usage::Unbounded)? {
            AnyTexture::Constant(SpectralFunction::Table(table)) => (*table).clone(),
            _ => {
                return Err(SceneError::at(
                    &element.span,
                    "a response must be a table",
                    "expected `nm:value, …` pairs",
                ));
            }
        };
        let channel = channel_of(&name.value, &response);
        bands.push(Band { name: name.value.clone(), channel, place: name.value_span.clone(), response });
    }
    if bands.is_empty() {
        return Err(SceneError::at(
            &params.element.span,
            "a specfilm without responses",
            "add a <spectrum name=…>",
        ));
    }
    bands.sort_by(|a, b| a.name.cmp(&b.name));
    let channels: Vec<String> = bands.iter().map(|band| band.channel.clone()).collect();
    let alike = |channel: &String| channels.iter().filter(|other| *other == channel).count() > 1;
    for band in bands.iter_mut().filter(|band| alike(&band.channel)) {
        band.channel = band.name.clone();
    }
    Ok(bands)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;

    const SIZE: (u32, u32) = (7, 5);

    #[test]
    fn samples_lie_about_the_centre_of_their_pixel() {
        for profile in [Profile::Box, Profile::Gaussian { deviation: 0.5 }] {
            let (place, weight) = Film::new(SIZE, profile).place((3, 2), DVec2::splat(0.5));
            assert!((place - DVec2::new(3.5, 2.5)).length() < 1e-12, "{place}");
            assert!((weight - 1.0).abs() < 0.01, "{weight}");
        }
    }

    #[test]
    fn filters_end_at_the_film_unless_they_may_reach_beyond() {
        let mut film = Film::new(SIZE, Profile::Gaussian { deviation: 0.5 });
        for border in [false, true] {
            film.border = border;
            let (first, _) = film.place((0, 0), DVec2::splat(1e-6));
            let (last, _) = film.place((6, 4), DVec2::splat(1.0 - 1e-6));
            let beyond = [first.x < 0.0, first.y < 0.0, last.x > 7.0, last.y > 5.0];
            assert_eq!(beyond, [border; 4], "{first} {last}");
        }
    }

    #[test]
    fn responses_with_one_centroid_all_keep_their_names() {
        let response = |name: &str, table: &str| format!(r#"<spectrum name="{name}" value="{table}"/>"#);
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"><film type="specfilm">{}{}{}{}</film></sensor></scene>"#,
            response("narrow", "540:1, 560:1"),
            response("broad", "500:1, 600:1"),
            response("broader", "450:1, 650:1"),
            response("red", "640:1, 660:1"),
        );
        let scene = load_text("film.xml", &text, ColorMode::Spectral).expect("it loads");
        let channels: Vec<&str> = scene.sensor.film.bands.iter().map(|band| band.channel.as_str()).collect();
        assert_eq!(channels, ["broad", "broader", "narrow", "S0.650,000nm"]);
    }

    #[test]
    fn responses_may_be_textures_and_references_and_have_the_name_that_they_have_here() {
        let texture = r#"<texture type="regular" ID><float name="wavelength_min" value="500"/>
            <float name="wavelength_max" value="600"/><string name="values" value="1, 1"/></texture>"#;
        let text = format!(
            r#"<scene version="3.0.0">{}<sensor type="perspective"><film type="specfilm">{}<ref id="r" name="red"/></film></sensor></scene>"#,
            texture.replace("ID", r#"id="r" name="other""#),
            texture.replace("ID", r#"name="green""#),
        );
        let scene = load_text("film.xml", &text, ColorMode::Spectral).expect("it loads");
        // All have one centroid.
        let names: Vec<&str> = scene.sensor.film.bands.iter().map(|band| band.channel.as_str()).collect();
        assert_eq!(names, ["green", "red"]);
    }

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

    /// Light goes to the pixels whose samples lie where it falls: over all places, as often as their weights
    /// say.
    #[test]
    fn light_is_given_to_the_pixel_that_gathers_it() {
        let mut film = Film::new(SIZE, Profile::Box);
        film.crop = Window { x: 2, y: 1, width: 3, height: 2 };
        for pixel in [(2, 1), (4, 1), (3, 2), (4, 2)] {
            let (place, _) = film.place(pixel, DVec2::new(0.1, 0.9));
            assert_eq!(film.pixel_at(place, DVec2::splat(0.4)), Some((pixel, 1.0)));
        }
        assert_eq!(film.pixel_at(DVec2::new(1.9, 1.5), DVec2::splat(0.4)), None);
    }
}
