//! The sRGB transfer function (IEC 61966-2-1), exact in both directions for 8-bit codes.
//!
//! Decoding: `c / 12.92` up to 0.04045, `((c + 0.055) / 1.055)^2.4` above, rounded to the nearest `f32`. Encoding to
//! 8 bits is its exact inverse: the code whose decoding interval contains the value, so the answer never depends on
//! how a power function was approximated. Powers are roots of integer powers by Newton's method in `f64`, which
//! needs only exactly rounded operations; the tables are computed by the compiler.

use crate::math::lanes::{ByteTable, Float, Int, LANES, Lanes, Mask, SimdLevel};

/// Linear value, 0 to 1, of every 8-bit sRGB code: the exact value rounded to the nearest `f32`.
pub static SRGB8_TO_LINEAR: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < 256 {
        table[code] = decode(code as f64 / 255.0) as f32;
        code += 1;
    }
    table
};

/// [`SRGB8_TO_LINEAR`] for [`Lanes::look_up_bytes`]. A constant, which code reaches without asking where it is: of a static,
/// compilers copied half a table into every call's frame.
pub const SRGB8_LANES: ByteTable = ByteTable::new(SRGB8_TO_LINEAR);

/// Linear value of an 8-bit sRGB code.
#[must_use]
pub fn srgb8_to_linear(code: u8) -> f32 {
    SRGB8_TO_LINEAR[usize::from(code)]
}

/// `THRESHOLDS[k]` is the least `f32` that encodes to at least `k`; one that nothing reaches ends the table.
static THRESHOLDS: [f32; 257] = {
    let mut table = [0.0; 257];
    let mut code = 1;
    while code < 256 {
        let exact = decode((code as f64 - 0.5) / 255.0);
        let nearest = exact as f32;
        table[code] = if (nearest as f64) < exact { f32::from_bits(nearest.to_bits() + 1) } else { nearest };
        code += 1;
    }
    table[256] = f32::INFINITY;
    table
};

/// Mantissa bits of a bucket's number: with 7, no bucket holds more than one threshold.
const BUCKET_SHIFT: u32 = 23 - 7;
/// Bucket of 2^-13, just below the first threshold.
const FIRST_BUCKET: u32 = (127 - 13) << 7;
/// Number of buckets from there to 1.
const BUCKETS: usize = 13 << 7;

/// The code at the lower end of every bucket of floats that share sign, exponent and seven mantissa bits.
static BUCKET_CODES: [u8; BUCKETS] = {
    let mut table = [0; BUCKETS];
    let mut bucket = 0;
    let mut code = 0;
    while bucket < BUCKETS {
        let start = f32::from_bits((FIRST_BUCKET + bucket as u32) << BUCKET_SHIFT);
        while THRESHOLDS[code + 1] <= start {
            code += 1;
        }
        table[bucket] = code as u8;
        bucket += 1;
    }
    table
};

/// The positive fifth root, to about 1e-15 relative.
const fn fifth_root(y: f64) -> f64 {
    // A fifth of the exponent is within a few percent; the error squares with every step.
    let mut root = f64::from_bits(y.to_bits() / 5 + (1023_u64 << 52) / 5 * 4);
    let mut step = 0;
    while step < 6 {
        root = (4.0 * root + y / (root * root * root * root)) / 5.0;
        step += 1;
    }
    root
}

/// The positive cube root, to about 1e-15 relative.
fn cube_root(y: f64) -> f64 {
    let mut root = f64::from_bits(y.to_bits() / 3 + (1023_u64 << 52) / 3 * 2);
    for _ in 0..6 {
        root = (2.0 * root + y / (root * root)) / 3.0;
    }
    root
}

const fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        // t^2.4 = t^2 * (t^2)^(1/5)
        let square = {
            let t = (encoded + 0.055) / 1.055;
            t * t
        };
        square * fifth_root(square)
    }
}

