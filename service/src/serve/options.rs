//! Options that a request may use: keys of scene files that read no file, and the encoding of the picture.

use super::error::{Kind, Problem};
use super::fair::Priority;
use super::offers::Preset;
use super::price::price;
use super::rules::{Rules, environment_names, preset_names, unknown_preset};
use super::several::Several;
use overcoat::description::{Description, DescriptionError, Machine, MaterialSource};
use overcoat::frame::Aov;
use overcoat::load::NamedEnvironment;
use overcoat::output::OutputFormat;
use overcoat_description::DescriptionOption;
use overcoat_worker::protocol::{PictureRequest, Turntable};
use overcoat_worker::turning::Turn;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Format of moving pictures alone.
const GIF: &str = "gif";
/// Frames of a turn a second where no number is given.
const FRAMES_A_SECOND: f64 = 12.0;

/// Options of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    keys: BTreeMap<String, Value>,
    camera: BTreeMap<String, Value>,
    size: Option<[u64; 2]>,
    /// Pixels of the picture for each pixel of the size.
    dpr: Option<f64>,
    aovs: Vec<String>,
    jpeg_quality: Option<u8>,
    /// Frames of a turn of the model.
    turntable: Option<u32>,
    /// Frames of it a second.
    fps: Option<f64>,
    /// The format is GIF, which is for turns alone.
    is_gif: bool,
    /// Lists of several pictures.
    pub several: Several,
    /// Format of the picture.
    pub format: Option<OutputFormat>,
    /// Name of the model's file.
    pub name: Option<String>,
    /// The last preset that was asked for.
    pub preset: Option<String>,
    /// Priority of the last preset that has one.
    priority: Option<Priority>,
    /// The size is not, or not in whole, a preset's.
    has_own_size: bool,
    /// The format is a preset's.
    has_preset_format: bool,
}

/// A picture with its price.
#[derive(Clone, Debug)]
pub struct Priced {
    /// The picture.
    pub request: PictureRequest,
    /// Units that it costs.
    pub price: u64,
    /// Priority that its preset gives it.
    pub priority: Option<Priority>,
}

fn wrong(message: impl Into<String>) -> Problem {
    Problem::new(Kind::Options, message)
}

impl Options {
    /// Takes an option of a request; later ones win.
    ///
    /// # Errors
    /// [`Kind::Options`] with the key and the values it takes, [`Kind::NotOffered`], [`Kind::Preset`].
    pub fn set(&mut self, key: &str, text: &str, rules: &Rules) -> Result<(), Problem> {
        if self.several.set(key, text)? {
            return Ok(());
        }
        match key {
            "preset" if rules.offers.presets_only() && self.preset.is_some() => {
                return Err(Problem::new(Kind::NotOffered, "preset: one at a time is offered here"));
            }
            // Names are of files. The size and the format are checked when they are whole.
            "preset" | "name" => {}
            "size" | "width" | "height" if !rules.offers.presets_only() => self.has_own_size = true,
            "format" => self.has_preset_format = false,
            key => {
                // Misspelt options are told as such.
                self.clone().put(key, text, rules)?;
                rules.offers.check(key, text)?;
            }
        }
        self.put(key, text, rules)
    }

