//! glTF loading through the public interface: small files made in memory, and the corpus where there is one.

mod compressed;
mod corpus;
mod damaged;
mod files;
mod geometry;
mod graph;
mod materials;
mod model;
mod motion;
mod variants;
