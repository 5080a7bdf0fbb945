//! Items of a batch: models and their pictures, from a manifest, a folder or a prefix.

use crate::place::{Listed, Place, is_url};
use overcoat::load::Format;
use overcoat_worker::protocol::PictureRequest;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

/// A model and the pictures of it.
#[derive(Clone, Debug)]
pub struct Item {
    /// Folder or prefix that the model's name is relative to.
    pub place: Place,
    /// Path of the model below that place.
    pub name: String,
    /// The model as the report names it.
    pub shown: String,
    /// Time of its last change, where that is known already.
    pub modified: Option<SystemTime>,
    /// Pictures to make of it.
    pub pictures: Vec<Wanted>,
}

/// One picture of a model.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Path of its file below the output place.
    pub out: String,
    /// Options of the picture.
    pub request: PictureRequest,
}

/// Defaults for models that do not set these options.
#[derive(Clone, Debug, Default)]
pub struct Defaults {
    /// Format, planes and the like.
    pub request: PictureRequest,
    /// Sides of square pictures; one of the common options' size if empty.
    pub sizes: Vec<u32>,
    /// Views, each a picture.
    pub views: Vec<String>,
    /// Presets, each a picture.
    pub presets: Presets,
}

/// Sets of options under names.
#[derive(Clone, Debug, Default)]
pub struct Presets {
    /// All of them.
    pub known: BTreeMap<String, PictureRequest>,
    /// Names of those that pictures are made by; none if there are none.
    pub chosen: Vec<String>,
}

impl Presets {
    /// Presets of which others are chosen: names with commas.
    ///
    /// # Errors
    /// One line that names the preset that does not exist.
    pub fn choose(mut self, names: &str) -> Result<Self, String> {
        let names = names.split(',').map(str::trim).filter(|name| !name.is_empty());
        self.chosen = names.map(str::to_owned).collect();
        match self.chosen.iter().find(|name| !self.known.contains_key(*name)) {
            Some(name) => {
                let known: Vec<&str> = self.known.keys().map(String::as_str).collect();
                Err(format!("there is no preset '{name}' among {}", known.join(", ")))
            }
            None => Ok(self),
        }
    }

    /// Options of the chosen ones, with their names.
    fn pictures(&self) -> impl Iterator<Item = (&str, &PictureRequest)> {
        self.chosen.iter().filter_map(|name| Some((name.as_str(), self.known.get(name)?)))
    }
}

/// Endings of packed files.
const PACKED: [&str; 2] = ["gz", "zst"];

/// True if a file is a model by its name.
#[must_use]
pub fn is_model(name: &str) -> bool {
    let extension =
        |name: &str| name.rsplit_once('.').map(|(stem, e)| (stem.to_owned(), e.to_ascii_lowercase()));
    match extension(name) {
        Some((stem, packed)) if PACKED.contains(&packed.as_str()) => {
            extension(&stem).is_some_and(|(_, e)| Format::from_extension(&e).is_some())
        }
        Some((_, e)) => Format::from_extension(&e).is_some(),
        None => false,
    }
}

impl Defaults {
    /// The pictures of a model that asks for none of its own: every view in every size, by names that nothing else has.
    #[must_use]
    pub fn pictures(&self, name: &str, keys: &Map<String, Value>) -> Vec<Wanted> {
        let views: Vec<Option<&str>> = some_or_one(self.views.iter().map(String::as_str));
        let sizes: Vec<Option<u32>> = some_or_one(self.sizes.iter().copied());
        let mut pictures = Vec::with_capacity(views.len() * sizes.len());
        for (preset, own) in self.presets.pictures() {
            let mut request = own.clone();
            request.keys.extend(keys.clone());
            let out = format!("{name}.{preset}.{}", request.format);
            pictures.push(Wanted { out, request });
        }
        if !pictures.is_empty() {
            return pictures;
        }
        for view in views {
            for &size in &sizes {
                let mut request = self.request.clone();
                let mut out = name.to_owned();
                if let Some(view) = view {
                    request.keys.insert("camera".to_owned(), serde_json::json!({ "view": view }));
                    out += &format!(".{}", view.replace([',', '/', '\\'], "_"));
                }
                if let Some(size) = size {
                    request.keys.insert("size".to_owned(), size.into());
                    out += &format!(".{size}");
                }
                request.keys.extend(keys.clone());
                out += &format!(".{}", request.format);
                pictures.push(Wanted { out, request });
            }
        }
        pictures
    }

    /// An item of a folder or a prefix.
    #[must_use]
    pub fn item(&self, place: &Place, Listed { name, modified }: &Listed) -> Item {
        Item {
            place: place.clone(),
            name: name.clone(),
            shown: name.clone(),
            modified: *modified,
            pictures: self.pictures(name, &Map::new()),
        }
    }

