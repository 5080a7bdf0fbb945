//! Surfaces that let part of the light pass: blended ones, and those that transmit it.
//!
//! A crossing leaves of each colour 1 - p + p t (1 - F) c, with the presence p (alpha), the share t of what enters that passes
//! straight through, Schlick's F at the angle of incidence and the base colour c. Only fronts are coloured, and both sides of
//! what is double-sided, like a picture of them: where [`Material::refracts`] the picture shows one of the two surfaces of a
//! closed body alone, so that each counts by the square root of its colour. A volume absorbs along the way between its
//! surfaces (`tint_map.rs`), and reflects a part within (`tint_body.rs`). Light is neither bent nor gathered: caustics have the
//! mean brightness of their surroundings.

use super::blockers::nearest_texel;
use super::of_scene::small_level;
use super::tint_body::facets;
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_core::each;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{
    AlphaMode, Instance, Material, Mesh, PrimitiveKind, Scene, Texture, TextureRef, Workflow, Wrap,
};
use std::sync::Arc;

/// Most texels of an image are the square of this; of a larger texture, a smaller mip level is taken.
const SIDE: u32 = 256;

/// Textures that a crossing reads: base colour with alpha, transmission, metallic.
const IMAGES: usize = 3;

/// Surfaces that tint light, in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tinted {
    /// Corners. Triangles with a corner that is not finite tint nothing.
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) filters: Vec<Filter>,
}

/// Image of a texture at the resolution that maps can show.
#[derive(Clone, Debug, PartialEq)]
struct SmallImage {
    size: [usize; 2],
    texels: Vec<[u8; 4]>,
    wrap: [Wrap; 2],
}

/// The triangles of one instance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Filter {
    /// Three of [`Tinted::positions`], counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex colours at the corners of each triangle; empty without any.
    colors: Vec<[[f32; 4]; 3]>,
    /// Texture coordinates of each image at the corners of each triangle; empty without images.
    uvs: Vec<[[[f32; 2]; 3]; IMAGES]>,
    images: [Option<Arc<SmallImage>>; IMAGES],
    base_color: [f32; 4],
    alpha_mode: AlphaMode,
    two_sided: bool,
    /// One of the two surfaces of a body is seen alone.
    refracts: bool,
    /// Share of what enters that passes, and the channel of its image.
    transmission: (f32, usize),
    metallic: f32,
    /// Reflectance at normal incidence.
    f0: f32,
    /// Index of refraction.
    pub ior: f32,
    /// Triangles of volumes that bend light: true where the surface is flat. Empty for all others.
    pub facets: Vec<bool>,
    /// Extinction per unit of length beneath the surface, if there is a volume.
    pub extinction: Option<[f32; 3]>,
    /// Thickness of that volume where the surface is not closed, in units of the world.
    pub thickness: f32,
}

/// A place on a triangle where light crosses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Number of the triangle.
    pub triangle: usize,
    pub barycentrics: [f32; 3],
    /// Cosine of the angle of incidence, 0 to 1.
    pub cosine: f32,
    /// Light falls on the front.
    pub is_front: bool,
}

/// True if light that crosses surfaces of a material is tinted, and not blocked or let by.
pub fn tints(material: &Material) -> bool {
    material.is_transmissive() || material.alpha_mode == AlphaMode::Blend
}

/// The textures whose texels decide about the tint of a material.
pub fn textures_of_tint(material: &Material) -> impl Iterator<Item = TextureRef> {
    read_textures(material).into_iter().flatten()
}

fn read_textures(material: &Material) -> [Option<TextureRef>; IMAGES] {
    let transmits = material.is_transmissive();
    let metallic = match &material.workflow {
        Workflow::MetallicRoughness { texture, .. } => *texture,
        Workflow::SpecularGlossiness { .. } => None,
    };
    let through = |texture: Option<TextureRef>| texture.filter(|_| transmits);
    [
        material.base_color_texture.filter(|_| tints(material)),
        through(material.lobes.transmission.factor.texture),
        through(metallic),
    ]
}

