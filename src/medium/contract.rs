//! Tests that every medium must pass, on every example of the registry and on a grid.

use super::*;
use crate::math::DVec3;
use crate::sampler::{Sampler, SamplerKind, blocks};
use crate::scene::catalogue::versioned;
use crate::scene::loader::Loader;
use crate::scene::xml;
use crate::spectrum::ColorMode;

/// A medium of a density that rises from 0.25 to 1.75 along x, by eight cells.
fn on_a_grid(folder: &std::path::Path) -> String {
    let values: Vec<f32> = (0..8 * 2 * 3).map(|i| 0.2 * (i % 8) as f32 + 0.25).collect();
    let path = folder.join("rising.vol");
    std::fs::write(&path, crate::volume::file_of([8, 2, 3], 1, &values)).unwrap();
    format!(
        r#"<medium type="heterogeneous"><float name="scale" value="3"/><rgb name="albedo" value="0.9, 0.5, 0.2"/>
        <volume type="gridvolume" name="sigma_t"><string name="filename" value="{}"/></volume></medium>"#,
        path.display()
    )
}

/// Calls `f` with every example in both modes.
fn each(mut f: impl FnMut(&str, &Medium, &Wavelengths)) {
    let folder = tempfile::tempdir().unwrap();
    let examples = MEDIA.iter().flat_map(|entry| entry.examples.iter().map(|e| String::from(*e)));
    for example in examples.chain([on_a_grid(folder.path())]) {
        let text = versioned(&example);
        let document = xml::read_text("example.xml", &text).unwrap();
        for (mode, λ) in
            [(ColorMode::Spectral, Wavelengths::sample_visible(0.03)), (ColorMode::Rgb, Wavelengths::rgb())]
        {
            let loader = Loader::new(&document, mode).unwrap();
            let medium = loader.medium(&document.root).unwrap_or_else(|e| panic!("{example}: {e}"));
            f(&format!("{} {example}", mode.name()), &medium, &λ);
        }
    }
}

const COUNT: u32 = 1 << 15;
/// What so many samples of numbers up to about 1 resolve: five standard errors of numbers between 0 and 1,
/// whose weights are at most so large.
const CLOSE: f64 = 5.0 * 0.5 / 181.0;

/// What carries nothing is never looked at, so every lane carries something, but not the same.
fn carried(λ: &Wavelengths) -> Spectrum {
    Spectrum::from_fn(|i| if λ.mode() == ColorMode::Spectral || i < 3 { 0.4 + 0.2 * i as f32 } else { 0.0 })
}

/// The sampler of a sample; others of another pixel.
fn sampler(pixel: u32, sample: u32) -> Sampler {
    Sampler::new(SamplerKind::Independent, 1, (pixel, 5), sample)
}

/// A ray through the middle of the unit cube, at an angle, to this distance.
fn ray(end: f64) -> Ray {
    let ray = Ray::free(DVec3::new(-0.3, 0.2, 0.4), crate::math::frame::unit(DVec3::new(3.0, 1.0, 0.5)));
    Ray { end, ..ray }
}

/// The means over many flights of the throughput that comes through and of that which is scattered.
fn means(medium: &Medium, length: f64, λ: &Wavelengths) -> [[f64; 8]; 2] {
    let mut sums = [[0.0; 8]; 2];
    for i in 0..COUNT {
        let sampler = sampler(0, i);
        let first = (f64::from(i) + 0.5) / f64::from(COUNT);
        let mut numbers = FlightNumbers::after(first, &sampler, blocks::flight(1));
        let (which, weight) = match medium.fly(&ray(length), carried(λ), λ, &mut numbers) {
            Flight::Through(weight) => (0, weight),
            Flight::Scattered(t, weight) => {
                assert!((0.0..length).contains(&t));
                (1, weight)
            }
        };
        let (before, after) = (carried(λ), carried(λ) * weight);
        assert!(weight.0.iter().all(|w| *w >= 0.0 && w.is_finite()), "{weight:?}");
        assert!(after.sum() <= before.sum() * (1.0 + 1e-5), "{weight:?}");
        sums[which].iter_mut().zip(after.0).for_each(|(sum, v)| *sum += f64::from(v) / f64::from(COUNT));
    }
    sums
}

