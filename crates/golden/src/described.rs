//! A folder of goldens, each with a description of what it shows.

use super::GoldenError;
use super::assertion::{Actual, Golden};
use super::report::{ReportEntry, to_html};
use super::walk::{NEW, THRESHOLDS};
use overcoat_core::files::read_file;
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use overcoat_image::output::write_atomically;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every golden of a folder.
#[derive(Clone, Debug)]
pub struct GoldenFolder {
    goldens: Vec<DescribedGolden>,
}

/// One golden: the files `<name>.toml` and `<name>.png`.
#[derive(Clone, Debug)]
pub struct DescribedGolden {
    name: String,
    folder: PathBuf,
    text: String,
    description: String,
    why: String,
    hash: Option<String>,
    has_picture: bool,
    limits: Limits,
}

impl GoldenFolder {
    /// Reads the descriptions of all goldens in a folder, in the order of their names. A picture without a
    /// description is a golden too: one that fails. Files are read within the default [`Limits`].
    ///
    /// # Errors
    /// [`GoldenError::Io`] and [`GoldenError::Malformed`], and [`GoldenError::Unpaired`] for a `.png` without its
    /// `.toml`.
    pub fn open(folder: &Path) -> Result<Self, GoldenError> {
        Self::open_within(folder, &Limits::default())
    }

