//! Light of other surfaces, by rays: what blocks a lobe is shaded where it is hit, one bounce.
//!
//! Each lobe of a fragment sends a few rays. Those that miss everything say how much of the environment's light is open (a
//! ratio again, as in `occlusion.rs`, so that open lobes keep the bits of the prefiltered environment); those that hit bring
//! the radiance of what they hit, by the model and the textures of its own material, under the light that the depth maps let
//! reach it (`hits.rs`). What rays have found is kept as sums ([`Found`]), so that those of neighbours can be added before
//! shading reads what they come to.

mod clear;
mod emitters;
mod found;
mod hits;
mod lobe;

pub use clear::ClearSurfaces;
pub use emitters::Emitters;
pub use found::Found;
pub use lobe::{TAKEN, TracedLobe, taken_share};

use super::lobe_samples::{LobeSamples, cosine_direction, ggx_direction};
use super::occlusion::LightOcclusion;
use super::record::{get, get_vector};
use super::surface::hit_opacity;
use super::{ShadeContext, ShadingCost};
use crate::bvh::{Hierarchy, Hit, Ray, Traversal};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, SurfacePlanes};
use clear::{Through, place_in};
use emitters::{LitPlace, cross};
use hits::RayHit;
use lobe::{NARROW, takes_all};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::math::triple::dot;
use overcoat_core::math::vec3::Vec3;
use overcoat_scene::{AlphaMode, Material};

/// Scene that rays are traced in.
#[derive(Clone, Copy, Debug)]
pub struct TracedLight<'a> {
    /// The triangles.
    pub hierarchy: &'a Hierarchy,
    /// The corners, in world space, of those that stand once.
    pub corners: &'a [[[f32; 3]; 3]],
    /// The draws that have triangles among them.
    pub draws: &'a [TracedDraw],
    /// Clear surfaces, which rays pass.
    pub clear: ClearSurfaces<'a>,
    /// The rays of a lobe.
    pub samples: &'a LobeSamples,
    /// Length below which distances mean nothing.
    pub epsilon: f32,
    /// Triangles that shine.
    pub emitters: &'a Emitters,
    /// Occlusion of the environment at the places that are hit.
    pub occlusion: LightOcclusion<'a>,
}

/// A draw whose triangles rays can hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedDraw {
    /// Number of the draw.
    pub draw: u32,
    /// Number of its first triangle.
    pub first: u32,
    /// Place of that in the corners of the traced scene, if it is there.
    pub listed: u32,
    /// Rows of its transform if its mesh is kept once, at several places.
    pub rows: Option<[[f64; 4]; 3]>,
}

/// Fragments that send rays.
#[derive(Clone, Copy, Debug)]
pub struct Senders<'a> {
    /// For each of up to sixteen fragments of a material, its place among what is found.
    pub places: &'a [u32],
    /// Their pixels in the picture.
    pub pixels: &'a [[u32; 2]; LANES],
    /// Mask of those that send the rays of lobes that are wide enough to be [taken](taken_share) whole from neighbours.
    pub wide: u16,
    /// Mask of those that send the rays of all other lobes, and look for lamps.
    pub narrow: u16,
}

/// Memory of one thread.
#[derive(Debug, Default)]
pub struct TraceScratch {
    traversal: Traversal,
    hits: Vec<RayHit>,
    order: Vec<u32>,
    radiance: Vec<[f32; 3]>,
    batch: Batch,
    planes: SurfacePlanes,
}

impl TraceScratch {
    /// Number of hits that wait for [`TracedLight::shade_hits`].
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.hits.len()
    }

    /// Cost of the rays that were sent since it was last begun or told, and of shading what they hit, which is left unshaded for
    /// good.
    pub fn take_cost(&mut self, hierarchy: &Hierarchy, costs: &[ShadingCost]) -> u64 {
        let of_hit = |hit: &RayHit| costs.get(hit.material as usize).map_or(0, |cost| cost.hit);
        let hits: u64 = self.hits.iter().map(of_hit).sum();
        let visited = self.traversal.take_visited();
        self.forget();
        ShadingCost::of_visits(visited, hierarchy.bytes()).saturating_add(hits)
    }

    /// Begins anew: leaves hits that wait unshaded, for good, and what rays have cost so far.
    pub fn forget(&mut self) {
        self.hits.clear();
        self.traversal.take_visited();
    }
}

