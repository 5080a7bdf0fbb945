//! Slices of the lab for the page `docs/src/coat-lab/`: the same coated surface by shading models, and by the referee with as many walks
//! as there has been time for. Numbers and names in, arrays of numbers out; every formula is the library's.

use overcoat_lab::lab::{
    Base, Bench, CONFIDENCE_95, LabError, Light, Progressive, Quantity, Referee, Slice, Specimen,
};
use overcoat_lab::truth::Samples;
use overcoat_scene::ShadingModel;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// Most values of a slice, as the command line has it.
const MOST_STEPS: usize = 1000;

/// Makes panics errors of JavaScript, which say what has happened; a trap would not.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_str(&format!("panic: {info}"))));
}

/// Names of the models that are built in, with commas between them.
#[wasm_bindgen]
#[must_use]
pub fn models() -> String {
    let built = ShadingModel::ALL.iter().filter(|model| model.is_built());
    built.map(|model| model.name()).collect::<Vec<_>>().join(",")
}

/// Names of the readings of a base that is no metal, with commas between them.
#[wasm_bindgen]
#[must_use]
pub fn bases() -> String {
    Base::ALL.iter().map(|base| base.name()).collect::<Vec<_>>().join(",")
}

/// Quantities that can vary, with their default ranges: `view 0 85,light -85 85,…`.
#[wasm_bindgen]
#[must_use]
pub fn quantities() -> String {
    let told = |quantity: &Quantity| {
        let [first, last] = quantity.range();
        format!("{} {first} {last}", quantity.name())
    };
    Quantity::ALL.iter().map(told).collect::<Vec<_>>().join(",")
}

/// Standard errors to either side of a mean in an interval of 95 percent confidence.
#[wasm_bindgen]
#[must_use]
pub fn confidence() -> f64 {
    CONFIDENCE_95
}

/// A slice as the options of `overcoat lab` describe it, with their defaults, ranges and units.
#[wasm_bindgen]
pub struct Setup {
    slice: Slice,
}

#[wasm_bindgen]
impl Setup {
    /// The defaults: white light, seen from 0 to 85 degrees.
    #[wasm_bindgen(constructor)]
    #[must_use]
    #[expect(clippy::new_without_default, reason = "JavaScript has no Default")]
    pub fn new() -> Self {
        let slice = Slice {
            specimen: Specimen::default(),
            view: 30.0,
            light: Light::White,
            over: Quantity::View,
            range: Quantity::View.range(),
            steps: 18,
            models: Vec::new(),
            samples: Samples::new(0),
        };
        Self { slice }
    }

    /// Sets one number: `view`, `steps`, `specular`, or another by the name of its option.
    ///
    /// # Errors
    /// An unknown name, or a number of steps out of 2 to 1000. Other ranges are checked when the slice begins.
    pub fn number(&mut self, name: &str, value: f64) -> Result<(), JsError> {
        let specimen = &mut self.slice.specimen;
        let place = match name {
            "view" => &mut self.slice.view,
            "coat" => &mut specimen.coat,
            "coat-roughness" => &mut specimen.coat_roughness,
            "coat-ior" => &mut specimen.coat_ior,
            "thickness" => &mut specimen.thickness,
            "base-roughness" => &mut specimen.base_roughness,
            "base-ior" => &mut specimen.base_ior,
            "specular" => &mut specimen.specular,
            "steps" if (2.0..=MOST_STEPS as f64).contains(&value) => {
                self.slice.steps = value as usize;
                return Ok(());
            }
            "steps" => return Err(JsError::new(&format!("steps is {value}; possible is 2 to {MOST_STEPS}"))),
            _ => return Err(unknown("number", name)),
        };
        *place = value;
        Ok(())
    }

    /// Sets three numbers, red, green and blue: `color` or `extinction`.
    ///
    /// # Errors
    /// An unknown name.
    pub fn channels(&mut self, name: &str, red: f64, green: f64, blue: f64) -> Result<(), JsError> {
        match name {
            "color" => self.slice.specimen.color = [red, green, blue],
            "extinction" => self.slice.specimen.extinction = [red, green, blue],
            _ => return Err(unknown("colour", name)),
        }
        Ok(())
    }

