//! Textures: which images the materials need, in which form, and their decoding.

use super::FORMAT;
use super::angle::sin_cos;
use super::buffers::Buffers;
use super::list::{Index, label};
use super::model::{self, Root, TextureInfo};
use super::uv_sets::UvSets;
use crate::budget::{Budget, Claim};
use crate::encoded_image::{EncodedImage, Reduction, warn_of_left_out, warn_of_reduced};
use crate::image::{self, Header, ImageError, Picture};
use crate::warnings::Warnings;
use crate::{Context, LoadError, ResolveError};
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{
    AlphaUse, ColorSpace, Filter, MipFilter, Sampler, Texture, TextureId, TextureRef, UvTransform, Wrap,
};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// Largest entry of a texture transform.
const MAX_TRANSFORM: f32 = 1e9;

/// A form in which an image is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Form {
    color_space: ColorSpace,
    alpha: AlphaUse,
    sampler: Sampler,
}

/// An image that some material needs.
struct Needed {
    image: usize,
    /// Fallback image that the file has for programs that do not read this one.
    substitute: Option<usize>,
    /// Material and slot of the first use, and the number of those beside it.
    used: (String, u64),
    /// The forms, with the provisional id of each.
    forms: Vec<(Form, u32)>,
}

/// The textures that materials refer to, before they exist. Ids are provisional: see [`Textures::load`].
#[derive(Default)]
pub(super) struct Textures {
    /// In the order of first use.
    needed: Vec<Needed>,
    places: HashMap<usize, usize>,
    count: u32,
}

impl Textures {
    /// A use of a texture, and what its values and its alpha are. `None`, with a warning, if there is no such texture or it cannot be read.
    pub(super) fn refer(
        &mut self,
        root: &Root,
        info: &TextureInfo,
        (color_space, alpha): (ColorSpace, AlphaUse),
        uv_sets: &mut UvSets,
        warnings: &mut Warnings,
        what: &dyn Fn() -> String,
    ) -> Option<TextureRef> {
        let transform = info.extensions.transform.as_deref();
        let set = transform.and_then(|t| t.tex_coord).or(info.tex_coord).unwrap_or_default();
        let mut dropped = |reason: &dyn Fn() -> String| {
            warnings.add_texture(|| format!("{}: {}; drawn without the texture", what(), reason()));
            None
        };
        let Some(index) = info.index else {
            return dropped(&|| "names no texture".to_owned());
        };
        let Some(texture) = root.textures.get(index.get()) else {
            return dropped(&|| format!("there is no texture {index}"));
        };
        let webp = texture.extensions.webp.as_ref().and_then(|e| e.source);
        // A reference to nothing is no reason to leave the substitute out.
        let basisu = texture.extensions.basisu.as_ref().and_then(|e| e.source);
        let basisu = basisu.filter(|source| texture.source.is_none() || source.get() < root.images.len());
        let Some(source) = basisu.or(webp).or(texture.source) else {
            return dropped(&|| format!("texture {index} has no image that can be read"));
        };
        if source.get() >= root.images.len() {
            return dropped(&|| format!("texture {index}: there is no image {source}"));
        }
        let Some(uv_set) = uv_sets.slot(set) else {
            return dropped(&|| format!("texture coordinate set {} is a third one, and two are read", set.0));
        };
        let transform = match transform.map(uv_transform) {
            None => UvTransform::IDENTITY,
            Some(Some(transform)) => transform,
            Some(None) => {
                warnings.add(|| format!("{}: texture transform out of range, ignored", what()));
                UvTransform::IDENTITY
            }
        };
        let sampler = sampler(root, texture, warnings);
        let substitute = texture.source.filter(|plain| *plain != source && plain.get() < root.images.len());
        let form = Form { color_space, alpha, sampler };
        let id = self.id(source.get(), substitute.map(Index::get), form, what)?;
        Some(TextureRef { texture: TextureId::from_index(id), uv_set, transform })
    }

    /// The provisional id of an image in a form.
    fn id(
        &mut self,
        image: usize,
        substitute: Option<usize>,
        form: Form,
        what: &dyn Fn() -> String,
    ) -> Option<u32> {
        let next = self.needed.len();
        let place = *self.places.entry(image).or_insert(next);
        if place == next {
            self.needed.push(Needed { image, substitute: None, used: (what(), 0), forms: Vec::new() });
        }
        let needed = self.needed.get_mut(place)?;
        if place != next {
            needed.used.1 = needed.used.1.saturating_add(1);
        }
        needed.substitute = needed.substitute.or(substitute);
        let forms = &mut needed.forms;
        if let Some((_, id)) = forms.iter().find(|(known, _)| *known == form) {
            return Some(*id);
        }
        let id = self.count;
        self.count = self.count.checked_add(1)?;
        forms.push((form, id));
        Some(id)
    }

