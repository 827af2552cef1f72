//! Small scenes that together use every feature that affects how an image is computed.

use etalon::spectrum::ColorMode;

/// Factors on the units of light and of length.
#[derive(Clone, Copy)]
pub struct Units {
    /// Factor on all radiances and intensities.
    pub light: f64,
    /// Factor on all lengths.
    pub length: f64,
}

impl Default for Units {
    fn default() -> Self {
        Self { light: 1.0, length: 1.0 }
    }
}

/// A scene without its units: `L(…)` encloses lists of radiances, `X(…)` lists of lengths, `P(…)` what is per
/// length, and `{place}` is at the end of every shape's transform. With media in it, `volpath` renders it.
pub struct Trial {
    pub name: &'static str,
    pub mode: ColorMode,
    /// Further options of the integrator.
    options: &'static str,
    camera: &'static str,
    filter: &'static str,
    sampler: &'static str,
    content: &'static str,
}

const CAMERA: &str = r#"type="perspective">"#;
const LENS: &str = r#"type="thinlens"><float name="aperture_radius" value="X(0.125)"/><float name="focus_distance" value="X(4)"/>"#;

const LAMP: &str = r#"
<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="1.9"/>{place}</transform>
  <emitter type="area"><rgb name="radiance" value="L(9, 7, 4)"/></emitter></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/><translate y="-1"/>{place}</transform>
  <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.3"/></bsdf></shape>"#;

