//! JPEG files as textures need them: row by row, and at halves, quarters and eighths of their size, without the picture as a whole.
//!
//! A half of a picture has the means of 2 x 2 of its samples, made of the coefficients ([`transform`]) in a quarter of the time. Rows
//! of several sizes come from one pass over the file. One row of blocks is in memory at a time, of progressive files too ([`scan`]).
//!
//! Read are files of Huffman codes and 8 bits, grey or YCbCr (ITU-T T.81; colours as ITU-T T.871 has them), with chroma at all or
//! half of the columns and rows: what cameras and programs write. The others, and files that are damaged, are left to the `image`
//! crate, which makes do with more.

mod bits;
mod halves;
mod header;
mod plane;
mod rows;
mod scan;
mod transform;

use header::Frame;

/// Halvings of its size at which a picture is read at most: a block becomes one texel.
const MOST_HALVINGS: u32 = 3;

/// A file whose segments have been found sound.
#[derive(Clone, Debug)]
pub struct Jpeg<'a> {
    frame: Frame<'a>,
}

impl<'a> Jpeg<'a> {
    /// Reads the segments. `None` if the file is not one of those that are read here.
    pub fn open(bytes: &'a [u8]) -> Option<Self> {
        Some(Self { frame: header::read(bytes)? })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.frame.size
    }

    /// Number of times that the size can be halved while decoding: to whole numbers.
    pub fn halvings(&self) -> u32 {
        self.size().into_iter().map(u32::trailing_zeros).fold(MOST_HALVINGS, u32::min)
    }
}

#[cfg(test)]
mod tests;
