//! Handling of the extensions that a file uses or requires.

use super::FORMAT;
use super::model::Root;
use crate::LoadError;
use crate::warnings::Warnings;

/// Extensions that are drawn as meant, or that do not concern the picture.
const DRAWN: &[&str] = &[
    "EXT_instance_features",
    "EXT_materials_clearcoat_color",
    "EXT_materials_clearcoat_darkening",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_gaussian_splatting",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_clearcoat_color",
    "KHR_materials_clearcoat_darkening",
    "KHR_materials_clearcoat_ior",
    "KHR_materials_coat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "VRMC_node_constraint",
    "VRMC_springBone",
    "VRMC_vrm",
];

/// Extensions whose absence changes how surfaces look or move, but not what is there. Files may require them and
/// are drawn all the same, with a warning.
const LOOK: &[(&str, &str)] = &[
    ("EXT_lights_ies", "such lights shine evenly"),
    ("EXT_lights_image_based", "the chosen environment is used instead"),
    ("KHR_materials_volume_scatter", "drawn without scattering"),
    ("VRM", "the avatar is drawn with glTF's materials, without toon shading"),
];

/// Extensions that hold the data itself. A file that merely uses one has a substitute; one that requires it is drawn
/// without what depends on it.
const DATA: &[(&str, &str)] = &[
    ("EXT_texture_avif", "the substitute images are used"),
    ("MSFT_lod", "the most detailed level is drawn"),
    ("MSFT_texture_dds", "the substitute images are used"),
];

/// Warns of every extension that is used and not drawn, once each: other programs draw such files too. The names of those
/// that the file requires and that may hold what is to be drawn, for the message if nothing is left.
pub(super) fn check(root: &Root, warnings: &mut Warnings) -> Option<LoadError> {
    let mut lacking: Vec<String> = root
        .extensions_required
        .iter()
        .filter(|name| !DRAWN.contains(&name.as_str()) && !is_look(name))
        .map(|name| printable(name))
        .collect();
    lacking.dedup();
    lacking.truncate(20);
    let required = |name: &str| root.extensions_required.iter().any(|required| required == name);
    let mut seen: Vec<&str> = Vec::new();
    for name in root.extensions_used.iter().chain(&root.extensions_required).take(1000) {
        if DRAWN.contains(&name.as_str()) || seen.contains(&name.as_str()) {
            continue;
        }
        seen.push(name);
        let known = LOOK.iter().chain(DATA).find(|(known, _)| known == name);
        warnings.add(|| match known {
            Some((_, instead)) => format!("{name} is not supported: {instead}"),
            None if required(name) && !is_look(name) => {
                format!(
                    "the file requires {}, which is not known: drawn without what depends on it",
                    printable(name)
                )
            }
            None => format!("{} is not known and has no effect", printable(name)),
        });
    }
    let list = lacking.join(", ");
    let message = format!("the file requires {list}, which cannot be read");
    (!list.is_empty()).then(|| LoadError::unsupported(FORMAT, message))
}

/// True for avatars of VRM 0, which face -Z; those of VRM 1 (`VRMC_vrm`) face +Z, as glTF has it. Files that are both are
/// taken as the newer one.
///
/// Sources: VRM 0.0 specification, "Coordinate system"; VRM 1.0 specification, `VRMC_vrm-1.0/README.md`.
pub(super) fn is_vrm0(root: &Root) -> bool {
    let uses = |name: &str| root.extensions_used.iter().any(|used| used == name);
    let is = |name: &str, own: bool| own || uses(name);
    let extensions = &root.extensions;
    is("VRM", extensions.vrm0.is_some()) && !is("VRMC_vrm", extensions.vrm1.is_some())
}

/// True for everything about materials: the geometry is intact without it.
fn is_look(name: &str) -> bool {
    name.contains("_materials_") || LOOK.iter().any(|(known, _)| *known == name)
}

/// Fit for a line of text.
fn printable(name: &str) -> String {
    name.chars().take(64).map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The guide's table has a row for each extension of the lists above, and no other says that something is done.
    #[test]
    fn the_guide_says_the_same() {
        let guide = include_str!("../../../../src/guide/formats.md");
        let rows: Vec<(&str, &str)> = guide
            .lines()
            .filter_map(|line| {
                let mut cells = line.strip_prefix("| `")?.split('|').map(str::trim);
                Some((cells.next()?.trim_end_matches('`'), cells.next()?))
            })
            .filter(|(name, _)| {
                name.split('_').next().is_some_and(|p| ["KHR", "EXT", "MSFT", "VRM", "VRMC"].contains(&p))
            })
            .collect();
        let names = |list: &[(&'static str, &str)]| list.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        for (list, state) in [
            (DRAWN.to_vec(), &["drawn", "no part of the picture"][..]),
            (names(LOOK), &["left out, with a warning"]),
            (names(DATA), &["left out, with a warning"]),
        ] {
            let mut sorted = list.clone();
            sorted.sort_unstable();
            assert_eq!(list, sorted);
            for name in list {
                let found: Vec<&str> = rows.iter().filter(|row| row.0 == name).map(|row| row.1).collect();
                assert!(found.len() == 1 && state.contains(&found[0]), "{name} is {found:?} in the guide");
            }
        }
        for (name, state) in &rows {
            let listed = DRAWN.contains(name) || LOOK.iter().chain(DATA).any(|(known, _)| known == name);
            assert!(listed, "{name}: the guide says '{state}', the loader does not know it");
        }
        // Every substitute of the loader's warnings is in the row.
        for (name, instead) in LOOK.iter().chain(DATA) {
            let row = guide.lines().find(|line| line.starts_with(&format!("| `{name}`"))).unwrap_or("");
            assert!(row.contains(instead), "{name}: '{instead}' is not in '{row}'");
        }
    }
}
