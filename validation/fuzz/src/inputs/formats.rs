//! The readers under test, one table row each.

use super::mutate::{self, Mutate};
use etalon::load_text;
use etalon::spectrum::ColorMode;
use etalon::spectrum::table::Tabulated;
use std::path::Path;
use validation::peer::{Lines, Peer, PeerError};

/// A kind of file and its reader.
pub struct Format {
    pub name: &'static str,
    /// Extensions of the format's files; inputs get the first one.
    pub extensions: &'static [&'static str],
    /// Reads an input, given as bytes and as a file of the same content. Its result is ignored: refusing is
    /// as good as reading.
    pub read: fn(&[u8], &Path),
    /// Changes a seed file into an input.
    pub mutate: Mutate,
    /// Memory limit of an input in bytes: a constant, and a multiple of the input's size that is added to it.
    pub memory: (usize, usize),
}

/// Limit for uncompressed formats.
const PLAIN: (usize, usize) = (16 << 20, 400);
/// Limit for compressed formats: deflate expands a byte to at most 1032 bytes, and a byte of a file becomes
/// up to four bytes of a float.
const COMPRESSED: (usize, usize) = (64 << 20, 3 * 4 * 1032);

/// All formats.
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
        // An error is a valid result; its message is formatted, since that may panic as well.
        let _ = load_text(&file.to_string_lossy(), &text, mode).map(drop).map_err(|e| e.to_string());
    }
}

/// Reads a mesh as the shape of a scene, with all that is derived from it.
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

/// Reads an image as a texture, as a part to merge, and with the harness's reader.
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

/// Reads the replies of a peer to every kind of request.
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
