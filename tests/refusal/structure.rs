//! Scenes that make no sense: unknown names, references that lead nowhere, objects in a wrong place.

use super::{Folder, all_refused, refused};

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
        ("<boolean", "<boolean name=\"kd_fast\" value=\"true\"/>", &["<boolean> has no place here"]),
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
fn media_that_cannot_be_meant_are_refused() {
    all_refused(&[
        (
            "homogenous",
            r#"<shape type="sphere"><medium name="interior" type="homogenous"/></shape>"#,
            &["unknown medium `homogenous`", "did you mean `homogeneous`?"],
        ),
        (
            "<bsdf",
            r#"<shape type="sphere"><bsdf name="interior" type="null"/></shape>"#,
            &["`interior` cannot be a <bsdf>", "expected <medium>"],
        ),
        (
            "\"1\"",
            r#"<phase type="hg"><float name="g" value="1"/></phase>"#,
            &["`g`", "above −1 and below 1"],
        ),
        ("<phase", r#"<phase type="tabphase"/>"#, &["there are no `values`", "at least two"]),
        (
            "<phase",
            r#"<phase type="blendphase"><float name="weight" value="0.5"/><phase type="hg"/></phase>"#,
            &["other than two phase functions", "expected two"],
        ),
        (
            "1.5",
            r#"<phase type="blendphase"><float name="weight" value="1.5"/><phase type="hg"/><phase type="hg"/></phase>"#,
            &["1.5 is out of range", "0 to 1"],
        ),
        (
            "<rgb",
            r#"<phase type="blendphase"><rgb name="weight" value="0, 1, 0"/><phase type="hg"/><phase type="hg"/></phase>"#,
            &["is no colour", "a number or a volume of one channel"],
        ),
        (
            "\"1\"",
            r#"<phase type="tabphase"><string name="values" value="1"/></phase>"#,
            &["too few values", "at least two"],
        ),
        (
            "1, -2",
            r#"<phase type="tabphase"><string name="values" value="1, -2"/></phase>"#,
            &["-2 is no density", "at least 0"],
        ),
        (
            "0 0",
            r#"<phase type="tabphase"><string name="values" value="0 0"/></phase>"#,
            &["all values are 0"],
        ),
        (
            "1.5",
            r#"<medium type="homogeneous"><float name="albedo" value="1.5"/></medium>"#,
            &["1.5 is out of range"],
        ),
        (
            "-2",
            r#"<medium type="homogeneous"><float name="sigma_t" value="-2"/></medium>"#,
            &["-2 is out of range"],
        ),
        (
            "<texture",
            r#"<medium type="homogeneous"><texture name="albedo" type="checkerboard"/></medium>"#,
            &["no value in space", "<volume>"],
        ),
        (
            "<volume",
            r#"<medium type="heterogeneous"><volume name="sigma_t" type="gridvolume"/></medium>"#,
            &["needs a `filename`"],
        ),
        (
            "<phase type=\"hg\"",
            r#"<medium type="homogeneous"><phase type="isotropic"/><phase type="hg"/></medium>"#,
            &["a second <phase>"],
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
            &["the id `a` is taken by the <bsdf> at ", ".xml:"],
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
            &["a <shape> is no <bsdf>", "expected one <bsdf> or two"],
        ),
        (
            "<alias id=\"x\"",
            "<alias id=\"x\" as=\"y\"/><alias id=\"y\" as=\"x\"/>\n<shape type=\"sphere\"><ref id=\"x\"/></shape>",
            &["`x`"],
        ),
        (
            "\"whit\"",
            "<bsdf type=\"diffuse\" id=\"white\"/>\n<alias id=\"whit\" as=\"w\"/>",
            &["no object has the id `whit`", "did you mean `white`?"],
        ),
    ]);
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
    for (kind, name) in [("point", "intensity"), ("spot", "intensity"), ("directional", "irradiance")] {
        let texture = format!("<texture name=\"{name}\" type=\"checkerboard\"/>");
        let lamp = format!("<emitter type=\"{kind}\">\n{texture}</emitter>");
        all_refused(&[("<texture", &lamp, &["cannot be textured", "the same everywhere"])]);
    }
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"sphere\"/>\n</scene>",
        "<scene",
        &["no sensor", "add a <sensor>"],
    );
    refused("<scene>\n</scene>", "<scene", &["no `version`", "3.0.0"]);
    refused("<bsdf type=\"diffuse\"/>", "<bsdf", &["the root is a <bsdf>", "expected <scene version"]);
    refused("<scene version=\"3\">\n</scene>", "<scene", &["is no version"]);
    refused("<bsdf version=\"3.0.0\" type=\"diffuse\"/>", "<bsdf", &["expected <scene>"]);
}

