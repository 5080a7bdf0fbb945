//! Mip levels: each texel the average of exactly its share of the image, in linear light.
//!
//! A level has half the size of the one before it, rounded down. Where a side is odd, `n = 2m + 1`, the share of a
//! texel is `2 + 1/m` source texels wide: texel i takes the weights `(m - i, m, i + 1) / n` of the source texels
//! `2i, 2i + 1, 2i + 2` (the polyphase box filter of Guthe and Heckbert, "Non-Power-of-Two Mipmap Creation", NVIDIA
//! 2005). The shares tile the image and never cross its edge, so wrap modes do not matter here.
//!
//! All levels are made in one pass over the image: a row that a level finishes goes on, unrounded, into the sums of
//! the next. Levels are stored in 8 bits a channel but never made from rounded texels, so that errors do not grow
//! from level to level.

use super::row_bands::{RowBands, doubled};
use super::{AlphaUse, ColorSpace, Image, LevelLayout};
use overcoat_core::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb8};
use std::ops::RangeInclusive;

/// Weight of an invisible texel's colour, as a fraction of an opaque one's. Not 0, so that the colour of a wholly
/// invisible share is its plain average; a power of two, so that its averages are exact.
const INVISIBLE: f32 = 1.0 / 65536.0;

/// A texel before rounding, in units of its [`Meaning`].
type Sum = [f32; 4];

/// Meaning of texels, which decides the quantity that is averaged.
trait Meaning: Send {
    /// Summand of a texel.
    fn decode(texel: [u8; 4]) -> Sum;
    /// Texel of an average.
    fn encode(mean: Sum) -> [u8; 4];
}

/// Colours in linear light 0 to 1 (sRGB) or codes 0 to 255, alpha in codes.
struct Plain<const SRGB: bool>;

/// Colours as those of [`Plain`] times a weight, and the weight `INVISIBLE + (1 - INVISIBLE) * alpha`.
struct Covered<const SRGB: bool>;

/// The components of normals in codes, and the square of their length ([`length_squared`]).
struct Normals;

/// The levels below one of the given size, largest first: none for 1 x 1.
pub(super) fn layout(width: u32, height: u32) -> impl Iterator<Item = LevelLayout> {
    let mut level = LevelLayout { width, height, offset: 0 };
    let mut next_offset = 0;
    std::iter::from_fn(move || {
        if level.width == 1 && level.height == 1 {
            return None;
        }
        level = LevelLayout {
            width: (level.width / 2).max(1),
            height: (level.height / 2).max(1),
            offset: next_offset,
        };
        next_offset += level.width * level.height;
        Some(level)
    })
}

/// Rows of all levels that are made while the rows of an image come in.
pub struct Chain {
    bands: RowBands,
    /// Number of the level that is level 0 of the bands; that of the image is 0.
    finest: usize,
    /// Halvings of the image whose rows are taken.
    halvings: RangeInclusive<u32>,
    /// Layout of the image and its levels, as far as halvings go.
    layout: Vec<LevelLayout>,
    /// Rows of each of the halvings that came in.
    taken: Vec<u32>,
    /// Number of rows of the largest that the bands depend on, from the top.
    rows: u32,
    /// The levels that are made of the last of the halvings.
    levels: Box<dyn Rows>,
    /// Texels of the bands; if all bands are kept, of the levels below the image.
    texels: Vec<[u8; 4]>,
    /// The image, if all bands are kept and it is their level 0.
    image: Option<Vec<[u8; 4]>>,
    /// Cutoff of a mask, whose levels keep their coverage.
    cutoff: Option<f32>,
}

