//! A second reading of documents that are JSON and not quite glTF: of an element, what cannot be read is left out, key by
//! key, and the rest is kept. Slower, and only for documents that the first reading refuses.

use super::model::Root;
use crate::warnings::Warnings;
use serde::Deserialize;
use serde_json::{Map, Value};

/// Names of elements for messages, by the name of their list in the document.
const KINDS: [(&str, &str); 14] = [
    ("accessors", "accessor"),
    ("animations", "animation"),
    ("bufferViews", "bufferView"),
    ("buffers", "buffer"),
    ("cameras", "camera"),
    ("extensionsRequired", "extensionsRequired"),
    ("extensionsUsed", "extensionsUsed"),
    ("images", "image"),
    ("materials", "material"),
    ("meshes", "mesh"),
    ("nodes", "node"),
    ("samplers", "sampler"),
    ("scenes", "scene"),
    ("textures", "texture"),
];

/// Deepest object, counted from an element, of which single keys are left out.
const DEPTH: u32 = 5;
/// Values that are looked at to find what cannot be read; elements are left out whole after that.
const MOST_WORK: u64 = 1 << 22;

/// Reads a document that keeps to the rules, by way of the tree.
pub(super) fn strictly(text: &[u8]) -> Result<Root, serde_json::Error> {
    Root::deserialize(&serde_json::from_slice::<Value>(text)?)
}

/// Reads the document of a text that [`super::json::parse`] has refused because of `reason`. `None` if it is not JSON, or no
/// object.
pub(super) fn read(text: &[u8], reason: &str, warnings: &mut Warnings) -> Option<Root> {
    let mut document: Value = serde_json::from_slice(text).ok()?;
    if !document.is_object() {
        return None;
    }
    tidy(&mut document);
    if let Ok(root) = Root::deserialize(&document) {
        warnings.add(|| format!("the document breaks rules of glTF and is read as it is meant: {reason}"));
        return Some(root);
    }
    let Value::Object(given) = document else { return None };
    let mut pruner = Pruner { left: MOST_WORK, warnings };
    let mut kept = Map::new();
    for (key, value) in given {
        let value = pruner.member(&key, value)?;
        kept.insert(key, value);
    }
    Root::deserialize(&Value::Object(kept)).ok()
}

/// Removes `null`s from objects, where others leave the key out, and makes text of names and versions that are numbers.
fn tidy(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|_, value| !value.is_null());
            for (key, value) in map {
                let is_text = matches!(key.as_str(), "name" | "version" | "minVersion" | "uri" | "generator");
                if is_text && (value.is_number() || value.is_boolean()) {
                    *value = Value::String(value.to_string());
                }
                tidy(value);
            }
        }
        Value::Array(list) => list.iter_mut().for_each(tidy),
        _ => {}
    }
}

/// Test of an element of the document; the error says why it cannot be read.
type Check<'c> = dyn Fn(&Value) -> Result<(), String> + 'c;

/// Leaves out what cannot be read.
struct Pruner<'w> {
    left: u64,
    warnings: &'w mut Warnings,
}

impl Pruner<'_> {
    /// A member of the document, without what cannot be read of it. `None` if it is a list and should not be, or the other
    /// way round: that is no glTF.
    fn member(&mut self, key: &str, value: Value) -> Option<Value> {
        let readable = |value: Value| {
            let document = Value::Object(Map::from_iter([(key.to_owned(), value)]));
            Root::deserialize(&document).map(drop).map_err(|error| error.to_string())
        };
        match (value, KINDS.iter().find(|(list, _)| *list == key)) {
            (Value::Array(list), Some((_, kind))) => {
                let mut kept = Vec::with_capacity(list.len());
                for (number, element) in list.into_iter().enumerate() {
                    let check = |value: &Value| readable(Value::Array(vec![value.clone()]));
                    kept.push(self.prune(element, &format!("{kind} {number}"), 0, &check));
                }
                Some(Value::Array(kept))
            }
            (_, Some(_)) => None,
            (value, None) => Some(self.prune(value, key, 0, &|value: &Value| readable(value.clone()))),
        }
    }

    /// A value without what cannot be read of it: an empty object where that is all of it.
    fn prune(&mut self, value: Value, place: &str, depth: u32, check: &Check<'_>) -> Value {
        let Err(reason) = check(&value) else { return value };
        let nothing = Value::Object(Map::new());
        match value {
            Value::Object(map) if depth < DEPTH && self.affords(&map) => {
                let mut kept = Map::new();
                for (key, value) in map {
                    let with = |value: &Value| {
                        let mut all = kept.clone();
                        all.insert(key.clone(), value.clone());
                        Value::Object(all)
                    };
                    let inner = |value: &Value| check(&with(value));
                    let pruned =
                        self.prune(value, &format!("{place}, {key}"), depth.saturating_add(1), &inner);
                    if inner(&pruned).is_ok() {
                        kept.insert(key, pruned);
                    }
                }
                let kept = Value::Object(kept);
                if check(&kept).is_err() {
                    self.warnings
                        .add(|| format!("{place} cannot be read and is left out: {}", plain(&reason)));
                }
                kept
            }
            Value::Array(list) if depth > 0 && depth < DEPTH && list.iter().all(Value::is_object) => {
                let mut kept: Vec<Value> = Vec::with_capacity(list.len());
                for (number, element) in list.into_iter().enumerate() {
                    let inner = |value: &Value| check(&Value::Array(vec![value.clone()]));
                    let place = format!("{place} {number}");
                    kept.push(self.prune(element, &place, depth.saturating_add(1), &inner));
                }
                Value::Array(kept)
            }
            _ => {
                self.warnings.add(|| format!("{place} cannot be read and is left out: {}", plain(&reason)));
                nothing
            }
        }
    }

    /// Takes the work of trying all keys of an object; false if that is too much.
    fn affords(&mut self, map: &Map<String, Value>) -> bool {
        let all: u64 = map.values().map(size).fold(1, u64::saturating_add);
        let work = all.saturating_mul(map.len() as u64).saturating_mul(2);
        let rest = self.left.checked_sub(work);
        self.left = rest.unwrap_or(self.left);
        rest.is_some()
    }
}

