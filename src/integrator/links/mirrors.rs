//! Flat mirrors and convex balls: where a point is seen in them is known.
//!
//! **Flat.** The image x′ of a point x lies as far behind the plane as x before it; x sees y where the segment x′y
//! crosses the plane.
//!
//! **A ball,** seen from outside: x, y, the centre and the place z of the reflection lie in one plane. On the arc from the
//! direction to x to that to y, the angle to the normal grows at x and shrinks at y as z moves on, so as long as both see z there is one place
//! where the two are equal (Alhazen's problem); it is found by false position. Light for x comes from about the image of x: with the distance s
//! from the surface, rays near the axis meet s r/(2s + r) below it.
//!
//! Glass is a mirror too, and from within a good one.

use crate::bsdf::{AnyMaterial, Bsdf, Material, Visitor};
use crate::math::frame::unit;
use crate::math::{DVec2, DVec3, bounds, length};
use crate::scene::Shape;
use crate::shape::{Geometry, Mesh, SurfacePoint};
use crate::spectrum::{ColorMode, Wavelengths};

/// More mirrors than these are not asked; the smallest are left out.
const MOST_MIRRORS: usize = 16;

/// Meshes of more flat pieces than these are taken for curved.
const MOST_PIECES: usize = 32;

/// Corners belong to a plane that they miss by less than this part of the mesh's size: vertices are f32.
const FLAT: f64 = 16.0 * f32::EPSILON as f64;

#[derive(Clone, Copy, Debug)]
enum Surface {
    /// All points p with n·p = height.
    Plane {
        n: DVec3,
        height: f64,
    },
    Ball {
        centre: DVec3,
        radius: f64,
    },
}

/// A surface that reflects all light from a point as if there were one other point, or nearly so.
#[derive(Clone, Debug)]
pub struct Mirror {
    surface: Surface,
    /// The ball around it.
    around: (DVec3, f64),
    /// Which part of the light it reflects, about, on the side of the normal (of a ball: outside) and on the other.
    strength: [f64; 2],
    /// Counted over the whole scene, in order.
    pub primitives: Vec<u32>,
}

impl Mirror {
    pub fn has(&self, primitive: u32) -> bool {
        self.primitives.binary_search(&primitive).is_ok()
    }

    /// Where x seems to be when one looks at the mirror; `None` from where there is no mirror.
    pub fn image(&self, x: DVec3) -> Option<DVec3> {
        match self.surface {
            Surface::Plane { n, height } => Some(x - n * (2.0 * (n.dot(x) - height))),
            Surface::Ball { centre, radius } => {
                let from_centre = x - centre;
                let distance = length(from_centre);
                let s = distance - radius;
                let below = s * radius / (2.0 * s + radius);
                (s > 0.0).then(|| centre + from_centre * ((radius - below) / distance))
            }
        }
    }

    /// Where x sees y in it.
    pub fn reflection(&self, x: DVec3, y: DVec3) -> Option<DVec3> {
        match self.surface {
            Surface::Plane { n, height } => {
                let (a, b) = (n.dot(x) - height, n.dot(y) - height);
                // The weights of y's foot and x's.
                (a * b > 0.0).then(|| {
                    let part = a / (a + b);
                    (x - n * a) * (1.0 - part) + (y - n * b) * part
                })
            }
            Surface::Ball { centre, radius } => {
                on_unit_ball((x - centre) / radius, (y - centre) / radius).map(|n| centre + n * radius)
            }
        }
    }

    /// How much of the light at x it may bring, about: what it reflects, times the part of the surroundings that it fills.
    fn weight(&self, x: DVec3) -> f64 {
        let behind = match self.surface {
            Surface::Plane { n, height } => n.dot(x) < height,
            Surface::Ball { centre, radius } => length(x - centre) <= radius,
        };
        let (centre, radius) = self.around;
        self.strength[usize::from(behind)] * (radius * radius / (x - centre).length_squared()).min(1.0)
    }
}

