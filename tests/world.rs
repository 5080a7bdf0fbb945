//! Scenes that change under names that stay, and pictures of them that follow each other: each is the picture that a scene made anew
//! has.

use crate::common::files::at_time;
use crate::common::scenes::motion;
use overcoat::frame::{DisplayOptions, PixelFormat, Target};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{AnimatedModel, BuiltinMaterial, Context, Format, Loaded, NoResolver};
use overcoat::render::{Cancellation, Ground, Quality, RenderError, RenderOptions, Renderer};
use overcoat::scene::{
    Axis, Camera, Environment, Framing, Light, Material, Mesh, Scene, Transform, Workflow, primitives,
};
use overcoat::viewport::{FrameBudget, Level, Orbit, Viewport};
use overcoat::world::{
    InstanceHandle, LightHandle, MaterialHandle, MeshHandle, TexturedMaterial, World, WorldError,
};

fn moved(x: f64, y: f64, z: f64) -> Transform {
    Transform::translation([x, y, z]).unwrap()
}

fn hash(renderer: &mut Renderer, scene: &Scene, quality: Quality) -> String {
    let camera = Framing::default().camera(scene);
    hash_from(renderer, scene, &camera, quality)
}

fn hash_from(renderer: &mut Renderer, scene: &Scene, camera: &Camera, quality: Quality) -> String {
    let options = RenderOptions::draft(72, 56).with_quality(quality).with_ground(Ground::Shadow);
    renderer.render(scene, camera, &options).unwrap().frame.frame_hash()
}

