//! COLLADA (Khronos, specifications 1.4.1 and 1.5.0): the visual scene that the document shows, with its meshes and materials.
//!
//! Units become metres, and the axis that is up is that of the document. Shaders of the common profile are drawn by their diffuse and
//! emitted light, with textures, opacity and, from the exponent of phong's highlight, roughness. Skins are drawn in their bind
//! pose, morphs as their base mesh, nodes where they stand without animation.

mod document;
mod geometry;
mod look;
#[cfg(test)]
mod tests;

use super::budget::Budget;
use super::mesh_formats::{
    add_placed, check_input, default_material, finish, material_of, phong_roughness, read_picture,
};
use super::normals::{add_missing_normals, add_smooth_normals};
use super::shares::Shares;
use super::text::{percent_decode, quoted};
use super::warnings::{Warnings, counted};
use super::xml::text_of;
use super::{Context, LoadError, Loaded, TextureLoading};
use document::{Document, Part};
use look::{Effect, Look};
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaMode, AlphaUse, CREASE_ANGLE, ColorSpace, Material, MaterialId, Mesh, MeshId, Sampler, Scene,
    TextureId, TextureRef, Transform, UvTransform, Workflow,
};
use std::collections::BTreeMap;

const FORMAT: &str = "COLLADA";

/// Reads a document, and the textures that it names.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut budget = Budget::shared(context.limits, shares);
    let text = text_of(bytes, "", &mut budget)?;
    let document = Document::read(&text, context)?;
    let mut builder = Builder {
        context,
        loading,
        document: &document,
        budget,
        scene: Scene::new(),
        warnings: Warnings::default(),
        meshes: BTreeMap::new(),
        materials: BTreeMap::new(),
        textures: BTreeMap::new(),
        visits: 0,
    };
    builder.build()?;
    let Builder { mut scene, mut warnings, .. } = builder;
    for geometry in document.geometries.values() {
        let name = || quoted(geometry.name.as_bytes());
        if geometry.bad > 0 {
            let bad = counted(geometry.bad, "primitive");
            warnings.add(|| {
                format!(
                    "{FORMAT}: {bad} of geometry {} left out: vertices missing, not finite or beyond 1e15",
                    name()
                )
            });
        }
        if geometry.holes > 0 {
            let holes = counted(geometry.holes, "polygon");
            warnings.add(|| format!("{FORMAT}: {holes} with holes in geometry {} filled", name()));
        }
        if geometry.unknown > 0 {
            warnings.add(|| format!("{FORMAT}: geometry {} is no mesh and is left out", name()));
        }
    }
    if document.animations > 0 {
        warnings.add(|| format!("{FORMAT}: animations have no effect"));
    }
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    Ok(Loaded { up: Some(document.up), ..finish(scene, warnings.finish()) })
}

struct Builder<'a> {
    context: &'a Context<'a>,
    loading: TextureLoading,
    document: &'a Document,
    budget: Budget,
    scene: Scene,
    warnings: Warnings,
    /// Meshes of the primitives of geometries.
    meshes: BTreeMap<(&'a str, usize), MeshId>,
    /// By the material's id; the empty one is that of surfaces without.
    materials: BTreeMap<String, MaterialId>,
    /// `None` for pictures that cannot be had.
    textures: BTreeMap<(String, bool), Option<TextureId>>,
    /// Nodes and parts so far, however often the document has them.
    visits: u64,
}

impl<'a> Builder<'a> {
    fn build(&mut self) -> Result<(), LoadError> {
        let document = self.document;
        let unit = Transform::scaling(document.unit).map_err(LoadError::scene("COLLADA: unit"))?;
        let shown = document.shown.as_ref().and_then(|id| document.scenes.get(id));
        let shown = shown.or_else(|| document.scenes.values().next());
        match shown {
            Some(roots) => roots.iter().try_for_each(|&root| self.node(root, &unit, 0))?,
            None if document.geometries.is_empty() => {}
            None => {
                self.warnings.add(|| format!("{FORMAT}: there is no visual scene: all geometries are drawn"));
                for id in document.geometries.keys() {
                    let part = Part { url: id.clone(), materials: BTreeMap::new() };
                    self.part(&part, &unit)?;
                }
            }
        }
        Ok(())
    }

    /// Counts what is visited: documents can place nodes within each other as often as they like.
    fn visit(&mut self, depth: u64) -> Result<(), LoadError> {
        self.visits = self.visits.saturating_add(1);
        let limits = self.context.limits;
        Limits::check(|| format!("{FORMAT}: the depth of nodes"), depth, limits.depth, "depth")?;
        Limits::check(|| format!("{FORMAT}: the number of nodes"), self.visits, limits.nodes, "nodes")?;
        Ok(())
    }

