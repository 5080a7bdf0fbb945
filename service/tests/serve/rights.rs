//! Rights of clients: keys, quotas, paths that expire, pages of other origins, sockets of the machine.

use crate::service::{
    Answer, PROGRAM, Service, model, model_path, read_answer, run, send_signal, start, start_with,
};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

const KEYS: &str = "[holder.shop]
keys = ['shop-key-0123456789', 'shop-old-0123456789']
units = 30
seconds = 3600
max_price = 25
[holder.gone]
keys = ['gone-key-0123456789']
expires = 2020-01-01T00:00:00Z
";

fn cube() -> Vec<u8> {
    model("rounded-cube.glb")
}

fn post(service: &Service, path: &str, key: Option<&str>) -> Answer {
    let header = key.map(|key| format!("Bearer {key}"));
    let headers: Vec<(&str, &str)> = header.iter().map(|value| ("Authorization", value.as_str())).collect();
    service.request("POST", path, &headers, &cube())
}

/// A path with its signature by the keys that the services here have.
fn signed(path: &str) -> String {
    let output = run(&["serve", "--key", "aabb", "--salt", "ccdd", "--sign", path]);
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs()
}

/// Waits until something is so.
fn wait_until(is_so: impl Fn() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !is_so() {
        assert!(Instant::now() < end, "it is never so");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn uploads_need_a_key_and_paths_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, KEYS).unwrap();
    let local = model_path("");
    let args =
        ["--bearer-keys", file.to_str().unwrap(), "--allow-unsigned", "--local", local.to_str().unwrap()];
    let variables = [("OVERCOAT_BEARER", "free=free-key-0123456789")];
    let service = start_with(Path::new(PROGRAM), &args, &variables);
    for (key, kind) in
        [(None, "no_key"), (Some("nonsense"), "key"), (Some("gone-key-0123456789"), "key_expired")]
    {
        for path in ["/render?size=16", "/info", "/pipeline?operations=[]"] {
            let answer = post(&service, path, key);
            assert_eq!(answer.error(401).0, kind, "{path}");
            assert!(answer.headers["www-authenticate"].starts_with("Bearer realm="), "{path}");
        }
        assert_eq!(service.metric(&format!("overcoat_refusals_total{{kind=\"{kind}\"}}")), 3.0);
    }
    for key in ["shop-key-0123456789", "shop-old-0123456789", "free-key-0123456789"] {
        let answer = post(&service, "/render?size=16&quality=draft", Some(key));
        answer.png(16, 16);
        assert_eq!(answer.headers.contains_key("overcoat-units-left"), key.starts_with("shop"), "{key}");
    }
    let path = "/_/size:16/plain/local://rounded-cube.glb@png";
    assert_eq!(service.get(path).headers["cache-control"], "public, max-age=3600");
    // A wrong key is told in any case.
    let answer = service.request("GET", path, &[("Authorization", "Bearer nonsense")], &[]);
    assert_eq!(answer.error(401).0, "key");
    for path in ["/", "/formats", "/health", "/ready", "/metrics"] {
        assert_eq!(service.get(path).status, 200, "{path}");
    }
    // Keys are in no line, the names of their holders are.
    service.request(
        "POST",
        "/render?size=17",
        &[("X-Request-Id", "named"), ("Authorization", "Bearer free-key-0123456789")],
        &cube(),
    );
    assert_eq!(service.line("named")["holder"], "free");
    assert!(!service.log().contains("key-0123456789"), "{}", service.log());

    let all = start(&[&args[..], &["--bearer-for", "all"]].concat());
    assert_eq!(all.get(path).error(401).0, "no_key");
    let answer = all.request("GET", path, &[("Authorization", "Bearer shop-key-0123456789")], &[]);
    assert_eq!(answer.headers["cache-control"], "private, max-age=3600");
    assert_eq!(all.get("/health").status, 200);
}

/// The listing of the manual is a file of keys.
#[test]
fn the_listing_of_the_manual_is_taken() {
    let manual = include_str!("../../../docs/src/service.md");
    let listing = manual.split("```toml\n").find(|part| part.starts_with("[holder.shop]")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, listing.split("```").next().unwrap()).unwrap();
    let service = start(&["--bearer-keys", file.to_str().unwrap()]);
    let answer = post(&service, "/render?size=16&quality=draft", Some("the-old-key-of-the-shop"));
    assert_eq!(answer.headers["overcoat-units-left"], "19995");
}

