//! Definition of an attack.

use std::path::Path;

/// Required outcome.
#[derive(Clone, Copy, Debug)]
pub enum Must {
    /// Exit code 1, and a message with this in it.
    Fail(&'static str),
    /// Exit code 2, and a message with this in it.
    Misuse(&'static str),
    /// Exit code 3, and a message with this in it: the name of the limit, most often.
    Exceed(&'static str),
    /// A picture, and a warning with this in it.
    Warn(&'static str),
    /// A picture without any warning: there is nothing wrong with it, it only looks like it.
    Draw,
}

/// Request to the program.
#[derive(Clone, Copy, Debug)]
pub enum Ask {
    /// To draw this model.
    Model(&'static str),
    /// To light a triangle with this environment.
    Environment(&'static str),
    /// To cover a triangle with this material.
    Material(&'static str),
    /// To draw what this scene file describes.
    Scene(&'static str),
}

/// One attack: files in a folder of their own, named by what they try.
pub struct Attack {
    /// Short and unique.
    pub name: &'static str,
    /// Aim of the attack.
    pub tries: &'static str,
    /// Files in the folder.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Preparation of all else in the folder or beside it (`../`): links, pipes.
    pub prepare: Option<fn(&Path)>,
    pub ask: Ask,
    pub must: Must,
}

impl Attack {
    /// An attack by one model file.
    pub fn model(
        name: &'static str,
        tries: &'static str,
        file: &'static str,
        bytes: impl Into<Vec<u8>>,
        must: Must,
    ) -> Self {
        let files = vec![(file, bytes.into())];
        Self { name, tries, files, prepare: None, ask: Ask::Model(file), must }
    }

    /// An attack by one environment file.
    pub fn environment(
        name: &'static str,
        tries: &'static str,
        file: &'static str,
        bytes: impl Into<Vec<u8>>,
        must: Must,
    ) -> Self {
        Self { ask: Ask::Environment(file), ..Self::model(name, tries, file, bytes, must) }
    }

    /// An attack by a material file, `x.toml`.
    pub fn material(name: &'static str, tries: &'static str, text: impl Into<Vec<u8>>, must: Must) -> Self {
        Self { ask: Ask::Material("x.toml"), ..Self::model(name, tries, "x.toml", text, must) }
    }

    /// An attack by a scene file, `x.json` or `x.toml`, beside a good model, `good.obj`.
    pub fn scene(
        name: &'static str,
        tries: &'static str,
        file: &'static str,
        text: impl Into<Vec<u8>>,
        must: Must,
    ) -> Self {
        Self { ask: Ask::Scene(file), ..Self::model(name, tries, file, text, must) }
    }

    /// With another file in its folder.
    pub fn with(mut self, name: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.push((name, bytes.into()));
        self
    }

    /// With something in its folder that is no file.
    pub fn prepared(mut self, prepare: fn(&Path)) -> Self {
        self.prepare = Some(prepare);
        self
    }
}

/// Every attack, by what it comes in.
pub fn all() -> Vec<Attack> {
    let mut all = Vec::new();
    all.extend(super::documents::attacks());
    all.extend(super::accessors::attacks());
    all.extend(super::graphs::attacks());
    all.extend(super::pictures::attacks());
    all.extend(super::meshes::attacks());
    all.extend(super::descriptions::attacks());
    all.extend(super::paths::attacks());
    all
}
