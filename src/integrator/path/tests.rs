//! What no expectation shows: settings that change the noise alone.

use crate::image::Image;
use crate::integrator::roulette::{ENDLESS, Roulette};
use crate::load_text;
use crate::render::{Progress, Report, Settings, render};
use crate::spectrum::ColorMode;

/// A scene in RGB with so many samples a pixel.
fn rendered(text: &str, samples: u64) -> (Image, Report) {
    let scene = load_text("scene.xml", text, ColorMode::Rgb).unwrap();
    let settings = Settings::of(&scene, 0..samples);
    render(&scene, &settings, &Progress::default()).unwrap()
}

/// The variance of the direct light on a floor under two lamps, one of which it does not see.
fn variance(emitter_samples: u32) -> f64 {
    let lamp = |place: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.3"/>{place}</transform>
                <emitter type="area"/></shape>"#
        )
    };
    let seen = lamp(r#"<rotate x="1" angle="180"/><translate z="1"/>"#);
    let hidden = lamp(r#"<translate z="2"/>"#);
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="2"/>
                <integer name="emitter_samples" value="{emitter_samples}"/><integer name="reuse" value="1"/></integrator>
            <sensor type="perspective"><float name="fov" value="0.001"/>
                <transform name="to_world"><lookat origin="0, -3, 0.5" target="0, 0, 0" up="0, 0, 1"/></transform>
                <sampler type="independent"/>
                <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
                    <rfilter type="box"/></film></sensor>
            <shape type="rectangle"/>{seen}{hidden}</scene>"#
    );
    let (image, _) = rendered(&text, 1024);
    let green = image.channel("G").unwrap();
    green.variance.iter().flatten().map(|&v| f64::from(v)).sum()
}

#[test]
fn eight_emitter_samples_have_an_eighth_of_the_variance() {
    // What sampling the surface adds is a hundredth; each variance is known to one in fifty.
    let ratio = variance(8) / variance(1);
    assert!((ratio - 0.125).abs() < 0.02, "{ratio}");
}

/// It is convex, so what it shines outwards never reaches its inner wall.
#[test]
fn a_ball_that_shines_does_not_light_its_inside() {
    for integrator in ["path", "direct", "volpath"] {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="{integrator}"/>
            <sensor type="perspective"><transform name="to_world"><lookat origin="20, 0.1, 0.5" target="20, 0, 0" up="0, 1, 0"/></transform>
                <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
            <shape type="sphere"><point name="center" x="20" y="0" z="0"/><float name="radius" value="1.1"/>
                <bsdf type="twosided"><bsdf type="diffuse"/></bsdf><emitter type="area"/></shape></scene>"#
        );
        let (image, _) = rendered(&text, 64);
        assert!(image.channels.iter().flat_map(|c| &c.mean).all(|v| *v == 0.0), "{integrator}");
    }
}

/// Alpha of a picture through three surfaces that let all light pass, at every depth of paths.
fn alpha(hide_emitters: bool, surroundings: &str) -> Vec<f32> {
    let pane = |z: f64| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><translate z="{z}"/></transform><bsdf type="null"/></shape>"#
        )
    };
    let panes: String = [1.0, 2.0, 3.0].map(pane).concat();
    let of_depth = |max_depth: u32| {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="{max_depth}"/>
                    <boolean name="hide_emitters" value="{hide_emitters}"/></integrator>
                <sensor type="perspective"><float name="fov" value="1"/><film type="hdrfilm"><string name="pixel_format" value="rgba"/>
                    <integer name="width" value="2"/><integer name="height" value="2"/><rfilter type="box"/></film></sensor>
                {panes}{surroundings}</scene>"#
        );
        let (image, _) = rendered(&text, 4);
        image.channel("A").unwrap().mean.clone()
    };
    (0..=5).flat_map(of_depth).collect()
}

#[test]
fn surroundings_in_view_cover_every_pixel_wherever_the_path_ends() {
    let sky = r#"<emitter type="constant"/>"#;
    let seen = alpha(false, sky);
    // Nothing is looked at with `max_depth` 0, as in Mitsuba.
    assert!(seen[..4].iter().all(|&a| a == 0.0) && seen[4..].iter().all(|&a| a == 1.0), "{seen:?}");
    assert!(alpha(true, sky).iter().all(|&a| a == 0.0));
    assert!(alpha(false, "").iter().all(|&a| a == 0.0));
}

