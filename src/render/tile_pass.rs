//! One tile from triangles to pixels.

use super::aov::TileAovs;
use super::bands::TileRows;
use super::draws::DrawState;
use super::reach::Reach;
use super::resolve::{Behind, TilePixels, Transmitted};
use super::shading_order::ShadingOrder;
use super::splat_tile::{SplatPlace, SplatScratch, Surfaces};
use super::splats::SplatScene;
use super::tile_shading::{Discs, ShadedFragment, TileShading, TileTriangles, one_material, shade_fragments};
use super::trace::FragmentHashes;
use super::work::{Spent, Work};
use crate::frame::{Clipping, Developer, is_tinted};
use crate::gbuffer::layout::SurfacePlanes;
use crate::gbuffer::{Batch, Fragment, extract_fragments, push_masked_fragments};
use crate::geometry::Chunk;
use crate::jobs::Scratch;
use crate::light::PunctualLight;
use crate::math::lanes::{LANES, Lanes, Mask};
use crate::raster::{Disc, SamplePattern, TileOrigin, Visibility};
use crate::reuse::reserve_like;
use crate::scene::AlphaMode;
use crate::shade::{Backdrop, ShadeContext, ShadingCost, alpha_passes};
use crate::tile::{Run, TileGrid};
use prefetch_index::prefetch_index;

/// What all tiles of a frame share.
pub(super) struct Pass<'a> {
    pub grid: TileGrid,
    pub pattern: &'a SamplePattern,
    pub chunks: &'a [Chunk],
    pub states: &'a [DrawState],
    pub shade: ShadeContext<'a>,
    pub show_environment: bool,
    /// What refracting surfaces see behind them; `None` while it is being drawn: without blended and transmissive
    /// surfaces.
    pub backdrop: Option<&'a Backdrop>,
    /// The frame's pixels, and the screen's, are new memory, all zero.
    pub blank: [bool; 2],
    /// The frame's pixels hold the backdrop already: where no surface is blended or transmissive, they stay.
    pub redraws: bool,
    /// Something may tint what is behind the picture.
    pub tints: bool,
    /// How the screen's pixels are made, if they are wanted.
    pub developer: Option<Developer>,
    /// White and black pixels of the screen are counted.
    pub meters: bool,
    /// Least square of the cosine between the normals of small triangles that are shaded as one, if any are.
    pub merge: Option<f32>,
    pub work: &'a Work,
    /// What fragments of each material take.
    pub costs: &'a [ShadingCost],
    /// Where the lights shine.
    pub reach: &'a Reach,
    /// Work is counted and not done, and there will be no picture: to find out which limit is passed first.
    pub only_counts: bool,
    pub splats: SplatScene<'a>,
}

/// Blended fragments that one thread keeps at a time: 64 layers of a tile of 64 x 64 pixels, and some 16 MB. Of tiles with
/// more, parts are drawn one after the other.
const MAX_KEPT: usize = 1 << 18;

/// What lanes without a fragment are counted as, where a blended triangle covers a block in part: fragments.
const PARTIAL_BLOCK: u64 = 4;

/// How many triangles before its turn one is asked for: in a dense mesh those of a tile are not in the cache.
const TRIANGLES_AHEAD: usize = 8;

/// Working memory of one thread, kept from tile to tile and from frame to frame.
#[derive(Debug, Default)]
pub(super) struct TileScratch {
    /// Empty between tiles.
    pub rows: TileRows<'static>,
    visibility: Visibility,
    /// Chunk of each identity, and which of its triangles or points.
    pub identities: Vec<(u32, u32)>,
    /// Of the points, those that are seen.
    pub discs: Discs,
    /// Identities of blended and transmissive triangles: of the tile, and after them of its parts.
    blended: Vec<u32>,
    /// The lights that reach the tile, if they are not all.
    lights: Vec<PunctualLight>,
    /// What each fragment lets through, where the tile has transmissive ones.
    pub kept: Vec<Option<Transmitted>>,
    /// The environment behind each pixel of such tiles, where it shows.
    environment: Vec<[f32; 3]>,
    /// Parts of the tile that are yet to be blended.
    parts: Vec<TilePart>,
    pub fragments: Vec<Fragment>,
    pub order: ShadingOrder,
    pub shaded: Vec<ShadedFragment>,
    /// The fragments that are being shaded, and those that are next.
    pub batches: [Batch; 2],
    /// The G-buffer of those that are being shaded.
    pub surface: SurfacePlanes,
    resolve: super::resolve::ResolveScratch,
    pub pixels: TilePixels,
    splats: SplatScratch,
}

