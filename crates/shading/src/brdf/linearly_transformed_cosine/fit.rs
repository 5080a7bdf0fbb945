//! Fits linearly transformed cosines to GGX, for the table that the renderer reads.
//!
//! Own work after the description in the paper (section 3.4), with these differences:
//! * The lobe of the fit is cut off at the horizon of the surface and normalised to what is left, as
//!   [`super::Lobe`] evaluates it. Light from everywhere then returns exactly the albedo, and none shines through from
//!   below.
//! * The error is measured with fixed samples, half of them visible normals of the roughness, half of three times the
//!   roughness for the tails, so that no random number enters.
//!
//! Everything is double precision with [`overcoat_core::math::double`]: the same numbers on every machine.

use crate::brdf::integrate::hammersley;
use overcoat_core::math::double::{exp, ln, sin_cos};
use std::f64::consts::PI;

/// A direction of light with the share of the lobe there.
struct Sample {
    direction: [f64; 3],
    /// BRDF times cosine over albedo, 1/sr.
    value: f64,
    /// Density with which this direction was drawn, 1/sr.
    density: f64,
}

/// The inverse matrix ((a, 0, b), (0, 1, 0), (c, 0, d)).
type Inverse = [f64; 4];

/// Smallest alpha that is fitted; smoother surfaces use its lobe.
const LEAST_ALPHA: f64 = 4e-4;

/// Smallest cosine of the view that is fitted.
const LEAST_COSINE: f64 = 2e-3;

/// Half-vector distribution and Smith's shadowing function of one direction.
fn distribution(n_dot_h: f64, alpha: f64) -> f64 {
    let d = n_dot_h * n_dot_h * (alpha * alpha - 1.0) + 1.0;
    alpha * alpha / (PI * d * d)
}

