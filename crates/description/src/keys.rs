//! The keys of scene files: tables that say what each takes and where it goes.

use super::Description;
use super::camera::CameraDescription;
use super::light::LightDescription;
use super::materials::MaterialSource;
use super::schema;
use super::value::Value;
use super::write;
use overcoat_core::suggest::{nearest_name, same_name, suggestion};
use overcoat_load::Warning;
use std::collections::BTreeMap;

/// A key of a table of scene files.
pub(super) struct Key<T: 'static> {
    /// In lower case with `_` between words; other spellings are read with a warning.
    pub(super) name: &'static str,
    /// What it is for, in one line.
    pub(super) about: &'static str,
    /// Puts its value where it belongs, or says what was expected.
    pub(super) set: fn(&mut T, &Value<'_>) -> Result<(), String>,
    /// Its value as it is written, if there is one, or why it cannot be.
    pub(super) get: fn(&T) -> Result<Option<serde_json::Value>, String>,
    /// What it takes.
    pub(super) schema: fn() -> serde_json::Value,
}

/// A key whose value is an option of the target: name, place, how the value is read, what it is for. How it is read is a method
/// of [`Value`]; functions of [`write`] and [`schema`] have the same name.
macro_rules! key {
    ($name:literal, $target:ident . $($place:ident).+, $form:ident ($($argument:expr),*), $about:literal) => {
        Key {
            name: $name,
            about: $about,
            set: |$target, value| {
                $target.$($place).+ = Some(value.$form($($argument),*)?);
                Ok(())
            },
            get: |$target| $target.$($place).+.as_ref().map(write::$form).transpose(),
            schema: || schema::$form($($argument),*),
        }
    };
}
pub(super) use key;

/// A key that is read over.
macro_rules! note {
    ($name:literal, $about:literal) => {
        Key { name: $name, about: $about, set: |_, _| Ok(()), get: |_| Ok(None), schema: schema::anything }
    };
}