/// sRGB to linear, correctly rounded but for ties closer than 1e-15. Values below 0 continue the linear segment,
/// values above 1 the power; for finite input. For colours given as numbers; texels use [`SRGB8_TO_LINEAR`].
#[must_use]
pub fn srgb_to_linear(encoded: f32) -> f32 {
    decode(f64::from(encoded)) as f32
}

/// Linear to sRGB, the inverse of [`srgb_to_linear`] with the same accuracy and ranges. For 8-bit output use
/// [`linear_to_srgb8`], which is exact and much faster.
#[must_use]
pub fn linear_to_srgb(linear: f32) -> f32 {
    let x = f64::from(linear);
    let encoded = if x <= 0.04045 / 12.92 {
        x * 12.92
    } else {
        // x^(1/2.4) = (x^5)^(1/12), taken apart so that no power overflows.
        let cube = cube_root(x);
        let twelfth = cube.sqrt().sqrt();
        1.055 * (cube * twelfth) - 0.055
    };
    encoded as f32
}

/// The 8-bit sRGB code of a linear value: the exact encoding rounded to the nearest code. Below 0 and NaN give 0,
/// above 1 gives 255.
#[inline]
#[must_use]
pub fn linear_to_srgb8(linear: f32) -> u8 {
    // Written so that NaN fails the comparison.
    if linear >= THRESHOLDS[1] {
        let bucket = ((linear.to_bits() >> BUCKET_SHIFT) - FIRST_BUCKET) as usize;
        match BUCKET_CODES.get(bucket) {
            Some(&code) => code + u8::from(linear >= THRESHOLDS[usize::from(code) + 1]),
            None => 255,
        }
    } else {
        0
    }
}

/// Error bound of the polynomial of [`encode_lanes`] against the exact code. Its true error is 4e-4 plus rounding;
/// lanes closer than this to a change of code ask the exact function.
const DOUBT: f32 = 0.000_6;

/// [`linear_to_srgb8`] for sixteen values at once, with the same result. `linear_mask` lanes (alpha) are instead
/// scaled by 255 and rounded, half up.
#[inline(always)]
fn encode_lanes<L: Lanes>(l: L, value: L::F, linear_mask: L::M) -> L::I {
    let x = value.saturate();
    // 255 * (1.055 * q^(5/3) - 0.055) + 0.5 over q = x^(1/4): least maximum error of degree 6.
    let q = x.sqrt().sqrt();
    let mut power = l.splat(COEFFICIENTS[6]);
    for k in (0..6).rev() {
        power = power * q + COEFFICIENTS[k];
    }
    let segment = linear_mask.select(l.splat(255.0), l.splat(12.92 * 255.0));
    let is_segment = linear_mask | x.le(l.splat(0.003_130_8));
    let code = is_segment.select(x * segment + 0.5, power);
    let rounded = code.to_int();
    let doubtful = (code - rounded.to_float() - 0.5).abs().gt(l.splat(0.5 - DOUBT)) & !linear_mask;
    if doubtful.any() {
        let exact: [i32; LANES] = x.to_array().map(|x| i32::from(linear_to_srgb8(x)));
        return doubtful.select_i(l.load_i(&exact), rounded);
    }
    rounded
}

/// From the constant term up.
const COEFFICIENTS: [f32; 7] =
    [-14.684385, 35.59906, 348.309_84, -217.504_09, 167.582_93, -81.196_02, 17.393_019];

/// The 8-bit sRGB codes of sixteen linear values, each as [`linear_to_srgb8`] gives it.
#[inline(always)]
#[doc(hidden)]
pub fn linear_to_srgb8_lanes<L: Lanes>(l: L, linear: L::F) -> L::I {
    encode_lanes(l, linear, l.mask(0))
}

/// Encodes straight-alpha RGBA pixels: colours by [`linear_to_srgb8`], alpha linearly (`255 a` rounded half up,
/// clamped, NaN is 0). Pixels beyond the shorter slice are left alone.
#[doc(hidden)]
pub fn encode_srgb8(level: SimdLevel, pixels: &[[f32; 4]], out: &mut [[u8; 4]]) {
    crate::dispatch!(level, l => encode_slice(l, pixels, out));
}

