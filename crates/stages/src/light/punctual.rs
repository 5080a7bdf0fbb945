//! Directional, point and spot lights in the units of KHR_lights_punctual.
//!
//! **Units.** Directional lights are given in lux, point and spot lights in candela; what arrives at a surface is
//! illuminance E in lux. The renderer's unit of radiance is the candela per square metre, so a white Lambert
//! surface that a light of 1 lux faces has radiance E / pi = 0.318, as in three.js, Filament and the Khronos viewer.
//! Environments use the same unit: a uniform radiance of 1 gives E = pi and makes the same surface 1. Nothing is
//! scaled on the way in; files whose lights are in physical magnitudes (an exporter that writes 683 lumen per watt, a
//! sun of 100,000 lux) want an exposure to match, which multiplies the finished radiance: 1 lux becomes white at
//! exposure pi.

use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Light, LightKind};

/// Squared distance in square metres below which a light comes no closer: 1 mm.
const MIN_DISTANCE_SQUARED: f32 = 1e-6;

/// A light ready for shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PunctualLight {
    /// Colour times intensity: lux or candela.
    intensity: [f32; 3],
    /// Its number among the lights without extent of the scene; 0 until it is given one.
    pub number: u32,
    /// Least alpha of what it shines on, 0 to 1.
    pub minimum_roughness: f32,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Directional { towards: [f32; 3] },
    Positional { position: [f32; 3], inverse_range_squared: f32, cone: Option<Cone> },
}

/// A spot light's cone: attenuation is saturate(cos * scale + offset)^2.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    /// From the scene to the light, along its axis.
    towards: [f32; 3],
    scale: f32,
    offset: f32,
}

/// Light that arrives at sixteen points from one source.
#[derive(Clone, Copy)]
pub struct LightSample<L: Lanes> {
    /// Unit vector from the point towards the light.
    pub direction: V3<L>,
    /// Illuminance in lux per colour channel on a surface that faces the light; 0 out of reach.
    pub irradiance: V3<L>,
    /// See [`PunctualLight::minimum_roughness`].
    pub minimum_roughness: f32,
}

impl PunctualLight {
    /// Prepares a light of a valid scene; `None` for lights with an extent, see [`super::AreaLight`].
    #[must_use]
    pub fn new(light: &Light) -> Option<Self> {
        let intensity = each!(c in light.color => c * light.intensity);
        let kind = match light.kind {
            LightKind::Directional { direction } => Kind::Directional { towards: unit_opposite(direction) },
            LightKind::Point { position, range } => {
                Kind::Positional { position, inverse_range_squared: inverse_square(range), cone: None }
            }
            LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine } => {
                let width = inner_cone_cosine - outer_cone_cosine;
                let scale = 1.0 / if width > 0.001 { width } else { 0.001 };
                Kind::Positional {
                    position,
                    inverse_range_squared: inverse_square(range),
                    cone: Some(Cone {
                        towards: unit_opposite(direction),
                        scale,
                        offset: -outer_cone_cosine * scale,
                    }),
                }
            }
            LightKind::Rect { .. } | LightKind::Tube { .. } => return None,
        };
        Some(Self { intensity, number: 0, minimum_roughness: light.minimum_roughness, kind })
    }

    /// The same with a number.
    #[must_use]
    pub fn with_number(self, number: u32) -> Self {
        Self { number, ..self }
    }

    /// Position, and the distance from which on it gives no light at all; `None` for lights without a range.
    #[must_use]
    pub fn reach(&self) -> Option<([f32; 3], f64)> {
        match self.kind {
            Kind::Positional { position, inverse_range_squared, .. } if inverse_range_squared > 0.0 => {
                Some((position, 1.0 / f64::from(inverse_range_squared).sqrt()))
            }
            _ => None,
        }
    }

    /// Direction and irradiance at world-space points.
    ///
    /// The recommended formulas of KHR_lights_punctual: 1 / d^2, times max(min(1 - (d / range)^4, 1), 0) where the
    /// light has a range, times the spot's saturate((cos - cos outer) / max(0.001, cos inner - cos outer))^2.
    /// Deviation: d is at least 1 mm.
    #[inline(always)]
    #[must_use]
    pub fn sample<L: Lanes>(&self, l: L, position: V3<L>) -> LightSample<L> {
        let intensity = Vec3::splat(l, self.intensity);
        match &self.kind {
            Kind::Directional { towards } => LightSample {
                direction: Vec3::splat(l, *towards),
                irradiance: intensity,
                minimum_roughness: self.minimum_roughness,
            },
            Kind::Positional { position: from, inverse_range_squared, cone } => {
                let to_light = Vec3::splat(l, *from) - position;
                let squared = to_light.dot(to_light);
                let direction = to_light.normalize();
                let near = squared.at_least(MIN_DISTANCE_SQUARED);
                let share = near * *inverse_range_squared;
                let mut factor = (share * share).one_minus().saturate() / near;
                if let Some(cone) = cone {
                    let cos = direction.dot(Vec3::splat(l, cone.towards));
                    factor = factor * (cos * cone.scale + cone.offset).saturate().squared();
                }
                // The quotient of a tiny factor can be subnormal, which is slow and dark: none.
                let factor = factor.lt(l.splat(1e-30)).select(l.zero(), factor);
                LightSample {
                    direction,
                    irradiance: intensity * factor,
                    minimum_roughness: self.minimum_roughness,
                }
            }
        }
    }
}

