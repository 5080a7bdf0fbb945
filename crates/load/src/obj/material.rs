//! Materials of OBJ files: Wavefront's Phong parameters, and the PBR extension that Exocortex, Blender and others
//! write.
//!
//! Conversion of Phong's parameters to physically based ones:
//! - `Kd` is the base colour. It is read as sRGB, as it was picked on a screen, unless the material has a PBR
//!   parameter: programs that write those work in linear colours.
//! - Roughness follows the exponent `Ns`: alpha = sqrt(2 / (Ns + 2)) (B. Walter et al., *Microfacet Models for
//!   Refraction*, 2007, for Blinn-Phong), perceptual roughness = sqrt(alpha). Black `Ks` means fully rough.
//! - Other values of `Ks` are not used: legacy files exaggerate them, and a dielectric's 4 percent looks right.
//!   `map_Ks` multiplies that reflectance.
//! - `Ni` is the index of refraction where it lies between 1 and 3 (many programs write 1 or 0 for "unknown").
//! - With `Pr`, `Pm`, `Pc`, `Pcr` and their maps these count; a map replaces the factor (Blender writes both).

use super::maps::Map;
use crate::mesh_formats::material_of;
use crate::names::shown;
use crate::text::{float, quoted};
use crate::warnings::Warnings;
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::parameters::EMISSIVE;
use overcoat_scene::{AlphaMode, Material, Workflow};

/// The texture statements of a material.
#[derive(Debug, Default)]
pub(super) struct Maps {
    pub(super) diffuse: Option<Map>,
    pub(super) opacity: Option<Map>,
    pub(super) specular: Option<Map>,
    pub(super) emissive: Option<Map>,
    pub(super) roughness: Option<Map>,
    pub(super) metallic: Option<Map>,
    pub(super) coat: Option<Map>,
    pub(super) coat_roughness: Option<Map>,
    pub(super) normal: Option<Map>,
    pub(super) bump: Option<Map>,
}

/// A material before its textures are there.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) material: Material,
    pub(super) maps: Maps,
}

impl Source {
    /// A material of a library in `folder`.
    pub(super) fn new(mtl: &tobj::Material, folder: &str, warnings: &mut Warnings) -> Self {
        let extra = |name: &str| mtl.unknown_param.get(name).map(String::as_str);
        let number = |name: &str| {
            let value = extra(name)?.split_whitespace().next()?;
            float(value.as_bytes()).filter(|v| v.is_finite())
        };
        let name = quoted(mtl.name.as_bytes());
        let unused = ["Ps", "map_Ps", "aniso", "anisor", "disp", "decal", "refl", "map_refl"];
        let mut missing: Vec<&str> = unused.into_iter().filter(|n| extra(n).is_some()).collect();
        missing.extend(mtl.shininess_texture.as_ref().map(|_| "map_Ns"));
        // The value 0 switches these off.
        missing.retain(|n| number(n) != Some(0.0));
        if !missing.is_empty() {
            warnings.add(|| format!("OBJ: {} of material {name} not drawn", missing.join(", ")));
        }

        let mut map = |text: Option<&str>| {
            let text = text?;
            let map = Map::parse(text, folder, warnings);
            if map.is_none() {
                warnings.add(|| format!("OBJ: a texture of material {name} has no file name"));
            }
            map
        };
        let maps = Maps {
            diffuse: map(mtl.diffuse_texture.as_deref()),
            opacity: map(mtl.dissolve_texture.as_deref()),
            specular: map(mtl.specular_texture.as_deref()),
            emissive: map(extra("map_Ke")),
            roughness: map(extra("map_Pr")),
            metallic: map(extra("map_Pm")),
            coat: map(extra("map_Pc")),
            coat_roughness: map(extra("map_Pcr")),
            normal: map(extra("norm")),
            bump: map(mtl.normal_texture.as_deref()),
        };

        let physical = ["Pr", "Pm", "Pc", "map_Pr", "map_Pm"].iter().any(|n| extra(n).is_some());
        let convert = |c: f32| if physical { saturate(c) } else { srgb_to_linear(saturate(c)) };
        let [r, g, b] = mtl.diffuse.unwrap_or([1.0; 3]).map(convert);
        // `Tr` is transparency, but MeshLab writes the opacity there: a surface that nobody could see is not meant.
        let transparency = number("Tr").filter(|&t| t < 1.0);
        let mut alpha = mtl.dissolve.or(transparency.map(|t| 1.0 - t)).map_or(1.0, saturate);
        if alpha <= 0.0 {
            // Blender 2.8 wrote `d 0` for its default material.
            warnings.add(|| format!("OBJ: material {name} is wholly transparent as written: drawn opaque"));
            alpha = 1.0;
        }
        // Not a number is none.
        let radiance = |c: f32| if c > 0.0 { EMISSIVE.range().clamp(f64::from(c)) } else { 0.0 };
        let emissive = mtl.emissive.unwrap_or([0.0; 3]).map(radiance);
        let material = material_of([r, g, b, alpha]).with(|m| {
            m.name = shown(&mtl.name);
            m.alpha_mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
            m.workflow = Workflow::MetallicRoughness {
                metallic: number("Pm").map_or(0.0, saturate),
                roughness: number("Pr").map_or_else(|| phong_roughness(mtl), saturate),
                texture: None,
            };
            m.ior = mtl.optical_density.filter(|&n| n > 1.0 && n <= 3.0).unwrap_or(1.5);
            m.emissive = emissive;
            m.coat = number("Pc").map_or(0.0, saturate);
            m.coat_roughness = number("Pcr").map_or(0.0, saturate);
        });
        Self { material, maps }
    }

    /// Maps of which other pictures are made: opacity joins the colours, metallic the roughness, heights become normals.
    pub(super) fn parts(&self) -> impl Iterator<Item = &Map> {
        let m = &self.maps;
        let color = m.diffuse.as_ref().filter(|_| m.opacity.is_some());
        [color, m.opacity.as_ref(), m.roughness.as_ref(), m.metallic.as_ref(), m.bump.as_ref()]
            .into_iter()
            .flatten()
    }

    /// The maps.
    pub(super) fn maps_mut(&mut self) -> [&mut Option<Map>; 10] {
        let m = &mut self.maps;
        [
            &mut m.diffuse,
            &mut m.opacity,
            &mut m.specular,
            &mut m.emissive,
            &mut m.roughness,
            &mut m.metallic,
            &mut m.coat,
            &mut m.coat_roughness,
            &mut m.normal,
            &mut m.bump,
        ]
    }
}

/// Perceptual roughness of a Phong material: see the head of this file.
fn phong_roughness(mtl: &tobj::Material) -> f32 {
    if mtl.specular.is_some_and(|ks| ks.iter().all(|&c| c <= 0.0)) {
        return 1.0;
    }
    match mtl.shininess {
        Some(ns) if ns > 0.0 => (2.0 / (ns + 2.0)).sqrt().sqrt(),
        Some(_) => 1.0,
        None => 0.5,
    }
}

/// 0 to 1; NaN becomes 0.
pub(super) fn saturate(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}
