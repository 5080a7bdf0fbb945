//! Light of other surfaces, by rays: what blocks a lobe is shaded where it is hit, one bounce.
//!
//! Each lobe of a fragment sends a few rays. Those that miss everything say how much of the environment's light is open (a
//! ratio again, as in `visibility.rs`, so that open lobes keep the bits of the prefiltered environment); those that hit bring
//! the radiance of what they hit, by the model and the textures of its own material, under the light that the depth maps let
//! reach it. Diffuse light takes from rays only what comes back: what is open is known better by the maps.

use super::effects::Effect;
use super::lobe_samples::{LobeSamples, cosine_direction, ggx_direction};
use super::normals::any_basis;
use super::record::{get, get_vector, put};
use super::surface::{SeenFrom, SurfacePlace, SurfaceReading, hit_opacity, store_face};
use super::visibility::{LightVisibility, share};
use super::{ShadeContext, shade, store_lit, store_surface};
use crate::bvh::{Hierarchy, Hit, Ray, Traversal};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::math::lanes::{Float, LANES, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};
use crate::scene::{AlphaMode, Material};

/// What rays meet in a scene.
#[derive(Clone, Copy, Debug)]
pub struct TracedLight<'a> {
    /// The triangles.
    pub hierarchy: &'a Hierarchy,
    /// Their corners in world space.
    pub corners: &'a [[[f32; 3]; 3]],
    /// The draws that have triangles among them, and the first triangle of each.
    pub draws: &'a [(u32, u32)],
    /// The rays of a lobe.
    pub samples: &'a LobeSamples,
    /// Length below which distances mean nothing.
    pub epsilon: f32,
    /// What light reaches the places that are hit.
    pub visibility: LightVisibility<'a>,
}

/// The lobes that send rays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lobe {
    Diffuse,
    Base,
    Coat,
}

impl Lobe {
    /// The open share of the sphere under the lobe, by the maps.
    #[inline(always)]
    fn sky<L: Lanes>(self, l: L, planes: &SurfacePlanes) -> L::F {
        let [all] = get(l, planes, layout::SKY);
        let [base, coat] = get(l, planes, layout::LOBE_SKY);
        match self {
            Self::Diffuse => all,
            Self::Base => base,
            Self::Coat => coat,
        }
    }

    fn planes(self) -> [Plane; 2] {
        match self {
            Self::Diffuse => [layout::DIFFUSE_SEEN, layout::DIFFUSE_BOUNCE],
            Self::Base => [layout::BASE_SEEN, layout::BASE_BOUNCE],
            Self::Coat => [layout::COAT_SEEN, layout::COAT_BOUNCE],
        }
    }
}

/// A ray that hits something.
#[derive(Clone, Copy, Debug)]
struct RayHit {
    lane: usize,
    weight: f32,
    direction: [f32; 3],
    triangle: u32,
    material: u32,
    barycentrics: [f32; 2],
    distance: f32,
    /// What it sends back.
    radiance: [f32; 3],
}

/// Memory of one thread.
#[derive(Debug, Default)]
pub struct TraceScratch {
    traversal: Traversal,
    hits: Vec<RayHit>,
    order: Vec<u32>,
    batch: Batch,
    planes: SurfacePlanes,
}

/// The rays of one lobe of sixteen fragments, gathered.
struct Sums<L: Lanes> {
    /// Share of what the maps say: what few rays say of a wide lobe is noise.
    wide: L::F,
    weight: L::F,
    all: V3<L>,
    open: V3<L>,
}

