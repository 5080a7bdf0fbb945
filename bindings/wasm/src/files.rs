//! Files that come with a call, by their names.

use crate::sentence;
use js_sys::{Array, Uint8Array};
use overcoat::Limits;
use overcoat::jobs::Jobs;
use overcoat::load::{Context, MemoryResolver};
use wasm_bindgen::{JsCast, JsValue};

/// Named files that a model, a material or an environment may refer to.
#[derive(Default)]
pub(crate) struct Files(pub(crate) MemoryResolver);

impl Files {
    /// Takes over contents, which are `Uint8Array`s, under their names.
    pub(crate) fn new(names: Vec<String>, contents: &Array) -> Result<Self, JsValue> {
        let mut files = MemoryResolver::default();
        for (name, content) in names.into_iter().zip(contents.iter()) {
            let content = content.dyn_into::<Uint8Array>();
            let content = content.map_err(|_| sentence(format!("files: '{name}' is no Uint8Array")))?;
            files.files.insert(name, content.to_vec());
        }
        Ok(Self(files))
    }

    /// The context of a loader that reads these files.
    pub(crate) fn context<'a>(&'a self, limits: &'a Limits, jobs: &'a Jobs) -> Context<'a> {
        Context { resolver: &self.0, limits, jobs }
    }
}
