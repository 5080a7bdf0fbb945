//! Light of other surfaces, by rays: what blocks a lobe is shaded where it is hit, one bounce.
//!
//! Each lobe of a fragment sends a few rays. Those that miss everything say how much of the environment's light is open (a
//! ratio again, as in `visibility.rs`, so that open lobes keep the bits of the prefiltered environment); those that hit bring
//! the radiance of what they hit, by the model and the textures of its own material, under the light that the depth maps let
//! reach it (`hits.rs`). What rays have found is kept as sums ([`Found`]), so that those of neighbours can be added before
//! shading reads what they come to.

mod found;
mod hits;

pub use found::Found;

use super::ShadeContext;
use super::lobe_samples::{LobeSamples, cosine_direction, ggx_direction};
use super::record::{get, get_vector};
use super::surface::{any_basis, hit_opacity};
use super::visibility::LightVisibility;
use crate::bvh::{Hierarchy, Hit, Ray, Traversal};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::math::lanes::{Float, LANES, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};
use crate::scene::{AlphaMode, Material, Workflow};
use hits::RayHit;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TracedLobe {
    /// Diffuse light of the base.
    Diffuse,
    /// Reflections of the base.
    Base,
    /// Reflections of the coat.
    Coat,
}

impl TracedLobe {
    /// All of them.
    pub const ALL: [Self; Self::COUNT] = [Self::Diffuse, Self::Base, Self::Coat];
    /// How many there are.
    pub const COUNT: usize = 3;

    /// Those that surfaces of a material have.
    #[must_use]
    pub fn of(material: &Material) -> &'static [Self] {
        match material.coat > 0.0 {
            _ if material.unlit => &[],
            true => &[Self::Diffuse, Self::Base, Self::Coat],
            false => &[Self::Diffuse, Self::Base],
        }
    }

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

    /// Its planes: what is open, and what is sent back where it is not.
    fn planes(self) -> [Plane; 2] {
        match self {
            Self::Diffuse => [layout::DIFFUSE_SEEN, layout::DIFFUSE_BOUNCE],
            Self::Base => [layout::BASE_SEEN, layout::BASE_BOUNCE],
            Self::Coat => [layout::COAT_SEEN, layout::COAT_BOUNCE],
        }
    }

    /// The normal and the perceptual roughness that it is about.
    fn shape(self) -> [Plane; 2] {
        match self {
            Self::Coat => [layout::COAT_NORMAL, layout::COAT_ROUGHNESS],
            Self::Diffuse | Self::Base => [layout::NORMAL, layout::ROUGHNESS],
        }
    }
}

/// Those of whom rays are sent.
#[derive(Clone, Copy, Debug)]
pub struct Senders<'a> {
    /// For each of up to sixteen fragments of a material, its place among what is found.
    pub places: &'a [u32],
    /// Their pixels in the picture.
    pub pixels: &'a [[u32; 2]; LANES],
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
    /// How many hits wait for [`TracedLight::shade_hits`].
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.hits.len()
    }
}

/// Lobes of less than this alpha send fewer rays than others: in a mirror all are the same.
const NARROW: f32 = 0.2;

