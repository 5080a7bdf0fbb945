//! Orientation of a scene's surface, and the share of it that a view shows.

use crate::{Mesh, Scene, Transform};
use glam::DVec3;
use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask, SimdLevel};

/// Which way the surface of a scene faces, as moments of its normals weighted by area.
pub(crate) struct Facing {
    /// Mean of normal * transposed normal: xx, yy, zz, xy, xz, yz.
    tensor: [f64; 6],
    /// Mean normal of one-sided and of double-sided surfaces: zero where they are closed.
    mean: [DVec3; 2],
}

impl Facing {
    /// Summed up in double precision, one triangle after the other.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut tensor = [0.0; 6];
        let mut mean = [DVec3::ZERO; 2];
        for instance in scene.instances() {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let double_sided = scene.materials()[instance.material.index()].double_sided;
            let sign = if instance.transform.determinant() < 0.0 { -1.0 } else { 1.0 };
            let point =
                |v: u32| DVec3::from(instance.transform.point(mesh.positions()[v as usize].map(f64::from)));
            for &[a, b, c] in mesh.triangles() {
                let origin = point(a);
                let n = (point(b) - origin).cross(point(c) - origin) * sign;
                let length = (n.x * n.x + n.y * n.y + n.z * n.z).sqrt();
                if length > 0.0 {
                    mean[usize::from(double_sided)] += n;
                    let products = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z];
                    for (sum, product) in tensor.iter_mut().zip(products) {
                        *sum += product / length;
                    }
                }
            }
        }
        Self::of_sums(tensor, mean)
    }

    /// The means from the sums. Without area, a surface that faces every way.
    fn of_sums(tensor: [f64; 6], mean: [DVec3; 2]) -> Self {
        let area = tensor[0] + tensor[1] + tensor[2];
        if area > 0.0 && area.is_finite() {
            Self { tensor: tensor.map(|v| v / area), mean: mean.map(|v| v / area) }
        } else {
            let third = 1.0 / 3.0;
            Self { tensor: [third, third, third, 0.0, 0.0, 0.0], mean: [DVec3::ZERO; 2] }
        }
    }

    /// Estimate of the share of the area that is seen from a direction, foreshortened, 0 to 1: one half for a closed
    /// surface; for an open one 1 or, if it is one-sided and seen from behind, 0.
    pub(crate) fn visible_from(&self, direction: [f32; 3]) -> f64 {
        self.visible_with(direction, 0.0)
    }

    /// A bound on [`Facing::visible_from`] of the surfaces whose moments differ from these by at most `error` each: the
    /// least, or, for its negative, the most.
    fn visible_with(&self, direction: [f32; 3], error: f64) -> f64 {
        let d = DVec3::from(direction.map(f64::from));
        let [xx, yy, zz, xy, xz, yz] = self.tensor;
        let length_squared = d.x * d.x + d.y * d.y + d.z * d.z;
        // The magnitudes of nine products of unit vectors' coordinates sum up to three at most, those of three
        // coordinates to less than two.
        let square = xx * d.x * d.x
            + yy * d.y * d.y
            + zz * d.z * d.z
            + 2.0 * (xy * d.x * d.y + xz * d.x * d.z + yz * d.y * d.z)
            - 3.0 * error * length_squared;
        // Rounding may leave a little less than nothing.
        let foreshortened = if square > 0.0 { square.sqrt() } else { 0.0 };
        let length = length_squared.sqrt();
        0.5 * (foreshortened + self.mean[0].dot(d) + self.mean[1].dot(d).abs()) / length - 2.0 * error
    }
}

/// Moments in single precision, with a bound on their difference from [`Facing::new`]: a tenth of its time, and
/// enough where a view shows clearly more than it has to.
pub(crate) struct Estimate {
    facing: Facing,
    /// Largest difference of a moment.
    error: f64,
}

/// Triangles that are summed up in single precision before the sum is added in double precision.
const BLOCK: usize = 64 * LANES;

