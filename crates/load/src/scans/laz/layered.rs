//! Points of formats 6 to 10 (items of versions 3 and 4): each attribute has a stream of its own, so that those of which nothing
//! is drawn are skipped.

use super::arithmetic::{Decoder, Integers, Median, Models};
use super::flat::{Colors, context_of, number_at};
use super::{Items, Records};
use crate::scans::las::u16_at;

/// Streams of the attributes that every point has: coordinates and returns, z, class, flags, intensity, and four that are
/// skipped (scan angle, user data, source, time).
const BASE_LAYERS: usize = 9;

/// Number of a combination of returns by the number of returns and that of the return (LASzip, `laszip_common_v3`).
const RETURNS: [[u8; 16]; 16] = [
    [0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5],
    [1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
    [2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3],
    [3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5],
];

/// A point, as far as it matters.
#[derive(Clone, Copy, Default)]
struct Point {
    position: [i32; 3],
    number: u8,
    count: u8,
    flags: u8,
    channel: u8,
    class: u8,
    intensity: u16,
    /// True where the time is another one than that of the point before.
    moved_on: bool,
}

impl Point {
    fn read(bytes: &[u8; 30]) -> Self {
        let [returns, flags, class] = [bytes[14], bytes[15], bytes[16]];
        Self {
            position: [0, 4, 8].map(|place| number_at(bytes, place)),
            number: returns & 15,
            count: returns >> 4,
            // Without the channel, which is stored beside them.
            flags: flags & 15 | flags >> 6 << 4,
            channel: flags >> 4 & 3,
            class,
            intensity: u16_at(bytes, 12).unwrap_or(0),
            moved_on: false,
        }
    }

    /// First, last, only or another return of its pulse.
    fn place(&self) -> usize {
        usize::from(self.number == 1) | usize::from(self.number >= self.count) << 1
    }

    /// The record of a point, without what is skipped.
    fn record(&self) -> [u8; 30] {
        let mut record = [0; 30];
        for (place, v) in record.as_chunks_mut::<4>().0.iter_mut().zip(self.position) {
            *place = v.to_le_bytes();
        }
        [record[12], record[13]] = self.intensity.to_le_bytes();
        record[14] = self.count << 4 | self.number & 15;
        record[15] = self.flags & 15 | self.channel << 4 | self.flags >> 4 << 6;
        record[16] = self.class;
        record
    }
}

/// Models of one channel of the scanner, and its last point.
struct Channel {
    last: Point,
    intensities: [u16; 8],
    dx: [Median; 12],
    dy: [Median; 12],
    heights: [i32; 8],
    changes: Models,
    switches: Models,
    counts: Models,
    numbers: Models,
    numbers_at_once: Models,
    classes: Models,
    flags: Models,
    x: Integers,
    y: Integers,
    z: Integers,
    intensity: Integers,
}

impl Channel {
    fn new(last: Point) -> Self {
        Self {
            last: Point { moved_on: false, ..last },
            intensities: [last.intensity; 8],
            dx: [Median::new(); 12],
            dy: [Median::new(); 12],
            heights: [last.position[2]; 8],
            changes: Models::new(8, 128),
            switches: Models::new(1, 3),
            counts: Models::new(16, 16),
            numbers: Models::new(16, 16),
            numbers_at_once: Models::new(1, 13),
            classes: Models::new(64, 256),
            flags: Models::new(64, 64),
            x: Integers::new(32, 2),
            y: Integers::new(32, 22),
            z: Integers::new(32, 20),
            intensity: Integers::new(16, 4),
        }
    }

    /// The numbers of returns and of the return.
    fn returns(&mut self, decoder: &mut Decoder<'_>, changes: u32, moved_on: bool) {
        let last = &mut self.last;
        if changes & 4 != 0 {
            last.count = decoder.symbol_byte(&mut self.counts, last.count.into()) & 15;
        }
        let by = match changes & 3 {
            0 => 0,
            1 => 1,
            2 => 15,
            _ if moved_on => {
                last.number = decoder.symbol_byte(&mut self.numbers, last.number.into()) & 15;
                return;
            }
            _ => decoder.symbol_byte(&mut self.numbers_at_once, 0).wrapping_add(2),
        };
        last.number = last.number.wrapping_add(by) & 15;
    }
}

/// Decoders of the streams that are read; `None` for attributes that do not change.
struct Layers<'a> {
    position: Decoder<'a>,
    z: Option<Decoder<'a>>,
    class: Option<Decoder<'a>>,
    flags: Option<Decoder<'a>>,
    intensity: Option<Decoder<'a>>,
    color: Option<Decoder<'a>>,
}

