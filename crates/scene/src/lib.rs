//! The resolved scene: all that is drawn, valid by construction.
//!
//! A [`Scene`] is filled by a loader or by hand through its `add_*` methods. Each checks its input (lengths, index
//! ranges, finite numbers, ids that exist), so that no later stage has to: the renderer cannot meet malformed input.
//! World space is glTF's: right-handed, +Y up, metres; colours are linear Rec. 709 unless said otherwise.

mod bounds;
mod camera;
mod changeable;
mod edges;
mod edit;
mod environment;
mod error;
mod face_colors;
mod framing;
mod intrinsics;
mod lazy;
mod light;
mod lobes;
mod material;
mod mesh;
mod mipmap;
mod model;
mod model_options;
mod objects;
mod paint;
pub mod parameters;
mod pose;
pub mod primitives;
mod revision;
mod row_bands;
mod splats;
mod surfels;
mod texture;
mod transform;
mod transmission;

pub use bounds::Bounds;
pub use camera::{Camera, CameraMatrices, Projection};
pub use edges::{CREASE_ANGLE, EdgeGroup, EdgeLines, FeatureEdges, edge_bytes, find_edges};
pub use environment::{Environment, EnvironmentSource, EquirectImage};
pub use error::SceneError;
pub use framing::{Axis, Crowd, Fit, Footing, Framing, Orientation};
pub use intrinsics::Intrinsics;
pub use lazy::{ImageSource, LazyImage, settle};
pub use light::{AreaLightMethod, Light, LightKind};
pub use lobes::{
    Anisotropy, CoatMedium, ColorParameter, Iridescence, Lobes, ReflectionOcclusion, ScalarParameter,
    SecondLobe, Sheen, Subsurface,
};
pub use material::{AlphaMode, Material, NormalTexture, TextureRef, UvTransform, Workflow};
pub use mesh::{MAX_VERTICES, Mesh, MeshData, PrimitiveKind, Surfels};
pub use model::ShadingModel;
pub use model_options::{
    BabylonOptions, DualNormalFix, Filament2018Options, FilamentOptions, GltfOptions, ModelOptions,
    OcclusionCone, OpenPbrOptions, SpecularOcclusionMethod, StackLitOptions, ThreeOptions,
};
pub use paint::{CoatSurface, Flakes};
pub use pose::{Pose, PoseConvention};
pub use revision::Revision;
pub use row_bands::BAND_SHIFT;
pub use splats::rotation_rows;
pub use splats::{
    LEAST_SPLAT_OPACITY, MAX_SPLAT_SCALE, Splat, SplatCloud, SplatCloudBuilder, SplatColorSpace, SplatOrder,
};
pub use surfels::estimate_surfels;
pub use texture::{AlphaUse, ColorSpace, Filter, Image, MipFilter, MipLevel, Sampler, Texture, Wrap};
pub use texture::{LevelLayout, level_size};
pub use transform::Transform;
pub use transmission::Transmission;

use objects::check_object;
use std::collections::BTreeMap;

/// Largest magnitude of a coordinate, in object and in world space. Keeps squares and products of differences
/// finite in single precision.
pub const MAX_COORDINATE: f32 = 1e15;

