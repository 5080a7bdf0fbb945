//! The visibility buffer of one tile: nearest depth and triangle of every sample.

use super::{
    BLOCK, Disc, EdgeFunctions, FewPixels, SUBPIXEL_BITS, SUBPIXELS, SamplePattern, SmallSamples, TileOrigin,
    Triangle,
};
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};
use overcoat_core::reuse::reserve_like;

/// The identity of "no surface".
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Depth and triangle of every sample of a tile, block by block, sample by sample, sixteen pixels a vector.
#[derive(Clone, Debug, Default)]
pub struct VisibilityBuffer {
    /// Blocks in a row.
    columns: usize,
    /// Samples a pixel.
    samples: usize,
    depth: Vec<[f32; LANES]>,
    triangle: Vec<[i32; LANES]>,
    /// For each block, a depth that every sample of it has reached: what is not nearer is hidden.
    block_depth: Vec<f32>,
    /// Blocks that triangles were drawn into since it was asked last.
    visited: u64,
    /// Pixels of the tile.
    width: i32,
    height: i32,
}

/// The part of a triangle that one sample of one block sees.
struct BlockSpan {
    /// Column of the block's first pixel.
    column: i32,
    /// Row of the block's first pixel.
    row: i32,
    /// No sample of the block lies outside.
    full: bool,
}

