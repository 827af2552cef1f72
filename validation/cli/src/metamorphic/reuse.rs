//! Path reuse between pixels: it changes the noise only.
//!
//! Only a subset of pixels is compared, no two of which share paths: so their variances suffice, and light
//! that a wrong weight moves from one pixel to its neighbour shows, though no light is lost.

use super::caustics::{
    down_upon_the_floor, globe, half_open, sheet, two_sided, vase, wall_before_two_lamps, with_links,
};
use super::still_life::*;
use super::{Relation, Term, chosen};
use crate::stage::*;
use etalon::integrator::path::reuse::correlated_edge;
use etalon::spectrum::ColorMode;
use validation::image::Image;

/// One pixel of each square with this edge length.
pub fn one_of<const EDGE: usize>(image: &Image) -> Image {
    let last = |place: usize| place % EDGE == EDGE - 1;
    chosen(image, (image.width / EDGE, image.height / EDGE), |column, row| last(column) && last(row))
}

/// A closed room with a lamp, in which nearly all light is reflected by several walls.
fn closed_room(wall: &str) -> String {
    walls(wall) + &lamp(4.0)
}

/// The closed room without its lamp.
pub(super) fn walls(wears: &str) -> String {
    let inwards = "<boolean name=\"flip_normals\" value=\"true\"/>";
    let steps = [scale([3.0, 3.0, 1.5]), translate([0.0, -2.0, 1.5])];
    shape("cube", &steps, &(wears.to_owned() + inwards))
}

/// A relation between an integrator with and without path reuse.
pub(super) struct Case {
    pub name: &'static str,
    /// Number of pixels in a group.
    pub pixels: u32,
    pub integrator: String,
    /// Number of light paths per camera path.
    pub light_paths: f64,
    /// Number of light paths per group of pixels, where paths are reused.
    pub shared_light_paths: u32,
    pub camera: String,
    pub world: String,
    pub mode: ColorMode,
    /// The pixels to compare; by default one of each group.
    pub view: Option<fn(&Image) -> Image>,
}

impl Case {
    pub fn new(name: &'static str, world: String) -> Self {
        Self {
            name,
            pixels: 4,
            integrator: path(4),
            light_paths: 1.0,
            shared_light_paths: 0,
            camera: camera(),
            world,
            mode: ColorMode::Rgb,
            view: None,
        }
    }

    fn option(self, kind: &str, name: &str, value: &str) -> Self {
        let integrator = self.integrator.replace("<integer name=\"rr_depth\" value=\"5\"/>", "");
        let option = format!("<{kind} name=\"{name}\" value=\"{value}\"/></integrator>");
        Self { integrator: integrator.replace("</integrator>", &option), ..self }
    }

    pub fn relation(self) -> Relation {
        let side = |pixels: u32| {
            let shared = if pixels > 1 { self.shared_light_paths } else { 0 };
            let more = [("reuse", pixels), ("shared_light_paths", shared)]
                .map(|(name, value)| format!("<integer name=\"{name}\" value=\"{value}\"/>"))
                .concat()
                + &float("light_paths", self.light_paths);
            let integrator = self.integrator.replace("</integrator>", &(more + "</integrator>"));
            let one = match correlated_edge(self.pixels, self.mode) {
                0..=2 => one_of::<2>,
                3..=4 => one_of::<4>,
                _ => one_of::<8>,
            };
            vec![Term {
                view: self.view.or(Some(one)),
                ..Term::new(scene(&[&integrator, &self.camera, &self.world]))
            }]
        };
        let relation = Relation::expectation(self.name, side(1), side(self.pixels)).samples(2048);
        if self.mode == ColorMode::Spectral { relation.in_spectra() } else { relation }
    }
}

/// A room between balls as large as grounds are, lit by a lamp at one of them: points of these are computed from
/// numbers a thousand times as large as they are.
fn large_balls() -> Case {
    const RADIUS: f64 = 1000.0;
    let wall = |centre: Point| sphere(centre, RADIUS, &diffuse(0.8));
    let balls = [
        [0.0, -RADIUS, 0.0],
        [0.0, RADIUS + 2.5, 0.0],
        [-RADIUS - 2.0, 0.0, 0.0],
        [RADIUS + 2.5, 0.0, 0.0],
        [0.0, 0.0, -RADIUS - 2.0],
    ];
    let steps = [scale([0.15; 3]), rotate('x', -90.0), translate([-0.8, 2.0, -0.6])];
    let lamp = shape("disk", &steps, &area(50.0));
    let place = look_at([1.2, 1.0, 2.0], [0.0, 0.8, 0.0], [0.0, 1.0, 0.0]);
    Case {
        camera: pinhole(&place, 60.0, &(film(16, 16) + INDEPENDENT)),
        integrator: path(6),
        light_paths: 0.0,
        shared_light_paths: 4,
        ..Case::new("large_balls", balls.map(wall).concat() + &lamp)
    }
}

