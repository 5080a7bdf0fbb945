//! Cost of each shading model: sixteen fragments of a coated paint under one light and the studio, from the planes of
//! the G-buffer to radiance.
//!
//! Figures are per fragment: `cargo bench -p overcoat-benches --bench models`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use overcoat::scene::{
    AreaLightMethod, CoatMedium, Light, LightKind, Lobes, Material, SecondLobe, ShadingModel, Workflow,
};
use overcoat_core::math::lanes::{Float, LANES, SimdLevel};
use overcoat_stages::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_stages::light::{EnvironmentLight, PrefilteredEnvironment, PunctualLight};
use overcoat_stages::shade::{ShadeContext, ViewRays, shade};
use std::hint::black_box;

/// Sixteen places on a ball, seen from +Z.
fn planes(material: &Material) -> SurfacePlanes {
    let mut planes = SurfacePlanes::default();
    let mut put = |plane: Plane, lane: usize, values: &[f32]| {
        for (n, value) in values.iter().enumerate() {
            planes.rows[plane.first + n][lane] = *value;
        }
    };
    for k in 0..LANES {
        let (x, y) = ((k % 4) as f32 * 0.4 - 0.6, (k / 4) as f32 * 0.4 - 0.6);
        let z = (1.0 - x * x - y * y).sqrt();
        let normal = [x, y, z];
        let across = (x * x + z * z).sqrt();
        let tangent = [z / across, 0.0, -x / across];
        put(layout::POSITION, k, &normal);
        put(layout::VIEW, k, &[0.0, 0.0, 1.0]);
        for plane in [layout::NORMAL, layout::COAT_NORMAL, layout::VERTEX_NORMAL] {
            put(plane, k, &normal);
        }
        put(layout::TANGENT, k, &tangent);
        put(layout::BITANGENT, k, &[y * tangent[2], z * tangent[0] - x * tangent[2], -y * tangent[0]]);
        put(layout::BASE_COLOR, k, &[0.6, 0.05, 0.04]);
        put(layout::SPECULAR_COLOR, k, &[1.0; 3]);
        put(layout::METALLIC, k, &[0.3]);
        put(layout::ROUGHNESS, k, &[0.2 + 0.03 * k as f32]);
        for plane in [layout::ALPHA, layout::SPECULAR_WEIGHT, layout::OCCLUSION] {
            put(plane, k, &[1.0]);
        }
        put(layout::COAT, k, &[material.coat]);
        put(layout::COAT_ROUGHNESS, k, &[0.1]);
        put(layout::COAT_THICKNESS, k, &[0.5]);
        put(layout::COAT_COLOR, k, &[1.0, 0.8, 0.6]);
        put(layout::SECOND_ROUGHNESS, k, &[0.6]);
        put(layout::LOBE_MIX, k, &[0.3]);
    }
    planes
}

fn models(criterion: &mut Criterion) {
    let coat = CoatMedium::default().with(|c| {
        c.thickness = 0.5.into();
        c.extinction = [0.1, 0.6, 0.6];
    });
    let second = SecondLobe::default().with(|s| s.mix = 0.3.into());
    let material = Material::default().with(|m| {
        m.coat = 1.0;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.3, roughness: 0.4, texture: None };
        m.lobes = Lobes::default().with(|l| {
            l.coat = coat;
            l.second = second;
        });
    });
    // StackLit as the others are: one lobe.
    let one_lobe = material.clone().with(|m| m.lobes = Lobes::default().with(|l| l.coat = coat));
    let planes = planes(&material);
    let filtered = PrefilteredEnvironment::studio();
    let environment = EnvironmentLight::new(&filtered, 0.0, 1.0);
    let direction = [0.6, -0.64, -0.48];
    let sun = Light::new(LightKind::Directional { direction }).with(|l| l.intensity = 2.0);
    let lights: Vec<PunctualLight> = PunctualLight::new(&sun).into_iter().collect();
    let context = ShadeContext {
        draws: &[],
        materials: &[],
        textures: &[],
        rays: ViewRays {
            eye: [0.0, 0.0, 4.0],
            right: [0.01, 0.0, 0.0],
            down: [0.0, -0.01, 0.0],
            centre: [0.0, 0.0, -1.0],
            forward: [0.0, 0.0, -1.0],
            principal: [0.0; 2],
            perspective: true,
        },
        environment: &environment,
        lights: &lights,
        area_lights: &[],
        model: None,
        area_light_method: AreaLightMethod::default(),
        anisotropy: 1,
        maps: 0,
        lamps: None,
        lobe_rays: 0,
        emitter_rays: 0,
        specular_antialiasing: false,
    };
    for level in SimdLevel::available() {
        let mut group = criterion.benchmark_group(format!("models/{level}"));
        group.throughput(Throughput::Elements(LANES as u64));
        let mut run = |name: &str, model: ShadingModel, material: &Material| {
            group.bench_function(name, |bencher| {
                bencher.iter(|| {
                    overcoat_core::dispatch!(level, l => {
                        let red = shade(l, &context, model, black_box(material), black_box(&planes)).x;
                        red.to_array()
                    })
                });
            });
        };
        for &model in ShadingModel::ALL {
            run(model.name(), model, &one_lobe);
        }
        run("stacklit, two lobes", ShadingModel::StackLit, &material);
    }
}

criterion_group!(benches, models);
criterion_main!(benches);
