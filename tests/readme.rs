//! README and book tell the truth: their commands run, their options exist, their tables are complete, their pictures are
//! made by the commands beside them. The README is short.

use super::pages::{Page, manual, overcoat, root};
use std::collections::BTreeSet;
use std::path::Path;

/// Most lines and bytes of the README.
const SHORT: (usize, usize) = (150, 9000);

/// Chapters about `overcoat-service`, whose tests hold them against its own help.
const OF_THE_SERVICE: [&str; 4] =
    ["docs/src/agents.md", "docs/src/cost.md", "docs/src/many-files.md", "docs/src/service.md"];

/// Chapter of scripts, in which other programs have options too; a test of its own holds its commands.
const RECIPES: &str = "docs/src/recipes.md";

/// Every command that has a help of its own.
const COMMANDS: [&str; 22] = [
    "lab",
    "conformance",
    "translate",
    "render",
    "thumbnail",
    "turntable",
    "animate",
    "info",
    "diagnose",
    "sheet",
    "bench",
    "compare-models",
    "diff",
    "materials",
    "formats",
    "guide",
    "golden",
    "golden check",
    "golden report",
    "golden accept",
    "completions",
    "man",
];

/// The words of a text that look like options: `--` and a letter.
fn options(text: &str) -> BTreeSet<String> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'))
        .filter(|word| {
            word.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
        })
        .map(str::to_owned)
        .collect()
}

fn help(command: &str) -> String {
    let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
    let output = overcoat(root(), &words);
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn options_of_the_manual_exist_and_all_of_render_are_there() {
    let known: BTreeSet<String> = COMMANDS.iter().flat_map(|c| options(&help(c))).collect();
    // Options of cargo, of containers and overcoat-service in one, of the installer of the C library, of F3D, of converters.
    let others = "--release --bench --example --help --locked --open --path --rm --network --listen --prefix \
                  --resolution --camera-direction --background-color --angle --deflection --disable-autoexec --factory-startup --python --pixels --no-install-recommends";
    let others = options(others);
    let mut mentioned = BTreeSet::new();
    for page in
        manual().into_iter().filter(|page| !OF_THE_SERVICE.contains(&&page.path[..]) && page.path != RECIPES)
    {
        let options = options(&page.text);
        for option in options.difference(&others) {
            assert!(known.contains(option), "{option} is in {} and not in --help", page.path);
        }
        mentioned.extend(options);
    }
    for option in ["Animation:", "Camera:", "Light:", "Picture:", "Display:"].iter().flat_map(|heading| {
        let help = help("render");
        let section = help.split(&format!("\n{heading}\n")).nth(1).unwrap().to_owned();
        // Up to the next heading, which is the next line that is not indented.
        let section: Vec<&str> =
            section.lines().take_while(|line| line.is_empty() || line.starts_with(' ')).collect();
        let names: Vec<String> = section
            .iter()
            .filter_map(|line| line.trim_start().strip_prefix("--"))
            .map(|rest| format!("--{}", rest.split([' ', '[']).next().unwrap()))
            .collect();
        assert!(!names.is_empty(), "{heading} lists nothing");
        names
    }) {
        assert!(mentioned.contains(&option), "{option} is in --help and not in the manual");
    }
}

/// Pictures of a page that the program makes, each with its command: in a listing below, or beside it in a row of a table.
fn pictures(page: &Page) -> Vec<(String, String)> {
    let lines: Vec<&str> = page.text.lines().collect();
    let mut commands = page.commands().into_iter();
    let mut found = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let Some(link) = line.split("![").nth(1).and_then(|rest| rest.split(['(', ')']).nth(1)) else {
            continue;
        };
        let path = page.target(link).to_str().unwrap().replace('\\', "/");
        let command = if line.starts_with('|') {
            line.split('`').find(|code| code.starts_with("overcoat ")).unwrap().to_owned()
        } else {
            assert_eq!(lines[at + 1..at + 3], ["", "```sh"], "there is no command under {path}");
            commands.find(|command| command.contains(&path)).unwrap_or_default()
        };
        assert!(command.split(' ').any(|word| word == path), "'{command}' does not write {path}");
        found.push((path, command));
    }
    found
}

