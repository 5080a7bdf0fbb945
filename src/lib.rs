//! overcoat renders meshes to pictures on machines that have only a processor: no GPU, no display, no driver, no
//! network; and gives the same bytes on every machine.
//!
//! Data flows one way:
//!
//! ```text
//! bytes --load--> Scene --geometry--> triangles --tile--> bins --raster--> visible samples
//!       --gbuffer--> surface fragments --shade--> radiance --render--> Frame --output--> files
//! ```
//!
//! [`load`] turns files into a [`Scene`], which is valid by construction, so that no later stage can meet malformed
//! input; all it reads goes through one [`load::Resolver`] and all it counts is held against [`Limits`]. A scene can
//! be built by hand just as well, see [`scene`].
//!
//! [`Renderer::render`] takes a scene, a [`scene::Camera`] (for example from [`scene::Framing`]) and
//! [`RenderOptions`], and runs the stages over square tiles in parallel: `geometry` transforms, clips and snaps
//! triangles to a fixed-point grid, `raster` finds which sample sees which triangle, `gbuffer` makes of them
//! fragments, sixteen at a time, `shade` evaluates the material models of `coat` under the lights of `light`. Out
//! comes a [`Frame`] of linear light; [`Frame::frame_hash`] names its bits. [`Renderer::render_image`] makes a picture for
//! screens tile by tile, with four bytes a pixel in place of twenty.
//!
//! What the models compute, and where engines differ, is on a page of its own: [`guide::clear_coat`].
//!
//! Whole programs, from a file to pixels and from nothing to a scene, are on a page: [`guide::library`].
//!
//! Applications that draw the same things again and again keep them in a [`world::World`], whose parts have names that stay, and
//! draw them through a [`viewport::Viewport`] into the memory of a window.
//!
//! [`output`] makes files of it, [`golden`] compares them, and [`decode`] reads them again. [`description`] reads a whole
//! picture, with camera, lights and options, from a scene file, and the program `overcoat` is a command line over all of it.
//!
//! [`truth`] measures what the models are an approximation of: random walks through stacks of coats, without a renderer.
//!
//! [`sandbox`] gives up what none of this needs from the system, before the first byte of input is read.
//!
//! The same bits everywhere come from `math`: shading is written over lanes, whose operations IEEE
//! 754 rounds exactly, and [`jobs`] keeps the order of results independent of threads. How each layer keeps them, how a
//! change breaks them, and which releases may change pictures is on a page: [`guide::bit_identity`].
//!
//! The stages and the formulas (`brdf`, `coat`, `gbuffer`, `geometry`, `light`, `math`, `raster`, `shade`, `splat`, `tile`) are
//! open to this project's tests, benches and fuzz targets and left out of these pages: they are not part of the promise, and
//! change in any release.
//!
//! ```
//! use overcoat::scene::{Framing, Instance, Material, Mesh, MeshData, Transform};
//! use overcoat::{RenderOptions, Renderer, Scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = Scene::new();
//! let mesh = scene.add_mesh(Mesh::new(MeshData {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     triangles: vec![[0, 1, 2]],
//!     ..MeshData::default()
//! })?)?;
//! let material = scene.add_material(Material { base_color: [0.8, 0.1, 0.1, 1.0], coat: 1.0, ..Material::default() })?;
//! scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 })?;
//!
//! let camera = Framing::default().camera(&scene);
//! let options = RenderOptions::new(64, 64);
//! let rendered = Renderer::new(1).render(&scene, &camera, &options)?;
//! assert!(rendered.frame.pixels.iter().any(|pixel| pixel[3] == 1.0));
//! # Ok(())
//! # }
//! ```

#[cfg(feature = "cache")]
pub mod cache;
pub mod color;
pub mod decode;
pub mod description;
pub mod formats;
pub mod frame;
pub mod golden;
pub mod guide;
pub mod jobs;
#[cfg(feature = "truth")]
pub mod lab;
pub mod limits;
pub mod load;
pub mod output;
pub mod render;
pub mod scene;
pub mod viewport;
pub mod world;

// Not part of the promise: for tests, benches and fuzz targets of this project.
#[doc(hidden)]
pub mod brdf;
#[doc(hidden)]
pub mod built;
#[doc(hidden)]
pub mod bvh;
#[doc(hidden)]
pub mod coat;
#[doc(hidden)]
pub mod gbuffer;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod light;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod raster;
#[doc(hidden)]
pub mod shade;
#[doc(hidden)]
pub mod shadow;
#[doc(hidden)]
pub mod splat;
#[doc(hidden)]
pub mod tile;

#[cfg(feature = "sandbox")]
pub mod sandbox;

#[cfg(feature = "truth")]
pub mod truth;

mod files;
mod reuse;
mod suggest;

// The program is no part of the library.
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

pub use frame::Frame;
pub use limits::Limits;
pub use math::lanes::{SimdLevel, UnknownLevel};
pub use render::{RenderOptions, Renderer};
pub use scene::Scene;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