#[test]
fn paths_end_where_nothing_is_absorbed() {
    let white = r#"<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>"#;
    for inside in [white, r#"<bsdf type="conductor"/>"#, r#"<bsdf type="dielectric"/>"#] {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"/>
                <sensor type="perspective"><transform name="to_world"><translate x="0.3" y="0.2" z="0.5"/></transform>
                    <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
                <shape type="cube"><bsdf type="twosided"><boolean name="allow_transmission" value="true"/>{inside}</bsdf></shape>
                <emitter type="point"/></scene>"#
        );
        let (image, report) = rendered(&text, 1);
        // In each of 16 pixels a ray and a shadow ray an edge; after so many edges as many more on average, but with long
        // tails.
        assert!(report.cut == 0 && report.rays < 16 * 2 * 4 * u64::from(ENDLESS), "{report:?}");
        assert!(image.channel("G").unwrap().mean.iter().all(|v| v.is_finite()));
    }
}

/// Inside a glowing sphere L = Lₑ/(1 − ρ), whichever paths end early.
#[test]
fn roulette_begins_early_where_a_pilot_decides_and_takes_no_light() {
    let glow = |options: &str| {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path">{options}</integrator>
                <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="16"/>
                    <integer name="height" value="16"/><rfilter type="box"/></film></sensor>
                <shape type="sphere"><boolean name="flip_normals" value="true"/><emitter type="area"/>
                    <bsdf type="diffuse"><rgb name="reflectance" value="0.4"/></bsdf></shape></scene>"#
        );
        let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
        let (image, _) = rendered(&text, 256);
        let green = &image.channel("G").unwrap().mean;
        let mean = green.iter().map(|&v| f64::from(v)).sum::<f64>() / green.len() as f64;
        (scene.integrator.path().unwrap().roulette, mean)
    };
    let (auto, given) = (r#"<integer name="reuse" value="0"/>"#, r#"<integer name="rr_depth" value="7"/>"#);
    let usual = Roulette::after(5);
    let (found, mean) = glow(auto);
    assert_eq!(found, usual.early());
    assert!((mean * 0.6 - 1.0).abs() < 2e-3, "{mean}");
    assert_eq!(glow(&[auto, given].concat()).0, Roulette::after(7));
    assert_eq!(glow("").0, usual);
}

/// Metals have no light in the lanes that RGB mode leaves empty, and no share in roulette.
#[test]
fn roulette_ends_paths_as_early_in_colours_as_in_spectra() {
    let text = r#"<scene version="3.0.0"><integrator type="path"/>
        <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="16"/>
            <integer name="height" value="16"/></film></sensor>
        <shape type="cube"><boolean name="flip_normals" value="true"/><bsdf type="conductor">
            <string name="material" value="Cr"/></bsdf></shape><emitter type="point"/></scene>"#;
    let [colours, spectra] = [ColorMode::Rgb, ColorMode::Spectral].map(|mode| {
        let scene = load_text("scene.xml", text, mode).unwrap();
        let settings = Settings::of(&scene, 0..16);
        render(&scene, &settings, &Progress::default()).unwrap().1.rays as f64
    });
    assert!((0.8..1.25).contains(&(colours / spectra)), "{colours} {spectra}");
}

/// Metals of index 1 in some channels, which reflect nothing there but what rounding leaves: a path may go on with that,
/// and those that share with it have densities beyond what a lane holds.
#[test]
fn metals_of_index_one_share_finite_light() {
    let wall = |number: usize, placed: &str| {
        let (eta, k) = [("0.2, 1, 1", "3, 0, 0"), ("1, 0.2, 1", "0, 3, 0")][number % 2];
        format!(
            r#"<shape type="rectangle"><transform name="to_world">{placed}</transform><bsdf type="roughconductor">
                <float name="alpha" value="0.15"/><rgb name="eta" value="{eta}"/><rgb name="k" value="{k}"/></bsdf></shape>"#
        )
    };
    let walls: String = [
        r#"<rotate y="1" angle="90"/><translate x="-1"/>"#,
        r#"<rotate y="1" angle="-90"/><translate x="1"/>"#,
        r#"<translate z="-1"/>"#,
        r#"<rotate x="1" angle="180"/><translate z="1"/>"#,
        r#"<rotate x="1" angle="90"/><translate y="1"/>"#,
    ]
    .iter()
    .enumerate()
    .map(|(number, placed)| wall(number, placed))
    .collect();
    let (_, report) = rendered(
        &format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="8"/>
                <integer name="reuse" value="16"/><string name="links" value="never"/><float name="light_paths" value="0"/></integrator>
            <sensor type="perspective"><transform name="to_world"><lookat origin="0, -3.9, 0" target="0, 0, 0" up="0, 0, 1"/></transform>
                <float name="fov" value="38"/><film type="hdrfilm"><integer name="width" value="24"/>
                <integer name="height" value="18"/><rfilter type="box"/></film><sampler type="independent"/></sensor>{walls}
            <shape type="rectangle"><transform name="to_world"><scale value="0.6"/><rotate x="1" angle="180"/>
                <translate z="0.98"/></transform><emitter type="area"><rgb name="radiance" value="4"/></emitter></shape></scene>"#
        ),
        2048,
    );
    assert_eq!(report.non_finite, 0, "{:?}", report.first_non_finite);
}