    fn node(&mut self, number: usize, parent: &Transform, depth: u64) -> Result<(), LoadError> {
        self.visit(depth)?;
        let document = self.document;
        let Some(node) = document.nodes.get(number) else { return Ok(()) };
        let Ok(transform) = parent.after(&node.transform) else {
            self.warnings.add(|| format!("{FORMAT}: a node that is moved too far is left out"));
            return Ok(());
        };
        for part in &node.parts {
            self.part(part, &transform)?;
        }
        let instances = node.instances.iter().filter_map(|url| {
            let found = document.by_id.get(url).copied();
            if found.is_none() {
                let url = quoted(url.as_bytes());
                self.warnings.add(|| format!("{FORMAT}: there is no node {url} to instance"));
            }
            found
        });
        let below: Vec<usize> = node.children.iter().copied().chain(instances.collect::<Vec<_>>()).collect();
        below.into_iter().try_for_each(|child| self.node(child, &transform, depth.saturating_add(1)))
    }

    /// Places a geometry, or that of a controller.
    fn part(&mut self, part: &Part, transform: &Transform) -> Result<(), LoadError> {
        self.visit(0)?;
        let document = self.document;
        let (mut url, mut placed) = (part.url.as_str(), *transform);
        // A skin may deform a morph.
        for _ in 0..2 {
            if let Some((source, shape)) = document.controllers.get(url) {
                url = source;
                match placed.after(shape) {
                    Ok(moved) => placed = moved,
                    Err(_) => return Ok(()),
                }
                self.warnings.add(|| {
                    format!("{FORMAT}: skins are drawn in their bind pose, morphs as their base mesh")
                });
            }
        }
        let Some((id, geometry)) = document.geometries.get_key_value(url) else {
            let url = quoted(url.as_bytes());
            self.warnings.add(|| format!("{FORMAT}: there is no geometry {url} to instance"));
            return Ok(());
        };
        let object = self.scene.instances().len() as u32;
        for (k, primitive) in geometry.primitives.iter().enumerate() {
            // A symbol without a binding may be the id itself.
            let symbol = &primitive.symbol;
            let bound = part.materials.get(symbol).unwrap_or(symbol);
            let material = self.material(bound)?;
            let element = format!("{FORMAT}: geometry {}", quoted(geometry.name.as_bytes()));
            let mesh = match self.meshes.get(&(id.as_str(), k)) {
                Some(mesh) => *mesh,
                None => {
                    let mut data = primitive.data.clone();
                    let missing: Vec<bool> =
                        data.normals.iter().map(|n| n.iter().all(|&v| v == 0.0)).collect();
                    if data.kind != overcoat_scene::PrimitiveKind::Triangles {
                        data.normals = Vec::new();
                    } else if missing.iter().all(|&missing| missing) {
                        add_smooth_normals(&mut data, CREASE_ANGLE, self.context.jobs);
                    } else if missing.contains(&true) {
                        let missing = |v: usize| missing.get(v) == Some(&true);
                        add_missing_normals(&mut data, CREASE_ANGLE, missing, self.context.jobs);
                    }
                    let mesh = Mesh::new(data).map_err(LoadError::scene(element.clone()))?;
                    let mesh = self.scene.add_mesh(mesh).map_err(LoadError::scene(element.clone()))?;
                    self.meshes.insert((id.as_str(), k), mesh);
                    mesh
                }
            };
            add_placed(&mut self.scene, &element, mesh, material, placed, object)?;
        }
        Ok(())
    }

    /// The material of an id; that of surfaces without for one that the document does not have.
    fn material(&mut self, id: &str) -> Result<MaterialId, LoadError> {
        let document = self.document;
        let effect = document.materials.get(id).and_then(|effect| document.effects.get(effect));
        let key = if effect.is_some() { id } else { "" };
        if let Some(known) = self.materials.get(key) {
            return Ok(*known);
        }
        let material = match effect {
            Some(effect) if effect.shader.is_empty() => {
                let name = quoted(id.as_bytes());
                self.warnings.add(|| {
                    format!("{FORMAT}: material {name} has no shader of the common profile: drawn plain")
                });
                default_material().with(|m| m.name = id.to_owned())
            }
            Some(effect) => (self.surface(id, effect)?).with(|m| m.name = id.to_owned()),
            None => default_material(),
        };
        let added = self.scene.add_material(material).map_err(LoadError::scene("COLLADA: material"))?;
        self.materials.insert(key.to_owned(), added);
        Ok(added)
    }

