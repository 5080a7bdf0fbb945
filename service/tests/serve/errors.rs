//! A test for each row of the table of errors in docs/src/service.md.

use crate::service::{form, model, model_path, ok, read_answer, run, source_server, start, start_with};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// A picture that takes a worker some seconds.
const SLOW: &str = "/render?size=2048&quality=best&samples=16&rays=64";

#[test]
fn options_are_refused_with_their_range() {
    let service = start(&["--max-size", "300"]);
    let cube = model("rounded-cube.glb");
    for (query, what) in [
        ("size=301", "1 to 300"),
        ("size=x", "WIDTHxHEIGHT"),
        ("samples=3", "1, 4, 8 or 16"),
        ("jpeg_quality=0", "1 to 100"),
        ("quality=ultra", "quality"),
        ("colour=red", "no such option"),
        ("env=%2Fetc%2Fpasswd", "sky or none"),
        ("material=%2Fetc%2Fpasswd.toml", "no built-in material"),
        ("model=a.glb", "names files"),
        ("format=gif", "png, webp"),
    ] {
        let (kind, message) = service.post(&format!("/render?{query}"), &cube).error(400);
        assert_eq!(kind, "options", "{query}");
        assert!(message.contains(what), "{query}: {message}");
    }
    let error = &service.post("/render?size=301", &cube).json()["error"];
    assert_eq!((error["limit"].as_str(), error["raise"].is_string()), (Some("max_size"), true));
    // An option of the model that it does not have is the model's.
    service.post("/render?animation=walk", &cube).error(422);
    let (form_type, body) = form(&[("size", None, b"500"), ("model", Some("a.glb"), &cube)]);
    let answer = service.request("POST", "/render", &[("Content-Type", &form_type)], &body);
    assert!(answer.error(400).1.contains("1 to 300"));
    // No worker was asked for any of that.
    assert_eq!(service.metric("overcoat_refusals_total{kind=\"options\"}"), 12.0);
    service.post("/render?size=32", &cube).png(32, 32);
}

#[test]
fn paths_need_a_signature() {
    let service = start(&["--key", "aa", "--salt", "bb"]);
    let answer = service.get("/unsafe/size:64/plain/local://x.glb@png");
    assert_eq!(answer.error(401).0, "unsigned");
    assert!(answer.headers.contains_key("www-authenticate"));
    assert_eq!(service.get("/AAAA/size:64/plain/local://x.glb@png").error(403).0, "signature");
}

#[test]
fn sources_need_to_be_allowed() {
    let service = start(&["--allow-unsigned"]);
    for source in ["local://x.glb", "https://example.com/x.glb", "s3://bucket/x.glb", "file:///etc/passwd"] {
        assert_eq!(service.get(&format!("/_/plain/{source}@png")).error(403).0, "source", "{source}");
    }
}

#[test]
fn what_is_not_there_is_not_found() {
    let folder = model_path("");
    let service = start(&["--allow-unsigned", "--local", folder.to_str().unwrap()]);
    for path in ["/nothing", "/a/b", "/_/plain/local://none.glb@png"] {
        assert_eq!(service.get(path).error(404).0, "not_found", "{path}");
    }
}

#[test]
fn pages_get_a_picture_in_place_of_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.webp");
    let picture = b"RIFF\0\0\0\0WEBPVP8L of a test";
    std::fs::write(&path, picture).unwrap();
    let models = model_path("");
    let fallback = path.to_str().unwrap();
    let service = start(&["--allow-unsigned", "--local", models.to_str().unwrap(), "--fallback", fallback]);
    let ask = |path: &str, headers: &[(&str, &str)]| service.request("GET", path, headers, &[]);
    let (img, program) = ([("Sec-Fetch-Dest", "image")], [("Accept", "application/json, image/*;q=0.5")]);
    for (path, status, kind) in [
        ("/_/plain/local://none.glb@png", 404, "not_found"),
        ("/_/size:99999/plain/local://rounded-cube.glb@png", 400, "options"),
        ("/AAAA/plain/local://rounded-cube.glb@png", 403, "signature"),
    ] {
        let answer = ask(path, &img);
        assert_eq!((answer.status, &answer.body[..]), (status, &picture[..]), "{path}");
        let header = |name: &str| answer.headers[name].as_str();
        assert_eq!(
            ["content-type", "fallback-image", "overcoat-error", "cache-control"].map(header),
            ["image/webp", "1", kind, "no-store"]
        );
        assert_eq!(header("content-length"), picture.len().to_string());
        assert_eq!(ask(path, &program).error(status).0, kind);
    }
    ask("/_/size:16/plain/local://rounded-cube.glb@png", &img).png(16, 16);
    // Nothing but pictures.
    assert_eq!(ask("/info/_/plain/local://none.glb", &img).error(404).0, "not_found");
    assert_eq!(service.metric("overcoat_refusals_total{kind=\"options\"}"), 2.0);
}

