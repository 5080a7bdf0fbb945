//! Lights of scene files: `[[light]]` in TOML, `"light": [..]` in JSON.

use super::Description;
use super::error::DescriptionError;
use super::keys::{Key, key};
use super::kind::{Extent, Kind, LinearColor, Number, Switch, Text, Vector};
use super::schema;
use super::value::Value;
use super::write;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_load::Warning;
use overcoat_scene::{Environment, EnvironmentSource, Light, LightKind, Scene};

/// A light of a scene file. They are added to those of the model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LightDescription {
    /// Infinitely far away.
    Directional {
        /// In which the light travels; any length but zero.
        direction: [f32; 3],
        /// Linear.
        color: Option<[f32; 3]>,
        /// Lux on a surface that faces it.
        intensity: f32,
        /// Least roughness (alpha, 0 to 1) of what it shines on, where a material honours it; 0 if absent.
        min_roughness: Option<f32>,
    },
    /// A point.
    Point {
        /// Metres.
        position: [f32; 3],
        /// Metres to where it has faded out.
        range: Option<f32>,
        /// Linear.
        color: Option<[f32; 3]>,
        /// Candela.
        intensity: f32,
        /// Least roughness (alpha, 0 to 1) of what it shines on, where a material honours it; 0 if absent.
        min_roughness: Option<f32>,
    },
    /// A cone.
    Spot {
        /// Metres.
        position: [f32; 3],
        /// Point on its axis, in metres.
        target: [f32; 3],
        /// Metres to where it has faded out.
        range: Option<f32>,
        /// Half angle inside which it is full, in degrees; 0 if absent.
        inner_cone_deg: Option<f32>,
        /// Half angle outside which it is dark, in degrees; 45 if absent.
        outer_cone_deg: Option<f32>,
        /// Linear.
        color: Option<[f32; 3]>,
        /// Candela on its axis.
        intensity: f32,
        /// Least roughness (alpha, 0 to 1) of what it shines on, where a material honours it; 0 if absent.
        min_roughness: Option<f32>,
    },
    /// A rectangle.
    Rect {
        /// Centre in metres.
        position: [f32; 3],
        /// Point that its front faces, in metres.
        target: [f32; 3],
        /// Which way is up on it; +Y if absent.
        up: Option<[f32; 3]>,
        /// Width and height in metres.
        size: [f32; 2],
        /// Shines from its back as well.
        two_sided: Option<bool>,
        /// Linear.
        color: Option<[f32; 3]>,
        /// Candela per square metre.
        intensity: f32,
    },
    /// A tube.
    Tube {
        /// One end of its axis, in metres.
        from: [f32; 3],
        /// The other end.
        to: [f32; 3],
        /// Metres.
        radius: f32,
        /// Linear.
        color: Option<[f32; 3]>,
        /// Candela per square metre.
        intensity: f32,
    },
}

/// Properties of any kind of light, read before its kind is known.
#[derive(Debug, Default)]
struct Given {
    kind: Option<String>,
    position: Option<[f32; 3]>,
    target: Option<[f32; 3]>,
    direction: Option<[f32; 3]>,
    up: Option<[f32; 3]>,
    from: Option<[f32; 3]>,
    to: Option<[f32; 3]>,
    size: Option<[f32; 2]>,
    radius: Option<f32>,
    range: Option<f32>,
    inner_cone_deg: Option<f32>,
    outer_cone_deg: Option<f32>,
    two_sided: Option<bool>,
    color: Option<[f32; 3]>,
    intensity: Option<f32>,
    min_roughness: Option<f32>,
}

