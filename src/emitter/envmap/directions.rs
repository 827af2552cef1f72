//! Directions towards an image of the surroundings, chosen by how bright it is there and how much a surface faces it.
//!
//! A surface of normal n gathers L(ω) cos θ, so the density is the product of two factors. The luminance is bilinear between
//! texel centres, in the turn and the height (the cosine of the polar angle). The cosine is that of a *block* of cells and of
//! the nearest of some normals all over the sphere, smoothed so that it is positive, for other directions of the block may be
//! above the horizon of other normals. Blocks are few, so the probabilities of all of them are tabulated for each
//! of the normals; inside a block the luminance alone decides, and is tabulated once.
//!
//! The density is thereby known in closed form, at the price of no table at all: with c of block and normal, Σ the sum over all cells
//! of c times luminance times height, and W cells around the equator, p(ω) = L(ω) c W / (2π Σ).

use crate::math::frame::unit;
use crate::math::function::sin_cos_turn;
use crate::math::{DVec2, DVec3, INV_PI, warp};
use std::f64::consts::{FRAC_PI_2, PI};

/// No more blocks than these along the turn and the height: their tables stay in a near cache.
const BLOCKS: [usize; 2] = [32, 16];

/// Normals along an edge of the square that the octahedron is unfolded to; odd, so that the axes are among them.
const NORMALS: usize = 17;

/// Most normals are nearer than this to the nearest of those, in radians.
const NEAR: f64 = 0.15;

/// The number of the choice that faces everything.
const ANYWHERE: usize = NORMALS * NORMALS;

/// A place within a cell, between the texel centres at its corners.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Its texels to the left are in this column, those above in this row.
    pub cell: Cell,
    /// The part of its width.
    pub across: f64,
    /// The part of its height, of the cosine.
    pub down: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    pub column: usize,
    pub row: usize,
}

/// The luminance at the corners of a cell: of the row above, left and right, and of the row below.
pub type Corners = [[f64; 2]; 2];

#[derive(Debug)]
pub struct Directions {
    columns: usize,
    /// Height of each row of cells and its upper edge, as cosines.
    strips: Vec<(f64, f64)>,
    /// Cells along a block's sides, as powers of two, and blocks along the image's.
    shift: [u32; 2],
    blocks: [usize; 2],
    /// The middles of blocks, row by row.
    middles: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// What cosines are smoothed by.
    blur: f64,
    /// For each normal, and for none, running sums over rows of blocks and then, row by row, over blocks.
    choices: Vec<f64>,
    /// For each block, running sums over its rows and then, row by row, over its cells.
    insides: Vec<f64>,
}

impl Directions {
    /// From the corners of each of `columns` × `rows` cells.
    pub fn new(columns: usize, rows: usize, corners: impl Fn(Cell) -> Corners) -> Self {
        let strips: Vec<(f64, f64)> = (0..rows).map(|row| strip(row, rows)).collect();
        let shift = [(columns, BLOCKS[0]), (rows, BLOCKS[1])]
            .map(|(cells, blocks)| cells.div_ceil(blocks).next_power_of_two().trailing_zeros());
        let side = shift.map(|shift| 1 << shift);
        let blocks = [columns.div_ceil(side[0]), rows.div_ceil(side[1])];
        let (mut insides, mut middles, mut weights) = (vec![], vec![], vec![]);
        for block_row in 0..blocks[1] {
            for block_column in 0..blocks[0] {
                let first = Cell { column: block_column * side[0], row: block_row * side[1] };
                let end =
                    Cell { column: columns.min(first.column + side[0]), row: rows.min(first.row + side[1]) };
                let cell = |row: usize, column: usize| {
                    let cell = Cell { column: first.column + column, row: first.row + row };
                    let there = cell.column < end.column && cell.row < end.row;
                    if there { mean(corners(cell)) * strips[cell.row].0 } else { 0.0 }
                };
                weights.push(sums_of(&mut insides, side[1], side[0], cell));
                let turn = (0.5 * (first.column + end.column) as f64 + 0.5) / columns as f64;
                middles
                    .push(direction(turn, libm::cos(0.5 * PI * (first.row + end.row) as f64 / rows as f64)));
            }
        }
        let angle =
            [side[0] as f64 / columns as f64, 0.5 * side[1] as f64 / rows as f64].map(|part| PI * part);
        let blur = 0.25 * libm::sin((NEAR + libm::hypot(angle[0], angle[1])).min(FRAC_PI_2));
        let normals = (0..ANYWHERE).map(normal_of).collect();
        let mut choices = vec![];
        let mut directions =
            Self { columns, strips, shift, blocks, middles, normals, blur, choices: vec![], insides };
        for normal in 0..=ANYWHERE {
            let block = |row: usize, column: usize| {
                let block = row * blocks[0] + column;
                weights[block] * directions.facing(normal, block)
            };
            sums_of(&mut choices, blocks[1], blocks[0], block);
        }
        directions.choices = choices;
        directions
    }

