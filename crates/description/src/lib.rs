//! The description of a picture: what it shows, from where, in which light, how large. A typed [`Description`], and the scene
//! files that it is read from, JSON or TOML with the same keys.
//!
//! ```toml
//! model = "car.glb"
//! env = "studio"
//! size = [640, 480]
//! camera = { eye = [4, 2, 6], target = [0, 0.5, 0], fov_y_deg = 30 }
//! ```
//!
//! Every key is optional. Keys are in lower case with `_` between words; `fovYDeg` and `fov-y-deg` are read with a warning.
//! The command line's options are laid over the same structure, so that a picture has one description whichever way it was
//! asked for.
//!
//! [`Description::open`] reads a file, [`Description::from_text`] a text. [`Description::picture`] loads what is named
//! in it, [`Description::picture_of`] takes a scene that is there already; out comes a [`Picture`] with everything that
//! [`Renderer::render_image`](overcoat_render::Renderer::render_image) wants. The steps in between are public as well, for who needs
//! only some: [`Description::options`], [`Description::environment`], [`Description::light`], [`Description::camera`],
//! [`Materials`], and [`Setting`] for what many models share.
//!
//! A description is written by serde as a scene file (`toml::to_string`, `serde_json::to_string`). [`scene_schema`] is a JSON
//! schema of scene files.
//!
//! ```
//! # mod overcoat { pub use {overcoat_core::limits::Limits, overcoat_description as description, overcoat_load as load, overcoat_render::Renderer, overcoat_scene as scene}; }
//! use overcoat::description::{Description, Machine};
//! use overcoat::load::Loaded;
//! use overcoat::scene::{Instance, Material, Mesh, MeshData, Scene, Transform};
//! use overcoat::{Limits, Renderer};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let description = Description::from_text("size = 32\nsamples = 4\n[camera]\nview = 'front'")?;
//!
//! let mut scene = Scene::new();
//! let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = scene.add_mesh(Mesh::new(MeshData::new(positions, vec![[0, 1, 2]]))?)?;
//! let material = scene.add_material(Material::default())?;
//! scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
//!
//! let mut renderer = Renderer::new(1);
//! let picture = description.picture_of(Loaded::from(scene), Machine::default(), &Limits::default(), renderer.jobs())?;
//! let image = renderer.render_image(&picture.scene, &picture.camera, &picture.options, &picture.display)?.image;
//! assert_eq!((image.width, image.height), (32, 32));
//! # Ok(())
//! # }
//! ```

mod argument;
mod camera;
mod environment;
mod error;
mod input;
mod keys;
mod kind;
mod light;
mod materials;
mod name;
mod option;
mod options;
mod picture;
mod schema;
mod tree;
mod value;
mod write;

pub use argument::{Argument, Group};
pub use camera::{CameraDescription, ViewDirection};
pub use environment::EnvironmentChoice;
pub use error::DescriptionError;
pub use input::is_standard_stream;
pub use input::{is_standard_input, read_standard_input};
pub use kind::{background, ground_name, one_of, position, seconds, size};
pub use light::{LightDescription, cone_cosine};
pub use materials::builtin;
pub use materials::{MaterialChoice, MaterialSource, Materials};
pub use name::file_name;
pub use name::one_line;
pub use option::DescriptionOption;
pub use options::{BackgroundChoice, ExposureChoice, Machine};
pub use picture::{Picture, Setting};
pub use schema::scene_schema;

use keys::SCENE;
use overcoat_core::color::ToneCurve;
use overcoat_core::frame::PlaneSample;
use overcoat_core::limits::Limits;
use overcoat_load::{AnimationChoice, LoadError, Warning, has_folder, inner_extension, read_input};
use overcoat_render::{Edges, Ground, Quality};
use overcoat_scene::Axis;
use overcoat_scene::{AreaLightMethod, ShadingModel};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};
use tree::{Node, line};
use value::Value;

/// Bytes of a scene file at most: it holds names and numbers only.
const MAX_BYTES: u64 = 1 << 20;

