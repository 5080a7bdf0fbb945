//! Physics of light that passes through surfaces: what is known of a pane before a wall.

use crate::common::shapes;
use overcoat::frame::Frame;
use overcoat::render::{Background, RenderOptions, Renderer};
use overcoat::scene::{
    AlphaMode, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, LightKind, Material,
    Mesh, MeshData, Projection, Scene, ShadingModel, Transform, Transmission, Workflow,
};
use overcoat_core::math::double;
use std::sync::Arc;

const SIDE: usize = 64;

/// Sees the square of side 2 around the origin along -Z.
fn camera() -> Camera {
    Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Orthographic { height: 2.0 }, 0.01)
}

/// A surface of index 1, which reflects nothing.
fn clear(transmission: Transmission) -> Material {
    Material::default().with(|m| {
        m.ior = 1.0;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.0, texture: None };
        m.lobes.transmission = transmission;
    })
}

fn through() -> Transmission {
    Transmission::default().with(|t| t.factor = 1.0.into())
}

struct Box {
    scene: Scene,
}

impl Box {
    fn new() -> Self {
        let mut scene = Scene::new();
        let dark = Environment::default().with(|e| e.source = EnvironmentSource::None);
        scene.set_environment(dark).unwrap();
        Self { scene }
    }

    fn place(mut self, mesh: MeshData, material: Material, transform: Transform) -> Self {
        let mesh = self.scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
        let material = self.scene.add_material(material).unwrap();
        self.scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
        self
    }

    /// A wall at z = -2, of vertex colours `color(x)` from left to right.
    fn wall(self, columns: u32, color: impl Fn(f32) -> [f32; 3]) -> Self {
        let mut mesh = shapes::square(columns);
        mesh.colors = mesh.positions.iter().map(|p| color(p[0])).map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let unlit = Material::default().with(|m| m.unlit = true);
        self.place(
            mesh,
            unlit,
            Transform::from_parts([0.0, 0.0, -2.0], [0.0, 0.0, 0.0, 1.0], [4.0; 3]).unwrap(),
        )
    }

    /// A pane over everything.
    fn pane(self, z: f64, material: Material) -> Self {
        self.place(shapes::square(1), material, Transform::translation([0.0, 0.0, z]).unwrap())
    }

    fn render(&self, options: RenderOptions) -> Vec<[f32; 4]> {
        self.frame(options).pixels
    }

    fn frame(&self, options: RenderOptions) -> Frame {
        let size = SIDE as u32;
        let options = options.with_width(size).with_height(size);
        Renderer::new(1).render(&self.scene, &camera(), &options).unwrap().frame
    }

    fn pixels(&self) -> Vec<[f32; 4]> {
        self.render(RenderOptions::draft(512, 512).with_samples(1))
    }
}

fn stripes(x: f32) -> [f32; 3] {
    [0.5 + 0.5 * x / 4.0, 0.3, 0.8 - 0.1 * x]
}

fn assert_close(a: &[[f32; 4]], b: &[[f32; 4]], tolerance: f32, what: &str) {
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        for c in 0..4 {
            assert!((a[c] - b[c]).abs() <= tolerance, "{what}: pixel {k} is {a:?} and not {b:?}");
        }
    }
}

#[test]
fn a_clear_pane_is_invisible_in_every_model_and_way() {
    let wall = Box::new().wall(8, stripes);
    let expected = wall.pixels();
    for &model in ShadingModel::ALL {
        let shading = Some(model);
        let options = RenderOptions::draft(512, 512).with_samples(1).with_shading(shading);
        // As a thin wall exactly, as a volume through the backdrop.
        let thin = Box::new().wall(8, stripes).pane(0.0, clear(through()));
        assert_close(&thin.render(options.clone()), &expected, 1e-6, model.name());
        let deep = clear(through().with(|t| t.thickness = 0.5.into()));
        let deep = Box::new().wall(8, stripes).pane(0.0, deep);
        assert_close(&deep.render(options), &expected, 2e-6, model.name());
    }
}

