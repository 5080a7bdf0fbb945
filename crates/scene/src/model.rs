//! Which engine's formulas shade a surface, and the switches that those engines have.

use super::Material;

/// A published shading model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShadingModel {
    /// Unity URP 13.0 Complex Lit on desktop platforms.
    UrpDesktop,
    /// Unity URP 13.0 Complex Lit where `SHADER_API_MOBILE` is defined.
    UrpMobile,
    /// Unity URP 17 (Unity 6), which has no such split.
    Urp17,
    /// Unity HDRP Lit 13.0.
    HdrpLit,
    /// Unity HDRP StackLit: the full adding path.
    StackLit,
    /// Filament's standard model (and, where a material has sheen and no metal, still that model) on desktop.
    Filament,
    /// The same where `TARGET_MOBILE` is defined, in low quality.
    FilamentMobile,
    /// Filament's cloth model.
    FilamentCloth,
    /// Filament's clear coat as its documentation printed it in 2018.
    Filament2018,
    /// three.js r187, `MeshPhysicalMaterial`.
    Three,
    /// three.js r131 or, by [`super::ThreeOptions::r119`], r119.
    ThreeLegacy,
    /// The Khronos glTF Sample Renderer.
    Gltf,
    /// The same BRDF with sixteen filtered lookups a lobe in place of one: the nearest to the integral that the appendix of
    /// glTF describes, with all bounces between microfacets.
    GltfSampled,
    /// OpenPBR 1.1: coat over a metallic or glossy-diffuse base.
    OpenPbr,
    /// Velvet (Ashikhmin and Premoze 2007) over Lambert.
    Velvet,
    /// Babylon.js 9.35, `PBRMaterial`.
    Babylon,
    /// The model of the house, of the parts that come nearest to a path tracer: for materials that name no model.
    #[default]
    Standard,
    /// StackLit repaired: the adding method with a diffuse term of its own, measured on a random walk through the layers.
    StackLitD,
}

/// Features of a material that only some models support.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    Sheen,
    Anisotropy,
    Iridescence,
    Coat,
    CoatNormal,
    CoatAbsorption,
    CoatColor,
    CoatIor,
    CoatDarkening,
    CoatAnisotropy,
    SecondLobe,
    Subsurface,
    ReflectionOcclusion,
}

use Feature as F;

impl Feature {
    /// In the order of warnings.
    const ALL: [Self; 13] = [
        F::Sheen,
        F::Anisotropy,
        F::Iridescence,
        F::Coat,
        F::CoatNormal,
        F::CoatAbsorption,
        F::CoatColor,
        F::CoatIor,
        F::CoatDarkening,
        F::CoatAnisotropy,
        F::SecondLobe,
        F::Subsurface,
        F::ReflectionOcclusion,
    ];

    /// Its name in warnings.
    fn name(self) -> &'static str {
        match self {
            F::Sheen => "sheen",
            F::Anisotropy => "anisotropy",
            F::Iridescence => "iridescence",
            F::Coat => "clear coat",
            F::CoatNormal => "coat normals",
            F::CoatAbsorption => "coat absorption",
            F::CoatColor => "coat colour",
            F::CoatIor => "coat index of refraction",
            F::CoatDarkening => "coat darkening",
            F::CoatAnisotropy => "coat anisotropy",
            F::SecondLobe => "second lobe",
            F::Subsurface => "subsurface",
            F::ReflectionOcclusion => "occlusion of reflections of its own",
        }
    }

    /// True if a material uses the feature.
    fn is_in(self, material: &Material) -> bool {
        let lobes = &material.lobes;
        let (coated, medium) = (material.coat > 0.0, &lobes.coat);
        match self {
            F::Sheen => lobes.sheen.color.factor != [0.0; 3],
            F::Anisotropy => lobes.anisotropy.strength != 0.0,
            F::Iridescence => lobes.iridescence.mask.factor > 0.0,
            F::Coat => coated,
            F::CoatNormal => {
                let own = material.coat_normal_texture != material.normal_texture;
                let scratched = material.has_scratches() || material.has_swirl();
                (coated && own) || material.has_orange_peel() || scratched
            }
            F::CoatAbsorption => coated && medium.thickness.factor > 0.0 && medium.extinction != [0.0; 3],
            F::CoatColor => coated && medium.color.factor != [1.0; 3],
            F::CoatIor => coated && medium.ior != 1.5,
            // 0 is the behaviour of models without the feature.
            F::CoatDarkening => coated && medium.darkening != 1.0 && medium.darkening != 0.0,
            F::CoatAnisotropy => coated && medium.anisotropy != 0.0,
            F::SecondLobe => lobes.second.mix.factor > 0.0 || lobes.second.haziness.factor > 0.0,
            F::Subsurface => lobes.subsurface.mask.factor > 0.0 || lobes.subsurface.transmission != [0.0; 3],
            F::ReflectionOcclusion => {
                lobes.occlusion.specular != 1.0.into() || lobes.occlusion.bent_normal.is_some()
            }
        }
    }
}

