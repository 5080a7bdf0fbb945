//! The values of a scene file's keys: each is what it should be, or a line that says where it stands and what was expected.

use super::camera::ViewDirection;
use super::environment::EnvironmentChoice;
use super::materials::MaterialSource;
use super::options::{BackgroundChoice, ExposureChoice};
use super::spelling;
use super::tree::{Node, short};
use overcoat_core::color::{ToneCurve, hex_color, srgb::srgb8_to_linear};
use overcoat_load::Warning;
use overcoat_render::{Ground, Quality};
use overcoat_scene::Axis;
use overcoat_scene::{AreaLightMethod, ShadingModel};
use std::cell::RefCell;
use std::fmt::Display;
use std::path::PathBuf;

/// A value with the key that it was given to.
pub(super) struct Value<'a> {
    /// With those of the tables around it: `camera.eye`. Empty for the file itself.
    key: String,
    pub(super) node: Node<'a>,
    pub(super) warnings: &'a RefCell<Vec<Warning>>,
}

impl<'a> Value<'a> {
    /// The whole file.
    pub(super) fn file(node: Node<'a>, warnings: &'a RefCell<Vec<Warning>>) -> Self {
        Self { key: String::new(), node, warnings }
    }

    /// The value of a key of this table.
    pub(super) fn within(&self, key: &str, node: Node<'a>) -> Self {
        let key = match self.key.as_str() {
            "" => short(key),
            outer => format!("{outer}.{}", short(key)),
        };
        Self { key, node, warnings: self.warnings }
    }

    /// A message about it.
    pub(super) fn message(&self, what: impl Display) -> String {
        match self.key.as_str() {
            "" => format!("line {}: {what}", self.node.line()),
            key => format!("line {}: {key}: {what}", self.node.line()),
        }
    }

    /// The message of a value that is not what it should be.
    pub(super) fn expected(&self, what: impl Display) -> String {
        self.message(format_args!("expected {what}, found {}", self.node.found()))
    }

