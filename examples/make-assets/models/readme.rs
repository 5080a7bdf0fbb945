//! The list of the bundled files.

use std::fmt::Write;

use super::model::Model;

/// Description of each model: what it shows.
fn purpose(name: &str) -> &'static str {
    match name {
        "material-ball" => "a coated ball with a groove, an inner ball and a stand: one material at a glance",
        "torus-knot" => "coated carbon fibre with a smooth coat over a normal-mapped base",
        "vase" => "a glazed vase: coat over a rough base, inside and outside",
        "draped-cloth" => "cloth over a ball: a rough surface without a coat",
        "rounded-cube" => "bevelled cube: the coat has its own roughness and normal maps",
        "text-plate" => "raised coated letters on brushed metal",
        "sports-car" => "the picture on the front page: coated flake paint, carbon, glass, lamps",
        _ => "",
    }
}

/// The text of `assets/README.md`.
pub fn text(models: &[Model], textures: &[&str], material_textures: &[&str]) -> String {
    let mut text = String::from(
        "# Bundled assets\n\n\
         Every file here is made by `cargo run --release --example make-assets`, the same bytes on every machine;\n\
         `tests/assets.rs` compares them. Source: `examples/make-assets`. Licence: MIT or Apache-2.0, as the\n\
         project. This list is made by the same program.\n\n\
         ## models\n\n\
         Metres, +Y up; the car looks along +Z. All surfaces are closed.\n\n\
         | file | triangles | materials | what it shows |\n|---|---:|---:|---|\n",
    );
    for model in models {
        let (name, purpose) = (model.name, purpose(model.name));
        let (triangles, materials) = (model.triangle_count(), model.materials.len());
        line(&mut text, format_args!("| models/{name}.glb | {triangles} | {materials} | {purpose} |"));
    }
    text.push_str(
        "\nThe same models in other formats: `torus-knot.obj` with `torus-knot.mtl`, `rounded-cube.stl` (binary),\n\
         `vase.ply` (binary, little endian, vertex colours).\n\n\
         ## textures\n\n\
         Tileable PNG files; the GLB files embed those that they use. Normal maps have +Y up; roughness maps hold\n\
         roughness in green.\n\n",
    );
    for name in textures {
        line(&mut text, format_args!("- models/textures/{name}.png"));
    }
    text.push_str(
        "\n## materials\n\n\
         Material files for any model, written by hand; the program has them built in (`overcoat materials`). Their\n\
         textures are made like the others, small, since they are part of the program:\n\n",
    );
    for name in material_textures {
        line(&mut text, format_args!("- materials/textures/{name}.png"));
    }
    text.push_str(
        "\n## environment\n\n\
         `environment/studio.env`: the built-in studio light, painted and prefiltered by\n\
         `examples/make-assets/environment.rs`; `environment/studio.packed`: the same in fewer bytes;\n\
         `environment/studio.directions`: directions that stand for its light.\n\
         \n## tables\n\n\
         What each engine integrates before it renders: `crates/shading/src/brdf/tables.rs` says what the columns mean, `crates/shading/src/brdf/integrate.rs`\n\
         integrates.\n\n\
         | file | texels | read at |\n|---|---:|---|\n\
         | tables/unity-fgd.bin | 64 x 64 x 3 | square root of N.V, perceptual roughness |\n\
         | tables/filament-dfg.bin | 128 x 128 x 3 | N.V, perceptual roughness |\n\
         | tables/three-dfg.bin | 16 x 16 x 2 | perceptual roughness, N.V |\n\
         | tables/khronos.bin | 64 x 64 x 3 | N.V, perceptual roughness |\n\
         | tables/sheen-albedo.bin | 32 x 32 x 1 | N.V, sheen roughness |\n\
         | tables/ggx-albedo.bin | 32 x 32 x 3 | square root of N.V, perceptual roughness |\n\
         | tables/ltc-ggx.bin | 64 x 64 x 4 | perceptual roughness, square root of 1 - N.V |\n",
    );
    text
}

fn line(text: &mut String, content: std::fmt::Arguments) {
    writeln!(text, "{content}").expect("writing to a string succeeds");
}
