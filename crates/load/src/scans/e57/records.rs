//! Records of a compressed vector of E57: packets, in each of which every field has a stream of bits.

use super::pages::Pages;

/// Bytes of the header of a section.
const SECTION: usize = 32;
/// Bytes of the header of a packet of data.
const PACKET: usize = 6;

/// Records, some at a time.
#[derive(Debug)]
pub(super) struct Records<'a> {
    pages: Pages<'a>,
    /// Logical place of the next packet.
    place: u64,
    /// Logical end of the section.
    end: u64,
    streams: Vec<Stream>,
    packet: Vec<u8>,
}

/// Values of a field that are not consumed yet.
#[derive(Debug)]
struct Stream {
    /// Bits of a value.
    bits: u32,
    /// Read at all.
    used: bool,
    bytes: Vec<u8>,
    /// Bits that are consumed.
    consumed: u64,
}

impl Stream {
    fn available(&self) -> u64 {
        let bits = (self.bytes.len() as u64).saturating_mul(8).saturating_sub(self.consumed);
        bits.checked_div(self.bits.into()).unwrap_or(u64::MAX)
    }

    /// Bits of the value that is so many behind the first.
    fn value(&self, number: u64) -> u64 {
        let first = number.saturating_mul(self.bits.into()).saturating_add(self.consumed);
        let rest = self.bytes.get((first >> 3) as usize..).unwrap_or_default();
        let all = match rest.first_chunk() {
            Some(&chunk) => u128::from_le_bytes(chunk),
            None => rest.iter().rev().fold(0, |all, &byte| all << 8 | u128::from(byte)),
        };
        let mask = (1_u128 << self.bits).wrapping_sub(1);
        (all >> (first & 7) & mask) as u64
    }

    fn consume(&mut self, values: u64) {
        self.consumed = self.consumed.saturating_add(values.saturating_mul(self.bits.into()));
        let whole = (self.consumed >> 3) as usize;
        // Only when that is most of them, so that a byte is moved a bounded number of times.
        if whole > self.bytes.len() / 2 {
            self.bytes.drain(..whole.min(self.bytes.len()));
            self.consumed &= 7;
        }
    }
}

impl<'a> Records<'a> {
    /// Records in the section at a physical place, of fields of so many bits that are read or not; else a message.
    pub(super) fn new(
        pages: Pages<'a>,
        place: u64,
        fields: impl Iterator<Item = (u32, bool)>,
    ) -> Result<Self, String> {
        let start = pages.logical(place).ok_or("its points begin within a checksum")?;
        let mut header = Vec::with_capacity(SECTION);
        pages.read(start, SECTION, &mut header).ok_or("the file ends before its points")?;
        if header.first() != Some(&1) {
            return Err("there is no section of points where it says".to_owned());
        }
        let word = |at: usize| header.get(at..).and_then(|rest| rest.first_chunk()).copied();
        let [length, data] = [8, 16].map(|at| u64::from_le_bytes(word(at).unwrap_or_default()));
        let place = pages.logical(data).filter(|&place| place > start);
        let place = place.ok_or("its packets are not within its section")?;
        let stream = |(bits, used)| Stream { bits, used, bytes: Vec::new(), consumed: 0 };
        let streams = fields.map(stream).collect();
        Ok(Self { pages, place, end: start.saturating_add(length), streams, packet: Vec::new() })
    }

    /// Reads packets until there are values of each field; says of how many records. `None` at the end, else a message.
    pub(super) fn next(&mut self) -> Result<Option<u64>, String> {
        loop {
            let available = self.streams.iter().filter(|s| s.used).map(Stream::available).min();
            if available.is_some_and(|count| count > 0) {
                return Ok(available);
            }
            if self.place >= self.end {
                return Ok(None);
            }
            self.read_packet()?;
        }
    }

    fn read_packet(&mut self) -> Result<(), String> {
        const ENDS: &str = "the file ends within a packet";
        self.packet.clear();
        self.pages.read(self.place, 4, &mut self.packet).ok_or(ENDS)?;
        let &[kind, _, low, high] = self.packet.first_chunk().ok_or(ENDS)?;
        let length = usize::from(u16::from_le_bytes([low, high])).saturating_add(1);
        match kind {
            // Packets of an index, and empty ones.
            0 | 2 => {}
            1 => {
                self.packet.clear();
                self.pages.read(self.place, length, &mut self.packet).ok_or(ENDS)?;
                distribute(&self.packet, &mut self.streams)
                    .ok_or("the streams of a packet are not within it")?;
            }
            _ => return Err(format!("a packet is of the unknown kind {kind}")),
        }
        // Packets begin at multiples of four bytes.
        self.place = self.place.saturating_add((length as u64).saturating_add(3) & !3);
        Ok(())
    }

    /// Bits of the value of a field, so many records behind the first.
    pub(super) fn value(&self, field: usize, number: u64) -> u64 {
        self.streams.get(field).map_or(0, |stream| stream.value(number))
    }

    /// Goes on by so many records.
    pub(super) fn consume(&mut self, count: u64) {
        self.streams.iter_mut().filter(|stream| stream.used).for_each(|stream| stream.consume(count));
    }
}

/// Appends the parts of a packet to the streams that they belong to.
fn distribute(packet: &[u8], streams: &mut [Stream]) -> Option<()> {
    let count = u16::from_le_bytes(*packet.get(4..)?.first_chunk()?);
    if usize::from(count) != streams.len() {
        return None;
    }
    let (sizes, mut rest) = packet.get(PACKET..)?.split_at_checked(streams.len().checked_mul(2)?)?;
    for (stream, &size) in streams.iter_mut().zip(sizes.as_chunks().0) {
        let (part, after) = rest.split_at_checked(u16::from_le_bytes(size).into())?;
        if stream.used {
            stream.bytes.extend_from_slice(part);
        }
        rest = after;
    }
    Some(())
}
