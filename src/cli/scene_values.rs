//! The values of a scene file's keys: written as those of options are, with the key in front of what is wrong.

use super::materials::MaterialSource;
use super::scene_file::EnvironmentChoice;
use super::values::{self, BackgroundChoice, ViewDirection};
use crate::color::ToneCurve;
use crate::render::{AreaLightMethod, ShadingModel};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use std::collections::BTreeMap;

pub(super) fn environment<'de, D: Deserializer<'de>>(d: D) -> Result<Option<EnvironmentChoice>, D::Error> {
    Ok(Some(EnvironmentChoice::new(&String::deserialize(d)?)))
}

pub(super) fn background<'de, D: Deserializer<'de>>(d: D) -> Result<Option<BackgroundChoice>, D::Error> {
    let text = String::deserialize(d)?;
    values::background(&text).map(Some).map_err(|e| D::Error::custom(format!("background '{text}': {e}")))
}

pub(super) fn samples<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u32>, D::Error> {
    let number = u32::deserialize(d)?;
    values::samples(&number.to_string()).map(Some).map_err(|e| D::Error::custom(format!("samples: {e}")))
}

pub(super) fn shading<'de, D: Deserializer<'de>>(d: D) -> Result<Option<ShadingModel>, D::Error> {
    let text = String::deserialize(d)?;
    values::shading(&text).map(Some).map_err(|e| D::Error::custom(format!("shading '{text}': {e}")))
}

pub(super) fn area_lights<'de, D: Deserializer<'de>>(d: D) -> Result<Option<AreaLightMethod>, D::Error> {
    let text = String::deserialize(d)?;
    values::area_lights(&text).map(Some).map_err(|e| D::Error::custom(format!("areaLights '{text}': {e}")))
}

pub(super) fn material<'de, D: Deserializer<'de>>(d: D) -> Result<Option<MaterialSource>, D::Error> {
    let text = String::deserialize(d)?;
    MaterialSource::new(&text).map(Some).map_err(|e| D::Error::custom(format!("material '{text}': {e}")))
}

pub(super) fn materials<'de, D: Deserializer<'de>>(
    d: D,
) -> Result<BTreeMap<String, MaterialSource>, D::Error> {
    let texts = BTreeMap::<String, String>::deserialize(d)?;
    let source = |(name, text): (String, String)| {
        let source = MaterialSource::new(&text);
        source.map(|s| (name, s)).map_err(|e| D::Error::custom(format!("materials '{text}': {e}")))
    };
    texts.into_iter().map(source).collect()
}

pub(super) fn view<'de, D: Deserializer<'de>>(d: D) -> Result<Option<ViewDirection>, D::Error> {
    let text = String::deserialize(d)?;
    values::view(&text).map(Some).map_err(|e| D::Error::custom(format!("view '{text}': {e}")))
}

pub(super) fn tone_mapping<'de, D: Deserializer<'de>>(d: D) -> Result<Option<ToneCurve>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Names {
        One(String),
        Many(Vec<String>),
    }
    let names = match Names::deserialize(d) {
        Ok(Names::One(name)) => vec![name],
        Ok(Names::Many(names)) => names,
        Err(_) => return Err(D::Error::custom("toneMapping: expected a name or a list of names")),
    };
    let curve = |name: &String| {
        values::tone_curve(name).map_err(|e| D::Error::custom(format!("toneMapping '{name}': {e}")))
    };
    let curves = names.iter().map(curve).collect::<Result<Vec<_>, _>>()?;
    Ok(curves.first().copied())
}

pub(super) fn name_or_number<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Either {
        Number(u32),
        Name(String),
    }
    match Either::deserialize(d) {
        Ok(Either::Number(number)) => Ok(Some(number.to_string())),
        Ok(Either::Name(name)) => Ok(Some(name)),
        Err(_) => Err(D::Error::custom("expected a name or a number")),
    }
}
