//! Path reuse between dissimilar pixels: each scene has an edge within every group, and only pixels on its
//! darker side are compared. Light that a wrong weight moves from one side to the other shows there at once.

use super::Relation;
use super::caustics::{glass, globe, with_links};
use super::reuse::{Case, one_of, walls};
use super::still_life::INDEPENDENT;
use crate::stage::*;
use etalon::spectrum::ColorMode;
use validation::image::Image;

/// The margin is large because few pixels are compared; misplaced light would amount to tens of per cent.
const MARGIN: f64 = 0.1;

/// Width of the film in pixels: a group of 16 is followed by the last four columns.
const WIDTH: u32 = 8;

/// Half the horizontal field of view in degrees.
const HALF_ANGLE: f64 = 7.0;

const EYE: Point = [0.0, -4.5, 1.5];

/// A camera that looks horizontally along y.
fn camera() -> String {
    let place = look_at(EYE, [0.0, 0.0, EYE[2]], [0.0, 0.0, 1.0]);
    pinhole(&place, 2.0 * HALF_ANGLE, &(film(WIDTH, 2 * WIDTH) + INDEPENDENT))
}

/// Ratio of x to the distance from the camera, for points with this number of columns to their left.
fn slope(columns: f64) -> f64 {
    let half = f64::from(WIDTH) / 2.0;
    (columns - half) / half * HALF_ANGLE.to_radians().tan()
}

/// One pixel of the last column in each square of this edge, within which errors are correlated.
fn last_column<const EDGE: usize>(image: &Image) -> Image {
    let wanted = |column: usize, row: usize| column == image.width - 1 && row % EDGE == EDGE - 1;
    super::chosen(image, (1, image.height / EDGE), wanted)
}

fn case(name: &'static str, world: String) -> Case {
    Case { pixels: 16, camera: camera(), view: Some(last_column::<4>), ..Case::new(name, world) }
}

/// Two rooms, separated by a wall along the view direction, one on each side of the image. The right one is
/// darker.
fn two_rooms() -> Relation {
    let turn = slope(6.0).atan().to_degrees();
    let [near, far] = [1.0, 6.0];
    let centre = [slope(6.0) * 0.5 * (near + far), EYE[1] + 0.5 * (near + far), 1.5];
    let half = [1.6, 0.5 * (far - near), 1.0];
    let wall = shape(
        "rectangle",
        &[scale(half), rotate('y', 90.0), rotate('z', -turn), translate(centre)],
        &bsdf("twosided", &diffuse(0.5)),
    );
    let lamp = |x: f64, radiance: f64| {
        let steps = [scale([0.5, 0.5, 1.0]), rotate('x', 180.0), translate([x, -1.0, 2.9])];
        shape("rectangle", &steps, &area(radiance))
    };
    case("two_rooms", walls(&diffuse(0.7)) + &wall + &lamp(-1.2, 8.0) + &lamp(1.8, 1.0)).relation()
}

/// A pane of flint on the right and one of another glass on the left, and the lamp in a ball of flint.
fn two_panes() -> Relation {
    let flint = "<bsdf type=\"dielectric\"><string name=\"dispersion\" value=\"sf11\"/></bsdf>";
    let distance = 0.5;
    let edge = slope(6.0) * distance;
    let pane = |lo: f64, hi: f64, wears: &str| {
        let steps = [
            scale([0.5 * (hi - lo), 0.02, 0.4]),
            translate([0.5 * (hi + lo), EYE[1] + distance + 0.02, EYE[2]]),
        ];
        shape("cube", &steps, wears)
    };
    let panes = pane(-0.5, edge, &glass("")) + &pane(edge, 0.5, flint);
    let bulb = sphere([-0.5, 0.0, 1.0], 0.4, &area(4.0)) + &sphere([-0.5, 0.0, 1.0], 0.6, flint);
    let case = case("two_panes", walls(&diffuse(0.7)) + &panes + &bulb);
    let (mode, view) = (ColorMode::Spectral, Some(last_column::<8> as fn(&Image) -> Image));
    Case { integrator: path(7), light_paths: 0.0, mode, view, ..case }.relation().samples(32_768)
}

