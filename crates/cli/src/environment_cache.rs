//! `--cache`: a folder of filtered environments, and what is to be told of it.

use super::report::Reporter;
use overcoat::cache::EnvironmentFolder;
use overcoat_render::{EnvironmentStore, Renderer};
use overcoat_scene::EquirectImage;
use std::path::Path;
use std::sync::Arc;

/// A folder whose failures are warnings as they happen: pictures do not depend on it.
#[derive(Debug)]
struct ReportedFolder {
    folder: EnvironmentFolder,
    reporter: Reporter,
}

impl EnvironmentStore for ReportedFolder {
    fn get(&self, picture: &EquirectImage) -> Option<Vec<u8>> {
        self.folder.get(picture)
    }

    fn put(&self, picture: &EquirectImage, filtered: &[u8]) {
        self.folder.put(picture, filtered);
        if let Some(failure) = self.folder.take_failure() {
            self.reporter.warning(format_args!("the environment is not kept: {failure}"));
        }
    }
}

/// Has a renderer keep environments in a folder; a warning if there is none and it cannot be made.
pub(super) fn keep_environments(renderer: &mut Renderer, path: &Path, reporter: Reporter) {
    match EnvironmentFolder::open(path, EnvironmentFolder::DEFAULT_BYTES) {
        Ok(folder) => renderer.set_environment_store(Some(Arc::new(ReportedFolder { folder, reporter }))),
        Err(error) => {
            reporter.warning(format_args!("environments are not kept in {}: {error}", path.display()));
        }
    }
}
