//! How many pixels share what their paths find, how many light paths they share, and how many emitter samples
//! the first vertex of a path takes, where the scene leaves that to a pilot; and when roulette begins then.
//!
//! Each multiplies the variance of a pixel by some v < 1 and its cost by some c > 1, and pays where c v < 1:
//! sharing where light has met several matte surfaces, light paths where most of it comes from few places,
//! and more emitter samples where what is left then is direct light, which nobody shares. The pilot makes the
//! same cells of pixels each way and counts the rays. v is the squared ratio of the sums of the cells'
//! relative deviations, over which a rare bright path has less sway than over variances, with the light paths
//! for caustics that are best beside them.
//!
//! Since direct light is never shared, its variance adds to that of the rest and falls as the number of its
//! samples grows, whatever is shared. So two looks at pixels that share nothing, with few emitter samples and
//! with many, predict any other look for any number of these, and all is chosen together.

use super::light_paths::{self, Brought};
use super::look::{CELLS, Cell, GLANCE, Look};
use crate::integrator::path::reuse::LightSources;
use crate::sampler::MOST_EMITTER_SAMPLES;
use crate::scene::{Features, Scene};

/// The settings that are chosen.
#[derive(Clone, Copy)]
struct Candidate {
    /// Number of pixels that share.
    pixels: u32,
    /// Light paths per group of pixels.
    light_paths: u32,
    /// Emitter samples of the first vertex.
    samples: u32,
}

/// Numbers of pixels to choose from, each with the factor by which its product of variance and cost is
/// multiplied for comparison: correlated errors are a price as well, which a small gain is not worth.
const PIXELS: [(u32, f64); 2] = [(16, 1.1), (64, 1.2)];

/// If one number of pixels has a product that exceeds this times the best, larger numbers have not been seen
/// to pay.
const FAR: f64 = 1.3;

/// Pixels per shared light path, and the factor for light paths (see [`PIXELS`]). The pilot, which looks at
/// one colour and few samples, overestimates their gain where little noise is left.
const LIGHT_PATHS: (u32, f64) = (8, 1.4);

/// Numbers of emitter samples, as multiples of what other vertices take, each with its factor (see
/// [`PIXELS`]).
const SAMPLES: [(u32, f64); 4] = [(1, 1.0), (2, 1.05), (4, 1.1), (8, 1.15)];

/// Cost of an emitter sample besides its ray, in rays.
const EMITTER_SAMPLE: f64 = 0.75;

/// A choice, and its product of variance, cost and factors such as those of [`PIXELS`], with as many light
/// paths for caustics to a camera path as are best.
struct Judged {
    choice: Candidate,
    product: f64,
    caustics: Option<f64>,
}

impl Judged {
    /// By a look that was measured or is predicted.
    fn new(choice: Candidate, look: &Look, price: f64, brought: Option<&Brought>) -> Self {
        let (product, caustics) = match brought.map(|brought| brought.best_with(look)) {
            Some((product, light_paths)) => (product, Some(light_paths)),
            None => (look.product(), None),
        };
        Self { choice, product: price * product, caustics }
    }
}

/// Noise and cost of the emitter samples of the first vertex.
struct Direct {
    /// Variance of each cell that one emitter sample leaves; n of them leave an nth.
    variances: Vec<f64>,
    /// Cost of one emitter sample, in rays.
    cost: f64,
}

impl Direct {
    /// From looks with few and with many samples.
    fn between((n, few): (u32, &Look), (m, many): (u32, &Look)) -> Self {
        let (n, m) = (f64::from(n), f64::from(m));
        let one = |(few, many): (&Cell, &Cell)| (few.variance - many.variance).max(0.0) / (1.0 / n - 1.0 / m);
        Self {
            variances: few.cells.iter().zip(&many.cells).map(one).collect(),
            cost: (1.0 + EMITTER_SAMPLE) * (many.cost - few.cost).max(0.0) / (m - n),
        }
    }

