//! The native half of the Python package `overcoat`: objects of Python in, calls of the library, objects of Python out. What it
//! draws, and what options mean, is decided in the library alone; signatures that people use, with their documentation, are in
//! `python/overcoat/`.

mod arithmetic;
mod arrays;
mod builder;
mod command;
mod environment;
mod errors;
mod golden;
mod image;
mod kept;
mod material;
mod memory;
mod model;
mod movie;
mod options;
mod orbit;
mod pool;
mod prepared;
mod renderer;
mod signals;
mod surface;
mod viewport;
mod world;
mod world_materials;

use pyo3::prelude::*;

/// The module `overcoat._overcoat`.
#[pymodule]
fn _overcoat(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<builder::SceneBuilder>()?;
    module.add_class::<environment::Environment>()?;
    module.add_class::<image::Image>()?;
    module.add_class::<image::Plane>()?;
    module.add_class::<kept::Geometry>()?;
    module.add_class::<kept::Texels>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<orbit::Orbit>()?;
    module.add_class::<renderer::Renderer>()?;
    module.add_class::<viewport::Viewport>()?;
    module.add_class::<world::World>()?;
    module.add_function(wrap_pyfunction!(command::run_command, module)?)?;
    module.add_function(wrap_pyfunction!(golden::golden_check, module)?)?;
    module.add_function(wrap_pyfunction!(golden::golden_compare, module)?)?;
    module.add_function(wrap_pyfunction!(movie::encode_movie, module)?)?;
    module.add_function(wrap_pyfunction!(options::scene_schema, module)?)?;
    module.add_function(wrap_pyfunction!(options::aov_names, module)?)?;
    module.add_function(wrap_pyfunction!(options::model_extensions, module)?)?;
    module.add_function(wrap_pyfunction!(options::check_request, module)?)?;
    module.add_function(wrap_pyfunction!(options::read_description, module)?)?;
    module.add_function(wrap_pyfunction!(options::srgb_table, module)?)?;
    module.add_function(wrap_pyfunction!(options::write_file, module)?)?;
    module.add_function(wrap_pyfunction!(arithmetic::arithmetic_is_default, module)?)?;
    Ok(())
}
