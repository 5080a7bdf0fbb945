//! Outputs of moving pictures: one file, written after all work, or a picture each frame, written as it is made.
//! Checked before any work.

use super::args::EncodingArgs;
use super::failure::Failure;
use super::names::numbered;
use super::output_file::{
    Encoded, check_file, check_quality, check_standard_output, file_format, output_failure, remove,
};
use super::render_task::RenderTask;
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_core::limits::Limits;
use overcoat_description::is_standard_stream;
use overcoat_image::output::{
    DEFAULT_JPEG_QUALITY, MovieFormat, MovieFrame, OutputError, OutputFormat, OutputOptions, durations,
    encode_image, encode_movie,
};
use overcoat_worker::picture_format::PictureFormat;
use overcoat_worker::picture_task::Pixels;
use std::path::{Path, PathBuf};

/// A place for frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct MovieOutput {
    path: PathBuf,
    /// `None`: numbered pictures.
    format: Option<MovieFormat>,
    /// Format of numbered pictures.
    picture: OutputFormat,
    /// JPEG quality.
    quality: u8,
}

impl MovieOutput {
    /// Checks that a moving picture could be written to `path` (`-`: standard output, unless a report goes there).
    ///
    /// # Errors
    /// [`Failure`] naming the path.
    pub(super) fn new(
        path: &Path,
        encoding: &EncodingArgs,
        inputs: &[PathBuf],
        json: bool,
    ) -> Result<Self, Failure> {
        let quality = encoding.jpeg_quality.unwrap_or(DEFAULT_JPEG_QUALITY);
        let target = |format, picture| Self { path: path.to_owned(), format, picture, quality };
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let standard_output = is_standard_stream(path);
        let numbered =
            !standard_output && path.file_name().is_some_and(|name| name.as_encoded_bytes().contains(&b'#'));
        let unknown = |known: &str| Failure::usage(format!("unknown format; known are {known}")).at(path);
        let known = ".gif, .png and .apng (animated PNG), .webp, and .png, .webp or .jpg with # in its name";
        if MovieFormat::from_extension(extension) == Some(MovieFormat::Gif) && !standard_output {
            if numbered {
                return Err(unknown(known));
            }
            if let Some(asked) = encoding.output_format {
                let message = format!("the name says GIF, --output-format says {asked}");
                return Err(Failure::usage(message).at(path));
            }
            check_quality(encoding.jpeg_quality, PictureFormat::File(OutputFormat::Png))?;
            let target = target(Some(MovieFormat::Gif), OutputFormat::Png);
            return target.check(1, inputs).map(|()| target);
        }
        // A name ending in .apng says PNG as well.
        let named = match MovieFormat::from_extension(extension) {
            Some(MovieFormat::Apng) if !numbered => path.with_extension("png"),
            _ => path.to_owned(),
        };
        let picture = match encoding.output_format {
            None if !standard_output && OutputFormat::from_path(&named).is_err() => {
                return Err(unknown(known));
            }
            asked => file_format(&named, asked)?,
        };
        check_quality(encoding.jpeg_quality, PictureFormat::File(picture))?;
        let target = match picture {
            picture if picture.is_linear() => return Err(unknown(known)),
            picture if numbered => target(None, picture),
            OutputFormat::WebP => target(Some(MovieFormat::WebP), picture),
            OutputFormat::Png => target(Some(MovieFormat::Apng), picture),
            _ => {
                let message = "JPEG does not move; put # into the name for a numbered picture each frame";
                return Err(Failure::usage(message).at(path));
            }
        };
        if standard_output {
            check_standard_output(json, false)?;
        } else {
            target.check(1, inputs)?;
        }
        Ok(target)
    }

    /// Puts white behind the pictures of a task where the format cannot show what is half there.
    pub(super) fn put_behind(&self, task: &mut RenderTask) {
        match self.format {
            Some(MovieFormat::Gif) => task.put_behind("GIF has no translucent pixels"),
            _ => task.behind_for(self.picture),
        }
    }

    /// True if all frames are in one file.
    pub(super) fn is_one_file(&self) -> bool {
        self.format.is_some()
    }

    /// The file of one numbered picture.
    fn encode(&self, image: &DisplayImage) -> Result<Vec<u8>, OutputError> {
        let options = OutputOptions::default().with_jpeg_quality(self.quality);
        encode_image(image, self.picture, &options)
    }

    /// The file of frame `k`.
    fn numbered(&self, k: usize) -> PathBuf {
        self.path.with_file_name(numbered(self.path.file_name().unwrap_or_default(), k))
    }

    /// Checks that so many frames could be written.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub(super) fn check(&self, frames: usize, inputs: &[PathBuf]) -> Result<(), Failure> {
        if is_standard_stream(&self.path) {
            return Ok(());
        }
        match self.format {
            Some(_) => check_file(&self.path, inputs),
            None => (0..frames).try_for_each(|k| check_file(&self.numbered(k), inputs)),
        }
    }
}

/// Frames on their way to a [`MovieOutput`], encoded. Numbered pictures that are written already are removed again unless
/// it comes to its end.
pub(super) struct MovieWriter {
    target: MovieOutput,
    display: DisplayOptions,
    limits: Limits,
    frames: Vec<MovieFrame>,
    written: Vec<PathBuf>,
    bytes: u64,
    hashes: String,
}

