//! Rows of texels from rows of blocks.
//!
//! Texels of a halved picture are the means of those of the whole one, in a unit of it that varies made of all of them. A unit whose
//! samples differ by less than one sees is transformed to the means themselves ([`SMOOTH`]): the light of these is the mean of light.

use super::halves::Half;
use super::header::{Component, Frame};
use super::plane::Plane;
use super::scan::Coefficients;
use super::transform::{Block, Dequantized, variance};
use super::{Jpeg, MOST_HALVINGS};
use overcoat_core::dispatch;
use overcoat_core::math::lanes::SimdLevel;
use std::ops::{Range, RangeInclusive};

/// Sum of the variances of a unit's blocks, in squares of codes, up to which its texels are taken for their mean. The code of the mean
/// of light is larger than the mean of codes by (p - 1) v / 2 (c + 14), with the power p = 2.4 of sRGB and a variance v about the
/// code c: less than 0.05 of a code.
const SMOOTH: f32 = 1.0;

/// Receiver of a row: halvings of the picture's size, and texels. False if no further row is wanted.
pub type Take<'a> = dyn FnMut(u32, &[[u8; 4]]) -> bool + 'a;

impl Jpeg<'_> {
    /// Gives the rows of the picture at its size halved as often as `halvings` says, each from the top on, those of the smallest first
    /// where several end at the same place. With `light` the means are of the light of sRGB codes, otherwise of codes. `None` if the
    /// file is damaged, whatever rows were given.
    pub fn rows(&self, halvings: RangeInclusive<u32>, light: bool, take: &mut Take<'_>) -> Option<()> {
        let frame = &self.frame;
        let mut stripes = Stripes::new(frame, halvings, light);
        let mut coefficients = Coefficients::new(frame);
        let [_, units] = frame.units;
        for row in 0..=units {
            if row < units {
                coefficients.next_row(frame)?;
                stripes.transform(frame, &coefficients.blocks);
            }
            // Chroma of the row below is needed: each row is given one later.
            match row.checked_sub(1) {
                None => stripes.begin(),
                Some(row) => {
                    if !stripes.give(row, take) {
                        return Some(());
                    }
                    stripes.advance();
                }
            }
        }
        Some(())
    }
}

/// Rows of units on their way to texels.
struct Stripes {
    size: [usize; 2],
    light: bool,
    /// The whole picture is given.
    whole: bool,
    planes: Vec<Plane>,
    halves: Vec<Half>,
    /// Units that vary, of the current row of units and of the next.
    varied: [Vec<bool>; 2],
    /// Texels of units of one colour, of which no sample is stored; of the same rows of units.
    uniform: [Vec<Option<[u8; 4]>>; 2],
    /// Texels along each side of a unit.
    unit: [usize; 2],
    /// Chroma of a row, and room for it.
    chroma: [Vec<f32>; 2],
    blended: Vec<f32>,
    /// Two rows.
    texels: [Vec<[u8; 4]>; 2],
}

impl Stripes {
    fn new(frame: &Frame<'_>, range: RangeInclusive<u32>, light: bool) -> Self {
        let planes: Vec<_> =
            frame.components.iter().map(|component| Plane::new(frame, component, 0)).collect();
        let size = frame.size.map(|side| side as usize);
        let half = |halvings: u32| {
            let plane = |component: &Component| {
                let is_halved =
                    frame.components.first().is_some_and(|first| first.sampling != component.sampling);
                (!is_halved).then(|| Plane::new(frame, component, halvings))
            };
            let is_given = range.contains(&halvings);
            let means = if is_given { frame.components.iter().map(plane).collect() } else { Vec::new() };
            let [width, _] = size;
            Half::new(halvings, is_given, means, width >> halvings)
        };
        let [units, _] = frame.units;
        let varied = vec![false; units];
        Self {
            size,
            light,
            whole: range.contains(&0),
            halves: (1..=*range.end()).map(half).collect(),
            planes,
            varied: [varied.clone(), varied],
            uniform: [vec![None; units], vec![None; units]],
            unit: frame
                .components
                .first()
                .map_or([8; 2], |first| first.sampling.map(|n| n.saturating_mul(8))),
            chroma: [Vec::new(), Vec::new()],
            blended: Vec::new(),
            texels: [Vec::new(), Vec::new()],
        }
    }

