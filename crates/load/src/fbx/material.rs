//! Materials: Phong and Lambert, and the properties that programs write for their physically based ones.

use super::Loading;
use super::document::{Document, Kind, Object, Properties, vector};
use super::record::{FORMAT, Record};
use super::texture::{Role, Textures, Use};
use crate::LoadError;
use crate::mesh_formats::{material_of, phong_roughness};
use crate::text::quoted;
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::{AlphaMode, Material, NormalTexture, Scene, Workflow};

/// Pictures of a material.
#[derive(Default)]
struct Maps<'r> {
    base: Option<Use<'r>>,
    opacity: Option<Use<'r>>,
    emission: Option<Use<'r>>,
    metallic: Option<Use<'r>>,
    roughness: Option<Use<'r>>,
    occlusion: Option<Use<'r>>,
    normal: Option<Use<'r>>,
    bump: Option<Use<'r>>,
}

impl Maps<'_> {
    /// Emitted light: a picture takes the place of a colour.
    fn light(&self, color: Option<[f32; 3]>) -> [f32; 3] {
        if self.emission.is_some() { [1.0; 3] } else { color.unwrap_or_default() }
    }
}

/// Most properties that a warning names.
const NAMED: usize = 8;

/// Names of the base colour in physically based materials.
const BASE: &[&str] = &["base_color", "baseColor", "basecolor"];

/// Properties of physically based materials (`Maya|metalness`, `3dsMax|Parameters|metalness`, `3dsMax|main|metalness`): of
/// Stingray PBS and the Standard Surface of Arnold in Maya, and of the Physical and PBR materials of 3ds Max.
struct Pbr<'r>(Vec<(&'r [u8], &'r Record<'r>, usize)>);

/// The end of the name of a property, without what marks that it is of a map: `color` of `Maya|TEX_color_map`.
fn key_of(name: &[u8]) -> &[u8] {
    let name = name.rsplit(|&b| b == b'|').next().unwrap_or(name);
    let name = name.strip_prefix(b"TEX_").unwrap_or(name);
    name.strip_suffix(b"_map").unwrap_or(name)
}

impl<'r> Pbr<'r> {
    /// `None` of a material that has no such base colour.
    fn of(properties: &Properties<'r>) -> Option<Self> {
        let own = properties.own().filter(|(name, ..)| name.contains(&b'|'));
        let pbr = Self(own.map(|(name, record, place)| (key_of(name), record, place)).collect());
        pbr.color(BASE).is_some().then_some(pbr)
    }

