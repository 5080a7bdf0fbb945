//! Views of EXT_meshopt_compression and KHR_meshopt_compression.

use super::encoder::{Random, attributes, triangles};
use super::model::{Model, push};
use serde_json::{Value, json};

/// Compressed views of one document, over a fallback buffer of their own that does not exist.
pub struct Views {
    random: Random,
    extension: &'static str,
    version: u8,
    /// Number of the fallback buffer.
    buffer: usize,
    /// Bytes of the fallback buffer so far.
    length: usize,
}

impl Views {
    /// Version 1 of the attributes is KHR_meshopt_compression's alone.
    pub fn new(extension: &'static str, version: u8, buffer: usize) -> Self {
        Self { random: Random::new(42), extension, version, buffer, length: 0 }
    }

    /// A view of vertices.
    pub fn attributes(&mut self, model: &mut Model, elements: &[u8], stride: usize, filter: &str) -> usize {
        let stream = attributes(elements, stride, self.version, &mut self.random);
        let mut about = json!({"mode": "ATTRIBUTES", "byteStride": stride, "count": elements.len() / stride});
        if filter != "NONE" {
            about["filter"] = filter.into();
        }
        let view = self.view(model, &stream, about, elements.len());
        model.json["bufferViews"][view]["byteStride"] = stride.into();
        view
    }

    /// A view of the indices of triangles, 32 bits each.
    pub fn triangles(&mut self, model: &mut Model, corners: &[u32]) -> usize {
        let stream = triangles(corners, &mut self.random);
        let about = json!({"mode": "TRIANGLES", "byteStride": 4, "count": corners.len()});
        self.view(model, &stream, about, corners.len() * 4)
    }

    fn view(&mut self, model: &mut Model, stream: &[u8], mut about: Value, length: usize) -> usize {
        about["buffer"] = 0.into();
        about["byteOffset"] = model.bytes.len().into();
        about["byteLength"] = stream.len().into();
        model.bytes.extend(stream);
        let mut view = json!({"buffer": self.buffer, "byteOffset": self.length, "byteLength": length});
        view["extensions"] = json!({self.extension: about});
        self.length = (self.length + length).next_multiple_of(4);
        push(&mut model.json["bufferViews"], view)
    }

    /// The fallback buffer.
    pub fn fallback(&self) -> Value {
        json!({"byteLength": self.length, "extensions": {self.extension: {"fallback": true}}})
    }
}
