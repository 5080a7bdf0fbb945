//! Files that a model names: where they are when they are not where the name says.
//!
//! Models are moved, and their textures are gathered in one folder, or left in the folder of the author's machine. So a file is
//! looked for relative to the file that names it, relative to the model, and then by the end of its path in both; last of all
//! under a name that differs in case only. The [`Resolver`](super::Resolver) lets nothing out of the model's folder.

use super::names::shown;
use super::text::quoted;
use super::{Context, ResolveError};

/// Most parts of a path that its end has.
const PARTS: usize = 6;
/// Most files that are looked for in the lists of folders: each costs a look at every name.
const LOOKS: u32 = 64;

/// A file that was found.
pub(super) struct Found {
    /// Its name relative to the model, with `/` between the parts.
    pub(super) name: String,
    pub(super) bytes: Vec<u8>,
    /// Warning that it was found at another place than named: one line.
    pub(super) note: Option<String>,
}

/// Looks for the files of one model.
#[derive(Debug, Default)]
pub(super) struct Nearby {
    looks: u32,
}

impl Nearby {
    /// Reads a file of at most `limit` bytes that a file in `folder` (relative to the model, empty for its own) names.
    /// Other readings of the same name are tried after it.
    ///
    /// # Errors
    /// Why the first place has none.
    pub(super) fn read<'n>(
        &mut self,
        context: &Context<'_>,
        folder: &str,
        names: impl IntoIterator<Item = &'n str>,
        limit: u64,
    ) -> Result<Found, ResolveError> {
        let resolver = context.resolver;
        let mut tried: Vec<String> = Vec::new();
        let mut first = None;
        for name in names {
            for place in places(folder, &shown(name)) {
                if tried.contains(&place) {
                    continue;
                }
                match resolver.read(&place, limit) {
                    Ok(bytes) => return Ok(Found { name: place, bytes, note: None }),
                    Err(error @ (ResolveError::TooLarge { .. } | ResolveError::NotAllowed(_))) => {
                        return Err(error);
                    }
                    Err(error) => _ = first.get_or_insert(error),
                }
                tried.push(place);
            }
        }
        if self.looks < LOOKS {
            self.looks = self.looks.saturating_add(1);
            for place in &tried {
                if let Some((name, bytes)) = resolver.read_alike(place, limit) {
                    let note = Some(format!("{} is taken", quoted(name.as_bytes())));
                    return Ok(Found { name, bytes: bytes?, note });
                }
            }
        }
        Err(first.unwrap_or_else(|| ResolveError::Unreadable {
            name: String::new(),
            reason: "it has no name".to_owned(),
        }))
    }
}

/// The folder that a file is in.
pub(super) fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Candidate paths of a file, best first.
fn places(folder: &str, name: &str) -> Vec<String> {
    let portable = name.trim().trim_matches(['"', '\'']).replace('\\', "/");
    let portable = portable.strip_prefix("./").unwrap_or(&portable);
    // Poser separates folders by colons, as the Macintosh did: `:Runtime:Textures:t.png`.
    // Two in a row begin the name of a data stream on Windows.
    let colons = !portable.contains('/')
        && !portable.contains("::")
        && (portable.starts_with(':') || portable.matches(':').count() > 1);
    let with_slashes = colons.then(|| portable.replace(':', "/"));
    let portable = with_slashes.as_deref().map_or(portable, |portable| portable.trim_start_matches('/'));
    let mut out = Vec::new();
    let mut add = |name: &str| {
        for place in [joined(folder, name), name.to_owned()] {
            if !out.contains(&place) {
                out.push(place);
            }
        }
    };
    // The resolver takes only the end of paths with drives, servers or a root.
    let absolute = portable.starts_with('/') || portable.contains(':');
    add(portable);
    let parts: Vec<&str> = portable.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    let ends =
        (0..parts.len()).filter(|&k| k > 0 || absolute).filter(|&k| parts.len().saturating_sub(k) <= PARTS);
    for end in ends.filter_map(|k| parts.get(k..)) {
        if !end.iter().any(|part| *part == ".." || part.contains(':')) {
            add(&end.join("/"));
        }
    }
    out
}

/// A name relative to a folder, without `..` as far as there are folders to leave.
fn joined(folder: &str, name: &str) -> String {
    if folder.is_empty() || name.starts_with('/') || name.contains(':') {
        return name.to_owned();
    }
    let mut parts: Vec<&str> = folder.split('/').collect();
    for part in name.split('/') {
        match part {
            "." | "" => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => _ = parts.pop(),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_a_name() {
        let all = |folder: &str, name: &str| places(folder, name).join(" ");
        assert_eq!(all("", "t.png"), "t.png");
        assert_eq!(all("mats", "t.png"), "mats/t.png t.png");
        assert_eq!(all("mats", r".\img\t.png"), "mats/img/t.png img/t.png mats/t.png t.png");
        assert_eq!(all("a/b", "../../t.png"), "t.png ../../t.png a/b/t.png");
        assert_eq!(
            all("", r#""C:\work\tex\my t.png""#),
            "C:/work/tex/my t.png work/tex/my t.png tex/my t.png my t.png"
        );
        assert_eq!(all("", ":Runtime:Textures:t.png"), "Runtime/Textures/t.png Textures/t.png t.png");
        assert_eq!(all("m", "Runtime:Textures:t.png").split(' ').next(), Some("m/Runtime/Textures/t.png"));
        assert_eq!(all("", ":t.png"), "t.png");
        assert_eq!(all("", "/home/x/t.png"), "/home/x/t.png home/x/t.png x/t.png t.png");
        assert_eq!(all("m", r"\\server\share\t.png").split(' ').next_back(), Some("t.png"));
        assert_eq!(all("", "a/b/c/d/e/f/g/h/t.png").split(' ').count(), 7);
        assert_eq!(folder_of("a/b.mtl"), "a");
        assert_eq!(folder_of("b.mtl"), "");
    }
}