/// Decodes one chunk into records, and returns what follows it; `None` where the file ends or is damaged.
pub(super) fn chunk<'a>(
    bytes: &'a [u8],
    items: &Items,
    most: u64,
    records: &mut Records,
) -> Option<&'a [u8]> {
    let (first, rest) = bytes.split_at_checked(items.size)?;
    records.push(first);
    let (count, mut rest) = rest.split_first_chunk()?;
    let count = u64::from(u32::from_le_bytes(*count));
    let mut sizes = Vec::with_capacity(items.layers);
    for _ in 0..items.layers {
        let (size, after) = rest.split_first_chunk()?;
        sizes.push(u32::from_le_bytes(*size) as usize);
        rest = after;
    }
    let mut streams = Vec::with_capacity(items.layers);
    for size in sizes {
        let (stream, after) = rest.split_at_checked(size)?;
        streams.push(stream);
        rest = after;
    }
    let layer = |place: usize| streams.get(place).filter(|bytes| !bytes.is_empty());
    let open = |place: usize| layer(place).map(|bytes| Decoder::new(bytes));
    let mut layers = Layers {
        position: Decoder::new(layer(0).copied().unwrap_or_default()),
        z: open(1),
        class: open(2),
        flags: open(3),
        intensity: open(4),
        color: items.color.and_then(|_| open(BASE_LAYERS)),
    };
    let mut channels = Channels::new(first, items)?;
    for _ in 1..count.min(most) {
        let Some(()) = channels.next(&mut layers, items, records) else { break };
    }
    Some(rest)
}

/// Models of the colours of a channel, and the last one.
type Painted = (Colors, [u16; 3]);

/// The channels of a chunk, and the colours beside them.
struct Channels {
    list: [Option<Box<Channel>>; 4],
    at: usize,
    colors: [Option<Box<Painted>>; 4],
    color_at: usize,
}

impl Channels {
    fn new(first: &[u8], items: &Items) -> Option<Self> {
        let point = Point::read(first.first_chunk()?);
        let at = usize::from(point.channel);
        let mut channels = Self { list: Default::default(), at, colors: Default::default(), color_at: at };
        *channels.list.get_mut(at)? = Some(Box::new(Channel::new(point)));
        if let Some(place) = items.color {
            let color = [0, 2, 4].map(|k: usize| u16_at(first, place.saturating_add(k)).unwrap_or(0));
            *channels.colors.get_mut(at)? = Some(Box::new((Colors::new(), color)));
        }
        Some(channels)
    }

