//! One tile from triangles to pixels: the stages in their order.

use super::aov::TileAovs;
use super::light_pool::TracedTile;
use super::pass::{Pass, Tile};
use super::resolve::{self, Behind, Distant, ResolveScratch, TilePixels};
use super::splat_tile::{SplatScratch, Surfaces};
use super::strips::TileRows;
use super::tile_blending::{TilePart, draw_blended};
use super::tile_shading::{Shaded, ShadingInput, ShadingScratch, shade_fragments};
use super::tile_store::{keep, store, store_nothing};
use super::tile_visibility_buffer::{TileVisibilityBuffer, draw_triangles, list_fragments};
use super::trace::FragmentHashes;
use super::work::Spent;
use overcoat_core::frame::{Clipping, is_tinted};
use overcoat_core::jobs::Scratch;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::light::PunctualLight;
use overcoat_stages::shade::ShadeContext;

/// Memory that the stages of one thread hand to each other, kept from tile to tile and from frame to frame.
#[derive(Debug, Default)]
pub struct TileScratch {
    /// Empty between tiles.
    pub rows: TileRows<'static>,
    /// The lights that reach the tile, if they are not all.
    lights: Vec<PunctualLight>,
    stages: TileStages,
}

/// Output of each stage for those after it.
#[derive(Debug, Default)]
struct TileStages {
    visibility_buffer: TileVisibilityBuffer,
    fragments: Vec<Fragment>,
    shading: ShadingScratch,
    shaded: Shaded,
    /// The environment and the floor behind each pixel of tiles with transmissive surfaces, where one of them shows.
    distant: Vec<Distant>,
    /// Parts of the tile that are yet to be blended.
    parts: Vec<TilePart>,
    resolve: ResolveScratch,
    splats: SplatScratch,
    pixels: TilePixels,
}

impl TileStages {
    /// Forgets the last tile.
    fn clear(&mut self, pass: &Pass<'_>, tile: &Tile<'_>) {
        self.visibility_buffer.blended.clear();
        self.fragments.clear();
        self.shaded.transmitted.clear();
        self.distant.clear();
        let over_ground = tile.transmissive && pass.frame.ground.is_some();
        self.pixels.clear(tile.size, pass.frame.tints, over_ground);
    }

    /// Takes as much memory as `other` has.
    fn reserve_like(&mut self, other: &Self) {
        self.visibility_buffer.reserve_like(&other.visibility_buffer);
        reserve_like(&mut self.fragments, &other.fragments);
        self.shading.reserve_like(&other.shading);
        self.shaded.reserve_like(&other.shaded);
        reserve_like(&mut self.distant, &other.distant);
        reserve_like(&mut self.parts, &other.parts);
        self.resolve.reserve_like(&other.resolve);
        self.splats.reserve_like(&other.splats);
        self.pixels.reserve_like(&other.pixels);
    }
}

impl TileScratch {
    /// Takes as much memory as `other` has.
    fn reserve_like(&mut self, other: &Self) {
        self.rows.reserve_like(&other.rows);
        reserve_like(&mut self.lights, &other.lights);
        self.stages.reserve_like(&other.stages);
    }

    /// Gives all the memory of the largest: which tiles a value gets depends on timing, and the next picture's tiles
    /// shall fit into any.
    pub fn level(all: &mut Scratch<Self>) {
        let mut others = all.iter_mut();
        let Some(first) = others.next() else { return };
        others.for_each(|other| first.reserve_like(other));
        let mut others = all.iter_mut();
        let Some(first) = others.next() else { return };
        others.for_each(|other| other.reserve_like(first));
    }
}

/// Work of one tile.
#[derive(Clone, Copy, Debug, Default)]
pub struct TileCost {
    /// Number of fragments.
    pub fragments: u64,
    /// Blocks that its triangles were drawn into.
    pub blocks: u64,
    /// Units of [`ShadingCost`](overcoat_stages::shade::ShadingCost).
    pub shading: u64,
    /// Pixels in which something of the scene shows, environment and floor left out.
    pub covered: u64,
}

/// Results of a tile beside its pixels.
#[derive(Debug, Default)]
pub struct TileJob {
    /// Something in it tints what is behind the picture.
    pub tinted: bool,
    /// Its pixels on the screen, if they are counted.
    pub clipping: Clipping,
    /// Planes of the G-buffer that were asked for.
    pub aovs: TileAovs,
    /// Cost of the tile; before it is drawn again, that of the last time.
    pub cost: TileCost,
    /// Hashes of the fragments, if they were asked for.
    pub hashes: Option<FragmentHashes>,
    /// Findings of rays, in a run that only sends them.
    pub traced: TracedTile,
}

