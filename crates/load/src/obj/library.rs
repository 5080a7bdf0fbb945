//! Material libraries of a file: reading them, decoding the pictures that they name, and putting both together.

use super::maps::Map;
use super::material::Source;
use super::mtl;
use super::udim;
use crate::budget::{Budget, Claim};
use crate::derived_images;
use crate::encoded_image::{EncodedImage, warn_of_left_out, warn_of_reduced};
use crate::image::{self, ImageError, Picture, area};
use crate::mesh_formats::default_material;
use crate::names::is_escaped;
use crate::nearby::{Found, Nearby, folder_of};
use crate::text::quoted;
use crate::warnings::Warnings;
use crate::{Context, LoadError, TextureLoading};
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Material, MaterialId, NormalTexture, Scene, SceneError, Texture,
    TextureId, TextureRef, Workflow,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Most material libraries that one file may use.
const LIBRARIES: usize = 64;

/// The materials that a file defines, and the pictures they use.
pub(super) struct Library<'a> {
    context: &'a Context<'a>,
    /// By name, with the folder of the library; the last definition counts.
    materials: BTreeMap<String, (tobj::Material, String)>,
    nearby: Nearby,
    /// A library could be read; what it lacks has not been said.
    found: bool,
    /// Time at which pictures are decoded that are textures as they are.
    loading: TextureLoading,
    /// Pictures by the names of their files; `None` for those that cannot be had.
    images: BTreeMap<String, Option<Held>>,
    /// Pictures made of those, by what they are made of.
    derived: BTreeMap<String, (Arc<Image>, bool)>,
    textures: BTreeMap<TextureKey, TextureId>,
    budget: Budget,
}

/// Picture of a file.
#[derive(Clone)]
enum Held {
    /// Decoded: others are made of it.
    Decoded(Arc<Image>),
    /// A texture as it is.
    Encoded(EncodedImage),
}

/// Picture on its way to [`Held`].
struct Fetched {
    /// Name of its file.
    file: String,
    image: EncodedImage,
    /// Others are made of it.
    is_part: bool,
}

/// Identity of a texture: uses of a picture with equal keys share one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TextureKey {
    /// File names, and how they are combined: [`key`].
    source: String,
    /// Colour space, use of alpha and sampler, in their debug form.
    reading: String,
}

impl<'a> Library<'a> {
    /// Reads the libraries that the file names. If it names none that is there, and uses materials, the one is taken that is
    /// called as the model is: both have been renamed together.
    pub(super) fn read(
        (context, loading): (&'a Context<'a>, TextureLoading),
        names: &[String],
        used: &[String],
        warnings: &mut Warnings,
    ) -> Result<Self, LoadError> {
        let mut materials = BTreeMap::new();
        let mut nearby = Nearby::default();
        let mut not_utf8 = used.iter().any(|name| is_escaped(name));
        let (mut left, mut found) = (context.limits.input_bytes, false);
        for (k, name) in names.iter().enumerate() {
            if k == LIBRARIES {
                warnings.add(|| format!("OBJ: material libraries beyond the first {LIBRARIES} are ignored"));
                break;
            }
            for file in read_library(context, &mut nearby, name, left, warnings) {
                left = left.saturating_sub(file.bytes.len() as u64);
                found = true;
                not_utf8 |= add_materials(&mut materials, &file, warnings);
            }
        }
        if !found
            && !used.is_empty()
            && let Some(file) = namesake(context, &mut nearby, left)
        {
            let name = quoted(file.name.as_bytes());
            warnings.add(|| {
                format!("OBJ: {name}, which is called as the model is, is taken for its material library")
            });
            found = true;
            not_utf8 |= add_materials(&mut materials, &file, warnings);
        }
        if not_utf8 {
            warnings.add(|| "OBJ: names that are not UTF-8 are shown with U+FFFD in them".to_owned());
        }
        let count = materials.len() as u64;
        Limits::check(|| "OBJ: the number of materials".to_owned(), count, context.limits.nodes, "nodes")?;
        Ok(Self {
            context,
            materials,
            nearby,
            found,
            loading,
            images: BTreeMap::new(),
            derived: BTreeMap::new(),
            textures: BTreeMap::new(),
            budget: Budget::new(context.limits),
        })
    }

    /// True if the material of a name has a picture for each tile of its texture coordinates.
    pub(super) fn is_tiled(&self, name: &str) -> bool {
        self.materials.get(name).is_some_and(|(material, _)| udim::is_tiled(material))
    }

