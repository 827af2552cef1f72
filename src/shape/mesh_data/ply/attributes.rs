//! Further numbers of a PLY file's vertices and faces, such as colours, which are read when a texture asks
//! for them by name.

use super::header::{self, Element, Encoding, Header};
use super::values::{Ascii, Binary, Values};
use super::{check_room, corner_list, skip_element, skip_property};
use crate::shape::mesh_data::{MeshError, read_bytes};
use std::path::PathBuf;

/// A file that has been read as a mesh, and may hold attributes of its vertices and faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeFile {
    pub path: PathBuf,
}

/// A number or three for each vertex, or for each triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// One, or three of a colour or vector.
    pub width: usize,
    /// Whether it belongs to triangles, not to vertices.
    pub of_faces: bool,
    /// `width` numbers for each vertex or triangle, in the mesh's order.
    pub values: Vec<f32>,
}

/// What a file answers to the name of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    Found(Attribute),
    /// There is none of this name, but these.
    Others(Vec<String>),
}

/// The properties of an element that are one attribute.
#[derive(Debug, PartialEq)]
struct Columns {
    /// With `vertex_` or `face_` before it, as scene files have it.
    name: String,
    properties: Vec<usize>,
}

/// The last letters of the names of properties that are one attribute, as in Mitsuba.
const LAST_LETTERS: [&str; 4] = ["xyzw", "rgba", "0123", "1234"];
/// What colours without such a letter are called.
const COLOURS: [[&str; 3]; 2] = [["r", "g", "b"], ["red", "green", "blue"]];

impl AttributeFile {
    /// Reads an attribute: `vertex_color` is made of `r`, `g` and `b`, or `red`, `green` and `blue`, and
    /// `vertex_NAME` of `NAME_x`, `NAME_y` and `NAME_z`, or `NAME_0` and so on, or of one of these alone; of
    /// `NAME_r` and so on is `vertex_NAME_color`. Attributes of the element `face` begin with `face_`.
    ///
    /// As in Mitsuba, integers are the numbers that they are: colours of bytes go up to 255.
    ///
    /// # Errors
    /// As [`read_ply`](super::read_ply) has them, and for numbers that are not finite.
    pub fn read(&self, name: &str) -> Result<Answer, MeshError> {
        let bytes = read_bytes(&self.path)?;
        let header = header::parse(&bytes)?;
        match header.encoding {
            Encoding::Ascii => read(&header, Ascii::new(&bytes, header.end), name),
            Encoding::LittleEndian => read(&header, Binary::<false>::new(&bytes, header.end), name),
            Encoding::BigEndian => read(&header, Binary::<true>::new(&bytes, header.end), name),
        }
    }
}

fn read(header: &Header, mut values: impl Values, name: &str) -> Result<Answer, MeshError> {
    let mut others = vec![];
    for element in &header.elements {
        check_room(element, &values)?;
        let columns = columns(element);
        if let Some(found) = columns.iter().find(|columns| columns.name == name) {
            return read_columns(element, &found.properties, &mut values).map(Answer::Found);
        }
        others.extend(columns.into_iter().map(|columns| columns.name));
        skip_element(element, &mut values)?;
    }
    Ok(Answer::Others(others))
}

/// The attributes of an element, in the order of the file.
fn columns(element: &Element) -> Vec<Columns> {
    let of_faces = match element.name.as_str() {
        "vertex" => false,
        "face" => true,
        _ => return vec![],
    };
    let prefix = if of_faces { "face" } else { "vertex" };
    let number = |name: &str| element.properties.iter().position(|p| p.name == name && p.length.is_none());
    let colours = COLOURS.iter().find_map(|names| names.iter().map(|name| number(name)).collect());
    let mut found: Vec<Columns> = colours
        .map(|properties| Columns { name: format!("{prefix}_color"), properties })
        .into_iter()
        .collect();
    let stem_and_letter = |index: usize| {
        let property = element.properties.get(index).filter(|property| property.length.is_none())?;
        let (stem, letter) = property.name.rsplit_once('_')?;
        Some((stem, letter.parse::<char>().ok()?))
    };
    let mut first = 0;
    while first < element.properties.len() {
        let begun = stem_and_letter(first).and_then(|(stem, letter)| {
            let letters = LAST_LETTERS.iter().find(|letters| letters.starts_with(letter))?;
            Some((stem, letters))
        });
        let Some((stem, letters)) = begun else {
            first += 1;
            continue;
        };
        let follows = |(i, letter): &(usize, char)| stem_and_letter(first + i) == Some((stem, *letter));
        let count = letters.chars().enumerate().take_while(follows).count();
        let of_colour = if letters.starts_with('r') { "_color" } else { "" };
        let name = format!("{prefix}_{stem}{of_colour}");
        if matches!(count, 1 | 3) && found.iter().all(|columns| columns.name != name) {
            found.push(Columns { name, properties: (first..first + count).collect() });
        }
        first += count;
    }
    found
}

