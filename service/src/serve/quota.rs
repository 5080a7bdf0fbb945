//! Quotas: units that the holder of a key may have drawn in a period. Pictures that are there already cost none.

use super::error::{Kind, Problem};
use super::rights::Holder;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Periods of holders, by their names: as many as there are holders. Time is that of the machine's run, which no clock sets.
#[derive(Debug, Default)]
pub struct Quotas(Mutex<BTreeMap<Arc<str>, Period>>);

#[derive(Clone, Copy, Debug)]
struct Period {
    begun: Instant,
    spent: u64,
}

impl Quotas {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Arc<str>, Period>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes units. Returns those that are left in the period, where there is a quota.
    ///
    /// # Errors
    /// [`Kind::Quota`] with the seconds to the next period, [`Kind::Price`] if no period has so many.
    pub fn take(&self, holder: &Holder, price: u64, now: Instant) -> Result<Option<u64>, Problem> {
        let Some(units) = holder.units else { return Ok(None) };
        if price > units {
            let message =
                format!("the picture costs {price} units, and the key has {units} in {} s", holder.seconds);
            return Err(Problem::new(Kind::Price, message));
        }
        let length = Duration::from_secs(holder.seconds);
        let mut periods = self.lock();
        let period = periods.entry(Arc::clone(&holder.name)).or_insert(Period { begun: now, spent: 0 });
        if now.saturating_duration_since(period.begun) >= length {
            *period = Period { begun: now, spent: 0 };
        }
        // A quota may have become smaller meanwhile.
        let left = units.saturating_sub(period.spent);
        if price > left {
            let wait = length.saturating_sub(now.saturating_duration_since(period.begun));
            let message = format!(
                "the picture costs {price} units, and the key has {left} left of {units} in {} s",
                holder.seconds
            );
            let seconds = (wait.as_secs_f64().ceil() as u64).max(1);
            return Err(Problem::new(Kind::Quota, message).retry_after(seconds));
        }
        period.spent = period.spent.saturating_add(price);
        Ok(Some(left - price))
    }

    /// Gives back units of pictures that are not drawn. Returns those that are left in the period, where there is a quota.
    pub fn give_back(&self, holder: &Holder, price: u64) -> Option<u64> {
        let units = holder.units?;
        let mut periods = self.lock();
        let period = periods.get_mut(&holder.name)?;
        period.spent = period.spent.saturating_sub(price);
        Some(units.saturating_sub(period.spent))
    }

    /// Forgets those who are no holders any more.
    pub fn keep(&self, is_holder: impl Fn(&str) -> bool) {
        self.lock().retain(|name, _| is_holder(name));
    }
}

#[cfg(test)]
mod tests {
    use super::super::rights::Rights;
    use super::*;
    use axum::http::{HeaderMap, header};

    fn holder() -> Arc<Holder> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("keys.toml");
        std::fs::write(&path, "[holder.a]\nkeys = ['0123456789abcdef']\nunits = 10\nseconds = 60").unwrap();
        let mut headers = HeaderMap::new();
        headers.insert(header::AUTHORIZATION, "Bearer 0123456789abcdef".parse().unwrap());
        Rights::read(Some(&path), None).unwrap().of(&headers, true, 0).unwrap().unwrap()
    }

    #[test]
    fn units_are_those_of_a_period() {
        let (quotas, holder, begun) = (Quotas::default(), holder(), Instant::now());
        let at = |seconds: u64| begun + Duration::from_secs(seconds);
        assert_eq!(quotas.take(&holder, 6, at(0)).unwrap(), Some(4));
        let problem = quotas.take(&holder, 5, at(15)).unwrap_err();
        assert_eq!((problem.kind, problem.retry_after), (Kind::Quota, Some(45)));
        assert_eq!(quotas.take(&holder, 11, at(15)).unwrap_err().kind, Kind::Price);
        assert_eq!(quotas.take(&holder, 4, at(59)).unwrap(), Some(0));
        assert_eq!(quotas.give_back(&holder, 4), Some(4));
        assert_eq!(quotas.take(&holder, 3, at(59)).unwrap(), Some(1));
        assert_eq!(quotas.take(&holder, 10, at(60)).unwrap(), Some(0));
        // A time before the last is none that gives units.
        assert_eq!(quotas.take(&holder, 1, at(0)).unwrap_err().kind, Kind::Quota);
        quotas.keep(|name| name == "b");
        assert_eq!(quotas.take(&holder, 10, at(61)).unwrap(), Some(0));
        let mut free = Holder::clone(&holder);
        free.units = None;
        assert_eq!(quotas.take(&free, u64::MAX, at(61)).unwrap(), None);
    }
}
