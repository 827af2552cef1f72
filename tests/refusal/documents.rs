//! Documents that are no XML or too much of it, parameters and includes.

use super::{Folder, SENSOR, all_refused, refused, refused_with};
use std::time::Instant;

#[test]
fn documents_that_are_no_xml_or_too_much_of_it_are_refused() {
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"sphere\">\n</scene>\n",
        "</scene",
        &["not well-formed", "</scene> where <shape> is open", "expected </shape> before it"],
    );
    refused(
        "<scene version=\"3.0.0\">\n<shape type=\"a\" type=\"b\"/>\n</scene>",
        "type=\"b\"",
        &["not well-formed"],
    );
    refused("<scene version=\"3.0.0\">\n<shape type=sphere/>\n</scene>", "sphere", &["not well-formed"]);
    refused("<scene version=\"3.0.0\">\n&unknown;\n</scene>", "&unknown;", &["not well-formed"]);
    refused("<scene version=\"3.0.0\">\n<!-- a -- b\n</scene>", "<!-- a", &["not well-formed", "comment"]);
    refused("", "", &["not well-formed"]);
    let mut bomb = "<!DOCTYPE scene [\n<!ENTITY a0 \"aaaaaaaaaa\">\n".to_owned();
    for i in 1..20 {
        bomb += &format!("<!ENTITY a{i} \"{}\">\n", format!("&a{};", i - 1).repeat(10));
    }
    refused(
        &(bomb + "]>\n<scene version=\"3.0.0\">&a19;</scene>"),
        "<!DOCTYPE",
        &["scene.xml:1:1", "a DTD", "leave it out"],
    );
    let external = "<?xml version=\"1.0\"?>\n<!DOCTYPE scene [<!ENTITY x SYSTEM \"/etc/passwd\">]>\n<scene version=\"3.0.0\">&x;</scene>";
    refused(external, "<!DOCTYPE", &["scene.xml:2:1", "a DTD", "leave it out"]);
    let deep =
        format!("<scene version=\"3.0.0\">{}{}</scene>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    refused(&deep, "<a>", &["nested"]);
    let folder = Folder::new(b"<scene version=\"3.0.0\">\xff\xfe</scene>");
    folder.refused(&["scene.xml", "UTF-8"]);
}

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
        ("scene.xml", "<include filename=\"scene.xml\"/>", &["includes itself", "expected another file"]),
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