impl Chain {
    /// Starts the `levels` of an image, itself the first, of which the rows in `bands` are kept. Bands have the coarsest
    /// levels alone if they are of fewer. Those of a mask are all kept, and lack the image. Levels up to the number
    /// `halvings` are rows of the halved image as they come, the smaller ones are made of the last of these.
    pub fn new(
        levels: &[LevelLayout],
        bands: RowBands,
        color_space: ColorSpace,
        alpha: AlphaUse,
        halvings: u32,
    ) -> Self {
        let size = levels.first().map(|image| image.width as usize * image.height as usize);
        let finest = levels.len().saturating_sub(bands.levels().len());
        let rows = levels[..finest]
            .iter()
            .rev()
            .fold(bands.source_rows(), |rows, finer| doubled(rows, finer.height));
        let halvings = halvings.min(levels.len().saturating_sub(1) as u32);
        let wanted = bands.finest().map_or(0, |level| finest + level) as u32;
        let halvings = wanted.min(halvings)..=halvings;
        let rows = rows.div_ceil(1 << halvings.start());
        fn of<M: Meaning + 'static>(levels: &[LevelLayout], halvings: u32) -> Box<dyn Rows> {
            let Some((image, levels)) = levels.split_first() else { return Box::new(()) };
            if levels.is_empty() {
                return Box::new(());
            }
            Box::new(Cascade::<M>::new([image.width, image.height], levels, halvings as usize))
        }
        let last = *halvings.end();
        let smaller = levels.get(last as usize..).unwrap_or_default();
        let layout = levels.iter().take(last as usize + 1).copied().collect();
        let levels = match (color_space, alpha) {
            (ColorSpace::Srgb, AlphaUse::Data) => of::<Plain<true>>(smaller, last),
            (ColorSpace::Linear, AlphaUse::Data) => of::<Plain<false>>(smaller, last),
            (ColorSpace::Srgb, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
                of::<Covered<true>>(smaller, last)
            }
            (ColorSpace::Linear, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
                of::<Covered<false>>(smaller, last)
            }
            (_, AlphaUse::Normals) => of::<Normals>(smaller, last),
        };
        let taken = halvings.clone().map(|_| 0).collect();
        let (mut count, mut image) = (bands.texels(), None);
        if let (true, 0, Some(size)) = (bands.are_all(), finest, size) {
            count -= size;
            image = Some(Vec::with_capacity(size));
        }
        let cutoff = match alpha {
            AlphaUse::Mask { cutoff_bits } => Some(f32::from_bits(cutoff_bits)),
            _ => None,
        };
        let texels = vec![[0; 4]; count];
        Self { bands, finest, halvings, layout, taken, rows, levels, texels, image, cutoff }
    }

    /// Halvings of the image whose rows are taken.
    pub fn halvings(&self) -> RangeInclusive<u32> {
        self.halvings.clone()
    }

    /// True if the bands depend on no further row of the image.
    pub fn is_done(&self) -> bool {
        self.taken.first().is_none_or(|&row| row >= self.rows)
    }

    /// Takes the next row of the image, from the top.
    pub fn take(&mut self, row: &[[u8; 4]]) {
        self.take_halved(0, row);
    }

    /// Takes the next row, from the top, of the image at its size halved so often. Of sizes that are not asked for nothing is
    /// taken.
    pub fn take_halved(&mut self, halvings: u32, row: &[[u8; 4]]) {
        let number = halvings.checked_sub(*self.halvings.start());
        let Some(taken) = number.and_then(|number| self.taken.get_mut(number as usize)) else { return };
        let number = *taken;
        *taken += 1;
        let place = match &mut self.image {
            Some(image) if halvings == 0 => {
                image.extend_from_slice(row);
                None
            }
            Some(_) => {
                self.layout.get(halvings as usize).map(|level| (level.offset + number * level.width) as usize)
            }
            None => {
                let level = (halvings as usize).checked_sub(self.finest);
                level.and_then(|level| self.bands.place(level, number))
            }
        };
        if let Some(start) = place {
            self.texels[start..][..row.len()].copy_from_slice(row);
        }
        if halvings == *self.halvings.end() {
            let bands = if self.image.is_some() { None } else { Some((&self.bands, self.finest)) };
            self.levels.take(row, &mut Kept { bands, texels: &mut self.texels });
        }
    }

    /// The kept rows, once all rows are in.
    pub fn finish(self) -> Made {
        let Self { bands, mut texels, mut image, cutoff, .. } = self;
        if image.is_none()
            && bands.are_all()
            && let Some((finest, further)) = bands.levels().split_first()
        {
            let mut rest = texels.split_off(finest.width as usize * finest.height as usize);
            if let Some(cutoff) = cutoff {
                keep_coverage((&texels, [finest.width, finest.height]), further, &mut rest, cutoff);
            }
            image = Some(std::mem::replace(&mut texels, rest));
        }
        Made { bands, texels, image }
    }
}

