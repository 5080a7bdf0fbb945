//! A few directions that stand for all of an environment.

use super::PrefilteredEnvironment;
use super::chain::Levels;
use super::octahedral;
use overcoat_core::dispatch;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use std::borrow::Cow;

/// The directions of an environment that shadows are asked for, in its own frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightDirections {
    /// Unit vectors towards the light.
    pub directions: Vec<[f32; 3]>,
    /// Flux that each stands for: radiance times solid angle, linear Rec. 709. The sum is the flux of the whole sphere.
    pub fluxes: Vec<[f32; 3]>,
    /// The part of the sphere that each stands for, in steradians. The sum is 4 pi.
    pub solid_angles: Vec<f32>,
}

/// Share of the energy that is spread evenly over the sphere when it is divided: dark parts, too, need some directions.
const EVEN_SHARE: f64 = 0.4;

/// Numbers of directions that are kept: those of the tiers, and of the floor in draft.
pub(super) const KEPT: usize = 4;

/// Numbers of directions of the studio that are made beforehand: those of the tiers.
pub const OF_STUDIO: [usize; 3] = [48, 64, 128];

/// Samples along a side of the map that is divided.
const SIZE: usize = 129;

/// Perceptual roughness for which the chain is read there: sharp, but no sharper than the samples are far apart.
const ROUGHNESS: f32 = 0.1;

/// The levels that [`PrefilteredEnvironment::light_directions`] reads.
pub const LIGHT_DIRECTIONS: Levels = Levels::for_roughness(ROUGHNESS, ROUGHNESS);

/// Part of the map, columns and rows from first to end, and the number of directions that it gets.
#[derive(Clone, Copy)]
struct Part {
    first: [usize; 2],
    end: [usize; 2],
    directions: usize,
}

/// Radiance by samples of the map.
struct Samples {
    /// Unit direction of each.
    directions: Vec<[f32; 3]>,
    /// Radiance times solid angle of each.
    fluxes: Vec<[f64; 3]>,
    /// Solid angle of each, in steradians.
    solid_angles: Vec<f64>,
    /// Energy of each sample: the quantity that is divided evenly among the directions.
    energies: Vec<f64>,
}

impl PrefilteredEnvironment {
    /// Up to `count` directions, each of which stands for a part of the sphere with about as much light as the others': the
    /// median cut of Debevec (2005, "A median cut algorithm for light probe sampling") on the octahedral map, with two fifths of
    /// them for what is dark. Where all light comes from one place, there are fewer. Where nothing shines they are spread
    /// evenly and have no flux. Those of the first four numbers that are asked for are kept: frame after frame asks for as many.
    #[must_use]
    pub fn light_directions(&self, count: usize) -> Cow<'_, LightDirections> {
        if let Some(made) = LightDirections::find(self.made_directions, count) {
            return Cow::Owned(made);
        }
        for kept in &self.directions {
            let (of, kept) = kept.get_or_init(|| (count, self.divided(count)));
            if *of == count {
                return Cow::Borrowed(kept);
            }
        }
        Cow::Owned(self.divided(count))
    }

    /// The same, found anew.
    pub(super) fn divided(&self, count: usize) -> LightDirections {
        let mut found = LightDirections::default();
        let samples = Samples::of(self);
        let mut parts = vec![Part { first: [0; 2], end: [SIZE; 2], directions: count }];
        while let Some(part) = parts.pop() {
            match samples.halves(&part) {
                Some([first, second]) => parts.extend([second, first]),
                None => samples.add(&part, &mut found),
            }
        }
        found
    }
}

/// Numbers of a direction as bytes: the vector, the flux, the solid angle.
const NUMBERS: usize = 7;

impl LightDirections {
    /// Directions as bytes: how many (32 bits), then seven singles of each, little endian.
    #[cfg(any(test, feature = "pack"))]
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut out = (self.directions.len() as u32).to_le_bytes().to_vec();
        let parts = self.directions.iter().zip(&self.fluxes).zip(&self.solid_angles);
        for (([x, y, z], [r, g, b]), solid_angle) in parts {
            out.extend([x, y, z, r, g, b, solid_angle].into_iter().flat_map(|v| v.to_le_bytes()));
        }
        out
    }

    /// Directions of one number, of several that stand one after the other.
    fn find(mut bytes: &[u8], count: usize) -> Option<Self> {
        loop {
            let (&length, rest) = bytes.split_first_chunk()?;
            let length = u32::from_le_bytes(length) as usize;
            let (own, others) = rest.split_at_checked(length.checked_mul(4 * NUMBERS)?)?;
            if length == count {
                return Some(Self::read(own.as_chunks().0));
            }
            bytes = others;
        }
    }

    fn read(bytes: &[[u8; 4]]) -> Self {
        let mut found = Self::default();
        for numbers in bytes.as_chunks::<NUMBERS>().0 {
            let [x, y, z, r, g, b, solid_angle] = numbers.map(f32::from_le_bytes);
            found.directions.push([x, y, z]);
            found.fluxes.push([r, g, b]);
            found.solid_angles.push(solid_angle);
        }
        found
    }
}