/// The reason without the list's element, whose number is that of a trial.
fn plain(reason: &str) -> &str {
    let mut rest = reason;
    while let Some((kind, behind)) = rest.split_once(" 0: ") {
        if kind.contains(' ') {
            break;
        }
        rest = behind;
    }
    rest
}

/// Values in a value.
fn size(value: &Value) -> u64 {
    match value {
        Value::Array(list) => list.iter().map(size).fold(1, u64::saturating_add),
        Value::Object(map) => map.values().map(size).fold(1, u64::saturating_add),
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The document as read leniently, with the messages of the warnings.
    fn lenient(text: &str) -> (Root, Vec<String>) {
        let mut warnings = Warnings::default();
        let root = read(text.as_bytes(), "reason", &mut warnings).unwrap();
        (root, warnings.finish().into_iter().map(|warning| warning.message).collect())
    }

    #[test]
    fn small_faults_are_read_as_meant() {
        let text =
            r#"{"asset":{"version":2.0},"scene":1,"scene":0,"nodes":[{"name":7,"mesh":null,"camera":3}]}"#;
        let (root, warnings) = lenient(text);
        assert_eq!(root.scene.unwrap().get(), 0);
        assert_eq!(root.nodes.label(0), "node 0 '7'");
        assert!(root.nodes[0].mesh.is_none() && root.nodes[0].camera.is_some());
        assert_eq!(warnings, ["the document breaks rules of glTF and is read as it is meant: reason"]);
    }

    #[test]
    fn keys_that_cannot_be_read_are_left_out() {
        let text = r#"{"materials":[{},{"emissiveFactor":1,"doubleSided":true,"pbrMetallicRoughness":
            {"baseColorFactor":[1,0,0],"metallicFactor":0.5}}],"meshes":[{"primitives":[{"mode":5},{"mode":{}}]}],
            "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,1]}]}}}"#;
        let (root, warnings) = lenient(text);
        let metal = root.materials[1].pbr_metallic_roughness.as_deref().unwrap();
        assert!(root.materials[1].double_sided && metal.base_color_factor.is_none());
        assert_eq!(metal.metallic_factor, Some(0.5));
        assert_eq!(root.meshes[0].primitives.len(), 2);
        let lights = &root.extensions.lights.as_ref().unwrap().lights;
        assert!(lights.len() == 1 && lights[0].kind == "point" && lights[0].color.is_none());
        assert_eq!(
            warnings,
            [
                "extensions, KHR_lights_punctual, lights 0, color cannot be read and is left out: invalid length 2, \
                 expected an array of length 3",
                "material 1, emissiveFactor cannot be read and is left out: invalid type: integer `1`, expected an \
                 array of length 3",
                "material 1, pbrMetallicRoughness, baseColorFactor cannot be read and is left out: invalid length 3, \
                 expected an array of length 4",
                "mesh 0, primitives 1, mode cannot be read and is left out: invalid type: map, expected a whole number \
                 of at least 0",
            ]
        );
    }

    #[test]
    fn what_is_no_gltf_stays_refused() {
        for text in ["[]", "3", "{", r#"{"nodes":5}"#, r#"{"nodes":{"a":{}}}"#] {
            assert!(read(text.as_bytes(), "", &mut Warnings::default()).is_none(), "{text}");
        }
    }

    #[test]
    fn work_is_bounded() {
        let keys: Vec<String> = (0..100_000).map(|k| format!("\"k{k}\":{k}")).collect();
        let text = format!("{{\"nodes\":[{{\"matrix\":3,{}}}]}}", keys.join(","));
        let (root, warnings) = lenient(&text);
        assert_eq!(root.nodes.len(), 1);
        assert!(warnings[0].starts_with("node 0 cannot be read and is left out: "), "{warnings:?}");
    }
}
