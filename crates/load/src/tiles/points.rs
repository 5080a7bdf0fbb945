//! Clouds of points of a tile (pnts).

use super::FORMAT;
use super::features::{Features, unfolded};
use crate::mesh_formats::check_mesh;
use crate::point_clouds::{Points, add};
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_scene::Scene;
use serde_json::Value;

/// The cloud about its centre, in the axes of the tile.
pub(super) fn scene(
    features: &Features<'_>,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Scene, LoadError> {
    let count = features.count("POINTS_LENGTH")?;
    let mut points = match features.value("extensions").and_then(|e| e.get("3DTILES_draco_point_compression"))
    {
        Some(stream) => compressed(features, stream, context)?,
        None => Points::default(),
    };
    if points.positions.is_empty() {
        // No more than there are bytes for.
        check_mesh(context, 0, (count as u64).min(features.binary().len() as u64 / 6).saturating_mul(2))?;
        let missing = || LoadError::malformed(FORMAT, "the points have no positions");
        points.positions = features.positions(count)?.ok_or_else(missing)?;
    }
    let count = points.positions.len();
    if points.colors.is_empty() {
        points.colors = colors(features, count)?;
    }
    if points.normals.is_empty() {
        points.normals = normals(features, count)?;
    }
    let mut scene = Scene::new();
    add(&mut scene, FORMAT, points, 0, warnings)?;
    Ok(scene)
}

fn colors(features: &Features<'_>, count: usize) -> Result<Vec<[f32; 4]>, LoadError> {
    let linear = |r: u8, g: u8, b: u8| [srgb8_to_linear(r), srgb8_to_linear(g), srgb8_to_linear(b), 1.0];
    if let Some(rows) = features.rows("RGBA", 4, count)? {
        return Ok(rows.as_chunks().0.iter().map(|&[r, g, b, _]| linear(r, g, b)).collect());
    }
    if let Some(rows) = features.rows("RGB", 3, count)? {
        return Ok(rows.as_chunks().0.iter().map(|&[r, g, b]| linear(r, g, b)).collect());
    }
    if let Some(rows) = features.rows("RGB565", 2, count)? {
        let of = |&bytes: &[u8; 2]| {
            let code = u16::from_le_bytes(bytes);
            let part = |code: u16, most: f32| (f32::from(code) / most * 255.0 + 0.5) as u8;
            linear(part(code >> 11, 31.0), part(code >> 5 & 63, 63.0), part(code & 31, 31.0))
        };
        return Ok(rows.as_chunks().0.iter().map(of).collect());
    }
    let constant = match features.value("CONSTANT_RGBA") {
        // In the binary part they are bytes.
        Some(Value::Object(_)) => {
            let bytes = features.rows("CONSTANT_RGBA", 4, 1)?.and_then(|bytes| bytes.first_chunk());
            bytes.map(|&[r, g, b, _]| linear(r, g, b))
        }
        _ => features.numbers::<4>("CONSTANT_RGBA")?.map(|[r, g, b, _]| linear(r as u8, g as u8, b as u8)),
    };
    Ok(constant.map(|color| vec![color; count]).unwrap_or_default())
}

fn normals(features: &Features<'_>, count: usize) -> Result<Vec<[f32; 3]>, LoadError> {
    let normals = match features.triples("NORMAL", count)? {
        Some(normals) => normals,
        None => match features.rows("NORMAL_OCT16P", 2, count)? {
            Some(rows) => {
                let of = |code: &[u8; 2]| unfolded(code.map(|part| f32::from(part) / 255.0 * 2.0 - 1.0));
                rows.as_chunks().0.iter().map(of).collect()
            }
            None => Vec::new(),
        },
    };
    let known = |n: [f32; 3]| if n.iter().all(|v| v.is_finite()) { n } else { [0.0; 3] };
    Ok(normals.into_iter().map(known).collect())
}

/// Values in a Draco stream in the binary part (3DTILES_draco_point_compression).
#[cfg(feature = "compression")]
fn compressed(features: &Features<'_>, stream: &Value, context: &Context<'_>) -> Result<Points, LoadError> {
    let number = |value: Option<&Value>| value.and_then(Value::as_u64);
    let place = |name: &str| number(stream.get(name)).and_then(|v| usize::try_from(v).ok());
    let bytes = place("byteOffset").zip(place("byteLength"));
    let bytes = bytes.and_then(|(start, length)| features.binary().get(start..)?.get(..length));
    let outside = || LoadError::malformed(FORMAT, "the Draco stream is not within the feature table");
    let mesh = crate::draco::decode(FORMAT, bytes.ok_or_else(outside)?, context)?;
    let attribute = |name: &str| {
        let id = number(stream.get("properties").and_then(|names| names.get(name)))?;
        mesh.attribute_by_unique_id(u32::try_from(id).ok()?)
    };
    let count = mesh.num_points();
    let triples = |name: &str| {
        let found = attribute(name).filter(|attribute| attribute.num_components() == 3);
        found.map(|attribute| crate::draco::triples(attribute, count)).unwrap_or_default()
    };
    let color = ["RGBA", "RGB"].into_iter().find_map(attribute);
    Ok(Points {
        positions: triples("POSITION"),
        normals: triples("NORMAL"),
        colors: color.and_then(|attribute| crate::draco::colors(attribute, count)).unwrap_or_default(),
        ..Points::default()
    })
}

#[cfg(not(feature = "compression"))]
fn compressed(_: &Features<'_>, _: &Value, _: &Context<'_>) -> Result<Points, LoadError> {
    Err(LoadError::unsupported("Draco", overcoat_core::formats::LEFT_OUT))
}
