//! Scene files and material files: they come from users, and their textures from strangers.

use super::attack::Attack;
use super::attack::Must::{Draw, Exceed, Fail, Misuse};

pub fn attacks() -> Vec<Attack> {
    vec![
        Attack::scene("scene-nesting", "a stack overflow by nested lists", "x.json", "[".repeat(100_000), Fail("x.json")),
        Attack::scene("scene-nested-note", "a stack overflow in what is skipped", "x.json", format!("{{\"note\":{}{}}}", "[".repeat(100_000), "]".repeat(100_000)), Fail("recursion limit")),
        Attack::scene("scene-nested-toml", "a stack overflow by nested lists", "x.toml", format!("note = {}", "[".repeat(100_000)), Fail("x.toml")),
        Attack::scene("scene-dotted-toml", "a stack overflow by dotted keys", "x.toml", format!("note{} = 1", ".a".repeat(100_000)), Fail("x.toml")),
        Attack::scene("scene-two-megabytes", "memory for a file of text", "x.json", format!("{{\"note\":\"{}\"}}", "x".repeat(2 << 20)), Fail("x.json")),
        Attack::scene("scene-size-maximum", "an allocation of the picture", "x.json", r#"{"model":"good.obj","size":[18446744073709551615,18446744073709551615]}"#, Exceed("output_side")),
        Attack::scene("scene-size-product", "an allocation that is within each side", "x.json", r#"{"model":"good.obj","size":[4096,4096]}"#, Exceed("output_pixels")),
        Attack::scene("scene-size-zero", "a division by the height", "x.json", r#"{"model":"good.obj","size":[64,0]}"#, Misuse("at least one pixel")),
        Attack::scene("scene-size-negative", "a size that wraps", "x.json", r#"{"model":"good.obj","size":[-1,64]}"#, Fail("x.json")),
        Attack::scene("scene-samples", "memory for samples", "x.json", r#"{"model":"good.obj","samples":4294967295}"#, Fail("samples")),
        Attack::scene("scene-eye-infinite", "a camera at infinity", "x.json", r#"{"model":"good.obj","camera":{"eye":[1e39,0,0]}}"#, Misuse("camera")),
        Attack::scene("scene-eye-is-target", "a direction without a length", "x.json", r#"{"model":"good.obj","camera":{"eye":[1,2,3],"target":[1,2,3]}}"#, Misuse("camera")),
        Attack::scene("scene-up-is-forward", "a camera without a side", "x.json", r#"{"model":"good.obj","camera":{"eye":[0,5,0],"target":[0,0,0],"up":[0,1,0]}}"#, Misuse("camera")),
        Attack::scene("scene-field-of-view", "the tangent of a right angle", "x.json", r#"{"model":"good.obj","camera":{"eye":[0,0,5],"fovYDeg":180}}"#, Misuse("field")),
        Attack::scene("scene-lights", "work for a hundred thousand lights", "x.toml", "[[light]]\ntype='point'\nposition=[0,0,0]\nintensity=1\n".repeat(18_000), Exceed("lights")),
        Attack::scene("scene-light-nan", "light that is no number", "x.toml", "model = 'good.obj'\n[[light]]\ntype = 'point'\nposition = [nan, 0, 0]\nintensity = inf\n", Fail("light 0")),
        Attack::scene("scene-tube-of-nothing", "a tube without a length", "x.toml", "model = 'good.obj'\n[[light]]\ntype = 'tube'\nfrom = [0,0,0]\nto = [0,0,0]\nradius = 0\nintensity = 1\n", Fail("light 0")),
        Attack::scene("scene-exposure", "two to the power of a million", "x.json", r#"{"model":"good.obj","exposure":1000000}"#, Misuse("exposure")),
        Attack::scene("scene-model-is-itself", "a file that describes itself", "x.json", r#"{"model":"x.json"}"#, Fail("x.json")),
        Attack::scene("scene-model-is-device", "a file without an end", "x.json", r#"{"model":"/dev/zero"}"#, Fail("not a regular file")),
        Attack::scene("scene-environment-is-folder", "reading a folder", "x.json", r#"{"model":"good.obj","env":"."}"#, Fail("folder")),
        Attack::scene("scene-unknown-key", "a key that is silently ignored", "x.json", r#"{"modle":"good.obj"}"#, Fail("modle")),
        Attack::material("material-nesting", "a stack overflow by nested lists", format!("base_color = {}", "[".repeat(100_000)), Fail("x.toml")),
        Attack::material("material-tables", "a stack overflow by nested tables", format!("base_color = {}", "{a=".repeat(50_000)), Fail("x.toml")),
        Attack::material("material-huge", "memory for a file of text", format!("description = \"{}\"", "x".repeat(32 << 20)), Exceed("input_bytes")),
        Attack::material("material-out-of-range", "a factor that breaks the shading", "roughness = 1e30\n", Fail("roughness")),
        Attack::material("material-nan", "a factor that is no number", "metallic = nan\n", Fail("metallic")),
        Attack::material("material-unknown-key", "a key that is silently ignored", "rougness = 0.5\n", Fail("rougness")),
        Attack::material("material-texture-outside", "a texture of another folder", "base_color_texture = \"../secret.png\"\n", Fail("leads out of the model's folder")),
        Attack::material("material-texture-absolute", "a texture from anywhere", "base_color_texture = \"/etc/passwd\"\n", Fail("leads out of the model's folder")),
        Attack::material("material-texture-device", "a texture without an end", "base_color_texture = \"/dev/zero\"\n", Fail("leads out of the model's folder")),
        Attack::material("material-not-text", "text that is none", vec![0xff; 64], Fail("x.toml")),
        Attack::material("material-empty", "a file of nothing", "", Draw),
    ]
}
