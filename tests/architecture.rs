//! The documents about the sources tell the truth: what they name is there, the code map is complete, and every recipe says
//! which files it goes through.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Documents that speak of this tree only: every path in them is one of it.
const OF_THE_TREE: [&str; 3] = ["ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"];

/// Folders at the top of the tree that belong into the code map, beside the packages.
const FOLDERS: [&str; 11] = [
    "tests",
    "golden",
    "assets",
    "examples",
    "bindings",
    "benches",
    "service",
    "packaging",
    "fuzz",
    "docs",
    ".ci",
];

/// File name extensions by which documents mention files without their folder.
const EXTENSIONS: [&str; 6] = [".rs", ".md", ".toml", ".tsv", ".sh", ".py"];

/// Recipes that the document must have, for what contributors may want to add.
const RECIPES: [&str; 6] = [
    "To add a shading model",
    "To add a glTF extension",
    "To add a format",
    "To add an output",
    "To add an effect",
    "To add an option",
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn read(document: &str) -> String {
    std::fs::read_to_string(root().join(document)).unwrap_or_else(|error| panic!("{document}: {error}"))
}

/// A text without its fenced blocks, line by line: shells and pictures mention files that are not there yet.
fn prose(text: &str) -> String {
    let mut inside = false;
    let mut out = String::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside;
        } else if !inside {
            out.push_str(line);
            out.push('\n');
        }
    }
    assert!(!inside, "a fenced block is not closed");
    out
}

/// The words of all that stands in backticks.
fn quoted(text: &str) -> Vec<String> {
    let prose = prose(text);
    let mut words = Vec::new();
    for paragraph in prose.split("\n\n") {
        // Every other part between backticks is code; a pair is never open beyond its paragraph.
        assert_eq!(paragraph.matches('`').count() % 2, 0, "an odd number of backticks in: {paragraph}");
        let code = paragraph.split('`').skip(1).step_by(2);
        words.extend(code.flat_map(str::split_whitespace).map(str::to_owned));
    }
    words
}

/// True if a word leads into this tree: its first part is a folder that stands in it.
fn leads_into_the_tree(word: &str) -> bool {
    word.split_once('/')
        .is_some_and(|(first, _)| ["src", "crates"].contains(&first) || FOLDERS.contains(&first))
}

/// True if a word of a document about the tree is meant as a path.
fn is_path(word: &str) -> bool {
    let has_extension = || EXTENSIONS.iter().any(|end| word.len() > end.len() && word.ends_with(end));
    let elsewhere = ["/", "-", "target/"].iter().any(|start| word.starts_with(start)) || word.contains("://");
    !elsewhere && (word.contains('/') || has_extension())
}

/// The paths among the words of a document. In those that also speak of files of users, only what leads into the tree.
pub fn paths(document: &str, text: &str) -> Vec<String> {
    let of_the_tree = OF_THE_TREE.contains(&document);
    let meant = |word: &String| if of_the_tree { is_path(word) } else { leads_into_the_tree(word) };
    quoted(text).into_iter().filter(meant).collect()
}

/// The files that a text links to, without places in them.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    targets.filter(|target| !target.is_empty() && !target.contains("://")).map(str::to_owned).collect()
}

/// True if a path exists, and is a folder if it ends as one.
pub fn exists(path: &str) -> bool {
    let found = root().join(path);
    if path.ends_with('/') { found.is_dir() } else { found.exists() }
}

/// The section below a heading, up to the next one of the same or a higher level.
fn section<'a>(text: &'a str, heading: &str) -> Option<&'a str> {
    let level = heading.chars().take_while(|c| *c == '#').count();
    let start = text.find(&format!("\n{heading}\n"))? + heading.len() + 2;
    let mut end = start;
    for line in text[start..].split_inclusive('\n') {
        let hashes = line.chars().take_while(|c| *c == '#').count();
        if (1..=level).contains(&hashes) && line[hashes..].starts_with(' ') {
            break;
        }
        end += line.len();
    }
    Some(&text[start..end])
}

