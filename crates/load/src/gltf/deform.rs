//! Meshes whose vertices move: morph targets first, then the skin.
//!
//! Vertices are moved in blocks of a fixed number, each by one job, so that the bits do not depend on threads.

use super::FORMAT;
use super::accessor::{self, Component, Pick};
use super::buffers::Buffers;
use super::draco::Decoded;
use super::flat::{geometric_normal, spread};
use super::list::Index;
use super::model::{self, Kind, Root};
use super::morph::{self, Displacements};
use super::skin::{self, Influences, Matrix};
use crate::LoadError;
use crate::warnings::Warnings;
use overcoat_core::jobs::Jobs;
use overcoat_scene::{Mesh, MeshData, SceneError};
use std::collections::BTreeSet;

/// Vertices of a job.
const BLOCK: usize = 4096;

/// Deformation of a mesh by all nodes of a scene that use it, united.
#[derive(Debug, Default)]
pub(super) struct Usage {
    /// One of them has a skin.
    pub skinned: bool,
    /// Morph targets that may have a weight other than 0.
    pub targets: BTreeSet<usize>,
}

/// Sources of a primitive's deformation: skin and morph targets. Empty if it does not deform.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Source {
    /// JOINTS_n and WEIGHTS_n.
    sets: Vec<(Index, Index)>,
    targets: Vec<morph::Target>,
}

impl Source {
    /// Sources of the deformation of a primitive whose mesh is used as `usage` says.
    pub(super) fn new(
        given: &model::Primitive,
        usage: &Usage,
        uv_sets: [u32; 2],
        name: &dyn Fn() -> String,
        warnings: &mut Warnings,
    ) -> Self {
        let mut out = Self::default();
        if usage.skinned {
            for &(set, joints) in &given.attributes.joints {
                match given.attributes.weights.iter().find(|(other, _)| *other == set) {
                    Some(&(_, weights)) => out.sets.push((joints, weights)),
                    None => warnings.add(|| format!("{}: JOINTS_{set} without weights, left out", name())),
                }
            }
            if out.sets.is_empty() {
                warnings.add(|| format!("{} has no joints and does not follow its skin", name()));
            }
        }
        for &number in &usage.targets {
            let base = &given.attributes;
            let target = given.targets.get(number);
            let target = target.map(|target| morph::Target::new(number, target, base, uv_sets));
            out.targets.extend(target.filter(|target| target.bytes() > 0));
        }
        out
    }

    pub(super) fn is_still(&self) -> bool {
        self.sets.is_empty() && self.targets.is_empty()
    }

    pub(super) fn has_joints(&self) -> bool {
        !self.sets.is_empty()
    }

    pub(super) fn has_targets(&self) -> bool {
        !self.targets.is_empty()
    }

    /// All accessors.
    pub(super) fn accessors(&self) -> impl Iterator<Item = Index> {
        let sets = self.sets.iter().flat_map(|&(joints, weights)| [joints, weights]);
        sets.chain(self.targets.iter().flat_map(morph::Target::accessors))
    }

    /// Bytes of a vertex.
    pub(super) fn bytes(&self) -> u64 {
        // As read, and as kept.
        let sets = (self.sets.len() as u64).saturating_mul(16 + 8 + 16);
        self.targets.iter().map(morph::Target::bytes).fold(sets, u64::saturating_add)
    }

    /// Cost of a vertex, in vertices that do not deform: each morph target, and each four joints beyond the first, is
    /// as much work as another vertex.
    pub(super) fn work(&self) -> u64 {
        (self.targets.len() as u64).saturating_add((self.sets.len() as u64).max(1))
    }
}

/// The vertices of a primitive that are read.
pub(super) struct Stored<'a> {
    pub root: &'a Root,
    pub buffers: &'a Buffers<'a>,
    /// Draco data, and what accessors are called in it.
    pub compressed: Option<(&'a Decoded, Vec<(Index, Index)>)>,
    /// Number of elements that each attribute must have.
    pub vertices: u64,
    pub pick: &'a Pick,
}