impl TileScratch {
    /// Takes as much memory as `other` has.
    fn reserve_like(&mut self, other: &Self) {
        self.rows.reserve_like(&other.rows);
        self.visibility.reserve_like(&other.visibility);
        reserve_like(&mut self.identities, &other.identities);
        reserve_like(&mut self.discs.triangles, &other.discs.triangles);
        reserve_like(&mut self.discs.places, &other.discs.places);
        reserve_like(&mut self.blended, &other.blended);
        reserve_like(&mut self.lights, &other.lights);
        reserve_like(&mut self.kept, &other.kept);
        reserve_like(&mut self.environment, &other.environment);
        reserve_like(&mut self.parts, &other.parts);
        reserve_like(&mut self.fragments, &other.fragments);
        self.order.reserve_like(&other.order);
        reserve_like(&mut self.shaded, &other.shaded);
        reserve_like(&mut self.resolve.blended, &other.resolve.blended);
        reserve_like(&mut self.resolve.behind, &other.resolve.behind);
        reserve_like(&mut self.pixels.linear, &other.pixels.linear);
        reserve_like(&mut self.pixels.transmittance, &other.pixels.transmittance);
        self.splats.reserve_like(&other.splats);
    }

    /// Gives all the memory of the largest: which tiles a value gets depends on timing, and the next picture's tiles
    /// shall fit into any.
    pub(super) fn level(all: &mut Scratch<Self>) {
        let mut others = all.iter_mut();
        let Some(first) = others.next() else { return };
        others.for_each(|other| first.reserve_like(other));
        let mut others = all.iter_mut();
        let Some(first) = others.next() else { return };
        others.for_each(|other| other.reserve_like(first));
    }
}

/// A part of a tile that is to be blended.
#[derive(Clone, Copy, Debug)]
struct TilePart {
    /// Left, top, and the ends.
    pixels: [u32; 4],
    /// The triangles that may be seen in it: first and end in the list of identities.
    triangles: [usize; 2],
}

/// Work of one tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TileCost {
    /// Number of fragments.
    pub fragments: u64,
    /// Blocks that its triangles were drawn into.
    pub blocks: u64,
    /// Units of [`ShadingCost`].
    pub shading: u64,
    /// Pixels in which something of the scene shows, the environment left out.
    pub covered: u64,
}

/// What a tile adds to the picture beside its pixels.
#[derive(Debug)]
pub(super) struct TileJob {
    /// Something in it tints what is behind the picture.
    pub tinted: bool,
    /// Its pixels on the screen, if they are counted.
    pub clipping: Clipping,
    /// Planes of the G-buffer that were asked for.
    pub aovs: TileAovs,
    /// What the tile took; before it is drawn again, what it took then.
    pub cost: TileCost,
    /// Hashes of the fragments, if they were asked for.
    pub hashes: Option<FragmentHashes>,
}

