//! Fragments of one pixel that show the same surface, shaded as one.
//!
//! Where a mesh has more triangles than the picture has pixels, every sample of a pixel sees another triangle, and shading
//! each costs as many times one picture as there are samples. Their normals hardly differ: the triangle with the most
//! samples answers for all. This is the idea of the aggregate G-buffer (Crassin et al. 2015, "Aggregate G-Buffer
//! Anti-Aliasing") with the representative in place of the mean, which keeps every plane of the G-buffer a value that
//! some surface has.
//!
//! Only neighbours are merged: triangles of one draw and side, each smaller than a pixel, whose normals differ by less than
//! an angle that the user gives and whose planes meet within a pixel. Edges, creases and silhouettes keep their samples,
//! and a pixel on which a surface bends is shaded as often as it bends by that angle: the cost follows pixels and
//! curvature, not triangles. It is off by default, because the picture changes where a reflection is sharper than the
//! angle. The result depends on nothing but the pixel's own triangles.

use super::{Draw, Fragment, SourceTriangle, TriangleSource};
use crate::raster::{SUBPIXELS, Triangle};

/// Twice the area of a pixel in square sub-pixels.
const TWICE_A_PIXEL: i64 = 2 * (SUBPIXELS as i64) * (SUBPIXELS as i64);

/// The most samples of a pixel.
const MOST: usize = 16;

/// Merges fragments of one pixel, from `first` on, that show the same surface: normals whose cosine has at least this
/// square. They are in the order of their lowest sample, before and after.
pub(super) fn merge(
    fragments: &mut Vec<Fragment>,
    first: usize,
    source: &impl TriangleSource,
    draws: &[Draw<'_>],
    least_squared_cosine: f32,
) {
    let found = &mut fragments[first..];
    if found.len() < 2 {
        return;
    }
    let mut candidates = [None; MOST];
    for (candidate, fragment) in candidates.iter_mut().zip(&*found) {
        *candidate = Candidate::new(fragment.triangle, source, draws);
    }
    // By number of samples; of equal ones the first comes first.
    let mut order: [usize; MOST] = std::array::from_fn(|k| k);
    let order = &mut order[..found.len()];
    order.sort_by_key(|&k| std::cmp::Reverse(found[k].mask.count_ones()));
    for (place, &k) in order.iter().enumerate() {
        let Some(representative) = candidates[k] else { continue };
        for &other in &order[place + 1..] {
            if candidates[other].is_some_and(|c| representative.continues(&c, least_squared_cosine)) {
                candidates[other] = None;
                found[k].mask |= std::mem::take(&mut found[other].mask);
            }
        }
    }
    found.sort_unstable_by_key(|fragment| fragment.mask.trailing_zeros());
    // Those that were merged into others are left without samples, and have come last.
    let kept = found.iter().take_while(|fragment| fragment.mask != 0).count();
    fragments.truncate(first + kept);
}

/// A triangle that may be merged.
#[derive(Clone, Copy)]
struct Candidate<'a> {
    triangle: &'a Triangle,
    draw: u32,
    /// Sum of the normals of its vertices, in object space.
    normal: [f32; 3],
    /// Its length, squared.
    square: f32,
}

