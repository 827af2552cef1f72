//! Coverage: the `A` channel of pixels.

use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::spectrum::ColorMode;

/// The `A` of a one-pixel film that sees `content` head-on.
fn alpha(integrator: &str, content: &str) -> f64 {
    alpha_with("", &[integrator, content].concat())
}

/// The same with something more said of the sensor.
fn alpha_with(sensor: &str, content: &str) -> f64 {
    let text = format!(
        r#"<scene version="3.0.0">
        <sensor type="orthographic">{sensor}<transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
        <string name="pixel_format" value="RGBA"/><rfilter type="box"/></film></sensor>{content}</scene>"#
    );
    let scene = load_text("alpha.xml", &text, ColorMode::Rgb).unwrap();
    let settings = Settings::of(&scene, 0..4096);
    let (image, _) = render(&scene, &settings, &Progress::default()).unwrap();
    let channel = image.channels.iter().find(|channel| channel.name == "A").unwrap();
    f64::from(channel.mean[0])
}

const PATH: &str = r#"<integrator type="path"/>"#;
const BALL: &str = r#"<shape type="sphere"/>"#;
const LAMP: &str = r#"<shape type="sphere"><emitter type="area"/></shape>"#;

#[test]
fn a_ball_covers_its_disk() {
    for integrator in [PATH, r#"<integrator type="direct"/>"#] {
        // Five standard errors of independent samples; Sobol's are smaller.
        let error =
            5.0 * (0.25 * std::f64::consts::PI * (1.0 - 0.25 * std::f64::consts::PI) / 4096.0f64).sqrt();
        assert!((alpha(integrator, BALL) - 0.25 * std::f64::consts::PI).abs() < error, "{integrator}");
    }
}

