//! Materials composed of other materials.

use super::ClosedForm;
use super::interfaces::stage;
use crate::stage::*;

pub fn cases() -> Vec<ClosedForm> {
    let (dark, light) = (diffuse(0.2), diffuse(0.8));
    let blend = bsdf("blendbsdf", &(float("weight", 0.3) + &dark + &light));
    let mirror = bsdf("conductor", &grey("specular_reflectance", 0.9));
    let half_mirror = bsdf("blendbsdf", &(float("weight", 0.3) + &mirror + &light));
    let veil = bsdf("mask", &(float("opacity", 0.6) + &diffuse(0.5)));
    let both = bsdf("twosided", &(dark.clone() + &light));
    let one = bsdf("twosided", &light);
    let null = bsdf("null", "");
    let cases = [
        ("blend", "(1 − w)ρ₁ + wρ₂", 30.0, &blend, 0.7 * 0.2 + 0.3 * 0.8),
        ("blend_with_mirror", "(1 − w)R + wρ", 30.0, &half_mirror, 0.7 * 0.9 + 0.3 * 0.8),
        ("mask", "αρ + (1 − α)L", 30.0, &veil, 0.6 * 0.5 + 0.4),
        ("twosided_front", "ρ of the front", 30.0, &both, 0.2),
        ("twosided_back", "ρ of the back", 150.0, &both, 0.8),
        ("twosided_alike", "ρ of either side", 150.0, &one, 0.8),
        ("null", "nothing is there", 30.0, &null, 1.0),
    ];
    cases
        .into_iter()
        .map(|(name, source, degrees, wears, expected)| {
            let sheet = shape("rectangle", &[], wears);
            ClosedForm::new(name, source, stage(degrees, &constant(1.0), &sheet), expected).samples(1 << 14)
        })
        .collect()
}