/// Result of a [`Chain`].
pub struct Made {
    pub bands: RowBands,
    /// Texels of the bands; if all bands are kept, of the levels below the image.
    pub texels: Vec<[u8; 4]>,
    /// The texels of the finest level, if all bands were kept.
    pub image: Option<Vec<[u8; 4]>>,
}

/// Takes the rows of an image and makes levels of them.
trait Rows: Send {
    fn take(&mut self, row: &[[u8; 4]], kept: &mut Kept<'_>);
}

/// No levels.
impl Rows for () {
    fn take(&mut self, _: &[[u8; 4]], _: &mut Kept<'_>) {}
}

/// Destination of the levels: all of them, or some bands, whose finest level has a number.
struct Kept<'a> {
    bands: Option<(&'a RowBands, usize)>,
    texels: &'a mut [[u8; 4]],
}

/// The texels of all levels below the image, one level after the other.
pub(super) fn reduce(
    image: &Image,
    levels: &[LevelLayout],
    color_space: ColorSpace,
    alpha: AlphaUse,
) -> Vec<[u8; 4]> {
    let mut texels = match (color_space, alpha) {
        (ColorSpace::Srgb, AlphaUse::Data) => cascade::<Plain<true>>(image, levels),
        (ColorSpace::Linear, AlphaUse::Data) => cascade::<Plain<false>>(image, levels),
        (ColorSpace::Srgb, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
            cascade::<Covered<true>>(image, levels)
        }
        (ColorSpace::Linear, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
            cascade::<Covered<false>>(image, levels)
        }
        (_, AlphaUse::Normals) => cascade::<Normals>(image, levels),
    };
    if let AlphaUse::Mask { cutoff_bits } = alpha {
        let size = [image.width(), image.height()];
        keep_coverage((image.texels(), size), levels, &mut texels, f32::from_bits(cutoff_bits));
    }
    texels
}

/// The level that is being made of the rows of the one before it.
struct Stage {
    /// Size of the source level.
    source: [u32; 2],
    /// The level itself.
    level: LevelLayout,
    /// Vertical weighted sum of the source rows so far that belong to the next row.
    sums: Vec<Sum>,
    /// Source rows taken.
    taken: u32,
    /// The row last finished.
    row: Vec<Sum>,
    /// Rows finished.
    finished: u32,
    /// Its number; that of the image is 0.
    number: usize,
}

impl Stage {
    fn new(source: [u32; 2], level: LevelLayout, number: usize) -> Self {
        Self {
            source,
            level,
            number,
            sums: vec![[0.0; 4]; source[0] as usize],
            taken: 0,
            row: vec![[0.0; 4]; level.width as usize],
            finished: 0,
        }
    }

    /// Adds the next source row; true if that finished a row.
    fn take(&mut self, source_row: &[Sum]) -> bool {
        let row = self.taken;
        self.taken += 1;
        let height = self.source[1];
        if height == 1 {
            self.sums.copy_from_slice(source_row);
            self.finish_row();
            return true;
        }
        if height.is_multiple_of(2) {
            if row.is_multiple_of(2) {
                self.sums.copy_from_slice(source_row);
                return false;
            }
            add(&mut self.sums, source_row);
            self.finish_row();
            return true;
        }
        let (half, i) = (height / 2, row / 2);
        if !row.is_multiple_of(2) {
            add_weighted(&mut self.sums, source_row, half as f32);
            return false;
        }
        // An even row of an odd height ends one share and begins the next.
        let ends = row > 0;
        if ends {
            add_weighted(&mut self.sums, source_row, i as f32);
            self.finish_row();
        }
        let weight = (half - i) as f32;
        for (sum, source) in self.sums.iter_mut().zip(source_row) {
            *sum = source.map(|s| s * weight);
        }
        ends
    }

