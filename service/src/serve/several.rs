//! Several pictures of one model in one request: every preset of a list, in every view, in every size.

use super::error::{Kind, Problem};
use super::options::{Options, Priced};
use super::rules::Rules;
use overcoat::output::OutputFormat;
use std::collections::BTreeSet;

/// Lists of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Several {
    presets: Vec<String>,
    views: Vec<String>,
    sizes: Vec<String>,
}

/// One of several pictures.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name of its file.
    pub name: String,
    /// The picture.
    pub priced: Priced,
}

/// All pictures of a request.
#[derive(Clone, Debug)]
pub struct Parts {
    /// In the order of the lists, the first of which changes last.
    pub all: Vec<Part>,
    /// Price of all together.
    pub price: u64,
}

impl Several {
    /// Takes a list; false if there is no list of this name.
    ///
    /// # Errors
    /// [`Kind::Options`] for an empty list, and for one that has something twice.
    pub fn set(&mut self, key: &str, text: &str) -> Result<bool, Problem> {
        let list = match key {
            "presets" => &mut self.presets,
            "views" => &mut self.views,
            "sizes" => &mut self.sizes,
            _ => return Ok(false),
        };
        // Directions have commas in them.
        let separator = if text.contains(';') { ';' } else { ',' };
        let values: Vec<String> = text.split(separator).map(|value| value.trim().to_owned()).collect();
        let wrong = |what: String| Problem::new(Kind::Options, format!("{key}: {what}"));
        if values.iter().any(String::is_empty) {
            return Err(wrong(format!(
                "expected values with commas (or semicolons) between them, got '{text}'"
            )));
        }
        let mut known = BTreeSet::new();
        if let Some(twice) = values.iter().find(|value| !known.insert(value.as_str())) {
            return Err(wrong(format!("'{twice}' stands there twice")));
        }
        *list = values;
        Ok(true)
    }

    /// True if there are no lists.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The pictures of the lists, each with the options that they share; `most` at most.
    ///
    /// # Errors
    /// [`Kind::Options`], [`Kind::Price`] of all together, and those of single pictures, with the names of these.
    pub fn parts(&self, shared: &Options, rules: &Rules, most: usize) -> Result<Parts, Problem> {
        let of = |list: &Vec<String>| list.len().max(1);
        let count = of(&self.presets).saturating_mul(of(&self.views)).saturating_mul(of(&self.sizes));
        if count > most {
            let message = format!("the lists ask for {count} pictures, and {most} are allowed in a request");
            return Err(Problem::new(Kind::Options, message)
                .limited("max_pictures", "start the service with --max-pictures N"));
        }
        let (mut all, mut price, mut names) = (Vec::with_capacity(count), 0_u64, BTreeSet::new());
        for preset in choices(&self.presets) {
            for view in choices(&self.views) {
                for size in choices(&self.sizes) {
                    let chosen = [("preset", preset), ("view", view), ("size", size)];
                    let part = part(shared, &chosen, rules)?;
                    price = price.saturating_add(part.priced.price);
                    if !names.insert(part.name.clone()) {
                        let message = format!("two of the pictures would be called '{}'", part.name);
                        return Err(Problem::new(Kind::Options, message));
                    }
                    all.push(part);
                }
            }
        }
        rules.check_price(price)?;
        Ok(Parts { all, price })
    }
}

/// The values of a list, or none of an empty one.
fn choices(list: &[String]) -> Vec<Option<&str>> {
    match list {
        [] => vec![None],
        list => list.iter().map(|value| Some(value.as_str())).collect(),
    }
}

fn part(shared: &Options, chosen: &[(&str, Option<&str>)], rules: &Rules) -> Result<Part, Problem> {
    let mut options = shared.clone();
    let mut name = Vec::new();
    for (key, value) in chosen.iter().filter_map(|(key, value)| Some((key, (*value)?))) {
        options.set(key, value, rules)?;
        // Characters other than letters, digits and dots may mean something to a file system.
        let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
        name.push(value.trim_start_matches('.').chars().map(plain).collect::<String>());
    }
    let name = name.join("-");
    let format: OutputFormat = options.format.unwrap_or(rules.format);
    let priced = options.priced(format, rules).map_err(|problem| problem.of(&name))?;
    Ok(Part { name: format!("{name}.{}", priced.request.format), priced })
}

#[cfg(test)]
mod tests {
    use super::super::options::{of_pairs, tests::rules};
    use super::*;

    fn parts(pairs: &[(&str, &str)], max_price: Option<u64>) -> Result<Parts, Problem> {
        let rules = Rules { max_price, ..rules() };
        let options = of_pairs(pairs.iter().copied(), &rules)?;
        options.several.parts(&options, &rules, 12)
    }

    #[test]
    fn every_preset_has_every_view_in_every_size() {
        let all =
            parts(&[("sizes", "32,64x48"), ("views", "front, left"), ("format", "webp")], None).unwrap();
        let names: Vec<&str> = all.all.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["front-32.webp", "front-64x48.webp", "left-32.webp", "left-64x48.webp"]);
        assert_eq!(all.price, all.all.iter().map(|part| part.priced.price).sum::<u64>());
        let keys = &all.all[3].priced.request.keys;
        assert_eq!((&keys["size"], &keys["camera"]["view"]), (&[64, 48].into(), &"left".into()));
        let all = parts(&[("presets", "thumb"), ("views", "1,0,2;0,1,0")], None).unwrap();
        let names: Vec<&str> = all.all.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["thumb-1_0_2.png", "thumb-0_1_0.png"]);
    }

    #[test]
    fn lists_are_bounded_and_their_mistakes_named() {
        for (pairs, what) in [
            (&[("sizes", "32,32")][..], "sizes: '32' stands there twice"),
            (&[("sizes", "32,,64")], "sizes: expected values with commas"),
            (&[("sizes", "")], "sizes: expected values"),
            (&[("sizes", "32,huge")], "WIDTHxHEIGHT"),
            (&[("sizes", "32,2000")], "1 to 1024"),
            (&[("presets", "thumb,none")], "there is none 'none'"),
            (&[("views", "front,nowhere")], "view"),
            (&[("views", "1,0,2;1 0 2")], "view"),
            (&[("sizes", "1,2,3,4,5,6,7,8,9,10,11,12,13")], "13 pictures, and 12 are allowed"),
        ] {
            let problem = parts(pairs, None).unwrap_err();
            assert!(problem.message.contains(what), "{pairs:?}: {}", problem.message);
        }
        let lists = [("sizes", "100,200"), ("views", "front,left")];
        let price = parts(&lists, None).unwrap().price;
        assert!(parts(&lists, Some(price)).is_ok());
        assert_eq!(parts(&lists, Some(price - 1)).unwrap_err().kind, Kind::Price);
    }
}
