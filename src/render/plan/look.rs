//! A look: a few cells of an image are rendered to measure their noise and their cost.

use super::{pilot_camera, scattered};
use crate::integrator::Counters;
use crate::integrator::path::reuse::{CELL, cell};
use crate::scene::Scene;
use rayon::prelude::*;

/// Fixed cost of sharing per path, in path rays.
const SHARING: f64 = 1.8;
/// Cost of sharing a source per receiver, in path rays, be it of a camera path or of a light path.
const HANDING_ON: f64 = 0.035;

/// Cost of a shadow ray between receiver and source, in path rays (which include shading).
const VISIBILITY: f64 = 0.5;

/// Cost of a light path of a group besides its rays, in path rays: scattering, weights, and connections.
const LIGHT_PATH: f64 = 12.0;

/// Cost of evaluating the BSDFs of a receiver and a source, one of them rough, in path rays.
const EVALUATION: f64 = 0.25;

/// Samples of each pixel of a cell.
const CAMERA_SAMPLES: u64 = 32;

/// The fewest cells of a look, unless the film has fewer, and the most. Between these it takes as many paths
/// as one sample of every pixel of the film.
pub const CELLS: [u64; 2] = [24, 64];

/// The fewest and the most cells of a glance, a shorter look.
pub const GLANCE: [u64; 2] = [8, 8];

/// Samples of a block, of which the sums are compared: noise that stratification removes must not count.
const BLOCK: u64 = 8;

/// Noise and cost of camera paths, without light paths for caustics.
pub struct Look {
    pub cells: Vec<Cell>,
    /// Cost of a path, in rays.
    pub cost: f64,
}

/// The noise of some pixels side by side. Green stands for all colours.
#[derive(Clone, Copy, Default)]
pub struct Cell {
    pub corner: (u32, u32),
    /// Mean value of a pixel.
    pub light: f64,
    /// Variance of a pixel with one sample, relative to the square of the pixel's own light, averaged over
    /// the cell, as far as stratification leaves it. Where the edge of a lamp is seen, light elsewhere in the
    /// cell is no measure.
    pub variance: f64,
}

impl Look {
    /// Renders cells that lie all over the film, so many at least and at most, with the scene's settings as
    /// they are.
    pub fn at(scene: &Scene, [fewest, most]: [u64; 2]) -> Self {
        let camera = pilot_camera(scene);
        let film = scene.sensor.film.crop;
        let (columns, rows) = (film.width.div_ceil(CELL), film.height.div_ceil(CELL));
        let all = u64::from(columns) * u64::from(rows);
        let looked_at = all.min((all / CAMERA_SAMPLES).clamp(fewest, most));
        let channels = camera.channel_names().len();
        let path = scene.integrator.path();
        let [pixels, light_paths] =
            path.map_or([1, 0], |path| [path.reuse, path.shared_light_paths]).map(f64::from);
        let of_cell = |i: u64| {
            let mut counters = Counters::default();
            let at = if all > looked_at { scattered(i, all) } else { i } as u32;
            let corner = (film.x + at % columns * CELL, film.y + at / columns * CELL);
            // Per pixel: the sum, the sum of squares of blocks, the current block.
            let mut sums = vec![[0.0; 3]; (CELL * CELL) as usize];
            // The film may end within the cell.
            let mut on_film = 0;
            for block in 0..CAMERA_SAMPLES / BLOCK {
                let pixels = |sample| cell(corner, sample, scene.sensor.film.size);
                let which: Vec<_> = (block * BLOCK..(block + 1) * BLOCK).flat_map(pixels).collect();
                on_film = which.len() / BLOCK as usize;
                let mut values = vec![0.0; channels * which.len()];
                camera.samples(&which, &mut counters, &mut values);
                for (((x, y), _), values) in which.into_iter().zip(values.chunks(channels)) {
                    sums[(y % CELL * CELL + x % CELL) as usize][2] += values[1];
                }
                for [sum, squares, of_block] in &mut sums {
                    (*sum, *squares) = (*sum + *of_block, *squares + *of_block * *of_block);
                    *of_block = 0.0;
                }
            }
            const BLOCKS: f64 = (CAMERA_SAMPLES / BLOCK) as f64;
            let relative = |[sum, squares, _]: &[f64; 3]| {
                if *sum > 0.0 { (squares / (sum * sum) - 1.0 / BLOCKS).max(0.0) } else { 0.0 }
            };
            let pixels_of_cell = on_film as f64;
            let samples = pixels_of_cell * CAMERA_SAMPLES as f64;
            let light: f64 = sums.iter().map(|sum| sum[0]).sum();
            let relative: f64 = sums.iter().map(relative).sum();
            let cost = counters.rays as f64 - (1.0 - VISIBILITY) * counters.shared as f64
                + EVALUATION * counters.evaluations as f64
                + HANDING_ON * pixels * counters.light_sources as f64;
            // The relative variance of a pixel's sum, from the scatter of its blocks, times its number of
            // samples is that of one sample.
            let variance = relative / pixels_of_cell * BLOCKS / (BLOCKS - 1.0) * CAMERA_SAMPLES as f64;
            (Cell { corner, light: light / samples, variance }, cost / samples)
        };
        let (cells, rays): (Vec<Cell>, Vec<f64>) = (0..looked_at).into_par_iter().map(of_cell).unzip();
        let sharing = if pixels > 1.0 {
            SHARING + HANDING_ON * pixels + LIGHT_PATH * light_paths / pixels
        } else {
            0.0
        };
        Self { cells, cost: rays.iter().sum::<f64>() / rays.len() as f64 + sharing }
    }
}
