use super::passage::Turn;
use super::*;
use crate::math::frame::unit;
use crate::math::{Frame, Origin};
use crate::scene::load_text;
use crate::shape::mesh_data::{MeshData, write_ply};
use crate::spectrum::ColorMode;

/// A lamp above a floor, and glass between.
fn scene(between: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"/>
            <integrator type="path"><string name="links" value="everywhere"/></integrator>
            <shape type="rectangle"><transform name="to_world"><scale value="9"/></transform></shape>
            <shape type="sphere"><point name="center" x="0.2" y="0.1" z="5"/><float name="radius" value="0.3"/>
                <emitter type="area"/></shape>{between}</scene>"#
    );
    load_text("glass.xml", &text, ColorMode::Rgb).expect("it loads")
}

const GLASS: &str =
    r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>"#;

fn slab() -> Scene {
    scene(&format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="9" y="9" z="0.5"/><translate z="2"/></transform>{GLASS}</shape>"#
    ))
}

/// A sheet that bends like a bowl, with the normals of the bowl.
fn bowl(height: f64, bend: f64) -> MeshData {
    const SIDE: u32 = 40;
    let at = |i: u32| (f64::from(i) / f64::from(SIDE) - 0.5) * 3.0;
    let places: Vec<(f64, f64)> = (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (at(i), at(j)))).collect();
    let normal =
        |(x, y): &(f64, f64)| unit(DVec3::new(-2.0 * bend * x, -2.0 * bend * y, 1.0)).as_vec3().to_array();
    let position = |(x, y): &(f64, f64)| [*x as f32, *y as f32, (height + bend * (x * x + y * y)) as f32];
    let corner = |i: u32, j: u32| j * (SIDE + 1) + i;
    let halves = |i: u32, j: u32| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    MeshData {
        positions: places.iter().map(position).collect(),
        normals: Some(places.iter().map(normal).collect()),
        uvs: None,
        triangles: (0..SIDE).flat_map(|j| (0..SIDE).flat_map(move |i| halves(i, j))).collect(),
    }
}

