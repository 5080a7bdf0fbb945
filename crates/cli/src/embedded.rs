//! Pictures that model files carry of themselves, in place of rendered ones.

use super::failure::Failure;
use super::output_file::OutputFile;
use super::render_task::RenderTask;
use super::report;
use overcoat_core::frame::DisplayImage;
use overcoat_description::is_standard_input;
use overcoat_load::{EmbeddedPicture, Warning, embedded_picture};
use overcoat_worker::picture_task::Pixels;
use overcoat_worker::report::Versions;
use serde::Serialize;

/// When the picture of a file is shown in place of its model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Embedded {
    /// Never.
    #[default]
    Never,
    /// Only if there is no model that can be drawn.
    WithoutModel,
    /// Always.
    Always,
}

/// Report of `--json` in place of the report of a rendered picture.
#[derive(Serialize)]
struct Report {
    /// Place of the picture in the file.
    embedded: String,
    width: u32,
    height: u32,
    warnings: Vec<String>,
    versions: Versions,
}

/// Writes the picture that a file carries of itself.
///
/// # Errors
/// [`Failure`] if there is none, or it cannot be written.
pub(super) fn show(task: &mut RenderTask, target: &OutputFile) -> Result<(), Failure> {
    let path = task.picture.source.path.clone();
    if is_standard_input(&path) {
        return Err(Failure::usage("--embedded is for files, not for standard input"));
    }
    let found = embedded_picture(&path, &task.picture.limits).map_err(|e| Failure::load(&e).at(&path))?;
    let picture = found.ok_or_else(|| Failure::failed("there is no picture in it").at(&path))?;
    write(task, target, &picture, "as --embedded asks")
}

/// Writes the picture that a file carries of itself because its model cannot be drawn. False if there is none, or it is not
/// wanted.
///
/// # Errors
/// [`Failure`] if it cannot be written.
pub(super) fn show_instead(task: &mut RenderTask, target: &OutputFile, why: &str) -> Result<bool, Failure> {
    let path = &task.picture.source.path;
    if task.embedded != Embedded::WithoutModel || is_standard_input(path) {
        return Ok(false);
    }
    let Ok(Some(picture)) = embedded_picture(path, &task.picture.limits) else { return Ok(false) };
    write(task, target, &picture, why)?;
    Ok(true)
}

fn write(
    task: &mut RenderTask,
    target: &OutputFile,
    picture: &EmbeddedPicture,
    why: &str,
) -> Result<(), Failure> {
    if target.format().is_linear() || !target.takes_image() {
        return Err(Failure::usage(
            "the picture in a file is for screens: .png, .webp or .jpg, without planes",
        ));
    }
    let EmbeddedPicture { place, image, .. } = picture;
    let warning = Warning::new(format!(
        "the file's own picture is shown ({place}, {} x {} pixels), {why}",
        image.width, image.height
    ));
    let mut fitted = picture.fitted([task.picture.options.width, task.picture.options.height]);
    if let Some(colour) = task.picture.display.background {
        lay_over(&mut fitted, colour);
    }
    let (width, height) = (fitted.width, fitted.height);
    let encoded = target.encode(&Pixels::Image(fitted), &task.picture.display)?;
    task.progress.finish();
    encoded.write()?;
    task.finish(std::slice::from_ref(&warning));
    if !task.json {
        return Ok(());
    }
    let (embedded, warnings) = (place.clone(), vec![warning.message]);
    report::print_json(&Report { embedded, width, height, warnings, versions: Versions::default() })
}

/// Puts a colour behind a picture, in codes as browsers do.
fn lay_over(image: &mut DisplayImage, colour: [u8; 3]) {
    for pixel in &mut image.pixels {
        let alpha = u32::from(pixel[3]);
        for (above, below) in pixel.iter_mut().zip(colour) {
            *above = ((u32::from(*above) * alpha + u32::from(below) * (255 - alpha) + 127) / 255) as u8;
        }
        pixel[3] = 255;
    }
}
