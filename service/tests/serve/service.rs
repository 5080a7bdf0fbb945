//! A service that runs, and a small client.

use serde_json::Value;
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The program.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_overcoat-service");

/// A model of the repository.
pub fn model_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models").join(name)
}

/// Content of the file of a model.
pub fn model(name: &str) -> Vec<u8> {
    std::fs::read(model_path(name)).unwrap()
}

/// A service that is ended with the test.
pub struct Service {
    child: Child,
    pub address: SocketAddr,
    /// Address of the metrics, if they have a port of their own.
    pub metrics: Option<SocketAddr>,
    log: Arc<Mutex<String>>,
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: HashMap<String, String>,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|e| panic!("{e}: {} {}", self.status, String::from_utf8_lossy(&self.body)))
    }

    /// The kind and the message of an error, whose status is checked.
    pub fn error(&self, status: u16) -> (String, String) {
        assert_eq!(self.status, status, "{}", String::from_utf8_lossy(&self.body));
        assert_eq!(self.headers["content-type"], "application/json");
        let error = &self.json()["error"];
        (error["kind"].as_str().unwrap().to_owned(), error["message"].as_str().unwrap().to_owned())
    }

    /// The bytes of a PNG picture, whose size is checked.
    pub fn png(&self, width: u32, height: u32) -> &[u8] {
        assert_eq!(self.status, 200, "{}", String::from_utf8_lossy(&self.body));
        assert_eq!(self.headers["content-type"], "image/png");
        assert!(self.body.starts_with(b"\x89PNG\r\n\x1a\n") && self.body.ends_with(b"IEND\xaeB`\x82"));
        let side = |at: usize| u32::from_be_bytes(self.body[at..at + 4].try_into().unwrap());
        assert_eq!((side(16), side(20)), (width, height));
        &self.body
    }

    pub fn etag(&self) -> &str {
        &self.headers["etag"]
    }
}

/// Arguments of a service beside a free port and one worker.
pub fn start(args: &[&str]) -> Service {
    start_with(Path::new(PROGRAM), args, &[])
}

