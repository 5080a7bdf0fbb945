//! The test scenes by name: what `model = "builtin:<name>"` of a golden refers to.

mod clouds;
pub mod compressed;
mod formats;
mod geometry;
mod lamps;
mod lighting;
mod materials;
mod models;
pub mod motion;
pub mod nodes;
mod paint;
mod splats;
mod surfaces;
mod texturing;
mod transmission;

use super::stage::Built;

/// A scene's name and what makes it.
pub type Entry = (&'static str, fn() -> Built);

/// All of them.
pub const SCENES: &[&[Entry]] = &[
    geometry::SCENES,
    materials::SCENES,
    paint::SCENES,
    models::SCENES,
    texturing::SCENES,
    lighting::SCENES,
    lamps::SCENES,
    transmission::SCENES,
    motion::SCENES,
    nodes::SCENES,
    compressed::SCENES,
    surfaces::SCENES,
    splats::SCENES,
    formats::SCENES,
    clouds::SCENES,
];

/// The scene of that name.
pub fn build(name: &str) -> Result<Built, String> {
    let known = || SCENES.iter().flat_map(|group| group.iter());
    known().find(|(n, _)| *n == name).map(|(_, build)| build()).ok_or_else(|| {
        let names: Vec<&str> = known().map(|(n, _)| *n).collect();
        format!("no built-in scene '{name}'; there are {}", names.join(", "))
    })
}
