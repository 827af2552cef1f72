//! Whether emitter samples are guided by photons.
//!
//! Where [`links`](crate::integrator::links) find a path they make less noise than guided samples and cost as
//! much; where they do not, an image of a few samples hardly shows what it misses, for scattering finds that
//! light in a few very bright pixels. So variances of a pilot cannot decide, but photons can: they know how
//! much light comes by which specular chains, and what part of it no link would find. A few camera paths say
//! whether guided samples would be taken at any surface in view. Neither are samples of the image, so the
//! choice cannot bias it; both are functions of the scene alone, so every part of a render chooses alike.

use super::{all_over, pilot_maker};
use crate::integrator::Counters;
use crate::integrator::caustics::Emission;
use crate::integrator::guide::{Guide, Photon, photons};
use crate::integrator::links::LinkPolicy;
use crate::scene::Scene;

/// Light paths per pixel, with which photons are made.
const PHOTON_PATHS_PER_PIXEL: usize = 4;
/// Most of these light paths in all: a few tenths of a second.
const MOST_PHOTON_PATHS: usize = 1 << 18;
/// Number of photons that is enough: four times as many would make a hundredth less noise.
const MOST_PHOTONS: f64 = (1 << 16) as f64;

/// Light paths of the pilot, some milliseconds.
const PILOT: u32 = 1 << 13;
/// Camera samples of the pilot, some milliseconds.
const CAMERA_SAMPLES: u64 = 2048;

/// Samples are guided if links would leave more than this share of the light to scattering.
const LEFT: f64 = 0.3;

/// No guide unless more than one guided sample is taken in this many camera paths.
const ONE_IN: u64 = 256;

/// Makes a scene's guide if its file or a pilot asks for one.
pub fn settle(scene: &mut Scene) {
    let Some(wanted) = scene.integrator.path().map(|path| path.links) else { return };
    let auto =
        wanted == LinkPolicy::Auto && !scene.techniques.links.as_ref().is_some_and(|links| links.everywhere);
    if !auto && wanted != LinkPolicy::Guided {
        return;
    }
    let Some(emission) = Emission::new(&scene.emitters, &scene.shapes, &scene.instances) else { return };
    let light_paths =
        (PHOTON_PATHS_PER_PIXEL * scene.sensor.film.crop.pixels()).min(MOST_PHOTON_PATHS) as u32;
    let few = PILOT.min(light_paths);
    let first = photons(scene, &emission, few);
    // This may exceed all light paths, where few of them leave a photon.
    let enough = MOST_PHOTONS * f64::from(few) / first.len() as f64;
    if auto && !pays(scene, first) {
        return;
    }
    let light_paths = f64::from(light_paths).min(enough) as u32;
    scene.techniques.links = None;
    scene.techniques.guide = Guide::new(photons(scene, &emission, light_paths));
}

/// Whether guided samples find enough that links do not, and are taken often enough, by a few photons.
fn pays(scene: &mut Scene, photons: Vec<Photon>) -> bool {
    let all: f64 = photons.iter().map(|photon| photon.power).sum();
    let left: f64 = photons.iter().map(|photon| photon.power * photon.left).sum();
    let Some(guide) = Guide::new(photons).filter(|_| left > LEFT * all) else { return false };
    let links = scene.techniques.links.take();
    scene.techniques.guide = Some(guide);
    let asked = guided_samples(scene) * ONE_IN > CAMERA_SAMPLES;
    (scene.techniques.links, scene.techniques.guide) = (links, None);
    asked
}

/// How many guided samples the camera paths of the pilot take.
fn guided_samples(scene: &Scene) -> u64 {
    let maker = pilot_maker(scene);
    let mut counters = Counters::default();
    let which = all_over(scene.sensor.film.crop, CAMERA_SAMPLES);
    let mut values = vec![0.0; maker.channels() * which.len()];
    maker.samples(&which, &mut counters, &mut values);
    counters.guided
}

#[cfg(test)]
mod tests {
    use crate::load_text;
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
        (scene.techniques.guide.is_some(), scene.techniques.links.is_some())
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
