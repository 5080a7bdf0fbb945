//! Every model of the folder that `OVERCOAT_CORPUS` names: `gltf/`, whose `EXPECT.tsv` and `MANIFEST.md` say what
//! comes out, and `hostile/`, of which nothing may panic, hang or take much memory.

use crate::common::files::model::messages;
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

/// `[N tri; ...]` of a file's line in the manifest.
fn triangles(manifest: &str, file: &str) -> Option<u64> {
    let line = manifest.lines().find(|line| line.starts_with(&format!("| {file} |")))?;
    let (before, _) = line.split_once(" tri;")?;
    before.rsplit_once('[')?.1.parse().ok()
}

#[test]
fn every_model_ends_in_a_scene_or_in_one_line() {
    let Some(folder) = std::env::var_os("OVERCOAT_CORPUS").map(PathBuf::from) else { return };
    let (limits, jobs) = (Limits::default(), Jobs::default());
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.md")).unwrap_or_default();
    let expect = std::fs::read_to_string(folder.join("EXPECT.tsv")).unwrap_or_default();
    let mut list = Vec::new();
    models(&folder, &mut list);
    assert!(!list.is_empty());
    let mut wrong = Vec::new();
    for path in list {
        let file = path.strip_prefix(&folder).unwrap().to_string_lossy().into_owned();
        let start = std::time::Instant::now();
        let result = load_file(&path, &limits, &jobs);
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let needs = expect
            .lines()
            .find(|line| line.split('\t').next() == Some(&file))
            .map(|line| line.split('\t').nth(2).unwrap_or("").to_owned());
        match &result {
            Ok(loaded) => {
                let scene = &loaded.scene;
                println!(
                    "{file}: {milliseconds:.0} ms, {} triangles, {} meshes, {} draws, {} materials, {} textures, {} \
                     lights, {} cameras",
                    scene.triangle_count(),
                    scene.meshes().len(),
                    scene.instances().len(),
                    scene.materials().len(),
                    scene.textures().len(),
                    scene.lights().len(),
                    scene.cameras().len(),
                );
                for message in messages(loaded) {
                    println!("    warning: {message}");
                    assert!(!message.contains('\n'), "{file}");
                }
                // Counts in the manifest are of meshes; instances may multiply them.
                let expected = needs.as_ref().and_then(|_| triangles(&manifest, &file));
                let own: u64 = scene.meshes().iter().map(|m| m.triangles().len() as u64).sum();
                if expected.is_some_and(|n| n != own && n != scene.triangle_count()) {
                    wrong.push(format!(
                        "{file}: {} or {own} triangles, not {expected:?}",
                        scene.triangle_count()
                    ));
                }
                if needs.is_some() && scene.triangle_count() == 0 {
                    wrong.push(format!("{file}: an empty scene"));
                }
            }
            Err(error) => {
                println!("{file}: {milliseconds:.0} ms, error: {error}");
                assert!(!error.to_string().contains('\n'), "{file}");
                if needs.is_some() {
                    wrong.push(format!("{file}: {error}"));
                }
            }
        }
        assert!(milliseconds < 1e4, "{file}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
