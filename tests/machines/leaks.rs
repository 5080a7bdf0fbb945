//! Random scenes have one hash, whatever the instruction set, the side of the tiles and the number of threads.
//!
//! `OVERCOAT_LEAKS=<count>[,<first seed>]` renders more of them, or others.

use super::dice::Dice;
use super::examine::{Bench, Problem, Setting, settings};
use super::files::{Files, SCENE};
use super::recipe::{EnvironmentRecipe, KeyValue, Recipe};
use super::shot::{Shot, Skies};
use super::shrink::shrink;
use overcoat::description::{Description, LightDescription, Machine};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::render::Renderer;
use overcoat_core::math::lanes::SimdLevel;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Problems that are looked into; the rest of the recipes is left then.
const MOST_REPORTED: usize = 3;

/// Questions that the shrinker may ask.
const STEPS: usize = 1000;

/// Folder to which minimal scenes are written.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("leaks")
}

/// Number of recipes, and the seed of the first.
fn asked() -> (u64, u64) {
    let number = |text: &str| text.trim().parse().expect("OVERCOAT_LEAKS is <count>[,<first seed>]");
    match std::env::var("OVERCOAT_LEAKS") {
        Ok(text) => {
            let (count, first) = text.split_once(',').unwrap_or((&text, "0"));
            (number(count), number(first))
        }
        // A debug build shades a tenth as fast.
        Err(_) => (if cfg!(debug_assertions) { 200 } else { 2000 }, 0),
    }
}

/// Results of random recipes.
#[derive(Default)]
struct Found {
    rendered: u64,
    /// Number of pictures that show something; not counted where there is a problem.
    visible: u64,
    /// Seeds of one problem, the least first.
    problems: Vec<(Problem, Vec<u64>)>,
}

impl Found {
    fn add(&mut self, seed: u64, outcome: Result<u64, Problem>) {
        self.rendered += 1;
        match outcome {
            Ok(fragments) => self.visible += u64::from(fragments > 0),
            Err(problem) => match self.problems.iter_mut().find(|(known, _)| known.is_like(&problem)) {
                Some((_, seeds)) => seeds.push(seed),
                None => self.problems.push((problem, vec![seed])),
            },
        }
    }
}

#[test]
fn random_scenes_have_one_hash() {
    let (count, first) = asked();
    let start = Instant::now();
    let skies = Skies::default();
    let next = AtomicU64::new(0);
    let found = Mutex::new(Found::default());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let mut bench = Bench::new();
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        break;
                    }
                    let outcome = bench.examine(&Recipe::random(first + number), &skies);
                    let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
                    found.add(first + number, outcome);
                    if found.problems.len() >= MOST_REPORTED {
                        next.store(count, Ordering::Relaxed);
                    }
                }
            });
        }
    });
    let mut bench = Bench::new();
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    println!(
        "{} of {count} scenes from seed {first}, {} to be seen, {} pictures of each: {:.1?}",
        found.rendered,
        found.visible,
        bench.pictures(),
        start.elapsed()
    );
    // Threads find in no order.
    found.problems.iter_mut().for_each(|(_, seeds)| seeds.sort_unstable());
    found.problems.sort_by_key(|(_, seeds)| seeds[0]);
    let mut reports = Vec::new();
    for (_, seeds) in &found.problems {
        let recipe = Recipe::random(seeds[0]);
        // As it is for this seed.
        let Err(problem) = bench.examine(&recipe, &skies) else {
            reports.push(format!("seed-{}: another outcome the second time", seeds[0]));
            continue;
        };
        let text = report(&format!("seed-{}", seeds[0]), &recipe, &problem, &mut |candidate| {
            bench.examine(candidate, &skies).err()
        });
        reports.push(format!("{text}\n  so many seeds like it: {}", seeds.len()));
    }
    assert!(reports.is_empty(), "\n{}", reports.join("\n"));
    // A few dozen tell nothing about the rest.
    assert!(
        count < 100 || found.visible * 4 > count * 3,
        "{} of {count} scenes show something",
        found.visible
    );
}

