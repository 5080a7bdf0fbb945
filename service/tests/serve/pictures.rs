//! Pictures: what is asked for is what comes.

use crate::service::{PROGRAM, form, model, model_path, run, start, start_with, zip};
use overcoat::description::{Description, Machine};
use overcoat::limits::Limits;
use overcoat::load::Format;
use overcoat::output::{OutputFormat, OutputOptions, encode};
use overcoat::render::Renderer;
use std::path::Path;

/// A glTF file with a triangle, whose buffer and texture are files beside it.
fn gltf() -> (Vec<u8>, Vec<u8>) {
    let mut buffer = Vec::new();
    for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0] {
        buffer.extend(value.to_le_bytes());
    }
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"doubleSided":true,"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicFactor":0}}],
        "textures":[{"source":0}],"images":[{"uri":"textures/color.png"}],
        "buffers":[{"uri":"tri.bin","byteLength":60}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
            {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]}"#;
    (json.as_bytes().to_vec(), buffer)
}

#[test]
fn a_form_is_a_model_with_its_files() {
    let service = start(&[]);
    let (json, buffer) = gltf();
    let textures = [model("textures/checker.png"), model("textures/carbon-color.png")];
    let post = |parts: &[(&str, Option<&str>, &[u8])]| {
        let (kind, body) = form(parts);
        service.request("POST", "/render?size=64&background=white", &[("Content-Type", &kind)], &body)
    };
    let of = |texture: &[u8], name: &str| {
        post(&[
            ("file", Some("tri.bin"), &buffer),
            ("file", Some(name), texture),
            ("model", Some("t.gltf"), &json),
        ])
    };
    let checker = of(&textures[0], "textures/color.png");
    checker.png(64, 64);
    assert!(!checker.headers.contains_key("overcoat-warnings"), "{:?}", checker.headers);
    let carbon = of(&textures[1], "textures/color.png");
    assert_ne!(carbon.png(64, 64), checker.body);
    assert_ne!(carbon.etag(), checker.etag());
    // Browsers do not tell folders.
    assert_eq!(of(&textures[0], "color.png").png(64, 64), checker.body);
    // Without its texture it is a picture with a warning, without its buffer it is none.
    let bare = post(&[("a", Some("tri.bin"), &buffer), ("b", Some("t.gltf"), &json), ("size", None, b"32")]);
    bare.png(32, 32);
    assert!(bare.headers["overcoat-warnings"].contains("color.png"), "{:?}", bare.headers);
    assert_eq!(post(&[("model", Some("t.gltf"), &json)]).error(422).0, "model");
    assert_eq!(
        post(&[("a", Some("tri.bin"), &buffer), ("b", Some("x.png"), &textures[0])]).error(400).0,
        "options"
    );
    let (kind, body) = form(&[("model", Some("t.gltf"), &json), ("file", Some("tri.bin"), &buffer)]);
    let info = service.request("POST", "/info", &[("Content-Type", &kind)], &body).json();
    assert_eq!(info["triangles"], 1);
}

