//! Materials of OBJ files: Wavefront's Phong parameters, and the PBR extension that Exocortex, Blender and others
//! write.
//!
//! How Phong becomes physically based:
//! - `Kd` is the base colour. It is read as sRGB, as it was picked on a screen, unless the material has a PBR
//!   parameter: programs that write those work in linear colours.
//! - Roughness follows the exponent `Ns`: alpha = sqrt(2 / (Ns + 2)) (B. Walter et al., *Microfacet Models for
//!   Refraction*, 2007, for Blinn-Phong), perceptual roughness = sqrt(alpha). Black `Ks` means fully rough.
//! - Other values of `Ks` are not used: legacy files exaggerate them, and a dielectric's 4 percent looks right.
//!   `map_Ks` multiplies that reflectance.
//! - `Ni` is the index of refraction where it lies between 1 and 3 (many programs write 1 or 0 for "unknown").
//! - With `Pr`, `Pm`, `Pc`, `Pcr` and their maps these count; a map replaces the factor (Blender writes both).

use super::maps::{self, Map};
use super::mtl;
use crate::color::srgb::srgb_to_linear;
use crate::limits::Limits;
use crate::load::budget::Budget;
use crate::load::image::{self, Header, ImageError};
use crate::load::plain::{default_material, read_near};
use crate::load::text::{float, quoted};
use crate::load::warnings::Warnings;
use crate::load::{Context, LoadError};
use crate::scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Material, MaterialId, NormalTexture, Sampler, Scene, SceneError,
    Texture, TextureId, TextureRef, Workflow,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Most material libraries that one file may use.
const LIBRARIES: usize = 64;

/// The materials that a file defines, and the pictures they use.
pub(super) struct Library<'a> {
    context: &'a Context<'a>,
    /// By name; the last definition counts.
    materials: BTreeMap<String, tobj::Material>,
    /// Decoded pictures by file name; `None` for those that cannot be had.
    images: BTreeMap<String, Option<Arc<Image>>>,
    textures: BTreeMap<TextureKey, TextureId>,
    budget: Budget,
}

/// What makes two uses of a picture the same texture.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TextureKey {
    /// File names, and how they are combined.
    source: String,
    /// Colour space, use of alpha and sampler, in their debug form.
    reading: String,
}

impl<'a> Library<'a> {
    /// Reads the libraries that the file names.
    pub(super) fn read(
        context: &'a Context<'a>,
        names: &[String],
        warnings: &mut Warnings,
    ) -> Result<Self, LoadError> {
        let mut materials = BTreeMap::new();
        let mut left = context.limits.input_bytes;
        for (k, name) in names.iter().enumerate() {
            if k == LIBRARIES {
                warnings.add(|| format!("OBJ: material libraries beyond the first {LIBRARIES} are ignored"));
                break;
            }
            for (file, bytes) in read_library(context, name, left, warnings) {
                left = left.saturating_sub(bytes.len() as u64);
                for material in mtl::parse(&bytes, &file, warnings) {
                    materials.insert(material.name.clone(), material);
                }
            }
        }
        let count = materials.len() as u64;
        Limits::check(|| "OBJ: the number of materials".to_owned(), count, context.limits.nodes, "nodes")?;
        Ok(Self {
            context,
            materials,
            images: BTreeMap::new(),
            textures: BTreeMap::new(),
            budget: Budget::new(context.limits),
        })
    }

    /// Adds the materials of these names to a scene, in this order. Unknown ones become the default, with a warning.
    pub(super) fn add(
        &mut self,
        scene: &mut Scene,
        names: &[&str],
        warnings: &mut Warnings,
    ) -> Result<Vec<MaterialId>, LoadError> {
        let sources: Vec<Option<Source>> = names
            .iter()
            .map(|name| {
                let Some(material) = self.materials.get(*name) else {
                    // Without any library that has been said already.
                    if !self.materials.is_empty() {
                        warnings.add(|| format!("OBJ: material {} is not defined", quoted(name.as_bytes())));
                    }
                    return None;
                };
                Some(Source::new(material, warnings))
            })
            .collect();
        let files: BTreeSet<&str> = sources.iter().flatten().flat_map(Source::files).collect();
        self.decode(&files, warnings)?;
        let mut ids = Vec::with_capacity(names.len());
        for (name, source) in names.iter().zip(&sources) {
            let element = || format!("OBJ: material {}", quoted(name.as_bytes()));
            let material = match source {
                Some(source) => self.material(scene, source, warnings)?,
                None => default_material(),
            };
            ids.push(scene.add_material(material).map_err(LoadError::scene(element()))?);
        }
        Ok(ids)
    }