    /// Rounds the row last finished into its place, if it is kept.
    fn store<M: Meaning>(&mut self, kept: &mut Kept<'_>) {
        let row = self.finished;
        self.finished += 1;
        let start = match kept.bands {
            None => Some((self.level.offset + row * self.level.width) as usize),
            Some((bands, finest)) => {
                self.number.checked_sub(finest).and_then(|level| bands.place(level, row))
            }
        };
        let Some(start) = start else { return };
        for (to, &sum) in kept.texels[start..].iter_mut().zip(&self.row) {
            *to = M::encode(sum);
        }
    }

    /// Horizontal sums over the vertical ones, divided by the area of a share.
    fn finish_row(&mut self) {
        let [width, height] = self.source;
        let rows = match height {
            1 => 1,
            h if h.is_multiple_of(2) => 2,
            h => h,
        };
        if width == 1 {
            let scale = 1.0 / rows as f32;
            self.row[0] = self.sums[0].map(|s| s * scale);
        } else if width.is_multiple_of(2) {
            let scale = 1.0 / (rows as f32 * 2.0);
            for (to, [a, b]) in self.row.iter_mut().zip(self.sums.as_chunks().0) {
                for (to, (a, b)) in to.iter_mut().zip(a.iter().zip(b)) {
                    *to = (a + b) * scale;
                }
            }
        } else {
            let half = width / 2;
            let scale = 1.0 / (rows as f32 * width as f32);
            for (i, to) in self.row.iter_mut().enumerate() {
                let [a, b, c] = [self.sums[2 * i], self.sums[2 * i + 1], self.sums[2 * i + 2]];
                let weights = [(half - i as u32) as f32, half as f32, (i + 1) as f32];
                *to = std::array::from_fn(|k| {
                    (a[k] * weights[0] + b[k] * weights[1] + c[k] * weights[2]) * scale
                });
            }
        }
    }
}

fn add(sums: &mut [Sum], row: &[Sum]) {
    for (sum, texel) in sums.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
        *sum += texel;
    }
}

fn add_weighted(sums: &mut [Sum], row: &[Sum], weight: f32) {
    for (sum, texel) in sums.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
        *sum += texel * weight;
    }
}

/// Sends the rows of the image through all levels.
fn cascade<M: Meaning>(image: &Image, levels: &[LevelLayout]) -> Vec<[u8; 4]> {
    let count = levels.last().map_or(0, |last| last.offset + last.width * last.height);
    let mut texels = vec![[0; 4]; count as usize];
    let kept = &mut Kept { bands: None, texels: &mut texels };
    let width = image.width() as usize;
    let mut cascade = Cascade::<M>::new([image.width(), image.height()], levels, 0);
    if cascade.is_even {
        for rows in image.texels().chunks_exact(2 * width) {
            let (upper, lower) = rows.split_at(width);
            cascade.take_pair(upper, lower, kept);
        }
    } else {
        image.texels().chunks_exact(width).for_each(|row| cascade.take_row(row, kept));
    }
    texels
}

/// All levels, each made of the one before it.
struct Cascade<M> {
    /// Both sides of the image are even: its rows are taken by pairs.
    is_even: bool,
    /// The first row of a pair.
    upper: Vec<[u8; 4]>,
    decoded: Vec<Sum>,
    stages: Vec<Stage>,
    meaning: std::marker::PhantomData<M>,
}

impl<M: Meaning> Cascade<M> {
    /// Starts the levels of an image of this size, which is level `first` itself.
    fn new([width, height]: [u32; 2], levels: &[LevelLayout], first: usize) -> Self {
        let is_even = width.is_multiple_of(2) && height.is_multiple_of(2) && !levels.is_empty();
        let mut source = [width, height];
        let mut stages = Vec::with_capacity(levels.len());
        for (k, &level) in levels.iter().enumerate() {
            stages.push(Stage::new(source, level, first + k + 1));
            source = [level.width, level.height];
        }
        Self {
            is_even,
            upper: Vec::new(),
            decoded: vec![[0.0; 4]; if is_even { 0 } else { width as usize }],
            stages,
            meaning: std::marker::PhantomData,
        }
    }

    fn take_pair(&mut self, upper: &[[u8; 4]], lower: &[[u8; 4]], kept: &mut Kept<'_>) {
        let Some((first, further)) = self.stages.split_first_mut() else { return };
        halve::<M>(upper, lower, &mut first.row);
        first.store::<M>(kept);
        descend::<M>(further, &first.row, kept);
    }

