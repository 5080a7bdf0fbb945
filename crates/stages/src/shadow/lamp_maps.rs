//! Depth maps of lamps: one for light from afar and for what shines on the scene from outside or in a cone, six around a lamp
//! that is among what it shines on.
//!
//! What maps from a point hold is the distance along their axis, in as many steps as [`DepthMaps`](super::DepthMaps) have.

use super::blockers::Blockers;
use super::bounds::{larger, mapped_sphere};
use super::depth_map::{DEEPEST, DepthMap, MARGIN, OUTERMOST, SIZES, basis, depth_at, open, pack};
use super::slab::{Allowance, Slab};
use super::tint_map::Source;
use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};

/// A lamp, or a part of one, as light leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampSource {
    /// Place of the lamp.
    pub place: LampPlace,
    /// Its radius in metres; of light from afar, the tangent of half the angle that it is seen under.
    pub radius: f32,
    /// Texels along a side of its maps; counts as 16 to 4096. With 0 it has none, and nothing blocks its light.
    pub size: usize,
    /// Places that are averaged where its shadow has an edge; counts as 8 to 16.
    pub places: usize,
}

/// Place of a lamp: a direction or a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampPlace {
    /// Far away, in the direction of this unit vector.
    Distant([f32; 3]),
    /// At a point.
    Near {
        /// The point in world space.
        position: [f32; 3],
        /// The unit axis along which it shines and the cosine of the half angle within which it does, if not all around.
        cone: Option<([f32; 3], f32)>,
    },
}

/// Projection of a lamp's maps.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Projection {
    /// Along one direction.
    Parallel,
    /// From a point along one axis.
    Point,
    /// From a point along both directions of all axes of space.
    Cube,
}

/// One lamp's maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LampMap {
    projection: Projection,
    frame: DepthMap,
    /// See [`LampSource::places`].
    pub places: usize,
    /// Texels along a side of its maps.
    size: usize,
    /// Its first texel.
    first: usize,
    /// Towards it, if it is far away; else where it is.
    place: [f32; 3],
    /// See [`LampSource::radius`].
    pub radius: f32,
    /// Length of a texel; of maps seen from a point, at a distance of 1.
    pub texel: f32,
    /// Length of a step of depth.
    step: f32,
    /// The distance at which depth is least.
    far: f32,
    /// Distance of what is nearest to it, of all that blocks its light.
    nearest: f32,
}

/// The maps of several lamps.
#[derive(Clone, Debug, Default)]
pub struct LampMaps {
    /// Nothing of lamps without maps.
    lamps: Vec<Option<LampMap>>,
    /// As [`DepthMaps`](super::DepthMaps) have them, map by map.
    texels: Vec<u32>,
    /// Sixteens of triangles and texels that drawing them has looked at.
    work: u64,
}

/// Lamp of a map.
#[derive(Clone, Copy)]
struct LampFrame {
    number: usize,
    /// Texels along a side.
    size: usize,
    /// See [`LampMap`].
    far: f32,
}

/// A map that is being drawn.
struct DrawnMap<'a> {
    of: LampFrame,
    frame: DepthMap,
    map: &'a mut [u32],
    /// Distance of what is nearest to the lamp.
    nearest: f32,
}

/// Positions of points on a lamp's maps.
pub(super) struct OnMap<L: Lanes> {
    /// Column and row.
    pub at: [L::F; 2],
    /// Depth in steps.
    pub depth: L::F,
    /// The first texel of the map.
    pub first: L::I,
}

/// Least distance at which a lamp's maps begin, as a share of that to the furthest point of the scene.
const NEAR: f32 = 1.0 / 1024.0;

/// Lamps that are further from the middle of a scene than this, in its radii, are outside of it.
const OUTSIDE: f64 = 1.2;

/// Lamps that are further than this, in the same unit, count as far away: single precision could not tell how far.
const AFAR: f64 = 1000.0;

/// Half of a cone's angle at most for one map to hold it, as a cosine.
const WIDEST: f32 = 0.5;

/// An edge is at most so wide, in parts of the distance to the lamp.
const WIDEST_EDGE: f32 = 0.5;

