//! Output file of a picture: checked before any work, written after all of it.

use super::args::PictureEncodingArgs;
use super::default_output;
use super::failure::Failure;
use overcoat_core::frame::Aov;
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_description::is_standard_stream;
use overcoat_image::output::{
    DEFAULT_JPEG_QUALITY, OutputError, OutputFormat, OutputOptions, destination, encode, encode_aov_png,
    encode_image, encode_terminal, fill_or_write_atomically, write_atomically,
};
use overcoat_worker::codes;
use overcoat_worker::picture_format::PictureFormat;
use overcoat_worker::picture_task::Pixels;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// A place for a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    path: PathBuf,
    format: PictureFormat,
    /// JPEG quality.
    quality: u8,
    /// Planes that go to files of their own.
    planes: Vec<(Aov, PathBuf)>,
    /// A file that is there and empty gets its content in place.
    fills_empty: bool,
    /// The picture says that nobody has named it.
    is_marked: bool,
}

impl OutputFile {
    /// Checks that a picture could be written to `path` (`-`: standard output).
    ///
    /// # Errors
    /// [`Failure`] naming the path if its format is unknown, its folder does not exist, it is a folder, or it is one
    /// of `inputs`; also if it is standard output, to which a report (`json`) goes or which is a terminal that cannot show
    /// the format, or its name contradicts the format.
    pub fn new(
        path: &Path,
        encoding: &PictureEncodingArgs,
        aovs: &[Aov],
        inputs: &[PathBuf],
        json: bool,
    ) -> Result<Self, Failure> {
        let standard_output = is_standard_output(path);
        let format = picture_format(path, encoding.output_format)?;
        check_quality(encoding.jpeg_quality, format)?;
        let mut planes = Vec::new();
        if !aovs.is_empty() && format != PictureFormat::File(OutputFormat::Exr) {
            if standard_output {
                return Err(Failure::usage("planes go to standard output as .exr only: --output-format exr"));
            }
            let named = |aov: Aov| {
                let mut name = path.file_stem().unwrap_or_default().to_owned();
                name.push(format!(".{}.png", aov.name()));
                path.with_file_name(name)
            };
            planes = aovs.iter().map(|&aov| (aov, named(aov))).collect();
        }
        let quality = encoding.jpeg_quality.unwrap_or(DEFAULT_JPEG_QUALITY);
        let target =
            Self { path: path.to_owned(), format, quality, planes, fills_empty: false, is_marked: false };
        if standard_output {
            check_standard_output(json, format.terminal().is_some())?;
            return Ok(target);
        }
        for file in std::iter::once(path).chain(target.planes.iter().map(|(_, file)| file.as_path())) {
            check_file(file, inputs)?;
        }
        Ok(target)
    }

    /// The same for a picture of this format, whatever its name says, for a caller who may have made an empty file of that
    /// name and have it open: that one gets its content in place.
    ///
    /// # Errors
    /// As [`OutputFile::new`].
    pub(super) fn of_format(
        path: &Path,
        format: OutputFormat,
        inputs: &[PathBuf],
        json: bool,
    ) -> Result<Self, Failure> {
        if is_standard_output(path) {
            check_standard_output(json, false)?;
        } else {
            check_file(path, inputs)?;
        }
        let (path, planes) = (path.to_owned(), Vec::new());
        let format = PictureFormat::File(format);
        Ok(Self { path, format, quality: DEFAULT_JPEG_QUALITY, planes, fills_empty: true, is_marked: false })
    }

    /// The same for a picture whose name nobody has asked for, see `default_output.rs`.
    pub(super) fn marked(self) -> Self {
        Self { is_marked: true, ..self }
    }

    /// The format of the picture.
    #[must_use]
    pub fn format(&self) -> PictureFormat {
        self.format
    }

    /// True if [`Pixels::Image`] is enough.
    #[must_use]
    pub fn takes_image(&self) -> bool {
        !self.format.is_linear() && self.planes.is_empty()
    }

    /// Encodes the picture and its planes.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub fn encode(&self, pixels: &Pixels, display: &DisplayOptions) -> Result<Encoded, Failure> {
        let mut files = Vec::new();
        // The picture comes last, so that who waits for it finds everything.
        let bytes = match pixels {
            Pixels::Frame(frame) => {
                for (aov, path) in &self.planes {
                    let bytes = encode_aov_png(frame, *aov).map_err(|e| output_failure(&e, path))?;
                    files.push((path.clone(), bytes));
                }
                match self.format {
                    PictureFormat::File(format) => encode(frame, format, &self.options(display)),
                    PictureFormat::Terminal(format) => {
                        encode_terminal(&DisplayImage::new(frame, display), format)
                    }
                }
            }
            Pixels::Image(image) => self.bytes_of_image(image, display),
        };
        let mut bytes = bytes.map_err(|e| output_failure(&e, &self.path))?;
        if self.is_marked {
            default_output::mark(&mut bytes);
        }
        files.push((self.path.clone(), bytes));
        Ok(Encoded { files, fills_empty: self.fills_empty })
    }
}

