//! Filters that are applied to elements after decoding (appendix B). Only + - * / and the square root, each rounded
//! exactly, so that every machine gets the same bytes.

/// The nearest integer, halves away from zero. What is not a number becomes 0.
fn round(value: f32) -> i32 {
    (value + if value >= 0.0 { 0.5 } else { -0.5 }) as i32
}

/// Filter 1: x and y of an octahedral map, whose third number stands for 1, to a vector of length `max`.
fn octahedral([x, y, one]: [f32; 3], max: f32) -> [i32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = if z >= 0.0 { 0.0 } else { z };
    let x = x + if x >= 0.0 { fold } else { -fold };
    let y = y + if y >= 0.0 { fold } else { -fold };
    let scale = max / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|v| round(v * scale))
}

/// Filter 1 for bytes.
pub(super) fn octahedral8(elements: &mut [[u8; 4]]) {
    for element in elements {
        let [x, y, one, w] = *element;
        let [x, y, z] = octahedral([x, y, one].map(|v| f32::from(v as i8)), 127.0).map(|v| v as u8);
        *element = [x, y, z, w];
    }
}

/// Filter 1 for numbers of 16 bits.
pub(super) fn octahedral16(elements: &mut [[u8; 8]]) {
    for element in elements {
        let [x, y, one, w] = shorts(element);
        let [x, y, z] = octahedral([x, y, one].map(f32::from), 32767.0).map(|v| v as i16);
        *element = bytes([x, y, z, w]);
    }
}

/// Filter 2: three components of a quaternion over sqrt(1/2), and 1 with the place of the fourth, the largest, in its
/// last two bits.
pub(super) fn quaternion(elements: &mut [[u8; 8]]) {
    let scale = 32767.0 / 2f32.sqrt();
    for element in elements {
        let [x, y, z, last] = shorts(element);
        let one = f32::from(last | 3);
        let xyz = [x, y, z].map(f32::from);
        let square = one * one * 2.0 - xyz[0] * xyz[0] - xyz[1] * xyz[1] - xyz[2] * xyz[2];
        let largest = if square >= 0.0 { square.sqrt() } else { 0.0 };
        let unit = scale / one;
        let numbers = [largest, xyz[0], xyz[1], xyz[2]].map(|v| round(v * unit) as i16);
        // The first number goes to that place, and the others to those behind it, which go round.
        let place = u32::from(last.cast_unsigned() & 3);
        *element = u64::from_le_bytes(bytes(numbers)).rotate_left(place << 4).to_le_bytes();
    }
}

/// Filter 3: 24 bits of mantissa times two to the power of 8 bits of exponent.
pub(super) fn exponential(numbers: &mut [[u8; 4]]) {
    for number in numbers {
        let bits = i32::from_le_bytes(*number);
        let (exponent, mantissa) = (bits >> 24, bits << 8 >> 8);
        // Both factors are floats and their product is one, for the exponents from -100 to 100 that are allowed.
        let power = f32::from_bits(exponent.clamp(-126, 127).wrapping_add(127).cast_unsigned() << 23);
        *number = (power * mantissa as f32).to_le_bytes();
    }
}

/// Filter 4: luma, chroma and alpha of as many bits as alpha's highest one tells.
fn color([y, co, cg]: [i32; 3], alpha: i32, max: f32) -> [i32; 4] {
    let highest = alpha.max(1).ilog2();
    let one = !(!1 << highest);
    let alpha = (alpha << 1 & one) | (alpha & 1);
    let scale = max / one as f32;
    // Whole numbers of at most 18 bits, whose sums are exact.
    let [y, co, cg, alpha] = [y, co, cg, alpha].map(|v| v as f32);
    // Not below zero: what is there is meant to be no colour.
    [y + co - cg, y + cg, y - co - cg, alpha].map(|v| (v * scale + 0.5) as i32)
}

/// Filter 4 for bytes.
pub(super) fn color8(elements: &mut [[u8; 4]]) {
    for element in elements {
        let [y, co, cg, alpha] = *element;
        let ycc = [i32::from(y), i32::from(co as i8), i32::from(cg as i8)];
        *element = color(ycc, alpha.into(), 255.0).map(|v| v.clamp(0, 255) as u8);
    }
}

/// Filter 4 for numbers of 16 bits.
pub(super) fn color16(elements: &mut [[u8; 8]]) {
    for element in elements {
        let [y, co, cg, alpha] = shorts(element);
        let ycc = [i32::from(y.cast_unsigned()), i32::from(co), i32::from(cg)];
        let rgba = color(ycc, i32::from(alpha.cast_unsigned()), 65535.0);
        *element = bytes(rgba.map(|v| (v.clamp(0, 65535) as u16).cast_signed()));
    }
}

fn shorts(element: &[u8; 8]) -> [i16; 4] {
    let [a, b, c, d, e, f, g, h] = *element;
    [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes)
}

fn bytes([x, y, z, w]: [i16; 4]) -> [u8; 8] {
    let ([a, b], [c, d], [e, f], [g, h]) =
        (x.to_le_bytes(), y.to_le_bytes(), z.to_le_bytes(), w.to_le_bytes());
    [a, b, c, d, e, f, g, h]
}

#[cfg(test)]
mod tests {
    use super::super::encoder::Random;
    use super::*;

