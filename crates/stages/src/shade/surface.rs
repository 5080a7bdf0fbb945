//! Material and geometry of sixteen fragments: everything that the shading models read.

use super::ShadeContext;
use super::lobes::LobeValues;
use super::normals::{NormalFrame, geometric_normal, normal_change, normalize_or};
use super::reader::{Coordinates, Reader, ReadingPlan, coordinates};
use super::record::{get_vector, put};
use super::variation::{NormalFilter, NormalVariation, mapped_variance, normal_filter};
use crate::gbuffer::layout::{self, SurfacePlanes};
use crate::gbuffer::texture::{Fetched, SamplePlan};
use crate::gbuffer::{Batch, Location, locate};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{AlphaMode, Material, Mesh, Texture, TextureRef, Workflow};

/// Reflectance of the base in the workflow of its material.
#[derive(Clone, Copy)]
pub enum Reflectance<L: Lanes> {
    /// Metallic 0 to 1 and the F0 of its dielectric part.
    Metallic {
        /// 0 dielectric to 1 metal.
        metallic: L::F,
        /// Its dielectric part.
        dielectric: Dielectric<L>,
    },
    /// F0 as a colour.
    Specular {
        /// Reflectance at normal incidence.
        f0: V3<L>,
    },
}

/// The dielectric part of a base in the terms of KHR_materials_ior and KHR_materials_specular.
#[derive(Clone, Copy)]
pub struct Dielectric<L: Lanes> {
    /// F0 of the index of refraction, ((n - 1) / (n + 1))^2; exactly 0.04 for 1.5, the constant of Unity's
    /// `kDielectricSpec`.
    pub f0_of_ior: f32,
    /// Linear colour that multiplies it.
    pub color: V3<L>,
    /// Weight of the reflection, 0 to 1.
    pub weight: L::F,
}

impl<L: Lanes> Dielectric<L> {
    /// `min(f0 * colour, 1)`, before the weight.
    #[inline(always)]
    pub fn f0(&self, _: L) -> V3<L> {
        (self.color * self.f0_of_ior).at_most(1.0)
    }

    /// `min(f0 * colour, 1) * weight`.
    #[inline(always)]
    pub fn weighted_f0(&self, l: L) -> V3<L> {
        let f0 = self.f0(l);
        f0 * self.weight
    }
}

/// Sixteen surface fragments. Directions are in world space, colours linear.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Position in world space.
    pub position: V3<L>,
    /// Unit vector towards the viewer.
    pub view: V3<L>,
    /// Unit normal of the base, N.V >= 0.
    pub normal: V3<L>,
    /// Unit normal of the clear coat, N.V >= 0.
    pub coat_normal: V3<L>,
    /// Unit normal before normal maps: the horizon of reflections.
    pub vertex_normal: V3<L>,
    /// Base (or diffuse) colour.
    pub base_color: V3<L>,
    /// Opacity; 1 for opaque materials.
    pub alpha: L::F,
    /// Reflectance of the base.
    pub reflectance: Reflectance<L>,
    /// Perceptual roughness of the base, 0 to 1.
    pub roughness: L::F,
    /// Ambient occlusion, 1 where nothing occludes.
    pub occlusion: L::F,
    /// Emitted radiance.
    pub emissive: V3<L>,
    /// Clear coat mask, 0 to 1.
    pub coat: L::F,
    /// Perceptual roughness of the coat, 0 to 1.
    pub coat_roughness: L::F,
    /// Unit vector in the surface along which highlights are stretched or squeezed, perpendicular to the normal.
    pub tangent: V3<L>,
    /// Normal x tangent, with the sign of the texture coordinates.
    pub bitangent: V3<L>,
    /// Unit mean of the directions that are not occluded; [`Surface::normal`] where the material has no map of it.
    pub bent_normal: V3<L>,
    /// Attributes beyond base, coat and emission.
    pub lobes: LobeValues<L>,
    /// Texture coordinates of set 0.
    pub uv: [L::F; 2],
    /// Perceptual roughness of the base as light that the coat sends back meets it, 0 to 1, where that is another: of a flake that of
    /// all flakes.
    pub trapped_roughness: Option<L::F>,
    /// Distance along the view direction.
    pub distance: L::F,
    /// The depth that the rasterizer compares.
    pub depth: L::F,
}

/// Opacity of a batch: base colour's alpha, texture and vertex colour.
#[inline(always)]
pub(super) fn opacity<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
) -> L::F {
    opacity_at(l, context, material, batch, &locate(l, batch, context.rays.perspective))
}

