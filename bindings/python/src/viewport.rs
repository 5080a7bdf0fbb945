//! Pictures that follow each other, drawn into arrays.
//!
//! One at a time: who draws takes the library's viewport out of its place and puts it back, and others wait for it without the
//! interpreter. As in [`crate::pool`], the lock is held only with the interpreter, and what belongs to another process is leaked: a
//! child of a fork begins with a new one.

use crate::arithmetic::DefaultArithmetic;
use crate::errors::{self, Kind};
use crate::memory::Memory;
use crate::model::Model;
use crate::options::{GivenRequest, Request, read};
use crate::orbit::Orbit;
use crate::renderer::Renderer;
use crate::signals::interruptible;
use crate::world::World;
use overcoat::description::{Description, Machine};
use overcoat::frame::DisplayOptions;
use overcoat::render::{Cancellation, RenderError};
use overcoat::scene::Camera;
use overcoat::viewport::{self, FrameBudget, Level};
use overcoat::{Limits, RenderOptions, Scene};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// See `overcoat.Viewport`.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Viewport {
    threads: usize,
    machine: Machine,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// The process that the viewport belongs to.
    process: u32,
    viewport: Option<viewport::Viewport>,
    is_drawing: bool,
    settings: Arc<Settings>,
    /// Cancellations of all threads that draw or wait, by numbers that are given out in turn.
    cancellations: Vec<(u64, Cancellation)>,
    next: u64,
}

/// Times that a scene is looked at which changes meanwhile.
const LOOKS: usize = 16;

/// Settings of the pictures.
#[derive(Clone, Debug)]
struct Settings {
    description: Description,
    options: RenderOptions,
    display: DisplayOptions,
    budget: Option<FrameBudget>,
}

impl Settings {
    fn new(request: GivenRequest<'_>, machine: Machine, budget: Option<FrameBudget>) -> PyResult<Self> {
        let Request { description, limits, .. } = Request::new(request)?;
        let (options, display) =
            description.options(machine, &limits).map_err(|e| errors::description(&e))?;
        // Of glass the linear picture is made all the same.
        let pixels = u64::from(options.width) * u64::from(options.height);
        Limits::check_memory(|| format!("a picture of {pixels} pixels"), pixels.saturating_mul(24))
            .map_err(|e| errors::limit(&e, &e))?;
        Ok(Self { description, options, display, budget })
    }

    /// Camera of a picture of the scene.
    fn camera(&self, scene: &Scene, camera: &GivenCamera) -> PyResult<Camera> {
        match camera {
            GivenCamera::Exact(camera) => Ok(*camera),
            GivenCamera::Described(camera) => {
                let description = Description { camera: (**camera).clone(), ..self.description.clone() };
                description.camera(scene, &self.options).map_err(|e| errors::description(&e))
            }
        }
    }
}

/// Camera as given, before the scene is known.
enum GivenCamera {
    Exact(Camera),
    Described(Box<overcoat::description::CameraDescription>),
}

impl GivenCamera {
    /// Camera of an orbit, or of a description as JSON that has nothing but a camera.
    fn new(orbit: Option<PyRef<'_, Orbit>>, json: &str) -> PyResult<Self> {
        Ok(match orbit {
            Some(orbit) => Self::Exact(orbit.camera()),
            None => Self::Described(Box::new(read(json)?.camera)),
        })
    }
}

impl Drop for State {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            std::mem::forget(self.viewport.take());
        }
    }
}

/// The right to draw, with what draws.
struct Turn<'a> {
    of: &'a Viewport,
    number: u64,
    cancellation: Cancellation,
    has_begun: bool,
}

impl Turn<'_> {
    /// Calls `f` with the library's viewport, without the interpreter. Ctrl-C stops what takes `long`; what takes microseconds is not
    /// worth a thread of its own.
    fn draw<T: Send>(
        self,
        py: Python<'_>,
        settings: &Settings,
        long: bool,
        f: impl FnOnce(&mut viewport::Viewport) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        let (threads, cancellation) = (self.of.threads, self.cancellation.clone());
        let kept = self.of.lock().viewport.take();
        let stop = self.cancellation.clone();
        let work = || {
            let _arithmetic = DefaultArithmetic::new();
            let new = || viewport::Viewport::new(overcoat::Renderer::new(threads));
            let mut viewport = kept.unwrap_or_else(new);
            viewport.set_options(settings.options.clone());
            viewport.set_quality(settings.description.quality.unwrap_or_default());
            viewport.set_budget(settings.budget);
            viewport.renderer().cancel_by(Some(cancellation));
            let result = f(&mut viewport);
            (viewport, result)
        };
        let ((viewport, result), raised) =
            if long { interruptible(py, &stop, work) } else { (py.detach(work), None) };
        self.of.lock().viewport = Some(viewport);
        raised.map_or(result, Err)
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let mut state = self.of.lock();
        state.cancellations.retain(|(number, _)| *number != self.number);
        if self.has_begun {
            state.is_drawing = false;
        }
    }
}

