//! More than a hundred files that attack the program, each through everything that a real one goes through: reading,
//! checking, drawing, encoding. What ends one is a count, never a clock, so it ends the same way on every machine.
//!
//! One more attack is one more entry in a list: a name, what it tries, the bytes, what must happen.

mod accessors;
mod attack;
mod descriptions;
mod documents;
mod graphs;
mod meshes;
mod paths;
mod pictures;

use crate::common::files::model;
use attack::{Ask, Attack, Must};
use overcoat::description::{Description, EnvironmentChoice, Machine, MaterialSource};
use overcoat::limits::Limits;
use overcoat::output::{OutputFormat, OutputOptions, encode};
use overcoat::render::{Quality, Renderer};
use overcoat_worker::failure::Failure;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// A model with nothing wrong, for attacks by everything else.
const GOOD: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

/// So small that every attack is over within a second or two, reaching a limit or not.
fn limits() -> Limits {
    Limits::default()
        .with_input_bytes(64 << 20)
        .with_decoded_bytes(128 << 20)
        .with_triangles(1 << 20)
        .with_vertices(3 << 20)
        .with_nodes(1 << 16)
        .with_depth(128)
        .with_textures(256)
        .with_texture_pixels(1 << 22)
        .with_total_texture_pixels(1 << 23)
        .with_lights(64)
        .with_output_side(4096)
        .with_output_pixels(1 << 20)
        .with_fragments(1 << 20)
        .with_blocks(1 << 14)
        .with_shading(Limits::default().shading)
        .with_blend_entries(1 << 16)
        .with_frame_bytes(32 << 20)
        .with_frames(16)
}

/// Outcome of an attack: the warnings beside a picture, or the reason why there is none.
fn carry_out(attack: &Attack, folder: &Path) -> Result<Vec<String>, Failure> {
    let good = folder.join("good.obj");
    let model = |name: &str| if Path::new(name).is_absolute() { name.into() } else { folder.join(name) };
    let mut description = match attack.ask {
        Ask::Model(name) => Description { model: Some(model(name)), ..Description::default() },
        Ask::Environment(name) => Description {
            model: Some(good.clone()),
            env: Some(EnvironmentChoice::File(folder.join(name))),
            ..Description::default()
        },
        Ask::Material(name) => Description {
            model: Some(good.clone()),
            material: Some(MaterialSource::File(folder.join(name))),
            ..Description::default()
        },
        Ask::Scene(name) => Description::open(&folder.join(name))?,
    };
    description.model.get_or_insert(good);
    description.size.get_or_insert([64, 64]);
    // Depth maps are more work than these limits allow any picture.
    description.quality.get_or_insert(Quality::Draft);
    let limits = limits();
    let mut renderer = Renderer::new(2);
    let picture = description.picture(Machine::default(), &limits, renderer.jobs())?;
    let mut warnings: Vec<String> = picture.warnings.iter().map(ToString::to_string).collect();
    let rendered = renderer
        .render(&picture.scene, &picture.camera, &picture.options)
        .map_err(|e| Failure::render(&e))?;
    if rendered.stats.fragments == 0 {
        warnings.push("nothing to see".to_owned());
    }
    assert!(rendered.frame.pixels.iter().flatten().all(|v| v.is_finite()), "a pixel is not finite");
    let options = OutputOptions::default().with_display(picture.display);
    encode(&rendered.frame, OutputFormat::Png, &options).expect("frames can be encoded");
    Ok(warnings)
}

/// Fault of the outcome, if it has any.
fn judge(must: Must, outcome: &Result<Vec<String>, Failure>) -> Option<String> {
    // Messages are for a line of a terminal.
    let texts: Vec<String> = match outcome {
        Ok(warnings) => warnings.clone(),
        Err(failure) => vec![failure.to_string()],
    };
    if let Some(bad) = texts.iter().find(|t| t.len() > 5000 || t.chars().any(char::is_control)) {
        return Some(format!(
            "a message of {} bytes: {}",
            bad.len(),
            bad.chars().take(200).collect::<String>()
        ));
    }
    let code = match must {
        Must::Draw | Must::Warn(_) => 0,
        Must::Fail(_) => 1,
        Must::Misuse(_) => 2,
        Must::Exceed(_) => 3,
    };
    let found = outcome.as_ref().map_or_else(Failure::exit_code, |_| 0);
    let said = match must {
        Must::Draw => texts.is_empty(),
        Must::Fail(part) | Must::Misuse(part) | Must::Exceed(part) | Must::Warn(part) => {
            texts.iter().any(|text| text.contains(part))
        }
    };
    (found != code || !said).then(|| format!("exit code {found}, {texts:?} in place of {must:?}"))
}

#[test]
fn every_attack_ends_as_it_must() {
    let attacks = attack::all();
    let only = std::env::var("OVERCOAT_ATTACK").ok();
    let mut wrong = Vec::new();
    for attack in attacks.iter().filter(|attack| only.as_deref().is_none_or(|only| attack.name == only)) {
        // A parent for what is tried beside the folder.
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("in");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("good.obj"), GOOD).unwrap();
        for (name, bytes) in &attack.files {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
        if let Some(prepare) = attack.prepare {
            prepare(&folder);
        }
        let judged = match catch_unwind(AssertUnwindSafe(|| carry_out(attack, &folder))) {
            Ok(outcome) => judge(attack.must, &outcome),
            Err(_) => Some("it panicked".to_owned()),
        };
        if let Some(judged) = judged {
            wrong.push(format!("{} ({}): {judged}", attack.name, attack.tries));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), attacks.len(), wrong.join("\n"));
}

#[test]
fn attacks_are_many_and_have_names() {
    let attacks = attack::all();
    assert!(attacks.len() >= 100, "{}", attacks.len());
    let names: BTreeSet<&str> = attacks.iter().map(|attack| attack.name).collect();
    assert_eq!(names.len(), attacks.len(), "two attacks have one name");
}