/// The lamp above the floor, meshes with what they wear, and other shapes.
fn with_meshes(meshes: &[(MeshData, String)], others: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a folder of its own");
    let shape = |(i, (mesh, wears)): (usize, &(MeshData, String))| {
        let file = folder.path().join(format!("{i}.ply"));
        write_ply(mesh, &file).expect("a file of its own");
        format!(r#"<shape type="ply"><string name="filename" value="{}"/>{wears}</shape>"#, file.display())
    };
    scene(&(meshes.iter().enumerate().map(shape).collect::<String>() + others))
}

fn curved() -> Vec<(&'static str, Scene)> {
    let ball = format!(
        r#"<shape type="sphere"><point name="center" z="2"/><float name="radius" value="0.8"/>{GLASS}</shape>"#
    );
    // Closer to the floor than its focus.
    let low = ball.replace(r#"z="2""#, r#"z="1""#);
    let hollow = r#"<shape type="sphere"><point name="center" x="0.1" z="2.1"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric"><float name="int_ior" value="1"/><float name="ext_ior" value="1.5"/></bsdf></shape>"#;
    let tube = format!(
        r#"<shape type="cylinder"><point name="p0" x="-3" z="2"/><point name="p1" x="3" z="2"/><float name="radius" value="0.7"/>{GLASS}</shape>"#
    );
    let below = (bowl(1.6, 0.15), GLASS.replace("1.5", "0.6666666667"));
    let lens = with_meshes(&[below, (bowl(2.4, -0.1), GLASS.into())], "");
    vec![
        ("ball", scene(&ball)),
        ("low ball", scene(&low)),
        ("globe", scene(&(ball.clone() + hollow))),
        ("tube", scene(&tube)),
        ("lens", lens),
    ]
}

/// The ways through glass alone, by a lens if there is one.
fn links(scene: &Scene, x: DVec3, y: DVec3) -> Vec<Link> {
    let lenses = scene.links.iter().map(|links| &links.lenses);
    let lenses = lenses.flat_map(|lenses| (0..lenses.len()).map(|i| Some(lenses.get(i))));
    [None].into_iter().chain(lenses).flat_map(|element| by(scene, x, y, element)).collect()
}

fn link(scene: &Scene, x: DVec3, y: DVec3) -> Option<Link> {
    links(scene, x, y).into_iter().next()
}

fn by(scene: &Scene, x: DVec3, y: DVec3, element: Option<&Element>) -> Vec<Link> {
    let mut counters = Counters::default();
    let search = Search::new(scene, Origin { p: x, primitive: 0 }, y, element, 8, &mut counters);
    search
        .iter()
        .flat_map(|search| search.links(&Wavelengths::rgb(), &mut Counters::default()).collect::<Vec<_>>())
        .collect()
}

/// So many surfaces that let light through; all of one primitive, if one is given.
fn through(surfaces: u32, alone: Option<u32>) -> Passage {
    (0..surfaces).fold(Passage::default(), |passage, i| passage.with(Turn::Through, alone.unwrap_or(i)))
}

/// Floor points and points near the lamp.
fn pairs() -> impl Iterator<Item = (DVec3, DVec3)> {
    let spread = |i: usize, step: f64| (i as f64 * step).fract() - 0.5;
    (0..200).map(move |i| {
        let x = DVec3::new(spread(i, 0.754_877_666), spread(i, 0.569_840_291), 0.0);
        (x, DVec3::new(0.2 + 0.5 * spread(i, 0.618_033_989), 0.1 + 0.5 * spread(i, 0.414_213_562), 4.7))
    })
}

#[test]
fn a_slab_moves_rays_as_snell_says() {
    let scene = slab();
    for (x, y) in pairs() {
        let found = link(&scene, x, y).expect("there is a way");
        let (sin, cos) = (found.direction.truncate().length(), found.direction.z);
        let (inside, cos_inside) = (sin / 1.5, (1.0 - sin * sin / 2.25f64).sqrt());
        // How far along the floor it comes, in 3.7 of air and 1 of glass.
        let along = 3.7 * sin / cos + inside / cos_inside;
        assert!((along - (y - x).truncate().length()).abs() < 1e-6, "{x} {y}");
        // Of the area R dR dφ for each sin θ dθ dφ, what lies across the ray.
        let change = 3.7 / (cos * cos) + cos / (1.5 * cos_inside * cos_inside * cos_inside);
        let spread = along * change * cos / sin;
        assert!((found.spread / spread - 1.0).abs() < 1e-6, "{} {spread}", found.spread);
        assert_eq!((found.surfaces, found.eta2), (2, 1.0));
    }
}

#[test]
fn spreads_are_quotients_of_differences() {
    for (name, scene) in curved() {
        let mut tried = 0;
        for (x, y) in pairs() {
            let Some(found) = links(&scene, x, y).pop() else { continue };
            let frame = Frame::about(found.last.direction);
            let step = 1e-5;
            let nearest = |y: DVec3| {
                let away = |link: &Link| length(link.direction - found.direction);
                let links = links(&scene, x, y);
                let nearest = links.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                nearest.map(|link| link.direction)
            };
            let moved = |along: DVec3| {
                let ends = [step, -step].map(|step| nearest(y + along * step));
                Some((ends[0]? - ends[1]?) / (2.0 * step))
            };
            let (Some(a), Some(b)) = (moved(frame.s), moved(frame.t)) else { continue };
            let spread = 1.0 / length(a.cross(b));
            // Vertices are f32, and so are their normals.
            let allowed = if name == "lens" { 1e-2 } else { 1e-3 };
            assert!(
                (found.spread / spread - 1.0).abs() < allowed,
                "{name} {x} {y}: {} {spread}",
                found.spread
            );
            tried += 1;
        }
        assert!(tried > 50, "{name}: {tried}");
    }
}

const MIRROR: &str = r#"<bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/>
    <rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/></bsdf></bsdf>"#;

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
    let mirrors = &scene.links.as_ref().expect("there is a mirror").mirrors;
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
            normals: None,
            uvs: None,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
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
        let mirrors = &scene.links.as_ref().expect("there is a mirror").mirrors;
        let mut tried = 0;
        for (x, _) in pairs() {
            let Some(image) = mirror.image(x) else { continue };
            let u = DVec2::new((x.x * 37.0).rem_euclid(1.0), (x.y * 41.0).rem_euclid(1.0));
            let Some(light) = entry.emitter.sample(geometry, (image, DVec3::ZERO), u, &λ) else { continue };
            let y = image + light.wi * light.distance;
            let Some(found) = by(&scene, x, y, Some(mirror)).pop() else { continue };
            let way = |reflected: u32| {
                let through = through(found.surfaces - 1, None);
                (found.direction, through.with(Turn::Back, reflected))
            };
            let known = mirrors.of_passage(&way(primitive).1).expect("it is known");
            let chance = mirrors.technique(x, known).chance;
            let expected = chance * density(light.pdf, (light.wi, light.distance), &found, light.n);
            let end = (index, &SurfacePoint::plain(y, light.n, light.n));
            let of = |way| {
                density_of(&scene, Origin { p: x, primitive: 0 }, way, end, &λ, &mut Counters::default())
            };
            match of(way(primitive)) {
                Some(pdf) => assert!((pdf / expected - 1.0).abs() < 1e-5, "{name}: {pdf} {expected}"),
                None => assert!(found.last.direction.dot(light.n) >= 0.0, "{name}: {x}"),
            }
            // Not by another mirror, and not without one.
            assert!(of(way(0)).is_none());
            assert!(of((found.direction, through(found.surfaces, None))).is_none());
            tried += 1;
        }
        assert!(tried > 50, "{name}: {tried}");
    }
}

