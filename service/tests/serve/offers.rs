//! Offers of the operator: presets, prices, and turns of clients.

use crate::service::{Service, model, model_path, run, start};
use std::path::Path;

const CUBE: &str = "rounded-cube.glb";

/// A service with a file of presets.
fn start_with_presets(text: &str, args: &[&str]) -> Service {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("presets.toml");
    std::fs::write(&path, text).unwrap();
    start(&[&["--presets", path.to_str().unwrap()], args].concat())
}

#[test]
fn the_example_is_taken() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets.toml");
    let local = model_path("");
    let service = start(&[
        "--presets",
        path.to_str().unwrap(),
        "--max-price",
        "1000",
        "--allow-unsigned",
        "--local",
        local.to_str().unwrap(),
    ]);
    let cube = model(CUBE);
    let formats = service.get("/formats").json();
    assert_eq!(formats["presets"], serde_json::json!(["card", "hero", "thumb"]));
    let thumb = service.post("/render?preset=thumb&name=a.glb", &cube);
    assert_eq!(
        (thumb.headers["content-type"].as_str(), thumb.headers["overcoat-size"].as_str()),
        ("image/webp", "128x128")
    );
    // A path names it alone, too.
    for path in ["/_/thumb/plain/local://rounded-cube.glb", "/_/preset:thumb/plain/local://rounded-cube.glb"]
    {
        assert_eq!(service.get(path).etag(), thumb.etag(), "{path}");
    }
    service.post("/render?preset=card&size=64&format=png", &cube).png(64, 64);
    for (query, kind, what) in [
        ("preset=poster", "preset", "none 'poster', but card, hero, thumb"),
        ("size=8", "not_offered", "16 to 1024"),
        ("preset=hero&size=2000", "not_offered", "16 to 1024"),
        ("quality=best", "not_offered", "draft, fast"),
        ("rays=1", "not_offered", "rays: this option is not offered here"),
    ] {
        let (told, message) = service.post(&format!("/render?{query}"), &cube).error(400);
        assert_eq!(told, kind, "{query}");
        assert!(message.contains(what), "{query}: {message}");
    }
    for (kind, count) in [("preset", 1.0), ("not_offered", 4.0)] {
        assert_eq!(service.metric(&format!("overcoat_refusals_total{{kind=\"{kind}\"}}")), count);
    }
}

/// The example of the manual is one, too.
#[test]
fn the_listing_of_the_manual_is_taken() {
    let manual = include_str!("../../../docs/src/service.md");
    let listing = manual.split("```toml\n").find(|part| part.starts_with("# Nothing but presets")).unwrap();
    let service = start_with_presets(listing.split("```").next().unwrap(), &[]);
    service.post("/render?preset=thumb&format=png", &model(CUBE)).png(256, 256);
}

#[test]
fn presets_may_be_all_that_is_offered() {
    let service = start_with_presets("only = true\n[preset]\nthumb = 'size:32'", &[]);
    let cube = model(CUBE);
    service.post("/render?preset=thumb", &cube).png(32, 32);
    for query in ["", "?size=32", "?preset=thumb&size=32", "?preset=thumb&preset=thumb"] {
        assert_eq!(service.post(&format!("/render{query}"), &cube).error(400).0, "not_offered", "{query}");
    }
    assert_eq!(service.get("/formats").json()["presets_only"], true);
    assert_eq!(service.post("/info", &cube).status, 200);
}

#[test]
fn prices_are_told_and_bounded() {
    let service = start(&["--max-price", "50", "--queue", "1"]);
    let cube = model(CUBE);
    for (query, price) in [("size=256", "9"), ("size=64&quality=draft", "6"), ("size=256&quality=good", "31")]
    {
        let answer = service.post(&format!("/render?{query}"), &cube);
        assert_eq!((answer.status, answer.headers["overcoat-price"].as_str()), (200, price), "{query}");
    }
    assert_eq!(service.metric("overcoat_units_total"), 46.0);
    assert_eq!(service.post("/info", &cube).headers["overcoat-price"], "5");
    let dear = service.request("POST", "/render?size=512&quality=good", &[("X-Request-Id", "dear")], &cube);
    let (kind, message) = dear.error(422);
    assert_eq!((kind.as_str(), dear.headers["overcoat-price"].as_str()), ("price", "85"));
    assert!(message.contains("costs 85 units, and 50 are allowed"), "{message}");
    assert_eq!(dear.json()["error"]["limit"], "max_price");
    assert_eq!(service.metric("overcoat_units_total"), 51.0);
    assert_eq!(service.metric("overcoat_refusals_total{kind=\"price\"}"), 1.0);
    service.request("POST", "/render?size=64", &[("X-Request-Id", "cheap")], &cube);
    assert_eq!(service.line("cheap")["price"], 7);
}

#[test]
fn wrong_files_end_the_service() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("presets.toml");
    let started = |text: &str, more: &[&str]| {
        std::fs::write(&path, text).unwrap();
        let args = [&["serve", "--listen", "0", "--presets", path.to_str().unwrap()], more].concat();
        let output = run(&args);
        assert_eq!(output.status.code(), Some(2), "{text}");
        String::from_utf8(output.stderr).unwrap()
    };
    for (text, more, what) in [
        (
            "[allow]\nsize = { min = 3, max = 2 }",
            &[][..],
            "presets.toml: allow.size: the range from 3 to 2 is empty",
        ),
        ("[preset]\na = 'size:9999'", &[], "presets.toml: preset.a: size: expected 1 to 2048"),
        ("[preset]\na = 'colour:red'", &[], "preset.a: colour: there is no such option"),
        ("[preset]\na = 'size:2000'", &["--max-price", "10"], "preset.a: what is asked for costs 217 units"),
        ("[preset]\na = 'size:20'", &["--preset", "a=size:30"], "another preset of this name"),
        ("only = true", &[], "only: there are no presets"),
    ] {
        let message = started(text, more);
        assert!(message.contains(what), "{text}: {message}");
    }
    std::fs::remove_file(&path).unwrap();
    let output = run(&["serve", "--listen", "0", "--presets", path.to_str().unwrap()]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("presets.toml: No such file"));
}
