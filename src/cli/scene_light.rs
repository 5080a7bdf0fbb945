//! Lights of scene files: `[[light]]` in TOML, `"light": [..]` in JSON.

use super::failure::Failure;
use crate::scene::{Light, LightKind, Scene};
use serde::Deserialize;

/// A light of a scene file. They are added to those of the model.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "type", rename_all = "lowercase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum SceneLight {
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
        /// What it points at.
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
        /// What its front faces.
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

impl SceneLight {
    /// Adds it to a scene.
    ///
    /// # Errors
    /// [`Failure`] naming the light by its number and what is wrong with it.
    pub fn add_to(&self, scene: &mut Scene, number: usize) -> Result<(), Failure> {
        let wrong = |reason: &str| Failure::failed(format!("light {number}: {reason}"));
        scene.add_light(self.light().map_err(|reason| wrong(&reason))?).map_err(|e| wrong(&e.to_string()))
    }

    fn light(&self) -> Result<Light, String> {
        let (kind, color, intensity, minimum_roughness) = match *self {
            Self::Directional { direction, color, intensity, min_roughness } => {
                let direction = unit(direction).ok_or("its direction has no length")?;
                (LightKind::Directional { direction }, color, intensity, min_roughness)
            }
            Self::Point { position, range, color, intensity, min_roughness } => {
                (LightKind::Point { position, range }, color, intensity, min_roughness)
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
                let direction = unit(difference(target, position)).ok_or("its target is where it is")?;
                let cosine = |degrees: f32| {
                    if (0.0..=90.0).contains(&degrees) {
                        Ok(crate::math::scalar::cos(degrees.to_radians()))
                    } else {
                        Err(format!("a cone of {degrees} degrees is not 0 to 90"))
                    }
                };
                let inner_cone_cosine = cosine(inner_cone_deg.unwrap_or(0.0))?;
                let outer_cone_cosine = cosine(outer_cone_deg.unwrap_or(45.0))?;
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
                (LightKind::Tube { ends: [from, to], radius }, color, intensity, None)
            }
        };
        Ok(Light {
            kind,
            color: color.unwrap_or([1.0; 3]),
            intensity,
            minimum_roughness: minimum_roughness.unwrap_or(0.0),
        })
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
    use crate::cli::scene_file::SceneFile;

    #[test]
    fn a_rectangle_faces_its_target_with_up_above() {
        let text = "[[light]]\ntype = \"rect\"\nposition = [0, 4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\n\
                    size = [2, 6]\nintensity = 3\n";
        let file = SceneFile::from_toml(text).expect("valid");
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
    fn what_is_wrong_with_a_light_is_named() {
        for (text, word) in [
            (r#"{"type": "area", "intensity": 1}"#, "area"),
            (r#"{"type": "point", "intensity": 1}"#, "position"),
            (r#"{"type": "point", "position": [0,0,0], "intensity": 1, "radius": 2}"#, "radius"),
        ] {
            let failure = SceneFile::from_json(&format!(r#"{{"light": [{text}]}}"#)).unwrap_err();
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
                r#"{"type": "spot", "position": [0,0,0], "target": [0,1,0], "innerConeDeg": 60, "intensity": 1}"#,
                "cone",
            ),
            (r#"{"type": "directional", "direction": [0,0,0], "intensity": 1}"#, "direction"),
        ] {
            let file = SceneFile::from_json(&format!(r#"{{"light": [{text}]}}"#)).expect("parses");
            let failure = file.lights_to_add[0].add_to(&mut Scene::new(), 7).unwrap_err().to_string();
            assert!(failure.contains(word) && failure.contains('7'), "{text}: {failure}");
        }
    }
}
