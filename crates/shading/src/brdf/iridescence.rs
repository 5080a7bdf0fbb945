//! Thin-film interference as Unity HDRP evaluates it.
//!
//! A film between the medium above and the base reflects light at both of its faces; the phase between the
//! orders of reflection colours the sum. Belcour and Barla, "A Practical Extension to Microfacet Theory for the
//! Modeling of Varying Iridescence", 2017, with Schlick's reflectance at both faces, two orders of
//! interference and no phase shift at the base. Unity core/BSDF, `EvalIridescence`.

use super::fresnel::{fresnel0_to_ior, ior_to_fresnel0, schlick, schlick_color};
use overcoat_core::each;
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Thickness 1 stands for an optical path of 3 micrometres at normal incidence, halved by convention (the
/// film's `Dinc`).
const FULL_THICKNESS: f32 = 3.0;

/// Least and greatest share of light that goes around in the film once, so that its series has a sum.
const LEAST_ROUND_TRIP: f32 = 1e-5;
const GREATEST_ROUND_TRIP: f32 = 0.9999;

/// One Gaussian of the fit to the colour matching functions in Fourier space: val sqrt(2 pi var) over
/// 1.0685e-7 (the normalisation), the position in rad/m and the variance.
struct Gaussian {
    weight: f32,
    position: f32,
    variance: f32,
}

/// sqrt(2 pi).
const SQRT_TAU: f64 = 2.506_628_274_631_000_5;

/// `val sqrt(2 pi var) / 1.0685e-7`, with the root of the variance given.
const fn weight(val: f64, root_of_variance: f64) -> f32 {
    (val * SQRT_TAU * root_of_variance / 1.0685e-7) as f32
}

/// X (two lobes), Y, Z.
const XYZ: [Gaussian; 4] = [
    Gaussian { weight: weight(5.4856e-13, 65_786.016_751_282_34), position: 1.6810e6, variance: 4.3278e9 },
    Gaussian { weight: weight(4.4201e-13, 96_460.354_550_457_68), position: 1.7953e6, variance: 9.3046e9 },
    Gaussian { weight: weight(5.2481e-13, 81_314.820_297_409_5), position: 2.2084e6, variance: 6.6121e9 },
    Gaussian { weight: weight(9.7470e-14, 67_291.901_444_378_88), position: 2.2399e6, variance: 4.5282e9 },
];

/// CIE XYZ to linear Rec. 709.
const XYZ_TO_REC709: [[f32; 3]; 3] = [
    [3.240_969_9, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_058],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

/// The colour of an optical path difference (in micrometres) with a phase shift in radians, linear Rec. 709;
/// components may be negative. Unity core/BSDF, `EvalSensitivity`.
#[inline(always)]
pub fn sensitivity<L: Lanes>(l: L, path_difference: L::F, shift: L::F) -> V3<L> {
    let phase = path_difference * (std::f32::consts::TAU * 1e-6);
    let phase2 = phase * phase;
    let [x, y, z, second_x] = each!(k => {
        let gaussian = &XYZ[k];
        let wave = math::cos(l, phase * gaussian.position + shift);
        wave * math::exp_transmittance(l, phase2 * -gaussian.variance) * gaussian.weight
    });
    let xyz = Vec3::new(x + second_x, y, z);
    vec3!(row in Vec3::from_array(XYZ_TO_REC709) => xyz.dot(Vec3::splat(l, row)))
}

/// Index of refraction of the film: Unity ties it to the thickness, 2 for none to 1 for full.
#[inline(always)]
fn film_ior<L: Lanes>(_: L, thickness: L::F) -> L::F {
    // lerp(2, 1, thickness).
    -thickness + 2.0
}

/// F0 of the base under the film, where the base's index is given relative to what its F0 in air stands for:
/// the optional last argument of `EvalIridescence` (0: none, `f0` stays), to be passed on as `f0` of
/// [`eval_iridescence`]. No material of HDRP uses it. `f0` below 0.9999.
#[inline(always)]
pub fn f0_under_film<L: Lanes>(l: L, thickness: L::F, f0: V3<L>, ior_over_base: L::F) -> V3<L> {
    let film = film_ior(l, thickness);
    let given = ior_over_base.gt(l.zero());
    vec3!(f in f0 => {
        let under = ior_to_fresnel0(l, ior_over_base * fresnel0_to_ior(l, f + 0.0001), film);
        given.select(under, f)
    })
}

/// Reflectance of a base of F0 under a film of thickness 0 to 1 (3 micrometres), seen from a medium of index
/// `top` at cosine u; not negative, 1 where the film reflects totally. It may exceed 1 a little, as the
/// original. Unity core/BSDF, `EvalIridescence`.
#[inline(always)]
pub fn eval_iridescence<L: Lanes>(l: L, top: L::F, cosine: L::F, thickness: L::F, f0: V3<L>) -> V3<L> {
    let one = l.splat(1.0);
    let film = film_ior(l, thickness);
    let distance = thickness * FULL_THICKNESS;
    let ratio = top / film;
    let cosine2 = (ratio * ratio * (cosine * cosine).one_minus()).one_minus();
    let total = cosine2.lt(l.zero());
    // The root of lanes with total reflection is not used.
    let inner = cosine2.at_least(0.0).sqrt();

    let first = schlick(l, ior_to_fresnel0(l, film, top), one, cosine);
    let transmitted = first.one_minus();
    let base = schlick_color(l, f0, one, inner);
    let round_trip = (base * first).clamp_to(LEAST_ROUND_TRIP, GREATEST_ROUND_TRIP);
    let amplitude = round_trip.sqrt();
    let series = base * (transmitted * transmitted) / round_trip.one_minus();

    let mut sum = series + first;
    let mut order = series - transmitted;
    for m in 1..=2 {
        let m = m as f32;
        let color = sensitivity(l, distance * m * inner, l.splat(m * std::f32::consts::PI));
        order *= amplitude;
        sum += order * (color * 2.0);
    }
    Vec3::select(total, Vec3::uniform(one), sum.at_least(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    #[test]
    fn weights_use_the_roots_of_their_variances() {
        let vals = [5.4856e-13_f64, 4.4201e-13, 5.2481e-13, 9.7470e-14];
        for (gaussian, val) in XYZ.iter().zip(vals) {
            let exact = val * (std::f64::consts::TAU * f64::from(gaussian.variance)).sqrt() / 1.0685e-7;
            assert!((f64::from(gaussian.weight) / exact - 1.0).abs() < 2e-7, "{} {exact}", gaussian.weight);
        }
    }

    /// Without a path difference all orders are in phase and the sensitivity is white up to the fit.
    #[test]
    fn no_path_is_nearly_white() {
        let white = sensitivity(Scalar, Scalar.zero(), Scalar.zero()).lane(0);
        assert!(white.iter().all(|c| (c - 1.0).abs() < 0.25), "{white:?}");
    }

    /// A film is seen from a denser medium beyond the critical angle.
    #[test]
    fn total_reflection_is_white() {
        let f0 = Vec3::splat(Scalar, [0.04, 0.5, 0.9]);
        let at = |cosine: f32| {
            let thickness = Scalar.splat(0.9);
            let color = eval_iridescence(Scalar, Scalar.splat(1.5), Scalar.splat(cosine), thickness, f0);
            color.lane(0)
        };
        assert_eq!(at(0.2), [1.0; 3]);
        assert!(at(0.9).iter().all(|c| (0.0..1.0).contains(c)));
    }
}
