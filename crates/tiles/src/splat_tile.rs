//! Splats in a tile: alone in most pixels, among surfaces in others.
//!
//! Where no surface is, sixteen pixels take a splat at once. Where one is, the splats of each pixel are listed, hidden sample
//! by sample by what is opaque and nearer than their centres, and blended with the surfaces in the order of depth.

use super::aov::TileAovs;
use super::pass::{Pass, Tile};
use super::resolve::{Behind, TilePixels};
use super::splat_layers::{LayerPixel, SplatLayer, blend_layers};
use super::splats::SplatScene;
use super::tile_shading::ShadedFragment;
use super::work::Spent;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::raster::{BLOCK, VisibilityBuffer};
use overcoat_stages::splat::{LEAST_TRANSMITTANCE, SplatPixel, SplatTile, visit_row};

/// Number of splats by which prefetching runs ahead.
const SPLATS_AHEAD: usize = 8;

/// Pixels in a row of blocks of the largest tile.
const PIXELS_OF_ROW: usize = 64 * BLOCK;

/// The surfaces of a part of a tile.
pub struct Surfaces<'a> {
    /// The part: left, top, and the ends.
    pub part: [u32; 4],
    pub visibility_buffer: &'a VisibilityBuffer,
    pub fragments: &'a [Fragment],
    pub shaded: &'a [ShadedFragment],
    /// Number of opaque fragments: the first in the list.
    pub opaque: usize,
    /// The other fragments sorted by pixel, farthest first.
    pub blended: &'a [u32],
    pub behind: Behind<'a>,
}

/// Working memory of one thread.
#[derive(Debug, Default)]
pub struct SplatScratch {
    tile: SplatTile,
    /// Pixels with surfaces, block by block.
    covered: Vec<u16>,
    /// Opaque fragments: pixel and index.
    behind: Vec<(u16, u32)>,
    layers: Vec<SplatLayer>,
    /// Transmittance of the splats in each pixel of a row of blocks.
    open: Vec<f32>,
}

