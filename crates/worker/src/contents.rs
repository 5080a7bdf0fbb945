//! Contents of a model file, for people and as JSON.

use crate::failure::{Failure, file_name};
use crate::report::{UpReport, Versions};
use overcoat_load::{AnimatedModel, AnimationInfo, Context, Format, LoadError, LoadOptions, Loaded, Plate};
use overcoat_scene::parameters::slots;
use overcoat_scene::{
    AlphaMode, ColorSpace, Light, LightKind, Material, PrimitiveKind, Projection, Scene, SplatCloud,
    SplatColorSpace, Workflow,
};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Contents of a model file, as `overcoat info --json` prints them. Fields are only ever added.
#[derive(Debug, Serialize)]
pub struct Contents {
    file: String,
    format: Option<&'static str>,
    /// Name of the converter that has made that of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub converter: Option<String>,
    #[serde(flatten)]
    up: UpReport,
    /// Axis of the file to which the model's front is taken to face, and +Z of everything here.
    front_axis: &'static str,
    /// The format says so of its front; else it is what most files have.
    front_is_known: bool,
    triangles: u64,
    lines: u64,
    points: u64,
    vertices: u64,
    instances: usize,
    meshes: usize,
    /// Gaussian splats, every instance counted.
    splats: u64,
    splat_clouds: Vec<SplatCloudInfo>,
    /// World space, metres; absent if nothing is drawn.
    bounds: Option<Extent>,
    materials: Vec<MaterialInfo>,
    textures: Vec<TextureInfo>,
    lights: Vec<LightInfo>,
    cameras: Vec<CameraInfo>,
    animations: Vec<Animation>,
    /// Names of the material variants.
    variants: Vec<String>,
    /// Plates of a 3MF project.
    plates: Vec<PlateInfo>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct SplatCloudInfo {
    splats: usize,
    /// Degree of the spherical harmonics.
    degree: u8,
    color_space: &'static str,
}

#[derive(Debug, Serialize)]
struct Extent {
    min: [f64; 3],
    max: [f64; 3],
}

#[derive(Debug, Serialize)]
struct MaterialInfo {
    name: String,
    workflow: &'static str,
    base_color: [f32; 4],
    metallic: Option<f32>,
    roughness: f32,
    coat: f32,
    coat_roughness: f32,
    alpha_mode: &'static str,
    double_sided: bool,
    unlit: bool,
    maps: Vec<Map>,
}

#[derive(Debug, Serialize)]
struct Map {
    /// Name of its key in material files, without `_texture`.
    map: String,
    texture: usize,
}

#[derive(Debug, Serialize)]
struct TextureInfo {
    width: u32,
    height: u32,
    color_space: &'static str,
}

#[derive(Debug, Serialize)]
struct LightInfo {
    kind: &'static str,
    intensity: f32,
    unit: &'static str,
    color: [f32; 3],
}

#[derive(Debug, Serialize)]
struct CameraInfo {
    name: String,
    projection: &'static str,
    /// Vertical field of view, of perspective cameras.
    fov_y_degrees: Option<f32>,
    /// Height of the view in metres, of orthographic cameras.
    height: Option<f32>,
}

#[derive(Debug, Serialize)]
struct PlateInfo {
    number: u32,
    name: String,
    /// Items of the file that lie on it.
    items: usize,
}

#[derive(Debug, Serialize)]
struct Animation {
    name: String,
    /// To the last key frame; absent if the file does not tell.
    seconds: Option<f64>,
    channels: usize,
}

impl Contents {
    /// Report of `--json` on a model in memory. `name` is that of its file, which tells the format where the content does
    /// not; a converter may have made it of that file, with warnings.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be loaded.
    pub fn json_of_bytes(
        bytes: &[u8],
        name: &Path,
        (converter, warnings): (Option<String>, &[String]),
        options: &LoadOptions,
        context: &Context<'_>,
    ) -> Result<Vec<u8>, Failure> {
        let about = |error: LoadError| match &converter {
            Some(converter) => Failure::load(&error).of_converter(converter).at(name),
            None => Failure::load(&error).at(name),
        };
        let model = AnimatedModel::from_named_bytes(bytes, name, options, context).map_err(about)?;
        let loaded = model.at(0.0, context.jobs).map_err(about)?;
        let mut contents = Self::of(&model, &loaded, file_name(name));
        contents.converter = converter;
        contents.warnings.extend_from_slice(warnings);
        serde_json::to_vec(&contents).map_err(Failure::failed)
    }

