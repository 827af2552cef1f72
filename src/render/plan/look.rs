//! A look: a few cells of an image are rendered to measure their noise and their cost. It can go on to more
//! cells, in an order that all looks at a film share, so that two of them compare the same cells.

use super::super::spread::neighbours;
use super::cells::Cells;
use super::{SampleMaker, brightness, pilot_maker};
use crate::film::Film;
use crate::film::filter_weights::{Place, Weights};
use crate::integrator::Counters;
use crate::integrator::path::reuse::{CELL, cell};
use crate::math::function::ln;
use crate::sampler::SampleId;
use crate::scene::Scene;
use rayon::prelude::*;
use std::array::from_fn;
use std::f64::consts::LN_2;

// Costs are in rays of a path, which include shading, through a tree that a near cache holds. They were fitted to
// the times of 18 scenes with 1, 4, 16 and 64 pixels that share (docs/notebook.md, "Rooms by others"), whose ratios they
// foretell with an error of 0.14 in the logarithm.

/// Fixed cost of a path.
const PATH: f64 = 2.0;

/// Fixed cost of sharing, for each path.
const SHARING: f64 = 3.5;

/// Cost of a source, be it of a camera path or of a light path, for each receiver.
const HANDING_ON: f64 = 0.05;

/// Cost of a light path of a group besides its rays: scattering, weights, and connections.
const LIGHT_PATH: f64 = 12.0;

/// Cost of a shadow ray between receiver and source.
const VISIBILITY: f64 = 0.7;

/// Number of primitives beyond which rays wait for memory.
const CACHED: f64 = 8192.0;

/// Samples of each pixel of a cell.
const CAMERA_SAMPLES: u64 = 32;

/// Fewest and most cells that [`Look::at`] visits, unless the film has fewer. In between: as many as make, all
/// together, one sample of every pixel of the film.
const CELLS_OF_ONE_LOOK: [u64; 2] = [24, 64];

/// Samples of a block, of which the sums are compared: noise that stratification removes must not count.
const LOOK_BLOCK: u64 = 8;

/// Light below this share of the image's is dark: noise there is relative to that share.
const DARK: f64 = 0.01;

/// Noise and cost of camera paths, without light paths for caustics unless these are added.
#[derive(Clone)]
pub struct Look {
    pub cells: Vec<Cell>,
    /// Cost of a path, in rays of it.
    pub cost: f64,
}

/// The noise of some pixels side by side: a cell of those that can share, which may reach beyond a crop.
#[derive(Clone, Copy, Default)]
pub struct Cell {
    pub corner: (u32, u32),
    /// Mean value of a pixel.
    pub light: f64,
    /// Variance of a pixel with one sample, relative to the square of the pixel's own light, averaged over
    /// the cell, as far as stratification leaves it. Where the edge of a lamp is seen, light elsewhere in the
    /// cell is no measure.
    pub variance: f64,
    /// The weight of the cell in means over the film; all of a look's together make one.
    pub weight: f64,
}

/// What has been seen of the cells of a film, in the order of [`Cells`].
#[derive(Default)]
pub struct Measurements {
    seen: Vec<CellMeasurement>,
    /// The weight of each in means over the film.
    weights: Vec<f64>,
}

/// What was seen of a cell.
struct CellMeasurement {
    corner: (u32, u32),
    /// Mean and variance of one sample of each pixel.
    pixels: Vec<(f64, f64)>,
    /// Cost of a path, in rays of it.
    cost: f64,
}

impl Measurements {
    /// Looks on, until the first `count` cells have been seen, which begin with those that have been. The scene
    /// has the settings that it had before.
    pub fn extend(&mut self, scene: &Scene, cells: &Cells, count: usize) {
        let maker = pilot_maker(scene);
        let corners: Vec<_> = cells.corners(count).skip(self.seen.len()).collect();
        let more = corners.par_iter().map(|corner| CellMeasurement::at(scene, &maker, *corner));
        self.seen.par_extend(more);
        self.weights = cells.weights(count).collect();
    }

