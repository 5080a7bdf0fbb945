//! Places of an instanced model (i3dm).

use super::FORMAT;
use super::earth;
use super::features::{Features, unfolded};
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_scene::Transform;

/// Places of the instances relative to the centre of the tile, in its axes.
pub(super) fn places(
    features: &Features<'_>,
    center: [f64; 3],
    context: &Context<'_>,
) -> Result<Vec<Transform>, LoadError> {
    let count = features.count("INSTANCES_LENGTH")?;
    let what = || format!("{FORMAT}: the number of instances");
    Limits::check(what, count as u64, context.limits.nodes, "nodes")?;
    let missing = || LoadError::malformed(FORMAT, "the instances have no positions");
    let positions = features.positions(count)?.ok_or_else(missing)?;
    let [up, right] = [["NORMAL_UP", "NORMAL_UP_OCT32P"], ["NORMAL_RIGHT", "NORMAL_RIGHT_OCT32P"]];
    let (up, right) = (directions(features, up, count)?, directions(features, right, count)?);
    let is_on_earth = features.value("EAST_NORTH_UP").and_then(|value| value.as_bool()) == Some(true);
    let scale = features.rows("SCALE", 4, count)?.map(|rows| rows.as_chunks().0);
    let scales = features.triples("SCALE_NON_UNIFORM", count)?;
    let mut places = Vec::with_capacity(count);
    for (k, position) in positions.iter().enumerate() {
        let position = position.map(f64::from);
        let axes = match (up.as_ref().and_then(|up| up.get(k)), right.as_ref().and_then(|r| r.get(k))) {
            (Some(up), Some(right)) => axes(up.map(f64::from), right.map(f64::from)),
            _ if is_on_earth => {
                let [x, y, z] = position;
                let [cx, cy, cz] = center;
                earth::axes([x + cx, y + cy, z + cz])
            }
            _ => IDENTITY,
        };
        let mut size =
            scales.as_ref().and_then(|scales| scales.get(k)).map_or([1.0; 3], |s| s.map(f64::from));
        if let Some(&scale) = scale.and_then(|scale| scale.get(k)) {
            size = size.map(|v| v * f64::from(f32::from_le_bytes(scale)));
        }
        places.push(transform(axes, size, position)?);
    }
    Ok(places)
}

/// Axes that turn nothing.
pub(super) const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Unit vectors of rows, whole or packed into two shorts.
fn directions(
    features: &Features<'_>,
    [whole, packed]: [&str; 2],
    count: usize,
) -> Result<Option<Vec<[f32; 3]>>, LoadError> {
    if let Some(found) = features.triples(whole, count)? {
        return Ok(Some(found));
    }
    let rows = features.rows(packed, 4, count)?;
    let part = |code: [u8; 2]| f32::from(u16::from_le_bytes(code)) / 65535.0 * 2.0 - 1.0;
    let of = |&[a, b, c, d]: &[u8; 4]| unfolded([part([a, b]), part([c, d])]);
    Ok(rows.map(|rows| rows.as_chunks().0.iter().map(of).collect()))
}

/// Right, up, and what is square to both (3D Tiles 1.0, *Instanced 3D Model*, "Instance orientation").
fn axes(up: [f64; 3], right: [f64; 3]) -> [[f64; 3]; 3] {
    let ([a, b, c], [d, e, f]) = (right, up);
    [right, up, [b * f - c * e, c * d - a * f, a * e - b * d]]
}

/// The transform of axes, sizes along them and a position.
fn transform(axes: [[f64; 3]; 3], size: [f64; 3], position: [f64; 3]) -> Result<Transform, LoadError> {
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = axes;
    let ([sx, sy, sz], [x, y, z]) = (size, position);
    let rows =
        [[ax * sx, bx * sy, cx * sz, x], [ay * sx, by * sy, cy * sz, y], [az * sx, bz * sy, cz * sz, z]];
    Transform::from_rows(rows).map_err(LoadError::scene(format!("{FORMAT}: an instance")))
}