impl TracedLight<'_> {
    /// Sends the rays of up to sixteen fragments of a material, shades what they hit, and fills the planes of
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
        let mut found = [Found::default(); LANES];
        let places: [u32; LANES] = std::array::from_fn(|k| k as u32);
        let senders = Senders { places: &places[..len.min(LANES)], pixels };
        self.send(l, context, material, &senders, planes, scratch, &mut found);
        self.shade_hits(l, context, scratch, &mut found);
        Found::store(l, material, &found, planes);
    }

    /// Sends the rays of up to sixteen fragments of a material, whose surface is in `planes`. What they hit waits to be shaded.
    #[inline(never)]
    pub fn send<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        senders: &Senders<'_>,
        planes: &SurfacePlanes,
        scratch: &mut TraceScratch,
        found: &mut [Found],
    ) {
        for &lobe in TracedLobe::of(material) {
            l.run(
                #[inline(always)]
                || self.send_of(l, context, (lobe, material), senders, planes, scratch, found),
            );
        }
    }

    /// How far apart the rays of a lobe are, as an angle: about the square root of the part of it that each stands for.
    #[inline(always)]
    fn spread<L: Lanes>(&self, l: L, lobe: TracedLobe, planes: &SurfacePlanes) -> [f32; LANES] {
        let each = 1.5 / (self.samples.len() as f32).sqrt();
        if lobe == TracedLobe::Diffuse {
            return [each; LANES];
        }
        let [roughness] = get::<L, 1>(l, planes, lobe.shape()[1]);
        ((roughness.squared() + 0.002) * each).to_array()
    }

    /// How many rays a lobe sends: none where the maps find nothing in the way or the lobe shows nothing, few into narrow ones
    /// and those that show little.
    #[inline(always)]
    fn wanted<L: Lanes>(
        &self,
        l: L,
        lobe: TracedLobe,
        material: &Material,
        alpha: L::F,
        planes: &SurfacePlanes,
    ) -> L::F {
        let most = self.samples.len() as f32;
        let one = l.splat(1.0);
        let mut open = lobe.sky(l, planes).ge(one);
        let mut narrow = one;
        if lobe != TracedLobe::Diffuse {
            narrow = (alpha * (1.0 / NARROW)).saturate();
            open = open & TracedLobe::Diffuse.sky(l, planes).ge(one);
        }
        let shown = weight_in_picture(l, lobe, material, planes);
        let gain = if lobe == TracedLobe::Diffuse { ALL_RAYS[0] } else { ALL_RAYS[1] };
        let wanted = narrow * (shown * gain).saturate() * (most - 1.0) + 1.0;
        (open | shown.lt(l.splat(LEAST_SHOWN))).select(l.zero(), wanted)
    }

    /// Sends the rays of one lobe.
    #[inline(always)]
    fn send_of<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        (lobe, material): (TracedLobe, &Material),
        senders: &Senders<'_>,
        planes: &SurfacePlanes,
        scratch: &mut TraceScratch,
        found: &mut [Found],
    ) {
        let face = get_vector(l, planes, layout::FACE_NORMAL);
        let view = get_vector(l, planes, layout::VIEW);
        let [normal, roughness] = lobe.shape();
        let (normal, [roughness]) = (get_vector(l, planes, normal), get(l, planes, roughness));
        let alpha = roughness.squared().at_least(1e-4);
        let wanted = self.wanted(l, lobe, material, alpha, planes);
        if !wanted.gt(l.zero()).any() {
            return;
        }
        let (tangent, bitangent) = any_basis(l, normal);
        let frame = [tangent, bitangent, normal];
        let position = get_vector(l, planes, layout::FACE_POSITION);
        let start = (position + face * self.epsilon).to_arrays();
        let spread = self.spread(l, lobe, planes);
        let is_wide = if lobe == TracedLobe::Diffuse { l.mask(u16::MAX) } else { alpha.gt(l.splat(NARROW)) };
        let wide = is_wide.select(l.splat(1.0), l.zero()).to_array();
        let turns = self.samples.turns(l, senders.pixels, lobe as u32);
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
            let (directions, weights) = (towards.to_arrays(), weight.to_array());
            for (lane, &sender) in senders.places.iter().enumerate().take(LANES) {
                if weights[lane] <= 0.0 {
                    continue;
                }
                let along = |planes: &[[f32; LANES]; 3]| [planes[0][lane], planes[1][lane], planes[2][lane]];
                let (origin, direction) = (along(&start), along(&directions));
                let ray = Ray { origin, direction, near: 0.0, far: f32::INFINITY };
                let TraceScratch { traversal, batch, hits, .. } = scratch;
                if let Some(met) = self.nearest(l, context, &ray, traversal, batch) {
                    hit |= 1 << lane;
                    let (draw, _) = self.place(met.triangle);
                    hits.push(RayHit {
                        sender,
                        lobe,
                        part: self.part_of(wide[lane] > 0.0, senders.pixels[lane], number),
                        weight: weights[lane],
                        direction,
                        triangle: met.triangle,
                        material: context.draws[draw as usize].material,
                        barycentrics: met.barycentrics,
                        distance: met.distance,
                        spread: spread[lane],
                    });
                }
            }
            sent_weight = sent_weight + weight;
            if lobe != TracedLobe::Diffuse {
                let light = context.environment.radiance(l, towards, part) * weight;
                all += light;
                open += Vec3::select(l.mask(hit), Vec3::zero(l), light);
            }
        }
        let (weights, all, open) = (sent_weight.to_array(), all.to_arrays(), open.to_arrays());
        for (lane, &sender) in senders.places.iter().enumerate().take(LANES) {
            found[sender as usize].add_sent(lobe, weights[lane], each_of(&all, lane), each_of(&open, lane));
        }
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
}

/// Inverse of the share that lobes show from which on they send all their rays: of diffuse ones, and of reflections, whose light
/// is less even.
const ALL_RAYS: [f32; 2] = [2.0, 8.0];

/// Lobes that show less of the light send no rays.
const LEAST_SHOWN: f32 = 0.01;

/// Which share of the light in a lobe is seen, about: the largest of red, green and blue of what the surface reflects of it.
#[inline(always)]
fn weight_in_picture<L: Lanes>(l: L, lobe: TracedLobe, material: &Material, planes: &SurfacePlanes) -> L::F {
    let largest = |color: V3<L>| color.x.max(color.y).max(color.z);
    let color = largest(get_vector(l, planes, layout::BASE_COLOR));
    let [metallic] = get(l, planes, layout::METALLIC);
    if lobe == TracedLobe::Diffuse {
        return color * metallic.one_minus();
    }
    let normal = get_vector(l, planes, lobe.shape()[0]);
    let grazing = normal.dot(get_vector(l, planes, layout::VIEW)).one_minus().saturate();
    let grazing = grazing.squared().squared() * grazing;
    let (weight, f0) = if lobe == TracedLobe::Coat {
        (get::<L, 1>(l, planes, layout::COAT)[0], l.splat(COAT_F0))
    } else {
        let specular = largest(get_vector(l, planes, layout::SPECULAR_COLOR));
        let [weight] = get(l, planes, layout::SPECULAR_WEIGHT);
        let dielectric = match &material.workflow {
            Workflow::MetallicRoughness { .. } => specular * material.dielectric_f0(),
            Workflow::SpecularGlossiness { .. } => specular,
        };
        (weight.lerp(l.splat(1.0), metallic), dielectric.lerp(color, metallic))
    };
    weight * f0.lerp(l.splat(1.0), grazing).at_most(1.0)
}

/// Reflectance of coats at normal incidence: an index of refraction of 1.5.
const COAT_F0: f32 = 0.04;

/// One lane of three planes.
#[inline(always)]
fn each_of(planes: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
    [planes[0][lane], planes[1][lane], planes[2][lane]]
}
