//! A part at the top of a file, used by a reference, means the same as in its place.

use etalon::load_text;
use etalon::render::{Progress, Settings, render};
use etalon::spectrum::ColorMode;

/// The bits of an image of a lamp above a floor; each part is in its place, or at the top with a reference to
/// it.
fn picture(named: bool) -> Vec<u32> {
    let mut top = String::new();
    let mut part = |element: &str, id: &str| {
        if !named {
            return element.to_owned();
        }
        top += &element.replacen(" type=", &format!(" id=\"{id}\" type="), 1);
        format!("<ref id=\"{id}\"/>")
    };
    let filter = part("<rfilter type=\"tent\"/>", "filter");
    let size = "<integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"8\"/>";
    let film = part(&format!("<film type=\"hdrfilm\">{size}{filter}</film>"), "film");
    let sampler = part(
        "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"16\"/></sampler>",
        "sampler",
    );
    let lamp = part("<emitter type=\"area\"><rgb name=\"radiance\" value=\"3, 2, 1\"/></emitter>", "lamp");
    let text = format!(
        r#"<scene version="3.0.0">{top}<sensor type="perspective">{film}{sampler}
                <transform name="to_world"><lookat origin="0, -3, 0.5" target="0, 0, 0.2" up="0, 0, 1"/></transform></sensor>
            <shape type="rectangle"/><shape type="sphere"><point name="center" z="1"/><float name="radius" value="0.3"/>{lamp}</shape></scene>"#
    );
    let scene = load_text("parts.xml", &text, ColorMode::Spectral).unwrap();
    assert_eq!(scene.emitters.list.len(), 1);
    let settings = Settings::of(&scene, 0..16);
    let (image, _) = render(&scene, &settings, &Progress::default()).unwrap();
    image.channels.iter().flat_map(|channel| channel.mean.iter().map(|v| v.to_bits())).collect()
}

#[test]
fn films_filters_samplers_and_lamps_may_stand_at_the_top() {
    let in_place = picture(false);
    assert!(in_place.iter().any(|&bits| bits != 0));
    assert_eq!(in_place, picture(true));
}

#[test]
fn a_lamp_without_a_shape_or_a_name_is_refused() {
    let text = r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="area"/></scene>"#;
    let error = load_text("lamp.xml", text, ColorMode::Rgb).err().unwrap();
    assert!(error.to_string().contains("without a shape"), "{error}");
}