impl Stored<'_> {
    fn resolve(&self, index: Index, what: &str, kinds: &[Kind]) -> Result<accessor::Elements<'_>, LoadError> {
        let id = self.compressed.as_ref().and_then(|(decoded, names)| {
            Some((decoded, names.iter().find(|(accessor, _)| *accessor == index)?.1))
        });
        let elements = match id {
            Some((decoded, id)) => decoded
                .elements(id, accessor::get(self.root, index)?.normalized)
                .ok_or_else(|| LoadError::malformed(FORMAT, format!("{what} is not in its Draco data")))?,
            None => accessor::resolve(self.root, self.buffers, index)?,
        };
        if !kinds.contains(&elements.kind) {
            let message = format!("{what}: accessor {index} has elements of the wrong type");
            return Err(LoadError::malformed(FORMAT, message));
        }
        if elements.count as u64 != self.vertices {
            let message = format!("{what} has {} elements for {} vertices", elements.count, self.vertices);
            return Err(LoadError::malformed(FORMAT, message));
        }
        Ok(elements)
    }

    /// The picked elements of an accessor, which must be of this kind.
    pub(super) fn read<const N: usize>(
        &self,
        index: Index,
        what: &str,
        kind: Kind,
    ) -> Result<Vec<[f32; N]>, LoadError> {
        self.resolve(index, what, &[kind])?.floats(self.pick)
    }

    /// The picked displacements of colours; their fourth number is 0 where there are three.
    pub(super) fn read_colors(&self, index: Index, what: &str) -> Result<Vec<[f32; 4]>, LoadError> {
        let mut elements = self.resolve(index, what, &[Kind::Vec3, Kind::Vec4])?;
        elements.normalized = true;
        Ok(match elements.kind {
            Kind::Vec4 => elements.floats(self.pick)?,
            _ => elements.floats(self.pick)?.into_iter().map(|[r, g, b]| [r, g, b, 0.0]).collect(),
        })
    }

    /// One set of joints and weights, the weights as they are in the file.
    fn read_influences(&self, joints: Index, weights: Index) -> Result<Influences, LoadError> {
        let elements = self.resolve(joints, "JOINTS", &[Kind::Vec4])?;
        if !matches!(elements.component, Component::U8 | Component::U16) {
            return Err(LoadError::malformed(
                FORMAT,
                format!("JOINTS: accessor {joints} does not hold indices"),
            ));
        }
        let mut elements = elements;
        elements.normalized = false;
        // Whole numbers up to 65535.
        let joints =
            elements.floats::<4>(self.pick)?.into_iter().map(|four| four.map(|v| v as u16)).collect();
        let mut elements = self.resolve(weights, "WEIGHTS", &[Kind::Vec4])?;
        // The specification knows normalised integers only.
        elements.normalized = true;
        Ok(Influences { joints, weights: elements.floats(self.pick)? })
    }
}

/// Data of a primitive's deformation, read from the accessors.
pub(super) struct Deform {
    sets: Vec<Influences>,
    /// Largest joint that moves a vertex.
    last_joint: u16,
    /// With the number in the primitive.
    targets: Vec<(usize, Displacements)>,
    /// Normals are those of the triangles, which share no vertices.
    flat: bool,
}

impl Deform {
    /// Reads what the picked vertices of a primitive move by. `origins`: for each vertex of the mesh the picked one that
    /// it was made of, unless they are the same.
    ///
    /// # Errors
    /// [`LoadError`] naming the attribute.
    pub(super) fn read(
        source: &Source,
        from: &Stored<'_>,
        origins: Option<&[u32]>,
        flat: bool,
        repaired: &mut dyn FnMut(&str),
    ) -> Result<Self, LoadError> {
        let mut sets = Vec::with_capacity(source.sets.len());
        for &(joints, weights) in &source.sets {
            sets.push(from.read_influences(joints, weights)?);
        }
        let last_joint = normalize(&mut sets, repaired);
        let mut targets = Vec::with_capacity(source.targets.len());
        let mut broken = false;
        for target in &source.targets {
            let mut displacements = Displacements::read(target, from)?;
            broken |= displacements.repair();
            if let Some(origins) = origins {
                displacements.spread(origins)?;
            }
            targets.push((target.number(), displacements));
        }
        if broken {
            repaired("displacements of morph targets that are not finite are taken as 0");
        }
        if let Some(origins) = origins {
            for set in &mut sets {
                spread(&mut set.joints, origins)?;
                spread(&mut set.weights, origins)?;
            }
        }
        Ok(Self { sets, last_joint, targets, flat })
    }

