//! Parameters of materials: one table with the name, range, place and readers of each.
//!
//! From it follow the checks of a scene ([`super::Scene::add_material`]), the clamping of loaders, the keys of
//! material files with their documentation, the textures of a material, the targets of glTF's animations, and the
//! ranges of the planes of the G-buffer. The name of a parameter in a format of files stays with its loader.
//!
//! A default is not written down again: it is the value in [`Material::default`].

mod table;

pub use table::*;

use super::SceneError;
use super::error::within;
use super::lobes::ScalarParameter;
use super::material::{AlphaMode, Material, NormalTexture, TextureRef};
use super::model::{Feature, ShadingModel};
use super::texture::{AlphaUse, ColorSpace};

/// Largest factor of an emissive or specular colour, largest length.
pub const MAX_FACTOR: f32 = 1e6;

/// Numbers that a parameter takes, ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value.
    pub low: f32,
    /// Greatest value.
    pub high: f32,
    /// One outside of these that has a meaning of its own.
    pub or: Option<f32>,
}

impl Range {
    /// Weights, masks, colours.
    pub const UNIT: Self = Self::new(0.0, 1.0);
    /// Anisotropy.
    pub(crate) const SIGNED: Self = Self::new(-1.0, 1.0);
    /// Range of factors without a natural bound: 0 to [`MAX_FACTOR`].
    pub const FACTOR: Self = Self::new(0.0, MAX_FACTOR);

    /// All values from `low` to `high`.
    pub const fn new(low: f32, high: f32) -> Self {
        Self { low, high, or: None }
    }

    /// The nearest number that is taken.
    pub fn clamp(self, value: f64) -> f32 {
        match self.or {
            Some(or) if value == f64::from(or) => or,
            // Both ends are exact in single precision.
            _ => value.clamp(f64::from(self.low), f64::from(self.high)) as f32,
        }
    }

    fn check(self, label: &'static str, values: &[f32]) -> Result<(), SceneError> {
        if let Some(or) = self.or
            && values.iter().all(|v| *v == or)
        {
            return Ok(());
        }
        within(label, values, self.low, self.high)
    }
}

/// Getter and setter of a value of a material.
#[derive(Clone, Copy, Debug)]
pub struct Access<T> {
    /// Reads the value.
    pub get: fn(&Material) -> T,
    /// Writes the value.
    pub set: fn(&mut Material, T),
}

/// Kind of a parameter, with its range and access.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number(Range, Access<f32>),
    /// Two numbers: the value where a texture is 0, and where it is 1.
    Pair(Range, Access<[f32; 2]>),
    /// A number each for red, green and blue.
    Triple(Range, Access<[f32; 3]>),
    /// A linear colour.
    Color(Range, Access<[f32; 3]>),
    /// A linear colour and opacity.
    ColorAndAlpha(Range, Access<[f32; 4]>),
    /// `true` or `false`.
    Switch(Access<bool>),
    /// One of a few names; none reads as "".
    Name {
        /// All names.
        names: fn() -> Vec<&'static str>,
        /// Name of the value.
        get: fn(&Material) -> &'static str,
        /// Sets the value of a name.
        set: fn(&mut Material, &str),
    },
    /// A texture.
    Texture(Slot),
}

/// A slot for a texture.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Kind of its texels.
    pub holds: Holds,
    /// Parameter that the texture multiplies, if any.
    pub factor: Option<&'static Parameter>,
    place: Place,
}

/// Meaning of a texture's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// An sRGB colour; alpha has a meaning of its own, if any.
    Color,
    /// An sRGB colour and opacity.
    ColorAndAlpha,
    /// Linear data, each channel with a meaning of its own.
    Data,
    /// Linear data in one channel: 0 red to 3 alpha.
    Channel(u8),
    /// Normals in tangent space.
    Normals,
}

#[derive(Clone, Copy, Debug)]
enum Place {
    Texture(fn(&Material) -> &Option<TextureRef>, fn(&mut Material) -> &mut Option<TextureRef>),
    /// The material chooses the channel that is read; that of [`Holds::Channel`] is the usual one.
    Scalar(fn(&Material) -> &ScalarParameter, fn(&mut Material) -> &mut ScalarParameter),
    Normal(fn(&Material) -> &Option<NormalTexture>, fn(&mut Material) -> &mut Option<NormalTexture>),
}

