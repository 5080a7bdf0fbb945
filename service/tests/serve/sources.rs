//! Paths: signatures, sources that are allowed, and networks that are not.

use crate::service::{PROGRAM, model, model_path, ok, source_server, start, start_with};
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use std::path::Path;

#[test]
fn keys_rotate() {
    let folder = model_path("");
    let local = folder.to_str().unwrap();
    let path = "/size:48/view:front/plain/local://rounded-cube.glb@png";
    let signed = |key: &str, salt: &str| {
        let mut command = std::process::Command::new(PROGRAM);
        let output = command.args(["serve", "--key", key, "--salt", salt, "--sign", path]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    let (old, new, other) = (signed("0a0b", "01"), signed("0c0d", "02"), signed("0e0f", "03"));
    let service = start(&["--key", "0c0d,0a0b", "--salt", "02,01", "--local", local]);
    let first = service.get(&new);
    first.png(48, 48);
    assert_eq!(service.get(&old).body, first.body);
    assert_eq!(service.get(&other).error(403).0, "signature");
    assert_eq!(service.get(&new.replace("size:48", "size:49")).error(403).0, "signature");
    // What follows a question mark is signed, too.
    assert_eq!(service.get(&format!("{new}?size=64")).error(403).0, "signature");
    // A replayed path is the same picture, and cheap for who has it.
    let known = service.request("GET", &old, &[("If-None-Match", first.etag())], &[]);
    assert_eq!((known.status, known.body.len()), (304, 0));
}

#[test]
fn secrets_come_from_the_environment_and_stay_there() {
    let secret = "736563726574736563726574";
    let variables = [("OVERCOAT_KEY", secret), ("OVERCOAT_SALT", "01"), ("OVERCOAT_MAX_SIZE", "64")];
    let service = start_with(Path::new(PROGRAM), &[], &variables);
    assert_eq!(service.get("/AAAA/plain/local://x.glb").error(403).0, "signature");
    assert!(service.post("/render?size=65", &model("rounded-cube.glb")).error(400).1.contains("1 to 64"));
    assert!(!service.log().contains(secret));
    let help =
        std::process::Command::new(PROGRAM).args(["serve", "--help"]).envs(variables).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    assert!(help.contains("OVERCOAT_KEY") && !help.contains(secret));
}

#[test]
fn folders_are_left_by_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let models = folder.path().join("models");
    std::fs::create_dir(&models).unwrap();
    std::fs::copy(model_path("torus-knot.obj"), models.join("a.obj")).unwrap();
    std::fs::copy(model_path("rounded-cube.glb"), folder.path().join("secret.glb")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("../secret.glb", models.join("link.glb")).unwrap();
    let service = start(&["--allow-unsigned", "--local", models.to_str().unwrap()]);
    service.get("/_/size:16/plain/local://a.obj@png").png(16, 16);
    for source in
        ["local://../secret.glb", "local://%2e%2e/secret.glb", "local://link.glb", "local:///../secret.glb"]
    {
        let answer = service.get(&format!("/_/size:16/plain/{source}@png"));
        assert_eq!(answer.error(403).0, "source", "{source}");
        let answer = service.get(&format!("/_/size:16/{}.png", URL_SAFE_NO_PAD.encode(source)));
        let kind = answer.error(answer.status).0;
        assert!(kind == "source" || kind == "not_found" && source.contains('%'), "{source}: {kind}");
    }
    let encoded = URL_SAFE_NO_PAD.encode("local://a.obj");
    let plain = service.get("/_/size:16/plain/local://a.obj@png");
    assert_eq!(service.get(&format!("/_/size:8/dpr:2/{encoded}.png")).png(16, 16), plain.png(16, 16));
    assert_eq!(service.get("/_/plain/local:///etc/passwd@png").error(404).0, "not_found");
}

/// A path is decoded once: what looks encoded then is the name of a file.
#[test]
fn names_of_local_files_are_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    for (name, asked) in [
        ("a b.glb", "a%20b.glb"),
        ("a%20b.glb", "a%2520b.glb"),
        ("ü@#?%.glb", "%C3%BC%40%23%3F%25.glb"),
        ("below/x%2e.glb", "below/x%252e.glb"),
    ] {
        std::fs::create_dir_all(folder.path().join("below")).unwrap();
        std::fs::copy(model_path("rounded-cube.glb"), folder.path().join(name)).unwrap();
        let service = start(&["--allow-unsigned", "--local", folder.path().to_str().unwrap()]);
        service.get(&format!("/_/size:16/plain/local://{asked}@png")).png(16, 16);
        let encoded = URL_SAFE_NO_PAD.encode(format!("local://{name}"));
        service.get(&format!("/_/size:16/{encoded}.png")).png(16, 16);
    }
}

#[test]
fn private_networks_are_refused() {
    let port = source_server(|_, _| ok(&model("rounded-cube.glb")));
    let service = start(&["--allow-unsigned", "--allow-source", "http://"]);
    for host in [
        "127.0.0.1",
        "localhost",
        "[::1]",
        "[::ffff:127.0.0.1]",
        "0.0.0.0",
        "2130706433",
        "0x7f.1",
        "169.254.169.254",
    ] {
        let answer = service.get(&format!("/_/plain/http://{host}:{port}/x.glb@png"));
        let (kind, message) = answer.error(403);
        assert_eq!(kind, "source", "{host}: {message}");
        assert!(message.contains("private network"), "{host}: {message}");
    }
}

#[test]
fn redirects_are_bounded_and_checked() {
    let port = source_server(|path, port| {
        let to = |location: &str| {
            format!("HTTP/1.1 302 Found\r\nLocation: {location}\r\nContent-Length: 0\r\n\r\n").into_bytes()
        };
        match path {
            "/m/once.glb" => to("/m/x.glb"),
            "/m/three.glb" => to("/m/two.glb"),
            "/m/two.glb" => to("/m/once.glb"),
            "/m/round.glb" => to("/m/round.glb"),
            "/m/out.glb" => to("/secret/x.glb"),
            "/m/private.glb" => to(&format!("http://127.0.0.2:{port}/m/x.glb")),
            "/m/file.glb" => to("file:///etc/passwd"),
            _ => ok(&model("rounded-cube.glb")),
        }
    });
    let (allowed, elsewhere) = (format!("http://127.0.0.1:{port}/m/"), format!("http://127.0.0.2:{port}/"));
    // The second address is allowed as a source, and not as a network.
    let service = start(&[
        "--allow-unsigned",
        "--allow-source",
        &format!("{allowed},{elsewhere}"),
        "--allow-network",
        "127.0.0.1/32",
    ]);
    let get = |name: &str| service.get(&format!("/_/size:16/plain/{allowed}{name}@png"));
    get("once.glb").png(16, 16);
    get("three.glb").png(16, 16);
    assert_eq!(get("round.glb").error(502).0, "source_failed");
    assert_eq!(get("out.glb").error(403).0, "source");
    let (kind, message) = get("private.glb").error(403);
    assert!(kind == "source" && message.contains("private network"), "{message}");
    assert_eq!(get("file.glb").error(403).0, "source");
}

#[test]
fn models_over_http_have_their_files_beside_them() {
    let port = source_server(|path, _| match path {
        "/m/torus-knot.obj" => ok(&model("torus-knot.obj")),
        "/m/torus-knot.mtl" => ok(&model("torus-knot.mtl")),
        _ => b"HTTP/1.1 404 None\r\nContent-Length: 0\r\n\r\n".to_vec(),
    });
    let base = format!("http://127.0.0.1:{port}/m/");
    let service = start(&["--allow-unsigned", "--allow-source", &base, "--allow-network", "127.0.0.1"]);
    let with = service.get(&format!("/_/size:64/plain/{base}torus-knot.obj@png"));
    with.png(64, 64);
    let alone = service.post("/render?size=64&name=torus-knot.obj", &model("torus-knot.obj"));
    assert_ne!(with.body, alone.png(64, 64));
    assert_ne!(with.etag(), alone.etag());
    assert!(alone.headers.contains_key("overcoat-warnings"), "{:?}", alone.headers);
}
