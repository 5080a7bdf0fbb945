//! The files of the pack.

use super::score::{Score, score, tolerance};
use super::{Entry, VERSION, describe};
use crate::failure::{self, Failure};
use crate::progress::Progress;
use half::f16;
use overcoat_image::output::{ExrPrecision, OutputError, encode_exr_channels};
use overcoat_lab::lab::conformance::{Engines, MAP_HEIGHT, MAP_WIDTH, Planes, Scene, Sky, Truth};
use overcoat_scene::ShadingModel;
use std::fmt::Write;

/// Files of the pack that are written by hand.
const README: &str = include_str!("pack/README.md");
const LICENSE: &str = include_str!("pack/LICENSE");
const SCORE: &str = include_str!("pack/score.py");

/// A path in the pack, and what is there.
pub(super) type File = (String, Vec<u8>);

/// Options of the pack.
pub(super) struct Request<'a> {
    pub scenes: &'a [Scene],
    pub models: &'a [ShadingModel],
    /// Side of the pictures in pixels.
    pub size: u32,
    /// Walks of each pixel.
    pub samples: u32,
    pub seed: u32,
    /// True for a second truth of scenes that have one.
    pub one_bounce: bool,
}

/// The truth as its file has it.
pub(super) struct Planes32 {
    pub mean: Vec<[f32; 3]>,
    pub variance: Vec<[f32; 3]>,
    pub footprint: Vec<[f32; 3]>,
    pub mask: Vec<bool>,
}

impl Planes32 {
    fn new(truth: &Truth) -> Self {
        let narrow = |plane: &[[f64; 3]]| plane.iter().map(|v| v.map(|c| c as f32)).collect();
        Self {
            mean: narrow(&truth.mean),
            variance: narrow(&truth.variance),
            footprint: narrow(&truth.footprint),
            mask: truth.mask.clone(),
        }
    }

    /// Number of scored pixels.
    pub fn scored(&self) -> usize {
        self.mask.iter().filter(|mask| **mask).count()
    }
}

/// Everything, in the order in which it is written, and how the models do.
///
/// # Errors
/// [`Failure`] of scenes and pictures that cannot be made.
pub(super) fn make(
    request: &Request,
    engines: &mut Engines,
    progress: &Progress,
) -> Result<(Vec<File>, Vec<Entry>), Failure> {
    let size = request.size as usize;
    let mut files = vec![
        ("README.md".to_owned(), README.replace("{version}", VERSION).into_bytes()),
        ("LICENSE".to_owned(), LICENSE.as_bytes().to_vec()),
        ("score.py".to_owned(), SCORE.as_bytes().to_vec()),
        ("scenes.tsv".to_owned(), list(request.scenes).into_bytes()),
        ("aov.exr".to_owned(), exr("aov.exr", [size; 2], planes(&Planes::new(size)), ExrPrecision::Float)?),
    ];
    let ball = Engines::ball().map_err(|e| Failure::scene(&e))?;
    files.push(("scenes/ball.bin".to_owned(), describe::buffer(&ball)));
    for sky in Sky::MAPS {
        let name = format!("environments/{}.exr", sky.name());
        let channels = rgb(["R", "G", "B"], &sky.map());
        files.push((name.clone(), exr(&name, [MAP_WIDTH, MAP_HEIGHT], channels, ExrPrecision::Float)?));
    }
    let mut scores = Vec::new();
    let of = (request.scenes.len() * size) as u32;
    for (number, scene) in request.scenes.iter().enumerate() {
        let name = scene.name;
        let description = describe::description(scene);
        files.push((format!("scenes/{name}.json"), describe::text(&description)));
        files.push((
            format!("scenes/{name}.gltf"),
            describe::text(&describe::gltf(scene, &ball, description)),
        ));
        let done = |rows: usize| progress.step(name, (number * size + rows) as u32, of);
        let truth = Truth::new(scene, size, [request.samples, request.seed], engines.jobs(), done);
        let truth = Planes32::new(&truth.map_err(|e| failure::lab(&e.into()))?);
        let path = format!("truth/{name}.exr");
        files.push((path.clone(), exr(&path, [size; 2], channels(&truth), ExrPrecision::Float)?));
        let one = if request.one_bounce && scene.has_truth_of_one_bounce() {
            let walks = [request.samples, request.seed];
            let one = Truth::of_one_bounce(scene, size, walks, engines.jobs(), |_| ());
            let one = Planes32::new(&one.map_err(|e| failure::lab(&e.into()))?);
            let path = format!("one-bounce/{name}.exr");
            files.push((path.clone(), exr(&path, [size; 2], channels(&one), ExrPrecision::Float)?));
            Some(one)
        } else {
            None
        };
        for &model in request.models {
            let picture = engines.picture(scene, model, size).map_err(|e| failure::lab(&e))?;
            // As the file has it.
            let picture: Vec<[f32; 3]> =
                picture.into_iter().map(|p| p.map(|v| f16::from_f32(v).to_f32())).collect();
            let path = format!("engines/{}/{name}.exr", model.name());
            let bytes = exr(&path, [size; 2], rgb(["R", "G", "B"], &picture), ExrPrecision::Half)?;
            files.push((path, bytes));
            let one_bounce = one.as_ref().map(|one| score(one, size, &picture));
            let score = score(&truth, size, &picture);
            scores.push(Entry { model: model.name(), scene: name, score, one_bounce });
        }
    }
    files.push(("engines/scores.tsv".to_owned(), tsv(&scores).into_bytes()));
    // Last: a folder that has it is whole, and without it `score.py` does nothing.
    files.push(("VERSION".to_owned(), version(request).into_bytes()));
    Ok((files, scores))
}

