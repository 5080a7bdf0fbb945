//! Morph targets: displacements of vertices that are added by weight (section 3.7.2.2 of the specification).

use super::attributes::Attributes;
use super::deform::Stored;
use super::flat::spread;
use super::list::Index;
use super::model::Kind;
use super::shape::zero_not_finite;
use crate::LoadError;

/// A morph target of a primitive that may be drawn with a weight other than 0.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Target {
    /// Number of the target in its primitive.
    number: u32,
    position: Option<Index>,
    normal: Option<Index>,
    tangent: Option<Index>,
    uvs: [Option<Index>; 2],
    color: Option<Index>,
}

impl Target {
    /// Displacements of the attributes that the base mesh has; others would have nothing to displace.
    pub(super) fn new(number: usize, given: &Attributes, base: &Attributes, uv_sets: [u32; 2]) -> Self {
        let with = |displacement: Option<Index>, base: Option<Index>| base.and(displacement);
        Self {
            number: number as u32,
            position: given.position,
            normal: with(given.normal, base.normal),
            tangent: with(given.tangent, base.normal),
            uvs: uv_sets.map(|set| with(given.uv(set), base.uv(set))),
            color: with(given.color, base.color),
        }
    }

    /// Number of the target in its primitive.
    pub(super) fn number(&self) -> usize {
        self.number as usize
    }

    /// The accessors that it reads.
    pub(super) fn accessors(&self) -> impl Iterator<Item = Index> {
        [self.position, self.normal, self.tangent, self.uvs[0], self.uvs[1], self.color].into_iter().flatten()
    }

    /// Bytes of a displaced vertex.
    pub(super) fn bytes(&self) -> u64 {
        [
            (self.position, 12),
            (self.normal, 12),
            (self.tangent, 12),
            (self.uvs[0], 8),
            (self.uvs[1], 8),
            (self.color, 16),
        ]
        .into_iter()
        .map(|(present, bytes)| if present.is_some() { bytes } else { 0 })
        .sum()
    }
}

/// The displacements of one target, by vertex; empty where it has none.
#[derive(Debug, Default)]
pub(super) struct Displacements {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<[f32; 3]>,
    pub uvs: [Vec<[f32; 2]>; 2],
    pub colors: Vec<[f32; 4]>,
}

impl Displacements {
    /// Reads the displacements of a target.
    ///
    /// # Errors
    /// [`LoadError`] naming the attribute.
    pub(super) fn read(target: &Target, from: &Stored<'_>) -> Result<Self, LoadError> {
        let mut out = Self::default();
        let name = |attribute: &str| format!("target {}, {attribute}", target.number);
        if let Some(index) = target.position {
            out.positions = from.read(index, &name("POSITION"), Kind::Vec3)?;
        }
        if let Some(index) = target.normal {
            out.normals = from.read(index, &name("NORMAL"), Kind::Vec3)?;
        }
        if let Some(index) = target.tangent {
            out.tangents = from.read(index, &name("TANGENT"), Kind::Vec3)?;
        }
        let sets = ["TEXCOORD_0", "TEXCOORD_1"].into_iter().zip(target.uvs).zip(&mut out.uvs);
        for ((attribute, index), uvs) in sets {
            if let Some(index) = index {
                *uvs = from.read(index, &name(attribute), Kind::Vec2)?;
            }
        }
        if let Some(index) = target.color {
            out.colors = from.read_colors(index, &name("COLOR_0"))?;
        }
        Ok(out)
    }

    /// Replaces numbers that are not finite by 0; true if there were any.
    pub(super) fn repair(&mut self) -> bool {
        let [uv0, uv1] = &mut self.uvs;
        let mut found = false;
        for numbers in [
            self.positions.as_flattened_mut(),
            self.normals.as_flattened_mut(),
            self.tangents.as_flattened_mut(),
            uv0.as_flattened_mut(),
            uv1.as_flattened_mut(),
            self.colors.as_flattened_mut(),
        ] {
            found |= zero_not_finite(numbers);
        }
        found
    }

    /// Gives vertex `k` the displacements of what was vertex `origins[k]`.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] if one of those is not there.
    pub(super) fn spread(&mut self, origins: &[u32]) -> Result<(), LoadError> {
        spread(&mut self.positions, origins)?;
        spread(&mut self.normals, origins)?;
        spread(&mut self.tangents, origins)?;
        for uvs in &mut self.uvs {
            spread(uvs, origins)?;
        }
        spread(&mut self.colors, origins)
    }
}

/// `out += weight * displacement`, number by number; nothing where there is no displacement.
pub(super) fn add<const N: usize>(
    out: &mut [[f32; N]],
    displacements: &[[f32; N]],
    first: usize,
    weight: f32,
) {
    let displacements = displacements.get(first..).unwrap_or_default();
    for (out, displacement) in out.as_flattened_mut().iter_mut().zip(displacements.as_flattened()) {
        *out += weight * displacement;
    }
}

/// The same for tangents, whose fourth number stays.
pub(super) fn add_tangents(out: &mut [[f32; 4]], displacements: &[[f32; 3]], first: usize, weight: f32) {
    let displacements = displacements.get(first..).unwrap_or_default();
    for (out, displacement) in out.iter_mut().zip(displacements) {
        for (out, displacement) in out.iter_mut().zip(displacement) {
            *out += weight * displacement;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_added_by_weight() {
        let mut positions = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let displacements = [[9.0; 3], [1.0, 0.0, -2.0], [0.0, 4.0, 8.0]];
        add(&mut positions, &displacements, 1, 0.5);
        add(&mut positions, &[], 1, 0.5);
        assert_eq!(positions, [[1.5, 2.0, 2.0], [4.0, 7.0, 10.0]]);
        let mut tangents = [[1.0, 0.0, 0.0, -1.0]];
        add_tangents(&mut tangents, &displacements, 2, 0.25);
        assert_eq!(tangents, [[1.0, 1.0, 2.0, -1.0]]);
    }
}
