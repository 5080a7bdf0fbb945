//! Materials by texts that programs make: TOML or JSON, with pictures of the program's memory.

use super::{MaterialError, MaterialErrorReason, MaterialFile};
use crate::Context;
use overcoat_scene::Image;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pictures of a program's memory by the names under which a material refers to them, in place of files.
///
/// Texels are as those of files: sRGB in slots of colours, linear data in all others, alpha straight.
pub type GivenPictures = BTreeMap<String, Arc<Image>>;

impl MaterialFile {
    /// Reads a material from a text: the lines of a material file (TOML), a MaterialX document, or a JSON object with the same keys, which begins with a
    /// brace as no material file does. Textures are those of `given`, or else come from the context's resolver.
    ///
    /// # Errors
    /// [`MaterialError`] with the key, and of TOML the line.
    pub fn from_text(
        text: &str,
        given: &GivenPictures,
        context: &Context<'_>,
    ) -> Result<Self, MaterialError> {
        if !text.trim_start().starts_with('{') {
            return Self::with_pictures(text.as_bytes(), given, context);
        }
        let syntax = |message: String| MaterialError::whole(MaterialErrorReason::Syntax(message));
        let table: toml::Table = serde_json::from_str(text).map_err(|error| syntax(error.to_string()))?;
        let lines = toml::to_string(&table).map_err(|error| syntax(error.to_string()))?;
        // Lines are those of a text that nobody has seen.
        Self::with_pictures(lines.as_bytes(), given, context)
            .map_err(|error| MaterialError { line: None, ..error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoResolver;
    use overcoat_core::jobs::Jobs;
    use overcoat_core::limits::Limits;
    use overcoat_scene::{ColorSpace, Material, Scene};

    fn laid(text: &str, given: &GivenPictures) -> Result<Scene, String> {
        let (limits, jobs) = (Limits::default(), Jobs::new(1));
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
        let file = MaterialFile::from_text(text, given, &context).map_err(|e| e.to_string())?;
        let mut scene = Scene::new();
        scene.add_material(Material::default()).map_err(|e| e.to_string())?;
        file.assign(&mut scene, None, &limits).map_err(|e| e.to_string())?;
        Ok(scene)
    }

    #[test]
    fn json_says_what_toml_says() {
        let none = GivenPictures::default();
        let lines = "model = \"openpbr\"\ncoat = 0.5\nbase_color = [0.1, 0.2, 0.7]\nunlit = false\n[options]\nstacklit_newest = true";
        let json = r#" {"options": {"stacklit_newest": true}, "model": "openpbr", "coat": 0.5,
            "base_color": [0.1, 0.2, 0.7], "unlit": false}"#;
        let [lines, json] = [lines, json].map(|text| laid(text, &none).unwrap());
        assert_eq!(lines.materials(), json.materials());
        assert!(lines.materials()[0].model.is_some());
        let json = r#"{"model": "openpbr", "coat": 0.5, "anisotropy_rotation": 90}"#;
        let scene = laid(json, &none).unwrap();
        assert_eq!(scene.materials()[0].coat, 0.5);
        assert_eq!(scene.materials()[0].lobes.anisotropy.rotation, 90_f32.to_radians());
        assert!(laid(r#"{"cot": 0.5}"#, &none).unwrap_err().starts_with("unknown key 'cot'"));
        assert!(laid(r#"{"coat": 5}"#, &none).unwrap_err().starts_with("coat: 5 is out of range"));
        assert!(laid(r#"{"coat": null}"#, &none).is_err() && laid("{", &none).is_err());
    }

    #[test]
    fn pictures_are_given_in_place_of_files() {
        let image = Arc::new(Image::new(1, 1, vec![[10, 20, 30, 40]]).unwrap());
        let given = GivenPictures::from([("mine".to_owned(), Arc::clone(&image))]);
        let text = r#"{"base_color_texture": "mine", "normal_texture": {"file": "mine", "wrap": "clamp"}}"#;
        let scene = laid(text, &given).unwrap();
        let spaces: Vec<ColorSpace> = scene.textures().iter().map(|texture| texture.color_space()).collect();
        assert_eq!(spaces, [ColorSpace::Srgb, ColorSpace::Linear]);
        assert!(laid(text, &GivenPictures::default()).is_err());
    }
}