pub fn start_with(program: &Path, args: &[&str], variables: &[(&str, &str)]) -> Service {
    let mut command = std::process::Command::new(program);
    command.args(["serve", "--listen", "127.0.0.1:0"]);
    if !args.contains(&"--workers") {
        command.args(["--workers", "1"]);
    }
    command.args(args).envs(variables.iter().copied()).stdin(Stdio::null());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let log = Arc::new(Mutex::new(String::new()));
    let (errors, kept) = (child.stderr.take().unwrap(), Arc::clone(&log));
    std::thread::spawn(move || {
        for line in BufReader::new(errors).lines().map_while(Result::ok) {
            *kept.lock().unwrap() += &(line + "\n");
        }
    });
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    let mut told = |before: &str, after: &str| {
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix(before).and_then(|line| line.strip_suffix(after));
        address.unwrap_or_else(|| panic!("'{line}' {}", log.lock().unwrap())).parse().unwrap()
    };
    let address = told("listening on http://", "");
    let metrics = args.contains(&"--metrics-listen").then(|| told("metrics on http://", "/metrics"));
    Service { child, address, metrics, log }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Service {
    pub fn get(&self, path: &str) -> Answer {
        self.request("GET", path, &[], &[])
    }

    pub fn post(&self, path: &str, body: &[u8]) -> Answer {
        self.request("POST", path, &[], body)
    }

    pub fn request(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        ask(self.address, method, path, headers, body).unwrap()
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        stream
    }

    pub fn log(&self) -> String {
        self.log.lock().unwrap().clone()
    }

    /// Waits for the line of the log, in JSON, about the request of a name.
    pub fn line(&self, id: &str) -> Value {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            let lines =
                self.log().lines().filter_map(|line| serde_json::from_str(line).ok()).collect::<Vec<Value>>();
            if let Some(line) = lines.into_iter().find(|line| line["id"] == id && line.get("route").is_some())
            {
                return line;
            }
            assert!(Instant::now() < end, "there is no line of {id}: {}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// A value of the metrics, 0 if there is none.
    pub fn metric(&self, name: &str) -> f64 {
        let text = String::from_utf8(self.get("/metrics").body).unwrap();
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.map_or(0.0, |value| value.parse().unwrap())
    }

    /// Waits until a metric has reached a value.
    pub fn wait_for(&self, name: &str, value: f64) {
        let end = Instant::now() + Duration::from_secs(60);
        while self.metric(name) < value {
            assert!(Instant::now() < end, "{name} does not reach {value}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub fn signal(&self, name: &str) {
        send_signal(name, self.id());
    }

    /// The processes that it has started.
    pub fn workers(&self) -> Vec<u32> {
        let of = |entry: std::fs::DirEntry| {
            let id: u32 = entry.file_name().to_str()?.parse().ok()?;
            let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
            let (_, rest) = stat.rsplit_once(") ")?;
            let mut fields = rest.split(' ');
            let alive = fields.next()? != "Z";
            (alive && fields.next()?.parse() == Ok(self.id())).then_some(id)
        };
        std::fs::read_dir("/proc").unwrap().filter_map(|entry| of(entry.ok()?)).collect()
    }

    /// Waits for its end.
    pub fn ended(&mut self) -> ExitStatus {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(Instant::now() < end, "it does not end: {}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// The program with arguments that it does not go on with.
pub fn run(args: &[&str]) -> std::process::Output {
    let mut command = std::process::Command::new(PROGRAM);
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let end = Instant::now() + Duration::from_secs(60);
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > end {
            let _ = child.kill();
            panic!("it goes on with {args:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().unwrap()
}

pub fn send_signal(name: &str, process: u32) {
    let done = std::process::Command::new("kill").args([&format!("-{name}"), &process.to_string()]).status();
    assert!(done.unwrap().success());
}

/// One request on one connection.
pub fn ask(
    address: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> std::io::Result<Answer> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(Duration::from_secs(120)))?;
    let mut head = format!("{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n");
    for (name, value) in headers {
        head += &format!("{name}: {value}\r\n");
    }
    if !body.is_empty() || method == "POST" {
        head += &format!("Content-Length: {}\r\n", body.len());
    }
    stream.write_all((head + "\r\n").as_bytes())?;
    // Who refuses a body may answer before all of it has gone.
    let _ = stream.write_all(body);
    read_answer(&mut stream, method)
}

/// Bytes until the end of the connection.
pub fn read_answer(stream: &mut TcpStream, method: &str) -> std::io::Result<Answer> {
    let mut all = Vec::new();
    let mut part = [0; 1 << 16];
    let broken = |what: &str| std::io::Error::other(what.to_owned());
    loop {
        if let Some(answer) = whole(&all, method) {
            return Ok(answer);
        }
        match stream.read(&mut part)? {
            0 => return Err(broken(&format!("the answer ends early: {}", String::from_utf8_lossy(&all)))),
            length => all.extend_from_slice(&part[..length]),
        }
    }
}

fn whole(all: &[u8], method: &str) -> Option<Answer> {
    let end = all.windows(4).position(|four| four == b"\r\n\r\n")?;
    let head = std::str::from_utf8(&all[..end]).unwrap();
    let mut lines = head.lines();
    let status = lines.next()?.split(' ').nth(1)?.parse().ok()?;
    let headers: HashMap<String, String> = lines
        .filter_map(|line| line.split_once(": "))
        .map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned()))
        .collect();
    let length = match headers.get("content-length") {
        Some(_) if method == "HEAD" => 0,
        Some(length) => length.parse().unwrap(),
        None => 0,
    };
    let body = all[end + 4..].to_vec();
    (body.len() >= length).then_some(Answer { status, headers, body })
}

/// A server for sources: what it answers to each path.
pub fn source_server(answer: impl Fn(&str, u16) -> Vec<u8> + Send + 'static) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut head = String::new();
            let mut lines = BufReader::new(stream.try_clone().unwrap());
            while !head.ends_with("\r\n\r\n") && lines.read_line(&mut head).unwrap_or(0) > 0 {}
            let path = head.split(' ').nth(1).unwrap_or_default().to_owned();
            let _ = stream.write_all(&answer(&path, port));
        }
    });
    port
}

/// An answer with a body.
pub fn ok(body: &[u8]) -> Vec<u8> {
    let mut answer = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n", body.len()).into_bytes();
    answer.extend_from_slice(body);
    answer
}

/// A form of parts: name, file name, content.
pub fn form(parts: &[(&str, Option<&str>, &[u8])]) -> (String, Vec<u8>) {
    let mut body = Vec::new();
    for (name, file, content) in parts {
        let file = file.map(|file| format!("; filename=\"{file}\"")).unwrap_or_default();
        body.extend(
            format!("--XyZ\r\nContent-Disposition: form-data; name=\"{name}\"{file}\r\n\r\n").into_bytes(),
        );
        body.extend_from_slice(content);
        body.extend(b"\r\n");
    }
    body.extend(b"--XyZ--\r\n");
    ("multipart/form-data; boundary=XyZ".to_owned(), body)
}

/// An archive of files, as programs that write as they go make it.
pub fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = rawzip::ZipArchiveWriter::new(Vec::new());
    for (name, content) in files {
        let (mut entry, config) = archive.new_file(*name).start().unwrap();
        let mut writer = config.wrap(&mut entry);
        writer.write_all(content).unwrap();
        let (_, end) = writer.finish().unwrap();
        entry.finish(end).unwrap();
    }
    archive.finish().unwrap()
}

/// Files of an archive that stores them as they are.
pub fn unzip(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let archive = rawzip::ZipArchive::from_slice(bytes).unwrap();
    let file = |entry: rawzip::ZipFileHeaderRecord<'_>| {
        let data = archive.get_entry(entry.wayfinder()).unwrap().data().to_vec();
        (String::from_utf8(entry.file_path().as_bytes().to_vec()).unwrap(), data)
    };
    archive.entries().map(|entry| file(entry.unwrap())).collect()
}
