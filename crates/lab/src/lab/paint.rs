//! Effect paint in the numbers of the trade: colour at the angles of multi-angle instruments, flop, sparkle and graininess.
//!
//! *Colours.* Light falls at 45 degrees; aspecular angles count from the mirror direction towards the light: 15, 25, 45, 75 and 110 degrees,
//! as multi-angle instruments have them (ASTM E2194, E2539). Flakes are as small as can be, so that a spot shows the mean of all. L*a*b* is
//! CIE 1976 with the white of D65, of linear Rec. 709: three channels, no spectra.
//!
//! *Flop.* `2.69 (L15 - L110)^1.11 / L45^.86` (Alman 1987): 0 for one colour at all angles, 15 to 17 for strong metallics.
//!
//! *Sparkle and graininess* are not those of an instrument, whose evaluation no maker has published. A plate of [`PLATE`] metres a side is drawn with pixels
//! of a tenth of a millimetre, about what an eye tells apart at 35 cm, and looked at straight from above.

use super::{Bench, LabError, Light};
use overcoat_core::math::double::{atan2, pow};
use overcoat_scene::{Flakes, Material, ShadingModel, Texture};

/// Aspecular angles in degrees.
pub const ASPECULAR: [f64; 5] = [15.0, 25.0, 45.0, 75.0, 110.0];

/// Angles of lamps under which sparkle is counted, in degrees from the normal.
pub const SPARKLE: [f64; 3] = [15.0, 45.0, 75.0];

/// Side of the plate in metres, and its pixels along one.
pub const PLATE: f32 = 0.025_6;
const PIXELS: u32 = 256;

/// Angle of the light for colours, in degrees.
const LIGHT: f64 = 45.0;

/// Factor over the plate's mean from which a pixel sparkles.
const SPARKLES: f64 = 2.0;

/// Colour at an aspecular angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaintColor {
    /// Degrees from the mirror direction.
    pub aspecular: f64,
    /// Reflectance factor in linear Rec. 709: 1 is the perfect diffuser.
    pub reflectance: [f64; 3],
    /// L*, a* and b*.
    pub lab: [f64; 3],
}

impl PaintColor {
    fn new(aspecular: f64, reflectance: [f64; 3]) -> Self {
        Self { aspecular, reflectance, lab: lab(reflectance) }
    }

    /// C*.
    #[must_use]
    pub fn chroma(&self) -> f64 {
        let [_, a, b] = self.lab;
        (a * a + b * b).sqrt()
    }

    /// h in degrees, 0 to 360.
    #[must_use]
    pub fn hue(&self) -> f64 {
        let [_, a, b] = self.lab;
        let degrees = atan2(b, a).to_degrees();
        if degrees < 0.0 { degrees + 360.0 } else { degrees }
    }
}

/// Sparkle under a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sparkle {
    /// Degrees of the lamp from the normal.
    pub light: f64,
    /// Share of pixels that are twice as bright as the mean, or more.
    pub area: f64,
    /// Mean of their brightness over that of the plate; 0 if there are none.
    pub intensity: f64,
}

impl Sparkle {
    /// Percent of area times intensity: light in sparkles, of all.
    #[must_use]
    pub fn grade(&self) -> f64 {
        100.0 * self.area * self.intensity
    }
}

/// Measurements of a paint.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintMeasure {
    /// At each of [`ASPECULAR`].
    pub colors: Vec<PaintColor>,
    /// At each of [`SPARKLE`].
    pub sparkle: Vec<Sparkle>,
    /// Standard deviation over mean of the plate under [`Light::Overhead`].
    pub graininess: f64,
}

impl PaintMeasure {
    /// Measures a material that reads these textures.
    ///
    /// # Errors
    /// [`LabError`] if the material cannot be drawn.
    pub fn of(
        bench: &mut Bench,
        material: &Material,
        textures: &[Texture],
        model: ShadingModel,
    ) -> Result<Self, LabError> {
        let material = &material.clone().with(|m| m.model = Some(model));
        let mut far = material.clone();
        far.lobes.flakes.size = Flakes::LEAST_SIZE;
        let surface = &mut far.lobes.coat_surface;
        (surface.peel_size, surface.swirl_size) = (Flakes::LEAST_SIZE, Flakes::LEAST_SIZE);
        let mut colors = Vec::new();
        for aspecular in ASPECULAR {
            // The view from the normal; the light stands on the side that it leans to, or on the other.
            let view = LIGHT - aspecular;
            let light = Light::Direct(if view < 0.0 { -LIGHT } else { LIGHT });
            let shown = bench.textured_radiance(&far, textures, model, view.abs(), light)?;
            // A perfect diffuser shows the cosine over pi.
            let factor = std::f64::consts::PI / overcoat_core::math::double::cos(LIGHT.to_radians());
            colors.push(PaintColor::new(aspecular, shown.map(|c| c * factor)));
        }
        let mut sparkle = Vec::new();
        for light in SPARKLE {
            let plate = bench.plate(material, textures, model, Light::Direct(light), (PLATE, PIXELS))?;
            let mean = plate.iter().sum::<f64>() / plate.len() as f64;
            let bright = plate.iter().filter(|&&y| y >= SPARKLES * mean && y > 0.0);
            let (count, sum) = bright.fold((0.0, 0.0), |(count, sum), y| (count + 1.0, sum + y));
            let intensity = if count > 0.0 { sum / count / mean } else { 0.0 };
            sparkle.push(Sparkle { light, area: count / plate.len() as f64, intensity });
        }
        let plate = bench.plate(material, textures, model, Light::Overhead, (PLATE, PIXELS))?;
        Ok(Self { colors, sparkle, graininess: contrast(&plate) })
    }