impl SplatScratch {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        self.tile.reserve_like(&other.tile);
        reserve_like(&mut self.covered, &other.covered);
        reserve_like(&mut self.behind, &other.behind);
        reserve_like(&mut self.layers, &other.layers);
        reserve_like(&mut self.open, &other.open);
    }

    /// Begins a tile.
    pub fn start(&mut self, pass: &Pass<'_>, place: &Tile<'_>) {
        self.tile.clear(place.corner, place.size, [pass.frame.grid.width(), pass.frame.grid.height()]);
    }

    /// Draws the splats of pixels without surfaces. Returns the number of blocks that were drawn into.
    #[inline(never)]
    pub fn draw_alone<L: Lanes>(
        &mut self,
        l: L,
        pass: &Pass<'_>,
        place: &Tile<'_>,
        pixels: &mut TilePixels,
        aovs: &mut TileAovs,
    ) -> u64 {
        // A function of its own, apart from all that shading is.
        l.run(
            #[inline(always)]
            || {
                let splats = &pass.frame.splats;
                let mut blocks = 0;
                for run in place.splats() {
                    let numbers = splats.numbers(run);
                    for (k, &number) in numbers.iter().enumerate() {
                        if let Some(&later) = numbers.get(k + SPLATS_AHEAD) {
                            splats.prefetch(later);
                        }
                        self.tile.draw(l, splats.splat(number), number);
                    }
                    let visited = self.tile.take_visited();
                    blocks += visited;
                    if !pass.work.spend(Spent::Blocks, visited) {
                        return blocks;
                    }
                    if self.tile.is_full() {
                        break;
                    }
                }
                if pass.only_counts() {
                    return blocks;
                }
                self.tile.finish(
                    l,
                    splats.is_linear,
                    #[inline(always)]
                    |SplatPixel { column, row, color, front }| {
                        let index = row as usize * pixels.width + column as usize;
                        pixels.linear[index] = color;
                        if let Some(open) = pixels.transmittance.get_mut(index) {
                            *open = [1.0 - color[3]; 3];
                        }
                        let front = front.map(|number| splats.splat(number));
                        aovs.add_splats(
                            index,
                            color[3],
                            front.map(|splat| (splats.distance(splat), splat.object)),
                        );
                    },
                );
                blocks
            },
        )
    }

    /// Draws the splats of those pixels of a part of the tile that have surfaces, and leaves these pixels out of [`SplatScratch::draw_alone`]. False if a limit stops it.
    #[inline(never)]
    pub fn draw_among<L: Lanes>(
        &mut self,
        l: L,
        pass: &Pass<'_>,
        place: &Tile<'_>,
        surfaces: &Surfaces<'_>,
        pixels: &mut TilePixels,
        aovs: &mut TileAovs,
    ) -> bool {
        // A function of its own, apart from all that shading is.
        l.run(
            #[inline(always)]
            || {
                let [left, top, right, bottom] = surfaces.part;
                let [columns, rows] = place.size.map(|pixels| pixels.div_ceil(BLOCK as u32) as usize);
                self.covered.clear();
                self.covered.resize(columns * rows, 0);
                self.behind.clear();
                for (index, fragment) in surfaces.fragments.iter().enumerate() {
                    let (column, row) = (fragment.column(), fragment.row());
                    if column < left || column >= right || row < top || row >= bottom {
                        continue;
                    }
                    let block = row as usize / BLOCK * columns + column as usize / BLOCK;
                    self.covered[block] |= 1 << (row as usize % BLOCK * BLOCK + column as usize % BLOCK);
                    self.tile.close(column, row);
                    if index < surfaces.opaque {
                        self.behind.push((fragment.pixel, index as u32));
                    }
                }
                self.behind.sort_unstable();
                for row in 0..rows {
                    if self.covered[row * columns..][..columns].iter().any(|&bits| bits != 0) {
                        let listed = self.list_row(l, pass, place, surfaces.visibility_buffer, row, columns);
                        if !pass.work.spend(Spent::Blended, listed) {
                            return false;
                        }
                        if !pass.only_counts() {
                            self.blend_row(pass, surfaces, pixels, aovs);
                        }
                    }
                }
                true
            },
        )
    }

    /// Lists the splats of the covered pixels of a row of blocks. Returns their number.
    #[inline(always)]
    fn list_row<L: Lanes>(
        &mut self,
        l: L,
        pass: &Pass<'_>,
        place: &Tile<'_>,
        visibility_buffer: &VisibilityBuffer,
        row: usize,
        columns: usize,
    ) -> u64 {
        let Self { covered, layers, open, .. } = self;
        let splats = &pass.frame.splats;
        let picture = [pass.frame.grid.width(), pass.frame.grid.height()];
        layers.clear();
        open.clear();
        open.resize(PIXELS_OF_ROW, 1.0);
        let all = pass.frame.pattern.full_mask();
        let wanted = &covered[row * columns..][..columns];
        for number in place.splats().iter().flat_map(|run| splats.numbers(run)).copied() {
            let splat = splats.splat(number);
            visit_row(
                l,
                splat,
                [place.corner, place.size, picture],
                row,
                wanted,
                #[inline(always)]
                |x, y, alpha| {
                    let open = &mut open[y as usize % BLOCK * 64 + x as usize];
                    if *open < LEAST_TRANSMITTANCE {
                        return;
                    }
                    let center =
                        |k: usize, at: u32| (place.corner[k] + at) as f32 + 0.5 - picture[k] as f32 * 0.5;
                    let depth = splats.depth(splat, [center(0, x), center(1, y)]);
                    let block = row * columns + x as usize / BLOCK;
                    let lane = y as usize % BLOCK * BLOCK + x as usize % BLOCK;
                    let mut mask = 0;
                    for (sample, nearest) in visibility_buffer.block_depths(block).iter().enumerate() {
                        mask |= u16::from(depth > nearest[lane]) << sample;
                    }
                    if mask == 0 {
                        return;
                    }
                    if mask == all {
                        *open -= *open * alpha;
                    }
                    let place = layers.len() as u32;
                    layers.push(SplatLayer {
                        pixel: Fragment::pixel_at(x, y),
                        mask,
                        place,
                        alpha,
                        depth,
                        number,
                    });
                },
            );
        }
        layers.sort_unstable_by_key(|layer| (layer.pixel, layer.place));
        layers.len() as u64
    }

    /// Blends the listed splats with the surfaces of their pixels.
    fn blend_row(
        &self,
        pass: &Pass<'_>,
        surfaces: &Surfaces<'_>,
        pixels: &mut TilePixels,
        aovs: &mut TileAovs,
    ) {
        let samples = pass.frame.pattern.len();
        let pixel_of = |k: u32| surfaces.fragments[k as usize].pixel;
        for layers in self.layers.chunk_by(|a, b| a.pixel == b.pixel) {
            let pixel = layers[0].pixel;
            let (row, column) = (usize::from(pixel) / 64, usize::from(pixel) % 64);
            let index = row * pixels.width + column;
            let first = surfaces.blended.partition_point(|&k| pixel_of(k) < pixel);
            let end = surfaces.blended.partition_point(|&k| pixel_of(k) <= pixel);
            let behind_first = self.behind.partition_point(|b| b.0 < pixel);
            let behind_end = self.behind.partition_point(|b| b.0 <= pixel);
            let (color, open) = blend_layers(&LayerPixel {
                samples,
                index,
                splats: &pass.frame.splats,
                layers,
                blended: &surfaces.blended[first..end],
                opaque: &self.behind[behind_first..behind_end],
                surfaces,
            });
            if let Some(transmittance) = pixels.transmittance.get_mut(index) {
                *transmittance = open;
            }
            let opacity = 1.0 - (open[0] + open[1] + open[2]) * (1.0 / 3.0);
            let opacity = if opacity > 0.0 { opacity } else { 0.0 };
            pixels.linear[index] = [color[0], color[1], color[2], opacity];
            if aovs.is_wanted() {
                let (coverage, front) = seen(&pass.frame.splats, samples, layers);
                aovs.add_splats(index, coverage, front);
            }
        }
    }
}

/// The part of a pixel that splats cover, and distance and object of the one behind which less than half of the light passes.
fn seen(splats: &SplatScene<'_>, samples: usize, layers: &[SplatLayer]) -> (f32, Option<(f32, u32)>) {
    let (mut open, mut front) = (1.0, None);
    for layer in layers {
        let before = open;
        open -= open * (layer.alpha * layer.mask.count_ones() as f32 / samples as f32);
        if before >= 0.5 && open < 0.5 {
            let splat = splats.splat(layer.number);
            front = Some((splats.distance(splat), splat.object));
        }
    }
    (1.0 - open, front)
}
