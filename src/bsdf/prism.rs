//! A ray through a prism of the scene files, by the scene's own search, surfaces and material, against
//! Snell's law.

use super::Bsdf;
use crate::load_text;
use crate::math::{BELOW_ONE, DVec2, DVec3, Ray, length};
use crate::scene::{Features, Scene};
use crate::spectrum::materials::Dispersion;
use crate::spectrum::{ColorMode, Wavelengths};

/// The angle between the prism's two faces that the ray crosses.
const APEX: f64 = std::f64::consts::FRAC_PI_3;

fn prism() -> Scene {
    let text = r#"<scene version="3.0.0">
        <sensor type="perspective"/>
        <shape type="obj">
            <string name="filename" value="meshes/prism.obj"/>
            <boolean name="face_normals" value="true"/>
            <bsdf type="dielectric">
                <string name="dispersion" value="sf11"/>
                <float name="ext_ior" value="1"/>
            </bsdf>
        </shape>
    </scene>"#;
    load_text(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/prism-alone.xml"), text, ColorMode::Spectral)
        .unwrap()
}

/// Refracts a ray at the next surface it meets.
fn refracted(scene: &Scene, ray: &Ray, λ: &mut Wavelengths) -> Ray {
    let hit = scene.accel.closest(ray).expect("the ray meets the prism");
    let (shape, point) = scene.surface::<{ Features::ALL }>(ray, &hit);
    let frame = point.frame(false);
    let current = *λ;
    let bsdf = scene.materials[shape.sides[0].material as usize].at(&point, &current);
    // The largest number below 1 chooses the last lobe, which is refraction.
    let lobe = BELOW_ONE;
    let sample = bsdf.sample(frame.to_local(-ray.direction), lobe, DVec2::ZERO).expect("a direction");
    assert_eq!(sample.dispersed, !λ.is_collapsed());
    if sample.dispersed {
        λ.collapse();
    }
    point.ray(frame.to_world(sample.wi), f64::INFINITY, hit.primitive)
}

/// By Snell's law at both faces a ray that comes in at angle i from the normal is turned by
/// δ = i + e − A, with sin e = n sin(A − r) and sin i = n sin r.
fn deviation(n: f64, incidence: f64) -> f64 {
    let r = libm::asin(libm::sin(incidence) / n);
    incidence + libm::asin(n * libm::sin(APEX - r)) - APEX
}

/// The tolerance of 1e-6 rad is the mesh's: vertices of 32 bits tilt its faces by up to 1e-7.
#[test]
fn every_wavelength_leaves_a_prism_as_snell_says() {
    let scene = prism();
    let sf11 = Dispersion::named("sf11").unwrap();
    // The normal of the face between the edge at x < 0 and that at z > 0, and the direction along the face.
    let (sin, cos) = libm::sincos(APEX / 2.0);
    let (normal, along) = (DVec3::new(-sin, 0.0, cos), DVec3::new(-cos, 0.0, -sin));
    let target = DVec3::new(-0.5 * 0.288_675_135, 0.6, 0.25);
    let mut turned = vec![];
    for nm in [404.66, 486.13, 546.07, 587.56, 656.27, 706.52] {
        // Beneath 58° violet would be totally reflected inside.
        for incidence in [62.0f64, 66.4, 75.0].map(f64::to_radians) {
            let (sin, cos) = libm::sincos(incidence);
            let direction = along * sin - normal * cos;
            let mut λ = Wavelengths::sample_visible(0.5);
            λ.nm[0] = nm;
            let inside = refracted(&scene, &Ray::free(target - direction, direction), &mut λ);
            let outside = refracted(&scene, &inside, &mut λ);
            // The cross product keeps small angles exact, where the arc cosine would not.
            let angle =
                libm::atan2(length(direction.cross(outside.direction)), direction.dot(outside.direction));
            let expected = deviation(sf11.eta(nm), incidence);
            assert!((angle - expected).abs() < 1e-6, "{nm} nm, {incidence}: {angle} {expected}");
            assert!(scene.accel.closest(&outside).is_none());
            turned.push(angle);
        }
    }
    // A prism that bent all colours alike would be no prism: violet is turned by 9.5° further than red.
    assert!(turned[1] - turned[turned.len() - 2] > 9f64.to_radians());
}
