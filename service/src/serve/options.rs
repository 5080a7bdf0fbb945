//! Options that a request may use: keys of scene files that read no file, and the encoding of the picture.

use super::error::{Kind, Problem};
use overcoat::description::{Description, DescriptionError, Machine, MaterialSource};
use overcoat::frame::Aov;
use overcoat::limits::Limits;
use overcoat::output::OutputFormat;
use overcoat_cli::worker::protocol::PictureRequest;
use overcoat_description::DescriptionOption;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

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
    pub presets: BTreeMap<String, Vec<(String, String)>>,
}

/// Options of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    keys: BTreeMap<String, Value>,
    camera: BTreeMap<String, Value>,
    size: Option<[u64; 2]>,
    aovs: Vec<String>,
    jpeg_quality: Option<u8>,
    /// Format of the picture.
    pub format: Option<OutputFormat>,
    /// Name of the model's file.
    pub name: Option<String>,
    /// The last preset that was asked for.
    pub preset: Option<String>,
}

fn wrong(message: impl Into<String>) -> Problem {
    Problem::new(Kind::Options, message)
}

impl Options {
    /// Takes an option; later ones win.
    ///
    /// # Errors
    /// [`Kind::Options`] with the key and the values it takes.
    pub fn set(&mut self, key: &str, text: &str, rules: &Rules) -> Result<(), Problem> {
        match key {
            "format" => self.format = Some(format(text)?),
            "name" => self.name = Some(text.to_owned()),
            "size" => self.size = Some(size(text)?),
            "width" => self.side(0, text)?,
            "height" => self.side(1, text)?,
            "jpeg_quality" => {
                let quality = text.parse().ok().filter(|quality| (1..=100).contains(quality));
                self.jpeg_quality = Some(
                    quality.ok_or_else(|| wrong(format!("jpeg_quality: expected 1 to 100, got '{text}'")))?,
                );
            }
            "aov" => self.aovs = aovs(text)?,
            "preset" => {
                let preset = rules.presets.get(text);
                let preset = preset.ok_or_else(|| wrong(format!("preset: there is none '{text}'")))?;
                preset.iter().try_for_each(|(key, text)| self.set(key, text, rules))?;
                self.preset = Some(text.to_owned());
            }
            "env" if !matches!(text, "studio" | "none") => {
                return Err(wrong(format!("env: expected studio or none, got '{text}'")));
            }
            "material" if MaterialSource::new(text).map_or(true, |source| source.file().is_some()) => {
                return Err(wrong(format!("material: '{text}' is no built-in material")));
            }
            "env" | "material" => drop(self.keys.insert(key.to_owned(), text.into())),
            _ => return self.scene_key(key, text),
        }
        Ok(())
    }

    fn scene_key(&mut self, key: &str, text: &str) -> Result<(), Problem> {
        let option = DescriptionOption::all().find(|option| option.request_name() == Some(key));
        let Some(option) = option else {
            return Err(wrong(match key {
                "model" | "materials" => format!("{key}: names files, which requests may not"),
                _ => format!("{key}: there is no such option"),
            }));
        };
        let value =
            option.query(text).map_err(|what| wrong(format!("{key}: expected {what}, got '{text}'")))?;
        let table = if option.is_of_camera() { &mut self.camera } else { &mut self.keys };
        table.insert(option.key().to_owned(), value);
        Ok(())
    }

    /// One side; the other one is the same if nothing is said of it.
    fn side(&mut self, which: usize, text: &str) -> Result<(), Problem> {
        let [side, _] = size(text)?;
        let sides = self.size.get_or_insert([side; 2]);
        sides[which] = side;
        Ok(())
    }

    /// The size, where one was asked for.
    #[cfg(test)]
    #[must_use]
    pub fn size(&self) -> Option<[u64; 2]> {
        self.size
    }

    /// The picture that is asked for.
    ///
    /// # Errors
    /// [`Kind::Options`] if something is out of range, [`Kind::Limit`] if it needs more than the renderer's limits.
    pub fn request(&self, format: OutputFormat, rules: &Rules) -> Result<PictureRequest, Problem> {
        let mut keys: Map<String, Value> = self.keys.clone().into_iter().collect();
        if let Some(sides) = self.size {
            let most = u64::from(rules.max_size);
            if sides.iter().any(|side| !(1..=most).contains(side)) {
                let message =
                    format!("size: expected 1 to {most} pixels a side, got {}x{}", sides[0], sides[1]);
                return Err(wrong(message).limited("max_size", "start the service with --max-size N"));
            }
            keys.insert("size".to_owned(), json!(sides));
        }
        if !self.camera.is_empty() {
            keys.insert("camera".to_owned(), self.camera.clone().into_iter().collect::<Map<_, _>>().into());
        }
        let is_layered = format == OutputFormat::Exr;
        if !is_layered && (self.aovs.len() > 1 || (format != OutputFormat::Png && !self.aovs.is_empty())) {
            return Err(wrong("aov: expected one plane, as PNG, or format=exr, which has layers"));
        }
        check(&keys, rules)?;
        let quality = self.jpeg_quality.or(rules.jpeg_quality);
        Ok(PictureRequest {
            keys,
            format: format.extension().to_owned(),
            // Values that change nothing make no other key.
            jpeg_quality: quality.filter(|_| format == OutputFormat::Jpeg),
            aovs: self.aovs.clone(),
            report: false,
        })
    }
}

