//! Lazy images: decoded once it is known which rows are visible.
//!
//! Of each form of such an image, the rows of each level that pictures have asked for are kept: the same texels that
//! [`Texture::new`] makes of the whole image, made while its rows are decoded. Pictures ask for the rows they read
//! ([`Form::want`]), and the renderer makes these resident before it draws ([`LazyImage::provide`]).

use super::mipmap::Chain;
use super::parameters::{EMISSIVE_TEXTURE, slots};
use super::row_bands::{BandLayout, RowBands};
use super::texture::{full_layout, is_opaque, layout_down, level_size};
use super::{AlphaUse, ColorSpace, Image, Material, Sampler, Scene, Texture, TextureId, TextureRef};
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Source of the rows of an image.
pub trait ImageSource: Send + Sync {
    /// Gives the rows of a sound image from the top on, until one is not `taken`. `raw` is a buffer that decoders
    /// overwrite. False if the image is not sound, whatever rows were given: then [`ImageSource::image`] says what
    /// could be read.
    fn rows(&self, raw: &mut Vec<u8>, take: &mut dyn FnMut(&[[u8; 4]]) -> bool) -> bool;
    /// Number of times that rows can be read at half the size; 0 for an image that may have alpha.
    fn halvings(&self) -> u32 {
        0
    }
    /// Gives rows as [`ImageSource::rows`] does, of the image at its size halved as often as `halvings` says, with the number of
    /// halvings. Texels are means of `light` of sRGB codes, or of codes, as those of mip levels are. Where rows of several sizes end at the same place, that
    /// of the smallest comes first.
    fn halved_rows(
        &self,
        _halvings: RangeInclusive<u32>,
        _light: bool,
        _take: &mut dyn FnMut(u32, &[[u8; 4]]) -> bool,
    ) -> bool {
        false
    }
    /// Bytes that reading its rows takes for a while.
    fn transient(&self) -> u64;
    /// The image and its flaws, or the reason why it is lost: each one line.
    fn image(&self) -> Result<(Image, Vec<String>), String>;
}

/// An image and its forms.
pub struct LazyImage {
    size: [u32; 2],
    /// Mip level of the image that is level 0 of its textures.
    finest: u32,
    /// It has no alpha.
    opaque: bool,
    source: Box<dyn ImageSource>,
    forms: Vec<FormState>,
    /// All of it, if it has been decoded as a whole; `None` if it is lost.
    image: OnceLock<Option<Arc<Image>>>,
    /// Flaws found so far, one line each.
    flaws: Mutex<Vec<String>>,
}

/// A form in which an image is read.
struct FormState {
    color_space: ColorSpace,
    alpha: AlphaUse,
    sampler: Sampler,
    layout: BandLayout,
    /// A bit for each band of rows that was asked for.
    wanted: Vec<AtomicU64>,
    /// Texture with the rows that are resident.
    texture: Mutex<Option<Texture>>,
    whole: OnceLock<Box<Texture>>,
}

impl std::fmt::Debug for LazyImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LazyImage({} x {})", self.size[0], self.size[1])
    }
}

/// A texture's form of its image.
#[derive(Clone, Debug)]
pub struct Form {
    image: Arc<LazyImage>,
    number: usize,
}

impl Form {
    /// The form of a number, if there is one.
    pub fn new(image: &Arc<LazyImage>, number: usize) -> Option<Self> {
        (number < image.forms.len()).then(|| Self { image: Arc::clone(image), number })
    }

    /// The image.
    pub fn image(&self) -> &Arc<LazyImage> {
        &self.image
    }

    fn state(&self) -> &FormState {
        &self.image.forms[self.number]
    }

    pub fn color_space(&self) -> ColorSpace {
        self.state().color_space
    }

    pub fn sampler(&self) -> Sampler {
        self.state().sampler
    }

    pub fn band_layout(&self) -> &BandLayout {
        &self.state().layout
    }

    /// Asks for a band of rows.
    pub fn want(&self, band: u32) {
        if let Some(word) = self.state().wanted.get(band as usize / 64) {
            word.fetch_or(1 << (band % 64), Ordering::Relaxed);
        }
    }

    /// Asks for all of it.
    pub fn want_all(&self) {
        let FormState { layout, wanted, .. } = self.state();
        for (word, all) in wanted.iter().zip(layout.all()) {
            word.fetch_or(all, Ordering::Relaxed);
        }
    }

