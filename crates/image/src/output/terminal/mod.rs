//! Pictures that a terminal shows: what is written to it in place of a file.
//!
//! All of them end with a line feed and with the terminal's own colours. Kitty's graphics have all of a picture; the others
//! have pixels that are there or not, from half of the opacity on.

mod blocks;
mod kitty;
mod sixel;

use super::{DisplayImage, OutputError};
use std::fmt;

/// Protocol by which a picture is sent to a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TerminalFormat {
    /// The graphics protocol of kitty: a PNG, with its opacity.
    Kitty,
    /// Sixel graphics as of the VT340, of 256 colours at most.
    Sixel,
    /// Upper and lower half blocks in 24-bit colours, two pixels a cell: for terminals without graphics.
    Blocks,
}

impl TerminalFormat {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Kitty, Self::Sixel, Self::Blocks];

    /// Its name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kitty => "kitty",
            Self::Sixel => "sixel",
            Self::Blocks => "blocks",
        }
    }

    /// The one of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.name() == name)
    }

    /// True where a part of a pixel can be covered; else pixels are there or not.
    #[must_use]
    pub fn has_opacity(self) -> bool {
        self == Self::Kitty
    }

    /// Columns and rows of pixels in a cell of a terminal whose cells have so many pixels.
    #[must_use]
    pub fn cell(self, pixels: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Kitty | Self::Sixel => pixels,
            Self::Blocks => [1, 2],
        }
    }
}

impl fmt::Display for TerminalFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Encodes a picture as the bytes that show it at the cursor of a terminal.
///
/// # Errors
/// [`OutputError::Terminal`] if the picture is empty.
pub fn encode_terminal(image: &DisplayImage, format: TerminalFormat) -> Result<Vec<u8>, OutputError> {
    let pixels = image.width as usize * image.height as usize;
    if pixels == 0 || image.pixels.len() != pixels {
        let reason =
            format!("{} pixels for a picture of {} x {}", image.pixels.len(), image.width, image.height);
        return Err(OutputError::Terminal { format, reason });
    }
    match format {
        TerminalFormat::Kitty => kitty::encode(image),
        TerminalFormat::Sixel => Ok(sixel::encode(image)),
        TerminalFormat::Blocks => Ok(blocks::encode(image)),
    }
}

/// The colour of a pixel that is there, where pixels are there or not: a part of one cannot be shown over a background that
/// only the terminal knows.
fn shown([r, g, b, a]: [u8; 4]) -> Option<[u8; 3]> {
    (a >= 128).then_some([r, g, b])
}
