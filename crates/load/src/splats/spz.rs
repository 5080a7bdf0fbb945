//! SPZ, the compressed splats of Niantic (github.com/nianticlabs/spz, README: "File Format"), versions 1 to 4.
//!
//! Attributes lie one after the other: positions in fixed point of 24 bits (half floats in version 1), opacities, colours,
//! logarithms of standard deviations, quaternions, harmonics as bytes. Up to version 3 all of it is inside gzip, which is
//! unpacked before; version 4 has Zstandard around each attribute. Coordinates are right, up, back, unless the extension
//! `SPZ_ADOBE_coordinate_system` names others.

use super::{Bytes, u16_at, u32_at, with_largest};
use crate::budget::Budget;
use crate::mesh_formats::check_input;
use crate::packed::unzstd;
use crate::splat_clouds::{Cloud, DEGREE_0, coefficients};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};
use overcoat_core::math::half::half_to_f32;
use overcoat_core::math::scalar::exp;
use overcoat_scene::{Axis, Splat};
use std::borrow::Cow;

const FORMAT: &str = "SPZ";
/// Bytes of the header up to version 3.
const HEADER: u64 = 16;
/// Bytes of the header of version 4.
const HEADER_4: u64 = 32;
/// Flag of extensions.
const EXTENSIONS: u8 = 2;
/// Extension that names the axes.
const COORDINATES: u32 = 0xadbe_0003;
/// Axis that is up without that extension, and whether its front is the back.
const USUAL: (Axis, bool) = (Axis::PositiveY, true);
/// Factor of colours: bytes hold somewhat more than 0 to 1.
const COLOR_SCALE: f32 = 0.15;
/// Names of the attributes, in the order of the file.
const NAMES: [&str; 6] = ["positions", "opacities", "colours", "scales", "rotations", "spherical harmonics"];

/// Header of a file.
struct Header {
    version: u32,
    count: u64,
    degree: u8,
    fraction: u8,
    flags: u8,
    streams: u8,
}

impl Header {
    fn read(bytes: &mut Bytes<'_>) -> Result<Self, LoadError> {
        let header = bytes.take(HEADER, "header")?;
        let byte = |place: usize| header.get(place).copied().unwrap_or(0);
        let version = u32_at(header, 4);
        if !(1..=4).contains(&version) {
            return Err(LoadError::unsupported(FORMAT, format!("version {version}; 1 to 4 are read")));
        }
        let (degree, fraction) = (byte(12), byte(13));
        if degree > 4 || fraction > 24 {
            let message =
                format!("degree {degree} of harmonics (most: 4), {fraction} bits of fractions (most: 24)");
            return Err(LoadError::malformed(FORMAT, message));
        }
        let count = u64::from(u32_at(header, 8));
        Ok(Self { version, count, degree, fraction, flags: byte(14), streams: byte(15) })
    }

    /// Coefficients of one colour that are stored for each splat.
    fn stored(&self) -> u64 {
        if self.degree > 3 { 24 } else { coefficients(self.degree) as u64 }
    }

    /// Bytes of each attribute for each splat.
    fn sizes(&self) -> [u64; NAMES.len()] {
        let position = if self.version == 1 { 6 } else { 9 };
        let rotation = if self.version < 3 { 3 } else { 4 };
        [position, 1, 3, 3, rotation, self.stored().saturating_mul(3)]
    }
}

/// Reads a file.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut warnings = Warnings::default();
    let mut reader = Bytes { format: FORMAT, rest: bytes };
    let header = Header::read(&mut reader)?;
    // Before anything of that size is unpacked.
    let degree = header.degree.min(3);
    let cloud = Cloud::new(FORMAT, header.count, degree, context)?;
    let (attributes, extensions) = if header.version < 4 {
        plain(&header, &mut reader, &mut warnings)?
    } else {
        packed(&header, &mut reader, context)?
    };
    let has_extensions = header.flags & EXTENSIONS != 0;
    let (up, is_turned) = if has_extensions { axes_of(extensions, &mut warnings)? } else { USUAL };
    if header.degree > degree {
        warnings
            .add(|| format!("{FORMAT}: harmonics of degree {} drawn up to degree {degree}", header.degree));
    }
    if header.flags & !(EXTENSIONS | 1) != 0 {
        warnings.add(|| format!("{FORMAT}: unknown flags {:#x} have no effect", header.flags));
    }
    let loaded = fill(cloud, &header, &attributes).finish(up, warnings)?;
    Ok(Loaded { is_turned, ..loaded })
}

