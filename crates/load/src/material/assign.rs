//! Lays material files over the materials of a scene.

use super::MaterialFile;
use super::error::AssignError;
use super::laid::{Part, TextureMaker, lay};
use super::texture::{TextureUse, metallic_roughness, one_channel};
use crate::budget::Budget;
use crate::grouped::Grouped;
use crate::tangents::{add_tangents, tangent_set};
use overcoat_core::limits::Limits;
use overcoat_core::suggest::nearest_name;
use overcoat_scene::{
    AlphaUse, ColorSpace, Image, Material, MaterialId, Mesh, MeshData, MeshId, Sampler, Scene, SceneError,
    Texture, TextureId, TextureRef,
};
use std::collections::BTreeSet;
use std::sync::Arc;

impl MaterialFile {
    /// Lays the material over every material of a scene, or over those of one name. Meshes get the tangents that it
    /// needs.
    ///
    /// A MaterialX document with several materials lays each over those of its own name, or, where the scene has none of these
    /// names, the first over every one; and over those of one name that of this name, if there is one, else the first.
    ///
    /// # Errors
    /// [`AssignError`] if there is no material of that name, or the textures and tangents exceed the limits. The scene
    /// may then be changed in part.
    pub fn assign(&self, scene: &mut Scene, name: Option<&str>, limits: &Limits) -> Result<(), AssignError> {
        let mut budget = Budget::new(limits);
        if let Some(name) = name {
            let chosen = chosen(scene, Some(name))?;
            return self.called(name).unwrap_or(self).lay(scene, &chosen, limits, &mut budget);
        }
        let mut by_name: Vec<(&Self, BTreeSet<MaterialId>)> = Vec::new();
        for (k, material) in scene.materials().iter().enumerate() {
            let Some(file) = self.called(&material.name) else { continue };
            let id = MaterialId::from_index(k as u32);
            match by_name.iter_mut().find(|(known, _)| std::ptr::eq(*known, file)) {
                Some((_, ids)) => {
                    ids.insert(id);
                }
                None => by_name.push((file, BTreeSet::from([id]))),
            }
        }
        if by_name.is_empty() {
            by_name.push((self, chosen(scene, None)?));
        }
        by_name.iter().try_for_each(|(file, ids)| file.lay(scene, ids, limits, &mut budget))
    }

    /// The material of that name of a document that has several.
    fn called(&self, name: &str) -> Option<&Self> {
        if self.others.is_empty() || name.is_empty() {
            return None;
        }
        let all = || std::iter::once(self).chain(&self.others);
        all().find(|file| file.description() == name).or_else(|| {
            // Names of MaterialX have letters, digits and underscores.
            let valid: String =
                name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
            all().find(|file| file.description() == valid)
        })
    }

    /// Lays this one material over those of a scene.
    fn lay(
        &self,
        scene: &mut Scene,
        chosen: &BTreeSet<MaterialId>,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<(), AssignError> {
        let mut builder = Builder { file: self, scene, made: Vec::new(), limits, budget };
        for &id in chosen {
            let material = builder.material(id)?;
            builder.scene.replace_material(id, material)?;
        }
        fit_meshes(scene, chosen, !self.is_over(), limits, budget)
    }
}

/// The materials of that name, or all.
fn chosen(scene: &Scene, name: Option<&str>) -> Result<BTreeSet<MaterialId>, AssignError> {
    let materials = scene.materials();
    let ids = (0..materials.len()).map(|k| MaterialId::from_index(k as u32));
    let Some(name) = name else { return Ok(ids.collect()) };
    let named = ids.zip(materials).filter(|(_, material)| material.name == name);
    let chosen: BTreeSet<MaterialId> = named.map(|(id, _)| id).collect();
    if !chosen.is_empty() {
        return Ok(chosen);
    }
    let names: BTreeSet<&str> = materials.iter().map(|m| m.name.as_str()).filter(|n| !n.is_empty()).collect();
    Err(AssignError::NoSuchMaterial {
        name: name.to_owned(),
        // Hostile files may have a million names: the first few thousand will do.
        nearest: nearest_name(name, names.iter().copied().take(4096)).map(str::to_owned),
        names: names.into_iter().map(str::to_owned).collect(),
    })
}

/// Identity of a texture: uses with equal forms share one.
#[derive(Clone, Debug, PartialEq)]
struct Form {
    /// Files and channels; channel 4 stands for all.
    files: [Option<(String, u8)>; 2],
    /// Metallic and roughness in one.
    packed: bool,
    color_space: ColorSpace,
    alpha: AlphaUse,
    sampler: Sampler,
}

/// Makes materials and their textures.
struct Builder<'a> {
    file: &'a MaterialFile,
    scene: &'a mut Scene,
    made: Vec<(Form, TextureId)>,
    limits: &'a Limits,
    budget: &'a mut Budget,
}

