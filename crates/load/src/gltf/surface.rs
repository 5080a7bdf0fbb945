//! Materials, lights and cameras as an animation has changed them.

use super::model;
use super::pointer::{Camera, Light, Surface};
use super::properties::{Goal, PROPERTIES, Property, Texture};
use super::texture::transform_of;
use overcoat_scene::Material;
use overcoat_scene::parameters::{Kind, Range};

/// Changes a material of the scene that was made of `given`. Numbers beyond their range are clamped to it.
pub(super) fn change(material: &mut Material, given: &model::Material, changes: &[(Surface, Vec<f64>)]) {
    let strength = given.extensions.as_deref().and_then(|e| e.emissive_strength.as_ref());
    let mut strength = strength.and_then(|e| e.emissive_strength).map_or(1.0, f64::from);
    let mut emissive = given.emissive_factor.as_deref().map_or([0.0; 3], |e| e.map(f64::from));
    let mut glows = false;
    for (surface, values) in changes {
        // Textures below, since what is changed of one belongs together.
        let Surface::Number(row) = surface else { continue };
        let Some(property) = PROPERTIES.get(*row).filter(|property| property.applies(given)) else {
            continue;
        };
        let Property::Number(number) = property else { continue };
        match number.goal {
            Goal::Emission => (emissive, glows) = (three(values), true),
            Goal::EmissionStrength => (strength, glows) = (values.first().copied().unwrap_or(0.0), true),
            Goal::Whole(_) | Goal::Part(..) => {
                let value = |k: usize| values.get(k).copied().unwrap_or(0.0);
                number.set(material, std::array::from_fn(|k| number.clamp(value(k))));
            }
        }
    }
    if glows {
        let strength = strength.clamp(0.0, f64::from(Range::FACTOR.high));
        material.emissive = emissive.map(|e| (e.clamp(0.0, 1.0) * strength) as f32);
    }
    for (place, (surface, _)) in changes.iter().enumerate() {
        let Some(row) = surface.texture() else { continue };
        // Once for each texture.
        if changes.iter().take(place).any(|(earlier, _)| earlier.texture() == Some(row)) {
            continue;
        }
        if let Some(property) = PROPERTIES.get(row).filter(|property| property.applies(given))
            && let Property::Texture(texture) = property
        {
            place_texture(material, given, texture, row, changes);
        }
    }
}

/// Gives a texture the transform of the file with what is changed of it.
fn place_texture(
    material: &mut Material,
    given: &model::Material,
    texture: &Texture,
    row: usize,
    changes: &[(Surface, Vec<f64>)],
) {
    let own = (texture.read)(given).and_then(|info| info.extensions.transform.as_deref());
    let mut offset = own.and_then(|t| t.offset).unwrap_or([0.0; 2]);
    let mut rotation = own.and_then(|t| t.rotation).unwrap_or(0.0);
    let mut scale = own.and_then(|t| t.scale).unwrap_or([1.0; 2]);
    for (surface, values) in changes.iter().filter(|(surface, _)| surface.texture() == Some(row)) {
        let two = || std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0));
        match surface {
            Surface::Offset(_) => offset = two(),
            Surface::Turn(_) => rotation = values.first().copied().unwrap_or(0.0),
            Surface::Scale(_) => scale = two(),
            Surface::Number(_) => {}
        }
    }
    let Kind::Texture(slot) = texture.parameter.kind else { return };
    // Beyond what a scene takes it stays as it was.
    if let (Some(texture), Some(transform)) = (slot.get_mut(material), transform_of(offset, rotation, scale))
    {
        texture.transform = transform;
    }
}

/// A light of the file with what is changed of it.
pub(super) fn changed_light(given: &model::Light, changes: &[(Light, Vec<f64>)]) -> model::Light {
    let mut light = given.clone();
    for (property, values) in changes {
        let first = values.first().copied();
        match property {
            Light::Color => light.color = Some(three(values)),
            Light::Intensity => light.intensity = first,
            Light::Range => light.range = first,
            Light::InnerCone => light.spot.get_or_insert_default().inner_cone_angle = first,
            Light::OuterCone => light.spot.get_or_insert_default().outer_cone_angle = first,
        }
    }
    light
}

/// A camera of the file with what is changed of it.
pub(super) fn changed_camera(given: &model::Camera, changes: &[(Camera, Vec<f64>)]) -> model::Camera {
    let mut camera = given.clone();
    for (property, values) in changes {
        let first = values.first().copied().unwrap_or(0.0);
        match (property, &mut camera.perspective, &mut camera.orthographic) {
            (Camera::FieldOfView, Some(perspective), _) => perspective.yfov = first,
            (Camera::PerspectiveNear, Some(perspective), _) => perspective.znear = first,
            (Camera::Height, _, Some(orthographic)) => orthographic.ymag = first,
            (Camera::OrthographicNear, _, Some(orthographic)) => orthographic.znear = first,
            _ => {}
        }
    }
    camera
}

fn three(values: &[f64]) -> [f64; 3] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
}