type Attributes<'a> = [Cow<'a, [u8]>; NAMES.len()];

/// The attributes up to version 3, and what follows them. Harmonics that are missing are left out, with a warning.
fn plain<'a>(
    header: &Header,
    reader: &mut Bytes<'a>,
    warnings: &mut Warnings,
) -> Result<(Attributes<'a>, &'a [u8]), LoadError> {
    let mut attributes: Attributes<'a> = Default::default();
    for ((attribute, size), name) in attributes.iter_mut().zip(header.sizes()).zip(NAMES) {
        let size = header.count.saturating_mul(size);
        if name == NAMES[5] && (reader.rest.len() as u64) < size {
            warnings.add(|| format!("{FORMAT}: the file ends within the {name}, which are left out"));
            return Ok((attributes, &[]));
        }
        *attribute = Cow::Borrowed(reader.take(size, name)?);
    }
    Ok((attributes, reader.rest))
}

/// The attributes of version 4, unpacked, and the extensions.
fn packed<'a>(
    header: &Header,
    reader: &mut Bytes<'a>,
    context: &Context<'_>,
) -> Result<(Attributes<'static>, &'a [u8]), LoadError> {
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let place = u64::from(u32_at(reader.take(HEADER_4.saturating_sub(HEADER), "header")?, 0));
    let Some(between) = place.checked_sub(HEADER_4) else {
        return Err(malformed(format!("the table of streams is at byte {place}, in the header")));
    };
    let extensions = reader.take(between, "extensions")?;
    let sizes = header.sizes();
    let expected: Vec<usize> =
        (0..NAMES.len()).filter(|&k| sizes.get(k).is_some_and(|&size| size > 0)).collect();
    // A stream without content may be there or not.
    if usize::from(header.streams) != expected.len() && usize::from(header.streams) != NAMES.len() {
        return Err(malformed(format!("{} streams in place of {}", header.streams, expected.len())));
    }
    let table = reader.take(u64::from(header.streams).saturating_mul(16), "table of streams")?;
    let mut budget = Budget::new(context.limits);
    let mut attributes: Attributes<'static> = Default::default();
    let all = usize::from(header.streams) == NAMES.len();
    let places: Vec<usize> = if all { (0..NAMES.len()).collect() } else { expected };
    for (entry, place) in table.as_chunks::<16>().0.iter().zip(places) {
        let (Some(name), Some(each)) = (NAMES.get(place), sizes.get(place)) else { continue };
        let [a, b, c, d, e, f, g, h, k, l, m, n, o, p, q, r] = *entry;
        let stored = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
        let size = u64::from_le_bytes([k, l, m, n, o, p, q, r]);
        let needed = header.count.saturating_mul(*each);
        if size != needed {
            return Err(malformed(format!("the {name} claim {size} bytes, not {needed}")));
        }
        let stream = reader.take(stored, name)?;
        budget.charge(|| format!("{FORMAT}: the {name}"), size, 1)?;
        let content = unzstd(stream, size).map_err(|reason| malformed(format!("the {name}: {reason}")))?;
        if content.len() as u64 != size {
            return Err(malformed(format!("the {name} have {} bytes, not {size}", content.len())));
        }
        if let Some(attribute) = attributes.get_mut(place) {
            *attribute = Cow::Owned(content);
        }
    }
    Ok((attributes, extensions))
}

