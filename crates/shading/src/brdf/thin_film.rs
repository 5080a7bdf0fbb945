//! Thin-film interference as three.js and the Khronos renderer evaluate it (KHR_materials_iridescence).
//!
//! Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying
//! Iridescence" (SIGGRAPH 2017), in the form of three.js `iridescence_fragment` and of the glTF Sample Renderer
//! `iridescence.glsl` (`evalIridescence`). Both use Schlick's approximation at both interfaces and two orders of
//! interference; they differ in the weight of Schlick's term, which is a value here.
//!
//! Deviations, by rounding only: the phase shifts of the interfaces are 0, pi or 2 pi, so they enter as the sign
//! of the cosine instead of being added to its argument (where single precision would blur them at thick films);
//! the constant factors of the sensitivity curves are multiplied beforehand.

use super::microfacet::schlick_weight;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{cos, exp_transmittance, exp2};
use overcoat_core::vec3;

/// Form of the weight (1 - u)^5 in Schlick's Fresnel term: exact or approximate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SchlickWeight {
    /// (1 - u)^5.
    Power,
    /// 2^((-5.55473 u - 6.98316) u): Karis, "Real Shading in Unreal Engine 4" (SIGGRAPH 2013). Within 3.8e-3 of
    /// the power; 1.7e-4 instead of 0 at u = 1.
    SphericalGaussian,
}

impl SchlickWeight {
    /// The weight for a cosine u of 0 to 1.
    #[inline(always)]
    pub fn at<L: Lanes>(self, l: L, u: L::F) -> L::F {
        match self {
            Self::Power => schlick_weight(l, u),
            Self::SphericalGaussian => exp2(l, (u * -5.55473 - 6.98316) * u),
        }
    }
}

/// A film of one refractive index on a base, under air.
#[derive(Clone, Copy)]
pub struct ThinFilm<L: Lanes> {
    /// Refractive index, 1 or more. Below a thickness of 0.03 nm it goes to 1.
    pub ior: L::F,
    /// Nanometres.
    pub thickness: L::F,
}

/// F0 of the film at most; the index of the base becomes infinite at 1.
const LARGEST_F0: f32 = 0.9999;

/// A peak of the sensitivity curves of the eye, as the Fourier transform of a Gaussian: the amplitude
/// val sqrt(2 pi var) / 1.0685e-7, the position and the variance, of the latter two per metre of path.
struct Peak {
    amplitude: f32,
    position: f32,
    variance: f32,
}

/// X, Y, Z, and the second peak of X.
const PEAKS: [Peak; 4] = [
    Peak { amplitude: 0.846_59, position: 1.6810e6, variance: 4.3278e9 },
    Peak { amplitude: 1.000_221_9, position: 1.7953e6, variance: 9.3046e9 },
    Peak { amplitude: 1.001_122_5, position: 2.2084e6, variance: 6.6121e9 },
    Peak { amplitude: 0.153_868_3, position: 2.2399e6, variance: 4.5282e9 },
];

/// CIE XYZ to linear Rec. 709, by rows.
const XYZ_TO_REC709: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// The peaks for an optical path difference in nanometres, before the phase shifts.
#[inline(always)]
fn sensitivity_peaks<L: Lanes>(l: L, path_difference: L::F) -> [L::F; 4] {
    let phase = path_difference * (2.0 * std::f32::consts::PI * 1e-9);
    each!(k => {
        let peak = &PEAKS[k];
        // The tail is exactly 0 below e^-25, a billionth of the peak's height.
        let envelope = exp_transmittance(l, -(phase * phase) * peak.variance);
        cos(l, phase * peak.position) * envelope * peak.amplitude
    })
}

/// Linear Rec. 709 of the peaks, where `flipped` holds -1 for a phase shift of pi and 1 for none. The originals
/// shift X, Y and Z by the phases of the red, green and blue base.
#[inline(always)]
fn sensitivity<L: Lanes>(l: L, peaks: &[L::F; 4], flipped: V3<L>) -> V3<L> {
    let xyz = Vec3::new(peaks[0] + peaks[3], peaks[1], peaks[2]) * flipped;
    vec3!(row in Vec3::from_array(XYZ_TO_REC709) => xyz.dot(Vec3::splat(l, row)))
}

/// `evalIridescence`: the Fresnel reflectance of the film on each of two bases (a dielectric and a metal share
/// all that depends on the film alone), linear Rec. 709, not negative; it exceeds 1 a little where colours leave
/// the gamut.
///
/// `cosine` is that of view and normal, 0 to 1; `base_f0` the bases' F0, of which at most 0.9999 counts.
#[inline(never)]
pub fn eval_iridescence<L: Lanes>(
    l: L,
    weight: SchlickWeight,
    film: &ThinFilm<L>,
    cosine: L::F,
    base_f0: &[V3<L>; 2],
) -> [V3<L>; 2] {
    l.run(
        #[inline(always)]
        || eval_iridescence_inline(l, weight, film, cosine, base_f0),
    )
}

#[inline(always)]
fn eval_iridescence_inline<L: Lanes>(
    l: L,
    weight: SchlickWeight,
    film: &ThinFilm<L>,
    cosine: L::F,
    base_f0: &[V3<L>; 2],
) -> [V3<L>; 2] {
    let one = l.splat(1.0);
    // Without thickness there is no film: its index goes to that of air.
    let t = (film.thickness / 0.03).saturate();
    let presence = t * t * (l.splat(3.0) - t * 2.0);
    let ior = presence.one_minus() + film.ior * presence;
    let ratio = one / ior;
    let sine2 = ratio * ratio * (cosine * cosine).one_minus();
    let cosine2 = sine2.one_minus();
    // Only for an index below 1.
    let total_reflection = cosine2.lt(l.zero());
    let cosine_inside = cosine2.at_least(0.0).sqrt();

    // Air to film.
    let r0 = ((ior - 1.0) / (ior + 1.0)).squared();
    let r12 = r0 + r0.one_minus() * weight.at(l, cosine);
    let t121 = r12.one_minus();
    let outer_flip = ior.lt(one).select(one, l.splat(-1.0));

    let path_difference = ior * 2.0 * film.thickness * cosine_inside;
    let first = sensitivity_peaks(l, path_difference);
    // Twice any of the shifts is a whole turn.
    let second = sensitivity(l, &sensitivity_peaks(l, path_difference * 2.0), Vec3::uniform(one));
    let inside = weight.at(l, cosine_inside);

    each!(f0 in *base_f0 => {
        // Film to base.
        let root = f0.clamp_to(0.0, LARGEST_F0).sqrt();
        let base_ior = (root + 1.0) / root.one_minus();
        let flipped = vec3!(n in base_ior => n.lt(ior).select(-outer_flip, outer_flip));
        let first = sensitivity(l, &first, flipped);
        let r1 = ((base_ior - ior) / (base_ior + ior)).squared();
        let r23 = r1 + r1.one_minus() * inside;
        let r123 = (r23 * r12).clamp_to(1e-5, LARGEST_F0);
        let amplitude = r123.sqrt();
        let rs = r23 * (t121 * t121) / r123.one_minus();
        let c1 = (rs - t121) * amplitude;
        let c2 = c1 * amplitude;
        let i = rs + r12 + c1 * (first * 2.0) + c2 * (second * 2.0);
        Vec3::select(total_reflection, Vec3::uniform(one), i.at_least(0.0))
    })
}
