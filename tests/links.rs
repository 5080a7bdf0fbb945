//! Links of every Markdown file lead to files and headings that are there.

use super::pages::{Page, files, root};
use std::collections::BTreeMap;

/// Lines outside of fenced blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut inside = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        inside ^= fence;
        !inside && !fence
    })
}

/// A text without what stands in backticks.
fn without_code(text: &str) -> String {
    text.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// Targets of links and pictures, and of definitions (`[name]: target`). Paths of Rust, which rustdoc resolves, are none.
fn links(text: &str) -> Vec<String> {
    let prose: Vec<&str> = prose(text).collect();
    let mut targets = Vec::new();
    for paragraph in prose.join("\n").split("\n\n") {
        let code_free = without_code(paragraph);
        targets.extend(
            code_free.split("](").skip(1).filter_map(|rest| rest.split(')').next()).map(str::to_owned),
        );
    }
    let definitions =
        prose.iter().filter(|line| line.starts_with('[')).filter_map(|line| line.split_once("]: "));
    targets.extend(definitions.map(|(_, target)| target.trim().to_owned()));
    targets.retain(|target| !target.contains("::"));
    targets
}

/// The anchor that GitHub and mdBook give a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Anchors of all headings; those of equal headings are counted on.
fn anchors(text: &str) -> Vec<String> {
    let mut seen = BTreeMap::new();
    let headings = prose(text).filter_map(|line| {
        let heading = line.trim_start_matches('#');
        (heading.len() < line.len() && heading.starts_with(' ')).then(|| anchor(heading))
    });
    headings
        .map(|name| {
            let count = seen.entry(name.clone()).and_modify(|n| *n += 1).or_insert(0);
            if *count == 0 { name } else { format!("{name}-{count}") }
        })
        .collect()
}

/// The mistake of a link, if it has one.
fn mistake(page: &Page, link: &str) -> Option<String> {
    let (path, heading) = link.split_once('#').map_or((link, None), |(path, heading)| (path, Some(heading)));
    let target = if path.is_empty() {
        page.path.clone()
    } else {
        page.target(path).to_str().unwrap().replace('\\', "/")
    };
    if !root().join(&target).exists() {
        return Some(format!("{}: {link} does not exist", page.path));
    }
    if page.path.starts_with("docs/src/") && target.ends_with(".md") && !target.starts_with("docs/src/") {
        // mdBook makes .html of every .md, of files that are no chapters too.
        return Some(format!("{}: {link} is no chapter: nothing is there in the built book", page.path));
    }
    let heading = heading.filter(|_| target.ends_with(".md"))?;
    let there = anchors(&Page::read(&target).text);
    (!there.iter().any(|name| name == heading)).then(|| format!("{}: {link} has no such heading", page.path))
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut paths = files();
    paths.retain(|path| path.ends_with(".md"));
    assert!(paths.len() > 40, "{paths:?}");
    let mut mistakes = Vec::new();
    let mut seen = 0;
    for path in paths {
        let page = Page::read(&path);
        // Addresses of the net are not asked.
        for link in links(&page.text).iter().filter(|link| !link.contains(':')) {
            mistakes.extend(mistake(&page, link));
            seen += 1;
        }
    }
    assert!(mistakes.is_empty(), "\n{}", mistakes.join("\n"));
    assert!(seen > 150, "only {seen} links found");
}

#[test]
fn mistakes_are_seen() {
    let text = "# A book\n\n## A `part` of it: 2\n\n[a](README.md#no), `[b](c)` and\n[d](docs/none.md)\n\n\
                ```text\n[e](f)\n```\n\n[g]: #a-part-of-it-2\n[h](crate::i) ![j](docs)\n\n## A book\n";
    let page = Page { path: "README.md".to_owned(), text: text.to_owned() };
    assert_eq!(links(text), ["README.md#no", "docs/none.md", "docs", "#a-part-of-it-2"]);
    assert_eq!(anchors(text), ["a-book", "a-part-of-it-2", "a-book-1"]);
    let mistakes: Vec<bool> = links(text).iter().map(|link| mistake(&page, link).is_some()).collect();
    // The last one is a heading of this text, and not of the file.
    assert_eq!(mistakes, [true, true, false, true]);
    let chapter = Page { path: "docs/src/start.md".to_owned(), text: String::new() };
    assert!(mistake(&chapter, "../../README.md").is_some() && mistake(&chapter, "service.md").is_none());
}