#[inline(always)]
fn opacity_at<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    location: &Location<L>,
) -> L::F {
    let mut alpha = l.splat(material.base_color[3]);
    if let Some(texture) = &material.base_color_texture {
        let coordinates = coordinates(l, context, batch, location);
        let reader = Reader::new(l, context, &coordinates, batch);
        alpha = alpha * reader.read(texture)[3];
    }
    if has_colors(context, batch) {
        let colors = batch.vertices.attribute(l, context.draws, [1.0; 4], Mesh::colors);
        alpha = alpha * location.interpolate(&colors)[3];
    }
    alpha
}

/// Opacity at points that rays hit, by their barycentric weights: of the finest texels.
#[inline(always)]
pub(super) fn hit_opacity<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    barycentric: [L::F; 2],
) -> L::F {
    let location = Location { barycentric, ..Location::none(l) };
    opacity_at(l, context, material, batch, &location)
}

/// Base colour and opacity at points that rays hit, by their barycentric weights: of the finest texels.
#[inline(always)]
pub(super) fn hit_color<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    barycentric: [L::F; 2],
) -> [L::F; 4] {
    let location = Location { barycentric, ..Location::none(l) };
    let mut color = material.base_color.map(|c| l.splat(c));
    if let Some(texture) = &material.base_color_texture {
        let coordinates = coordinates(l, context, batch, &location);
        let texel = Reader::new(l, context, &coordinates, batch).read(texture);
        color = each!(n => color[n] * texel[n]);
    }
    with_vertex_colors(l, context, batch, &location, color)
}

/// Base colour and opacity times the colours of the vertices.
#[inline(always)]
fn with_vertex_colors<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    batch: &Batch,
    location: &Location<L>,
    base_color: [L::F; 4],
) -> [L::F; 4] {
    if !has_colors(context, batch) {
        return base_color;
    }
    let colors = batch.vertices.attribute(l, context.draws, [1.0; 4], Mesh::colors);
    let color = location.interpolate(&colors);
    each!(n => base_color[n] * color[n])
}

/// True if some lane's mesh has vertex colours.
#[inline(always)]
fn has_colors(context: &ShadeContext<'_>, batch: &Batch) -> bool {
    batch.vertices.draws().iter().any(|&draw| !context.draws[draw as usize].mesh.colors().is_empty())
}

/// Positions of sixteen fragments and of their texture lookups: known before they are evaluated.
pub struct SurfacePlace<L: Lanes> {
    location: Location<L>,
    pub(super) coordinates: Coordinates<L>,
    samples: [SamplePlan<L>; PLACES],
    /// Texels that were read of the textures, in the slots of their plan.
    texels: [[L::F; 4]; PLACES],
    fetched: Fetched<L>,
    /// Viewpoint of fragments that no ray of the camera meets; `None` for the camera.
    seen_from: Option<SeenFrom<L>>,
}

/// A point that is seen from elsewhere than the camera.
#[derive(Clone, Copy)]
pub struct SeenFrom<L: Lanes> {
    /// The point.
    pub position: V3<L>,
    /// Unit vector towards the viewer.
    pub view: V3<L>,
    /// Distance of the viewer.
    pub distance: L::F,
}

impl<L: Lanes> SurfacePlace<L> {
    /// Positions on their triangles.
    pub(super) fn location(&self) -> &Location<L> {
        &self.location
    }

