//! Light that is reflected within a body on its way through.
//!
//! Maps of tints know the straight way alone. Between neighbouring sides of a cube of glass no light goes that way: from an index
//! of 1.41 on, all that enters by one of them is reflected by the other, goes on through the whole thickness to the side
//! opposite that by which it came, and leaves it in a mirrored direction. So the reflected share is absorbed along that
//! thickness, and half of it counts as lost: of the ways through two neighbouring sides, as many end on the side of the light as
//! on that of the shadow. What is gathered elsewhere for it is not, like all caustics.
//!
//! The share is Schlick's approximation at the angle by which light would leave, beyond what a crossing of the map counts for
//! its straight way. Both sides have to be known: the body shows one front and one back in a texel, and the back is flat; of
//! curved bodies light leaves by another normal than the straight way does (a ball reflects none of it wholly).

use super::tinted::Tinted;
use overcoat_core::each;
use overcoat_core::math::triple::dot;
use overcoat_scene::{Material, Mesh};

/// Part of the reflected light that leaves a body on the side by which it came.
const RETURNED: f32 = 0.5;

/// A side of a volume that light crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unit vector towards the light.
    pub towards: [f32; 3],
    /// Cosine between both.
    pub facing: f32,
    /// Depth as a length that grows towards the light.
    pub along: f32,
    /// True if the surface is not curved.
    pub is_flat: bool,
}

/// The sides of one instance's volume that a texel sees: the last of its fronts and of its backs, and their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    filter: usize,
    fronts: (Side, u8),
    backs: (Side, u8),
}

/// Light that is reflected within a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reflected {
    /// Factor of the transmittance.
    pub kept: f32,
    /// Sum of extinction times the length of the way beyond the straight one.
    pub path: [f32; 3],
}

impl Body {
    /// Nothing crossed.
    pub(super) const NONE: Self = {
        let side = Side { normal: [0.0; 3], towards: [0.0; 3], facing: 0.0, along: 0.0, is_flat: false };
        Self { filter: usize::MAX, fronts: (side, 0), backs: (side, 0) }
    };

    /// Adds a side of the volume of a filter. The body before it is complete if it is another's: its light is returned then.
    pub(super) fn cross(&mut self, tinted: &Tinted, number: usize, side: Side) -> Option<Reflected> {
        let complete = (self.filter != number).then(|| self.reflected(tinted)).flatten();
        if self.filter != number {
            *self = Self { filter: number, ..Self::NONE };
        }
        let sides = if side.facing > 0.0 { &mut self.fronts } else { &mut self.backs };
        *sides = (side, sides.1.saturating_add(1));
        complete
    }

    /// Light that is reflected within the body; `None` if it goes straight through, or nobody knows.
    pub(super) fn reflected(&self, tinted: &Tinted) -> Option<Reflected> {
        let (Body { fronts: (front, 1), backs: (back, 1), .. }, true) = (self, self.backs.0.is_flat) else {
            return None;
        };
        let filter = tinted.filters.get(self.filter)?;
        let share = reflected_share(front, back, filter.ior);
        let beyond = filter.thickness - (front.along - back.along);
        let length = if beyond > 0.0 { beyond * share } else { 0.0 };
        let extinction = filter.extinction.unwrap_or_default();
        (share > 0.0)
            .then(|| Reflected { kept: 1.0 - RETURNED * share, path: extinction.map(|e| e * length) })
    }
}

/// Share of the light that the back reflects beyond what leaves it on the straight way, 0 to 1.
fn reflected_share(front: &Side, back: &Side, ior: f32) -> f32 {
    let eta = 1.0 / ior;
    // GLSL's refract at the front.
    let inside = (1.0 - eta * eta * (1.0 - front.facing * front.facing)).sqrt();
    let bend = eta * front.facing - inside;
    let way: [f32; 3] = each!(k => front.normal[k] * bend - front.towards[k] * eta);
    let cosine = dot(way, back.normal);
    let square = 1.0 - ior * ior * (1.0 - cosine * cosine);
    // Also of what is no number, and of a way that does not lead to the back: total reflection.
    let leaving = if cosine > 0.0 && square > 0.0 { square.sqrt() } else { 0.0 };
    let [reflected, counted] = [leaving, back.facing.abs()].map(|cosine| {
        let grazing = if cosine < 1.0 { 1.0 - cosine } else { 0.0 };
        let square = grazing * grazing;
        square * square * grazing
    });
    if reflected > counted { (reflected - counted) / (1.0 - counted) } else { 0.0 }
}

/// For each triangle of a mesh, true if its normals are those of its plane; empty where the volume beneath does not bend
/// light.
pub(super) fn facets(mesh: &Mesh, material: &Material) -> Vec<bool> {
    let bends = material.is_transmissive() && material.lobes.transmission.has_volume() && material.ior > 1.0;
    if !bends {
        return Vec::new();
    }
    let (positions, normals) = (mesh.positions(), mesh.normals());
    let is_flat = |corners: &[u32; 3]| {
        if normals.is_empty() {
            return true;
        }
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let [u, v]: [[f32; 3]; 2] = [b, c].map(|to| each!(k => to[k] - a[k]));
        let plane = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        corners.iter().all(|v| {
            let normal = normals[*v as usize];
            let cosine = dot(plane, normal);
            cosine * cosine > FLAT * dot(plane, plane) * dot(normal, normal)
        })
    };
    mesh.triangles().iter().map(is_flat).collect()
}

/// Least squared cosine between the normals of a flat surface: an angle of 2.5 degrees.
const FLAT: f32 = 0.998;
