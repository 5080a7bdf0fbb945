//! Rows of texels from rows of blocks.
//!
//! Chroma of half the columns or rows is interpolated between the two nearest samples with weights of 3/4 and 1/4, as most decoders
//! do it. The means of 2 samples so interpolated have 1/8 of each neighbour in them, those of 4 have 1/16, and so on: halves of a picture
//! are blurred by as much.

use super::header::{Component, Frame};
use super::scan::Coefficients;
use super::transform::{Block, Dequantized};
use super::{Jpeg, MOST_HALVINGS};

/// Variance of samples, in squares of codes, up to which the mean of their light is that of their codes: by less than 1/100 of a code.
const SMOOTH: f32 = 0.25;

/// Receiver of a row: halvings of the picture's size, and texels. False if no further row is wanted.
pub type Take<'a> = dyn FnMut(u32, &[[u8; 4]]) -> bool + 'a;

impl Jpeg<'_> {
    /// Gives the rows of the picture at its size halved as often as `halvings` says, each from the top on, those of the smallest first
    /// where several end at the same place. With `light` the means are of the light of sRGB codes, otherwise of codes. `None` if the
    /// file is damaged, whatever rows were given.
    pub fn rows(&self, halvings: std::ops::RangeInclusive<u32>, light: bool, take: &mut Take<'_>) -> Option<()> {
        let frame = &self.frame;
        let mut scales: Vec<Scale> =
            halvings.rev().map(|halvings| Scale::new(frame, halvings, light && halvings > 0)).collect();
        // Colours of chroma at half the size need more of it than its mean.
        let is_mean = |scale: &Scale| !light && scale.planes.iter().all(|plane| plane.fold == [MOST_HALVINGS; 2]);
        let mut coefficients = Coefficients::new(frame, scales.iter().all(is_mean));
        let [_, units] = frame.units;
        for row in 0..=units {
            if row < units {
                coefficients.next_row(frame)?;
                for (number, component) in frame.components.iter().enumerate() {
                    let blocks = coefficients.blocks.get(number)?;
                    transform(frame, number, component, blocks, &mut scales);
                }
            }
            // Chroma of the row below is needed: each row is given one later.
            let Some(row) = row.checked_sub(1) else {
                scales.iter_mut().for_each(Scale::begin);
                continue;
            };
            for scale in &mut scales {
                if !scale.give(row, take) {
                    return Some(());
                }
                scale.advance();
            }
        }
        Some(())
    }
}

/// Samples of a component at one size, of two rows of units.
struct Plane {
    /// Halvings that the transform makes, columns and rows.
    fold: [u32; 2],
    /// True where there are half as many samples as of the first component.
    halved: [bool; 2],
    /// Samples of the picture, columns and rows; more are stored, up to whole units.
    size: [usize; 2],
    stride: usize,
    /// Rows of a row of units.
    rows: usize,
    /// The last row of the units before.
    above: Vec<f32>,
    current: Vec<f32>,
    next: Vec<f32>,
}

impl Plane {
    fn new(frame: &Frame<'_>, component: &Component, halvings: u32) -> Self {
        let most = frame.components.first().map_or([1; 2], |first| first.sampling);
        let [[x, y], [most_x, most_y]] = [component.sampling, most];
        let halved = [x != most_x, y != most_y];
        let fold = halved.map(|halved| halvings.saturating_sub(halved.into()));
        let [width, height] = frame.size;
        let size = [(width, halved[0]), (height, halved[1])].map(|(side, halved)| {
            let side = if halved && halvings == 0 { side.div_ceil(2) } else { side >> halvings };
            side as usize
        });
        let [units, _] = frame.units;
        let stride = units.saturating_mul(x).saturating_mul(8 >> fold[0]);
        let rows = y.saturating_mul(8 >> fold[1]);
        let samples = vec![0.0; stride.saturating_mul(rows)];
        Self { fold, halved, size, stride, rows, above: vec![0.0; stride], current: samples.clone(), next: samples }
    }

