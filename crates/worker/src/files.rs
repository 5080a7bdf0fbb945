//! The files that a model refers to, from the worker's parent: the worker itself reads none.

use crate::pipe::Pipe;
use crate::protocol::{FromWorker, Missing, ToWorker};
use overcoat_load::{ResolveError, Resolver};

/// Asks the parent.
pub(crate) struct AskedFiles<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) model: &'a str,
}

/// An answer.
enum Answer {
    /// The bytes, and a name for them.
    File(Option<String>, Vec<u8>),
    Missing(Missing),
}

impl AskedFiles<'_> {
    fn ask(&self, name: &str, limit: u64, alike: bool) -> Answer {
        let lost = |reason: String| Answer::Missing(Missing::Unreadable { reason });
        let need = FromWorker::Need { name: name.to_owned(), limit, alike };
        match self.pipe.ask(&need) {
            Ok(Some((ToWorker::File { found }, bytes))) => Answer::File(found, bytes),
            Ok(Some((ToWorker::Missing(missing), _))) => Answer::Missing(missing),
            Ok(_) => lost("no answer".to_owned()),
            Err(e) => lost(e.to_string()),
        }
    }
}

/// In the words of the library.
fn error(missing: Missing, name: &str, limit: u64) -> ResolveError {
    let name = name.to_owned();
    match missing {
        Missing::TooLarge => ResolveError::TooLarge { name, limit },
        Missing::Outside => ResolveError::Outside(name),
        Missing::NotAllowed => ResolveError::NotAllowed(name),
        Missing::Unreadable { reason } => ResolveError::Unreadable { name, reason },
    }
}

impl Resolver for AskedFiles<'_> {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        match self.ask(name, limit, false) {
            Answer::File(_, bytes) if bytes.len() as u64 <= limit => Ok(bytes),
            Answer::File(..) => Err(error(Missing::TooLarge, name, limit)),
            Answer::Missing(missing) => Err(error(missing, name, limit)),
        }
    }

    fn read_alike(&self, name: &str, limit: u64) -> Option<(String, Result<Vec<u8>, ResolveError>)> {
        match self.ask(name, limit, true) {
            Answer::File(found, bytes) => Some((found.unwrap_or_else(|| name.to_owned()), Ok(bytes))),
            Answer::Missing(_) => None,
        }
    }

    fn model_name(&self) -> Option<&str> {
        Some(self.model)
    }
}