    /// A place that has no meaning yet.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self {
            location: Location::none(l),
            coordinates: Coordinates::none(l),
            samples: [SamplePlan::none(l); PLACES],
            texels: [[l.zero(); 4]; PLACES],
            fetched: Fetched::none(l),
            seen_from: None,
        }
    }

    /// As [`SurfacePlace::find`], for points that rays hit: at these `barycentric` weights of the second and third vertices, of
    /// which a footprint takes `width`.
    #[inline(never)]
    pub fn find_hits(
        &mut self,
        l: L,
        context: &ShadeContext<'_>,
        reading: &SurfaceReading<'_>,
        batch: &Batch,
        (barycentric, width, seen_from): ([L::F; 2], [L::F; 2], SeenFrom<L>),
    ) {
        l.run(
            #[inline(always)]
            || {
                let zero = l.zero();
                self.location = Location {
                    barycentric,
                    barycentric_dx: [width[0], zero],
                    barycentric_dy: [zero, width[1]],
                    depth: zero,
                    screen: [zero; 2],
                };
                self.seen_from = Some(seen_from);
                self.coordinates = coordinates(l, context, batch, &self.location);
                let reader = Reader::new(l, context, &self.coordinates, batch);
                reader.plan_samples(&reading.textures.plan, &mut self.samples);
            },
        );
    }

    /// Finds where the fragments of a batch lie, in place of what was there, and asks the processor for the texels that they
    /// will read.
    ///
    /// A function of its own for each instruction set.
    #[inline(never)]
    pub fn find(&mut self, l: L, context: &ShadeContext<'_>, reading: &SurfaceReading<'_>, batch: &Batch) {
        l.run(
            #[inline(always)]
            || {
                self.location = locate(l, batch, context.rays.perspective);
                self.coordinates = coordinates(l, context, batch, &self.location);
                let reader = Reader::new(l, context, &self.coordinates, batch);
                reader.plan_samples(&reading.textures.plan, &mut self.samples);
            },
        );
    }
}

/// Requests the texels that sixteen fragments read, where textures are decoded on demand. Some of the material may be
/// asked for in vain.
#[inline(never)]
pub fn ask_for_textures<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    reading: &SurfaceReading<'_>,
    batch: &Batch,
) {
    l.run(
        #[inline(always)]
        || {
            let location = locate(l, batch, context.rays.perspective);
            let coordinates = coordinates(l, context, batch, &location);
            let reader = Reader::new(l, context, &coordinates, batch);
            reader.ask_for_plan(&reading.textures.plan);
            for texture in reading.further_textures() {
                reader.ask(texture);
            }
        },
    );
}

/// Evaluates sixteen fragments at their `place`, as the surfaces of their material are read. With a filter of normals, also
/// how those vary.
#[inline(always)]
pub(super) fn evaluate_surface<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    reading: &SurfaceReading<'_>,
    batch: &Batch,
    place: &mut SurfacePlace<L>,
) -> (Surface<L>, Option<NormalVariation<L>>) {
    let &SurfaceReading { material, ref textures, lobes: wants_lobes, filter } = reading;
    let SurfacePlace { location, coordinates, samples, texels, fetched, seen_from } = place;
    let SeenFrom { position, view, distance } = match seen_from {
        Some(seen_from) => *seen_from,
        None => seen_by_camera(l, context, location),
    };

    let uv = coordinates.uv[0];
    let reader = Reader::new(l, context, coordinates, batch);

    textures.plan.read(l, samples, fetched, texels);
    let [base, workflow, occluding, emitting, coat, coat_rough, mapped, coat_mapped] =
        each!(slot in textures.plan.slots => &texels[slot]);

    let base = scaled(l, material.base_color, textures.base_color, base);
    let [red, green, blue, alpha] = with_vertex_colors(l, context, batch, location, base);
    let alpha = match material.alpha_mode {
        AlphaMode::Blend => alpha.saturate(),
        AlphaMode::Opaque | AlphaMode::Mask { .. } => l.splat(1.0),
    };

    let (reflectance, roughness) = reflectance(l, material, &reader, workflow);
    let occlusion = match textures.occlusion {
        Some(_) => (occluding[0] - 1.0) * material.occlusion_strength + 1.0,
        None => l.splat(1.0),
    };
    let emissive = Vec3::from_array(scaled(l, material.emissive, textures.emissive, emitting));
    let [coat] = scaled(l, [material.coat.max(0.0)], textures.coat, coat);
    let [coat_roughness] = scaled(l, [material.coat_roughness], textures.coat_roughness, &[coat_rough[1]; 4]);

    let normals = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::shading_normals);
    let frame = NormalFrame::new(l, context, material, batch, (location, &normals), view);
    let variation = if filter.is_some() {
        let (normal, change) = normal_change(l, context, batch, (location, &normals));
        let mapped = textures.normal_variances(l, material, mapped, coat_mapped);
        Some(NormalVariation { normal, change, mapped })
    } else {
        None
    };
    let normal = frame.shading_normal(l, material.normal_texture.as_ref(), mapped, view);
    let coat_normal = frame.coat_normal(l, material, coat_mapped, normal, view);

    let (mut lobes, mut tangent, mut bitangent) =
        (LobeValues::none(l), Vec3::splat(l, [1.0, 0.0, 0.0]), Vec3::splat(l, [0.0, 1.0, 0.0]));
    let mut bent_normal = normal;
    if wants_lobes {
        let direction;
        (lobes, direction) = LobeValues::new(l, material, &reader);
        (tangent, bitangent) = frame.tangents(l, direction, normal);
        if let Some(map) = &material.lobes.occlusion.bent_normal {
            bent_normal = frame.mapped_normal(l, map, &reader.read(&map.texture));
        }
    }

    let surface = Surface {
        position,
        view,
        normal,
        coat_normal,
        vertex_normal: frame.normal,
        base_color: Vec3::new(red, green, blue),
        alpha,
        reflectance,
        roughness,
        occlusion,
        emissive,
        coat,
        coat_roughness,
        tangent,
        bitangent,
        bent_normal,
        lobes,
        uv,
        trapped_roughness: None,
        distance,
        depth: location.depth,
    };
    (surface, variation)
}