#[test]
fn tints_multiply_layer_by_layer() {
    let tint = |r, g, b| clear(through()).with(|m| m.base_color = [r, g, b, 1.0]);
    let expected: Vec<[f32; 4]> = Box::new()
        .wall(8, stripes)
        .pixels()
        .into_iter()
        .map(|[r, g, b, a]| [r * 0.45, g * 0.08, b * 0.42, a])
        .collect();
    let (near, far) = (tint(0.9, 0.2, 0.7), tint(0.5, 0.4, 0.6));
    let seen = Box::new().wall(8, stripes).pane(0.5, near.clone()).pane(-0.5, far.clone());
    assert_close(&seen.pixels(), &expected, 1e-6, "near first");
    let seen = Box::new().pane(-0.5, far).pane(0.5, near).wall(8, stripes);
    assert_close(&seen.pixels(), &expected, 1e-6, "far first");
}

#[test]
fn a_volume_absorbs_by_beer_and_lambert_and_scales_with_its_mesh() {
    let absorbing = through().with(|t| {
        t.thickness = 0.75.into();
        t.attenuation_color = [0.5, 0.9, 0.1];
        t.attenuation_distance = 0.5;
    });
    // Twice as large: 1.5 of the world's units, three times the distance.
    let big = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [2.0; 3]).unwrap();
    let seen = Box::new().wall(8, stripes).place(shapes::square(1), clear(absorbing), big);
    let expected: Vec<[f32; 4]> = Box::new()
        .wall(8, stripes)
        .pixels()
        .into_iter()
        .map(|[r, g, b, a]| [r * 0.125, g * 0.729, b * 0.001, a])
        .collect();
    assert_close(&seen.pixels(), &expected, 1e-5, "three distances");
}

/// Position along the middle row at which the wall's edge at x = 0 is seen.
fn edge(pixels: &[[f32; 4]]) -> f32 {
    let row = &pixels[SIDE * SIDE / 2..][..SIDE];
    let dark = row.iter().filter(|p| p[0] < 0.25).count();
    dark as f32 * (2.0 / SIDE as f32) - 1.0
}

#[test]
fn a_tilted_slab_shifts_what_is_behind_it_by_snells_law() {
    // Black left of 0, white right of it.
    let mut wall = shapes::square(1);
    wall.positions.iter_mut().for_each(|p| p[0] = (p[0] + 1.0) * 0.5);
    let white = Material::default().with(|m| m.unlit = true);
    let behind = Transform::from_parts([0.0, 0.0, -2.0], [0.0, 0.0, 0.0, 1.0], [4.0; 3]).unwrap();
    let black = Material::default().with(|m| {
        m.unlit = true;
        m.base_color = [0.0, 0.0, 0.0, 1.0];
    });
    let (tilt, thickness) = (45.0_f64.to_radians(), 0.6);
    let (sin_tilt, cos_tilt) = double::sin_cos(tilt);
    for ior in [1.0, 1.33, 1.5, 2.4] {
        let slab = clear(through().with(|t| t.thickness = thickness.into())).with(|m| m.ior = ior);
        let (sin, cos) = double::sin_cos(0.5 * tilt);
        let turned = Transform::from_parts([0.0; 3], [0.0, sin, 0.0, cos], [2.0; 3]).unwrap();
        let seen = Box::new()
            .place(shapes::square(1), black.clone(), Transform::translation([0.0, 0.0, -3.0]).unwrap())
            .place(wall.clone(), white.clone(), behind)
            .place(shapes::square(1), slab, turned);
        // The slab's normal points to +X: rays inside bend towards -X by the difference of the angles. The mesh is twice as
        // large, and its volume twice as thick.
        let sin_inside = sin_tilt / f64::from(ior);
        let bend = sin_tilt * (1.0 - sin_inside * sin_inside).sqrt() - cos_tilt * sin_inside;
        let shift = 2.0 * f64::from(thickness) * bend;
        let at = edge(&seen.pixels());
        assert!((f64::from(at) - shift).abs() < 0.035, "index {ior}: edge at {at}, expected at {shift}");
    }
}

#[test]
fn a_picture_without_background_stays_open_behind_glass() {
    let tinted = clear(through()).with(|m| m.base_color = [0.9, 0.6, 0.3, 1.0]);
    let rough = tinted
        .clone()
        .with(|m| m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.5, texture: None });
    for material in [tinted.clone(), rough] {
        for p in Box::new().pane(0.0, material.clone()).pixels() {
            assert!((p[3] - 0.4).abs() < 2e-3, "1 less the mean of the tint is 0.4, not {}", p[3]);
            assert!(p[..3].iter().all(|&v| v == 0.0), "nothing to see in the dark: {p:?}");
        }
        // Half there, it hides half as much.
        let half = material.with(|m| {
            m.base_color = [0.9, 0.6, 0.3, 0.5];
            m.alpha_mode = AlphaMode::Blend;
        });
        for p in Box::new().pane(0.0, half).pixels() {
            assert!((p[3] - 0.2).abs() < 2e-3, "{p:?}");
        }
    }
}

