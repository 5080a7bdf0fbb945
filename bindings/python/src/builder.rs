//! Scenes of arrays: what `overcoat._arrays`, `_trimesh` and `compat.pyrender` make of other libraries' objects.

use crate::arrays::{optional_rows, rows, transform};
use crate::errors::{self, Kind};
use crate::kept::{Geometry, Texels};
use crate::model::Model;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use overcoat::Scene;
use overcoat::jobs::Jobs;
use overcoat::load::{add_smooth_normals, add_tangents};
use overcoat::scene::{
    AlphaMode, AlphaUse, Axis, ColorSpace, Filter, Instance, Light, LightKind, Material, MaterialId, Mesh,
    MeshData, MeshId, MipFilter, NormalTexture, Orientation, PrimitiveKind, Sampler, Splat, SplatCloud,
    SplatCloudBuilder, SplatColorSpace, SplatInstance, SplatOrder, TextureId, TextureRef, UvTransform,
    Workflow, Wrap,
};
use pyo3::prelude::*;
use serde::Deserialize;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A scene that grows until it is finished.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug, Default)]
pub(crate) struct SceneBuilder(Mutex<Parts>);

#[derive(Debug, Default)]
struct Parts {
    scene: Scene,
    images: Vec<Py<Texels>>,
    /// Image, sampler and use of each texture that was made.
    textures: Vec<(usize, Sampler, ColorSpace, AlphaUse, TextureId)>,
    materials: Vec<MaterialId>,
    meshes: Vec<MeshId>,
    warnings: Vec<String>,
}

/// A material as Python describes it: numbers as in glTF, textures by the number of their image.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct MaterialData {
    name: String,
    base_color: [f32; 4],
    base_color_texture: Option<TextureData>,
    metallic: f32,
    roughness: f32,
    metallic_roughness_texture: Option<TextureData>,
    ior: f32,
    emissive: [f32; 3],
    emissive_texture: Option<TextureData>,
    normal_texture: Option<TextureData>,
    normal_scale: f32,
    occlusion_texture: Option<TextureData>,
    /// `opaque`, `mask` or `blend`.
    alpha_mode: String,
    alpha_cutoff: f32,
    double_sided: bool,
    unlit: bool,
}

impl Default for MaterialData {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.5,
            metallic_roughness_texture: None,
            ior: 1.5,
            emissive: [0.0; 3],
            emissive_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            alpha_mode: "opaque".to_owned(),
            alpha_cutoff: 0.5,
            double_sided: false,
            unlit: false,
        }
    }
}

/// An image and how it is read.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TextureData {
    image: usize,
    /// OpenGL's numbers, as in glTF; 0 for the default.
    wrap_u: u32,
    wrap_v: u32,
    magnification: u32,
    minification: u32,
    uv_set: u8,
}

/// A light; directions and positions in metres of the world.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightData {
    /// `directional`, `point` or `spot`.
    kind: String,
    #[serde(default)]
    position: [f32; 3],
    /// Direction in which the light travels.
    #[serde(default)]
    direction: [f32; 3],
    color: [f32; 3],
    /// Lux for directional lights, candela for others.
    intensity: f32,
    range: Option<f32>,
    #[serde(default)]
    inner_cone_cosine: f32,
    #[serde(default)]
    outer_cone_cosine: f32,
}

/// An object that is given as JSON, deserialised.
fn parsed<'a, T: Deserialize<'a>>(what: &str, json: &'a str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| Kind::Mesh.error(format_args!("{what}: {error}")))
}

/// Arrays of a mesh.
pub(crate) struct MeshArrays<'py> {
    pub(crate) positions: PyReadonlyArray2<'py, f32>,
    pub(crate) indices: PyReadonlyArray2<'py, u32>,
    pub(crate) normals: Option<PyReadonlyArray2<'py, f32>>,
    pub(crate) uv: Option<PyReadonlyArray2<'py, f32>>,
    pub(crate) colors: Option<PyReadonlyArray2<'py, f32>>,
}

