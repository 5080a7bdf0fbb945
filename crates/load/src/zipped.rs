//! A model in a ZIP archive, as downloads come: the model, its materials and its textures.
//!
//! Nothing is written to a disk. Sizes and ratios are limited as those of 3MF parts, and all that is inflated together by
//! [`Limits::decoded_bytes`](overcoat_core::limits::Limits::decoded_bytes); an archive in the archive stays closed.

use super::archive::{Archive, MAGIC};
use super::budget::Budget;
use super::gltf::Purpose;
use super::nearby::folder_of;
use super::text::quoted;
use super::warnings::{Warnings, counted};
use super::{Claim, Context, Format, LoadError, LoadOptions, Model, ResolveError, Resolver, read_unpacked};
use overcoat_core::files::check_size;
use overcoat_core::jobs::lock;
use std::sync::Mutex;

/// Name of the format in messages.
const FORMAT: &str = "ZIP";

/// Most models that a message names.
const NAMED: usize = 6;

/// Reads the model in an archive; `None` for what is no archive, has no model in it, or is of a format of its own.
///
/// # Errors
/// [`LoadError`] if there are several models and none lies less deep than the others, or the model cannot be read.
pub(super) fn read(
    bytes: &[u8],
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Option<(Model, Option<Format>)>, LoadError> {
    if !bytes.starts_with(MAGIC) {
        return Ok(None);
    }
    let limits = context.limits;
    let mut warnings = Warnings::default();
    let archive = match Archive::open(FORMAT, bytes, limits, &mut warnings) {
        Ok(archive) => archive,
        Err(error @ LoadError::Limit(_)) => return Err(error),
        // Other readers report other errors.
        Err(_) => return Ok(None),
    };
    // Documents of Office have such a part; models in them are pictures of a page.
    if archive.has("[content_types].xml") {
        return Ok(None);
    }
    let Some(name) = choose(&archive, &mut warnings)? else { return Ok(None) };
    let name = name.to_owned();
    check_size(archive.size(&name).unwrap_or(0), limits)?;
    let mut budget = Budget::new(limits);
    let content = archive.read(&name, &mut budget)?;
    if content.starts_with(MAGIC) && Format::detect(&content).is_none() {
        let message = format!("part {} is an archive too, and stays closed", quoted(name.as_bytes()));
        return Err(LoadError::unsupported(FORMAT, message));
    }
    let named = name.rsplit_once('.').and_then(|(_, extension)| Format::from_extension(extension));
    let resolver = ZipResolver::new(archive, name, budget);
    let inner = Context { resolver: &resolver, limits, jobs: context.jobs };
    let (mut model, format) = read_unpacked(&content, Claim { said: None, named }, options, purpose, &inner)?;
    warnings.finish().into_iter().for_each(|warning| model.warn(warning));
    Ok(Some((model, format)))
}

/// The name of the model: the only one, or the only one in so few folders.
fn choose<'a>(archive: &'a Archive<'_>, warnings: &mut Warnings) -> Result<Option<&'a str>, LoadError> {
    let depth = |name: &str| name.matches('/').count();
    let mut models: Vec<&str> = archive.names().filter(|name| is_model(name)).collect();
    // In alphabetical order among those of one depth.
    models.sort_by_key(|name| depth(name));
    let Some((&first, others)) = models.split_first() else { return Ok(None) };
    if others.iter().any(|other| depth(other) == depth(first)) {
        let mut names: Vec<String> = models.iter().take(NAMED).map(|name| quoted(name.as_bytes())).collect();
        let more = models.len().saturating_sub(NAMED);
        if more > 0 {
            names.push(format!("{more} more"));
        }
        let names = names.join(", ");
        return Err(LoadError::unsupported(
            FORMAT,
            format!("there are several models in it ({names}): unpack one"),
        ));
    }
    if !others.is_empty() {
        let count = counted(others.len() as u64, "other model");
        let first = quoted(first.as_bytes());
        warnings.add(|| format!("{FORMAT}: {first} is read; {count} in deeper folders are left out"));
    }
    Ok(Some(first))
}

/// True for a model by its extension, if its name is a path that stays in the archive and no program's own note beside it.
fn is_model(name: &str) -> bool {
    let mut parts = name.split('/');
    let is_plain = !name.contains([':', '\0']) && !parts.any(|part| part == ".." || part.starts_with("._"));
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    is_plain && !name.starts_with("__macosx/") && Format::from_extension(extension).is_some()
}

/// Resolves to the parts of an archive, relative to the model in it and never out of it.
#[derive(Debug)]
pub(super) struct ZipResolver<'a> {
    archive: Archive<'a>,
    /// Name of the model.
    model: String,
    /// For all parts together.
    budget: Mutex<Budget>,
}

impl<'a> ZipResolver<'a> {
    /// For the parts beside a model.
    pub(super) fn new(archive: Archive<'a>, model: String, budget: Budget) -> Self {
        Self { archive, model, budget: Mutex::new(budget) }
    }

    /// The part that a reference of the model stands for.
    fn place(&self, name: &str) -> Result<String, ResolveError> {
        let outside = || ResolveError::Outside(name.to_owned());
        let portable = name.replace('\\', "/");
        if portable.contains([':', '\0']) || portable.starts_with('/') {
            return Err(outside());
        }
        let mut parts: Vec<&str> =
            folder_of(&self.model).split('/').filter(|part| !part.is_empty()).collect();
        for part in portable.split('/') {
            match part {
                "" | "." => {}
                ".." => _ = parts.pop().ok_or_else(outside)?,
                part => parts.push(part),
            }
        }
        Ok(parts.join("/"))
    }

    fn part(&self, place: &str, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        let unreadable = |reason: String| ResolveError::Unreadable {
            name: name.to_owned(),
            reason: reason.replace('\n', " "),
        };
        let size =
            self.archive.size(place).ok_or_else(|| unreadable("it is not in the archive".to_owned()))?;
        if size > limit {
            return Err(ResolveError::TooLarge { name: name.to_owned(), limit });
        }
        let read = self.archive.read(place, &mut lock(&self.budget));
        read.map(Into::into).map_err(|error| unreadable(error.to_string()))
    }
}

impl Resolver for ZipResolver<'_> {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        self.part(&self.place(name)?, name, limit)
    }

    /// The only part with this file name, in whatever folder.
    fn read_alike(&self, name: &str, limit: u64) -> Option<(String, Result<Vec<u8>, ResolveError>)> {
        let file_name = |path: &str| path.rsplit('/').next().unwrap_or_default().to_lowercase();
        let wanted = file_name(&name.replace('\\', "/"));
        let mut found = self.archive.names().filter(|part| file_name(part) == wanted && !wanted.is_empty());
        let (part, None) = (found.next()?, found.next()) else { return None };
        Some((part.to_owned(), self.part(part, part, limit)))
    }

    fn model_name(&self) -> Option<&str> {
        self.model.rsplit('/').next()
    }
}

#[cfg(test)]
mod tests;