/// Content and look of a picture. A key that is absent leaves the choice to the command line or to the default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The model file.
    pub model: Option<PathBuf>,
    /// Up axis of the model file, for example `+z`; what its format has, or the model's shape says, if absent.
    pub up: Option<Axis>,
    /// Plate of a 3MF project that is drawn alone, from 1; all of them side by side if absent.
    pub plate: Option<u32>,
    /// Source of the light from afar: a name of [`overcoat_load::NamedEnvironment`] or the path of an equirectangular picture.
    pub env: Option<EnvironmentChoice>,
    /// Turns the environment about +Y, in degrees, counter-clockwise seen from above.
    pub env_rotation_degrees: Option<f32>,
    /// Multiplies the environment's radiance.
    pub env_intensity: Option<f32>,
    /// False leaves out the lights of the model file.
    pub lights: Option<bool>,
    /// Lights beside those of the model file.
    pub lights_to_add: Vec<LightDescription>,
    /// The camera.
    pub camera: CameraDescription,
    /// An animation of the model file, by its name or number.
    pub animation: Option<String>,
    /// Seconds in the animation.
    pub time: Option<f64>,
    /// After its end the animation begins again.
    pub repeat: Option<bool>,
    /// Width and height in pixels.
    pub size: Option<[u64; 2]>,
    /// `transparent`, `env`, a colour name or `#rrggbb`.
    pub background: Option<BackgroundChoice>,
    /// Tone curve of 8-bit output: one name or a list of names, of which the first counts.
    pub tone_curve: Option<ToneCurve>,
    /// Exposure of 8-bit output in stops: the picture is multiplied by 2 to this power before the tone curve; or metered.
    pub exposure: Option<ExposureChoice>,
    /// Coverage samples a pixel: 1, 4, 8 or 16.
    pub samples: Option<u32>,
    /// Quality tier: names a setting of the next four. [`Quality::default`] if absent.
    pub quality: Option<Quality>,
    /// Directions of the environment's light, each with a depth map, 0 to 256.
    pub maps: Option<u32>,
    /// Texels along a side of a depth map, 32 to 2048.
    pub map_size: Option<u32>,
    /// Rays of a lobe, 0 to 256.
    pub rays: Option<u32>,
    /// Shadings a pixel where one would show: 1, 4, 8, 9 or 16. A picture has at least as many samples.
    pub shading_rate: Option<u32>,
    /// All surfaces are shaded as often.
    pub shade_everywhere: Option<bool>,
    /// Floor under the model: `none`, `shadow`, a colour name or `#rrggbb`. If absent its shadow, and nothing
    /// without maps.
    pub ground: Option<Ground>,
    /// Part of the light of the model that the floor mirrors, 0 to 1. With one there is a floor, unless `ground` says none.
    pub ground_reflection: Option<f32>,
    /// Shading model by name.
    pub shading: Option<ShadingModel>,
    /// A material for every mesh: the path of a material file, or the name of a built-in one.
    pub material: Option<MaterialSource>,
    /// Materials by the names of those in the model that they take the place of.
    pub materials: BTreeMap<String, MaterialSource>,
    /// Laid over these, in this order; not part of the file.
    pub more_materials: Vec<MaterialChoice>,
    /// Largest anisotropy of texture filtering, 1 to 16.
    pub anisotropy: Option<u32>,
    /// Roughness grows where normals vary within a pixel.
    pub specular_antialiasing: Option<bool>,
    /// Integration of reflections of rectangles and tubes: `ltc` or `facets`.
    pub area_lights: Option<AreaLightMethod>,
    /// Triangles smaller than a pixel are shaded as one where their normals differ by less than this, 0 to 45 degrees.
    pub merge_angle_degrees: Option<f32>,
    /// Edges that are drawn as lines: `none`, `creases` or `boundary`. If absent, creases of parts of clay.
    pub edges: Option<Edges>,
    /// Width of these lines in pixels, 0.1 to 64.
    pub edge_width: Option<f32>,
    /// Strength by which concave creases are drawn darker and convex ones lighter, 0 to 2. If absent, 1 of parts of clay.
    pub cavity: Option<f32>,
    /// Strength by which surfaces are drawn darker towards their outline, 0 to 2. If absent, 1 of white models in the studio.
    pub rim: Option<f32>,
    /// Width of lines in pixels, 0.1 to 64.
    pub line_width: Option<f32>,
    /// Diameter of points in pixels, 0.1 to 64.
    pub point_size: Option<f32>,
    /// Surface of a pixel that planes of geometry and identities show: `center` or `nearest`.
    pub aov_sample: Option<PlaneSample>,

    /// Warnings about the file that it was read from.
    pub warnings: Vec<Warning>,
}

