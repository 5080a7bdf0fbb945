//! Vertices and faces of a PLY file.

use super::FORMAT;
use super::header::{Element, Encoding, Kind, Property, Scalar};
use super::values::{Missing, Values};
use crate::mesh_formats::{check_mesh, drawable};
use crate::origin::{Origin, Region};
use crate::point_clouds::Measure;
use crate::polygon::Triangulator;
use crate::{Context, LoadError};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};

/// Attributes of a vertex or face that a value can be, in the order of the slots of an item.
const NAMES: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["s", "u", "texture_u", "tex_u", "texture_s", "texcoord_u", "texcoord_s", "u0", "s0", "tx"],
    &["t", "v", "texture_v", "tex_v", "texture_t", "texcoord_v", "texcoord_t", "v0", "t0", "ty"],
    &["red", "r", "diffuse_red", "color_red", "color_r"],
    &["green", "g", "diffuse_green", "color_green", "color_g"],
    &["blue", "b", "diffuse_blue", "color_blue", "color_b"],
    &["alpha", "a", "diffuse_alpha", "color_alpha", "color_a"],
];
/// Names of the list of a face's corners.
pub(super) const INDICES: [&str; 6] =
    ["vertex_indices", "vertex_index", "vertex_indexes", "vertexindices", "vertexindex", "indices"];
/// Slots of an item: those of [`NAMES`], and that of a [`Measure`].
pub(super) const SLOTS: usize = NAMES.len() + 1;
const VALUE: usize = NAMES.len();
const NORMAL: usize = 3;
const UV: usize = 6;
pub(super) const COLOR: usize = 8;
pub(super) const ALPHA: usize = 11;

/// Slot that a property fills, with the type of its values; `None` for lists and unknown names.
fn slot(property: &Property) -> Option<(usize, Scalar)> {
    let Kind::One(scalar) = property.kind else { return None };
    let name = property.name.as_str();
    NAMES.iter().position(|names| names.contains(&name)).map(|slot| (slot, scalar))
}

/// The slots that the properties of an element fill.
pub(super) struct Slots(pub(super) Vec<Option<(usize, Scalar)>>);

impl Slots {
    pub(super) fn new(element: &Element) -> Self {
        Self(element.properties.iter().map(slot).collect())
    }

    /// Fills the slot of the value that says most of a point; the first of several alike.
    fn add_measure(&mut self, element: &Element) -> Option<Measure> {
        let named =
            element.properties.iter().zip(&mut self.0).filter_map(|(property, slot)| match property.kind {
                Kind::One(scalar) if slot.is_none() => Some((Measure::of(&property.name)?, scalar, slot)),
                _ => None,
            });
        let best = named.reduce(|best, next| if next.0 > best.0 { next } else { best });
        let (measure, scalar, slot) = best?;
        *slot = Some((VALUE, scalar));
        Some(measure)
    }

    /// True if all of these slots are filled.
    pub(super) fn has(&self, mut slots: std::ops::Range<usize>) -> bool {
        slots.all(|slot| self.0.iter().flatten().any(|&(filled, _)| filled == slot))
    }
}

/// Stores a value in its slot: colours as linear numbers, the rest as it is.
pub(super) fn store(item: &mut [f32; SLOTS], slot: Option<(usize, Scalar)>, value: f32) {
    if let Some((slot, scalar)) = slot
        && let Some(place) = item.get_mut(slot)
    {
        *place = if (COLOR..VALUE).contains(&slot) { color(slot, scalar, value) } else { value };
    }
}

/// Whole numbers are sRGB codes of 8 bits (16 in `ushort`), and fractions sRGB, which programs that read them agree on (three.js,
/// MeshLab, Open3D, trimesh): those are left as they are until all are known.
/// Alpha is linear in both.
fn color(slot: usize, scalar: Scalar, value: f32) -> f32 {
    match scalar {
        Scalar::F16 | Scalar::F32 | Scalar::F64 => value,
        Scalar::U16 if slot == ALPHA => saturate(value / 65535.0),
        Scalar::U16 => srgb_to_linear(saturate(value / 65535.0)),
        _ if slot == ALPHA => saturate(value / 255.0),
        _ => code(value),
    }
}

/// The linear value of an sRGB code.
fn code(value: f32) -> f32 {
    srgb8_to_linear((saturate(value / 255.0) * 255.0 + 0.5) as u8)
}