/// Names in a folder.
fn names(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Missing entries of a code map, which has every package, all modules of those whose root only lists them, as `crates/core/src/math/` or
/// `crates/core/src/limits.rs`, and the folders beside them.
fn missing_in_map(map: &str) -> Vec<String> {
    let mut wanted: Vec<String> = names("crates").iter().map(|name| format!("crates/{name}/")).collect();
    assert!(wanted.len() > 10, "only {wanted:?} in crates");
    for package in [
        "src",
        "crates/core/src",
        "crates/image/src",
        "crates/lab/src",
        "crates/shading/src",
        "crates/stages/src",
    ] {
        let modules = names(package);
        wanted.extend(modules.iter().map(|name| {
            let path = format!("{package}/{name}");
            if root().join(&path).is_dir() { path + "/" } else { path }
        }));
    }
    // The entry of the package itself speaks of its root.
    wanted.retain(|path| !path.ends_with("/lib.rs") || path == "src/lib.rs");
    wanted.extend(FOLDERS.map(|folder| format!("{folder}/")));
    wanted.sort();
    // Named at the beginning of its own entry, and not only mentioned in another.
    wanted.retain(|name| !map.lines().any(|line| line.starts_with(&format!("- `{name}`"))));
    wanted
}

/// The recipes of a text that name no file, or only folders.
fn recipes_without_files(recipes: &str) -> Vec<String> {
    let headings = recipes.lines().filter(|line| line.starts_with("### "));
    let has_file = |heading: &&str| {
        let text = section(recipes, heading).unwrap_or_default();
        quoted(text).iter().any(|word| is_path(word) && root().join(word).is_file())
    };
    headings.filter(|heading| !has_file(heading)).map(str::to_owned).collect()
}

#[test]
fn every_path_in_the_documents_exists() {
    let mut wrong = Vec::new();
    for document in OF_THE_TREE.into_iter().chain(["README.md"]) {
        let text = read(document);
        let (paths, links) = (paths(document, &text), links(&text));
        let least = if document == "ARCHITECTURE.md" { 100 } else { 5 };
        assert!(paths.len() >= least, "only {} paths found in {document}", paths.len());
        let lost = paths.iter().chain(&links).filter(|path| !exists(path));
        wrong.extend(lost.map(|path| format!("{document}: {path} does not exist")));
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The name of a type at the beginning of a word such as `Frame` or `Renderer::render`, if the word is one.
fn type_name(word: &str) -> Option<&str> {
    let is_code = word.chars().all(|c| c.is_ascii_alphanumeric() || c == ':');
    let name = word.split(':').next()?;
    let is_type =
        name.starts_with(|c: char| c.is_ascii_uppercase()) && name.contains(|c: char| c.is_ascii_lowercase());
    (is_code && is_type).then_some(name)
}

#[test]
fn every_type_in_the_documents_exists() {
    fn read_all(folder: &Path, text: &mut String) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                read_all(&path, text);
            } else if path.extension().is_some_and(|e| e == "rs") {
                text.push_str(&std::fs::read_to_string(path).unwrap());
            }
        }
    }
    let mut sources = String::new();
    read_all(&root().join("src"), &mut sources);
    read_all(&root().join("crates"), &mut sources);
    let mut defined = BTreeSet::new();
    for line in sources.lines() {
        let mut words = line.split(|c: char| !c.is_ascii_alphanumeric());
        while let Some(word) = words.next() {
            if ["struct", "enum", "trait"].contains(&word) {
                defined.extend(words.next());
            }
        }
    }
    let mut seen = 0;
    for document in OF_THE_TREE {
        for word in quoted(&read(document)) {
            let Some(name) = type_name(&word) else { continue };
            assert!(defined.contains(name), "{document}: there is no type '{name}'");
            seen += 1;
        }
    }
    assert!(seen >= 20, "only {seen} types found");
}

#[test]
fn everything_in_src_is_in_the_code_map() {
    let text = read("ARCHITECTURE.md");
    let map = section(&text, "## Code map").expect("there is a code map");
    let missing = missing_in_map(map);
    assert!(missing.is_empty(), "not in the code map: {}", missing.join(", "));
}

