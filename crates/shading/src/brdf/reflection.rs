//! Directions in which environments are looked up.

use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Dominant direction of the specular lobe of a rough surface: between the mirror direction `r` and the normal `n`,
/// not normalised. Lagarde and de Rousiers, "Moving Frostbite to PBR" (SIGGRAPH 2014); Unity core/ImageBasedLighting,
/// `GetSpecularDominantDir`.
///
/// Perceptual roughness 0 to 1; `n_dot_v` clamped by the caller.
#[inline(always)]
pub fn specular_dominant_direction<L: Lanes>(
    _: L,
    n: V3<L>,
    r: V3<L>,
    perceptual_roughness: L::F,
    n_dot_v: L::F,
) -> V3<L> {
    let p2 = perceptual_roughness.squared();
    // Roughness 1 may have been reached by rounding up.
    let q = p2.one_minus().at_least(0.0);
    let factor = (q.sqrt() + p2) * (q * q + q * n_dot_v.squared()).saturate();
    n.lerp(r, factor)
}

/// The correction that HDRP applies to [`specular_dominant_direction`] for rough surfaces: back towards the mirror
/// direction `r` by smoothstep(alpha^2). Unity hd/Lit and hd/StackLit, `EvaluateBSDF_Env`.
#[inline(always)]
pub fn environment_direction<L: Lanes>(_: L, dominant: V3<L>, r: V3<L>, perceptual_roughness: L::F) -> V3<L> {
    let t = perceptual_roughness.squared().squared().saturate();
    dominant.lerp(r, t * t * (t * -2.0 + 3.0))
}

/// The normal and the perceptual roughness with which an anisotropic surface looks up an isotropic environment:
/// the normal is bent along the grain towards the view. Unity core/ImageBasedLighting,
/// `GetGGXAnisotropicModifiedNormalAndRoughness`; after McAuley, "Rendering the World of Far Cry 4" (GDC 2015).
///
/// Anisotropy in -1 to 1, unit vectors. Looking along the grain, where the original divides 0 by 0, the normal stays
/// as it is.
#[inline(always)]
pub fn anisotropic_normal_and_roughness<L: Lanes>(
    l: L,
    bitangent: V3<L>,
    tangent: V3<L>,
    n: V3<L>,
    view: V3<L>,
    anisotropy: L::F,
    perceptual_roughness: L::F,
) -> (V3<L>, L::F) {
    let grain = Vec3::select(anisotropy.ge(l.zero()), bitangent, tangent);
    let stretch = anisotropy.abs() * (perceptual_roughness.sqrt() * 1.5).saturate();
    let across = view - grain * view.dot(grain);
    let along_grain = across.dot(across).lt(l.splat(f32::MIN_POSITIVE));
    let grain_normal = Vec3::select(along_grain, n, across.normalize());
    let bent = n.lerp(grain_normal, stretch).normalize();
    let roughness = perceptual_roughness * (l.splat(1.2) - anisotropy.abs()).saturate();
    (bent, roughness)
}

/// The direction `x` (unit, away from the surface) inside a medium of higher index behind the surface of normal `n`,
/// again as it points outwards. `ieta` is the ratio of the indices outside and inside, 0 to 1. Unity hd/StackLit,
/// `CoatRefract`.
///
/// No total reflection can occur; ratios above 1, where the original takes the root of a negative number, are
/// refracted along the surface.
#[inline(always)]
pub fn coat_refract<L: Lanes>(_: L, x: V3<L>, n: V3<L>, ieta: L::F) -> V3<L> {
    let cosine = n.dot(x).saturate();
    let inside2 = ieta.squared() * (cosine.squared() - 1.0) + 1.0;
    let along_normal = inside2.at_least(0.0).sqrt() - ieta * cosine;
    x * ieta + n * along_normal
}