impl MeshArrays<'_> {
    /// A mesh of them, see [`Geometry`].
    pub(crate) fn mesh(
        self,
        py: Python<'_>,
        kind: &str,
        crease_degrees: Option<f32>,
        tangents_of: Option<usize>,
    ) -> PyResult<Mesh> {
        let kind = match kind {
            "lines" => PrimitiveKind::Lines,
            "points" => PrimitiveKind::Points,
            _ => PrimitiveKind::Triangles,
        };
        let mut data = MeshData::default();
        data.positions = rows("vertices", &self.positions)?;
        data.normals = optional_rows("normals", self.normals)?;
        data.uvs[0] = optional_rows("uv", self.uv)?;
        data.colors = optional_rows("colors", self.colors)?;
        data.triangles = rows("faces", &self.indices)?;
        data.kind = kind;
        let mesh = py.detach(|| {
            let _arithmetic = crate::arithmetic::DefaultArithmetic::new();
            // Checked before anything is made of it.
            let checked = Mesh::new(data.clone())?;
            let smooth =
                crease_degrees.filter(|_| data.normals.is_empty() && kind == PrimitiveKind::Triangles);
            if smooth.is_none() && tangents_of.is_none() {
                return Ok(checked);
            }
            if let Some(angle) = smooth {
                add_smooth_normals(&mut data, angle.clamp(0.0, 180.0), &Jobs::new(1));
            }
            if let Some(set) = tangents_of {
                add_tangents(&mut data, set);
            }
            Mesh::new(data)
        });
        mesh.map_err(|e| errors::scene("mesh", &e))
    }
}

/// A cloud of splats of arrays of one length; `harmonics` has 3 numbers for each coefficient above degree 0.
fn cloud(
    positions: PyReadonlyArray2<'_, f32>,
    scales: PyReadonlyArray2<'_, f32>,
    rotations: PyReadonlyArray2<'_, f32>,
    opacities: PyReadonlyArray2<'_, f32>,
    colors: PyReadonlyArray2<'_, f32>,
    harmonics: &PyReadonlyArray2<'_, f32>,
) -> PyResult<SplatCloud> {
    let positions: Vec<[f32; 3]> = rows("means", &positions)?;
    let scales: Vec<[f32; 3]> = rows("scales", &scales)?;
    let rotations: Vec<[f32; 4]> = rows("rotations", &rotations)?;
    let opacities: Vec<[f32; 1]> = rows("opacities", &opacities)?;
    let colors: Vec<[f32; 3]> = rows("colors", &colors)?;
    let width = harmonics.shape()[1];
    let degree = [0, 9, 24, 45].iter().position(|known| *known == width).ok_or_else(|| {
        Kind::Mesh.error(format_args!(
            "harmonics: expected shape (N, K, 3) with K = 3, 8 or 15, found ({}, {}, 3)",
            harmonics.shape()[0],
            width / 3
        ))
    })?;
    let lists = [scales.len(), rotations.len(), opacities.len(), colors.len(), harmonics.shape()[0]];
    if let Some(other) = lists.iter().find(|length| **length != positions.len()) {
        let message = format_args!("splats: {} means, but another array has {other} rows", positions.len());
        return Err(Kind::Mesh.error(message.to_string()));
    }
    let harmonics =
        harmonics.as_slice().map_err(|error| Kind::Mesh.error(format_args!("harmonics: {error}")))?;
    let wrong = |e| errors::scene("splats", &e);
    let builder = SplatCloudBuilder::new(degree as u8, SplatColorSpace::Srgb, SplatOrder::Depth);
    let mut builder = builder.map_err(wrong)?;
    builder.reserve(positions.len());
    for k in 0..positions.len() {
        let splat = Splat {
            position: positions[k],
            scale: scales[k],
            rotation: rotations[k],
            opacity: opacities[k][0],
            color: colors[k],
        };
        let (above, _) = harmonics[k * width..(k + 1) * width].as_chunks::<3>();
        builder.push(&splat, above).map_err(wrong)?;
    }
    Ok(builder.finish())
}

impl SceneBuilder {
    fn parts(&self) -> MutexGuard<'_, Parts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl SceneBuilder {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// A picture; returns its number.
    fn add_image(&self, texels: Py<Texels>) -> usize {
        let mut parts = self.parts();
        parts.images.push(texels);
        parts.images.len() - 1
    }

