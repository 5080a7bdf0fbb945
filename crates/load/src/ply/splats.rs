//! PLY files of Gaussian splats, as trainers write them.
//!
//! Properties of each vertex: `x y z`, the logarithms `scale_0..2`, the quaternion `rot_0..3` (w first), the `opacity`
//! before the logistic function, and coefficients of spherical harmonics: `f_dc_0..2` of degree 0, and `f_rest_*` of
//! the others, all of red before all of green and blue. Such files come from photographs whose cameras look along +Z
//! with +Y down, so -Y is up, unless a comment names another `Vertical Axis`.

use super::body::{cut, skip, skip_property};
use super::header::{Element, Encoding, Header, Kind, Scalar};
use super::packed;
use super::values::{Missing, Values};
use super::{FACES, FORMAT, VERTICES};
use crate::splat_clouds::{Cloud, DEGREE_0, UP_OF_CAPTURES, coefficients};
use crate::warnings::Warnings;
use crate::warnings::counted;
use crate::{Context, LoadError, Loaded};
use overcoat_core::math::scalar::exp;
use overcoat_scene::Splat;

/// Names of what every splat has, in the order of [`Row`]'s slots.
const NAMES: [&str; 14] = [
    "x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity", "f_dc_0",
    "f_dc_1", "f_dc_2",
];

/// Names that tell a file of splats.
const SURE: [&str; 5] = ["scale_0", "scale_1", "rot_0", "opacity", "f_dc_0"];

/// The one of [`NAMES`] that flat splats do not have.
const THICKNESS: usize = 5;

/// Layout of the splats in a file.
pub(super) enum Layout {
    /// A number for each property.
    Plain,
    /// Several in each word, relative to boxes of 256 splats.
    Packed,
}

/// Layout of the file's splats; `None` if it holds something else.
pub(super) fn layout(header: &Header<'_>) -> Option<Layout> {
    let is =
        |names: &[&str]| header.elements.iter().find(|e| names.contains(&e.name.as_str()) && e.count > 0);
    let vertex = is(&VERTICES)?;
    let has = |names: &[&str]| names.iter().all(|name| vertex.properties.iter().any(|p| p.name == *name));
    if is(&FACES).is_some() {
        None
    } else if has(&SURE) {
        Some(Layout::Plain)
    } else if has(&["packed_position", "packed_rotation", "packed_scale", "packed_color"]) {
        Some(Layout::Packed)
    } else {
        None
    }
}

/// Takes away the `scalar_` that CloudCompare puts before the names of what it does not know, where they are those of splats.
pub(super) fn take_prefixes_away(header: &mut Header<'_>) {
    let is_of_splats = |name: &str| NAMES.contains(&name) || name.starts_with("f_rest_");
    for element in header.elements.iter_mut().filter(|e| VERTICES.contains(&e.name.as_str())) {
        let names: Vec<String> = element.properties.iter().map(|p| p.name.clone()).collect();
        // `scal_` before version 2.6.
        let plain = |name: &str| -> Option<String> {
            let rest = name.strip_prefix("scalar_").or_else(|| name.strip_prefix("scal_"))?;
            (is_of_splats(rest) && !names.iter().any(|other| other == rest)).then(|| rest.to_owned())
        };
        let renamed: Vec<String> =
            names.iter().map(|name| plain(name).unwrap_or_else(|| name.clone())).collect();
        if SURE.iter().all(|sure| renamed.iter().any(|name| name == sure)) {
            element.properties.iter_mut().zip(renamed).for_each(|(property, name)| property.name = name);
        }
    }
}

/// Reads a file of splats. One that ends too early is drawn as far as it goes, with a warning; splats that are not finite are
/// left out, with a warning.
pub(super) fn load(
    layout: &Layout,
    header: &Header<'_>,
    context: &Context<'_>,
    mut warnings: Warnings,
) -> Result<Loaded, LoadError> {
    let cloud = match layout {
        Layout::Plain => read(header, context, &mut warnings)?,
        Layout::Packed => packed::read(header, context, &mut warnings)?,
    };
    cloud.finish(header.up.unwrap_or(UP_OF_CAPTURES), warnings)
}

/// An empty cloud with room for as many splats as the file says, if it can hold them.
pub(super) fn cloud(
    element: &Element,
    encoding: Encoding,
    bytes: usize,
    degree: u8,
    context: &Context<'_>,
) -> Result<Cloud, LoadError> {
    let least = element.min_size(encoding).max(1);
    let count = element.count.min((bytes as u64).saturating_add(1).checked_div(least).unwrap_or(0));
    Cloud::new(FORMAT, count, degree, context)
}

