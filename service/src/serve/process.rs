//! Metrics of this process under the names that Prometheus gives to those of every program: from /proc, and therefore on Linux alone.

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric};
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;
use std::fmt;
use std::path::Path;

/// Ticks of a second in /proc, whatever the kernel counts in (USER_HZ).
const TICKS: f64 = 100.0;

/// Reads the metrics whenever they are asked for.
#[derive(Debug)]
pub struct Process;

/// Metrics at a time; those that the system does not tell are absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Values {
    cpu_seconds: Option<f64>,
    resident_bytes: Option<u64>,
    open_files: Option<u64>,
    /// Seconds since 1970.
    started: Option<f64>,
}

impl Values {
    /// Metrics of this process.
    fn read() -> Self {
        if !cfg!(target_os = "linux") {
            return Self::default();
        }
        let text = |path: &str| std::fs::read_to_string(Path::new("/proc").join(path)).unwrap_or_default();
        let open_files = std::fs::read_dir("/proc/self/fd").ok();
        Self {
            // Reading the folder opens it.
            open_files: open_files.map(|files| (files.count() as u64).saturating_sub(1)),
            ..Self::of(&text("self/stat"), &text("self/status"), &text("stat"))
        }
    }

    /// Metrics in the files that proc(5) describes: stat and status of a process, and stat of the system.
    fn of(stat: &str, status: &str, system: &str) -> Self {
        // The name is in parentheses and may hold any character; state, field 3, follows.
        let fields: Vec<&str> =
            stat.rsplit_once(')').map_or("", |(_, rest)| rest).split_ascii_whitespace().collect();
        let field = |number: usize| fields.get(number - 3)?.parse::<f64>().ok();
        let line = |text: &str, name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.split_ascii_whitespace().next()?.parse::<u64>().ok()
        };
        let boot = line(system, "btime ");
        Self {
            cpu_seconds: field(14).zip(field(15)).map(|(user, system)| (user + system) / TICKS),
            resident_bytes: line(status, "VmRSS:").map(|kilobytes| kilobytes.saturating_mul(1024)),
            open_files: None,
            started: field(22).zip(boot).map(|(ticks, boot)| boot as f64 + ticks / TICKS),
        }
    }
}

impl Collector for Process {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> Result<(), fmt::Error> {
        let Values { cpu_seconds, resident_bytes, open_files, started } = Values::read();
        if let Some(seconds) = cpu_seconds {
            let metric = ConstCounter::new(seconds);
            let help = "Processor time of this process, without workers";
            metric.encode(encoder.encode_descriptor(
                "process_cpu_seconds",
                help,
                None,
                metric.metric_type(),
            )?)?;
        }
        for (name, help, value) in [
            (
                "process_resident_memory_bytes",
                "Resident memory, without workers",
                resident_bytes.map(|v| v as f64),
            ),
            ("process_open_fds", "Open file descriptors", open_files.map(|v| v as f64)),
            ("process_start_time_seconds", "Start in seconds since 1970", started),
        ] {
            let Some(value) = value else { continue };
            let metric = ConstGauge::new(value);
            metric.encode(encoder.encode_descriptor(name, help, None, metric.metric_type())?)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_the_system_are_read() {
        let stat = "7 (a) b (c) S 1 7 7 0 -1 4194560 100 0 0 0 250 125 0 0 20 0 4 0 12345 1000 300 18446744073709551615";
        let values = Values::of(
            stat,
            "Name:\tx\nVmPeak:\t  9 kB\nVmRSS:\t    1234 kB\n",
            "cpu  1 2\nbtime 1700000000\n",
        );
        assert_eq!(
            values,
            Values {
                cpu_seconds: Some(3.75),
                resident_bytes: Some(1234 * 1024),
                open_files: None,
                started: Some(1_700_000_123.45),
            }
        );
        assert_eq!(Values::of("", "VmRSS:\n", "btime x"), Values::default());
        assert_eq!(Values::of("7 (a) S 1", "", "btime 5"), Values::default());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn this_process_is_alive() {
        let values = Values::read();
        assert!(values.cpu_seconds.is_some_and(|seconds| seconds < 1e6), "{values:?}");
        assert!(values.resident_bytes.is_some_and(|bytes| bytes > 100_000), "{values:?}");
        let before = values.open_files.unwrap();
        let file = std::fs::File::open("/proc/self/stat").unwrap();
        // Other tests open files, too.
        assert!(before >= 3 && Values::read().open_files.unwrap() >= 4);
        drop(file);
        assert!(values.started.unwrap() > 1.5e9);
        assert_eq!(Values::read().started, values.started);
    }
}
