use super::*;
use crate::image::Image;
use crate::integrator::kernel_for;
use crate::load_text;
use crate::render::quality::{Correlation, Quality};
use crate::render::{Progress, Settings, render};
use crate::scene::Scene;
use crate::spectrum::ColorMode;

const FILTERS: [&str; 4] = [
    r#"<rfilter type="tent"/>"#,
    r#"<rfilter type="gaussian"/>"#,
    r#"<rfilter type="mitchell"/>"#,
    r#"<rfilter type="lanczos"/>"#,
];

/// Twice: with samples that count for one pixel each, and for all that the filter reaches. The film shows a
/// part that begins within it.
fn scenes(filter: &str, content: &str) -> [Scene; 2] {
    sharing(1, filter, content)
}

/// The same where so many pixels share paths.
fn sharing(pixels: u32, filter: &str, content: &str) -> [Scene; 2] {
    let depth = if pixels > 1 { 4 } else { 2 };
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="{depth}"/>
            <integer name="reuse" value="{pixels}"/></integrator>
        <sensor type="perspective"><float name="fov" value="40"/><sampler type="independent"/><film type="hdrfilm">
            <integer name="width" value="14"/><integer name="height" value="12"/>
            <integer name="crop_offset_x" value="1"/><integer name="crop_offset_y" value="2"/>
            <integer name="crop_width" value="12"/><integer name="crop_height" value="9"/>{filter}</film></sensor>
        {content}</scene>"#
    );
    let scene = || load_text("scene.xml", &text, ColorMode::Rgb).expect("it loads");
    let (own, mut spread) = (scene(), scene());
    spread.sensor.film.spread = spread.sensor.film.spreadable();
    assert!(spread.sensor.film.spread.is_some());
    [own, spread]
}

fn image(scene: &Scene, seed: u32, samples: u64) -> Image {
    let settings = Settings { seed, ..Settings::of(scene, 0..samples) };
    render(scene, &settings, &Progress::default()).expect("it renders").0
}

/// Mean and variance of green, pixel by pixel.
fn green(image: &Image) -> impl Iterator<Item = (f64, f64)> {
    let variances = image.channels[1].variance.as_deref().expect("there are variances");
    image.channels[1].mean.iter().zip(variances).map(|(mean, v)| (f64::from(*mean), f64::from(*v)))
}

const BALL: &str = r#"<shape type="sphere"><transform name="to_world"><scale value="0.8"/><translate x="0.3" y="0.2" z="4"/></transform></shape>
    <shape type="rectangle"><transform name="to_world"><scale x="0.1" y="9"/><translate x="-0.9" z="4"/></transform>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
    <emitter type="constant"/>"#;

#[test]
fn pixels_are_what_their_filters_say_up_to_the_film_s_borders() {
    const SAMPLES: u64 = 1 << 14;
    // Of what the foot of a filter sees, no sample may have fallen there.
    const MISSED: f64 = 1.0 / SAMPLES as f64;
    for filter in FILTERS {
        let [own, spread] = scenes(filter, BALL).map(|scene| image(&scene, 0, SAMPLES));
        for (i, ((a, va), (b, vb))) in green(&own).zip(green(&spread)).enumerate() {
            // Four filters of 108 pixels; beyond five deviations is one in four thousand.
            let z = (a - b) / (va + vb + MISSED * MISSED).sqrt();
            assert!(z.abs() < 5.0, "{filter}, pixel {i}: {a} {b}, {z} deviations");
        }
    }
}

#[test]
fn pixels_that_share_paths_are_what_their_filters_say() {
    let room = r#"<shape type="cube"><transform name="to_world"><scale value="3"/><translate z="2.5"/></transform>
            <boolean name="flip_normals" value="true"/><bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="0.6" y="0.4" z="4"/><float name="radius" value="0.4"/><emitter type="area"/></shape>"#;
    for pixels in [4, 64] {
        let [own, spread] = sharing(pixels, FILTERS[0], room).map(|scene| image(&scene, 0, 4096));
        for (i, ((a, va), (b, vb))) in green(&own).zip(green(&spread)).enumerate() {
            let z = (a - b) / (va + vb).sqrt();
            assert!(z.abs() < 5.0, "{pixels} share, pixel {i}: {a} {b}, {z} deviations");
        }
    }
}

