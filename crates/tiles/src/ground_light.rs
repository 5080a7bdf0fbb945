//! Light that reaches the floor: a picture of it from above, found once for a scene.

use super::ground::{Ground, footing_of};
use super::ground_lamps::GroundLamps;
use super::ground_part::ShownPart;
use super::lamps::LightMemory;
use super::occlusion::asked_for;
use super::options::RenderOptions;
use super::quality::Visibility;
use super::timed_pool::TimedPool;
use overcoat_core::built;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::{dispatch, dispatch_available};
use overcoat_scene::{Footing, Revision, Scene};
use overcoat_stages::geometry::View;
use overcoat_stages::light::{EnvironmentLight, LUMINANCE};
use overcoat_stages::shade::{DistantLight, LightOcclusion};
use overcoat_stages::shadow::{Pyramids, Receiver};
use std::f32::consts::FRAC_1_PI;

/// Least and most texels along a side of the picture, which has as many as the maps between these. Of 128, those in the middle are
/// a 96th of [`Footing::radius`] wide: less than those of the maps.
const SIZES: [u32; 2] = [64, 256];

/// Distance from its middle to which the floor reaches, in [`Footing::radius`].
const REACH: f64 = 2.0;

/// Part of the reach within which the floor does not fade.
const WHOLE: f32 = 0.5;

/// Texels are the finer the closer they lie to the middle: a place u = x (1 + c) / (|x| + c) along each axis, with x and u from
/// -1 to 1 over the reach. The smaller c, the finer.
const BEND: f32 = 0.5;

/// Half of the widest angle that one direction stands for, as a tangent.
const WIDEST: f32 = 0.5;

/// Units of shading (about a nanosecond) for one texel and one map.
const TEXEL: u64 = 12;

/// The floor's picture, and what it was made of.
#[derive(Debug, Default)]
pub struct GroundLight {
    known: Option<Known>,
    /// Place of the floor below the last scene, which all of its vertices decide.
    below: Option<(Revision, Option<Footing>)>,
    /// Texels along a side.
    size: usize,
    /// Bits of floats, row by row, in each row one plane after the other: irradiance over pi in three colours; or one number, the
    /// part of its luminance that does not arrive; or, where pixels add lamps to it ([`GroundLamps`]), the luminance that
    /// arrives and the one that would.
    texels: Vec<u32>,
    /// Texels that are found, a bit for sixteen of a row: those that the first picture shows, then all.
    found: Vec<bool>,
}

/// Inputs that a picture is made of; it is found anew when they change.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    footing: Footing,
    /// Number of the maps.
    maps: u64,
    planes: usize,
    /// Lamps are left to the pixels.
    lamps_apart: bool,
    /// Number of times that the lights had changed.
    lights: u64,
}

