use crate::load;
use crate::scene::{Overrides, Scene};
use crate::spectrum::ColorMode;

const SENSOR: &str = r#"<sensor type="perspective"/>"#;

/// A scene with these objects, loaded with what a command line says.
fn loaded(objects: &str, overrides: &Overrides) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, format!(r#"<scene version="3.0.0">{objects}</scene>"#)).unwrap();
    load(&path, &[], ColorMode::Spectral, overrides).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn settings_reach_the_integrator_within_others() {
    let aov = r#"<integrator type="aov"><string name="aovs" value="d:depth"/>"#;
    let path = r#"<integrator type="path"><integer name="max_depth" value="9"/></integrator>"#;
    let overrides = Overrides {
        max_depth: Some(3),
        light_paths: Some(2.0),
        reuse: Some(16),
        shared_light_paths: Some(4),
        links: Some("never".into()),
        ..Overrides::default()
    };
    for integrator in [
        String::new(),
        path.into(),
        format!("{aov}{path}</integrator>"),
        format!(r#"<integrator type="moment">{aov}{path}</integrator></integrator>"#),
    ] {
        let scene = loaded(&[SENSOR, &integrator].concat(), &overrides);
        let path = scene.integrator.path().expect(&integrator);
        assert_eq!((path.lengths.max_depth, path.light_paths, path.reuse), (3, 2.0, 16), "{integrator}");
        assert_eq!(path.shared_light_paths, 4, "{integrator}");
    }
}

#[test]
fn what_path_alone_has_is_refused_by_the_option() {
    let text = format!(r#"<scene version="3.0.0">{SENSOR}<integrator type="volpath"/></scene>"#);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, text).unwrap();
    let overrides = Overrides { light_paths: Some(1.0), ..Overrides::default() };
    let error = load(&file, &[], ColorMode::Spectral, &overrides).err().map(|error| error.to_string());
    let error = error.unwrap_or_default();
    assert!(error.contains("--light-paths is for the integrator `path`, and this is `volpath`"), "{error}");
}

#[test]
fn film_and_sampler_that_are_referred_to_are_those_that_change() {
    let overrides = Overrides {
        size: Some((5, 3)),
        seed: Some(7),
        sampler: Some("independent".into()),
        ..Overrides::default()
    };
    let objects = r#"<film type="hdrfilm" id="f"><integer name="width" value="40"/><integer name="crop_width" value="9"/></film>
        <sampler type="sobol" id="s"><integer name="sample_count" value="12"/></sampler>
        <alias id="s" as="alias"/>"#;
    for sensor in [
        r#"<sensor type="perspective"><ref id="f"/><ref name="sampler" id="s"/></sensor>"#,
        r#"<sensor type="perspective"><ref id="f"/><ref id="alias"/></sensor>"#,
        SENSOR,
    ] {
        let sensor = loaded(&[sensor, objects].concat(), &overrides).sensor;
        assert_eq!((sensor.film.size, sensor.film.crop.width, sensor.sampler.seed), ((5, 3), 5, 7));
        assert_eq!(sensor.sampler.kind, crate::sampler::SamplerKind::Independent);
    }
}

#[test]
fn overrides_reach_a_sensor_within_a_shape() {
    let overrides = Overrides { seed: Some(7), sampler: Some("independent".into()), ..Overrides::default() };
    let sensor = r#"<sensor type="irradiancemeter"><film type="hdrfilm" id="f"><integer name="width" value="1"/>
        <integer name="height" value="1"/></film></sensor>"#;
    for objects in [
        format!(r#"<shape type="sphere" id="s">{sensor}</shape>"#),
        format!(r#"<shape type="sphere">{sensor}</shape>{SENSOR}"#),
    ] {
        let sensor = loaded(&objects, &overrides).sensor;
        assert_eq!((sensor.camera.name(), sensor.sampler.seed), ("irradiancemeter", 7));
        assert_eq!(sensor.sampler.kind, crate::sampler::SamplerKind::Independent);
    }
}

#[test]
fn another_sensor_may_be_chosen() {
    let sensor = |size: u32| {
        format!(
            r#"<sensor type="perspective" id="s{size}"><film type="hdrfilm"><integer name="width" value="{size}"/>
            <integer name="height" value="{size}"/></film></sensor>"#
        )
    };
    let meter = r#"<shape type="sphere"><sensor type="irradiancemeter"/></shape>"#;
    let objects =
        [sensor(2), r#"<shape type="sphere"/>"#.into(), sensor(3), meter.into(), sensor(4)].concat();
    let size = |sensor| loaded(&objects, &Overrides { sensor, ..Overrides::default() }).sensor.film.size.0;
    assert_eq!([None, Some(0), Some(1), Some(2), Some(3)].map(size), [2, 2, 3, 1, 4]);
    let mut document =
        crate::scene::xml::read_text("scene.xml", &format!(r#"<scene version="3.0.0">{objects}</scene>"#))
            .unwrap();
    let overrides = Overrides { sensor: Some(4), ..Overrides::default() };
    let refused = super::apply(&mut document, &overrides).unwrap_err().to_string();
    assert!(refused.contains("no sensor number 4") && refused.contains("0 to 3"), "{refused}");
}

#[test]
fn what_the_file_says_already_leaves_its_hash() {
    let objects = r#"<integrator type="path"><integer name="max_depth" value="5"/><integer name="rr_depth" value="9"/></integrator>
        <sensor type="perspective"><sampler type="sobol"><integer name="seed" value="7"/><integer name="sample_count" value="4"/></sampler>
            <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/><rfilter type="box"/></film></sensor>"#;
    let hash = |overrides: &Overrides| loaded(objects, overrides).hash;
    let own = Overrides {
        size: Some((40, 30)),
        seed: Some(7),
        max_depth: Some(5),
        sampler: Some("sobol".into()),
        ..Overrides::default()
    };
    let plain = hash(&Overrides::default());
    assert_eq!(hash(&own), plain);
    for other in [
        Overrides { size: Some((40, 31)), ..Overrides::default() },
        Overrides { seed: Some(8), ..Overrides::default() },
        Overrides { max_depth: Some(6), ..Overrides::default() },
    ] {
        assert_ne!(hash(&other), plain, "{other:?}");
    }
}
