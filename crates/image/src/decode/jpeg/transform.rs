//! Inverse cosine transforms of blocks of 8 x 8, to their samples or to the means of 2, 4 or 8 samples along each side.
//!
//! A mean of neighbouring samples is a weighted sum of the coefficients as a sample is: no coefficient is left out, so that the
//! means are those of the samples that the whole transform makes, up to rounding. (Scaled transforms as other decoders have them
//! leave the high frequencies out, and filter in another way.)

/// Cosines of k * pi / 16.
const COSINES: [f32; 9] = [
    1.0,
    0.980_785_25,
    0.923_879_5,
    0.831_469_6,
    0.707_106_77,
    0.555_570_24,
    0.382_683_43,
    0.195_090_32,
    0.0,
];

/// Weight of each frequency (first index) in each sample (second).
type Weights = [[f32; 8]; 8];

/// Weights of means of 1, 2, 4 and 8 samples.
const WEIGHTS: [Weights; 4] = {
    let whole = weights();
    let half = means(&whole, 8);
    let quarter = means(&half, 4);
    [whole, half, quarter, means(&quarter, 2)]
};

/// Weights of the one-dimensional inverse transform (ITU-T T.81, A.3.3).
#[allow(clippy::indexing_slicing, clippy::arithmetic_side_effects)] // Evaluated by the compiler.
const fn weights() -> Weights {
    let mut weights = [[0.0; 8]; 8];
    let mut frequency = 0;
    while frequency < 8 {
        let mut sample = 0;
        while sample < 8 {
            let turn = (2 * sample + 1) * frequency % 32;
            let cosine = match turn {
                0..=8 => COSINES[turn],
                9..=16 => -COSINES[16 - turn],
                17..=24 => -COSINES[turn - 16],
                _ => COSINES[32 - turn],
            };
            weights[frequency][sample] = if frequency == 0 { 0.5 * COSINES[4] } else { 0.5 * cosine };
            sample += 1;
        }
        frequency += 1;
    }
    weights
}

/// Weights of the means of pairs of `count` samples.
#[allow(clippy::indexing_slicing, clippy::arithmetic_side_effects)] // Evaluated by the compiler.
const fn means(weights: &Weights, count: usize) -> Weights {
    let mut means = [[0.0; 8]; 8];
    let mut frequency = 0;
    while frequency < 8 {
        let mut sample = 0;
        while 2 * sample + 1 < count {
            means[frequency][sample] =
                0.5 * (weights[frequency][2 * sample] + weights[frequency][2 * sample + 1]);
            sample += 1;
        }
        frequency += 1;
    }
    means
}

/// Natural order of the coefficients: row by row, in zigzag (ITU-T T.81, figure A.6).
pub const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7,
    14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39,
    46, 53, 60, 61, 54, 47, 55, 62, 63,
];

/// Columns and rows of the coefficients up to each place of the zigzag.
const EXTENTS: [[u8; 2]; 64] = extents();

#[allow(clippy::indexing_slicing, clippy::arithmetic_side_effects)] // Evaluated by the compiler.
const fn extents() -> [[u8; 2]; 64] {
    let mut extents = [[1; 2]; 64];
    let mut place = 1;
    while place < 64 {
        let (column, row) = (ZIGZAG[place] % 8 + 1, ZIGZAG[place] / 8 + 1);
        let [columns, rows] = extents[place - 1];
        extents[place] =
            [if column > columns { column } else { columns }, if row > rows { row } else { rows }];
        place += 1;
    }
    extents
}

/// Coefficients of a block as they are coded.
#[derive(Clone, Debug)]
pub struct Block {
    /// In rows.
    pub coefficients: [i16; 64],
    /// Place in zigzag behind which all are 0.
    pub last: u8,
}

impl Block {
    /// A block of nothing.
    pub const EMPTY: Self = Self { coefficients: [0; 64], last: 0 };