impl VisibilityBuffer {
    /// Forgets everything: `width` x `height` pixels (up to 64 each) of `samples` samples, without a surface. Only what is nearer than
    /// `depth` is drawn, minus infinity for all.
    pub fn clear(&mut self, width: usize, height: usize, samples: usize, depth: f32) {
        self.columns = width.div_ceil(BLOCK);
        self.samples = samples;
        (self.width, self.height) = (width as i32, height as i32);
        let blocks = self.columns * height.div_ceil(BLOCK);
        self.depth.clear();
        self.depth.resize(blocks * samples, [depth; LANES]);
        self.triangle.clear();
        self.triangle.resize(blocks * samples, [NO_TRIANGLE as i32; LANES]);
        self.block_depth.clear();
        self.block_depth.resize(blocks, depth);
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.depth, &other.depth);
        reserve_like(&mut self.triangle, &other.triangle);
        reserve_like(&mut self.block_depth, &other.block_depth);
    }

    /// Number of blocks that triangles were drawn into since the last call, hidden ones included: a measure of work
    /// that depends on nothing but the triangles.
    pub fn take_visited(&mut self) -> u64 {
        std::mem::take(&mut self.visited)
    }

    /// Blocks in a row.
    #[must_use]
    pub fn block_columns(&self) -> usize {
        self.columns
    }

    /// Number of blocks.
    #[must_use]
    pub fn block_count(&self) -> usize {
        self.block_depth.len()
    }

    /// For each sample of a block, the triangle that its sixteen pixels see, as bits of a `u32` ([`NO_TRIANGLE`]:
    /// none).
    #[inline(always)]
    #[must_use]
    pub fn block_triangles(&self, block: usize) -> &[[i32; LANES]] {
        &self.triangle[block * self.samples..(block + 1) * self.samples]
    }

    /// For each sample of a block, the depth of what its sixteen pixels see; where that is nothing, that of [`VisibilityBuffer::clear`].
    #[inline(always)]
    #[must_use]
    pub fn block_depths(&self, block: usize) -> &[[f32; LANES]] {
        &self.depth[block * self.samples..(block + 1) * self.samples]
    }

    /// True if nothing was ever written to the block.
    #[inline(always)]
    #[must_use]
    pub fn block_is_empty(&self, block: usize) -> bool {
        self.block_triangles(block).iter().all(|s| s.iter().all(|&t| t == NO_TRIANGLE as i32))
    }

    /// Draws a triangle: samples that it covers and where it is nearer than what is there (greater depth; the earlier
    /// triangle stays on ties) become `identity`. `keep(column, row, sample, covered)` may take samples away before
    /// they count (alpha masks); it gets the block's first pixel and the covered lanes, and returns those to keep.
    #[inline(always)]
    pub fn draw<L: Lanes>(
        &mut self,
        l: L,
        triangle: &Triangle,
        identity: u32,
        origin: TileOrigin,
        pattern: &SamplePattern,
        mut keep: Option<&mut dyn FnMut(i32, i32, usize, u16) -> u16>,
    ) {
        if keep.is_none() {
            if let Some(samples) = SmallSamples::new(triangle, origin) {
                self.draw_small(triangle, samples, identity, origin, pattern);
                return;
            }
            if let Some(pixels) = FewPixels::new(l, triangle, origin, pattern) {
                self.draw_pixels(l, triangle, &pixels, identity, origin, pattern);
                return;
            }
        }
        let plane = DepthPlane::new(l, triangle, origin);
        let edges = EdgeFunctions::new(l, triangle, origin, pattern);
        let lane_edges = lane_offsets(l, &edges);
        let identity = l.splat_i(identity as i32);
        for_each_block(
            triangle,
            &edges,
            origin,
            [0, 0, self.width, self.height],
            #[inline(always)]
            |span: BlockSpan| {
                let block = (span.row as usize / BLOCK) * self.columns + span.column as usize / BLOCK;
                self.visited += 1;
                if plane.largest_value <= self.block_depth[block] {
                    return;
                }
                let corner = lane_edges.at(&edges, &span);
                let place = plane.place(l, &span);
                let mut all_written = span.full && keep.is_none();
                let samples = block * self.samples..(block + 1) * self.samples;
                let depths = self.depth[samples.clone()].iter_mut();
                let triangles = self.triangle[samples].iter_mut();
                for (sample, ((offset, nearest), seen)) in
                    pattern.offsets().iter().zip(depths).zip(triangles).enumerate()
                {
                    let mut covered =
                        if span.full { l.mask(u16::MAX) } else { corner.inside(&edges, sample) };
                    if !span.full && !covered.any() {
                        continue;
                    }
                    let depth = plane.at(l, place, *offset);
                    let old = l.load(nearest);
                    covered = covered & depth.gt(old);
                    if !covered.any() {
                        continue;
                    }
                    if let Some(keep) = keep.as_mut() {
                        covered =
                            l.mask(keep(span.column, span.row, sample, covered.bits()) & covered.bits());
                    }
                    *nearest = covered.select(depth, old).to_array();
                    *seen = covered.select_i(identity, l.load_i(seen)).to_array();
                }
                // Every sample now holds at least the triangle's smallest depth.
                all_written &= plane.smallest_value > self.block_depth[block];
                if all_written {
                    self.block_depth[block] = plane.smallest_value;
                }
            },
        );
    }

    /// Draws a small triangle, with the same result as [`VisibilityBuffer::draw`].
    #[inline(always)]
    fn draw_small(
        &mut self,
        triangle: &Triangle,
        mut samples: SmallSamples,
        identity: u32,
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.visited += self.blocks_of_box(triangle, origin);
        while let Some((sample, place)) = samples.next(pattern) {
            self.put(triangle, sample, place, identity, origin);
        }
    }

    /// Draws a triangle of few pixels, with the same result as [`VisibilityBuffer::draw`].
    #[inline(always)]
    fn draw_pixels<L: Lanes>(
        &mut self,
        l: L,
        triangle: &Triangle,
        pixels: &FewPixels<L>,
        identity: u32,
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.visited += self.blocks_of_box(triangle, origin);
        pixels.for_each(
            l,
            pattern,
            #[inline(always)]
            |corner, inside| {
                let mut left = inside;
                while left != 0 {
                    let sample = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let [x, y] = pattern.offsets()[sample];
                    self.put(triangle, sample, [corner[0] + x, corner[1] + y], identity, origin);
                }
            },
        );
    }

    /// Number of blocks of the tile that a triangle's box touches. Over all tiles the sum does not depend on their
    /// size.
    #[inline(always)]
    fn blocks_of_box(&self, triangle: &Triangle, origin: TileOrigin) -> u64 {
        Self::blocks_of(EdgeFunctions::pixel_box(triangle, origin, self.width, self.height))
    }

    /// Number of blocks that a box of pixels touches.
    #[inline(always)]
    fn blocks_of([left, top, right, bottom]: [i32; 4]) -> u64 {
        const SHIFT: u32 = BLOCK.trailing_zeros();
        if left >= right || top >= bottom {
            return 0;
        }
        let columns = ((right - 1) >> SHIFT) - (left >> SHIFT) + 1;
        let rows = ((bottom - 1) >> SHIFT) - (top >> SHIFT) + 1;
        (columns * rows) as u64
    }

    /// Draws one sample of a triangle, at a place relative to the tile's corner in sub-pixels, if it is in the tile.
    #[inline(always)]
    fn put(
        &mut self,
        triangle: &Triangle,
        sample: usize,
        [x, y]: [i32; 2],
        identity: u32,
        origin: TileOrigin,
    ) {
        let (column, row) = (x >> SUBPIXEL_BITS, y >> SUBPIXEL_BITS);
        if column < 0 || row < 0 || column >= self.width || row >= self.height {
            return;
        }
        let depth =
            triangle.depth_at([(x + origin.x - triangle.x[0]) as f32, (y + origin.y - triangle.y[0]) as f32]);
        let (column, row) = (column as usize, row as usize);
        let block = row / BLOCK * self.columns + column / BLOCK;
        let lane = row % BLOCK * BLOCK + column % BLOCK;
        let index = block * self.samples + sample;
        let nearest = &mut self.depth[index][lane];
        if depth > *nearest {
            *nearest = depth;
            self.triangle[index][lane] = identity as i32;
        }
    }

    /// Number of blocks of the tile that a disc's box touches. Over all tiles the sum does not depend on their size.
    #[must_use]
    pub fn blocks_of_disc(&self, disc: &Disc, origin: TileOrigin) -> u64 {
        Self::blocks_of(disc.pixel_box(origin, self.width, self.height))
    }

    /// Draws a disc, as [`VisibilityBuffer::draw`] does a triangle.
    #[inline(always)]
    pub fn draw_disc<L: Lanes>(
        &mut self,
        l: L,
        disc: &Disc,
        identity: u32,
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.visited += self.blocks_of_disc(disc, origin);
        let pixels = disc.pixel_box(origin, self.width, self.height);
        let ellipse = Ellipse::new(l, disc, origin);
        let identity = l.splat_i(identity as i32);
        for_each_block_of_box(
            pixels,
            #[inline(always)]
            |span: BlockSpan| {
                let block = (span.row as usize / BLOCK) * self.columns + span.column as usize / BLOCK;
                if ellipse.plane.largest_value <= self.block_depth[block] {
                    return;
                }
                let place = ellipse.plane.place(l, &span);
                let mut all_covered = true;
                let samples = block * self.samples..(block + 1) * self.samples;
                let depths = self.depth[samples.clone()].iter_mut();
                let triangles = self.triangle[samples].iter_mut();
                for ((offset, nearest), seen) in pattern.offsets().iter().zip(depths).zip(triangles) {
                    let (covered, depth) = ellipse.at(l, place, *offset);
                    all_covered &= covered.all();
                    if !covered.any() {
                        continue;
                    }
                    let old = l.load(nearest);
                    let nearer = covered & depth.gt(old);
                    *nearest = nearer.select(depth, old).to_array();
                    *seen = nearer.select_i(identity, l.load_i(seen)).to_array();
                }
                if all_covered && ellipse.plane.smallest_value > self.block_depth[block] {
                    self.block_depth[block] = ellipse.plane.smallest_value;
                }
            },
        );
    }

    /// Visits the samples that a disc covers, as [`VisibilityBuffer::visit_visible`] does those of a triangle.
    #[inline(always)]
    pub fn visit_visible_disc<L: Lanes>(
        &self,
        l: L,
        disc: &Disc,
        origin: TileOrigin,
        pattern: &SamplePattern,
        [left, top, right, bottom]: [u32; 4],
        mut visit: impl FnMut(i32, i32, &[u16; LANES]),
    ) -> u64 {
        let mut visited = 0;
        let ellipse = Ellipse::new(l, disc, origin);
        let ends = [whole_blocks(right).min(self.width), whole_blocks(bottom).min(self.height)];
        let [first_column, first_row, end_column, end_row] = disc.pixel_box(origin, ends[0], ends[1]);
        for_each_block_of_box(
            [first_column.max(left as i32), first_row.max(top as i32), end_column, end_row],
            #[inline(always)]
            |span: BlockSpan| {
                let block = (span.row as usize / BLOCK) * self.columns + span.column as usize / BLOCK;
                visited += u64::from(span.column >= left as i32 && span.row >= top as i32);
                if ellipse.plane.largest_value <= self.block_depth[block] {
                    return;
                }
                let place = ellipse.plane.place(l, &span);
                let mut masks = [0_u16; LANES];
                for (sample, offset) in pattern.offsets().iter().enumerate() {
                    let old = l.load(&self.depth[block * self.samples + sample]);
                    let (covered, depth) = ellipse.at(l, place, *offset);
                    let visible = (covered & depth.gt(old)).bits();
                    for (k, mask) in masks.iter_mut().enumerate() {
                        *mask |= (visible >> k & 1) << sample;
                    }
                }
                if masks.iter().any(|&m| m != 0) {
                    visit(span.column, span.row, &masks);
                }
            },
        );
        visited
    }

    /// Visits the samples that a triangle covers in front of everything drawn so far, without drawing it, in the blocks that
    /// lie in a rectangle of the tile (left, top, and the ends) or partly: `visit(column, row, masks)` gets a block's first
    /// pixel and the sample mask of each of its pixels. Returns the number of blocks whose first pixel lies in the rectangle,
    /// hidden ones included: over rectangles that make up a tile, and over tiles, the sum does not depend on them.
    #[inline(always)]
    pub fn visit_visible<L: Lanes>(
        &self,
        l: L,
        triangle: &Triangle,
        origin: TileOrigin,
        pattern: &SamplePattern,
        [left, top, right, bottom]: [u32; 4],
        mut visit: impl FnMut(i32, i32, &[u16; LANES]),
    ) -> u64 {
        let mut visited = 0;
        let plane = DepthPlane::new(l, triangle, origin);
        let edges = EdgeFunctions::new(l, triangle, origin, pattern);
        let lane_edges = lane_offsets(l, &edges);
        for_each_block(
            triangle,
            &edges,
            origin,
            [
                left as i32,
                top as i32,
                whole_blocks(right).min(self.width),
                whole_blocks(bottom).min(self.height),
            ],
            #[inline(always)]
            |span: BlockSpan| {
                let block = (span.row as usize / BLOCK) * self.columns + span.column as usize / BLOCK;
                visited += u64::from(span.column >= left as i32 && span.row >= top as i32);
                if plane.largest_value <= self.block_depth[block] {
                    return;
                }
                let corner = lane_edges.at(&edges, &span);
                let place = plane.place(l, &span);
                let mut masks = [0_u16; LANES];
                for (sample, offset) in pattern.offsets().iter().enumerate() {
                    let covered = if span.full { l.mask(u16::MAX) } else { corner.inside(&edges, sample) };
                    let old = l.load(&self.depth[block * self.samples + sample]);
                    let visible = (covered & plane.at(l, place, *offset).gt(old)).bits();
                    for (k, mask) in masks.iter_mut().enumerate() {
                        *mask |= (visible >> k & 1) << sample;
                    }
                }
                if masks.iter().any(|&m| m != 0) {
                    visit(span.column, span.row, &masks);
                }
            },
        );
        visited
    }
}

