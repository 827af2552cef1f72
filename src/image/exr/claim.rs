//! Whether a file can hold what its header claims, checked before memory is allocated for it.

use exr::meta::header::Header;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Most bytes of samples that a byte of the file can hold, with room to spare: deflate reaches 1032, and DWA,
/// where a whole block is dark, little more.
const MOST_PER_BYTE: u128 = 4096;

/// What every OpenEXR file begins with.
pub const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Refuses a file of another kind, and one that claims more samples than one of its length can hold.
pub fn check(path: &Path) -> Result<(), String> {
    let mut file = std::fs::File::open(path).map_err(|error| error.to_string())?;
    let mut begin = [0; 4];
    if file.read_exact(&mut begin).is_err() || begin != MAGIC {
        return Err("this is no OpenEXR file".into());
    }
    file.rewind().map_err(|error| error.to_string())?;
    let length = file.metadata().map_err(|error| error.to_string())?.len();
    let reader = exr::block::read(BufReader::new(file), false).map_err(|error| error.to_string())?;
    plausible(reader.headers(), length)
}

fn plausible(headers: &[Header], length: u64) -> Result<(), String> {
    for header in headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        let claimed = width as u128 * height as u128 * header.channels.bytes_per_pixel as u128;
        if claimed > MOST_PER_BYTE * u128::from(length) {
            return Err(format!("a file of {length} bytes cannot hold {width} × {height} pixels"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::image::{read, read_exr};
    use std::path::Path;

    #[test]
    fn a_file_that_claims_too_much_is_refused() {
        let sky = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/references/scenes/textures/sky.exr");
        assert!(read_exr(&sky).is_ok() && read::pixels(&sky).is_ok());
        let mut bytes = std::fs::read(&sky).unwrap();
        // Name, type and length of an attribute, then the corners: x and y of the least pixel, then of the
        // last.
        for name in [b"dataWindow\0box2i\0\x10\0\0\0".as_slice(), b"displayWindow\0box2i\0\x10\0\0\0"] {
            let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
            bytes[at + 8..at + 16].copy_from_slice(&[0xff, 0xff, 0x0f, 0, 0xff, 0xff, 0x0f, 0]);
        }
        let folder = tempfile::tempdir().unwrap();
        let vast = folder.path().join("vast.exr");
        std::fs::write(&vast, &bytes).unwrap();
        let error = read_exr(&vast).unwrap_err().to_string();
        assert!(error.contains("cannot hold 1048576 × 1048576"), "{error}");
        assert!(read::pixels(&vast).is_err_and(|e| e.contains("cannot hold")));
    }
}