    pub(super) fn has_joints(&self) -> bool {
        !self.sets.is_empty()
    }

    /// Largest joint that moves a vertex.
    pub(super) fn last_joint(&self) -> usize {
        self.last_joint.into()
    }

    /// The numbers of its morph targets in the primitive.
    pub(super) fn targets(&self) -> impl Iterator<Item = usize> {
        self.targets.iter().map(|(number, _)| *number)
    }
}

/// Makes the weights of each vertex add up to 1, and gives the largest joint with a weight. Joints without a weight become
/// joint 0, since writers leave anything there.
fn normalize(sets: &mut [Influences], repaired: &mut dyn FnMut(&str)) -> u16 {
    let mut sums = vec![0.0_f32; sets.first().map_or(0, |set| set.weights.len())];
    let (mut broken, mut lost, mut last) = (false, false, 0);
    for set in sets.iter_mut() {
        for (weights, sum) in set.weights.iter_mut().zip(&mut sums) {
            for weight in weights {
                if !(*weight >= 0.0 && *weight < f32::INFINITY) {
                    broken = true;
                    *weight = 0.0;
                }
                *sum += *weight;
            }
        }
    }
    let usable = |sum: f32| sum > f32::MIN_POSITIVE && sum < f32::INFINITY;
    for set in sets.iter_mut() {
        for ((weights, joints), &sum) in set.weights.iter_mut().zip(&mut set.joints).zip(&sums) {
            for (weight, joint) in weights.iter_mut().zip(joints) {
                *weight = if usable(sum) { *weight / sum } else { 0.0 };
                if *weight == 0.0 {
                    *joint = 0;
                }
                last = if *joint > last { *joint } else { last };
            }
        }
    }
    for (weights, &sum) in sets.iter_mut().take(1).flat_map(|set| &mut set.weights).zip(&sums) {
        if !usable(sum) {
            lost = true;
            weights[0] = 1.0;
        }
    }
    if broken {
        repaired("weights of joints that are negative or not finite are taken as 0");
    }
    if lost {
        repaired("vertices without weights follow the first joint of their skin");
    }
    last
}

/// A mesh in a pose.
pub(super) struct Wanted<'a> {
    pub base: &'a MeshData,
    pub deform: &'a Deform,
    /// In the order of [`Deform::targets`].
    pub weights: Vec<f32>,
    /// Joint matrices of the skin, if there is one.
    pub matrices: Option<&'a [Matrix]>,
}

/// A run of vertices of one mesh.
struct Block<'a> {
    wanted: &'a Wanted<'a>,
    first: usize,
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    tangents: &'a mut [[f32; 4]],
    uvs: [&'a mut [[f32; 2]]; 2],
    colors: &'a mut [[f32; 4]],
    orientation: &'a mut [f32],
}

/// A mesh that is being made.
struct Posed<'a> {
    wanted: &'a Wanted<'a>,
    data: MeshData,
    /// The determinant of each vertex's map; empty without a skin.
    orientation: Vec<f32>,
    mesh: Option<Result<Mesh, SceneError>>,
}