impl MovieWriter {
    /// No frames yet.
    pub(super) fn new(target: MovieOutput, display: DisplayOptions, limits: Limits) -> Self {
        let (frames, written) = (Vec::new(), Vec::new());
        Self { target, display, limits, frames, written, bytes: 0, hashes: String::new() }
    }

    /// Bytes of the frames so far.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Forgets the frames so far.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        self.hashes.clear();
        self.bytes = 0;
    }

    /// Frames become 8 bits like this from now on.
    pub(super) fn show_as(&mut self, display: DisplayOptions) {
        self.display = display;
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be encoded or written, or if all frames take more bytes than the limits allow.
    pub(super) fn push(&mut self, pixels: &Pixels) -> Result<(), Failure> {
        let failed = |error| output_failure(&error, &self.target.path);
        let developed;
        let image = match pixels {
            Pixels::Image(image) => image,
            Pixels::Frame(frame) => {
                self.hashes.push_str(&frame.frame_hash());
                developed = DisplayImage::new(frame, &self.display);
                &developed
            }
        };
        let Some(format) = self.target.format else {
            let path = self.target.numbered(self.written.len());
            let encoded = Encoded::new(path.clone(), self.target.encode(image).map_err(failed)?);
            self.bytes += encoded.size();
            self.check_bytes(self.written.len())?;
            encoded.write()?;
            self.written.push(path);
            return Ok(());
        };
        // A colour behind everything leaves no transparency.
        let alpha = self.display.background.is_none();
        let frame = MovieFrame::new(image, format, alpha).map_err(failed)?;
        self.bytes += frame.size() as u64;
        self.frames.push(frame);
        self.check_bytes(self.frames.len() - 1)
    }

    /// Checks what all frames up to `k` take.
    fn check_bytes(&self, k: usize) -> Result<(), Failure> {
        let what = || format!("frames up to {k}");
        Limits::check(what, self.bytes, self.limits.decoded_bytes, "decoded_bytes")
            .map_err(|e| Failure::limit(&e))
    }

    /// Writes what is not written yet. Returns the bytes of all files, and the hash of all frames of linear light: XXH3-128
    /// of their hashes, equal on every machine.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be encoded or written.
    pub(super) fn finish(mut self, frames_a_second: f64) -> Result<(u64, String), Failure> {
        let hash = format!("{:032x}", xxhash_rust::xxh3::xxh3_128(self.hashes.as_bytes()));
        let path = &self.target.path;
        if self.target.format.is_none() {
            self.written.clear();
            return Ok((self.bytes, hash));
        }
        let times = durations(self.frames.len(), frames_a_second);
        let bytes = encode_movie(&self.frames, &times).map_err(|e| output_failure(&e, path))?;
        let encoded = Encoded::new(path.clone(), bytes);
        encoded.write()?;
        Ok((encoded.size(), hash))
    }
}

impl Drop for MovieWriter {
    fn drop(&mut self) {
        self.written.iter().for_each(|path| remove(path));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_tells_the_format() {
        let target = |name: &str, asked| {
            let encoding = EncodingArgs { output_format: asked, jpeg_quality: None };
            MovieOutput::new(Path::new(name), &encoding, &[], false)
        };
        let format = |name: &str| target(name, None).map(|target| (target.format, target.picture));
        let (png, webp) = (OutputFormat::Png, OutputFormat::WebP);
        assert_eq!(format("a.png"), Ok((Some(MovieFormat::Apng), png)));
        assert_eq!(format("a.APNG"), Ok((Some(MovieFormat::Apng), png)));
        assert_eq!(format("a.webp"), Ok((Some(MovieFormat::WebP), webp)));
        assert_eq!(format("a.GIF"), Ok((Some(MovieFormat::Gif), png)));
        assert_eq!(format("a-###.png"), Ok((None, png)));
        assert_eq!(format("a-###.webp"), Ok((None, webp)));
        assert_eq!(format("a-###.jpeg"), Ok((None, OutputFormat::Jpeg)));
        assert_eq!(target("a", Some(webp)).unwrap().format, Some(MovieFormat::WebP));
        for bad in ["a", "a-#.gif", "a.jpg", "a.exr", "a-##.exr", "#"] {
            assert_eq!(format(bad).unwrap_err().exit_code(), 2, "{bad}");
        }
        assert_eq!(target("a.webp", Some(png)).unwrap_err().exit_code(), 2);
        assert_eq!(target("a.gif", Some(png)).unwrap_err().exit_code(), 2);
        assert_eq!(format("no-such-folder/a.png").unwrap_err().exit_code(), 1);
    }

    #[test]
    fn pictures_are_numbered_from_0_in_their_folder() {
        let path = |name: &str, k| {
            MovieOutput { path: name.into(), format: None, picture: OutputFormat::Png, quality: 90 }
                .numbered(k)
        };
        assert_eq!(
            [path("f/a-##.png", 0), path("f/a-##.png", 1)],
            ["f/a-00.png", "f/a-01.png"].map(PathBuf::from)
        );
    }
}
