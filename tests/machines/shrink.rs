//! Cuts a recipe down to the least that still fails.

use super::recipe::{
    Alpha, EnvironmentRecipe, InstanceRecipe, MaterialRecipe, Pattern, PictureFormat, Recipe, TextureUse,
};
use overcoat::color::ToneCurve;
use overcoat::description::LightDescription;
use overcoat::load::Format;
use overcoat::render::Quality;
use std::ops::Range;

/// A way to make recipes smaller: the candidate of each number, until there are no more.
type Pass = fn(&Recipe, usize) -> Option<Recipe>;

/// Bold cuts first: what they take away need not be tried piece by piece.
const PASSES: [Pass; 10] = [
    fewer_instances,
    fewer_lights,
    plainer_picture,
    fewer_keys,
    fewer_textures,
    fewer_triangles,
    plainer_instances,
    plainer_materials,
    plainer_textures,
    plainer_lights,
];

/// A smaller recipe for which `fails` is still true, and how often it was asked. The result is one of which no single
/// cut fails, unless `steps` were too few.
pub fn shrink(recipe: &Recipe, steps: usize, fails: &mut dyn FnMut(&Recipe) -> bool) -> (Recipe, usize) {
    let mut least = recipe.clone();
    let mut asked = 0;
    loop {
        let before = least.clone();
        for pass in PASSES {
            let mut number = 0;
            while let Some(candidate) = pass(&least, number) {
                let candidate = candidate.compact();
                if candidate == least {
                    number += 1;
                    continue;
                }
                if asked == steps {
                    return (least, asked);
                }
                asked += 1;
                if fails(&candidate) {
                    // The same number is another cut of what is left.
                    least = candidate;
                } else {
                    number += 1;
                }
            }
        }
        if least == before {
            return (least, asked);
        }
    }
}

/// Parts of a list to leave out: all of it, halves, quarters and so on to single items.
fn cuts(length: usize) -> impl Iterator<Item = Range<usize>> {
    let sizes = std::iter::successors((length > 0).then_some(length), |&size| (size > 1).then_some(size / 2));
    sizes.flat_map(move |size| (0..length).step_by(size).map(move |start| start..(start + size).min(length)))
}

/// The candidate of a number among the cuts of several lists.
fn cut_one(
    recipe: &Recipe,
    number: usize,
    lengths: impl Iterator<Item = usize>,
    cut: impl Fn(&mut Recipe, usize, Range<usize>),
) -> Option<Recipe> {
    let all = lengths.enumerate().flat_map(|(list, length)| cuts(length).map(move |range| (list, range)));
    let (list, range) = { all }.nth(number)?;
    let mut candidate = recipe.clone();
    cut(&mut candidate, list, range);
    Some(candidate)
}

fn fewer_instances(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let one = std::iter::once(recipe.instances.len());
    cut_one(recipe, number, one, |r, _, range| drop(r.instances.drain(range)))
}

fn fewer_lights(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let one = std::iter::once(recipe.lights.len());
    cut_one(recipe, number, one, |r, _, range| drop(r.lights.drain(range)))
}

fn fewer_keys(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let lengths = recipe.materials.iter().map(|m| m.keys.len());
    cut_one(recipe, number, lengths, |r, k, range| drop(r.materials[k].keys.drain(range)))
}

fn fewer_textures(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let lengths = recipe.materials.iter().map(|m| m.textures.len());
    cut_one(recipe, number, lengths, |r, k, range| drop(r.materials[k].textures.drain(range)))
}

fn fewer_triangles(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let lengths = recipe.meshes.iter().map(|m| m.triangles.len());
    cut_one(recipe, number, lengths, |r, k, range| drop(r.meshes[k].triangles.drain(range)))
}

/// The candidate of a number among changes to each item of a list.
fn change_one(
    recipe: &Recipe,
    number: usize,
    items: usize,
    changes: &[fn(&mut Recipe, usize)],
) -> Option<Recipe> {
    let (item, change) = (number / changes.len(), number % changes.len());
    (item < items).then(|| {
        let mut candidate = recipe.clone();
        changes[change](&mut candidate, item);
        candidate
    })
}

fn plainer_picture(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let side = |side: u32| side.div_ceil(2).max(4);
    let changes: &[fn(&mut Recipe, usize)] = &[
        |r, _| r.aovs.clear(),
        |r, _| r.environment = EnvironmentRecipe::None,
        |r, _| r.samples = 1,
        |r, _| r.background = "transparent",
        |r, _| r.environment_rotation = 0.0,
        |r, _| r.environment_intensity = 1.0,
        |r, _| r.container = Format::Gltf,
        |r, _| r.anisotropy = 1,
        |r, _| r.quality = Quality::Draft,
        |r, _| r.ground = "none",
        |r, _| r.ground_reflection = 0.0,
        |r, _| r.relief = false,
        |r, _| r.shading = None,
        |r, _| r.exposure = 0.0,
        |r, _| r.tone_curve = ToneCurve::None,
        |r, _| r.camera.near = None,
        |r, _| r.camera.up = None,
        |r, _| r.camera.orthographic_height = None,
        |r, _| r.aovs.truncate(1),
    ];
    match number.checked_sub(changes.len()) {
        None => change_one(recipe, number, 1, changes),
        Some(0) => Some(Recipe { size: recipe.size.map(side), ..recipe.clone() }),
        Some(axis @ 1..3) => {
            let mut candidate = recipe.clone();
            candidate.size[axis - 1] = side(candidate.size[axis - 1]);
            Some(candidate)
        }
        Some(_) => None,
    }
}