impl OutputFile {
    fn options(&self, display: &DisplayOptions) -> OutputOptions {
        OutputOptions::default().with_display(display.clone()).with_jpeg_quality(self.quality)
    }

    fn bytes_of_image(&self, image: &DisplayImage, display: &DisplayOptions) -> Result<Vec<u8>, OutputError> {
        match self.format {
            PictureFormat::File(format) => encode_image(image, format, &self.options(display)),
            PictureFormat::Terminal(format) => encode_terminal(image, format),
        }
    }

    /// Encodes a picture that is for screens.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub(super) fn encode_image(&self, image: &DisplayImage) -> Result<Encoded, Failure> {
        let bytes = self
            .bytes_of_image(image, &DisplayOptions::default())
            .map_err(|e| output_failure(&e, &self.path))?;
        Ok(Encoded::new(self.path.clone(), bytes))
    }
}

/// The format that is asked for, or that the name says; both must agree.
///
/// # Errors
/// [`Failure`] if they contradict each other, or there is none.
pub(super) fn file_format(path: &Path, asked: Option<OutputFormat>) -> Result<OutputFormat, Failure> {
    if is_standard_output(path) {
        return Ok(asked.unwrap_or_default());
    }
    match (asked, OutputFormat::from_path(path)) {
        (Some(asked), Ok(named)) if asked != named => {
            let message = format!("--output-format {asked} contradicts the name; call it .{asked}");
            Err(Failure::usage(message).at(path))
        }
        (Some(asked), _) => Ok(asked),
        (None, named) => named.map_err(Failure::usage),
    }
}

/// [`file_format`], or one for terminals, which no name says.
fn picture_format(path: &Path, asked: Option<PictureFormat>) -> Result<PictureFormat, Failure> {
    match asked {
        Some(PictureFormat::Terminal(format)) => match OutputFormat::from_path(path) {
            Ok(named) => {
                let message = format!("--output-format {format} contradicts the name, which is of .{named}");
                Err(Failure::usage(message).at(path))
            }
            Err(_) => Ok(PictureFormat::Terminal(format)),
        },
        Some(PictureFormat::File(format)) => file_format(path, Some(format)).map(PictureFormat::File),
        None => file_format(path, None).map(PictureFormat::File),
    }
}

/// A quality is for what loses something.
///
/// # Errors
/// [`Failure`] if it is given for another format.
pub(super) fn check_quality(quality: Option<u8>, format: PictureFormat) -> Result<(), Failure> {
    match (quality, format) {
        (None, _) | (_, PictureFormat::File(OutputFormat::Jpeg)) => Ok(()),
        (_, PictureFormat::File(format)) => {
            Err(Failure::usage(format!("--jpeg-quality is for .jpg; .{format} loses nothing")))
        }
        (_, PictureFormat::Terminal(format)) => {
            Err(Failure::usage(format!("--jpeg-quality is for .jpg and not for {format}")))
        }
    }
}

/// The bytes of all files of one picture.
#[derive(Clone, Debug)]
pub struct Encoded {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// As of [`OutputFile`].
    fills_empty: bool,
}

impl Encoded {
    /// One file.
    #[must_use]
    pub fn new(path: PathBuf, bytes: Vec<u8>) -> Self {
        Self::of_files(vec![(path, bytes)])
    }

    /// Several files.
    #[must_use]
    pub(super) fn of_files(files: Vec<(PathBuf, Vec<u8>)>) -> Self {
        Self { files, fills_empty: false }
    }

    /// Bytes of all files.
    #[must_use]
    pub fn size(&self) -> u64 {
        self.files.iter().map(|(_, bytes)| bytes.len() as u64).sum()
    }

    /// XXH3-128 over the bytes of all files, in the order in which they are written.
    #[must_use]
    pub fn digest(&self) -> u128 {
        let mut hasher = Xxh3::new();
        self.files.iter().for_each(|(_, bytes)| hasher.update(bytes));
        hasher.digest128()
    }