macro_rules! id {
    ($name:ident, $what:literal) => {
        #[doc = concat!("Names a ", $what, " of one [`Scene`]: its index in the order of adding.")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) u32);
        impl $name {
            /// Id of the element at a position of a scene's list. It is not checked here, but by the scene that it is
            /// used with.
            #[must_use]
            pub const fn from_index(index: u32) -> Self {
                Self(index)
            }
            /// Position in the scene's list.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}
id!(TextureId, "texture");
id!(MaterialId, "material");
id!(MeshId, "mesh");
id!(SplatCloudId, "splat cloud");

/// A mesh placed in the world: one draw.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Instance {
    /// Mesh to draw.
    pub mesh: MeshId,
    /// Material of the mesh.
    pub material: MaterialId,
    /// Object to world space.
    pub transform: Transform,
    /// Groups the draws of one object of the file (a glTF node) for the `object-id` plane.
    pub object: u32,
}

/// A cloud of splats placed in the world.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SplatInstance {
    /// Cloud to draw.
    pub cloud: SplatCloudId,
    /// Object to world space.
    pub transform: Transform,
    /// As [`Instance::object`].
    pub object: u32,
}

impl Instance {
    /// A mesh of a material at a place, of the object 0.
    #[must_use]
    pub fn new(mesh: MeshId, material: MaterialId, transform: Transform) -> Self {
        Self { mesh, material, transform, object: 0 }
    }

    /// The same with another [`Instance::object`].
    #[must_use]
    pub fn with_object(self, object: u32) -> Self {
        Self { object, ..self }
    }
}

impl SplatInstance {
    /// A cloud at a place, of the object 0.
    #[must_use]
    pub fn new(cloud: SplatCloudId, transform: Transform) -> Self {
        Self { cloud, transform, object: 0 }
    }

    /// The same with another [`SplatInstance::object`].
    #[must_use]
    pub fn with_object(self, object: u32) -> Self {
        Self { object, ..self }
    }
}

/// Everything that one picture shows.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    textures: Vec<Texture>,
    materials: Vec<Material>,
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    splats: Vec<SplatCloud>,
    splat_instances: Vec<SplatInstance>,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    camera_names: Vec<String>,
    /// Names of objects, by their numbers.
    object_names: BTreeMap<u32, String>,
    environment: Environment,
    origin: [f64; 3],
    orientation: Orientation,
    revision: Revision,
    lighting: Revision,
}

impl Scene {
    /// An empty scene under the built-in studio environment.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a texture. It is valid already: see [`Texture::new`].
    ///
    /// # Errors
    /// [`SceneError::TooMany`] beyond 2^32 - 1 textures.
    pub fn add_texture(&mut self, texture: Texture) -> Result<TextureId, SceneError> {
        let id = TextureId(next_id(self.textures.len(), "textures")?);
        self.change();
        self.textures.push(texture);
        Ok(id)
    }

    /// Adds a material.
    ///
    /// # Errors
    /// [`SceneError`] if a factor is not finite or out of its range, or a texture does not exist.
    pub fn add_material(&mut self, material: Material) -> Result<MaterialId, SceneError> {
        material.validate(self.textures.len())?;
        let id = MaterialId(next_id(self.materials.len(), "materials")?);
        self.change();
        self.materials.push(material);
        Ok(id)
    }

    /// Adds a mesh. It is valid already: see [`Mesh::new`].
    ///
    /// # Errors
    /// [`SceneError::TooMany`] beyond 2^32 - 1 meshes.
    pub fn add_mesh(&mut self, mesh: Mesh) -> Result<MeshId, SceneError> {
        let id = MeshId(next_id(self.meshes.len(), "meshes")?);
        self.change();
        self.meshes.push(mesh);
        Ok(id)
    }

    /// Places a mesh in the world.
    ///
    /// # Errors
    /// [`SceneError`] if the mesh or the material does not exist, or the transform takes the mesh beyond
    /// [`MAX_COORDINATE`], or the object is number 2^32 - 1.
    pub fn add_instance(&mut self, instance: Instance) -> Result<(), SceneError> {
        let mesh = self
            .meshes
            .get(instance.mesh.index())
            .ok_or(SceneError::NoSuch { what: "mesh", index: instance.mesh.0 })?;
        if instance.material.index() >= self.materials.len() {
            return Err(SceneError::NoSuch { what: "material", index: instance.material.0 });
        }
        check_placed(mesh.bounds(), &instance.transform)?;
        check_object(instance.object)?;
        next_id(self.instances.len(), "instances")?;
        self.change();
        self.instances.push(instance);
        Ok(())
    }

    /// Adds a cloud of splats. It is valid already: see [`SplatCloudBuilder`].
    ///
    /// # Errors
    /// [`SceneError::TooMany`] beyond 2^32 - 1 clouds.
    pub fn add_splats(&mut self, cloud: SplatCloud) -> Result<SplatCloudId, SceneError> {
        let id = SplatCloudId(next_id(self.splats.len(), "splat clouds")?);
        self.change();
        self.splats.push(cloud);
        Ok(id)
    }

