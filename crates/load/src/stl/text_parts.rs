//! Facets of a text that is too large to be held as a whole.

use super::reduced::{Facet, Parts};
use super::{ENDS, KEYWORDS, Loop};
use crate::LoadError;
use crate::text::{Tokens, float};
use std::fs::File;
use std::io::{Read, Seek};

/// Bytes that are read at once.
const PART: usize = 1 << 20;

/// Bytes of the longest token: behind more without white space there is no text.
const LONGEST_TOKEN: usize = 1 << 16;

/// A text of facets.
pub(super) struct TextParts {
    pub(super) file: File,
}

impl Parts for TextParts {
    fn each(&mut self, take: &mut dyn FnMut(Facet)) -> Result<(), LoadError> {
        self.file.rewind()?;
        let mut facets = Facets::default();
        let mut buffer = Vec::new();
        loop {
            let had = buffer.len();
            (&mut self.file).take(PART as u64).read_to_end(&mut buffer)?;
            let has_ended = buffer.len() == had;
            // Tokens that may go on stay for the next part.
            let whole = match buffer.iter().rposition(u8::is_ascii_whitespace) {
                Some(end) if !has_ended => end.saturating_add(1),
                _ if has_ended || buffer.len() > LONGEST_TOKEN => buffer.len(),
                _ => 0,
            };
            facets.read(buffer.get(..whole).unwrap_or_default(), take);
            buffer.drain(..whole);
            if has_ended {
                return Ok(());
            }
        }
    }
}

/// Facets that are read token by token.
struct Facets {
    open: Loop,
    position: [f32; 3],
    /// Coordinates of the position that are still to come.
    missing: usize,
}

impl Default for Facets {
    fn default() -> Self {
        Self { open: Loop::Empty, position: [0.0; 3], missing: 0 }
    }
}

impl Facets {
    fn read(&mut self, text: &[u8], take: &mut dyn FnMut(Facet)) {
        let mut tokens = Tokens::new(text);
        while let Some(token) = tokens.next() {
            if self.missing > 0 && !is_keyword(token) {
                let at = self.position.len().saturating_sub(self.missing);
                if let Some(coordinate) = self.position.get_mut(at) {
                    *coordinate = float(token).unwrap_or(f32::NAN);
                }
                self.missing = self.missing.saturating_sub(1);
                if self.missing == 0 {
                    self.add_corner(take);
                }
                continue;
            }
            if self.missing > 0 {
                // A vertex without all of its coordinates.
                (self.missing, self.position) = (0, [f32::NAN; 3]);
                self.add_corner(take);
            }
            if token.eq_ignore_ascii_case(b"vertex") {
                self.missing = self.position.len();
            } else if ENDS.iter().any(|end| token.eq_ignore_ascii_case(end)) {
                if let Loop::Triangle(corners) = std::mem::replace(&mut self.open, Loop::Empty) {
                    take((corners, [0; 2]));
                }
            } else if token.eq_ignore_ascii_case(b"solid") || token.eq_ignore_ascii_case(b"endsolid") {
                // A name, unless facets follow on the same line.
                let after = tokens.clone();
                let line = tokens.rest_of_line();
                if line.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet")) {
                    tokens = after;
                }
            }
        }
    }

    /// Ends a corner; a loop of more than three is a fan.
    fn add_corner(&mut self, take: &mut dyn FnMut(Facet)) {
        let position = self.position;
        self.open = match std::mem::replace(&mut self.open, Loop::Empty) {
            Loop::Empty => Loop::One(position),
            Loop::One(a) => Loop::Two(a, position),
            Loop::Two(a, b) => Loop::Triangle([a, b, position]),
            Loop::Triangle([a, b, c]) => {
                take(([a, b, c], [0; 2]));
                Loop::Triangle([a, c, position])
            }
        };
    }
}

fn is_keyword(token: &[u8]) -> bool {
    token.first().is_some_and(u8::is_ascii_alphabetic)
        && KEYWORDS.iter().any(|keyword| token.eq_ignore_ascii_case(keyword))
}
