//! Invalid numbers, transforms and sizes.

use super::{Folder, all_refused, refused, scene};
use std::time::Instant;

#[test]
fn shapes_that_are_points_and_shutters_that_close_first_are_refused() {
    for kind in ["rectangle", "disk", "cube", "cylinder"] {
        let body = format!(
            "<shape type=\"{kind}\">\n<transform name=\"to_world\"><scale value=\"1e-150\"/></transform></shape>"
        );
        all_refused(&[("<shape", &body, &["as good as a point", "expected a larger shape"])]);
    }
    let shutter = "<sensor type=\"perspective\">\n<float name=\"shutter_open\" value=\"1\"/></sensor>";
    let document = format!("<scene version=\"3.0.0\">{shutter}</scene>");
    refused(&document, "shutter_open", &["the shutter closes before it opens"]);
    let axis = "<sensor type=\"perspective\">\n<string name=\"fov_axis\" value=\"y\"/></sensor>";
    let document = format!("<scene version=\"3.0.0\">{axis}</scene>");
    refused(&document, "fov_axis", &["`fov_axis` without `fov`"]);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let sphere =
        |value: &str| format!("<shape type=\"sphere\">\n<float name=\"radius\" value=\"{value}\"/></shape>");
    for value in ["0", "-0", "NaN", "inf", "-inf", "1e999", "", "one", "0x10", "1,5"] {
        all_refused(&[(
            "name=\"radius\"",
            &sphere(value),
            &["`radius`", "expected a finite number other than 0"],
        )]);
    }
    for value in ["1.5", "1e3", "99999999999999999999", ""] {
        let body = format!("<shape type=\"sphere\">\n<integer name=\"radius\" value=\"{value}\"/></shape>");
        all_refused(&[("name=\"radius\"", &body, &["is no integer"])]);
    }
    // 0 is accepted and means nearly smooth, as in Mitsuba.
    for (model, value) in ["roughconductor", "roughdielectric", "roughplastic"]
        .iter()
        .flat_map(|m| ["-0.1", "nan", "1e200"].map(|v| (m, v)))
    {
        let body = format!("<bsdf type=\"{model}\">\n<float name=\"alpha\" value=\"{value}\"/></bsdf>");
        all_refused(&[("name=\"alpha\"", &body, &[value])]);
    }
    for value in ["2", "-0.1", "0.5, 0.5, 1.01", "0.5, nan, 0.5", "1, 2", "#12345g"] {
        let body = format!("<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"{value}\"/></bsdf>");
        all_refused(&[("name=\"reflectance\"", &body, &["expected"])]);
    }
    // A spectrum of light is no reflectance, in whatever form it is written.
    for (kind, inside) in [
        ("uniform", "<float name=\"value\" value=\"5\"/>"),
        ("d65", ""),
        ("d65", "<rgb name=\"color\" value=\"2\"/>"),
        ("d65", "<texture type=\"checkerboard\"><rgb name=\"color1\" value=\"0.9\"/></texture>"),
        ("blackbody", ""),
    ] {
        let spectrum = format!("<spectrum type=\"{kind}\" name=\"reflectance\">{inside}</spectrum>");
        let body = format!("<bsdf type=\"diffuse\">\n{spectrum}</bsdf>");
        all_refused(&[("<spectrum", &body, &["no reflectance", "expected 0 to 1"])]);
    }
    all_refused(&[
        (
            "<spectrum",
            "<bsdf type=\"diffuse\">\n<spectrum name=\"reflectance\" value=\"2\"/></bsdf>",
            &["expected"],
        ),
        (
            "<spectrum",
            "<bsdf type=\"diffuse\">\n<spectrum name=\"reflectance\" value=\"500:0.1, 400:0.2\"/></bsdf>",
            &["expected"],
        ),
        (
            "<rgb",
            "<emitter type=\"constant\">\n<rgb name=\"radiance\" value=\"-1, 0, 0\"/></emitter>",
            &["expected"],
        ),
        (
            "<rgb",
            "<emitter type=\"constant\">\n<rgb name=\"radiance\" value=\"inf, 0, 0\"/></emitter>",
            &["expected"],
        ),
        (
            "<rgb",
            "<emitter type=\"constant\">\n<rgb name=\"radiance\" value=\"1e300\"/></emitter>",
            &["expected"],
        ),
        (
            "int_ior",
            "<bsdf type=\"dielectric\">\n<float name=\"int_ior\" value=\"0\"/></bsdf>",
            &["expected"],
        ),
        (
            "int_ior",
            "<bsdf type=\"dielectric\">\n<float name=\"int_ior\" value=\"-1.5\"/></bsdf>",
            &["expected"],
        ),
        (
            "int_ior",
            "<bsdf type=\"plastic\">\n<float name=\"int_ior\" value=\"1e-19\"/></bsdf>",
            &["from 1e-9 to 1e9"],
        ),
        (
            "int_ior",
            "<bsdf type=\"dielectric\">\n<spectrum name=\"int_ior\" value=\"1e160\"/></bsdf>",
            &["no index of refraction"],
        ),
        (
            "max_depth",
            "<integrator type=\"path\">\n<integer name=\"max_depth\" value=\"-2\"/></integrator>",
            &["expected"],
        ),
        (
            "max_depth",
            "<integrator type=\"path\">\n<integer name=\"max_depth\" value=\"1.5\"/></integrator>",
            &["expected"],
        ),
        (
            "shared_light_paths",
            "<integrator type=\"path\">\n<integer name=\"shared_light_paths\" value=\"4\"/></integrator>",
            &["4 light paths for 1 pixels", "`reuse` as well"],
        ),
        (
            "shared_light_paths",
            "<integrator type=\"path\"><integer name=\"reuse\" value=\"4\"/>\n<integer name=\"shared_light_paths\" value=\"8\"/></integrator>",
            &["8 light paths for 4 pixels", "at most 4"],
        ),
    ]);
}

