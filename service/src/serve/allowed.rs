//! URLs that a service may read.

use crate::place::Place;
use url::Url;

/// Allowed prefix of sources.
#[derive(Debug)]
pub struct Allowed {
    scheme: String,
    /// A host and its port; `*.` in front stands for all below it, nothing for all.
    host: Option<(String, Option<u16>)>,
    path: String,
    /// Root for reading, for object stores.
    pub place: Option<Place>,
}

impl Allowed {
    /// Parses a URL that others begin with, of this option.
    ///
    /// # Errors
    /// One line.
    pub fn new(option: &str, text: &str) -> Result<Self, String> {
        let about = |reason: &str| format!("{option} {text}: {reason}");
        let (scheme, rest) =
            text.split_once("://").ok_or_else(|| about("expected a URL, as https://example.com/"))?;
        let scheme = scheme.to_ascii_lowercase();
        let is_http = matches!(scheme.as_str(), "http" | "https");
        if is_http && rest.is_empty() {
            return Ok(Self { scheme, host: None, path: "/".to_owned(), place: None });
        }
        if matches!(scheme.as_str(), "file" | "local") || rest.is_empty() {
            return Err(about("files of this machine are those of --local"));
        }
        let (wild, plain) = match rest.strip_prefix("*.") {
            Some(rest) => ("*.", rest),
            None => ("", rest),
        };
        let url = Url::parse(&format!("{scheme}://{plain}")).map_err(|e| about(&e.to_string()))?;
        let host = url.host_str().ok_or_else(|| about("names no host"))?;
        let place = if is_http { None } else { Some(Place::new(url.as_str()).map_err(|e| about(&e))?) };
        let host = Some((format!("{wild}{host}"), url.port()));
        Ok(Self { scheme, host, path: url.path().to_owned(), place })
    }

    /// The path of a URL below this one, if it is there.
    #[must_use]
    pub fn below(&self, url: &Url) -> Option<String> {
        let host_fits = self.host.as_ref().is_none_or(|(host, port)| {
            let other = url.host_str().unwrap_or_default();
            let fits = match host.strip_prefix('*') {
                Some(end) => other.len() > end.len() && other.ends_with(end),
                None => other == host,
            };
            fits && url.port() == *port
        });
        let is_plain = url.username().is_empty() && url.password().is_none();
        if self.scheme != url.scheme() || !host_fits || !is_plain {
            return None;
        }
        let rest = url.path().strip_prefix(&self.path)?;
        // models/ is not the beginning of models-of-others/.
        let whole = self.path.ends_with('/') || rest.is_empty() || rest.starts_with('/');
        whole.then(|| rest.trim_start_matches('/').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allows(allowed: &str, url: &str) -> bool {
        Allowed::new("--allow-source", allowed).unwrap().below(&Url::parse(url).unwrap()).is_some()
    }

    #[test]
    fn prefixes_are_of_whole_hosts_and_folders() {
        for (allowed, url) in [
            ("https://a.org", "https://a.org/x.glb"),
            ("https://a.org/m", "https://a.org/m/x.glb"),
            ("https://a.org/m/", "https://a.org/m/x.glb"),
            ("https://*.a.org", "https://b.a.org/x"),
            ("https://", "https://anything.org/x"),
            ("http://a.org:81/", "http://a.org:81/x"),
        ] {
            assert!(allows(allowed, url), "{allowed} {url}");
        }
        for (allowed, url) in [
            ("https://a.org", "https://a.org.evil.net/x"),
            ("https://a.org", "https://a.org@evil.net/x"),
            ("https://a.org", "https://user@a.org/x"),
            ("https://a.org", "http://a.org/x"),
            ("https://a.org", "https://a.org:444/x"),
            ("https://a.org/m", "https://a.org/mm/x"),
            ("https://a.org/m/", "https://a.org/m/../x"),
            ("https://a.org/m/", "https://a.org/m/%2e%2e/x"),
            ("https://*.a.org", "https://a.org/x"),
            ("https://*.a.org", "https://b-a.org/x"),
        ] {
            assert!(!allows(allowed, url), "{allowed} {url}");
        }
        for wrong in ["a.org", "file:///etc", "local://x", "s3://"] {
            assert!(Allowed::new("--allow-source", wrong).is_err(), "{wrong}");
        }
    }
}