impl TracedLight<'_> {
    /// Sends the rays of up to sixteen fragments of a material at these pixels of the picture, and fills the planes of
    /// [`LightVisibility`] anew.
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
        if material.unlit {
            return;
        }
        for lobe in [Lobe::Diffuse, Lobe::Base, Lobe::Coat] {
            if lobe == Lobe::Coat && material.coat <= 0.0 {
                continue;
            }
            let sums = self.send(l, context, lobe, (len, pixels), planes, scratch);
            self.shade_hits(l, context, self.spread(l, lobe, planes), scratch);
            l.run(
                #[inline(always)]
                || store(l, lobe, &sums, &scratch.hits, planes),
            );
        }
    }

    /// How far apart the rays of a lobe are, as an angle: about the square root of the part of it that each stands for.
    #[inline(always)]
    fn spread<L: Lanes>(&self, l: L, lobe: Lobe, planes: &SurfacePlanes) -> [f32; LANES] {
        let count = self.samples.len() as f32;
        let roughness = match lobe {
            Lobe::Diffuse => return [1.5 / count.sqrt(); LANES],
            Lobe::Base => layout::ROUGHNESS,
            Lobe::Coat => layout::COAT_ROUGHNESS,
        };
        let [roughness] = get::<L, 1>(l, planes, roughness);
        ((roughness.squared() + 0.002) * (1.5 / count.sqrt())).to_array()
    }

    /// Sends the rays of one lobe.
    #[inline(always)]
    fn send<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        lobe: Lobe,
        (len, pixels): (usize, &[[u32; 2]; LANES]),
        planes: &SurfacePlanes,
        scratch: &mut TraceScratch,
    ) -> Sums<L> {
        let mut sums = Sums { wide: l.splat(1.0), weight: l.zero(), all: Vec3::zero(l), open: Vec3::zero(l) };
        scratch.hits.clear();
        l.run(
            #[inline(always)]
            || {
                let position = get_vector(l, planes, layout::FACE_POSITION);
                let face = get_vector(l, planes, layout::FACE_NORMAL);
                let view = get_vector(l, planes, layout::VIEW);
                let [normal, roughness] = match lobe {
                    Lobe::Coat => [layout::COAT_NORMAL, layout::COAT_ROUGHNESS],
                    _ => [layout::NORMAL, layout::ROUGHNESS],
                };
                let (normal, [roughness]) = (get_vector(l, planes, normal), get(l, planes, roughness));
                let alpha = roughness.squared().at_least(1e-4);
                let (tangent, bitangent) = any_basis(l, normal);
                let frame = [tangent, bitangent, normal];
                let start = (position + face * self.epsilon).to_arrays();
                let turns = self.samples.turns(l, pixels, lobe as u32);
                // What one of the rays stands for is as rough as its part of the lobe.
                let part = roughness * if self.samples.len() < 8 { 0.7 } else { 0.5 };
                // Nothing is sent where the maps find nothing in the way, and few rays into narrow lobes.
                let most = self.samples.len() as f32;
                let mut wanted = l.splat(most);
                sums.wide = l.splat(2.0 / most.sqrt()).at_most(1.0);
                let mut open = lobe.sky(l, planes).ge(l.splat(1.0));
                if lobe != Lobe::Diffuse {
                    sums.wide = ((alpha - SHARP[0] * most) * (1.0 / SHARP[1])).saturate();
                    wanted = (alpha * (1.0 / NARROW)).saturate() * (most - 1.0) + 1.0;
                    open = open & Lobe::Diffuse.sky(l, planes).ge(l.splat(1.0));
                }
                let wanted = open.select(l.zero(), wanted);
                for number in 0..self.samples.len() {
                    let point = self.samples.point(l, number, &turns);
                    let (towards, weight) = match lobe {
                        Lobe::Diffuse => (cosine_direction(l, &frame, point), l.splat(1.0)),
                        _ => ggx_direction(l, &frame, view, alpha, point),
                    };
                    // Nothing is sent below the surface: what a bump would see is its neighbour.
                    let height = face.dot(towards);
                    let towards = towards - face * (height * 2.0).at_most(0.0);
                    let sent = wanted.gt(l.splat(number as f32));
                    if !sent.any() {
                        break;
                    }
                    let weight = sent.select(weight, l.zero());
                    let mut hit = 0_u16;
                    let (directions, weights) = (towards.to_arrays(), weight.to_array());
                    for lane in 0..len {
                        if weights[lane] <= 0.0 {
                            continue;
                        }
                        let along =
                            |planes: &[[f32; LANES]; 3]| [planes[0][lane], planes[1][lane], planes[2][lane]];
                        let (origin, direction) = (along(&start), along(&directions));
                        let ray = Ray { origin, direction, near: 0.0, far: f32::INFINITY };
                        if let Some(found) =
                            self.nearest(l, context, &ray, &mut scratch.traversal, &mut scratch.batch)
                        {
                            hit |= 1 << lane;
                            let (draw, _) = self.place(found.triangle);
                            scratch.hits.push(RayHit {
                                lane,
                                weight: weights[lane],
                                direction,
                                triangle: found.triangle,
                                material: context.draws[draw as usize].material,
                                barycentrics: found.barycentrics,
                                distance: found.distance,
                                radiance: [0.0; 3],
                            });
                        }
                    }
                    sums.weight = sums.weight + weight;
                    if lobe != Lobe::Diffuse {
                        let light = context.environment.radiance(l, towards, part) * weight;
                        sums.all += light;
                        sums.open += Vec3::select(l.mask(hit), Vec3::zero(l), light);
                    }
                }
            },
        );
        sums
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
        self.hierarchy.nearest(l, ray, traversal, |hit| {
            let (draw, triangle) = self.place(hit.triangle);
            let of = &context.draws[draw as usize];
            let material = &context.materials[of.material as usize];
            let AlphaMode::Mask { cutoff } = material.alpha_mode else { return true };
            batch.of_hits(&[(of.mesh.triangles()[triangle as usize], draw)], 0);
            let weights = hit.barycentrics.map(|b| l.splat(b));
            hit_opacity(l, context, material, batch, weights).to_array()[0] >= cutoff
        })
    }

    /// The draw of a triangle, and the triangle's number in it.
    fn place(&self, triangle: u32) -> (u32, u32) {
        let after = self.draws.partition_point(|(_, first)| *first <= triangle);
        let (draw, first) = self.draws[after.saturating_sub(1)];
        (draw, triangle - first)
    }

    /// Finds what the hits send back, sixteen of one material at a time.
    #[inline(always)]
    fn shade_hits<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        spread: [f32; LANES],
        scratch: &mut TraceScratch,
    ) {
        let TraceScratch { hits, order, batch, planes, .. } = scratch;
        order.clear();
        order.extend(0..hits.len() as u32);
        order.sort_unstable_by_key(|k| (hits[*k as usize].material, hits[*k as usize].triangle, *k));
        let mut rest = &order[..];
        while let Some(first) = rest.first() {
            let number = hits[*first as usize].material;
            let same = rest.iter().take(LANES).take_while(|k| hits[**k as usize].material == number).count();
            let (sixteen, others) = rest.split_at(same);
            rest = others;
            let material = &context.materials[number as usize];
            let model = material.shading(context.model);
            let reading = SurfaceReading::of(context, material, model.reads_lobes());
            let place = self.gather(l, context, sixteen, hits, &spread, batch);
            let mut surface = SurfacePlace::none(l);
            surface.find_hits(l, context, &reading, batch, place);
            store_surface(l, context, &reading, batch, &mut surface, planes);
            if !material.unlit {
                store_face(l, context, batch, &surface, planes);
                store_lit(l, context, material, batch, &surface, planes);
                self.visibility.fill(l, context, material, planes);
            }
            let radiance = shade(l, context, model, material, planes).to_arrays();
            for (lane, k) in sixteen.iter().enumerate() {
                hits[*k as usize].radiance = [radiance[0][lane], radiance[1][lane], radiance[2][lane]];
            }
        }
    }

    /// Puts up to sixteen hits into a batch: their weights, how much of their triangles a ray stands for, and from where they
    /// are seen.
    #[inline(always)]
    fn gather<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        numbers: &[u32],
        hits: &[RayHit],
        spread: &[f32; LANES],
        batch: &mut Batch,
    ) -> ([L::F; 2], [L::F; 2], SeenFrom<L>) {
        let mut vertices = [([0; 3], 0); LANES];
        let mut back_facing = 0;
        let (mut weights, mut widths) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        let (mut position, mut view, mut distance) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        for lane in 0..LANES {
            let hit = &hits[numbers[lane.min(numbers.len() - 1)] as usize];
            let (draw, triangle) = self.place(hit.triangle);
            let of = &context.draws[draw as usize];
            vertices[lane] = (of.mesh.triangles()[triangle as usize], draw);
            let [a, b, c] = self.corners[hit.triangle as usize];
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
            let radius = spread[hit.lane] * hit.distance;
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

/// How many rays the estimate of the maps counts for beside those that hit something.
const PRIOR: f32 = 0.25;

/// From which alpha on the maps have a say about a lobe, for each ray that it sends, and over how much of alpha it becomes all.
const SHARP: [f32; 2] = [0.02, 0.3];

/// Lobes of less than this alpha send fewer rays than others: in a mirror all are the same.
const NARROW: f32 = 0.2;

/// Writes what the rays of a lobe have found.
#[inline(always)]
fn store<L: Lanes>(l: L, lobe: Lobe, sums: &Sums<L>, hits: &[RayHit], planes: &mut SurfacePlanes) {
    let (mut sent, mut weights) = ([[0.0; LANES]; 3], [0.0; LANES]);
    for hit in hits {
        weights[hit.lane] += hit.weight;
        for k in 0..3 {
            sent[k][hit.lane] += hit.radiance[k] * hit.weight;
        }
    }
    let sent = Vec3::new(l.load(&sent[0]), l.load(&sent[1]), l.load(&sent[2]));
    let weights = l.load(&weights);
    let [seen_plane, bounce_plane] = lobe.planes();
    // The open share by the maps, and from what is blocked the mean of what rays have met there.
    let (estimate, blocked) = (get_vector(l, planes, bounce_plane), lobe.sky(l, planes).one_minus());
    let mean = (sent * blocked + estimate * PRIOR) / (weights + PRIOR);
    // Where none has met anything though some should have, less is blocked.
    let expected = (sums.weight * blocked + 1.0).recip();
    let none = !weights.gt(l.zero());
    let mean = mean * none.select(expected, l.splat(1.0));
    // By the rays alone.
    let direct = sent / sums.weight.at_least(1e-6);
    let traced = sums.weight.gt(l.zero());
    let bounce = Vec3::select(traced, direct.lerp(mean, sums.wide), estimate);
    put(planes, bounce_plane, bounce.to_array());
    if lobe != Lobe::Diffuse {
        let (direct, known) = (share(l, sums.open, sums.all), get_vector(l, planes, seen_plane));
        let seen = Vec3::select(traced, direct.lerp(known, sums.wide), known);
        put(planes, seen_plane, seen.to_array());
    }
}