    /// Flop index; `None` where a paint does not grow darker.
    #[must_use]
    pub fn flop_index(&self) -> Option<f64> {
        let lightness =
            |aspecular: f64| self.colors.iter().find(|c| c.aspecular == aspecular).map(|c| c.lab[0]);
        flop_index(lightness(15.0)?, lightness(45.0)?, lightness(110.0)?)
    }
}

/// Flop index of L* at aspecular angles of 15, 45 and 110 degrees.
fn flop_index(at_15: f64, at_45: f64, at_110: f64) -> Option<f64> {
    let fall = at_15 - at_110;
    (fall >= 0.0 && at_45 > 0.0).then(|| 2.69 * pow(fall, 1.11) / pow(at_45, 0.86))
}

/// Standard deviation over mean.
fn contrast(plate: &[f64]) -> f64 {
    let mean = plate.iter().sum::<f64>() / plate.len() as f64;
    let variance = plate.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / plate.len() as f64;
    if mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
}

/// CIE 1976 L*a*b* of linear Rec. 709, which has the white of D65.
fn lab([r, g, b]: [f64; 3]) -> [f64; 3] {
    let x = 0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b;
    let y = 0.212_672_9 * r + 0.715_152_2 * g + 0.072_175_0 * b;
    let z = 0.019_333_9 * r + 0.119_192_0 * g + 0.950_304_1 * b;
    // Both branches meet at (6/29)^3.
    let f = |t: f64| if t > 216.0 / 24_389.0 { pow(t, 1.0 / 3.0) } else { t * (841.0 / 108.0) + 4.0 / 29.0 };
    let [fx, fy, fz] = [f(x / 0.950_470), f(y), f(z / 1.088_83)];
    [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::Workflow;

    fn painted(flakes: f32, size: f32) -> Material {
        Material::default().with(|m| {
            m.base_color = [0.1, 0.1, 0.1, 1.0];
            m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.9, texture: None };
            m.specular = 0.0;
            (m.lobes.flakes.share, m.lobes.flakes.size) = (flakes, size);
        })
    }

    #[test]
    fn lightness_and_hue_are_those_of_the_cie() {
        let close = |found: [f64; 3], right: [f64; 3]| {
            assert!((0..3).all(|k| (found[k] - right[k]).abs() < 0.02), "{found:?}, not {right:?}");
        };
        // Lindbloom's values of sRGB's corners.
        close(lab([1.0; 3]), [100.0, 0.0, 0.0]);
        close(lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20]);
        close(lab([0.0, 0.0, 1.0]), [32.30, 79.19, -107.86]);
        close(lab([0.18; 3]), [49.50, 0.0, 0.0]);
        let blue = PaintColor::new(45.0, [0.0, 0.0, 1.0]);
        assert!((blue.hue() - 306.28).abs() < 0.02 && (blue.chroma() - 133.81).abs() < 0.02);
    }

    #[test]
    fn the_flop_index_is_alman_s() {
        assert_eq!(flop_index(50.0, 50.0, 50.0), Some(0.0));
        assert_eq!(flop_index(40.0, 50.0, 50.0), None);
        // 2.69 * 100^1.11 / 50^.86.
        assert!((flop_index(120.0, 50.0, 20.0).unwrap() - 15.44).abs() < 0.02);
    }

    /// A matt surface is the perfect diffuser times its albedo, from everywhere.
    #[test]
    fn a_matt_surface_has_one_color_at_all_angles() {
        let found =
            PaintMeasure::of(&mut Bench::new(1), &painted(0.0, 1e-3), &[], ShadingModel::Standard).unwrap();
        for color in &found.colors {
            assert!(color.reflectance.iter().all(|r| (r - 0.1).abs() < 0.002), "{color:?}");
        }
        assert!(found.flop_index().unwrap() < 0.05 && found.graininess < 1e-3, "{found:?}");
        assert!(found.sparkle.iter().all(|s| s.area == 0.0));
    }

    /// Metallic paint is bright near the mirror direction, and sparkles more the larger its flakes are.
    #[test]
    fn flakes_flop_and_sparkle_with_their_size() {
        let mut bench = Bench::new(1);
        let mut of = |size: f32| {
            PaintMeasure::of(&mut bench, &painted(0.6, size), &[], ShadingModel::Standard).unwrap()
        };
        let [fine, coarse] = [of(15e-6), of(150e-6)];
        // Colour is that of the mean, whatever the size.
        assert_eq!(fine.colors, coarse.colors);
        assert!(fine.flop_index().unwrap() > 5.0, "{fine:?}");
        assert!(coarse.graininess > 2.0 * fine.graininess && fine.graininess > 0.0, "{coarse:?} {fine:?}");
        // Large flakes are fewer and brighter; more light of all is in sparkles, under each lamp.
        for (coarse, fine) in coarse.sparkle.iter().zip(&fine.sparkle) {
            assert!(coarse.grade() > 1.5 * fine.grade() && fine.grade() > 0.0, "{coarse:?} {fine:?}");
        }
    }
}
