//! Lossless objects in uniform light, which must be invisible: to 10⁻⁴, in RGB and in spectral mode, and
//! wavelength by wavelength where they disperse.

use super::ClosedForm;
use super::{mean, surroundings::white};
use crate::stage::*;
use validation::microfacet::{Rough, Slopes};

const INVISIBLE: &str = "a lossless body in a furnace of radiance 1 cannot be seen (Kirchhoff)";

/// The largest deviation from the background that counts as none.
const MARGIN: f64 = 1e-4;

pub fn cases() -> Vec<ClosedForm> {
    let glass = |eta: f64| bsdf("dielectric", &(float("int_ior", eta) + &float("ext_ior", 1.0)));
    let rough = |law: &str, alpha: f64| {
        let law = format!("<string name=\"distribution\" value=\"{law}\"/>");
        bsdf(
            "roughdielectric",
            &(law + &float("alpha", alpha) + &float("int_ior", 1.5) + &float("ext_ior", 1.0)),
        )
    };
    let schlick = "<string name=\"fresnel\" value=\"schlick\"/>";
    let ball = |wears: &str| sphere([0.0; 3], 1.0, wears);
    let mut cases = vec![];
    for (name, body, samples) in [
        ("mirror_ball", ball(&bsdf("conductor", "")), 8),
        ("glass_ball", ball(&glass(1.5)), 8),
        ("glass_ball_schlick", ball(&glass(1.5).replace("</bsdf>", &format!("{schlick}</bsdf>"))), 8),
        ("diamond_ball", ball(&glass(2.4)), 8),
        ("bubble", ball(&glass(0.75)), 8),
        ("thin_ball", ball(&bsdf("thindielectric", &float("int_ior", 1.5))), 8),
        // The rougher the surface, the more single scattering loses; at these roughnesses the loss is below
        // the margin.
        ("rough_glass_ball_beckmann", ball(&rough("beckmann", 0.005)), 12),
        ("rough_glass_ball_ggx", ball(&rough("ggx", 0.001)), 12),
    ] {
        cases.extend(both(name, scene(&[&path(-1), &portrait(), &body, &constant(1.0)]), 1 << samples));
    }
    let thin = bsdf("thindielectric", &float("int_ior", 1.5));
    for (name, wears, thickness) in [("thin_panes", thin, None), ("slabs", glass(1.5), Some(0.05))] {
        let place = pointed([3.0, 0.0, 4.0], [0.0; 3]);
        let panes: String = (0..8).map(|i| pane(&wears, -0.2 * f64::from(i), thickness)).collect();
        cases.extend(both(name, scene(&[&path(-1), &place, &panes, &constant(1.0)]), 1 << 8));
    }
    let place = pointed([-3.0, 0.0, 5.0], [0.0, 0.1, 0.05]);
    // The case tests rounding over that many bounces, so roulette, which leaves few paths of large weight, is
    // off.
    let whole = path(-1).replace("value=\"5\"", "value=\"65536\"");
    let rod = scene(&[&whole, &place, &rod(&glass(2.4)), &constant(1.0)]);
    cases.extend(both("diamond_rod_of_1000_bounces", rod, 1 << 9));
    cases.extend(dispersing());
    cases.extend(rough_mirrors());
    cases
}

/// A case in RGB, and one in spectral mode, whose white is the observer's response to D65. The only noise is
/// that of the wavelengths, which stratified samples mostly remove.
fn both(name: &str, scene: String, samples: u64) -> Vec<ClosedForm> {
    let stratified = scene.replace("</sensor>", "<sampler type=\"multijitter\"/></sensor>");
    let spectral = ClosedForm::new(format!("{name}_spectral"), INVISIBLE, stratified, white()).spectral();
    let rgb = ClosedForm::new(name, INVISIBLE, scene, 1.0);
    [rgb, spectral].map(|case| case.margin(MARGIN).samples(samples)).into()
}

/// A camera that sees a unit sphere at the origin, and some of the background.
fn portrait() -> String {
    pinhole(&look_at([0.0, -4.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]), 32.0, &film(8, 8))
}

/// A wide pane at height `z`; it is a slab of glass if it has a thickness.
fn pane(wears: &str, z: f64, thickness: Option<f64>) -> String {
    let face = |steps: &[String], z: f64| {
        let steps = [&[scale([100.0, 100.0, 1.0])], steps, &[translate([0.0, 0.0, z])]].concat();
        shape("rectangle", &steps, wears)
    };
    match thickness {
        None => face(&[], z),
        Some(thickness) => face(&[], z) + &face(&[rotate('x', 180.0)], z - thickness),
    }
}

