//! The book: its chapters are in the list, its lines are short, and its listings are run or held against the tree.

use super::architecture::{exists, paths};
use super::pages::{Block, Page, chapters, manual, overcoat, root};
use std::collections::BTreeSet;

/// Longest line of a chapter, but for tables and pictures, which cannot be broken.
const COLUMNS: usize = 110;

/// Chapters with listings that other tests hold: of the service and its tools, of converters, and scripts.
const HELD_ELSEWHERE: [&str; 5] = [
    "docs/src/agents.md",
    "docs/src/converters.md",
    "docs/src/cost.md",
    "docs/src/recipes.md",
    "docs/src/service.md",
];

#[test]
fn every_chapter_is_in_the_list() {
    let summary = Page::read("docs/src/SUMMARY.md");
    let listed: BTreeSet<String> = summary
        .text
        .split("](")
        .skip(1)
        .map(|rest| format!("docs/src/{}", rest.split(')').next().unwrap()))
        .collect();
    let there: BTreeSet<String> = chapters().into_iter().map(|page| page.path).collect();
    assert_eq!(listed, there);
}

#[test]
fn lines_are_short() {
    for page in chapters() {
        for (number, line) in (1..).zip(page.text.lines()) {
            let cannot_be_broken = line.starts_with('|') || line.starts_with("![") || line.starts_with("{\"");
            let columns = line.chars().count();
            assert!(cannot_be_broken || columns < COLUMNS, "{}:{number}: {columns} columns", page.path);
        }
    }
}

#[test]
fn paths_of_the_tree_exist() {
    let mut seen = 0;
    for page in chapters() {
        for path in paths(&page.path, &page.text) {
            assert!(exists(&path), "{}: {path} does not exist", page.path);
            seen += 1;
        }
    }
    assert!(seen > 20, "only {seen} paths found");
}

/// Sources of the examples, which are compiled and run with the tests.
fn examples() -> Vec<String> {
    let paths = ["file-to-pixels.rs", "scene-by-hand.rs", "golden-image/main.rs"];
    paths.map(|path| Page::read(&format!("examples/{path}")).text).into()
}

/// A scene file is one, with the camera that its text says.
fn check_scene(text: &str) {
    let scene = overcoat::description::Description::from_toml(text).unwrap();
    assert_eq!(scene.size, Some([1920, 1080]));
    assert_eq!(scene.camera.fov_y_degrees, Some(30.0));
}

/// A scene file is one whose camera sees the origin at a place that its K and pose give.
fn check_camera(text: &str) {
    let description = overcoat::description::Description::from_toml(text).unwrap();
    let options = overcoat::RenderOptions::draft(640, 480);
    let camera = description.camera(&overcoat::Scene::new(), &options).unwrap();
    let told = camera.matrices([0.0; 3], 640, 480).unwrap();
    // Half of the numbers, which are those of a picture of twice the size.
    assert_eq!(told.k, [[300.0, 0.0, 150.25], [0.0, 300.0, 125.625], [0.0, 0.0, 1.0]]);
    // Places are of single precision.
    assert_eq!(told.world_to_camera.map(|row| row[3] as f32), [0.0, 0.6, 6.0, 1.0]);
}

fn check_material(text: &str) {
    use overcoat::load::{Context, MaterialFile, MemoryResolver};
    let flakes = std::fs::read(root().join("assets/materials/textures/flakes-normal.png")).unwrap();
    let resolver = MemoryResolver { files: [("flakes.png".to_owned(), flakes)].into() };
    let (limits, jobs) = (overcoat::Limits::default(), overcoat::jobs::Jobs::new(1));
    let context = Context { resolver: &resolver, limits: &limits, jobs: &jobs };
    let file = MaterialFile::from_bytes(text.as_bytes(), &context).unwrap();
    assert_eq!(file.model(), Some(overcoat::scene::ShadingModel::StackLit));
}

