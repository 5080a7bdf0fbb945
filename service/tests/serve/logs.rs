//! The log: one line for each request, with all that an operator asks about it and nothing that is secret.

use crate::service::{PROGRAM, Service, form, model, model_path, ok, source_server, start, start_with};
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

fn post(service: &Service, path: &str, id: &str, more: &[(&str, &str)], body: &[u8]) -> Value {
    let headers = [&[("X-Request-Id", id)], more].concat();
    let answer = service.request("POST", path, &headers, body);
    assert_eq!(answer.headers["x-request-id"], id);
    let line = service.line(id);
    assert_eq!(line["status"], answer.status);
    assert_eq!(line["bytes_out"], answer.body.len());
    assert!(line["total_ms"].as_f64().unwrap() >= 0.0);
    line
}

#[test]
fn pictures_have_lines() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, models) = (folder.path().to_str().unwrap(), model_path(""));
    let args = ["--cache", cache, "--preset", "thumb=size:40/view:front"];
    let service = start(&[&args[..], &["--allow-unsigned", "--local", models.to_str().unwrap()]].concat());
    let cube = model("rounded-cube.glb");
    let named = [("Content-Disposition", "attachment; filename=\"my cube.glb\"")];
    let first = post(&service, "/render?preset=thumb&samples=4", "first", &named, &cube);
    for (key, value) in [
        ("method", Value::from("POST")),
        ("route", "render".into()),
        ("client", "127.0.0.1".into()),
        ("source", "upload".into()),
        ("file", "my cube.glb".into()),
        ("preset", "thumb".into()),
        ("options", "format=png&samples=4&size=40x40&view=front".into()),
        ("bytes_in", cube.len().into()),
        ("result", "rendered".into()),
        ("warnings", 0.into()),
    ] {
        assert_eq!(first[key], value, "{key}: {first}");
    }
    assert_eq!(first["model"], blake3::hash(&cube).to_hex().to_string());
    assert!(first["queue_ms"].is_number() && first["worker"].is_number(), "{first}");
    if cfg!(target_os = "linux") {
        // In steps of 10 ms.
        assert!(first["cpu_ms"].as_f64().unwrap() < 20_000.0, "{first}");
    }
    for absent in ["error", "reason", "trace_id", "traceparent"] {
        assert!(first.get(absent).is_none(), "{absent}: {first}");
    }
    service.wait_for("overcoat_cache_total{event=\"write\"}", 2.0);
    // An equal query in another order comes from the cache, without work.
    let again =
        post(&service, "/render?view=front&size=40&samples=4&format=png&name=b.glb", "again", &[], &cube);
    assert_eq!(again["result"], "cached");
    assert_eq!((&again["key"], &again["options"]), (&first["key"], &first["options"]));
    assert_eq!(again["file"], "b.glb");
    for absent in ["queue_ms", "cpu_ms", "preset", "worker"] {
        assert!(again.get(absent).is_none(), "{absent}: {again}");
    }
    let tag = format!("\"{}\"", first["key"].as_str().unwrap());
    let path = "/_/samples:4/pr:thumb/plain/local://rounded-cube.glb@png";
    let headers = [("X-Request-Id", "third"), ("If-None-Match", &tag)];
    assert_eq!(service.request("GET", path, &headers, &[]).status, 304);
    let third = service.line("third");
    assert_eq!((&third["result"], &third["source"]), (&"known".into(), &"local://rounded-cube.glb".into()));
    assert_eq!((&third["bytes_in"], &third["bytes_out"]), (&cube.len().into(), &0.into()));
    // A picture with a loss.
    let (kind, body) = form(&[("model", Some("torus-knot.obj"), &model("torus-knot.obj"))]);
    let lossy = post(&service, "/render?size=16", "lossy", &[("Content-Type", &kind)], &body);
    assert_eq!((&lossy["warnings"], &lossy["bytes_in"]), (&1.into(), &body.len().into()));
}

#[test]
fn refusals_have_lines() {
    let service = start(&["--max-body", "10k"]);
    let broken = &model("rounded-cube.glb")[..300];
    let line = post(&service, "/render?size=16", "broken", &[], broken);
    assert_eq!((&line["result"], &line["error"]), (&"failed".into(), &"model".into()));
    assert!(!line["reason"].as_str().unwrap().is_empty() && line.get("key").is_none(), "{line}");
    assert!(line["model"].is_string() && line["queue_ms"].is_number(), "{line}");
    assert_eq!(post(&service, "/info", "info", &[], broken)["error"], "model");
    let line = post(&service, "/render?size=0", "options", &[], broken);
    assert_eq!((&line["error"], line.get("options")), (&"options".into(), None));
    let line = post(&service, "/render", "large", &[], &[b'x'; 20_000]);
    assert_eq!((&line["error"], &line["bytes_in"]), (&"too_large".into(), &20_000.into()));
    // Requests for no picture are "answered".
    service.request("GET", "/health", &[("X-Request-Id", "health")], &[]);
    assert_eq!(service.line("health")["result"], "answered");
}

