//! Sixteen lanes of arithmetic with one meaning on every processor.
//!
//! Everything that runs per pixel is written over the [`Lanes`] trait and compiled once for each instruction
//! set. The trait offers what IEEE 754 rounds exactly (add, subtract, multiply, divide, square root), compares,
//! selects, bit operations and conversions, and nothing else: no fused multiply-add, no reciprocal estimate, no
//! reduction, no platform minimum. Whatever is written with it therefore has the same bits at every level.
//!
//! * [`Scalar`] is the definition: plain arrays, one lane after the other.
//! * [`Vector`] wraps the vectors of `fearless_simd` for SSE2, AVX2, AVX-512, NEON and WebAssembly.
//!
//! A function takes the token `l: L` first; constants come from `l.splat(0.04)` or from mixed arithmetic
//! (`x * 0.5 + 1.0`). Mark it `#[inline(always)]`: the instruction set is chosen once, by [`dispatch!`], and
//! must reach the innermost loop.
//!
//! [`dispatch!`]: crate::dispatch

mod byte_table;
mod level;
#[cfg(target_arch = "x86_64")]
mod permutations;
mod scalar;
mod vector;

pub use byte_table::ByteTable;
#[cfg(target_arch = "aarch64")]
#[doc(hidden)]
pub use level::neon;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
#[doc(hidden)]
pub use level::simd128;
pub use level::{SimdLevel, UnknownLevel};
#[cfg(target_arch = "x86_64")]
#[doc(hidden)]
pub use level::{avx2, avx512, sse2};
pub use scalar::Scalar;
pub use vector::Vector;

use crate::each;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Number of lanes of every vector: one 4x4 block of pixels.
pub const LANES: usize = 16;

/// `[f(0), f(1), ...]`, for arrays of lane numbers. Mark the closure `#[inline(always)]`.
///
/// `std::array::from_fn` and `array::map` must not hold lane arithmetic: the standard library's functions are not
/// `#[inline(always)]`, so they are compiled for the least instruction set and every operation in them becomes a
/// call (URP shading ran five to eight times slower with them).
#[inline(always)]
pub fn array_from_fn<T: Copy, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut out = [f(0); N];
    for k in 1..N {
        out[k] = f(k);
    }
    out
}

/// `f` of every element, for arrays of lane numbers; see [`array_from_fn`].
#[inline(always)]
pub fn map_array<A: Copy, B: Copy, const N: usize>(a: [A; N], mut f: impl FnMut(A) -> B) -> [B; N] {
    let mut out = [f(a[0]); N];
    for k in 1..N {
        out[k] = f(a[k]);
    }
    out
}

