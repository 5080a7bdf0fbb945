//! Jobs: answered at once, done later, sent to a callback, signed, and not lost.

use crate::service::{Service, model, run, start, unzip};
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use hmac::{Hmac, KeyInit, Mac};
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// A result as it came.
struct Sent {
    headers: HashMap<String, String>,
    body: Vec<u8>,
}

/// A place that results are sent to, which answers with these statuses and then with 204.
fn receiver(statuses: &'static [u16]) -> (u16, Receiver<Sent>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (send, received) = channel();
    std::thread::spawn(move || {
        let mut statuses = statuses.iter();
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut lines = BufReader::new(stream.try_clone().unwrap());
            let (mut headers, mut line) = (HashMap::new(), String::new());
            while lines.read_line(&mut line).unwrap_or(0) > 2 {
                if let Some((name, value)) = line.trim_end().split_once(": ") {
                    headers.insert(name.to_ascii_lowercase(), value.to_owned());
                }
                line.clear();
            }
            let mut body = vec![0; headers["content-length"].parse().unwrap()];
            lines.read_exact(&mut body).unwrap();
            let _ = send.send(Sent { headers, body });
            let status = statuses.next().unwrap_or(&204);
            let _ = write!(stream, "HTTP/1.1 {status} x\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        }
    });
    (port, received)
}

impl Sent {
    fn is_signed(&self) -> bool {
        let of = |name: &str| self.headers[name].as_str();
        // Key and salt of `taking`.
        let mut mac = Hmac::<sha2::Sha256>::new_from_slice(&[0xaa]).unwrap();
        mac.update(&[0xbb]);
        mac.update(
            format!("{}.{}.{}.", of("overcoat-job"), of("overcoat-time"), of("overcoat-status")).as_bytes(),
        );
        mac.update(&self.body);
        URL_SAFE_NO_PAD.encode(mac.finalize().into_bytes()) == of("overcoat-signature")
    }
}

fn taking(spool: &Path, more: &[&str]) -> Service {
    let fixed =
        ["--spool", spool.to_str().unwrap(), "--key", "aa", "--salt", "bb", "--callback-seconds", "0.05"];
    start(&[&fixed[..], &["--allow-callback", "http://127.0.0.1"], more].concat())
}

/// Any port of this machine: allowed callbacks name theirs.
fn allow(port: u16) -> [String; 4] {
    [
        "--allow-callback".to_owned(),
        format!("http://127.0.0.1:{port}/hook"),
        "--allow-network".to_owned(),
        "127.0.0.1".to_owned(),
    ]
}

fn path(port: u16, options: &str) -> String {
    format!("/jobs?callback=http%3A%2F%2F127.0.0.1%3A{port}%2Fhook%3Fa%3D1&{options}")
}

fn next(received: &Receiver<Sent>) -> Sent {
    received.recv_timeout(Duration::from_secs(100)).unwrap()
}

#[test]
fn results_are_drawn_later_signed_and_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let (port, received) = receiver(&[500, 302]);
    let allowed = allow(port);
    let service = taking(folder.path(), &allowed.each_ref().map(String::as_str));
    let cube = model("rounded-cube.glb");
    let taken = service.post(&path(port, "size=32&name=a.glb"), &cube);
    assert_eq!(taken.status, 202, "{}", String::from_utf8_lossy(&taken.body));
    let id = taken.json()["id"].as_str().unwrap().to_owned();
    let alone = service.post("/render?size=32", &cube);
    // A server error and a redirect are no success.
    for _ in 0..3 {
        let sent = next(&received);
        assert!(sent.is_signed());
        assert_eq!(
            (sent.headers["overcoat-job"].as_str(), sent.headers["overcoat-status"].as_str()),
            (id.as_str(), "200")
        );
        assert_eq!(sent.headers["content-type"], "image/png");
        assert!(sent.body == alone.body);
    }
    service.wait_for("overcoat_jobs_total{event=\"delivered\"}", 1.0);
    assert_eq!(service.metric("overcoat_jobs_total{event=\"retried\"}"), 2.0);
    assert_eq!(service.line(&id)["route"], "render");
    // It is gone with its files.
    while service.get(&format!("/jobs/{id}")).status != 404 {}
    assert!(!folder.path().join(&id).exists());
    // Several pictures, and errors, are results like others.
    service.post(&path(port, "sizes=16,20"), &cube);
    assert_eq!(unzip(&next(&received).body).len(), 3);
    service.post(&path(port, "size=32"), b"glTF is no model");
    let failed = next(&received);
    assert!(failed.is_signed() && failed.headers["overcoat-status"] == "422");
    assert!(String::from_utf8_lossy(&failed.body).contains("\"kind\""));
}

