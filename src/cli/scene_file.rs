//! Scene files: a whole picture in one file, JSON or TOML with the same keys.
//!
//! ```toml
//! model = "car.glb"
//! env = "studio"
//! size = [640, 480]
//! camera = { eye = [4, 2, 6], target = [0, 0.5, 0], fovYDeg = 30 }
//! ```
//!
//! Every key is optional. The command line's options are laid over the same structure, so that a picture has one
//! description whichever way it was asked for.

use super::failure::Failure;
use super::materials::{MaterialChoice, MaterialSource};
use super::scene_light::SceneLight;
use super::scene_values;
use super::values::{BackgroundChoice, ViewDirection};
use crate::color::ToneCurve;
use crate::load::AnimationChoice;
use crate::render::{AreaLightMethod, ShadingModel};
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes of a scene file at most: it holds names and numbers only.
const MAX_BYTES: u64 = 1 << 20;

/// What a picture shows and how. A key that is absent leaves the choice to the command line or to the default.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct SceneFile {
    /// The model file.
    pub model: Option<PathBuf>,
    /// Where the light from afar comes from: `studio`, `none` or the path of an equirectangular picture.
    #[serde(deserialize_with = "scene_values::environment")]
    pub env: Option<EnvironmentChoice>,
    /// Turns the environment about +Y, in degrees, counter-clockwise seen from above.
    #[serde(rename = "envRotationDeg")]
    pub env_rotation_degrees: Option<f32>,
    /// Multiplies the environment's radiance.
    #[serde(rename = "envIntensity")]
    pub env_intensity: Option<f32>,
    /// False leaves out the lights of the model file.
    pub lights: Option<bool>,
    /// Lights beside those of the model file.
    #[serde(rename = "light")]
    pub lights_to_add: Vec<SceneLight>,
    /// The camera.
    pub camera: SceneCamera,
    /// An animation of the model file, by its name or number.
    #[serde(deserialize_with = "scene_values::name_or_number")]
    pub animation: Option<String>,
    /// Seconds in the animation.
    pub time: Option<f64>,
    /// After its end the animation begins again.
    #[serde(rename = "loop")]
    pub repeat: Option<bool>,
    /// Width and height in pixels.
    pub size: Option<[u64; 2]>,
    /// `transparent`, `env`, a colour name or `#rrggbb`.
    #[serde(deserialize_with = "scene_values::background")]
    pub background: Option<BackgroundChoice>,
    /// Tone curve of 8-bit output: one name or a list of names, of which the first counts.
    #[serde(rename = "toneMapping", deserialize_with = "scene_values::tone_mapping")]
    pub tone_curve: Option<ToneCurve>,
    /// Exposure of 8-bit output in stops: the picture is multiplied by 2 to this power before the tone curve.
    pub exposure: Option<f32>,
    /// Coverage samples a pixel: 1, 4, 8 or 16.
    #[serde(deserialize_with = "scene_values::samples")]
    pub samples: Option<u32>,
    /// Shading model by name.
    #[serde(deserialize_with = "scene_values::shading")]
    pub shading: Option<ShadingModel>,
    /// A material for every mesh: the path of a material file, or the name of a built-in one.
    #[serde(deserialize_with = "scene_values::material")]
    pub material: Option<MaterialSource>,
    /// Materials by the names of those in the model that they take the place of.
    #[serde(deserialize_with = "scene_values::materials")]
    pub materials: BTreeMap<String, MaterialSource>,
    /// Laid over these, in this order; not part of the file.
    #[serde(skip)]
    pub more_materials: Vec<MaterialChoice>,
    /// Largest anisotropy of texture filtering, 1 to 16.
    pub anisotropy: Option<u32>,
    /// How reflections of rectangles and tubes are integrated: `ltc` or `facets`.
    #[serde(rename = "areaLights", deserialize_with = "scene_values::area_lights")]
    pub area_lights: Option<AreaLightMethod>,
    /// Triangles smaller than a pixel are shaded as one where their normals differ by less than this, 0 to 45 degrees.
    #[serde(rename = "mergeAngleDeg")]
    pub merge_angle_degrees: Option<f32>,
    /// Width of lines in pixels, 0.1 to 64.
    #[serde(rename = "lineWidth")]
    pub line_width: Option<f32>,
    /// Size of points in pixels, 0.1 to 64.
    #[serde(rename = "pointSize")]
    pub point_size: Option<f32>,

    /// Descriptive; changes nothing.
    pub name: Option<Ignored>,
    /// Descriptive; changes nothing.
    pub note: Option<Ignored>,
    /// Descriptive; changes nothing.
    pub peers: Option<Ignored>,
    /// Descriptive; changes nothing.
    #[serde(rename = "groundTruth")]
    pub ground_truth: Option<Ignored>,
}