#[test]
fn methods_are_told() {
    let service = start(&[]);
    let answer = service.get("/render");
    assert_eq!(answer.error(405).0, "method");
    assert_eq!(answer.headers["allow"], "POST");
    service.request("DELETE", "/health", &[], &[]).error(405);
}

#[test]
fn formats_that_nobody_makes_are_not_acceptable() {
    let service = start(&[]);
    let cube = model("rounded-cube.glb");
    let answer = service.request("POST", "/render", &[("Accept", "text/html, image/gif")], &cube);
    assert_eq!(answer.error(406).0, "not_acceptable");
    let answer =
        service.request("POST", "/render?size=16", &[("Accept", "image/webp, image/png;q=0.5")], &cube);
    assert_eq!((answer.status, answer.headers["content-type"].as_str()), (200, "image/webp"));
    assert_eq!(answer.headers["vary"], "Accept");
}

#[test]
fn slow_bodies_are_given_up() {
    let service = start(&["--body-seconds", "0.5", "--body-rate", "1M"]);
    let mut stream = service.connect();
    stream.write_all(b"POST /render HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nglTF").unwrap();
    assert_eq!(read_answer(&mut stream, "POST").unwrap().error(408).0, "slow");
    // Nor does it help to send a byte from time to time.
    let mut stream = service.connect();
    stream.write_all(b"POST /render HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n").unwrap();
    for _ in 0..20 {
        std::thread::sleep(Duration::from_millis(50));
        let _ = stream.write_all(b"x");
    }
    assert_eq!(read_answer(&mut stream, "POST").unwrap().error(408).0, "slow");
}

#[test]
fn large_bodies_are_refused() {
    let service = start(&["--max-body", "1000"]);
    let answer = service.post("/render", &vec![b'v'; 5_000_000]);
    assert_eq!(answer.error(413).0, "too_large");
    assert_eq!(answer.json()["error"]["limit"], "max_body");
    // One that does not say how long it is.
    let mut stream = service.connect();
    stream.write_all(b"POST /render HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n").unwrap();
    for _ in 0..20 {
        stream.write_all(format!("64\r\n{}\r\n", "v".repeat(100)).as_bytes()).unwrap();
    }
    stream.write_all(b"0\r\n\r\n").unwrap();
    assert_eq!(read_answer(&mut stream, "POST").unwrap().error(413).0, "too_large");
}

#[test]
fn other_files_are_called_what_they_are() {
    let service = start(&[]);
    for (body, query, what) in [
        (&b"\x89PNG\r\n\x1a\n"[..], "", "a PNG picture"),
        (b"BLENDER-v300", "?name=a.blend", "Blender"),
        (b"%PDF-1.7", "", "PDF"),
        (b"whatever", "?name=a.blend", ".blend"),
        (b"whatever", "", "nothing says what it is"),
        (b"", "", "empty"),
    ] {
        let (kind, message) = service.post(&format!("/render{query}"), body).error(415);
        assert_eq!(kind, "media_type");
        assert!(message.contains(what), "{message}");
    }
    let (kind, _) = service.request("POST", "/render", &[("Content-Type", "text/css")], b"a{}").error(415);
    assert_eq!(kind, "media_type");
}

#[test]
fn ranges_that_there_are_not_are_refused() {
    let folder = model_path("");
    let service = start(&["--allow-unsigned", "--local", folder.to_str().unwrap()]);
    let path = "/_/size:16/plain/local://rounded-cube.glb@png";
    let answer = service.request("GET", path, &[("Range", "bytes=1000000-")], &[]);
    assert_eq!(answer.error(416).0, "range");
    assert!(answer.headers["content-range"].starts_with("bytes */"));
}

