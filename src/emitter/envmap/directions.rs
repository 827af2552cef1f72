//! Sampling of directions towards an image of the environment, by its importance there and by how much a
//! surface faces it.
//!
//! A surface of normal n gathers L(ω) cos θ. First a *block* of cells is chosen, by its importance and the
//! cosine of its middle with the nearest of some normals all over the sphere, smoothed so that it is
//! positive, for other directions of the block may be above the horizon of other normals. Blocks are few, so
//! their probabilities are tabulated for each of the normals. Then a cell of the block is chosen by its
//! importance alone, which is tabulated once, and last a place in it, by the importance I that is bilinear
//! between texel centres, in the turn and the height (the cosine of the polar angle). In *even* blocks, where
//! I hardly varies within cells, a place is as likely as any other of its cell, so that nobody waits for the
//! texels, which are far away in memory, before it is known whether light arrives.
//!
//! With the mean importance Ī of the cell, its height h, and W cells around the equator, p(ω) = P(block, n)
//! P(cell) I(ω)/Ī · W/(2π h), where I(ω)/Ī is taken for one in even blocks.

use super::normals::{ANYWHERE, NEAR, nearest, normal_of};
use super::steps::{self, deal, pick};
use crate::math::function::{cos, hypot, sin, sin_cos_turn};
use crate::math::simd::prefetch;
use crate::math::{DVec2, DVec3, INV_PI, warp};
use std::f64::consts::{FRAC_PI_2, PI};

/// Numbers of blocks along the turn and the height: so few that their tables stay in a near cache.
const BLOCKS: [usize; 2] = [32, 16];

/// The mean of the relative variance of the importance within cells, up to which a block is even. It is what
/// the squares of samples from there grow by.
const EVEN: f64 = 0.05;

/// A place of the map: within a cell, between the texel centres at its corners.
#[derive(Clone, Copy, Debug)]
pub struct MapPlace {
    /// Column of the texels to the left, and row of those above.
    pub cell: Cell,
    /// Distance from the left edge, as a fraction of the cell's width.
    pub across: f64,
    /// Distance from the upper edge, as a fraction of the cell's height in the cosine.
    pub down: f64,
}

/// A cell of the image: the square between four texels' centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    pub column: usize,
    pub row: usize,
}

/// How important the corners of a cell are: of the row above, left and right, and of the row below.
pub type Corners = [[f64; 2]; 2];

/// For one row of blocks, where the [`steps`] of each block begin: as long as a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct RowOfBlocks([u16; BLOCKS[0]]);

#[derive(Debug)]
pub struct Directions {
    columns: usize,
    /// Height of each row of cells and its upper edge, as cosines of the polar angle.
    strips: Vec<(f64, f64)>,
    /// Cells along a block's sides, as powers of two.
    shift: [u32; 2],
    /// Table by which a row of blocks is chosen, for each normal and for none.
    rows: Vec<[u16; BLOCKS[1]]>,
    /// Tables by which a block of a row is chosen, row by row, for each normal and for none.
    blocks: Vec<RowOfBlocks>,
    /// For each block, the table by which a row of its cells is chosen, then those by which a cell of a row
    /// is.
    insides: Vec<u16>,
    /// Whether each block is even.
    even: Vec<bool>,
}

/// The tables by which cells of a block are chosen.
struct Inside<'a> {
    rows: &'a [u16],
    /// Tables of the cells, row by row.
    cells: &'a [u16],
    width: usize,
}

impl Inside<'_> {
    #[inline]
    fn cells(&self, row: usize) -> &[u16] {
        &self.cells[row * self.width..][..self.width]
    }
}