/// State that the parts of a tile have in common.
struct TileParts<'a> {
    tile: &'a Tile<'a>,
    /// With the lights that reach the tile.
    context: &'a ShadeContext<'a>,
    /// Number of opaque fragments: the first in the list.
    opaque: usize,
    /// The material of all triangles, if it is one.
    one_material: Option<u32>,
}

/// Renders one tile.
#[inline(always)]
pub fn render_tile<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    tile: &Tile<'_>,
    scratch: &mut TileScratch,
    rows: &mut TileRows<'_>,
    job: &mut TileJob,
) {
    let (frame, TileScratch { lights, stages, .. }) = (pass.frame, scratch);

    // Leave what is drawn already, and empty what has nothing in it.
    if pass.keeps(tile) {
        return keep(l, pass, rows, job);
    }
    job.cost = TileCost::default();
    if pass.work.is_stopped() {
        return;
    }
    if !count_ground(pass, tile, job) {
        return;
    }
    let shows_behind = frame.show_environment || frame.ground.is_some();
    if tile.runs.is_empty() && tile.splats().is_empty() && !shows_behind {
        return store_nothing(pass, rows);
    }
    stages.clear(pass, tile);

    // Find the triangle that each sample sees, and make fragments of that.
    if !tile.runs.is_empty() {
        if !draw_triangles(l, pass, tile, &mut stages.visibility_buffer, &mut job.cost) {
            return;
        }
        list_fragments(l, frame, tile.size, &mut stages.visibility_buffer, &mut stages.fragments);
    }
    let opaque = stages.fragments.len();
    job.cost.fragments = opaque as u64;
    if !pass.work.spend(Spent::Fragments, opaque as u64) {
        return;
    }

    // Find what lies behind transmissive surfaces, and the lights that reach the tile.
    if tile.transmissive && shows_behind && !pass.only_counts() {
        find_distant(l, pass, tile, &mut stages.distant);
    }
    let one_material = frame.one_material(tile.runs);
    let context = &lit_context(pass, tile, lights);
    let parts = TileParts { tile, context, opaque, one_material };

    // Send rays, if that is all.
    if pass.traces() {
        shade_and_resolve(l, pass, &parts, 0, None, stages, job);
        return;
    }

    // Shade and resolve the fragments, blended ones and splats with them.
    draw_parts(l, pass, &parts, stages, job);

    // Draw the splats of pixels without surfaces.
    let TileStages { splats, pixels, .. } = stages;
    if !tile.splats().is_empty() && !pass.work.is_stopped() {
        job.cost.blocks += splats.draw_alone(l, pass, tile, pixels, &mut job.aovs);
    }
    if pass.only_counts() || pass.work.is_stopped() {
        return;
    }

    // Put the floor and the environment behind the pixels, and hand them on.
    job.cost.covered = resolve::covered(pixels);
    if let Some(ground) = &frame.ground {
        let aovs = &mut job.aovs;
        let see = aovs.wants_ground().then_some(|pixel, opacity| aovs.set_ground(pixel, opacity));
        ground.composite(l, tile.origin, pixels, see);
    }
    if frame.show_environment {
        resolve::composite_environment(l, &frame.shade, tile.origin, pixels);
    }
    job.clipping = store(l, pass, pixels, rows);
    job.tinted = pixels.transmittance.iter().any(is_tinted);
}

/// Counts what looking up the floor takes. False if a limit stops it.
fn count_ground(pass: &Pass<'_>, tile: &Tile<'_>, job: &mut TileJob) -> bool {
    let Some(ground) = &pass.frame.ground else { return true };
    let units = ground.units_of_tile(tile.size);
    job.cost.shading += units;
    pass.work.spend(Spent::Shading, units)
}

/// Finds what is behind all surfaces in each pixel of a tile: the environment, and before it the floor.
#[inline(always)]
fn find_distant<L: Lanes>(l: L, pass: &Pass<'_>, tile: &Tile<'_>, out: &mut Vec<Distant>) {
    let ([width, height], frame) = (tile.size, pass.frame);
    out.resize(width as usize * height as usize, Distant::NOTHING);
    if frame.show_environment {
        resolve::environment_behind(l, &frame.shade, tile.origin, width, out);
    }
    if let Some(ground) = &frame.ground {
        ground.cover(l, tile.origin, width, out);
    }
}

/// The frame's context with the lights that reach the tile.
#[inline(always)]
fn lit_context<'a>(pass: &Pass<'a>, tile: &Tile<'_>, lights: &'a mut Vec<PunctualLight>) -> ShadeContext<'a> {
    let (reach, shade) = (pass.frame.reach, pass.frame.shade);
    if reach.is_uniform() {
        return shade;
    }
    let ([left, top], [width, height]) = (tile.corner, tile.size);
    reach.lights_of([left, top, width, height], shade.lights, lights);
    ShadeContext { lights, ..shade }
}

