//! The keys of scene files: tables that say what each takes and where it goes.

use super::Description;
use super::camera::CameraDescription;
use super::environment::EnvironmentChoice;
use super::light::LightDescription;
use super::materials::MaterialSource;
use super::spelling;
use super::value::Value;
use crate::load::{Warning, nearest_name, same_name, suggestion};
use std::collections::BTreeMap;

/// A key of a table of scene files.
pub(super) struct Key<T: 'static> {
    /// In lower case with `_` between words; other spellings are read with a warning.
    pub(super) name: &'static str,
    /// Puts its value where it belongs, or says what was expected.
    pub(super) set: fn(&mut T, &Value<'_>) -> Result<(), String>,
}

/// A key whose value is an option of the target: name, place, how the value is read.
macro_rules! key {
    ($name:literal, $target:ident . $($place:ident).+, $value:ident => $read:expr) => {
        Key {
            name: $name,
            set: |$target, $value| {
                $target.$($place).+ = Some($read?);
                Ok(())
            },
        }
    };
}
pub(super) use key;

/// A key that is read over.
macro_rules! note {
    ($name:literal) => {
        Key { name: $name, set: |_, _| Ok(()) }
    };
}

/// Keys of the file.
pub(super) static SCENE: &[Key<Description>] = &[
    key!("model", s.model, v => v.path("the path of a model file")),
    key!("up", s.up, v => v.axis()),
    key!("env", s.env, v => v.text("studio, none or the path of a picture").map(|t| EnvironmentChoice::new(&t))),
    key!("env_rotation_deg", s.env_rotation_degrees, v => v.number("degrees", f32::MIN, f32::MAX)),
    key!("env_intensity", s.env_intensity, v => v.number("a factor", 0.0, f32::MAX)),
    key!("lights", s.lights, v => v.switch()),
    Key {
        name: "light",
        set: |s, v| {
            v.each("a list of lights", |v| {
                s.lights_to_add.push(LightDescription::read(v)?);
                Ok(())
            })
        },
    },
    Key { name: "camera", set: |s, v| v.table(CAMERA, &mut s.camera) },
    key!("animation", s.animation, v => v.name_or_number("an animation")),
    key!("time", s.time, v => v.seconds()),
    key!("loop", s.repeat, v => v.switch()),
    key!("size", s.size, v => v.size()),
    key!("background", s.background, v => v.parsed("a colour, transparent or env", spelling::background)),
    key!("tone_mapping", s.tone_curve, v => v.tone_curve()),
    key!("exposure", s.exposure, v => v.exposure()),
    key!("samples", s.samples, v => v.samples()),
    key!("shading", s.shading, v => v.parsed("the name of a shading model", spelling::shading)),
    key!("material", s.material, v => v.parsed("a material", MaterialSource::new)),
    Key { name: "materials", set: |s, v| v.materials(&mut s.materials) },
    key!("anisotropy", s.anisotropy, v => v.whole(1, 16)),
    key!("area_lights", s.area_lights, v => v.parsed("ltc or facets", spelling::area_lights)),
    key!("merge_angle_deg", s.merge_angle_degrees, v => v.number("degrees", 0.0, 45.0)),
    key!("line_width", s.line_width, v => v.number("pixels", 0.1, 64.0)),
    key!("point_size", s.point_size, v => v.number("pixels", 0.1, 64.0)),
    // Descriptive.
    note!("name"),
    note!("note"),
    note!("peers"),
    note!("ground_truth"),
];

/// Keys of the table `camera`.
static CAMERA: &[Key<CameraDescription>] = &[
    key!("eye", c.eye, v => v.doubles("x, y and z")),
    key!("target", c.target, v => v.doubles("x, y and z")),
    key!("up", c.up, v => v.numbers("x, y and z")),
    key!("fov_y_deg", c.fov_y_degrees, v => v.number("degrees", 0.1, 179.0)),
    key!("near", c.near, v => v.number("metres", 0.0, f32::MAX)),
    key!("ortho_height", c.orthographic_height, v => v.number("metres", 0.0, f32::MAX)),
    key!("view", c.view, v => v.parsed("a view", spelling::view)),
    key!("camera", c.from_model, v => v.name_or_number("a camera")),
    // There is no far limit; the key is read for the sake of other programs' files.
    note!("far"),
];

impl Value<'_> {
    /// Reads a table by its keys.
    pub(super) fn table<T>(&self, keys: &'static [Key<T>], target: &mut T) -> Result<(), String> {
        let entries = self.node.table().ok_or_else(|| self.expected("a table"))?;
        let names = || keys.iter().map(|key| key.name);
        let mut given: Vec<&str> = Vec::new();
        for (written, node) in entries {
            let mut value = self.within(&written, node);
            let key = keys.iter().find(|key| key.name == written).or_else(|| {
                let name = same_name(&written, names())?;
                keys.iter().find(|key| key.name == name)
            });
            let Some(key) = key else {
                let hint = match nearest_name(&written, names()) {
                    Some(name) => suggestion(Some(name)),
                    None => format!("; known are {}", names().collect::<Vec<_>>().join(", ")),
                };
                return Err(value.message(format_args!("there is no such key{hint}")));
            };
            if given.contains(&key.name) {
                return Err(value.message("the key is given twice"));
            }
            given.push(key.name);
            if key.name != written {
                let message = value.message(format_args!("the key is spelt {}", key.name));
                self.warnings.borrow_mut().push(Warning::new(message));
                value = self.within(key.name, node);
            }
            if !node.is_null() {
                (key.set)(target, &value)?;
            }
        }
        Ok(())
    }

    /// Materials by the names of those of the model.
    fn materials(&self, materials: &mut BTreeMap<String, MaterialSource>) -> Result<(), String> {
        for (name, node) in self.node.table().ok_or_else(|| self.expected("a table of materials"))? {
            let source = self.within(&name, node).parsed("a material", MaterialSource::new)?;
            materials.insert(name.into_owned(), source);
        }
        Ok(())
    }
}
