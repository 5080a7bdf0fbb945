//! From a [`Frame`] to the bytes of a file.
//!
//! A frame is linear, premultiplied radiance. The way to an 8-bit picture is [`DisplayImage::new`]: un-premultiply,
//! exposure, tone curve, solid background, sRGB, straight alpha. OpenEXR and Radiance files keep the linear light
//! and see none of these. [`encode`] makes the bytes of any format, [`write_atomically`] puts them into place.
//!
//! Bytes of files are reproducible for one release and its `Cargo.lock`: no time stamp, one thread, no float
//! function of the platform.

mod aov;
mod exr;
mod hdr;
mod movie;
mod png;
mod write;

pub use crate::frame::{DisplayImage, DisplayOptions};
pub use aov::encode_aov_png;
pub use exr::{ExrPrecision, encode_exr};
pub use hdr::encode_hdr;
pub use movie::{MovieFormat, MovieFrame, durations, encode_movie};
pub use png::{encode_png, encode_png_rgb};
pub use write::write_atomically;

use crate::frame::Frame;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A format of picture files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum OutputFormat {
    /// 8 bits a channel, sRGB, straight alpha.
    #[default]
    Png,
    /// OpenEXR: linear, premultiplied, with the G-buffer planes as layers.
    Exr,
    /// Radiance RGBE: linear, without alpha.
    Hdr,
}

impl OutputFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Png, Self::Exr, Self::Hdr];

    /// The extension of its files, in lower case and without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Hdr => "hdr",
        }
    }

    /// The format that a file's extension names, in whatever case.
    ///
    /// # Errors
    /// [`OutputError::UnknownExtension`].
    pub fn from_path(path: &Path) -> Result<Self, OutputError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        Self::ALL
            .into_iter()
            .find(|format| format.extension() == extension)
            .ok_or_else(|| OutputError::UnknownExtension { path: path.to_owned() })
    }
}

impl fmt::Display for OutputFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.extension())
    }
}

/// How a frame becomes a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputOptions {
    /// For PNG.
    pub display: DisplayOptions,
    /// For OpenEXR.
    pub exr_precision: ExrPrecision,
}

/// Why there is no file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The extension names no format.
    #[error("{}: unknown format; known extensions are .png, .exr and .hdr", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
    },
    /// The file could not be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The picture does not fit the format (or a plane does not belong to the frame).
    #[error("cannot encode {format}: {reason}")]
    Encode {
        /// The format.
        format: OutputFormat,
        /// What is wrong.
        reason: String,
    },
    /// The frames do not fit the format of moving pictures.
    #[error("cannot encode {format}: {reason}")]
    Movie {
        /// The format.
        format: MovieFormat,
        /// What is wrong.
        reason: String,
    },
}

/// The bytes of a frame's file.
///
/// # Errors
/// [`OutputError::Encode`] if the frame is empty or too large for the format.
pub fn encode(frame: &Frame, format: OutputFormat, options: &OutputOptions) -> Result<Vec<u8>, OutputError> {
    match format {
        OutputFormat::Png => {
            check_size(frame, format)?;
            encode_png(&DisplayImage::new(frame, &options.display))
        }
        OutputFormat::Exr => encode_exr(frame, options.exr_precision),
        OutputFormat::Hdr => encode_hdr(frame),
    }
}

/// [`OutputError::Encode`] if a frame's data do not fit its size. Frames from the renderer always pass.
fn check_size(frame: &Frame, format: OutputFormat) -> Result<(), OutputError> {
    let pixels = frame.width as usize * frame.height as usize;
    let wrong = |reason: String| Err(OutputError::Encode { format, reason });
    if pixels == 0 {
        return wrong(format!("a picture of {} x {} pixels", frame.width, frame.height));
    }
    if frame.pixels.len() != pixels {
        return wrong(format!(
            "{} pixels for a picture of {} x {}",
            frame.pixels.len(),
            frame.width,
            frame.height
        ));
    }
    if !frame.transmittance.is_empty() && frame.transmittance.len() != pixels {
        return wrong(format!(
            "transmittance of {} pixels in a picture of {pixels}",
            frame.transmittance.len()
        ));
    }
    match frame.aovs.iter().find(|plane| plane.data.len() != pixels * plane.aov.channels()) {
        Some(plane) => wrong(format!("{} numbers in plane {}", plane.data.len(), plane.aov.name())),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_names_the_format() {
        for (name, format) in [("a.png", OutputFormat::Png), ("b/c.EXR", OutputFormat::Exr)] {
            assert_eq!(OutputFormat::from_path(Path::new(name)).unwrap(), format);
        }
        for name in ["a", "a.jpg", ".png", "png", "a.png/"] {
            let result = OutputFormat::from_path(Path::new(name));
            if name == "a.png/" {
                // A trailing separator does not count as a component; writing to it fails later.
                assert!(result.is_ok());
                continue;
            }
            let message = result.unwrap_err().to_string();
            assert!(message.starts_with(name) && message.contains(".exr"), "{message}");
        }
    }

    #[test]
    fn frames_that_do_not_fit_their_size_are_refused() {
        let frame = |width, height, len| Frame {
            width,
            height,
            pixels: vec![[0.0; 4]; len],
            transmittance: Vec::new(),
            aovs: Vec::new(),
        };
        for format in OutputFormat::ALL {
            let short = Frame { transmittance: vec![[0.5; 3]; 3], ..frame(2, 2, 4) };
            for bad in [frame(0, 4, 0), frame(4, 0, 0), frame(2, 2, 3), short] {
                assert!(encode(&bad, format, &OutputOptions::default()).is_err(), "{format}");
            }
            assert!(encode(&frame(1, 1, 1), format, &OutputOptions::default()).is_ok(), "{format}");
        }
    }
}
