//! The fast lanes: the 512-bit vectors of `fearless_simd`, in one, two or four registers as the processor has it.

#[cfg(target_arch = "x86_64")]
use super::permutations::{NUMBERS, PAIRS, SPREAD};
use super::{ByteTable, Float, Int, LANES, Lanes, Mask, look_up_by_lane};
use crate::each;
use fearless_simd::{Bytes, ExtractToken};
use fearless_simd::{
    Select, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x4, f32x16, i32x4, i32x8, i32x16, i64x2,
    mask32x16, u32x16,
};
#[cfg(target_arch = "x86_64")]
use fearless_simd::{i8x64, u8x64};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The token of one instruction set, proof that the processor has it.
#[derive(Clone, Copy, Debug)]
pub struct Vector<S>(pub(super) S);

/// Sixteen `f32` in vector registers.
#[derive(Clone, Copy)]
pub struct VectorFloat<S: Simd>(f32x16<S>);

/// Sixteen `i32` in vector registers.
#[derive(Clone, Copy)]
pub struct VectorInt<S: Simd>(i32x16<S>);

/// Sixteen booleans in vector or mask registers.
#[derive(Clone, Copy)]
pub struct VectorMask<S: Simd>(mask32x16<S>);

macro_rules! binary {
    ($type:ident, $element:ty, $trait:ident, $method:ident, $op:tt) => {
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        }
        impl<S: Simd> $trait<$element> for $type<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: $element) -> Self {
                Self(self.0 $op other)
            }
        }
    };
}
binary!(VectorFloat, f32, Add, add, +);
binary!(VectorFloat, f32, Sub, sub, -);
binary!(VectorFloat, f32, Mul, mul, *);
binary!(VectorFloat, f32, Div, div, /);
binary!(VectorInt, i32, Add, add, +);
binary!(VectorInt, i32, Sub, sub, -);
binary!(VectorInt, i32, Mul, mul, *);
binary!(VectorInt, i32, BitAnd, bitand, &);
binary!(VectorInt, i32, BitOr, bitor, |);
binary!(VectorInt, i32, BitXor, bitxor, ^);

impl<S: Simd> Neg for VectorFloat<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Lanes for Vector<S> {
    type F = VectorFloat<S>;
    type I = VectorInt<S>;
    type M = VectorMask<S>;