/// 0 to 1; NaN becomes 0.
fn saturate(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// The linear component of a colour that is written as a fraction; `is_code`: as the code of a whole number, with a point.
pub(super) fn settled(v: f32, is_code: bool) -> f32 {
    if is_code { code(v) } else { srgb_to_linear(saturate(v)) }
}

/// Makes fractions linear numbers, as whole numbers are already. Where some are above 2 they are the codes of whole numbers,
/// written with a point.
pub(super) fn settle_colors(slots: &Slots, colors: &mut [[f32; 4]]) {
    let is_float = |scalar| matches!(scalar, Scalar::F16 | Scalar::F32 | Scalar::F64);
    let rgb_codes = colors.iter().flatten().enumerate().any(|(k, &v)| k % 4 != 3 && v > 2.0);
    let alpha_codes = colors.iter().any(|color| color[3] > 2.0);
    for (channel, slot) in (COLOR..=ALPHA).enumerate() {
        if !slots.0.iter().flatten().any(|&(filled, scalar)| filled == slot && is_float(scalar)) {
            continue;
        }
        for v in colors.iter_mut().filter_map(|color| color.get_mut(channel)) {
            *v = match slot {
                ALPHA => saturate(if alpha_codes { *v / 255.0 } else { *v }),
                _ => settled(*v, rgb_codes),
            };
        }
    }
}

/// Attributes of all vertices; lists are empty where the file has none.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// v runs down.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) colors: Vec<[f32; 4]>,
    /// Read only if there are no colours.
    pub(super) values: Vec<f32>,
    /// Meaning of the values.
    pub(super) measure: Measure,
    /// Reason why there are fewer than the header says.
    pub(super) cut: Option<String>,
}

/// Triangles, and what each of their corners or faces has of its own.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Three per triangle, v down; empty without.
    pub(super) corner_uvs: Vec<[[f32; 2]; 3]>,
    /// One per triangle; empty without.
    pub(super) colors: Vec<[f32; 4]>,
    /// Numbers of their textures, one per triangle; empty without.
    pub(super) textures: Vec<i64>,
    /// Faces whose vertices do not exist or are not finite.
    pub(super) bad: u64,
    /// Faces of less than three corners.
    pub(super) short: u64,
    /// Reason why there are fewer than the header says.
    pub(super) cut: Option<String>,
    /// Name of the list that is taken for the corners, if it is none of the usual ones.
    pub(super) unusual: Option<String>,
}

/// "element face: item 3 of 10".
fn item(element: &Element, number: u64) -> String {
    format!("element '{}', item {number} of {}", element.name, element.count)
}

/// Reason why an element is read only in part: one line.
pub(super) fn cut(element: &Element, number: u64, missing: Missing) -> String {
    let item = item(element, number);
    match missing {
        Missing::End => format!("the file ends within {item}"),
        Missing::NotANumber => format!("{item} has something that is not a (whole) number"),
    }
}

/// Number of items of an element that so many bytes can hold at most: memory may be allocated for as many.
fn fitting(element: &Element, encoding: Encoding, bytes: usize) -> u64 {
    // The last value of a text file need not be separated from anything.
    let fitting = (bytes as u64).saturating_add(1).checked_div(element.min_size(encoding));
    fitting.unwrap_or(0).min(element.count)
}

/// Skips an element that means nothing here. The error says where the file cannot be read on.
pub(super) fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), String> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 0..element.count {
        for property in &element.properties {
            match skip_property(property.kind, values) {
                Ok(()) => {}
                Err(Missing::NotANumber) if values.skip_line() => break,
                Err(missing) => return Err(cut(element, number, missing)),
            }
        }
        if element.by_line {
            values.skip_line();
        }
    }
    Ok(())
}

pub(super) fn skip_property(kind: Kind, values: &mut Values<'_>) -> Result<(), Missing> {
    match kind {
        Kind::One(scalar) => values.skip(scalar, 1),
        Kind::List(count, scalar) => {
            let count = u64::try_from(values.integer(count)?).map_err(|_| Missing::NotANumber)?;
            values.skip(scalar, count)
        }
    }
}

