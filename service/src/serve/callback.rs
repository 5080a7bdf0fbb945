//! Callbacks: results of jobs, sent to where clients want them, if the operator allows that place.

use super::address::Network;
use super::allowed::Allowed;
use super::error::{Kind, Problem};
use super::fetch::Fetcher;
use super::sign::Signer;
use super::spool::Outcome;
use axum::http::{HeaderName, StatusCode, header};
use bytes::Bytes;
use std::time::Duration;
use url::Url;

/// Characters of a URL at most.
const LONGEST: usize = 2000;
/// Name of the job.
const JOB: HeaderName = HeaderName::from_static("overcoat-job");
/// Status that the request would have been answered with.
const STATUS: HeaderName = HeaderName::from_static("overcoat-status");
/// Seconds since 1970.
const TIME: HeaderName = HeaderName::from_static("overcoat-time");
/// Signature of all three and the body.
const SIGNATURE: HeaderName = HeaderName::from_static("overcoat-signature");

/// Places that results may be sent to.
#[derive(Debug)]
pub struct Callbacks {
    allowed: Vec<Allowed>,
    fetcher: Fetcher,
    patience: Duration,
}

fn refused(message: &str) -> Problem {
    Problem::new(Kind::Callback, format!("callback: {message}"))
}

/// A private address is the callback's here.
fn of_callback(problem: Problem) -> Problem {
    match problem.kind {
        Kind::Source => refused("it is in a private network"),
        _ => Problem { message: problem.message.replace("the source", "the callback"), ..problem },
    }
}

impl Callbacks {
    /// Places that begin with these URLs, at public addresses or in these networks.
    ///
    /// # Errors
    /// One line.
    pub fn new(allowed: &[String], networks: &[String], patience: Duration) -> Result<Self, String> {
        let networks =
            networks.iter().map(|text| Network::new(text).map_err(|e| format!("--allow-network {e}")));
        let fetcher = Fetcher::new(networks.collect::<Result<_, _>>()?);
        let allowed = allowed.iter().map(|text| Allowed::new("--allow-callback", text));
        Ok(Self { allowed: allowed.collect::<Result<_, _>>()?, fetcher, patience })
    }

    /// Checks that results may be sent to a URL.
    ///
    /// # Errors
    /// [`Kind::Callback`]; [`Kind::Options`] if it is no URL.
    pub async fn check(&self, text: &str) -> Result<(), Problem> {
        let url = self.allowed(text)?;
        let checked = tokio::time::timeout(self.patience, self.fetcher.check(&url)).await;
        checked.map_err(|_| refused("its host is not found in time"))?.map_err(of_callback)
    }

    fn allowed(&self, text: &str) -> Result<Url, Problem> {
        let wrong = |what: &str| Problem::new(Kind::Options, format!("callback: {what}"));
        if text.len() > LONGEST {
            return Err(wrong("it is too long"));
        }
        let url = Url::parse(text).map_err(|e| wrong(&format!("expected a URL: {e}")))?;
        let fits = matches!(url.scheme(), "http" | "https")
            && self.allowed.iter().any(|allowed| allowed.below(&url).is_some());
        fits.then_some(url).ok_or_else(|| refused("it is not allowed here"))
    }

    /// Sends a result, signed.
    ///
    /// # Errors
    /// [`Problem`], also of an answer that is no success.
    pub async fn send(
        &self,
        (callback, signer): (&str, &Signer),
        (job, time): (&str, u64),
        outcome: &Outcome,
        result: Bytes,
    ) -> Result<(), Problem> {
        let url = self.allowed(callback)?;
        let failed = |message: String| Problem::new(Kind::SourceFailed, message);
        let before = format!("{job}.{time}.{}.", outcome.status);
        let signature = signer.sign_bytes(&[before.as_bytes(), &result]);
        let signature = signature.ok_or_else(|| failed("there is no key for its signature".to_owned()))?;
        let headers = [
            (header::CONTENT_TYPE, outcome.content_type.clone()),
            (JOB, job.to_owned()),
            (STATUS, outcome.status.to_string()),
            (TIME, time.to_string()),
            (SIGNATURE, signature),
        ];
        let sent = tokio::time::timeout(self.patience, self.fetcher.post(&url, &headers, result)).await;
        let status: StatusCode =
            sent.map_err(|_| failed("the callback takes too long".to_owned()))?.map_err(of_callback)?;
        if status.is_success() {
            Ok(())
        } else {
            Err(failed(format!("the callback answers {}", status.as_u16())))
        }
    }
}