impl Directions {
    /// From the corners of each of `columns` × `rows` cells.
    pub fn new(columns: usize, rows: usize, corners: impl Fn(Cell) -> Corners) -> Self {
        let strips: Vec<(f64, f64)> = (0..rows).map(|row| strip(row, rows)).collect();
        let shift = [(columns, BLOCKS[0]), (rows, BLOCKS[1])]
            .map(|(cells, blocks)| cells.div_ceil(blocks).next_power_of_two().trailing_zeros());
        let side = shift.map(|shift| 1 << shift);
        let (mut insides, mut even, mut middles, mut importances) = (vec![], vec![], vec![], vec![]);
        for (row, column) in (0..BLOCKS[1]).flat_map(|row| (0..BLOCKS[0]).map(move |column| (row, column))) {
            let first = Cell { column: column * side[0], row: row * side[1] };
            let mut varying = 0.0;
            let mut important = |row: usize, column: usize| {
                let cell = Cell { column: first.column + column, row: first.row + row };
                if cell.column >= columns || cell.row >= rows {
                    return 0.0;
                }
                let (corners, height) = (corners(cell), strips[cell.row].0);
                let important = mean(corners) * height;
                varying += important * relative_variance(corners);
                important
            };
            let cells: Vec<f64> =
                (0..side[1] * side[0]).map(|i| important(i / side[0], i % side[0])).collect();
            let rows_of_cells: Vec<f64> = cells.chunks(side[0]).map(|row| row.iter().sum()).collect();
            insides.extend(deal(&rows_of_cells));
            insides.extend(cells.chunks(side[0]).flat_map(deal));
            let importance: f64 = rows_of_cells.iter().sum();
            even.push(varying <= EVEN * importance);
            importances.push(importance);
            let end = [columns.min(first.column + side[0]), rows.min(first.row + side[1])];
            let turn = (0.5 * (first.column + end[0]) as f64 + 0.5) / columns as f64;
            let height = cos(0.5 * PI * (first.row + end[1]) as f64 / rows as f64);
            middles.push(direction(turn, height));
        }
        let angle =
            [side[0] as f64 / columns as f64, 0.5 * side[1] as f64 / rows as f64].map(|part| PI * part);
        let blur = 0.25 * sin((NEAR + hypot(angle[0], angle[1])).min(FRAC_PI_2));
        let mut directions = Self { columns, strips, shift, rows: vec![], blocks: vec![], insides, even };
        let normals = (0..ANYWHERE).map(|number| Some(normal_of(number)));
        normals.chain([None]).for_each(|n| {
            directions
                .add_choice(&importances, &middles, |middle| n.map_or(1.0, |n| facing(n.dot(middle), blur)))
        });
        directions
    }

    /// Tabulates how blocks are chosen, by their importance and how much they face something.
    fn add_choice(&mut self, importances: &[f64], middles: &[DVec3], facing: impl Fn(DVec3) -> f64) {
        let weights: Vec<f64> = importances
            .iter()
            .zip(middles)
            .map(|(importance, middle)| importance * facing(*middle))
            .collect();
        let rows: Vec<f64> = weights.chunks(BLOCKS[0]).map(|row| row.iter().sum()).collect();
        self.rows.push(array(deal(&rows)));
        self.blocks.extend(weights.chunks(BLOCKS[0]).map(|row| RowOfBlocks(array(deal(row)))));
    }

    /// Samples a place that may light a surface of normal n (any surface, if n is zero); returns it with its
    /// density in sr⁻¹. `None` if there is no light.
    #[inline]
    pub fn sample(&self, n: DVec3, u: DVec2, corners: impl Fn(Cell) -> Corners) -> Option<(MapPlace, f64)> {
        let normal = nearest(n);
        let block_row = pick(&self.rows[normal], u.y)?;
        let block = pick(self.blocks(normal, block_row.index), u.x)?;
        let inside = self.inside([block.index, block_row.index]);
        let row = pick(inside.rows, block_row.rest)?;
        let column = pick(inside.cells(row.index), block.rest)?;
        let cell = Cell {
            column: (block.index << self.shift[0]) + column.index,
            row: (block_row.index << self.shift[1]) + row.index,
        };
        let of_block = block_row.probability * block.probability;
        let probability = of_block * (row.probability * column.probability);
        if self.even([block.index, block_row.index]) {
            let place = MapPlace { cell, across: column.rest, down: row.rest };
            return Some((place, self.even_density(probability, cell)));
        }
        let corners = corners(cell);
        let [above, below] = corners;
        let across = warp::linear(column.rest, above[0] + below[0], above[1] + below[1]);
        let down = warp::linear(row.rest, lerp(above, across), lerp(below, across));
        let place = MapPlace { cell, across, down };
        Some((place, self.density(probability, &place, corners)))
    }

