//! Sampled directions towards emitters, as distributions over the sphere.

use etalon::emitter::select::Expected;
use etalon::emitter::{AnyEmitter, Radiance};
use etalon::math::{DVec2, Ray};
use etalon::scene::{Features, Scene};
use etalon::spectrum::{ColorMode, Wavelengths};
use std::path::Path;
use validation::scatterer::{DVec3, Laws};
use validation::{Sample, Scatterer};

/// Distance from a shape's centre at which its light is sampled, in radii.
const DISTANCE: f64 = 2.5;

/// The path of the environment map of the reference scenes.
pub fn sky() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../references/scenes/textures/sky.exr");
    folder.display().to_string()
}

/// The only emitter of a scene, sampled from a point in the direction `wo` from its centre.
pub struct Light {
    scene: Scene,
    λ: Wavelengths,
    middle: DVec3,
    radius: f64,
    /// The normal of the receiver; zero for a receiver that collects light from all directions equally.
    n: DVec3,
}

/// A shape of the registry as an area light.
pub fn area(snippet: &str) -> Result<Light, String> {
    let emitter = r#"<emitter type="area"><spectrum name="radiance" value="1"/></emitter>"#;
    let shape = match snippet.strip_suffix("/>") {
        Some(open) => format!("{open}>{emitter}</shape>"),
        None => snippet.replace("</shape>", &format!("{emitter}</shape>")),
    };
    let mut light = Light::new(&shape)?;
    let (low, high) = light.scene.shapes[0].geometry.bounds();
    (light.middle, light.radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    Ok(light)
}

/// An emitter without a surface, for a receiver with normal `n`.
pub fn distant(snippet: &str, n: DVec3) -> Result<Light, String> {
    Ok(Light { n, ..Light::new(snippet)? })
}

impl Light {
    fn new(inside: &str) -> Result<Self, String> {
        let sensor = r#"<sensor type="perspective"/><integrator type="path"/>"#;
        let text = format!("<scene version=\"3.0.0\">{sensor}{inside}</scene>");
        let scene = etalon::load_text("light.xml", &text, ColorMode::Spectral).map_err(|e| e.to_string())?;
        let λ = Wavelengths::sample_visible(0.4);
        Ok(Self { scene, λ, middle: DVec3::ZERO, radius: 1.0, n: DVec3::ZERO })
    }

    /// Divisor of the radiance, so that no weight is above 1: light is no albedo. Intensity over the squared
    /// distance is the weight of a small source, of which a closed one shows a quarter of its surface. Of light
    /// from afar the irradiance that is sought is at least a quarter of all, which on a sphere is four times
    /// that on a plane. A colour differs from its luminance by less than the remaining factor.
    fn scale(&self) -> f64 {
        let geometry = self.scene.shapes.first().map(|shape| &shape.geometry);
        let nearest = self.radius * (DISTANCE - 1.0);
        match self.emitter().expected(geometry) {
            Expected::Near(cluster) => 16.0 * cluster.intensity / (nearest * nearest),
            Expected::Far(distant) => 64.0 * distant.irradiance,
        }
    }

    fn emitter(&self) -> &AnyEmitter {
        &self.scene.emitters.list[0].emitter
    }

    /// The receiver's weight of light from a direction: the cosine to its normal.
    fn gathered(&self, wi: DVec3) -> f64 {
        if self.n == DVec3::ZERO { 1.0 } else { self.n.dot(wi).max(0.0) }
    }

    fn place(&self, wo: DVec3) -> DVec3 {
        self.middle + wo * (DISTANCE * self.radius)
    }

    /// Radiance from a direction and its density, by tracing a ray.
    fn seen(&self, wo: DVec3, wi: DVec3) -> (f64, f64) {
        let ray = Ray::free(self.place(wo), wi);
        let view = self.emitter().view(wi);
        if let Some(radiance) = self.emitter().distant_radiance(&view, &self.λ) {
            return (radiance.0[0] as f64 * self.gathered(wi), self.emitter().distant_pdf(&view, self.n));
        }
        let Some(hit) = self.scene.accel.closest(&ray) else { return (0.0, 0.0) };
        let (shape, point) = self.scene.surface::<{ Features::ALL }>(&ray, &hit);
        let radiance = self.emitter().surface_radiance(&point, -wi, &self.λ).0[0] as f64;
        if radiance == 0.0 {
            return (0.0, 0.0);
        }
        (radiance, self.emitter().surface_pdf(&shape.geometry, &ray, hit.t, &point))
    }
}

impl Scatterer for Light {
    fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.seen(wo, wi).0 / self.scale()
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.seen(wo, wi).1
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<Sample> {
        let geometry = self.scene.shapes.first().map(|shape| &shape.geometry);
        let (p, u) = (self.place(wo), DVec2::new(u[1], u[2]));
        let found = self.emitter().sample(geometry, p, self.n, u, &self.λ)?;
        let radiance = match found.radiance {
            Radiance::Known(radiance) => radiance,
            Radiance::Mapped(place) => self.scene.emitters.mapped(&place, &self.λ),
        };
        let weight = radiance.0[0] as f64 * self.gathered(found.wi) / (found.pdf * self.scale());
        Some(Sample { wi: found.wi, weight, pdf: found.pdf, delta: found.delta })
    }

    fn laws(&self) -> Laws {
        Laws::default()
    }

    fn is_phase_function(&self) -> bool {
        true
    }
}
