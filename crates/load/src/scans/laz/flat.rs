//! Points of formats 0 to 3 (items of version 2): the attributes of a point follow each other in one stream.

use super::arithmetic::{Decoder, Integers, Median, Models};
use crate::scans::las::{u16_at, u32_at};

/// Sequences of times that a file may go back and forth between; a stream that does nothing else is damaged.
const MOST_SWITCHES: u32 = 16;

/// Number of a combination of returns by the number of returns and that of the return (LASzip, `laszip_common_v2`).
const RETURNS: [[u8; 8]; 8] = [
    [15, 14, 13, 12, 11, 10, 9, 8],
    [14, 0, 1, 3, 6, 10, 10, 9],
    [13, 1, 2, 4, 7, 11, 11, 10],
    [12, 3, 4, 5, 8, 12, 12, 11],
    [11, 6, 7, 8, 9, 13, 13, 12],
    [10, 10, 11, 12, 13, 14, 14, 13],
    [9, 10, 11, 12, 13, 14, 15, 14],
    [8, 9, 10, 11, 12, 13, 14, 15],
];

/// Context of a number by the bits of the one before, and whether the pulse has one return alone.
pub(super) fn context_of(size: u32, most: u32, is_single: bool) -> usize {
    let even = if size < most { size & !1 } else { most };
    (even as usize).saturating_add(is_single.into())
}

/// Attributes that every point has.
pub(super) struct Base {
    last: [u8; 20],
    intensities: [u16; 16],
    dx: [Median; 16],
    dy: [Median; 16],
    heights: [i32; 8],
    changes: Models,
    flags: Models,
    classes: Models,
    angles: Models,
    user: Models,
    x: Integers,
    y: Integers,
    z: Integers,
    intensity: Integers,
    source: Integers,
}

impl Base {
    pub(super) fn new(first: &[u8; 20]) -> Self {
        let mut last = *first;
        [last[12], last[13]] = [0; 2];
        Self {
            last,
            intensities: [0; 16],
            dx: [Median::new(); 16],
            dy: [Median::new(); 16],
            heights: [0; 8],
            changes: Models::new(1, 64),
            flags: Models::new(256, 256),
            classes: Models::new(256, 256),
            angles: Models::new(2, 256),
            user: Models::new(256, 256),
            x: Integers::new(32, 2),
            y: Integers::new(32, 22),
            z: Integers::new(32, 20),
            intensity: Integers::new(16, 4),
            source: Integers::new(16, 1),
        }
    }

    /// The next point.
    pub(super) fn next(&mut self, decoder: &mut Decoder<'_>) -> Option<&[u8; 20]> {
        let changes = decoder.symbol(&mut self.changes, 0);
        if changes & 32 != 0 {
            self.last[14] = decoder.symbol_byte(&mut self.flags, self.last[14].into());
        }
        let (number, count) = (usize::from(self.last[14] & 7), usize::from(self.last[14] >> 3 & 7));
        let returns = usize::from(*RETURNS.get(count)?.get(number)?);
        if changes != 0 {
            self.others(decoder, changes, returns)?;
        }
        let is_single = count == 1;
        let (dx, dy) = (self.dx.get_mut(returns)?, self.dy.get_mut(returns)?);
        let by = self.x.next(decoder, dx.get(), is_single.into());
        dx.add(by);
        let x = number_at(&self.last, 0).wrapping_add(by);
        let by = self.y.next(decoder, dy.get(), context_of(self.x.size(), 20, is_single));
        dy.add(by);
        let y = number_at(&self.last, 4).wrapping_add(by);
        let size = self.x.size().wrapping_add(self.y.size()) / 2;
        let height = self.heights.get_mut(count.abs_diff(number))?;
        *height = self.z.next(decoder, *height, context_of(size, 18, is_single));
        let places = self.last.as_chunks_mut::<4>().0;
        for (place, v) in places.iter_mut().zip([x, y, *height]) {
            *place = v.to_le_bytes();
        }
        Some(&self.last)
    }

    /// Attributes beside coordinates and returns.
    fn others(&mut self, decoder: &mut Decoder<'_>, changes: u32, returns: usize) -> Option<()> {
        let last_of = self.intensities.get_mut(returns)?;
        if changes & 16 != 0 {
            *last_of = self.intensity.next(decoder, (*last_of).into(), returns.min(3)) as u16;
        }
        [self.last[12], self.last[13]] = last_of.to_le_bytes();
        if changes & 8 != 0 {
            self.last[15] = decoder.symbol_byte(&mut self.classes, self.last[15].into());
        }
        if changes & 4 != 0 {
            let by = decoder.symbol_byte(&mut self.angles, usize::from(self.last[14] >> 6 & 1));
            self.last[16] = self.last[16].wrapping_add(by);
        }
        if changes & 2 != 0 {
            self.last[17] = decoder.symbol_byte(&mut self.user, self.last[17].into());
        }
        if changes & 1 != 0 {
            let source = u16_at(&self.last, 18).unwrap_or(0);
            let source = self.source.next(decoder, source.into(), 0) as u16;
            [self.last[18], self.last[19]] = source.to_le_bytes();
        }
        Some(())
    }
}

/// The signed number at a place.
pub(super) fn number_at(bytes: &[u8], place: usize) -> i32 {
    u32_at(bytes, place).unwrap_or(0) as i32
}

/// Times, of which nothing is drawn but whose bits are among the others: predicted by multiples of the last difference in one of
/// four sequences.
pub(super) struct Times {
    at: usize,
    newest: usize,
    times: [i64; 4],
    steps: [i32; 4],
    /// Numbers in a row that were far from the prediction.
    surprises: [u32; 4],
    multiples: Models,
    still: Models,
    differences: Integers,
}