    /// Predicts what a look with n samples would have been with m.
    fn foretell(&self, look: &Look, n: u32, m: u32) -> Look {
        let (n, m) = (f64::from(n), f64::from(m));
        let with = |(cell, direct): (&Cell, &f64)| Cell {
            variance: (cell.variance - direct * (1.0 / n - 1.0 / m)).max(0.0),
            ..*cell
        };
        Look {
            cells: look.cells.iter().zip(&self.variances).map(with).collect(),
            cost: look.cost + (m - n) * self.cost,
        }
    }
}

/// Settles sharing and emitter samples, by a pilot if the scene's file or a command line leaves them to that,
/// once all else is settled but the number of light paths that look for caustics. What these find as well is
/// not shared; so where emitters are sampled through glass at all vertices, which takes over their part, they
/// may be dropped.
pub fn settle(scene: &mut Scene) {
    let Some(path) = scene.integrator.path() else { return };
    let free = path.free;
    let given = Candidate {
        pixels: path.reuse,
        light_paths: path.shared_light_paths,
        samples: path.first_emitter_samples,
    };
    if !free.reuse {
        set(scene, given);
        if scene.caustics.is_some() && light_paths::is_free(scene) {
            light_paths::balance(scene);
        }
        return;
    }
    scene.sensor.film.spread = scene.sensor.film.spreadable();
    let mut best = choose(scene, given);
    let relieved = scene.links.as_ref().is_some_and(|links| links.everywhere) && light_paths::is_free(scene);
    if let Some(caustics) = scene.caustics.take_if(|_| relieved) {
        let without = choose(scene, given);
        if without.product < best.product {
            best = without;
        } else {
            scene.caustics = Some(caustics);
        }
        scene.settle_caustics();
    }
    set(scene, best.choice);
    if let Some(ratio) = best.caustics.filter(|_| light_paths::is_free(scene)) {
        light_paths::set(scene, ratio);
    }
}

/// The best choice for a scene as it is. A glance suffices where sharing is far from paying, unless the look
/// is needed to balance light paths.
fn choose(scene: &mut Scene, given: Candidate) -> Judged {
    if scene.caustics.is_none()
        && let (glanced, true) = among(scene, given, true)
    {
        return glanced;
    }
    among(scene, given, false).0
}

/// The best choice, and whether sharing is far from paying; a glance is for the latter.
fn among(scene: &mut Scene, given: Candidate, glance: bool) -> (Judged, bool) {
    let free = scene.integrator.path().map(|path| path.free).unwrap_or_default();
    let brought = Brought::of(scene);
    let alone = look_with(scene, given, glance);
    let numbers = SAMPLES.map(|(times, price)| ((times * given.samples).min(MOST_EMITTER_SAMPLES), price));
    let many = numbers[SAMPLES.len() - 1].0;
    let direct = (free.first_emitter_samples && many > given.samples).then(|| {
        let looked = look_with(scene, Candidate { samples: many, ..given }, glance);
        Direct::between((given.samples, &alone), (many, &looked))
    });
    // The best number of emitter samples, from a look with `choice.samples` of them.
    let judge = |choice: Candidate, look: Look, price: f64| {
        let Some(direct) = &direct else { return Judged::new(choice, &look, price, brought.as_ref()) };
        let each = numbers.map(|(samples, more)| {
            let look = direct.foretell(&look, choice.samples, samples);
            Judged::new(Candidate { samples, ..choice }, &look, price * more, brought.as_ref())
        });
        let [first, others @ ..] = each;
        others.into_iter().fold(first, better)
    };
    let mut best = judge(given, alone, 1.0);
    let (mut price_of_best, mut far) = (1.0, false);
    for &(pixels, price) in if glance { &PIXELS[..1] } else { &PIXELS } {
        let choice = Candidate { pixels, ..given };
        let judged = judge(choice, look_with(scene, choice, glance), price);
        // Where some pixels are far from paying, more are not tried.
        if judged.product > FAR * best.product {
            far = best.choice.pixels == given.pixels;
            break;
        }
        if judged.product < best.product {
            (best, price_of_best) = (judged, price);
        }
    }
    let (each, price) = LIGHT_PATHS;
    let lit = Candidate { light_paths: best.choice.pixels / each, ..best.choice };
    if free.shared_light_paths && lit.light_paths > 0 && !glance {
        let judged = judge(lit, look_with(scene, lit, glance), price * price_of_best);
        best = better(best, judged);
    }
    (best, far)
}

