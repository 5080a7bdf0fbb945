//! `overcoat guide`: one page for programs, and the vocabulary of reports and messages, made of the tables and types that speak it.

use super::failure::Failure;
use super::report;
use clap::Args;
use overcoat_core::frame::Aov;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::{Description, DescriptionOption, Machine};
use overcoat_image::output::OutputFormat;
use overcoat_load::{Context, LoadOptions, Loaded, NoResolver, Warning, load_named_bytes};
use overcoat_render::{Rendered, Renderer};
use overcoat_worker::Contents;
use overcoat_worker::annotation_report::annotations;
use overcoat_worker::codes::{self, Code};
use overcoat_worker::converters::{Registry, config};
use overcoat_worker::diagnosis::Diagnosis;
use overcoat_worker::message::WarningJson;
use overcoat_worker::model_source::ModelSource;
use overcoat_worker::picture_format::PictureFormat;
use overcoat_worker::picture_task::PictureTask;
use overcoat_worker::render_report::{RenderReport, Told};
use overcoat_worker::report::{Stages, Versions};
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

/// A converter, so that the keys of its entry are known.
fn sample_registry() -> Registry {
    let text = "[converters.x]\nextensions = ['x']\ncommand = ['x', '{input}']";
    let mut registry = Registry::default();
    registry.add(config::parse(text).unwrap_or_default());
    registry
}

/// The page.
const GUIDE: &str = include_str!("guide.md");

/// A model of which reports are made, to learn their keys from: it has something of everything.
const SAMPLE: &str = include_str!("guide_sample.gltf");

/// `overcoat guide`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat guide
  overcoat guide --keys")]
pub struct GuideArgs {
    /// Print the vocabulary as JSON instead: options, codes, exit codes, keys of reports
    #[arg(long)]
    keys: bool,
}

/// The vocabulary. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Vocabulary {
    options: Vec<OptionEntry>,
    /// Codes of warnings, findings and errors.
    codes: &'static [Code],
    exit_codes: BTreeMap<u8, &'static str>,
    /// Keys by commands with `--json` and by kinds of lines; `a.b` is in `a`, `a[]` an element of it.
    reports: BTreeMap<&'static str, BTreeSet<String>>,
    warnings: Vec<String>,
    versions: Versions,
}

/// An option of pictures.
#[derive(Debug, Serialize)]
struct OptionEntry {
    /// In scene files; of the table `camera` with that before it.
    key: String,
    /// On the command line.
    argument: Option<String>,
    /// In requests to the service and to `overcoat mcp`.
    request: Option<&'static str>,
    about: String,
    /// Values that have names.
    values: Vec<&'static str>,
}

/// Prints the page, or the vocabulary.
///
/// # Errors
/// [`Failure`] if standard output cannot be written.
pub fn run(args: &GuideArgs) -> Result<(), Failure> {
    if !args.keys {
        return report::print(GUIDE);
    }
    report::print_json(&Vocabulary {
        options: DescriptionOption::all().map(entry).collect(),
        codes: codes::ALL,
        exit_codes: Failure::exit_codes().collect(),
        reports: reports()?,
        warnings: Vec::new(),
        versions: Versions::default(),
    })
}

fn entry(option: DescriptionOption) -> OptionEntry {
    OptionEntry {
        key: format!("{}{}", if option.is_of_camera() { "camera." } else { "" }, option.key()),
        argument: option.argument().map(|argument| format!("--{}", argument.long)),
        request: option.request_name(),
        about: option.help().into_owned(),
        values: option.names(),
    }
}

/// Keys of reports, taken from reports on the sample.
fn reports() -> Result<BTreeMap<&'static str, BTreeSet<String>>, Failure> {
    let (limits, mut renderer) = (Limits::default(), Renderer::new(1));
    let path = Path::new("sample.gltf");
    let options = LoadOptions::default();
    let jobs = Jobs::new(1);
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    let contents =
        Contents::json_of_bytes(SAMPLE.as_bytes(), path, (Some(String::new()), &[]), &options, &context)?;
    let loaded =
        load_named_bytes(SAMPLE.as_bytes(), path, &options, &context).map_err(|e| Failure::load(&e))?;
    let Loaded { mut scene, .. } = loaded;
    let source = ModelSource { path: path.to_owned(), format: None, options, conversion: None };
    let description = Description { size: Some([8, 8]), ..Description::default() };
    let mut task = PictureTask::new(description, source, Machine::default(), &limits)?;
    // Parts of reports that are there when they are asked for.
    task.options.aovs = vec![Aov::ObjectId];
    task.options.stage_hashes = true;
    let mut camera = task.camera(&task.source, &scene)?;
    camera.far = 1000.0;
    let Rendered { frame, stats, .. } = task.render(&task.source, &mut renderer, &scene, &camera)?;
    let (mut stages, mut warnings) = (Stages::default(), vec![Warning::new("")]);
    stats.stages().iter().for_each(|&(name, time)| stages.add(name, time));
    for stage in ["load", "load_materials", "load_environment", "encode", "write", "hash"] {
        stages.add(stage, Duration::ZERO);
    }
    let told = (&mut stages, &mut warnings);
    let ids = annotations(&mut renderer, &scene, &camera, &task.options, &frame, told)?;
    let told = Told {
        task: &task,
        scene: &scene,
        camera: &camera,
        stats: &stats,
        format: PictureFormat::File(OutputFormat::Png),
        frame_hash: frame.frame_hash(),
        encoded: 0,
        exposure: 0.0,
        threads: 1,
        ids,
    };
    let rendered = RenderReport::new(&told, stages, Duration::ZERO, warnings);
    let warning = Warning::new("").with_remedy("");
    let diagnosis = Diagnosis::new(&task, &task.source, &mut renderer, &mut scene, vec![warning.clone()])?;
    let contents: Value = serde_json::from_slice(&contents).map_err(Failure::failed)?;
    Ok(BTreeMap::from([
        ("render", keys_of(&rendered)?),
        ("info", keys_of(&contents)?),
        ("diagnose", keys_of(&diagnosis)?),
        ("formats", keys_of(&super::formats_command::report(&sample_registry()))?),
        ("error", keys_of(&Failure::usage("").json())?),
        ("warning", keys_of(&WarningJson::from(&warning))?),
    ]))
}

/// Keys of a value.
fn keys_of(value: &impl Serialize) -> Result<BTreeSet<String>, Failure> {
    let mut keys = BTreeSet::new();
    collect(&serde_json::to_value(value).map_err(Failure::failed)?, "", &mut keys);
    Ok(keys)
}

fn collect(value: &Value, place: &str, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                let dot = if place.is_empty() { "" } else { "." };
                let place = format!("{place}{dot}{key}");
                collect(value, &place, keys);
                keys.insert(place);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| collect(value, &format!("{place}[]"), keys)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_page_is_short() {
        assert!(GUIDE.lines().count() <= 90);
        assert!(GUIDE.lines().all(|line| line.chars().count() <= 122));
    }

    #[test]
    fn keys_of_lists_are_those_of_all_elements() {
        let keys = keys_of(&json!({"a": [{"b": 1}, {"c": {"d": 2}}], "e": [1, 2]})).unwrap();
        assert_eq!(keys.into_iter().collect::<Vec<_>>(), ["a", "a[].b", "a[].c", "a[].c.d", "e"]);
    }
}