/// Renders one tile.
#[inline(always)]
pub(super) fn render_tile<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    tile: usize,
    runs: &[Run],
    scratch: &mut TileScratch,
    rows: &mut TileRows<'_>,
    job: &mut TileJob,
) {
    let [left, top, width, height] = pass.grid.pixels(tile);
    let origin = pass.grid.origin(tile);
    let state = |run: &Run| &pass.states[pass.chunks[run.chunk as usize].draw as usize];
    let transmissive = pass.backdrop.is_some() && runs.iter().any(|run| state(run).transmissive);
    // Like blended surfaces they are no part of what refracting ones see behind them.
    let splats = if pass.backdrop.is_some() { pass.splats.runs(tile) } else { &[] };
    if pass.redraws
        && splats.is_empty()
        && job.hashes.is_none()
        && !job.aovs.is_wanted()
        && !transmissive
        && !runs.iter().any(|run| state(run).alpha_mode == AlphaMode::Blend)
    {
        // Counted as if it were: what a limit lets through must not depend on the tiles.
        let TileCost { fragments, blocks, shading, .. } = job.cost;
        for (what, amount) in
            [(Spent::Blocks, blocks), (Spent::Fragments, fragments), (Spent::Shading, shading)]
        {
            pass.work.spend(what, amount);
        }
        if let Some(developer) = &pass.developer {
            // Nothing in it tints.
            for (linear, display) in rows.linear.iter().zip(&mut rows.display) {
                developer.develop(l, linear, &[], display);
                if pass.meters {
                    job.clipping.count(linear, display);
                }
            }
        }
        return;
    }
    job.cost = TileCost::default();
    if pass.work.is_stopped() {
        return;
    }
    if runs.is_empty() && splats.is_empty() && !pass.show_environment {
        store_nothing(pass, rows);
        return;
    }
    scratch.pixels.clear([width, height], pass.tints);
    scratch.fragments.clear();
    scratch.kept.clear();
    scratch.environment.clear();
    scratch.blended.clear();
    if !runs.is_empty() && !draw_triangles(l, pass, origin, [width, height], runs, scratch, &mut job.cost) {
        return;
    }
    let opaque = scratch.fragments.len();
    job.cost.fragments = opaque as u64;
    if !pass.work.spend(Spent::Fragments, opaque as u64) {
        return;
    }
    let one_material = one_material(pass, runs);
    if transmissive && pass.show_environment && !pass.only_counts {
        super::resolve::environment_behind(l, &pass.shade, origin, [width, height], &mut scratch.environment);
    }
    let mut lights = std::mem::take(&mut scratch.lights);
    let shade = if pass.reach.is_uniform() {
        pass.shade
    } else {
        pass.reach.lights_of([left, top, width, height], pass.shade.lights, &mut lights);
        ShadeContext { lights: &lights, ..pass.shade }
    };
    let mut of_tile = TileShading {
        shade: &shade,
        origin,
        corner: [left, top],
        one_material,
        whole: None,
        opaque,
        transmissive,
    };
    // Pixels are independent of each other. Where there are more blended fragments than are kept, the opaque ones are
    // shaded alone, and parts of the tile are blended one after the other, halved until one fits.
    scratch.parts.clear();
    scratch.parts.push(TilePart { pixels: [0, 0, width, height], triangles: [0, scratch.blended.len()] });
    let splat_tile = SplatPlace { corner: [left, top], size: [width, height], runs: splats };
    if !splats.is_empty() {
        scratch.splats.start(pass, &splat_tile);
    }
    let mut start = 0;
    while let Some(part) = scratch.parts.pop() {
        // Those of parts that are done.
        scratch.blended.truncate(part.triangles[1]);
        let blends = part.triangles[0] < part.triangles[1];
        let fits = !blends || draw_blended(l, pass, &of_tile, &part, scratch, &mut job.cost);
        if pass.work.is_stopped() {
            break;
        }
        // Without blending, a fragment that covers its pixel is the pixel: these are written when they are shaded.
        let blends = opaque < scratch.fragments.len();
        of_tile.whole = if blends || !splats.is_empty() || job.hashes.is_some() {
            None
        } else {
            Some(pass.pattern.full_mask())
        };
        if !fits {
            let triangles = [part.triangles[1], scratch.blended.len()];
            scratch.parts.extend(halves(part.pixels).map(|pixels| TilePart { pixels, triangles }));
            scratch.fragments.truncate(opaque);
        }
        if !shade_and_resolve(l, pass, &of_tile, start, scratch, job) {
            break;
        }
        if fits
            && !splats.is_empty()
            && !draw_splats_among_surfaces(l, pass, &splat_tile, opaque, part.pixels, scratch, job)
        {
            break;
        }
        scratch.fragments.truncate(opaque);
        start = opaque;
    }
    scratch.lights = lights;
    if !splats.is_empty() && !pass.work.is_stopped() {
        let TileScratch { splats, pixels, .. } = scratch;
        job.cost.blocks += splats.draw_alone(l, pass, &splat_tile, pixels, &mut job.aovs);
    }
    if pass.only_counts || pass.work.is_stopped() {
        return;
    }
    job.cost.covered = super::resolve::covered(&scratch.pixels);
    if pass.show_environment {
        super::resolve::composite_environment(l, &pass.shade, origin, &mut scratch.pixels);
    }
    job.clipping = store(l, pass, &scratch.pixels, rows);
    job.tinted = scratch.pixels.transmittance.iter().any(is_tinted);
}

