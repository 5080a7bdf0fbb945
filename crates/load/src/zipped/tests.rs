use super::*;
use crate::threemf::zip;
use crate::{Loaded, NoResolver, load_bytes};
use overcoat_core::frame::DisplayImage;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_image::output::encode_png;

const OBJ: &[u8] = b"mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

fn within(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
    load_bytes(bytes, None, &Context { resolver: &NoResolver, limits, jobs: &Jobs::new(1) })
}

fn open(parts: &[(&str, &[u8])]) -> Result<Loaded, LoadError> {
    within(&zip(parts, true), &Limits::default())
}

fn red() -> Vec<u8> {
    encode_png(&DisplayImage { width: 2, height: 2, pixels: vec![[255, 0, 0, 255]; 4] }).unwrap()
}

fn textures(loaded: &Loaded) -> usize {
    loaded.scene.textures().len()
}

#[test]
fn a_model_is_read_with_what_it_refers_to() {
    let picture = red();
    let mtl = |name: &str| format!("newmtl a\nmap_Kd {name}\n").into_bytes();
    // Beside it, in a folder beside its own, and by the end of its path.
    for (model, library, texture, name) in [
        ("m.obj", "m.mtl", "t.png", "t.png"),
        ("Source/M.obj", "Source/m.mtl", "Textures/t.png", "../textures/t.png"),
        ("a/m.obj", "a/m.mtl", "b/c/T.png", "C:\\work\\t.png"),
    ] {
        let library = (library, mtl(name));
        let parts = [(model, OBJ), (library.0, &library.1), (texture, &picture), ("__MACOSX/._m.obj", b"x")];
        let loaded = open(&parts).unwrap();
        assert_eq!(
            (loaded.scene.instances().len(), textures(&loaded)),
            (1, 1),
            "{model}: {:?}",
            loaded.warnings
        );
    }
    let buffer: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let gltf = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"uri":"m.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,
        "type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;
    let loaded = open(&[("x/m.gltf", gltf), ("x/m.bin", &buffer)]).unwrap();
    assert_eq!((loaded.scene.instances().len(), loaded.warnings.len()), (1, 0));
}

#[test]
fn of_several_models_one_lies_least_deep_or_none_is_read() {
    let loaded = open(&[("m.obj", OBJ), ("old/m.obj", OBJ), ("old/n.stl", b"solid")]).unwrap();
    let message = "ZIP: 'm.obj' is read; 2 other models in deeper folders are left out";
    assert!(loaded.warnings.iter().any(|w| w.message == message), "{:?}", loaded.warnings);
    let message = open(&[("a.obj", OBJ), ("b.glb", b"glTF"), ("c/d.obj", OBJ)]).unwrap_err().to_string();
    assert_eq!(message, "ZIP: there are several models in it ('a.obj', 'b.glb', 'c/d.obj'): unpack one");
    let many: Vec<String> = (0..9).map(|k| format!("{k}.obj")).collect();
    let many: Vec<(&str, &[u8])> = many.iter().map(|name| (name.as_str(), OBJ)).collect();
    assert!(open(&many).unwrap_err().to_string().contains("'5.obj', 3 more): unpack one"));
}

#[test]
fn nothing_leads_out_of_the_archive_or_deeper_into_it() {
    // Names that leave the archive are none.
    for name in ["../m.obj", "a/../../m.obj", "C:m.obj"] {
        let message = open(&[(name, OBJ)]).unwrap_err().to_string();
        assert!(message.contains("a ZIP archive without 3D model in it"), "{message}");
    }
    let library = b"newmtl a\nmap_Kd ../../etc/passwd\n";
    let loaded = open(&[("m.obj", OBJ), ("m.mtl", library)]).unwrap();
    assert_eq!(textures(&loaded), 0);
    assert!(loaded.warnings.iter().any(|w| w.message.contains("passwd")), "{:?}", loaded.warnings);
    let inner = zip(&[("m.obj", OBJ)], true);
    let message = open(&[("m.obj", &inner)]).unwrap_err().to_string();
    assert!(message.contains("is an archive too"), "{message}");
    assert!(open(&[("m.zip", &inner)]).unwrap_err().to_string().contains("without 3D model"));
    assert!(open(&[("m.obj", OBJ), ("[Content_Types].xml", b"")]).is_err());
}

#[test]
fn sizes_and_ratios_are_limited() {
    let mut large = OBJ.to_vec();
    large.resize(1 << 20, b'\n');
    let bytes = zip(&[("m.obj", &large)], true);
    let with = |limits: Limits| within(&bytes, &limits);
    assert!(with(Limits::default()).is_ok());
    for limits in
        [Limits::default().with_input_bytes((1 << 20) - 1), Limits::default().with_decoded_bytes(1 << 19)]
    {
        assert!(matches!(with(limits), Err(LoadError::Limit(_))));
    }
    // A part that claims to be a thousand times as large.
    let mut bomb = zip(&[("m.obj", OBJ)], true);
    let at = bomb.windows(4).position(|w| w == b"PK\x01\x02").unwrap() + 24;
    bomb[at..at + 4].copy_from_slice(&(1_u32 << 20).to_le_bytes());
    let message = within(&bomb, &Limits::default()).unwrap_err().to_string();
    assert!(message.contains("claims to inflate from"), "{message}");
    for length in 0..bytes.len() {
        assert!(within(&bytes[..length], &Limits::default()).is_err(), "{length}");
    }
}
