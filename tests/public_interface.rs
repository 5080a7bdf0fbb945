//! The public interface, item by item, in `tests/public_interface.txt`: a change of it is a change of that file, and is seen.
//!
//! `UPDATE_INTERFACE=1 cargo test --test documents public_interface` writes the file anew.
//!
//! The sources are read line by line as rustfmt leaves them. Items that macros make are listed as they are handed to the macro.
//! What is `#[doc(hidden)]` (stages, formulas, the program) is open to tests and benches and no part of the interface.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What leaves an item, and all within it, out of the interface.
const HIDDEN: &str = "#[doc(hidden)]";

/// Definitions that have a second path, and why.
const SECOND_PATHS: [(&str, &str); 5] = [
    ("Frame", "the short way to what every program names"),
    ("Limits", "the short way"),
    ("RenderOptions", "the short way"),
    ("Renderer", "the short way"),
    ("Scene", "the short way"),
];

/// Something that is declared at the top of a module.
#[derive(Clone, Debug, Default)]
struct Definition {
    public: bool,
    /// Its own line, then those of its fields, variants and functions, each after the end of its path.
    lines: Vec<(String, String)>,
}

#[derive(Debug, Default)]
struct Module {
    public_children: Vec<String>,
    definitions: BTreeMap<String, Definition>,
    /// Path as written and the name here, of public ones.
    uses: Vec<(Vec<String>, String)>,
    /// Type, and the lines of an `impl`.
    impls: Vec<(String, Vec<(String, String)>)>,
    /// Macros that are called with what they make.
    calls: Vec<String>,
}

type Modules = BTreeMap<Vec<String>, Module>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The modules of all files below a folder.
fn read(folder: &Path, path: &[String], modules: &mut Modules) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for entry in entries {
        let name = entry.file_stem().unwrap().to_string_lossy().into_owned();
        let below: Vec<String> = path.iter().cloned().chain([name.clone()]).collect();
        if entry.is_dir() {
            read(&entry, &below, modules);
        } else if entry.extension().is_some_and(|e| e == "rs") && name != "main" {
            let own = if ["mod", "lib"].contains(&name.as_str()) { path.to_vec() } else { below };
            modules.insert(own, parse(&std::fs::read_to_string(&entry).unwrap()));
        }
    }
}

/// One space between words, none inside of brackets, no comma before a closing one: however long the line is.
fn joined(lines: &[&str]) -> String {
    let text = lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    text.replace("( ", "(").replace(", )", ")").replace(" )", ")").replace(", >", ">").replace("< ", "<")
}

