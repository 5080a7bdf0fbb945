//! `overcoat translate`: a material for another engine, or for a measured BRDF, as a material file or in a copy of a glTF file, with
//! what is left of the difference.

pub(crate) mod measured;
mod model;
mod seen;

use super::args::{CellArgs, ReportArgs, ThreadArgs};
use super::contact::ContactSheet;
use super::file_uri::file_or_uri;
use super::output_file::{Encoded, check_file, is_standard_output};
use super::progress::Progress;
use super::report::{self, Reporter};
use super::{ball, value_parsers};
use crate::failure::{self, Failure};
use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};
use model::{ModelCopy, goal_in_a_file, is_model, unknown};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::{Machine, MaterialChoice, MaterialSource, builtin};
use overcoat_lab::lab::{Distance, Goal, Translation, Translator};
use overcoat_load::{Context, MaterialFile, OwnTextures, Resolver, resolver_beside};
use overcoat_render::Renderer;
use overcoat_scene::parameters::{Kind, PARAMETERS, slots};
use overcoat_scene::{Material, Scene, ShadingModel};
use overcoat_worker::report::Versions;
use seen::Flip;
use serde::Serialize;
use serde::ser::{Error as _, SerializeMap, Serializer};
use serde_json::value::RawValue;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Side of a ball in pixels.
const BALL: u32 = 256;

/// Keys of material files for one channel of a texture: that of the whole, and theirs.
const PARTS: [(&str, &str); 2] =
    [("metallic_roughness_texture", "metallic_texture"), ("metallic_roughness_texture", "roughness_texture")];

/// `overcoat translate`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat translate candy-red --to three -o candy-three.toml
  overcoat translate paint.toml --to openpbr -o new.mtlx --picture both.png
  overcoat translate paint.toml --to gltf --into car.glb --material body -o painted.glb
  overcoat translate car.glb --from three --to gltf -o copy.glb
  overcoat translate gold-metallic-paint.binary --to filament -o gold.toml

Finds the parameters of --to whose surfaces look most like those of --from: least squares of lightness over five views, under
white light and light from one direction. What the other engine or the file has no place for (flakes, films, orange peel) is
replaced by what looks the same in mean. Textures stay as they are, relative to the file; parameters are found for three of their
texels, dark, middle and bright. Differences are root mean squares of lightness, which is 0 for black and 1 for white.

What was written is read again and drawn: FLIP (0 equal to 1) is its mean over a sphere of 256 pixels and, with a glTF file, over
the file's own picture. Above 0.3 on the sphere or 0.12 on the file it is an error, exit code 4, and nothing is
written, unless --force is given.

With --into the material takes the place of one of a glTF file, in a copy; normal maps and occlusion of the file stay, other
textures of that material go. A glTF file in place of the material: each of its materials with a clear coat is translated in a
copy, and its textures stay. Nothing else of a copy is changed. It refers to the same files, so that it goes beside the
original where there are any.

A measured BRDF in place of the material: a file of MERL (.binary) or one of the RGL in red, green and blue (_rgb.bsdf). Without a
material that says which features it has, plain surfaces, a clear coat, sheen and a film are tried, and more features are taken
where they pay. FLIP is on a sphere under white light and three lamps. Errors of radiance are told at angles between those
of the fit: root mean square, and relative to all measured light.")]
pub struct TranslateArgs {
    /// Material file (.toml, .mtlx), the name of a built-in material, a glTF file (.glb, .gltf), or a measured BRDF (.binary, .bsdf)
    #[arg(value_name = "MATERIAL", value_parser = subject_parser())]
    pub subject: Subject,

