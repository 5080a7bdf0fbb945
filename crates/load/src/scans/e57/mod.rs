//! E57, the point clouds of terrestrial laser scanners (ASTM E2807-11, *3D Imaging Data Exchange*): positions, cartesian or
//! spherical, colours, intensities and normals of all scans, each by its pose.
//!
//! Points without a valid position are left out. Points of scans without colours are grey by their intensity. Pictures in the
//! file are left out, with a warning. Of more points than the limits allow every second is drawn, or every third, and so on.

mod document;
mod pages;
mod records;
#[cfg(test)]
pub(super) mod tests;

use super::{Scan, color_within, range_of};
use crate::budget::Budget;
use crate::mesh_formats::check_input;
use crate::origin::{Region, load_about};
use crate::point_clouds::Measure;
use crate::text::quoted;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};
use document::{Document, Field, Header, Kind};
use overcoat_core::math::double::sin_cos;
use pages::Pages;
use records::Records;

const FORMAT: &str = "E57";
/// Begins every file.
pub(crate) const MAGIC: &[u8; 8] = b"ASTM-E57";
/// Bytes of the file's header.
const HEADER: usize = 48;
/// sRGB code of points whose colour is not known, as a fraction.
const UNKNOWN: f32 = 0.5;

/// Reads a file. Scans that end early are drawn as far as they go, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut warnings = Warnings::default();
    let (pages, document) = open(bytes, context, &mut warnings)?;
    load_about(|region| load_in(&pages, &document, region, context, warnings.clone()))
}

/// Reads the header and the XML section.
fn open<'a>(
    bytes: &'a [u8],
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<(Pages<'a>, Document), LoadError> {
    let malformed = |message: &str| LoadError::malformed(FORMAT, message.to_owned());
    let header = bytes.get(..HEADER).filter(|header| header.starts_with(MAGIC));
    let header = header.ok_or_else(|| malformed("it does not begin with the header of ASTM-E57"))?;
    let word = |at: usize| {
        let word = header.get(at..).and_then(|rest| rest.first_chunk()).copied();
        u64::from_le_bytes(word.unwrap_or_default())
    };
    let version = word(8);
    if version as u32 != 1 {
        warnings.add(|| format!("{FORMAT}: version {}.{} is read as 1.0", version as u32, version >> 32));
    }
    let pages = Pages::new(bytes, word(40)).ok_or_else(|| malformed("its pages have a damaged size"))?;
    let damaged = pages.damaged();
    if damaged > 0 {
        let damaged = counted(damaged, "page");
        warnings.add(|| format!("{FORMAT}: {damaged} with a wrong checksum: points may be wrong"));
    }
    let (place, length) = (pages.logical(word(24)), word(32));
    let ends = || malformed("the file ends before its XML section does");
    let length = usize::try_from(length).ok().filter(|&length| length <= bytes.len()).ok_or_else(ends)?;
    let mut budget = Budget::new(context.limits);
    budget.charge(|| format!("{FORMAT}: the XML section"), length as u64, 1)?;
    let mut text = Vec::with_capacity(length);
    place.and_then(|place| pages.read(place, length, &mut text)).ok_or_else(ends)?;
    // Sections may be filled up with zeros.
    let end = text.iter().rposition(|&b| b != 0).map_or(0, |last| last.saturating_add(1));
    let text = String::from_utf8_lossy(text.get(..end).unwrap_or_default());
    let document = Document::read(text.strip_prefix('\u{feff}').unwrap_or(&text), context)?;
    if document.images > 0 {
        let images = counted(document.images, "picture");
        warnings.add(|| format!("{FORMAT}: {images} left out"));
    }
    Ok((pages, document))
}

fn load_in(
    pages: &Pages<'_>,
    document: &Document,
    region: Option<&Region>,
    context: &Context<'_>,
    mut warnings: Warnings,
) -> Result<Loaded, LoadError> {
    let scans = document.scans.iter().zip(1_u64..);
    let readers: Vec<_> =
        scans.filter_map(|(header, number)| Reader::new(header, number, &mut warnings)).collect();
    let bits = pages.length().saturating_mul(8);
    let most = |reader: &Reader<'_>| reader.header.count.min(bits.checked_div(reader.bits()).unwrap_or(1));
    let count = readers.iter().fold(0, |all: u64, reader| all.saturating_add(most(reader)));
    let stride = Scan::stride(FORMAT, context, count, &mut warnings)?;
    // Points with colours, and those of scans without.
    let [mut colored, mut plain] = [Scan::default(), Scan::default()];
    plain.rest.measure = Measure::Intensity;
    let mut first = None;
    for reader in &readers {
        let scan = if reader.slots.color.is_some() { &mut colored } else { &mut plain };
        if let Err(message) = reader.read(pages, stride, scan, &mut warnings) {
            let message = format!("scan {}: {message}", reader.number);
            warnings.add(|| format!("{FORMAT}: {message}"));
            first.get_or_insert(message);
        }
    }
    if colored.positions.is_empty()
        && plain.positions.is_empty()
        && let Some(message) = first
    {
        return Err(LoadError::malformed(FORMAT, message));
    }
    // Numbers that only some scans have.
    if plain.rest.values.len() != plain.positions.len() {
        plain.rest.values = Vec::new();
    }
    Scan::finish_all(vec![colored, plain], FORMAT, region, warnings)
}

