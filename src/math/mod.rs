//! Vectors, frames, rays, warps and reproducible functions: everything the models share and no model owns.
//!
//! All of it is `f64` and uses only operations whose result IEEE 754 fixes, or functions of [`function`] that
//! are built from those. The platform's mathematics library never decides a bit of an image.

pub mod ball;
pub mod bits;
pub mod bounds;
pub mod cone;
pub mod discrete;
pub mod frame;
pub mod function;
pub mod gaussian;
pub mod quadrature;
pub mod random;
pub mod ray;
pub mod root;
pub mod simd;
pub mod transform;
pub mod warp;

pub use ball::Ball;
pub use bounds::Bounds;
pub use discrete::{Chosen, Discrete};
pub use frame::{Frame, length};
pub use glam::{DVec2, DVec3};
pub use ray::{Origin, Ray};
pub use transform::Transform;

/// The largest number below 1.
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// π⁻¹, the normalisation of the cosine over the hemisphere.
pub const INV_PI: f64 = std::f64::consts::FRAC_1_PI;
