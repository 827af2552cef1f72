//! Different methods for the same colours: eight wavelengths per path, one wavelength per path, and bands of
//! a spectral film.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;
use etalon::spectrum::ColorMode;
use validation::image::{Channel, Image};

/// The normalisation of images (Mitsuba 3.9's constant; see the renderer's `observer`).
const Y_INTEGRAL: f64 = 106.750_259_399_414_06;

/// The second row of the matrix from linear sRGB to XYZ.
const LUMINANCE: [(&str, f64); 3] = [("R", 0.212_671), ("G", 0.715_160), ("B", 0.072_169)];

pub fn relations() -> Vec<Relation> {
    let spectral = |scene: String| Term { mode: ColorMode::Spectral, ..Term::new(scene) };
    let (hero, single) = (room(""), room(&separator()).replace(&path(4), &path(5)));
    let colours = |name: &str, left: &str, right: &str| {
        let sides = [left, right].map(|scene| vec![spectral(scene.to_string())]);
        let [left, right] = sides;
        // One wavelength per path is noisier than eight by an order of magnitude.
        Relation::expectation(name, left, right).samples(1 << 12)
    };
    let seen =
        |scene: &str, view: fn(&Image) -> Image| vec![Term { view: Some(view), ..spectral(scene.into()) }];
    let banded = |scene: &str| scene.replace(&film(SIZE, SIZE), &observing_film());
    vec![
        // Both are held to `specfilm` below.
        colours("hero_is_single_wavelength", &hero, &single).longer(3).at_length(),
        Relation::expectation("hero_is_specfilm", seen(&hero, luminance), seen(&banded(&hero), band))
            .samples(1 << 12),
        Relation::expectation(
            "specfilm_is_single_wavelength",
            seen(&banded(&hero), band),
            seen(&banded(&single), band),
        )
        .samples(1 << 12),
    ]
}

/// The room in colours, with further elements.
fn room(more: &str) -> String {
    let colour = |rgb: &str| bsdf("diffuse", &format!("<rgb name=\"reflectance\" value=\"{rgb}\"/>"));
    let [orange, blue] = ["0.7, 0.4, 0.15", "0.2, 0.35, 0.6"].map(colour);
    with(more).replace(&diffuse(0.6), &orange).replace(&diffuse(0.7), &blue)
}

/// A pane in front of the camera that does not refract, but whose index depends on the wavelength by
/// 10⁻¹²/µm²: behind it every path has one wavelength.
fn separator() -> String {
    let glass = bsdf(
        "dielectric",
        "<string name=\"cauchy\" value=\"1 1e-12 0\"/><float name=\"ext_ior\" value=\"1\"/>",
    );
    let [x, y, z] = EYE;
    shape("rectangle", &[rotate('x', 90.0), scale([0.3; 3]), translate([x, y + 0.2, z])], &glass)
}

/// A film with one band, whose sensitivity is the eye's.
fn observing_film() -> String {
    let table = include_str!("../../../../src/spectrum/data/cie1931.csv");
    let rows = table.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<Vec<&str>> = rows.map(|row| row.split(',').map(str::trim).collect()).collect();
    let column =
        |i: usize| columns.iter().filter_map(|row| row.get(i).copied()).collect::<Vec<_>>().join(", ");
    let (wavelengths, values) = (column(0), column(2));
    film(SIZE, SIZE).replace("hdrfilm", "specfilm").replace(
        "<rfilter",
        &format!(
            "<spectrum name=\"eye\" type=\"irregular\"><string name=\"wavelengths\" value=\"{wavelengths}\"/>\
             <string name=\"values\" value=\"{values}\"/></spectrum><rfilter"
        ),
    )
}

/// The film's band, as luminance.
fn band(image: &Image) -> Image {
    let of_band = |channel: &&Channel| channel.name.starts_with("S0.");
    let scaled = |channel: &Channel| Channel {
        name: "Y".into(),
        mean: channel.mean.iter().map(|v| v / Y_INTEGRAL).collect(),
        variance: channel
            .variance
            .as_ref()
            .map(|v| v.iter().map(|v| v / (Y_INTEGRAL * Y_INTEGRAL)).collect()),
    };
    Image { channels: image.channels.iter().filter(of_band).map(scaled).collect(), ..*image }
}

/// The luminance of the colours. The correlation of their errors is at most 1, so their standard deviations
/// add up to an upper bound.
fn luminance(image: &Image) -> Image {
    let pixels = image.width * image.height;
    let (mut mean, mut deviation) = (vec![0.0; pixels], vec![0.0; pixels]);
    for (name, weight) in LUMINANCE {
        for channel in image.channels.iter().filter(|channel| channel.name == name) {
            mean.iter_mut().zip(&channel.mean).for_each(|(sum, v)| *sum += weight * v);
            let variances = channel.variance.iter().flatten();
            deviation.iter_mut().zip(variances).for_each(|(sum, v)| *sum += weight * v.sqrt());
        }
    }
    let variance = Some(deviation.into_iter().map(|d: f64| d * d).collect());
    Image { channels: vec![Channel { name: "Y".into(), mean, variance }], ..*image }
}
