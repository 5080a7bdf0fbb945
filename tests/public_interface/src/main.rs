//! Prints the public interface of `overcoat`, an item a line, from the JSON of rustdoc of its packages.
//!
//! The library re-exports items of the packages below it, which tools list as one line each. Here the members of those items are listed
//! too, under the names by which users reach them. A name of another package that is left in a line is a type that users meet
//! and cannot name.
//!
//! Usage: public-interface FOLDER     with `overcoat.json` and `overcoat_*.json`

#![forbid(unsafe_code)]

use public_api::Builder;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::Path;

/// One package: its items as lines, and the sources of its re-exports.
struct Package {
    lines: Vec<(String, String)>,
    /// Source of a public path, as it is written in the code.
    uses: BTreeMap<String, String>,
    /// The path of the same item in the modules where it is written, which other packages' documents have.
    written: BTreeMap<String, String>,
}

/// The path that begins in `text`, without parameters of types.
fn path_at(text: &str) -> String {
    let (mut path, mut depth) = (String::new(), 0);
    for c in text.chars() {
        match c {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ if depth > 0 => {}
            ':' => path.push(c),
            c if c.is_alphanumeric() || c == '_' => path.push(c),
            _ => break,
        }
    }
    path.trim_end_matches(':').to_owned()
}

/// The path of an item; of an implementation that of its type.
fn path_of(line: &str, package: &str) -> Option<String> {
    let start = format!("{package}::");
    let at = match line.starts_with("impl") {
        true => line.rfind(&format!(" for {start}")).map(|at| at + 5).or_else(|| line.find(&start)),
        false => line.find(&start),
    };
    at.map(|at| path_at(&line[at..]))
}

/// Adds the re-exports of a module and of those in it.
fn add_uses(document: &Value, module: &Value, path: &str, package: &mut Package) {
    for id in module["inner"]["module"]["items"].as_array().into_iter().flatten() {
        let item = &document["index"][id.to_string()];
        if let Some(found) = item["inner"].get("use") {
            let (name, source) =
                (found["name"].as_str().unwrap_or(""), found["source"].as_str().unwrap_or(""));
            let path = format!("{path}::{name}");
            let written = document["paths"][found["id"].to_string()]["path"].as_array().into_iter().flatten();
            let written: Vec<&str> = written.filter_map(Value::as_str).collect();
            package.written.insert(path.clone(), written.join("::"));
            package.uses.insert(path, source.to_owned());
        } else if let Some(name) = item["name"].as_str().filter(|_| item["inner"].get("module").is_some()) {
            add_uses(document, item, &format!("{path}::{name}"), package);
        }
    }
}

fn read(path: &Path, name: &str) -> Result<Package, Box<dyn Error>> {
    let builder = Builder::from_rustdoc_json(path).omit_blanket_impls(true).omit_auto_trait_impls(true);
    let items = builder.omit_auto_derived_impls(true).build()?;
    let lines = items.items().map(ToString::to_string);
    let lines = lines.filter_map(|line| Some((path_of(&line, name)?, line))).collect();
    let document: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let mut package = Package { lines, uses: BTreeMap::new(), written: BTreeMap::new() };
    add_uses(&document, &document["index"][document["root"].to_string()], name, &mut package);
    Ok(package)
}

/// Path of the definition that an item's path leads to, as far as it is known.
fn definition(packages: &BTreeMap<String, Package>, path: &str) -> String {
    let mut path = path.to_owned();
    while let Some(package) = path.split("::").next().and_then(|name| packages.get(name)) {
        let is_here = package.lines.iter().any(|(p, line)| *p == path && !line.starts_with("pub use "));
        match package
            .uses
            .get(&path)
            .filter(|source| !is_here && packages.contains_key(source.split("::").next().unwrap_or("")))
        {
            Some(source) => path.clone_from(source),
            None => break,
        }
    }
    path
}

/// Replaces a path where it stands whole.
fn renamed(line: &str, from: &str, to: &str) -> String {
    let mut out = String::new();
    let mut rest = line;
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let goes_on = after.chars().next().is_some_and(|c| c.is_alphanumeric() || c == '_');
        out.push_str(before);
        out.push_str(if goes_on { from } else { to });
        rest = after;
    }
    out + rest
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: public-interface FOLDER")?;
    let mut packages = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("").to_owned();
        if path.extension().is_some_and(|extension| extension == "json") && name.starts_with("overcoat") {
            packages.insert(name.clone(), read(&path, &name)?);
        }
    }
    let facade = packages.get("overcoat").ok_or("there is no overcoat.json")?;
    // Longer paths first, so that a module does not stand in for what is in it. Of two names of one item that within a module counts.
    let mut names: Vec<(String, String)> =
        facade.uses.keys().map(|name| (definition(&packages, name), name.clone())).collect();
    names.extend(
        facade
            .written
            .iter()
            .filter(|(_, path)| !path.is_empty())
            .map(|(name, path)| (path.clone(), name.clone())),
    );
    names.sort_by_key(|(source, name)| {
        (std::cmp::Reverse(source.len()), std::cmp::Reverse(name.matches("::").count()))
    });

    let mut out = BTreeSet::new();
    for (_, line) in &facade.lines {
        out.insert(line.clone());
    }
    for (source, _) in &names {
        let Some(package) = source.split("::").next().and_then(|name| packages.get(name)) else { continue };
        let inner = format!("{source}::");
        out.extend(
            package
                .lines
                .iter()
                .filter(|(path, _)| path == source || path.starts_with(&inner))
                .map(|(_, line)| line.clone()),
        );
    }
    let spelt =
        |line: &String| names.iter().fold(line.clone(), |line, (source, name)| renamed(&line, source, name));
    let lines: BTreeSet<String> = out.iter().map(spelt).collect();
    // Items that are listed with their members need no line that says that they are re-exported.
    let defined: BTreeSet<String> = lines
        .iter()
        .filter(|line| !line.starts_with("pub use "))
        .filter_map(|line| path_of(line, "overcoat"))
        .collect();
    for line in lines {
        if line.strip_prefix("pub use ").is_none_or(|path| !defined.contains(path)) {
            println!("{line}");
        }
    }
    Ok(())
}
