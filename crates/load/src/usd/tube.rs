//! Tubes around polylines.

use overcoat_core::math::double::sin_cos;
use overcoat_scene::MeshData;
use std::f64::consts::TAU;

/// Sides from which on the ends of a tube are closed; thinner ones are seen by nobody.
const CLOSED: u32 = 8;

/// A place on the axis of a tube.
pub(super) struct Ring {
    pub(super) center: [f64; 3],
    pub(super) radius: f64,
    pub(super) color: Option<[f32; 4]>,
}

/// Adds the tube through rings; both ends of a closed one are the same ring. Rings at one place are one.
pub(super) fn add_tube(data: &mut MeshData, rings: &[Ring], sides: u32, is_closed: bool) {
    let mut kept: Vec<&Ring> = Vec::new();
    for ring in rings {
        if kept.last().is_none_or(|last| unit(difference(ring.center, last.center)).is_some()) {
            kept.push(ring);
        }
    }
    if kept.len() < 2 {
        return;
    }
    let frames = frames(&kept, is_closed);
    let first = data.positions.len() as u32;
    for (ring, frame) in kept.iter().zip(&frames) {
        for side in 0..=sides {
            // The seam is one place, to the last bit.
            let place = if side == sides { 0 } else { side };
            let (sin, cos) = sin_cos(TAU * f64::from(place) / f64::from(sides));
            let normal = combined([(frame.normal, cos), (frame.binormal, sin)]);
            let point = combined([(ring.center, 1.0), (normal, ring.radius)]);
            data.positions.push(point.map(|v| v as f32));
            data.normals.push(normal.map(|v| v as f32));
            data.colors.extend(ring.color);
        }
    }
    let row = sides.saturating_add(1);
    for k in 1..kept.len() as u32 {
        let [below, above] = [k.saturating_sub(1), k].map(|k| first.saturating_add(k.saturating_mul(row)));
        for side in 0..sides {
            let [a, b] = [below, above].map(|v| v.saturating_add(side));
            let [c, d] = [a, b].map(|v| v.saturating_add(1));
            data.triangles.push([a, c, d]);
            data.triangles.push([a, d, b]);
        }
    }
    if !is_closed && sides >= CLOSED {
        let ends = [(kept.first(), frames.first(), -1.0), (kept.last(), frames.last(), 1.0)];
        for (ring, frame, outwards) in ends {
            if let (Some(ring), Some(frame)) = (ring, frame) {
                add_end(data, ring, frame, sides, outwards);
            }
        }
    }
}

/// Adds a disc.
fn add_end(data: &mut MeshData, ring: &Ring, frame: &Frame, sides: u32, outwards: f64) {
    let normal = frame.tangent.map(|v| (v * outwards) as f32);
    let center = data.positions.len() as u32;
    let mut vertex = |point: [f64; 3]| {
        data.positions.push(point.map(|v| v as f32));
        data.normals.push(normal);
        data.colors.extend(ring.color);
    };
    vertex(ring.center);
    for side in 0..sides {
        let (sin, cos) = sin_cos(TAU * f64::from(side) / f64::from(sides));
        let out = combined([(frame.normal, cos), (frame.binormal, sin)]);
        vertex(combined([(ring.center, 1.0), (out, ring.radius)]));
    }
    for side in 0..sides {
        let next = side.saturating_add(1);
        let next = if next == sides { 0 } else { next };
        let [a, b] = [side, next].map(|side| center.saturating_add(1).saturating_add(side));
        data.triangles.push(if outwards > 0.0 { [center, a, b] } else { [center, b, a] });
    }
}

/// Axes of a ring: along the tube, and two across.
#[derive(Clone, Copy)]
struct Frame {
    tangent: [f64; 3],
    normal: [f64; 3],
    binormal: [f64; 3],
}

/// Frames of rings that turn as little as they can.
fn frames(rings: &[&Ring], is_closed: bool) -> Vec<Frame> {
    let last = rings.len().saturating_sub(1);
    let center = |k: usize| rings.get(k).map_or([0.0; 3], |ring| ring.center);
    let mut out: Vec<Frame> = Vec::with_capacity(rings.len());
    let mut normal = [0.0; 3];
    for k in 0..rings.len() {
        // The first and the last ring of a closed tube are one.
        let (before, after) = match () {
            () if is_closed && (k == 0 || k == last) => (last.saturating_sub(1), 1),
            () => (k.saturating_sub(1), k.saturating_add(1).min(last)),
        };
        let around = unit(difference(center(after), center(before)));
        let ahead = || unit(difference(center(k.saturating_add(1).min(last)), center(k)));
        let tangent = around.or_else(ahead).or_else(|| out.last().map(|frame| frame.tangent));
        let tangent = tangent.unwrap_or([0.0, 0.0, 1.0]);
        let own = combined([(normal, 1.0), (tangent, -dot(normal, tangent))]);
        normal = unit(own).unwrap_or_else(|| perpendicular(tangent));
        out.push(Frame { tangent, normal, binormal: cross(tangent, normal) });
    }
    if is_closed && let (Some(first), Some(end)) = (out.first().copied(), out.last_mut()) {
        *end = first;
    }
    out
}

fn perpendicular(tangent: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = tangent.map(f64::abs);
    let axis = match () {
        () if x <= y && x <= z => [1.0, 0.0, 0.0],
        () if y <= z => [0.0, 1.0, 0.0],
        () => [0.0, 0.0, 1.0],
    };
    unit(cross(tangent, axis)).unwrap_or([1.0, 0.0, 0.0])
}

fn combined<const N: usize>(parts: [([f64; 3], f64); N]) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (v, by) in parts {
        out.iter_mut().zip(v).for_each(|(sum, v)| *sum += v * by);
    }
    out
}

fn difference([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn dot([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-30 && length.is_finite()).then(|| v.map(|v| v / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tubes_are_closed_and_face_outwards() {
        let ring = |x: f64, y: f64| Ring { center: [x, y, 0.0], radius: 0.5, color: None };
        let mut data = MeshData::default();
        add_tube(&mut data, &[ring(0.0, 0.0), ring(2.0, 0.0), ring(2.0, 0.0), ring(4.0, 0.0)], 12, false);
        // Two bands of the three rings that differ, and two ends.
        assert_eq!(data.triangles.len(), 2 * 24 + 2 * 12);
        let corner = |v: u32| data.positions[v as usize].map(f64::from);
        let mut volume = 0.0;
        for t in &data.triangles {
            let [a, b, c] = t.map(corner);
            volume += dot(a, cross(b, c)) / 6.0;
            let normal = data.normals[t[0] as usize].map(f64::from);
            assert!(dot(cross(difference(b, a), difference(c, a)), normal) > 0.0);
        }
        // Four long, the area that of a polygon of twelve corners: 3 r^2.
        assert!((volume - 4.0 * 0.75).abs() < 1e-5, "{volume}");
        let mut loop_of_four = MeshData::default();
        let square = [ring(0.0, 0.0), ring(4.0, 0.0), ring(4.0, 4.0), ring(0.0, 4.0), ring(0.0, 0.0)];
        add_tube(&mut loop_of_four, &square, 4, true);
        assert_eq!(loop_of_four.triangles.len(), 4 * 8);
        assert_eq!(loop_of_four.positions[..5], loop_of_four.positions[20..]);
        let mut point = MeshData::default();
        add_tube(&mut point, &[ring(1.0, 1.0), ring(1.0, 1.0)], 4, false);
        assert!(point.triangles.is_empty());
    }
}
