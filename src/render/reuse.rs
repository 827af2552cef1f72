//! Whether pixels share what their paths find, where the scene leaves that to a pilot.
//!
//! Sharing multiplies the variance of a pixel by some v < 1 and its cost by some c > 1, and pays where c v < 1: where light has
//! met several matte surfaces. The pilot makes the same cells of pixels each way, counts the rays, and takes the geometric mean of v over
//! cells, which a rare bright path cannot sway. Its samples are thrown away and are a function of the scene alone, so the
//! choice cannot bias an image, and every part of a render makes the same.

use super::sample::Camera;
use super::scattered;
use crate::integrator::path::reuse::{AUTO, CELL, cell};
use crate::integrator::{Counters, kernel_for};
use crate::scene::{Features, Scene};

/// Numbers of pixels to choose from, and what each must make of the product of variance and cost of the one before. Correlated errors
/// are a price as well, which a smaller gain is not worth.
const CHOICES: [(u32, f64); 2] = [(16, 0.8), (64, 0.9)];

/// What handing on light from one pixel to another costs, in rays, where no ray is needed.
const HANDING_ON: f64 = 0.02;

/// Cells and samples of the pilot: about a tenth of a second.
const CELLS: u64 = 32;
const SAMPLES: u64 = 32;

/// Samples that are summed before sums are compared: what stratification does away with is no gain of sharing.
const BLOCK: u64 = 8;

/// Settles how many pixels share, by a pilot if the scene's file or a command line leaves it to that.
pub fn settle(scene: &mut Scene) {
    let mut pixels = scene.integrator.reuse();
    if pixels == AUTO {
        let mut measured = |pixels: u32| {
            set(scene, pixels);
            measure(scene, pixels)
        };
        let mut best = (1, measured(1));
        for (more, worth) in CHOICES {
            let measured = measured(more);
            if relative_error(&measured, &best.1) > worth {
                break;
            }
            best = (more, measured);
        }
        pixels = best.0;
    }
    set(scene, pixels);
}

fn set(scene: &mut Scene, pixels: u32) {
    scene.integrator.set_reuse(pixels);
    scene.features.0 &= !Features::REUSE;
    scene.features.0 |= if pixels > 1 { Features::REUSE } else { 0 };
}

/// What the pilot saw: the variance of each cell, and the cost in rays.
struct Measured {
    variances: Vec<f64>,
    cost: f64,
}

/// The product of variance and cost, over the same of the other.
fn relative_error(ours: &Measured, other: &Measured) -> f64 {
    let ratios = ours.variances.iter().zip(&other.variances).map(|(a, b)| a / b);
    let logarithms: Vec<f64> = ratios.map(libm::log).filter(|ratio| ratio.is_finite()).collect();
    if logarithms.is_empty() {
        return f64::INFINITY;
    }
    let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
    libm::exp(mean) * ours.cost / other.cost
}

fn measure(scene: &Scene, pixels: u32) -> Measured {
    let camera = Camera::new(scene, 0, kernel_for(scene.features));
    let film = scene.sensor.film.crop;
    let (columns, rows) = (film.width.div_ceil(CELL), film.height.div_ceil(CELL));
    let channels = camera.channel_names().len();
    let mut counters = Counters::default();
    let variance = |i: u64| {
        let at = scattered(i, u64::from(columns * rows)) as u32;
        let corner = (film.x + at % columns * CELL, film.y + at / columns * CELL);
        // Green stands for all colours. Of every pixel: the sum, the sum of squares of blocks, the block at hand.
        let mut sums = vec![[0.0; 3]; (CELL * CELL) as usize];
        for sample in 0..SAMPLES {
            let which: Vec<_> = cell(corner, sample, scene.sensor.film.size).collect();
            let mut values = vec![0.0; channels * which.len()];
            camera.samples(&which, &mut counters, &mut values);
            for (((x, y), _), values) in which.into_iter().zip(values.chunks(channels)) {
                let sum = &mut sums[(y % CELL * CELL + x % CELL) as usize];
                sum[0] += values[1];
                sum[2] += values[1];
                if sample % BLOCK == BLOCK - 1 {
                    sum[1] += sum[2] * sum[2];
                    sum[2] = 0.0;
                }
            }
        }
        let scatter = |[sum, squares, _]: &[f64; 3]| squares - sum * sum / (SAMPLES / BLOCK) as f64;
        sums.iter().map(|sum| scatter(sum).max(0.0)).sum()
    };
    let variances = (0..CELLS).map(variance).collect();
    let paths = CELLS * SAMPLES * u64::from(CELL * CELL);
    let handed_on = if pixels > 1 { paths * u64::from(pixels) } else { 0 };
    Measured { variances, cost: counters.rays as f64 + HANDING_ON * handed_on as f64 }
}

#[cfg(test)]
mod tests {
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    /// Pixels that share in a closed box or an open one, lit from within.
    fn chosen(sides: &str, wears: &str, reuse: &str) -> u32 {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="8"/>{reuse}</integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film></sensor>
                <shape type="{sides}"><transform name="to_world"><scale value="4"/></transform><boolean name="flip_normals" value="true"/>{wears}</shape>
                <shape type="sphere"><point name="center" x="2" y="3" z="0"/><float name="radius" value="0.7"/>
                    <emitter type="area"/></shape></scene>"#
        );
        let scene = load_text("box.xml", &text, ColorMode::Rgb).expect("it loads");
        scene.integrator.reuse()
    }

    #[test]
    fn pixels_share_where_light_has_met_several_walls() {
        let bright = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf>"#;
        let metal = r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>"#;
        let asked = r#"<integer name="reuse" value="0"/>"#;
        assert_eq!(chosen("cube", bright, asked), 64);
        assert_eq!(chosen("cube", metal, asked), 1);
        assert_eq!(chosen("rectangle", bright, asked), 1);
        assert_eq!(chosen("cube", bright, ""), 1);
        assert_eq!(chosen("cube", metal, r#"<integer name="reuse" value="4"/>"#), 4);
    }
}
