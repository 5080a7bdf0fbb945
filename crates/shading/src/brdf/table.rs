//! Tables over two parameters that both run from 0 to 1, read with bilinear interpolation.

use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, Lanes};

/// Mapping of the parameters 0 and 1 to a table's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelGrid {
    /// The first texel is at 0, the last at 1: position = u (size - 1).
    Corners,
    /// Texels are the centres of equal cells, as a clamped texture's: position = u size - 0.5.
    Centers,
}

/// `width * height` texels of N numbers, row by row; the first parameter runs along the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    width: usize,
    height: usize,
    grid: TexelGrid,
    /// Channels together: one index, and most often one cache line, for all of them.
    texels: Vec<[f32; N]>,
}

/// Number format of a stored table's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFormat {
    /// `f32`.
    Single,
    /// IEEE half precision, rounded to nearest even.
    Half,
}

/// First bytes of a stored table. After it: width and height as `u16`, then one byte each for the number of channels,
/// the format (0 single, 1 half), the grid (0 corners, 1 centers) and 0; then the texels, row by row, channels together.
/// Everything is little endian.
const MAGIC: [u8; 8] = *b"ovctable";

/// Bytes before the texels.
const HEADER: usize = 16;

impl<const N: usize> Table<N> {
    /// A table of one texel, which it gives everywhere.
    #[must_use]
    pub fn constant(texel: [f32; N]) -> Self {
        Self { width: 1, height: 1, grid: TexelGrid::Corners, texels: vec![texel] }
    }

    /// Reads what [`Table::to_bytes`] writes. `None` for anything else.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let header = bytes.get(..HEADER)?;
        let size = |at: usize| usize::from(u16::from_le_bytes([header[at], header[at + 1]]));
        if header[..8] != MAGIC || usize::from(header[12]) != N || header[15] != 0 {
            return None;
        }
        let grid = match header[14] {
            0 => TexelGrid::Corners,
            1 => TexelGrid::Centers,
            _ => return None,
        };
        let texels = &bytes[HEADER..];
        let numbers: Vec<f32> = match header[13] {
            0 if texels.len().is_multiple_of(4) => {
                texels.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
            }
            1 if texels.len().is_multiple_of(2) => {
                texels.chunks_exact(2).map(|b| half_to_single(u16::from_le_bytes([b[0], b[1]]))).collect()
            }
            _ => return None,
        };
        let (texels, rest) = numbers.as_chunks::<N>();
        if rest.is_empty() { Self::new(size(8), size(10), grid, texels) } else { None }
    }

    /// The table as bytes, each number rounded to the format. `None` if a side exceeds 65535 or there are more than 255
    /// channels.
    #[must_use]
    pub fn to_bytes(&self, format: TexelFormat) -> Option<Vec<u8>> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(u16::try_from(self.width).ok()?.to_le_bytes());
        bytes.extend(u16::try_from(self.height).ok()?.to_le_bytes());
        bytes.push(u8::try_from(N).ok()?);
        bytes.push(u8::from(format == TexelFormat::Half));
        bytes.push(u8::from(self.grid == TexelGrid::Centers));
        bytes.push(0);
        for number in self.texels.as_flattened() {
            match format {
                TexelFormat::Single => bytes.extend(number.to_le_bytes()),
                TexelFormat::Half => bytes.extend(single_to_half(*number).to_le_bytes()),
            }
        }
        Some(bytes)
    }

    /// A table of texels in rows. `None` if the texels are not `width * height`, there are none, or more than 2^20.
    #[must_use]
    pub fn new(width: usize, height: usize, grid: TexelGrid, texels: &[[f32; N]]) -> Option<Self> {
        let count = width.checked_mul(height)?;
        if count == 0 || count > 1 << 20 || texels.len() != count {
            return None;
        }
        Some(Self { width, height, grid, texels: texels.to_vec() })
    }

    /// Number of texels along each parameter.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// One texel. Coordinates beyond the table read its edge.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> [f32; N] {
        let index = y.min(self.height - 1) * self.width + x.min(self.width - 1);
        self.texels[index]
    }

    /// All channels at (u, v), clamped to the edge; a NaN reads 0.
    #[inline(always)]
    pub fn fetch<L: Lanes>(&self, l: L, u: L::F, v: L::F) -> [L::F; N] {
        self.fetch_first(l, u, v)
    }

    /// The first M channels at (u, v), as [`Table::fetch`] finds them. M is at most N; channels beyond are 0.
    #[inline(always)]
    pub fn fetch_first<L: Lanes, const M: usize>(&self, l: L, u: L::F, v: L::F) -> [L::F; M] {
        let (x0, x1, fx) = self.position(l, u, self.width);
        let (y0, y1, fy) = self.position(l, v, self.height);
        let width = l.splat_i(self.width as i32);
        let (upper, lower) = (y0 * width, y1 * width);
        let mut corners = [[[0.0; 16]; 4]; M];
        gather(
            &self.texels,
            [upper + x0, upper + x1, lower + x0, lower + x1].map(Int::to_array),
            &mut corners,
        );
        each!(c in corners => {
            let [a, b, c, d] = [l.load(&c[0]), l.load(&c[1]), l.load(&c[2]), l.load(&c[3])];
            a.lerp(b, fx).lerp(c.lerp(d, fx), fy)
        })
    }

    /// The two texels about a parameter, and the weight of the second.
    #[inline(always)]
    fn position<L: Lanes>(&self, l: L, u: L::F, size: usize) -> (L::I, L::I, L::F) {
        let last = (size - 1) as f32;
        let at = match self.grid {
            TexelGrid::Corners => u * last,
            TexelGrid::Centers => u * size as f32 - 0.5,
        };
        let at = at.clamp_to(0.0, last);
        let first = at.to_int();
        let next = (first + 1).min(l.splat_i(size as i32 - 1));
        (first, next, at - first.to_float())
    }
}

