//! The number of light paths per camera path.
//!
//! First a pilot, too short to measure variances, measures how much of the light they find, for either kind
//! of path finds its own part easily. Where light paths find none they are left out; where they would find
//! most of it, sampling emitters through glass ([`links`](crate::integrator::links)) takes over a part. The
//! root of their share is a first guess at their number: a pixel of relative cost 1 + s and variance V + W/s,
//! with s light paths per camera path, is best at s² = W/V, and variances are about in proportion to
//! energies.
//!
//! Once all else is settled ([`balance`]), V and W and the costs are measured, with the weights that the two
//! kinds of path have beside as many light paths as were guessed. V + W/s is then an upper bound: the weights
//! of s light paths would leave less. With a small guess these weights leave nearly all light to the camera
//! paths, so W comes out small and would confirm the small guess whatever is true: the guess is not below a
//! quarter.

use super::cells::{Cells, first_of};
use super::look::{Cell, Look};
use super::{all_over, brightness, pilot_maker};
use crate::film::Window;
use crate::integrator::Counters;
use crate::integrator::links::LinkPolicy;
use crate::sampler::SampleId;
use crate::scene::Scene;

/// Camera samples of the pilot: some milliseconds.
const CAMERA_SAMPLES: u64 = 2048;
/// Light paths of the pilot: some milliseconds.
const PILOT_PATHS: u64 = 8192;
/// Where they bring light to fewer places of a tile than this on average, there are more of them.
const PLACES: usize = 8;
/// Most light paths of the pilot.
const MOST_LIGHT_PATHS: u64 = 16 * PILOT_PATHS;

/// Tiles along each side of the image where light is measured: few, for there may be few samples in each.
const TILES: usize = 8;
/// Tiles along each side where noise is measured: more, for noise is relative to the light of its own tile.
const FINE_TILES: usize = 32;

/// If light paths would find more than this share of the light, emitters are sampled through glass at all
/// vertices.
const MUCH: f64 = 0.5;

/// Fewest light paths per camera path beside which noise is measured.
const FIRST: f64 = 0.25;

/// Fewest light paths per camera path, unless there are none: so few cost next to nothing.
const FEWEST: f64 = 1.0 / 32.0;
/// Most light paths per camera path: more gain next to nothing.
const MOST: f64 = 1.0;

/// Most light paths per sample number, however large the film: what those of the four samples of a block find
/// may take a quarter of a gigabyte.
const AT_ONCE: f64 = (1 << 19) as f64;

/// Ratio of the actual variance of light paths, which are stratified over emitters and directions, to the
/// variance of independent ones, which the sum of squares estimates. (Found by renders with other numbers of
/// them; see the notebook.)
const STRATIFIED: f64 = 0.4;

/// Cost of a ray of a light path, connections with the camera included, in rays of camera paths.
const RAY: f64 = 2.0;

/// Settles the number of light paths of a scene whose file does not.
pub fn settle(scene: &mut Scene) {
    if scene.techniques.caustics.is_none() || !are_open(scene) {
        return;
    }
    let mut part = part_of_light_paths(scene);
    let auto = scene.integrator.path().is_some_and(|path| path.links == LinkPolicy::Auto);
    if let Some(links) = scene.techniques.links.as_mut().filter(|_| auto && part > MUCH) {
        links.everywhere = true;
        part = part_of_light_paths(scene);
    }
    if part > 0.0 {
        set(scene, part.sqrt().max(FIRST));
    } else {
        scene.techniques.caustics = None;
    }
}

/// What light paths bring to a film, and what they cost.
pub struct LightPathGain {
    film: Window,
    tiles: Vec<Tile>,
    /// Cost of a light path, in rays of camera paths.
    cost: f64,
    /// Numbers of light paths per camera path to choose from.
    ratios: Vec<f64>,
}

impl LightPathGain {
    /// `None` if a scene has no light paths.
    pub fn of(scene: &Scene) -> Option<Self> {
        let caustics = scene.techniques.caustics.as_ref()?;
        let film = scene.sensor.film.crop;
        let (tiles, rays) = splats(scene, FINE_TILES, MOST_LIGHT_PATHS);
        let ratios = if are_open(scene) {
            let (most, fewest) = (most(film), FEWEST.min(most(film)));
            let halves = std::iter::successors(Some(most), |s| Some(0.5 * s));
            halves.take_while(|s| *s >= fewest).flat_map(|s| [s, 0.75 * s]).collect()
        } else {
            vec![f64::from(caustics.paths) / film.pixels() as f64]
        };
        Some(Self { film, tiles, cost: RAY * rays, ratios })
    }