    /// The name of the material, if there is one alone.
    pub(super) fn only_one(&self) -> Option<&str> {
        let mut names = self.materials.keys();
        names.next().filter(|_| names.len() == 0).map(String::as_str)
    }

    /// Adds the materials of these names to a scene, in this order. Unknown ones become the default, with a warning.
    pub(super) fn add(
        &mut self,
        scene: &mut Scene,
        names: &[&str],
        warnings: &mut Warnings,
    ) -> Result<Vec<MaterialId>, LoadError> {
        // A material as it is read and as it is drawn, the latter twice for a list that grows.
        const SIZE: usize = size_of::<Option<Source>>() + 2 * size_of::<Material>();
        self.budget.charge(|| "OBJ: materials".to_owned(), names.len() as u64, SIZE as u64)?;
        let mut sources: Vec<Option<Source>> = names
            .iter()
            .map(|name| {
                let (name, tile) = udim::split(name);
                let Some((material, folder)) = self.materials.get(name) else {
                    // Without any library that has been said already.
                    if self.found {
                        warnings.add(|| format!("OBJ: material {} is not defined", quoted(name.as_bytes())));
                    }
                    return None;
                };
                if !udim::is_tiled(material) {
                    return Some(Source::new(material, folder, warnings));
                }
                let tile = tile.unwrap_or("1001");
                let mut source = Source::new(&udim::variant(material, tile), folder, warnings);
                for map in source.maps_mut().into_iter().flatten() {
                    map.others.extend(udim::first_tile(material, &map.file, tile));
                }
                Some(source)
            })
            .collect();
        self.decode(&mut sources, warnings)?;
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

    /// Reads and decodes the pictures of materials, in parallel. Maps are named by the files that were found afterwards; those
    /// without are gone.
    fn decode(&mut self, sources: &mut [Option<Source>], warnings: &mut Warnings) -> Result<(), LoadError> {
        let context = self.context;
        // As they are named, and where that was found.
        let mut places: BTreeMap<(String, String), (Vec<String>, Option<String>)> = BTreeMap::new();
        for map in sources.iter_mut().flatten().flat_map(Source::maps_mut).filter_map(|slot| slot.as_ref()) {
            let key = (map.folder.clone(), map.file.clone());
            places.entry(key).or_insert_with(|| (map.others.clone(), None));
        }
        let count = places.len() as u64;
        Limits::check(
            || "OBJ: the number of textures".to_owned(),
            count,
            context.limits.textures,
            "textures",
        )?;
        let parts: BTreeSet<(String, String)> = sources
            .iter()
            .flatten()
            .flat_map(Source::parts)
            .map(|map| (map.folder.clone(), map.file.clone()))
            .collect();
        let mut found: Vec<Fetched> = Vec::new();
        for ((folder, file), (others, place)) in &mut places {
            let what = format!("texture {}", quoted(file.as_bytes()));
            let names = std::iter::once(file.as_str()).chain(others.iter().map(String::as_str));
            let Found { name, bytes, note } =
                match self.nearby.read(context, folder, names, context.limits.input_bytes) {
                    Ok(found) => found,
                    Err(error) => {
                        warnings.add_texture(|| format!("OBJ: {what} is left out: {error}"));
                        continue;
                    }
                };
            if let Some(note) = note {
                warnings.add(|| format!("OBJ: {what} does not exist; {note}"));
            }
            *place = Some(name.clone());
            let is_part = parts.contains(&(folder.clone(), file.clone()));
            if self.images.contains_key(&name) {
                if let Some(known) = found.iter_mut().find(|known| known.file == name) {
                    known.is_part |= is_part;
                }
                continue;
            }
            self.images.insert(name.clone(), None);
            match image::probe_large(&what, &bytes, context.limits) {
                Ok(header) => {
                    self.budget.charge(|| what.clone(), bytes.len() as u64, 1)?;
                    let image = EncodedImage {
                        name: format!("OBJ: {what}"),
                        bytes: Arc::new(bytes),
                        header,
                        finest: header.excess(),
                    };
                    found.push(Fetched { file: name, image, is_part });
                }
                Err(ImageError::Limit(limit)) => {
                    warnings.add_texture(|| format!("OBJ: {limit}; it is left out"));
                }
                Err(ImageError::Damaged(message)) => {
                    warnings.add_texture(|| format!("OBJ: {what} is left out: {message}"));
                }
            }
        }
        self.hold(found, warnings)?;
        for source in sources.iter_mut().flatten() {
            let glows = source.maps.emissive.is_some();
            for slot in source.maps_mut() {
                *slot = slot.take().and_then(|map| {
                    let place = places.get(&(map.folder.clone(), map.file.clone()));
                    let file = place.and_then(|(_, place)| place.clone())?;
                    self.images.get(&file)?.as_ref()?;
                    Some(Map { file, ..map })
                });
            }
            if glows && source.maps.emissive.is_none() {
                // The factor alone would make all of it glow.
                source.material.emissive = [0.0; 3];
            }
        }
        Ok(())
    }

    /// Takes pictures into the budget, the largest smaller if need be, and decodes those of which others are made or that are not
    /// decoded by need, in parallel.
    fn hold(&mut self, found: Vec<Fetched>, warnings: &mut Warnings) -> Result<(), LoadError> {
        // Texels and a mip chain, and pictures made of them.
        let claim = |Fetched { image, is_part, .. }: &Fetched| {
            Claim::of(&image.header, if *is_part { 12 } else { 6 })
        };
        let mut claims: Vec<Claim> = found.iter().map(claim).collect();
        self.budget.fit(&mut claims);
        let (mut kept, mut left_out) = (Vec::new(), Vec::new());
        for (mut fetched, claim) in found.into_iter().zip(&claims) {
            let image = &mut fetched.image;
            if claim.left_out {
                left_out.push(std::mem::take(&mut image.name));
                continue;
            }
            self.budget.charge_texture(|| image.name.clone(), claim)?;
            image.finest = claim.finest;
            kept.push(fetched);
        }
        let found = kept;
        warn_of_left_out(left_out, warnings);
        warn_of_reduced(found.iter().filter_map(|found| found.image.reduction()), warnings);
        let loading = self.loading;
        let decoded = self.context.jobs.map_each(&found, |Fetched { image, is_part, .. }| {
            let by_need = loading == TextureLoading::ByNeed || image.finest > 0;
            (*is_part || !by_need && !image.can_be_streamed()).then(|| image.decode())
        });
        for (Fetched { file, image, .. }, decoded) in found.into_iter().zip(decoded) {
            let held = match decoded {
                None => Some(Held::Encoded(image)),
                Some(Ok(Picture { image: decoded, flaw })) => {
                    if let Some(flaw) = flaw {
                        warnings.add(|| format!("{}: {flaw}", image.name));
                    }
                    Some(Held::Decoded(Arc::new(decoded)))
                }
                Some(Err(error)) => {
                    let message = error.loss()?;
                    warnings.add_texture(|| format!("{} is left out: {message}", image.name));
                    None
                }
            };
            self.images.insert(file, held);
        }
        Ok(())
    }

    /// True if there is a picture for a map.
    fn has(&self, map: &Map) -> bool {
        matches!(self.images.get(&map.file), Some(Some(_)))
    }

    /// The decoded picture of a map, of which others are made.
    fn image(&self, map: Option<&Map>) -> Option<&Arc<Image>> {
        match self.images.get(&map?.file)?.as_ref()? {
            Held::Decoded(image) => Some(image),
            Held::Encoded(_) => None,
        }
    }

    /// A picture made of others, once for equal `parts`, and something about it that takes long to find out.
    fn derive(
        &mut self,
        parts: &[&str],
        texels: u64,
        is_special: fn(&Image) -> bool,
        make: impl FnOnce(&Self) -> Result<Arc<Image>, SceneError>,
    ) -> Result<(Arc<Image>, bool), LoadError> {
        if let Some(known) = self.derived.get(&key(parts)) {
            return Ok(known.clone());
        }
        let what = || format!("OBJ: texture {}", quoted(parts.join(" ").as_bytes()));
        self.budget.charge(what, texels, 4)?;
        let image = make(self).map_err(LoadError::scene(what()))?;
        let special = is_special(&image);
        self.derived.insert(key(parts), (image.clone(), special));
        Ok((image, special))
    }

    /// A use of a picture, as the same texture for equal `parts` and reading.
    fn texture(
        &mut self,
        scene: &mut Scene,
        map: &Map,
        parts: &[&str],
        picture: &Held,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Result<Option<TextureRef>, LoadError> {
        let reading = format!("{color_space:?} {alpha:?} {:?}", map.sampler);
        let key = TextureKey { source: key(parts), reading };
        let texture = match self.textures.get(&key) {
            Some(&id) => id,
            None => {
                let what = || format!("OBJ: texture {}", quoted(parts.join(" ").as_bytes()));
                let (count, limit) =
                    ((self.textures.len() as u64).saturating_add(1), self.context.limits.textures);
                Limits::check(|| "OBJ: the number of textures".to_owned(), count, limit, "textures")?;
                let texture = match picture {
                    Held::Decoded(image) => {
                        // Mip levels: a third of the picture.
                        self.budget.charge(what, texels(image), 2)?;
                        Texture::new(Arc::clone(image), color_space, alpha, map.sampler)
                    }
                    Held::Encoded(image) => {
                        let form = (color_space, alpha, map.sampler);
                        let now = self.loading == TextureLoading::Whole && image.finest == 0;
                        let texture = if now { image.streamed(form) } else { None };
                        let Some(texture) = texture.or_else(|| image.lazy_texture(form)) else {
                            return Ok(None);
                        };
                        texture
                    }
                };
                let id = scene.add_texture(texture).map_err(LoadError::scene(what()))?;
                self.textures.insert(key, id);
                id
            }
        };
        Ok(Some(TextureRef { texture, uv_set: 0, transform: map.transform }))
    }

    /// A picture as it is.
    fn plain(
        &mut self,
        scene: &mut Scene,
        map: Option<&Map>,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Result<Option<TextureRef>, LoadError> {
        let Some(map) = map else { return Ok(None) };
        let Some(Some(held)) = self.images.get(&map.file).cloned() else { return Ok(None) };
        self.texture(scene, map, &[&map.file], &held, color_space, alpha)
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
        material.specular_color_texture =
            self.plain(scene, m.specular.as_ref(), ColorSpace::Srgb, AlphaUse::Data)?;
        material.emissive_texture =
            self.plain(scene, m.emissive.as_ref(), ColorSpace::Srgb, AlphaUse::Data)?;
        if material.emissive_texture.is_some() && material.emissive == [0.0; 3] {
            material.emissive = [1.0; 3];
        }
        material.coat_texture = self.plain(scene, m.coat.as_ref(), ColorSpace::Linear, AlphaUse::Data)?;
        if material.coat_texture.is_some() {
            material.coat = 1.0;
        }
        material.coat_roughness_texture =
            self.plain(scene, m.coat_roughness.as_ref(), ColorSpace::Linear, AlphaUse::Data)?;
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
        let color_map = source.maps.diffuse.as_ref().filter(|m| self.has(m));
        let opacity_map = source.maps.opacity.as_ref().filter(|m| self.image(Some(m)).is_some());
        if color_map.is_some() && material.base_color[..3] == [0.0; 3] {
            // Exporters that write black beside a texture do not mean a black texture.
            material.base_color[..3].fill(1.0);
        }
        let Some(opacity) = opacity_map else {
            material.base_color_texture = self.plain(scene, color_map, ColorSpace::Srgb, AlphaUse::Data)?;
            return Ok(());
        };
        let map = color_map.unwrap_or(opacity);
        let (Some(opacity_image), color_image) =
            (self.image(Some(opacity)).cloned(), self.image(color_map).cloned())
        else {
            return Ok(());
        };
        let parts = ["opacity", &opacity.file, color_map.map_or("", |m| &m.file)];
        let size = texels(color_image.as_ref().unwrap_or(&opacity_image));
        let (combined, translucent) = self.derive(&parts, size, derived_images::is_translucent, |_| {
            derived_images::with_opacity(color_image.as_deref(), &opacity_image).map(Arc::new)
        })?;
        let alpha = if translucent || material.base_color[3] < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
            AlphaUse::Coverage
        } else {
            material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            AlphaUse::mask(0.5)
        };
        material.base_color_texture =
            self.texture(scene, map, &parts, &Held::Decoded(combined), ColorSpace::Srgb, alpha)?;
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
        let [metal_image, rough_image] = [metal, rough].map(|m| self.image(m).cloned());
        let parts = ["metallic", metal.map_or("", |m| &m.file), "roughness", rough.map_or("", |m| &m.file)];
        // Each side is the larger one of the two.
        let side =
            |f: fn(&Image) -> u32| [&metal_image, &rough_image].into_iter().flatten().map(|i| f(i)).max();
        let size = area(side(Image::width).unwrap_or(1), side(Image::height).unwrap_or(1));
        let (packed, _) = self.derive(
            &parts,
            size,
            |_| false,
            |_| {
                derived_images::metallic_roughness(metal_image.as_deref(), rough_image.as_deref())
                    .map(Arc::new)
            },
        )?;
        let made =
            self.texture(scene, map, &parts, &Held::Decoded(packed), ColorSpace::Linear, AlphaUse::Data)?;
        if let Workflow::MetallicRoughness { metallic, roughness, texture } = &mut material.workflow {
            *texture = made;
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
        if let Some(texture) =
            self.plain(scene, source.maps.normal.as_ref(), ColorSpace::Linear, AlphaUse::Normals)?
        {
            return Ok(Some(NormalTexture { texture, scale: 1.0 }));
        }
        let Some(map) = source.maps.bump.as_ref() else { return Ok(None) };
        let Some(image) = self.image(Some(map)).cloned() else { return Ok(None) };
        let source = ["bump", &map.file];
        let (image, normals) = self.derive(&source, 0, derived_images::is_normal_map, |_| Ok(image))?;
        if normals {
            let file = quoted(map.file.as_bytes());
            warnings
                .add(|| format!("OBJ: the bump map {file} is taken for what it looks like: a normal map"));
            let texture = self.plain(scene, Some(map), ColorSpace::Linear, AlphaUse::Normals)?;
            return Ok(texture.map(|texture| NormalTexture { texture, scale: 1.0 }));
        }
        let parts = ["normals", &map.file, &map.bump.to_string(), &format!("{:?}", map.sampler)];
        let (image, _) = self.derive(
            &parts,
            texels(&image),
            |_| false,
            |_| derived_images::normals_of_heights(&image, map.bump, &map.sampler).map(Arc::new),
        )?;
        let texture =
            self.texture(scene, map, &parts, &Held::Decoded(image), ColorSpace::Linear, AlphaUse::Normals)?;
        Ok(texture.map(|texture| NormalTexture { texture, scale: 1.0 }))
    }
}

/// Names in one string; no name contains the separator.
fn key(parts: &[&str]) -> String {
    parts.join("\0")
}

fn texels(image: &Image) -> u64 {
    area(image.width(), image.height())
}

/// Adds the materials of a library. True if it has names that are not UTF-8.
fn add_materials(
    materials: &mut BTreeMap<String, (tobj::Material, String)>,
    file: &Found,
    warnings: &mut Warnings,
) -> bool {
    let mut not_utf8 = false;
    for material in mtl::parse(&file.bytes, &quoted(file.name.as_bytes()), warnings) {
        not_utf8 |= is_escaped(&material.name);
        materials.insert(material.name.clone(), (material, folder_of(&file.name).to_owned()));
    }
    not_utf8
}

/// The library beside the model that has its name.
fn namesake(context: &Context<'_>, nearby: &mut Nearby, limit: u64) -> Option<Found> {
    let model = context.resolver.model_name()?;
    let stem = model.rsplit_once('.').map_or(model, |(stem, _)| stem);
    let names = [format!("{stem}.mtl"), format!("{model}.mtl")];
    nearby.read(context, "", names.iter().map(String::as_str), limit).ok()
}

/// The files behind one `mtllib`: a name that may contain spaces, or several names.
fn read_library(
    context: &Context<'_>,
    nearby: &mut Nearby,
    name: &str,
    limit: u64,
    warnings: &mut Warnings,
) -> Vec<Found> {
    let whole = match nearby.read(context, "", [name], limit) {
        Ok(found) => {
            if let Some(note) = &found.note {
                let name = quoted(name.as_bytes());
                warnings.add(|| format!("OBJ: the material library {name} does not exist; {note}"));
            }
            return vec![found];
        }
        Err(error) => error,
    };
    let mut found = Vec::new();
    if name.split_whitespace().nth(1).is_some() {
        for part in name.split_whitespace().take(LIBRARIES) {
            found.extend(nearby.read(context, "", [part], limit));
        }
    }
    if found.is_empty() {
        warnings.add(|| format!("OBJ: the material library is left out: {whole}"));
    }
    found
}

/// Samplers are compared by their debug form above; this keeps that honest.
#[cfg(test)]
#[test]
fn samplers_have_distinct_debug_forms() {
    use overcoat_scene::Sampler;
    let clamped = Sampler { wrap_u: overcoat_scene::Wrap::ClampToEdge, ..Sampler::default() };
    assert_ne!(format!("{clamped:?}"), format!("{:?}", Sampler::default()));
}
