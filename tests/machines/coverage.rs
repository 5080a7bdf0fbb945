//! The curated scenes touch everything that the library has a list of.

use super::curated::curated;
use super::files::Files;
use super::keys::KEYS;
use super::recipe::{Alpha, EnvironmentRecipe, GltfSlot, KeyValue, PictureFormat, Recipe};
use super::shot::Shot;
use overcoat::color::ToneCurve;
use overcoat::description::LightDescription;
use overcoat::frame::Aov;
use overcoat::jobs::Jobs;
use overcoat::load::Format;
use overcoat::output::{OutputFormat, OutputOptions, encode};
use overcoat::render::{Quality, Renderer};
use overcoat::scene::{Filter, MipFilter, ShadingModel, Wrap};
use std::collections::BTreeSet;
use std::fmt::Debug;

/// Features that a scene touches, in words.
fn touched(recipe: &Recipe) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut add = |what: &str, value: &dyn Debug| {
        all.insert(format!("{what} {value:?}"));
    };
    add("container", &recipe.container);
    add("given", &recipe.given.is_some());
    add("pose", &recipe.given.as_ref().is_some_and(|given| given.time.is_some()));
    add("output", &recipe.output);
    add("samples", &recipe.samples);
    add("anisotropy", &recipe.anisotropy);
    add("quality", &recipe.quality);
    add("ground", &recipe.ground.split_at(1).0);
    if recipe.ground != "none" {
        add("reflection", &(recipe.ground_reflection > 0.0));
    }
    add("background", &recipe.background.split_at(1).0);
    add("environment", &recipe.environment);
    add("orthographic", &recipe.camera.orthographic_height.is_some());
    add("near", &recipe.camera.near.is_some());
    if recipe.output == OutputFormat::Png {
        add("tone", &recipe.tone_curve);
    }
    if recipe.output == OutputFormat::Exr {
        recipe.aovs.iter().for_each(|aov| add("plane", aov));
    }
    for light in &recipe.lights {
        match light {
            LightDescription::Directional { .. } => add("light", &"directional"),
            LightDescription::Point { .. } => add("light", &"point"),
            LightDescription::Spot { .. } => add("light", &"spot"),
            LightDescription::Rect { .. } => add("light", &"rect"),
            LightDescription::Tube { .. } => add("light", &"tube"),
            other => panic!("a light of a kind that no scene has yet: {other:?}"),
        }
    }
    let names = matches!(recipe.container, Format::Gltf | Format::Glb);
    for material in &recipe.materials {
        match material.alpha {
            Alpha::Opaque => add("alpha", &"opaque"),
            Alpha::Mask(_) => add("alpha", &"mask"),
            Alpha::Blend => add("alpha", &"blend"),
        }
        for (key, value) in &material.keys {
            add("key", key);
            if let (&"model", None, KeyValue::Text(name)) = (key, recipe.shading, value) {
                add("model", &ShadingModel::from_name(name.trim_matches('"')));
            }
            if let KeyValue::Texture(used) = value {
                add("filter of a file", &used.magnification);
                add("wraps of a file", &used.wrap);
            }
        }
        for (slot, used) in material.textures.iter().filter(|_| names) {
            add("slot", slot);
            add("filters", &(used.magnification, used.minification));
            add("mip", &(used.minification, used.mip));
            add("wrap", &used.wrap);
        }
        add("double sided", &material.double_sided);
        add("unlit", &material.unlit);
    }
    for used in recipe.texture_uses() {
        add("texture", &recipe.textures[used.texture].format);
        add("uv set", &used.uv_set);
    }
    for instance in &recipe.instances {
        let mesh = &recipe.meshes[instance.mesh];
        add("mirrored", &instance.is_mirrored());
        add("normals", &!mesh.normals.is_empty());
        add("tangents", &!mesh.tangents.is_empty());
        add("colors", &!mesh.colors.is_empty());
    }
    all
}

