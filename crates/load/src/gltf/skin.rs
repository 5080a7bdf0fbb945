//! Skins: joints that move vertices.
//!
//! Section 3.7.3 of the specification: a vertex goes to the sum over its joints of weight * joint to world * inverse bind
//! matrix, in world space; the transform of the node that shows the mesh has no influence.

use super::FORMAT;
use super::accessor::{self, Component, Pick};
use super::buffers::Buffers;
use super::hierarchy::{Places, Tree};
use super::model::{Kind, Root};
use crate::budget::Budget;
use crate::{Context, LoadError};
use overcoat_scene::{Bounds, SceneError, Transform};

/// An affine map as four columns in single precision; the fourth numbers are not used.
pub(super) type Matrix = [[f32; 4]; 4];

/// Bytes charged for a joint: its place, its inverse bind matrix as read and as kept, and its matrix in a pose.
const JOINT_BYTES: u64 = 8 + 64 + 96 + 64;

/// A skin of the file.
pub(super) struct Skin {
    joints: Vec<Joint>,
    /// World space of the bind pose to joints; empty: identities.
    inverse: Vec<Transform>,
}

struct Joint {
    /// Number of its node.
    node: usize,
    /// Place of that in the tree.
    place: usize,
}

/// Finds the joints of a skin and reads its inverse bind matrices.
///
/// # Errors
/// [`LoadError`] naming the skin.
pub(super) fn read(
    root: &Root,
    index: usize,
    tree: &mut Tree,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<Skin, LoadError> {
    let given = root.skins.at(index)?;
    let name = || root.skins.label(index);
    let malformed = |message: String| LoadError::malformed(FORMAT, format!("{}: {message}", name()));
    if given.joints.is_empty() {
        return Err(malformed("it has no joints".to_owned()));
    }
    budget.charge(name, given.joints.len() as u64, JOINT_BYTES)?;
    let mut joints = Vec::with_capacity(given.joints.len());
    for joint in &given.joints {
        if joint.get() >= root.nodes.len() {
            return Err(malformed(format!("there is no node {joint}")));
        }
        let place = tree.reach(root, joint.get(), context.limits)?;
        joints.push(Joint { node: joint.get(), place });
    }
    let Some(matrices) = given.inverse_bind_matrices else { return Ok(Skin { joints, inverse: Vec::new() }) };
    accessor::require(root, matrices, buffers, context, budget)?;
    buffers.decompress(context.jobs)?;
    let elements = accessor::resolve(root, buffers, matrices)?;
    if elements.kind != Kind::Mat4 || elements.component != Component::F32 {
        return Err(malformed(format!("accessor {matrices} does not hold inverse bind matrices")));
    }
    if elements.count < joints.len() {
        return Err(malformed(format!(
            "{} inverse bind matrices for {} joints",
            elements.count,
            joints.len()
        )));
    }
    let inverse = elements
        .floats::<16>(&Pick::Range(0..joints.len()))?
        .into_iter()
        .map(|m| Transform::from_columns(m.map(f64::from)))
        .collect::<Result<_, SceneError>>()
        .map_err(LoadError::scene(format!("{}, inverse bind matrices", name())))?;
    Ok(Skin { joints, inverse })
}

impl Skin {
    /// Number of joints.
    pub(super) fn len(&self) -> usize {
        self.joints.len()
    }

    /// True if no joint squeezes what follows it to a line or a point.
    pub(super) fn keeps_surfaces(&self, places: &Places) -> bool {
        let keeps = |joint: &Joint| places.transform(joint.place).is_some_and(|t| t.keeps_surfaces());
        self.joints.iter().all(keeps)
    }

    /// A box around what all joints together may make of a box.
    pub(super) fn reach(&self, bounds: &Bounds, places: &Places) -> Bounds {
        self.joints.iter().enumerate().fold(Bounds::EMPTY, |all, (k, joint)| {
            let inverse = self.inverse.get(k).copied().unwrap_or_default();
            let placed = places.transform(joint.place).and_then(|place| place.after(&inverse).ok());
            placed.map_or(all, |placed| all.union(&bounds.transformed(&placed)))
        })
    }

    /// The bind pose's world space to that of a pose, for every joint.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming the joint whose transform overflows.
    pub(super) fn matrices(&self, root: &Root, places: &Places) -> Result<Vec<Matrix>, LoadError> {
        let matrix = |(k, joint): (usize, &Joint)| {
            // Without matrices they are identities.
            let inverse = self.inverse.get(k).copied().unwrap_or_default();
            let transform = places.transform(joint.place).and_then(|place| place.after(&inverse).ok());
            let rows = transform.map(|transform| transform.rows().map(|row| row.map(|v| v as f32)));
            match rows {
                Some(rows) if rows.as_flattened().iter().all(|v| v.is_finite()) => Ok(columns(rows)),
                _ => {
                    let name = format!("joint {k}, {}", root.nodes.label(joint.node));
                    Err(LoadError::scene(name)(SceneError::NotFinite { what: "transform" }))
                }
            }
        };
        self.joints.iter().enumerate().map(matrix).collect()
    }
}

/// The columns of a map that is given by rows.
fn columns([[ax, bx, cx, dx], [ay, by, cy, dy], [az, bz, cz, dz]]: [[f32; 4]; 3]) -> Matrix {
    [[ax, ay, az, 0.0], [bx, by, bz, 0.0], [cx, cy, cz, 0.0], [dx, dy, dz, 0.0]]
}

/// Up to four joints of each vertex.
pub(super) struct Influences {
    pub joints: Vec<[u16; 4]>,
    pub weights: Vec<[f32; 4]>,
}

/// The sum of the joints' matrices by their weights. Where all numbers are finite, so are the joints'.
#[inline]
fn blended(matrices: &[Matrix], sets: &[Influences], vertex: usize) -> Matrix {
    let mut sum = [[0.0; 4]; 4];
    for set in sets {
        let (Some(joints), Some(weights)) = (set.joints.get(vertex), set.weights.get(vertex)) else {
            continue;
        };
        for (&joint, &weight) in joints.iter().zip(weights) {
            // `Rig::check_joints` has made sure that there is one.
            let Some(matrix) = matrices.get(usize::from(joint)) else { continue };
            for (sum, column) in sum.as_flattened_mut().iter_mut().zip(matrix.as_flattened()) {
                *sum += weight * column;
            }
        }
    }
    sum
}

/// `x a + y b + z c`, and what is added to it.
#[inline]
fn combine([x, y, z]: [f32; 3], [a, b, c]: [&[f32; 4]; 3], and: &[f32; 4]) -> [f32; 4] {
    let mut out = *and;
    for ((out, a), (b, c)) in out.iter_mut().zip(a).zip(b.iter().zip(c)) {
        *out += (x * a + y * b) + z * c;
    }
    out
}

/// Three numbers and nothing.
#[inline]
fn cross(a: &[f32; 4], b: &[f32; 4]) -> [f32; 4] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0]
}

