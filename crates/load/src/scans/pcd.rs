//! PCD, the point clouds of the Point Cloud Library (its document "The PCD file format", version 0.7): text, binary, and binary
//! compressed by LZF.
//!
//! `x y z`, `normal_x normal_y normal_z` and `rgb` or `rgba` (8 bits each in a word, which may be written as a float) are read, or the
//! three parts of a colour in fields of their own, as PDAL writes them, and of the others the one that says most of a point where
//! there are no colours. Points of the depth camera without a measure are NaN.

use super::{Scan, color_of_8, color_within, lzf, range_of};
use crate::budget::Budget;
use crate::mesh_formats::check_input;
use crate::origin::{Region, load_about};
use crate::point_clouds::Measure;
use crate::text::{Tokens, double, integer, quoted, without_mark};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};

const FORMAT: &str = "PCD";
/// Most fields of a point, and most values of a field (descriptors have some hundreds).
const MOST: u64 = 4096;

/// Type of the values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Signed,
    Unsigned,
    Float,
}

#[derive(Clone, Debug)]
struct Field {
    name: String,
    size: u64,
    kind: Type,
    count: u64,
    /// Byte, or word of the line, at which it begins.
    place: [usize; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Data {
    Text,
    Binary,
    Compressed,
}

struct Header<'a> {
    fields: Vec<Field>,
    points: u64,
    /// Bytes of a point.
    stride: usize,
    data: Data,
    body: &'a [u8],
}

/// True if a text begins as the header of such a file.
pub(crate) fn is_one(text: &[u8]) -> bool {
    let head = text.get(..4096).unwrap_or(text);
    let mut lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    let is_keyword = first.starts_with(b"VERSION") || first.starts_with(b"FIELDS");
    text.starts_with(b"# .PCD") || is_keyword && head.windows(5).any(|word| word == b"\nDATA")
}

/// Reads a file.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(bytes, region, context))
}

fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let header = Header::read(bytes, &mut warnings)?;
    let slots = Slots::new(&header.fields, &mut warnings)?;
    let mut scan = Scan::default();
    scan.rest.measure = slots.measure;
    match header.data {
        Data::Text => text(&header, &slots, &mut scan, context, &mut warnings)?,
        Data::Binary => {
            let reach = |field: &Field| (field.place[0], header.stride);
            binary(&header, header.body, reach, &slots, &mut scan, context, &mut warnings)?;
        }
        Data::Compressed => {
            let body = unpack(&header, context)?;
            // All values of a field come before those of the next.
            let points = usize::try_from(header.points).unwrap_or(usize::MAX);
            let reach = |field: &Field| {
                (field.place[0].saturating_mul(points), (field.size.saturating_mul(field.count)) as usize)
            };
            binary(&header, &body, reach, &slots, &mut scan, context, &mut warnings)?;
        }
    }
    if slots.parts.is_some() {
        let codes = scan.rest.colors.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
        let range = range_of(codes.fold(0.0, |most, v| if v > most { v } else { most }));
        for color in &mut scan.rest.colors {
            let [r, g, b, _] = *color;
            *color = color_within([r, g, b], range);
        }
    }
    if (scan.positions.len() as u64) < header.points {
        let (read, all) = (scan.positions.len(), counted(header.points, "point"));
        if read == 0 {
            return Err(LoadError::malformed(FORMAT, format!("the file ends before the first of {all}")));
        }
        warnings.add(|| format!("{FORMAT}: the file has {read} of {all}"));
    }
    leave_out_unmeasured(&mut scan);
    scan.finish(FORMAT, region, warnings)
}