impl Builder<'_> {
    /// The material that material `id` of the scene becomes.
    fn material(&mut self, id: MaterialId) -> Result<Material, AssignError> {
        let no_such = SceneError::NoSuch { what: "material", index: id.index() as u32 };
        let own = self.scene.materials().get(id.index()).ok_or(no_such)?;
        let mut material = if self.file.is_over() {
            own.clone()
        } else {
            Material::default().with(|m| {
                m.name = own.name.clone();
                m.double_sided = own.double_sided;
            })
        };
        let file = self.file;
        lay(&file.settings, &mut material, self)?;
        Ok(material)
    }

    /// The texture of that form, made if there is none yet.
    fn reference(
        &mut self,
        texture: &TextureUse,
        form: Form,
        image: impl FnOnce(&MaterialFile) -> Option<Arc<Image>>,
    ) -> Result<TextureRef, AssignError> {
        let known = self.made.iter().find(|(made, _)| *made == form).map(|(_, id)| *id);
        let id = match known {
            Some(id) => id,
            None => {
                let count = (self.scene.textures().len() as u64).saturating_add(1);
                Limits::check(|| "textures".to_owned(), count, self.limits.textures, "textures")?;
                // Every file that is named has been loaded.
                let image = image(self.file).ok_or(SceneError::NoSuch { what: "texture", index: 0 })?;
                let texels = image.texels().len() as u64;
                self.budget.charge(|| texture.file.clone(), texels, 6)?;
                let made = Texture::new(image, form.color_space, form.alpha, form.sampler);
                let id = self.scene.add_texture(made)?;
                self.made.push((form, id));
                id
            }
        };
        Ok(TextureRef { texture: id, uv_set: texture.uv_set, transform: texture.transform })
    }
}

impl TextureMaker for Builder<'_> {
    type Error = AssignError;

    fn whole(
        &mut self,
        texture: &TextureUse,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Result<Option<TextureRef>, AssignError> {
        let files = [Some((texture.file.clone(), 4)), None];
        let form = Form { files, packed: false, color_space, alpha, sampler: texture.sampler };
        let image = self.file.pictures.get(&texture.file).cloned();
        self.reference(texture, form, |_| image).map(Some)
    }

    fn one_channel(&mut self, texture: &TextureUse, channel: u8) -> Result<Option<TextureRef>, AssignError> {
        let files = [Some((texture.file.clone(), channel)), None];
        let form = Form {
            files,
            packed: false,
            color_space: ColorSpace::Linear,
            alpha: AlphaUse::Data,
            sampler: texture.sampler,
        };
        self.reference(texture, form, |file| {
            file.pictures.get(&texture.file).map(|image| Arc::new(one_channel(image, channel)))
        })
        .map(Some)
    }

    fn packed(&mut self, metallic: Part<'_>, roughness: Part<'_>) -> Result<Option<TextureRef>, AssignError> {
        let Some((texture, _)) = metallic.or(roughness) else { return Ok(None) };
        let name = |given: Part<'_>| given.map(|(t, channel)| (t.file.clone(), channel));
        let form = Form {
            files: [name(metallic), name(roughness)],
            packed: true,
            color_space: ColorSpace::Linear,
            alpha: AlphaUse::Data,
            sampler: texture.sampler,
        };
        self.reference(texture, form, |file| {
            let picture = |given: Part<'_>| {
                given.and_then(|(t, channel)| file.pictures.get(&t.file).map(|image| (&**image, channel)))
            };
            metallic_roughness(picture(metallic), picture(roughness)).map(Arc::new)
        })
        .map(Some)
    }
}

/// Gives meshes the tangents that the chosen materials need, and takes vertex colours from those whose material has
/// been replaced. A mesh that other materials use as well is copied for that.
fn fit_meshes(
    scene: &mut Scene,
    chosen: &BTreeSet<MaterialId>,
    replaced: bool,
    limits: &Limits,
    budget: &mut Budget,
) -> Result<(), AssignError> {
    let count = scene.meshes().len();
    let draws = Grouped::new(count, scene.instances().iter().map(|instance| instance.mesh.index()));
    let mut vertices = scene.meshes().iter().map(|m| m.positions().len() as u64).sum::<u64>();
    for k in 0..count {
        let id = MeshId::from_index(k as u32);
        let Some(mesh) = scene.meshes().get(k) else { break };
        let material = |draw: u32| scene.instances().get(draw as usize).map(|instance| instance.material);
        let is_chosen = |draw: &u32| material(*draw).is_some_and(|id| chosen.contains(&id));
        let (these, others): (Vec<u32>, Vec<u32>) = draws.group(k).iter().partition(|&draw| is_chosen(draw));
        let set = these
            .iter()
            .find_map(|&draw| tangent_set(scene.materials().get(material(draw)?.index())?))
            // Without normals there is flat shading, and tangents mean nothing.
            .filter(|&set| {
                mesh.tangents().is_empty() && !mesh.normals().is_empty() && !mesh.uvs(set.index()).is_empty()
            });
        let without_colors = replaced && !these.is_empty() && !mesh.colors().is_empty();
        if set.is_none() && !without_colors {
            continue;
        }
        budget.charge(|| format!("mesh {k}"), mesh.positions().len() as u64, BYTES_A_VERTEX)?;
        budget.charge(|| format!("mesh {k}"), mesh.triangles().len() as u64, 12)?;
        let mut data: MeshData = mesh.data().clone();
        if without_colors {
            data.colors = Vec::new();
        }
        if let Some(set) = set {
            add_tangents(&mut data, set.index());
        }
        vertices = vertices.saturating_add(data.positions.len() as u64);
        if others.is_empty() {
            vertices = vertices.saturating_sub(mesh.positions().len() as u64);
        }
        Limits::check(|| format!("mesh {k} with tangents"), vertices, limits.vertices, "vertices")?;
        let mesh = Mesh::new(data)?;
        if others.is_empty() {
            scene.replace_mesh(id, mesh)?;
        } else {
            let copy = scene.add_mesh(mesh)?;
            for draw in these {
                scene.set_instance_mesh(draw as usize, copy)?;
            }
        }
    }
    Ok(())
}

/// Bytes of all attributes of a vertex.
const BYTES_A_VERTEX: u64 = 12 + 12 + 16 + 16 + 16;
