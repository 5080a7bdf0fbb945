//! Which known name somebody may have meant: "did you mean".

/// The name that is fewest edits away from `name`, if it is near enough to be a misspelling; the first of several.
///
/// Letters count alike in upper and lower case, and `-` as `_`.
pub fn nearest_name<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Names of hostile files can be long, and the distance takes the product of two lengths.
    let plain = |text: &str| -> Vec<char> {
        text.chars().take(64).map(|c| if c == '-' { '_' } else { c.to_ascii_lowercase() }).collect()
    };
    let name = plain(name);
    let nearest = known.into_iter().map(|k| (distance(&name, &plain(k)), k)).min_by_key(|(d, _)| *d)?;
    (nearest.0 <= (name.len() / 2).saturating_add(1)).then_some(nearest.1)
}

/// The known name that is the same but for upper and lower case, `-` and `_`: `fov_y_deg` for `fovYDeg` and `fov-y-deg`.
pub fn same_name<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let letters = |text: &str| -> String {
        text.chars().filter(|c| !matches!(c, '-' | '_')).map(|c| c.to_ascii_lowercase()).take(64).collect()
    };
    let name = letters(name);
    known.into_iter().find(|known| letters(known) == name)
}

/// Levenshtein's distance: insertions, deletions and replacements.
fn distance(a: &[char], b: &[char]) -> usize {
    // From what has been seen of `a` to nothing, and to as many letters of `b` as there are numbers before.
    let mut to_nothing = 0_usize;
    let mut row: Vec<usize> = (1..=b.len()).collect();
    for x in a {
        let (mut above, mut left) = (to_nothing, to_nothing.saturating_add(1));
        to_nothing = left;
        for (y, distance) in b.iter().zip(&mut row) {
            let replaced = above.saturating_add(usize::from(x != y));
            above = *distance;
            left = replaced.min(above.saturating_add(1)).min(left.saturating_add(1));
            *distance = left;
        }
    }
    row.last().copied().unwrap_or(to_nothing)
}

/// `; did you mean 'x'?`, or nothing.
pub fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean '{name}'?"))
}

/// The name that a message suggests by [`suggestion`].
pub fn suggested(message: &str) -> Option<&str> {
    let (_, name) = message.split_once("; did you mean '")?;
    name.split_once("'?").map(|(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_are_recognised_and_other_words_are_not() {
        let known = ["roughness", "coat", "coat_roughness", "normal_texture"];
        assert_eq!(nearest_name("rougness", known), Some("roughness"));
        assert_eq!(nearest_name("Coat-Roughness", known), Some("coat_roughness"));
        assert_eq!(nearest_name("normal_texure", known), Some("normal_texture"));
        assert_eq!(nearest_name("cot", known), Some("coat"));
        assert_eq!(nearest_name("xyzzy", known), None);
        assert_eq!(nearest_name("x", []), None);
    }

    #[test]
    fn suggestions_are_found_in_messages() {
        let message = format!("there is no 'x'{} (see --help)", suggestion(Some("exposure")));
        assert_eq!(suggested(&message), Some("exposure"));
        for message in ["", "there is no 'x'", "; did you mean 'x"] {
            assert_eq!(suggested(message), None);
        }
    }

    #[test]
    fn other_spellings_are_the_same_name() {
        let known = ["fov_y_deg", "env"];
        for name in ["fov_y_deg", "fovYDeg", "fov-y-deg", "FOV_Y_DEG"] {
            assert_eq!(same_name(name, known), Some("fov_y_deg"), "{name}");
        }
        assert_eq!((same_name("fov", known), same_name("", known)), (None, None));
    }

    #[test]
    fn distances() {
        let d = |a: &str, b: &str| distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>());
        assert_eq!((d("", ""), d("", "ab"), d("ab", ""), d("kitten", "sitting")), (0, 2, 2, 3));
    }
}
