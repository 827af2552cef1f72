//! Affine maps with their inverses.

use super::frame::unit;
use super::function::{sincos, tan};
use glam::{DMat4, DVec3, DVec4};

/// An affine map and its inverse; the last row of both is 0, 0, 0, 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    pub matrix: DMat4,
    pub inverse: DMat4,
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, inverse: DMat4::IDENTITY };

    /// From a matrix, whose last row is taken for 0, 0, 0, 1; `None` if it is singular or not finite.
    pub fn from_matrix(matrix: DMat4) -> Option<Self> {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| matrix.col(i).truncate());
        let matrix = DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), w.extend(1.0));
        let inverse = matrix.inverse();
        let usable = matrix.is_finite() && inverse.is_finite() && matrix.determinant() != 0.0;
        usable.then_some(Self { matrix, inverse })
    }

    /// The rotation, or mirroring, that takes the axes to directions next to these: along the first, in the plane of it
    /// and the second, and across both.
    pub fn of_axes([x, y, z]: [DVec3; 3]) -> Option<Self> {
        let x = unit(x);
        let y = unit(y - x * x.dot(y));
        let across = x.cross(y);
        let z = if across.dot(z) < 0.0 { -across } else { across };
        Self::from_matrix(DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), DVec4::W))
    }

    /// Moves points by a vector.
    pub fn translate(by: DVec3) -> Self {
        Self { matrix: DMat4::from_translation(by), inverse: DMat4::from_translation(-by) }
    }

    /// Scaling along the axes; `None` if a factor is zero.
    pub fn scale(by: DVec3) -> Option<Self> {
        let usable = by.cmpne(DVec3::ZERO).all() && by.is_finite();
        usable.then(|| Self { matrix: DMat4::from_scale(by), inverse: DMat4::from_scale(by.recip()) })
    }

    /// Rotation about `axis` by an angle in degrees (Rodrigues); `None` if the axis has no length.
    pub fn rotate(axis: DVec3, degrees: f64) -> Option<Self> {
        let k = axis.try_normalize()?;
        let (sin, cos) = sincos(degrees.to_radians());
        let column = |e: DVec3| (e * cos + k.cross(e) * sin + k * (k.dot(e) * (1.0 - cos))).extend(0.0);
        let matrix = DMat4::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z), DVec4::W);
        Some(Self { matrix, inverse: matrix.transpose() })
    }

    /// Mitsuba's camera frame: at `origin`, looking along +z at `target`, +x to the left of `up`.
    /// `None` if the three do not span a plane.
    pub fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> Option<Self> {
        let forward = (target - origin).try_normalize()?;
        let left = up.cross(forward).try_normalize()?;
        let up = forward.cross(left);
        Self::from_matrix(DMat4::from_cols(
            left.extend(0.0),
            up.extend(0.0),
            forward.extend(0.0),
            origin.extend(1.0),
        ))
    }

    /// `self` after `first`.
    pub fn after(&self, first: &Self) -> Self {
        Self { matrix: self.matrix * first.matrix, inverse: first.inverse * self.inverse }
    }

    /// The map back.
    pub fn inverted(&self) -> Self {
        Self { matrix: self.inverse, inverse: self.matrix }
    }

    /// Maps a point.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.matrix.transform_point3(p)
    }

    /// Maps a vector: translations do not move it, and its length is scaled.
    #[inline]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.matrix.transform_vector3(v)
    }

    /// Transforms a normal, by the inverse transpose; the result is not normalised.
    #[inline]
    pub fn normal(&self, n: DVec3) -> DVec3 {
        self.inverse.transpose().transform_vector3(n)
    }

    /// Whether the map mirrors space.
    pub fn mirrors(&self) -> bool {
        self.matrix.determinant() < 0.0
    }
}

/// Half the width of an image plane at distance 1 that spans `degrees`.
pub fn half_width(degrees: f64) -> f64 {
    tan(0.5 * degrees.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::length;

    #[test]
    fn inverses_undo() {
        let t = Transform::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 2.0), DVec3::Y)
            .and_then(|t| Some(t.after(&Transform::rotate(DVec3::new(1.0, 1.0, 0.2), 40.0)?)))
            .and_then(|t| Some(t.after(&Transform::scale(DVec3::new(2.0, -3.0, 0.5))?)))
            .unwrap();
        let p = DVec3::new(0.3, -0.7, 5.0);
        assert!(length(t.inverted().point(t.point(p)) - p) < 1e-13);
        assert!(t.mirrors());
    }

    #[test]
    fn normals_stay_perpendicular_to_what_is_sheared() {
        let shear = DMat4::from_cols_array(&[
            2.0, 0.0, 0.0, 0.0, 0.5, 1.0, -0.25, 0.0, 0.0, 3.0, 4.0, 0.0, 1.0, 2.0, 3.0, 1.0,
        ]);
        let t = Transform::from_matrix(shear).unwrap();
        let n = t.normal(DVec3::new(1.0, -2.0, 0.5));
        for tangent in [DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 4.0)] {
            assert!(n.dot(t.vector(tangent)).abs() < 1e-14, "{tangent}");
        }
    }

    #[test]
    fn axes_of_three_decimals_are_straightened() {
        let turned = [DVec3::new(0.707, 0.0, -0.707), DVec3::Y, DVec3::new(0.707, 0.001, 0.707)];
        for axes in [turned, [turned[0] * 3.0, turned[1] * 3.0, turned[2] * -3.0]] {
            let rotation = Transform::of_axes(axes).unwrap();
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| rotation.vector(axis));
            assert!([x.dot(y), y.dot(z), z.dot(x)].iter().all(|cos| cos.abs() < 1e-15));
            assert!([x, y, z].iter().all(|axis| (length(*axis) - 1.0).abs() < 1e-15));
            let [near_x, near_y, near_z] = axes.map(unit);
            assert!(length(x - near_x) + length(y - near_y) + length(z - near_z) < 2e-3);
        }
    }

    #[test]
    fn degenerate_maps_are_refused() {
        assert!(Transform::scale(DVec3::new(1.0, 0.0, 1.0)).is_none());
        assert!(Transform::rotate(DVec3::ZERO, 10.0).is_none());
        assert!(Transform::look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
    }
}
