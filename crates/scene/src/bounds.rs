//! Boxes in double precision.

use super::Transform;

/// An axis-aligned box in double precision; empty where `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: [f64; 3],
    /// Largest corner.
    pub max: [f64; 3],
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// True if it contains nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }

    /// True if a point is within, or on a side.
    #[must_use]
    pub(crate) fn contains(&self, p: [f64; 3]) -> bool {
        (0..3).all(|k| self.min[k] <= p[k] && p[k] <= self.max[k])
    }

    /// Grows to contain a point.
    pub fn include(&mut self, p: [f32; 3]) {
        for k in 0..3 {
            let v = f64::from(p[k]);
            if v < self.min[k] {
                self.min[k] = v;
            }
            if v > self.max[k] {
                self.max[k] = v;
            }
        }
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let mut out = *self;
        for k in 0..3 {
            if other.min[k] < out.min[k] {
                out.min[k] = other.min[k];
            }
            if other.max[k] > out.max[k] {
                out.max[k] = other.max[k];
            }
        }
        out
    }

    /// The box around the eight transformed corners.
    #[must_use]
    pub fn transformed(&self, transform: &Transform) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let mut out = Self::EMPTY;
        for corner in 0..8 {
            let p = transform
                .point(std::array::from_fn(|k| if corner >> k & 1 == 1 { self.max[k] } else { self.min[k] }));
            out = out.union(&Self { min: p, max: p });
        }
        out
    }

    /// True if every coordinate's magnitude is at most `limit`.
    #[must_use]
    pub fn within(&self, limit: f64) -> bool {
        self.min.iter().chain(&self.max).all(|v| v.abs() <= limit)
    }

    /// Midpoint.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// Edge lengths.
    #[must_use]
    pub fn size(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.max[k] - self.min[k])
    }
}