/// Models that read a parameter.
#[derive(Clone, Copy, Debug)]
pub enum ReadBy {
    /// All models, or a stage before any model.
    All,
    /// Models that support the feature.
    Knowing(Feature),
    /// The listed models.
    Models(&'static [ShadingModel]),
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Also its key in material files.
    pub name: &'static str,
    /// Name in messages.
    pub(crate) label: &'static str,
    /// Type, range and access.
    pub kind: Kind,
    /// Unit of numbers, empty without one.
    pub unit: &'static str,
    /// Models that read it.
    pub read_by: ReadBy,
    /// A sentence about it.
    pub about: &'static str,
    held: fn(&Material) -> bool,
}

impl Parameter {
    const fn new(name: &'static str, label: &'static str, kind: Kind, about: &'static str) -> Self {
        Self { name, label, kind, unit: "", read_by: ReadBy::All, about, held: |_| true }
    }

    /// In that unit.
    const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Read by the models that know this of a material.
    const fn knowing(self, feature: Feature) -> Self {
        Self { read_by: ReadBy::Knowing(feature), ..self }
    }

    /// Read by these models.
    const fn of(self, models: &'static [ShadingModel]) -> Self {
        Self { read_by: ReadBy::Models(models), ..self }
    }

    /// Only where that is true of a material.
    const fn only(self, held: fn(&Material) -> bool) -> Self {
        Self { held, ..self }
    }

    /// False where a material has something else in its place: the specular workflow has no metallic.
    pub fn is_in(&self, material: &Material) -> bool {
        (self.held)(material)
    }

    /// The models that read it.
    pub fn models(&self) -> Vec<ShadingModel> {
        let reads = |model: &ShadingModel| match self.read_by {
            ReadBy::All => true,
            ReadBy::Knowing(feature) => model.knows(feature),
            ReadBy::Models(models) => models.contains(model),
        };
        ShadingModel::ALL.iter().copied().filter(reads).collect()
    }

    /// The numbers that it takes; nothing where it is none.
    pub const fn range(&self) -> Range {
        match self.kind {
            Kind::Number(range, _)
            | Kind::Pair(range, _)
            | Kind::Triple(range, _)
            | Kind::Color(range, _)
            | Kind::ColorAndAlpha(range, _) => range,
            Kind::Switch(_) | Kind::Name { .. } | Kind::Texture(_) => Range::new(0.0, 0.0),
        }
    }

    /// Number of components: 0 for switches, names and textures.
    pub const fn width(&self) -> usize {
        match self.kind {
            Kind::Number(..) => 1,
            Kind::Pair(..) => 2,
            Kind::Triple(..) | Kind::Color(..) => 3,
            Kind::ColorAndAlpha(..) => 4,
            Kind::Switch(_) | Kind::Name { .. } | Kind::Texture(_) => 0,
        }
    }

    /// Its numbers, with zeros behind them.
    pub fn numbers(&self, material: &Material) -> [f32; 4] {
        match self.kind {
            Kind::Number(_, access) => [(access.get)(material), 0.0, 0.0, 0.0],
            Kind::Pair(_, access) => {
                let [a, b] = (access.get)(material);
                [a, b, 0.0, 0.0]
            }
            Kind::Triple(_, access) | Kind::Color(_, access) => {
                let [r, g, b] = (access.get)(material);
                [r, g, b, 0.0]
            }
            Kind::ColorAndAlpha(_, access) => (access.get)(material),
            Kind::Switch(_) | Kind::Name { .. } | Kind::Texture(_) => [0.0; 4],
        }
    }

