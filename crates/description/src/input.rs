//! Standard input in the place of a file.

use super::error::DescriptionError;
use overcoat_core::files::read_stream;
use overcoat_core::limits::Limits;
use overcoat_load::LoadError;
use std::path::Path;

/// A path that stands for standard input. What comes from there has no folder, whatever it is.
#[must_use]
pub fn is_standard_input(path: &Path) -> bool {
    let names = ["/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"];
    is_standard_stream(path) || (cfg!(unix) && names.iter().any(|name| path == Path::new(name)))
}

/// A path that stands for standard input or output.
#[must_use]
pub fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// All of standard input, at most [`Limits::input_bytes`] of it.
///
/// # Errors
/// [`DescriptionError`] if it has more, has nothing or cannot be read.
pub fn read_standard_input(limits: &Limits) -> Result<Vec<u8>, DescriptionError> {
    let bytes = read_stream(std::io::stdin().lock(), limits).map_err(LoadError::from)?;
    if bytes.is_empty() {
        return Err(DescriptionError::invalid("no data"));
    }
    Ok(bytes)
}