/// Leaves out the points that the camera has not measured: NaN, which is how the format says so.
fn leave_out_unmeasured(scan: &mut Scan) {
    let keep: Vec<bool> = scan.positions.iter().map(|p| !p.iter().any(|v| v.is_nan())).collect();
    fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
        let mut keep = keep.iter();
        list.retain(|_| keep.next().is_some_and(|keep| *keep));
    }
    retain(&mut scan.positions, &keep);
    retain(&mut scan.rest.normals, &keep);
    retain(&mut scan.rest.colors, &keep);
    retain(&mut scan.rest.values, &keep);
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let mut tokens = Tokens::new(without_mark(bytes));
        let mut lists: [Vec<&[u8]>; 4] = Default::default();
        let (mut points, mut size) = (None, [None; 2]);
        loop {
            let Some(word) = tokens.next() else {
                return Err(malformed("the header has no line DATA".to_owned()));
            };
            let mut ahead = tokens.clone();
            // The rest of a line that has none would be the next one.
            let line = ahead.rest_of_line();
            let words = || line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            let number = || words().next().and_then(integer).and_then(|count| u64::try_from(count).ok());
            let list = match word {
                b"FIELDS" | b"COLUMNS" => Some(0),
                b"SIZE" => Some(1),
                b"TYPE" => Some(2),
                b"COUNT" => Some(3),
                _ => None,
            };
            if let Some(list) = list.and_then(|list| lists.get_mut(list)) {
                *list = words().take(MOST as usize).collect();
            }
            match word {
                b"POINTS" => points = number(),
                b"WIDTH" => size[0] = number(),
                b"HEIGHT" => size[1] = number(),
                b"VIEWPOINT" if words().map(integer).ne([0, 0, 0, 1, 0, 0, 0].map(Some)) => {
                    warnings.add(|| format!("{FORMAT}: the viewpoint has no effect"));
                }
                b"DATA" => {
                    let data = match line {
                        b"ascii" => Data::Text,
                        b"binary" => Data::Binary,
                        b"binary_compressed" => Data::Compressed,
                        _ => return Err(malformed(format!("DATA {} is not known", quoted(line)))),
                    };
                    let body = ahead.rest();
                    // The end of the line is one byte or two.
                    let body = body.strip_prefix(b"\r").unwrap_or(body);
                    let body = body.strip_prefix(b"\n").unwrap_or(body);
                    let [width, height] = size.map(|side| side.unwrap_or(1));
                    let points = points.unwrap_or_else(|| width.saturating_mul(height));
                    let (fields, stride) = Field::all(&lists)?;
                    return Ok(Self { fields, points, stride, data, body });
                }
                _ => {}
            }
            tokens = ahead;
        }
    }
}

impl Field {
    /// The fields, and the bytes of a point.
    fn all(lists: &[Vec<&[u8]>; 4]) -> Result<(Vec<Self>, usize), LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let [names, sizes, types, counts] = lists;
        if names.is_empty() {
            return Err(malformed("the header has no line FIELDS".to_owned()));
        }
        let (mut fields, mut place) = (Vec::new(), [0_usize; 2]);
        for (k, name) in names.iter().enumerate() {
            let name = String::from_utf8_lossy(name).into_owned();
            let number = |list: &[&[u8]], missing: u64| match list.get(k) {
                None => Some(missing),
                Some(word) => integer(word).and_then(|v| u64::try_from(v).ok()),
            };
            let size = number(sizes, 4).filter(|size| [1, 2, 4, 8].contains(size));
            let count = number(counts, 1).filter(|&count| count <= MOST);
            let kind = match types.get(k).copied().unwrap_or(b"F") {
                b"I" => Some(Type::Signed),
                b"U" => Some(Type::Unsigned),
                b"F" if size != Some(1) && size != Some(2) => Some(Type::Float),
                _ => None,
            };
            let (Some(size), Some(count), Some(kind)) = (size, count, kind) else {
                let name = quoted(name.as_bytes());
                return Err(malformed(format!("field {name} has a SIZE, TYPE or COUNT that is not known")));
            };
            fields.push(Self { name, size, kind, count, place });
            let [bytes, words] = place;
            place = [
                bytes.saturating_add(size.saturating_mul(count) as usize),
                words.saturating_add(count as usize),
            ];
        }
        Ok((fields, place[0]))
    }
}