    /// Shading model to find parameters for
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading)]
    pub to: ShadingModel,

    /// Shading model whose pictures are meant [default: what the material names, else standard]
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading)]
    pub from: Option<ShadingModel>,

    /// glTF file (.glb, .gltf) into a copy of which the material is put
    #[arg(long, value_name = "MODEL", value_parser = model_parser())]
    pub into: Option<PathBuf>,

    /// Name of the material of the glTF file that is replaced or translated (repeatable)
    #[arg(long, value_name = "NAME")]
    pub material: Vec<String>,

    /// File to write: material (.toml; .mtlx with --to openpbr), or copy of the glTF file [default: the material is printed]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Write the file although FLIP is above 0.3 on a sphere or 0.12 on the file
    #[arg(long)]
    pub force: bool,

    /// Also write a picture of a ball of each material side by side (.png, .webp or .jpg)
    #[arg(long, value_name = "PICTURE")]
    pub picture: Option<PathBuf>,

    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub workers: ThreadArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub report: ReportArgs,
}

/// Subject of the translation.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A material.
    Material(MaterialChoice),
    /// Materials of a glTF file.
    Model(PathBuf),
    /// A measured BRDF.
    Measured(PathBuf),
}

impl TranslateArgs {
    /// The files that are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let subject = match &self.subject {
            Subject::Material(choice) => choice.source.file(),
            Subject::Model(path) | Subject::Measured(path) => Some(path.as_path()),
        };
        subject.into_iter().chain(self.into.as_deref())
    }
}

fn subject_parser() -> impl TypedValueParser<Value = Subject> {
    OsStringValueParser::new().try_map(|text: OsString| {
        if is_model(Path::new(&text)) {
            file_or_uri(&text).map(Subject::Model)
        } else if is_measured(Path::new(&text)) {
            file_or_uri(&text).map(Subject::Measured)
        } else {
            value_parsers::material(text).map(Subject::Material)
        }
    })
}

/// True of names of measured BRDFs.
pub(crate) fn is_measured(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("binary") || e.eq_ignore_ascii_case("bsdf"))
}

fn model_parser() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|text: OsString| {
        if is_model(Path::new(&text)) {
            file_or_uri(&text)
        } else {
            Err("expected a .glb or .gltf file".to_owned())
        }
    })
}

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    from: &'static str,
    to: &'static str,
    /// Translation of a material, as a material file.
    #[serde(skip_serializing_if = "Option::is_none")]
    material: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    before: Option<Difference>,
    #[serde(skip_serializing_if = "Option::is_none")]
    after: Option<Difference>,
    /// FLIP between the material and what was written.
    flip: Flip,
    /// Errors of radiance of a fit to a measured BRDF.
    #[serde(skip_serializing_if = "Option::is_none")]
    residual: Option<measured::Residuals>,
    /// Materials in the copy of a glTF file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<Written>,
    warnings: Vec<String>,
    versions: Versions,
}

/// A material that was written into a glTF file.
#[derive(Debug, Serialize)]
struct Written {
    index: usize,
    name: String,
    /// FLIP on a sphere.
    flip: f64,
    before: Difference,
    after: Difference,
    /// Members that have new values, by their paths from the material.
    members: Members,
}

/// Members of a JSON object with the text of their values.
#[derive(Debug)]
struct Members(Vec<(String, String)>);

impl Serialize for Members {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            let value = RawValue::from_string(value.clone()).map_err(S::Error::custom)?;
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

#[derive(Clone, Copy, Debug, Serialize)]
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
    let limits = Limits::default();
    match &args.subject {
        Subject::Material(choice) => material(args, choice, &limits),
        Subject::Model(path) => tuned(args, path, &limits),
        Subject::Measured(path) => measured::run(args, path, &limits),
    }
}