/// Light of any colour behind the picture, let through by its transmittance, is a wall of that colour behind the scene.
#[test]
fn what_is_put_behind_a_picture_looks_like_a_wall_behind_the_scene() {
    let tint = |r, g, b, a| clear(through()).with(|m| m.base_color = [r, g, b, a]);
    let rough = |material: Material| {
        material.with(|m| {
            m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.4, texture: None };
            m.ior = 1.3;
        })
    };
    let blended = Material::default().with(|m| {
        m.base_color = [0.2, 0.7, 0.1, 0.6];
        m.alpha_mode = AlphaMode::Blend;
    });
    let deep = through().with(|t| {
        t.thickness = 0.3.into();
        t.attenuation_color = [0.3, 0.9, 0.5];
        t.attenuation_distance = 0.4;
        t.dispersion = 5.0;
    });
    let deep = clear(deep).with(|m| m.ior = 1.6);
    let flap = Transform::from_parts([0.3, 0.2, -0.7], [0.0, 0.0, 0.6, 0.8], [0.5; 3]).unwrap();
    let opaque = Material::default().with(|m| {
        m.unlit = true;
        m.base_color = [0.7, 0.1, 0.2, 1.0];
    });
    let red = tint(0.9, 0.1, 0.2, 1.0);
    let half = tint(0.3, 0.9, 0.2, 0.5).with(|m| m.alpha_mode = AlphaMode::Blend);
    let layers: [&[&Material]; 7] =
        [&[&red], &[&red, &blended], &[&half, &red], &[&deep], &[&deep, &blended], &[&blended, &half], &[]];
    for samples in [1, 8] {
        let options = RenderOptions::draft(512, 512).with_samples(samples);
        for (number, layers) in layers.iter().enumerate() {
            for is_rough in [false, true] {
                // Panes at different heights, so that pixels have one, several and none, and edges of what is opaque.
                let build = |mut scene: Box| {
                    scene = scene.place(shapes::square(1), opaque.clone(), flap);
                    for (k, &material) in layers.iter().enumerate() {
                        let at = [0.4 * k as f64 - 0.37, 0.1, 0.3 * k as f64];
                        let at = Transform::from_parts(at, [0.0, 0.0, 0.28, 0.96], [0.8; 3]).unwrap();
                        let material = material.clone();
                        let material = if is_rough { rough(material) } else { material };
                        scene = scene.place(shapes::square(1), material, at);
                    }
                    scene
                };
                let open = build(Box::new()).frame(options.clone());
                let transmits = layers.iter().any(|material| material.lobes.transmission.factor.factor > 0.0);
                assert_eq!(open.transmittance.len(), if transmits { SIDE * SIDE } else { 0 });
                for color in [[1.0, 1.0, 1.0], [0.0, 0.5, 1.0]] {
                    let composed: Vec<[f32; 4]> = (0..SIDE * SIDE)
                        .map(|k| {
                            let [r, g, b, a] = open.pixels[k];
                            let [x, y, z] = open.transmittance.get(k).copied().unwrap_or([1.0 - a; 3]);
                            let mean = (x + y + z) / 3.0;
                            assert!((1.0 - mean - a).abs() < 1e-6, "{number}: {x} {y} {z}, opacity {a}");
                            [r + x * color[0], g + y * color[1], b + z * color[2], 1.0]
                        })
                        .collect();
                    let wall = build(Box::new().wall(8, |_| color)).render(options.clone());
                    assert_close(
                        &composed,
                        &wall,
                        4e-5,
                        &format!("{number}, rough {is_rough}, {samples} samples"),
                    );
                }
            }
        }
    }
}

#[test]
fn glass_in_a_white_furnace_is_white() {
    for (roughness, thickness, bound) in
        [(0.0, 0.0, 2e-3), (0.0, 0.4, 2e-3), (0.3, 0.0, 0.02), (0.7, 0.4, 0.05)]
    {
        for coat in [0.0, 1.0] {
            let mut scene = Box::new();
            let white = EquirectImage::new(4, 2, vec![[1.0; 3]; 8]).unwrap();
            let source = EnvironmentSource::Image(Arc::new(white));
            scene.scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
            let workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
            let glass = through().with(|t| t.thickness = thickness.into());
            let material = clear(glass).with(|m| {
                m.ior = 1.5;
                m.workflow = workflow;
                m.coat = coat;
            });
            let seen = scene.pane(0.0, material);
            let options = RenderOptions::draft(512, 512)
                .with_samples(1)
                .with_shading(ShadingModel::Gltf)
                .with_background(Background::Environment);
            for p in seen.render(options) {
                for v in &p[..3] {
                    assert!((v - 1.0).abs() < bound, "roughness {roughness}, coat {coat}: {p:?}");
                }
            }
        }
    }
}

