//! Properties of what is seen, beside the image of another integrator.

use super::{AnyIntegrator, Counters, INTEGRATORS, nested_integrator};
use crate::image::COLOURS;
use crate::image::check_names;
use crate::math::Ray;
use crate::scene::error::{SceneError, known};
use crate::scene::params::{Params, Usage};
use crate::scene::registry::construct;
use crate::scene::{Features, Scene};

pub const NAME: &str = "aov";
pub const ABOUT: &str = "Depth, position, normals and the like as further channels; 0 where nothing is seen.";
pub const EXAMPLES: &[&str] =
    &[r#"<integrator type="aov"><string name="aovs" value="dd:depth,nn:sh_normal"/>
    <integrator type="path"/></integrator>"#];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Property {
    Depth,
    Position,
    Uv,
    GeometricNormal,
    ShadingNormal,
    Tangent,
    PrimitiveIndex,
    ShapeIndex,
}

/// Names in scene files, and the suffixes of the channels.
const PROPERTIES: &[(&str, Property, &[&str])] = &[
    ("depth", Property::Depth, &["T"]),
    ("position", Property::Position, &["X", "Y", "Z"]),
    ("uv", Property::Uv, &["U", "V"]),
    ("geo_normal", Property::GeometricNormal, &["X", "Y", "Z"]),
    ("sh_normal", Property::ShadingNormal, &["X", "Y", "Z"]),
    ("dp_du", Property::Tangent, &["X", "Y", "Z"]),
    ("prim_index", Property::PrimitiveIndex, &["I"]),
    ("shape_index", Property::ShapeIndex, &["I"]),
];

/// Geometry at the first surface, beside what another integrator finds.
#[derive(Clone, Debug)]
pub struct Aov {
    /// What fills the colour channels.
    pub nested: Option<AnyIntegrator>,
    /// What begins the names of that one's channels.
    name: String,
    /// How many channels repeat that one's colours.
    repeated: usize,
    outputs: Vec<(String, Property, &'static [&'static str])>,
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let list = params.string("aovs", "pairs `channel:property`, with commas or blanks between")?;
    let list = list.ok_or_else(|| params.error("aovs", "`aovs` is missing", "expected such as dd:depth"))?;
    let mut outputs: Vec<(String, Property, &'static [&'static str])> = vec![];
    // Blanks about a colon part nothing.
    let pairs = list.value.split(':').map(str::trim).collect::<Vec<_>>().join(":");
    for pair in pairs.split(|c: char| c == ',' || c.is_whitespace()).filter(|p| !p.is_empty()) {
        let (name, kind) = pair.split_once(':').filter(|(name, _)| !name.is_empty()).ok_or_else(|| {
            SceneError::at(&list.value_span, format!("`{pair}` is no pair"), "expected `channel:property`")
        })?;
        let found = PROPERTIES.iter().find(|p| p.0 == kind).ok_or_else(|| {
            let names: Vec<&str> = PROPERTIES.iter().map(|p| p.0).collect();
            SceneError::at(&list.value_span, format!("unknown property `{kind}`"), known(kind, &names))
        })?;
        outputs.push((name.to_owned(), found.1, found.2));
    }
    if outputs.is_empty() {
        return Err(SceneError::at(&list.value_span, "no channel is asked for", "expected such as dd:depth"));
    }
    let (nested, name) = match nested_integrator(params, "what fills the colour channels")? {
        None => (None, String::new()),
        Some((element, name)) => {
            (Some(construct(INTEGRATORS, element, params.loader, Usage::Unbounded)?), name.to_owned())
        }
    };
    let repeated = if nested.as_ref().is_some_and(has_colours) { COLOURS.len() } else { 0 };
    let integrator = AnyIntegrator::Aov(Box::new(Aov { nested, name, repeated, outputs }));
    check_names(&integrator.extra_channels())
        .map_err(|(_, why)| SceneError::at(&list.value_span, why, "expected another name"))?;
    Ok(integrator)
}

/// Whether an integrator fills R, G and B, in whatever way: they come first.
fn has_colours(integrator: &AnyIntegrator) -> bool {
    integrator.has_radiance() || integrator.extra_channels().first().is_some_and(|c| c == COLOURS[0])
}

impl Aov {
    /// See [`AnyIntegrator::without_media`].
    pub fn without_media(self) -> Self {
        Self { nested: self.nested.map(AnyIntegrator::without_media), ..self }
    }