impl GroundLight {
    /// Finds what a view shows of it, unless that is known: all of it once another view shows more. `maps` is the number of the
    /// maps among all that were made.
    pub fn prepare(
        &mut self,
        pool: &TimedPool<'_>,
        (scene, view): (&Scene, &View),
        occlusion: Option<(LightOcclusion<'_>, u64)>,
        (environment, lights): (&EnvironmentLight<'_>, &LightMemory),
        options: &RenderOptions,
    ) {
        if !built::Shadows::IS_BUILT {
            return;
        }
        let lamps_apart = GroundLamps::shadows(lights).is_some();
        let planes = match (options.ground, lamps_apart) {
            (Ground::Shadow, false) => 1,
            (Ground::Shadow, true) => 2,
            _ => 3,
        };
        let found = occlusion.and_then(|maps| Some((maps, self.place_of(scene, options)?)));
        let changes = lights.changes();
        let known =
            found.map(|((_, maps), footing)| Known { footing, maps, planes, lamps_apart, lights: changes });
        let is_known = std::mem::replace(&mut self.known, known) == known;
        let Some(((occlusion, _), footing)) = found else { return };
        if !is_known {
            self.size = size_of_picture(&asked_for(options));
            self.texels.clear();
            self.texels.resize(self.size * self.size * planes, 0);
            self.found.clear();
            self.found.resize(self.size * self.size / LANES, false);
        }
        let wanted = self.wanted(&ShownPart::of(view, &footing), is_known, options.stage_hashes);
        if wanted.is_empty() {
            return;
        }
        let level = options.simd;
        let above = dispatch!(level, l => {
            let up = Vec3::splat(l, [0.0, 1.0, 0.0]);
            environment.irradiance_over_pi(l, up).to_arrays()
        });
        let mut shadows = Shadows {
            size: self.size,
            irradiance: each!(c in above => c[0]),
            lights: Some(lights),
            lamps_apart,
            ..Shadows::new(&occlusion, footing, planes, (pool.jobs, level))
        };
        shadows.find_tint(pool, level);
        let blocks = self.size / LANES;
        pool.jobs.for_each_chunk_mut(&mut self.texels, self.size * planes, |row, texels| {
            if !pool.jobs.is_cancelled() {
                let wanted = &wanted[row * blocks..][..blocks];
                dispatch_available!(level, l => shadows.row(l, (row, wanted), texels));
            }
        });
        self.found.iter_mut().zip(wanted).for_each(|(found, wanted)| *found |= wanted);
        if pool.jobs.is_cancelled() {
            self.known = None;
        }
    }

    /// Texels that are yet to be found, sixteen of a row each: those that a view shows, or all of the rest if `has_some` are
    /// found and one is missing. Empty if none is.
    fn wanted(&self, shown: &ShownPart, has_some: bool, all: bool) -> Vec<bool> {
        let blocks = self.size / LANES;
        // Pixels look between texels.
        let between = |first: usize, count: usize| {
            [first as f64 - 1.0, (first + count) as f64].map(|index| place_of(index, self.size))
        };
        let is_shown = |block: usize| {
            all || shown.may_show(between(block % blocks * LANES, LANES), between(block / blocks, 1))
        };
        let is_wanted = |block: &usize| !self.found[*block] && is_shown(*block);
        if !(0..self.found.len()).any(|block| is_wanted(&block)) {
            return Vec::new();
        }
        (0..self.found.len())
            .map(|block| if has_some { !self.found[block] } else { is_wanted(&block) })
            .collect()
    }

    /// Place of the floor of a scene, which is not looked for again in the same one.
    fn place_of(&mut self, scene: &Scene, options: &RenderOptions) -> Option<Footing> {
        if options.ground_under.is_some() {
            return footing_of(scene, options);
        }
        match self.below {
            Some((revision, footing)) if revision == scene.revision() => footing,
            _ => {
                let footing = footing_of(scene, options);
                self.below = Some((scene.revision(), footing));
                footing
            }
        }
    }

    /// Place of the floor, if there is one.
    pub fn footing(&self) -> Option<&Footing> {
        self.known.as_ref().map(|known| &known.footing)
    }

    /// True if pixels add lamps to it.
    pub fn has_lamps_apart(&self) -> bool {
        self.known.is_some_and(|known| known.lamps_apart)
    }

    /// All that is known of it; nothing without a floor.
    pub fn texels(&self) -> &[u32] {
        if self.known.is_some() { &self.texels } else { &[] }
    }

    /// Work of finding the light, in units of shading.
    pub fn units(asked: &Visibility) -> u64 {
        let size = size_of_picture(asked) as u64;
        TEXEL * u64::from(asked.maps) * size * size
    }

    /// Distance from its middle to which the floor reaches.
    pub fn reach(footing: &Footing) -> f64 {
        footing.radius * REACH
    }

    /// Fade of the floor by the square of a distance from its middle, 1 being its reach: 1 where it is whole, 0 where
    /// it is gone.
    #[inline(always)]
    pub fn fade<L: Lanes>(_: L, square: L::F) -> L::F {
        let t = (square.sqrt().one_minus() * (1.0 / (1.0 - WHOLE))).saturate();
        smooth(t)
    }

    /// The first `N` colours at places within the reach, by bilinear weights.
    #[inline(always)]
    pub fn look_up<L: Lanes, const N: usize>(&self, l: L, place: [L::F; 2]) -> [L::F; N] {
        let half = self.size as f32 * 0.5;
        let [x, y] = each!(v in place => {
            let bent = v * (1.0 + BEND) / (v.abs() + BEND);
            (bent * half + (half - 0.5)).clamp_to(0.0, half * 2.0 - 1.001)
        });
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let (column, row) = (left.to_int(), top.to_int());
        planes_between(l, (&self.texels, self.size), [column, row], [fx, fy])
    }
}

/// `N` colours between four texels of a picture that holds them as bits of floats, in each row one colour after the other.
#[inline(always)]
fn planes_between<L: Lanes, const N: usize>(
    l: L,
    (texels, size): (&[u32], usize),
    [column, row]: [L::I; 2],
    [fx, fy]: [L::F; 2],
) -> [L::F; N] {
    each!(plane => {
        // Above and below.
        let rows: [L::F; 2] = each!(k => {
            let index = ((row + k as i32) * N as i32 + plane as i32) * size as i32 + column;
            let [left, right] = l.gather_pairs_u32(texels, index);
            left.float_from_bits().lerp(right.float_from_bits(), fx)
        });
        rows[0].lerp(rows[1], fy)
    })
}

/// Hermite's smooth step of what lies between 0 and 1.
#[inline(always)]
pub fn smooth<F: Float>(t: F) -> F {
    t.squared() * (t * -2.0 + 3.0)
}

/// One direction of the environment's light, as the floor has it.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    number: usize,
    towards: [f32; 3],
    /// Irradiance.
    flux: [f32; 3],
    /// Tangent of half the angle that it stands for.
    spread: f32,
}

/// Light and occluders that the floor is shaded by.
struct Shadows<'a> {
    occlusion: &'a LightOcclusion<'a>,
    pyramids: Pyramids<'a>,
    lamps: Vec<Lamp>,
    /// All light.
    sum: [f32; 3],
    /// Middle of the floor, in world space.
    center: [f32; 3],
    reach: f32,
    /// Height and radius of the model.
    height: f32,
    radius: f32,
    /// Planes of the picture.
    planes: usize,
    /// Irradiance of the environment, over pi.
    irradiance: [f32; 3],
    /// The other lights.
    lights: Option<&'a LightMemory>,
    /// Lights without extent are not in the picture.
    lamps_apart: bool,
    /// Texels along a side of the picture.
    size: usize,
    /// Mean transmittance of the surfaces that tint what arrives of the environment, as bits of floats on a picture of half as
    /// many texels along a side; empty where nothing does. It has no edges as sharp as those of what blocks light, and looking
    /// it up takes as long as all the rest.
    tint: Vec<u32>,
}