impl LampPlace {
    /// Projection of a lamp's maps, their frames, and the distance of the furthest point of the scene; 0 for parallel
    /// projection.
    fn frames(self, centre: [f32; 3], radius: f32, size: usize) -> (Projection, Vec<DepthMap>, f32) {
        let (position, cone) = match self {
            Self::Distant(towards) => {
                return (Projection::Parallel, vec![DepthMap::new(towards, centre, radius, size)], 0.0);
            }
            Self::Near { position, cone } => (position, cone),
        };
        let to_centre: [f64; 3] = each!(k => f64::from(centre[k]) - f64::from(position[k]));
        let square: f64 = to_centre.iter().map(|c| c * c).sum();
        let (distance, radius) = (square.sqrt(), f64::from(radius));
        if distance > AFAR * radius {
            let towards = to_centre.map(|c| (-c / distance) as f32);
            return (Projection::Parallel, vec![DepthMap::new(towards, centre, radius as f32, size)], 0.0);
        }
        let far = (distance + radius) as f32;
        let frame = |axis: [f64; 3], tangent: f64, near: f32| {
            let [across, down] = basis(axis);
            DepthMap::from_point(position, [across, down, axis], tangent, near, size)
        };
        let about_scene = (distance > OUTSIDE * radius).then(|| {
            let tangent = 1.02 * radius / (square - radius * radius).sqrt();
            let near = larger((0.99 * (distance - radius)) as f32, far * NEAR);
            (tangent, frame(to_centre.map(|c| c / distance), tangent, near))
        });
        let about_cone = cone.filter(|(_, cosine)| *cosine >= WIDEST).map(|(axis, cosine)| {
            let tangent = 1.02 * (1.0 - f64::from(cosine) * f64::from(cosine)).sqrt() / f64::from(cosine);
            let tangent = if tangent > 1e-3 { tangent } else { 1e-3 };
            (tangent, frame(axis.map(f64::from), tangent, far * NEAR))
        });
        let one = match (about_scene, about_cone) {
            (Some(scene), Some(cone)) => Some(if cone.0 < scene.0 { cone } else { scene }),
            (scene, cone) => scene.or(cone),
        };
        if let Some((_, frame)) = one {
            return (Projection::Point, vec![frame], far);
        }
        let faces = (0..6).map(|face| {
            let mut axes = [[0.0; 3]; 3];
            let axis = face / 2;
            axes[0][(axis + 1) % 3] = 1.0;
            axes[1][(axis + 2) % 3] = 1.0;
            axes[2][axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
            DepthMap::from_point(position, axes, 1.0, far * NEAR, size)
        });
        (Projection::Cube, faces.collect(), far)
    }
}

impl LampMaps {
    /// Draws blockers as lamps see them. The result depends on neither threads nor instruction set.
    ///
    /// # Errors
    /// [`LimitExceeded`] if the maps and what they are drawn of take more than [`Limits::frame_bytes`], or drawing them looks at
    /// more sixteens of triangles and of texels than [`Limits::blocks`].
    pub fn within(
        limits: &Limits,
        blockers: &Blockers,
        sources: &[LampSource],
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Result<Self, LimitExceeded> {
        let what = || "depth maps of lamps".to_owned();
        let sphere = if sources.is_empty() { None } else { mapped_sphere(&blockers.parts(), jobs) };
        let Some((centre, radius)) = sphere else { return Ok(Self::default()) };
        // The maps, each with the number of its lamp.
        let mut frames: Vec<(LampFrame, DepthMap)> = Vec::new();
        let mut lamps: Vec<Option<LampMap>> = Vec::new();
        let mut texels = 0_usize;
        for (number, source) in sources.iter().enumerate() {
            if source.size == 0 {
                lamps.push(None);
                continue;
            }
            let size = source.size.clamp(SIZES[0], SIZES[1]);
            let (lamp, own) = LampMap::of(source, (centre, radius), texels, size);
            texels = texels.saturating_add(own.len().saturating_mul(size * size));
            let of = LampFrame { number, size, far: lamp.far };
            frames.extend(own.into_iter().map(|frame| (of, frame)));
            lamps.push(Some(lamp));
        }
        let beside = blockers.bytes().saturating_add(Slab::bytes(blockers));
        let bytes = (texels as u64).saturating_mul(4).saturating_add(beside);
        Limits::check(what, bytes, limits.frame_bytes, "frame_bytes")?;
        // They have numbers of 31 bits.
        Limits::check(what, texels as u64, 1 << 31, "frame_bytes")?;
        Limits::check_memory(what, bytes)?;
        let mut maps = Self { lamps, texels: vec![0; texels], work: 0 };
        let allowance = Allowance::new(limits.blocks, jobs);
        maps.draw(frames, blockers, &allowance, jobs, level);
        if allowance.is_passed() {
            return Err(LimitExceeded::beyond("depth maps of lamps", limits.blocks, "blocks"));
        }
        maps.work = allowance.spent();
        Ok(maps)
    }

    /// Draws all maps, each with the number of its lamp. They are unfinished if that takes more than is allowed.
    fn draw(
        &mut self,
        frames: Vec<(LampFrame, DepthMap)>,
        blockers: &Blockers,
        allowance: &Allowance<'_>,
        jobs: &Jobs,
        level: SimdLevel,
    ) {
        let mut rest = &mut self.texels[..];
        let mut drawn = Vec::new();
        for (of, frame) in frames {
            let (map, others) = std::mem::take(&mut rest).split_at_mut(of.size.pow(2));
            rest = others;
            drawn.push(DrawnMap { of, frame, map, nearest: f32::INFINITY });
        }
        Slab::for_each(blockers, jobs, allowance, |slab| {
            jobs.for_each_mut(&mut drawn, |_, DrawnMap { of, frame, map, .. }| {
                let frame = std::slice::from_ref(frame);
                dispatch_available!(level, l => slab.draw(l, frame, allowance, of.size, map));
            });
        });
        jobs.for_each_mut(&mut drawn, |_, DrawnMap { of, frame, map, nearest, .. }| {
            if allowance.is_passed() {
                return;
            }
            let LampFrame { size, far, .. } = *of;
            dispatch_available!(level, l => {
                if frame.near > 0.0 {
                    *nearest = from_inverse(l, frame, far, map);
                }
                pack(l, map, size);
            });
        });
        for map in &drawn {
            if let Some(lamp) = &mut self.lamps[map.of.number] {
                lamp.nearest = if map.nearest < lamp.nearest { map.nearest } else { lamp.nearest };
            }
        }
    }

    /// Number of maps that each lamp has.
    #[must_use]
    pub fn counts(blockers: &Blockers, sources: &[LampSource], jobs: &Jobs) -> Vec<usize> {
        let sphere = if sources.is_empty() { None } else { blockers.bounding_sphere(jobs) };
        let count = |source: &LampSource| {
            sphere.map_or(0, |(centre, radius)| source.place.frames(centre, radius, SIZES[0]).1.len())
        };
        sources.iter().map(count).collect()
    }

    /// Number of maps that can be drawn within limits at most: each looks at all triangles.
    #[must_use]
    pub fn most(limits: &Limits, blockers: &Blockers) -> u64 {
        limits.blocks / Slab::sixteens(blockers).max(1)
    }

    /// All texels, as they are in memory.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Sixteens of triangles and texels that drawing them has looked at.
    #[must_use]
    pub fn work(&self) -> u64 {
        self.work
    }

    /// Number of lamps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lamps.len()
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// The maps of a lamp.
    pub(super) fn lamp(&self, number: usize) -> Option<&LampMap> {
        self.lamps.get(number)?.as_ref()
    }

    /// Share of the four texels around places that are no nearer to a lamp than they are, by their bilinear weights.
    #[inline(always)]
    pub(super) fn open<L: Lanes>(&self, l: L, lamp: &LampMap, position: V3<L>) -> L::F {
        let OnMap { at, depth, first } = lamp.project(l, position);
        open(l, &self.texels, lamp.size, first, at, depth.clamp_to(0.0, OUTERMOST).to_int())
    }

    /// The depths of places and of what is nearest to the lamp there, in steps; 0 of nothing.
    #[inline(always)]
    pub(super) fn depths<L: Lanes>(&self, l: L, lamp: &LampMap, position: V3<L>) -> [L::F; 2] {
        let OnMap { at, depth, first } = lamp.project(l, position);
        [depth, depth_at(l, &self.texels, lamp.size, first, at).to_float()]
    }
}

impl LampMap {
    /// A lamp's maps of a sphere from a number of texels on, and their frames.
    pub(super) fn of(
        source: &LampSource,
        (centre, radius): ([f32; 3], f32),
        first: usize,
        size: usize,
    ) -> (Self, Vec<DepthMap>) {
        let (projection, frames, far) = source.place.frames(centre, radius, size);
        (Self::new(source, projection, (first, frames[0], far), radius, size), frames)
    }

