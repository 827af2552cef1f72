//! Spectral lines, gaps and the ends of the visible range.

use super::Case;
use crate::closed_forms::ClosedForm;
use crate::closed_forms::interfaces::{SKY, reflectance, stage};
use crate::stage::*;
use etalon::render::Settings;
use etalon::spectrum::ColorMode;
use etalon::spectrum::observer::luminance;
use validation::image::Image;
use validation::statistics::worst_of;

/// Luminance of an equal-energy spectrum of 1 per nm over 550 nm ± 0.05: ȳ(550) over the observer's
/// normalisation.
const LINE: f64 = 0.1 * 0.994_950_1 / 106.750_259_399_414_06;

pub fn cases() -> Vec<Case> {
    let line = |radiance: &str| {
        wall(&spectrum("radiance", "549.9, 549.95, 550.05, 550.1", radiance)).replace(BANDS, &film(1, 1))
    };
    let mut answers = vec![
        ClosedForm::new(
            "line_of_0.1_nm",
            "∫ L ȳ dλ of a line 0.1 nm wide, with flanks of 0.05 nm; f32 places them to 3·10⁻⁵ nm",
            line("0, 1e4, 1e4, 0"),
            1.5e4 * LINE,
        )
        .measure(|image| luminance(["R", "G", "B"].map(|channel| of(image, channel))))
        .margin(0.0025)
        .samples(1 << 18),
    ];
    let equal = "<spectrum name=\"radiance\" type=\"uniform\"><float name=\"value\" value=\"1\"/></spectrum>";
    let ends: [(&str, f64, crate::closed_forms::Measure); 2] = [
        ("violet_end", 5.0, |image| of(image, "S0.365,000nm")),
        ("red_end", 5.0, |image| of(image, "S0.825,000nm")),
    ];
    for (name, expected, measure) in ends {
        let case =
            ClosedForm::new(name, "∫ s dλ of a band of 10 nm at an end of the range", wall(equal), expected);
        answers.push(case.measure(measure).margin(0.01).samples(1 << 16));
    }
    answers.push(dispersion());
    let mut cases: Vec<Case> = answers.into_iter().map(|case| Case::answer(case.spectral())).collect();
    cases.push(Case::at_most(
        "empty_band",
        "light beyond 600 nm leaves the bands about 365 and 550 nm black: their largest value",
        0.0,
        Box::new(|_| empty()),
    ));
    cases
}

/// Two bands at the ends and one in the middle.
const BANDS: &str = "<film type=\"specfilm\"><integer name=\"width\" value=\"1\"/><integer name=\"height\" value=\"1\"/>\
     <rfilter type=\"box\"/><spectrum name=\"violet\" value=\"360:0.5, 370:0.5\"/>\
     <spectrum name=\"green\" value=\"500:1, 600:1\"/><spectrum name=\"red\" value=\"820:0.5, 830:0.5\"/></film>";

/// The mean of a channel; NaN if there is none of this name.
fn of(image: &Image, name: &str) -> f64 {
    let found = image.channels.iter().find(|c| c.name == name);
    found.map_or(f64::NAN, |c| c.mean.iter().sum::<f64>() / c.mean.len() as f64)
}

fn spectrum(name: &str, wavelengths: &str, values: &str) -> String {
    format!(
        "<spectrum name=\"{name}\" type=\"irregular\"><string name=\"wavelengths\" value=\"{wavelengths}\"/>\
         <string name=\"values\" value=\"{values}\"/></spectrum>"
    )
}

fn wall(radiance: &str) -> String {
    let wall = shape("rectangle", &[], &emitter("area", radiance));
    scene(&[&path(1), &pointed([0.0, 0.0, 3.0], [0.1, 0.2, 0.0]), &wall]).replace(&film(1, 1), BANDS)
}

/// Reflection at glass whose index decreases from 3 to 1.2 over the green band.
fn dispersion() -> ClosedForm {
    let glass = bsdf(
        "dielectric",
        "<spectrum name=\"int_ior\" value=\"360:3, 500:3, 600:1.2, 830:1.2\"/><float name=\"ext_ior\" value=\"1\"/>",
    );
    let pane = shape("rectangle", &[scale([100.0; 3])], &glass);
    let equal = "<spectrum name=\"radiance\" type=\"uniform\"><float name=\"value\" value=\"1\"/></spectrum>";
    let scene = stage(45.0, SKY, &pane).replace(&grey("radiance", 1.0), equal).replace(&film(1, 1), BANDS);
    const STEPS: i32 = 10_000;
    let index = |i: i32| 3.0 - 1.8 * (f64::from(i) + 0.5) / f64::from(STEPS);
    let mean = (0..STEPS).map(|i| reflectance(45.0, index(i))).sum::<f64>() / f64::from(STEPS);
    ClosedForm::new("strong_dispersion", "∫ R(n(λ)) s dλ, n from 3 to 1.2 in 100 nm", scene, 100.0 * mean)
        .measure(|image| of(image, "S0.550,000nm"))
        .margin(0.01)
        .samples(1 << 18)
}

fn empty() -> Result<f64, String> {
    let scene = load(&wall(&spectrum("radiance", "601, 602, 830", "0, 1, 1")), ColorMode::Spectral)?;
    let settings = Settings { seed: 1, ..Settings::of(&scene, 0..4096) };
    let image = measured(&expose(&scene, &settings)?);
    let [violet, green, red] = ["S0.365,000nm", "S0.550,000nm", "S0.825,000nm"].map(|name| of(&image, name));
    if red > 0.0 { Ok(worst_of(violet, green)) } else { Err(format!("the red band has {red}")) }
}