    /// Finds the bytes of every image that is needed and checks their claims. Of images that cannot be read the substitute
    /// is taken; those without are left out. Both with a warning.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the image.
    pub(super) fn fetch(
        &self,
        root: &Root,
        buffers: &mut Buffers<'_>,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Vec<Encoded>, LoadError> {
        Limits::check(|| "textures".to_owned(), self.count.into(), context.limits.textures, "textures")?;
        // The headers now, the pictures later.
        buffers.hold(self.needed.iter().filter_map(|needed| root.images.get(needed.image)?.buffer_view))?;
        let mut encoded = Vec::new();
        for needed in &self.needed {
            let (what, opened) = open(needed.image, root, buffers, context, budget)?;
            let used = match &needed.used {
                (used, 0) => format!(" ({used})"),
                (used, more) => format!(" ({used}, and {more} more)"),
            };
            let found = match opened {
                Ok((header, bytes)) => {
                    let (substitute, forms) = (needed.substitute, needed.forms.clone());
                    Some(Encoded { what, used, bytes, header, finest: header.excess(), substitute, forms })
                }
                Err(message) => {
                    let lost =
                        Lost { what: &what, used: &used, message: &message, substitute: needed.substitute };
                    lost.replace(&needed.forms, root, buffers, context, budget, warnings)?
                }
            };
            encoded.extend(found);
        }
        let mut claims: Vec<Claim> = encoded.iter().map(Encoded::claim).collect();
        budget.fit(&mut claims);
        let (mut kept, mut left_out) = (Vec::new(), Vec::new());
        for (mut image, claim) in encoded.into_iter().zip(&claims) {
            if claim.left_out {
                left_out.push(image.what);
                continue;
            }
            image.finest = claim.finest;
            image.charge(budget)?;
            kept.push(image);
        }
        warn_of_left_out(left_out, warnings);
        warn_of_reduced(kept.iter().filter_map(Encoded::reduction), warnings);
        Ok(kept)
    }

    /// Number of provisional ids.
    pub(super) fn count(&self) -> usize {
        self.count as usize
    }
}

/// An image that cannot be read.
struct Lost<'a> {
    what: &'a str,
    used: &'a str,
    message: &'a str,
    substitute: Option<usize>,
}

impl Lost<'_> {
    /// Its substitute. `None` if it has none, or one that cannot be read either. Warns of what is done.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the substitute.
    fn replace(
        &self,
        forms: &[(Form, u32)],
        root: &Root,
        buffers: &mut Buffers<'_>,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Option<Encoded>, LoadError> {
        let Self { what, used, message, substitute } = self;
        let Some(substitute) = *substitute else {
            warnings.add_texture(|| format!("{what}{used}: {message}; drawn without it"));
            return Ok(None);
        };
        let (other, opened) = open(substitute, root, buffers, context, budget)?;
        warnings.add(|| format!("{what}: {message}; {other} takes its place"));
        match opened {
            Ok((header, bytes)) => {
                let used = (*used).to_owned();
                Ok(Some(Encoded {
                    what: other,
                    used,
                    bytes,
                    header,
                    finest: header.excess(),
                    substitute: None,
                    forms: forms.to_vec(),
                }))
            }
            Err(message) => {
                warnings.add_texture(|| format!("{other}: {message}; drawn without it"));
                Ok(None)
            }
        }
    }
}

/// Source of encoded bytes.
enum Bytes {
    Own(Vec<u8>),
    View(Index),
}

/// An image that can be decoded.
pub(super) struct Encoded {
    /// The image in messages.
    what: String,
    /// First use of the image, appended to its name in messages.
    used: String,
    bytes: Bytes,
    header: Header,
    /// Mip level that is level 0 of its textures.
    finest: u32,
    substitute: Option<usize>,
    forms: Vec<(Form, u32)>,
}

