//! Rows of the reference tables through the whole pipeline: a flat quad, one light, the tables' environment.
//!
//! The quad faces along the row's N, an orthographic camera looks along its V, so that every fragment has exactly the
//! row's geometry (up to the rounding of matrices and normals). What comes out of `Renderer::render` must be what the
//! original function returned. Rows that a scene file cannot express (other pre-integrated tables than the renderer's,
//! occlusion from the screen, normals apart that need a map) are left out; each test states how many remain.

use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    AlphaUse, Camera, ColorSpace, Environment, EnvironmentSource, Image, Instance, Light, LightKind,
    Material, Mesh, MeshData, Projection, Sampler, Scene, ShadingModel, Texture, TextureRef, Transform,
    UvTransform, Workflow,
};
use overcoat_stages::light::PrefilteredEnvironment;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

type Row = BTreeMap<String, f32>;

/// The rows of a table in the repository, `unity/<name>` or `web/<name>`.
fn rows(table: &str) -> Vec<Row> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(table).with_extension("csv");
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

/// A quad of two metres around the origin with the row's normal (and tangent, where it has one).
fn quad(row: &Row) -> MeshData {
    let normal = vector(row, "in_N");
    let helper = if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let side = cross(helper, normal);
    let up = cross(normal, side);
    let corner = |a: f32, b: f32| std::array::from_fn(|k| side[k] * a + up[k] * b);
    MeshData::default().with(|d| {
        d.positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        d.normals = vec![normal; 4];
        d.tangents = if row.contains_key("in_T_x") {
            let [x, y, z] = vector(row, "in_T");
            vec![[x, y, z, 1.0]; 4]
        } else {
            Vec::new()
        };
        d.triangles = vec![[0, 1, 2], [0, 2, 3]];
    })
}

/// The quad of a row with URP's material.
fn scene(row: &Row) -> Scene {
    let mesh = quad(row);
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
    let material = Material::default().with(|m| {
        m.base_color = [albedo[0], albedo[1], albedo[2], 1.0];
        m.workflow = workflow;
        m.coat = row["in_clearCoatMask"];
        m.coat_roughness = 1.0 - row["in_clearCoatSmoothness"];
        m.occlusion_texture = Some(TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY });
        m.occlusion_strength = row.get("in_occlusion").map_or(0.0, |o| 1.0 - o);
    });
    let mesh = scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

/// The centre pixel of the picture that an eye in the direction of the row's V takes.
fn render(renderer: &mut Renderer, scene: &Scene, row: &Row, shading: ShadingModel) -> [f32; 3] {
    let view = vector(row, "in_V");
    let camera = Camera::new(
        view.map(|v| v * 4.0),
        [0.0; 3],
        if view[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] },
        Projection::Orthographic { height: 0.1 },
        0.01,
    );
    let options = RenderOptions::draft(5, 5).with_samples(4).with_shading(shading);
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
    for (table, least) in [("unity/urp_direct", 150), ("unity/urp17_direct", 40)] {
        let compared = compare(table, "out_lit", |_, scene, row| {
            scene
                .set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None))
                .unwrap();
            // URP's light colour is irradiance over pi.
            let color =
                vector(row, "in_lightColor").map(|c| c * row["in_attenuation"] * std::f32::consts::PI);
            let direction = vector(row, "in_L").map(|v| -v);
            let kind = LightKind::Directional { direction };
            scene
                .add_light(Light::new(kind).with(|l| {
                    l.color = color;
                    l.intensity = 1.0;
                }))
                .unwrap();
        });
        assert!(compared >= least, "{table}: only {compared} rows");
    }
}

#[test]
fn the_environment_reproduces_the_tables() {
    for (table, least) in [("unity/urp_gi", 150), ("unity/urp17_gi", 40)] {
        let compared = compare(table, "out_gi", |renderer, _, row| {
            let environment = PrefilteredEnvironment::reference(vector(row, "in_bakedGI"));
            renderer.use_environment(Some(Arc::new(environment)));
        });
        assert!(compared >= least, "{table}: only {compared} rows");
    }
}