#[test]
fn damaged_models_and_limits_are_told() {
    let service = start(&["--limit", "triangles=100"]);
    let cube = model("rounded-cube.glb");
    let answer = service.post("/render?size=16", &cube);
    assert_eq!(answer.error(422).0, "limit");
    let error = &answer.json()["error"];
    assert_eq!(
        (&error["limit"], &error["raise"]),
        (&"triangles".into(), &"start the service with --limit triangles=N".into())
    );
    for damaged in [&cube[..cube.len() / 2], b"glTF\x02\0\0\0", b"{}", b"ply\nformat nothing\n"] {
        let (kind, message) = service.post("/render?size=16", damaged).error(422);
        assert_eq!(kind, "model", "{message}");
    }
    assert_eq!(service.post("/info", &cube[..100]).error(422).0, "model");
    // Nobody died of any of that.
    assert_eq!(service.metric("overcoat_workers_died_total"), 0.0);
}

#[test]
fn workers_have_so_much_memory() {
    // A picture of 8192 x 8192 needs more than a worker has here.
    let service = start(&["--memory", "300Mi", "--max-size", "8192"]);
    let answer = service.post("/render?size=8192&samples=16&quality=draft", &model("rounded-cube.glb"));
    assert_eq!(answer.status, 422, "{}", String::from_utf8_lossy(&answer.body));
    let kind = answer.error(422).0;
    assert!(matches!(kind.as_str(), "memory" | "limit"), "{kind}");
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
}

#[test]
fn a_worker_that_is_killed_is_told_and_replaced() {
    let service = start(&["--deadline", "100"]);
    let address = service.address;
    let slow = std::thread::spawn(move || {
        crate::service::ask(address, "POST", SLOW, &[], &model("sports-car.glb")).unwrap()
    });
    service.wait_for("overcoat_workers_busy", 1.0);
    // A killed worker's request is tried once more.
    for attempt in 1..=2 {
        std::thread::sleep(Duration::from_millis(200));
        let workers = service.workers();
        assert_eq!(workers.len(), 1);
        crate::service::send_signal("KILL", workers[0]);
        service.wait_for("overcoat_workers_died_total", f64::from(attempt));
    }
    let (kind, message) = slow.join().unwrap().error(500);
    assert_eq!(kind, "worker");
    assert!(message.contains("killed"), "{message}");
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
    assert_eq!(service.metric("overcoat_workers_died_total"), 2.0);
    assert_eq!(service.metric("overcoat_workers_started_total"), 3.0);
    assert_eq!(service.metric("overcoat_failures_remembered_total"), 0.0);
}

/// On a machine that has other work, a model takes longer and is drawn all the same: processor time counts.
#[test]
#[cfg(target_os = "linux")]
fn waiting_is_not_work() {
    let service = start(&["--deadline", "3", "--workers", "1"]);
    let address = service.address;
    let asked = std::thread::spawn(move || {
        crate::service::ask(address, "POST", "/render?size=64", &[], &model("torus-knot.glb")).unwrap()
    });
    // The worker is stopped for longer than the work may take.
    let workers = service.workers();
    workers.iter().for_each(|id| crate::service::send_signal("STOP", *id));
    std::thread::sleep(Duration::from_secs(4));
    workers.iter().for_each(|id| crate::service::send_signal("CONT", *id));
    asked.join().unwrap().png(64, 64);
    // The wall has a limit of its own.
    let service = start(&["--deadline", "100", "--wall-deadline", "4"]);
    service.workers().into_iter().for_each(|id| crate::service::send_signal("STOP", id));
    let answer = service.post("/render?size=64", &model("torus-knot.glb"));
    assert_eq!(answer.error(504).0, "timeout");
    assert_eq!(answer.json()["error"]["limit"], "wall_deadline");
}

