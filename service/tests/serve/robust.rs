//! Faults that must not happen under load, at the end, and to the cache.

use crate::service::{Answer, ask, model, model_path, start};
use std::io::{Read, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Duration;

fn in_background(address: SocketAddr, path: String, body: Vec<u8>) -> JoinHandle<std::io::Result<Answer>> {
    std::thread::spawn(move || ask(address, "POST", &path, &[], &body))
}

#[test]
fn equal_requests_are_drawn_once() {
    let service = start(&["--deadline", "100"]);
    let car = model("sports-car.glb");
    let path = "/render?size=700&quality=good&view=front";
    let all: Vec<_> = (0..6).map(|_| in_background(service.address, path.to_owned(), car.clone())).collect();
    let bodies: Vec<Vec<u8>> =
        all.into_iter().map(|one| one.join().unwrap().unwrap().png(700, 700).to_vec()).collect();
    assert!(bodies.windows(2).all(|two| two[0] == two[1]));
    assert_eq!(service.metric("overcoat_render_seconds_count{stage=\"load\"}"), 1.0);
    assert_eq!(service.log().matches("\"result\":\"shared\"").count(), 5);
}

#[test]
fn who_goes_away_takes_nothing_from_others() {
    let service = start(&["--deadline", "100"]);
    let car = model("sports-car.glb");
    let path = "/render?size=700&quality=good&view=back";
    let mut stream = service.connect();
    let head = format!("POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: {}\r\n\r\n", car.len());
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(&car).unwrap();
    service.wait_for("overcoat_workers_busy", 1.0);
    let other = in_background(service.address, path.to_owned(), car.clone());
    std::thread::sleep(Duration::from_millis(50));
    drop(stream);
    other.join().unwrap().unwrap().png(700, 700);
    // One that goes away before its turn is not drawn at all.
    let slow = in_background(service.address, "/render?size=900&quality=best".to_owned(), car.clone());
    service.wait_for("overcoat_workers_busy", 1.0);
    let mut stream = service.connect();
    let head = format!("POST /render?size=30 HTTP/1.1\r\nHost: x\r\nContent-Length: {}\r\n\r\n", car.len());
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(&car).unwrap();
    service.wait_for("overcoat_queue_length", 1.0);
    drop(stream);
    slow.join().unwrap().unwrap().png(900, 900);
    service.post("/render?size=31", &car).png(31, 31);
    assert_eq!(service.metric("overcoat_render_seconds_count{stage=\"load\"}"), 3.0);
    assert_eq!(service.metric("overcoat_workers_died_total"), 0.0);
}

#[test]
fn the_end_loses_no_request() {
    // Patience for a slow machine.
    let mut service =
        start(&["--workers", "2", "--queue", "64", "--queue-seconds", "1000", "--stop-seconds", "1000"]);
    let cube = model("rounded-cube.glb");
    let all: Vec<_> = (0..24)
        .map(|k| {
            in_background(service.address, format!("/render?size={}&quality=good", 200 + k), cube.clone())
        })
        .collect();
    service.wait_for("overcoat_queue_length", 4.0);
    service.signal("TERM");
    let mut drawn = 0;
    for (k, one) in (200..).zip(all) {
        match one.join().unwrap() {
            Ok(answer) => drop(answer.png(k, k)),
            // Only who came too late is not served, and sees that there is nobody.
            Err(error) => {
                assert_eq!(error.kind(), std::io::ErrorKind::ConnectionRefused, "{error}");
                continue;
            }
        }
        drawn += 1;
    }
    assert!(drawn >= 4, "{drawn}");
    let status = service.ended();
    assert!(status.success(), "{status}: {}", service.log());
    assert!(service.log().contains("\"stopped\""));
}

#[test]
fn a_second_signal_ends_at_once() {
    let mut service = start(&["--deadline", "100"]);
    let slow = in_background(
        service.address,
        "/render?size=2048&quality=best&samples=16".to_owned(),
        model("sports-car.glb"),
    );
    service.wait_for("overcoat_workers_busy", 1.0);
    let workers = service.workers();
    service.signal("INT");
    std::thread::sleep(Duration::from_millis(300));
    service.signal("INT");
    assert_eq!(service.ended().code(), Some(1));
    assert!(slow.join().unwrap().is_err());
    gone(&workers);
}

#[test]
fn workers_end_with_their_parent() {
    let mut service = start(&["--workers", "2"]);
    let workers = service.workers();
    assert_eq!(workers.len(), 2);
    service.signal("KILL");
    service.ended();
    gone(&workers);
}

/// Waits until processes have ended.
fn gone(processes: &[u32]) {
    for _ in 0..500 {
        if processes.iter().all(|id| !Path::new(&format!("/proc/{id}")).exists()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("workers are still there");
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.path().is_dir() { all.extend(entries(&entry.path())) } else { all.push(entry.path()) }
    }
    all
}

#[test]
fn the_cache_is_checked_bounded_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().to_str().unwrap();
    let args = ["--cache", cache, "--cache-bytes", "30k"];
    let service = start(&args);
    let cube = model("rounded-cube.glb");
    let first = service.post("/render?size=64", &cube);
    // It is written when the answer is on its way.
    service.wait_for("overcoat_cache_total{event=\"write\"}", 2.0);
    let again = service.post("/render?size=64", &cube);
    assert_eq!(again.png(64, 64), first.body);
    assert_eq!(service.metric("overcoat_cache_total{event=\"hit\"}"), 1.0);
    // Another process finds it, and so does one that was started anew.
    drop(service);
    let service = start(&args);
    assert!(service.post("/render?size=64", &cube).headers["server-timing"].contains("cache"));
    let picture =
        entries(folder.path()).into_iter().find(|path| path.extension().unwrap() == "picture").unwrap();
    let mut bytes = std::fs::read(&picture).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&picture, bytes).unwrap();
    let anew = service.post("/render?size=64", &cube);
    assert!(anew.headers["server-timing"].contains("drawn"));
    assert_eq!(anew.body, first.body);
    assert_eq!(service.metric("overcoat_cache_total{event=\"damaged\"}"), 1.0);
    for size in 65..95 {
        service.post(&format!("/render?size={size}"), &cube).png(size, size);
    }
    // Names and picture of each, and those of the one that was damaged.
    service.wait_for("overcoat_cache_total{event=\"write\"}", 61.0);
    let bytes: u64 = entries(folder.path()).iter().map(|path| path.metadata().unwrap().len()).sum();
    assert!(bytes <= 30_000 && bytes > 10_000, "{bytes}");
    assert_eq!(service.metric("overcoat_cache_bytes"), bytes as f64);
}

