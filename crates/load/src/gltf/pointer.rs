//! Targets of animation channels: properties of nodes, and with KHR_animation_pointer all others that the loader reads.

use super::model::Root;
use super::properties::{PROPERTIES, Property};

/// A property that changes over time, of an element that exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Target {
    /// Translation of a node.
    Translation(usize),
    /// Rotation of a node, a quaternion.
    Rotation(usize),
    /// Scale of a node.
    Scale(usize),
    /// Morph weights of a node, in place of those of its mesh.
    Weights(usize),
    /// Visibility of a node and its children.
    Visible(usize),
    /// Morph weights of a mesh, which nodes without weights of their own use.
    MeshWeights(usize),
    /// Property of a material.
    Surface(usize, Surface),
    /// Property of a light.
    Light(usize, Light),
    /// Property of a camera.
    Camera(usize, Camera),
}

/// A property of a material, or of one of its textures: its row in [`PROPERTIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Surface {
    Number(usize),
    /// Offset of KHR_texture_transform.
    Offset(usize),
    /// Rotation of KHR_texture_transform.
    Turn(usize),
    /// Scale of KHR_texture_transform.
    Scale(usize),
}

/// Properties of KHR_lights_punctual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Light {
    Color,
    Intensity,
    Range,
    InnerCone,
    OuterCone,
}

/// Properties of cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Camera {
    FieldOfView,
    PerspectiveNear,
    Height,
    OrthographicNear,
}

impl Target {
    /// Target of a channel with this path; `None` if the specification has no such path.
    pub(super) fn of_node(node: usize, path: &str) -> Option<Self> {
        Some(match path {
            "translation" => Self::Translation(node),
            "rotation" => Self::Rotation(node),
            "scale" => Self::Scale(node),
            "weights" => Self::Weights(node),
            _ => return None,
        })
    }

    /// Target of the pointer of a channel; `None` if the loader does not read that property.
    pub(super) fn of_pointer(root: &Root, pointer: &str) -> Option<Self> {
        let below = |list: &str| -> Option<(usize, &str)> {
            let (index, rest) = pointer.strip_prefix(list)?.split_once('/')?;
            // No sign, no leading zero: RFC 6901, section 4.
            let canonical = index == "0" || index.starts_with(|c: char| ('1'..='9').contains(&c));
            if canonical { Some((index.parse().ok()?, rest)) } else { None }
        };
        if let Some((node, rest)) = below("/nodes/") {
            let node = Some(node).filter(|&k| k < root.nodes.len())?;
            return match rest {
                "extensions/KHR_node_visibility/visible" => Some(Self::Visible(node)),
                path => Self::of_node(node, path),
            };
        }
        if let Some((mesh, rest)) = below("/meshes/") {
            return (mesh < root.meshes.len() && rest == "weights").then_some(Self::MeshWeights(mesh));
        }
        if let Some((material, rest)) = below("/materials/") {
            let surface = Surface::named(rest).filter(|_| material < root.materials.len())?;
            return Some(Self::Surface(material, surface));
        }
        if let Some((light, rest)) = below("/extensions/KHR_lights_punctual/lights/") {
            let count = root.extensions.lights.as_ref().map_or(0, |lights| lights.lights.len());
            let property = match rest {
                "color" => Light::Color,
                "intensity" => Light::Intensity,
                "range" => Light::Range,
                "spot/innerConeAngle" => Light::InnerCone,
                "spot/outerConeAngle" => Light::OuterCone,
                _ => return None,
            };
            return (light < count).then_some(Self::Light(light, property));
        }
        let (camera, rest) = below("/cameras/")?;
        let property = match rest {
            "perspective/yfov" => Camera::FieldOfView,
            "perspective/znear" => Camera::PerspectiveNear,
            "orthographic/ymag" => Camera::Height,
            "orthographic/znear" => Camera::OrthographicNear,
            _ => return None,
        };
        (camera < root.cameras.len()).then_some(Self::Camera(camera, property))
    }