    /// Sets the first of these numbers, as many as it is.
    pub fn set_numbers(&self, material: &mut Material, [a, b, c, d]: [f32; 4]) {
        match self.kind {
            Kind::Number(_, access) => (access.set)(material, a),
            Kind::Pair(_, access) => (access.set)(material, [a, b]),
            Kind::Triple(_, access) | Kind::Color(_, access) => (access.set)(material, [a, b, c]),
            Kind::ColorAndAlpha(_, access) => (access.set)(material, [a, b, c, d]),
            Kind::Switch(_) | Kind::Name { .. } | Kind::Texture(_) => {}
        }
    }
}

impl Slot {
    /// Colour space of its texels.
    pub fn color_space(&self) -> ColorSpace {
        match self.holds {
            Holds::Color | Holds::ColorAndAlpha => ColorSpace::Srgb,
            Holds::Data | Holds::Channel(_) | Holds::Normals => ColorSpace::Linear,
        }
    }

    /// Meaning of the alpha channel of a texture in this slot.
    pub fn alpha_use(&self, material: &Material) -> AlphaUse {
        match (self.holds, material.alpha_mode) {
            (Holds::Normals, _) => AlphaUse::Normals,
            (Holds::Color | Holds::Data | Holds::Channel(_), _) => AlphaUse::Data,
            (Holds::ColorAndAlpha, AlphaMode::Opaque) => AlphaUse::Data,
            // The cutoff is compared with the product of texture and factor.
            (Holds::ColorAndAlpha, AlphaMode::Mask { cutoff }) if material.base_color[3] > 0.0 => {
                AlphaUse::mask(cutoff / material.base_color[3])
            }
            (Holds::ColorAndAlpha, AlphaMode::Mask { .. } | AlphaMode::Blend) => AlphaUse::Coverage,
        }
    }

    /// True if the material chooses the channel that is read.
    pub fn names_channel(&self) -> bool {
        matches!(self.place, Place::Scalar(..))
    }

    /// The texture that is there.
    pub fn get(self, material: &Material) -> Option<&TextureRef> {
        match self.place {
            Place::Texture(get, _) => get(material).as_ref(),
            Place::Scalar(get, _) => get(material).texture.as_ref(),
            Place::Normal(get, _) => get(material).as_ref().map(|normal| &normal.texture),
        }
    }

    /// The same, to be changed.
    pub fn get_mut(self, material: &mut Material) -> Option<&mut TextureRef> {
        // The other way to a place of the other workflow would change the workflow.
        self.get(material)?;
        match self.place {
            Place::Texture(_, get) => get(material).as_mut(),
            Place::Scalar(_, get) => get(material).texture.as_mut(),
            Place::Normal(_, get) => get(material).as_mut().map(|normal| &mut normal.texture),
        }
    }

    /// Fills or empties it. A map of normals keeps its scale; a material of the other workflow is turned to that of the slot.
    pub fn set(self, material: &mut Material, texture: Option<TextureRef>) {
        match self.place {
            Place::Texture(_, get) => *get(material) = texture,
            Place::Scalar(_, get) => get(material).texture = texture,
            Place::Normal(_, get) => {
                let place = get(material);
                let scale = place.map_or(1.0, |normal| normal.scale);
                *place = texture.map(|texture| NormalTexture { texture, scale });
            }
        }
    }

    /// Sets the channel that is read, where the material chooses it.
    pub fn set_channel(self, material: &mut Material, channel: u8) {
        if let Place::Scalar(_, get) = self.place {
            get(material).channel = channel;
        }
    }