    /// Calls `f` for each value of a list.
    pub(super) fn each(
        &self,
        expected: &str,
        mut f: impl FnMut(&Value<'a>) -> Result<(), String>,
    ) -> Result<(), String> {
        let list = self.node.list().ok_or_else(|| self.expected(expected))?;
        for (k, node) in list.into_iter().enumerate() {
            f(&Value { key: format!("{} {k}", self.key), node, warnings: self.warnings })?;
        }
        Ok(())
    }

    pub(super) fn text(&self, expected: &str) -> Result<String, String> {
        self.node.text().map(|text| text.into_owned()).ok_or_else(|| self.expected(expected))
    }

    pub(super) fn path(&self, expected: &str) -> Result<PathBuf, String> {
        self.text(expected).map(PathBuf::from)
    }

    pub(super) fn switch(&self) -> Result<bool, String> {
        self.node.switch().ok_or_else(|| self.expected("true or false"))
    }

    /// Text that is written as the value of an option is.
    fn parsed<T>(&self, expected: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<T, String> {
        let text = self.text(expected)?;
        parse(&text).map_err(|reason| self.message(format_args!("'{}': {reason}", short(&text))))
    }

    /// A number between two others, which are allowed as well.
    pub(super) fn number(&self, unit: &str, low: f32, high: f32) -> Result<f32, String> {
        let number = self.node.number().map(|v| v as f32).filter(|v| (low..=high).contains(v));
        number.ok_or_else(|| {
            self.expected(match (low, high) {
                (f32::MIN, _) => format!("a number ({unit})"),
                (_, f32::MAX) => format!("a number from {low} ({unit})"),
                _ => format!("a number from {low} to {high} ({unit})"),
            })
        })
    }

    /// Seconds.
    pub(super) fn seconds(&self) -> Result<f64, String> {
        let number = self.node.number().filter(|v| *v >= 0.0);
        number.ok_or_else(|| self.expected("a number of seconds, at least 0"))
    }

    /// A whole number between two others, which are allowed as well.
    pub(super) fn whole(&self, low: u32, high: u32) -> Result<u32, String> {
        let number = self.node.whole().and_then(|v| u32::try_from(v).ok());
        number
            .filter(|v| (low..=high).contains(v))
            .ok_or_else(|| self.expected(format_args!("a whole number from {low} to {high}")))
    }

    /// As many numbers as are wanted.
    fn numbers<const N: usize>(&self, names: &str) -> Result<[f32; N], String> {
        self.doubles(names).map(|numbers| numbers.map(|v| v as f32))
    }

    /// The same in double precision, within the range of single precision.
    fn doubles<const N: usize>(&self, names: &str) -> Result<[f64; N], String> {
        let wrong = || self.expected(format_args!("a list of {N} numbers, {names}"));
        let list = self.node.list().ok_or_else(wrong)?;
        let numbers: Vec<f64> = list
            .iter()
            .map(|node| node.number().filter(|v| (*v as f32).is_finite()))
            .collect::<Option<_>>()
            .ok_or_else(wrong)?;
        <[f64; N]>::try_from(numbers).map_err(|_| wrong())
    }

    /// A direction or a place of single precision.
    pub(super) fn vector(&self) -> Result<[f32; 3], String> {
        self.numbers("x, y and z")
    }

    /// A place of double precision, for models far from zero.
    pub(super) fn position(&self) -> Result<[f64; 3], String> {
        self.doubles("x, y and z")
    }

    /// Width and height of something.
    pub(super) fn extent(&self) -> Result<[f32; 2], String> {
        self.numbers("width and height")
    }

    /// Three numbers of linear light, or an sRGB colour.
    pub(super) fn color(&self) -> Result<[f32; 3], String> {
        match self.node.text() {
            None => self.numbers("red, green and blue"),
            Some(text) => match hex_color(&text) {
                Some((color, None)) => Ok(color.map(srgb8_to_linear)),
                _ => Err(self.expected("a list of 3 numbers or a colour #rrggbb")),
            },
        }
    }

    /// An axis of the model file.
    pub(super) fn axis(&self) -> Result<Axis, String> {
        match self.node.list() {
            // The camera's direction, which has another key.
            Some(_) => {
                Err(self
                    .expected("an axis of the model such as '+z' (a direction for the camera is camera.up)"))
            }
            None => self.parsed("an axis of the model such as '+z'", spelling::axis),
        }
    }

    /// Where the light from afar comes from.
    pub(super) fn environment(&self) -> Result<EnvironmentChoice, String> {
        self.text("studio, none or the path of a picture").map(|text| EnvironmentChoice::new(&text))
    }

    /// What is behind the model.
    pub(super) fn background(&self) -> Result<BackgroundChoice, String> {
        self.parsed("a colour, transparent or env", spelling::background)
    }

    /// What is seen of a floor.
    pub(super) fn ground(&self) -> Result<Ground, String> {
        self.parsed("none, shadow or a colour", spelling::ground)
    }

    /// A shading model.
    pub(super) fn shading(&self) -> Result<ShadingModel, String> {
        self.parsed("the name of a shading model", spelling::shading)
    }

    /// How area lights are integrated.
    pub(super) fn area_lights(&self) -> Result<AreaLightMethod, String> {
        self.parsed("ltc or facets", spelling::area_lights)
    }

    /// What a picture is worth.
    pub(super) fn quality(&self) -> Result<Quality, String> {
        self.parsed("draft, fast, good or best", spelling::quality)
    }

    /// Where an automatic camera stands.
    pub(super) fn view(&self) -> Result<ViewDirection, String> {
        self.parsed("a view", spelling::view)
    }

    /// A material file or a built-in material.
    pub(super) fn material(&self) -> Result<MaterialSource, String> {
        self.parsed("a material", MaterialSource::new)
    }

    /// Stops, or `auto`.
    pub(super) fn exposure(&self) -> Result<ExposureChoice, String> {
        match self.node.text() {
            Some(text) if text == "auto" => Ok(ExposureChoice::Auto),
            Some(_) => Err(self.expected("a number of stops or 'auto'")),
            None => self.number("stops", -64.0, 64.0).map(ExposureChoice::Stops),
        }
    }

    /// Width and height; one number makes a square.
    pub(super) fn size(&self) -> Result<[u64; 2], String> {
        if let Some(side) = self.node.whole() {
            return Ok([side; 2]);
        }
        let sides = self.node.list().and_then(|list| match &list[..] {
            [width, height] => Some([width.whole()?, height.whole()?]),
            _ => None,
        });
        sides.ok_or_else(|| self.expected("two whole numbers, width and height in pixels"))
    }

    /// Samples a pixel.
    pub(super) fn samples(&self) -> Result<u32, String> {
        let number = self.node.whole().and_then(|number| spelling::samples(&number.to_string()).ok());
        number.ok_or_else(|| self.expected("1, 4, 8 or 16"))
    }

    /// Shadings a pixel.
    pub(super) fn shading_rate(&self) -> Result<u32, String> {
        let number = self.node.whole().and_then(|number| spelling::shading_rate(&number.to_string()).ok());
        number.ok_or_else(|| self.expected("1, 4, 8, 9 or 16"))
    }

    /// One name, or a list of names of which the first counts.
    pub(super) fn tone_curve(&self) -> Result<ToneCurve, String> {
        let expected = "the name of a tone curve, or a list of names";
        let Some(list) = self.node.list() else { return self.parsed(expected, spelling::tone_curve) };
        let of = |node| Value { key: self.key.clone(), node, warnings: self.warnings };
        let curves = list
            .into_iter()
            .map(|node| of(node).parsed(expected, spelling::tone_curve))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(curves.first().copied().unwrap_or_default())
    }

    /// The name of something in the model, or its number from 0.
    pub(super) fn name_or_number(&self, what: &str) -> Result<String, String> {
        let number = self.node.whole().and_then(|v| u32::try_from(v).ok()).map(|v| v.to_string());
        let name = || self.node.text().map(|text| text.into_owned());
        number
            .or_else(name)
            .ok_or_else(|| self.expected(format_args!("the name of {what} or its number from 0")))
    }
}
