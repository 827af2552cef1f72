//! The channels of a spectral film.

use crate::scene::error::{SceneError, Span};
use crate::scene::params::{Params, Usage};
use crate::spectrum::table::Tabulated;
use crate::spectrum::{ColorMode, SpectralFunction};
use crate::texture::AnyTexture;

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

/// Every nested spectrum or texture is a channel, named as [`channel_of`] says.
pub fn parse_bands(params: &mut Params) -> Result<Vec<Band>, SceneError> {
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
    use crate::load_text;
    use crate::spectrum::ColorMode;

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
}
