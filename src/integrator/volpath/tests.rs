use crate::load_text;
use crate::render::{Progress, Settings, render};
use crate::scene::trial::ball_of_glass;
use crate::spectrum::ColorMode;

/// The colours of an image, pixel by pixel.
fn colours(text: &str, mode: ColorMode, samples: u64) -> Vec<[f64; 3]> {
    let scene = load_text("scene.xml", text, mode).unwrap();
    let (image, _) = render(&scene, &Settings::of(&scene, 0..samples), &Progress::default()).unwrap();
    let channel = |name: &str| image.channels.iter().find(|c| c.name == name).unwrap();
    let [r, g, b] = ["R", "G", "B"].map(channel);
    (0..r.mean.len()).map(|i| [r, g, b].map(|c| f64::from(c.mean[i]))).collect()
}

#[test]
fn without_media_it_is_path() {
    for within in ["", r#"<integer name="max_depth" value="4"/><boolean name="hide_emitters" value="true"/>"#]
    {
        let by = |name: &str| {
            let integrator = format!(r#"<integrator type="{name}">{within}</integrator>"#);
            colours(&ball_of_glass(&integrator), ColorMode::Spectral, 4)
        };
        assert_eq!(by("volpath"), by("path"));
        assert_eq!(by("volpathmis"), by("path"));
    }
}

/// A camera that sees nothing but a ball that fills its film, in surroundings of radiance 1.
fn ball(wears: &str) -> String {
    format!(
        r#"<scene version="3.0.0"><integrator type="volpath"/><emitter type="constant"/>
        <sensor type="perspective"><float name="fov" value="10"/>
            <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="2"/><integer name="height" value="2"/><rfilter type="box"/></film>
        </sensor><shape type="sphere">{wears}</shape></scene>"#
    )
}

/// Where nothing is absorbed, surroundings of radiance 1 show radiance 1, whatever is in them: emission,
/// emitter samples, phase functions and flights have to agree.
#[test]
fn white_media_vanish_in_a_furnace() {
    let white = r#"<medium type="homogeneous" name="interior"><float name="albedo" value="1"/>
        <spectrum name="sigma_t" value="400:4, 700:0.5"/><phase type="hg"><float name="g" value="0.4"/></phase></medium>"#;
    for (surface, margin) in [
        (r#"<bsdf type="null"/>"#, 0.01),
        (r#"<bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="null"/></bsdf>"#, 0.01),
        (r#"<bsdf type="thindielectric"/>"#, 0.015),
        (r#"<bsdf type="dielectric"/>"#, 0.02),
    ] {
        for mode in [ColorMode::Spectral, ColorMode::Rgb] {
            let image = colours(&ball(&format!("{surface}{white}")), mode, 4096);
            let mean = image.iter().flatten().sum::<f64>() / (3 * image.len()) as f64;
            // What surroundings of radiance 1 show by themselves.
            let plain = colours(&ball(r#"<bsdf type="null"/>"#), mode, 4096);
            let expected = plain.iter().flatten().sum::<f64>() / (3 * plain.len()) as f64;
            assert!((mean / expected - 1.0).abs() < margin, "{surface} {}: {mean} {expected}", mode.name());
        }
    }
}

/// Emitter samples and phase functions find the same light, alone and together.
#[test]
fn emitter_samples_change_no_mean() {
    let medium = |samples: bool| {
        format!(
            r#"<bsdf type="null"/><medium type="homogeneous" name="interior"><float name="sigma_t" value="2"/>
            <boolean name="sample_emitters" value="{samples}"/></medium>"#
        )
    };
    let mean = |samples: bool| {
        let image = colours(&ball(&medium(samples)), ColorMode::Rgb, 1 << 13);
        image.iter().flatten().sum::<f64>() / (3 * image.len()) as f64
    };
    let (with, without) = (mean(true), mean(false));
    assert!((with / without - 1.0).abs() < 0.01, "{with} {without}");
}

/// A medium is on the side of the surface that the file says, whichever way the normal points.
#[test]
fn media_are_on_their_side() {
    let black = |name: &str, flipped: bool| {
        format!(
            r#"<bsdf type="null"/><boolean name="flip_normals" value="{flipped}"/>
            <medium type="homogeneous" name="{name}"><float name="albedo" value="0"/></medium>"#
        )
    };
    // The rays go nearly 2 through the middle of the ball.
    for (name, flipped) in [("interior", false), ("exterior", true)] {
        for [r, g, b] in colours(&ball(&black(name, flipped)), ColorMode::Rgb, 16) {
            let passed = [(-2.0f64).exp(), (-1.9f64).exp()];
            assert!([r, g, b].iter().all(|v| (passed[0]..passed[1]).contains(v)), "{name} {r}");
        }
    }
}

/// Passing an invisible surface is no edge: what is behind is lit by paths of two.
#[test]
fn invisible_surfaces_are_no_edges() {
    let matte = r#"<shape type="sphere"><float name="radius" value="0.8"/></shape>"#;
    let lit = |shells: &str| {
        let shown = ball(r#"<bsdf type="null"/>"#).replace("</scene>", &format!("{matte}{shells}</scene>"));
        let two = r#"<integrator type="volpath"><integer name="max_depth" value="2"/></integrator>"#;
        colours(&shown.replace(r#"<integrator type="volpath"/>"#, two), ColorMode::Rgb, 1024)
    };
    for [r, g, b] in lit("")
        .into_iter()
        .chain(lit(r#"<shape type="sphere"><float name="radius" value="2"/><bsdf type="null"/></shape>"#))
    {
        assert!([r, g, b].iter().all(|v| (v - 0.5).abs() < 0.02), "{r} {g} {b}");
    }
}

/// Red, green and blue underflow on the way to the inner ball; what RGB mode leaves empty must not go on.
#[test]
fn paths_end_where_nothing_comes_through() {
    let ink = |place: &str| {
        format!(
            r#"<medium type="homogeneous" name="{place}"><rgb name="sigma_t" value="300, 310, 320"/>
            <float name="albedo" value="0"/></medium>"#
        )
    };
    let inner = format!(
        r#"<shape type="sphere"><float name="radius" value="0.5"/><bsdf type="null"/>{}
        <medium type="homogeneous" name="interior"><rgb name="sigma_t" value="1, 1, 1.5"/></medium></shape></scene>"#,
        ink("exterior")
    );
    let text = ball(&format!(r#"<bsdf type="null"/>{}"#, ink("interior"))).replace("</scene>", &inner);
    let image = colours(&text, ColorMode::Rgb, 64);
    assert!(image.iter().flatten().all(|v| *v == 0.0), "{image:?}");
}