/// The place on a ball of radius 1 about the origin where x sees y.
fn on_unit_ball(x: DVec3, y: DVec3) -> Option<DVec3> {
    /// False position needs six or seven steps; halving alone would need as many as there are bits.
    const STEPS: usize = 64;
    let (a, b) = (length(x), length(y));
    if !(a > 1.0 && b > 1.0) {
        return None;
    }
    let e1 = x / a;
    let along = y.dot(e1);
    let across = length(y - e1 * along);
    if across == 0.0 {
        return (along > 0.0).then_some(e1);
    }
    let e2 = (y - e1 * along) / across;
    // In the plane of the two: x = (a, 0), y = (along, across), and the normal leads from (1, 0) to y/|y| as t from 0 to 1.
    let normal = |t: f64| {
        let n = DVec2::new(1.0 - t + t * along / b, t * across / b);
        n / n.length()
    };
    // The sine of the angle to the normal; of a direction below the horizon, beyond that of the horizon.
    let sine = |n: DVec2, p: DVec2| {
        let way = p - n;
        let sine = n.perp_dot(way) / way.length();
        let above = n.dot(way) > 0.0;
        (if above { sine } else { sine.signum() * 2.0 - sine }, above)
    };
    let both = |t: f64| {
        let n = normal(t);
        (sine(n, DVec2::new(a, 0.0)), sine(n, DVec2::new(along, across)), n)
    };
    // Angles to the two sides are equal where their sines, of opposite signs, add to nothing.
    let end = |t: f64| (t, both(t).0.0 + both(t).1.0);
    let (mut low, mut high) = (end(0.0), end(1.0));
    if !(low.1 > 0.0 && high.1 < 0.0) {
        return None;
    }
    let mut last = 0;
    for _ in 0..STEPS {
        let t = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let (of_x, of_y, n) = both(t);
        let sum = of_x.0 + of_y.0;
        if sum.abs() <= 4.0 * f64::EPSILON || t <= low.0 || t >= high.0 {
            return (of_x.1 && of_y.1).then(|| e1 * n.x + e2 * n.y);
        }
        // The end that stays is believed less each time (the Illinois method).
        let side = if sum > 0.0 { 1 } else { -1 };
        if sum > 0.0 {
            low = (t, sum);
            high.1 *= if last == side { 0.5 } else { 1.0 };
        } else {
            high = (t, sum);
            low.1 *= if last == side { 0.5 } else { 1.0 };
        }
        last = side;
    }
    None
}

/// The mirrors of a scene.
#[derive(Debug)]
pub struct Mirrors(Vec<Mirror>);

