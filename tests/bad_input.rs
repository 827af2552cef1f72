//! Malformed input: the program says what is wrong and where, exits with 2, and touches nothing.

mod refusal;

use refusal::{Folder, SENSOR, refused_with};
use std::time::Instant;

/// Asserts that a scene is refused with an error that points at the first line that holds `place` and shows it.
fn refused(scene: &str, place: &str, words: &[&str]) {
    let line = scene.lines().position(|line| line.contains(place)).unwrap_or(0) + 1;
    let at = format!("scene.xml:{line}:");
    Folder::new(scene.as_bytes()).refused(&[words, &[at.as_str(), place]].concat());
}

/// `(where, body, words)`: a scene with this body is refused with a message that points at the line of `where` and
/// holds all the words.
type Trial<'a> = (&'a str, &'a str, &'a [&'a str]);

fn all_refused(trials: &[Trial]) {
    for (place, body, words) in trials {
        refused(&format!("<scene version=\"3.0.0\">\n{SENSOR}\n{body}\n</scene>\n"), place, words);
    }
}

#[test]
fn unknown_names_are_refused_and_the_known_ones_listed() {
    all_refused(&[
        (
            "difuse",
            r#"<bsdf type="difuse"/>"#,
            &["unknown bsdf `difuse`", "did you mean `diffuse`?", "roughconductor"],
        ),
        (
            "spher",
            r#"<shape type="spher"/>"#,
            &["unknown shape `spher`", "did you mean `sphere`?", "rectangle"],
        ),
        ("whatever", r#"<emitter type="whatever"/>"#, &["unknown emitter `whatever`", "envmap", "constant"]),
        ("bogus", r#"<integrator type="bogus"/>"#, &["unknown integrator `bogus`", "path", "direct"]),
        (
            "alhpa",
            "<bsdf type=\"roughconductor\">\n<float name=\"alhpa\" value=\"0.1\"/></bsdf>",
            &["no parameter `alhpa`", "did you mean `alpha`?", "distribution"],
        ),
        (
            "foo",
            "<shape type=\"sphere\">\n<float name=\"foo\" value=\"1\"/></shape>",
            &["no parameter `foo`", "radius"],
        ),
        ("raduis", "<shape type=\"sphere\" raduis=\"1\"/>", &["no attribute `raduis`", "known:"]),
        (
            "ggxx",
            "<bsdf type=\"roughconductor\">\n<string name=\"distribution\" value=\"ggxx\"/></bsdf>",
            &["ggxx", "beckmann"],
        ),
        (
            "Unobtainium",
            "<bsdf type=\"conductor\">\n<string name=\"material\" value=\"Unobtainium\"/></bsdf>",
            &["Unobtainium", "Cu"],
        ),
        ("<widget", "<widget/>", &["<widget> has no place here", "shape", "emitter"]),
        ("<shape>", "<shape>\n</shape>", &["no `type`"]),
        ("radius", "<shape type=\"sphere\">\n<float name=\"radius\"/></shape>", &["no `value`"]),
        (
            "\"2\"",
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/>\n<float name=\"radius\" value=\"2\"/></shape>",
            &["`radius` is given twice"],
        ),
        (
            "<string",
            "<shape type=\"sphere\">\n<string name=\"radius\" value=\"1\"/></shape>",
            &["expected <float>"],
        ),
    ]);
}

#[test]
fn references_that_lead_nowhere_or_in_circles_are_refused() {
    all_refused(&[
        (
            "whte",
            "<bsdf type=\"diffuse\" id=\"white\"/>\n<shape type=\"sphere\"><ref id=\"whte\"/></shape>",
            &["no object with id `whte`", "did you mean `white`?"],
        ),
        (
            "plastic",
            "<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"plastic\" id=\"a\"/>",
            &["the id `a` is taken"],
        ),
        ("id=\"a\"", "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf>", &["contains itself"]),
        (
            "id=\"a\"",
            "<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf>\n<bsdf type=\"mask\" id=\"b\"><ref id=\"a\"/></bsdf>",
            &["contains itself"],
        ),
        (
            "<ref",
            "<bsdf type=\"diffuse\" id=\"a\"/>\n<shape type=\"sphere\" id=\"s\"/><bsdf type=\"twosided\"><ref id=\"s\"/></bsdf>",
            &[],
        ),
        (
            "<ref id=\"x\"",
            "<alias id=\"x\" as=\"y\"/><alias id=\"y\" as=\"x\"/>\n<shape type=\"sphere\"><ref id=\"x\"/></shape>",
            &["`x`"],
        ),
    ]);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let sphere =
        |value: &str| format!("<shape type=\"sphere\">\n<float name=\"radius\" value=\"{value}\"/></shape>");
    for value in ["-1", "0", "NaN", "inf", "-inf", "1e999", "", "one", "0x10", "1,5"] {
        all_refused(&[("name=\"radius\"", &sphere(value), &["`radius`", "expected a positive number"])]);
    }
    // 0 is accepted and means nearly smooth, as in Mitsuba.
    for (model, value) in
        ["roughconductor", "roughdielectric", "roughplastic"].iter().flat_map(|m| [(m, "-0.1"), (m, "nan")])
    {
        let body = format!("<bsdf type=\"{model}\">\n<float name=\"alpha\" value=\"{value}\"/></bsdf>");
        all_refused(&[("name=\"alpha\"", &body, &[value])]);
    }
    for value in ["2", "-0.1", "0.5, 0.5, 1.01", "0.5, nan, 0.5", "1, 2", "#12345g"] {
        let body = format!("<bsdf type=\"diffuse\">\n<rgb name=\"reflectance\" value=\"{value}\"/></bsdf>");
        all_refused(&[("name=\"reflectance\"", &body, &["expected"])]);
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
            "max_depth",
            "<integrator type=\"path\">\n<integer name=\"max_depth\" value=\"-2\"/></integrator>",
            &["expected"],
        ),
        (
            "max_depth",
            "<integrator type=\"path\">\n<integer name=\"max_depth\" value=\"1.5\"/></integrator>",
            &["expected"],
        ),
    ]);
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
fn scenes_that_make_no_sense_are_refused() {
    all_refused(&[
        (
            "dielectric",
            "<bsdf type=\"twosided\">\n<bsdf type=\"dielectric\"/></bsdf>",
            &["two-sided", "opaque"],
        ),
        (
            "<emitter",
            "<emitter type=\"area\">\n<rgb name=\"radiance\" value=\"1\"/></emitter>",
            &["without a shape", "<shape>"],
        ),
        (
            "point",
            "<shape type=\"sphere\">\n<emitter type=\"point\"/></shape>",
            &["expected an `area` emitter"],
        ),
        (
            "direct",
            "<integrator type=\"path\"/>\n<integrator type=\"direct\"/>",
            &["second integrator", "only one"],
        ),
        (
            "\"2\"",
            "<emitter type=\"constant\"/>\n<emitter type=\"constant\" id=\"2\"/>",
            &["second environment"],
        ),
        ("hello", "<shape type=\"sphere\"/>\nhello", &["text between elements"]),
    ]);
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"sphere\"/>\n</scene>",
        "<scene",
        &["no sensor", "add a <sensor>"],
    );
    refused("<scene>\n</scene>", "<scene", &["no `version`", "3.0.0"]);
    refused("<scene version=\"3\">\n</scene>", "<scene", &["is no version"]);
    refused("<bsdf version=\"3.0.0\" type=\"diffuse\"/>", "<bsdf", &["expected <scene>"]);
}

#[test]
fn documents_that_are_no_xml_or_too_much_of_it_are_refused() {
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"sphere\">\n</scene>\n",
        "</scene",
        &["not well-formed"],
    );
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"a\" type=\"b\"/>\n</scene>",
        "type=\"b\"",
        &["not well-formed"],
    );
    refused("<scene version=\"3.0.0\">\n<shape type=sphere/>\n</scene>", "sphere", &["not well-formed"]);
    refused("<scene version=\"3.0.0\">\n&unknown;\n</scene>", "&unknown;", &["not well-formed"]);
    refused("", "", &["not well-formed"]);
    let mut bomb = "<!DOCTYPE scene [\n<!ENTITY a0 \"aaaaaaaaaa\">\n".to_owned();
    for i in 1..20 {
        bomb += &format!("<!ENTITY a{i} \"{}\">\n", format!("&a{};", i - 1).repeat(10));
    }
    refused(&(bomb + "]>\n<scene version=\"3.0.0\">&a19;</scene>"), "<!DOCTYPE", &["not well-formed", "DTD"]);
    let external =
        "<!DOCTYPE scene [<!ENTITY x SYSTEM \"/etc/passwd\">]>\n<scene version=\"3.0.0\">&x;</scene>";
    refused(external, "<!DOCTYPE", &["not well-formed", "DTD"]);
    let deep =
        format!("<scene version=\"3.0.0\">{}{}</scene>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    refused(&deep, "<a>", &["nested"]);
    let folder = Folder::new(b"<scene version=\"3.0.0\">\xff\xfe</scene>");
    folder.refused(&["scene.xml", "UTF-8"]);
}

