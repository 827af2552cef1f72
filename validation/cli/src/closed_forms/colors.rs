//! Spectra seen by the CIE observer, by quadrature of its tables.

use super::{ClosedForm, Measure, mean};
use crate::stage::*;
use std::sync::LazyLock;

/// The normalisation of images (Mitsuba 3.9's constant; see the renderer's `observer`).
const Y_INTEGRAL: f64 = 106.750_259_399_414_06;

/// A function of wavelength in nm.
type Spectrum = fn(f64) -> f64;

/// The rows of a CSV table with steps of 5 nm from 360 nm.
type Table = Vec<Vec<f64>>;

fn read(csv: &str) -> Table {
    let rows = csv.lines().filter(|line| !line.starts_with('#'));
    rows.map(|line| line.split(',').filter_map(|word| word.trim().parse().ok()).collect()).collect()
}

static OBSERVER: LazyLock<Table> =
    LazyLock::new(|| read(include_str!("../../../../src/spectrum/data/cie1931.csv")));
static DAYLIGHT: LazyLock<Table> =
    LazyLock::new(|| read(include_str!("../../../../src/spectrum/data/d65.csv")));

/// Linear interpolation between the rows; 0 outside the table.
fn look_up(table: &Table, column: usize, nm: f64) -> f64 {
    let place = (nm - 360.0) / 5.0;
    if !(0.0..=94.0).contains(&place) {
        return 0.0;
    }
    let row = (place as usize).min(93);
    let t = place - row as f64;
    table[row][column] * (1.0 - t) + table[row + 1][column] * t
}

/// D65 with luminance 1.
pub fn d65(nm: f64) -> f64 {
    look_up(&DAYLIGHT, 1, nm)
}

/// Integral over the visible range, 360 to 830 nm.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    integral_from(360.0, 9400, f)
}

/// Integral over this number of steps of 0.05 nm from `start`, by the midpoint rule.
fn integral_from(start: f64, steps: u32, f: impl Fn(f64) -> f64) -> f64 {
    (0..steps).map(|i| f(start + 0.05 * (f64::from(i) + 0.5)) * 0.05).sum()
}

/// X, Y, Z of a radiance spectrum.
pub fn color(radiance: Spectrum) -> [f64; 3] {
    [1, 2, 3].map(|column| integral(|nm| radiance(nm) * look_up(&OBSERVER, column, nm)) / Y_INTEGRAL)
}

/// Planck's law in W·m⁻²·sr⁻¹·nm⁻¹, with the two radiation constants of CODATA 2018.
fn planck(kelvin: f64, nm: f64) -> f64 {
    let metres = 1e-9 * nm;
    let m5 = metres * metres * metres * metres * metres;
    1e-9 * 1.191_042_972e-16 / (m5 * libm::expm1(1.438_776_877e-2 / (metres * kelvin)))
}

/// A narrow triangular reflectance.
fn line(nm: f64) -> f64 {
    (1.0 - (nm - 560.0).abs() / 10.0).max(0.0)
}

