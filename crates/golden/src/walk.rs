//! Pairing of the pictures of two folders.

use super::GoldenError;
use overcoat_core::limits::Limits;
use overcoat_image::decode::extensions;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Infix before the extension of a picture that a failed test leaves: `x.new.png` beside `x.png`.
pub const NEW: &str = ".new";

/// Name of the file that says by how much pictures of its folder may differ.
pub const THRESHOLDS: &str = "thresholds.toml";

/// A name with the files that have it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pair {
    /// Path below the folders, with `/` between its parts, as text.
    pub name: String,
    /// The same as it is.
    pub relative: PathBuf,
    /// The expected picture, if there is one.
    pub expected: Option<PathBuf>,
    /// The actual picture, if there is one.
    pub actual: Option<PathBuf>,
    /// True if the actual picture is called `x.new.png` for the expected `x.png`.
    pub is_new: bool,
    /// Reason that a file of this name was not looked at, if so: it is a link that leads out of its folder, or cannot
    /// be read.
    pub problem: Option<String>,
    /// True for files of a format that is not read, which are not the same in every byte.
    pub unread: bool,
}

/// Two folders whose pictures are compared by name, or two files.
#[derive(Clone, Debug)]
pub struct FolderPair {
    /// Folder of the expected pictures.
    pub expected: PathBuf,
    /// Folder of the actual pictures.
    pub actual: PathBuf,
    /// The pictures of both, by name, and of the other files those that differ: in a byte, or because a picture of a format
    /// that is not read is on one side only.
    pub pairs: Vec<Pair>,
    /// Number of the other files of both by extension (`.txt`; empty for names without one), without those that belong
    /// to the goldens (`thresholds.toml`).
    pub others: BTreeMap<String, u64>,
}

impl FolderPair {
    /// Lists the pictures (those with [`extensions`]) of two folders and of the folders in them, and what differs of the other
    /// files: nothing that is not read may pass for equal. In the actual folder,
    /// `x.new.png` stands for `x.png` and comes before a file of that name; in the expected folder it is left out. So
    /// both may be one folder, in which tests leave what failed.
    ///
    /// A symbolic link to a file is followed if it leads to a place within its folder; links to folders are not.
    ///
    /// # Errors
    /// [`GoldenError`] if one of the folders cannot be read, one of them is none, or there are too many pictures.
    pub fn open(expected: &Path, actual: &Path, limits: &Limits) -> Result<Self, GoldenError> {
        let is_folder = |path: &Path| {
            std::fs::metadata(path)
                .map(|m| m.is_dir())
                .map_err(|source| GoldenError::Io { path: path.to_owned(), source })
        };
        let (expected, actual) = (expected.to_owned(), actual.to_owned());
        match (is_folder(&expected)?, is_folder(&actual)?) {
            (true, true) => {}
            (false, false) => {
                let name = expected.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let pair = Pair {
                    name,
                    relative: expected.file_name().unwrap_or_default().into(),
                    expected: Some(expected.clone()),
                    actual: Some(actual.clone()),
                    ..Pair::default()
                };
                return Ok(Self { expected, actual, pairs: vec![pair], others: BTreeMap::new() });
            }
            (true, false) => return Err(GoldenError::Mixed { folder: expected, file: actual }),
            (false, true) => return Err(GoldenError::Mixed { folder: actual, file: expected }),
        }
        let mut pairs: BTreeMap<(String, PathBuf), Pair> = BTreeMap::new();
        for found in list(&expected, limits)? {
            if split_new(&found.relative).is_some() {
                continue;
            }
            let pair = pairs.entry((found.name, found.relative)).or_default();
            pair.unread = found.unread;
            pair.expected = found.problem.is_none().then_some(found.path);
            pair.problem = found.problem;
        }
        for found in list(&actual, limits)? {
            let (key, is_new) = match split_new(&found.relative) {
                Some(relative) => ((name_of(&relative), relative), true),
                None => ((found.name, found.relative), false),
            };
            let pair = pairs.entry(key).or_default();
            if pair.is_new && !is_new {
                continue;
            }
            pair.unread = found.unread;
            pair.is_new = is_new;
            pair.actual = found.problem.is_none().then_some(found.path);
            if found.problem.is_some() {
                pair.problem = found.problem;
            }
        }
        let mut out = Self { expected, actual, pairs: Vec::new(), others: BTreeMap::new() };
        for ((name, relative), pair) in pairs {
            let pair = Pair { name, relative, ..pair };
            match files_of_no_interest(&pair) {
                0 => out.pairs.push(pair),
                count => *out.others.entry(dotted(&extension(&pair.relative))).or_default() += count,
            }
        }
        Ok(out)
    }

