//! Records rays on procedural meshes, and replays recorded rays, to compare run times with other ray tracers.
//!
//! ```sh
//! cargo run --release --example rays -- record FOLDER [MESH...]
//! cargo run --release --example rays -- replay FOLDER MESH
//! ```
//!
//! `record` writes `MESH.mesh` and `MESH-KIND.rays`. `replay` builds the tree, prints a line of JSON about
//! it, and then answers requests, one per line of standard input: `closest KIND` and `occluded KIND` trace
//! the set once and print `{"seconds": s}`; `hits KIND FILE` also writes what each ray hit.
//! `benches/rays_side_by_side.py` is the client.

mod file;
mod meshes;
mod record;
mod replay;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["record", folder, ref names @ ..] => {
            for (name, make) in meshes::MESHES {
                if names.is_empty() || names.contains(name) {
                    record::record(Path::new(folder), name, &make())?;
                }
            }
            Ok(())
        }
        ["replay", folder, mesh] => replay::replay(Path::new(folder), mesh),
        _ => Err("usage: rays record FOLDER [MESH...] | rays replay FOLDER MESH".into()),
    }
}
