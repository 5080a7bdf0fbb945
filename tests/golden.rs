//! Every file of the folder `golden` is a test: the scene that it describes is rendered and compared, without
//! tolerance, with the recorded hash of the linear frame and the recorded picture, which is made of the frame and also
//! without one.
//!
//! A failure writes the picture, and a page that shows where it differs, to `target/golden-failures`. `UPDATE_GOLDENS=1` records instead, and fails: look at the pictures, then run again.

mod common;

use common::{Shot, goldens, scene_names};
use libtest_mimic::{Arguments, Failed, Trial};
use overcoat::description::Machine;
use overcoat::frame::DisplayImage;
use overcoat::golden::DescribedGolden;
use overcoat::render::Renderer;
use overcoat_core::math::lanes::SimdLevel;
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = match goldens() {
        Ok(goldens) => {
            let mut trials = vec![Trial::test("golden::every_scene_has_one", every_scene_has_one)];
            trials.extend(goldens.into_iter().map(|golden| {
                Trial::test(format!("golden::{}", golden.name()), move || {
                    check(&golden).map_err(Failed::from)
                })
            }));
            trials
        }
        Err(error) => vec![Trial::test("golden::folder", move || Err(Failed::from(error)))],
    };
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Renders one golden and compares or records it.
fn check(golden: &DescribedGolden) -> Result<(), String> {
    // Filtered environments stay with the renderer, so each is used again.
    static IDLE: Mutex<Vec<Renderer>> = Mutex::new(Vec::new());
    let idle = || IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut renderer = idle().pop().unwrap_or_else(|| Renderer::new(1));
    // The reference lanes where they are compiled in, else the best of the machine: all give these hashes.
    let simd = if SimdLevel::Scalar.is_available() { SimdLevel::Scalar } else { SimdLevel::best() };
    let machine = Machine::default().with_simd(simd);
    let shot = Shot::load(golden, machine, renderer.jobs())?;
    let rendered =
        renderer.render(&shot.scene, &shot.camera, &shot.options).map_err(|error| error.to_string())?;
    let hash = rendered.frame.frame_hash();
    let direct = renderer
        .render_image(&shot.scene, &shot.camera, &shot.options, &shot.display)
        .map_err(|error| error.to_string())?;
    idle().push(renderer);
    let image = DisplayImage::new(&rendered.frame, &shot.display);
    if direct.image != image {
        return Err("the picture without a frame is another one than that of the frame".to_owned());
    }
    if direct.tinted != rendered.frame.is_tinted() || direct.stats.fragments != rendered.stats.fragments {
        return Err("what is said of the picture without a frame differs".to_owned());
    }
    if std::env::var_os("UPDATE_GOLDENS").is_some_and(|value| value == "1") {
        return Err(golden.accept(&hash, &image).to_string());
    }
    let failures = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden-failures");
    golden.check(&hash, &image, &failures).map_err(|error| error.to_string())
}

/// A built-in scene that no golden shows tests nothing, and a folder without goldens is a mistake.
fn every_scene_has_one() -> Result<(), Failed> {
    let shown: Vec<String> = goldens()?.iter().map(|golden| golden.description().to_owned()).collect();
    let missing: Vec<&str> = scene_names()
        .into_iter()
        .filter(|name| !shown.iter().any(|text| text.contains(&format!("\"builtin:{name}\""))))
        .collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("no golden shows {}", missing.join(", ")).into()) }
}