/// A floor of rough metal that reflects light, arriving from a wall at grazing angles, upwards.
fn grazed_floor() -> Relation {
    let metal = bsdf("roughconductor", &float("alpha", 1.0));
    let floor = shape("rectangle", &[scale([4.0, 4.0, 1.0])], &metal);
    let ceiling = [scale([4.0, 4.0, 1.0]), rotate('x', 180.0), translate([0.0, 0.0, 3.0])];
    let ceiling = shape("rectangle", &ceiling, &diffuse(0.8));
    let wall = [scale([0.6, 0.6, 1.0]), rotate('x', 90.0), translate([0.0, 2.9, 0.6])];
    let wall = shape("rectangle", &wall, &diffuse(0.8));
    let place = to_world(&[look_at([0.0, 0.0, 0.6], [0.0, 2.9, 0.6], [0.0, 0.0, 1.0])]);
    let spot = emitter("spot", &(place + &float("cutoff_angle", 11.0) + &grey("intensity", 50.0)));
    let place = look_at([0.0, 0.0, 1.5], [0.0, 1.0, 3.0], [0.0, 0.0, 1.0]);
    let camera = pinhole(&place, 40.0, &(film(WIDTH, 2 * WIDTH) + INDEPENDENT));
    let case = case("grazed_floor", floor + &ceiling + &wall + &spot);
    Case { camera, view: Some(one_of::<4>), ..case }.relation().samples(3 * 8192)
}

/// A board close to the camera, and a wall far behind it, lit by a spot behind the camera via a metal plate.
/// A pixel receives a thousand times less light from the board than from the wall, so its own paths find
/// nearly all light of the board and light paths nearly all of the wall's: light found by one method and
/// weighted as the other's would be counted twice.
fn near_and_far() -> Relation {
    let eye = [0.0, -4.5, 2.2];
    let place = look_at(eye, [0.0, 0.0, eye[2]], [0.0, 0.0, 1.0]);
    // A single group, with the board in front of its left half.
    let camera = pinhole(&place, 50.0, &(film(4, 4) + INDEPENDENT));
    let upright = |half: [f64; 2], place: Point, turn: f64| {
        let steps = [scale([half[0], half[1], 1.0]), rotate('x', turn), translate(place)];
        shape("rectangle", &steps, &diffuse(0.8))
    };
    let board = upright([0.06, 0.1], [-0.06, eye[1] + 0.1, eye[2]], 90.0);
    let wall = upright([2.0, 1.4], [0.0, -1.5, 2.1], 90.0);
    let screen = upright([1.5, 0.8], [0.0, -6.5, 1.45], -90.0);
    let plate = [scale([0.5, 0.5, 1.0]), translate([0.0, -5.5, 0.0])];
    let plate = shape("rectangle", &plate, &bsdf("roughconductor", &float("alpha", 0.15)));
    // Lower than the surfaces lit via the plate, and facing away from them.
    let lamp = [scale([0.1, 0.1, 1.0]), rotate('x', 180.0), translate([0.0, eye[1], 0.6])];
    let lamp = shape("rectangle", &lamp, &area(100.0));
    let case = case("near_and_far", board + &wall + &screen + &plate + &lamp);
    Case { camera, integrator: with_links(&path(4), "never"), view: Some(one_of::<4>), ..case }
        .relation()
        .samples(24 * 8192)
}

/// A dark room seen in a mirror, where light paths do not help, lit by a bulb in glass, which guided samples
/// find.
fn seen_in_a_mirror() -> Relation {
    let steps = [scale([0.5, 0.5, 1.0]), rotate('x', 90.0), rotate('z', 45.0), translate([0.0, -3.5, 1.5])];
    let mirror = shape("rectangle", &steps, &bsdf("conductor", ""));
    let case = case("seen_in_a_mirror", walls(&diffuse(0.4)) + &mirror + &globe());
    Case { integrator: with_links(&path(6), "guided"), view: Some(one_of::<4>), ..case }
        .relation()
        .samples(8192)
}

pub fn relations() -> Vec<Relation> {
    let relations = [two_rooms(), grazed_floor()].map(|relation| relation.within(MARGIN));
    // An error would be large: the contribution of one wavelength would be counted for eight, or dark pixels
    // would be bright.
    let at_a_glance = [two_panes(), seen_in_a_mirror()].map(|relation| relation.within(2.5 * MARGIN));
    let twice = near_and_far().within(4.0 * MARGIN);
    relations.into_iter().chain(at_a_glance).chain([twice]).collect()
}