pub const SCENES: &[Trial] = &[
    Trial {
        name: "diffuse box",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/>{place}</transform>
          <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.6, 0.3"/></bsdf></bsdf></shape>
          <shape type="disk"><transform name="to_world"><translate x="0.7" z="2"/>{place}</transform></shape>"#,
    },
    Trial {
        name: "media",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.7"/><translate x="-0.8"/>{place}</transform>
          <bsdf type="null"/><medium type="homogeneous" name="interior"><rgb name="albedo" value="0.9, 0.7, 0.5"/>
          <spectrum name="sigma_t" value="400:2, 700:0.5"/><float name="scale" value="P(1.5)"/><phase type="hg"/></medium></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.6"/><translate x="0.8" z="0.5"/>{place}</transform>
          <bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="dielectric"/></bsdf>
          <medium type="heterogeneous" name="interior"><volume type="constvolume" name="sigma_t"><float name="value" value="2"/>
          <transform name="to_world"><rotate y="1" angle="20"/><translate x="0.5" y="-0.5"/>{place}</transform></volume>
          <float name="scale" value="P(1)"/></medium></shape>"#,
    },
    Trial {
        name: "many lamps",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.2"/><translate x="-1"/>{place}</transform>
          <emitter type="area"><rgb name="radiance" value="L(8, 2, 4)"/></emitter></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.1"/><rotate y="1" angle="30"/><translate x="1" y="-0.5"/>{place}</transform>
          <emitter type="area"><rgb name="radiance" value="L(4, 8, 16)"/></emitter></shape>
          <shape type="cylinder"><transform name="to_world"><scale value="0.1"/><translate y="0.5" z="-1"/>{place}</transform>
          <emitter type="area"><rgb name="radiance" value="L(1, 2, 8)"/></emitter></shape>
          <emitter type="constant"><rgb name="radiance" value="L(0.25, 0.5, 1)"/></emitter>
          <shape type="disk"><transform name="to_world"><scale value="0.7"/><rotate x="1" angle="20"/>{place}</transform></shape>"#,
    },
    Trial {
        name: "mirror and glass through a lens",
        mode: ColorMode::Spectral,
        options: "",
        camera: LENS,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.6"/><translate x="-0.7"/>{place}</transform>
          <bsdf type="dielectric"/></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.6"/><translate x="0.7"/>{place}</transform>
          <bsdf type="conductor"/></shape>"#,
    },
    Trial {
        name: "textured plastic",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.8"/>{place}</transform>
          <bsdf type="roughplastic"><float name="alpha" value="0.2"/><texture name="diffuse_reflectance" type="checkerboard">
          <transform name="to_uv"><scale x="6" y="3"/></transform></texture></bsdf></shape>"#,
    },
    Trial {
        name: "brushed metal in the open",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<emitter type="constant"><rgb name="radiance" value="L(0.25, 0.5, 1)"/></emitter>
          <shape type="cylinder"><transform name="to_world"><scale value="0.5"/><rotate x="1" angle="70"/>{place}</transform>
          <bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha_u" value="0.4"/><float name="alpha_v" value="0.05"/>
          <string name="material" value="Cu"/></bsdf></bsdf></shape>"#,
    },
    Trial {
        name: "dispersive glass",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.9"/>{place}</transform>
          <bsdf type="dielectric"><spectrum name="int_ior" value="400:1.7, 550:1.6, 700:1.5"/></bsdf></shape>"#,
    },
    Trial {
        name: "mesh under a gaussian filter",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="gaussian""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="cube"><transform name="to_world"><scale value="0.6"/><rotate x="1" y="1" angle="40"/>{place}</transform>
          <bsdf type="roughdielectric"><float name="alpha" value="0.3"/></bsdf></shape>"#,
    },
    Trial {
        name: "independent numbers",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="mitchell""#,
        sampler: "independent",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.7"/>{place}</transform>
          <bsdf type="mask"><float name="opacity" value="0.5"/><bsdf type="plastic"/></bsdf></shape>"#,
    },
    Trial {
        name: "three colours",
        mode: ColorMode::Rgb,
        options: "",
        camera: LENS,
        filter: r#"type="tent""#,
        sampler: "independent",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.7"/>{place}</transform>
          <bsdf type="blendbsdf"><float name="weight" value="0.25"/><bsdf type="plastic"/><bsdf type="diffuse"/></bsdf></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.2"/><translate x="1.2" y="0.5"/>{place}</transform>
          <emitter type="area"><rgb name="radiance" value="L(1, 2, 8)"/></emitter></shape>"#,
    },
    Trial {
        name: "instances with inclined normals",
        mode: ColorMode::Spectral,
        options: "",
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="shapegroup" id="pair"><shape type="sphere"><transform name="to_world"><scale value="0.5"/></transform>
          <bsdf type="normalmap"><rgb name="normalmap" value="0.6, 0.45, 0.9"/><bsdf type="plastic"/></bsdf></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.25"/><translate x="0.75"/></transform></shape></shape>
          <shape type="instance"><ref id="pair"/><transform name="to_world"><rotate z="1" angle="30"/>{place}</transform></shape>
          <shape type="instance"><ref id="pair"/><transform name="to_world"><scale x="-0.5" y="0.75" z="0.5"/><translate x="-1"/>{place}</transform></shape>"#,
    },
    Trial {
        name: "guided through glass",
        mode: ColorMode::Spectral,
        options: r#"<string name="links" value="guided"/>"#,
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="cube"><transform name="to_world"><scale value="0.6"/><rotate y="1" angle="30"/>{place}</transform>
          <bsdf type="dielectric"/></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.4"/>{place}</transform></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.4"/><translate x="1.3"/>{place}</transform><bsdf type="conductor"/></shape>"#,
    },
    Trial {
        name: "shared paths around glass",
        mode: ColorMode::Spectral,
        options: r#"<integer name="reuse" value="8"/>"#,
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate x="-0.7"/>{place}</transform>
          <bsdf type="dielectric"/></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/><translate x="0.7"/>{place}</transform>
          <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.6, 0.3"/></bsdf></shape>"#,
    },
    Trial {
        name: "shared paths between textures",
        mode: ColorMode::Rgb,
        options: r#"<integer name="reuse" value="32"/><integer name="rr_depth" value="2"/>"#,
        camera: LENS,
        filter: r#"type="gaussian""#,
        sampler: "independent",
        content: r#"{lamp}<emitter type="constant"><rgb name="radiance" value="L(0.25, 0.5, 1)"/></emitter>
          <shape type="sphere"><transform name="to_world"><scale value="0.8"/>{place}</transform>
          <bsdf type="diffuse"><texture name="reflectance" type="checkerboard">
          <transform name="to_uv"><scale x="6" y="3"/></transform></texture></bsdf></shape>"#,
    },
    Trial {
        name: "shared paths and samples",
        mode: ColorMode::Spectral,
        options: r#"<integer name="reuse" value="0"/>"#,
        camera: CAMERA,
        filter: r#"type="tent""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="cube"><transform name="to_world"><scale value="6"/>{place}</transform><boolean name="flip_normals" value="true"/>
          <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.7, 0.8"/></bsdf></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate x="-0.7"/>{place}</transform></shape>"#,
    },
    Trial {
        name: "samples that count for several pixels",
        mode: ColorMode::Spectral,
        options: r#"<integer name="reuse" value="0"/>"#,
        camera: LENS,
        filter: r#"type="gaussian""#,
        sampler: "sobol",
        // Nothing here could be shared.
        content: r#"<emitter type="constant"><rgb name="radiance" value="L(0.25, 0.5, 1)"/></emitter>
          <shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate x="-0.7"/>{place}</transform>
          <bsdf type="plastic"/></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/><translate x="0.7"/>{place}</transform>
          <bsdf type="conductor"/></shape>"#,
    },
    Trial {
        name: "shared light paths",
        mode: ColorMode::Spectral,
        options: r#"<integer name="reuse" value="16"/><integer name="shared_light_paths" value="4"/>"#,
        camera: CAMERA,
        filter: r#"type="box""#,
        sampler: "sobol",
        content: r#"{lamp}<shape type="cube"><transform name="to_world"><scale value="6"/>{place}</transform><boolean name="flip_normals" value="true"/>
          <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.5, 0.6"/></bsdf></shape>
          <shape type="sphere"><transform name="to_world"><scale value="0.5"/><translate x="-0.7"/>{place}</transform>
          <bsdf type="roughconductor"><float name="alpha" value="0.3"/></bsdf></shape>
          <shape type="cube"><transform name="to_world"><scale value="0.5"/><rotate y="1" angle="30"/><translate x="0.7"/>{place}</transform>
          <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.6, 0.3"/></bsdf></shape>"#,
    },
];

