//! Transforms of prims: the operations of `xformOpOrder`, the first of which is the outermost (UsdGeomXformable).

use super::compose::Composed;
use overcoat_scene::{SceneError, Transform};

/// The transform of a prim in its parent, and whether it stands on the stage itself instead.
pub(super) fn local(prim: &Composed) -> Result<(Transform, bool), SceneError> {
    let mut transform = Transform::IDENTITY;
    let mut is_reset = false;
    let Some(order) = prim.value("xformOpOrder") else { return Ok((transform, false)) };
    for op in order.texts() {
        if op == "!resetXformStack!" {
            (transform, is_reset) = (Transform::IDENTITY, true);
            continue;
        }
        let (name, is_inverse) = match op.strip_prefix("!invert!") {
            Some(name) => (name, true),
            None => (op.as_str(), false),
        };
        let mut own = operation(prim, name)?;
        if is_inverse {
            own = inverse(&own)?;
        }
        transform = transform.after(&own)?;
    }
    Ok((transform, is_reset))
}

/// One operation, by its full name: `xformOp:rotateXYZ:pivot`. The identity for what has no value.
fn operation(prim: &Composed, name: &str) -> Result<Transform, SceneError> {
    let kind = name.strip_prefix("xformOp:").unwrap_or(name).split(':').next().unwrap_or_default();
    let Some(value) = prim.value(name) else { return Ok(Transform::IDENTITY) };
    let scaled = |scale: [f64; 3]| Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], scale);
    let first = value.doubles().first().copied().unwrap_or(0.0);
    let vector = value.tuple::<3>();
    match (kind, vector) {
        ("translate", Some(by)) => Transform::translation(by),
        ("translateX", _) => Transform::translation([first, 0.0, 0.0]),
        ("translateY", _) => Transform::translation([0.0, first, 0.0]),
        ("translateZ", _) => Transform::translation([0.0, 0.0, first]),
        ("scale", Some(by)) => scaled(by),
        ("scaleX", _) => scaled([first, 1.0, 1.0]),
        ("scaleY", _) => scaled([1.0, first, 1.0]),
        ("scaleZ", _) => scaled([1.0, 1.0, first]),
        ("orient", _) => {
            let rotation = value.tuple::<4>().unwrap_or([0.0, 0.0, 0.0, 1.0]);
            Transform::from_parts([0.0; 3], rotation, [1.0; 3])
        }
        ("transform", _) => value.tuple::<16>().map_or(Ok(Transform::IDENTITY), matrix),
        (kind, _) => {
            let Some(axes) = kind.strip_prefix("rotate") else { return Ok(Transform::IDENTITY) };
            let angles = if axes.len() == 1 { [first; 3] } else { vector.unwrap_or_default() };
            let mut out = Transform::IDENTITY;
            // The axis that is named first turns first.
            for axis in axes.chars() {
                let (axis, angle) = match axis {
                    'X' => ([1.0, 0.0, 0.0], angles[0]),
                    'Y' => ([0.0, 1.0, 0.0], angles[1]),
                    'Z' => ([0.0, 0.0, 1.0], angles[2]),
                    _ => continue,
                };
                out = Transform::rotation(axis, (angle % 360.0).to_radians())?.after(&out)?;
            }
            Ok(out)
        }
    }
}

/// Matrices are written for vectors in rows: their rows are columns here.
fn matrix(m: [f64; 16]) -> Result<Transform, SceneError> {
    Transform::from_columns(m)
}

/// Affine inverse. Singular matrices have none: the identity.
fn inverse(of: &Transform) -> Result<Transform, SceneError> {
    let determinant = of.determinant();
    if determinant == 0.0 || !determinant.is_finite() {
        return Ok(Transform::IDENTITY);
    }
    let [[a, b, c, x], [d, e, f, y], [g, h, i, z]] = *of.rows();
    let inverse = [
        [e * i - f * h, c * h - b * i, b * f - c * e],
        [f * g - d * i, a * i - c * g, c * d - a * f],
        [d * h - e * g, b * g - a * h, a * e - b * d],
    ];
    let rows = inverse.map(|row| {
        let [p, q, r] = row.map(|v| v / determinant);
        [p, q, r, -(p * x + q * y + r * z)]
    });
    Transform::from_rows(rows)
}
