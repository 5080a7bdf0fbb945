//! Rights of clients: bearer keys (RFC 6750) with what their holders may have, from a file and from the environment.

use super::error::{Kind, Problem};
use super::fair::Priority;
use super::offers::{read_text, told};
use axum::http::header::WWW_AUTHENTICATE;
use axum::http::{HeaderMap, header};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::sync::Arc;
use toml::value::{Date, Datetime, Offset, Time};

/// Variable of the environment with keys: NAME=KEY, with commas.
pub const VARIABLE: &str = "OVERCOAT_BEARER";

/// Bytes of the file at most.
const LARGEST: u64 = 4 << 20;
/// Holders at most.
const HOLDERS: usize = 10_000;
/// Keys of a holder at most: the one in use, and the one that takes its place.
const KEYS: usize = 2;
/// Characters of a key.
const KEY_LENGTH: std::ops::RangeInclusive<usize> = 16..=256;
/// Seconds of a quota's period, if no others are given.
const HOUR: u64 = 3600;

/// One who has a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Holder {
    /// Name in logs and in the queue.
    pub name: Arc<str>,
    /// Hashes of keys; the keys themselves are not kept.
    keys: Vec<blake3::Hash>,
    /// Seconds since 1970 from which on the keys are no longer taken.
    expires: Option<u64>,
    /// Units that may be drawn in a period; any number if absent.
    pub units: Option<u64>,
    /// Seconds of a period.
    pub seconds: u64,
    /// Units that one request may cost.
    pub max_price: Option<u64>,
    /// Workers at a time.
    pub workers: Option<usize>,
    /// Priority in the queue.
    pub priority: Option<Priority>,
}

/// All holders of keys.
#[derive(Clone, Default)]
pub struct Rights(Vec<Arc<Holder>>);

impl fmt::Debug for Rights {
    // Hashes of keys stay out of logs.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Rights({} holders)", self.0.len())
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    holder: BTreeMap<String, Entry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    keys: Vec<String>,
    expires: Option<Datetime>,
    units: Option<u64>,
    seconds: Option<u64>,
    max_price: Option<u64>,
    workers: Option<usize>,
    priority: Option<Priority>,
}

impl Rights {
    /// Keys of a file, and those of the environment, which have no limits of their own.
    ///
    /// # Errors
    /// One line that names the file or the variable, and the holder.
    pub fn read(file: Option<&Path>, variable: Option<&str>) -> Result<Self, String> {
        let mut rights = Self::default();
        if let Some(path) = file {
            let text = read_text(path, LARGEST)?;
            rights.add_file(&text).map_err(|reason| format!("{}: {reason}", path.display()))?;
            if rights.0.is_empty() {
                return Err(format!("{}: there is no holder of a key", path.display()));
            }
        }
        if let Some(text) = variable {
            rights.add_variable(text).map_err(|reason| format!("{VARIABLE}: {reason}"))?;
        }
        Ok(rights)
    }

    fn add_file(&mut self, text: &str) -> Result<(), String> {
        // A message with a part of the file would show keys.
        let hidden = |e: toml::de::Error| match told(&e, text) {
            line if text_is_in(&line, text) => {
                line.split(':').next().unwrap_or_default().to_owned() + ": not as it has to be"
            }
            line => line,
        };
        let file: File = toml::from_str(text).map_err(hidden)?;
        file.holder.into_iter().try_for_each(|(name, entry)| {
            self.add(&name, entry).map_err(|reason| format!("holder.{name}: {reason}"))
        })
    }

