//! The curated scenes have the recorded hashes: here at every instruction set, and on every other machine whose
//! program is named.
//!
//! `OVERCOAT_MACHINES` has a line `name[/n] = command [-- options]` for each; with `/n` only every n-th scene is drawn,
//! which is for machines that are emulated slowly. The command is split at spaces and may be an emulator with the program
//! behind it; it is called as `command render --scene ... -o ... --json --stage-hashes
//! options`. Scenes are files that this machine has written, pictures are files that it reads: a program that renders
//! somewhere else has to see the same folder. `UPDATE_MACHINES=1` records the hashes of this machine, and fails.

use super::curated::curated;
use super::files::{Files, SCENE};
use super::recipe::Recipe;
use super::record::{self, Hashes};
use super::referee;
use super::shot::Shot;
use overcoat::jobs::Jobs;
use overcoat::output::{OutputOptions, encode};
use overcoat::render::Renderer;
use overcoat_core::math::lanes::SimdLevel;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use xxhash_rust::xxh3::xxh3_128;

/// Emulators are slow, and a program that hangs must not hold the others for ever.
const TIMEOUT: Duration = Duration::from_secs(600);

/// Programs that run at a time.
const PROCESSES: usize = 2;

/// A stage and the hash of what it hands on; the bytes of the file come last.
type Stages = Vec<(String, String)>;

/// The hashes of a scene on this machine.
fn render(recipe: &Recipe, files: &Files, level: SimdLevel) -> Result<(Hashes, Stages), String> {
    // New for each scene and level, as in a process of its own: nothing is kept from another.
    let mut renderer = Renderer::new(2);
    let shot = Shot::load(files, recipe, &Jobs::new(1), None)?;
    let options = shot.options.with_simd(level);
    let rendered = renderer.render(&shot.scene, &shot.camera, &options).map_err(|e| e.to_string())?;
    let mut output = OutputOptions::default().with_display(shot.display);
    output.display.simd = level;
    let bytes = encode(&rendered.frame, recipe.output, &output).map_err(|e| e.to_string())?;
    let hashes = Hashes {
        frame: rendered.frame.frame_hash(),
        format: recipe.output.extension().to_owned(),
        file: format!("{:032x}", xxh3_128(&bytes)),
    };
    let stages = rendered.stats.stage_hashes.ok_or("no stage hashes")?;
    let mut stages: Stages =
        stages.stages().map(|(name, hash)| (name.to_owned(), format!("{hash:032x}"))).collect();
    stages.push(("encode".to_owned(), hashes.file.clone()));
    Ok((hashes, stages))
}

/// The first stage that two machines do not agree on.
fn first_difference<'a>(here: &'a Stages, there: &Stages) -> Option<&'a str> {
    let differs = |(name, hash): &&(String, String)| {
        there.iter().find(|(other, _)| other == name).is_none_or(|(_, other)| other != hash)
    };
    here.iter().find(differs).map(|(name, _)| name.as_str())
}

