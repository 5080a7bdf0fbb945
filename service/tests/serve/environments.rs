//! Environments that requests name.

use crate::service::{model, run, start};
use std::path::Path;

/// A picture of one colour, in the format of Radiance: mantissas and their exponent.
fn write_environment(path: &Path, pixel: [u8; 4]) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n".to_vec();
    bytes.extend(pixel.repeat(16));
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn environments_have_names() {
    let folder = tempfile::tempdir().unwrap();
    let (dawn, dusk) = (folder.path().join("dawn.hdr"), folder.path().join("dusk.hdr"));
    write_environment(&dawn, [20, 60, 255, 129]);
    write_environment(&dusk, [255, 60, 20, 129]);
    let [of_dawn, of_dusk] =
        [("dawn", &dawn), ("dusk", &dusk)].map(|(name, path)| format!("{name}={}", path.display()));
    let args = ["--environment", &of_dawn, "--environment", &of_dusk, "--preset", "blue=size:48/env:dawn"];
    let service = start(&args);
    let cube = model("rounded-cube.glb");
    let of = |query: &str| service.post(&format!("/render?size=48{query}"), &cube);
    let all = ["&env=dawn", "&env=dusk", "&env=studio", "&env=none"].map(of);
    for (k, one) in all.iter().enumerate() {
        one.png(48, 48);
        assert!(all[..k].iter().all(|other| other.body != one.body && other.etag() != one.etag()), "{k}");
    }
    assert_eq!(of("&env=dawn").body, all[0].body);
    assert_eq!(service.post("/render?preset=blue", &cube).body, all[0].body);
    let named = service.get("/formats").json()["environments"].clone();
    assert_eq!(named, serde_json::json!(["dawn", "dusk"]));
    // Files stay the operator's business.
    assert!(!service.log().contains(dawn.to_str().unwrap()));
    for env in [dawn.to_str().unwrap(), "dawn.hdr", "Dawn", "../dawn"] {
        let (kind, message) = of(&format!("&env={env}")).error(400);
        assert!(
            kind == "options" && message.contains("studio, car-studio, sky, none, dawn or dusk"),
            "{message}"
        );
    }
    // Another content is another picture, whatever its name.
    write_environment(&dawn, [20, 255, 20, 129]);
    let anew = start(&args);
    assert_ne!(anew.post("/render?size=48&env=dawn", &cube).etag(), all[0].etag());
    assert_eq!(anew.post("/render?size=48&env=dusk", &cube).etag(), all[1].etag());
}

#[test]
fn mistakes_are_told_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("wrong.hdr");
    std::fs::write(&wrong, "no picture").unwrap();
    let of_wrong = format!("dawn={}", wrong.display());
    for (text, code, what) in [
        ("dawn", 2, "expected NAME=FILE"),
        ("none=/x", 2, "has a meaning"),
        ("dawn=/no/such.hdr", 2, "--environment dawn=/no/such.hdr: "),
        (&of_wrong, 1, "--environment dawn: "),
    ] {
        let output = run(&["serve", "--listen", "127.0.0.1:0", "--workers", "1", "--environment", text]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{text}: {error}");
        assert!(error.contains(what), "{text}: {error}");
    }
}
