//! Axes along the spine of an extrusion (ISO/IEC 14772-1, 6.18).

use overcoat_core::math::double::sin_cos;

type Vector = [f64; 3];

fn less([a, b, c]: Vector, [x, y, z]: Vector) -> Vector {
    [a - x, b - y, c - z]
}

fn cross([a, b, c]: Vector, [x, y, z]: Vector) -> Vector {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn dot([a, b, c]: Vector, [x, y, z]: Vector) -> f64 {
    a * x + b * y + c * z
}

/// The vector at length 1; `None` for one without.
fn unit(v: Vector) -> Option<Vector> {
    let length = dot(v, v).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|c| c / length))
}

/// A vector turned about an axis by an angle (O. Rodrigues).
pub(super) fn turned(v: Vector, [x, y, z, angle]: [f64; 4]) -> Vector {
    // Sines of angles beyond are not known.
    let Some(axis) = unit([x, y, z]).filter(|_| angle.abs() < 1e6) else { return v };
    let (sin, cos) = sin_cos(angle);
    let (across, along) = (cross(axis, v), dot(axis, v) * (1.0 - cos));
    let ([a, b, c], [d, e, f], [g, h, i]) = (v, across, axis);
    [a * cos + d * sin + g * along, b * cos + e * sin + h * along, c * cos + f * sin + i * along]
}

/// Axes x, y and z at each point of a spine of two points or more.
pub(super) fn axes(spine: &[Vector]) -> Vec<[Vector; 3]> {
    let count = spine.len();
    let last = count.saturating_sub(1);
    let is_closed = count > 2 && spine.first() == spine.last();
    let at = |k: usize| spine.get(k).copied().unwrap_or_default();
    // Points before and after one; around, where the spine is closed.
    let around = |k: usize| {
        let before = if k == 0 && is_closed { last.saturating_sub(1) } else { k.saturating_sub(1) };
        let after = if k >= last && is_closed { 1 } else { k.saturating_add(1).min(last) };
        (at(before), at(after))
    };
    let mut along = Vec::with_capacity(count);
    let mut across: Vec<Option<Vector>> = Vec::with_capacity(count);
    for k in 0..count {
        let (before, after) = around(k);
        along.push(unit(less(after, before)));
        across.push(unit(cross(less(after, at(k)), less(before, at(k)))));
    }
    // Directions that are not known are those of the neighbours.
    let first_along = along.iter().flatten().next().copied().unwrap_or([0.0, 1.0, 0.0]);
    let first_across = across.iter().flatten().next().copied().unwrap_or_else(|| across_line(first_along));
    let (mut y, mut z) = (first_along, first_across);
    let mut out = Vec::with_capacity(count);
    for (along, across) in along.into_iter().zip(across) {
        y = along.unwrap_or(y);
        let next = across.unwrap_or(z);
        z = if dot(next, z) < 0.0 { next.map(|c| -c) } else { next };
        let x = unit(cross(y, z)).unwrap_or([1.0, 0.0, 0.0]);
        out.push([x, y, z]);
    }
    out
}

/// The z axis along a straight spine: that of the y axis, turned as +Y is to the spine.
fn across_line(along: Vector) -> Vector {
    let [x, y, z] = along;
    // By the shortest rotation from +Y, whose axis is (z, 0, -x) and whose cosine is y.
    if y < -1.0 + 1e-9 {
        return [0.0, 0.0, -1.0];
    }
    let k = 1.0 / (1.0 + y);
    [-x * z * k, -z, 1.0 - z * z * k]
}
