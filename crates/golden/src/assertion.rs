//! Goldens for tests of any project: a folder of pictures, and one line in a test.

use super::GoldenError;
use super::accept::{Accepted, prepare, store};
use super::check::{Compared, FileResult, Verdict, compare_sides, decode_side, read_side};
use super::thresholds::{ThresholdFile, Thresholds};
use super::walk::{NEW, Pair, THRESHOLDS};
use overcoat_core::files::read_file;
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use overcoat_image::decode::DecodedPicture;
use overcoat_image::output::{encode_png, write_atomically};
use std::path::{Path, PathBuf};

/// A folder of expected pictures for use within `cargo test`.
///
/// [`Golden::assert`] compares what a test drew with the file of that name. On a mismatch it writes `<name>.new.png` and
/// panics with both paths; once the picture is as expected again, the file goes away. `overcoat golden report` shows
/// such files beside the expected ones, and `overcoat golden accept` takes them.
///
/// With the environment variable `UPDATE_GOLDENS=1` the picture is recorded instead, and the test **fails all
/// the same**: whoever records a picture has looked at it, and runs the tests again.
///
/// Pictures must be equal in every pixel, unless a `thresholds.toml` in the folder says otherwise (see
/// [`thresholds`](super::thresholds)). Tests may run in parallel: files are written whole, and no two names share one.
///
/// ```no_run
/// # mod overcoat { pub use {overcoat_core::frame, overcoat_golden as golden}; }
/// use overcoat::frame::DisplayImage;
/// use overcoat::golden::Golden;
///
/// # fn draw() -> DisplayImage { unimplemented!() }
/// #[test]
/// fn the_knot_looks_as_it_should() {
///     Golden::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden")).assert("knot", &draw());
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Golden {
    folder: PathBuf,
    failures: Option<PathBuf>,
    otherwise: Thresholds,
    update: bool,
    limits: Limits,
}

impl Golden {
    /// The goldens in a folder, which need not exist before the first is recorded.
    #[must_use]
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            failures: None,
            otherwise: Thresholds::default(),
            update: std::env::var_os("UPDATE_GOLDENS").is_some_and(|value| value == "1"),
            limits: Limits::default(),
        }
    }

    /// Writes what differs into this folder instead of beside the expected pictures.
    #[must_use]
    pub fn failures_in(mut self, folder: impl Into<PathBuf>) -> Self {
        self.failures = Some(folder.into());
        self
    }

    /// Sets the thresholds of pictures for which `thresholds.toml` says nothing.
    #[must_use]
    pub fn thresholds(mut self, thresholds: Thresholds) -> Self {
        self.otherwise = thresholds;
        self
    }

    /// Records or compares, whatever the environment says.
    #[must_use]
    pub fn updating(mut self, update: bool) -> Self {
        self.update = update;
        self
    }

    /// Bounds on the files that are read; [`Limits::default`] if nothing is said.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Compares a picture with `<name>.png`. The name may lead into folders: `cars/red`.
    ///
    /// # Panics
    /// With a message that names the files, where [`Golden::check`] gives an error.
    #[track_caller]
    pub fn assert(&self, name: &str, actual: &DisplayImage) {
        if let Err(error) = self.check(name, actual) {
            panic!("{error}");
        }
    }

    /// Compares a picture file, PNG, WebP (both animated or not), JPEG, OpenEXR or Radiance, with the expected file of this
    /// name: `sky.exr`.
    ///
    /// # Panics
    /// With a message that names the files, where [`Golden::check_file`] gives an error.
    #[track_caller]
    pub fn assert_file(&self, file_name: &str, actual: &[u8]) {
        if let Err(error) = self.check_file(file_name, actual) {
            panic!("{error}");
        }
    }

    /// Compares a picture with `<name>.png`.
    ///
    /// # Errors
    /// [`GoldenError::Differs`], [`GoldenError::Recorded`], or what keeps the picture from being compared.
    pub fn check(&self, name: &str, actual: &DisplayImage) -> Result<(), GoldenError> {
        self.check_actual(&format!("{name}.png"), Actual::Image(actual)).map_err(|(error, _)| error)
    }

    /// Compares a picture file, PNG, WebP (both animated or not), JPEG, OpenEXR or Radiance, with the expected file of this
    /// name.
    ///
    /// # Errors
    /// As [`Golden::check`].
    pub fn check_file(&self, file_name: &str, actual: &[u8]) -> Result<(), GoldenError> {
        self.check_actual(file_name, Actual::File(actual)).map_err(|(error, _)| error)
    }

    /// The only way to compare and to record. The error comes with what was compared, if it came so far.
    pub(super) fn check_actual(
        &self,
        file_name: &str,
        actual: Actual<'_>,
    ) -> Result<(), (GoldenError, Option<Box<Compared>>)> {
        let only = |error| (error, None);
        let expected = self.folder.join(file_name);
        let new = new_path(self.failures.as_deref().unwrap_or(&self.folder), file_name).ok_or_else(|| {
            only(GoldenError::Malformed {
                path: expected.clone(),
                reason: "the name of a golden is a relative path with an extension".to_owned(),
            })
        })?;
        if let Actual::Image(image) = actual
            && let Some(reason) = not_a_picture(image)
        {
            return Err(only(GoldenError::Malformed { path: new, reason }));
        }
        let thresholds = self.read_thresholds(file_name).map_err(only)?;
        if self.update {
            actual.write(&new).map_err(only)?;
            let pair = Pair {
                name: file_name.to_owned(),
                relative: file_name.into(),
                expected: expected.is_file().then(|| expected.clone()),
                actual: Some(new),
                is_new: true,
                problem: None,
                unread: false,
            };
            return Err(only(self.record(&pair, &thresholds, expected)));
        }
        let stored = expected.is_file().then(|| read_side(&expected, &self.limits));
        let drawn = match actual {
            Actual::Image(image) => Ok((Vec::new(), DecodedPicture::from(image))),
            Actual::File(bytes) => decode_side(bytes.to_vec(), &self.limits),
        };
        let compared =
            compare_sides(file_name, [stored, Some(drawn)], None, &thresholds, false, &self.limits);
        match compared.result.verdict {
            Verdict::Equal | Verdict::Within => {
                // What an earlier failure left. That it still lies there would be untidy and no failure.
                let _ = std::fs::remove_file(&new);
                Ok(())
            }
            verdict => {
                actual.write(&new).map_err(only)?;
                let error = GoldenError::Differs {
                    summary: summary(&compared.result),
                    why: None,
                    expected: (verdict != Verdict::NoExpected).then_some(expected),
                    actual: Some(new),
                };
                Err((error, Some(Box::new(compared))))
            }
        }
    }

    fn read_thresholds(&self, name: &str) -> Result<Thresholds, GoldenError> {
        let path = self.folder.join(THRESHOLDS);
        if !path.exists() {
            return Ok(self.otherwise.clone());
        }
        let malformed = |reason| GoldenError::Malformed { path: path.clone(), reason };
        let bytes = read_file(&path, &self.limits).map_err(|error| malformed(error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|_| malformed("it is not UTF-8".to_owned()))?;
        let file = ThresholdFile::parse(&text);
        match file.problems().first() {
            None => Ok(file.of(name, &self.otherwise)),
            Some(problem) => Err(malformed(format!("line {}: {}", problem.line, problem.message))),
        }
    }

    /// Stores the actual picture. Always an error.
    fn record(&self, pair: &Pair, thresholds: &Thresholds, path: PathBuf) -> GoldenError {
        let done = prepare(pair, &self.folder, thresholds, true, &self.limits)
            .and_then(|accepted| store(&accepted, pair).map(|()| accepted));
        match done {
            Ok(Accepted::Unchanged) => GoldenError::Recorded { path, changed: false },
            Ok(Accepted::Written { .. }) => GoldenError::Recorded { path, changed: true },
            Err(error) => GoldenError::Malformed { path, reason: error.to_string() },
        }
    }
}