    #[inline(always)]
    fn splat(self, value: f32) -> VectorFloat<S> {
        VectorFloat(f32x16::splat(self.0, value))
    }
    #[inline(always)]
    fn splat_i(self, value: i32) -> VectorInt<S> {
        VectorInt(i32x16::splat(self.0, value))
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> VectorFloat<S> {
        VectorFloat(f32x16::load_array_ref(self.0, values))
    }
    #[inline(always)]
    fn load_i(self, values: &[i32; LANES]) -> VectorInt<S> {
        VectorInt(i32x16::load_array_ref(self.0, values))
    }
    #[inline(always)]
    fn mask(self, bits: u16) -> VectorMask<S> {
        VectorMask(mask32x16::from_bitmask(self.0, u64::from(bits)))
    }
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        self.0.vectorize(f)
    }
    #[inline(always)]
    fn unzip_halves(self, numbers: [i64; LANES]) -> [VectorInt<S>; 2] {
        // Put together by halves: from one array of all, AVX-512 code inserts pair by pair, each waiting for the last. And
        // as numbers of 64 bits: two are one vector after two instructions, four numbers of 32 bits after four and more. The
        // lower half comes first in a vector: every processor that has one here is little-endian.
        let quarter: [i32x4<S>; 8] = each!(k => {
            let pair = i64x2::load_array(self.0, [numbers[2 * k], numbers[2 * k + 1]]);
            pair.bitcast()
        });
        let [a, b, c, d]: [i32x8<S>; 4] =
            each!(k => self.0.combine_i32x4(quarter[2 * k], quarter[2 * k + 1]));
        let (low, high) = (self.0.combine_i32x8(a, b), self.0.combine_i32x8(c, d));
        let (first, second) = self.0.deinterleave_i32x16(low, high);
        [VectorInt(first), VectorInt(second)]
    }
    #[inline(always)]
    fn zip(self, first: VectorInt<S>, second: VectorInt<S>) -> [[i32; 2]; LANES] {
        let (low, high) = self.0.interleave_i32x16(first.0, second.0);
        let halves = [SimdBase::to_array(low), SimdBase::to_array(high)];
        each!(k => [halves[k / 8][2 * k % 16], halves[k / 8][2 * k % 16 + 1]])
    }
    #[inline(always)]
    fn load_triples(self, triples: &[[f32; 3]; LANES]) -> [VectorFloat<S>; 3] {
        // Each with the number behind it, which nobody asks for, so that it is one load.
        let numbers = triples.as_flattened();
        let quads: [f32x4<S>; LANES] = each!(k => {
            let at = 3 * k;
            let behind = if k + 1 < LANES { numbers[at + 3] } else { 0.0 };
            f32x4::load_array(self.0, [numbers[at], numbers[at + 1], numbers[at + 2], behind])
        });
        let four: [f32x16<S>; 4] = each!(k => self.0.combine_f32x8(
            self.0.combine_f32x4(quads[4 * k], quads[4 * k + 1]),
            self.0.combine_f32x4(quads[4 * k + 2], quads[4 * k + 3]),
        ));
        let [x, y, z, _] = unzip_quads(self.0, four);
        [x, y, z]
    }
    #[inline(always)]
    fn load_quads(self, quads: &[[f32; 4]; LANES]) -> [VectorFloat<S>; 4] {
        let (vectors, _) = quads.as_flattened().as_chunks::<LANES>();
        let four: [f32x16<S>; 4] = each!(k => f32x16::load_array_ref(self.0, &vectors[k]));
        unzip_quads(self.0, four)
    }
    #[inline(always)]
    fn look_up_16(self, table: &[i32; LANES], index: VectorInt<S>) -> VectorInt<S> {
        #[cfg(target_arch = "x86_64")]
        if matches!(self.0.level(), fearless_simd::Level::Avx512(_)) {
            // The four bytes of number k are bytes 4 k to 4 k + 3.
            let first = ((index & 15).shl(2)).0.bitcast::<u8x64<S>>();
            let places =
                first.swizzle_dyn_within_blocks(bytes(self.0, &SPREAD[0])) | bytes(self.0, &SPREAD[1]);
            let table = i32x16::load_array_ref(self.0, table).bitcast::<u8x64<S>>();
            return VectorInt(table.swizzle_dyn(places).bitcast());
        }
        look_up_by_lane(self, table, index)
    }
    #[inline(always)]
    fn look_up_bytes(self, table: &ByteTable, packed: VectorInt<S>) -> [VectorFloat<S>; 3] {
        #[cfg(target_arch = "x86_64")]
        if matches!(self.0.level(), fearless_simd::Level::Avx512(_)) {
            return permute_bytes(self.0, table, packed);
        }
        let packed = packed.to_array();
        each!(c => {
            let quarter: [f32x4<S>; 4] = each!(q => {
                let found: [f32; 4] =
                    each!(k => table.values[usize::from(packed[4 * q + k].to_le_bytes()[c])]);
                f32x4::load_array(self.0, found)
            });
            let [a, b, c, d] = quarter;
            VectorFloat(
                self.0.combine_f32x8(self.0.combine_f32x4(a, b), self.0.combine_f32x4(c, d)),
            )
        })
    }
}

/// The first to fourth numbers of sixteen quadruples, of which each vector holds four.
#[inline(always)]
fn unzip_quads<S: Simd>(token: S, four: [f32x16<S>; 4]) -> [VectorFloat<S>; 4] {
    let (low_even, low_odd) = token.deinterleave_f32x16(four[0], four[1]);
    let (high_even, high_odd) = token.deinterleave_f32x16(four[2], four[3]);
    let (x, z) = token.deinterleave_f32x16(low_even, high_even);
    let (y, w) = token.deinterleave_f32x16(low_odd, high_odd);
    [VectorFloat(x), VectorFloat(y), VectorFloat(z), VectorFloat(w)]
}

/// [`Lanes::look_up_bytes`] by permutations of bytes: an instruction finds one byte of 64 numbers in half of a table. With
/// AVX-512 (VBMI), decoding took a sixth of the time in the profile of a textured frame (Zen 5); elsewhere permutations do not
/// reach that far.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn permute_bytes<S: Simd>(token: S, table: &ByteTable, packed: VectorInt<S>) -> [VectorFloat<S>; 3] {
    let packed: u8x64<S> = packed.0.bitcast();
    let is_upper = packed.bitcast::<i8x64<S>>().simd_lt(i8x64::splat(token, 0));
    let index = packed & 0x7f;
    // Every byte of the numbers, for all bytes.
    let [a, b, c, d]: [u8x64<S>; 4] = each!(part => {
        let [q0, q1, q2, q3] = &table.bytes[part];
        let lower = bytes(token, q0).concat_swizzle_dyn(bytes(token, q1), index);
        let upper = bytes(token, q2).concat_swizzle_dyn(bytes(token, q3), index);
        is_upper.select(upper, lower)
    });
    let [first_and_second, third] = &PAIRS;
    let [first_half, second_half] = &NUMBERS;
    let (first_and_second, third) = (bytes(token, first_and_second), bytes(token, third));
    let (first_half, second_half) = (bytes(token, first_half), bytes(token, second_half));
    let [ab, cd] = [a.concat_swizzle_dyn(b, first_and_second), c.concat_swizzle_dyn(d, first_and_second)];
    let [ab_3, cd_3] = [a.concat_swizzle_dyn(b, third), c.concat_swizzle_dyn(d, third)];
    [
        VectorFloat(ab.concat_swizzle_dyn(cd, first_half).bitcast()),
        VectorFloat(ab.concat_swizzle_dyn(cd, second_half).bitcast()),
        VectorFloat(ab_3.concat_swizzle_dyn(cd_3, first_half).bitcast()),
    ]
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn bytes<S: Simd>(token: S, bytes: &[u8; 64]) -> u8x64<S> {
    u8x64::load_array_ref(token, bytes)
}