    /// The files that are not compared as pictures, in one line; `None` if there are none.
    #[must_use]
    pub fn others_in_words(&self) -> Option<String> {
        let count: u64 = self.others.values().sum();
        let kind = |(extension, count): (&String, &u64)| match extension.as_str() {
            "" => format!("{count} without extension"),
            extension => format!("{count} {extension}"),
        };
        // An extension may be anything; so may their number.
        let mut kinds: Vec<String> = self.others.iter().take(12).map(kind).collect();
        if self.others.len() > kinds.len() {
            kinds.push("others".to_owned());
        }
        let files = if count == 1 { "1 file is" } else { &format!("{count} files are") };
        (count > 0).then(|| format!("{files} not compared: {}", kinds.join(", ")))
    }
}

/// `a/x.png` for `a/x.new.png`.
fn split_new(relative: &Path) -> Option<PathBuf> {
    let (stem, extension) = (Path::new(relative.file_stem()?), relative.extension()?);
    if stem.extension()? != NEW.trim_start_matches('.') {
        return None;
    }
    let mut name = stem.file_stem()?.to_owned();
    name.push(".");
    name.push(extension);
    Some(relative.with_file_name(name))
}

/// A path below a folder as text, with `/` between its parts.
fn name_of(relative: &Path) -> String {
    relative.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Extensions of pictures and films that are not read, in lower case.
const UNREAD_PICTURES: [&str; 38] = [
    "astc", "avi", "avif", "basis", "cin", "cur", "dds", "dng", "dpx", "ff", "gv", "heic", "heif", "ico",
    "j2k", "jfif", "jp2", "jpe", "jxl", "jxr", "ktx", "ktx2", "mkv", "mov", "mp4", "pcx", "pdf", "pfm",
    "pic", "ps", "psb", "psd", "rgbe", "sgi", "svg", "svgz", "webm", "xcf",
];

/// Number of files of a pair that nobody has to look at: those of a format that is not read, with the same bytes on both sides,
/// or no picture and on one side only. 0 if the pair is to be compared.
fn files_of_no_interest(pair: &Pair) -> u64 {
    if !pair.unread || pair.problem.is_some() {
        return 0;
    }
    match (&pair.expected, &pair.actual) {
        (Some(expected), Some(actual)) if expected == actual => 1,
        (Some(expected), Some(actual)) if has_same_bytes(expected, actual).unwrap_or(false) => 2,
        (Some(_), Some(_)) => 0,
        _ => u64::from(!UNREAD_PICTURES.contains(&extension(&pair.relative).as_str())),
    }
}

/// Compares two regular files byte by byte; anything else is not the same.
fn has_same_bytes(a: &Path, b: &Path) -> std::io::Result<bool> {
    // Asked before opening, which would wait for a writer if one were a pipe.
    let (size, other) = (std::fs::metadata(a)?, std::fs::metadata(b)?);
    if !size.is_file() || !other.is_file() || size.len() != other.len() {
        return Ok(false);
    }
    let [mut a, mut b] = [BufReader::new(File::open(a)?), BufReader::new(File::open(b)?)];
    loop {
        let (left, right) = (a.fill_buf()?, b.fill_buf()?);
        let count = left.len().min(right.len());
        if left[..count] != right[..count] || count == 0 && left.len() != right.len() {
            return Ok(false);
        }
        if count == 0 {
            return Ok(true);
        }
        a.consume(count);
        b.consume(count);
    }
}

/// The extension of a file in lower case, empty if it has none.
pub(super) fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// The beginning of an extension behind its dot, and nothing for none.
pub(super) fn dotted(extension: &str) -> String {
    if extension.is_empty() { String::new() } else { format!(".{}", short(extension)) }
}

struct Found {
    name: String,
    relative: PathBuf,
    path: PathBuf,
    problem: Option<String>,
    unread: bool,
}

/// The files in a folder and the folders in it, without the threshold file.
fn list(root: &Path, limits: &Limits) -> Result<Vec<Found>, GoldenError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| GoldenError::Io { path, source }
    };
    let real_root = root.canonicalize().map_err(io(root))?;
    let mut found = Vec::new();
    let mut folders = vec![(root.to_owned(), PathBuf::new())];
    while let Some((folder, prefix)) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(io(&folder))? {
            let entry = entry.map_err(io(&folder))?;
            let (path, kind) = (entry.path(), entry.file_type().map_err(io(&entry.path()))?);
            let relative = prefix.join(entry.file_name());
            if kind.is_dir() {
                folders.push((path, relative));
                continue;
            }
            let count = (found.len() + folders.len()) as u64;
            Limits::check(|| format!("files in {}", root.display()), count, limits.nodes, "nodes")?;
            if relative == Path::new(THRESHOLDS) {
                continue;
            }
            let unread = !extensions().any(|known| known == extension(&path));
            let problem = kind.is_symlink().then(|| link_problem(&path, &real_root)).flatten();
            found.push(Found { name: name_of(&relative), relative, path, problem, unread });
        }
    }
    Ok(found)
}

/// The beginning of a long extension.
fn short(extension: &str) -> String {
    extension.chars().take(16).collect()
}

