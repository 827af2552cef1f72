//! The mirrors of a scene: rectangles, disks, flat pieces of meshes, and balls seen from outside.
//!
//! Glass is a mirror too, and from within a good one.

use super::bent::REFLECTED;
use super::mirror::{Form, Mirror};
use crate::bsdf::{AnyMaterial, Bsdf, Material, Visitor};
use crate::math::frame::unit;
use crate::math::{Ball, DVec2, DVec3, length};
use crate::scene::Shape;
use crate::shape::{Geometry, Mesh, Patch, SurfacePoint};
use crate::spectrum::{ColorMode, Wavelengths};

/// More mirrors than these are not asked; the smallest are left out.
const MOST_MIRRORS: usize = 16;

/// Meshes of more flat pieces than these are taken for curved.
const MOST_PIECES: usize = 32;

/// Corners belong to a plane that they miss by less than this part of the mesh's size: vertices are f32.
const FLAT: f64 = 16.0 * f32::EPSILON as f64;

/// The mirrors of a scene.
#[derive(Debug)]
pub struct Mirrors(Vec<Mirror>);

impl Mirrors {
    pub fn of(shapes: &[Shape], materials: &[AnyMaterial], mode: ColorMode) -> Self {
        let mut mirrors: Vec<Mirror> =
            shapes.iter().flat_map(|shape| of_shape(shape, materials, mode)).collect();
        let size = |mirror: &Mirror| {
            mirror.around.radius * mirror.around.radius * mirror.strength[0].max(mirror.strength[1])
        };
        mirrors.retain(|mirror| size(mirror) > 0.0);
        mirrors.sort_by(|a, b| size(b).total_cmp(&size(a)));
        mirrors.truncate(MOST_MIRRORS);
        Self(mirrors)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn get(&self, index: usize) -> &Mirror {
        &self.0[index]
    }

    /// The weight of each for the light at x, and what their chances are in proportion to.
    fn weights(&self, x: DVec3) -> ([f64; MOST_MIRRORS], f64) {
        let mut weights = [0.0; MOST_MIRRORS];
        self.0.iter().zip(&mut weights).for_each(|(mirror, weight)| *weight = mirror.weight(x));
        (weights, weights.iter().sum::<f64>().max(1.0))
    }

    /// One of them for the light at x, by a number in [0, 1), and with which chance. Where all together bring
    /// little, perhaps none: what is a hundredth of the light is asked for a hundredth of the time.
    pub fn choose(&self, x: DVec3, choice: f64) -> Option<(usize, f64)> {
        let (weights, all) = self.weights(x);
        let mut rest = choice * all;
        let chosen = weights[..self.0.len()].iter().position(|weight| {
            rest -= weight;
            rest < 0.0
        })?;
        Some((chosen, weights[chosen] / all))
    }

    /// The mirror that a primitive belongs to, and the chance with which it is chosen for the light at x.
    pub fn chosen(&self, x: DVec3, primitive: u32) -> Option<(usize, f64)> {
        let index = self.0.iter().position(|mirror| mirror.has(primitive))?;
        let (weights, all) = self.weights(x);
        (weights[index] > 0.0).then(|| (index, weights[index] / all))
    }
}

fn of_shape(shape: &Shape, materials: &[AnyMaterial], mode: ColorMode) -> Vec<Mirror> {
    if !shape.mirrors() {
        return vec![];
    }
    let strength = [0, 1].map(|behind| {
        let side = shape.sides[behind];
        let wo = unit(DVec3::new(1.0, 0.0, if (behind == 1) == side.turned { 1.0 } else { -1.0 }));
        if side.traits.mirrors {
            materials[side.material as usize].visit(Reflected { wo, mode })
        } else {
            0.0
        }
    });
    let first = shape.first_primitive;
    let whole =
        |form, around, strength, primitive| Mirror { form, around, strength, primitives: vec![primitive] };
    let plane = |patch: &Patch, primitive| {
        let form = Form::Plane { n: patch.n, height: patch.n.dot(patch.centre) };
        whole(form, patch.ball(), strength, primitive)
    };
    match &shape.geometry {
        Geometry::Sphere(sphere) => {
            let ball = shape.geometry.ball();
            // From inside it would be a hollow mirror.
            vec![whole(Form::Ball(ball), ball, [strength[usize::from(sphere.inward)], 0.0], first)]
        }
        Geometry::Patch(patch) => vec![plane(patch, first)],
        Geometry::Cube(cube) => cube.faces().iter().zip(first..).map(|(face, i)| plane(face, i)).collect(),
        Geometry::Mesh(mesh) => flat_pieces(mesh)
            .into_iter()
            .map(|(form, around, local)| Mirror {
                form,
                around,
                strength,
                primitives: local.into_iter().map(|triangle| first + triangle).collect(),
            })
            .collect(),
        Geometry::Cylinder(_) => vec![],
    }
}

/// Which part of light a mirror reflects at 45°.
struct Reflected {
    wo: DVec3,
    mode: ColorMode,
}

impl Visitor for Reflected {
    type Output = f64;

