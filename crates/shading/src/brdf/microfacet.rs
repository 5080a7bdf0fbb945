//! GGX and its visibility in their textbook forms, isotropic and anisotropic, without any engine's guards.
//!
//! Engines agree on these formulas and differ in what they do where a denominator vanishes. That is why the
//! denominators have functions of their own, and why the visibility terms take the least denominator as a value.
//!
//! `alpha` is the linear roughness, the square of the perceptual one; `alpha2` its square. Cosines with the normal
//! are saturated by the caller.

use super::fresnel::pow4;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// GGX normal distribution, 1/sr: alpha^2 / (pi ((N.H)^2 (alpha^2 - 1) + 1)^2).
///
/// Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), equation 33. For alpha below
/// about 0.01 the denominator cancels near N.H = 1; its square vanishes for N.H = 1 and alpha = 0.
#[inline(always)]
pub fn distribution_ggx<L: Lanes>(_: L, n_dot_h: L::F, alpha2: L::F) -> L::F {
    let d = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
    alpha2 * FRAC_1_PI / (d * d)
}

/// Denominator of the height-correlated Smith visibility: N.L sqrt((N.V)^2 (1 - alpha^2) +
/// alpha^2) + N.V sqrt((N.L)^2 (1 - alpha^2) + alpha^2); the visibility is half its reciprocal.
///
/// Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs" (2014), equation 99, over
/// 4 N.L N.V. 0 only where both cosines are, or alpha and one of them.
#[inline(always)]
pub fn smith_denominator<L: Lanes>(_: L, n_dot_l: L::F, n_dot_v: L::F, alpha2: L::F) -> L::F {
    let view = n_dot_l * (n_dot_v * n_dot_v * alpha2.one_minus() + alpha2).sqrt();
    let light = n_dot_v * (n_dot_l * n_dot_l * alpha2.one_minus() + alpha2).sqrt();
    view + light
}

/// Height-correlated Smith visibility, G / (4 N.L N.V): 0.5 / [`smith_denominator`], which is kept from falling
/// below `least` (0: no guard, and infinity where the denominator is 0).
#[inline(always)]
pub fn visibility_smith<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, alpha2: L::F, least: f32) -> L::F {
    l.splat(0.5) / smith_denominator(l, n_dot_l, n_dot_v, alpha2).at_least(least)
}

/// Denominator of the anisotropic GGX: (ab T.H)^2 + (at B.H)^2 + (at ab N.H)^2; with `half` = (T.H, B.H, N.H), T.H and
/// B.H with their signs, and `alpha` = `[at, ab]`. For unit vectors in an orthonormal frame at least (at ab)^2 if
/// neither alpha is above 1.
#[inline(always)]
pub fn ggx_anisotropic_denominator<L: Lanes>(_: L, half: V3<L>, alpha: [L::F; 2]) -> L::F {
    let [along_t, along_b] = alpha;
    let v = Vec3::new(along_b * half.x, along_t * half.y, along_t * along_b * half.z);
    v.dot(v)
}

/// Anisotropic GGX, 1/sr: 1 / (pi at ab ((T.H / at)^2 + (B.H / ab)^2 + (N.H)^2)^2) for `alpha` = `[at, ab]`, both
/// above 0, with the arguments of [`ggx_anisotropic_denominator`], which is kept from falling below `least` (0: no
/// guard).
///
/// Burley, "Physically Based Shading at Disney" (2012), appendix B.2, exponent 2, in the arrangement of engines:
/// everything times at ab, so that a small alpha does not overflow.
#[inline(always)]
pub fn distribution_ggx_anisotropic<L: Lanes>(l: L, half: V3<L>, alpha: [L::F; 2], least: f32) -> L::F {
    let a2 = alpha[0] * alpha[1];
    let w2 = a2 / ggx_anisotropic_denominator(l, half, alpha).at_least(least);
    a2 * w2 * w2 * FRAC_1_PI
}

/// The anisotropic [`smith_denominator`]: N.L |(at T.V, ab B.V, N.V)| + N.V |(at T.L, ab B.L, N.L)|. `light` and
/// `view` are given in the frame, (T.L, B.L, N.L), tangential parts with their signs.
///
/// Heitz (2014), on stretched surfaces.
#[inline(always)]
pub fn smith_denominator_anisotropic<L: Lanes>(_: L, light: V3<L>, view: V3<L>, alpha: [L::F; 2]) -> L::F {
    let [along_t, along_b] = alpha;
    let masked = light.z * Vec3::new(along_t * view.x, along_b * view.y, view.z).length();
    let shadowed = view.z * Vec3::new(along_t * light.x, along_b * light.y, light.z).length();
    masked + shadowed
}

/// Anisotropic [`visibility_smith`].
#[inline(always)]
pub fn visibility_smith_anisotropic<L: Lanes>(
    l: L,
    light: V3<L>,
    view: V3<L>,
    alpha: [L::F; 2],
    least: f32,
) -> L::F {
    l.splat(0.5) / smith_denominator_anisotropic(l, light, view, alpha).at_least(least)
}

