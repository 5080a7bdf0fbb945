//! `--sandbox`: what each command needs from the system, so that everything else can be given up before it reads.

use super::args::{Command, DrawArgs};
use super::failure::Failure;
use super::golden::{AcceptArgs, FolderArgs, GoldenArgs, GoldenCommand, ResultArgs};
use overcoat_core::jobs::MAX_THREADS;
use overcoat_description::{Description, EnvironmentChoice, is_standard_input, is_standard_stream};
use overcoat_image::output::destination;
use overcoat_load::has_folder;
use overcoat_sandbox::{Grants, SandboxError};
use overcoat_worker::resources;
use std::path::{Path, PathBuf};
use std::slice::from_ref;

/// Gives up every right that a command does not need.
///
/// # Errors
/// [`Failure`]; nothing has been read then.
pub(super) fn enter(command: &mut Command) -> Result<(), Failure> {
    // Both ask files of the system that will be out of reach.
    resources::keep_status_open();
    count_threads(command);
    let mut grants = writes(command);
    let Some(scene) = draw_of(command).and_then(|draw| draw.scene.clone()) else {
        reads(command, Description::default(), &mut grants);
        return overcoat_sandbox::enter(&grants).map(drop).map_err(|e| failure(&e));
    };
    // Names in a scene file are known once it has been read, and it may name any file. So while it is read, every file
    // can be read, and no more; then only what it names.
    let everything = Grants { read_folders: vec![PathBuf::from("/")], ..grants.clone() };
    let confined = overcoat_sandbox::enter(&everything).map_err(|e| failure(&e))?;
    let description = Description::open(&scene)?;
    // Not again: it may have come through a pipe, and may say something else by then.
    if let Some(draw) = draw_of(command) {
        draw.described = Some(Box::new(description.clone()));
    }
    grants.read_files.push(scene);
    reads(command, description, &mut grants);
    confined.narrow(&grants).map_err(|e| failure(&e))
}

/// The same, as far as this system lets it, for a command that has no scene file: what could not be given up, and why.
pub(super) fn enter_as_far_as_possible(command: &mut Command) -> Vec<SandboxError> {
    resources::keep_status_open();
    count_threads(command);
    let mut grants = writes(command);
    reads(command, Description::default(), &mut grants);
    overcoat_sandbox::enter_as_far_as_possible(&grants)
}

fn failure(error: &SandboxError) -> Failure {
    Failure::failed(error)
}

/// Files that a command that reads models was given.
pub(super) struct Files<'a> {
    pub(super) draw: Option<&'a DrawArgs>,
    pub(super) models: &'a [PathBuf],
    output: Option<&'a Path>,
}

impl<'a> Files<'a> {
    pub(super) fn of(command: &'a Command) -> Self {
        let (draw, models, output) = match command {
            Command::Render(a) => (Some(&a.model.draw), a.model.input.as_slice(), a.output.as_ref()),
            Command::Turntable(a) => (Some(&a.model.draw), a.model.input.as_slice(), Some(&a.movie.output)),
            Command::Animate(a) => (Some(&a.model.draw), a.model.input.as_slice(), Some(&a.movie.output)),
            Command::CompareModels(a) => (Some(&a.model.draw), a.model.input.as_slice(), Some(&a.output)),
            Command::Diagnose(a) => (Some(&a.model.draw), a.model.input.as_slice(), None),
            Command::Sheet(a) => (Some(&a.draw), a.inputs.as_slice(), Some(&a.output)),
            Command::Diff(a) => (Some(&a.draw), a.models.as_slice(), Some(&a.output)),
            Command::Bench(a) => (Some(&a.draw), a.inputs.as_slice(), None),
            Command::Thumbnail(a) => (None, from_ref(&a.input), Some(&a.output)),
            Command::Info(a) => (None, from_ref(&a.input), None),
            Command::Materials(a) => (None, [].as_slice(), a.output.as_ref()),
            Command::Lab(a) => (None, [].as_slice(), a.output.as_ref()),
            Command::Translate(a) => (None, [].as_slice(), a.output.as_ref()),
            Command::Conformance(_)
            | Command::Formats(_)
            | Command::Guide(_)
            | Command::Golden(_)
            | Command::Completions(_)
            | Command::Man(_)
            | Command::Batch(_)
            | Command::Serve(_)
            | Command::Mcp(_)
            | Command::Attempt(_) => (None, [].as_slice(), None),
        };
        Self { draw, models, output: output.map(PathBuf::as_path) }
    }
}

/// The options of drawing, if a command has them.
fn draw_of(command: &mut Command) -> Option<&mut DrawArgs> {
    match command {
        Command::Render(args) => Some(&mut args.model.draw),
        Command::Turntable(args) => Some(&mut args.model.draw),
        Command::Animate(args) => Some(&mut args.model.draw),
        Command::CompareModels(args) => Some(&mut args.model.draw),
        Command::Diagnose(args) => Some(&mut args.model.draw),
        Command::Diff(args) => Some(&mut args.draw),
        Command::Sheet(args) => Some(&mut args.draw),
        Command::Bench(args) => Some(&mut args.draw),
        _ => None,
    }
}

