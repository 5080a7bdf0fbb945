//! Output formats of `overcoat render`: of files, and of what a terminal shows.

use overcoat_image::output::{OutputFormat, TerminalFormat};
use std::fmt;

/// A format of one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Format of a file.
    File(OutputFormat),
    /// Format that a terminal shows.
    Terminal(TerminalFormat),
}

impl PictureFormat {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let files = OutputFormat::ALL.iter().copied().map(Self::File);
        files.chain(TerminalFormat::ALL.iter().copied().map(Self::Terminal))
    }

    /// The name for `--output-format`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::File(format) => format.extension(),
            Self::Terminal(format) => format.name(),
        }
    }

    /// The one of this name, or of this extension in whatever case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let file = OutputFormat::from_extension(name).map(Self::File);
        file.or_else(|| TerminalFormat::from_name(name).map(Self::Terminal))
    }

    /// True for linear light.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::File(format) if format.is_linear())
    }

    /// The format for terminals, if it is one.
    #[must_use]
    pub fn terminal(self) -> Option<TerminalFormat> {
        match self {
            Self::File(_) => None,
            Self::Terminal(format) => Some(format),
        }
    }
}

impl fmt::Display for PictureFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
