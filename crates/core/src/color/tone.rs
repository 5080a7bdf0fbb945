//! Tone curves: from scene-referred to display-referred light.

use crate::each;
use crate::math::lanes::{Float, Lanes, Mask};
use std::fmt;
use std::str::FromStr;

/// Curve of the tone mapping, from radiance of any magnitude to display light from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ToneCurve {
    /// Light above 1 is cut off per channel.
    None,
    /// Khronos PBR Neutral: base colours below 0.76 keep hue and brightness, highlights are compressed and fade to
    /// white. <https://github.com/KhronosGroup/ToneMapping/blob/main/PBR_Neutral/README.md>
    #[default]
    Neutral,
    /// The ACES reference transforms (RRT + ODT, sRGB, 100 nits), fitted by Stephen Hill:
    /// <https://github.com/TheRealMJP/BakingLab/blob/master/BakingLab/ACES.hlsl>. Light is multiplied by 1 / 0.6
    /// first, as three.js does (`ACESFilmicToneMapping`), so that pictures have the brightness that web viewers
    /// give them.
    Aces,
    /// AgX by Troy Sobotka, base look, with Benjamin Wrensch's polynomial for the contrast curve
    /// (<https://iolite-engine.com/blog_posts/minimal_agx_implementation>), working in Rec. 2020 as three.js
    /// (`AgXToneMapping`) and Filament do.
    Agx,
}

impl ToneCurve {
    /// All of them.
    pub const ALL: &[Self] = &[Self::None, Self::Neutral, Self::Aces, Self::Agx];

