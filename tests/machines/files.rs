//! A recipe as the files that `overcoat render --scene` draws. Whatever renders a recipe, in memory or in another
//! program, starts from these bytes.

use super::recipe::{EnvironmentRecipe, KeyValue, Recipe, TextureUse};
use super::{gltf, pictures, plain};
use overcoat::description::LightDescription;
use overcoat::load::Format;
use overcoat::render::Quality;
use overcoat::scene::{Filter, Wrap};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Formats of models that recipes are written in.
pub const WRITTEN: [Format; 6] =
    [Format::Gltf, Format::Glb, Format::Obj, Format::Stl, Format::Ply, Format::ThreeMf];

/// The scene file.
pub const SCENE: &str = "scene.toml";

/// Folder of material files, and below it of their textures: they read from nowhere else.
pub const MATERIALS: &str = "materials/";

/// Names and contents.
#[derive(Clone, Debug)]
pub struct Files(pub BTreeMap<String, Vec<u8>>);

pub fn material_name(number: usize) -> String {
    format!("m{number}")
}

/// The path of a texture as material files write it.
fn texture_name(recipe: &Recipe, number: usize) -> String {
    format!("textures/t{number}.{}", recipe.textures[number].format.extension())
}

/// The path of a texture as the model file writes it.
pub fn texture_path(recipe: &Recipe, number: usize) -> String {
    format!("{MATERIALS}{}", texture_name(recipe, number))
}

impl Files {
    /// The files of a recipe.
    pub fn of(recipe: &Recipe) -> Result<Self, String> {
        let mut files = BTreeMap::new();
        let model = format!("model.{}", recipe.container.extension());
        let bytes = match recipe.container {
            _ if recipe.given.is_some() => {
                recipe.given.as_ref().map_or_else(Vec::new, |given| given.bytes.clone())
            }
            Format::Gltf => {
                let (json, buffer) = gltf::write(recipe, Some("model.bin"));
                files.insert("model.bin".to_owned(), buffer);
                format!("{json:#}\n").into_bytes()
            }
            Format::Glb => gltf::glb(recipe),
            Format::Obj => {
                let (text, library) = plain::obj(recipe);
                files.insert("model.mtl".to_owned(), library.into_bytes());
                text.into_bytes()
            }
            Format::Stl => plain::stl(recipe),
            Format::Ply => plain::ply(recipe),
            Format::ThreeMf => plain::three_mf(recipe),
            other => return Err(format!("nothing here writes {other:?}")),
        };
        files.insert(model.clone(), bytes);
        for (k, texture) in recipe.textures.iter().enumerate() {
            files.insert(texture_path(recipe, k), pictures::texture(texture)?);
        }
        for (k, material) in recipe.materials.iter().enumerate().filter(|(_, m)| !m.keys.is_empty()) {
            let text = material_text(recipe, !material.replaces, &material.keys);
            files.insert(format!("{MATERIALS}{}.toml", material_name(k)), text.into_bytes());
        }
        let environment = match recipe.environment {
            EnvironmentRecipe::None => "none",
            EnvironmentRecipe::Studio => "studio",
            EnvironmentRecipe::Hdr(number) => {
                files.insert("sky.hdr".to_owned(), pictures::hdr(number));
                "sky.hdr"
            }
            EnvironmentRecipe::Exr(number) => {
                files.insert("sky.exr".to_owned(), pictures::exr(number)?);
                "sky.exr"
            }
        };
        files.insert(SCENE.to_owned(), scene_text(recipe, &model, environment).into_bytes());
        Ok(Self(files))
    }

    /// Writes them to a folder, in place of what is there.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        if folder.exists() {
            std::fs::remove_dir_all(folder)?;
        }
        self.0.iter().try_for_each(|(name, bytes)| {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
            std::fs::write(path, bytes)
        })
    }

    /// One of them.
    pub fn get(&self, name: &str) -> Result<&[u8], String> {
        self.0.get(name).map(Vec::as_slice).ok_or_else(|| format!("there is no file {name}"))
    }
}

fn list(values: &[f32]) -> String {
    let numbers: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
    format!("[{}]", numbers.join(", "))
}

