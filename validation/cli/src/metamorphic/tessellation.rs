//! Different representations of the same surface.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;

pub fn relations() -> Vec<Relation> {
    let plain = || vec![Term::new(with(""))];
    let objects = objects(&[]);
    let [floor, wall, .., cube] = &objects[..] else { return vec![] };
    let analytic = cube.replace("\"obj\"", "\"cube\"").replace(CUBE_OF_TRIANGLES, "");
    let lamp = lamp(8.0);
    let swap = |from: &str, to: &str| vec![Term::new(with("").replace(from, to))];
    let squares = |n: i32| -> String {
        let side = 3.0 / f64::from(n);
        let place = |i: i32| side * f64::from(2 * i + 1 - n);
        let tile = |i: i32, j: i32| {
            shape(
                "rectangle",
                &[scale([side, side, 1.0]), translate([place(i), place(j), 0.0])],
                &diffuse(0.6),
            )
        };
        (0..n * n).map(|k| tile(k % n, k / n)).collect()
    };
    // A slab whose upper side is the floor.
    let slab = shape("cube", &[scale([3.0, 3.0, 0.5]), translate([0.0, 0.0, -0.5])], &diffuse(0.6));
    let back = [scale([3.0, 3.0, 1.0]), rotate('x', -90.0), translate([0.0, 1.5, 1.0])];
    let flipped = "<boolean name=\"flip_normals\" value=\"true\"/>".to_string() + &diffuse(0.4);
    let lamp_of = |kind: &str, steps: &[String]| vec![Term::new(with_light(&shape(kind, steps, &area(8.0))))];
    let disk = [scale([0.7, 0.7, 1.0]), rotate('x', 180.0), translate([0.0, 0.0, 2.5])];
    let turned = [vec![rotate('z', 40.0)], disk.to_vec()].concat();
    let ball = |center: Point, r: f64| sphere(center, r, &area(8.0));
    let scaled = shape("sphere", &[scale([0.3; 3]), translate([0.0, -1.0, 2.0])], &area(8.0));
    vec![
        Relation::expectation("floor_of_9", plain(), swap(floor, &squares(3))),
        Relation::expectation("floor_of_64", plain(), swap(floor, &squares(8))),
        Relation::expectation("floor_is_a_slab", plain(), swap(floor, &slab)),
        Relation::expectation("flipped_wall", plain(), swap(wall, &shape("rectangle", &back, &flipped))),
        Relation::expectation("turned_disk", lamp_of("disk", &disk), lamp_of("disk", &turned)),
        Relation::expectation(
            "sphere_by_transform",
            vec![Term::new(with_light(&ball([0.0, -1.0, 2.0], 0.3)))],
            vec![Term::new(with_light(&scaled))],
        )
        .longer(2),
        Relation::expectation(
            "floor_of_2_triangles",
            plain(),
            swap(floor, &mesh(floor, "ply", "square.ply")),
        ),
        Relation::expectation(
            "wall_of_32_triangles",
            plain(),
            swap(wall, &mesh(wall, "ply", "square-fine.ply")),
        ),
        Relation::expectation("lamp_of_2_triangles", plain(), swap(&lamp, &mesh(&lamp, "ply", "square.ply"))),
        Relation::expectation(
            "lamp_of_32_triangles",
            plain(),
            swap(&lamp, &mesh(&lamp, "ply", "square-fine.ply")),
        ),
        Relation::expectation("cube_of_obj", swap(cube, &analytic), plain()),
    ]
}

/// An analytic shape replaced by a mesh from a file.
fn mesh(shape: &str, kind: &str, file: &str) -> String {
    let inside = shape.split_once('>').map_or("", |(_, inside)| inside);
    format!("<shape type=\"{kind}\"><string name=\"filename\" value=\"meshes/{file}\"/>{inside}")
}