/// A few lines that mean a thousand times as much each as the line before.
#[test]
fn what_multiplies_is_refused_soon() {
    let begin = Instant::now();
    let levels = |count: usize, first: &str, next: &dyn Fn(usize) -> String| {
        (1..count).fold(first.to_owned(), |text, level| text + &next(level))
    };
    let blends = levels(40, r#"<bsdf type="diffuse" id="b0"/>"#, &|i| {
        let below = i - 1;
        format!(
            "\n<bsdf type=\"blendbsdf\" id=\"b{i}\"><float name=\"weight\" value=\"0.5\"/><ref id=\"b{below}\"/><ref id=\"b{below}\"/></bsdf>"
        )
    });
    let masks = levels(5000, r#"<bsdf type="diffuse" id="b0"/>"#, &|i| {
        format!("\n<bsdf type=\"mask\" id=\"b{i}\"><ref id=\"b{}\"/></bsdf>", i - 1)
    });
    let values = levels(60, r#"<default name="x0" value="x"/>"#, &|i| {
        format!("\n<default name=\"x{i}\" value=\"$x{0}$x{0}\"/>", i - 1)
    });
    all_refused(&[
        ("id=\"b0\"", &blends, &["repeat objects within objects more than"]),
        ("id=\"b0\"", &masks, &["more than 64 deep"]),
        ("name=\"x27\"", &values, &["longer than 134217728 bytes"]),
    ]);
    let folder = Folder::new(b"<scene version=\"3.0.0\">\n<include filename=\"1.xml\"/></scene>");
    for file in 1..15 {
        let twice = format!("<include filename=\"{}.xml\"/>", file + 1).repeat(4);
        let text = if file < 14 { twice } else { String::new() };
        std::fs::write(
            folder.path().join(format!("{file}.xml")),
            format!("<scene version=\"3.0.0\">{text}</scene>"),
        )
        .expect("written");
    }
    folder.refused(&["more than 4096 files are included"]);
    assert!(begin.elapsed().as_secs() < 60, "{:?}", begin.elapsed());
}