impl Trial {
    /// The scene file. Products with a power of two are exact, and printed so that reading gives the same
    /// number.
    pub fn text(&self, units: Units) -> String {
        let frame = format!(
            r#"<scene version="3.0.0"><integrator type="{integrator}"><integer name="max_depth" value="7"/>{options}</integrator>
<sensor {camera}<float name="fov" value="45"/><float name="near_clip" value="X(0.0625)"/><float name="far_clip" value="X(64)"/>
<transform name="to_world"><lookat origin="X(0.25, 0.75, -4)" target="X(0, 0, 0)" up="0, 1, 0"/></transform>
<sampler type="{sampler}"><integer name="sample_count" value="4"/></sampler>
<film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="20"/><rfilter {filter}/></film></sensor>
{content}
</scene>
"#,
            integrator = if self.content.contains("<medium") { "volpath" } else { "path" },
            options = self.options,
            camera = self.camera,
            sampler = self.sampler,
            filter = self.filter,
            content = self.content.replace("{lamp}", LAMP),
        );
        let placed = frame.replace("{place}", &format!(r#"<scale value="{}"/>"#, units.length));
        let scales = [("\"L(", units.light), ("\"X(", units.length), ("\"P(", 1.0 / units.length)];
        scales.into_iter().fold(placed, |text, (open, factor)| scaled(&text, open, factor))
    }
}

/// Multiplies the numbers in every list that begins with `open`.
fn scaled(text: &str, open: &str, factor: f64) -> String {
    let mut pieces = text.split(open);
    let mut result = pieces.next().unwrap_or("").to_owned();
    for piece in pieces {
        let (list, rest) = piece.split_once(')').expect("a closing bracket");
        let numbers =
            list.split(',').map(|n| (n.trim().parse::<f64>().expect("a number") * factor).to_string());
        result.push('"');
        result.push_str(&numbers.collect::<Vec<_>>().join(", "));
        result.push_str(rest);
    }
    result
}
