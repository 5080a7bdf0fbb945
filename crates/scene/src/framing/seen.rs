//! Visibility of the parts of a scene from anywhere, as far as it decides which part of the world a picture shows.

use crate::{AlphaMode, Bounds, Instance, Material, Mesh, MeshData, PrimitiveKind, Scene, Texture};

/// Largest height of a degenerate triangle, in lengths of its longest side: below, a triangle that fits into a picture
/// of 16384 pixels is a sixtieth of one wide, and corners on one line are as far off it in single precision.
const FLAT: f64 = 1e-6;

/// True if a triangle, line or point of a mesh can be seen. Its vertices exist.
#[inline]
fn can_be_seen(data: &MeshData, [a, b, c]: [u32; 3]) -> bool {
    let at = |v: u32| data.positions[v as usize].map(f64::from);
    match data.kind {
        PrimitiveKind::Points => true,
        PrimitiveKind::Lines => a != b && at(a) != at(b),
        PrimitiveKind::Triangles => {
            if a == b || b == c || c == a {
                return false;
            }
            let (a, b, c) = (at(a), at(b), at(c));
            let between = |p: [f64; 3], q: [f64; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let (u, v, w) = (between(a, b), between(a, c), between(b, c));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let longest = [u, v, w].map(square).into_iter().fold(0.0, |m, v| if v > m { v } else { m });
            square(normal) > FLAT * FLAT * longest * longest
        }
    }
}

/// Mask of the vertices that belong to something visible, if an outermost vertex does not: one that decides the box of
/// a mesh. `None` otherwise, and where nothing is visible.
pub(crate) fn vertices(data: &MeshData, bounds: &Bounds) -> Option<Vec<bool>> {
    if data.kind == PrimitiveKind::Points || bounds.is_empty() {
        return None;
    }
    // The sides of the box on which a position lies.
    let sides = |p: [f32; 3]| {
        (0..3).fold(0_u8, |sides, k| {
            let v = f64::from(p[k]);
            sides | u8::from(v == bounds.min[k]) << k | u8::from(v == bounds.max[k]) << (3 + k)
        })
    };
    let outermost: Vec<u8> = data.positions.iter().map(|&p| sides(p)).collect();
    let mut open = 0b11_1111_u8;
    for &[a, b, c] in &data.triangles {
        let touched = outermost[a as usize] | outermost[b as usize] | outermost[c as usize];
        if touched & open != 0 && can_be_seen(data, [a, b, c]) {
            open &= !touched;
            if open == 0 {
                return None;
            }
        }
    }
    let mut used = vec![true; data.positions.len()];
    keep_seen(data, &mut used);
    used.contains(&true).then_some(used)
}

/// Clears the mask of vertices that belong to nothing visible, unless that leaves none.
pub(crate) fn keep_seen(data: &MeshData, used: &mut [bool]) {
    let mut seen = vec![false; used.len()];
    for &triangle in data.triangles.iter().filter(|&&triangle| can_be_seen(data, triangle)) {
        for v in triangle {
            seen[v as usize] = true;
        }
    }
    if seen.contains(&true) {
        used.iter_mut().zip(seen).for_each(|(used, seen)| *used &= seen);
    }
}

impl Scene {
    /// The draws that can be seen; all of them if none can.
    pub(crate) fn seen_instances(&self) -> impl Iterator<Item = &Instance> {
        self.seen_draws().map(|(_, instance)| instance)
    }

    /// The same with their numbers among all instances.
    pub fn seen_draws(&self) -> impl Iterator<Item = (u32, &Instance)> {
        let invisible: Vec<bool> =
            self.materials.iter().map(|material| self.is_invisible(material)).collect();
        let can_be_seen = move |instance: &Instance| {
            let mesh = &self.meshes[instance.mesh.index()];
            let kept = keeps(instance, mesh.kind());
            let material = instance.material.index();
            kept && !invisible[material] && !hides(&self.materials[material], mesh)
        };
        let any = self.instances.iter().any(&can_be_seen);
        let draws = self.instances.iter().enumerate();
        draws
            .filter(move |(_, instance)| !any || can_be_seen(instance))
            .map(|(number, instance)| (number as u32, instance))
    }

    /// True if something of a draw has an area, a length or, if it is made of points, a place.
    pub fn is_solid(&self, instance: &Instance) -> bool {
        let mesh = &self.meshes[instance.mesh.index()];
        let has_places = mesh.kind() == PrimitiveKind::Points && mesh.primitive_count() > 0;
        keeps(instance, mesh.kind())
            && (has_places || mesh.triangles().iter().any(|&t| can_be_seen(mesh.data(), t)))
    }

    /// True if a material is fully transparent, whatever mesh it is on.
    pub fn is_invisible(&self, material: &Material) -> bool {
        let Some(least) = least_alpha(material) else { return false };
        let alpha = material.base_color[3];
        if alpha < least {
            return true;
        }
        let texture = material.base_color_texture.and_then(|t| self.textures.get(t.texture.index()));
        let passes = |texel: u8| f32::from(texel) * (1.0 / 255.0) * alpha >= least;
        // One that cannot be read hides nothing.
        let is_lost = |texture: &Texture| texture.form().is_some_and(|form| form.image().is_lost());
        texture.is_some_and(|texture| !texture.has_alpha(passes) && !is_lost(texture))
    }
}

/// True if the transform does not squeeze the primitives of a mesh to nothing.
fn keeps(instance: &Instance, kind: PrimitiveKind) -> bool {
    match kind {
        PrimitiveKind::Triangles => instance.transform.keeps_surfaces(),
        PrimitiveKind::Lines => instance.transform.keeps_lines(),
        PrimitiveKind::Points => true,
    }
}

/// True if the vertex colours of a mesh are fully transparent.
fn hides(material: &Material, mesh: &Mesh) -> bool {
    let Some(least) = least_alpha(material) else { return false };
    let colors = mesh.colors();
    !colors.is_empty() && colors.iter().all(|color| color[3] * material.base_color[3] < least)
}

/// The least alpha with which something of a material is seen; `None` where alpha counts for nothing, or other things let
/// light through as well.
fn least_alpha(material: &Material) -> Option<f32> {
    match material.alpha_mode {
        _ if material.is_transmissive() => None,
        AlphaMode::Opaque => None,
        AlphaMode::Blend => Some(f32::MIN_POSITIVE),
        AlphaMode::Mask { cutoff } => Some(cutoff),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Transform;

    /// A cube's worth of corners, and one far away.
    fn positions() -> Vec<[f32; 3]> {
        let mut positions: Vec<[f32; 3]> =
            (0..8_u32).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|v| v as f32)).collect();
        positions.extend([[5000.0, 0.0, 0.0], [2500.0, 0.0, 0.0], [5000.0, 1e-4, 0.0]]);
        positions
    }

    fn bounds(kind: PrimitiveKind, extra: [u32; 3]) -> [f64; 3] {
        let mut triangles = vec![[0, 1, 2], [5, 6, 7], [3, 4, 7]];
        triangles.push(extra);
        if kind == PrimitiveKind::Lines {
            triangles.iter_mut().for_each(|t| t[2] = t[1]);
        }
        let data = MeshData { positions: positions(), triangles, kind, ..MeshData::default() };
        Mesh::new(data).unwrap().bounds().max
    }

    #[test]
    fn what_has_no_area_does_not_count() {
        for invisible in [[8, 8, 8], [0, 8, 8], [0, 9, 8], [0, 8, 10]] {
            assert_eq!(bounds(PrimitiveKind::Triangles, invisible), [1.0; 3], "{invisible:?}");
        }
        assert_eq!(bounds(PrimitiveKind::Triangles, [0, 8, 3]), [5000.0, 1.0, 1.0]);
        assert_eq!(bounds(PrimitiveKind::Lines, [8, 8, 8]), [1.0; 3]);
        assert_eq!(bounds(PrimitiveKind::Lines, [0, 8, 8]), [5000.0, 1.0, 1.0]);
        assert_eq!(bounds(PrimitiveKind::Points, [8, 8, 8]), [5000.0, 1.0, 1.0]);
        // Of nothing else there is a box all the same.
        let data = MeshData { positions: positions(), triangles: vec![[8; 3]], ..MeshData::default() };
        assert_eq!(Mesh::new(data).unwrap().bounds().max[0], 5000.0);
    }

    #[test]
    fn what_is_squeezed_or_transparent_does_not_count() {
        let data = MeshData { positions: positions(), triangles: vec![[0, 1, 7]], ..MeshData::default() };
        let mesh = Mesh::new(data).unwrap();
        let far =
            |scale: [f64; 3]| Transform::from_parts([5000.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], scale).unwrap();
        let clear = Material { alpha_mode: AlphaMode::Blend, base_color: [0.0; 4], ..Material::default() };
        let cut = Material {
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            base_color: [0.4; 4],
            ..Material::default()
        };
        let bounds = |transform: Transform, material: Material| {
            let mut scene = Scene::new();
            let id = scene.add_mesh(mesh.clone()).unwrap();
            let plain = scene.add_material(Material::default()).unwrap();
            let other = scene.add_material(material).unwrap();
            for (transform, material) in [(Transform::IDENTITY, plain), (transform, other)] {
                scene.add_instance(Instance { mesh: id, material, transform, object: 0 }).unwrap();
            }
            scene.bounds().max[0]
        };
        assert_eq!(bounds(far([0.0; 3]), Material::default()), 1.0);
        assert_eq!(bounds(far([1.0, 0.0, 0.0]), Material::default()), 1.0);
        assert_eq!(bounds(far([1.0, 1.0, 0.0]), Material::default()), 5001.0);
        assert_eq!(bounds(far([1.0; 3]), clear), 1.0);
        assert_eq!(bounds(far([1.0; 3]), cut), 1.0);
        let coat = Material { alpha_mode: AlphaMode::Blend, base_color: [0.1; 4], ..Material::default() };
        assert_eq!(bounds(far([1.0; 3]), coat), 5001.0);
    }
}