/// A worker that is killed once is not seen by the client.
#[test]
fn work_of_a_killed_worker_is_done_by_another() {
    let service = start(&["--deadline", "100"]);
    let address = service.address;
    let asked = std::thread::spawn(move || {
        let query = "/render?size=400&quality=good&samples=16";
        crate::service::ask(address, "POST", query, &[], &model("torus-knot.glb")).unwrap()
    });
    service.wait_for("overcoat_workers_busy", 1.0);
    service.workers().into_iter().for_each(|id| crate::service::send_signal("KILL", id));
    asked.join().unwrap().png(400, 400);
    assert_eq!(service.metric("overcoat_workers_died_total"), 1.0);
}

/// Work that has failed costs nothing for a while.
#[test]
fn failures_are_remembered_and_forgotten() {
    let service = start(&["--failure-seconds", "600"]);
    let broken = &model("rounded-cube.glb")[..300];
    let first = service.post("/render?size=16", broken);
    let (kind, message) = first.error(422);
    assert!(!first.headers.contains_key("retry-after"), "{kind}");
    let again = service.post("/render?size=16", broken);
    assert_eq!(again.error(422), (kind.clone(), message));
    assert!(again.headers["retry-after"].parse::<u64>().unwrap() > 500);
    assert_eq!(service.metric("overcoat_failures_remembered_total"), 1.0);
    // Another picture of it, and another model, are other work.
    assert_eq!(service.post("/render?size=17", broken).error(422).0, kind);
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
    assert_eq!(service.metric("overcoat_failures_remembered_total"), 1.0);
    service.signal("HUP");
    std::thread::sleep(Duration::from_millis(300));
    assert!(!service.post("/render?size=16", broken).headers.contains_key("retry-after"));
}

/// Failures of questions about a model cost no second worker.
#[test]
fn failures_of_descriptions_are_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let broken = &model("rounded-cube.glb")[..300];
    std::fs::write(folder.path().join("broken.glb"), broken).unwrap();
    let local = folder.path().to_str().unwrap();
    let service = start(&["--failure-seconds", "600", "--allow-unsigned", "--local", local]);
    let remembered = || service.metric("overcoat_failures_remembered_total");
    let first = service.post("/info", broken);
    let told = first.error(422);
    assert_eq!((told.0.as_str(), first.headers.contains_key("retry-after")), ("model", false));
    let again = service.post("/info", broken);
    assert_eq!(again.error(422), told);
    assert!(again.headers["retry-after"].parse::<u64>().unwrap() > 500);
    assert_eq!(remembered(), 1.0);
    // Pictures of it, another name of its format, and another model are other work.
    assert!(!service.post("/render?size=16", broken).headers.contains_key("retry-after"));
    assert!(!service.post("/info?name=a.obj", broken).headers.contains_key("retry-after"));
    assert_eq!(service.post("/info", &model("rounded-cube.glb")).status, 200);
    assert_eq!(remembered(), 1.0);
    // Sources of paths are remembered too.
    for retry in [false, true] {
        let answer = service.get("/info/_/plain/local://broken.glb");
        assert_eq!(answer.error(422).0, "model");
        assert_eq!(answer.headers.contains_key("retry-after"), retry);
    }
    assert_eq!(remembered(), 2.0);
    service.signal("HUP");
    std::thread::sleep(Duration::from_millis(300));
    assert!(!service.post("/info", broken).headers.contains_key("retry-after"));
}

#[test]
fn sources_that_fail_are_told() {
    let port = source_server(|path, _| match path {
        "/broken.glb" => b"HTTP/1.1 500 Broken\r\nContent-Length: 0\r\n\r\n".to_vec(),
        "/short.glb" => b"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nglTF".to_vec(),
        "/large.glb" => ok(&vec![0; 200_000]),
        "/endless.glb" => [&b"HTTP/1.1 200 OK\r\n\r\n"[..], &vec![0; 200_000]].concat(),
        "/silent.glb" => {
            std::thread::sleep(Duration::from_secs(3));
            Vec::new()
        }
        _ => b"HTTP/1.1 404 None\r\nContent-Length: 0\r\n\r\n".to_vec(),
    });
    let base = format!("http://127.0.0.1:{port}");
    let service = start(&[
        "--allow-unsigned",
        "--allow-source",
        &base,
        "--allow-network",
        "127.0.0.0/8",
        "--source-seconds",
        "1",
        "--max-body",
        "100k",
    ]);
    for (name, status, kind) in [
        ("none.glb", 404, "not_found"),
        ("broken.glb", 502, "source_failed"),
        ("short.glb", 502, "source_failed"),
        ("large.glb", 413, "too_large"),
        ("endless.glb", 413, "too_large"),
        ("silent.glb", 504, "source_timeout"),
    ] {
        assert_eq!(service.get(&format!("/_/plain/{base}/{name}@png")).error(status).0, kind, "{name}");
    }
}