#[test]
fn parameters_and_includes_are_held_to_account() {
    all_refused(&[
        (
            "$size",
            "<default name=\"sise\" value=\"1\"/>\n<shape type=\"sphere\"><float name=\"radius\" value=\"$size\"/></shape>",
            &["undefined parameter `$size`", "did you mean `sise`?", "-D"],
        ),
        ("missing.xml", "<include filename=\"missing.xml\"/>", &["missing.xml"]),
        ("scene.xml", "<include filename=\"scene.xml\"/>", &["includes itself"]),
        ("nowhere", "<path value=\"nowhere\"/>", &["no folder `nowhere`"]),
    ]);
    let scene = format!("<scene version=\"3.0.0\">\n{SENSOR}\n<include filename=\"other.xml\"/>\n</scene>");
    let other = "<scene version=\"3.0.0\">\n<include filename=\"scene.xml\"/>\n</scene>";
    refused_with(
        &scene,
        &[("other.xml", other.as_bytes())],
        &["other.xml:2:", "includes itself", "<include filename"],
    );
    refused_with(
        &scene,
        &[("other.xml", b"<scene version=\"3.0.0\">\n<shape type=\"q\"/></scene>")],
        &["other.xml:2:", "`q`"],
    );
    let plain = format!("<scene version=\"3.0.0\">{SENSOR}<default name=\"used\" value=\"1\"/></scene>");
    let folder = Folder::new(plain.as_bytes());
    folder.refused_given(&["-D", "unused=3"], &["unused", "no parameter"]);
    folder.refused_given(&["-D", "novalue"], &["NAME=VALUE"]);
    folder.refused_given(&["-D", "=3"], &["expected a name"]);
}