/// Materials of a glTF file, in a copy.
fn tuned(args: &TranslateArgs, source: &Path, limits: &Limits) -> Result<(), Failure> {
    if args.into.is_some() {
        return Err(Failure::usage(
            "--into is for a material: a glTF file is translated in its own copy, -o",
        ));
    }
    if args.picture.is_some() {
        return Err(Failure::usage("--picture is of one material: draw the copy with overcoat render"));
    }
    let mut copy = ModelCopy::open(args, source, &[], &args.material, limits, true)?;
    let from = args.from.unwrap_or_default();
    let models = [from, args.to];
    check_built(Some(from), args.to)?;
    let mut renderer = Renderer::new(args.workers.count());
    let resolver = resolver_beside(source);
    let jobs = Jobs::new(args.workers.count());
    let context = Context { resolver: resolver.as_ref(), limits, jobs: &jobs };
    let progress = Progress::new(args.report.quiet);
    copy.tune(models, &context, &progress)?;
    progress.stage("drawing");
    let flip = copy.seen(None, models, &context, &mut renderer)?;
    drop(progress);
    let what = format!("{} to {}", source.display(), args.to.name());
    flip.check(&what, &copy.lacks, args.force)?;
    finish(args, copy, from, flip, None)
}

/// A material, as a file or in a copy of a glTF file.
fn material(args: &TranslateArgs, choice: &MaterialChoice, limits: &Limits) -> Result<(), Failure> {
    let source = &choice.source;
    let copy = match &args.into {
        Some(model) => {
            let others: Vec<PathBuf> = source.file().map(Path::to_owned).into_iter().collect();
            let wanted: Vec<String> = choice.name.iter().chain(&args.material).cloned().collect();
            Some(ModelCopy::open(args, model, &others, &wanted, limits, false)?)
        }
        None => {
            check_output(args, source)?;
            None
        }
    };
    let mut renderer = Renderer::new(args.workers.count());
    let (file, resolver) = read(source, limits, &renderer)?;
    if copy.is_some() && file.is_over() {
        let what = "it changes a part of a model's own materials: --into needs one that says all";
        return Err(Failure::usage(what));
    }
    let mut warnings: Vec<String> = file.warnings().map(|warning| warning.to_string()).collect();
    let scene = scene_of(&file, limits)?;
    let material = &scene.materials()[0];
    let from = material.shading(args.from);
    let models = [from, args.to];
    check_built(Some(from), args.to)?;
    let goal = match copy {
        Some(_) => goal_in_a_file(args.to, OwnTextures::Replaced),
        None => Goal::of_a_file(args.to),
    };
    let progress = Progress::new(args.report.quiet);
    progress.stage(format!("{} to {}", from.name(), args.to.name()));
    let found = Translator::new().translate_for(material, scene.textures(), from, &goal);
    let found = found.map_err(|e| failure::lab(&e))?;
    warnings.extend(unknown(&goal, material));
    let what = format!("{} to {}", label(source), args.to.name());
    progress.stage("drawing");
    if let Some(mut copy) = copy {
        copy.paint(&found)?;
        let model = args.into.as_deref().unwrap_or(Path::new("."));
        let beside = resolver_beside(model);
        let jobs = Jobs::new(args.workers.count());
        let context = Context { resolver: beside.as_ref(), limits, jobs: &jobs };
        let flip = copy.seen(Some(&file), models, &context, &mut renderer)?;
        let toml = written(&found, &goal, file.text(), [from, args.to], source, flip);
        if let Some(picture) = &args.picture {
            let context = Context { resolver: resolver.as_ref(), limits, jobs: &jobs };
            let made = reread(&toml, &context)?;
            flip.check(&what, &goal.lacks(material), args.force)?;
            balls(args, picture, [(&file, from), (&made, args.to)], limits, &mut renderer)?;
        }
        drop(progress);
        copy.warnings.splice(0..0, warnings);
        flip.check(&what, &goal.lacks(material), args.force)?;
        return finish(args, copy, from, flip, Some((toml, found)));
    }
    let jobs = Jobs::new(args.workers.count());
    let context = Context { resolver: resolver.as_ref(), limits, jobs: &jobs };
    // Numbers and textures are those of the file that is written; the report in its first line is no part of them.
    let toml = written(&found, &goal, file.text(), models, source, Flip::new(0.0, None));
    let (made, materialx) = as_read(args, &toml, &context, &mut warnings)?;
    let spheres = [seen::sphere_of_file(&file, from, limits)?, seen::sphere_of_file(&made, args.to, limits)?];
    let flip = Flip::new(seen::between_spheres(spheres, &mut renderer, limits)?, None);
    flip.check(&what, &goal.lacks(material), args.force)?;
    let toml = written(&found, &goal, file.text(), models, source, flip);
    if let Some(picture) = &args.picture {
        balls(args, picture, [(&file, from), (&made, args.to)], limits, &mut renderer)?;
    }
    drop(progress);
    let [before, after] = [found.before, found.after].map(Difference::from);
    let report = Report {
        from: from.name(),
        to: args.to.name(),
        material: Some(toml),
        before: Some(before),
        after: Some(after),
        flip,
        residual: None,
        materials: Vec::new(),
        warnings,
        versions: Versions::default(),
    };
    put(args, materialx, &(told(&before, &after) + &flip.told()), &report)
}

