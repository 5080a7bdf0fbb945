//! The pictures that `comment TextureFile` names.
//!
//! With several of them the `texnumber` of a face says which is its own (MeshLab's convention, from 0; -1 is none).

use crate::budget::Budget;
use crate::mesh_formats::read_picture;
use crate::shares::Shares;
use crate::splitting::Variants;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, TextureLoading};
use overcoat_core::limits::Limits;
use overcoat_scene::{AlphaUse, ColorSpace, MeshData, Sampler, Scene, TextureRef, UvTransform};
use std::collections::BTreeMap;

/// A part of a mesh, and its texture.
pub(super) type Part = (MeshData, Option<TextureRef>);

/// The mesh by texture. `of_faces` has the number of each triangle's; it is empty where the file says nothing of that, and the
/// first texture is that of all.
///
/// # Errors
/// [`LoadError::Limit`].
pub(super) fn by_texture(
    data: MeshData,
    names: &[String],
    of_faces: &[i64],
    scene: &mut Scene,
    mut reader: Reader<'_>,
    warnings: &mut Warnings,
) -> Result<Vec<Part>, LoadError> {
    if names.is_empty() || data.uvs[0].is_empty() {
        return Ok(vec![(data, None)]);
    }
    if names.len() == 1 || of_faces.is_empty() {
        if names.len() > 1 {
            warnings.add(|| format!("PLY: of {} textures only the first is drawn", names.len()));
        }
        let texture = names.first().map(|name| reader.read(name, scene, warnings)).transpose()?;
        return Ok(vec![(data, texture.flatten())]);
    }
    let count = names.len() as u64;
    Limits::check(
        || "PLY: the number of textures".to_owned(),
        count,
        reader.context.limits.textures,
        "textures",
    )?;
    let mut textures: BTreeMap<Option<usize>, Option<TextureRef>> = BTreeMap::from([(None, None)]);
    let mut missing = 0_u64;
    let mut parts: BTreeMap<Option<usize>, Vec<[u32; 3]>> = BTreeMap::new();
    for (&triangle, &number) in data.triangles.iter().zip(of_faces) {
        let texture = usize::try_from(number).ok().filter(|&texture| texture < names.len());
        missing = missing.saturating_add(u64::from(texture.is_none() && number != -1));
        parts.entry(texture).or_default().push(triangle);
    }
    if missing > 0 {
        let triangles = counted(missing, "triangle");
        warnings.add(|| format!("PLY: {triangles} with a texnumber that no texture has drawn without one"));
    }
    for &number in parts.keys() {
        if let Some(name) = number.and_then(|number| names.get(number)) {
            textures.insert(number, reader.read(name, scene, warnings)?);
        }
    }
    let texture_of = |number: &Option<usize>| textures.get(number).copied().flatten();
    if parts.len() == 1 {
        let texture = parts.keys().next().and_then(texture_of);
        return Ok(vec![(data, texture)]);
    }
    let mut local = Variants::new(data.positions.len(), 1);
    let cut = |(number, triangles): (Option<usize>, Vec<[u32; 3]>)| {
        local.clear();
        (part(&data, triangles, &mut local), texture_of(&number))
    };
    Ok(parts.into_iter().map(cut).collect())
}

/// Some triangles of a mesh with the vertices that they use.
fn part(whole: &MeshData, triangles: Vec<[u32; 3]>, local: &mut Variants<()>) -> MeshData {
    let mut out = MeshData::default().with(|d| d.kind = whole.kind);
    for mut triangle in triangles {
        for vertex in &mut triangle {
            let v = *vertex as usize;
            let Some((number, is_new)) = local.number(v, ()) else { continue };
            if is_new {
                out.positions.extend(whole.positions.get(v));
                out.normals.extend(whole.normals.get(v));
                out.uvs[0].extend(whole.uvs[0].get(v));
                out.colors.extend(whole.colors.get(v));
            }
            *vertex = number;
        }
        out.triangles.push(triangle);
    }
    out
}

/// Files of pictures on their way to textures.
pub(super) struct Reader<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) loading: TextureLoading,
    budget: Budget,
}

