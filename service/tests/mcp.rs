//! `overcoat-service mcp` as a client sees it: lines of JSON-RPC over standard streams.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

struct Client {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    id: u64,
}

impl Client {
    fn start(root: &Path, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_overcoat-service"));
        command.arg("mcp").arg("--root").arg(root).args(["--size", "32"]).args(more);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (child.stdin.take(), BufReader::new(child.stdout.take().unwrap()));
        let mut client = Self { child, to, from, id: 0 };
        let told = client.ask(
            "initialize",
            json!({"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}),
        );
        assert_eq!(told["serverInfo"]["name"], "overcoat");
        assert!(told["instructions"].as_str().unwrap().contains("`info` first"));
        client.say(&json!({"jsonrpc": "2.0", "method": "notifications/initialized"}));
        client
    }

    fn say(&mut self, message: &Value) {
        writeln!(self.to.as_mut().unwrap(), "{message}").unwrap();
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.id += 1;
        let id = self.id;
        self.say(&json!({"jsonrpc": "2.0", "id": id, "method": method, "params": params}));
        let mut line = String::new();
        loop {
            line.clear();
            assert!(self.from.read_line(&mut line).unwrap() > 0, "{method}: the server has ended");
            let mut message: Value = serde_json::from_str(&line).unwrap();
            if message["id"] == id {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].take();
            }
        }
    }

    fn call(&mut self, tool: &str, arguments: Value) -> Value {
        self.ask("tools/call", json!({"name": tool, "arguments": arguments}))
    }

    /// Kind of the error that a call ends with.
    fn error(&mut self, tool: &str, arguments: Value) -> String {
        let told = self.call(tool, arguments);
        assert_eq!(told["isError"], true, "{told}");
        told["structuredContent"]["kind"].as_str().unwrap().to_owned()
    }

    /// Ends when its input does.
    fn end(mut self) {
        drop(self.to.take());
        assert!(self.child.wait().unwrap().success());
    }
}

fn models() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models")
}

/// Width of a PNG picture in a content block.
fn width(block: &Value) -> u32 {
    assert_eq!((&block["type"], &block["mimeType"]), (&json!("image"), &json!("image/png")));
    let bytes = STANDARD.decode(block["data"].as_str().unwrap()).unwrap();
    assert!(bytes.starts_with(b"\x89PNG"));
    u32::from_be_bytes(bytes[16..20].try_into().unwrap())
}

#[test]
fn tools_draw_and_tell() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rounded-cube.glb", "torus-knot.glb"] {
        std::fs::copy(models().join(name), folder.path().join(name)).unwrap();
    }
    let mut client = Client::start(folder.path(), &["--write"]);
    let tools = client.ask("tools/list", json!({}));
    let names: Vec<&str> =
        tools["tools"].as_array().unwrap().iter().map(|t| t["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["render", "views", "diagnose", "info", "compare_models", "compare_pictures", "materials"]
    );

    let drawn = client.call(
        "render",
        json!({"model": "rounded-cube.glb", "options": {"size": 48, "view": "front"}, "save": "a.png"}),
    );
    assert_eq!(width(&drawn["content"][0]), 48);
    let report = &drawn["structuredContent"];
    assert_eq!((&report["width"], report["frame_hash"].as_str().map(str::len)), (&json!(48), Some(32)));
    assert_eq!(std::fs::read(folder.path().join("a.png")).unwrap()[..4], *b"\x89PNG");
    let again = client.call(
        "render",
        json!({"model": "./rounded-cube.glb", "options": {"view": "front", "size": "48x48"}}),
    );
    assert_eq!(again["structuredContent"]["frame_hash"], report["frame_hash"]);

    let views = client.call("views", json!({"model": "torus-knot.glb", "views": ["front", "0,1,0"]}));
    let blocks = views["content"].as_array().unwrap();
    assert_eq!((blocks.len(), width(&blocks[1]), width(&blocks[3])), (4, 32, 32));
    assert_ne!(blocks[1]["data"], blocks[3]["data"]);

    let arguments = json!({"model": "rounded-cube.glb", "options": {"size": 300, "env": "none"}});
    let told = client.call("diagnose", arguments);
    let report = &told["structuredContent"];
    assert_eq!(report["findings"][0]["code"], "no-light", "{told}");
    assert_eq!(report["findings"][0]["remedy"], "--env studio");
    assert_eq!(report["measures"]["width"], 256);
    let told = client.call("diagnose", json!({"model": "rounded-cube.glb", "options": {"env": "studio"}}));
    assert_eq!(told["structuredContent"]["findings"], json!([]), "{told}");

    let info = client.call("info", json!({"model": "torus-knot.glb"}));
    assert!(info["structuredContent"]["triangles"].as_u64().unwrap() > 100);
    let materials = client.call("materials", json!({}));
    assert!(materials["content"][0]["text"].as_str().unwrap().contains("candy-red\n"));
    let file = client.call("materials", json!({"name": "candy-red"}));
    assert!(file["content"][0]["text"].as_str().unwrap().contains("coat"));
    client.end();
}

