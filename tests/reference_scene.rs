//! Rows of the reference tables through the whole pipeline: a flat quad, one light, the tables' environment.
//!
//! The quad faces along the row's N, an orthographic camera looks along its V, so that every fragment has exactly the
//! row's geometry (up to the rounding of matrices and normals). What comes out of `Renderer::render` must be what the
//! original function returned.

use overcoat::light::PrefilteredEnvironment;
use overcoat::render::{RenderOptions, Renderer, ShadingModel};
use overcoat::scene::{
    AlphaUse, Camera, ColorSpace, Environment, EnvironmentSource, Image, Instance, Light, LightKind,
    Material, Mesh, MeshData, Projection, Sampler, Scene, Texture, TextureRef, Transform, UvTransform,
    Workflow,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

type Row = BTreeMap<String, f32>;

/// The rows of a table in the repository.
fn rows(table: &str) -> Vec<Row> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/unity").join(table).with_extension("csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let cells = line.split(',').map(|c| c.parse::<f64>().unwrap() as f32);
            header.iter().map(ToString::to_string).zip(cells).collect()
        })
        .collect()
}

fn vector(row: &Row, name: &str) -> [f32; 3] {
    ["x", "y", "z"].map(|axis| row[&format!("{name}_{axis}")])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A quad of two metres around the origin with the row's normal and material.
fn scene(row: &Row) -> Scene {
    let normal = vector(row, "in_N");
    let helper = if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let side = cross(helper, normal);
    let up = cross(normal, side);
    let corner = |a: f32, b: f32| std::array::from_fn(|k| side[k] * a + up[k] * b);
    let mesh = MeshData {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        normals: vec![normal; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    };
    let mut scene = Scene::new();
    // Occlusion comes as a black texture and its strength, which may be any number.
    let black = Arc::new(Image::new(1, 1, vec![[0, 0, 0, 255]]).unwrap());
    let black = Texture::new(black, ColorSpace::Linear, AlphaUse::Data, Sampler::default());
    let texture = scene.add_texture(black).unwrap();
    let albedo = vector(row, "in_albedo");
    let workflow = if row["in_specularWorkflow"] == 1.0 {
        let glossiness = row["in_smoothness"];
        Workflow::SpecularGlossiness { specular: vector(row, "in_specular"), glossiness, texture: None }
    } else {
        Workflow::MetallicRoughness {
            metallic: row["in_metallic"],
            roughness: 1.0 - row["in_smoothness"],
            texture: None,
        }
    };
    let material = Material {
        base_color: [albedo[0], albedo[1], albedo[2], 1.0],
        workflow,
        coat: row["in_clearCoatMask"],
        coat_roughness: 1.0 - row["in_clearCoatSmoothness"],
        occlusion_texture: Some(TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY }),
        occlusion_strength: row.get("in_occlusion").map_or(0.0, |o| 1.0 - o),
        ..Material::default()
    };
    let mesh = scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 }).unwrap();
    scene
}

/// The centre pixel of the picture that an eye in the direction of the row's V takes.
fn render(renderer: &mut Renderer, scene: &Scene, row: &Row, shading: ShadingModel) -> [f32; 3] {
    let view = vector(row, "in_V");
    let camera = Camera {
        eye: view.map(|v| v * 4.0),
        target: [0.0; 3],
        up: if view[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] },
        projection: Projection::Orthographic { height: 0.1 },
        near: 0.01,
    };
    let options = RenderOptions { width: 5, height: 5, samples: 4, shading: Some(shading), ..RenderOptions::default() };
    let rendered = renderer.render(scene, &camera, &options).unwrap();
    let [r, g, b, a] = rendered.frame.pixels[12];
    assert_eq!(a, 1.0, "the quad fills the picture");
    [r, g, b]
}

/// Renders every row that a camera can see, and compares. Returns how many there were.
fn compare(table: &str, output: &str, mut prepare: impl FnMut(&mut Renderer, &mut Scene, &Row)) -> usize {
    let mut renderer = Renderer::new(1);
    let mut compared = 0;
    for row in rows(table) {
        let (normal, view) = (vector(&row, "in_N"), vector(&row, "in_V"));
        // A quad that is seen edge-on covers nothing; rows with hazards have no defined answer.
        if row["hazard"] != 0.0 || dot(normal, view) < 0.1 {
            continue;
        }
        let shading = match (row.get("in_mobile"), row.get("in_realIsHalf")) {
            (Some(&1.0), _) => ShadingModel::UrpMobile,
            (Some(_), _) => ShadingModel::UrpDesktop,
            // Half precision is not offered by the renderer.
            (_, Some(&1.0)) => continue,
            _ => ShadingModel::Urp17,
        };
        let mut scene = scene(&row);
        prepare(&mut renderer, &mut scene, &row);
        let found = render(&mut renderer, &scene, &row, shading);
        let expected = vector(&row, output);
        for k in 0..3 {
            // The view and the light are rounded once more on their way through matrices; what a row makes of such a
            // change is what single and double precision differ by in it.
            let conditioning = row["f32_f64_maxrel"] * expected[k].abs().max(1e-3);
            let tolerance = 1e-6 + 2e-4 * expected[k].abs() + 64.0 * conditioning;
            assert!(
                (found[k] - expected[k]).abs() <= tolerance,
                "{table} row {}: {found:?} instead of {expected:?}",
                row["row"]
            );
        }
        compared += 1;
    }
    compared
}

#[test]
fn direct_light_reproduces_the_tables() {
    for (table, least) in [("urp_direct", 150), ("urp17_direct", 40)] {
        let compared = compare(table, "out_lit", |_, scene, row| {
            scene
                .set_environment(Environment { source: EnvironmentSource::None, ..Environment::default() })
                .unwrap();
            // URP's light colour is irradiance over pi.
            let color =
                vector(row, "in_lightColor").map(|c| c * row["in_attenuation"] * std::f32::consts::PI);
            let direction = vector(row, "in_L").map(|v| -v);
            let kind = LightKind::Directional { direction };
            scene.add_light(Light { kind, color, intensity: 1.0 }).unwrap();
        });
        assert!(compared >= least, "{table}: only {compared} rows");
    }
}

#[test]
fn the_environment_reproduces_the_tables() {
    for (table, least) in [("urp_gi", 150), ("urp17_gi", 40)] {
        let compared = compare(table, "out_gi", |renderer, _, row| {
            let environment = PrefilteredEnvironment::reference(vector(row, "in_bakedGI"));
            renderer.use_environment(Some(Arc::new(environment)));
        });
        assert!(compared >= least, "{table}: only {compared} rows");
    }
}
