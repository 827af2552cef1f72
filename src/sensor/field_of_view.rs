//! Fields of view, and where a camera may be.

use crate::math::{DVec3, Transform};
use crate::scene::error::SceneError;
use crate::scene::params::Params;
use crate::spelling::shortened;

/// tan of half the horizontal field of view of a picture of this width over height, from `fov` and `fov_axis`
/// or from `focal_length`.
pub fn half_width(params: &mut Params, aspect: f64) -> Result<f64, SceneError> {
    let axes = ["x", "y", "diagonal", "smaller", "larger"];
    let expected = "degrees above 0 and below 180";
    let about = "field of view in degrees; without it `focal_length` holds";
    let fov = params.optional_float_where("fov", about, expected, |v| v > 0.0 && v < 180.0)?;
    let axis = params.word("fov_axis", &axes, "the axis that `fov` is along")?;
    let about = "instead of `fov`: of a lens for 35 mm film; without either it is 50mm";
    let focal = params.string("focal_length", about)?;
    if fov.is_none() && params.has("fov_axis") {
        let message = "`fov_axis` without `fov`: a `focal_length` is along the diagonal";
        return Err(params.error("fov_axis", message, "expected it beside `fov` only"));
    }
    let (half, axis) = match (focal, fov) {
        (Some(place), Some(_)) => {
            let message = "both `fov` and `focal_length`";
            return Err(SceneError::at(&place.value_span, message, "expected one of them"));
        }
        (None, Some(fov)) => (crate::math::transform::half_width(fov), axis),
        (_, None) => {
            let text = focal.map_or("50mm", |a| a.value.as_str()).trim();
            let length = text.strip_suffix("mm").unwrap_or(text);
            let length = crate::scene::params::number(length).filter(|v| *v > 0.0);
            let length = length.ok_or_else(|| {
                let message = format!("`{}` is no focal length", shortened(text));
                params.error("focal_length", message, "expected millimetres, such as 50mm")
            })?;
            // Half the diagonal of a 36 mm × 24 mm frame.
            (0.5 * (36.0f64 * 36.0 + 24.0 * 24.0).sqrt() / length, "diagonal")
        }
    };
    Ok(match axis {
        "y" => half * aspect,
        "smaller" if aspect > 1.0 => half * aspect,
        "larger" if aspect <= 1.0 => half * aspect,
        "diagonal" => half / (1.0 + 1.0 / (aspect * aspect)).sqrt(),
        _ => half,
    })
}

/// Refuses a camera, or another thing of this name, whose transform scales; distances along its rays would not
/// be distances in the world.
pub fn require_rigid(params: &Params, to_world: &Transform, name: &str) -> Result<(), SceneError> {
    /// Matrices written with a few decimals are meant as rotations; Mitsuba's tolerance.
    const TOLERANCE: f64 = 1e-3;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis));
    let scaled = axes.iter().any(|axis| (axis.length_squared() - 1.0).abs() > TOLERANCE);
    if scaled {
        return Err(params.error(
            "to_world",
            format!("{name} cannot be scaled"),
            "expected rotation and translation",
        ));
    }
    Ok(())
}
