//! The children of a node, side by side.

use super::Cluster;
use crate::bsdf::Lobe;
use crate::emitter::{GatherPoint, Gathers};
use crate::math::DVec3;
use crate::math::simd::{F64x4, dot};

/// Most children of a node.
pub const WIDTH: usize = 4;

/// [`Cluster`]s, one to a lane; those that are missing emit nothing.
#[derive(Debug)]
pub struct Children {
    centre: [[f64; WIDTH]; 3],
    /// Radius of the ball about the box.
    radius: [f64; WIDTH],
    axis: [[f64; WIDTH]; 3],
    /// Cosine of the half angle of the cone of normals.
    cos: [f64; WIDTH],
    /// Sine of that angle.
    sin: [f64; WIDTH],
    cos_beyond: [f64; WIDTH],
    intensity: [f64; WIDTH],
}

/// For each child an estimate of its irradiance, and their sum.
pub type Importance = ([f64; WIDTH], f64);

/// Cosine and sine of an angle from 0 to π.
type Angle = (F64x4, F64x4);

impl Children {
    pub fn new(clusters: &[Cluster]) -> Self {
        let of = |f: &dyn Fn(&Cluster) -> f64| std::array::from_fn(|i| clusters.get(i).map_or(0.0, f));
        let vectors = |f: &dyn Fn(&Cluster) -> DVec3| [0, 1, 2].map(|axis| of(&|cluster| f(cluster)[axis]));
        Self {
            centre: vectors(&|cluster| cluster.ball().0),
            radius: of(&|cluster| cluster.ball().1.sqrt()),
            axis: vectors(&|cluster| cluster.normals.axis),
            cos: of(&|cluster| cluster.normals.cos),
            sin: of(&|cluster| (1.0 - cluster.normals.cos * cluster.normals.cos).max(0.0).sqrt()),
            cos_beyond: of(&|cluster| cluster.cos_beyond),
            intensity: of(&|cluster| cluster.intensity),
        }
    }

    /// Estimates of the irradiance from each child at a point p (from all directions, if n is zero), and their
    /// sum. An estimate is zero only if no light of the child can arrive there.
    ///
    /// Intensity over squared distances, times the largest cosines that can be at either end: as seen from the
    /// point all emitters are within a cone about the centre, and from any of them the point is as far from
    /// the axis of the normals, less the angle of that cone and of the normals' own. What a lobe makes of them
    /// is no bound, but never zero.
    #[inline(always)]
    pub fn importance(&self, GatherPoint { p, gathers: &Gathers { n, lobe } }: GatherPoint) -> Importance {
        let (zero, one) = (F64x4::splat(0.0), F64x4::splat(1.0));
        let p = p.to_array().map(F64x4::splat);
        let way = [0, 1, 2].map(|axis| F64x4::new(self.centre[axis]) - p[axis]);
        let (distance2, radius) = (dot(way, way), F64x4::new(self.radius));
        let inverse = one / distance2.sqrt();
        let sin_seen = radius * inverse;
        let near = F64x4::new(self.intensity) * mean_inverse_square((distance2, radius), (inverse, sin_seen));
        let w = way.map(|v| v * inverse);
        let seen = ((one - sin_seen * sin_seen).sqrt(), sin_seen);
        let from_axis = with_sine(-dot(self.axis.map(F64x4::new), w));
        let beyond_normals = less(from_axis, (F64x4::new(self.cos), F64x4::new(self.sin)));
        let leaving = less(beyond_normals, seen).0;
        let leaving = F64x4::new(self.cos_beyond).below(leaving).select(leaving, zero);
        let mut cosines = leaving;
        if n != DVec3::ZERO {
            cosines = cosines * less(with_sine(dot(n.to_array().map(F64x4::splat), w)), seen).0.max(zero);
        }
        if lobe.share > 0.0 {
            cosines = cosines * gain(&lobe, w, sin_seen);
        }
        // Within the ball, emitters may be in any direction, and emit in any.
        let all = distance2.at_most(radius * radius).select(near, near * cosines).to_array();
        (all, (all[0] + all[1]) + (all[2] + all[3]))
    }
}

/// [`Lobe::gain`] on average over a disk whose radius is seen under an angle, in directions w. Over it, the
/// squared half angle to its middle is an eighth of its squared radius on average, by which the lobe is wider.
#[inline(always)]
fn gain(lobe: &Lobe, w: [F64x4; 3], sin_seen: F64x4) -> F64x4 {
    let [one, half, share] = [1.0, 0.5, lobe.share].map(F64x4::splat);
    let cos = dot(lobe.axis.to_array().map(F64x4::splat), w);
    let alpha2 = F64x4::splat(lobe.alpha2) + F64x4::splat(0.125) * (sin_seen * sin_seen);
    let turned = alpha2 + half * (one - cos);
    (one - share) + share * (F64x4::splat(0.25) * alpha2 / (turned * turned))
}

/// 1/d² on average over a ball of half the squared radius, nearly: 3/r² in its midst, 3/2r² on its surface.
///
/// Taking for it half of the ball about a box, in which most boxes' emitters are, leaves a quarter or a fifth
/// of the variance that 1/max(d², r²) does.
#[inline(always)]
fn mean_inverse_square((distance2, radius): (F64x4, F64x4), (inverse, sin_seen): (F64x4, F64x4)) -> F64x4 {
    let (least, half) = (F64x4::splat(f64::MIN_POSITIVE), F64x4::splat(0.5));
    let radius2 = half * (radius * radius);
    let ratio = half * (sin_seen * sin_seen);
    let outside = (F64x4::splat(1.0) + half * (ratio * ratio)) * (inverse * inverse);
    let inside = F64x4::splat(3.0) / (radius2 + distance2).max(least);
    distance2.at_most(radius2).select(inside, outside)
}

#[inline(always)]
fn with_sine(cos: F64x4) -> Angle {
    (cos, (F64x4::splat(1.0) - cos * cos).max(F64x4::splat(0.0)).sqrt())
}

/// α − β, or 0 if β is larger.
#[inline(always)]
fn less((cos_a, sin_a): Angle, (cos_b, sin_b): Angle) -> Angle {
    let larger = cos_b.at_most(cos_a);
    let cos = larger.select(F64x4::splat(1.0), cos_a * cos_b + sin_a * sin_b);
    (cos, larger.select(F64x4::splat(0.0), sin_a * cos_b - cos_a * sin_b))
}