impl Description {
    /// Reads a scene file, also one in gzip or Zstandard, a pipe, or `-` for standard input: TOML or JSON by its name, by
    /// its first character where that says nothing. Relative paths in it are taken to be relative to its folder (of a
    /// pipe, the current one), and may lead anywhere: who names a scene file trusts it.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the file, and the key that is wrong.
    pub fn open(path: &Path) -> Result<Self, DescriptionError> {
        let text = read_text(path).map_err(|error| error.at(path))?;
        let parsed = match inner_extension(path).as_deref() {
            Some("toml") => Self::from_toml(&text),
            Some("json") => Self::from_json(&text),
            _ => Self::from_text(&text),
        };
        let mut scene = parsed.map_err(|error| error.at(path))?;
        for warning in &mut scene.warnings {
            *warning = warning.clone().of(&file_name(path));
        }
        let folder = path.parent().filter(|_| has_folder(path) && !is_standard_input(path));
        scene.resolve_paths(folder.unwrap_or(Path::new("")));
        Ok(scene)
    }

    /// Parses JSON if the text begins with a brace, TOML otherwise. Relative paths stay as they are, see
    /// [`Description::resolve_paths`].
    ///
    /// # Errors
    /// [`DescriptionError`] with the key or the place that is wrong.
    pub fn from_text(text: &str) -> Result<Self, DescriptionError> {
        if text.trim_start().starts_with('{') { Self::from_json(text) } else { Self::from_toml(text) }
    }

    /// Parses JSON.
    ///
    /// # Errors
    /// [`DescriptionError`] with the key or the place that is wrong.
    pub fn from_json(text: &str) -> Result<Self, DescriptionError> {
        let node = Node::json(text).map_err(DescriptionError::invalid)?;
        Self::read(node).map_err(DescriptionError::invalid)
    }

    /// Parses TOML.
    ///
    /// # Errors
    /// [`DescriptionError`] with the key or the place that is wrong.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionError> {
        let table = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            DescriptionError::invalid(format!("line {}: {}", line(text, at), e.message()))
        })?;
        let table = DeValue::Table(table.into_inner());
        Self::read(Node::toml(text, &table)).map_err(DescriptionError::invalid)
    }

    /// Reads the keys.
    fn read(file: Node<'_>) -> Result<Self, String> {
        let (mut scene, warnings) = (Self::default(), RefCell::default());
        Value::file(file, &warnings).table(SCENE, &mut scene)?;
        scene.warnings = warnings.into_inner();
        Ok(scene)
    }

    /// Makes relative paths relative to `folder`.
    pub fn resolve_paths(&mut self, folder: &Path) {
        if let Some(model) = &mut self.model {
            *model = folder.join(&*model);
        }
        if let Some(EnvironmentChoice::File(file)) = &mut self.env {
            *file = folder.join(&*file);
        }
        for material in self.material.iter_mut().chain(self.materials.values_mut()) {
            if let MaterialSource::File(file) = material {
                *file = folder.join(&*file);
            }
        }
    }

    /// The animation and the time in it, if there is one.
    ///
    /// # Errors
    /// [`DescriptionError`] if there is a time and no animation, or a time that is none.
    pub fn animation_choice(&self) -> Result<Option<AnimationChoice>, DescriptionError> {
        let time = self.time.unwrap_or(0.0);
        if !(time.is_finite() && time >= 0.0) {
            return Err(DescriptionError::out_of_range(format!("time {time}: expected seconds, at least 0")));
        }
        match &self.animation {
            Some(name) => {
                let repeat = self.repeat.unwrap_or(false);
                Ok(Some(AnimationChoice { name: name.clone(), time, repeat }))
            }
            None if self.time.is_some() || self.repeat == Some(true) => {
                Err(DescriptionError::TimeWithoutAnimation)
            }
            None => Ok(None),
        }
    }

    /// All materials that are laid over those of the model, in order.
    pub fn material_choices(&self) -> impl Iterator<Item = MaterialChoice> {
        let every = self.material.iter().map(|source| MaterialChoice { name: None, source: source.clone() });
        let named = self
            .materials
            .iter()
            .map(|(name, source)| MaterialChoice { name: Some(name.clone()), source: source.clone() });
        every.chain(named).chain(self.more_materials.iter().cloned())
    }
}