    fn take_row(&mut self, row: &[[u8; 4]], kept: &mut Kept<'_>) {
        for (to, &texel) in self.decoded.iter_mut().zip(row) {
            *to = M::decode(texel);
        }
        descend::<M>(&mut self.stages, &self.decoded, kept);
    }
}

impl<M: Meaning + Send> Rows for Cascade<M> {
    fn take(&mut self, row: &[[u8; 4]], kept: &mut Kept<'_>) {
        if !self.is_even {
            self.take_row(row, kept);
        } else if self.upper.is_empty() {
            self.upper.extend_from_slice(row);
        } else {
            let mut upper = std::mem::take(&mut self.upper);
            self.take_pair(&upper, row, kept);
            upper.clear();
            self.upper = upper;
        }
    }
}

/// Sends a row down through levels, as far as it finishes rows.
fn descend<M: Meaning>(stages: &mut [Stage], row: &[Sum], kept: &mut Kept<'_>) {
    let mut row = row;
    for stage in stages {
        if !stage.take(row) {
            return;
        }
        stage.store::<M>(kept);
        row = &stage.row;
    }
}

/// The row that two rows of an image of even size make, as a [`Stage`] would make it of them one after the other, with
/// the same bits, but nothing is kept between. Three quarters of all texels pass here.
fn halve<M: Meaning>(upper: &[[u8; 4]], lower: &[[u8; 4]], row: &mut [Sum]) {
    let pairs = upper.as_chunks().0.iter().zip(lower.as_chunks().0);
    for (to, ([a, b], [c, d])) in row.iter_mut().zip(pairs) {
        // Written out: closures over arrays were called and not inlined, and all levels took four times as long.
        let (a, b, c, d) = (M::decode(*a), M::decode(*b), M::decode(*c), M::decode(*d));
        let mean = |k: usize| ((a[k] + c[k]) + (b[k] + d[k])) * 0.25;
        *to = [mean(0), mean(1), mean(2), mean(3)];
    }
}

/// A colour's channel in the unit that is averaged.
#[inline(always)]
fn decode_channel<const SRGB: bool>(code: u8) -> f32 {
    if SRGB { SRGB8_TO_LINEAR[usize::from(code)] } else { f32::from(code) }
}

/// The nearest code of an average of such.
#[inline(always)]
fn encode_channel<const SRGB: bool>(value: f32) -> u8 {
    if SRGB { linear_to_srgb8(value) } else { round(value) }
}

impl<const SRGB: bool> Meaning for Plain<SRGB> {
    #[inline(always)]
    fn decode([r, g, b, a]: [u8; 4]) -> Sum {
        let of = decode_channel::<SRGB>;
        [of(r), of(g), of(b), f32::from(a)]
    }

    #[inline(always)]
    fn encode([r, g, b, a]: Sum) -> [u8; 4] {
        let of = encode_channel::<SRGB>;
        [of(r), of(g), of(b), round(a)]
    }
}

impl<const SRGB: bool> Meaning for Covered<SRGB> {
    #[inline(always)]
    fn decode([r, g, b, a]: [u8; 4]) -> Sum {
        let of = decode_channel::<SRGB>;
        let weight = INVISIBLE + (1.0 - INVISIBLE) / 255.0 * f32::from(a);
        [of(r) * weight, of(g) * weight, of(b) * weight, weight]
    }

    #[inline(always)]
    fn encode([r, g, b, a]: Sum) -> [u8; 4] {
        let scale = 1.0 / a;
        let of = encode_channel::<SRGB>;
        let alpha = round((a - INVISIBLE) * (255.0 / (1.0 - INVISIBLE)));
        [of(r * scale), of(g * scale), of(b * scale), alpha]
    }
}

/// The square of the length of a normal in codes, times 255^2: exact for a texel.
#[inline(always)]
fn length_squared([x, y, z]: [f32; 3]) -> f32 {
    let signed = |code: f32| code * 2.0 - 255.0;
    let (x, y, z) = (signed(x), signed(y), signed(z));
    (x * x + y * y) + z * z
}

