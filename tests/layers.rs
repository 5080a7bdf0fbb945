//! Reads the sources and fails on any dependency between modules that the design does not have.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Which module may use which, and why no more.
const MAY_USE: &[(&str, &[&str])] = &[
    // The foundations: whoever wants to know what the bits of a sum are reads these and nothing else.
    ("math", &[]),
    // What is compiled in: each part of the renderer asks for itself.
    ("built", &[]),
    ("jobs", &[]),
    ("limits", &[]),
    ("formats", &[]),
    ("reuse", &[]),
    ("suggest", &[]),
    // Files within limits.
    ("files", &["limits"]),
    // Pure functions over lanes.
    ("color", &["math"]),
    ("brdf", &["math"]),
    // What blocks light of a scene, and maps of its depth.
    ("shadow", &["scene", "math", "jobs", "limits"]),
    // Rays against triangles, whatever they are of.
    ("bvh", &["math", "jobs"]),
    // A scene can be built and checked without anything that loads or draws it.
    ("scene", &["math", "color"]),
    // Encoded pictures to those that scenes have (scene), and to those that are compared and shown (frame).
    ("decode", &["color", "files", "formats", "frame", "limits", "scene"]),
    // Ends where the scene begins: no stage of the renderer can meet malformed input.
    ("load", &["built", "scene", "math", "color", "decode", "files", "jobs", "limits", "formats", "suggest"]),
    ("light", &["built", "scene", "math", "color", "brdf", "jobs"]),
    // A material model is a formula: it takes lookups as parameters and knows no scene.
    ("coat", &["brdf", "math"]),
    // Triangles flow one way: geometry fills tiles, tiles are rasterized.
    ("geometry", &["scene", "math", "limits", "jobs", "tile", "raster"]),
    ("tile", &["scene", "math", "limits", "raster"]),
    ("raster", &["scene", "math", "limits", "reuse"]),
    // Texels are decoded where they are filtered (color).
    ("gbuffer", &["raster", "scene", "math", "color"]),
    // Surfaces are evaluated from the scene's materials as they are (scene).
    // Pre-integrated tables are handed to the models here (brdf).
    ("shade", &["built", "gbuffer", "coat", "brdf", "light", "math", "scene", "shadow", "bvh"]),
    // Splats go their own way from the scene to the pixels of a tile.
    ("splat", &["geometry", "raster", "scene", "math", "color"]),
    // What comes out can be stored and compared without the renderer.
    ("frame", &["math", "color"]),
    ("output", &["frame", "color", "math", "formats"]),
    // Pictures of strangers are read within limits by the decoders that textures and environments have, and no model is;
    // files are written whole by output.
    ("golden", &["frame", "color", "decode", "files", "math", "limits", "output", "suggest"]),
    // The only place that knows the order of the stages.
    (
        "render",
        &[
            "built", "geometry", "tile", "raster", "gbuffer", "shade", "shadow", "bvh", "splat", "coat",
            "light", "brdf", "formats", "scene", "color", "math", "frame", "jobs", "limits", "reuse",
        ],
    ),
    // Pictures of models beside what the referee says; reads no file.
    ("lab", &["jobs", "math", "render", "scene", "truth"]),
    // Keeps what the renderer has made of pictures.
    ("cache", &["output", "render", "scene"]),
    // What a picture shows, for whoever asks: the command line, tests and programs. Says what to load and to draw, and draws
    // nothing.
    (
        "description",
        &[
            "color", "files", "frame", "jobs", "limits", "load", "math", "output", "render", "scene",
            "suggest",
        ],
    ),
    // For applications: scenes that change under names that stay, and pictures of them that follow each other. What changes is
    // said in one place, what is drawn in the other.
    ("world", &["jobs", "load", "scene"]),
    ("viewport", &["frame", "math", "render", "scene"]),
    // Rights of the process; knows nothing of what they are for.
    ("sandbox", &[]),
    // The referee judges models and shares nothing with them but arithmetic: a mistake of theirs must not be one of its own.
    ("truth", &["math"]),
    // Pages to read.
    ("guide", &[]),
    // Arguments in, library calls out.
    (
        "cli",
        &[
            "brdf",
            "cache",
            "coat",
            "color",
            "decode",
            "description",
            "files",
            "formats",
            "frame",
            "gbuffer",
            "geometry",
            "golden",
            "jobs",
            "lab",
            "light",
            "limits",
            "load",
            "math",
            "output",
            "raster",
            "render",
            "sandbox",
            "scene",
            "shade",
            "suggest",
            "tile",
            "truth",
        ],
    ),
    ("main", &["cli"]),
];

/// Packages that one module hides from all others: that is where their rules are kept.
const ONLY_IN: &[(&str, &str)] = &[
    // What others may have written is trusted in one place.
    ("blake3", "cache"),
    // What the process may do is decided in one place.
    ("landlock", "sandbox"),
    ("seccompiler", "sandbox"),
    ("libc", "sandbox"),
    // The order of results does not depend on threads because nobody else starts any work.
    ("rayon", "jobs"),
    // Instruction sets agree in bits because nobody else speaks to them.
    ("fearless_simd", "math/lanes"),
    // The library has no command line.
    ("clap", "cli"),
    ("tiny_skia", "cli"),
    ("plotters", "cli"),
];

