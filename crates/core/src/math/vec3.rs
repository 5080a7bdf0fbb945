//! Vectors of three lane numbers, with a fixed order of operations.
//!
//! Operators and functions mean what they mean in GLSL and HLSL: a vector and a number stand for the number with each
//! component, the product of two vectors is that of their components.

use super::lanes::{Float, LANES, Lanes, Mask};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

/// Three numbers a lane: a point, a direction or a linear colour.
pub type V3<L> = Vec3<<L as Lanes>::F>;

/// Three numbers: x, y and z, or red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<F> {
    /// The first component, red of a colour.
    pub x: F,
    /// The second component, green of a colour.
    pub y: F,
    /// The third component, blue of a colour.
    pub z: F,
}

/// `vec3!(c in v => f(c))`: `f` of every component; `vec3!(k => f(a[k], b[k]))`: a vector by index. For what has no
/// operator or method; inlined into the instruction set, see [`Vec3::map`].
#[macro_export]
macro_rules! vec3 {
    ($k:ident => $body:expr) => {
        $crate::math::vec3::Vec3::from_fn(
            #[inline(always)]
            |$k: usize| $body,
        )
    };
    ($c:ident in $vector:expr => $body:expr) => {
        $crate::math::vec3::Vec3::map(
            $vector,
            #[inline(always)]
            |$c| $body,
        )
    };
}

impl<F> Vec3<F> {
    /// The vector of these components.
    #[inline(always)]
    pub const fn new(x: F, y: F, z: F) -> Self {
        Self { x, y, z }
    }

    /// The vector of these components.
    #[inline(always)]
    pub fn from_array(v: [F; 3]) -> Self {
        let [x, y, z] = v;
        Self { x, y, z }
    }

    /// The components.
    #[inline(always)]
    pub fn to_array(self) -> [F; 3] {
        [self.x, self.y, self.z]
    }

    /// `f` of every component. Mark the closure `#[inline(always)]`, as [`vec3!`](crate::vec3) does: others are
    /// compiled for the least instruction set and called, which makes lane arithmetic several times slower.
    #[inline(always)]
    pub fn map<T>(self, f: impl Fn(F) -> T) -> Vec3<T> {
        Vec3 { x: f(self.x), y: f(self.y), z: f(self.z) }
    }

    /// `(f(0), f(1), f(2))`. Mark the closure `#[inline(always)]`; see [`Vec3::map`].
    #[inline(always)]
    pub fn from_fn(f: impl Fn(usize) -> F) -> Self {
        Self { x: f(0), y: f(1), z: f(2) }
    }
}

impl<F: Copy> Vec3<F> {
    /// The same number three times: a grey.
    #[inline(always)]
    pub fn uniform(value: F) -> Self {
        Self { x: value, y: value, z: value }
    }
}