/// Keys of the tables `light`.
static KEYS: &[Key<Given>] = &[
    key!(Given, "type", g.kind, Text("the name of a kind of light"), "What kind of light it is"),
    key!(Given, "position", g.position, Vector, "Where it is, of a rectangle its centre, in metres"),
    key!(Given, "target", g.target, Vector, "What it points at, or its front faces, in metres"),
    key!(Given, "direction", g.direction, Vector, "In which the light travels; any length but zero"),
    key!(Given, "up", g.up, Vector, "Which way is up on it").default("+Y"),
    key!(Given, "from", g.from, Vector, "One end of its axis, in metres"),
    key!(Given, "to", g.to, Vector, "The other end of its axis, in metres"),
    key!(Given, "size", g.size, Extent, "Width and height in metres"),
    key!(Given, "radius", g.radius, Number::positive("metres"), "Metres"),
    key!(Given, "range", g.range, Number::positive("metres"), "Metres to where it has faded out"),
    key!(
        Given,
        "inner_cone_deg",
        g.inner_cone_deg,
        Number::within("degrees", 0.0, 90.0),
        "Half angle inside which it is full, in degrees"
    )
    .default("0"),
    key!(
        Given,
        "outer_cone_deg",
        g.outer_cone_deg,
        Number::within("degrees", 0.0, 90.0),
        "Half angle outside which it is dark, in degrees"
    )
    .default("45"),
    key!(Given, "two_sided", g.two_sided, Switch, "Shines from its back as well"),
    key!(Given, "color", g.color, LinearColor, "Linear red, green and blue, or an sRGB colour #rrggbb")
        .default("white"),
    key!(
        Given,
        "intensity",
        g.intensity,
        Number::positive("candela, lux or candela per square metre"),
        "Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes"
    ),
    key!(
        Given,
        "min_roughness",
        g.min_roughness,
        Number::within("alpha", 0.0, 1.0),
        "Least roughness (alpha) of what it shines on, where a material honours it"
    )
    .default("0"),
];

/// Keys of every kind of light.
const COMMON: [&str; 3] = ["type", "color", "intensity"];

/// Kinds of light with the keys that they have beside `type`, `color` and `intensity`; those with `!` must be there.
const KINDS: [(&str, &[&str]); 5] = [
    ("directional", &["direction!", "min_roughness"]),
    ("point", &["position!", "range", "min_roughness"]),
    ("spot", &["position!", "target!", "range", "inner_cone_deg", "outer_cone_deg", "min_roughness"]),
    ("rect", &["position!", "target!", "up", "size!", "two_sided"]),
    ("tube", &["from!", "to!", "radius!"]),
];

impl Given {
    /// Properties of a light.
    fn of(light: &LightDescription) -> Self {
        let none = Self::default();
        match light.clone() {
            LightDescription::Directional { direction, color, intensity, min_roughness } => Self {
                kind: Some("directional".to_owned()),
                direction: Some(direction),
                color,
                intensity: Some(intensity),
                min_roughness,
                ..none
            },
            LightDescription::Point { position, range, color, intensity, min_roughness } => Self {
                kind: Some("point".to_owned()),
                position: Some(position),
                range,
                color,
                intensity: Some(intensity),
                min_roughness,
                ..none
            },
            LightDescription::Spot {
                position,
                target,
                range,
                inner_cone_deg,
                outer_cone_deg,
                color,
                intensity,
                min_roughness,
            } => Self {
                kind: Some("spot".to_owned()),
                position: Some(position),
                target: Some(target),
                range,
                inner_cone_deg,
                outer_cone_deg,
                color,
                intensity: Some(intensity),
                min_roughness,
                ..none
            },
            LightDescription::Rect { position, target, up, size, two_sided, color, intensity } => Self {
                kind: Some("rect".to_owned()),
                position: Some(position),
                target: Some(target),
                up,
                size: Some(size),
                two_sided,
                color,
                intensity: Some(intensity),
                ..none
            },
            LightDescription::Tube { from, to, radius, color, intensity } => Self {
                kind: Some("tube".to_owned()),
                from: Some(from),
                to: Some(to),
                radius: Some(radius),
                color,
                intensity: Some(intensity),
                ..none
            },
        }
    }
}

/// Cosine of a spot's half angle in degrees.
///
/// # Errors
/// A sentence, of an angle that is not 0 to 90.
pub fn cone_cosine(degrees: f32) -> Result<f32, String> {
    if (0.0..=90.0).contains(&degrees) {
        Ok(overcoat_core::math::scalar::cos(degrees.to_radians()))
    } else {
        Err(format!("a cone of {degrees} degrees is not 0 to 90"))
    }
}

