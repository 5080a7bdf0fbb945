//! Numbers for each value of a byte, looked up by sixteen lanes in one go.

/// A number for each value of a byte.
#[derive(Clone, Debug)]
pub struct ByteTable {
    /// The numbers.
    pub values: [f32; 256],
    /// Their bytes, the lowest of all first, each in quarters as long as the longest vector.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code))]
    pub(super) bytes: [[[u8; 64]; 4]; 4],
}

impl ByteTable {
    /// Takes the numbers.
    #[must_use]
    pub const fn new(values: [f32; 256]) -> Self {
        let mut bytes = [[[0; 64]; 4]; 4];
        let mut value = 0;
        while value < 256 {
            let parts = values[value].to_le_bytes();
            let mut part = 0;
            while part < 4 {
                bytes[part][value / 64][value % 64] = parts[part];
                part += 1;
            }
            value += 1;
        }
        Self { values, bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{Float, LANES, SimdLevel};

    #[test]
    fn every_byte_finds_its_number_at_every_level() {
        let number = |k: u32| f32::from_bits(k.wrapping_mul(0x9e37_79b1) & 0xbfff_ffff);
        let table = ByteTable::new(std::array::from_fn(|k| number(k as u32)));
        for level in SimdLevel::available() {
            for first in (0..256).step_by(LANES) {
                let bytes: [[u32; 3]; LANES] = std::array::from_fn(|k| {
                    [first + k as u32, 255 - first - k as u32, (first * 7 + k as u32 * 3) % 256]
                });
                let packed = bytes.map(|[a, b, c]| (a | b << 8 | c << 16 | (a ^ b) << 24) as i32);
                let found = crate::dispatch!(level, l => {
                    let [a, b, c] = l.look_up_bytes(&table, l.load_i(&packed));
                    [a.to_array(), b.to_array(), c.to_array()]
                });
                for (c, found) in found.into_iter().enumerate() {
                    let expected = bytes.map(|bytes| number(bytes[c]).to_bits());
                    assert_eq!(found.map(f32::to_bits), expected, "{level}, byte {c} from {first} on");
                }
            }
        }
    }
}