    /// The sum of luminance times height over all cells.
    pub fn total(&self) -> f64 {
        self.table(ANYWHERE)[self.blocks[1] - 1]
    }

    /// A place that may light a surface of normal n, or of none if n is zero; `None` if nothing shines there.
    #[inline]
    pub fn sample(&self, n: DVec3, u: DVec2, corners: impl Fn(Cell) -> Corners) -> Option<Place> {
        let (block, u) = pick_both(self.table(nearest(n)), self.blocks, u)?;
        let number = block.row * self.blocks[0] + block.column;
        let side = self.shift.map(|shift| 1 << shift);
        let size = side[1] + side[0] * side[1];
        let (inside, u) = pick_both(&self.insides[number * size..][..size], side, u)?;
        let [column, row] = [(block.column, inside.column, 0), (block.row, inside.row, 1)]
            .map(|(block, cell, i)| (block << self.shift[i]) + cell);
        let cell = Cell { column, row };
        let [above, below] = corners(cell);
        let across = warp::linear(u.x, above[0] + below[0], above[1] + below[1]);
        let down = warp::linear(u.y, lerp(above, across), lerp(below, across));
        Some(Place { cell, across, down })
    }

    /// The density of a place for normal n, in sr⁻¹.
    #[inline]
    pub fn pdf(&self, n: DVec3, place: &Place, [above, below]: Corners) -> f64 {
        let normal = nearest(n);
        let total = self.table(normal)[self.blocks[1] - 1];
        let block = (place.cell.row >> self.shift[1]) * self.blocks[0] + (place.cell.column >> self.shift[0]);
        let luminance = lerp([lerp(above, place.across), lerp(below, place.across)], place.down);
        let facing = self.facing(normal, block);
        if total > 0.0 { luminance * facing / total * (0.5 * INV_PI * self.columns as f64) } else { 0.0 }
    }

    /// The turn of a place about +y, and the cosine of its polar angle.
    #[inline]
    pub fn turn_and_height(&self, place: &Place) -> (f64, f64) {
        let turn = (place.cell.column as f64 + 0.5 + place.across) / self.columns as f64;
        let (height, top) = self.strips[place.cell.row];
        (if turn < 1.0 { turn } else { turn - 1.0 }, top - place.down * height)
    }

    /// The place at a turn in [0, 1], a polar angle in half turns, and the cosine of that angle.
    #[inline]
    pub fn place(&self, turn: f64, half_turns: f64, height: f64) -> Place {
        let rows = self.strips.len();
        let row = ((half_turns * rows as f64) as usize).min(rows - 1);
        let x = turn * self.columns as f64 - 0.5;
        let x = if x < 0.0 { x + self.columns as f64 } else { x };
        let column = (x as usize).min(self.columns - 1);
        let (strip, top) = self.strips[row];
        let down = ((top - height) / strip).clamp(0.0, 1.0);
        Place { cell: Cell { column, row }, across: (x - column as f64).min(1.0), down }
    }

