//! The readers that are asked, a row each.

use super::mutate::{self, Mutate};
use etalon::scene::load_text;
use etalon::spectrum::ColorMode;
use etalon::spectrum::table::Tabulated;
use std::path::Path;
use validation::peer::{Lines, Peer, PeerError};

/// A kind of file and its reader.
pub struct Format {
    pub name: &'static str,
    /// Of seeds and inputs.
    pub extensions: &'static [&'static str],
    /// Reads an input that also stands in a file. What it answers does not matter.
    pub read: fn(&[u8], &Path),
    pub mutate: Mutate,
    /// Bytes that an input may take: so many, and so many times its own.
    pub memory: (usize, usize),
}

/// What does not compress stays within this.
const PLAIN: (usize, usize) = (16 << 20, 400);
/// Deflate makes at most 1032 bytes of one, and a byte of a file becomes up to four of a float.
const COMPRESSED: (usize, usize) = (64 << 20, 3 * 4 * 1032);

/// All of them.
pub const FORMATS: &[Format] = &[
    Format { name: "xml", extensions: &["xml"], read: scene, mutate: mutate::words, memory: PLAIN },
    Format { name: "ply", extensions: &["ply"], read: ply, mutate: mutate::headed, memory: PLAIN },
    Format { name: "obj", extensions: &["obj"], read: obj, mutate: mutate::words, memory: PLAIN },
    Format {
        name: "serialized",
        extensions: &["serialized"],
        read: serialized,
        mutate: mutate::deflated,
        memory: COMPRESSED,
    },
    Format { name: "exr", extensions: &["exr"], read: exr, mutate: mutate::bytes, memory: COMPRESSED },
    Format {
        name: "picture",
        extensions: &["png", "jpg", "hdr", "bmp"],
        read: picture,
        mutate: mutate::bytes,
        memory: COMPRESSED,
    },
    Format { name: "spd", extensions: &["spd"], read: spd, mutate: mutate::words, memory: PLAIN },
    Format { name: "peer", extensions: &["jsonl"], read: peer, mutate: mutate::words, memory: PLAIN },
];

/// The format of this name.
pub fn named(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name == name)
}

fn scene(bytes: &[u8], file: &Path) {
    let text = String::from_utf8_lossy(bytes);
    for mode in [ColorMode::Rgb, ColorMode::Spectral] {
        // An error, and its words, are an answer.
        let _ = load_text(&file.to_string_lossy(), &text, mode).map(drop).map_err(|e| e.to_string());
    }
}

/// Reads a mesh as a scene does, with all that is made of it.
fn mesh(kind: &str, file: &Path) {
    let text = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><shape type=\"{kind}\">\
         <string name=\"filename\" value=\"{}\"/><emitter type=\"area\"/></shape></scene>",
        file.display()
    );
    let _ = load_text("scene.xml", &text, ColorMode::Rgb).map(drop).map_err(|e| e.to_string());
}

fn ply(_: &[u8], file: &Path) {
    mesh("ply", file);
}

fn obj(_: &[u8], file: &Path) {
    mesh("obj", file);
}

fn serialized(_: &[u8], file: &Path) {
    mesh("serialized", file);
}

/// As a texture, as a part to merge, and as the harness reads it.
fn exr(bytes: &[u8], file: &Path) {
    drop(etalon::image::read::pixels(file));
    drop(etalon::image::read_exr(file));
    drop(validation::image::from_exr(bytes));
}

fn picture(_: &[u8], file: &Path) {
    drop(etalon::image::read::pixels(file));
}

fn spd(bytes: &[u8], _: &Path) {
    drop(Tabulated::parse_spd(&String::from_utf8_lossy(bytes)));
}

/// The replies of a peer to all there is to ask.
fn peer(bytes: &[u8], _: &Path) {
    let text = String::from_utf8_lossy(bytes);
    let Ok(mut peer) = Peer::meet(Replies(text.lines())) else { return };
    let (up, side) = (validation::scatterer::DVec3::Z, validation::scatterer::DVec3::X);
    drop(peer.evaluate(0, &[[up, side], [side, up]]));
    drop(peer.sample(0, &[(up, [0.5; 3]), (side, [0.0; 3])]));
}

struct Replies<'a>(std::str::Lines<'a>);

impl Lines for Replies<'_> {
    fn exchange(&mut self, _: String) -> Result<String, PeerError> {
        self.0.next().map(str::to_owned).ok_or_else(|| PeerError("the peer ended".into()))
    }
}