#[test]
fn a_full_queue_is_told() {
    let service = start(&["--queue", "1", "--deadline", "100"]);
    let address = service.address;
    let ask = move |query: &'static str| {
        std::thread::spawn(move || {
            crate::service::ask(address, "POST", &format!("{SLOW}&{query}"), &[], &model("sports-car.glb"))
        })
    };
    let _first = ask("view=front");
    service.wait_for("overcoat_workers_busy", 1.0);
    let _second = ask("view=back");
    service.wait_for("overcoat_queue_length", 1.0);
    let answer = service.post("/render?size=16", &model("rounded-cube.glb"));
    assert_eq!(answer.error(429).0, "queue_full");
    assert!(answer.headers["retry-after"].parse::<u64>().unwrap() >= 1);
    assert_eq!(answer.json()["error"]["limit"], "queue");
    assert_eq!(service.post("/info", &model("rounded-cube.glb")).error(429).0, "queue_full");
    // Those who need no worker are served.
    assert_eq!(service.get("/health").status, 200);
}

#[test]
fn who_waits_too_long_is_told() {
    let service = start(&["--queue-seconds", "0.3", "--deadline", "100"]);
    let address = service.address;
    std::thread::spawn(move || crate::service::ask(address, "POST", SLOW, &[], &model("sports-car.glb")));
    service.wait_for("overcoat_workers_busy", 1.0);
    let answer = service.post("/render?size=16", &model("rounded-cube.glb"));
    assert_eq!(answer.error(503).0, "busy");
    assert!(answer.headers.contains_key("retry-after"));
}

#[test]
fn bodies_have_so_much_memory_together() {
    let service = start(&["--body-memory", "100Ki", "--max-body", "1Mi"]);
    let answer = service.post("/render", &vec![b'{'; 500_000]);
    assert_eq!(answer.error(503).0, "busy");
    assert_eq!(answer.json()["error"]["limit"], "body_memory");
    service.post("/render?size=16", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n").png(16, 16);
}

#[test]
fn who_waits_at_the_end_is_told() {
    let mut service = start(&["--stop-seconds", "0.5", "--deadline", "100"]);
    let address = service.address;
    let _slow =
        std::thread::spawn(move || crate::service::ask(address, "POST", SLOW, &[], &model("sports-car.glb")));
    service.wait_for("overcoat_workers_busy", 1.0);
    let waiting = std::thread::spawn(move || {
        crate::service::ask(address, "POST", "/render?size=16", &[], &model("rounded-cube.glb")).unwrap()
    });
    service.wait_for("overcoat_queue_length", 1.0);
    service.signal("TERM");
    assert_eq!(waiting.join().unwrap().error(503).0, "stopping");
    service.ended();
}

#[test]
fn workers_that_cannot_be_started_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("service");
    std::fs::copy(crate::service::PROGRAM, &program).unwrap();
    let service = start_with(Path::new(&program), &["--deadline", "100"], &[]);
    std::fs::remove_file(&program).unwrap();
    service.workers().into_iter().for_each(|id| crate::service::send_signal("KILL", id));
    std::thread::sleep(Duration::from_millis(200));
    let answer = service.post("/render?size=16", &model("rounded-cube.glb"));
    assert_eq!(answer.error(503).0, "no_worker");
    // Nor does one start where no worker can.
    let output = run(&["serve", "--listen", "127.0.0.1:0", "--memory", "1"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("a worker cannot draw"));
}

#[test]
fn work_has_so_much_time() {
    // On a busy machine a second of the processor is many of the wall.
    let service = start(&["--deadline", "1", "--wall-deadline", "600"]);
    let answer = service.post(SLOW, &model("sports-car.glb"));
    assert_eq!(answer.error(504).0, "timeout");
    assert_eq!(answer.json()["error"]["limit"], "deadline");
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
    assert_eq!(service.metric("overcoat_workers_timed_out_total"), 1.0);
}