pub fn cases() -> Vec<ClosedForm> {
    let planck_source = "∫ B(λ, T) ȳ dλ with Planck's law (CODATA 2018 constants; CIE 1931 observer)";
    // By default a body is dark beyond the visible range.
    let body = |kelvin: f64| {
        let parameters = float("temperature", kelvin) + &float("wavelength_max", 1200.0);
        format!("<spectrum name=\"radiance\" type=\"blackbody\">{parameters}</spectrum>")
    };
    let daylight = "∫ D65 x̄ȳz̄ dλ = white";
    let uniform =
        "<spectrum name=\"radiance\" type=\"uniform\"><float name=\"value\" value=\"1\"/></spectrum>";
    let x = |light: Spectrum| {
        let [x, y, z] = color(light);
        x / (x + y + z)
    };
    let warm: Spectrum = |nm| planck(2700.0, nm);
    let cool: Spectrum = |nm| planck(6500.0, nm);
    let narrow = "<spectrum name=\"reflectance\" type=\"irregular\"><string name=\"wavelengths\" value=\"550, 560, 570\"/>\
                  <string name=\"values\" value=\"0, 1, 0\"/></spectrum>";
    let orange = "<rgb name=\"reflectance\" value=\"0.6, 0.3, 0.1\"/>";
    let mut cases = vec![
        ClosedForm::new("blackbody_2700", planck_source, wall(&body(2700.0)), color(warm)[1]),
        ClosedForm::new("blackbody_6500", planck_source, wall(&body(6500.0)), color(cool)[1]),
        ClosedForm::new("blackbody_2700_x", "chromaticity X/(X + Y + Z)", wall(&body(2700.0)), x(warm))
            .measure(chromaticity),
        ClosedForm::new("blackbody_6500_x", "chromaticity X/(X + Y + Z)", wall(&body(6500.0)), x(cool))
            .measure(chromaticity),
        ClosedForm::new("equal_energy", "∫ ȳ dλ", wall(uniform), color(|_| 1.0)[1]),
        ClosedForm::new("white_red", daylight, wall(&grey("radiance", 1.0)), 1.0).measure(|i| mean(i, "R")),
        ClosedForm::new("white_green", daylight, wall(&grey("radiance", 1.0)), 1.0).measure(|i| mean(i, "G")),
        ClosedForm::new("white_blue", daylight, wall(&grey("radiance", 1.0)), 1.0).measure(|i| mean(i, "B")),
        ClosedForm::new("narrow_line", "∫ ρ D65 ȳ dλ", card(narrow), color(|nm| line(nm) * d65(nm))[1])
            .samples(1 << 14),
        ClosedForm::new("narrow_line_x", "chromaticity of ρ D65", card(narrow), x(|nm| line(nm) * d65(nm)))
            .measure(chromaticity)
            .samples(1 << 14),
    ];
    let upsampled = "the reflectance fitted to a colour has that colour under D65 (Jakob & Hanika 2019)";
    let channels: [(&str, f64, Measure); 3] =
        [("red", 0.6, |i| mean(i, "R")), ("green", 0.3, |i| mean(i, "G")), ("blue", 0.1, |i| mean(i, "B"))];
    for (name, expected, measure) in channels {
        let case = ClosedForm::new(format!("upsampled_{name}"), upsampled, card(orange), expected);
        cases.push(case.measure(measure).margin(0.0025).samples(1 << 14));
    }
    let in_band = |name: &str, kelvin: f64, responses: &str, expected: f64| {
        let film =
            film(1, 1).replace("hdrfilm", "specfilm").replace("</film>", &format!("{responses}</film>"));
        let scene = wall(&body(kelvin)).replace(&self::film(1, 1), &film);
        ClosedForm::new(name, "∫ L(λ)s(λ) dλ of a spectral film's band", scene, expected).samples(1 << 14)
    };
    let bands: [(&str, Spectrum, Measure); 2] = [
        ("band_triangle", |nm| (1.0 - (nm - 450.0).abs() / 50.0).max(0.0), |i| mean(i, "S0.450,000nm")),
        ("band_box", |nm| if (600.0..=700.0).contains(&nm) { 0.5 } else { 0.0 }, |i| mean(i, "S0.650,000nm")),
    ];
    let visible = "<spectrum name=\"triangle\" value=\"400:0, 450:1, 500:0\"/>\
                   <spectrum name=\"box\" value=\"600:0.5, 700:0.5\"/>";
    for (name, response, measure) in bands {
        let expected = integral(|nm| planck(5000.0, nm) * response(nm));
        cases.push(in_band(name, 5000.0, visible, expected).measure(measure));
    }
    // Outside the visible range wavelengths are drawn from a wider range.
    let heat = "<spectrum name=\"heat\" value=\"900:0, 1000:1, 1100:0\"/>";
    let expected = integral_from(900.0, 4000, |nm| planck(1500.0, nm) * (1.0 - (nm - 1000.0).abs() / 100.0));
    let beyond = in_band("band_beyond_the_visible", 1500.0, heat, expected);
    cases.push(beyond.measure(|i| mean(i, "S0.1000,000nm")));
    cases.into_iter().map(ClosedForm::spectral).collect()
}

/// X, Y, Z of the image, by the inverse of the matrix that converted them to RGB.
fn xyz(image: &validation::image::Image) -> [f64; 3] {
    let rgb = ["R", "G", "B"].map(|channel| mean(image, channel));
    let to_xyz =
        [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]];
    to_xyz.map(|row| row.iter().zip(rgb).map(|(a, b)| a * b).sum())
}

/// The chromaticity coordinate x.
fn chromaticity(image: &validation::image::Image) -> f64 {
    xyz(image)[0] / xyz(image).iter().sum::<f64>()
}

/// A luminous wall.
fn wall(radiance: &str) -> String {
    let wall = shape("rectangle", &[], &emitter("area", radiance));
    scene(&[&path(1), &pointed([0.0, 0.0, 3.0], [0.1, 0.2, 0.0]), &wall])
}

/// A card under D65 with irradiance π.
fn card(reflectance: &str) -> String {
    let card = shape("rectangle", &[], &bsdf("diffuse", reflectance));
    let light = "<vector name=\"direction\" x=\"0\" y=\"0\" z=\"-1\"/>".to_string();
    let light = emitter("directional", &(light + &grey("irradiance", std::f64::consts::PI)));
    scene(&[&path(2), &pointed([0.0, 1.0, 3.0], [0.1, 0.2, 0.0]), &card, &light])
}
