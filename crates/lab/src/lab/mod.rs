//! Errors of the clear coats of engines against physics: the same coated surface by a shading model and by the
//! referee.
//!
//! A [`Specimen`] is a coated surface in numbers. [`Bench`] shades it with the models of this crate, by pictures of
//! one pixel, so that pictures are measured; [`Referee`] follows light through the same layers ([`crate::truth`]). A
//! [`Slice`] varies one quantity, a [`Summary`] measures the error of each model over a grid of specimens; a
//! [`Translator`] finds the parameters of one model whose pictures are nearest to another's; a [`PaintMeasure`] has colours, flop and sparkle of
//! effect paint. A [`MeasuredBrdf`] is what others have measured on a real material, and [`Translator::fit`] finds the parameters of a
//! model for it.
//!
//! ```
//! # mod overcoat { pub use {overcoat_lab::{lab, truth}, overcoat_scene as scene}; }
//! use overcoat::lab::{Bench, Light, Referee, Specimen};
//! use overcoat::scene::ShadingModel;
//! use overcoat::truth::Samples;
//!
//! // Lacquer over a matt surface that reflects 18 percent, under white light from everywhere.
//! let specimen = Specimen { color: [0.18; 3], specular: 0.0, coat_roughness: 0.0, ..Specimen::default() };
//! let three = Bench::new(1).radiance(&specimen, ShadingModel::Three, 30.0, Light::White)?;
//! let truth = Referee::new(&specimen)?.radiance(30.0, Light::White, &Samples::new(1024))?;
//! // three.js does not know that the lacquer sends light back to what it covers, and darkens it.
//! assert!(three[1] > 1.5 * truth.mean()[1]);
//! # Ok::<(), overcoat::lab::LabError>(())
//! ```
//!
//! # What is compared
//!
//! The value is always a radiance: under light from one direction the BRDF times the cosine of that direction (a lamp that a white
//! Lambert surface would show as 1/pi if it shone from the normal), under white light from everywhere the directional albedo, under a soft box its part of that.
//!
//! The coat is a dielectric with Fresnel's equations over a medium that absorbs. A metal is GGX with Schlick's term and all its bounces, as
//! engines define it without a coat: the coat is on trial, not the base. Of plastic there are several truths, and [`Base`] names which one
//! is meant: below a coat of its own index it has no surface. A `specular` of 0 leaves Lambert alone. A mask between
//! 0 and 1 is that share of the surface with a coat and the rest without, as every engine defines it.

mod base;
mod bench;
// Its output is files, which are the program's.
pub mod conformance;
mod measured;
mod paint;
mod progressive;
mod referee;
mod slice;
mod specimen;
mod summary;
mod summary_tally;
mod translate;

pub use base::Base;
pub use bench::Bench;
pub use measured::{MeasuredBrdf, MeasuredError};
pub use paint::{ASPECULAR, PLATE, PaintColor, PaintMeasure, SPARKLE, Sparkle};
pub use progressive::Progressive;
pub use referee::{Measured, Referee};
pub use slice::{Quantity, Row, Slice};
pub use specimen::Specimen;
pub use summary::{CONFIDENCE_95, ModelError, StandardErrors, Summary};
pub use translate::{Distance, Fit, Goal, Residual, Translation, Translator, untextured};

use crate::truth::StackError;
use overcoat_render::RenderError;
use overcoat_scene::SceneError;

/// Light on a specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From one direction, in the plane of the view: degrees from the normal, -89 to 89. Below 0 it comes from the side of the
    /// viewer.
    Direct(f64),
    /// Radiance 1 from everywhere.
    White,
    /// Radiance 1 from up to [`OVERHEAD`] degrees off the normal, and darkness beyond: a round soft box.
    Overhead,
}

/// Radius of [`Light::Overhead`], in degrees.
pub const OVERHEAD: f64 = 37.5;

/// Reason why something cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// A number of a specimen is out of its range, for the engines.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The same, for the referee.
    #[error(transparent)]
    Stack(#[from] StackError),
    /// The picture cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A material that is to be translated is black under all light.
    #[error("the material reflects no light, so that no numbers can be found for it")]
    Dark,
    /// A number is out of range.
    #[error("{what} is {value}; possible is {range}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Value found.
        value: f64,
        /// Range that is possible.
        range: &'static str,
    },
}

/// Luminance of linear Rec. 709.
#[must_use]
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The direction at an angle from the normal in degrees, in the plane of x and z.
fn direction(what: &'static str, degrees: f64) -> Result<[f64; 3], LabError> {
    if !(-89.0..=89.0).contains(&degrees) {
        return Err(LabError::OutOfRange { what, value: degrees, range: "-89 to 89 degrees" });
    }
    let (sin, cos) = overcoat_core::math::double::sin_cos(degrees.to_radians());
    // Of length 1 to the last bit that matters.
    let length = (sin * sin + cos * cos).sqrt();
    Ok([sin / length, 0.0, cos / length])
}
