//! One quantity that varies, and the radiance of models and referee over it.

use super::{Bench, LabError, Light, Referee, Specimen};
use crate::truth::Samples;
use overcoat_scene::ShadingModel;

/// Quantity that a slice varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Angle of the view from the normal, 0 to 89 degrees.
    View,
    /// Angle of the light, -89 to 89 degrees.
    Light,
    /// Share of the surface that has a coat.
    Coat,
    /// Perceptual roughness of the coat.
    CoatRoughness,
    /// Index of refraction of the coat, 1 to 3.
    CoatIor,
    /// Thickness of the coat, 0 to 4.
    Thickness,
    /// Perceptual roughness of the base.
    BaseRoughness,
    /// Index of refraction of a base with an interface, 1 to 3.
    BaseIor,
    /// A grey for the colour of the base.
    Color,
    /// Strength of the specular part of a base that is no metal.
    Specular,
}

impl Quantity {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::View,
        Self::Light,
        Self::Coat,
        Self::CoatRoughness,
        Self::CoatIor,
        Self::Thickness,
        Self::BaseRoughness,
        Self::BaseIor,
        Self::Color,
        Self::Specular,
    ];

    /// Its name in options and headings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Light => "light",
            Self::Coat => "coat",
            Self::CoatRoughness => "coat-roughness",
            Self::CoatIor => "coat-ior",
            Self::Thickness => "thickness",
            Self::BaseRoughness => "base-roughness",
            Self::BaseIor => "base-ior",
            Self::Color => "color",
            Self::Specular => "specular",
        }
    }

    /// Default range.
    #[must_use]
    pub fn range(self) -> [f64; 2] {
        match self {
            Self::View => [0.0, 85.0],
            Self::Light => [-85.0, 85.0],
            Self::CoatIor | Self::BaseIor => [1.0, 2.0],
            Self::Thickness => [0.0, 4.0],
            _ => [0.0, 1.0],
        }
    }
}

/// One row of a slice.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Value of the quantity.
    pub value: f64,
    /// Radiance by each model, in the order of [`Slice::models`].
    pub models: Vec<[f64; 3]>,
    /// Radiance by the referee.
    pub truth: [f64; 3],
    /// Standard error of the referee.
    pub error: [f64; 3],
    /// Part of the referee's radiance that the coat's own surface reflects.
    pub coat: [f64; 3],
}

/// A specimen, its view and light, and the quantity that varies.
#[derive(Clone, Debug)]
pub struct Slice {
    /// Specimen with the values of the quantities that do not vary.
    pub specimen: Specimen,
    /// Angle of the view in degrees from the normal.
    pub view: f64,
    /// Light on the specimen.
    pub light: Light,
    /// Quantity that varies.
    pub over: Quantity,
    /// First and last value.
    pub range: [f64; 2],
    /// Number of values, two at least, evenly apart.
    pub steps: usize,
    /// Models to measure.
    pub models: Vec<ShadingModel>,
    /// Samples of the referee for each value.
    pub samples: Samples,
}

impl Slice {
    /// Values of the quantity.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        let [first, last] = self.range;
        let steps = if self.steps < 2 { 2 } else { self.steps };
        (0..steps).map(|k| first + (last - first) * (k as f64 / (steps - 1) as f64)).collect()
    }

    /// Measures every value; `done` is called with the number of finished values.
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn measure(&self, bench: &mut Bench, mut done: impl FnMut(usize)) -> Result<Vec<Row>, LabError> {
        let mut rows = Vec::new();
        for value in self.values() {
            rows.push(self.row(bench, value)?);
            done(rows.len());
        }
        Ok(rows)
    }

    fn row(&self, bench: &mut Bench, value: f64) -> Result<Row, LabError> {
        let (specimen, view, light) = self.at(value)?;
        let models = self.models.iter().map(|&model| bench.radiance(&specimen, model, view, light));
        let models = models.collect::<Result<_, _>>()?;
        let found = Referee::new(&specimen)?.radiance_by(bench.jobs(), view, light, &self.samples)?;
        let (truth, error, coat) = (found.mean(), found.standard_error(), found.coat());
        Ok(Row { value, models, truth, error, coat })
    }

    /// The same slice with another value of a quantity that does not vary in it.
    ///
    /// # Errors
    /// [`LabError`] if that is the angle of light that comes from everywhere.
    pub fn varied(&self, quantity: Quantity, value: f64) -> Result<Self, LabError> {
        let (specimen, view, light) = Self { over: quantity, ..self.clone() }.at(value)?;
        Ok(Self { specimen, view, light, ..self.clone() })
    }

    /// Specimen, view and light at a value of what varies.
    ///
    /// # Errors
    /// [`LabError`] if that is the angle of light that comes from everywhere.
    pub fn at(&self, value: f64) -> Result<(Specimen, f64, Light), LabError> {
        let (mut specimen, mut view, mut light) = (self.specimen, self.view, self.light);
        match self.over {
            Quantity::View => view = value,
            Quantity::Light if !matches!(light, Light::Direct(_)) => {
                let range = "that of light from one direction: this light has none";
                return Err(LabError::OutOfRange { what: "angle of the light", value, range });
            }
            Quantity::Light => light = Light::Direct(value),
            Quantity::Coat => specimen.coat = value,
            Quantity::CoatRoughness => specimen.coat_roughness = value,
            Quantity::CoatIor => specimen.coat_ior = value,
            Quantity::Thickness => specimen.thickness = value,
            Quantity::BaseRoughness => specimen.base_roughness = value,
            Quantity::BaseIor => specimen.base_ior = value,
            Quantity::Color => specimen.color = [value; 3],
            Quantity::Specular => specimen.specular = value,
        }
        Ok((specimen, view, light))
    }
}
