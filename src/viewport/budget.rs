//! Choice of quality for pictures that have to be drawn within a budget.

use overcoat_render::{Quality, RenderOptions, RenderStats, WorkDone};
use overcoat_scene::Scene;
use std::cmp::Reverse;
use std::time::Duration;

/// Budget of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameBudget {
    /// Units of work, counted and not timed: the same pictures on every machine. A unit is about a nanosecond of one thread (within
    /// a factor of 2 for three models in tiers up to `good`, on a machine of 2026 with AVX-512): with two threads 33,000,000 are
    /// about a sixtieth of a second there.
    Work(u64),
    /// Time by the clock. How well a picture is drawn then depends on the machine and what else it does, so no hash of it says
    /// anything; each picture is the one of its [`Level`] all the same.
    Time(Duration),
}

/// Quality of a picture: tier, samples and resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// The tier.
    pub quality: Quality,
    /// Coverage samples a pixel.
    pub samples: u32,
    /// Pixels of the target, in each direction, for one that is drawn: 1, or 2 to 4 where a picture of fewer pixels is made as large as
    /// the target.
    pub scale: u32,
}

/// Scales of pictures for which there is no time otherwise, and their samples.
const SCALES: [u32; 3] = [2, 3, 4];
const SCALED_SAMPLES: u32 = 4;

impl Level {
    /// From the best to the cheapest: first the tiers with all samples, then drafts with fewer, then, where the target can be filled so,
    /// drafts of fewer pixels.
    pub(super) fn all(best: Quality, samples: u32, scales: bool) -> Vec<Self> {
        let draft = |samples, scale| Self { quality: Quality::Draft, samples, scale };
        let tiers = Quality::ALL.iter().rev().skip_while(|quality| **quality != best);
        let tiers = tiers.map(|&quality| Self { quality, samples, scale: 1 });
        let fewer = [4, 1].into_iter().filter(|fewer| *fewer < samples);
        let fewer = fewer.map(|samples| draft(samples, 1));
        let scales = SCALES.iter().filter(|_| scales);
        let scaled = scales.map(|scale| draft(samples.min(SCALED_SAMPLES), *scale));
        tiers.chain(fewer).chain(scaled).collect()
    }

    /// The better, the larger.
    pub(super) fn rank(self) -> (usize, Reverse<u32>, u32) {
        let tier = Quality::ALL.iter().position(|quality| *quality == self.quality);
        (tier.unwrap_or_default(), Reverse(self.scale), self.samples)
    }

    /// Size of the picture that is drawn for a target of this size.
    pub(super) fn size(self, target: [u32; 2]) -> [u32; 2] {
        target.map(|side| side.div_ceil(self.scale))
    }

    /// About what its pixels take beside those of a draft with eight samples: medians of frames of the sports car, the material ball and a knot of
    /// 100,000 triangles at 1280 x 720, on one thread.
    fn weight(self) -> f64 {
        let tier = match self.quality {
            Quality::Draft => 1.0,
            Quality::Fast => 2.2,
            Quality::Good => 17.0,
            Quality::Best => 38.0,
        };
        let samples = match self.samples {
            1 => 0.53,
            4 => 0.88,
            16 => 1.25,
            _ => 1.0,
        };
        tier * samples / f64::from(self.scale * self.scale)
    }
}

/// Nanoseconds, about: of a triangle, whether it is seen or not; of a block of 4 x 4 pixels that a triangle is drawn into; of a
/// pixel; of a fragment, beside its shading.
const TRIANGLE: u64 = 12;
const BLOCK: u64 = 12;
const PIXEL: u64 = 3;
const FRAGMENT: u64 = 12;
/// Units of shading, which are what it may take at the most, to a nanosecond; and where rays are counted, most of which find less
/// than they might.
const SHADING: u64 = 2;
const SHADING_WITH_RAYS: u64 = 10;
/// Cost of a pixel of a model that nothing is known of, all included, with half of the picture covered.
const UNKNOWN_PIXEL: u64 = 90;

/// Part of the budget that the next better level has to stay within: what it takes is only guessed.
const ROOM: f64 = 0.8;

/// Cost of making one pixel of the target of fewer pixels.
const SCALED_PIXEL: u64 = 5;

