//! The radiance that leaves the scene in one direction.

use super::{AnySensor, Optics, Sensor, one_pixel};
use crate::math::{Ball, Bounds, DVec2, DVec3, Frame, Ray, warp};
use crate::scene::error::SceneError;
use crate::scene::objects::geometry;
use crate::scene::params::Params;
use crate::shape::Geometry;
use std::sync::Arc;

pub const NAME: &str = "distant";
pub const ABOUT: &str = "Measures the radiance that leaves the scene in one direction, from a point, from a surface, or the mean over the scene's outline; its film is one pixel.";
pub const EXAMPLES: &[&str] = &[
    r#"<sensor type="distant"/>"#,
    r#"<sensor type="distant"><vector name="direction" x="0.3" y="-1" z="0.1"/>
    <point name="target" x="0" y="0.5" z="0"/></sensor>"#,
    r#"<sensor type="distant"><shape type="disk" name="target"/></sensor>"#,
];

/// Looks along parallel rays from outside of the scene.
#[derive(Clone, Debug)]
pub struct Distant {
    /// Whose normal is the direction that it looks in.
    frame: Frame,
    target: Target,
    /// Around the scene, once that is known.
    scene: Ball,
}

/// What the rays are aimed at.
#[derive(Clone, Debug)]
enum Target {
    /// The disk that the ball around the scene is seen as.
    Scene,
    Point(DVec3),
    /// A surface, which need not be one of the scene, evenly by its area.
    Surface(Arc<Geometry>),
}

pub fn parse(params: &mut Params) -> Result<Sensor, SceneError> {
    let recorded = one_pixel(params)?;
    let direction = params
        .direction("where it looks: against the light that it measures", "turns +z to where it looks")?;
    let about = "a <point> or a <shape> that is aimed at, evenly by its area; by default the disk that the ball around the scene's box is seen as";
    let target = match params.raw("target", "point or shape", "none", about)? {
        None => Target::Scene,
        Some(element) if element.tag == "shape" => {
            Target::Surface(Arc::new(geometry(element, params.loader)?))
        }
        Some(element) if ["point", "vector"].contains(&element.tag.as_str()) => {
            Target::Point(crate::scene::transform::coordinates(element, &["name"], 0.0)?)
        }
        Some(element) => {
            let message = format!("`target` cannot be a <{}>", element.tag);
            return Err(SceneError::at(&element.span, message, "expected <point> or <shape>"));
        }
    };
    let scene = Ball { centre: DVec3::ZERO, radius: 1.0 };
    Ok(recorded.with(AnySensor::Distant(Distant { frame: Frame::about(direction), target, scene })))
}

impl Optics for Distant {
    #[inline]
    fn ray(&self, _: DVec2, lens: DVec2) -> Ray {
        let n = self.frame.n;
        let (p, distance) = self.aim(lens);
        Ray::free(p - n * distance, n)
    }

    fn has_lens(&self) -> bool {
        !matches!(self.target, Target::Point(_))
    }

    fn look_at(&mut self, bounds: Bounds) {
        if bounds.0.x <= bounds.1.x {
            self.scene = Ball::of_box(bounds);
        }
    }
}

impl Distant {
    /// A point that is aimed at, and from how far: as in Mitsuba from a diameter of the scene, of the outline from a
    /// radius, for distances count from there; but from farther away where that is not outside.
    // Not inlined, and not where the ray is: cameras would pay for either.
    #[inline(never)]
    fn aim(&self, lens: DVec2) -> (DVec3, f64) {
        let Ball { centre, radius } = self.scene;
        let (p, distance) = match &self.target {
            Target::Scene => {
                let d = radius * warp::disk_concentric(lens);
                (centre + self.frame.s * d.x + self.frame.t * d.y, radius)
            }
            Target::Point(p) => (*p, 2.0 * radius),
            Target::Surface(surface) => (surface.sample_area::<false>(lens).p, 2.0 * radius),
        };
        (p, distance.max(self.frame.n.dot(p - centre) + radius))
    }
}