    fn add_variable(&mut self, text: &str) -> Result<(), String> {
        let mut holders: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for (k, pair) in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()).enumerate() {
            let (name, key) =
                pair.split_once('=').ok_or_else(|| format!("key {}: expected NAME=KEY", k + 1))?;
            holders.entry(name.trim()).or_default().push(key.trim().to_owned());
        }
        for (name, keys) in holders {
            let (units, seconds, max_price, workers) = (None, None, None, None);
            let entry = Entry { keys, expires: None, units, seconds, max_price, workers, priority: None };
            self.add(name, entry).map_err(|reason| format!("{name}: {reason}"))?;
        }
        Ok(())
    }

    fn add(&mut self, name: &str, entry: Entry) -> Result<(), String> {
        super::offers::check_name(name)?;
        let Entry { keys, expires, units, seconds, max_price, workers, priority } = entry;
        if self.0.iter().any(|holder| *holder.name == *name) {
            return Err("there is another holder of this name".to_owned());
        }
        if self.0.len() >= HOLDERS {
            return Err(format!("there are more than {HOLDERS} holders"));
        }
        if keys.is_empty() || keys.len() > KEYS {
            return Err(format!("keys: expected 1 or {KEYS}, got {}", keys.len()));
        }
        for (what, value) in [("units", units), ("seconds", seconds), ("max_price", max_price)] {
            if value == Some(0) {
                return Err(format!("{what}: expected 1 or more, got 0"));
            }
        }
        if workers == Some(0) {
            return Err("workers: expected 1 or more, got 0".to_owned());
        }
        let expires = expires.map(seconds_of).transpose().map_err(|reason| format!("expires: {reason}"))?;
        let mut hashes: Vec<blake3::Hash> = Vec::new();
        for (k, key) in keys.iter().enumerate() {
            let about = |reason: &str| format!("key {}: {reason}", k + 1);
            if !is_key(key) {
                let message = "expected 16 to 256 letters, digits and -._~+/, with = at the end alone";
                return Err(about(message));
            }
            let hash = blake3::hash(key.as_bytes());
            if hashes.contains(&hash) || self.0.iter().any(|holder| holder.keys.contains(&hash)) {
                return Err(about("there is another one like it"));
            }
            hashes.push(hash);
        }
        let (name, seconds) = (name.into(), seconds.unwrap_or(HOUR));
        let holder = Holder { name, keys: hashes, expires, units, seconds, max_price, workers, priority };
        self.0.push(Arc::new(holder));
        Ok(())
    }

    /// True if nobody has a key: none is asked for then.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Number of holders.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// True if there is a holder of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.iter().any(|holder| *holder.name == *name)
    }

    /// The holder of this name.
    #[must_use]
    pub fn holder(&self, name: &str) -> Option<Arc<Holder>> {
        self.0.iter().find(|holder| *holder.name == *name).cloned()
    }

    /// The holder of the key in the headers of a request, if there is one.
    ///
    /// # Errors
    /// [`Kind::NoKey`] if there is none and one is needed, [`Kind::Key`], [`Kind::KeyExpired`].
    pub fn of(&self, headers: &HeaderMap, is_needed: bool, now: u64) -> Result<Option<Arc<Holder>>, Problem> {
        if self.is_empty() {
            return Ok(None);
        }
        let refused = |kind, message: &str, error: &str| {
            Problem::new(kind, message).with(WWW_AUTHENTICATE, format!("Bearer realm=\"overcoat\"{error}"))
        };
        let mut all =
            headers.get_all(header::AUTHORIZATION).iter().map(|value| value.to_str().unwrap_or_default());
        let (first, second) = (all.next().and_then(bearer), all.next());
        let wrong = || refused(Kind::Key, "nobody has this key", ", error=\"invalid_token\"");
        let key = match (first, second) {
            (_, Some(_)) => return Err(wrong()),
            (Some(key), None) => key,
            (None, None) if !is_needed => return Ok(None),
            (None, None) => {
                return Err(refused(Kind::NoKey, "a key is needed here: Authorization: Bearer KEY", ""));
            }
        };
        let holder = self.find(key).ok_or_else(wrong)?;
        if holder.expires.is_some_and(|end| now >= end) {
            return Err(refused(Kind::KeyExpired, "the key has expired", ", error=\"invalid_token\""));
        }
        Ok(Some(holder))
    }

    /// The holder of a key. All keys are compared, each in constant time, as hashes of BLAKE3 are.
    fn find(&self, key: &str) -> Option<Arc<Holder>> {
        let hash = blake3::hash(key.as_bytes());
        let mut found = None;
        for holder in &self.0 {
            for own in &holder.keys {
                if *own == hash {
                    found = Some(Arc::clone(holder));
                }
            }
        }
        found
    }
}

