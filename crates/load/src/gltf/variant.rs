//! KHR_materials_variants: one model in several finishes.

use super::list::Index;
use super::model::{Primitive, Root};
use crate::LoadError;
use overcoat_core::suggest::{nearest_name, suggestion};

/// Most names that a message lists.
const LISTED: usize = 20;

/// The names of all variants.
pub(super) fn names(root: &Root) -> impl Iterator<Item = &str> {
    let variants = root.extensions.variants.iter().flat_map(|given| given.variants.iter());
    variants.map(|variant| variant.name.as_str())
}

/// The number of the variant with this name; where none is called so, a number from 0 stands for itself.
///
/// # Errors
/// [`LoadError::NoSuch`] with the names that the file has.
pub(super) fn chosen(root: &Root, name: Option<&str>) -> Result<Option<Index>, LoadError> {
    let Some(name) = name else { return Ok(None) };
    let variants = root.extensions.variants.as_ref().map_or(&[][..], |given| &given.variants);
    let named = variants.iter().position(|variant| variant.name == name);
    let found = named.or_else(|| name.parse().ok().filter(|&number| number < variants.len()));
    if let Some(index) = found.and_then(|number| u32::try_from(number).ok()) {
        return Ok(Some(Index(index)));
    }
    let mut known: Vec<String> =
        variants.iter().take(LISTED).map(|variant| format!("'{}'", short(&variant.name))).collect();
    match variants.len().checked_sub(LISTED) {
        _ if variants.is_empty() => known.push("none".to_owned()),
        None | Some(0) => {}
        Some(unlisted) => known.push(format!("{unlisted} more")),
    }
    let known = known.join(", ");
    // Files may have very many: only the first are looked at.
    let names = variants.iter().take(1000).map(|variant| variant.name.as_str());
    let hint = suggestion(nearest_name(name, names).map(short).as_deref());
    let shown = short(name);
    Err(LoadError::no_such(format!("there is no material variant '{shown}'; the file has {known}{hint}")))
}

fn short(name: &str) -> String {
    name.chars().take(48).collect()
}

/// The material of a primitive: the variant's, or its own where the variant says nothing about it.
pub(super) fn material(primitive: &Primitive, variant: Option<Index>) -> Option<Index> {
    let mappings = primitive.extensions.as_deref().and_then(|e| e.variants.as_ref());
    let mapped = variant.zip(mappings).and_then(|(variant, given)| {
        let mapping = given.mappings.iter().find(|mapping| mapping.variants.contains(&variant));
        mapping.and_then(|mapping| mapping.material)
    });
    mapped.or(primitive.material)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn root(names: &[&str]) -> Root {
        let variants: Vec<Value> = names.iter().map(|name| json!({"name": name})).collect();
        let json = json!({"extensions": {"KHR_materials_variants": {"variants": variants}}});
        serde_json::from_value(json).unwrap()
    }

    #[test]
    fn names_go_before_numbers() {
        let root = root(&["midnight", "beach", "0", "street"]);
        let find = |name| chosen(&root, Some(name)).map_err(|e| e.to_string());
        assert_eq!(chosen(&root, None).unwrap(), None);
        assert_eq!(find("beach"), Ok(Some(Index(1))));
        assert_eq!(find("0"), Ok(Some(Index(2))));
        assert_eq!(find("3"), Ok(Some(Index(3))));
        for missing in ["4", "-1", "Beach", ""] {
            let message = format!(
                "there is no material variant '{missing}'; the file has 'midnight', 'beach', '0', 'street'"
            );
            assert!(find(missing).is_err_and(|error| error.starts_with(&message)), "{missing}");
        }
    }

    #[test]
    fn long_lists_are_cut_short() {
        let names: Vec<String> = (0..50).map(|k| format!("v{k}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = chosen(&root(&names), Some("x")).unwrap_err().to_string();
        assert!(error.ends_with("'v19', 30 more") && !error.contains("v20"), "{error}");
        let none = chosen(&Root::default(), Some("x")).unwrap_err().to_string();
        assert!(none.ends_with("the file has none"), "{none}");
    }

    #[test]
    fn primitives_without_a_word_about_the_variant_keep_their_material() {
        let mapped = json!({"material": 7, "extensions": {"KHR_materials_variants": {"mappings": [
            {"material": 2, "variants": [0, 3]}, {"material": 4, "variants": [1]}, {"variants": [5]},
        ]}}});
        let primitive: Primitive = serde_json::from_value(mapped).unwrap();
        let of = |variant: Option<u32>| material(&primitive, variant.map(Index)).map(|index| index.0);
        assert_eq!(of(None), Some(7));
        assert_eq!([0, 1, 2, 3, 5].map(|v| of(Some(v))), [Some(2), Some(4), Some(7), Some(2), Some(7)]);
    }
}
