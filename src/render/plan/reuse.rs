//! How many pixels share what their paths find, how many light paths they share, and how many emitter samples
//! the first vertex of a path takes, where the scene leaves that to a pilot.
//!
//! Each multiplies the variance of a pixel by some v < 1 and its cost by some c > 1, and pays where c v < 1:
//! sharing where light has met several matte surfaces, light paths where most of it comes from few places,
//! and more emitter samples where what is left then is direct light, which nobody shares. The pilot makes the
//! same cells of pixels each way and counts the rays. v is the squared ratio of the sums of the cells'
//! relative deviations, over which a rare bright path has less sway than over variances. It has a seed of its
//! own and its samples are thrown away, so the choice cannot bias an image; they are a function of the scene
//! alone, so every part of a render makes the same.

use super::{light_paths, pilot_camera, scattered};
use crate::integrator::Counters;
use crate::integrator::path::reuse::{CELL, LightSources, cell};
use crate::sampler::MOST_EMITTER_SAMPLES;
use crate::scene::{Features, Scene};
use rayon::prelude::*;

/// What is to be settled.
#[derive(Clone, Copy)]
struct Choice {
    /// That share.
    pixels: u32,
    /// Of each group of these.
    light_paths: u32,
    /// Emitter samples of the first vertex.
    samples: u32,
}

/// Numbers of pixels to choose from, and what each must make of the product of variance and cost of the one
/// before. Correlated errors are a price as well, which a smaller gain is not worth.
const PIXELS: [(u32, f64); 2] = [(16, 0.8), (64, 0.9)];

/// How many pixels there are to a shared light path, and what light paths must make of the product. The
/// pilot, which looks at one colour and few samples, promises half as much again as they bring where little
/// noise is left.
const LIGHT_PATHS: (u32, f64) = (8, 0.65);

/// The same of emitter samples, as multiples of what other vertices take.
const SAMPLES: [(u32, f64); 2] = [(2, 0.95), (4, 0.95)];

/// What sharing costs, in rays a path: at all, and for each receiver; so does each source of a light path.
const SHARING: f64 = 1.8;
const HANDING_ON: f64 = 0.035;

/// What a ray costs that only asks whether a pixel sees what it may share, in rays of paths, which end at
/// vertices.
const VISIBILITY: f64 = 0.5;

/// What a light path of a group costs besides its rays: scattering, weights, and connections.
const LIGHT_PATH: f64 = 12.0;

/// What it costs to ask how a receiver and a source scatter of which one is rough.
const EVALUATION: f64 = 0.25;

/// Cells and samples of the pilot: about a tenth of a second.
const CELLS: u64 = 32;
const CAMERA_SAMPLES: u64 = 32;

/// Samples that are summed before sums are compared: what stratification does away with is no gain.
const BLOCK: u64 = 8;

/// Settles both, by a pilot if the scene's file or a command line leaves them to that, once all else is
/// settled. Light paths take what they make as well out of what pixels share; so where emitters are sampled
/// through glass at all vertices, which relieves light paths, these may go.
pub fn settle(scene: &mut Scene) {
    let Some(path) = scene.integrator.path() else { return };
    let (free, usual) = (path.free, path.emitter_samples);
    let (pixels, light_paths) = (path.reuse, path.shared_light_paths);
    let mut choice = Choice { pixels, light_paths, samples: path.first_emitter_samples };
    if free.reuse {
        let steps = PIXELS.map(|(pixels, worth)| (Choice { pixels, ..choice }, worth));
        let alone = (choice, measure(scene, choice));
        let mut best = climb(scene, alone, &steps);
        let relieved =
            scene.links.as_ref().is_some_and(|links| links.everywhere) && light_paths::is_free(scene);
        if let Some(caustics) = scene.caustics.take_if(|_| relieved) {
            let without = climb(scene, best, &steps);
            if without.1 < best.1 {
                best = without;
            } else {
                scene.caustics = Some(caustics);
            }
            scene.settle_caustics();
        }
        // More emitter samples pay the more, the less is left of other light.
        let several = |scene: &mut Scene, best: (Choice, f64)| {
            let steps = SAMPLES.map(|(times, worth)| {
                let samples = (times * usual).min(MOST_EMITTER_SAMPLES);
                (Choice { samples, ..best.0 }, worth)
            });
            climb(scene, best, if free.first_emitter_samples { &steps } else { &[] })
        };
        let (each, worth) = LIGHT_PATHS;
        let lit = Choice { light_paths: best.0.pixels / each, ..best.0 };
        best = several(scene, best);
        if free.shared_light_paths && lit.light_paths > 0 {
            let with = (lit, measure(scene, lit));
            let with = several(scene, with);
            if with.1 < worth * best.1 {
                best = with;
            }
        }
        choice = best.0;
    }
    set(scene, choice);
    if choice.pixels > 1 {
        light_paths::raise(scene);
    }
}