    /// Reads and decodes pictures, in parallel.
    fn decode(&mut self, files: &BTreeSet<&str>, warnings: &mut Warnings) -> Result<(), LoadError> {
        let context = self.context;
        let count = files.len() as u64;
        Limits::check(
            || "OBJ: the number of textures".to_owned(),
            count,
            context.limits.textures,
            "textures",
        )?;
        let mut found: Vec<(&str, Vec<u8>, Header)> = Vec::new();
        for &file in files {
            self.images.insert(file.to_owned(), None);
            let what = format!("texture {}", quoted(file.as_bytes()));
            let bytes = match read_near(context, file, context.limits.input_bytes) {
                Ok(bytes) => bytes,
                Err(error) => {
                    warnings.add(|| format!("OBJ: {what} is left out: {error}"));
                    continue;
                }
            };
            match image::probe(&what, &bytes, context.limits) {
                Ok(header) => {
                    // The file, its texels and a mip chain, and what is made of them.
                    self.budget.charge(|| what, header.texels(), 12)?;
                    self.budget.charge(
                        || format!("texture {}", quoted(file.as_bytes())),
                        bytes.len() as u64,
                        1,
                    )?;
                    found.push((file, bytes, header));
                }
                Err(ImageError::Limit(error)) => return Err(error.into()),
                Err(ImageError::Damaged(message)) => {
                    warnings.add(|| format!("OBJ: {what} is left out: {message}"));
                }
            }
        }
        let decoded = context.jobs.map(found.len(), |k| image::decode(&found[k].1, &found[k].2));
        for ((file, ..), decoded) in found.iter().zip(decoded) {
            match decoded {
                Ok(image) => {
                    self.images.insert((*file).to_owned(), Some(Arc::new(image)));
                }
                Err(ImageError::Limit(error)) => return Err(error.into()),
                Err(ImageError::Damaged(message)) => {
                    let file = quoted(file.as_bytes());
                    warnings.add(|| format!("OBJ: texture {file} is left out: {message}"));
                }
            }
        }
        Ok(())
    }

    fn image(&self, map: Option<&Map>) -> Option<&Arc<Image>> {
        self.images.get(&map?.file)?.as_ref()
    }

    /// A use of a texture that `make` builds, made once for equal `source` and reading.
    fn texture(
        &mut self,
        scene: &mut Scene,
        map: &Map,
        source: String,
        color_space: ColorSpace,
        alpha: AlphaUse,
        make: impl FnOnce(&Self) -> Result<Arc<Image>, SceneError>,
    ) -> Result<TextureRef, LoadError> {
        let element = || LoadError::scene(format!("OBJ: texture {}", quoted(source.as_bytes())));
        let reading = format!("{color_space:?} {alpha:?} {:?}", map.sampler);
        let key = TextureKey { source: source.clone(), reading };
        let texture = match self.textures.get(&key) {
            Some(&id) => id,
            None => {
                let image = make(self).map_err(element())?;
                let id = scene
                    .add_texture(Texture::new(image, color_space, alpha, map.sampler))
                    .map_err(element())?;
                let count = self.textures.len() as u64 + 1;
                let limit = self.context.limits.textures;
                Limits::check(|| "OBJ: the number of textures".to_owned(), count, limit, "textures")?;
                self.textures.insert(key, id);
                id
            }
        };
        Ok(TextureRef { texture, uv_set: 0, transform: map.transform })
    }

    /// A picture as it is.
    fn plain(
        &mut self,
        scene: &mut Scene,
        map: Option<&Map>,
        color_space: ColorSpace,
    ) -> Result<Option<TextureRef>, LoadError> {
        let (Some(map), Some(image)) = (map, self.image(map).cloned()) else { return Ok(None) };
        self.texture(scene, map, map.file.clone(), color_space, AlphaUse::Data, |_| Ok(image)).map(Some)
    }

