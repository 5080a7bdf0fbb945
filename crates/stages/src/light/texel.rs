//! Radiance in 32 bits: three mantissas of nine bits and a shared exponent.
//!
//! The packing of the graphics interfaces' RGB9E5 with another range: a channel is `mantissa * 2^(exponent - 20)`,
//! so the format holds 0 to 1,046,528, all that [`EquirectImage`] admits, with an absolute step of 1e-6 at the dark
//! end. The error is at most 1/512 (0.2 percent) of the brightest channel, a quarter of the step of an 8-bit sRGB
//! picture at mid grey; a lookup is one load a texel and a prefiltered chain stays in the cache.
//!
//! [`EquirectImage`]: overcoat_scene::EquirectImage

use overcoat_core::math::lanes::{Int, Lanes};
use overcoat_core::math::vec3::V3;
use overcoat_core::vec3;

/// Largest value that can be stored.
pub(crate) const MAX: f32 = 511.0 * 2048.0;

/// Bias of the stored exponent.
const BIAS: i32 = 20;

/// The float 2^k for -126 <= k <= 127.
fn power_of_two(k: i32) -> f32 {
    f32::from_bits(((k + 127) as u32) << 23)
}

/// The nearest storable colour (ties up). Negative numbers and NaN become 0, numbers above [`MAX`] that.
pub(crate) fn encode(rgb: [f32; 3]) -> u32 {
    let rgb = rgb.map(|c| if c > 0.0 { if c < MAX { c } else { MAX } } else { 0.0 });
    let bits = rgb.map(f32::to_bits);
    // Positive floats are ordered as their bits are.
    let largest = bits[0].max(bits[1]).max(bits[2]);
    // The exponent that puts the largest channel into 256 to 511.
    let mut exponent = ((largest >> 23) as i32 - 127 - 8 + BIAS).max(0);
    let round = |c: f32, exponent: i32| (c * power_of_two(BIAS - exponent) + 0.5) as u32;
    if round(f32::from_bits(largest), exponent) > 511 {
        exponent += 1;
    }
    let [r, g, b] = rgb.map(|c| round(c, exponent));
    (exponent as u32) << 27 | b << 18 | g << 9 | r
}

/// The colour of a texel.
#[cfg(test)]
pub(crate) fn decode(texel: u32) -> [f32; 3] {
    let scale = power_of_two((texel >> 27) as i32 - BIAS);
    [0, 9, 18].map(|shift| (texel >> shift & 511) as f32 * scale)
}

/// Sixteen texels' mantissas and common scales: a channel is `mantissa * scale`, without rounding.
#[inline(always)]
pub(crate) fn unpack<L: Lanes>(_: L, texel: L::I) -> (V3<L>, L::F) {
    let scale = (texel.shr_logical(27) + (127 - BIAS)).shl(23).float_from_bits();
    (vec3!(c => (texel.shr_logical(9 * c as u32) & 511).to_float()), scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    #[test]
    fn the_error_is_below_a_512th_of_the_brightest_channel() {
        let mut state = 1_u32;
        for k in 0..200_000 {
            let mut next = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / 16_777_216.0
            };
            let magnitude = power_of_two(k % 31 - 11);
            let rgb = [next() * magnitude, next() * magnitude, next() * magnitude];
            let found = decode(encode(rgb));
            let brightest = rgb[0].max(rgb[1]).max(rgb[2]);
            let bound = (brightest / 512.0).max(0.5 * power_of_two(-BIAS));
            for c in 0..3 {
                assert!((found[c] - rgb[c]).abs() <= bound, "{rgb:?} -> {found:?}");
            }
        }
    }

    #[test]
    fn decoding_is_undone_by_encoding_and_the_ends_are_safe() {
        for mantissa in 256..512 {
            for exponent in 0..32 {
                let texel = exponent << 27 | (mantissa / 3) << 18 | 7 << 9 | mantissa;
                assert_eq!(encode(decode(texel)), texel);
            }
        }
        assert_eq!(decode(encode([0.0, -1.0, f32::NAN])), [0.0; 3]);
        assert_eq!(decode(encode([f32::INFINITY, 1e6, 0.0])), [MAX, 1e6_f32.round_to(2048.0), 0.0]);
    }

    trait RoundTo {
        fn round_to(self, step: f32) -> f32;
    }
    impl RoundTo for f32 {
        fn round_to(self, step: f32) -> f32 {
            (self / step + 0.5).floor() * step
        }
    }

    #[test]
    fn lanes_decode_as_the_scalar_definition() {
        for base in (0..u32::MAX - 0x0100_0000).step_by(0x0012_3457) {
            let texels: [i32; 16] = std::array::from_fn(|k| (base + 77_777 * k as u32) as i32);
            let (rgb, scale) = unpack(Scalar, Scalar.load_i(&texels));
            for k in 0..16 {
                let found = (rgb * scale).lane(k);
                assert_eq!(found, decode(texels[k] as u32));
            }
        }
    }
}