    /// Columns and rows up to the last that are not 0.
    #[inline(always)]
    fn extent(&self) -> [usize; 2] {
        EXTENTS.get(usize::from(self.last)).copied().unwrap_or([8; 2]).map(usize::from)
    }

    /// Mean of its samples.
    #[inline(always)]
    pub fn mean(&self, steps: &[f32; 64]) -> f32 {
        let ([first, ..], [step, ..]) = (self.coefficients, steps);
        // Samples are stored less 128.
        f32::from(first) * step * 0.125 + 128.0
    }

    /// Makes it empty.
    pub fn clear(&mut self) {
        if self.last > 0 {
            self.coefficients = [0; 64];
            self.last = 0;
        }
        let [first, ..] = &mut self.coefficients;
        *first = 0;
    }
}

/// A block as numbers.
pub struct Dequantized {
    rows: [[f32; 8]; 8],
    /// Columns and rows up to the last that are not 0.
    extent: [usize; 2],
}

/// Variance of the samples of a block: the transform keeps the sum of squares (Parseval).
#[inline(always)]
pub fn variance(block: &Block, steps: &[f32; 64]) -> f32 {
    if block.last == 0 {
        return 0.0;
    }
    let mut sums = [0.0_f32; 8];
    let [_, count] = block.extent();
    for (row, steps) in block.coefficients.as_chunks::<8>().0.iter().zip(steps.as_chunks::<8>().0).take(count)
    {
        for ((sum, &coefficient), step) in sums.iter_mut().zip(row).zip(steps) {
            let number = f32::from(coefficient) * step;
            *sum += number * number;
        }
    }
    let ([first, ..], [step, ..]) = (block.coefficients, steps);
    let first = f32::from(first) * step;
    let [a, b, c, d, e, f, g, h] = sums;
    (((a + b) + (c + d)) + ((e + f) + (g + h)) - first * first) / 64.0
}

impl Dequantized {
    /// Multiplies coefficients by the steps of quantization, both in rows.
    #[inline(always)]
    pub fn new(block: &Block, steps: &[f32; 64]) -> Self {
        let mut rows = [[0.0; 8]; 8];
        let extent = block.extent();
        let [_, count] = extent;
        let coefficients = block.coefficients.as_chunks::<8>().0.iter().zip(steps.as_chunks::<8>().0);
        for (row, (coefficients, steps)) in rows.iter_mut().zip(coefficients).take(count) {
            for ((number, &coefficient), step) in row.iter_mut().zip(coefficients).zip(steps) {
                *number = f32::from(coefficient) * step;
            }
        }
        let [[first, ..], ..] = &mut rows;
        *first = 8.0 * block.mean(steps);
        Self { rows, extent }
    }

    /// Means of `1 << fold` samples along each side, columns and rows, written to `plane` from `start` on, whose rows are
    /// `stride` apart.
    #[inline(always)]
    pub fn means(&self, [fold_x, fold_y]: [u32; 2], plane: &mut [f32], start: usize, stride: usize) {
        let [columns, count] = self.extent;
        let [width, height] = [8 >> fold_x, 8 >> fold_y];
        let lines = plane.get_mut(start..).unwrap_or_default().chunks_mut(stride.max(1)).take(height);
        let [across, down] = [fold_x, fold_y].map(|fold| WEIGHTS.get(fold as usize).unwrap_or(&WEIGHTS[0]));
        for (sample, line) in lines.enumerate() {
            let mut sums = [0.0_f32; 8];
            for (row, weights) in self.rows.iter().zip(down).take(count) {
                let weight = weights.get(sample).copied().unwrap_or(0.0);
                sums.iter_mut().zip(row).for_each(|(sum, number)| *sum += number * weight);
            }
            let mut means = [0.0_f32; 8];
            for (sum, weights) in sums.iter().zip(across).take(columns) {
                means.iter_mut().zip(weights).for_each(|(mean, weight)| *mean += sum * weight);
            }
            line.iter_mut().zip(means).take(width).for_each(|(to, mean)| *to = mean);
        }
    }
}