    fn material(
        &mut self,
        scene: &mut Scene,
        source: &Source,
        warnings: &mut Warnings,
    ) -> Result<Material, LoadError> {
        let mut material = source.material.clone();
        let m = &source.maps;
        self.base_color(scene, source, &mut material)?;
        self.metallic_roughness(scene, source, &mut material)?;
        material.specular_color_texture = self.plain(scene, m.specular.as_ref(), ColorSpace::Srgb)?;
        material.emissive_texture = self.plain(scene, m.emissive.as_ref(), ColorSpace::Srgb)?;
        if material.emissive_texture.is_some() && material.emissive == [0.0; 3] {
            material.emissive = [1.0; 3];
        }
        material.coat_texture = self.plain(scene, m.coat.as_ref(), ColorSpace::Linear)?;
        if material.coat_texture.is_some() {
            material.coat = 1.0;
        }
        material.coat_roughness_texture = self.plain(scene, m.coat_roughness.as_ref(), ColorSpace::Linear)?;
        if material.coat_roughness_texture.is_some() {
            material.coat_roughness = 1.0;
        }
        material.normal_texture = self.normals(scene, source, warnings)?;
        Ok(material)
    }

    fn base_color(
        &mut self,
        scene: &mut Scene,
        source: &Source,
        material: &mut Material,
    ) -> Result<(), LoadError> {
        let color_map = source.maps.diffuse.as_ref().filter(|m| self.image(Some(m)).is_some());
        let opacity_map = source.maps.opacity.as_ref().filter(|m| self.image(Some(m)).is_some());
        if color_map.is_some() && material.base_color[..3] == [0.0; 3] {
            // Exporters that write black beside a texture do not mean a black texture.
            material.base_color[..3].fill(1.0);
        }
        let Some(opacity) = opacity_map else {
            material.base_color_texture = self.plain(scene, color_map, ColorSpace::Srgb)?;
            return Ok(());
        };
        let map = color_map.unwrap_or(opacity);
        let (Some(opacity_image), color_image) = (self.image(Some(opacity)), self.image(color_map)) else {
            return Ok(());
        };
        let combined = maps::with_opacity(color_image.map(Arc::as_ref), opacity_image);
        let combined = combined
            .map_err(LoadError::scene(format!("OBJ: texture {}", quoted(opacity.file.as_bytes()))))?;
        let alpha = if maps::is_translucent(&combined) || material.base_color[3] < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
            AlphaUse::Coverage
        } else {
            material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            AlphaUse::mask(0.5)
        };
        let name = format!("{} with the opacity of {}", map.file, opacity.file);
        let texture = self.texture(scene, map, name, ColorSpace::Srgb, alpha, |_| Ok(Arc::new(combined)))?;
        material.base_color_texture = Some(texture);
        Ok(())
    }

    fn metallic_roughness(
        &mut self,
        scene: &mut Scene,
        source: &Source,
        material: &mut Material,
    ) -> Result<(), LoadError> {
        let metal = source.maps.metallic.as_ref().filter(|m| self.image(Some(m)).is_some());
        let rough = source.maps.roughness.as_ref().filter(|m| self.image(Some(m)).is_some());
        let Some(map) = rough.or(metal) else { return Ok(()) };
        let name = |m: Option<&Map>| m.map_or("nothing", |m| &m.file).to_owned();
        let source_name = format!("metallic {} and roughness {}", name(metal), name(rough));
        let made = self.texture(scene, map, source_name, ColorSpace::Linear, AlphaUse::Data, |own| {
            let [metal, rough] = [metal, rough].map(|m| own.image(m).map(Arc::as_ref));
            maps::metallic_roughness(metal, rough).map(Arc::new)
        })?;
        if let Workflow::MetallicRoughness { metallic, roughness, texture } = &mut material.workflow {
            *texture = Some(made);
            if metal.is_some() {
                *metallic = 1.0;
            }
            if rough.is_some() {
                *roughness = 1.0;
            }
        }
        Ok(())
    }

    /// `norm`, or a bump map turned into normals.
    fn normals(
        &mut self,
        scene: &mut Scene,
        source: &Source,
        warnings: &mut Warnings,
    ) -> Result<Option<NormalTexture>, LoadError> {
        if let Some(texture) = self.plain(scene, source.maps.normal.as_ref(), ColorSpace::Linear)? {
            return Ok(Some(NormalTexture { texture, scale: 1.0 }));
        }
        let Some(map) = source.maps.bump.as_ref() else { return Ok(None) };
        let Some(image) = self.image(Some(map)).cloned() else { return Ok(None) };
        if maps::is_normal_map(&image) {
            let file = quoted(map.file.as_bytes());
            warnings
                .add(|| format!("OBJ: the bump map {file} is taken for what it looks like: a normal map"));
            let texture = self.plain(scene, Some(map), ColorSpace::Linear)?;
            return Ok(texture.map(|texture| NormalTexture { texture, scale: 1.0 }));
        }
        let name = format!("normals of {} x {}", map.file, map.bump);
        let texture = self.texture(scene, map, name, ColorSpace::Linear, AlphaUse::Data, |_| {
            maps::normals_of_heights(&image, map.bump, &map.sampler).map(Arc::new)
        })?;
        Ok(Some(NormalTexture { texture, scale: 1.0 }))
    }
}

