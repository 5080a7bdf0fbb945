//! Scenes for others: in numbers that say all, as JSON, and as glTF, which says what it can.

use super::VERSION;
use overcoat_lab::lab::conformance::{
    BOX, BOX_RADIANCE, BOX_RANGE, DISTANCE, FOV_DEGREES, GRADIENT, IRRADIANCE, LAMP, Scene, Sky,
};
use overcoat_lab::lab::{Base, Specimen};
use overcoat_scene::Mesh;
use serde_json::{Value, json};

/// A value as a file.
pub(super) fn text(value: &Value) -> Vec<u8> {
    // `{:#}` indents; it cannot fail.
    format!("{value:#}\n").into_bytes()
}

/// All that a scene is.
pub(super) fn description(scene: &Scene) -> Value {
    let specimen = &scene.specimen;
    let mut surfaces = Vec::new();
    for (share, coated) in [(specimen.coat, true), (1.0 - specimen.coat, false)] {
        if share > 0.0 {
            surfaces.push(json!({ "share": share, "layers": layers(scene, coated) }));
        }
    }
    json!({
        "pack": VERSION,
        "name": scene.name,
        "about": scene.about,
        "geometry": { "kind": "sphere", "center": [0.0, 0.0, 0.0], "radius": 1.0 },
        "camera": {
            "kind": "perspective",
            "eye": [0.0, 0.0, DISTANCE],
            "target": [0.0, 0.0, 0.0],
            "up": [0.0, 1.0, 0.0],
            "vertical_fov_degrees": FOV_DEGREES,
            "aspect": 1.0,
            "pixel_filter": "box",
        },
        "light": light(scene.sky),
        "surfaces": surfaces,
        "parameters": {
            "coat": specimen.coat,
            "coat_roughness": specimen.coat_roughness,
            "coat_ior": specimen.coat_ior,
            "coat_thickness": specimen.thickness,
            "coat_extinction": specimen.extinction,
            "base": base(specimen),
            "base_ior": specimen.base_ior,
            "base_roughness": specimen.base_roughness,
            "metallic": if specimen.metal { 1.0 } else { 0.0 },
            "base_color": specimen.color,
            "specular": specimen.specular,
        },
    })
}

fn light(sky: Sky) -> Value {
    if sky == Sky::Lamp {
        return json!({ "kind": "directional", "towards": LAMP, "irradiance": ([IRRADIANCE; 3]) });
    }
    let formula = match sky {
        Sky::White => json!({ "kind": "constant", "radiance": [1.0, 1.0, 1.0] }),
        Sky::Gradient => json!({
            "kind": "linear",
            "radiance": "offset + slope * (x, y, z) of the direction, for red, green and blue",
            "offset": GRADIENT[0],
            "slope": GRADIENT[1],
        }),
        _ => json!({
            "kind": "soft_box",
            "radiance": "strength * t * t * (3 - 2 * t), t = clamp((dot(direction, towards) - from) / (to - from), 0, 1)",
            "strength": BOX_RADIANCE,
            "towards": BOX,
            "from": BOX_RANGE[0],
            "to": BOX_RANGE[1],
        }),
    };
    json!({ "kind": "environment", "file": map(sky), "formula": formula })
}

/// A map's path from the folder of the scenes.
fn map(sky: Sky) -> String {
    format!("../environments/{}.exr", sky.name())
}

/// Name of the layers beneath the coat.
fn base(specimen: &Specimen) -> &'static str {
    match specimen {
        Specimen { metal: true, .. } => "metal",
        Specimen { specular, .. } if *specular > 0.0 => specimen.base.name(),
        _ => Base::Lambert.name(),
    }
}

/// The layers from the top, as [`Truth`](overcoat_lab::lab::conformance::Truth) has them.
fn layers(scene: &Scene, coated: bool) -> Value {
    let specimen = &scene.specimen;
    let alpha = |roughness: f64| if roughness * roughness < 1e-4 { 0.0 } else { roughness * roughness };
    let mut layers = Vec::new();
    if coated {
        let rough = alpha(specimen.coat_roughness);
        layers.push(json!({
            "kind": "dielectric_interface",
            "fresnel": "exact",
            "index": specimen.coat_ior,
            "ggx_alpha": rough,
            "all_bounces": rough > 0.0,
        }));
        layers.push(json!({
            "kind": "absorbing_medium",
            "extinction": specimen.extinction,
            "thickness": specimen.thickness,
        }));
    }
    let rough = alpha(specimen.base_roughness);
    if specimen.metal {
        layers.push(json!({
            "kind": "conductor",
            "fresnel": "schlick",
            "f0": specimen.color,
            "ggx_alpha": rough,
            "all_bounces": rough > 0.0 && scene.has_all_bounces(),
        }));
    } else {
        let above = if coated { specimen.coat_ior } else { 1.0 };
        if specimen.base == Base::Convention && specimen.specular > 0.0 {
            layers.push(json!({
                "kind": "dielectric_interface",
                "fresnel": "schlick",
                "f0": ([0.04 * specimen.specular; 3]),
                "index": 1.0,
                "ggx_alpha": rough,
                "all_bounces": false,
            }));
        } else if let Some(index) = specimen.index_below(above) {
            layers.push(json!({
                "kind": "dielectric_interface",
                "fresnel": "exact",
                "index": index,
                "ggx_alpha": rough,
                "all_bounces": rough > 0.0,
            }));
        }
        layers.push(json!({ "kind": "lambert", "reflectance": specimen.substrate() }));
    }
    Value::Array(layers)
}

