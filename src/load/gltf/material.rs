//! Materials of the file as materials of the scene.

use super::model::{self, Root, TextureInfo};
use super::texture::Textures;
use super::uv_sets::UvSets;
use crate::load::LoadError;
use crate::load::warnings::Warnings;
use crate::scene::{
    AlphaMode, AlphaUse, Anisotropy, ColorParameter, ColorSpace, Iridescence, Lobes, Material, NormalTexture,
    ScalarParameter, Sheen, TextureId, TextureRef, Transmission, Workflow,
};

/// Largest emissive or specular colour of a scene.
const MAX_FACTOR: f32 = 1e6;

/// What primitives without a material are made of: section 3.9.2 of the specification with its default factors,
/// which is a rough white metal.
pub(super) fn default_material() -> Material {
    Material {
        workflow: Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture: None },
        ..Material::default()
    }
}

/// The scene's material for material `index` of the file, with provisional texture ids, and the sets of texture coordinates
/// of the file that it reads as sets 0 and 1. Factors outside their range
/// are clamped with a warning.
///
/// # Errors
/// [`LoadError::Malformed`] if there is no such material.
pub(super) fn convert(
    root: &Root,
    index: usize,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<(Material, [u32; 2]), LoadError> {
    let given = root.materials.at(index)?;
    let mut converter = Converter { root, index, textures, uv_sets: UvSets::default(), warnings };
    Ok((converter.convert(given), converter.uv_sets.numbers()))
}

/// Replaces provisional texture ids by those of the scene; uses of textures that could not be read are removed.
pub(super) fn settle_textures(material: &mut Material, ids: &[Option<TextureId>]) {
    let settle = |slot: &mut Option<TextureRef>| {
        *slot = slot.and_then(|r| {
            ids.get(r.texture.index()).copied().flatten().map(|texture| TextureRef { texture, ..r })
        });
    };
    let settle_normal = |slot: &mut Option<NormalTexture>| {
        *slot = slot.and_then(|n| {
            let mut texture = Some(n.texture);
            settle(&mut texture);
            texture.map(|texture| NormalTexture { texture, ..n })
        });
    };
    match &mut material.workflow {
        Workflow::MetallicRoughness { texture, .. } | Workflow::SpecularGlossiness { texture, .. } => {
            settle(texture);
        }
    }
    settle(&mut material.base_color_texture);
    settle(&mut material.specular_texture);
    settle(&mut material.specular_color_texture);
    settle(&mut material.occlusion_texture);
    let glowed = material.emissive_texture.is_some();
    settle(&mut material.emissive_texture);
    if glowed && material.emissive_texture.is_none() {
        // The factor alone would make all of it glow.
        material.emissive = [0.0; 3];
    }
    settle(&mut material.coat_texture);
    settle(&mut material.coat_roughness_texture);
    material.lobes.texture_slots_mut().into_iter().for_each(settle);
    settle_normal(&mut material.normal_texture);
    settle_normal(&mut material.coat_normal_texture);
}

struct Converter<'a> {
    root: &'a Root,
    index: usize,
    textures: &'a mut Textures,
    uv_sets: UvSets,
    warnings: &'a mut Warnings,
}

