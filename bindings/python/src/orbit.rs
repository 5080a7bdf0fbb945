//! A camera that goes around a point.

use crate::errors::Kind;
use crate::model::Model;
use overcoat::Scene;
use overcoat::scene::Camera;
use overcoat::viewport;
use pyo3::prelude::*;

// What is said here is what `help(overcoat.Orbit)` shows.
/// A camera for a mouse: it goes around a point, and +Y stays up. `camera=` of `Viewport.draw`, `Viewport.pick` and
/// `render` takes it.
///
/// `Orbit.around(scene, aspect)` makes one; the cameras of a model in a scene, `ModelHandle.cameras`, are such ones too.
#[pyclass(module = "overcoat._overcoat")]
#[derive(Clone, Debug)]
pub(crate) struct Orbit {
    orbit: viewport::Orbit,
    /// Origin of the scene, in the coordinates of its file.
    origin: [f64; 3],
}

impl Orbit {
    /// Around what a camera of a scene looks at.
    pub(crate) fn from_camera(camera: &Camera, scene: &Scene) -> Self {
        Self { orbit: viewport::Orbit::from_camera(camera), origin: scene.origin() }
    }

    pub(crate) fn camera(&self) -> Camera {
        self.orbit.camera()
    }

    /// In the coordinates of the file.
    fn outside(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| p[k] + self.origin[k])
    }
}

/// A number that is one.
fn finite(name: &str, value: f64) -> PyResult<f64> {
    let wrong = || Kind::Option.error(format_args!("{name} {value}: expected a finite number"));
    value.is_finite().then_some(value).ok_or_else(wrong)
}

#[pymethods]
impl Orbit {
    /// Around a `Scene` or a `Model`, which fills a picture of that aspect (width over height), from where it shows most.
    #[staticmethod]
    #[pyo3(signature = (scene, aspect=1.0))]
    fn around(scene: &Bound<'_, PyAny>, aspect: f64) -> PyResult<Self> {
        if !(aspect > 0.0 && aspect.is_finite()) {
            return Err(Kind::Option.error(format_args!("aspect {aspect}: expected width over height")));
        }
        let model = match scene.cast::<Model>() {
            Ok(model) => model.clone(),
            Err(_) => match scene.call_method0("snapshot").map(Bound::cast_into::<Model>) {
                Ok(Ok(model)) => model,
                _ => {
                    let found = scene.get_type().name()?;
                    return Err(
                        Kind::Option.error(format_args!("scene: expected a Scene or a Model, found {found}"))
                    );
                }
            },
        };
        let scene = &model.get().scene;
        Ok(Self { orbit: viewport::Orbit::around(scene, aspect as f32), origin: scene.origin() })
    }

    /// Goes around by angles in degrees: to the right, so that the scene turns to the left, and up. Up and down it stops a
    /// little before the poles.
    #[pyo3(signature = (right_deg, up_deg=0.0))]
    fn turn(&mut self, right_deg: f64, up_deg: f64) -> PyResult<()> {
        let (right, up) = (finite("right_deg", right_deg)?, finite("up_deg", up_deg)?);
        self.orbit.turn(right.to_radians(), up.to_radians());
        Ok(())
    }

    /// Moves camera and point along the picture, by parts of its height: to the right and up.
    fn pan(&mut self, right: f64, up: f64) -> PyResult<()> {
        self.orbit.pan(finite("right", right)?, finite("up", up)?);
        Ok(())
    }

    /// Comes closer by a factor, above 0: 2 is half the distance.
    fn zoom(&mut self, factor: f64) -> PyResult<()> {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(Kind::Option.error(format_args!("factor {factor}: expected a number above 0")));
        }
        self.orbit.zoom(factor);
        Ok(())
    }

    /// The point that it goes around, `(x, y, z)` in metres. Assigned to, the view moves with it.
    #[getter]
    fn target(&self) -> (f64, f64, f64) {
        self.outside(self.orbit.target()).into()
    }

    #[setter]
    fn set_target(&mut self, target: [f64; 3]) -> PyResult<()> {
        for value in target {
            finite("target", value)?;
        }
        self.orbit.set_target(std::array::from_fn(|k| target[k] - self.origin[k]));
        Ok(())
    }

    /// Where it is seen from, `(x, y, z)` in metres.
    #[getter]
    fn eye(&self) -> (f64, f64, f64) {
        self.outside(self.orbit.camera().eye.map(f64::from)).into()
    }

    /// Another one like it.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __repr__(&self) -> String {
        let ([x, y, z], [a, b, c]) = (<[f64; 3]>::from(self.eye()), <[f64; 3]>::from(self.target()));
        format!("<overcoat.Orbit at ({x:.4}, {y:.4}, {z:.4}) around ({a:.4}, {b:.4}, {c:.4})>")
    }
}