impl<F: Float> Vec3<F> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat<L: Lanes<F = F>>(l: L, v: [f32; 3]) -> Self {
        Self { x: l.splat(v[0]), y: l.splat(v[1]), z: l.splat(v[2]) }
    }

    /// Zero in every lane.
    #[inline(always)]
    pub fn zero<L: Lanes<F = F>>(l: L) -> Self {
        Self::uniform(l.zero())
    }

    /// `(x x' + y y') + z z'`, in this order.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F {
        (self.x * other.x + self.y * other.y) + self.z * other.z
    }

    /// Right-handed cross product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self { x: a.y * b.z - a.z * b.y, y: a.z * b.x - a.x * b.z, z: a.x * b.y - a.y * b.x }
    }

    /// Euclidean length.
    #[inline(always)]
    pub fn length(self) -> F {
        self.dot(self).sqrt()
    }

    /// The vector at length 1; one whose squared length is below the smallest normal number (1.2e-38) shrinks
    /// towards zero instead, and zero stays zero. Components beyond 1.8e19 overflow.
    ///
    /// The rule of Unity's `SafeNormalize`: v / sqrt(max(`FLT_MIN`, v.v)).
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.dot(self).at_least(f32::MIN_POSITIVE).sqrt().recip()
    }

    /// [`Vec3::normalize`] by three divisions, as GLSL defines it: v / length(v), components rounded once less. Half
    /// vectors of models whose original is GLSL need the bits, because 1 - (N.H)^2 magnifies the last one near the
    /// mirror direction.
    #[inline(always)]
    pub fn divide_by_length(self) -> Self {
        self / self.dot(self).at_least(f32::MIN_POSITIVE).sqrt()
    }

    /// Two unit vectors that are perpendicular to this one, of unit length, and to each other: (b1, b2, n) is right-handed.
    ///
    /// Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3.
    #[inline(always)]
    pub fn any_basis<L: Lanes<F = F>>(self, l: L) -> [Self; 2] {
        let Self { x, y, z } = self;
        let sign = z.lt(l.zero()).select(l.splat(-1.0), l.splat(1.0));
        let a = (sign + z).recip() * -1.0;
        let b = x * y * a;
        [
            Self { x: sign * x * x * a + 1.0, y: sign * b, z: -sign * x },
            Self { x: b, y: sign + y * y * a, z: -y },
        ]
    }

    /// The incident direction mirrored at the plane with normal n: i - 2 (n.i) n, both pointing as in HLSL
    /// `reflect` (i towards the surface, the result away from it).
    #[inline(always)]
    pub fn reflect(self, n: Self) -> Self {
        self - n * (self.dot(n) * 2.0)
    }

    /// `self + t * (other - self)`, in this order of operations (HLSL `lerp`).
    #[inline(always)]
    pub fn lerp(self, other: Self, t: F) -> Self {
        Self { x: self.x.lerp(other.x, t), y: self.y.lerp(other.y, t), z: self.z.lerp(other.z, t) }
    }

    /// `yes` where the mask is true, `no` elsewhere.
    #[inline(always)]
    pub fn select(condition: F::M, yes: Self, no: Self) -> Self {
        Self {
            x: condition.select(yes.x, no.x),
            y: condition.select(yes.y, no.y),
            z: condition.select(yes.z, no.z),
        }
    }

    /// [`Float::min`] of every component with the other's.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// [`Float::max`] of every component with the other's.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// The largest component.
    #[inline(always)]
    pub fn max_component(self) -> F {
        self.x.max(self.y).max(self.z)
    }

    /// The vector of one lane, 0 to 15.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> [f32; 3] {
        [self.x.to_array()[lane], self.y.to_array()[lane], self.z.to_array()[lane]]
    }

    /// All lanes of every component.
    #[inline(always)]
    pub fn to_arrays(self) -> [[f32; LANES]; 3] {
        [self.x.to_array(), self.y.to_array(), self.z.to_array()]
    }

    /// `1 - self`.
    #[inline(always)]
    pub fn one_minus(self) -> Self {
        vec3!(c in self => c.one_minus())
    }

    /// [`Float::sqrt`] of every component.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        vec3!(c in self => c.sqrt())
    }

    /// The square of every component.
    #[inline(always)]
    pub fn squared(self) -> Self {
        self * self
    }

    /// [`Float::at_most`] of every component.
    #[inline(always)]
    pub fn at_most(self, limit: f32) -> Self {
        vec3!(c in self => c.at_most(limit))
    }

    /// [`Float::at_least`] of every component.
    #[inline(always)]
    pub fn at_least(self, limit: f32) -> Self {
        vec3!(c in self => c.at_least(limit))
    }

    /// [`Float::clamp_to`] of every component.
    #[inline(always)]
    pub fn clamp_to(self, low: f32, high: f32) -> Self {
        vec3!(c in self => c.clamp_to(low, high))
    }

    /// [`Float::saturate`] of every component.
    #[inline(always)]
    pub fn saturate(self) -> Self {
        vec3!(c in self => c.saturate())
    }
}

impl<F: Float> Neg for Vec3<F> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

macro_rules! componentwise {
    ($($trait:ident::$function:ident $operator:tt;)*) => {
        $(
            impl<F: Float> $trait for Vec3<F> {
                type Output = Self;

                #[inline(always)]
                fn $function(self, other: Self) -> Self {
                    Self { x: self.x $operator other.x, y: self.y $operator other.y, z: self.z $operator other.z }
                }
            }

            impl<F: Float> $trait<F> for Vec3<F> {
                type Output = Self;

                #[inline(always)]
                fn $function(self, number: F) -> Self {
                    Self { x: self.x $operator number, y: self.y $operator number, z: self.z $operator number }
                }
            }

            impl<F: Float> $trait<f32> for Vec3<F> {
                type Output = Self;

                #[inline(always)]
                fn $function(self, number: f32) -> Self {
                    Self { x: self.x $operator number, y: self.y $operator number, z: self.z $operator number }
                }
            }
        )*
    };
}

