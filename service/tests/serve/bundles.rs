//! Several pictures in one answer, and pictures that move.

use crate::service::{model, model_path, start, unzip};
use serde_json::Value;

#[test]
fn lists_are_pictures_in_an_archive() {
    let service = start(&["--preset", "thumb=size:24/format:webp", "--preset", "card=size:40"]);
    let cube = model("rounded-cube.glb");
    let path = "/render?views=front,top&sizes=32,48x24&background=white";
    let answer = service.request("POST", path, &[("X-Request-Id", "many")], &cube);
    assert_eq!((answer.status, answer.headers["content-type"].as_str()), (200, "application/zip"));
    assert!(!answer.headers.contains_key("overcoat-size"));
    let files = unzip(&answer.body);
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["front-32.png", "front-48x24.png", "top-32.png", "top-48x24.png", "pictures.json"]);
    let list: Value = serde_json::from_slice(&files[4].1).unwrap();
    let mut price = 0;
    for (k, query) in
        ["view=front&size=32", "view=front&size=48x24", "view=top&size=32", "view=top&size=48x24"]
            .iter()
            .enumerate()
    {
        let alone = service.post(&format!("/render?background=white&{query}"), &cube);
        assert!(alone.body == files[k].1, "{query}");
        let told = &list["pictures"][k];
        assert_eq!(alone.etag(), format!("\"{}\"", told["key"].as_str().unwrap()), "{query}");
        assert_eq!((&told["name"], &told["from"]), (&names[k].into(), &"drawn".into()));
        price += alone.headers["overcoat-price"].parse::<u64>().unwrap();
    }
    assert_eq!(answer.headers["overcoat-price"], price.to_string());
    assert_eq!(service.metric("overcoat_bundled_pictures_total"), 4.0);
    let line = service.line("many");
    assert_eq!((&line["pictures"], &line["price"]), (&4.into(), &price.into()));
    // The same bytes for the same pictures.
    assert_eq!(service.post(path, &cube).body, answer.body);
    // Presets have formats of their own.
    let answer = service.post("/render?presets=thumb,card", &cube);
    let names: Vec<String> = unzip(&answer.body).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["thumb.webp", "card.png", "pictures.json"]);
}

#[test]
fn paths_have_lists_too() {
    let folder = model_path("");
    let service = start(&["--allow-unsigned", "--local", folder.to_str().unwrap()]);
    let path = "/_/sizes:16,20/plain/local://rounded-cube.glb@webp";
    let answer = service.get(path);
    assert_eq!(unzip(&answer.body)[1].0, "20.webp");
    let known = service.request("GET", path, &[("If-None-Match", answer.etag())], &[]);
    assert_eq!((known.status, known.body.len()), (304, 0));
}

#[test]
fn lists_have_bounds() {
    let service = start(&["--max-pictures", "3", "--max-price", "40"]);
    let cube = model("rounded-cube.glb");
    for (query, status, kind, what) in [
        ("sizes=1,2,3,4", 400, "options", "4 pictures, and 3 are allowed"),
        ("sizes=16,16", 400, "options", "stands there twice"),
        ("sizes=16,x", 400, "options", "WIDTHxHEIGHT"),
        ("presets=a,b", 400, "preset", "there is none 'a'"),
        ("sizes=256,300,301&quality=good", 422, "price", "are allowed"),
    ] {
        let (told, message) = service.post(&format!("/render?{query}"), &cube).error(status);
        assert!(told == kind && message.contains(what), "{query}: {message}");
    }
    // No worker was asked for any of that; a model that fails is told with the picture that it fails in.
    assert_eq!(service.metric("overcoat_units_total"), 0.0);
    let (kind, message) = service.post("/render?sizes=16,20", &cube[..500]).error(422);
    assert!(kind == "model" && message.starts_with("16.png: "), "{message}");
    assert_eq!(service.metric("overcoat_bundled_pictures_total"), 0.0);
}

/// Frames of an animated WebP and its size; of a GIF, its frames.
fn webp_frames(bytes: &[u8]) -> usize {
    assert!(bytes.starts_with(b"RIFF") && &bytes[8..12] == b"WEBP");
    bytes.windows(4).filter(|four| four == b"ANMF").count()
}

#[test]
fn models_turn() {
    let service = start(&["--max-price", "200"]);
    let cube = model("rounded-cube.glb");
    let still = service.post("/render?size=48", &cube);
    let turn = service.request("POST", "/render?size=48&turntable=6", &[("X-Request-Id", "turn")], &cube);
    assert_eq!((turn.status, turn.headers["content-type"].as_str()), (200, "image/webp"));
    assert_eq!((webp_frames(&turn.body), turn.headers["overcoat-size"].as_str()), (6, "48x48"));
    let price = |answer: &crate::service::Answer| answer.headers["overcoat-price"].parse::<u64>().unwrap();
    assert_eq!(price(&turn), 6 * price(&still));
    let line = service.line("turn");
    assert!(line["options"].as_str().unwrap().contains("turntable=6"), "{line}");
    assert_eq!(line["price"], price(&turn));
    let gif = service.post("/render?size=48&turntable=6&format=gif&fps=10", &cube);
    assert_eq!((gif.status, gif.headers["content-type"].as_str()), (200, "image/gif"));
    assert!(gif.body.starts_with(b"GIF89a"));
    let png = service.post("/render?size=48&turntable=3&format=png", &cube);
    assert_eq!((png.status, png.headers["content-type"].as_str()), (200, "image/apng"));
    assert!(png.body.windows(4).any(|four| four == b"acTL"));
    // A still picture after one that has turned has its light where it was.
    assert_eq!(service.post("/render?size=48&samples=8&format=png&dpr=1", &cube).body, still.body);
    for (query, status, kind, what) in [
        ("format=gif", 400, "options", "gif with a turntable"),
        ("turntable=4&format=jpg", 400, "options", "webp, gif or png"),
        ("turntable=100000", 422, "limit", "3600"),
        ("turntable=100&size=256", 422, "price", "are allowed"),
        ("fps=12", 400, "options", "turntable"),
    ] {
        let (told, message) = service.post(&format!("/render?{query}"), &cube).error(status);
        assert!(told == kind && message.contains(what), "{query}: {message}");
    }
    // One of several pictures may turn, and a path may.
    let both = service.post("/render?sizes=16,20&turntable=2&format=gif", &cube);
    let names: Vec<String> = unzip(&both.body).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["16.gif", "20.gif", "pictures.json"]);
}

/// The same bytes as those of the command line.
#[test]
fn turns_are_those_of_the_command_line() {
    let folder = model_path("");
    let service = start(&["--allow-unsigned", "--local", folder.to_str().unwrap()]);
    let served = service.get("/_/size:40/turntable:4/fps:10/plain/local://torus-knot.obj@gif");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("turn.gif");
    // In a process of its own: the command listens to signals, which would break off what other tests read.
    let run = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "bundles::the_command_line_turns", "--ignored"])
        .env(TURN, &out)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stdout));
    let alone = std::fs::read(&out).unwrap();
    assert!(served.body == alone, "not the same bytes");
}

/// File that the test below writes.
const TURN: &str = "TURN_OUT";

#[test]
#[ignore = "a part of another test, in a process of its own"]
fn the_command_line_turns() {
    let Ok(out) = std::env::var(TURN) else { return };
    let model = model_path("torus-knot.obj");
    let arguments = ["overcoat", "turntable", model.to_str().unwrap(), "-o", &out];
    let options = ["--size", "40", "--frames", "4", "--fps", "10"];
    assert_eq!(overcoat_cli::run_arguments(arguments.iter().chain(&options)), 0);
}