impl Encoded {
    /// The image, and the mip levels of each form: a third more.
    fn claim(&self) -> Claim {
        let Self { header, finest, forms, .. } = self;
        let per_texel = (forms.len() as u64).saturating_mul(2).saturating_add(4);
        Claim { finest: *finest, ..Claim::of(header, per_texel) }
    }

    /// Size as stored and size as kept, if that is smaller.
    fn reduction(&self) -> Option<Reduction<'_>> {
        Reduction::of(&self.what, &self.header, self.finest)
    }

    /// True if it is kept smaller than its file has it.
    pub(super) fn is_reduced(&self) -> bool {
        self.finest > 0
    }

    /// Charges the claim, and what decoding takes for a while.
    fn charge(&self, budget: &mut Budget) -> Result<(), LoadError> {
        Ok(budget.charge_texture(|| self.what.clone(), &self.claim())?)
    }

    /// The textures of the substitute with their provisional ids, where decoding failed with `message`; none, with a
    /// warning, if there is no substitute or it cannot be read either.
    ///
    /// # Errors
    /// Those of [`Textures::fetch`].
    pub(super) fn replaced(
        &self,
        message: &str,
        root: &Root,
        buffers: &mut Buffers<'_>,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Vec<(u32, Texture)>, LoadError> {
        let lost = Lost { what: &self.what, used: &self.used, message, substitute: self.substitute };
        let Some(mut other) = lost.replace(&self.forms, root, buffers, context, budget, warnings)? else {
            return Ok(Vec::new());
        };
        let mut claim = other.claim();
        budget.fit_one(&mut claim);
        other.finest = claim.finest;
        warn_of_reduced(other.reduction(), warnings);
        other.charge(budget)?;
        match other.decode(buffers) {
            Ok(decoded) => Ok(decoded.textures(warnings)),
            Err(message) => {
                warnings.add_texture(|| format!("{}: {message}; drawn without it", other.what));
                Ok(Vec::new())
            }
        }
    }

    /// The textures of this image with their provisional ids, to be decoded when a picture asks for them: its bytes are theirs from
    /// then on. `None` if that is done at once: where something else takes its place if it cannot be decoded.
    pub(super) fn defer(
        &mut self,
        buffers: &mut Buffers<'_>,
        warnings: &mut Warnings,
    ) -> Option<Vec<(u32, Texture)>> {
        let unusual = self.unusual();
        let Self { what, used, bytes, header, finest, substitute: None, forms } = self else { return None };
        let bytes = match bytes {
            Bytes::Own(bytes) => std::mem::take(bytes),
            Bytes::View(view) => buffers.take(*view).ok()?,
        };
        if let Some(unusual) = unusual {
            warnings.add(|| unusual);
        }
        let (name, bytes) = (format!("{what}{used}"), Arc::new(bytes));
        let image = EncodedImage { name, bytes, header: *header, finest: *finest }
            .lazy(forms.iter().map(|(form, _)| (form.color_space, form.alpha, form.sampler)));
        let texture = |(number, (_, id)): (usize, &(Form, u32))| Some((*id, Texture::lazy(&image, number)?));
        forms.iter().enumerate().map(texture).collect()
    }

    /// Warning about an image of a format that glTF does not allow.
    fn unusual(&self) -> Option<String> {
        let kind = self.header.unusual()?;
        Some(format!("{}{}: it is {kind}, which glTF does not have", self.what, self.used))
    }

    /// The textures of an image that can be read at halves of its size, or is kept smaller than it is, if it is sound.
    fn streamed(&self, bytes: &[u8]) -> Option<Vec<(u32, Texture)>> {
        let Self { what, header, finest, forms, .. } = self;
        if header.halvings() == 0 && *finest == 0 {
            return None;
        }
        let bytes = Arc::new(bytes.to_vec());
        let image = EncodedImage { name: what.clone(), bytes, header: *header, finest: *finest };
        let texture = |(form, id): &(Form, u32)| {
            Some((*id, image.streamed((form.color_space, form.alpha, form.sampler))?))
        };
        forms.iter().map(texture).collect()
    }

    /// The textures of this image, or why there are none.
    pub(super) fn decode(&self, buffers: &Buffers<'_>) -> Result<Decoded, String> {
        let bytes = match &self.bytes {
            Bytes::Own(bytes) => Cow::Borrowed(bytes.as_slice()),
            Bytes::View(view) => {
                buffers.view(*view).and_then(|view| view.bytes()).map_err(|error| error.to_string())?
            }
        };
        if let Some(textures) = self.streamed(&bytes) {
            return Ok(Decoded { textures, flaws: self.unusual().into_iter().collect() });
        }
        let Picture { image, flaw } = match image::decode(&bytes, &self.header) {
            Ok(picture) => picture,
            Err(error) => return Err(error.loss().unwrap_or_else(|limit| limit.to_string())),
        };
        let flaw = flaw.map(|flaw| format!("{}{}: {flaw}", self.what, self.used));
        let flaws = [self.unusual(), flaw].into_iter().flatten().collect();
        let image = Arc::new(image);
        let texture = |form: &Form| {
            let Form { color_space, alpha, sampler } = *form;
            Texture::from_level(Arc::clone(&image), color_space, alpha, sampler, self.finest)
        };
        Ok(Decoded { textures: self.forms.iter().map(|(form, id)| (*id, texture(form))).collect(), flaws })
    }
}