    /// True if a band was asked for that `texture`, which is of this form, does not have.
    pub fn lacks(&self, texture: &Texture) -> bool {
        let Some(bands) = texture.bands() else { return false };
        let wanted = &self.state().wanted;
        let lacks = |(wanted, present): (&AtomicU64, &u64)| wanted.load(Ordering::Relaxed) & !present != 0;
        wanted.iter().zip(bands.present()).any(lacks)
    }

    /// The resident rows of `texture`, which is of this form.
    pub fn resident(&self, texture: &Texture) -> Texture {
        if let Some(whole) = self.state().whole.get() {
            return (**whole).clone();
        }
        lock(&self.state().texture).clone().unwrap_or_else(|| texture.clone())
    }

    /// All of `texture`, which is of this form.
    pub(super) fn whole<'a>(&'a self, texture: &'a Texture) -> &'a Texture {
        let FormState { color_space, alpha, sampler, texture: made, whole, .. } = self.state();
        if texture.bands().is_none() {
            return texture;
        }
        whole.get_or_init(|| {
            // A picture may have asked for all of it: it is not decoded again.
            if let Some(made) = lock(made).as_ref().filter(|made| made.bands().is_none()) {
                return Box::new(made.clone());
            }
            if let Some(streamed) = self.streamed(texture) {
                return Box::new(streamed);
            }
            let image = self.image.decoded().unwrap_or_else(|| Arc::new(Image::white()));
            Box::new(Texture::from_level(image, *color_space, *alpha, *sampler, self.image.finest))
        })
    }
}

impl Form {
    /// All of `texture`, which is of this form, made while the rows of its image come in. `None` if that cannot be done, or if its
    /// levels are those that [`Texture::new`] makes and the first is the image: then that may be kept.
    pub(super) fn streamed(&self, texture: &Texture) -> Option<Texture> {
        let FormState { layout, .. } = self.state();
        let all = Lacking { texture, form: self, wanted: layout.all().collect() };
        let is_kept = self.image.source.halvings() == 0 || all.is_mask();
        if is_kept && self.image.finest == 0 {
            return None;
        }
        self.image.stream(&[all], &mut Vec::new())?.pop()
    }
}

impl LazyImage {
    /// An image of this size in some forms, whose textures have its mip levels from `finest` on. `opaque`: it has no alpha.
    pub fn new(
        size: [u32; 2],
        finest: u32,
        opaque: bool,
        source: Box<dyn ImageSource>,
        forms: impl IntoIterator<Item = (ColorSpace, AlphaUse, Sampler)>,
    ) -> Self {
        let state = |(color_space, alpha, sampler)| {
            let layout = BandLayout::new(&full_layout(level_size(size, finest), &sampler));
            let wanted = (0..layout.words()).map(|_| AtomicU64::new(0)).collect();
            let (texture, whole) = (Mutex::new(None), OnceLock::new());
            FormState { color_space, alpha, sampler, layout, wanted, texture, whole }
        };
        Self {
            size,
            finest,
            opaque,
            source,
            forms: forms.into_iter().map(state).collect(),
            image: OnceLock::new(),
            flaws: Mutex::new(Vec::new()),
        }
    }

    /// In texels, as it is decoded.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Bytes that decoding it takes for a while.
    pub fn transient(&self) -> u64 {
        self.source.transient()
    }

    /// Size of level 0 of its textures.
    pub fn kept_size(&self) -> [u32; 2] {
        level_size(self.size, self.finest)
    }

    /// Its format has no alpha.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// True if an attempt to read it has failed.
    pub fn is_lost(&self) -> bool {
        matches!(self.image.get(), Some(None))
    }

    /// Flaws found so far, one line each.
    pub(crate) fn flaws(&self) -> Vec<String> {
        lock(&self.flaws).clone()
    }

    /// True if the alpha of some texel passes. Rows are decoded up to the first that does.
    pub(crate) fn has_alpha(&self, passes: &dyn Fn(u8) -> bool) -> bool {
        if self.opaque && self.image.get().is_none() {
            return passes(255);
        }
        let any = |row: &[[u8; 4]]| row.iter().any(|texel| passes(texel[3]));
        if self.image.get().is_none() {
            let mut found = false;
            let sound = self.source.rows(&mut Vec::new(), &mut |row| {
                found = any(row);
                !found
            });
            if sound {
                return found;
            }
        }
        self.decoded().is_some_and(|image| any(image.texels()))
    }

