//! Occlusion of lamps: the light of those without extent is multiplied by their visibility; of rectangles and tubes, it
//! is the part of a lobe's light that comes from places of them that are seen.
//!
//! Light falls on the smooth surface that a mesh stands for, not on its flat triangles, or each that turns away from a lamp
//! would be dark where shading is not (Hanika 2021, "Hacking the shadow terminator", Ray Tracing Gems II, chapter 4).

use super::ShadeContext;
use super::effects::Effect;
use super::occlusion::{Arriving, LobeShares, is_coat, share};
use super::record::{get, get_vector, put};
use super::surface::SurfacePlace;
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, SurfacePlanes};
use crate::light::{AreaLight, AreaShape, LUMINANCE, LightSample, PunctualLight};
use crate::shadow::{LampMaps, LampTints, Receiver};
use overcoat_core::built::{AreaLights, Shadows};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Material, Mesh};
use overcoat_shading::coat::EnvironmentQuery;

/// Shadows of a scene's lamps, prepared for any camera.
#[derive(Clone, Copy, Debug)]
pub struct LampOcclusion<'a> {
    /// Depth maps of each: first the lights without extent, by their number, then [`LampOcclusion::parts`].
    pub maps: &'a LampMaps,
    /// Maps of the surfaces that tint the light of each.
    pub tints: &'a LampTints,
    /// Number of lights without extent.
    pub punctual: usize,
    /// Parts of rectangles and tubes.
    pub parts: &'a [LampPart],
    /// Shadows are compiled in.
    pub built: Shadows,
}

/// A part of a rectangle or tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampPart {
    /// The lamp, of the picture's area lights.
    pub light: u32,
    /// Its middle in world space.
    pub position: [f32; 3],
    /// Its area, of tubes that of the side that is seen.
    pub area: f32,
}

/// Corners whose normals are further off the triangle than this cosine say nothing of a smooth surface.
const SMOOTH: f32 = 0.3;

/// Writes what [`LampOcclusion`] needs of a surface: the rows [`layout::LIT`]. The surface and its triangles are in `planes`.
#[inline(never)]
pub fn store_lit<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    place: &SurfacePlace<L>,
    planes: &mut SurfacePlanes,
) {
    let Some(lamps) = &context.lamps else { return };
    l.run(
        #[inline(always)]
        || {
            let face = get_vector(l, planes, layout::FACE_NORMAL);
            let position = get_vector(l, planes, layout::FACE_POSITION);
            let smooth = smooth_position(l, context, batch, place, position, face);
            put(planes, layout::LIT_POSITION, smooth.to_array());
            let vertex = get_vector(l, planes, layout::VERTEX_NORMAL);
            let is_smooth = vertex.dot(face).gt(l.splat(SMOOTH));
            put(planes, layout::LIT_NORMAL, Vec3::select(is_smooth, vertex, face).to_array());
            if AreaLights::IS_BUILT && !lamps.parts.is_empty() {
                lamps.look_up_parts(l, context, material, planes);
            }
        },
    );
}

/// Places on triangles, moved onto the surface that is bent through their corners as their normals say.
#[inline(always)]
fn smooth_position<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    batch: &Batch,
    place: &SurfacePlace<L>,
    position: V3<L>,
    face: V3<L>,
) -> V3<L> {
    let corners = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::positions);
    let normals = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::normals);
    let shifts: [[L::F; 3]; 3] = each!(k => {
        let corner = batch.vertices.to_world(l, context.draws, Vec3::from_array(corners[k]));
        let normal = Vec3::from_array(normals[k]);
        let normal = batch.vertices.transform(l, context.draws, |d| d.normal_matrix, normal);
        let length = normal.dot(normal);
        let unit = normal * length.at_least(1e-30).sqrt().recip();
        let facing = unit.dot(face);
        // Below the plane through the corner, on the side that is seen.
        let below = unit.dot(position - corner);
        let below = facing.gt(l.zero()).select(below, -below).at_most(0.0);
        let there = facing.abs().gt(l.splat(SMOOTH));
        let shift = there.select(facing.gt(l.zero()).select(-below, below), l.zero());
        (unit * shift).to_array()
    });
    position + Vec3::from_array(place.location().interpolate(&shifts))
}

