//! Links by mirrors.

use super::*;

/// A mirroring ball or wall beside the way to the lamp; alone, or seen through glass.
fn mirrors() -> Vec<(&'static str, Scene)> {
    let ball = format!(
        r#"<shape type="sphere"><point name="center" x="1.6" y="0.3" z="2"/><float name="radius" value="0.7"/>{MIRROR}</shape>"#
    );
    let wall = format!(
        r#"<shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate y="1" angle="80"/><translate x="2"/></transform>{MIRROR}</shape>"#
    );
    let block = format!(
        r#"<shape type="cube"><transform name="to_world"><scale value="0.5"/><translate x="-1.5" z="2"/></transform>{MIRROR}</shape>"#
    );
    let sheet = format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="9" y="9" z="0.1"/><translate z="0.5"/></transform>{GLASS}</shape>"#
    );
    vec![
        ("ball", scene(&ball)),
        ("wall", scene(&wall)),
        ("block", scene(&block)),
        ("ball behind glass", scene(&(ball + &sheet))),
    ]
}

/// The mirror of metal that shows the lamp.
fn metal(scene: &Scene) -> &Element {
    let mirrors = &scene.techniques.links.as_ref().expect("there is a mirror").mirrors;
    let links =
        |mirror: &&Element| pairs().filter(|(x, y)| !by(scene, *x, *y, Some(mirror)).is_empty()).count();
    let of_metal = |mirror: &&Element| !scene.shape_of(mirror.primitives[0]).0.refracts();
    (0..mirrors.len()).map(|i| mirrors.get(i)).filter(of_metal).max_by_key(links).expect("it is of metal")
}

#[test]
fn a_mirror_shows_its_image() {
    for (name, scene) in mirrors() {
        let mirror = metal(&scene);
        let mut tried = 0;
        for (x, y) in pairs() {
            let Some(found) = by(&scene, x, y, Some(mirror)).pop() else { continue };
            tried += 1;
            let expected = [0.9f32, 0.8, 0.7];
            if name == "ball behind glass" {
                assert_eq!((found.surfaces, found.eta2), (3, 1.0));
                continue;
            }
            assert_eq!((found.surfaces, found.chance), (1, 1.0));
            assert!((0..3).all(|i| (found.transmittance.0[i] - expected[i]).abs() < 1e-6), "{name}");
            let z = found.last.origin;
            let (before, behind) = (length(z - x), length(y - z));
            // Both ways make the same angle with the normal, which halves the angle between them.
            let half = unit(x - z) / 2.0 + unit(y - z) / 2.0;
            let cos = unit(x - z).dot(unit(half));
            let together = before + behind;
            // Of a ball, across and along the plane of the two (Coddington's equations for a mirror).
            let curved = match name {
                "ball" => 2.0 * before * behind / 0.7,
                _ => 0.0,
            };
            let spread = (together + curved / cos) * (together + curved * cos);
            assert!((found.spread / spread - 1.0).abs() < 1e-6, "{name} {x} {y}: {} {spread}", found.spread);
            if name == "ball" {
                assert!(length(unit(half) - (z - DVec3::new(1.6, 0.3, 2.0)) / 0.7) < 1e-6, "{x} {y}");
            }
            let image = mirror.image(x).expect("x is before it");
            if name == "wall" {
                assert!(
                    length(unit(y - image) - unit(y - z)) < 1e-9
                        && (length(y - image) - together).abs() < 1e-9
                );
            }
        }
        assert!(tried > 100, "{name}: {tried}");
    }
}

/// Points of the mirror itself: on which side of it they are is rounding.
#[test]
fn what_lies_in_a_mirror_is_not_seen_in_it() {
    for (name, scene) in mirrors() {
        let mirror = metal(&scene);
        let search = |x, y| {
            let from = Origin { p: x, primitive: 0 };
            Search::new(&scene, from, y, Some(mirror), 8, &mut Counters::default()).is_some()
        };
        let mut tried = 0;
        for (x, y) in pairs() {
            let Some(z) = mirror.reflection(x, y) else { continue };
            tried += 1;
            assert!(!search(z, y) && !search(x, z), "{name}: {x} {z} {y}");
        }
        assert!(tried > 100, "{name}: {tried}");
    }
}

