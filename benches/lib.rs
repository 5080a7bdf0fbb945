//! Speed of overcoat: stages, shading models, whole frames. The programs are beside this file; they decide nothing.
//!
//! `cargo bench -p overcoat-benches --bench models` runs one of them.
