//! How many pixels share what their paths find, how many light paths they share, and how many emitter samples
//! the first vertex of a path takes, where the scene leaves that to a pilot; and when roulette begins then.
//!
//! Each multiplies the variance of a pixel by some v < 1 and its cost by some c > 1, and pays where c v < 1:
//! sharing where light has met several matte surfaces, light paths where most of it comes from few places,
//! and more emitter samples where what is left then is direct light, which nobody shares. The pilot makes the
//! same cells of pixels each way and counts the rays. v is the squared ratio of the sums of the cells'
//! relative deviations, over which a rare bright path has less sway than over variances, with the light paths
//! for caustics that are best beside them. They race each other: `race.rs`.

use super::light_paths;
use super::race::Race;
use crate::integrator::path::reuse::LightSources;
use crate::scene::Scene;

/// The settings that are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Number of pixels that share.
    pub pixels: u32,
    /// Light paths per group of pixels.
    pub light_paths: u32,
    /// Emitter samples of the first vertex.
    pub samples: u32,
}

/// Settles sharing and emitter samples, by a pilot if the scene's file or a command line leaves them to that,
/// once all else is settled but the number of light paths that look for caustics. What these find as well is
/// not shared; so where emitters are sampled through glass at all vertices, which takes over their part, they
/// may be dropped.
pub fn settle(scene: &mut Scene) {
    let Some(path) = scene.integrator.path() else { return };
    let given = Candidate {
        pixels: path.reuse,
        light_paths: path.shared_light_paths,
        samples: path.first_emitter_samples,
    };
    let open = path.open;
    if !open.reuse {
        set(scene, given);
        if scene.techniques.caustics.is_some() && open.light_paths {
            light_paths::balance(scene);
        }
        return;
    }
    scene.sensor.film.spread = scene.sensor.film.spreadable();
    let best = Race::new(scene, given, open).run();
    if let Some(ratio) = best.caustics.filter(|_| open.light_paths) {
        light_paths::set(scene, ratio);
    }
}

/// Gives a scene these settings.
pub fn set(scene: &mut Scene, choice: Candidate) {
    let Some(path) = scene.integrator.path_mut() else { return };
    let light_paths = choice.light_paths.min(if choice.pixels > 1 { choice.pixels } else { 0 });
    (path.reuse, path.shared_light_paths) = (choice.pixels, light_paths);
    path.first_emitter_samples = choice.samples;
    if path.open.reuse && path.open.roulette {
        path.roulette = path.roulette.early();
    }
    scene.techniques.light_sources = match light_paths {
        0 => None,
        some => LightSources::new(some, &scene.shapes, &scene.emitters),
    };
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::spectrum::ColorMode;

    /// Pixels that share, emitter samples of the first vertex and light paths that look for caustics.
    fn chosen(sides: &str, wears: &str, options: &str, inside: &str) -> (u32, u32, u32) {
        let text = scene(sides, wears, options, inside);
        let scene = load_text("box.xml", &text, ColorMode::Rgb).expect("it loads");
        let samples = scene.integrator.path().map_or(0, |path| path.first_emitter_samples);
        (scene.integrator.reuse(), samples, scene.techniques.light_paths())
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
            scene.techniques.light_sources.map_or(0, |sources| sources.paths)
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
        let (globe, unused_caustics) = (ball(2.0, 0.9, glass), ball(-2.0, 0.9, glass));
        let choice =
            |options: &str, glass: &str| chosen("cube", BRIGHT, options, &(ball(2.0, 0.3, LAMP) + glass));
        let (pixels, _, light_paths) = choice(ASKED, &globe);
        assert!(pixels > 1 && light_paths == 0, "{pixels} {light_paths}");
        assert!(choice("", &globe).2 > 0 && choice(ASKED, &unused_caustics).2 > 0);
        let told = ASKED.to_owned() + r#"<float name="light_paths" value="1"/>"#;
        assert_eq!(choice(&told, &globe).2, 64 * 48);
    }
}
