//! Filtered environments, kept from one picture to the next.

use crate::jobs::Jobs;
use crate::light::PrefilteredEnvironment;
use crate::math::lanes::SimdLevel;
use crate::scene::{EnvironmentSource, EquirectImage};
use std::sync::Arc;

/// The environment that was used last.
#[derive(Debug, Default)]
pub(super) struct EnvironmentCache {
    picture: Option<(Arc<EquirectImage>, Arc<PrefilteredEnvironment>)>,
}

impl EnvironmentCache {
    /// The filtered form of a source; a picture is filtered once for as long as the scenes share it.
    pub(super) fn get(
        &mut self,
        source: &EnvironmentSource,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Arc<PrefilteredEnvironment> {
        match source {
            EnvironmentSource::Studio => studio_stopgap(),
            EnvironmentSource::None => Arc::new(PrefilteredEnvironment::black()),
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

struct Gradient;
impl crate::light::DistantRadiance for Gradient {
    #[inline(always)]
    fn radiance<L: crate::math::lanes::Lanes>(&self, l: L, d: [L::F; 3]) -> [L::F; 3] {
        use crate::math::lanes::{Float, Mask};
        let d = crate::math::vec3::normalize(l, d);
        let v = d[1] * 0.3 + 0.5;
        let key = (d[0].gt(l.splat(0.6)) & d[1].gt(l.splat(0.3))).select(l.splat(5.0), l.zero());
        [v + key, v + key, v + key]
    }
}
fn studio_stopgap() -> Arc<PrefilteredEnvironment> {
    static S: std::sync::OnceLock<Arc<PrefilteredEnvironment>> = std::sync::OnceLock::new();
    S.get_or_init(|| {
        Arc::new(PrefilteredEnvironment::from_radiance(&Gradient, 8, &Jobs::new(1), SimdLevel::best()))
    })
    .clone()
}
