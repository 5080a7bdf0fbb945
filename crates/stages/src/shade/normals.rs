//! Normals of sixteen fragments: of their vertices, of maps, and how they change from pixel to pixel.
//!
//! *Normals that face away.* An interpolated or mapped normal can point away from the viewer although the surface is seen (N.V
//! < 0). It is bent to the silhouette: its part along the view is taken out, so that N.V = 0. Reflections then leave at grazing
//! angles, without black rims. (Reflections into the surface: see `incident.rs`.)

use super::ShadeContext;
use crate::gbuffer::{Batch, Location};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Material, Mesh, NormalTexture};

/// The tangent space of a batch.
pub(super) struct NormalFrame<L: Lanes> {
    /// Unit vertex normal, on the side of the viewer's face.
    pub(super) normal: V3<L>,
    /// Interpolated, not normalised (MikkTSpace): tangent, bitangent, normal.
    basis: Option<[V3<L>; 3]>,
}

impl<L: Lanes> NormalFrame<L> {
    /// The tangent space at a location on triangles, of normals of their vertices.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        batch: &Batch,
        (location, vertices): (&Location<L>, &[[L::F; 3]; 3]),
        view: V3<L>,
    ) -> Self {
        let draws = context.draws;
        let smooth = Vec3::from_array(location.interpolate(vertices));
        let zero = smooth.dot(smooth).eq(l.zero());
        let object = if zero.any() {
            let flat = geometric_normal(l, context, batch);
            Vec3::select(zero, flat, smooth)
        } else {
            smooth
        };
        let world = batch.vertices.transform(l, draws, |d| d.normal_matrix, object);
        // Backs of double-sided surfaces turn the whole tangent space around.
        let side = l.mask(batch.back_facing).select(l.splat(-1.0), l.splat(1.0));
        let unit = normalize_or(l, world, view) * side;
        if !material.needs_tangents() {
            return Self { normal: unit, basis: None };
        }
        let tangents = batch.vertices.attribute(l, draws, [0.0; 4], Mesh::tangents);
        let [x, y, z, sign] = location.interpolate(&tangents);
        let tangent = batch.vertices.transform(l, draws, |d| d.tangent_matrix, Vec3::new(x, y, z));
        let mirror = batch.vertices.number(l, draws, |d| d.handedness);
        let bitangent = world.cross(tangent) * (sign * mirror);
        // No texture coordinates, or degenerate ones: any fixed basis around the normal.
        let lost = tangent.dot(tangent).eq(l.zero()) | bitangent.dot(bitangent).eq(l.zero());
        let (tangent, bitangent) = if lost.any() {
            let [t, b] = unit.any_basis(l);
            let t = t * side;
            let b = b * side;
            (Vec3::select(lost, t, tangent), Vec3::select(lost, b, bitangent))
        } else {
            (tangent, bitangent)
        };
        let basis = [tangent * side, bitangent * side, world * side];
        Self { normal: unit, basis: Some(basis) }
    }

    /// The normal of the clear coat, that of the base being known.
    #[inline(always)]
    pub(super) fn coat_normal(
        &self,
        l: L,
        material: &Material,
        mapped: &[L::F; 4],
        normal: V3<L>,
        view: V3<L>,
    ) -> V3<L> {
        if material.coat <= 0.0 {
            face_viewer(l, self.normal, view)
        } else if material.coat_normal_texture == material.normal_texture {
            normal
        } else {
            self.shading_normal(l, material.coat_normal_texture.as_ref(), mapped, view)
        }
    }

    /// Unit tangent and bitangent about a shading normal, turned by the direction of the anisotropy. Some basis where the
    /// surface has no tangents.
    #[inline(always)]
    pub(super) fn tangents(&self, l: L, direction: [L::F; 2], normal: V3<L>) -> (V3<L>, V3<L>) {
        let Some([tangent, bitangent, _]) = &self.basis else {
            return normal.any_basis(l).into();
        };
        let flat = *tangent - normal * tangent.dot(normal);
        let [any, _] = normal.any_basis(l);
        let t = normalize_or(l, flat, any);
        let b = normal.cross(t);
        // The side on which texture coordinates put the bitangent.
        let mirrored = b.dot(*bitangent).lt(l.zero());
        let b = Vec3::select(mirrored, -b, b);
        let [x, y] = direction;
        let turned = t * x + b * y;
        let across = b * x - t * y;
        (turned, across)
    }

    /// The normal after a texel of a normal map, unit length, facing the viewer.
    #[inline(always)]
    pub(super) fn shading_normal(
        &self,
        l: L,
        map: Option<&NormalTexture>,
        texel: &[L::F; 4],
        view: V3<L>,
    ) -> V3<L> {
        match map {
            Some(map) => face_viewer(l, self.mapped_normal(l, map, texel), view),
            None => face_viewer(l, self.normal, view),
        }
    }

    /// The vector of a texel of a map of normals, unit length.
    #[inline(always)]
    pub(super) fn mapped_normal(&self, l: L, map: &NormalTexture, texel: &[L::F; 4]) -> V3<L> {
        let Some([tangent, bitangent, normal]) = &self.basis else {
            return self.normal;
        };
        let x = (texel[0] * 2.0 - 1.0) * map.scale;
        let y = (texel[1] * 2.0 - 1.0) * map.scale;
        let z = texel[2] * 2.0 - 1.0;
        let mapped = *tangent * x + *bitangent * y + *normal * z;
        normalize_or(l, mapped, self.normal)
    }
}

