//! How many light paths there are to a camera path.
//!
//! A pixel of relative cost 1 + s and variance V + W/s, with s light paths to a camera path, is best at s² =
//! W/V: the variance that light paths leave against that of camera paths. A pilot too short to know variances
//! knows energies well, since either kind of path finds its own part of the light easily. So s is the root of
//! the part of the image's light that light paths bring, as a power of two; and where they bring none they
//! are left out. Where they would bring most of it, sampling emitters through glass
//! ([`links`](crate::integrator::links)) relieves them first. The pilot has a seed of its own and its samples
//! are thrown away, so the choice cannot bias an image; they are a function of the scene alone, so every part
//! of a render makes the same.

use super::{all_over, pilot_camera};
use crate::integrator::Counters;
use crate::integrator::caustics::Caustics;
use crate::integrator::links::Where;
use crate::scene::Scene;

/// Camera samples and light paths of the pilot: some milliseconds.
const CAMERA_SAMPLES: u64 = 2048;
const LIGHT_PATHS: u64 = 8192;

/// Tiles along each side of the image.
const TILES: usize = 8;

/// Where light paths would bring this part of the light, emitters are sampled through glass at all vertices.
const MUCH: f64 = 0.5;

/// Fewer light paths than these to a camera path cost next to nothing, more gain next to nothing.
const FEWEST: f64 = 1.0 / 32.0;
const MOST: f64 = 1.0;

/// So many times more where pixels share what their paths find ([`reuse`](crate::integrator::path::reuse)):
/// that takes variance from camera paths and leaves that of light paths.
const MORE_WHERE_PIXELS_SHARE: f64 = 2.0;

/// No more light paths for a sample number than these, however large the film: a quarter of a gigabyte may
/// have to be kept of the four of a block.
const AT_ONCE: f64 = (1 << 19) as f64;

/// Settles the number of light paths of a scene whose file does not.
pub fn settle(scene: &mut Scene) {
    if !is_free(scene) {
        return;
    }
    let brought =
        |scene: &Scene| scene.caustics.as_ref().map(|caustics| part_of_light_paths(scene, caustics));
    let Some(mut part) = brought(scene) else { return };
    let auto = scene.integrator.path().is_some_and(|path| path.links == Where::Auto);
    if let Some(links) = scene.links.as_mut().filter(|_| auto && part > MUCH) {
        links.everywhere = true;
        part = brought(scene).unwrap_or(part);
    }
    if part > 0.0 {
        set(scene, nearest_power_of_two(part.sqrt()));
    } else {
        scene.caustics = None;
        scene.settle_caustics();
    }
}

fn set(scene: &mut Scene, ratio: f64) {
    let pixels = scene.sensor.film.crop.pixels();
    let ratio = ratio.clamp(FEWEST, MOST).min(AT_ONCE / pixels as f64);
    scene.caustics.iter_mut().for_each(|caustics| caustics.set_ratio(ratio, pixels));
}

/// Gives a scene whose pixels share the more light paths that it then is best with, if its file leaves that
/// open.
pub fn raise(scene: &mut Scene) {
    let Some(caustics) = scene.caustics.as_ref().filter(|_| is_free(scene)) else { return };
    let ratio = f64::from(caustics.paths) / scene.sensor.film.crop.pixels() as f64;
    set(scene, MORE_WHERE_PIXELS_SHARE * ratio);
}

/// Whether a scene's file leaves open how many light paths there are.
pub fn is_free(scene: &Scene) -> bool {
    scene.integrator.path().is_some_and(|path| path.light_paths.is_none())
}

/// The power of two nearest to x in (0, 1], by ratio; not below [`FEWEST`].
fn nearest_power_of_two(x: f64) -> f64 {
    let mut power = 1.0;
    while power * power > 2.0 * x * x && power > FEWEST {
        power *= 0.5;
    }
    power
}