/// Material, model and what is to come out per light colour; `None` for rows that cannot be expressed.
type Told = Option<(Material, ShadingModel, [f32; 3])>;

/// Translation of a table's rows to scenes.
struct Case {
    table: &'static str,
    told: fn(&Row) -> Told,
    /// Irradiance per unit of the row's light colour.
    irradiance: fn(&Row) -> f32,
    /// Relative error beyond rounding: of pre-integrated tables that are not the row's.
    relative: f32,
    /// Rows that remain at least.
    least: usize,
}

fn metallic(row: &Row, color: &str, metallic: f32, roughness: f32) -> Material {
    let color = vector(row, color);
    Material::default().with(|m| {
        m.base_color = [color[0], color[1], color[2], 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
    })
}

fn same(row: &Row, a: &str, b: &str) -> bool {
    let (a, b) = (vector(row, a), vector(row, b));
    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6)
}

fn on(row: &Row, name: &str) -> bool {
    row[&format!("in_{name}")] == 1.0
}

/// Index of refraction of an F0.
fn ior_of(f0: f32) -> f32 {
    (1.0 + f0.sqrt()) / (1.0 - f0.sqrt())
}

fn hdrp_lit(row: &Row) -> Told {
    let features = row["in_materialFeatures"] as u32;
    let roughness = 1.0 - row["in_perceptualSmoothness"];
    // Lamps of the renderer have the roughness 1/1024 at least.
    if row["in_lightMinRoughness"] > 1.0 / 1024.0 || roughness < 0.1 {
        return None;
    }
    let mut material = metallic(row, "in_baseColor", row["in_metallic"], roughness);
    if features & 2 != 0 {
        let glossiness = row["in_perceptualSmoothness"];
        let specular = vector(row, "in_specularColor");
        material.workflow = Workflow::SpecularGlossiness { specular, glossiness, texture: None };
    }
    if features & 16 != 0 {
        material.lobes.anisotropy.strength = row["in_anisotropy"];
    }
    if features & 32 != 0 {
        material.lobes.iridescence.mask = row["in_iridescenceMask"].into();
        material.lobes.iridescence.thickness = [3000.0 * row["in_iridescenceThickness"]; 2];
    }
    if features & 64 != 0 {
        material.coat = row["in_coatMask"];
    }
    let (diffuse, specular) = (vector(row, "out_litDiffuse"), vector(row, "out_litSpecular"));
    let (color, f0) = (vector(row, "out_diffuseColor"), vector(row, "out_fresnel0"));
    let compensation = row["out_energyCompensation"];
    let out = std::array::from_fn(|k| color[k] * diffuse[k] + specular[k] * (1.0 + f0[k] * compensation));
    Some((material, ShadingModel::HdrpLit, out))
}

