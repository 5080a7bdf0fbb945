//! Tests of prefiltered environments against integrals and by symmetry.

use super::*;
use overcoat_core::jobs::Jobs;
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, LANES, Mask, Scalar, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::EquirectImage;
use std::sync::Arc;

/// Radiance of one value from everywhere.
struct Uniform(f32);
impl DistantRadiance for Uniform {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, _: V3<L>) -> V3<L> {
        Vec3::splat(l, [self.0, self.0 * 0.5, 0.0])
    }
}

/// A sharp box light of 20 in a room that is lit by a gradient.
struct BoxLight;
impl DistantRadiance for BoxLight {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, d: V3<L>) -> V3<L> {
        let d = d.normalize();
        let inside = d.x.gt(l.splat(0.5)) & d.y.abs().lt(l.splat(0.2)) & d.z.abs().lt(l.splat(0.3));
        let room = d.y * 0.3 + 0.5;
        Vec3::new(inside.select(l.splat(20.0), room), room, room * 0.1)
    }
}

/// A sun: a disc of 1.15 degrees' radius and radiance 4000, nothing else.
struct Sun([f32; 3]);
impl DistantRadiance for Sun {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, d: V3<L>) -> V3<L> {
        let cos = d.normalize().dot(Vec3::splat(l, self.0));
        let light = cos.gt(l.splat(0.999_8)).select(l.splat(4000.0), l.zero());
        Vec3::new(light, light, light * 0.5)
    }
}

fn filtered(source: &(impl DistantRadiance + Sync), size_log2: u32) -> PrefilteredEnvironment {
    PrefilteredEnvironment::from_radiance(source, size_log2, &Jobs::new(2), SimdLevel::best())
}

fn one(rgb: V3<Scalar>) -> [f32; 3] {
    rgb.lane(0)
}

fn reflected(light: &EnvironmentLight<'_>, d: [f32; 3], p: f32) -> [f32; 3] {
    one(light.radiance(Scalar, Vec3::splat(Scalar, d), Scalar.splat(p)))
}

fn diffuse(light: &EnvironmentLight<'_>, n: [f32; 3]) -> [f32; 3] {
    one(light.irradiance_over_pi(Scalar, Vec3::splat(Scalar, n)))
}

/// Directions spread evenly over the sphere.
fn spread(count: usize) -> impl Iterator<Item = [f32; 3]> {
    (0..count).map(move |k| {
        let y = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let r = (1.0 - y * y).sqrt();
        let (sin, cos) = math::double::sin_cos(k as f64 * 2.399_963_229_728_653);
        [(r * cos) as f32, y as f32, (r * sin) as f32]
    })
}

/// A radiance seen in 200,000 directions.
fn looked_at(source: &impl DistantRadiance) -> Vec<([f32; 3], [f32; 3])> {
    let directions: Vec<_> = spread(200_000).collect();
    let blocks = directions.chunks_exact(LANES).flat_map(|block| {
        let lanes = Vec3::from_fn(|c| Scalar.load(&std::array::from_fn(|k| block[k][c])));
        let rgb = source.radiance(Scalar, lanes);
        (0..LANES).map(move |k| (block[k], rgb.lane(k)))
    });
    blocks.collect()
}

/// The mean of the red channel, weighted by a function of the cosine to `axis`.
fn integral(seen: &[([f32; 3], [f32; 3])], axis: [f32; 3], weight: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (d, rgb) in seen {
        let cos = f64::from(d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]);
        let w = weight(cos);
        total += w;
        sum += w * f64::from(rgb[0]);
    }
    sum / total
}

#[test]
fn furnace_a_uniform_environment_looks_the_same_for_every_roughness_and_normal() {
    let environment = filtered(&Uniform(0.75), 6);
    let light = EnvironmentLight::new(&environment, 33.0, 2.0);
    for d in spread(200) {
        for p in [0.0, 0.03, 0.1, 0.3, 0.5, 0.77, 1.0] {
            let [r, g, b] = reflected(&light, d, p);
            assert!((r - 1.5).abs() < 1e-6 && (g - 0.75).abs() < 1e-6 && b == 0.0, "{p}: {r} {g} {b}");
        }
        let [r, g, b] = diffuse(&light, d);
        assert!((r - 1.5).abs() < 1e-6 && (g - 0.75).abs() < 1e-6 && b == 0.0, "diffuse: {r} {g} {b}");
    }
}