    /// Texels along a side of its maps.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// The light, as maps of tinted surfaces are drawn for it.
    pub(super) fn source(&self) -> Source {
        if self.projection == Projection::Parallel {
            Source::Distant { towards: self.place, step: self.step }
        } else {
            Source::Near { position: self.place, far: self.far, texel: self.texel }
        }
    }

    fn new(
        source: &LampSource,
        projection: Projection,
        (first, frame, far): (usize, DepthMap, f32),
        radius: f32,
        size: usize,
    ) -> Self {
        let steps = OUTERMOST - DEEPEST;
        let texels = (size - 2 * MARGIN) as f32;
        let place = match source.place {
            LampPlace::Distant(towards) => towards,
            LampPlace::Near { position, .. } if projection != Projection::Parallel => position,
            // The depth grows towards it.
            LampPlace::Near { .. } => {
                let [x, y, z, _] = frame.rows[2];
                let length = (x * x + y * y + z * z).sqrt();
                [x / length, y / length, z / length]
            }
        };
        let (texel, step, near_radius) = if projection == Projection::Parallel {
            let far_away = matches!(source.place, LampPlace::Near { .. });
            // Seen from so far away that it is none.
            (2.0 * radius / texels, 2.0 * radius / steps, if far_away { 0.0 } else { source.radius })
        } else {
            let [x, y, z, _] = frame.rows[0];
            let [a, b, c, _] = frame.rows[2];
            // Of the axis across alone: what the shift to the middle adds lies along the other.
            let middle = (size - 1) as f32 * 0.5;
            let across = [x - a * middle, y - b * middle, z - c * middle];
            let scale = (across[0] * across[0] + across[1] * across[1] + across[2] * across[2]).sqrt();
            (1.0 / scale, (far - frame.near) / steps, source.radius)
        };
        Self {
            projection,
            frame,
            places: source.places.clamp(8, 16),
            size,
            first,
            place,
            radius: near_radius,
            texel,
            step,
            far,
            nearest: far,
        }
    }