impl LampOcclusion<'_> {
    /// Irradiance over pi of all rectangles and tubes, of that which would reach the base.
    #[inline(always)]
    pub(super) fn irradiance<L: Lanes>(l: L, planes: &SurfacePlanes, unoccluded: V3<L>) -> V3<L> {
        unoccluded * get_vector(l, planes, layout::LAMPS_DIFFUSE_SEEN)
    }

    /// Their mean radiance over a lobe, of that which would reach it.
    #[inline(always)]
    pub(super) fn radiance<L: Lanes>(
        l: L,
        planes: &SurfacePlanes,
        material: &Material,
        query: &EnvironmentQuery<L>,
        unoccluded: V3<L>,
    ) -> V3<L> {
        let mut seen = get_vector(l, planes, layout::LAMPS_BASE_SEEN);
        if material.coat > 0.0 {
            let of_coat = get_vector(l, planes, layout::LAMPS_COAT_SEEN);
            seen = Vec3::select(is_coat(l, planes, query), of_coat, seen);
        }
        unoccluded * seen
    }

    /// Irradiance from lights on surfaces, and what it would be without anything in their way. Rectangles and tubes that are not in
    /// `area_lights` add nothing.
    #[inline(never)]
    pub fn irradiance_of_all<L: Lanes>(
        &self,
        l: L,
        lights: &[PunctualLight],
        area_lights: &[AreaLight],
        receiver: &Receiver<L>,
    ) -> [V3<L>; 2] {
        l.run(
            #[inline(always)]
            || {
                let (mut open, mut all) = (Vec3::zero(l), Vec3::zero(l));
                for light in lights {
                    let LightSample { direction, irradiance, .. } = light.sample(l, receiver.position);
                    let seen = self.arriving(l, light.number as usize, receiver).share;
                    let light = irradiance * receiver.normal.dot(direction).at_least(0.0);
                    all += light;
                    open += light * seen;
                }
                for (number, part) in self.parts.iter().enumerate() {
                    let Some(light) = area_lights.get(part.light as usize) else { continue };
                    let (towards, angle) = seen_from(l, light, part, receiver.position);
                    let seen = self.arriving(l, self.punctual + number, receiver).share;
                    let cosine = receiver.normal.dot(towards).at_least(0.0);
                    let light = Vec3::splat(l, light.radiance) * angle * cosine;
                    all += light;
                    open += light * seen;
                }
                [open, all]
            },
        )
    }

    /// Light of a lamp that arrives at surfaces, past what blocks it and through what tints it.
    #[inline(always)]
    fn arriving<L: Lanes>(&self, l: L, number: usize, receiver: &Receiver<L>) -> Arriving<L> {
        let visible = self.maps.visibility(l, number, receiver);
        let is_tinted = !self.tints.is_empty() && visible.gt(l.zero()).any();
        let tint = if is_tinted { Some(self.tints.transmittance(l, number, receiver)) } else { None };
        Arriving::new(visible, tint)
    }

    /// Share of each colour of the light of a source without extent that arrives at surfaces, 0 to 1.
    #[inline(never)]
    pub(super) fn of_light<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        light: &PunctualLight,
        planes: &SurfacePlanes,
    ) -> V3<L> {
        l.run(
            #[inline(always)]
            || {
                let number = light.number as usize;
                if number >= self.punctual {
                    return Vec3::splat(l, [1.0; 3]);
                }
                self.arriving(l, number, &receiver(l, context, material, planes)).share
            },
        )
    }

    /// Finds what part of the light of all rectangles and tubes reaches each lobe.
    #[inline(always)]
    fn look_up_parts<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    ) {
        let receiver = receiver(l, context, material, planes);
        let view = get_vector(l, planes, layout::VIEW);
        let normal = get_vector(l, planes, layout::NORMAL);
        let [roughness] = get(l, planes, layout::ROUGHNESS);
        let mut base = LobeShares::new(l, view, normal, roughness);
        let coat_normal = get_vector(l, planes, layout::COAT_NORMAL);
        let [coat_roughness] = get(l, planes, layout::COAT_ROUGHNESS);
        let mut coat = LobeShares::new(l, view, coat_normal, coat_roughness);
        let (mut all, mut open) = (Vec3::zero(l), Vec3::zero(l));
        for (number, part) in self.parts.iter().enumerate() {
            let Some(light) = context.area_lights.get(part.light as usize) else { continue };
            let (towards, angle) = seen_from(l, light, part, receiver.position);
            let arriving = self.arriving(l, self.punctual + number, &receiver);
            let flux = Vec3::splat(l, light.radiance) * angle;
            let weight = flux * normal.dot(towards).at_least(0.0);
            all += weight;
            open += weight * arriving.share;
            base.add(towards, (flux, angle), &arriving);
            if material.coat > 0.0 {
                coat.add(towards, (flux, angle), &arriving);
            }
        }
        put(planes, layout::LAMPS_DIFFUSE_SEEN, share(l, open, all).to_array());
        put(planes, layout::LAMPS_BASE_SEEN, base.shares(l).0.to_array());
        put(planes, layout::LAMPS_COAT_SEEN, coat.shares(l).0.to_array());
    }
}

