//! A JSON schema of scene files, for editors and for programs that write them, made of the tables of keys.

use super::keys::{Key, SCENE};
use super::kind::{Kind, Material};
use serde_json::{Map, Value, json};

/// The JSON schema (draft 7) of scene files, in JSON or TOML. What it allows is read without a warning, unless a name leads
/// nowhere. The same text is in the repository as `crates/description/src/scene.schema.json`.
///
/// It refuses some things that are read: keys in other spellings, which get a warning, and names of colours and axes in
/// capitals; and `null`, which stands for a key that is not there.
#[must_use]
pub fn scene_schema() -> String {
    let mut schema = table(SCENE, &[]);
    schema["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    schema["title"] = json!("Scene file of overcoat");
    schema["description"] = json!("What a picture shows and how. Every key may be left out.");
    // Keys of this crate's maps are sorted, and all of them are text: nothing can fail.
    let text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text + "\n"
}

/// A table with these keys, of which some must be there.
pub(super) fn table<T>(keys: &'static [Key<T>], required: &[&str]) -> Value {
    let properties: Map<String, Value> =
        keys.iter().map(|key| (key.name.to_owned(), property(key))).collect();
    let mut table = json!({"type": "object", "properties": properties, "additionalProperties": false});
    if !required.is_empty() {
        table["required"] = json!(required);
    }
    table
}

/// JSON schema of a key, with its sentence.
pub(super) fn property<T>(key: &Key<T>) -> Value {
    let mut schema = (key.schema)();
    schema["description"] = json!(key.sentence());
    schema
}

/// Anything.
pub(super) fn anything() -> Value {
    json!({})
}

/// A list.
pub(super) fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

pub(super) fn materials() -> Value {
    json!({"type": "object", "additionalProperties": Material.schema()})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Description;
    use crate::kind::HEX_COLOR;
    use std::path::Path;

    #[test]
    fn the_schema_in_the_repository_is_that_of_the_keys() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scene.schema.json");
        if std::env::var_os("UPDATE_SCHEMA").is_some_and(|value| value == "1") {
            std::fs::write(&path, scene_schema()).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            kept == scene_schema(),
            "crates/description/src/scene.schema.json is out of date: UPDATE_SCHEMA=1 cargo test -p overcoat-description schema writes \
             it"
        );
    }

    /// As much of JSON schema as is used here.
    fn fits(schema: &Value, value: &Value) -> bool {
        let Value::Object(rules) = schema else { panic!("{schema}") };
        rules.iter().all(|(rule, wanted)| match rule.as_str() {
            "$schema" | "title" | "description" | "examples" => true,
            "type" => match wanted.as_str().unwrap() {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "boolean" => value.is_boolean(),
                "number" => value.is_number(),
                "integer" => value.is_u64() || value.is_i64(),
                other => panic!("{other}"),
            },
            "enum" => wanted.as_array().unwrap().contains(value),
            "const" => wanted == value,
            "anyOf" => wanted.as_array().unwrap().iter().any(|schema| fits(schema, value)),
            "minimum" => value.as_f64().is_none_or(|v| v >= wanted.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|v| v <= wanted.as_f64().unwrap()),
            "minItems" => value.as_array().is_none_or(|list| list.len() as u64 >= wanted.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|list| list.len() as u64 <= wanted.as_u64().unwrap()),
            "items" => value.as_array().is_none_or(|list| list.iter().all(|item| fits(wanted, item))),
            "required" => value.as_object().is_none_or(|table| {
                wanted.as_array().unwrap().iter().all(|k| table.contains_key(k.as_str().unwrap()))
            }),
            "properties" => value.as_object().is_none_or(|table| {
                table.iter().all(|(key, value)| wanted.get(key).is_none_or(|schema| fits(schema, value)))
            }),
            "additionalProperties" => value.as_object().is_none_or(|table| {
                let others = || {
                    table.iter().filter(|(key, _)| {
                        rules.get("properties").is_none_or(|known| known.get(key.as_str()).is_none())
                    })
                };
                match wanted {
                    Value::Bool(false) => others().next().is_none(),
                    schema => others().all(|(_, value)| fits(schema, value)),
                }
            }),
            "pattern" => value.as_str().is_none_or(|text| match wanted.as_str().unwrap() {
                HEX_COLOR => overcoat_core::color::hex_color(text).is_some_and(|(_, alpha)| alpha.is_none()),
                "^[^,]+,[^,]+,[^,]+$" => text.split(',').filter(|part| !part.is_empty()).count() == 3,
                _ => text.contains(['/', '\\']) || text.ends_with(".toml"),
            }),
            other => panic!("the test does not know {other}"),
        })
    }

    fn agree(value: &Value, good: bool) {
        let schema: Value = serde_json::from_str(&scene_schema()).unwrap();
        let read = Description::from_json(&value.to_string());
        assert_eq!(read.as_ref().is_ok_and(|file| file.warnings.is_empty()), good, "{value}: {read:?}");
        assert_eq!(fits(&schema, value), good, "{value}");
    }

    /// A text that names the environments names all there are.
    #[test]
    fn environments_are_named_by_their_key() {
        let schema: Value = serde_json::from_str(&scene_schema()).unwrap();
        let about = schema["properties"]["env"]["description"].as_str().unwrap();
        assert!(about.contains(&overcoat_load::NamedEnvironment::sentence([])), "{about}");
    }

    /// The schema says yes where the reader does, and no where it does not.
    #[test]
    fn the_schema_says_what_the_reader_says() {
        let light = |kind: &str, rest: Value| {
            let mut light = rest;
            light["type"] = json!(kind);
            light["intensity"] = json!(1.5);
            json!({"light": [light]})
        };
        let spot =
            json!({"position": [0, 0, 0], "target": [0, 1, 0], "outer_cone_deg": 30, "min_roughness": 0.5});
        for good in [
            json!({}),
            json!({"name": "x", "note": 7, "peers": [], "ground_truth": {}}),
            json!({"model": "a.glb", "up": "-z", "env": "sky.hdr", "env_rotation_deg": -400, "env_intensity": 0}),
            json!({"size": 64, "samples": 8, "background": "#102030", "tone_mapping": "linear", "exposure": -1}),
            json!({"size": [64, 32], "background": "teal", "tone_mapping": ["aces", "none"], "exposure": "auto"}),
            json!({"background": "env", "shading": "gltf", "anisotropy": 16, "area_lights": "facets"}),
            json!({"merge_angle_deg": 45, "line_width": 0.1, "point_size": 64, "lights": false}),
            json!({"ground": "shadow"}),
            json!({"ground": "#456"}),
            json!({"quality": "best", "maps": 0, "map_size": 2048, "rays": 256}),
            json!({"material": "velvet", "materials": {"a": "x.toml", "b": "x/y"}}),
            json!({"animation": 0, "time": 0.5, "loop": true}),
            json!({"camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 0.1, "near": 1}}),
            json!({"camera": {"view": "1,2,3", "ortho_height": 0, "camera": "a", "far": 1}}),
            json!({"camera": {"view": "front"}}),
            light("directional", json!({"direction": [0, -1, 0], "color": "#fff"})),
            light("point", json!({"position": [0, 0, 0], "range": 3, "color": [1, 2, 3]})),
            light("spot", spot.clone()),
            light(
                "rect",
                json!({"position": [0, 0, 0], "target": [0, 1, 0], "size": [1, 2], "two_sided": true}),
            ),
            light("tube", json!({"from": [0, 0, 0], "to": [0, 1, 0], "radius": 0.1})),
        ] {
            agree(&good, true);
        }
        for bad in [
            json!([]),
            json!({"modle": "a"}),
            json!({"model": 7}),
            json!({"up": "w"}),
            json!({"env_intensity": -1}),
            json!({"size": [640]}),
            json!({"size": -1}),
            json!({"samples": 5}),
            json!({"background": "whitish"}),
            json!({"tone_mapping": ["linear", "filmic"]}),
            json!({"exposure": 65}),
            json!({"exposure": "bright"}),
            json!({"shading": "phong"}),
            json!({"material": "velvit"}),
            json!({"materials": {"a": 1}}),
            json!({"anisotropy": 17}),
            json!({"anisotropy": 2.5}),
            json!({"lights": "no"}),
            json!({"ground": "env"}),
            json!({"ground": "shadows"}),
            json!({"quality": "ultra"}),
            json!({"maps": 257}),
            json!({"map_size": 16}),
            json!({"time": -1}),
            json!({"animation": true}),
            json!({"merge_angle_deg": 46}),
            json!({"envIntensity": 1}),
            json!({"camera": [1]}),
            json!({"camera": {"eye": [1, 2]}}),
            json!({"camera": {"fov_y_deg": 180}}),
            json!({"camera": {"view": "sideways"}}),
            json!({"light": {}}),
            json!({"light": [{}]}),
            json!({"light": [{"type": "point", "position": [0, 0, 0]}]}),
            light("area", json!({})),
            light("point", json!({})),
            light("tube", spot),
        ] {
            agree(&bad, false);
        }
    }
}
