//! Fresnel reflectance and its change at the boundary to a clear coat.

use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;

/// `x^4` as the square of a square.
#[inline(always)]
pub fn pow4<L: Lanes>(_: L, x: L::F) -> L::F {
    (x * x) * (x * x)
}

/// F0 of a surface under a coat of index 1.5, from its F0 in air: the cubic fit of Unity's
/// `ConvertF0ForAirInterfaceToF0ForClearCoat15` (core/CommonMaterial), 0 to 1; within 0.0037 of the exact
/// value from 0.04 upwards.
#[inline(always)]
pub fn f0_under_coat<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * ((f0 * -0.283_835 + 0.978_946) * f0 + 0.326_846) + -0.025_686_8).saturate()
}

/// As [`f0_under_coat`], by the quadratic fit that Unity uses on mobile and in its newest version
/// (`ConvertF0ForAirInterfaceToF0ForClearCoat15Fast`); within 0.0091.
#[inline(always)]
pub fn f0_under_coat_fast<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * (f0 * 0.526_868 + 0.529_324) - 0.048_225_6).saturate()
}

/// Largest F0 that [`fresnel0_to_ior`] is asked for when the medium above changes: beyond, the index grows
/// without bound.
const MAX_CONVERTIBLE_F0: f32 = 0.999;

/// `(1 - u)^5` with the powers in the order of Unity's `F_Schlick`.
#[inline(always)]
fn schlick_weight<L: Lanes>(_: L, cosine: L::F) -> L::F {
    let x = cosine.one_minus();
    let x2 = x * x;
    x * x2 * x2
}

/// Schlick's reflectance of one number, (f90 - f0) (1 - u)^5 + f0, at the cosine u of the incident (or half)
/// angle. Unity core/BSDF, `F_Schlick`; Schlick, "An Inexpensive BRDF Model for Physically-based Rendering",
/// 1994.
#[inline(always)]
pub fn schlick<L: Lanes>(l: L, f0: L::F, f90: L::F, cosine: L::F) -> L::F {
    (f90 - f0) * schlick_weight(l, cosine) + f0
}

/// Schlick's reflectance of a colour, f0 (1 - x5) + f90 x5. Unity core/BSDF, `F_Schlick`.
#[inline(always)]
pub fn schlick_color<L: Lanes>(l: L, f0: V3<L>, f90: L::F, cosine: L::F) -> V3<L> {
    let x5 = schlick_weight(l, cosine);
    let (rest, grazing) = (x5.one_minus(), f90 * x5);
    f0 * rest + grazing
}

/// Complement of Schlick's reflectance, (1 - f90 x5) - f0 (1 - x5). Unity core/BSDF, `F_Transm_Schlick`.
#[inline(always)]
pub fn schlick_transmission<L: Lanes>(l: L, f0: L::F, f90: L::F, cosine: L::F) -> L::F {
    let x5 = schlick_weight(l, cosine);
    (f90 * x5).one_minus() - f0 * x5.one_minus()
}

/// F0 of the boundary from index `incident` to index `transmitted`, ((t - i) / (t + i))^2. Unity core/BSDF,
/// `IorToFresnel0`.
#[inline(always)]
pub fn ior_to_fresnel0<L: Lanes>(_: L, transmitted: L::F, incident: L::F) -> L::F {
    ((transmitted - incident) / (transmitted + incident)).squared()
}

/// Index of refraction (at least 1) of a dielectric with F0 in air; infinite at 1. Unity core/BSDF,
/// `Fresnel0ToIor`.
#[inline(always)]
pub fn fresnel0_to_ior<L: Lanes>(_: L, f0: L::F) -> L::F {
    let root = f0.sqrt();
    (root + 1.0) / root.one_minus()
}

/// F0 (in air, 0 to 1) as it is under a medium of index `top`, per channel. Unity StackLit,
/// `ConvertF0NewTopIor`: `IorToFresnel0(Fresnel0ToIor(min(f0, 0.999)), top)`, here with one division instead
/// of two.
#[inline(always)]
pub fn f0_under_ior<L: Lanes>(_: L, f0: V3<L>, top: L::F) -> V3<L> {
    let root = f0.at_most(MAX_CONVERTIBLE_F0).sqrt();
    let (numerator, denominator) = (root + 1.0, root.one_minus() * top);
    ((numerator - denominator) / (numerator + denominator)).squared()
}

/// Reflectance of unpolarised light at a smooth boundary between dielectrics, from cosine c on the side of
/// index `n1` (Unity StackLit, `FresnelUnpolarized`). Two quirks of the original: equal indices give exactly
/// 0, and total internal reflection gives 0, not 1.
///
/// A cosine above 1, which rounding makes, counts as it is: the sine is then negative and no root fails.
#[inline(always)]
pub fn fresnel_unpolarized<L: Lanes>(l: L, cosine: L::F, n1: L::F, n2: L::F) -> L::F {
    let ratio = n2 / n1;
    let sine2 = (ratio * ratio) * (cosine * cosine).one_minus();
    let refracts = sine2.le(l.splat(1.0)) & !ratio.eq(l.splat(1.0));
    let transmitted = sine2.one_minus().at_least(0.0).sqrt();
    let s = (ratio * cosine - transmitted) / (ratio * cosine + transmitted);
    let p = (cosine - ratio * transmitted) / (ratio * transmitted + cosine);
    refracts.select((s * s + p * p) * 0.5, l.zero())
}