/// A texture of two colours, in squares of a few pixels.
fn checks(name: &str, colors: [&str; 2]) -> String {
    format!(
        "<texture type=\"checkerboard\" name=\"{name}\">\
         <rgb name=\"color0\" value=\"{}\"/><rgb name=\"color1\" value=\"{}\"/>\
         <transform name=\"to_uv\"><scale value=\"7\"/></transform></texture>",
        colors[0], colors[1]
    )
}

fn board(colors: [&str; 2]) -> String {
    bsdf("diffuse", &checks("reflectance", colors))
}

/// Walls of rough metal with black squares, whose own paths end there: they scatter towards every source, but find
/// nothing for their neighbours.
fn black_metal() -> Case {
    let colours = checks("specular_reflectance", ["0", "0.9"]);
    let metal = "<string name=\"material\" value=\"none\"/>".to_owned() + &float("alpha", 0.4) + &colours;
    let world = closed_room(&bsdf("roughconductor", &metal)) + &sphere([-0.5, 0.0, 0.7], 0.6, &diffuse(0.5));
    Case { pixels: 16, integrator: path(6), light_paths: 0.0, ..Case::new("black_metal", world) }
}

/// A room that a lamp above a black board lights by way of the ceiling, which it grazes: the cosines of both ends of a
/// light path's vertex are far from alike there.
fn grazed_ceiling() -> Case {
    let lamp_steps = [scale([0.1, 1.5, 1.0]), rotate('y', 90.0), translate([-2.9, -1.5, 2.8])];
    let board_steps = [scale([1.4, 3.0, 1.0]), translate([-1.6, -1.5, 2.65])];
    let black = format!("<bsdf type=\"twosided\">{}</bsdf>", diffuse(0.0));
    let things = shape("rectangle", &lamp_steps, &area(80.0)) + &shape("rectangle", &board_steps, &black);
    Case {
        pixels: 16,
        integrator: path(8),
        light_paths: 0.0,
        shared_light_paths: 16,
        ..Case::new("lit_by_a_grazed_ceiling", walls(&diffuse(0.7)) + &things)
    }
}

/// The relation for an integrator in a closed room, with `light_paths` light paths per camera path.
pub(super) fn shared(name: &'static str, integrator: &str, light_paths: f64, things: &str) -> Relation {
    let world = closed_room(&diffuse(0.7)) + things;
    Case { integrator: integrator.to_owned(), light_paths, ..Case::new(name, world) }.relation()
}

