//! Moving pictures: animated PNG, lossless animated WebP, and GIF.
//!
//! Frames are encoded one by one, each as the still picture that it is, and put into one container in the end.

mod apng;
mod gif;
mod webp;

use super::{DisplayImage, OutputError};
use overcoat_core::formats::{self, FileFormat};
use std::fmt;

/// A format of moving pictures. All but GIF keep every bit of every frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MovieFormat {
    /// Animated PNG: what does not know it shows the first frame.
    Apng,
    /// Lossless WebP.
    WebP,
    /// GIF: what every chat, tracker and mail shows, at the price of 256 colours a frame. What is translucent lies over white.
    Gif,
}

impl MovieFormat {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Apng, Self::WebP, Self::Gif];

    /// Name, extensions and media type.
    #[must_use]
    pub fn file_format(self) -> FileFormat {
        match self {
            Self::Apng => formats::APNG,
            Self::WebP => formats::WEBP,
            Self::Gif => formats::GIF,
        }
    }

    /// The format that a file's extension names, in whatever case.
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.file_format().has_extension(extension))
    }
}

impl fmt::Display for MovieFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Apng => "APNG",
            Self::WebP => "WebP",
            Self::Gif => "GIF",
        })
    }
}

/// A frame of a moving picture, encoded.
#[derive(Clone, Debug)]
pub struct MovieFrame {
    format: MovieFormat,
    width: u32,
    height: u32,
    /// A PNG file, the content of a VP8L chunk, or the image block of a GIF.
    bytes: Vec<u8>,
}

impl MovieFrame {
    /// Encodes a frame. All frames of one moving picture have the same size and either all an alpha channel or all none,
    /// in which case their alpha is left out.
    ///
    /// # Errors
    /// [`OutputError::Movie`] if the picture is empty or too large for the format.
    pub fn new(image: &DisplayImage, format: MovieFormat, alpha: bool) -> Result<Self, OutputError> {
        let bytes = match format {
            MovieFormat::Apng => apng::encode_frame(image, alpha)?,
            MovieFormat::WebP => webp::encode_frame(image, alpha)?,
            MovieFormat::Gif => gif::encode_frame(image)?,
        };
        Ok(Self { format, width: image.width, height: image.height, bytes })
    }

    /// Bytes that it takes.
    #[must_use]
    pub fn size(&self) -> usize {
        self.bytes.len()
    }
}

/// The bytes of a moving picture that begins again and again. Each frame is shown for the given number of milliseconds.
///
/// # Errors
/// [`OutputError::Movie`] if there are no frames, if they differ in size or format, if there is not one duration for each, or
/// if they are too long for the format.
pub fn encode_movie(frames: &[MovieFrame], milliseconds: &[u16]) -> Result<Vec<u8>, OutputError> {
    let Some(first) = frames.first() else {
        return Err(OutputError::Movie { format: MovieFormat::Apng, reason: "no frames".to_owned() });
    };
    let format = first.format;
    let alike =
        |frame: &MovieFrame| (frame.format, frame.width, frame.height) == (format, first.width, first.height);
    if !frames.iter().all(alike) || frames.len() != milliseconds.len() {
        return Err(OutputError::Movie { format, reason: "its frames do not belong together".to_owned() });
    }
    match format {
        MovieFormat::Apng => apng::assemble(frames, milliseconds),
        MovieFormat::WebP => webp::assemble(frames, milliseconds),
        MovieFormat::Gif => gif::assemble(frames, milliseconds),
    }
}