impl Times {
    pub(super) fn new(first: &[u8; 8]) -> Self {
        Self {
            at: 0,
            newest: 0,
            times: [i64::from_le_bytes(*first), 0, 0, 0],
            steps: [0; 4],
            surprises: [0; 4],
            multiples: Models::new(1, 516),
            still: Models::new(1, 6),
            differences: Integers::new(32, 9),
        }
    }

    /// The next time.
    pub(super) fn next(&mut self, decoder: &mut Decoder<'_>) -> Option<[u8; 8]> {
        for _ in 0..MOST_SWITCHES {
            let step = *self.steps.get(self.at)?;
            let (code, full) = if step == 0 {
                (decoder.symbol(&mut self.still, 0), 2)
            } else {
                (decoder.symbol(&mut self.multiples, 0), 512)
            };
            if code > full {
                self.at = self.at.wrapping_add((code.wrapping_sub(full)) as usize) & 3;
                continue;
            }
            if code == full {
                self.begin(decoder)?;
            } else if step == 0 {
                self.move_still(decoder, code)?;
            } else {
                self.move_on(decoder, code, step)?;
            }
            return Some(self.times.get(self.at)?.to_le_bytes());
        }
        None
    }

    /// A new sequence, whose first time is stored in full.
    fn begin(&mut self, decoder: &mut Decoder<'_>) -> Option<()> {
        let last = *self.times.get(self.at)?;
        let high = self.differences.next(decoder, (last >> 32) as i32, 8);
        let low = decoder.bits(32);
        self.newest = self.newest.wrapping_add(1) & 3;
        self.at = self.newest;
        *self.times.get_mut(self.at)? = i64::from(high) << 32 | i64::from(low);
        *self.steps.get_mut(self.at)? = 0;
        *self.surprises.get_mut(self.at)? = 0;
        Some(())
    }

    /// A time in a sequence that has no step yet.
    fn move_still(&mut self, decoder: &mut Decoder<'_>, code: u32) -> Option<()> {
        if code == 1 {
            let by = self.differences.next(decoder, 0, 0);
            *self.steps.get_mut(self.at)? = by;
            let time = self.times.get_mut(self.at)?;
            *time = time.wrapping_add(by.into());
            *self.surprises.get_mut(self.at)? = 0;
        }
        Some(())
    }

    /// A time about a multiple of the step after the last one.
    fn move_on(&mut self, decoder: &mut Decoder<'_>, code: u32, step: i32) -> Option<()> {
        let code = code as i32;
        // The multiple, and the context of numbers about it; 511 repeats the time.
        let (multiple, context) = match code {
            0 => (0, 7),
            1 => (1, 1),
            2..=9 => (code, 2),
            10..=499 => (code, 3),
            500 => (500, 4),
            501..=509 => (500_i32.wrapping_sub(code), 5),
            510 => (-10, 6),
            _ => return Some(()),
        };
        let by = self.differences.next(decoder, step.wrapping_mul(multiple), context);
        let surprises = self.surprises.get_mut(self.at)?;
        match context {
            1 => *surprises = 0,
            4 | 6 | 7 => {
                *surprises = surprises.saturating_add(1);
                if *surprises > 3 {
                    *surprises = 0;
                    *self.steps.get_mut(self.at)? = by;
                }
            }
            _ => {}
        }
        let time = self.times.get_mut(self.at)?;
        *time = time.wrapping_add(by.into());
        Some(())
    }
}

/// Models of a colour.
pub(super) struct Colors {
    used: Models,
    bytes: Models,
}

impl Colors {
    pub(super) fn new() -> Self {
        Self { used: Models::new(1, 128), bytes: Models::new(6, 256) }
    }

    /// The colour after one.
    pub(super) fn next(&mut self, decoder: &mut Decoder<'_>, last: [u16; 3]) -> [u16; 3] {
        let used = decoder.symbol(&mut self.used, 0);
        let [red, green, blue] = last.map(u16::to_le_bytes);
        let low = self.byte(decoder, used, 0, red[0], 0);
        let high = self.byte(decoder, used, 1, red[1], 0);
        let now = u16::from_le_bytes([low, high]);
        if used & 64 == 0 {
            return [now; 3];
        }
        let [low_green, low_blue] = self.others(decoder, used, 2, (red[0], low), [green[0], blue[0]]);
        let [high_green, high_blue] = self.others(decoder, used, 3, (red[1], high), [green[1], blue[1]]);
        [now, u16::from_le_bytes([low_green, high_green]), u16::from_le_bytes([low_blue, high_blue])]
    }

    /// Bytes of green and blue, from the last and the present one of red: changes of red are those of green, and the mean of
    /// both that of blue.
    fn others(
        &mut self,
        decoder: &mut Decoder<'_>,
        used: u32,
        place: usize,
        (last, red): (u8, u8),
        [green, blue]: [u8; 2],
    ) -> [u8; 2] {
        let by = i32::from(red).wrapping_sub(last.into());
        let now = self.byte(decoder, used, place, green, by);
        let by = by.wrapping_add(now.into()).wrapping_sub(green.into()) / 2;
        [now, self.byte(decoder, used, place.saturating_add(2), blue, by)]
    }

    /// A byte of a colour: its last value unless it is said to change; then near that plus a change.
    fn byte(&mut self, decoder: &mut Decoder<'_>, used: u32, place: usize, last: u8, by: i32) -> u8 {
        if used >> place & 1 == 0 {
            return last;
        }
        let predicted = i32::from(last).wrapping_add(by).clamp(0, 255) as u8;
        decoder.symbol_byte(&mut self.bytes, place).wrapping_add(predicted)
    }
}
