//! What is done about extensions that a file uses or requires.

use super::FORMAT;
use super::model::Root;
use crate::load::LoadError;
use crate::load::warnings::Warnings;

/// Extensions that are drawn as meant, or that do not concern the picture.
const DRAWN: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Extensions whose absence changes how surfaces look or move, but not what is there. Files may require them and
/// are drawn all the same, with a warning.
const LOOK: &[(&str, &str)] = &[
    ("EXT_lights_image_based", "the chosen environment is used instead"),
    ("KHR_materials_diffuse_transmission", "drawn without light from behind"),
    ("KHR_materials_dispersion", "drawn without dispersion"),
    ("KHR_materials_transmission", "drawn without light passing through"),
    ("KHR_materials_volume", "drawn without absorption"),
];

/// Extensions that hold the data itself. A file that requires one is refused; one that merely uses it has a
/// substitute.
const DATA: &[(&str, &str)] = &[
    ("EXT_meshopt_compression", "the uncompressed buffers are used"),
    ("EXT_texture_avif", "the substitute images are used"),
    ("KHR_draco_mesh_compression", "the uncompressed accessors are used"),
    ("KHR_meshopt_compression", "the uncompressed buffers are used"),
    ("KHR_texture_basisu", "the substitute images are used"),
    ("MSFT_lod", "the most detailed level is drawn"),
    ("MSFT_texture_dds", "the substitute images are used"),
];

/// Warns of every extension that is used and not drawn, once each.
///
/// # Errors
/// [`LoadError::Unsupported`] naming all extensions that are required and without which the picture would miss
/// something.
pub(super) fn check(root: &Root, warnings: &mut Warnings) -> Result<(), LoadError> {
    let mut lacking: Vec<String> = root
        .extensions_required
        .iter()
        .filter(|name| !DRAWN.contains(&name.as_str()) && !is_look(name))
        .map(|name| printable(name))
        .collect();
    lacking.dedup();
    if !lacking.is_empty() {
        lacking.truncate(20);
        let list = lacking.join(", ");
        return Err(LoadError::unsupported(
            FORMAT,
            format!("the file requires {list}, which cannot be read"),
        ));
    }
    let mut seen: Vec<&str> = Vec::new();
    for name in root.extensions_used.iter().chain(&root.extensions_required).take(1000) {
        if DRAWN.contains(&name.as_str()) || seen.contains(&name.as_str()) {
            continue;
        }
        seen.push(name);
        let known = LOOK.iter().chain(DATA).find(|(known, _)| known == name);
        warnings.add(|| match known {
            Some((_, instead)) => format!("{name} is not supported: {instead}"),
            None => format!("{} is not known and has no effect", printable(name)),
        });
    }
    Ok(())
}

/// True for everything about materials: the geometry is intact without it.
fn is_look(name: &str) -> bool {
    name.contains("_materials_") || LOOK.iter().any(|(known, _)| *known == name)
}

/// Fit for a line of text.
fn printable(name: &str) -> String {
    name.chars().take(64).map(|c| if c.is_control() { '?' } else { c }).collect()
}
