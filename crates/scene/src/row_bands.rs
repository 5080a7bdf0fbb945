//! Row bands: mip levels of which only some rows are resident, in bands of eight.

use super::LevelLayout;

/// Rows of a band, as a power of two.
pub const BAND_SHIFT: u32 = 3;

/// Division of the rows of all mip levels into bands, one level after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BandLayout {
    levels: Vec<LevelLayout>,
    /// The first band of each level.
    firsts: Vec<u32>,
    /// Number of bands.
    count: usize,
}

/// Resident bands of a texture, and their offsets.
#[derive(Debug)]
pub struct RowBands {
    layout: BandLayout,
    /// A bit for each band, set if it is resident.
    present: Vec<u64>,
    /// Per-band offset: `offset + row * width + column`, with row and column in the level, indexes the resident
    /// texels. The bytes of an `i32`, little-endian; of no meaning for bands that are not resident.
    places: Vec<[u8; 4]>,
    /// Texels of all that are there.
    texels: usize,
}

impl BandLayout {
    /// Layout of these levels, the largest first.
    pub fn new(levels: &[LevelLayout]) -> Self {
        let mut count = 0;
        let mut first_of = |level: &LevelLayout| {
            let first = count;
            count += (level.height as usize).div_ceil(1 << BAND_SHIFT);
            first as u32
        };
        let firsts = levels.iter().map(&mut first_of).collect();
        Self { levels: levels.to_vec(), firsts, count }
    }

    /// Words of a bit for each band.
    pub fn words(&self) -> usize {
        self.count.div_ceil(64)
    }

    /// The bits of all bands.
    pub fn all(&self) -> impl Iterator<Item = u64> {
        let bits = |word: usize| match self.count - word * 64 {
            64.. => u64::MAX,
            rest => (1 << rest) - 1,
        };
        (0..self.words()).map(bits)
    }

    /// Texels of all bands.
    #[cfg(test)]
    pub(super) fn texels(&self) -> usize {
        self.levels.iter().map(|level| level.width as usize * level.height as usize).sum()
    }
}

/// Number of rows, from the top, of a level of `height` rows that `rows` of the next one are made of: two each, of an odd number three.
pub fn doubled(rows: u32, height: u32) -> u32 {
    rows.saturating_mul(2).saturating_add(u32::from(rows > 0)).min(height)
}

impl RowBands {
    /// Bands whose bit in `present` is set, and no others.
    pub fn new(layout: &BandLayout, mut present: Vec<u64>) -> Self {
        present.resize(layout.words(), 0);
        let mut places = vec![[0; 4]; layout.count];
        let mut texels = 0_usize;
        for (level, &first) in layout.levels.iter().zip(&layout.firsts) {
            let (width, height) = (level.width as usize, level.height as usize);
            for start in (0..height).step_by(1 << BAND_SHIFT) {
                let band = first as usize + (start >> BAND_SHIFT);
                if present[band / 64] >> (band % 64) & 1 == 1 {
                    // An image has fewer texels than 2^31.
                    places[band] = ((texels as i64 - (start * width) as i64) as i32).to_le_bytes();
                    texels += (height - start).min(1 << BAND_SHIFT) * width;
                }
            }
        }
        Self { layout: layout.clone(), present, places, texels }
    }

    /// Texels of all that are there.
    pub fn texels(&self) -> usize {
        self.texels
    }

    /// The levels, largest first.
    pub fn levels(&self) -> &[LevelLayout] {
        &self.layout.levels
    }

    /// True if all bands are resident.
    pub fn are_all(&self) -> bool {
        self.layout.all().eq(self.present.iter().copied())
    }

    /// The first band of a level.
    #[inline(always)]
    pub fn first(&self, level: usize) -> u32 {
        self.layout.firsts[level]
    }

    /// Offset of each band: `offset + row * width + column` indexes the resident texels; an `i32`, little-endian.
    #[inline(always)]
    pub fn places(&self) -> &[[u8; 4]] {
        &self.places
    }