/// Fields by what they mean.
struct Slots<'a> {
    position: [&'a Field; 3],
    normal: Option<[&'a Field; 3]>,
    color: Option<&'a Field>,
    /// Red, green and blue in fields of their own.
    parts: Option<[&'a Field; 3]>,
    value: Option<&'a Field>,
    measure: Measure,
}

impl<'a> Slots<'a> {
    fn new(fields: &'a [Field], warnings: &mut Warnings) -> Result<Self, LoadError> {
        let find = |name: &str| fields.iter().find(|field| field.name == name && field.count > 0);
        let three = |names: [&str; 3]| match names.map(find) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        let Some(position) = three(["x", "y", "z"]) else {
            return Err(LoadError::malformed(FORMAT, "there are no fields x, y and z"));
        };
        let normal = three(["normal_x", "normal_y", "normal_z"]);
        let color = find("rgb").or_else(|| find("rgba")).filter(|field| field.size == 4);
        let parts = three(["red", "green", "blue"]).or_else(|| three(["r", "g", "b"]));
        let parts = parts.filter(|_| color.is_none());
        let is_colored = color.is_some() || parts.is_some();
        let mut best: Option<(Measure, &Field)> = None;
        for field in fields.iter().filter(|field| !is_colored && field.count == 1) {
            if let Some(measure) = Measure::of(&field.name)
                && best.is_none_or(|(found, _)| measure > found)
            {
                best = Some((measure, field));
            }
        }
        let (measure, value) = best.map_or((Measure::default(), None), |(m, field)| (m, Some(field)));
        let used = |name: &str| {
            let of = |list: &[&Field]| list.iter().any(|field| field.name == name);
            of(&position)
                || normal.is_some_and(|n| of(&n))
                || parts.is_some_and(|p| of(&p))
                || color.into_iter().chain(value).any(|f| f.name == name)
        };
        // `_` is padding.
        let unused: Vec<String> = fields
            .iter()
            .filter(|field| field.name != "_" && !used(&field.name))
            .map(|field| quoted(field.name.as_bytes()))
            .take(8)
            .collect();
        if !unused.is_empty() {
            warnings.add(|| format!("{FORMAT}: fields without effect: {}", unused.join(", ")));
        }
        Ok(Self { position, normal, color, parts, value, measure })
    }

    /// Adds a point, of whose fields `number` has the value and `word` the bits.
    fn push(
        &self,
        scan: &mut Scan,
        number: impl Fn(&Field) -> Option<f64>,
        word: impl Fn(&Field) -> Option<u32>,
    ) -> Option<()> {
        let three = |[x, y, z]: [&Field; 3]| Some([number(x)?, number(y)?, number(z)?]);
        let position = three(self.position)?;
        let normal = match self.normal {
            Some(fields) => Some(three(fields)?.map(|v| v as f32)),
            None => None,
        };
        let color = match self.color {
            Some(field) => Some(word(field)?),
            None => None,
        };
        let parts = match self.parts {
            Some(fields) => Some(three(fields)?.map(|v| v as f32)),
            None => None,
        };
        let value = match self.value {
            Some(field) => Some(number(field)? as f32),
            None => None,
        };
        scan.positions.push(position);
        let is_finite = |normal: &[f32; 3]| normal.iter().all(|v| v.is_finite());
        scan.rest.normals.extend(normal.map(|normal| if is_finite(&normal) { normal } else { [0.0; 3] }));
        scan.rest.colors.extend(color.map(|word| {
            let [b, g, r, _] = word.to_le_bytes();
            color_of_8([r, g, b])
        }));
        // Codes until all are known.
        scan.rest.colors.extend(parts.map(|[r, g, b]| [r, g, b, 1.0]));
        scan.rest.values.extend(value);
        Some(())
    }
}

/// Reads lines of text, one for each point.
fn text(
    header: &Header<'_>,
    slots: &Slots<'_>,
    scan: &mut Scan,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<(), LoadError> {
    // A point takes six bytes at least: three digits, and what is between them.
    Scan::check(context, header.points.min(header.body.len() as u64 / 6))?;
    let (mut words, mut bad) = (Vec::new(), 0_u64);
    for line in header.body.split(|&b| b == b'\n' || b == b'\r') {
        if scan.positions.len() as u64 >= header.points {
            break;
        }
        words.clear();
        words.extend(line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()));
        if words.is_empty() || line.starts_with(b"#") {
            continue;
        }
        let word = |field: &Field| words.get(field.place[1]).copied();
        let number = |field: &Field| word(field).and_then(double);
        let bits = |field: &Field| match field.kind {
            // A whole number is no float of these bits, which would be far below 1: the word itself is written.
            Type::Float => match word(field).and_then(integer) {
                Some(value) if value != 0 => Some(value as u32),
                _ => number(field).map(|value| (value as f32).to_bits()),
            },
            _ => word(field).and_then(integer).map(|value| value as u32),
        };
        if slots.push(scan, number, bits).is_none() {
            bad = bad.saturating_add(1);
        }
    }
    if bad > 0 {
        let lines = counted(bad, "line");
        warnings.add(|| format!("{FORMAT}: {lines} left out: numbers missing, or words in their place"));
    }
    Ok(())
}

/// Reads binary values; `reach` has the place of the first value of a field and the bytes to that of the next point.
fn binary(
    header: &Header<'_>,
    body: &[u8],
    reach: impl Fn(&Field) -> (usize, usize),
    slots: &Slots<'_>,
    scan: &mut Scan,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<(), LoadError> {
    let there = (body.len() as u64).checked_div(header.stride as u64).unwrap_or(0);
    let count = header.points.min(there);
    let stride = Scan::stride(FORMAT, context, count, warnings)?;
    let [count, stride] = [count, stride].map(|v| usize::try_from(v).unwrap_or(usize::MAX));
    for number in (0..count).step_by(stride) {
        let bytes = |field: &Field| {
            let (first, step) = reach(field);
            body.get(first.checked_add(number.checked_mul(step)?)?..)
        };
        let value = |field: &Field| bytes(field).and_then(|bytes| value(bytes, field));
        let word = |field: &Field| Some(u32::from_le_bytes(*bytes(field)?.first_chunk()?));
        if slots.push(scan, value, word).is_none() {
            break;
        }
    }
    if header.data == Data::Binary {
        let extra = (body.len() as u64).saturating_sub(header.points.saturating_mul(header.stride as u64));
        if extra > 0 {
            let extra = counted(extra, "byte");
            warnings.add(|| format!("{FORMAT}: {extra} after the last point left out"));
        }
    }
    Ok(())
}

/// A value at the beginning of some bytes.
fn value(bytes: &[u8], field: &Field) -> Option<f64> {
    macro_rules! read {
        ($type:ty) => {
            <$type>::from_le_bytes(*bytes.first_chunk()?) as f64
        };
    }
    Some(match (field.kind, field.size) {
        (Type::Signed, 1) => read!(i8),
        (Type::Signed, 2) => read!(i16),
        (Type::Signed, 4) => read!(i32),
        (Type::Signed, _) => read!(i64),
        (Type::Unsigned, 1) => read!(u8),
        (Type::Unsigned, 2) => read!(u16),
        (Type::Unsigned, 4) => read!(u32),
        (Type::Unsigned, _) => read!(u64),
        (Type::Float, 4) => read!(f32),
        (Type::Float, _) => read!(f64),
    })
}

/// The body of a compressed file: the sizes before and after, and the data.
fn unpack(header: &Header<'_>, context: &Context<'_>) -> Result<Vec<u8>, LoadError> {
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let sizes = header.body.split_first_chunk::<4>().and_then(|(packed, rest)| {
        let (size, rest) = rest.split_first_chunk::<4>()?;
        Some((u32::from_le_bytes(*packed), u32::from_le_bytes(*size), rest))
    });
    let Some((packed, size, rest)) = sizes else {
        return Err(malformed("the file ends before the compressed data".to_owned()));
    };
    let needed = header.points.saturating_mul(header.stride as u64);
    if u64::from(size) != needed {
        return Err(malformed(format!("the compressed data claim {size} bytes, not {needed}")));
    }
    let Some(data) = rest.get(..packed as usize) else {
        return Err(malformed(format!("the file ends after {} of {packed} compressed bytes", rest.len())));
    };
    Budget::new(context.limits).charge(|| format!("{FORMAT}: the data"), size.into(), 1)?;
    lzf::unpack(data, size as usize).ok_or_else(|| malformed("the compressed data are damaged".to_owned()))
}