/// Positions, which are normals as well, then triangles.
pub(super) fn buffer(ball: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    for c in ball.positions().as_flattened() {
        bytes.extend(c.to_le_bytes());
    }
    for index in ball.triangles().as_flattened() {
        bytes.extend(index.to_le_bytes());
    }
    bytes
}

/// The scene as glTF 2.0, with its whole description in the extras of the scene.
pub(super) fn gltf(scene: &Scene, ball: &Mesh, description: Value) -> Value {
    let specimen = &scene.specimen;
    let (vertices, triangles) = (ball.positions().len(), ball.triangles().len());
    let bounds = ball.bounds();
    let (vertex_bytes, index_bytes) = (12 * vertices, 12 * triangles);
    let mut used = vec!["KHR_materials_ior", "KHR_materials_specular"];
    let mut extensions = json!({
        "KHR_materials_ior": { "ior": 1.5 },
        "KHR_materials_specular": { "specularFactor": specimen.specular },
    });
    if specimen.coat > 0.0 {
        used.push("KHR_materials_clearcoat");
        extensions["KHR_materials_clearcoat"] = json!({
            "clearcoatFactor": specimen.coat,
            "clearcoatRoughnessFactor": specimen.coat_roughness,
        });
    }
    let mut nodes = vec![
        json!({ "name": "ball", "mesh": 0 }),
        json!({ "name": "camera", "camera": 0, "translation": [0.0, 0.0, DISTANCE] }),
    ];
    let mut document = json!({
        "asset": {
            "version": "2.0",
            "generator": format!("overcoat conformance pack {VERSION}"),
            "copyright": "CC0-1.0",
        },
        "scene": 0,
        "cameras": [{
            "name": "camera",
            "type": "perspective",
            "perspective": { "yfov": FOV_DEGREES.to_radians(), "aspectRatio": 1.0, "znear": 0.1, "zfar": 100.0 },
        }],
        "meshes": [{
            "name": "ball",
            "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 0 }, "indices": 1, "material": 0 }],
        }],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
                "min": bounds.min, "max": bounds.max,
            },
            { "bufferView": 1, "componentType": 5125, "count": 3 * triangles, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": vertex_bytes, "target": 34962 },
            { "buffer": 0, "byteOffset": vertex_bytes, "byteLength": index_bytes, "target": 34963 },
        ],
        "buffers": [{ "uri": "ball.bin", "byteLength": vertex_bytes + index_bytes }],
    });
    let [r, g, b] = specimen.color;
    document["materials"] = json!([{
        "name": scene.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0],
            "metallicFactor": if specimen.metal { 1.0 } else { 0.0 },
            "roughnessFactor": specimen.base_roughness,
        },
        "extensions": extensions,
    }]);
    if scene.sky == Sky::Lamp {
        used.push("KHR_lights_punctual");
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
            { "type": "directional", "color": [1.0, 1.0, 1.0], "intensity": IRRADIANCE },
        ] } });
        nodes.push(json!({
            "name": "lamp",
            "rotation": rotation(LAMP),
            "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }));
    }
    let all: Vec<usize> = (0..nodes.len()).collect();
    document["nodes"] = Value::Array(nodes);
    document["scenes"] = json!([{ "nodes": all, "extras": { "overcoat_conformance": description } }]);
    document["extensionsUsed"] = json!(used);
    document
}

/// The quaternion that turns +Z to a direction: lights of glTF shine along -Z.
fn rotation([x, y, z]: [f64; 3]) -> [f64; 4] {
    let length = (x * x + y * y + (1.0 + z) * (1.0 + z)).sqrt();
    [-y / length, x / length, 0.0, (1.0 + z) / length]
}