    /// Takes an option of a request or of a preset.
    pub(super) fn put(&mut self, key: &str, text: &str, rules: &Rules) -> Result<(), Problem> {
        match key {
            "format" => {
                self.is_gif = text.eq_ignore_ascii_case(GIF);
                self.format = if self.is_gif { None } else { Some(format(text)?) };
            }
            "turntable" => self.turntable = Some(frames(text, rules)?),
            "fps" => self.fps = Some(fps(text)?),
            "name" => self.name = Some(text.to_owned()),
            "size" => self.size = Some(size(text)?),
            "dpr" => self.dpr = Some(dpr(text)?),
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
                let preset = preset.ok_or_else(|| unknown_preset(text, rules))?;
                self.take_preset(preset, rules)?;
                self.preset = Some(text.to_owned());
            }
            "env" if NamedEnvironment::named(text).is_none() && !rules.environments.contains_key(text) => {
                return Err(wrong(format!("env: expected {}, got '{text}'", environment_names(rules))));
            }
            "material" if MaterialSource::new(text).map_or(true, |source| source.file().is_some()) => {
                return Err(wrong(format!("material: '{text}' is no built-in material")));
            }
            "env" | "material" => drop(self.keys.insert(key.to_owned(), text.into())),
            _ => return self.scene_key(key, text),
        }
        Ok(())
    }

    /// Takes the options of a preset, all of which are offered.
    ///
    /// # Errors
    /// [`Kind::Options`] with the key and the values it takes.
    pub fn take_preset(&mut self, preset: &Preset, rules: &Rules) -> Result<(), Problem> {
        for (key, text) in &preset.pairs {
            self.put(key, text, rules)?;
            match key.as_str() {
                "size" => self.has_own_size = false,
                "format" => self.has_preset_format = true,
                _ => {}
            }
        }
        self.priority = preset.priority.or(self.priority);
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

    /// Extension of the picture's file, which is of this format unless the model turns in it.
    ///
    /// # Errors
    /// [`Kind::Options`] if there is no such moving picture, or what is for one stands alone.
    pub fn extension(&self, format: OutputFormat) -> Result<&'static str, Problem> {
        let still = |name: &str| wrong(format!("{name}: is for a turntable=FRAMES"));
        match (self.turntable, self.format) {
            (None, _) if self.is_gif => Err(unknown_format(GIF)),
            (None, _) if self.fps.is_some() => Err(still("fps")),
            (None, _) => Ok(format.extension()),
            (Some(_), _) if !self.aovs.is_empty() => Err(wrong("aov: a turntable has none")),
            (Some(_), _) if self.is_gif => Ok(GIF),
            // Accept is not asked: every browser shows it.
            (Some(_), None | Some(OutputFormat::WebP)) => Ok(OutputFormat::WebP.extension()),
            (Some(_), Some(OutputFormat::Png)) => Ok(OutputFormat::Png.extension()),
            (Some(_), Some(other)) => {
                let name = other.extension();
                Err(wrong(format!("format: a turntable is webp, gif or png, got '{name}'")))
            }
        }
    }

    /// True if the format is settled, whatever a client accepts.
    #[must_use]
    pub fn has_format(&self) -> bool {
        self.format.is_some() || self.is_gif || self.turntable.is_some()
    }

    /// The size, where one was asked for.
    #[cfg(test)]
    #[must_use]
    pub fn size(&self) -> Option<[u64; 2]> {
        self.size
    }

    /// The picture that is asked for, if it is offered, with its price.
    ///
    /// # Errors
    /// [`Kind::Options`] if something is out of range, [`Kind::Limit`] if it needs more than the renderer's limits,
    /// [`Kind::NotOffered`], [`Kind::Price`].
    pub fn priced(&self, format: OutputFormat, rules: &Rules) -> Result<Priced, Problem> {
        if rules.offers.presets_only() && self.preset.is_none() {
            let message = format!("preset: one of them is needed: {}", preset_names(rules));
            return Err(Problem::new(Kind::NotOffered, message));
        }
        if !self.has_preset_format {
            rules.offers.check("format", self.extension(format)?)?;
        }
        let (request, price) = self.request(format, rules)?;
        // A size that cannot be at all is told as such.
        if let Some([width, height]) = self.size.filter(|_| self.has_own_size) {
            rules.offers.check("size", &format!("{width}x{height}"))?;
        }
        rules.check_price(price)?;
        Ok(Priced { request, price, priority: self.priority })
    }

    /// The picture that is asked for, and its price, whether it is offered or not.
    ///
    /// # Errors
    /// [`Kind::Options`] if something is out of range, [`Kind::Limit`] if it needs more than the renderer's limits.
    pub fn request(&self, format: OutputFormat, rules: &Rules) -> Result<(PictureRequest, u64), Problem> {
        let mut keys: Map<String, Value> = self.keys.clone().into_iter().collect();
        let sides = match self.dpr {
            None => self.size,
            Some(dpr) => {
                let sides = match self.size {
                    Some(sides) => sides,
                    None => check(&keys, rules)?.0,
                };
                Some(sides.map(|side| (side as f64 * dpr).round() as u64))
            }
        };
        if let Some(sides) = sides {
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
        let extension = self.extension(format)?;
        let (_, price) = check(&keys, rules)?;
        let turntable = self.turntable.map(|frames| Turntable {
            frames,
            fps: self.fps.unwrap_or(FRAMES_A_SECOND),
            turn: Turn::default(),
        });
        let price = price.saturating_mul(self.turntable.unwrap_or(1).into());
        let quality = self.jpeg_quality.or(rules.jpeg_quality);
        let request = PictureRequest {
            keys,
            format: extension.to_owned(),
            turntable,
            // Values that change nothing make no other key.
            jpeg_quality: quality.filter(|_| format == OutputFormat::Jpeg),
            aovs: self.aovs.clone(),
            ..PictureRequest::default()
        };
        Ok((request, price))
    }
}

