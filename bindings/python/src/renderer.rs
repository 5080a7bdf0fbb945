//! Threads, environments and scenes that are kept from one picture to the next.

use crate::errors;
use crate::image::{Image, Source};
use crate::model::Model;
use crate::options::{GivenRequest, Request, limits, loading};
use crate::pool::Pool;
use crate::prepared::{Cache, Made, Plan};
use crate::surface::losses;
use overcoat::description::Machine;
use overcoat::frame::DisplayOptions;
use overcoat::jobs::MAX_THREADS;
use overcoat::load::{Context, Format, Loaded, NoResolver, TextureLoading, load_bytes_with, load_file_with};
use overcoat::render::{Background, Rendered};
use overcoat::scene::Camera;
use overcoat::{Limits, Scene, SimdLevel};
use overcoat_cli::args::Turn;
use overcoat_cli::turntable::Turning;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// See `overcoat.Renderer`.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Renderer {
    pub(crate) pool: Arc<Pool>,
    cache: Cache,
    pub(crate) machine: Machine,
}

#[pymethods]
impl Renderer {
    #[new]
    fn new(threads: usize, simd: Option<&str>, tile_size: Option<u32>) -> PyResult<Self> {
        let mut machine = Machine::default().with_tile_size(tile_size);
        if let Some(name) = simd {
            let level = name
                .parse::<SimdLevel>()
                .map_err(|e| errors::Kind::Option.error(format_args!("simd: {e}")))?;
            machine = machine.with_simd(level);
        }
        // What is out of range is said in the library's own words, and no threads are started for it.
        let asked = if threads > MAX_THREADS { threads } else { 1 };
        let mut checked = overcoat::Renderer::builder().threads(asked).simd(machine.simd);
        if let Some(side) = machine.tile_size {
            checked = checked.tile_size(side);
        }
        checked.build().map_err(|e| errors::render(&e))?;
        Ok(Self { pool: Arc::new(Pool::new(threads)), cache: Cache::default(), machine })
    }

    /// Loads a model from a file.
    fn load_path(
        &self,
        py: Python<'_>,
        path: PathBuf,
        description: &str,
        given_limits: BTreeMap<String, u64>,
    ) -> PyResult<Model> {
        let options = loading(description)?.with_textures(TextureLoading::ByNeed);
        let limits = limits(&given_limits)?;
        self.pool.with(py, |renderer| {
            let loaded = load_file_with(&path, &options, &limits, renderer.jobs());
            loaded.map(model_of).map_err(|e| errors::load(&e, Some(&path)))
        })?
    }

    /// Loads a model from memory; `format` is a name or an extension that says what its content does not.
    fn load_bytes(
        &self,
        py: Python<'_>,
        bytes: PyBackedBytes,
        format: Option<&str>,
        description: &str,
        given_limits: BTreeMap<String, u64>,
    ) -> PyResult<Model> {
        let options = loading(description)?.with_textures(TextureLoading::ByNeed);
        let limits = limits(&given_limits)?;
        let format = format.map(format_of).transpose()?;
        self.pool.with(py, |renderer| {
            let context = Context { resolver: &NoResolver, limits: &limits, jobs: renderer.jobs() };
            let loaded = load_bytes_with(&bytes, format, &options, &context);
            loaded.map(model_of).map_err(|e| errors::load(&e, None))
        })?
    }

    /// Draws a model. One that is drawn `once` leaves nothing in the cache but its environment.
    fn render(
        &self,
        py: Python<'_>,
        model: &Bound<'_, Model>,
        request: GivenRequest<'_>,
        once: bool,
    ) -> PyResult<Image> {
        let (model, request) = (model.get(), Request::new(request)?);
        let plan = self.cache.find(model, &request);
        let (drawn, made) = self.pool.with(py, |renderer| self.draw(renderer, model, &request, plan))??;
        if let Some(made) = made {
            self.cache.keep(if once { made.once() } else { made });
        }
        Ok(drawn.into_image(&self.pool))
    }

    /// Draws a model once around, in `frames` pictures: as the command `overcoat turntable`.
    fn turntable(
        &self,
        py: Python<'_>,
        model: &Bound<'_, Model>,
        request: GivenRequest<'_>,
        frames: u32,
        turn_model: bool,
    ) -> PyResult<Vec<Image>> {
        let (model, request) = (model.get(), Request::new(request)?);
        Limits::check(|| "moving picture".to_owned(), frames.into(), request.limits.frames, "frames")
            .map_err(|e| errors::limit(&e, &e))?;
        let plan = self.cache.find(model, &request);
        let turn = if turn_model { Turn::Model } else { Turn::Camera };
        let (drawn, made) = self
            .pool
            .with(py, |renderer| self.draw_turn(renderer, model, &request, plan, frames, turn))??;
        if let Some(made) = made {
            self.cache.keep(made);
        }
        Ok(drawn.into_iter().map(|drawn| drawn.into_image(&self.pool)).collect())
    }

    /// Worker threads that each picture is drawn by.
    #[getter]
    fn threads(&self, py: Python<'_>) -> PyResult<usize> {
        self.pool.with(py, |renderer| renderer.jobs().threads())
    }
}