pub fn relations() -> Vec<Relation> {
    let room = |things: &str| closed_room(&diffuse(0.7)) + things;
    let ball = |wears: &str| sphere([-0.5, 0.0, 0.7], 0.6, wears);
    let glass = bsdf("dielectric", &float("int_ior", 1.5));
    let mirror = bsdf("conductor", "<rgb name=\"specular_reflectance\" value=\"0.9, 0.7, 0.4\"/>");
    let flint = bsdf("dielectric", "<string name=\"dispersion\" value=\"sf11\"/>");
    let matte = objects(&[])[2..].concat();
    let checks = &board(["0.8, 0.5, 0", "0, 0.6, 0.7"]);
    let pure = &board(["0.8, 0, 0", "0, 0.7, 0.1"]);
    let screen = |wears: &str| {
        let steps = [scale([0.6, 0.6, 1.0]), rotate('x', 90.0), translate([0.3, -1.5, 0.8])];
        shape("rectangle", &steps, wears)
    };
    // Pickets stand upright and as far apart as neighbouring pixels see, so that one of them hides what the
    // next sees.
    let picket = |i: i32| {
        let steps =
            [scale([0.15, 0.5, 1.0]), rotate('y', 90.0), translate([0.25 * f64::from(i), -0.4, 0.15])];
        shape("rectangle", &steps, &format!("<bsdf type=\"twosided\">{}</bsdf>", diffuse(0.7)))
    };
    let pickets: String = (-5..6).map(picket).collect();
    let both_sides = format!("<bsdf type=\"twosided\">{}{}</bsdf>", diffuse(0.8), diffuse(0.2));
    let veil = format!("<bsdf type=\"mask\">{}{}</bsdf>", float("opacity", 0.5), diffuse(0.4));
    let relief = format!(
        "<bsdf type=\"normalmap\"><texture type=\"bitmap\" name=\"normalmap\"><boolean name=\"raw\" value=\"true\"/>\
         <string name=\"filename\" value=\"textures/normals.png\"/></texture>{}</bsdf>",
        diffuse(0.7)
    );
    let metal = |alpha| bsdf("roughconductor", &(float("alpha_u", alpha) + &float("alpha_v", 0.4)));
    let plastic = bsdf("roughplastic", &(float("alpha", 0.2) + &grey("diffuse_reflectance", 0.5)));
    let wide = camera().replace("<rfilter type=\"box\"/>", "<rfilter type=\"gaussian\"/>");
    let case = Case::new;
    let cases = vec![
        case("matte", room(&matte)),
        Case { integrator: path(-1), ..case("roulette", room(&matte)) }.option("integer", "rr_depth", "2"),
        case("smooth_normals", room(&vase(&diffuse(0.8)))),
        case("two_sides", room(&(screen(&both_sides) + &vase(&both_sides)))),
        case("rough_plastic", closed_room(&plastic) + &ball(&diffuse(0.5))),
        case("mirror", room(&(ball(&mirror) + &screen(&mirror)))),
        case("glass_before_mirror", room(&(ball(&glass) + &screen(&mirror)))),
        case(
            "bulb",
            room(&(sphere([-0.5, 0.0, 1.0], 0.3, &area(3.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, &glass))),
        ),
    ];
    let noisy = [
        Case { pixels: 2, ..case("two", room(&matte)) },
        Case { camera: wide, ..case("gaussian_film", room(&matte)) },
        case("veil", room(&screen(&veil))),
        case("glass", room(&ball(&glass))),
    ];
    // Rough receivers, rough sources, and both at once.
    let brushed = room(&(ball(&metal(0.2)) + &screen(&metal(0.1))));
    let polished = closed_room(&metal(0.3)) + &ball(&diffuse(0.5)) + &screen(&mirror);
    let brushed_metal = Case { pixels: 16, ..case("brushed_metal", brushed.clone()) };
    let metal_walls =
        Case { pixels: 16, light_paths: 0.0, integrator: path(6), ..case("metal_walls", polished) };
    let beside = brushed.clone() + &sphere([0.6, -0.6, 0.4], 0.3, &glass);
    let [metal_roulette, metal_beside_glass] =
        [("metal_roulette", brushed.clone()), ("metal_beside_glass", beside)].map(|(name, scene)| {
            Case { integrator: path(-1), ..case(name, scene) }.option("integer", "rr_depth", "3")
        });
    // Light paths of a group also find sources: few and many, short and long, via rough surfaces, and beside
    // those that are left to other methods.
    let lit = |case: Case, shared_light_paths: u32| Case {
        integrator: path(-1),
        pixels: 16,
        shared_light_paths,
        ..case
    };
    let limited = |case: Case| Case { integrator: case.integrator.replace("-1", "4"), ..case };
    let bare = sphere([-0.5, 0.0, 1.0], 0.3, &area(3.0));
    let lit_matte = limited(lit(case("lit", room(&matte)), 2));
    let lit_glass = limited(lit(case("lit_glass_and_mirror", room(&(ball(&glass) + &screen(&mirror)))), 4));
    let lit_metal = lit(case("lit_metal", brushed.clone()), 4);
    let one_way = two_sided(&(diffuse(0.7) + &half_open(0.5)));
    let lit_one_way = lit(case("lit_walls_of_two_sides", closed_room(&one_way) + &ball(&diffuse(0.5))), 16);
    // Nearly all light travels from the lamp via the tray below it and the ceiling.
    let tray = shape("rectangle", &[scale([1.4; 3]), translate([0.0, 0.0, 1.9])], &diffuse(0.8));
    let lit_by_a_tray = lit(case("lit_walls_of_two_sides_by_a_tray", closed_room(&one_way) + &tray), 16);
    let lit_by_one_of_two = Case {
        light_paths: 0.0,
        camera: down_upon_the_floor(),
        ..limited(lit(case("lit_by_one_of_two", wall_before_two_lamps(&metal(0.4))), 16))
    };
    let lit_at_length = [
        lit(case("lit_two_sides", room(&(screen(&both_sides) + &bare))), 8),
        lit(case("lit_by_many", room(&matte)), 16).option("integer", "rr_depth", "3"),
        lit(case("lit_smooth_normals", room(&vase(&diffuse(0.8)))), 4),
        lit(case("lit_relief", room(&(screen(&relief) + &ball(&diffuse(0.5))))), 4),
        Case { light_paths: 0.0, ..lit(case("lit_metal_alone", brushed), 4) },
        lit(case("lit_plastic", closed_room(&plastic) + &ball(&diffuse(0.5))), 4),
    ];
    let sky = objects(&[]).concat() + &lamp(4.0) + &constant(0.1);
    let lit_under_the_sky = lit(case("lit_under_the_sky", sky), 4);
    let open = Case { pixels: 16, ..case("open", objects(&[]).concat() + &constant(1.0)) };
    let checkered = case("checks", closed_room(checks) + &ball(checks));
    let hidden_lamp = case("hidden_lamp", room(&(matte.clone() + &screen(&area(1.0)))));
    let hidden_lamp = hidden_lamp.option("boolean", "hide_emitters", "true");
    let sixteen = Case { pixels: 16, ..case("sixteen", room(&matte)) };
    let mut relations: Vec<Relation> = cases.into_iter().map(Case::relation).collect();
    relations.extend(noisy.map(|case| case.relation().longer(2)));
    relations.push(case("relief", room(&(screen(&relief) + &ball(&diffuse(0.5))))).relation().longer(3));
    relations.push(Case { pixels: 16, ..case("pickets", room(&pickets)) }.relation().longer(3));
    relations.push(lit_matte.relation().longer(3).at_length());
    relations.push(lit_glass.relation().samples(3072).within(0.02));
    relations.push(lit_metal.relation().samples(3072).within(0.02));
    relations.push(lit_one_way.relation().longer(3));
    relations.push(lit_by_a_tray.relation().longer(9).within(0.04));
    relations.push(grazed_ceiling().relation().samples(8192).within(0.03));
    relations.push(lit_under_the_sky.relation().samples(8192).at_length());
    relations.extend(lit_at_length.map(|case| case.relation().samples(4096).at_length()));
    relations.push(lit_by_one_of_two.relation().samples(32 * 1024).within(0.03).at_length());
    relations.push(metal_roulette.relation().samples(4096).at_length());
    relations.push(metal_beside_glass.relation().samples(4096).at_length());
    relations.push(brushed_metal.relation().samples(3 * 4096).at_length());
    relations.push(metal_walls.relation().samples(4 * 4096).at_length());
    relations.push(open.relation().samples(4096));
    relations.push(checkered.relation().samples(8192));
    // Without light paths, pixels share the results of emitter samples through glass and by mirrors.
    let links = with_links(&path(6), "everywhere");
    let sheet = sheet(&bsdf("twosided", &mirror));
    relations.push(shared("links", &links, 0.0, &(globe() + &sheet)).at_length());
    relations.push(shared("links_beside_light_paths", &links, 1.0, &(globe() + &sheet)).at_length());
    relations.push(hidden_lamp.relation().samples(8192).at_length());
    relations.push(sixteen.relation().samples(8192).at_length());
    // A path whose light is black at one pixel's receiver must not be terminated for the others.
    let colours = Case {
        integrator: path(-1),
        pixels: 16,
        ..case("roulette_of_colours", closed_room(pure) + &ball(pure))
    };
    // It was 6 to 13 % too dark.
    relations.push(colours.option("integer", "rr_depth", "2").relation().samples(8192).within(0.02));
    let spectral = |case| Case { mode: ColorMode::Spectral, ..case };
    let dispersion = spectral(case("dispersion", room(&ball(&flint))));
    relations.push(dispersion.relation().samples(65_536).at_length());
    let spectra = spectral(case("spectra", closed_room(checks) + &matte));
    relations.push(spectra.relation().samples(65_536).at_length());
    // A quarter of the light was missing.
    relations.push(black_metal().relation().samples(4096).within(0.02));
    // As much.
    relations.push(large_balls().relation().samples(16_384).within(0.03));
    relations
}