/// Packages of ours that a manifest names as dependencies, on any target, but for those of tests.
fn own_dependencies(manifest: &toml::Table) -> BTreeSet<String> {
    let of = |table: &toml::Table| -> Vec<String> {
        let list = table.get("dependencies").and_then(toml::Value::as_table);
        list.into_iter().flat_map(toml::Table::keys).cloned().collect()
    };
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let of_targets = targets.into_iter().flat_map(toml::Table::values).filter_map(toml::Value::as_table);
    of_targets.chain([manifest]).flat_map(of).filter(|name| name.starts_with("overcoat")).collect()
}

#[test]
fn the_table_of_packages_is_that_of_the_manifests() {
    let text = read("ARCHITECTURE.md");
    let map = section(&text, "## Code map").expect("there is a code map");
    let rows = map.lines().filter_map(|line| line.strip_prefix("| `overcoat"));
    let told: BTreeMap<String, BTreeSet<String>> = rows
        .map(|row| {
            let (name, used) = row.split_once("` | ").expect("two columns");
            let used = used.trim_end_matches(" |").split(", ").filter(|name| *name != "none");
            let full = |name: &str| if name == "overcoat" { name.into() } else { format!("overcoat-{name}") };
            (format!("overcoat{name}"), used.map(full).collect())
        })
        .collect();
    let folders = names("crates").into_iter().map(|name| format!("crates/{name}"));
    let there: BTreeMap<String, BTreeSet<String>> = folders
        .chain(["assets".to_owned(), ".".to_owned()])
        .map(|folder| {
            let manifest: toml::Table = read(&format!("{folder}/Cargo.toml")).parse().unwrap();
            (manifest["package"]["name"].as_str().unwrap().to_owned(), own_dependencies(&manifest))
        })
        .collect();
    assert_eq!(told, there);
}

#[test]
fn every_recipe_lists_files() {
    let text = read("ARCHITECTURE.md");
    let recipes = section(&text, "## Recipes").expect("there are recipes");
    for recipe in RECIPES {
        assert!(section(recipes, &format!("### {recipe}")).is_some(), "there is no recipe '{recipe}'");
    }
    let empty = recipes_without_files(recipes);
    assert!(empty.is_empty(), "no file in: {}", empty.join(", "));
}

/// Cargo would say so too, but not before somebody tries it.
#[test]
fn tests_that_are_to_be_run_exist() {
    let text = OF_THE_TREE.map(read).concat();
    let words: Vec<&str> = text.split(|c: char| c.is_whitespace() || c == '`').collect();
    let named: Vec<&str> = words.windows(2).filter(|pair| pair[0] == "--test").map(|pair| pair[1]).collect();
    assert!(named.len() >= 5, "{named:?}");
    let binaries = test_binaries();
    // Other packages declare their tests in manifests of their own.
    let of_packages = ["service/tests", "bindings/c/tests", "examples/embedded/tests"];
    for name in named {
        let is_there = binaries.iter().any(|binary| binary == name)
            || of_packages.iter().any(|folder| exists(&format!("{folder}/{name}.rs")));
        assert!(is_there, "there is no test '{name}'");
    }
}

/// Names of the test binaries of the packages whose tests are in `tests/`.
fn test_binaries() -> Vec<String> {
    let manifests =
        ["Cargo.toml", "crates/cli/Cargo.toml", "crates/lab/Cargo.toml", "crates/shading/Cargo.toml"];
    let tables = manifests.map(|path| read(path).parse::<toml::Table>().unwrap());
    let tests = tables.iter().flat_map(|manifest| manifest["test"].as_array().unwrap());
    tests.map(|test| test["name"].as_str().unwrap().to_owned()).collect()
}