#[test]
fn keys_have_limits_and_quotas() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, KEYS).unwrap();
    let cache = folder.path().join("cache");
    let service = start(&[
        "--bearer-keys",
        file.to_str().unwrap(),
        "--cache",
        cache.to_str().unwrap(),
        "--log",
        "error",
    ]);
    let key = Some("shop-key-0123456789");
    let dear = post(&service, "/render?size=512&quality=good", key);
    assert_eq!((dear.error(422).0.as_str(), dear.headers["overcoat-price"].as_str()), ("price", "85"));
    let left = |answer: &Answer| answer.headers.get("overcoat-units-left").cloned();
    let first = post(&service, "/render?size=512", key);
    assert_eq!((first.status, left(&first).as_deref()), (200, Some("9")));
    // Pictures of the cache cost nothing, by the other key of the same holder either.
    let again = post(&service, "/render?size=512", Some("shop-old-0123456789"));
    assert_eq!((again.status, left(&again)), (200, None));
    let spent = post(&service, "/render?size=256&samples=16", Some("shop-old-0123456789"));
    let (kind, message) = spent.error(429);
    assert_eq!(kind, "quota");
    assert!(message.contains("costs 10 units, and the key has 9 left of 30 in 3600 s"), "{message}");
    let wait: u64 = spent.headers["retry-after"].parse().unwrap();
    assert!((3000..=3600).contains(&wait), "{wait}");
    let last = post(&service, "/info", key);
    assert_eq!((last.status, left(&last).as_deref()), (200, Some("4")));
    assert_eq!(service.metric("overcoat_refusals_total{kind=\"quota\"}"), 1.0);
    assert_eq!(service.metric("overcoat_units_total"), 26.0);
}

/// Pictures of one request that no worker has begun cost nothing: the request failed before them, or they were in the cache.
#[test]
fn pictures_that_are_not_drawn_cost_no_units() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, KEYS.replace("units = 30", "units = 100")).unwrap();
    let cache = folder.path().join("cache");
    let models = folder.path().join("models");
    std::fs::create_dir(&models).unwrap();
    let faces = "mtllib red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for name in ["a.obj", "b.obj", "c.obj"] {
        std::fs::write(models.join(name), faces).unwrap();
    }
    std::fs::write(models.join("red.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    let mut args = vec!["--bearer-keys", file.to_str().unwrap(), "--cache", cache.to_str().unwrap()];
    args.extend(["--bearer-for", "all", "--allow-unsigned", "--local", models.to_str().unwrap()]);
    let service = start(&args);
    let ask = |method: &str, path: &str, model: &[u8], status: u16| {
        let shop = [("Authorization", "Bearer shop-key-0123456789")];
        let answer = service.request(method, path, &shop, model);
        assert_eq!(answer.status, status, "{path}: {}", String::from_utf8_lossy(&answer.body));
        answer.headers["overcoat-units-left"].parse::<u64>().unwrap()
    };
    // Five units each.
    assert_eq!(ask("POST", "/render?sizes=16,20,24&quality=draft", &cube()[..500], 422), 95);
    let left = |path: &str| ask("GET", path, &[], 200);
    assert_eq!(left("/_/quality:draft/size:16/plain/local://a.obj@png"), 90);
    // That it is the same picture is known when the model is read: one of another name might look for other files.
    assert_eq!(left("/_/quality:draft/sizes:16,20/plain/local://b.obj@png"), 85);
    // A model that is read for nothing costs what a description does, and not six units.
    assert_eq!(left("/_/quality:draft/size:64/plain/local://a.obj@png"), 79);
    assert_eq!(left("/_/quality:draft/size:64/plain/local://c.obj@png"), 74);
}

/// Pictures of a request that nobody waits for any more are not drawn, and cost nothing.
#[test]
fn who_goes_away_pays_for_what_others_wait_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, KEYS).unwrap();
    let args = ["--bearer-keys", file.to_str().unwrap(), "--spare-workers", "0", "--wall-deadline", "600"];
    let service = start_with(Path::new(PROGRAM), &args, &[("OVERCOAT_BEARER", "free=free-key-0123456789")]);
    let send = |query: &str, key: &str, id: &str| {
        let mut stream = service.connect();
        let length = cube().len();
        let head = format!(
            "POST /render?{query}&quality=draft HTTP/1.1\r\nHost: x\r\nX-Request-Id: {id}\r\n\
             Authorization: Bearer {key}\r\nContent-Length: {length}\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(&cube()).unwrap();
        stream
    };
    // The only worker stands still with the first request.
    let workers = service.workers();
    workers.iter().for_each(|worker| send_signal("STOP", *worker));
    let mut first = send("size=16", "free-key-0123456789", "first");
    service.wait_for("overcoat_workers_busy", 1.0);
    let gone = send("sizes=17,18,19", "shop-key-0123456789", "gone");
    service.wait_for("overcoat_queue_length", 1.0);
    // One of its pictures is the other's, too.
    let mut other = send("sizes=18,20", "free-key-0123456789", "other");
    service.wait_for("overcoat_queue_length", 2.0);
    drop(gone);
    // Connections of the others, and the one that asks.
    wait_until(|| service.metric("overcoat_connections") == 3.0);
    workers.iter().for_each(|worker| send_signal("CONT", *worker));
    for stream in [&mut first, &mut other] {
        let answer = read_answer(stream, "POST").unwrap();
        assert_eq!(answer.status, 200, "{}", String::from_utf8_lossy(&answer.body));
    }
    assert_eq!(service.line("gone")["result"], "gone");
    assert_eq!(service.metric("overcoat_units_total"), 15.0);
    let answer = post(&service, "/render?size=16&quality=draft&view=top", Some("shop-key-0123456789"));
    assert_eq!((answer.status, answer.headers["overcoat-units-left"].as_str()), (200, "20"));
}

