use super::faces::Faces;
use crate::load_text;
use crate::math::DVec3;
use crate::render::{Progress, Settings, render};
use crate::spectrum::ColorMode;

/// Direct light on a floor by one technique alone, and its standard error.
fn floor(ceiling_and_lamp: &str, emitter_samples: u32, bsdf_samples: u32) -> (f64, f64) {
    let text = format!(
        r#"<scene version="3.0.0">
            <integrator type="direct"><integer name="emitter_samples" value="{emitter_samples}"/>
                <integer name="bsdf_samples" value="{bsdf_samples}"/></integrator>
            <sensor type="perspective"><transform name="to_world">
                <lookat origin="0.3, 0.7, 0" target="0.3, 0, 0" up="0, 0, 1"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>
                <sampler type="independent"/>
                <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>
            <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/>
                <rotate x="1" y="2" z="-1" angle="$turn"/></transform></shape>
            {ceiling_and_lamp}</scene>"#
    );
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
    for turn in ["0", "37"] {
        let scene = load_text("scene.xml", &text.replace("$turn", turn), ColorMode::Rgb).unwrap();
        let (image, _) = render(&scene, &Settings::of(&scene, 0..256), &Progress::default()).unwrap();
        for value in &image.channel("G").unwrap().mean {
            let value = f64::from(*value);
            (sum, square, count) = (sum + value, square + value * value, count + 1.0);
        }
    }
    let mean = sum / count;
    (mean, ((square / count - mean * mean) / count).sqrt())
}

/// Both techniques see all of the lamp, or none, whatever lies in its plane, and whichever comes first.
#[test]
fn a_lamp_lies_upon_what_it_lies_in() {
    let shape = |kind: &str, scale: f64, more: &str| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world"><rotate x="1" angle="90"/><scale value="{scale}"/>
                <translate y="1"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
        )
    };
    let emitter = r#"<emitter type="area"/>"#;
    let ceiling = shape("rectangle", 2.7, "");
    // Its lower side is in the plane.
    let beam = r#"<shape type="cube"><transform name="to_world"><scale x="2" y="0.3" z="1"/><translate y="1.3"/>
        <rotate x="1" y="2" z="-1" angle="$turn"/></transform></shape>"#;
    for lamp in [shape("rectangle", 0.45, emitter), shape("disk", 0.45, emitter)] {
        for scene in [format!("{ceiling}{lamp}"), format!("{lamp}{ceiling}"), format!("{beam}{lamp}")] {
            let (by_emitter, e) = floor(&scene, 1, 0);
            let (by_bsdf, b) = floor(&scene, 0, 1);
            assert!(by_emitter > 0.01, "{by_emitter}");
            assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{by_emitter} {by_bsdf} {scene}");
        }
    }
}