impl Converter<'_> {
    fn convert(&mut self, given: &model::Material) -> Material {
        let mut material = default_material();
        material.name = given.name.as_deref().unwrap_or("").chars().take(256).collect();
        material.double_sided = given.double_sided;
        let mode = given.alpha_mode.as_deref();
        let upper = mode.map(str::to_ascii_uppercase);
        if mode != upper.as_deref() {
            let name = self.name();
            self.warnings.add(|| format!("{name}: alphaMode is not in capitals"));
        }
        material.alpha_mode = match upper.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask {
                cutoff: self.clamped("alphaCutoff", given.alpha_cutoff.unwrap_or(0.5), 0.0, MAX_FACTOR),
            },
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => {
                let name = self.name();
                self.warnings.add(|| format!("{name}: unknown alphaMode, drawn opaque"));
                AlphaMode::Opaque
            }
        };
        // Where a material is given in both workflows, that of the extension is preferred and the other is the
        // substitute, whose textures are not read.
        let extensions = given.extensions.as_deref();
        match extensions.and_then(|e| e.specular_glossiness.as_ref()) {
            Some(base) => self.specular_glossiness(base, &mut material),
            None => self.metallic_roughness(given.pbr_metallic_roughness.as_deref(), &mut material),
        }
        self.surface(given, &mut material);
        if let Some(extensions) = extensions {
            self.extensions(extensions, &mut material);
        }
        material
    }

    /// pbrMetallicRoughness.
    fn metallic_roughness(&mut self, given: Option<&model::MetallicRoughness>, material: &mut Material) {
        let Some(base) = given else { return };
        if let Some(factor) = base.base_color_factor {
            material.base_color = self.clamped_all("baseColorFactor", factor, 1.0);
        }
        let alpha = alpha_use(material);
        material.base_color_texture =
            self.texture("baseColorTexture", base.base_color_texture.as_ref(), ColorSpace::Srgb, alpha);
        material.workflow = Workflow::MetallicRoughness {
            metallic: self.unit("metallicFactor", base.metallic_factor, 1.0),
            roughness: self.unit("roughnessFactor", base.roughness_factor, 1.0),
            texture: self.data("metallicRoughnessTexture", base.metallic_roughness_texture.as_ref()),
        };
    }

    /// KHR_materials_pbrSpecularGlossiness.
    fn specular_glossiness(&mut self, base: &model::SpecularGlossiness, material: &mut Material) {
        material.base_color = self.clamped_all("diffuseFactor", base.diffuse_factor.unwrap_or([1.0; 4]), 1.0);
        let alpha = alpha_use(material);
        material.base_color_texture =
            self.texture("diffuseTexture", base.diffuse_texture.as_ref(), ColorSpace::Srgb, alpha);
        let texture = base.specular_glossiness_texture.as_ref();
        material.workflow = Workflow::SpecularGlossiness {
            specular: self.clamped_all("specularFactor", base.specular_factor.unwrap_or([1.0; 3]), 1.0),
            glossiness: self.unit("glossinessFactor", base.glossiness_factor, 1.0),
            texture: self.texture("specularGlossinessTexture", texture, ColorSpace::Srgb, AlphaUse::Data),
        };
    }

    /// What every material has beside its base.
    fn surface(&mut self, given: &model::Material, material: &mut Material) {
        material.normal_texture = self.normal("normalTexture", given.normal_texture.as_deref());
        material.occlusion_texture = self.data("occlusionTexture", given.occlusion_texture.as_deref());
        let strength = given.occlusion_texture.as_ref().and_then(|info| info.strength);
        material.occlusion_strength = self.unit("occlusionTexture.strength", strength, 1.0);
        if let Some(factor) = given.emissive_factor.as_deref() {
            material.emissive = self.clamped_all("emissiveFactor", *factor, 1.0);
        }
        material.emissive_texture = self.texture(
            "emissiveTexture",
            given.emissive_texture.as_deref(),
            ColorSpace::Srgb,
            AlphaUse::Data,
        );
    }

    fn extensions(&mut self, given: &model::MaterialExtensions, material: &mut Material) {
        material.unlit = given.unlit.is_some();
        if let Some(strength) = given.emissive_strength.as_ref().and_then(|e| e.emissive_strength) {
            let strength = self.clamped("emissiveStrength", strength, 0.0, MAX_FACTOR);
            material.emissive = material.emissive.map(|e| e * strength);
        }
        if let Some(ior) = given.ior.as_ref().and_then(|e| e.ior) {
            // 0 stands for a reflectance of 1.
            material.ior = if ior == 0.0 { 0.0 } else { self.clamped("ior", ior, 1.0, 1000.0) };
        }
        if let Some(specular) = &given.specular {
            material.specular = self.unit("specularFactor", specular.specular_factor, 1.0);
            material.specular_texture = self.data("specularTexture", specular.specular_texture.as_ref());
            if let Some(factor) = specular.specular_color_factor {
                material.specular_color = self.clamped_all("specularColorFactor", factor, MAX_FACTOR);
            }
            let texture = specular.specular_color_texture.as_ref();
            material.specular_color_texture =
                self.texture("specularColorTexture", texture, ColorSpace::Srgb, AlphaUse::Data);
        }
        if let Some(coat) = &given.clearcoat {
            material.coat = self.unit("clearcoatFactor", coat.clearcoat_factor, 0.0);
            material.coat_texture = self.data("clearcoatTexture", coat.clearcoat_texture.as_ref());
            material.coat_roughness =
                self.unit("clearcoatRoughnessFactor", coat.clearcoat_roughness_factor, 0.0);
            material.coat_roughness_texture =
                self.data("clearcoatRoughnessTexture", coat.clearcoat_roughness_texture.as_ref());
            material.coat_normal_texture =
                self.normal("clearcoatNormalTexture", coat.clearcoat_normal_texture.as_ref());
        }
        self.lobes(given, &mut material.lobes);
        self.transmission(given, &mut material.lobes.transmission);
    }

    /// KHR_materials_sheen, KHR_materials_anisotropy and KHR_materials_iridescence.
    fn lobes(&mut self, given: &model::MaterialExtensions, lobes: &mut Lobes) {
        if let Some(sheen) = &given.sheen {
            let color = sheen.sheen_color_factor.unwrap_or([0.0; 3]);
            let texture = sheen.sheen_color_texture.as_ref();
            lobes.sheen = Sheen {
                color: ColorParameter {
                    factor: self.clamped_all("sheenColorFactor", color, 1.0),
                    texture: self.texture("sheenColorTexture", texture, ColorSpace::Srgb, AlphaUse::Data),
                },
                roughness: ScalarParameter {
                    factor: self.unit("sheenRoughnessFactor", sheen.sheen_roughness_factor, 0.0),
                    texture: self.data("sheenRoughnessTexture", sheen.sheen_roughness_texture.as_ref()),
                    channel: 3,
                },
            };
        }
        if let Some(anisotropy) = &given.anisotropy {
            lobes.anisotropy = Anisotropy {
                strength: self.unit("anisotropyStrength", anisotropy.anisotropy_strength, 0.0),
                rotation: self.clamped(
                    "anisotropyRotation",
                    anisotropy.anisotropy_rotation.unwrap_or(0.0),
                    -1e4,
                    1e4,
                ),
                texture: self.data("anisotropyTexture", anisotropy.anisotropy_texture.as_ref()),
            };
        }
        if let Some(film) = &given.iridescence {
            let thickness = [
                film.iridescence_thickness_minimum.unwrap_or(100.0),
                film.iridescence_thickness_maximum.unwrap_or(400.0),
            ];
            lobes.iridescence = Iridescence {
                mask: ScalarParameter {
                    factor: self.unit("iridescenceFactor", film.iridescence_factor, 0.0),
                    texture: self.data("iridescenceTexture", film.iridescence_texture.as_ref()),
                    channel: 0,
                },
                ior: self.clamped("iridescenceIor", film.iridescence_ior.unwrap_or(1.3), 1.0, 5.0),
                thickness: thickness.map(|nm| self.clamped("iridescenceThickness", nm, 0.0, 1e5)),
                thickness_texture: self
                    .data("iridescenceThicknessTexture", film.iridescence_thickness_texture.as_ref()),
                ..Iridescence::default()
            };
        }
    }

    /// KHR_materials_transmission, _diffuse_transmission, _volume and _dispersion.
    fn transmission(&mut self, given: &model::MaterialExtensions, transmission: &mut Transmission) {
        if let Some(straight) = &given.transmission {
            transmission.factor = ScalarParameter {
                factor: self.unit("transmissionFactor", straight.transmission_factor, 0.0),
                texture: self.data("transmissionTexture", straight.transmission_texture.as_ref()),
                channel: 0,
            };
        }
        if let Some(diffuse) = &given.diffuse_transmission {
            transmission.diffuse = ScalarParameter {
                factor: self.unit("diffuseTransmissionFactor", diffuse.diffuse_transmission_factor, 0.0),
                texture: self
                    .data("diffuseTransmissionTexture", diffuse.diffuse_transmission_texture.as_ref()),
                channel: 3,
            };
            let color = diffuse.diffuse_transmission_color_factor.unwrap_or([1.0; 3]);
            let texture = diffuse.diffuse_transmission_color_texture.as_ref();
            transmission.diffuse_color = ColorParameter {
                factor: self.clamped_all("diffuseTransmissionColorFactor", color, 1.0),
                texture: self.texture(
                    "diffuseTransmissionColorTexture",
                    texture,
                    ColorSpace::Srgb,
                    AlphaUse::Data,
                ),
            };
        }
        if let Some(volume) = &given.volume {
            let thickness = volume.thickness_factor.unwrap_or(0.0);
            transmission.thickness = ScalarParameter {
                factor: self.clamped("thicknessFactor", thickness, 0.0, MAX_FACTOR),
                texture: self.data("thicknessTexture", volume.thickness_texture.as_ref()),
                channel: 1,
            };
            if let Some(color) = volume.attenuation_color {
                transmission.attenuation_color = self.clamped_all("attenuationColor", color, 1.0);
            }
            if let Some(distance) = volume.attenuation_distance {
                let least = f32::MIN_POSITIVE;
                transmission.attenuation_distance =
                    self.clamped("attenuationDistance", distance, least, f32::INFINITY);
            }
        }
        if let Some(dispersion) = given.dispersion.as_ref().and_then(|d| d.dispersion) {
            transmission.dispersion = self.clamped("dispersion", dispersion, 0.0, 1e3);
        }
    }

    fn name(&self) -> String {
        self.root.materials.label(self.index)
    }

    fn clamped(&mut self, what: &str, value: f32, low: f32, high: f32) -> f32 {
        let kept = value.clamp(low, high);
        if kept != value {
            let name = self.name();
            self.warnings.add(|| format!("{name}: {what} {value} is out of range, {kept} is used"));
        }
        kept
    }

    fn clamped_all<const N: usize>(&mut self, what: &str, values: [f32; N], high: f32) -> [f32; N] {
        values.map(|v| self.clamped(what, v, 0.0, high))
    }

    /// A factor from 0 to 1.
    fn unit(&mut self, what: &str, value: Option<f32>, default: f32) -> f32 {
        self.clamped(what, value.unwrap_or(default), 0.0, 1.0)
    }

    fn texture(
        &mut self,
        what: &str,
        info: Option<&TextureInfo>,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Option<TextureRef> {
        let name = self.name();
        let name = || format!("{name}: {what}");
        self.textures.refer(self.root, info?, color_space, alpha, &mut self.uv_sets, self.warnings, &name)
    }

    /// A texture of numbers.
    fn data(&mut self, what: &str, info: Option<&TextureInfo>) -> Option<TextureRef> {
        self.texture(what, info, ColorSpace::Linear, AlphaUse::Data)
    }

    fn normal(&mut self, what: &str, info: Option<&TextureInfo>) -> Option<NormalTexture> {
        let texture = self.data(what, info)?;
        let scale = info.and_then(|info| info.scale).unwrap_or(1.0);
        Some(NormalTexture { texture, scale: self.clamped("scale of the normal map", scale, -1e4, 1e4) })
    }
}

/// What the alpha of a material's base colour texture means.
fn alpha_use(material: &Material) -> AlphaUse {
    match material.alpha_mode {
        AlphaMode::Opaque => AlphaUse::Data,
        // The cutoff is compared with the product of texture and factor.
        AlphaMode::Mask { cutoff } if material.base_color[3] > 0.0 => {
            AlphaUse::mask(cutoff / material.base_color[3])
        }
        AlphaMode::Mask { .. } | AlphaMode::Blend => AlphaUse::Coverage,
    }
}
