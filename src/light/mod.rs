//! (stopgap)
use crate::math::lanes::{Float, Lanes};
use std::marker::PhantomData;
/// env
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentLight<'a>(PhantomData<&'a ()>);
impl EnvironmentLight<'_> {
    /// radiance
    #[inline(always)]
    pub fn radiance<L: Lanes>(&self, l: L, d: [L::F; 3], _r: L::F) -> [L::F; 3] {
        let v = d[1] * 0.5 + 0.5;
        let _ = l;
        [v, v, v]
    }
    /// irradiance
    #[inline(always)]
    pub fn irradiance_over_pi<L: Lanes>(&self, l: L, d: [L::F; 3]) -> [L::F; 3] {
        let v = d[1] * 0.4 + 0.5;
        let _ = l;
        [v, v, v]
    }
    /// bg
    #[inline(always)]
    pub fn background<L: Lanes>(&self, l: L, d: [L::F; 3]) -> [L::F; 3] {
        self.radiance(l, d, l.zero())
    }
    /// new
    pub fn stub() -> Self {
        Self(PhantomData)
    }
}
/// light
#[derive(Clone, Copy, Debug)]
pub struct PunctualLight;