/// Quality, samples, scale, whether it is final, exposure, triangles.
type Drawn = (&'static str, u32, u32, bool, f32, u64);

#[pymethods]
impl Viewport {
    #[new]
    fn new(
        renderer: &Bound<'_, Renderer>,
        request: GivenRequest<'_>,
        work: Option<u64>,
        seconds: Option<f64>,
    ) -> PyResult<Self> {
        let renderer = renderer.get();
        let machine = renderer.machine;
        let settings = Arc::new(Settings::new(request, machine, budget(work, seconds)?)?);
        let state = State {
            process: std::process::id(),
            viewport: None,
            is_drawing: false,
            settings,
            cancellations: Vec::new(),
            next: 0,
        };
        Ok(Self { threads: renderer.pool.threads, machine, state: Mutex::new(state) })
    }

    /// Draws the following pictures with these options.
    fn configure(&self, request: GivenRequest<'_>, work: Option<u64>, seconds: Option<f64>) -> PyResult<()> {
        let settings = Settings::new(request, self.machine, budget(work, seconds)?)?;
        self.lock().settings = Arc::new(settings);
        Ok(())
    }

    /// Draws the next picture, or a better one of the same: `None` if there is no better one.
    #[allow(clippy::too_many_arguments)]
    fn draw(
        &self,
        py: Python<'_>,
        model: &Bound<'_, Model>,
        orbit: Option<PyRef<'_, Orbit>>,
        camera: &str,
        out: &Bound<'_, PyAny>,
        format: Option<&str>,
        region: Option<[u32; 4]>,
        refine: bool,
    ) -> PyResult<Option<Drawn>> {
        let camera = GivenCamera::new(orbit, camera)?;
        let settings = Arc::clone(&self.lock().settings);
        let size = match region {
            Some([_, _, width, height]) => [width, height],
            None => [settings.options.width, settings.options.height],
        };
        if size.contains(&0) {
            return Err(Kind::Option.error("region: expected at least one pixel"));
        }
        // Nobody else who waits keeps the array from the one that draws.
        let turn = self.turn(py)?;
        let mut memory = Memory::new(out, format, size)?;
        let mut target = memory.target();
        if let Some([left, top, width, height]) = region {
            target = target.with_region(left, top, width, height);
        }
        let scene = &model.get().scene;
        let drawn = turn.draw(py, &settings, true, |viewport| {
            let camera = settings.camera(scene, &camera)?;
            viewport.set_display(settings.description.display_of(scene, &settings.display));
            let drawn = if refine {
                viewport.refine(scene, &camera, &mut target)
            } else {
                viewport.draw(scene, &camera, &mut target).map(Some)
            };
            drawn.map_err(|e| errors::render(&e))
        })?;
        Ok(drawn.map(|drawn| {
            let Level { quality, samples, scale } = drawn.level;
            (quality.name(), samples, scale, drawn.is_final, drawn.exposure, drawn.stats.triangles)
        }))
    }

    /// What is seen in a pixel of a scene: instance, primitive, vertices, their weights, depth, position, whether from behind.
    #[allow(clippy::type_complexity)]
    fn pick(
        &self,
        py: Python<'_>,
        world: &Bound<'_, World>,
        orbit: Option<PyRef<'_, Orbit>>,
        camera: &str,
        x: u32,
        y: u32,
    ) -> PyResult<Option<(u64, usize, [u32; 3], [f32; 3], f32, [f64; 3], bool)>> {
        let camera = GivenCamera::new(orbit, camera)?;
        let settings = Arc::clone(&self.lock().settings);
        for _ in 0..LOOKS {
            let model = world.get().model(py)?;
            let scene = &model.get().scene;
            let hit = self.turn(py)?.draw(py, &settings, false, |viewport| {
                let camera = settings.camera(scene, &camera)?;
                viewport.pick(scene, &camera, [x, y]).map_err(|e| errors::render(&e))
            })?;
            let Some(hit) = hit else { return Ok(None) };
            // Another thread may have changed the scene: numbers may be those of other instances.
            let Some(instance) = world.get().instance_in(&model, hit.instance) else { continue };
            let origin = scene.origin();
            let position = std::array::from_fn(|k| hit.position[k] + origin[k]);
            let (vertices, weights) = (hit.vertices, hit.barycentric);
            return Ok(Some((
                instance,
                hit.primitive,
                vertices,
                weights,
                hit.depth,
                position,
                hit.back_facing,
            )));
        }
        Err(Kind::Render.error("pick: another thread changes the scene all the time"))
    }

    /// Stops what is being drawn, and who waits to draw.
    fn cancel(&self) {
        for (_, cancellation) in &self.lock().cancellations {
            cancellation.cancel();
        }
    }
}

/// Budget of a picture: units of work or seconds. Seconds count if both are given.
fn budget(work: Option<u64>, seconds: Option<f64>) -> PyResult<Option<FrameBudget>> {
    let Some(seconds) = seconds else { return Ok(work.map(FrameBudget::Work)) };
    let time = Duration::try_from_secs_f64(seconds);
    let time = time.map_err(|_| Kind::Option.error("budget: expected a time of at least 0"))?;
    Ok(Some(FrameBudget::Time(time)))
}

impl Viewport {
    fn lock(&self) -> MutexGuard<'_, State> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        if state.process != process {
            // What the parent was drawing nobody finishes here, and threads of its own viewport are not there.
            std::mem::forget(state.viewport.take());
            state.cancellations.clear();
            (state.process, state.is_drawing) = (process, false);
        }
        state
    }

    /// Waits, without the interpreter, until nobody else draws.
    fn turn(&self, py: Python<'_>) -> PyResult<Turn<'_>> {
        let cancellation = Cancellation::new();
        let number = {
            let mut state = self.lock();
            state.next += 1;
            let number = state.next;
            state.cancellations.push((number, cancellation.clone()));
            number
        };
        let mut turn = Turn { of: self, number, cancellation, has_begun: false };
        loop {
            if turn.cancellation.is_cancelled() {
                return Err(errors::render(&RenderError::Cancelled));
            }
            {
                let mut state = self.lock();
                if !state.is_drawing {
                    state.is_drawing = true;
                    turn.has_begun = true;
                    drop(state);
                    return Ok(turn);
                }
            }
            py.check_signals()?;
            py.detach(|| std::thread::sleep(Duration::from_micros(200)));
        }
    }
}
