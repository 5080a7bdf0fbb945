//! Which part of a batch one of several processes does.

use std::fmt;

/// One of `count` parts; the first is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    pub index: u64,
    /// At least 1.
    pub count: u64,
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// `3/16`, or `auto` and `auto/16` for what a job of Kubernetes, AWS Batch or SLURM says of itself in its environment.
    ///
    /// # Errors
    /// One line.
    pub fn new(text: &str, environment: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u64>().ok();
        let wrong = || {
            format!("'{text}': expected INDEX/COUNT with INDEX from 0 to COUNT - 1, or auto, or auto/COUNT")
        };
        let (index, count) = match text.split_once('/') {
            Some(("auto", count)) => (None, Some(number(count).ok_or_else(wrong)?)),
            Some((index, count)) => {
                (Some(number(index).ok_or_else(wrong)?), Some(number(count).ok_or_else(wrong)?))
            }
            None if text == "auto" => (None, None),
            None => return Err(wrong()),
        };
        let found = match index {
            Some(index) => Self { index, count: count.ok_or_else(wrong)? },
            None => Self::of_job(count, environment)?,
        };
        if found.index < found.count { Ok(found) } else { Err(wrong()) }
    }

    /// Shard from the environment variables of a job system.
    fn of_job(count: Option<u64>, environment: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |name: &str| environment(name)?.trim().parse::<u64>().ok();
        // Kubernetes (indexed Jobs): how many there are is not in the environment unless the manifest puts it there.
        if let Some(index) = number("JOB_COMPLETION_INDEX") {
            let count = count.or_else(|| number("JOB_COMPLETIONS"));
            let count = count.ok_or("JOB_COMPLETION_INDEX is set: --shard auto/COUNT says of how many")?;
            return Ok(Self { index, count });
        }
        // AWS Batch (array jobs).
        if let Some(index) = number("AWS_BATCH_JOB_ARRAY_INDEX") {
            let count = count.or_else(|| number("AWS_BATCH_JOB_ARRAY_SIZE"));
            let count =
                count.ok_or("AWS_BATCH_JOB_ARRAY_INDEX is set: --shard auto/COUNT says of how many")?;
            return Ok(Self { index, count });
        }
        // SLURM (job arrays): --array=MIN-MAX:STEP.
        if let Some(task) = number("SLURM_ARRAY_TASK_ID") {
            let first = number("SLURM_ARRAY_TASK_MIN").unwrap_or(0);
            let step = number("SLURM_ARRAY_TASK_STEP").filter(|step| *step > 0).unwrap_or(1);
            let count = count.or_else(|| number("SLURM_ARRAY_TASK_COUNT"));
            let count = count.ok_or("SLURM_ARRAY_TASK_ID is set: --shard auto/COUNT says of how many")?;
            return Ok(Self { index: task.saturating_sub(first) / step, count });
        }
        Err("--shard auto: this is no job of Kubernetes (JOB_COMPLETION_INDEX), AWS Batch \
             (AWS_BATCH_JOB_ARRAY_INDEX) or SLURM (SLURM_ARRAY_TASK_ID)"
            .to_owned())
    }

    /// True if a model belongs to it: by its name alone, so that models that come or go move no other.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        let hash = blake3::hash(name.as_bytes());
        let [a, b, c, d, e, f, g, h, ..] = *hash.as_bytes();
        u64::from_le_bytes([a, b, c, d, e, f, g, h]) % self.count == self.index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shard(text: &str, environment: &[(&str, &str)]) -> Result<Shard, String> {
        let find = |name: &str| environment.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        Shard::new(text, find)
    }

    #[test]
    fn jobs_say_which_they_are() {
        let is = |index, count| Ok(Shard { index, count });
        assert_eq!(shard("3/16", &[]), is(3, 16));
        assert_eq!(shard("auto/4", &[("JOB_COMPLETION_INDEX", "2")]), is(2, 4));
        let completions = [("JOB_COMPLETION_INDEX", "2"), ("JOB_COMPLETIONS", "5")];
        assert_eq!(shard("auto", &completions), is(2, 5));
        let array = [("AWS_BATCH_JOB_ARRAY_INDEX", "0"), ("AWS_BATCH_JOB_ARRAY_SIZE", "9")];
        assert_eq!(shard("auto", &array), is(0, 9));
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "7"),
            ("SLURM_ARRAY_TASK_MIN", "1"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(shard("auto", &slurm), is(3, 4));
        for (text, environment) in [
            ("4/4", &[][..]),
            ("x/4", &[]),
            ("1/0", &[]),
            ("3", &[]),
            ("auto", &[]),
            ("auto", &[("JOB_COMPLETION_INDEX", "2")]),
            ("auto/2", &[("JOB_COMPLETION_INDEX", "2")]),
        ] {
            assert!(shard(text, environment).is_err(), "{text} {environment:?}");
        }
    }

    #[test]
    fn every_model_is_in_one_of_them() {
        let mut counts = [0; 7];
        for model in 0..7000 {
            let name = format!("models/{model}.glb");
            let of: Vec<u64> = (0..7).filter(|&index| Shard { index, count: 7 }.has(&name)).collect();
            assert_eq!(of.len(), 1);
            counts[of[0] as usize] += 1;
        }
        assert!(counts.iter().all(|count| (850..1150).contains(count)), "{counts:?}");
    }
}
