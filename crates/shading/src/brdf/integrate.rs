//! Directional albedo of specular and sheen lobes, integrated from their definition in double precision.
//!
//! Each function computes what the named engine stores in its pre-integrated table: the same estimator with the same
//! samples, because some of what the engines shade with is the error of theirs. Everything is `+ - * / sqrt` and
//! [`overcoat_core::math::double`], so the numbers are the same on every machine. `examples/make-assets` writes them to files;
//! [`super::tables`] reads these.
//!
//! The view direction lies in the plane of x and z, z is the normal. Only x and z of a half vector matter then, and
//! half vectors do not depend on the view: they are made once for a row of a table.

use overcoat_core::math::double::{exp, ln, pow, sin_cos};
use std::f64::consts::PI;

/// x and z of a unit half vector.
type HalfVector = [f64; 2];

/// Point k of n of Hammersley's sequence: (k / n, bits of k mirrored at the binary point).
#[must_use]
pub fn hammersley(k: u32, n: u32) -> [f64; 2] {
    [f64::from(k) / f64::from(n), f64::from(k.reverse_bits()) / 4_294_967_296.0]
}

/// Half vectors of cosines and azimuths in turns.
fn half_vectors(n: u32, direction: impl Fn(u32) -> (f64, f64)) -> Vec<HalfVector> {
    let of = |k| {
        let (cosine, turns) = direction(k);
        let (_, c) = sin_cos(2.0 * PI * turns);
        [(1.0 - cosine * cosine).max(0.0).sqrt() * c, cosine]
    };
    (0..n).map(of).collect()
}

/// The cosine that GGX of the given roughness (alpha) has for the cumulative probability u below 1.
fn ggx_cosine(u: f64, alpha: f64) -> f64 {
    let (above, below) = (1.0 - u, 1.0 + (alpha * alpha - 1.0) * u);
    // Equal for a mirror, also where both vanish.
    if above == below { 1.0 } else { (above / below).sqrt() }
}

/// Sampled half vectors of GGX: azimuth from the first number of the sequence, elevation from the second.
#[must_use]
fn ggx_half_vectors(n: u32, alpha: f64) -> Vec<HalfVector> {
    half_vectors(n, |k| {
        let [turns, u] = hammersley(k, n);
        (ggx_cosine(u, alpha), turns)
    })
}

/// A view direction by its cosine with the normal.
#[derive(Clone, Copy)]
struct View {
    x: f64,
    z: f64,
}

impl View {
    fn new(cosine: f64) -> Self {
        Self { x: (1.0 - cosine * cosine).max(0.0).sqrt(), z: cosine }
    }

    /// V.H, saturated, and N.L of the direction mirrored at the half vector.
    fn mirrored(self, half: HalfVector) -> (f64, f64) {
        let v_dot_h = (self.x * half[0] + self.z * half[1]).clamp(0.0, 1.0);
        (v_dot_h, 2.0 * v_dot_h * half[1] - self.z)
    }
}

/// Height-correlated Smith visibility of GGX.
fn smith(n_dot_l: f64, n_dot_v: f64, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let lambda_v = n_dot_l * ((-n_dot_v * a2 + n_dot_v) * n_dot_v + a2).sqrt();
    let lambda_l = n_dot_v * ((-n_dot_l * a2 + n_dot_l) * n_dot_l + a2).sqrt();
    0.5 / (lambda_v + lambda_l).max(f64::from(f32::MIN_POSITIVE))
}

fn pow5(x: f64) -> f64 {
    let x2 = x * x;
    x2 * x2 * x
}

