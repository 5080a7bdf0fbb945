//! Vertex clustering: meshes of more triangles than may be kept, reduced while they are read.
//!
//! Vertices in one cell of a grid become one, at their mean, and triangles within fewer than three cells go (J. Rossignac and
//! P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes*, 1993). The grid begins fine; each time that there are more
//! clusters than may be, its cells double. Means are sums of whole numbers, so that the result is that of the cells that it ends with.

use super::vertices::PositionTable;
use overcoat_scene::{Bounds, MeshData};

/// Steps along the longest side in which positions are added up, as a power of two.
const STEPS: u32 = 20;

/// Triangles that may be kept for each cluster: a closed surface has two.
const TRIANGLES: usize = 4;

/// A mesh that is being clustered.
pub(super) struct Clusters {
    low: [f64; 3],
    /// Steps in a unit of length.
    scale: f64,
    /// Cells along the longest side, as a power of two.
    cells: u32,
    most: usize,
    seed: u64,
    /// Clusters by their cells.
    table: PositionTable,
    /// Cell of the last vertex, and its cluster: the next vertex is often in the same.
    last: Option<([u32; 3], u32)>,
    members: Vec<Sum>,
    /// Colours of the clusters, in parts of [`WHOLE`]; fewer than clusters where the last ones have none.
    colors: Vec<Sum>,
    /// Cluster of each vertex that was added by its number; [`NONE`] of those that cannot be drawn.
    of_vertices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// Code of a colour's component of 1.
const WHOLE: f32 = 65535.0;

/// Number of no cluster.
const NONE: u32 = u32::MAX;

/// Sum of triples of whole numbers (positions in steps, colours), and their count.
#[derive(Clone, Copy, Default)]
struct Sum {
    of: [u64; 3],
    count: u64,
}

impl Sum {
    fn add(&mut self, of: [u64; 3], count: u64) {
        self.of.iter_mut().zip(of).for_each(|(sum, more)| *sum = sum.saturating_add(more));
        self.count = self.count.saturating_add(count);
    }

    /// Adds to one of a list, which grows to have it.
    fn add_at(list: &mut Vec<Self>, number: u32, of: [u64; 3], count: u64) {
        let number = number as usize;
        if number >= list.len() {
            list.resize(number.saturating_add(1), Self::default());
        }
        if let Some(sum) = list.get_mut(number) {
            sum.add(of, count);
        }
    }