/// Entry of the table of models: all but the formulas.
struct Entry {
    model: ShadingModel,
    /// As `--shading` and material files take it.
    name: &'static str,
    /// Engine or version of the model, shown in brackets behind the name.
    version: &'static str,
    /// Features it supports beside base and emission.
    knows: &'static [Feature],
}

const fn entry(
    model: ShadingModel,
    name: &'static str,
    version: &'static str,
    knows: &'static [Feature],
) -> Entry {
    Entry { model, name, version, knows }
}

/// The models, in the order of [`ShadingModel`]. Their formulas are registered with the renderer in `shade::models`.
const TABLE: &[Entry] = {
    use ShadingModel as M;
    const URP: &[Feature] = &[F::Coat, F::CoatNormal];
    const FILAMENT: &[Feature] = &[F::Coat, F::CoatNormal, F::Sheen, F::Anisotropy];
    const KHRONOS: &[Feature] = &[F::Coat, F::CoatNormal, F::Sheen, F::Anisotropy, F::Iridescence];
    const HOUSE: &[Feature] =
        &[F::Coat, F::CoatNormal, F::CoatColor, F::CoatDarkening, F::Sheen, F::Anisotropy, F::Iridescence];
    const STACKLIT: &[Feature] = &[
        F::Anisotropy,
        F::Iridescence,
        F::Coat,
        F::CoatNormal,
        F::CoatAbsorption,
        F::CoatIor,
        F::SecondLobe,
        F::Subsurface,
        F::ReflectionOcclusion,
    ];
    &[
        entry(M::UrpDesktop, "urp-desktop", "Unity URP 13, desktop", URP),
        entry(M::UrpMobile, "urp-mobile", "Unity URP 13, mobile", URP),
        entry(M::Urp17, "urp17", "Unity 6", URP),
        entry(M::HdrpLit, "hdrp-lit", "Unity HDRP", &[F::Coat, F::Anisotropy, F::Iridescence]),
        entry(M::StackLit, "stacklit", "Unity HDRP", STACKLIT),
        entry(M::Filament, "filament", "desktop", FILAMENT),
        entry(M::FilamentMobile, "filament-mobile", "mobile", FILAMENT),
        entry(M::FilamentCloth, "filament-cloth", "cloth", &[F::Sheen, F::Subsurface]),
        entry(M::Filament2018, "filament-2018", "its document of 2018", &[F::Coat]),
        entry(M::Three, "three", "three.js r187", KHRONOS),
        entry(M::ThreeLegacy, "three-legacy", "three.js r131", &[F::Coat, F::CoatNormal, F::Sheen]),
        entry(M::Gltf, "gltf", "Khronos", KHRONOS),
        entry(M::GltfSampled, "gltf-sampled", "the same by sixteen lookups a lobe", KHRONOS),
        entry(
            M::OpenPbr,
            "openpbr",
            "1.1",
            &[
                F::Coat,
                F::CoatNormal,
                F::CoatColor,
                F::CoatIor,
                F::CoatDarkening,
                F::CoatAnisotropy,
                F::Anisotropy,
            ],
        ),
        entry(M::Velvet, "velvet", "over Lambert", &[F::Sheen, F::Anisotropy]),
        entry(
            M::Babylon,
            "babylon",
            "Babylon.js 9.35",
            &[F::Coat, F::CoatNormal, F::CoatAbsorption, F::CoatColor, F::CoatIor, F::Anisotropy],
        ),
        entry(M::Standard, "standard", "what comes nearest to a path tracer", HOUSE),
        entry(
            M::StackLitD,
            "stacklit-d",
            "StackLit repaired",
            &[F::Coat, F::CoatNormal, F::CoatAbsorption, F::CoatIor, F::CoatAnisotropy, F::Anisotropy],
        ),
    ]
};

