//! Density of edges: about how many lines lie side by side on a unit of length, around each edge.
//!
//! Lengths are summed in the cells of a grid, and each cell takes part in those around it by a tent, so that the density of a rim does not
//! jump from cell to cell. Two lines to a cell are not dense: a cell is 1/16 of the mesh, however small that is on the screen.

use super::Edge;

/// Cells along each axis: one in the middle of the box around all edges, and as many on both sides of it, so that a mirrored mesh has
/// the same densities.
const CELLS: usize = 17;

/// Places at which an edge that crosses all cells is looked at.
const STEPS: f64 = 48.0;

/// For each edge the mean density along it, in lines per unit of length: of parallel lines on a plane the reciprocal of their distance,
/// less that of the side of a cell.
pub(super) fn densities(edges: &[Edge], place: impl Fn(u32) -> [f32; 3]) -> Vec<f32> {
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in edges.iter().flat_map(|edge| edge.ends.map(&place)) {
        for (axis, v) in corner.map(f64::from).into_iter().enumerate() {
            min[axis] = if v < min[axis] { v } else { min[axis] };
            max[axis] = if v > max[axis] { v } else { max[axis] };
        }
    }
    let size = (0..3).map(|axis| max[axis] - min[axis]).fold(0.0, |a: f64, b| if b > a { b } else { a });
    // The outermost cells reach out by half of their side.
    let cell = size / (CELLS - 1) as f64;
    let middle: [f64; 3] = std::array::from_fn(|axis| 0.5 * (min[axis] + max[axis]));
    let cell_at = |p: [f64; 3]| {
        let along = |axis: usize| {
            let from_middle = ((p[axis] - middle[axis]) / cell).round();
            ((from_middle + (CELLS / 2) as f64) as usize).min(CELLS - 1)
        };
        (along(2) * CELLS + along(1)) * CELLS + along(0)
    };
    // The length of an edge, and the cells of places along it.
    let walk = |edge: &Edge| {
        let [a, b] = edge.ends.map(|end| place(end).map(f64::from));
        let along: [f64; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
        let length = (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]).sqrt();
        let steps = 1 + (STEPS * length / (2.0 * size)) as usize;
        let at = move |k: usize| {
            let t = (k as f64 + 0.5) / steps as f64;
            cell_at(std::array::from_fn(|axis| a[axis] + along[axis] * t))
        };
        (length, steps, at)
    };
    let mut sums = vec![0.0_f64; CELLS * CELLS * CELLS];
    for (length, steps, at) in edges.iter().map(walk) {
        (0..steps).for_each(|k| sums[at(k)] += length / steps as f64);
    }
    for stride in [1, CELLS, CELLS * CELLS] {
        sums = blurred(&sums, stride);
    }
    // On a plane, half of it is lost to the cells before and behind.
    let per_length = 2.0 / (cell * cell);
    let density = |edge: &Edge| {
        let (_, steps, at) = walk(edge);
        let all = (0..steps).map(|k| sums[at(k)]).sum::<f64>() / steps as f64 * per_length;
        let beyond = all - 1.0 / cell;
        if beyond > 0.0 { beyond as f32 } else { 0.0 }
    };
    edges.iter().map(density).collect()
}

/// Sums along one axis, weighted 1, 2, 1; beyond the border there is nothing.
fn blurred(sums: &[f64], stride: usize) -> Vec<f64> {
    let part = |cell: usize| {
        let along = cell / stride % CELLS;
        let before = if along > 0 { sums[cell - stride] } else { 0.0 };
        let after = if along + 1 < CELLS { sums[cell + stride] } else { 0.0 };
        0.25 * (before + after) + 0.5 * sums[cell]
    };
    (0..sums.len()).map(part).collect()
}
