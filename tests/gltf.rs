//! glTF loading, through the public interface only.

use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::load_file;
use std::path::{Path, PathBuf};

/// All `.gltf` and `.glb` files below a folder, in order of their names.
fn models(folder: &Path, list: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            models(&path, list);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            list.push(path);
        }
    }
}

/// Every model of the folder in `OVERCOAT_CORPUS` ends in a scene or in an error of one line.
#[test]
fn corpus() {
    let Some(folder) = std::env::var_os("OVERCOAT_CORPUS").map(PathBuf::from) else { return };
    let (limits, jobs) = (Limits::default(), Jobs::default());
    let mut list = Vec::new();
    models(&folder, &mut list);
    assert!(!list.is_empty());
    for path in list {
        let start = std::time::Instant::now();
        let result = load_file(&path, &limits, &jobs);
        let took = start.elapsed().as_secs_f64() * 1e3;
        let shown = path.strip_prefix(&folder).unwrap().display();
        match result {
            Ok(loaded) => {
                let s = &loaded.scene;
                println!(
                    "{shown}: {took:.0} ms {} tri, {} meshes, {} instances, {} materials, {} textures, {} lights, {} cameras, size {:?}",
                    s.triangle_count(),
                    s.meshes().len(),
                    s.instances().len(),
                    s.materials().len(),
                    s.textures().len(),
                    s.lights().len(),
                    s.cameras().len(),
                    s.bounds().size().map(|v| v as f32),
                );
                for w in &loaded.warnings {
                    println!("    warning: {w}");
                    assert!(!w.message.contains('\n'));
                }
            }
            Err(e) => {
                println!("{shown}: {took:.0} ms ERROR {e}");
                assert!(!e.to_string().contains('\n'));
            }
        }
    }
}
