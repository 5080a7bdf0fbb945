//! Light that passes through a surface: KHR_materials_transmission, _volume, _dispersion and _diffuse_transmission.

use super::lobes::{ColorParameter, ScalarParameter, group};
use super::parameters::MAX_FACTOR;

group! {
    /// Light that a dielectric base transmits in place of reflecting it diffusely. The default is none.
    Transmission {
        /// Share of the light that is not reflected that passes straight through, refracted; 0 to 1, the texture's red.
        factor: ScalarParameter = ScalarParameter::default(),
        /// Share of the rest that leaves on the other side in all directions; 0 to 1, the texture's alpha.
        diffuse: ScalarParameter = ScalarParameter { channel: 3, ..ScalarParameter::default() },
        /// Colour of that diffuse light.
        diffuse_color: ColorParameter = ColorParameter::from([1.0; 3]),
        /// Thickness of the volume beneath the surface in units of the mesh, 0 or more, the texture's green. With 0 the surface
        /// is a thin wall, which does not refract.
        thickness: ScalarParameter = ScalarParameter { channel: 1, ..ScalarParameter::default() },
        /// Colour that white light has after [`Transmission::attenuation_distance`] in the volume, 0 to 1.
        attenuation_color: [f32; 3] = [1.0; 3],
        /// In units of the world, more than 0; infinite where nothing is absorbed.
        attenuation_distance: f32 = f32::INFINITY,
        /// Dispersion: 20 over the Abbe number of the volume, 0 or more.
        dispersion: f32 = 0.0,
    }
}

impl Transmission {
    /// True if there is a volume beneath the surface.
    #[must_use]
    pub fn has_volume(&self) -> bool {
        self.thickness.factor > 0.0
    }

    /// Extinction per unit of length in the volume: -ln(attenuation colour) / attenuation distance. Finite: a channel
    /// of 0 counts as the least number.
    #[must_use]
    pub fn extinction(&self) -> [f32; 3] {
        self.attenuation_color.map(|c| {
            let c = if c > f32::MIN_POSITIVE { c } else { f32::MIN_POSITIVE };
            let extinction = -overcoat_core::math::scalar::ln(c) / self.attenuation_distance;
            if extinction < MAX_FACTOR { extinction } else { MAX_FACTOR }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lobes, Material};

    #[test]
    fn extinction_turns_white_into_the_colour_after_the_distance() {
        let glass = Transmission {
            attenuation_color: [0.25, 1.0, 0.0],
            attenuation_distance: 2.0,
            ..Transmission::default()
        };
        let [red, green, blue] = glass.extinction();
        assert!((overcoat_core::math::scalar::exp(-red * 2.0) - 0.25).abs() < 1e-6);
        assert_eq!(green, 0.0);
        assert!(blue > 40.0 && blue.is_finite());
        assert_eq!(Transmission::default().extinction(), [0.0; 3]);
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        let check = |transmission: Transmission| {
            let lobes = Lobes { transmission, ..Lobes::default() };
            Material { lobes, ..Material::default() }.validate(0)
        };
        assert_eq!(check(Transmission::default()), Ok(()));
        for wrong in [0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
            let glass = Transmission { attenuation_distance: wrong, ..Transmission::default() };
            assert!(check(glass).is_err(), "{wrong}");
        }
        for wrong in [-0.1, f32::NAN, f32::INFINITY] {
            let glass = Transmission { dispersion: wrong, ..Transmission::default() };
            assert!(check(glass).is_err(), "{wrong}");
        }
    }
}
