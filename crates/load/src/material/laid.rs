//! The settings of a material file as a material of a scene, whoever makes its textures.

use super::error::MaterialError;
use super::keys::{Key, Kind};
use super::parse::{Setting, Value, parse};
use super::texture::TextureUse;
use overcoat_scene::parameters::{Holds, Kind as Of, METALLIC_ROUGHNESS_TEXTURE, Parameter, Slot};
use overcoat_scene::{AlphaUse, ColorSpace, Material, TextureRef};

/// A texture and the channel that is read of it.
pub(crate) type Part<'t> = Option<(&'t TextureUse, u8)>;

/// Makes textures of a scene. Those that cannot be had are `None`.
pub(crate) trait TextureMaker {
    /// The reason for which a scene cannot have a texture at all.
    type Error;

    /// A file's picture as it is.
    fn whole(
        &mut self,
        texture: &TextureUse,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Result<Option<TextureRef>, Self::Error>;

    /// One channel of a file's picture in all channels.
    fn one_channel(&mut self, texture: &TextureUse, channel: u8) -> Result<Option<TextureRef>, Self::Error>;

    /// Metallic and roughness, which lie alike, as the one picture that the renderer reads.
    fn packed(&mut self, metallic: Part<'_>, roughness: Part<'_>) -> Result<Option<TextureRef>, Self::Error>;
}

/// A material by its settings, for readers of formats that hold graphs of MaterialX.
#[derive(Debug)]
pub(crate) struct Recipe {
    settings: Vec<Setting>,
}

impl Recipe {
    /// Parses the text of a material file.
    ///
    /// # Errors
    /// [`MaterialError`] of the first line that is wrong.
    pub(crate) fn parse(text: &str) -> Result<Self, MaterialError> {
        Ok(Self { settings: parse(text)? })
    }

    /// Changes a material by the settings.
    ///
    /// # Errors
    /// The first of the maker.
    pub(crate) fn lay<M: TextureMaker>(
        &self,
        material: &mut Material,
        maker: &mut M,
    ) -> Result<(), M::Error> {
        lay(&self.settings, material, maker)
    }
}

/// Changes a material by settings, in their order.
///
/// # Errors
/// The first of the maker.
pub(super) fn lay<M: TextureMaker>(
    settings: &[Setting],
    material: &mut Material,
    maker: &mut M,
) -> Result<(), M::Error> {
    let mut layer = Layer { settings, maker };
    settings.iter().try_for_each(|setting| layer.set(setting, material))
}

struct Layer<'s, 'm, M> {
    settings: &'s [Setting],
    maker: &'m mut M,
}

impl<'s, M: TextureMaker> Layer<'s, '_, M> {
    /// Value of a key; `None` if it is not set.
    fn value(&self, name: &str) -> Option<&'s Value> {
        self.settings.iter().find(|setting| setting.key.name == name).map(|setting| &setting.value)
    }

    fn set(&mut self, setting: &Setting, material: &mut Material) -> Result<(), M::Error> {
        match (&setting.key.kind, &setting.value) {
            (Kind::Value(Of::Number(_, access)), Value::Number(value)) => (access.set)(material, *value),
            (Kind::Value(Of::Pair(_, access)), Value::Pair(value)) => (access.set)(material, *value),
            (Kind::Value(Of::Triple(_, access) | Of::Color(_, access)), Value::Triple(value)) => {
                (access.set)(material, *value);
            }
            (Kind::Value(Of::ColorAndAlpha(_, access)), Value::ColorAndAlpha([r, g, b], alpha)) => {
                let [.., own] = (access.get)(material);
                (access.set)(material, [*r, *g, *b, alpha.unwrap_or(own)]);
            }
            (Kind::Value(Of::Switch(access)), Value::Switch(value)) => (access.set)(material, *value),
            (Kind::Value(Of::Name { set, .. }), Value::Text(name)) => set(material, name),
            (Kind::Value(Of::Texture(slot)), Value::Texture(texture)) => {
                self.lift(slot.factor.filter(|_| texture.is_some()), material);
                self.texture(slot, texture.as_deref(), material)?;
            }
            (Kind::Part(_, factor), Value::Texture(texture)) => {
                self.lift(Some(*factor).filter(|_| texture.is_some()), material);
                let reference = if texture.is_some() { self.packed()? } else { None };
                if let Of::Texture(slot) = METALLIC_ROUGHNESS_TEXTURE.kind {
                    slot.set(material, reference);
                }
            }
            // The rest is about the file and not about the material.
            _ => {}
        }
        Ok(())
    }

    /// A texture multiplies; where the file gives no number and there is 0, it would show nothing.
    fn lift(&self, factor: Option<&Parameter>, material: &mut Material) {
        let Some(factor) = factor.filter(|factor| self.value(factor.name).is_none()) else { return };
        let is_black = factor.numbers(material) == [0.0; 4];
        if is_black && matches!(factor.kind, Of::Number(..) | Of::Color(..)) {
            factor.set_numbers(material, [1.0; 4]);
        }
    }

    /// Fills or empties a slot.
    fn texture(
        &mut self,
        slot: &Slot,
        texture: Option<&TextureUse>,
        material: &mut Material,
    ) -> Result<(), M::Error> {
        let Some(texture) = texture else {
            slot.set(material, None);
            return Ok(());
        };
        let alpha = slot.alpha_use(material);
        let reference = match (slot.holds, texture.channel) {
            (Holds::Channel(usual), channel) if slot.names_channel() => {
                slot.set_channel(material, channel.unwrap_or(usual));
                self.maker.whole(texture, slot.color_space(), alpha)?
            }
            (Holds::Channel(read), channel) => {
                // A picture of one number has it in red; only glTF's have it in alpha.
                let channel = channel.unwrap_or(if read == 3 { 0 } else { read });
                if channel == read {
                    self.maker.whole(texture, slot.color_space(), alpha)?
                } else {
                    self.maker.one_channel(texture, channel)?
                }
            }
            _ => self.maker.whole(texture, slot.color_space(), alpha)?,
        };
        slot.set(material, reference);
        Ok(())
    }

    /// `metallic_texture` and `roughness_texture` as the one that the renderer reads.
    fn packed(&mut self) -> Result<Option<TextureRef>, M::Error> {
        let given = |name: &str| match (Key::named(name).map(|key| &key.kind), self.value(name)) {
            (Some(Kind::Part(usual, _)), Some(Value::Texture(Some(texture)))) => {
                Some((&**texture, texture.channel.unwrap_or(*usual)))
            }
            _ => None,
        };
        let (metallic, roughness) = (given("metallic_texture"), given("roughness_texture"));
        self.maker.packed(metallic, roughness)
    }
}