/// True if a message quotes a longer piece of the text that it is about.
fn text_is_in(message: &str, text: &str) -> bool {
    text.split(|c: char| c.is_whitespace() || "\"'=,[]".contains(c))
        .any(|word| word.len() >= *KEY_LENGTH.start() && message.contains(word))
}

/// The token of `Authorization: Bearer TOKEN`, whose scheme is written in any case (RFC 9110, 11.1).
fn bearer(value: &str) -> Option<&str> {
    let (scheme, key) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
}

/// True for a token of bearers (RFC 6750, 2.1) that is long enough to be a secret.
fn is_key(text: &str) -> bool {
    let body = text.trim_end_matches('=');
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~+/".contains(&byte);
    KEY_LENGTH.contains(&text.len()) && !body.is_empty() && body.bytes().all(plain)
}

/// Seconds since 1970 of a date with time and offset.
fn seconds_of(time: Datetime) -> Result<u64, String> {
    let Datetime { date: Some(date), time: Some(Time { hour, minute, second, .. }), offset: Some(offset) } =
        time
    else {
        return Err(format!("expected a date with its time and offset, as 2027-01-31T00:00:00Z, got {time}"));
    };
    let minutes = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => i64::from(minutes),
    };
    let of_day = i64::from(hour) * 3600 + i64::from(minute) * 60 + i64::from(second.unwrap_or(0));
    let seconds = days_of(date) * 86_400 + of_day - minutes * 60;
    u64::try_from(seconds).map_err(|_| format!("{time} lies before 1970"))
}

