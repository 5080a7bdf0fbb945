//! Which surfaces each pixel of a tile sees.

use super::merge::merge;
use super::{Draw, TriangleSource};
use crate::math::lanes::LANES;
use crate::raster::{BLOCK, NO_TRIANGLE, Visibility};

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

/// Lists what the pixels of a tile of `width` x `height` pixels see: block by block, within a block pixel by pixel,
/// within a pixel in the order of the lowest sample. This is the order in which fragments are summed. With
/// `merge_by`, which holds the least square of a cosine between normals, small triangles of one surface share a fragment.
pub fn extract_fragments(
    visibility: &Visibility,
    width: u32,
    height: u32,
    samples: usize,
    merge_by: Option<(&impl TriangleSource, &[Draw<'_>], f32)>,
    out: &mut Vec<Fragment>,
) {
    const NONE: i32 = NO_TRIANGLE as i32;
    let full = ((1_u32 << samples) - 1) as u16;
    for block in 0..visibility.block_count() {
        let seen = visibility.block_triangles(block);
        let first = &seen[0];
        // Lanes in which all samples see the same, as a difference of bits that is zero.
        let mut difference = [0_i32; LANES];
        let mut any = 0_i32;
        for sample in seen {
            for k in 0..LANES {
                difference[k] |= sample[k] ^ first[k];
                any |= !sample[k];
            }
        }
        if any == 0 {
            continue;
        }
        let column = (block % visibility.block_columns() * BLOCK) as u32;
        let row = (block / visibility.block_columns() * BLOCK) as u32;
        for k in 0..LANES {
            let (x, y) = (column + (k % BLOCK) as u32, row + (k / BLOCK) as u32);
            if x >= width || y >= height {
                continue;
            }
            let pixel = Fragment::pixel_at(x, y);
            if difference[k] == 0 {
                if first[k] != NONE {
                    out.push(Fragment { triangle: first[k] as u32, pixel, mask: full });
                }
                continue;
            }
            let first_found = out.len();
            let mut left = full;
            while left != 0 {
                let triangle = seen[left.trailing_zeros() as usize][k];
                let mut mask = 0;
                for (s, sample) in seen.iter().enumerate() {
                    mask |= u16::from(sample[k] == triangle) << s;
                }
                left &= !mask;
                if triangle != NONE {
                    out.push(Fragment { triangle: triangle as u32, pixel, mask });
                }
            }
            if let Some((source, draws, least_squared_cosine)) = merge_by {
                merge(out, first_found, source, draws, least_squared_cosine);
            }
        }
    }
}

/// Lists the pixels of one block that see a triangle, given their sample masks, within a rectangle of the tile: left, top,
/// and the ends.
#[inline(always)]
pub fn push_masked_fragments(
    triangle: u32,
    column: i32,
    row: i32,
    masks: &[u16; LANES],
    [left, top, right, bottom]: [u32; 4],
    out: &mut Vec<Fragment>,
) {
    for (k, &mask) in masks.iter().enumerate() {
        let (x, y) = (column as u32 + (k % BLOCK) as u32, row as u32 + (k / BLOCK) as u32);
        if mask != 0 && x >= left && x < right && y >= top && y < bottom {
            out.push(Fragment { triangle, pixel: Fragment::pixel_at(x, y), mask });
        }
    }
}
