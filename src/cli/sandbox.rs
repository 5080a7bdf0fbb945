//! `--sandbox`: what each command needs from the system, so that everything else can be given up before it reads.

use super::args::{
    AnimateArgs, AttemptArgs, BenchArgs, Command, CompareModelsArgs, LightArgs, RenderArgs, TurntableArgs,
};
use super::failure::Failure;
use super::golden::{AcceptArgs, FolderArgs, GoldenArgs, GoldenCommand, ResultArgs};
use super::picture::is_standard_stream;
use super::report;
use super::scene_file::{EnvironmentChoice, SceneFile};
use crate::sandbox::{self, Grants, SandboxError};
use std::path::{Path, PathBuf};

/// Gives up every right that a command does not need.
///
/// # Errors
/// [`Failure`]; nothing has been read then.
pub(super) fn enter(command: &mut Command) -> Result<(), Failure> {
    // Both ask files of the system that will be out of reach.
    report::keep_status_open();
    count_threads(command);
    let mut grants = writes(command);
    let Some(scene) = scene_file(command).map(Path::to_owned) else {
        reads(command, &SceneFile::default(), &mut grants);
        return sandbox::enter(&grants).map(drop).map_err(|e| failure(&e));
    };
    // What a scene file names is known once it has been read, and it may name any file. So while it is read, every file
    // can be read, and no more; then only what it names.
    let everything = Grants { read_folders: vec![PathBuf::from("/")], ..grants.clone() };
    let confined = sandbox::enter(&everything).map_err(|e| failure(&e))?;
    let description = SceneFile::open(&scene)?;
    grants.read_files.push(scene);
    reads(command, &description, &mut grants);
    confined.narrow(&grants).map_err(|e| failure(&e))
}

fn failure(error: &SandboxError) -> Failure {
    Failure::failed(error)
}

/// Puts the number of processors in place of 0. Where a group of processes has a share of them only, that is in files.
fn count_threads(command: &mut Command) {
    let threads = match command {
        Command::Render(args) => &mut args.machine.threads,
        Command::Turntable(args) => &mut args.machine.threads,
        Command::Animate(args) => &mut args.machine.threads,
        Command::Info(args) => &mut args.threads,
        Command::Sheet(args) => &mut args.machine.threads,
        Command::Bench(args) => &mut args.machine.threads,
        Command::CompareModels(args) => &mut args.machine.threads,
        Command::Materials(args) => &mut args.machine.threads,
        Command::Golden(args) => match &mut args.command {
            GoldenCommand::Check(args) => &mut args.folders.threads,
            GoldenCommand::Report(args) => &mut args.folders.threads,
            GoldenCommand::Accept(args) => &mut args.folders.threads,
        },
        Command::Attempt(_) => return,
    };
    if *threads == 0 {
        *threads = std::thread::available_parallelism().map_or(1, |n| u16::try_from(n.get()).unwrap_or(1024));
    }
}

/// The scene file of a command.
fn scene_file(command: &Command) -> Option<&Path> {
    match command {
        Command::Render(args) => args.scene.scene.as_deref(),
        Command::Turntable(args) => args.scene.scene.as_deref(),
        Command::Animate(args) => args.scene.scene.as_deref(),
        Command::Bench(args) => args.scene.scene.as_deref(),
        Command::CompareModels(args) => args.scene.scene.as_deref(),
        _ => None,
    }
}

/// The outputs of a command.
fn writes(command: &Command) -> Grants {
    let mut grants = Grants::default();
    let mut write = |path: &Path| {
        if !is_standard_stream(path) {
            grants.write(path);
        }
    };
    match command {
        Command::Render(args) => write(&args.output),
        Command::Turntable(args) => write(&args.output),
        Command::Animate(args) => write(&args.output),
        Command::Sheet(args) => write(&args.output),
        Command::CompareModels(args) => write(&args.output),
        Command::Materials(args) => args.output.iter().for_each(|path| write(path)),
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
        Command::Attempt(AttemptArgs { output, .. }) => {
            output.iter().for_each(|folder| write(&folder.join("x")));
        }
        Command::Info(_) | Command::Bench(_) => {}
    }
    grants
}

/// The inputs of a command, with those of its scene file.
fn reads(command: &Command, description: &SceneFile, grants: &mut Grants) {
    let mut description = description.clone();
    match command {
        Command::Render(args) => {
            let RenderArgs { input, light, picture, .. } = &**args;
            light.apply(&mut description);
            picture.apply(&mut description);
            read_models(input.as_slice(), &description, grants);
        }
        Command::Turntable(args) => {
            let TurntableArgs { input, light, picture, .. } = &**args;
            light.apply(&mut description);
            picture.apply(&mut description);
            read_models(input.as_slice(), &description, grants);
        }
        Command::Animate(args) => {
            let AnimateArgs { input, light, picture, .. } = &**args;
            light.apply(&mut description);
            picture.apply(&mut description);
            read_models(input.as_slice(), &description, grants);
        }
        Command::Bench(args) => {
            let BenchArgs { inputs, light, picture, .. } = &**args;
            light.apply(&mut description);
            picture.apply(&mut description);
            read_models(inputs, &description, grants);
        }
        Command::CompareModels(args) => {
            let CompareModelsArgs { input, light, picture, .. } = &**args;
            light.apply(&mut description);
            picture.apply(&mut description);
            read_models(input.as_slice(), &description, grants);
        }
        Command::Sheet(args) => {
            args.light.apply(&mut description);
            args.picture.apply(&mut description);
            read_models(&args.inputs, &description, grants);
        }
        Command::Info(args) => read_models(std::slice::from_ref(&args.input), &description, grants),
        Command::Materials(args) => {
            LightArgs::apply(&args.light, &mut description);
            read_models(&[], &description, grants);
        }
        Command::Golden(args) => read_pictures(args, grants),
        Command::Attempt(args) => grants.read_folders.extend(args.input.clone()),
    }
}

/// Models and what lights and covers them.
fn read_models(models: &[PathBuf], description: &SceneFile, grants: &mut Grants) {
    // A model of the command line takes the place of the scene file's.
    let described = description.model.iter().filter(|_| models.is_empty());
    for path in models.iter().chain(described).filter(|path| !is_standard_stream(path)) {
        grants.read_with_folder(path);
    }
    if let Some(EnvironmentChoice::File(path)) = &description.env {
        grants.read_files.push(path.clone());
    }
    for choice in description.material_choices() {
        if let Some(path) = choice.source.file() {
            grants.read_with_folder(path);
        }
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