impl Samples {
    fn of(environment: &PrefilteredEnvironment) -> Self {
        let mut samples = Self {
            directions: Vec::with_capacity(SIZE * SIZE),
            fluxes: Vec::with_capacity(SIZE * SIZE),
            solid_angles: Vec::with_capacity(SIZE * SIZE),
            energies: Vec::new(),
        };
        dispatch!(SimdLevel::best(), l => {
            for first in (0..SIZE * SIZE).step_by(LANES) {
                samples.add_sixteen(l, environment, first);
            }
        });
        // So that they add up to the sphere, which they miss by the curvature of the map.
        let sphere = samples.solid_angles.iter().sum::<f64>() / (4.0 * std::f64::consts::PI);
        for (flux, solid_angle) in samples.fluxes.iter_mut().zip(&mut samples.solid_angles) {
            *solid_angle /= sphere;
            for c in flux {
                *c *= *solid_angle;
            }
        }
        let luminance = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let energies = samples.fluxes.iter().map(|flux| luminance(*flux));
        let all = energies.clone().sum::<f64>();
        let even = EVEN_SHARE / (1.0 - EVEN_SHARE) * all / (4.0 * std::f64::consts::PI);
        let even = if all > 0.0 { even } else { 1.0 };
        let solid_angles = &samples.solid_angles;
        samples.energies = energies.zip(solid_angles).map(|(energy, angle)| energy + even * angle).collect();
        samples
    }

    /// Adds the samples from number `first` on, with radiance in the place of fluxes.
    #[inline(always)]
    fn add_sixteen<L: Lanes>(&mut self, l: L, environment: &PrefilteredEnvironment, first: usize) {
        let cell = 2.0 / (SIZE - 1) as f64;
        let (u, v) = octahedral::positions(l, SIZE, first);
        let (direction, density) = octahedral::directions(l, u, v);
        let radiance = environment.chain.radiance(l, direction, l.splat(ROUGHNESS)).to_arrays();
        let (directions, densities) = (direction.to_arrays(), density.to_array());
        for (k, index) in (first..SIZE * SIZE).take(LANES).enumerate() {
            let share = octahedral::cell_share(SIZE, index % SIZE, index / SIZE);
            self.directions.push(each!(c => directions[c][k]));
            self.fluxes.push(each!(c => f64::from(radiance[c][k])));
            self.solid_angles.push(f64::from(densities[k] * share) * cell * cell);
        }
    }

    /// Numbers of the samples of a part.
    fn numbers(part: &Part) -> impl Iterator<Item = usize> + use<> {
        let Part { first, end, .. } = *part;
        (first[1]..end[1]).flat_map(move |row| (first[0]..end[0]).map(move |column| row * SIZE + column))
    }

    /// Divides a part across its longer side so that both get energy and directions in the same proportion; `None` if it is
    /// one direction or one sample.
    fn halves(&self, part: &Part) -> Option<[Part; 2]> {
        let size = [part.end[0] - part.first[0], part.end[1] - part.first[1]];
        let axis = usize::from(size[1] > size[0]);
        if part.directions < 2 || size[axis] < 2 {
            return None;
        }
        let mut lines = vec![0.0; size[axis]];
        for row in part.first[1]..part.end[1] {
            let energies = &self.energies[row * SIZE..][part.first[0]..part.end[0]];
            if axis == 0 {
                lines.iter_mut().zip(energies).for_each(|(line, energy)| *line += energy);
            } else {
                lines[row - part.first[1]] = energies.iter().sum();
            }
        }
        let all: f64 = lines.iter().sum();
        let first_directions = part.directions / 2;
        let wanted = all * first_directions as f64 / part.directions as f64;
        // The line after which the sum is nearest to what is wanted.
        let (mut best, mut sum) = ((f64::INFINITY, 1), 0.0);
        for (k, line) in lines.iter().enumerate().take(size[axis] - 1) {
            sum += line;
            let miss = (sum - wanted).abs();
            if miss < best.0 {
                best = (miss, k + 1);
            }
        }
        let (mut first, mut second) = (*part, *part);
        first.end[axis] = part.first[axis] + best.1;
        second.first[axis] = first.end[axis];
        first.directions = first_directions;
        second.directions = part.directions - first_directions;
        Some([first, second])
    }