    /// Names of all channels besides the colours, as Mitsuba has them: those that the nested integrator adds
    /// and its colours once more, both under its name, and then those of the aov itself.
    pub fn channels(&self) -> Vec<String> {
        let of_nested = |channel: &str| format!("{}.{channel}", self.name);
        let added = self.nested.as_ref().map(AnyIntegrator::extra_channels).unwrap_or_default();
        let is_colour = |channel: &String| COLOURS.contains(&channel.as_str());
        let mut channels: Vec<String> =
            added.into_iter().map(|c| if is_colour(&c) { c } else { of_nested(&c) }).collect();
        channels.extend(COLOURS.into_iter().take(self.repeated).map(of_nested));
        for (name, _, suffixes) in &self.outputs {
            channels.extend(suffixes.iter().map(|suffix| format!("{name}.{suffix}")));
        }
        channels
    }

    /// How many channels follow those that the nested integrator adds.
    pub fn width(&self) -> usize {
        self.repeated + self.outputs.iter().map(|(.., suffixes)| suffixes.len()).sum::<usize>()
    }

    /// Fills the channels that follow from a sample's others, which are all before: R, G, B first.
    #[inline]
    pub fn complete(&self, values: &mut [f64]) {
        let Some(nested) = &self.nested else { return };
        let (seen, own) = values.split_at_mut(values.len() - self.width());
        nested.complete(seen);
        own[..self.repeated].copy_from_slice(&seen[..self.repeated]);
    }

    pub fn values(&self, scene: &Scene, ray: &Ray, counters: &mut Counters, values: &mut [f64]) {
        counters.rays += 1;
        values.fill(0.0);
        let Some(hit) = scene.accel.closest(ray) else { return };
        let (_, point) = scene.surface::<{ Features::ALL }>(ray, &hit);
        let mut values = values.iter_mut().skip(self.repeated);
        for (_, property, suffixes) in &self.outputs {
            let v = match property {
                Property::Depth => [hit.t, 0.0, 0.0],
                Property::Position => point.p.to_array(),
                Property::Uv => {
                    let uv = scene.shape_of(hit.primitive).0.geometry.file_uv(&point);
                    [uv.x, uv.y, 0.0]
                }
                Property::GeometricNormal => point.ng.to_array(),
                Property::ShadingNormal => point.ns.to_array(),
                Property::Tangent => point.dp_du.to_array(),
                Property::PrimitiveIndex => {
                    let (shape, local) = scene.shape_of(hit.primitive);
                    [f64::from(shape.geometry.mitsuba_primitive(local, &point)), 0.0, 0.0]
                }
                // From 1, for 0 is where nothing is seen.
                Property::ShapeIndex => [scene.shape_index(hit.primitive) as f64 + 1.0, 0.0, 0.0],
            };
            for (value, to) in v.iter().zip(values.by_ref().take(suffixes.len())) {
                *to = *value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::load_text;
    use crate::render::{Progress, Settings, render};
    use crate::scene::trial::ball_of_glass;
    use crate::spectrum::ColorMode;

    /// Channels by name, of a ball of glass seen through this integrator within an `aov`.
    fn rendered(nested: &str) -> (Vec<String>, Vec<Vec<f32>>) {
        // Commas and blanks part, but not blanks about a colon.
        let aovs = r#"<string name="aovs" value="d : depth n:sh_normal,u:uv "/>"#;
        let text = ball_of_glass(&format!(r#"<integrator type="aov">{aovs}{nested}</integrator>"#));
        let scene = load_text("scene.xml", &text, ColorMode::Rgb).unwrap();
        let settings = Settings::of(&scene, 0..4);
        let (image, _) = render(&scene, &settings, &Progress::default()).unwrap();
        image.channels.into_iter().map(|c| (c.name, c.mean)).unzip()
    }

    const OWN: [&str; 6] = ["d.T", "n.X", "n.Y", "n.Z", "u.U", "u.V"];

    #[test]
    fn the_nested_integrator_fills_the_colours_and_repeats_them_under_its_name() {
        let path = r#"<integrator type="path" name="image">
            <float name="light_paths" value="8"/></integrator>"#;
        for nested in [path, r#"<integrator type="depth" name="image"/>"#] {
            let (names, means) = rendered(nested);
            assert_eq!(names, [&["R", "G", "B", "image.R", "image.G", "image.B"][..], &OWN].concat());
            assert_eq!(means[..3], means[3..6]);
            assert!(means[..3].iter().flatten().any(|v| *v > 0.0));
        }
        assert_eq!(rendered("").0, OWN);
    }

    #[test]
    fn channels_that_the_nested_integrator_adds_are_under_its_name() {
        let (names, means) = rendered(
            r#"<integrator type="aov" name="in"><string name="aovs" value="d:depth"/><integrator type="path"/></integrator>"#,
        );
        let added = ["in._arg_0.R", "in._arg_0.G", "in._arg_0.B", "in.d.T", "in.R", "in.G", "in.B"];
        assert_eq!(names, [&["R", "G", "B"][..], &added, &OWN].concat());
        assert_eq!([&means[..3], &means[6..7]].concat(), [&means[3..6], &means[10..11]].concat());
        assert_eq!(means[..3], means[7..10]);
    }
}
