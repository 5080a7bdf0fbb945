//! Sine and cosine of a part of a full turn, the same bits on every machine.
//!
//! The models do not use `overcoat_core::math`, so that a better polynomial there never moves a vertex here.

use glam::DVec2;

/// Half the circumference of the unit circle.
const PI: f64 = std::f64::consts::PI;

/// (cosine, sine) of `turns` full turns; the error stays below 1e-15 for moderate angles.
pub fn unit(turns: f64) -> DVec2 {
    let quarter = (turns * 4.0 + 0.5).floor();
    let x = (turns - quarter * 0.25) * (2.0 * PI);
    let (cosine, sine) = (taylor(x, 0), x * taylor(x, 1));
    match (quarter - (quarter * 0.25).floor() * 4.0) as u8 {
        0 => DVec2::new(cosine, sine),
        1 => DVec2::new(-sine, cosine),
        2 => DVec2::new(-cosine, -sine),
        _ => DVec2::new(sine, -cosine),
    }
}

/// The series of cos x (`odd` = 0) or sin x / x (`odd` = 1) up to the 18th power, for |x| <= pi / 4.
fn taylor(x: f64, odd: u32) -> f64 {
    let square = x * x;
    let mut sum = 1.0;
    for k in (1..=9).rev() {
        let n = f64::from(2 * k + odd);
        sum = 1.0 - square / (n * (n - 1.0)) * sum;
    }
    sum
}

/// Cosine of `turns` full turns.
pub fn cos(turns: f64) -> f64 {
    unit(turns).x
}

/// Sine of `turns` full turns.
pub fn sin(turns: f64) -> f64 {
    unit(turns).y
}