/// Shrinks a recipe that fails, writes it, and says how to see it.
fn report(
    name: &str,
    recipe: &Recipe,
    problem: &Problem,
    examine: &mut dyn FnMut(&Recipe) -> Option<Problem>,
) -> String {
    let fails = &mut |candidate: &Recipe| examine(candidate).is_some_and(|other| problem.is_like(&other));
    let (least, steps) = shrink(recipe, STEPS, fails);
    // The settings may be others now.
    let problem = examine(&least).unwrap_or_else(|| problem.clone());
    let folder = folder().join(name);
    let written = Files::of(&least).and_then(|files| files.write(&folder).map_err(|e| e.to_string()));
    let wrote = match written {
        Ok(()) => String::new(),
        Err(error) => format!(" (which could not be written: {error})"),
    };
    let setting = problem.setting().map_or(String::new(), |setting| format!("{setting} "));
    let planes: Vec<&str> = least.aovs.iter().map(|aov| aov.name()).collect();
    let planes = if planes.is_empty() { String::new() } else { format!("--aov {} ", planes.join(",")) };
    format!(
        "{name}: {problem}\n  after {steps} steps of shrinking{wrote}: overcoat render --scene {} {setting}{planes}--json \
         --stage-hashes -o out.png",
        folder.join(SCENE).display(),
    )
}

#[test]
fn environments_have_one_hash() {
    let skies = Skies::default();
    let jobs = Jobs::new(1);
    for number in 0..EnvironmentRecipe::PICTURES {
        for which in [EnvironmentRecipe::Hdr(number), EnvironmentRecipe::Exr(number)] {
            let recipe = Recipe { environment: which, ..square() };
            let files = Files::of(&recipe).unwrap();
            let shot = Shot::load(&files, &recipe, &jobs, Some(&skies)).unwrap();
            let mut hashes = BTreeSet::new();
            for setting in settings(&SimdLevel::available().collect::<Vec<_>>()) {
                let options = shot.options.clone().with_simd(setting.level);
                // A new renderer has filtered nothing yet.
                let rendered =
                    Renderer::new(setting.threads).render(&shot.scene, &shot.camera, &options).unwrap();
                hashes.insert(rendered.stats.stage_hashes.unwrap().environment);
            }
            assert_eq!(hashes.len(), 1, "{which:?}");
        }
    }
}

/// One square.
fn square() -> Recipe {
    Recipe {
        meshes: vec![super::shapes::square(1)],
        materials: vec![super::recipe::MaterialRecipe::default()],
        instances: vec![super::recipe::InstanceRecipe::plain(0, 0)],
        ..Recipe::empty()
    }
}

#[test]
fn settings_cover_all_pairs() {
    for count in 1..=SimdLevel::ALL.len() {
        let all = settings(&SimdLevel::ALL[..count]);
        let pairs =
            |key: fn(&Setting) -> (String, String)| all.iter().map(key).collect::<BTreeSet<_>>().len();
        assert_eq!(pairs(|s| (s.level.to_string(), s.tile.to_string())), 3 * count);
        assert_eq!(pairs(|s| (s.level.to_string(), s.threads.to_string())), 2 * count);
        assert_eq!(pairs(|s| (s.tile.to_string(), s.threads.to_string())), 6);
    }
}

