//! Tests that every texture must pass, on every example of the registry and on a picture.

use super::*;
use crate::scene::xml;

/// Of linear sRGB.
const LUMINANCE: [f64; 3] = [0.212671, 0.715160, 0.072169];

/// Places to each side of the unit square, so that the mean over them is that over the square.
const SIDE: u32 = 64;

fn places() -> impl Iterator<Item = DVec2> {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    (0..SIDE * SIDE).map(move |i| DVec2::new(at(i % SIDE), at(i / SIDE)))
}

fn wavelengths(mode: ColorMode) -> Vec<Wavelengths> {
    match mode {
        ColorMode::Rgb => vec![Wavelengths::rgb()],
        ColorMode::Spectral => {
            (0..16).map(|i| Wavelengths::sample_visible((f64::from(i) + 0.5) / 16.0)).collect()
        }
    }
}

/// Calls `f` with every example in both modes, as a light: what is no reflectance is one too.
fn each(mut f: impl FnMut(&str, &AnyTexture, ColorMode)) {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("picture.png");
    let levels = [[20, 200, 90], [250, 10, 128], [0, 60, 255], [99, 99, 98]];
    let rgb = crate::image::Rgb8 { width: 2, height: 2, pixels: levels.to_vec() };
    crate::image::write_png(&picture, &rgb).unwrap();
    let file = format!(
        "<texture type=\"bitmap\"><string name=\"filename\" value=\"{}\"/></texture>",
        picture.display()
    );
    let examples = TEXTURES.iter().flat_map(|entry| entry.examples.iter().map(|e| (*e).to_owned()));
    for example in examples.chain([file]) {
        for mode in [ColorMode::Spectral, ColorMode::Rgb] {
            let text = format!("<scene version=\"3.0.0\">{example}</scene>");
            let document = xml::read_text("example.xml", &text).unwrap();
            let loader = Loader::new(&document, mode).unwrap();
            let texture = AnyTexture::parse(&document.root.children[0], &loader, Usage::Unbounded);
            let texture = texture.unwrap_or_else(|e| panic!("{e}"));
            f(&format!("{} {example}", mode.name()), &texture, mode);
        }
    }
}

#[test]
fn no_value_is_above_the_bound_or_below_zero() {
    each(|name, texture, mode| {
        for λ in wavelengths(mode) {
            for value in places().flat_map(|uv| texture.eval(uv, &λ).0) {
                assert!((0.0..=texture.bound() * 1.00001).contains(&value), "{name}: {value}");
            }
        }
    });
}

#[test]
fn what_does_not_vary_is_the_same_everywhere() {
    each(|name, texture, mode| {
        let values = |uv| wavelengths(mode).iter().map(|λ| texture.eval(uv, λ).0).collect::<Vec<_>>();
        let first = values(DVec2::ZERO);
        assert_eq!(texture.varies(), places().any(|uv| values(uv) != first), "{name}");
        assert!(texture.constant().is_none() || !texture.varies(), "{name}");
    });
}

/// The mean chooses between lobes and lights, the luminance makes tints: in three channels both are plain sums.
#[test]
fn means_and_luminances_are_those_of_the_values() {
    let count = f64::from(SIDE * SIDE);
    each(|name, texture, mode| {
        if mode != ColorMode::Rgb {
            return;
        }
        let rgb = |uv| {
            let [r, g, b, ..] = texture.eval(uv, &Wavelengths::rgb()).0;
            [r, g, b].map(f64::from)
        };
        let luminance = |uv| rgb(uv).iter().zip(LUMINANCE).map(|(c, weight)| c * weight).sum::<f64>();
        for uv in places() {
            let (found, expected) = (texture.luminance(uv), luminance(uv));
            assert!((found - expected).abs() <= 1e-6 * expected, "{name}: {found} {expected}");
        }
        // A picture keeps one number of a texel besides its colour.
        let of = |uv| match texture {
            AnyTexture::Bitmap(_) => luminance(uv),
            _ => rgb(uv).iter().sum::<f64>() / 3.0,
        };
        let (found, expected) = (texture.mean(), places().map(of).sum::<f64>() / count);
        assert!((found - expected).abs() <= 1e-6 * expected, "{name}: {found} {expected}");
    });
}

#[test]
fn gradients_are_slopes() {
    // Places lie twice as far from the nearest line at which slopes change.
    const STEP: f64 = 1.0 / 256.0;
    each(|name, texture, _| {
        let texture = texture.clone().scalar();
        for uv in places() {
            let Some(gradient) = texture.gradient(uv) else { continue };
            let slope =
                |by: DVec2| (texture.eval_scalar(uv + by) - texture.eval_scalar(uv - by)) / (2.0 * STEP);
            let found = DVec2::new(slope(DVec2::X * STEP), slope(DVec2::Y * STEP));
            assert!((found - gradient).length() < 1e-4, "{name}: {uv}: {found} {gradient}");
        }
    });
}
