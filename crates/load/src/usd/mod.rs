//! USD, Universal Scene Description: `usda` (text), `usdc` (binary) and `usdz` (both, with textures in a package).
//!
//! Layers of either syntax become one model (`layer.rs`), their opinions are composed into prims (`compose.rs`), and these are drawn:
//! meshes and simple shapes with preview surfaces, at the first of their samples over time. Subdivision surfaces are drawn as their
//! cage, skins at rest; proxies, guides and what is invisible are left out. Units become metres, and the axis that is up is that of
//! the root layer.

mod camera;
mod compose;
mod crate_file;
mod crate_values;
mod curves;
mod dome;
mod files;
mod layer;
mod lights;
mod look;
mod lz4;
#[cfg(feature = "material-files")]
mod materialx;
#[cfg(not(feature = "material-files"))]
#[path = "without_materialx.rs"]
mod materialx;
mod mesh;
mod network;
mod points;
mod scene;
mod shapes;
#[cfg(test)]
mod tests;
mod text;
mod tube;
mod xform;

use super::archive::{self, Archive};
use super::budget::Budget;
use super::mesh_formats::{check_input, finish};
use super::shares::Shares;
use super::text::without_mark;
use super::warnings::Warnings;
use super::zipped::ZipResolver;
use super::{Context, LoadError, Loaded, TextureLoading};
use compose::Stage;
use files::Files;
use overcoat_scene::{Axis, Transform};

const FORMAT: &str = "USD";

/// True for layers of either syntax.
pub(crate) fn is_layer(bytes: &[u8]) -> bool {
    bytes.starts_with(crate_file::MAGIC) || without_mark(bytes).starts_with(b"#usda")
}

/// True for a package by the names of its parts: the first is the layer that is shown (*Usdz File Format Specification*).
pub(crate) fn is_package(names: &[String]) -> bool {
    let ends = |name: &String| [".usda", ".usdc", ".usd"].iter().any(|end| name.ends_with(end));
    names.first().is_some_and(ends)
}

/// Reads a layer or a package, and what it refers to.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    if !bytes.starts_with(archive::MAGIC) {
        return read(bytes, context, loading, shares);
    }
    let mut warnings = Warnings::default();
    let archive = Archive::open(FORMAT, bytes, context.limits, &mut warnings)?;
    let names = archive::names(bytes, 1);
    let Some(name) = names.into_iter().next().filter(|name| is_package(std::slice::from_ref(name))) else {
        return Err(LoadError::malformed(FORMAT, "the first part of the package is no layer"));
    };
    let mut budget = Budget::new(context.limits);
    let content = archive.read(&name, &mut budget)?;
    let resolver = ZipResolver::new(archive, name, budget);
    let inner = Context { resolver: &resolver, limits: context.limits, jobs: context.jobs };
    let mut loaded = read(&content, &inner, loading, shares)?;
    loaded.warnings.extend(warnings.finish());
    Ok(loaded)
}

/// Reads a layer.
fn read(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    let mut files = Files::new(context, shares);
    let mut layer = files::read_layer(bytes, context, &mut files.budget, &mut files.warnings)?;
    layer.name = context.resolver.model_name().unwrap_or_default().to_owned();
    let stage = Stage::new(files, layer)?;
    // Centimetres and +Y without a word.
    let unit =
        stage.setting(|layer| layer.meters_per_unit).filter(|&v| v > 0.0 && v.is_finite()).unwrap_or(0.01);
    let up = match stage.setting(|layer| layer.up.clone()).as_deref() {
        Some("Z") => Axis::PositiveZ,
        _ => Axis::PositiveY,
    };
    let unit = Transform::scaling(unit).map_err(LoadError::scene("USD: metersPerUnit"))?;
    let (mut scene, warnings) = scene::build(stage, &unit, up == Axis::PositiveZ, loading)?;
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    Ok(Loaded { up: Some(up), ..finish(scene, warnings.finish()) })
}