#[test]
fn nothing_covers_nothing_and_a_sky_covers_all() {
    assert_eq!(alpha(PATH, ""), 0.0);
    let pane = r#"<shape type="rectangle"><bsdf type="null"/></shape>"#;
    assert_eq!(alpha(PATH, pane), 0.0);
    assert_eq!(alpha(PATH, r#"<emitter type="constant"/>"#), 1.0);
    let wall =
        r#"<shape type="rectangle"><transform name="to_world"><translate z="-1"/></transform></shape>"#;
    assert_eq!(alpha(PATH, &format!("{pane}{wall}")), 1.0);
}

#[test]
fn hidden_lamps_cover_nothing() {
    assert!(alpha(PATH, LAMP) > 0.7);
    let hidden = r#"<integrator type="path"><boolean name="hide_emitters" value="true"/></integrator>"#;
    assert_eq!(alpha(hidden, LAMP), 0.0);
}

/// As in Mitsuba, also where a surface scatters nothing: from behind, or by a sample that failed.
#[test]
fn what_scatters_nothing_covers_too() {
    let black = r#"<shape type="rectangle"><transform name="to_world"><scale value="2"/><rotate y="1" angle="180"/></transform></shape>"#;
    let rough = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="75"/></transform>
        <bsdf type="roughconductor"><float name="alpha" value="0.6"/></bsdf></shape>"#;
    // Somewhere else, for `volpath` to have something to do.
    let beside = r#"<shape type="sphere"><point name="center" x="99"/><bsdf type="null"/></shape>"#;
    for surface in [black, rough] {
        for integrator in [PATH, r#"<integrator type="volpath"/>"#] {
            assert_eq!(alpha(integrator, &format!("{surface}{beside}")), 1.0, "{integrator} {surface}");
        }
    }
}

/// As in Mitsuba, `far_clip` ends what the camera sees, but not beyond a surface that lets light through, nor
/// beyond a lamp that is hidden.
#[test]
fn far_clips_end_the_first_ray() {
    let wall =
        r#"<shape type="rectangle"><transform name="to_world"><translate z="-1"/></transform></shape>"#;
    let (pane, lamp) = (r#"<bsdf type="null"/>"#, r#"<emitter type="area"/>"#);
    let before = |what: &str| format!(r#"{wall}<shape type="rectangle">{what}</shape>"#);
    let clipped = |integrator: &str, content: &str| {
        alpha_with(r#"<float name="far_clip" value="5.5"/>"#, &[integrator, content].concat())
    };
    for name in ["path", "volpath", "direct"] {
        let hides =
            format!(r#"<integrator type="{name}"><boolean name="hide_emitters" value="true"/></integrator>"#);
        assert_eq!((clipped(&hides, wall), clipped(&hides, &before(lamp))), (0.0, 1.0), "{name}");
        if name != "direct" {
            assert_eq!(clipped(&hides, &before(pane)), 1.0, "{name}");
        }
    }
}

/// As in Mitsuba, a medium covers what it scatters or absorbs.
#[test]
fn media_cover_what_they_take_and_invisible_surfaces_nothing() {
    let volpath = r#"<integrator type="volpath"/>"#;
    let pane = r#"<shape type="rectangle"><bsdf type="null"/></shape>"#;
    assert_eq!((alpha(volpath, pane), alpha(volpath, BALL) > 0.7), (0.0, true));
    let hidden = r#"<integrator type="volpath"><boolean name="hide_emitters" value="true"/></integrator>"#;
    assert_eq!((alpha(hidden, &format!("{pane}{LAMP}")), alpha(volpath, LAMP) > 0.7), (0.0, true));
    // The cube is as wide as the film, and two deep.
    for albedo in ["0.75", "0"] {
        let cube = format!(
            r#"<shape type="cube"><bsdf type="null"/><medium type="homogeneous" name="interior">
            <float name="sigma_t" value="0.4"/><float name="albedo" value="{albedo}"/></medium></shape>"#
        );
        let (found, expected) = (alpha(volpath, &cube), 1.0 - (-0.8f64).exp());
        let error = 5.0 * (expected * (1.0 - expected) / 4096.0).sqrt();
        assert!((found - expected).abs() < error, "{albedo}: {found}, not {expected}");
    }
    // A coloured one of two pieces covers as one does: the mean of what all of it takes of each channel.
    let coloured = r#"<shape type="cube"><bsdf type="null"/><medium type="homogeneous" name="interior">
        <rgb name="sigma_t" value="0, 0.5, 1"/><float name="scale" value="2"/><float name="albedo" value="0"/></medium></shape>"#;
    let expected = [0.0f64, 1.0, 2.0].iter().map(|sigma| 1.0 - (-2.0 * sigma).exp()).sum::<f64>() / 3.0;
    let error = 5.0 * (expected * (1.0 - expected) / 4096.0).sqrt();
    for scene in [coloured.to_owned(), coloured.to_owned() + pane] {
        let found = alpha(volpath, &scene);
        assert!((found - expected).abs() < error, "{found}, not {expected}: {scene}");
    }
}

/// As in Mitsuba: with paths of one edge `volpath` sees surfaces, `path` does not, and media are none.
#[test]
fn paths_of_one_edge_see_what_mitsuba_says_they_see() {
    let one = |name: &str, content: &str| {
        let integrator =
            format!(r#"<integrator type="{name}"><integer name="max_depth" value="1"/></integrator>"#);
        // Somewhere else, for `volpath` to have something to do.
        let beside = r#"<shape type="sphere"><point name="center" x="99"/><bsdf type="null"/></shape>"#;
        alpha(&integrator, &format!("{content}{beside}"))
    };
    let wall = |bsdf: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="2"/></transform>{bsdf}</shape>"#
        )
    };
    let opaque = wall(r#"<bsdf type="mask"><float name="opacity" value="1"/><bsdf type="diffuse"/></bsdf>"#);
    for name in ["volpath", "volpathmis"] {
        assert_eq!((one(name, &wall("")), one(name, &opaque)), (1.0, 1.0), "{name}");
        for albedo in ["0.5", "0"] {
            let mist = format!(
                r#"<shape type="cube"><bsdf type="null"/><medium type="homogeneous" name="interior">
                <float name="sigma_t" value="9"/><float name="albedo" value="{albedo}"/></medium></shape>"#
            );
            assert_eq!(one(name, &mist), 0.0, "{name} {albedo}");
        }
    }
    assert_eq!(one("path", &wall("")), 0.0);
}
