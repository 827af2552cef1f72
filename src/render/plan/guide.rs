//! Whether emitters are sampled along ways that light paths have shown.
//!
//! Where [`links`](crate::integrator::links) find the way they make less noise and cost as much; where they
//! do not, a picture of a few samples hardly shows what it misses, for scattering finds that light in single
//! pixels of fire. So variances of a pilot cannot tell, but photons can: they know how much light comes by
//! which ways, and what part of it no link would make. A few camera paths say whether any surface is seen
//! that would ask. Neither are samples of the image, so the choice cannot bias it; both are functions of the
//! scene alone, so every part of a render makes the same.

use super::{all_over, pilot_camera};
use crate::integrator::Counters;
use crate::integrator::caustics::Emission;
use crate::integrator::guide::{Guide, Photon, photons};
use crate::integrator::links::Where;
use crate::scene::Scene;

/// Light paths for each pixel, and no more in all than these: a few tenths of a second. Nor more than leave so
/// many photons, for four times as many would make a hundredth less noise.
const LIGHT_PATHS: usize = 4;
const MOST_LIGHT_PATHS: usize = 1 << 18;
const MOST_PHOTONS: f64 = (1 << 16) as f64;

/// Light paths and camera samples of the pilot, some milliseconds.
const PILOT: u32 = 1 << 13;
const CAMERA_SAMPLES: u64 = 2048;

/// Guided is what links would leave this part of to chance.
const LEFT: f64 = 0.3;

/// Nor is it worth anything where fewer camera paths than one in so many would ask.
const ONE_IN: u64 = 256;

/// Makes a scene's guide if its file or a pilot wants one.
pub fn settle(scene: &mut Scene) {
    let Some(wanted) = scene.integrator.path().map(|path| path.links) else { return };
    let auto = wanted == Where::Auto && !scene.links.as_ref().is_some_and(|links| links.everywhere);
    if !auto && wanted != Where::Guided {
        return;
    }
    let Some(emission) = Emission::new(&scene.emitters, &scene.shapes, &scene.instances) else { return };
    let light_paths = (LIGHT_PATHS * scene.sensor.film.crop.pixels()).min(MOST_LIGHT_PATHS) as u32;
    let few = PILOT.min(light_paths);
    let first = photons(scene, &emission, few);
    // More than all are asked for where few leave any.
    let enough = MOST_PHOTONS * f64::from(few) / first.len() as f64;
    if auto && !pays(scene, first) {
        return;
    }
    let light_paths = f64::from(light_paths).min(enough) as u32;
    scene.links = None;
    scene.guide = Guide::new(photons(scene, &emission, light_paths));
    scene.settle_caustics();
}

/// Whether guided samples find what links do not, and are asked for, by a few photons.
fn pays(scene: &mut Scene, photons: Vec<Photon>) -> bool {
    let all: f64 = photons.iter().map(|photon| photon.power).sum();
    let left: f64 = photons.iter().map(|photon| photon.power * photon.left).sum();
    let Some(guide) = Guide::new(photons).filter(|_| left > LEFT * all) else { return false };
    let links = scene.links.take();
    scene.guide = Some(guide);
    scene.settle_caustics();
    let asked = guided_samples(scene) * ONE_IN > CAMERA_SAMPLES;
    (scene.links, scene.guide) = (links, None);
    scene.settle_caustics();
    asked
}

/// How many guided samples the camera paths of the pilot take.
fn guided_samples(scene: &Scene) -> u64 {
    let camera = pilot_camera(scene);
    let mut counters = Counters::default();
    let which = all_over(scene.sensor.film.crop, CAMERA_SAMPLES);
    let mut values = vec![0.0; camera.channel_names().len() * which.len()];
    camera.samples(&which, &mut counters, &mut values);
    counters.guided
}

#[cfg(test)]
mod tests {
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    /// Whether there is a guide, and whether there are links, in a room with this inside.
    fn settled(links: &str, inside: &str) -> (bool, bool) {
        let text = format!(
            r#"<scene version="3.0.0">
                <integrator type="path"><integer name="max_depth" value="12"/><string name="links" value="{links}"/></integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, -6, 2" target="0, 0, 0.5" up="0, 0, 1"/></transform>
                    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film></sensor>
                <shape type="rectangle"><transform name="to_world"><scale value="9"/></transform></shape>
                <shape type="sphere"><point name="center" x="-4" y="-2" z="5"/><float name="radius" value="0.5"/>
                    <emitter type="area"/></shape>{inside}</scene>"#
        );
        let scene = load_text("room.xml", &text, ColorMode::Rgb).expect("it loads");
        (scene.guide.is_some(), scene.links.is_some())
    }

    #[test]
    fn guided_is_what_links_do_not_find() {
        let block = |place: &str| {
            let at = |size: f64| {
                format!(
                    r#"<transform name="to_world"><scale value="{size}"/><translate {place}/></transform>"#
                )
            };
            let glass = format!(r#"<shape type="cube">{}<bsdf type="dielectric"/></shape>"#, at(1.0));
            glass + &format!(r#"<shape type="sphere">{}</shape>"#, at(0.7))
        };
        let before = block(r#"z="1.1""#);
        let behind = block(r#"y="-12" z="1.1""#);
        // The straight line to the lamp seldom leads through the side by which light comes to the ball
        // within.
        assert_eq!(settled("auto", &before), (true, false));
        assert_eq!(settled("auto", &behind), (false, true));
        assert_eq!(settled("auto", ""), (false, false));
        for (links, expected) in
            [("never", (false, false)), ("unaided", (false, true)), ("guided", (true, false))]
        {
            assert_eq!(settled(links, &before), expected, "{links}");
        }
        assert_eq!(settled("guided", ""), (false, false));
    }
}