/// A material file as it is read, and the text of the MaterialX document that it becomes where the output is one.
fn as_read(
    args: &TranslateArgs,
    toml: &str,
    context: &Context<'_>,
    warnings: &mut Vec<String>,
) -> Result<(MaterialFile, Option<String>), Failure> {
    let made = reread(toml, context)?;
    if !args.output.as_deref().is_some_and(is_materialx) {
        return Ok((made, None));
    }
    let (document, lost) = made.to_materialx();
    warnings.extend(lost.iter().map(ToString::to_string));
    Ok((reread(&document, context)?, Some(document)))
}

/// Writes the material of a report, and says how far it is off: as JSON, in words beside the file, or in the file that is printed.
fn put(args: &TranslateArgs, materialx: Option<String>, told: &str, report: &Report) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    report.warnings.iter().for_each(|warning| reporter.warning(warning));
    let toml = report.material.as_deref().unwrap_or_default();
    let file = args.output.as_ref().filter(|path| !is_standard_output(path));
    if let Some(output) = file {
        let text = materialx.unwrap_or_else(|| toml.to_owned());
        Encoded::new(output.clone(), text.into_bytes()).write()?;
    }
    if args.report.json {
        return report::print_json(report);
    }
    report::print(if file.is_some() { told } else { toml })
}

/// True of the name of a MaterialX document.
fn is_materialx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mtlx"))
}

/// Name of a material in messages.
fn label(source: &MaterialSource) -> String {
    match source {
        MaterialSource::File(path) => path.display().to_string(),
        MaterialSource::Builtin(name) => name.to_string(),
    }
}

/// A material file that was written, as it is read.
fn reread(text: &str, context: &Context<'_>) -> Result<MaterialFile, Failure> {
    MaterialFile::from_bytes(text.as_bytes(), context).map_err(|e| Failure::material(&e))
}

/// Writes a copy and says what is in it.
fn finish(
    args: &TranslateArgs,
    copy: ModelCopy,
    from: ShadingModel,
    flip: Flip,
    found: Option<(String, Translation)>,
) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    copy.warnings.iter().for_each(|warning| reporter.warning(warning));
    let to_standard_output = copy.write()?;
    if args.report.json {
        let (material, found) = found.unzip();
        return report::print_json(&Report {
            from: from.name(),
            to: args.to.name(),
            material,
            before: found.as_ref().map(|found| found.before.into()),
            after: found.as_ref().map(|found| found.after.into()),
            flip,
            residual: None,
            materials: copy.written,
            warnings: copy.warnings,
            versions: Versions::default(),
        });
    }
    if to_standard_output { Ok(()) } else { report::print(&(copy.told() + &flip.of_the_file())) }
}

fn check_built(from: Option<ShadingModel>, to: ShadingModel) -> Result<(), Failure> {
    for (model, whose) in from.map(|model| (model, "of --from")).into_iter().chain([(to, "of --to")]) {
        if !model.is_built() {
            return Err(Failure::usage(format!(
                "the model {whose} is not in this program: {}",
                model.name()
            )));
        }
    }
    Ok(())
}