/// All features, from the library's own lists where it has them.
fn wanted() -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut add = |what: &str, values: Vec<String>| {
        all.extend(values.into_iter().map(|value| format!("{what} {value}")));
    };
    fn debug<T: Debug>(values: impl IntoIterator<Item = T>) -> Vec<String> {
        values.into_iter().map(|value| format!("{value:?}")).collect()
    }
    let filters = [Filter::Nearest, Filter::Linear];
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    let pairs = || wraps.into_iter().flat_map(|u| wraps.map(|v| [u, v]));
    let mips = [MipFilter::None, MipFilter::Nearest, MipFilter::Linear];
    let pictures = 0..EnvironmentRecipe::PICTURES;
    add("model", debug(ShadingModel::ALL.iter().map(Some)));
    add("key", debug(KEYS.iter().map(|(key, _)| key)));
    add("container", debug(super::files::WRITTEN));
    add("output", debug(super::invent::OUTPUTS));
    add("tone", debug(ToneCurve::ALL));
    add("plane", debug(Aov::ALL));
    add("samples", debug([1, 4, 8, 16]));
    add("anisotropy", debug([1, 2, 4, 16]));
    add("quality", debug(Quality::ALL));
    add("ground", debug(["n", "s", "#"]));
    add("reflection", debug([false, true]));
    add("background", debug(["t", "e", "#"]));
    add("environment", debug([EnvironmentRecipe::None, EnvironmentRecipe::Studio]));
    add("environment", debug(pictures.clone().map(EnvironmentRecipe::Hdr)));
    add("environment", debug(pictures.map(EnvironmentRecipe::Exr)));
    add("light", debug(["directional", "point", "spot", "rect", "tube"]));
    add("alpha", debug(["opaque", "mask", "blend"]));
    add("slot", debug(GltfSlot::ALL));
    add("texture", debug(PictureFormat::ALL));
    add("filters", debug(filters.into_iter().flat_map(|mag| filters.map(|min| (mag, min)))));
    add("mip", debug(filters.into_iter().flat_map(|min| mips.map(|mip| (min, mip)))));
    add("wrap", debug(pairs()));
    add("filter of a file", debug(filters));
    add("wraps of a file", debug(wraps.map(|wrap| [wrap; 2])));
    add("uv set", debug([0, 1]));
    for what in [
        "given",
        "pose",
        "orthographic",
        "near",
        "mirrored",
        "normals",
        "tangents",
        "colors",
        "double sided",
        "unlit",
    ] {
        add(what, debug([false, true]));
    }
    all
}

#[test]
fn curated_scenes_cover_everything() {
    let all = curated();
    assert!(all.len() >= 48, "{}", all.len());
    let names: BTreeSet<&String> = all.iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), all.len(), "a name stands twice");
    let covered: BTreeSet<String> = all.iter().flat_map(|(_, recipe)| touched(recipe)).collect();
    let missing: Vec<String> = wanted().difference(&covered).cloned().collect();
    assert!(missing.is_empty(), "no scene has\n{}", missing.join("\n"));
    for (name, recipe) in &all {
        assert!(recipe.size.iter().all(|&side| side <= 64), "{name} is large for an emulated machine");
    }
}

/// Scenes that show nothing, or all the same, test nothing.
#[test]
fn curated_scenes_show_something() {
    let mut hashes = BTreeSet::new();
    let jobs = Jobs::new(1);
    let mut renderer = Renderer::new(1);
    for (name, recipe) in curated() {
        let files = Files::of(&recipe).unwrap();
        let shot = Shot::load(&files, &recipe, &jobs, None).unwrap_or_else(|e| panic!("{name}: {e}"));
        let rendered = renderer.render(&shot.scene, &shot.camera, &shot.options).unwrap();
        let pixels = &rendered.frame.pixels;
        let covered = rendered.stats.fragments as usize;
        assert!(covered * 5 > pixels.len(), "{name}: {covered} fragments");
        assert!(pixels.as_flattened().iter().all(|v| v.is_finite()), "{name}");
        let lit = pixels.iter().filter(|p| p[0].max(p[1]).max(p[2]) > 0.01).count();
        assert!(lit * 8 > pixels.len(), "{name}: {lit} pixels are not black");
        let output = OutputOptions::default().with_display(shot.display);
        let file = encode(&rendered.frame, recipe.output, &output).unwrap();
        assert!(hashes.insert(file), "{name} shows what another scene does");
    }
}