    /// Transforms the blocks of the next row of units, with the widest vectors that the compiler has here.
    fn transform(&mut self, frame: &Frame<'_>, blocks: &[Vec<Block>]) {
        dispatch!(SimdLevel::best(), _l => self.transform_blocks(frame, blocks));
    }

    /// [`Stripes::transform`] by the instruction set of the caller.
    #[inline(always)]
    fn transform_blocks(&mut self, frame: &Frame<'_>, blocks: &[Vec<Block>]) {
        let Self { whole, planes, halves, varied: [_, varied], uniform: [_, uniform], .. } = self;
        find_varied(frame, blocks, varied);
        // The mean of all samples of a block needs no transform.
        let is_finer = halves.iter().any(|half| half.is_given && half.halvings < MOST_HALVINGS);
        if frame.components.iter().all(|component| component.sampling == [1, 1]) {
            uniform
                .iter_mut()
                .enumerate()
                .for_each(|(unit, texel)| *texel = uniform_texel(frame, blocks, unit));
        }
        for (number, ((component, blocks), plane)) in
            frame.components.iter().zip(blocks).zip(planes).enumerate()
        {
            let is_halved = plane.halved != [false; 2];
            let [x, _] = component.sampling;
            let count = plane.stride / 8;
            for (row, line) in blocks.chunks_exact(count.max(1)).enumerate() {
                for (column, block) in line.iter().enumerate() {
                    if matches!(uniform.get(column), Some(Some(_))) {
                        continue;
                    }
                    let is_varied =
                        column.checked_div(x).and_then(|unit| varied.get(unit)).is_some_and(|varied| *varied);
                    let is_whole = *whole || is_halved || is_varied;
                    let is_needed = block.last > 0 && (is_whole || is_finer);
                    let numbers =
                        if is_needed { Some(Dequantized::new(block, &component.steps)) } else { None };
                    let mean = block.mean(&component.steps);
                    let of = (numbers.as_ref(), mean);
                    if is_whole {
                        write(plane, [column, row], 0, of);
                    }
                    if !is_varied {
                        for half in halves.iter_mut() {
                            if let Some(Some(plane)) = half.means.get_mut(number) {
                                write(plane, [column, row], half.halvings, of);
                            }
                        }
                    }
                }
            }
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
        let means = self.halves.iter_mut().flat_map(|half| half.means.iter_mut().flatten());
        self.planes.iter_mut().chain(means).for_each(Plane::advance);
        let [current, next] = &mut self.varied;
        std::mem::swap(current, next);
        let [current, next] = &mut self.uniform;
        std::mem::swap(current, next);
    }

    /// Gives the texel rows of the current row of units; false once no further is wanted.
    fn give(&mut self, units: usize, take: &mut Take<'_>) -> bool {
        let [_, rows] = self.unit;
        let [_, height] = self.size;
        let there = height.saturating_sub(units.saturating_mul(rows)).min(rows);
        self.smooth(units, there);
        if self.halves.iter().any(|half| half.is_given)
            && self.varied.first().is_some_and(|v| v.contains(&true))
        {
            self.vary(units, there);
        }
        for Half { halvings, is_given, texels, width, .. } in self.halves.iter().rev() {
            for row in texels.chunks_exact((*width).max(1)).filter(|_| *is_given) {
                if !take(*halvings, row) {
                    return false;
                }
            }
        }
        let runs = self.stored_runs(0);
        for row in 0..if self.whole { there } else { 0 } {
            self.convert(units, row, 0, &runs);
            let ([texels, _], [uniform, _], [side, _]) = (&mut self.texels, &self.uniform, self.unit);
            fill_uniform(uniform, side, texels);
            if !take(0, texels) {
                return false;
            }
        }
        true
    }

    /// Runs of texels of the halved picture in units whose samples are stored.
    fn stored_runs(&self, halvings: u32) -> Vec<Range<usize>> {
        let ([uniform, _], [side, _], [width, _]) = (&self.uniform, self.unit, self.size);
        let stored: Vec<bool> = uniform.iter().map(Option::is_none).collect();
        let texels = |unit: usize| unit.saturating_mul(side).min(width) >> halvings;
        runs_of(&stored).map(|run| texels(run.start)..texels(run.end)).collect()
    }

    /// Makes the texels of halves from means, as if all units were smooth.
    fn smooth(&mut self, units: usize, there: usize) {
        let stored: Vec<_> = self.halves.iter().map(|half| self.stored_runs(half.halvings)).collect();
        let Self { planes, halves, chroma, blended, uniform: [uniform, _], unit: [side, _], .. } = self;
        for (half, runs) in halves.iter_mut().zip(stored).filter(|(half, _)| half.is_given) {
            let Half { halvings, means, texels, width, .. } = half;
            texels.clear();
            for row in 0..there >> *halvings {
                let Some(Some(luma)) = means.first() else { return };
                let [for_blue, for_red] = &mut *chroma;
                let [blue, red] = [(1, for_blue), (2, for_red)].map(|(number, samples)| {
                    match (means.get(number), planes.get(number)) {
                        (Some(Some(mean)), _) => mean.sample(units, row, 0, blended, samples),
                        (_, Some(plane)) => plane.sample(units, row, *halvings, blended, samples),
                        _ => &[],
                    }
                });
                let luma = luma.row(units.saturating_mul(luma.rows), row as isize);
                let start = texels.len();
                texels.resize(start.saturating_add(*width), [255; 4]);
                let to = texels.get_mut(start..).unwrap_or_default();
                runs.iter().for_each(|run| paint([luma, blue, red], run, to));
                fill_uniform(uniform, *side >> *halvings, to);
            }
        }
    }

    /// Makes the texels of halves anew in units that vary: means of all of their texels.
    fn vary(&mut self, units: usize, there: usize) {
        let [side, _] = self.unit;
        let [width, _] = self.size;
        let varied = self.varied.first().map_or(&[][..], Vec::as_slice);
        let texels = |unit: usize| unit.saturating_mul(side).min(width);
        let runs: Vec<_> = runs_of(varied).map(|run| texels(run.start)..texels(run.end)).collect();
        for pair in 0..there / 2 {
            for place in 0..2 {
                self.convert(units, pair.saturating_mul(2).saturating_add(place), place, &runs);
            }
            let Self { halves, texels: [upper, lower], light, .. } = self;
            // Row of the half, which is whole once the second row of the next larger one is.
            let mut row = pair;
            let mut finer: Option<&Half> = None;
            for half in halves.iter_mut() {
                match finer {
                    None => runs.iter().for_each(|run| half.add_texels(upper, lower, run, *light)),
                    Some(finer) => {
                        let is_first = row.is_multiple_of(2);
                        runs.iter().for_each(|run| half.add_sums(finer, run, is_first));
                        if is_first {
                            break;
                        }
                        row /= 2;
                    }
                }
                if half.is_given {
                    runs.iter().for_each(|run| half.encode(row, run, *light));
                }
                finer = Some(half);
            }
        }
    }

    /// Makes texels of a row of the whole picture, in one of two places.
    fn convert(&mut self, units: usize, row: usize, place: usize, runs: &[Range<usize>]) {
        let Self { size: [width, _], planes, chroma, blended, texels, .. } = self;
        let (Some(luma), Some(texels)) = (planes.first(), texels.get_mut(place)) else { return };
        let luma = luma.row(units.saturating_mul(luma.rows), row as isize);
        texels.resize(*width, [255; 4]);
        let [for_blue, for_red] = chroma;
        let [blue, red] = [(1, for_blue), (2, for_red)].map(|(number, samples)| {
            planes.get(number).map_or(&[][..], |plane| plane.sample(units, row, 0, blended, samples))
        });
        runs.iter().for_each(|run| paint([luma, blue, red], run, texels));
    }
}

/// Writes the samples of a block, or the means of `1 << fold` of them along each side, to where it lies in a plane: of its mean alone
/// where that is all there is.
#[inline(always)]
fn write(
    plane: &mut Plane,
    [column, row]: [usize; 2],
    fold: u32,
    (numbers, mean): (Option<&Dequantized>, f32),
) {
    let side = 8_usize >> fold;
    let start = row.saturating_mul(side).saturating_mul(plane.stride);
    let start = start.saturating_add(column.saturating_mul(side));
    match numbers {
        Some(numbers) if fold < MOST_HALVINGS => {
            numbers.means([fold; 2], &mut plane.next, start, plane.stride);
        }
        _ => fill(&mut plane.next, start, plane.stride, side, mean),
    }
}

/// Writes one sample to so many columns and rows.
#[inline(always)]
fn fill(plane: &mut [f32], start: usize, stride: usize, side: usize, sample: f32) {
    let lines = plane.get_mut(start..).unwrap_or_default().chunks_mut(stride.max(1)).take(side);
    if side == 8 {
        lines.filter_map(|line| line.first_chunk_mut()).for_each(|line| *line = [sample; 8]);
    } else {
        lines.flat_map(|line| line.iter_mut().take(side)).for_each(|to| *to = sample);
    }
}

/// Finds the units of which some component's samples vary.
fn find_varied(frame: &Frame<'_>, blocks: &[Vec<Block>], varied: &mut [bool]) {
    let mut sums = vec![0.0_f32; varied.len()];
    for (component, blocks) in frame.components.iter().zip(blocks) {
        let [x, _] = component.sampling;
        for line in blocks.chunks_exact(varied.len().saturating_mul(x).max(1)) {
            for (sum, blocks) in sums.iter_mut().zip(line.chunks_exact(x.max(1))) {
                blocks.iter().for_each(|block| *sum += variance(block, &component.steps));
            }
        }
    }
    varied.iter_mut().zip(sums).for_each(|(varied, sum)| *varied = sum > SMOOTH);
}

/// Runs of numbers that are true.
fn runs_of(flags: &[bool]) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0_usize;
    std::iter::from_fn(move || {
        let next = |from: usize, flag: bool| flags.iter().skip(from).position(|&f| f == flag);
        let start = end.saturating_add(next(end, true)?);
        end = next(start, false).map_or(flags.len(), |count| start.saturating_add(count));
        Some(start..end)
    })
}