fn look_with(scene: &mut Scene, choice: Candidate, glance: bool) -> Look {
    set(scene, choice);
    Look::at(scene, if glance { GLANCE } else { CELLS })
}

/// The one with the smaller product; of equals the first.
fn better(a: Judged, b: Judged) -> Judged {
    if b.product < a.product { b } else { a }
}

fn set(scene: &mut Scene, choice: Candidate) {
    let Some(path) = scene.integrator.path_mut() else { return };
    let light_paths = choice.light_paths.min(if choice.pixels > 1 { choice.pixels } else { 0 });
    (path.reuse, path.shared_light_paths) = (choice.pixels, light_paths);
    path.first_emitter_samples = choice.samples;
    if path.free.reuse && path.free.roulette {
        path.roulette = path.roulette.early();
    }
    scene.light_sources = match light_paths {
        0 => None,
        some => LightSources::new(some, &scene.shapes, &scene.emitters),
    };
    scene.features.0 &= !Features::REUSE;
    scene.features.0 |= if choice.pixels > 1 { Features::REUSE } else { 0 };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load_text;
    use crate::spectrum::ColorMode;

    /// Pixels that share, emitter samples of the first vertex and light paths that look for caustics.
    fn chosen(sides: &str, wears: &str, options: &str, inside: &str) -> (u32, u32, u32) {
        let text = scene(sides, wears, options, inside);
        let scene = load_text("box.xml", &text, ColorMode::Rgb).expect("it loads");
        let samples = scene.integrator.path().map_or(0, |path| path.first_emitter_samples);
        (scene.integrator.reuse(), samples, scene.light_paths())
    }

    /// In a closed box or an open one with this inside.
    fn scene(sides: &str, wears: &str, options: &str, inside: &str) -> String {
        format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="8"/>{options}</integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/><rfilter type="box"/></film></sensor>
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
    fn samples_count_for_several_pixels_where_errors_may_be_correlated() {
        let plastic = r#"<bsdf type="plastic"/>"#;
        let spreads = |wears: &str, options: &str, filter: &str| {
            let text = scene("cube", wears, options, &ball(2.0, 0.7, LAMP)).replace("box", filter);
            let scene = load_text("room.xml", &text, ColorMode::Rgb).expect("it loads");
            scene.sensor.film.spread.is_some()
        };
        assert!(spreads(plastic, ASKED, "tent") && spreads(BRIGHT, ASKED, "gaussian"));
        assert!(!spreads(plastic, ASKED, "box"));
        assert!(
            !spreads(plastic, "", "tent") && !spreads(BRIGHT, r#"<integer name="reuse" value="4"/>"#, "tent")
        );
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
        assert_eq!(samples(dark, &asked), 8);
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

    #[test]
    fn two_looks_foretell_any_number_of_emitter_samples() {
        // Shared light leaves so much of each cell, one sample of direct light so much more.
        let (shared, direct) = ([3.0, 0.5, 0.0], [1.0, 8.0, 2.0]);
        let look = |shared: [f64; 3], samples: f64, cost: f64| Look {
            cells: shared
                .iter()
                .zip(&direct)
                .map(|(shared, direct)| Cell { variance: shared + direct / samples, ..Cell::default() })
                .collect(),
            cost: cost + samples * (1.0 + EMITTER_SAMPLE),
        };
        // A ray is all that looks know of the cost of a sample.
        let alone = |samples: f64| Look { cost: 5.0 + samples, ..look(shared, samples, 0.0) };
        let direct = Direct::between((2, &alone(2.0)), (8, &alone(8.0)));
        let fewer = shared.map(|variance| variance / 16.0);
        let (foretold, seen) = (direct.foretell(&look(fewer, 1.0, 9.0), 1, 4), look(fewer, 4.0, 9.0));
        assert!((foretold.cost - seen.cost).abs() < 1e-12);
        for (foretold, seen) in foretold.cells.iter().zip(&seen.cells) {
            assert!((foretold.variance - seen.variance).abs() < 1e-12);
        }
    }
}