#[test]
fn a_cache_that_cannot_be_written_is_done_without() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("no-folder");
    std::fs::write(&file, b"x").unwrap();
    let service = start(&["--cache", file.to_str().unwrap()]);
    let cube = model("rounded-cube.glb");
    for size in [32, 33] {
        let query = format!("/render?size={size}");
        assert!(service.post(&query, &cube).headers["server-timing"].contains("drawn"));
    }
    service.wait_for("overcoat_cache_total{event=\"write_error\"}", 2.0);
    assert!(service.log().contains("the cache cannot be written"));
}

#[test]
fn connections_that_say_nothing_are_closed() {
    let service = start(&["--header-seconds", "0.5", "--max-connections", "2"]);
    let mut silent = service.connect();
    let mut half = service.connect();
    half.write_all(b"GET /health HT").unwrap();
    // The third waits until they have gone.
    assert_eq!(service.get("/health").status, 200);
    let mut rest = Vec::new();
    assert_eq!(silent.read_to_end(&mut rest).unwrap(), 0);
    let _ = half.read_to_end(&mut rest);
    let mut preface = service.connect();
    preface.write_all(b"PRI * HT").unwrap();
    assert_eq!(preface.read_to_end(&mut rest).map_or(0, |_| 0), 0);
}

#[test]
fn connections_are_kept_for_the_next_request() {
    let service = start(&[]);
    let mut stream = service.connect();
    for _ in 0..3 {
        stream.write_all(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
        assert_eq!(crate::service::read_answer(&mut stream, "GET").unwrap().status, 200);
    }
}

#[tokio::test]
async fn http2_is_spoken_too() {
    let folder = model_path("");
    let service = start(&["--allow-unsigned", "--local", folder.to_str().unwrap()]);
    let stream = tokio::net::TcpStream::connect(service.address).await.unwrap();
    let io = hyper_util::rt::TokioIo::new(stream);
    let (sender, connection) =
        hyper::client::conn::http2::handshake(hyper_util::rt::TokioExecutor::new(), io).await.unwrap();
    tokio::spawn(connection);
    let ask = |size: u32| {
        let mut sender = sender.clone();
        async move {
            let uri = format!("http://x/_/size:{size}/plain/local://rounded-cube.glb@png");
            let request =
                hyper::Request::get(uri).body(http_body_util::Empty::<bytes::Bytes>::new()).unwrap();
            let response = sender.send_request(request).await.unwrap();
            assert_eq!(
                (response.status(), response.version()),
                (hyper::StatusCode::OK, hyper::Version::HTTP_2)
            );
            http_body_util::BodyExt::collect(response.into_body()).await.unwrap().to_bytes()
        }
    };
    // Several at a time on one connection.
    let (a, b, c) = tokio::join!(ask(20), ask(21), ask(22));
    for (bytes, size) in [(a, 20), (b, 21), (c, 22)] {
        assert_eq!(bytes[16..20], u32::to_be_bytes(size));
    }
}
