//! What of a file is loaded, where it offers a choice.

use super::LoadError;

/// Choices among what a file offers. The default is what the file shows by itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Material variant of a glTF file (KHR_materials_variants), by its name or, where none is called so, by its number
    /// from 0. Default: the materials that the primitives name themselves.
    pub variant: Option<String>,
}

impl LoadOptions {
    /// For formats that offer no choices.
    ///
    /// # Errors
    /// [`LoadError::NoSuch`] if something is chosen.
    pub(super) fn refuse(&self) -> Result<(), LoadError> {
        match &self.variant {
            Some(variant) => Err(LoadError::no_such(format!(
                "there is no material variant '{variant}': files of this format have none"
            ))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_without_choices_refuse_one() {
        LoadOptions::default().refuse().unwrap();
        let error = LoadOptions { variant: Some("a\nb".into()) }.refuse().unwrap_err().to_string();
        assert!(error.starts_with("there is no material variant 'a\u{fffd}b'"), "{error}");
    }
}