/// The name after a keyword.
fn name_after(text: &str, keyword: &str) -> Option<String> {
    let rest = text.strip_prefix(keyword)?;
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

/// Kind and name of what a declaration without its `pub` declares.
fn declared(text: &str) -> Option<String> {
    let keywords = ["const fn ", "fn ", "struct ", "enum ", "trait ", "const ", "type ", "static "];
    keywords.iter().find_map(|keyword| name_after(text, keyword))
}

/// The lines from one on up to the end of what it declares, without body and value. Returns how many there are.
fn header(lines: &[&str]) -> (String, usize) {
    let constant = ["const ", "static "].iter().any(|keyword| {
        let text = lines[0].trim().trim_start_matches("pub ");
        text.starts_with(keyword) && !text.starts_with("const fn ")
    });
    let mut taken = 0;
    for line in lines {
        taken += 1;
        let line = line.trim_end();
        let value = constant && (line.contains(" = ") || line.ends_with(" ="));
        if value || line.contains(" {") || line.trim() == "{" || line.ends_with(';') {
            break;
        }
    }
    let text = joined(&lines[..taken]);
    let text = text.split(" {").next().unwrap_or_default().trim_end_matches([';', '{', ' ']);
    let text = if constant { text.split(" =").next().unwrap_or_default() } else { text };
    (text.strip_prefix("pub ").unwrap_or(text).to_owned(), taken)
}

/// `impl<A> Trait<B> for Type<C>` as trait and name of the type.
fn implemented(header: &str) -> (Option<String>, String) {
    let mut rest = header.trim_start_matches("impl");
    if rest.starts_with('<') {
        let mut depth = 0;
        let end = rest.char_indices().find(|&(at, c)| {
            depth += match c {
                '<' => 1,
                '>' if !rest[..at].ends_with('-') => -1,
                _ => 0,
            };
            depth == 0
        });
        rest = &rest[end.map_or(0, |(at, _)| at + 1)..];
    }
    let rest = rest.split(" where").next().unwrap_or_default().trim();
    let (of, on) = match rest.split_once(" for ") {
        Some((of, on)) => (Some(of.trim().to_owned()), on),
        None => (None, rest),
    };
    let name = on.trim().split(['<', ' ']).next().unwrap_or_default();
    (of, name.rsplit("::").next().unwrap_or_default().to_owned())
}

/// What a `use` names: `a::{b, c::{d, e as f}}` flattened.
fn used(tree: &str, before: &[String], found: &mut Vec<(Vec<String>, String)>) {
    let tree = tree.trim();
    if let Some((path, group)) = tree.split_once('{') {
        let mut before = before.to_vec();
        before.extend(path.split("::").map(str::trim).filter(|part| !part.is_empty()).map(str::to_owned));
        let (mut depth, mut entry) = (0, String::new());
        for c in group[..group.rfind('}').unwrap_or(group.len())].chars().chain([',']) {
            match c {
                ',' if depth == 0 => used(&std::mem::take(&mut entry), &before, found),
                _ => {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    entry.push(c);
                }
            }
        }
    } else if !tree.is_empty() {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, ""));
        let mut parts = before.to_vec();
        parts.extend(path.split("::").map(|part| part.trim().to_owned()));
        let name = if name.is_empty() { parts.last().cloned().unwrap_or_default() } else { name.to_owned() };
        found.push((parts, name));
    }
}

/// Lines of a body, each with the end of its path: public fields and functions; all variants, and all functions of traits.
fn members(name: &str, body: &[&str], all: bool) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut at = 0;
    let mut hidden = false;
    while at < body.len() {
        let line = body[at];
        let text = line.trim_start();
        let skipped = line.len() - text.len() != 4 || text.starts_with(['/', '#', '}', ')', ']']);
        if skipped {
            hidden |= text == HIDDEN;
            at += 1;
            continue;
        }
        if std::mem::take(&mut hidden) || !(all || text.starts_with("pub ")) {
            at += 1;
            continue;
        }
        let declaration = text.trim_start_matches("pub ");
        if let Some(function) = declared(declaration) {
            let (text, taken) = header(&body[at..]);
            found.push((format!("{name}::{function}"), text));
            at += taken;
        } else if !all || text.ends_with(',') || text.ends_with('{') || text.ends_with('(') {
            // A field, or a variant with its fields.
            let mut end = at;
            while !body[end].ends_with(',') || (body[end].len() - body[end].trim_start().len()) != 4 {
                end += 1;
                if end == body.len() {
                    return found;
                }
            }
            let code: Vec<&str> =
                body[at..=end].iter().copied().filter(|l| !l.trim_start().starts_with(['/', '#'])).collect();
            let text = joined(&code).trim_end_matches(',').to_owned();
            let text = text.strip_prefix("pub ").unwrap_or(&text).replace(", }", " }");
            let member = text.split([':', ' ', '(', ',']).next().unwrap_or_default();
            found.push((format!("{name}::{member}"), text.clone()));
            at = end + 1;
        } else {
            at += 1;
        }
    }
    found
}