/// Finds errors in keys before a model is read. Returns the size of their picture and its price.
fn check(keys: &Map<String, Value>, rules: &Rules) -> Result<([u64; 2], u64), Problem> {
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
    let (options, _) = description.options(Machine::default(), &rules.limits).map_err(told)?;
    Ok(([options.width, options.height].map(u64::from), price(&options, description.lights_to_add.len())))
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
///
/// # Errors
/// [`Kind::Options`].
pub fn size(text: &str) -> Result<[u64; 2], Problem> {
    let (width, height) = text.split_once(['x', ':']).unwrap_or((text, text));
    let sides = width.parse().ok().zip(height.parse().ok());
    let (width, height) =
        sides.ok_or_else(|| wrong(format!("size: expected N or WIDTHxHEIGHT in pixels, got '{text}'")))?;
    Ok([width, height])
}

/// Pixels of a screen for each pixel of a page.
fn dpr(text: &str) -> Result<f64, Problem> {
    let ratio = text.parse::<f64>().ok().filter(|ratio| (0.1..=8.0).contains(ratio));
    ratio.ok_or_else(|| wrong(format!("dpr: expected 0.1 to 8, got '{text}'")))
}

fn format(text: &str) -> Result<OutputFormat, Problem> {
    OutputFormat::from_extension(text).ok_or_else(|| unknown_format(text))
}

fn unknown_format(text: &str) -> Problem {
    let names: Vec<&str> = OutputFormat::ALL.iter().map(|format| format.extension()).collect();
    wrong(format!("format: expected one of {} (gif with a turntable), got '{text}'", names.join(", ")))
}

/// Frames of a turn.
fn frames(text: &str, rules: &Rules) -> Result<u32, Problem> {
    let most = rules.limits.frames;
    let frames = text.parse::<u32>().ok().filter(|frames| *frames > 0);
    let frames =
        frames.ok_or_else(|| wrong(format!("turntable: expected 1 to {most} frames, got '{text}'")))?;
    if u64::from(frames) > most {
        let message = format!("turntable: {frames} frames exceed {most}");
        return Err(
            Problem::new(Kind::Limit, message).limited("frames", "start the service with --limit frames=N")
        );
    }
    Ok(frames)
}

/// Frames of a turn a second.
fn fps(text: &str) -> Result<f64, Problem> {
    let range = overcoat_worker::turntable::FRAMES_A_SECOND;
    let fps = text.parse::<f64>().ok().filter(|fps| range.contains(fps));
    fps.ok_or_else(|| wrong(format!("fps: expected {} to {}, got '{text}'", range.start(), range.end())))
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
    use super::super::offers::{self, Offers};
    use super::*;
    use overcoat::limits::Limits;

    pub(in crate::serve) fn rules() -> Rules {
        Rules {
            common: Map::new(),
            limits: Limits::default(),
            max_size: 1024,
            format: OutputFormat::Png,
            jpeg_quality: None,
            presets: BTreeMap::from([(
                "thumb".to_owned(),
                Preset {
                    pairs: vec![("size".to_owned(), "64".to_owned()), ("view".to_owned(), "top".to_owned())],
                    priority: None,
                },
            )]),
            offers: Offers::default(),
            max_price: None,
            environments: BTreeMap::new(),
        }
    }

    fn keys(pairs: &[(&str, &str)]) -> Result<Value, Problem> {
        let options = of_pairs(pairs.iter().copied(), &rules())?;
        let priced = options.priced(options.format.unwrap_or(OutputFormat::Png), &rules())?;
        Ok(Value::Object(priced.request.keys))
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
    fn turntables_cost_every_frame() {
        let of = |pairs: &[(&str, &str)]| {
            let options = of_pairs(pairs.iter().copied(), &rules())?;
            options.priced(options.format.unwrap_or(OutputFormat::Png), &rules())
        };
        let still = of(&[("size", "64")]).unwrap();
        assert!(still.request.turntable.is_none());
        for (pairs, format) in [
            (&[("turntable", "24")][..], "webp"),
            (&[("format", "gif"), ("turntable", "24"), ("fps", "8.5")], "gif"),
            (&[("turntable", "24"), ("format", "png")], "png"),
        ] {
            let turn = of(&[&[("size", "64")], pairs].concat()).unwrap();
            assert_eq!((turn.price, turn.request.format.as_str()), (24 * still.price, format));
            assert_eq!(turn.request.turntable.unwrap().frames, 24);
        }
        for (pairs, what) in [
            (&[("turntable", "24"), ("format", "jpg")][..], "webp, gif or png"),
            (&[("turntable", "24"), ("aov", "depth")], "has none"),
        ] {
            assert!(of(pairs).unwrap_err().message.contains(what), "{pairs:?}");
        }
        assert_eq!(of(&[("turntable", "3601")]).unwrap_err().kind, Kind::Limit);
    }

    #[test]
    fn dense_screens_have_more_pixels() {
        let size = |pairs: &[(&str, &str)]| keys(pairs).unwrap()["size"].clone();
        assert_eq!(size(&[("size", "64x48"), ("dpr", "2")]), json!([128, 96]));
        assert_eq!(size(&[("dpr", "1.5"), ("preset", "thumb")]), json!([96, 96]));
        let whole = keys(&[("size", "512"), ("dpr", "1")]).unwrap();
        // The size of a request that names none.
        assert_eq!(size(&[("dpr", "0.5")])[1], json!(whole["size"][1].as_u64().unwrap() / 2));
        let refused = wrong_of(keys(&[("size", "600"), ("dpr", "2")]).map(drop));
        assert!(refused.contains("1 to 1024") && refused.contains("1200x1200"), "{refused}");
    }

    #[test]
    fn what_reads_files_or_is_out_of_range_is_refused() {
        for (key, text, what) in [
            ("dpr", "9", "0.1 to 8"),
            ("dpr", "NaN", "0.1 to 8"),
            ("env", "/etc/passwd", "sky or none"),
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
            ("fps", "12", "turntable=FRAMES"),
            ("fps", "61", "1 to 60"),
            ("turntable", "0", "1 to 3600"),
            ("turntable", "x", "1 to 3600"),
            ("aov", "depths", "depth"),
            ("aov", "depth,normal", "one plane"),
            ("eye", "1,2", "three numbers"),
            ("lights", "maybe", "true or false"),
            ("light", "[", "JSON"),
            ("quality", "ultra", "quality"),
            ("time", "1", "animation"),
        ] {
            let problem = keys(&[(key, text)]).unwrap_err();
            assert_eq!(problem.kind, Kind::Options, "{key}={text}");
            assert!(problem.message.contains(what), "{key}={text}: {}", problem.message);
        }
    }

    fn offered(text: &str, pairs: &[(&str, &str)], max_price: Option<u64>) -> Result<u64, Problem> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("presets.toml");
        std::fs::write(&path, text).unwrap();
        let (presets, offers) = offers::read(&path).unwrap();
        let rules = Rules { presets, offers, max_price, ..rules() };
        let options = of_pairs(pairs.iter().copied(), &rules)?;
        options.priced(options.format.unwrap_or(OutputFormat::Png), &rules).map(|priced| priced.price)
    }

    #[test]
    fn presets_may_be_all_that_is_offered() {
        let only = "only = true\n[preset]\nthumb = 'size:64'\nhero = 'size:900/quality:best'";
        for pairs in
            [&[("preset", "thumb")][..], &[("preset", "hero"), ("format", "webp"), ("name", "a.glb")]]
        {
            assert!(offered(only, pairs, None).is_ok(), "{pairs:?}");
        }
        for (pairs, what) in [
            (&[][..], "one of them is needed: hero, thumb"),
            (&[("preset", "thumb"), ("preset", "hero")], "one at a time"),
            (&[("preset", "thumb"), ("size", "32")], "size: presets alone"),
            (&[("preset", "thumb"), ("height", "32")], "height: presets alone"),
            (&[("quality", "draft")], "quality: presets alone"),
        ] {
            let problem = offered(only, pairs, None).unwrap_err();
            assert_eq!(problem.kind, Kind::NotOffered, "{pairs:?}");
            assert!(problem.message.contains(what), "{pairs:?}: {}", problem.message);
        }
        let unknown = offered(only, &[("preset", "card")], None).unwrap_err();
        assert_eq!(unknown.kind, Kind::Preset);
        assert_eq!(unknown.message, "preset: there is none 'card', but hero, thumb");
    }

    #[test]
    fn what_is_beside_presets_has_its_range() {
        let text = "[preset]\nhero = 'size:900/format:webp'\n[allow]\nsize = { min = 16, max = 128 }\nformat = ['png']";
        let hero = ("preset", "hero");
        for pairs in [&[hero][..], &[("size", "128")], &[hero, ("format", "png")], &[("size", "900"), hero]] {
            assert!(offered(text, pairs, None).is_ok(), "{pairs:?}");
        }
        for pairs in [
            &[hero, ("size", "900")][..],
            &[hero, ("width", "64")],
            &[("size", "8")],
            &[("format", "webp")],
            &[hero, ("format", "jpg")],
            &[("view", "top")],
        ] {
            assert_eq!(offered(text, pairs, None).unwrap_err().kind, Kind::NotOffered, "{pairs:?}");
        }
        // An option that does not exist is not one that is not offered.
        assert_eq!(offered(text, &[("colour", "red")], None).unwrap_err().kind, Kind::Options);
        assert_eq!(offered(text, &[("size", "2000")], None).unwrap_err().kind, Kind::Options);
    }

    #[test]
    fn prices_have_a_bound() {
        let dear = [("size", "1024"), ("quality", "best")];
        let price = offered("", &dear, None).unwrap();
        assert_eq!(offered("", &dear, Some(price)).unwrap(), price);
        let problem = offered("", &dear, Some(price - 1)).unwrap_err();
        assert_eq!((problem.kind, problem.limit.as_deref()), (Kind::Price, Some("max_price")));
        assert!(problem.message.contains(&format!("costs {price} units, and {} are", price - 1)));
        // The default of the service counts, and lamps.
        let light = ("light", r#"[{"type":"point","position":[1,2,3],"intensity":1}]"#);
        assert!(offered("", &[light], None).unwrap() > offered("", &[], None).unwrap());
    }
}
