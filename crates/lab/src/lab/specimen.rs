//! A coated surface in numbers, as a material of engines and as a stack of layers.

use super::Base;
use crate::truth::{Interface, Medium, Stack, StackError, mean_reflectance};
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
    /// Layers below the coat where they are no metal.
    pub base: Base,
    /// Index of refraction of the base with an interface ([`Base::has_index`]), 1 to 3. Where it is that of the coat, nothing lies between the two.
    pub base_ior: f64,
    /// F0 of a metal; albedo of any other base, as its [`Base`] reads it.
    pub color: [f64; 3],
    /// Factor on the F0 of a base that is no metal, 0 to 1. Of an interface the relative index is the one that has this F0, as with
    /// OpenPBR's `specular_weight`. With 0 every base is [`Base::Lambert`].
    pub specular: f64,
}

impl Default for Specimen {
    /// A smooth coat of index 1.5 that absorbs nothing, over grey plastic of the same index.
    fn default() -> Self {
        Self {
            coat: 1.0,
            coat_roughness: 0.1,
            coat_ior: 1.5,
            thickness: 0.0,
            extinction: [0.0; 3],
            base_roughness: 0.5,
            metal: false,
            base: Base::default(),
            base_ior: 1.5,
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
            m.specular = if self.metal || self.base != Base::Lambert { self.specular as f32 } else { 0.0 };
            if !self.metal && self.base.has_index() {
                m.ior = self.base_ior as f32;
            }
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
        self.stack_of(coated, true)
    }

    /// The layers with one bounce between the facets of each interface, as GGX is in most renderers: light that would meet a second
    /// facet is lost.
    ///
    /// # Errors
    /// As of [`Specimen::stack`].
    pub fn stack_of_one_bounce(&self, coated: bool) -> Result<Stack, StackError> {
        self.stack_of(coated, false)
    }

    /// True if some interface of the coated surface has further bounces between its facets, so that the two stacks differ.
    #[must_use]
    pub fn has_further_bounces(&self) -> bool {
        let is_rough = |roughness: f64| roughness * roughness >= LEAST_ALPHA;
        let facets = self.metal || self.index_below(self.coat_ior).is_some();
        is_rough(self.coat_roughness) && self.coat_ior != 1.0 || facets && is_rough(self.base_roughness)
    }

    fn stack_of(&self, coated: bool, bounces: bool) -> Result<Stack, StackError> {
        let mut layers = Stack::builder();
        if coated {
            let coat = Interface::dielectric(self.coat_ior);
            layers = layers.interface(rough(coat, self.coat_roughness, bounces && self.coat_ior != 1.0));
            layers = layers.medium(Medium::absorbing(self.extinction.map(|c| c * self.thickness)));
        }
        if self.metal {
            let metal = Interface::schlick_conductor(self.color);
            layers = layers.interface(rough(metal, self.base_roughness, bounces));
        } else {
            if let Some(facets) = self.facets(if coated { self.coat_ior } else { 1.0 }, bounces) {
                layers = layers.interface(facets).medium(Medium::absorbing([0.0; 3]));
            }
            layers = layers.interface(Interface::lambertian(self.substrate()));
        }
        layers.build()
    }

    /// Albedo of the Lambertian surface of a base that is no metal.
    #[must_use]
    pub fn substrate(&self) -> [f64; 3] {
        match self.base {
            Base::Seen => self.color.map(|c| albedo_below(c, self.relative_index(1.0))),
            _ => self.color,
        }
    }

    /// Index of a base that has one relative to that of what lies above it, after the specular factor; `None` where there is no interface
    /// between the two.
    #[must_use]
    pub fn index_below(&self, above: f64) -> Option<f64> {
        let index = self.relative_index(above);
        // NaN is left to the stack, which names it.
        let nothing = (index - 1.0).abs() < LEAST_STEP;
        (!self.metal && self.base.has_index() && !nothing).then_some(index)
    }

    /// The index whose F0 is that of the base's times the specular factor.
    fn relative_index(&self, above: f64) -> f64 {
        let root = self.specular.sqrt() * (self.base_ior - above) / (self.base_ior + above);
        (1.0 + root) / (1.0 - root)
    }

    /// Interface of a base that is no metal below something of that index.
    fn facets(&self, above: f64, bounces: bool) -> Option<Interface> {
        if self.base == Base::Convention {
            let facets = Interface::schlick_dielectric(1.0, [0.04 * self.specular; 3]);
            return (self.specular > 0.0).then(|| rough(facets, self.base_roughness, false));
        }
        self.index_below(above).map(|index| rough(Interface::dielectric(index), self.base_roughness, bounces))
    }
}

/// Alphas below which the referee takes an interface for smooth.
const LEAST_ALPHA: f64 = 1e-4;

/// Steps of the index below which there is no interface: it would reflect less than 3e-9.
const LEAST_STEP: f64 = 1e-4;

/// Albedo of a Lambertian surface below a smooth interface of that index, for which white light shows the share `seen` of what
/// the interface lets in. Of even light inside the share e escapes, and the sum over all bounces is `d e / (1 - d (1 - e))`.
fn albedo_below(seen: f64, index: f64) -> f64 {
    let escapes = (1.0 - mean_reflectance(index)) / (index * index);
    seen / (1.0 - (1.0 - seen) * (1.0 - escapes))
}

/// An interface with the alpha of a perceptual roughness, and with all bounces between its facets where it can have them.
fn rough(interface: Interface, roughness: f64, bounces: bool) -> Interface {
    let alpha = roughness * roughness;
    if alpha < LEAST_ALPHA {
        return interface;
    }
    let interface = interface.rough(alpha);
    if bounces { interface.multiple_scattering() } else { interface }
}