    /// The density of a place for normal n, in sr⁻¹: to the bit what [`Directions::sample`] says.
    #[inline]
    pub fn pdf(&self, n: DVec3, place: &MapPlace, corners: impl Fn(Cell) -> Corners) -> f64 {
        let normal = nearest(n);
        let ([block, block_row], [column, row]) = self.within_block(place.cell);
        let of_block = steps::probability(&self.rows[normal], block_row)
            * steps::probability(self.blocks(normal, block_row), block);
        let inside = self.inside([block, block_row]);
        let of_cell = steps::probability(inside.rows, row) * steps::probability(inside.cells(row), column);
        if self.even([block, block_row]) {
            return self.even_density(of_block * of_cell, place.cell);
        }
        self.density(of_block * of_cell, place, corners(place.cell))
    }

    /// The block of a cell, and the cell's column and row within it.
    #[inline]
    fn within_block(&self, cell: Cell) -> ([usize; 2], [usize; 2]) {
        let [block, row] = [cell.column >> self.shift[0], cell.row >> self.shift[1]];
        ([block, row], [cell.column - (block << self.shift[0]), cell.row - (row << self.shift[1])])
    }

    /// Whether all places of a cell of the block are equally likely.
    #[inline]
    fn even(&self, [block, row]: [usize; 2]) -> bool {
        self.even[row * BLOCKS[0] + block]
    }

    /// Prefetches what [`Directions::pdf`] looks at, but for tables that always are near.
    #[inline]
    pub fn prefetch(&self, cell: Cell) {
        let (block, [column, row]) = self.within_block(cell);
        let inside = self.inside(block);
        prefetch(inside.rows, row);
        prefetch(inside.cells(row), column);
    }

    /// The table by which a block of a row of blocks is chosen for a normal.
    #[inline]
    fn blocks(&self, normal: usize, row: usize) -> &[u16] {
        &self.blocks[normal * BLOCKS[1] + row].0
    }

    #[inline]
    fn inside(&self, [block, row]: [usize; 2]) -> Inside<'_> {
        let [width, height] = self.shift.map(|shift| 1 << shift);
        let size = height + width * height;
        let (rows, cells) = self.insides[(row * BLOCKS[0] + block) * size..][..size].split_at(height);
        Inside { rows, cells, width }
    }

    /// The density, in sr⁻¹, of a place in a cell of this probability.
    #[inline]
    fn density(&self, probability: f64, place: &MapPlace, corners: Corners) -> f64 {
        let [above, below] = corners;
        let importance = lerp([lerp(above, place.across), lerp(below, place.across)], place.down);
        let even = self.even_density(probability, place.cell);
        if probability > 0.0 { even * (importance / mean(corners)) } else { 0.0 }
    }

    /// The same if all places of the cell are equally likely.
    #[inline]
    fn even_density(&self, probability: f64, cell: Cell) -> f64 {
        probability * (0.5 * INV_PI * self.columns as f64) / self.strips[cell.row].0
    }

    /// The turn of a place about +y, and the cosine of its polar angle.
    #[inline]
    pub fn turn_and_height(&self, place: &MapPlace) -> (f64, f64) {
        let turn = (place.cell.column as f64 + 0.5 + place.across) / self.columns as f64;
        let (height, top) = self.strips[place.cell.row];
        (if turn < 1.0 { turn } else { turn - 1.0 }, top - place.down * height)
    }

    /// The place at a turn in [0, 1], a polar angle in half turns, and the cosine of that angle.
    #[inline]
    pub fn place(&self, turn: f64, half_turns: f64, height: f64) -> MapPlace {
        let rows = self.strips.len();
        let row = ((half_turns * rows as f64) as usize).min(rows - 1);
        let x = turn * self.columns as f64 - 0.5;
        let x = if x < 0.0 { x + self.columns as f64 } else { x };
        let column = (x as usize).min(self.columns - 1);
        let (strip, top) = self.strips[row];
        let down = ((top - height) / strip).clamp(0.0, 1.0);
        MapPlace { cell: Cell { column, row }, across: (x - column as f64).min(1.0), down }
    }
}