/// Days since 1970 in the Gregorian calendar, by years that begin in March: leap days are the last of theirs.
fn days_of(Date { year, month, day }: Date) -> i64 {
    let [year, month, day] = [i64::from(year), i64::from(month), i64::from(day)];
    let (year, month) = if month < 3 { (year - 1, month + 9) } else { (year, month - 3) };
    let of_year = (153 * month + 2) / 5 + day - 1;
    year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "0123456789abcdef";

    fn rights(text: &str) -> Result<Rights, String> {
        let mut rights = Rights::default();
        rights.add_file(text).map(|()| rights)
    }

    fn of(rights: &Rights, headers: &[&str], is_needed: bool, now: u64) -> Result<Option<String>, Kind> {
        let mut all = HeaderMap::new();
        for value in headers {
            all.append(header::AUTHORIZATION, value.parse().unwrap());
        }
        let holder = rights.of(&all, is_needed, now).map_err(|problem| problem.kind)?;
        Ok(holder.map(|holder| holder.name.to_string()))
    }

    #[test]
    fn holders_are_known_by_their_keys() {
        let text = format!(
            "[holder.a]\nkeys = ['{KEY}', '{KEY}new==']\nunits = 9\n[holder.b]\nkeys = ['b{KEY}']\nexpires = 1970-01-02T00:00:00Z"
        );
        let rights = rights(&text).unwrap();
        let a = Ok(Some("a".to_owned()));
        assert_eq!(of(&rights, &[&format!("Bearer {KEY}")], true, 0), a);
        assert_eq!(of(&rights, &[&format!("bearer  {KEY}new==")], false, 0), a);
        assert_eq!(of(&rights, &[&format!("Bearer b{KEY}")], true, 86_399), Ok(Some("b".to_owned())));
        assert_eq!(of(&rights, &[&format!("Bearer b{KEY}")], true, 86_400), Err(Kind::KeyExpired));
        for (headers, kind) in [
            (&[][..], Kind::NoKey),
            (&["Basic 0123456789abcdef"], Kind::NoKey),
            (&["Bearer"], Kind::NoKey),
            (&["Bearer "], Kind::Key),
            (&["Bearer 0123456789abcde"], Kind::Key),
            (&["Bearer 0123456789abcdef0"], Kind::Key),
            (&["Bearer 0123456789abcdef", "Bearer 0123456789abcdef"], Kind::Key),
        ] {
            assert_eq!(of(&rights, headers, true, 0), Err(kind), "{headers:?}");
        }
        assert_eq!(of(&rights, &["Basic x"], false, 0), Ok(None));
        assert_eq!(of(&rights, &["Bearer x"], false, 0), Err(Kind::Key));
        assert_eq!(of(&Rights::default(), &["Bearer x"], true, 0), Ok(None));
        assert!(!format!("{rights:?}").contains("0123"));
    }

    #[test]
    fn keys_of_the_environment_are_a_list() {
        let rights = Rights::read(None, Some(&format!("a={KEY}, a=x{KEY}==,b=y{KEY}"))).unwrap();
        assert_eq!(of(&rights, &[&format!("Bearer x{KEY}==")], true, 0), Ok(Some("a".to_owned())));
        assert_eq!(rights.count(), 2);
        for (text, what) in [
            (KEY.to_owned(), "OVERCOAT_BEARER: key 1: expected NAME=KEY"),
            ("a=short".to_owned(), "OVERCOAT_BEARER: a: key 1: expected 16 to 256"),
            (format!("a={KEY},b={KEY}"), "OVERCOAT_BEARER: b: key 1: there is another"),
        ] {
            let error = Rights::read(None, Some(&text)).unwrap_err();
            assert!(error.starts_with(what) && !error.contains(KEY), "{text}: {error}");
        }
    }

    #[test]
    fn wrong_files_are_told_without_their_keys() {
        let many = format!("[holder.a]\nkeys = ['{KEY}', '1{KEY}', '2{KEY}']");
        for (text, what) in [
            ("[holder.a]\nkeys = []", "holder.a: keys: expected 1 or 2, got 0"),
            (&many, "holder.a: keys: expected 1 or 2, got 3"),
            ("[holder.a]", "line 1: missing field `keys`"),
            ("[holder.a]\nkeys = ['0123456789abcdef é']", "holder.a: key 1: expected 16"),
            ("[holder.a]\nkeys = ['0123456789abcdef'", "line 2: "),
            ("[holder.a]\nkeys = '0123456789abcdef'", "line 2"),
            ("[holder.a]\n0123456789abcdef = 1", "line 2"),
            ("[holder.'a b']\nkeys = ['0123456789abcdef']", "holder.a b: expected a name"),
            ("[holder.a]\nkeys = ['0123456789abcdef']\nunits = 0", "holder.a: units: expected 1"),
            ("[holder.a]\nkeys = ['0123456789abcdef']\nunits = -1", "line 3"),
            (
                "[holder.a]\nkeys = ['0123456789abcdef']\nexpires = 2027-01-01",
                "holder.a: expires: expected a date with",
            ),
            (
                "[holder.a]\nkeys = ['0123456789abcdef']\nexpires = 1960-01-01T00:00:00Z",
                "holder.a: expires: 1960",
            ),
            (
                "[holder.a]\nkeys = ['0123456789abcdef', '0123456789abcdef']",
                "holder.a: key 2: there is another",
            ),
        ] {
            let error = rights(text).unwrap_err();
            assert!(error.starts_with(what) && !error.contains(KEY), "{text}: {error}");
        }
    }

    #[test]
    fn dates_are_seconds() {
        for (text, seconds) in [
            ("1970-01-01T00:00:00Z", 0),
            ("2000-02-29T12:00:00Z", 951_825_600),
            ("2001-09-09T01:46:40Z", 1_000_000_000),
            ("2001-09-09T03:46:40+02:00", 1_000_000_000),
            ("2033-05-18T03:33:20Z", 2_000_000_000),
            ("2100-03-01T00:00:00Z", 4_107_542_400),
        ] {
            assert_eq!(seconds_of(text.parse().unwrap()), Ok(seconds), "{text}");
        }
    }
}