/// True if the minimum of an instruction set is `a < b ? a : b` and its maximum `a > b ? a : b`, with the second
/// operand for NaN and for zeros of both signs: MINPS and MAXPS of x86 are (Intel SDM, volume 2B). Others have a rule
/// for NaN and order the zeros. The library leaves both to the instruction set; the test of the levels against the
/// reference holds it.
#[inline(always)]
fn has_ordered_min_max<S: Simd>(token: S) -> bool {
    cfg!(any(target_arch = "x86", target_arch = "x86_64")) && !token.level().is_fallback()
}

impl<S: Simd> Float for VectorFloat<S> {
    type I = VectorInt<S>;
    type M = VectorMask<S>;

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(SimdFloat::sqrt(self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        #[cfg(target_arch = "x86_64")]
        if matches!(self.0.token().level(), fearless_simd::Level::Sse2(_)) {
            // SSE2 has no rounding instruction, and the library's takes one lane at a time. From 2^23 on every float
            // is an integer; below, truncation is exact. The sign of -0.0 is kept by the last selection.
            let truncated = Self(SimdInt::to_float::<f32x16<S>>(SimdFloat::to_int::<i32x16<S>>(self.0)));
            let below = truncated.gt(self).select(truncated - 1.0, truncated);
            let small = self.abs().lt(self.splat_like(8_388_608.0)) & !self.eq(below);
            return small.select(below, self);
        }
        Self(SimdFloat::floor(self.0))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if has_ordered_min_max(self.0.token()) {
            return Self(self.0.min(other.0));
        }
        self.lt(other).select(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if has_ordered_min_max(self.0.token()) {
            return Self(self.0.max(other.0));
        }
        self.gt(other).select(self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> VectorMask<S> {
        VectorMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> VectorMask<S> {
        VectorMask(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> VectorMask<S> {
        VectorMask(self.0.simd_eq(other.0))
    }
    #[inline(always)]
    fn to_int(self) -> VectorInt<S> {
        VectorInt(SimdFloat::to_int::<i32x16<S>>(self.0))
    }
    #[inline(always)]
    fn bits(self) -> VectorInt<S> {
        VectorInt(self.0.bitcast())
    }
    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        SimdBase::to_array(self.0)
    }
    #[inline(always)]
    fn splat_like(self, value: f32) -> Self {
        Self(f32x16::splat(self.0.token(), value))
    }
}

impl<S: Simd> Int for VectorInt<S> {
    type F = VectorFloat<S>;
    type M = VectorMask<S>;

    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
    #[inline(always)]
    fn shr_logical(self, bits: u32) -> Self {
        Self((self.0.bitcast::<u32x16<S>>() >> bits).bitcast())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> VectorMask<S> {
        VectorMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> VectorMask<S> {
        VectorMask(self.0.simd_eq(other.0))
    }
    #[inline(always)]
    fn to_float(self) -> VectorFloat<S> {
        VectorFloat(SimdInt::to_float::<f32x16<S>>(self.0))
    }
    #[inline(always)]
    fn float_from_bits(self) -> VectorFloat<S> {
        VectorFloat(self.0.bitcast())
    }
    #[inline(always)]
    fn to_array(self) -> [i32; LANES] {
        SimdBase::to_array(self.0)
    }
    #[inline(always)]
    fn splat_like(self, value: i32) -> Self {
        Self(i32x16::splat(self.0.token(), value))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
}

impl<S: Simd> BitAnd for VectorMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
impl<S: Simd> BitOr for VectorMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
impl<S: Simd> Not for VectorMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
impl<S: Simd> Mask for VectorMask<S> {
    type F = VectorFloat<S>;
    type I = VectorInt<S>;

    #[inline(always)]
    fn select(self, yes: VectorFloat<S>, no: VectorFloat<S>) -> VectorFloat<S> {
        VectorFloat(self.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn select_i(self, yes: VectorInt<S>, no: VectorInt<S>) -> VectorInt<S> {
        VectorInt(self.0.select(yes.0, no.0))
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0.to_bitmask() as u16
    }
}
