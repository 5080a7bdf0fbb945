//! What a scene refuses.

/// Why something cannot be part of a scene.
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

/// True if all numbers pass; without an early exit within a block, so that it is compiled to vectors.
fn all(values: &[f32], passes: impl Fn(f32) -> bool) -> bool {
    values.chunks(1024).all(|block| block.iter().fold(true, |all, &v| all & passes(v)))
}
