//! `<transform>` and the three coordinates of points, vectors and transformation steps.

use super::error::{SceneError, Span};
use super::params::number;
use super::xml::{Attribute, Element};
use crate::math::frame::unit;
use crate::math::{DVec3, Frame, Transform};
use crate::spelling::shortened;
use glam::DMat4;

/// The steps of a `<transform>`, each applied after the one before.
pub fn parse(element: &Element) -> Result<Transform, SceneError> {
    if element.tag != "transform" {
        let message = format!("expected a <transform>, not <{}>", element.tag);
        return Err(SceneError::at(&element.span, message, "expected <transform>"));
    }
    element.only(&["name"])?;
    let mut result = Transform::IDENTITY;
    for step in &element.children {
        result = parse_step(step)?.after(&result);
    }
    if !result.matrix.is_finite() || !result.inverse.is_finite() {
        return Err(SceneError::at(&element.span, "the transform overflows", "expected moderate factors"));
    }
    Ok(result)
}

fn parse_step(step: &Element) -> Result<Transform, SceneError> {
    let singular =
        |what: &str| SceneError::at(&step.span, format!("this <{}> is singular", step.tag), what.to_owned());
    match step.tag.as_str() {
        "translate" => Ok(Transform::translate(coordinates(step, &[], 0.0)?)),
        "scale" => Transform::scale(coordinates(step, &[], 1.0)?)
            .ok_or_else(|| singular("expected factors other than 0")),
        "rotate" => {
            let angle = step.require("angle")?;
            let degrees = number(&angle.value).ok_or_else(|| bad_number(&angle.value_span, &angle.value))?;
            let axis = coordinates(step, &["angle"], 0.0)?;
            Transform::rotate(axis, degrees).ok_or_else(|| singular("expected an axis with a length"))
        }
        "lookat" | "look_at" => {
            step.only(&["origin", "target", "up"])?;
            let point = |name| step.require(name).and_then(triple);
            let (origin, target) = (point("origin")?, point("target")?);
            let up = step.attribute("up").map(triple).transpose()?.filter(|up| *up != DVec3::ZERO);
            // As in Mitsuba: a vector of the frame that the same construction makes about the viewing
            // direction.
            let up = up.unwrap_or_else(|| Frame::about(unit(target - origin)).s);
            Transform::look_at(origin, target, up).ok_or_else(|| {
                singular("expected a target apart from the origin, and `up` not along the view")
            })
        }
        "matrix" => {
            step.only(&["value"])?;
            let value = step.require("value")?;
            // Of sixteen the last four are read and, as in Mitsuba, mean nothing.
            let numbers = numbers(value)?;
            let entries: [f64; 16] = match numbers[..] {
                [a, b, c, d, e, f, g, h, i] => [a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0, 0.0, 0.0, 0.0, 1.0],
                _ => numbers.try_into().map_err(|n: Vec<f64>| {
                    SceneError::at(
                        &value.value_span,
                        format!("`{}` is {} numbers", shortened(&value.value), n.len()),
                        "expected 16 or 9 numbers",
                    )
                })?,
            };
            Transform::from_matrix(DMat4::from_cols_array(&entries).transpose())
                .ok_or_else(|| singular("expected an invertible matrix"))
        }
        other => {
            let steps = ["translate", "rotate", "scale", "lookat", "matrix"];
            Err(SceneError::at(
                &step.span,
                format!("unknown step <{other}>"),
                crate::spelling::known(other, &steps),
            ))
        }
    }
}

/// `x= y= z=` or `value="x, y, z"`; one number in `value` means all three. `rest` stands for coordinates left
/// out; `others` are the attributes besides.
pub fn coordinates(element: &Element, others: &[&str], rest: f64) -> Result<DVec3, SceneError> {
    element.only(&[&["x", "y", "z", "value"], others].concat())?;
    if let Some(value) = element.attribute("value") {
        if let Some(extra) = element.attributes.iter().find(|a| ["x", "y", "z"].contains(&a.name.as_str())) {
            return Err(SceneError::at(
                &extra.name_span,
                "both `value` and coordinates",
                "expected one of them",
            ));
        }
        return triple(value);
    }
    let coordinate = |name| match element.attribute(name) {
        None => Ok(rest),
        Some(a) => number(&a.value).ok_or_else(|| bad_number(&a.value_span, &a.value)),
    };
    Ok(DVec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?))
}

