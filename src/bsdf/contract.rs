//! Tests that every material must pass, on every example of the registry.

use super::*;
use crate::math::length;
use crate::scene::catalogue::catalogue;
use crate::scene::xml;
use crate::spectrum::ColorMode;
use std::f64::consts::{PI, TAU};

/// Angles of views in degrees: from the normal, and about it.
const VIEWS: [(f64, f64); 6] =
    [(0.0, 0.0), (25.0, 40.0), (60.0, 110.0), (85.0, 200.0), (130.0, 300.0), (170.0, 20.0)];

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((sin, cos), (y, x)) = (libm::sincos(theta), libm::sincos(phi));
    DVec3::new(sin * x, sin * y, cos)
}

fn views() -> impl Iterator<Item = DVec3> {
    VIEWS.into_iter().map(|(theta, phi)| direction(theta.to_radians(), phi.to_radians()))
}

/// All views from all views.
fn pairs() -> impl Iterator<Item = (DVec3, DVec3)> {
    views().flat_map(|wo| views().map(move |wi| (wo, wi)))
}

/// Parses a snippet, or says why it cannot be.
fn parse(snippet: &str, mode: ColorMode) -> Result<AnyMaterial, String> {
    let text = format!("<scene version=\"3.0.0\">{snippet}</scene>");
    let document = xml::read_text("example.xml", &text).map_err(|e| e.to_string())?;
    let loader = Loader::new(&document, mode).map_err(|e| e.to_string())?;
    AnyMaterial::parse(&document.root.children[0], &loader).map_err(|e| e.to_string())
}

/// Calls `f` with every example in both modes.
fn each(mut f: impl FnMut(&str, &AnyBsdf, &AnyMaterial, &Wavelengths)) {
    let point = SurfacePoint::flat();
    for snippet in MATERIALS.iter().flat_map(|entry| entry.examples) {
        for (mode, λ) in
            [(ColorMode::Spectral, Wavelengths::sample_visible(0.03)), (ColorMode::Rgb, Wavelengths::rgb())]
        {
            let material = parse(snippet, mode).unwrap_or_else(|e| panic!("{snippet}: {e}"));
            f(&format!("{} {snippet}", mode.name()), &material.at(&point, &λ), &material, &λ);
        }
    }
}

/// The centres of a grid over the three numbers that samples are made from.
fn grid(n: usize, lobes: usize) -> impl Iterator<Item = (f64, DVec2)> {
    let centre = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    (0..lobes).flat_map(move |l| {
        (0..n * n).map(move |i| (centre(l, lobes), DVec2::new(centre(i / n, n), centre(i % n, n))))
    })
}

/// Point `i` of an even sequence in three dimensions: multiples of powers of 1/g with g⁴ = g + 1 (Roberts
/// 2018).
fn lattice(i: usize) -> (f64, DVec2) {
    const G: f64 = 1.220_744_084_605_759_5;
    let part = |step: f64| (0.5 + i as f64 * step).fract();
    (part(1.0 / G), DVec2::new(part(1.0 / (G * G)), part(1.0 / (G * G * G))))
}

#[test]
fn weights_are_values_over_densities() {
    each(|name, bsdf, _, _| {
        for wo in views().chain([direction(89.99f64.to_radians(), 1.0)]) {
            for (lobe, u) in grid(12, 8) {
                let Some(s) = bsdf.sample(wo, lobe, u).filter(|s| !s.delta) else { continue };
                let e = bsdf.evaluate(wo, s.wi);
                assert!((length(s.wi) - 1.0).abs() < 1e-12, "{name}: {wo} to {}", s.wi);
                assert!((e.pdf / s.pdf - 1.0).abs() < 1e-5, "{name}: {wo} to {}: {} {}", s.wi, e.pdf, s.pdf);
                for (value, weight) in e.value.0.iter().zip(s.weight.0) {
                    let expected = *value as f64 / e.pdf;
                    assert!(
                        (weight as f64 - expected).abs() <= 1e-5 * expected,
                        "{name}: {weight} {expected}"
                    );
                }
            }
        }
    });
}

/// Where a material neither transmits nor has a relief, light is sampled from the hemisphere that ωo is in
/// alone.
#[test]
fn opaque_materials_gather_light_from_one_side() {
    let mut count = 0;
    each(|name, bsdf, material, _| {
        let traits = material.traits();
        if traits.transmits || traits.relief {
            return;
        }
        count += 1;
        for (wo, wi) in pairs() {
            let value = bsdf.evaluate(wo, wi).value;
            assert!(wo.z * wi.z > 0.0 || value.is_zero(), "{name}: {wo} from {wi}: {value:?}");
        }
    });
    assert!(count > 0);
}

