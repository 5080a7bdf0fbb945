//! Splats to the light of the pixels of a tile, nearest first.

use super::ScreenSplat;
use crate::raster::BLOCK;
use overcoat_core::each;
use overcoat_core::math::exp_transmittance;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};

/// Part of the light from behind below which a pixel takes no more splats, as in the reference implementation.
pub const LEAST_TRANSMITTANCE: f32 = 1e-4;

/// Sixteen pixels.
#[derive(Clone, Debug)]
struct Block {
    /// Part of the light from behind that passes.
    transmittance: [f32; LANES],
    /// Sums of colour times opacity times what nearer splats let through.
    color: [[f32; LANES]; 3],
    /// The splat behind which less than half of the light passes.
    front: [i32; LANES],
    /// Pixels that take more splats.
    open: u16,
}

/// No splat.
const NONE: i32 = -1;

const CLEAR: Block =
    Block { transmittance: [1.0; LANES], color: [[0.0; LANES]; 3], front: [NONE; LANES], open: 0 };

/// The pixels of one tile while splats are drawn.
#[derive(Clone, Debug, Default)]
pub struct SplatTile {
    /// Blocks in a row.
    columns: usize,
    blocks: Vec<Block>,
    /// Blocks with pixels that take more splats.
    open: usize,
    /// Blocks that splats were drawn into since it was asked last.
    visited: u64,
    /// Pixels of the tile.
    size: [u32; 2],
    /// Column and row of its first pixel in the picture.
    corner: [u32; 2],
    /// Width and height of the picture.
    picture: [u32; 2],
}

/// Result of a pixel after all splats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatPixel {
    /// Column in the tile.
    pub column: u32,
    /// Row in the tile.
    pub row: u32,
    /// Linear premultiplied colour and opacity.
    pub color: [f32; 4],
    /// The splat behind which less than half of the light passes.
    pub front: Option<u32>,
}

impl SplatTile {
    /// Forgets everything: a tile of `size` pixels at `corner` of a picture, all of whose pixels take splats.
    pub fn clear(&mut self, corner: [u32; 2], size: [u32; 2], picture: [u32; 2]) {
        let [columns, rows] = size.map(|pixels| pixels.div_ceil(BLOCK as u32));
        self.columns = columns as usize;
        (self.size, self.corner, self.picture) = (size, corner, picture);
        self.blocks.clear();
        self.blocks.resize((columns * rows) as usize, CLEAR);
        self.open = self.blocks.len();
        for (number, block) in self.blocks.iter_mut().enumerate() {
            let first = [number % self.columns, number / self.columns].map(|k| (k * BLOCK) as u32);
            for lane in 0..LANES {
                let place = [first[0] + (lane % BLOCK) as u32, first[1] + (lane / BLOCK) as u32];
                block.open |= u16::from(place[0] < size[0] && place[1] < size[1]) << lane;
            }
        }
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        let more = other.blocks.capacity().saturating_sub(self.blocks.len());
        self.blocks.reserve_exact(more);
    }

    /// Leaves a pixel out: splats are drawn into it in another way.
    pub fn close(&mut self, column: u32, row: u32) {
        let block = &mut self.blocks[row as usize / BLOCK * self.columns + column as usize / BLOCK];
        let was_open = block.open != 0;
        block.open &= !(1 << (row as usize % BLOCK * BLOCK + column as usize % BLOCK));
        self.open -= usize::from(was_open && block.open == 0);
    }

    /// True if no pixel takes more splats.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.open == 0
    }

    /// Number of blocks that splats were drawn into since the last call: a measure of work that depends on nothing but
    /// the splats and the picture.
    pub fn take_visited(&mut self) -> u64 {
        std::mem::take(&mut self.visited)
    }

    /// Draws the next splat behind all that were drawn. `number` names it in [`SplatPixel::front`].
    #[inline(always)]
    pub fn draw<L: Lanes>(&mut self, l: L, splat: &ScreenSplat, number: u32) {
        let [left, top, right, bottom] = in_tile(splat, self.corner, self.size);
        if left >= right || top >= bottom {
            return;
        }
        let ellipse = Ellipse::new(l, splat);
        let first = first_pixels(l, self.corner, self.picture);
        for row in top / BLOCK..=(bottom - 1) / BLOCK {
            for column in left / BLOCK..=(right - 1) / BLOCK {
                let block = &mut self.blocks[row * self.columns + column];
                if block.open == 0 {
                    continue;
                }
                self.visited += 1;
                let exponent = ellipse.exponent(l, first, [column, row]);
                let inside = exponent.ge(ellipse.least) & l.mask(block.open);
                if !inside.any() {
                    continue;
                }
                let before = l.load(&block.transmittance);
                let part = inside.select(ellipse.opacity_at(l, exponent) * before, l.zero());
                let after = before - part;
                for (sum, color) in block.color.iter_mut().zip(splat.color) {
                    *sum = (l.load(sum) + part * color).to_array();
                }
                let half = l.splat(0.5);
                let halved = before.ge(half) & after.lt(half);
                if halved.any() {
                    let front = halved.select_i(l.splat_i(number as i32), l.load_i(&block.front));
                    block.front = front.to_array();
                }
                block.transmittance = after.to_array();
                block.open &= !after.lt(l.splat(LEAST_TRANSMITTANCE)).bits();
                self.open -= usize::from(block.open == 0);
            }
        }
    }

    /// Hands over every pixel that splats were drawn into. Colours become linear unless they are.
    #[inline(always)]
    pub fn finish<L: Lanes>(&self, l: L, is_linear: bool, mut take: impl FnMut(SplatPixel)) {
        for (number, block) in self.blocks.iter().enumerate() {
            if block.transmittance == [1.0; LANES] {
                continue;
            }
            let alpha = l.load(&block.transmittance).one_minus().saturate();
            let seen = alpha.gt(l.zero());
            let color: [L::F; 3] = each!(sum in block.color => {
                let sum = l.load(&sum);
                if is_linear { sum } else { srgb_to_linear_lanes(l, sum / alpha) * alpha }
            });
            let color = each!(c in color => c.to_array());
            let (seen, alpha) = (seen.bits(), alpha.to_array());
            for lane in 0..LANES {
                if seen >> lane & 1 == 1 {
                    take(SplatPixel {
                        column: (number % self.columns * BLOCK + lane % BLOCK) as u32,
                        row: (number / self.columns * BLOCK + lane / BLOCK) as u32,
                        color: [color[0][lane], color[1][lane], color[2][lane], alpha[lane]],
                        front: u32::try_from(block.front[lane]).ok(),
                    });
                }
            }
        }
    }
}