/// Denominator of Smith's G1 at a cosine: G1 = 2 cosine / this.
fn masking(cosine: f64, alpha: f64) -> f64 {
    cosine + (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt()
}

/// Density of reflected directions with half vectors drawn from the visible normals of `alpha`.
fn reflected_density(n_dot_v: f64, n_dot_h: f64, alpha: f64) -> f64 {
    0.5 * distribution(n_dot_h, alpha) / masking(n_dot_v, alpha)
}

/// A visible normal for a point of the unit square (Heitz, JCGT 2018). The view lies in the plane of x and z.
fn visible_normal(view: [f64; 3], alpha: f64, [turns, u]: [f64; 2]) -> [f64; 3] {
    let length = (alpha * alpha * view[0] * view[0] + view[2] * view[2]).sqrt();
    let (x, z) = (alpha * view[0] / length, view[2] / length);
    let (s, c) = sin_cos(2.0 * PI * turns);
    let across = u.sqrt() * c;
    let squeeze = 0.5 * (1.0 + z);
    let along = (1.0 - squeeze) * (1.0 - across * across).max(0.0).sqrt() + squeeze * u.sqrt() * s;
    let towards = (1.0 - across * across - along * along).max(0.0).sqrt();
    let normal = [alpha * (towards * x - along * z), alpha * across, (along * x + towards * z).max(1e-12)];
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    normal.map(|v| v / length)
}

/// Directions of light above the surface, and the lobe there.
fn samples(n_dot_v: f64, alpha: f64) -> Vec<Sample> {
    const COUNT: u32 = 512;
    let view = [(1.0 - n_dot_v * n_dot_v).max(0.0).sqrt(), 0.0, n_dot_v];
    let wide = (3.0 * alpha).min(1.0);
    let mut samples = Vec::new();
    for k in 0..2 * COUNT {
        let drawn = if k < COUNT { alpha } else { wide };
        let half = visible_normal(view, drawn, hammersley(k % COUNT, COUNT));
        let v_dot_h = view[0] * half[0] + view[2] * half[2];
        let light = [0, 1, 2].map(|i| 2.0 * v_dot_h * half[i] - view[i]);
        if light[2] > 0.0 {
            let a2 = alpha * alpha;
            let lambda = light[2] * (n_dot_v * n_dot_v * (1.0 - a2) + a2).sqrt()
                + n_dot_v * (light[2] * light[2] * (1.0 - a2) + a2).sqrt();
            samples.push(Sample {
                direction: light,
                value: distribution(half[2], alpha) * 0.5 / lambda * light[2],
                density: 0.5
                    * (reflected_density(n_dot_v, half[2], alpha)
                        + reflected_density(n_dot_v, half[2], wide)),
            });
        }
    }
    let albedo: f64 = samples.iter().map(|s| s.value / s.density).sum::<f64>() / f64::from(2 * COUNT);
    samples.iter_mut().for_each(|s| s.value /= albedo);
    samples
}

/// The lobe of an inverse matrix, cut off at the horizon and normalised.
fn density(m: Inverse, [x, y, z]: [f64; 3]) -> f64 {
    let [a, b, c, d] = m;
    let (x, z) = (a * x + b * z, c * x + d * z);
    let squared = x * x + y * y + z * z;
    let mass = 0.5 * (1.0 + a / (a * a + c * c).sqrt());
    (z.max(0.0) / (PI * squared * squared)) * (a * d - b * c).abs() / mass
}

/// Inverse matrix of a lobe about the direction `angle` (from the normal, away from the view), with the logarithms of its
/// extents, and its skew.
fn inverse([along, across, skew, angle]: [f64; 4]) -> Inverse {
    let (s, c) = sin_cos(angle);
    let (axis_x, axis_z) = (-s, c);
    let (side_x, side_z) = (c, s);
    let across = exp(across);
    let scale = across * exp(-along);
    [(side_x - skew * axis_x) * scale, (side_z - skew * axis_z) * scale, axis_x * across, axis_z * across]
}

/// Error of the fit: the squared difference between lobe and samples, integrated over the sphere by their density.
fn error(samples: &[Sample], m: Inverse) -> f64 {
    let one = |s: &Sample| {
        let difference = s.value - density(m, s.direction);
        difference * difference / s.density
    };
    samples.iter().map(one).sum::<f64>()
}

/// Nelder and Mead's simplex method: the point with the least value that it finds.
fn minimize<const N: usize>(start: [f64; N], step: [f64; N], f: impl Fn([f64; N]) -> f64) -> [f64; N] {
    let mut simplex: Vec<([f64; N], f64)> = (0..=N)
        .map(|k| {
            let mut point = start;
            if k > 0 {
                point[k - 1] += step[k - 1];
            }
            (point, f(point))
        })
        .collect();
    for _ in 0..60 * N {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        if simplex[N].1 - simplex[0].1 <= 1e-6 * simplex[0].1 {
            break;
        }
        let centre: [f64; N] =
            std::array::from_fn(|i| simplex[..N].iter().map(|(p, _)| p[i]).sum::<f64>() / N as f64);
        let worst = simplex[N];
        let along = |t: f64| {
            let point: [f64; N] = std::array::from_fn(|i| centre[i] + t * (worst.0[i] - centre[i]));
            (point, f(point))
        };
        let reflected = along(-1.0);
        if reflected.1 < simplex[0].1 {
            let expanded = along(-2.0);
            simplex[N] = if expanded.1 < reflected.1 { expanded } else { reflected };
        } else if reflected.1 < simplex[N - 1].1 {
            simplex[N] = reflected;
        } else {
            let contracted = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if contracted.1 < worst.1.min(reflected.1) {
                simplex[N] = contracted;
            } else {
                let best = simplex[0].0;
                for vertex in &mut simplex[1..] {
                    vertex.0 = std::array::from_fn(|i| 0.5 * (best[i] + vertex.0[i]));
                    vertex.1 = f(vertex.0);
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}

/// The inverse matrices for one view and a row of rising perceptual roughnesses.
#[must_use]
pub fn ggx(n_dot_v: f64, roughnesses: &[f64]) -> Vec<Inverse> {
    let n_dot_v = n_dot_v.max(LEAST_COSINE);
    let head_on = n_dot_v >= 1.0;
    let mut row = vec![[0.0; 4]; roughnesses.len()];
    let mut last: Option<([f64; 4], f64)> = None;
    // From rough to smooth: each fit starts from the one before, narrowed.
    for (k, p) in roughnesses.iter().enumerate().rev() {
        let alpha = (p * p).max(LEAST_ALPHA);
        let samples = samples(n_dot_v, alpha);
        let mean = samples.iter().fold([0.0; 2], |sum, s| {
            let weight = s.value / s.density;
            [sum[0] - weight * s.direction[0], sum[1] + weight * s.direction[2]]
        });
        let mean_angle = overcoat_core::math::double::atan2(mean[0], mean[1]);
        let (start, step) = match last {
            Some((fit, last_alpha)) => {
                let narrower = ln(alpha / last_alpha);
                ([fit[0] + narrower, fit[1] + narrower, fit[2], fit[3]], [0.1, 0.1, 0.05, 0.1])
            }
            None => ([0.0; 4], [0.2, 0.2, 0.1, 0.2]),
        };
        // The fourth number is the angle beyond the mean direction, in extents of the lobe.
        let place = |q: [f64; 4]| [q[0], q[1], q[2], mean_angle + q[3] * exp(q[0])];
        let fit = if head_on {
            let round = |q: [f64; 1]| [q[0], q[0], 0.0, 0.0];
            round(minimize([start[0]], [step[0]], |q| error(&samples, inverse(round(q)))))
        } else {
            let distance = |q| error(&samples, inverse(place(q)));
            let mut best = minimize(start, step, distance);
            let nothing: f64 = samples.iter().map(|s| s.value * s.value / s.density).sum();
            if distance(best) > 0.1 * nothing {
                // Still far: perhaps led astray by the fit before.
                let width = ln(alpha);
                let other = minimize([width, width, 0.0, 0.0], step, distance);
                if distance(other) < distance(best) {
                    best = other;
                }
            }
            best
        };
        row[k] = inverse(if head_on { fit } else { place(fit) });
        last = Some((fit, alpha));
    }
    row
}
