//! Building blocks of the test scenes.

use super::images;
use overcoat::scene::{
    AlphaUse, Camera, ColorSpace, Environment, EnvironmentSource, EquirectImage, Image, Instance, Light,
    LightKind, Material, MaterialId, Mesh, MeshData, MeshId, Projection, Sampler, Scene, SceneError, Texture,
    TextureId, TextureRef, Transform, UvTransform, Workflow,
};
use std::error::Error;
use std::sync::{Arc, OnceLock};

/// Result of a scene function.
pub type Built = Result<(Scene, Camera), Box<dyn Error>>;

/// A scene that is being filled.
pub struct Stage {
    /// The scene so far.
    pub scene: Scene,
}

impl Stage {
    /// Under the sky of [`images::sky`], the same picture in every scene: renderers filter it once.
    pub fn new() -> Result<Self, SceneError> {
        static SKY: OnceLock<Result<Arc<EquirectImage>, SceneError>> = OnceLock::new();
        Self::under(SKY.get_or_init(|| images::sky().map(Arc::new)).clone()?)
    }

    /// Without any light.
    pub fn dark() -> Result<Self, SceneError> {
        let mut scene = Scene::new();
        scene.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None))?;
        Ok(Self { scene })
    }

    /// Under an environment.
    pub fn under(sky: Arc<EquirectImage>) -> Result<Self, SceneError> {
        let mut scene = Scene::new();
        let source = EnvironmentSource::Image(sky);
        scene.set_environment(Environment::default().with(|e| e.source = source))?;
        Ok(Self { scene })
    }

    pub fn mesh(&mut self, data: MeshData) -> Result<MeshId, SceneError> {
        self.scene.add_mesh(Mesh::new(data)?)
    }

    pub fn material(&mut self, material: Material) -> Result<MaterialId, SceneError> {
        self.scene.add_material(material)
    }

    pub fn place(
        &mut self,
        mesh: MeshId,
        material: MaterialId,
        transform: Transform,
    ) -> Result<(), SceneError> {
        let object = self.scene.instances().len() as u32;
        self.scene.add_instance(Instance::new(mesh, material, transform).with_object(object))
    }

    /// Puts the meshes of another scene into this one.
    pub fn add(&mut self, other: &Scene, place: Transform) -> Result<(), Box<dyn Error>> {
        let textures = other.textures().iter().map(|texture| self.scene.add_texture(texture.clone()));
        let textures: Vec<TextureId> = textures.collect::<Result<_, _>>()?;
        let mut materials = Vec::new();
        for material in other.materials() {
            let mut material = material.clone();
            let count = material.textures().count();
            if let Some(texture) = &mut material.base_color_texture {
                texture.texture = textures[texture.texture.index()];
            }
            if count > usize::from(material.base_color_texture.is_some()) {
                return Err("only textures of the base colour can be put into another scene".into());
            }
            materials.push(self.material(material)?);
        }
        let meshes = other.meshes().iter().map(|mesh| self.scene.add_mesh(mesh.clone()));
        let meshes: Vec<MeshId> = meshes.collect::<Result<_, _>>()?;
        for instance in other.instances() {
            let transform = place.after(&instance.transform)?;
            self.place(meshes[instance.mesh.index()], materials[instance.material.index()], transform)?;
        }
        Ok(())
    }

    /// A texture of colours, opaque.
    pub fn colors(&mut self, image: Image, sampler: Sampler) -> Result<TextureRef, SceneError> {
        self.texture(image, ColorSpace::Srgb, AlphaUse::Data, sampler)
    }

    /// A texture of numbers.
    pub fn data(&mut self, image: Image) -> Result<TextureRef, SceneError> {
        self.texture(image, ColorSpace::Linear, AlphaUse::Data, Sampler::default())
    }

    pub fn texture(
        &mut self,
        image: Image,
        color_space: ColorSpace,
        alpha: AlphaUse,
        sampler: Sampler,
    ) -> Result<TextureRef, SceneError> {
        let texture = self.scene.add_texture(Texture::new(Arc::new(image), color_space, alpha, sampler))?;
        Ok(TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY })
    }

    /// A directional light from the upper left front, in lux.
    pub fn key_light(&mut self, intensity: f32) -> Result<(), SceneError> {
        let direction = [0.6, -0.64, -0.48];
        self.scene.add_light(Light::new(LightKind::Directional { direction }).with(|l| {
            l.color = [1.0; 3];
            l.intensity = intensity;
        }))
    }

    pub fn seen(self, camera: Camera) -> Built {
        Ok((self.scene, camera))
    }
}

/// Scales, then moves.
pub fn at(position: [f64; 3], scale: f64) -> Result<Transform, SceneError> {
    Transform::from_parts(position, [0.0, 0.0, 0.0, 1.0], [scale; 3])
}

/// Scales, turns about an axis (of unit length) by twice the angle whose sine and cosine are given, then moves.
pub fn turned(
    position: [f64; 3],
    axis: [f64; 3],
    half_angle: [f64; 2],
    scale: f64,
) -> Result<Transform, SceneError> {
    let [sin, cos] = half_angle;
    Transform::from_parts(position, [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos], [scale; 3])
}

/// A perspective camera, +Y up; field of view in degrees.
pub fn look(eye: [f32; 3], target: [f32; 3], fov_y: f32) -> Camera {
    let projection = Projection::Perspective { fov_y: fov_y.to_radians() };
    Camera::new(eye, target, [0.0, 1.0, 0.0], projection, 0.01)
}

/// A parallel projection along -Z that shows the square of side 2 around the origin.
pub fn flat_view() -> Camera {
    Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Orthographic { height: 2.0 }, 0.01)
}

/// Base colour only: what light falls on cannot change it.
pub fn unlit(r: f32, g: f32, b: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.unlit = true;
    })
}

/// A dielectric.
pub fn plastic(r: f32, g: f32, b: f32, roughness: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
    })
}

/// A metal.
pub fn metal(r: f32, g: f32, b: f32, roughness: f32) -> Material {
    plastic(r, g, b, roughness)
        .with(|m| m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness, texture: None })
}
