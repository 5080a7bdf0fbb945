//! A loaded model: what is drawn again and again without being read again.

use overcoat::Scene;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A loaded model, which never changes: drawn many times, read once.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) scene: Arc<Scene>,
    /// Tells models apart: of two that are equal, each has its own.
    pub(crate) id: u64,
    /// Its environment was chosen, and stays unless a picture asks for another; else it is what pictures have by default.
    pub(crate) is_lit: bool,
    /// What its file asks for and it does not have.
    #[pyo3(get)]
    pub(crate) warnings: Vec<String>,
}

impl Model {
    pub(crate) fn new(scene: Scene, warnings: Vec<String>) -> Self {
        Self::with(scene, warnings, false)
    }

    /// A scene as it is now, with the light that it has.
    pub(crate) fn lit(scene: Scene) -> Self {
        Self::with(scene, Vec::new(), true)
    }

    fn with(scene: Scene, warnings: Vec<String>, is_lit: bool) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self { scene: Arc::new(scene), id: NEXT.fetch_add(1, Ordering::Relaxed), is_lit, warnings }
    }
}

#[pymethods]
impl Model {
    /// Corners of the box around it, `((x, y, z), (x, y, z))` in metres in its file's coordinates; `None` if it is empty.
    #[getter]
    fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        let bounds = self.scene.bounds();
        let origin = self.scene.origin();
        let corner = |corner: [f64; 3]| std::array::from_fn(|k| corner[k] + origin[k]);
        (!bounds.is_empty()).then(|| (corner(bounds.min), corner(bounds.max)))
    }

    /// Triangles, every instance counted.
    #[getter]
    fn triangles(&self) -> u64 {
        self.scene.triangle_count()
    }

    /// Names of its materials, sorted, for the option `materials`.
    #[getter]
    fn materials(&self) -> Vec<String> {
        let names: BTreeSet<&str> = self.scene.materials().iter().map(|m| m.name.as_str()).collect();
        names.into_iter().filter(|name| !name.is_empty()).map(str::to_owned).collect()
    }

    /// Names of its cameras, for the option `camera={"camera": name}`.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        self.scene.camera_names().to_vec()
    }

    fn __repr__(&self) -> String {
        format!("<overcoat.Model of {} triangles>", self.scene.triangle_count())
    }
}
