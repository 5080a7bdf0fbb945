//! Tables over the unit square that depend on a direction, and the warp that makes a density even.
//!
//! Dupuy and Jakob 2018, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", sections 3.3 and 4: values
//! between those of a table are bilinear, and between the directions that it was made for linear in both angles. The warp goes by
//! rows first: the share of the density in the rows before, then that of the columns before within the row.

use super::MeasuredError;

/// Tables of one size, for each azimuth and elevation, and for each channel.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Columns and rows, two each at least.
    pub(super) size: [usize; 2],
    pub(super) channels: usize,
    pub(super) numbers: Vec<f32>,
}

/// Directions that tables are made for, in radians.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    pub(super) azimuths: Vec<f32>,
    pub(super) elevations: Vec<f32>,
}

/// Four tables and their weights.
pub(super) type Slices = [(usize, f64); 4];

impl Directions {
    /// The tables around a direction.
    pub(super) fn slices(&self, azimuth: f64, elevation: f64) -> Slices {
        let [a, b] = [between(&self.azimuths, azimuth), between(&self.elevations, elevation)];
        let stride = self.elevations.len();
        let of = |i: (usize, f64), j: (usize, f64)| (i.0 * stride + j.0, i.1 * j.1);
        [of(a[0], b[0]), of(a[0], b[1]), of(a[1], b[0]), of(a[1], b[1])]
    }
}

/// Indices on either side of a value in rising numbers, and their weights; beyond the ends the last number counts.
fn between(numbers: &[f32], value: f64) -> [(usize, f64); 2] {
    let above = numbers.partition_point(|n| f64::from(*n) <= value);
    if above == 0 || above == numbers.len() {
        let end = above.saturating_sub(1);
        return [(end, 1.0), (end, 0.0)];
    }
    let [low, high] = [numbers[above - 1], numbers[above]].map(f64::from);
    let share = (value - low) / (high - low);
    [(above - 1, 1.0 - share), (above, share)]
}

/// A patch of the square and the position within it.
struct Patch {
    column: usize,
    row: usize,
    x: f64,
    y: f64,
}

impl Grid {
    fn area(&self) -> usize {
        self.size[0] * self.size[1]
    }

    fn patch(&self, [u, v]: [f64; 2]) -> Patch {
        let along = |share: f64, n: usize| {
            let position = share.clamp(0.0, 1.0) * (n - 1) as f64;
            let cell = (position as usize).min(n - 2);
            (cell, position - cell as f64)
        };
        let ((column, x), (row, y)) = (along(u, self.size[0]), along(v, self.size[1]));
        Patch { column, row, x, y }
    }

    /// A number of the tables, weighted.
    fn at(&self, slices: &Slices, channel: usize, column: usize, row: usize) -> f64 {
        let within = row * self.size[0] + column;
        let of =
            |slice: usize| f64::from(self.numbers[(slice * self.channels + channel) * self.area() + within]);
        slices.iter().filter(|(_, weight)| *weight != 0.0).map(|(slice, weight)| weight * of(*slice)).sum()
    }

    /// The numbers at the corners of a patch: left and right, then below.
    fn corners(&self, slices: &Slices, channel: usize, patch: &Patch) -> [f64; 4] {
        let Patch { column, row, .. } = *patch;
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.at(slices, channel, column + i, row + j))
    }

    /// The bilinear value at a position of the square.
    pub(super) fn value(&self, slices: &Slices, channel: usize, position: [f64; 2]) -> f64 {
        let patch = self.patch(position);
        let [a, b, c, d] = self.corners(slices, channel, &patch);
        let (x, y) = (patch.x, patch.y);
        (1.0 - y) * ((1.0 - x) * a + x * b) + y * ((1.0 - x) * c + x * d)
    }
}

/// Densities over the square with their sums.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    /// Densities whose sum is 1 in units of patches.
    density: Grid,
    /// Sum of each row up to each column.
    in_rows: Grid,
    /// Sum of all rows up to each, a table of one column for each slice.
    over_rows: Vec<f32>,
}

impl Warp {
    /// Sums up densities, one table for each direction.
    ///
    /// # Errors
    /// [`MeasuredError`] if one is negative, or all of a table are 0.
    pub(super) fn new(what: &'static str, mut density: Grid) -> Result<Self, MeasuredError> {
        let [width, height] = density.size;
        let negative = density.numbers.iter().position(|n| *n < 0.0);
        if let Some(index) = negative {
            let value = f64::from(density.numbers[index]);
            return Err(MeasuredError::Number { what, index: index as u64, value, expected: "0 or more" });
        }
        let (mut in_rows, mut over_rows) = (density.clone(), Vec::new());
        let tables =
            density.numbers.chunks_mut(width * height).zip(in_rows.numbers.chunks_mut(width * height));
        for (slice, (table, sums)) in tables.enumerate() {
            let mut row_sums = Vec::new();
            for (row, sums) in table.chunks(width).zip(sums.chunks_mut(width)) {
                let mut sum = 0.0;
                for (column, place) in sums.iter_mut().enumerate() {
                    if column > 0 {
                        sum += 0.5 * (f64::from(row[column - 1]) + f64::from(row[column]));
                    }
                    *place = sum as f32;
                }
                row_sums.push(sum);
            }
            let halves = row_sums.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let total: f64 = halves.clone().sum();
            if total.is_nan() || total <= 0.0 || total > f64::from(f32::MAX) {
                let index = (slice * width * height) as u64;
                let expected = "a table whose sum is above 0 and finite";
                return Err(MeasuredError::Number { what, index, value: total, expected });
            }
            table.iter_mut().chain(sums).for_each(|n| *n = (f64::from(*n) / total) as f32);
            let mut sum = 0.0;
            over_rows.push(0.0);
            over_rows.extend(halves.map(|half| {
                sum += half;
                (sum / total) as f32
            }));
        }
        Ok(Self { density, in_rows, over_rows })
    }

    /// The position whose density is even, of one in the square.
    pub(super) fn invert(&self, slices: &Slices, position: [f64; 2]) -> [f64; 2] {
        let patch = self.density.patch(position);
        let Patch { column, row, x, y } = patch;
        let [a, b, c, d] = self.density.corners(slices, 0, &patch);
        let mix = |above: f64, below: f64| (1.0 - y) * above + y * below;
        let (left, right) = (mix(a, c), mix(b, d));
        let sums = |column: usize, row: usize| self.in_rows.at(slices, 0, column, row);
        let before = mix(sums(column, row), sums(column, row + 1));
        let last = self.density.size[0] - 1;
        let rows = [sums(last, row), sums(last, row + 1)];
        let whole = mix(rows[0], rows[1]);
        let along = before + x * (left + 0.5 * x * (right - left));
        let height = self.density.size[1];
        let above: f64 = slices
            .iter()
            .map(|(slice, weight)| weight * f64::from(self.over_rows[slice * height + row]))
            .sum();
        let down = above + y * (rows[0] + 0.5 * y * (rows[1] - rows[0]));
        // A row without density is seen from nowhere.
        [if whole > 0.0 { along / whole } else { 0.0 }, down]
    }
}
