//! Filtered environments, kept from one picture to the next.

use crate::built::Environments;
use crate::jobs::Jobs;
use crate::light::PrefilteredEnvironment;
use crate::math::lanes::SimdLevel;
use crate::scene::{EnvironmentSource, EquirectImage};
use std::sync::Arc;

/// The environment that was used last.
#[derive(Debug, Default)]
pub(super) struct EnvironmentCache {
    picture: Option<(Arc<EquirectImage>, Arc<PrefilteredEnvironment>)>,
    dark: Option<Arc<PrefilteredEnvironment>>,
    /// Used whatever the scene says.
    pub(super) given: Option<Arc<PrefilteredEnvironment>>,
}

impl EnvironmentCache {
    /// True if [`EnvironmentCache::get`] would filter a picture.
    pub(super) fn would_filter(&self, source: &EnvironmentSource) -> bool {
        let EnvironmentSource::Image(picture) = source else { return false };
        self.given.is_none() && !self.picture.as_ref().is_some_and(|(key, _)| Arc::ptr_eq(key, picture))
    }

    /// Darkness.
    fn dark(&mut self) -> Arc<PrefilteredEnvironment> {
        Arc::clone(self.dark.get_or_insert_with(|| Arc::new(PrefilteredEnvironment::black())))
    }

    /// The filtered form of a source; a picture is filtered once for as long as the scenes share it.
    pub(super) fn get(
        &mut self,
        source: &EnvironmentSource,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Arc<PrefilteredEnvironment> {
        if let Some(given) = &self.given {
            return Arc::clone(given);
        }
        match source {
            EnvironmentSource::Studio => PrefilteredEnvironment::studio(),
            // Pictures without the part have been refused.
            EnvironmentSource::Image(_) if !Environments::IS_BUILT => self.dark(),
            EnvironmentSource::None => self.dark(),
            EnvironmentSource::Image(picture) => match &self.picture {
                Some((key, filtered)) if Arc::ptr_eq(key, picture) => Arc::clone(filtered),
                _ => {
                    let filtered = Arc::new(PrefilteredEnvironment::new(picture, jobs, level));
                    self.picture = Some((Arc::clone(picture), Arc::clone(&filtered)));
                    filtered
                }
            },
        }
    }
}
