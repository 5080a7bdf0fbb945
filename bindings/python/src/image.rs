//! A picture: its frame of linear light, and what is made of it when somebody asks.

use crate::errors;
use crate::pool::Pool;
use overcoat::frame::{DisplayImage, DisplayOptions};
use overcoat::output::{ExrPrecision, OutputFormat, OutputOptions, encode, encode_png, write_atomically};
use overcoat::render::{Annotation, RenderOptions, Rendered, names_of_ids, optical_flow};
use overcoat::scene::{Camera, CameraMatrices};
use overcoat::{Frame, Scene};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

// Nothing in it changes, so that arrays may look at its memory. What is said here is what `help(overcoat.Image)` shows.
/// A picture of linear light, and what is made of it when it is asked for. It never changes.
///
/// `numpy.asarray(image)` is `image.array`. A notebook shows it.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Image {
    frame: Frame,
    camera: CameraMatrices,
    display: DisplayOptions,
    /// No pixel is transparent: the environment is behind the model.
    is_filled: bool,
    /// What the file asks for and the picture does not show, in one sentence each.
    #[pyo3(get)]
    warnings: Vec<String>,
    hash: OnceLock<String>,
    shown: OnceLock<DisplayImage>,
    /// Pool that takes the frame's memory back.
    pool: Arc<Pool>,
    /// Scene, camera and options, if it has planes of the G-buffer.
    source: Option<Source>,
}

/// Scene, camera and options of a picture.
#[derive(Debug)]
pub(crate) struct Source {
    pub(crate) scene: Arc<Scene>,
    pub(crate) camera: Camera,
    pub(crate) options: RenderOptions,
}

impl Image {
    pub(crate) fn new(
        Rendered { frame, camera, .. }: Rendered,
        display: DisplayOptions,
        is_filled: bool,
        warnings: Vec<String>,
        pool: Arc<Pool>,
        source: Option<Source>,
    ) -> Self {
        Self {
            frame,
            source,
            camera,
            display,
            is_filled,
            warnings,
            hash: OnceLock::new(),
            shown: OnceLock::new(),
            pool,
        }
    }

    /// For screens.
    pub(crate) fn shown(&self, py: Python<'_>) -> &DisplayImage {
        // Not made under the lock of the cell: a thread that waits for another in it would keep the interpreter.
        if self.shown.get().is_none() {
            let made = py.detach(|| DisplayImage::new(&self.frame, &self.display));
            let _ = self.shown.set(made);
        }
        self.shown.get_or_init(|| DisplayImage::new(&self.frame, &self.display))
    }

    /// For formats without transparency: over white unless it has a background; the command does the same.
    fn opaque_display(&self) -> DisplayOptions {
        if self.display.background.is_none() && !self.is_filled {
            self.display.clone().with_background(Some([255; 3]))
        } else {
            self.display.clone()
        }
    }

    /// For screens, without transparency.
    pub(crate) fn shown_opaque(&self, py: Python<'_>) -> DisplayImage {
        py.detach(|| DisplayImage::new(&self.frame, &self.opaque_display()))
    }

    /// As a file of a format.
    fn encoded(&self, format: OutputFormat, quality: u8, half: bool) -> PyResult<Vec<u8>> {
        let display = match format {
            OutputFormat::Jpeg => self.opaque_display(),
            _ => self.display.clone(),
        };
        let precision = if half { ExrPrecision::Half } else { ExrPrecision::Float };
        let mut options = OutputOptions::default().with_display(display).with_exr_precision(precision);
        options.jpeg_quality = quality;
        encode(&self.frame, format, &options).map_err(|e| errors::output(&e))
    }

    fn plane(slf: &Bound<'_, Self>, content: Content, shape: Vec<usize>) -> PyResult<Py<PyAny>> {
        let py = slf.py();
        let plane = Plane { image: slf.clone().unbind(), content, shape };
        let numpy = PyModule::import(py, "numpy")?;
        Ok(numpy.call_method1("asarray", (Py::new(py, plane)?,))?.unbind())
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        let aovs = Vec::new();
        let empty = Frame { width: 0, height: 0, pixels: Vec::new(), transmittance: Vec::new(), aovs };
        let pool = Arc::clone(&self.pool);
        // Objects go with the interpreter held.
        pool.recycle(std::mem::replace(&mut self.frame, empty));
    }
}

