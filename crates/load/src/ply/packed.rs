//! The compressed splats of PlayCanvas and SuperSplat: four words each, relative to boxes of 256 splats.
//!
//! `packed_position` and `packed_scale` hold 11, 10 and 11 bits between the least and the largest of the box,
//! `packed_rotation` the place of the quaternion's largest number and 10 bits of each other, `packed_color` 8 bits of red,
//! green, blue and opacity. Harmonics above degree 0, if any, are bytes from -4 to 4 of an element `sh`.

use super::FORMAT;
use super::body::{cut, skip, skip_property};
use super::header::{Element, Header, Kind};
use super::splats::{self, each_row};
use super::values::Values;
use crate::splat_clouds::{Cloud, coefficients};
use crate::warnings::Warnings;
use crate::warnings::counted;
use crate::{Context, LoadError};
use overcoat_core::math::scalar::exp;
use overcoat_scene::Splat;

/// Splats of a box.
const PER_BOX: usize = 256;

/// Properties of a box: least and largest position, scale and colour.
const BOUNDS: [&str; 18] = [
    "min_x",
    "min_y",
    "min_z",
    "max_x",
    "max_y",
    "max_z",
    "min_scale_x",
    "min_scale_y",
    "min_scale_z",
    "max_scale_x",
    "max_scale_y",
    "max_scale_z",
    "min_r",
    "min_g",
    "min_b",
    "max_r",
    "max_g",
    "max_b",
];

/// The words of a splat.
const WORDS: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];

/// Reads the elements in the order of the header.
pub(super) fn read(
    header: &Header<'_>,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Cloud, LoadError> {
    let mut values = Values::new(header.encoding, header.body);
    let (mut boxes, mut found) = (Vec::new(), None);
    let mut harmonics: Vec<u8> = Vec::new();
    let of_sh = header.elements.iter().find(|e| e.name == "sh");
    let each = of_sh.map_or(0, |e| e.properties.len()).checked_div(3).unwrap_or(0);
    let degree = splats::degree_of(each, of_sh.map_or(0, |e| e.properties.len()), warnings);
    for element in &header.elements {
        match element.name.as_str() {
            "chunk" => boxes = read_boxes(element, &mut values, header.body.len(), warnings)?,
            "vertex" => {
                let cloud = splats::cloud(element, header.encoding, header.body.len(), degree, context)?;
                found = Some((cloud, read_words(element, &mut values, header.body.len(), warnings)?));
            }
            "sh" => {
                let size = element.count.saturating_mul(element.properties.len() as u64);
                harmonics.reserve(usize::try_from(size).unwrap_or(0).min(header.body.len()));
                each_row(element, &mut values, warnings, |row| {
                    harmonics.extend(row.iter().map(|&v| v as u8));
                })?;
            }
            _ => skip(element, &mut values).map_err(|message| LoadError::malformed(FORMAT, message))?,
        }
    }
    let Some((mut cloud, words)) = found else {
        return Err(LoadError::malformed(FORMAT, "there is no element 'vertex'"));
    };
    let needed = words.len().div_ceil(PER_BOX);
    if boxes.len() < needed {
        let boxes = boxes.len();
        let message = format!("{boxes} items of element 'chunk' for {} packed splats", words.len());
        return Err(LoadError::malformed(FORMAT, message));
    }
    let stride = each.saturating_mul(3).max(of_sh.map_or(0, |e| e.properties.len()));
    let mut own = [[0.0; 3]; 15];
    let own = own.get_mut(..coefficients(degree)).unwrap_or_default();
    let mut without = 0_u64;
    let chunks = words.chunks(PER_BOX).zip(&boxes);
    let all = chunks.flat_map(|(words, bounds)| words.iter().map(move |words| (words, bounds)));
    for (number, (words, bounds)) in all.enumerate() {
        let first = number.saturating_mul(stride);
        let bytes = harmonics.get(first..first.saturating_add(stride)).unwrap_or_default();
        without = without.saturating_add(u64::from(bytes.is_empty() && stride > 0));
        for (n, coefficient) in own.iter_mut().enumerate() {
            for (c, value) in coefficient.iter_mut().enumerate() {
                let byte = bytes.get(c.saturating_mul(each).saturating_add(n));
                *value = byte.map_or(0.0, |&byte| harmonic(byte));
            }
        }
        cloud.push(unpack(words, bounds), own);
    }
    if without > 0 {
        let splats = counted(without, "splat");
        warnings.add(|| format!("PLY: {splats} without spherical harmonics of the element 'sh'"));
    }
    Ok(cloud)
}