#[test]
fn keys_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    std::fs::write(&file, KEYS).unwrap();
    let service = start(&["--bearer-keys", file.to_str().unwrap()]);
    let draws = |key: &str| post(&service, "/render?size=16&quality=draft", Some(key)).status == 200;
    assert!(draws("shop-key-0123456789") && !draws("shop-new-0123456789"));
    std::fs::write(&file, KEYS.replace("shop-old", "shop-new")).unwrap();
    service.signal("HUP");
    wait_until(|| draws("shop-new-0123456789"));
    assert!(!draws("shop-old-0123456789"));
    // Units that were spent stay spent.
    let left: u64 = post(&service, "/render?size=16&quality=draft", Some("shop-key-0123456789")).headers
        ["overcoat-units-left"]
        .parse()
        .unwrap();
    assert_eq!(left, 15);
    // A file that is wrong changes nothing.
    std::fs::write(&file, "[holder.shop]\nkeys = ['shop-bad-0123456789'").unwrap();
    service.signal("HUP");
    service.wait_for("overcoat_keys_failures_total", 1.0);
    assert!(draws("shop-key-0123456789") && !draws("shop-bad-0123456789"));
    assert!(!service.log().contains("shop-bad"), "{}", service.log());
}

#[test]
fn wrong_keys_end_the_service() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("keys.toml");
    for (text, what) in [
        ("", "keys.toml: there is no holder of a key"),
        ("[holder.a]\nkeys = ['too-short']", "keys.toml: holder.a: key 1: expected 16 to 256"),
        ("[holder.a]\nkeys = ['0123456789-secret']\nunit = 3", "keys.toml: line 3: unknown field `unit`"),
    ] {
        std::fs::write(&file, text).unwrap();
        let output = run(&["serve", "--listen", "0", "--bearer-keys", file.to_str().unwrap()]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(what) && !message.contains("secret"), "{text}: {message}");
    }
    let output = run(&["serve", "--listen", "0", "--cors-origin", "example.com"]);
    assert!(String::from_utf8(output.stderr).unwrap().contains("expected an origin"));
}

#[test]
fn paths_expire() {
    let local = model_path("");
    let service = start(&[
        "--key",
        "aabb",
        "--salt",
        "ccdd",
        "--local",
        local.to_str().unwrap(),
        "--failure-seconds",
        "0",
    ]);
    assert!(service.log().contains("--key on the command line is visible"), "{}", service.log());
    let path = |end: u64| signed(&format!("/exp:{end}/size:16/plain/local://rounded-cube.glb@png"));
    let end = now() + 1000;
    let good = service.get(&path(end));
    good.png(16, 16);
    let age: u64 = good.headers["cache-control"].strip_prefix("public, max-age=").unwrap().parse().unwrap();
    assert!((900..=1000).contains(&age), "{age}");
    let over = path(now() - 1);
    for path in [over.clone(), path(0), format!("/info{}", signed("/exp:1/plain/local://rounded-cube.glb"))] {
        assert_eq!(service.get(&path).error(410).0, "expired", "{path}");
    }
    assert_eq!(service.metric("overcoat_refusals_total{kind=\"expired\"}"), 3.0);
    // The end is part of what is signed.
    let forged = over.replace(&format!("exp:{}", now() - 1), &format!("exp:{end}"));
    let forged = if forged == over { path(1).replace("exp:1", &format!("exp:{end}")) } else { forged };
    assert_eq!(service.get(&forged).error(403).0, "signature");
    assert_eq!(service.get(&signed("/exp:soon/size:16/plain/local://a.glb")).error(400).0, "options");
    // In a query it is nothing.
    assert_eq!(service.post("/render?exp=1", &cube()).error(400).0, "options");
}