/// Texel of a unit of a block of each component, if all of these are of one sample.
fn uniform_texel(frame: &Frame<'_>, blocks: &[Vec<Block>], unit: usize) -> Option<[u8; 4]> {
    let mut samples = [0.0; 3];
    for (sample, (component, blocks)) in samples.iter_mut().zip(frame.components.iter().zip(blocks)) {
        let block = blocks.get(unit).filter(|block| block.last == 0)?;
        *sample = block.mean(&component.steps);
    }
    let ([luma, blue, red], mut texel) = (samples, [[0; 4]]);
    if frame.components.len() > 1 {
        colors(&[luma], &[blue], &[red], &mut texel)
    } else {
        greys(&[luma], &mut texel)
    }
    let [texel] = texel;
    Some(texel)
}

/// Writes the texels of units of one colour, so many of each, into a row.
fn fill_uniform(uniform: &[Option<[u8; 4]>], side: usize, row: &mut [[u8; 4]]) {
    for (texels, uniform) in row.chunks_mut(side.max(1)).zip(uniform) {
        if let Some(texel) = uniform {
            texels.fill(*texel);
        }
    }
}

/// Makes a part of a row of texels of samples: of luma alone if there are no others.
fn paint([luma, blue, red]: [&[f32]; 3], run: &Range<usize>, texels: &mut [[u8; 4]]) {
    let (Some(luma), Some(texels)) = (luma.get(run.clone()), texels.get_mut(run.clone())) else { return };
    match (blue.get(run.clone()), red.get(run.clone())) {
        (Some(blue), Some(red)) if !blue.is_empty() => {
            dispatch!(SimdLevel::best(), _l => colors(luma, blue, red, texels));
        }
        _ => greys(luma, texels),
    }
}

/// Texels of samples (ITU-T T.871, clause 7).
#[inline(always)]
fn colors(luma: &[f32], blue: &[f32], red: &[f32], texels: &mut [[u8; 4]]) {
    for ((texel, &luma), (&blue, &red)) in texels.iter_mut().zip(luma).zip(blue.iter().zip(red)) {
        let [blue, red] = [blue - 128.0, red - 128.0];
        let [r, g, b] =
            [luma + 1.402 * red, luma - 0.344_136_3 * blue - 0.714_136_3 * red, luma + 1.772 * blue]
                .map(code);
        *texel = [r, g, b, 255];
    }
}

/// Texels of grey samples.
fn greys(luma: &[f32], texels: &mut [[u8; 4]]) {
    for (texel, &luma) in texels.iter_mut().zip(luma) {
        let luma = code(luma);
        *texel = [luma, luma, luma, 255];
    }
}

/// The nearest code.
#[inline(always)]
fn code(value: f32) -> u8 {
    let value = if value > 0.0 { value } else { 0.0 };
    let value = if value < 255.0 { value } else { 255.0 };
    // From 2^23 on singles are whole numbers: the lowest bits are those of the code.
    (value + 8_388_608.0).to_bits() as u8
}
