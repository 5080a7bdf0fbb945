//! Clear surfaces on the way of rays: those that are blended, and those that transmit light. Rays go on straight behind them.
//!
//! A crossing leaves of each colour what it leaves on maps of tinted light (`shadow/tinted.rs`): 1 - p + p t (1 - F) c with the presence p
//! (alpha), the share t of what enters that passes, Schlick's F at the angle of incidence and the base colour c; a volume absorbs
//! between the surfaces of a body. What a clear surface sends back itself is shaded as other hits are (`hits.rs`).

use super::{TraceScratch, TracedDraw, TracedLight, cross};
use crate::bvh::{Hierarchy, Hit, Ray};
use crate::shade::ShadeContext;
use crate::shade::surface::hit_color;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::scalar;
use overcoat_core::math::triple::dot;
use overcoat_scene::{AlphaMode, Workflow};

/// Crossings of a ray that are followed; behind the last of them nothing tints it any more.
const MOST: usize = 8;

/// Triangles of clear surfaces, all of them listed.
#[derive(Clone, Copy, Debug)]
pub struct ClearSurfaces<'a> {
    /// The triangles.
    pub hierarchy: &'a Hierarchy,
    /// Their corners, in world space.
    pub corners: &'a [[[f32; 3]; 3]],
    /// The draws that they are of.
    pub draws: &'a [TracedDraw],
}

/// Light that comes to the origin of a ray through clear surfaces.
#[derive(Clone, Copy)]
pub(super) struct Through {
    /// Transmittance of each colour, 0 to 1.
    pub(super) tint: [f32; 3],
    /// The surfaces that can be seen, each with the transmittance of those before it.
    pub(super) seen: [Option<(Hit, [f32; 3])>; MOST],
}

impl Through {
    /// No surface is crossed.
    pub(super) const OPEN: Self = Self { tint: [1.0; 3], seen: [None; MOST] };
}

/// A body of glass that a ray is in.
struct Inside {
    material: u32,
    extinction: [f32; 3],
    /// Distance at which it was entered.
    entered: f32,
}

impl Inside {
    /// Lets the body absorb along a way.
    fn absorb(&self, length: f32, tint: &mut [f32; 3]) {
        for (tint, extinction) in tint.iter_mut().zip(self.extinction) {
            *tint *= scalar::exp(-extinction * if length > 0.0 { length } else { 0.0 });
        }
    }
}

impl TracedLight<'_> {
    /// Follows a ray through clear surfaces up to its end.
    #[inline(never)]
    pub(super) fn through<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        ray: &Ray,
        scratch: &mut TraceScratch,
    ) -> Through {
        l.run(
            #[inline(always)]
            || self.follow(l, context, ray, scratch),
        )
    }

    #[inline(always)]
    fn follow<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        ray: &Ray,
        scratch: &mut TraceScratch,
    ) -> Through {
        let mut through = Through::OPEN;
        let mut inside: Option<Inside> = None;
        let mut rest = *ray;
        for seen in &mut through.seen {
            let traversal = &mut scratch.traversal;
            let Some(hit) = self.clear.hierarchy.nearest(
                l,
                &rest,
                traversal,
                #[inline(always)]
                |_| true,
            ) else {
                break;
            };
            let crossing = self.crossing(l, context, (&hit, ray.direction), scratch);
            *seen = crossing.is_seen.then_some((hit, through.tint));
            if crossing.is_front {
                inside = crossing.extinction.map(|extinction| Inside {
                    material: crossing.material,
                    extinction,
                    entered: hit.distance,
                });
            } else if let Some(body) = inside.take_if(|body| body.material == crossing.material) {
                body.absorb(hit.distance - body.entered, &mut through.tint);
            }
            for (tint, own) in through.tint.iter_mut().zip(crossing.tint) {
                *tint *= own;
            }
            rest.near = hit.distance + self.epsilon;
        }
        if let Some(body) = inside
            && ray.far.is_finite()
        {
            body.absorb(ray.far - body.entered, &mut through.tint);
        }
        through
    }

    /// Effect of a clear surface on a ray of a direction.
    #[inline(always)]
    fn crossing<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        (hit, along): (&Hit, [f32; 3]),
        scratch: &mut TraceScratch,
    ) -> Crossing {
        let (place, triangle) = place_in(self.clear.draws, hit.triangle);
        let of = &context.draws[place.draw as usize];
        let material = &context.materials[of.material as usize];
        let (normal, length) = cross(&self.clear.corners[(place.listed + triangle) as usize]);
        let facing = dot(normal, along) * of.handedness;
        let (is_front, cosine) = (facing < 0.0, facing.abs() / if length > 0.0 { length } else { 1.0 });
        let transmission = &material.lobes.transmission;
        let straight = if material.is_transmissive() { transmission.factor.factor } else { 0.0 };
        let reflected = schlick(material.dielectric_f0(), cosine);
        let is_seen = is_front || (material.double_sided && !material.refracts());
        let volume = straight > 0.0 && transmission.has_volume();
        let extinction = (is_front && volume).then(|| transmission.extinction());
        let mut crossing = Crossing { tint: [1.0; 3], is_seen, is_front, material: of.material, extinction };
        if !(is_front || material.double_sided) {
            // Light leaves a body by its inner side.
            if straight > 0.0 {
                crossing.tint = [1.0 - reflected; 3];
            }
            return crossing;
        }
        scratch.batch.of_hits(&[(of.mesh.triangles()[triangle as usize], place.draw)], 0);
        let weights = hit.barycentrics.map(|b| l.splat(b));
        let [r, g, b, a] = hit_color(l, context, material, &scratch.batch, weights).map(|c| c.to_array()[0]);
        let presence = match material.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Blend => clamped(a),
            AlphaMode::Mask { cutoff } => f32::from(u8::from(a >= cutoff)),
        };
        let metallic = match material.workflow {
            Workflow::MetallicRoughness { metallic, .. } => metallic,
            Workflow::SpecularGlossiness { .. } => 0.0,
        };
        let entering = straight * (1.0 - clamped(metallic)) * (1.0 - reflected);
        let halved = material.refracts() && material.double_sided;
        crossing.tint = [r, g, b].map(|c| {
            let c = clamped(c);
            let c = if halved { c.sqrt() } else { c };
            clamped((1.0 - presence) + presence * (entering * c))
        });
        crossing.is_seen &= presence > 0.0;
        crossing
    }
}

/// Crossing of a clear surface.
struct Crossing {
    tint: [f32; 3],
    /// It sends light back along the ray.
    is_seen: bool,
    /// The ray comes from the front.
    is_front: bool,
    material: u32,
    /// Extinction of the volume that the ray enters.
    extinction: Option<[f32; 3]>,
}

/// The draw of a triangle, and the triangle's number in it.
pub(super) fn place_in(draws: &[TracedDraw], triangle: u32) -> (&TracedDraw, u32) {
    let after = draws.partition_point(|of| of.first <= triangle);
    let of = &draws[after.saturating_sub(1)];
    (of, triangle - of.first)
}

/// Schlick's reflectance (1994).
fn schlick(f0: f32, cosine: f32) -> f32 {
    let grazing = 1.0 - clamped(cosine);
    let square = grazing * grazing;
    // An index of 1 is no interface.
    let rest = if f0 > 0.0 { 1.0 - f0 } else { 0.0 };
    f0 + rest * (square * square * grazing)
}

/// A number kept to 0 to 1; 0 of what is none.
fn clamped(x: f32) -> f32 {
    if x > 0.0 { if x < 1.0 { x } else { 1.0 } } else { 0.0 }
}