/// The end of the block that ends there or beyond.
#[inline(always)]
fn whole_blocks(end: u32) -> i32 {
    end.next_multiple_of(BLOCK as u32) as i32
}

/// Calls `f` for every block of a rectangle of a tile (left, top, and the ends) of which a sample may lie inside the triangle,
/// row by row.
#[inline(always)]
fn for_each_block(
    triangle: &Triangle,
    edges: &EdgeFunctions,
    origin: TileOrigin,
    [left, top, right, bottom]: [i32; 4],
    mut f: impl FnMut(BlockSpan),
) {
    const SIDE: i32 = BLOCK as i32;
    let [first_column, first_row, end_column, end_row] =
        EdgeFunctions::pixel_box(triangle, origin, right, bottom);
    let (first_column, first_row) = (first_column.max(left), first_row.max(top));
    if first_column >= end_column || first_row >= end_row {
        return;
    }
    let (first_column, first_row) = (first_column & !(SIDE - 1), first_row & !(SIDE - 1));
    let wide = end_column - first_column > 2 * SIDE;
    // What the edge functions gain and lose at most between the first pixel of a block and its others.
    let gain: [i32; 3] = std::array::from_fn(
        #[inline(always)]
        |k| (SIDE - 1) * (edges.a[k].max(0) + edges.b[k].max(0)),
    );
    let loss: [i32; 3] = std::array::from_fn(
        #[inline(always)]
        |k| (SIDE - 1) * (edges.a[k].min(0) + edges.b[k].min(0)),
    );
    let mut row = first_row;
    while row < end_row {
        let reach: [i32; 3] = std::array::from_fn(
            #[inline(always)]
            |k| edges.largest[k] + edges.b[k] * row + gain[k],
        );
        let (mut from, mut to) = (first_column, end_column);
        if wide {
            // The blocks for which `a * column + reach >= 0`, by one division an edge.
            for k in 0..3 {
                let a = edges.a[k];
                if a > 0 && reach[k] < 0 {
                    let column = -(reach[k].div_euclid(a));
                    from = from.max((column + SIDE - 1) & !(SIDE - 1));
                } else if a < 0 && reach[k] >= 0 {
                    to = to.min(reach[k] / -a + 1);
                } else if a <= 0 && reach[k] < 0 {
                    to = from;
                }
            }
        }
        let mut column = from;
        while column < to {
            let outside = (0..3).any(|k| edges.a[k] * column + reach[k] < 0);
            if !outside {
                let full =
                    (0..3).all(|k| edges.smallest[k] + edges.a[k] * column + edges.b[k] * row + loss[k] >= 0);
                f(BlockSpan { column, row, full });
            }
            column += SIDE;
        }
        row += SIDE;
    }
}