#[test]
fn pages_of_named_origins_may_ask() {
    let service = start(&["--cors-origin", "https://shop.example,https://b.example"]);
    let ask = |method: &str, origin: &str| {
        let headers = [("Origin", origin), ("Access-Control-Request-Method", "POST")];
        service.request(method, "/render?size=16", &headers, if method == "POST" { b"nothing" } else { b"" })
    };
    let good = ask("OPTIONS", "https://b.example");
    assert_eq!(good.status, 204);
    assert_eq!(good.headers["access-control-allow-origin"], "https://b.example");
    assert!(good.headers["access-control-allow-headers"].contains("Authorization"));
    let bad = ask("OPTIONS", "https://evil.example");
    assert_eq!(bad.error(403).0, "origin");
    assert!(!bad.headers.contains_key("access-control-allow-origin"));
    // Failures are told to those who may ask, and to no others.
    assert_eq!(
        ask("POST", "https://shop.example").headers["access-control-allow-origin"],
        "https://shop.example"
    );
    let other = ask("POST", "https://evil.example");
    assert!(other.status == 415 && !other.headers.contains_key("access-control-allow-origin"));
    assert_eq!(other.headers["vary"], "Origin");
    // Without the option nothing of that is there.
    let service = start(&[]);
    let headers = [("Origin", "https://a.example"), ("Access-Control-Request-Method", "POST")];
    assert_eq!(service.request("OPTIONS", "/render", &headers, &[]).error(405).0, "method");
}

#[test]
#[cfg(unix)]
fn sockets_of_the_machine_are_listened_on() {
    use std::io::{Read, Write};
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::net::UnixStream;
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("o.sock");
    let listen = format!("unix:{}", socket.display());
    let begin = || {
        let mut command = std::process::Command::new(PROGRAM);
        command.args(["serve", "--listen", &listen, "--workers", "1", "--log", "off"]);
        command.stdout(std::process::Stdio::null()).spawn().unwrap()
    };
    let mut child = begin();
    wait_until(|| UnixStream::connect(&socket).is_ok());
    assert_eq!(std::fs::metadata(&socket).unwrap().permissions().mode() & 0o777, 0o660);
    let render = || {
        let mut stream = UnixStream::connect(&socket).unwrap();
        let body = cube();
        let head = format!(
            "POST /render?size=16 HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: {}\r\n\r\n",
            body.len()
        );
        stream.write_all(&[head.as_bytes(), &body].concat()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        assert!(answer.starts_with(b"HTTP/1.1 200 OK\r\n"), "{}", String::from_utf8_lossy(&answer));
    };
    render();
    // Another one does not take its place.
    let other = run(&["serve", "--listen", &listen, "--workers", "1", "--log", "off"]);
    assert_eq!(other.status.code(), Some(1));
    // A file that a killed one has left is replaced, and one that ends leaves none.
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(socket.exists());
    let mut child = begin();
    wait_until(|| UnixStream::connect(&socket).is_ok());
    render();
    send_signal("TERM", child.id());
    assert!(child.wait().unwrap().success());
    assert!(!socket.exists());
}

/// Clients behind a proxy that is trusted are told apart.
#[test]
fn proxies_tell_their_clients() {
    let line = |args: &[&str]| {
        let service = start(args);
        let headers = [("X-Request-Id", "told"), ("X-Forwarded-For", "6.6.6.6, 1.2.3.4")];
        service.request("POST", "/render?size=16", &headers, &cube());
        service.line("told")["client"].as_str().unwrap().to_owned()
    };
    assert_eq!(line(&[]), "127.0.0.1");
    assert_eq!(line(&["--trusted-proxies", "127.0.0.0/8"]), "1.2.3.4");
    assert_eq!(line(&["--trusted-proxies", "10.0.0.0/8"]), "127.0.0.1");
}