/// An instruction set: a token that makes vectors. Zero-sized and copied freely.
pub trait Lanes: Copy + Send + Sync + 'static {
    /// Sixteen `f32`.
    type F: Float<I = Self::I, M = Self::M>;
    /// Sixteen `i32`, wrapping.
    type I: Int<F = Self::F, M = Self::M>;
    /// Sixteen booleans.
    type M: Mask<F = Self::F, I = Self::I>;

    /// The same number in every lane.
    fn splat(self, value: f32) -> Self::F;
    /// The same integer in every lane.
    fn splat_i(self, value: i32) -> Self::I;
    /// Lane k holds `values[k]`.
    fn load(self, values: &[f32; LANES]) -> Self::F;
    /// Lane k holds `values[k]`.
    fn load_i(self, values: &[i32; LANES]) -> Self::I;
    /// Lane k is bit k of `bits`.
    fn mask(self, bits: u16) -> Self::M;
    /// Runs `f` compiled for this instruction set. `f` and all that it calls must be `#[inline(always)]`.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;

    /// The lane numbers 0 to 15.
    #[inline(always)]
    fn lane_indices(self) -> Self::I {
        self.load_i(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15])
    }
    /// Zero in every lane.
    #[inline(always)]
    fn zero(self) -> Self::F {
        self.splat(0.0)
    }
    /// `table[index]` per lane, by sixteen scalar loads. An index outside the table reads 0.
    #[inline(always)]
    fn gather(self, table: &[f32], index: Self::I) -> Self::F {
        let index = index.to_array();
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = table.get(index[k] as usize).copied().unwrap_or(0.0);
        }
        self.load(&out)
    }
    /// `table[index]` per lane, by the lowest four bits of the index.
    #[inline(always)]
    fn look_up_16(self, table: &[i32; LANES], index: Self::I) -> Self::I {
        look_up_by_lane(self, table, index)
    }
    /// `table[index]` and `table[index + 1]` per lane, as integers' bits: half the loads and half the checks of two
    /// gathers. An index outside the table, read as a `u32`, stands for the last pair; without a pair both are 0.
    #[inline(always)]
    fn gather_pairs_u32(self, table: &[u32], index: Self::I) -> [Self::I; 2] {
        let Some(last) = table.len().checked_sub(2) else { return [self.splat_i(0); 2] };
        let index = index.to_array();
        let mut pairs = [[0; 2]; LANES];
        let outside = [table[last] as i32, table[last + 1] as i32];
        for k in 0..LANES {
            let first = index[k] as u32 as usize;
            // One check of both: compilers check a first that was clamped again, and the second, twice the instructions.
            pairs[k] = match table.get(first..first.saturating_add(2)) {
                Some(&[first, second]) => [first as i32, second as i32],
                _ => outside,
            };
        }
        self.unzip(pairs)
    }
    /// `table[index]` per lane, four bytes as a little-endian integer. An index outside, read as a `u32`, stands for the
    /// last; of an empty table all are 0.
    #[inline(always)]
    fn gather_bytes(self, table: &[[u8; 4]], index: Self::I) -> Self::I {
        let index = index.to_array();
        let mut out = [0; LANES];
        if let Some(last) = table.len().checked_sub(1) {
            for k in 0..LANES {
                out[k] = i32::from_le_bytes(table[(index[k] as u32 as usize).min(last)]);
            }
        }
        self.load_i(&out)
    }
    /// [`Lanes::gather_pairs_u32`] of four bytes each, as little-endian integers: from several tables at the same places, so
    /// that indices are checked once. What is beyond the shortest table's end counts as outside of all.
    #[inline(always)]
    fn gather_pairs_bytes<const N: usize>(
        self,
        tables: [&[[u8; 4]]; N],
        index: Self::I,
    ) -> [[Self::I; 2]; N] {
        let mut len = usize::MAX;
        for table in tables {
            len = len.min(table.len());
        }
        // Left at once, and not with numbers that are 0: they would wait for the check in registers of their own.
        let Some(last) = len.checked_sub(2) else { return [[self.splat_i(0); 2]; N] };
        let tables = each!(table in tables => table.get(..len).unwrap_or_default());
        let index = index.to_array();
        let mut pairs = [[0; LANES]; N];
        for k in 0..LANES {
            // Clamping tells the compiler that both lie inside: half the instructions of a check with a branch.
            let first = (index[k] as u32 as usize).min(last);
            for n in 0..N {
                // One number of eight bytes from the start: compilers take two of four apart again.
                if let Some(pair) = tables[n][first..].first_chunk::<2>() {
                    pairs[n][k] = i64::from_le_bytes(*pair.as_flattened().first_chunk().unwrap_or(&[0; 8]));
                }
            }
        }
        each!(pairs in pairs => self.unzip_halves(pairs))
    }
    /// The lower and the upper halves of sixteen numbers.
    #[inline(always)]
    fn unzip_halves(self, numbers: [i64; LANES]) -> [Self::I; 2] {
        let (mut lower, mut upper) = ([0; LANES], [0; LANES]);
        for (k, number) in numbers.into_iter().enumerate() {
            (lower[k], upper[k]) = (number as i32, (number >> 32) as i32);
        }
        [self.load_i(&lower), self.load_i(&upper)]
    }
    /// The first and the second numbers of sixteen pairs.
    #[inline(always)]
    fn unzip(self, pairs: [[i32; 2]; LANES]) -> [Self::I; 2] {
        self.unzip_halves(each!(pair in pairs => i64::from(pair[0] as u32) | i64::from(pair[1]) << 32))
    }
    /// Sixteen pairs of numbers of two vectors.
    #[inline(always)]
    fn zip(self, first: Self::I, second: Self::I) -> [[i32; 2]; LANES] {
        let (first, second) = (first.to_array(), second.to_array());
        each!(k => [first[k], second[k]])
    }
    /// The first, second and third numbers of sixteen triples.
    #[inline(always)]
    fn load_triples(self, triples: &[[f32; 3]; LANES]) -> [Self::F; 3] {
        each!(c => self.load(&each!(k => triples[k][c])))
    }
    /// The first to fourth numbers of sixteen quadruples.
    #[inline(always)]
    fn load_quads(self, quads: &[[f32; 4]; LANES]) -> [Self::F; 4] {
        each!(c => self.load(&each!(k => quads[k][c])))
    }
    /// `table[byte]` per lane for each of the three lowest bytes of `packed`.
    #[inline(always)]
    fn look_up_bytes(self, table: &ByteTable, packed: Self::I) -> [Self::F; 3] {
        let packed = packed.to_array();
        let mut out = [[0.0; LANES]; 3];
        for (c, out) in out.iter_mut().enumerate() {
            for (out, packed) in out.iter_mut().zip(packed) {
                *out = table.values[usize::from(packed.to_le_bytes()[c])];
            }
        }
        let [r, g, b] = out;
        [self.load(&r), self.load(&g), self.load(&b)]
    }
}