/// Cargo looks for no tests by itself (`autotests`), so a file that nothing includes would be a promise that nobody keeps.
#[test]
fn every_test_file_belongs_to_a_binary() {
    let binaries = test_binaries();
    let roots = binaries.iter().map(|name| format!("tests/{name}.rs")).filter(|path| exists(path));
    let included = roots.map(|path| read(&path)).collect::<String>();
    let is_module = |name: &str| included.contains(&format!("\nmod {name};\n"));
    let entries = std::fs::read_dir(root().join("tests")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let lost: Vec<String> = names
        .filter_map(|file| file.strip_suffix(".rs").map(str::to_owned))
        .filter(|name| !binaries.contains(name) && !is_module(name))
        .collect();
    assert!(lost.is_empty(), "in no test binary: {}", lost.join(", "));
}

/// The guide has a row for each feature, which says whether it is a default one or one of `full`.
#[test]
fn the_guide_lists_the_features() {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let features = manifest["features"].as_table().unwrap();
    let of = |group: &str| -> BTreeSet<&str> {
        features[group].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect()
    };
    let (default, full) = (of("default"), of("full"));
    assert!(default.len() > 3 && full.contains("default"), "{default:?} {full:?}");
    let there: BTreeMap<&str, &str> = features
        .keys()
        .map(String::as_str)
        .filter(|name| !["default", "full"].contains(name))
        .map(|name| match (default.contains(name), full.contains(name)) {
            (true, _) => (name, "yes"),
            (_, true) => (name, "`full`"),
            _ => (name, "no"),
        })
        .collect();
    let guide = read("src/guide/library.md");
    let table = section(&guide, "# Features").expect("there is a list of features");
    let told: BTreeMap<&str, &str> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` | "))
        .filter_map(|(name, rest)| Some((name, rest.split_once(" |")?.0)))
        .collect();
    assert_eq!(told, there);
}

#[test]
fn the_readme_leads_to_the_documents() {
    let links = links(&read("README.md"));
    for document in OF_THE_TREE {
        assert!(links.iter().any(|link| link == document), "README.md has no link to {document}");
    }
}

#[test]
fn the_reader_sees_what_it_should() {
    let text = "\n## Code map\n\n- `crates/core/src/math/`: see [there](a.md#b), `src/nowhere.rs` and `x::y`; `cargo run tests/no/`.\n\n\
                ```sh\ncat src/never.rs `x\n```\n\n### Inner\n\n- `.toml` of `target/out/`, `/dev/null`, `Nothing.toml`\n\n\
                ## Recipes\n\n### To add one\n\nIn `src/lib.rs`.\n\n### To add another\n\nSomewhere in `src/`.\n";
    let of_the_tree =
        ["crates/core/src/math/", "src/nowhere.rs", "tests/no/", "Nothing.toml", "src/lib.rs", "src/"];
    assert_eq!(paths("ARCHITECTURE.md", text), of_the_tree);
    assert_eq!(
        paths("README.md", text),
        ["crates/core/src/math/", "src/nowhere.rs", "tests/no/", "src/lib.rs", "src/"]
    );
    assert_eq!(links(text), ["a.md"]);
    let lost: Vec<&str> = of_the_tree.into_iter().filter(|path| !exists(path)).collect();
    assert_eq!(lost, ["src/nowhere.rs", "tests/no/", "Nothing.toml"]);
    assert!(!exists("Cargo.toml/"));
    let words = ["Frame", "Renderer::render", "render", "KHR_x", "ALL", "Cargo.lock", "Fn()"];
    assert_eq!(words.map(type_name), [Some("Frame"), Some("Renderer"), None, None, None, None, None]);

    let map = section(text, "## Code map").unwrap();
    assert!(map.contains("Inner") && !map.contains("To add"));
    assert!(section(text, "## Code").is_none());
    let missing = missing_in_map(map);
    assert!(!missing.contains(&"crates/core/src/math/".to_owned()));
    assert!(missing.contains(&"crates/cli/".to_owned()) && missing.contains(&"src/lib.rs".to_owned()));
    let recipes = section(text, "## Recipes").unwrap();
    assert_eq!(recipes_without_files(recipes), ["### To add another"]);
}