/// The first M channels at the corners, for each lane. Scalar loads only, so one copy serves every instruction set.
#[inline(never)]
fn gather<const N: usize, const M: usize>(
    texels: &[[f32; N]],
    indices: [[i32; 16]; 4],
    corners: &mut [[[f32; 16]; 4]; M],
) {
    for corner in 0..4 {
        for lane in 0..16 {
            let texel = texels.get(indices[corner][lane] as usize).unwrap_or(&[0.0; N]);
            for channel in 0..M.min(N) {
                corners[channel][corner][lane] = texel[channel];
            }
        }
    }
}

/// The exact value of a finite half-precision number.
fn half_to_single(half: u16) -> f32 {
    let (exponent, fraction) = (i32::from(half >> 10 & 31), f32::from(half & 1023));
    let power = |n: i32| f32::from_bits(((n + 127) as u32) << 23);
    let magnitude = match exponent {
        0 => fraction * power(-24),
        n => (fraction + 1024.0) * power(n - 25),
    };
    if half & 0x8000 == 0 { magnitude } else { -magnitude }
}

/// The nearest half-precision number, ties to even; 65504 is the largest magnitude.
fn single_to_half(x: f32) -> u16 {
    let sign = ((x.to_bits() >> 16) & 0x8000) as u16;
    let magnitude = x.abs().min(65_504.0);
    // The spacing of half-precision numbers about this one, at least that of subnormal ones.
    let exponent = ((magnitude.to_bits() >> 23) as i32 - 127).max(-14);
    let power = |n: i32| f32::from_bits(((n + 127) as u32) << 23);
    // Adding 2^23 leaves no room for fraction bits: it rounds to a whole number of spacings, 0 to 2048. The product is
    // exact, and a carry into the next exponent falls out of the sum.
    let spacings = (magnitude * power(10 - exponent) + 8_388_608.0) - 8_388_608.0;
    let code = (exponent + 14) * 1024 + spacings as i32;
    sign | code as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    #[test]
    fn texels_are_where_the_grid_says_and_lines_between() {
        let texels: Vec<[f32; 2]> = (0..12).map(|k| [(k % 4) as f32, (k / 4) as f32]).collect();
        for (grid, first, last) in [(TexelGrid::Corners, 0.0, 1.0), (TexelGrid::Centers, 0.125, 0.875)] {
            let table = Table::new(4, 3, grid, &texels).expect("twelve texels");
            for k in 0..=30 {
                let u = k as f32 / 30.0;
                let expected = 3.0 * ((u - first) / (last - first)).clamp(0.0, 1.0);
                let [x, _] = table.fetch(Scalar, Scalar.splat(u), Scalar.splat(0.5));
                assert!((x.to_array()[0] - expected).abs() < 1e-6, "{u}");
            }
            for outside in [-1.0, 2.0, f32::NAN, f32::INFINITY] {
                let [x, y] = table.fetch(Scalar, Scalar.splat(outside), Scalar.splat(outside));
                assert!((0.0..=3.0).contains(&x.to_array()[0]) && (0.0..=2.0).contains(&y.to_array()[0]));
            }
        }
    }

    #[test]
    fn halves_return_and_round_to_the_nearest() {
        for code in 0..=u16::MAX {
            if code >> 10 & 31 != 31 {
                let x = half_to_single(code);
                assert_eq!(single_to_half(x), code, "{x}");
                // Half way to the next magnitude goes to the even one.
                if code & 0x7fff < 0x7bff {
                    let next = half_to_single(code + 1);
                    assert_eq!(single_to_half(x + (next - x) * 0.5), code + (code & 1), "{x}");
                    assert_eq!(single_to_half(x + (next - x) * 0.501), code + 1, "{x}");
                }
            }
        }
        assert_eq!(half_to_single(0x3c00), 1.0);
        assert_eq!([single_to_half(1e9), single_to_half(-1e-9)], [0x7bff, 0x8000]);
    }

    #[test]
    fn stored_tables_return_and_damaged_ones_are_refused() {
        let texels: Vec<[f32; 2]> = (0..6).map(|k| [k as f32 * 0.25, -1.0 - k as f32]).collect();
        let table = Table::new(3, 2, TexelGrid::Centers, &texels).expect("six texels");
        for format in [TexelFormat::Single, TexelFormat::Half] {
            let bytes = table.to_bytes(format).expect("small");
            assert_eq!(Table::from_bytes(&bytes).as_ref(), Some(&table));
            assert!(Table::<3>::from_bytes(&bytes).is_none());
            for length in 0..bytes.len() {
                assert!(Table::<2>::from_bytes(&bytes[..length]).is_none());
            }
            for (at, value) in [(0, 0), (8, 4), (13, 2), (14, 2), (15, 1)] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                assert!(Table::<2>::from_bytes(&damaged).is_none(), "{at}");
            }
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(Table::new(2, 2, TexelGrid::Corners, &[[0.0]; 3]).is_none());
        assert!(Table::<1>::new(0, 2, TexelGrid::Corners, &[]).is_none());
        assert!(Table::new(usize::MAX, 2, TexelGrid::Corners, &[[0.0]; 3]).is_none());
    }
}