/// Fields by what they mean, as their places in the prototype.
#[derive(Debug)]
struct Slots {
    position: [usize; 3],
    is_spherical: bool,
    invalid: Option<usize>,
    color: Option<[usize; 3]>,
    color_invalid: Option<usize>,
    intensity: Option<usize>,
    intensity_invalid: Option<usize>,
    normal: Option<[usize; 3]>,
}

impl Slots {
    /// `None` without positions.
    fn new(fields: &[Field]) -> Option<Self> {
        let find = |name: &str| fields.iter().position(|field| field.name == name);
        let three = |names: [&str; 3]| match names.map(find) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        let cartesian = three(["cartesianX", "cartesianY", "cartesianZ"]);
        let spherical = || three(["sphericalRange", "sphericalAzimuth", "sphericalElevation"]);
        let position = cartesian.or_else(spherical)?;
        let is_spherical = cartesian.is_none();
        let color = three(["colorRed", "colorGreen", "colorBlue"]);
        Some(Self {
            position,
            is_spherical,
            invalid: find(if is_spherical { "sphericalInvalidState" } else { "cartesianInvalidState" }),
            color,
            color_invalid: find("isColorInvalid").filter(|_| color.is_some()),
            intensity: find("intensity").filter(|_| color.is_none()),
            intensity_invalid: find("isIntensityInvalid").filter(|_| color.is_none()),
            normal: three(["nor:normalX", "nor:normalY", "nor:normalZ"]),
        })
    }

    fn uses(&self, field: usize) -> bool {
        let single = [self.invalid, self.color_invalid, self.intensity, self.intensity_invalid];
        self.position.contains(&field)
            || [self.color, self.normal].iter().flatten().any(|three| three.contains(&field))
            || single.contains(&Some(field))
    }
}

/// A scan that can be drawn.
#[derive(Debug)]
struct Reader<'a> {
    header: &'a Header,
    /// From 1.
    number: u64,
    slots: Slots,
    /// Columns of the rotation.
    axes: [[f64; 3]; 3],
}

impl<'a> Reader<'a> {
    fn new(header: &'a Header, number: u64, warnings: &mut Warnings) -> Option<Self> {
        let slots = Slots::new(&header.fields).filter(|_| !header.is_nested);
        let Some(slots) = slots else {
            let reason = if header.is_nested { "fields in fields" } else { "no positions" };
            warnings.add(|| format!("{FORMAT}: scan {number} left out: it has {reason}"));
            return None;
        };
        let is_extra = |name: &str| name.contains(':') && !name.starts_with("nor:normal");
        let extra = header.fields.iter().map(|field| field.name.as_str()).filter(|name| is_extra(name));
        let extra: Vec<String> = extra.map(|name| quoted(name.as_bytes())).take(8).collect();
        if !extra.is_empty() {
            warnings.add(|| format!("{FORMAT}: fields without effect: {}", extra.join(", ")));
        }
        Some(Self { header, number, slots, axes: axes(header.rotation) })
    }

    /// Bits of a record that are read.
    fn bits(&self) -> u64 {
        let fields = self.header.fields.iter().enumerate();
        fields.filter(|(k, _)| self.slots.uses(*k)).map(|(_, field)| u64::from(field.kind.bits())).sum()
    }

    /// Adds every so many-th point, if it is valid; else a message.
    fn read(
        &self,
        pages: &Pages<'_>,
        stride: u64,
        scan: &mut Scan,
        warnings: &mut Warnings,
    ) -> Result<(), String> {
        if self.header.count == 0 {
            return Ok(());
        }
        let fields = self.header.fields.iter().enumerate();
        let fields = fields.map(|(k, field)| (field.kind.bits(), self.slots.uses(k)));
        let mut records = Records::new(*pages, self.header.place, fields)?;
        // All alike: one will do.
        let count = if self.bits() == 0 { self.header.count.min(1) } else { self.header.count };
        let mut codes = Vec::new();
        let (mut read, mut wanted) = (0_u64, 0_u64);
        while read < count {
            let there = match records.next() {
                Ok(Some(there)) => there.min(count.saturating_sub(read)),
                Ok(None) => {
                    self.ends_early(read, "its section ends", warnings);
                    break;
                }
                Err(message) if read > 0 => {
                    self.ends_early(read, &message, warnings);
                    break;
                }
                Err(message) => return Err(message),
            };
            while wanted < there {
                self.point(&records, wanted, scan, &mut codes);
                wanted = wanted.saturating_add(stride);
            }
            wanted = wanted.saturating_sub(there);
            records.consume(there);
            read = read.saturating_add(there);
        }
        let range = self.color_range(&codes);
        scan.rest.colors.extend(codes.iter().map(|&codes| {
            if codes.iter().all(|code| code.is_finite()) {
                color_within(codes, range)
            } else {
                color_within([UNKNOWN; 3], 1.0)
            }
        }));
        Ok(())
    }

