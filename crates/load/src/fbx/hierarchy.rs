//! Models below models: where each stands, and whether it is shown.

use super::document::{Document, Kind, Object};
use super::transform::Placement;

/// A model in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    pub(super) placement: Placement,
    pub(super) is_shown: bool,
}

/// Models of a document, by the numbers of their objects. `None` for other objects, and for models that are below themselves or
/// moved too far.
pub(super) fn stands(document: &Document<'_>) -> Vec<Option<Stand>> {
    let count = document.objects.len();
    let mut parents: Vec<Option<usize>> = vec![None; count];
    // Only the first parent of a model counts.
    for (parent, object) in
        document.objects.iter().enumerate().filter(|(_, object)| object.kind == Kind::Model)
    {
        for child in children(document, object) {
            if let Some(slot) = parents.get_mut(child) {
                slot.get_or_insert(parent);
            }
        }
    }
    let mut stands = vec![None; count];
    let is_root = |(number, object): (usize, &Object<'_>)| {
        let is_free = parents.get(number) == Some(&None);
        (object.kind == Kind::Model && is_free)
            .then_some((number, Stand { placement: Placement::ROOT, is_shown: true }))
    };
    let mut left: Vec<(usize, Stand)> = document.objects.iter().enumerate().filter_map(is_root).collect();
    while let Some((number, parent)) = left.pop() {
        let Some(object) = document.objects.get(number) else { continue };
        let Ok(placement) = parent.placement.child(&object.properties) else { continue };
        let is_off = |name: &str| object.properties.number(name) == Some(0.0);
        let inherits = !is_off("Visibility Inheritance") && !is_off("VisibilityInheritance");
        let is_shown = (parent.is_shown || !inherits) && !is_off("Visibility") && !is_off("Show");
        let stand = Stand { placement, is_shown };
        if let Some(slot) = stands.get_mut(number) {
            *slot = Some(stand);
        }
        let is_choice = is_lod_group(document, number, object);
        let own = children(document, object).filter(|&child| parents.get(child) == Some(&Some(number)));
        // The first of a group of levels of detail is the finest.
        left.extend(
            own.enumerate()
                .map(|(k, child)| (child, Stand { is_shown: is_shown && !(is_choice && k > 0), ..stand })),
        );
    }
    stands
}

/// Models below one.
fn children<'d>(document: &'d Document<'_>, object: &'d Object<'_>) -> impl Iterator<Item = usize> + 'd {
    let is_model =
        |number: usize| document.objects.get(number).is_some_and(|object| object.kind == Kind::Model);
    // Connections to properties are those of constraints.
    object
        .links
        .iter()
        .filter(|(_, property)| property.is_none())
        .map(|(number, _)| *number)
        .filter(move |&n| is_model(n))
}

fn is_lod_group(document: &Document<'_>, number: usize, object: &Object<'_>) -> bool {
    object.class == b"LodGroup"
        || document.linked(number, Kind::Attribute).any(|(_, attribute)| attribute.class == b"LodGroup")
}