/// Finds errors in keys before a model is read.
fn check(keys: &Map<String, Value>, rules: &Rules) -> Result<(), Problem> {
    let mut all = rules.common.clone();
    all.extend(keys.clone());
    let told = |error: DescriptionError| match error {
        DescriptionError::Limit(limit) => {
            let raise = format!("start the service with --limit {}=N", limit.field);
            Problem::new(Kind::Limit, limit.to_string()).limited(limit.field, &raise)
        }
        error => wrong(error.to_string()),
    };
    let description = Description::from_json(&Value::Object(all).to_string()).map_err(told)?;
    description.load_options().map_err(told)?;
    description.options(Machine::default(), &rules.limits).map(drop).map_err(told)
}

/// The options of a query or of a form.
///
/// # Errors
/// As [`Options::set`].
pub fn of_pairs<'a>(
    pairs: impl Iterator<Item = (impl AsRef<str> + 'a, impl AsRef<str> + 'a)>,
    rules: &Rules,
) -> Result<Options, Problem> {
    let mut options = Options::default();
    for (key, text) in pairs {
        options.set(key.as_ref(), text.as_ref(), rules)?;
    }
    Ok(options)
}

/// A size: one number for a square, or two with x or a colon.
fn size(text: &str) -> Result<[u64; 2], Problem> {
    let (width, height) = text.split_once(['x', ':']).unwrap_or((text, text));
    let sides = width.parse().ok().zip(height.parse().ok());
    let (width, height) =
        sides.ok_or_else(|| wrong(format!("size: expected N or WIDTHxHEIGHT in pixels, got '{text}'")))?;
    Ok([width, height])
}

fn format(text: &str) -> Result<OutputFormat, Problem> {
    OutputFormat::from_extension(text).ok_or_else(|| {
        let names: Vec<&str> = OutputFormat::ALL.iter().map(|format| format.extension()).collect();
        wrong(format!("format: expected one of {}, got '{text}'", names.join(", ")))
    })
}

fn aovs(text: &str) -> Result<Vec<String>, Problem> {
    let name = |name: &str| {
        let found = Aov::ALL.iter().find(|aov| aov.name() == name.trim());
        found.map(|aov| aov.name().to_owned()).ok_or_else(|| {
            let names: Vec<&str> = Aov::ALL.iter().map(|aov| aov.name()).collect();
            wrong(format!("aov: '{name}' is none of {}", names.join(", ")))
        })
    };
    text.split(',').map(name).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::serve) fn rules() -> Rules {
        Rules {
            common: Map::new(),
            limits: Limits::default(),
            max_size: 1024,
            format: OutputFormat::Png,
            jpeg_quality: None,
            presets: BTreeMap::from([(
                "thumb".to_owned(),
                vec![("size".to_owned(), "64".to_owned()), ("view".to_owned(), "top".to_owned())],
            )]),
        }
    }

    fn keys(pairs: &[(&str, &str)]) -> Result<Value, Problem> {
        let options = of_pairs(pairs.iter().copied(), &rules())?;
        Ok(Value::Object(options.request(options.format.unwrap_or(OutputFormat::Png), &rules())?.keys))
    }

    /// Every key of scene files is an option, or has a reason not to be.
    #[test]
    fn every_key_of_scene_files_is_allowed_or_refused_by_name() {
        let for_readers = ["name", "note", "peers", "ground_truth"];
        for option in DescriptionOption::all().filter(|option| option.request_name().is_none()) {
            let key = option.key();
            if for_readers.contains(&key) || key == "camera" {
                continue;
            }
            let refused = wrong_of(Options::default().set(key, "a.toml", &rules()));
            assert!(refused.contains(key), "{key}: {refused}");
        }
    }

    fn wrong_of(result: Result<(), Problem>) -> String {
        result.map_err(|problem| problem.message).unwrap_err()
    }

    #[test]
    fn options_become_keys() {
        assert_eq!(
            keys(&[
                ("size", "64"),
                ("view", "1,0,2"),
                ("background", "102030"),
                ("exposure", "auto"),
                ("lights", "false")
            ])
            .unwrap(),
            json!({"size": [64, 64], "camera": {"view": "1,0,2"}, "background": "102030", "exposure": "auto", "lights": false})
        );
        assert_eq!(
            keys(&[("preset", "thumb"), ("height", "32"), ("fov_y_deg", "40"), ("samples", "4")]).unwrap(),
            json!({"size": [64, 32], "camera": {"view": "top", "fov_y_deg": 40}, "samples": 4})
        );
    }

    #[test]
    fn what_reads_files_or_is_out_of_range_is_refused() {
        for (key, text, what) in [
            ("env", "/etc/passwd", "studio or none"),
            ("material", "/etc/x.toml", "no built-in material"),
            ("material", "x.toml", "no built-in material"),
            ("materials", "{}", "names files"),
            ("model", "a.glb", "names files"),
            ("Model", "a.glb", "no such option"),
            ("ENV", "/etc/passwd", "no such option"),
            ("size", "0", "1 to 1024"),
            ("size", "2000x3", "1 to 1024"),
            ("size", "-1", "N or WIDTHxHEIGHT"),
            ("samples", "3", "1, 4, 8 or 16"),
            ("maps", "300", "256"),
            ("jpeg_quality", "101", "1 to 100"),
            ("format", "gif", "png, webp"),
            ("aov", "depths", "depth"),
            ("aov", "depth,normal", "one plane"),
            ("eye", "1,2", "three numbers"),
            ("lights", "maybe", "true or false"),
            ("light", "[", "JSON"),
            ("preset", "x", "there is none"),
            ("quality", "ultra", "quality"),
            ("time", "1", "animation"),
        ] {
            let problem = keys(&[(key, text)]).unwrap_err();
            assert_eq!(problem.kind, Kind::Options, "{key}={text}");
            assert!(problem.message.contains(what), "{key}={text}: {}", problem.message);
        }
    }
}