    fn tile(&self, pixel: (u32, u32)) -> Tile {
        self.tiles[tile(self.film, FINE_TILES, pixel)]
    }

    /// The cells that the scene is looked at in: noisy are those in the tiles where light paths make half of
    /// their deviations, the fewest that do.
    pub fn cells(&self) -> Cells {
        let mut deviations: Vec<f64> = self.tiles.iter().map(|tile| tile.squares.sqrt()).collect();
        deviations.sort_by(|a, b| b.total_cmp(a));
        let half = 0.5 * deviations.iter().sum::<f64>();
        let mut sum = 0.0;
        let reaches_half = |deviation: &f64| {
            sum += deviation;
            sum >= half
        };
        let least = deviations.into_iter().find(reaches_half).filter(|least| *least > 0.0);
        Cells::of(self.film, |pixel| least.is_some_and(|least| self.tile(pixel).squares.sqrt() >= least))
    }

    /// A look with as many light paths to each camera path as are best beside it, and that number.
    pub fn best_with(&self, look: &Look) -> (Look, f64) {
        // Variances of a cell relative to its light squared: that which camera paths leave, and that which
        // one light path per camera path leaves. Black cells have neither.
        let of_cell = |cell: &Cell| {
            let Tile { light, squares } = self.tile(first_of(cell.corner, self.film));
            let all = cell.light + light;
            let parts =
                [cell.variance * (cell.light / all) * (cell.light / all), STRATIFIED * squares / (all * all)];
            if all > 0.0 { parts } else { [0.0; 2] }
        };
        let cells: Vec<_> = look.cells.iter().map(of_cell).collect();
        let with = |s: f64| {
            let lit = |(cell, [v, w]): (&Cell, &[f64; 2])| Cell { variance: v + w / s, ..*cell };
            let cells = look.cells.iter().zip(&cells).map(lit).collect();
            (Look { cells, cost: look.cost + s * self.cost }, s)
        };
        let better = |best: (Look, f64), other: (Look, f64)| {
            if other.0.product() < best.0.product() { other } else { best }
        };
        self.ratios.iter().copied().map(with).reduce(better).expect("there are numbers to choose from")
    }
}

/// Settles the number of light paths by the noise and the cost of camera paths, once all else is settled.
pub fn balance(scene: &mut Scene) {
    if let Some(brought) = LightPathGain::of(scene) {
        set(scene, brought.best_with(&Look::at(scene, &brought.cells())).1);
    }
}

/// Gives a scene so many light paths per camera path, within reason.
pub fn set(scene: &mut Scene, ratio: f64) {
    let film = scene.sensor.film.crop;
    let ratio = ratio.max(FEWEST).min(most(film));
    scene.techniques.caustics.iter_mut().for_each(|caustics| caustics.set_ratio(ratio, film.pixels()));
}

/// The most light paths per camera path of a film.
fn most(film: Window) -> f64 {
    MOST.min(AT_ONCE / film.pixels() as f64)
}

/// Whether a scene's file leaves open how many light paths there are.
pub fn are_open(scene: &Scene) -> bool {
    scene.integrator.path().is_some_and(|path| path.open.light_paths)
}

/// What light paths contribute to the pixels of a tile.
#[derive(Clone, Copy, Default)]
struct Tile {
    /// Mean contribution to a pixel.
    light: f64,
    /// Variance of that contribution with one light path per camera sample.
    squares: f64,
}

/// The tile of a pixel.
fn tile(film: Window, tiles: usize, (x, y): (u32, u32)) -> usize {
    tile_along(y - film.y, film.height, tiles) * tiles + tile_along(x - film.x, film.width, tiles)
}

/// The tile of a pixel along one side of the film, at `offset` of `size` pixels.
fn tile_along(offset: u32, size: u32, tiles: usize) -> usize {
    (u64::from(offset) * tiles as u64 / u64::from(size)) as usize
}

/// How many pixels each tile has along one side; on a small film one or none.
fn pixels_along(size: u32, tiles: usize) -> Vec<u32> {
    let mut pixels = vec![0; tiles];
    (0..size).for_each(|offset| pixels[tile_along(offset, size, tiles)] += 1);
    pixels
}

