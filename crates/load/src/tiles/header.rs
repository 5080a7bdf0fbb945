//! Headers of tiles, and the parts behind them.

use super::FORMAT;
use crate::LoadError;

/// Kind of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A model of several things (b3dm).
    Batched,
    /// A model at several places (i3dm).
    Instanced,
    /// A cloud of points (pnts).
    Points,
    /// Several tiles (cmpt).
    Composite,
}

impl Kind {
    /// The kind of a file by its first bytes.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        Some(match bytes.first_chunk()? {
            b"b3dm" => Self::Batched,
            b"i3dm" => Self::Instanced,
            b"pnts" => Self::Points,
            b"cmpt" => Self::Composite,
            _ => return None,
        })
    }
}

/// A tile in its parts.
pub(super) struct Tile<'a> {
    pub(super) kind: Kind,
    /// Text of the feature table, and what it refers to.
    pub(super) features: [&'a [u8]; 2],
    /// Behind the tables: a model, or tiles.
    pub(super) body: &'a [u8],
    /// Body of an instanced model that is a file of its own, and no name of one.
    pub(super) is_embedded: bool,
    /// Number of tiles within a composite.
    pub(super) count: u32,
    /// The file ends before the tile does.
    pub(super) is_cut: bool,
}

/// Bytes of the shortest header.
const LEAST: usize = 16;
/// Beginnings of batch tables and of models as numbers: a header that has them in its place is one of a draft.
const QUOTE: u32 = 0x2200_0000;

impl<'a> Tile<'a> {
    /// The tile at the beginning of some bytes, and what follows it.
    pub(super) fn read(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let Some(kind) = Kind::of(bytes) else {
            return Err(malformed("it begins with none of b3dm, i3dm, pnts and cmpt".to_owned()));
        };
        let word = |place: usize| Some(u32::from_le_bytes(*bytes.get(place..)?.first_chunk()?));
        let ends = || malformed("the file ends within the header of a tile".to_owned());
        let [version, length, first] = [4, 8, 12].map(word);
        let (version, length) = (version.ok_or_else(ends)?, length.ok_or_else(ends)? as usize);
        let first = first.ok_or_else(ends)?;
        if version != 1 {
            let message = format!("tiles of version {version}; version 1 is read");
            return Err(LoadError::unsupported(FORMAT, message));
        }
        if length < LEAST {
            return Err(malformed(format!("a tile of {length} bytes, less than its header has")));
        }
        let (own, after) = bytes.split_at_checked(length).unwrap_or((bytes, &[]));
        let is_cut = own.len() < length;
        let mut tile = Self { kind, features: [&[]; 2], body: &[], is_embedded: true, count: 0, is_cut };
        if kind == Kind::Composite {
            tile.count = first;
            tile.body = own.get(16..).unwrap_or_default();
            return Ok((tile, after));
        }
        let mut sizes =
            [first, word(16).ok_or_else(ends)?, word(20).ok_or_else(ends)?, word(24).ok_or_else(ends)?];
        let mut start = 28;
        if kind == Kind::Instanced {
            tile.is_embedded = word(28) == Some(1);
            start = 32;
        } else if kind == Kind::Batched && sizes.get(2) >= Some(&QUOTE) {
            // Drafts had a batch table alone, and the number of its rows before or behind its size.
            (sizes, start) = ([0, 0, sizes[1], 0], 20);
        } else if kind == Kind::Batched && sizes.get(3) >= Some(&QUOTE) {
            (sizes, start) = ([0, 0, sizes[0], sizes[1]], 24);
        }
        let mut rest = own.get(start..).unwrap_or_default();
        let mut parts = [&[][..]; 4];
        for (part, size) in parts.iter_mut().zip(sizes) {
            let ends = || malformed("the tables of a tile are longer than the tile".to_owned());
            (*part, rest) = rest.split_at_checked(size as usize).ok_or_else(ends)?;
        }
        let [text, binary, _, _] = parts;
        (tile.features, tile.body) = ([text, binary], rest);
        Ok((tile, after))
    }

    /// The model of the tile, without the padding behind it.
    pub(super) fn model(&self) -> &'a [u8] {
        let length = self.body.get(8..).and_then(|rest| rest.first_chunk()).map(|b| u32::from_le_bytes(*b));
        let is_container = self.body.starts_with(crate::gltf::MAGIC);
        let own = length.filter(|_| is_container).and_then(|length| self.body.get(..length as usize));
        own.unwrap_or(self.body)
    }
}