#[test]
fn levels_follow_the_mapping_of_unity() {
    for (level, p) in [(0, 0.0), (2, 0.102_353), (6, 0.342_389), (12, 1.0)] {
        assert!((chain::Chain::perceptual_roughness(level) - p).abs() < 1e-5, "{level}");
    }
    for level in 0..chain::LEVELS {
        let p = chain::Chain::perceptual_roughness(level);
        assert!((p * (1.7 - 0.7 * p) * 6.0 - level as f64 * 0.5).abs() < 1e-12);
    }
}

/// Root mean square of the difference between two lists relative to the second's, and the largest difference
/// relative to its mean.
fn errors(found: &[f64], truth: &[f64]) -> (f64, f64) {
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let (mut square, mut power, mut largest) = (0.0, 0.0, 0.0);
    for (f, t) in found.iter().zip(truth) {
        square += (f - t) * (f - t);
        power += t * t;
        let error = (f - t).abs() / mean;
        largest = if error > largest { error } else { largest };
    }
    ((square / power).sqrt(), largest)
}

#[test]
fn reflections_agree_with_the_integral() {
    let environment = filtered(&BoxLight, 8);
    let light = EnvironmentLight::new(&environment, 0.0, 1.0);
    let seen = looked_at(&BoxLight);
    // Perceptual roughness on levels and between, and the error allowed: about 1.5 times what was found.
    for (p, allowed) in [
        (0.15_f64, 0.009),
        (0.215_1, 0.008),
        (0.25, 0.012),
        (0.342_4, 0.01),
        (0.5, 0.012),
        (0.7, 0.016),
        (1.0, 0.01),
    ] {
        let alpha2: f64 = p * p * p * p;
        let (mut found, mut truth) = (Vec::new(), Vec::new());
        for d in spread(40) {
            found.push(f64::from(reflected(&light, d, p as f32)[0]));
            truth.push(integral(&seen, d, |cos| {
                if cos <= 0.0 {
                    return 0.0;
                }
                let n_dot_h2 = 0.5 + 0.5 * cos;
                let q = n_dot_h2 * (alpha2 - 1.0) + 1.0;
                cos * alpha2 / (q * q)
            }));
        }
        let (rms, _) = errors(&found, &truth);
        println!("perceptual roughness {p}: rms error {rms:.4}");
        assert!(rms < allowed, "perceptual roughness {p}: rms error {rms:.4}");
    }
}

#[test]
fn irradiance_agrees_with_the_integral() {
    let environment = filtered(&BoxLight, 7);
    let light = EnvironmentLight::new(&environment, 0.0, 1.0);
    let seen = looked_at(&BoxLight);
    let (mut found, mut truth) = (Vec::new(), Vec::new());
    for d in spread(60) {
        found.push(f64::from(diffuse(&light, d)[0]));
        truth.push(integral(&seen, d, |cos| if cos > 0.0 { cos } else { 0.0 }));
    }
    let (rms, largest) = errors(&found, &truth);
    println!("irradiance: rms error {rms:.4}, largest {largest:.4}");
    assert!(rms < 0.006 && largest < 0.02, "rms {rms:.4}, largest {largest:.4}");
}