#[pymethods]
impl Image {
    /// In pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.frame.width
    }

    /// In pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.frame.height
    }

    /// Matrices of the camera that it was taken with, in the coordinates of the file.
    #[getter]
    fn camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let CameraMatrices { width, height, k, world_to_camera, camera_to_world, near, far, .. } =
            self.camera;
        let array = PyModule::import(py, "numpy")?.getattr("array")?;
        let rows = |rows: Vec<Vec<f64>>| array.call1((rows,));
        let square = |m: [[f64; 4]; 4]| rows(m.iter().map(|row| row.to_vec()).collect());
        let kind = if self.camera.perspective { "perspective" } else { "orthographic" };
        let k = rows(k.iter().map(|row| row.to_vec()).collect())?;
        let (outward, inward) = (square(world_to_camera)?, square(camera_to_world)?);
        let class = PyModule::import(py, "overcoat._camera")?.getattr("CameraMatrices")?;
        // Digits of single precision, no more.
        let decimal = |v: f32| v.to_string().parse::<f64>().unwrap_or(f64::from(v));
        class.call1((kind, width, height, k, outward, inward, decimal(near), decimal(far)))
    }

    /// Stops of the 8-bit picture; what was metered for `exposure="auto"`.
    #[getter]
    fn exposure(&self) -> f32 {
        self.display.exposure
    }

    /// (H, W, 4) uint8, sRGB with straight, linear alpha, row 0 on top; a view without a copy, not to be written to.
    #[getter]
    fn array(slf: &Bound<'_, Self>) -> PyResult<Py<PyAny>> {
        let image = slf.get();
        // Made here, without the interpreter, and not where only its address is asked for.
        image.shown(slf.py());
        Self::plane(slf, Content::Shown, vec![image.frame.height as usize, image.frame.width as usize, 4])
    }

    /// (H, W, 4) float32, linear light multiplied by alpha, before exposure and tone curve; a view, likewise.
    #[getter]
    fn linear(slf: &Bound<'_, Self>) -> PyResult<Py<PyAny>> {
        let frame = &slf.get().frame;
        Self::plane(slf, Content::Linear, vec![frame.height as usize, frame.width as usize, 4])
    }

    /// Planes of the G-buffer that were asked for by `aov=`: (H, W) or (H, W, C) views, by their names; float32, of identities
    /// uint32.
    #[getter]
    fn aov<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let frame = &slf.get().frame;
        let planes = PyDict::new(slf.py());
        for (k, plane) in frame.aovs.iter().enumerate() {
            let mut shape = vec![frame.height as usize, frame.width as usize];
            if plane.aov.channels() > 1 {
                shape.push(plane.aov.channels());
            }
            planes.set_item(plane.aov.name(), Self::plane(slf, Content::Aov(k), shape)?)?;
        }
        PyModule::import(slf.py(), "overcoat._planes")?.getattr("Planes")?.call1((planes,))
    }

    /// Names of what planes of identities show, `{plane: {number: name}}`: empty where the file has none. 0 is nothing.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let Some(source) = &self.source else { return Ok(found) };
        for plane in self.frame.aovs.iter().filter(|plane| plane.aov.is_identity()) {
            found.set_item(plane.aov.name(), names_of_ids(&source.scene, plane.aov))?;
        }
        Ok(found)
    }

    /// Boxes and pixels of each instance, object or material, whether it is visible or not: a list of dicts by the numbers of a plane
    /// of identities that was asked for.
    ///
    /// `id` and `name`; and, by the names of BOP, `bbox_obj` and `bbox_visib` (left, top, width, height in pixels: of the whole
    /// geometry, also hidden and beyond the picture, and of the pixels that show it; `None` without any), `px_count_all` (pixels of
    /// the picture that would show it alone, or `None` where too many overlap), `px_count_visib` and `visib_fract`. Everything that overlaps something else is drawn alone for
    /// it, without light.
    #[pyo3(signature = (plane="object-id"))]
    fn annotations<'py>(&self, py: Python<'py>, plane: &str) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let aov = crate::options::aov(plane)?;
        let (Some(source), Some(ids)) = (&self.source, self.frame.plane(aov).filter(|_| aov.is_identity()))
        else {
            return Err(errors::Kind::Option.error(format_args!(
                "plane '{plane}': the picture has no such plane of identities: render(..., aov=['object-id'])"
            )));
        };
        let Source { scene, camera, options } = source;
        let found = self.pool.with(py, |renderer| renderer.annotate(scene, camera, options, ids))?;
        let told = |of: Annotation| {
            let dict = PyDict::new(py);
            let fraction = of.visible_fraction();
            dict.set_item("id", of.id)?;
            dict.set_item("name", of.name)?;
            dict.set_item("bbox_obj", of.full_box)?;
            dict.set_item("bbox_visib", of.visible_box)?;
            dict.set_item("px_count_all", of.pixels)?;
            dict.set_item("px_count_visib", of.visible_pixels)?;
            dict.set_item("visib_fract", fraction)?;
            Ok(dict)
        };
        found.map_err(|e| errors::render(&e))?.into_iter().map(told).collect()
    }

    /// Optical flow to another picture of the same size, (H, W, 2) float32: pixels to the right and down from each pixel's centre to
    /// where the point that it shows is in the other, whether it is seen there or not. The picture has to have the planes `position`
    /// and `instance-id`, the other any plane; it is of the same model, in the same pose or another one.
    ///
    /// NaN where nothing is, behind the other camera, and where meshes are deformed: by skins and morph targets.
    fn flow_to<'py>(&self, py: Python<'py>, other: &Bound<'py, Image>) -> PyResult<Bound<'py, PyAny>> {
        let other = other.get();
        let (Some(from), Some(to)) = (&self.source, &other.source) else {
            let message =
                "flow_to(): both pictures have to have planes: render(..., aov=['position', 'instance-id'])";
            return Err(errors::Kind::Option.error(message));
        };
        if (self.frame.width, self.frame.height) != (other.frame.width, other.frame.height) {
            return Err(errors::Kind::Option.error("flow_to(): the pictures have different sizes"));
        }
        let flow = py.detach(|| optical_flow(&self.frame, &from.scene, &to.scene, &to.camera));
        let flow = flow.map_err(|e| errors::render(&e))?;
        let flat = numpy::PyArray1::from_vec(py, flow.into_flattened());
        flat.call_method1("reshape", ((self.frame.height, self.frame.width, 2),))
    }

    /// XXH3-128 of the linear picture, 32 hexadecimal digits: as `overcoat render --json` prints it.
    #[getter]
    fn hash(&self, py: Python<'_>) -> String {
        if let Some(hash) = self.hash.get() {
            return hash.clone();
        }
        let hash = py.detach(|| self.frame.frame_hash());
        self.hash.get_or_init(|| hash).clone()
    }

    /// The bytes of a PNG file, 8 bits.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let shown = self.shown(py);
        let bytes = py.detach(|| encode_png(shown)).map_err(|e| errors::output(&e))?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    /// The bytes of a file.
    ///
    /// Args:
    ///     format: `png`, `webp`, `jpg`, `exr` or `hdr`; the last two hold linear light, and `exr` the planes of `aov` too.
    ///     quality: Of JPEG, 1 to 100. JPEG has no transparency: white is behind the picture unless it has a background.
    ///     half: Whether `exr` has 16 bits a number, or 32.
    #[pyo3(signature = (format, *, quality=90, half=true))]
    fn encode<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        quality: u8,
        half: bool,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let format = OutputFormat::from_path(Path::new(&format!("x.{format}"))).map_err(|_| {
            let known: Vec<&str> = OutputFormat::ALL.iter().map(|f| f.extension()).collect();
            errors::Kind::Option.error(format_args!(
                "format '{format}': there is no such format; known are {}",
                known.join(", ")
            ))
        })?;
        let bytes = py.detach(|| self.encoded(format, quality, half))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes a file whose extension tells the format; whole or not at all. Arguments as of `encode`.
    #[pyo3(signature = (path, *, quality=90, half=true))]
    fn save(&self, py: Python<'_>, path: PathBuf, quality: u8, half: bool) -> PyResult<()> {
        let format = OutputFormat::from_path(&path).map_err(|e| errors::output(&e))?;
        py.detach(|| {
            let bytes = self.encoded(format, quality, half)?;
            write_atomically(&path, &bytes).map_err(|e| errors::output(&e))
        })
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        slf: &Bound<'py, Self>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let array = Self::array(slf)?.into_bound(py);
        let arguments = PyDict::new(py);
        arguments.set_item("copy", copy == Some(true))?;
        match dtype {
            None if copy == Some(true) => array.call_method0("copy"),
            None => Ok(array),
            Some(dtype) => array.call_method("astype", (dtype,), Some(&arguments)),
        }
    }

    fn __repr__(&self) -> String {
        format!("<overcoat.Image of {} x {} pixels>", self.frame.width, self.frame.height)
    }
}

