//! Collects warnings, and keeps hostile files from drowning the reader in them.
use super::Warning;

/// Most warnings that one file may give; the rest is counted.
const MOST: usize = 100;

/// Warnings in the order of finding.
#[derive(Clone, Debug, Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    more: usize,
}

impl Warnings {
    /// Adds one, unless it is the same as the last one. The text is only made if there is room for it.
    pub(crate) fn add(&mut self, message: impl FnOnce() -> String) {
        self.add_of(Warning::FILE, message);
    }

    /// Adds one about a texture that is left out, likewise.
    pub(crate) fn add_texture(&mut self, message: impl FnOnce() -> String) {
        self.add_of(Warning::TEXTURE, message);
    }

    fn add_of(&mut self, code: &'static str, message: impl FnOnce() -> String) {
        if self.list.len() < MOST {
            let warning = Warning::new(message()).with_code(code);
            if self.list.last() != Some(&warning) {
                self.list.push(warning);
            }
        } else {
            self.more = self.more.saturating_add(1);
        }
    }

    /// The list, with a last line that counts those without room.
    pub(crate) fn finish(mut self) -> Vec<Warning> {
        if self.more > 0 {
            self.list.push(Warning::new(format!("and {} more warnings", self.more)));
        }
        self.list
    }
}

/// "1 triangle", "2 triangles".
pub(super) fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_bounded_and_says_how_much_is_missing() {
        let mut warnings = Warnings::default();
        for k in 0..1000 {
            warnings.add(|| k.to_string());
        }
        let mut same = Warnings::default();
        for k in [1, 1, 2, 1] {
            same.add(|| k.to_string());
        }
        assert_eq!(same.finish().len(), 3);
        let list = warnings.finish();
        assert_eq!(list.len(), MOST + 1);
        assert_eq!(list[MOST].message, "and 900 more warnings");
    }
}