impl<'a> Candidate<'a> {
    /// `None` for triangles as large as a pixel, clipped ones, and those without normals.
    fn new(identity: u32, source: &'a impl TriangleSource, draws: &[Draw<'_>]) -> Option<Self> {
        let SourceTriangle { screen: triangle, vertices: [a, b, c], draw, clip } = source.triangle(identity);
        let [x0, y0, x1, y1] = triangle.bounds();
        if clip.is_some() || x1 - x0 >= 4 * SUBPIXELS || y1 - y0 >= 4 * SUBPIXELS {
            return None;
        }
        let side =
            |k: usize| (i64::from(triangle.x[k] - triangle.x[0]), i64::from(triangle.y[k] - triangle.y[0]));
        let ((ax, ay), (bx, by)) = (side(1), side(2));
        if ax * by - ay * bx > TWICE_A_PIXEL {
            return None;
        }
        let mesh = draws[draw as usize].mesh;
        let normal = |vertex: u32| mesh.normals().get(vertex as usize).copied();
        let (a, b, c) = (normal(a)?, normal(b)?, normal(c)?);
        let sum = [0, 1, 2].map(|k| (a[k] + b[k]) + c[k]);
        let square = dot(sum, sum);
        (square > 0.0).then_some(Self { triangle, draw, normal: sum, square })
    }

    /// True if the other shows the same surface.
    fn continues(&self, other: &Self, least_squared_cosine: f32) -> bool {
        let (a, b) = (self.triangle, other.triangle);
        if self.draw != other.draw || a.back_facing != b.back_facing {
            return false;
        }
        let cosine = dot(self.normal, other.normal);
        if !(cosine > 0.0 && cosine * cosine >= least_squared_cosine * self.square * other.square) {
            return false;
        }
        // The other's vertex lies on this triangle's plane, up to what depth changes over a pixel.
        let [dx, dy] = a.depth_gradient;
        let (x, y) = ((b.x[0] - a.x[0]) as f32, (b.y[0] - a.y[0]) as f32);
        let expected = a.depth[0] + x * dx + y * dy;
        let slack = (dx.abs() + dy.abs()) * SUBPIXELS as f32 + a.depth[0].abs() * 1e-3;
        (b.depth[0] - expected).abs() <= slack
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::NOT_CLIPPED;
    use crate::scene::{Mesh, MeshData, Transform};

    /// Triangles by identity, all of draw 0.
    struct Listed(Vec<Triangle>);

    impl TriangleSource for Listed {
        fn triangle(&self, identity: u32) -> SourceTriangle<'_> {
            let vertices = [0, 1, 2].map(|v| 3 * identity + v);
            SourceTriangle { screen: &self.0[identity as usize], vertices, draw: 0, clip: None }
        }
    }

    /// Merges triangles of 60 sub-pixels with these normals and depths, one sample each.
    fn merged(surfaces: &[([f32; 3], f32)], side: i32) -> Vec<(u32, u16)> {
        let data = MeshData {
            positions: surfaces.iter().flat_map(|_| [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).collect(),
            normals: surfaces.iter().flat_map(|s| [s.0; 3]).collect(),
            triangles: (0..surfaces.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            ..MeshData::default()
        };
        let mesh = Mesh::new(data).expect("valid");
        let identity = Transform::IDENTITY.normal_matrix();
        let draws = [Draw {
            mesh: &mesh,
            material: 0,
            object: 0,
            normal_matrix: identity,
            tangent_matrix: identity,
            handedness: 1.0,
            scale: 1.0,
            uv_sets: [false; 2],
        }];
        let triangle = |(k, s): (usize, &([f32; 3], f32))| {
            let x = 20 * k as i32;
            let corners = [(x, 0, s.1), (x + side, 0, s.1), (x, side, s.1)];
            Triangle::new(corners, k as u32, NOT_CLIPPED, true).expect("it has an area")
        };
        let source = Listed(surfaces.iter().enumerate().map(triangle).collect());
        let mask = |k: usize| if k == 1 { 3 << 14 } else { 1 << k };
        let mut fragments: Vec<Fragment> =
            (0..surfaces.len()).map(|k| Fragment { triangle: k as u32, pixel: 0, mask: mask(k) }).collect();
        // 2 degrees.
        merge(&mut fragments, 0, &source, &draws, 0.998_782);
        fragments.iter().map(|f| (f.triangle, f.mask)).collect()
    }

    const UP: [f32; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn a_smooth_surface_is_shaded_once_by_the_triangle_with_the_most_samples() {
        let turned = [0.03, 0.0, 1.0];
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5), (turned, 0.5001)], 60), [(1, 3 << 14 | 0b101)]);
    }

    #[test]
    fn creases_layers_and_triangles_of_a_pixel_stay_apart() {
        let crease = [0.04, 0.0, 1.0];
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5), (crease, 0.5)], 60), [(1, 3 << 14 | 1), (2, 4)]);
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.6), (UP, 0.5)], 60), [(0, 0b101), (1, 3 << 14)]);
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5)], 400).len(), 2);
        // Without a normal there is nothing to compare.
        assert_eq!(merged(&[([0.0; 3], 0.5), ([0.0; 3], 0.5)], 60).len(), 2);
    }
}
