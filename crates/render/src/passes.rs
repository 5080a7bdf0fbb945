//! The passes that the tiles of a frame take, in their order.

use super::picture::Request;
use super::tiles::{Found, TileMemory, count_tiles, feedback_tiles, render_tiles};
use overcoat_core::frame::{Developer, Meter, Target, TargetWriter};
use overcoat_core::limits::LimitExceeded;
use overcoat_stages::shade::Effects;
use overcoat_tiles::effects::EffectMemory;
use overcoat_tiles::pass::{FrameContext, Pass, PassKind, Purpose, Wanted};
use overcoat_tiles::strips::Planes;
use overcoat_tiles::timed_pool::TimedPool;
use overcoat_tiles::work::{Spent, Work};

/// Memory of the passes that is kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct PassMemory {
    tiles: TileMemory,
    pub effects: EffectMemory,
    /// Planes of pictures that were given back.
    pub planes: Planes,
}

impl PassMemory {
    /// Runs the feedback pass: fragments of all tiles of a frame ask for the textures that they read.
    pub(super) fn draw_feedback(
        &mut self,
        pool: &mut TimedPool<'_>,
        frame: &FrameContext<'_>,
        request: &Request<'_>,
    ) {
        // The last pass has all surfaces. What it takes is counted by those that draw.
        let Some(&kind) = PassKind::of(frame.states).last() else { return };
        let work = &work_of(frame, request);
        let pass = Pass {
            frame,
            kind,
            purpose: Purpose::Feedback,
            effects: Effects::default(),
            work,
            traced_tiles: None,
        };
        feedback_tiles(pool, &pass, &mut self.tiles, request.options.simd);
    }

    /// Counts the work of all tiles of a frame without rays, until a limit stops it. Nothing is shaded.
    pub(super) fn count(
        &mut self,
        pool: &mut TimedPool<'_>,
        frame: &FrameContext<'_>,
        work: &Work<'_>,
        request: &Request<'_>,
    ) {
        if let Some(ground) = &frame.ground {
            work.spend(Spent::Shading, ground.units);
        }
        self.pass_over(pool, frame, (Purpose::Count, work), request);
        self.tiles.counted = work.sum(Spent::Fragments);
    }

    /// Sends the rays of few pixels of a frame, whose work counts for all, until a limit stops it.
    pub(super) fn probe(
        &mut self,
        pool: &mut TimedPool<'_>,
        frame: &FrameContext<'_>,
        work: &Work<'_>,
        request: &Request<'_>,
    ) {
        self.pass_over(pool, frame, (Purpose::Probe, work), request);
    }

    /// All passes of a frame, without a picture.
    fn pass_over(
        &mut self,
        pool: &mut TimedPool<'_>,
        frame: &FrameContext<'_>,
        (purpose, work): (Purpose<'_>, &Work<'_>),
        request: &Request<'_>,
    ) {
        for &kind in PassKind::of(frame.states) {
            let effects = if matches!(purpose, Purpose::Probe) {
                self.effects.of(kind, &[])
            } else {
                Effects::default()
            };
            let pass = Pass { frame, kind, purpose, effects, work, traced_tiles: None };
            feedback_tiles(pool, &pass, &mut self.tiles, request.options.simd);
        }
    }

    /// Draws all tiles of a frame: in one pass, or in one for each [`PassKind`] that it takes.
    pub(super) fn draw(
        &mut self,
        pool: &mut TimedPool<'_>,
        frame: &FrameContext<'_>,
        work: &Work<'_>,
        request: &Request<'_>,
        mut target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> (Planes, Found) {
        let &Request { scene, options, display, only_planes, .. } = request;
        let (kinds, count) = (PassKind::of(frame.states), frame.grid.pixel_count());
        // What is metered is developed when all of it is known.
        let mut developer = display.filter(|display| display.meter == Meter::Never).map(Developer::new);
        let writer = target
            .as_ref()
            .zip(developer)
            .map(|((target, _), developer)| TargetWriter::new(target.format(), developer));
        if writer.is_some() {
            developer = None;
        }
        let mut planes = Planes::default();
        // Linear light is kept for what is seen through surfaces that refract, what is metered, and hashes; planes of the G-buffer
        // alone have none.
        if (developer.is_none() && writer.is_none() && !only_planes)
            || kinds.contains(&PassKind::Backdrop)
            || options.stage_hashes
        {
            planes.add_light(&mut self.planes, count, frame.tints);
        }
        let mut found = Found::default();
        for &kind in kinds {
            let mut wanted = Wanted::default();
            if kind != PassKind::Backdrop {
                let (clipping, hashes) = (!scene.lights().is_empty(), options.stage_hashes);
                let clipping = clipping && writer.is_none();
                let aovs = if writer.is_some() { &[] } else { &options.aovs[..] };
                wanted = Wanted { developer, target: writer, clipping, aovs, hashes, only_planes };
                if display.is_some() && writer.is_none() {
                    planes.add_display(&mut self.planes, count);
                }
            }
            let (purpose, effects) = (Purpose::Draw(wanted), self.effects.of(kind, wanted.aovs));
            let pass = Pass { frame, kind, purpose, effects, work, traced_tiles: None };
            let fragments = found.fragments;
            let target = target
                .as_mut()
                .filter(|_| wanted.target.is_some())
                .map(|(target, region)| (&mut **target, *region));
            found = render_tiles(pool, &pass, &mut self.tiles, &mut planes, target, options.simd);
            found.fragments += fragments;
            self.effects.after(kind, pool, &frame.grid, &planes.linear);
        }
        (planes, found)
    }
}

/// The limit that one thread would pass first, if the work of a frame passes any.
pub(super) fn check_limits(frame: &FrameContext<'_>, request: &Request<'_>) -> Result<(), LimitExceeded> {
    let work = &work_of(frame, request);
    let mut costs = Vec::new();
    for &kind in PassKind::of(frame.states) {
        let pass = Pass {
            frame,
            kind,
            purpose: Purpose::Count,
            effects: Effects::default(),
            work,
            traced_tiles: None,
        };
        count_tiles(&pass, &mut costs, request.options.simd);
    }
    work.check()
}

/// Counters of a frame's work within its limits, with what was spent before the tiles.
pub(super) fn work_of<'a>(frame: &FrameContext<'_>, request: &Request<'a>) -> Work<'a> {
    let &Request { jobs, options, .. } = request;
    let pixels = frame.grid.pixel_count() as u64;
    let work = Work::new(&options.limits, pixels, options.shading_groups()).stopped_by(jobs.cancellation());
    if let Some(ground) = &frame.ground {
        work.spend(Spent::Shading, ground.units);
    }
    work
}
