//! Times that stages take, for the user to read. No result depends on them.

use std::time::Duration;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
use std::time::Instant;

/// A moment. In WebAssembly without a system there is no clock that can be asked, and asking ends the program: there no
/// time ever passes.
#[derive(Clone, Copy, Debug)]
pub struct Moment(#[cfg(not(all(target_family = "wasm", target_os = "unknown")))] Instant);

impl Moment {
    /// Now.
    pub fn now() -> Self {
        Self(
            #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
            Instant::now(),
        )
    }

    /// From an earlier moment to this one.
    pub(crate) fn since(self, _earlier: Self) -> Duration {
        #[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
        return self.0 - _earlier.0;
        #[cfg(all(target_family = "wasm", target_os = "unknown"))]
        return Duration::ZERO;
    }

    /// From this moment to now.
    pub fn elapsed(self) -> Duration {
        Self::now().since(self)
    }
}
