//! Lazy textures, whose images are decoded when a picture reads them: which of their rows are there, which it needs, and the loop
//! that draws it until none is lacking.
//!
//! What a picture reads is known once its fragments are: a feedback pass over all tiles finds these and asks for what they read without
//! shading them ([`Purpose::Feedback`](overcoat_tiles::pass::Purpose::Feedback)). Reads that it does not foresee are asked for as well while
//! tiles are drawn: then they are drawn again. The texels are those of the whole image, whatever was asked for
//! before, so no picture shows the order in which things were found.

use super::picture::Request;
use overcoat_core::jobs::{Jobs, Scratch};
use overcoat_scene::{AlphaMode, LazyImage, Material, Revision, Scene, Texture};
use overcoat_stages::shadow::textures_of_tint;
use overcoat_tiles::occlusion::asked_for;
use std::sync::Arc;

/// Memory of the textures that is kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct TextureMemory {
    /// Resident parts of the scene's textures; empty if all of it is there in the scene.
    pub resident: Vec<Texture>,
    /// Room for decoders.
    raw: Scratch<Vec<u8>>,
    /// A feedback pass is run whether it pays or not.
    pub always: bool,
    /// The scene that has had its feedback pass.
    pub fed_back: Option<Revision>,
}

impl TextureMemory {
    /// Starts a picture: brings what decides about opacity, and all of what rays may read. True if a feedback pass
    /// is to be run.
    pub(super) fn begin(&mut self, request: &Request<'_>) -> bool {
        let &Request { jobs, scene, options, .. } = request;
        self.resident.clear();
        if !is_lazy(scene) {
            return false;
        }
        let pixels = u64::from(options.width) * u64::from(options.height);
        let few = !self.always && texels(scene) <= MANY.min(WORTH * pixels);
        let all = options.visibility.rays > 0 || options.stage_hashes || few;
        for instance in scene.instances() {
            let material = &scene.materials()[instance.material.index()];
            if all {
                material.textures().for_each(|read| want_all(&scene.textures()[read.texture.index()]));
            }
            if let AlphaMode::Mask { .. } = material.alpha_mode {
                want_alpha(scene, material);
            }
            if asked_for(options).is_on() {
                let lists = textures_of_tint(material);
                lists.for_each(|read| want_all(&scene.textures()[read.texture.index()]));
            }
        }
        self.fetch(jobs, scene);
        if all {
            return false;
        }
        self.fed_back != Some(scene.revision())
    }

    /// Brings what decides about opacity anywhere.
    pub(super) fn begin_picking(&mut self, request: &Request<'_>) {
        let &Request { jobs, scene, .. } = request;
        self.resident.clear();
        if is_lazy(scene) {
            let clear = |material: &&Material| material.alpha_mode != AlphaMode::Opaque;
            scene.materials().iter().filter(clear).for_each(|material| want_alpha(scene, material));
            self.fetch(jobs, scene);
        }
    }

    /// True if something was asked for that is not resident.
    pub(super) fn lacks(&self) -> bool {
        let lacks = |texture: &Texture| {
            texture.form().is_some_and(|form| form.lacks(texture) && !form.image().is_lost())
        };
        self.resident.iter().any(lacks)
    }

    /// Decodes what is wanted and not resident.
    pub(super) fn fetch(&mut self, jobs: &Jobs, scene: &Scene) {
        // The textures of each image together.
        let mut images: Vec<Vec<&Texture>> = Vec::new();
        for texture in scene.textures() {
            let Some(form) = texture.form() else { continue };
            if !form.lacks(&texture.resident()) || form.image().is_lost() {
                continue;
            }
            let same = |list: &&mut Vec<&Texture>| {
                list[0].form().is_some_and(|other| Arc::ptr_eq(other.image(), form.image()))
            };
            match images.iter_mut().find(same) {
                Some(list) => list.push(texture),
                None => images.push(vec![texture]),
            }
        }
        // The largest first: what is left at the end is small.
        images
            .sort_by_key(|list| std::cmp::Reverse(u64::from(list[0].width()) * u64::from(list[0].height())));
        let mut rest = &mut images[..];
        while !rest.is_empty() {
            let (now, later) = rest.split_at_mut(at_once(rest));
            jobs.for_each_with_scratch(&mut self.raw, now, |raw, _, textures| {
                if let Some(form) = textures.first().and_then(|texture| texture.form()) {
                    form.image().provide(textures, raw);
                }
            });
            self.raw.iter_mut().for_each(|raw| *raw = Vec::new());
            rest = later;
        }
        self.resident.clear();
        self.resident.extend(scene.textures().iter().map(Texture::resident));
    }

    /// The textures that a picture reads.
    pub(super) fn of<'a>(&'a self, scene: &'a Scene) -> &'a [Texture] {
        if self.resident.is_empty() { scene.textures() } else { &self.resident }
    }

    /// Forgets the picture: what is there stays with the scene.
    pub(super) fn end(&mut self) {
        self.resident.clear();
    }
}

/// Bytes that the decoders of images that are decoded beside each other take together, if they are several.
const DECODING: u64 = 96 << 20;

/// Number of images that are decoded beside each other: the first, and those that there is memory for.
fn at_once(images: &[Vec<&Texture>]) -> usize {
    let mut sum = 0_u64;
    let fits = |textures: &&Vec<&Texture>| {
        let form = textures.first().and_then(|texture| texture.form());
        sum = sum.saturating_add(form.map_or(0, |form| form.image().transient()));
        sum <= DECODING
    };
    images.iter().take_while(fits).count().max(1)
}

/// True if some texture of a scene is decoded on demand.
fn is_lazy(scene: &Scene) -> bool {
    scene.textures().iter().any(|texture| texture.form().is_some())
}

/// Texels of a pixel of the picture up to which images are decoded as a whole, without asking. A feedback pass takes some 100 ns a pixel,
/// decoding some 13 ns a texel (FlightHelmet at 256 x 256, one thread), and it saves a part of the texels alone: models with
/// fewer lost up to a tenth of their time to it.
const WORTH: u64 = 96;

/// Texels that are never all kept without asking: with their mip levels they take some 50 MB.
const MANY: u64 = 1 << 23;

/// Texels of the images that are decoded by need.
fn texels(scene: &Scene) -> u64 {
    // The textures of an image follow each other.
    let mut last: Option<&Arc<LazyImage>> = None;
    let mut sum = 0;
    for form in scene.textures().iter().filter_map(Texture::form) {
        if last.is_none_or(|last| !Arc::ptr_eq(last, form.image())) {
            let [width, height] = form.image().size().map(u64::from);
            sum += width * height;
        }
        last = Some(form.image());
    }
    sum
}

/// Requests the texture that decides about the opacity of a material, if it has alpha: of others it is known.
fn want_alpha(scene: &Scene, material: &Material) {
    let texture = material.base_color_texture.map(|read| &scene.textures()[read.texture.index()]);
    if let Some(form) = texture.and_then(Texture::form)
        && !form.image().is_opaque()
    {
        form.want_all();
    }
}

fn want_all(texture: &Texture) {
    if let Some(form) = texture.form() {
        form.want_all();
    }
}