impl LightDescription {
    /// As a table of a scene file.
    pub(super) fn write(&self) -> Result<Option<serde_json::Value>, String> {
        write::table(KEYS, &Given::of(self))
    }

    /// JSON schema of a light.
    pub(super) fn schema() -> serde_json::Value {
        let kinds: Vec<serde_json::Value> = KINDS
            .iter()
            .map(|(kind, own)| {
                let is_own = |name: &str| own.iter().any(|key| key.trim_end_matches('!') == name);
                let properties: serde_json::Map<String, serde_json::Value> = KEYS
                    .iter()
                    .filter(|key| COMMON.contains(&key.name) || is_own(key.name))
                    .map(|key| (key.name.to_owned(), schema::property(key)))
                    .collect();
                let needed = own.iter().filter_map(|key| key.strip_suffix('!'));
                let needed: Vec<&str> = ["type", "intensity"].into_iter().chain(needed).collect();
                let mut kind_of_light = serde_json::json!({
                    "type": "object",
                    "properties": properties,
                    "required": needed,
                    "additionalProperties": false,
                });
                kind_of_light["properties"]["type"]["const"] = serde_json::json!(kind);
                kind_of_light
            })
            .collect();
        serde_json::json!({"anyOf": kinds})
    }

    /// Reads one.
    pub(super) fn read(value: &Value<'_>) -> Result<Self, String> {
        let mut g = Given::default();
        value.table(KEYS, &mut g)?;
        let kinds = || KINDS.iter().map(|(kind, _)| *kind);
        let listed = || kinds().collect::<Vec<_>>().join(", ");
        let name = g.kind.as_deref().unwrap_or_default();
        let Some((kind, own)) = KINDS.iter().find(|(kind, _)| *kind == name) else {
            return Err(value.message(match g.kind.as_deref() {
                None => format!("it needs a type: {}", listed()),
                Some(name) => {
                    let hint = suggestion(nearest_name(name, kinds()));
                    format!("'{name}' is no type of light; known are {}{hint}", listed())
                }
            }));
        };
        let present = [
            ("position", g.position.is_some()),
            ("target", g.target.is_some()),
            ("direction", g.direction.is_some()),
            ("up", g.up.is_some()),
            ("from", g.from.is_some()),
            ("to", g.to.is_some()),
            ("size", g.size.is_some()),
            ("radius", g.radius.is_some()),
            ("range", g.range.is_some()),
            ("inner_cone_deg", g.inner_cone_deg.is_some()),
            ("outer_cone_deg", g.outer_cone_deg.is_some()),
            ("two_sided", g.two_sided.is_some()),
            ("min_roughness", g.min_roughness.is_some()),
        ];
        for (name, is_there) in present {
            let wanted = own.iter().find(|key| key.trim_end_matches('!') == name);
            match wanted {
                None if is_there => {
                    let names: Vec<&str> = own.iter().map(|key| key.trim_end_matches('!')).collect();
                    let names = names.join(", ");
                    return Err(value.message(format_args!(
                        "a {kind} light has no {name}; it has {names}, color and intensity"
                    )));
                }
                Some(key) if key.ends_with('!') && !is_there => {
                    return Err(value.message(format_args!("a {kind} light needs the key {name}")));
                }
                _ => {}
            }
        }
        let Some(intensity) = g.intensity else {
            return Err(value.message(format_args!("a {kind} light needs the key intensity")));
        };
        // What a kind needs is there.
        let Given { range, up, two_sided, color, min_roughness, inner_cone_deg, outer_cone_deg, .. } = g;
        let point = |p: Option<[f32; 3]>| p.unwrap_or_default();
        let (position, target) = (point(g.position), point(g.target));
        Ok(match *kind {
            "directional" => {
                Self::Directional { direction: point(g.direction), color, intensity, min_roughness }
            }
            "point" => Self::Point { position, range, color, intensity, min_roughness },
            "spot" => Self::Spot {
                position,
                target,
                range,
                inner_cone_deg,
                outer_cone_deg,
                color,
                intensity,
                min_roughness,
            },
            "rect" => {
                let size = g.size.unwrap_or_default();
                Self::Rect { position, target, up, size, two_sided, color, intensity }
            }
            _ => {
                let radius = g.radius.unwrap_or_default();
                Self::Tube { from: point(g.from), to: point(g.to), radius, color, intensity }
            }
        })
    }

