//! `overcoat diff`: two models from one camera, side by side, and how they differ.

use super::args::DiffArgs;
use super::contact::ContactSheet;
use super::failure::{Failure, file_name};
use super::output_file::is_standard_output;
use super::render_task::RenderTask;
use super::report;
use overcoat_core::frame::DisplayImage;
use overcoat_golden::metrics::{MetricSettings, Metrics, measure};
use overcoat_image::decode::DecodedPicture;
use overcoat_load::Loaded;
use overcoat_render::Rendered;
use overcoat_scene::{Camera, Fit, PrimitiveKind, Scene};
use overcoat_worker::camera_report::CameraReport;
use overcoat_worker::losses::{clipped, limited, lost_tint, lowered_exposure, texture_losses};
use overcoat_worker::model_source::ModelSource;
use overcoat_worker::report::{Stages, Versions};
use serde::Serialize;

/// Factor of the differences in the picture.
const AMPLIFICATION: u16 = 4;
/// Width and height of each picture where none are given.
pub(super) const DEFAULT_SIDE: [u64; 2] = [512; 2];

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    width: u32,
    height: u32,
    before: SideReport,
    after: SideReport,
    /// True if the pictures are equal in every bit of their linear light.
    equal: bool,
    /// Pixels of the pictures for screens that differ, and all of one.
    differing_pixels: u64,
    pixels: u64,
    /// Largest difference, 0 to 255.
    max_difference: f64,
    /// Decibels; nothing where the pictures are equal.
    psnr: Option<f64>,
    ssim: f64,
    /// 0 to 1.
    flip: f64,
    /// Stops of both pictures.
    exposure: f32,
    camera: CameraReport,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct SideReport {
    file: String,
    frame_hash: String,
    triangles: u64,
    lines: u64,
    points: u64,
    splats: u64,
    draws: usize,
    materials: usize,
    textures: usize,
    lights: usize,
    /// Width, height and depth in metres.
    bounds: [f64; 3],
}

impl SideReport {
    fn new(source: &ModelSource, scene: &Scene, rendered: &Rendered) -> Self {
        let bounds = scene.bounds();
        Self {
            file: file_name(&source.path),
            frame_hash: rendered.frame.frame_hash(),
            triangles: scene.count_of(PrimitiveKind::Triangles),
            lines: scene.count_of(PrimitiveKind::Lines),
            points: scene.count_of(PrimitiveKind::Points),
            splats: scene.splat_count(),
            draws: scene.instances().len(),
            materials: scene.materials().len(),
            textures: scene.textures().len(),
            lights: scene.lights().len(),
            bounds: if bounds.is_empty() { [0.0; 3] } else { bounds.size() },
        }
    }

    /// In a line.
    fn line(&self) -> String {
        let Self { triangles, materials, textures, .. } = self;
        format!("{triangles} triangles, {materials} materials, {textures} textures")
    }
}

/// Absolute differences of what a screen shows, amplified, on black.
fn difference(a: &DisplayImage, b: &DisplayImage) -> DisplayImage {
    let one = |(p, q): (&[u8; 4], &[u8; 4])| {
        // Multiplied by alpha, so that a shape shows where there is nothing in the other.
        let of = |pixel: &[u8; 4], k: usize| (u16::from(pixel[k]) * u16::from(pixel[3]) + 127) / 255;
        let rgb: [u16; 3] = std::array::from_fn(|k| of(p, k).abs_diff(of(q, k)));
        let alpha = u16::from(p[3].abs_diff(q[3]));
        let [r, g, b] = rgb.map(|v| (v.max(alpha / 4) * AMPLIFICATION).min(255) as u8);
        [r, g, b, 255]
    };
    DisplayImage {
        width: a.width,
        height: a.height,
        pixels: a.pixels.iter().zip(&b.pixels).map(one).collect(),
    }
}

/// One camera for both, unless there is one already.
fn camera(task: &RenderTask, before: &Scene, after: &Scene) -> Result<Camera, Failure> {
    let Some(framing) = task.picture.description.framing(before, &task.picture.options) else {
        return task.picture.camera(&task.picture.source, before);
    };
    let mut fit = Fit::new(framing);
    fit.include(before);
    fit.include(after);
    Ok(task.picture.description.fitted(fit.camera()).map_err(|error| error.at(&task.picture.source.path))?)
}

