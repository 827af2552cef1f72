//! Sensors: from a place on the film and one on the lens to a ray. Cameras make images; meters measure one number.
//!
//! *How to add one*: write `sensor/<name>.rs` with `NAME`, `ABOUT`, `EXAMPLES`, `parse` and a type with [`Optics`]; add
//! its line to `sensors!`.

#[cfg(test)]
mod contract;
mod distant;
mod field_of_view;
mod foreshortening;
mod irradiancemeter;
mod orthographic;
mod perspective;
mod radiancemeter;
mod recorded;
mod thinlens;

use crate::film::Film;
use crate::math::{Bounds, DVec2, DVec3, Ray};
use crate::medium::Medium;
use crate::sampler::SamplerSettings;
use crate::scene::Shape;
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::params::Usage;
use crate::scene::registry::{Entry, construct};
use crate::scene::xml::Element;
pub use field_of_view::{half_width, require_rigid};
use foreshortening::Foreshortening;
use recorded::{common, one_pixel};
use std::f64::consts::PI;
use std::sync::Arc;

/// What a camera or a meter does. What only cameras do is by default what a meter does instead.
pub trait Optics {
    /// The ray through a place on the film (0 to 1 from the upper left) and a place on the unit square of the
    /// lens.
    fn ray(&self, film: DVec2, lens: DVec2) -> Ray;

    /// Whether the place on the lens matters.
    fn has_lens(&self) -> bool {
        false
    }

    /// Tells the box around the scene, which may be empty.
    fn look_at(&mut self, _bounds: Bounds) {}

    /// Whether its rays leave the surface whose irradiance it measures, with a density of cos θ/π.
    fn lies_on_surface(&self) -> bool {
        false
    }

    /// What light along its rays is multiplied by: in sr for a meter of irradiance, for E = ∫ L cos θ dω is π times the
    /// mean of L over directions of density cos θ/π.
    fn response(&self) -> f64 {
        if self.lies_on_surface() { PI } else { 1.0 }
    }

    /// Whether it makes an image: then light paths can be connected with it, and what is seen has a place on the film.
    fn has_image(&self) -> bool {
        false
    }

    /// How a point in the world is seen through a place on the unit square of the lens, if it is not
    /// occluded. `None` for what lies behind the camera or beyond its clipping distances, and of what makes no image.
    fn connect(&self, _p: DVec3, _lens: DVec2) -> Option<View> {
        None
    }

    /// [`View::per_area`] at the point `p` of a camera ray; 0 of what makes no image.
    fn seen_per_area(&self, _ray: &Ray, _p: DVec3) -> f64 {
        0.0
    }
}

/// A point as a camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Unit direction from the point to the lens, world space.
    pub towards: DVec3,
    /// Distance to the lens, over which the shadow ray must be unoccluded.
    pub distance: f64,
    /// The place on the film, 0 to 1 from the upper left where it is on it.
    pub film: DVec2,
    /// The part of the film that a unit of area about the point, across the line of sight, fills.
    pub per_area: f64,
}

/// A camera or a meter with what it records on and how it is sampled.
#[derive(Clone, Debug)]
pub struct Sensor {
    pub camera: AnySensor,
    pub film: Film,
    pub sampler: SamplerSettings,
    /// What it is in.
    pub medium: Option<Arc<Medium>>,
}

macro_rules! sensors {
    ($($module:ident: $Type:ident),* $(,)?) => {
        $(pub use $module::$Type;)*

        /// Any sensor.
        #[derive(Clone, Debug)]
        pub enum AnySensor {
            $($Type($Type)),*
        }

        /// Every sensor.
        pub static SENSORS: &[Entry<Sensor>] = &[$(Entry {
            name: $module::NAME,
            about: $module::ABOUT,
            examples: $module::EXAMPLES,
            parse: $module::parse,
        }),*];

        impl AnySensor {
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$Type(_) => $module::NAME),*
                }
            }
        }

        impl Optics for AnySensor {
            #[inline]
            fn ray(&self, film: DVec2, lens: DVec2) -> Ray {
                match self {
                    $(Self::$Type(sensor) => sensor.ray(film, lens)),*
                }
            }

            fn has_lens(&self) -> bool {
                match self {
                    $(Self::$Type(sensor) => sensor.has_lens()),*
                }
            }

            fn look_at(&mut self, bounds: Bounds) {
                match self {
                    $(Self::$Type(sensor) => sensor.look_at(bounds)),*
                }
            }

            fn lies_on_surface(&self) -> bool {
                match self {
                    $(Self::$Type(sensor) => sensor.lies_on_surface()),*
                }
            }

            fn has_image(&self) -> bool {
                match self {
                    $(Self::$Type(sensor) => sensor.has_image()),*
                }
            }

            #[inline]
            fn connect(&self, p: DVec3, lens: DVec2) -> Option<View> {
                match self {
                    $(Self::$Type(sensor) => sensor.connect(p, lens)),*
                }
            }

            fn seen_per_area(&self, ray: &Ray, p: DVec3) -> f64 {
                match self {
                    $(Self::$Type(sensor) => sensor.seen_per_area(ray, p)),*
                }
            }
        }
    };
}
sensors! {
    perspective: Perspective,
    thinlens: ThinLens,
    orthographic: Orthographic,
    radiancemeter: RadianceMeter,
    distant: Distant,
    irradiancemeter: IrradianceMeter,
}

impl Sensor {
    /// Reads a sensor that stands by itself.
    ///
    /// # Errors
    /// Where it is wrong, or belongs to a shape.
    pub fn parse<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<Self, SceneError> {
        let sensor = construct(SENSORS, element, loader, Usage::Unbounded)?;
        if let AnySensor::IrradianceMeter(_) = sensor.camera {
            let message = format!("an `{}` without a shape", irradiancemeter::NAME);
            return Err(SceneError::at(&element.span, message, "put it inside a <shape>"));
        }
        Ok(sensor)
    }

    /// Reads a sensor that belongs to a shape; it is in what the shape has around it, unless it says otherwise.
    ///
    /// # Errors
    /// Where it is wrong, or does not measure a surface.
    pub fn of_shape<'d>(
        element: &'d Element,
        loader: &Loader<'d>,
        shape: &Shape,
    ) -> Result<Self, SceneError> {
        let mut sensor: Self = construct(SENSORS, element, loader, Usage::Unbounded)?;
        let AnySensor::IrradianceMeter(meter) = &mut sensor.camera else {
            let message = format!("a shape cannot have a sensor `{}`", sensor.camera.name());
            let expected = format!("expected an `{}`", irradiancemeter::NAME);
            return Err(SceneError::at(&element.span, message, expected));
        };
        meter.lay_on(Arc::new(shape.geometry.clone()), shape.first_primitive);
        let around = shape.interface.as_ref().and_then(|interface| interface.exterior.clone());
        sensor.medium = sensor.medium.or(around);
        Ok(sensor)
    }
}
