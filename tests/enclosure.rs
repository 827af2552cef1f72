//! Inside a luminous sphere that reflects the share ρ of light, the radiance of paths of up to n edges is 1 +
//! ρ + … + ρⁿ⁻¹ in every direction, whatever the method.

use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::spectrum::ColorMode;

const REFLECTANCE: f64 = 0.5;

/// The mean of the image, and its standard error.
fn radiance(integrator: &str) -> (f64, f64) {
    let text = format!(
        r#"<scene version="3.0.0">
            {integrator}
            <sensor type="perspective">
                <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
                <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/>
                    <rfilter type="box"/></film>
            </sensor>
            <shape type="sphere">
                <boolean name="flip_normals" value="true"/>
                <bsdf type="diffuse"><rgb name="reflectance" value="{REFLECTANCE}"/></bsdf>
                <emitter type="area"><rgb name="radiance" value="1"/></emitter>
            </shape>
        </scene>"#
    );
    let scene = load_text("enclosure.xml", &text, ColorMode::Rgb).unwrap();
    let settings = Settings::of(&scene, 0..64);
    let (image, report) = render(&scene, &settings, &Progress::default()).unwrap();
    assert_eq!(report.non_finite, 0);
    let green = image.channel("G").unwrap();
    let n = green.mean.len() as f64;
    let mean = green.mean.iter().map(|&v| v as f64).sum::<f64>() / n;
    let variance = green.variance.iter().flatten().map(|&v| v as f64).sum::<f64>() / (n * n);
    (mean, variance.sqrt())
}

fn series(depth: i32) -> f64 {
    (0..depth).map(|edges| REFLECTANCE.powi(edges)).sum()
}

/// Allows for four standard errors, which may be zero, and for the rounding of `f32`: fails by chance once in
/// 16,000 draws; there are ten, with one seed each.
fn assert_is(integrator: &str, expected: f64) {
    let (mean, error) = radiance(integrator);
    assert!(error < 6e-3, "{integrator}: too noisy to tell, {error}");
    let rounding = expected * f64::from(f32::EPSILON);
    assert!(
        (mean - expected).abs() <= 4.0 * error + rounding,
        "{integrator}: {mean} ± {error}, not {expected}"
    );
}

fn path(parameters: &str) -> String {
    format!(r#"<integrator type="path">{parameters}</integrator>"#)
}

#[test]
fn max_depth_counts_edges() {
    for depth in [2, 3, 5] {
        let limit =
            format!(r#"<integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="100"/>"#);
        assert_is(&path(&limit), series(depth));
    }
    let (mean, _) = radiance(&path(r#"<integer name="max_depth" value="1"/>"#));
    assert_eq!(mean, 1.0);
    let (mean, _) = radiance(&path(r#"<integer name="max_depth" value="0"/>"#));
    assert_eq!(mean, 0.0);
}

#[test]
fn roulette_keeps_the_mean() {
    for depth in [1, 2, 5] {
        assert_is(
            &path(&format!(r#"<integer name="rr_depth" value="{depth}"/>"#)),
            1.0 / (1.0 - REFLECTANCE),
        );
    }
}

#[test]
fn any_number_of_emitter_samples_gives_the_same() {
    assert_is(&path(r#"<integer name="emitter_samples" value="3"/>"#), 1.0 / (1.0 - REFLECTANCE));
    for counts in [(1, 1), (4, 1), (1, 3)] {
        let direct = format!(
            r#"<integrator type="direct"><integer name="emitter_samples" value="{}"/>
                <integer name="bsdf_samples" value="{}"/></integrator>"#,
            counts.0, counts.1
        );
        assert_is(&direct, series(2));
    }
}