    pub fn look(&self) -> Look {
        let seen = || self.seen.iter().zip(&self.weights);
        let light: f64 = seen().map(|(seen, weight)| weight * seen.light()).sum();
        Look {
            cells: seen().map(|(seen, weight)| seen.cell(DARK * light, *weight)).collect(),
            cost: seen().map(|(seen, weight)| weight * seen.cost).sum(),
        }
    }
}

impl Look {
    /// A look that does not go on, with the scene's settings as they are.
    pub fn at(scene: &Scene, cells: &Cells) -> Self {
        let [fewest, most] = CELLS_OF_ONE_LOOK;
        let one_of_each_pixel =
            scene.sensor.film.crop.pixels() as u64 / (u64::from(CELL * CELL) * CAMERA_SAMPLES);
        let mut sight = Measurements::default();
        sight.extend(scene, cells, one_of_each_pixel.clamp(fewest, most) as usize);
        sight.look()
    }

    /// The mean deviation of a pixel with one sample.
    pub fn deviation(&self) -> f64 {
        self.cells.iter().map(|cell| cell.weight * cell.variance.sqrt()).sum()
    }

    /// The product of variance and cost, up to a factor that all looks have.
    pub fn product(&self) -> f64 {
        let deviation = self.deviation();
        deviation * deviation * self.cost
    }
}

impl CellMeasurement {
    fn at(scene: &Scene, maker: &SampleMaker, corner: (u32, u32)) -> Self {
        const BLOCKS: u64 = CAMERA_SAMPLES / LOOK_BLOCK;
        let film = &scene.sensor.film;
        let channels = maker.channels();
        let pixels = |sample| cell(corner, sample, film.size);
        let of_block = |block: u64| {
            let which: Vec<_> = (block * LOOK_BLOCK..(block + 1) * LOOK_BLOCK).flat_map(pixels).collect();
            let of_sample = which.len() / LOOK_BLOCK as usize;
            let mut values = vec![0.0; channels * which.len()];
            let mut counters = Counters::default();
            maker.samples(&which, &mut counters, &mut values);
            let mut sum = Square::default();
            for (which, values) in which.chunks(of_sample).zip(values.chunks(channels * of_sample)) {
                let square =
                    spread(film, maker.place_in_pixels(which[0].sample), corner, square(which, values));
                sum.as_flattened_mut().iter_mut().zip(square.as_flattened()).for_each(|(a, b)| *a += b);
            }
            (sum, cost(scene, &counters, which.len() as f64))
        };
        let blocks: Vec<_> = (0..BLOCKS).into_par_iter().map(of_block).collect();
        let of_pixel = |SampleId { pixel: (x, y), .. }| {
            moments(blocks.iter().map(|(block, _)| block[(y % CELL) as usize][(x % CELL) as usize]))
        };
        let pixels: Vec<_> = pixels(0).map(of_pixel).collect();
        let cost = blocks.iter().map(|(_, cost)| cost).sum::<f64>() / BLOCKS as f64;
        Self { corner, pixels, cost }
    }

    fn light(&self) -> f64 {
        self.pixels.iter().map(|(mean, _)| mean).sum::<f64>() / self.pixels.len() as f64
    }

    fn cell(&self, dark: f64, weight: f64) -> Cell {
        let relative = |(mean, variance): &(f64, f64)| {
            let square = mean * mean + dark * dark;
            if square > 0.0 { variance / square } else { 0.0 }
        };
        let variance = self.pixels.iter().map(relative).sum::<f64>() / self.pixels.len() as f64;
        Cell { corner: self.corner, light: self.light(), variance, weight }
    }
}

/// Mean and variance of one sample, from the sums over blocks of [`LOOK_BLOCK`]: the variance of all samples' sum, from
/// the scatter of the blocks, over their number is that of one.
fn moments(blocks: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for block in blocks {
        (count, sum, squares) = (count + 1.0, sum + block, squares + block * block);
    }
    let scatter = (squares - sum * sum / count).max(0.0) * count / (count - 1.0);
    let samples = count * LOOK_BLOCK as f64;
    (sum / samples, scatter / samples)
}