fn read_columns(
    element: &Element,
    columns: &[usize],
    values: &mut impl Values,
) -> Result<Attribute, MeshError> {
    let of_faces = element.name == "face";
    let corners = if of_faces { Some(corner_list(element)?) } else { None };
    let mut found = Vec::with_capacity(columns.len() * element.count as usize);
    let mut record = vec![0.0; columns.len()];
    for _ in 0..element.count {
        let mut triangles = 1;
        for (index, property) in element.properties.iter().enumerate() {
            if let Some(column) = columns.iter().position(|column| *column == index) {
                let number = values.float(property.kind)?;
                if !number.is_finite() {
                    return Err(values.error(format!("`{}` is infinite or no number", property.name)));
                }
                record[column] = number;
            } else if let Some(length) = property.length.filter(|_| corners == Some(index)) {
                let count = values.integer(length)?;
                triangles = count.saturating_sub(2);
                let count = u64::try_from(count);
                values.skip(
                    property.kind,
                    count.map_err(|_| values.error("a face with less than no corners".into()))?,
                )?;
            } else {
                skip_property(property, values)?;
            }
        }
        // A face is as many triangles as the mesh has of it.
        (0..triangles).for_each(|_| found.extend(&record));
    }
    Ok(Attribute { width: columns.len(), of_faces, values: found })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::mesh_data::Place;
    use std::fs;

    fn element(name: &str, properties: &str) -> Element {
        let text = format!("ply\nformat ascii 1.0\nelement {name} 1\n{properties}end_header\n");
        header::parse(text.as_bytes()).unwrap().elements.remove(0)
    }

    fn found(name: &str, properties: &[&str]) -> Vec<(String, Vec<usize>)> {
        let properties: String = properties.iter().map(|p| format!("property float {p}\n")).collect();
        columns(&element(name, &properties)).into_iter().map(|c| (c.name, c.properties)).collect()
    }

    /// The names that `mi.load_dict` of Mitsuba 3.9.1 gives to such properties.
    #[test]
    fn attributes_have_mitsubas_names() {
        let colour = |prefix: &str, properties: &[usize]| (format!("{prefix}_color"), properties.to_vec());
        assert_eq!(found("vertex", &["x", "y", "z", "r", "g", "b"]), [colour("vertex", &[3, 4, 5])]);
        assert_eq!(found("face", &["blue", "green", "red", "alpha"]), [colour("face", &[2, 1, 0])]);
        let named = |name: &str, properties: &[usize]| (name.to_owned(), properties.to_vec());
        assert_eq!(
            found("vertex", &["heat_x", "wind_0", "wind_1", "wind_2", "tint_r", "tint_g", "tint_b", "one_1"]),
            [
                named("vertex_heat", &[0]),
                named("vertex_wind", &[1, 2, 3]),
                named("vertex_tint_color", &[4, 5, 6]),
                named("vertex_one", &[7]),
            ]
        );
        // Two or four of them, other letters, and none; then other elements.
        let strange = ["a_x", "a_y", "b_x", "b_y", "b_z", "b_w", "c_y", "d_q", "e", "f_xy"];
        assert_eq!(found("vertex", &strange), []);
        assert_eq!(found("edge", &["r", "g", "b"]), []);
    }

    /// A triangle, and a square that becomes two.
    const FILE: &str = "ply\nformat ascii 1.0\nelement vertex 5\n\
        property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nproperty list uchar int any\nproperty double heat_x\n\
        element nothing 99999999\nelement face 2\n\
        property float age_0\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 255 0 128 0 0.5\n1 0 0 0 0 0 2 7 7 0.25\n1 1 0 0 0 0 0 -1\n0 1 0 0 0 0 0 2\n2 0 0 0 0 0 0 3\n\
        10 3 1 4 2\n20 4 0 1 2 3\n";

    fn answer(text: &str, name: &str) -> Result<Answer, MeshError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        fs::write(&path, text).unwrap();
        AttributeFile { path }.read(name)
    }

    #[test]
    fn values_are_those_of_vertices_and_triangles() {
        let found = |name: &str| match answer(FILE, name).unwrap() {
            Answer::Found(attribute) => attribute,
            Answer::Others(others) => panic!("{name}: {others:?}"),
        };
        let color = found("vertex_color");
        assert_eq!((color.width, color.of_faces), (3, false));
        assert_eq!(color.values[..3], [255.0, 0.0, 128.0]);
        assert_eq!(color.values.len(), 15);
        let heat = Attribute { width: 1, of_faces: false, values: vec![0.5, 0.25, -1.0, 2.0, 3.0] };
        assert_eq!(found("vertex_heat"), heat);
        let age = Attribute { width: 1, of_faces: true, values: vec![10.0, 20.0, 20.0] };
        assert_eq!(found("face_age"), age);
    }

    #[test]
    fn what_is_not_there_or_no_number_is_told() {
        let names = ["vertex_color", "vertex_heat", "face_age"].map(str::to_owned);
        assert_eq!(answer(FILE, "vertex_colour").unwrap(), Answer::Others(names.into()));
        let error = answer(&FILE.replace("0 -1\n", "0 nan\n"), "vertex_heat").unwrap_err();
        assert_eq!(error.place, Place::Line(19), "{error}");
        assert!(error.message.contains("`heat_x`"), "{error}");
        // Another attribute does not mind.
        assert!(answer(&FILE.replace("0 -1\n", "0 nan\n"), "vertex_color").is_ok());
        let error = answer(&FILE.replace("vertex 5", "vertex 99999999"), "vertex_heat").unwrap_err();
        assert!(error.message.contains("too short"), "{error}");
    }
}