    fn mean(&self) -> [f64; 3] {
        self.of.map(|sum| sum as f64 / self.count as f64)
    }
}

impl Clusters {
    /// Clusters of vertices within `bounds`, at most about a quarter of `triangles`. `seed` is that of [`PositionTable`].
    pub(super) fn new(bounds: &Bounds, triangles: u64, seed: u64) -> Self {
        let extent =
            bounds.size().into_iter().fold(0.0_f64, |most, side| if side > most { side } else { most });
        let scale = if extent > 0.0 { f64::from((1_u32 << STEPS).wrapping_sub(1)) / extent } else { 0.0 };
        let most =
            usize::try_from(triangles).unwrap_or(usize::MAX).checked_div(TRIANGLES).unwrap_or(0).max(1);
        // A surface of that many cells, as a square.
        let cells = (most.ilog2() / 2).min(STEPS);
        Self {
            low: bounds.min,
            scale,
            cells,
            most,
            seed,
            table: PositionTable::new(seed),
            last: None,
            members: Vec::new(),
            colors: Vec::new(),
            of_vertices: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Adds a triangle.
    pub(super) fn add(&mut self, corners: [[f32; 3]; 3]) {
        let clusters = corners.map(|corner| self.vertex(corner));
        self.add_of_clusters(clusters);
    }

    /// Adds a vertex that triangles name by its number, or one that cannot be drawn: it has no position.
    pub(super) fn add_vertex(&mut self, position: Option<[f32; 3]>) {
        let cluster = position.map_or(NONE, |position| self.vertex(position));
        self.of_vertices.push(cluster);
        if self.table.len() > self.most && self.cells > 0 {
            self.halve();
        }
    }

    /// Number of vertices that were added by their number.
    pub(super) fn vertices(&self) -> usize {
        self.of_vertices.len()
    }

    /// True for a vertex that is there and can be drawn.
    pub(super) fn has(&self, vertex: i64) -> bool {
        usize::try_from(vertex).is_ok_and(|vertex| self.cluster_of(vertex).is_some())
    }

    /// Mean position of the cluster that a vertex is in; `None` of one that cannot be drawn or is not there.
    pub(super) fn near(&self, vertex: i64) -> Option<[f32; 3]> {
        let members = self.members.get(self.cluster_of(usize::try_from(vertex).ok()?)? as usize)?;
        Some(self.position(members, [0.0; 3]))
    }

    /// Adds a linear colour, components from 0 to 1, to the cluster of a vertex.
    pub(super) fn add_color(&mut self, vertex: usize, color: [f32; 3]) {
        if let Some(cluster) = self.cluster_of(vertex) {
            Sum::add_at(&mut self.colors, cluster, color.map(|c| (c * WHOLE + 0.5) as u64), 1);
        }
    }

    fn cluster_of(&self, vertex: usize) -> Option<u32> {
        self.of_vertices.get(vertex).copied().filter(|&cluster| cluster != NONE)
    }

    /// Adds a triangle of vertices that can be drawn.
    pub(super) fn add_triangle(&mut self, vertices: [u32; 3]) {
        let clusters = vertices.map(|vertex| self.cluster_of(vertex as usize).unwrap_or(NONE));
        if !clusters.contains(&NONE) {
            self.add_of_clusters(clusters);
        }
    }

    fn add_of_clusters(&mut self, [a, b, c]: [u32; 3]) {
        if a != b && b != c && c != a {
            self.triangles.push([a, b, c]);
        }
        let full = self.most.saturating_mul(TRIANGLES);
        if self.triangles.len() > full {
            self.drop_equal();
            // Soon there would be too many again.
            if self.triangles.len() > self.most.saturating_mul(TRIANGLES / 2) && self.cells > 0 {
                self.halve();
            }
        }
        let is_full = self.table.len() > self.most || self.triangles.len() > full;
        if is_full && self.cells > 0 {
            self.halve();
        }
    }

    /// Leaves one of equal triangles.
    fn drop_equal(&mut self) {
        for triangle in &mut self.triangles {
            let [a, b, c] = *triangle;
            // The least corner first, on the same side.
            *triangle = if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            };
        }
        self.triangles.sort_unstable();
        self.triangles.dedup();
    }

    /// The cluster of a position.
    fn vertex(&mut self, position: [f32; 3]) -> u32 {
        let [[x, low_x], [y, low_y], [z, low_z]] = {
            let [x, y, z] = position.map(f64::from);
            let [low_x, low_y, low_z] = self.low;
            [[x, low_x], [y, low_y], [z, low_z]]
        };
        // The conversion saturates.
        let step = |v: f64, low: f64| ((v - low) * self.scale) as u32;
        let steps = [step(x, low_x), step(y, low_y), step(z, low_z)];
        let shift = STEPS.saturating_sub(self.cells);
        let cell = steps.map(|step| step.wrapping_shr(shift));
        let number = match self.last {
            Some((last, number)) if last == cell => number,
            // Whole numbers of up to 20 bits are exact.
            _ => self.table.insert(cell.map(|v| v as f32)),
        };
        self.last = Some((cell, number));
        Sum::add_at(&mut self.members, number, steps.map(u64::from), 1);
        number
    }

    /// Doubles the cells.
    fn halve(&mut self) {
        self.cells = self.cells.saturating_sub(1);
        self.last = None;
        let old = std::mem::replace(&mut self.table, PositionTable::new(self.seed));
        let (mut members, mut colors) = (Vec::new(), Vec::new());
        let mut numbers = Vec::with_capacity(old.len());
        for (at, (cell, old)) in old.into_positions().into_iter().zip(&self.members).enumerate() {
            let number = self.table.insert(cell.map(|v| (v * 0.5).floor()));
            Sum::add_at(&mut members, number, old.of, old.count);
            if let Some(color) = self.colors.get(at) {
                Sum::add_at(&mut colors, number, color.of, color.count);
            }
            numbers.push(number);
        }
        (self.members, self.colors) = (members, colors);
        for cluster in &mut self.of_vertices {
            *cluster = numbers.get(*cluster as usize).copied().unwrap_or(NONE);
        }
        self.triangles.retain_mut(|triangle| {
            let [a, b, c] = triangle.map(|old| numbers.get(old as usize).copied().unwrap_or(0));
            *triangle = [a, b, c];
            a != b && b != c && c != a
        });
    }

    /// Cells along the longest side.
    pub(super) fn cells(&self) -> u32 {
        1 << self.cells
    }

    /// Mean position of a cluster about an origin.
    fn position(&self, members: &Sum, origin: [f64; 3]) -> [f32; 3] {
        let mut position = members.mean().map(|mean| (mean + 0.5) / self.scale);
        for (v, (low, origin)) in position.iter_mut().zip(self.low.iter().zip(origin)) {
            *v += low - origin;
        }
        position.map(|v| v as f32)
    }

    /// Mean linear colour of a cluster; white without any.
    fn color(&self, cluster: usize) -> [f32; 4] {
        match self.colors.get(cluster) {
            Some(sum) if sum.count > 0 => {
                let [r, g, b] = sum.mean().map(|mean| (mean / f64::from(WHOLE)) as f32);
                [r, g, b, 1.0]
            }
            _ => [1.0; 4],
        }
    }

    /// The mesh of the clusters that triangles have, about an origin; with colours if any were added.
    pub(super) fn finish(mut self, origin: [f64; 3]) -> MeshData {
        self.drop_equal();
        let mut triangles = std::mem::take(&mut self.triangles);
        let mut numbers = vec![NONE; self.members.len()];
        let (mut positions, mut colors) = (Vec::new(), Vec::new());
        for corner in triangles.as_flattened_mut() {
            let old = *corner as usize;
            let (Some(number), Some(members)) = (numbers.get_mut(old), self.members.get(old)) else {
                continue;
            };
            if *number == NONE {
                *number = positions.len() as u32;
                positions.push(self.position(members, origin));
                if !self.colors.is_empty() {
                    colors.push(self.color(old));
                }
            }
            *corner = *number;
        }
        MeshData::new(positions, triangles).with(|d| d.colors = colors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of a grid of n x n squares over the unit square, bulged by a parabola, in some order.
    fn relief(n: usize, order: impl Fn(usize) -> usize) -> Vec<[[f32; 3]; 3]> {
        let point = |i: usize, j: usize| {
            let [x, y] = [i, j].map(|k| k as f32 / n as f32);
            [x, y, 0.25 * (x * (1.0 - x) + y * (1.0 - y))]
        };
        let square = |k: usize| {
            let (i, j) = (k % n, k / n);
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..n * n).flat_map(|k| square(order(k))).collect()
    }

    fn clustered(triangles: &[[[f32; 3]; 3]], most: u64, seed: u64) -> (MeshData, u32) {
        let mut bounds = Bounds::EMPTY;
        triangles.as_flattened().iter().for_each(|&corner| bounds.include(corner));
        let mut clusters = Clusters::new(&bounds, most, seed);
        triangles.iter().for_each(|&triangle| clusters.add(triangle));
        let cells = clusters.cells();
        (clusters.finish([0.0; 3]), cells)
    }

    #[test]
    fn a_surface_stays_whole_and_where_it_was() {
        let triangles = relief(256, |k| k);
        let (mesh, cells) = clustered(&triangles, 8000, 1);
        assert_eq!(cells, 32);
        assert!(mesh.triangles.len() <= 8000 && mesh.triangles.len() > 1500, "{}", mesh.triangles.len());
        let size = 1.0 / f64::from(cells);
        let mut area = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].map(f64::from));
            area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        }
        // Seen from above, up to half a cell at the edges: no holes and no folds.
        assert!((area - 1.0).abs() < 3.0 * size, "{area}");
        for [x, y, z] in mesh.positions.iter().map(|p| p.map(f64::from)) {
            let height = 0.25 * (x * (1.0 - x) + y * (1.0 - y));
            assert!((z - height).abs() < size * size, "{x} {y} {z} {height}");
        }
    }