/// The last of the choices that each are worth their step, with the product of variance and cost.
fn climb(scene: &mut Scene, mut best: (Choice, f64), steps: &[(Choice, f64)]) -> (Choice, f64) {
    for &(choice, worth) in steps {
        let next = (choice, measure(scene, choice));
        let pays = next.1 < worth * best.1;
        if !pays {
            break;
        }
        best = next;
    }
    best
}

fn set(scene: &mut Scene, choice: Choice) {
    let Some(path) = scene.integrator.path_mut() else { return };
    let light_paths = choice.light_paths.min(if choice.pixels > 1 { choice.pixels } else { 0 });
    (path.reuse, path.shared_light_paths) = (choice.pixels, light_paths);
    path.first_emitter_samples = choice.samples;
    scene.light_sources = match light_paths {
        0 => None,
        some => LightSources::new(some, &scene.shapes, &scene.emitters),
    };
    scene.features.0 &= !Features::REUSE;
    scene.features.0 |= if choice.pixels > 1 { Features::REUSE } else { 0 };
}

/// The product of variance and cost, up to a factor that all choices have.
fn measure(scene: &mut Scene, choice: Choice) -> f64 {
    set(scene, choice);
    let scene = &*scene;
    let camera = pilot_camera(scene);
    let film = scene.sensor.film.crop;
    let (columns, rows) = (film.width.div_ceil(CELL), film.height.div_ceil(CELL));
    let channels = camera.channel_names().len();
    let pixels = f64::from(choice.pixels);
    // Relative deviation of a cell, and the cost of its paths in rays.
    let of_cell = |i: u64| {
        let mut counters = Counters::default();
        let at = scattered(i, u64::from(columns * rows)) as u32;
        let corner = (film.x + at % columns * CELL, film.y + at / columns * CELL);
        // Green stands for all colours. Of every pixel: the sum, the sum of squares of blocks, the block at
        // hand.
        let mut sums = vec![[0.0; 3]; (CELL * CELL) as usize];
        for sample in 0..CAMERA_SAMPLES {
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
        let scatter = |[sum, squares, _]: &[f64; 3]| squares - sum * sum / (CAMERA_SAMPLES / BLOCK) as f64;
        let deviation = sums.iter().map(|sum| scatter(sum).max(0.0)).sum::<f64>().sqrt();
        let light: f64 = sums.iter().map(|sum| sum[0]).sum();
        let cost = counters.rays as f64 - (1.0 - VISIBILITY) * counters.shared as f64
            + EVALUATION * counters.evaluations as f64
            + HANDING_ON * pixels * counters.light_sources as f64;
        (if light > 0.0 { deviation / light } else { 0.0 }, cost)
    };
    let cells: Vec<(f64, f64)> = (0..CELLS).into_par_iter().map(of_cell).collect();
    let (deviation, rays) = cells.iter().fold((0.0, 0.0), |sum, cell| (sum.0 + cell.0, sum.1 + cell.1));
    let light_paths = LIGHT_PATH * f64::from(choice.light_paths) / pixels;
    let sharing = if choice.pixels > 1 { SHARING + HANDING_ON * pixels + light_paths } else { 0.0 };
    let paths = (CELLS * CAMERA_SAMPLES * u64::from(CELL * CELL)) as f64;
    deviation * deviation * (rays + sharing * paths)
}

#[cfg(test)]
mod tests {
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    /// Pixels that share, emitter samples of the first vertex and light paths that look for caustics.
    fn chosen(sides: &str, wears: &str, options: &str, inside: &str) -> (u32, u32, u32) {
        let text = scene(sides, wears, options, inside);
        let scene = load_text("box.xml", &text, ColorMode::Rgb).expect("it loads");
        let samples = scene.integrator.path().map_or(0, |path| path.first_emitter_samples);
        (scene.integrator.reuse(), samples, scene.caustics.as_ref().map_or(0, |caustics| caustics.paths))
    }

    /// In a closed box or an open one with this inside.
    fn scene(sides: &str, wears: &str, options: &str, inside: &str) -> String {
        format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="8"/>{options}</integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film></sensor>
                <shape type="{sides}"><transform name="to_world"><scale value="4"/></transform><boolean name="flip_normals" value="true"/>{wears}</shape>
                {inside}</scene>"#
        )
    }

    fn ball(x: f64, radius: f64, wears: &str) -> String {
        format!(
            r#"<shape type="sphere"><point name="center" x="{x}" y="{}" z="0"/><float name="radius" value="{radius}"/>{wears}</shape>"#,
            1.5 * x
        )
    }

    const LAMP: &str = r#"<emitter type="area"/>"#;
    const BRIGHT: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf>"#;
    const ASKED: &str = r#"<integer name="reuse" value="0"/>"#;

    #[test]
    fn pixels_share_where_light_has_met_several_walls() {
        let metal = r#"<bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf>"#;
        let pixels = |sides, wears, reuse| chosen(sides, wears, reuse, &ball(2.0, 0.7, LAMP)).0;
        // A lobe without density is nothing that pixels could share.
        let plastic = r#"<bsdf type="plastic"/>"#;
        assert_eq!(pixels("cube", BRIGHT, ASKED), 64);
        assert!(pixels("cube", metal, ASKED) > 1);
        assert_eq!(pixels("cube", plastic, ASKED), 1);
        assert_eq!(pixels("rectangle", BRIGHT, ASKED), 1);
        assert_eq!(pixels("cube", BRIGHT, ""), 1);
        assert_eq!(pixels("cube", plastic, r#"<integer name="reuse" value="4"/>"#), 4);
    }

    #[test]
    fn light_paths_are_shared_where_a_lamp_shines_at_a_wall() {
        let light_paths = |lamp: &str| {
            let text = scene("cube", BRIGHT, ASKED, lamp);
            let scene = load_text("box.xml", &text, ColorMode::Rgb).expect("it loads");
            scene.light_sources.map_or(0, |sources| sources.paths)
        };
        let spot = format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.1"/><rotate y="1" angle="90"/><translate x="3.5" y="1"/></transform>{LAMP}</shape>"#
        );
        assert!(light_paths(&spot) > 0);
        // Far from the walls it lights all of them.
        assert_eq!(light_paths(&ball(1.0, 0.7, LAMP)), 0);
    }

    #[test]
    fn the_first_vertex_asks_more_often_where_direct_light_is_what_is_left() {
        let lamps: String = (0..6)
            .map(|i| {
                format!(
                    r#"<shape type="sphere"><point name="center" x="{}" y="{}" z="1"/><float name="radius" value="0.1"/>
                        <emitter type="area"><rgb name="radiance" value="20"/></emitter></shape>
                    <shape type="sphere"><point name="center" x="{}" y="0" z="1.5"/><float name="radius" value="0.3"/></shape>"#,
                    i - 3,
                    (i % 3) - 1,
                    f64::from(i) - 2.6
                )
            })
            .collect();
        let samples = |wears: &str, options: &str| chosen("cube", wears, options, &lamps).1;
        let dark = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.1"/></bsdf>"#;
        // Lamps in view have edges, which nothing of this makes smooth.
        let asked = ASKED.to_owned() + r#"<boolean name="hide_emitters" value="true"/>"#;
        assert_eq!(samples(dark, &asked), 4);
        assert_eq!(samples(dark, ""), 1);
        assert_eq!(samples(dark, r#"<integer name="emitter_samples" value="3"/>"#), 3);
        let told = asked + r#"<integer name="first_emitter_samples" value="1"/>"#;
        assert_eq!(samples(dark, &told), 1);
    }

    #[test]
    fn light_paths_give_way_to_sharing_where_links_do_their_work() {
        let glass = r#"<bsdf type="dielectric"/>"#;
        let (globe, aside) = (ball(2.0, 0.9, glass), ball(-2.0, 0.9, glass));
        let choice =
            |options: &str, glass: &str| chosen("cube", BRIGHT, options, &(ball(2.0, 0.3, LAMP) + glass));
        let (pixels, _, light_paths) = choice(ASKED, &globe);
        assert!(pixels > 1 && light_paths == 0, "{pixels} {light_paths}");
        assert!(choice("", &globe).2 > 0 && choice(ASKED, &aside).2 > 0);
        let told = ASKED.to_owned() + r#"<float name="light_paths" value="1"/>"#;
        assert_eq!(choice(&told, &globe).2, 64 * 48);
    }
}