/// Calls `f` for every block that a box of pixels touches, row by row; none of them counts as covered whole.
#[inline(always)]
fn for_each_block_of_box([left, top, right, bottom]: [i32; 4], mut f: impl FnMut(BlockSpan)) {
    const SIDE: i32 = BLOCK as i32;
    let mut row = top & !(SIDE - 1);
    while row < bottom {
        let mut column = left & !(SIDE - 1);
        while column < right {
            f(BlockSpan { column, row, full: false });
            column += SIDE;
        }
        row += SIDE;
    }
}

/// Coverage and depth of a disc.
struct Ellipse<L: Lanes> {
    conic: [L::F; 3],
    sag: L::F,
    plane: DepthPlane<L>,
}

impl<L: Lanes> Ellipse<L> {
    #[inline(always)]
    fn new(l: L, disc: &Disc, origin: TileOrigin) -> Self {
        let [a, b, c] = disc.conic;
        let (gradient, range) = (disc.depth_gradient, disc.depth_range());
        let plane = DepthPlane::of_parts(l, [disc.x, disc.y], disc.depth, gradient, range, origin);
        Self { conic: [l.splat(a), l.splat(b), l.splat(c)], sag: l.splat(disc.sag), plane }
    }

    /// The lanes whose sample lies inside, and the depth there. Distances are exact, so that neither the tile nor the block
    /// shows.
    #[inline(always)]
    fn at(&self, l: L, place: [L::F; 2], offset: [i32; 2]) -> (L::M, L::F) {
        let [x, y] = [place[0] + l.splat(offset[0] as f32), place[1] + l.splat(offset[1] as f32)];
        let [a, b, c] = self.conic;
        let form = (a * x + b * y) * x + c * y * y;
        let plane = &self.plane;
        let depth = plane.at_vertex + x * plane.gradient[0] + y * plane.gradient[1] - form * self.sag;
        (form.le(l.splat(1.0)), depth.max(plane.smallest).min(plane.largest))
    }
}

