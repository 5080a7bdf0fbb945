//! Fair shares for textures that files name one by one.
//!
//! Most readers find textures while they build the scene, and cannot know which others follow: granted in turn, the first would
//! take all. So a file is read as if all of it fitted. If it does not, it is read again, and its textures are only
//! measured, by their headers; and once more, with a share for each that depends on its size alone
//! ([`Budget::share`]). Files that fit are read once.

use crate::budget::{Budget, Claim, Share};
use crate::encoded_image::Reduction;
use crate::warnings::Warnings;
use crate::{LoadError, Loaded};
use overcoat_core::limits::Limits;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Meaning of grants of textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Pass {
    /// All of each, while that fits.
    #[default]
    Trial,
    /// None is kept: their sizes are noted.
    Survey,
    /// The share of each.
    Shared,
}

/// Results of the passes over a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shares(Arc<Found>);

#[derive(Debug, Default)]
struct Found {
    /// Bytes that all but textures take.
    others: AtomicU64,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    pass: Pass,
    /// All textures so far.
    claims: Vec<Claim>,
    share: Option<Share>,
    /// The first that is kept smaller: its name, its size and its level.
    reduced: Option<(String, [u32; 2], u32)>,
    /// Number of those beside it.
    more_reduced: usize,
}

/// Reads a file, as often as its textures make it necessary.
///
/// # Errors
/// Errors of the reader.
pub(crate) fn read(
    limits: &Limits,
    mut reader: impl FnMut(&Shares) -> Result<Loaded, LoadError>,
) -> Result<Loaded, LoadError> {
    let shares = Shares::default();
    let is_short = match reader(&shares) {
        Ok(loaded) if shares.pass() == Pass::Trial => return Ok(shares.warned(loaded)),
        Ok(_) => false,
        Err(LoadError::Limit(limit)) if limit.field == "decoded_bytes" && shares.has_textures() => true,
        Err(error) => return Err(error),
    };
    if is_short {
        // All else comes after the textures: how much it is, it tells without them.
        shares.measure();
        reader(&shares)?;
    }
    shares.divide(limits);
    Ok(shares.warned(reader(&shares)?))
}

impl Shares {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn pass(&self) -> Pass {
        self.state().pass
    }

    /// A reader starts, or starts again.
    pub(crate) fn start(&self) {
        self.count_others(0);
        let mut state = self.state();
        state.claims.clear();
        (state.reduced, state.more_reduced) = (None, 0);
    }

    /// Notes the bytes that all but textures take so far.
    pub(crate) fn count_others(&self, bytes: u64) {
        self.0.others.store(bytes, Ordering::Relaxed);
    }

    /// Notes a texture.
    pub(crate) fn note(&self, claim: Claim) {
        self.state().claims.push(claim);
    }

    fn has_textures(&self) -> bool {
        !self.state().claims.is_empty()
    }

    /// From now on textures are measured only.
    pub(crate) fn measure(&self) {
        self.state().pass = Pass::Survey;
    }

    /// Makes the shares of all textures that were noted.
    fn divide(&self, limits: &Limits) {
        let mut budget = Budget::new(limits);
        let others = self.0.others.load(Ordering::Relaxed);
        // They have been granted before.
        let is_granted = budget.charge(String::new, others, 1).is_ok();
        let mut state = self.state();
        state.share = is_granted.then(|| budget.share(&state.claims, true));
        state.pass = Pass::Shared;
    }

    /// Takes the share of a texture.
    pub(crate) fn reduce(&self, claim: &mut Claim) {
        if let Some(share) = &mut self.state().share {
            claim.reduce_to(share);
        }
    }

    /// Notes a texture whose mip levels from `finest` on are kept.
    pub(crate) fn say_reduced(&self, name: &str, size: [u32; 2], finest: u32) {
        if finest == 0 {
            return;
        }
        let mut state = self.state();
        if state.reduced.is_some() {
            state.more_reduced = state.more_reduced.saturating_add(1);
        } else {
            state.reduced = Some((name.to_owned(), size, finest));
        }
    }

    /// The file as it was read, with one warning for all textures that are kept smaller.
    fn warned(&self, mut loaded: Loaded) -> Loaded {
        let state = self.state();
        let Some((name, size, finest)) = &state.reduced else { return loaded };
        let mut warnings = Warnings::default();
        Reduction::new(name, *size, *finest).warn(state.more_reduced, &mut warnings);
        loaded.warnings.extend(warnings.finish());
        loaded
    }
}

#[cfg(all(test, feature = "more-models", feature = "3mf", feature = "obj", feature = "ply-stl"))]
mod tests;
