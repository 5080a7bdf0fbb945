//! The referee against closed forms, against integrators of other kinds, and against itself.
//!
//! Random numbers are by counters, so that what passes once passes always, and everywhere. Comparisons of estimates are
//! Z-tests of a family, with Sidak's correction for their number.
//!
//! Others have published pictures and plots of such walks, but no numbers that would test more than the closed forms do.

#![cfg(feature = "truth")]

mod bad_input;
mod bits;
mod chi_squared;
mod closed_forms;
mod discrete_ordinates;
mod environment;
mod furnace;
mod interfaces;
mod media;
mod reciprocity;
mod statistics;

use overcoat_core::math::double::sin_cos;

/// A direction of a cosine (negative is below) and an angle about the normal.
pub fn direction(cosine: f64, phi: f64) -> [f64; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    let (s, c) = sin_cos(phi);
    [sine * c, sine * s, cosine]
}

/// Fresnel's reflectance, and the cosine beyond.
fn fresnel(cosine: f64, eta: f64) -> (f64, f64) {
    let square = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if square <= 0.0 {
        return (1.0, 0.0);
    }
    let beyond = square.sqrt();
    let s = (cosine - eta * beyond) / (cosine + eta * beyond);
    let p = (eta * cosine - beyond) / (eta * cosine + beyond);
    (0.5 * (s * s + p * p), beyond)
}
