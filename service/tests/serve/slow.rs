//! Clients that take their time, and whom others must not wait for.

use crate::service::{Answer, Service, model, read_answer, start};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

const HALF: &[u8] = b"GET /health HTTP/1.1\r\nHost: x\r\nX-Slow: ";

/// Half-sent heads, as many as this process has descriptors for.
fn many() -> usize {
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let open = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max open files")?.split_whitespace().next()?.parse().ok());
    open.map_or(256, |open: usize| (open / 2).min(1024))
}

/// A connection from an address of this machine.
fn connect_from(service: &Service, from: &str, receive: Option<u32>) -> TcpStream {
    let connect = async {
        let socket = tokio::net::TcpSocket::new_v4().unwrap();
        if let Some(bytes) = receive {
            socket.set_recv_buffer_size(bytes).unwrap();
        }
        socket.bind(format!("{from}:0").parse().unwrap()).unwrap();
        socket.connect(service.address).await.unwrap().into_std().unwrap()
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().unwrap();
    let stream = runtime.block_on(connect);
    stream.set_nonblocking(false).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
    stream
}

fn half_head(service: &Service, from: &str) -> TcpStream {
    let mut stream = connect_from(service, from, None);
    // One that is refused at once may be closed by now.
    let _ = stream.write_all(HALF);
    stream
}

/// True if the service has neither answered nor closed a connection.
fn is_open(stream: &mut TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let read = stream.read(&mut [0; 1]);
    stream.set_nonblocking(false).unwrap();
    read.is_err_and(|error| error.kind() == ErrorKind::WouldBlock)
}

fn answer(stream: &mut TcpStream) -> std::io::Result<Answer> {
    read_answer(stream, "GET")
}

/// The rest of what a connection says, until it is closed.
fn until_closed(stream: &mut TcpStream) -> Vec<u8> {
    let mut rest = Vec::new();
    let _ = stream.read_to_end(&mut rest);
    rest
}

fn closed(service: &Service, reason: &str) -> f64 {
    service.metric(&format!("overcoat_connections_closed_total{{reason=\"{reason}\"}}"))
}

#[test]
fn half_heads_give_way_to_good_requests() {
    let count = many();
    let most = count.to_string();
    let service =
        start(&["--max-connections", &most, "--client-connections", "5000", "--header-seconds", "1000"]);
    let mut half: Vec<TcpStream> = (0..count).map(|_| half_head(&service, "127.0.0.1")).collect();
    service.post("/render?size=32", &model("rounded-cube.glb")).png(32, 32);
    assert!(is_open(half.last_mut().unwrap()), "it was answered when the half heads had gone");
    // The oldest have given way, and were told.
    assert_eq!(answer(&mut half[0]).unwrap().error(503).0, "busy");
    let gone = closed(&service, "full");
    assert!((1.0..10.0).contains(&gone), "{gone}");
    // Other clients' connections stay, where one has most of them.
    let mut other = half_head(&service, "127.0.0.2");
    for _ in 0..3 {
        assert_eq!(service.get("/health").status, 200);
    }
    assert!(is_open(&mut other));
}

#[test]
fn one_address_has_so_many_connections() {
    let service = start(&["--client-connections", "8", "--header-seconds", "1000"]);
    let count = many();
    let mut half: Vec<TcpStream> = (0..count).map(|_| half_head(&service, "127.0.0.2")).collect();
    service.post("/render?size=32", &model("rounded-cube.glb")).png(32, 32);
    service.wait_for("overcoat_connections_closed_total{reason=\"client\"}", (count - 8) as f64);
    assert_eq!(closed(&service, "client"), (count - 8) as f64);
    assert!(half[..8].iter_mut().all(is_open));
    // A client with one less may have another, and one more is told why not.
    drop(half);
    let mut again: Vec<TcpStream> = Vec::new();
    for _ in 0..200 {
        again.push(half_head(&service, "127.0.0.2"));
        std::thread::sleep(Duration::from_millis(5));
        if again.iter_mut().filter_map(|stream| is_open(stream).then_some(())).count() == 8 {
            break;
        }
    }
    let refused = answer(&mut half_head(&service, "127.0.0.2")).unwrap();
    let (kind, message) = refused.error(429);
    assert_eq!((kind.as_str(), refused.headers["retry-after"].as_str()), ("connections", "1"));
    assert!(message.contains('8'), "{message}");
    assert!(service.get("/metrics").body.windows(11).any(|part| part == b"connections"));
}

#[test]
fn proxies_have_any_number_of_connections() {
    let service =
        start(&["--client-connections", "2", "--trusted-proxies", "127.0.0.2", "--header-seconds", "1000"]);
    let mut half: Vec<TcpStream> = (0..20).map(|_| half_head(&service, "127.0.0.2")).collect();
    service.wait_for("overcoat_connections", 21.0);
    assert!(half.iter_mut().all(is_open));
    assert_eq!(closed(&service, "client"), 0.0);
}

#[test]
fn heads_have_their_time_the_first_and_the_next() {
    let service = start(&["--header-seconds", "0.3", "--log", "debug"]);
    let mut half = half_head(&service, "127.0.0.1");
    let (kind, message) = answer(&mut half).unwrap().error(408);
    assert!(kind == "slow" && message.contains("0.3 s"), "{message}");
    assert!(until_closed(&mut half).is_empty());
    // A byte now and then is no head.
    let mut next = service.connect();
    next.write_all(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
    assert_eq!(answer(&mut next).unwrap().status, 200);
    let mut sending = next.try_clone().unwrap();
    let drip = std::thread::spawn(move || {
        while HALF.iter().all(|byte| {
            std::thread::sleep(Duration::from_millis(20));
            sending.write_all(&[*byte]).is_ok()
        }) {}
    });
    assert_eq!(answer(&mut next).unwrap().error(408).0, "slow");
    drop(next);
    drip.join().unwrap();
    assert_eq!(closed(&service, "head"), 2.0);
    assert!(service.log().contains("\"reason\":\"head\""), "{}", service.log());
}

#[test]
fn idle_connections_are_closed() {
    let service = start(&["--idle-seconds", "0.2"]);
    let mut stream = service.connect();
    for _ in 0..2 {
        stream.write_all(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
        assert_eq!(answer(&mut stream).unwrap().status, 200);
    }
    assert!(until_closed(&mut stream).is_empty());
    assert_eq!(closed(&service, "idle"), 1.0);
}

#[test]
fn who_reads_no_answer_is_closed() {
    let service = start(&["--write-seconds", "0.3", "--idle-seconds", "0.3", "--header-seconds", "100"]);
    let cube = model("rounded-cube.glb");
    let mut deaf = connect_from(&service, "127.0.0.1", Some(4096));
    let path = "/render?size=900&quality=draft&format=exr&aov=position,normal,depth";
    let head = format!("POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: {}\r\n\r\n", cube.len());
    deaf.write_all(head.as_bytes()).unwrap();
    deaf.write_all(&cube).unwrap();
    service.wait_for("overcoat_connections_closed_total{reason=\"answer\"}", 1.0);
    // Pipelined requests whose answers are not taken are no way to stay.
    let mut many = connect_from(&service, "127.0.0.1", Some(4096));
    let _ = many.write_all(&b"GET / HTTP/1.1\r\nHost: x\r\n\r\n".repeat(2000));
    service.wait_for("overcoat_connections_closed_total{reason=\"idle\"}", 1.0);
    service.wait_for("overcoat_connections", 1.0);
}

#[tokio::test]
async fn who_opens_no_window_is_closed() {
    let service = start(&["--write-seconds", "0.3"]);
    let stream = tokio::net::TcpStream::connect(service.address).await.unwrap();
    let io = hyper_util::rt::TokioIo::new(stream);
    let mut builder = hyper::client::conn::http2::Builder::new(hyper_util::rt::TokioExecutor::new());
    let (mut sender, connection) = builder.initial_stream_window_size(0).handshake(io).await.unwrap();
    let connection = tokio::spawn(connection);
    let request =
        hyper::Request::get("http://x/").body(http_body_util::Empty::<bytes::Bytes>::new()).unwrap();
    let response = sender.send_request(request).await.unwrap();
    assert_eq!(response.status(), hyper::StatusCode::OK);
    // It ends though the client is there.
    let _ = connection.await;
    assert_eq!(closed(&service, "answer"), 1.0);
}
