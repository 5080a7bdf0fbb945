//! Every golden scene has one hash, whatever the number of threads, the side of the tiles and the instruction set.
//!
//! Threads {1, 2, 3, 7}, tiles {16, 32, 64} and the instruction sets of this machine are combined so that every pair
//! of values of two of them occurs (a covering array, not all products). G-buffer planes are compared too, in every
//! bit, and what each stage hands to the next, so that a failure names the stage; and pictures for a screen that are made
//! without a frame. A level that the machine lacks is not tested here: another machine's run is.

mod common;

use common::{Shot, goldens};
use libtest_mimic::{Arguments, Failed, Trial};
use overcoat::description::Machine;
use overcoat::frame::{Aov, AovPlane, DisplayImage, Frame};
use overcoat::golden::DescribedGolden;
use overcoat::render::{Rendered, Renderer, WorkDone};
use overcoat_core::math::lanes::SimdLevel;
use std::collections::BTreeSet;
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

const THREADS: [usize; 4] = [1, 2, 3, 7];
const TILES: [u32; 3] = [16, 32, 64];

/// One renderer for each number of threads, so that environments are filtered once for each (and, by the order of
/// [`combinations`], at a different instruction set for each).
static RENDERERS: Mutex<Vec<Renderer>> = Mutex::new(Vec::new());

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    // The renderers have threads of their own.
    arguments.test_threads = Some(1);
    let mut trials = vec![Trial::test("determinism::all_pairs_are_covered", all_pairs_are_covered)];
    match goldens() {
        Ok(goldens) => trials.extend(goldens.into_iter().map(|golden| {
            let name = format!("determinism::{}", golden.name());
            Trial::test(name, move || one_hash(&golden).map_err(Failed::from))
        })),
        Err(error) => trials.push(Trial::test("determinism::folder", move || Err(Failed::from(error)))),
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Indices of threads, tile sizes and levels in which every pair of two occurs.
fn combinations(levels: usize) -> Vec<[usize; 3]> {
    // Rows of a Latin rectangle: threads and levels in all pairs, diagonal by diagonal; the tile size moves with
    // both, so that it meets each value of either.
    let columns = levels.max(TILES.len());
    (0..columns)
        .flat_map(|shift| {
            (0..THREADS.len()).map(move |thread| {
                let column = (thread + shift) % columns;
                [thread, (thread + column) % TILES.len(), column % levels]
            })
        })
        .collect()
}

fn all_pairs_are_covered() -> Result<(), Failed> {
    for levels in 1..=SimdLevel::ALL.len() {
        let sizes = [THREADS.len(), TILES.len(), levels];
        let rows = combinations(levels);
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let seen: BTreeSet<_> = rows.iter().map(|row| (row[a], row[b])).collect();
            if seen.len() != sizes[a] * sizes[b] {
                return Err(format!("{levels} levels: {} pairs of {a} and {b}", seen.len()).into());
            }
        }
    }
    Ok(())
}

fn one_hash(golden: &DescribedGolden) -> Result<(), String> {
    let mut renderers = RENDERERS.lock().unwrap_or_else(PoisonError::into_inner);
    if renderers.is_empty() {
        renderers.extend(THREADS.map(Renderer::new));
    }
    let levels: Vec<SimdLevel> = SimdLevel::available().collect();
    let mut shot = Shot::load(golden, Machine::default(), renderers[1].jobs())?;
    shot.options.aovs = Aov::ALL.to_vec();
    shot.options.stage_hashes = true;
    let mut first: Option<(String, Rendered)> = None;
    let mut images: Option<DisplayImage> = None;
    let mut work: Option<WorkDone> = None;
    for [thread, tile, level] in combinations(levels.len()) {
        shot.options.tile_size = Some(TILES[tile]);
        shot.options.simd = levels[level];
        let setting =
            format!("{} threads, tiles of {}, {}", THREADS[thread], TILES[tile], levels[level].name());
        let rendered = renderers[thread]
            .render(&shot.scene, &shot.camera, &shot.options)
            .map_err(|error| format!("{setting}: {error}"))?;
        if *work.get_or_insert_with(|| renderers[thread].work_done()) != renderers[thread].work_done() {
            return Err(format!(
                "{setting}: the work differs, {work:?} and {:?}",
                renderers[thread].work_done()
            ));
        }
        // With hashes of the stages a picture for a screen has a frame beside it.
        let options = shot.options.clone().with_stage_hashes(false);
        let direct = renderers[thread]
            .render_image(&shot.scene, &shot.camera, &options, &shot.display)
            .map_err(|error| format!("{setting}: {error}"))?;
        let bits = |planes: &[AovPlane]| -> Vec<u32> {
            let bits = |plane: &AovPlane| {
                plane.data.iter().map(|v| v.to_bits()).chain(plane.ids.clone()).collect::<Vec<_>>()
            };
            planes.iter().flat_map(bits).collect()
        };
        if bits(&direct.aovs) != bits(&rendered.frame.aovs) {
            return Err(format!("{setting}: planes differ without a frame"));
        }
        if work.is_some_and(|work| work != renderers[thread].work_done()) {
            return Err(format!("{setting}: the work differs without a frame"));
        }
        if images.get_or_insert_with(|| direct.image.clone()) != &direct.image {
            return Err(format!("{setting}: the picture without a frame differs"));
        }
        // Display development of the frame at this level.
        let display = shot.display.clone().with_simd(levels[level]);
        if DisplayImage::new(&rendered.frame, &display) != direct.image {
            return Err(format!("{setting}: the picture of the frame is another one than that without"));
        }
        match &first {
            None => first = Some((setting, rendered)),
            Some((reference, expected)) => {
                if let Some(what) = difference(expected, &rendered) {
                    return Err(format!("{what} differs between [{reference}] and [{setting}]"));
                }
            }
        }
    }
    Ok(())
}

/// The first thing in which two renders differ.
fn difference(a: &Rendered, b: &Rendered) -> Option<String> {
    let stage = a.stats.stage_hashes.zip(b.stats.stage_hashes).and_then(|(a, b)| a.first_difference(&b));
    let what = frame_difference(&a.frame, &b.frame);
    match (stage, what) {
        (None, what) => what,
        (Some(stage), None) => Some(format!("stage {stage}")),
        (Some(stage), Some(what)) => Some(format!("stage {stage}, then {what}")),
    }
}

/// The first thing in which two frames differ.
fn frame_difference(a: &Frame, b: &Frame) -> Option<String> {
    let bits = |data: &[f32]| -> Vec<u32> { data.iter().map(|v| v.to_bits()).collect() };
    if a.frame_hash() != b.frame_hash() {
        let count = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count();
        let at = a.pixels.iter().zip(&b.pixels).position(|(a, b)| a != b).unwrap_or(0);
        let (x, y) = (at % a.width as usize, at / a.width as usize);
        return Some(format!("the picture ({count} pixels, first at {x}, {y})"));
    }
    a.aovs
        .iter()
        .zip(&b.aovs)
        .find(|(a, b)| a.aov != b.aov || a.ids != b.ids || bits(&a.data) != bits(&b.data))
        .map(|(a, _)| format!("plane {}", a.aov.name()))
}