#[test]
fn jobs_survive_a_killed_service() {
    let folder = tempfile::tempdir().unwrap();
    let (port, received) = receiver(&[]);
    let allowed = allow(port);
    let allowed = allowed.each_ref().map(String::as_str);
    let cube = model("rounded-cube.glb");
    let mut service = taking(folder.path(), &[&allowed[..], &["--deadline", "1000"]].concat());
    // The first takes the only worker for long enough.
    let slow = path(port, "size=2048&quality=best&samples=16&rays=64");
    let ids = [slow.as_str(), &path(port, "size=24"), &path(port, "size=25")].map(|path| {
        let taken = service.post(path, &cube);
        assert_eq!(taken.status, 202);
        taken.json()["id"].as_str().unwrap().to_owned()
    });
    assert_eq!(service.metric("overcoat_jobs_spooled"), 3.0);
    assert_eq!(service.get(&format!("/jobs/{}", ids[1])).json()["state"], "waiting");
    service.signal("KILL");
    service.ended();
    assert!(received.try_recv().is_err());
    // Jobs that were accepted are done by the next one; the dear one need not be.
    std::fs::remove_dir_all(folder.path().join(&ids[0])).unwrap();
    let service = taking(folder.path(), &allowed);
    let mut done = [next(&received), next(&received)].map(|sent| {
        assert!(sent.is_signed());
        sent.headers["overcoat-job"].clone()
    });
    done.sort();
    assert_eq!(done, ids[1..]);
    service.wait_for("overcoat_jobs_total{event=\"delivered\"}", 2.0);
}

#[test]
fn callbacks_are_where_the_operator_allows() {
    let folder = tempfile::tempdir().unwrap();
    let service = taking(
        folder.path(),
        &[
            "--allow-callback",
            "http://127.0.0.1:9/,http://localhost,https://a.example/x/,http://[::1]",
            "--spool-jobs",
            "1",
        ],
    );
    let cube = model("rounded-cube.glb");
    for (callback, status, kind, what) in [
        ("http%3A%2F%2F127.0.0.1%3A9%2Fx", 403, "callback", "private network"),
        ("http%3A%2F%2Flocalhost%2Fx", 403, "callback", "private network"),
        ("http%3A%2F%2F%5B%3A%3A1%5D%2Fx", 403, "callback", "private network"),
        ("http%3A%2F%2F169.254.169.254%2Flatest", 403, "callback", "not allowed here"),
        ("https%3A%2F%2Fme%3Asecret%40a.example%2Fx%2F", 403, "callback", "not allowed here"),
        ("file%3A%2F%2F%2Fetc%2Fpasswd", 403, "callback", "not allowed here"),
        ("nonsense", 400, "options", "expected a URL"),
    ] {
        let answer = service.post(&format!("/jobs?size=32&callback={callback}"), &cube);
        let (told, message) = answer.error(status);
        assert!(told == kind && message.contains(what), "{callback}: {message}");
    }
    assert!(service.post("/jobs?size=32", &cube).error(400).1.contains("a URL is needed"));
    assert!(service.post("/jobs?size=0&callback=x", &cube).error(400).1.contains("1 to"));
    assert_eq!(service.metric("overcoat_jobs_total{event=\"accepted\"}"), 0.0);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(service.get("/jobs/..%2f..%2fetc").status, 404);
    // Without a spool there are no jobs.
    assert_eq!(start(&[]).post("/jobs?callback=http%3A%2F%2Fx", &cube).error(404).0, "not_found");
}

#[test]
fn spools_are_bounded_and_callbacks_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let (port, received) = receiver(&[500, 500, 500, 500]);
    let allowed = allow(port);
    let allowed = allowed.each_ref().map(String::as_str);
    let service =
        taking(folder.path(), &[&allowed[..], &["--spool-jobs", "1", "--callback-attempts", "2"]].concat());
    let cube = model("rounded-cube.glb");
    assert_eq!(service.post(&path(port, "size=600&quality=good"), &cube).status, 202);
    let full = service.post(&path(port, "size=17"), &cube);
    assert_eq!((full.error(429).0.as_str(), full.headers["retry-after"].as_str()), ("queue_full", "10"));
    service.wait_for("overcoat_jobs_total{event=\"given_up\"}", 1.0);
    assert_eq!(received.try_iter().count(), 2);
    assert!(service.log().contains("a job is given up") && service.log().contains("answers 500"));
    // A disk that cannot be written is told, and nothing else suffers.
    std::fs::remove_dir_all(folder.path()).unwrap();
    assert_eq!(service.post(&path(port, "size=17"), &cube).error(507).0, "spool");
    service.post("/render?size=17", &cube).png(17, 17);
    let taken = folder.path().join("taken");
    let _first = taking(&taken, &[]);
    for (args, what) in [
        (
            &[
                "--spool",
                taken.to_str().unwrap(),
                "--key",
                "aa",
                "--salt",
                "bb",
                "--allow-callback",
                "https://a/",
            ][..],
            "another service",
        ),
        (&["--spool", "x"], "--key and --salt"),
        (&["--spool", "x", "--key", "aa", "--salt", "bb"], "--allow-callback"),
        (&["--allow-callback", "x"], "--allow-callback x: expected a URL"),
        (&["--callback-attempts", "0"], "--callback-attempts"),
    ] {
        let output = run(&[&["serve", "--listen", "127.0.0.1:0"], args].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
        assert!(error.contains(what), "{args:?}: {error}");
    }
}
