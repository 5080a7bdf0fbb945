//! Materials, lights and cameras as an animation has changed them.

use super::model::{self, TextureInfo};
use super::pointer::{Camera, Light, Slot, Surface};
use super::texture::transform_of;
use crate::scene::{AlphaMode, Material, NormalTexture, TextureRef, Workflow};

/// Largest emissive or specular colour of a scene.
const MAX_FACTOR: f64 = 1e6;

/// Changes a material of the scene that was made of `given`. Numbers beyond their range are clamped to it.
pub(super) fn change(material: &mut Material, given: &model::Material, changes: &[(Surface, Vec<f64>)]) {
    let strength = given.extensions.as_deref().and_then(|e| e.emissive_strength.as_ref());
    let mut strength = strength.and_then(|e| e.emissive_strength).map_or(1.0, f64::from);
    let mut emissive = given.emissive_factor.as_deref().map_or([0.0; 3], |e| e.map(f64::from));
    let mut glows = false;
    for (surface, values) in changes {
        let first = values.first().copied().unwrap_or(0.0);
        let unit = first.clamp(0.0, 1.0) as f32;
        match surface {
            Surface::Emissive => (emissive, glows) = (three(values), true),
            Surface::EmissiveStrength => (strength, glows) = (first, true),
            // Each workflow has its own; that of the other is the substitute that is not drawn.
            Surface::BaseColor | Surface::Diffuse
                if (*surface == Surface::Diffuse) != is_glossy(material) => {}
            Surface::BaseColor | Surface::Diffuse => {
                material.base_color =
                    std::array::from_fn(|k| values.get(k).copied().unwrap_or(1.0).clamp(0.0, 1.0) as f32);
            }
            Surface::Metallic => {
                if let Workflow::MetallicRoughness { metallic, .. } = &mut material.workflow {
                    *metallic = unit;
                }
            }
            Surface::Roughness => {
                if let Workflow::MetallicRoughness { roughness, .. } = &mut material.workflow {
                    *roughness = unit;
                }
            }
            Surface::SpecularGlossinessColor => {
                if let Workflow::SpecularGlossiness { specular, .. } = &mut material.workflow {
                    *specular = three(values).map(|v| v.clamp(0.0, 1.0) as f32);
                }
            }
            Surface::Glossiness => {
                if let Workflow::SpecularGlossiness { glossiness, .. } = &mut material.workflow {
                    *glossiness = unit;
                }
            }
            Surface::NormalScale => scale_normal(&mut material.normal_texture, first),
            Surface::CoatNormalScale => scale_normal(&mut material.coat_normal_texture, first),
            Surface::OcclusionStrength => material.occlusion_strength = unit,
            Surface::AlphaCutoff => {
                if let AlphaMode::Mask { cutoff } = &mut material.alpha_mode {
                    *cutoff = first.clamp(0.0, MAX_FACTOR) as f32;
                }
            }
            Surface::Ior => {
                material.ior = if first == 0.0 { 0.0 } else { first.clamp(1.0, 1000.0) as f32 };
            }
            Surface::Specular => material.specular = unit,
            Surface::SpecularColor => {
                material.specular_color = three(values).map(|v| v.clamp(0.0, MAX_FACTOR) as f32);
            }
            Surface::Coat => material.coat = unit,
            Surface::CoatRoughness => material.coat_roughness = unit,
            Surface::SheenColor => {
                material.lobes.sheen.color.factor = three(values).map(|v| v.clamp(0.0, 1.0) as f32);
            }
            Surface::SheenRoughness => material.lobes.sheen.roughness.factor = unit,
            Surface::AnisotropyStrength => material.lobes.anisotropy.strength = unit,
            Surface::AnisotropyRotation => {
                material.lobes.anisotropy.rotation = first.clamp(-1e4, 1e4) as f32;
            }
            Surface::Iridescence => material.lobes.iridescence.mask.factor = unit,
            Surface::IridescenceIor => material.lobes.iridescence.ior = first.clamp(1.0, 5.0) as f32,
            Surface::FilmMinimum => {
                material.lobes.iridescence.thickness[0] = first.clamp(0.0, 1e5) as f32;
            }
            Surface::FilmMaximum => {
                material.lobes.iridescence.thickness[1] = first.clamp(0.0, 1e5) as f32;
            }
            Surface::Transmission => material.lobes.transmission.factor.factor = unit,
            Surface::DiffuseTransmission => material.lobes.transmission.diffuse.factor = unit,
            Surface::DiffuseTransmissionColor => {
                material.lobes.transmission.diffuse_color.factor =
                    three(values).map(|v| v.clamp(0.0, 1.0) as f32);
            }
            Surface::Thickness => {
                material.lobes.transmission.thickness.factor = first.clamp(0.0, MAX_FACTOR) as f32
            }
            Surface::AttenuationDistance => {
                material.lobes.transmission.attenuation_distance =
                    (first as f32).clamp(f32::MIN_POSITIVE, f32::INFINITY);
            }
            Surface::AttenuationColor => {
                material.lobes.transmission.attenuation_color =
                    three(values).map(|v| v.clamp(0.0, 1.0) as f32);
            }
            Surface::Dispersion => material.lobes.transmission.dispersion = first.clamp(0.0, 1e3) as f32,
            // Below, since the three of a texture belong together.
            Surface::Offset(_) | Surface::Turn(_) | Surface::Scale(_) => {}
        }
    }
    if glows {
        let strength = strength.clamp(0.0, MAX_FACTOR);
        material.emissive = emissive.map(|e| (e.clamp(0.0, 1.0) * strength) as f32);
    }
    for (place, (surface, _)) in changes.iter().enumerate() {
        if let Surface::Offset(slot) | Surface::Turn(slot) | Surface::Scale(slot) = surface {
            let same = |s: &Surface| matches!(s, Surface::Offset(o) | Surface::Turn(o) | Surface::Scale(o) if o == slot);
            // Once for each texture.
            if !changes.iter().take(place).any(|(s, _)| same(s)) {
                place_texture(material, given, *slot, changes);
            }
        }
    }
}