#[inline(always)]
fn encode_slice<L: Lanes>(l: L, pixels: &[[f32; 4]], out: &mut [[u8; 4]]) {
    let alpha = l.mask(0x8888);
    let count = pixels.len().min(out.len());
    let (pixels, out) = (&pixels[..count], &mut out[..count]);
    let (blocks, rest) = pixels.as_flattened().as_chunks::<LANES>();
    let (out_blocks, out_rest) = out.as_flattened_mut().as_chunks_mut::<LANES>();
    for (from, to) in blocks.iter().zip(out_blocks) {
        *to = encode_lanes(l, l.load(from), alpha).to_array().map(|code| code as u8);
    }
    let mut last = [0.0; LANES];
    last[..rest.len()].copy_from_slice(rest);
    let codes = encode_lanes(l, l.load(&last), alpha).to_array();
    for (to, code) in out_rest.iter_mut().zip(codes) {
        *to = code as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `decode(encoded) < linear`, `==` or `>` without any root: both sides to the fifth power.
    fn compare(linear: f64, encoded: f64) -> std::cmp::Ordering {
        if encoded <= 0.04045 {
            return linear.total_cmp(&(encoded / 12.92));
        }
        let t = (encoded + 0.055) / 1.055;
        let (t2, x2) = (t * t, linear * linear);
        let t4 = t2 * t2;
        (x2 * x2 * linear).total_cmp(&(t4 * t4 * t4))
    }

    #[test]
    fn the_table_holds_the_nearest_floats() {
        use std::cmp::Ordering::{Greater, Less};
        for code in 1..256 {
            let value = SRGB8_TO_LINEAR[code];
            let half_below = (f64::from(value) + f64::from(value.next_down())) / 2.0;
            let half_above = (f64::from(value) + f64::from(value.next_up())) / 2.0;
            let encoded = code as f64 / 255.0;
            assert_eq!(compare(half_below, encoded), Less, "code {code}");
            assert_eq!(compare(half_above, encoded), Greater, "code {code}");
        }
        assert_eq!((SRGB8_TO_LINEAR[0], SRGB8_TO_LINEAR[255]), (0.0, 1.0));
    }

    #[test]
    fn known_values_of_the_standard() {
        // Middle grey of an 8-bit picture, and the end of the linear segment.
        assert!((SRGB8_TO_LINEAR[128] - 0.215_860_5).abs() < 1e-7);
        assert_eq!(SRGB8_TO_LINEAR[10], 10.0 / 255.0 / 12.92);
        assert!((SRGB8_TO_LINEAR[11] - 0.003_346_536).abs() < 1e-9);
        assert_eq!(linear_to_srgb8(0.18), 118);
        assert_eq!(linear_to_srgb8(0.5), 188);
    }

    #[test]
    fn codes_change_exactly_at_the_middle_between_codes() {
        use std::cmp::Ordering::Less;
        for code in 1..256_u16 {
            let threshold = THRESHOLDS[usize::from(code)];
            let middle = (f64::from(code) - 0.5) / 255.0;
            assert_ne!(compare(f64::from(threshold), middle), Less);
            assert_eq!(compare(f64::from(threshold.next_down()), middle), Less);
            assert_eq!(u16::from(linear_to_srgb8(threshold)), code);
            assert_eq!(u16::from(linear_to_srgb8(threshold.next_down())), code - 1);
        }
    }

    #[test]
    fn every_code_survives_the_round_trip() {
        for code in 0..=255 {
            let linear = SRGB8_TO_LINEAR[usize::from(code)];
            assert_eq!(linear_to_srgb8(linear), code);
            // The fraction was rounded to f32, and the power magnifies that by 2.4.
            let direct = srgb_to_linear(f32::from(code) / 255.0);
            assert!(direct.to_bits().abs_diff(linear.to_bits()) <= 3, "{code}");
        }
    }

    #[test]
    fn no_bucket_holds_two_thresholds() {
        for pair in BUCKET_CODES.windows(2) {
            assert!(pair[1] - pair[0] <= 1);
        }
    }

    #[test]
    fn out_of_range_is_clamped_and_nan_is_black() {
        for (value, code) in [
            (f32::NAN, 0),
            (-f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (-1.0, 0),
            (-0.0, 0),
            (1e-42, 0),
            (1.0, 255),
            (1.5, 255),
            (f32::MAX, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(linear_to_srgb8(value), code, "{value}");
            for level in SimdLevel::available() {
                let mut out = [[1; 4]; 1];
                encode_srgb8(level, &[[value; 4]], &mut out);
                assert_eq!(out, [[code; 4]], "{level} {value}");
            }
        }
    }

    #[test]
    fn float_functions_are_inverse_to_each_other() {
        for k in 0..=4096 {
            let x = k as f32 / 2048.0;
            assert!((srgb_to_linear(linear_to_srgb(x)) - x).abs() <= 4e-7 * x, "{x}");
        }
        assert_eq!(linear_to_srgb(1.0), 1.0);
        // (0.5^5)^(1/12) by hand: 0.749153538...
        assert!((f64::from(linear_to_srgb(0.5)) - (1.055 * 0.749_153_538_438_340_7 - 0.055)).abs() < 6e-8);
    }

    /// The values where a mistake would show: both sides of every change of code, and a sweep of all magnitudes.
    fn probes() -> Vec<f32> {
        let near = THRESHOLDS[1..256].iter().flat_map(|t| {
            (-40..=40).map(|step: i32| f32::from_bits(t.to_bits().wrapping_add_signed(step * step * step)))
        });
        let sweep = (0..(1_u32 << 30)).step_by(4999).map(f32::from_bits);
        near.chain(sweep).collect()
    }

    #[test]
    fn lanes_give_the_exact_codes_at_every_level() {
        let probes = probes();
        let pixels: Vec<[f32; 4]> = probes.chunks_exact(3).map(|c| [c[0], c[1], c[2], c[0]]).collect();
        for level in SimdLevel::available() {
            let mut found = vec![[0; 4]; pixels.len()];
            encode_srgb8(level, &pixels, &mut found);
            for (pixel, found) in pixels.iter().zip(&found) {
                let [r, g, b, a] = *pixel;
                let alpha = (a * 255.0 + 0.5) as u8;
                let expected = [linear_to_srgb8(r), linear_to_srgb8(g), linear_to_srgb8(b), alpha];
                assert_eq!(*found, expected, "{level}: {pixel:?}");
            }
        }
    }

    #[test]
    #[ignore = "all 2^30 floats from 0 to 1: seconds in release, minutes without"]
    fn lanes_give_the_exact_codes_for_every_float() {
        let level = SimdLevel::best();
        let mut found = vec![[0; 4]; 1 << 14];
        for start in (0..=0x3f80_0000_u32).step_by(3 << 14) {
            let pixels: Vec<[f32; 4]> = (0..1 << 14)
                .map(|k| [0, 1, 2, 0].map(|channel| f32::from_bits(start + 3 * k + channel)))
                .collect();
            encode_srgb8(level, &pixels, &mut found);
            for (pixel, found) in pixels.iter().zip(&found) {
                for channel in 0..3 {
                    assert_eq!(found[channel], linear_to_srgb8(pixel[channel]), "{}", pixel[channel]);
                }
            }
        }
    }

    #[test]
    fn a_slice_of_any_length_is_encoded_to_its_end() {
        for count in 0..10 {
            let pixels: Vec<[f32; 4]> = (0..count).map(|k| [k as f32 / 10.0; 4]).collect();
            let mut out = vec![[9; 4]; count + 1];
            encode_srgb8(SimdLevel::best(), &pixels, &mut out);
            for (pixel, out) in pixels.iter().zip(&out) {
                assert_eq!(out[0], linear_to_srgb8(pixel[0]));
                assert_eq!(out[3], (pixel[3] * 255.0 + 0.5) as u8);
            }
            assert_eq!(out[count], [9; 4]);
        }
    }
}