    fn find<T>(&self, names: &[&str], read: impl Fn(&Record<'_>, usize) -> Option<T>) -> Option<T> {
        let named = |key: &[u8]| names.iter().any(|name| name.as_bytes() == key);
        self.0.iter().filter(|(key, ..)| named(key)).find_map(|(_, record, place)| read(record, *place))
    }

    fn number(&self, names: &[&str]) -> Option<f32> {
        self.find(names, |record, place| record.float(place)).map(|v| v as f32)
    }

    fn color(&self, names: &[&str]) -> Option<[f32; 3]> {
        self.find(names, vector).map(|color| color.map(|v| v as f32))
    }

    /// The factors of a material.
    fn material(&self, maps: &Maps<'_>) -> Material {
        let weight = unit(self.number(&["base", "base_weight"]).unwrap_or(1.0));
        let base = if maps.base.is_some() { [1.0; 3] } else { self.color(BASE).unwrap_or([0.8; 3]) };
        let [r, g, b] = base.map(|v| unit(v) * weight);
        let opacity = self.color(&["opacity"]).map(|[r, g, b]| (r + g + b) / 3.0);
        let opacity = opacity.or_else(|| self.number(&["opacity", "cutout"])).map_or(1.0, unit);
        let mut material = material_of([r, g, b, opacity]);
        let is_inverse = self.number(&["roughness_inv"]).is_some_and(|v| v != 0.0);
        let rough = self.number(&["roughness", "specularRoughness", "specular_roughness"]);
        let rough = rough.map(|v| if is_inverse { 1.0 - v } else { v });
        let rough = rough.or_else(|| self.number(&["glossiness"]).map(|v| 1.0 - v));
        let metallic = self.number(&["metallic", "metalness"]).map_or(0.0, unit);
        let of_map = |map: &Option<Use<'_>>, factor: f32| if map.is_some() { 1.0 } else { factor };
        material.workflow = Workflow::MetallicRoughness {
            metallic: of_map(&maps.metallic, metallic),
            roughness: of_map(&maps.roughness, rough.map_or(0.5, unit)),
            texture: None,
        };
        let strength = self.number(&["emission", "emissive_intensity"]).unwrap_or(1.0);
        let light = self.color(&["emissive", "emissionColor", "emit_color", "emission_color"]);
        material.emissive = maps.light(light).map(|v| bright(v * strength));
        material.coat = self.number(&["coat", "coating"]).map_or(0.0, unit);
        let coat = self.number(&["coatRoughness", "coat_roughness", "coat_rough"]);
        material.coat_roughness = coat.map_or(0.0, unit);
        let ior = self.number(&["specularIOR", "specular_IOR", "trans_ior"]);
        material.ior = ior.filter(|ior| (1.0..=10.0).contains(ior)).unwrap_or(1.5);
        material
    }
}

/// 0 to 1; NaN becomes 0.
fn unit(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// Emitted light as a scene takes it.
fn bright(v: f32) -> f32 {
    if v > 0.0 { if v < 1e6 { v } else { 1e6 } } else { 0.0 }
}

/// Factors of Phong and Lambert.
fn common(object: &Object<'_>, is_blender: bool, maps: &Maps<'_>) -> Material {
    let properties = &object.properties;
    let number = |name: &str| properties.number(name).map(|v| v as f32);
    let color = |names: [&str; 2]| {
        let found = names.iter().find_map(|name| properties.vector(name));
        // Blender writes its linear colours as they are; other programs write those of the screen.
        found.map(|color| {
            color.map(|v| if is_blender { unit(v as f32) } else { srgb_to_linear(unit(v as f32)) })
        })
    };
    let factor = unit(number("DiffuseFactor").unwrap_or(1.0));
    let base =
        if maps.base.is_some() { [1.0; 3] } else { color(["DiffuseColor", "Diffuse"]).unwrap_or([0.8; 3]) };
    let [r, g, b] = base.map(|v| v * factor);
    let mut material = material_of([r, g, b, opacity(properties, is_blender)]);
    let strength = number("EmissiveFactor").unwrap_or(1.0);
    material.emissive = maps.light(color(["EmissiveColor", "Emissive"])).map(|v| bright(v * strength));
    let exponent = number("ShininessExponent").or_else(|| number("Shininess"));
    let specular = color(["SpecularColor", "Specular"]).unwrap_or_default();
    let shines = number("SpecularFactor").unwrap_or(1.0) > 0.0 && specular.iter().any(|v| *v > 0.0);
    let of_map = |map: &Option<Use<'_>>, factor: f32| if map.is_some() { 1.0 } else { factor };
    let (metallic, roughness) = match exponent.filter(|exponent| *exponent >= 0.0) {
        // Blender's exporter: the exponent is the square of 10 (1 - roughness), the reflection is metallic.
        Some(exponent) if is_blender => {
            let metallic = unit(number("ReflectionFactor").unwrap_or(0.0));
            (of_map(&maps.metallic, metallic), of_map(&maps.roughness, unit(1.0 - exponent.sqrt() / 10.0)))
        }
        Some(exponent) if shines && is_phong(object) && exponent > 0.0 => (0.0, phong_roughness(exponent)),
        _ => (0.0, of_map(&maps.roughness, 0.5)),
    };
    material.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
    material
}

fn is_phong(object: &Object<'_>) -> bool {
    object.record.text_of("ShadingModel").is_some_and(|model| model.eq_ignore_ascii_case(b"phong"))
}

/// Opacity, as far as programs agree: that of the property if the material has it, else what a transparent colour and its factor
/// leave.
fn opacity(properties: &Properties<'_>, is_blender: bool) -> f32 {
    let own = |wanted: &[u8]| {
        let (_, record, place) = properties.own().find(|(name, ..)| *name == wanted)?;
        record.float(place)
    };
    if let Some(opacity) = own(b"Opacity") {
        return unit(opacity as f32);
    }
    let factor = properties.number("TransparencyFactor").unwrap_or(0.0);
    let color = properties.vector("TransparentColor").filter(|_| !is_blender).unwrap_or([1.0; 3]);
    let [r, g, b] = color;
    unit((1.0 - factor * (r + g + b) / 3.0) as f32)
}

/// The pictures that are connected to a material, with a warning of those that have no effect.
fn maps<'r>(
    document: &Document<'r>,
    number: usize,
    pbr: Option<&Pbr<'r>>,
    loading: &mut Loading<'_>,
) -> Maps<'r> {
    let (mut maps, mut lost) = (Maps::default(), Vec::new());
    let Some(object) = document.objects.get(number) else { return maps };
    for &(from, property) in &object.links {
        let is_texture = |object: &Object<'_>| matches!(object.kind, Kind::Texture | Kind::Layered);
        if !document.objects.get(from).is_some_and(is_texture) {
            continue;
        }
        let property = property.unwrap_or(b"DiffuseColor");
        let key = key_of(property);
        // Stingray has a switch for each map.
        let switch = [b"use_", key].concat();
        let switch = String::from_utf8_lossy(&switch).into_owned();
        if pbr.and_then(|pbr| pbr.number(&[&switch])) == Some(0.0) {
            continue;
        }
        let is_pbr = pbr.is_some();
        let slot = match key {
            b"DiffuseColor" | b"Diffuse" | b"base_color" | b"baseColor" | b"basecolor" | b"baseColorMap" => {
                &mut maps.base
            }
            b"color" if is_pbr => &mut maps.base,
            b"NormalMap" | b"normalMap" | b"normalCamera" | b"norm" | b"normal" => &mut maps.normal,
            b"Bump" | b"bump" => &mut maps.bump,
            b"EmissiveColor" | b"emissive" | b"emit_color" | b"emissionColor" => &mut maps.emission,
            b"TransparentColor" | b"TransparencyFactor" | b"opacity" | b"cutout" => &mut maps.opacity,
            b"ReflectionFactor" if document.is_blender => &mut maps.metallic,
            b"Shininess" | b"ShininessExponent" if document.is_blender => &mut maps.roughness,
            b"metallic" | b"metalness" | b"metalnessMap" => &mut maps.metallic,
            b"roughness" | b"specularRoughness" | b"roughnessMap" | b"Roughness_Map" => &mut maps.roughness,
            b"ao" | b"ambientOcclusionMap" => &mut maps.occlusion,
            // Names that 3ds Max has for the same connections once more.
            _ if key.starts_with(b"mapM") => continue,
            _ => {
                if lost.len() < NAMED {
                    lost.push(quoted(property));
                }
                continue;
            }
        };
        if slot.is_none() {
            *slot = Use::new(document, from, loading);
        }
    }
    if !lost.is_empty() {
        let (name, lost) = (quoted(object.name.as_bytes()), lost.join(", "));
        loading
            .warnings
            .add(|| format!("{FORMAT}: textures of material {name} have no effect: those for {lost}"));
    }
    maps
}