    /// Places a cloud of splats in the world.
    ///
    /// # Errors
    /// [`SceneError`] if there is no such cloud, or the transform takes it beyond [`MAX_COORDINATE`].
    pub fn add_splat_instance(&mut self, instance: SplatInstance) -> Result<(), SceneError> {
        let cloud = self.splats.get(instance.cloud.index());
        let cloud = cloud.ok_or(SceneError::NoSuch { what: "splat cloud", index: instance.cloud.0 })?;
        check_placed(cloud.bounds(), &instance.transform)?;
        check_object(instance.object)?;
        next_id(self.splat_instances.len(), "instances")?;
        self.change();
        self.splat_instances.push(instance);
        Ok(())
    }

    /// Adds a light. Its direction may have any length but zero; that in [`Scene::lights`] is a unit vector.
    ///
    /// # Errors
    /// [`SceneError`] if a number of it is not finite or out of its range; [`SceneError::NoLength`] if its direction is
    /// zero.
    pub fn add_light(&mut self, light: Light) -> Result<(), SceneError> {
        self.lights.push(light.checked()?);
        self.relight();
        Ok(())
    }

    /// Adds a camera that a picture may choose.
    ///
    /// # Errors
    /// [`SceneError`] if it looks nowhere or a number of it is not finite or out of its range.
    pub fn add_camera(&mut self, camera: Camera) -> Result<(), SceneError> {
        self.add_named_camera(String::new(), camera)
    }

    /// Adds a camera that a picture may choose by its name.
    ///
    /// # Errors
    /// As [`Scene::add_camera`].
    pub fn add_named_camera(&mut self, name: String, camera: Camera) -> Result<(), SceneError> {
        camera.validate()?;
        self.cameras.push(camera);
        self.camera_names.push(name);
        Ok(())
    }

    /// Replaces the environment.
    ///
    /// # Errors
    /// [`SceneError`] if its rotation or intensity is not finite, or its intensity negative.
    pub fn set_environment(&mut self, environment: Environment) -> Result<(), SceneError> {
        environment.validate()?;
        self.environment = environment;
        self.relight();
        Ok(())
    }

    /// Renews the revision after a change of geometry or materials.
    fn change(&mut self) {
        self.revision = Revision::next();
    }

    /// Renews the revision of lights and environment.
    fn relight(&mut self) {
        self.lighting = Revision::next();
    }

    /// Names its lights and its environment, as [`Scene::revision`] names the rest.
    pub fn lighting(&self) -> Revision {
        self.lighting
    }

    /// Name of its state: textures, materials, meshes and where they are.
    pub fn revision(&self) -> Revision {
        self.revision
    }

    /// Turns everything that a file has placed so far (draws, lights, cameras), in its own coordinates, so that the axis
    /// that is up there becomes +Y and its [front](Orientation::front) +Z. Coordinates and signs are exchanged, no bit is lost.
    pub fn stand_up(&mut self, orientation: Orientation) {
        self.orientation = orientation;
        if orientation.up == Axis::PositiveY && !orientation.is_turned {
            return;
        }
        for instance in &mut self.instances {
            instance.transform = instance.transform.upright(orientation);
        }
        self.change();
        self.relight();
        self.origin = orientation.upright(self.origin);
        for instance in &mut self.splat_instances {
            instance.transform = instance.transform.upright(orientation);
        }
        for light in &mut self.lights {
            *light = framing::orientation::upright_light(light, orientation);
        }
        for camera in &mut self.cameras {
            *camera = framing::orientation::upright_camera(camera, orientation);
        }
    }