/// Which memory of a picture.
#[derive(Clone, Copy, Debug)]
enum Content {
    Shown,
    Linear,
    Aov(usize),
}

/// A view of a picture's memory for numpy, by its array interface: the address, and that nobody may write there. The array
/// keeps this object and this object the picture.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Plane {
    image: Py<Image>,
    content: Content,
    shape: Vec<usize>,
}

#[pymethods]
impl Plane {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let image = self.image.get();
        let (address, kind) = match self.content {
            Content::Shown => (image.shown(py).as_bytes().as_ptr() as usize, "|u1"),
            Content::Linear => (image.frame.pixels.as_ptr() as usize, FLOAT),
            Content::Aov(k) => match image.frame.aovs.get(k) {
                Some(plane) if plane.aov.is_identity() => (plane.ids.as_ptr() as usize, UNSIGNED),
                Some(plane) => (plane.data.as_ptr() as usize, FLOAT),
                None => (0, FLOAT),
            },
        };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", kind)?;
        interface.set_item("shape", PyList::new(py, &self.shape)?.to_tuple())?;
        interface.set_item("data", (address, true))?;
        Ok(interface)
    }
}

/// Whole numbers of this machine, in the words of numpy.
const UNSIGNED: &str = if cfg!(target_endian = "little") { "<u4" } else { ">u4" };

/// Floats of this machine, likewise.
const FLOAT: &str = if cfg!(target_endian = "little") { "<f4" } else { ">f4" };
