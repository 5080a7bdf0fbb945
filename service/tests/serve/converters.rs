//! Converters of the operator: clients' files of other formats become models, and nothing that a client says changes a converter.
#![cfg(target_os = "linux")]

use super::service::{model, start};

#[test]
fn files_of_registered_formats_are_drawn_for_clients() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("c.toml");
    let text = "[converters.copy]\nextensions = ['copy']\nmagic = ['MAGIC!']\ncommand = ['cat', '{input}']\n";
    std::fs::write(&file, text).unwrap();
    let service = start(&["--converters", file.to_str().unwrap()]);
    let cube = model("rounded-cube.glb");
    let asked = "size=32&samples=1&quality=draft";
    let drawn = service.post(&format!("/render?{asked}&name=m.copy"), &cube);
    if drawn.status != 200 && String::from_utf8_lossy(&drawn.body).contains("there is no sandbox here") {
        eprintln!("SKIPPED, NOTHING WAS TESTED: this kernel has no sandbox");
        return;
    }
    let own = service.post(&format!("/render?{asked}&name=m.glb"), &cube);
    assert_eq!(drawn.png(32, 32), own.png(32, 32));
    let by_type = [("content-type", "model/x-copy")];
    let typed = service.request("POST", &format!("/render?{asked}"), &by_type, &cube);
    assert_eq!(typed.png(32, 32), own.png(32, 32));
    assert_eq!(service.post("/info?name=m.copy", &cube).json()["converter"], "copy");
    // The output of a converter is read like a stranger's.
    let (kind, message) = service.post(&format!("/render?{asked}"), b"MAGIC! and no model").error(422);
    assert_eq!(kind, "model");
    assert!(message.contains("converter copy: it was to write GLB"), "{message}");
    // The option is the operator's.
    assert_eq!(service.post(&format!("/render?{asked}&name=m.copy&converters=x"), &cube).status, 400);
    let without = start(&[]);
    without.post(&format!("/render?{asked}&name=m.copy"), b"MAGIC! and no model").error(415);
}