    /// Sets what is beneath the coat: `metal`, or a reading of plastic.
    ///
    /// # Errors
    /// An unknown name.
    pub fn base(&mut self, name: &str) -> Result<(), JsError> {
        let specimen = &mut self.slice.specimen;
        specimen.metal = name == "metal";
        if !specimen.metal {
            let base = Base::ALL.iter().find(|base| base.name() == name);
            specimen.base = *base.ok_or_else(|| unknown("base", name))?;
        }
        Ok(())
    }

    /// Sets the light: `white`, `overhead`, or from one direction, in degrees.
    ///
    /// # Errors
    /// An unknown name.
    pub fn light(&mut self, name: &str) -> Result<(), JsError> {
        self.slice.light = match name {
            "white" => Light::White,
            "overhead" => Light::Overhead,
            _ => Light::Direct(name.parse().map_err(|_| unknown("light", name))?),
        };
        Ok(())
    }

    /// Sets what varies, over its default range.
    ///
    /// # Errors
    /// An unknown name.
    pub fn over(&mut self, name: &str) -> Result<(), JsError> {
        let quantity = Quantity::ALL.iter().find(|quantity| quantity.name() == name);
        self.slice.over = *quantity.ok_or_else(|| unknown("quantity", name))?;
        self.slice.range = self.slice.over.range();
        Ok(())
    }

    /// Adds a model.
    ///
    /// # Errors
    /// An unknown name.
    pub fn model(&mut self, name: &str) -> Result<(), JsError> {
        let model = ShadingModel::ALL.iter().find(|model| model.name() == name && model.is_built());
        self.slice.models.push(*model.ok_or_else(|| unknown("model", name))?);
        Ok(())
    }
}

fn unknown(kind: &str, name: &str) -> JsError {
    JsError::new(&format!("there is no {kind} '{name}'"))
}

fn sentence(error: &LabError) -> JsError {
    JsError::new(&error.to_string())
}

/// The bench, which keeps filtered environments from slice to slice, and the slice that it measures.
#[wasm_bindgen]
pub struct Lab {
    bench: Bench,
    models: Vec<ShadingModel>,
    values: Vec<Value>,
}

/// One value of what varies.
struct Value {
    value: f64,
    specimen: Specimen,
    view: f64,
    light: Light,
    reading: Progressive,
}

#[wasm_bindgen]
impl Lab {
    /// An empty bench.
    #[wasm_bindgen(constructor)]
    #[must_use]
    #[expect(clippy::new_without_default, reason = "JavaScript has no Default")]
    pub fn new() -> Self {
        Self { bench: Bench::new(1), models: Vec::new(), values: Vec::new() }
    }

    /// Begins a slice, without any walk yet, in the place of the one before. Gives the values of what varies.
    ///
    /// # Errors
    /// A number out of its range, by its name; the slice before is kept.
    pub fn begin(&mut self, setup: &Setup) -> Result<Vec<f64>, JsError> {
        let slice = &setup.slice;
        let value = |value: f64| {
            let (specimen, view, light) = slice.at(value)?;
            let reading = Referee::new(&specimen)?.progressive(view, light)?;
            Ok(Value { value, specimen, view, light, reading })
        };
        let values = slice.values().into_iter().map(value).collect::<Result<Vec<_>, LabError>>();
        self.values = values.map_err(|error| sentence(&error))?;
        self.models.clone_from(&slice.models);
        Ok(self.values.iter().map(|value| value.value).collect())
    }

    /// Radiance by the models at value number `k`, three channels each.
    ///
    /// # Errors
    /// A number out of its range.
    pub fn models(&mut self, k: usize) -> Result<Vec<f64>, JsError> {
        let mut radiance = Vec::new();
        let Some(value) = self.values.get(k) else { return Ok(radiance) };
        for &model in &self.models {
            let shown = self.bench.radiance(&value.specimen, model, value.view, value.light);
            radiance.extend(shown.map_err(|error| sentence(&error))?);
        }
        Ok(radiance)
    }

    /// Adds so many walks, a multiple of 256, at value number `k`. Gives three channels each of mean, standard error and the part that the
    /// coat's own surface reflects.
    ///
    /// # Errors
    /// A number that is no multiple, or a value that is not there.
    pub fn walk(&mut self, k: usize, count: u32) -> Result<Vec<f64>, JsError> {
        let value = self.values.get_mut(k).ok_or_else(|| unknown("value", &k.to_string()))?;
        value.reading.add(count.into()).map_err(|error| sentence(&error))?;
        let found = value.reading.measured();
        Ok([found.mean(), found.standard_error(), found.coat()].concat())
    }
}
