//! Samples of a component, and chroma between them.
//!
//! Chroma of half the columns or rows is interpolated between the two nearest samples with weights of 3/4 and 1/4, as most decoders
//! do it.

use super::header::{Component, Frame};

/// Samples of a component, of two rows of units.
pub struct Plane {
    /// True where there are half as many samples as of the first component.
    pub halved: [bool; 2],
    /// Samples of the picture, columns and rows; more are stored, up to whole units.
    size: [usize; 2],
    pub stride: usize,
    /// Rows of a row of units.
    pub rows: usize,
    /// The last row of the units before.
    pub above: Vec<f32>,
    pub current: Vec<f32>,
    pub next: Vec<f32>,
}

impl Plane {
    /// Plane of the means of `1 << fold` samples along each side.
    pub fn new(frame: &Frame<'_>, component: &Component, fold: u32) -> Self {
        let most = frame.components.first().map_or([1; 2], |first| first.sampling);
        let [[x, y], [most_x, most_y]] = [component.sampling, most];
        let halved = [x != most_x, y != most_y];
        let [width, height] = frame.size;
        let size = [(width, x, most_x), (height, y, most_y)]
            .map(|(side, own, most)| ((side >> fold) as usize).saturating_mul(own).div_ceil(most));
        let [units, _] = frame.units;
        let stride = units.saturating_mul(x).saturating_mul(8 >> fold);
        let rows = y.saturating_mul(8 >> fold);
        let samples = vec![0.0; stride.saturating_mul(rows)];
        Self { halved, size, stride, rows, above: vec![0.0; stride], current: samples.clone(), next: samples }
    }

    /// A row of the current ones, counted from the first of these on, which is row `first` of the picture; for rows beyond the picture
    /// the next one within.
    pub fn row(&self, first: usize, row: isize) -> &[f32] {
        let [width, height] = self.size;
        let last = height.saturating_sub(first) as isize;
        let row = row.min(last.saturating_sub(1));
        let (plane, row) = match usize::try_from(row) {
            Err(_) => (&self.above, 0),
            Ok(row) if row < self.rows => (&self.current, row),
            Ok(_) => (&self.next, 0),
        };
        plane.chunks_exact(self.stride.max(1)).nth(row).and_then(|row| row.get(..width)).unwrap_or_default()
    }

    /// Goes on to the next row of units.
    pub fn advance(&mut self) {
        if let Some(last) = self.current.chunks_exact(self.stride.max(1)).next_back() {
            self.above.copy_from_slice(last);
        }
        std::mem::swap(&mut self.current, &mut self.next);
    }

    /// Samples of a texel row of the picture halved so often; `blended` and `out` are room. `units` is the row of units.
    pub fn sample<'a>(
        &'a self,
        units: usize,
        row: usize,
        halvings: u32,
        blended: &mut Vec<f32>,
        out: &'a mut Vec<f32>,
    ) -> &'a [f32] {
        let first = units.saturating_mul(self.rows);
        let [across, down] = self.halved;
        if [across, down] == [false; 2] && halvings == 0 {
            return self.row(first, row as isize);
        }
        let at = |row: usize| self.row(first, row as isize);
        let share = 1.0 / (4_u32 << halvings) as f32;
        blended.clear();
        if down && halvings == 0 {
            let near = row / 2;
            let step = if row.is_multiple_of(2) { -1 } else { 1 };
            let far = (near as isize).saturating_add(step);
            let pairs = at(near).iter().zip(self.row(first, far));
            blended.extend(pairs.map(|(near, far)| near + (far - near) * share));
        } else {
            // The mean of its samples, and of chroma a share of those around.
            let count = 1_usize << halvings.saturating_sub(down.into());
            let start = row.saturating_mul(count);
            blended.extend_from_slice(at(start));
            for row in start.saturating_add(1)..start.saturating_add(count) {
                blended.iter_mut().zip(at(row)).for_each(|(sum, sample)| *sum += sample);
            }
            if count > 1 {
                let scale = 1.0 / count as f32;
                blended.iter_mut().for_each(|sum| *sum *= scale);
            }
            if down {
                let last = start.saturating_add(count).saturating_sub(1);
                let outer = self
                    .row(first, (start as isize).saturating_sub(1))
                    .iter()
                    .zip(at(last.saturating_add(1)));
                let inner = at(start).iter().zip(at(last));
                for ((mean, (above, below)), (top, bottom)) in blended.iter_mut().zip(outer).zip(inner) {
                    *mean += ((above - top) + (below - bottom)) * share;
                }
            }
        }
        spread(blended, across, halvings, share, out);
        out
    }
}

/// [`Plane::sample`] along a row.
fn spread(row: &[f32], halved: bool, halvings: u32, share: f32, out: &mut Vec<f32>) {
    out.clear();
    let ([left, ..], [.., right]) = (row, row) else { return };
    if halved && halvings == 0 {
        out.resize(row.len().saturating_mul(2), 0.0);
        let pairs = out.as_chunks_mut::<2>().0;
        if let ([first, ..], [_, second, ..]) = (&mut *pairs, row) {
            *first = [*left, left + (second - left) * share];
        }
        for (pair, around) in pairs.iter_mut().skip(1).zip(row.windows(3)) {
            if let [before, own, after] = around {
                *pair = [own + (before - own) * share, own + (after - own) * share];
            }
        }
        if let ([.., last], [.., before, _]) = (&mut *pairs, row) {
            *last = [right + (before - right) * share, *right];
        }
        if let ([only], [sample]) = (pairs, row) {
            *only = [*sample; 2];
        }
        return;
    }
    let count = 1_usize << halvings.saturating_sub(halved.into());
    if count == 1 {
        out.extend_from_slice(row);
    } else {
        let scale = 1.0 / count as f32;
        out.extend(row.chunks_exact(count).map(|samples| samples.iter().sum::<f32>() * scale));
    }
    if !halved {
        return;
    }
    let mut before = left;
    let mut chunks = row.chunks_exact(count).zip(out).peekable();
    while let Some((samples, mean)) = chunks.next() {
        let ([first, ..], [.., last]) = (samples, samples) else { return };
        let after = match chunks.peek() {
            Some(([next, ..], _)) => next,
            _ => last,
        };
        *mean += ((before - first) + (after - last)) * share;
        before = last;
    }
}