/// Points that the camera sees.
#[inline(always)]
fn seen_by_camera<L: Lanes>(l: L, context: &ShadeContext<'_>, location: &Location<L>) -> SeenFrom<L> {
    let distance = context.rays.distance(l, location.depth);
    let (start, ray) = context.rays.ray(l, location.screen);
    let up = Vec3::splat(l, [0.0, 0.0, 1.0]);
    SeenFrom { position: start + ray * distance, view: normalize_or(l, ray * -1.0, up), distance }
}

/// Writes places on the triangles of a batch, and the triangles' unit normals on the side that is seen: the rows
/// [`layout::FACE`].
#[inline(never)]
pub fn store_face<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    batch: &Batch,
    place: &SurfacePlace<L>,
    planes: &mut SurfacePlanes,
) {
    l.run(
        #[inline(always)]
        || {
            let object = geometric_normal(l, context, batch);
            let world = batch.vertices.transform(l, context.draws, |d| d.normal_matrix, object);
            let view = get_vector(l, planes, layout::VIEW);
            let unit = normalize_or(l, world, view);
            // By the view and not by the order of vertices: light is blocked on the other side, whatever is the front.
            let away = unit.dot(view).lt(l.zero());
            put(planes, layout::FACE_NORMAL, Vec3::select(away, -unit, unit).to_array());
            let corners = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::positions);
            let on_triangle = Vec3::from_array(place.location.interpolate(&corners));
            let position = batch.vertices.to_world(l, context.draws, on_triangle);
            put(planes, layout::FACE_POSITION, position.to_array());
        },
    );
}

/// Number of textures that every model reads.
const PLACES: usize = 8;

/// Reading of the surfaces of one material: what all batches of it have in common.
#[derive(Debug)]
pub struct SurfaceReading<'a> {
    /// The material.
    pub material: &'a Material,
    textures: SurfaceTextures<'a>,
    /// With the material's lobes and tangents, which are left out otherwise.
    pub(super) lobes: bool,
    /// Filter by which roughness grows where normals vary within a pixel, if it does.
    pub(super) filter: Option<NormalFilter>,
}

impl<'a> SurfaceReading<'a> {
    /// Reading of a material of the scene, with its lobes or without.
    #[must_use]
    pub fn of(context: &ShadeContext<'a>, material: &'a Material, lobes: bool) -> Self {
        let textures = SurfaceTextures::of(material, context.textures);
        Self { material, textures, lobes, filter: normal_filter(context, material) }
    }

    /// Textures that some models read beside those that all do.
    fn further_textures(&self) -> impl Iterator<Item = &'a TextureRef> {
        let material = self.material;
        let known = [
            material.base_color_texture.as_ref(),
            material.occlusion_texture.as_ref(),
            material.emissive_texture.as_ref(),
            material.coat_texture.as_ref(),
            material.coat_roughness_texture.as_ref(),
            material.normal_texture.as_ref().map(|map| &map.texture),
            material.coat_normal_texture.as_ref().map(|map| &map.texture),
            match &material.workflow {
                Workflow::MetallicRoughness { texture, .. }
                | Workflow::SpecularGlossiness { texture, .. } => texture.as_ref(),
            },
        ];
        let is_known =
            move |texture: &TextureRef| known.into_iter().flatten().any(|k| std::ptr::eq(k, texture));
        material.textures().filter(move |texture| !is_known(texture))
    }
}

