//! A cube of twelve triangles.

use super::mesh::Mesh;
use super::mesh_data::MeshData;
use super::{Geometry, placement};
use crate::scene::error::SceneError;
use crate::scene::params::Params;

pub const NAME: &str = "cube";
pub const ABOUT: &str = "The cube from (−1, −1, −1) to (1, 1, 1); uv cover each face once.";
pub const EXAMPLES: &[&str] = &[
    r#"<shape type="cube"/>"#,
    r#"<shape type="cube"><transform name="to_world"><scale x="2" y="0.1" z="1"/></transform></shape>"#,
];

/// Each side's normal, and the corners in the order of uv (0,1), (1,1), (1,0), (0,0). Bit k of a corner is
/// the sign of axis k.
const SIDES: [([f32; 3], [u8; 4]); 6] = [
    ([0.0, -1.0, 0.0], [1, 5, 4, 0]),
    ([0.0, 1.0, 0.0], [3, 2, 6, 7]),
    ([1.0, 0.0, 0.0], [1, 3, 7, 5]),
    ([0.0, 0.0, 1.0], [5, 7, 6, 4]),
    ([-1.0, 0.0, 0.0], [4, 6, 2, 0]),
    ([0.0, 0.0, -1.0], [3, 1, 0, 2]),
];

pub fn parse(params: &mut Params) -> Result<Geometry, SceneError> {
    let (to_world, flip) = placement(params)?;
    Ok(Geometry::Mesh(Mesh::new(cube(), &to_world, flip, false)))
}

fn cube() -> MeshData {
    let (mut positions, mut normals, mut uvs, mut triangles) = (vec![], vec![], vec![], vec![]);
    for (normal, corners) in SIDES {
        let first = positions.len() as u32;
        for (corner, uv) in corners.into_iter().zip([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]) {
            positions.push([0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 }));
            normals.push(normal);
            uvs.push(uv);
        }
        triangles.push([first, first + 1, first + 2]);
        triangles.push([first + 3, first, first + 2]);
    }
    MeshData { positions, normals: Some(normals), uvs: Some(uvs), triangles, surface_points: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Transform;

    #[test]
    fn every_side_faces_outwards() {
        let mesh = Mesh::new(cube(), &Transform::IDENTITY, false, false);
        assert!((mesh.area() - 24.0).abs() < 1e-12);
        for triangle in 0..12 {
            let point = mesh.point::<true>(triangle, 0.3, 0.3);
            assert!(point.ng.dot(point.p) > 0.9 && point.ns.dot(point.p) > 0.9, "{triangle}");
        }
    }
}