#[test]
fn wrong_calls_have_a_kind_and_the_server_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(models().join("rounded-cube.glb"), folder.path().join("a.glb")).unwrap();
    std::fs::write(folder.path().join("broken.glb"), "glTF").unwrap();
    let mut client = Client::start(folder.path(), &[]);
    for (tool, arguments, kind) in [
        ("render", json!({}), "options"),
        ("render", json!({"model": "a.glb", "size": 3}), "options"),
        ("render", json!({"model": "a.glb", "options": {"qualty": "good"}}), "options"),
        ("render", json!({"model": "a.glb", "options": {"env": "/etc/passwd"}}), "options"),
        ("render", json!({"model": "a.glb", "options": {"format": "exr"}}), "options"),
        ("render", json!({"model": "a.glb", "options": {"size": 1000000}}), "options"),
        ("render", json!({"model": "a.glb", "save": "a.png"}), "not_offered"),
        ("render", json!({"model": "../a.glb"}), "not_found"),
        ("render", json!({"model": "/etc/passwd"}), "source"),
        ("render", json!({"model": "broken.glb"}), "model"),
        ("info", json!({"model": "none.glb"}), "not_found"),
        ("views", json!({"model": "a.glb", "views": []}), "options"),
        ("views", json!({"model": "a.glb", "views": ["fornt"]}), "options"),
        ("compare_models", json!({"before": "a.glb", "after": "/etc/passwd"}), "source"),
        ("compare_pictures", json!({"expected": "a.glb", "actual": "a.glb", "preset": "soft"}), "options"),
        ("materials", json!({"name": "chocolate"}), "options"),
        ("delete", json!({}), "options"),
    ] {
        assert_eq!(client.error(tool, arguments.clone()), kind, "{tool} {arguments}");
    }
    assert_eq!(width(&client.call("render", json!({"model": "a.glb"}))["content"][0]), 32);
    client.end();
}

/// These are done by the program `overcoat`, which is there where the whole workspace was built.
#[test]
fn models_and_pictures_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rounded-cube.glb", "torus-knot.glb"] {
        std::fs::copy(models().join(name), folder.path().join(name)).unwrap();
    }
    let mut client = Client::start(folder.path(), &["--write"]);
    for (model, name) in
        [("rounded-cube.glb", "a.png"), ("rounded-cube.glb", "b.png"), ("torus-knot.glb", "c.png")]
    {
        client.call("render", json!({"model": model, "save": name}));
    }
    let program = Path::new(env!("CARGO_BIN_EXE_overcoat-service")).with_file_name("overcoat");
    if !program.is_file() {
        let arguments = json!({"expected": "a.png", "actual": "b.png"});
        // Or another one is on the path.
        let told = client.call("compare_pictures", arguments);
        assert!(told["isError"] == true || told["structuredContent"]["passed"] == true, "{told}");
        return;
    }
    for (actual, passed) in [("b.png", true), ("c.png", false)] {
        let told = client.call("compare_pictures", json!({"expected": "a.png", "actual": actual}));
        assert_eq!(told["structuredContent"]["passed"], passed, "{told}");
    }
    for (after, equal) in [("rounded-cube.glb", true), ("torus-knot.glb", false)] {
        let told =
            client.call("compare_models", json!({"before": "rounded-cube.glb", "after": after, "size": 64}));
        assert_eq!(told["structuredContent"]["equal"], equal, "{told}");
        assert!(width(&told["content"][0]) > 64);
    }
    client.end();
}

#[test]
fn a_root_that_is_none_is_told() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_overcoat-service"));
    let output = command.args(["mcp", "--root", "/no/such/folder"]).stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("overcoat: --root /no/such/folder: "));
}
