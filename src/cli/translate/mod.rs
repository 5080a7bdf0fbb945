//! `overcoat translate`: a material file for another engine, with what is left of the difference.

use super::args::{CellArgs, ReportArgs, ThreadArgs};
use super::contact::ContactSheet;
use super::failure::Failure;
use super::output_file::{Encoded, check_file, is_standard_output};
use super::progress::Progress;
use super::report::{self, Reporter, Versions};
use super::{ball, value_parsers};
use crate::description::{Machine, MaterialChoice, MaterialSource, builtin};
use crate::lab::{Distance, Translation, Translator};
use crate::limits::Limits;
use crate::load::{Context, MaterialFile, Resolver, resolver_beside};
use crate::render::Renderer;
use crate::scene::parameters::{Kind, PARAMETERS, slots};
use crate::scene::{Material, ShadingModel};
use clap::Args;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Side of a ball in pixels.
const BALL: u32 = 256;

/// `overcoat translate`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat translate candy-red --to three -o candy-three.toml
  overcoat translate paint.toml --to openpbr -o new.toml --picture both.png

Finds the parameters of --to whose surfaces look most like those of --from: least squares of lightness over five views, under
white light and light from one direction. Textures stay as they are, relative to the file; parameters are found for where they
are white. Differences are root mean squares of lightness, which is 0 for black and 1 for white.")]
pub struct TranslateArgs {
    /// Material file (.toml), or the name of a built-in material
    #[arg(value_name = "MATERIAL", value_parser = value_parsers::material_parser())]
    pub material: MaterialChoice,

    /// Shading model to find parameters for
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading)]
    pub to: ShadingModel,

    /// Shading model whose pictures are meant [default: what the material names, else standard]
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading)]
    pub from: Option<ShadingModel>,

    /// Material file to write (.toml) [default: it is printed]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Also write a picture of a ball of each material side by side (.png, .webp or .jpg)
    #[arg(long, value_name = "PICTURE")]
    pub picture: Option<PathBuf>,

    #[command(flatten)]
    pub workers: ThreadArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    from: &'static str,
    to: &'static str,
    material: String,
    before: Difference,
    after: Difference,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct Difference {
    all: f64,
    white: f64,
    highlights: f64,
    body: f64,
}

impl From<Distance> for Difference {
    fn from(Distance { all, white, highlights, body }: Distance) -> Self {
        Self { all, white, highlights, body }
    }
}

/// Translates a material, writes it and says how far it is off.
///
/// # Errors
/// [`Failure`] if the material cannot be read or what is asked for cannot be written.
pub fn run(args: &TranslateArgs) -> Result<(), Failure> {
    check_output(args)?;
    let limits = Limits::default();
    let mut renderer = Renderer::new(args.workers.count());
    let (file, resolver) = read(&args.material.source, &limits, &renderer)?;
    let reporter = Reporter { quiet: args.report.quiet };
    let mut warnings: Vec<String> = file.warnings().map(|warning| warning.to_string()).collect();
    let material = material_of(&file, &limits)?;
    let from = material.shading(args.from);
    for (model, whose) in [(from, "of --from"), (args.to, "of --to")] {
        if !model.is_built() {
            return Err(Failure::usage(format!(
                "the model {whose} is not in this program: {}",
                model.name()
            )));
        }
    }
    let progress = Progress::new(args.report.quiet);
    progress.stage(format!("{} to {}", from.name(), args.to.name()));
    let found = Translator::new().translate(&material, from, args.to).map_err(|e| Failure::lab(&e))?;
    warnings.extend(args.to.leaves_out(&material).map(|what| {
        format!("{} does not know {what}: what it looks like is approached by the rest", args.to.name())
    }));
    let toml = written(&found, file.text(), [from, args.to], &args.material.source);
    if let Some(picture) = &args.picture {
        progress.stage("drawing");
        let context = Context { resolver: resolver.as_ref(), limits: &limits, jobs: renderer.jobs() };
        let written =
            MaterialFile::from_bytes(toml.as_bytes(), &context).map_err(|e| Failure::material(&e))?;
        balls(args, picture, [(&file, from), (&written, args.to)], &limits, &mut renderer)?;
    }
    drop(progress);
    warnings.iter().for_each(|warning| reporter.warning(warning));
    if let Some(output) = args.output.as_ref().filter(|path| !is_standard_output(path)) {
        Encoded::new(output.clone(), toml.clone().into_bytes()).write()?;
    }
    let Translation { before, after, .. } = found;
    if args.report.json {
        return report::print_json(&Report {
            from: from.name(),
            to: args.to.name(),
            material: toml,
            before: before.into(),
            after: after.into(),
            warnings,
            versions: Versions::default(),
        });
    }
    match &args.output {
        Some(path) if !is_standard_output(path) => report::print(&told(before, after)),
        _ => report::print(&toml),
    }
}