fn material_text(recipe: &Recipe, over: bool, keys: &[(&'static str, KeyValue)]) -> String {
    let mut text = format!("over = {over}\n");
    let line = |key: &str, value: &KeyValue| match value {
        KeyValue::Text(value) => format!("{key} = {value}\n"),
        KeyValue::Texture(used) => format!("{key} = {}\n", texture_table(recipe, used)),
    };
    let is_option = |key: &str| key.starts_with("options.");
    keys.iter().filter(|(key, _)| !is_option(key)).for_each(|(key, value)| text += &line(key, value));
    if keys.iter().any(|(key, _)| is_option(key)) {
        text += "\n[options]\n";
    }
    for (key, value) in keys {
        if let Some(option) = key.strip_prefix("options.") {
            text += &line(option, value);
        }
    }
    text
}

fn texture_table(recipe: &Recipe, used: &TextureUse) -> String {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => "repeat",
        Wrap::MirroredRepeat => "mirror",
        Wrap::ClampToEdge => "clamp",
    };
    let mut table = format!("{{ file = \"{}\"", texture_name(recipe, used.texture));
    if let Some(channel) = used.channel {
        let _ = write!(table, ", channel = \"{}\"", ["r", "g", "b", "a"][usize::from(channel)]);
    }
    let plain = TextureUse { channel: used.channel, ..TextureUse::plain(used.texture) };
    if *used != plain {
        let _ = write!(
            table,
            ", uv_set = {}, scale = {}, offset = {}, rotation = {:?}, wrap = [\"{}\", \"{}\"], filter = \"{}\"",
            used.uv_set,
            list(&used.scale),
            list(&used.offset),
            used.rotation,
            wrap(used.wrap[0]),
            wrap(used.wrap[1]),
            if used.magnification == Filter::Nearest { "nearest" } else { "linear" },
        );
    }
    table + " }"
}

fn scene_text(recipe: &Recipe, model: &str, environment: &str) -> String {
    let mut text = String::new();
    let [width, height] = recipe.size;
    let _ = write!(
        text,
        "model = \"{model}\"\nenv = \"{environment}\"\nenv_rotation_deg = {:?}\nenv_intensity = {:?}\n\
         size = [{width}, {height}]\nsamples = {}\nbackground = \"{}\"\ntone_mapping = \"{}\"\nexposure = {:?}\n\
         anisotropy = {}\nquality = \"{}\"\nground = \"{}\"\nground_reflection = {:?}\n",
        recipe.environment_rotation,
        recipe.environment_intensity,
        recipe.samples,
        recipe.background,
        recipe.tone_curve.name(),
        recipe.exposure,
        recipe.anisotropy,
        recipe.quality.name(),
        recipe.ground,
        recipe.ground_reflection,
    );
    if recipe.quality != Quality::Draft {
        // So many scenes do not look at large maps for long.
        text += "map_size = 32\n";
    }
    if recipe.relief {
        text += "cavity = 1.0\nrim = 1.0\n";
    }
    if let Some(model) = recipe.shading {
        let _ = writeln!(text, "shading = \"{}\"", model.name());
    }
    if let Some(time) = recipe.given.as_ref().and_then(|given| given.time) {
        let _ = writeln!(text, "animation = 0\ntime = {time:?}");
    }
    let has_names = matches!(recipe.container, Format::Gltf | Format::Glb | Format::Obj);
    let with_keys: Vec<String> = (0..recipe.materials.len())
        .filter(|&k| !recipe.materials[k].keys.is_empty())
        .map(material_name)
        .collect();
    if let (false, Some(first)) = (has_names, with_keys.first()) {
        let _ = writeln!(text, "material = \"{MATERIALS}{first}.toml\"");
    }
    let camera = &recipe.camera;
    text += "\n[camera]\n";
    let single = |place: [f64; 3]| place.map(|v| v as f32);
    let places = [("eye", camera.eye.map(single)), ("target", camera.target.map(single)), ("up", camera.up)];
    for (key, value) in places {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {}", list(&value));
        }
    }
    for (key, value) in [
        ("fov_y_deg", camera.fov_y_degrees),
        ("near", camera.near),
        ("ortho_height", camera.orthographic_height),
    ] {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value:?}");
        }
    }
    if has_names && !with_keys.is_empty() {
        text += "\n[materials]\n";
        with_keys.iter().for_each(|name| text += &format!("{name} = \"{MATERIALS}{name}.toml\"\n"));
    }
    recipe.lights.iter().for_each(|light| light_text(&mut text, light));
    text
}

fn light_text(text: &mut String, light: &LightDescription) {
    let number = |v: &f32| format!("{v:?}");
    let kind;
    let mut lines: Vec<(&str, Option<String>)> = Vec::new();
    let (shared_color, shared_intensity) = match light {
        LightDescription::Directional { direction, color, intensity, min_roughness } => {
            kind = "directional";
            lines.push(("direction", Some(list(direction))));
            lines.push(("min_roughness", min_roughness.as_ref().map(number)));
            (color, intensity)
        }
        LightDescription::Point { position, range, color, intensity, min_roughness } => {
            kind = "point";
            lines.push(("position", Some(list(position))));
            lines.push(("range", range.as_ref().map(number)));
            lines.push(("min_roughness", min_roughness.as_ref().map(number)));
            (color, intensity)
        }
        LightDescription::Spot {
            position,
            target,
            range,
            inner_cone_deg,
            outer_cone_deg,
            color,
            intensity,
            min_roughness,
        } => {
            kind = "spot";
            lines.push(("position", Some(list(position))));
            lines.push(("target", Some(list(target))));
            lines.push(("range", range.as_ref().map(number)));
            lines.push(("inner_cone_deg", inner_cone_deg.as_ref().map(number)));
            lines.push(("outer_cone_deg", outer_cone_deg.as_ref().map(number)));
            lines.push(("min_roughness", min_roughness.as_ref().map(number)));
            (color, intensity)
        }
        LightDescription::Rect { position, target, up, size, two_sided, color, intensity } => {
            kind = "rect";
            lines.push(("position", Some(list(position))));
            lines.push(("target", Some(list(target))));
            lines.push(("up", up.as_ref().map(|v| list(v))));
            lines.push(("size", Some(list(size))));
            lines.push(("two_sided", two_sided.map(|v| v.to_string())));
            (color, intensity)
        }
        LightDescription::Tube { from, to, radius, color, intensity } => {
            kind = "tube";
            lines.push(("from", Some(list(from))));
            lines.push(("to", Some(list(to))));
            lines.push(("radius", Some(number(radius))));
            (color, intensity)
        }
        other => panic!("a light of a kind that has no name here: {other:?}"),
    };
    lines.push(("color", shared_color.as_ref().map(|v| list(v))));
    lines.push(("intensity", Some(number(shared_intensity))));
    let _ = writeln!(text, "\n[[light]]\ntype = \"{kind}\"");
    for (key, value) in lines {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value}");
        }
    }
}