#[test]
fn a_sun_gives_no_negative_light_and_no_fireflies() {
    let towards = [0.48, 0.6, 0.64];
    let environment = filtered(&Sun(towards), 8);
    let light = EnvironmentLight::new(&environment, 0.0, 1.0);
    for d in spread(2000) {
        for v in diffuse(&light, d) {
            assert!(v >= 0.0 && v.is_finite());
        }
        for p in [0.0, 0.2, 0.4, 0.6, 1.0] {
            assert!(reflected(&light, d, p).iter().all(|v| *v >= 0.0 && v.is_finite()));
        }
    }
    // Around a rough reflection of the sun the lobe is smooth: equal at equal angles.
    let [x, y, z] = towards;
    let across = [z, 0.0, -x].map(|v| v / (x * x + z * z).sqrt());
    let along = [y * across[2], z * across[0] - x * across[2], -y * across[0]];
    for p in [0.342_39_f32, 0.491_7, 0.681_4, 1.0] {
        let tilt = p * p;
        let ring: Vec<f64> = (0..32)
            .map(|k| {
                let (sin, cos) = math::double::sin_cos(f64::from(k) * std::f64::consts::TAU / 32.0);
                let d = std::array::from_fn(|c| {
                    towards[c] + tilt * (across[c] * cos as f32 + along[c] * sin as f32)
                });
                f64::from(reflected(&light, d, p)[0])
            })
            .collect();
        let mean = ring.iter().sum::<f64>() / 32.0;
        // Roughness 1 is the cosine lobe: radiance times solid angle times cos 45 degrees, over pi.
        if p == 1.0 {
            let expected = 4000.0 * 2.0 * (1.0 - 0.9998) * std::f64::consts::FRAC_1_SQRT_2;
            assert!((mean / expected - 1.0).abs() < 0.05, "{mean} where {expected} is expected");
        }
        let (rms, largest) = errors(&ring, &[mean; 32]);
        println!("sun at {p}: {mean:.3} with a scatter of {rms:.4}, {largest:.4}");
        assert!(rms < 0.05 && largest < 0.12, "{p}: {mean} rms {rms} largest {largest}");
    }
    // All of the sun's light is there: irradiance on a surface that faces it is radiance times solid angle, but for
    // what the window takes.
    let solid_angle = 2.0 * std::f32::consts::PI * (1.0 - 0.999_8);
    let facing = diffuse(&light, towards)[0] / (4000.0 * solid_angle * std::f32::consts::FRAC_1_PI);
    println!("facing the sun: {facing:.3}");
    assert!((0.91..1.01).contains(&facing), "{facing}");
}

#[test]
fn bright_spots_are_seen_where_the_picture_has_them() {
    // One bright pixel block at each axis; u = 0.5 is +X, 0.75 +Z, 0 -X, 0.25 -Z; the first rows are +Y.
    let (width, height) = (64, 32);
    let axes = [
        ([1.0, 0.0, 0.0], (32, 16)),
        ([0.0, 0.0, 1.0], (48, 16)),
        ([-1.0, 0.0, 0.0], (0, 16)),
        ([0.0, 0.0, -1.0], (16, 16)),
        ([0.0, 1.0, 0.0], (0, 0)),
        ([0.0, -1.0, 0.0], (0, 32)),
    ];
    for (axis, (u, v)) in axes {
        let mut pixels = vec![[0.0_f32; 3]; width * height];
        for y in v.max(2) - 2..(v + 2).min(height) {
            let pole = v == 0 || v == height;
            for x in 0..width {
                let near = (x + width - u + 2) % width < 4;
                if pole || near {
                    pixels[y * width + x] = [9.0; 3];
                }
            }
        }
        let picture = Arc::new(EquirectImage::new(width as u32, height as u32, pixels).unwrap());
        let environment = PrefilteredEnvironment::new(&picture, &Jobs::new(1), SimdLevel::best());
        for degrees in [0.0_f32, 90.0, 30.0, -400.0] {
            let light = EnvironmentLight::new(&environment, degrees, 1.0);
            // The environment turns counter-clockwise seen from above: +X goes to (cos, 0, -sin).
            let (sin, cos) = math::double::sin_cos(f64::from(degrees).to_radians());
            let (sin, cos) = (sin as f32, cos as f32);
            let seen = [axis[0] * cos + axis[2] * sin, axis[1], axis[2] * cos - axis[0] * sin];
            let background = |d: [f32; 3]| one(light.background(Scalar, Vec3::splat(Scalar, d)))[0];
            let away = seen.map(|c: f32| -c);
            assert!(reflected(&light, seen, 0.0)[0] > 8.9, "{axis:?} turned by {degrees}");
            assert!(background(seen) > 8.9, "{axis:?} turned by {degrees}");
            assert!(reflected(&light, away, 0.0)[0] < 0.01 && background(away) < 0.01);
            for p in [0.3, 1.0] {
                assert!(reflected(&light, seen, p)[0] > 2.0 * reflected(&light, away, p)[0]);
            }
            assert!(diffuse(&light, seen)[0] > 2.0 * diffuse(&light, away)[0]);
        }
    }
}