    /// Adds it to a scene.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the light by its number and what is wrong with it.
    pub fn add_to(&self, scene: &mut Scene, number: usize) -> Result<(), DescriptionError> {
        let wrong = |reason: &str| DescriptionError::invalid(format!("light {number}: {reason}"));
        scene
            .add_light(self.light(scene).map_err(|reason| wrong(&reason))?)
            .map_err(|e| wrong(&e.to_string()))
    }

    fn light(&self, scene: &Scene) -> Result<Light, String> {
        let near = |p: [f32; 3]| scene.position_of(p.map(f64::from));
        let (kind, color, intensity, minimum_roughness) = match *self {
            Self::Directional { direction, color, intensity, min_roughness } => {
                let direction = unit(direction).ok_or("its direction has no length")?;
                (LightKind::Directional { direction }, color, intensity, min_roughness)
            }
            Self::Point { position, range, color, intensity, min_roughness } => {
                (LightKind::Point { position: near(position), range }, color, intensity, min_roughness)
            }
            Self::Spot {
                position,
                target,
                range,
                inner_cone_deg,
                outer_cone_deg,
                color,
                intensity,
                min_roughness,
            } => {
                let (position, target) = (near(position), near(target));
                let direction = unit(difference(target, position)).ok_or("its target is where it is")?;
                let inner_cone_cosine = cone_cosine(inner_cone_deg.unwrap_or(0.0))?;
                let outer_cone_cosine = cone_cosine(outer_cone_deg.unwrap_or(45.0))?;
                if outer_cone_cosine > inner_cone_cosine {
                    return Err("its inner cone is wider than its outer cone".to_owned());
                }
                (
                    LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine },
                    color,
                    intensity,
                    min_roughness,
                )
            }
            Self::Rect { position, target, up, size, two_sided, color, intensity } => {
                let (position, target) = (near(position), near(target));
                let front = unit(difference(target, position)).ok_or("its target is where it is")?;
                let up = up.unwrap_or([0.0, 1.0, 0.0]);
                let right = unit(cross(up, front)).ok_or("its up direction is that of its front")?;
                let above = cross(front, right);
                let half = |axis: [f32; 3], length: f32| axis.map(|v| v * (0.5 * length));
                let kind = LightKind::Rect {
                    position,
                    half_width: half(right, size[0]),
                    half_height: half(above, size[1]),
                    two_sided: two_sided.unwrap_or(false),
                };
                (kind, color, intensity, None)
            }
            Self::Tube { from, to, radius, color, intensity } => {
                (LightKind::Tube { ends: [near(from), near(to)], radius }, color, intensity, None)
            }
        };
        Ok(Light::new(kind).with(|l| {
            l.color = color.unwrap_or([1.0; 3]);
            l.intensity = intensity;
            l.minimum_roughness = minimum_roughness.unwrap_or(0.0);
        }))
    }
}

impl Description {
    /// Puts environment and lights into the scene and takes out lights that are not wanted. Returns what is doubtful
    /// about the environment.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the environment's file and the reason.
    pub fn light(
        &self,
        scene: &mut Scene,
        limits: &Limits,
        jobs: &Jobs,
    ) -> Result<Vec<Warning>, DescriptionError> {
        let (environment, warnings) = self.environment(limits, jobs)?;
        self.light_by(scene, environment)?;
        Ok(warnings)
    }