#[test]
fn a_seed_is_one_recipe() {
    for seed in 0..50 {
        let recipe = Recipe::random(seed);
        assert_eq!(recipe, Recipe::random(seed));
        assert_eq!(Files::of(&recipe).unwrap().0, Files::of(&recipe).unwrap().0);
    }
    assert_ne!(Recipe::random(1), Recipe::random(2));
    // The reference's first numbers.
    let mut dice = Dice::new(1_234_567);
    assert_eq!([dice.next(), dice.next()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
}

#[test]
fn files_on_disk_are_those_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = Jobs::new(1);
    let mut renderer = Renderer::new(1);
    for seed in 0..60 {
        let recipe = Recipe::random(seed);
        let files = Files::of(&recipe).unwrap();
        files.write(folder.path()).unwrap();
        let file = Description::open(&folder.path().join(SCENE)).unwrap();
        let picture = file.picture(Machine::default(), &Limits::default(), &jobs).unwrap();
        let options = picture.options.with_stage_hashes(true);
        let shot = Shot::load(&files, &recipe, &jobs, None).unwrap();
        let mut hashes = |scene, camera, options| {
            let rendered = renderer.render(scene, camera, options).unwrap();
            (rendered.frame.frame_hash(), rendered.stats.stage_hashes)
        };
        let on_disk = hashes(&picture.scene, &picture.camera, &options);
        assert_eq!(on_disk, hashes(&shot.scene, &shot.camera, &shot.options), "seed {seed}");
    }
}

/// True if a StackLit material with a texture is lit by a tube.
fn stacklit_texture_under_a_tube(recipe: &Recipe) -> bool {
    let is = |value: &KeyValue, text: &str| *value == KeyValue::Text(text.to_owned());
    recipe.lights.iter().any(|light| matches!(light, LightDescription::Tube { .. }))
        && recipe.materials.iter().any(|material| {
            material.keys.iter().any(|(key, value)| *key == "model" && is(value, "\"stacklit\""))
                && material.keys.iter().any(|(_, value)| matches!(value, KeyValue::Texture(_)))
        })
}

#[test]
fn shrinking_leaves_what_fails_and_nothing_else() {
    let failing: Vec<Recipe> =
        (0..).map(Recipe::random).filter(stacklit_texture_under_a_tube).take(5).collect();
    for recipe in failing {
        let (least, steps) = shrink(&recipe, STEPS, &mut |r| stacklit_texture_under_a_tube(r));
        assert!(stacklit_texture_under_a_tube(&least));
        assert!(steps < STEPS, "{steps}");
        let lengths =
            [least.instances.len(), least.materials.len(), least.textures.len(), least.lights.len()];
        assert_eq!(lengths, [1; 4], "{least:#?}");
        assert_eq!(least.meshes.iter().map(|m| m.triangles.len()).sum::<usize>(), 1);
        assert_eq!(least.materials[0].keys.len(), 2);
        assert_eq!((least.samples, least.size, least.environment), (1, [4, 4], EnvironmentRecipe::None));
        // Nothing more can go.
        assert_eq!(shrink(&least, STEPS, &mut |r| stacklit_texture_under_a_tube(r)).0, least);
        // And it is a scene.
        assert!(Bench::new().examine(&least, &Skies::default()).is_ok());
    }
}

/// A difference that is put in where tiles of 32 show a blended surface must be found, shrunk, named and written.
#[test]
fn a_planted_difference_is_found() {
    let skies = Skies::default();
    let mut bench = Bench::new();
    let mut examine = |recipe: &Recipe| {
        bench
            .examine_by(recipe, &skies, &mut |bench, shot, setting| {
                let mut rendered = bench.render(shot, setting)?;
                let blended =
                    shot.scene.materials().iter().any(|m| m.alpha_mode == overcoat::scene::AlphaMode::Blend);
                if let (true, 32, Some(hashes)) = (blended, setting.tile, &mut rendered.stats.stage_hashes) {
                    hashes.shading ^= 1;
                }
                Ok(rendered)
            })
            .err()
    };
    let (seed, problem) = (0..).find_map(|seed| Some((seed, examine(&Recipe::random(seed))?))).unwrap();
    let Problem::Differs { what, settings: [a, b] } = &problem else { panic!("{problem}") };
    assert_eq!((what.as_str(), a.tile, b.tile), ("stage shading", 16, 32));
    let text = report("planted", &Recipe::random(seed), &problem, &mut examine);
    for word in
        ["planted: stage shading differs", "--tile 16", "--tile 32", "--json --stage-hashes", "scene.toml"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let scene = folder().join("planted");
    let file = Description::open(&scene.join(SCENE)).unwrap();
    let picture = file.picture(Machine::default(), &Limits::default(), &Jobs::new(1)).unwrap();
    assert_eq!((picture.scene.materials().len(), picture.scene.triangle_count()), (1, 1));
    std::fs::remove_dir_all(scene).unwrap();
}