    /// An item of a manifest: a row whose keys are `model`, `out`, `format`, `aov`, `jpeg_quality`, `preset`, `pictures` (a list of such rows,
    /// without `model`) and those of scene files. Paths are relative to `folder`.
    ///
    /// # Errors
    /// One line that names the key.
    pub fn row(&self, folder: &Path, mut row: Map<String, Value>) -> Result<Item, String> {
        let model = match row.remove("model") {
            Some(Value::String(model)) if !model.is_empty() => model,
            Some(other) => return Err(format!("model: expected a path or a URL, got {other}")),
            None => return Err("names no model".to_owned()),
        };
        let (place, name) = place_of(&model, folder)?;
        let below = safe_name(&name_below(&model));
        let pictures = match row.remove("pictures") {
            None => self.pictures_of_row(&below, row)?,
            Some(Value::Array(rows)) if !rows.is_empty() => {
                let mut pictures = Vec::new();
                for own in rows {
                    let Value::Object(own) = own else {
                        return Err(format!("pictures: expected objects, got {own}"));
                    };
                    let mut all = row.clone();
                    all.extend(own);
                    pictures.extend(self.pictures_of_row(&below, all)?);
                }
                pictures
            }
            Some(other) => return Err(format!("pictures: expected a list of objects, got {other}")),
        };
        Ok(Item { place, name, shown: model, modified: None, pictures })
    }

    fn each_request(&mut self, change: impl Fn(&mut PictureRequest)) {
        change(&mut self.request);
        self.presets.known.values_mut().for_each(change);
    }

    fn pictures_of_row(&self, name: &str, mut row: Map<String, Value>) -> Result<Vec<Wanted>, String> {
        let mut own = self.clone();
        let text = |key: &str, value: Option<Value>| match value {
            None | Some(Value::Null) => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(format!("{key}: expected a text, got {other}")),
        };
        let out = text("out", row.remove("out"))?;
        if let Some(names) = text("preset", row.remove("preset"))? {
            own.presets = own.presets.choose(&names).map_err(|e| format!("preset: {e}"))?;
        }
        if let Some(format) = text("format", row.remove("format"))? {
            own.each_request(|request| request.format.clone_from(&format));
        }
        if let Some(quality) = row.remove("jpeg_quality") {
            let within = quality.as_u64().filter(|q| (1..=100).contains(q));
            let within = within.ok_or_else(|| format!("jpeg_quality: expected 1 to 100, got {quality}"))?;
            own.each_request(|request| request.jpeg_quality = Some(within as u8));
        }
        match row.remove("aov") {
            None => {}
            Some(Value::String(list)) => {
                let names: Vec<String> = list.split(',').map(|name| name.trim().to_owned()).collect();
                own.each_request(|request| request.aovs.clone_from(&names));
            }
            Some(other) => return Err(format!("aov: expected names with commas, got {other}")),
        }
        if let Some(view) = row.remove("view") {
            row.insert("camera".to_owned(), serde_json::json!({ "view": view }));
        }
        // Options that a row sets itself are not varied.
        if row.contains_key("size") {
            own.sizes.clear();
        }
        if row.contains_key("camera") {
            own.views.clear();
        }
        let mut pictures = match &out {
            Some(out) => {
                if let Some(format) = format_of(out) {
                    own.each_request(|request| request.format.clone_from(&format));
                }
                own.pictures(name, &row)
            }
            None => own.pictures(name, &row),
        };
        if let Some(out) = out {
            let safe = safe_name(&out);
            if safe != out {
                return Err(format!("out: '{out}' leads out of the folder of the pictures"));
            }
            if pictures.len() > 1 {
                return Err("out: this row makes several pictures, which cannot have one name".to_owned());
            }
            pictures.iter_mut().for_each(|picture| picture.out.clone_from(&out));
        }
        Ok(pictures)
    }
}

/// All of them, or one `None`.
fn some_or_one<T>(values: impl Iterator<Item = T>) -> Vec<Option<T>> {
    let all: Vec<Option<T>> = values.map(Some).collect();
    if all.is_empty() { vec![None] } else { all }
}

/// The format that the name of a picture has, if it is one.
fn format_of(out: &str) -> Option<String> {
    let (_, extension) = out.rsplit_once('.')?;
    let extension = extension.to_ascii_lowercase();
    overcoat::output::OutputFormat::from_extension(&extension).map(|_| extension)
}

/// The place of a model that a manifest names, and its name there.
fn place_of(model: &str, folder: &Path) -> Result<(Place, String), String> {
    if is_url(model) {
        let (before, name) = model.rsplit_once('/').unwrap_or(("", model));
        // A query belongs to the file.
        return Ok((Place::new(before)?, name.to_owned()));
    }
    let path = folder.join(model);
    let name = path.file_name().and_then(|name| name.to_str()).ok_or("model: names no file")?;
    Ok((Place::Folder(path.parent().unwrap_or(Path::new("")).to_owned()), name.to_owned()))
}

/// Part of a model's name that the names of its pictures are derived from: a URL without scheme, query and fragment.
fn name_below(model: &str) -> String {
    match model.split_once("://") {
        Some((_, rest)) => rest.split(['?', '#']).next().unwrap_or(rest).to_owned(),
        None => model.to_owned(),
    }
}