#[test]
fn both_sides_agree_on_the_density() {
    let λ = Wavelengths::rgb();
    // What comes from above is thrown back by it.
    let below = format!(
        r#"<shape type="sphere"><point name="center" z="-1.5"/><float name="radius" value="1.2"/>{GLASS}</shape>"#
    );
    for (name, scene) in curved().into_iter().chain([("slab", slab()), ("ball below", scene(&below))]) {
        let (mut tried, mut several, mut reflected) = (0, 0, 0);
        let Some(index) = scene.emitters.list.iter().position(|e| e.shape.is_some()) else { panic!() };
        let entry = &scene.emitters.list[index];
        let geometry = entry.shape.map(|i| &scene.shapes[i as usize].geometry);
        let Links { lenses, mirrors, .. } = scene.links.as_ref().expect("there is glass");
        // By nothing else, through a ball, and with a reflection within.
        let inner = (0..mirrors.len()).filter(|i| mirrors.get(*i).lens().is_some());
        let elements = (0..lenses.len()).map(|i| (lenses, i)).chain(inner.map(|i| (mirrors, i)));
        let techniques: Vec<_> = [None].into_iter().chain(elements.map(Some)).collect();
        for (which, (x, _)) in techniques.iter().flat_map(|which| pairs().map(move |pair| (which, pair))) {
            let Technique { by: element, chance } =
                which.map_or(Technique::THROUGH, |(elements, i)| elements.technique(x, i));
            let seen_from = element.map_or(x, |element| element.image(x).expect("x is outside"));
            let u = DVec2::new((x.x * 37.0).rem_euclid(1.0), (x.y * 41.0).rem_euclid(1.0));
            let Some(light) = entry.emitter.sample(geometry, (seen_from, DVec3::ZERO), u, &λ) else {
                continue;
            };
            let y = seen_from + light.wi * light.distance;
            let end = (index, &SurfacePoint::plain(y, light.n, light.n));
            let counters = &mut Counters::default();
            let found = by(&scene, x, y, element);
            several += usize::from(found.len() > 1);
            let inner = element.and_then(Element::lens).map_or(0, |lens| lens.inner);
            reflected += inner * found.len() as u32;
            for link in &found {
                let expected = chance * density(light.pdf, (light.wi, light.distance), link, light.n);
                let alone = element.map(|element| element.primitives[0]);
                let within = |passage: Passage| match alone {
                    Some(primitive) => {
                        (0..inner).fold(passage, |passage, _| passage.with(Turn::Back, primitive))
                    }
                    None => passage,
                };
                let way = (link.direction, within(through(link.surfaces - inner, alone)));
                match density_of(&scene, Origin { p: x, primitive: 0 }, way, end, &λ, counters) {
                    Some(pdf) => assert!((pdf / expected - 1.0).abs() < 1e-5, "{name}: {pdf} {expected}"),
                    None => assert!(link.last.direction.dot(light.n) >= 0.0, "{name}: {x}"),
                }
                // Another direction is another way, and another number of interfaces too.
                let aside = unit(link.direction + DVec3::X * 1e-3);
                assert!(
                    density_of(&scene, Origin { p: x, primitive: 0 }, (aside, way.1), end, &λ, counters)
                        .is_none()
                );
                let fewer = (way.0, within(through(link.surfaces - inner - 1, alone)));
                assert!(
                    density_of(&scene, Origin { p: x, primitive: 0 }, fewer, end, &λ, counters).is_none()
                );
                tried += 1;
            }
        }
        assert!(tried > 50, "{name}: {tried}");
        assert!(name != "low ball" || several > 10, "{name}: {several}");
        assert_eq!(name == "ball below", reflected > 10, "{name}: {reflected}");
    }
}

#[test]
fn what_is_not_refracted_is_not_linked() {
    let rectangle = |wears: &str| {
        scene(&format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><translate z="2"/></transform>{wears}</shape>"#
        ))
    };
    let thin = rectangle(r#"<bsdf type="thindielectric"/>"#);
    let matte = rectangle(r#"<bsdf type="diffuse"/>"#);
    let frosted = rectangle(r#"<bsdf type="roughdielectric"/>"#);
    let veil = rectangle(r#"<bsdf type="mask"><bsdf type="dielectric"/></bsdf>"#);
    let (x, y) = (DVec3::new(0.3, 0.2, 0.0), DVec3::new(0.1, 0.1, 4.0));
    let straight = link(&thin, x, y).expect("a pane bends nothing");
    assert!(length(straight.direction - unit(y - x)) < 1e-12);
    assert!((straight.spread / (y - x).length_squared() - 1.0).abs() < 1e-9);
    for other in [matte, frosted, veil, scene("")] {
        assert!(link(&other, x, y).is_none());
    }
    // More interfaces than may be.
    let twice = scene(&format!(
        r#"<shape type="sphere"><point name="center" z="2"/>{GLASS}</shape><shape type="sphere"><point name="center" z="2"/><float name="radius" value="0.5"/>{GLASS}</shape>"#
    ));
    let find = |most| {
        let mut counters = Counters::default();
        Search::new(&twice, Origin { p: x, primitive: 0 }, y, None, most, &mut counters)
            .is_some_and(|search| search.links(&Wavelengths::rgb(), &mut counters).next().is_some())
    };
    assert!(find(8) && find(4) && !find(3));
}