/// The camera of a [`SceneFile`]. Without `eye` the model is framed automatically, seen along `view`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct SceneCamera {
    /// World-space position in metres.
    pub eye: Option<[f32; 3]>,
    /// World-space point in the centre of the picture. The middle of the model if absent.
    pub target: Option<[f32; 3]>,
    /// Which way is up. +Y if absent.
    pub up: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    #[serde(rename = "fovYDeg")]
    pub fov_y_degrees: Option<f32>,
    /// Nothing nearer than this distance in metres is drawn.
    pub near: Option<f32>,
    /// Parallel projection that shows this many metres from top to bottom; 0 fits the model.
    #[serde(rename = "orthoHeight")]
    pub orthographic_height: Option<f32>,
    /// Where an automatic camera stands: a name such as `front`, or `x,y,z`.
    #[serde(deserialize_with = "scene_values::view")]
    pub view: Option<ViewDirection>,
    /// A camera of the model file, by its name or number.
    #[serde(rename = "camera", deserialize_with = "scene_values::name_or_number")]
    pub from_model: Option<String>,

    /// There is no far limit; the key is read for the sake of other programs' files.
    pub far: Option<Ignored>,
}

/// What `--env` and a scene file's `env` say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EnvironmentChoice {
    /// The built-in studio.
    Studio,
    /// Darkness.
    None,
    /// An equirectangular picture.
    File(PathBuf),
}

impl EnvironmentChoice {
    /// `studio`, `none` or a path.
    #[must_use]
    pub fn new(text: &str) -> Self {
        match text {
            "studio" => Self::Studio,
            "none" => Self::None,
            path => Self::File(PathBuf::from(path)),
        }
    }
}

/// A value that is read over. Equal to every other, so that files which differ in their notes describe the same
/// picture.
#[derive(Clone, Copy, Debug)]
pub struct Ignored;

impl<'de> Deserialize<'de> for Ignored {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(deserializer).map(|_| Self)
    }
}

impl PartialEq for Ignored {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl SceneFile {
    /// Reads a scene file. TOML if its name ends in `.toml`, JSON otherwise. Relative paths in it are taken to be
    /// relative to its folder, and may lead anywhere: who names a scene file trusts it.
    ///
    /// # Errors
    /// [`Failure`] naming the file, and the key that is wrong.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let text = read_text(path).map_err(|failure| failure.at(path))?;
        let is_toml = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let parsed = if is_toml { Self::from_toml(&text) } else { Self::from_json(&text) };
        let mut scene = parsed.map_err(|failure| failure.at(path))?;
        scene.resolve_paths(path.parent().unwrap_or(Path::new("")));
        Ok(scene)
    }

    /// Parses JSON.
    ///
    /// # Errors
    /// [`Failure`] with the key or the place that is wrong.
    pub fn from_json(text: &str) -> Result<Self, Failure> {
        serde_json::from_str(text).map_err(Failure::failed)
    }

