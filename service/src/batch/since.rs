//! The time since which models have changed, of those that a batch draws.

use std::time::{Duration, SystemTime};

/// The time of a text: a date (`2026-11-01`, `2026-11-01T12:00:00Z`, UTC), a duration before now (`36h`, `7days`), or a file, whose own
/// time counts.
///
/// # Errors
/// One line.
pub fn time_of(text: &str, now: SystemTime) -> Result<SystemTime, String> {
    let day = |text: &str| humantime::parse_rfc3339_weak(&format!("{text} 00:00:00")).ok();
    if let Some(time) = humantime::parse_rfc3339_weak(text).ok().or_else(|| day(text)) {
        return Ok(time);
    }
    if let Ok(before) = humantime::parse_duration(text) {
        return now.checked_sub(before).ok_or_else(|| format!("'{text}' before now is no time"));
    }
    let modified = std::fs::metadata(text).and_then(|metadata| metadata.modified());
    modified.map_err(|_| {
        format!(
            "'{text}': expected a date (2026-11-01, 2026-11-01T12:00:00Z), a duration (36h, 7days) or a file"
        )
    })
}

/// True if a model has changed since then. File systems and stores tell whole seconds; one whose time nobody tells is drawn.
#[must_use]
pub fn has_changed(modified: Option<SystemTime>, since: SystemTime) -> bool {
    modified.is_none_or(|modified| modified + Duration::from_secs(1) > since)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_dates_durations_and_files() {
        let at = |seconds: u64| SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        let now = at(1_800_000_000);
        assert_eq!(time_of("2026-11-01", now), Ok(at(1_793_491_200)));
        assert_eq!(time_of("2026-11-01T12:00:00Z", now), Ok(at(1_793_534_400)));
        assert_eq!(time_of("2026-11-01 12:00:01", now), Ok(at(1_793_534_401)));
        assert_eq!(time_of("36h", now), Ok(at(1_800_000_000 - 36 * 3600)));
        assert_eq!(time_of("7days", now), Ok(at(1_800_000_000 - 7 * 86_400)));
        let file = tempfile::NamedTempFile::new().unwrap();
        let modified = file.as_file().metadata().unwrap().modified().unwrap();
        assert_eq!(time_of(file.path().to_str().unwrap(), now), Ok(modified));
        for wrong in ["", "yesterday", "2026-13-01"] {
            assert!(time_of(wrong, now).is_err(), "{wrong}");
        }
    }

    #[test]
    fn models_of_the_same_second_are_drawn() {
        let at = |millis| SystemTime::UNIX_EPOCH + Duration::from_millis(millis);
        assert!(
            has_changed(None, at(0))
                && has_changed(Some(at(5_000)), at(5_900))
                && has_changed(Some(at(9_000)), at(5_900))
        );
        assert!(!has_changed(Some(at(4_800)), at(5_900)));
    }
}