#[test]
fn a_pixel_is_the_weighted_sum_of_the_samples_around_it() {
    for filter in FILTERS {
        let [_, scene] = scenes(filter, BALL);
        let film = &scene.sensor.film;
        let maker = SampleMaker::new(&scene, 1, kernel_for(scene.features()));
        let settings = Settings { seed: 1, ..Settings::of(&scene, 4..5) };
        let (image, _) = render(&scene, &settings, &Progress::default()).expect("it renders");
        let place = maker.place_in_pixels(4).expect("it is the same in all pixels");
        let reach = film.spread.as_ref().map_or(0, |spread| spread.reach());
        for i in 0..film.crop.pixels() {
            let (x, y) = film.crop.pixel(i);
            let [columns, rows] = film.weights((x, y), place).expect("there are some");
            let mut sum = 0.0;
            for (j, row) in rows.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                for (i, column) in columns.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                    let from = (x + i as u32 - reach, y + j as u32 - reach);
                    let path = maker.replay(from, 4).path;
                    sum += column * row * f64::from(path.radiance.0[1]);
                }
            }
            let shown = f64::from(image.channels[1].mean[i]);
            assert!((shown - sum).abs() <= 1e-6 * shown.abs(), "{filter}, {x} {y}: {shown} {sum}");
        }
    }
}