/// The axis that is up by the extensions, and whether the front that goes with it is the back.
///
/// # Errors
/// [`LoadError::Unsupported`] for axes that are those of a mirror.
fn axes_of(mut records: &[u8], warnings: &mut Warnings) -> Result<(Axis, bool), LoadError> {
    let mut found = USUAL;
    while let Some((head, rest)) = records.split_at_checked(8) {
        let (kind, size) = (u32_at(head, 0), u32_at(head, 4));
        let parts = usize::try_from(size).ok().and_then(|size| rest.split_at_checked(size));
        let Some((content, after)) = parts else { break };
        records = after;
        if kind != COORDINATES {
            warnings.add(|| format!("{FORMAT}: extension {kind:#010x} has no effect"));
            continue;
        }
        let code = u32_at(content, 0);
        let Some(axes) = code.checked_sub(1).filter(|&axes| axes < 16) else {
            warnings
                .add(|| format!("{FORMAT}: coordinate system {code} is not known: drawn as right, up, back"));
            continue;
        };
        // Bits: right in place of left, up of down, front of back (back of front in the second half).
        let [right, above, front, turned] = [axes & 1, axes >> 1 & 1, axes >> 2 & 1, axes >> 3];
        if right ^ above ^ front != 0 {
            return Err(LoadError::unsupported(
                FORMAT,
                format!("coordinate system {code}, which is left-handed"),
            ));
        }
        // The side that is shown is that of PLY files of the same scene, whose axes are right, down, front.
        found = match (turned, above) {
            (0, 1) => (Axis::PositiveY, front == 0),
            (0, _) => (Axis::NegativeY, front == 0),
            (_, 1) => (Axis::PositiveZ, front == 0),
            _ => (Axis::NegativeZ, front == 1),
        };
    }
    if !records.is_empty() {
        let rest = counted(records.len() as u64, "byte");
        warnings.add(|| format!("{FORMAT}: {rest} of extensions that end early have no effect"));
    }
    Ok(found)
}

/// Adds the splats.
fn fill(mut cloud: Cloud, header: &Header, attributes: &Attributes<'_>) -> Cloud {
    let sizes = header.sizes();
    let mut own = [[0.0; 3]; 15];
    let drawn = own.get_mut(..coefficients(header.degree.min(3))).unwrap_or_default();
    for number in 0..usize::try_from(header.count).unwrap_or(0) {
        let of = |k: usize| -> &[u8] {
            let (Some(attribute), Some(&size)) = (attributes.get(k), sizes.get(k)) else { return &[] };
            let size = size as usize;
            let start = number.saturating_mul(size);
            attribute.get(start..start.saturating_add(size)).unwrap_or_default()
        };
        let byte = |k: usize, place: usize| of(k).get(place).copied().map_or(0.0, f32::from);
        let color = |place: usize| {
            let stored = (byte(2, place) / 255.0 - 0.5) / COLOR_SCALE;
            0.5 + DEGREE_0 * stored
        };
        for (n, coefficient) in drawn.iter_mut().enumerate() {
            for (c, value) in coefficient.iter_mut().enumerate() {
                let stored = of(5).get(n.saturating_mul(3).saturating_add(c));
                *value = stored.map_or(0.0, |&stored| (f32::from(stored) - 128.0) / 128.0);
            }
        }
        let splat = Splat {
            position: position(of(0), header),
            scale: [0, 1, 2].map(|place| exp(byte(3, place) / 16.0 - 10.0)),
            rotation: rotation(of(4), header.version),
            opacity: byte(1, 0) / 255.0,
            color: [0, 1, 2].map(color),
        };
        cloud.push(splat, drawn);
    }
    cloud
}

fn position(bytes: &[u8], header: &Header) -> [f32; 3] {
    if header.version == 1 {
        return [0, 2, 4].map(|place| half_to_f32(u16_at(bytes, place)));
    }
    // Exact: 24 bits and a power of two.
    let unit = 1.0 / 1_u32.wrapping_shl(header.fraction.into()) as f32;
    let mut position = [0.0; 3];
    for (value, &[a, b, c]) in position.iter_mut().zip(bytes.as_chunks().0) {
        *value = (i32::from_le_bytes([0, a, b, c]) >> 8) as f32 * unit;
    }
    position
}

fn rotation(bytes: &[u8], version: u32) -> [f32; 4] {
    if version < 3 {
        let [x, y, z] = [0, 1, 2].map(|k: usize| bytes.get(k).copied().map_or(0.0, f32::from) / 127.5 - 1.0);
        return with_largest([x, y, z], 3);
    }
    let word = u32_at(bytes, 0);
    let small = |shift: u32| {
        let magnitude = (word.wrapping_shr(shift) & 511) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
        if word.wrapping_shr(shift) & 512 == 0 { magnitude } else { -magnitude }
    };
    with_largest([small(20), small(10), small(0)], word >> 30)
}