fn stacklit(row: &Row) -> Told {
    let features = row["in_materialFeatures"] as u32;
    // Scattering, a coat normal apart and the specular workflow (whose base colour Unity's graph dims) are not told.
    let film_fixed =
        row["in_iridescenceCoatFixupTIR"] != 0.0 || row["in_iridescenceCoatFixupTIRClamp"] != 0.0;
    // The peak of a mirror: rounding of the view decides.
    let (view, light) = (vector(row, "in_V"), vector(row, "in_L"));
    let half: [f32; 3] = std::array::from_fn(|k| view[k] + light[k]);
    let n_dot_h = dot(vector(row, "in_N"), half) / dot(half, half).sqrt();
    let smoothest = row["in_perceptualSmoothnessA"].max(row["in_perceptualSmoothnessB"]);
    let at_peak = n_dot_h > 0.9999 && smoothest > 0.95;
    if features & (32 | 64 | 128 | 256) != 0
        || on(row, "cfg_honorLightMinRoughness")
        || (features & 24 == 24 && film_fixed)
        || at_peak
    {
        return None;
    }
    let roughness = 1.0 - row["in_perceptualSmoothnessA"];
    let mut material = metallic(row, "in_baseColor", row["in_metallic"], roughness);
    material.ior = row["in_dielectricIor"];
    let lobes = &mut material.lobes;
    // Lobe B is always there, and counts by the mix.
    lobes.second.roughness = (1.0 - row["in_perceptualSmoothnessB"]).into();
    lobes.second.mix = row["in_lobeMix"].into();
    if features & 4 != 0 {
        lobes.anisotropy.strength = row["in_anisotropyA"];
        lobes.second.anisotropy = row["in_anisotropyB"];
    } else if features & 512 != 0 && row["in_anisotropyB"] != 0.0 {
        return None;
    }
    if features & 512 != 0 {
        lobes.second.haziness = row["in_haziness"].into();
        lobes.second.haze_extent = row["in_hazeExtent"];
        lobes.second.haze_max_dielectric_f0 = row["in_hazyGlossMaxDielectricF0"];
    }
    if features & 16 != 0 {
        lobes.iridescence.mask = row["in_iridescenceMask"].into();
        lobes.iridescence.thickness = [3000.0 * row["in_iridescenceThickness"]; 2];
    }
    if features & 8 != 0 {
        lobes.coat.ior = row["in_coatIor"];
        lobes.coat.thickness = row["in_coatThickness"].into();
        lobes.coat.extinction = vector(row, "in_coatExtinction");
        material.coat = row["in_coatMask"];
        material.coat_roughness = 1.0 - row["in_coatPerceptualSmoothness"];
    }
    material.options.stacklit.recompute_per_light = on(row, "cfg_recomputePerLight");
    material.options.stacklit.refracted_angles = on(row, "cfg_refractedAnglesForBase");
    let (diffuse, specular) = (vector(row, "out_litDiffuse"), vector(row, "out_litSpecular"));
    let color = vector(row, "in_baseColor").map(|c| c * (1.0 - row["in_metallic"]));
    Some((material, ShadingModel::StackLit, std::array::from_fn(|k| color[k] * diffuse[k] + specular[k])))
}

fn filament(row: &Row) -> Told {
    let coat = on(row, "clearCoat_on");
    // The renderer's materials always have a coat roughness; the sheen's albedo is the row's.
    if on(row, "anisotropy_on")
        || on(row, "sheen_on")
        || coat && (on(row, "coatNormal_on") || !on(row, "coatRoughness_on"))
    {
        return None;
    }
    let mut material = metallic(row, "in_baseColor", row["in_metallic"], row["in_roughness"]);
    let reflectance = row["in_reflectance"];
    material.ior = ior_of(0.16 * reflectance * reflectance);
    if coat {
        material.coat = row["in_clearCoat"];
        material.coat_roughness = row["in_clearCoatRoughness"];
        material.options.filament.coat_ior_change = on(row, "iorChange_on");
    }
    let model = if on(row, "mobile") { ShadingModel::FilamentMobile } else { ShadingModel::Filament };
    Some((material, model, vector(row, "out_color")))
}

fn filament_2018(row: &Row) -> Told {
    if row["in_modifyF0"] != 1.0 {
        return None;
    }
    let mut material = metallic(row, "in_baseColor", row["in_metallic"], row["in_perceptualRoughness"]);
    material.ior = ior_of(0.16 * row["in_reflectance"] * row["in_reflectance"]);
    material.coat = row["in_clearCoat"];
    if material.coat == 0.0 {
        return None;
    }
    material.coat_roughness = row["in_clearCoatPerceptualRoughness"];
    // Every other row in the other form.
    let single = row["row"] as u32 % 2 == 1;
    material.options.filament_2018.single_attenuation = single;
    let out = vector(row, if single { "out_litFormB" } else { "out_litFormA" });
    Some((material, ShadingModel::Filament2018, out))
}