    /// Adds the direction that a part's light comes from on average.
    fn add(&self, part: &Part, found: &mut LightDirections) {
        let (mut flux, mut towards, mut solid_angle) = ([0.0; 3], [0.0; 3], 0.0);
        for number in Self::numbers(part) {
            solid_angle += self.solid_angles[number];
            for c in 0..3 {
                flux[c] += self.fluxes[number][c];
                towards[c] += self.energies[number] * f64::from(self.directions[number][c]);
            }
        }
        let length = (towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2]).sqrt();
        if length > 0.0 {
            found.directions.push(towards.map(|c| (c / length) as f32));
            found.fluxes.push(flux.map(|c| c as f32));
            found.solid_angles.push(solid_angle as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{DistantRadiance, Studio};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::math::lanes::Mask;
    use overcoat_core::math::vec3::{V3, Vec3};

    struct Uniform;

    impl DistantRadiance for Uniform {
        fn radiance<L: Lanes>(&self, l: L, _: V3<L>) -> V3<L> {
            Vec3::splat(l, [1.0, 0.5, 0.25])
        }
    }

    /// A sun of 3 degrees at +X, and nothing else.
    struct Sun;

    impl DistantRadiance for Sun {
        fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
            let cosine = direction.x / direction.length();
            Vec3::uniform(cosine.gt(l.splat(0.9986)).select(l.splat(1000.0), l.zero()))
        }
    }

    fn of(source: &(impl DistantRadiance + Sync), count: usize) -> LightDirections {
        let level = SimdLevel::best();
        PrefilteredEnvironment::from_radiance(source, 8, &Jobs::new(1), level).divided(count)
    }

    #[test]
    fn even_light_comes_from_everywhere_alike() {
        let found = of(&Uniform, 64);
        assert_eq!(found.directions.len(), 64);
        let sphere = 4.0 * std::f32::consts::PI;
        let sum = found.fluxes.iter().fold([0.0; 3], |s, f| [s[0] + f[0], s[1] + f[1], s[2] + f[2]]);
        for (c, radiance) in [1.0, 0.5, 0.25].into_iter().enumerate() {
            assert!((sum[c] / sphere - radiance).abs() < 0.01 * radiance, "{sum:?}");
        }
        let angles: f32 = found.solid_angles.iter().sum();
        assert!((angles / sphere - 1.0).abs() < 1e-5, "{angles}");
        for (flux, angle) in found.fluxes.iter().zip(&found.solid_angles) {
            assert!((flux[0] - angle).abs() < 0.01 * angle, "{flux:?} {angle}");
        }
        let mean = sphere / 64.0;
        assert!(found.fluxes.iter().all(|f| f[0] > 0.5 * mean && f[0] < 1.6 * mean), "{:?}", found.fluxes);
        // No direction is far from all of them.
        for k in 0..6 {
            let axis = |c: usize| if c == k / 2 { 1.0 - (k % 2) as f32 * 2.0 } else { 0.0 };
            let nearest = found.directions.iter().map(|d| (0..3).map(|c| d[c] * axis(c)).sum::<f32>());
            assert!(nearest.fold(-1.0, |m: f32, v| if v > m { v } else { m }) > 0.9);
        }
    }

    /// Another number of directions is not that of the first.
    #[test]
    fn directions_are_kept_by_their_number() {
        let level = SimdLevel::best();
        let environment = PrefilteredEnvironment::from_radiance(&Sun, 8, &Jobs::new(1), level);
        for count in [64, 16, 64, 1, 2, 3, 4, 64] {
            assert_eq!(*environment.light_directions(count), environment.divided(count));
        }
        assert_ne!(environment.light_directions(64), environment.light_directions(16));
        let is_kept = |count| matches!(environment.light_directions(count), Cow::Borrowed(_));
        assert_eq!([64, 16, 4].map(is_kept), [true, true, false]);
    }

    #[test]
    fn a_sun_gets_most_directions_and_they_point_at_it() {
        let found = of(&Sun, 64);
        let all: f32 = found.fluxes.iter().map(|f| f[0]).sum();
        let there: f32 =
            found.directions.iter().zip(&found.fluxes).filter(|(d, _)| d[0] > 0.99).map(|(_, f)| f[0]).sum();
        assert!(there > 0.9 * all, "{there} of {all}");
        assert!(found.directions.iter().filter(|d| d[0] > 0.99).count() > 8);
    }

    #[test]
    fn the_studio_gets_as_many_as_were_asked_for() {
        for count in [1, 16, 48, 64, 128] {
            let found = of(&Studio, count);
            assert_eq!(found.directions.len(), count);
            let angles: f32 = found.solid_angles.iter().sum();
            assert!((angles / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-5, "{angles}");
            for d in &found.directions {
                let length = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                assert!((length - 1.0).abs() < 1e-5);
            }
        }
    }

    /// Directions that were made beforehand are those that would be found.
    #[test]
    fn the_directions_of_the_studio_are_its_own() {
        let studio = PrefilteredEnvironment::studio();
        for count in OF_STUDIO {
            assert_eq!(*studio.light_directions(count), studio.divided(count));
            assert!(LightDirections::find(studio.made_directions, count).is_some());
        }
        assert!(LightDirections::find(studio.made_directions, 50).is_none());
        for end in 0..40 {
            assert!(LightDirections::find(&studio.made_directions[..end], 48).is_none());
        }
    }

    /// Rays find what a black environment leaves to lamps and to surfaces that shine: they need directions, too.
    #[test]
    fn directions_of_black_are_even_and_have_no_flux() {
        let black = PrefilteredEnvironment::black();
        let found = black.light_directions(64);
        assert_eq!(found.directions.len(), 64);
        assert!(found.fluxes.iter().all(|flux| *flux == [0.0; 3]));
        let mean = 4.0 * std::f32::consts::PI / 64.0;
        assert!(found.solid_angles.iter().all(|a| *a > 0.5 * mean && *a < 1.6 * mean), "{found:?}");
    }
}