    #[test]
    fn vectors_of_an_octahedron() {
        // 1.0 in 8 bits; the axes, an edge, and a corner of the lower half.
        for (given, expected) in [
            ([0, 0, 127, 5], [0, 0, 127, 5]),
            ([127, 0, 127, 250], [127, 0, 0, 250]),
            ([0, -127, 127, 0], [0, -127, 0, 0]),
            ([64, 63, 127, 0], [91, 89, 0, 0]),
            ([127, 127, 127, 0], [0, 0, -127, 0]),
            ([-127, 127, 127, 0], [0, 0, -127, 0]),
            // The same in 4 bits.
            ([7, 0, 7, 1], [127, 0, 0, 1]),
            ([-7, -7, 7, 1], [0, 0, -127, 1]),
        ] {
            let mut element = [given.map(|v: i32| v as u8)];
            octahedral8(&mut element);
            assert_eq!(element[0], expected.map(|v| v as u8), "{given:?}");
        }
        let mut element = [bytes([511, 0, 511, -3])];
        octahedral16(&mut element);
        assert_eq!(shorts(&element[0]), [32767, 0, 0, -3]);
    }

    #[test]
    fn octahedral_vectors_have_their_direction() {
        let mut random = Random::new(23);
        for _ in 0..10_000 {
            let v: [f64; 3] = [0; 3].map(|_| random.below(2001) as f64 / 1000.0 - 1.0);
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            if length < 0.1 {
                continue;
            }
            let sum = v[0].abs() + v[1].abs() + v[2].abs();
            let (mut x, mut y) = (v[0] / sum, v[1] / sum);
            if v[2] < 0.0 {
                (x, y) = ((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum());
            }
            let mut element = [bytes([(x * 32767.0) as i16, (y * 32767.0) as i16, 32767, 0])];
            octahedral16(&mut element);
            let decoded = shorts(&element[0]);
            for k in 0..3 {
                assert!((f64::from(decoded[k]) / 32767.0 - v[k] / length).abs() < 3e-4, "{v:?} {decoded:?}");
            }
        }
    }

    #[test]
    fn quaternions_turn_around_their_largest_component() {
        let half = 23170;
        for (given, expected) in [
            // Only the largest: x, y, z, w.
            ([0, 0, 0, 32764], [32767, 0, 0, 0]),
            ([0, 0, 0, 32765], [0, 32767, 0, 0]),
            ([0, 0, 0, 32766], [0, 0, 32767, 0]),
            ([0, 0, 0, 32767], [0, 0, 0, 32767]),
            // 1.0 stands for sqrt(1/2): as large as the largest. In 16 and in 8 bits.
            ([32767, 0, 0, 32767], [half, 0, 0, half]),
            ([0, 0, -127, 124], [half, 0, 0, -half]),
            ([0, 127, 0, 125], [0, half, 0, half]),
        ] {
            let mut element = [bytes(given)];
            quaternion(&mut element);
            let decoded = shorts(&element[0]);
            assert!(decoded.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1), "{given:?} {decoded:?}");
        }
    }

    #[test]
    fn exponents_are_exact() {
        let decode = |exponent: i32, mantissa: i32| {
            let mut number = [(exponent << 24 | mantissa & 0xff_ffff).to_le_bytes()];
            exponential(&mut number);
            f32::from_le_bytes(number[0])
        };
        assert_eq!(decode(0, 1), 1.0);
        assert_eq!(decode(0, -1), -1.0);
        assert_eq!(decode(3, 5), 40.0);
        assert_eq!(decode(-1, 3), 1.5);
        assert_eq!(decode(-24, -(1 << 23)), -0.5);
        assert_eq!(decode(100, 8_388_607), 8_388_607.0 * f32::from_bits(227 << 23));
        assert_eq!(decode(-100, 1), f32::from_bits(27 << 23));
        assert_eq!(decode(0, 0).to_bits(), 0);
    }

    #[test]
    fn colours_of_few_and_of_many_bits() {
        // 8 bits: alpha of 7 bits below bit 7. Grey, red, and their half transparent forms.
        for (given, expected) in [
            ([200, 0, 0, 255], [200, 200, 200, 255]),
            ([0, 0, 0, 128], [0, 0, 0, 0]),
            // y = (r + 2 g + b) / 4 and so on: y + co - cg = 254, y + cg = 0, y - co - cg = 0.
            ([64, 127, 192, 255], [255, 0, 1, 255]),
            // One bit less: 127 stands for 1.
            ([127, 0, 0, 127], [255, 255, 255, 255]),
            ([0, 0, 0, 64], [0, 0, 0, 0]),
            ([3, 0, 0, 3], [255, 255, 255, 255]),
        ] {
            let mut element = [given.map(|v: i32| v as u8)];
            color8(&mut element);
            assert_eq!(element[0], expected.map(|v: i32| v as u8), "{given:?}");
        }
        let mut element = [bytes([1023, 0, 0, 1023])];
        color16(&mut element);
        assert_eq!(shorts(&element[0]), [-1; 4]);
    }

    /// Filters give some result for any numbers.
    #[test]
    fn numbers_that_no_encoder_writes() {
        let mut random = Random::new(29);
        for _ in 0..20_000 {
            let mut wide =
                [[random.next(), random.next()].map(u32::to_le_bytes).as_flattened().try_into().unwrap()];
            let mut narrow = [random.next().to_le_bytes()];
            for filter in [octahedral16, quaternion, color16] {
                filter(&mut wide);
            }
            for filter in [octahedral8, exponential, color8] {
                filter(&mut narrow);
            }
        }
        let mut zero = [[0; 8]];
        octahedral16(&mut zero);
        assert_eq!(zero, [[0; 8]]);
        color16(&mut zero);
        quaternion(&mut zero);
    }
}