impl Mirrors {
    pub fn of(shapes: &[Shape], materials: &[AnyMaterial], mode: ColorMode) -> Self {
        let mut mirrors: Vec<Mirror> =
            shapes.iter().flat_map(|shape| of_shape(shape, materials, mode)).collect();
        let size =
            |mirror: &Mirror| mirror.around.1 * mirror.around.1 * mirror.strength[0].max(mirror.strength[1]);
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

    /// One of them for the light at x, by a number in [0, 1), and with which chance. Where all together bring little, perhaps none: what is
    /// a hundredth of the light is asked for a hundredth of the time.
    pub fn choose(&self, x: DVec3, choice: f64) -> Option<(usize, f64)> {
        let mut weights = [0.0; MOST_MIRRORS];
        self.0.iter().zip(&mut weights).for_each(|(mirror, weight)| *weight = mirror.weight(x));
        let all = weights.iter().sum::<f64>().max(1.0);
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
        let all = self.0.iter().map(|mirror| mirror.weight(x)).sum::<f64>().max(1.0);
        Some((index, self.0[index].weight(x) / all)).filter(|chosen| chosen.1 > 0.0)
    }
}

fn of_shape(shape: &Shape, materials: &[AnyMaterial], mode: ColorMode) -> Vec<Mirror> {
    if !shape.sides.iter().any(|side| side.traits.mirrors) {
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
    let whole = |surface, around, strength| Mirror { surface, around, strength, primitives: vec![first] };
    match &shape.geometry {
        Geometry::Sphere(sphere) => {
            let around = (sphere.centre, sphere.radius);
            let surface = Surface::Ball { centre: sphere.centre, radius: sphere.radius };
            // From inside it would be a hollow mirror.
            vec![whole(surface, around, [strength[usize::from(sphere.inward)], 0.0])]
        }
        Geometry::Patch(patch) => {
            let surface = Surface::Plane { n: patch.n, height: patch.n.dot(patch.centre) };
            vec![whole(surface, around(&patch.corners()), strength)]
        }
        Geometry::Mesh(mesh) => flat_pieces(mesh)
            .into_iter()
            .map(|(surface, around, local)| Mirror {
                surface,
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
        let sample = material.at(&point, &λ).sample(self.wo, super::bent::REFLECTED, DVec2::ZERO);
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
fn flat_pieces(mesh: &Mesh) -> Vec<(Surface, (DVec3, f64), Vec<u32>)> {
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
        let surface = Surface::Plane { n: piece.n, height: piece.height };
        (surface, around(&piece.places), piece.triangles)
    };
    pieces.into_iter().map(plane).collect()
}

/// A ball around points.
fn around(points: &[DVec3]) -> (DVec3, f64) {
    let (lo, hi) = bounds::around(points.iter().copied());
    (0.5 * (lo + hi), 0.5 * length(hi - lo))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    /// Angles to the normal, signed, and whether both are above the horizon.
    fn angles(n: DVec3, x: DVec3, y: DVec3) -> (f64, bool) {
        let (to_x, to_y) = (unit(x - n), unit(y - n));
        (to_x.dot(n) - to_y.dot(n), to_x.dot(n) > 0.0 && to_y.dot(n) > 0.0)
    }

    #[test]
    fn on_a_ball_both_angles_are_equal() {
        let (mut found, mut none) = (0, 0);
        for i in 0..4000 {
            let part = |step: f64| (f64::from(i) * step).fract();
            // Distances from close above the ball to far from it, on all sides.
            let away = |u: f64| 1.0 + 1e-9 * 1e12f64.powf(u);
            let turn = std::f64::consts::TAU * part(0.618_033_989);
            let x = DVec3::new(0.6, 0.0, 0.8) * away(part(0.754_877_666));
            let y = DVec3::new(turn.cos(), 0.6 * turn.sin(), 0.8 * turn.sin()) * away(part(0.569_840_291));
            match on_unit_ball(x, y) {
                Some(n) => {
                    let (difference, above) = angles(n, x, y);
                    assert!(above && (length(n) - 1.0).abs() < 1e-12, "{x} {y}");
                    // The way from a point close to the ball is known as well as the point.
                    let known = 1e-13 / (length(x) - 1.0).min(length(y) - 1.0).min(1.0);
                    assert!(difference.abs() < 1e-9 + 100.0 * known, "{x} {y}: {difference}");
                    found += 1;
                }
                None => {
                    // No place on the arc between sees both.
                    let (a, b) = (unit(x), unit(y));
                    let sees = |i: i32| {
                        let n = unit(a * (1.0 - f64::from(i) / 1e3) + b * (f64::from(i) / 1e3));
                        x.dot(n) > 1.0 + 1e-6 && y.dot(n) > 1.0 + 1e-6
                    };
                    assert!(!(0..=1000).any(sees), "{x} {y}");
                    none += 1;
                }
            }
        }
        assert!(found > 500 && none > 500, "{found} {none}");
    }

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
        assert_eq!(cube.0.iter().map(|mirror| mirror.primitives.len()).collect::<Vec<_>>(), [2; 6]);
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
