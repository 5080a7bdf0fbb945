//! The reference lanes: arrays, one element after the other.
//!
//! The operators are ordinary functions that are not inlined. A kernel then stays a list of calls instead of
//! sixteen times its arithmetic, which keeps compile times in hand on every target.

use super::{Float, Int, LANES, Lanes, Mask};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The token of the reference lanes: available on every processor, slow, and the definition of all others.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

/// Sixteen `f32` in an array.
#[derive(Clone, Copy, Debug)]
pub struct ScalarFloat([f32; LANES]);

/// Sixteen `i32` in an array.
#[derive(Clone, Copy, Debug)]
pub struct ScalarInt([i32; LANES]);

/// Sixteen booleans, one a bit.
#[derive(Clone, Copy, Debug)]
pub struct ScalarMask(u16);

macro_rules! binary {
    ($type:ident, $element:ty, $trait:ident, $method:ident, |$a:ident, $b:ident| $body:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(never)]
            fn $method(self, other: Self) -> Self {
                Self(std::array::from_fn(|k| {
                    let ($a, $b) = (self.0[k], other.0[k]);
                    $body
                }))
            }
        }
        impl $trait<$element> for $type {
            type Output = Self;
            #[inline(never)]
            fn $method(self, other: $element) -> Self {
                Self(std::array::from_fn(|k| {
                    let ($a, $b) = (self.0[k], other);
                    $body
                }))
            }
        }
    };
}
binary!(ScalarFloat, f32, Add, add, |a, b| a + b);
binary!(ScalarFloat, f32, Sub, sub, |a, b| a - b);
binary!(ScalarFloat, f32, Mul, mul, |a, b| a * b);
binary!(ScalarFloat, f32, Div, div, |a, b| a / b);
binary!(ScalarInt, i32, Add, add, |a, b| a.wrapping_add(b));
binary!(ScalarInt, i32, Sub, sub, |a, b| a.wrapping_sub(b));
binary!(ScalarInt, i32, Mul, mul, |a, b| a.wrapping_mul(b));
binary!(ScalarInt, i32, BitAnd, bitand, |a, b| a & b);
binary!(ScalarInt, i32, BitOr, bitor, |a, b| a | b);
binary!(ScalarInt, i32, BitXor, bitxor, |a, b| a ^ b);

impl Neg for ScalarFloat {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

/// The lanes in which `test` holds.
#[inline(always)]
fn mask_of(test: impl Fn(usize) -> bool) -> ScalarMask {
    let mut bits = 0;
    for k in 0..LANES {
        bits |= u16::from(test(k)) << k;
    }
    ScalarMask(bits)
}

impl Lanes for Scalar {
    type F = ScalarFloat;
    type I = ScalarInt;
    type M = ScalarMask;

    #[inline(always)]
    fn splat(self, value: f32) -> ScalarFloat {
        ScalarFloat([value; LANES])
    }
    #[inline(always)]
    fn splat_i(self, value: i32) -> ScalarInt {
        ScalarInt([value; LANES])
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> ScalarFloat {
        ScalarFloat(*values)
    }
    #[inline(always)]
    fn load_i(self, values: &[i32; LANES]) -> ScalarInt {
        ScalarInt(*values)
    }
    #[inline(always)]
    fn mask(self, bits: u16) -> ScalarMask {
        ScalarMask(bits)
    }
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
}

impl Float for ScalarFloat {
    type I = ScalarInt;
    type M = ScalarMask;

    #[inline(never)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(never)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(never)]
    fn floor(self) -> Self {
        Self(self.0.map(f32::floor))
    }
    #[inline(never)]
    fn lt(self, other: Self) -> ScalarMask {
        mask_of(|k| self.0[k] < other.0[k])
    }
    #[inline(never)]
    fn le(self, other: Self) -> ScalarMask {
        mask_of(|k| self.0[k] <= other.0[k])
    }
    #[inline(never)]
    fn eq(self, other: Self) -> ScalarMask {
        mask_of(|k| self.0[k] == other.0[k])
    }
    #[inline(never)]
    fn to_int(self) -> ScalarInt {
        ScalarInt(self.0.map(|a| a as i32))
    }
    #[inline(always)]
    fn bits(self) -> ScalarInt {
        ScalarInt(self.0.map(|a| a.to_bits() as i32))
    }
    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        self.0
    }
    #[inline(always)]
    fn splat_like(self, value: f32) -> Self {
        Self([value; LANES])
    }
}

impl Int for ScalarInt {
    type F = ScalarFloat;
    type M = ScalarMask;

    #[inline(never)]
    fn shl(self, bits: u32) -> Self {
        Self(self.0.map(|a| a << bits))
    }
    #[inline(never)]
    fn shr(self, bits: u32) -> Self {
        Self(self.0.map(|a| a >> bits))
    }
    #[inline(never)]
    fn shr_logical(self, bits: u32) -> Self {
        Self(self.0.map(|a| ((a as u32) >> bits) as i32))
    }
    #[inline(never)]
    fn lt(self, other: Self) -> ScalarMask {
        mask_of(|k| self.0[k] < other.0[k])
    }
    #[inline(never)]
    fn eq(self, other: Self) -> ScalarMask {
        mask_of(|k| self.0[k] == other.0[k])
    }
    #[inline(never)]
    fn to_float(self) -> ScalarFloat {
        ScalarFloat(self.0.map(|a| a as f32))
    }
    #[inline(always)]
    fn float_from_bits(self) -> ScalarFloat {
        ScalarFloat(self.0.map(|a| f32::from_bits(a as u32)))
    }
    #[inline(always)]
    fn to_array(self) -> [i32; LANES] {
        self.0
    }
    #[inline(always)]
    fn splat_like(self, value: i32) -> Self {
        Self([value; LANES])
    }
}

impl BitAnd for ScalarMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}
impl BitOr for ScalarMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
impl Not for ScalarMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
impl Mask for ScalarMask {
    type F = ScalarFloat;
    type I = ScalarInt;

    #[inline(never)]
    fn select(self, yes: ScalarFloat, no: ScalarFloat) -> ScalarFloat {
        ScalarFloat(std::array::from_fn(|k| if self.0 >> k & 1 == 1 { yes.0[k] } else { no.0[k] }))
    }
    #[inline(never)]
    fn select_i(self, yes: ScalarInt, no: ScalarInt) -> ScalarInt {
        ScalarInt(std::array::from_fn(|k| if self.0 >> k & 1 == 1 { yes.0[k] } else { no.0[k] }))
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0
    }
}