/// Reason that a link is not followed.
fn link_problem(path: &Path, real_root: &Path) -> Option<String> {
    match path.canonicalize() {
        Ok(target) if target.starts_with(real_root) => None,
        Ok(_) => Some("a symbolic link that leads out of its folder is not followed".to_owned()),
        Err(error) => Some(format!("a symbolic link that cannot be followed: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn names_pair_through_folders_and_new_files_stand_for_old_ones() {
        let root = tempfile::tempdir().unwrap();
        let (expected, actual) = (root.path().join("e"), root.path().join("a"));
        for (folder, name) in [
            (&expected, "x.png"),
            (&expected, "x.new.png"),
            (&expected, "deep/er/y.EXR"),
            (&expected, "notes.txt"),
            (&actual, "x.png"),
            (&actual, "x.new.png"),
            (&actual, "z.hdr"),
            (&expected, "thresholds.toml"),
        ] {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name).unwrap();
        }
        let pair = FolderPair::open(&expected, &actual, &Limits::default()).unwrap();
        let names: Vec<_> =
            pair.pairs.iter().map(|p| (p.name.as_str(), p.expected.is_some(), p.actual.is_some())).collect();
        assert_eq!(names, [("deep/er/y.EXR", true, false), ("x.png", true, true), ("z.hdr", false, true)]);
        assert!(pair.pairs[1].is_new);
        assert_eq!(pair.others_in_words().as_deref(), Some("1 file is not compared: 1 .txt"));
        assert_eq!(pair.pairs[1].actual.as_deref(), Some(actual.join("x.new.png").as_path()));

        let one = FolderPair::open(&expected, &expected, &Limits::default()).unwrap();
        assert!(one.pairs.iter().any(|p| p.name == "x.png" && p.is_new));
        for name in ["a.SVG", "b.svg", "LICENCE"] {
            fs::write(expected.join(name), name).unwrap();
        }
        let one = FolderPair::open(&expected, &expected, &Limits::default()).unwrap();
        let words = "4 files are not compared: 1 without extension, 2 .svg, 1 .txt";
        assert_eq!(one.others_in_words().as_deref(), Some(words));
        let limits = Limits::default().with_nodes(1);
        assert!(matches!(FolderPair::open(&expected, &actual, &limits), Err(GoldenError::Limit(_))));
        let file = expected.join("x.png");
        assert!(matches!(FolderPair::open(&file, &actual, &limits), Err(GoldenError::Mixed { .. })));
        assert!(FolderPair::open(&root.path().join("none"), &actual, &limits).is_err());
        assert_eq!(FolderPair::open(&file, &actual.join("z.hdr"), &limits).unwrap().pairs[0].name, "x.png");
    }

    #[test]
    fn what_is_not_read_is_a_pair_if_it_differs() {
        let root = tempfile::tempdir().unwrap();
        let (expected, actual) = (root.path().join("e"), root.path().join("a"));
        let long = "x".repeat(100_000);
        for (folder, name, text) in [
            (&expected, "same.svg", long.as_str()),
            (&actual, "same.svg", &long),
            (&expected, "longer.svg", &long),
            (&actual, "longer.svg", &long[1..]),
            (&expected, "other", &format!("{long}a")),
            (&actual, "other", &format!("{long}b")),
            (&expected, "readme.md", "x"),
            (&actual, "only.DDS", "x"),
            (&expected, "new.svg", "x"),
            (&actual, "new.new.svg", "y"),
        ] {
            fs::create_dir_all(folder).unwrap();
            fs::write(folder.join(name), text).unwrap();
        }
        let pair = FolderPair::open(&expected, &actual, &Limits::default()).unwrap();
        let names: Vec<_> = pair.pairs.iter().map(|p| (p.name.as_str(), p.unread)).collect();
        assert_eq!(names, [("longer.svg", true), ("new.svg", true), ("only.DDS", true), ("other", true)]);
        let words = "3 files are not compared: 1 .md, 2 .svg";
        assert_eq!(pair.others_in_words().as_deref(), Some(words));
    }

    #[cfg(unix)]
    #[test]
    fn links_do_not_lead_out() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("e");
        fs::create_dir_all(folder.join("in")).unwrap();
        fs::write(root.path().join("secret.png"), "x").unwrap();
        fs::write(folder.join("in/a.png"), "x").unwrap();
        symlink(root.path().join("secret.png"), folder.join("out.png")).unwrap();
        symlink(folder.join("in/a.png"), folder.join("b.png")).unwrap();
        symlink(folder.join("none"), folder.join("broken.png")).unwrap();
        symlink(&folder, folder.join("in/loop")).unwrap();
        let pairs = FolderPair::open(&folder, &folder, &Limits::default()).unwrap().pairs;
        let names: Vec<_> = pairs.iter().map(|p| (p.name.as_str(), p.problem.is_some())).collect();
        assert_eq!(names, [("b.png", false), ("broken.png", true), ("in/a.png", false), ("out.png", true)]);
        assert!(pairs.iter().all(|p| p.problem.is_none() || p.expected.is_none()));
    }
}