    /// [`GoldenFolder::open`] within other limits, which count for the pictures too.
    ///
    /// # Errors
    /// As [`GoldenFolder::open`].
    pub fn open_within(folder: &Path, limits: &Limits) -> Result<Self, GoldenError> {
        let io = |source| GoldenError::Io { path: folder.to_owned(), source };
        let mut names = BTreeSet::new();
        let mut pictures = BTreeSet::new();
        for entry in fs::read_dir(folder).map_err(io)? {
            let path = entry.map_err(io)?.path();
            let Some(name) = path.file_stem().and_then(|stem| stem.to_str()) else { continue };
            // What belongs to the folder, and what a failed test has left.
            if path.ends_with(THRESHOLDS) || name.ends_with(NEW) {
                continue;
            }
            match path.extension().and_then(|extension| extension.to_str()) {
                Some("toml") => names.insert(name.to_owned()),
                Some("png") => pictures.insert(name.to_owned()),
                _ => false,
            };
        }
        if let Some(name) = pictures.difference(&names).next() {
            return Err(GoldenError::Unpaired {
                present: folder.join(format!("{name}.png")),
                missing: folder.join(format!("{name}.toml")),
            });
        }
        let goldens = names
            .into_iter()
            .map(|name| {
                let has_picture = pictures.contains(&name);
                DescribedGolden::read(folder, name, has_picture, limits)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { goldens })
    }

    /// The goldens by name.
    #[must_use]
    pub fn goldens(&self) -> &[DescribedGolden] {
        &self.goldens
    }
}

impl DescribedGolden {
    fn read(folder: &Path, name: String, has_picture: bool, limits: &Limits) -> Result<Self, GoldenError> {
        let path = folder.join(format!("{name}.toml"));
        let malformed = |reason: String| GoldenError::Malformed { path: path.clone(), reason };
        let bytes = read_file(&path, limits).map_err(|error| malformed(error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|_| malformed("it is not UTF-8".to_owned()))?;
        let mut table: toml::Table =
            text.parse().map_err(|e: toml::de::Error| malformed(e.message().to_owned()))?;
        let Some(toml::Value::Table(golden)) = table.remove("golden") else {
            return Err(malformed("no table [golden]".to_owned()));
        };
        if let Some(key) = golden.keys().find(|key| !["why", "hash"].contains(&key.as_str())) {
            return Err(malformed(format!("unknown key golden.{key}; known are why and hash")));
        }
        let entry = |key| golden.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        let why = entry("why").filter(|why| !why.trim().is_empty()).ok_or_else(|| {
            malformed(
                "golden.why must say in one sentence what would be wrong if the picture changed".to_owned(),
            )
        })?;
        let hash = entry("hash").filter(|hash| !hash.is_empty());
        let description = table.to_string();
        let (folder, limits) = (folder.to_owned(), limits.clone());
        Ok(Self { name, folder, text, description, why, hash, has_picture, limits })
    }

    /// Name of both files, without extension.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Description of the picture to draw: the `.toml` without its `[golden]` table.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Reason that the picture is tested: what would be wrong if it changed.
    #[must_use]
    pub fn why(&self) -> &str {
        &self.why
    }

    /// The recorded hash of the linear frame, if there is one.
    #[must_use]
    pub fn hash(&self) -> Option<&str> {
        self.hash.as_deref()
    }

    /// Path of the recorded picture.
    #[must_use]
    pub fn picture_path(&self) -> PathBuf {
        self.folder.join(format!("{}.png", self.name))
    }

    /// Compares with what is recorded: the hash of the linear frame, and the 8-bit picture as [`Golden`] does. Where it differs,
    /// `<name>.new.png` is written into the folder `failures`, and `<name>.html`, which shows where.
    ///
    /// # Errors
    /// [`GoldenError::Differs`], or what keeps the golden from being compared.
    pub fn check(&self, frame_hash: &str, actual: &DisplayImage, failures: &Path) -> Result<(), GoldenError> {
        if !self.has_picture {
            return Err(GoldenError::Unpaired {
                present: self.folder.join(format!("{}.toml", self.name)),
                missing: self.picture_path(),
            });
        }
        let recorded = self.hash.as_deref().unwrap_or("none");
        let hashes = if recorded == frame_hash {
            format!("the linear frame is the same (hash {recorded})")
        } else {
            format!("the linear frame is another one (hash {recorded} is now {frame_hash})")
        };
        let why = Some(self.why.clone());
        let page_path = failures.join(format!("{}.html", self.name));
        let golden = self.golden().failures_in(failures).updating(false);
        let compared = golden.check_actual(&format!("{}.png", self.name), Actual::Image(actual));
        if compared.is_ok() {
            // What an earlier failure left, as the picture beside it.
            let _ = fs::remove_file(&page_path);
        }
        match compared {
            Ok(()) if recorded == frame_hash => Ok(()),
            Ok(()) => {
                let summary =
                    format!("{}: no pixel differs in 8 bits by more than it may, but {hashes}", self.name);
                Err(GoldenError::Differs { summary, why, expected: Some(self.picture_path()), actual: None })
            }
            Err((GoldenError::Differs { summary, expected, actual, .. }, compared)) => {
                if let Some(compared) = compared {
                    let [expected, actual] = [&self.folder, failures].map(|f| f.display().to_string());
                    let page = to_html(&expected, &actual, &[ReportEntry::new(&compared, false)]);
                    write_atomically(&page_path, page.as_bytes())?;
                }
                Err(GoldenError::Differs { summary: format!("{summary}; {hashes}"), why, expected, actual })
            }
            Err((error, _)) => Err(error),
        }
    }

    /// Records a picture: writes the `.png` and the hash into the `.toml`, of which nothing else changes.
    ///
    /// Returns the error that ends the test: [`GoldenError::Recorded`], or what kept the picture from being
    /// recorded. Recording never passes.
    #[must_use = "a golden that was recorded has not been checked"]
    pub fn accept(&self, frame_hash: &str, actual: &DisplayImage) -> GoldenError {
        let path = self.folder.join(format!("{}.toml", self.name));
        let Some(text) = with_hash(&self.text, frame_hash) else {
            return GoldenError::Malformed {
                path,
                reason: "[golden] must stand on a line of its own".to_owned(),
            };
        };
        let golden = self.golden().updating(true);
        match golden.check_actual(&format!("{}.png", self.name), Actual::Image(actual)) {
            Err((GoldenError::Recorded { path: picture, changed }, _)) => {
                match write_atomically(&path, text.as_bytes()) {
                    Ok(()) => {
                        let changed = changed || self.hash.as_deref() != Some(frame_hash);
                        GoldenError::Recorded { path: picture, changed }
                    }
                    Err(error) => error.into(),
                }
            }
            Err((error, _)) => error,
            // It never says that all is well.
            Ok(()) => GoldenError::Recorded { path: self.picture_path(), changed: false },
        }
    }

    /// The picture alone, as any project has it.
    fn golden(&self) -> Golden {
        Golden::new(&self.folder).limits(self.limits.clone())
    }
}

/// The text with `hash = "..."` replaced in the table `[golden]`, or added at that table's start. `None` if the table
/// has no line of its own.
fn with_hash(text: &str, hash: &str) -> Option<String> {
    let entry = format!("hash = \"{hash}\"");
    let mut lines: Vec<&str> = text.lines().collect();
    let header = lines.iter().position(|line| line.trim() == "[golden]")?;
    let is_hash = |line: &str| line.split_once('=').is_some_and(|(key, _)| key.trim() == "hash");
    let rest = lines[header + 1..].iter().take_while(|line| !line.starts_with('['));
    match rest.clone().position(|line| is_hash(line)) {
        Some(k) => lines[header + 1 + k] = &entry,
        None => lines.insert(header + 1, &entry),
    }
    Some(lines.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_image::output::encode_png;

    const TOML: &str = "# A comment.\nmodel = \"a.glb\"\n\n[golden]\nwhy = \"All.\"\n";

    fn picture(v: u8) -> DisplayImage {
        DisplayImage { width: 2, height: 1, pixels: vec![[v, 0, 0, 255]; 2] }
    }

    fn only(folder: &Path) -> DescribedGolden {
        GoldenFolder::open(folder).unwrap().goldens()[0].clone()
    }

    #[test]
    fn recording_fails_and_the_next_run_passes_until_something_changes() {
        let folder = tempfile::tempdir().unwrap();
        let failures = folder.path().join("failures");
        fs::write(folder.path().join("a.toml"), TOML).unwrap();

        let golden = only(folder.path());
        assert_eq!((golden.name(), golden.why(), golden.hash()), ("a", "All.", None));
        assert_eq!(golden.description().trim(), "model = \"a.glb\"");
        assert!(matches!(golden.check("12", &picture(5), &failures), Err(GoldenError::Unpaired { .. })));
        assert!(matches!(golden.accept("12", &picture(5)), GoldenError::Recorded { changed: true, .. }));

        let golden = only(folder.path());
        golden.check("12", &picture(5), &failures).unwrap();
        assert!(matches!(golden.accept("12", &picture(5)), GoldenError::Recorded { changed: false, .. }));
        assert!(!failures.exists());
        for (hash, v, words) in
            [("12", 6, "linear frame is the same"), ("13", 5, "no pixel differs"), ("13", 6, "2 pixels")]
        {
            let message = golden.check(hash, &picture(v), &failures).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains("All."), "{message}");
            // The picture that differs is left for looking at.
            let left = ["a.new.png", "a.html"].map(|file| failures.join(file).exists());
            assert_eq!(left, [v != 5; 2]);
        }

        // Files of the folder that are no goldens.
        fs::write(folder.path().join("a.new.png"), "left").unwrap();
        fs::write(folder.path().join("thresholds.toml"), "max_abs = 1").unwrap();
        golden.check("12", &picture(6), &failures).unwrap();
        fs::remove_file(folder.path().join("thresholds.toml")).unwrap();
        assert_eq!(only(folder.path()).name(), "a");

        // Recording again replaces the hash and keeps everything else.
        let _ = golden.accept("13", &picture(6));
        let text = fs::read_to_string(folder.path().join("a.toml")).unwrap();
        assert_eq!(text, TOML.replace("why", "hash = \"13\"\nwhy"));
    }

    #[test]
    fn a_golden_without_its_other_half_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("b.png"), encode_png(&picture(1)).unwrap()).unwrap();
        let message = GoldenFolder::open(folder.path()).unwrap_err().to_string();
        assert!(message.contains("b.toml: missing"), "{message}");
    }

    #[test]
    fn descriptions_must_be_complete() {
        for (text, words) in [
            ("model = 1", "[golden]"),
            ("[golden]\nhash = \"\"", "golden.why"),
            ("[golden]\nwhy = \" \"", "golden.why"),
            ("[golden]\nwhy = \"x\"\nhsah = \"\"", "golden.hsah"),
            ("[golden", ""),
        ] {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("c.toml"), text).unwrap();
            let message = GoldenFolder::open(folder.path()).unwrap_err().to_string();
            assert!(message.contains("c.toml") && message.contains(words), "{message}");
        }
    }
}
