//! Tiles of 3D Tiles 1.0 (OGC 18-053r2): models (b3dm), models at several places (i3dm), clouds of points (pnts), and several of
//! them in one file (cmpt).
//!
//! A tile is drawn alone, as its file has it, without the tileset around it: +Z is up in tiles, and +Y in the glTF models within
//! them. Tiles in coordinates of the Earth are turned so that the way up at their place is up. Batch tables, which have
//! properties and no looks, have no effect.

mod assembly;
mod earth;
mod features;
mod header;
mod instances;
mod points;
#[cfg(test)]
mod tests;

use super::gltf::{self, Purpose};
use super::mesh_formats::{check_input, finish};
use super::nearby::Nearby;
use super::text::quoted;
use super::warnings::Warnings;
use super::{Context, LoadError, LoadOptions, Loaded, TextureLoading, Warning};
use assembly::{Assembly, upright, upright_map};
use features::Features;
use header::{Kind, Tile};
use overcoat_core::limits::Limits;
use overcoat_scene::{Scene, Transform};

const FORMAT: &str = "3D Tiles";
/// Composites may nest this deep.
const DEEPEST: u64 = 16;

/// True for the beginning of a tile.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    Kind::of(bytes).is_some()
}

/// Reads a tile.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    textures: TextureLoading,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let (tile, _) = Tile::read(bytes)?;
    let mut reader = Reader { context, textures, assembly: Assembly::default(), tiles: 0 };
    let (mut scene, mut warnings) = if tile.kind == Kind::Batched {
        // A model alone keeps all that the reader of glTF makes of it.
        reader.note_cut(&tile);
        let features = Features::read(tile.features, context)?;
        let Loaded { mut scene, warnings, .. } = reader.model(tile.model(), context)?;
        let [x, y, z] = scene.origin();
        let [cx, cy, cz] = upright(center(&features)?);
        scene.set_origin([x + cx, y + cy, z + cz]);
        reader.assembly.warn(warnings);
        (scene, reader.assembly.warnings)
    } else {
        reader.tile(&tile, 0)?;
        (reader.assembly.scene, reader.assembly.warnings)
    };
    // Without a picture it says so again.
    warnings.retain(|warning| warning.message != "no triangles");
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    stand_on_ground(&mut scene)?;
    Ok(finish(scene, warnings))
}

/// Turns a scene in coordinates of the Earth.
fn stand_on_ground(scene: &mut Scene) -> Result<(), LoadError> {
    let failed = || LoadError::scene(format!("{FORMAT}: a tile"));
    let Some(turn) = earth::turn(scene.origin()) else { return Ok(()) };
    let turned = |own: &Transform| turn.after(own).map_err(failed());
    for k in 0..scene.instances().len() {
        let Some(transform) = scene.instances().get(k).map(|instance| turned(&instance.transform)) else {
            break;
        };
        scene.set_instance_transform(k, transform?).map_err(failed())?;
    }
    for k in 0..scene.splat_instances().len() {
        let own = scene.splat_instances().get(k).map(|instance| turned(&instance.transform));
        let Some(transform) = own else { break };
        scene.set_splat_transform(k, transform?).map_err(failed())?;
    }
    scene.set_origin(turn.point(scene.origin()));
    Ok(())
}

/// Centre that positions of a tile are relative to, in its axes.
fn center(features: &Features<'_>) -> Result<[f64; 3], LoadError> {
    Ok(features.numbers::<3>("RTC_CENTER")?.unwrap_or_default())
}

/// Reads tiles into one scene.
struct Reader<'a> {
    context: &'a Context<'a>,
    textures: TextureLoading,
    assembly: Assembly,
    tiles: u64,
}

impl Reader<'_> {
    fn note_cut(&mut self, tile: &Tile<'_>) {
        if tile.is_cut {
            self.assembly.warn([Warning::new(format!("{FORMAT}: the file ends within a tile"))]);
        }
    }

    fn tile(&mut self, tile: &Tile<'_>, depth: u64) -> Result<(), LoadError> {
        let limits = self.context.limits;
        Limits::check(|| format!("{FORMAT}: a composite"), depth, limits.depth.min(DEEPEST), "depth")?;
        self.tiles = self.tiles.saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the number of tiles"), self.tiles, limits.nodes, "nodes")?;
        self.note_cut(tile);
        if tile.kind == Kind::Composite {
            return self.composite(tile, depth);
        }
        let left = self.assembly.left(limits);
        let context = Context { limits: &left, ..*self.context };
        let features = Features::read(tile.features, &context)?;
        let center = center(&features)?;
        match tile.kind {
            Kind::Points => {
                let mut warnings = Warnings::default();
                let part = points::scene(&features, &context, &mut warnings)?;
                self.assembly.warn(warnings.finish());
                let place = upright_map(&Transform::IDENTITY, false)?;
                self.assembly.add(&part, &[place], upright(center), limits)
            }
            Kind::Instanced => {
                let places = instances::places(&features, center, &context)?;
                let upright_places = places.iter().map(|place| upright_map(place, true));
                let places = upright_places.collect::<Result<Vec<_>, _>>()?;
                let Some(part) = self.instanced(tile, &context)? else { return Ok(()) };
                self.assembly.add(&part, &places, upright(center), limits)
            }
            _ => {
                let Loaded { scene, warnings, .. } = self.model(tile.model(), &context)?;
                self.assembly.warn(warnings);
                self.assembly.add(&scene, &[Transform::IDENTITY], upright(center), limits)
            }
        }
    }

    /// Tiles in a tile. Those that are damaged are left out, with a warning.
    fn composite(&mut self, tile: &Tile<'_>, depth: u64) -> Result<(), LoadError> {
        let (mut rest, mut first, mut read) = (tile.body, None, 0_u32);
        for number in 1..=tile.count {
            let found = Tile::read(rest);
            // Behind what is no tile nothing is found.
            let is_last = found.is_err();
            let outcome = found.and_then(|(inner, after)| {
                rest = after;
                self.tile(&inner, depth.saturating_add(1))
            });
            match outcome {
                Ok(()) => read = read.saturating_add(1),
                Err(error) if error.is_partial() => {
                    let message = format!("{FORMAT}: tile {number} of {} left out: {error}", tile.count);
                    self.assembly.warn([Warning::new(message)]);
                    first.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
            if is_last {
                break;
            }
        }
        match first {
            Some(error) if read == 0 => Err(error),
            _ => Ok(()),
        }
    }

    /// The model of an instanced tile: within it, or in a file beside it.
    fn instanced(&mut self, tile: &Tile<'_>, context: &Context<'_>) -> Result<Option<Scene>, LoadError> {
        let found;
        let mut bytes = tile.model();
        if !tile.is_embedded {
            let name = String::from_utf8_lossy(tile.body);
            let name = name.trim_matches(['\0', ' ']);
            let limit = context.limits.input_bytes;
            found = match Nearby::default().read(context, "", [name], limit) {
                Ok(found) => found.bytes,
                Err(error) => {
                    let name = quoted(name.as_bytes());
                    let message = format!("{FORMAT}: model {name} is left out: {error}");
                    self.assembly.warn([Warning::new(message)]);
                    return Ok(None);
                }
            };
            bytes = &found;
        }
        let Loaded { scene, warnings, .. } = self.model(bytes, context)?;
        self.assembly.warn(warnings);
        Ok(Some(scene))
    }

    /// A model of glTF in its own pose.
    fn model(&self, bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
        let options = LoadOptions::default().with_textures(self.textures);
        gltf::read(bytes, &options, Purpose::Pictures, context)?.at(0.0, false, context.jobs)
    }
}