impl Tinted {
    /// The surfaces of a scene that tint light: triangles of blended and transmissive materials.
    ///
    /// # Errors
    /// [`LimitExceeded`] if they would take more than [`Limits::frame_bytes`].
    pub fn of_scene(scene: &Scene, limits: &Limits) -> Result<Self, LimitExceeded> {
        let instances = || {
            scene.seen_draws().map(|(_, instance)| instance).filter(|instance| {
                tints(&scene.materials()[instance.material.index()])
                    && scene.meshes()[instance.mesh.index()].kind() == PrimitiveKind::Triangles
            })
        };
        let bytes = instances().fold(0_u64, |sum, instance| {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let of_triangle = size_of::<[u32; 3]>()
                + size_of::<bool>()
                + usize::from(!mesh.colors().is_empty()) * size_of::<[[f32; 4]; 3]>()
                + size_of::<[[[f32; 2]; 3]; IMAGES]>();
            let own = mesh.triangles().len().saturating_mul(of_triangle)
                + size_of_val(mesh.positions())
                + IMAGES * (SIDE as usize).pow(2) * size_of::<[u8; 4]>();
            sum.saturating_add(own as u64)
        });
        let what = || "triangles that tint light".to_owned();
        Limits::check(what, bytes, limits.frame_bytes, "frame_bytes")?;
        Limits::check_memory(what, bytes)?;
        let mut out = Self::default();
        // By textures: their small images, once they have been made.
        let mut images: Vec<Option<Arc<SmallImage>>> = vec![None; scene.textures().len()];
        for instance in instances() {
            out.add(scene, instance, &mut images);
        }
        Ok(out)
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.filters.is_empty()
    }

    /// Bytes that they take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let of_filter = |filter: &Filter| {
            size_of_val(filter.triangles.as_slice())
                + size_of_val(filter.colors.as_slice())
                + size_of_val(filter.uvs.as_slice())
                + size_of_val(filter.facets.as_slice())
        };
        let lists: usize = self.filters.iter().map(of_filter).sum();
        (lists + size_of_val(self.positions.as_slice())) as u64
    }

    fn add(&mut self, scene: &Scene, instance: &Instance, images: &mut [Option<Arc<SmallImage>>]) {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let material = &scene.materials()[instance.material.index()];
        let mut references = read_textures(material);
        if !material.is_transmissive() {
            // Alpha alone is read.
            references[0] = references[0].filter(|read| !scene.textures()[read.texture.index()].is_opaque());
        }
        let Some(filter) = Filter::new(material, instance) else { return };
        let first = self.positions.len() as u32;
        let used = mesh.used_vertices();
        self.positions.extend(mesh.positions().iter().enumerate().map(|(k, vertex)| {
            let is_used = used.as_ref().is_none_or(|used| used[k]);
            // Vertices that no triangle uses are no numbers, and widen no bounds.
            if is_used {
                instance.transform.point(vertex.map(f64::from)).map(|c| c as f32)
            } else {
                [f32::NAN; 3]
            }
        }));
        let turned = instance.transform.determinant() < 0.0;
        let ordered = |&[a, b, c]: &[u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
        let corners = || mesh.triangles().iter().map(ordered);
        let mut filter = Filter {
            triangles: corners().map(|triangle| triangle.map(|v| v + first)).collect(),
            facets: facets(mesh, material),
            ..filter
        };
        if !mesh.colors().is_empty() {
            filter.colors = corners().map(|corners| corners.map(|v| mesh.colors()[v as usize])).collect();
        }
        if references.iter().any(Option::is_some) {
            filter.uvs = corners()
                .map(|corners| references.map(|reference| corners.map(|v| uv(mesh, reference.as_ref(), v))))
                .collect();
        }
        filter.images = references.map(|reference| {
            let number = reference?.texture.index();
            let made = || Arc::new(SmallImage::of(&scene.textures()[number]));
            Some(images.get_mut(number)?.get_or_insert_with(made).clone())
        });
        self.filters.push(filter);
    }
}

/// Texture coordinates of a vertex, as a texture reads them.
fn uv(mesh: &Mesh, reference: Option<&TextureRef>, vertex: u32) -> [f32; 2] {
    let Some(reference) = reference else { return [0.0; 2] };
    let uvs = mesh.uvs(usize::from(reference.uv_set));
    let [u, v] = uvs.get(vertex as usize).copied().unwrap_or([0.0; 2]);
    reference.transform.rows.map(|row| (row[0] * u + row[1] * v) + row[2])
}

