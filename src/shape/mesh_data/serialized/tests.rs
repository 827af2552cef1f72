use super::{super::tests::assert_valid, *};
use flate2::{Compression, write::ZlibEncoder};
use proptest::prelude::*;
use std::io::{Cursor, Write};

/// One triangle with the optional parts that `flags` name; its first x is `x`.
fn mesh_bytes(version: u16, flags: u32, x: f64, last_vertex: u32, counts: [u64; 2]) -> Vec<u8> {
    let mut contents = flags.to_le_bytes().to_vec();
    if version == 4 {
        contents.extend(b"triangle\0");
    }
    contents.extend(counts.map(u64::to_le_bytes).concat());
    let mut numbers = vec![x, 0., 0., 1., 0., 0., 0., 1., 0.];
    if flags & HAS_NORMALS != 0 {
        numbers.extend([0., 0., 1.].repeat(3));
    }
    if flags & HAS_UVS != 0 {
        numbers.extend([0., 0.25, 1., 0., 0., 1.]);
    }
    if flags & HAS_COLORS != 0 {
        numbers.extend([0.5; 9]);
    }
    for number in numbers {
        if flags & DOUBLE_PRECISION != 0 {
            contents.extend(number.to_le_bytes());
        } else {
            contents.extend((number as f32).to_le_bytes());
        }
    }
    contents.extend([0, 1, last_vertex].map(u32::to_le_bytes).concat());
    let mut bytes = [MAGIC.to_le_bytes(), version.to_le_bytes()].concat();
    let mut encoder = ZlibEncoder::new(&mut bytes, Compression::default());
    encoder.write_all(&contents).unwrap();
    encoder.finish().unwrap();
    bytes
}

fn file_of(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
    let mut offset = 0_u64;
    let mut table = Vec::new();
    for mesh in meshes {
        let width = if version == 3 { 4 } else { 8 };
        table.extend(&offset.to_le_bytes()[..width]);
        offset += mesh.len() as u64;
    }
    [meshes.concat(), table, (meshes.len() as u32).to_le_bytes().into()].concat()
}

fn read(bytes: &[u8], index: u32) -> Result<MeshData, MeshError> {
    parse(Cursor::new(bytes), bytes.len() as u64, index)
}

#[test]
fn each_mesh_of_a_file_is_found_in_every_layout() {
    for version in [3, 4] {
        let layouts = [0, HAS_NORMALS, HAS_UVS | DOUBLE_PRECISION, HAS_NORMALS | HAS_UVS | HAS_COLORS];
        let meshes: Vec<_> = layouts
            .iter()
            .zip(0..)
            .map(|(&flags, x)| mesh_bytes(version, flags, x.into(), 2, [3, 1]))
            .collect();
        let file = file_of(version, &meshes);
        for (index, flags) in layouts.into_iter().enumerate() {
            let mesh = read(&file, index as u32).unwrap();
            assert_valid(&mesh);
            assert_eq!(mesh.positions, [[index as f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
            assert_eq!(mesh.normals, (flags & HAS_NORMALS != 0).then(|| vec![[0., 0., 1.]; 3]));
            assert_eq!(mesh.uvs, (flags & HAS_UVS != 0).then(|| vec![[0., 0.25], [1., 0.], [0., 1.]]));
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
        }
        let error = read(&file, 4).unwrap_err();
        assert_eq!(error.message, "there is no mesh 4: the file holds 4, counted from 0");
    }
}

#[test]
fn faults_are_told() {
    for (mesh, message) in [
        (mesh_bytes(4, 0, 0., 3, [3, 1]), "a triangle asks for vertex 3 of 3"),
        (
            mesh_bytes(4, 0, f64::NAN, 2, [3, 1]),
            "the mesh that begins here has an infinite number or none (NaN)",
        ),
        (
            mesh_bytes(4, DOUBLE_PRECISION, 1e99, 2, [3, 1]),
            "the mesh that begins here has an infinite number or none (NaN)",
        ),
        (mesh_bytes(4, 0, 0., 2, [3, 0]), "the mesh has no triangles"),
        (mesh_bytes(4, 0, 0., 2, [3, 2]), "the mesh that begins here ends too early"),
        (
            mesh_bytes(4, 0, 0., 2, [u64::MAX; 2]),
            "a mesh of 18446744073709551615 vertices and 18446744073709551615 triangles cannot be in this file",
        ),
        (mesh_bytes(5, 0, 0., 2, [3, 1]), "serialized version 5; versions 3 and 4 can be read"),
    ] {
        assert_eq!(read(&file_of(4, &[mesh]), 0).unwrap_err().message, message);
    }
    assert!(read(b"", 0).is_err() && read(b"ply\nformat", 0).is_err());
}

proptest! {
    #[test]
    fn a_cut_or_altered_file_gives_an_error_or_a_valid_mesh(
        version in 3_u16..5,
        index in 0_u32..3,
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte: u8,
    ) {
        let mut bytes = file_of(version, &[
            mesh_bytes(version, HAS_NORMALS, 0., 2, [3, 1]),
            mesh_bytes(version, HAS_UVS, 0., 2, [3, 1]),
        ]);
        if let Ok(mesh) = read(&bytes[..cut.index(bytes.len())], index) {
            assert_valid(&mesh);
        }
        let at = at.index(bytes.len());
        bytes[at] = byte;
        if let Ok(mesh) = read(&bytes, index) {
            assert_valid(&mesh);
        }
    }

    #[test]
    fn random_contents_give_an_error_or_a_valid_mesh(
        flags in 0_u32..16,
        counts in prop::array::uniform2(0_u64..5),
        numbers in prop::collection::vec(any::<u8>(), 0..200),
        index in 0_u32..2,
    ) {
        let contents = [flags.to_le_bytes().to_vec(), counts.map(u64::to_le_bytes).concat(), numbers].concat();
        let mut bytes = [MAGIC.to_le_bytes(), 3_u16.to_le_bytes()].concat();
        let mut encoder = ZlibEncoder::new(&mut bytes, Compression::fast());
        encoder.write_all(&contents).unwrap();
        encoder.finish().unwrap();
        if let Ok(mesh) = read(&bytes, index) {
            assert_valid(&mesh);
        }
    }
}