componentwise! {
    Add::add +;
    Sub::sub -;
    Mul::mul *;
    Div::div /;
}

impl<F: Float> AddAssign for Vec3<F> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<F: Float, T> MulAssign<T> for Vec3<F>
where
    Self: Mul<T, Output = Self>,
{
    #[inline(always)]
    fn mul_assign(&mut self, factor: T) {
        *self = *self * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

    fn first(v: V3<Scalar>) -> [f32; 3] {
        v.lane(0)
    }
    fn v(x: f32, y: f32, z: f32) -> V3<Scalar> {
        Vec3::splat(Scalar, [x, y, z])
    }

    #[test]
    fn operators_are_componentwise() {
        let (a, b, two) = (v(1.0, 2.0, 3.0), v(5.0, 7.0, 11.0), Scalar.splat(2.0));
        assert_eq!(first(b + a), [6.0, 9.0, 14.0]);
        assert_eq!(first(b - a), [4.0, 5.0, 8.0]);
        assert_eq!(first(b * a), [5.0, 14.0, 33.0]);
        assert_eq!(first(b / a), [5.0, 3.5, 11.0 / 3.0]);
        assert_eq!(first(-a), [-1.0, -2.0, -3.0]);
        for of_number in [[a + two, a - two, a * two, a / two], [a + 2.0, a - 2.0, a * 2.0, a / 2.0]] {
            let expected = [[3.0, 4.0, 5.0], [-1.0, 0.0, 1.0], [2.0, 4.0, 6.0], [0.5, 1.0, 1.5]];
            assert_eq!(of_number.map(first), expected);
        }
        assert_eq!(first(a.lerp(b, two)), [9.0, 12.0, 19.0]);
        assert_eq!(first(Vec3::select(Scalar.mask(1), a, b)), [1.0, 2.0, 3.0]);
        assert_eq!(first(a.min(v(0.0, 4.0, 3.0))), [0.0, 2.0, 3.0]);
        assert_eq!(first(a.max(v(0.0, 4.0, 3.0))), [1.0, 4.0, 3.0]);
    }

    #[test]
    fn axes_are_right_handed() {
        assert_eq!(first(v(1.0, 0.0, 0.0).cross(v(0.0, 1.0, 0.0))), [0.0, 0.0, 1.0]);
        assert_eq!(first(v(2.0, 3.0, 5.0).cross(v(7.0, 11.0, 13.0))), [-16.0, 9.0, 1.0]);
    }

    #[test]
    fn normalize_keeps_zero_and_reaches_one() {
        assert_eq!(first(v(0.0, 0.0, 0.0).normalize()), [0.0; 3]);
        assert_eq!(first(v(3e-19, 0.0, 4e-19).normalize()), [0.6, 0.0, 0.8]);
        assert_eq!(first(v(0.0, -7.0, 0.0).normalize()), [0.0, -1.0, 0.0]);
        assert_eq!(first(v(0.0, 0.0, 0.0).divide_by_length()), [0.0; 3]);
        assert_eq!(first(v(0.0, 3.0, -4.0).divide_by_length()), [0.0, 3.0 / 5.0, -4.0 / 5.0]);
        let tiny = v(1e-25, 0.0, 0.0).normalize().x.to_array()[0];
        assert!(tiny > 0.0 && tiny < 1.0);
    }

    #[test]
    fn reflection_mirrors_at_the_plane() {
        assert_eq!(first(v(0.6, 0.0, -0.8).reflect(v(0.0, 0.0, 1.0))), [0.6, 0.0, 0.8]);
    }

    #[test]
    fn dot_adds_x_and_y_before_z() {
        // 1e8 - 1e8 + 1 in this order is 1; in another it is 0.
        let sum = v(1e8, -1e8, 1.0).dot(v(1.0, 1.0, 1.0)).to_array()[0];
        assert_eq!(sum, 1.0);
        assert_eq!(v(1.0, 1e8, -1e8).dot(v(1.0, 1.0, 1.0)).to_array()[0], 0.0);
    }
}
