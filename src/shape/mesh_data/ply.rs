//! PLY, the Stanford triangle format (Greg Turk, 1994), as text or binary of either byte order.
//!
//! Read are `x y z`, `nx ny nz` and texture coordinates under any of their usual names of the element
//! `vertex`, and the lists `vertex_index` or `vertex_indices` of the element `face`. All else is passed over,
//! and read when a texture asks for it (`attributes.rs`).

mod attributes;
mod header;
mod values;
mod write;

pub use attributes::{Answer, Attribute, AttributeFile};
pub use write::write_ply;

use super::{MeshData, MeshError, read_bytes};
use header::{Element, Encoding, Header, Property, Scalar};
use std::path::Path;
use values::{Ascii, Binary, Values};

/// Reads a PLY mesh, with polygons cut into fans of triangles (right for convex ones).
///
/// # Errors
/// Besides a file that cannot be read or is cut short: coordinates stored as integers (Mitsuba would take
/// them for sRGB-encoded fractions), numbers that are not finite, indices out of range, no triangles, and
/// anything left over behind the data.
pub fn read_ply(path: &Path) -> Result<MeshData, MeshError> {
    let attributes = Some(AttributeFile { path: path.to_owned() });
    Ok(MeshData { attributes, ..parse(&read_bytes(path)?)? })
}

fn parse(bytes: &[u8]) -> Result<MeshData, MeshError> {
    let header = header::parse(bytes)?;
    match header.encoding {
        Encoding::Ascii => read_body(&header, Ascii::new(bytes, header.end)),
        Encoding::LittleEndian => read_body(&header, Binary::<false>::new(bytes, header.end)),
        Encoding::BigEndian => read_body(&header, Binary::<true>::new(bytes, header.end)),
    }
}

fn read_body(header: &Header, mut values: impl Values) -> Result<MeshData, MeshError> {
    let mut mesh = MeshData::default();
    let vertices = header.elements.iter().find(|element| element.name == "vertex");
    let vertex_count = vertices.map_or(0, |element| element.count);
    for element in &header.elements {
        check_room(element, &values)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut values, &mut mesh)?,
            "face" => read_faces(element, &mut values, vertex_count, &mut mesh.triangles)?,
            _ => skip_element(element, &mut values)?,
        }
    }
    if !values.at_end() {
        return Err(MeshError::file("the file goes on after the data that its header promises"));
    }
    if mesh.triangles.is_empty() {
        return Err(MeshError::file("the mesh has no triangles"));
    }
    Ok(mesh)
}

/// Refuses an element of more records than what is left of the file can hold.
fn check_room(element: &Element, values: &impl Values) -> Result<(), MeshError> {
    if element.count <= values.room(element) {
        return Ok(());
    }
    let (count, name) = (element.count, &element.name);
    Err(MeshError::file(format!(
        "the header promises {count} records of `{name}`; the file is too short for that"
    )))
}

const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Names of texture coordinates, in the order in which Mitsuba prefers them where a file has several.
const UV: [[&str; 2]; 3] = [["u", "v"], ["texture_u", "texture_v"], ["s", "t"]];

/// Where a vertex's numbers are gathered: x y z, nx ny nz, u v.
const SLOTS: usize = 8;

/// Where the properties of vertices go.
struct Columns {
    /// The slot of each property that is used.
    slots: Vec<Option<usize>>,
    normals: bool,
    uvs: bool,
}

fn columns_of(element: &Element) -> Result<Columns, MeshError> {
    let has = |name: &&str| -> bool {
        element.properties.iter().any(|property| property.name == *name && property.length.is_none())
    };
    if !POSITION.iter().all(has) {
        return Err(MeshError::file("the element `vertex` has no `x`, `y` and `z`"));
    }
    let normals = NORMAL.iter().all(has);
    let uv_names = UV.iter().find(|names| names.iter().all(has));
    let mut names: Vec<(&str, usize)> = POSITION.into_iter().zip(0..).collect();
    names.extend(NORMAL.into_iter().zip(3..).filter(|_| normals));
    names.extend(uv_names.into_iter().flatten().copied().zip(6..));

    let mut slots = Vec::with_capacity(element.properties.len());
    for property in &element.properties {
        let wanted = names.iter().position(|(name, _)| *name == property.name);
        // Taken out, so that a second property of the same name is passed over.
        let slot = wanted.filter(|_| property.length.is_none()).map(|index| names.swap_remove(index).1);
        if slot.is_some() && !property.kind.is_float() {
            let name = &property.name;
            return Err(MeshError::file(format!("the vertex property `{name}` is stored as an integer")));
        }
        slots.push(slot);
    }
    Ok(Columns { slots, normals, uvs: uv_names.is_some() })
}