/// A relative name without steps out.
fn safe_name(name: &str) -> String {
    let name = name.replace('\\', "/");
    let parts = name.split('/').filter(|part| !matches!(*part, "" | "." | "..") && !part.contains('\0'));
    parts.collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn defaults() -> Defaults {
        let request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
        Defaults { request, ..Defaults::default() }
    }

    fn row(defaults: &Defaults, value: Value) -> Result<Vec<(String, Value)>, String> {
        let Value::Object(row) = value else { panic!("no row") };
        let item = defaults.row(Path::new("/m"), row)?;
        Ok(item.pictures.into_iter().map(|p| (p.out, Value::Object(p.request.keys))).collect())
    }

    #[test]
    fn models_are_known_by_their_names() {
        for name in ["a.glb", "b/c.STL", "x.obj.gz", "y.ply.zst", "z.3mf"] {
            assert!(is_model(name), "{name}");
        }
        for name in ["a.png", "glb", "x.gz", "a.bin", "a.mtl"] {
            assert!(!is_model(name), "{name}");
        }
    }

    #[test]
    fn every_picture_has_a_name_of_its_own() {
        let all = Defaults {
            sizes: vec![64, 128],
            views: vec!["front".to_owned(), "1,0,2".to_owned()],
            ..defaults()
        };
        let names: Vec<String> = all.pictures("a/b.glb", &Map::new()).into_iter().map(|p| p.out).collect();
        assert_eq!(
            names,
            [
                "a/b.glb.front.64.png",
                "a/b.glb.front.128.png",
                "a/b.glb.1_0_2.64.png",
                "a/b.glb.1_0_2.128.png"
            ]
        );
        assert_eq!(defaults().pictures("b.stl", &Map::new())[0].out, "b.stl.png");
    }

    #[test]
    fn presets_are_pictures() {
        let mut known = BTreeMap::new();
        for (name, size, format) in [("hero", 900, "webp"), ("thumb", 64, "png")] {
            let mut request = PictureRequest { format: format.to_owned(), ..PictureRequest::default() };
            request.keys.insert("size".to_owned(), size.into());
            known.insert(name.to_owned(), request);
        }
        let presets = Presets { known, chosen: Vec::new() };
        let all = Defaults { presets: presets.clone().choose("hero, thumb").unwrap(), ..defaults() };
        assert_eq!(
            row(&all, json!({"model": "x.glb", "quality": "good"})).unwrap(),
            [
                ("x.glb.hero.webp".to_owned(), json!({"size": 900, "quality": "good"})),
                ("x.glb.thumb.png".to_owned(), json!({"size": 64, "quality": "good"})),
            ]
        );
        let one = json!({"model": "x.glb", "preset": "thumb", "size": 32, "out": "y.jpg"});
        assert_eq!(row(&all, one).unwrap(), [("y.jpg".to_owned(), json!({"size": 32}))]);
        let none = Defaults { presets: presets.clone(), ..defaults() };
        assert_eq!(row(&none, json!({"model": "x.glb"})).unwrap(), [("x.glb.png".to_owned(), json!({}))]);
        let wrong = row(&none, json!({"model": "x.glb", "preset": "card"})).unwrap_err();
        assert_eq!(wrong, "preset: there is no preset 'card' among hero, thumb");
    }

    #[test]
    fn rows_say_what_is_made() {
        let all = Defaults { sizes: vec![64, 128], ..defaults() };
        assert_eq!(row(&all, json!({"model": "../x.glb"})).unwrap().len(), 2);
        assert_eq!(
            row(&all, json!({"model": "x.glb", "size": 32, "view": "top", "out": "a/y.webp"})).unwrap(),
            [("a/y.webp".to_owned(), json!({"size": 32, "camera": {"view": "top"}}))]
        );
        let several = json!({"model": "x.glb", "quality": "good", "pictures": [
            {"size": 32, "out": "a.png"}, {"size": [64, 32], "out": "b.png", "quality": "draft"},
        ]});
        assert_eq!(
            row(&all, several).unwrap(),
            [
                ("a.png".to_owned(), json!({"quality": "good", "size": 32})),
                ("b.png".to_owned(), json!({"quality": "draft", "size": [64, 32]})),
            ]
        );
        for (wrong, what) in [
            (json!({}), "names no model"),
            (json!({"model": 3}), "model: expected"),
            (json!({"model": "x.glb", "out": "../y.png", "size": 1}), "leads out"),
            (json!({"model": "x.glb", "out": "/y.png", "size": 1}), "leads out"),
            (json!({"model": "x.glb", "out": "y.png"}), "several pictures"),
            (json!({"model": "x.glb", "pictures": 3}), "pictures: expected"),
            (json!({"model": "x.glb", "jpeg_quality": 0}), "1 to 100"),
        ] {
            let error = row(&all, wrong.clone()).unwrap_err();
            assert!(error.contains(what), "{wrong}: {error}");
        }
    }
}