/// The textures of an image.
pub(super) struct Decoded {
    /// With their provisional ids.
    textures: Vec<(u32, Texture)>,
    /// Defects of the image that do not prevent its use.
    flaws: Vec<String>,
}

impl Decoded {
    /// The textures with their provisional ids. Warns of what is wrong with them.
    pub(super) fn textures(self, warnings: &mut Warnings) -> Vec<(u32, Texture)> {
        for flaw in self.flaws {
            warnings.add(|| flaw);
        }
        self.textures
    }
}

/// The header and the bytes of an image, or why it cannot be read.
type Opened = Result<(Header, Bytes), String>;

/// The name of an image in messages, and what it is.
///
/// # Errors
/// [`LoadError::Limit`] naming the image.
fn open(
    index: usize,
    root: &Root,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<(String, Opened), LoadError> {
    let image = root.images.at(index)?;
    let what = label::<model::Image>(index, image.name.as_deref().or(short_uri(image)));
    let bytes = match bytes_of(image, &what, buffers, context, budget) {
        // That of a buffer is one of geometry, too.
        Err(error @ LoadError::Resolve(ResolveError::TooLarge { .. })) if image.buffer_view.is_some() => {
            return Err(error);
        }
        Err(error @ LoadError::Limit(_)) => return Err(error),
        Err(LoadError::Malformed { message, .. }) => return Ok((what, Err(message))),
        Err(error) => return Ok((what, Err(error.to_string()))),
        Ok(bytes) => bytes,
    };
    let view = match &bytes {
        Bytes::Own(bytes) => Ok(Cow::Borrowed(bytes.as_slice())),
        Bytes::View(view) => buffers.view(*view).and_then(|view| view.bytes()),
    };
    let probed = match view {
        Ok(view) => image::probe_large(&what, &view, context.limits),
        Err(error) => return Ok((what, Err(error.to_string()))),
    };
    match probed {
        Ok(header) => Ok((what, Ok((header, bytes)))),
        // A picture that is missing, too large, damaged, or never was one, is a loss.
        Err(ImageError::Limit(limit)) => Ok((what, Err(excess(&limit)))),
        Err(ImageError::Damaged(message)) => Ok((what, Err(message))),
    }
}

/// Reason why a picture that is too large cannot be read; its name is said before.
fn excess(limit: &LimitExceeded) -> String {
    let LimitExceeded { asked, limit, field, .. } = limit;
    let asked = asked.map_or_else(|| "more".to_owned(), |asked| asked.to_string());
    format!("{asked} texels exceed the limit of {limit} ({field})")
}

fn bytes_of(
    image: &model::Image,
    what: &str,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<Bytes, LoadError> {
    match (&image.uri, image.buffer_view) {
        (_, Some(view)) => {
            buffers.require(view, context, budget)?;
            buffers.decompress(context.jobs)?;
            Ok(Bytes::View(view))
        }
        (Some(uri), None) => Ok(Bytes::Own(buffers.read_uri(uri, what, context, budget)?)),
        (None, None) => Err(LoadError::malformed(FORMAT, "it has neither a URI nor a bufferView")),
    }
}

/// The URI as a name, unless it holds the data itself.
fn short_uri(image: &model::Image) -> Option<&str> {
    image.uri.as_deref().filter(|uri| !uri.get(..5).is_some_and(|s| s.eq_ignore_ascii_case("data:")))
}

/// KHR_texture_transform: scale, then rotate counter-clockwise as seen in the image (v points down), then offset.
/// `None` if a number is beyond what a scene takes.
fn uv_transform(transform: &model::TextureTransform) -> Option<UvTransform> {
    transform_of(
        transform.offset.unwrap_or([0.0; 2]),
        transform.rotation.unwrap_or(0.0),
        transform.scale.unwrap_or([1.0; 2]),
    )
}

/// The same of its numbers; the rotation is in radians.
pub(crate) fn transform_of([x, y]: [f64; 2], rotation: f64, [sx, sy]: [f64; 2]) -> Option<UvTransform> {
    let (sin, cos) = sin_cos(rotation);
    let rows = [[cos * sx, sin * sy, x], [-sin * sx, cos * sy, y]].map(|row| row.map(|v| v as f32));
    rows.as_flattened().iter().all(|v| v.abs() <= MAX_TRANSFORM).then_some(UvTransform { rows })
}

fn sampler(root: &Root, texture: &model::Texture, warnings: &mut Warnings) -> Sampler {
    let mut sampler = Sampler::default();
    let Some(index) = texture.sampler else { return sampler };
    let Some(given) = root.samplers.get(index.get()) else {
        warnings.add(|| format!("there is no sampler {index}: the default one is used"));
        return sampler;
    };
    let mut unknown = |what: &str, code: u64| {
        warnings.add(|| format!("sampler {index}: unknown {what} {code}, the default is used"));
    };
    for (what, code, wrap) in
        [("wrapS", given.wrap_s, &mut sampler.wrap_u), ("wrapT", given.wrap_t, &mut sampler.wrap_v)]
    {
        match code.map(|c| c.0) {
            None | Some(10497) => *wrap = Wrap::Repeat,
            Some(33648) => *wrap = Wrap::MirroredRepeat,
            Some(33071) => *wrap = Wrap::ClampToEdge,
            Some(code) => unknown(what, code),
        }
    }
    match given.mag_filter.map(|c| c.0) {
        None | Some(9729) => sampler.magnification = Filter::Linear,
        Some(9728) => sampler.magnification = Filter::Nearest,
        Some(code) => unknown("magFilter", code),
    }
    let minification = match given.min_filter.map(|c| c.0) {
        None | Some(9987) => Some((Filter::Linear, MipFilter::Linear)),
        Some(9728) => Some((Filter::Nearest, MipFilter::None)),
        Some(9729) => Some((Filter::Linear, MipFilter::None)),
        Some(9984) => Some((Filter::Nearest, MipFilter::Nearest)),
        Some(9985) => Some((Filter::Linear, MipFilter::Nearest)),
        Some(9986) => Some((Filter::Nearest, MipFilter::Linear)),
        Some(code) => {
            unknown("minFilter", code);
            None
        }
    };
    if let Some((minification, mip)) = minification {
        sampler.minification = minification;
        sampler.mip = mip;
    }
    sampler
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(transform: &model::TextureTransform, [u, v]: [f32; 2]) -> [f32; 2] {
        uv_transform(transform).unwrap().rows.map(|r| r[0] * u + r[1] * v + r[2])
    }

    /// The atlas example of the extension: offset (0, 1), a quarter turn, half the size. It selects the lower left
    /// quarter of the image, turned.
    #[test]
    fn texture_transforms_turn_as_the_extension_shows() {
        let example = model::TextureTransform {
            offset: Some([0.0, 1.0]),
            rotation: Some(std::f64::consts::FRAC_PI_2),
            scale: Some([0.5, 0.5]),
            tex_coord: None,
        };
        let near = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
        assert!(near(apply(&example, [0.0, 0.0]), [0.0, 1.0]));
        assert!(near(apply(&example, [1.0, 0.0]), [0.0, 0.5]));
        assert!(near(apply(&example, [0.0, 1.0]), [0.5, 1.0]));
        assert!(near(apply(&example, [1.0, 1.0]), [0.5, 0.5]));
    }

    /// Scale applies before the rotation.
    #[test]
    fn scale_is_along_the_axes_of_the_coordinates() {
        let t = model::TextureTransform {
            offset: None,
            rotation: Some(std::f64::consts::FRAC_PI_2),
            scale: Some([3.0, 5.0]),
            tex_coord: None,
        };
        let [u, v] = apply(&t, [1.0, 0.0]);
        assert!(u.abs() < 1e-6 && (v + 3.0).abs() < 1e-6, "{u} {v}");
    }
}