/// Reflectance of a dielectric of relative index `ior` for unpolarised light at cosine u; 1 where the
/// reflection is total. Unity core/BSDF, `F_FresnelDielectric`; Walter et al., "Microfacet Models for
/// Refraction through Rough Surfaces", 2007, equation 22. The original takes the root of a negative number
/// where the reflection is total and lets the saturation drop the NaN; here the root ends at 0, which gives 1
/// as well.
#[inline(always)]
pub fn fresnel_dielectric<L: Lanes>(_: L, ior: L::F, cosine: L::F) -> L::F {
    let g = (ior * ior + cosine * cosine - 1.0).at_least(0.0).sqrt();
    let (sum, difference) = (g + cosine, g - cosine);
    let first = (difference / sum).squared() * 0.5;
    let second = ((sum * cosine - 1.0) / (difference * cosine + 1.0)).squared();
    (first * (second + 1.0)).one_minus().saturate().one_minus()
}

/// Factor by which a GGX lobe of F0 is scaled to return the light lost between microfacets, 1 + f0 (1/E - 1),
/// where `reflectivity` E > 0 is the directional albedo of the lobe for F0 = 1 (the second channel of
/// HDRP's pre-integrated table). Unity core/BSDF, `GetEnergyCompensationFactor`; Turquin, "Practical
/// multiple scattering compensation for microfacet models", 2019.
#[inline(always)]
pub fn energy_compensation_factor<L: Lanes>(_: L, reflectivity: L::F, f0: V3<L>) -> V3<L> {
    let lost = reflectivity.recip() - 1.0;
    f0 * lost + 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;
    use overcoat_core::math::vec3::Vec3;

    /// The fits against the exact change of interface: F0 to index of refraction, and its F0 against 1.5.
    #[test]
    fn fits_follow_the_change_of_interface() {
        let mut worst = [0.0_f32; 2];
        // From the coat's own F0 upwards; below, the exact value rises again, and the fits stay at 0.
        for k in 40..=999 {
            let f0 = k as f32 / 1000.0;
            let ior = (1.0 + f0.sqrt()) / (1.0 - f0.sqrt());
            let exact = {
                let r = (ior - 1.5) / (ior + 1.5);
                r * r
            };
            let x = Scalar.splat(f0);
            for (fit, worst) in
                [f0_under_coat(Scalar, x), f0_under_coat_fast(Scalar, x)].iter().zip(&mut worst)
            {
                let error = (fit.to_array()[0] - exact).abs();
                *worst = if error > *worst { error } else { *worst };
            }
        }
        assert!(worst[0] < 0.0037 && worst[1] < 0.0091, "{worst:?}");
    }

    fn one(x: f32) -> <Scalar as Lanes>::F {
        Scalar.splat(x)
    }

    /// At normal incidence all forms agree with F0, at grazing incidence with 1.
    #[test]
    fn forms_agree_at_both_ends() {
        let near = |found: <Scalar as Lanes>::F, expected: f32| {
            let found = found.to_array()[0];
            assert!((found - expected).abs() < 2e-6, "{found} not {expected}");
        };
        for k in 11..40 {
            let n = k as f32 / 10.0;
            let f0 = ior_to_fresnel0(Scalar, one(n), one(1.0));
            near(fresnel0_to_ior(Scalar, f0) / n, 1.0);
            let f0_number = f0.to_array()[0];
            near(fresnel_unpolarized(Scalar, one(1.0), one(n), one(1.0)), f0_number);
            near(fresnel_unpolarized(Scalar, one(1.0), one(1.0), one(n)), f0_number);
            near(fresnel_dielectric(Scalar, one(n), one(1.0)), f0_number);
            near(schlick(Scalar, f0, one(1.0), one(1.0)), f0_number);
            near(schlick(Scalar, f0, one(1.0), one(0.0)), 1.0);
            near(fresnel_dielectric(Scalar, one(n), one(0.0)), 1.0);
            near(f0_under_ior(Scalar, Vec3::uniform(f0), one(1.0)).y, f0_number);
            near(f0_under_ior(Scalar, Vec3::uniform(f0), one(n)).z, 0.0);
            for u in 0..=10 {
                let u = one(u as f32 / 10.0);
                near(schlick(Scalar, f0, one(1.0), u) + schlick_transmission(Scalar, f0, one(1.0), u), 1.0);
            }
        }
    }

    #[test]
    fn nothing_is_reflected_between_equal_media_nor_when_all_should_be() {
        assert_eq!(fresnel_unpolarized(Scalar, one(0.3), one(1.5), one(1.5)).to_array()[0], 0.0);
        assert_eq!(fresnel_unpolarized(Scalar, one(0.3), one(1.0), one(1.5)).to_array()[0], 0.0);
        assert_eq!(fresnel_dielectric(Scalar, one(0.5), one(0.3)).to_array()[0], 1.0);
    }
}