#[test]
fn pictures_are_those_of_the_command_line() {
    let service = start(&[]);
    for (name, query) in [
        ("rounded-cube.stl", "size=96x64&view=front&quality=good"),
        ("vase.ply", "size=64&background=102030&format=webp"),
        ("torus-knot.obj", "size=64&name=x.obj&samples=4"),
        ("rounded-cube.glb", "size=64&format=exr&aov=depth"),
    ] {
        let served = service.post(&format!("/render?{query}"), &model(name));
        assert_eq!(served.status, 200, "{name}: {}", String::from_utf8_lossy(&served.body));
        // The same by a batch, whose pictures are those of the command line by its own tests.
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in");
        std::fs::create_dir(&input).unwrap();
        std::fs::copy(model_path(name), input.join(name)).unwrap();
        let mut row = serde_json::json!({ "model": input.join(name).to_str().unwrap(), "out": "picture" });
        for pair in query.split('&') {
            let (key, text) = pair.split_once('=').unwrap();
            row[key] = match key {
                "name" => continue,
                "samples" => 4.into(),
                "size" => {
                    let (width, height) = text.split_once('x').unwrap_or((text, text));
                    serde_json::json!([width.parse::<u64>().unwrap(), height.parse::<u64>().unwrap()])
                }
                _ => text.into(),
            };
        }
        let manifest = folder.path().join("list.jsonl");
        std::fs::write(&manifest, row.to_string()).unwrap();
        let out = folder.path().join("out");
        let output = std::process::Command::new(PROGRAM)
            .args(["batch", manifest.to_str().unwrap(), "-o", out.to_str().unwrap(), "--workers", "1"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(std::fs::read(out.join("picture")).unwrap() == served.body, "{name}: not the same bytes");
    }
}

#[test]
fn an_archive_is_a_model_with_its_files() {
    let service = start(&[]);
    let (json, buffer) = gltf();
    let texture = model("textures/checker.png");
    let query = "/render?size=64&background=white";
    let files: [(&str, &[u8]); 3] =
        [("t/t.gltf", &json), ("t/tri.bin", &buffer), ("t/textures/color.png", &texture)];
    let archive = zip(&files);
    let (kind, body) = form(&[
        ("model", Some("t.gltf"), &json),
        ("f", Some("tri.bin"), &buffer),
        ("f", Some("textures/color.png"), &texture),
    ]);
    let alone = service.request("POST", query, &[("Content-Type", &kind)], &body);
    // By its content, whatever it is called, and as a file of a form.
    assert_eq!(service.post(query, &archive).png(64, 64), alone.png(64, 64));
    let headers = [("Content-Disposition", "attachment; filename=\"my car.zip\"")];
    assert_eq!(service.request("POST", query, &headers, &archive).png(64, 64), alone.body);
    let (kind, body) = form(&[("notes", Some("read me.txt"), b"x"), ("file", Some("car.zip"), &archive)]);
    assert_eq!(service.request("POST", query, &[("Content-Type", &kind)], &body).png(64, 64), alone.body);
    assert_eq!(service.post("/info", &archive).json()["triangles"], 1);
    for (files, status, what) in [
        (&[("a.gltf", &json[..]), ("b.gltf", &json)][..], 422, "several models"),
        (&[("a.txt", &b"x"[..])], 422, "without 3D model"),
    ] {
        let (_, message) = service.post(query, &zip(files)).error(status);
        assert!(message.contains(what), "{message}");
    }
    // Programs that make archives make none like this.
    let mut outside = zip(&[("xx/yy/t.gltf", &json)]);
    while let Some(at) = outside.windows(6).position(|six| six == b"xx/yy/") {
        outside[at..at + 6].copy_from_slice(b"../../");
    }
    assert!(service.post(query, &outside).error(422).1.contains("without 3D model"));
    // A part that claims to be far larger than its bytes can be.
    let mut bomb = archive.clone();
    let at = bomb.windows(4).position(|w| w == b"PK\x01\x02").unwrap() + 24;
    bomb[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(service.post(query, &bomb).status, 422);
    // Nothing of a form leads out of it, and no name stands for two files.
    let twice =
        form(&[("m", Some("a.obj"), b"v"), ("f", Some("x.png"), b"1"), ("f", Some("../x.png"), b"2")]);
    let answer = service.request("POST", query, &[("Content-Type", &twice.0)], &twice.1);
    assert!(answer.error(400).1.contains("two files that are called 'x.png'"));
    assert_eq!(service.metric("overcoat_workers_died_total"), 0.0);
}

/// Whoever asks for nothing but a size gets the picture of the library, the program and the bindings.
#[test]
fn the_default_picture_is_that_of_every_door() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/default-picture.txt"))
        .unwrap();
    let hash = text.split_whitespace().nth(2).unwrap();
    let served = start(&[]).post("/render?size=96x64", &model("rounded-cube.glb"));
    let mut description = Description::default();
    (description.model, description.size) = (Some(model_path("rounded-cube.glb")), Some([96, 64]));
    let mut renderer = Renderer::new(1);
    let picture = description.picture(Machine::default(), &Limits::default(), renderer.jobs()).unwrap();
    let frame = renderer.render(&picture.scene, &picture.camera, &picture.options).unwrap().frame;
    assert_eq!(frame.frame_hash(), hash);
    let options = OutputOptions::default().with_display(picture.display);
    assert!(encode(&frame, OutputFormat::Png, &options).unwrap() == served.body, "not the same bytes");
}

#[test]
fn planes_are_pictures() {
    let service = start(&[]);
    let cube = model("rounded-cube.glb");
    let plain = service.post("/render?size=32", &cube);
    let normal = service.post("/render?size=32&aov=normal", &cube);
    assert_ne!(normal.png(32, 32), plain.png(32, 32));
    assert_eq!(service.post("/render?size=32&aov=normal,depth", &cube).error(400).0, "options");
}

#[test]
fn clients_ask_for_what_they_have_not() {
    let folder = model_path("");
    let service =
        start(&["--allow-unsigned", "--local", folder.to_str().unwrap(), "--cache-control", "max-age=7"]);
    let path = "/_/size:32/plain/local://rounded-cube.glb@png";
    let whole = service.get(path);
    whole.png(32, 32);
    assert_eq!(
        (whole.headers["cache-control"].as_str(), whole.headers["accept-ranges"].as_str()),
        ("max-age=7", "bytes")
    );
    let part = service.request("GET", path, &[("Range", "bytes=4-9"), ("If-Range", whole.etag())], &[]);
    assert_eq!((part.status, &part.body[..]), (206, &whole.body[4..10]));
    assert_eq!(part.headers["content-range"], format!("bytes 4-9/{}", whole.body.len()));
    let other = service.request("GET", path, &[("Range", "bytes=4-9"), ("If-Range", "\"x\"")], &[]);
    assert_eq!((other.status, other.body.len()), (200, whole.body.len()));
    let head = service.request("HEAD", path, &[], &[]);
    assert_eq!((head.status, head.etag(), head.body.len()), (200, whole.etag(), 0));
    assert_eq!(head.headers["content-length"], whole.body.len().to_string());
    for (tag, status) in [(whole.etag(), 304), ("\"x\"", 200), (&format!("\"y\", W/{}", whole.etag()), 304)] {
        let answer = service.request("GET", path, &[("If-None-Match", tag)], &[]);
        assert_eq!((answer.status, answer.etag()), (status, whole.etag()), "{tag}");
    }
    // A tag is of the content: of another size it is another one, of the same model by another way it is the same.
    assert_ne!(service.get(&path.replace("32", "33")).etag(), whole.etag());
    assert_eq!(
        service.post("/render?size=32x32&format=png&name=a.glb", &model("rounded-cube.glb")).etag(),
        whole.etag()
    );
}

#[test]
fn previews_of_imaginary_are_made() {
    let service = start(&["--max-size", "256"]);
    let operations = "%5B%7B%22operation%22%3A%22fit%22%2C%22params%22%3A%7B%22width%22%3A1024%2C%22height%22%3A512%2C%22type%22%3A%22png%22%7D%7D%5D";
    let answer = service.post(&format!("/pipeline?operations={operations}"), &model("rounded-cube.stl"));
    answer.png(256, 128);
    assert_eq!(
        (answer.headers["image-width"].as_str(), answer.headers["image-height"].as_str()),
        ("256", "128")
    );
    assert_eq!(service.post("/pipeline", &model("rounded-cube.stl")).error(400).0, "options");
}

#[test]
fn the_page_loads_and_allows_nothing_else() {
    let service = start(&[]);
    let page = service.get("/");
    assert_eq!(page.status, 200);
    let text = String::from_utf8(page.body).unwrap();
    assert!(text.contains("<option>filament</option>") && !text.contains("SHADING"));
    let policy = &page.headers["content-security-policy"];
    assert!(policy.starts_with("default-src 'none'; script-src 'sha256-"), "{policy}");
    assert_eq!(page.headers["x-content-type-options"], "nosniff");
}

#[test]
fn what_a_service_can_do_is_told() {
    let service = start(&["--preset", "thumb=size:40/view:front"]);
    let formats = service.get("/formats").json();
    assert_eq!(formats["read"].as_array().unwrap().len(), Format::ALL.len());
    assert_eq!(formats["presets"][0], "thumb");
    assert_eq!(service.get("/health").json()["status"], "ok");
    assert_eq!(service.get("/ready").json()["status"], "ready");
    let cube = model("rounded-cube.glb");
    service.post("/render?preset=thumb", &cube).png(40, 40);
    let info = service
        .request("POST", "/info", &[("Content-Disposition", "attachment; filename=\"a.glb\"")], &cube)
        .json();
    assert_eq!((&info["format"], &info["triangles"]), (&"glb".into(), &2028.into()));
    let metrics = String::from_utf8(service.get("/metrics").body).unwrap();
    for name in [
        "overcoat_requests_total{route=\"render\",status=\"200\"} 1",
        "overcoat_render_seconds_count{stage=\"load\"} 1",
        "overcoat_queue_length 0",
        "overcoat_workers_started_total 1",
        "# EOF",
    ] {
        assert!(metrics.contains(name), "{name} is not in {metrics}");
    }
    let id = service.request("GET", "/health", &[("X-Request-Id", "abc-1")], &[]);
    assert_eq!(id.headers["x-request-id"], "abc-1");
    let line = service.log().lines().find(|line| line.contains("\"render\"")).unwrap().to_owned();
    let line: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!((&line["status"], &line["result"]), (&200.into(), &"rendered".into()));
    assert!(
        line["key"].as_str().unwrap().len() == 64 && line["total_ms"].is_number() && line["id"].is_string()
    );
}

#[test]
fn signed_paths_can_be_all_there_is() {
    let service = start(&["--signed-only", "--key", "aa", "--salt", "bb"]);
    for path in ["/", "/render"] {
        assert_eq!(service.get(path).status, 404, "{path}");
        assert_eq!(service.post(path, b"x").status, 404, "{path}");
    }
    assert_eq!(service.get("/health").status, 200);
}

#[test]
fn configurations_are_read_and_their_mistakes_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("overcoat.toml");
    let path = file.to_str().unwrap();
    std::fs::write(&file, "max_size = 48\nqueue = 3\nquality = 'draft'\n[preset]\nthumb = 'size:20'\n[limit]\ntriangles = 5000\n").unwrap();
    let service = start_with(Path::new(PROGRAM), &["--config", path, "--queue", "5"], &[]);
    let cube = model("rounded-cube.glb");
    assert!(service.post("/render?size=49", &cube).error(400).1.contains("1 to 48"));
    service.post("/render?preset=thumb", &cube).png(20, 20);
    assert_eq!(service.post("/render?size=8", &model("sports-car.glb")).error(422).0, "limit");
    for (text, what) in [
        ("max_sizes = 3", "max_sizes: there is no such key; did you mean max_size?"),
        ("max_size = 'x'", "max-size"),
        ("a = = 1", "line 1"),
        ("preset = ['x']", "expected NAME=OPTIONS"),
        ("preset = ['x=size:5000']", "1 to 2048"),
        ("key = ['abc']", "--key and --salt come in pairs"),
        ("allow_network = ['x']", "ADDRESS/BITS"),
    ] {
        std::fs::write(&file, text).unwrap();
        let output = run(&["serve", "--config", path]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}: {error}");
        assert!(error.contains(what) && error.trim().lines().count() == 1, "{text}: {error}");
    }
}
