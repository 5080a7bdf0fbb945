//! Reasons why a file is no measured BRDF.

/// Reason why a file cannot be read as a measured BRDF.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// First bytes of neither format.
    #[error(
        "neither a MERL file, which begins with three dimensions as 32-bit integers, nor a tensor file of the RGL, which \
         begins with 'tensor_file'"
    )]
    Unknown,
    /// Dimensions of a MERL file that do not fit its length.
    #[error("dimensions {}: {} bytes in three planes, and the file has {length}", list(dimensions), expected)]
    Length {
        /// Dimensions: half angles, difference angles, difference azimuths.
        dimensions: Vec<u64>,
        /// Bytes that a file of these dimensions has.
        expected: u64,
        /// Bytes of the file.
        length: u64,
    },
    /// End of the file where more was expected.
    #[error("{what} is cut short: it ends at byte {end}, and the file has {length}")]
    Cut {
        /// Element of the file.
        what: String,
        /// First byte after it.
        end: u64,
        /// Bytes of the file.
        length: u64,
    },
    /// Version of a tensor file that is not read.
    #[error("version {}.{} of a tensor file; 1.0 is read", found[0], found[1])]
    Version {
        /// Major and minor number.
        found: [u8; 2],
    },
    /// Count beyond what is read.
    #[error("{what}: {found}, at most {limit}")]
    TooMany {
        /// Element of the file.
        what: String,
        /// Count found.
        found: u64,
        /// Largest count.
        limit: u64,
    },
    /// Field that has to be there.
    #[error("field '{field}' is missing")]
    Missing {
        /// Name of the field.
        field: &'static str,
    },
    /// Field that is there twice.
    #[error("field '{field}' is there twice")]
    Twice {
        /// Name of the field.
        field: String,
    },
    /// Spectra in place of red, green and blue.
    #[error("it has spectra ('spectra'): the file of the same material whose name ends in _rgb.bsdf is read")]
    Spectral,
    /// Type of a field.
    #[error("field '{field}' has type {found}, expected {expected}")]
    Type {
        /// Name of the field.
        field: &'static str,
        /// Number of the type found.
        found: u8,
        /// Number and name of the type that is read.
        expected: &'static str,
    },
    /// Shape of a field.
    #[error("field '{field}' has shape {}, expected {expected}", list(found))]
    Shape {
        /// Name of the field.
        field: &'static str,
        /// Lengths along each dimension.
        found: Vec<u64>,
        /// Shape that is read.
        expected: String,
    },
    /// Number out of range.
    #[error("{what}, number {index}: {value}, expected {expected}")]
    Number {
        /// Field or plane.
        what: &'static str,
        /// Index of the number within it.
        index: u64,
        /// Value found.
        value: f64,
        /// Range that is read.
        expected: &'static str,
    },
}

/// Lengths along dimensions.
fn list(shape: &[u64]) -> String {
    let lengths: Vec<String> = shape.iter().map(ToString::to_string).collect();
    if lengths.is_empty() { "of a single number".to_owned() } else { lengths.join(" x ") }
}