/// What a source declares.
fn parse(text: &str) -> Module {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    let mut module = Module::default();
    let mut attributes: Vec<&str> = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let line = lines[at];
        at += 1;
        if line.starts_with("#[") {
            attributes.push(line);
            continue;
        }
        if line.starts_with(char::is_whitespace) || line.starts_with("//") || line.is_empty() {
            continue;
        }
        let attributes = std::mem::take(&mut attributes);
        // The lines up to the brace that closes what is opened here.
        let body = |from: usize| {
            let closes = |line: &&str| line.starts_with('}');
            let opens = lines[from - 1].ends_with('{');
            let end =
                if opens { lines[from..].iter().position(closes).map_or(from, |k| from + k) } else { from };
            (&lines[from..end], end)
        };
        let public = line.starts_with("pub ") && !attributes.contains(&HIDDEN);
        let item = line.strip_prefix("pub ").unwrap_or(line);
        if let Some(child) = name_after(item, "mod ") {
            if public {
                module.public_children.push(child);
            }
        } else if let Some(tree) = item.strip_prefix("use ") {
            let mut tree = tree.to_owned();
            while !tree.ends_with(';') {
                tree.push_str(lines[at].trim());
                at += 1;
            }
            if public {
                used(tree.trim_end_matches(';'), &[], &mut module.uses);
            }
        } else if item.starts_with("impl") {
            let (text, taken) = header(&lines[at - 1..]);
            let (body, end) = body(at - 1 + taken);
            let (of, name) = implemented(&text);
            let lines = match of {
                Some(of) => vec![(format!("{name}: {of}"), String::new())],
                None => members(&name, body, false),
            };
            module.impls.push((name, lines));
            at = end;
        } else if line.starts_with(char::is_lowercase)
            && line.contains('!')
            && !line.starts_with("macro_rules!")
        {
            let (body, end) = body(at);
            let arguments =
                body.iter().filter(|l| l.starts_with("    ") && !l.trim_start().starts_with(['/', '#']));
            let calls = [line].into_iter().chain(arguments.copied()).map(|l| l.trim().to_owned());
            let said = |call: &String| !call.ends_with('{') && !call.starts_with("compile_error!");
            module.calls.extend(calls.filter(said));
            at = end;
        } else if let Some(name) = declared(item) {
            let (text, taken) = header(&lines[at - 1..]);
            let (body, end) = body(at - 1 + taken);
            let shown = attributes
                .iter()
                .filter(|a| ["#[derive", "#[non_exh", "#[cfg("].iter().any(|k| a.starts_with(k)));
            let shown: String = shown.map(|a| format!("{a} ")).collect();
            let mut all = vec![(name.clone(), shown + &text)];
            if ["struct ", "enum ", "trait "].iter().any(|kind| text.starts_with(kind)) {
                all.extend(members(&name, body, !text.starts_with("struct ")));
            }
            module.definitions.insert(name, Definition { public, lines: all });
            at = end;
        }
    }
    module
}

/// The module that a path names, seen from another.
fn resolve(modules: &Modules, from: &[String], path: &[String]) -> Option<Vec<String>> {
    let mut at: Vec<String> = from.to_vec();
    for (k, part) in path.iter().enumerate() {
        match part.as_str() {
            "crate" if k == 0 => at.clear(),
            "self" => {}
            "super" => drop(at.pop()),
            part => at.push(part.to_owned()),
        }
    }
    modules.contains_key(&at).then_some(at)
}

/// Where the definition of a public name is.
fn definition(modules: &Modules, module: &[String], name: &str) -> Option<Vec<String>> {
    let found = modules.get(module)?;
    if found.definitions.get(name).is_some_and(|d| d.public) {
        return Some(module.to_vec());
    }
    let (path, _) = found.uses.iter().find(|(_, here)| here == name)?;
    let (last, before) = path.split_last()?;
    definition(modules, &resolve(modules, module, before)?, last)
}