/// Which pack this is. `score.py` reads the first line.
fn version(request: &Request) -> String {
    format!(
        "overcoat conformance pack {VERSION}\nmade by overcoat {}\nsize {}\nsamples {}\nseed {}\n",
        env!("CARGO_PKG_VERSION"),
        request.size,
        request.samples,
        request.seed
    )
}

/// Names with what they are for. `score.py` reads the first column.
fn list(scenes: &[Scene]) -> String {
    let mut text = "scene\tlight\tplain\tabout\n".to_owned();
    for scene in scenes {
        // Writing to a string cannot fail.
        let plain = if scene.is_plain() { "yes" } else { "no" };
        let _ = writeln!(text, "{}\t{}\t{plain}\t{}", scene.name, scene.sky.name(), scene.about);
    }
    text
}

/// Scores as `score.py --tsv` writes them, with the model before.
fn tsv(scores: &[Entry]) -> String {
    let mut text =
        "model\tscene\tverdict\tbias\terror\tnoise\trmse\tflip\tz_mean\tz_square\tpixels\tblocks\twhole\t\
         one_verdict\tone_bias\tone_error\n"
            .to_owned();
    for Entry { model, scene, score, one_bounce } in scores {
        let Score { passes, bias, error, noise, rmse, flip, z_mean, z_square, pixels, blocks, whole } =
            *score;
        let verdict = |passes| if passes { "pass" } else { "fail" };
        let _ = write!(text, "{model}\t{scene}\t{}", verdict(passes));
        for number in [bias, error, noise, rmse, flip, z_mean, z_square, pixels, blocks, whole] {
            let _ = write!(text, "\t{number:.6}");
        }
        let _ = match one_bounce {
            Some(one) => writeln!(text, "\t{}\t{:.6}\t{:.6}", verdict(one.passes), one.bias, one.error),
            None => writeln!(text, "\t-\t-\t-"),
        };
    }
    text
}

type Channel<'a> = (&'a str, Vec<f32>);

fn rgb<'a>(names: [&'a str; 3], pixels: &[[f32; 3]]) -> Vec<Channel<'a>> {
    let channel = |c: usize| (names[c], pixels.iter().map(|p| p[c]).collect());
    (0..3).map(channel).collect()
}

fn channels(truth: &Planes32) -> Vec<Channel<'static>> {
    let mut channels = rgb(["R", "G", "B"], &truth.mean);
    channels.extend(rgb(["variance.R", "variance.G", "variance.B"], &truth.variance));
    channels.extend(rgb(["footprint.R", "footprint.G", "footprint.B"], &truth.footprint));
    channels.extend(rgb(["tolerance.R", "tolerance.G", "tolerance.B"], &tolerance(truth)));
    channels.push(("mask.Y", truth.mask.iter().map(|mask| f32::from(u8::from(*mask))).collect()));
    channels
}

fn planes(planes: &Planes) -> Vec<Channel<'static>> {
    let narrow =
        |plane: &[[f64; 3]]| -> Vec<[f32; 3]> { plane.iter().map(|v| v.map(|c| c as f32)).collect() };
    let single = |plane: &[f64]| plane.iter().map(|v| *v as f32).collect();
    let mut channels = rgb(["normal.X", "normal.Y", "normal.Z"], &narrow(&planes.normal));
    channels.extend(rgb(["position.X", "position.Y", "position.Z"], &narrow(&planes.position)));
    channels.push(("depth.Z", single(&planes.depth)));
    channels.push(("coverage.Y", single(&planes.coverage)));
    channels
}

fn exr(
    name: &str,
    size: [usize; 2],
    channels: Vec<Channel>,
    precision: ExrPrecision,
) -> Result<Vec<u8>, Failure> {
    let failed = |error: OutputError| Failure::failed(format!("{name}: {error}"));
    encode_exr_channels(size, channels, precision).map_err(failed)
}