/// A few lines, each of which expands to a thousand times the line before.
#[test]
fn channels_that_no_file_could_hold_are_refused() {
    let aov = |aovs: &str| {
        format!("<integrator type=\"aov\">\n<string name=\"aovs\" value=\"{aovs}\"/></integrator>")
    };
    let long = "d".repeat(245) + ":depth";
    let sensor = |bands: &str| {
        let bands: String = bands
            .split('|')
            .map(|band| band.split_once('=').unwrap_or((band, "400:1, 700:1")))
            .map(|(name, nm)| format!("\n<spectrum name=\"{name}\" value=\"{nm}\"/>"))
            .collect();
        format!(
            r#"<scene version="3.0.0"><sensor type="perspective"><film type="specfilm">{bands}</film></sensor></scene>"#
        )
    };
    // Of two bands with the same centroid the first keeps its name.
    refused(&sensor("R|ω"), "name=\"R\"", &["two channels would have the name `R`"]);
    refused(&sensor("|ω"), "name=\"\"", &["a channel would have no name"]);
    refused(&sensor("variance.R|ω"), "name=\"variance.R\"", &["`variance` is taken"]);
    refused(&sensor("λ|ω"), "name=\"λ\"", &["ASCII"]);
    refused(
        &sensor("b.T|c").replace(
            "</scene>",
            &format!("\n{}</scene>", aov("b:depth").replace("/></int", "/><integrator type=\"path\"/></int")),
        ),
        "<integrator type=\"aov\"",
        &["two channels would have the name `b.T`"],
    );
    all_refused(&[
        ("name=\"aovs\"", &aov(""), &["no channel is asked for", "dd:depth"]),
        (":depth", &aov(&long), &["247 characters", "more than 246"]),
        ("name=\"aovs\"", &aov("variance.R:depth"), &["`variance` is taken"]),
        ("name=\"aovs\"", &aov("d:depth,d:depth"), &["two channels would have the name `d.T`"]),
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
    let shared = format!(
        "<emitter type=\"area\" id=\"e\"/>{BALL}<ref id=\"e\"/></shape>{}",
        group(&format!("{BALL}\n<ref id=\"e\"/></shape>"))
    );
    all_refused(&[
        ("<emitter", &group(&lamp), &["a shape in a group cannot shine"]),
        ("shapegroup", &group(&group(ball).replace("\"g\"", "\"h\"")), &["cannot be grouped again"]),
        ("instance", &group(&instance(&group(ball).replace("\"g\"", "\"h\""))), &["cannot be grouped again"]),
        ("instance", &instance(""), &["there is no nested <shape>", "shapegroup"]),
        ("<bsdf", &instance("<bsdf type=\"diffuse\"/>"), &["a <bsdf> is no <shape>", "shapegroup"]),
        (
            "=\"h\"",
            &instance(&format!("{}\n{}", group(ball), group(ball).replace("\"g\"", "\"h\""))),
            &["a second <shape>"],
        ),
        ("<ref id=\"e\"/></shape></shape>", &shared, &["a shape in a group cannot shine"]),
        ("sphere", &instance(ball), &["an instance of a shape that is no group"]),
        ("<transform", &instance(&tiny), &["this transform overflows"]),
        ("checkerboard", &map("normalmap"), &["holds no normals", "three channels"]),
        ("checkerboard", &map("bumpmap"), &["has no slope", "bitmap"]),
    ]);
}

#[test]
fn what_stands_in_a_wrong_place_is_refused_there() {
    all_refused(&[
        ("<spectrum", "<spectrum value=\"1\"/>", &["a value has no place here", "`type`"]),
        (
            "<transform/>",
            "<shape type=\"cube\">\n<transform/></shape>",
            &["this <transform>", "has no `name`"],
        ),
        ("<bsdf/>", "<bsdf type=\"diffuse\">\n<bsdf/></bsdf>", &["cannot contain this <bsdf>"]),
    ]);
    let folder = Folder::new(b"<bsdf version=\"3.0.0\" type=\"diffuse\"/>");
    folder.refused_given(&["--seed", "1"], &["the root is a <bsdf>", "expected <scene>"]);
}
