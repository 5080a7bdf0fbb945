//! The one number type of the transcendental functions: a single `f32` or sixteen lanes of it.
//!
//! A kernel is written once over [`Real`] and compiled for `f32` and for every [`Float`]; the scalar twin of
//! a lane function therefore performs the same operations and has the same bits.

use super::lanes::{Float, Int, Mask};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Operations that the kernels need of a number, each exactly rounded or exact.
pub(super) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// The wrapping 32-bit integer of the same shape.
    type I: Copy + Sub<Output = Self::I> + Add<i32, Output = Self::I> + Sub<i32, Output = Self::I>;
    /// The truth value of the same shape.
    type M: Copy + BitAnd<Output = Self::M> + BitOr<Output = Self::M> + Not<Output = Self::M>;

    fn constant(self, value: f32) -> Self;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    fn lt(self, other: Self) -> Self::M;
    fn eq(self, other: Self) -> Self::M;
    fn select(condition: Self::M, yes: Self, no: Self) -> Self;
    /// True where bit k of the integer is set.
    fn bit_set(value: Self::I, k: u32) -> Self::M;
    fn bits(self) -> Self::I;
    fn from_bits(bits: Self::I) -> Self;
    fn int_to_float(value: Self::I) -> Self;
    fn shl(value: Self::I, by: u32) -> Self::I;
    fn shr(value: Self::I, by: u32) -> Self::I;
    fn and(value: Self::I, mask: i32) -> Self::I;

    /// The first 12 bits of the significand: products of two such numbers are exact.
    #[inline(always)]
    fn high_half(self) -> Self {
        Self::from_bits(Self::and(self.bits(), !0xfff))
    }
    /// `self` limited to `low..=high`; NaN stays NaN.
    #[inline(always)]
    fn limited(self, low: f32, high: f32) -> Self {
        let (low, high) = (self.constant(low), self.constant(high));
        let above_low = Self::select(self.lt(low), low, self);
        Self::select(high.lt(above_low), high, above_low)
    }
    /// The sign of `other` on the magnitude of `self`, which must not be negative.
    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self::select(Self::bit_set(other.bits(), 31), -self, self)
    }
    /// `c[0] + c[1] x + c[2] x^2 + ...` by Horner's rule.
    #[inline(always)]
    fn polynomial<const N: usize>(self, c: [f32; N]) -> Self {
        let mut sum = self.constant(c[N - 1]);
        for k in (0..N - 1).rev() {
            sum = sum * self + c[k];
        }
        sum
    }
}

impl<F: Float> Real for F {
    type I = F::I;
    type M = F::M;

    #[inline(always)]
    fn constant(self, value: f32) -> Self {
        self.splat_like(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Float::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Float::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> F::M {
        Float::lt(self, other)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> F::M {
        Float::eq(self, other)
    }
    #[inline(always)]
    fn select(condition: F::M, yes: Self, no: Self) -> Self {
        Mask::select(condition, yes, no)
    }
    #[inline(always)]
    fn bit_set(value: F::I, k: u32) -> F::M {
        Int::lt(value.shl(31 - k), value.splat_like(0))
    }
    #[inline(always)]
    fn bits(self) -> F::I {
        Float::bits(self)
    }
    #[inline(always)]
    fn from_bits(bits: F::I) -> Self {
        bits.float_from_bits()
    }
    #[inline(always)]
    fn int_to_float(value: F::I) -> Self {
        value.to_float()
    }
    #[inline(always)]
    fn shl(value: F::I, by: u32) -> F::I {
        Int::shl(value, by)
    }
    #[inline(always)]
    fn shr(value: F::I, by: u32) -> F::I {
        Int::shr(value, by)
    }
    #[inline(always)]
    fn and(value: F::I, mask: i32) -> F::I {
        value & mask
    }
}

/// The bits of one `f32`, with wrapping arithmetic.
#[derive(Clone, Copy)]
pub(super) struct Bits(i32);

impl Sub for Bits {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}
impl Add<i32> for Bits {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: i32) -> Self {
        Self(self.0.wrapping_add(other))
    }
}
impl Sub<i32> for Bits {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: i32) -> Self {
        Self(self.0.wrapping_sub(other))
    }
}

impl Real for f32 {
    type I = Bits;
    type M = bool;

    #[inline(always)]
    fn constant(self, value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(condition: bool, yes: Self, no: Self) -> Self {
        if condition { yes } else { no }
    }
    #[inline(always)]
    fn bit_set(value: Bits, k: u32) -> bool {
        value.0 >> k & 1 == 1
    }
    #[inline(always)]
    fn bits(self) -> Bits {
        Bits(self.to_bits() as i32)
    }
    #[inline(always)]
    fn from_bits(bits: Bits) -> Self {
        Self::from_bits(bits.0 as u32)
    }
    #[inline(always)]
    fn int_to_float(value: Bits) -> Self {
        value.0 as Self
    }
    #[inline(always)]
    fn shl(value: Bits, by: u32) -> Bits {
        Bits(value.0 << by)
    }
    #[inline(always)]
    fn shr(value: Bits, by: u32) -> Bits {
        Bits(value.0 >> by)
    }
    #[inline(always)]
    fn and(value: Bits, mask: i32) -> Bits {
        Bits(value.0 & mask)
    }
}