/// The text of a small file.
fn read_text(path: &Path) -> Result<String, DescriptionError> {
    let limits = Limits::default().with_input_bytes(MAX_BYTES);
    let bytes = if is_standard_input(path) {
        read_standard_input(&limits)?
    } else {
        let (bytes, damage) = read_input(path, &limits).map_err(|error| match error {
            LoadError::Limit(_) => DescriptionError::invalid("too large for a scene file"),
            error => error.into(),
        })?;
        if let Some(damage) = damage {
            return Err(DescriptionError::invalid(damage));
        }
        bytes
    };
    String::from_utf8(bytes).map_err(|_| DescriptionError::invalid("not a text file"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_are_files_beside_it_or_built_in() {
        let text = r#"{"material": "paint.toml", "materials": {"body": "candy-red", "a": "x/y.toml"}}"#;
        let mut scene = Description::from_json(text).unwrap();
        let toml = "material = 'paint.toml'\n[materials]\nbody = 'candy-red'\na = 'x/y.toml'\n";
        assert_eq!(Description::from_toml(toml).unwrap(), scene);
        scene.resolve_paths(Path::new("f"));
        scene.more_materials.push(MaterialChoice {
            name: Some("body".to_owned()),
            source: MaterialSource::new("velvet").unwrap(),
        });
        let choices: Vec<String> = scene.material_choices().map(|c| format!("{:?}", c)).collect();
        let expected = [
            (None, MaterialSource::File("f/paint.toml".into())),
            (Some("a"), MaterialSource::File("f/x/y.toml".into())),
            (Some("body"), MaterialSource::Builtin("candy-red")),
            (Some("body"), MaterialSource::Builtin("velvet")),
        ]
        .map(|(name, source)| format!("{:?}", MaterialChoice { name: name.map(str::to_owned), source }));
        assert_eq!(choices, expected);
        let error = Description::from_json(r#"{"material": "candy-rad"}"#).unwrap_err().to_string();
        assert!(error.contains("did you mean 'candy-red'"), "{error}");
    }

    const JSON: &str = r##"{
        "name": "x", "note": "why", "peers": ["a"], "ground_truth": {"p": "c.exr"},
        "model": "../m/car.glb", "env": "sky.hdr", "env_rotation_deg": 90, "env_intensity": 0.5,
        "camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 30, "near": 0.01, "far": 1000},
        "size": [512, 256], "background": "#102030", "tone_mapping": ["linear", "neutral", "aces"],
        "samples": 16, "shading": "urp-mobile", "exposure": -1
    }"##;

    #[test]
    fn a_time_belongs_to_an_animation() {
        let choice = |text: &str| Description::from_toml(text).unwrap().animation_choice();
        assert_eq!(choice("").unwrap(), None);
        let walk = AnimationChoice { name: "Walk".to_owned(), time: 0.5, repeat: true };
        assert_eq!(choice("animation = 'Walk'\ntime = 0.5\nloop = true").unwrap(), Some(walk));
        let first = AnimationChoice { name: "0".to_owned(), ..AnimationChoice::default() };
        assert_eq!(choice("animation = 0").unwrap(), Some(first));
        for bad in ["time = 1.0", "loop = true"] {
            let error = choice(bad).unwrap_err();
            assert!(matches!(error, DescriptionError::TimeWithoutAnimation), "{bad}: {error}");
        }
        for bad in ["animation = 0\ntime = nan", "animation = 0\ntime = -1.0"] {
            let error = Description::from_toml(bad).unwrap_err().to_string();
            assert!(error.starts_with("line 2: time: expected a number of seconds"), "{error}");
        }
    }

    #[test]
    fn json_and_toml_mean_the_same() {
        let toml = r##"
            name = "x"
            model = "../m/car.glb"
            env = "sky.hdr"
            env_rotation_deg = 90
            env_intensity = 0.5
            size = [512, 256]
            background = "#102030"
            tone_mapping = "none"
            samples = 16
            shading = "urp-mobile"
            exposure = -1
            [camera]
            eye = [1, 2, 3]
            target = [0, 0, 0]
            up = [0, 1, 0]
            fov_y_deg = 30
            near = 0.01
            far = 1000
        "##;
        let json = Description::from_json(JSON).unwrap();
        assert_eq!(json, Description::from_toml(toml).unwrap());
        assert_eq!(json.camera.eye, Some([1.0, 2.0, 3.0]));
        assert_eq!(json.background, Some(BackgroundChoice::Color([16, 32, 48])));
        assert_eq!(json.tone_curve, Some(ToneCurve::None));
    }

    #[test]
    fn paths_are_relative_to_the_scene_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.json");
        std::fs::write(&path, JSON).unwrap();
        let scene = Description::open(&path).unwrap();
        assert_eq!(scene.model, Some(folder.path().join("../m/car.glb")));
        assert_eq!(scene.env, Some(EnvironmentChoice::File(folder.path().join("sky.hdr"))));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, name) in [
            (r#"{"modle": "x"}"#, "modle"),
            (r#"{"camera": {"fov": 3}}"#, "fov"),
            (r#"{"background": "whitish"}"#, "whitish"),
            (r#"{"tone_mapping": ["linear", "filmic"]}"#, "filmic"),
            (r#"{"tone_mapping": 3}"#, "tone_mapping"),
            (r#"{"exposure": "bright"}"#, "auto"),
            (r#"{"samples": 5}"#, "samples"),
            (r#"{"up": "w"}"#, "+z"),
            (r#"{"up": [0, 0, 1]}"#, "camera.up"),
            (r#"{"shading": "phong"}"#, "phong"),
            (r#"{"size": [1, 2], "size": [1, 2]}"#, "size"),
            (r#"{"size""#, "line 1"),
        ] {
            let error = Description::from_json(text).unwrap_err();
            assert!(error.to_string().contains(name), "{text}: {error}");
        }
        let error = Description::from_toml("size = [1, 2]\nmodle = 'x'\n").unwrap_err().to_string();
        assert_eq!(error, "line 2: modle: there is no such key; did you mean 'model'?");
    }

    /// The line, the key, what it takes in words, and what is there: the same in JSON and in TOML.
    #[test]
    fn what_is_expected_is_said_in_words() {
        for (key, value, expected) in [
            ("anisotropy", "17", "a whole number from 1 to 16, found 17"),
            ("anisotropy", "\"x\"", "a whole number from 1 to 16, found \"x\""),
            ("anisotropy", "2.5", "a whole number from 1 to 16, found 2.5"),
            ("samples", "-4", "1, 4, 8 or 16, found -4"),
            ("size", "[640]", "two whole numbers, width and height in pixels, found a list of 1"),
            ("size", "[-1, 5]", "two whole numbers, width and height in pixels, found a list of 2"),
            ("model", "7", "the path of a model file, found 7"),
            ("lights", "\"no\"", "true or false, found \"no\""),
            ("exposure", "65", "a number from -64 to 64 (stops), found 65"),
            ("env_intensity", "-1", "a number from 0 (a factor), found -1"),
            ("camera", "[1]", "a table, found a list of 1"),
            ("animation", "true", "the name of an animation or its number from 0, found true"),
        ] {
            let json = format!("{{\n\"note\": 1,\n\"{key}\": {value}}}");
            let toml = format!("note = 1\n\n{key} = {value}");
            for error in
                [Description::from_json(&json).unwrap_err(), Description::from_toml(&toml).unwrap_err()]
            {
                assert_eq!(error.to_string(), format!("line 3: {key}: expected {expected}"));
            }
        }
        let json = "{\"camera\": {\n\"eye\": [1, 2]}}";
        let error = Description::from_json(json).unwrap_err().to_string();
        assert_eq!(error, "line 2: camera.eye: expected a list of 3 numbers, x, y and z, found a list of 2");
        let toml = "[[light]]\ntype = 'spot'\nintensity = 'high'";
        let error = Description::from_toml(toml).unwrap_err().to_string();
        assert!(error.starts_with("line 3: light 0.intensity: expected a number from 0"), "{error}");
    }

    /// Other spellings mean the same, and a warning tells the right one.
    #[test]
    fn keys_are_read_in_every_spelling() {
        let right = "env_rotation_deg = 90\narea_lights = 'ltc'\n[camera]\nfov_y_deg = 20\n\
                     [[light]]\ntype = 'point'\nposition = [1, 2, 3]\nmin_roughness = 0.5\nintensity = 1\ncolor = 'ff0000'\n";
        let right_file = Description::from_toml(right).unwrap();
        assert_eq!((right_file.warnings.len(), right_file.lights_to_add.len()), (0, 1));
        for words in [
            ["envRotationDeg", "areaLights", "fovYDeg", "minRoughness"],
            ["env-rotation-deg", "area-lights", "fov-y-deg", "min-roughness"],
        ] {
            let mut text = right.to_owned();
            for (old, new) in
                ["env_rotation_deg", "area_lights", "fov_y_deg", "min_roughness"].iter().zip(words)
            {
                text = text.replace(old, new);
            }
            let mut file = Description::from_toml(&text).unwrap();
            let warnings: Vec<String> =
                std::mem::take(&mut file.warnings).iter().map(ToString::to_string).collect();
            assert_eq!(file, right_file);
            assert_eq!(warnings.len(), 4, "{warnings:?}");
            assert!(
                warnings.contains(&format!("line 4: camera.{}: the key is spelt fov_y_deg", words[2])),
                "{warnings:?}"
            );
        }
        let twice =
            Description::from_json(r#"{"env_intensity": 1, "envIntensity": 2}"#).unwrap_err().to_string();
        assert_eq!(twice, "line 1: envIntensity: the key is given twice");
        // What is read over may be as deep as it likes, and null is nothing.
        let note = format!("{{\"note\": {}{}, \"size\": null}}", "[".repeat(90_000), "]".repeat(90_000));
        assert_eq!(Description::from_json(&note).unwrap(), Description::default());
    }

    /// Defaults of quality and floor: the tier, and a shadow where the light of the environment can be blocked.
    #[test]
    fn defaults_of_quality_and_ground() {
        let options = |text: &str| {
            let description = Description::from_toml(text).unwrap();
            description.options(Machine::default(), &Limits::default()).unwrap().0
        };
        let plain = options("");
        assert_eq!(plain.visibility, Quality::default().visibility());
        assert_eq!((plain.ground, plain.ground_under), (Ground::Shadow, None));
        assert!(plain.ground_edge > 0.1);
        assert_eq!(plain, options("quality = 'fast'\nground = 'shadow'"));
        for text in ["quality = 'draft'", "maps = 0", "ground = 'none'"] {
            assert_eq!(options(text).ground, Ground::None, "{text}");
        }
        for text in ["quality = 'best'", "quality = 'draft'\nmaps = 16", "maps = 0\nground = 'shadow'"] {
            assert_eq!(options(text).ground, Ground::Shadow, "{text}");
        }
    }
}
