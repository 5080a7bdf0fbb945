//! Vertices and faces of a PLY file.

use super::FORMAT;
use super::header::{Element, Encoding, Kind, Property, Scalar};
use super::values::{Missing, Values};
use crate::color::srgb::{srgb_to_linear, srgb8_to_linear};
use crate::load::plain::{check_mesh, drawable};
use crate::load::polygon::Triangulator;
use crate::load::{Context, LoadError};

/// Attributes of a vertex or face that a value can be, in the order of the slots of an item.
const NAMES: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["s", "u", "texture_u", "tex_u"],
    &["t", "v", "texture_v", "tex_v"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
];
const NORMAL: usize = 3;
const UV: usize = 6;
const COLOR: usize = 8;
const ALPHA: usize = 11;

/// Which slot a property fills, if any.
fn slot(property: &Property) -> Option<(usize, Scalar)> {
    let Kind::One(scalar) = property.kind else { return None };
    let name = property.name.as_str();
    NAMES.iter().position(|names| names.contains(&name)).map(|slot| (slot, scalar))
}

/// The slots that the properties of an element fill.
struct Slots(Vec<Option<(usize, Scalar)>>);

impl Slots {
    fn new(element: &Element) -> Self {
        Self(element.properties.iter().map(slot).collect())
    }

    /// Whether all of these are filled.
    fn has(&self, mut slots: std::ops::Range<usize>) -> bool {
        slots.all(|slot| self.0.iter().flatten().any(|&(filled, _)| filled == slot))
    }
}

/// Stores a value in its slot: colours as linear numbers, the rest as it is.
fn store(item: &mut [f32; NAMES.len()], slot: Option<(usize, Scalar)>, value: f32) {
    if let Some((slot, scalar)) = slot
        && let Some(place) = item.get_mut(slot)
    {
        *place = if slot < COLOR { value } else { color(slot, scalar, value) };
    }
}

/// Whole numbers are sRGB codes of 8 bits (16 in `ushort`), fractions linear. Alpha is linear in both.
fn color(slot: usize, scalar: Scalar, value: f32) -> f32 {
    let most = match scalar {
        Scalar::F32 | Scalar::F64 => 1.0,
        Scalar::U16 => 65535.0,
        _ => 255.0,
    };
    let v = value / most;
    let v = if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 };
    match scalar {
        _ if slot == ALPHA => v,
        Scalar::F32 | Scalar::F64 => v,
        Scalar::U16 => srgb_to_linear(v),
        _ => srgb8_to_linear((v * 255.0 + 0.5) as u8),
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
}

/// Triangles, and what each of their corners or faces has of its own.
#[derive(Debug, Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Three per triangle, v down; empty without.
    pub(super) corner_uvs: Vec<[[f32; 2]; 3]>,
    /// One per triangle; empty without.
    pub(super) colors: Vec<[f32; 4]>,
    /// Faces whose vertices do not exist or are not finite.
    pub(super) bad: u64,
    /// Faces of less than three corners.
    pub(super) short: u64,
    /// Items that were read, and whether the file ended before all were.
    pub(super) read: u64,
    pub(super) incomplete: bool,
}

/// "element face: item 3 of 10".
fn item(element: &Element, number: u64) -> String {
    format!("element '{}', item {number} of {}", element.name, element.count)
}

fn damaged(element: &Element, number: u64, missing: Missing) -> LoadError {
    let item = item(element, number);
    let message = match missing {
        Missing::End => format!("the file ends within {item}"),
        Missing::NotANumber => format!("{item} has something that is not a (whole) number"),
    };
    LoadError::malformed(FORMAT, message)
}

/// Refuses counts that this many bytes cannot hold; then they may be allocated.
pub(super) fn check_count(element: &Element, encoding: Encoding, bytes: usize) -> Result<(), LoadError> {
    let least = element.count.saturating_mul(element.min_size(encoding));
    // The last value of a text file need not be separated from anything.
    if least > (bytes as u64).saturating_add(1) {
        let fitting = (bytes as u64).checked_div(element.min_size(encoding)).unwrap_or(0);
        return Err(damaged(element, fitting.min(element.count), Missing::End));
    }
    Ok(())
}

/// Skips an element that means nothing here.
pub(super) fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), LoadError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 0..element.count {
        for property in &element.properties {
            skip_property(property.kind, values).map_err(|m| damaged(element, number, m))?;
        }
    }
    Ok(())
}

fn skip_property(kind: Kind, values: &mut Values<'_>) -> Result<(), Missing> {
    match kind {
        Kind::One(scalar) => values.skip(scalar, 1),
        Kind::List(count, scalar) => {
            let count = u64::try_from(values.integer(count)?).map_err(|_| Missing::NotANumber)?;
            values.skip(scalar, count)
        }
    }
}

pub(super) fn vertices(element: &Element, values: &mut Values<'_>) -> Result<Vertices, LoadError> {
    let slots = Slots::new(element);
    if !slots.has(0..3) {
        return Err(LoadError::malformed(FORMAT, "element 'vertex' has no x, y and z"));
    }
    let (with_normals, with_uvs, with_colors) =
        (slots.has(NORMAL..UV), slots.has(UV..COLOR), slots.has(COLOR..ALPHA));
    let count = element.count as usize;
    let mut out = Vertices::default();
    out.positions.reserve_exact(count);
    for number in 0..element.count {
        let mut item = [0.0; NAMES.len()];
        item[ALPHA] = 1.0;
        for (property, &slot) in element.properties.iter().zip(&slots.0) {
            let read = match property.kind {
                Kind::One(scalar) => values.number(scalar).map(|value| store(&mut item, slot, value)),
                list @ Kind::List(..) => skip_property(list, values),
            };
            read.map_err(|m| damaged(element, number, m))?;
        }
        let [x, y, z, nx, ny, nz, u, v, r, g, b, a] = item;
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
    }
    Ok(out)
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
    let indices_at = element.properties.iter().position(|p| is_list(p, &["vertex_indices", "vertex_index"]));
    let uvs_at = element.properties.iter().position(|p| is_list(p, &["texcoord", "texcoords"]));
    let strips = element.name == "tristrips";
    let mut out = Faces::default();
    if indices_at.is_none() || element.properties.is_empty() {
        skip(element, values)?;
        return Ok((out, 0));
    }

    let mut triangulator = Triangulator::default();
    let (mut indices, mut uvs) = (Vec::<i64>::new(), Vec::<f32>::new());
    // Number, position and texture coordinates of each corner.
    let mut polygon: Vec<(u32, [f32; 3], [f32; 2])> = Vec::new();
    let mut item = [0.0; NAMES.len()];
    for number in 0..element.count {
        indices.clear();
        uvs.clear();
        item[ALPHA] = 1.0;
        let mut read = || -> Result<(), Missing> {
            for (k, (property, &slot)) in element.properties.iter().zip(&slots.0).enumerate() {
                match property.kind {
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
            Ok(()) => {}
            Err(Missing::End) if !out.triangles.is_empty() => {
                out.incomplete = true;
                break;
            }
            Err(missing) => return Err(damaged(element, number, missing)),
        }
        out.read = out.read.saturating_add(1);
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
        if number % 1024 == 0 || out.triangles.len().saturating_sub(first) > 1024 {
            check_mesh(context, out.triangles.len() as u64, positions.len() as u64)?;
        }
    }
    check_mesh(context, out.triangles.len() as u64, positions.len() as u64)?;
    Ok((out, triangulator.given_up))
}

/// The position of an index, if there is one that can be drawn.
fn existing(index: i64, positions: &[[f32; 3]]) -> Option<[f32; 3]> {
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
