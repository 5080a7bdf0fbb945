//! Environments by the names that an operator gives them: requests name no files.

use super::offers::check_name;
use crate::common::read;
use crate::key::hash_of;
use overcoat::load::NamedEnvironment;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Environments by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Environments {
    /// Their files.
    pub files: BTreeMap<String, PathBuf>,
    /// BLAKE3 of their contents.
    pub hashes: BTreeMap<String, String>,
}

impl Environments {
    /// Environments of texts `NAME=FILE`, which are read once.
    ///
    /// # Errors
    /// One line that names the text.
    pub fn new(texts: &[String]) -> Result<Self, String> {
        let mut all = Self::default();
        for text in texts {
            all.add(text).map_err(|reason| format!("{text}: {reason}"))?;
        }
        Ok(all)
    }

    fn add(&mut self, text: &str) -> Result<(), String> {
        let (name, file) = text.split_once('=').ok_or("expected NAME=FILE")?;
        let name = name.trim();
        check_name(name)?;
        if NamedEnvironment::named(name).is_some() {
            return Err("this name has a meaning already".to_owned());
        }
        let path = std::fs::canonicalize(file).map_err(|e| e.to_string())?;
        self.hashes.insert(name.to_owned(), hash_of(&read(&path)?));
        match self.files.insert(name.to_owned(), path) {
            None => Ok(()),
            Some(_) => Err("there is another environment of this name".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_what_is_wrong_with_them() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.hdr");
        std::fs::write(&file, "x").unwrap();
        let of = |texts: &[&str]| {
            let path = file.to_str().unwrap();
            Environments::new(&texts.iter().map(|text| text.replace("@", path)).collect::<Vec<_>>())
        };
        let all = of(&["dawn=@", "dusk=@"]).unwrap();
        assert_eq!(all.files.keys().collect::<Vec<_>>(), ["dawn", "dusk"]);
        assert_eq!(all.hashes["dawn"], hash_of(b"x"));
        for (texts, what) in [
            (&["dawn"][..], "expected NAME=FILE"),
            (&["studio=@"], "has a meaning"),
            (&["sky=@"], "has a meaning"),
            (&["a/b=@"], "a/b=@"),
            (&["dawn=@.no"], "dawn=@.no: "),
            (&["dawn=@", "dawn=@"], "another environment"),
        ] {
            let error = of(texts).unwrap_err();
            assert!(error.contains(&what.replace('@', file.to_str().unwrap())), "{error}");
        }
    }
}