/// The corners of a sheet lie in one plane but for their rounding, and either half may lie before the other.
#[test]
fn both_halves_of_a_sheet_are_mirrors() {
    const METAL: &str = r#"<bsdf type="twosided"><bsdf type="conductor"/></bsdf>"#;
    // Before the lamp; where there is no glass, what is between is not searched.
    const PANE: &str = r#"<shape type="rectangle"><bsdf type="thindielectric"/>
        <transform name="to_world"><scale value="9"/><translate z="4.6"/></transform></shape>"#;
    let frame = Frame::about(unit(DVec3::new(-0.9, 0.13, 0.31)));
    // About as many reflections lie on either half.
    let middle = DVec3::new(2.0, 0.1, 2.4) - frame.s * 1.5;
    for bent in [-1e-6, 1e-6] {
        let corner = |(s, t, n): (f64, f64, f64)| {
            let p = middle + frame.s * s + frame.t * t + frame.n * n;
            p.as_vec3().to_array()
        };
        let corners = [(-2.0, -2.0, 0.0), (2.0, -2.0, 0.0), (2.0, 2.0, 0.0), (-2.0, 2.0, bent)];
        let sheet = MeshData {
            positions: corners.map(corner).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshData::default()
        };
        let scene = with_meshes(&[(sheet, METAL.into())], PANE);
        let mirror = metal(&scene);
        assert_eq!(mirror.primitives.len(), 2);
        let mut met = [0; 2];
        for (x, y) in pairs() {
            let place = mirror.reflection(x, y).expect("both are before it") - middle;
            let (s, t) = (place.dot(frame.s), place.dot(frame.t));
            if s.abs().max(t.abs()) < 2.0 {
                met[usize::from(t > s)] += 1;
                let links = by(&scene, x, y, Some(mirror));
                let surfaces: Vec<u32> = links.iter().map(|link| link.surfaces).collect();
                assert_eq!(surfaces, [2], "{x} {y} by {s} {t}, bent by {bent}");
            }
        }
        assert!(met.iter().all(|count| *count > 20), "{met:?}");
    }
}

#[test]
fn both_sides_agree_on_the_density_by_mirrors() {
    let λ = Wavelengths::rgb();
    for (name, scene) in mirrors() {
        let mirror = metal(&scene);
        let primitive = mirror.primitives[0];
        let index = scene.emitters.list.iter().position(|e| e.shape.is_some()).expect("there is a lamp");
        let entry = &scene.emitters.list[index];
        let geometry = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
        let mirrors = &scene.techniques.links.as_ref().expect("there is a mirror").mirrors;
        let mut tried = 0;
        for (x, _) in pairs() {
            let Some(image) = mirror.image(x) else { continue };
            let u = DVec2::new((x.x * 37.0).rem_euclid(1.0), (x.y * 41.0).rem_euclid(1.0));
            let Some(light) = entry.emitter.sample(geometry, image, DVec3::ZERO, u, &λ) else { continue };
            let y = image + light.wi * light.distance;
            let Some(found) = by(&scene, x, y, Some(mirror)).pop() else { continue };
            let chain = |reflected: u32| through(found.surfaces - 1, None).with(Turn::Back, reflected);
            let known = mirrors.of_chain(&chain(primitive)).expect("it is known");
            let chance = mirrors.connector(x, known).chance;
            let expected = chance * density(light.pdf, light.wi, light.distance, &found, light.n);
            let end = EmitterPoint { emitter: index, p: y, n: light.n };
            let of = |chain| {
                let (from, counters) = (Origin { p: x, primitive: 0 }, &mut Counters::default());
                density_of(&scene, from, found.direction, chain, end, &λ, counters)
            };
            match of(chain(primitive)) {
                Some(pdf) => assert!((pdf / expected - 1.0).abs() < 1e-5, "{name}: {pdf} {expected}"),
                None => assert!(found.last.direction.dot(light.n) >= 0.0, "{name}: {x}"),
            }
            // Not by another mirror, and not without one.
            assert!(of(chain(0)).is_none());
            assert!(of(through(found.surfaces, None)).is_none());
            tried += 1;
        }
        assert!(tried > 50, "{name}: {tried}");
    }
}