/// Writes the pixels of a tile to where they are wanted. Returns how many are white or black, if they are counted.
#[inline(always)]
fn store<L: Lanes>(l: L, pass: &Pass<'_>, pixels: &TilePixels, rows: &mut TileRows<'_>) -> Clipping {
    let mut clipping = Clipping::default();
    let TilePixels { width, linear, transmittance } = pixels;
    for (row, pixels) in rows.linear.iter_mut().zip(linear.chunks(*width)) {
        row.copy_from_slice(pixels);
    }
    for (row, open) in rows.transmittance.iter_mut().zip(transmittance.chunks(*width)) {
        row.copy_from_slice(open);
    }
    if let Some(developer) = &pass.developer {
        let mut open = transmittance.chunks(*width);
        for (row, pixels) in rows.display.iter_mut().zip(linear.chunks(*width)) {
            developer.develop(l, pixels, open.next().unwrap_or_default(), row);
            if pass.meters {
                clipping.count(pixels, row);
            }
        }
    }
    clipping
}

/// Writes the pixels of a tile without surfaces and without the environment.
fn store_nothing(pass: &Pass<'_>, rows: &mut TileRows<'_>) {
    let [blank, blank_display] = pass.blank;
    if !blank {
        for row in &mut rows.linear {
            // They may be empty already, because nothing was there in the last picture, and memory that is only read
            // costs half.
            let bits = row.as_flattened().iter().fold(0, |bits, value| bits | value.to_bits());
            if bits != 0 {
                row.fill([0.0; 4]);
            }
        }
    }
    rows.transmittance.iter_mut().for_each(|row| row.fill([1.0; 3]));
    let nothing = pass.developer.map_or([0; 4], |developer| developer.nothing());
    if !blank_display || nothing != [0; 4] {
        rows.display.iter_mut().for_each(|row| row.fill(nothing));
    }
}

/// Two halves of a rectangle of more than one pixel: left, top, and the ends.
fn halves([left, top, right, bottom]: [u32; 4]) -> [[u32; 4]; 2] {
    if bottom - top > 1 {
        let middle = top.midpoint(bottom);
        [[left, middle, right, bottom], [left, top, right, middle]]
    } else {
        let middle = left.midpoint(right);
        [[middle, top, right, bottom], [left, top, middle, bottom]]
    }
}

/// Shades the fragments from `start` on and puts them into the pixels. False if a limit stops it.
#[inline(always)]
fn shade_and_resolve<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of_tile: &TileShading<'_>,
    start: usize,
    scratch: &mut TileScratch,
    job: &mut TileJob,
) -> bool {
    if of_tile.transmissive {
        scratch.kept.truncate(start);
        scratch.kept.resize(scratch.fragments.len(), None);
    }
    if start < scratch.fragments.len() && !shade_fragments(l, pass, of_tile, start, scratch, job) {
        return false;
    }
    if pass.only_counts {
        return true;
    }
    let TileScratch { fragments, shaded, kept, environment, resolve, pixels, .. } = scratch;
    let behind = Behind { kept, environment };
    let samples = pass.pattern.len();
    if start == 0 {
        super::resolve::sum_opaque(samples, of_tile.whole, &fragments[..of_tile.opaque], shaded, pixels);
        super::resolve::transmittance_of(pixels);
    }
    if of_tile.opaque < fragments.len() {
        super::resolve::blend(samples, fragments, shaded, of_tile.opaque, &behind, resolve, pixels);
    }
    true
}

