//! `overcoat materials`: what materials are built in.

use super::args::MaterialsArgs;
use super::ball;
use super::contact::{ContactSheet, DEFAULT_CELL};
use super::failure::Failure;
use super::progress::Progress;
use super::report::{self, Reporter};
use overcoat_core::limits::Limits;
use overcoat_description::builtin;
use overcoat_load::{BuiltinMaterial, MaterialFile, material_keys};
use overcoat_render::Renderer;
use overcoat_scene::ShadingModel;
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    materials: Vec<Entry>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct Entry {
    name: &'static str,
    model: Option<&'static str>,
    description: String,
    /// Hash of the picture, where a sheet is made.
    frame_hash: Option<String>,
}

/// Report of `--keys --json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct KeyReport {
    keys: Vec<KeyEntry>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct KeyEntry {
    key: &'static str,
    takes: String,
    default: Option<String>,
    about: &'static str,
    /// The shading models that read it; none if it is for all.
    read_by: Vec<&'static str>,
}

/// Lists the built-in materials, prints one, or renders all of them.
///
/// # Errors
/// [`Failure`] if there is no such material or the sheet cannot be made.
pub fn run(args: &MaterialsArgs) -> Result<(), Failure> {
    if let Some(name) = &args.name {
        return print_one(name, args.report.json);
    }
    if args.keys {
        return print_keys(args.report.json);
    }
    let mut renderer = args.machine.renderer(args.report.quiet);
    let limits = Limits::default();
    let mut loaded: Vec<(Entry, MaterialFile)> = Vec::new();
    for material in BuiltinMaterial::all() {
        let file = load(material, &limits, &renderer)?;
        loaded.push((entry(material, &file), file));
    }
    let mut warnings = Vec::new();
    if let Some(output) = &args.output {
        warnings = sheet(args, output, &mut loaded, &limits, &mut renderer)?;
        if !args.report.json {
            return Ok(());
        }
    }
    let entries: Vec<Entry> = loaded.into_iter().map(|(entry, _)| entry).collect();
    if args.report.json {
        return report::print_json(&Report { materials: entries, warnings, versions: Versions::default() });
    }
    let width = entries.iter().map(|e| e.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for Entry { name, model, description, .. } in &entries {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<width$}  {:<15}  {description}", model.unwrap_or("any"));
    }
    report::print(&text)
}

fn load(material: &BuiltinMaterial, limits: &Limits, renderer: &Renderer) -> Result<MaterialFile, Failure> {
    material.load(limits, renderer.jobs()).map_err(|e| Failure::material(&e).at(Path::new(material.name)))
}

fn entry(material: &BuiltinMaterial, file: &MaterialFile) -> Entry {
    Entry {
        name: material.name,
        model: file.model().map(|model| model.name()),
        description: file.description().to_owned(),
        frame_hash: None,
    }
}

/// Prints the file of one material.
fn print_one(name: &str, json: bool) -> Result<(), Failure> {
    let material = builtin(name).map_err(|e| Failure::usage(format!("'{name}' is {e}")))?;
    if json {
        let file = load(material, &Limits::default(), &Renderer::new(1))?;
        let materials = vec![entry(material, &file)];
        return report::print_json(&Report {
            materials,
            warnings: Vec::new(),
            versions: Versions::default(),
        });
    }
    report::print(material.text)
}

/// Prints the keys of material files.
fn print_keys(json: bool) -> Result<(), Failure> {
    if json {
        let keys = material_keys()
            .map(|k| KeyEntry {
                key: k.name,
                takes: k.takes,
                default: k.default,
                about: k.about,
                read_by: k.read_by.into_iter().map(ShadingModel::name).collect(),
            })
            .collect();
        return report::print_json(&KeyReport { keys, warnings: Vec::new(), versions: Versions::default() });
    }
    let mut text = String::new();
    for key in material_keys() {
        let default = key.default.map_or_else(String::new, |default| format!(" [default: {default}]"));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}\n    {}\n    {}{default}", key.name, key.about, key.takes);
        if !key.read_by.is_empty() {
            let models: Vec<&str> = key.read_by.into_iter().map(ShadingModel::name).collect();
            let _ = writeln!(text, "    read by {}", models.join(", "));
        }
    }
    report::print(&text)
}

/// Renders a ball of each material to one sheet. Returns what is doubtful about the light.
fn sheet(
    args: &MaterialsArgs,
    output: &Path,
    loaded: &mut [(Entry, MaterialFile)],
    limits: &Limits,
    renderer: &mut Renderer,
) -> Result<Vec<String>, Failure> {
    let progress = Progress::new(args.report.quiet);
    let mut description = ball::description(args.size.unwrap_or(DEFAULT_CELL));
    args.light.apply(&mut description);
    let (options, display) = description.options(args.machine.machine(), limits)?;
    let (count, cell) = (loaded.len(), [options.width, options.height]);
    let mut sheet = ContactSheet::new(output, &[], args.report.json, count, &args.cells, cell, limits)?;
    let mut surroundings = ball::scene().map_err(|e| Failure::scene(&e))?;
    let warnings = description.light(&mut surroundings, limits, renderer.jobs())?;
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    for warning in &warnings {
        Reporter { quiet: args.report.quiet }.warning(warning);
    }
    for (k, (entry, file)) in loaded.iter_mut().enumerate() {
        progress.stage(format!("{} of {count}: {}", k + 1, entry.name));
        let mut scene = surroundings.clone();
        let (image, hash) = ball::picture(&description, &mut scene, file, &options, &display, renderer)
            .map_err(|failure| failure.at(Path::new(entry.name)))?;
        entry.frame_hash = Some(hash);
        sheet.add(&[&image], [entry.name, entry.model.unwrap_or("any model")]);
    }
    progress.stage("encoding");
    sheet.write()?;
    Ok(warnings)
}