    /// Unit vectors towards the lamp, and what texels are to be multiplied by at these places.
    #[inline(always)]
    pub(super) fn towards<L: Lanes>(&self, l: L, position: V3<L>) -> (V3<L>, L::F) {
        let place = Vec3::splat(l, self.place);
        if self.projection == Projection::Parallel {
            return (place, l.splat(1.0));
        }
        let to = place - position;
        let distance = to.length().at_least(1e-30);
        (to * distance.recip(), distance)
    }

    /// Radius of the shadow's edge: that of the light's disc, seen from places of one depth past an occluder at
    /// another.
    #[inline(always)]
    pub(super) fn edge<L: Lanes>(&self, l: L, depth: L::F, blocker: L::F) -> L::F {
        let length = (blocker - depth) * self.step;
        if self.projection == Projection::Parallel {
            return length * self.radius;
        }
        let distance = self.distance(l, blocker).at_least(self.frame.near);
        length * self.radius / distance
    }

    /// The largest radius of a shadow's edge, in what [`LampMap::towards`] calls distance.
    pub(super) fn widest(&self) -> f32 {
        if self.projection == Projection::Parallel { f32::MAX } else { WIDEST_EDGE }
    }

    /// The distance along the axis of a depth.
    #[inline(always)]
    fn distance<L: Lanes>(&self, l: L, depth: L::F) -> L::F {
        l.splat(self.far) - (depth - DEEPEST) * self.step
    }

