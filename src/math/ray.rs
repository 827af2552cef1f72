//! Rays.

use glam::DVec3;

/// No primitive: of a ray that starts in free space, of a hit of nothing, of an empty lane. All smaller numbers
/// are primitives'.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A half-line in world space, with the primitive it starts on.
///
/// A ray never meets the planar primitive it starts on again, and meets a quadric it starts on only at the
/// other root: leaving a surface needs no offset and no epsilon. `start` bounds the rounding error of the
/// origin against neighbouring primitives.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    /// Direction, of unit length.
    pub direction: DVec3,
    /// Distances at or below this are rounding error of `origin`.
    pub start: f64,
    /// Hits at or beyond this distance are ignored.
    pub end: f64,
    /// The primitive that `origin` lies on, or [`Ray::FREE`].
    pub from: u32,
    pub ends: Ends,
}

/// What is known of the two ends of a ray.
// As large as the field before it: a ray is copied all the time, and bytes of padding would be copied one by
// one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Ends {
    Anywhere,
    /// Both lie on surfaces of the scene: a plane with the whole scene on one side cannot lie between them.
    OnSurfaces,
}

/// A point of a surface from which rays leave (world).
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    pub p: DVec3,
    /// The primitive that it lies on.
    pub primitive: u32,
}

impl Ray {
    /// The `from` of a ray that starts in free space.
    pub const FREE: u32 = NO_PRIMITIVE;

    /// A ray from a point in free space.
    pub fn free(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, start: 0.0, end: f64::INFINITY, from: Self::FREE, ends: Ends::Anywhere }
    }

    /// A ray that leaves primitive `from` at `origin`, to distance `end`.
    #[inline]
    pub fn leaving(origin: DVec3, direction: DVec3, end: f64, from: u32) -> Self {
        Self { origin, direction, start: position_error(origin), end, from, ends: Ends::Anywhere }
    }

    /// The point at distance `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// A bound of the rounding error of a computed surface point.
///
/// Points are interpolated from stored vertices or projected onto quadrics in `f64`: about ten roundings of
/// numbers as large as the largest coordinate, 10·2⁻⁵³ < 2⁻⁴⁹. The bound scales with the scene. For a point
/// of something large that passes close to the world's origin, the numbers it was computed from are larger
/// than its coordinates: there `p` must be a bound of those.
#[inline]
pub fn position_error(p: DVec3) -> f64 {
    rounding(p.abs().max_element())
}

/// Ten roundings of a number as large as `size`.
#[inline]
pub fn rounding(size: f64) -> f64 {
    const TEN_ROUNDINGS: f64 = 1.0 / (1u64 << 49) as f64;
    size * TEN_ROUNDINGS
}

/// Length of the shadow ray between two points, `distance` apart, whose errors sum to `errors`.
#[inline]
pub fn free_way(distance: f64, errors: f64) -> f64 {
    distance - 4.0 * errors
}
