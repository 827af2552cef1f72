//! Participating media: what comes straight through, what one scattering sends back, and what a lossless
//! medium does in a furnace.

use super::ClosedForm;
use super::surroundings::white;
use crate::stage::*;
use std::f64::consts::PI;

/// Extinction coefficient of the media, per unit of length.
const SIGMA: f64 = 0.7;

/// Mean cosine of the phase function.
const G: f64 = -0.3;

pub fn cases() -> Vec<ClosedForm> {
    let down = pointed([0.1, 0.2, 5.0], [0.1, 0.2, 0.0]);
    let seen = |max_depth: i64, rest: &[&str]| scene(&[&[&volpath(max_depth), &down[..]], rest].concat());
    // A slab of thickness 1 and far larger than what is seen of it.
    let slab = |medium: &str| shape("cube", &[scale([50.0, 50.0, 0.5])], &filled(medium));
    let absorbing = float("albedo", 0.0) + &float("sigma_t", SIGMA);
    let by = |phase: &str| grey("albedo", 0.8) + &float("sigma_t", SIGMA) + phase;
    let scattering = by(&henyey_greenstein());
    // Straight on and straight back, from a table: ∫ 2πp dc from −1 to 1 is 3π before it is normalised.
    let table = "<phase type=\"tabphase\"><string name=\"values\" value=\"1, 0, 2\"/></phase>";
    let tabulated = |cos: f64| if cos < 0.0 { -cos } else { 2.0 * cos } / (3.0 * PI);
    let blend = float("weight", 0.3) + &henyey_greenstein() + table;
    let mixed = by(&format!("<phase type=\"blendphase\">{blend}</phase>"));
    let white_medium = float("albedo", 1.0) + &float("sigma_t", 0.5) + &henyey_greenstein();
    let sky = constant(1.0);
    let beer = "exp(−σd) of what is behind it comes through (Beer and Lambert)";
    let back = "L = ϖ p E (1 − exp(−σd(1 + 1/cos θ)))/(1 + 1/cos θ) of light that is scattered once";
    let furnace = "a lossless medium in a furnace of radiance 1 cannot be seen (Kirchhoff)";
    let sun = |degrees: f64| {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let towards = format!("<vector name=\"direction\" x=\"{sin}\" y=\"0\" z=\"{}\"/>", -cos);
        emitter("directional", &(towards + &grey("irradiance", 1.0)))
    };
    let lit = |inside: &str, degrees: f64| seen(2, &[&slab(&medium("homogeneous", inside)), &sun(degrees)]);
    let scattered = |density: &dyn Fn(f64) -> f64, degrees: f64| {
        let cos = libm::cos(degrees.to_radians());
        let ways = 1.0 + 1.0 / cos;
        // Light goes down at θ and leaves straight up: it is turned by an angle whose cosine is −cos θ.
        0.8 * density(-cos) * (1.0 - libm::exp(-SIGMA * ways)) / ways
    };
    let of_both = |cos: f64| 0.7 * density(cos) + 0.3 * tabulated(cos);
    // The density's own unit cube, in a larger one that is empty beyond.
    let boxed = shape("cube", &[scale([3.0; 3])], &filled(&medium("heterogeneous", &absorbing)));
    let white_ball = |kind: &str| {
        let inside = medium(kind, &white_medium);
        seen(-1, &[&sphere([0.0; 3], 1.0, &filled(&inside)), &sky])
    };
    let veil = bsdf("mask", &(float("opacity", 0.3) + &diffuse(0.5)));
    let veil = shape("rectangle", &[scale([4.0; 3]), translate([0.0, 0.0, 1.0])], &veil);
    let lamp = "<point name=\"position\" x=\"3\" y=\"0.2\" z=\"2\"/>".to_string() + &grey("intensity", 1.0);
    let floor = shape("rectangle", &[scale([9.0; 3])], &diffuse(0.5));
    let aside = pointed([-3.0, -7.0, 0.5], [0.0, 0.2, 0.0]);
    let under = scene(&[&volpath(2), &aside, &floor, &veil, &emitter("point", &lamp)]);
    // One that fills its unit cube, about the camera: what is beyond `far_clip` is still seen through all of it.
    let within = pointed([0.5, 0.5, 2.0], [0.5, 0.5, 0.0]).replace(
        "</sensor>",
        &(float("far_clip", 1.25)
            + &medium("heterogeneous", &absorbing).replace("interior", "medium")
            + "</sensor>"),
    );
    let clipped = scene(&[&volpath(-1), &within, &sky]);
    let ball_of = |wears: &str| {
        let inside = medium("homogeneous", &white_medium);
        seen(-1, &[&sphere([0.0; 3], 1.0, &(wears.to_string() + &inside)), &sky])
    };
    let flint = bsdf(
        "dielectric",
        &("<string name=\"cauchy\" value=\"1.7, 0.03, 0\"/>".to_string() + &float("ext_ior", 1.0)),
    );
    let frosted =
        bsdf("roughdielectric", &(float("int_ior", 1.02) + &float("ext_ior", 1.0) + &float("alpha", 0.03)));
    let form = ClosedForm::new;
    vec![
        form("slab", beer, seen(-1, &[&slab(&medium("homogeneous", &absorbing)), &sky]), libm::exp(-SIGMA)),
        form("slab_spectral", beer, seen(-1, &[&slab(&medium("homogeneous", &absorbing)), &sky]), {
            libm::exp(-SIGMA) * white()
        })
        .spectral(),
        form("box_of_density", beer, seen(-1, &[&boxed, &sky]), libm::exp(-SIGMA)).samples(1 << 14),
        form("lit_from_above", back, lit(&scattering, 0.0), scattered(&density, 0.0)).samples(1 << 14),
        form("lit_from_aside", back, lit(&scattering, 60.0), scattered(&density, 60.0)).samples(1 << 14),
        form("lit_by_a_table", back, lit(&by(table), 60.0), scattered(&tabulated, 60.0)).samples(1 << 14),
        form("lit_by_a_mixture", back, lit(&mixed, 60.0), scattered(&of_both, 60.0)).samples(1 << 14),
        form("white_ball", furnace, white_ball("homogeneous"), 1.0).margin(0.0025).samples(1 << 14),
        form("white_ball_spectral", furnace, white_ball("homogeneous"), white())
            .spectral()
            .margin(0.0025)
            .samples(1 << 14),
        // Each time that light is dispersed, one wavelength of those that are left goes on.
        form("white_ball_in_flint_glass", furnace, ball_of(&flint), white())
            .spectral()
            .margin(0.0025)
            .samples(1 << 16),
        // Emitter samples of a surface that lets light through, into the medium and out of it.
        form("white_ball_in_frosted_glass", furnace, ball_of(&frosted), 1.0).margin(0.0025).samples(1 << 14),
        form("beyond_what_is_seen", beer, clipped, libm::exp(-SIGMA)).margin(0.0025).samples(1 << 19),
        form("white_box", furnace, white_ball("heterogeneous"), 1.0).margin(0.0025).samples(1 << 14),
        form(
            "lamp_behind_a_veil",
            "E = (1 − opacity) I cos θ/d²",
            under,
            // At (0, 0.2, 0), 3 from below the lamp that is 2 above.
            0.7 * 0.5 / PI * 2.0 / libm::pow(13.0, 1.5),
        ),
    ]
}

/// `volpath` with paths of at most `max_depth` scatterings and without roulette; −1 means no limit.
fn volpath(max_depth: i64) -> String {
    path(max_depth).replace("\"path\"", "\"volpath\"")
}

/// A medium that fills a shape with an invisible surface.
fn filled(medium: &str) -> String {
    bsdf("null", "") + medium
}

fn medium(kind: &str, parameters: &str) -> String {
    format!("<medium type=\"{kind}\" name=\"interior\">{parameters}</medium>")
}

fn henyey_greenstein() -> String {
    format!("<phase type=\"hg\">{}</phase>", float("g", G))
}

/// Henyey and Greenstein's phase function in sr⁻¹, for light that is turned by an angle of this cosine.
fn density(cos: f64) -> f64 {
    (1.0 - G * G) / (4.0 * PI * libm::pow(1.0 + G * G - 2.0 * G * cos, 1.5))
}