impl Estimate {
    /// The moments of all instances.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut tensor = [0.0; 6];
        let mut mean = [DVec3::ZERO; 2];
        let mut error = 0.0;
        for instance in scene.instances() {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let double_sided = scene.materials()[instance.material.index()].double_sided;
            let (matrix, weight) = normal_matrix(&instance.transform);
            let sums = dispatch_available!(SimdLevel::best(), l => sum(l, mesh, &matrix));
            mean[usize::from(double_sided)] += DVec3::from(sums.normal) * weight;
            for (all, own) in tensor.iter_mut().zip(sums.tensor) {
                *all += own * weight;
            }
            error += sums.error(mesh, &instance.transform, weight);
        }
        let area = tensor[0] + tensor[1] + tensor[2];
        // The area is off by three errors, and divides all. The last term is the rounding of sums of 2^26 numbers.
        Self { facing: Facing::of_sums(tensor, mean), error: 4.0 * (error / area + 1e-8) }
    }

    /// True if it is sure that [`Facing::visible_from`] is `part` of that of each of the others.
    pub(crate) fn surely_shows(&self, direction: [f32; 3], part: f64, others: &[[f32; 3]]) -> bool {
        let least = self.facing.visible_with(direction, self.error);
        let most = |other: &[f32; 3]| self.facing.visible_with(*other, -self.error);
        // An error that is no number is no assurance.
        self.error < 0.1 && least > 0.0 && others.iter().all(|other| least > part * most(other))
    }
}

/// The matrix for normals, whose entries' squares sum up to 1, and the factor that this leaves out.
fn normal_matrix(transform: &Transform) -> ([[f32; 3]; 3], f64) {
    let [a, b, c] = transform.rows().map(|r| DVec3::new(r[0], r[1], r[2]));
    let rows = [b.cross(c), c.cross(a), a.cross(b)];
    let norm = rows.iter().map(|r| r.dot(*r)).sum::<f64>().sqrt();
    let sign = if transform.determinant() < 0.0 { -1.0 } else { 1.0 };
    let unit = |row: DVec3| row.to_array().map(|v| if norm > 0.0 { (v / norm * sign) as f32 } else { 0.0 });
    (rows.map(unit), norm)
}

/// Sums over the triangles of a mesh.
#[derive(Default)]
struct Sums {
    tensor: [f64; 6],
    normal: [f64; 3],
    /// Squared lengths of the two edges that each normal is the product of, in object space.
    edges: f64,
}

impl Sums {
    /// Error bound of each sum, times `weight`, against [`Facing::new`].
    fn error(&self, mesh: &Mesh, transform: &Transform, weight: f64) -> f64 {
        let count = mesh.triangles().len() as f64;
        // A normal computed in single precision is off by some units in the last place of the product of its edges'
        // lengths; so is its part of the tensor, and the sums of 64 of either. The rest is underflow.
        let single = weight * (128.0 * f64::from(f32::EPSILON) * self.edges + 1e-17 * count);
        // The double precision of the other computation, whose edges are differences of points in the world.
        let (mut norm, mut magnitude) = (0.0, 0.0_f64);
        let reach: [f64; 3] =
            std::array::from_fn(|k| mesh.bounds().min[k].abs().max(mesh.bounds().max[k].abs()));
        for row in transform.rows() {
            norm += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
            let along = |k: usize| row[k].abs() * reach[k];
            magnitude = magnitude.max(along(0) + along(1) + along(2) + row[3].abs());
        }
        let off = 16.0 * f64::EPSILON * magnitude;
        let double = off * (2.0 * count * self.edges * norm).sqrt()
            + off * off * count
            + 16.0 * f64::EPSILON * self.edges * norm;
        single + 4.0 * double
    }
}

