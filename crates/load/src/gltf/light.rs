//! KHR_lights_punctual in world space, with intensities as they are in the file.

use super::angle::sin_cos;
use super::camera::unit;
use super::list::label;
use super::model;
use crate::warnings::Warnings;
use overcoat_scene::{Light, LightKind, Scene, Transform};

/// Largest intensity that a scene takes.
const MAX_INTENSITY: f64 = 1e9;
/// Largest colour component that a scene takes.
const MAX_COLOR: f64 = 1e6;

/// Adds a light that stands at `transform` and shines along its -Z. One that cannot shine is left out with a
/// warning. As the extension demands, a node's scale has no influence.
pub(super) fn add(
    scene: &mut Scene,
    light: &model::Light,
    index: usize,
    transform: &Transform,
    warnings: &mut Warnings,
) {
    let name = || label::<model::Light>(index, light.name.as_deref());
    let intensity = light.intensity.unwrap_or(1.0);
    let color = light.color.unwrap_or([1.0; 3]);
    if !(0.0..=MAX_INTENSITY).contains(&intensity) || color.iter().any(|c| !(0.0..=MAX_COLOR).contains(c)) {
        warnings.add(|| format!("{}: intensity or colour out of range, clamped", name()));
    }
    let position = transform.point([0.0; 3]).map(|v| v as f32);
    let range = light.range.map(|r| r as f32).filter(|r| (f32::MIN_POSITIVE..f32::INFINITY).contains(r));
    let direction = || unit(transform.direction([0.0, 0.0, -1.0])).map(|d| d.map(|v| v as f32));
    let kind = match light.kind.as_str() {
        "directional" => direction().map(|direction| LightKind::Directional { direction }),
        "point" => Some(LightKind::Point { position, range }),
        "spot" => {
            let default = model::Spot::default();
            let spot = light.spot.as_ref().unwrap_or(&default);
            let right_angle = std::f64::consts::FRAC_PI_2;
            let outer = spot.outer_cone_angle.unwrap_or(right_angle * 0.5).clamp(0.0, right_angle);
            let inner = spot.inner_cone_angle.unwrap_or(0.0).clamp(0.0, outer);
            direction().map(|direction| LightKind::Spot {
                position,
                direction,
                range,
                inner_cone_cosine: sin_cos(inner).1 as f32,
                outer_cone_cosine: sin_cos(outer).1 as f32,
            })
        }
        other => {
            let other: String = other.escape_debug().take(32).collect();
            warnings.add(|| format!("{} of unknown type '{other}' is left out", name()));
            return;
        }
    };
    let Some(kind) = kind else {
        warnings.add(|| format!("{} is scaled to nothing and is left out", name()));
        return;
    };
    let result = scene.add_light(Light::new(kind).with(|l| {
        l.color = color.map(|c| c.clamp(0.0, MAX_COLOR) as f32);
        l.intensity = intensity.clamp(0.0, MAX_INTENSITY) as f32;
    }));
    if let Err(error) = result {
        warnings.add(|| format!("{} is left out: {error}", name()));
    }
}