/// Chooses levels.
#[derive(Debug, Default)]
pub(super) struct Controller {
    budget: Option<FrameBudget>,
    last: Option<Spent>,
}

/// Cost of a picture, in the unit of the budget.
#[derive(Clone, Copy, Debug)]
struct Spent {
    level: Level,
    all: f64,
    /// Part that pictures of fewer pixels cost as well.
    fixed: f64,
}

impl Spent {
    /// Guess of what the same picture costs at another level.
    fn at(self, level: Level) -> f64 {
        let ratio = level.weight() / self.level.weight();
        if level.scale == self.level.scale {
            return self.all * ratio;
        }
        self.fixed + (self.all - self.fixed) * ratio
    }
}

impl Controller {
    pub(super) fn set_budget(&mut self, budget: Option<FrameBudget>) {
        if self.budget != budget {
            *self = Self { budget, last: None };
        }
    }

    /// The level of the next picture, of those that there are, the best of them first.
    pub(super) fn choose(&self, levels: &[Level], scene: &Scene, options: &RenderOptions) -> Level {
        let best = levels.first().copied().unwrap_or(Level {
            quality: Quality::Draft,
            samples: options.samples,
            scale: 1,
        });
        let Some(budget) = self.budget else { return best };
        let most = match budget {
            FrameBudget::Work(units) => units as f64,
            FrameBudget::Time(time) => time.as_nanos() as f64,
        };
        let spent = self.last.unwrap_or_else(|| {
            let pixels = u64::from(options.width) * u64::from(options.height);
            let fixed = (scene.triangle_count() * TRIANGLE) as f64;
            let all = fixed + (pixels * UNKNOWN_PIXEL) as f64;
            Spent { level: Level { quality: Quality::Draft, samples: 8, scale: 1 }, all, fixed }
        });
        let fits = |level: &&Level| {
            // The level that it was needs no room; a better one is guessed to need some.
            let room = if **level == spent.level { 1.0 } else { ROOM };
            spent.at(**level) <= most * room
        };
        levels.iter().find(fits).or(levels.last()).copied().unwrap_or(best)
    }

