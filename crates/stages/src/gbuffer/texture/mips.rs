//! The levels of a texture that fragments read, and how their texels are combined.

use super::MAX_TOGETHER;
use super::texels::{Corners, LevelLanes, wrap};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};
use overcoat_scene::{Filter, MipFilter, Texture};

/// Parts that are fetched before any is used: texels that are not in the cache come together.
pub(super) const TOGETHER: usize = 2;

/// Texels on the way to a texture's colour: memory that is kept, since to clear it for each batch takes a fiftieth of a
/// textured frame.
pub struct Fetched<L: Lanes> {
    pub(super) parts: FetchedParts<L>,
    /// Colours that one of several probes finds in each texture.
    pub(super) probe: [[L::F; 4]; MAX_TOGETHER],
}

/// Parts that are fetched together: the places of their texels, if no plan knows them, and the texels of each texture
/// as they lie in memory.
pub(super) struct FetchedParts<L: Lanes> {
    corners: [Corners<L>; TOGETHER],
    texels: [[[L::I; 4]; MAX_TOGETHER]; TOGETHER],
}

impl<L: Lanes> Fetched<L> {
    /// Nothing yet.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        let texels = [[[l.splat_i(0); 4]; MAX_TOGETHER]; TOGETHER];
        Self {
            parts: FetchedParts { corners: [Corners::none(l); TOGETHER], texels },
            probe: [[l.zero(); 4]; MAX_TOGETHER],
        }
    }
}

/// Mip levels that a fragment reads, and their weights.
#[derive(Clone, Copy)]
pub(super) struct Mips<L: Lanes> {
    /// The finest level of each lane.
    level: L::I,
    /// Lanes whose finest level is level 0.
    at_0: L::M,
    /// The level of all active lanes, if they have one: neighbouring fragments nearly always do.
    common: Option<i32>,
    /// Weight of the next coarser level for each lane, 0 to 1.
    fraction: L::F,
    /// Lanes that are magnified and need another filter for it.
    magnified: L::M,
    /// Parts that some lane reads, in the order of use.
    parts: [Part; 4],
    /// Number of parts in use.
    count: usize,
}

/// A part of what fragments read, in the order of use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The finest level of each lane; of lanes with different ones, those that are not at level 0.
    Finest,
    /// Level 0, which lies in an array of its own, for lanes with different levels.
    Level0,
    /// The next coarser level.
    Coarser,
    /// Level 0 with the filter of magnification.
    Magnified,
}

