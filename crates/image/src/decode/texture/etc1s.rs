//! Blocks of ETC1S, as blocks of ETC1 of eight bytes (Khronos Data Format Specification, "ETC1 Compressed Texture Image Formats"):
//! one colour of 5 bits a channel, and one table of what is added to it.

/// Bytes of a block.
pub const BLOCK: usize = 8;

/// Offsets that a block adds to its base colour, from the darkest to the brightest.
const TABLES: [[i16; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

/// Place in a table by the bits of a texel: the higher one is the sign, the lower one the size.
const PLACES: [usize; 4] = [2, 3, 1, 0];

/// The texels of a block, row by row.
pub fn texels(block: [u8; BLOCK]) -> [[[u8; 3]; 4]; 4] {
    let [r, g, b, kind, high @ .., _, _] = block;
    let [.., low_first, low_second] = block;
    let table = TABLES.get(usize::from(kind >> 5)).copied().unwrap_or_default();
    let color = [r, g, b].map(|v| {
        let five = v >> 3;
        i16::from(five << 3 | five >> 2)
    });
    let colors = table
        .map(|more| color.map(|v| u8::try_from(v.saturating_add(more).clamp(0, 255)).unwrap_or(u8::MAX)));
    let (high, low) = (u16::from_be_bytes(high), u16::from_be_bytes([low_first, low_second]));
    let mut texels = [[[0; 3]; 4]; 4];
    for (y, row) in texels.iter_mut().enumerate() {
        for (x, texel) in row.iter_mut().enumerate() {
            // Columns follow each other.
            let bit = x.saturating_mul(4).saturating_add(y);
            let code = (high >> bit & 1) << 1 | low >> bit & 1;
            let place = PLACES.get(usize::from(code)).copied().unwrap_or(0);
            *texel = colors.get(place).copied().unwrap_or_default();
        }
    }
    texels
}

/// Four rows of texels of a row of blocks, with the green of another as their alpha.
pub fn row_of_blocks(blocks: &[u8], alpha: Option<&[u8]>, width: usize, rows: &mut [[u8; 4]]) {
    let mut of_alpha = alpha.map(|alpha| alpha.as_chunks::<BLOCK>().0.iter());
    for (column, block) in blocks.as_chunks::<BLOCK>().0.iter().enumerate() {
        let opacity = of_alpha.as_mut().and_then(Iterator::next).map(|block| texels(*block));
        for (y, (row, line)) in rows.chunks_mut(width).zip(texels(*block)).enumerate() {
            let Some(row) = row.chunks_mut(4).nth(column) else { break };
            for (x, (texel, [r, g, b])) in row.iter_mut().zip(line).enumerate() {
                let a = opacity.and_then(|opacity| opacity.get(y)?.get(x).copied());
                *texel = [r, g, b, a.map_or(255, |[_, green, _]| green)];
            }
        }
    }
}