/// Makes meshes in their poses.
pub(super) fn pose(wanted: &[Wanted<'_>], jobs: &Jobs) -> Vec<Result<Mesh, SceneError>> {
    let mut posed = jobs.map_each(wanted, |wanted| {
        let Wanted { base, matrices, .. } = wanted;
        let orientation = matrices.map_or(Vec::new(), |_| vec![0.0; base.positions.len()]);
        Posed { wanted, data: (*base).clone(), orientation, mesh: None }
    });
    let mut blocks = Vec::new();
    for Posed { wanted, data, orientation, .. } in &mut posed {
        let count = data.positions.len();
        let [uv0, uv1] = &mut data.uvs;
        let mut rest = (
            data.positions.as_mut_slice(),
            data.normals.as_mut_slice(),
            data.tangents.as_mut_slice(),
            [uv0.as_mut_slice(), uv1.as_mut_slice()],
            data.colors.as_mut_slice(),
            orientation.as_mut_slice(),
        );
        for first in (0..count).step_by(BLOCK) {
            let [uv0, uv1] = &mut rest.3;
            blocks.push(Block {
                wanted,
                first,
                positions: front(&mut rest.0),
                normals: front(&mut rest.1),
                tangents: front(&mut rest.2),
                uvs: [front(uv0), front(uv1)],
                colors: front(&mut rest.4),
                orientation: front(&mut rest.5),
            });
        }
    }
    jobs.for_each_mut(&mut blocks, |_, block| block.apply());
    drop(blocks);
    jobs.for_each_mut(&mut posed, |_, posed| posed.finish());
    posed.into_iter().filter_map(|posed| posed.mesh).collect()
}

/// Takes up to a block from the front of a list that may be empty.
fn front<'a, T>(list: &mut &'a mut [T]) -> &'a mut [T] {
    let whole = std::mem::take(list);
    let (own, rest) = whole.split_at_mut(whole.len().min(BLOCK));
    *list = rest;
    own
}

impl Block<'_> {
    fn apply(&mut self) {
        let Wanted { deform, weights, matrices, .. } = self.wanted;
        let first = self.first;
        let (mut bent, mut tinted) = (false, false);
        for ((_, target), &weight) in deform.targets.iter().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            morph::add(self.positions, &target.positions, first, weight);
            morph::add(self.normals, &target.normals, first, weight);
            morph::add_tangents(self.tangents, &target.tangents, first, weight);
            for (uvs, displacements) in self.uvs.iter_mut().zip(&target.uvs) {
                morph::add(uvs, displacements, first, weight);
            }
            morph::add(self.colors, &target.colors, first, weight);
            bent |= !target.normals.is_empty() || !target.tangents.is_empty();
            tinted |= !target.colors.is_empty();
        }
        if tinted {
            // Section 3.7.2.2 of the specification.
            self.colors.as_flattened_mut().iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
        }
        if let Some(matrices) = matrices
            && deform.has_joints()
        {
            let (positions, normals) = (&mut *self.positions, &mut *self.normals);
            skin::apply(matrices, &deform.sets, first, positions, normals, self.tangents, self.orientation);
        } else if bent {
            self.normals.iter_mut().for_each(|n| *n = skin::unit(*n));
            for tangent in self.tangents.iter_mut() {
                let [x, y, z] = skin::unit([tangent[0], tangent[1], tangent[2]]);
                *tangent = [x, y, z, tangent[3]];
            }
        }
    }
}