/// Durations in whole milliseconds of frames that come so many a second: each ends at the millisecond nearest to its end, so
/// that rounding does not add up.
#[must_use]
pub fn durations(frames: usize, per_second: f64) -> Vec<u16> {
    let end = |k: usize| (k as f64 * 1000.0 / per_second + 0.5).floor();
    (0..frames).map(|k| (end(k + 1) - end(k)).clamp(1.0, 65535.0) as u16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// Frames of every colour and alpha.
    fn picture(seed: u32, opaque: bool) -> DisplayImage {
        let pixel = |k: u32| {
            let v = k.wrapping_mul(2_654_435_761).wrapping_add(seed) >> 8;
            let a = if opaque { 255 } else { (v >> 3) as u8 };
            if a == 0 { [0; 4] } else { [v as u8, (k / 31) as u8, (seed * 50) as u8, a] }
        };
        DisplayImage { width: 31, height: 17, pixels: (0..31 * 17).map(pixel).collect() }
    }

    fn movie(format: MovieFormat, alpha: bool) -> (Vec<DisplayImage>, Vec<u8>) {
        let pictures: Vec<DisplayImage> = (0..4).map(|k| picture(k, !alpha)).collect();
        let frames: Vec<MovieFrame> =
            pictures.iter().map(|p| MovieFrame::new(p, format, alpha).unwrap()).collect();
        (pictures, encode_movie(&frames, &[40, 41, 42, 1000]).unwrap())
    }

    /// Frames that another decoder finds in the files, and their delays.
    fn decoded<'a>(decoder: impl image::AnimationDecoder<'a>) -> Vec<(Vec<u8>, (u32, u32))> {
        let frames = decoder.into_frames().collect_frames().unwrap();
        let one = |f: &image::Frame| (f.buffer().as_raw().clone(), f.delay().numer_denom_ms());
        frames.iter().map(one).collect()
    }

    #[test]
    fn every_bit_of_every_frame_survives() {
        for alpha in [true, false] {
            let (pictures, apng) = movie(MovieFormat::Apng, alpha);
            let png = image::codecs::png::PngDecoder::new(Cursor::new(&apng)).unwrap();
            let from_apng = decoded(png.apng().unwrap());
            let (_, file) = movie(MovieFormat::WebP, alpha);
            let from_webp = decoded(image::codecs::webp::WebPDecoder::new(Cursor::new(&file)).unwrap());
            for (name, found) in [("APNG", from_apng), ("WebP", from_webp)] {
                assert_eq!(found.len(), 4, "{name}");
                for ((picture, (pixels, delay)), ms) in pictures.iter().zip(&found).zip([40, 41, 42, 1000]) {
                    assert_eq!(f64::from(delay.0) / f64::from(delay.1), f64::from(ms), "{name}");
                    let expected = picture.pixels.as_flattened();
                    assert!(pixels == expected, "{name} {alpha}");
                }
            }
        }
    }

    /// Programs that know no animation show the first frame.
    #[test]
    fn an_animated_png_is_a_png() {
        let (pictures, apng) = movie(MovieFormat::Apng, true);
        let still = image::load_from_memory_with_format(&apng, image::ImageFormat::Png).unwrap().to_rgba8();
        assert!(still.as_raw() == pictures[0].pixels.as_flattened());
    }

    #[test]
    fn frames_that_do_not_belong_together_are_refused() {
        let frame = MovieFrame::new(&picture(1, true), MovieFormat::WebP, true).unwrap();
        let mut other = frame.clone();
        other.width += 1;
        for (frames, times) in
            [(vec![], vec![]), (vec![frame.clone()], vec![]), (vec![frame.clone(), other], vec![1, 1])]
        {
            encode_movie(&frames, &times).unwrap_err();
        }
        let empty = DisplayImage { width: 0, height: 3, pixels: Vec::new() };
        for &format in MovieFormat::ALL {
            MovieFrame::new(&empty, format, true).unwrap_err();
        }
    }

    #[test]
    fn durations_do_not_drift() {
        assert_eq!(durations(4, 25.0), [40; 4]);
        let film = durations(24 * 60, 24.0);
        assert!(film.iter().all(|&ms| ms == 41 || ms == 42));
        assert_eq!(film.iter().map(|&ms| u64::from(ms)).sum::<u64>(), 60_000);
        assert_eq!(durations(2, 1e-9), [65535; 2]);
    }
}