/// Thresholds count: what differs by one code passes with them, and not without.
fn check_thresholds(text: &str) {
    let folder = tempfile::tempdir().unwrap();
    for (side, colour) in [("expected", "#808080"), ("actual", "#818181")] {
        std::fs::create_dir(folder.path().join(side)).unwrap();
        let model = root().join("assets/models/rounded-cube.stl");
        let picture = format!("{side}/cube.png");
        // Far away, so that nothing but the background is seen.
        let arguments =
            ["render", model.to_str().unwrap(), "-o", &picture, "--size", "32", "--quality", "draft"];
        let view =
            ["--eye", "0,0,900", "--target", "0,0,1000", "--allow-empty", "-q", "--background", colour];
        assert!(overcoat(folder.path(), &[&arguments[..], &view].concat()).status.success());
    }
    let check = || overcoat(folder.path(), &["golden", "check", "expected", "actual"]).status.code();
    assert_eq!(check(), Some(4));
    std::fs::write(folder.path().join("expected/thresholds.toml"), text).unwrap();
    assert_eq!(check(), Some(0));
}

#[test]
fn listings_are_what_they_seem() {
    let examples = examples();
    let mut seen = BTreeSet::new();
    for page in manual().into_iter().filter(|page| !HELD_ELSEWHERE.contains(&&page.path[..])) {
        for Block { language, lines } in page.blocks() {
            let text = lines.join("\n");
            match &language[..] {
                // Commands have tests of their own.
                "sh" => {}
                "toml" => check_scene(&text),
                "toml calibrated.toml" => check_camera(&text),
                "toml paint.toml" => check_material(&text),
                "toml thresholds.toml" => check_thresholds(&text),
                "rust" => {
                    let is_there = examples.iter().any(|example| example.contains(&text));
                    assert!(is_there, "{}: no example has this listing:\n{text}", page.path);
                }
                other => panic!("{}: nothing checks a listing of '{other}'", page.path),
            }
            seen.insert(language);
        }
    }
    assert_eq!(seen.len(), 6, "{seen:?}");
}

/// Names of the packages of the workspace.
fn packages() -> BTreeSet<String> {
    let manifests = super::pages::files().into_iter().filter(|path| path.ends_with("Cargo.toml"));
    let tables = manifests.map(|path| Page::read(&path).text.parse::<toml::Table>().unwrap());
    let names = tables.filter_map(|manifest| Some(manifest.get("package")?["name"].as_str()?.to_owned()));
    names.collect()
}

/// True if a command of another program names only packages, scripts and folders that exist in the tree.
fn is_possible(command: &str, packages: &BTreeSet<String>) -> bool {
    let words: Vec<&str> = command.split(" #").next().unwrap().split_whitespace().collect();
    let value = |option: &str| words.iter().position(|word| *word == option).map(|at| words[at + 1]);
    match words[0] {
        "cargo" => {
            let package = value("-p").is_none_or(|name| packages.contains(name));
            package && value("--path").is_none_or(|path| root().join(path).join("Cargo.toml").is_file())
        }
        "pip" => words[1] == "install" && root().join(words[2]).join("pyproject.toml").is_file(),
        "python3" => root().join(words[1]).is_file(),
        // Programs of others, which need what is not here: a daemon, a server, a window, rights.
        "docker" | "curl" | "f3d" | "sudo" => true,
        program => match program.strip_prefix("target/release/") {
            Some(built) => packages.contains(built),
            None => program.contains('/') && root().join(program).is_file(),
        },
    }
}

#[test]
fn commands_of_other_programs_are_possible() {
    let packages = packages();
    let mut tried = 0;
    for page in manual().into_iter().filter(|page| page.path != "docs/src/recipes.md") {
        let mut lines = page.commands();
        lines.retain(|line| !line.starts_with("overcoat "));
        let is_command =
            |cell: &String| cell.starts_with("cargo ") || cell.starts_with("pip ") || cell.contains(".sh");
        lines.extend(page.cells().into_iter().filter(is_command));
        for line in lines {
            for command in line.split("&&") {
                assert!(is_possible(command, &packages), "{}: {command}", page.path);
                tried += 1;
            }
        }
    }
    assert!(tried > 20, "only {tried} commands found");
    for wrong in [
        "cargo build -p overcoat-nothing",
        "cargo install --path crates/no",
        "packaging/no.sh",
        "target/release/overcoat-nothing",
        "nothing",
    ] {
        assert!(!is_possible(wrong, &packages), "{wrong}");
    }
}