/// Of what a path carries, T comes through and albedo (1 − T) is scattered, whatever the lanes' shares; and T
/// is what shadow rays find.
#[test]
fn nothing_is_lost_and_nothing_is_made() {
    each(|name, medium, λ| {
        for length in [0.3, 1.5, 20.0] {
            let mut passed = [0.0; 8];
            for i in 0..COUNT {
                let sampler = sampler(1, i);
                let mut numbers = FlightNumbers::independent(&sampler, blocks::shadow_flight(1));
                let passes = medium.transmittance(&ray(length), λ, &mut numbers);
                passed.iter_mut().zip(passes.0).for_each(|(sum, v)| *sum += f64::from(v) / f64::from(COUNT));
            }
            let [through, scattered] = means(medium, length, λ);
            let albedo = medium.albedo.eval(DVec3::ZERO, λ);
            for (i, carried) in carried(λ).0.into_iter().map(f64::from).enumerate() {
                let expected = [carried * passed[i], carried * f64::from(albedo.0[i]) * (1.0 - passed[i])];
                for (found, expected) in [through[i], scattered[i]].into_iter().zip(expected) {
                    let close = (found - expected).abs() <= 2.0 * CLOSE;
                    assert!(close, "{name}: lane {i} over {length}: {found}, not {expected}");
                }
            }
        }
    });
}

/// The transmittance of what is known in closed form: exp(−σ d), d being the way within the unit cube where
/// the medium is a box; on the grid exp(−∫σ).
#[test]
fn transmittances_are_exponential() {
    let mut checked = 0;
    each(|name, medium, λ| {
        let sigma = |rate: f64| Spectrum::splat((-rate) as f32).exp().0[0];
        // The ray enters the cube at x = 0 and leaves at x = 1.
        let across = 1.0 / ray(1.0).direction.x;
        let depth = match name {
            _ if name.contains("rising.vol") => {
                // Straight lines between the middles of cells, constant beyond: the mean is (0.25 + 1.65)/2.
                3.0 * 0.95 * across
            }
            _ if name.ends_with(r#"<medium type="homogeneous"/>"#) => 2.5,
            _ if name.ends_with(r#"<medium type="heterogeneous"/>"#) => across,
            _ => return,
        };
        let mut mean = 0.0;
        for i in 0..COUNT {
            let sampler = sampler(2, i);
            let mut numbers = FlightNumbers::independent(&sampler, blocks::shadow_flight(1));
            let length = if name.contains("homogeneous") { 2.5 } else { 30.0 };
            mean += f64::from(medium.transmittance(&ray(length), λ, &mut numbers).0[1]) / f64::from(COUNT);
        }
        assert!((mean - f64::from(sigma(depth))).abs() < CLOSE, "{name}: {mean}, not {}", sigma(depth));
        checked += 1;
    });
    assert_eq!(checked, 6);
}

#[test]
fn nothing_passes_an_endless_medium_and_all_passes_nothing() {
    let mut checked = [0; 2];
    each(|name, medium, λ| {
        let sampler = sampler(2, 0);
        let mut numbers = FlightNumbers::independent(&sampler, blocks::shadow_flight(1));
        let mut passes = |length: f64| medium.transmittance(&ray(length), λ, &mut numbers);
        assert_eq!(passes(0.0), Spectrum::ONE, "{name}");
        let vacuum = name.contains(r#"name="sigma_t" value="0""#);
        let endless = name.contains(r#"type="homogeneous""#) && !name.contains("400:4");
        if endless {
            let lanes = if λ.mode() == ColorMode::Spectral { 8 } else { 3 };
            let expected = if vacuum { 1.0 } else { 0.0 };
            let all = passes(f64::INFINITY).0[..lanes].iter().all(|v| *v == expected);
            assert!(all, "{name}: {:?}", passes(f64::INFINITY));
            checked[usize::from(vacuum)] += 1;
        }
    });
    assert!(checked.iter().all(|count| *count > 0), "{checked:?}");
}

/// The albedo is that of the place where light is scattered.
#[test]
fn albedos_are_those_of_collisions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rising.vol");
    std::fs::write(&path, crate::volume::file_of([4, 1, 1], 1, &[0.1, 0.3, 0.6, 1.0])).unwrap();
    let text = format!(
        r#"<medium version="3.0.0" type="homogeneous"><volume type="gridvolume" name="albedo">
        <string name="filename" value="{}"/></volume></medium>"#,
        path.display()
    );
    let document = xml::read_text("example.xml", &text).unwrap();
    let loader = Loader::new(&document, ColorMode::Rgb).unwrap();
    let (medium, λ) = (loader.medium(&document.root).unwrap(), Wavelengths::rgb());
    let mut scattered = 0;
    for i in 0..256 {
        let sampler = sampler(3, i);
        let mut numbers = FlightNumbers::independent(&sampler, blocks::flight(1));
        let flight = medium.fly(&ray(1.5), Spectrum::ONE, &λ, &mut numbers);
        let Flight::Scattered(t, weight) = flight else { continue };
        let albedo = medium.albedo.eval(ray(1.5).at(t), &λ).0[0];
        assert!((weight.0[0] - albedo).abs() < 1e-6, "{t}: {weight:?}, not {albedo}");
        scattered += 1;
    }
    assert!(scattered > 100, "{scattered}");
}