/// The degree that so many coefficients of one colour above degree 0 suffice for. Others are left over, with a warning.
pub(super) fn degree_of(each: usize, all: usize, warnings: &mut Warnings) -> u8 {
    let degree = (0..=3).rev().find(|&degree| coefficients(degree) <= each).unwrap_or(0);
    if coefficients(degree).saturating_mul(3) != all {
        warnings.add(|| format!("PLY: of {all} properties 'f_rest_*' those of degree {degree} are drawn"));
    }
    degree
}

fn read(header: &Header<'_>, context: &Context<'_>, warnings: &mut Warnings) -> Result<Cloud, LoadError> {
    let mut values = Values::new(header.encoding, header.body);
    for element in &header.elements {
        if !VERTICES.contains(&element.name.as_str()) {
            skip(element, &mut values).map_err(|message| LoadError::malformed(FORMAT, message))?;
            continue;
        }
        let place = |name: &str| element.properties.iter().position(|p| p.name == name);
        let mut places = [usize::MAX; NAMES.len()];
        for (k, (slot, name)) in places.iter_mut().zip(NAMES).enumerate() {
            match place(name) {
                Some(found) => *slot = found,
                None if k == THICKNESS => {}
                None => {
                    let message = format!("element 'vertex' has splats without '{name}'");
                    return Err(LoadError::malformed(FORMAT, message));
                }
            }
        }
        let rest: Vec<usize> = (0..).map_while(|k| place(&format!("f_rest_{k}"))).collect();
        let each = rest.len().checked_div(3).unwrap_or(0);
        let degree = degree_of(each, rest.len(), warnings);
        if place("filter_3D").is_some() {
            warnings.add(|| "PLY: 'filter_3D' of the splats has no effect".to_owned());
        }
        let mut cloud = cloud(element, header.encoding, header.body.len(), degree, context)?;
        let mut harmonics = [[0.0; 3]; 15];
        let harmonics = harmonics.get_mut(..coefficients(degree)).unwrap_or_default();
        each_row(element, &mut values, warnings, |row| {
            let at = |place: usize| row.get(place).copied().unwrap_or(0.0);
            let [x, y, z, s0, s1, s2, w, i, j, k, opacity, r, g, b] = places.map(at);
            let flat = places.get(THICKNESS) == Some(&usize::MAX);
            for (n, coefficient) in harmonics.iter_mut().enumerate() {
                for (c, value) in coefficient.iter_mut().enumerate() {
                    let place = rest.get(c.saturating_mul(each).saturating_add(n));
                    *value = place.map_or(0.0, |&place| at(place));
                }
            }
            let splat = Splat {
                position: [x, y, z],
                scale: [exp(s0), exp(s1), if flat { 0.0 } else { exp(s2) }],
                rotation: [i, j, k, w],
                opacity: 1.0 / (1.0 + exp(-opacity)),
                color: [r, g, b].map(|v| 0.5 + DEGREE_0 * v),
            };
            cloud.push(splat, harmonics);
        })?;
        return Ok(cloud);
    }
    Err(LoadError::malformed(FORMAT, "there is no element 'vertex'"))
}

/// Calls `f` with the numbers of each item, 0 in the place of a list. Where the file ends within them, those that are complete
/// count, with a warning.
pub(super) fn each_row(
    element: &Element,
    values: &mut Values<'_>,
    warnings: &mut Warnings,
    mut f: impl FnMut(&[f32]),
) -> Result<(), LoadError> {
    let mut row = vec![0.0_f32; element.properties.len()];
    let mut read = 0_u64;
    let plain = element.properties.iter().all(|p| matches!(p.kind, Kind::One(Scalar::F32)));
    while read < element.count {
        let mut next = || -> Result<(), Missing> {
            // Nearly all files are like that, and large.
            if let (Values::LittleEndian(bytes), true) = (&mut *values, plain) {
                let (head, rest) = bytes.split_at_checked(row.len().saturating_mul(4)).ok_or(Missing::End)?;
                *bytes = rest;
                for (value, bytes) in row.iter_mut().zip(head.as_chunks().0) {
                    *value = f32::from_le_bytes(*bytes);
                }
                return Ok(());
            }
            for (value, property) in row.iter_mut().zip(&element.properties) {
                match property.kind {
                    Kind::One(scalar) => *value = values.number(scalar)?,
                    list @ Kind::List(..) => skip_property(list, values)?,
                }
            }
            Ok(())
        };
        match next() {
            Ok(()) => f(&row),
            // Harmonics are no reason not to draw.
            Err(Missing::End) if read > 0 || element.name == "sh" => {
                let all = counted(element.count, "splat");
                warnings.add(|| format!("PLY: the file ends after {read} of {all}"));
                break;
            }
            Err(missing) => return Err(LoadError::malformed(FORMAT, cut(element, read, missing))),
        }
        if element.by_line {
            values.skip_line();
        }
        read = read.saturating_add(1);
    }
    Ok(())
}
