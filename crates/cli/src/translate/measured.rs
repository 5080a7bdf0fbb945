//! Translations of measured BRDFs: files of MERL and of the RGL.

use super::seen::{self, Flip};
use super::{
    BALL, Difference, Report, TranslateArgs, as_read, check_built, check_output, keys, put, scene_of,
};
use crate::args::CellArgs;
use crate::contact::ContactSheet;
use crate::failure::{self, Failure};
use crate::progress::Progress;
use overcoat_core::frame::DisplayImage;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::MaterialSource;
use overcoat_lab::lab::{Bench, Fit, Goal, MeasuredBrdf, Residual, Translator};
use overcoat_load::{Context, read_input, resolver_beside};
use overcoat_worker::codes;
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::path::Path;

/// Errors of radiance of a fit, at angles between those that it was made for.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Residuals {
    /// Under white light: of directional albedos.
    white: Errors,
    /// Under light from one direction: of the BRDF times the cosine of the light.
    direct: Errors,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Errors {
    /// Root mean square over directions and channels.
    rms: f64,
    /// Sum of differences of luminance over the sum of luminance.
    relative: f64,
    directions: usize,
}

impl From<Residual> for Errors {
    fn from(Residual { rms, relative, directions }: Residual) -> Self {
        Self { rms, relative, directions }
    }
}

/// Reads a measured BRDF.
///
/// # Errors
/// [`Failure`] naming the file and what is wrong with it.
pub(crate) fn read(path: &Path, limits: &Limits) -> Result<(MeasuredBrdf, Vec<String>), Failure> {
    let (bytes, packed) = read_input(path, limits).map_err(|e| Failure::load(&e).at(path))?;
    let brdf = MeasuredBrdf::from_bytes(bytes);
    let brdf = brdf.map_err(|e| Failure::failed(e).with_code(codes::MALFORMED).at(path))?;
    let mut warnings: Vec<String> = packed.iter().map(ToString::to_string).collect();
    if brdf.is_anisotropic() {
        warnings.push("it is anisotropic: its mean over all azimuths is meant".to_owned());
    }
    Ok((brdf, warnings))
}

/// Finds parameters for a measured BRDF, writes them and says how far they are off.
///
/// # Errors
/// [`Failure`] if the file cannot be read or what is asked for cannot be written.
pub(super) fn run(args: &TranslateArgs, path: &Path, limits: &Limits) -> Result<(), Failure> {
    for (is_given, option) in [(args.from.is_some(), "--from"), (args.into.is_some(), "--into")] {
        if is_given {
            let what = format!("{option} is for a material: what is measured becomes one first, with -o");
            return Err(Failure::usage(what).at(path));
        }
    }
    check_output(args, &MaterialSource::File(path.to_owned()))?;
    check_built(None, args.to)?;
    let (brdf, mut warnings) = read(path, limits)?;
    let progress = Progress::new(args.report.quiet);
    progress.stage(format!("{} to {}", brdf.format(), args.to.name()));
    let fit = Translator::new().fit(&brdf, args.to).map_err(|e| failure::lab(&e).at(path))?;
    progress.stage("drawing");
    let keys = keys_of(&brdf, &fit, args);
    let jobs = Jobs::new(args.workers.count());
    let resolver = resolver_beside(path);
    let context = Context { resolver: resolver.as_ref(), limits, jobs: &jobs };
    let (made, materialx) = as_read(args, &keys, &context, &mut warnings)?;
    let scene = scene_of(&made, limits)?;
    let mut bench = Bench::new(args.workers.count());
    let spheres = brdf.spheres(&mut bench, &scene.materials()[0], args.to, BALL);
    let (images, off) = seen::between_frames(&spheres.map_err(|e| failure::lab(&e))?);
    let flip = Flip::new(off, None);
    flip.check(&format!("{} to {}", path.display(), args.to.name()), &[], args.force)?;
    if let Some(picture) = &args.picture {
        balls(args, picture, &images, limits)?;
    }
    drop(progress);
    let residual = Residuals { white: fit.white.into(), direct: fit.direct.into() };
    let toml = format!(
        "# Made by overcoat translate for {} of a {} file. FLIP on a sphere {:.4}.\n\
         # Error in white light {:.1} %, in light from one direction {:.1} %.\n{keys}",
        args.to.name(),
        brdf.format(),
        flip.sphere,
        100.0 * fit.white.relative,
        100.0 * fit.direct.relative,
    );
    let after = Difference::from(fit.distance);
    let report = Report {
        from: brdf.format(),
        to: args.to.name(),
        material: Some(toml),
        before: None,
        after: Some(after),
        flip,
        residual: Some(residual),
        materials: Vec::new(),
        warnings,
        versions: Versions::default(),
    };
    put(args, materialx, &(told(&after, &residual) + &flip.told()), &report)
}

/// The keys of the material file, with the words that the measurement has.
fn keys_of(brdf: &MeasuredBrdf, fit: &Fit, args: &TranslateArgs) -> String {
    let mut table = toml::Table::new();
    if !brdf.description().is_empty() {
        table.insert("description".to_owned(), brdf.description().into());
    }
    keys(&fit.material, &Goal::of_a_file(args.to), &table)
}

fn told(after: &Difference, residual: &Residuals) -> String {
    let mut text = format!("{:<21} {:>8}\n", "difference", "fit");
    for (name, value) in [
        ("all", after.all),
        ("white light", after.white),
        ("highlights", after.highlights),
        ("body", after.body),
    ] {
        text += &format!("{name:<21} {value:>8.4}\n");
    }
    text += &format!("{:<21} {:>8} {:>9} {:>10}\n", "error", "rms", "relative", "directions");
    for (name, errors) in [("white light", residual.white), ("one direction", residual.direct)] {
        let Errors { rms, relative, directions } = errors;
        text += &format!("{name:<21} {rms:>8.4} {:>7.1} % {directions:>10}\n", 100.0 * relative);
    }
    text
}

/// Spheres of the measurement and of the material side by side.
fn balls(
    args: &TranslateArgs,
    output: &Path,
    images: &[DisplayImage; 2],
    limits: &Limits,
) -> Result<(), Failure> {
    let cells = CellArgs::default();
    let mut sheet = ContactSheet::new(output, &[], args.report.json, 2, &cells, [BALL; 2], limits)?;
    for (image, name) in images.iter().zip(["measured", args.to.name()]) {
        sheet.add(&[image], [name, ""]);
    }
    sheet.write()
}
