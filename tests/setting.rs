//! Files that a description names, given in memory: the same as from the file system, and nothing else is reached.

use overcoat::Limits;
use overcoat::description::{Description, Setting};
use overcoat::jobs::Jobs;
use overcoat::load::{Context, MemoryResolver};
use overcoat::scene::{EnvironmentSource, Material, Scene};

/// Radiance, 2 x 1 pixels.
const SKY: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\xc8\x0a\x0a\x81\x0a\x0a\x0a\x81";
const LACQUER: &[u8] = b"base_color = [0.5, 0.25, 0.125]\ncoat = 1\nroughness = 0.5\n";

fn material_of(setting: &Setting, description: &Description) -> (Material, EnvironmentSource) {
    let mut scene = Scene::new();
    scene.add_material(Material::default()).unwrap();
    setting.apply(description, &mut scene, &Limits::default()).unwrap();
    (scene.materials()[0].clone(), scene.environment().source.clone())
}

#[test]
fn from_memory_and_from_the_file_system_are_the_same() {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let folder = tempfile::tempdir().unwrap();
    let mut resolver = MemoryResolver::default();
    for (name, bytes) in [("sky.hdr", SKY), ("lacquer.toml", LACQUER)] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        resolver.files.insert(name.to_owned(), bytes.to_vec());
    }
    let text = "env = 'sky.hdr'\nenv_intensity = 2\nmaterial = 'lacquer.toml'";
    let description = Description::from_toml(text).unwrap();
    let context = Context { resolver: &resolver, limits: &limits, jobs: &jobs };
    let setting = Setting::load_from(&description, &context).unwrap();
    let (material, environment) = material_of(&setting, &description);
    assert_eq!((material.coat, material.base_color), (1.0, [0.5, 0.25, 0.125, 1.0]));

    let mut there = description.clone();
    there.resolve_paths(folder.path());
    let setting = Setting::load(&there, &limits, &jobs).unwrap();
    let (material_there, environment_there) = material_of(&setting, &there);
    assert_eq!(material, material_there);
    let EnvironmentSource::Image(here) = environment else { panic!("no picture") };
    let EnvironmentSource::Image(there) = environment_there else { panic!("no picture") };
    assert!(here == there && here.width() == 2);
}

#[test]
fn files_that_are_not_in_memory_are_not_looked_for_elsewhere() {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().join("there.toml");
    std::fs::write(&there, LACQUER).unwrap();
    let resolver = MemoryResolver::default();
    let context = Context { resolver: &resolver, limits: &limits, jobs: &jobs };
    let there = there.to_string_lossy().replace('\\', "/");
    for text in ["env = 'sky.hdr'".to_owned(), format!("material = '{there}'")] {
        let description = Description::from_toml(&text).unwrap();
        let error = Setting::load_from(&description, &context).unwrap_err().to_string();
        assert!(error.contains("no such file"), "{text}: {error}");
    }
}
