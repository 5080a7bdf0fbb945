//! Content keys: names for pictures that say all that they were made of.

use crate::files::Needed;
use overcoat::load::Format;
use overcoat_worker::protocol::{PictureRequest, Start};
use serde_json::Value;
use std::collections::BTreeMap;

/// Content keys: two pictures with the same key have the same bytes.
///
/// BLAKE3 of the renderer's version, of the settings of all pictures (the contents of their files in place of the
/// paths), of the model, of every file that it refers to, and of the picture's own options. 64 hexadecimal digits.
#[derive(Clone, Debug)]
pub struct Keys {
    common: blake3::Hasher,
    /// Hashes of environments, by the names that pictures ask for them by.
    environments: BTreeMap<String, String>,
    /// Text that changes with what converters make of files that are not read here.
    converters: String,
}

impl Keys {
    /// Keys for this version of the program and the first message to workers; `files` are the contents of files that
    /// it refers to, by the paths that stand there; `converters` tells converters from others.
    #[must_use]
    pub fn new(start: &Start, files: &[(String, Vec<u8>)], converters: String) -> Self {
        let mut common = blake3::Hasher::new();
        part(&mut common, b"overcoat");
        part(&mut common, env!("CARGO_PKG_VERSION").as_bytes());
        // Memory, threads and sandbox change no picture; limits say whether there is one, but not which.
        let mut description = start.description.clone();
        for (path, bytes) in files {
            replace(&mut description, path, &hash_of(bytes));
        }
        part(&mut common, description.to_string().as_bytes());
        part(&mut common, start.variant.as_deref().unwrap_or_default().as_bytes());
        Self { common, environments: BTreeMap::new(), converters }
    }

    /// The same for pictures that may ask for environments by name, whose contents have these hashes.
    #[must_use]
    pub fn with_environments(self, environments: BTreeMap<String, String>) -> Self {
        Self { environments, ..self }
    }

    /// The key of a picture of a model, of which its BLAKE3 hash and its name are known.
    #[must_use]
    pub fn of(&self, model: &str, name: &str, needed: &[Needed], request: &PictureRequest) -> String {
        let mut hasher = self.common.clone();
        part(&mut hasher, model.as_bytes());
        // The extension holds information that the content does not.
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        part(&mut hasher, extension.to_ascii_lowercase().as_bytes());
        if !self.converters.is_empty() && Format::from_extension(extension).is_none() {
            part(&mut hasher, b"converted");
            part(&mut hasher, self.converters.as_bytes());
        }
        part(&mut hasher, &(needed.len() as u64).to_le_bytes());
        for file in needed {
            part(&mut hasher, file.name.as_bytes());
            part(&mut hasher, &[u8::from(file.alike)]);
            part(&mut hasher, file.hash.as_deref().unwrap_or("-").as_bytes());
        }
        let named = request.keys.get("env").and_then(Value::as_str);
        if let Some(hash) = named.and_then(|name| self.environments.get(name)) {
            part(&mut hasher, hash.as_bytes());
        }
        let request = serde_json::to_vec(request).unwrap_or_default();
        part(&mut hasher, &request);
        hasher.finalize().to_hex().to_string()
    }
}

/// Puts a hash in the place of a path, which is another one on another machine.
fn replace(value: &mut Value, path: &str, hash: &str) {
    match value {
        Value::String(text) if text == path => hash.clone_into(text),
        Value::Array(values) => values.iter_mut().for_each(|value| replace(value, path, hash)),
        Value::Object(values) => values.values_mut().for_each(|value| replace(value, path, hash)),
        _ => {}
    }
}

/// Adds a part with its length, so that no two lists of parts are alike.
fn part(hasher: &mut blake3::Hasher, bytes: &[u8]) {
    hasher.update(&(bytes.len() as u64).to_le_bytes());
    hasher.update(bytes);
}

/// The hash of a model, as [`Keys::of`] takes it.
#[must_use]
pub fn hash_of(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_changes_a_picture_changes_its_key() {
        let start = Start::default();
        let of = |start: &Start,
                  files: &[(String, Vec<u8>)],
                  model: &str,
                  name: &str,
                  needed: &[Needed],
                  size: u32| {
            let mut request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
            request.keys.insert("size".to_owned(), size.into());
            Keys::new(start, files, String::new()).of(model, name, needed, &request)
        };
        let texture = Needed::found("a.png", false, b"x");
        let plain = of(&start, &[], "m", "m.glb", &[], 64);
        assert_eq!(plain, of(&start, &[], "m", "other.GLB", &[], 64));
        let faster = Start { threads: 7, memory: Some(9), sandbox: true, ..Start::default() };
        assert_eq!(plain, of(&faster, &[], "m", "m.glb", &[], 64));
        let lit = |path: &str, bytes: u8| {
            let start = Start { description: serde_json::json!({"env": path}), ..Start::default() };
            of(&start, &[(path.to_owned(), vec![bytes])], "m", "m.glb", &[], 64)
        };
        // The place of a file changes no picture, its content does.
        assert_eq!(lit("/a/sky.hdr", 1), lit("/b/sky.hdr", 1));
        let described = Start { description: serde_json::json!({"quality": "good"}), ..Start::default() };
        let others = [
            of(&described, &[], "m", "m.glb", &[], 64),
            lit("/a/sky.hdr", 1),
            lit("/a/sky.hdr", 2),
            of(&start, &[], "n", "m.glb", &[], 64),
            of(&start, &[], "m", "m.obj", &[], 64),
            of(&start, &[], "m", "m.glb", std::slice::from_ref(&texture), 64),
            of(&start, &[], "m", "m.glb", &[Needed::missing("a.png", false)], 64),
            of(&start, &[], "m", "m.glb", &[Needed::found("a.png", false, b"y")], 64),
            of(&start, &[], "m", "m.glb", &[], 65),
        ];
        let of_converter = |name: &str, text: &str| {
            let request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
            Keys::new(&start, &[], text.to_owned()).of("m", name, &[], &request)
        };
        assert_eq!(of_converter("m.glb", "a"), of_converter("m.glb", "b"));
        assert_ne!(of_converter("m.step", "a"), of_converter("m.step", "b"));
        let mut all: Vec<&String> = others.iter().chain([&plain]).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 10);
    }

    #[test]
    fn environments_have_their_content_in_keys() {
        let of = |name: &str, hash: &str, asked: &str| {
            let named = BTreeMap::from([(name.to_owned(), hash.to_owned())]);
            let mut request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
            request.keys.insert("env".to_owned(), asked.into());
            Keys::new(&Start::default(), &[], String::new()).with_environments(named).of(
                "m",
                "m.glb",
                &[],
                &request,
            )
        };
        assert_eq!(of("sky", "1", "sky"), of("sky", "1", "sky"));
        assert_ne!(of("sky", "1", "sky"), of("sky", "2", "sky"));
        assert_eq!(of("sky", "1", "studio"), of("sky", "2", "studio"));
    }
}
