//! glTF loading through the public interface: small files made in memory, and the corpus where there is one.

mod coats;
mod compressed;
mod corpus;
mod damaged;
mod far;
mod files;
mod geometry;
mod graph;
mod materials;
mod motion;
mod variants;