    /// Contents of a model, of which `file` is the name.
    #[must_use]
    pub fn of(model: &AnimatedModel, loaded: &Loaded, file: String) -> Self {
        let scene = &loaded.scene;
        let mut bounds = scene.bounds();
        for k in 0..3 {
            bounds.min[k] += scene.origin()[k];
            bounds.max[k] += scene.origin()[k];
        }
        let orientation = scene.orientation();
        Self {
            file,
            format: model.format().map(Format::extension),
            converter: None,
            triangles: scene.count_of(PrimitiveKind::Triangles),
            lines: scene.count_of(PrimitiveKind::Lines),
            points: scene.count_of(PrimitiveKind::Points),
            up: UpReport::from(orientation),
            front_axis: orientation.front().name(),
            front_is_known: orientation.front_is_known,
            vertices: scene.meshes().iter().map(|m| m.positions().len() as u64).sum(),
            instances: scene.instances().len(),
            meshes: scene.meshes().len(),
            splats: scene.splat_count(),
            splat_clouds: scene.splats().iter().map(describe_splats).collect(),
            bounds: (!bounds.is_empty()).then_some(Extent { min: bounds.min, max: bounds.max }),
            materials: scene.materials().iter().map(describe_material).collect(),
            textures: describe_textures(scene),
            lights: scene.lights().iter().map(describe_light).collect(),
            cameras: describe_cameras(scene),
            animations: describe_animations(model),
            variants: model.variants().map(str::to_owned).collect(),
            plates: loaded.plates().iter().map(describe_plate).collect(),
            warnings: loaded.warnings.iter().map(ToString::to_string).collect(),
            versions: Versions::default(),
        }
    }

    /// One line for each fact.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let by =
            self.converter.as_ref().map_or_else(String::new, |name| format!(", by the converter {name}"));
        let _ = writeln!(out, "{}: {}{by}", self.file, self.format.unwrap_or("unknown format"));
        let _ = write!(out, "  {} triangles, ", self.triangles);
        for (count, what) in [(self.lines, "lines"), (self.points, "points")] {
            if count > 0 {
                let _ = write!(out, "{count} {what}, ");
            }
        }
        let _ = writeln!(
            out,
            "{} vertices, {} instances of {} meshes",
            self.vertices, self.instances, self.meshes
        );
        for cloud in &self.splat_clouds {
            let SplatCloudInfo { splats, degree, color_space } = cloud;
            let _ = writeln!(
                out,
                "  {splats} Gaussian splats, spherical harmonics of degree {degree}, {color_space} colours"
            );
        }
        let guess = if self.front_is_known { "" } else { " (the format does not say)" };
        let shape = if self.up.up_is_by_shape { " by the shape of the model" } else { "" };
        let (up, front) = (self.up.up_axis, self.front_axis);
        let _ = writeln!(out, "  {up} of the file is up{shape}, {front} its front{guess}");
        if let Some(Extent { min, max }) = &self.bounds {
            let [w, h, d]: [f64; 3] = std::array::from_fn(|k| max[k] - min[k]);
            let point = |p: &[f64; 3]| format!("({})", p.map(|v| format!("{v:.6}")).join(", "));
            let _ =
                writeln!(out, "  bounds {} to {}, size {w:.6} x {h:.6} x {d:.6} m", point(min), point(max));
        }
        for (k, m) in self.materials.iter().enumerate() {
            let _ = write!(out, "  material {k} '{}': {}", m.name.escape_debug(), m.workflow);
            if let Some(metallic) = m.metallic {
                let _ = write!(out, ", metallic {metallic}");
            }
            let _ = write!(out, ", roughness {}, base color {:?}", m.roughness, m.base_color);
            if m.coat > 0.0 {
                let _ = write!(out, ", coat {} with roughness {}", m.coat, m.coat_roughness);
            }
            for (shown, text) in [
                (m.alpha_mode != "opaque", m.alpha_mode),
                (m.double_sided, "double-sided"),
                (m.unlit, "unlit"),
            ] {
                if shown {
                    let _ = write!(out, ", {text}");
                }
            }
            if !m.maps.is_empty() {
                let maps: Vec<String> = m.maps.iter().map(|m| format!("{} {}", m.map, m.texture)).collect();
                let _ = write!(out, "; maps: {}", maps.join(", "));
            }
            out.push('\n');
        }
        for (k, t) in self.textures.iter().enumerate() {
            let _ = writeln!(out, "  texture {k}: {} x {}, {}", t.width, t.height, t.color_space);
        }
        for (k, l) in self.lights.iter().enumerate() {
            let _ = writeln!(out, "  light {k}: {}, {} {}, color {:?}", l.kind, l.intensity, l.unit, l.color);
        }
        for (k, c) in self.cameras.iter().enumerate() {
            let _ = write!(out, "  camera {k} '{}': {}", c.name.escape_debug(), c.projection);
            match (c.fov_y_degrees, c.height) {
                (Some(degrees), _) => {
                    let _ = writeln!(out, ", {degrees:.1} degrees");
                }
                (_, Some(height)) => {
                    let _ = writeln!(out, ", {height} m high");
                }
                _ => out.push('\n'),
            }
        }
        for (k, a) in self.animations.iter().enumerate() {
            let _ = write!(out, "  animation {k} '{}': ", a.name.escape_debug());
            let _ = match a.seconds {
                Some(seconds) => writeln!(out, "{seconds:.3} s, {} channels", a.channels),
                None => writeln!(out, "{} channels", a.channels),
            };
        }
        for (k, name) in self.variants.iter().enumerate() {
            let _ = writeln!(out, "  variant {k} '{}'", name.escape_debug());
        }
        for PlateInfo { number, name, items } in &self.plates {
            let things = if *items == 1 { "item" } else { "items" };
            let _ = writeln!(out, "  plate {number} '{}': {items} {things}", name.escape_debug());
        }
        out
    }
}

