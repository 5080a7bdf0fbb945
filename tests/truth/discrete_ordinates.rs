//! An integrator of another kind: discrete ordinates, for a smooth dielectric over a medium that scatters isotropically over
//! a diffuse base (Chandrasekhar 1960; Stamnes et al. 1988). Nothing is random in it, and nothing of it is in the library.

use super::statistics::{Family, gauss_legendre};
use super::{direction, fresnel};
use overcoat_core::math::double::exp;
use overcoat_lab::truth::{Interface, Medium, Samples, Stack};
use std::f64::consts::{FRAC_1_PI, PI};

struct Layers {
    eta: f64,
    depth: f64,
    scattering: f64,
    base: f64,
}

impl Layers {
    /// The share of energy from `co` that leaves per solid angle at `ci`, by radiance in cells of depth and at cosines of
    /// Gauss's.
    fn value(&self, co: f64, ci: f64, cells: usize) -> f64 {
        let inverse = 1.0 / self.eta;
        let critical = (1.0 - inverse * inverse).sqrt();
        let mut nodes = Vec::new();
        // Squares on both sides of the critical angle, where reflectance has a root, and toward the horizon, where light fades.
        for (t, w) in gauss_legendre(24, 0.0, 1.0) {
            nodes.push((critical * t * t, 2.0 * critical * t * w));
            nodes.push((critical + (1.0 - critical) * t * t, 2.0 * (1.0 - critical) * t * w));
        }
        // For each cosine: what passes a cell, and of a source that is linear across a cell what reaches its end, by the
        // values at its beginning and its end.
        let step = self.depth / cells as f64;
        let across = |mu: f64| {
            let x = step / mu;
            let pass = exp(-x);
            let filled = 1.0 - pass;
            // int_0^1 of t and of 1 - t, each times x exp(-x (1 - t)).
            let end = if x < 1e-3 { 0.5 * x - x * x / 6.0 } else { 1.0 - filled / x };
            (pass, filled - end, end)
        };
        // Radiance of light from `co`, one unit of energy on a unit of area: refracted, once through, diffuse from the base,
        // and what is scattered out of it on the way.
        let (f, mu0) = fresnel(co, self.eta);
        let beam = |z: f64| (1.0 - f) * exp(-z / mu0);
        let direct = self.scattering / (4.0 * PI);
        let from_beam: Vec<f64> = (0..=cells).map(|k| direct * beam(k as f64 * step) / mu0).collect();
        let base_beam = self.base * FRAC_1_PI * beam(self.depth);
        let mut source = from_beam.clone();
        let exit = |source: &[f64], mu: f64, up_from_base: f64| {
            let (pass, begin, end) = across(mu);
            let mut radiance = up_from_base;
            for k in (0..cells).rev() {
                radiance = radiance * pass + source[k + 1] * begin + source[k] * end;
            }
            radiance
        };
        let mut base = base_beam;
        let nodes: Vec<_> =
            nodes.into_iter().map(|(mu, weight)| (mu, weight, across(mu), fresnel(mu, inverse).0)).collect();
        for _ in 0..2000 {
            let mut flux_down = 0.0;
            let mut sum = vec![0.0; cells + 1];
            for &(mu, weight, (pass, begin, end), reflectance) in &nodes {
                let mut radiance = base;
                sum[cells] += weight * radiance;
                for k in (0..cells).rev() {
                    radiance = radiance * pass + source[k + 1] * begin + source[k] * end;
                    sum[k] += weight * radiance;
                }
                radiance *= reflectance;
                sum[0] += weight * radiance;
                for k in 1..=cells {
                    radiance = radiance * pass + source[k - 1] * begin + source[k] * end;
                    sum[k] += weight * radiance;
                }
                flux_down += weight * mu * radiance;
            }
            let next_base = base_beam + self.base * 2.0 * flux_down;
            let mut change = (next_base - base).abs();
            base = next_base;
            for k in 0..=cells {
                let next = from_beam[k] + self.scattering * 0.5 * sum[k];
                change += (next - source[k]).abs();
                source[k] = next;
            }
            if change < 1e-13 {
                break;
            }
        }
        let (f, mu) = fresnel(ci, self.eta);
        // Radiance over the square of the index is what refraction keeps.
        exit(&source, mu, base) * (1.0 - f) / (self.eta * self.eta) * ci
    }
}

#[test]
fn slabs_of_three_kinds() {
    let mut family = Family::default();
    let kinds = [
        (1.5, [0.2, 1.0, 4.0], [0.9, 0.5, 1.0], [0.8, 0.2, 0.5]),
        (1.33, [1.0, 1.0, 1.0], [1.0, 0.8, 0.2], [0.0, 0.5, 1.0]),
        (1.8, [0.05, 0.5, 2.0], [0.99, 0.99, 0.99], [0.9, 0.9, 0.9]),
    ];
    for (eta, depth, scattering, base) in kinds {
        let stack = Stack::builder()
            .interface(Interface::dielectric(eta))
            .medium(Medium { extinction: depth, albedo: scattering, anisotropy: 0.0, thickness: 1.0 })
            .interface(Interface::lambertian(base))
            .build()
            .unwrap();
        for (co, ci) in [(0.9, 0.8), (0.2, 0.7), (0.6, 0.1)] {
            let found =
                stack.evaluate(direction(co, 0.0), direction(ci, 2.0), &Samples::new(1 << 14)).unwrap().total;
            for c in 0..3 {
                let layers = Layers { eta, depth: depth[c], scattering: scattering[c], base: base[c] };
                let (coarse, fine) = (layers.value(co, ci, 40), layers.value(co, ci, 80));
                // The error falls with the square of the cells.
                let expected = fine + (fine - coarse) / 3.0;
                let uncertain = (fine - coarse).abs() / 10.0;
                assert!(uncertain < 2e-4 * expected);
                family.compare(
                    format!("eta {eta}, depth {}, {co} to {ci}", depth[c]),
                    (found.mean()[c], found.standard_error()[c]),
                    (expected, uncertain),
                );
                assert!(
                    found.standard_error()[c] < 0.04 * expected,
                    "{} of {expected}",
                    found.standard_error()[c]
                );
            }
        }
    }
    family.judge();
}
