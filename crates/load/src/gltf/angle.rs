//! Sine and cosine with the same bits everywhere.

use overcoat_core::math::tan_half;
use std::f64::consts::{PI, TAU};

/// Sine and cosine of an angle in radians, to about 1e-15 for angles of a few turns.
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    let turn = angle - TAU * (angle / TAU).floor();
    let (half_turn, sign) = if turn > PI { (TAU - turn, -1.0) } else { (turn, 1.0) };
    // The tangent of a quarter of the angle is at most 1; doubling the angle once more gives the whole.
    let t = tan_half(half_turn * 0.5);
    let square = t * t;
    let (sin, cos) = (2.0 * t / (1.0 + square), (1.0 - square) / (1.0 + square));
    (sign * 2.0 * sin * cos, cos * cos - sin * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_angles() {
        let half = 0.5_f64.sqrt();
        let cases = [
            (0.0, 0.0, 1.0),
            (PI / 6.0, 0.5, 0.75_f64.sqrt()),
            (PI / 4.0, half, half),
            (PI / 2.0, 1.0, 0.0),
            (PI, 0.0, -1.0),
            (-PI / 2.0, -1.0, 0.0),
            (1.5 * PI, -1.0, 0.0),
            (TAU + PI / 6.0, 0.5, 0.75_f64.sqrt()),
        ];
        for (angle, sin, cos) in cases {
            let (s, c) = sin_cos(angle);
            assert!((s - sin).abs() < 1e-14 && (c - cos).abs() < 1e-14, "{angle}: {s} {c}");
        }
    }

    #[test]
    fn they_lie_on_the_circle() {
        for k in -1000..1000 {
            let (s, c) = sin_cos(f64::from(k) * 0.0137);
            assert!((s * s + c * c - 1.0).abs() < 1e-14);
        }
    }
}