/// Picture that a test has drawn.
#[derive(Clone, Copy)]
pub(super) enum Actual<'a> {
    Image(&'a DisplayImage),
    /// The bytes of a file.
    File(&'a [u8]),
}

impl Actual<'_> {
    /// Writes it as a file of a folder, which is made if it is not there.
    fn write(&self, path: &Path) -> Result<(), GoldenError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .map_err(|source| GoldenError::Io { path: folder.to_owned(), source })?;
        }
        match self {
            Self::Image(image) => write_atomically(path, &encode_png(image)?)?,
            Self::File(bytes) => write_atomically(path, bytes)?,
        }
        Ok(())
    }
}

/// Reason that a picture is none: it is empty, or has another number of pixels than its size says.
fn not_a_picture(image: &DisplayImage) -> Option<String> {
    let DisplayImage { width, height, pixels } = image;
    let whole = pixels.len() as u64 == u64::from(*width) * u64::from(*height) && !pixels.is_empty();
    (!whole).then(|| format!("the actual picture of {width} x {height} has {} pixels", pixels.len()))
}

/// `cars/red.new.png` in a folder. `None` for names that lead elsewhere or have no extension.
fn new_path(folder: &Path, name: &str) -> Option<PathBuf> {
    let plain = Path::new(name).components().all(|c| matches!(c, std::path::Component::Normal(_)));
    let (stem, extension) = name.rsplit_once('.')?;
    (plain && !stem.is_empty() && !extension.contains('/'))
        .then(|| folder.join(format!("{stem}{NEW}.{extension}")))
}

