//! Hits of rays, and the light that they send back.

use super::clear::place_in;
use super::{Emitters, Found, TraceScratch, TracedDraw, TracedLight, TracedLobe, each_of};
use crate::bvh::Hit;
use crate::gbuffer::Batch;
use crate::gbuffer::layout;
use crate::shade::record::put;
use crate::shade::surface::{SeenFrom, SurfacePlace, SurfaceReading, store_face};
use crate::shade::{ShadeContext, pass_through, shade, store_lit, store_surface, store_transmission};
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_core::math::vec3::Vec3;
use overcoat_scene::AlphaMode;

/// A ray that hits something.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayHit {
    /// The fragment that has sent it, by its place among what is found.
    pub(super) sender: u32,
    pub(super) lobe: TracedLobe,
    /// Part of the maps that it is lit by.
    pub(super) part: u8,
    pub(super) weight: f32,
    /// Transmittance of what lies before it.
    pub(super) tint: [f32; 3],
    pub(super) direction: [f32; 3],
    /// It is a clear surface, behind which the ray goes on.
    pub(super) is_clear: bool,
    pub(super) triangle: u32,
    pub(super) material: u32,
    pub(super) barycentrics: [f32; 2],
    pub(super) distance: f32,
    /// Angle between neighbouring rays.
    pub(super) spread: f32,
}

impl RayHit {
    /// The same ray where it hits a triangle of a draw.
    pub(super) fn at(self, context: &ShadeContext<'_>, (of, _): (&TracedDraw, u32), met: &Hit) -> Self {
        Self {
            triangle: met.triangle,
            material: context.draws[of.draw as usize].material,
            barycentrics: met.barycentrics,
            distance: met.distance,
            ..self
        }
    }
}

/// All parts of the maps.
const ALL: u8 = u8::MAX;

/// Directions of a part, at least. Shares of light by few directions are too large: with 16, the inside of a pierced shell gets 1.5 percent
/// too much. Shading a hit takes little longer with more of them.
const DIRECTIONS: usize = 40;