fn describe_plate(plate: &Plate) -> PlateInfo {
    PlateInfo { number: plate.number, name: plate.name.clone(), items: plate.items }
}

fn describe_animations(model: &AnimatedModel) -> Vec<Animation> {
    let describe =
        |a: &AnimationInfo| Animation { name: a.name.clone(), seconds: a.length, channels: a.channels };
    model.animations().iter().map(describe).collect()
}

fn describe_splats(cloud: &SplatCloud) -> SplatCloudInfo {
    SplatCloudInfo {
        splats: cloud.len(),
        degree: cloud.degree(),
        color_space: match cloud.color_space() {
            SplatColorSpace::Srgb => "sRGB",
            SplatColorSpace::Linear => "linear",
        },
    }
}

fn describe_material(material: &Material) -> MaterialInfo {
    let (workflow, metallic, roughness) = match &material.workflow {
        Workflow::MetallicRoughness { metallic, roughness, .. } => {
            ("metallic-roughness", Some(*metallic), *roughness)
        }
        Workflow::SpecularGlossiness { glossiness, .. } => ("specular-glossiness", None, 1.0 - glossiness),
    };
    let maps = slots().filter_map(|(parameter, slot)| {
        let map = parameter.name.trim_end_matches("_texture").replace('_', "-");
        slot.get(material).map(|texture| Map { map, texture: texture.texture.index() })
    });
    MaterialInfo {
        name: material.name.clone(),
        workflow,
        base_color: material.base_color,
        metallic,
        roughness,
        coat: material.coat,
        coat_roughness: material.coat_roughness,
        alpha_mode: match material.alpha_mode {
            AlphaMode::Opaque => "opaque",
            AlphaMode::Mask { .. } => "mask",
            AlphaMode::Blend => "blend",
        },
        double_sided: material.double_sided,
        unlit: material.unlit,
        maps: maps.collect(),
    }
}

fn describe_textures(scene: &Scene) -> Vec<TextureInfo> {
    let describe = |texture: &overcoat_scene::Texture| TextureInfo {
        width: texture.width(),
        height: texture.height(),
        color_space: match texture.color_space() {
            ColorSpace::Srgb => "sRGB",
            ColorSpace::Linear => "linear",
        },
    };
    scene.textures().iter().map(describe).collect()
}

fn describe_light(light: &Light) -> LightInfo {
    let (kind, unit) = match light.kind {
        LightKind::Directional { .. } => ("directional", "lux"),
        LightKind::Point { .. } => ("point", "candela"),
        LightKind::Spot { .. } => ("spot", "candela"),
        LightKind::Rect { .. } => ("rect", "candela per square metre"),
        LightKind::Tube { .. } => ("tube", "candela per square metre"),
    };
    LightInfo { kind, intensity: light.intensity, unit, color: light.color }
}

fn describe_cameras(scene: &Scene) -> Vec<CameraInfo> {
    let names = scene.camera_names().iter();
    names
        .zip(scene.cameras())
        .map(|(name, camera)| {
            let (projection, fov_y_degrees, height) = match camera.projection {
                Projection::Perspective { fov_y } => ("perspective", Some(fov_y.to_degrees()), None),
                Projection::Intrinsics(_) => ("perspective", None, None),
                Projection::Orthographic { height } => ("orthographic", None, Some(height)),
            };
            CameraInfo { name: name.clone(), projection, fov_y_degrees, height }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::{TextureId, TextureRef, UvTransform};

    #[test]
    fn every_map_of_a_material_is_listed() {
        let texture = |id| TextureRef {
            texture: TextureId::from_index(id),
            uv_set: 0,
            transform: UvTransform::IDENTITY,
        };
        let mut material = Material::default();
        for (k, (_, slot)) in
            slots().filter(|(parameter, _)| parameter.is_in(&Material::default())).enumerate()
        {
            slot.set(&mut material, Some(texture(k as u32)));
        }
        let maps = describe_material(&material).maps;
        assert_eq!(maps.iter().map(|m| m.texture).collect::<Vec<_>>(), (0..28).collect::<Vec<_>>());
        let names: Vec<&str> = maps.iter().map(|m| m.map.as_str()).collect();
        for name in
            ["base-color", "metallic-roughness", "coat-normal", "coat-color", "thickness", "bent-normal"]
        {
            assert!(names.contains(&name), "{name} is not in {names:?}");
        }
    }
}