    fn visit<M: Material>(self, material: &M) -> f64 {
        let λ = match self.mode {
            ColorMode::Rgb => Wavelengths::rgb(),
            ColorMode::Spectral => Wavelengths::sample_visible(0.5),
        };
        let point = SurfacePoint::flat();
        let sample = material.at(&point, &λ).sample(self.wo, REFLECTED, DVec2::ZERO);
        let sample = sample.filter(|sample| sample.wi.z * self.wo.z > 0.0);
        sample.map_or(0.0, |sample| f64::from(λ.mean(sample.weight)) * sample.pdf)
    }
}

/// A flat piece in the making.
struct Piece {
    n: DVec3,
    height: f64,
    places: Vec<DVec3>,
    triangles: Vec<u32>,
}

/// Planes of a mesh, with balls around what lies in them, and the triangles that do; none if it is curved.
fn flat_pieces(mesh: &Mesh) -> Vec<(Form, Ball, Vec<u32>)> {
    let (lo, hi) = mesh.bounds();
    let size = length(hi - lo);
    let mut pieces: Vec<Piece> = vec![];
    for triangle in 0..mesh.triangles.len() as u32 {
        let corner = |(u, v)| mesh.point::<false>(triangle, u, v);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(corner);
        let n = corners[0].ng;
        if !n.is_finite() || corners.iter().any(|corner| length(corner.ns - n) > FLAT) {
            continue;
        }
        let places = corners.map(|corner| corner.p);
        let holds = |piece: &&mut Piece| {
            let beside = |p: &DVec3| (piece.n.dot(*p) - piece.height).abs() <= FLAT * size;
            length(piece.n - n) <= FLAT && places.iter().all(beside)
        };
        if let Some(piece) = pieces.iter_mut().find(holds) {
            piece.places.extend(places);
            piece.triangles.push(triangle);
        } else if pieces.len() < MOST_PIECES {
            let height = n.dot(places[0]);
            pieces.push(Piece { n, height, places: places.to_vec(), triangles: vec![triangle] });
        } else {
            return vec![];
        }
    }
    let plane = |piece: Piece| {
        let form = Form::Plane { n: piece.n, height: piece.height };
        (form, Ball::of_points(piece.places.iter().copied()), piece.triangles)
    };
    pieces.into_iter().map(plane).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    #[test]
    fn mirrors_are_flat_or_balls_seen_from_outside() {
        let of = |shape: &str| {
            let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{shape}</scene>"#);
            let scene = load_text("mirrors.xml", &text, ColorMode::Rgb).expect("it loads");
            Mirrors::of(&scene.shapes, &scene.materials, ColorMode::Rgb)
        };
        let metal = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
        let glass = r#"<bsdf type="dielectric"/>"#;
        let cube = of(&format!(r#"<shape type="cube">{glass}</shape>"#));
        assert_eq!(cube.0.iter().map(|mirror| mirror.primitives.len()).collect::<Vec<_>>(), [1; 6]);
        for (shape, count) in [
            (format!(r#"<shape type="sphere">{metal}</shape>"#), 1),
            (format!(r#"<shape type="disk">{glass}</shape>"#), 1),
            (format!(r#"<shape type="cylinder">{metal}</shape>"#), 0),
            // Its mirror is inside.
            (
                format!(r#"<shape type="sphere"><boolean name="flip_normals" value="true"/>{metal}</shape>"#),
                0,
            ),
            (r#"<shape type="rectangle"><bsdf type="roughconductor"/></shape>"#.into(), 0),
            (r#"<shape type="rectangle"><bsdf type="plastic"/></shape>"#.into(), 0),
            (format!(r#"<shape type="rectangle"><bsdf type="mask">{metal}</bsdf></shape>"#), 0),
        ] {
            assert_eq!(of(&shape).0.len(), count, "{shape}");
        }
    }

    #[test]
    fn chances_are_those_of_the_choice() {
        let text = r#"<scene version="3.0.0"><sensor type="perspective"/>
            <shape type="sphere"><point name="center" x="3"/><bsdf type="conductor"/></shape>
            <shape type="sphere"><point name="center" y="2"/><bsdf type="conductor"/></shape>
            <shape type="rectangle"><transform name="to_world"><translate z="-1.5"/></transform><bsdf type="dielectric"/></shape>
            <shape type="rectangle"><transform name="to_world"><translate z="1.5"/></transform><bsdf type="conductor"/></shape></scene>"#;
        let scene = load_text("mirrors.xml", text, ColorMode::Rgb).expect("it loads");
        let mirrors = Mirrors::of(&scene.shapes, &scene.materials, ColorMode::Rgb);
        for x in [DVec3::ZERO, DVec3::X * 9.0, DVec3::new(-1.0, 0.5, 0.2)] {
            const N: u32 = 20_000;
            let mut times = [0.0; 4];
            for i in 0..N {
                let u = (f64::from(i) + 0.5) / f64::from(N);
                if let Some((index, chance)) = mirrors.choose(x, u) {
                    times[index] += 1.0 / f64::from(N);
                    assert_eq!(mirrors.chosen(x, mirrors.get(index).primitives[0]), Some((index, chance)));
                }
            }
            for (index, times) in times.into_iter().enumerate() {
                let chance =
                    mirrors.chosen(x, mirrors.get(index).primitives[0]).map_or(0.0, |chosen| chosen.1);
                assert!((times - chance).abs() < 2.0 / f64::from(N), "{x}: {times} {chance}");
            }
            // Of metal that reflects at its front alone, nothing is seen from behind.
            assert!(times[..3].iter().sum::<f64>() <= 1.0);
        }
    }
}