impl<L: Lanes> Mips<L> {
    /// Nothing is read.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        let none = l.mask(0);
        let (level, fraction) = (l.splat_i(0), l.zero());
        Self {
            level,
            at_0: none,
            common: None,
            fraction,
            magnified: none,
            parts: [Part::Finest; 4],
            count: 0,
        }
    }

    /// By the level of detail of each lane.
    #[inline(always)]
    pub fn new(l: L, texture: &Texture, lambda: L::F, active: L::M) -> Self {
        let sampler = texture.sampler();
        let clamped = lambda.clamp_to(0.0, (texture.level_count() - 1) as f32);
        let (level, fraction) = match sampler.mip {
            MipFilter::None => (l.splat_i(0), l.zero()),
            MipFilter::Nearest => {
                // The nearest level, the finer one in the middle: ceil(lambda + 1/2) - 1.
                let above = (clamped + 0.5).to_int();
                let is_middle = above.to_float().eq(clamped + 0.5) & l.zero().lt(clamped);
                (is_middle.select_i(above + -1, above), l.zero())
            }
            MipFilter::Linear => {
                let level = clamped.to_int();
                (level, clamped - level.to_float())
            }
        };
        let mut magnified = l.mask(0);
        if sampler.magnification != sampler.minification {
            magnified = lambda.le(l.zero());
        }
        let first = level.to_array()[active.bits().trailing_zeros() as usize % LANES];
        let common = (level.eq(l.splat_i(first)) | !active).all().then_some(first);
        let at_0 = level.eq(l.splat_i(0));
        let minifies = (!magnified & active).any();
        let needed = [
            (Part::Finest, minifies),
            (Part::Level0, minifies && common.is_none() && (at_0 & active).any()),
            (Part::Coarser, (l.zero().lt(fraction) & active).any()),
            (Part::Magnified, (magnified & active).any()),
        ];
        let mut parts = [Part::Finest; 4];
        let mut count = 0;
        for (part, is_needed) in needed {
            if is_needed {
                parts[count] = part;
                count += 1;
            }
        }
        Self { level, at_0, common, fraction, magnified, parts, count }
    }

    /// Parts that some lane reads, in this order.
    #[inline(always)]
    pub fn parts(&self) -> &[Part] {
        &self.parts[..self.count.min(self.parts.len())]
    }

    /// Texels at `uv`, filtered but not finished. With the corners of the first parts, if they are `known`.
    #[inline(always)]
    pub fn sample(
        &self,
        l: L,
        textures: &[&Texture],
        uv: [L::F; 2],
        known: Option<&[Corners<L>; TOGETHER]>,
        fetched: &mut FetchedParts<L>,
        out: &mut [[L::F; 4]],
    ) {
        let Some(&texture) = textures.first() else { return };
        let FetchedParts { corners, texels: fetched } = fetched;
        let mut wrapped = [l.zero(); 2];
        if known.is_none() || self.count > TOGETHER {
            wrapped = wrap(texture.sampler(), uv);
        }
        for (turn, parts) in self.parts().chunks(TOGETHER).enumerate() {
            let corners = match known {
                Some(known) if turn == 0 => known,
                _ => {
                    for (corners, part) in corners.iter_mut().zip(parts) {
                        *corners = self.corners(l, texture, wrapped, *part);
                    }
                    &*corners
                }
            };
            // All are fetched before any is used: texels that are not in the cache come together.
            for ((corners, texels), _) in corners.iter().zip(fetched.iter_mut()).zip(parts) {
                corners.fetch(l, textures, texels);
            }
            for (n, (&texture, out)) in textures.iter().zip(out.iter_mut()).enumerate() {
                for ((corners, texels), &part) in corners.iter().zip(&*fetched).zip(parts) {
                    *out = self.add(part, corners.weights.filter(l, texture, texels[n]), *out);
                }
            }
        }
    }

    /// Adds the texel of one more part to the sum so far.
    #[inline(always)]
    fn add(&self, part: Part, texel: [L::F; 4], sum: [L::F; 4]) -> [L::F; 4] {
        each!(n => match part {
            Part::Finest if self.common.is_some() => texel[n],
            Part::Finest => self.at_0.select(sum[n], texel[n]),
            Part::Level0 => self.at_0.select(texel[n], sum[n]),
            Part::Coarser => sum[n].lerp(texel[n], self.fraction),
            Part::Magnified => self.magnified.select(texel[n], sum[n]),
        })
    }

    /// Places of a part's texels, for coordinates that [`wrap`] gave.
    #[inline(always)]
    pub fn corners(&self, l: L, texture: &Texture, wrapped: [L::F; 2], part: Part) -> Corners<L> {
        let (levels, filter) = self.levels(l, texture, part);
        Corners::new(l, texture.sampler(), &levels, wrapped, filter)
    }

    /// The finest level of each lane: magnified ones read level 0, which is theirs.
    #[inline(always)]
    pub fn finest(&self) -> [i32; LANES] {
        self.level.to_array()
    }

    /// The levels of a part, and how they are filtered.
    #[inline(always)]
    fn levels<'a>(&self, l: L, texture: &'a Texture, part: Part) -> (LevelLanes<'a, L>, Filter) {
        let sampler = texture.sampler();
        let last = (texture.level_count() - 1) as i32;
        let (level, common, filter) = match part {
            Part::Finest => (self.level, self.common, sampler.minification),
            Part::Coarser => {
                let coarser = (self.level + 1).min(l.splat_i(last));
                let common = match self.common {
                    Some(level) => Some((level + 1).min(last)),
                    None => None,
                };
                (coarser, common, sampler.minification)
            }
            Part::Level0 => (self.level, Some(0), sampler.minification),
            Part::Magnified => (self.level, Some(0), sampler.magnification),
        };
        let levels = match common {
            Some(level) => LevelLanes::uniform(l, texture, level),
            None => LevelLanes::reduced(l, texture, &level.to_array()),
        };
        (levels, filter)
    }
}
