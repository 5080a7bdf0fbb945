//! Microfacet specular terms of the GGX family, as Unity evaluates them.
//!
//! The functions with "smith" in their names are those of Unity core/BSDF (13.0.0 and Unity 6 alike): Walter et
//! al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007) with the height-correlated Smith
//! visibility of Heitz (JCGT 2014), and Burley's anisotropic form. *Visibility* V is G / (4 N.L N.V). Unless said
//! otherwise a roughness is the alpha of GGX, 0 to 1; anisotropic ones may reach 2 in one direction. Where a cosine
//! with the normal leaves 0 to 1 by rounding, the results stay finite.

use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// 2^-24, `FLT_EPS` of Unity's shaders.
const FLOAT_EPSILON: f32 = 5.960_464_5e-8;

/// Angles between light, view and normal, Unity's `GetBSDFAngle`.
#[derive(Clone, Copy)]
pub struct BsdfAngles<L: Lanes> {
    /// L.V.
    pub l_dot_v: L::F,
    /// N.H, 0 to 1.
    pub n_dot_h: L::F,
    /// L.H (which is V.H), 0 to 1.
    pub l_dot_h: L::F,
    /// 1 / |L + V|, at most 4096: the half vector is (L + V) times this.
    pub inverse_length: L::F,
}

/// The angles of a pair of unit vectors, both away from the surface. `n_dot_l` and `n_dot_v` are not clamped.
///
/// Where light and view are opposite there is no half vector and the cosines are rounding noise in 0 to 1.
#[inline(always)]
pub fn bsdf_angles<L: Lanes>(_: L, light: V3<L>, view: V3<L>, n_dot_l: L::F, n_dot_v: L::F) -> BsdfAngles<L> {
    let l_dot_v = light.dot(view);
    let inverse_length = (l_dot_v * 2.0 + 2.0).at_least(FLOAT_EPSILON).sqrt().recip();
    BsdfAngles {
        l_dot_v,
        n_dot_h: ((n_dot_l + n_dot_v) * inverse_length).saturate(),
        l_dot_h: (inverse_length * l_dot_v + inverse_length).saturate(),
        inverse_length,
    }
}

/// `numerator / denominator`, and 1 where both are equal, also both 0 (Unity core/Common, `SafeDiv`).
#[inline(always)]
fn safe_div<L: Lanes>(l: L, numerator: L::F, denominator: L::F) -> L::F {
    numerator.eq(denominator).select(l.splat(1.0), numerator / denominator)
}

/// The denominator of the distribution, (N.H)^2 (a^2 - 1) + 1.
#[inline(always)]
fn distribution_base<L: Lanes>(_: L, n_dot_h: L::F, roughness2: L::F) -> L::F {
    (n_dot_h * roughness2 - n_dot_h) * n_dot_h + 1.0
}

/// The distribution of normals times pi, `D_GGXNoPI`. Roughness 0 gives 1 at N.H = 1 and 0 elsewhere.
#[inline(always)]
pub fn distribution_no_pi<L: Lanes>(l: L, n_dot_h: L::F, roughness: L::F) -> L::F {
    let a2 = roughness.squared();
    safe_div(l, a2, distribution_base(l, n_dot_h, a2).squared())
}

/// The distribution of normals per steradian, `D_GGX`.
#[inline(always)]
pub fn distribution<L: Lanes>(l: L, n_dot_h: L::F, roughness: L::F) -> L::F {
    distribution_no_pi(l, n_dot_h, roughness) * FRAC_1_PI
}

/// Smith's Lambda of one direction as the joint visibility needs it, `GetSmithJointGGXPartLambdaV`:
/// sqrt((N.V)^2 (1 - a^2) + a^2). Also for the light's cosine.
#[inline(always)]
pub fn part_lambda<L: Lanes>(_: L, cosine: L::F, roughness: L::F) -> L::F {
    let a2 = roughness.squared();
    ((-cosine * a2 + cosine) * cosine + a2).sqrt()
}

/// Sum of the Smith terms of view and light, the denominator of the visibility over 2.
#[inline(always)]
fn smith_sum<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, roughness: L::F, part_lambda_v: L::F) -> L::F {
    let lambda_v = n_dot_l * part_lambda_v;
    let lambda_l = n_dot_v * part_lambda(l, n_dot_l, roughness);
    lambda_v + lambda_l
}

/// Height-correlated visibility, `V_SmithJointGGX`. `part_lambda_v` is [`part_lambda`] of the view.
#[inline(always)]
pub fn smith_visibility<L: Lanes>(
    l: L,
    n_dot_l: L::F,
    n_dot_v: L::F,
    roughness: L::F,
    part_lambda_v: L::F,
) -> L::F {
    let sum = smith_sum(l, n_dot_l, n_dot_v, roughness, part_lambda_v);
    l.splat(0.5) / sum.at_least(f32::MIN_POSITIVE)
}