fn three(row: &Row) -> Told {
    let coat = on(row, "clearcoat_on");
    if coat && !same(row, "in_N", "in_Ncc") || on(row, "anisotropy_on") {
        return None;
    }
    let mut material = metallic(row, "in_diffuse", row["in_metalness"], row["in_roughness"]);
    material.ior = row["in_ior"];
    material.specular = row["in_specularIntensity"];
    material.specular_color = vector(row, "in_specularColor");
    if coat {
        material.coat = row["in_clearcoat"];
        material.coat_roughness = row["in_clearcoatRoughness"];
    }
    if on(row, "sheen_on") {
        material.lobes.sheen.color = vector(row, "in_sheenColor").into();
        material.lobes.sheen.roughness = row["in_sheenRoughness"].into();
    }
    if on(row, "iridescence_on") {
        material.lobes.iridescence.mask = row["in_iridescence"].into();
        material.lobes.iridescence.ior = row["in_iridescenceIOR"];
        material.lobes.iridescence.thickness = [row["in_iridescenceThickness"]; 2];
    }
    Some((material, ShadingModel::Three, vector(row, "out_outgoing")))
}

fn three_legacy(row: &Row, r119: bool) -> Told {
    let coat = on(row, "clearcoat_on");
    if coat && !same(row, "in_N", "in_Ncc") {
        return None;
    }
    let mut material = metallic(row, "in_diffuse", row["in_metalness"], row["in_roughness"]);
    let reflectivity = row["in_reflectivity"];
    material.ior = ior_of(0.16 * reflectivity * reflectivity);
    material.options.three.r119 = r119;
    if !r119 {
        material.specular = row["in_specularIntensity"];
        material.specular_color = vector(row, "in_specularTint");
    }
    if coat {
        material.coat = row["in_clearcoat"];
        material.coat_roughness = row["in_clearcoatRoughness"];
    }
    if row.get("in_sheen_on") == Some(&1.0) {
        material.lobes.sheen.color = vector(row, "in_sheenColor").into();
    }
    Some((material, ShadingModel::ThreeLegacy, vector(row, "out_outgoing")))
}

fn gltf(row: &Row) -> Told {
    let coat = on(row, "clearcoat_on");
    // The albedo of the sheen is given in the row.
    if coat && !same(row, "in_N", "in_Nc") || on(row, "anisotropy_on") || on(row, "sheen_on") {
        return None;
    }
    let mut material = metallic(row, "in_baseColor", row["in_metallic"], row["in_roughness"]);
    material.ior = row["in_ior"];
    if on(row, "specular_on") {
        material.specular = row["in_specularFactor"];
        material.specular_color = vector(row, "in_specularColor");
    }
    if coat {
        material.coat = row["in_clearcoat"];
        material.coat_roughness = row["in_clearcoatRoughness"];
    }
    if on(row, "iridescence_on") {
        material.lobes.iridescence.mask = row["in_iridescence"].into();
        material.lobes.iridescence.ior = row["in_iridescenceIor"];
        material.lobes.iridescence.thickness = [row["in_iridescenceThickness"]; 2];
    }
    Some((material, ShadingModel::Gltf, vector(row, "out_color")))
}

/// Directional albedos are given in the rows: bare metals have none.
fn openpbr(row: &Row) -> Told {
    if row["in_metalness"] != 1.0 || row["in_coatWeight"] != 0.0 {
        return None;
    }
    let weight = row["in_baseWeight"];
    let mut material = metallic(row, "in_baseColor", 1.0, row["in_specularRoughness"]);
    for channel in &mut material.base_color[..3] {
        *channel *= weight;
    }
    material.ior = row["in_specularIor"];
    material.specular = row["in_specularWeight"];
    material.specular_color = vector(row, "in_specularColor");
    material.lobes.anisotropy.strength = row["in_specularAnisotropy"];
    material.options.openpbr.single_scattering = true;
    Some((material, ShadingModel::OpenPbr, vector(row, "out_lit")))
}