/// The direction at a turn about +y, of which the middle of the image is half a one, and a height.
#[inline]
pub fn direction(turn: f64, height: f64) -> DVec3 {
    let (sin, cos) = sin_cos_turn(turn);
    let r = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt();
    DVec3::new(r * sin, height, -r * cos)
}

/// How much something at cosine c is taken to face a normal: (c + √(c² + ε²))/2, close to max(c, 0) but never
/// zero.
fn facing(c: f64, blur: f64) -> f64 {
    // Below the horizon the sum would cancel.
    let large = 0.5 * (c.abs() + (c * c + blur * blur).sqrt());
    if c > 0.0 { large } else { 0.25 * blur * blur / large }
}

/// The first N numbers.
fn array<const N: usize>(mut numbers: impl Iterator<Item = u16>) -> [u16; N] {
    std::array::from_fn(|_| numbers.next().unwrap_or(u16::MAX))
}

fn mean(corners: Corners) -> f64 {
    0.25 * corners.as_flattened().iter().sum::<f64>()
}

/// The variance of what is bilinear between corners, over the square of its mean.
fn relative_variance(corners: Corners) -> f64 {
    let [[a, b], [c, d]] = corners;
    // The integral of (1 − x)² is a third, of x (1 − x) a sixth.
    let squares = a * a + b * b + c * c + d * d + a * b + c * d + a * c + b * d + 0.5 * (a * d + b * c);
    let mean = mean(corners);
    if mean > 0.0 { squares / (9.0 * mean * mean) - 1.0 } else { 0.0 }
}

fn lerp([a, b]: [f64; 2], t: f64) -> f64 {
    a + t * (b - a)
}

/// The height of a row of cells, which is 2 sin(mid) sin(half), free of cancellation, and its upper edge.
pub fn strip(row: usize, rows: usize) -> (f64, f64) {
    let step = PI / rows as f64;
    (2.0 * sin((row as f64 + 0.5) * step) * sin(0.5 * step), cos(row as f64 * step))
}

#[cfg(test)]
mod tests {
    use super::super::normals::tests::even;
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

    #[test]
    fn whatever_shines_has_a_density() {
        for (columns, rows) in [(2, 2), (7, 5), (64, 33), (200, 70)] {
            let directions = Directions::new(columns, rows, |_| [[1.0; 2]; 2]);
            for (n, w) in even(50).flat_map(|n| even(100).map(move |w| (n, w))) {
                let turn = 0.5 * INV_PI * libm::atan2(w.x, -w.z);
                let place = directions.place(turn.rem_euclid(1.0), INV_PI * libm::acos(w.y), w.y);
                let pdf = directions.pdf(n, &place, |_| [[1.0; 2]; 2]);
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
                let (place, pdf) = directions.sample(n, u, corners(columns)).expect("there is light");
                assert_eq!(pdf, directions.pdf(n, &place, corners(columns)));
                found[place.cell.row * columns + place.cell.column] += 1.0 / (SIDE * SIDE) as f64;
            }
            for (i, expected) in expected.iter_mut().enumerate() {
                let cell = Cell { column: i % columns, row: i / columns };
                // Bilinear in solid angle: the middle is the mean.
                let middle = MapPlace { cell, across: 0.5, down: 0.5 };
                let solid_angle = 2.0 * PI / columns as f64 * directions.strips[cell.row].0;
                *expected = directions.pdf(n, &middle, corners(columns)) * solid_angle;
            }
            assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            // A grid of numbers meets each cell as often as it should, but for its rim.
            let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 0.8 / SIDE as f64, "{worst}");
        }
    }
}