/// Distribution times visibility, `DV_SmithJointGGX`, for punctual lights.
///
/// `part_lambda_v` may come from another roughness, and does where lights raise the roughness. A negative `n_dot_l`
/// can give up to 1.4e37: the product with max(0, N.L) is 0 all the same. Roughness 0 gives 0.
#[inline(always)]
pub fn smith_distribution_visibility<L: Lanes>(
    l: L,
    n_dot_h: L::F,
    n_dot_l: L::F,
    n_dot_v: L::F,
    roughness: L::F,
    part_lambda_v: L::F,
) -> L::F {
    let a2 = roughness.squared();
    let s = distribution_base(l, n_dot_h, a2);
    let sum = smith_sum(l, n_dot_l, n_dot_v, roughness, part_lambda_v);
    a2 * (FRAC_1_PI * 0.5) / (s * s * sum).at_least(f32::MIN_POSITIVE)
}

/// Masking of one direction, `G_MaskingSmithGGX`: 2 / (1 + sqrt(1 + a^2 ((N.V)^-2 - 1))); 0 at N.V = 0.
///
/// At N.V = 0 and roughness 0 the original is 0 * infinity; here it is 1, as for every other angle.
#[inline(always)]
pub fn smith_masking<L: Lanes>(l: L, n_dot_v: L::F, roughness: L::F) -> L::F {
    let a2 = roughness.squared();
    let slope = a2 * (n_dot_v.squared().recip() - 1.0);
    let slope = a2.eq(l.zero()).select(l.zero(), slope);
    ((slope + 1.0).sqrt() * 0.5 + 0.5).recip()
}

/// Components of a direction in a tangent frame: along the tangent, the bitangent and the normal.
pub type FrameCosines<L> = V3<L>;

/// The squared length of (aB T.H, aT B.H, aT aB N.H), and aT aB.
#[inline(always)]
fn anisotropic_base<L: Lanes>(_: L, half: FrameCosines<L>, roughness: [L::F; 2]) -> (L::F, L::F) {
    let [along_t, along_b] = roughness;
    let a2 = along_t * along_b;
    let v = Vec3::new(along_b * half.x, along_t * half.y, a2 * half.z);
    (v.dot(v), a2)
}

/// The anisotropic distribution per steradian, `D_GGXAniso`. `half` is the half vector in the tangent frame,
/// `roughness` that along the tangent and along the bitangent.
#[inline(always)]
pub fn anisotropic_distribution<L: Lanes>(l: L, half: FrameCosines<L>, roughness: [L::F; 2]) -> L::F {
    let (s, a2) = anisotropic_base(l, half, roughness);
    safe_div(l, a2 * a2 * a2, s * s) * FRAC_1_PI
}

/// [`part_lambda`] of an anisotropic surface, `GetSmithJointGGXAnisoPartLambdaV`, of a direction in the tangent
/// frame.
#[inline(always)]
pub fn anisotropic_part_lambda<L: Lanes>(_: L, direction: FrameCosines<L>, roughness: [L::F; 2]) -> L::F {
    Vec3::new(roughness[0] * direction.x, roughness[1] * direction.y, direction.z).length()
}

/// Sum of the Smith terms of view and light on an anisotropic surface.
#[inline(always)]
fn anisotropic_smith_sum<L: Lanes>(
    l: L,
    light: FrameCosines<L>,
    n_dot_v: L::F,
    roughness: [L::F; 2],
    part_lambda_v: L::F,
) -> L::F {
    light.z * part_lambda_v + n_dot_v * anisotropic_part_lambda(l, light, roughness)
}

/// Height-correlated visibility of an anisotropic surface, `V_SmithJointGGXAniso`. Infinite where both cosines
/// are 0: the original has no guard.
#[inline(always)]
pub fn anisotropic_smith_visibility<L: Lanes>(
    l: L,
    light: FrameCosines<L>,
    n_dot_v: L::F,
    roughness: [L::F; 2],
    part_lambda_v: L::F,
) -> L::F {
    l.splat(0.5) / anisotropic_smith_sum(l, light, n_dot_v, roughness, part_lambda_v)
}

/// Distribution times visibility of an anisotropic surface, `DV_SmithJointGGXAniso`. See
/// [`smith_distribution_visibility`].
#[inline(always)]
pub fn anisotropic_distribution_visibility<L: Lanes>(
    l: L,
    half: FrameCosines<L>,
    light: FrameCosines<L>,
    n_dot_v: L::F,
    roughness: [L::F; 2],
    part_lambda_v: L::F,
) -> L::F {
    let (s, a2) = anisotropic_base(l, half, roughness);
    let sum = anisotropic_smith_sum(l, light, n_dot_v, roughness, part_lambda_v);
    a2 * a2 * a2 * (FRAC_1_PI * 0.5) / (s * s * sum).at_least(f32::MIN_POSITIVE)
}

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
