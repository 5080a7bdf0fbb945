//! Ways out of a model's folder, and files that are none.

use super::attack::Must::{Fail, Warn};
use super::attack::{Attack, Must};
use std::path::Path;

/// A document whose only buffer is at this URI.
fn buffer(name: &'static str, tries: &'static str, uri: &str, must: Must) -> Attack {
    let json = serde_json::json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": uri}]});
    Attack::model(name, tries, "x.gltf", json.to_string(), must)
}

/// An OBJ file whose material has this picture.
fn map(name: &'static str, tries: &'static str, path: &str, must: Must) -> Attack {
    let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    Attack::model(name, tries, "x.obj", text, must).with("m.mtl", format!("newmtl a\nmap_Kd {path}\n"))
}

/// Links are made on systems that have them; elsewhere the name leads nowhere.
fn link(to: &str, at: &Path) {
    #[cfg(unix)]
    std::os::unix::fs::symlink(to, at).unwrap();
    #[cfg(not(unix))]
    let _ = (to, at);
}

fn sparse_file(folder: &Path) {
    // A hole of 8 TiB, where the file system has holes that large.
    let file = std::fs::File::create(folder.join("huge.bin")).unwrap();
    if file.set_len(8 << 40).is_err() {
        file.set_len(3 << 30).unwrap();
    }
}

fn pipe(folder: &Path) {
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe")).status();
    if !made.is_ok_and(|status| status.success()) {
        // Without pipes: something else that is no file.
        std::fs::create_dir(folder.join("pipe")).unwrap();
    }
}

pub fn attacks() -> Vec<Attack> {
    let outside = Fail("leads out of the model's folder");
    let gone = Fail("cannot be read");
    let mut attacks = vec![
        buffer("path-parent", "a file beside the folder", "../secret", outside),
        buffer("path-parent-later", "the same after going down", "a/b/../../../secret", outside),
        buffer("path-parent-backslash", "the same as Windows writes it", "..\\secret", outside),
        buffer("path-parent-encoded", "the same in percent encoding", "%2e%2e%2fsecret", outside),
        buffer("path-parent-half-encoded", "the same with an encoded slash", "..%2Fsecret", outside),
        buffer("path-parent-twice-encoded", "decoding twice", "%252e%252e%252fsecret", gone),
        buffer("path-overlong", "the same in overlong UTF-8", "%c0%ae%c0%ae%c0%afsecret", gone),
        buffer("path-absolute", "a file of the system", "/etc/passwd", outside),
        buffer(
            "path-absolute-double",
            "an absolute path that does not look like it",
            "//etc/passwd",
            outside,
        ),
        buffer("path-windows-drive", "a drive", "C:\\Windows\\win.ini", outside),
        buffer("path-windows-share", "a server", "\\\\server\\share\\x", outside),
        buffer("path-windows-device", "a device namespace", "\\\\?\\C:\\x", outside),
        buffer("path-file-scheme", "a file of the system by its address", "file:///etc/passwd", outside),
        buffer("path-http", "a request to a server", "http://127.0.0.1:9/x", outside),
        buffer("path-http-upper", "the same in other letters", "HTTPS://example.com/x", outside),
        buffer("path-home", "a file of the user", "~/.ssh/id_rsa", gone),
        buffer("path-proc", "the memory of this process", "/proc/self/mem", outside),
        buffer("path-proc-relative", "the same without a slash", "proc/self/environ", gone),
        buffer("path-nul", "a name that ends early", "x.bin%00.png", outside),
        buffer("path-stream", "an alternative data stream", "x.gltf::$DATA", outside),
        buffer("path-empty", "a name of nothing", "", Fail("cannot be read")),
        buffer("path-dot", "the folder itself", ".", Fail("not a regular file")),
        buffer("path-itself", "the model as its own buffer", "x.gltf", Fail("position")),
        buffer("path-long", "a name of a megabyte", &"a/".repeat(1 << 19), Fail("URI has")),
        buffer("path-long-component", "a name longer than file systems take", &"a".repeat(4000), gone),
        map("map-parent", "a picture beside the folder", "../secret.png", Warn("left out")),
        map("map-absolute", "a picture from anywhere", "/etc/passwd", Warn("left out")),
        map(
            "map-backslash",
            "a picture beside the folder, as Windows writes it",
            "..\\secret.png",
            Warn("left out"),
        ),
        map("map-http", "a request to a server", "http://127.0.0.1:9/x.png", Warn("left out")),
        Attack::model(
            "library-parent",
            "a library beside the folder",
            "x.obj",
            "mtllib ../secret.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n",
            Warn("secret.mtl"),
        ),
        buffer("sparse-file", "reading a hole of terabytes", "huge.bin", Must::Exceed("huge.bin"))
            .prepared(sparse_file),
    ];
    if cfg!(unix) {
        attacks.extend([
            buffer("link-out", "a link out of the folder", "link", outside).prepared(|folder| {
                std::fs::write(folder.join("../secret"), [0; 36]).unwrap();
                link("../secret", &folder.join("link"));
            }),
            buffer("link-absolute", "a link to the system", "link", outside)
                .prepared(|folder| link("/etc/passwd", &folder.join("link"))),
            buffer("link-folder-out", "a folder that is a link", "link/passwd", outside)
                .prepared(|folder| link("/etc", &folder.join("link"))),
            buffer("link-loop", "a link to itself", "link", gone)
                .prepared(|folder| link("link", &folder.join("link"))),
            buffer("link-two-loop", "two links to each other", "a", gone).prepared(|folder| {
                link("b", &folder.join("a"));
                link("a", &folder.join("b"));
            }),
            buffer("link-chain", "a long chain of links", "l0", gone).prepared(|folder| {
                for k in 0..100 {
                    link(&format!("l{}", k + 1), &folder.join(format!("l{k}")));
                }
            }),
            buffer("link-to-proc", "the memory of this process", "link", outside)
                .prepared(|folder| link("/proc/self/mem", &folder.join("link"))),
            buffer("link-to-device", "a file without an end", "link", outside)
                .prepared(|folder| link("/dev/zero", &folder.join("link"))),
            buffer(
                "link-within",
                "nothing: a link within the folder is fine",
                "link",
                Warn("nothing to see"),
            )
            .prepared(|folder| {
                std::fs::write(folder.join("data"), [0; 36]).unwrap();
                link("data", &folder.join("link"));
            }),
            buffer("pipe", "waiting for a writer", "pipe", Fail("not a regular file")).prepared(pipe),
            Attack {
                ask: super::attack::Ask::Model("pipe"),
                ..Attack::model("model-is-pipe", "waiting for a writer", "y", "", Fail("it is"))
                    .prepared(pipe)
            },
            Attack {
                ask: super::attack::Ask::Model("/dev/zero"),
                ..Attack::model(
                    "model-is-device",
                    "a file without an end",
                    "y",
                    "",
                    Fail("not a regular file"),
                )
            },
            Attack {
                ask: super::attack::Ask::Model("huge.bin"),
                ..Attack::model(
                    "model-is-hole",
                    "reading a hole of terabytes",
                    "y",
                    "",
                    Must::Exceed("input_bytes"),
                )
                .prepared(sparse_file)
            },
            Attack {
                ask: super::attack::Ask::Environment("pipe"),
                ..Attack::model("environment-is-pipe", "waiting for a writer", "y", "", Fail("it is"))
                    .prepared(pipe)
            },
        ]);
    }
    attacks
}
