//! The mirrors of a scene: rectangles, disks, flat pieces of meshes, and balls seen from outside; and its
//! balls of glass.
//!
//! Glass is a mirror too, and from within a good one.

use super::bent::{NOT_REFLECTED, REFLECTED};
use super::element::{Element, Form};
use super::glass_ball::GlassBall;
use super::{Connector, SpecularChain};
use crate::bsdf::{AnyMaterial, Bsdf, Material, Visitor};
use crate::math::frame::unit;
use crate::math::{Ball, DVec2, DVec3, length};
use crate::scene::Shape;
use crate::shape::{Geometry, Mesh, Patch, SurfacePoint};
use crate::spectrum::ColorMode;

/// Most elements of a kind; the largest are taken.
const MOST_ELEMENTS: usize = 16;

/// Most flat pieces of a mesh; one with more is taken to be curved.
const MOST_PIECES: usize = 32;

/// Corners belong to a plane if they miss it by no more than this fraction of the mesh's size: vertices are
/// f32.
const FLAT: f64 = 16.0 * f32::EPSILON as f64;

/// Most reflections inside a ball of glass: each keeps about a twentieth of the light.
const MOST_INNER: u32 = 1;

/// Mirrors, or balls of glass, of which each emitter sample uses at most one.
#[derive(Debug)]
pub struct Elements(Vec<Element>);

impl Elements {
    /// The elements that reflect light, balls of glass with inner reflections among them, and the balls of glass that
    /// it goes straight through.
    pub fn of(shapes: &[Shape], materials: &[AnyMaterial], mode: ColorMode) -> [Self; 2] {
        let elements = shapes.iter().flat_map(|shape| of_shape(shape, materials, mode));
        let (glass_balls, mirrors): (Vec<_>, _) = elements.partition(Element::gathers);
        [mirrors, glass_balls].map(Self::largest)
    }

    fn largest(mut elements: Vec<Element>) -> Self {
        let size = |element: &Element| {
            element.around.radius * element.around.radius * element.strength[0].max(element.strength[1])
        };
        elements.retain(|element| size(element) > 0.0);
        elements.sort_by(|a, b| size(b).total_cmp(&size(a)));
        elements.truncate(MOST_ELEMENTS);
        Self(elements)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn get(&self, index: usize) -> &Element {
        &self.0[index]
    }

    /// The weight of each for the light at x, and the number by which weights are divided to be
    /// probabilities.
    fn weights(&self, x: DVec3) -> ([f64; MOST_ELEMENTS], f64) {
        let mut weights = [0.0; MOST_ELEMENTS];
        self.0.iter().zip(&mut weights).for_each(|(element, weight)| *weight = element.weight(x));
        (weights, weights.iter().sum::<f64>().max(1.0))
    }

    /// Chooses one for the light at x by a number in [0, 1), or none, if all together contribute little: an
    /// element that contributes a hundredth of the light is chosen with a probability of a hundredth.
    pub fn choose(&self, x: DVec3, choice: f64) -> Option<Connector<'_>> {
        let (weights, all) = self.weights(x);
        let mut rest = choice * all;
        let chosen = weights[..self.0.len()].iter().position(|weight| {
            rest -= weight;
            rest < 0.0
        })?;
        Some(Connector { by: Some(self.get(chosen)), chance: weights[chosen] / all })
    }

    /// Index of the one whose links lead by such surfaces.
    pub fn of_chain(&self, chain: &SpecularChain) -> Option<usize> {
        self.0.iter().position(|element| match element.glass_ball() {
            Some(glass_ball) => chain.is_through(element.primitives[0], glass_ball.inner),
            None => chain.mirror.is_some_and(|primitive| {
                // A ball is no mirror from inside.
                chain.reflections == 1 && element.has(primitive) && !chain.is_through(primitive, 1)
            }),
        })
    }

    /// One of them, with the probability of choosing it for the light at x.
    pub fn connector(&self, x: DVec3, index: usize) -> Connector<'_> {
        let (weights, all) = self.weights(x);
        Connector { by: Some(self.get(index)), chance: weights[index] / all }
    }

    /// Whether a primitive is one of them.
    pub fn have(&self, primitive: u32) -> bool {
        self.0.iter().any(|element| element.has(primitive))
    }
}

fn of_shape(shape: &Shape, materials: &[AnyMaterial], mode: ColorMode) -> Vec<Element> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::spectrum::ColorMode;

    #[test]
    fn mirrors_are_flat_or_balls_seen_from_outside() {
        let of = |shape: &str| {
            let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{shape}</scene>"#);
            let scene = load_text("mirrors.xml", &text, ColorMode::Rgb).expect("it loads");
            Elements::of(&scene.shapes, &scene.materials, ColorMode::Rgb)
        };
        let metal = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
        let glass = r#"<bsdf type="dielectric"/>"#;
        let cube = of(&format!(r#"<shape type="cube">{glass}</shape>"#));
        assert_eq!(cube[0].0.iter().map(|mirror| mirror.primitives.len()).collect::<Vec<_>>(), [1; 6]);
        for (shape, count) in [
            (format!(r#"<shape type="sphere">{metal}</shape>"#), [1, 0]),
            // From outside and from inside, and through it.
            (format!(r#"<shape type="sphere">{glass}</shape>"#), [2, 1]),
            // Bends nothing.
            (r#"<shape type="sphere"><bsdf type="thindielectric"/></shape>"#.into(), [1, 0]),
            (format!(r#"<shape type="disk">{glass}</shape>"#), [1, 0]),
            (format!(r#"<shape type="cylinder">{metal}</shape>"#), [0, 0]),
            // Its mirror is inside.
            (
                format!(r#"<shape type="sphere"><boolean name="flip_normals" value="true"/>{metal}</shape>"#),
                [0, 0],
            ),
            (r#"<shape type="rectangle"><bsdf type="roughconductor"/></shape>"#.into(), [0, 0]),
            (r#"<shape type="rectangle"><bsdf type="plastic"/></shape>"#.into(), [0, 0]),
            (format!(r#"<shape type="rectangle"><bsdf type="mask">{metal}</bsdf></shape>"#), [0, 0]),
        ] {
            assert_eq!(of(&shape).map(|elements| elements.0.len()), count, "{shape}");
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
        let [mirrors, _] = Elements::of(&scene.shapes, &scene.materials, ColorMode::Rgb);
        for x in [DVec3::ZERO, DVec3::X * 9.0, DVec3::new(-1.0, 0.5, 0.2)] {
            const N: u32 = 20_000;
            let mut times = [0.0; 4];
            for i in 0..N {
                let u = (f64::from(i) + 0.5) / f64::from(N);
                if let Some(Connector { by: Some(mirror), chance }) = mirrors.choose(x, u) {
                    let index =
                        (0..4).position(|i| std::ptr::eq(mirrors.get(i), mirror)).expect("it is one of them");
                    times[index] += 1.0 / f64::from(N);
                    assert_eq!(mirrors.connector(x, index).chance, chance);
                }
            }
            for (index, times) in times.into_iter().enumerate() {
                let chance = mirrors.connector(x, index).chance;
                assert!((times - chance).abs() < 2.0 / f64::from(N), "{x}: {times} {chance}");
            }
            // Of metal that reflects at its front alone, nothing is seen from behind.
            assert!(times[..3].iter().sum::<f64>() <= 1.0);
        }
    }
}
