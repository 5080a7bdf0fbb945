//! Coefficients of a frame, one row of interleaved units after the other.
//!
//! All scans go side by side, each with a reader of its own: a row's coefficients are whole once each has added its part, and
//! those of one row are all that is in memory, of progressive files too.

use super::bits::Bits;
use super::header::{Component, Frame, Part, Scan};
use super::transform::{Block, ZIGZAG};

/// Reader of the coefficients of a frame.
pub struct Coefficients<'a> {
    scans: Vec<Reader<'a>>,
    /// Blocks of each component in the present row of units, row by row.
    pub blocks: Vec<Vec<Block>>,
    /// Row of units that comes next.
    row: usize,
}

/// A scan, as far as it has been read.
struct Reader<'a> {
    scan: Scan<'a>,
    bits: Bits<'a>,
    /// Last first coefficient of each part.
    predictions: [i32; 4],
    /// Blocks that follow without further coefficients in the band.
    ended: u32,
    /// Units before the next restart, if there are restarts.
    left: u32,
    /// Number of the next restart marker.
    marker: u8,
}

impl<'a> Coefficients<'a> {
    /// Reader of a frame's coefficients.
    pub fn new(frame: &Frame<'a>) -> Self {
        let reader = |scan: &Scan<'a>| Reader {
            bits: Bits::new(scan.data),
            predictions: [0; 4],
            ended: 0,
            left: scan.restart,
            marker: 0,
            scan: scan.clone(),
        };
        let [units, _] = frame.units;
        let blocks = |component: &Component| {
            let [x, y] = component.sampling;
            vec![Block::EMPTY; units.saturating_mul(x).saturating_mul(y)]
        };
        Self {
            scans: frame.scans.iter().map(reader).collect(),
            blocks: frame.components.iter().map(blocks).collect(),
            row: 0,
        }
    }

    /// Reads the next row of units. `None` if something is damaged.
    pub fn next_row(&mut self, frame: &Frame<'a>) -> Option<()> {
        self.blocks.iter_mut().flatten().for_each(Block::clear);
        for reader in &mut self.scans {
            reader.row(frame, self.row, &mut self.blocks)?;
            if reader.bits.is_overrun() {
                return None;
            }
        }
        self.row = self.row.wrapping_add(1);
        Some(())
    }
}