/// The files behind one `mtllib`: a name that may contain spaces, or several names.
fn read_library(
    context: &Context<'_>,
    name: &str,
    limit: u64,
    warnings: &mut Warnings,
) -> Vec<(String, Vec<u8>)> {
    let whole = match read_near(context, name, limit) {
        Ok(bytes) => return vec![(quoted(name.as_bytes()), bytes)],
        Err(error) => error,
    };
    let mut found = Vec::new();
    if name.split_whitespace().nth(1).is_some() {
        for part in name.split_whitespace().take(LIBRARIES) {
            if let Ok(bytes) = read_near(context, part, limit) {
                found.push((quoted(part.as_bytes()), bytes));
            }
        }
    }
    if found.is_empty() {
        warnings.add(|| format!("OBJ: the material library is left out: {whole}"));
    }
    found
}

/// The texture statements of a material.
#[derive(Debug, Default)]
struct Maps {
    diffuse: Option<Map>,
    opacity: Option<Map>,
    specular: Option<Map>,
    emissive: Option<Map>,
    roughness: Option<Map>,
    metallic: Option<Map>,
    coat: Option<Map>,
    coat_roughness: Option<Map>,
    normal: Option<Map>,
    bump: Option<Map>,
}

/// A material before its textures are there.
#[derive(Debug)]
struct Source {
    material: Material,
    maps: Maps,
}

impl Source {
    fn new(mtl: &tobj::Material, warnings: &mut Warnings) -> Self {
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
            let map = Map::parse(text, warnings);
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
        let alpha = mtl.dissolve.or(number("Tr").map(|t| 1.0 - t)).map_or(1.0, saturate);
        let emissive = mtl
            .emissive
            .unwrap_or([0.0; 3])
            .map(|c| if c > 0.0 { if c < 1e6 { c } else { 1e6 } } else { 0.0 });
        let material = Material {
            name: mtl.name.clone(),
            base_color: [r, g, b, alpha],
            alpha_mode: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
            workflow: Workflow::MetallicRoughness {
                metallic: number("Pm").map_or(0.0, saturate),
                roughness: number("Pr").map_or_else(|| phong_roughness(mtl), saturate),
                texture: None,
            },
            ior: mtl.optical_density.filter(|&n| n > 1.0 && n <= 3.0).unwrap_or(1.5),
            emissive,
            coat: number("Pc").map_or(0.0, saturate),
            coat_roughness: number("Pcr").map_or(0.0, saturate),
            ..default_material()
        };
        Self { material, maps }
    }

    /// The files that the maps name.
    fn files(&self) -> impl Iterator<Item = &str> {
        let m = &self.maps;
        let maps = [
            &m.diffuse,
            &m.opacity,
            &m.specular,
            &m.emissive,
            &m.roughness,
            &m.metallic,
            &m.coat,
            &m.coat_roughness,
            &m.normal,
            &m.bump,
        ];
        maps.into_iter().flatten().map(|m| m.file.as_str())
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
fn saturate(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// Samplers are compared by their debug form above; this keeps that honest.
#[cfg(test)]
#[test]
fn samplers_have_distinct_debug_forms() {
    let clamped = Sampler { wrap_u: crate::scene::Wrap::ClampToEdge, ..Sampler::default() };
    assert_ne!(format!("{clamped:?}"), format!("{:?}", Sampler::default()));
}