    /// A material; returns its number.
    fn add_material(&self, json: &str) -> PyResult<usize> {
        let data: MaterialData = parsed("material", json)?;
        let mut parts = self.parts();
        let material = parts.material(&data)?;
        let id = parts.scene.add_material(material).map_err(|e| errors::scene("material", &e))?;
        parts.materials.push(id);
        Ok(parts.materials.len() - 1)
    }

    /// A mesh; returns its number.
    fn add_mesh(&self, geometry: &Bound<'_, Geometry>) -> PyResult<usize> {
        let mut parts = self.parts();
        let id = parts.scene.add_mesh(geometry.get().0.clone()).map_err(|e| errors::scene("mesh", &e))?;
        parts.meshes.push(id);
        Ok(parts.meshes.len() - 1)
    }

    /// Splats of arrays at a place: see `overcoat.Splats`.
    #[allow(clippy::too_many_arguments)]
    fn add_splats(
        &self,
        positions: PyReadonlyArray2<'_, f32>,
        scales: PyReadonlyArray2<'_, f32>,
        rotations: PyReadonlyArray2<'_, f32>,
        opacities: PyReadonlyArray2<'_, f32>,
        colors: PyReadonlyArray2<'_, f32>,
        harmonics: PyReadonlyArray2<'_, f32>,
        matrix: PyReadonlyArray2<'_, f64>,
        object: u32,
    ) -> PyResult<()> {
        let cloud = cloud(positions, scales, rotations, opacities, colors, &harmonics)?;
        let transform = transform(&matrix)?;
        let mut parts = self.parts();
        let cloud = parts.scene.add_splats(cloud).map_err(|e| errors::scene("splats", &e))?;
        let added = parts.scene.add_splat_instance(SplatInstance::new(cloud, transform).with_object(object));
        added.map_err(|e| errors::scene("splats", &e))
    }

    /// Places a mesh. `matrix` is (4, 4), object to world, in the way that columns are multiplied; `object` is the number
    /// that the plane `object-id` shows, less 1.
    fn add_instance(
        &self,
        mesh: usize,
        material: usize,
        matrix: PyReadonlyArray2<'_, f64>,
        object: u32,
    ) -> PyResult<()> {
        let transform = transform(&matrix)?;
        let mut parts = self.parts();
        let (Some(&mesh), Some(&material)) = (parts.meshes.get(mesh), parts.materials.get(material)) else {
            return Err(Kind::Mesh.error("instance: there is no such mesh or material"));
        };
        let added = parts.scene.add_instance(Instance::new(mesh, material, transform).with_object(object));
        added.map_err(|e| errors::scene("instance", &e))
    }

    /// Names an object, for `image.ids`.
    fn name_object(&self, object: u32, name: &str) {
        self.parts().scene.name_object(object, name);
    }

    fn add_light(&self, json: &str) -> PyResult<()> {
        let data: LightData = parsed("light", json)?;
        let LightData { position, direction, range, inner_cone_cosine, outer_cone_cosine, .. } = data;
        let kind = match data.kind.as_str() {
            "directional" => LightKind::Directional { direction },
            "point" => LightKind::Point { position, range },
            _ => LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine },
        };
        let light = Light::new(kind).with(|l| {
            l.color = data.color;
            l.intensity = data.intensity;
        });
        self.parts().scene.add_light(light).map_err(|e| errors::scene("light", &e))
    }

    /// Notes what cannot be shown.
    fn warn(&self, message: String) {
        self.parts().warnings.push(message);
    }

    /// The model; the builder is empty then. `up` is the axis that is up in the arrays, `+y` if it is not given.
    #[pyo3(signature = (up=None))]
    fn finish(&self, up: Option<&str>) -> PyResult<Model> {
        let mut parts = std::mem::take(&mut *self.parts());
        if let Some(name) = up {
            let axis = Axis::from_name(name).ok_or_else(|| {
                let known: Vec<&str> = Axis::ALL.iter().map(|axis| axis.name()).collect();
                Kind::Option.error(format_args!("up '{name}': expected one of {}", known.join(", ")))
            })?;
            parts.scene.stand_up(Orientation { up: axis, front_is_known: false, ..Orientation::default() });
        }
        Ok(Model::new(parts.scene, parts.warnings))
    }
}

