//! What of a shape connects: planes, balls and the ways through balls of glass.

use super::bent::{NOT_REFLECTED, REFLECTED};
use super::element::{Element, Form};
use super::glass_ball::GlassBall;
use crate::bsdf::{AnyMaterial, Bsdf, Material, Visitor};
use crate::math::frame::unit;
use crate::math::{Ball, DVec2, DVec3, length};
use crate::scene::Shape;
use crate::shape::{Geometry, Mesh, Patch, SurfacePoint};
use crate::spectrum::ColorMode;

/// Most flat pieces of a mesh; one with more is taken to be curved.
const MOST_PIECES: usize = 32;

/// Corners belong to a plane if they miss it by no more than this fraction of the mesh's size: vertices are
/// f32.
const FLAT: f64 = 16.0 * f32::EPSILON as f64;

/// Most reflections inside a ball of glass: each keeps about a twentieth of the light.
const MOST_INNER: u32 = 1;

/// The elements that a shape is made of; none if it neither mirrors nor refracts, or is curved otherwise.
pub fn of_shape(shape: &Shape, materials: &[AnyMaterial], mode: ColorMode) -> Vec<Element> {
    if !shape.mirrors() && !shape.refracts() {
        return vec![];
    }
    let turned = [0, 1].map(|behind| {
        let side = shape.sides[behind];
        let wo = unit(DVec3::new(1.0, 0.0, if (behind == 1) == side.turned { 1.0 } else { -1.0 }));
        let turned = materials[side.material as usize].visit(At45 { wo, mode });
        Turned {
            reflected: if side.traits.mirrors { turned.reflected } else { 0.0 },
            eta: turned.eta.filter(|_| shape.refracts()),
        }
    });
    let strength = turned.map(|turned| turned.reflected);
    let first = shape.first_primitive;
    let whole =
        |form, around, strength, primitive| Element { form, around, strength, primitives: vec![primitive] };
    let plane = |patch: &Patch, primitive| {
        let form = Form::Plane { n: patch.n, height: patch.n.dot(patch.centre) };
        whole(form, patch.ball(), strength, primitive)
    };
    match &shape.geometry {
        Geometry::Sphere(sphere) => {
            let ball = shape.geometry.ball();
            // Only from outside: from inside it is a concave mirror.
            let Turned { reflected, eta } = turned[usize::from(sphere.inward)];
            let mirror = whole(Form::Ball(ball), ball, [reflected, 0.0], first);
            let glass_balls = eta
                .into_iter()
                .flat_map(|eta| (0..=MOST_INNER).map(move |inner| GlassBall { ball, eta, inner }));
            let through = |inner: u32| {
                (0..inner).fold((1.0 - reflected) * (1.0 - reflected), |part, _| part * reflected)
            };
            let glass_balls = glass_balls.map(|glass_ball| {
                whole(Form::GlassBall(glass_ball), ball, [through(glass_ball.inner), 0.0], first)
            });
            glass_balls.chain([mirror]).collect()
        }
        Geometry::Patch(patch) => vec![plane(patch, first)],
        Geometry::Cube(cube) => cube.faces().iter().zip(first..).map(|(face, i)| plane(face, i)).collect(),
        Geometry::Mesh(mesh) => flat_pieces(mesh)
            .into_iter()
            .map(|(form, around, local)| Element {
                form,
                around,
                strength,
                primitives: local.into_iter().map(|triangle| first + triangle).collect(),
            })
            .collect(),
        Geometry::Cylinder(_) => vec![],
    }
}

/// Samples a mirror or glass at 45°.
struct At45 {
    wo: DVec3,
    mode: ColorMode,
}

#[derive(Clone, Copy)]
struct Turned {
    /// Share of the light that is reflected.
    reflected: f64,
    /// Index of refraction behind over that in front; `None` unless all wavelengths are refracted alike.
    eta: Option<f64>,
}

impl Visitor for At45 {
    type Output = Turned;

    fn visit<M: Material>(self, material: &M) -> Turned {
        let λ = self.mode.wavelengths(0.5);
        let point = SurfacePoint::flat();
        let bsdf = material.at(&point, &λ);
        let reflected = bsdf.sample(self.wo, REFLECTED, DVec2::ZERO);
        let reflected = reflected.filter(|sample| sample.wi.z * self.wo.z > 0.0);
        let bent = bsdf.sample(self.wo, NOT_REFLECTED, DVec2::ZERO).filter(|sample| {
            sample.wi.z * self.wo.z < 0.0 && sample.delta && !sample.dispersed && sample.eta != 1.0
        });
        Turned {
            reflected: reflected
                .map_or(0.0, |sample| f64::from(λ.mean(sample.weight * λ.ones())) * sample.pdf),
            eta: bent.map(|sample| sample.eta),
        }
    }
}

/// A flat piece of a mesh that is being collected.
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
