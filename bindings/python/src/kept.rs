//! Meshes and pictures of arrays, made once and given to as many scenes as there are: what `overcoat._kept` keeps of other libraries'
//! objects from one picture to the next.

use crate::builder::MeshArrays;
use crate::errors::{self, Kind};
use numpy::{PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use overcoat::scene::{AlphaUse, ColorSpace, Image, Mesh, Sampler, Texture};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// A mesh of arrays, as of `SceneBuilder.add_mesh`.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Geometry(pub(crate) Mesh);

#[pymethods]
impl Geometry {
    /// `kind` is `triangles`, `lines` or `points`; `crease_degrees` asks for smooth normals where there are none; `tangents_of` for
    /// tangents over that set of texture coordinates, which normal maps need.
    #[new]
    #[pyo3(signature = (positions, indices, normals=None, uv=None, colors=None, kind="triangles", crease_degrees=None, tangents_of=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        positions: PyReadonlyArray2<'_, f32>,
        indices: PyReadonlyArray2<'_, u32>,
        normals: Option<PyReadonlyArray2<'_, f32>>,
        uv: Option<PyReadonlyArray2<'_, f32>>,
        colors: Option<PyReadonlyArray2<'_, f32>>,
        kind: &str,
        crease_degrees: Option<f32>,
        tangents_of: Option<usize>,
    ) -> PyResult<Self> {
        let arrays = MeshArrays { positions, indices, normals, uv, colors };
        arrays.mesh(py, kind, crease_degrees, tangents_of).map(Self)
    }
}

/// Use of a picture as a texture.
type Use = (Sampler, ColorSpace, AlphaUse);

/// A picture of (H, W, 4) bytes, row 0 on top, with the textures that were made of it.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug)]
pub(crate) struct Texels {
    pub(crate) image: Arc<Image>,
    made: Mutex<Vec<(Use, Texture)>>,
}

#[pymethods]
impl Texels {
    #[new]
    fn new(texels: PyReadonlyArray3<'_, u8>) -> PyResult<Self> {
        let shape = texels.shape();
        let [height, width, 4] = *shape else {
            return Err(Kind::Mesh.error(format_args!("texture: expected shape (H, W, 4), found {shape:?}")));
        };
        let values = texels.as_slice().map_err(|error| Kind::Mesh.error(format_args!("texture: {error}")))?;
        let (texels, _) = values.as_chunks::<4>();
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let image = Image::new(side(width), side(height), texels.to_vec());
        let image = Arc::new(image.map_err(|error| errors::scene("texture", &error))?);
        Ok(Self { image, made: Mutex::default() })
    }
}

impl Texels {
    /// The texture of a use: its reduced levels are made once.
    pub(crate) fn texture(&self, used: Use) -> Texture {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, texture)) = made.iter().find(|(other, _)| *other == used) {
            return texture.clone();
        }
        let (sampler, color_space, alpha) = used;
        let texture = Texture::new(Arc::clone(&self.image), color_space, alpha, sampler);
        made.push((used, texture.clone()));
        texture
    }
}