/// The textures of a material that every model reads, without those of no effect, and how they are read.
#[derive(Debug)]
struct SurfaceTextures<'a> {
    base_color: Option<&'a TextureRef>,
    occlusion: Option<&'a TextureRef>,
    emissive: Option<&'a TextureRef>,
    coat: Option<&'a TextureRef>,
    coat_roughness: Option<&'a TextureRef>,
    /// For the maps of base and coat: true if their texels record how far the normals stray.
    knows_variance: [bool; 2],
    plan: ReadingPlan<'a, PLACES>,
}

impl<'a> SurfaceTextures<'a> {
    /// Textures of a material of the scene.
    fn of(material: &'a Material, textures: &'a [Texture]) -> Self {
        let (Workflow::MetallicRoughness { texture: workflow, .. }
        | Workflow::SpecularGlossiness { texture: workflow, .. }) = &material.workflow;
        let (emits, has_coat) = (material.emissive != [0.0; 3], material.coat > 0.0);
        let base_color = material.base_color_texture.as_ref();
        let occlusion = material.occlusion_texture.as_ref();
        let emissive = if emits { material.emissive_texture.as_ref() } else { None };
        let coat = if has_coat { material.coat_texture.as_ref() } else { None };
        let coat_roughness = if has_coat { material.coat_roughness_texture.as_ref() } else { None };
        let normal = material.normal_texture.as_ref().map(|map| &map.texture);
        let coat_normal = match &material.coat_normal_texture {
            Some(map) if has_coat => Some(&map.texture),
            _ => None,
        };
        let places =
            [base_color, workflow.as_ref(), occlusion, emissive, coat, coat_roughness, normal, coat_normal];
        let plan = ReadingPlan::new(places, textures);
        let knows = |map: &TextureRef| textures[map.texture.index()].reads_variance();
        let knows_variance = [normal, coat_normal].map(|map| map.is_some_and(knows));
        Self { base_color, occlusion, emissive, coat, coat_roughness, knows_variance, plan }
    }

    /// Growth of the square of alpha by how the normals of base and coat vary within their texels: see
    /// [`mapped_variance`].
    #[inline(always)]
    fn normal_variances<L: Lanes>(
        &self,
        l: L,
        material: &Material,
        mapped: &[L::F; 4],
        coat_mapped: &[L::F; 4],
    ) -> [L::F; 2] {
        let maps = [(&material.normal_texture, mapped), (&material.coat_normal_texture, coat_mapped)];
        each!(which => match maps[which] {
            (Some(map), texel) if self.knows_variance[which] => mapped_variance(l, texel, map.scale),
            _ => l.zero(),
        })
    }
}

/// The first channels of a texel times their factors, or the factors alone where there is no texture.
#[inline(always)]
fn scaled<L: Lanes, const N: usize>(
    l: L,
    factors: [f32; N],
    texture: Option<&TextureRef>,
    texel: &[L::F; 4],
) -> [L::F; N] {
    match texture {
        Some(_) => each!(n => texel[n] * factors[n]),
        None => each!(f in factors => l.splat(f)),
    }
}

/// Reflectance and perceptual roughness, from the texel of the workflow's texture.
#[inline(always)]
fn reflectance<L: Lanes>(
    l: L,
    material: &Material,
    reader: &Reader<'_, L>,
    texel: &[L::F; 4],
) -> (Reflectance<L>, L::F) {
    match &material.workflow {
        Workflow::MetallicRoughness { metallic, roughness, texture } => {
            let (metallic, roughness) = match texture {
                Some(_) => (texel[2] * *metallic, texel[1] * *roughness),
                None => (l.splat(*metallic), l.splat(*roughness)),
            };
            let dielectric = dielectric(material, reader);
            (Reflectance::Metallic { metallic, dielectric }, roughness)
        }
        Workflow::SpecularGlossiness { specular, glossiness, texture } => {
            let factors = [specular[0], specular[1], specular[2], *glossiness];
            let [r, g, b, gloss] = scaled(l, factors, texture.as_ref(), texel);
            (Reflectance::Specular { f0: Vec3::new(r, g, b) }, gloss.one_minus().saturate())
        }
    }
}

/// Index of refraction and KHR_materials_specular.
#[inline(always)]
fn dielectric<L: Lanes>(material: &Material, reader: &Reader<'_, L>) -> Dielectric<L> {
    let color = reader.factor(material.specular_color, material.specular_color_texture.as_ref(), [0, 1, 2]);
    let [weight] = reader.factor([material.specular], material.specular_texture.as_ref(), [3]);
    Dielectric { f0_of_ior: material.dielectric_f0(), color: Vec3::from_array(color), weight }
}
