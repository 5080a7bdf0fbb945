//! `overcoat compare-models`: one scene as every engine would shade it, and how far each is from a chosen one.

use super::args::CompareModelsArgs;
use super::failure::{Failure, file_name};
use super::input;
use super::label::Sheet;
use super::materials::{MaterialChoice, Materials};
use super::progress::Progress;
use super::render::{describe, machine, model_source, nothing_to_see};
use super::report::{self, Reporter, Versions};
use super::sheet::{DEFAULT_CELL, Layout, PAPER};
use super::target::{Encoded, Target};
use crate::output::{DisplayImage, OutputFormat, encode_png_rgb};
use crate::render::Renderer;
use crate::scene::ShadingModel;
use serde::Serialize;

/// What differences are multiplied by in the picture.
const AMPLIFICATION: u16 = 4;

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    width: u32,
    height: u32,
    against: &'static str,
    models: Vec<ModelReport>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct ModelReport {
    model: &'static str,
    frame_hash: String,
    /// Of 255, over the pixels that the scene covers.
    mean_difference: f64,
    /// Of 255.
    max_difference: u8,
}

/// How two pictures differ.
struct Difference {
    pixels: Vec<[u8; 4]>,
    mean: f64,
    max: u8,
}

impl Difference {
    /// Absolute differences of the display values, amplified for the picture. Both pictures have the same coverage.
    fn new(a: &DisplayImage, b: &DisplayImage) -> Self {
        let (mut sum, mut covered, mut max) = (0_u64, 0_u64, 0);
        let mut pixels = Vec::with_capacity(a.pixels.len());
        for (p, q) in a.pixels.iter().zip(&b.pixels) {
            let d: [u8; 3] = std::array::from_fn(|k| p[k].abs_diff(q[k]));
            if p[3] > 0 {
                covered += 3;
                sum += d.iter().map(|&v| u64::from(v)).sum::<u64>();
                max = d.into_iter().fold(max, u8::max);
            }
            let [r, g, b] = d.map(|v| (u16::from(v) * AMPLIFICATION).min(255) as u8);
            pixels.push([r, g, b, p[3]]);
        }
        let mean = if covered == 0 { 0.0 } else { sum as f64 / covered as f64 };
        Self { pixels, mean, max }
    }
}

/// Renders one scene with many shading models to one sheet.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &CompareModelsArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    if args.picture.shading.is_some() {
        return Err(Failure::usage("--shading has no meaning here; --models chooses"));
    }
    let mut description = describe(args.scene.scene.as_deref(), args.input.as_deref())?;
    description.size = description.size.or(Some([DEFAULT_CELL; 2]));
    args.camera.apply(&mut description);
    args.light.apply(&mut description);
    args.picture.apply(&mut description);
    args.display.apply(&mut description);
    let source = model_source(&description, &args.input_options)?;
    let about_model = |failure: Failure| failure.at(&source.path);
    let mut inputs = vec![source.path.as_path()];
    inputs.extend(args.scene.scene.as_deref());
    let choices: Vec<MaterialChoice> = description.material_choices().collect();
    inputs.extend(choices.iter().filter_map(|choice| choice.source.file()));
    let target = Target::new(&args.output, None, &[], &inputs)?;
    if target.format() != OutputFormat::Png {
        return Err(Failure::usage("a sheet of models is a .png").at(&args.output));
    }
    if target.is_standard_output() && args.report.json {
        return Err(Failure::usage("--json and the sheet cannot both go to standard output"));
    }
    let mut models = args.models.clone();
    if models.is_empty() {
        models = ShadingModel::ALL.to_vec();
    }
    let mut seen = Vec::new();
    models.retain(|model| {
        !seen.contains(model) && {
            seen.push(*model);
            true
        }
    });

    let (mut options, display) = description.options(machine(&args.machine), &limits).map_err(about_model)?;
    let cell = [options.width, options.height.saturating_mul(2)];
    let layout = Layout::new(models.len(), args.columns, cell, &limits)?;
    let [width, height] = layout.size;
    let mut sheet = Sheet::new(width, height, PAPER).ok_or_else(|| {
        Failure::failed(format!("a sheet of {width} x {height} pixels does not fit into memory"))
    })?;

    progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let loaded = input::load(&source, &limits, renderer.jobs())?;
    let mut scene = loaded.scene;
    materials.assign(&mut scene, &limits).map_err(about_model)?;
    let mut warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    let doubts = description.light(&mut scene, &limits, renderer.jobs())?;
    warnings.extend(doubts.iter().map(ToString::to_string));
    let camera = description.camera(&scene, &options).map_err(about_model)?;

    let mut render = |model: ShadingModel| {
        options.shading = Some(model);
        let rendered =
            renderer.render(&scene, &camera, &options).map_err(|e| about_model(Failure::render(&e)))?;
        let image = DisplayImage::new(&rendered.frame, &display);
        Ok((image, rendered))
    };
    progress.stage(format!("rendering {}", args.against.name()));
    let (reference, rendered) = render(args.against)?;
    warnings.extend(nothing_to_see(&scene, &rendered.stats).map(|w| w.to_string()));
    let mut reports = Vec::new();
    for (k, &model) in models.iter().enumerate() {
        progress.stage(format!("{} of {}: {}", k + 1, models.len(), model.name()));
        let (image, rendered) = render(model)?;
        let difference = Difference::new(&image, &reference);
        let second = if model == args.against {
            "compared with".to_owned()
        } else {
            format!("mean {:.1}, largest {} of 255", difference.mean, difference.max)
        };
        let [x, y] = layout.label(&mut sheet, k, [model.name(), &second]);
        sheet.picture(x as i32, y as i32, image.width, image.height, &image.pixels);
        let below = (y + image.height) as i32;
        sheet.picture(x as i32, below, image.width, image.height, &difference.pixels);
        reports.push(ModelReport {
            model: model.name(),
            frame_hash: rendered.frame.frame_hash(),
            mean_difference: difference.mean,
            max_difference: difference.max,
        });
    }

    progress.stage("encoding");
    let bytes = encode_png_rgb(width, height, &sheet.into_rgb(), true)
        .map_err(|e| Failure::failed(e).at(&args.output))?;
    Encoded::new(args.output.clone(), bytes).write()?;
    drop(progress);
    for warning in &warnings {
        reporter.warning(warning);
    }
    if args.report.json {
        let against = args.against.name();
        report::print_json(&Report {
            width,
            height,
            against,
            models: reports,
            warnings,
            versions: Versions::default(),
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_count_covered_pixels_only() {
        let image = |pixels: Vec<[u8; 4]>| DisplayImage { width: pixels.len() as u32, height: 1, pixels };
        let a = image(vec![[10, 20, 30, 255], [0, 0, 0, 0]]);
        let b = image(vec![[13, 20, 130, 255], [0, 0, 0, 0]]);
        let difference = Difference::new(&a, &b);
        assert_eq!(difference.pixels, [[12, 0, 255, 255], [0; 4]]);
        assert_eq!((difference.mean, difference.max), (103.0 / 3.0, 100));
        assert_eq!(Difference::new(&image(Vec::new()), &image(Vec::new())).mean, 0.0);
    }
}