    fn ends_early(&self, read: u64, reason: &str, warnings: &mut Warnings) {
        let (number, all) = (self.number, counted(self.header.count, "point"));
        warnings.add(|| format!("{FORMAT}: scan {number} ends after {read} of {all}: {reason}"));
    }

    /// Adds a point if it is valid.
    fn point(&self, records: &Records<'_>, number: u64, scan: &mut Scan, codes: &mut Vec<[f32; 3]>) {
        let value = |field: usize| {
            let kind = self.header.fields.get(field).map(|field| field.kind);
            kind.map_or(0.0, |kind| kind.value(records.value(field, number)))
        };
        let is_set = |field: Option<usize>| field.is_some_and(|field| value(field) != 0.0);
        let slots = &self.slots;
        if is_set(slots.invalid) {
            return;
        }
        let [x, y, z] = self.turned(cartesian(slots.position.map(value), slots.is_spherical));
        let [tx, ty, tz] = self.header.translation;
        scan.positions.push([x + tx, y + ty, z + tz]);
        if let Some(fields) = slots.color {
            let is_unknown = is_set(slots.color_invalid);
            codes.push(if is_unknown { [f32::NAN; 3] } else { fields.map(|field| value(field) as f32) });
        }
        if let Some(field) = slots.intensity {
            let is_unknown = is_set(slots.intensity_invalid);
            scan.rest.values.push(if is_unknown { f32::NAN } else { value(field) as f32 });
        }
        let normal = slots.normal.map(|fields| self.turned(fields.map(value)).map(|v| v as f32));
        let normal = normal.filter(|normal| normal.iter().all(|v| v.is_finite()));
        if let Some(normal) = normal {
            // Scans before may have none, which are computed then.
            scan.rest.normals.resize(scan.positions.len().saturating_sub(1), [0.0; 3]);
            scan.rest.normals.push(normal);
        } else if !scan.rest.normals.is_empty() {
            scan.rest.normals.push([0.0; 3]);
        }
    }

    /// A direction of the scan in the coordinates of the file.
    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes;
        let one = |k: fn([f64; 3]) -> f64| x * k(a) + y * k(b) + z * k(c);
        [one(|v| v[0]), one(|v| v[1]), one(|v| v[2])]
    }

    /// The code of full colour: a power of two less one, of what the file says of its codes or else of the largest of them.
    fn color_range(&self, codes: &[[f32; 3]]) -> f32 {
        let field = self.slots.color.and_then(|[red, _, _]| self.header.fields.get(red));
        let of_type = match field.map(|field| field.kind) {
            Some(Kind::Integer { maximum, scale, offset, .. }) if maximum <= 255 => {
                (maximum as f64 * scale + offset) as f32
            }
            _ => 0.0,
        };
        let said = self.header.color_limit as f32;
        let all = || codes.iter().flatten().copied().filter(|code| code.is_finite());
        let largest = if said > 0.0 {
            said
        } else if of_type > 0.0 {
            of_type
        } else {
            all().fold(0.0, f32::max)
        };
        let is_code =
            largest > 255.0 && largest < 65535.0 && (largest as u32).wrapping_add(1).is_power_of_two();
        if is_code { largest } else { range_of(largest) }
    }
}

/// Position from a range, an azimuth and an elevation (ASTM E2807, 8.4.4).
fn cartesian(position: [f64; 3], is_spherical: bool) -> [f64; 3] {
    if !is_spherical {
        return position;
    }
    let [range, azimuth, elevation] = position;
    // Sines of angles that no scanner has are not known.
    if !(azimuth.abs() < 1e4 && elevation.abs() < 1e4) {
        return [f64::NAN; 3];
    }
    let ((sin_a, cos_a), (sin_e, cos_e)) = (sin_cos(azimuth), sin_cos(elevation));
    [range * cos_e * cos_a, range * cos_e * sin_a, range * sin_e]
}

/// Columns of the rotation of a quaternion (w, x, y, z) of any length; without one there is no rotation.
fn axes(quaternion: [f64; 4]) -> [[f64; 3]; 3] {
    let length = quaternion.iter().map(|v| v * v).sum::<f64>().sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let [w, x, y, z] = quaternion.map(|v| v / length);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}