/// Puts the number of processors in place of 0. Where a group of processes has a share of them only, that is in files.
fn count_threads(command: &mut Command) {
    let workers = match command {
        Command::Render(args) => &mut args.model.draw.machine.workers,
        Command::Turntable(args) => &mut args.model.draw.machine.workers,
        Command::Animate(args) => &mut args.model.draw.machine.workers,
        Command::CompareModels(args) => &mut args.model.draw.machine.workers,
        Command::Diagnose(args) => &mut args.model.draw.machine.workers,
        Command::Diff(args) => &mut args.draw.machine.workers,
        Command::Sheet(args) => &mut args.draw.machine.workers,
        Command::Bench(args) => &mut args.draw.machine.workers,
        Command::Thumbnail(args) => &mut args.workers,
        Command::Info(args) => &mut args.workers,
        Command::Materials(args) => &mut args.machine.workers,
        Command::Golden(args) => match &mut args.command {
            GoldenCommand::Check(args) => &mut args.folders.workers,
            GoldenCommand::Report(args) => &mut args.folders.workers,
            GoldenCommand::Accept(args) => &mut args.folders.workers,
        },
        Command::Lab(args) => &mut args.workers,
        Command::Translate(args) => &mut args.workers,
        Command::Conformance(args) => &mut args.workers,
        Command::Formats(_)
        | Command::Guide(_)
        | Command::Completions(_)
        | Command::Man(_)
        | Command::Batch(_)
        | Command::Serve(_)
        | Command::Mcp(_)
        | Command::Attempt(_) => return,
    };
    if workers.threads == 0 {
        let processors = std::thread::available_parallelism();
        workers.threads = processors.map_or(1, |n| n.get().min(MAX_THREADS) as u16);
    }
}

/// The outputs of a command.
fn writes(command: &Command) -> Grants {
    let mut grants = Grants::default();
    let mut write = |path: &Path| {
        if !is_standard_stream(path) {
            grants.write(path);
            // The target of a link may not exist yet.
            grants.write(&destination(path).unwrap_or_else(|_| path.to_owned()));
        }
    };
    Files::of(command).output.into_iter().for_each(&mut write);
    match command {
        Command::Golden(args) => {
            let ResultArgs { json, junit, .. } = match &args.command {
                GoldenCommand::Check(args) => &args.results,
                GoldenCommand::Report(args) => {
                    write(&args.output);
                    &args.results
                }
                GoldenCommand::Accept(AcceptArgs { folders, .. }) => {
                    // Expected pictures are replaced, actual ones called x.new.png removed.
                    for path in [&folders.expected, &folders.actual] {
                        write(&if path.is_dir() { path.join("x") } else { path.clone() });
                    }
                    return grants;
                }
            };
            json.iter().chain(junit).for_each(|path| write(path));
        }
        Command::Translate(args) => args.picture.iter().for_each(|path| write(path)),
        Command::Conformance(args) => {
            let folder = &args.folder;
            write(&if folder.is_dir() { folder.join("x") } else { folder.clone() });
        }
        Command::Man(args) => args.dir.iter().for_each(|folder| write(&folder.join("x"))),
        Command::Attempt(args) => args.output.iter().for_each(|folder| write(&folder.join("x"))),
        _ => {}
    }
    grants
}

/// The inputs of a command, with those of its scene file.
fn reads(command: &Command, mut description: Description, grants: &mut Grants) {
    let Files { draw, models, .. } = Files::of(command);
    if let Some(draw) = draw {
        draw.apply(&mut description);
        // Not to be written: who has taken over the process could put another light there for those that follow.
        grants.read_folders.extend(draw.machine.cache.clone());
    }
    match command {
        Command::Materials(args) => {
            args.light.apply(&mut description);
            grants.read_folders.extend(args.machine.cache.clone());
        }
        Command::Golden(args) => read_pictures(args, grants),
        Command::Attempt(args) => grants.read_folders.extend(args.input.clone()),
        // To find out whether the folder is empty.
        Command::Conformance(args) => grants.read_folders.push(args.folder.clone()),
        Command::Lab(args) => {
            args.inputs().for_each(|path| read_model(path, grants));
        }
        Command::Translate(args) => {
            args.inputs().for_each(|path| read_model(path, grants));
        }
        _ => {}
    }
    read_models(models, &description, grants);
}

/// Models and what lights and covers them.
fn read_models(models: &[PathBuf], description: &Description, grants: &mut Grants) {
    // A model of the command line takes the place of the scene file's.
    let described = description.model.iter().filter(|_| models.is_empty());
    for path in models.iter().chain(described).filter(|path| !is_standard_input(path)) {
        read_model(path, grants);
    }
    if let Some(EnvironmentChoice::File(path)) = &description.env {
        grants.read_files.push(path.clone());
    }
    for choice in description.material_choices() {
        if let Some(path) = choice.source.file() {
            read_model(path, grants);
        }
    }
}

/// A model or a material. A pipe has no folder.
fn read_model(path: &Path, grants: &mut Grants) {
    if has_folder(path) {
        grants.read_with_folder(path);
    } else {
        grants.read_files.push(path.to_owned());
    }
}

/// Pictures that are compared.
fn read_pictures(args: &GoldenArgs, grants: &mut Grants) {
    let FolderArgs { expected, actual, thresholds, .. } = match &args.command {
        GoldenCommand::Check(args) => &args.folders,
        GoldenCommand::Report(args) => &args.folders,
        GoldenCommand::Accept(args) => &args.folders,
    };
    for path in [expected, actual] {
        // Either may be one picture.
        grants.read_folders.push(path.clone());
        grants.read_files.push(path.clone());
    }
    grants.read_files.extend(thresholds.clone());
}
