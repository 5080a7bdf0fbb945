//! A smooth lacquer over a matt base in closed form: what total reflection from within has to do with how dark the base gets.
//!
//! R is Fresnel's reflectance from outside, T = 1 - R, and r the mean of the reflectance from within over the cosines of light
//! that a matt surface sends, which [`Beyond`] the critical angle is 1 or, as `FresnelUnpolarized` has it, 0. Of the light that is
//! sent the share 1 - r gets out, and what does not comes back to the base:
//!
//! ```text
//! lamp   E cos(l) T(l) T(v) / pi  (1 - r) a / (1 - r a) / t       t the mean of T from outside
//! sky    R(v) + T(v) (1 - r) a / (1 - r a)
//! ```
//!
//! The highlight of a lamp in a smooth coat is a point, and not part of it.

use super::ball::{Color, L, Number, Setting};
use overcoat::scene::{Material, ShadingModel};
use overcoat_core::math::double::sin_cos;
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::Vec3;
use overcoat_lab::lab::{Light, Referee, Specimen};
use overcoat_lab::truth::Samples;
use std::f64::consts::PI;

/// Whose normals are shaded: any model's.
pub const CARRIER: ShadingModel = ShadingModel::Standard;

const INDEX: f64 = 1.5;

/// Albedo of the base.
const BLUE: [f64; 3] = [0.1, 0.18, 0.5];

/// Treatment of light from within beyond the critical angle.
#[derive(Clone, Copy, PartialEq)]
pub enum Beyond {
    Reflected,
    Lost,
}

/// Any ball.
pub fn material() -> Material {
    Material::default()
}

/// Fresnel's reflectance for unpolarized light from the side of index 1 to that of `index`, `beyond` where it is total.
fn fresnel(cosine: f64, index: f64, beyond: f64) -> f64 {
    let sine2 = (1.0 - cosine * cosine) / (index * index);
    if sine2 >= 1.0 {
        return beyond;
    }
    let other = (1.0 - sine2).sqrt();
    let s = (cosine - index * other) / (cosine + index * other);
    let p = (index * cosine - other) / (index * cosine + other);
    0.5 * (s * s + p * p)
}

/// Mean of a reflectance over the directions of matt light, 2 u du, by the midpoints of steps in u^2.
fn mean(of: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 4096;
    (0..STEPS).map(|k| of(((k as f64 + 0.5) / STEPS as f64).sqrt())).sum::<f64>() / STEPS as f64
}

/// Means over the hemisphere.
#[derive(Clone, Copy)]
struct Means {
    /// Reflectance of the upper side for matt light from outside, which is lost to the lacquer.
    outside: f64,
    /// Reflectance of the upper side for matt light from within, which is sent back.
    inside: f64,
}

impl Means {
    fn new(beyond: Beyond) -> Self {
        let total = if beyond == Beyond::Reflected { 1.0 } else { 0.0 };
        Self { outside: mean(|u| fresnel(u, INDEX, 0.0)), inside: mean(|u| fresnel(u, 1.0 / INDEX, total)) }
    }

    /// Share of the light that has entered which leaves again.
    fn leaves(&self, albedo: f64) -> f64 {
        (1.0 - self.inside) * albedo / (1.0 - self.inside * albedo)
    }

    /// Radiance under a sky of radiance 1.
    fn sky(&self, albedo: f64, view: f64) -> f64 {
        let r = fresnel(view, INDEX, 0.0);
        r + (1.0 - r) * self.leaves(albedo)
    }

    /// Radiance under a lamp of irradiance 1.
    fn lamp(&self, albedo: f64, view: f64, light: f64) -> f64 {
        if light <= 0.0 {
            return 0.0;
        }
        let through = (1.0 - fresnel(view, INDEX, 0.0)) * (1.0 - fresnel(light, INDEX, 0.0));
        light * through * self.leaves(albedo) / (PI * (1.0 - self.outside))
    }
}

pub fn shade(normal: Color, setting: &Setting, beyond: Beyond) -> Color {
    let means = Means::new(beyond);
    let view = normal.z.to_array().map(f64::from);
    let light = normal.dot(setting.direction()).to_array().map(f64::from);
    let channel = |albedo: f64| -> Number {
        let shown: [f32; LANES] = std::array::from_fn(|k| {
            let sky = f64::from(setting.sky) * means.sky(albedo, view[k]);
            (sky + f64::from(setting.lamp) * means.lamp(albedo, view[k], light[k])) as f32
        });
        L.load(&shown)
    };
    let [r, g, b] = BLUE.map(channel);
    Vec3::new(r, g, b)
}

/// The right one of the two is what a random walk through the layers finds.
pub fn must_be_what_the_referee_finds() {
    let specimen = Specimen { coat_roughness: 0.0, specular: 0.0, color: BLUE, ..Specimen::default() };
    let referee = Referee::new(&specimen).unwrap();
    let [means, lost] = [Beyond::Reflected, Beyond::Lost].map(Means::new);
    let samples = Samples::new(1 << 14);
    for view in [0.0_f64, 40.0, 70.0] {
        let found = referee.radiance(view, Light::White, &samples).unwrap();
        let lit = referee.radiance(view, Light::Direct(-30.0), &samples).unwrap();
        let [cosine, light] = [view, 30.0].map(|degrees: f64| sin_cos(degrees.to_radians()).1);
        for (c, albedo) in BLUE.into_iter().enumerate() {
            for (found, right, wrong) in [
                (found, means.sky(albedo, cosine), lost.sky(albedo, cosine)),
                (lit, means.lamp(albedo, cosine, light), lost.lamp(albedo, cosine, light)),
            ] {
                let (seen, error) = (found.mean()[c], found.standard_error()[c]);
                let off = 4.0 * error + 2e-3 * right;
                assert!((seen - right).abs() < off, "{view} {c}: {seen} +- {error}, not {right}");
                assert!((seen - wrong).abs() > off, "{view} {c}: {seen} +- {error}, {wrong} as well");
            }
        }
    }
}