fn model(name: &str) -> Loaded {
    overcoat::load::model(format!("{}/../../assets/models/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn animated(model: &crate::common::files::model::Model) -> AnimatedModel {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    AnimatedModel::from_bytes(&model.glb(), Some(Format::Glb), &at_time(0.0), &context).unwrap()
}

#[test]
fn a_model_in_a_world_is_the_model() {
    for name in ["sports-car.glb", "vase.ply", "torus-knot.obj", "text-plate.glb"] {
        let loaded = model(name);
        let mut world = World::new();
        world.add_model(&loaded, Transform::IDENTITY).unwrap();
        let (mut one, mut other) = (Renderer::new(1), Renderer::new(2));
        assert_eq!(
            hash(&mut one, world.scene(), Quality::Fast),
            hash(&mut other, &loaded.scene, Quality::Fast),
            "{name}"
        );
    }
}

/// Skins, morph targets, nodes that move, materials and visibility: at any time the world is the scene of that time.
#[test]
fn a_pose_is_the_scene_of_that_time() {
    let jobs = Jobs::new(1);
    let models =
        [motion::skinned(), motion::morphing().unwrap(), motion::interpolated(), motion::pointed().unwrap()];
    for (number, model) in models.iter().enumerate() {
        let has_animation = number != 1;
        let (limits, context_jobs) = (Limits::default(), Jobs::new(1));
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &context_jobs };
        let source = if has_animation {
            animated(model)
        } else {
            AnimatedModel::from_bytes(&model.glb(), None, &Default::default(), &context).unwrap()
        };
        let reference = if has_animation {
            animated(model)
        } else {
            AnimatedModel::from_bytes(&model.glb(), None, &Default::default(), &context).unwrap()
        };
        let mut world = World::new();
        let place = moved(0.5, 0.0, 0.0);
        let (handle, _) = world.add_animated_model(source, place, &jobs).unwrap();
        let instances: Vec<InstanceHandle> = world.model_instances(handle).unwrap();
        let mut renderer = Renderer::new(1);
        for time in [0.0, 0.3, 1.0, 0.6, 2.0, 0.0] {
            world.set_pose(handle, time, &jobs).unwrap();
            let mut alone = World::new();
            let own = reference.at(time, &jobs).unwrap();
            alone.add_model(&own, place).unwrap();
            for quality in [Quality::Draft, Quality::Fast] {
                assert_eq!(
                    hash(&mut renderer, world.scene(), quality),
                    hash(&mut Renderer::new(1), alone.scene(), quality),
                    "model {number} at {time}"
                );
            }
            for instance in &instances {
                assert!(world.transform(*instance).is_ok(), "names stay");
            }
        }
        // Instances that the application hides stay hidden, those it removes stay away.
        world.set_visible(instances[0], false).unwrap();
        let shown = world.scene().instances().len();
        world.set_pose(handle, 0.3, &jobs).unwrap();
        assert!(world.scene().instances().len() <= shown);
        world.remove_instance(instances[0]).unwrap();
        world.set_pose(handle, 1.5, &jobs).unwrap();
        assert!(matches!(world.transform(instances[0]), Err(WorldError::Gone { what: "instance" })));
        world.remove_model(handle).unwrap();
        assert!(world.scene().instances().is_empty() && world.models().next().is_none());
        assert!(
            world.scene().meshes().iter().all(|mesh| mesh.positions().is_empty()),
            "memory is given back"
        );
    }
}

/// A world and, beside it, plain lists that say what is to be in it.
struct Pair {
    world: World,
    meshes: Vec<(MeshHandle, Mesh)>,
    materials: Vec<(MaterialHandle, Material)>,
    lights: Vec<(LightHandle, Light)>,
    /// Mesh, material, place and whether it is shown, in the order of drawing.
    instances: Vec<(InstanceHandle, usize, usize, Transform, bool)>,
}

impl Pair {
    fn new() -> Self {
        let mut world = World::new();
        let mut meshes = Vec::new();
        for mesh in [primitives::cuboid([0.8; 3]), primitives::sphere(0.5, 24), primitives::plane([1.0, 1.5])]
        {
            let mesh = mesh.unwrap();
            meshes.push((world.add_mesh(mesh.clone()).unwrap(), mesh));
        }
        let mut materials = Vec::new();
        for (red, metallic) in [(0.8, 0.0), (0.2, 1.0), (0.5, 0.3)] {
            let workflow = Workflow::MetallicRoughness { metallic, roughness: 0.4, texture: None };
            let base_color = [red, 0.3, 0.9 - red, 1.0];
            let material = Material::default().with(|m| {
                m.base_color = base_color;
                m.workflow = workflow;
                m.double_sided = true;
            });
            materials.push((world.add_material(material.clone()).unwrap(), material));
        }
        Self { world, meshes, materials, lights: Vec::new(), instances: Vec::new() }
    }

    /// The scene that the lists are.
    fn scene(&self) -> Scene {
        let mut scene = Scene::new();
        let meshes: Vec<_> =
            self.meshes.iter().map(|(_, mesh)| scene.add_mesh(mesh.clone()).unwrap()).collect();
        let materials: Vec<_> =
            self.materials.iter().map(|(_, m)| scene.add_material(m.clone()).unwrap()).collect();
        for (object, (_, mesh, material, transform, shown)) in self.instances.iter().enumerate() {
            if *shown {
                let (mesh, material) = (meshes[*mesh], materials[*material]);
                let instance =
                    overcoat::scene::Instance::new(mesh, material, *transform).with_object(object as u32);
                scene.add_instance(instance).unwrap();
            }
        }
        for (_, light) in &self.lights {
            scene.add_light(*light).unwrap();
        }
        scene
    }

    fn step(&mut self, number: &mut impl FnMut(usize) -> usize) {
        let place = |number: &mut dyn FnMut(usize) -> usize| {
            moved(number(9) as f64 * 0.4, number(5) as f64 * 0.4, number(9) as f64 * 0.4)
        };
        let count = self.instances.len();
        match number(11) {
            0..3 => {
                let (mesh, material, transform) = (number(self.meshes.len()), number(3), place(number));
                let (of, made) = (self.meshes[mesh].0, self.materials[material].0);
                let own = self.world.add_instance(of, made, transform).unwrap();
                self.instances.push((own, mesh, material, transform, true));
            }
            3 if count > 0 => {
                let (gone, ..) = self.instances.remove(number(count));
                self.world.remove_instance(gone).unwrap();
                assert!(matches!(self.world.set_visible(gone, true), Err(WorldError::Gone { .. })));
            }
            4 if count > 0 => {
                let (own, .., transform, _) = &mut self.instances[number(count)];
                *transform = place(number);
                self.world.set_transform(*own, *transform).unwrap();
            }
            5 if count > 0 => {
                let (own, .., shown) = &mut self.instances[number(count)];
                *shown = !*shown;
                self.world.set_visible(*own, *shown).unwrap();
            }
            6 if count > 0 => {
                let (own, mesh, material, ..) = &mut self.instances[number(count)];
                (*mesh, *material) = (number(self.meshes.len()), number(3));
                self.world.set_instance_mesh(*own, self.meshes[*mesh].0).unwrap();
                self.world.set_instance_material(*own, self.materials[*material].0).unwrap();
            }
            7 => {
                let (own, material) = &mut self.materials[number(3)];
                material.coat = number(3) as f32 * 0.5;
                self.world.set_material(*own, material.clone()).unwrap();
            }
            8 => {
                let (own, mesh) = &mut self.meshes[number(3)];
                *mesh = primitives::cuboid([0.3 + number(4) as f32 * 0.2; 3]).unwrap();
                self.world.set_mesh(*own, mesh.clone()).unwrap();
            }
            9 if self.lights.len() < 3 => {
                let light = Light::directional([number(3) as f32 - 1.0, -1.0, 0.5], 1.0 + number(2) as f32);
                self.lights.push((self.world.add_light(light).unwrap(), light));
            }
            10 if !self.lights.is_empty() => {
                let (gone, _) = self.lights.remove(number(self.lights.len()));
                self.world.remove_light(gone).unwrap();
                if let Some((own, light)) = self.lights.first_mut() {
                    light.intensity = 1.0 + number(4) as f32;
                    self.world.set_light(*own, *light).unwrap();
                }
            }
            _ => {}
        }
    }
}

/// Whatever is changed, in whatever order: a renderer that has drawn all states draws each as one that has seen nothing else.
#[test]
fn a_changed_world_is_drawn_as_a_scene_made_anew() {
    let mut state = 1_u32;
    let mut number = |below: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    };
    let mut pair = Pair::new();
    let mut renderer = Renderer::new(1);
    let camera = Camera::look_at([4.0, 3.0, 7.0], [1.5, 0.5, 1.5], [0.0, 1.0, 0.0]).unwrap();
    for step in 0..240 {
        pair.step(&mut number);
        let expected = pair.scene();
        let (seen, of_lists) = (pair.world.scene(), expected.instances());
        assert_eq!(seen.instances().len(), of_lists.len());
        for (k, (own, other)) in seen.instances().iter().zip(of_lists).enumerate() {
            assert_eq!(
                (own.transform, own.material, own.mesh),
                (other.transform, other.material, other.mesh)
            );
            let handle = pair.world.instance(k).unwrap();
            assert_eq!(handle, pair.instances[other.object as usize].0);
        }
        assert_eq!(seen.lights().len(), pair.lights.len());
        if step % 6 == 5 {
            let quality = if step % 24 == 23 { Quality::Good } else { Quality::Fast };
            let hashes = [
                hash_from(&mut renderer, pair.world.scene(), &camera, quality),
                hash_from(&mut Renderer::new(1), &expected, &camera, quality),
            ];
            // Lights are summed in the order of the list.
            if pair.world.scene().lights() == expected.lights() {
                assert_eq!(hashes[0], hashes[1], "after step {step}");
            }
        }
    }
}