    /// Parses TOML.
    ///
    /// # Errors
    /// [`Failure`] with the key or the place that is wrong.
    pub fn from_toml(text: &str) -> Result<Self, Failure> {
        toml::from_str(text).map_err(|e| {
            let line = e.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            match line {
                Some(line) => Failure::failed(format!("{} at line {line}", e.message())),
                None => Failure::failed(e.message()),
            }
        })
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
    /// [`Failure`] if there is a time and no animation, or a time that is none.
    pub fn animation_choice(&self) -> Result<Option<AnimationChoice>, Failure> {
        let time = self.time.unwrap_or(0.0);
        if !(time.is_finite() && time >= 0.0) {
            return Err(Failure::usage(format!("time {time}: expected seconds, at least 0")));
        }
        match &self.animation {
            Some(name) => {
                let repeat = self.repeat.unwrap_or(false);
                Ok(Some(AnimationChoice { name: name.clone(), time, repeat }))
            }
            None if self.time.is_some() || self.repeat == Some(true) => {
                Err(Failure::usage("a time without an animation: --animation names one"))
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
fn read_text(path: &Path) -> Result<String, Failure> {
    use std::io::Read;
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|e| Failure::failed(format!("cannot be read: {e}")))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Failure::failed("too large for a scene file"));
    }
    String::from_utf8(bytes).map_err(|_| Failure::failed("not a text file"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::values;

    #[test]
    fn materials_are_files_beside_it_or_built_in() {
        let text = r#"{"material": "paint.toml", "materials": {"body": "candy-red", "a": "x/y.toml"}}"#;
        let mut scene = SceneFile::from_json(text).unwrap();
        let toml = "material = 'paint.toml'\n[materials]\nbody = 'candy-red'\na = 'x/y.toml'\n";
        assert_eq!(SceneFile::from_toml(toml).unwrap(), scene);
        scene.resolve_paths(Path::new("f"));
        scene.more_materials.push(values::material("body=velvet").unwrap());
        let choices: Vec<String> = scene.material_choices().map(|c| format!("{:?}", c)).collect();
        let expected = [
            (None, MaterialSource::File("f/paint.toml".into())),
            (Some("a"), MaterialSource::File("f/x/y.toml".into())),
            (Some("body"), MaterialSource::Builtin("candy-red")),
            (Some("body"), MaterialSource::Builtin("velvet")),
        ]
        .map(|(name, source)| format!("{:?}", MaterialChoice { name: name.map(str::to_owned), source }));
        assert_eq!(choices, expected);
        let failure = SceneFile::from_json(r#"{"material": "candy-rad"}"#).unwrap_err().to_string();
        assert!(failure.contains("did you mean 'candy-red'"), "{failure}");
    }

    const JSON: &str = r##"{
        "name": "x", "note": "why", "peers": ["a"], "groundTruth": {"p": "c.exr"},
        "model": "../m/car.glb", "env": "sky.hdr", "envRotationDeg": 90, "envIntensity": 0.5,
        "camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fovYDeg": 30, "near": 0.01, "far": 1000},
        "size": [512, 256], "background": "#102030", "toneMapping": ["linear", "neutral", "aces"],
        "samples": 16, "shading": "urp-mobile", "exposure": -1
    }"##;

    #[test]
    fn a_time_belongs_to_an_animation() {
        let choice = |text: &str| SceneFile::from_toml(text).unwrap().animation_choice();
        assert_eq!(choice("").unwrap(), None);
        let walk = AnimationChoice { name: "Walk".to_owned(), time: 0.5, repeat: true };
        assert_eq!(choice("animation = 'Walk'\ntime = 0.5\nloop = true").unwrap(), Some(walk));
        let first = AnimationChoice { name: "0".to_owned(), ..AnimationChoice::default() };
        assert_eq!(choice("animation = 0").unwrap(), Some(first));
        for bad in ["time = 1.0", "loop = true", "animation = 0\ntime = nan", "animation = 0\ntime = -1.0"] {
            assert_eq!(choice(bad).unwrap_err().exit_code(), 2, "{bad}");
        }
    }

    #[test]
    fn json_and_toml_mean_the_same() {
        let toml = r##"
            name = "x"
            model = "../m/car.glb"
            env = "sky.hdr"
            envRotationDeg = 90
            envIntensity = 0.5
            size = [512, 256]
            background = "#102030"
            toneMapping = "none"
            samples = 16
            shading = "urp-mobile"
            exposure = -1
            [camera]
            eye = [1, 2, 3]
            target = [0, 0, 0]
            up = [0, 1, 0]
            fovYDeg = 30
            near = 0.01
        "##;
        let mut json = SceneFile::from_json(JSON).unwrap();
        let mut toml = SceneFile::from_toml(toml).unwrap();
        for scene in [&mut json, &mut toml] {
            scene.note = None;
            scene.peers = None;
            scene.ground_truth = None;
            scene.camera.far = None;
        }
        assert_eq!(json, toml);
        assert_eq!(json.camera.eye, Some([1.0, 2.0, 3.0]));
        assert_eq!(json.background, Some(BackgroundChoice::Color([16, 32, 48])));
        assert_eq!(json.tone_curve, Some(ToneCurve::None));
    }

    #[test]
    fn paths_are_relative_to_the_scene_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.json");
        std::fs::write(&path, JSON).unwrap();
        let scene = SceneFile::open(&path).unwrap();
        assert_eq!(scene.model, Some(folder.path().join("../m/car.glb")));
        assert_eq!(scene.env, Some(EnvironmentChoice::File(folder.path().join("sky.hdr"))));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, name) in [
            (r#"{"modle": "x"}"#, "modle"),
            (r#"{"camera": {"fov": 3}}"#, "fov"),
            (r#"{"background": "whitish"}"#, "whitish"),
            (r#"{"toneMapping": ["linear", "filmic"]}"#, "filmic"),
            (r#"{"toneMapping": 3}"#, "toneMapping"),
            (r#"{"samples": 5}"#, "samples"),
            (r#"{"shading": "phong"}"#, "phong"),
            (r#"{"size": [1, 2], "size": [1, 2]}"#, "size"),
            (r#"{"size""#, "line 1"),
        ] {
            let failure = SceneFile::from_json(text).unwrap_err();
            assert!(failure.to_string().contains(name), "{text}: {failure}");
        }
        let failure = SceneFile::from_toml("size = [1, 2]\nmodle = 'x'\n").unwrap_err().to_string();
        assert!(failure.contains("modle") && failure.contains("line 2"), "{failure}");
    }
}
