//! Formats of models in the texts of help, as the table of the loaders has them.
use overcoat_load::Format;

/// Usual extension of each format, behind a mark.
pub(super) fn extensions(mark: &str) -> Vec<String> {
    Format::ALL.iter().map(|format| format!("{mark}{}", format.extension())).collect()
}

/// Help for model files: a noun, the extensions, and what else may be given.
pub(super) fn model_files(noun: &str, others: &str) -> String {
    format!("{noun} ({}){others}", extensions(".").join(", "))
}
