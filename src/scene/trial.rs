//! Scenes for tests of several modules.

/// A ball of glass under a lamp, so that light paths take part, seen by this integrator on 8 × 6 pixels.
pub fn ball_of_glass(integrator: &str) -> String {
    format!(
        r#"<scene version="3.0.0">{integrator}
        <sensor type="perspective"><transform name="to_world"><lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
            <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/><rfilter type="box"/></film></sensor>
        <shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/><translate y="-1"/></transform></shape>
        <shape type="sphere"><float name="radius" value="0.7"/><bsdf type="dielectric"/></shape>
        <shape type="rectangle"><transform name="to_world"><scale value="0.2"/><rotate x="1" angle="90"/><translate y="3"/></transform>
            <emitter type="area"><rgb name="radiance" value="90, 60, 30"/></emitter></shape>
        </scene>"#
    )
}
