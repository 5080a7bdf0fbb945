//! A coated surface in numbers, as a material of engines and as a stack of layers.

use crate::truth::{Interface, Medium, Stack, StackError};
use overcoat_scene::{Material, Workflow};

/// A coated surface. Numbers have the ranges of [`Material`]; colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// Share of the surface that has a coat, 0 to 1.
    pub coat: f64,
    /// Perceptual roughness of the coat, 0 to 1: its alpha is the square.
    pub coat_roughness: f64,
    /// Index of refraction of the coat, 1 to 3.
    pub coat_ior: f64,
    /// Thickness of the coat in units of length, 0 or more.
    pub thickness: f64,
    /// Extinction of the coat per unit of length, 0 or more.
    pub extinction: [f64; 3],
    /// Perceptual roughness of the base.
    pub base_roughness: f64,
    /// True of a metal.
    pub metal: bool,
    /// F0 of a metal; albedo of the diffuse lobe of any other base.
    pub color: [f64; 3],
    /// Strength of the specular lobe of a base that is no metal, 0 to 1: its F0 is 0.04 times this.
    pub specular: f64,
}

impl Default for Specimen {
    /// A smooth coat of index 1.5 that absorbs nothing, over grey plastic.
    fn default() -> Self {
        Self {
            coat: 1.0,
            coat_roughness: 0.1,
            coat_ior: 1.5,
            thickness: 0.0,
            extinction: [0.0; 3],
            base_roughness: 0.5,
            metal: false,
            color: [0.5; 3],
            specular: 1.0,
        }
    }
}

impl Specimen {
    /// The material that engines are given.
    #[must_use]
    pub fn material(&self) -> Material {
        let [r, g, b] = self.color.map(|c| c as f32);
        let mut material = Material::default().with(|m| {
            m.base_color = [r, g, b, 1.0];
            m.workflow = Workflow::MetallicRoughness {
                metallic: f32::from(u8::from(self.metal)),
                roughness: self.base_roughness as f32,
                texture: None,
            };
            m.specular = self.specular as f32;
            m.coat = self.coat as f32;
            m.coat_roughness = self.coat_roughness as f32;
        });
        let medium = &mut material.lobes.coat;
        medium.ior = self.coat_ior as f32;
        medium.thickness = (self.thickness as f32).into();
        medium.extinction = self.extinction.map(|c| c as f32);
        // OpenPBR has no thickness: the coat's transmittance down and up at normal incidence is its colour.
        medium.color = self
            .extinction
            .map(|c| overcoat_core::math::double::exp(-2.0 * c * self.thickness) as f32)
            .into();
        material
    }

    /// The layers, with the coat or without.
    ///
    /// # Errors
    /// [`StackError`] naming the layer and the number that is out of range.
    pub fn stack(&self, coated: bool) -> Result<Stack, StackError> {
        let mut layers = Stack::builder();
        if coated {
            let coat = Interface::dielectric(self.coat_ior);
            layers = layers.interface(rough(coat, self.coat_roughness, self.coat_ior != 1.0));
            layers = layers.medium(Medium::absorbing(self.extinction.map(|c| c * self.thickness)));
        }
        if self.metal {
            let metal = Interface::schlick_conductor(self.color);
            layers = layers.interface(rough(metal, self.base_roughness, true));
        } else {
            if self.specular > 0.0 {
                let facets = Interface::schlick_dielectric(1.0, [0.04 * self.specular; 3]);
                layers = layers.interface(rough(facets, self.base_roughness, false));
                layers = layers.medium(Medium::absorbing([0.0; 3]));
            }
            layers = layers.interface(Interface::lambertian(self.color));
        }
        layers.build()
    }
}

/// An interface with the alpha of a perceptual roughness, and with all bounces between its facets where it can have them.
fn rough(interface: Interface, roughness: f64, bounces: bool) -> Interface {
    let alpha = roughness * roughness;
    // Smoother ones the referee takes for smooth.
    if alpha < 1e-4 {
        return interface;
    }
    let interface = interface.rough(alpha);
    if bounces { interface.multiple_scattering() } else { interface }
}