    fn surface(&mut self, id: &str, effect: &Effect) -> Result<Material, LoadError> {
        let is_texture = |look: &Option<Look>| matches!(look, Some(Look::Texture(_)));
        let [r, g, b, _] = Effect::linear(&effect.diffuse).unwrap_or(if is_texture(&effect.diffuse) {
            [1.0; 4]
        } else {
            [0.0, 0.0, 0.0, 1.0]
        });
        let mut opacity = effect.opacity().unwrap_or(1.0);
        if opacity <= 0.0 {
            let name = quoted(id.as_bytes());
            self.warnings
                .add(|| format!("{FORMAT}: material {name} is wholly transparent as written: drawn opaque"));
            opacity = 1.0;
        }
        let mut material = material_of([r, g, b, opacity]);
        if let Some(roughness) = roughness(effect) {
            material.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
        }
        let cut = is_texture(&effect.transparent);
        if opacity < 1.0 || cut {
            material.alpha_mode = AlphaMode::Blend;
        }
        let images = &self.document.images;
        let image = |of: fn(&Effect) -> &Option<Look>| effect.image(of(effect), images);
        let (own, other) = (image(|e| &e.diffuse), image(|e| &e.transparent));
        if cut && own != other {
            let name = quoted(id.as_bytes());
            self.warnings.add(|| {
                format!("{FORMAT}: the texture of material {name} for transparency alone has no effect")
            });
            material.alpha_mode = AlphaMode::Opaque;
        }
        let covers = material.alpha_mode != AlphaMode::Opaque;
        material.base_color_texture = self.texture(own, covers)?;
        if material.base_color_texture.is_none() && is_texture(&effect.diffuse) {
            material.base_color = [0.8, 0.8, 0.8, opacity];
        }
        let [r, g, b, _] = Effect::linear(&effect.emission).unwrap_or_default();
        material.emissive = [r, g, b];
        if let Some(texture) = self.texture(image(|e| &e.emission), false)? {
            (material.emissive, material.emissive_texture) = ([1.0; 3], Some(texture));
        }
        if effect.shader == "constant" {
            // Emission is the colour, without any light.
            let [r, g, b] = material.emissive;
            material.unlit = true;
            material.base_color = [r, g, b, opacity];
            material.base_color_texture = material.emissive_texture.take();
            material.emissive = [0.0; 3];
        }
        Ok(material)
    }

    /// Texture of an image; none, with a warning, if it cannot be had.
    fn texture(&mut self, image: Option<&str>, covers: bool) -> Result<Option<TextureRef>, LoadError> {
        let Some(image) = image else { return Ok(None) };
        let key = (image.to_owned(), covers);
        let texture = match self.textures.get(&key) {
            Some(known) => *known,
            None => {
                let texture = self.read_texture(image, covers)?;
                self.textures.insert(key, texture);
                texture
            }
        };
        Ok(texture.map(|texture| TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY }))
    }

    fn read_texture(&mut self, image: &str, covers: bool) -> Result<Option<TextureId>, LoadError> {
        let count = (self.textures.len() as u64).saturating_add(1);
        let limit = self.context.limits.textures;
        Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
        let Some(file) = self.document.images.get(image) else {
            let image = quoted(image.as_bytes());
            self.warnings.add_texture(|| format!("{FORMAT}: there is no image {image}"));
            return Ok(None);
        };
        // URIs of files: `file:///C:/textures/a%20b.png`.
        let file = percent_decode(file.strip_prefix("file://").unwrap_or(file));
        let image = match read_picture(FORMAT, self.context, &file, &mut self.budget)? {
            Ok(image) => image,
            Err(why) => {
                self.warnings.add_texture(|| why);
                return Ok(None);
            }
        };
        let alpha = if covers { AlphaUse::Coverage } else { AlphaUse::Data };
        let form = (ColorSpace::Srgb, alpha, Sampler::default());
        let Some(texture) = image.texture(form, self.loading, &mut self.warnings)? else { return Ok(None) };
        self.scene.add_texture(texture).map(Some).map_err(LoadError::scene("COLLADA: texture"))
    }
}

/// Roughness of a highlight. `None` without one.
fn roughness(effect: &Effect) -> Option<f32> {
    let is_dark = matches!(effect.specular, None | Some(Look::Color([0.0, 0.0, 0.0, _])));
    let exponent = effect.shininess.filter(|&n| effect.shader == "phong" && !is_dark && n > 0.0)?;
    Some(phong_roughness(exponent))
}