impl Filter {
    /// The filter of a material on an instance, without triangles; `None` if it lets all light by.
    fn new(material: &Material, instance: &Instance) -> Option<Self> {
        let clear = material.alpha_mode == AlphaMode::Blend && material.base_color[3] <= 0.0;
        if clear {
            return None;
        }
        let transmission = &material.lobes.transmission;
        let volume = material.is_transmissive() && transmission.has_volume();
        let extinction = Some(transmission.extinction()).filter(|sum| volume && *sum != [0.0; 3]);
        let metallic = match material.workflow {
            Workflow::MetallicRoughness { metallic, .. } => metallic,
            Workflow::SpecularGlossiness { .. } => 0.0,
        };
        let thickness = transmission.thickness.factor * instance.transform.uniform_scale() as f32;
        Some(Self {
            triangles: Vec::new(),
            colors: Vec::new(),
            uvs: Vec::new(),
            images: [const { None }; IMAGES],
            base_color: material.base_color,
            alpha_mode: material.alpha_mode,
            two_sided: material.double_sided,
            refracts: material.refracts(),
            transmission: match material.is_transmissive() {
                true => (transmission.factor.factor, usize::from(transmission.factor.channel & 3)),
                false => (0.0, 0),
            },
            metallic,
            f0: material.dielectric_f0(),
            ior: material.ior,
            facets: Vec::new(),
            extinction,
            thickness,
        })
    }

    /// True if transmittance does not depend on the place.
    pub(super) fn is_uniform(&self) -> bool {
        self.colors.is_empty() && self.uvs.is_empty()
    }

    /// Transmittance of each colour where light crosses a triangle, without what a volume absorbs.
    pub(super) fn transmittance(&self, crossing: &Crossing) -> [f32; 3] {
        let colored = crossing.is_front || self.two_sided;
        let reflected = {
            let grazing = 1.0 - crossing.cosine;
            let square = grazing * grazing;
            // An index of 1 is no interface.
            let rest = if self.f0 > 0.0 { 1.0 - self.f0 } else { 0.0 };
            self.f0 + rest * (square * square * grazing)
        };
        if !colored {
            // Light leaves a body by its inner side.
            let left = if self.transmission.0 > 0.0 { 1.0 - reflected } else { 1.0 };
            return [left; 3];
        }
        let read = |image: usize| self.texel(image, crossing);
        let mut color = self.base_color;
        if let Some(corners) = self.colors.get(crossing.triangle) {
            let b = crossing.barycentrics;
            let mean = |k: usize| (corners[0][k] * b[0] + corners[1][k] * b[1]) + corners[2][k] * b[2];
            color = each!(k => color[k] * mean(k));
        }
        if let Some([r, g, b, a]) = read(0) {
            color = [
                color[0] * srgb8_to_linear(r),
                color[1] * srgb8_to_linear(g),
                color[2] * srgb8_to_linear(b),
                color[3] * unit(a),
            ];
        }
        let presence = match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Blend => clamped(color[3]),
            AlphaMode::Mask { cutoff } => f32::from(u8::from(color[3] >= cutoff)),
        };
        let (mut straight, channel) = self.transmission;
        if straight > 0.0 {
            let metallic = self.metallic * read(2).map_or(1.0, |texel| unit(texel[2]));
            straight *= read(1).map_or(1.0, |texel| unit(texel[channel])) * (1.0 - clamped(metallic));
        }
        let entering = straight * (1.0 - reflected);
        let halved = self.refracts && self.two_sided;
        std::array::from_fn(|k| {
            let c = clamped(color[k]);
            let c = if halved { c.sqrt() } else { c };
            clamped((1.0 - presence) + presence * (entering * c))
        })
    }

    /// The texel of an image at a crossing; `None` without that image.
    fn texel(&self, image: usize, crossing: &Crossing) -> Option<[u8; 4]> {
        let uvs = &self.uvs.get(crossing.triangle)?[image];
        let b = crossing.barycentrics;
        let place = [0, 1].map(|k| (uvs[0][k] * b[0] + uvs[1][k] * b[1]) + uvs[2][k] * b[2]);
        self.images[image].as_ref()?.nearest(place)
    }
}

/// A share of 255.
fn unit(code: u8) -> f32 {
    f32::from(code) * (1.0 / 255.0)
}

/// A number kept to 0 to 1; 0 of what is none.
fn clamped(x: f32) -> f32 {
    if x > 0.0 { if x < 1.0 { x } else { 1.0 } } else { 0.0 }
}

impl SmallImage {
    /// The largest level of a texture with few enough texels.
    fn of(texture: &Texture) -> Self {
        let sampler = texture.sampler();
        let (size, texels) = small_level(texture, SIDE);
        Self { size, texels, wrap: [sampler.wrap_u, sampler.wrap_v] }
    }

    fn nearest(&self, uv: [f32; 2]) -> Option<[u8; 4]> {
        self.texels.get(nearest_texel(self.size, self.wrap, uv)).copied()
    }
}