fn read_vertices(element: &Element, values: &mut impl Values, mesh: &mut MeshData) -> Result<(), MeshError> {
    let Columns { slots, normals: has_normals, uvs: has_uvs } = columns_of(element)?;
    let count = element.count as usize;
    mesh.positions.reserve_exact(count);
    let mut normals = Vec::with_capacity(if has_normals { count } else { 0 });
    let mut uvs = Vec::with_capacity(if has_uvs { count } else { 0 });
    let plain =
        element.properties.iter().all(|property| property.kind == Scalar::F32 && property.length.is_none());
    let mut numbers = vec![0.0; if plain { slots.len() } else { 0 }];
    for _ in 0..count {
        let mut record = [0.0_f32; SLOTS];
        values.floats(&mut numbers)?;
        for (slot, number) in slots.iter().zip(&numbers) {
            if let Some(slot) = slot {
                record[*slot] = *number;
            }
        }
        for (property, slot) in element.properties.iter().zip(&slots).filter(|_| !plain) {
            match slot {
                Some(slot) => record[*slot] = values.float(property.kind)?,
                None => skip_property(property, values)?,
            }
        }
        if !record.iter().all(|number| number.is_finite()) {
            return Err(values.error("a vertex with an infinite number or none (NaN)".into()));
        }
        let [x, y, z, nx, ny, nz, u, v] = record;
        mesh.positions.push([x, y, z]);
        if has_normals {
            normals.push([nx, ny, nz]);
        }
        if has_uvs {
            uvs.push([u, v]);
        }
    }
    mesh.normals = has_normals.then_some(normals);
    mesh.uvs = has_uvs.then_some(uvs);
    Ok(())
}

fn read_faces(
    element: &Element,
    values: &mut impl Values,
    vertex_count: u64,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), MeshError> {
    let at_corners = ["texcoord", "texcoords"];
    if let Some(property) = element.properties.iter().find(|p| at_corners.contains(&p.name.as_str())) {
        return Err(MeshError::file(format!(
            "the element `face` has `{}`, texture coordinates of its own at every corner; expected `u` and `v` of vertices",
            property.name
        )));
    }
    let corners = corner_list(element)?;
    triangles.reserve_exact(element.count as usize);
    let [Property { kind, length, .. }, ..] = element.properties.as_slice() else { return Ok(()) };
    let usual = element.properties.len() == 1
        && *length == Some(Scalar::U8)
        && matches!(kind, Scalar::I32 | Scalar::U32);
    // A negative index is past this limit, too.
    let limit = vertex_count.min(1 << 31) as u32;
    for _ in 0..element.count {
        if let Some(triangle) = usual.then(|| values.triangle(limit)).flatten() {
            triangles.push(triangle);
            continue;
        }
        for (index, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length.filter(|_| index == corners) else {
                skip_property(property, values)?;
                continue;
            };
            let count = values.integer(length)?;
            if count < 3 {
                return Err(values.error(format!("a face with {count} corners; it takes three")));
            }
            let mut corner = || {
                let index = values.integer(property.kind)?;
                match u32::try_from(index) {
                    Ok(vertex) if u64::from(vertex) < vertex_count => Ok(vertex),
                    _ => Err(values.error(format!("a face asks for vertex {index} of {vertex_count}"))),
                }
            };
            let [first, mut previous] = [corner()?, corner()?];
            for _ in 2..count {
                let next = corner()?;
                triangles.push([first, previous, next]);
                previous = next;
            }
        }
    }
    Ok(())
}

/// The property of faces that lists their corners.
fn corner_list(element: &Element) -> Result<usize, MeshError> {
    let is_corners = |property: &Property| {
        matches!(property.name.as_str(), "vertex_index" | "vertex_indices") && property.length.is_some()
    };
    let found = element.properties.iter().position(is_corners);
    found.ok_or_else(|| MeshError::file("the element `face` has no list `vertex_index` or `vertex_indices`"))
}

fn skip_element(element: &Element, values: &mut impl Values) -> Result<(), MeshError> {
    // However many such records a file claims, there is nothing of them.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        element.properties.iter().try_for_each(|property| skip_property(property, values))?;
    }
    Ok(())
}

fn skip_property(property: &Property, values: &mut impl Values) -> Result<(), MeshError> {
    let Some(length) = property.length else {
        return values.skip(property.kind, 1);
    };
    let count = values.integer(length)?;
    let count = u64::try_from(count).map_err(|_| values.error(format!("a list of length {count}")))?;
    values.skip(property.kind, count)
}

#[cfg(test)]
mod tests;
