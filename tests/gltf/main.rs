//! glTF loading through the public interface: small files made in memory, and the corpus where there is one.

mod coats;
mod compressed;
mod corpus;
mod damaged;
#[path = "../common/files/draco.rs"]
mod draco;
// The encoders of the decoder's own tests.
#[allow(dead_code)]
#[path = "../../src/load/gltf/meshopt/encoder.rs"]
mod encoder;
mod far;
mod files;
mod geometry;
mod graph;
mod materials;
#[path = "../common/files/meshopt.rs"]
mod meshopt;
mod model;
mod motion;
mod variants;