/// Unity's `IntegrateGGXAndDisneyDiffuseFGD` (core/ImageBasedLighting) for a row of cosines N.V at one perceptual
/// roughness, 4096 samples: the albedo of GGX weighted with (1 - V.H)^5, without weight, and the albedo of Disney's
/// diffuse less 0.5.
#[must_use]
pub fn unity_fgd(perceptual_roughness: f64, cosines: &[f64]) -> Vec<[f64; 3]> {
    const SAMPLES: u32 = 4096;
    let alpha = perceptual_roughness * perceptual_roughness;
    // Elevation from the first number of the sequence, azimuth from the second: the other way round than elsewhere.
    let halves = half_vectors(SAMPLES, |k| {
        let [u, turns] = hammersley(k, SAMPLES);
        (ggx_cosine(u, alpha), turns)
    });
    // Cosine-weighted directions: the normal plus a point of the unit sphere, normalized.
    let sphere = half_vectors(SAMPLES, |k| {
        let [u, turns] = hammersley(k, SAMPLES);
        (1.0 - 2.0 * u, turns)
    });
    let lights: Vec<[f64; 2]> = sphere
        .iter()
        .map(|[x, z]| {
            // |N + S|^2 = 2 + 2 z.
            let scale = 1.0 / (2.0 + 2.0 * z).max(f64::from(f32::MIN_POSITIVE)).sqrt();
            [x * scale, ((1.0 + z) * scale).clamp(0.0, 1.0)]
        })
        .collect();
    let one = |&cosine: &f64| {
        let view = View::new(cosine.max(UNITY_REAL_EPS));
        let mut sum = [0.0; 3];
        for &half in &halves {
            let (v_dot_h, n_dot_l) = view.mirrored(half);
            if n_dot_l > 0.0 {
                let weight = 4.0 * smith(n_dot_l, view.z, alpha) * n_dot_l * v_dot_h / half[1];
                sum[0] += weight * pow5(1.0 - v_dot_h);
                sum[1] += weight;
            }
        }
        for &[x, n_dot_l] in &lights {
            if n_dot_l > 0.0 {
                let l_dot_v = x * view.x + n_dot_l * view.z;
                sum[2] += disney_diffuse(view.z, n_dot_l, l_dot_v, perceptual_roughness);
            }
        }
        let n = f64::from(SAMPLES);
        [sum[0] / n, sum[1] / n, sum[2] / n - 0.5]
    };
    cosines.iter().map(one).collect()
}

/// `REAL_EPS`, the least cosine of Unity's integral: 2^-24.
const UNITY_REAL_EPS: f64 = 5.960_464_48e-8;

/// Unity's `DisneyDiffuse` times pi.
fn disney_diffuse(n_dot_v: f64, n_dot_l: f64, l_dot_v: f64, perceptual_roughness: f64) -> f64 {
    let fd90 = 0.5 + (perceptual_roughness + perceptual_roughness * l_dot_v);
    let scatter = |cosine: f64| 1.0 + (fd90 - 1.0) * pow5(1.0 - cosine);
    scatter(n_dot_l) * scatter(n_dot_v) / 1.035_71
}

/// Filament's table for one perceptual roughness (libs/ibl `DFV_Multiscatter` and `DFV_Charlie_Uniform`): the albedo of
/// GGX weighted with (1 - V.H)^5 and without weight (1024 samples), and the albedo of Charlie with Neubelt's visibility
/// (4096 samples, uniform over the hemisphere).
#[must_use]
pub fn filament_dfg(perceptual_roughness: f64, cosines: &[f64]) -> Vec<[f64; 3]> {
    const SAMPLES: u32 = 1024;
    const CLOTH_SAMPLES: u32 = 4096;
    let alpha = perceptual_roughness * perceptual_roughness;
    let halves = ggx_half_vectors(SAMPLES, alpha);
    let cloth: Vec<(HalfVector, f64)> = half_vectors(CLOTH_SAMPLES, |k| {
        let [turns, u] = hammersley(k, CLOTH_SAMPLES);
        (1.0 - u, turns)
    })
    .into_iter()
    .map(|half| (half, charlie(half[1], alpha)))
    .collect();
    let one = |&cosine: &f64| {
        let view = View::new(cosine);
        let mut sum = [0.0; 3];
        for &half in &halves {
            let (v_dot_h, n_dot_l) = view.mirrored(half);
            if n_dot_l > 0.0 {
                let weight = smith(n_dot_l, view.z, alpha) * n_dot_l * v_dot_h / half[1];
                sum[0] += weight * pow5(1.0 - v_dot_h);
                sum[1] += weight;
            }
        }
        for &(half, distribution) in &cloth {
            let (v_dot_h, n_dot_l) = view.mirrored(half);
            if n_dot_l > 0.0 {
                sum[2] += neubelt(n_dot_l, view.z) * distribution * n_dot_l * v_dot_h;
            }
        }
        let (ggx, cloth) = (4.0 / f64::from(SAMPLES), 8.0 * PI / f64::from(CLOTH_SAMPLES));
        [sum[0] * ggx, sum[1] * ggx, sum[2] * cloth]
    };
    cosines.iter().map(one).collect()
}

/// The perceptual roughness of row `row` of Filament's table of `rows` rows. The texture is read at the centres of
/// texels, (row + 0.5) / rows; the generator counts rows from the other end and is off by one.
#[must_use]
pub fn filament_row(row: usize, rows: usize) -> f64 {
    ((row as f64 + 1.5) / rows as f64).min(1.0)
}

/// Charlie (Estevez and Kulla 2017): (2 + 1/alpha) sin^(1/alpha) / (2 pi).
fn charlie(n_dot_h: f64, alpha: f64) -> f64 {
    let inverse = 1.0 / alpha;
    (2.0 + inverse) * pow(1.0 - n_dot_h * n_dot_h, 0.5 * inverse) / (2.0 * PI)
}

