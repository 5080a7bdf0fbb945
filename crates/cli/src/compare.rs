//! `overcoat compare-models`: one scene as every engine would shade it, and how far each is from a chosen one.

use super::args::CompareModelsArgs;
use super::contact::{ContactSheet, DEFAULT_CELL};
use super::failure::{Failure, file_name};
use super::render_task::RenderTask;
use super::report;
use overcoat_core::frame::DisplayImage;
use overcoat_load::Loaded;
use overcoat_scene::ShadingModel;
use overcoat_worker::camera_report::CameraReport;
use overcoat_worker::losses::{clipped, limited, lost_tint, lowered_exposure, texture_losses};
use overcoat_worker::report::{Stages, UpReport, Versions};
use serde::Serialize;

/// Factor of the differences in the picture.
const AMPLIFICATION: u16 = 4;

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    width: u32,
    height: u32,
    against: &'static str,
    /// Stops of all pictures.
    exposure: f32,
    #[serde(flatten)]
    up: UpReport,
    camera: CameraReport,
    models: Vec<ModelReport>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct ModelReport {
    model: &'static str,
    frame_hash: String,
    /// Mean difference, 0 to 255, over the pixels in which the scene shows, without its shadow on the ground.
    mean_difference: f64,
    /// Largest difference, 0 to 255.
    max_difference: u8,
}

/// Difference of two pictures.
struct Difference {
    image: DisplayImage,
    mean: f64,
    max: u8,
}

impl Difference {
    /// Absolute differences of the display values, amplified for the picture. The scene shows in `covered` pixels of either:
    /// what else they have in common, ground and background, counts neither as a difference nor as a pixel.
    fn new(a: &DisplayImage, b: &DisplayImage, covered: u64) -> Self {
        let (mut sum, mut max) = (0_u64, 0);
        let mut pixels = Vec::with_capacity(a.pixels.len());
        for (p, q) in a.pixels.iter().zip(&b.pixels) {
            let d: [u8; 3] = std::array::from_fn(|k| p[k].abs_diff(q[k]));
            if p[3] > 0 {
                sum += d.iter().map(|&v| u64::from(v)).sum::<u64>();
                max = d.into_iter().fold(max, u8::max);
            }
            let [r, g, b] = d.map(|v| (u16::from(v) * AMPLIFICATION).min(255) as u8);
            pixels.push([r, g, b, p[3]]);
        }
        let mean = if covered == 0 { 0.0 } else { sum as f64 / (3 * covered) as f64 };
        Self { image: DisplayImage { width: a.width, height: a.height, pixels }, mean, max }
    }
}

/// Renders one scene with many shading models to one sheet.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &CompareModelsArgs) -> Result<(), Failure> {
    let (draw, inputs) = (&args.model.draw, args.model.input.as_slice());
    if draw.options.has("shading") {
        return Err(Failure::usage("--shading has no meaning here; --models chooses"));
    }
    let mut models: Vec<ShadingModel> = Vec::new();
    let wanted = if args.models.is_empty() { ShadingModel::ALL } else { &args.models };
    for model in wanted {
        if !models.contains(model) {
            models.push(*model);
        }
    }
    let mut description = draw.describe(inputs)?;
    description.size.get_or_insert(DEFAULT_CELL);
    let mut task = RenderTask::new(draw, description, inputs)?;
    let cell = [task.picture.options.width, task.picture.options.height.saturating_mul(2)];
    let mut sheet = ContactSheet::new(
        &args.output,
        &task.inputs,
        task.json,
        models.len(),
        &args.cells,
        cell,
        &task.picture.limits,
    )?;

    task.progress.stage(format!("loading {}", file_name(&task.picture.source.path)));
    let mut renderer = draw.renderer();
    let Loaded { scene, mut warnings, .. } = task.picture.load(renderer.jobs(), &mut Stages::default())?;
    let camera = task.picture.camera(&task.picture.source, &scene)?;
    let display = task.picture.display_of(&scene);
    let mut done = 0;
    let mut render = |model: ShadingModel| {
        task.progress.step(format!("rendering {}", model.name()), done, 1 + models.len() as u32);
        done += 1;
        task.picture.options.shading = Some(model);
        let rendered = task.picture.render(&task.picture.source, &mut renderer, &scene, &camera)?;
        // The first one is what others are compared with, at one exposure.
        task.picture.display = task.picture.display_of(&scene).metered(&rendered.frame);
        Ok::<_, Failure>((DisplayImage::new(&rendered.frame, &task.picture.display), rendered))
    };
    let (reference, rendered) = render(args.against)?;
    let mut reports = Vec::new();
    for &model in &models {
        let (image, rendered) = render(model)?;
        let difference = Difference::new(&image, &reference, rendered.stats.covered);
        let second = if model == args.against {
            "compared with".to_owned()
        } else {
            format!("mean {:.1}, largest {} of 255", difference.mean, difference.max)
        };
        sheet.add(&[&image, &difference.image], [model.name(), &second]);
        reports.push(ModelReport {
            model: model.name(),
            frame_hash: rendered.frame.frame_hash(),
            mean_difference: difference.mean,
            max_difference: difference.max,
        });
    }
    warnings.extend(texture_losses(&scene, &warnings));
    let clipping = task.picture.clipping(&scene, &rendered.frame);
    warnings.extend(lowered_exposure(&display, task.picture.display.exposure));
    warnings.extend(clipped(&scene, &task.picture.display, clipping));
    warnings.extend(limited(&rendered.stats));
    warnings.extend(lost_tint(rendered.frame.is_tinted(), &task.picture.display));
    match task.picture.check_coverage(&task.picture.source, &scene, &camera, &rendered.stats) {
        Ok(warning) => warnings.extend(warning),
        Err(failure) => {
            task.finish(&warnings);
            return Err(failure);
        }
    }

    task.progress.stage("encoding");
    let [width, height] = sheet.size();
    sheet.write()?;
    task.finish(&warnings);
    task.note_up(scene.orientation());
    if task.json {
        report::print_json(&Report {
            width,
            height,
            against: args.against.name(),
            exposure: task.picture.display.exposure,
            up: UpReport::from(scene.orientation()),
            camera: CameraReport::new(&camera, &scene, &task.picture.options),
            models: reports,
            warnings: warnings.iter().map(ToString::to_string).collect(),
            versions: Versions::default(),
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_a_mean_over_covered_pixels() {
        let image = |pixels: Vec<[u8; 4]>| DisplayImage { width: pixels.len() as u32, height: 1, pixels };
        let a = image(vec![[10, 20, 30, 255], [0, 0, 0, 0]]);
        let b = image(vec![[13, 20, 130, 255], [0, 0, 0, 0]]);
        let difference = Difference::new(&a, &b, 1);
        assert_eq!(difference.image.pixels, [[12, 0, 255, 255], [0; 4]]);
        assert_eq!((difference.mean, difference.max), (103.0 / 3.0, 100));
        assert_eq!(Difference::new(&image(Vec::new()), &image(Vec::new()), 0).mean, 0.0);
    }
}
