//! glTF 2.0, as `.gltf` with its files beside it or embedded, and as `.glb`.
//!
//! The order is: container, JSON, extensions, scene graph, materials and primitives that are in the scene, and then,
//! in parallel, images and primitives. Compressed views are decompressed when all that are needed are known, compressed
//! primitives when their triangles are read. What is not in the default scene is never read. Serial steps find every byte
//! and charge every allocation in the order of the file, so that a limit is met at the same element whatever the
//! number of threads.
//!
//! The result is a [`Rig`]: it makes the scene in the pose of the file or at a time of one animation, with vertices
//! moved by morph targets and skins. Nothing is read or decoded again for another time.

// Whatever a file says, nothing here panics: there is no operation that could.
mod accessor;
mod angle;
mod animation;
mod attributes;
mod buffers;
mod camera;
mod container;
mod deform;
mod draco;
mod extensions;
mod far;
mod flat;
mod hierarchy;
mod instancing;
mod json;
mod lenient;
mod light;
mod list;
mod material;
mod mesh;
mod meshopt;
mod model;
mod morph;
mod plan;
mod pointer;
mod pose;
mod properties;
mod repair;
mod rest;
mod rewrite;
mod rig;
mod sample;
mod shape;
mod skin;
mod source;
mod splats;
mod splice;
mod surface;
mod surface_objects;
mod texture;
mod topology;
mod uv_sets;
mod variant;

pub(super) use container::MAGIC;
pub use rewrite::{OwnTextures, Put, Rewriter};
pub(crate) use rig::Rig;
pub(super) use texture::transform_of;

use super::budget::Budget;
use super::warnings::Warnings;
use super::{AnimationInfo, Context, Format, LoadError, LoadOptions, TextureLoading};
use accessor::Pick;
use animation::{Animation, Channels};
use buffers::Buffers;
use far::Far;
use hierarchy::Tree;
use list::Index;
use mesh::Geometry;
use model::Root;
use overcoat_core::built::Splats;
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::limits::Limits;
use overcoat_scene::{Material, Orientation, Scene, SplatCloud, Texture, TextureId};
use rig::{Drawn, PoseKey};
use shape::{Shape, Topological};
use skin::Skin;
use source::{Shared, Source};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::sync::Mutex;
use texture::{Decoded, Encoded, Textures};

/// The format in messages.
const FORMAT: &str = "glTF";

/// Extent of reading: pictures alone need less than a list of contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Pictures only.
    Pictures,
    /// Also a list of all animations.
    Contents,
}