/// Reads the vertices. Those that are complete when the file ends are kept: [`Vertices::cut`].
pub(super) fn vertices(
    element: &Element,
    values: &mut Values<'_>,
    encoding: Encoding,
    bytes: usize,
) -> Result<Vertices, LoadError> {
    let mut slots = Slots::new(element);
    if !slots.has(0..3) {
        return Err(LoadError::malformed(FORMAT, "element 'vertex' has no x, y and z"));
    }
    let (with_normals, with_uvs, with_colors) =
        (slots.has(NORMAL..UV), slots.has(UV..COLOR), slots.has(COLOR..ALPHA));
    let measure = if with_colors { None } else { slots.add_measure(element) };
    let count = fitting(element, encoding, bytes) as usize;
    let mut out = Vertices { measure: measure.unwrap_or_default(), ..Vertices::default() };
    // Lists that grow would take twice as much for a while.
    let exactly = |wanted: bool| if wanted { count } else { 0 };
    out.positions.reserve_exact(count);
    out.normals.reserve_exact(exactly(with_normals));
    out.uvs.reserve_exact(exactly(with_uvs));
    out.colors.reserve_exact(exactly(with_colors));
    out.values.reserve_exact(exactly(measure.is_some()));
    for number in 0..element.count {
        let mut item = [0.0; SLOTS];
        item[ALPHA] = 1.0;
        let mut read = || -> Result<(), Missing> {
            for (property, &slot) in element.properties.iter().zip(&slots.0) {
                match property.kind {
                    Kind::One(scalar) => store(&mut item, slot, values.number(scalar)?),
                    list @ Kind::List(..) => skip_property(list, values)?,
                }
            }
            Ok(())
        };
        match read() {
            Ok(()) if element.by_line => drop(values.skip_line()),
            Ok(()) => {}
            Err(Missing::NotANumber) if values.skip_line() => {}
            Err(missing) => {
                out.cut = Some(cut(element, number, missing));
                break;
            }
        }
        let [x, y, z, nx, ny, nz, u, v, r, g, b, a, value] = item;
        out.positions.push([x, y, z]);
        if with_normals {
            // A zero normal stands for the triangle's own.
            let normal = [nx, ny, nz];
            out.normals.push(if normal.iter().all(|v| v.is_finite()) { normal } else { [0.0; 3] });
        }
        if with_uvs {
            out.uvs.push(upside_down([u, v]));
        }
        if with_colors {
            out.colors.push([r, g, b, a]);
        }
        if measure.is_some() {
            out.values.push(value);
        }
    }
    settle_colors(&slots, &mut out.colors);
    Ok(out)
}

/// Reads the positions of vertices once more, in double precision, and puts them about an origin in the region. Returns
/// that, and whether the file has them in single precision.
pub(super) fn place(
    element: &Element,
    mut values: Values<'_>,
    region: &Region,
    positions: &mut [[f32; 3]],
) -> (Origin, bool) {
    let slots = Slots::new(element);
    let mut exact = Vec::with_capacity(positions.len());
    let mut single = !matches!(values, Values::Ascii(_));
    while exact.len() < positions.len() {
        let mut position = [f64::NAN; 3];
        let mut read = || -> Result<(), Missing> {
            for (property, slot) in element.properties.iter().zip(&slots.0) {
                let scalar = match property.kind {
                    Kind::One(scalar) => scalar,
                    list @ Kind::List(..) => {
                        skip_property(list, &mut values)?;
                        continue;
                    }
                };
                let value = values.double(scalar)?;
                if let Some(place) = slot.and_then(|(slot, _)| position.get_mut(slot)) {
                    *place = value;
                    single &= matches!(scalar, Scalar::F16 | Scalar::F32);
                }
            }
            Ok(())
        };
        // As they were read at first.
        match read() {
            Ok(()) if element.by_line => drop(values.skip_line()),
            Ok(()) => {}
            Err(Missing::NotANumber) if values.skip_line() => {}
            Err(_) => break,
        }
        exact.push(position);
    }
    let origin = region.origin(exact.iter().copied());
    for (position, exact) in positions.iter_mut().zip(exact) {
        *position = origin.relative(exact);
    }
    (origin, single)
}

/// v runs up in PLY files, down here.
fn upside_down([u, v]: [f32; 2]) -> [f32; 2] {
    if u.is_finite() && v.is_finite() { [u, 1.0 - v] } else { [0.0; 2] }
}