    /// A row of the current ones, counted from the first of these on; rows beyond the picture are the next one within.
    fn row(&self, first: usize, row: isize) -> &[f32] {
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

    /// Samples of a texel row, in `out`; `blended` is room.
    fn upsample(&self, units: usize, row: usize, halvings: u32, blended: &mut Vec<f32>, out: &mut Vec<f32>) {
        let first = units.saturating_mul(self.rows);
        let [across, down] = self.halved;
        let at = |row: isize| self.row(first, row);
        let near = if down && halvings == 0 { row / 2 } else { row } as isize;
        let share = 1.0 / (4_u32 << halvings) as f32;
        blended.clear();
        match (down, halvings) {
            (false, _) => blended.extend_from_slice(at(near)),
            (true, 0) => {
                let far = if row.is_multiple_of(2) { near.saturating_sub(1) } else { near.saturating_add(1) };
                blended.extend(at(near).iter().zip(at(far)).map(|(near, far)| near + (far - near) * share));
            }
            (true, _) => {
                let around = at(near.saturating_sub(1)).iter().zip(at(near.saturating_add(1)));
                let blend = |(own, (a, b)): (&f32, (&f32, &f32))| own + ((a - own) + (b - own)) * share;
                blended.extend(at(near).iter().zip(around).map(blend));
            }
        }
        out.clear();
        if !across {
            out.extend_from_slice(blended);
            return;
        }
        let ([left, ..], [.., right]) = (blended.as_slice(), blended.as_slice()) else { return };
        let before = std::iter::once(left).chain(blended.iter());
        let after = blended.iter().skip(1).chain(std::iter::once(right));
        let around = blended.iter().zip(before.zip(after));
        if halvings == 0 {
            let pair = |(own, (a, b)): (&f32, (&f32, &f32))| [own + (a - own) * share, own + (b - own) * share];
            out.extend(around.flat_map(pair));
        } else {
            let blend = |(own, (a, b)): (&f32, (&f32, &f32))| own + ((a - own) + (b - own)) * share;
            out.extend(around.map(blend));
        }
    }
}

/// The picture at one size.
struct Scale {
    halvings: u32,
    size: [usize; 2],
    planes: Vec<Plane>,
    /// Means are of light.
    light: bool,
    /// Variance of luma in its means, of each block; of the current row of units and of the next.
    variances: [Vec<f32>; 2],
    /// Chroma of a row, and room for it.
    chroma: [Vec<f32>; 2],
    blended: Vec<f32>,
    texels: Vec<[u8; 4]>,
}

impl Scale {
    fn new(frame: &Frame<'_>, halvings: u32, light: bool) -> Self {
        let planes: Vec<_> =
            frame.components.iter().map(|component| Plane::new(frame, component, halvings)).collect();
        let size = frame.size.map(|side| (side >> halvings) as usize);
        let [x, y] = frame.components.first().map_or([1; 2], |first| first.sampling);
        let [units, _] = frame.units;
        let blocks = if light { units.saturating_mul(x).saturating_mul(y) } else { 0 };
        Self {
            halvings,
            size,
            planes,
            light,
            variances: [vec![0.0; blocks], vec![0.0; blocks]],
            chroma: [Vec::new(), Vec::new()],
            blended: Vec::new(),
            texels: Vec::new(),
        }
    }

    /// Takes the first row of units as the current one.
    fn begin(&mut self) {
        self.advance();
        for Plane { above, current, stride, .. } in &mut self.planes {
            current.iter().take(*stride).zip(above).for_each(|(from, to)| *to = *from);
        }
    }

    /// Goes on to the next row of units.
    fn advance(&mut self) {
        for Plane { above, current, next, stride, .. } in &mut self.planes {
            if let Some(last) = current.chunks_exact((*stride).max(1)).next_back() {
                above.copy_from_slice(last);
            }
            std::mem::swap(current, next);
        }
        let [current, next] = &mut self.variances;
        std::mem::swap(current, next);
    }

    /// Gives the texel rows of the current row of units; false once no further is wanted.
    fn give(&mut self, units: usize, take: &mut Take<'_>) -> bool {
        let Some(rows) = self.planes.first().map(|luma| luma.rows) else { return false };
        let [_, height] = self.size;
        let there = height.saturating_sub(units.saturating_mul(rows)).min(rows);
        for row in 0..there {
            self.convert(units, row);
            if !take(self.halvings, &self.texels) {
                return false;
            }
        }
        true
    }

