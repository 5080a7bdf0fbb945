//! Common parts of the formats beside glTF: default materials, meshes within the limits, pictures by
//! name.
use super::budget::Budget;
use super::clay::clay;
use super::encoded_image::EncodedImage;
use super::image::{self, ImageError};
use super::nearby::Nearby;
use super::text::quoted;
use super::{Context, LoadError, Loaded, Warning};
use overcoat_core::limits::Limits;
use overcoat_scene::{
    Instance, MAX_COORDINATE, Material, MaterialId, Mesh, MeshData, MeshId, Scene, Transform, Workflow,
};

/// Material of surfaces without one: clay, drawn from both sides, since the winding of such files cannot be trusted, with the edges of
/// parts, which are of one tone.
pub(super) fn default_material() -> Material {
    clay().with(|m| {
        m.name = "default".to_owned();
        m.double_sided = true;
        m.has_edges = true;
    })
}

/// Material of surfaces of which the file gives only a base colour (linear, with alpha): a satin dielectric, drawn from
/// both sides as well.
pub(super) fn material_of(base_color: [f32; 4]) -> Material {
    let mut material = Material::default().with(|m| {
        m.name = "default".to_owned();
        m.base_color = base_color;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.5, texture: None };
        m.double_sided = true;
    });
    // Coats of these formats return nothing to the base, as in the engines that write them.
    material.lobes.coat.darkening = 0.0;
    material
}

/// Roughness of a highlight by its exponent n: alpha is the root of 2 / (n + 2) (B. Walter et al., *Microfacet Models for
/// Refraction through Rough Surfaces*, 2007, for the Phong distribution).
pub(super) fn phong_roughness(exponent: f32) -> f32 {
    (2.0 / (exponent + 2.0)).sqrt().sqrt()
}

/// The same for meshes with colours of their own, which multiply the base colour.
pub(super) fn white_material() -> Material {
    material_of([1.0; 4]).with(|m| m.name = "vertex colours".to_owned())
}

/// True if a position can be part of a scene.
pub(super) fn drawable(position: [f32; 3]) -> bool {
    position.iter().all(|v| v.abs() <= MAX_COORDINATE)
}

/// Adds a mesh and its only instance, where it stands.
pub(super) fn add_object(
    scene: &mut Scene,
    element: &str,
    data: MeshData,
    material: MaterialId,
    object: u32,
) -> Result<(), LoadError> {
    let mesh = Mesh::new(data).map_err(LoadError::scene(element))?;
    let mesh = scene.add_mesh(mesh).map_err(LoadError::scene(element))?;
    add_placed(scene, element, mesh, material, Transform::IDENTITY, object)
}

/// Places a mesh that the scene has.
pub(super) fn add_placed(
    scene: &mut Scene,
    element: &str,
    mesh: MeshId,
    material: MaterialId,
    transform: Transform,
    object: u32,
) -> Result<(), LoadError> {
    scene
        .add_instance(Instance::new(mesh, material, transform).with_object(object))
        .map_err(LoadError::scene(element))
}

/// Values of the corners of triangles, one after the other, of those of vertices; none where there are none.
pub(super) fn of_corners<T: Copy>(vertices: &[T], triangles: &[[u32; 3]]) -> Vec<T> {
    if vertices.is_empty() {
        return Vec::new();
    }
    triangles.as_flattened().iter().filter_map(|&v| vertices.get(v as usize).copied()).collect()
}

/// Triangles that share no vertex.
pub(super) fn separate_triangles(count: usize) -> Vec<[u32; 3]> {
    let corners = |t: u32| t.saturating_mul(3);
    (0..count as u32).map(corners).map(|a| [a, a.saturating_add(1), a.saturating_add(2)]).collect()
}

/// Checks the sizes of a mesh against the limits, before or while it is built.
pub(super) fn check_mesh(context: &Context<'_>, triangles: u64, vertices: u64) -> Result<(), LoadError> {
    let limits = context.limits;
    Limits::check(|| "the model's triangles".to_owned(), triangles, limits.triangles, "triangles")?;
    Limits::check(|| "the model's vertices".to_owned(), vertices, limits.vertices, "vertices")?;
    // Positions and normals; indices and the list of corners that normals are made from.
    let bytes = vertices.saturating_mul(24).saturating_add(triangles.saturating_mul(24));
    Limits::check(|| "the model".to_owned(), bytes, limits.decoded_bytes, "decoded_bytes")?;
    if bytes >= 1 << 20 {
        Limits::check_memory(|| "the model".to_owned(), bytes)?;
    }
    Ok(())
}

/// Checks the size of the file itself.
pub(super) fn check_input(context: &Context<'_>, bytes: &[u8]) -> Result<(), LoadError> {
    Limits::check(|| "the file".to_owned(), bytes.len() as u64, context.limits.input_bytes, "input_bytes")?;
    Ok(())
}

/// A finished scene; one without triangles says so.
pub(super) fn finish(scene: Scene, mut warnings: Vec<Warning>) -> Loaded {
    if scene.triangle_count() == 0 && scene.splat_count() == 0 {
        warnings.push(Warning::new("the model has no triangles"));
    }
    Loaded { warnings, ..Loaded::from(scene) }
}

/// Reads one picture that the model names, for a texture. The inner error says why it cannot be had.
pub(super) fn read_picture(
    format: &str,
    context: &Context<'_>,
    file: &str,
    budget: &mut Budget,
) -> Result<Result<EncodedImage, String>, LoadError> {
    let what = format!("{format}: texture {}", quoted(file.as_bytes()));
    match Nearby::default().read(context, "", [file], context.limits.input_bytes) {
        Ok(found) => picture_of(what, found.bytes, context, budget),
        Err(error) => Ok(Err(format!("{what} is left out: {error}"))),
    }
}

/// Picture for a texture, called `what` in messages; beyond the budget there is none. The inner error says why it cannot be had.
pub(super) fn picture_of(
    what: String,
    bytes: Vec<u8>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<Result<EncodedImage, String>, LoadError> {
    match image::probe_large(&what, &bytes, context.limits) {
        // Texels, their mip levels and what is made of them.
        Ok(header) => Ok(EncodedImage::charged(what, (bytes, header), 12, budget)
            .map_err(|limit| format!("{limit}; it is left out"))),
        Err(ImageError::Limit(limit)) => Ok(Err(format!("{limit}; it is left out"))),
        Err(ImageError::Damaged(loss)) => Ok(Err(format!("{what} is left out: {loss}"))),
    }
}