/// Visibility of cloth after Neubelt and Pettineo: 1 / (4 (l + v - l v)).
fn neubelt(n_dot_l: f64, n_dot_v: f64) -> f64 {
    1.0 / (4.0 * (n_dot_l + n_dot_v - n_dot_l * n_dot_v))
}

/// Scale and bias of the split sum after Karis: the albedo of GGX with height-correlated visibility is F0 scale + F90
/// bias.
fn scale_and_bias(view: View, halves: &[HalfVector], alpha: f64) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for &half in halves {
        let (v_dot_h, n_dot_l) = view.mirrored(half);
        if n_dot_l > 0.0 {
            let weight = smith(n_dot_l, view.z, alpha) * n_dot_l * v_dot_h / half[1];
            let fresnel = pow5(1.0 - v_dot_h);
            sum[0] += (1.0 - fresnel) * weight;
            sum[1] += fresnel * weight;
        }
    }
    let scale = 4.0 / halves.len() as f64;
    [sum[0] * scale, sum[1] * scale]
}

/// Scale and bias as three.js stores them (utils/generateDFGLUT.js): GGX with height-correlated visibility and 4096
/// samples. The tangent frame of its generator lies across the view, so that its azimuths start a quarter turn earlier;
/// at grazing angles that shows (up to 3 percent).
#[must_use]
pub fn three_dfg(perceptual_roughness: f64, cosines: &[f64]) -> Vec<[f64; 2]> {
    const SAMPLES: u32 = 4096;
    let alpha = perceptual_roughness * perceptual_roughness;
    let halves = half_vectors(SAMPLES, |k| {
        let [turns, u] = hammersley(k, SAMPLES);
        (ggx_cosine(u, alpha), turns - 0.25)
    });
    cosines.iter().map(|&cosine| scale_and_bias(View::new(cosine), &halves, alpha)).collect()
}

/// Albedos of GGX with height-correlated visibility for one perceptual roughness: weighted with (1 - V.H)^5, without
/// weight, and weighted with V.H (1 - V.H)^6, the shape of the F82 tint of metals.
///
/// No engine's: 4096 visible normals (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018), whose
/// weights are at most 1, so that there is no noise at grazing angles.
#[must_use]
pub fn ggx_albedo(perceptual_roughness: f64, cosines: &[f64]) -> Vec<[f64; 3]> {
    const SAMPLES: u32 = 4096;
    let a = perceptual_roughness * perceptual_roughness;
    let disc: Vec<[f64; 2]> = (0..SAMPLES)
        .map(|k| {
            let [turns, u] = hammersley(k, SAMPLES);
            let (s, c) = sin_cos(2.0 * PI * turns);
            [u.sqrt() * c, u.sqrt() * s]
        })
        .collect();
    let one = |&cosine: &f64| {
        let view = View::new(cosine.max(1e-6));
        // The view of the surface that is stretched until its facets form a hemisphere.
        let length = (a * a * view.x * view.x + view.z * view.z).sqrt();
        let (x, z) = (a * view.x / length, view.z / length);
        let unmasked = 2.0 * view.z / (view.z + (a * a + (1.0 - a * a) * view.z * view.z).sqrt());
        let mut sum = [0.0; 3];
        for &[across, along] in &disc {
            let squeeze = 0.5 * (1.0 + z);
            let along = (1.0 - squeeze) * (1.0 - across * across).max(0.0).sqrt() + squeeze * along;
            let towards = (1.0 - across * across - along * along).max(0.0).sqrt();
            let normal = [a * (towards * x - along * z), a * across, (along * x + towards * z).max(0.0)];
            let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
            let (v_dot_h, n_dot_l) = view.mirrored([normal[0] / length, normal[2] / length]);
            if n_dot_l > 0.0 {
                let weight = 4.0 * smith(n_dot_l, view.z, a) * n_dot_l * view.z / unmasked;
                let x = 1.0 - v_dot_h;
                sum[0] += weight * pow5(x);
                sum[1] += weight;
                sum[2] += weight * v_dot_h * pow5(x) * x;
            }
        }
        sum.map(|sum| sum / f64::from(SAMPLES))
    };
    cosines.iter().map(one).collect()
}

