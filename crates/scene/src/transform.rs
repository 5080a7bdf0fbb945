//! Affine transforms in double precision.

use super::{Orientation, SceneError};
use glam::{DMat4, DQuat, DVec3};

/// An affine map from object to world space, kept in `f64` and rounded once where it is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Row-major 3x4: `world = rows * (x, y, z, 1)`.
    rows: [[f64; 4]; 3],
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// From row-major rows: `world = rows * (x, y, z, 1)`.
    ///
    /// # Errors
    /// [`SceneError::NotFinite`].
    pub fn from_rows(rows: [[f64; 4]; 3]) -> Result<Self, SceneError> {
        if rows.iter().flatten().all(|v| v.is_finite()) {
            Ok(Self { rows })
        } else {
            Err(SceneError::NotFinite { what: "transform" })
        }
    }

    /// From a column-major 4x4 matrix as glTF writes it. The last row is taken to be (0, 0, 0, 1).
    ///
    /// # Errors
    /// [`SceneError::NotFinite`].
    pub fn from_columns(m: [f64; 16]) -> Result<Self, SceneError> {
        Self::from_rows(std::array::from_fn(|r| std::array::from_fn(|c| m[4 * c + r])))
    }

    /// Scale, then rotate by a quaternion (x, y, z, w; normalised here), then translate. A zero quaternion is the
    /// identity.
    ///
    /// # Errors
    /// [`SceneError::NotFinite`].
    pub fn from_parts(
        translation: [f64; 3],
        rotation: [f64; 4],
        scale: [f64; 3],
    ) -> Result<Self, SceneError> {
        let q = DQuat::from_array(rotation);
        let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
        let q = if length > 0.0 && length.is_finite() {
            DQuat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length)
        } else {
            DQuat::IDENTITY
        };
        let m = DMat4::from_scale_rotation_translation(DVec3::from(scale), q, DVec3::from(translation));
        Self::from_columns(m.to_cols_array())
    }

    /// Moves by a vector.
    ///
    /// # Errors
    /// [`SceneError::NotFinite`].
    pub fn translation(by: [f64; 3]) -> Result<Self, SceneError> {
        Self::from_parts(by, [0.0, 0.0, 0.0, 1.0], [1.0; 3])
    }

    /// Turns by an angle in radians (magnitude up to 10^6) about an axis through the origin: counter-clockwise for a
    /// viewer who looks against it. The axis may have any length but zero.
    ///
    /// # Errors
    /// [`SceneError::NotFinite`]; [`SceneError::NoLength`] if the axis is zero.
    pub fn rotation(axis: [f64; 3], radians: f64) -> Result<Self, SceneError> {
        if !axis.iter().all(|v| v.is_finite()) {
            return Err(SceneError::NotFinite { what: "rotation axis" });
        }
        if !radians.is_finite() {
            return Err(SceneError::NotFinite { what: "rotation angle" });
        }
        // Relative to the largest component, no square overflows or vanishes.
        let largest = axis.iter().fold(0.0, |most, v| if v.abs() > most { v.abs() } else { most });
        if largest == 0.0 {
            return Err(SceneError::NoLength { what: "rotation axis" });
        }
        let [x, y, z] = axis.map(|v| v / largest);
        let length = (x * x + y * y + z * z).sqrt();
        let (sin, cos) = overcoat_core::math::double::sin_cos(0.5 * radians);
        let [x, y, z] = [x, y, z].map(|v| v / length * sin);
        Self::from_parts([0.0; 3], [x, y, z, cos], [1.0; 3])
    }

    /// Scales lengths by a factor about the origin.
    ///
    /// # Errors
    /// [`SceneError::NotFinite`].
    pub fn scaling(by: f64) -> Result<Self, SceneError> {
        Self::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [by; 3])
    }

    /// `self` after `first`: the map of a child (`first`) in its parent (`self`).
    ///
    /// # Errors
    /// [`SceneError::NotFinite`] if the product overflows.
    pub fn after(&self, first: &Self) -> Result<Self, SceneError> {
        let mut rows = [[0.0; 4]; 3];
        for (r, row) in rows.iter_mut().enumerate() {
            let a = &self.rows[r];
            for (c, out) in row.iter_mut().enumerate() {
                *out = a[0] * first.rows[0][c] + a[1] * first.rows[1][c] + a[2] * first.rows[2][c];
            }
            row[3] += a[3];
        }
        Self::from_rows(rows)
    }

    /// The same map to a world whose zero is elsewhere.
    pub fn less(&self, by: [f64; 3]) -> Self {
        let mut rows = self.rows;
        for (row, by) in rows.iter_mut().zip(by) {
            row[3] -= by;
        }
        Self { rows }
    }

    /// The same map into the scene of a file whose axes lie so.
    pub(super) fn upright(&self, file: Orientation) -> Self {
        let turned: [[f64; 3]; 4] = std::array::from_fn(|c| file.upright(self.rows.map(|row| row[c])));
        Self { rows: std::array::from_fn(|r| turned.map(|column| column[r])) }
    }

    /// Row-major rows: `world = rows * (x, y, z, 1)`.
    #[must_use]
    pub fn rows(&self) -> &[[f64; 4]; 3] {
        &self.rows
    }

    /// Transforms a point.
    #[must_use]
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// Transforms a direction (no translation, not normalised).
    #[must_use]
    pub fn direction(&self, d: [f64; 3]) -> [f64; 3] {
        self.rows.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2])
    }

    /// Determinant of the linear part: negative for mirrored instances.
    #[must_use]
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = &self.rows;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// False if it squeezes every surface to a line or a point.
    #[must_use]
    pub fn keeps_surfaces(&self) -> bool {
        let [a, b, c] = self.rows.map(|r| DVec3::new(r[0], r[1], r[2]));
        let square = |v: DVec3| v.x * v.x + v.y * v.y + v.z * v.z;
        let lengths = square(a) + square(b) + square(c);
        // The areas that the sides of a cube become, against those of a cube that keeps its shape.
        let areas = square(a.cross(b)) + square(b.cross(c)) + square(c.cross(a));
        areas > 1e-20 * lengths * lengths
    }

    /// False if it puts everything at one point.
    #[must_use]
    pub fn keeps_lines(&self) -> bool {
        self.rows.iter().any(|row| row[..3].iter().any(|&v| v != 0.0))
    }

    /// The factor by which a similarity scales lengths: the cube root of the magnitude of the determinant, 1 for
    /// singular maps.
    #[must_use]
    pub fn uniform_scale(&self) -> f64 {
        let determinant = self.determinant().abs();
        if determinant < 1e-300 || !determinant.is_finite() {
            return 1.0;
        }
        // Newton's iteration from a power of eight close by: exact operations only.
        let exponent = (determinant.to_bits() >> 52) as i64 - 1023;
        let mut root = f64::from_bits(((exponent.div_euclid(3) + 1023) as u64) << 52);
        for _ in 0..8 {
            root = (2.0 * root + determinant / (root * root)) / 3.0;
        }
        root
    }

    /// The matrix for normals, row-major: the cofactor matrix (inverse transpose times determinant) with the sign of
    /// the determinant, defined for singular maps too. Keeps lengths where the map scales uniformly.
    #[must_use]
    pub fn normal_matrix(&self) -> [[f32; 3]; 3] {
        let [a, b, c] = self.rows.map(|r| DVec3::new(r[0], r[1], r[2]));
        let sign = if self.determinant() < 0.0 { -1.0 } else { 1.0 };
        let scale = self.uniform_scale();
        let factor = sign / (scale * scale);
        // The rows of the cofactor matrix.
        [b.cross(c), c.cross(a), a.cross(b)].map(|row| row.to_array().map(|v| (v * factor) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_matrix_is_the_inverse_transpose() {
        let t =
            Transform::from_rows([[2.0, 0.0, 0.0, 5.0], [0.0, 4.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
        let n = t.normal_matrix();
        // A plane's normal stays perpendicular to its tangents.
        let tangents = [[1.0, 2.0, 0.0], [0.0, 1.0, 3.0]];
        let normal = [6.0_f32, -3.0, 1.0];
        let moved: [f32; 3] = n.map(|r| r[0] * normal[0] + r[1] * normal[1] + r[2] * normal[2]);
        for tangent in tangents {
            let d = t.direction(tangent);
            let dot: f64 = (0..3).map(|k| d[k] * f64::from(moved[k])).sum();
            assert!(dot.abs() < 1e-5, "{dot}");
        }
    }

    #[test]
    fn rotations_are_counter_clockwise_about_axes_of_any_length() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for length in [1.0, 2.0, 1e300, 1e-300] {
            let turn = Transform::rotation([0.0, length, 0.0], quarter).unwrap();
            let [x, y, z] = turn.point([1.0, 5.0, 0.0]);
            assert!(x.abs() < 1e-15 && y == 5.0 && (z + 1.0).abs() < 1e-15, "{x} {y} {z}");
        }
        assert_eq!(Transform::rotation([0.0; 3], 1.0), Err(SceneError::NoLength { what: "rotation axis" }));
        let not_finite = |what| Err(SceneError::NotFinite { what });
        assert_eq!(Transform::rotation([0.0, f64::NAN, 1.0], 1.0), not_finite("rotation axis"));
        assert_eq!(Transform::rotation([0.0, 1.0, 0.0], f64::INFINITY), not_finite("rotation angle"));
    }

    #[test]
    fn mirroring_keeps_normals_on_the_outside() {
        let t = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [-1.0, 1.0, 1.0]).unwrap();
        assert_eq!(t.normal_matrix(), [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
}