#[test]
fn even_light_makes_an_even_picture() {
    for filter in FILTERS {
        let [_, spread] = scenes(filter, r#"<emitter type="constant"/>"#);
        let image = image(&spread, 0, 8);
        let reach = spread.sensor.film.spread.as_ref().map_or(0, |spread| spread.reach());
        for (i, (mean, _)) in green(&image).enumerate() {
            let (x, y) = (i as u32 % 12, i as u32 / 12);
            let inside = |at: u32, size: u32| (reach..size - reach).contains(&at);
            if inside(x, 12) && inside(y, 9) {
                assert!((mean - 1.0).abs() < 1e-3, "{filter}, {x} {y}: {mean}");
            }
        }
    }
}

/// Noise that is the same in all pixels: a wall that emits little, seen by an unlikely lamp.
const NOISE: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="9"/><rotate y="1" angle="180"/><translate z="4"/></transform></shape>
    <shape type="sphere"><point name="center" x="0" y="8" z="-9"/><float name="radius" value="3"/><emitter type="area"/></shape>
    <shape type="sphere"><point name="center" x="0" y="4" z="-1"/><float name="radius" value="1.4"/></shape>"#;

#[test]
fn noise_is_less_by_the_square_of_the_filter_and_the_mean_knows_of_it() {
    for (filter, expected) in [(FILTERS[0], 4.0 / 9.0), (FILTERS[1], std::f64::consts::FRAC_1_PI)] {
        let [own, spread] = scenes(filter, NOISE);
        let gain = spread.sensor.film.correlation(1);
        assert!((gain * expected - 1.0).abs() < 0.01, "{filter} {gain}");
        // Away from the film's borders.
        let variance = |image: &Image| -> f64 {
            let inside = |i: usize| (2..10).contains(&(i % 12)) && (2..7).contains(&(i / 12));
            green(image).enumerate().filter(|(i, _)| inside(*i)).map(|(_, (_, v))| v).sum()
        };
        let ratio = variance(&image(&spread, 0, 4096)) / variance(&image(&own, 0, 4096));
        assert!((ratio / expected - 1.0).abs() < 0.1, "{filter} {ratio}");
        // The scatter of the image's mean over seeds, whose square is uncertain by √(2/255), a twelfth.
        let quality = |seed| Quality::of_image(&image(&spread, seed, 16));
        let seen: Vec<Quality> = (0..256).map(quality).collect();
        let mean = seen.iter().map(|q| q.mean[1]).sum::<f64>() / 256.0;
        let scatter = seen.iter().map(|q| (q.mean[1] / mean - 1.0).powi(2)).sum::<f64>() / 255.0;
        let told = seen.iter().map(|q| q.relative_standard_error_of_mean.powi(2)).sum::<f64>() / 256.0;
        // At borders more samples are counted for one pixel only, so it is told a little too large.
        assert!((0.85..1.6).contains(&(told / scatter)), "{filter} {told} {scatter}");
    }
}

/// A lamp whose edges lie along rows and columns, and nothing else.
const EDGES: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/><scale x="0.45" y="0.33"/><translate x="0.05" y="0.02" z="4"/></transform>
    <emitter type="area"/></shape>"#;

#[test]
fn the_mean_knows_of_errors_that_all_pixels_share() {
    for (filter, samples) in [(FILTERS[0], 64), (FILTERS[1], 100)] {
        let [_, scene] = scenes(filter, EDGES);
        let render = |seed| {
            let settings = Settings { seed, ..Settings::of(&scene, 0..samples) };
            let (image, report) = render(&scene, &settings, &Progress::default()).expect("it renders");
            (report.quality.expect("it is known"), Quality::of_image(&image))
        };
        let seen: Vec<(Quality, Quality)> = (0..256).map(render).collect();
        let mean = seen.iter().map(|(q, _)| q.mean[1]).sum::<f64>() / 256.0;
        let scatter = seen.iter().map(|(q, _)| (q.mean[1] / mean - 1.0).powi(2)).sum::<f64>() / 255.0;
        let square = |q: &Quality| q.relative_standard_error_of_mean.powi(2) / scatter / 256.0;
        let told: f64 = seen.iter().map(|(q, _)| square(q)).sum();
        let of_pixels: f64 = seen.iter().map(|(_, q)| square(q)).sum();
        // Two standard deviations of the scatter's square are a sixth of it.
        assert!((0.8..1.4).contains(&told), "{filter} {told} {of_pixels}");
        assert!(of_pixels < 0.7, "{filter} {of_pixels}: these edges show nothing");
    }
}

#[test]
fn an_image_tells_that_its_samples_count_for_several_pixels() {
    let [own, spread] = scenes(FILTERS[1], BALL);
    assert_eq!(Correlation::of(&own), Correlation::NONE);
    let [own, spread] = [own, spread].map(|scene| (Correlation::of(&scene), image(&scene, 0, 8)));
    for (correlation, image) in [own, spread] {
        let known = Quality::new(image.crop, correlation, [green(&image)]);
        let told = Quality::of_image(&Image { channels: vec![image.channels[1].clone()], ..image });
        let ratio = told.relative_standard_error_of_mean / known.relative_standard_error_of_mean;
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}

#[test]
fn what_is_not_finite_is_found_in_its_own_pixel_only() {
    // What the lamp emits and what it reflects together are more than single precision holds.
    let lamp = r#"<emitter type="constant"><rgb name="radiance" value="1.6e38"/></emitter>
        <emitter type="directional"><vector name="direction" z="1"/><rgb name="irradiance" value="1.6e38"/></emitter>
        <shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate z="4"/></transform>
            <bsdf type="diffuse"><rgb name="reflectance" value="0.99"/></bsdf>
            <emitter type="area"><rgb name="radiance" value="1.6e38"/></emitter></shape>"#;
    let [_, spread] = scenes(FILTERS[1], lamp);
    let settings = Settings::of(&spread, 0..64);
    let (image, report) = render(&spread, &settings, &Progress::default()).expect("it renders");
    let infinite = |x: u32, y: u32| !image.channels[1].mean[((y - 2) * 12 + x - 1) as usize].is_finite();
    assert!(!report.first_non_finite.is_empty());
    assert!(report.first_non_finite.iter().all(|found| infinite(found.pixel.0, found.pixel.1)));
    // The lamp's outline on the film: its radius over the film's half width, which is seven pixels.
    let radius = 7.0 * (0.5f64 / 4.0).asin().tan() / 20f64.to_radians().tan();
    let distance = |x: u32, y: u32| (f64::from(x) - 7.0).hypot(f64::from(y) - 6.0);
    for (x, y) in (2..11).flat_map(|y| (1..13).map(move |x| (x, y))) {
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| distance(x, y));
        let [nearest, farthest] = [f64::min, f64::max].map(|f| corners.into_iter().reduce(f).unwrap_or(0.0));
        assert!(!infinite(x, y) || nearest < radius, "{x} {y}");
        assert!(infinite(x, y) || farthest > radius, "{x} {y}");
    }
}