impl<'a> Shadows<'a> {
    fn new(
        occlusion: &'a LightOcclusion<'a>,
        footing: Footing,
        planes: usize,
        (jobs, level): (&Jobs, SimdLevel),
    ) -> Self {
        let lamp = |(number, light): (usize, &DistantLight)| {
            let cosine = light.direction[1];
            // The angle of a cap of that size, if it is small.
            let spread = (light.solid_angle * FRAC_1_PI).sqrt();
            let spread = if spread < WIDEST { spread } else { WIDEST };
            let flux = each!(c in light.flux => c * cosine);
            (cosine > 1e-4).then_some(Lamp { number, towards: light.direction, flux, spread })
        };
        let lamps: Vec<Lamp> = occlusion.lights.iter().enumerate().filter_map(lamp).collect();
        let sum = lamps.iter().fold([0.0; 3], |sum, lamp| each!(c => sum[c] + lamp.flux[c]));
        Self {
            occlusion,
            pyramids: Pyramids::new(occlusion.maps, footing.center[1] as f32, jobs, level),
            lamps,
            sum,
            center: each!(c in footing.center => c as f32),
            reach: GroundLight::reach(&footing) as f32,
            height: footing.height as f32,
            radius: footing.radius as f32,
            planes,
            irradiance: [0.0; 3],
            lights: None,
            lamps_apart: false,
            size: 0,
            tint: Vec::new(),
        }
    }

    /// Texels along a side of the tint: whole vectors of them, about half of those of the picture.
    fn size_of_tint(&self) -> usize {
        self.size / 2 / LANES * LANES
    }

    /// Finds the tint, if there is one.
    fn find_tint(&mut self, pool: &TimedPool<'_>, level: SimdLevel) {
        if self.occlusion.tints.is_empty() {
            return;
        }
        let size = self.size_of_tint();
        let mut tint = vec![0; size * size * 3];
        pool.jobs.for_each_chunk_mut(&mut tint, size * 3, |row, texels| {
            if !pool.jobs.is_cancelled() {
                dispatch_available!(level, l => self.tint_row(l, (row, size), texels));
            }
        });
        self.tint = tint;
    }