impl ShadingModel {
    /// All of them.
    pub const ALL: &[Self] = &{
        let mut all = [Self::UrpDesktop; TABLE.len()];
        let mut k = 0;
        while k < all.len() {
            assert!(TABLE[k].model as usize == k, "the table is in the order of the models");
            all[k] = TABLE[k].model;
            k += 1;
        }
        all
    };

    /// True if its formulas are compiled in: with the feature `engines`, which is a default one, all, else those of this project,
    /// [`ShadingModel::Standard`] among them. A picture by another is an error.
    #[must_use]
    pub const fn is_built(self) -> bool {
        cfg!(feature = "engines") || matches!(self, Self::StackLitD | Self::Standard)
    }

    fn entry(self) -> &'static Entry {
        &TABLE[self as usize]
    }

    /// Name as `--shading` and material files take it.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// Engine or version of the model, in a few words that follow the name.
    #[must_use]
    pub fn version(self) -> &'static str {
        self.entry().version
    }

    /// True if the model supports the feature.
    pub fn knows(self, feature: Feature) -> bool {
        self.entry().knows.contains(&feature)
    }

    /// True if the model reads more of a material than base, coat and emission.
    #[must_use]
    pub fn reads_lobes(self) -> bool {
        self.entry().knows.iter().any(|feature| !matches!(feature, F::Coat | F::CoatNormal))
    }

    /// The model of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        TABLE.iter().find(|entry| entry.name == name).map(|entry| entry.model)
    }

    /// Names of the features that a material uses and this model does not support, for a warning.
    pub fn leaves_out(self, material: &Material) -> impl Iterator<Item = &'static str> {
        let knows = self.entry().knows;
        let coat = knows.contains(&F::Coat);
        // Where the coat itself is missing, its normals are not missed.
        let missed = move |feature: &Feature| !knows.contains(feature) && (coat || *feature != F::CoatNormal);
        let in_material = |feature: &Feature| feature.is_in(material);
        Feature::ALL.into_iter().filter(missed).filter(in_material).map(Feature::name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lobes, Sheen};

    #[test]
    fn what_a_model_does_not_know_is_named() {
        let names = |model: ShadingModel, material: &Material| model.leaves_out(material).collect::<Vec<_>>();
        let plain = Material { coat: 1.0, ..Material::default() };
        let sheen = Sheen { color: [0.5; 3].into(), roughness: 0.3.into() };
        let mut rich = Material { lobes: Lobes { sheen, ..Lobes::default() }, ..plain.clone() };
        rich.lobes.anisotropy.strength = 0.5;
        rich.lobes.iridescence.mask = 1.0.into();
        rich.lobes.coat.thickness = 1.0.into();
        for &model in ShadingModel::ALL {
            let uncoated = matches!(model, ShadingModel::FilamentCloth | ShadingModel::Velvet);
            assert_eq!(names(model, &plain), if uncoated { vec!["clear coat"] } else { Vec::new() });
            assert!(names(model, &Material::default()).is_empty());
        }
        let all = ["sheen", "anisotropy", "iridescence", "coat absorption"];
        assert_eq!(names(ShadingModel::Urp17, &rich), all);
        assert_eq!(names(ShadingModel::Gltf, &rich), ["coat absorption"]);
        assert_eq!(names(ShadingModel::StackLit, &rich), ["sheen"]);
        assert_eq!(names(ShadingModel::HdrpLit, &rich), ["sheen", "coat absorption"]);
    }
}