    /// Number of components of one value.
    pub(super) fn width(self, root: &Root) -> usize {
        let targets = |mesh: usize| {
            let primitives = root.meshes.get(mesh).map_or(&[][..], |mesh| &mesh.primitives);
            primitives.iter().map(|p| p.targets.len()).fold(0, usize::max)
        };
        match self {
            Self::Translation(_) | Self::Scale(_) | Self::Light(_, Light::Color) => 3,
            Self::Rotation(_) => 4,
            Self::Weights(node) => {
                let mesh = root.nodes.get(node).and_then(|node| node.mesh);
                mesh.map_or(0, |mesh| targets(mesh.get()))
            }
            Self::MeshWeights(mesh) => targets(mesh),
            Self::Surface(_, surface) => surface.width(),
            Self::Visible(_) | Self::Light(..) | Self::Camera(..) => 1,
        }
    }
}

impl Surface {
    fn named(path: &str) -> Option<Self> {
        let row = |path: &str| PROPERTIES.iter().position(|property| property.path() == path);
        if let Some(number) = row(path)
            && matches!(PROPERTIES.get(number), Some(Property::Number(_)))
        {
            return Some(Self::Number(number));
        }
        let (texture, property) = path.split_once("/extensions/KHR_texture_transform/")?;
        let texture =
            row(texture).filter(|&row| matches!(PROPERTIES.get(row), Some(Property::Texture(_))))?;
        match property {
            "offset" => Some(Self::Offset(texture)),
            "rotation" => Some(Self::Turn(texture)),
            "scale" => Some(Self::Scale(texture)),
            _ => None,
        }
    }

    /// The row of the texture that it places.
    pub(super) fn texture(self) -> Option<usize> {
        match self {
            Self::Number(_) => None,
            Self::Offset(texture) | Self::Turn(texture) | Self::Scale(texture) => Some(texture),
        }
    }

    fn width(self) -> usize {
        match self {
            Self::Number(row) => match PROPERTIES.get(row) {
                Some(Property::Number(number)) => number.width,
                _ => 0,
            },
            Self::Offset(_) | Self::Scale(_) => 2,
            Self::Turn(_) => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row of that path.
    fn row(path: &str) -> usize {
        PROPERTIES.iter().position(|property| property.path() == path).unwrap()
    }

    #[test]
    fn pointers_lead_to_what_exists() {
        let text = r#"{"nodes": [{}, {"mesh": 0}], "meshes": [{"primitives": [{"targets": [{}, {}]}]}],
            "materials": [{}], "cameras": [{}], "extensions": {"KHR_lights_punctual": {"lights": [{}]}}}"#;
        let root: Root = serde_json::from_str(text).unwrap();
        let cases = [
            ("/nodes/1/weights", Some(Target::Weights(1)), 2),
            ("/nodes/0/rotation", Some(Target::Rotation(0)), 4),
            ("/nodes/1/extensions/KHR_node_visibility/visible", Some(Target::Visible(1)), 1),
            ("/meshes/0/weights", Some(Target::MeshWeights(0)), 2),
            (
                "/materials/0/pbrMetallicRoughness/baseColorFactor",
                Some(Target::Surface(0, Surface::Number(row("pbrMetallicRoughness/baseColorFactor")))),
                4,
            ),
            (
                "/materials/0/normalTexture/extensions/KHR_texture_transform/offset",
                Some(Target::Surface(0, Surface::Offset(row("normalTexture")))),
                2,
            ),
            ("/cameras/0/perspective/yfov", Some(Target::Camera(0, Camera::FieldOfView)), 1),
            ("/extensions/KHR_lights_punctual/lights/0/color", Some(Target::Light(0, Light::Color)), 3),
            ("/nodes/2/rotation", None, 0),
            ("/nodes/01/rotation", None, 0),
            ("/nodes/+1/rotation", None, 0),
            ("/nodes/1/matrix", None, 0),
            ("/materials/1/alphaCutoff", None, 0),
            (
                "/materials/0/extensions/KHR_materials_volume/attenuationColor",
                Some(Target::Surface(
                    0,
                    Surface::Number(row("extensions/KHR_materials_volume/attenuationColor")),
                )),
                3,
            ),
            ("/materials/0/extensions/KHR_materials_volume_scatter/multiscatterColor", None, 0),
            ("/extensions/KHR_lights_punctual/lights/1/color", None, 0),
            ("", None, 0),
            ("/", None, 0),
        ];
        for (pointer, expected, width) in cases {
            let target = Target::of_pointer(&root, pointer);
            assert_eq!(target, expected, "{pointer}");
            assert_eq!(target.map_or(0, |t| t.width(&root)), width, "{pointer}");
        }
    }
}