/// What light paths contribute to so many tiles along each side, and the number of rays per light path; by no
/// more than so many of them, and as few as tell one tile from the other.
fn splats(scene: &Scene, along: usize, most: u64) -> (Vec<Tile>, f64) {
    let film = scene.sensor.film.crop;
    let mut tiles = vec![Tile::default(); along * along];
    let mut counters = Counters::default();
    let paths = f64::from(scene.techniques.light_paths());
    let maker = pilot_maker(scene);
    let (mut traced, mut next, mut places) = (0, PILOT_PATHS, 0);
    loop {
        maker.trace_light(traced..next, &mut counters, |_, at, values| {
            // As if it had been the only light path.
            let brought = paths * brightness(values);
            let tile = &mut tiles[tile(film, along, at)];
            tile.light += brought;
            tile.squares += brought * brought;
            places += 1;
        });
        (traced, next) = (next, 2 * next);
        let lit = tiles.iter().filter(|tile| tile.squares > 0.0).count();
        if next > most || places >= PLACES * lit {
            break;
        }
    }
    let (columns, rows) = (pixels_along(film.width, along), pixels_along(film.height, along));
    let pixels = film.pixels() as f64;
    for (i, tile) in tiles.iter_mut().enumerate() {
        let samples = traced as f64 * f64::from((columns[i % along] * rows[i / along]).max(1));
        *tile = Tile { light: tile.light / samples, squares: tile.squares / (samples * pixels) };
    }
    (tiles, counters.rays as f64 / traced as f64)
}

/// The share of the light that light paths find, averaged over tiles of the image, so that a lamp in view
/// does not outweigh everything else; zero if they were not seen to find any.
fn part_of_light_paths(scene: &Scene) -> f64 {
    let maker = pilot_maker(scene);
    let film = scene.sensor.film.crop;
    let which = all_over(film, CAMERA_SAMPLES);
    let channels = maker.channels();
    let mut values = vec![0.0; channels * which.len()];
    maker.samples(&which, &mut Counters::default(), &mut values);
    // Per tile: the sum of samples, and their number; tiles without samples are left out.
    let mut seen = vec![(0.0, 0.0); TILES * TILES];
    for (SampleId { pixel, .. }, values) in which.iter().zip(values.chunks(channels)) {
        let (light, samples) = &mut seen[tile(film, TILES, *pixel)];
        (*light, *samples) = (*light + brightness(values), *samples + 1.0);
    }
    let (brought, _) = splats(scene, TILES, PILOT_PATHS);
    let part =
        |((seen, samples), brought): (&(f64, f64), &Tile)| brought.light / (seen / samples + brought.light);
    let parts = seen.iter().zip(&brought).map(part);
    let lit: Vec<f64> = parts.filter(|part| part.is_finite()).map(|part| part.clamp(0.0, 1.0)).collect();
    if lit.is_empty() { 0.0 } else { lit.iter().sum::<f64>() / lit.len() as f64 }
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::scene::Features;
    use crate::spectrum::ColorMode;

    /// Light paths to a camera path in a box whose lamp is behind glass or not, or that has no glass, or no
    /// lamp to aim from.
    fn ratio(inside: &str, more: &str) -> f64 {
        let text = format!(
            r#"<scene version="3.0.0">
                <integrator type="path"><integer name="max_depth" value="6"/>{more}</integrator>
                <sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, -3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film></sensor>
                <shape type="cube"><transform name="to_world"><scale value="4"/></transform><boolean name="flip_normals" value="true"/>
                    <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>{inside}</scene>"#
        );
        let scene = load_text("box.xml", &text, ColorMode::Rgb).unwrap();
        let paths = scene.techniques.light_paths();
        assert_eq!(paths > 0, scene.features().cover(Features(Features::CAUSTICS)));
        f64::from(paths) / 1024.0
    }

    #[test]
    fn there_are_as_many_light_paths_as_light_comes_by_them() {
        let lamp = |place: &str, radius: f64| {
            format!(
                r#"<shape type="sphere"><point name="center" {place}/><float name="radius" value="{radius}"/>
                    <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>"#
            )
        };
        let glass = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value="0.9"/>
            <bsdf type="dielectric"/></shape>"#;
        let beside = ratio(&(lamp(r#"x="2" y="2" z="0""#, 0.5) + glass), "");
        let within = ratio(&(lamp(r#"x="0" y="0" z="1""#, 0.5) + glass), "");
        assert!(beside > 0.0 && within > 1.5 * beside, "{beside} beside, {within} within");
        assert_eq!(ratio(&lamp(r#"x="2" y="2" z="0""#, 0.5), ""), 0.0);
        let red = lamp(r#"x="2" y="2" z="0""#, 0.5).replace(r#"value="5""#, r#"value="5 0 0""#);
        assert_eq!(ratio(&(red + glass), ""), beside);
        let distant =
            r#"<emitter type="directional"><vector name="direction" x="0" y="-1" z="0"/></emitter>"#;
        assert_eq!(ratio(&(distant.to_owned() + glass), ""), 0.0);
        let told = r#"<float name="light_paths" value="3"/>"#;
        assert_eq!(ratio(&(lamp(r#"x="2" y="2" z="0""#, 0.5) + glass), told), 3.0);
    }
}
