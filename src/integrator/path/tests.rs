//! What no expectation shows: settings that change the noise alone.

use super::LONG;
use super::exchange::Exchange;
use super::receivers::Receivers;
use super::shared::{Receiver, Shared, Source};
use crate::image::Image;
use crate::integrator::{CameraPath, Counters};
use crate::math::frame::unit;
use crate::math::{DVec3, Ray, Transform};
use crate::render::{Progress, Report, Settings, render};
use crate::sampler::{Kind, Sampler};
use crate::scene::load_text;
use crate::spectrum::{ColorMode, Spectrum, Wavelengths};

/// A scene in RGB with so many samples a pixel.
fn rendered(text: &str, samples: u64) -> (Image, Report) {
    let scene = load_text("scene.xml", text, ColorMode::Rgb).unwrap();
    let window = scene.sensor.film.crop;
    let settings = Settings { samples: 0..samples, seed: 0, window, threads: 1, shard: false, kernel: None };
    render(&scene, &settings, &Progress::default()).unwrap()
}

/// The variance of the direct light on a floor under two lamps, one of which it does not see.
fn variance(emitter_samples: u32) -> f64 {
    let lamp = |place: &str| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.3"/>{place}</transform>
                <emitter type="area"/></shape>"#
        )
    };
    let seen = lamp(r#"<rotate x="1" angle="180"/><translate z="1"/>"#);
    let hidden = lamp(r#"<translate z="2"/>"#);
    let text = format!(
        r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="2"/>
                <integer name="emitter_samples" value="{emitter_samples}"/><integer name="reuse" value="1"/></integrator>
            <sensor type="perspective"><float name="fov" value="0.001"/>
                <transform name="to_world"><lookat origin="0, -3, 0.5" target="0, 0, 0" up="0, 0, 1"/></transform>
                <sampler type="independent"/>
                <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/>
                    <rfilter type="box"/></film></sensor>
            <shape type="rectangle"/>{seen}{hidden}</scene>"#
    );
    let (image, _) = rendered(&text, 1024);
    let green = image.channel("G").unwrap();
    green.variance.iter().flatten().map(|&v| f64::from(v)).sum()
}

#[test]
fn eight_emitter_samples_have_an_eighth_of_the_variance() {
    // What sampling the surface adds is a hundredth; each variance is known to one in fifty.
    let ratio = variance(8) / variance(1);
    assert!((ratio - 0.125).abs() < 0.02, "{ratio}");
}

#[test]
fn receivers_share_with_their_like_on_the_side_that_is_matte() {
    let receiver = |x: f64, edges: u32| {
        let (p, n) = (DVec3::new(x, 0.0, 0.0), DVec3::Z);
        Shared {
            receiver: Some(Receiver { p, n, primitive: 0, weight: Spectrum::ONE, lobes: None, edges }),
            ..Shared::NOTHING
        }
    };
    let group = [(-1.0, 0), (-0.5, 1), (0.5, 0), (1.0, 1)].map(|(x, edges)| receiver(x, edges));
    let mut receivers = Receivers::default();
    receivers.begin(&group);
    let mut weights = [0.0; 64];
    let mut facing = |path: usize, n: DVec3| {
        let source = Source { p: DVec3::new(0.0, 0.0, 2.0), n, ng: n, primitive: 1, lobes: None };
        let facing = receivers.weights(path, &source, &mut weights);
        // The cosine at the floor, that at the source, and the distance.
        for (i, x) in [-1.0, -0.5, 0.5, 1.0f64].into_iter().enumerate() {
            let way = DVec3::new(-x, 0.0, 2.0);
            let geometry = (way.z * n.dot(way)).abs() / way.dot(way).powi(2);
            assert!((weights[i] / geometry - 1.0).abs() < 1e-12, "{i}");
        }
        facing
    };
    let ceiling = -DVec3::Z;
    let to_the_left = unit(DVec3::new(-1.0, 0.0, -0.1));
    assert_eq!([0, 1].map(|path| facing(path, ceiling)), [0b0101, 0b1010]);
    assert_eq!([0, 1].map(|path| facing(path, to_the_left)), [0b0001, 0b0010]);
}

/// A ray that ended on its source's surface would be stopped there as often as rounding says, and neighbours would go without.
#[test]
fn sources_do_not_hide_themselves() {
    let axis = DVec3::new(1.0, 2.0, 3.0);
    let turn = Transform::rotate(axis, 25.0).unwrap();
    let placed = |kind: &str, scale: f64, z: f64| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world"><scale value="{scale}"/><translate z="{z}"/>
                <rotate x="1" y="2" z="3" angle="25"/></transform></shape>"#
        )
    };
    // A floor and a ceiling with something beyond both, or no ray would ask them.
    let things =
        [("rectangle", 2.0, 0.0), ("rectangle", 2.0, 2.0), ("sphere", 0.5, -3.0), ("sphere", 0.5, 5.0)];
    let things: String = things.map(|(kind, scale, z)| placed(kind, scale, z)).concat();
    let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{things}</scene>"#);
    let scene = load_text("t", &text, ColorMode::Rgb).unwrap();
    let up = turn.vector(DVec3::Z);
    let part = |i: u32, step: f64| (f64::from(i) * step).fract() - 0.5;
    let camera = CameraPath {
        ray: Ray::free(DVec3::ZERO, DVec3::Z),
        λ: Wavelengths::rgb(),
        sampler: Sampler::new(Kind::Sobol, 0, (0, 0), 0),
        group: 0,
        radiance: Spectrum::ZERO,
        covered: false,
    };
    let mut exchange = Exchange::default();
    for i in 0..1000 {
        let place = |j: u32, z: f64| {
            let i = 8 * i + j;
            turn.point(DVec3::new(2.0 * part(i, 0.618_033_989), 2.0 * part(i, 0.754_877_666), z))
        };
        let group = [0, 1, 2, 3].map(|j| Shared {
            receiver: Some(Receiver {
                p: place(j, 0.0),
                n: up,
                primitive: 0,
                weight: Spectrum::ONE,
                lobes: None,
                edges: 0,
            }),
            source: Some(Source { p: place(j + 4, 2.0), n: -up, ng: -up, primitive: 1, lobes: None }),
            own: Spectrum::ONE,
            radiance: Spectrum::ONE,
        });
        let mut paths = vec![camera; 4];
        exchange.share(&scene, &mut paths, &group, &mut Counters::default());
        // Both cosines are the height over the distance.
        let weight = |receiver: u32, source: u32| {
            (place(source + 4, 2.0) - place(receiver, 0.0)).length_squared().powi(2).recip()
        };
        for receiver in 0..4 {
            let part =
                |source: u32| weight(receiver, source) / (0..4).map(|r| weight(r, source)).sum::<f64>();
            let expected: f64 = (0..4).map(part).sum();
            let found = f64::from(paths[receiver as usize].radiance.0[0]);
            assert!((found - expected).abs() < 1e-6, "{i} {receiver}: {found} for {expected}");
        }
    }
}

