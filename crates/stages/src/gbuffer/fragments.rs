//! Visible surfaces of each pixel of a tile.

use super::merge::Merger;
use super::{Draw, TriangleSource};
use crate::raster::{BLOCK, NO_TRIANGLE, SamplePattern, VisibilityBuffer};
use overcoat_core::each;
use overcoat_core::math::lanes::{Int, LANES, Lanes, Mask};

/// The part of one pixel that sees one triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fragment {
    /// Identity of the triangle in its tile.
    pub triangle: u32,
    /// Row * 64 + column of the pixel in its tile.
    pub pixel: u16,
    /// The samples that see it.
    pub mask: u16,
}

impl Fragment {
    /// The number that names a pixel of a tile.
    #[inline(always)]
    #[must_use]
    pub fn pixel_at(column: u32, row: u32) -> u16 {
        (row * 64 + column) as u16
    }
    /// Column in the tile.
    #[inline(always)]
    #[must_use]
    pub fn column(&self) -> u32 {
        u32::from(self.pixel) & 63
    }
    /// Row in the tile.
    #[inline(always)]
    #[must_use]
    pub fn row(&self) -> u32 {
        u32::from(self.pixel) >> 6
    }
}

/// One triangle of each pixel of a block, and the samples that see it: none where a pixel has no further triangle.
#[derive(Clone, Copy)]
struct Round {
    triangle: [i32; LANES],
    mask: [i32; LANES],
}

/// The most samples of a pixel, and so the most triangles.
const MAX_ROUNDS: usize = 16;

/// Lists what the pixels of a tile of `width` x `height` pixels see: block by block, within a block pixel by pixel,
/// within a pixel in the order of the lowest sample. This is the order in which fragments are summed. With
/// `merge_by`, which holds the least square of a cosine between normals, small triangles of one surface share a fragment.
#[inline(always)]
pub fn extract_fragments<'a, L: Lanes>(
    l: L,
    buffer: &VisibilityBuffer,
    width: u32,
    height: u32,
    samples: usize,
    merge_by: Option<(&'a impl TriangleSource, &'a [Draw<'a>], f32)>,
    out: &mut Vec<Fragment>,
) {
    let none = l.splat_i(NO_TRIANGLE as i32);
    let full = ((1_u32 << samples) - 1) as u16;
    let mut merger = match merge_by {
        Some((source, draws, least_squared_cosine)) => Some(Merger::new(source, draws, least_squared_cosine)),
        None => None,
    };
    let mut rounds = [Round { triangle: [0; LANES], mask: [0; LANES] }; MAX_ROUNDS];
    for block in 0..buffer.block_count() {
        let seen = buffer.block_triangles(block);
        let first = l.load_i(&seen[0]);
        let empty = first.eq(none);
        // Pixels in which all samples see the same.
        let mut same = l.mask(u16::MAX);
        for sample in &seen[1..] {
            same = same & l.load_i(sample).eq(first);
        }
        let (same, empty) = (same.bits(), empty.bits());
        if same & empty == u16::MAX {
            continue;
        }
        let column = (block % buffer.block_columns() * BLOCK) as u32;
        let row = (block / buffer.block_columns() * BLOCK) as u32;
        let corner = Fragment::pixel_at(column, row);
        let inside = inside(width - column, height - row);
        let whole =
            |k: usize| Fragment { triangle: seen[0][k] as u32, pixel: corner + pixel_of(k), mask: full };
        if same & !empty & inside == u16::MAX {
            // One check for all sixteen.
            let pixels: [Fragment; LANES] = each!(k => whole(k));
            out.extend_from_slice(&pixels);
            continue;
        }
        let count = if same == u16::MAX { 0 } else { list_rounds(l, seen, full, &mut rounds) };
        let mut remaining = inside & !(same & empty);
        while remaining != 0 {
            let k = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            if same >> k & 1 == 1 {
                out.push(whole(k));
                continue;
            }
            let first_found = out.len();
            for Round { triangle, mask } in &rounds[..count] {
                if mask[k] == 0 {
                    break;
                }
                if triangle[k] != NO_TRIANGLE as i32 {
                    let (triangle, mask) = (triangle[k] as u32, mask[k] as u16);
                    out.push(Fragment { triangle, pixel: corner + pixel_of(k), mask });
                }
            }
            if let Some(merger) = &mut merger {
                merger.merge(out, first_found);
            }
        }
    }
}

/// The number of a block's pixel relative to that of its first.
#[inline(always)]
fn pixel_of(k: usize) -> u16 {
    Fragment::pixel_at((k % BLOCK) as u32, (k / BLOCK) as u32)
}

/// The pixels of a block that lie in the tile, by bits, where that many columns and rows follow from the block's first on.
#[inline(always)]
fn inside(columns: u32, rows: u32) -> u16 {
    let row = if columns < BLOCK as u32 { (1_u32 << columns) - 1 } else { 0xf };
    let all = row * 0x1111;
    (if rows < BLOCK as u32 { all & ((1 << (rows * BLOCK as u32)) - 1) } else { all }) as u16
}

/// Lists the triangles of the sixteen pixels of a block in the order of their lowest sample. Returns the number of
/// rounds that it takes.
#[inline(always)]
fn list_rounds<L: Lanes>(l: L, seen: &[[i32; LANES]], full: u16, rounds: &mut [Round; MAX_ROUNDS]) -> usize {
    let zero = l.splat_i(0);
    let mut remaining = l.splat_i(i32::from(full));
    let mut triangle = l.load_i(&seen[0]);
    let mut count = 0;
    for round in rounds {
        let mut mask = zero;
        for (bit, sample) in seen.iter().enumerate() {
            mask = mask | l.load_i(sample).eq(triangle).select_i(l.splat_i(1 << bit), zero);
        }
        mask = mask & remaining;
        remaining = remaining ^ mask;
        *round = Round { triangle: triangle.to_array(), mask: mask.to_array() };
        count += 1;
        if remaining.eq(zero).all() {
            break;
        }
        for (bit, sample) in seen.iter().enumerate().rev() {
            triangle = (remaining & (1 << bit)).eq(zero).select_i(triangle, l.load_i(sample));
        }
    }
    count
}

/// Lists the pixels of one block that see a triangle, given their sample masks, within a rectangle of the tile: left, top,
/// and the ends. With a pattern each is split by its groups of samples.
#[inline(always)]
pub fn push_masked_fragments(
    triangle: u32,
    column: i32,
    row: i32,
    masks: &[u16; LANES],
    split: Option<&SamplePattern>,
    [left, top, right, bottom]: [u32; 4],
    out: &mut Vec<Fragment>,
) {
    for (k, &mask) in masks.iter().enumerate() {
        let (x, y) = (column as u32 + (k % BLOCK) as u32, row as u32 + (k / BLOCK) as u32);
        if mask != 0 && x >= left && x < right && y >= top && y < bottom {
            let fragment = |mask| Fragment { triangle, pixel: Fragment::pixel_at(x, y), mask };
            match split {
                Some(pattern) => out.extend(pattern.parts(mask).map(fragment)),
                None => out.push(fragment(mask)),
            }
        }
    }
}