fn summary(result: &FileResult) -> String {
    let mut text = format!("{}: {}", result.name, result.reasons.join("; "));
    if let Some(metrics) = &result.metrics
        && metrics.flip_mean > 0.0
    {
        text.push_str(&format!(" (PSNR {:.2} dB, FLIP {:.4})", metrics.psnr, metrics.flip_mean));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_image::decode::read_display_image;
    use std::fs;

    fn picture(v: u8) -> DisplayImage {
        DisplayImage { width: 20, height: 10, pixels: vec![[v, 7, 9, 255]; 200] }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .map(|entries| entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect())
            .unwrap_or_default();
        names.sort();
        names
    }

    #[test]
    fn a_golden_is_recorded_and_fails_then_passes_then_fails_with_both_paths() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("golden");
        let golden = Golden::new(&folder).updating(false);

        let message = golden.check("knot", &picture(5)).unwrap_err().to_string();
        assert!(message.contains("no expected picture") && message.contains("knot.new.png"), "{message}");
        assert!(message.contains("UPDATE_GOLDENS=1"), "{message}");

        let update = golden.clone().updating(true);
        let recorded = update.check("knot", &picture(5)).unwrap_err();
        assert!(matches!(recorded, GoldenError::Recorded { changed: true, .. }), "{recorded}");
        assert_eq!(names(&folder), ["knot.png"]);
        let again = update.check("knot", &picture(5)).unwrap_err();
        assert!(matches!(again, GoldenError::Recorded { changed: false, .. }), "{again}");

        golden.assert("knot", &picture(5));
        assert_eq!(names(&folder), ["knot.png"]);
        let message = golden.check("knot", &picture(6)).unwrap_err().to_string();
        assert!(message.contains("200 pixels differ by up to 1"), "{message}");
        assert!(message.contains(folder.join("knot.png").to_str().unwrap()), "{message}");
        assert!(message.contains(folder.join("knot.new.png").to_str().unwrap()), "{message}");
        let left = fs::read(folder.join("knot.new.png")).unwrap();
        assert_eq!(read_display_image(&left, &Limits::default()).unwrap(), picture(6));

        // What is as expected again leaves nothing behind.
        golden.assert("knot", &picture(5));
        assert_eq!(names(&folder), ["knot.png"]);

        let failures = root.path().join("failures");
        let elsewhere = golden.failures_in(&failures);
        assert!(elsewhere.check("knot", &picture(6)).is_err());
        assert_eq!(
            (names(&folder), names(&failures)),
            (vec!["knot.png".into()], vec!["knot.new.png".into()])
        );
    }

    #[test]
    #[should_panic(expected = "200 pixels differ by up to 3")]
    fn asserting_panics_with_the_message() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.png"), encode_png(&picture(1)).unwrap()).unwrap();
        Golden::new(folder.path()).updating(false).assert("a", &picture(4));
    }

    #[test]
    fn thresholds_of_the_folder_count_and_their_mistakes_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("cars")).unwrap();
        fs::write(folder.path().join("cars/a.png"), encode_png(&picture(1)).unwrap()).unwrap();
        let golden = Golden::new(folder.path()).updating(false);
        assert!(golden.check("cars/a", &picture(2)).is_err());
        golden
            .clone()
            .thresholds(Thresholds { max_abs: Some(1.0), ..Thresholds::default() })
            .assert("cars/a", &picture(2));
        fs::write(folder.path().join("thresholds.toml"), "[\"cars/*\"]\nmax_abs = 2").unwrap();
        golden.assert("cars/a", &picture(3));
        assert!(golden.check("cars/a", &picture(4)).is_err());
        fs::write(folder.path().join("thresholds.toml"), "max_asb = 2").unwrap();
        let message = golden.check("cars/a", &picture(1)).unwrap_err().to_string();
        assert!(message.contains("line 1") && message.contains("'max_abs'"), "{message}");
    }

    #[test]
    fn names_do_not_lead_out_of_the_folder() {
        let root = tempfile::tempdir().unwrap();
        let golden = Golden::new(root.path().join("golden")).updating(true);
        let absolute = root.path().join("x");
        for name in ["../x", "a/../../x", absolute.to_str().unwrap(), ""] {
            assert!(matches!(golden.check(name, &picture(1)), Err(GoldenError::Malformed { .. })), "{name}");
        }
        assert_eq!(names(root.path()), [""; 0]);
    }

    #[test]
    fn what_is_no_picture_is_neither_compared_nor_recorded() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.png"), encode_png(&picture(1)).unwrap()).unwrap();
        let cut = DisplayImage { pixels: vec![[1, 7, 9, 255]; 199], ..picture(1) };
        let empty = DisplayImage { width: 0, height: 10, pixels: Vec::new() };
        for (image, update) in [(&cut, false), (&cut, true), (&empty, false), (&empty, true)] {
            let error = Golden::new(folder.path()).updating(update).check("a", image).unwrap_err();
            assert!(matches!(error, GoldenError::Malformed { .. }), "{error}");
        }
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn many_tests_at_once_do_not_disturb_each_other() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("golden");
        std::thread::scope(|scope| {
            for k in 0..16_u8 {
                let golden = Golden::new(&folder);
                scope.spawn(move || {
                    let name = format!("deep/picture-{k}");
                    for _ in 0..4 {
                        let _ = golden.clone().updating(true).check(&name, &picture(k));
                        golden.clone().updating(false).assert(&name, &picture(k));
                        assert!(golden.clone().updating(false).check(&name, &picture(k + 1)).is_err());
                    }
                    golden.updating(false).assert(&name, &picture(k));
                });
            }
        });
        assert_eq!(names(&folder.join("deep")).len(), 16);
    }
}
