//! Properties of what is seen, beside the image of another integrator.

use super::{AnyIntegrator, Counters, INTEGRATORS};
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

#[derive(Clone, Debug)]
pub struct Aov {
    /// What fills the colour channels.
    pub nested: Option<AnyIntegrator>,
    outputs: Vec<(String, Property, &'static [&'static str])>,
}

pub fn parse(params: &mut Params) -> Result<AnyIntegrator, SceneError> {
    let list = params.string("aovs", "pairs `channel:property`, with commas between")?;
    let list = list.ok_or_else(|| params.error("aovs", "`aovs` is missing", "expected such as dd:depth"))?;
    let mut outputs: Vec<(String, Property, &'static [&'static str])> = vec![];
    for pair in list.value.split(',').map(str::trim).filter(|p| !p.is_empty()) {
        let (name, kind) = pair.split_once(':').ok_or_else(|| {
            SceneError::at(&list.value_span, format!("`{pair}` is no pair"), "expected `channel:property`")
        })?;
        let found = PROPERTIES.iter().find(|p| p.0 == kind.trim()).ok_or_else(|| {
            let names: Vec<&str> = PROPERTIES.iter().map(|p| p.0).collect();
            SceneError::at(&list.value_span, format!("unknown property `{kind}`"), known(kind, &names))
        })?;
        outputs.push((name.to_owned(), found.1, found.2));
    }
    if outputs.is_empty() {
        return Err(SceneError::at(&list.value_span, "no channel is asked for", "expected such as dd:depth"));
    }
    let nested = match params.object("integrator", "what fills the colour channels")? {
        None => None,
        Some(element) => Some(construct(INTEGRATORS, element, params.loader, Usage::Unbounded)?),
    };
    let integrator = AnyIntegrator::Aov(Box::new(Aov { nested, outputs }));
    check_names(&integrator.extra_channels())
        .map_err(|(_, why)| SceneError::at(&list.value_span, why, "expected another name"))?;
    Ok(integrator)
}

impl Aov {
    pub fn channels(&self) -> Vec<String> {
        let of = |(name, _, suffixes): &(String, Property, &'static [&'static str])| {
            suffixes.iter().map(|s| format!("{name}.{s}")).collect::<Vec<_>>()
        };
        self.outputs.iter().flat_map(of).collect()
    }

    /// How many channels these are.
    pub fn width(&self) -> usize {
        self.outputs.iter().map(|(.., suffixes)| suffixes.len()).sum()
    }

    pub fn values(&self, scene: &Scene, ray: &Ray, counters: &mut Counters, values: &mut [f64]) {
        counters.rays += 1;
        values.fill(0.0);
        let Some(hit) = scene.accel.closest(ray) else { return };
        let (shape, point) = scene.surface::<{ Features::ALL }>(ray, &hit);
        let mut values = values.iter_mut();
        for (_, property, suffixes) in &self.outputs {
            let v = match property {
                Property::Depth => [hit.t, 0.0, 0.0],
                Property::Position => point.p.to_array(),
                Property::Uv => [point.uv.x, point.uv.y, 0.0],
                Property::GeometricNormal => point.ng.to_array(),
                Property::ShadingNormal => point.ns.to_array(),
                Property::Tangent => point.dp_du.to_array(),
                Property::PrimitiveIndex => {
                    let (shape, local) = scene.shape_of(hit.primitive);
                    [f64::from(shape.geometry.mitsuba_primitive(local, &point)), 0.0, 0.0]
                }
                // From 1, for 0 is where nothing is seen.
                Property::ShapeIndex => [scene.index_of(shape) as f64 + 1.0, 0.0, 0.0],
            };
            for (value, to) in v.iter().zip(values.by_ref().take(suffixes.len())) {
                *to = *value;
            }
        }
    }
}