fn plainer_instances(recipe: &Recipe, number: usize) -> Option<Recipe> {
    change_one(
        recipe,
        number,
        recipe.instances.len(),
        &[
            |r, k| r.instances[k] = InstanceRecipe::plain(r.instances[k].mesh, r.instances[k].material),
            |r, k| r.instances[k].rotation = InstanceRecipe::plain(0, 0).rotation,
            |r, k| r.instances[k].scale = [1.0; 3],
            |r, k| r.instances[k].translation = [0.0; 3],
            |r, k| {
                let mesh = r.instances[k].mesh;
                r.meshes[mesh].colors.clear();
            },
            |r, k| {
                let mesh = r.instances[k].mesh;
                r.meshes[mesh].uvs[1].clear();
            },
            |r, k| {
                let mesh = r.instances[k].mesh;
                r.meshes[mesh].tangents.clear();
            },
            |r, k| {
                let mesh = r.instances[k].mesh;
                r.meshes[mesh].normals.clear();
                r.meshes[mesh].tangents.clear();
            },
            |r, k| {
                let mesh = r.instances[k].mesh;
                r.meshes[mesh].uvs[0].clear();
                r.meshes[mesh].tangents.clear();
            },
        ],
    )
}

fn plainer_materials(recipe: &Recipe, number: usize) -> Option<Recipe> {
    change_one(
        recipe,
        number,
        recipe.materials.len(),
        &[
            |r, k| {
                let MaterialRecipe { keys, textures, .. } = std::mem::take(&mut r.materials[k]);
                r.materials[k] = MaterialRecipe { keys, textures, ..MaterialRecipe::default() };
            },
            |r, k| r.materials[k].alpha = Alpha::Opaque,
            |r, k| r.materials[k].double_sided = false,
            |r, k| r.materials[k].unlit = false,
            |r, k| r.materials[k].base_color = MaterialRecipe::default().base_color,
            |r, k| r.materials[k].metallic = 0.0,
            |r, k| r.materials[k].roughness = 0.5,
            |r, k| r.materials[k].replaces = false,
        ],
    )
}

fn plainer_textures(recipe: &Recipe, number: usize) -> Option<Recipe> {
    let files: &[fn(&mut Recipe, usize)] = &[
        |r, k| r.textures[k].format = PictureFormat::Png8,
        |r, k| r.textures[k].pattern = Pattern::Checker,
        |r, k| r.textures[k].size = [1, 1],
        |r, k| r.textures[k].size = [4, 4],
    ];
    let uses: &[fn(&mut TextureUse)] = &[
        |u| *u = TextureUse::plain(u.texture),
        |u| (u.offset, u.scale, u.rotation) = ([0.0; 2], [1.0; 2], 0.0),
        |u| u.wrap = TextureUse::plain(0).wrap,
        |u| u.magnification = TextureUse::plain(0).magnification,
        |u| (u.minification, u.mip) = (TextureUse::plain(0).minification, TextureUse::plain(0).mip),
        |u| u.uv_set = 0,
        |u| u.channel = None,
    ];
    match number.checked_sub(recipe.textures.len() * files.len()) {
        None => change_one(recipe, number, recipe.textures.len(), files),
        Some(number) => {
            let mut candidate = recipe.clone();
            let used = candidate.texture_uses_mut().nth(number / uses.len())?;
            uses[number % uses.len()](used);
            Some(candidate)
        }
    }
}

fn plainer_lights(recipe: &Recipe, number: usize) -> Option<Recipe> {
    change_one(
        recipe,
        number,
        recipe.lights.len(),
        &[
            |r, k| match &mut r.lights[k] {
                LightDescription::Directional { color, .. }
                | LightDescription::Point { color, .. }
                | LightDescription::Spot { color, .. }
                | LightDescription::Rect { color, .. }
                | LightDescription::Tube { color, .. } => *color = None,
                _ => {}
            },
            |r, k| match &mut r.lights[k] {
                LightDescription::Directional { min_roughness, .. }
                | LightDescription::Point { min_roughness, .. }
                | LightDescription::Spot { min_roughness, .. } => *min_roughness = None,
                LightDescription::Rect { two_sided, .. } => *two_sided = None,
                _ => {}
            },
            |r, k| match &mut r.lights[k] {
                LightDescription::Point { range, .. } | LightDescription::Spot { range, .. } => *range = None,
                _ => {}
            },
        ],
    )
}