impl TracedLight<'_> {
    /// Sends the rays of up to sixteen fragments of a material, shades what they hit, and fills the planes of
    /// [`LightOcclusion`] anew.
    #[inline(never)]
    pub fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        (len, pixels): (usize, &[[u32; 2]; LANES]),
        planes: &mut SurfacePlanes,
        scratch: &mut TraceScratch,
    ) {
        let mut found = [Found::default(); LANES];
        let places: [u32; LANES] = std::array::from_fn(|k| k as u32);
        let places = &places[..len.min(LANES)];
        let senders = Senders { places, pixels, wide: u16::MAX, narrow: u16::MAX };
        self.send(l, context, material, &senders, planes, (&mut *scratch, &mut found));
        self.shade_hits(l, context, scratch, &mut found);
        Found::store(l, material, &found, planes);
    }

    /// Sends the rays of up to sixteen fragments of a material, whose surface is in `planes`. What they hit waits to be shaded.
    /// Returns for each lobe the mask of fragments that want rays, whether these are sent or not.
    #[inline(never)]
    pub fn send<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        senders: &Senders<'_>,
        planes: &SurfacePlanes,
        (scratch, found): (&mut TraceScratch, &mut [Found]),
    ) -> [u16; TracedLobe::COUNT] {
        let mut wanted = [0; TracedLobe::COUNT];
        for &lobe in TracedLobe::of(material) {
            wanted[lobe as usize] = l.run(
                #[inline(always)]
                || self.send_of(l, context, (lobe, material), senders, planes, (&mut *scratch, &mut *found)),
            );
        }
        wanted
    }

    /// Angle between neighbouring rays of a lobe: about the square root of the part of it that each stands for.
    #[inline(always)]
    fn spread<L: Lanes>(&self, l: L, lobe: TracedLobe, planes: &SurfacePlanes) -> [f32; LANES] {
        let each = 1.5 / (self.samples.len() as f32).sqrt();
        if lobe == TracedLobe::Diffuse {
            return [each; LANES];
        }
        let [roughness] = get::<L, 1>(l, planes, lobe.shape()[1]);
        ((roughness.squared() + 0.002) * each).to_array()
    }

    /// Sends the rays of one lobe. Returns the mask of fragments that want some.
    #[inline(always)]
    fn send_of<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        (lobe, material): (TracedLobe, &Material),
        senders: &Senders<'_>,
        planes: &SurfacePlanes,
        (scratch, found): (&mut TraceScratch, &mut [Found]),
    ) -> u16 {
        let face = get_vector(l, planes, layout::FACE_NORMAL);
        let view = get_vector(l, planes, layout::VIEW);
        let [normal, roughness] = lobe.shape();
        let (normal, [roughness]) = (get_vector(l, planes, normal), get(l, planes, roughness));
        let alpha = roughness.squared().at_least(1e-4);
        let (wanted, is_dim) = lobe.wanted(l, self.samples.len() as f32, material, alpha, planes);
        let looks_for_lamps = lobe == TracedLobe::Diffuse && !self.emitters.is_empty() && senders.narrow != 0;
        let want = wanted.gt(l.zero()).bits();
        let wide = if lobe == TracedLobe::Diffuse { u16::MAX } else { takes_all(l, alpha).bits() };
        let send = want & (wide & senders.wide | !wide & senders.narrow);
        if send == 0 && !looks_for_lamps {
            return want;
        }
        let wanted = l.mask(send).select(wanted, l.zero());
        let [tangent, bitangent] = normal.any_basis(l);
        let frame = [tangent, bitangent, normal];
        let position = get_vector(l, planes, layout::FACE_POSITION);
        let start = (position + face * self.epsilon).to_arrays();
        if looks_for_lamps {
            let (face, normal) = (face.to_arrays(), normal.to_arrays());
            for (lane, &sender) in senders.places.iter().enumerate().take(LANES) {
                let (start, pixel) = (each_of(&start, lane), senders.pixels[lane]);
                let at =
                    LitPlace { start, face: each_of(&face, lane), normal: each_of(&normal, lane), pixel };
                found[sender as usize].add_direct(self.light_of_emitters(l, context, &at, scratch));
            }
        }
        let spread = self.spread(l, lobe, planes);
        let is_wide = if lobe == TracedLobe::Diffuse { l.mask(u16::MAX) } else { alpha.gt(l.splat(NARROW)) };
        let (is_lit_by_part, is_wide) = ((is_wide | is_dim).bits(), is_wide.bits());
        let turns = self.samples.turns(l, senders.pixels, lobe as u32, wide);
        let size = self.samples.block();
        let blocks = senders.pixels.map(|pixel| pixel.map(|v| v / size));
        // What one of the rays stands for is as rough as its part of the lobe.
        let part = roughness * if self.samples.len() < 8 { 0.7 } else { 0.5 };
        let (mut sent_weight, mut all, mut open) = (l.zero(), Vec3::zero(l), Vec3::zero(l));
        for number in 0..self.samples.len() {
            let sent = wanted.gt(l.splat(number as f32));
            if !sent.any() {
                break;
            }
            let point = self.samples.point(l, number, &turns);
            let (towards, weight) = match lobe {
                TracedLobe::Diffuse => (cosine_direction(l, &frame, point), l.splat(1.0)),
                _ => ggx_direction(l, &frame, view, alpha, point),
            };
            // Nothing is sent below the surface: what a bump would see is its neighbour.
            let height = face.dot(towards);
            let towards = towards - face * (height * 2.0).at_most(0.0);
            let weight = sent.select(weight, l.zero());
            let mut hit = 0_u16;
            let mut tints = [[1.0; LANES]; 3];
            let (directions, weights) = (towards.to_arrays(), weight.to_array());
            for (lane, &sender) in senders.places.iter().enumerate().take(LANES) {
                if weights[lane] <= 0.0 {
                    continue;
                }
                let along = |planes: &[[f32; LANES]; 3]| [planes[0][lane], planes[1][lane], planes[2][lane]];
                let (origin, direction) = (along(&start), along(&directions));
                let ray = Ray { origin, direction, near: 0.0, far: f32::INFINITY };
                let TraceScratch { traversal, batch, .. } = &mut *scratch;
                let met = self.nearest(l, context, &ray, traversal, batch);
                let end = met.map_or(ray.far, |met| met.distance);
                let through = match self.clear.hierarchy.is_empty() {
                    true => Through::OPEN,
                    false => self.through(l, context, &Ray { far: end, ..ray }, scratch),
                };
                let sent = RayHit {
                    sender,
                    lobe,
                    part: self.part_of(is_lit_by_part >> lane & 1 == 1, blocks[lane], number),
                    weight: weights[lane],
                    tint: through.tint,
                    direction,
                    is_clear: false,
                    triangle: 0,
                    material: 0,
                    barycentrics: [0.0; 2],
                    distance: 0.0,
                    spread: spread[lane],
                };
                // Reflections in glass are too weak in wide lobes to be worth the noise.
                if is_wide >> lane & 1 == 0 {
                    for &(met, tint) in through.seen.iter().flatten() {
                        let sent = RayHit { tint, is_clear: true, ..sent };
                        scratch.hits.push(sent.at(context, place_in(self.clear.draws, met.triangle), &met));
                    }
                }
                if let Some(met) = met {
                    hit |= 1 << lane;
                    scratch.hits.push(sent.at(context, place_in(self.draws, met.triangle), &met));
                } else {
                    (0..3).for_each(|k| tints[k][lane] = through.tint[k]);
                }
            }
            sent_weight = sent_weight + weight;
            if lobe != TracedLobe::Diffuse {
                let tint = Vec3::new(l.load(&tints[0]), l.load(&tints[1]), l.load(&tints[2]));
                let light = context.environment.radiance(l, towards, part) * weight;
                all += light;
                open += Vec3::select(l.mask(hit), Vec3::zero(l), light * tint);
            }
        }
        let (weights, all, open) = (sent_weight.to_array(), all.to_arrays(), open.to_arrays());
        for (lane, &sender) in senders.places.iter().enumerate().take(LANES) {
            found[sender as usize].add_sent(lobe, weights[lane], each_of(&all, lane), each_of(&open, lane));
        }
        want
    }

    /// The nearest triangle that a ray hits.
    #[inline(always)]
    fn nearest<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        ray: &Ray,
        traversal: &mut Traversal,
        batch: &mut Batch,
    ) -> Option<Hit> {
        self.hierarchy.nearest(
            l,
            ray,
            traversal,
            #[inline(always)]
            |hit| self.is_seen(l, context, (hit, ray.direction), batch),
        )
    }

    /// True if one who looks along a direction sees a triangle where it is hit: its front unless it is double-sided, and where
    /// its alpha reaches the cutoff.
    #[inline(always)]
    fn is_seen<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        (hit, along): (&Hit, [f32; 3]),
        batch: &mut Batch,
    ) -> bool {
        let (place, triangle) = place_in(self.draws, hit.triangle);
        let of = &context.draws[place.draw as usize];
        let material = &context.materials[of.material as usize];
        if !material.double_sided {
            let (normal, _) = cross(&self.corners(context, (place, triangle)));
            if dot(normal, along) * of.handedness > 0.0 {
                return false;
            }
        }
        let AlphaMode::Mask { cutoff } = material.alpha_mode else { return true };
        batch.of_hits(&[(of.mesh.triangles()[triangle as usize], place.draw)], 0);
        let weights = hit.barycentrics.map(|b| l.splat(b));
        hit_opacity(l, context, material, batch, weights).to_array()[0] >= cutoff
    }

    /// The corners of a triangle of a draw, in world space.
    fn corners(&self, context: &ShadeContext<'_>, (of, triangle): (&TracedDraw, u32)) -> [[f32; 3]; 3] {
        let Some(rows) = &of.rows else { return self.corners[(of.listed + triangle) as usize] };
        let mesh = context.draws[of.draw as usize].mesh;
        mesh.triangles()[triangle as usize].map(|vertex| {
            let [x, y, z] = mesh.positions()[vertex as usize].map(f64::from);
            // The arithmetic of `Transform::point`.
            rows.map(|row| (row[0] * x + row[1] * y + row[2] * z + row[3]) as f32)
        })
    }
}

/// One lane of three planes.
#[inline(always)]
fn each_of(planes: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
    [planes[0][lane], planes[1][lane], planes[2][lane]]
}