/// Makes the material of an object. `second` is the name of the second set of texture coordinates, `other` the texture of the
/// model, as they are before version 7: the colour of materials that have none.
pub(super) fn material<'r>(
    scene: &mut Scene,
    document: &Document<'r>,
    number: usize,
    (second, other): (Option<&[u8]>, Option<usize>),
    textures: &mut Textures,
    loading: &mut Loading<'_>,
) -> Result<Material, LoadError> {
    let Some(object) = document.objects.get(number) else { return Ok(Material::default()) };
    let pbr = Pbr::of(&object.properties);
    let mut maps = maps(document, number, pbr.as_ref(), loading);
    if maps.base.is_none() {
        maps.base = other.and_then(|other| Use::new(document, other, loading));
    }
    let mut material = match &pbr {
        Some(pbr) => pbr.material(&maps),
        None => common(object, document.is_blender, &maps),
    };
    material.name.clone_from(&object.name);
    let named = quoted(object.name.as_bytes());
    if material.base_color[3] <= 0.0 && maps.opacity.is_none() {
        loading
            .warnings
            .add(|| format!("{FORMAT}: material {named} is wholly transparent as written: drawn opaque"));
        material.base_color[3] = 1.0;
    }
    let set = |of: &Use<'_>| u8::from(second.is_some_and(|second| second == of.set));
    let mut plain = |of: &Option<Use<'r>>, role: Role, loading: &mut Loading<'_>, scene: &mut Scene| match of
    {
        Some(of) => textures.plain(scene, document, (of, set(of)), role, loading),
        None => Ok(None),
    };
    material.emissive_texture = plain(&maps.emission, Role::Color, loading, scene)?;
    if maps.emission.is_some() && material.emissive_texture.is_none() {
        material.emissive = [0.0; 3];
    }
    material.occlusion_texture = plain(&maps.occlusion, Role::Data, loading, scene)?;
    let normal = plain(&maps.normal, Role::Data, loading, scene)?;
    base_color(scene, document, &maps, (&mut material, second), textures, loading)?;
    let bump = match &maps.bump {
        Some(bump) if normal.is_none() => {
            let parts = ([Some(bump), None], set(bump));
            textures.combined(scene, document, parts, (Role::Data, "height"), loading)?
        }
        _ => None,
    };
    material.normal_texture = normal.or(bump).map(|texture| NormalTexture { texture, scale: 1.0 });
    if let Some(first) = maps.metallic.as_ref().or(maps.roughness.as_ref()) {
        let parts = ([maps.metallic.as_ref(), maps.roughness.as_ref()], set(first));
        let made = textures.combined(scene, document, parts, (Role::Data, "metallic"), loading)?;
        if let Workflow::MetallicRoughness { metallic, roughness, texture } = &mut material.workflow {
            match made {
                Some(made) => *texture = Some(made),
                None => (*metallic, *roughness) = (0.0, 0.5),
            }
        }
    }
    Ok(material)
}

