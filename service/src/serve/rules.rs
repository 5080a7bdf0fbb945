//! Rules for the options of requests: limits, presets, and offers of the operator.

use super::error::{Kind, Problem};
use super::offers::{self, Offers, Preset};
use super::options::Options;
use axum::http::HeaderName;
use overcoat::limits::Limits;
use overcoat::load::NamedEnvironment;
use overcoat::output::OutputFormat;
use overcoat_cli::args::EncodingArgs;
use overcoat_worker::protocol::PictureRequest;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Price of a request in units.
pub const PRICE: HeaderName = HeaderName::from_static("overcoat-price");

/// Rules for the options of requests.
#[derive(Clone, Debug)]
pub struct Rules {
    /// Settings that all pictures share.
    pub common: Map<String, Value>,
    /// Limits of the renderer.
    pub limits: Limits,
    /// Pixels of a side.
    pub max_size: u32,
    /// Default format of pictures.
    pub format: OutputFormat,
    /// Default quality of JPEG pictures.
    pub jpeg_quality: Option<u8>,
    /// Options by names.
    pub presets: BTreeMap<String, Preset>,
    /// Options that requests may use beside presets.
    pub offers: Offers,
    /// Units that a request may cost.
    pub max_price: Option<u64>,
    /// Files of environments by the names that requests have for them.
    pub environments: BTreeMap<String, PathBuf>,
}

impl Rules {
    /// Rules for pictures that share a description, without presets.
    #[must_use]
    pub fn new(description: &Value, limits: Limits, encoding: &EncodingArgs) -> Self {
        Self {
            common: description.as_object().cloned().unwrap_or_default(),
            max_size: limits.output_side,
            limits,
            format: encoding.output_format.unwrap_or_default(),
            jpeg_quality: encoding.jpeg_quality,
            presets: BTreeMap::new(),
            offers: Offers::default(),
            max_price: None,
            environments: BTreeMap::new(),
        }
    }

    /// Adds a preset, whose errors are found now and not by every request.
    ///
    /// # Errors
    /// One line.
    pub fn add_preset(&mut self, name: &str, preset: Preset) -> Result<(), String> {
        offers::check_name(name)?;
        if self.presets.contains_key(name) {
            return Err("there is another preset of this name".to_owned());
        }
        let mut asked = Options::default();
        let taken = asked.take_preset(&preset, self);
        let format = asked.format.unwrap_or(self.format);
        let (_, price) =
            taken.and_then(|()| asked.request(format, self)).map_err(|problem| problem.message)?;
        if let Some(most) = self.max_price.filter(|most| price > *most) {
            return Err(too_dear(price, most).message);
        }
        self.presets.insert(name.to_owned(), preset);
        Ok(())
    }

    /// The picture of a preset.
    ///
    /// # Errors
    /// [`Kind::Preset`] if there is none of this name, as [`Options::request`].
    pub fn picture_of_preset(&self, name: &str) -> Result<PictureRequest, Problem> {
        let mut asked = Options::default();
        asked.put("preset", name, self)?;
        asked.request(asked.format.unwrap_or(self.format), self).map(|(request, _)| request)
    }

    /// Adds the presets of a file, and what it offers beside them.
    ///
    /// # Errors
    /// One line that names the file, and the key that is wrong.
    pub fn add_file(&mut self, path: &Path) -> Result<(), String> {
        let (presets, offers) = offers::read(path)?;
        self.offers = offers;
        presets.into_iter().try_for_each(|(name, preset)| {
            let added = self.add_preset(&name, preset);
            added.map_err(|reason| format!("{}: preset.{name}: {reason}", path.display()))
        })
    }
}

impl Rules {
    /// Checks what a request costs.
    ///
    /// # Errors
    /// [`Kind::Price`] if that is more than a request may.
    pub fn check_price(&self, price: u64) -> Result<(), Problem> {
        match self.max_price {
            Some(most) if price > most => {
                Err(too_dear(price, most).limited("max_price", "start the service with --max-price UNITS"))
            }
            _ => Ok(()),
        }
    }
}

/// Problem of pictures that cost too much.
#[must_use]
pub fn too_dear(price: u64, most: u64) -> Problem {
    let message = format!("what is asked for costs {price} units, and {most} are allowed");
    Problem::new(Kind::Price, message).with(PRICE, price.to_string())
}

/// Problem of a preset that does not exist.
#[must_use]
pub fn unknown_preset(name: &str, rules: &Rules) -> Problem {
    let known = match preset_names(rules) {
        names if names.is_empty() => String::new(),
        names => format!(", but {names}"),
    };
    Problem::new(Kind::Preset, format!("preset: there is none '{name}'{known}"))
}

/// Names of all environments, as a sentence ends with them.
#[must_use]
pub fn environment_names(rules: &Rules) -> String {
    NamedEnvironment::sentence(rules.environments.keys().map(String::as_str))
}

/// Names of all presets, with commas.
#[must_use]
pub fn preset_names(rules: &Rules) -> String {
    rules.presets.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
}