/// Cost of a path, in rays of it, of what so many paths have counted.
fn cost(scene: &Scene, counters: &Counters, paths: f64) -> f64 {
    let path = scene.integrator.path();
    let [pixels, light_paths] =
        path.map_or([1, 0], |path| [path.reuse, path.shared_light_paths]).map(f64::from);
    let [rays, shared, sources] =
        [counters.rays, counters.shared, counters.light_sources].map(|n| n as f64 / paths);
    let handed_on = HANDING_ON * pixels * (1.0 + sources);
    let sharing = if pixels > 1.0 { SHARING + handed_on + LIGHT_PATH * light_paths / pixels } else { 0.0 };
    // Each doubling of a tree beyond the cache costs about as much as a ray within it.
    let slowness = 1.0 + (ln(f64::from(scene.accel.primitives()) / CACHED) / LN_2).max(0.0);
    rays - (1.0 - VISIBILITY) * shared + (PATH + sharing) / slowness
}

/// One sample of the pixels of a cell, row by row.
type Square = [[f64; CELL as usize]; CELL as usize];

/// Brightness of these samples of a cell's pixels.
fn square(which: &[SampleId], values: &[f64]) -> Square {
    let mut square = Square::default();
    for (SampleId { pixel: (x, y), .. }, values) in
        which.iter().zip(values.chunks(values.len() / which.len()))
    {
        square[(y % CELL) as usize][(x % CELL) as usize] = brightness(values);
    }
    square
}

/// What pixels have of the samples around them, if these count for several. Beyond an edge of the cell come
/// those of its other side, which stand for neighbours that are not looked at.
fn spread(film: &Film, place: Option<[Place; 2]>, corner: (u32, u32), seen: Square) -> Square {
    let Some((spread, places)) = film.spread.as_ref().zip(place) else { return seen };
    let weights = |place| Some(spread.at(place, &film.filter, (u32::MAX, u32::MAX)));
    let [columns, rows] = places.map(weights);
    let sum = |weights: &Option<Weights>, size: u32, at: usize, value: &dyn Fn(usize) -> f64| -> f64 {
        let (size, reach) = (size.min(CELL), spread.reach());
        let around = neighbours(at as u32 + reach * size, weights, reach);
        around.map(|(from, weight)| weight * value(from % size as usize)).sum()
    };
    let (width, height) = (film.size.0 - corner.0, film.size.1 - corner.1);
    let along: Square = from_fn(|y| from_fn(|x| sum(&columns, width, x, &|x| seen[y][x])));
    from_fn(|y| from_fn(|x| sum(&rows, height, y, &|y| along[y][x])))
}

#[cfg(test)]
mod tests {
    use super::super::cells::first_of;
    use super::*;
    use crate::film::Window;
    use crate::load_text;
    use crate::render::spread::Spread;
    use crate::spectrum::ColorMode;

    const ROOM: &str = r#"<scene version="3.0.0"><integrator type="path"/>
        <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="60"/><integer name="height" value="44"/><rfilter type="tent"/></film></sensor>
        <shape type="cube"><transform name="to_world"><scale value="4"/></transform><boolean name="flip_normals" value="true"/></shape>
        <shape type="sphere"><point name="center" x="0" y="3" z="-3.4"/><float name="radius" value="0.4"/><emitter type="area"/></shape></scene>"#;

    /// Where no neighbours are missing.
    #[test]
    fn samples_count_for_several_pixels_as_in_an_image() {
        let mut scene = load_text("room.xml", ROOM, ColorMode::Rgb).expect("it loads");
        let film = &mut scene.sensor.film;
        film.spread = film.spreadable();
        let maker = pilot_maker(&scene);
        let channels = maker.channels();
        for sample in 0..4 {
            let which: Vec<_> = cell((8, 8), sample, scene.sensor.film.size).collect();
            let mut values = vec![0.0; channels * which.len()];
            maker.samples(&which, &mut Counters::default(), &mut values);
            let place = maker.place_in_pixels(sample);
            let square = spread(&scene.sensor.film, place, (8, 8), square(&which, &values));
            for (x, y) in [(9, 9), (11, 12), (14, 9)] {
                let window = Window { x, y, width: 1, height: 1 };
                let value = Spread::new(&maker, window, channels).one(sample)[1];
                let seen = square[(y % CELL) as usize][(x % CELL) as usize];
                assert!((seen - value).abs() < 1e-12 * value && value > 0.0, "{seen} {value}");
            }
        }
    }