/// The sums, for a matrix for normals.
#[inline(always)]
fn sum<L: Lanes>(l: L, mesh: &Mesh, matrix: &[[f32; 3]; 3]) -> Sums {
    let positions = mesh.positions();
    let mut out = Sums::default();
    for block in mesh.triangles().chunks(BLOCK) {
        let mut sums = [l.zero(); 10];
        for group in block.chunks(LANES) {
            // Missing triangles have their corners at one place.
            let mut corners = [[[0.0_f32; LANES]; 3]; 3];
            for (k, triangle) in group.iter().enumerate() {
                for c in 0..3 {
                    if let Some(p) = positions.get(triangle[c] as usize) {
                        for axis in 0..3 {
                            corners[c][axis][k] = p[axis];
                        }
                    }
                }
            }
            let origin: [L::F; 3] = each!(k => l.load(&corners[0][k]));
            let u: [L::F; 3] = each!(k => l.load(&corners[1][k]) - origin[k]);
            let v: [L::F; 3] = each!(k => l.load(&corners[2][k]) - origin[k]);
            let normal: [L::F; 3] =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let n: [L::F; 3] =
                each!(r => normal[0] * matrix[r][0] + normal[1] * matrix[r][1] + normal[2] * matrix[r][2]);
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            let inverse = length.gt(l.zero()).select(length.recip(), l.zero());
            let unit: [L::F; 3] = each!(k => n[k] * inverse);
            let terms = [
                n[0] * unit[0],
                n[1] * unit[1],
                n[2] * unit[2],
                n[0] * unit[1],
                n[0] * unit[2],
                n[1] * unit[2],
                n[0],
                n[1],
                n[2],
                u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + v[0] * v[0] + v[1] * v[1] + v[2] * v[2],
            ];
            sums = each!(k => sums[k] + terms[k]);
        }
        for k in 0..10 {
            let lanes = sums[k].to_array();
            let mut total = 0.0;
            for lane in lanes {
                total += f64::from(lane);
            }
            match k {
                0..=5 => out.tensor[k] += total,
                6..=8 => out.normal[k - 6] += total,
                _ => out.edges += total,
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, MeshData};

    /// Triangles with corners from a generator, stretched along one axis.
    fn soup(count: u32, stretch: f32, transform: Transform, double_sided: bool) -> Scene {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(0x9e37_79b1).wrapping_add(0x85eb_ca6b);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.3
        };
        let positions: Vec<[f32; 3]> = (0..3 * count).map(|_| [next() * stretch, next(), next()]).collect();
        let triangles = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap();
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(mesh).unwrap();
        let material = scene.add_material(Material { double_sided, ..Material::default() }).unwrap();
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    #[test]
    fn the_estimate_is_within_its_bound() {
        let transforms = [
            Transform::IDENTITY,
            Transform::from_parts([1.0, 2.0, 3.0], [0.3, 0.1, -0.2, 0.9], [-1.0, 2.0, 0.1]).unwrap(),
            Transform::from_parts([1e6, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [1e-3; 3]).unwrap(),
            Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 0.0]).unwrap(),
            Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1e-9; 3]).unwrap(),
        ];
        for transform in transforms {
            for stretch in [1.0, 1e-6, 1e6, 0.0] {
                for count in [1, 17, 5000] {
                    let scene = soup(count, stretch, transform, count == 17);
                    let (exact, estimate) = (Facing::new(&scene), Estimate::new(&scene));
                    let bound = estimate.error;
                    let near = |a: f64, b: f64| {
                        let off = (a - b).abs();
                        assert!(
                            off <= bound || off.is_nan() || bound.is_nan(),
                            "{a} {b} +- {bound}: {transform:?} {stretch} {count}"
                        );
                    };
                    for (a, b) in exact.tensor.iter().zip(estimate.facing.tensor) {
                        near(*a, b);
                    }
                    for (a, b) in exact.mean.iter().zip(estimate.facing.mean) {
                        (0..3).for_each(|k| near(a[k], b[k]));
                    }
                    for direction in [[1.0, 0.0, 0.0], [0.62, 0.42, 1.0], [-1.0, 2.0, -3.0]] {
                        let visible = exact.visible_from(direction);
                        let [least, most] =
                            [bound, -bound].map(|e| estimate.facing.visible_with(direction, e));
                        assert!(bound.is_nan() || (least <= visible && visible <= most), "{bound}");
                        // More than itself it does not show.
                        assert!(!estimate.surely_shows(direction, 1.0, &[direction]), "{bound}");
                    }
                    // Useful, not only right, where triangles are not needles.
                    if stretch == 1.0 && transform == Transform::IDENTITY && count > 1 {
                        assert!(bound < 0.01, "{bound}");
                        let direction = [0.62, 0.42, 1.0];
                        let part = 1.0 - 8.0 * bound / exact.visible_from(direction);
                        assert!(estimate.surely_shows(direction, part, &[direction]));
                    }
                }
            }
        }
    }

    #[test]
    fn nothing_is_sure_without_area() {
        assert!(!Estimate::new(&Scene::new()).surely_shows([0.0, 0.0, 1.0], 0.0, &[]));
        let flat = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0]).unwrap();
        assert!(!Estimate::new(&soup(100, 1.0, flat, true)).surely_shows([0.0, 0.0, 1.0], 0.0, &[]));
    }
}