impl Parts {
    fn material(&mut self, data: &MaterialData) -> PyResult<Material> {
        let alpha_mode = match data.alpha_mode.as_str() {
            "opaque" => AlphaMode::Opaque,
            "mask" => AlphaMode::Mask { cutoff: data.alpha_cutoff },
            "blend" => AlphaMode::Blend,
            other => {
                let message = format_args!("material: alpha_mode '{other}': expected opaque, mask or blend")
                    .to_string();
                return Err(Kind::Mesh.error(message));
            }
        };
        let alpha = match alpha_mode {
            AlphaMode::Mask { cutoff } => AlphaUse::mask(cutoff / data.base_color[3].max(1e-6)),
            AlphaMode::Blend => AlphaUse::Coverage,
            _ => AlphaUse::Data,
        };
        let color = |parts: &mut Self, texture| parts.texture(texture, ColorSpace::Srgb, AlphaUse::Data);
        let plain = |parts: &mut Self, texture| parts.texture(texture, ColorSpace::Linear, AlphaUse::Data);
        let normal = self.texture(data.normal_texture, ColorSpace::Linear, AlphaUse::Normals)?;
        let mut material = Material::default();
        material.name = data.name.clone();
        material.base_color = data.base_color;
        material.base_color_texture = self.texture(data.base_color_texture, ColorSpace::Srgb, alpha)?;
        material.workflow = Workflow::MetallicRoughness {
            metallic: data.metallic,
            roughness: data.roughness,
            texture: plain(self, data.metallic_roughness_texture)?,
        };
        material.ior = data.ior;
        material.emissive = data.emissive;
        material.emissive_texture = color(self, data.emissive_texture)?;
        material.normal_texture = normal.map(|texture| NormalTexture { texture, scale: data.normal_scale });
        material.occlusion_texture = plain(self, data.occlusion_texture)?;
        material.alpha_mode = alpha_mode;
        material.double_sided = data.double_sided;
        material.unlit = data.unlit;
        Ok(material)
    }

    fn texture(
        &mut self,
        data: Option<TextureData>,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> PyResult<Option<TextureRef>> {
        let Some(data) = data else { return Ok(None) };
        let image = self.images.get(data.image);
        let image = image.ok_or_else(|| Kind::Mesh.error("material: there is no such texture"))?;
        let sampler = sampler(&data);
        let known = |t: &&(usize, Sampler, ColorSpace, AlphaUse, TextureId)| {
            (t.0, t.1, t.2, t.3) == (data.image, sampler, color_space, alpha)
        };
        let id = match self.textures.iter().find(known) {
            Some(known) => known.4,
            None => {
                let texture = image.get().texture((sampler, color_space, alpha));
                let id = self.scene.add_texture(texture).map_err(|e| errors::scene("texture", &e))?;
                self.textures.push((data.image, sampler, color_space, alpha, id));
                id
            }
        };
        Ok(Some(TextureRef { texture: id, uv_set: data.uv_set, transform: UvTransform::IDENTITY }))
    }
}

/// Sampler of a texture, from the numbers of OpenGL that glTF uses.
fn sampler(data: &TextureData) -> Sampler {
    let wrap = |number| match number {
        33071 => Wrap::ClampToEdge,
        33648 => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let (minification, mip) = match data.minification {
        9728 => (Filter::Nearest, MipFilter::None),
        9729 => (Filter::Linear, MipFilter::None),
        9984 => (Filter::Nearest, MipFilter::Nearest),
        9985 => (Filter::Linear, MipFilter::Nearest),
        9986 => (Filter::Nearest, MipFilter::Linear),
        _ => (Filter::Linear, MipFilter::Linear),
    };
    let magnification = if data.magnification == 9728 { Filter::Nearest } else { Filter::Linear };
    Sampler { magnification, minification, mip, wrap_u: wrap(data.wrap_u), wrap_v: wrap(data.wrap_v) }
}