#[test]
fn materials_of_one_lobe_do_not_choose() {
    let mut count = 0;
    each(|name, bsdf, material, _| {
        if !material.traits().one_lobe {
            return;
        }
        count += 1;
        let sample = |wo, lobe, u| bsdf.sample(wo, lobe, u).map(|s| (s.wi, s.weight.0, s.pdf));
        for wo in views() {
            for (lobe, u) in grid(6, 8) {
                assert_eq!(sample(wo, lobe, u), sample(wo, 0.0, u), "{name}");
            }
        }
    });
    assert!(count > 0);
}

/// What is known of a material decides what is left out where it is: kernels, media, techniques.
#[test]
fn samples_are_what_the_traits_say() {
    each(|name, bsdf, material, _| {
        let traits = material.traits();
        for wo in views() {
            for (lobe, u) in grid(6, 16) {
                let Some(s) = bsdf.sample(wo, lobe, u) else { continue };
                let [straight, mirrored] = [-wo, mirror(wo)].map(|w| length(s.wi - w) < 1e-9);
                let passes = s.wi.z * wo.z < 0.0;
                assert!(!s.null || traits.has_null && s.delta && straight, "{name}: {wo} {s:?}");
                assert!(!s.dispersed || traits.dispersive, "{name}: {wo} {s:?}");
                assert!(!passes || traits.transmits, "{name}: {wo} {s:?}");
                assert!(!traits.mirrors || passes || s.delta && mirrored, "{name}: {wo} {s:?}");
                assert!(!traits.refracts || !passes || s.delta, "{name}: {wo} {s:?}");
                assert!(!traits.only_rough || !passes && !s.delta, "{name}: {wo} {s:?}");
            }
        }
    });
}

#[test]
fn null_transmission_is_what_samples_bring_straight_on() {
    const DRAWS: usize = 1 << 12;
    let mut count = 0;
    each(|name, bsdf, material, _| {
        let passes = |i: usize, wo| {
            let (lobe, u) = lattice(i);
            bsdf.sample(wo, lobe, u).filter(|s| s.null).map_or(Spectrum::ZERO, |s| s.weight)
        };
        for wo in views() {
            let expected = bsdf.null_transmission(wo);
            assert!(material.traits().has_null || expected.is_zero(), "{name}: {expected:?}");
            let found = (0..DRAWS).fold(Spectrum::ZERO, |sum, i| sum + passes(i, wo)) * (1.0 / DRAWS as f32);
            for (found, expected) in found.0.into_iter().zip(expected.0) {
                assert!((found - expected).abs() < 2e-3, "{name}: {wo}: {found} {expected}");
            }
            count += u32::from(!expected.is_zero());
        }
    });
    assert!(count > 0);
}

#[test]
fn what_has_an_albedo_obeys_lamberts_law() {
    let mut count = 0;
    each(|name, bsdf, _, _| {
        let Some(albedo) = bsdf.albedo() else { return };
        count += 1;
        for (wo, wi) in pairs().filter(|(wo, _)| wo.z > 0.0) {
            let found = bsdf.evaluate(wo, wi);
            let pdf = wi.z.max(0.0) / PI;
            assert!((found.pdf - pdf).abs() < 1e-12, "{name}: {wo} from {wi}");
            for (value, albedo) in found.value.0.into_iter().zip(albedo.0) {
                assert!((f64::from(value) - f64::from(albedo) * pdf).abs() < 1e-6, "{name}: {wo} from {wi}");
            }
        }
    });
    assert!(count > 0);
}

/// By which emitters are chosen: what follows the cosine must keep a part.
#[test]
fn lobes_leave_a_part_to_the_cosine() {
    let mut count = 0;
    each(|name, bsdf, _, _| {
        for lobe in views().map(|wo| bsdf.lobe(wo)) {
            assert!((0.0..1.0).contains(&lobe.share) && lobe.alpha2 > 0.0, "{name}: {lobe:?}");
            assert!(lobe.share == 0.0 || (length(lobe.axis) - 1.0).abs() < 1e-12, "{name}: {lobe:?}");
            count += u32::from(lobe.share > 0.0);
        }
    });
    assert!(count > 0);
}