/// A reader sees the work of the commands. `UPDATE_PICTURES=1` makes the pictures anew, and fails: look at them.
#[test]
fn pictures_are_made_by_the_commands_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let pictures: BTreeSet<(String, String)> = manual().iter().flat_map(pictures).collect();
    assert!(pictures.len() > 8, "{pictures:?}");
    let update = std::env::var_os("UPDATE_PICTURES").is_some_and(|value| value == "1");
    let mut others = Vec::new();
    for (path, command) in pictures {
        let made = folder.path().join("picture").with_extension(Path::new(&path).extension().unwrap());
        let words = command.split_whitespace().skip(1);
        let arguments: Vec<&str> =
            words.map(|word| if word == path { made.to_str().unwrap() } else { word }).collect();
        let output = overcoat(root(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        // A sandbox that this system cannot give is no matter of the picture.
        assert!(output.status.success(), "{command}: {message}");
        assert!(arguments[0] == "thumbnail" || message.is_empty(), "{command}: {message}");
        let bytes = std::fs::read(&made).unwrap();
        let known = root().join(&path);
        if std::fs::read(&known).ok().as_ref() != Some(&bytes) {
            if update {
                std::fs::write(&known, bytes).unwrap();
            }
            others.push(path);
        }
    }
    let how = if update { "made anew" } else { "not made by their commands" };
    assert!(others.is_empty(), "{how}: {}", others.join(", "));
}

#[test]
fn the_readme_is_short() {
    let text = Page::read("README.md").text;
    assert!(text.lines().count() <= SHORT.0 && text.len() <= SHORT.1, "{} bytes", text.len());
    let pictures = pictures(&Page::read("README.md"));
    let bytes = |path: &str| std::fs::metadata(root().join(path)).unwrap().len();
    let all: u64 = pictures.iter().map(|(path, _)| bytes(path)).sum();
    assert!(pictures.len() > 5 && all < 400_000, "{all} bytes of pictures");
}

/// Figures of the README are copies of those in the book.
#[test]
fn the_speed_of_the_readme_is_that_of_the_benchmarks() {
    let readme = Page::read("README.md").text;
    let section = readme.split("\n## Speed\n").nth(1).unwrap().split("\n## ").next().unwrap();
    let chapter = Page::read("docs/src/benchmarks.md").text;
    let rows = section.lines().filter(|line| line.starts_with("| ")).skip(1);
    let cells = rows.flat_map(|row| row.trim_matches('|').split('|').skip(1).map(str::trim));
    let cells: Vec<&str> = cells.filter(|cell| !cell.is_empty()).collect();
    assert!(cells.len() > 8, "{cells:?}");
    for cell in cells {
        assert!(chapter.contains(&format!("| {cell}")), "'{cell}' is not in {}", "docs/src/benchmarks.md");
    }
    for factor in ["6.0 times", "10.4 times"] {
        assert!(section.contains(factor) && chapter.contains(factor), "{factor}");
    }
}

/// Every example of the program is accepted: it fails for want of its files and not for its options.
#[test]
fn examples_of_the_manual_and_of_help_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let pages = manual().into_iter().filter(|page| page.path != RECIPES);
    let mut lines: BTreeSet<String> = pages.flat_map(|page| page.commands()).collect();
    for command in COMMANDS {
        lines.extend(help(command).lines().map(|line| line.trim().to_owned()));
    }
    let mut tried = 0;
    for line in lines {
        // Pipes are the business of the shell.
        let Some(arguments) = line.strip_prefix("overcoat ") else { continue };
        let arguments: Vec<&str> =
            arguments.split(['<', '>', '|']).next().unwrap().split_whitespace().collect();
        if ["batch", "serve"].contains(&arguments[0]) {
            // Another program's.
            continue;
        }
        // A measurement is a file, and takes the place of the referee.
        let lab = arguments[0] == "lab" && !arguments.contains(&"--measured");
        // The number of samples does not matter here; and outputs of the lab have no folder.
        let few = if lab && !arguments.contains(&"--paint") { &["--samples", "256"][..] } else { &[] };
        let arguments: Vec<&str> = match arguments.iter().position(|argument| *argument == "--samples") {
            Some(k) if lab => [&arguments[..k], few, &arguments[k + 2..]].concat(),
            _ => [&arguments[..], few].concat(),
        };
        let arguments: Vec<&str> = match arguments[..] {
            // Nor does what is in the pack depend on how many pixels there are.
            ["conformance", name, ..] => vec!["conformance", name, "--size", "32", "--samples", "32"],
            _ => arguments,
        };
        for outputs in ["src/guide", "assets"] {
            std::fs::create_dir_all(folder.path().join(outputs)).unwrap();
        }
        let output = overcoat(folder.path(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        if arguments.starts_with(&["translate", "candy-red"]) {
            // Features that the other engine does not know are a warning.
            assert!(output.status.success() && message.starts_with("warning: "), "{line}: {message}");
            continue;
        }
        if lab
            || ["conformance", "materials", "formats", "guide", "completions"].contains(&arguments[0])
            || arguments == ["man"]
        {
            // It needs no file.
            assert_eq!((output.status.code(), message.as_str()), (Some(0), ""), "{line}");
            continue;
        }
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("No such file") || message.contains("standard input"), "{line}: {message}");
        tried += 1;
    }
    assert!(tried >= 12, "only {tried} examples found");
}

#[test]
fn the_first_command_of_the_readme_makes_a_picture() {
    let commands = Page::read("README.md").commands();
    let line = commands.iter().find_map(|line| line.strip_prefix("cargo run --release -- ")).unwrap();
    let (input, output) = line.strip_prefix("render ").unwrap().split_once(" -o ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(output);
    let done = overcoat(root(), &["render", input, "-o", picture.to_str().unwrap(), "--size", "64"]);
    assert_eq!((done.status.code(), String::from_utf8(done.stderr).unwrap().as_str()), (Some(0), ""));
    assert!(std::fs::metadata(picture).unwrap().len() > 500);
    // It leaves a checkout as it was.
    let ignored = std::fs::read_to_string(root().join(".gitignore")).unwrap();
    assert!(
        !output.contains('/') && output.ends_with(".png") && ignored.lines().any(|line| line == "/*.png")
    );
}

/// The tables have all formats that the program reads and writes, and every command has its example.
#[test]
fn every_format_and_every_command_is_in_the_manual() {
    let manual: String = manual().into_iter().map(|page| page.text).collect();
    for command in COMMANDS.iter().filter(|command| **command != "golden") {
        assert!(manual.contains(&format!("overcoat {command}")), "{command}");
    }
    let tables = ["README.md", "docs/src/formats.md"].map(Page::read);
    let formats = overcoat(root(), &["formats", "--json"]).stdout;
    let formats: serde_json::Value = serde_json::from_slice(&formats).unwrap();
    let mut seen = 0;
    for direction in ["read", "written"] {
        for (kind, entries) in formats[direction].as_object().unwrap() {
            for entry in entries.as_array().unwrap() {
                let name = entry["name"].as_str().unwrap();
                let extension = entry["extensions"][0].as_str().unwrap();
                for Page { path, text } in &tables {
                    let is_named = text.contains(name) || text.contains(&format!("`.{extension}`"));
                    assert!(is_named, "{name} ({kind}, {direction}) is not in {path}");
                }
                assert!(entry["mime_type"].as_str().unwrap().contains('/'), "{name}");
                seen += 1;
            }
        }
    }
    assert!(seen >= 20, "{formats}");
}

#[test]
fn the_table_of_limits_is_complete_and_right() {
    // The derived Debug output lists the fields with their defaults.
    let text = format!("{:?}", overcoat::limits::Limits::default());
    let fields: Vec<(&str, u64)> = text
        .trim_start_matches("Limits {")
        .trim_end_matches('}')
        .split(',')
        .filter_map(|part| part.split_once(':'))
        .map(|(name, value)| (name.trim(), value.trim().parse().unwrap()))
        .collect();
    assert!(fields.len() >= 11);
    let chapter = Page::read("docs/src/limits-and-security.md").text;
    for (name, value) in fields {
        let row = chapter.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
        let row = row.unwrap_or_else(|| panic!("{name} is not in the table of limits"));
        let stated = row.split('|').nth(2).unwrap().trim();
        let stated = if let Some(exponent) = stated.strip_prefix("2^") {
            1_u64 << exponent.parse::<u32>().unwrap()
        } else if let Some(gib) = stated.strip_suffix(" GiB") {
            (gib.parse::<f64>().unwrap() * f64::from(1 << 30)) as u64
        } else {
            stated.parse().unwrap()
        };
        assert_eq!(stated, value, "{name}");
    }
}

/// Every command line of the page of recipes is accepted, whatever is around it in a script, a rule or a configuration.
#[test]
fn recipes_are_accepted() {
    let page = std::fs::read_to_string(root().join(RECIPES)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut inside = false;
    let mut tried = 0;
    for line in page.lines() {
        if line.starts_with("```") {
            inside = !inside;
        }
        // As a word of its own: addresses end in the name as well.
        let is_word = |at: usize| at == 0 || line[..at].ends_with(' ');
        let command = line.match_indices("overcoat ").map(|(at, _)| at).find(|&at| is_word(at));
        let Some(at) = command.filter(|_| inside) else { continue };
        // Variables that stand for numbers; those that stand for files are names like others here.
        let command = line[at..].replace("$((h * 2))", "48").replace("${w}", "40");
        let command =
            [" |", " &&", "'", " >"].iter().fold(&command[..], |line, end| line.split(end).next().unwrap());
        let arguments: Vec<&str> =
            command.split_whitespace().skip(1).map(|word| word.trim_matches('"')).collect();
        let output = overcoat(folder.path(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("No such file"), "{line}: {message}");
        tried += 1;
    }
    assert!(tried >= 10, "only {tried} recipes found");
}