#[test]
fn rough_glass_blurs_and_keeps_the_mean() {
    let split = |x: f32| if x < 0.0 { [0.0; 3] } else { [1.0; 3] };
    let contrast = |roughness: f32| {
        let workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
        // An index of 1 would not scatter; the specular weight takes the reflection away.
        let frosted = clear(through()).with(|m| {
            m.ior = 1.5;
            m.specular = 0.0;
            m.workflow = workflow;
        });
        let pixels = Box::new().wall(64, split).pane(0.0, frosted).pixels();
        let row = &pixels[SIDE * SIDE / 2..][..SIDE];
        let mean = row.iter().map(|p| p[0]).sum::<f32>() / SIDE as f32;
        (row[SIDE - 4][0] - row[3][0], row[SIDE / 2 + 4][0] - row[SIDE / 2 - 6][0], mean)
    };
    let (_, mut sharpness, first) = contrast(0.0);
    assert!(sharpness > 0.99);
    for roughness in [0.3, 0.5, 0.7, 1.0] {
        let (_, edge, mean) = contrast(roughness);
        assert!(edge <= sharpness + 1e-6, "roughness {roughness}: {edge} after {sharpness}");
        assert!((mean - first).abs() < 0.05, "roughness {roughness}: mean {mean} of {first}");
        sharpness = edge;
    }
    assert!(sharpness < 0.2, "fully rough glass shows the mean: {sharpness}");
}

#[test]
fn paper_glows_with_the_light_behind_it() {
    let intensity = 2.0;
    let light = |z: f32| {
        Light::new(LightKind::Directional { direction: [0.0, 0.0, z] }).with(|l| {
            l.color = [1.0; 3];
            l.intensity = intensity;
        })
    };
    let paper = |diffuse: f32, model| {
        let mut front_and_back = [0.0; 2];
        for (seen, z) in front_and_back.iter_mut().zip([-1.0, 1.0]) {
            let mut material = Material::default().with(|m| m.specular = 0.0);
            material.lobes.transmission.diffuse.factor = diffuse;
            let mut scene = Box::new().pane(0.0, material);
            scene.scene.add_light(light(z)).unwrap();
            let options = RenderOptions::draft(512, 512).with_samples(1).with_shading(model);
            *seen = scene.render(options)[SIDE * SIDE / 2 + SIDE / 2][0];
        }
        front_and_back
    };
    let lambert = intensity / std::f32::consts::PI;
    let close = |a: f32, b: f32| (a - b).abs() < 0.01 * lambert;
    for diffuse in [0.0, 0.25, 1.0] {
        let [front, back] = paper(diffuse, ShadingModel::Gltf);
        assert!(close(front, lambert * (1.0 - diffuse)), "{diffuse}: {front} of {lambert} before");
        assert!(close(back, lambert * diffuse), "{diffuse}: {back} of {lambert} behind");
    }
}

#[test]
fn limits_let_through_the_same_whatever_the_tiles() {
    let mut scene = Box::new().wall(32, stripes);
    let glass = clear(through().with(|t| t.thickness = 0.5.into()));
    let small = Transform::from_parts([0.3, 0.2, 0.0], [0.0, 0.0, 0.0, 1.0], [0.2; 3]).unwrap();
    scene = scene.place(shapes::square(4), glass, small);
    let fragments = |tile: u32, limit: u64| {
        let mut options = RenderOptions::draft(512, 512).with_tile_size(Some(tile));
        options.limits.fragments = limit;
        options.width = SIDE as u32;
        options.height = SIDE as u32;
        Renderer::new(1).render(&scene.scene, &camera(), &options).map(|r| r.stats.fragments)
    };
    let count = fragments(16, u64::MAX).unwrap();
    for tile in [16, 32, 64] {
        assert_eq!(fragments(tile, count), Ok(count), "tiles of {tile}");
        assert!(fragments(tile, count - 1).is_err());
    }
}
