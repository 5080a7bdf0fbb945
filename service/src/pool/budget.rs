//! Time that the work on one model may take: of the processor, so that a loaded machine stops no work that an idle one would end, and
//! of the wall, far longer, for work that waits.

use std::fmt;
use std::future::Future;
use std::pin::pin;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// Time between two looks at the processor time of a worker, at least and at most: half of the limit.
const LOOKS: [Duration; 2] = [Duration::from_millis(5), Duration::from_millis(100)];

/// Times that the work on one model may take.
#[derive(Clone, Copy, Debug)]
pub struct TimeLimits {
    /// Processor time of all threads of its worker; wall time where the system does not tell it (on others than Linux).
    pub processor: Duration,
    /// Wall time.
    pub wall: Duration,
}

impl TimeLimits {
    /// Limits in seconds; that of the wall is ten times as long unless it is given.
    #[must_use]
    pub fn new(processor: f64, wall: Option<f64>) -> Self {
        let seconds = Duration::from_secs_f64;
        Self { processor: seconds(processor), wall: seconds(wall.unwrap_or(10.0 * processor)) }
    }

    /// Limits of the work on so many pictures of one model.
    #[must_use]
    pub fn times(self, pictures: u32) -> Self {
        let times = |time: Duration| time.saturating_mul(pictures.max(1));
        Self { processor: times(self.processor), wall: times(self.wall) }
    }
}

/// A time limit that was passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeLimit {
    /// Processor time.
    Processor(Duration),
    /// Wall time.
    Wall(Duration),
}

impl TimeLimit {
    /// Name of the option that sets it.
    #[must_use]
    pub fn option(self) -> &'static str {
        match self {
            Self::Processor(_) => "deadline",
            Self::Wall(_) => "wall_deadline",
        }
    }
}

impl fmt::Display for TimeLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Processor(limit) => write!(f, "{} s of processor time", limit.as_secs_f64()),
            Self::Wall(limit) => write!(f, "{} s", limit.as_secs_f64()),
        }
    }
}

/// Time that is left for the work on one model.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeBudget {
    limits: TimeLimits,
    end: Instant,
    /// Worker whose processor time counts, and that time at which it is stopped.
    process: Option<(u32, Duration)>,
}

impl TimeBudget {
    /// The whole of it, from now on, before there is a worker.
    pub(super) fn new(limits: TimeLimits) -> Self {
        Self { limits, end: Instant::now() + limits.wall, process: None }
    }

    /// Deadlines of a worker that begins now.
    pub(super) fn of_process(self, process: Option<u32>) -> Self {
        let Self { limits, end, .. } = self;
        match process.and_then(|id| Some((id, processor_time(id)? + limits.processor))) {
            Some(process) => Self { process: Some(process), ..self },
            None => Self { end: end.min(Instant::now() + limits.processor), ..self },
        }
    }

    /// Processor time that the worker has spent since it began; `None` where the system does not tell it.
    pub(super) fn spent(&self) -> Option<Duration> {
        let (id, end) = self.process?;
        Some((processor_time(id)? + self.limits.processor).saturating_sub(end))
    }

    /// Waits for something, as long as there is time.
    ///
    /// # Errors
    /// [`TimeLimit`] that was passed before.
    pub(super) async fn wait<T>(&self, work: impl Future<Output = T>) -> Result<T, TimeLimit> {
        let mut work = pin!(work);
        let pause = (self.limits.processor / 2).clamp(LOOKS[0], LOOKS[1]);
        loop {
            let look = Instant::now() + pause;
            let until = if self.process.is_some() { look.min(self.end) } else { self.end };
            if let Ok(done) = timeout_at(until, &mut work).await {
                return Ok(done);
            }
            self.check()?;
        }
    }

    fn check(&self) -> Result<(), TimeLimit> {
        if let Some((id, end)) = self.process
            && processor_time(id).is_some_and(|time| time >= end)
        {
            return Err(TimeLimit::Processor(self.limits.processor));
        }
        match (Instant::now() < self.end, self.process) {
            (true, _) => Ok(()),
            (false, None) if self.limits.processor < self.limits.wall => {
                Err(TimeLimit::Processor(self.limits.processor))
            }
            (false, _) => Err(TimeLimit::Wall(self.limits.wall)),
        }
    }
}

/// Processor time of all threads of a process so far, in steps of a hundredth of a second; `None` where the system does not tell.
fn processor_time(process: u32) -> Option<Duration> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    // proc_pid_stat(5): utime and stime are fields 14 and 15. The second, the name, is in parentheses and may hold any character. Ticks
    // are hundredths of a second for programs, whatever the kernel counts in (USER_HZ).
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_ascii_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(ticks()?.saturating_add(ticks()?).saturating_mul(10)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(1000);

    #[tokio::test]
    async fn sleep_takes_wall_time_alone() {
        let limits = TimeLimits { processor: Duration::from_millis(20), wall: LONG };
        let budget = TimeBudget::new(limits).of_process(Some(std::process::id()));
        if cfg!(target_os = "linux") {
            let mut child = std::process::Command::new("sleep").arg("100").spawn().unwrap();
            let asleep = TimeBudget::new(limits).of_process(Some(child.id()));
            assert_eq!(asleep.wait(tokio::time::sleep(Duration::from_millis(400))).await, Ok(()));
            child.kill().unwrap();
            child.wait().unwrap();
            // This process works.
            std::thread::spawn(|| {
                let begun = std::time::Instant::now();
                while begun.elapsed() < Duration::from_secs(20) {
                    std::hint::black_box(begun);
                }
            });
            let passed = budget.wait(std::future::pending::<()>()).await;
            assert_eq!(passed, Err(TimeLimit::Processor(limits.processor)));
        }
    }

    #[tokio::test]
    async fn wall_time_ends_what_waits() {
        let limits = TimeLimits { processor: LONG, wall: Duration::from_millis(50) };
        for process in [None, Some(std::process::id())] {
            let budget = TimeBudget::new(limits).of_process(process);
            assert_eq!(budget.wait(std::future::pending::<()>()).await, Err(TimeLimit::Wall(limits.wall)));
        }
        // The limit of processor time becomes one of the wall if the system does not tell processor time.
        let limits = TimeLimits { processor: Duration::from_millis(50), wall: LONG };
        let passed = TimeBudget::new(limits).of_process(None).wait(std::future::pending::<()>()).await;
        assert_eq!(passed, Err(TimeLimit::Processor(limits.processor)));
    }
}