/// Draws splats into the pixels of a part of the tile that surfaces cover too. False if a limit stops it.
#[inline(always)]
fn draw_splats_among_surfaces<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    place: &SplatPlace<'_>,
    opaque: usize,
    part: [u32; 4],
    scratch: &mut TileScratch,
    job: &mut TileJob,
) -> bool {
    let TileScratch { visibility, fragments, shaded, kept, environment, resolve, pixels, splats, .. } =
        scratch;
    let surfaces = Surfaces {
        visibility,
        fragments,
        shaded,
        opaque,
        // Without blended fragments the list is another part's.
        blended: if opaque < fragments.len() { &resolve.blended } else { &[] },
        behind: Behind { kept, environment },
    };
    splats.draw_among(l, pass, place, &surfaces, part, pixels, &mut job.aovs)
}

/// Visibility of opaque and masked triangles, and their fragments. Leaves blended triangles for later. False if a limit stops
/// it.
#[inline(always)]
fn draw_triangles<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    [width, height]: [u32; 2],
    runs: &[Run],
    scratch: &mut TileScratch,
    cost: &mut TileCost,
) -> bool {
    let mut small = 0;
    scratch.identities.clear();
    scratch.discs.clear();
    let samples = pass.pattern.len();
    scratch.visibility.clear(width as usize, height as usize, samples);
    for (number, run) in runs.iter().enumerate() {
        if let Some(next) = runs.get(number + 1) {
            let chunk = &pass.chunks[next.chunk as usize];
            for &first in chunk.bins.triangles(next).iter().take(TRIANGLES_AHEAD) {
                prefetch_index(&chunk.triangles, first as usize);
            }
        }
        let chunk = &pass.chunks[run.chunk as usize];
        let state = &pass.states[chunk.draw as usize];
        let mode = if state.transmissive { AlphaMode::Blend } else { state.alpha_mode };
        if mode == AlphaMode::Blend && pass.backdrop.is_none() {
            continue;
        }
        let listed = chunk.bins.triangles(run);
        let mut masked = 0;
        if chunk.points {
            scratch.discs.wanted = true;
            masked += draw_points(l, pass, origin, run, mode, scratch);
        }
        let listed = if chunk.points { &[] } else { listed };
        for (place, &index) in listed.iter().enumerate() {
            if let Some(&later) = listed.get(place + TRIANGLES_AHEAD) {
                prefetch_index(&chunk.triangles, later as usize);
            }
            let identity = scratch.identities.len() as u32;
            scratch.identities.push((run.chunk, index));
            let triangle = &chunk.triangles[index as usize];
            small += u64::from(triangle.small_samples != 0);
            match mode {
                AlphaMode::Opaque => {
                    scratch.visibility.draw(l, triangle, identity, origin, pass.pattern, None);
                }
                AlphaMode::Blend => scratch.blended.push(identity),
                AlphaMode::Mask { cutoff } => {
                    let TileScratch { visibility, identities, discs, .. } = &mut *scratch;
                    let source = TileTriangles { chunks: pass.chunks, identities, discs };
                    let number = pass.shade.draws[chunk.draw as usize].material as usize;
                    let (material, own) =
                        (&pass.shade.materials[number], LANES as u64 * pass.costs[number].mask);
                    // A call through a pointer leaves the instruction set: `run` enters it again.
                    let mut keep = |column, row, sample, _covered| {
                        masked += own;
                        l.run(
                            #[inline(always)]
                            || {
                                let batch = Batch::of_block(
                                    identity,
                                    &source,
                                    origin,
                                    column,
                                    row,
                                    sample,
                                    pass.pattern,
                                );
                                alpha_passes(l, &pass.shade, material, cutoff, &batch).bits()
                            },
                        )
                    };
                    visibility.draw(l, triangle, identity, origin, pass.pattern, Some(&mut keep));
                }
            }
        }
        let visited = scratch.visibility.take_visited();
        cost.blocks += visited;
        cost.shading += masked;
        if !pass.work.spend(Spent::Blocks, visited)
            || (masked > 0 && !pass.work.spend(Spent::Shading, masked))
        {
            return false;
        }
    }
    let TileScratch { visibility, identities, discs, fragments, .. } = scratch;
    let source = TileTriangles { chunks: pass.chunks, identities, discs };
    let merge = match pass.merge {
        Some(least_squared_cosine) if small > 1 => Some((&source, pass.shade.draws, least_squared_cosine)),
        _ => None,
    };
    extract_fragments(l, visibility, width, height, samples, merge, fragments);
    discs.list(pass, identities, fragments);
    true
}

