//! Descriptions as scene files: the inverse of reading.

use super::Description;
use super::keys::{Key, SCENE};
use super::kind::{Kind, Material};
use super::light::LightDescription;
use super::materials::MaterialSource;
use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, SerializeMap, Serializer};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// As a scene file: `toml::to_string(&description)` or `serde_json::to_string`. Warnings are left out. What no scene file can
/// say is an error: paths that are no text, numbers that are not finite, a view with an up direction of its own,
/// [`more_materials`](Description::more_materials).
impl Serialize for Description {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.more_materials.is_empty() {
            return Err(S::Error::custom("more_materials have no place in a scene file"));
        }
        let entries = entries(SCENE, self).map_err(S::Error::custom)?;
        let mut map = serializer.serialize_map(Some(entries.len()))?;
        entries.iter().try_for_each(|(name, value)| map.serialize_entry(name, value))?;
        map.end()
    }
}

/// From any format that describes itself. Lines in messages are those of no file; [`Description::from_toml`] and
/// [`Description::from_json`] say them.
impl<'de> Deserialize<'de> for Description {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        Self::from_json(&value.to_string()).map_err(D::Error::custom)
    }
}

/// Keys and values of a table, in the order of the keys.
fn entries<T>(keys: &'static [Key<T>], target: &T) -> Result<Vec<(&'static str, Value)>, String> {
    let mut entries = Vec::new();
    for key in keys {
        let value = (key.get)(target).map_err(|reason| format!("{}: {reason}", key.name))?;
        entries.extend(value.map(|value| (key.name, value)));
    }
    Ok(entries)
}

/// A table; none if nothing is in it.
pub(super) fn table<T>(keys: &'static [Key<T>], target: &T) -> Result<Option<Value>, String> {
    let entries = entries(keys, target)?;
    let table: Map<String, Value> =
        entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    Ok((!table.is_empty()).then_some(Value::Object(table)))
}

/// The lights; none if there are none.
pub(super) fn lights(lights: &[LightDescription]) -> Result<Option<Value>, String> {
    let lights = lights
        .iter()
        .map(|light| Ok(light.write()?.unwrap_or_default()))
        .collect::<Result<Vec<_>, String>>()?;
    Ok((!lights.is_empty()).then_some(Value::Array(lights)))
}

/// Materials by name; none if there are none.
pub(super) fn materials(materials: &BTreeMap<String, MaterialSource>) -> Result<Option<Value>, String> {
    let of = |(name, source): (&String, &MaterialSource)| Ok((name.clone(), Material.write(source)?));
    let table = materials.iter().map(of).collect::<Result<Map<_, _>, String>>()?;
    Ok((!table.is_empty()).then_some(Value::Object(table)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ViewDirection;

    const EVERYTHING: &str = r##"
        model = "car.glb"
        up = "-z"
        env = "sky.hdr"
        env_rotation_deg = -33.3
        env_intensity = 0.1
        lights = false
        plate = 3
        animation = 2
        time = 0.25
        loop = true
        size = [64, 32]
        background = "#0a141e"
        tone_mapping = "aces"
        exposure = -1.5
        samples = 16
        shading_rate = 4
        shade_everywhere = true
        shading = "velvet"
        material = "x/y.toml"
        anisotropy = 3
        area_lights = "facets"
        quality = "good"
        maps = 32
        map_size = 64
        rays = 2
        specular_antialiasing = true
        ground = "#304050"
        ground_reflection = 0.25
        merge_angle_deg = 12.5
        edges = "boundary"
        edge_width = 2.0
        cavity = 0.5
        rim = 0.25
        line_width = 0.1
        point_size = 2.5
        aov_sample = "nearest"
        [materials]
        body = "velvet"
        [camera]
        eye = [1.1, 2, 3e6]
        target = [0, 0, 0.3]
        up = [0, 0, 1]
        fov_y_deg = 33.3
        near = 0.01
        far = 100
        ortho_height = 0
        view = "1,2,3.3"
        camera = "main"
        [[light]]
        type = "directional"
        direction = [0, -1, 0.1]
        color = "#ff8800"
        intensity = 2
        [[light]]
        type = "point"
        position = [0, 1, 0]
        range = 5.5
        min_roughness = 0.2
        intensity = 3
        [[light]]
        type = "spot"
        position = [0, 1, 0]
        target = [0, 0, 0]
        inner_cone_deg = 10
        outer_cone_deg = 20
        intensity = 4
        [[light]]
        type = "rect"
        position = [0, 1, 0]
        target = [0, 0, 0]
        up = [0, 0, 1]
        size = [1, 2]
        two_sided = true
        intensity = 5
        [[light]]
        type = "tube"
        from = [0, 1, 0]
        to = [0, 0, 0]
        radius = 0.1
        intensity = 6
    "##;

    #[test]
    fn what_is_written_is_what_was_read() {
        let plain =
            "env = 'none'\nbackground = 'env'\nexposure = 'auto'\nlights = true\n[camera]\nview = 'top'";
        for text in ["", plain, EVERYTHING] {
            let description = Description::from_toml(text).unwrap();
            let toml = toml::to_string(&description).unwrap();
            assert_eq!(Description::from_toml(&toml).unwrap(), description, "{toml}");
            assert_eq!(toml::from_str::<Description>(&toml).unwrap(), description, "{toml}");
            let json = serde_json::to_string(&description).unwrap();
            assert_eq!(Description::from_json(&json).unwrap(), description, "{json}");
            assert_eq!(serde_json::from_str::<Description>(&json).unwrap(), description, "{json}");
        }
        // Every key that means something is in the test.
        let read = Description::from_toml(EVERYTHING).unwrap();
        let written: Vec<&str> = entries(SCENE, &read).unwrap().iter().map(|(name, _)| *name).collect();
        let notes = ["name", "note", "peers", "ground_truth"];
        let known: Vec<&str> =
            SCENE.iter().map(|key| key.name).filter(|name| !notes.contains(name)).collect();
        assert_eq!(written, known);
        // Digits that nobody has written do not appear.
        assert!(toml::to_string(&read).unwrap().contains("line_width = 0.1\n"));
    }

    #[test]
    fn what_no_scene_file_can_say_is_an_error() {
        let mut description = Description { env_intensity: Some(f32::NAN), ..Description::default() };
        let error = serde_json::to_string(&description).unwrap_err().to_string();
        assert!(error.starts_with("env_intensity: "), "{error}");
        description = Description::default();
        description.camera.view = Some(ViewDirection { direction: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] });
        let error = toml::to_string(&description).unwrap_err().to_string();
        assert!(error.contains("camera: view: "), "{error}");
        let error = toml::from_str::<Description>("modle = 'x'").unwrap_err().to_string();
        assert!(error.contains("did you mean 'model'"), "{error}");
    }
}
