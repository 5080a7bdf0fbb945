//! LAS, the point clouds of airborne and terrestrial laser scans (ASPRS, *LAS Specification 1.4 - R15*): versions 1.0 to 1.4, point
//! formats 0 to 10.
//!
//! Positions are whole numbers with a scale and an offset. Colours have 16 bits, unless none is above 255: then they are of 8,
//! as many programs write them. Points without colours are grey by their intensity or else their class; withheld points are left
//! out, as the specification asks. LAZ is the same inside another compression ([`laz`](super::laz)).

use super::{Scan, color_within, laz};
use crate::mesh_formats::check_input;
use crate::origin::{Region, load_about};
use crate::point_clouds::Measure;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};
use std::borrow::Cow;

const FORMAT: &str = "LAS";
/// Begins every file.
const MAGIC: &[u8; 4] = b"LASF";
/// Least bytes of a point of each format, and the place of its colour.
const FORMATS: [(usize, Option<usize>); 11] = [
    (20, None),
    (28, None),
    (26, Some(20)),
    (34, Some(28)),
    (57, None),
    (63, Some(28)),
    (30, None),
    (36, Some(30)),
    (38, Some(30)),
    (59, None),
    (67, Some(30)),
];
/// Least bytes of a header, up to the bounds of the points.
const HEADER: usize = 227;

/// Bytes of a point of a format, and the place of its colour.
#[cfg(test)]
pub(super) fn layout_of(format: u8) -> (usize, Option<usize>) {
    FORMATS[usize::from(format)]
}

struct Header<'a> {
    format: usize,
    /// Bytes of a point.
    length: usize,
    /// Points by the header.
    points: u64,
    scale: [f64; 3],
    offset: [f64; 3],
    body: Cow<'a, [u8]>,
}

pub(super) fn u16_at(bytes: &[u8], place: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(place..)?.first_chunk()?))
}

pub(super) fn u32_at(bytes: &[u8], place: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(place..)?.first_chunk()?))
}

fn f64_at(bytes: &[u8], place: usize) -> Option<f64> {
    Some(f64::from_le_bytes(*bytes.get(place..)?.first_chunk()?))
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8], context: &Context<'_>, warnings: &mut Warnings) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        if !bytes.starts_with(MAGIC) {
            return Err(malformed("it does not begin with LASF".to_owned()));
        }
        let header =
            bytes.get(..HEADER).ok_or_else(|| malformed("the file ends within the header".to_owned()))?;
        let byte = |place: usize| header.get(place).copied().unwrap_or(0);
        let (major, minor) = (byte(24), byte(25));
        if major != 1 || minor > 4 {
            warnings.add(|| format!("{FORMAT}: version {major}.{minor} is read as 1.4"));
        }
        // LASzip marks its files by the highest bit.
        let is_packed = byte(104) & 0x80 != 0;
        let format = usize::from(byte(104) & 0x7f);
        let Some(&(least, _)) = FORMATS.get(format) else {
            return Err(LoadError::unsupported(FORMAT, format!("point format {format}; 0 to 10 are read")));
        };
        let length = usize::from(u16_at(header, 105).unwrap_or(0));
        if length < least {
            return Err(malformed(format!("points of format {format} in {length} bytes, less than {least}")));
        }
        let mut points = u64::from(u32_at(header, 107).unwrap_or(0));
        if minor >= 4
            && let Some(all) = bytes.get(247..).and_then(|rest| rest.first_chunk())
            && u16_at(header, 94).is_some_and(|size| size >= 255)
        {
            points = points.max(u64::from_le_bytes(*all));
        }
        let start = u32_at(header, 96).unwrap_or(0) as usize;
        let mut body = Cow::Borrowed(bytes.get(start..).unwrap_or_default());
        let three = |first: usize| {
            [0, 8, 16].map(|k: usize| f64_at(header, first.saturating_add(k)).unwrap_or(f64::NAN))
        };
        let (scale, offset) = (three(131), three(155));
        if start < HEADER || scale.iter().chain(&offset).any(|v| !v.is_finite()) {
            return Err(malformed(
                "the place of the points, their scale or their offset is damaged".to_owned(),
            ));
        }
        if is_packed {
            body = Cow::Owned(laz::unpack(bytes, &body, (length, points), context)?);
        }
        Ok(Self { format, length, points, scale, offset, body })
    }

    /// True if the format is one of those with more returns and classes.
    fn is_extended(&self) -> bool {
        self.format >= 6
    }
}

/// Reads a file. One that ends early is drawn as far as it goes, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(bytes, region, context))
}

fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let header = Header::read(bytes, context, &mut warnings)?;
    let there = (header.body.len() as u64).checked_div(header.length as u64).unwrap_or(0);
    if there < header.points {
        let all = counted(header.points, "point");
        if there == 0 {
            return Err(LoadError::malformed(FORMAT, format!("the file ends before the first of {all}")));
        }
        warnings.add(|| format!("{FORMAT}: the file ends after {there} of {all}"));
    }
    let count = there.min(header.points);
    let stride = Scan::stride(FORMAT, context, count, &mut warnings)?;
    let [count, stride] = [count, stride].map(|v| usize::try_from(v).unwrap_or(usize::MAX));
    let records = || header.body.chunks_exact(header.length).take(count).step_by(stride);
    let color_at = FORMATS.get(header.format).and_then(|(_, color)| *color);
    let codes = |record: &[u8]| {
        let place = color_at?;
        Some([0, 2, 4].map(|k: usize| u16_at(record, place.saturating_add(k)).unwrap_or(0)))
    };
    let largest = records().filter_map(codes).flatten().max().unwrap_or(0);
    let range = if largest > 255 { 65535.0 } else { 255.0 };
    let by_intensity = records().any(|record| u16_at(record, 12) != Some(0));
    let mut scan = Scan::default();
    scan.rest.measure = if by_intensity { Measure::Intensity } else { Measure::Class };
    let mut withheld = 0_u64;
    for record in records() {
        let byte = |place: usize| record.get(place).copied().unwrap_or(0);
        let (flag, class) = if header.is_extended() {
            (byte(15) & 4 != 0, byte(16))
        } else {
            (byte(15) & 0x80 != 0, byte(15) & 31)
        };
        if flag {
            withheld = withheld.saturating_add(1);
            continue;
        }
        let [x, y, z] = [0, 4, 8].map(|place| f64::from(u32_at(record, place).unwrap_or(0) as i32));
        let ([sx, sy, sz], [ox, oy, oz]) = (header.scale, header.offset);
        scan.positions.push([x * sx + ox, y * sy + oy, z * sz + oz]);
        if largest > 0 {
            scan.rest.colors.push(color_within(codes(record).unwrap_or_default().map(f32::from), range));
        } else {
            let intensity = f32::from(u16_at(record, 12).unwrap_or(0));
            scan.rest.values.push(if by_intensity { intensity } else { f32::from(class) });
        }
    }
    if withheld > 0 {
        let points = counted(withheld, "withheld point");
        warnings.add(|| format!("{FORMAT}: {points} left out"));
    }
    scan.finish(FORMAT, region, warnings)
}