impl TracedLight<'_> {
    /// Number of parts that the maps are divided into: each enough for the rough idea that wide lobes want of the light
    /// on one hit of many.
    fn parts(&self) -> usize {
        (self.occlusion.lights.len() / DIRECTIONS).clamp(1, usize::from(ALL))
    }

    /// The directions that a ray's hit is lit by, the ray of this number of a block of pixels: each of a wide lobe's by some, and
    /// of one that shows little, others by all.
    #[inline(always)]
    pub(super) fn part_of(&self, is_wide: bool, [x, y]: [u32; 2], number: usize) -> u8 {
        if is_wide { ((x + 2 * y + number as u32) % self.parts() as u32) as u8 } else { ALL }
    }

    /// Finds what the hits that wait send back, sixteen of one material at a time, and adds it to what is found.
    #[inline(never)]
    pub fn shade_hits<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        scratch: &mut TraceScratch,
        found: &mut [Found],
    ) {
        let TraceScratch { hits, order, radiance: found_radiance, batch, planes, .. } = scratch;
        order.clear();
        order.extend(0..hits.len() as u32);
        order.sort_unstable_by_key(|k| {
            let hit = &hits[*k as usize];
            (hit.material, hit.part, hit.triangle, *k)
        });
        let mut rest = &order[..];
        let mut known: Option<(u32, SurfaceReading<'_>)> = None;
        found_radiance.resize(hits.len(), [0.0; 3]);
        while let Some(first) = rest.first() {
            let RayHit { material: number, part, .. } = hits[*first as usize];
            let is_same = |k: &u32| hits[*k as usize].material == number && hits[*k as usize].part == part;
            let same = rest.iter().take(LANES).take_while(|k| is_same(k)).count();
            let (sixteen, others) = rest.split_at(same);
            rest = others;
            let material = &context.materials[number as usize];
            let model = material.shading(context.model);
            if known.as_ref().is_none_or(|(of, _)| *of != number) {
                known = Some((number, SurfaceReading::of(context, material, model.reads_lobes())));
            }
            let Some((_, reading)) = &known else { continue };
            let mut surface = l.run(
                #[inline(always)]
                || {
                    let place = self.gather(l, context, sixteen, hits, batch);
                    let mut surface = SurfacePlace::none(l);
                    surface.find_hits(l, context, reading, batch, place);
                    surface
                },
            );
            store_surface(l, context, reading, batch, &mut surface, planes);
            let lets_through = material.transmits() || material.alpha_mode == AlphaMode::Blend;
            if lets_through {
                store_transmission(l, context, material, batch, &surface, planes);
                if matches!(material.alpha_mode, AlphaMode::Mask { .. }) {
                    // Rays pass where the mask is open: a hit is there. The batch has no place on the screen to look it up.
                    put(planes, layout::PRESENCE, [l.splat(1.0)]);
                }
                // The ray itself finds the surfaces behind.
                put(planes, layout::BACKDROP_COLOR, [l.zero(); 3]);
                put(planes, layout::BACKDROP_OPACITY, [l.splat(1.0); 3]);
            }
            if !material.unlit {
                store_face(l, context, batch, &surface, planes);
                store_lit(l, context, material, batch, &surface, planes);
                let directions = if part == ALL { (0, 1) } else { (usize::from(part), self.parts()) };
                self.occlusion.fill_by(l, context, material, planes, directions);
            }
            let mut radiance = shade(l, context, model, material, planes);
            if lets_through {
                radiance = pass_through(l, context, material, planes, radiance).radiance;
            }
            let radiance = radiance.to_arrays();
            for (lane, k) in sixteen.iter().enumerate() {
                found_radiance[*k as usize] = each_of(&radiance, lane);
            }
        }
        // In the order in which they were hit.
        for (hit, radiance) in hits.iter().zip(&*found_radiance) {
            let mut radiance = *radiance;
            let material = &context.materials[hit.material as usize];
            let is_diffuse = hit.lobe == TracedLobe::Diffuse;
            if self.emitters.has(hit.material) && (is_diffuse || hit.part != ALL) {
                radiance = Emitters::without_own(radiance, material, is_diffuse);
            }
            for (radiance, tint) in radiance.iter_mut().zip(hit.tint) {
                *radiance *= tint;
            }
            let weight = if hit.is_clear { 0.0 } else { hit.weight };
            found[hit.sender as usize].add_hit(hit.lobe, (hit.weight, weight), radiance);
        }
        hits.clear();
    }

    /// Gathers up to sixteen hits in a batch: their weights, the footprint of a ray on their triangles, and the
    /// viewpoints.
    #[inline(always)]
    fn gather<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        numbers: &[u32],
        hits: &[RayHit],
        batch: &mut Batch,
    ) -> ([L::F; 2], [L::F; 2], SeenFrom<L>) {
        let mut vertices = [([0; 3], 0); LANES];
        let mut back_facing = 0;
        let (mut weights, mut widths) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        let (mut position, mut view, mut distance) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        for lane in 0..LANES {
            let hit = &hits[numbers[lane.min(numbers.len() - 1)] as usize];
            let draws = if hit.is_clear { self.clear.draws } else { self.draws };
            let (place, triangle) = place_in(draws, hit.triangle);
            let of = &context.draws[place.draw as usize];
            vertices[lane] = (of.mesh.triangles()[triangle as usize], place.draw);
            let [a, b, c] = match hit.is_clear {
                true => self.clear.corners[(place.listed + triangle) as usize],
                false => self.corners(context, (place, triangle)),
            };
            let [v, w] = hit.barycentrics;
            let (mut edges, mut lengths) = ([[0.0; 3]; 2], [0.0_f32; 2]);
            for k in 0..3 {
                edges[0][k] = b[k] - a[k];
                edges[1][k] = c[k] - a[k];
                lengths[0] += edges[0][k] * edges[0][k];
                lengths[1] += edges[1][k] * edges[1][k];
                position[k][lane] = a[k] + edges[0][k] * v + edges[1][k] * w;
                view[k][lane] = -hit.direction[k];
            }
            let [[ex, ey, ez], [fx, fy, fz]] = edges;
            let normal = [ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx];
            let facing = (normal[0] * view[0][lane] + normal[1] * view[1][lane]) + normal[2] * view[2][lane];
            back_facing |= u16::from(facing * of.handedness < 0.0) << lane;
            let radius = hit.spread * hit.distance;
            for k in 0..2 {
                weights[k][lane] = hit.barycentrics[k];
                let length = lengths[k].sqrt();
                widths[k][lane] = if length > radius { radius / length } else { 1.0 };
            }
            distance[lane] = hit.distance;
        }
        batch.of_hits(&vertices[..numbers.len()], back_facing);
        let load = |planes: &[[f32; LANES]; 3]| {
            Vec3::new(l.load(&planes[0]), l.load(&planes[1]), l.load(&planes[2]))
        };
        let seen_from = SeenFrom {
            position: load(&position),
            view: load(&view).normalize(),
            distance: l.load(&distance),
        };
        ([l.load(&weights[0]), l.load(&weights[1])], [l.load(&widths[0]), l.load(&widths[1])], seen_from)
    }
}