    /// The image as a whole, decoded at the first call. `None` if it is lost.
    fn decoded(&self) -> Option<Arc<Image>> {
        let decode = || {
            let (image, flaws) = match self.source.image() {
                Ok((image, flaws)) => (Some(Arc::new(image)), flaws),
                Err(loss) => (None, vec![loss]),
            };
            *lock(&self.flaws) = flaws;
            image
        };
        if self.finest > 0 && !self.is_lost() {
            // The whole image is larger than what may be kept.
            let image = decode();
            return if image.is_some() { image } else { self.image.get_or_init(|| None).clone() };
        }
        self.image.get_or_init(decode).clone()
    }

    /// Makes the bands that were asked for and are not resident, of all `textures` of the image: it is decoded once
    /// for them. `raw` is a buffer for decoders, kept from image to image.
    pub fn provide(&self, textures: &[&Texture], raw: &mut Vec<u8>) {
        let lacking = textures.iter().filter_map(|texture| Lacking::of(texture)).collect::<Vec<_>>();
        if lacking.is_empty() || self.is_lost() {
            return;
        }
        // Images decoded at halves of their size never come from the whole one.
        if (self.image.get().is_none() || self.source.halvings() > 0)
            // Levels of a mask are made of the whole image, if that is kept.
            && (self.finest > 0 || !lacking.iter().any(|of| of.is_mask()))
            && let Some(made) = self.stream(&lacking, raw)
        {
            for (of, texture) in lacking.iter().zip(made) {
                let mut kept = lock(&of.form.state().texture);
                // Another picture of the scene may have asked for more in the meantime: requests are never withdrawn.
                if kept.as_ref().is_none_or(|kept| kept.band_count() < texture.band_count()) {
                    *kept = Some(texture);
                }
            }
            return;
        }
        // It is there already, or not sound, or a mask.
        if self.decoded().is_some() {
            lacking.iter().for_each(|of| {
                of.texture.whole();
            });
        }
    }

    /// Textures with the rows that are lacking, and those that were there. `None` if the image is not sound.
    fn stream(&self, lacking: &[Lacking<'_>], raw: &mut Vec<u8>) -> Option<Vec<Texture>> {
        if self.source.halvings() > 0 {
            return self.stream_halved(lacking);
        }
        let is_normals = |of: &Lacking<'_>| of.form.state().alpha == AlphaUse::Normals;
        // The alpha of normals depends on whether some texel has alpha.
        let needs_all = !self.opaque && lacking.iter().any(is_normals);
        let mut opaque = true;
        let mut made = lacking.iter().map(|of| of.start(true)).collect::<Vec<_>>();
        let sound = self.source.rows(raw, &mut |row| {
            opaque &= self.opaque || is_opaque(row);
            made.iter_mut().for_each(|made| made.take(row));
            needs_all || !made.iter().all(Chain::is_done)
        });
        if !sound {
            return None;
        }
        if !opaque && lacking.iter().any(is_normals) {
            // Their alpha is another number.
            made = lacking.iter().map(|of| of.start(false)).collect::<Vec<_>>();
            let again = self.source.rows(raw, &mut |row| {
                made.iter_mut().for_each(|made| made.take(row));
                !made.iter().all(Chain::is_done)
            });
            if !again {
                return None;
            }
        }
        let finish = |(of, made): (&Lacking<'_>, Chain)| {
            of.texture.with_bands(made, [opaque, opaque && is_normals(of)])
        };
        Some(lacking.iter().zip(made).map(finish).collect())
    }

    /// [`LazyImage::stream`] of an image that can be read at halves of its size, and has no alpha. Levels are the rows of these, whatever
    /// others are asked for with them; those of normals, which tell how much these differ, are made of the image.
    fn stream_halved(&self, lacking: &[Lacking<'_>]) -> Option<Vec<Texture>> {
        let mut made = lacking.iter().map(|of| of.start(true)).collect::<Vec<_>>();
        for space in [ColorSpace::Linear, ColorSpace::Srgb] {
            let of_space = lacking.iter().zip(&mut made).filter(|(of, _)| of.form.color_space() == space);
            let mut chains = of_space.map(|(_, chain)| chain).collect::<Vec<_>>();
            let halvings = chains.iter().map(|chain| chain.halvings());
            let range = halvings.reduce(|a, b| *a.start().min(b.start())..=*a.end().max(b.end()));
            let Some(range) = range else { continue };
            let mut take = |halvings: u32, row: &[[u8; 4]]| {
                chains.iter_mut().for_each(|chain| chain.take_halved(halvings, row));
                !chains.iter().all(|chain| chain.is_done())
            };
            if !self.source.halved_rows(range, space == ColorSpace::Srgb, &mut take) {
                return None;
            }
        }
        let finish = |(of, made): (&Lacking<'_>, Chain)| {
            of.texture.with_bands(made, [true, of.form.state().alpha == AlphaUse::Normals])
        };
        Some(lacking.iter().zip(made).map(finish).collect())
    }
}

/// A texture that lacks bands that were asked for.
struct Lacking<'a> {
    texture: &'a Texture,
    form: &'a Form,
    /// The bands that were asked for.
    wanted: Vec<u64>,
}

impl<'a> Lacking<'a> {
    fn of(texture: &'a Texture) -> Option<Self> {
        let form = texture.form()?;
        if !form.lacks(&form.resident(texture)) {
            return None;
        }
        let wanted = form.state().wanted.iter().map(|word| word.load(Ordering::Relaxed)).collect();
        Some(Self { texture, form, wanted })
    }