    /// The textures, by [`TextureId`].
    #[must_use]
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }
    /// The materials, by [`MaterialId`].
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }
    /// The meshes, by [`MeshId`].
    #[must_use]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }
    /// The draws, in the order of adding. Where two surfaces have the same depth, the earlier draw is seen.
    #[must_use]
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }
    /// The clouds of splats, by [`SplatCloudId`].
    #[must_use]
    pub fn splats(&self) -> &[SplatCloud] {
        &self.splats
    }
    /// Placed clouds of splats, in the order of adding. Of splats at the same distance the first is in front.
    #[must_use]
    pub fn splat_instances(&self) -> &[SplatInstance] {
        &self.splat_instances
    }
    /// Splats, every instance counted.
    #[must_use]
    pub fn splat_count(&self) -> u64 {
        self.splat_instances.iter().map(|i| self.splats[i.cloud.index()].len() as u64).sum()
    }
    /// True if there are splats and nothing else: all light of the picture is as a screen is to show it, and no tone curve is
    /// to change it.
    #[must_use]
    pub fn is_display_referred(&self) -> bool {
        self.splat_count() > 0 && self.instances.is_empty()
    }
    /// The lights beside the environment.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }
    /// The cameras that came with the file.
    #[must_use]
    pub fn cameras(&self) -> &[Camera] {
        &self.cameras
    }
    /// The names of [`Scene::cameras`], in the same order; empty where a camera has none.
    #[must_use]
    pub fn camera_names(&self) -> &[String] {
        &self.camera_names
    }
    /// Environment of the scene.
    #[must_use]
    pub fn environment(&self) -> &Environment {
        &self.environment
    }
    /// True if it has lights or an environment that came with its model: only these overexpose.
    #[must_use]
    pub fn brings_light(&self) -> bool {
        !self.lights.is_empty() || self.environment.of_model
    }
    /// Axes of the file in the scene that it became.
    #[must_use]
    pub fn orientation(&self) -> Orientation {
        self.orientation
    }
    /// Triangles, every instance counted; a line is drawn as two, a point counts as one.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        let count = |mesh: &Mesh| {
            let each = if mesh.kind() == PrimitiveKind::Lines { 2 } else { 1 };
            mesh.primitive_count() as u64 * each
        };
        self.instances.iter().map(|i| count(&self.meshes[i.mesh.index()])).sum()
    }
    /// Number of triangles, lines or points, every instance counted.
    #[must_use]
    pub fn count_of(&self, kind: PrimitiveKind) -> u64 {
        let meshes = self.instances.iter().map(|instance| &self.meshes[instance.mesh.index()]);
        meshes.filter(|mesh| mesh.kind() == kind).map(|mesh| mesh.primitive_count() as u64).sum()
    }
    /// World-space box around all instances that can be seen, or around all if none can: not around those that their
    /// transforms squeeze to nothing or whose material is transparent all over. Empty for an empty scene.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds_with(SplatCloud::bounds)
    }
    /// [`Scene::bounds`] without the parts a camera need not show: splats that are hardly opaque, the few that lie far
    /// from all others, and strays of other kinds ([`Scene::crowd`]).
    #[must_use]
    pub fn shown_bounds(&self) -> Bounds {
        self.crowd().map_or_else(|| self.bounds_with(SplatCloud::shown_bounds), |crowd| crowd.bounds)
    }
    fn bounds_with(&self, of_splats: impl Fn(&SplatCloud) -> &Bounds) -> Bounds {
        let meshes = self.seen_instances().fold(Bounds::EMPTY, |all, i| {
            all.union(&self.meshes[i.mesh.index()].bounds().transformed(&i.transform))
        });
        self.splat_instances.iter().fold(meshes, |all, i| {
            all.union(&of_splats(&self.splats[i.cloud.index()]).transformed(&i.transform))
        })
    }
}

/// `Ok` if a mesh stays within [`MAX_COORDINATE`] where it is placed.
fn check_placed(bounds: &Bounds, transform: &Transform) -> Result<(), SceneError> {
    let bounds = bounds.transformed(transform);
    if !bounds.is_empty() && !bounds.within(f64::from(MAX_COORDINATE)) {
        return Err(SceneError::OutOfRange { what: "world position", limit: MAX_COORDINATE });
    }
    Ok(())
}

/// The id of the next element of a list.
fn next_id(len: usize, what: &'static str) -> Result<u32, SceneError> {
    u32::try_from(len).ok().filter(|&id| id < u32::MAX).ok_or(SceneError::TooMany { what })
}