/// A coefficient, whose two outermost codes stand for the ends of the range.
fn harmonic(byte: u8) -> f32 {
    match byte {
        0 => -4.0,
        255 => 4.0,
        _ => ((f32::from(byte) + 0.5) / 256.0 - 0.5) * 8.0,
    }
}

fn read_boxes(
    element: &Element,
    values: &mut Values<'_>,
    bytes: usize,
    warnings: &mut Warnings,
) -> Result<Vec<[f32; BOUNDS.len()]>, LoadError> {
    let places = BOUNDS.map(|name| element.properties.iter().position(|p| p.name == name));
    // No more than the file can hold.
    let most = bytes.checked_div(size_of::<[f32; BOUNDS.len()]>()).unwrap_or(0);
    let mut boxes = Vec::with_capacity(usize::try_from(element.count).unwrap_or(0).min(most));
    each_row(element, values, warnings, |row| {
        let mut bounds = [0.0; BOUNDS.len()];
        for (k, (value, place)) in bounds.iter_mut().zip(places).enumerate() {
            // Files without ranges of colours mean 0 to 1.
            let missing = if k < 15 { 0.0 } else { 1.0 };
            *value = place.and_then(|place| row.get(place).copied()).unwrap_or(missing);
        }
        boxes.push(bounds);
    })?;
    Ok(boxes)
}

fn read_words(
    element: &Element,
    values: &mut Values<'_>,
    bytes: usize,
    warnings: &mut Warnings,
) -> Result<Vec<[u32; 4]>, LoadError> {
    let most = bytes.checked_div(size_of::<[u32; 4]>()).unwrap_or(0);
    let mut all = Vec::with_capacity(usize::try_from(element.count).unwrap_or(0).min(most));
    for number in 0..element.count {
        let mut words = [0; 4];
        let mut next = || {
            for property in &element.properties {
                match property.kind {
                    Kind::One(scalar) => {
                        let value = values.integer(scalar)?;
                        if let Some(k) = WORDS.iter().position(|name| *name == property.name)
                            && let Some(word) = words.get_mut(k)
                        {
                            *word = value as u32;
                        }
                    }
                    list @ Kind::List(..) => skip_property(list, values)?,
                }
            }
            Ok(())
        };
        match next() {
            Ok(()) => all.push(words),
            Err(super::values::Missing::End) if number > 0 => {
                let count = counted(element.count, "splat");
                warnings.add(|| format!("PLY: the file ends after {number} of {count}"));
                break;
            }
            Err(missing) => return Err(LoadError::malformed(FORMAT, cut(element, number, missing))),
        }
    }
    Ok(all)
}

/// The lowest bits of a word after a shift, as a number from 0 to 1.
fn fraction(word: u32, shift: u32, bits: u32) -> f32 {
    let most = 1_u32.wrapping_shl(bits).wrapping_sub(1);
    (word.wrapping_shr(shift) & most) as f32 / most as f32
}

fn unpack(&[position, rotation, scale, color]: &[u32; 4], bounds: &[f32; BOUNDS.len()]) -> Splat {
    let [p0, p1, p2, q0, q1, q2, s0, s1, s2, t0, t1, t2, r0, g0, b0, r1, g1, b1] = *bounds;
    let between = |least: f32, most: f32, t: f32| least * (1.0 - t) + most * t;
    let thirds = |word: u32| [fraction(word, 21, 11), fraction(word, 11, 10), fraction(word, 0, 11)];
    let mix = |least: [f32; 3], most: [f32; 3], t: [f32; 3]| {
        let ([a, b, c], [d, e, f], [s, t, u]) = (least, most, t);
        [between(a, d, s), between(b, e, t), between(c, f, u)]
    };
    let small = |shift: u32| (fraction(rotation, shift, 10) - 0.5) * std::f32::consts::SQRT_2;
    let [a, b, c] = [small(20), small(10), small(0)];
    let rest = 1.0 - (a * a + b * b + c * c);
    let largest = if rest > 0.0 { rest.sqrt() } else { 0.0 };
    let [w, x, y, z] = match rotation.wrapping_shr(30) {
        0 => [largest, a, b, c],
        1 => [a, largest, b, c],
        2 => [a, b, largest, c],
        _ => [a, b, c, largest],
    };
    let codes = [fraction(color, 24, 8), fraction(color, 16, 8), fraction(color, 8, 8)];
    Splat {
        position: mix([p0, p1, p2], [q0, q1, q2], thirds(position)),
        scale: mix([s0, s1, s2], [t0, t1, t2], thirds(scale)).map(exp),
        rotation: [x, y, z, w],
        opacity: fraction(color, 0, 8),
        color: mix([r0, g0, b0], [r1, g1, b1], codes),
    }
}
