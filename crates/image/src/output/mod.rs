//! From a [`Frame`] to the bytes of a file.
//!
//! A frame is linear, premultiplied radiance. The way to an 8-bit picture is [`DisplayImage::new`]: un-premultiply,
//! exposure, tone curve, solid background, sRGB, straight alpha. OpenEXR and Radiance files keep the linear light
//! and see none of these. [`encode`] makes the bytes of any format, [`write_atomically`] puts them into place;
//! [`encode_terminal`] makes what shows a picture in a terminal.
//!
//! Bytes of files are reproducible for one release and its `Cargo.lock`: no time stamp, one thread, no float
//! function of the platform.

mod aov;
#[cfg_attr(not(feature = "exr"), path = "without_exr.rs")]
mod exr;
mod hdr;
mod jpeg;
mod movie;
mod palette;
mod png;
mod terminal;
mod webp;
mod write;

pub use aov::encode_aov_png;
pub use exr::encode_exr;
#[cfg(feature = "exr")]
pub use exr::encode_exr_channels;
pub use hdr::encode_hdr;
pub use jpeg::{DEFAULT_JPEG_QUALITY, encode_jpeg};
pub use movie::{MovieFormat, MovieFrame, durations, encode_movie};
use overcoat_core::frame::{DisplayImage, DisplayOptions};
pub use png::{encode_png, encode_png_rgb};
pub use terminal::{TerminalFormat, encode_terminal};
pub use webp::encode_webp;
pub use write::write_atomically;
pub use write::{destination, fill_or_write_atomically};

use overcoat_core::formats::{self, FileFormat};
use overcoat_core::frame::Frame;
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
    /// The same as lossless WebP.
    WebP,
    /// 8 bits a channel, sRGB, with loss and without alpha: over white where there is no background.
    Jpeg,
    /// OpenEXR: linear, premultiplied, with the G-buffer planes as layers.
    Exr,
    /// Radiance RGBE: linear, without alpha.
    Hdr,
}

impl OutputFormat {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Png, Self::WebP, Self::Jpeg, Self::Exr, Self::Hdr];

    /// Name, extensions and media type.
    #[must_use]
    pub fn file_format(self) -> FileFormat {
        match self {
            Self::Png => formats::PNG,
            Self::WebP => formats::WEBP,
            Self::Jpeg => formats::JPEG,
            Self::Exr => formats::EXR,
            Self::Hdr => formats::HDR,
        }
    }

    /// The usual extension of its files, in lower case and without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        self.file_format().extensions.first().copied().unwrap_or_default()
    }

    /// True for linear light; false for pictures of 8 bits, which are for screens.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Exr | Self::Hdr)
    }

    /// The format with this extension, without the dot and in whatever case.
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.file_format().has_extension(extension))
    }

    /// The format that a file's extension names, in whatever case.
    ///
    /// # Errors
    /// [`OutputError::UnknownExtension`].
    pub fn from_path(path: &Path) -> Result<Self, OutputError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        Self::from_extension(extension).ok_or_else(|| OutputError::UnknownExtension { path: path.to_owned() })
    }
}

impl fmt::Display for OutputFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.extension())
    }
}

/// Bits of a colour in an OpenEXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ExrPrecision {
    /// 16-bit floats: 11 bits of precision, up to 65504 (brighter light is written as that).
    #[default]
    Half,
    /// 32-bit floats: the frame's own bits.
    Float,
}

/// Options for writing a frame to a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OutputOptions {
    /// For PNG, WebP and JPEG.
    pub display: DisplayOptions,
    /// For OpenEXR.
    pub exr_precision: ExrPrecision,
    /// For JPEG, 1 to 100.
    pub jpeg_quality: u8,
}

impl Default for OutputOptions {
    fn default() -> Self {
        let (display, exr_precision) = Default::default();
        Self { display, exr_precision, jpeg_quality: DEFAULT_JPEG_QUALITY }
    }
}