/// The Khronos renderer's tables for one perceptual roughness (glTF-Sample-Renderer, ibl_filtering.frag `LUT`): scale
/// and bias of GGX with height-correlated visibility, and the sheen lobe; 512 samples each.
///
/// The sheen is not the albedo of anything: half vectors are drawn from Charlie of alpha = p^2, Charlie is evaluated
/// with alpha = p, and the sum is weighted as for a uniform distribution. The renderer shades with these.
#[must_use]
pub fn khronos(perceptual_roughness: f64, cosines: &[f64]) -> Vec<[f64; 3]> {
    const SAMPLES: u32 = 512;
    let alpha = perceptual_roughness * perceptual_roughness;
    let halves = ggx_half_vectors(SAMPLES, alpha);
    let sheen: Vec<(HalfVector, f64)> = half_vectors(SAMPLES, |k| {
        let [turns, u] = hammersley(k, SAMPLES);
        let sine = pow(u, alpha / (2.0 * alpha + 1.0));
        ((1.0 - sine * sine).max(0.0).sqrt(), turns)
    })
    .into_iter()
    .map(|half| (half, charlie(half[1], perceptual_roughness.max(1e-6))))
    .collect();
    let one = |&cosine: &f64| {
        let view = View::new(cosine);
        let [scale, bias] = scale_and_bias(view, &halves, alpha);
        let mut sum = 0.0;
        for &(half, distribution) in &sheen {
            let (v_dot_h, n_dot_l) = view.mirrored(half);
            if n_dot_l > 0.0 {
                sum += neubelt(n_dot_l, view.z).clamp(0.0, 1.0) * distribution * n_dot_l * v_dot_h;
            }
        }
        [scale, bias, sum * 8.0 * PI / f64::from(SAMPLES)]
    };
    cosines.iter().map(one).collect()
}

/// Directional albedo of the Khronos renderer's sheen lobe (Charlie of alpha = roughness^2 with Estevez and Kulla's
/// fitted shadowing), by which it dims the layers beneath: the integral of D V N.L over the hemisphere of lights.
///
/// The renderer reads it from a picture whose making is not published with it; this is the integral that the picture
/// stands for. Midpoint rule over 128 x 128 directions, denser towards the horizon, where the lobe is.
#[must_use]
pub fn sheen_albedo(sheen_roughness: f64, cosines: &[f64]) -> Vec<f64> {
    const STEPS: usize = 128;
    let alpha = (sheen_roughness * sheen_roughness).max(1e-6);
    // N.L = u^2 for u in the middle of equal steps: dN.L = 2 u du.
    let lights: Vec<[f64; 3]> = (0..STEPS)
        .map(|k| {
            let u = (k as f64 + 0.5) / STEPS as f64;
            [u * u, sheen_lambda(u * u, alpha), 2.0 * u / STEPS as f64]
        })
        .collect();
    let azimuths: Vec<f64> = (0..STEPS).map(|k| sin_cos(PI * (k as f64 + 0.5) / STEPS as f64).1).collect();
    let one = |&n_dot_v: &f64| {
        let (sin_v, lambda_v) = ((1.0 - n_dot_v * n_dot_v).max(0.0).sqrt(), sheen_lambda(n_dot_v, alpha));
        let mut sum = 0.0;
        for &[n_dot_l, lambda_l, weight] in &lights {
            let sin_l = (1.0 - n_dot_l * n_dot_l).sqrt();
            let visibility = (1.0 / ((1.0 + lambda_v + lambda_l) * 4.0 * n_dot_v * n_dot_l)).clamp(0.0, 1.0);
            let mut ring = 0.0;
            for cosine in &azimuths {
                let l_dot_v = sin_l * sin_v * cosine + n_dot_l * n_dot_v;
                let n_dot_h = (n_dot_l + n_dot_v) / (2.0 + 2.0 * l_dot_v).max(1e-12).sqrt();
                ring += charlie(n_dot_h.min(1.0), alpha);
            }
            // Both halves of the circle.
            sum += ring * (2.0 * PI / STEPS as f64) * visibility * n_dot_l * weight;
        }
        sum
    };
    cosines.iter().map(one).collect()
}

/// Lambda of Charlie's fitted shadowing (Estevez and Kulla 2017, equations 3 and 4, and table 1).
fn sheen_lambda(cosine: f64, alpha: f64) -> f64 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f64, smooth: f64| rough * (1.0 - t) + smooth * t;
    let a = mix(21.5473, 25.3245);
    let b = mix(3.829_87, 3.324_35);
    let c = mix(0.198_23, 0.168_01);
    let d = mix(-1.977_60, -1.273_93);
    let e = mix(-4.320_54, -4.859_67);
    let fit = |x: f64| a / (1.0 + b * if x > 0.0 { exp(c * ln(x)) } else { 0.0 }) + d * x + e;
    if cosine < 0.5 { exp(fit(cosine)) } else { exp(2.0 * fit(0.5) - fit(1.0 - cosine)) }
}