/// Calls `visit(column, row, opacity)` for the pixels of a row of blocks of a tile in which a splat is drawn, of those that
/// `wanted` names: sixteen bits for each block of the row.
#[inline(always)]
pub fn visit_row<L: Lanes>(
    l: L,
    splat: &ScreenSplat,
    [corner, size, picture]: [[u32; 2]; 3],
    row: usize,
    wanted: &[u16],
    mut visit: impl FnMut(u32, u32, f32),
) {
    let [left, top, right, bottom] = in_tile(splat, corner, size);
    if left >= right || top >= bottom || row < top / BLOCK || row > (bottom - 1) / BLOCK {
        return;
    }
    let ellipse = Ellipse::new(l, splat);
    let first = first_pixels(l, corner, picture);
    for column in left / BLOCK..=(right - 1) / BLOCK {
        let wanted = wanted[column];
        if wanted == 0 {
            continue;
        }
        let exponent = ellipse.exponent(l, first, [column, row]);
        let mut left = (exponent.ge(ellipse.least) & l.mask(wanted)).bits();
        if left == 0 {
            continue;
        }
        let opacity = ellipse.opacity_at(l, exponent).to_array();
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let place = [column * BLOCK + lane % BLOCK, row * BLOCK + lane / BLOCK];
            visit(place[0] as u32, place[1] as u32, opacity[lane]);
        }
    }
}

/// The pixels of a tile that a splat may reach: left, top, and the ends.
#[inline(always)]
fn in_tile(splat: &ScreenSplat, corner: [u32; 2], size: [u32; 2]) -> [usize; 4] {
    let [left, top, right, bottom] = splat.pixels.map(u32::from);
    let within = |v: u32, k: usize| v.saturating_sub(corner[k]).min(size[k]) as usize;
    [within(left, 0), within(top, 1), within(right, 0), within(bottom, 1)]
}

/// Centres of the pixels of a tile's first block, relative to the centre of the picture: exact.
#[inline(always)]
fn first_pixels<L: Lanes>(l: L, corner: [u32; 2], picture: [u32; 2]) -> [L::F; 2] {
    let lane = l.lane_indices();
    let start = |k: usize| corner[k] as f32 + 0.5 - picture[k] as f32 * 0.5;
    [(lane & 3).to_float() + start(0), lane.shr(2).to_float() + start(1)]
}

/// A splat in lanes.
struct Ellipse<L: Lanes> {
    center: [L::F; 2],
    shear: f32,
    scale: [f32; 2],
    least: L::F,
    opacity: f32,
}

impl<L: Lanes> Ellipse<L> {
    #[inline(always)]
    fn new(l: L, splat: &ScreenSplat) -> Self {
        Self {
            center: [l.splat(splat.center[0]), l.splat(splat.center[1])],
            shear: splat.shear,
            scale: splat.scale,
            least: l.splat(splat.least),
            opacity: splat.opacity,
        }
    }

    /// The exponent of the Gaussian at the pixels of a block, from those of the tile's first. Not a number where the splat is
    /// too far away for numbers; no comparison holds then.
    #[inline(always)]
    fn exponent(&self, l: L, first: [L::F; 2], block: [usize; 2]) -> L::F {
        let at = |k: usize| first[k] + l.splat((block[k] * BLOCK) as f32) - self.center[k];
        let (x, y) = (at(0), at(1));
        let (u, v) = ((x - y * self.shear) * self.scale[0], y * self.scale[1]);
        -(u * u + v * v)
    }

    /// The opacity for an exponent.
    #[inline(always)]
    fn opacity_at(&self, l: L, exponent: L::F) -> L::F {
        (exp_transmittance(l, exponent) * self.opacity).at_most(1.0)
    }
}

/// Display light, 0 and above, from an sRGB code divided by 255.
#[must_use]
pub fn srgb_to_linear(encoded: f32) -> f32 {
    let curve = overcoat_core::math::scalar::pow((encoded + 0.055) * (1.0 / 1.055), 2.4);
    if encoded <= 0.040_45 { encoded * (1.0 / 12.92) } else { curve }
}

/// [`srgb_to_linear`] in lanes.
#[inline(always)]
fn srgb_to_linear_lanes<L: Lanes>(l: L, encoded: L::F) -> L::F {
    let curve = overcoat_core::math::pow(l, (encoded + 0.055) * (1.0 / 1.055), l.splat(2.4));
    encoded.le(l.splat(0.040_45)).select(encoded * (1.0 / 12.92), curve)
}