/// Gives a texture the transform of the file with what is changed of it.
fn place_texture(
    material: &mut Material,
    given: &model::Material,
    slot: Slot,
    changes: &[(Surface, Vec<f64>)],
) {
    let own = info(given, slot).and_then(|info| info.extensions.transform.as_deref());
    let mut offset = own.and_then(|t| t.offset).unwrap_or([0.0; 2]);
    let mut rotation = own.and_then(|t| t.rotation).unwrap_or(0.0);
    let mut scale = own.and_then(|t| t.scale).unwrap_or([1.0; 2]);
    for (surface, values) in changes {
        let two = || std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0));
        match surface {
            Surface::Offset(s) if *s == slot => offset = two(),
            Surface::Turn(s) if *s == slot => rotation = values.first().copied().unwrap_or(0.0),
            Surface::Scale(s) if *s == slot => scale = two(),
            _ => {}
        }
    }
    // Beyond what a scene takes it stays as it was.
    if let (Some(texture), Some(transform)) =
        (reference(material, slot), transform_of(offset, rotation, scale))
    {
        texture.transform = transform;
    }
}

/// The texture in the file.
fn info(given: &model::Material, slot: Slot) -> Option<&TextureInfo> {
    let base = given.pbr_metallic_roughness.as_deref();
    let extensions = given.extensions.as_deref();
    let coat = extensions.and_then(|e| e.clearcoat.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let sheen = extensions.and_then(|e| e.sheen.as_deref());
    let film = extensions.and_then(|e| e.iridescence.as_deref());
    let glossy = extensions.and_then(|e| e.specular_glossiness.as_ref());
    let diffuse = extensions.and_then(|e| e.diffuse_transmission.as_deref());
    match slot {
        Slot::BaseColor => base?.base_color_texture.as_ref(),
        Slot::MetallicRoughness => base?.metallic_roughness_texture.as_ref(),
        Slot::Normal => given.normal_texture.as_deref(),
        Slot::Occlusion => given.occlusion_texture.as_deref(),
        Slot::Emissive => given.emissive_texture.as_deref(),
        Slot::Specular => specular?.specular_texture.as_ref(),
        Slot::SpecularColor => specular?.specular_color_texture.as_ref(),
        Slot::Coat => coat?.clearcoat_texture.as_ref(),
        Slot::CoatRoughness => coat?.clearcoat_roughness_texture.as_ref(),
        Slot::CoatNormal => coat?.clearcoat_normal_texture.as_ref(),
        Slot::SheenColor => sheen?.sheen_color_texture.as_ref(),
        Slot::SheenRoughness => sheen?.sheen_roughness_texture.as_ref(),
        Slot::Anisotropy => extensions?.anisotropy.as_deref()?.anisotropy_texture.as_ref(),
        Slot::Iridescence => film?.iridescence_texture.as_ref(),
        Slot::FilmThickness => film?.iridescence_thickness_texture.as_ref(),
        Slot::Transmission => extensions?.transmission.as_deref()?.transmission_texture.as_ref(),
        Slot::DiffuseTransmission => diffuse?.diffuse_transmission_texture.as_ref(),
        Slot::DiffuseTransmissionColor => diffuse?.diffuse_transmission_color_texture.as_ref(),
        Slot::Thickness => extensions?.volume.as_deref()?.thickness_texture.as_ref(),
        Slot::Diffuse => glossy?.diffuse_texture.as_ref(),
        Slot::SpecularGlossiness => glossy?.specular_glossiness_texture.as_ref(),
    }
}

/// The texture in the scene's material.
fn reference(material: &mut Material, slot: Slot) -> Option<&mut TextureRef> {
    let glossy = is_glossy(material);
    let lobes = &mut material.lobes;
    match slot {
        Slot::BaseColor | Slot::Diffuse if (slot == Slot::Diffuse) != glossy => None,
        Slot::BaseColor | Slot::Diffuse => material.base_color_texture.as_mut(),
        Slot::MetallicRoughness => match &mut material.workflow {
            Workflow::MetallicRoughness { texture, .. } => texture.as_mut(),
            Workflow::SpecularGlossiness { .. } => None,
        },
        Slot::SpecularGlossiness => match &mut material.workflow {
            Workflow::SpecularGlossiness { texture, .. } => texture.as_mut(),
            Workflow::MetallicRoughness { .. } => None,
        },
        Slot::Normal => material.normal_texture.as_mut().map(|n| &mut n.texture),
        Slot::Occlusion => material.occlusion_texture.as_mut(),
        Slot::Emissive => material.emissive_texture.as_mut(),
        Slot::Specular => material.specular_texture.as_mut(),
        Slot::SpecularColor => material.specular_color_texture.as_mut(),
        Slot::Coat => material.coat_texture.as_mut(),
        Slot::CoatRoughness => material.coat_roughness_texture.as_mut(),
        Slot::CoatNormal => material.coat_normal_texture.as_mut().map(|n| &mut n.texture),
        Slot::SheenColor => lobes.sheen.color.texture.as_mut(),
        Slot::SheenRoughness => lobes.sheen.roughness.texture.as_mut(),
        Slot::Anisotropy => lobes.anisotropy.texture.as_mut(),
        Slot::Iridescence => lobes.iridescence.mask.texture.as_mut(),
        Slot::FilmThickness => lobes.iridescence.thickness_texture.as_mut(),
        Slot::Transmission => lobes.transmission.factor.texture.as_mut(),
        Slot::DiffuseTransmission => lobes.transmission.diffuse.texture.as_mut(),
        Slot::DiffuseTransmissionColor => lobes.transmission.diffuse_color.texture.as_mut(),
        Slot::Thickness => lobes.transmission.thickness.texture.as_mut(),
    }
}

/// A light of the file with what is changed of it.
pub(super) fn changed_light(given: &model::Light, changes: &[(Light, Vec<f64>)]) -> model::Light {
    let mut light = given.clone();
    for (property, values) in changes {
        let first = values.first().copied();
        match property {
            Light::Color => light.color = Some(three(values)),
            Light::Intensity => light.intensity = first,
            Light::Range => light.range = first,
            Light::InnerCone => light.spot.get_or_insert_default().inner_cone_angle = first,
            Light::OuterCone => light.spot.get_or_insert_default().outer_cone_angle = first,
        }
    }
    light
}

/// A camera of the file with what is changed of it.
pub(super) fn changed_camera(given: &model::Camera, changes: &[(Camera, Vec<f64>)]) -> model::Camera {
    let mut camera = given.clone();
    for (property, values) in changes {
        let first = values.first().copied().unwrap_or(0.0);
        match (property, &mut camera.perspective, &mut camera.orthographic) {
            (Camera::FieldOfView, Some(perspective), _) => perspective.yfov = first,
            (Camera::PerspectiveNear, Some(perspective), _) => perspective.znear = first,
            (Camera::Height, _, Some(orthographic)) => orthographic.ymag = first,
            (Camera::OrthographicNear, _, Some(orthographic)) => orthographic.znear = first,
            _ => {}
        }
    }
    camera
}

fn is_glossy(material: &Material) -> bool {
    matches!(material.workflow, Workflow::SpecularGlossiness { .. })
}

fn scale_normal(normal: &mut Option<NormalTexture>, scale: f64) {
    if let Some(normal) = normal {
        normal.scale = scale.clamp(-1e4, 1e4) as f32;
    }
}

fn three(values: &[f64]) -> [f64; 3] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
}
