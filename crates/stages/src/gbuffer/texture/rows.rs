//! Requests for rows of textures of which only some are resident.

use super::mips::Mips;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_scene::{BAND_SHIFT, MipFilter, Texture, Wrap};

/// Rows beyond those that arithmetic says: a filter reads one on each side, and another is for rounding.
const SLACK: f32 = 2.0;

/// Lanes whose rows are so far apart are asked for one after the other.
const GAP: f32 = 16.0;

/// Neighbouring lanes that read the same level.
#[derive(Clone, Copy)]
struct Run {
    level: i32,
    /// Coordinates, before they are wrapped.
    from: f32,
    to: f32,
}

/// Requests the rows that active lanes read, for textures that are read alike: around `v`, up to `reach` away, of the
/// levels of `mips`. Neighbouring lanes are taken together, so a few rows are asked for in vain.
#[inline(always)]
pub(super) fn ask<L: Lanes>(textures: &[&Texture], mips: &Mips<L>, (v, reach): (L::F, L::F), active: L::M) {
    let Some(&first) = textures.first() else { return };
    let (low, high, levels) = ((v - reach).to_array(), (v + reach).to_array(), mips.finest());
    let (lanes, layout) = (active.bits(), first.layout());
    let mut run: Option<Run> = None;
    for k in 0..LANES {
        if lanes >> k & 1 == 0 {
            continue;
        }
        let own = Run { level: levels[k], from: low[k], to: high[k] };
        let gap = GAP / layout.get(own.level as usize).map_or(1.0, |level| level.height as f32);
        run = match run {
            // What is no number joins nothing.
            Some(run) if run.level == own.level && own.from <= run.to + gap && own.to >= run.from - gap => {
                let from = if own.from < run.from { own.from } else { run.from };
                let to = if own.to > run.to { own.to } else { run.to };
                Some(Run { from, to, ..run })
            }
            Some(run) => {
                ask_for(textures, run);
                Some(own)
            }
            None => Some(own),
        };
    }
    if let Some(run) = run {
        ask_for(textures, run);
    }
}

/// Requests the rows of a run: of its level and, where levels are blended, of the next.
#[inline(never)]
fn ask_for(textures: &[&Texture], Run { level, from, to }: Run) {
    let Some(&first) = textures.first() else { return };
    let wrap = first.sampler().wrap_v;
    // Coordinates repeat: near to 0 their differences are exact.
    let base = match wrap {
        Wrap::Repeat => from.floor(),
        Wrap::MirroredRepeat => (from * 0.5).floor() * 2.0,
        Wrap::ClampToEdge => 0.0,
    };
    let far = if from.abs() > to.abs() { from.abs() } else { to.abs() };
    let last = first.level_count() - 1;
    let finest = (level.max(0) as usize).min(last);
    let blends = first.sampler().mip == MipFilter::Linear;
    let coarsest = (finest + usize::from(blends)).min(last);
    for level in finest..=coarsest {
        let height = first.layout()[level].height;
        let rows = height as f32;
        let slack = SLACK + far * rows * (4.0 * f32::EPSILON);
        let (low, high) = ((from - base) * rows - slack, (to - base) * rows + slack);
        // All of them, also where a coordinate is no number.
        let all = high - low >= rows || !(high - low).is_finite();
        let mut asking = Asking { textures, level, last: u32::MAX };
        match wrap {
            _ if all => asking.ask(0, height - 1),
            Wrap::ClampToEdge => {
                let row = |v: f32| (if v > 0.0 { v as u32 } else { 0 }).min(height - 1);
                asking.ask(row(low), row(high));
            }
            Wrap::Repeat => {
                let (low, high) = (low.floor() as i64, high.floor() as i64);
                let start = low.rem_euclid(height.into()) as u32;
                let end = start + (high - low) as u32;
                asking.ask(start, end.min(height - 1));
                if end >= height {
                    asking.ask(0, end - height);
                }
            }
            Wrap::MirroredRepeat => {
                let period = 2 * i64::from(height);
                for row in low.floor() as i64..=high.floor() as i64 {
                    let row = row.rem_euclid(period) as u32;
                    let row = if row < height { row } else { 2 * height - 1 - row };
                    asking.ask(row, row);
                }
            }
        }
    }
}

/// Requests for rows of a level.
struct Asking<'a> {
    textures: &'a [&'a Texture],
    level: usize,
    /// The band that was asked for last.
    last: u32,
}

impl Asking<'_> {
    /// Requests the rows from one to another.
    fn ask(&mut self, from: u32, to: u32) {
        for band in from >> BAND_SHIFT..=to >> BAND_SHIFT {
            if band == self.last {
                continue;
            }
            self.last = band;
            for texture in self.textures {
                let (Some(bands), Some(form)) = (texture.bands(), texture.form()) else { continue };
                let band = bands.first(self.level) + band;
                if !bands.has(band) {
                    form.want(band);
                }
            }
        }
    }
}