/// What shines in a plane with another lamp, or with one of its faces in a plane.
#[test]
fn lamps_and_cubes_lie_upon_what_they_lie_in_too() {
    let at = |kind: &str, placed: &str, more: &str| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world">{placed}<translate y="1"/>
                <rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
        )
    };
    let lamp = |radiance: f64| {
        format!(r#"<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>"#)
    };
    let down = |scale: f64, more: &str| {
        at("rectangle", &format!(r#"<rotate x="1" angle="90"/><scale value="{scale}"/>"#), more)
    };
    let up = at("rectangle", r#"<rotate x="1" angle="-90"/><scale value="0.45"/>"#, &lamp(1.0));
    let cube = at("cube", r#"<scale value="0.45"/><translate y="0.45"/>"#, &lamp(1.0));
    // Its back is outside, and its front shines into it: the lower face upon the panel, which shines down.
    let inward = at(
        "cube",
        r#"<scale x="0.9" y="0.45" z="0.9"/><translate y="0.45"/>"#,
        &(r#"<boolean name="flip_normals" value="true"/>"#.to_owned() + &lamp(3.0)),
    );
    let (ceiling, panel) = (down(2.7, ""), down(0.45, &lamp(1.0)));
    let (brighter, darker) = (down(0.45, &lamp(2.0)), down(0.45, &lamp(0.5)));
    for (scene, same) in [
        (format!("{ceiling}{cube}"), &cube),
        (format!("{cube}{ceiling}"), &cube),
        (format!("{up}{panel}"), &panel),
        (format!("{panel}{up}"), &panel),
        (format!("{panel}{cube}"), &cube),
        (format!("{panel}{inward}"), &panel),
        (format!("{inward}{panel}"), &panel),
        // The last one is seen.
        (format!("{brighter}{panel}{darker}"), &darker),
        (format!("{panel}{darker}{brighter}"), &brighter),
    ] {
        let ((by_emitter, e), (by_bsdf, b)) = (floor(&scene, 1, 0), floor(&scene, 0, 1));
        let (alone, a) = floor(same, 1, 0);
        assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{by_emitter} {by_bsdf} {scene}");
        assert!((by_emitter - alone).abs() < 5.0 * e.hypot(a), "{by_emitter} {alone} {scene}");
    }
}

/// Rounded to `f32`, some of these ceilings are before their lamps: where they are, or where the file has them.
#[test]
fn a_lamp_lies_upon_a_mesh_too() {
    let file = std::env::temp_dir().join(format!("etalon-ceiling-{}.ply", std::process::id()));
    let at = |height: &str, kind: &str, scale: f64, before: &str, more: &str| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world">{before}<rotate x="1" angle="90"/><scale value="{scale}"/>
                <translate y="{height}"/><rotate x="1" y="2" z="-1" angle="$turn"/></transform>{more}</shape>"#
        )
    };
    let name = format!(r#"<string name="filename" value="{}"/>"#, file.display());
    for (height, stored) in
        [("1", "0"), ("2.3", "0"), ("2.6", "0"), ("2.7", "0"), ("1", "2.3"), ("1", "2.6"), ("1", "2.7")]
    {
        let square = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_index\nend_header\n\
             -1 -1 {stored}\n1 -1 {stored}\n1 1 {stored}\n-1 1 {stored}\n4 0 1 2 3\n"
        );
        std::fs::write(&file, square).unwrap();
        let lamp = at(height, "rectangle", 0.45, "", r#"<emitter type="area"/>"#);
        let down = format!(r#"<translate z="-{stored}"/>"#);
        let scene = at(height, "ply", 2.7, &down, &name) + &lamp;
        let ((by_emitter, e), (by_bsdf, b)) = (floor(&scene, 1, 0), floor(&scene, 0, 1));
        let (alone, a) = floor(&lamp, 1, 0);
        assert!((by_emitter - by_bsdf).abs() < 5.0 * e.hypot(b), "{height}: {by_emitter} {by_bsdf}");
        // Nothing of it is hidden.
        assert!((by_emitter - alone).abs() < 5.0 * e.hypot(a), "{height}: {by_emitter} {alone}");
    }
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn lamps_are_raised_by_what_they_lie_in_and_by_nothing_far_away() {
    let lamp = |more: &str| {
        let text = format!(
            r#"<scene version="3.0.0"><sensor type="perspective"/>
                <shape type="rectangle"><transform name="to_world"><translate z="2"/></transform>
                <emitter type="area"/></shape>{more}</scene>"#
        );
        let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
        scene.shapes[0].geometry.bounds().0.z - 2.0
    };
    let place = |scale: &str, x: &str, z: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="{scale}"/><translate x="{x}" z="{z}"/></transform></shape>"#
        )
    };
    let sun =
        r#"<shape type="sphere"><point name="center" z="1.5e11"/><float name="radius" value="1e9"/></shape>"#;
    assert_eq!(lamp(&(place("5", "0", "1.9") + sun)), 0.0);
    assert_eq!(lamp(&place("5", "1e9", "2")), 0.0);
    let height = lamp(&place("5", "0", "2"));
    assert!(height > 0.0 && height < 1e-12, "{height}");
    // A hill that goes far up and down about it, and a level plain that does not reach it.
    let hill = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element face 2\nproperty list uchar int vertex_index\nend_header\n\
                -1e5 -1e5 -1e5\n1e5 -1e5 1e5\n1e5 1e5 2e5\n-9e4 2e4 2\n3 0 1 2\n3 0 2 3\n";
    let file = std::env::temp_dir().join(format!("etalon-hill-{}.ply", std::process::id()));
    std::fs::write(&file, hill).unwrap();
    let mesh = format!(r#"<shape type="ply"><string name="filename" value="{}"/></shape>"#, file.display());
    let group = format!(r#"<shape type="shapegroup" id="g">{mesh}</shape>"#);
    let instance = r#"<shape type="instance"><ref id="g"/></shape>"#;
    let heights = [lamp(&mesh), lamp(&format!("{group}{instance}"))];
    std::fs::remove_file(&file).unwrap();
    assert_eq!(heights, [0.0; 2]);
}

/// So many that they are found by a tree: those that lie in a plate of their own are raised, and no others.
#[test]
fn of_many_lamps_each_that_lies_in_something_is_raised() {
    let at = |i: usize, more: &str| {
        let (x, y) = (3 * (i % 7), 3 * (i / 7));
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><translate x="{x}" y="{y}" z="2"/></transform>{more}</shape>"#
        )
    };
    let lamps: String = (0..100).map(|i| at(i, r#"<emitter type="area"/>"#)).collect();
    let plates: String = (0..100).step_by(2).map(|i| at(i, "")).collect();
    let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{lamps}{plates}</scene>"#);
    let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
    for (i, shape) in scene.shapes[..100].iter().enumerate() {
        let height = shape.geometry.bounds().0.z - 2.0;
        assert_eq!(height > 0.0, i % 2 == 0, "{i}: {height}");
    }
}

/// A loader that looked at every triangle between two lamps would take minutes for a field of instances.
#[test]
fn what_is_between_lamps_or_beside_a_tilted_one_is_passed_over() {
    let lamp = |place: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world">{place}</transform><emitter type="area"/></shape>"#
        )
    };
    let far = (0..20).map(|i| lamp(&format!(r#"<translate x="{}" y="{}"/>"#, 50 * i, 50 * i))).collect();
    let tilted = lamp(r#"<scale value="20"/><rotate x="1" y="1" angle="45"/><translate z="100"/>"#);
    for (lamps, at) in [(far, DVec3::ZERO), (tilted, DVec3::new(0.0, 0.0, 100.0))] {
        let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{lamps}</scene>"#);
        let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
        let faces = Faces::of(&scene.shapes);
        let is_near = |p: DVec3| faces.are_near((p - 0.5, p + 0.5), 1e-9);
        assert!(is_near(at));
        for beside in [DVec3::new(5.0, 0.0, 2.0), DVec3::new(7.0, -7.0, 0.0), DVec3::new(0.0, -9.0, -1.0)] {
            assert!(!is_near(at + beside), "{beside}");
        }
    }
}
