//! Microfacet specular terms of the GGX family.

use crate::math::lanes::{Float, Lanes};

/// The specular term of URP without its Fresnel colour: roughness^2 / (d^2 max(0.1, (L.H)^2) (4 roughness +
/// 2)) with d = (N.H)^2 (roughness^2 - 1) + 1.00001.
///
/// Karis and Lagarde's approximation of D V F for mobile ("Optimizing PBR for Mobile", SIGGRAPH 2015), times
/// pi: URP folds pi into the colour of its lights. The constant 1.00001 bounds the peak. Unity urp/BRDF,
/// `DirectBRDFSpecular`.
///
/// `roughness2` is alpha squared, `normalization` is 4 alpha + 2.
#[inline(always)]
pub fn minimalist_cook_torrance<L: Lanes>(
    _: L,
    n_dot_h: L::F,
    l_dot_h: L::F,
    roughness2: L::F,
    roughness2_minus_one: L::F,
    normalization: L::F,
) -> L::F {
    let d = n_dot_h * n_dot_h * roughness2_minus_one + 1.00001;
    let l_dot_h2 = l_dot_h * l_dot_h;
    roughness2 / ((d * d) * l_dot_h2.at_least(0.1) * normalization)
}