/// Kelemen's visibility, 0.25 / (L.H)^2, with the square at least `least` (0: infinity at L.H = 0). Kelemen and
/// Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model" (2001).
#[inline(always)]
pub fn visibility_kelemen<L: Lanes>(l: L, l_dot_h: L::F, least: f32) -> L::F {
    l.splat(0.25) / (l_dot_h * l_dot_h).at_least(least)
}

/// (1 - u)^5, the weight of Schlick's approximation (1994); u is the cosine, 0 to 1.
#[inline(always)]
pub fn schlick_weight<L: Lanes>(l: L, u: L::F) -> L::F {
    let x = u.one_minus();
    pow4(l, x) * x
}

/// Schlick's Fresnel reflectance: f0 + (f90 - f0) (1 - u)^5.
#[inline(always)]
pub fn schlick<L: Lanes>(l: L, f0: L::F, f90: L::F, u: L::F) -> L::F {
    f0 + (f90 - f0) * schlick_weight(l, u)
}

/// [`schlick`] of a coloured F0 with one reflectance at grazing angles.
#[inline(always)]
pub fn schlick_color<L: Lanes>(l: L, f0: V3<L>, f90: L::F, u: L::F) -> V3<L> {
    let weight = schlick_weight(l, u);
    vec3!(f0 in f0 => f0 + (f90 - f0) * weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    fn splat(x: f32) -> <Scalar as Lanes>::F {
        Scalar.splat(x)
    }
    fn first(x: <Scalar as Lanes>::F) -> f64 {
        f64::from(x.to_array()[0])
    }

    /// The projected area of the microfacets is that of the surface: the integral of D N.H over the hemisphere
    /// is 1, for equal and unequal roughness.
    #[test]
    fn distributions_are_normalised() {
        let (rings, sectors) = (2000, 64);
        for [at, ab] in [[1.0_f32, 1.0], [0.3, 0.3], [0.5, 0.2], [0.1, 0.4]] {
            let (mut isotropic, mut anisotropic) = (0.0, 0.0);
            for ring in 0..rings {
                // cos^2 uniform: the cosine and the sine of the hemisphere's measure are in its differential.
                let cosine = ((ring as f32 + 0.5) / rings as f32).sqrt();
                let sine = (1.0 - cosine * cosine).sqrt();
                isotropic +=
                    first(distribution_ggx(Scalar, splat(cosine), splat(at * at))) / f64::from(rings);
                for sector in 0..sectors {
                    let phi = (sector as f32 + 0.5) * std::f32::consts::TAU / sectors as f32;
                    let (c, s) =
                        (overcoat_core::math::scalar::cos(phi), overcoat_core::math::scalar::sin(phi));
                    let half = Vec3::splat(Scalar, [sine * c, sine * s, cosine]);
                    anisotropic +=
                        first(distribution_ggx_anisotropic(Scalar, half, [splat(at), splat(ab)], 0.0))
                            / f64::from(rings * sectors);
                }
            }
            let pi = std::f64::consts::PI;
            assert!((isotropic * pi - 1.0).abs() < 2e-3, "{at}: {}", isotropic * pi);
            assert!((anisotropic * pi - 1.0).abs() < 2e-3, "{at} {ab}: {}", anisotropic * pi);
        }
    }

    /// With equal roughness the anisotropic forms are the isotropic ones.
    #[test]
    fn equal_roughness_is_isotropic() {
        let l = Scalar;
        let view = Vec3::splat(l, [0.6, 0.0, 0.8]);
        let light = Vec3::splat(l, [-0.48, 0.64, 0.6]);
        let half = (view + light).normalize();
        for alpha in [1.0_f32, 0.5, 0.1, 0.01] {
            let (a, a2) = (splat(alpha), splat(alpha * alpha));
            let near = |x, y| {
                let (x, y) = (first(x), first(y));
                assert!((x - y).abs() <= 1e-4 * y.abs(), "{alpha}: {x} not {y}");
            };
            near(distribution_ggx_anisotropic(l, half, [a; 2], 0.0), distribution_ggx(l, half.z, a2));
            near(
                visibility_smith_anisotropic(l, light, view, [a; 2], 0.0),
                visibility_smith(l, light.z, view.z, a2, 0.0),
            );
        }
    }

    #[test]
    fn schlick_goes_from_f0_to_f90() {
        let l = Scalar;
        assert_eq!(first(schlick(l, splat(0.25), splat(0.75), splat(1.0))), 0.25);
        assert_eq!(first(schlick(l, splat(0.25), splat(0.75), splat(0.0))), 0.75);
        let color = schlick_color(l, Vec3::uniform(splat(0.25)), splat(1.0), splat(0.5));
        assert_eq!(first(color.z), 0.25 + 0.75 / 32.0);
    }
}