/// Offset of each lane from the edge functions at its block's first pixel.
struct LaneEdges<L: Lanes> {
    offsets: [L::I; 3],
}

#[inline(always)]
fn lane_offsets<L: Lanes>(l: L, edges: &EdgeFunctions) -> LaneEdges<L> {
    let lane = l.lane_indices();
    let (column, row) = (lane & 3, lane.shr(2));
    LaneEdges {
        offsets: std::array::from_fn(
            #[inline(always)]
            |k| column * edges.a[k] + row * edges.b[k],
        ),
    }
}

impl<L: Lanes> LaneEdges<L> {
    #[inline(always)]
    fn at(&self, edges: &EdgeFunctions, span: &BlockSpan) -> Self {
        Self {
            offsets: std::array::from_fn(
                #[inline(always)]
                |k| self.offsets[k] + (edges.a[k] * span.column + edges.b[k] * span.row),
            ),
        }
    }

    /// The lanes on the inner side of all three edges.
    #[inline(always)]
    fn inside(&self, edges: &EdgeFunctions, sample: usize) -> L::M {
        let [a, b, c] = self.offsets;
        let [ca, cb, cc] = &edges.constants;
        ((a + ca[sample]) | (b + cb[sample]) | (c + cc[sample])).non_negative()
    }
}

