//! Light: environments prepared for lookups, and punctual lights.

mod chain;
mod environment;
mod equirect;
mod harmonics;
mod octahedral;
mod prefilter;
mod texel;

pub use environment::{EnvironmentLight, PrefilteredEnvironment};

use crate::math::lanes::Lanes;
use crate::math::vec3::V3;

/// Radiance from infinitely far away, as a function of direction.
pub trait DistantRadiance {
    /// Linear Rec. 709 radiance that arrives from `direction` (away from the scene, any length but zero); finite and
    /// not negative.
    fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L>;
}
// STOPGAP until the punctual lights and the studio are there.
/// stop
#[derive(Clone, Copy, Debug)]
pub struct PunctualLight;
/// stop
pub struct LightSample<L: Lanes> {
    /// d
    pub direction: V3<L>,
    /// i
    pub irradiance: V3<L>,
}
impl PunctualLight {
    /// stop
    pub fn new(_: &crate::scene::Light) -> Self {
        Self
    }
    /// stop
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, p: V3<L>) -> LightSample<L> {
        LightSample { direction: p, irradiance: [l.zero(); 3] }
    }
}
struct Gradient;
impl DistantRadiance for Gradient {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, d: V3<L>) -> V3<L> {
        use crate::math::lanes::{Float, Mask};
        let d = crate::math::vec3::normalize(l, d);
        let v = d[1] * 0.3 + 0.5;
        let key = (d[0].gt(l.splat(0.6)) & d[1].gt(l.splat(0.3))).select(l.splat(5.0), l.zero());
        [v + key, v + key, v + key]
    }
}
impl PrefilteredEnvironment {
    /// stop
    pub fn studio() -> std::sync::Arc<Self> {
        static S: std::sync::OnceLock<std::sync::Arc<PrefilteredEnvironment>> = std::sync::OnceLock::new();
        S.get_or_init(|| {
            std::sync::Arc::new(Self::from_radiance(
                &Gradient,
                8,
                &crate::jobs::Jobs::new(1),
                crate::math::lanes::SimdLevel::best(),
            ))
        })
        .clone()
    }
}