fn check_output(args: &TranslateArgs) -> Result<(), Failure> {
    let Some(path) = args.output.as_deref().filter(|path| !is_standard_output(path)) else { return Ok(()) };
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("toml")) {
        return Err(Failure::usage(format!("{} is no .toml", path.display())));
    }
    let input: Vec<PathBuf> = args.material.source.file().map(Path::to_owned).into_iter().collect();
    check_file(path, &input)
}

/// Reads a material, and what finds its textures.
fn read(
    source: &MaterialSource,
    limits: &Limits,
    renderer: &Renderer,
) -> Result<(MaterialFile, Box<dyn Resolver>), Failure> {
    let jobs = renderer.jobs();
    match source {
        MaterialSource::File(path) => {
            let file = MaterialFile::open(path, limits, jobs).map_err(|e| Failure::material(&e).at(path))?;
            Ok((file, resolver_beside(path)))
        }
        MaterialSource::Builtin(name) => {
            let builtin = builtin(name).map_err(|e| Failure::usage(format!("'{name}' is {e}")))?;
            let file = builtin.load(limits, jobs).map_err(|e| Failure::material(&e).at(Path::new(name)))?;
            Ok((file, Box::new(*builtin)))
        }
    }
}

/// The material of a file.
fn material_of(file: &MaterialFile, limits: &Limits) -> Result<Material, Failure> {
    let mut scene = ball::scene().map_err(|e| Failure::scene(&e))?;
    file.assign(&mut scene, None, limits).map_err(|e| Failure::assign(&e))?;
    Ok(scene.materials()[0].clone())
}

/// The material file: numbers that are not the default, textures as the source names them.
fn written(
    found: &Translation,
    text: &str,
    [from, to]: [ShadingModel; 2],
    source: &MaterialSource,
) -> String {
    let table: toml::Table = text.parse().unwrap_or_default();
    let mut text = format!(
        "# Made by overcoat translate from {} to {}. Difference {:.4}, before {:.4}.\n",
        from.name(),
        to.name(),
        found.after.all,
        found.before.all,
    );
    if source.file().is_none() && slots().any(|(_, slot)| slot.get(&found.material).is_some()) {
        text += "# Its textures are in assets/materials of the sources.\n";
    }
    let mut put = |key: &str, value: &toml::Value| {
        let _ = writeln!(text, "{key} = {value}");
    };
    if let Some(description) = table.get("description").and_then(|value| value.as_str()) {
        put("description", &toml::Value::from(description));
    }
    put("model", &toml::Value::from(to.name()));
    let default = Material::default();
    for parameter in PARAMETERS.iter().filter(|p| p.is_in(&found.material) && p.name != "model") {
        match parameter.kind {
            // Also what is switched or named, which no number says.
            Kind::Texture(_) | Kind::Switch(_) | Kind::Name { .. } => {
                if let Some(value) = table.get(parameter.name) {
                    put(parameter.name, value);
                }
            }
            _ => {
                let (numbers, plain) = (parameter.numbers(&found.material), parameter.numbers(&default));
                if numbers != plain {
                    let numbers = numbers.map(|c| toml::Value::from(short(c)));
                    match &numbers[..parameter.width()] {
                        [one] => put(parameter.name, one),
                        several => put(parameter.name, &toml::Value::from(several.to_vec())),
                    }
                }
            }
        }
    }
    text
}

/// A number as few digits say it.
fn short(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

fn told(before: Distance, after: Distance) -> String {
    let line = |name: &str, a: f64, b: f64| format!("{name:<12} {a:>8.4} {b:>8.4}\n");
    let mut text = format!("{:<12} {:>8} {:>8}\n", "difference", "before", "after");
    text += &line("all", before.all, after.all);
    text += &line("white light", before.white, after.white);
    text += &line("highlights", before.highlights, after.highlights);
    text += &line("body", before.body, after.body);
    text
}

/// Two balls side by side.
fn balls(
    args: &TranslateArgs,
    output: &Path,
    materials: [(&MaterialFile, ShadingModel); 2],
    limits: &Limits,
    renderer: &mut Renderer,
) -> Result<(), Failure> {
    let description = ball::description([BALL.into(); 2]);
    let cells = CellArgs::default();
    let mut sheet = ContactSheet::new(output, &[], args.report.json, 2, &cells, [BALL; 2], limits)?;
    for (file, model) in materials {
        let (mut options, display) = description.options(Machine::default(), limits)?;
        options.shading = Some(model);
        let mut scene = ball::scene().map_err(|e| Failure::scene(&e))?;
        let (image, _) = ball::picture(&description, &mut scene, file, &options, &display, renderer)?;
        sheet.add(&[&image], [model.name(), ""]);
    }
    sheet.write()
}