/// Visibility of the points of a run that are opaque or pass their mask. Leaves blended ones for later. Returns what their
/// masks cost, in units of [`ShadingCost`]: as if each were read once in every block that the point touches, so that it does
/// not depend on the tiles.
#[inline(never)]
fn draw_points<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    run: &Run,
    mode: AlphaMode,
    scratch: &mut TileScratch,
) -> u64 {
    // A function of its own: the one that draws opaque triangles is large enough.
    l.run(
        #[inline(always)]
        || {
            let chunk = &pass.chunks[run.chunk as usize];
            let draw = &pass.shade.draws[chunk.draw as usize];
            let own = pass.costs[draw.material as usize].mask;
            let mut masked = 0;
            let listed = chunk.bins.triangles(run);
            for (place, &index) in listed.iter().enumerate() {
                if let Some(&later) = listed.get(place + TRIANGLES_AHEAD) {
                    let vertex = draw.mesh.point(chunk.range.start + later as usize) as usize;
                    prefetch_index(draw.mesh.positions(), vertex);
                    prefetch_index(draw.mesh.shading_normals(), vertex);
                }
                let identity = scratch.identities.len() as u32;
                scratch.identities.push((run.chunk, index));
                if mode == AlphaMode::Blend {
                    scratch.blended.push(identity);
                    continue;
                }
                let Some(disc) = pass.disc(chunk, index) else { continue };
                if let AlphaMode::Mask { cutoff } = mode {
                    masked += LANES as u64 * own * scratch.visibility.blocks_of_disc(&disc, origin);
                    if !passes_mask(l, pass, origin, identity, &disc, cutoff, scratch) {
                        continue;
                    }
                }
                scratch.visibility.draw_disc(l, &disc, identity, origin, pass.pattern);
            }
            masked
        },
    )
}

/// Whether a point passes its mask: attributes are the same all over it.
#[inline(never)]
fn passes_mask<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    identity: u32,
    disc: &Disc,
    cutoff: f32,
    scratch: &mut TileScratch,
) -> bool {
    l.run(
        #[inline(always)]
        || {
            scratch.discs.add(identity, disc);
            let TileScratch { identities, discs, .. } = &*scratch;
            let source = TileTriangles { chunks: pass.chunks, identities, discs };
            let batch = Batch::of_block(identity, &source, origin, 0, 0, 0, pass.pattern);
            let draw = pass.chunks[identities[identity as usize].0 as usize].draw;
            let material = &pass.shade.materials[pass.shade.draws[draw as usize].material as usize];
            let passes = alpha_passes(l, &pass.shade, material, cutoff, &batch).bits() & 1 != 0;
            // Listed again if it is seen.
            scratch.discs.triangles.pop();
            scratch.discs.places.truncate(identity as usize);
            passes
        },
    )
}