/// Share of all lights that arrives, as data for users: in a plane of its own that no shading model reads.
#[derive(Clone, Copy, Debug)]
pub struct LitShares;

impl Effect for LitShares {
    fn is_read(&self, material: &Material) -> bool {
        !material.unlit
    }

    #[inline(never)]
    fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    ) {
        l.run(
            #[inline(always)]
            || {
                let mut seen = l.splat(1.0);
                if let Some(lamps) = &context.lamps {
                    let receiver = receiver(l, context, material, planes);
                    let sums = lamps.irradiance_of_all(l, context.lights, context.area_lights, &receiver);
                    let [open, all] = each!(sum in sums => Vec3::uniform(sum.dot(Vec3::splat(l, LUMINANCE))));
                    seen = share(l, open, all).x;
                }
                put(planes, layout::LIT_SHARE, [seen]);
            },
        )
    }
}

/// The surfaces in `planes`, as lamps light them.
#[inline(always)]
fn receiver<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
) -> Receiver<L> {
    let half = l.splat(context.rays.half_pixel());
    let [distance] = get(l, planes, layout::DISTANCE);
    Receiver {
        position: get_vector(l, planes, layout::LIT_POSITION),
        normal: get_vector(l, planes, layout::LIT_NORMAL),
        pixel: if context.rays.perspective { half * distance } else { half },
        two_sided: material.transmits(),
    }
}

/// Unit vectors to the middle of a part of a lamp, and its solid angle.
#[inline(always)]
fn seen_from<L: Lanes>(l: L, light: &AreaLight, part: &LampPart, position: V3<L>) -> (V3<L>, L::F) {
    let to = Vec3::splat(l, part.position) - position;
    let square = to.dot(to).at_least(1e-12);
    let towards = to * square.sqrt().recip();
    let facing = match light.shape {
        AreaShape::Rect { corners: [a, b, c, _], two_sided } => {
            // The outline runs up along the right edge first.
            let [a, b, c] = each!(corner in [a, b, c] => Vec3::splat(l, corner));
            let cosine = -towards.dot((b - a).cross(c - b).normalize());
            if two_sided { cosine.abs() } else { cosine.at_least(0.0) }
        }
        AreaShape::Tube { ends, .. } => {
            let [start, end] = each!(end in ends => Vec3::splat(l, end));
            let along = towards.dot((end - start).normalize());
            along.squared().one_minus().at_least(0.0).sqrt()
        }
    };
    (towards, facing * part.area / square)
}
