//! Errors of building a scene.

/// Reason why something cannot be part of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A number is NaN or infinite.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// The quantity.
        what: &'static str,
    },
    /// A number lies outside the range that its documentation gives.
    #[error("{what} is out of range (limit {limit})")]
    OutOfRange {
        /// The quantity.
        what: &'static str,
        /// The bound that it violates.
        limit: f32,
    },
    /// A direction or an axis is zero.
    #[error("{what} has no length")]
    NoLength {
        /// The vector.
        what: &'static str,
    },
    /// An attribute has another length than the positions.
    #[error("{what} has {len} elements for {vertices} vertices")]
    LengthMismatch {
        /// The attribute.
        what: &'static str,
        /// Its length.
        len: usize,
        /// The number of positions.
        vertices: usize,
    },
    /// There is not one of something for each triangle.
    #[error("{what} has {len} elements for {triangles} triangles")]
    FaceMismatch {
        /// The attribute.
        what: &'static str,
        /// Its length.
        len: usize,
        /// The number of triangles.
        triangles: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex} of {vertices}")]
    IndexOutOfRange {
        /// The triangle's number.
        triangle: usize,
        /// The vertex it refers to.
        vertex: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// An id does not name an element of this scene.
    #[error("there is no {what} {index}")]
    NoSuch {
        /// Kind of element.
        what: &'static str,
        /// The id.
        index: u32,
    },
    /// An image's data does not fit its size, or a side is zero.
    #[error("image of {width} x {height} pixels cannot have {len} bytes")]
    ImageSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Bytes given.
        len: usize,
    },
    /// More elements than ids.
    #[error("too many {what}")]
    TooMany {
        /// Kind of element.
        what: &'static str,
    },
    /// Camera directions that do not span a view.
    #[error("the camera's view direction and up vector do not span a view")]
    DegenerateCamera,
    /// Intrinsics that no camera has.
    #[error("camera intrinsics: {name} is {value}, expected {expected}")]
    Intrinsics {
        /// The number: `fx`, `cy`, an element of K.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        expected: String,
    },
    /// Intrinsics of a picture of another shape.
    #[error(
        "camera intrinsics are those of a picture of {} x {} pixels, and one of {} x {} has another shape",
        .of[0], .of[1], .picture[0], .picture[1]
    )]
    IntrinsicsSize {
        /// Width and height that the intrinsics are for.
        of: [u32; 2],
        /// Width and height of the picture.
        picture: [u32; 2],
    },
    /// A matrix that is not the pose of a camera.
    #[error("camera pose: {reason}")]
    Pose {
        /// The element or the deformation, with what was expected.
        reason: String,
    },
}

/// `Ok` if every number is finite.
pub(crate) fn finite(what: &'static str, values: &[f32]) -> Result<(), SceneError> {
    if all(values, f32::is_finite) { Ok(()) } else { Err(SceneError::NotFinite { what }) }
}

/// `Ok` if every number lies within the range.
pub(crate) fn within(what: &'static str, values: &[f32], low: f32, high: f32) -> Result<(), SceneError> {
    // No NaN and no infinity is.
    if all(values, |v| low <= v && v <= high) {
        return Ok(());
    }
    finite(what, values)?;
    let limit = values.iter().find_map(|&v| {
        if v < low {
            Some(low)
        } else if v > high {
            Some(high)
        } else {
            None
        }
    });
    limit.map_or(Ok(()), |limit| Err(SceneError::OutOfRange { what, limit }))
}

/// The vector at unit length, rounded once. One that is as good as of that length stays as it is, bit for bit: who has
/// normalised it already gets it back.
///
/// # Errors
/// [`SceneError::NotFinite`], and [`SceneError::NoLength`] of zero.
pub(crate) fn unit(what: &'static str, v: [f32; 3]) -> Result<[f32; 3], SceneError> {
    finite(what, &v)?;
    // In double precision no square of a single one overflows or vanishes.
    let wide = v.map(f64::from);
    let square = wide[0] * wide[0] + wide[1] * wide[1] + wide[2] * wide[2];
    if square == 0.0 {
        return Err(SceneError::NoLength { what });
    }
    if (0.99..=1.01).contains(&square) {
        return Ok(v);
    }
    let length = square.sqrt();
    Ok(wide.map(|c| (c / length) as f32))
}

/// True if all numbers pass; without an early exit within a block, so that it is compiled to vectors.
fn all(values: &[f32], passes: impl Fn(f32) -> bool) -> bool {
    values.chunks(1024).all(|block| block.iter().fold(true, |all, &v| all & passes(v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_become_units() {
        let tiny = f32::from_bits(1);
        for (given, expected) in [
            ([0.0, -2.0, 0.0], [0.0, -1.0, 0.0]),
            ([3.0, 0.0, 4.0], [0.6, 0.0, 0.8]),
            ([0.0, f32::MAX, 0.0], [0.0, 1.0, 0.0]),
            ([0.0, 0.0, -tiny], [0.0, 0.0, -1.0]),
            // As good as of unit length: not a bit changes.
            ([0.6, 0.8001, 0.0], [0.6, 0.8001, 0.0]),
        ] {
            assert_eq!(unit("axis", given), Ok(expected));
        }
        assert_eq!(unit("axis", [0.0, -0.0, 0.0]), Err(SceneError::NoLength { what: "axis" }));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(unit("axis", [0.0, bad, 1.0]), Err(SceneError::NotFinite { what: "axis" }));
        }
    }
}