/// Fragments of blended triangles in front of everything opaque, in a part of the tile. `false`, with some of them drawn, if
/// they are too many to be kept: then the triangles that are seen in the part are listed after the others.
///
/// What is counted belongs to the block of 4 x 4 pixels, and to the part that has its first pixel. Sixteen lanes cost as much
/// with fewer fragments: [`PARTIAL_BLOCK`] more are counted where not all pixels of a block see the triangle.
#[inline(never)]
fn draw_blended<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of_tile: &TileShading<'_>,
    part: &TilePart,
    scratch: &mut TileScratch,
    cost: &mut TileCost,
) -> bool {
    // A function of its own: the one that draws opaque triangles is large enough.
    l.run(
        #[inline(always)]
        || {
            let TileScratch { visibility, identities, discs, blended, fragments, .. } = scratch;
            let &TilePart { pixels: [left, top, right, bottom], triangles: [first, end] } = part;
            let opaque = fragments.len();
            let divisible = right - left > 1 || bottom - top > 1;
            let most = usize::try_from(pass.work.most(Spent::Blended)).unwrap_or(usize::MAX);
            let (mut fits, mut shading) = (true, 0);
            // Of triangles that are seen, and of those that are not.
            let mut blocks = [0; 2];
            for place in first..end {
                let identity = blended[place];
                let (chunk, index) = identities[identity as usize];
                let chunk = &pass.chunks[chunk as usize];
                let own = pass.costs[pass.shade.draws[chunk.draw as usize].material as usize];
                let mut seen = false;
                // No arithmetic of lanes in it.
                let mut visit = |column: i32, row: i32, masks: &[u16; LANES]| {
                    seen = true;
                    if column >= left as i32 && row >= top as i32 {
                        let [x, y] = of_tile.corner;
                        let lit =
                            own.fragment + own.light * pass.reach.count(x + column as u32, y + row as u32);
                        let count = masks.iter().map(|&mask| u64::from(mask != 0)).sum::<u64>();
                        let more = if count < LANES as u64 { PARTIAL_BLOCK } else { 0 };
                        shading += count * (lit + own.blending) + more * lit;
                    }
                    if fits {
                        push_masked_fragments(identity, column, row, masks, part.pixels, fragments);
                    }
                };
                let (origin, pattern, pixels) = (of_tile.origin, pass.pattern, part.pixels);
                let visited = if chunk.points {
                    let Some(disc) = pass.disc(chunk, index) else { continue };
                    visibility.visit_visible_disc(l, &disc, origin, pattern, pixels, &mut visit)
                } else {
                    let triangle = &chunk.triangles[index as usize];
                    visibility.visit_visible(l, triangle, origin, pattern, pixels, &mut visit)
                };
                blocks[usize::from(!seen)] += visited;
                if seen && divisible {
                    blended.push(identity);
                }
                let count = fragments.len() - opaque;
                fits &= !divisible || count <= MAX_KEPT;
                if count > most || (place % 1024 == 0 && pass.work.is_stopped()) {
                    break;
                }
            }
            let (visited, count) = if fits {
                blended.truncate(end);
                (blocks[0] + blocks[1], fragments.len() - opaque)
            } else {
                // What is seen is drawn and counted part by part; the rest is done.
                (blocks[1], 0)
            };
            cost.blocks += visited;
            pass.work.spend(Spent::Blocks, visited);
            if fits {
                cost.fragments += count as u64;
                cost.shading += shading;
                pass.work.spend(Spent::Blended, count as u64);
                pass.work.spend(Spent::Fragments, count as u64);
                pass.work.spend(Spent::Shading, shading);
            }
            discs.list(pass, identities, &fragments[opaque..]);
            fits
        },
    )
}

/// The side of a tile that keeps depth and identity in the second-level cache or closer.
pub(super) fn default_tile_size(samples: u32) -> u32 {
    match samples {
        1 => 64,
        4 | 8 => 32,
        _ => 16,
    }
}
