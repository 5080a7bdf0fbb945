//! Segments of a JPEG file (ITU-T T.81, annex B): its frame, tables, and where its scans begin.

use super::bits::Huffman;
use super::transform::ZIGZAG;
use std::sync::Arc;

/// Most scans of a frame: as many as a progression of three components in all bits and bands has, and more.
const MOST_SCANS: usize = 64;

/// A component of a frame.
#[derive(Clone, Debug)]
pub struct Component {
    id: u8,
    /// Sampling factors, columns and rows: blocks in an interleaved unit.
    pub sampling: [usize; 2],
    /// Blocks that its samples take, columns and rows: those of a scan of this component alone.
    pub blocks: [usize; 2],
    table: u8,
    /// Steps of quantization, in rows. From before the first scan on they stay.
    pub steps: [f32; 64],
}

/// A component within a scan.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its number in the frame.
    pub component: usize,
    pub dc: Option<Arc<Huffman>>,
    pub ac: Option<Arc<Huffman>>,
}

/// A scan.
#[derive(Clone, Debug)]
pub struct Scan<'a> {
    pub parts: Vec<Part>,
    /// First and last coefficient, in zigzag.
    pub band: [u8; 2],
    /// Bits that follow: before this scan (0: this one is the first) and after it.
    pub high: u8,
    pub low: u8,
    /// Units between restarts; 0: none.
    pub restart: u32,
    /// Entropy-coded data, and what follows.
    pub data: &'a [u8],
}

/// A frame whose scans have been found.
#[derive(Clone, Debug)]
pub struct Frame<'a> {
    pub size: [u32; 2],
    pub progressive: bool,
    /// One, or three: luma and two of chroma.
    pub components: Vec<Component>,
    /// Interleaved units, columns and rows.
    pub units: [usize; 2],
    pub scans: Vec<Scan<'a>>,
}

/// Tables that segments define, by their numbers.
#[derive(Default)]
struct Tables {
    quantization: [Option<[f32; 64]>; 4],
    dc: [Option<Arc<Huffman>>; 4],
    ac: [Option<Arc<Huffman>>; 4],
    restart: u32,
}

/// Reads a file up to its end. `None` if it is none of the kind that is read here: Huffman codes, 8 bits, grey or YCbCr, chroma
/// at all or half of the columns and rows.
pub fn read(bytes: &[u8]) -> Option<Frame<'_>> {
    let mut rest = bytes.strip_prefix(&[0xff, 0xd8])?;
    let mut tables = Tables::default();
    let mut frame: Option<Frame<'_>> = None;
    loop {
        let at = rest.iter().position(|&byte| byte != 0xff).filter(|&at| at > 0)?;
        let (&marker, after) = rest.get(at..)?.split_first()?;
        if marker == 0xd9 {
            return frame.filter(is_whole);
        }
        let length = usize::from(u16::from_be_bytes(*after.first_chunk()?));
        let segment = after.get(2..length)?;
        rest = after.get(length..)?;
        match marker {
            0xdb if frame.as_ref().is_none_or(|frame| frame.scans.is_empty()) => {
                tables.read_quantization(segment)?;
            }
            0xc4 => tables.read_codes(segment)?,
            0xdd => tables.restart = u16::from_be_bytes(segment.try_into().ok()?).into(),
            0xc0..=0xc2 if frame.is_none() => frame = Some(read_frame(segment, marker == 0xc2)?),
            0xda => {
                let frame = frame.as_mut()?;
                let scan = tables.scan(frame, segment, rest)?;
                frame.scans.push(scan);
                if frame.scans.len() > MOST_SCANS {
                    return None;
                }
                rest = after_scan(rest)?;
            }
            // Adobe's: 1 is YCbCr.
            0xee if segment.starts_with(b"Adobe") && segment.get(11) != Some(&1) => return None,
            0xe0..=0xef | 0xfe => {}
            _ => return None,
        }
    }
}

/// Data from the marker on that ends a scan.
fn after_scan(mut data: &[u8]) -> Option<&[u8]> {
    loop {
        let at = data.iter().position(|&byte| byte == 0xff)?;
        data = data.get(at..)?;
        match data {
            [_, 0 | 0xd0..=0xd7, rest @ ..] => data = rest,
            [_, 0xff, ..] => data = data.get(1..)?,
            _ => return Some(data),
        }
    }
}

/// True if each component has a scan.
fn is_whole(frame: &Frame<'_>) -> bool {
    let has_scan = |number: usize| {
        let begins = |scan: &Scan<'_>| matches!(scan.band, [0, _]) && scan.high == 0;
        let scans = frame.scans.iter().filter(|scan| begins(scan));
        scans.flat_map(|scan| &scan.parts).filter(|part| part.component == number).count() == 1
    };
    (0..frame.components.len()).all(has_scan)
}