    /// Puts an environment and the description's lights into the scene and takes out lights that are not wanted. A picture that
    /// the scene has around it, as files of USD can, stays in place of a studio that the description does not name.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the light.
    pub fn light_by(&self, scene: &mut Scene, environment: Environment) -> Result<(), DescriptionError> {
        if self.lights == Some(false) {
            scene.clear_lights();
        }
        for (number, light) in self.lights_to_add.iter().enumerate() {
            light.add_to(scene, number)?;
        }
        let is_default = self.env.is_none()
            && self.lights != Some(false)
            && matches!(environment.source, EnvironmentSource::Studio);
        let own = scene.environment();
        let environment = if is_default && own.of_model {
            let source = own.source.clone();
            environment.with(|e| (e.source, e.of_model) = (source, true))
        } else {
            environment
        };
        Ok(scene.set_environment(environment)?)
    }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// At unit length, computed in double precision and rounded once; `None` for vectors without length or too long.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let wide = v.map(f64::from);
    let length = (wide[0] * wide[0] + wide[1] * wide[1] + wide[2] * wide[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| wide.map(|c| (c / length) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Description;
    use overcoat_scene::EquirectImage;
    use std::sync::Arc;

    #[test]
    fn a_rectangle_faces_its_target_with_up_above() {
        let text = "[[light]]\ntype = \"rect\"\nposition = [0, 4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\n\
                    size = [2, 6]\nintensity = 3\n";
        let file = Description::from_toml(text).expect("valid");
        let mut scene = Scene::new();
        file.lights_to_add.iter().for_each(|light| light.add_to(&mut scene, 0).expect("valid"));
        let LightKind::Rect { half_width, half_height, two_sided, .. } = scene.lights()[0].kind else {
            panic!("not a rectangle")
        };
        assert_eq!((half_width, half_height, two_sided), ([-1.0, 0.0, 0.0], [0.0, 0.0, -3.0], false));
        // Down, where the target is.
        assert!(cross(half_width, half_height)[1] < 0.0);
    }

    #[test]
    fn a_picture_around_a_file_stays_unless_another_light_is_named() {
        let image = EquirectImage::new(2, 1, vec![[1.0; 3], [2.0; 3]]).expect("two texels");
        let own = Environment::default()
            .with(|e| (e.source, e.of_model) = (EnvironmentSource::Image(Arc::new(image)), true));
        let (limits, jobs) = (Limits::default(), Jobs::new(1));
        for (text, stays) in [
            ("", true),
            ("env_intensity = 3.0\n", true),
            ("env = \"studio\"\n", false),
            ("env = \"none\"\n", false),
            ("lights = false\n", false),
        ] {
            let mut scene = Scene::new();
            scene.set_environment(own.clone()).expect("valid");
            let description = Description::from_toml(text).expect("valid");
            // Twice: scenes are lit for each picture.
            for _ in 0..2 {
                description.light(&mut scene, &limits, &jobs).expect("lit");
            }
            let environment = scene.environment();
            assert_eq!(matches!(environment.source, EnvironmentSource::Image(_)), stays, "{text}");
            assert_eq!(environment.intensity, if text.contains('3') { 3.0 } else { 1.0 });
        }
    }

    #[test]
    fn what_is_wrong_with_a_light_is_named() {
        for (text, word) in [
            (r#"{"type": "area", "intensity": 1}"#, "area"),
            (r#"{"type": "point", "intensity": 1}"#, "position"),
            (r#"{"type": "point", "position": [0,0,0], "intensity": 1, "radius": 2}"#, "radius"),
        ] {
            let failure = Description::from_json(&format!(r#"{{"light": [{text}]}}"#)).unwrap_err();
            assert!(failure.to_string().contains(word), "{text}: {failure}");
        }
        for (text, word) in [
            (
                r#"{"type": "rect", "position": [0,0,0], "target": [0,1,0], "size": [1,1], "intensity": 1}"#,
                "up",
            ),
            (
                r#"{"type": "rect", "position": [0,0,0], "target": [0,0,1], "size": [1,0], "intensity": 1}"#,
                "height",
            ),
            (r#"{"type": "tube", "from": [0,0,0], "to": [0,0,0], "radius": 1, "intensity": 1}"#, "length"),
            (
                r#"{"type": "spot", "position": [0,0,0], "target": [0,1,0], "inner_cone_deg": 60, "intensity": 1}"#,
                "cone",
            ),
            (r#"{"type": "directional", "direction": [0,0,0], "intensity": 1}"#, "direction"),
        ] {
            let file = Description::from_json(&format!(r#"{{"light": [{text}]}}"#)).expect("parses");
            let failure = file.lights_to_add[0].add_to(&mut Scene::new(), 7).unwrap_err().to_string();
            assert!(failure.contains(word) && failure.contains('7'), "{text}: {failure}");
        }
    }
}