    /// Makes the texels of a row.
    fn convert(&mut self, units: usize, row: usize) {
        let Self { halvings, size: [width, _], planes, light, variances, chroma, blended, texels } = self;
        let Some((luma, others)) = planes.split_first() else { return };
        let luma_row = luma.row(units.saturating_mul(luma.rows), row as isize);
        for (plane, samples) in others.iter().zip(chroma.iter_mut()) {
            plane.upsample(units, row, *halvings, blended, samples);
        }
        let [blue, red] = chroma;
        texels.resize(*width, [255; 4]);
        let is_grey = others.is_empty();
        if is_grey {
            for (texel, &luma) in texels.iter_mut().zip(luma_row) {
                let luma = code(luma);
                *texel = [luma, luma, luma, 255];
            }
        } else {
            for ((texel, &luma), (&blue, &red)) in texels.iter_mut().zip(luma_row).zip(blue.iter().zip(&*red)) {
                let [r, g, b] = color(luma, blue, red).map(code);
                *texel = [r, g, b, 255];
            }
        }
        if !*light {
            return;
        }
        let [fold_x, fold_y] = luma.fold;
        let [columns, lines] = [8_usize >> fold_x, 8_usize >> fold_y];
        let blocks = luma.stride / columns.max(1);
        let [variances, _] = variances;
        let Some(variances) = variances.chunks_exact(blocks.max(1)).nth(row / lines.max(1)) else { return };
        for (block, &variance) in variances.iter().enumerate().filter(|(_, variance)| **variance > SMOOTH) {
            let start = block.saturating_mul(columns);
            for at in start..start.saturating_add(columns).min(*width) {
                let of = |row: &[f32]| row.get(at).copied().unwrap_or(128.0);
                let [r, g, b] = color(of(luma_row), of(blue), of(red)).map(|c| code(brighter(c, variance)));
                if let Some(texel) = texels.get_mut(at) {
                    *texel = [r, g, b, 255];
                }
            }
        }
    }
}

/// Transforms a component's blocks of a row of units for all sizes.
fn transform(frame: &Frame<'_>, number: usize, component: &Component, blocks: &[Block], scales: &mut [Scale]) {
    let ([units, _], [x, _]) = (frame.units, component.sampling);
    let count = units.saturating_mul(x);
    for (row, line) in blocks.chunks_exact(count.max(1)).enumerate() {
        for (column, block) in line.iter().enumerate() {
            let numbers = Dequantized::new(block, &component.steps);
            for scale in scales.iter_mut() {
                let Some(plane) = scale.planes.get_mut(number) else { continue };
                let [width, height] = plane.fold.map(|fold| 8_usize >> fold);
                let start = row.saturating_mul(height).saturating_mul(plane.stride);
                let start = start.saturating_add(column.saturating_mul(width));
                let variance = numbers.means(plane.fold, &mut plane.next, start, plane.stride);
                if number == 0 && scale.light {
                    let [_, next] = &mut scale.variances;
                    if let Some(to) = next.get_mut(row.saturating_mul(count).saturating_add(column)) {
                        *to = variance;
                    }
                }
            }
        }
    }
}

/// Red, green and blue, not yet within their range (ITU-T T.871, clause 7).
#[inline(always)]
fn color(luma: f32, blue: f32, red: f32) -> [f32; 3] {
    let [blue, red] = [blue - 128.0, red - 128.0];
    [luma + 1.402 * red, luma - 0.344_136_3 * blue - 0.714_136_3 * red, luma + 1.772 * blue]
}

/// The nearest code.
#[inline(always)]
fn code(value: f32) -> u8 {
    (value + 0.5) as u8
}

/// Code of the mean light of samples whose codes have this mean and variance.
///
/// Light is about the power 2.4 of the code and 14 more (IEC 61966-2-1). The mean of a power p of numbers of the mean x and variance v
/// is that of x + (p - 1) v / (2 x), for a small v; the sum in the denominator keeps large ones within 0.02 x, for two equal halves.
#[inline(always)]
pub(super) fn brighter(mean: f32, variance: f32) -> f32 {
    let x = if mean > 0.0 { mean } else { 0.0 } + 14.0;
    mean + 0.7 * variance * x / (x * x + 0.4 * variance)
}