    /// One row of the tint, in all planes.
    #[inline(always)]
    fn tint_row<L: Lanes>(&self, l: L, (row, size): (usize, usize), out: &mut [u32]) {
        let z = place(l.splat(row as f32), size);
        for first in (0..size).step_by(LANES) {
            let x = place(l.lane_indices().to_float() + first as f32, size);
            let [open, tinted] = self.arriving_tinted(l, [x, z]);
            for plane in 0..3 {
                let texels = &mut out[plane * size + first..][..LANES];
                let values = share(l, tinted[plane], open[plane]).to_array();
                texels.iter_mut().zip(values).for_each(|(to, value)| *to = value.to_bits());
            }
        }
    }

    /// Texels of one row that are wanted, sixteen each, in all planes.
    #[inline(always)]
    fn row<L: Lanes>(&self, l: L, (row, wanted): (usize, &[bool]), out: &mut [u32]) {
        let z = place(l.splat(row as f32), self.size);
        let wanted = wanted.iter().enumerate().filter(|(_, wanted)| **wanted);
        for first in wanted.map(|(block, _)| block * LANES) {
            let column = l.lane_indices().to_float() + first as f32;
            let x = place(column, self.size);
            let mut arriving = self.arriving(l, [x, z]);
            if !self.tint.is_empty() {
                let tint = self.tint_at(l, [column, l.splat(row as f32)]);
                arriving = each!(c => arriving[c] * tint[c]);
            }
            let [open, all] = self.of_lights(l, [x, z]);
            let mut put = |plane: usize, values: L::F| {
                let texels = &mut out[plane * self.size + first..][..LANES];
                texels.iter_mut().zip(values.to_array()).for_each(|(to, value)| *to = value.to_bits());
            };
            if self.planes < 3 {
                let of = |rgb: [L::F; 3]| (rgb[0] + rgb[1]) + rgb[2];
                let arriving = of(each!(c => (arriving[c] + open[c]) * LUMINANCE[c]));
                let all = of(each!(c => (all[c] + self.sum[c]) * LUMINANCE[c]));
                if self.planes == 1 {
                    put(0, share(l, arriving, all).one_minus());
                } else {
                    put(0, arriving);
                    put(1, all);
                }
            } else {
                for c in 0..3 {
                    let sky = share(l, arriving[c], l.splat(self.sum[c])) * self.irradiance[c];
                    put(c, sky + open[c] * FRAC_1_PI);
                }
            }
        }
    }

    /// Irradiance from lights at places on the floor: that arrives, and that would.
    #[inline(always)]
    fn of_lights<L: Lanes>(&self, l: L, [x, z]: [L::F; 2]) -> [[L::F; 3]; 2] {
        let lights = self.lights.and_then(|lights| Some((lights, lights.shadows_of_ground()?)));
        let Some((lights, shadows)) = lights else { return [[l.zero(); 3]; 2] };
        let [center_x, low, center_z] = self.center;
        // As wide as the finest texels.
        let texel = self.reach / self.size as f32 * (BEND / (1.0 + BEND));
        let receiver = Receiver {
            position: Vec3::new(x * self.reach + center_x, l.splat(low), z * self.reach + center_z),
            normal: Vec3::splat(l, [0.0, 1.0, 0.0]),
            pixel: l.splat(texel),
            two_sided: false,
        };
        let lamps = if self.lamps_apart { &[][..] } else { &lights.punctual };
        shadows.irradiance_of_all(l, lamps, &lights.areas, &receiver).map(Vec3::to_array)
    }

    /// Irradiance of the environment that arrives at places on the floor, without tint.
    #[inline(always)]
    fn arriving<L: Lanes>(&self, l: L, place: [L::F; 2]) -> [L::F; 3] {
        let at = self.above(l, place);
        let mut sum = [l.zero(); 3];
        for lamp in &self.lamps {
            let (may_be_blocked, furthest) = self.reach_of(l, lamp, &at);
            let mut open = l.splat(1.0);
            if may_be_blocked.any() {
                let found =
                    self.pyramids.soft_visibility(l, lamp.number, &at.position, lamp.spread, furthest);
                open = may_be_blocked.select(found, open);
            }
            sum = each!(c => sum[c] + open * lamp.flux[c]);
        }
        sum
    }