/// [`Lanes::look_up_16`] by scalar loads.
#[inline(always)]
fn look_up_by_lane<L: Lanes>(l: L, table: &[i32; LANES], index: L::I) -> L::I {
    let index = index.to_array();
    l.load_i(&each!(k => table[index[k] as usize % LANES]))
}

/// Sixteen `f32`. Arithmetic is IEEE 754 round-to-nearest per lane, without contraction.
pub trait Float:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
    + Div<f32, Output = Self>
{
    /// The integers of the same instruction set.
    type I: Int<F = Self, M = Self::M>;
    /// The masks of the same instruction set.
    type M: Mask<F = Self, I = Self::I>;

    /// Correctly rounded square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// Clears the sign bit.
    fn abs(self) -> Self;
    /// Largest integer not above, as a float.
    fn floor(self) -> Self;
    /// `self < other`; false where either is NaN.
    fn lt(self, other: Self) -> Self::M;
    /// `self <= other`; false where either is NaN.
    fn le(self, other: Self) -> Self::M;
    /// `self == other`; false where either is NaN.
    fn eq(self, other: Self) -> Self::M;
    /// Truncates towards zero. Values must lie within ±(2^31 - 128): clamp first, because what happens beyond
    /// differs between processors.
    fn to_int(self) -> Self::I;
    /// The bit pattern.
    fn bits(self) -> Self::I;
    /// All lanes.
    fn to_array(self) -> [f32; LANES];
    /// The same number in every lane.
    fn splat_like(self, value: f32) -> Self;

    /// `self > other`; false where either is NaN.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::M {
        other.lt(self)
    }
    /// `self >= other`; false where either is NaN.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::M {
        other.le(self)
    }
    /// `self < other ? self : other`: a NaN in `self` yields `other`.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }
    /// `self > other ? self : other`: a NaN in `self` yields `other`.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }
    /// [`Float::min`] against a constant: a NaN in `self` yields the constant.
    #[inline(always)]
    fn at_most(self, limit: f32) -> Self {
        self.min(self.splat_like(limit))
    }
    /// [`Float::max`] against a constant: a NaN in `self` yields the constant.
    #[inline(always)]
    fn at_least(self, limit: f32) -> Self {
        self.max(self.splat_like(limit))
    }
    /// `clamp(self, low, high)`; NaN yields `low`.
    #[inline(always)]
    fn clamp_to(self, low: f32, high: f32) -> Self {
        self.at_least(low).at_most(high)
    }
    /// `clamp(self, 0, 1)`; NaN yields 0.
    #[inline(always)]
    fn saturate(self) -> Self {
        self.clamp_to(0.0, 1.0)
    }
    /// `1 - self`.
    #[inline(always)]
    fn one_minus(self) -> Self {
        self.splat_like(1.0) - self
    }
    /// `1 / self`, correctly rounded.
    #[inline(always)]
    fn recip(self) -> Self {
        self.splat_like(1.0) / self
    }
    /// `self + t * (other - self)`, in this order of operations (HLSL `lerp`).
    #[inline(always)]
    fn lerp(self, other: Self, t: Self) -> Self {
        self + t * (other - self)
    }
    /// `self * self`.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
}