impl OutputOptions {
    /// The same with another [`OutputOptions::display`].
    #[must_use]
    pub fn with_display(self, display: DisplayOptions) -> Self {
        Self { display, ..self }
    }

    /// The same with another [`OutputOptions::exr_precision`].
    #[must_use]
    pub fn with_exr_precision(self, exr_precision: ExrPrecision) -> Self {
        Self { exr_precision, ..self }
    }

    /// The same with another [`OutputOptions::jpeg_quality`].
    #[must_use]
    pub fn with_jpeg_quality(self, jpeg_quality: u8) -> Self {
        Self { jpeg_quality, ..self }
    }
}

/// Error of writing a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The extension names no format.
    #[error("{}: unknown format; known extensions are .png, .webp, .jpg, .exr and .hdr", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
    },
    /// The file could not be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The picture does not fit the format (or a plane does not belong to the frame).
    #[error("cannot encode {format}: {reason}")]
    Encode {
        /// The format.
        format: OutputFormat,
        /// Reason, in a few words.
        reason: String,
    },
    /// The picture is none that a terminal could show.
    #[error("cannot encode {format}: {reason}")]
    Terminal {
        /// The format.
        format: TerminalFormat,
        /// Reason, in a few words.
        reason: String,
    },
    /// The frames do not fit the format of moving pictures.
    #[error("cannot encode {format}: {reason}")]
    Movie {
        /// The format.
        format: MovieFormat,
        /// Reason, in a few words.
        reason: String,
    },
}

/// The bytes of a frame's file.
///
/// # Errors
/// [`OutputError::Encode`] if the frame is empty or too large for the format.
pub fn encode(frame: &Frame, format: OutputFormat, options: &OutputOptions) -> Result<Vec<u8>, OutputError> {
    match format {
        OutputFormat::Png | OutputFormat::WebP | OutputFormat::Jpeg => {
            check_size(frame, format)?;
            let mut display = options.display.clone();
            if format == OutputFormat::Jpeg {
                // Here coloured glass tints it, which it cannot any more when the picture is made.
                display.background.get_or_insert([255; 3]);
            }
            encode_image(&DisplayImage::new(frame, &display), format, options)
        }
        OutputFormat::Exr => encode_exr(frame, options.exr_precision),
        OutputFormat::Hdr => encode_hdr(frame),
    }
}

/// The bytes of the file of a picture for a screen.
///
/// # Errors
/// [`OutputError::Encode`] if the picture is empty or too large for the format, or the format is one of linear light.
pub fn encode_image(
    image: &DisplayImage,
    format: OutputFormat,
    options: &OutputOptions,
) -> Result<Vec<u8>, OutputError> {
    match format {
        OutputFormat::Png => encode_png(image),
        OutputFormat::WebP => encode_webp(image),
        OutputFormat::Jpeg => encode_jpeg(image, options.jpeg_quality),
        OutputFormat::Exr | OutputFormat::Hdr => {
            Err(OutputError::Encode { format, reason: "it takes linear light".to_owned() })
        }
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
    match frame.aovs.iter().find(|plane| plane.len() != pixels * plane.aov.channels()) {
        Some(plane) => wrong(format!("{} numbers in plane {}", plane.len(), plane.aov.name())),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_names_the_format() {
        for (name, format) in
            [("a.png", OutputFormat::Png), ("b/c.EXR", OutputFormat::Exr), ("d.JPEG", OutputFormat::Jpeg)]
        {
            assert_eq!(OutputFormat::from_path(Path::new(name)).unwrap(), format);
        }
        for name in ["a", "a.gif", ".png", "png", "a.png/"] {
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
        for &format in OutputFormat::ALL {
            let short = Frame { transmittance: vec![[0.5; 3]; 3], ..frame(2, 2, 4) };
            for bad in [frame(0, 4, 0), frame(4, 0, 0), frame(2, 2, 3), short] {
                assert!(encode(&bad, format, &OutputOptions::default()).is_err(), "{format}");
            }
            assert!(encode(&frame(1, 1, 1), format, &OutputOptions::default()).is_ok(), "{format}");
        }
    }
}
