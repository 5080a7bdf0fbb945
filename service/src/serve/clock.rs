//! Time of day that never goes back: what has expired stays so, whatever is done to the system's clock.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Difference between the system's clock and the time that has passed, up to which neither is wrong.
const TOLERANCE: Duration = Duration::from_secs(2);

/// A clock.
#[derive(Debug)]
pub struct Clock(Mutex<Known>);

#[derive(Clone, Copy, Debug)]
struct Known {
    /// Time of day that was told last, since 1970.
    time: Duration,
    /// Moment at which it was told.
    at: Instant,
    /// The system's clock is behind.
    is_behind: bool,
}

impl Default for Clock {
    fn default() -> Self {
        Self(Mutex::new(Known { time: system(), at: Instant::now(), is_behind: false }))
    }
}

fn system() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

impl Clock {
    /// Seconds since 1970, and true if the system's clock has jumped back since the last time.
    #[must_use]
    pub fn seconds(&self) -> (u64, bool) {
        self.read(system(), Instant::now())
    }

    fn read(&self, system: Duration, now: Instant) -> (u64, bool) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let passed = known.time + now.saturating_duration_since(known.at);
        let was_behind = std::mem::replace(&mut known.is_behind, system + TOLERANCE < passed);
        (known.time, known.at) = (passed.max(system), now);
        (known.time.as_secs(), known.is_behind && !was_behind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_does_not_go_back() {
        let seconds = Duration::from_secs;
        let at = Instant::now();
        let known = Known { time: seconds(1000), at, is_behind: false };
        let clock = Clock(Mutex::new(known));
        for (system, passed, told) in [
            (1010, 10, (1010, false)),
            // Ahead, as after a pause of the machine.
            (2000, 20, (2000, false)),
            // Back: time goes on from where it was, and the jump is told once.
            (1030, 30, (2010, true)),
            (1040, 40, (2020, false)),
            // The system's clock is right again.
            (2040, 50, (2040, false)),
            (1, 60, (2050, true)),
        ] {
            assert_eq!(clock.read(seconds(system), at + seconds(passed)), told, "{system}");
        }
    }
}
