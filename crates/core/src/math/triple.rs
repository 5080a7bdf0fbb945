//! Three numbers as a vector, one at a time: where there are no sixteen of them (`vec3.rs`). The order of sums is that of
//! [`Vec3`](super::vec3::Vec3).

/// The dot product.
#[inline(always)]
#[must_use]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// `a - b`.
#[inline(always)]
#[must_use]
pub fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