/// Sixteen `i32` with wrapping arithmetic.
pub trait Int:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Add<i32, Output = Self>
    + Sub<i32, Output = Self>
    + Mul<i32, Output = Self>
    + BitAnd<i32, Output = Self>
    + BitOr<i32, Output = Self>
{
    /// The floats of the same instruction set.
    type F: Float<I = Self, M = Self::M>;
    /// The masks of the same instruction set.
    type M: Mask<F = Self::F, I = Self>;

    /// Shift left by a constant, 0 to 31.
    fn shl(self, bits: u32) -> Self;
    /// Arithmetic shift right by a constant, 0 to 31.
    fn shr(self, bits: u32) -> Self;
    /// Logical shift right by a constant, 0 to 31.
    fn shr_logical(self, bits: u32) -> Self;
    /// `self < other`, signed.
    fn lt(self, other: Self) -> Self::M;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::M;
    /// Nearest float, ties to even.
    fn to_float(self) -> Self::F;
    /// The float with this bit pattern.
    fn float_from_bits(self) -> Self::F;
    /// All lanes.
    fn to_array(self) -> [i32; LANES];
    /// The same number in every lane.
    fn splat_like(self, value: i32) -> Self;

    /// The smaller, signed.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.lt(other).select_i(self, other)
    }
    /// The larger, signed.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.lt(self).select_i(self, other)
    }
    /// Lanes whose sign bit is clear.
    #[inline(always)]
    fn non_negative(self) -> Self::M {
        self.splat_like(-1).lt(self)
    }
}

/// Sixteen booleans.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The floats of the same instruction set.
    type F: Float<I = Self::I, M = Self>;
    /// The integers of the same instruction set.
    type I: Int<F = Self::F, M = Self>;

    /// `yes` where true, `no` where false.
    fn select(self, yes: Self::F, no: Self::F) -> Self::F;
    /// `yes` where true, `no` where false.
    fn select_i(self, yes: Self::I, no: Self::I) -> Self::I;
    /// Bit k is lane k.
    fn bits(self) -> u16;

    /// True if any lane is.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// True if every lane is.
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == u16::MAX
    }
}

