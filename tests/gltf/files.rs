//! Containers, URIs and files on disk.

use crate::common::files::model::{Model, messages, picture};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{
    Context, DirectoryResolver, Format, LoadError, Loaded, NoResolver, Resolver, load_bytes, load_file,
};
use serde_json::json;
use std::path::Path;

/// Visible contents of a scene, for comparing.
fn shown(loaded: &Loaded) -> String {
    format!("{:?}", loaded.scene)
}

fn load_with(text: &str, resolver: &dyn Resolver) -> Result<Loaded, LoadError> {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    load_bytes(text.as_bytes(), None, &Context { resolver, limits: &limits, jobs: &jobs })
}

fn base64(bytes: &[u8]) -> String {
    use base64::Engine;
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// The same model as a container, with data URIs and with files beside it is the same scene.
#[test]
fn every_packaging_gives_the_same_scene() {
    let mut model = Model::textured();
    let expected = shown(&model.load().unwrap());
    let length = model.bytes.len();

    let mut embedded = model.json.clone();
    let uri = format!("data:application/gltf-buffer;base64,{}", base64(&model.bytes));
    embedded["buffers"] = json!([{"byteLength": length, "uri": uri}]);
    assert_eq!(shown(&load_with(&embedded.to_string(), &NoResolver).unwrap()), expected);

    embedded["images"] =
        json!([{"uri": format!("data:image/png;base64,{}", base64(&picture(image::ImageFormat::Png)))}]);
    assert_eq!(shown(&load_with(&embedded.to_string(), &NoResolver).unwrap()), expected);

    // Names are percent-encoded in the file.
    model.files.files.insert("my data.bin".to_owned(), model.bytes.clone());
    model.files.files.insert("100%.png".to_owned(), picture(image::ImageFormat::Png));
    let mut external = model.json.clone();
    external["buffers"] = json!([{"byteLength": length, "uri": "my%20data.bin"}]);
    external["images"] = json!([{"uri": "100%.png"}]);
    assert_eq!(shown(&load_with(&external.to_string(), &model.files).unwrap()), expected);

    // From memory alone, other files are out of reach.
    let error = load_with(&external.to_string(), &NoResolver).unwrap_err().to_string();
    assert_eq!(error, "'my data.bin' cannot be read: this model may not refer to other files");

    // A mark at the beginning and white space are no part of the text.
    let text = format!("\u{feff}\n{embedded}\n");
    assert_eq!(shown(&load_with(&text, &NoResolver).unwrap()), expected);
}

#[test]
fn references_stay_in_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("model");
    std::fs::create_dir_all(inner.join("maps")).unwrap();
    let model = Model::textured();
    let mut json = model.json.clone();
    let length = model.bytes.len();
    std::fs::write(inner.join("data.bin"), &model.bytes).unwrap();
    std::fs::write(inner.join("maps/p.png"), picture(image::ImageFormat::Png)).unwrap();
    std::fs::write(folder.path().join("secret.bin"), &model.bytes).unwrap();
    json["images"] = json!([{"uri": "maps/p.png"}]);
    let mut with_buffer = |uri: &str| {
        json["buffers"] = json!([{"byteLength": length, "uri": uri}]);
        std::fs::write(inner.join("m.gltf"), json.to_string()).unwrap();
        load_file(&inner.join("m.gltf"), &Limits::default(), &Jobs::new(1)).map_err(|e| e.to_string())
    };
    let loaded = with_buffer("data.bin").unwrap();
    assert!(messages(&loaded).is_empty());
    assert_eq!(loaded.scene.textures().len(), 1);
    with_buffer("./maps/../data.bin").unwrap();
    for uri in [
        "../secret.bin",
        "..%2Fsecret.bin",
        "/etc/hostname",
        "file:///etc/hostname",
        "C:\\x",
        "maps/../../secret.bin",
    ] {
        let error = with_buffer(uri).unwrap_err();
        assert!(error.ends_with("leads out of the model's folder"), "{error}");
    }
    assert!(with_buffer("none.bin").unwrap_err().starts_with("'none.bin' cannot be read: "));
    assert!(with_buffer("maps").unwrap_err().ends_with("not a regular file"));
    let resolver = DirectoryResolver::new(&inner);
    assert!(resolver.read("data.bin", length as u64 - 1).is_err());
}

#[test]
fn files_that_cannot_be_models() {
    let folder = tempfile::tempdir().unwrap();
    let error = |path: &Path| load_file(path, &Limits::default(), &Jobs::new(1)).unwrap_err().to_string();
    assert_eq!(error(folder.path()), "cannot be read: it is a folder");
    assert!(error(&folder.path().join("none.glb")).starts_with("cannot be read: "));
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    assert_eq!(error(&write("empty.glb", b"")), "the file is empty");
    assert_eq!(error(&write("words.glb", b"hello")), "glTF: this is neither a GLB container nor JSON");
    for name in ["picture.glb", "picture.png"] {
        let message = error(&write(name, &picture(image::ImageFormat::Png)));
        assert!(message.starts_with("it is a PNG picture; models are read from glTF, OBJ, "), "{message}");
    }
    assert!(error(&write("words.txt", b"hello")).starts_with("the format is not known"));
    // Content beats the extension.
    let path = write("box.obj", &Model::triangle().glb());
    assert_eq!(load_file(&path, &Limits::default(), &Jobs::new(1)).unwrap().scene.triangle_count(), 1);
    let limits = Limits::default().with_input_bytes(100);
    let error = load_file(&path, &limits, &Jobs::new(1)).unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)), "{error}");
}

#[test]
fn a_stated_format_holds() {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    let file = Model::triangle().glb();
    load_bytes(&file, Some(Format::Gltf), &context).unwrap();
    // A container is no STL file, whatever comes of it.
    let other = load_bytes(&file, Some(Format::Stl), &context);
    assert!(other.map_or(true, |loaded| loaded.scene.triangle_count() == 0));
    assert!(
        load_bytes(b"hello", None, &context).unwrap_err().to_string().contains("the format is not known")
    );
}