    /// The depth of what is nearest to the lamp.
    #[inline(always)]
    pub(super) fn outermost(&self) -> f32 {
        if self.projection == Projection::Parallel {
            OUTERMOST
        } else {
            DEEPEST + (self.far - self.nearest) / self.step
        }
    }

    /// Positions of points on the maps.
    #[inline(always)]
    pub(super) fn project<L: Lanes>(&self, l: L, position: V3<L>) -> OnMap<L> {
        let (size, own) = (self.size, self.first as i32);
        let p = position.to_array();
        match self.projection {
            Projection::Parallel => {
                let [x, y, depth] = self.frame.project(l, &p);
                OnMap { at: [x, y], depth, first: l.splat_i(own) }
            }
            Projection::Point => {
                let [x, y, distance] = self.frame.project(l, &p);
                let inverse = distance.at_least(self.frame.near).recip();
                OnMap {
                    at: [x * inverse, y * inverse],
                    depth: self.depth(l, distance),
                    first: l.splat_i(own),
                }
            }
            Projection::Cube => {
                let [x, y, z] = (position - Vec3::splat(l, self.place)).to_array();
                let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
                let along_x = ax.ge(ay) & ax.ge(az);
                let along_y = !along_x & ay.ge(az);
                let along = [along_x, along_y];
                let distance = pick::<L>(along, ax, ay, az);
                let inverse = distance.at_least(self.frame.near).recip();
                let (scale, middle) = ((size - 2 * MARGIN) as f32 * 0.5, (size - 1) as f32 * 0.5);
                let at = each!(v in [pick::<L>(along, y, z, x), pick::<L>(along, z, x, y)] => v * inverse * scale + middle);
                let backwards = pick::<L>(along, x, y, z).lt(l.zero());
                let axis = along_x.select_i(l.splat_i(0), along_y.select_i(l.splat_i(2), l.splat_i(4)));
                let face = axis + backwards.select_i(l.splat_i(1), l.splat_i(0));
                OnMap { at, depth: self.depth(l, distance), first: face * (size * size) as i32 + own }
            }
        }
    }

    /// The depth of a distance along the axis.
    #[inline(always)]
    fn depth<L: Lanes>(&self, l: L, distance: L::F) -> L::F {
        (l.splat(self.far) - distance) * (1.0 / self.step) + DEEPEST
    }
}

/// The first number along x, the second along y, else the third. No closure: those that have a name are not compiled for the
/// instruction set of their lanes.
#[inline(always)]
fn pick<L: Lanes>([along_x, along_y]: [L::M; 2], x: L::F, y: L::F, z: L::F) -> L::F {
    along_x.select(x, along_y.select(y, z))
}

/// From inverse distances to depths, texel by texel. Returns the least distance.
#[inline(always)]
fn from_inverse<L: Lanes>(l: L, frame: &DepthMap, far: f32, texels: &mut [u32]) -> f32 {
    let scale = (OUTERMOST - DEEPEST) / (far - frame.near);
    let mut most = l.zero();
    for sixteen in texels.chunks_exact_mut(LANES) {
        let Some(sixteen) = sixteen.first_chunk_mut::<LANES>() else { continue };
        let inverse = l.load_i(&each!(texel in *sixteen => texel as i32)).float_from_bits();
        let some = inverse.gt(l.zero());
        if !some.any() {
            continue;
        }
        most = most.max(inverse);
        let distance = l.splat(frame.nearest()) / some.select(inverse, l.splat(1.0));
        let depth = ((l.splat(far) - distance) * scale + DEEPEST).clamp_to(DEEPEST, OUTERMOST);
        let bits = some.select(depth, l.zero()).bits().to_array();
        *sixteen = each!(bits in bits => bits as u32);
    }
    let most = most.to_array().into_iter().fold(0.0_f32, larger);
    if most > 0.0 { frame.nearest() / most } else { far }
}