    /// True if a band is resident.
    #[inline(always)]
    pub fn has(&self, band: u32) -> bool {
        self.present.get(band as usize / 64).is_some_and(|word| word >> (band % 64) & 1 == 1)
    }

    /// The finest level with resident rows.
    pub(super) fn finest(&self) -> Option<usize> {
        let bands = |level: &LevelLayout| level.height.div_ceil(1 << BAND_SHIFT);
        let BandLayout { levels, firsts, .. } = &self.layout;
        levels
            .iter()
            .zip(firsts)
            .position(|(level, first)| (0..bands(level)).any(|band| self.has(first + band)))
    }

    /// Number of image rows, from the top, that the resident rows depend on.
    pub fn source_rows(&self) -> u32 {
        let BandLayout { levels, firsts, .. } = &self.layout;
        let mut rows = 0_u32;
        for (k, (level, &first)) in levels.iter().zip(firsts).enumerate().rev() {
            let bands = level.height.div_ceil(1 << BAND_SHIFT);
            let own = (0..bands).rev().find(|band| self.has(first + band));
            let own = own.map_or(0, |band| (band + 1) << BAND_SHIFT).min(level.height);
            rows = if rows > own { rows } else { own };
            if let Some(finer) = k.checked_sub(1).and_then(|k| levels.get(k)) {
                rows = doubled(rows, finer.height);
            }
        }
        rows
    }

    /// A bit for each band, set if it is resident.
    pub(super) fn present(&self) -> &[u64] {
        &self.present
    }

    /// Index of the first texel of a level's row among the resident texels, if the row is resident.
    pub(super) fn place(&self, level: usize, row: u32) -> Option<usize> {
        let band = self.layout.firsts[level] + (row >> BAND_SHIFT);
        let place = i64::from(i32::from_le_bytes(self.places[band as usize]));
        let start = place + i64::from(row) * i64::from(self.layout.levels[level].width);
        self.has(band).then_some(start as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_that_are_there_follow_each_other() {
        let levels = [(20, 33), (10, 16), (5, 8), (1, 1)];
        let levels = levels.map(|(width, height)| LevelLayout { width, height, offset: 0 });
        let layout = BandLayout::new(&levels);
        assert_eq!((layout.count, layout.words(), layout.texels()), (9, 1, 861));
        // Of level 0 the second and the last, which has one row; the first of level 1; the last level.
        let bands = RowBands::new(&layout, vec![0b1_0011_0010]);
        let rows = |level: usize| (0..levels[level].height).map(move |row| (level, row));
        let mut next = 0;
        for (level, row) in (0..4).flat_map(rows) {
            let there = match level {
                0 => (8..16).contains(&row) || row == 32,
                1 => row < 8,
                2 => false,
                _ => true,
            };
            assert_eq!(bands.place(level, row), there.then_some(next), "{level} {row}");
            next += if there { levels[level].width as usize } else { 0 };
        }
        assert_eq!(bands.texels(), next);
        assert_eq!(RowBands::new(&layout, vec![]).texels(), 0);
        let rows = |bits: u64| RowBands::new(&layout, vec![bits]).source_rows();
        assert_eq!([0, 1, 0b10, 0b1_0000, 0b10_0000, 0b100_0000].map(rows), [0, 8, 16, 33, 17, 33]);
        assert_eq!([0b1000_0000, 0b1_0000_0000].map(rows), [33, 15]);
        let finest = |bits: u64| RowBands::new(&layout, vec![bits]).finest();
        assert_eq!([0, 0b10_0000, 0b1_1000_0000].map(finest), [None, Some(1), Some(2)]);
        assert_eq!(layout.all().collect::<Vec<_>>(), [0b1_1111_1111]);
        assert_eq!(RowBands::new(&layout, layout.all().collect()).texels(), layout.texels());
    }
}