/// Depth over the screen, relative to the triangle's first vertex.
struct DepthPlane<L: Lanes> {
    at_vertex: L::F,
    gradient: [L::F; 2],
    /// Lane offsets in sub-pixels.
    lane: [L::F; 2],
    /// The tile's corner relative to the vertex, in sub-pixels.
    origin: [i32; 2],
    smallest: L::F,
    largest: L::F,
    smallest_value: f32,
    largest_value: f32,
}

impl<L: Lanes> DepthPlane<L> {
    #[inline(always)]
    fn new(l: L, triangle: &Triangle, origin: TileOrigin) -> Self {
        let vertex = [triangle.x[0], triangle.y[0]];
        let (gradient, range) = (triangle.depth_gradient, triangle.depth_range());
        Self::of_parts(l, vertex, triangle.depth[0], gradient, range, origin)
    }

    /// The plane through a vertex, with the range that it is clamped to.
    #[inline(always)]
    fn of_parts(
        l: L,
        [x, y]: [i32; 2],
        depth: f32,
        gradient: [f32; 2],
        [smallest, largest]: [f32; 2],
        origin: TileOrigin,
    ) -> Self {
        let lane = l.lane_indices();
        Self {
            at_vertex: l.splat(depth),
            gradient: gradient.map(|g| l.splat(g)),
            lane: [(lane & 3).shl(SUBPIXEL_BITS).to_float(), lane.shr(2).shl(SUBPIXEL_BITS).to_float()],
            origin: [origin.x - x, origin.y - y],
            smallest: l.splat(smallest),
            largest: l.splat(largest),
            smallest_value: smallest,
            largest_value: largest,
        }
    }

    /// Distances of the corners of a block's pixels from the vertex, in sub-pixels.
    #[inline(always)]
    fn place(&self, l: L, span: &BlockSpan) -> [L::F; 2] {
        let [x, y] = [self.origin[0] + span.column * SUBPIXELS, self.origin[1] + span.row * SUBPIXELS];
        [self.lane[0] + l.splat(x as f32), self.lane[1] + l.splat(y as f32)]
    }

    /// Depth of one sample of each pixel of a block, at an offset from their corners. The distances to the vertex are exact
    /// integers below 2^24, so neither the tile nor the block shows in the result.
    #[inline(always)]
    fn at(&self, l: L, place: [L::F; 2], offset: [i32; 2]) -> L::F {
        let [x, y] = [place[0] + l.splat(offset[0] as f32), place[1] + l.splat(offset[1] as f32)];
        let depth = self.at_vertex + x * self.gradient[0] + y * self.gradient[1];
        depth.max(self.smallest).min(self.largest)
    }
}