/// Alpha of a picture through three surfaces that let all light pass, at every depth of paths.
fn alpha(hide_emitters: bool, surroundings: &str) -> Vec<f32> {
    let pane = |z: f64| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><translate z="{z}"/></transform><bsdf type="null"/></shape>"#
        )
    };
    let panes: String = [1.0, 2.0, 3.0].map(pane).concat();
    let of_depth = |max_depth: u32| {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="{max_depth}"/>
                    <boolean name="hide_emitters" value="{hide_emitters}"/></integrator>
                <sensor type="perspective"><float name="fov" value="1"/><film type="hdrfilm"><string name="pixel_format" value="rgba"/>
                    <integer name="width" value="2"/><integer name="height" value="2"/><rfilter type="box"/></film></sensor>
                {panes}{surroundings}</scene>"#
        );
        let (image, _) = rendered(&text, 4);
        image.channel("A").unwrap().mean.clone()
    };
    (0..=5).flat_map(of_depth).collect()
}

#[test]
fn surroundings_in_view_cover_every_pixel_wherever_the_path_ends() {
    let sky = r#"<emitter type="constant"/>"#;
    let seen = alpha(false, sky);
    // Nothing is looked at with `max_depth` 0, as in Mitsuba.
    assert!(seen[..4].iter().all(|&a| a == 0.0) && seen[4..].iter().all(|&a| a == 1.0), "{seen:?}");
    assert!(alpha(true, sky).iter().all(|&a| a == 0.0));
    assert!(alpha(false, "").iter().all(|&a| a == 0.0));
}

#[test]
fn paths_end_where_nothing_is_absorbed() {
    let white = r#"<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>"#;
    for inside in [white, r#"<bsdf type="conductor"/>"#, r#"<bsdf type="dielectric"/>"#] {
        let text = format!(
            r#"<scene version="3.0.0"><integrator type="path"/>
                <sensor type="perspective"><transform name="to_world"><translate x="0.3" y="0.2" z="0.5"/></transform>
                    <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/></film></sensor>
                <shape type="cube"><bsdf type="twosided"><boolean name="allow_transmission" value="true"/>{inside}</bsdf></shape>
                <emitter type="point"/></scene>"#
        );
        let (image, report) = rendered(&text, 1);
        // In each of 16 pixels a ray and a shadow ray an edge; of the edges after so many, twenty on average.
        assert!(report.cut == 0 && report.rays < 16 * 2 * u64::from(LONG + 1000), "{report:?}");
        assert!(image.channel("G").unwrap().mean.iter().all(|v| v.is_finite()));
    }
}
