//! Half floats (IEEE 754 binary16), as bits: files and clouds of splats store them, nothing is computed in them.

/// The number of a half float, exactly.
#[must_use]
pub fn half_to_f32(bits: u16) -> f32 {
    /// The exponents of the two formats have biases of 15 and 127.
    const TWO_TO_112: f32 = f32::from_bits((127 + 112) << 23);
    let sign = u32::from(bits & 0x8000) << 16;
    let magnitude = u32::from(bits & 0x7fff) << 13;
    let magnitude = match bits & 0x7fff {
        // Infinity and NaN have all bits of the exponent, in either format.
        0x7c00.. => magnitude | 0x7f80_0000,
        // Scaling normalises the small ones, which have no leading bit.
        _ => (f32::from_bits(magnitude) * TWO_TO_112).to_bits(),
    };
    f32::from_bits(sign | magnitude)
}

/// The nearest half float, of two the even one: infinity from 65520 on, a quiet NaN for NaN.
#[must_use]
pub fn f32_to_half(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = (bits >> 16 & 0x8000) as u16;
    let magnitude = bits & 0x7fff_ffff;
    let rounded = match magnitude {
        0x7f80_0001.. => return sign | 0x7e00 | (bits >> 13 & 0x03ff) as u16,
        // 65520, half way beyond the largest.
        0x477f_f000.. => 0x7c00,
        // 2^-14, the smallest with a leading bit. Adding just below one half of the last bit, and that bit, rounds to even.
        0x3880_0000.. => (magnitude + 0x0fff + (magnitude >> 13 & 1) - (112 << 23)) >> 13,
        // Beside 0.5 the last bit of a float is 2^-24, as of the small half floats: the addition rounds.
        _ => (f32::from_bits(magnitude) + 0.5).to_bits() - 0.5_f32.to_bits(),
    };
    sign | rounded as u16
}

#[cfg(test)]
mod tests {
    use super::{f32_to_half, half_to_f32};
    use half::f16;

    #[test]
    fn every_half_float_comes_back() {
        for bits in 0..=u16::MAX {
            let expected = f16::from_bits(bits).to_f32();
            let found = half_to_f32(bits);
            if expected.is_nan() {
                assert!(found.is_nan() && f16::from_bits(f32_to_half(found)).is_nan(), "{bits:#x}");
            } else {
                assert_eq!((found.to_bits(), f32_to_half(found)), (expected.to_bits(), bits), "{bits:#x}");
            }
        }
    }

    #[test]
    fn rounding_is_to_the_nearest_and_to_even() {
        // Each half float's neighbourhood, the middle between two and both sides of it; then floats of all exponents.
        let middles = (0..0x7c00_u16).flat_map(|bits| {
            let [low, high] = [bits, bits + 1].map(|bits| f16::from_bits(bits).to_f32());
            let middle = if high.is_finite() { (low + high) * 0.5 } else { 65520.0 };
            [low, middle]
                .map(f32::to_bits)
                .into_iter()
                .flat_map(|bits| [bits.wrapping_sub(1), bits, bits + 1])
        });
        let others = (0..=u32::MAX).step_by(65_521);
        for bits in middles.chain(others) {
            for bits in [bits, bits ^ 0x8000_0000] {
                let (value, expected) = (f32::from_bits(bits), f16::from_f32(f32::from_bits(bits)));
                let found = f32_to_half(value);
                assert!(
                    found == expected.to_bits() || value.is_nan() && f16::from_bits(found).is_nan(),
                    "{bits:#x}"
                );
            }
        }
    }
}
