//! Values that have names.

use super::Kind;
use super::vectors::vector;
use crate::camera::ViewDirection;
use crate::value::Value;
use overcoat_core::color::ToneCurve;
use overcoat_core::frame::PlaneSample;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_render::{Edges, Quality};
use overcoat_scene::{AreaLightMethod, Axis, ShadingModel};
use serde_json::{Value as Json, json};

/// Letters of a name's beginning that are enough to guess the rest.
const BEGINNING: usize = 3;

/// Suggestion of the only name that begins so, or else of the nearest.
pub(super) fn hint<'a>(text: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let begins = |name: &&str| name.get(..text.len()).is_some_and(|first| first.eq_ignore_ascii_case(text));
    let mut begun = names.clone().filter(begins);
    match (begun.next(), begun.next()) {
        (Some(name), None) if text.len() >= BEGINNING => suggestion(Some(name)),
        _ => suggestion(nearest_name(text, names)),
    }
}

/// `expected one of` the names, and the one that may have been meant.
pub fn one_of<'a>(text: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let hint = hint(text, names.clone());
    format!("expected one of {}{hint}", names.collect::<Vec<_>>().join(", "))
}

/// A type of which every value has a name.
pub(crate) trait Named: Sized + Copy + 'static {
    /// Noun for a value in messages: `the name of a shading model`.
    const EXPECTED: &'static str;
    /// Further names, which are read alike.
    const ALIASES: &'static [(&'static str, &'static str)] = &[];
    /// The value of an empty list, where a scene file may have a list of names, of which the first counts.
    const OF_EMPTY_LIST: Option<Self> = None;

    fn all() -> &'static [Self];
    fn name(self) -> &'static str;
}

impl Named for ShadingModel {
    const EXPECTED: &'static str = "the name of a shading model";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for Quality {
    const EXPECTED: &'static str = "draft, fast, good or best";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for Edges {
    const EXPECTED: &'static str = "none, creases or boundary";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for PlaneSample {
    const EXPECTED: &'static str = "center or nearest";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for AreaLightMethod {
    const EXPECTED: &'static str = "ltc or facets";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

impl Named for ToneCurve {
    const EXPECTED: &'static str = "the name of a tone curve, or a list of names";
    const ALIASES: &'static [(&'static str, &'static str)] = &[("linear", "none")];
    const OF_EMPTY_LIST: Option<Self> = Some(Self::Neutral);
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

/// The names of a type.
pub(crate) struct Names<T>(pub(crate) std::marker::PhantomData<T>);

impl<T> Names<T> {
    pub(crate) const OF: Self = Self(std::marker::PhantomData);
}

impl<T: Named> Kind for Names<T> {
    type Value = T;

    fn parse(&self, text: &str) -> Result<T, String> {
        let alias = T::ALIASES.iter().find(|(alias, _)| *alias == text);
        let name = alias.map_or(text, |(_, name)| name);
        let known = T::all().iter().copied().find(|value| value.name() == name);
        known.ok_or_else(|| one_of(text, self.names().into_iter()))
    }

    fn read(&self, value: &Value<'_>) -> Result<T, String> {
        let parse = |text: &str| self.parse(text);
        match (T::OF_EMPTY_LIST, value.node.list()) {
            (Some(none), Some(list)) => {
                let values = list.into_iter().map(|node| value.with(node).parsed(T::EXPECTED, parse));
                let values = values.collect::<Result<Vec<T>, _>>()?;
                Ok(values.first().copied().unwrap_or(none))
            }
            _ => value.parsed(T::EXPECTED, parse),
        }
    }

    fn write(&self, value: &T) -> Result<Json, String> {
        Ok(json!(value.name()))
    }

    fn schema(&self) -> Json {
        let names = self.names();
        match T::OF_EMPTY_LIST {
            Some(_) => json!({"anyOf": [{"enum": names}, {"type": "array", "items": {"enum": names}}]}),
            None => json!({"enum": names}),
        }
    }

    fn names(&self) -> Vec<&'static str> {
        let names = T::all().iter().map(|value| value.name());
        names.chain(T::ALIASES.iter().map(|(alias, _)| *alias)).collect()
    }
}

/// An axis of the model file: `+z`, `-x`, `y`.
pub(crate) fn axis(text: &str) -> Result<Axis, String> {
    Axis::from_name(text).ok_or_else(|| match vector(text) {
        Ok(_) => "expected an axis of the model, +x, -x, +y, -y, +z or -z; --camera-up (in scene files camera.up) takes \
                  a direction for the camera"
            .to_owned(),
        Err(_) => "expected +x, -x, +y, -y, +z or -z".to_owned(),
    })
}

/// An axis of the model file.
pub(crate) struct Axes;

impl Kind for Axes {
    type Value = Axis;