/// The part of the light that light paths bring, averaged over tiles of the image, for a lamp in view must
/// not outshine everything else; zero where they were not seen to bring any.
fn part_of_light_paths(scene: &Scene, caustics: &Caustics) -> f64 {
    let camera = pilot_camera(scene);
    let mut counters = Counters::default();
    let film = scene.sensor.film.crop;
    let pixels = film.pixels() as u64;
    let which = all_over(film, CAMERA_SAMPLES);
    let channels = camera.channel_names().len();
    let mut values = vec![0.0; channels * which.len()];
    camera.samples(&which, &mut counters, &mut values);
    let tile = |(x, y): (u32, u32)| {
        let along = |offset: u32, size: u32| (u64::from(offset) * TILES as u64 / u64::from(size)) as usize;
        along(y - film.y, film.height) * TILES + along(x - film.x, film.width)
    };
    // Green stands for all colours.
    let (mut seen, mut brought) = (vec![0.0; TILES * TILES], vec![0.0; TILES * TILES]);
    for ((pixel, _), values) in which.iter().zip(values.chunks(channels)) {
        seen[tile(*pixel)] += values[1];
    }
    let scale = f64::from(caustics.paths) * CAMERA_SAMPLES as f64 / (LIGHT_PATHS as f64 * pixels as f64);
    camera.trace_light(0..LIGHT_PATHS, &mut counters, |_, pixel, values| {
        brought[tile(pixel)] += values[1] * scale;
    });
    let parts = seen.iter().zip(&brought).map(|(seen, brought)| brought / (seen + brought));
    let lit: Vec<f64> = parts.filter(|part| part.is_finite()).map(|part| part.clamp(0.0, 1.0)).collect();
    if lit.is_empty() { 0.0 } else { lit.iter().sum::<f64>() / lit.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Features, load_text};
    use crate::spectrum::ColorMode;

    #[test]
    fn powers_are_the_nearest() {
        for (x, power) in
            [(1.0, 1.0), (0.72, 1.0), (0.7, 0.5), (0.26, 0.25), (0.18, 0.25), (0.17, 0.125), (1e-9, FEWEST)]
        {
            assert_eq!(nearest_power_of_two(x), power, "{x}");
        }
    }

    /// Light paths to a camera path in a box whose lamp is behind glass or not, or that has no glass, or no
    /// lamp to aim from.
    fn ratio(inside: &str, more: &str) -> f64 {
        let text = format!(
            r#"<scene version="3.0.0">
                <integrator type="path"><integer name="max_depth" value="6"/>{more}</integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film></sensor>
                <shape type="cube"><transform name="to_world"><scale value="4"/></transform><boolean name="flip_normals" value="true"/>
                    <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>{inside}</scene>"#
        );
        let scene = load_text("box.xml", &text, ColorMode::Rgb).unwrap();
        let paths = scene.caustics.as_ref().map_or(0, |caustics| caustics.paths);
        assert_eq!(paths > 0, scene.features.0 & Features::CAUSTICS != 0);
        f64::from(paths) / 1024.0
    }

    #[test]
    fn there_are_as_many_light_paths_as_light_comes_by_them() {
        let lamp = |place: &str, radius: f64| {
            format!(
                r#"<shape type="sphere"><point name="center" {place}/><float name="radius" value="{radius}"/>
                    <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>"#
            )
        };
        let glass = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="0.9"/>
            <bsdf type="dielectric"/></shape>"#;
        let beside = ratio(&(lamp(r#"x="2" y="2" z="0""#, 0.5) + glass), "");
        let within = ratio(&(lamp(r#"x="0" y="0" z="1""#, 0.5) + glass), "");
        assert!(beside > 0.0 && within > 2.0 * beside, "{beside} beside, {within} within");
        assert_eq!(ratio(&lamp(r#"x="2" y="2" z="0""#, 0.5), ""), 0.0);
        let distant =
            r#"<emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/></emitter>"#;
        assert_eq!(ratio(&(distant.to_owned() + glass), ""), 0.0);
        let told = r#"<float name="light_paths" value="3"/>"#;
        assert_eq!(ratio(&(lamp(r#"x="2" y="2" z="0""#, 0.5) + glass), told), 3.0);
    }
}