    /// Adds the record of the next point.
    fn next(&mut self, layers: &mut Layers<'_>, items: &Items, records: &mut Records) -> Option<()> {
        let decoder = &mut layers.position;
        let channel = self.list.get_mut(self.at)?.as_mut()?;
        let kind = channel.last.place() | usize::from(channel.last.moved_on) << 2;
        let changes = decoder.symbol(&mut channel.changes, kind);
        let switches = changes & 64 != 0;
        if switches {
            let by = decoder.symbol(&mut channel.switches, 0) as usize;
            let last = channel.last;
            self.at = self.at.wrapping_add(by).wrapping_add(1) & 3;
            let channel = self.list.get_mut(self.at)?;
            let channel = channel.get_or_insert_with(|| Box::new(Channel::new(last)));
            channel.last.channel = self.at as u8;
        }
        // Up to version 3 other attributes are of channel 0 unless the channel changes, by an oversight that became the format.
        let of_color = if switches || items.version > 3 { self.at } else { 0 };
        let channel = self.list.get_mut(self.at)?.as_mut()?;
        let point = base(channel, layers, changes)?;
        let mut record = point.record().to_vec();
        record.resize(items.size, 0);
        if let Some(place) = items.color {
            let color = self.color(of_color, items, layers.color.as_mut())?;
            let slots = record.get_mut(place..).unwrap_or_default().as_chunks_mut::<2>().0;
            slots.iter_mut().zip(color).for_each(|(slot, v)| *slot = v.to_le_bytes());
        }
        let is_cut = |decoder: &Option<Decoder<'_>>| decoder.as_ref().is_some_and(Decoder::is_cut);
        let others = [&layers.z, &layers.class, &layers.flags, &layers.intensity, &layers.color];
        if layers.position.is_cut() || others.into_iter().any(is_cut) {
            return None;
        }
        records.push(&record);
        Some(())
    }

    /// The colour of the next point.
    fn color(&mut self, at: usize, items: &Items, decoder: Option<&mut Decoder<'_>>) -> Option<[u16; 3]> {
        let mut last_at = self.color_at;
        if at != last_at {
            self.color_at = at;
            let last = self.colors.get(last_at)?.as_ref()?.1;
            let slot = self.colors.get_mut(at)?;
            if slot.is_none() {
                *slot = Some(Box::new((Colors::new(), last)));
                last_at = at;
            }
            // Version 3 goes on from the colour of the other channel.
            if items.version > 3 {
                last_at = at;
            }
        }
        let last = self.colors.get(last_at)?.as_ref()?.1;
        let Some(decoder) = decoder else { return Some(last) };
        let color = self.colors.get_mut(at)?.as_mut()?.0.next(decoder, last);
        self.colors.get_mut(last_at)?.as_mut()?.1 = color;
        Some(color)
    }
}

/// Attributes that every point has.
fn base(channel: &mut Channel, layers: &mut Layers<'_>, changes: u32) -> Option<Point> {
    let decoder = &mut layers.position;
    let moved_on = changes & 16 != 0;
    channel.returns(decoder, changes, moved_on);
    let last = &mut channel.last;
    let (count, number) = (usize::from(last.count), usize::from(last.number));
    let returns = usize::from(*RETURNS.get(count)?.get(number)?) << 1 | usize::from(moved_on);
    let is_single = count == 1;
    // First, last, only or another return of its pulse, in another order than above.
    let place = usize::from(number == 1) << 1 | usize::from(number >= count);
    let (dx, dy) = (channel.dx.get_mut(returns)?, channel.dy.get_mut(returns)?);
    let by = channel.x.next(decoder, dx.get(), is_single.into());
    dx.add(by);
    last.position[0] = last.position[0].wrapping_add(by);
    let by = channel.y.next(decoder, dy.get(), context_of(channel.x.size(), 20, is_single));
    dy.add(by);
    last.position[1] = last.position[1].wrapping_add(by);
    if let Some(decoder) = &mut layers.z {
        let size = channel.x.size().wrapping_add(channel.y.size()) / 2;
        let height = channel.heights.get_mut(count.abs_diff(number).min(7))?;
        *height = channel.z.next(decoder, *height, context_of(size, 18, is_single));
        last.position[2] = *height;
    }
    if let Some(decoder) = &mut layers.class {
        let context = usize::from(last.class & 31) << 1 | usize::from(place == 3);
        last.class = decoder.symbol_byte(&mut channel.classes, context);
    }
    if let Some(decoder) = &mut layers.flags {
        last.flags = decoder.symbol_byte(&mut channel.flags, last.flags.into()) & 63;
    }
    if let Some(decoder) = &mut layers.intensity {
        let last_of = channel.intensities.get_mut(place << 1 | usize::from(moved_on))?;
        *last_of = channel.intensity.next(decoder, (*last_of).into(), place) as u16;
        last.intensity = *last_of;
    }
    last.moved_on = moved_on;
    Some(*last)
}