#[test]
fn what_is_used_is_not_removed_and_what_is_refused_changes_nothing() {
    let mut world = World::new();
    let mesh = world.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
    let material = world.add_material(Material::default()).unwrap();
    let cube = world.add_instance(mesh, material, Transform::IDENTITY).unwrap();
    assert!(matches!(
        world.remove_mesh(mesh),
        Err(WorldError::InUse { what: "mesh", by: "instance", number: 0 })
    ));
    assert!(matches!(world.remove_material(material), Err(WorldError::InUse { .. })));
    let message = world.remove_mesh(mesh).unwrap_err().to_string();
    assert_eq!(message, "the mesh is in use, by instance 0");
    assert_eq!((world.instance_mesh(cube).unwrap(), world.visible(cube).unwrap()), (mesh, true));
    // Hidden ones need them too.
    world.set_visible(cube, false).unwrap();
    assert!(world.remove_mesh(mesh).is_err() && !world.visible(cube).unwrap());
    world.set_visible(cube, true).unwrap();
    // Too far away, then not moved.
    let far = moved(1e15, 0.0, 0.0);
    assert!(matches!(world.set_transform(cube, far), Err(WorldError::Scene(_))));
    assert_eq!(world.transform(cube).unwrap(), Transform::IDENTITY);
    assert!(world.add_instance(mesh, material, far).is_err());
    assert_eq!((world.scene().instances().len(), world.instances().count()), (1, 1));
    let other = World::new();
    assert!(matches!(other.transform(cube), Err(WorldError::Foreign { what: "instance" })));
    let dark = Material::default().with(|m| m.ior = -4.0);
    assert!(world.set_material(material, dark).is_err());
    world.remove_instance(cube).unwrap();
    world.remove_mesh(mesh).unwrap();
    world.remove_material(material).unwrap();
    assert!(matches!(
        world.add_instance(mesh, material, Transform::IDENTITY),
        Err(WorldError::Gone { what: "mesh" })
    ));
    // Their places are used again, under other names.
    let again = world.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
    assert_ne!(again, mesh);
    assert_eq!(world.scene().meshes().len(), 1);
}