    fn parse(&self, text: &str) -> Result<Axis, String> {
        axis(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<Axis, String> {
        match value.node.list() {
            // The camera's direction, which has another key.
            Some(_) => {
                Err(value
                    .expected("an axis of the model such as '+z' (a direction for the camera is camera.up)"))
            }
            None => value.parsed("an axis of the model such as '+z'", axis),
        }
    }

    fn write(&self, value: &Axis) -> Result<Json, String> {
        Ok(json!(value.name()))
    }

    fn schema(&self) -> Json {
        let short = Axis::ALL.iter().copied().filter_map(|axis| axis.name().strip_prefix('+'));
        let names: Vec<&str> = self.names().into_iter().chain(short).collect();
        json!({"enum": names})
    }

    fn names(&self) -> Vec<&'static str> {
        Axis::ALL.iter().copied().map(Axis::name).collect()
    }
}

/// Views by name. glTF models face +Z; left and right are those of someone who looks at the front.
pub(crate) const VIEWS: [(&str, ViewDirection); 7] = [
    ("three-quarter", ViewDirection { direction: [0.62, 0.42, 1.0], up: [0.0, 1.0, 0.0] }),
    ("front", ViewDirection { direction: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] }),
    ("back", ViewDirection { direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0] }),
    ("left", ViewDirection { direction: [-1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] }),
    ("right", ViewDirection { direction: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] }),
    ("top", ViewDirection { direction: [0.0, 1.0, 0.0], up: [0.0, 0.0, -1.0] }),
    ("bottom", ViewDirection { direction: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0] }),
];

/// A view by name, or a direction `x,y,z` from the model towards the camera.
///
/// # Errors
/// A message that names the expected form.
pub(crate) fn view(text: &str) -> Result<ViewDirection, String> {
    if let Some((_, view)) = VIEWS.iter().find(|(name, _)| *name == text) {
        return Ok(*view);
    }
    match vector(text) {
        Ok(direction) if direction != [0.0; 3] => {
            // Looking straight down or up, the vertical axis cannot be up.
            let up =
                if direction[0] == 0.0 && direction[2] == 0.0 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
            Ok(ViewDirection { direction, up })
        }
        _ => {
            let names = Views.names();
            let hint = hint(text, names.iter().copied());
            Err(format!("expected a direction x,y,z or one of {}{hint}", names.join(", ")))
        }
    }
}

/// View direction of an automatic camera.
pub(crate) struct Views;

impl Kind for Views {
    type Value = ViewDirection;

    fn parse(&self, text: &str) -> Result<ViewDirection, String> {
        view(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<ViewDirection, String> {
        value.parsed("a view", view)
    }

    fn write(&self, value: &ViewDirection) -> Result<Json, String> {
        let name = VIEWS.iter().find(|(_, known)| known == value).map(|(name, _)| (*name).to_owned());
        let text = name.unwrap_or_else(|| value.direction.map(|v| v.to_string()).join(","));
        if view(&text).as_ref() == Ok(value) {
            Ok(json!(text))
        } else {
            Err("a view with an up direction of its own has no name".to_owned())
        }
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [{"enum": self.names()}, {"type": "string", "pattern": "^[^,]+,[^,]+,[^,]+$"}]})
    }

    fn names(&self) -> Vec<&'static str> {
        VIEWS.iter().map(|(name, _)| *name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_model_is_recognised() {
        let shading = |text| Names::<ShadingModel>::OF.parse(text);
        assert_eq!(shading("urp17"), Ok(ShadingModel::Urp17));
        let message = shading("stack-lit").unwrap_err();
        assert!(message.contains("openpbr") && message.ends_with("did you mean 'stacklit'?"), "{message}");
        assert!(!shading("phong").unwrap_err().contains("did you mean"));
    }

    #[test]
    fn axes() {
        assert_eq!((axis("+z"), axis("X")), (Ok(Axis::PositiveZ), Ok(Axis::PositiveX)));
        assert!(axis("0,0,1").unwrap_err().contains("--camera-up"));
        assert!(!axis("up").unwrap_err().contains("--camera-up"));
    }

    #[test]
    fn views_are_usable_cameras() {
        for name in VIEWS.map(|(name, _)| name).into_iter().chain(["0,1,0", "1,2,3"]) {
            let view = view(name).unwrap();
            let projection = overcoat_scene::Projection::Perspective { fov_y: 1.0 };
            let camera = overcoat_scene::Camera::new(view.direction, [0.0; 3], view.up, projection, 0.1);
            assert!(camera.axes().is_ok(), "{name}");
        }
        assert!(view("0,0,0").is_err());
        assert!(view("sideways").is_err());
    }
}