    /// The same, and what is left of it behind surfaces that tint it.
    #[inline(always)]
    fn arriving_tinted<L: Lanes>(&self, l: L, place: [L::F; 2]) -> [[L::F; 3]; 2] {
        let at = self.above(l, place);
        let tints = self.occlusion.tints;
        let mut sums = [[l.zero(); 3]; 2];
        for lamp in &self.lamps {
            let (may_be_blocked, furthest) = self.reach_of(l, lamp, &at);
            let (mut open, mut tint) = (l.splat(1.0), Vec3::splat(l, [1.0; 3]));
            if may_be_blocked.any() {
                let found =
                    self.pyramids.soft_visibility(l, lamp.number, &at.position, lamp.spread, furthest);
                open = may_be_blocked.select(found, open);
                let found = tints.soft_transmittance(l, lamp.number, &at.position, lamp.spread, furthest);
                tint = Vec3::select(may_be_blocked, found, tint);
            }
            let tint = tint.to_array();
            let light: [L::F; 3] = each!(c => open * lamp.flux[c]);
            sums[0] = each!(c => sums[0][c] + light[c]);
            sums[1] = each!(c => sums[1][c] + light[c] * tint[c]);
        }
        sums
    }

    /// Places on the floor, and where the model is from there.
    #[inline(always)]
    fn above<L: Lanes>(&self, l: L, [x, z]: [L::F; 2]) -> OnFloor<L> {
        let [center_x, low, center_z] = self.center;
        let position = [x * self.reach + center_x, l.splat(low), z * self.reach + center_z];
        let to_middle = Vec3::new(x * -self.reach, l.splat(0.5 * self.height), z * -self.reach);
        OnFloor { position, to_middle, square: to_middle.dot(to_middle) }
    }

    /// Mask of places from which the model may lie before a lamp, and a distance within which it does.
    #[inline(always)]
    fn reach_of<L: Lanes>(&self, l: L, lamp: &Lamp, at: &OnFloor<L>) -> (L::M, L::F) {
        let along = at.to_middle.dot(Vec3::splat(l, lamp.towards));
        // The model ends at its height, and within its radius.
        let furthest = (along + self.radius).at_most(self.height / lamp.towards[1]).at_least(0.0);
        let bound = furthest * lamp.spread + self.radius;
        ((at.square - along.squared()).lt(bound.squared()), furthest)
    }

    /// The tint at columns and rows of the picture.
    #[inline(always)]
    fn tint_at<L: Lanes>(&self, l: L, texel: [L::F; 2]) -> [L::F; 3] {
        let size = self.size_of_tint();
        let scale = size as f32 / self.size as f32;
        let [x, y] = each!(v in texel => ((v + 0.5) * scale - 0.5).clamp_to(0.0, size as f32 - 1.001));
        let (left, top) = (x.floor(), y.floor());
        planes_between(l, (&self.tint, size), [left.to_int(), top.to_int()], [x - left, y - top])
    }
}

/// Places on the floor.
struct OnFloor<L: Lanes> {
    position: [L::F; 3],
    /// From there to the middle of the model, and the square of that way.
    to_middle: V3<L>,
    square: L::F,
}

/// Places of texels, counted along a side, from -1 to 1 over the reach.
#[inline(always)]
fn place<F: Float>(index: F, size: usize) -> F {
    let bent = (index + 0.5) * (2.0 / size as f32) - 1.0;
    bent * BEND / (bent.abs() * -1.0 + (1.0 + BEND))
}

/// [`place`] of one.
fn place_of(index: f64, size: usize) -> f64 {
    let (bent, bend) = ((index + 0.5) * (2.0 / size as f64) - 1.0, f64::from(BEND));
    bent * bend / (1.0 + bend - bent.abs())
}

/// Texels along a side: whole vectors of them.
fn size_of_picture(asked: &Visibility) -> usize {
    asked.map_size.clamp(SIZES[0], SIZES[1]) as usize / LANES * LANES
}

/// `part / all`, 0 to 1; 1 of nothing.
#[inline(always)]
pub fn share<L: Lanes>(l: L, part: L::F, all: L::F) -> L::F {
    let some = all.gt(l.zero());
    let one = l.splat(1.0);
    (some.select(part, one) / some.select(all, one)).saturate()
}