/// 1 / range^2 in 1 / m^2; 0 without a range. Ranges below 1e-9 m count as that.
fn inverse_square(range: Option<f32>) -> f32 {
    range.map_or(0.0, |r| {
        let r = if r > 1e-9 { r } else { 1e-9 };
        1.0 / (r * r)
    })
}

/// The opposite of a nearly unit vector, at unit length.
fn unit_opposite(d: [f32; 3]) -> [f32; 3] {
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    each!(c in d => -c / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::{LANES, Scalar, SimdLevel};

    fn light(kind: LightKind) -> PunctualLight {
        PunctualLight::new(&Light::new(kind).with(|l| {
            l.color = [1.0, 0.5, 0.0];
            l.intensity = 8.0;
        }))
        .expect("a punctual light")
    }

    fn at(light: &PunctualLight, position: [f32; 3]) -> ([f32; 3], [f32; 3]) {
        let sample = light.sample(Scalar, Vec3::splat(Scalar, position));
        (sample.direction.lane(0), sample.irradiance.lane(0))
    }

    #[test]
    fn directional_light_is_the_same_everywhere() {
        let sun = light(LightKind::Directional { direction: [0.0, -1.0, 0.0] });
        assert_eq!(at(&sun, [5.0, -3.0, 1e6]), ([0.0, 1.0, 0.0], [8.0, 4.0, 0.0]));
    }

    #[test]
    fn point_light_falls_with_the_square_of_the_distance() {
        let lamp = light(LightKind::Point { position: [1.0, 2.0, 3.0], range: None });
        assert_eq!(at(&lamp, [1.0, 0.0, 3.0]), ([0.0, 1.0, 0.0], [2.0, 1.0, 0.0]));
        assert_eq!(at(&lamp, [5.0, 2.0, 3.0]).1[0], 0.5);
        // At the light itself and very far away numbers stay finite.
        for position in [[1.0, 2.0, 3.0], [1e15, 0.0, 0.0]] {
            let (direction, irradiance) = at(&lamp, position);
            assert!(direction.iter().chain(&irradiance).all(|v| v.is_finite()), "{position:?}");
        }
    }

    #[test]
    fn range_fades_to_darkness() {
        let lamp = light(LightKind::Point { position: [0.0; 3], range: Some(2.0) });
        assert_eq!(at(&lamp, [1.0, 0.0, 0.0]).1[0], 8.0 * (1.0 - 1.0 / 16.0));
        assert_eq!(at(&lamp, [2.0, 0.0, 0.0]).1, [0.0; 3]);
        assert_eq!(at(&lamp, [1e18, 0.0, 0.0]).1, [0.0; 3]);
    }

    #[test]
    fn spot_is_full_inside_the_inner_cone_and_dark_outside_the_outer() {
        let spot = light(LightKind::Spot {
            position: [0.0; 3],
            direction: [0.0, 0.0, -1.0],
            range: None,
            inner_cone_cosine: 0.9,
            outer_cone_cosine: 0.7,
        });
        // Unit distance at an angle whose cosine is given.
        let seen = |cos: f32| at(&spot, [(1.0 - cos * cos).sqrt(), 0.0, -cos]).1[0];
        assert!((seen(1.0) - 8.0).abs() < 1e-5);
        assert!((seen(0.91) - 8.0).abs() < 1e-5);
        assert!((seen(0.8) - 8.0 * 0.25).abs() < 1e-4);
        assert_eq!(seen(0.69), 0.0);
        assert_eq!(at(&spot, [0.0, 0.0, 1.0]).1[0], 0.0);
    }

    #[test]
    fn equal_cone_angles_make_a_hard_edge() {
        let spot = light(LightKind::Spot {
            position: [0.0; 3],
            direction: [0.0, 0.0, -1.0],
            range: None,
            inner_cone_cosine: 0.8,
            outer_cone_cosine: 0.8,
        });
        assert_eq!(at(&spot, [0.61, 0.0, -0.79]).1[0], 0.0);
        assert!(at(&spot, [0.59, 0.0, -0.81]).1[0] > 7.9);
    }

    #[test]
    fn every_level_gives_the_same_bits() {
        let spot = light(LightKind::Spot {
            position: [0.3, 1.7, -0.2],
            direction: [0.6, -0.8, 0.0],
            range: Some(3.0),
            inner_cone_cosine: 0.9,
            outer_cone_cosine: 0.3,
        });
        let run = |level| {
            overcoat_core::dispatch!(level, l => {
                let x = l.load(&std::array::from_fn(|k| k as f32 * 0.2 - 1.0));
                let sample = spot.sample(l, Vec3::new(x, x * 0.3, x * -0.7));
                [sample.direction, sample.irradiance].map(|v| v.to_arrays().map(|c| c.map(f32::to_bits)))
            })
        };
        let expected: [[[u32; LANES]; 3]; 2] = run(SimdLevel::Scalar);
        for level in SimdLevel::available() {
            assert_eq!(run(level), expected, "{level}");
        }
    }
}
