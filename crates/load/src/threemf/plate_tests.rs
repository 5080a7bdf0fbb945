//! Plates that are chosen, and what is told of them.

use super::tests::{HEAD, zip};
use super::*;
use crate::NoResolver;
use overcoat_core::jobs::Jobs;

/// A project with two items of object 1 and one of object 2, each at another X (millimetres), on the plates of `config`.
fn project(config: &str) -> Vec<u8> {
    let object = |id: u32| {
        format!(
            "<object id=\"{id}\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"90\" y=\"0\" z=\"0\"/>\
             <vertex x=\"0\" y=\"90\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh></object>"
        )
    };
    let item = |object: u32, x: u32| {
        format!("<item objectid=\"{object}\" transform=\"1 0 0 0 1 0 0 0 1 {x} 0 0\"/>")
    };
    let text = format!(
        "{HEAD}><resources>{}{}</resources><build>{}{}{}</build></model>",
        object(1),
        object(2),
        item(1, 100),
        item(1, 400),
        item(2, 700)
    );
    let config = format!("<config>{config}</config>");
    let parts =
        [("3D/3dmodel.model", text.as_bytes()), ("Metadata/model_settings.config", config.as_bytes())];
    zip(&parts, true)
}

fn plate(number: u32, name: &str, items: &[(u32, u32)]) -> String {
    let items: String = items
        .iter()
        .map(|(object, instance)| {
            format!(
                "<model_instance><metadata key=\"object_id\" value=\"{object}\"/>\
                 <metadata key=\"instance_id\" value=\"{instance}\"/></model_instance>"
            )
        })
        .collect();
    format!(
        "<plate><metadata key=\"plater_id\" value=\"{number}\"/><metadata key=\"plater_name\" value=\"{name}\"/>{items}</plate>"
    )
}

fn load_plate(bytes: &[u8], number: Option<u32>) -> Result<Loaded, LoadError> {
    let context = Context { resolver: &NoResolver, limits: &Limits::default(), jobs: &Jobs::new(1) };
    load(bytes, &context, &LoadOptions::default().with_plate(number), &Shares::default())
}

/// A number of a plate far beyond the others.
const LAST: u32 = 2_000_000_000;

/// X of each instance in millimetres.
fn places(loaded: &Loaded) -> Vec<f64> {
    let instances = loaded.scene.instances().iter();
    instances
        .map(|instance| ((instance.transform.rows()[0][3] + loaded.scene.origin()[0]) * 1e6).round() / 1e3)
        .collect()
}

fn refused(bytes: &[u8], number: u32) -> String {
    match load_plate(bytes, Some(number)) {
        Err(LoadError::NoSuch(message)) => message,
        other => panic!("{other:?}"),
    }
}

/// Items keep their places; the second item of an object is told from the first.
#[test]
fn a_plate_is_drawn_alone() {
    let bytes = project(
        &[plate(1, "", &[(1, 0)]), plate(2, "lid &amp; base", &[(1, 1), (2, 0)]), plate(3, "spare", &[])]
            .concat(),
    );
    assert_eq!(places(&load_plate(&bytes, Some(1)).unwrap()), [100.0]);
    let second = load_plate(&bytes, Some(2)).unwrap();
    assert_eq!(places(&second), [400.0, 700.0]);
    let told = |plate: &crate::Plate| (plate.number, plate.name.clone(), plate.items);
    let expected = [(1, String::new(), 1), (2, "lid & base".to_owned(), 2), (3, "spare".to_owned(), 0)];
    assert_eq!(second.plates().iter().map(told).collect::<Vec<_>>(), expected);
    // All of them: side by side, and told of likewise.
    let all = load_plate(&bytes, None).unwrap();
    assert_eq!((all.plates(), places(&all).len()), (second.plates(), 3));
    // Beside the 90 mm of the first, a tenth of the second's 390 away.
    assert_eq!(places(&all), [100.0, 229.0, 529.0]);
    assert_eq!(refused(&bytes, 3), "there is nothing on plate 3 of 3");
    assert_eq!(refused(&bytes, 4), "there is no plate 4: the file has 3 plates, 1 to 3");
    assert_eq!(refused(&bytes, 0), "there is no plate 0: the file has 3 plates, 1 to 3");
}

#[test]
fn numbers_of_plates_may_be_missing_doubled_or_absurd() {
    // An item lies on the first plate that names it.
    let doubled = project(&[plate(1, "a", &[(1, 0)]), plate(1, "b", &[(1, 0), (1, 1)])].concat());
    let loaded = load_plate(&doubled, Some(1)).unwrap();
    assert_eq!(places(&loaded), [100.0, 400.0]);
    let [only] = loaded.plates() else { panic!("{:?}", loaded.plates()) };
    assert_eq!((only.name.as_str(), only.items), ("a", 2));
    assert_eq!(refused(&doubled, 2), "there is no plate 2: the file has 1 plate, 1");
    let last = project(&[plate(1, "", &[(1, 0)]), plate(LAST, "", &[(2, 0)])].concat());
    assert_eq!(places(&load_plate(&last, Some(LAST)).unwrap()), [700.0]);
    assert_eq!(refused(&last, 2), "there is no plate 2: the file has 2 plates, the last of them 2000000000");
    // Without a number, after those before.
    let unnumbered = project("<plate/><plate/>");
    assert_eq!(load_plate(&unnumbered, None).unwrap().plates().len(), 2);
    assert_eq!(refused(&unnumbered, 2), "there is nothing on plate 2 of 2");
    for without in ["", "<object id=\"1\"/>", "<plate"] {
        assert_eq!(refused(&project(without), 1), "there is no plate 1: the file has no plates");
    }
    let long = project(&plate(1, &"x".repeat(1000), &[(1, 0)]));
    assert_eq!(load_plate(&long, None).unwrap().plates()[0].name.len(), 64);
}
