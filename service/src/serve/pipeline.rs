//! The part of Imaginary's interface that Nextcloud and others ask previews by.

use super::answer::SIZE;
use super::error::{Kind, Problem};
use super::options::Options;
use super::rules::Rules;
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use serde::Deserialize;
use serde_json::Value;
use url::form_urlencoded;

/// A step: those that turn, crop or strip pictures have nothing to do here.
#[derive(Debug, Deserialize)]
struct Operation {
    #[serde(default)]
    params: Params,
}

#[derive(Debug, Default, Deserialize)]
struct Params {
    width: Option<Value>,
    height: Option<Value>,
    #[serde(rename = "type")]
    format: Option<String>,
    quality: Option<Value>,
}

/// Options of a query: width, height, type and quality of the last operation that has them. What is too large is made smaller,
/// as a preview is as large as it can be.
///
/// # Errors
/// [`Kind::Options`].
pub fn read(query: &str, rules: &Rules) -> Result<Options, Problem> {
    let wrong = |reason: &str| Problem::new(Kind::Options, format!("operations: {reason}"));
    let pairs = form_urlencoded::parse(query.as_bytes());
    let text = pairs.into_iter().find(|(key, _)| key == "operations").map(|(_, text)| text);
    let text = text.ok_or_else(|| wrong("expected a list in JSON"))?;
    let all: Vec<Operation> = serde_json::from_str(&text).map_err(|e| wrong(&e.to_string()))?;
    let mut options = Options::default();
    let mut size = (None, None);
    for Operation { params } in all {
        let side = |value: &Option<Value>| whole(value.as_ref()?).filter(|side| *side > 0);
        size = (side(&params.width).or(size.0), side(&params.height).or(size.1));
        if let Some(format) = params.format.filter(|format| format != "auto") {
            options.set("format", &format, rules)?;
            // Nothing moves here.
            options.extension(rules.format)?;
        }
        if let Some(quality) = params.quality.as_ref().and_then(whole) {
            options.set("jpeg_quality", &quality.to_string(), rules)?;
        }
    }
    let (width, height) = match size {
        (Some(width), Some(height)) => (width, height),
        (Some(side), None) | (None, Some(side)) => (side, side),
        (None, None) => return Ok(options),
    };
    let most = u64::from(rules.max_size);
    let longest = width.max(height);
    let fit = |side: u64| {
        if longest > most {
            ((u128::from(side) * u128::from(most)) / u128::from(longest)).max(1)
        } else {
            side.into()
        }
    };
    options.set("size", &format!("{}x{}", fit(width), fit(height)), rules)?;
    Ok(options)
}

/// Tells the size as Imaginary does with `-return-size`. Nextcloud keeps such a picture as it is, and decodes and encodes any other one
/// once more.
pub fn tell_size(headers: &mut HeaderMap) {
    let sides = |size: &HeaderValue| {
        let (width, height) = size.to_str().ok()?.split_once('x')?;
        Some((HeaderValue::from_str(width).ok()?, HeaderValue::from_str(height).ok()?))
    };
    if let Some((width, height)) = headers.get(SIZE).and_then(sides) {
        headers.insert(HeaderName::from_static("image-width"), width);
        headers.insert(HeaderName::from_static("image-height"), height);
    }
}

/// A whole number, or a text that is one.
fn whole(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| value.as_str()?.parse().ok())
}

#[cfg(test)]
mod tests {
    use super::super::options::tests::rules;
    use super::*;
    use overcoat::output::OutputFormat;

    fn read(json: &str) -> Result<Options, Problem> {
        let query: String =
            form_urlencoded::Serializer::new(String::new()).append_pair("operations", json).finish();
        super::read(&query, &rules())
    }

    #[test]
    fn previews_of_nextcloud_are_understood() {
        let asked = r#"[{"operation":"autorotate"},{"operation":"fit","params":{"width":4096,"height":2048,"stripmeta":"true","type":"jpeg","norotation":"true","quality":"80"}}]"#;
        let options = read(asked).unwrap();
        assert_eq!((options.size(), options.format), (Some([1024, 512]), Some(OutputFormat::Jpeg)));
        let (request, _) = options.request(OutputFormat::Jpeg, &rules()).unwrap();
        assert_eq!(request.jpeg_quality, Some(80));
        assert_eq!(read(r#"[{"operation":"resize","params":{"width":64}}]"#).unwrap().size(), Some([64, 64]));
        assert_eq!(read("[]").unwrap().size(), None);
        for wrong in ["", "{}", r#"[{"params":{"type":"gif"}}]"#, r#"[{"params":{"quality":0}}]"#] {
            assert_eq!(read(wrong).unwrap_err().kind, Kind::Options, "{wrong}");
        }
        assert!(super::super::pipeline::read("", &rules()).is_err());
    }
}