fn check_output(args: &TranslateArgs, source: &MaterialSource) -> Result<(), Failure> {
    if !args.material.is_empty() {
        return Err(Failure::usage("--material is one of a glTF file: name that with --into"));
    }
    let Some(path) = args.output.as_deref().filter(|path| !is_standard_output(path)) else { return Ok(()) };
    if is_model(path) {
        let what = "a material becomes part of a model: name the glTF file with --into";
        return Err(Failure::usage(what).at(path));
    }
    if is_materialx(path) && args.to != ShadingModel::OpenPbr {
        let what = "MaterialX takes the numbers of OpenPBR: it is written with --to openpbr";
        return Err(Failure::usage(what).at(path));
    }
    if !is_materialx(path) && path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("toml")) {
        return Err(Failure::usage(format!("{} is no .toml or .mtlx", path.display())));
    }
    let input: Vec<PathBuf> = source.file().map(Path::to_owned).into_iter().collect();
    check_file(path, &input)
}

/// Reads a material, and what finds its textures.
pub(super) fn read(
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

/// A scene whose first material is that of a file, with its textures.
pub(super) fn scene_of(file: &MaterialFile, limits: &Limits) -> Result<Scene, Failure> {
    let mut scene = ball::scene().map_err(|e| Failure::scene(&e))?;
    file.assign(&mut scene, None, limits).map_err(|e| Failure::assign(&e))?;
    Ok(scene)
}

/// The material file: numbers that are not the default, textures as the source names them.
fn written(
    found: &Translation,
    goal: &Goal<'_>,
    text: &str,
    [from, to]: [ShadingModel; 2],
    source: &MaterialSource,
    flip: Flip,
) -> String {
    let table: toml::Table = text.parse().unwrap_or_default();
    let mut text = format!(
        "# Made by overcoat translate from {} to {}. FLIP on a sphere {:.4}.\n",
        from.name(),
        to.name(),
        flip.sphere,
    );
    if source.file().is_none() && slots().any(|(_, slot)| slot.get(&found.material).is_some()) {
        text += "# Its textures are in assets/materials of the sources.\n";
    }
    text + &keys(&found.material, goal, &table)
}

/// The keys of a material file: numbers that are not the default, what else there is as the table of another one names it.
fn keys(material: &Material, goal: &Goal<'_>, table: &toml::Table) -> String {
    let mut text = String::new();
    let mut put = |key: &str, value: &toml::Value| {
        let _ = writeln!(text, "{key} = {value}");
    };
    if let Some(description) = table.get("description").and_then(|value| value.as_str()) {
        put("description", &toml::Value::from(description));
    }
    put("model", &toml::Value::from(goal.model.name()));
    let default = Material::default();
    for parameter in PARAMETERS.iter().filter(|p| p.is_in(material) && p.name != "model") {
        match parameter.kind {
            // Also what is switched or named, which no number says.
            Kind::Texture(_) | Kind::Switch(_) | Kind::Name { .. } if (goal.holds)(parameter) => {
                let parts = PARTS.iter().filter(|(whole, _)| *whole == parameter.name);
                for name in parts.map(|(_, part)| *part).chain([parameter.name]) {
                    if let Some(value) = table.get(name) {
                        put(name, value);
                    }
                }
            }
            Kind::Texture(_) | Kind::Switch(_) | Kind::Name { .. } => {}
            _ => {
                let (numbers, plain) = (parameter.numbers(material), parameter.numbers(&default));
                if numbers != plain {
                    let numbers = if parameter.name == "anisotropy_rotation" {
                        // Files have degrees.
                        numbers.map(f32::to_degrees)
                    } else {
                        numbers
                    };
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

fn told(before: &Difference, after: &Difference) -> String {
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