impl Posed<'_> {
    /// Turns triangles that are mirrored, and checks the mesh.
    fn finish(&mut self) {
        let mut data = std::mem::take(&mut self.data);
        if self.orientation.iter().any(|&o| o < 0.0) {
            let determinant = |v: &u32| self.orientation.get(*v as usize);
            for triangle in &mut data.triangles {
                let sum = triangle.iter().filter_map(determinant).fold(0.0, |s, o| s + o);
                if sum < 0.0 {
                    let [_, b, c] = triangle;
                    std::mem::swap(b, c);
                }
            }
        }
        if self.wanted.deform.flat {
            for corners in &data.triangles {
                let [Some(a), Some(b), Some(c)] = corners.map(|v| data.positions.get(v as usize)) else {
                    continue;
                };
                let normal = geometric_normal(&[*a, *b, *c]);
                for &v in corners {
                    data.normals.get_mut(v as usize).into_iter().for_each(|own| *own = normal);
                }
            }
        }
        self.mesh = Some(Mesh::new(data));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn influences(weights: [f32; 4]) -> Influences {
        Influences { joints: vec![[1, 2, 900, 4]], weights: vec![weights] }
    }

    #[test]
    fn weights_add_up_to_one_over_all_sets() {
        let mut said = Vec::new();
        let mut sets = [influences([1.0, 1.0, 0.0, 0.0]), influences([0.0, 2.0, 0.0, 0.0])];
        let last = normalize(&mut sets, &mut |text| said.push(text.to_owned()));
        assert_eq!((sets[0].weights[0], sets[1].weights[0]), ([0.25, 0.25, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0]));
        assert_eq!((sets[0].joints[0], sets[1].joints[0], last), ([1, 2, 0, 0], [0, 2, 0, 0], 2));
        assert!(said.is_empty());
    }

    #[test]
    fn weights_that_are_none() {
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            let mut said = Vec::new();
            let mut sets = [influences([bad, 3.0, 0.0, 0.0])];
            let last = normalize(&mut sets, &mut |text| said.push(text.to_owned()));
            assert_eq!((sets[0].weights[0], last), ([0.0, 1.0, 0.0, 0.0], 2));
            assert_eq!(said.len(), 1, "{said:?}");
        }
        let mut said = Vec::new();
        let mut sets = [influences([0.0; 4])];
        assert_eq!(normalize(&mut sets, &mut |text| said.push(text.to_owned())), 0);
        assert_eq!((sets[0].joints[0], sets[0].weights[0]), ([0; 4], [1.0, 0.0, 0.0, 0.0]));
        assert!(said[0].contains("first joint"), "{said:?}");
    }

    /// Many vertices along x, by two targets and one mirroring joint, in more than one block.
    #[test]
    fn blocks_are_all_moved_and_mirrored_triangles_turned() {
        let count = 3 * BLOCK + 17;
        let base = MeshData::default().with(|d| {
            d.positions = (0..count).map(|k| [k as f32, 0.0, 0.0]).collect();
            d.normals = vec![[0.0, 0.0, 1.0]; count];
            d.colors = vec![[0.5; 4]; count];
            d.triangles = vec![[0, 1, 2], [2, 1, count as u32 - 1]];
        });
        let target = |y: f32| Displacements {
            positions: (0..count).map(|k| [0.0, y * k as f32, 0.0]).collect(),
            colors: vec![[y; 4]; count],
            ..Displacements::default()
        };
        let deform = Deform {
            sets: vec![Influences {
                joints: vec![[0; 4]; count],
                weights: vec![[1.0, 0.0, 0.0, 0.0]; count],
            }],
            last_joint: 0,
            targets: vec![(0, target(1.0)), (5, target(4.0))],
            flat: false,
        };
        assert_eq!(deform.targets().collect::<Vec<_>>(), [0, 5]);
        let mirror =
            [[[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 7.0, 0.0]]];
        for threads in [1, 3] {
            let jobs = Jobs::new(threads);
            let make = |matrices| Wanted { base: &base, deform: &deform, weights: vec![0.0, 0.5], matrices };
            let mut made =
                pose(&[make(None), make(Some(&mirror[..]))], &jobs).into_iter().map(Result::unwrap);
            let (morphed, skinned) = (made.next().unwrap(), made.next().unwrap());
            for k in 0..count {
                let x = k as f32;
                assert_eq!(morphed.positions()[k], [x, 2.0 * x, 0.0]);
                assert_eq!(skinned.positions()[k], [-x, 2.0 * x, 7.0]);
            }
            assert_eq!(morphed.triangles(), base.triangles);
            assert_eq!(skinned.triangles(), [[0, 2, 1], [2, count as u32 - 1, 1]]);
            assert_eq!((morphed.colors()[9], skinned.normals()[9]), ([1.0; 4], [0.0, 0.0, 1.0]));
        }
    }
}