/// Names that are longer, or of other characters, than names are: the service makes its own.
#[test]
fn names_of_requests_are_plain() {
    let service = start(&[]);
    let long = "x".repeat(101);
    let mut made = Vec::new();
    for name in ["a b", "a\"b", "a{b}", "", &long, "é"] {
        let answer = service.request("GET", "/health", &[("X-Request-Id", name)], &[]);
        let id = answer.headers["x-request-id"].clone();
        assert!(id != name && id.split_once('-').is_some(), "{name}: {id}");
        assert_eq!(service.line(&id)["route"], "health");
        made.push(id);
    }
    made.sort();
    made.dedup();
    assert_eq!(made.len(), 6);
}

/// Work of which nobody waits for the result has its line, too.
#[test]
fn who_goes_away_has_a_line() {
    let service = start(&["--deadline", "100"]);
    let car = model("sports-car.glb");
    let mut stream = service.connect();
    let head = format!(
        "POST /render?size=300 HTTP/1.1\r\nHost: x\r\nX-Request-Id: gone-1\r\nContent-Length: {}\r\n\r\n",
        car.len()
    );
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(&car).unwrap();
    service.wait_for("overcoat_workers_busy", 1.0);
    drop(stream);
    let line = service.line("gone-1");
    assert_eq!((&line["result"], line.get("status")), (&"gone".into(), None), "{line}");
    assert_eq!(line["bytes_in"], car.len());
}

const PARENT: &str = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

#[test]
fn traces_go_through() {
    let service = start(&["--log", "debug"]);
    let cube = model("rounded-cube.glb");
    let line = post(&service, "/render?size=16", "traced", &[("traceparent", PARENT)], &cube);
    assert_eq!((&line["traceparent"], &line["trace_id"]), (&PARENT.into(), &PARENT[3..35].into()));
    // The worker's line has them too.
    let log = service.log();
    let work = log.lines().find(|line| line.contains("\"worked\"")).unwrap();
    let work: Value = serde_json::from_str(work).unwrap();
    assert_eq!((&work["id"], &work["trace_id"]), (&"traced".into(), &PARENT[3..35].into()));
    assert_eq!(work["worker"], line["worker"]);
    let zero = PARENT.replace("b7ad6b7169203331", "0000000000000000");
    for (k, wrong) in [&PARENT[1..], &PARENT.to_uppercase(), &zero, "x"].into_iter().enumerate() {
        let line = post(&service, "/render?size=16", &format!("wrong-{k}"), &[("traceparent", wrong)], &cube);
        assert!(line.get("traceparent").is_none() && line.get("trace_id").is_none(), "{line}");
        assert_eq!(line["status"], 200);
    }
}

/// All requests whose texts try to be lines of their own, in both formats.
#[test]
fn nobody_writes_into_the_log() {
    for format in ["json", "text"] {
        let service = start(&["--log-format", format, "--allow-unsigned", "--preset", "thumb=size:16"]);
        let cube = model("rounded-cube.glb");
        let evil = "a%0A%7B%22id%22%3A%22evil%22%7D%0D%1B%5B2J%7F%C2%85%E2%80%A8%22%20status%3D999%20.glb";
        let mut count = 0;
        let mut ask = |method: &str, path: &str, headers: &[(&str, &str)]| {
            service.request(method, path, headers, if method == "POST" { &cube } else { &[] });
            count += 1;
        };
        ask("POST", &format!("/render?size=16&name={evil}"), &[]);
        ask("POST", "/render?size=16", &[("Content-Disposition", &format!("x; filename*=UTF-8''{evil}"))]);
        ask("POST", &format!("/render?size={evil}"), &[]);
        ask("POST", &format!("/render?{evil}=1"), &[]);
        ask("POST", &format!("/render?animation={evil}"), &[]);
        ask("POST", &format!("/render?preset={evil}"), &[]);
        ask("POST", &format!("/info?name={evil}"), &[]);
        ask("GET", &format!("/_/size:16/plain/local://{evil}@png"), &[]);
        ask("GET", &format!("/_/size:{evil}/plain/local://a.glb@png"), &[]);
        ask("GET", &format!("/{evil}"), &[("X-Request-Id", "a\tb"), ("traceparent", "00-\t")]);
        ask("GET", "/health", &[("X-Request-Id", "last")]);
        let end = Instant::now() + Duration::from_secs(60);
        while !service.log().contains("last") {
            assert!(Instant::now() < end, "{}", service.log());
            std::thread::sleep(Duration::from_millis(10));
        }
        let log = service.log();
        let lines: Vec<&str> = log.lines().collect();
        // And one that says that it listens.
        assert_eq!(lines.len(), count + 1, "{format}: {log}");
        for line in &lines {
            assert!(!line.contains(|c: char| c.is_control() || c == '\u{2028}'), "{format}: {line:?}");
            if format == "json" {
                let line: Value = serde_json::from_str(line).unwrap();
                assert!(line["id"] != "evil" && line["status"] != 999, "{line}");
                for (_, value) in line.as_object().unwrap() {
                    let text = value.as_str().unwrap_or_default();
                    assert!(!text.contains(|c: char| c.is_control() || c == '\u{2028}'), "{line}");
                }
            } else {
                // A quotation mark in a name ends nothing.
                assert!(!line.contains("}\" status=999"), "{line}");
            }
        }
        assert!(lines.iter().any(|line| line.contains("a\\") && line.contains(".glb")), "{format}: {log}");
    }
}

