//! Meshes whose textures are in tiles (UDIM): a part for each tile, with the pictures of that.

use super::super::compose::Composed;
use super::{Builder, Inherited, MeshKey};
use crate::LoadError;
use crate::udim;
use overcoat_scene::{MeshData, MeshId};
use std::collections::BTreeMap;

/// Most tiles of a mesh; what lies in others has the first.
const MOST: usize = 1024;

impl Builder<'_> {
    /// True for a look with pictures in tiles.
    pub(super) fn is_tiled(&self, look: Option<&str>) -> bool {
        let look = look.and_then(|look| self.looks.get(look)?.as_ref());
        look.is_some_and(|look| look.is_tiled)
    }

    /// Draws a mesh tile by tile.
    pub(super) fn tiles(
        &mut self,
        prim: &Composed,
        (key, data): (MeshKey, MeshData),
        path: &str,
        is_double: bool,
        state: &Inherited,
    ) -> Result<(), LoadError> {
        if !self.tiled.contains_key(&key) {
            let meshes = self.split(prim, &key, &data)?;
            self.tiled.insert(key.clone(), meshes);
        }
        for (tile, mesh) in self.tiled.get(&key).cloned().unwrap_or_default() {
            let look = self.of_tile(path, tile)?;
            let material = self.material(look, prim, is_double)?;
            self.place(prim, Some(mesh), material, state)?;
        }
        Ok(())
    }

    /// The look of a material in a tile.
    pub(super) fn of_tile(&mut self, path: &str, tile: u32) -> Result<Option<String>, LoadError> {
        // No path has a space.
        let name = format!("{path} {tile}");
        self.add_look(&name, path, Some(tile))?;
        Ok(self.looks.get(&name).is_some_and(Option::is_some).then_some(name))
    }

    /// The parts of a mesh by tiles.
    fn split(
        &mut self,
        prim: &Composed,
        (identity, reads, number): &MeshKey,
        data: &MeshData,
    ) -> Result<Vec<(u32, MeshId)>, LoadError> {
        let [uvs, _] = &data.uvs;
        let mut parts: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
        for triangle in &data.triangles {
            let corners = triangle.map(|v| uvs.get(v as usize).copied().unwrap_or_default());
            let tile = udim::tile(corners).filter(|tile| parts.len() < MOST || parts.contains_key(tile));
            parts.entry(tile.unwrap_or(udim::FIRST)).or_default().push(*triangle);
        }
        let mut meshes = Vec::new();
        for (tile, triangles) in parts {
            // One more than a prim has.
            let mut identity = identity.clone();
            identity.push(tile as usize);
            let key = (identity, reads.clone(), *number);
            meshes.extend(self.add_mesh(prim, key, part(data, triangles))?.map(|mesh| (tile, mesh)));
        }
        Ok(meshes)
    }
}

/// Some triangles of a mesh, with their vertices alone.
fn part(data: &MeshData, triangles: Vec<[u32; 3]>) -> MeshData {
    let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
    let mut order = Vec::new();
    let triangles = triangles
        .into_iter()
        .map(|triangle| {
            triangle.map(|v| {
                let next = order.len() as u32;
                *numbers.entry(v).or_insert_with(|| {
                    order.push(v as usize);
                    next
                })
            })
        })
        .collect();
    MeshData::default().with(|d| {
        d.positions = chosen(&data.positions, &order);
        d.normals = chosen(&data.normals, &order);
        d.tangents = chosen(&data.tangents, &order);
        d.uvs = data.uvs.each_ref().map(|uvs| chosen(uvs, &order));
        d.colors = chosen(&data.colors, &order);
        d.triangles = triangles;
        d.kind = data.kind;
    })
}

/// Items of a list, in an order.
fn chosen<T: Copy>(list: &[T], order: &[usize]) -> Vec<T> {
    order.iter().filter_map(|&k| list.get(k).copied()).collect()
}