/// Renders two models to one sheet and says how they differ.
///
/// # Errors
/// [`Failure`]; nothing is written then, but for pictures that differ where that is asked for.
pub fn run(args: &DiffArgs) -> Result<(), Failure> {
    let inputs = args.models.as_slice();
    let mut description = args.draw.describe(inputs)?;
    description.size.get_or_insert(DEFAULT_SIDE);
    let mut task = RenderTask::new(&args.draw, description, inputs)?;
    let cell = [task.picture.options.width, task.picture.options.height];
    let mut sheet =
        ContactSheet::new(&args.output, &task.inputs, task.json, 3, &args.cells, cell, &task.picture.limits)?;
    let Some(after) = task.more.pop() else { return Err(Failure::usage("two models are compared")) };

    let mut renderer = args.draw.renderer();
    let setting = task.picture.setting(renderer.jobs())?;
    let load = |source: &ModelSource| {
        task.progress.stage(format!("loading {}", file_name(&source.path)));
        task.picture.load_into(&setting, source, renderer.jobs(), &mut Stages::default())
    };
    let Loaded { scene: first, mut warnings, .. } = load(&task.picture.source)?;
    let Loaded { scene: second, warnings: more, .. } = load(&after)?;
    warnings.extend(more);
    let camera = camera(&task, &first, &second)?;
    // One floor under both.
    if task.picture.options.ground.is_seen() {
        task.picture.options.ground_under = Some(first.tight_bounds().union(&second.tight_bounds()));
    }
    task.progress.step("rendering", 0, 2);
    let own = task.picture.render(&task.picture.source, &mut renderer, &first, &camera)?;
    let display = task.picture.display_of(&first);
    task.picture.display = display.metered(&own.frame);
    warnings.extend(lowered_exposure(&display, task.picture.display.exposure));
    task.progress.step("rendering", 1, 2);
    let other = task.picture.render(&after, &mut renderer, &second, &camera)?;
    for (source, scene, rendered) in [(&task.picture.source, &first, &own), (&after, &second, &other)] {
        warnings.extend(texture_losses(scene, &warnings));
        warnings.extend(clipped(scene, &task.picture.display, task.picture.clipping(scene, &rendered.frame)));
        warnings.extend(limited(&rendered.stats));
        warnings.extend(lost_tint(rendered.frame.is_tinted(), &task.picture.display));
        warnings.extend(task.picture.check_coverage(source, scene, &camera, &rendered.stats)?);
    }

    let images = [&own, &other].map(|rendered| DisplayImage::new(&rendered.frame, &task.picture.display));
    let [before, after_image] = &images;
    let measured = measure(&before.into(), &DecodedPicture::from(after_image), &MetricSettings::default());
    let Metrics { exact, psnr, ssim, flip_mean, .. } =
        measured.map_err(|error| Failure::failed(error.to_string()))?.metrics;
    let equal = own.frame.frame_hash() == other.frame.frame_hash();
    let [one, two] = [(&task.picture.source, &first, &own), (&after, &second, &other)]
        .map(|(s, c, r)| SideReport::new(s, c, r));
    let pixels = before.pixels.len() as u64;
    let summary = if equal {
        "equal in every bit".to_owned()
    } else {
        let part = 100.0 * exact.pixels as f64 / pixels as f64;
        format!("{part:.2} % of pixels, up to {} of 255; FLIP {flip_mean:.4}", exact.max_abs)
    };
    sheet.add(&[before], [&one.file, &one.line()]);
    sheet.add(&[after_image], [&two.file, &two.line()]);
    sheet.add(&[&difference(before, after_image)], ["difference, four times as strong", &summary]);
    task.progress.stage("encoding");
    let [width, height] = sheet.size();
    sheet.write()?;
    task.finish(&warnings);
    if task.json {
        report::print_json(&Report {
            width,
            height,
            before: one,
            after: two,
            equal,
            differing_pixels: exact.pixels,
            pixels,
            max_difference: exact.max_abs,
            psnr: psnr.is_finite().then_some(psnr),
            ssim,
            flip: flip_mean,
            exposure: task.picture.display.exposure,
            camera: CameraReport::new(&camera, &first, &task.picture.options),
            warnings: warnings.iter().map(ToString::to_string).collect(),
            versions: Versions::default(),
        })?;
    } else if !args.draw.report.quiet && !is_standard_output(&args.output) {
        report::print(&format!("{summary}\n"))?;
    }
    if args.exit_code && !equal {
        Err(Failure::differ(format!("the pictures differ: {summary}")))
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_only_one_picture_has_shows_in_the_difference() {
        let image = |pixels: Vec<[u8; 4]>| DisplayImage { width: pixels.len() as u32, height: 1, pixels };
        let a = image(vec![[10, 20, 30, 255], [0; 4], [0, 0, 0, 255], [7, 7, 7, 255]]);
        let b = image(vec![[13, 20, 130, 255], [0; 4], [0; 4], [7, 7, 7, 255]]);
        let shown = difference(&a, &b).pixels;
        assert_eq!(shown, [[12, 0, 255, 255], [0, 0, 0, 255], [252, 252, 252, 255], [0, 0, 0, 255]]);
        assert_eq!(difference(&b, &a).pixels, shown);
    }
}
