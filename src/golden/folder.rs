//! A folder of goldens, each with a description of what it shows.

use super::{Comparison, GoldenError, Picture};
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
}

impl GoldenFolder {
    /// Reads the descriptions of all goldens in a folder, in the order of their names. A picture without a
    /// description is a golden too: one that fails.
    ///
    /// # Errors
    /// [`GoldenError::Io`] and [`GoldenError::Malformed`], and [`GoldenError::Unpaired`] for a `.png` without its
    /// `.toml`.
    pub fn open(folder: &Path) -> Result<Self, GoldenError> {
        let io = |source| GoldenError::Io { path: folder.to_owned(), source };
        let mut names = BTreeSet::new();
        let mut pictures = BTreeSet::new();
        for entry in fs::read_dir(folder).map_err(io)? {
            let path = entry.map_err(io)?.path();
            let Some(name) = path.file_stem().and_then(|stem| stem.to_str()) else { continue };
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
                DescribedGolden::read(folder, name, has_picture)
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
    fn read(folder: &Path, name: String, has_picture: bool) -> Result<Self, GoldenError> {
        let path = folder.join(format!("{name}.toml"));
        let text =
            fs::read_to_string(&path).map_err(|source| GoldenError::Io { path: path.clone(), source })?;
        let malformed = |reason: String| GoldenError::Malformed { path: path.clone(), reason };
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
        Ok(Self { name, folder: folder.to_owned(), text, description, why, hash, has_picture })
    }

    /// Name of both files, without extension.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is to be drawn: the `.toml` without its `[golden]` table.
    #[must_use]
    pub fn description(&self) -> &str {
        &self.description
    }

    /// What would be wrong if the picture changed.
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

    /// Compares with what is recorded, without tolerance: the hash of the linear frame, and the 8-bit picture. On a
    /// mismatch writes `<name>.png` (expected, difference, actual) and `<name>.json` (every pixel that differs) into
    /// the folder `failures`.
    ///
    /// # Errors
    /// [`GoldenError::Mismatch`], or what keeps the golden from being compared.
    pub fn check(&self, frame_hash: &str, actual: &Picture, failures: &Path) -> Result<(), GoldenError> {
        let path = self.picture_path();
        if !self.has_picture {
            return Err(GoldenError::Unpaired {
                present: self.folder.join(format!("{}.toml", self.name)),
                missing: path,
            });
        }
        let bytes = fs::read(&path).map_err(|source| GoldenError::Io { path: path.clone(), source })?;
        let expected = Picture::from_png(&bytes)
            .map_err(|reason| GoldenError::Malformed { path: path.clone(), reason })?;
        let comparison = Comparison::new(&expected, actual);
        let recorded = self.hash.as_deref().unwrap_or("none");
        if recorded == frame_hash && comparison.is_equal() {
            return Ok(());
        }

        let summary = match (comparison.pixels.len(), recorded == frame_hash) {
            (0, _) => format!(
                "no pixel differs in 8 bits, but the linear frame does (hash {recorded} is now {frame_hash})"
            ),
            (count, true) => format!(
                "{count} pixels differ by up to {}, although the linear frame is the same (hash {recorded})",
                comparison.largest
            ),
            (count, false) => format!(
                "{count} pixels differ by up to {} (hash {recorded} is now {frame_hash})",
                comparison.largest
            ),
        };
        let triptych = failures.join(format!("{}.png", self.name));
        let report = failures.join(format!("{}.json", self.name));
        fs::create_dir_all(failures)
            .map_err(|source| GoldenError::Io { path: failures.to_owned(), source })?;
        let header = [("name", self.name.as_str()), ("expected_hash", recorded), ("actual_hash", frame_hash)];
        write_picture(&triptych, &comparison.triptych(&expected, actual))?;
        write(&report, comparison.to_json(&header).as_bytes())?;
        Err(GoldenError::Mismatch {
            name: self.name.clone(),
            why: self.why.clone(),
            summary,
            triptych,
            report,
        })
    }

    /// Records a picture: writes the `.png`, and the hash into the `.toml`, of which nothing else changes.
    ///
    /// Returns the error that ends the test: [`GoldenError::Accepted`], or what kept the picture from being
    /// recorded. Recording never passes.
    #[must_use = "a golden that was recorded has not been checked"]
    pub fn accept(&self, frame_hash: &str, actual: &Picture) -> GoldenError {
        let recorded = write_picture(&self.picture_path(), actual).and_then(|()| {
            let path = self.folder.join(format!("{}.toml", self.name));
            let reason = || "[golden] must stand on a line of its own".to_owned();
            let text = with_hash(&self.text, frame_hash)
                .ok_or_else(|| GoldenError::Malformed { path: path.clone(), reason: reason() })?;
            write(&path, text.as_bytes())
        });
        match recorded {
            Ok(()) => GoldenError::Accepted {
                name: self.name.clone(),
                hash: frame_hash.to_owned(),
                picture: self.picture_path(),
            },
            Err(error) => error,
        }
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

fn write(path: &Path, bytes: &[u8]) -> Result<(), GoldenError> {
    fs::write(path, bytes).map_err(|source| GoldenError::Io { path: path.to_owned(), source })
}

fn write_picture(path: &Path, picture: &Picture) -> Result<(), GoldenError> {
    let bytes =
        picture.to_png().map_err(|reason| GoldenError::Malformed { path: path.to_owned(), reason })?;
    write(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOML: &str = "# A comment.\nmodel = \"a.glb\"\n\n[golden]\nwhy = \"All.\"\n";

    fn picture(v: u8) -> Picture {
        Picture { width: 2, height: 1, pixels: vec![[v, 0, 0, 255]; 2] }
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
        assert!(matches!(golden.accept("12", &picture(5)), GoldenError::Accepted { .. }));

        let golden = only(folder.path());
        golden.check("12", &picture(5), &failures).unwrap();
        assert!(!failures.exists());
        for (hash, v, words) in
            [("12", 6, "linear frame is the same"), ("13", 5, "no pixel differs"), ("13", 6, "2 pixels")]
        {
            let message = golden.check(hash, &picture(v), &failures).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains("All."), "{message}");
            assert!(failures.join("a.png").exists() && failures.join("a.json").exists());
        }

        // Recording again replaces the hash and keeps everything else.
        let _ = golden.accept("13", &picture(6));
        let text = fs::read_to_string(folder.path().join("a.toml")).unwrap();
        assert_eq!(text, TOML.replace("why", "hash = \"13\"\nwhy"));
    }

    #[test]
    fn a_golden_without_its_other_half_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("b.png"), picture(1).to_png().unwrap()).unwrap();
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
