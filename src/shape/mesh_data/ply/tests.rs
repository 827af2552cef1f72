use super::{super::Place, super::tests::assert_valid, *};
use proptest::prelude::*;

const ASCII: &str = "ply\nformat ascii 1.0\nelement vertex 4\n\
    property float x\nproperty float y\nproperty uchar red\nproperty double z\n\
    property float s\nproperty float t\n\
    element edge 1\nproperty list uchar int ends\nproperty float crease\n\
    element face 1\nproperty uchar flags\nproperty list uchar int vertex_index\nend_header\n\
    0 0 255 0.5 0 0\n1 0 255 0.5 1 0\n1 1 255 0.5 1 1\n0 1 255 0.5 0 1\n2 0 1 0.25\n7 4 0 1 2 3\n";

fn square() -> MeshData {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    MeshData {
        positions: corners.map(|[x, y]| [x, y, 0.5]).into(),
        uvs: Some(corners.into()),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

fn binary(mesh: &MeshData) -> Vec<u8> {
    let mut bytes = Vec::new();
    write::write(mesh, &mut bytes).unwrap();
    bytes
}

#[test]
fn text_gives_a_mesh_without_what_is_not_asked_for() {
    assert_eq!(parse(ASCII.as_bytes()).unwrap(), square());
}

/// As by Mitsuba.
#[test]
fn of_several_texture_coordinates_those_named_u_and_v_count() {
    let text = ASCII.replace("property float t\n", "property float t\nproperty float u\nproperty float v\n");
    let text = text
        .replace("0.5 0 0\n", "0.5 0 0 5 6\n")
        .replace("0.5 1 0\n", "0.5 1 0 5 6\n")
        .replace("0.5 1 1\n", "0.5 1 1 5 6\n")
        .replace("0.5 0 1\n", "0.5 0 1 5 6\n");
    assert_eq!(parse(text.as_bytes()).unwrap().uvs, Some(vec![[5.0, 6.0]; 4]));
}

#[test]
fn what_is_written_is_read_back() {
    let with_normals = MeshData { normals: Some(vec![[0.0, 0.0, 1.0]; 4]), ..square() };
    for mesh in [square(), with_normals, MeshData { uvs: None, ..square() }] {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("square.ply");
        write_ply(&mesh, &path).unwrap();
        let attributes = Some(AttributeFile { path: path.clone() });
        assert_eq!(read_ply(&path).unwrap(), MeshData { attributes, ..mesh });
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }
}

#[test]
fn big_endian_numbers_of_any_type_are_read() {
    let vertices = [(0.0_f64, 0_u16, 0.0_f32), (2.5, 0, -1.0), (0.0, 0x3c00, 0.0)];
    let lists = [
        ("ushort short", [3_u16, 2, 0, 1].map(u16::to_be_bytes).concat()),
        ("uchar int", { [vec![3], [2_u32, 0, 1].map(u32::to_be_bytes).concat()].concat() }),
    ];
    for (types, list) in lists {
        let mut bytes = format!(
            "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty double x\nproperty half y\n\
             property float z\nelement face 1\nproperty list {types} vertex_indices\nend_header\n"
        )
        .into_bytes();
        for (x, half, z) in vertices {
            bytes.extend(x.to_be_bytes());
            bytes.extend(half.to_be_bytes());
            bytes.extend(z.to_be_bytes());
        }
        bytes.extend(list);
        let mesh = parse(&bytes).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [2.5, 0.0, -1.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.triangles, [[2, 0, 1]]);
    }
}

#[test]
fn faults_are_told_with_their_place() {
    for (from, to, place, message) in [
        ("7 4 0 1 2 3", "7 4 0 1 2 4", Place::Line(22), "a face asks for vertex 4 of 4"),
        ("7 4 0 1 2 3", "7 4 0 1 2 -1", Place::Line(22), "a face asks for vertex -1 of 4"),
        ("7 4 0 1 2 3", "7 2 0 1", Place::Line(22), "a face with 2 corners; it takes three"),
        ("7 4 0 1 2 3", "7 4 0 1 2 x", Place::Line(22), "`x` is not an integer"),
        ("1 1 255", "1 nan 255", Place::Line(19), "a vertex with an infinite number or none (NaN)"),
        ("1 1 255", "1 1e99 255", Place::Line(19), "a vertex with an infinite number or none (NaN)"),
        ("element edge 1\n", "foo bar\r\n", Place::Line(10), "`foo bar` does not belong in a PLY 1.0 header"),
        ("2 3\n", "2 3 9\n", Place::File, "the file goes on after the data that its header promises"),
        ("face 1", "face 0", Place::File, "the file goes on after the data that its header promises"),
        ("float x", "int x", Place::File, "the vertex property `x` is stored as an integer"),
        ("float x", "float w", Place::File, "the element `vertex` has no `x`, `y` and `z`"),
    ] {
        let error = parse(ASCII.replace(from, to).as_bytes()).unwrap_err();
        assert_eq!((error.place, error.message.as_str()), (place, message), "{to}");
    }
    let empty = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert_eq!(parse(empty.as_bytes()).unwrap_err().message, "the mesh has no triangles");
}

#[test]
fn counts_beyond_the_file_cost_no_memory() {
    for count in ["5", "1000000000", "18446744073709551615"] {
        for element in ["vertex 4", "edge 1", "face 1"] {
            let name = element.split(' ').next().unwrap();
            let text = ASCII.replace(element, &format!("{name} {count}"));
            assert!(parse(text.as_bytes()).is_err(), "{name} {count}");
        }
    }
    let header = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nelement vertex 9\n\
        element face 1\nproperty list uchar int vertex_index\nend_header\n3 0 1 2";
    assert_eq!(parse(header.as_bytes()).unwrap_err().message, "the element `vertex` has no `x`, `y` and `z`");
    let mut bytes = binary(&square());
    let list = bytes.len() - 13;
    bytes[list] = 255;
    assert!(matches!(parse(&bytes).unwrap_err().place, Place::Byte(_)));
    bytes[list..list + 2].copy_from_slice(&[3, 4]);
    let error = MeshError::new(Place::Byte(list as u64 + 1), "a face asks for vertex 4 of 4");
    assert_eq!(parse(&bytes).unwrap_err(), error);
}

proptest! {
    #[test]
    fn random_bodies_give_an_error_or_a_valid_mesh(
        format in prop::sample::select(vec!["ascii", "binary_little_endian", "binary_big_endian"]),
        vertices in 0_u64..9,
        faces in 0_u64..9,
        kind in prop::sample::select(vec!["float", "double", "half", "int"]),
        length in prop::sample::select(vec!["char", "uchar", "int", "ulong"]),
        body in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut bytes = format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty {kind} x\nproperty {kind} y\n\
             property {kind} z\nelement face {faces}\nproperty list {length} char vertex_index\nend_header\n"
        ).into_bytes();
        bytes.extend(body);
        if let Ok(mesh) = parse(&bytes) {
            assert_valid(&mesh);
        }
    }

    #[test]
    fn a_cut_or_altered_file_gives_an_error_or_a_valid_mesh(
        text: bool,
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte: u8,
    ) {
        let whole = if text { ASCII.as_bytes().to_vec() } else { binary(&square()) };
        // A text without its last line break is still whole.
        let length = cut.index(whole.len() - 1);
        prop_assert!(parse(&whole[..length]).is_err());
        let mut altered = whole;
        let at = at.index(altered.len());
        altered[at] = byte;
        if let Ok(mesh) = parse(&altered) {
            assert_valid(&mesh);
        }
    }

    #[test]
    fn random_bytes_are_no_mesh(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(parse(&bytes).is_err());
    }
}
