//! Homogeneous media between interfaces.

use super::vector::{Channels, Vector, around, dot};
use overcoat_core::math::double::exp;
use std::f64::consts::PI;

/// Homogeneous medium between two interfaces, which absorbs and scatters.
///
/// Only the products of extinction and thickness count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Extinction (absorption plus scattering) per unit of length, three channels, at least 0. Times the thickness at most
    /// 10^10.
    pub extinction: [f64; 3],
    /// Single scattering albedo: the share of extinction that is scattering, three channels, 0 to 1.
    pub albedo: [f64; 3],
    /// Mean cosine g of the phase function of Henyey and Greenstein, -0.999 to 0.999; 0 is isotropic.
    pub anisotropy: f64,
    /// Thickness in units of length, at least 0.
    pub thickness: f64,
}

impl Medium {
    /// Nothing.
    pub const CLEAR: Self = Self { extinction: [0.0; 3], albedo: [0.0; 3], anisotropy: 0.0, thickness: 1.0 };

    /// Absorption alone, of an optical thickness in three channels: its transmittance at normal incidence is
    /// `exp(-thickness)`.
    #[must_use]
    pub const fn absorbing(optical_thickness: [f64; 3]) -> Self {
        Self { extinction: optical_thickness, ..Self::CLEAR }
    }
}

/// A medium as walks need it; depth goes from 0 at its upper side to 1 at its lower.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    pub optical: Channels,
    pub albedo: Channels,
    pub g: f64,
    pub clear: bool,
    /// True if there are events in it.
    pub scatters: bool,
}

impl Slab {
    pub fn new(medium: &Medium) -> Self {
        let optical = medium.extinction.map(|extinction| extinction * medium.thickness);
        let clear = optical.iter().all(|&depth| depth == 0.0);
        let scatters = !clear && medium.albedo.iter().any(|&albedo| albedo > 0.0);
        Self { optical, albedo: medium.albedo, g: medium.anisotropy, clear, scatters }
    }

    /// Transmittance of `distance` (in depth) along a direction of cosine `mu`, unscattered light only.
    pub fn transmittance(&self, distance: f64, mu: f64) -> Channels {
        let [a, b, c] = self.optical;
        if self.clear {
            [1.0; 3]
        } else if a == b && b == c {
            // The same bits for a third of the work.
            [exp(-a * distance / mu); 3]
        } else {
            self.optical.map(|optical| exp(-optical * distance / mu))
        }
    }

    /// Henyey and Greenstein's phase function, for two directions of propagation.
    pub fn phase(&self, from: Vector, to: Vector) -> f64 {
        let g = self.g;
        let x = 1.0 + g * g - 2.0 * g * dot(from, to);
        (1.0 - g * g) / (4.0 * PI * x * x.sqrt())
    }

    /// A direction of propagation after scattering.
    pub fn scattered(&self, from: Vector, u: f64, v: f64) -> Vector {
        let (g, s) = (self.g, 2.0 * u - 1.0);
        // The inverse of the distribution, arranged so that nothing is divided by g.
        let x = 1.0 + g * s;
        let y = s + 0.5 * g * (s * s + 3.0) + g * g * s + 0.5 * g * g * g * (s * s - 1.0);
        let cosine = y / (x * x);
        around(from, cosine.clamp(-1.0, 1.0), v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_function_is_one_and_is_what_is_sampled() {
        for g in [0.0, 1e-9, 0.5, -0.8, 0.95] {
            let slab = Slab::new(&Medium { anisotropy: g, ..Medium::CLEAR });
            let axis = [0.6, 0.0, -0.8];
            let steps = 400_000;
            let (mut whole, mut mean, mut sampled) = (0.0, 0.0, 0.0);
            for k in 0..steps {
                let u = (f64::from(k) + 0.5) / f64::from(steps);
                let cosine = 2.0 * u - 1.0;
                let p = 4.0 * PI * slab.phase(axis, around(axis, cosine, 0.3)) / f64::from(steps);
                whole += p;
                mean += p * cosine;
                sampled += dot(axis, slab.scattered(axis, u, 0.7)) / f64::from(steps);
            }
            assert!(
                (whole - 1.0).abs() < 1e-4 && (mean - g).abs() < 1e-4 && (sampled - g).abs() < 1e-4,
                "{g}"
            );
        }
    }
}