const CASES: &[Case] = &[
    Case { table: "unity/hdrp_lit_coat", told: hdrp_lit, irradiance: |_| 1.0, relative: 1e-3, least: 40 },
    Case { table: "unity/stacklit_direct", told: stacklit, irradiance: |_| 1.0, relative: 1e-3, least: 100 },
    Case {
        table: "web/filament_direct",
        told: filament,
        irradiance: |row| row["in_lightAttenuation"],
        // The rows' table has 64 rows of roughness, the renderer's 128 as the engine ships it, each off by one row.
        relative: 2e-2,
        least: 60,
    },
    Case { table: "web/filament2018", told: filament_2018, irradiance: |_| 1.0, relative: 0.0, least: 40 },
    Case {
        table: "web/threejs_current_direct",
        told: three,
        irradiance: |_| 1.0,
        relative: 2e-3,
        least: 100,
    },
    Case {
        table: "web/threejs_legacy_direct",
        told: |row| three_legacy(row, true),
        irradiance: legacy_irradiance,
        relative: 0.0,
        least: 80,
    },
    Case {
        table: "web/threejs_r131_direct",
        told: |row| three_legacy(row, false),
        irradiance: legacy_irradiance,
        relative: 0.0,
        least: 60,
    },
    Case { table: "web/gltf_khronos_direct", told: gltf, irradiance: |_| 1.0, relative: 0.0, least: 60 },
    Case { table: "web/openpbr_coat", told: openpbr, irradiance: |_| 1.0, relative: 0.0, least: 10 },
];

/// Irradiance per unit of a light's colour: pi unless lights are physical.
fn legacy_irradiance(row: &Row) -> f32 {
    if row["in_physicallyCorrectLights"] == 1.0 { 1.0 } else { std::f32::consts::PI }
}

#[test]
fn every_engine_reproduces_its_tables() {
    let mut renderer = Renderer::new(1);
    let mut failures = Vec::new();
    for case in CASES {
        let mut compared = 0;
        for row in rows(case.table) {
            let (normal, view) = (vector(&row, "in_N"), vector(&row, "in_V"));
            if row["hazard"] != 0.0 || dot(normal, view) < 0.1 {
                continue;
            }
            let Some((material, model, expected)) = (case.told)(&row) else { continue };
            let mut scene = Scene::new();
            let source = EnvironmentSource::None;
            scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
            // Numbers that a scene does not admit are no row of its.
            let Ok(material) = scene.add_material(material) else { continue };
            let mesh = scene.add_mesh(Mesh::new(quad(&row)).unwrap()).unwrap();
            scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
            let color = vector(&row, "in_lightColor").map(|c| c * (case.irradiance)(&row));
            let direction = vector(&row, "in_L").map(|v| -v);
            scene
                .add_light(Light::new(LightKind::Directional { direction }).with(|l| {
                    l.color = color;
                    l.intensity = 1.0;
                }))
                .unwrap();
            let found = render(&mut renderer, &scene, &row, model);
            for k in 0..3 {
                let scale = expected[k].abs();
                let conditioning = row["f32_f64_maxrel"] * scale.max(1e-3);
                let tolerance = 1e-6 + (2e-4 + case.relative) * scale + 64.0 * conditioning;
                // A frame holds no negative light.
                let expected = if expected[k] > 0.0 { expected[k] } else { 0.0 };
                let error = (found[k] - expected).abs();
                if error.is_nan() || error > tolerance {
                    failures.push(format!(
                        "{} row {}: channel {k} is {} instead of {expected}",
                        case.table, row["row"], found[k]
                    ));
                }
            }
            compared += 1;
        }
        println!("{}: {compared} rows", case.table);
        if compared < case.least {
            failures.push(format!("{}: only {compared} rows", case.table));
        }
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}