/// A rod of radius 1 along +x, from 0 to 6000, closed by two disks. A ray that enters at 59° to its axis
/// continues at asin(sin 59°/2.4) = 21° and meets the wall at least once in 2/tan 21° = 5.2 lengths: 1150
/// times, always with total reflection, before it reaches the other end; one in six turns back there.
fn rod(wears: &str) -> String {
    const LENGTH: f64 = 6000.0;
    let wall = format!(
        "<shape type=\"cylinder\"><point name=\"p0\" x=\"0\" y=\"0\" z=\"0\"/>\
         <point name=\"p1\" x=\"{LENGTH}\" y=\"0\" z=\"0\"/>{wears}</shape>"
    );
    let end = |degrees: f64, x: f64| shape("disk", &[rotate('y', degrees), translate([x, 0.0, 0.0])], wears);
    wall + &end(-90.0, 0.0) + &end(90.0, LENGTH)
}

/// Seen from within a bubble in a ball of SF11, in three bands of wavelengths. All light has been refracted,
/// and its wavelengths separated, before it arrives; and the weight of every path is 1. So an image's value
/// depends on no random number but that of the wavelength, over which a stratified sampler integrates almost
/// exactly.
fn dispersing() -> Vec<ClosedForm> {
    let glass = bsdf("dielectric", "<string name=\"dispersion\" value=\"sf11\"/>");
    let inwards = format!("<boolean name=\"flip_normals\" value=\"true\"/>{glass}");
    let shell = sphere([0.0; 3], 2.0, &glass) + &sphere([0.0; 3], 1.0, &inwards);
    let film = "<film type=\"specfilm\"><integer name=\"width\" value=\"1\"/><integer name=\"height\" value=\"1\"/>\
                <spectrum name=\"blue\" value=\"400:0, 460:1, 520:0\"/>\
                <spectrum name=\"green\" value=\"490:0, 550:1, 610:0\"/>\
                <spectrum name=\"red\" value=\"560:0, 620:1, 680:0\"/><rfilter type=\"box\"/></film>\
                <sampler type=\"multijitter\"/>";
    let camera = pinhole(&look_at([0.2, -0.1, 0.1], [0.3, 0.0, 0.4], [0.0, 0.0, 1.0]), 1e-3, film);
    let light = emitter(
        "constant",
        "<spectrum name=\"radiance\" type=\"uniform\"><float name=\"value\" value=\"1\"/></spectrum>",
    );
    let scene = scene(&[&path(-1), &camera, &shell, &light]);
    let bands: [(&str, u64, super::Measure); 3] = [
        ("blue", 1 << 19, |image| mean(image, "S0.460,000nm")),
        ("green", 1 << 18, |image| mean(image, "S0.550,000nm")),
        ("red", 1 << 18, |image| mean(image, "S0.620,000nm")),
    ];
    let case = |(band, samples, measure): (&str, u64, super::Measure)| {
        let source =
            "∫ of a band's sensitivity, whatever disperses before a furnace of radiance 1 per nanometre";
        let case = ClosedForm::new(format!("dispersing_shell_{band}"), source, scene.clone(), 60.0);
        case.spectral().measure(measure).margin(MARGIN).samples(samples)
    };
    bands.map(case).into()
}

/// Mirrors that are not lossless in one bounce: a rough mirror shows the albedo of single scattering, by
/// quadrature of its definition.
fn rough_mirrors() -> Vec<ClosedForm> {
    let source =
        "∫ D G₂/(4 cos θₒ) dω, what single scattering leaves of a furnace (Walter et al. 2007, eq. 20)";
    let case = |(law, slopes, alpha): (&str, Slopes, f64)| {
        let wears = bsdf(
            "roughconductor",
            &(format!("<string name=\"distribution\" value=\"{law}\"/>") + &float("alpha", alpha)),
        );
        let plane = shape("rectangle", &[scale([100.0, 100.0, 1.0])], &wears);
        let degrees = 60.0f64;
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let camera = pointed([5.0 * sin, 0.0, 5.0 * cos], [0.0; 3]);
        let expected = Rough { slopes, alpha, eta: None }.albedo(cos, 1e-6).value;
        let scene = scene(&[&path(-1), &camera, &plane, &constant(1.0)]);
        ClosedForm::new(format!("rough_mirror_{law}_{alpha}"), source, scene, expected).samples(1 << 14)
    };
    [("ggx", Slopes::Ggx, 0.1), ("ggx", Slopes::Ggx, 0.5), ("beckmann", Slopes::Beckmann, 0.5)]
        .map(case)
        .into()
}