/// All Rust sources below `src`, with `/` between the parts of their paths.
fn sources() -> Vec<(String, String)> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    walk(&root, &mut files);
    files.sort();
    assert!(files.len() > 40, "only {} sources found", files.len());
    let read = |path: &PathBuf| {
        let name: Vec<_> = path
            .strip_prefix(&root)
            .unwrap()
            .iter()
            .map(|part| part.to_string_lossy().into_owned())
            .collect();
        (name.join("/"), std::fs::read_to_string(path).unwrap())
    };
    files.iter().map(read).collect()
}

/// The module of a source: its folder or file directly below `src`.
fn module(name: &str) -> &str {
    name.split('/').next().unwrap().trim_end_matches(".rs")
}

/// The code of a source: without comments and strings, and without its unit tests, which may build scenes to test
/// on and stand at the end by convention.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let mut out = String::new();
    for line in text.lines() {
        let line = line.split("//").next().unwrap();
        // Every other part between quotation marks is a string.
        out.extend(line.split('"').step_by(2));
        out.push('\n');
    }
    out
}

/// The modules that code names after `crate::` or `$crate::`, also in braces and over several lines.
fn used_modules(code: &str) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        // `overcoat_crate::` is not this crate.
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            // The first identifier of every entry on the first level.
            let (mut depth, mut name, mut expecting) = (0, String::new(), true);
            for c in group.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        used.insert(std::mem::take(&mut name));
                        expecting = true;
                    }
                    c if depth == 0 && expecting && (c.is_alphanumeric() || c == '_') => name.push(c),
                    c if c.is_whitespace() => {}
                    _ => expecting = false,
                }
            }
            used.insert(name);
        } else {
            used.insert(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
        }
    }
    used.remove("");
    used
}

#[test]
fn arrows_between_modules_are_those_of_the_design() {
    let known: BTreeSet<&str> = MAY_USE.iter().map(|(name, _)| *name).collect();
    let mut wrong = Vec::new();
    let part_of_the_program = |name: &str| name != "lib.rs" && !name.ends_with("tests.rs");
    for (name, text) in sources().iter().filter(|(name, _)| part_of_the_program(name)) {
        let own = module(name);
        let Some((_, allowed)) = MAY_USE.iter().find(|(module, _)| *module == own) else {
            wrong.push(format!("src/{name}: module '{own}' has no place in the table"));
            continue;
        };
        for used in used_modules(&code(text)) {
            // Macros of the crate have no module; `dispatch!` belongs to math.
            let used = if used == "dispatch" { "math" } else { &used };
            if known.contains(used) && used != own && !allowed.contains(&used) {
                wrong.push(format!("src/{name}: {own} may not use {used}"));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_module_of_the_library_is_in_the_table() {
    let lib = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let declared: BTreeSet<&str> = lib
        .lines()
        .filter_map(|line| line.trim().strip_prefix("pub mod ").or(line.trim().strip_prefix("mod ")))
        .filter_map(|rest| rest.strip_suffix(';'))
        .collect();
    let listed: BTreeSet<&str> =
        MAY_USE.iter().map(|(name, _)| *name).filter(|name| *name != "main").collect();
    assert_eq!(declared, listed);
}

#[test]
fn the_design_has_no_cycles() {
    // Take away modules that use nothing but what was taken away; with a cycle some stay.
    let mut left: Vec<&(&str, &[&str])> = MAY_USE.iter().collect();
    while let Some(k) =
        left.iter().position(|(_, uses)| uses.iter().all(|u| left.iter().all(|(n, _)| n != u)))
    {
        left.remove(k);
    }
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn packages_stay_where_they_belong() {
    for (package, place) in ONLY_IN {
        let users: Vec<String> = sources()
            .into_iter()
            .filter(|(_, text)| {
                let code = code(text);
                code.match_indices(package).any(|(at, _)| {
                    let before = code[..at].chars().next_back();
                    let after = code[at + package.len()..].chars().next();
                    let word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
                    !word(before) && !word(after)
                })
            })
            .map(|(name, _)| name)
            .collect();
        assert!(!users.is_empty(), "nobody uses {package}");
        for user in users {
            assert!(user.starts_with(place), "src/{user} uses {package}, which belongs to src/{place}");
        }
    }
}

#[test]
fn there_is_no_unsafe_code() {
    for (name, text) in sources() {
        let code = code(&text);
        let words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
        assert!(!words.into_iter().any(|word| word == "unsafe"), "src/{name} has unsafe code");
    }
}

#[test]
fn the_reader_sees_what_it_should() {
    let text = "use crate::math::Lanes; // crate::cli\nuse crate::{\n    jobs::{Jobs, crate_like},\n    scene,\n};\n\
                fn f() -> $crate::frame::Frame { \"crate::load\" }\n#[cfg(test)]\nmod tests {\nuse crate::render;\n}\n";
    let used: Vec<String> = used_modules(&code(text)).into_iter().collect();
    assert_eq!(used, ["frame", "jobs", "math", "scene"]);
}
