//! Files that come with a call, by their names.

use crate::sentence;
use js_sys::{Array, Uint8Array};
use overcoat::Limits;
use overcoat::jobs::Jobs;
use overcoat::load::{Context, GivenPictures, MemoryResolver};
use overcoat::scene::Image;
use std::sync::Arc;
use wasm_bindgen::{JsCast, JsValue};

/// Beginning of the names of pictures that are no files: width and height in four bytes each, least first, and bytes R, G, B, A.
const PICTURE: &str = "array/";

/// Named files and pictures that a model, a material or an environment may refer to.
#[derive(Default)]
pub(crate) struct Files {
    pub(crate) resolver: MemoryResolver,
    pub(crate) pictures: GivenPictures,
}

impl Files {
    /// Takes over contents, which are `Uint8Array`s, under their names.
    pub(crate) fn new(names: Vec<String>, contents: &Array) -> Result<Self, JsValue> {
        let mut all = Self::default();
        for (name, content) in names.into_iter().zip(contents.iter()) {
            let content = content.dyn_into::<Uint8Array>();
            let content = content.map_err(|_| sentence(format!("files: '{name}' is no Uint8Array")))?;
            if name.starts_with(PICTURE) {
                let image = image(&content.to_vec());
                let image = image.ok_or_else(|| sentence(format!("files: '{name}' is no picture")))?;
                all.pictures.insert(name, Arc::new(image));
            } else {
                all.resolver.files.insert(name, content.to_vec());
            }
        }
        Ok(all)
    }

    /// The context of a loader that reads these files.
    pub(crate) fn context<'a>(&'a self, limits: &'a Limits, jobs: &'a Jobs) -> Context<'a> {
        Context { resolver: &self.resolver, limits, jobs }
    }
}

/// A picture of width, height and texels.
fn image(bytes: &[u8]) -> Option<Image> {
    let (width, rest) = bytes.split_first_chunk::<4>()?;
    let (height, texels) = rest.split_first_chunk::<4>()?;
    let (texels, []) = texels.as_chunks::<4>() else { return None };
    Image::new(u32::from_le_bytes(*width), u32::from_le_bytes(*height), texels.to_vec()).ok()
}
