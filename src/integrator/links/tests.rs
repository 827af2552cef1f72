mod mirrors;

use super::chain::Turn;
use super::*;
use crate::load_text;
use crate::math::frame::unit;
use crate::math::{DVec2, Frame, Origin};
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
        triangles: (0..SIDE).flat_map(|j| (0..SIDE).flat_map(move |i| halves(i, j))).collect(),
        ..MeshData::default()
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

/// The ways through glass alone, by a ball of glass if there is one.
fn links(scene: &Scene, x: DVec3, y: DVec3) -> Vec<Link> {
    let balls = scene.techniques.links.iter().map(|links| &links.glass_balls);
    let balls = balls.flat_map(|balls| (0..balls.len()).map(|i| Some(balls.get(i))));
    [None].into_iter().chain(balls).flat_map(|element| by(scene, x, y, element)).collect()
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
fn through(surfaces: u32, alone: Option<u32>) -> SpecularChain {
    (0..surfaces).fold(SpecularChain::BEGUN, |chain, i| chain.with(Turn::Through, alone.unwrap_or(i)))
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
        let Links { glass_balls, mirrors, .. } = scene.techniques.links.as_ref().expect("there is glass");
        // By nothing else, through a ball, and with a reflection within.
        let inner = (0..mirrors.len()).filter(|i| mirrors.get(*i).glass_ball().is_some());
        let elements = (0..glass_balls.len()).map(|i| (glass_balls, i)).chain(inner.map(|i| (mirrors, i)));
        let techniques: Vec<_> = [None].into_iter().chain(elements.map(Some)).collect();
        for (which, (x, _)) in techniques.iter().flat_map(|which| pairs().map(move |pair| (which, pair))) {
            let Connector { by: element, chance } =
                which.map_or(Connector::THROUGH, |(elements, i)| elements.connector(x, i));
            let seen_from = element.map_or(x, |element| element.image(x).expect("x is outside"));
            let u = DVec2::new((x.x * 37.0).rem_euclid(1.0), (x.y * 41.0).rem_euclid(1.0));
            let Some(light) = entry.emitter.sample(geometry, seen_from, DVec3::ZERO, u, &λ) else {
                continue;
            };
            let y = seen_from + light.wi * light.distance;
            let end = EmitterPoint { emitter: index, p: y, n: light.n };
            let pdf_of = |direction, chain| {
                let from = Origin { p: x, primitive: 0 };
                density_of(&scene, from, direction, chain, end, &λ, &mut Counters::default())
            };
            let found = by(&scene, x, y, element);
            several += usize::from(found.len() > 1);
            let inner = element.and_then(Element::glass_ball).map_or(0, |ball| ball.inner);
            reflected += inner * found.len() as u32;
            for link in &found {
                let expected = chance * density(light.pdf, light.wi, light.distance, link, light.n);
                let alone = element.map(|element| element.primitives[0]);
                let within = |chain: SpecularChain| match alone {
                    Some(primitive) => (0..inner).fold(chain, |chain, _| chain.with(Turn::Back, primitive)),
                    None => chain,
                };
                let chain = within(through(link.surfaces - inner, alone));
                match pdf_of(link.direction, chain) {
                    Some(pdf) => assert!((pdf / expected - 1.0).abs() < 1e-5, "{name}: {pdf} {expected}"),
                    None => assert!(link.last.direction.dot(light.n) >= 0.0, "{name}: {x}"),
                }
                // Another direction is another way, and another number of interfaces too.
                let aside = unit(link.direction + DVec3::X * 1e-3);
                let fewer = within(through(link.surfaces - inner - 1, alone));
                assert!(pdf_of(aside, chain).is_none() && pdf_of(link.direction, fewer).is_none());
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