fn triple(attribute: &Attribute) -> Result<DVec3, SceneError> {
    match numbers(attribute)?[..] {
        [x] => Ok(DVec3::splat(x)),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref n => Err(SceneError::at(
            &attribute.value_span,
            format!("`{}` is {} numbers", shortened(&attribute.value), n.len()),
            "expected three numbers, or one for all three",
        )),
    }
}

/// Numbers between commas or blanks.
pub fn numbers(attribute: &Attribute) -> Result<Vec<f64>, SceneError> {
    let words = attribute.value.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
    words.map(|w| number(w).ok_or_else(|| bad_number(&attribute.value_span, w))).collect()
}

fn bad_number(span: &Span, text: &str) -> SceneError {
    SceneError::at(span, format!("`{text}` is no number"), "expected a finite number")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::length;
    use crate::scene::xml;

    /// What the steps of a transform make of (1, 10, 100).
    fn place(steps: &str) -> DVec3 {
        let text =
            format!(r#"<scene version="3.0.0"><transform name="to_world">{steps}</transform></scene>"#);
        let document = xml::read_text("t", &text).unwrap();
        parse(&document.root.children[0]).unwrap().point(DVec3::new(1.0, 10.0, 100.0))
    }

    #[test]
    fn matrices_are_read_row_by_row() {
        let map = place(r#"<matrix value="1 2 0 5  0 1 0 6  0 3 1 7  0 0 0 1"/>"#);
        assert_eq!(map, DVec3::new(26.0, 16.0, 137.0));
        assert_eq!(place(r#"<matrix value="1 2 0  0 1 0  0 3 1"/>"#), DVec3::new(21.0, 10.0, 130.0));
    }

    #[test]
    fn the_last_row_of_a_matrix_is_that_of_an_affine_map() {
        let text = |steps: &str| {
            format!(r#"<scene version="3.0.0"><transform name="to_world">{steps}</transform></scene>"#)
        };
        let read = |steps: &str| parse(&xml::read_text("t", &text(steps)).unwrap().root.children[0]).unwrap();
        let rows = "1 2 0 5  0 1 0 6  0 3 1 7";
        let [plain, odd] = ["0 0 0 1", "1 2 3 4"]
            .map(|row| read(&format!(r#"<matrix value="{rows} {row}"/><translate x="2"/>"#)));
        assert_eq!(plain, odd);
        let p = DVec3::new(1.0, 10.0, 100.0);
        assert!(length(odd.inverted().point(odd.point(p)) - p) < 1e-12);
    }

    #[test]
    fn a_view_without_up_has_one() {
        let view = |up: &str| place(&format!(r#"<lookat origin="1 2 3" target="4 2 9" {up}/>"#));
        assert_eq!(view(r#"up="0 0 0""#), view(""));
    }

    #[test]
    fn steps_apply_in_the_order_in_which_they_are_written() {
        let (move_up, double) = (r#"<translate z="1"/>"#, r#"<scale value="2"/>"#);
        assert_eq!(place(&format!("{move_up}{double}")), DVec3::new(2.0, 20.0, 202.0));
        assert_eq!(place(&format!("{double}{move_up}")), DVec3::new(2.0, 20.0, 201.0));
        // A quarter turn about z takes x to y.
        let turned = place(r#"<rotate z="1" angle="90"/>"#);
        assert!(length(turned - DVec3::new(-10.0, 1.0, 100.0)) < 1e-13, "{turned}");
    }

    #[test]
    fn look_at_places_the_origin_and_looks_along_z() {
        let seen = place(r#"<lookat origin="1 2 3" target="1 2 9" up="0 1 0"/>"#);
        assert!(length(seen - DVec3::new(2.0, 12.0, 103.0)) < 1e-13, "{seen}");
    }
}
