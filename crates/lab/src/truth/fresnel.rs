//! Reflectance of smooth interfaces: Fresnel's equations, and Schlick's approximation, which engines use.

use super::vector::{Channels, positive};

/// Fresnel term of an interface between two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DielectricFresnel {
    /// Fresnel's equations.
    Exact,
    /// Schlick 1994, of a reflectance at normal incidence, by the cosine on the side where it is smaller; so it is the same
    /// from both sides, and 1 beyond the critical angle.
    Schlick(Channels),
}

impl DielectricFresnel {
    /// Reflectance, and cosine on the other side (0 beyond the critical angle), by the cosine on this side, at least 0, and the
    /// index of the other side relative to this one.
    pub fn reflectance(self, cosine: f64, eta: f64) -> (Channels, f64) {
        let square = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
        if square <= 0.0 {
            return ([1.0; 3], 0.0);
        }
        let beyond = square.sqrt();
        let channels = match self {
            Self::Exact => [exact(cosine, beyond, eta); 3],
            Self::Schlick(f0) => schlick(f0, if beyond < cosine { beyond } else { cosine }),
        };
        (channels, beyond)
    }
}

fn exact(cosine: f64, beyond: f64, eta: f64) -> f64 {
    // At a cosine of 0 with an index of 1 both are 0, and nothing is reflected.
    if eta == 1.0 {
        return 0.0;
    }
    let s = (cosine - eta * beyond) / (cosine + eta * beyond);
    let p = (eta * cosine - beyond) / (eta * cosine + beyond);
    0.5 * (s * s + p * p)
}

/// Reflectance of a smooth interface to a relative index for light from everywhere: 2 F u du over cosines u from 0 to 1.
pub(crate) fn mean_reflectance(eta: f64) -> f64 {
    const STEPS: u32 = 4096;
    let at = |k: u32| {
        let cosine = (f64::from(k) + 0.5) / f64::from(STEPS);
        let ([f, ..], _) = DielectricFresnel::Exact.reflectance(cosine, eta);
        2.0 * f * cosine
    };
    (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
}

/// f0 + (1 - f0) (1 - cosine)^5
pub(super) fn schlick(f0: Channels, cosine: f64) -> Channels {
    let x = positive(1.0 - cosine);
    let power = x * x * x * x * x;
    f0.map(|f0| f0 + (1.0 - f0) * power)
}

/// A conductor of index n + ik relative to the medium before it: Fresnel's equations with a complex index, for unpolarised
/// light (Born and Wolf, "Principles of Optics", 7th edition, section 14.2).
pub(super) fn conductor(cosine: f64, n: f64, k: f64) -> f64 {
    let (c2, n2, k2) = (cosine * cosine, n * n, k * k);
    let s2 = positive(1.0 - c2);
    let difference = n2 - k2 - s2;
    let sum = (difference * difference + 4.0 * n2 * k2).sqrt();
    let a = positive(0.5 * (sum + difference)).sqrt();
    let (t1, t2) = (sum + c2, 2.0 * cosine * a);
    let s = (t1 - t2) / (t1 + t2);
    let (t3, t4) = (c2 * sum + s2 * s2, t2 * s2);
    let denominator = t3 + t4;
    let p = if denominator > 0.0 { s * (t3 - t4) / denominator } else { s };
    0.5 * (s + p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_is_the_same_from_both_sides() {
        for fresnel in [DielectricFresnel::Exact, DielectricFresnel::Schlick([0.04, 0.2, 0.9])] {
            for eta in [1.5, 0.7, 3.0, 1.0] {
                for k in 0..=20 {
                    let cosine = f64::from(k) / 20.0;
                    let (there, beyond) = fresnel.reflectance(cosine, eta);
                    assert!(there.iter().all(|f| (0.0..=1.0).contains(f)), "{there:?}");
                    if beyond > 0.0 {
                        let (back, before) = fresnel.reflectance(beyond, 1.0 / eta);
                        assert!((before - cosine).abs() < 1e-7 && (back[1] - there[1]).abs() < 1e-7);
                    } else {
                        assert_eq!(there, [1.0; 3]);
                    }
                }
            }
        }
    }

    #[test]
    fn known_values() {
        let (f, _) = DielectricFresnel::Exact.reflectance(1.0, 1.5);
        assert!((f[0] - 0.04).abs() < 1e-15);
        // Walsh's closed form (1926; in Duntley 1942, "The optical properties of diffusing materials").
        assert!((mean_reflectance(1.5) - 0.091_777_96).abs() < 1e-7 && mean_reflectance(1.0) == 0.0);
        // At Brewster's angle only s is reflected: ((n^2 - 1) / (n^2 + 1))^2 of one half.
        let (f, _) = DielectricFresnel::Exact.reflectance(1.0 / (1.0_f64 + 2.25).sqrt(), 1.5);
        assert!((f[0] - 0.5 * (1.25_f64 / 3.25) * (1.25 / 3.25)).abs() < 1e-14);
        // Gold at 650 nm: n = 0.16, k = 3.5.
        let expected = ((0.16 - 1.0) * (0.16 - 1.0) + 3.5 * 3.5) / ((0.16 + 1.0) * (0.16 + 1.0) + 3.5 * 3.5);
        assert!((conductor(1.0, 0.16, 3.5) - expected).abs() < 1e-14);
        assert!((conductor(0.0, 0.16, 3.5) - 1.0).abs() < 1e-14);
        // Without k it is a dielectric.
        for k in 0..=10 {
            let cosine = f64::from(k) / 10.0;
            let (f, _) = DielectricFresnel::Exact.reflectance(cosine, 1.7);
            assert!((conductor(cosine, 1.7, 0.0) - f[0]).abs() < 1e-13, "{cosine}");
        }
    }
}