#[test]
fn channels_that_no_file_could_hold_are_refused() {
    let aov = |aovs: &str| {
        format!("<integrator type=\"aov\">\n<string name=\"aovs\" value=\"{aovs}\"/></integrator>")
    };
    let long = "d".repeat(101) + ":depth";
    all_refused(&[
        ("name=\"aovs\"", &aov(""), &["no channel is asked for", "dd:depth"]),
        (":depth", &aov(&long), &["101 bytes", "at most 100"]),
        ("name=\"aovs\"", &aov("variance.R:depth"), &["`variance` is taken"]),
        ("moment", r#"<integrator type="moment"/>"#, &["no nested <integrator>"]),
        (
            "depth",
            "<integrator type=\"moment\">\n<integrator type=\"depth\"/></integrator>",
            &["`depth` sees no light"],
        ),
        (
            "<integrator type=\"path\" name=\"variance\"",
            "<integrator type=\"moment\">\n<integrator type=\"path\" name=\"variance\"/></integrator>",
            &["taken"],
        ),
    ]);
}

#[test]
fn groups_instances_and_maps_say_what_they_cannot_be() {
    let group = |member: &str| format!(r#"<shape type="shapegroup" id="g">{member}</shape>"#);
    let ball = r#"<shape type="sphere"/>"#;
    let instance = |inside: &str| format!("<shape type=\"instance\">\n{inside}</shape>");
    let map =
        |kind: &str| format!("{BALL}<bsdf type=\"{kind}\"><bsdf type=\"diffuse\"/>\n{BOARD}</bsdf></shape>");
    const BALL: &str = r#"<shape type="sphere">"#;
    const BOARD: &str = r#"<texture name="normalmap" type="checkerboard"/>"#;
    let lamp = format!("{BALL}\n<emitter type=\"area\"/></shape>");
    let tiny = format!("{}<transform name=\"to_world\">\n<scale value=\"1e-150\"/></transform>", group(ball));
    all_refused(&[
        ("<emitter", &group(&lamp), &["a shape in a group cannot shine"]),
        ("shapegroup", &group(&group(ball).replace("\"g\"", "\"h\"")), &["cannot be grouped again"]),
        ("instance", &group(&instance(&group(ball).replace("\"g\"", "\"h\""))), &["cannot be grouped again"]),
        ("instance", &instance(""), &["an instance of nothing", "shapegroup"]),
        ("sphere", &instance(ball), &["an instance of a shape that is no group"]),
        ("<transform", &instance(&tiny), &["this transform overflows"]),
        ("checkerboard", &map("normalmap"), &["holds no normals", "three channels"]),
        ("checkerboard", &map("bumpmap"), &["has no slope", "bitmap"]),
    ]);
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
    ]);
    let of = |element: &str, kind: &str, name: &str, value: &str| {
        format!("<{element} type=\"{kind}\">\n<float name=\"{name}\" value=\"{value}\"/></{element}>")
    };
    let film = |filter: &str| {
        format!("<sensor type=\"perspective\"><film type=\"hdrfilm\">{filter}</film></sensor>")
    };
    let too_dense = of("bsdf", "plastic", "int_ior", "4");
    all_refused(&[
        ("int_ior", &of("bsdf", "dielectric", "int_ior", "1e300"), &["no index of refraction"]),
        ("int_ior", &too_dense, &["exceeds 1", "expected a ratio of indices up to 3.8"]),
        ("stddev", &film(&of("rfilter", "gaussian", "stddev", "1e-9")), &["to 16"]),
        ("radius", &film(&of("rfilter", "tent", "radius", "1e-6")), &["to 16"]),
        ("\"B\"", &film(&of("rfilter", "mitchell", "B", "1e300")), &["-10 to 10"]),
    ]);
}