/// Paths of every public definition: module and name where it is declared, and where programs find it.
fn public_paths(modules: &Modules) -> BTreeMap<(Vec<String>, String), BTreeSet<String>> {
    let mut paths: BTreeMap<_, BTreeSet<String>> = BTreeMap::new();
    let mut queue = vec![Vec::new()];
    while let Some(path) = queue.pop() {
        let Some(module) = modules.get(&path) else { continue };
        let full = |name: &str| path.iter().map(String::as_str).chain([name]).collect::<Vec<_>>().join("::");
        for (name, _) in module.definitions.iter().filter(|(_, d)| d.public) {
            paths.entry((path.clone(), name.clone())).or_default().insert(full(name));
        }
        for (from, name) in &module.uses {
            let Some((last, before)) = from.split_last() else { continue };
            let place = resolve(modules, &path, before).and_then(|m| definition(modules, &m, last));
            if let Some(place) = place {
                paths.entry((place, last.clone())).or_default().insert(full(name));
            }
        }
        queue.extend(
            module
                .public_children
                .iter()
                .map(|child| path.iter().cloned().chain([child.clone()]).collect::<Vec<_>>()),
        );
    }
    paths
}

/// The module that declares the type of an `impl`: its own, else the nearest one above whose part of the tree has only one.
fn home(modules: &Modules, from: &[String], name: &str) -> Option<Vec<String>> {
    if modules[from].definitions.contains_key(name) {
        return Some(from.to_vec());
    }
    (0..=from.len()).rev().find_map(|depth| {
        let below =
            |m: &&Vec<String>| m.starts_with(&from[..depth]) && modules[*m].definitions.contains_key(name);
        let mut found = modules.keys().filter(below);
        found.next().filter(|_| found.next().is_none()).cloned()
    })
}

/// Modules that programs can name.
fn public_modules(modules: &Modules) -> BTreeSet<Vec<String>> {
    let mut found = BTreeSet::from([Vec::new()]);
    let mut queue = vec![Vec::new()];
    while let Some(path) = queue.pop() {
        let children = modules.get(&path).map_or(&[][..], |module| &module.public_children);
        let children =
            children.iter().map(|child| path.iter().cloned().chain([child.clone()]).collect::<Vec<_>>());
        queue.extend(children.filter(|child| found.insert(child.clone())));
    }
    found
}

/// The interface, an item a line, in the order of their paths.
fn listing(modules: &Modules) -> Vec<String> {
    let paths = public_paths(modules);
    let seen = public_modules(modules);
    let mut lines = BTreeSet::new();
    // A type is at home in the part of the tree that declares it, at the shortest of its paths there.
    let home_path = |module: &[String], all: &BTreeSet<String>| {
        let elsewhere =
            |path: &str| module.first().is_some_and(|first| path.split("::").next() != Some(first));
        all.iter()
            .min_by_key(|path| (elsewhere(path), path.matches("::").count()))
            .cloned()
            .unwrap_or_default()
    };
    let mut add = |path: &str, name: &str, members: &[(String, String)]| {
        for (end, text) in members {
            let end = end.strip_prefix(name).unwrap_or(end);
            lines.insert(format!("{path}{end}  {text}").trim_end().to_owned());
        }
    };
    for ((module, name), all) in &paths {
        let path = home_path(module, all);
        add(&path, name, &modules[module].definitions[name].lines);
        for other in all.iter().filter(|other| **other != path) {
            add(other, name, &[(name.clone(), format!("= {path}"))]);
        }
    }
    for (from, module) in modules {
        for (name, members) in &module.impls {
            let Some(home) = home(modules, from, name) else { continue };
            if let Some(all) = paths.get(&(home.clone(), name.clone())) {
                add(&home_path(&home, all), name, members);
            }
        }
        for call in module.calls.iter().filter(|_| seen.contains(from)) {
            add(&from.join("::"), "", &[(String::new(), call.clone())]);
        }
    }
    lines.into_iter().collect()
}

