//! Names the sources that the program is made of, so that no checkpoint and no part of a render is joined with
//! those of other sources: `ETALON_VERSION` is the package's version and a hash of all that can change a pixel,
//! the same on every machine.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

fn main() -> io::Result<()> {
    let mut files = vec![PathBuf::from("Cargo.lock")];
    list(Path::new("src"), &mut files)?;
    // The command line decides no pixel.
    files.retain(|file| !file.starts_with("src/cli"));
    files.sort();
    let mut hash = Xxh3::new();
    for file in files {
        let name = file.to_string_lossy().replace('\\', "/");
        for piece in [name.into_bytes(), fs::read(file)?] {
            hash.update(&(piece.len() as u64).to_le_bytes());
            hash.update(&piece);
        }
    }
    println!("cargo::rerun-if-changed=Cargo.lock");
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rustc-env=ETALON_VERSION={}+{:016x}", env!("CARGO_PKG_VERSION"), hash.digest());
    Ok(())
}

/// All files of a folder and of those in it.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() { list(&path, files)? } else { files.push(path) }
    }
    Ok(())
}