/// Keys of the file.
pub(super) static SCENE: &[Key<Description>] = &[
    key!("model", s.model, path("the path of a model file"), "The model file"),
    key!("up", s.up, axis(), "Which axis of the model file is up; what its format has if absent"),
    key!(
        "env",
        s.env,
        environment(),
        "Light from afar: studio, none or the path of an equirectangular picture"
    ),
    key!(
        "env_rotation_deg",
        s.env_rotation_degrees,
        number("degrees", f32::MIN, f32::MAX),
        "Turns the environment about +Y, in degrees, counter-clockwise seen from above"
    ),
    key!(
        "env_intensity",
        s.env_intensity,
        number("a factor", 0.0, f32::MAX),
        "Multiplies the environment's radiance"
    ),
    key!("lights", s.lights, switch(), "False leaves out the lights of the model file"),
    Key {
        name: "light",
        about: "Lights beside those of the model file",
        set: |s, v| {
            v.each("a list of lights", |v| {
                s.lights_to_add.push(LightDescription::read(v)?);
                Ok(())
            })
        },
        get: |s| write::lights(&s.lights_to_add),
        schema: || schema::list(LightDescription::schema()),
    },
    Key {
        name: "camera",
        about: "The camera. Without eye the model is framed automatically, seen along view",
        set: |s, v| v.table(CAMERA, &mut s.camera),
        get: |s| write::table(CAMERA, &s.camera),
        schema: || schema::table(CAMERA, &[]),
    },
    key!(
        "animation",
        s.animation,
        name_or_number("an animation"),
        "An animation of the model file, by name or number from 0"
    ),
    key!("time", s.time, seconds(), "Seconds in the animation"),
    key!("loop", s.repeat, switch(), "After its end the animation begins again"),
    key!("size", s.size, size(), "Width and height in pixels; one number makes a square"),
    key!(
        "background",
        s.background,
        background(),
        "What is behind the model: transparent, env, a colour name or #rrggbb"
    ),
    key!(
        "tone_mapping",
        s.tone_curve,
        tone_curve(),
        "Tone curve of 8-bit output; of a list of names the first counts"
    ),
    key!("exposure", s.exposure, exposure(), "Exposure of 8-bit output in stops, or auto"),
    key!("samples", s.samples, samples(), "Coverage samples a pixel"),
    key!(
        "quality",
        s.quality,
        quality(),
        "What a picture is worth: sets maps, map_size, rays and shading_rate; fast if absent"
    ),
    key!(
        "maps",
        s.maps,
        whole(0, 256),
        "Directions of the environment's light, each with a depth map; 0: nothing blocks it"
    ),
    key!("map_size", s.map_size, whole(32, 2048), "Texels along a side of a depth map"),
    key!(
        "rays",
        s.rays,
        whole(0, 256),
        "Rays that each lobe of a fragment sends for the light of other surfaces"
    ),
    key!(
        "shading_rate",
        s.shading_rate,
        shading_rate(),
        "Shadings a pixel where one would show; a picture has at least as many samples"
    ),
    key!(
        "shade_everywhere",
        s.shade_everywhere,
        switch(),
        "Every surface is shaded as often, and not only where one shading would show"
    ),
    key!(
        "ground",
        s.ground,
        ground(),
        "What is seen of a floor under the model: none, shadow, a colour name or #rrggbb; if absent shadow, without maps none"
    ),
    key!(
        "ground_reflection",
        s.ground_reflection,
        number("of 1", 0.0, 1.0),
        "How much of the model the floor mirrors; 0 if absent"
    ),
    key!(
        "shading",
        s.shading,
        shading(),
        "Shading model of every material; what each material names if absent"
    ),
    key!(
        "material",
        s.material,
        material(),
        "A material for every mesh: the path of a material file, or a built-in one"
    ),
    Key {
        name: "materials",
        about: "Materials by the names of those in the model that they take the place of",
        set: |s, v| v.materials(&mut s.materials),
        get: |s| write::materials(&s.materials),
        schema: schema::materials,
    },
    key!("anisotropy", s.anisotropy, whole(1, 16), "Largest anisotropy of texture filtering"),
    key!(
        "specular_antialiasing",
        s.specular_antialiasing,
        switch(),
        "Roughness grows where normals vary within a pixel; models of three.js always have their own way"
    ),
    key!(
        "area_lights",
        s.area_lights,
        area_lights(),
        "How reflections of rectangles and tubes are integrated"
    ),
    key!(
        "merge_angle_deg",
        s.merge_angle_degrees,
        number("degrees", 0.0, 45.0),
        "Triangles smaller than a pixel are shaded as one where their normals differ by less than this, in degrees"
    ),
    key!("line_width", s.line_width, number("pixels", 0.1, 64.0), "Width of lines in pixels"),
    key!("point_size", s.point_size, number("pixels", 0.1, 64.0), "Diameter of points in pixels"),
    note!("name", "A name, for readers"),
    note!("note", "A note, for readers"),
    note!("peers", "Pictures of other programs, for readers"),
    note!("ground_truth", "Pictures to compare with, for readers"),
];

/// Keys of the table `camera`.
static CAMERA: &[Key<CameraDescription>] = &[
    key!("eye", c.eye, position(), "Where the camera is, in metres"),
    key!(
        "target",
        c.target,
        position(),
        "What is in the centre of the picture, in metres; the middle of the model if absent"
    ),
    key!("up", c.up, vector(), "Which way is up in the picture; +Y if absent"),
    key!("fov_y_deg", c.fov_y_degrees, number("degrees", 0.1, 179.0), "Vertical field of view in degrees"),
    key!(
        "near",
        c.near,
        number("metres", 0.0, f32::MAX),
        "Nothing nearer than this distance in metres is drawn"
    ),
    key!(
        "ortho_height",
        c.orthographic_height,
        number("metres", 0.0, f32::MAX),
        "Parallel projection that shows this many metres from top to bottom; 0 fits the model"
    ),
    key!(
        "view",
        c.view,
        view(),
        "Where an automatic camera stands: a name, or x,y,z from the model towards it"
    ),
    key!(
        "camera",
        c.from_model,
        name_or_number("a camera"),
        "A camera of the model file, by name or number from 0"
    ),
    // There is no far limit; the key is read for the sake of other programs' files.
    note!("far", "Read over: there is no far limit"),
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
            let source = self.within(&name, node).material()?;
            materials.insert(name.into_owned(), source);
        }
        Ok(())
    }
}