/// `each!(k => a[k] + b[k])`: an array by index; `each!(c in v => c * s)`: an array from an array. Inlined into the
/// instruction set, see [`array_from_fn`](crate::math::lanes::array_from_fn).
#[macro_export]
macro_rules! each {
    ($k:ident => $body:expr) => {
        $crate::math::lanes::array_from_fn(
            #[inline(always)]
            |$k: usize| $body,
        )
    };
    ($c:ident in $array:expr => $body:expr) => {
        $crate::math::lanes::map_array(
            $array,
            #[inline(always)]
            |$c| $body,
        )
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A little of everything, on numbers of all magnitudes.
    #[inline(always)]
    fn probe<L: Lanes>(l: L, a: &[f32; LANES], b: &[f32; LANES]) -> Vec<u32> {
        let (x, y) = (l.load(a), l.load(b));
        let i = x.bits();
        let j = y.bits();
        // All bytes of the numbers differ; none is NaN.
        let bytes = ByteTable::new(std::array::from_fn(|k| {
            f32::from_bits((k as u32).wrapping_mul(0x9e37_79b1) & 0xbfff_ffff)
        }));
        let triples: [[f32; 3]; LANES] = std::array::from_fn(|k| [a[k], b[k], a[LANES - 1 - k]]);
        let quads: [[f32; 4]; LANES] = std::array::from_fn(|k| [b[k], a[LANES - 1 - k], a[k], b[k ^ 5]]);
        let floats = [
            x + y,
            x - y,
            x * y,
            x / y,
            x.sqrt(),
            -x,
            x.abs(),
            x.floor(),
            x.min(y),
            y.max(x),
            x.saturate(),
            x.lerp(y, x),
            x * 3.0 + 0.1,
            x.lt(y).select(x, y),
            i.to_float(),
            (x.le(y) & !x.eq(y)).select(y, x),
            l.look_up_bytes(&bytes, i)[0],
            l.look_up_bytes(&bytes, i)[1],
            l.look_up_bytes(&bytes, i)[2],
            l.load_triples(&triples)[0],
            l.load_triples(&triples)[1],
            l.load_triples(&triples)[2],
            l.load_quads(&quads)[0],
            l.load_quads(&quads)[1],
            l.load_quads(&quads)[2],
            l.load_quads(&quads)[3],
        ];
        // Some indices lie outside of the table, one pair across its end.
        let table: [u32; 20] = std::array::from_fn(|k| a[k % LANES].to_bits() ^ k as u32);
        let index = (i & 15) + (l.lane_indices() - 3);
        let [first, second] = l.gather_pairs_u32(&table, index);
        let texels = table.map(u32::to_le_bytes);
        let reversed = std::array::from_fn::<_, 12, _>(|k| texels[19 - k]);
        // The end of the shorter table counts for both.
        let of_both = l.gather_pairs_bytes([&texels, &reversed], index);
        let alone = [&texels[..12], &reversed].map(|table| l.gather_pairs_bytes([table], index)[0]);
        assert_eq!(of_both.map(|p| p.map(Int::to_array)), alone.map(|p| p.map(Int::to_array)));
        let zipped = l.zip(i, j);
        let ints = [
            l.unzip(zipped)[0],
            l.unzip(zipped)[1],
            l.load_i(&std::array::from_fn(|k| zipped[k / 2][k % 2])),
            l.look_up_16(&std::array::from_fn(|k| table[k + 3] as i32), i + j),
            first,
            second,
            l.gather_pairs_u32(&table, l.lane_indices() + 4)[1],
            l.gather_bytes(&texels, index),
            l.gather_pairs_bytes([&texels], index)[0][0],
            l.gather_pairs_bytes([&texels], l.lane_indices() + 4)[0][1],
            of_both[1][0],
            i + j,
            i - j,
            i * j,
            i & j,
            i | j,
            i ^ j,
            i.shl(3),
            i.shr(5),
            i.shr_logical(7),
            i.min(j),
            i.max(j),
            x.clamp_to(-1e9, 1e9).to_int(),
            i.lt(j).select_i(i, j),
            l.lane_indices(),
        ];
        let masks =
            [i.lt(j).bits(), i.eq(j).bits(), x.gt(y).bits(), i.non_negative().bits(), l.mask(0xa5c3).bits()];
        // A NaN's payload is not part of the contract.
        let canonical = |v: f32| if v.is_nan() { f32::NAN.to_bits() } else { v.to_bits() };
        floats
            .iter()
            .flat_map(|v| v.to_array().map(canonical))
            .chain(ints.iter().flat_map(|v| v.to_array().map(|k| k as u32)))
            .chain(masks.iter().map(|&m| u32::from(m)))
            .collect()
    }

    #[test]
    fn every_level_computes_the_bits_of_the_scalar_reference() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state
        };
        for round in 0..2000 {
            let mut draw = || {
                std::array::from_fn::<f32, LANES, _>(|_| match round % 3 {
                    0 => f32::from_bits(next()),
                    1 => (next() >> 8) as f32 / 65536.0 - 128.0,
                    _ => [0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, -1.5, 1e-40, f32::MAX]
                        [next() as usize >> 29],
                })
            };
            let (a, b) = (draw(), draw());
            let expected = probe(Scalar, &a, &b);
            for level in SimdLevel::available() {
                let found = crate::dispatch!(level, l => probe(l, &a, &b));
                assert!(found == expected, "{level}: {a:?} {b:?}");
            }
        }
    }
}