/// Textures go with the last material that reads them, and their places are used again.
#[test]
fn textures_go_with_the_material_that_brought_them() {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let oak = BuiltinMaterial::named("varnished-oak").unwrap().load(&limits, &jobs).unwrap();
    let of = |world: &World| {
        TexturedMaterial::lay(
            world.scene().textures(),
            Material::default(),
            |error| error.to_string(),
            |scene| oak.assign(scene, None, &limits).map_err(|error| error.to_string()),
        )
        .unwrap()
    };
    let mut world = World::new();
    let material = world.add_textured_material(of(&world)).unwrap();
    let most = world.scene().textures().len();
    assert!(most > 0 && world.material(material).unwrap().textures().count() > 0);
    for _ in 0..4 {
        world.set_textured_material(material, of(&world)).unwrap();
        assert!(world.scene().textures().len() <= 2 * most);
    }
    // A copy reads them on when the first is gone.
    let copy = world.add_material(world.material(material).unwrap().clone()).unwrap();
    let read = world.material(copy).unwrap().textures().next().unwrap().texture;
    let width = |world: &World| world.scene().textures()[read.index()].image().width();
    let before = width(&world);
    world.remove_material(material).unwrap();
    assert_eq!(width(&world), before);
    assert!(matches!(world.set_textured_material(material, of(&world)), Err(WorldError::Gone { .. })));
    let plain = world.add_textured_material(of(&world)).unwrap();
    world.set_material(plain, Material::default()).unwrap();
    assert!(world.scene().textures().len() <= 3 * most);
}

