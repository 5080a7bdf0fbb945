//! The rays of some rows of tiles, sent before what they have found is filtered and shaded: a pixel takes what the pixels around it have
//! found, in the tiles beside its own too.

use super::tiles::render_tile;
use overcoat_core::jobs::Scratch;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::tile::TileGrid;
use overcoat_tiles::light_filter::Neighbourhood;
use overcoat_tiles::light_pool::TracedTile;
use overcoat_tiles::pass::{Pass, Purpose};
use overcoat_tiles::strips::TileRows;
use overcoat_tiles::tile_pass::{TileJob, TileScratch};
use overcoat_tiles::timed_pool::TimedPool;

/// Fragments of the rows of tiles that are shaded at once, about, if all rows have as many. What their rays have found takes some
/// 500 bytes a fragment; no more of a picture than this, and a row of tiles on both sides, has it at a time.
const FRAGMENTS_AT_ONCE: u64 = 1 << 17;

/// Findings of the rays of the tiles of some rows.
#[derive(Debug, Default)]
pub(super) struct TracedRows {
    /// Each at its number modulo their count.
    tiles: Vec<TracedTile>,
    /// Rows of tiles whose rays are sent.
    sent: u32,
    /// Empty between runs.
    jobs: Vec<TileJob>,
}

impl TracedRows {
    /// Begins a run over all tiles of a picture of so many fragments. Returns the number of rows of tiles that are shaded at
    /// once.
    pub(super) fn start(&mut self, grid: &TileGrid, fragments: u64) -> u32 {
        let rows = grid.rows().max(1);
        let of_row = (fragments / u64::from(rows)).max(1);
        let at_once = (FRAGMENTS_AT_ONCE / of_row).clamp(1, u64::from(rows)) as u32;
        let known = grid.rows().min(at_once + 2) * grid.columns();
        self.tiles.resize_with(known as usize, TracedTile::default);
        self.sent = 0;
        at_once
    }

    /// The known tiles: those that are shaded, and those around them.
    pub(super) fn known<'a>(&'a self, grid: &'a TileGrid) -> Neighbourhood<'a> {
        Neighbourhood { grid, tiles: &self.tiles }
    }

    /// Sends the rays of tiles before those of a row are shaded, and of the row after them.
    pub(super) fn trace_before(
        &mut self,
        row: u32,
        pool: &mut TimedPool<'_>,
        pass: &Pass<'_>,
        scratch: &mut Scratch<TileScratch>,
        simd: SimdLevel,
    ) {
        let grid = &pass.frame.grid;
        let [start, end] = [self.sent, grid.rows().min(row + 1)].map(|row| (row * grid.columns()) as usize);
        self.sent = grid.rows().min(row + 1);
        let Self { tiles, jobs, .. } = self;
        let places = tiles.len().max(1);
        jobs.extend((start..end).map(|number| TileJob {
            traced: std::mem::take(&mut tiles[number % places]),
            ..TileJob::default()
        }));
        // Drawn tiles are counted when they are shaded, tiles beyond them not at all.
        let works = [false, true].map(|is_free| pass.work.anew(is_free));
        pool.for_each_with_scratch(scratch, jobs, |scratch, number, job| {
            let number = start + number;
            job.traced.start(0, [0; 2], 1);
            if is_looked_at(pass, number) {
                let work = &works[usize::from(!pass.draws(number))];
                let pass = Pass { purpose: Purpose::Trace, work, ..*pass };
                let (tile, rows) = (&pass.tile(number), &mut TileRows::default());
                render_tile(simd, &pass, tile, scratch, rows, job);
            }
        });
        for (number, job) in (start..end).zip(jobs.drain(..)) {
            tiles[number % places] = job.traced;
        }
        if works.iter().any(|work| work.is_stopped()) {
            pass.work.stop();
        }
    }
}

/// True if a tile or one beside it is shaded.
fn is_looked_at(pass: &Pass<'_>, number: usize) -> bool {
    let grid = &pass.frame.grid;
    let [column, row] = [number as u32 % grid.columns(), number as u32 / grid.columns()];
    let around = |at: u32, end: u32| at.saturating_sub(1)..(at + 2).min(end);
    around(row, grid.rows()).any(|row| {
        around(column, grid.columns()).any(|column| {
            let number = (row * grid.columns() + column) as usize;
            pass.draws(number) && !pass.keeps(&pass.tile(number))
        })
    })
}