fn base_color<'r>(
    scene: &mut Scene,
    document: &Document<'r>,
    maps: &Maps<'r>,
    (material, second): (&mut Material, Option<&[u8]>),
    textures: &mut Textures,
    loading: &mut Loading<'_>,
) -> Result<(), LoadError> {
    let set = |of: &Use<'_>| u8::from(second.is_some_and(|second| second == of.set));
    let mut made = None;
    if let Some(opacity) = &maps.opacity {
        // Opacity in the colour's own alpha, or in a picture of its own.
        let is_own = maps.base.as_ref().is_some_and(|base| base.is_same_picture(opacity));
        if !is_own || textures.may_cover(document, opacity, loading)? {
            let first = maps.base.as_ref().unwrap_or(opacity);
            made = if is_own {
                textures.plain(scene, document, (first, set(first)), Role::Cover, loading)?
            } else {
                let parts = ([maps.base.as_ref(), Some(opacity)], set(first));
                textures.combined(scene, document, parts, (Role::Cover, "opacity"), loading)?
            };
            if made.is_some() {
                material.alpha_mode = AlphaMode::Blend;
                material.base_color[3] = 1.0;
            }
        }
    }
    if material.base_color[3] <= 0.0 {
        material.base_color[3] = 1.0;
    }
    if material.base_color[3] < 1.0 {
        material.alpha_mode = AlphaMode::Blend;
    }
    if let Some(base) = maps.base.as_ref().filter(|_| made.is_none()) {
        made = textures.plain(scene, document, (base, set(base)), Role::Color, loading)?;
        if made.is_none() {
            let [r, g, b, _] = &mut material.base_color;
            [*r, *g, *b] = [0.8; 3];
        }
    }
    material.base_color_texture = made;
    Ok(())
}