    /// Checks channel, scale and the like beside the texture.
    fn check(self, material: &Material) -> Result<(), SceneError> {
        match self.place {
            Place::Texture(..) => {}
            Place::Scalar(get, _) if get(material).channel > 3 => {
                return Err(SceneError::OutOfRange { what: "texture channel", limit: 3.0 });
            }
            Place::Scalar(..) => {}
            Place::Normal(get, _) => {
                if let Some(normal) = get(material) {
                    NORMAL_SCALE.range().check(NORMAL_SCALE.label, &[normal.scale])?;
                }
            }
        }
        Ok(())
    }
}

/// Every slot for a texture, in the order of the table.
pub fn slots() -> impl Iterator<Item = (&'static Parameter, &'static Slot)> {
    PARAMETERS.iter().filter_map(|parameter| match &parameter.kind {
        Kind::Texture(slot) => Some((parameter, slot)),
        _ => None,
    })
}

/// Checks every number of a material against its range, and that textures exist, of which there are so many.
pub(super) fn check(material: &Material, textures: usize) -> Result<(), SceneError> {
    for parameter in PARAMETERS.iter().filter(|parameter| parameter.is_in(material)) {
        if let Kind::Texture(slot) = parameter.kind {
            slot.check(material)?;
            if let Some(texture) = slot.get(material) {
                texture.check(textures)?;
            }
        } else {
            let numbers = parameter.numbers(material);
            parameter.range().check(parameter.label, &numbers[..parameter.width()])?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TextureId, UvTransform, Workflow};

    fn workflows() -> [Material; 2] {
        let glossy = Workflow::SpecularGlossiness { specular: [0.5; 3], glossiness: 0.5, texture: None };
        [Material::default(), Material { workflow: glossy, ..Material::default() }]
    }

    #[test]
    fn names_are_unique_and_defaults_in_range() {
        let mut names: Vec<&str> = PARAMETERS.iter().map(|p| p.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), PARAMETERS.len());
        for material in workflows() {
            assert_eq!(check(&material, 0), Ok(()));
        }
        for parameter in PARAMETERS {
            assert!(parameter.about.ends_with('.'), "{}", parameter.name);
            assert!(!parameter.models().is_empty(), "{}", parameter.name);
        }
    }

    /// Each parameter reads back the value that was set, and nothing else of the table changes but parameters that
    /// share its place.
    #[test]
    fn numbers_have_a_place_of_their_own() {
        for own in workflows() {
            for parameter in PARAMETERS.iter().filter(|p| p.width() > 0 && p.is_in(&own)) {
                let Range { low, high, .. } = parameter.range();
                // Exact in degrees, in products and less 1.
                let value = if low > 0.5 { low + 0.25 } else { high.clamp(-0.5, 0.25) };
                let mut material = own.clone();
                parameter.set_numbers(&mut material, [value; 4]);
                assert_eq!(
                    parameter.numbers(&material)[..parameter.width()],
                    [value; 4][..parameter.width()]
                );
                assert_eq!(check(&material, 0), Ok(()), "{}", parameter.name);
                let others = PARAMETERS.iter().filter(|p| p.width() > 0 && p.name != parameter.name);
                let changed: Vec<&str> = others
                    .filter(|p| p.is_in(&own) && p.numbers(&material) != p.numbers(&own))
                    .map(|p| p.name)
                    .collect();
                assert!(changed.is_empty(), "{} changes {changed:?}", parameter.name);
            }
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused_by_their_label() {
        for own in workflows() {
            for parameter in PARAMETERS.iter().filter(|p| p.width() > 0 && p.is_in(&own)) {
                let Range { low, high, .. } = parameter.range();
                for wrong in [low - 1.0 - low.abs(), high * 2.0 + 1.0, f32::NAN, f32::NEG_INFINITY] {
                    // Twice an infinite end is still in range.
                    if wrong == f32::INFINITY {
                        continue;
                    }
                    let mut material = own.clone();
                    parameter.set_numbers(&mut material, [wrong; 4]);
                    let error = check(&material, 0).unwrap_err().to_string();
                    assert!(error.starts_with(parameter.label), "{}: {error}", parameter.name);
                }
            }
        }
    }

    #[test]
    fn slots_are_filled_emptied_and_checked() {
        let texture = TextureRef { texture: TextureId(0), uv_set: 1, transform: UvTransform::IDENTITY };
        for own in workflows() {
            for (parameter, slot) in slots().filter(|(p, _)| p.is_in(&own)) {
                let mut material = own.clone();
                assert_eq!(slot.get_mut(&mut material), None);
                slot.set(&mut material, Some(texture));
                assert_eq!(material.textures().collect::<Vec<_>>(), [&texture], "{}", parameter.name);
                assert_eq!(material.uv_sets(), [false, true]);
                assert!(check(&material, 0).is_err() && check(&material, 1).is_ok());
                slot.set(&mut material, None);
                assert_eq!(material, own);
                slot.set_channel(&mut material, 4);
                assert_eq!(check(&material, 0).is_err(), slot.names_channel());
            }
        }
    }
}