/// A picture, before it is an object.
struct Drawn {
    rendered: Rendered,
    display: DisplayOptions,
    /// The environment is behind the model.
    is_filled: bool,
    warnings: Vec<String>,
    source: Option<Source>,
}

impl Drawn {
    fn into_image(self, pool: &Arc<Pool>) -> Image {
        let Self { rendered, display, is_filled, warnings, source } = self;
        Image::new(rendered, display, is_filled, warnings, Arc::clone(pool), source)
    }
}

impl Renderer {
    /// Prepares what is not prepared, and draws.
    fn draw(
        &self,
        renderer: &mut overcoat::Renderer,
        model: &Model,
        request: &Request,
        plan: Plan,
    ) -> PyResult<(Drawn, Option<Made>)> {
        // What can be wrong with the description is found before a file is read.
        let description = &request.description;
        let (options, display) =
            description.options(self.machine, &request.limits).map_err(|e| errors::description(&e))?;
        let options = options.with_aovs(request.aovs.clone());
        let (prepared, made) = prepare(plan, model, request, renderer)?;
        let scene = &prepared.scene;
        let camera = match request.orbit {
            Some(camera) => camera,
            None => description.camera(scene, &options).map_err(|e| errors::description(&e))?,
        };
        let display = description.display_of(scene, &display);
        let mut drawn = one(renderer, scene, &camera, &options, display)?;
        if !options.aovs.is_empty() {
            drawn.source = Some(Source { scene: Arc::clone(scene), camera, options });
        }
        drawn.warnings.splice(0..0, model.warnings.iter().chain(&prepared.warnings).cloned());
        Ok((drawn, made))
    }

    /// The same for a turn.
    fn draw_turn(
        &self,
        renderer: &mut overcoat::Renderer,
        model: &Model,
        request: &Request,
        plan: Plan,
        frames: u32,
        turn: Turn,
    ) -> PyResult<(Vec<Drawn>, Option<Made>)> {
        let description = &request.description;
        let (options, display) =
            description.options(self.machine, &request.limits).map_err(|e| errors::description(&e))?;
        let options = options.with_aovs(request.aovs.clone());
        let (prepared, made) = prepare(plan, model, request, renderer)?;
        let mut scene = Scene::clone(&prepared.scene);
        let turning =
            Turning::new(description, &scene, &options, frames, turn).map_err(|e| errors::description(&e))?;
        let mut display = description.display_of(&scene, &display);
        let mut all = Vec::new();
        for k in 0..frames {
            let camera = turning.pose(k, &mut scene).map_err(|e| errors::description(&e.into()))?;
            let mut drawn = one(renderer, &scene, &camera, &options, display)?;
            if k == 0 {
                drawn.warnings.splice(0..0, model.warnings.iter().chain(&prepared.warnings).cloned());
            }
            if !options.aovs.is_empty() {
                let (scene, options) = (Arc::new(scene.clone()), options.clone());
                drawn.source = Some(Source { scene, camera, options });
            }
            // What the first is metered at holds for all.
            display = drawn.display.clone();
            all.push(drawn);
        }
        Ok((all, made))
    }
}

/// The scene of a plan.
fn prepare(
    plan: Plan,
    model: &Model,
    request: &Request,
    renderer: &overcoat::Renderer,
) -> PyResult<(Arc<crate::prepared::Prepared>, Option<Made>)> {
    match plan {
        Plan::Done(prepared) => Ok((prepared, None)),
        Plan::Prepare(preparation) => {
            let made = preparation.carry_out(model, request, renderer.jobs())?;
            Ok((Arc::clone(&made.scene), Some(made)))
        }
    }
}

/// One picture.
fn one(
    renderer: &mut overcoat::Renderer,
    scene: &Scene,
    camera: &Camera,
    options: &overcoat::RenderOptions,
    display: DisplayOptions,
) -> PyResult<Drawn> {
    // An allocation that fails would end the process; as the command does, for what is drawn and what is made of it.
    let pixels = u64::from(options.width) * u64::from(options.height);
    Limits::check_memory(|| format!("a picture of {pixels} pixels"), pixels.saturating_mul(24))
        .map_err(|e| errors::limit(&e, &e))?;
    let rendered = renderer.render(scene, camera, options).map_err(|e| errors::render(&e))?;
    let metered = display.metered(&rendered.frame);
    let asked = (&display, metered.exposure);
    let warnings = losses(scene, camera, options, asked, &rendered.frame, &rendered.stats);
    let display = metered;
    let is_filled = options.background == Background::Environment;
    Ok(Drawn { rendered, display, is_filled, warnings, source: None })
}

/// A format by its name or its extension.
pub(crate) fn format_of(name: &str) -> PyResult<Format> {
    Format::from_name(name).or_else(|| Format::from_extension(name)).ok_or_else(|| {
        let known = Format::ALL.iter().map(|f| f.extension()).collect::<Vec<_>>().join(", ");
        errors::Kind::Option
            .error(format_args!("format '{name}': there is no such format; known are {known}"))
    })
}

/// Model object of a loaded file.
fn model_of(loaded: Loaded) -> Model {
    let warnings = loaded.warnings.into_iter().map(|warning| warning.message).collect();
    Model::new(loaded.scene, warnings)
}