    #[test]
    fn the_order_of_triangles_and_the_seed_change_the_order_alone() {
        let sorted = |(mesh, cells): (MeshData, u32)| {
            let mut positions: Vec<_> = mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect();
            positions.sort_unstable();
            (positions, mesh.triangles.len(), cells)
        };
        let expected = sorted(clustered(&relief(64, |k| k), 1000, 1));
        assert_eq!(sorted(clustered(&relief(64, |k| k * 37 % 4096), 1000, 1)), expected);
        let (a, b) = (clustered(&relief(64, |k| k), 1000, 1).0, clustered(&relief(64, |k| k), 1000, 77).0);
        assert_eq!((a.positions, a.triangles), (b.positions, b.triangles));
    }

    #[test]
    fn few_triangles_and_points_end_in_little() {
        // Two cells along a side have four clusters of a relief.
        let (mesh, cells) = clustered(&relief(16, |k| k), 16, 1);
        assert_eq!((mesh.positions.len(), mesh.triangles.len() <= 16, cells), (4, true, 2));
        let (mesh, _) = clustered(&relief(16, |k| k), 0, 1);
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (0, 0));
        let (mesh, _) = clustered(&[[[3.0; 3]; 3]; 9], 1000, 1);
        assert_eq!(mesh.triangles.len(), 0);
        // One triangle, however often.
        let (mesh, cells) = clustered(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 999], 256, 1);
        assert_eq!((mesh.positions.len(), cells), (3, 8));
    }
}