fn modules() -> Modules {
    let mut modules = Modules::new();
    read(&root().join("src"), &[], &mut modules);
    modules
}

#[test]
fn the_interface_is_the_recorded_one() {
    let file = root().join("tests/public_interface.txt");
    let lines = listing(&modules());
    assert!(lines.len() > 500, "only {} items found", lines.len());
    let now = lines.join("\n") + "\n";
    if std::env::var_os("UPDATE_INTERFACE").is_some_and(|value| value == "1") {
        std::fs::write(&file, now).unwrap();
        return;
    }
    let recorded = std::fs::read_to_string(&file).unwrap_or_default();
    let (old, new): (BTreeSet<&str>, BTreeSet<&str>) = (recorded.lines().collect(), now.lines().collect());
    let gone = old.difference(&new).map(|line| format!("- {line}"));
    let added = new.difference(&old).map(|line| format!("+ {line}"));
    let changes: Vec<String> = gone.chain(added).collect();
    assert!(
        changes.is_empty(),
        "the public interface has changed:\n{}\nIf that is meant, say so in CHANGELOG.md and write the list anew:\n\
         UPDATE_INTERFACE=1 cargo test --test documents public_interface",
        changes.join("\n")
    );
}

#[test]
fn everything_has_one_path() {
    let several: Vec<_> = public_paths(&modules())
        .into_iter()
        .filter(|((_, name), paths)| paths.len() > 1 && SECOND_PATHS.iter().all(|(known, _)| known != name))
        .map(|(_, paths)| paths)
        .collect();
    assert!(several.is_empty(), "{several:#?}");
}

#[test]
fn the_reader_sees_what_it_should() {
    let text = "pub use a::{B, c::{D, E as F}};\n/// Text.\n#[derive(Clone)]\n#[non_exhaustive]\npub enum G {\n    /// One.\n    \
                #[default]\n    One,\n    Two {\n        /// X.\n        x: u32,\n    },\n}\npub struct H<T> {\n    pub a: [T; 3],\n    \
                b: u8,\n}\nimpl<T: Fn() -> u8> H<T> {\n    pub const ALL: &[Self] = &[];\n    pub fn long(\n        &self,\n        x: u8,\n    \
                ) -> u8 {\n        0\n    }\n    fn own() {}\n}\nimpl From<u8> for G {\n    fn from(_: u8) -> Self {\n        Self::One\n    \
                }\n}\nfn private() {}\n#[doc(hidden)]\npub mod i;\npub mod j;\n#[doc(hidden)]\npub fn k() {}\nimpl \
                G {\n    /// Text.\n    #[doc(hidden)]\n    pub fn l() {}\n    pub fn m() {}\n}\n#[cfg(test)]\nmod tests {\n}\n";
    let module = parse(text);
    let names: Vec<String> =
        module.uses.iter().map(|(path, name)| format!("{} {name}", path.join("::"))).collect();
    assert_eq!(names, ["a::B B", "a::c::D D", "a::c::E F"]);
    let show = |lines: &[(String, String)]| {
        lines.iter().map(|(end, text)| format!("{end}  {text}")).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(
        show(&module.definitions["G"].lines),
        "G  #[derive(Clone)] #[non_exhaustive] enum G; G::One  One; G::Two  Two { x: u32 }"
    );
    assert_eq!(show(&module.definitions["H"].lines), "H  struct H<T>; H::a  a: [T; 3]");
    let impls: Vec<String> =
        module.impls.iter().map(|(name, lines)| format!("{name} {}", show(lines))).collect();
    assert_eq!(
        impls,
        [
            "H H::ALL  const ALL: &[Self]; H::long  fn long(&self, x: u8) -> u8",
            "G G: From<u8>  ",
            "G G::m  fn m()"
        ]
    );
    assert!(!module.definitions["private"].public && !module.definitions["k"].public);
    assert_eq!(module.public_children, ["j"]);
}