#[test]
fn pictures_of_light_are_no_reflectances() {
    // One texel of 4, 4, 4.
    let picture = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".as_slice(), &[128, 128, 128, 131]];
    let texture =
        "<texture type=\"bitmap\" name=\"NAME\">\n<string name=\"filename\" value=\"a.hdr\"/></texture>";
    let text = |object: &str, name: &str| scene(&format!("{object}{}</bsdf>", texture.replace("NAME", name)));
    let folder = Folder::new(text("<bsdf type=\"diffuse\">", "reflectance").as_bytes());
    std::fs::write(folder.path().join("a.hdr"), picture.concat()).expect("written");
    folder.refused(&["texel (0, 0)", "[4.0, 4.0, 4.0]", "expected 0 to 1", "scene.xml:"]);
}

#[test]
fn spots_shine_into_less_than_a_half_space() {
    for value in ["-5", "0", "90", "180"] {
        let spot =
            format!("<emitter type=\"spot\">\n<float name=\"cutoff_angle\" value=\"{value}\"/></emitter>");
        all_refused(&[("name=\"cutoff_angle\"", &spot, &["`cutoff_angle`"])]);
    }
}

#[test]
fn transforms_that_flatten_are_refused() {
    let shape = |step: &str| {
        format!("<shape type=\"sphere\"><transform name=\"to_world\">\n{step}</transform></shape>")
    };
    for step in [
        r#"<scale value="0"/>"#,
        r#"<scale x="0"/>"#,
        r#"<scale value="nan"/>"#,
        r#"<scale value="1, 2"/>"#,
        r#"<matrix value="1 0 0 0  0 1 0 0  1 1 0 0  0 0 0 1"/>"#,
        r#"<matrix value="1 2 3  2 4 6  0 0 1"/>"#,
        r#"<matrix value="1 0 0 0  0 1 0 0"/>"#,
        r#"<rotate x="0" angle="30"/>"#,
        r#"<rotate x="1"/>"#,
        r#"<lookat origin="0,0,0" target="0,0,0" up="0,1,0"/>"#,
        r#"<lookat origin="0,0,0" target="0,1,0" up="0,1,0"/>"#,
        r#"<translate x="inf"/>"#,
        r#"<shear x="1"/>"#,
    ] {
        let tag = step.split(' ').next().unwrap_or_default();
        all_refused(&[(tag, &shape(step), &[])]);
    }
    all_refused(&[("<shape", &shape(r#"<translate x="1e38"/>"#), &["overflow", "expected a smaller shape"])]);
}

#[test]
fn cameras_and_films_that_cannot_be_are_refused() {
    let scene = |inside: &str| {
        format!("<scene version=\"3.0.0\">\n<sensor type=\"perspective\">\n{inside}\n</sensor>\n</scene>")
    };
    refused(
        &scene("<float name=\"near_clip\" value=\"20000\"/>"),
        "near_clip",
        &["beyond `far_clip`", "far_clip"],
    );
    for fov in ["0", "180", "-5", "NaN", "inf", "270"] {
        let text = scene(&format!("<float name=\"fov\" value=\"{fov}\"/>"));
        refused(&text, "\"fov\"", &["expected degrees above 0 and below 180"]);
    }
    let film = |width: &str, height: &str| {
        let size = format!(
            "<integer name=\"width\" value=\"{width}\"/><integer name=\"height\" value=\"{height}\"/>"
        );
        scene(&format!("<film type=\"hdrfilm\">\n{size}</film>"))
    };
    for (width, height) in [("0", "4"), ("4", "0"), ("-4", "4"), ("4.5", "4"), ("99999999999999999999", "1")]
    {
        refused(&film(width, height), "\"width\"", &["expected"]);
    }
    let start = Instant::now();
    refused(&film("100000", "10000"), "\"width\"", &["100000", "too large"]);
    assert!(start.elapsed().as_secs() < 10, "a film of 10⁹ pixels was not refused at once");
    let crop = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/>\n";
    refused(
        &scene(&format!("{crop}<integer name=\"crop_offset_x\" value=\"4\"/></film>")),
        "crop_offset_x",
        &["expected"],
    );
    refused(
        &scene(&format!("{crop}<integer name=\"crop_width\" value=\"5\"/></film>")),
        "crop_width",
        &["expected"],
    );
    refused(&scene("<float name=\"near_clip\" value=\"0\"/>"), "near_clip", &["positive"]);
    refused(
        &scene("<float name=\"near_clip\" value=\"2\"/>\n<float name=\"far_clip\" value=\"1\"/>"),
        "far_clip",
        &["beyond"],
    );
    refused(
        &scene("<transform name=\"to_world\"><scale value=\"2\"/></transform>"),
        "to_world",
        &["cannot be scaled"],
    );
    refused(
        &scene("<sampler type=\"sobol\">\n<integer name=\"sample_count\" value=\"0\"/></sampler>"),
        "sample_count",
        &["expected"],
    );
    refused(
        &scene("<film type=\"hdrfilm\">\n<rfilter type=\"boxx\"/></film>"),
        "boxx",
        &["did you mean `box`?"],
    );
}

#[test]
fn amounts_and_shapes_that_no_number_can_hold_are_refused() {
    let light = |inside: &str| format!("<emitter type=\"constant\">\n{inside}</emitter>");
    for (kind, parameter, value) in [
        ("d65", "rgb name=\"color\"", "-1, 0, 0.5"),
        ("d65", "rgb name=\"color\"", "1e300"),
        ("d65", "float name=\"scale\"", "1e300"),
        ("uniform", "float name=\"value\"", "1e300"),
        ("blackbody", "float name=\"scale\"", "1e300"),
        ("blackbody", "float name=\"temperature\"", "1e300"),
    ] {
        let spectrum = format!(
            "<spectrum type=\"{kind}\" name=\"radiance\">\n<{parameter} value=\"{value}\"/></spectrum>"
        );
        all_refused(&[(value, &light(&spectrum), &["expected"])]);
    }
    let cold = "<blackbody name=\"radiance\" temperature=\"5000K\"\nscale=\"-1e-6\"/>";
    all_refused(&[
        ("-1e-6", &light(cold), &["expected"]),
        ("3e38", &light("<rgb name=\"radiance\"\nvalue=\"3e38\"/>"), &["expected"]),
        ("3e38", &light("<spectrum name=\"radiance\"\nvalue=\"400:1, 700:3e38\"/>"), &["none above 1.7e38"]),
    ]);
    let of = |element: &str, kind: &str, name: &str, value: &str| {
        format!("<{element} type=\"{kind}\">\n<float name=\"{name}\" value=\"{value}\"/></{element}>")
    };
    let film = |filter: &str| {
        format!("<sensor type=\"perspective\"><film type=\"hdrfilm\">{filter}</film></sensor>")
    };
    let between = |index: &str| format!("<bsdf type=\"dielectric\">\n<{index}/></bsdf>");
    let too_dense = of("bsdf", "plastic", "int_ior", "4");
    all_refused(&[
        ("int_ior", &of("bsdf", "dielectric", "int_ior", "1e300"), &["no index of refraction"]),
        // A pole, and a peak, between two whole wavelengths.
        (
            "sellmeier",
            &between(r#"string name="sellmeier" value="0.001 0.25050025 1 0.01""#),
            &["inf at 500.5 nm"],
        ),
        (
            "int_ior",
            &between(r#"spectrum name="int_ior" value="400:1.5, 500.4:1.5, 500.5:1e10, 500.6:1.5, 800:1.5""#),
            &["at 500.5 nm"],
        ),
        ("<medium", &of("medium", "heterogeneous", "scale", "1e9"), &["free paths across", "at most 1e6"]),
        ("int_ior", &too_dense, &["exceeds 1", "expected a ratio of indices up to 3.8"]),
        ("stddev", &film(&of("rfilter", "gaussian", "stddev", "1e-9")), &["to 16"]),
        ("radius", &film(&of("rfilter", "tent", "radius", "1e-6")), &["to 16"]),
        ("\"B\"", &film(&of("rfilter", "mitchell", "B", "1e300")), &["-10 to 10"]),
    ]);
}

#[test]
fn meters_measure_one_number_along_a_direction() {
    let meter = |kind: &str, body: &str| {
        format!("<scene version=\"3.0.0\">\n<sensor type=\"{kind}\">\n{body}</sensor></scene>")
    };
    let film = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"1\"/><integer name=\"height\" value=\"2\"/></film>\n";
    let (origin, direction) =
        ("<point name=\"origin\" x=\"1\"/>\n", "<vector name=\"direction\" z=\"1\"/>\n");
    for kind in ["radiancemeter", "distant"] {
        refused(&meter(kind, film), "<film", &["1 × 2 pixels", "1 × 1"]);
        let none = origin.replace("origin", "direction").replace('1', "0");
        let body = if kind == "distant" { none } else { format!("{origin}{none}") };
        refused(&meter(kind, &body), "name=\"direction\"", &["no length"]);
    }
    refused(&meter("radiancemeter", origin), "origin", &["without `direction`"]);
    refused(&meter("radiancemeter", direction), "direction", &["without `origin`"]);
    let turned = format!("{direction}<transform name=\"to_world\"/>\n");
    refused(&meter("distant", &turned), "to_world", &["both"]);
    let targets = [
        ("<float name=\"target\" value=\"1\"/>", "cannot be a <float>"),
        ("<shape type=\"shapegroup\" name=\"target\"/>", "no surface"),
        ("<shape type=\"disk\" name=\"target\"><float name=\"a\" value=\"1\"/></shape>", "no parameter `a`"),
    ];
    for (target, message) in targets {
        refused(&meter("distant", target), "target", &[message]);
    }
}

#[test]
fn a_meter_of_irradiance_belongs_to_a_shape() {
    let scene = |body: &str| format!("<scene version=\"3.0.0\">\n{body}</scene>");
    let of = |kind: &str, body: &str| {
        scene(&format!("<shape type=\"disk\">\n<sensor type=\"{kind}\">{body}</sensor></shape>"))
    };
    refused(
        &scene("<sensor type=\"irradiancemeter\"/>"),
        "<sensor",
        &["without a shape", "inside a <shape>"],
    );
    refused(&of("perspective", ""), "<sensor", &["a sensor `perspective`", "`irradiancemeter`"]);
    refused(&of("irradiancemeter", "<transform name=\"to_world\"/>"), "to_world", &["no parameter"]);
    let group = "<shape type=\"shapegroup\"><shape type=\"disk\">\n<sensor type=\"irradiancemeter\"/></shape></shape>";
    refused(&scene(group), "<sensor", &["cannot contain"]);
    let two = "<shape type=\"disk\"><sensor type=\"irradiancemeter\"/>\n<sensor type=\"irradiancemeter\" id=\"b\"/></shape>";
    refused(&scene(two), "id=\"b\"", &["second"]);
}

#[test]
fn numbers_are_judged_as_they_are_kept() {
    let grey = |value: &str| {
        format!("<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"{value}\"/></bsdf>")
    };
    refused(&scene(&grey("1.0000001")), "1.0000001", &["1.0000001 is out of range"]);
    refused(&scene(&grey("-1e-50")), "-1e-50", &["-1e-50 is out of range"]);
    refused(&scene(&grey("0.1, 0.2")), "0.1", &["`0.1, 0.2` is 2 numbers"]);
    // Which is 1 as `f32`: what is refused comes behind it.
    refused(&scene(&format!("{}\n<nothing/>", grey("1.00000001"))), "<nothing", &["no place here"]);
    let specular = |value: &str| {
        format!("<bsdf type=\"principled\">\n<float name=\"specular\" value=\"{value}\"/></bsdf>")
    };
    refused(&scene(&specular("12.5")), "12.5", &["0 to 12"]);
    refused(&scene(&format!("{}\n<nothing/>", specular("12"))), "<nothing", &["no place here"]);
    let focal = "<scene version=\"3.0.0\"><sensor type=\"perspective\">\n<string name=\"focal_length\" value=\"far\"/></sensor></scene>";
    refused(focal, "far", &["`far` is no focal length"]);
}
