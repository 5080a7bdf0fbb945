//! View of those who watch over the service: metrics of the process, and a port of their own.

use crate::service::{Answer, Service, ask, model, start};

fn get(service: &Service, path: &str) -> Answer {
    ask(service.metrics.unwrap(), "GET", path, &[], &[]).unwrap()
}

/// A value by its name in the metrics.
fn value(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
    Some(line.parse().unwrap())
}

#[test]
fn the_process_is_measured() {
    let service = start(&[]);
    service.post("/render?size=200&quality=best", &model("sports-car.glb")).png(200, 200);
    let text = String::from_utf8(service.get("/metrics").body).unwrap();
    assert!(text.ends_with("# EOF\n") && text.matches("# EOF").count() == 1, "{text}");
    let of = |name: &str| value(&text, name);
    if !cfg!(target_os = "linux") {
        assert!(!text.contains("process_"), "{text}");
        return;
    }
    assert!(text.contains("# TYPE process_cpu_seconds counter"), "{text}");
    assert!(of("process_cpu_seconds_total").is_some_and(|seconds| seconds < 1e4), "{text}");
    assert!(of("process_resident_memory_bytes").unwrap() > 1e6);
    // Standard streams, the socket, and the pipes of a worker.
    let files = of("process_open_fds").unwrap();
    assert!(files >= 7.0, "{text}");
    let open = std::fs::read_dir(format!("/proc/{}/fd", service.id())).unwrap().count() as f64;
    assert!((files - open).abs() <= 4.0, "{files} {open}");
    // The service was started after this test's process, or in the same moment.
    let own = std::fs::metadata("/proc/self").unwrap().modified().unwrap();
    let own = own.duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
    let started = of("process_start_time_seconds").unwrap();
    assert!((started - own).abs() < 3600.0, "{started} {own}");
    assert!(of("overcoat_worker_cpu_seconds_total").unwrap() > 0.0, "{text}");
}

/// The time in the queue is a number from the start, for those who scale by it, and has descriptions as well.
#[test]
fn the_wait_is_measured_from_the_start() {
    let service = start(&[]);
    let count = || service.metric("overcoat_render_seconds_count{stage=\"queue\"}");
    let text = String::from_utf8(service.get("/metrics").body).unwrap();
    assert_eq!(value(&text, "overcoat_render_seconds_sum{stage=\"queue\"}"), Some(0.0), "{text}");
    service.post("/info", &model("rounded-cube.glb"));
    assert_eq!(count(), 1.0);
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
    assert_eq!(count(), 2.0);
}

#[test]
fn metrics_can_have_a_port_of_their_own() {
    let service = start(&["--metrics-listen", "127.0.0.1:0"]);
    assert_ne!(service.metrics, Some(service.address));
    assert_eq!(service.get("/metrics").error(404).0, "not_found");
    service.post("/render?size=16", &model("rounded-cube.glb")).png(16, 16);
    let text = String::from_utf8(get(&service, "/metrics").body).unwrap();
    assert_eq!(value(&text, "overcoat_requests_total{route=\"render\",status=\"200\"}"), Some(1.0));
    assert_eq!(value(&text, "overcoat_requests_total{route=\"metrics\",status=\"404\"}"), Some(1.0));
    for path in ["/health", "/ready"] {
        assert_eq!(service.get(path).status, 200, "{path}");
        assert_eq!(get(&service, path).status, 200, "{path}");
    }
    // Nothing else is there.
    for path in ["/", "/formats", "/render", "/_/plain/local://a.glb"] {
        assert_eq!(get(&service, path).error(404).0, "not_found", "{path}");
    }
}

#[test]
fn failures_and_slow_requests_are_shown() {
    let service = start(&["--metrics-listen", "127.0.0.1:0"]);
    let cube = model("rounded-cube.glb");
    service.post("/render?size=16", &cube).png(16, 16);
    service.post("/render?size=200&quality=best", &cube).png(200, 200);
    service.post("/render?size=17&name=%3Cscript%3E.glb", &cube[..300]).error(422);
    service.post("/render?size=18", &cube[..300]).error(422);
    let status = get(&service, "/status.json").json();
    assert_eq!((&status["ready"], &status["workers"]), (&true.into(), &1.into()));
    assert_eq!((&status["working"], &status["failures_remembered"]), (&0.into(), &2.into()));
    let failures = status["failures"].as_array().unwrap();
    assert_eq!(failures.len(), 2);
    assert_eq!(failures[0]["options"], "format=png&size=18x18");
    assert_eq!((&failures[1]["error"], &failures[1]["file"]), (&"model".into(), &"<script>.glb".into()));
    assert!(!failures[0]["reason"].as_str().unwrap().is_empty());
    let slowest = status["slowest"].as_array().unwrap();
    let times: Vec<f64> = slowest.iter().map(|line| line["total_ms"].as_f64().unwrap()).collect();
    assert!(times.len() == 2 && times[0] >= times[1], "{times:?}");
    // The page has the same, and what clients write is text there.
    let page = get(&service, "/status");
    let text = String::from_utf8(page.body).unwrap();
    assert!(text.contains("&lt;script&gt;.glb") && !text.contains("<script"), "{text}");
    assert!(page.headers["content-security-policy"].starts_with("default-src 'none'"));
    // Clients do not see it.
    assert_eq!(service.get("/status").error(404).0, "not_found");
    assert_eq!(start(&[]).get("/status").error(404).0, "not_found");
}

/// Metrics are answered to the end.
#[test]
fn metrics_are_there_to_the_end() {
    let mut service = start(&["--metrics-listen", "127.0.0.1:0", "--stop-seconds", "300"]);
    let address = service.address;
    let slow = std::thread::spawn(move || {
        let path = "/render?size=400&quality=good";
        ask(address, "POST", path, &[], &model("sports-car.glb")).unwrap()
    });
    let busy = |service: &Service| {
        let text = String::from_utf8(get(service, "/metrics").body).unwrap();
        value(&text, "overcoat_workers_busy") == Some(1.0)
    };
    while !busy(&service) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    service.workers().into_iter().for_each(|id| crate::service::send_signal("STOP", id));
    service.signal("TERM");
    // The other port closes first.
    while std::net::TcpStream::connect(service.address).is_ok() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert!(busy(&service));
    assert_eq!(get(&service, "/ready").error(503).0, "stopping");
    service.workers().into_iter().for_each(|id| crate::service::send_signal("CONT", id));
    slow.join().unwrap().png(400, 400);
    assert!(service.ended().success());
}