    /// The running sums over rows of blocks, and those over blocks.
    #[inline]
    fn table(&self, normal: usize) -> &[f64] {
        let size = self.blocks[1] + self.blocks[0] * self.blocks[1];
        &self.choices[normal * size..][..size]
    }

    /// How much a block is taken to face a normal: (c + √(c² + ε²))/2 of the cosine c, close to max(c, 0) but never zero.
    #[inline]
    fn facing(&self, normal: usize, block: usize) -> f64 {
        if normal == ANYWHERE {
            return 1.0;
        }
        let (c, blur) = (self.normals[normal].dot(self.middles[block]), self.blur);
        // Below the horizon the sum would cancel.
        let large = 0.5 * (c.abs() + (c * c + blur * blur).sqrt());
        if c > 0.0 { large } else { 0.25 * blur * blur / large }
    }
}

/// The direction at a turn about +y, of which the middle of the image is half a one, and a height.
#[inline]
pub fn direction(turn: f64, height: f64) -> DVec3 {
    let (sin, cos) = sin_cos_turn(turn);
    let r = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt();
    DVec3::new(r * sin, height, -r * cos)
}

/// Appends running sums over rows, and over the columns of each row, and answers with the sum of all.
fn sums_of(sums: &mut Vec<f64>, rows: usize, columns: usize, weight: impl Fn(usize, usize) -> f64) -> f64 {
    let (first, mut total) = (sums.len(), 0.0);
    sums.resize(first + rows, 0.0);
    for row in 0..rows {
        let mut sum = 0.0;
        for column in 0..columns {
            sum += weight(row, column);
            sums.push(sum);
        }
        total += sum;
        sums[first + row] = total;
    }
    total
}

/// Chooses a row and a column by running sums, and stretches what is left of u over the cell.
#[inline]
fn pick_both(sums: &[f64], [columns, rows]: [usize; 2], u: DVec2) -> Option<(Cell, DVec2)> {
    let (sums, below) = sums.split_at(rows);
    let (row, y) = pick(sums, u.y)?;
    let (column, x) = pick(&below[row * columns..][..columns], u.x)?;
    Some((Cell { column, row }, DVec2::new(x, y)))
}

/// The first of some running sums that is above u of the last, and what is left of u.
#[inline]
fn pick(sums: &[f64], u: f64) -> Option<(usize, f64)> {
    let total = *sums.last()?;
    if total <= 0.0 {
        return None;
    }
    let x = (u * total).min(total.next_down());
    // Counting all is faster than a search: there are few, no branch depends on them, and registers hold several.
    let index: usize = sums.iter().map(|sum| usize::from(*sum <= x)).sum();
    let below = if index == 0 { 0.0 } else { sums[index - 1] };
    Some((index, ((x - below) / (sums[index] - below)).min(1.0 - f64::EPSILON / 2.0)))
}

/// The number of the normal nearest to n on the octahedron, or of none.
#[inline]
fn nearest(n: DVec3) -> usize {
    if n == DVec3::ZERO {
        return ANYWHERE;
    }
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs());
    let (a, b) = if n.y < 0.0 { (fold(n.x, n.z), fold(n.z, n.x)) } else { (n.x, n.z) };
    let [column, row] = [a, b].map(|v| ((0.5 + 0.5 * v) * (NORMALS - 1) as f64 + 0.5) as usize);
    row * NORMALS + column
}

fn normal_of(number: usize) -> DVec3 {
    let [a, b] = [number % NORMALS, number / NORMALS].map(|i| 2.0 * i as f64 / (NORMALS - 1) as f64 - 1.0);
    let y = 1.0 - a.abs() - b.abs();
    let (x, z) = if y < 0.0 { (fold(a, b), fold(b, a)) } else { (a, b) };
    unit(DVec3::new(x, y, z))
}

/// A coordinate of the octahedron's lower half in the unfolded square, and back.
#[inline]
fn fold(a: f64, b: f64) -> f64 {
    (1.0 - b.abs()).copysign(a)
}

fn mean(corners: Corners) -> f64 {
    0.25 * corners.as_flattened().iter().sum::<f64>()
}