#[test]
fn only_anisotropic_materials_know_the_tangent() {
    let mut count = 0;
    each(|name, bsdf, material, _| {
        if material.traits().anisotropic {
            return;
        }
        count += 1;
        let (sin, cos) = libm::sincos(2.1);
        let turned = |w: DVec3| DVec3::new(cos * w.x - sin * w.y, sin * w.x + cos * w.y, w.z);
        for (wo, wi) in pairs() {
            let [found, other] = [bsdf.evaluate(wo, wi), bsdf.evaluate(turned(wo), turned(wi))];
            for (a, b) in found.value.0.into_iter().zip(other.value.0) {
                assert!((a - b).abs() <= 1e-4 * a.abs(), "{name}: {wo} from {wi}: {a} {b}");
            }
            assert!((found.pdf - other.pdf).abs() <= 1e-4 * found.pdf, "{name}: {wo} from {wi}");
        }
    });
    assert!(count > 0);
}

/// A material without any density gets the number that chooses the lobe from those of the direction.
#[test]
fn materials_without_density_draw_no_direction() {
    let mut count = 0;
    each(|name, bsdf, material, _| {
        if material.traits().has_density {
            return;
        }
        count += 1;
        let sample = |wo, lobe, u| bsdf.sample(wo, lobe, u).map(|s| (s.wi, s.weight.0, s.pdf));
        for wo in views() {
            for (lobe, u) in grid(6, 8) {
                assert_eq!(sample(wo, lobe, u), sample(wo, lobe, DVec2::ZERO), "{name}");
            }
        }
    });
    assert!(count > 0);
}

/// The density has the mass and the first moments of the samples.
#[test]
fn densities_are_those_of_the_samples() {
    each(|name, bsdf, _, λ| {
        if λ.mode() == ColorMode::Rgb {
            return;
        }
        for wo in views() {
            let moments = |w: DVec3| [1.0, w.x, w.y, w.z, w.z * w.z];
            let mut integral = [0.0; 5];
            const N: usize = 512;
            for i in 0..N {
                let theta = PI * (i as f64 + 0.5) / N as f64;
                for j in 0..N {
                    let wi = direction(theta, TAU * (j as f64 + 0.5) / N as f64);
                    let mass = bsdf.evaluate(wo, wi).pdf * libm::sin(theta) * PI * TAU / (N * N) as f64;
                    for (sum, m) in integral.iter_mut().zip(moments(wi)) {
                        *sum += m * mass;
                    }
                }
            }
            let mut mean = [0.0; 5];
            const SAMPLES: usize = 1 << 16;
            for (lobe, u) in (0..SAMPLES).map(lattice) {
                if let Some(s) = bsdf.sample(wo, lobe, u).filter(|s| !s.delta) {
                    for (sum, m) in mean.iter_mut().zip(moments(s.wi)) {
                        *sum += m / SAMPLES as f64;
                    }
                }
            }
            // What 2¹⁶ points and this grid resolve; with sixteen times as many of both, all agree to 5e-4.
            for (a, b) in integral.iter().zip(mean) {
                assert!((a - b).abs() < 1e-2, "{name} at {wo}: {integral:?} {mean:?}");
            }
        }
    });
}

#[test]
fn nothing_gives_more_light_than_it_gets() {
    each(|name, bsdf, _, λ| {
        for wo in views() {
            let mut sum = [0.0; 8];
            let mut count = 0.0;
            for (lobe, u) in (0..1 << 15).map(lattice) {
                count += 1.0;
                if let Some(s) = bsdf.sample(wo, lobe, u) {
                    // Radiance grows with the square of the index; power does not. One dispersed wavelength
                    // stands for eight.
                    let share = if s.dispersed { 0.125 } else { 1.0 };
                    for (sum, w) in sum.iter_mut().zip(s.weight.0) {
                        *sum += share * w as f64 * s.eta * s.eta;
                    }
                }
            }
            let lanes = if λ.mode() == ColorMode::Rgb { 3 } else { 8 };
            for albedo in &sum[..lanes] {
                assert!(albedo / count <= 1.0 + 1e-3, "{name} at {wo}: {}", albedo / count);
            }
        }
    });
}