    #[test]
    fn one_sample_is_told_by_the_sums_of_blocks() {
        // Blocks of eight samples: their mean 16, their variance (16 + 0 + 16)/2, of one sample an eighth of each.
        assert_eq!(moments([12.0, 16.0, 20.0].into_iter()), (2.0, 2.0));
        assert_eq!(moments([3.0; 4].into_iter()), (0.375, 0.0));
    }

    /// Of independent samples, for whose blocks nothing is stratified. The scatter of four blocks of 768 pixels is
    /// heavy-tailed, so that the sum is only roughly that of 256 samples.
    #[test]
    fn variances_are_of_one_sample() {
        let text = ROOM.replace("<film", r#"<sampler type="independent"/><film"#);
        let scene = load_text("room.xml", &text, ColorMode::Rgb).expect("it loads");
        let maker = pilot_maker(&scene);
        let channels = maker.channels();
        let variance = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (values.len() - 1) as f64
        };
        let of_pixel = |SampleId { pixel, .. }| {
            let which: Vec<_> = (1000..1256).map(|sample| SampleId { pixel, sample }).collect();
            let mut values = vec![0.0; channels * which.len()];
            maker.samples(&which, &mut Counters::default(), &mut values);
            variance(&values.chunks(channels).map(brightness).collect::<Vec<_>>())
        };
        // Of one cell alone the scatter of four blocks says too little.
        let corners = || [8, 16, 24, 32].into_iter().flat_map(|x| [8, 16, 24].map(|y| (x, y)));
        let size = scene.sensor.film.size;
        let expected: f64 = corners().flat_map(|corner| cell(corner, 0, size)).map(of_pixel).sum();
        let seen = corners().flat_map(|corner| CellMeasurement::at(&scene, &maker, corner).pixels);
        let found: f64 = seen.map(|(_, variance)| variance).sum();
        assert!((found / expected - 1.0).abs() < 0.5 && expected > 0.0, "{found} {expected}");
    }

    #[test]
    fn cells_of_a_crop_are_those_that_its_pixels_share_with() {
        let mut scene = load_text("room.xml", ROOM, ColorMode::Rgb).expect("it loads");
        let crop = Window { x: 5, y: 9, width: 7, height: 18 };
        scene.sensor.film.crop = crop;
        let look = Look::at(&scene, &Cells::of(crop, |_| false));
        let mut corners: Vec<_> = look.cells.iter().map(|cell| cell.corner).collect();
        corners.sort_unstable();
        assert_eq!(corners, [(0, 8), (0, 16), (0, 24), (8, 8), (8, 16), (8, 24)]);
        assert_eq!([first_of((0, 8), crop), first_of((8, 16), crop)], [(5, 9), (8, 16)]);
    }

    #[test]
    fn a_look_that_goes_on_is_the_look_at_all_its_cells() {
        let scene = load_text("room.xml", ROOM, ColorMode::Rgb).expect("it loads");
        let cells = Cells::of(scene.sensor.film.crop, |(x, _)| x < 8);
        let looked = |stages: &[usize]| {
            let mut sight = Measurements::default();
            stages.iter().for_each(|count| sight.extend(&scene, &cells, *count));
            let look = sight.look();
            (look.product(), look.cost, look.cells.len())
        };
        assert_eq!(looked(&[3, 3, 9]), looked(&[9]));
    }

    #[test]
    fn noise_in_the_dark_is_relative_to_the_light_of_the_image() {
        let seen =
            CellMeasurement { corner: (0, 0), pixels: vec![(1.0, 4.0), (0.0, 0.0), (1e-3, 1e-4)], cost: 0.0 };
        let variance = |dark| seen.cell(dark, 1.0).variance;
        assert!((variance(0.0) - (4.0 + 100.0) / 3.0).abs() < 1e-12);
        assert!((variance(0.01) - (4.0 + 1e-4 / 1.01e-4) / 3.0).abs() < 1e-3);
    }
}