    /// Starts the chain that makes the bands that were asked for; normals are filtered as such only if they are
    /// `opaque`.
    fn start(&self, opaque: bool) -> Chain {
        let FormState { color_space, alpha, sampler, layout, .. } = self.form.state();
        let alpha = if *alpha == AlphaUse::Normals && !opaque { AlphaUse::Data } else { *alpha };
        let LazyImage { size, finest, .. } = *self.form.image;
        let levels =
            if finest == 0 { full_layout(size, sampler) } else { layout_down(size, sampler, finest) };
        let wanted = if self.is_mask() { layout.all().collect() } else { self.wanted.clone() };
        let halvings = match alpha {
            AlphaUse::Data | AlphaUse::Coverage => self.form.image.source.halvings(),
            AlphaUse::Mask { .. } | AlphaUse::Normals => 0,
        };
        Chain::new(&levels, RowBands::new(layout, wanted), *color_space, alpha, halvings)
    }

    fn is_mask(&self) -> bool {
        matches!(self.form.state().alpha, AlphaUse::Mask { .. })
    }
}

impl Scene {
    /// Losses in textures that are decoded on demand, as far as pictures have asked for them: one line each.
    #[must_use]
    pub fn texture_losses(&self) -> Vec<String> {
        let mut losses: Vec<String> = Vec::new();
        for form in self.textures().iter().filter_map(Texture::form) {
            for flaw in form.image().flaws() {
                if !losses.contains(&flaw) {
                    losses.push(flaw);
                }
            }
        }
        losses
    }

    /// The scene without the uses of textures of which it was found that they cannot be read; `None` if there are none.
    pub fn without_lost_textures(&self) -> Option<Self> {
        let is_lost = |texture: &Texture| texture.form().is_some_and(|form| form.image().is_lost());
        let reads_lost = |material: &Material| {
            material.textures().any(|read| is_lost(&self.textures[read.texture.index()]))
        };
        if !self.materials.iter().any(reads_lost) {
            return None;
        }
        let mut scene = self.clone();
        for material in &mut scene.materials {
            settle(material, &|id| (!is_lost(&self.textures[id.index()])).then_some(id));
        }
        Some(scene)
    }
}

/// Replaces the textures that a material reads; those that become none are left out.
pub fn settle(material: &mut Material, other: &dyn Fn(TextureId) -> Option<TextureId>) {
    for (parameter, slot) in slots() {
        let Some(&read) = slot.get(material) else { continue };
        let settled = other(read.texture);
        if settled.is_none() && parameter.name == EMISSIVE_TEXTURE.name {
            // The factor alone would make all of it glow.
            material.emissive = [0.0; 3];
        }
        slot.set(material, settled.map(|texture| TextureRef { texture, ..read }));
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