/// Signatures, passwords and queries of sources are in no line, and in no answer.
#[test]
fn secrets_are_in_no_line() {
    let port = source_server(|path, _| match path.contains("good") {
        true => ok(&model("rounded-cube.glb")),
        false => b"HTTP/1.1 500 No\r\nContent-Length: 0\r\n\r\n".to_vec(),
    });
    let (key, salt) = ("736563726574", "706570706572");
    let host = format!("127.0.0.1:{port}");
    let sign = |path: &str| {
        let mut command = std::process::Command::new(PROGRAM);
        let output = command.args(["serve", "--key", key, "--salt", salt, "--sign", path]).output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    for format in ["json", "text"] {
        let allowed = format!("http://{host}/");
        let args = ["--allow-source", &allowed, "--allow-network", "127.0.0.0/8", "--log", "debug"];
        let variables = [("OVERCOAT_KEY", key), ("OVERCOAT_SALT", salt), ("OVERCOAT_LOG_FORMAT", format)];
        let service = start_with(Path::new(PROGRAM), &args, &variables);
        let mut signatures = Vec::new();
        let mut answers = Vec::new();
        for source in [
            format!("http://{host}/good.glb%3Fsig=HUSH"),
            format!("http://{host}/bad.glb%3Fsig=HUSH%26key=HUSH"),
            format!("http://{host}/bad.glb%23HUSH"),
            format!("http://me:HUSH%40{host}/good.glb"),
            "https://me:HUSH%40example.com/a.glb%3FHUSH".to_owned(),
            "http://%3FHUSH".to_owned(),
        ] {
            let path = sign(&format!("/size:16/plain/{source}@png"));
            signatures.push(path.split('/').nth(1).unwrap().to_owned());
            answers.push(service.get(&path));
            // Signatures of another path.
            answers.push(service.get(&path.replace("size:16", "size:17")));
            answers.push(service.get(&format!("/info{path}")));
        }
        answers[0].png(16, 16);
        // Nor what a client means to be a secret of another service.
        service.post("/render?key=HUSH&sig=HUSH", &model("rounded-cube.glb")).error(400);
        service.request("GET", "/health", &[("Authorization", "Bearer HUSH"), ("X-Request-Id", "last")], &[]);
        let end = Instant::now() + Duration::from_secs(60);
        while !service.log().contains("last") && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(10));
        }
        let log = service.log();
        assert!(log.contains("/good.glb?...") && log.contains("last"), "{format}: {log}");
        for secret in ["HUSH", key, salt].into_iter().chain(signatures.iter().map(String::as_str)) {
            assert!(!log.contains(secret), "{format}: {secret}: {log}");
        }
        for answer in answers.iter().filter(|answer| answer.status != 200) {
            let text = String::from_utf8_lossy(&answer.body);
            assert!(!text.contains("HUSH"), "{text}");
        }
    }
}

/// The key of the configuration file.
#[test]
fn lines_can_be_text() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("overcoat.toml");
    std::fs::write(&file, "log_format = 'text'\n").unwrap();
    let service = start(&["--config", file.to_str().unwrap()]);
    let headers = [("X-Request-Id", "text-1"), ("traceparent", PARENT)];
    let answer = service.request("POST", "/render?size=16", &headers, &model("rounded-cube.glb"));
    answer.png(16, 16);
    let end = Instant::now() + Duration::from_secs(60);
    let line = loop {
        if let Some(line) = service.log().lines().find(|line| line.contains("text-1")) {
            break line.to_owned();
        }
        assert!(Instant::now() < end, "{}", service.log());
        std::thread::sleep(Duration::from_millis(10));
    };
    for part in [
        " INFO id=\"text-1\" method=\"POST\" route=\"render\" client=127.0.0.1 source=\"upload\"",
        " options=\"format=png&size=16x16\"",
        &format!(" key={}", answer.etag()),
        " status=200 result=\"rendered\" warnings=0",
        &format!(" traceparent=\"{PARENT}\""),
    ] {
        assert!(line.contains(part), "{part}: {line}");
    }
}