    /// Name as `--tone-map` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Neutral => "neutral",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// The curve of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|curve| curve.name() == name)
    }

    /// Takes linear Rec. 709 scene light (exposure already applied) to linear Rec. 709 display light, 0 to 1.
    /// Negative numbers and NaN count as 0, numbers above 1e9 as that.
    #[inline(always)]
    #[doc(hidden)]
    pub fn apply<L: Lanes>(self, l: L, rgb: [L::F; 3]) -> [L::F; 3] {
        let rgb = each!(c in rgb => c.clamp_to(0.0, 1e9));
        let mapped = match self {
            Self::None => rgb,
            Self::Neutral => neutral(l, rgb),
            Self::Aces => aces(l, rgb),
            Self::Agx => agx(l, rgb),
        };
        each!(c in mapped => c.saturate())
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no tone curve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tone curve '{0}'; known are none, neutral, aces and agx")]
pub struct UnknownToneCurve(String);

impl FromStr for ToneCurve {
    type Err = UnknownToneCurve;
    fn from_str(name: &str) -> Result<Self, UnknownToneCurve> {
        Self::from_name(name).ok_or_else(|| UnknownToneCurve(name.to_owned()))
    }
}

/// Row-major 3x3 matrix times column.
#[inline(always)]
fn transform<F: Float>(m: &[[f32; 3]; 3], v: [F; 3]) -> [F; 3] {
    each!(k => v[0] * m[k][0] + v[1] * m[k][1] + v[2] * m[k][2])
}

/// Khronos PBR Neutral, in the order of operations of its specification.
#[inline(always)]
fn neutral<L: Lanes>(l: L, rgb: [L::F; 3]) -> [L::F; 3] {
    /// Fresnel reflectance at normal incidence that a base colour is seen through.
    const F90: f32 = 0.04;
    /// Peak above which colours are compressed.
    const KS: f32 = 0.8 - F90;
    /// Rate at which compressed colours fade to white.
    const KD: f32 = 0.15;
    let least = rgb[0].min(rgb[1]).min(rgb[2]);
    let toe = least - least.squared() * 6.25;
    let offset = least.lt(l.splat(0.08)).select(toe, l.splat(F90));
    let rgb = each!(c in rgb => c - offset);
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    let compressed = peak.ge(l.splat(KS));
    // Where nothing is bright, the divisions are for nothing.
    if !compressed.any() {
        return rgb;
    }
    let d = 1.0 - KS;
    let new_peak = l.splat(1.0) - l.splat(d * d) / (peak + (d - KS));
    let white = l.splat(1.0) - ((peak - new_peak) * KD + 1.0).recip();
    // Lanes that are not compressed divide by whatever the peak is, and are not selected.
    let scale = new_peak / peak;
    each!(c in rgb => compressed.select((c * scale).lerp(new_peak, white), c))
}

/// Hill's fit of the ACES transforms, with three.js's exposure of 1 / 0.6.
#[inline(always)]
fn aces<L: Lanes>(l: L, rgb: [L::F; 3]) -> [L::F; 3] {
    /// sRGB to XYZ, D65 to D60, to AP1, RRT saturation.
    const INPUT: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    /// ODT saturation, to XYZ, D60 to D65, to sRGB.
    const OUTPUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let _ = l;
    let working = transform(&INPUT, each!(c in rgb => c * (1.0 / 0.6)));
    let curved = each!(v in working =>
        (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (v * 0.983_729 + 0.432_951_0) + 0.238_081));
    transform(&OUTPUT, curved)
}

/// AgX: inset, logarithm, contrast curve, outset.
#[inline(always)]
fn agx<L: Lanes>(l: L, rgb: [L::F; 3]) -> [L::F; 3] {
    /// ITU-R BT.2407.
    const REC709_FROM_REC2020: [[f32; 3]; 3] =
        [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
    /// Its inverse.
    const REC2020_FROM_REC709: [[f32; 3]; 3] = [
        [0.627_409_4, 0.329_260_25, 0.043_271_89],
        [0.069_124_84, 0.919_548_6, 0.011_320_77],
        [0.016_423_36, 0.088_047_85, 0.895_616_7],
    ];
    const INSET: [[f32; 3]; 3] = [
        [0.856_627_15, 0.095_121_24, 0.048_251_606],
        [0.137_318_97, 0.761_242_0, 0.101_439_04],
        [0.111_898_21, 0.076_799_42, 0.811_302_4],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.127_100_6, -0.110_606_64, -0.016_493_939],
        [-0.141_329_76, 1.157_823_7, -0.016_493_939],
        [-0.141_329_76, -0.110_606_64, 1.251_936_4],
    ];
    /// Stops around middle grey: log2(0.18) - 10 and log2(0.18) + 6.5.
    const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
    let working = transform(&INSET, transform(&REC2020_FROM_REC709, rgb));
    let contrast = each!(v in working => {
        let x = (crate::math::log2(l, v.at_least(1e-10)) - STOPS[0]) * (1.0 / (STOPS[1] - STOPS[0]));
        let x = x.saturate();
        let x2 = x * x;
        let x4 = x2 * x2;
        x4 * x2 * 15.5 - x4 * x * 40.14 + x4 * 31.96 - x2 * x * 6.868 + x2 * 0.4298 + x * 0.1191 - 0.00232
    });
    let display =
        each!(v in transform(&OUTSET, contrast) => crate::math::pow(l, v.at_least(0.0), l.splat(2.2)));
    transform(&REC709_FROM_REC2020, display)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch;
    use crate::math::lanes::{LANES, SimdLevel};

    /// The curve of one colour.
    fn map(curve: ToneCurve, rgb: [f32; 3]) -> [f32; 3] {
        dispatch!(SimdLevel::best(), l => curve.apply(l, rgb.map(|c| l.splat(c))).map(|c| c.to_array()[3]))
    }

    fn assert_close(got: [f32; 3], want: [f32; 3], tolerance: f32) {
        for k in 0..3 {
            assert!((got[k] - want[k]).abs() <= tolerance, "{got:?} is not {want:?}");
        }
    }

    #[test]
    fn every_name_leads_back_to_its_curve() {
        for &curve in ToneCurve::ALL {
            assert_eq!(curve.name().parse(), Ok(curve));
        }
        assert!("filmic".parse::<ToneCurve>().unwrap_err().to_string().contains("'filmic'"));
    }

    #[test]
    fn none_only_cuts_off() {
        assert_eq!(map(ToneCurve::None, [0.25, 1.0, 7.0]), [0.25, 1.0, 1.0]);
    }

    /// The purpose of the curve: a diffuse base colour under unit light, seen with its 4 percent of specular
    /// reflection on top, comes out as the base colour itself, up to 0.8 - 0.04.
    #[test]
    fn neutral_shows_base_colours_as_they_are() {
        for base in [0.05_f32, 0.18, 0.5, 0.755] {
            assert_close(map(ToneCurve::Neutral, [base + 0.04; 3]), [base; 3], 1e-6);
        }
    }

    /// Computed in double precision from the formula of the specification.
    #[test]
    fn neutral_known_answers() {
        assert_close(map(ToneCurve::Neutral, [0.02, 0.3, 0.05]), [0.0025, 0.2825, 0.0325], 1e-6);
        assert_close(map(ToneCurve::Neutral, [1.0; 3]), [0.869_090_9; 3], 1e-6);
        assert_close(map(ToneCurve::Neutral, [4.0, 1.0, 0.25]), NEUTRAL_BRIGHT, 2e-6);
    }
    const NEUTRAL_BRIGHT: [f32; 3] = [0.983_255_8, 0.468_299_2, 0.339_56];

    /// Value and slope agree where compression starts.
    #[test]
    fn neutral_is_smooth_at_its_threshold() {
        let h = 1e-3;
        let at = |x: f32| map(ToneCurve::Neutral, [x; 3])[0];
        let below = (at(0.8) - at(0.8 - h)) / h;
        let above = (at(0.8 + h) - at(0.8)) / h;
        assert!((below - 1.0).abs() < 1e-3 && (above - 1.0).abs() < 1e-2, "{below} {above}");
    }

    /// Computed in double precision from the published matrices and fits.
    #[test]
    fn aces_and_agx_known_answers() {
        assert_close(map(ToneCurve::Aces, [0.18; 3]), ACES_GREY, 3e-6);
        assert_close(map(ToneCurve::Aces, [2.0, 0.5, 0.05]), ACES_ORANGE, 3e-6);
        assert_close(map(ToneCurve::Agx, [0.18; 3]), AGX_GREY, 3e-5);
        assert_close(map(ToneCurve::Agx, [2.0, 0.5, 0.05]), AGX_ORANGE, 3e-5);
    }
    const ACES_GREY: [f32; 3] = [0.213_105_45, 0.213_105_45, 0.213_103_3];
    const ACES_ORANGE: [f32; 3] = [0.986_555, 0.604_349_4, 0.158_138_7];
    const AGX_GREY: [f32; 3] = [0.214_524_3, 0.214_520_4, 0.214_514_5];
    const AGX_ORANGE: [f32; 3] = [0.819_190_6, 0.452_264_2, 0.232_645_6];

    #[test]
    fn greys_rise_with_light_and_stay_between_black_and_white() {
        for &curve in ToneCurve::ALL {
            let mut last = -1.0;
            for step in 0..200 {
                let light = 0.001 * (step * step) as f32;
                let [r, g, b] = map(curve, [light; 3]);
                assert!((r - g).abs() < 2e-3 && (r - b).abs() < 2e-3, "{curve}: grey is {r} {g} {b}");
                assert!((0.0..=1.0).contains(&r) && r >= last, "{curve} at {light}: {r} after {last}");
                last = r;
            }
            assert!(last > 0.95, "{curve}: white is {last}");
        }
    }

    #[test]
    fn nothing_that_comes_in_leads_outside_0_to_1() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, -0.0, 1e-40, f32::MAX, 0.5];
        for &curve in ToneCurve::ALL {
            for (r, g, b) in odd.iter().flat_map(|&r| odd.iter().map(move |&g| (r, g, 0.3))) {
                let out = map(curve, [r, g, b]);
                assert!(out.iter().all(|c| (0.0..=1.0).contains(c)), "{curve} of {r} {g} {b}: {out:?}");
            }
        }
    }

    #[test]
    fn every_instruction_set_has_the_same_bits() {
        for &curve in ToneCurve::ALL {
            let bits = |level| -> Vec<u32> {
                let mut out = Vec::new();
                for block in 0..64 {
                    let lane = |scale: f32| -> [f32; LANES] {
                        std::array::from_fn(|k| scale * ((block * LANES + k) as f32) * 0.01)
                    };
                    let input = [lane(1.0), lane(0.37), lane(2.3)];
                    let mapped = dispatch!(level, l => {
                        curve.apply(l, [l.load(&input[0]), l.load(&input[1]), l.load(&input[2])])
                            .map(|c| c.to_array())
                    });
                    out.extend(mapped.as_flattened().iter().map(|v| v.to_bits()));
                }
                out
            };
            let expected = bits(SimdLevel::Scalar);
            for level in SimdLevel::available() {
                assert!(bits(level) == expected, "{curve} at {level}");
            }
        }
    }
}