    /// Writes everything, or nothing.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub fn write(&self) -> Result<(), Failure> {
        for (k, (path, bytes)) in self.files.iter().enumerate() {
            let written = if is_standard_output(path) {
                let mut out = std::io::stdout().lock();
                out.write_all(bytes).and_then(|()| out.flush()).map_err(|e| match e.kind() {
                    ErrorKind::BrokenPipe => Failure::silent(),
                    _ => Failure::failed(format!("standard output cannot be written: {e}")),
                })
            } else {
                let write = if self.fills_empty { fill_or_write_atomically } else { write_atomically };
                write(path, bytes).map_err(|e| output_failure(&e, path))
            };
            if let Err(failure) = written {
                self.files[..k].iter().for_each(|(earlier, _)| remove(earlier));
                return Err(failure);
            }
        }
        Ok(())
    }
}

/// Takes back a file that has been written. A device or a pipe stays.
pub(super) fn remove(path: &Path) {
    if let Ok(written) = destination(path)
        && std::fs::metadata(&written).is_ok_and(|found| found.is_file())
    {
        // The failure that counts is the one before.
        let _ = std::fs::remove_file(written);
    }
}

/// True if a path stands for standard output. `/dev/stdout` may lead to a regular file, which whoever started the program
/// has open: replacing it would write to a file that nobody looks at.
pub(super) fn is_standard_output(path: &Path) -> bool {
    let names = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
    is_standard_stream(path) || (cfg!(unix) && names.iter().any(|name| path == Path::new(name)))
}

/// Messages name the file once.
pub(super) fn output_failure(error: &OutputError, path: &Path) -> Failure {
    match error {
        OutputError::Write { source, .. } => {
            let failure = Failure::failed(format!("cannot be written: {source}"));
            failure.with_code(codes::UNWRITABLE).at(path)
        }
        OutputError::UnknownExtension { .. } => Failure::usage(error),
        other => Failure::failed(other).at(path),
    }
}

/// Checks that standard output can take a picture: a terminal only what is `for_terminal`.
pub(super) fn check_standard_output(json: bool, for_terminal: bool) -> Result<(), Failure> {
    if json {
        return Err(Failure::usage("--json and the picture cannot both go to standard output"));
    }
    if std::io::stdout().is_terminal() {
        let message = "standard output is a terminal, which shows what overcoat render makes with --output-format kitty, sixel \
                       or blocks";
        return if for_terminal { Ok(()) } else { Err(Failure::usage(message)) };
    }
    if is_lost() {
        return Err(Failure::failed(
            "standard output is closed, or is /dev/null open for reading as well: the picture would be lost",
        ));
    }
    Ok(())
}

/// True if nobody can read standard output. Where a process is started without one, the standard library has put
/// `/dev/null` in its place before any of our code runs, open for reading and writing, as nobody does who redirects it.
fn is_lost() -> bool {
    #[cfg(unix)]
    {
        use rustix::fs::{FileType, OFlags, fcntl_getfl, fstat, stat};
        let out = std::io::stdout();
        let (Ok(flags), Ok(found), Ok(null)) = (fcntl_getfl(&out), fstat(&out), stat("/dev/null")) else {
            return false;
        };
        let is_device = FileType::from_raw_mode(found.st_mode) == FileType::CharacterDevice;
        is_device && found.st_rdev == null.st_rdev && flags.contains(OFlags::RDWR)
    }
    #[cfg(not(unix))]
    false
}

/// Checks that a file can be written and is none of the inputs.
pub(super) fn check_file(path: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    check_writable(path)?;
    match inputs.iter().any(|input| is_same_file(path, input)) {
        true => Err(Failure::usage("this is an input; it would be overwritten").at(path)),
        false => Ok(()),
    }
}

/// Finds out before the work what would fail after it.
pub(super) fn check_writable(path: &Path) -> Result<(), Failure> {
    let cannot = |reason: String| Err(Failure::failed(format!("cannot be written: {reason}")).at(path));
    if path.is_dir() {
        return cannot("it is a folder".to_owned());
    }
    let target = match destination(path) {
        Ok(target) => target,
        Err(e) => return cannot(e.to_string()),
    };
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => {}
        Ok(_) => return cannot(format!("{} is not a folder", folder.display())),
        Err(e) => return cannot(format!("{}: {e}", folder.display())),
    }
    // WASI's files have no permissions, which looks like none.
    if !cfg!(target_family = "wasm") && std::fs::metadata(path).is_ok_and(|m| m.permissions().readonly()) {
        return cannot("it is read-only".to_owned());
    }
    Ok(())
}

/// True if both paths lead to one file.
fn is_same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => false,
    }
}