#[test]
fn this_machine_gives_the_recorded_hashes() {
    let recorded = record::read();
    let mut rows = Vec::new();
    let mut wrong = Vec::new();
    for (name, recipe) in curated() {
        let files = Files::of(&recipe).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut first: Option<(SimdLevel, Hashes, Stages)> = None;
        for level in SimdLevel::available() {
            let (hashes, stages) = render(&recipe, &files, level).unwrap_or_else(|e| panic!("{name}: {e}"));
            match &first {
                None => first = Some((level, hashes, stages)),
                Some((reference, _, expected)) => {
                    if let Some(stage) = first_difference(expected, &stages) {
                        wrong.push(format!("{name}: stage {stage} differs between {reference} and {level}"));
                    }
                }
            }
        }
        let (_, hashes, _) = first.expect("there is always a level");
        match recorded.get(&name) {
            None => wrong.push(format!("{name}: no hash is recorded")),
            Some(known) if known.frame != hashes.frame => wrong.push(format!("{name}: another frame")),
            Some(known) if *known != hashes => wrong.push(format!("{name}: another file of the same frame")),
            Some(_) => {}
        }
        rows.push((name, hashes));
    }
    for (name, options) in referee::RUNS {
        // The program, as on other machines.
        let output =
            Command::new(env!("CARGO_BIN_EXE_overcoat")).args(referee::words(options)).output().unwrap();
        let hashes = referee::hashes(&String::from_utf8(output.stdout).unwrap());
        let hashes = hashes.unwrap_or_else(|e| panic!("{name}: {e}"));
        if recorded.get(name) != Some(&hashes) {
            wrong.push(format!("{name}: another one, or none is recorded"));
        }
        rows.push((name.to_owned(), hashes));
    }
    if std::env::var_os("UPDATE_MACHINES").is_some_and(|value| value == "1") {
        std::fs::write(record::path(), record::to_text(&rows)).unwrap();
        panic!("{} scenes recorded; look at what changed, then run again\n{}", rows.len(), wrong.join("\n"));
    }
    let names: Vec<&String> = rows.iter().map(|(name, _)| name).collect();
    wrong.extend(
        recorded.keys().filter(|name| !names.contains(name)).map(|name| format!("{name}: no such scene")),
    );
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Command that runs the program of another machine.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Machine {
    name: String,
    /// Draws every one of this many scenes.
    every: usize,
    command: Vec<String>,
    options: Vec<String>,
}

/// Reads lines `name[/n] = command [-- options]`.
fn machines(text: &str) -> Result<Vec<Machine>, String> {
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    lines
        .map(|line| {
            let (name, rest) =
                line.split_once('=').ok_or_else(|| format!("'{line}' is not name = command"))?;
            let (command, options) = rest.split_once(" -- ").unwrap_or((rest, ""));
            let (name, every) = match name.trim().rsplit_once('/') {
                Some((name, n)) => {
                    let every = n.parse().ok().filter(|&n| n > 0);
                    (name, every.ok_or_else(|| format!("'{line}': /{n} is no number of scenes"))?)
                }
                None => (name.trim(), 1),
            };
            let (name, command, options) = (name.to_owned(), words(command), words(options));
            let machine = Machine { name, every, command, options };
            if machine.command.is_empty() { Err(format!("'{line}' has no command")) } else { Ok(machine) }
        })
        .collect()
}

#[test]
fn other_machines_give_the_recorded_hashes() {
    let Ok(text) = std::env::var("OVERCOAT_MACHINES") else {
        println!("OVERCOAT_MACHINES names no other machine: nothing compared");
        return;
    };
    let machines = machines(&text).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("machines");
    let mut scenes = Vec::new();
    for (name, recipe) in curated() {
        let files = Files::of(&recipe).unwrap();
        let place = folder.join(&name);
        files.write(&place).unwrap();
        scenes.push(Scene { name, recipe, files, folder: place });
    }
    let (recorded, all) = (record::read(), scenes.len());
    let mut wrong = Vec::new();
    for machine in &machines {
        let start = Instant::now();
        let scenes: Vec<&Scene> = scenes.iter().step_by(machine.every).collect();
        let problems = on_machine(machine, &scenes, &|scene| {
            let expected = recorded.get(&scene.name).ok_or("no hash is recorded")?;
            compare(machine, scene, expected)
        });
        println!(
            "{:<14} {} of {all} scenes, {} hashes equal, {} differ, {:.0} s",
            machine.name,
            scenes.len(),
            scenes.len() - problems.len(),
            problems.len(),
            start.elapsed().as_secs_f64()
        );
        wrong.extend(problems);
        let start = Instant::now();
        let runs = referee::RUNS.iter();
        let problems: Vec<String> =
            runs.filter_map(|(name, options)| judge(machine, name, options, &recorded).err()).collect();
        println!(
            "{:<14} {} runs of the referee, {} differ, {:.0} s",
            machine.name,
            referee::RUNS.len(),
            problems.len(),
            start.elapsed().as_secs_f64()
        );
        wrong.extend(problems);
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Asks the referee of another program. Options of drawing are not its.
fn judge(
    machine: &Machine,
    name: &str,
    options: &str,
    recorded: &BTreeMap<String, Hashes>,
) -> Result<(), String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("machines").join(name);
    let ask = || {
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let expected = recorded.get(name).ok_or("no hash is recorded")?;
        let found = referee::hashes(&execute(machine, &referee::words(options), &folder)?)?;
        match (found.frame == expected.frame, found == *expected) {
            (_, true) => Ok(()),
            (false, _) => Err("other numbers of the referee".to_owned()),
            (true, _) => Err("other numbers of the models".to_owned()),
        }
    };
    ask().map_err(|problem: String| format!("{}: {name}: {problem}", machine.name))
}

/// A scene whose files are written.
struct Scene {
    name: String,
    recipe: Recipe,
    files: Files,
    folder: PathBuf,
}

/// Problems of the scenes on a machine, in the order of the scenes.
fn on_machine(
    machine: &Machine,
    scenes: &[&Scene],
    check: &(dyn Fn(&Scene) -> Result<(), String> + Sync),
) -> Vec<String> {
    let next = AtomicUsize::new(0);
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..PROCESSES {
            scope.spawn(|| {
                while let Some(scene) = scenes.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Err(problem) = check(scene) {
                        let line = format!("{}: {}: {problem}", machine.name, scene.name);
                        found.lock().unwrap_or_else(PoisonError::into_inner).push((&scene.name, line));
                    }
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|(name, _)| scenes.iter().position(|scene| scene.name == **name));
    found.into_iter().map(|(_, line)| line).collect()
}

/// Renders a scene in another program and compares what it says and what it has written.
fn compare(machine: &Machine, scene: &Scene, expected: &Hashes) -> Result<(), String> {
    let out = scene.folder.join(format!("out.{}", expected.format));
    let _ = std::fs::remove_file(&out);
    let report: Value = serde_json::from_str(&run(machine, scene, &out)?)
        .map_err(|e| format!("its report is no JSON: {e}"))?;
    let bytes = std::fs::read(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let actual = Hashes {
        frame: report["frame_hash"].as_str().unwrap_or_default().to_owned(),
        format: expected.format.clone(),
        file: format!("{:032x}", xxh3_128(&bytes)),
    };
    let reported = report["stage_hashes"]["encode"].as_str().unwrap_or_default();
    if reported != actual.file {
        return Err(format!("it reports {reported} as the hash of a file that has {}", actual.file));
    }
    if actual == *expected {
        return Ok(());
    }
    let there: Stages = report["stage_hashes"]
        .as_object()
        .map(|stages| {
            let text = |hash: &Value| hash.as_str().unwrap_or_default().to_owned();
            stages.iter().map(|(name, hash)| (name.clone(), text(hash))).collect()
        })
        .unwrap_or_default();
    let (_, here) = render(&scene.recipe, &scene.files, SimdLevel::best())?;
    let stage = match first_difference(&here, &there) {
        Some(stage) => format!("stage {stage} is the first that differs from this machine's"),
        None => {
            "every stage is as on this machine, which does not give the recorded hashes either".to_owned()
        }
    };
    let what =
        if actual.frame == expected.frame { "another file of the same frame" } else { "another frame" };
    Err(format!("{what}; {stage} ({})", scene.folder.join(SCENE).display()))
}

/// Output of the program when it draws a scene.
fn run(machine: &Machine, scene: &Scene, out: &Path) -> Result<String, String> {
    let path = |path: &Path| path.to_string_lossy().into_owned();
    let mut words = vec!["render".to_owned(), "--scene".to_owned(), path(&scene.folder.join(SCENE))];
    words.extend(["-o".to_owned(), path(out), "--json".to_owned(), "--stage-hashes".to_owned()]);
    words.extend(machine.options.iter().cloned());
    if !scene.recipe.aovs.is_empty() {
        let names: Vec<&str> = scene.recipe.aovs.iter().map(|aov| aov.name()).collect();
        words.extend(["--aov".to_owned(), names.join(",")]);
    }
    execute(machine, &words, &scene.folder)
}

/// Output of the program, which also goes to a file of a folder.
fn execute(machine: &Machine, words: &[String], folder: &Path) -> Result<String, String> {
    let (program, first) = machine.command.split_first().ok_or("no command")?;
    let log = |name: &str| folder.join(name);
    // Files, because nobody empties a pipe while this waits.
    let file = |name: &str| File::create(log(name)).map_err(|e| e.to_string());
    let mut command = Command::new(program);
    command.args(first).args(words);
    let mut child = command
        .stdin(Stdio::null())
        .stdout(file("stdout")?)
        .stderr(file("stderr")?)
        .spawn()
        .map_err(|e| format!("{program}: {e}"))?;
    let start = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|e| e.to_string())? {
            Some(status) => break status,
            None if start.elapsed() > TIMEOUT => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("not done after {} s", TIMEOUT.as_secs()));
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    if !status.success() {
        let message = std::fs::read_to_string(log("stderr")).unwrap_or_default();
        return Err(format!("{status}: {}", message.lines().last().unwrap_or_default()));
    }
    std::fs::read_to_string(log("stdout")).map_err(|e| e.to_string())
}

#[test]
fn machines_are_read() {
    let text = "arm = emulator -L /root program\n\n big endian/5 = program -- --simd sse2 --tile 16\n";
    let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let machine = |name: &str, every, command, options| {
        let name = name.to_owned();
        Machine { name, every, command, options }
    };
    let expected = vec![
        machine("arm", 1, words("emulator -L /root program"), Vec::new()),
        machine("big endian", 5, words("program"), words("--simd sse2 --tile 16")),
    ];
    assert_eq!(machines(text), Ok(expected));
    for wrong in ["x86", "x86 =", "x86/0 = program", "x86/five = program"] {
        assert!(machines(wrong).is_err(), "{wrong}");
    }
}
