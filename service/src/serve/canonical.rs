//! Options of a picture as the query that asks for it: equal pictures have equal texts, whatever way they were asked for.

use overcoat_description::DescriptionOption;
use overcoat_worker::protocol::PictureRequest;
use serde_json::Value;
use std::collections::BTreeMap;
use url::form_urlencoded;

/// The query, in the order of the names.
#[must_use]
pub fn query(request: &PictureRequest) -> String {
    let mut pairs = BTreeMap::new();
    for (key, value) in &request.keys {
        match value {
            Value::Object(camera) if key == "camera" => {
                pairs.extend(camera.iter().map(|(key, value)| (name_in_camera(key), text(value))));
            }
            Value::Array(sides) if key == "size" => {
                drop(
                    pairs.insert(
                        key.as_str(),
                        sides.iter().map(Value::to_string).collect::<Vec<_>>().join("x"),
                    ),
                );
            }
            value => drop(pairs.insert(key.as_str(), text(value))),
        }
    }
    pairs.insert("format", request.format.clone());
    if let Some(turn) = &request.turntable {
        pairs.insert("turntable", turn.frames.to_string());
        pairs.insert("fps", turn.fps.to_string());
    }
    if let Some(quality) = request.jpeg_quality {
        pairs.insert("jpeg_quality", quality.to_string());
    }
    if !request.aovs.is_empty() {
        pairs.insert("aov", request.aovs.join(","));
    }
    form_urlencoded::Serializer::new(String::new()).extend_pairs(pairs).finish()
}

/// The name in requests of a key of the table `camera`.
fn name_in_camera(key: &str) -> &str {
    let mut options = DescriptionOption::all();
    let option = options.find(|option| option.is_of_camera() && option.key() == key);
    option.and_then(DescriptionOption::request_name).unwrap_or(key)
}

/// A value as a query has it: numbers of a list with commas between them.
fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) if values.iter().all(Value::is_number) => {
            values.iter().map(Value::to_string).collect::<Vec<_>>().join(",")
        }
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::options::{of_pairs, tests::rules};
    use super::*;
    use overcoat::output::OutputFormat;

    fn asked(text: &str) -> PictureRequest {
        let options = of_pairs(form_urlencoded::parse(text.as_bytes()), &rules()).unwrap();
        options.request(options.format.unwrap_or(OutputFormat::Png), &rules()).unwrap().0
    }

    #[test]
    fn equal_pictures_have_equal_queries() {
        assert_eq!(query(&asked("view=front&size=64")), "format=png&size=64x64&view=front");
        assert_eq!(query(&asked("preset=thumb&height=32")), query(&asked("size=64x32&view=top&format=png")));
    }

    /// A canonical query asks for the same picture again.
    #[test]
    fn queries_can_be_asked() {
        for text in [
            "",
            "format=jpg&jpeg_quality=70",
            "eye=1,2,3&target=0,0.5,0&camera_up=0,0,1&up=z",
            "aov=depth,normal&format=exr",
            "K=60.5,60,32,24&intrinsics_size=64x64&pose=1,0,0,0,0,-1,0,0,0,0,-1,6,0,0,0,1&pose_convention=opencv",
            "fx=60&fy=60&cx=-3.25&cy=1e2",
            "background=102030&exposure=auto&lights=false&samples=4&quality=good",
            "light=%5B%7B%22type%22%3A%22point%22%2C%22position%22%3A%5B1%2C2%2C3%5D%2C%22intensity%22%3A1%7D%5D",
        ] {
            let first = asked(text);
            let again = asked(&query(&first));
            let json = |request: &PictureRequest| serde_json::to_value(request).unwrap();
            assert_eq!(json(&first), json(&again), "{text}: {}", query(&first));
        }
    }
}