impl Meaning for Normals {
    #[inline(always)]
    fn decode([r, g, b, _]: [u8; 4]) -> Sum {
        let normal @ [x, y, z] = [f32::from(r), f32::from(g), f32::from(b)];
        [x, y, z, length_squared(normal)]
    }

    /// The mean of the squares less the square of the mean is the variance of the normals: 0 where all are equal,
    /// whatever rounding has made of their length.
    #[inline(always)]
    fn encode([r, g, b, square]: Sum) -> [u8; 4] {
        let variance = square - length_squared([r, g, b]);
        let deviation = if variance > 0.0 { variance.sqrt() } else { 0.0 };
        [round(r), round(g), round(b), round(255.0 - if deviation < 255.0 { deviation } else { 255.0 })]
    }
}

/// The nearest code.
#[inline(always)]
fn round(code: f32) -> u8 {
    (code + 0.5) as u8
}

/// Scales alpha in every level so that the fraction of texels at or above the cutoff comes as close as possible to that of the
/// image (Castano, "Computing Alpha Mipmaps", 2010). Without this, foliage and fences thin out with distance.
///
/// Only texels are scaled whose share of the image is visible in part. Where all of it is visible or none, the average is on
/// the right side of the cutoff as it is: a gradient keeps its edge within a texel of each level, whatever thin features
/// elsewhere in the image lose. The scale is found exactly: the alpha value that should lie at the cutoff is a quantile.
fn keep_coverage(
    (image, [width, height]): (&[[u8; 4]], [u32; 2]),
    levels: &[LevelLayout],
    texels: &mut [[u8; 4]],
    cutoff: f32,
) {
    // The least visible code. Above 1 or NaN nothing can be kept, at 0 and below everything is visible.
    let Some(visible) = (1..=255_u8).find(|&code| f32::from(code) >= cutoff * 255.0) else { return };
    if cutoff <= 0.0 {
        return;
    }
    let hard: Vec<[u8; 4]> =
        image.iter().map(|texel| [if texel[3] >= visible { 255 } else { 0 }; 4]).collect();
    let first = hard.first().map_or(0, |texel| texel[0]);
    if hard.iter().all(|texel| texel[0] == first) {
        return;
    }
    let Ok(hard) = Image::new(width, height, hard) else { return };
    let coverage = cascade::<Plain<false>>(&hard, levels);
    for level in levels {
        let count = level.width as usize * level.height as usize;
        let texels = &mut texels[level.offset as usize..][..count];
        keep_coverage_of_level(texels, &coverage[level.offset as usize..][..count], visible, cutoff);
    }
}

/// Scales the alpha of one level where the `coverage` of a texel's share is neither 0 nor 255.
fn keep_coverage_of_level(texels: &mut [[u8; 4]], coverage: &[[u8; 4]], visible: u8, cutoff: f32) {
    let is_mixed = |share: &[u8; 4]| (1..=254).contains(&share[0]);
    let (mut histogram, mut wanted) = ([0_u64; 256], 0);
    for (texel, share) in texels.iter().zip(coverage) {
        if is_mixed(share) {
            histogram[usize::from(texel[3])] += 1;
            wanted += u64::from(share[0]);
        }
    }
    let mut above = 0;
    let mut best = (u64::MAX, u16::MAX, 0);
    for least in (1..=256_u16).rev() {
        above += histogram.get(usize::from(least)).copied().unwrap_or(0);
        let key = ((above * 255).abs_diff(wanted), least.abs_diff(u16::from(visible)));
        if key < (best.0, best.1) {
            best = (key.0, key.1, least);
        }
    }
    let least = best.2;
    if least == u16::from(visible) {
        return;
    }
    let scale = cutoff * 255.0 / (f32::from(least) - 0.5);
    for (texel, share) in texels.iter_mut().zip(coverage) {
        if is_mixed(share) {
            let scaled = round(f32::from(texel[3]) * scale);
            // Rounding must not move a texel across the cutoff.
            texel[3] =
                if u16::from(texel[3]) >= least { scaled.max(visible) } else { scaled.min(visible - 1) };
        }
    }
}

#[cfg(test)]
mod tests;
