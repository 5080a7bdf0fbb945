//! Fragments of one pixel that show the same surface, shaded as one.
//!
//! Where a mesh has more triangles than the picture has pixels, every sample of a pixel sees another triangle, and shading
//! each costs as many times one picture as there are samples. Their normals hardly differ: the triangle with the most
//! samples answers for all. This is the idea of the aggregate G-buffer (Crassin et al. 2015, "Aggregate G-Buffer
//! Anti-Aliasing") with the representative in place of the mean, which keeps every plane of the G-buffer a value that
//! some surface has.
//!
//! Only neighbours are merged: triangles of one draw and side, each smaller than two pixels, whose normals differ by less
//! than an angle that the user gives, whose planes meet within a pixel, and whose vertices have one colour, if they have
//! any: textures are filtered over the pixel whichever triangle stands for it, colours of vertices are not. Edges, creases
//! and silhouettes keep their samples, and a pixel on which a surface bends is shaded as often as it bends by that angle:
//! the cost follows pixels and curvature, not triangles. It is off by default, because the picture changes where a
//! reflection is sharper than the angle. The result depends on nothing but the pixel's own triangles.

use super::{Draw, Fragment, SourceTriangle, TriangleSource};
use crate::raster::SUBPIXELS;

/// The most samples of a pixel.
const MOST: usize = 16;

/// Merges the fragments of pixels that show the same surface.
pub(super) struct Merger<'a, S> {
    source: &'a S,
    draws: &'a [Draw<'a>],
    /// Least square of the cosine of normals.
    least_squared_cosine: f32,
    /// Merge candidates among the last pixel's fragments.
    candidates: [Candidate; MOST],
}