/// Takes the part of a unit normal out that points away from the viewer.
#[inline(always)]
pub(super) fn face_viewer<L: Lanes>(l: L, normal: V3<L>, view: V3<L>) -> V3<L> {
    let cosine = normal.dot(view);
    let away = cosine.lt(l.zero());
    if !away.any() {
        return normal;
    }
    let bent = normal + view * -cosine;
    let bent = normalize_or(l, bent, view);
    Vec3::select(away, bent, normal)
}

/// The unit vertex normal in world space and its change per pixel to the right and per pixel down, at a location on triangles, of
/// normals of their vertices; 0 where the mesh has no normals. Which side is seen does not matter to its size.
#[inline(always)]
pub(super) fn normal_change<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    batch: &Batch,
    (location, vertices): (&Location<L>, &[[L::F; 3]; 3]),
) -> (V3<L>, [V3<L>; 2]) {
    let smooth = Vec3::from_array(location.interpolate(vertices));
    let normal = batch.vertices.transform(l, context.draws, |d| d.normal_matrix, smooth);
    let square = normal.dot(normal);
    let none = !square.gt(l.zero());
    let inverse = none.select(l.splat(1.0), square).sqrt().recip();
    let unit = normal * inverse;
    let change = each!(derivative in location.derivatives(vertices) => {
        let derivative = Vec3::from_array(derivative);
        let change = batch.vertices.transform(l, context.draws, |d| d.normal_matrix, derivative) * inverse;
        // What lengthens the vector does not turn it.
        let across = change - unit * unit.dot(change);
        Vec3::select(none, Vec3::zero(l), across)
    });
    (unit, change)
}

/// The normal of each lane's triangle in object space, on its front; zero for triangles without area.
#[inline(always)]
pub(super) fn geometric_normal<L: Lanes>(l: L, context: &ShadeContext<'_>, batch: &Batch) -> V3<L> {
    let corners = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::positions);
    let [a, b, c]: [V3<L>; 3] = each!(corner in corners => Vec3::from_array(corner));
    let (e1, e2) = (b - a, c - a);
    // Scaled to the longest component, so that neither huge nor tiny triangles leave the range of f32.
    let mut largest = l.zero();
    for v in [e1.to_array(), e2.to_array()].as_flattened() {
        largest = v.abs().max(largest);
    }
    let factor = largest.gt(l.zero()).select(largest, l.splat(1.0)).recip();
    let sign = l.mask(batch.reversed).select(l.splat(-1.0), l.splat(1.0));
    (e1 * factor).cross(e2 * factor) * sign
}

/// A vector at unit length, or `fallback` where it is zero.
#[inline(always)]
pub(super) fn normalize_or<L: Lanes>(l: L, v: V3<L>, fallback: V3<L>) -> V3<L> {
    let square = v.dot(v);
    let zero = !square.gt(l.zero());
    let inverse = zero.select(l.splat(1.0), square).sqrt().recip();
    Vec3::select(zero, fallback, v * inverse)
}