fn lerp([a, b]: [f64; 2], t: f64) -> f64 {
    a + t * (b - a)
}

/// The height of a row of cells, which is 2 sin(mid) sin(half), free of cancellation, and its upper edge.
fn strip(row: usize, rows: usize) -> (f64, f64) {
    let step = PI / rows as f64;
    (2.0 * libm::sin((row as f64 + 0.5) * step) * libm::sin(0.5 * step), libm::cos(row as f64 * step))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bright spot on a dim ground with a black stripe.
    fn corners(columns: usize) -> impl Fn(Cell) -> Corners {
        let luminance = move |row: usize, column: usize| match (row, column % columns) {
            (7, 11) => 900.0,
            (12, _) => 0.0,
            (row, column) => 0.1 + (row as f64 * 0.37 + column as f64 * 0.11) % 1.0,
        };
        move |cell| [0, 1].map(|down| [0, 1].map(|across| luminance(cell.row + down, cell.column + across)))
    }

    fn even(count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| {
            direction((i as f64 * 0.618_033_988_749_895) % 1.0, 1.0 - (2.0 * i as f64 + 1.0) / count as f64)
        })
    }

    #[test]
    fn the_nearest_normal_is_near() {
        let near = even(100_000).filter(|n| libm::acos(n.dot(normal_of(nearest(*n)))) < NEAR).count();
        assert!((80_000..100_000).contains(&near), "{near}");
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert_eq!((normal_of(nearest(axis)), normal_of(nearest(-axis))), (axis, -axis));
        }
    }

    #[test]
    fn whatever_shines_has_a_density() {
        for (columns, rows) in [(2, 2), (7, 5), (64, 33), (200, 70)] {
            let directions = Directions::new(columns, rows, |_| [[1.0; 2]; 2]);
            for (n, w) in even(50).flat_map(|n| even(100).map(move |w| (n, w))) {
                let turn = 0.5 * INV_PI * libm::atan2(w.x, -w.z);
                let place = directions.place(turn.rem_euclid(1.0), INV_PI * libm::acos(w.y), w.y);
                let pdf = directions.pdf(n, &place, [[1.0; 2]; 2]);
                assert!(pdf > 0.0 && pdf < 1.0, "{columns} {n} {w} {pdf}");
            }
        }
    }

    #[test]
    fn cells_are_chosen_as_often_as_their_density_says() {
        const SIDE: usize = 256;
        let (columns, rows) = (37, 21);
        let directions = Directions::new(columns, rows, corners(columns));
        for n in even(5).chain([DVec3::ZERO]) {
            let mut found = vec![0.0; columns * rows];
            let mut expected = vec![0.0; columns * rows];
            for i in 0..SIDE * SIDE {
                let u = DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) / SIDE as f64;
                let place = directions.sample(n, u, corners(columns)).expect("there is light");
                found[place.cell.row * columns + place.cell.column] += 1.0 / (SIDE * SIDE) as f64;
            }
            for (i, expected) in expected.iter_mut().enumerate() {
                let cell = Cell { column: i % columns, row: i / columns };
                // Bilinear in solid angle: the middle is the mean.
                let middle = Place { cell, across: 0.5, down: 0.5 };
                let solid_angle = 2.0 * PI / columns as f64 * directions.strips[cell.row].0;
                *expected = directions.pdf(n, &middle, corners(columns)(cell)) * solid_angle;
            }
            assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // A grid of numbers meets each cell as often as it should, but for its rim.
            let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 0.8 / SIDE as f64, "{worst}");
        }
    }

    #[test]
    fn rounding_never_leads_to_where_nothing_shines() {
        let sums = [0.0, 0.1, 0.1, 0.4, 0.4];
        assert_eq!(pick(&sums, 0.0).map(|found| found.0), Some(1));
        assert_eq!(pick(&sums, 1.0 - f64::EPSILON / 2.0).map(|found| found.0), Some(3));
        assert_eq!(pick(&[0.0, 0.0], 0.5), None);
    }
}