/// A vector at length 1, or zero if it has no direction. Scaled first: cofactors of small parts have squares that are
/// too small for the format.
#[inline]
pub(super) fn unit([x, y, z]: [f32; 3]) -> [f32; 3] {
    let larger = |a: f32, b: f32| if a.abs() > b { a.abs() } else { b };
    let largest = larger(x, larger(y, larger(z, 0.0)));
    if !(largest > f32::MIN_POSITIVE && largest < f32::INFINITY) {
        return [0.0; 3];
    }
    let [x, y, z] = [x / largest, y / largest, z / largest];
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// Moves consecutive vertices, the first of which is number `first` of the mesh. `normals` and `tangents` may be empty.
/// `orientation` becomes the determinant of each vertex's map: below 0 where it mirrors.
pub(super) fn apply(
    matrices: &[Matrix],
    sets: &[Influences],
    first: usize,
    positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
    tangents: &mut [[f32; 4]],
    orientation: &mut [f32],
) {
    for (k, (position, orientation)) in positions.iter_mut().zip(orientation).enumerate() {
        let [a, b, c, d] = blended(matrices, sets, first.saturating_add(k));
        let [x, y, z, _] = combine(*position, [&a, &b, &c], &d);
        *position = [x, y, z];
        // The columns of the cofactor matrix: the inverse transpose times the determinant, for singular maps too.
        let cofactors = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        let determinant = (a[0] * cofactors[0][0] + a[1] * cofactors[0][1]) + a[2] * cofactors[0][2];
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        *orientation = determinant;
        if let Some(normal) = normals.get_mut(k) {
            let [p, q, r] = &cofactors;
            let [x, y, z, _] = combine(*normal, [p, q, r], &[0.0; 4]);
            *normal = unit([sign * x, sign * y, sign * z]);
        }
        if let Some(tangent) = tangents.get_mut(k) {
            let [x, y, z, w] = *tangent;
            let [x, y, z, _] = combine([x, y, z], [&a, &b, &c], &[0.0; 4]);
            let [x, y, z] = unit([x, y, z]);
            *tangent = [x, y, z, sign * w];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: [[f32; 4]; 3]) -> Matrix {
        columns(rows)
    }
    fn one(
        matrices: &[Matrix],
        joints: [u16; 4],
        weights: [f32; 4],
        p: [f32; 3],
        n: [f32; 3],
        t: [f32; 4],
    ) -> ([f32; 3], [f32; 3], [f32; 4], f32) {
        let sets = [Influences { joints: vec![joints], weights: vec![weights] }];
        let (mut p, mut n, mut t, mut o) = ([p], [n], [t], [0.0]);
        apply(matrices, &sets, 0, &mut p, &mut n, &mut t, &mut o);
        (p[0], n[0], t[0], o[0])
    }
    const STILL: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

    #[test]
    fn halfway_between_two_joints() {
        let moved = [[1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 2.0]];
        let (p, n, t, o) = one(
            &[matrix(STILL), matrix(moved)],
            [1, 0, 0, 0],
            [0.25, 0.75, 0.0, 0.0],
            [1.0, 2.0, 3.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0, -1.0],
        );
        assert_eq!((p, n, t, o), ([2.0, 2.0, 3.5], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0, -1.0], 1.0));
    }

    /// A plane x + y = 0 squeezed to a third along x: its normal goes with the inverse transpose.
    #[test]
    fn normals_stay_perpendicular_to_the_surface() {
        let squeezed = [[1.0 / 3.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let (_, n, t, _) = one(
            &[matrix(squeezed)],
            [0; 4],
            [1.0, 0.0, 0.0, 0.0],
            [0.0; 3],
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 0.0, 1.0],
        );
        let length = 10.0_f32.sqrt();
        for (a, b) in
            n.iter().chain(&t[..3]).zip([3.0 / length, 1.0 / length, 0.0, 1.0 / length, -3.0 / length, 0.0])
        {
            assert!((a - b).abs() < 1e-6, "{n:?} {t:?}");
        }
    }

    #[test]
    fn mirroring_turns_the_bitangent_and_keeps_the_normal_outside() {
        let mirrored = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let (p, n, t, o) = one(
            &[matrix(mirrored)],
            [0; 4],
            [1.0, 0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 1.0],
        );
        assert_eq!((p, n, t, o), ([-1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0, -1.0], -1.0));
        // The bitangent w * cross(n, t) is the mirrored one: cross(+x, +y) = +z before, -1 * cross(-x, +y) = +z after.
    }

    #[test]
    fn small_and_singular_maps() {
        let small = STILL.map(|row| row.map(|v| v * 1e-12));
        let (_, n, t, _) = one(
            &[matrix(small)],
            [0; 4],
            [1.0, 0.0, 0.0, 0.0],
            [1.0; 3],
            [0.0, 0.6, 0.8],
            [1.0, 0.0, 0.0, 1.0],
        );
        assert_eq!((n, t), ([0.0, 0.6, 0.8], [1.0, 0.0, 0.0, 1.0]));
        let nothing = [[0.0; 4]; 3];
        let (p, n, _, _) = one(
            &[matrix(nothing)],
            [0; 4],
            [1.0, 0.0, 0.0, 0.0],
            [1.0; 3],
            [0.0, 0.6, 0.8],
            [1.0, 0.0, 0.0, 1.0],
        );
        assert_eq!((p, n), ([0.0; 3], [0.0; 3]));
    }
}