/// Reads faces or triangle strips. What is complete when the file ends is kept.
pub(super) fn faces(
    element: &Element,
    values: &mut Values<'_>,
    positions: &[[f32; 3]],
    context: &Context<'_>,
) -> Result<(Faces, u64), LoadError> {
    let slots = Slots::new(element);
    let with_colors = slots.has(COLOR..ALPHA);
    let is_list =
        |p: &Property, names: &[&str]| matches!(p.kind, Kind::List(..)) && names.contains(&p.name.as_str());
    let usual = element.properties.iter().position(|p| is_list(p, &INDICES));
    // Else the first list of whole numbers.
    let whole = |p: &Property| matches!(p.kind, Kind::List(_, scalar) if !scalar.is_float());
    let indices_at = usual.or_else(|| element.properties.iter().position(whole));
    let uvs_at = element.properties.iter().position(|p| is_list(p, &["texcoord", "texcoords"]));
    let number_at = element.properties.iter().position(|p| p.name == "texnumber");
    let strips = element.name == "tristrips";
    let mut out = Faces::default();
    let Some(indices_property) = indices_at.and_then(|at| element.properties.get(at)) else {
        out.cut = skip(element, values).err();
        return Ok((out, 0));
    };
    out.unusual = usual.is_none().then(|| indices_property.name.clone());

    let mut triangulator = Triangulator::default();
    let (mut indices, mut uvs) = (Vec::<i64>::new(), Vec::<f32>::new());
    // Number, position and texture coordinates of each corner.
    let mut polygon: Vec<(u32, [f32; 3], [f32; 2])> = Vec::new();
    let mut item = [0.0; SLOTS];
    for number in 0..element.count {
        indices.clear();
        uvs.clear();
        item[ALPHA] = 1.0;
        let mut texture = -1;
        let mut read = || -> Result<(), Missing> {
            for (k, (property, &slot)) in element.properties.iter().zip(&slots.0).enumerate() {
                match property.kind {
                    Kind::One(scalar) if Some(k) == number_at => texture = values.integer(scalar)?,
                    Kind::One(scalar) => store(&mut item, slot, values.number(scalar)?),
                    Kind::List(count, scalar) if Some(k) == indices_at => {
                        let count = values.integer(count)?;
                        if count < 0 {
                            return Err(Missing::NotANumber);
                        }
                        // Grows with what is there, whatever the count says.
                        for _ in 0..count {
                            indices.push(values.integer(scalar)?);
                        }
                    }
                    Kind::List(count, scalar) if Some(k) == uvs_at => {
                        for _ in 0..values.integer(count)? {
                            uvs.push(values.number(scalar)?);
                        }
                    }
                    list @ Kind::List(..) => skip_property(list, values)?,
                }
            }
            Ok(())
        };
        match read() {
            Ok(()) if element.by_line => drop(values.skip_line()),
            Ok(()) => {}
            Err(Missing::NotANumber) if values.skip_line() => {
                out.bad = out.bad.saturating_add(1);
                continue;
            }
            Err(missing) => {
                out.cut = Some(cut(element, number, missing));
                break;
            }
        }
        let first = out.triangles.len();
        polygon.clear();
        if strips {
            strip(&indices, positions, &mut out);
        } else if indices.len() < 3 {
            out.short = out.short.saturating_add(1);
        } else {
            polygon.extend(
                indices
                    .iter()
                    .map_while(|&index| Some((index as u32, existing(index, positions)?, [0.0; 2]))),
            );
            let (pairs, odd) = uvs.as_chunks();
            if odd.is_empty() && pairs.len() == polygon.len() {
                polygon.iter_mut().zip(pairs).for_each(|((_, _, own), &uv)| *own = upside_down(uv));
            }
            if polygon.len() < indices.len() {
                out.bad = out.bad.saturating_add(1);
                polygon.clear();
            }
            triangulator.triangulate(
                &polygon,
                |(_, position, _)| position,
                |t| {
                    out.triangles.push(t.map(|(index, ..)| index));
                    if uvs_at.is_some() {
                        out.corner_uvs.push(t.map(|(_, _, uv)| uv));
                    }
                },
            );
        }
        if with_colors {
            let color = [item[COLOR], item[COLOR + 1], item[COLOR + 2], item[ALPHA]];
            out.colors.resize(out.triangles.len(), color);
        }
        if number_at.is_some() {
            out.textures.resize(out.triangles.len(), texture);
        }
        if number % 1024 == 0 || out.triangles.len().saturating_sub(first) > 1024 {
            check_mesh(context, out.triangles.len() as u64, positions.len() as u64)?;
        }
    }
    settle_colors(&slots, &mut out.colors);
    check_mesh(context, out.triangles.len() as u64, positions.len() as u64)?;
    Ok((out, triangulator.given_up))
}

/// The position of an index, if there is one that can be drawn.
pub(super) fn existing(index: i64, positions: &[[f32; 3]]) -> Option<[f32; 3]> {
    positions.get(usize::try_from(index).ok()?).copied().filter(|&position| drawable(position))
}

/// Adds the triangles of strips that -1 separates; every other triangle of a strip runs the other way round.
fn strip(indices: &[i64], positions: &[[f32; 3]], out: &mut Faces) {
    for run in indices.split(|&i| i == -1) {
        let (second, third) = (run.iter().skip(1), run.iter().skip(2));
        for (k, ((&a, &b), &c)) in run.iter().zip(second).zip(third).enumerate() {
            if [a, b, c].iter().all(|&index| existing(index, positions).is_some()) {
                let [a, b, c] = [a, b, c].map(|index| index as u32);
                out.triangles.push(if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
            } else {
                out.bad = out.bad.saturating_add(1);
            }
        }
    }
}