/// The snippet with a checkered parameter, instead of a number or colour of that name.
fn checkered(snippet: &str, parameter: &str) -> Option<String> {
    let name = |name: &str| format!("name=\"{name}\"");
    let texture = |parameter: &str| format!("<texture type=\"checkerboard\" {}/>", name(parameter));
    // A roughness along the tangent comes with one across.
    let more: String = match parameter {
        "alpha_u" | "alpha_v" => ["alpha_u", "alpha_v"].map(texture).concat(),
        _ => texture(parameter),
    };
    let end = snippet.find('>')?;
    let (head, rest) = match snippet[..end].strip_suffix('/') {
        Some(head) => (head, "</bsdf>"),
        None => (&snippet[..end], &snippet[end + 1..]),
    };
    let Some(at) = rest.find(&name(parameter)) else { return Some(format!("{head}>{more}{rest}")) };
    let (begin, length) = (rest[..at].rfind('<')?, rest[at..].find('>')? + 1);
    let plain = rest[..at + length].ends_with("/>");
    plain.then(|| format!("{head}>{more}{}{}", &rest[..begin], &rest[at + length..]))
}

/// A kernel without textures knows no place on the surface: a material that needs one must say so.
#[test]
fn whatever_is_checkered_is_textured() {
    for model in catalogue().iter().filter(|model| model.kind == "bsdf") {
        // A checkerboard has no normals.
        let checkerable = |name: &str| name != "normalmap";
        let textures = model.parameters.iter().filter(|p| p.kind == "texture" && checkerable(p.name));
        for parameter in textures.map(|parameter| parameter.name) {
            let snippets = model.examples.iter().filter_map(|snippet| checkered(snippet, parameter));
            let materials: Vec<AnyMaterial> =
                snippets.filter_map(|snippet| parse(&snippet, ColorMode::Rgb).ok()).collect();
            assert!(!materials.is_empty(), "{}: no example takes a checkered `{parameter}`", model.name);
            let textured = materials.iter().all(|material| material.traits().textured);
            assert!(textured, "{} with a checkered `{parameter}`", model.name);
        }
    }
}

#[test]
fn grazing_directions_are_finite() {
    each(|name, bsdf, _, _| {
        let grazing =
            [89.99, 89.999_999, 90.000_001, 90.0 - 1e-13].map(|d: f64| direction(d.to_radians(), 0.7));
        for wo in grazing.into_iter().chain(views()) {
            for (lobe, u) in grid(8, 5).chain([(0.0, DVec2::ZERO), (1.0 - 1e-16, DVec2::splat(1.0 - 1e-16))])
            {
                if let Some(s) = bsdf.sample(wo, lobe, u) {
                    assert!(s.weight.is_finite() && s.pdf.is_finite() && s.pdf > 0.0, "{name}: {wo} {s:?}");
                }
            }
            for wi in grazing.into_iter().chain([wo, -wo, mirror(wo), mirror(-wo)]) {
                let e = bsdf.evaluate(wo, wi);
                assert!(e.value.is_finite() && e.pdf.is_finite() && e.pdf >= 0.0, "{name}: {wo} {wi} {e:?}");
                assert!(e.value.0.iter().all(|v| *v >= 0.0), "{name}: {wo} {wi} {e:?}");
            }
        }
    });
}

#[test]
fn wrong_descriptions_are_refused_with_reasons() {
    let glass = r#"<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>"#;
    for (snippet, reason) in [
        (glass, "two-sided"),
        (r#"<bsdf type="twosided"/>"#, "no nested"),
        (
            r#"<bsdf type="blendbsdf"><float name="weight" value="0.5"/><bsdf type="diffuse"/></bsdf>"#,
            "two materials",
        ),
        (r#"<bsdf type="roughconductor"><float name="alpha_u" value="0.1"/></bsdf>"#, "alpha_v"),
        (r#"<bsdf type="roughconductor"><string name="distribution" value="phong"/></bsdf>"#, "phong"),
        (r#"<bsdf type="conductor"><string name="material" value="Gold"/></bsdf>"#, "Gold"),
        (r#"<bsdf type="dielectric"><string name="int_ior" value="glas"/></bsdf>"#, "glas"),
        (r#"<bsdf type="dielectric"><float name="int_ior" value="-1"/></bsdf>"#, "no index"),
        (r#"<bsdf type="dielectric"><string name="sellmeier" value="1 2 3"/></bsdf>"#, "3 numbers"),
        (r#"<bsdf type="dielectric"><string name="cauchy" value="-1 0 0"/></bsdf>"#, "at 360 nm"),
        (
            r#"<bsdf type="roughdielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1"/></bsdf>"#,
            "same on both sides",
        ),
    ] {
        let refusal =
            parse(snippet, ColorMode::Spectral).err().unwrap_or_else(|| panic!("{snippet} was accepted"));
        assert!(refusal.contains(reason), "{snippet}: {refusal}");
    }
}