/// Reads a `.gltf` or `.glb` file.
///
/// # Errors
/// [`LoadError`] naming the element.
pub(crate) fn read(
    bytes: &[u8],
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Rig, LoadError> {
    let mut warnings = Warnings::default();
    let (text, binary) = container::split(bytes, &mut warnings)?;
    read_parts(text, binary.map(Source::Memory), options, purpose, context, warnings)
}

/// Reads a `.glb` file of `size` bytes without reading all of it into memory first. `None` for every other file, and
/// for containers that are not as they should be.
///
/// # Errors
/// [`LoadError`] as [`read`], and [`LoadError::Io`].
pub(crate) fn read_file(
    file: &File,
    size: u64,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Option<Rig>, LoadError> {
    let file = Shared::new(file);
    let Some((text, (start, length))) = container::locate(&file, size) else { return Ok(None) };
    let binary = Source::File(source::Part::new(&file, start, length));
    read_parts(&text, Some(binary), options, purpose, context, Warnings::default()).map(Some)
}

/// Reads the JSON text and the binary chunk of a file, with an animation that shows something if the file has only that.
fn read_parts(
    text: &[u8],
    binary: Option<Source<'_>>,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
    warnings: Warnings,
) -> Result<Rig, LoadError> {
    let chosen = options.animation.as_ref().map(|choice| Played::Chosen(&choice.name));
    let read = |played| read_playing(text, binary, played, options, purpose, context, warnings.clone());
    let rig = read(chosen.unwrap_or(Played::None))?;
    Ok(match options.animation {
        None => rest::or_first_visible(rig, |index| read(Played::Numbered(index)), context.jobs),
        Some(_) => rig,
    })
}

/// The animation that is played.
#[derive(Clone, Copy)]
enum Played<'a> {
    None,
    /// By its name or number in an option.
    Chosen(&'a str),
    /// By its number in the file.
    Numbered(usize),
}

/// Reads the JSON text and the binary chunk of a file whose animation is chosen.
fn read_playing(
    text: &[u8],
    binary: Option<Source<'_>>,
    played: Played<'_>,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
    mut warnings: Warnings,
) -> Result<Rig, LoadError> {
    let mut budget = Budget::new(context.limits);
    let mut root = json::parse(text, &mut budget, &mut warnings)?;
    check_counts(&root, context.limits)?;
    let lacking = extensions::check(&root, &mut warnings);
    hierarchy::place_loose_meshes(&mut root, &mut warnings);
    let variant = variant::chosen(&root, options.variant.as_deref())?;
    let mut tree = Tree::new(&root, context.limits, &mut warnings)?;
    let index = match played {
        Played::None => None,
        Played::Chosen(name) => Some(animation::choose(&root, name)?),
        Played::Numbered(index) => Some(index),
    };
    let chosen = match index {
        None => None,
        Some(index) => Some((index, animation::channels(&root, index, context.limits, &mut warnings)?)),
    };
    let channels = chosen.as_ref().map(|(_, channels)| channels);

    let mut loader = Loader {
        root: &root,
        context,
        variant,
        budget,
        warnings,
        buffers: Buffers::new(&root, binary),
        textures: Textures::default(),
        materials: Vec::new(),
        uv_sets: Vec::new(),
        material_places: BTreeMap::new(),
        geometries: Vec::new(),
        clouds: Vec::new(),
        sources: BTreeMap::new(),
        skins: BTreeMap::new(),
        failures: Failures::default(),
        by_need: options.textures == TextureLoading::ByNeed,
    };
    let (draws, contents) = loader.plan(&mut tree, channels)?;
    let (animation, animations) = loader.read_animations(channels, purpose)?;
    let (textures, shapes) = loader.read(&draws)?;
    let clouds = loader.read_splats()?;
    if clouds.iter().all(SplatCloud::is_empty)
        && shapes.iter().all(|shape| shape.mesh.triangles().is_empty())
        && let Some(error) = loader.failures.first.take().or(lacking)
    {
        return Err(error);
    }
    let (stage, materials) = loader.dress(textures)?;
    let (skins, warnings) = (loader.skins, loader.warnings);
    let animation = chosen.as_ref().map(|(index, _)| *index).zip(animation);
    let far = Far::default();
    let is_turned = extensions::is_vrm0(&root);
    let orientation = options.orientation(Orientation { is_turned, ..Format::Gltf.orientation() });
    let mut rig = Rig {
        root,
        tree,
        stage,
        materials,
        shapes,
        clouds,
        skins,
        draws,
        contents,
        animation,
        stands_in: None,
        animations,
        far,
        orientation,
        warnings,
    };
    rig.check_joints()?;
    rig.bring_near()?;
    Ok(rig)
}

/// Every list of small objects against one limit.
fn check_counts(root: &Root, limits: &Limits) -> Result<(), LoadError> {
    let lists = [
        ("nodes", root.nodes.len()),
        ("scenes", root.scenes.len()),
        ("meshes", root.meshes.len()),
        ("materials", root.materials.len()),
        ("textures", root.textures.len()),
        ("images", root.images.len()),
        ("samplers", root.samplers.len()),
        ("cameras", root.cameras.len()),
        ("accessors", root.accessors.len()),
        ("bufferViews", root.buffer_views.len()),
        ("buffers", root.buffers.len()),
        ("skins", root.skins.len()),
        ("animations", root.animations.len()),
    ];
    for (name, count) in lists {
        Limits::check(|| name.to_owned(), count as u64, limits.nodes, "nodes")?;
    }
    Ok(())
}

struct Loader<'a> {
    root: &'a Root,
    context: &'a Context<'a>,
    /// The chosen material variant.
    variant: Option<Index>,
    budget: Budget,
    warnings: Warnings,
    buffers: Buffers<'a>,
    textures: Textures,
    /// Used materials in the order of first use, with their numbers in the file and provisional texture ids.
    materials: Vec<(Option<usize>, Material)>,
    /// Sets of texture coordinates in the file that each of them reads.
    uv_sets: Vec<[u32; 2]>,
    /// Number in the file (`None`: the default material), whether it is without light and whether primitives have colours, to
    /// place.
    material_places: BTreeMap<(Option<usize>, bool, bool), usize>,
    /// Used geometries in the order of first use.
    geometries: Vec<Geometry>,
    /// Used clouds of splats in the order of first use.
    clouds: Vec<splats::Source>,
    sources: BTreeMap<mesh::Source, usize>,
    /// Used skins by their numbers in the file.
    skins: BTreeMap<usize, Skin>,
    failures: Failures,
    /// Images are decoded when a picture asks for them.
    by_need: bool,
}

/// Elements that cannot be read. The rest of the file is drawn without them; where nothing is left, the first of them is why.
#[derive(Debug, Default)]
struct Failures {
    first: Option<LoadError>,
}

impl Failures {
    /// Notes an element that is left out, with a warning.
    ///
    /// # Errors
    /// The error itself if it is not about that element alone.
    fn add(
        &mut self,
        error: LoadError,
        name: impl FnOnce() -> String,
        warnings: &mut Warnings,
    ) -> Result<(), LoadError> {
        if !error.is_partial() {
            return Err(error);
        }
        warnings.add(|| {
            let (name, reason) = (name(), error.reason());
            if reason.starts_with(&name) {
                format!("{reason}; not drawn")
            } else {
                format!("{name} is not drawn: {reason}")
            }
        });
        self.first.get_or_insert(error);
        Ok(())
    }
}

impl Loader<'_> {
    /// The animation that is played, and a list of all if that is the purpose.
    fn read_animations(
        &mut self,
        channels: Option<&Channels>,
        purpose: Purpose,
    ) -> Result<(Option<Animation>, Vec<AnimationInfo>), LoadError> {
        let (buffers, budget) = (&mut self.buffers, &mut self.budget);
        let animation = channels
            .map(|channels| channels.read(self.root, buffers, self.context, budget, &mut self.warnings))
            .transpose()?;
        let animations = match purpose {
            Purpose::Pictures => Vec::new(),
            Purpose::Contents => animation::list(self.root, buffers, self.context, budget)?,
        };
        Ok((animation, animations))
    }

    /// Reads the clouds of splats.
    fn read_splats(&mut self) -> Result<Vec<SplatCloud>, LoadError> {
        if !Splats::IS_BUILT && !self.clouds.is_empty() {
            return Err(LoadError::unsupported(FORMAT, format!("Gaussian splats: {LEFT_OUT}")));
        }
        let mut repaired = Vec::new();
        let mut clouds = Vec::with_capacity(self.clouds.len());
        for source in &self.clouds {
            match splats::read(self.root, &self.buffers, source, &mut repaired) {
                Ok(cloud) => clouds.push(cloud),
                Err(error) => {
                    self.failures.add(error, || source.name(self.root), &mut self.warnings)?;
                    // In its place.
                    clouds.push(SplatCloud::default());
                }
            }
        }
        for message in repaired {
            self.warnings.add(|| message);
        }
        Ok(clouds)
    }

    /// Decodes images and reads primitives.
    #[allow(clippy::type_complexity)]
    fn read(&mut self, draws: &[Drawn]) -> Result<(Vec<Option<Texture>>, Vec<Shape>), LoadError> {
        let (root, jobs) = (self.root, self.context.jobs);
        let encoded = self.textures.fetch(
            root,
            &mut self.buffers,
            self.context,
            &mut self.budget,
            &mut self.warnings,
        )?;
        self.buffers.decompress(jobs)?;
        for note in std::mem::take(&mut self.buffers.notes) {
            self.warnings.add(|| note);
        }
        let (geometries, buffers) = (&self.geometries, &self.buffers);

        // As many at a time as what they take for a while fits into what is left.
        let mut connected = Vec::with_capacity(geometries.len());
        let mut rest = geometries.as_slice();
        while !rest.is_empty() {
            let mut transient = 0u64;
            let fits = rest.iter().take_while(|geometry| {
                transient = transient.saturating_add(geometry.transient_bytes());
                transient <= self.budget.left()
            });
            let (now, later) = rest.split_at_checked(fits.count().max(1)).unwrap_or((rest, &[]));
            connected.extend(jobs.map_each(now, |geometry| geometry.read_triangles(root, buffers)));
            rest = later;
        }
        let mut vertices = 0;
        let mut picks = Vec::with_capacity(geometries.len());
        for (geometry, topological) in geometries.iter().zip(connected) {
            let topological = match topological {
                Err(error) => {
                    self.failures.add(error, || geometry.name(root), &mut self.warnings)?;
                    Topological::nothing()
                }
                Ok(topological) => topological,
            };
            let count = topological.left_out;
            if count > 0 {
                let what = "triangles, lines or points left out: their vertices are out of range";
                self.warnings.add(|| format!("{}: {count} {what}", geometry.name(root)));
            }
            let pick =
                geometry.pick(root, &topological, &mut vertices, self.context.limits, &mut self.budget)?;
            picks.push((topological, pick));
        }
        let mut posed: BTreeSet<PoseKey> = BTreeSet::new();
        for drawn in draws {
            for draw in drawn.mesh.iter() {
                let (Some(geometry), Some((_, pick))) =
                    (geometries.get(draw.geometry), picks.get(draw.geometry))
                else {
                    continue;
                };
                let skin = drawn.skin.filter(|_| geometry.has_joints());
                let weights = geometry.has_targets().then_some(drawn.weights);
                if (skin.is_some() || weights.is_some()) && posed.insert((draw.geometry, skin, weights)) {
                    geometry.charge_pose(root, pick, &mut vertices, self.context.limits, &mut self.budget)?;
                }
            }
        }
        let mut textures: Vec<Option<Texture>> = (0..self.textures.count()).map(|_| None).collect();
        let mut encoded = encoded;
        encoded.retain_mut(|image| {
            if !self.by_need && !image.is_reduced() {
                return true;
            }
            let deferred = image.defer(&mut self.buffers, &mut self.warnings);
            let is_kept = deferred.is_none();
            place(&mut textures, deferred.unwrap_or_default());
            is_kept
        });
        let buffers = &self.buffers;
        // Images first: they take longest.
        let images = encoded.iter().map(Work::Image);
        let picked = geometries.iter().zip(picks);
        let meshes = picked.map(|(geometry, picked)| Work::Mesh(geometry, Mutex::new(Some(picked))));
        let work: Vec<Work<'_>> = images.chain(meshes).collect();
        let results = jobs.map_each(&work, |work| match work {
            Work::Image(encoded) => Part::Image(encoded.decode(buffers)),
            Work::Mesh(geometry, picked) => {
                let taken = picked.lock().map_or(None, |mut slot| slot.take());
                let mut repaired = Vec::new();
                let mesh = match taken {
                    Some((topological, pick)) => {
                        geometry.read(root, buffers, topological, &pick, &mut repaired)
                    }
                    None => Err(LoadError::malformed(FORMAT, "a primitive was read twice")),
                };
                Part::Mesh(Box::new(mesh), repaired)
            }
        });
        drop(work);
        self.buffers.warn_of_short(&mut self.warnings);
        self.collect(results, &encoded, textures)
    }

    #[allow(clippy::type_complexity)]
    fn collect(
        &mut self,
        results: Vec<Part>,
        encoded: &[Encoded],
        mut textures: Vec<Option<Texture>>,
    ) -> Result<(Vec<Option<Texture>>, Vec<Shape>), LoadError> {
        // Images come first, in their order.
        let mut encoded = encoded.iter();
        let mut meshes = Vec::with_capacity(self.geometries.len());
        for result in results {
            match result {
                Part::Image(decoded) => {
                    let list = match (decoded, encoded.next()) {
                        (Ok(decoded), _) => decoded.textures(&mut self.warnings),
                        (Err(message), Some(image)) => image.replaced(
                            &message,
                            self.root,
                            &mut self.buffers,
                            self.context,
                            &mut self.budget,
                            &mut self.warnings,
                        )?,
                        (Err(_), None) => Vec::new(),
                    };
                    place(&mut textures, list);
                }
                Part::Mesh(mesh, repaired) => {
                    let of = self.geometries.get(meshes.len()).map_or((0, 0), |geometry| geometry.of);
                    meshes.push(match *mesh {
                        Err(error) => {
                            let name = || mesh::name(self.root, of.0, of.1);
                            self.failures.add(error, name, &mut self.warnings)?;
                            Shape::nothing(of)?
                        }
                        Ok(shape) => shape,
                    });
                    for message in repaired {
                        self.warnings.add(|| message);
                    }
                }
            }
        }
        Ok((textures, meshes))
    }

    /// A scene with the textures, and the materials that use them, with their numbers in the file.
    #[allow(clippy::type_complexity)]
    fn dress(
        &mut self,
        textures: Vec<Option<Texture>>,
    ) -> Result<(Scene, Vec<(Option<usize>, Material)>), LoadError> {
        let mut scene = Scene::new();
        let mut ids: Vec<Option<TextureId>> = Vec::with_capacity(textures.len());
        for texture in textures {
            let id = texture.map(|texture| scene.add_texture(texture)).transpose();
            ids.push(id.map_err(LoadError::scene("textures"))?);
        }
        let mut materials = std::mem::take(&mut self.materials);
        materials.iter_mut().for_each(|(_, material)| material::settle_textures(material, &ids));
        Ok((scene, materials))
    }
}

/// Puts textures in the places of their provisional ids.
fn place(textures: &mut [Option<Texture>], list: Vec<(u32, Texture)>) {
    for (id, texture) in list {
        if let Some(place) = textures.get_mut(id as usize) {
            *place = Some(texture);
        }
    }
}

/// Input of a parallel job.
enum Work<'a> {
    Image(&'a Encoded),
    /// Its triangles and vertices are taken out by the job that reads it.
    Mesh(&'a Geometry, Mutex<Option<(Topological, Pick)>>),
}

/// Result of a parallel job.
enum Part {
    /// Or why it cannot be decoded.
    Image(Result<Decoded, String>),
    Mesh(Box<Result<Shape, LoadError>>, Vec<String>),
}
