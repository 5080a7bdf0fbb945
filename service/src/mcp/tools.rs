//! The tools: names, sentences, and schemas of their arguments, of the one table of options.

use overcoat::load::NamedEnvironment;
use overcoat_description::DescriptionOption;
use rmcp::model::{JsonObject, Tool, ToolAnnotations};
use serde_json::{Map, Value, json};

/// Views of the tool `views`, unless others are asked for.
pub const VIEWS: [&str; 6] = ["three-quarter", "front", "right", "back", "left", "top"];

/// All tools.
#[must_use]
pub fn all() -> Vec<Tool> {
    let model =
        || json!({"type": "string", "description": "Path of the model file, from the root or absolute."});
    let options = || options_schema();
    let tool = |name: &'static str, sentence: &'static str, properties: Value, required: Value| {
        let schema = json!({
            "type": "object", "properties": properties, "required": required, "additionalProperties": false,
        });
        let Value::Object(schema) = schema else { return Tool::new(name, sentence, JsonObject::new()) };
        let hints = ToolAnnotations::new().read_only(name != "render").destructive(false).open_world(false);
        Tool::new(name, sentence, schema).annotate(hints)
    };
    vec![
        tool(
            "render",
            "Render a 3D model to a picture. Returns the picture, and a report with warnings, camera and hash. The same \
             arguments give the same pixels on every machine.",
            json!({
                "model": model(),
                "options": options(),
                "save": {"type": "string", "description": "Path of a new file below the root for the picture, if the server was \
                                                            started with --write."},
            }),
            json!(["model"]),
        ),
        tool(
            "views",
            "Render a 3D model from several sides: one picture for each view, in their order.",
            json!({
                "model": model(),
                "views": {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 16,
                          "description": format!("Names of views, or directions x,y,z. Default: {}.", VIEWS.join(", "))},
                "options": options(),
            }),
            json!(["model"]),
        ),
        tool(
            "diagnose",
            "Tell what is wrong with the picture that `render` makes of the same arguments: too bright or dark, cut off, tiny, empty, \
             no light, back faces, missing textures, up axis in doubt. Each finding has a code, numbers and the option that mends it.",
            json!({ "model": model(), "options": options() }),
            json!(["model"]),
        ),
        tool(
            "info",
            "Tell what is in a model file: triangles, size, materials, textures, lights, cameras, animations, variants, warnings.",
            json!({ "model": model() }),
            json!(["model"]),
        ),
        tool(
            "compare_models",
            "Render two model files from one camera, side by side with their difference.",
            json!({
                "before": model(),
                "after": model(),
                "size": {"type": "integer", "minimum": 16, "maximum": 2048, "description": "Side of each picture in pixels."},
            }),
            json!(["before", "after"]),
        ),
        tool(
            "compare_pictures",
            "Compare a picture with the expected one by equality, PSNR, SSIM and FLIP.",
            json!({
                "expected": {"type": "string", "description": "Path of the expected picture."},
                "actual": {"type": "string", "description": "Path of the actual picture."},
                "preset": {"type": "string", "enum": ["exact", "gpu"], "description": "Tolerance; exact is equality."},
            }),
            json!(["expected", "actual"]),
        ),
        tool(
            "materials",
            "List the built-in materials, or print one: a file to start from, and the value of the option `material`.",
            json!({ "name": {"type": "string", "description": "Name of one of them."} }),
            json!([]),
        ),
    ]
}

/// Schema of the options of a picture: those of requests to the service, with their sentences.
fn options_schema() -> Value {
    let mut properties: Map<String, Value> = Map::new();
    let mut add = |name: &str, sentence: String, names: Vec<&str>| {
        let values = if names.is_empty() { String::new() } else { format!(" Values: {}.", names.join(", ")) };
        properties.insert(name.to_owned(), json!({ "description": format!("{sentence}{values}") }));
    };
    add("size", "Pixels of a side, or WIDTHxHEIGHT.".to_owned(), vec![]);
    add("format", "Format of the picture.".to_owned(), vec!["png", "webp", "jpg"]);
    add("env", "Light around the model.".to_owned(), NamedEnvironment::names().collect());
    add("material", "A built-in material over the whole model.".to_owned(), vec![]);
    for option in DescriptionOption::all() {
        if let Some(name) = option.request_name() {
            add(name, option.help().into_owned(), option.names());
        }
    }
    json!({
        "type": "object",
        "properties": properties,
        "description": "Options of the picture, as those of overcoat render with _ for -.",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tool_has_a_schema_and_options_come_from_the_table() {
        for tool in all() {
            assert_eq!(tool.input_schema["type"], "object", "{}", tool.name);
            assert!(tool.description.is_some_and(|text| text.len() > 20));
        }
        let schema = options_schema();
        for name in ["size", "view", "quality", "shading", "camera_up", "background", "exposure", "ground"] {
            let text = schema["properties"][name]["description"].as_str().unwrap_or_default();
            assert!(text.len() > 10, "{name}");
        }
        assert!(schema["properties"].get("model").is_none());
    }
}
