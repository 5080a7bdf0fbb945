//! `overcoat formats`: which formats of files are read and written.

use super::args::FormatsArgs;
use super::converters;
use super::failure::Failure;
use super::report;
use overcoat_core::formats::FileFormat;
use overcoat_image::decode;
use overcoat_image::output::{MovieFormat, OutputFormat};
use overcoat_load::{ENVIRONMENT_FORMATS, Format, TEXTURE_FORMATS};
use overcoat_worker::converters::{Converter, Registry};
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write;

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    read: Read,
    written: Written,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct Read {
    models: Vec<Entry>,
    /// By registered converters.
    converted: Vec<ConvertedEntry>,
    textures: Vec<Entry>,
    environments: Vec<Entry>,
    /// By the commands of `golden`.
    pictures: Vec<Entry>,
}

#[derive(Debug, Serialize)]
struct Written {
    pictures: Vec<Entry>,
    movies: Vec<Entry>,
}

#[derive(Debug, Serialize)]
struct Entry {
    name: &'static str,
    /// Without the dot; the usual one comes first.
    extensions: &'static [&'static str],
    mime_type: &'static str,
}

/// Format of a registered converter.
#[derive(Debug, Serialize)]
struct ConvertedEntry {
    name: String,
    extensions: Vec<String>,
    mime_type: String,
    /// Name of the converter.
    converter: String,
}

/// The formats that the loaders and encoders say they support.
pub(super) fn report(registry: &Registry) -> Report {
    let entry = |FileFormat { name, extensions, mime_type }| Entry { name, extensions, mime_type };
    Report {
        read: Read {
            models: Format::ALL.iter().copied().map(|format| entry(format.file_format())).collect(),
            converted: registry.all().iter().map(|converter| converted(converter)).collect(),
            textures: TEXTURE_FORMATS.iter().copied().map(entry).collect(),
            environments: ENVIRONMENT_FORMATS.iter().copied().map(entry).collect(),
            pictures: decode::FORMATS.iter().copied().map(entry).collect(),
        },
        written: Written {
            pictures: OutputFormat::ALL.iter().copied().map(|format| entry(format.file_format())).collect(),
            movies: MovieFormat::ALL.iter().copied().map(|format| entry(format.file_format())).collect(),
        },
        warnings: Vec::new(),
        versions: Versions::default(),
    }
}

fn converted(converter: &Converter) -> ConvertedEntry {
    ConvertedEntry {
        name: converter.about.clone(),
        extensions: converter.extensions.clone(),
        mime_type: converter.mime_type.clone(),
        converter: converter.name.clone(),
    }
}

/// Prints the formats.
///
/// # Errors
/// [`Failure`] if standard output cannot be written.
pub fn run(args: &FormatsArgs) -> Result<(), Failure> {
    let report = report(converters::registry()?);
    if args.json {
        return report::print_json(&report);
    }
    let mut text = String::new();
    let Report { read, written, .. } = &report;
    for (heading, entries) in [
        ("models, read", &read.models),
        ("textures, read", &read.textures),
        ("environments, read", &read.environments),
        ("pictures, written", &written.pictures),
        ("moving pictures, written", &written.movies),
        ("pictures, read by golden", &read.pictures),
    ] {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{heading}");
        for Entry { name, extensions, mime_type } in entries {
            let extensions: Vec<String> = extensions.iter().map(|e| format!(".{e}")).collect();
            let _ = writeln!(text, "  {name:<18}{:<14}{mime_type}", extensions.join(" "));
        }
    }
    if !read.converted.is_empty() {
        let _ = writeln!(text, "models, read by registered converters");
        for ConvertedEntry { name, extensions, mime_type, converter } in &read.converted {
            let extensions: Vec<String> = extensions.iter().map(|e| format!(".{e}")).collect();
            let _ = writeln!(text, "  {name:<18}{:<14}{mime_type} ({converter})", extensions.join(" "));
        }
    }
    report::print(&text)
}
