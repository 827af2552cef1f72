//! Unusable files and command lines: the program gives the reason, exits with 2, and changes nothing.

use super::{Folder, SENSOR, refused_with, scene};
use std::process::Command;

fn mesh_refused(kind: &str, content: &[u8], words: &[&str]) {
    let body = format!("<shape type=\"{kind}\">\n<string name=\"filename\" value=\"m\"/></shape>");
    refused_with(
        &scene(&body),
        &[("m", content)],
        &[&["scene.xml:4:", "<string name=\"filename\""], words].concat(),
    );
}

/// A triangle as binary PLY, whose header declares the given counts, with the given third index.
fn ply(vertices: &str, faces: &str, z: f32, last: i32) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for v in [0.0, 0.0, z, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f32] {
        bytes.extend(v.to_le_bytes());
    }
    bytes.push(3);
    for index in [0, 1, last] {
        bytes.extend(index.to_le_bytes());
    }
    bytes
}

#[test]
fn meshes_that_are_damaged_are_refused() {
    let whole = ply("3", "1", 0.0, 2);
    for cut in [whole.len() - 1, whole.len() - 12, whole.len() - 20, 100, 4, 0] {
        mesh_refused("ply", &whole[..cut], &["m:", "expected a whole mesh"]);
    }
    mesh_refused("ply", &ply("3", "1", 0.0, 3), &["vertex 3 of 3"]);
    mesh_refused("ply", &ply("3", "1", 0.0, -1), &["vertex -1 of 3"]);
    mesh_refused("ply", &ply("3", "1", f32::NAN, 2), &["NaN"]);
    mesh_refused("ply", &ply("3", "1", f32::INFINITY, 2), &["infinite"]);
    for count in ["4000000000", "18446744073709551615", "99999999999999999999999", "-1", "x"] {
        mesh_refused("ply", &ply(count, "1", 0.0, 2), &[count]);
        mesh_refused("ply", &ply("3", count, 0.0, 2), &[count]);
    }
    mesh_refused("ply", &ply("0", "0", 0.0, 2)[..160], &["m:"]);
    mesh_refused("ply", b"hello", &["line 1", "ply"]);
    let cornered = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n\
        0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n";
    mesh_refused("ply", cornered, &["`texcoord`", "at every corner"]);
    mesh_refused("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["line 4", "position 4"]);
    mesh_refused("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", &["line 4"]);
    mesh_refused("obj", b"v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", &["line 2", "nan"]);
    mesh_refused("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0 nan\nf 1 2 3\n", &["line 3", "nan"]);
    mesh_refused("obj", b"", &["no triangles"]);
    mesh_refused("serialized", b"\x1c\x04\x04\x00", &["byte 0"]);
}

#[test]
fn missing_and_damaged_files_are_refused_where_they_are_named() {
    for kind in ["ply", "obj", "serialized"] {
        let body = format!("<shape type=\"{kind}\">\n<string name=\"filename\" value=\"gone\"/></shape>");
        refused_with(&scene(&body), &[], &["scene.xml:4:", "no file `gone`", "<string"]);
    }
    let bitmap = "<bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"bitmap\">\n\
                  <string name=\"filename\" value=\"b.png\"/></texture></bsdf>";
    refused_with(&scene(bitmap), &[], &["scene.xml:4:", "no file `b.png`"]);
    refused_with(&scene(bitmap), &[("b.png", b"\x89PNG\r\n\x1a\n\0\0")], &["scene.xml:4:", "b.png"]);
    refused_with(&scene(bitmap), &[("b.png", &vast_png())], &["scene.xml:4:", "b.png"]);
    let map = "<emitter type=\"envmap\">\n<string name=\"filename\" value=\"e.exr\"/></emitter>";
    refused_with(&scene(map), &[], &["scene.xml:4:", "no file `e.exr`"]);
    refused_with(&scene(map), &[("e.exr", b"v/1\x01junk")], &["scene.xml:4:", "e.exr", "expected a whole"]);
    let spectrum = "<bsdf type=\"diffuse\">\n<spectrum name=\"reflectance\" filename=\"a.spd\"/></bsdf>";
    refused_with(&scene(spectrum), &[], &["scene.xml:4:", "no file `a.spd`"]);
    for (content, line) in [("400 x\n", "line 1"), ("400 0.5\n500 nan\n", "line 2"), ("", "two wavelengths")]
    {
        refused_with(
            &scene(spectrum),
            &[("a.spd", content.as_bytes())],
            &["scene.xml:4:", "a.spd", line, "expected"],
        );
    }
    let folder = Folder::new(b"");
    folder.command_refused(&["render", "gone.xml", "-o", "out.exr"], &["gone.xml"]);
    folder.command_refused(&["render", ".", "-o", "out.exr"], &["cannot read"]);
    folder.command_refused(&["explain", "gone.xml"], &["gone.xml"]);
    folder.command_refused(&["replay", "gone.xml", "--pixel", "0,0", "--sample", "0"], &["gone.xml"]);
}

/// A PNG that declares 200 000 × 200 000 pixels and contains none.
fn vast_png() -> Vec<u8> {
    let mut header = b"IHDR".to_vec();
    header.extend([200_000u32.to_be_bytes(), 200_000u32.to_be_bytes()].concat());
    header.extend([8, 2, 0, 0, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(&header);
    [b"\x89PNG\r\n\x1a\n".as_slice(), &13u32.to_be_bytes(), &header, &crc.sum().to_be_bytes()].concat()
}

#[test]
fn command_lines_that_make_no_sense_are_refused() {
    let folder = Folder::new(scene("").as_bytes());
    let trials: &[(&[&str], &str)] = &[
        (&["--size", "0x5"], "no pixels"),
        (&["--size", "5"], "640x480"),
        (&["--size=-4x4"], "640x480"),
        (&["--size", "100000x10000"], "too large"),
        (&["--samples", "3..8"], "multiple of 4"),
        (&["--samples", "8..8"], "empty"),
        (&["--samples", "8..4"], "empty"),
        (&["--samples", "0..99999999999"], "at most"),
        (&["--samples", "4"], "0..64"),
        (&["--crop", "3,3,2,2"], "0,0,4,4"),
        (&["--crop", "4294967295,0,4294967295,1"], "0,0,4,4"),
        (&["--crop", "0,0,0,1"], "1x1"),
        (&["--crop", "0,0,4"], "X,Y,W,H"),
        (&["--spp", "0"], "1..="),
        (&["--spp", "1.5"], "1.5"),
        (&["--spp", "4", "--samples", "0..4"], "--samples"),
        (&["--seed", "4294967296"], "4294967296"),
        (&["--color", "cmyk"], "`spectral` or `rgb`"),
        (&["--integrator", "pth"], "'path'"),
        (&["--sampler", "sobl"], "'sobol'"),
        (&["--max-depth", "-5"], "-1..="),
        (&["--bogus"], "--bogus"),
        (&["--png", "gone/a.png"], "gone"),
        (&["--png", "scene.xml/a.png"], "scene.xml"),
        (&["--png", "."], "folder"),
    ];
    for (arguments, word) in trials {
        folder.refused_given(arguments, &[word]);
    }
    std::fs::create_dir(folder.path().join("sub")).expect("made");
    for output in ["gone/out.exr", "scene.xml/out.exr", "sub", "."] {
        folder.command_refused(&["render", "scene.xml", "-o", output], &["cannot write", output]);
    }
    // Whatever an error message begins with, the word `error` precedes it, once.
    folder.command_refused(
        &["render", "scene.xml", "-o", "error-gone/out.exr"],
        &["error: error-gone/out.exr: cannot write"],
    );
    folder.refused_given(&["--crop", "3,3,2,2"], &["error: --crop is not inside"]);
    folder.command_refused(&["render", "error.xml", "-o", "out.exr"], &["error: cannot read error.xml"]);
    for pixel in ["4,0", "0,4", "-1,0", "x", "1"] {
        let pixel = format!("--pixel={pixel}");
        folder.command_refused(&["replay", "scene.xml", &pixel, "--sample", "0"], &[]);
    }
    folder.command_refused(&["replay", "scene.xml", "--pixel", "0,0", "--sample", "4294967296"], &[]);
    folder.command_refused(&["render", "scene.xml", "-o", "out.exr", "--threads", "1025"], &["0..=1024"]);
    for address in ["viewer", ":14158", "viewer:99999"] {
        folder.refused_given(&["--preview", address], &["expected such as localhost:14158"]);
    }
}

#[test]
fn what_takes_colours_is_refused_before_a_render_without() {
    let aov = "<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/></integrator>";
    let folder = Folder::new(scene(aov).as_bytes());
    let endless = ["--spp", "4000000000", "--png", "a.png"];
    folder.refused_given(&endless, &["the image has no channel `R`", "R, G and B are expected"]);
    let error = ["--integrator", "depth", "--target-error", "1%"];
    folder.refused_given(&error, &["--target-error: the integrator sees no light", "--spp"]);
    let rendered = Command::new(env!("CARGO_BIN_EXE_etalon"))
        .args(["render", "--samples", "0..8", "scene.xml", "-o", "part.exr"])
        .current_dir(folder.path())
        .output()
        .expect("it runs");
    // Depths are all 0 where there are no surfaces, which is not reported as a lack of light.
    let said = String::from_utf8_lossy(&rendered.stdout);
    assert!(
        rendered.status.success() && said.contains("no relative standard error: the mean is 0"),
        "{said}"
    );
    folder.command_refused(&["merge", "part.exr", "-o", "out.exr", "--png", "a.png"], &["no channel `R`"]);
}

#[test]
fn no_output_is_written_over_another_or_over_the_scene() {
    let folder = Folder::new(format!("<scene version=\"3.0.0\">{SENSOR}</scene>").as_bytes());
    let (taken, read) = (["another output has this place"], ["this file is read, and cannot be an output"]);
    folder.command_refused(&["render", "scene.xml", "-o", "both", "--png", "both"], &taken);
    folder.refused_given(&["--checkpoint", "./out.exr"], &taken);
    folder.refused_given(&["--checkpoint", "out.exr.partial"], &taken);
    folder.refused_given(&["--checkpoint", "scene.xml"], &read);
    folder.command_refused(&["merge", "scene.xml", "-o", "both", "--png", "both"], &taken);
    std::fs::write(folder.path().join("part"), "of a render").expect("written");
    folder.command_refused(&["merge", "part", "-o", "out.exr", "--png", "./part"], &read);
    // Nor over a file that the scene reads.
    let (mesh, part) = (folder.path().join("a.obj"), folder.path().join("part.xml"));
    let triangle = "v 0 0 5\nv 1 0 5\nv 0 1 5\nf 1 2 3\n";
    std::fs::write(&mesh, triangle).expect("written");
    std::fs::write(&part, scene(r#"<shape type="obj"><string name="filename" value="a.obj"/></shape>"#))
        .expect("written");
    std::fs::write(
        folder.path().join("scene.xml"),
        r#"<scene version="3.0.0"><include filename="part.xml"/></scene>"#,
    )
    .expect("written");
    folder.refused_given(&["--png", "a.obj"], &read);
    for output in ["a.obj", "part.xml"] {
        folder.refused_given(&["--checkpoint", output], &read);
    }
    folder.command_refused(&["render", "scene.xml", "-o", "a.obj"], &read);
    assert_eq!(std::fs::read_to_string(mesh).expect("it is there"), triangle);
}

#[test]
fn an_image_is_not_given_the_name_of_another_kind_of_file() {
    let folder = Folder::new(scene("").as_bytes());
    for (name, expected) in [
        ("a.png", "a.exr"),
        ("A.JPG", "A.exr"),
        ("a.b.jpeg", "a.b.exr"),
        ("a.hdr", "a.exr"),
        ("scene.xml", "scene.exr"),
    ] {
        let words = [name, "OpenEXR", &format!("expected such as {expected}")];
        folder.command_refused(&["render", "scene.xml", "-o", name], &words);
        folder.command_refused(&["merge", "out.exr", "-o", name], &words);
    }
    let words = ["PNG", "expected such as a.png"];
    folder.command_refused(&["render", "scene.xml", "-o", "b.exr", "--png", "a.exr"], &words);
    folder.command_refused(&["merge", "out.exr", "-o", "b.exr", "--png", "a.jpg"], &words);
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let folder = Folder::new(scene("<emitter type=\"constant\"/>").as_bytes());
    std::fs::write(
        folder.path().join("other.xml"),
        scene("<emitter type=\"constant\"/><shape type=\"cube\"/>"),
    )
    .expect("written");
    let render = |scene: &str, name: &str, more: &[&str]| {
        let fixed = ["render", scene, "-o", name, "--quiet"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_etalon"));
        let output = command.current_dir(folder.path()).args(fixed).args(more).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    render("scene.xml", "a", &["--samples", "0..8"]);
    render("scene.xml", "next", &["--samples", "8..16"]);
    render("scene.xml", "overlap", &["--samples", "4..12"]);
    render("scene.xml", "gap", &["--samples", "12..16"]);
    render("scene.xml", "seed", &["--samples", "8..16", "--seed", "1"]);
    render("scene.xml", "rgb", &["--samples", "8..16", "--color", "rgb"]);
    render("scene.xml", "depth", &["--samples", "8..16", "--max-depth", "3"]);
    render("scene.xml", "size", &["--samples", "8..16", "--size", "5x4"]);
    render("scene.xml", "crop", &["--samples", "8..16", "--crop", "0,0,2,4"]);
    render("scene.xml", "plain", &["--spp", "8"]);
    render("other.xml", "other", &["--samples", "8..16"]);
    let trials = [
        ("overlap", "overlap"),
        ("gap", "8..12 of pixel (0, 0) are missing"),
        ("seed", "seed differs"),
        ("other", "scene differs"),
        ("rgb", "differs"),
        ("depth", "differs"),
        ("size", "differ"),
        ("crop", ""),
        ("plain", "rendered with --samples"),
        ("a", ""),
        ("scene.xml", "scene.xml"),
        ("gone", "gone"),
    ];
    for (part, word) in trials {
        folder.command_refused(&["merge", "a", part, "-o", "out.exr"], &[word]);
        folder.command_refused(&["merge", part, "a", "-o", "out.exr"], &[word]);
    }
    let damaged = std::fs::read(folder.path().join("next")).expect("read");
    for cut in [damaged.len() - 1, damaged.len() / 2, 8, 0] {
        std::fs::write(folder.path().join("cut"), &damaged[..cut]).expect("written");
        folder.command_refused(&["merge", "a", "cut", "-o", "out.exr"], &["cut"]);
    }
    folder.command_refused(&["merge", "a", "next", "-o", "gone/out.exr"], &["gone/out.exr", "cannot write"]);
    folder.command_refused(&["merge", "-o", "out.exr"], &["PARTS"]);
}

#[test]
fn grids_that_cannot_be_read_are_refused() {
    let scene = |parameters: &str| {
        let volume = r#"<volume name="sigma_t" type="gridvolume"><string name="filename" value="g.vol"/>"#;
        let medium = format!(r#"<medium type="heterogeneous">{volume}{parameters}</volume></medium>"#);
        super::scene(&medium)
    };
    let grid = |values: &[f32]| {
        let numbers = [1, values.len() as u32, 1, 1, 1].map(u32::to_le_bytes).concat();
        let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 1.0].map(f32::to_le_bytes).concat();
        let values: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        [b"VOL\x03".to_vec(), numbers, corners, values].concat()
    };
    refused_with(&scene(""), &[("g.vol", b"nothing")], &["g.vol", "does not begin with VOL"]);
    let cut = &grid(&[1.0, 2.0])[..52];
    refused_with(
        &scene(""),
        &[("g.vol", cut)],
        &["g.vol", "2 × 1 × 1 cells", "expected four bytes for each"],
    );
    refused_with(&scene(""), &[("g.vol", &grid(&[1.0, -2.0]))], &["cell (1, 0, 0)", "is -2"]);
    refused_with(&scene(""), &[("g.vol", &grid(&[f32::NAN]))], &["cell (0, 0, 0)", "is NaN"]);
    let own_box = r#"<boolean name="use_grid_bbox" value="true"/>"#;
    refused_with(&scene(own_box), &[("g.vol", &grid(&[1.0]))], &["the file's box is empty"]);
}
