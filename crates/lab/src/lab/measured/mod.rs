//! BRDFs of others, measured on real materials: the files of MERL and of the RGL, read and evaluated.
//!
//! [`MeasuredBrdf::from_bytes`] tells the formats apart by their first bytes. Both are evaluated for two directions above the
//! surface, whose normal is +Z; values are per steradian, in the three channels of the file, which stand for linear Rec. 709.

mod error;
mod light;
mod merl;
mod rgl;
mod sphere;
mod tensor;
mod warp;

pub use error::MeasuredError;

use merl::Merl;
use overcoat_core::math::double::{atan2, sin_cos};
use rgl::Rgl;

/// A BRDF that was measured.
#[derive(Clone, Debug)]
pub struct MeasuredBrdf {
    table: Table,
}

#[derive(Clone, Debug)]
enum Table {
    Merl(Merl),
    Rgl(Box<Rgl>),
}

impl MeasuredBrdf {
    /// Reads a file of MERL (`.binary`; Matusik et al. 2003) or the tensor file of the RGL with red, green and blue (`_rgb.bsdf`;
    /// Dupuy and Jakob 2018). It takes about twice the memory of the file at most.
    ///
    /// # Errors
    /// [`MeasuredError`] with the field, what was found there and what was expected.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, MeasuredError> {
        let table = if tensor::is_tensor_file(&bytes) {
            Table::Rgl(Box::new(Rgl::new(&bytes)?))
        } else {
            Table::Merl(Merl::new(bytes)?)
        };
        Ok(Self { table })
    }

    /// Name of the format: `merl` or `rgl`.
    #[must_use]
    pub fn format(&self) -> &'static str {
        match &self.table {
            Table::Merl(_) => "merl",
            Table::Rgl(_) => "rgl",
        }
    }

    /// The file's own words about the material; empty in files of MERL, which have none. Without control characters.
    #[must_use]
    pub fn description(&self) -> &str {
        match &self.table {
            Table::Merl(_) => "",
            Table::Rgl(table) => table.description(),
        }
    }

    /// True if it depends on how the surface is turned about its normal.
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        matches!(&self.table, Table::Rgl(table) if table.is_anisotropic())
    }

    /// The BRDF per steradian for directions of length 1 towards the viewer and the light; 0 where one is not above the
    /// surface, and `None` where nothing was measured. `view` is the direction that tables of the RGL are indexed by.
    #[must_use]
    pub fn evaluate(&self, view: [f64; 3], light: [f64; 3]) -> Option<[f64; 3]> {
        if !(view[2] > 0.0 && light[2] > 0.0) {
            return Some([0.0; 3]);
        }
        match &self.table {
            Table::Merl(table) => table.evaluate(view, light),
            Table::Rgl(table) => table.evaluate(view, light),
        }
    }
}

/// Angle from +Z, 0 to pi, and azimuth from +X, -pi to pi.
fn spherical([x, y, z]: [f64; 3]) -> [f64; 2] {
    [atan2((x * x + y * y).sqrt(), z), atan2(y, x)]
}

/// The direction between two.
fn halfway(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let sum: [f64; 3] = std::array::from_fn(|k| a[k] + b[k]);
    let length = dot(sum, sum).sqrt();
    sum.map(|c| c / length)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Turns a direction about +Z.
fn turned([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = sin_cos(angle);
    [x * cos - y * sin, x * sin + y * cos, z]
}