#[test]
fn models_move_with_all_that_is_theirs() {
    let mut loaded = model("sports-car.glb");
    loaded.scene.add_light(Light::point([0.0, 3.0, 0.0], 50.0)).unwrap();
    loaded.scene.add_camera(Camera::look_at([0.0, 1.0, 8.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap()).unwrap();
    let mut world = World::new();
    let car = world.add_model(&loaded, Transform::IDENTITY).unwrap();
    let (mut one, mut other) = (Renderer::new(1), Renderer::new(1));
    // Seen from beside it, it is the same wherever it is: at powers of two nothing is rounded otherwise.
    let place = moved(4.0, 2.0, -8.0);
    world.set_model_transform(car, place).unwrap();
    let bounds = world.scene().bounds();
    let own = loaded.scene.bounds();
    for (k, by) in [4.0, 2.0, -8.0].into_iter().enumerate() {
        assert!((bounds.min[k] - own.min[k] - by).abs() < 1e-9);
    }
    let light = world.model_lights(car).unwrap()[0];
    assert_eq!(world.light(light).unwrap().kind, Light::point([4.0, 5.0, -8.0], 1.0).kind);
    assert_eq!(world.model_cameras(car).unwrap()[0].1.eye, [4.0, 3.0, 0.0]);
    world.set_model_transform(car, Transform::IDENTITY).unwrap();
    assert_eq!(hash(&mut one, world.scene(), Quality::Fast), hash(&mut other, &loaded.scene, Quality::Fast));
    world.set_model_visible(car, false).unwrap();
    assert!(!world.model_visible(car).unwrap());
    assert_eq!((world.scene().instances().len(), world.scene().lights().len()), (0, 1));
    world.set_model_visible(car, true).unwrap();
    assert!(world.model_visible(car).unwrap());
    assert_eq!(hash(&mut one, world.scene(), Quality::Fast), hash(&mut other, &loaded.scene, Quality::Fast));
    // Two of them have names of their own.
    let second = world.add_model(&loaded, place).unwrap();
    let parts = [world.model_instances(car).unwrap(), world.model_instances(second).unwrap()];
    assert!(parts[0].iter().all(|part| !parts[1].contains(part)));
    assert_eq!(world.model_of(parts[1][0]).unwrap(), Some(second));
    let objects: std::collections::BTreeSet<u32> =
        world.scene().instances().iter().map(|i| i.object).collect();
    let alone: std::collections::BTreeSet<u32> = loaded.scene.instances().iter().map(|i| i.object).collect();
    assert_eq!(objects.len(), 2 * alone.len());
    assert!(world.set_model_transform(car, moved(1e15, 0.0, 0.0)).is_err());
    assert_eq!(world.model_transform(car).unwrap(), Transform::IDENTITY);
    world.remove_model(car).unwrap();
    assert!(matches!(world.model_instances(car), Err(WorldError::Gone { what: "model" })));
    assert_eq!(world.model_instances(second).unwrap(), parts[1]);
}

#[test]
fn splats_belong_to_their_model() {
    let golden = crate::common::goldens().unwrap();
    let golden = golden.iter().find(|golden| golden.name() == "splats-and-surfaces").unwrap();
    let shot = crate::common::Shot::load(golden, Default::default(), &Jobs::new(1)).unwrap();
    let mut scene = shot.scene.clone();
    scene.clear_lights();
    let loaded = Loaded::from(scene.clone());
    let mut world = World::new();
    let first = world.add_model(&loaded, Transform::IDENTITY).unwrap();
    let expected = |scene: &Scene| hash_from(&mut Renderer::new(1), scene, &shot.camera, Quality::Draft);
    let alone = expected(&scene);
    world.set_environment(scene.environment().clone()).unwrap();
    assert_eq!(expected(world.scene()), alone);
    let second = world.add_model(&loaded, moved(0.3, 0.0, 0.0)).unwrap();
    assert_ne!(expected(world.scene()), alone);
    world.set_model_transform(first, moved(0.1, 0.0, 0.0)).unwrap();
    world.set_model_visible(second, false).unwrap();
    world.set_model_transform(first, Transform::IDENTITY).unwrap();
    assert_eq!(expected(world.scene()), alone);
    world.remove_model(first).unwrap();
    assert!(world.scene().splat_instances().is_empty());
    let count = world.scene().splats().len();
    let third = world.add_model(&loaded, Transform::IDENTITY).unwrap();
    assert_eq!(world.scene().splats().len(), count, "places are used again");
    assert_eq!(expected(world.scene()), alone);
    world.remove_model(third).unwrap();
    world.set_model_visible(second, true).unwrap();
    assert!(!world.scene().splat_instances().is_empty());
}

const SIZE: (u32, u32) = (72, 56);

fn viewport(quality: Quality) -> Viewport {
    let mut viewport = Viewport::new(Renderer::new(2));
    viewport.set_options(RenderOptions::draft(SIZE.0, SIZE.1));
    viewport.set_quality(quality);
    viewport
}

fn draw(scene: &Scene, camera: &Camera, quality: Quality, samples: u32) -> Vec<u8> {
    let options = RenderOptions::draft(SIZE.0, SIZE.1).with_samples(samples).with_quality(quality);
    let display = DisplayOptions::default();
    Renderer::new(1).render_image(scene, camera, &options, &display).unwrap().image.as_bytes().to_vec()
}

#[test]
fn pictures_become_better_until_nothing_is_better_and_begin_again_after_a_change() {
    let mut loaded = model("sports-car.glb");
    let mut viewport = viewport(Quality::Good);
    let mut orbit = Orbit::around(&loaded.scene, SIZE.0 as f32 / SIZE.1 as f32);
    let mut buffer = vec![0; 4 * (SIZE.0 * SIZE.1) as usize];
    let mut refine = |viewport: &mut Viewport, scene: &Scene, orbit: &Orbit| {
        let mut target = Target::new(&mut buffer, 4 * SIZE.0 as usize, PixelFormat::Rgba8);
        let drawn = viewport.refine(scene, &orbit.camera(), &mut target).unwrap();
        drawn.map(|drawn| (drawn.level.quality, drawn.is_final, buffer.clone()))
    };
    for change in 0..3 {
        match change {
            0 => {}
            1 => orbit.turn(0.4, -0.1),
            _ => loaded.scene.set_environment(Environment::default().with(|e| e.intensity = 0.5)).unwrap(),
        }
        for (quality, is_last) in [(Quality::Draft, false), (Quality::Fast, false), (Quality::Good, true)] {
            let (own, is_final, bytes) = refine(&mut viewport, &loaded.scene, &orbit).unwrap();
            assert_eq!((own, is_final), (quality, is_last));
            assert!(bytes == draw(&loaded.scene, &orbit.camera(), quality, 8), "{change} {quality:?}");
        }
        assert_eq!(refine(&mut viewport, &loaded.scene, &orbit), None);
    }
    // Another part of the picture has not been drawn yet.
    let mut part = vec![0; 4 * 16];
    let mut target = Target::new(&mut part, 16, PixelFormat::Rgba8).with_region(30, 20, 4, 4);
    assert!(viewport.refine(&loaded.scene, &orbit.camera(), &mut target).unwrap().is_some());
    // Another size, and the same again.
    viewport.resize(40, 30);
    let mut small = vec![0; 4 * 40 * 30];
    let mut target = Target::new(&mut small, 160, PixelFormat::Rgba8);
    let drawn = viewport.refine(&loaded.scene, &orbit.camera(), &mut target).unwrap().unwrap();
    assert_eq!(drawn.level, Level { quality: Quality::Draft, samples: 8, scale: 1 });
    // A cancelled picture is drawn again.
    let cancellation = Cancellation::new();
    viewport.renderer().cancel_by(Some(cancellation.clone()));
    cancellation.cancel();
    assert_eq!(
        viewport.refine(&loaded.scene, &orbit.camera(), &mut target).unwrap_err(),
        RenderError::Cancelled
    );
    viewport.renderer().cancel_by(None);
    let drawn = viewport.refine(&loaded.scene, &orbit.camera(), &mut target).unwrap().unwrap();
    assert_eq!(drawn.level.quality, Quality::Draft);
}

#[test]
fn a_budget_is_kept_by_counts_and_says_how() {
    let scene = model("sports-car.glb").scene;
    let orbit = Orbit::around(&scene, SIZE.0 as f32 / SIZE.1 as f32);
    let levels = |budget: u64| {
        let mut viewport = viewport(Quality::Good);
        viewport.set_budget(Some(FrameBudget::Work(budget)));
        let mut buffer = vec![0; 4 * (SIZE.0 * SIZE.1) as usize];
        let mut orbit = orbit;
        (0..6)
            .map(|_| {
                orbit.turn(0.01, 0.0);
                let mut target = Target::new(&mut buffer, 4 * SIZE.0 as usize, PixelFormat::Rgba8);
                let drawn = viewport.draw(&scene, &orbit.camera(), &mut target).unwrap();
                let level = drawn.level;
                if level.scale == 1 {
                    assert!(buffer == draw(&scene, &orbit.camera(), level.quality, level.samples));
                }
                level
            })
            .collect::<Vec<Level>>()
    };
    let (best, least) = (
        Level { quality: Quality::Good, samples: 8, scale: 1 },
        Level { quality: Quality::Draft, samples: 4, scale: 4 },
    );
    assert_eq!(levels(u64::MAX), [best; 6]);
    assert_eq!(levels(1), [least; 6]);
    let some = levels(6_000_000);
    assert!(some.iter().any(|level| *level != best && *level != least), "{some:?}");
    assert_eq!(levels(6_000_000), some, "again");
}

/// A picture of fewer pixels shows the same at the same place, and is refined to the picture of all pixels.
#[test]
fn pictures_of_fewer_pixels_are_alike_and_refined() {
    let scene = model("sports-car.glb").scene;
    let orbit = Orbit::around(&scene, SIZE.0 as f32 / SIZE.1 as f32);
    let (width, height) = (4 * SIZE.0, 4 * SIZE.1);
    let mut viewport = viewport(Quality::Draft);
    viewport.resize(width, height);
    let stride = 4 * width as usize;
    let mut whole = vec![0; stride * height as usize];
    // A straight colour of a pixel that is hardly covered says nothing of what is seen.
    let format = PixelFormat::Rgba8Premultiplied;
    let mut target = Target::new(&mut whole, stride, format);
    assert_eq!(viewport.draw(&scene, &orbit.camera(), &mut target).unwrap().level.scale, 1);
    viewport.set_budget(Some(FrameBudget::Work(1)));
    let mut coarse = vec![0; stride * height as usize];
    let mut target = Target::new(&mut coarse, stride, format);
    let drawn = viewport.draw(&scene, &orbit.camera(), &mut target).unwrap();
    assert_eq!((drawn.level.scale, drawn.is_final), (4, false));
    // Three quarters of the pixels and more are within a sixteenth; none of the object is missing.
    let near = whole.chunks(4).zip(coarse.chunks(4));
    let near = near.filter(|(a, b)| a.iter().zip(*b).all(|(a, b)| a.abs_diff(*b) <= 16)).count();
    assert!(near * 100 > 75 * (width * height) as usize, "{near} of {}", width * height);
    let mean = |bytes: &[u8]| bytes.iter().map(|byte| f64::from(*byte)).sum::<f64>() / bytes.len() as f64;
    assert!((mean(&whole) - mean(&coarse)).abs() < 1.0, "{} {}", mean(&whole), mean(&coarse));
    // A part of a picture, and linear light, have all pixels.
    let mut part = vec![0; 4 * 16];
    let mut target = Target::new(&mut part, 16, format).with_region(30, 20, 4, 4);
    assert_eq!(viewport.draw(&scene, &orbit.camera(), &mut target).unwrap().level.scale, 1);
    let mut target = Target::new(&mut coarse, stride, format);
    viewport.draw(&scene, &orbit.camera(), &mut target).unwrap();
    let refined = viewport.refine(&scene, &orbit.camera(), &mut target).unwrap().unwrap();
    assert!(refined.is_final && refined.level.scale == 1);
    assert!(coarse == whole);
    assert!(
        viewport
            .refine(&scene, &orbit.camera(), &mut Target::new(&mut coarse, stride, format))
            .unwrap()
            .is_none()
    );
}

/// Positions are those of the file, wherever its zero is and whatever is up in it.
#[test]
fn the_first_model_says_where_zero_is() {
    let loaded = model("vase.ply");
    let mut world = World::new();
    world.add_model(&loaded, Transform::IDENTITY).unwrap();
    assert_eq!(world.scene().orientation(), loaded.scene.orientation());
    assert_eq!(world.scene().origin(), loaded.scene.origin());
    assert_ne!(loaded.scene.orientation().up, Axis::NegativeY);
}
