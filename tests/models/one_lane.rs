//! Surfaces and light in the scalar lanes, as the tests of several models make them.

use super::draws::tilted;
use overcoat_core::math::lanes::{Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::coat::EnvironmentQuery;
use overcoat_shading::coat::gltf::{Coat, Sheen};

pub const L: Scalar = Scalar;
pub type F = <Scalar as Lanes>::F;

pub fn f(x: f32) -> F {
    L.splat(x)
}

pub fn grey(x: f32) -> V3<Scalar> {
    Vec3::uniform(f(x))
}

/// The normal of most tests.
pub fn up() -> V3<Scalar> {
    tilted(1.0)
}

/// A coat of that normal.
pub fn coat(factor: f32, roughness: f32) -> Option<Coat<Scalar>> {
    Some(Coat { factor: f(factor), roughness: f(roughness), normal: up() })
}

/// Grey sheen.
pub fn sheen(color: f32, roughness: f32) -> Option<Sheen<Scalar>> {
    Some(Sheen { color: grey(color), roughness: f(roughness) })
}

/// The environment by query.
pub type Asked<'a> = &'a dyn Fn(EnvironmentQuery<Scalar>) -> V3<Scalar>;
