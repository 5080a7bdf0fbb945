//! Radiance of measured BRDFs under the lab's lights: values, and integrals over half vectors.

use super::{MeasuredBrdf, dot, turned};
use crate::lab::{LabError, Light, OVERHEAD, direction};
use overcoat_core::math::double::sin_cos;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Elevations and azimuths of the half vectors of an integral. Elevations grow by squares, as tables of both formats do, so that
/// sharp highlights are found; the directional albedo of an even BRDF is right to 1e-3, and a GGX of alpha 0.01 to 1e-3.
const HALF: [u32; 2] = [192, 96];

/// Azimuths of the surface that an anisotropic material is the mean of.
const TURNS: u32 = 8;

/// Share of the light of an integral below whose measured part nothing is said of it.
const LEAST_KNOWN: f64 = 0.5;

impl MeasuredBrdf {
    /// Radiance as [`super::super::Bench::radiance`] has it, `view` degrees off the normal, linear; of an anisotropic material the mean
    /// over its turns about the normal. `None` where nothing was measured. Under light from many directions those that were not
    /// measured are taken to be as the mean of the others.
    ///
    /// # Errors
    /// [`LabError`] if an angle is out of its range.
    pub fn radiance(&self, view: f64, light: Light) -> Result<Option<[f64; 3]>, LabError> {
        let eye = direction("view", view)?;
        let lit = match light {
            Light::Direct(degrees) => Some(direction("light", -degrees)?),
            Light::White | Light::Overhead => None,
        };
        let edge = (light == Light::Overhead).then(|| {
            let (sin, cos) = sin_cos(OVERHEAD.to_radians());
            (cos, sin)
        });
        Ok(match lit {
            Some(lit) => self.mean(eye, lit).map(|f| f.map(|c| c * lit[2])),
            None => self.over_turns(|angle| self.integral(turned(eye, angle), edge)),
        })
    }

    /// The BRDF, of an anisotropic material the mean over its turns.
    pub(super) fn mean(&self, view: [f64; 3], light: [f64; 3]) -> Option<[f64; 3]> {
        self.over_turns(|angle| self.evaluate(turned(view, angle), turned(light, angle)))
    }

    /// Mean over turns of the surface about its normal by an angle, where there is a value.
    fn over_turns(&self, of: impl Fn(f64) -> Option<[f64; 3]>) -> Option<[f64; 3]> {
        let turns = if self.is_anisotropic() { TURNS } else { 1 };
        let (mut sum, mut known) = ([0.0; 3], 0.0);
        for turn in 0..turns {
            if let Some(color) = of(TAU * f64::from(turn) / f64::from(turns)) {
                sum = std::array::from_fn(|c| sum[c] + color[c]);
                known += 1.0;
            }
        }
        (known > 0.0).then(|| sum.map(|c| c / known))
    }

    /// Light of radiance 1, reflected: from everywhere, or from all directions up to an edge, whose cosine and sine are given.
    fn integral(&self, view: [f64; 3], edge: Option<(f64, f64)>) -> Option<[f64; 3]> {
        let [elevations, azimuths] = HALF.map(f64::from);
        let (mut sum, mut known, mut all) = ([0.0; 3], 0.0, 0.0);
        for i in 0..HALF[0] {
            let u = (f64::from(i) + 0.5) / elevations;
            let (sin, cos) = sin_cos(FRAC_PI_2 * u * u);
            // Solid angle of half vectors: sin t dt dp, dt = pi u du.
            let solid = sin * PI * u / elevations * TAU / azimuths;
            for k in 0..HALF[1] {
                let (y, x) = sin_cos(TAU * (f64::from(k) + 0.5) / azimuths);
                let half = [sin * x, sin * y, cos];
                let along = dot(view, half);
                let light: [f64; 3] = std::array::from_fn(|c| 2.0 * along * half[c] - view[c]);
                if along <= 0.0 || light[2] <= 0.0 {
                    continue;
                }
                // Share of the cell within the edge of the light, which turns twice as far as its half vector.
                let share = match edge {
                    Some((least, slope)) => {
                        (0.5 + (light[2] - least) / (slope * 2.0 * PI * u / elevations)).clamp(0.0, 1.0)
                    }
                    None => 1.0,
                };
                if share == 0.0 {
                    continue;
                }
                // Solid angles: d light = 4 (view . half) d half.
                let weight = 4.0 * along * solid * light[2] * share;
                all += weight;
                if let Some(f) = self.evaluate(view, light) {
                    sum = std::array::from_fn(|c| sum[c] + weight * f[c]);
                    known += weight;
                }
            }
        }
        (known >= LEAST_KNOWN * all && known > 0.0).then(|| sum.map(|c| c * (all / known)))
    }
}