    /// Takes over what a picture took: counts and time, and the pixels of its target.
    pub(super) fn learn(
        &mut self,
        level: Level,
        stats: &RenderStats,
        work: &WorkDone,
        [width, height]: [u32; 2],
        time: Duration,
    ) {
        let Some(budget) = self.budget else { return };
        let has_rays = level.quality.visibility().rays > 0;
        let shading = work.shading / if has_rays { SHADING_WITH_RAYS } else { SHADING };
        let [target, drawn] = [[width, height], level.size([width, height])]
            .map(|[width, height]| u64::from(width) * u64::from(height));
        let scaled = if level.scale > 1 { target } else { 0 };
        let sum = |counts: &[(u64, u64)]| {
            counts.iter().fold(0_u64, |sum, (n, each)| sum.saturating_add(n.saturating_mul(*each))) as f64
        };
        let fixed = sum(&[(stats.triangles, TRIANGLE), (scaled, SCALED_PIXEL)]);
        let all =
            fixed + sum(&[(work.blocks, BLOCK), (work.fragments, FRAGMENT), (shading, 1), (drawn, PIXEL)]);
        let unit = match budget {
            FrameBudget::Work(_) => 1.0,
            FrameBudget::Time(_) => time.as_nanos() as f64 / all.max(1.0),
        };
        self.last = Some(Spent { level, all: all * unit, fixed: fixed * unit });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEGA: u64 = 1_000_000;

    fn levels() -> Vec<Level> {
        Level::all(Quality::Good, 8, false)
    }

    fn learnt(spent: u64, level: Level, budget: u64) -> Level {
        let mut controller = Controller::default();
        controller.set_budget(Some(FrameBudget::Work(budget)));
        let mut work = WorkDone::default();
        work.blocks = spent / BLOCK;
        controller.learn(level, &RenderStats::default(), &work, [0, 0], Duration::MAX);
        controller.choose(&levels(), &Scene::new(), &RenderOptions::draft(64, 64))
    }

    #[test]
    fn levels_go_down_from_the_best() {
        let names: Vec<_> = levels().iter().map(|level| (level.quality.name(), level.samples)).collect();
        assert_eq!(names, [("good", 8), ("fast", 8), ("draft", 8), ("draft", 4), ("draft", 1)]);
        assert!(levels().windows(2).all(|w| w[0].rank() > w[1].rank() && w[0].weight() > w[1].weight()));
        assert_eq!(Level::all(Quality::Draft, 1, false).len(), 1);
        assert_eq!(Level::all(Quality::Best, 16, false).len(), 6);
        let scaled = Level::all(Quality::Fast, 8, true);
        assert!(scaled.windows(2).all(|w| w[0].rank() > w[1].rank() && w[0].weight() > w[1].weight()));
        let last: Vec<_> = scaled.iter().rev().take(3).map(|level| (level.scale, level.samples)).collect();
        assert_eq!(last, [(4, 4), (3, 4), (2, 4)]);
        assert_eq!(scaled[5].size([1281, 1]), [427, 1]);
    }

    #[test]
    fn a_picture_that_took_too_much_is_followed_by_a_cheaper_one_and_back_with_room() {
        let [good, fast, draft, _, least] = levels()[..] else { panic!() };
        assert_eq!(learnt(20 * MEGA, good, 30 * MEGA), good);
        assert_eq!(learnt(50 * MEGA, good, 30 * MEGA), fast);
        assert_eq!(learnt(900 * MEGA, good, 30 * MEGA), least);
        assert_eq!(learnt(10 * MEGA, draft, 30 * MEGA), fast);
        assert_eq!(learnt(10 * MEGA, draft, 250 * MEGA), good);
        // A level that fits is kept, though little is left.
        assert_eq!(learnt(29 * MEGA, fast, 30 * MEGA), fast);
    }

    #[test]
    fn the_clock_does_not_count_unless_it_is_asked_and_nothing_counts_without_a_budget() {
        let mut controller = Controller::default();
        let (scene, options) = (Scene::new(), RenderOptions::draft(64, 64));
        assert_eq!(controller.choose(&levels(), &scene, &options), levels()[0]);
        controller.set_budget(Some(FrameBudget::Time(Duration::from_millis(10))));
        let stats = RenderStats::default();
        let mut work = WorkDone::default();
        work.blocks = 1000;
        controller.learn(levels()[0], &stats, &work, [8, 8], Duration::from_millis(500));
        assert_eq!(controller.choose(&levels(), &scene, &options), levels()[4]);
        controller.learn(levels()[4], &stats, &work, [8, 8], Duration::from_micros(10));
        assert_eq!(controller.choose(&levels(), &scene, &options), levels()[0]);
        // Before anything is known, by the size of the picture.
        controller.set_budget(Some(FrameBudget::Work(16 * MEGA)));
        assert_eq!(controller.choose(&levels(), &scene, &options), levels()[0]);
        assert_eq!(controller.choose(&levels(), &scene, &RenderOptions::draft(4096, 4096)), levels()[4]);
    }

    /// Costs of triangles stay where pixels are fewer.
    #[test]
    fn fewer_pixels_are_drawn_where_pixels_are_dear_and_no_more_than_needed() {
        let levels = Level::all(Quality::Fast, 8, true);
        let chosen = |triangles: u64, blocks: u64| {
            let mut controller = Controller::default();
            controller.set_budget(Some(FrameBudget::Work(33 * MEGA)));
            let (mut stats, mut work) = (RenderStats::default(), WorkDone::default());
            (stats.triangles, work.blocks) = (triangles * MEGA / TRIANGLE, blocks * MEGA / BLOCK);
            let least = Level { quality: Quality::Draft, samples: 1, scale: 1 };
            controller.learn(least, &stats, &work, [8, 8], Duration::ZERO);
            controller.choose(&levels, &Scene::new(), &RenderOptions::draft(64, 64)).scale
        };
        assert_eq!([chosen(1, 31), chosen(1, 50), chosen(1, 100), chosen(1, 250)], [1, 2, 3, 4]);
        // Fewer pixels do not help, and the fewest are as near as it gets.
        assert_eq!(chosen(40, 10), 4);
    }
}