#[test]
fn lookups_are_continuous_across_every_fold() {
    let environment = filtered(&BoxLight, 5);
    let light = EnvironmentLight::new(&environment, 0.0, 1.0);
    let tiny = 1e-6;
    for d in spread(500) {
        // Onto each of the planes where the map folds or ends.
        for plane in 0..3 {
            let (mut a, mut b) = (d, d);
            a[plane] = tiny;
            b[plane] = -tiny;
            for p in [0.0, 0.2, 0.9] {
                let (x, y) = (reflected(&light, a, p), reflected(&light, b, p));
                assert!((x[0] - y[0]).abs() < 2e-3 * (x[0] + 0.1), "{a:?} at {p}: {x:?} {y:?}");
            }
            let (x, y) = (diffuse(&light, a), diffuse(&light, b));
            assert!((x[0] - y[0]).abs() < 1e-4 * (x[0] + 0.1));
        }
    }
}

#[test]
fn the_same_bits_at_every_level_and_for_any_number_of_threads() {
    let mut state = 5_u32;
    let pixels = (0..48 * 24)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            [(state >> 24) as f32, (state >> 16 & 255) as f32 * 0.1, 1.0]
        })
        .collect();
    let picture = Arc::new(EquirectImage::new(48, 24, pixels).unwrap());
    let expected = PrefilteredEnvironment::new(&picture, &Jobs::new(1), SimdLevel::Scalar);
    for level in SimdLevel::available() {
        for threads in [1, 2, 3, 7] {
            let found = PrefilteredEnvironment::new(&picture, &Jobs::new(threads), level);
            assert!(found.chain.texels() == expected.chain.texels(), "{level}, {threads} threads");
        }
    }
    let light = EnvironmentLight::new(&expected, 12.5, 1.5);
    for d in spread(64).collect::<Vec<_>>().chunks_exact(LANES) {
        let run = |level| {
            overcoat_core::dispatch!(level, l => {
                let direction = Vec3::from_fn(|c| l.load(&std::array::from_fn(|k| d[k][c])));
                let p = l.load(&std::array::from_fn(|k| k as f32 / 15.0));
                [
                    light.radiance(l, direction, p),
                    light.irradiance_over_pi(l, direction),
                    light.background(l, direction),
                ]
                .map(|rgb| rgb.to_arrays().map(|c| c.map(f32::to_bits)))
            })
        };
        let expected: [[[u32; LANES]; 3]; 3] = run(SimdLevel::Scalar);
        for level in SimdLevel::available() {
            assert!(run(level) == expected, "{level}");
        }
    }
}

#[test]
fn odd_directions_and_roughnesses_are_safe() {
    let environment = filtered(&BoxLight, 5);
    let light = EnvironmentLight::new(&environment, 1e6, 1.0);
    for d in [[0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [1e-38, 0.0, -1e-38], [1e30, 1e30, -1e30]] {
        for p in [-1.0, 2.0, f32::NAN] {
            assert!(reflected(&light, d, p).iter().all(|v| v.is_finite()), "{d:?} {p}");
        }
        assert!(diffuse(&light, d).iter().all(|v| v.is_finite()), "{d:?}");
    }
    let black = PrefilteredEnvironment::black();
    let light = EnvironmentLight::new(&black, 0.0, 1.0);
    assert_eq!(reflected(&light, [0.0, 1.0, 0.0], 0.5), [0.0; 3]);
    assert_eq!(diffuse(&light, [0.0, 1.0, 0.0]), [0.0; 3]);
}

#[test]
fn bytes_keep_an_environment_and_its_sharpest_map_fits_the_picture() {
    let environment = filtered(&BoxLight, 6);
    let read = PrefilteredEnvironment::from_bytes(&environment.to_bytes()).unwrap();
    assert!(read.chain.texels() == environment.chain.texels());
    for (width, height, size) in [(1, 1, 33), (128, 64, 65), (200, 100, 129)] {
        let pixels = vec![[1.0; 3]; width * height];
        let picture = Arc::new(EquirectImage::new(width as u32, height as u32, pixels).unwrap());
        let found = PrefilteredEnvironment::new(&picture, &Jobs::new(2), SimdLevel::best());
        assert_eq!(found.chain.size(0), size, "{width} x {height}");
    }
}