impl Reader<'_> {
    fn row(&mut self, frame: &Frame<'_>, row: usize, blocks: &mut [Vec<Block>]) -> Option<()> {
        let [units, _] = frame.units;
        if let [part] = self.scan.parts.as_slice() {
            let part = part.clone();
            let Component { sampling: [x, y], blocks: [columns, rows], .. } =
                *frame.components.get(part.component)?;
            let blocks = blocks.get_mut(part.component)?;
            // Without the blocks that fill up units alone.
            let there = rows.saturating_sub(row.saturating_mul(y)).min(y);
            let stride = units.saturating_mul(x);
            for line in blocks.chunks_mut(stride.max(1)).take(there) {
                for block in line.get_mut(..columns)? {
                    self.begin_unit()?;
                    self.block(&part, 0, block, frame.progressive)?;
                }
            }
            return Some(());
        }
        let parts = self.scan.parts.clone();
        for unit in 0..units {
            self.begin_unit()?;
            for (number, part) in parts.iter().enumerate() {
                let [x, y] = frame.components.get(part.component)?.sampling;
                let blocks = blocks.get_mut(part.component)?;
                let stride = units.saturating_mul(x);
                for line in blocks.chunks_mut(stride.max(1)).take(y) {
                    let start = unit.saturating_mul(x);
                    for block in line.get_mut(start..start.saturating_add(x))? {
                        self.block(part, number, block, frame.progressive)?;
                    }
                }
            }
        }
        Some(())
    }

    /// Passes over the restart marker that is due before a unit.
    fn begin_unit(&mut self) -> Option<()> {
        if self.scan.restart == 0 {
            return Some(());
        }
        if self.left == 0 {
            self.bits.restart(self.marker)?;
            self.marker = self.marker.wrapping_add(1) & 7;
            self.left = self.scan.restart;
            self.predictions = [0; 4];
            self.ended = 0;
        }
        self.left = self.left.wrapping_sub(1);
        Some(())
    }

    #[inline(always)]
    fn block(&mut self, part: &Part, number: usize, block: &mut Block, progressive: bool) -> Option<()> {
        if !progressive {
            self.first(part, number, block)?;
            return self.sequential(part, block);
        }
        match (self.scan.band, self.scan.high) {
            ([0, _], 0) => self.first(part, number, block),
            ([0, _], _) => {
                let [first, ..] = &mut block.coefficients;
                *first |= i16::from(self.bits.bit()) << self.scan.low;
                Some(())
            }
            (_, 0) => self.band(part, block),
            _ => self.refined_band(part, block),
        }
    }

    /// The first coefficient (T.81, F.2.2.1 and G.1.2.1).
    #[inline(always)]
    fn first(&mut self, part: &Part, number: usize, block: &mut Block) -> Option<()> {
        let size = self.bits.symbol(part.dc.as_deref()?)?;
        if size > 15 {
            return None;
        }
        let prediction = self.predictions.get_mut(number)?;
        *prediction = prediction.wrapping_add(self.bits.signed(size.into()));
        let [first, ..] = &mut block.coefficients;
        *first = (*prediction << self.scan.low) as i16;
        Some(())
    }

    /// All other coefficients of a sequential scan (T.81, F.2.2.2).
    #[inline(always)]
    fn sequential(&mut self, part: &Part, block: &mut Block) -> Option<()> {
        let table = part.ac.as_deref()?;
        let mut place = 1_usize;
        while place < 64 {
            let symbol = self.bits.symbol(table)?;
            let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            if size == 0 {
                if run < 15 {
                    break;
                }
                place = place.wrapping_add(16);
                continue;
            }
            place = place.wrapping_add(run);
            let value = self.bits.signed(size);
            let to = usize::from(*ZIGZAG.get(place)?);
            *block.coefficients.get_mut(to)? = value as i16;
            block.last = place as u8;
            place = place.wrapping_add(1);
        }
        Some(())
    }

    /// The first bits of a band (T.81, G.1.2.2).
    #[inline(always)]
    fn band(&mut self, part: &Part, block: &mut Block) -> Option<()> {
        if self.ended > 0 {
            self.ended = self.ended.wrapping_sub(1);
            return Some(());
        }
        let table = part.ac.as_deref()?;
        let [start, end] = self.scan.band.map(usize::from);
        let mut place = start;
        while place <= end {
            let symbol = self.bits.symbol(table)?;
            let (run, size) = (usize::from(symbol >> 4), u32::from(symbol & 15));
            if size == 0 {
                if run < 15 {
                    // This block is the first of them.
                    self.ended = (1_u32 << run).wrapping_sub(1).wrapping_add(self.bits.number(run as u32));
                    break;
                }
                place = place.wrapping_add(16);
                continue;
            }
            place = place.wrapping_add(run);
            let value = self.bits.signed(size);
            let to = usize::from(*ZIGZAG.get(place).filter(|_| place <= end)?);
            *block.coefficients.get_mut(to)? = (value << self.scan.low) as i16;
            block.last = block.last.max(place as u8);
            place = place.wrapping_add(1);
        }
        Some(())
    }

    /// A further bit of a band (T.81, G.1.2.3).
    fn refined_band(&mut self, part: &Part, block: &mut Block) -> Option<()> {
        let table = part.ac.as_deref()?;
        let [start, end] = self.scan.band.map(usize::from);
        let step = 1_i16 << self.scan.low;
        let mut place = start;
        while self.ended == 0 && place <= end {
            let symbol = self.bits.symbol(table)?;
            let (mut run, size) = (symbol >> 4, symbol & 15);
            let value = match size {
                0 if run < 15 => {
                    self.ended = (1_u32 << run).wrapping_add(self.bits.number(run.into()));
                    break;
                }
                0 => 0,
                _ => {
                    if self.bits.bit() {
                        step
                    } else {
                        step.wrapping_neg()
                    }
                }
            };
            // The new one comes behind as many coefficients that were 0 so far.
            while place <= end {
                let to = usize::from(*ZIGZAG.get(place)?);
                let coefficient = block.coefficients.get_mut(to)?;
                place = place.wrapping_add(1);
                if *coefficient != 0 {
                    refine(&mut self.bits, coefficient, step);
                } else if run == 0 {
                    if value != 0 {
                        *coefficient = value;
                        block.last = block.last.max(place.wrapping_sub(1) as u8);
                    }
                    break;
                } else {
                    run = run.wrapping_sub(1);
                }
            }
        }
        if self.ended > 0 {
            for &to in ZIGZAG.get(place..=end).unwrap_or_default() {
                let coefficient = block.coefficients.get_mut(usize::from(to))?;
                if *coefficient != 0 {
                    refine(&mut self.bits, coefficient, step);
                }
            }
            self.ended = self.ended.wrapping_sub(1);
        }
        Some(())
    }
}

/// Adds a bit to the magnitude of a coefficient.
#[inline(always)]
fn refine(bits: &mut Bits<'_>, coefficient: &mut i16, step: i16) {
    if bits.bit() && *coefficient & step == 0 {
        *coefficient = coefficient.wrapping_add(if *coefficient > 0 { step } else { step.wrapping_neg() });
    }
}