/// Shades and resolves the fragments of a tile, and splats in the pixels of surfaces, until a limit stops it.
///
/// Pixels are independent of each other. Where there are more blended fragments than are kept, the opaque ones are shaded
/// alone, and parts of the tile are blended one after the other, halved until one fits.
#[inline(always)]
fn draw_parts<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of: &TileParts<'_>,
    stages: &mut TileStages,
    job: &mut TileJob,
) {
    let &TileParts { tile, opaque, .. } = of;
    let has_splats = !tile.splats().is_empty();
    if has_splats {
        stages.splats.start(pass, tile);
    }
    stages.parts.clear();
    stages.parts.push(TilePart::whole(tile.size, stages.visibility_buffer.blended.len()));
    let mut start = 0;
    while let Some(part) = stages.parts.pop() {
        // List what is blended in the part, without what parts that are done have listed.
        let TileStages { visibility_buffer, fragments, parts, .. } = stages;
        visibility_buffer.blended.truncate(part.triangles[1]);
        let fits =
            !part.blends() || draw_blended(l, pass, tile, &part, visibility_buffer, fragments, &mut job.cost);
        if pass.work.is_stopped() {
            return;
        }

        // Without blending, a fragment that covers its pixel is the pixel: these are written when they are shaded.
        let is_plain = opaque == fragments.len() && !has_splats && job.hashes.is_none();
        let whole = if is_plain { Some(pass.frame.pattern.full_mask()) } else { None };

        // Halve a part of which too much is blended.
        if !fits {
            parts.extend(part.halves(visibility_buffer.blended.len()));
            fragments.truncate(opaque);
        }

        // Shade what is not shaded yet, and put it into the pixels.
        if !shade_and_resolve(l, pass, of, start, whole, stages, job) {
            return;
        }
        if fits && has_splats && !draw_splats_among_surfaces(l, pass, of, &part, stages, job) {
            return;
        }
        stages.fragments.truncate(opaque);
        start = opaque;
    }
}

/// Shades the fragments from `start` on and puts them into the pixels: those with the mask `whole` at once. False if a limit
/// stops it.
#[inline(always)]
fn shade_and_resolve<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of: &TileParts<'_>,
    start: usize,
    whole: Option<u16>,
    stages: &mut TileStages,
    job: &mut TileJob,
) -> bool {
    let &TileParts { tile, context, opaque, one_material } = of;
    let TileStages {
        visibility_buffer, fragments, shading, shaded, distant, resolve: scratch, pixels, ..
    } = stages;
    let (fragments, triangles) = (&fragments[..], visibility_buffer.triangles(pass.frame));
    let input = ShadingInput { tile, context, triangles, fragments, start, opaque, one_material, whole };
    shaded.resize(&input);
    if start < fragments.len() && !shade_fragments(l, pass, &input, shading, shaded, pixels, job) {
        return false;
    }
    if pass.only_counts() {
        return true;
    }
    let samples = pass.frame.pattern.len();
    if start == 0 {
        resolve::sum_opaque(samples, whole, &fragments[..opaque], &shaded.fragments, pixels);
        resolve::transmittance_of(pixels);
    }
    if opaque < fragments.len() {
        let behind = Behind { kept: &shaded.transmitted, distant };
        resolve::blend(samples, fragments, &shaded.fragments, opaque, &behind, scratch, pixels);
    }
    true
}

/// Draws splats into the pixels of a part of the tile that surfaces cover too. False if a limit stops it.
#[inline(always)]
fn draw_splats_among_surfaces<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of: &TileParts<'_>,
    part: &TilePart,
    stages: &mut TileStages,
    job: &mut TileJob,
) -> bool {
    let &TileParts { tile, opaque, .. } = of;
    let TileStages { visibility_buffer, fragments, shaded, distant, resolve, pixels, splats, .. } = stages;
    let surfaces = Surfaces {
        part: part.pixels,
        visibility_buffer: &visibility_buffer.samples,
        fragments,
        shaded: &shaded.fragments,
        opaque,
        // Without blended fragments the list is another part's.
        blended: if opaque < fragments.len() { &resolve.blended } else { &[] },
        behind: Behind { kept: &shaded.transmitted, distant },
    };
    splats.draw_among(l, pass, tile, &surfaces, pixels, &mut job.aovs)
}

/// The side of a tile that keeps depth and identity in the second-level cache or closer.
pub fn default_tile_size(samples: u32) -> u32 {
    match samples {
        1 => 64,
        4 | 8 => 32,
        _ => 16,
    }
}