fn read_frame(segment: &[u8], progressive: bool) -> Option<Frame<'static>> {
    let (&[8, h1, h0, w1, w0, count], rest) = segment.split_first_chunk()? else { return None };
    let [width, height] = [[w1, w0], [h1, h0]].map(|side| u32::from(u16::from_be_bytes(side)));
    if width == 0
        || height == 0
        || !matches!(count, 1 | 3)
        || rest.len() != usize::from(count).checked_mul(3)?
    {
        return None;
    }
    let mut components = Vec::with_capacity(3);
    for &[id, factors, table] in rest.as_chunks::<3>().0 {
        // Sampling factors mean nothing with a single component (ITU-T T.81, A.2.2).
        let factors = if count == 1 { 0x11 } else { factors };
        let sampling = [factors >> 4, factors & 15].map(usize::from);
        components.push(Component { id, sampling, blocks: [0; 2], table, steps: [0.0; 64] });
    }
    if components.iter().map(|component| component.id).eq(*b"RGB") {
        return None;
    }
    let most = components.first()?.sampling;
    let is_read = |component: &Component| {
        // All or half of the first component's samples.
        let is_part = |(own, most): (&usize, &usize)| own == most || own.checked_mul(2) == Some(*most);
        component.sampling.iter().zip(&most).all(is_part)
    };
    if !matches!(most, [1 | 2, 1 | 2]) || !components.iter().all(is_read) {
        return None;
    }
    let samples = [width as usize, height as usize];
    let units = |axis: usize| Some(samples.get(axis)?.div_ceil(most.get(axis)?.checked_mul(8)?));
    for component in &mut components {
        let [[x, y], [most_x, most_y], [width, height]] = [component.sampling, most, samples];
        let blocks = |samples: usize, own: usize, most: usize| {
            Some(samples.checked_mul(own)?.div_ceil(most).div_ceil(8))
        };
        component.blocks = [blocks(width, x, most_x)?, blocks(height, y, most_y)?];
    }
    let units = [units(0)?, units(1)?];
    Some(Frame { size: [width, height], progressive, components, units, scans: Vec::new() })
}

impl Tables {
    fn read_quantization(&mut self, mut segment: &[u8]) -> Option<()> {
        while let Some((&kind, rest)) = segment.split_first() {
            let table = self.quantization.get_mut(usize::from(kind & 15))?;
            let mut steps = [0.0; 64];
            let values: Vec<u16> = if kind >> 4 == 0 {
                rest.get(..64)?.iter().copied().map(u16::from).collect()
            } else {
                rest.get(..128)?.as_chunks().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect()
            };
            for (&place, &value) in ZIGZAG.iter().zip(&values) {
                *steps.get_mut(usize::from(place))? = f32::from(value);
            }
            *table = Some(steps);
            segment = rest.get(if kind >> 4 == 0 { 64 } else { 128 }..)?;
        }
        Some(())
    }

    fn read_codes(&mut self, mut segment: &[u8]) -> Option<()> {
        while let Some((&kind, rest)) = segment.split_first() {
            let (counts, rest) = rest.split_first_chunk::<16>()?;
            let total = counts.iter().map(|&count| usize::from(count)).sum();
            let (symbols, rest) = rest.split_at_checked(total)?;
            let tables = if kind >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            *tables.get_mut(usize::from(kind & 15))? = Some(Arc::new(Huffman::new(counts, symbols)?));
            segment = rest;
        }
        Some(())
    }

    /// The scan of a SOS segment; the components that begin with it get their steps of quantization.
    fn scan<'a>(&self, frame: &mut Frame<'_>, segment: &[u8], data: &'a [u8]) -> Option<Scan<'a>> {
        let (&count, rest) = segment.split_first()?;
        let (selectors, &[start, end, bits]) = rest.split_last_chunk()?;
        if selectors.len() != usize::from(count).checked_mul(2)? || count == 0 {
            return None;
        }
        let mut parts: Vec<Part> = Vec::with_capacity(3);
        for &[id, tables] in selectors.as_chunks().0 {
            let component = frame.components.iter().position(|component| component.id == id)?;
            if parts.iter().any(|part| part.component >= component) {
                return None;
            }
            let [dc, ac] = [(&self.dc, tables >> 4), (&self.ac, tables & 15)]
                .map(|(tables, number)| tables.get(usize::from(number)).cloned().flatten());
            parts.push(Part { component, dc, ac });
            let component = frame.components.get_mut(component)?;
            component.steps = (*self.quantization.get(usize::from(component.table))?)?;
        }
        let [high, low] = [bits >> 4, bits & 15];
        let fits = if frame.progressive {
            let is_band = if start == 0 { end == 0 } else { start <= end && end < 64 && parts.len() == 1 };
            is_band && low < 14 && (high == 0 || Some(high) == low.checked_add(1))
        } else {
            [start, end, bits] == [0, 63, 0]
        };
        let uses_dc = start == 0 && high == 0;
        let uses_ac = !frame.progressive || start > 0;
        let has_tables = |part: &Part| (!uses_dc || part.dc.is_some()) && (!uses_ac || part.ac.is_some());
        (fits && parts.iter().all(has_tables)).then_some(Scan {
            parts,
            band: [start, end],
            high,
            low,
            restart: self.restart,
            data,
        })
    }
}