impl<'a> Reader<'a> {
    /// A reader that has read nothing.
    pub(super) fn new(context: &'a Context<'a>, loading: TextureLoading, shares: &Shares) -> Self {
        Self { context, loading, budget: Budget::shared(context.limits, shares) }
    }

    /// Reads a picture; none, with a warning, if it cannot be had.
    fn read(
        &mut self,
        name: &str,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureRef>, LoadError> {
        let image = match read_picture("PLY", self.context, name, &mut self.budget)? {
            Ok(image) => image,
            Err(why) => {
                warnings.add_texture(|| why);
                return Ok(None);
            }
        };
        let form = (ColorSpace::Srgb, AlphaUse::Data, Sampler::default());
        let Some(texture) = image.texture(form, self.loading, warnings)? else { return Ok(None) };
        let texture = scene.add_texture(texture).map_err(LoadError::scene("PLY: texture"))?;
        Ok(Some(TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY }))
    }
}

#[cfg(test)]
mod tests {
    use crate::shares::Shares;
    use crate::{Context, Loaded, MemoryResolver, TextureLoading};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::limits::Limits;

    /// A picture of one pixel.
    fn picture(color: [u8; 3]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&color).unwrap();
        writer.finish().unwrap();
        bytes
    }

    /// A face for each number, and the files that there are.
    fn load(numbers: &[i32], names: &[&str], limits: &Limits) -> Loaded {
        let comments: String = names.iter().map(|name| format!("comment TextureFile {name}\n")).collect();
        let faces: String = numbers.iter().map(|n| format!("3 0 1 2 6 0 0 1 0 0 1 {n}\n")).collect();
        let text = format!(
            "ply\nformat ascii 1.0\n{comments}element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
             property int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n{faces}",
            numbers.len()
        );
        let files = [("red.png", [255, 0, 0]), ("green.png", [0, 255, 0]), ("blue.png", [0, 0, 255])];
        let files = files.map(|(name, color)| (name.to_owned(), picture(color))).into();
        let resolver = MemoryResolver { files };
        let context = Context { resolver: &resolver, limits, jobs: &Jobs::new(1) };
        super::super::load(text.as_bytes(), &context, TextureLoading::Whole, &Shares::default()).unwrap()
    }

    /// Triangles of each mesh, and the first texel of its texture.
    fn found(loaded: &Loaded) -> Vec<(usize, Option<[u8; 3]>)> {
        let scene = &loaded.scene;
        let of = |instance: &overcoat_scene::Instance| {
            let texture = scene.materials()[instance.material.index()].base_color_texture;
            let texel = texture.map(|texture| {
                let [r, g, b, _] = scene.textures()[texture.texture.index()].image().texels()[0];
                [r, g, b]
            });
            (scene.meshes()[instance.mesh.index()].triangles().len(), texel)
        };
        scene.instances().iter().map(of).collect()
    }

    #[test]
    fn each_face_has_its_texture() {
        let limits = Limits::default();
        let names = ["red.png", "green.png", "blue.png"];
        let loaded = load(&[2, 0, 2, -1], &names, &limits);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(found(&loaded), [(1, None), (1, Some([255, 0, 0])), (2, Some([0, 0, 255]))]);
        assert_eq!(found(&load(&[1, 1], &names, &limits)), [(2, Some([0, 255, 0]))]);
        // With one texture the number means nothing.
        assert_eq!(found(&load(&[1, 0], &names[..1], &limits)), [(2, Some([255, 0, 0]))]);
    }

    #[test]
    fn textures_that_are_not_there_are_named() {
        let loaded = load(&[0, 1, 7], &["red.png", "gone.png"], &Limits::default());
        assert_eq!(found(&loaded), [(1, None), (1, Some([255, 0, 0])), (1, None)]);
        let messages: Vec<&str> = loaded.warnings.iter().map(|warning| warning.message.as_str()).collect();
        assert!(messages[0].contains("1 triangle with a texnumber"), "{messages:?}");
        assert!(messages.len() == 2 && messages[1].contains("gone.png"), "{messages:?}");
    }
}