impl<'a, S: TriangleSource> Merger<'a, S> {
    pub(super) fn new(source: &'a S, draws: &'a [Draw<'a>], least_squared_cosine: f32) -> Self {
        Self { source, draws, least_squared_cosine, candidates: [Candidate::default(); MOST] }
    }

    /// Merges fragments of one pixel, from `first` on. They are in the order of their lowest sample, before and after: the
    /// first that is left takes what shows the same surface as it does.
    #[inline(never)]
    pub(super) fn merge(&mut self, fragments: &mut Vec<Fragment>, first: usize) {
        let found = &mut fragments[first..];
        if found.len() < 2 {
            return;
        }
        let mut remaining = 0_u32;
        for (k, (fragment, candidate)) in found.iter().zip(&mut self.candidates).enumerate() {
            if let Some(found) = Candidate::new(fragment.triangle, self.source, self.draws) {
                *candidate = found;
                remaining |= 1 << k;
            }
        }
        let mut gone = 0_u32;
        while let Some(k) = take_lowest(&mut remaining) {
            let representative = &self.candidates[k];
            let mut merged = found[k];
            let mut most = merged.mask.count_ones();
            let mut others = remaining;
            while let Some(other) = take_lowest(&mut others) {
                if representative.continues(&self.candidates[other], self.least_squared_cosine) {
                    let Fragment { triangle, mask, .. } = found[other];
                    if mask.count_ones() > most {
                        (merged.triangle, most) = (triangle, mask.count_ones());
                    }
                    merged.mask |= mask;
                    remaining &= !(1 << other);
                    gone |= 1 << other;
                }
            }
            found[k] = merged;
        }
        if gone != 0 {
            let mut kept = 0;
            for k in 0..found.len() {
                if gone >> k & 1 == 0 {
                    found[kept] = found[k];
                    kept += 1;
                }
            }
            fragments.truncate(first + kept);
        }
    }
}

/// Takes the lowest of the numbers whose bits are set.
#[inline(always)]
fn take_lowest(bits: &mut u32) -> Option<usize> {
    let lowest = bits.trailing_zeros();
    *bits &= bits.wrapping_sub(1);
    (lowest < u32::BITS).then_some(lowest as usize)
}

/// A triangle that may be merged.
#[derive(Clone, Copy, Default)]
struct Candidate {
    draw: u32,
    back_facing: bool,
    /// A vertex on the screen: place and depth.
    place: [i32; 2],
    depth: f32,
    depth_gradient: [f32; 2],
    /// Sum of the normals of its vertices, in object space.
    normal: [f32; 3],
    /// Its length, squared.
    square: f32,
    /// That of all of its vertices.
    color: [f32; 4],
}

impl Candidate {
    /// `None` for triangles that are not small, those without normals, and those of several colours.
    #[inline(always)]
    fn new(identity: u32, source: &impl TriangleSource, draws: &[Draw<'_>]) -> Option<Self> {
        let SourceTriangle { screen, draw, .. } = source.triangle(identity);
        if screen.small_samples == 0 {
            return None;
        }
        let (mesh, vertices) = (draws[draw as usize].mesh, screen.vertices());
        let mut color = [1.0; 4];
        if !mesh.colors().is_empty() {
            let colors = vertices.map(|vertex| mesh.colors().get(vertex as usize).copied());
            color = colors[0]?;
            if colors != [Some(color); 3] {
                return None;
            }
        }
        let normal = |k: usize| mesh.normals().get(vertices[k] as usize).copied();
        let (a, b, c) = (normal(0)?, normal(1)?, normal(2)?);
        let sum = [0, 1, 2].map(|k| (a[k] + b[k]) + c[k]);
        let square = dot(sum, sum);
        (square > 0.0).then_some(Self {
            draw,
            back_facing: screen.is_back_facing(),
            place: [screen.x[0], screen.y[0]],
            depth: screen.depth[0],
            depth_gradient: screen.depth_gradient,
            normal: sum,
            square,
            color,
        })
    }

    /// True if the other shows the same surface.
    #[inline(always)]
    fn continues(&self, other: &Self, least_squared_cosine: f32) -> bool {
        if self.draw != other.draw || self.back_facing != other.back_facing || self.color != other.color {
            return false;
        }
        let cosine = dot(self.normal, other.normal);
        if !(cosine > 0.0 && cosine * cosine >= least_squared_cosine * self.square * other.square) {
            return false;
        }
        // The other's vertex lies on this triangle's plane, up to what depth changes over a pixel.
        let [dx, dy] = self.depth_gradient;
        let (x, y) = ((other.place[0] - self.place[0]) as f32, (other.place[1] - self.place[1]) as f32);
        let expected = self.depth + x * dx + y * dy;
        let slack = (dx.abs() + dy.abs()) * SUBPIXELS as f32 + self.depth.abs() * 1e-3;
        (other.depth - expected).abs() <= slack
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Triangle;
    use overcoat_scene::{Mesh, MeshData, Transform};

    /// Triangles by identity, all of draw 0.
    struct Listed(Vec<Triangle>);

    impl TriangleSource for Listed {
        fn triangle(&self, identity: u32) -> SourceTriangle<'_> {
            SourceTriangle { screen: &self.0[identity as usize], draw: 0, clip: None }
        }
    }

    /// Merges triangles with these normals and depths, and colours if any, one sample each.
    fn merged_colors(surfaces: &[([f32; 3], f32)], small: bool, colors: &[[f32; 4]]) -> Vec<(u32, u16)> {
        let data = MeshData::default().with(|d| {
            d.positions =
                surfaces.iter().flat_map(|_| [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).collect();
            d.normals = surfaces.iter().flat_map(|s| [s.0; 3]).collect();
            d.triangles = (0..surfaces.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            d.colors = colors.to_vec();
        });
        let mesh = Mesh::new(data).expect("valid");
        let identity = Transform::IDENTITY.normal_matrix();
        let draws = [Draw {
            mesh: &mesh,
            material: 0,
            object: 0,
            instance: 0,
            position_matrix: [[0.0; 4]; 3],
            normal_matrix: identity,
            tangent_matrix: identity,
            handedness: 1.0,
            scale: 1.0,
            uv_sets: [false; 2],
            edges: None,
        }];
        let triangle = |(k, s): (usize, &([f32; 3], f32))| {
            let x = 20 * k as i32;
            let corners = [(x, 0, s.1), (x + 60, 0, s.1), (x, 60, s.1)];
            let vertices = [0, 1, 2].map(|v| 3 * k as u32 + v);
            let mut triangle = Triangle::new(corners, vertices, true).expect("it has an area");
            triangle.small_samples = u64::from(small);
            triangle
        };
        let source = Listed(surfaces.iter().enumerate().map(triangle).collect());
        let mask = |k: usize| if k == 1 { 3 << 14 } else { 1 << k };
        let mut fragments: Vec<Fragment> =
            (0..surfaces.len()).map(|k| Fragment { triangle: k as u32, pixel: 0, mask: mask(k) }).collect();
        // 2 degrees.
        Merger::new(&source, &draws, 0.998_782).merge(&mut fragments, 0);
        fragments.iter().map(|f| (f.triangle, f.mask)).collect()
    }

    fn merged(surfaces: &[([f32; 3], f32)], small: bool) -> Vec<(u32, u16)> {
        merged_colors(surfaces, small, &[])
    }

    const UP: [f32; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn a_smooth_surface_is_shaded_once_by_the_triangle_with_the_most_samples() {
        let turned = [0.03, 0.0, 1.0];
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5), (turned, 0.5001)], true), [(1, 3 << 14 | 0b101)]);
    }

    #[test]
    fn colours_of_vertices_are_not_lost() {
        const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
        const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];
        let surfaces = [(UP, 0.5); 3];
        let of = |colors: [[f32; 4]; 3]| merged_colors(&surfaces, true, &colors.map(|c| [c; 3]).concat());
        assert_eq!(of([RED; 3]).len(), 1);
        assert_eq!(of([RED, BLUE, RED]), [(0, 0b101), (1, 3 << 14)]);
        // A gradient is not averaged by whom it stands for.
        let gradient = [RED, RED, BLUE].repeat(3);
        assert_eq!(merged_colors(&surfaces, true, &gradient).len(), 3);
    }

    #[test]
    fn creases_layers_and_large_triangles_stay_apart() {
        let crease = [0.04, 0.0, 1.0];
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5), (crease, 0.5)], true), [(1, 3 << 14 | 1), (2, 4)]);
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.6), (UP, 0.5)], true), [(0, 0b101), (1, 3 << 14)]);
        assert_eq!(merged(&[(UP, 0.5), (UP, 0.5)], false).len(), 2);
        // Without a normal there is nothing to compare.
        assert_eq!(merged(&[([0.0; 3], 0.5), ([0.0; 3], 0.5)], true).len(), 2);
    }
}
