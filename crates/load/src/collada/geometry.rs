//! Meshes: sources, inputs and primitives.

use super::document::{id_of, numbers};
use crate::mesh_formats::{check_mesh, drawable};
use crate::polygon::Triangulator;
use crate::splitting::Variants;
use crate::text::{Tokens, integer};
use crate::xml::{Tag, Xml};
use crate::{Context, LoadError};
use overcoat_scene::{MeshData, PrimitiveKind};
use std::collections::BTreeMap;

/// Vertices of one position that are compared before another is made.
const SEARCHED: usize = 64;

/// Primitives of a geometry, each with a material.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) name: String,
    pub(super) primitives: Vec<Primitive>,
    /// Faces whose vertices do not exist, or are not finite.
    pub(super) bad: u64,
    /// Polygons with holes, which are filled.
    pub(super) holes: u64,
    /// Splines and the like.
    pub(super) unknown: u64,
}

#[derive(Debug, Default)]
pub(super) struct Primitive {
    /// Symbol of the material.
    pub(super) symbol: String,
    pub(super) data: MeshData,
}

/// Numbers in groups.
#[derive(Debug, Default)]
struct Source {
    values: Vec<f32>,
    stride: usize,
    offset: usize,
    /// Places within a group that have names, where others have none: those are skipped (COLLADA 1.4.1, chapter 5, `accessor`).
    named: Vec<usize>,
}

impl Source {
    fn get<const N: usize>(&self, index: u32) -> Option<[f32; N]> {
        let start = (index as usize).checked_mul(self.stride)?.checked_add(self.offset)?;
        if let Some(places) = self.named.first_chunk::<N>() {
            let mut group = [0.0; N];
            for (value, place) in group.iter_mut().zip(places) {
                *value = *self.values.get(start.checked_add(*place)?)?;
            }
            return Some(group);
        }
        self.values.get(start..start.checked_add(N)?)?.first_chunk().copied()
    }

    fn len(&self) -> usize {
        self.values.len().checked_div(self.stride).unwrap_or(0)
    }
}

/// An input of a primitive: what it means, where it comes from, and its place among the indices.
#[derive(Clone, Debug)]
struct Input {
    semantic: String,
    source: String,
    offset: usize,
    set: u32,
}

impl Input {
    fn read(tag: &Tag<'_>) -> Self {
        let text = |name: &str| tag.attribute(name).unwrap_or_default();
        let number = |name: &str| tag.number(name).unwrap_or(0);
        Self {
            semantic: text("semantic"),
            source: id_of(&text("source")),
            offset: number("offset").min(255) as usize,
            set: number("set"),
        }
    }
}

/// Sources of a mesh, and what its element `vertices` makes of them.
#[derive(Default)]
struct Mesh {
    sources: BTreeMap<String, Source>,
    vertices: BTreeMap<String, Vec<Input>>,
}

/// Reads a geometry.
pub(super) fn read(xml: &mut Xml<'_>, name: String, context: &Context<'_>) -> Result<Geometry, LoadError> {
    let mut geometry = Geometry { name, ..Geometry::default() };
    xml.children(|xml, tag| match tag.name() {
        "mesh" | "convex_mesh" => mesh(xml, &mut geometry, context),
        "asset" | "extra" => Ok(()),
        _ => {
            geometry.unknown = geometry.unknown.saturating_add(1);
            Ok(())
        }
    })?;
    Ok(geometry)
}

fn mesh(xml: &mut Xml<'_>, geometry: &mut Geometry, context: &Context<'_>) -> Result<(), LoadError> {
    let mut mesh = Mesh::default();
    xml.children(|xml, tag| {
        let id = || tag.attribute("id").unwrap_or_default();
        match tag.name() {
            "source" => _ = mesh.sources.insert(id(), source(xml)?),
            "vertices" => {
                let mut inputs = Vec::new();
                xml.children(|_, tag| {
                    if tag.name() == "input" {
                        inputs.push(Input::read(tag));
                    }
                    Ok(())
                })?;
                mesh.vertices.insert(id(), inputs);
            }
            kind @ ("triangles" | "polylist" | "polygons" | "trifans" | "tristrips" | "lines"
            | "linestrips") => {
                let (kind, symbol) = (kind.to_owned(), tag.attribute("material").unwrap_or_default());
                let lists = Lists::read(xml, geometry)?;
                let data = lists.build(&kind, &mesh, geometry, context)?;
                if !data.triangles.is_empty() {
                    geometry.primitives.push(Primitive { symbol, data });
                }
            }
            _ => {}
        }
        Ok(())
    })
}

fn source(xml: &mut Xml<'_>) -> Result<Source, LoadError> {
    let mut source = Source { stride: 1, ..Source::default() };
    xml.children(|xml, tag| {
        match tag.name() {
            "float_array" => source.values = numbers(&xml.content()?).map(|v| v as f32).collect(),
            "technique_common" => xml.children(|xml, tag| {
                if tag.name() == "accessor" {
                    source.stride = tag.number("stride").unwrap_or(1).max(1) as usize;
                    source.offset = tag.number("offset").unwrap_or(0) as usize;
                    source.named = named_parameters(xml)?;
                }
                Ok(())
            })?,
            _ => {}
        }
        Ok(())
    })?;
    Ok(source)
}

/// Places of an accessor's parameters that have names; none if all have or all do not.
fn named_parameters(xml: &mut Xml<'_>) -> Result<Vec<usize>, LoadError> {
    let (mut named, mut count) = (Vec::new(), 0_usize);
    xml.children(|_, tag| {
        if tag.name() == "param" {
            // The first four count: no more have a meaning.
            if named.len() < 4 && tag.attribute("name").is_some_and(|name| !name.is_empty()) {
                named.push(count);
            }
            count = count.saturating_add(1);
        }
        Ok(())
    })?;
    let is_first = named.last().is_none_or(|last| last.saturating_add(1) == named.len());
    Ok(if is_first { Vec::new() } else { named })
}

/// Lists of a primitive, as they are written.
#[derive(Default)]
struct Lists {
    inputs: Vec<Input>,
    counts: Vec<u32>,
    /// One for each polygon, fan or strip; one for all triangles.
    indices: Vec<Vec<u32>>,
}

fn whole(text: &str) -> impl Iterator<Item = u32> {
    let mut tokens = Tokens::new(text.as_bytes());
    // Negative ones do not exist either.
    std::iter::from_fn(move || tokens.next().map(|word| integer(word).and_then(|v| u32::try_from(v).ok())))
        .map(|index| index.unwrap_or(u32::MAX))
}

impl Lists {
    fn read(xml: &mut Xml<'_>, geometry: &mut Geometry) -> Result<Self, LoadError> {
        let mut lists = Self::default();
        xml.children(|xml, tag| {
            match tag.name() {
                "input" => lists.inputs.push(Input::read(tag)),
                "vcount" => lists.counts.extend(whole(&xml.content()?)),
                "p" => lists.indices.push(whole(&xml.content()?).collect()),
                "ph" => {
                    geometry.holes = geometry.holes.saturating_add(1);
                    xml.children(|xml, tag| {
                        if tag.name() == "p" {
                            lists.indices.push(whole(&xml.content()?).collect());
                        }
                        Ok(())
                    })?;
                }
                _ => {}
            }
            Ok(())
        })?;
        Ok(lists)
    }

    /// Builds a mesh. What refers to what does not exist is left out, and counted.
    fn build(
        &self,
        kind: &str,
        mesh: &Mesh,
        geometry: &mut Geometry,
        context: &Context<'_>,
    ) -> Result<MeshData, LoadError> {
        let mut out = Builder::new(&self.inputs, mesh);
        let stride = self.inputs.iter().map(|input| input.offset).max().unwrap_or(0).saturating_add(1);
        let mut corners: Vec<[u32; 4]> = Vec::new();
        for list in &self.indices {
            corners.clear();
            corners.extend(list.chunks_exact(stride).map(|indices| out.corner(indices)));
            match kind {
                "triangles" => corners.chunks_exact(3).for_each(|face| out.polygon(face)),
                "polylist" => {
                    let mut rest = corners.as_slice();
                    for &count in &self.counts {
                        let Some((face, after)) = rest.split_at_checked(count as usize) else {
                            out.bad = out.bad.saturating_add(1);
                            break;
                        };
                        out.polygon(face);
                        rest = after;
                    }
                }
                "trifans" => {
                    if let Some((&first, others)) = corners.split_first() {
                        others.windows(2).for_each(|pair| {
                            if let [a, b] = *pair {
                                out.polygon(&[first, a, b]);
                            }
                        });
                    }
                }
                "tristrips" => corners.windows(3).enumerate().for_each(|(k, face)| {
                    if let [a, b, c] = *face {
                        out.polygon(&if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
                    }
                }),
                "lines" => corners.chunks_exact(2).for_each(|line| out.line(line)),
                "linestrips" => corners.windows(2).for_each(|line| out.line(line)),
                _ => out.polygon(&corners),
            }
            let sizes = (out.data.triangles.len() as u64, out.data.positions.len() as u64);
            check_mesh(context, sizes.0, sizes.1)?;
        }
        geometry.bad = geometry.bad.saturating_add(out.bad);
        if matches!(kind, "lines" | "linestrips") {
            out.data.kind = PrimitiveKind::Lines;
            out.data.normals = Vec::new();
        }
        Ok(out.data)
    }
}

/// A mesh of corners, each of which has an index of a position, a normal, texture coordinates and a colour.
struct Builder<'a> {
    position: Option<(&'a Source, usize)>,
    normal: Option<(&'a Source, usize)>,
    uv: Option<(&'a Source, usize)>,
    color: Option<(&'a Source, usize)>,
    vertices: Variants<[u32; 3]>,
    triangulator: Triangulator,
    data: MeshData,
    bad: u64,
}

impl<'a> Builder<'a> {
    fn new(inputs: &'a [Input], mesh: &'a Mesh) -> Self {
        // The inputs of the vertices have the index of these.
        let own = inputs.iter().filter(|input| input.semantic == "VERTEX").flat_map(|vertex| {
            let inputs = mesh.vertices.get(&vertex.source).map(Vec::as_slice).unwrap_or_default();
            inputs.iter().map(|input| (input, vertex.offset))
        });
        let all: Vec<(&Input, usize)> = inputs.iter().map(|input| (input, input.offset)).chain(own).collect();
        let find = |semantic: &str| {
            let of = all.iter().filter(|(input, _)| input.semantic == semantic);
            let (input, offset) = of.min_by_key(|(input, _)| input.set)?;
            Some((mesh.sources.get(&input.source)?, *offset))
        };
        let position = find("POSITION");
        Self {
            position,
            normal: find("NORMAL"),
            uv: find("TEXCOORD"),
            color: find("COLOR"),
            vertices: Variants::new(position.map_or(0, |(source, _)| source.len()), SEARCHED),
            triangulator: Triangulator::default(),
            data: MeshData::default(),
            bad: 0,
        }
    }

    /// Indices of a corner: of position, normal, texture coordinates and colour.
    fn corner(&self, indices: &[u32]) -> [u32; 4] {
        let of = |input: &Option<(&Source, usize)>| {
            input.and_then(|(_, offset)| indices.get(offset).copied()).unwrap_or(u32::MAX)
        };
        [of(&self.position), of(&self.normal), of(&self.uv), of(&self.color)]
    }

    fn position(&self, corner: &[u32; 4]) -> Option<[f32; 3]> {
        self.position?.0.get(corner[0]).filter(|&position| drawable(position))
    }

    fn polygon(&mut self, corners: &[[u32; 4]]) {
        if corners.len() < 3 || !corners.iter().all(|corner| self.position(corner).is_some()) {
            self.bad = self.bad.saturating_add(1);
            return;
        }
        let mut triangulator = std::mem::take(&mut self.triangulator);
        let mut triangles = Vec::new();
        let position = |corner: [u32; 4]| self.position(&corner).unwrap_or_default();
        triangulator.triangulate(corners, position, |triangle| triangles.push(triangle));
        self.triangulator = triangulator;
        for triangle in triangles {
            if let [Some(a), Some(b), Some(c)] = triangle.map(|corner| self.vertex(corner)) {
                self.data.triangles.push([a, b, c]);
            }
        }
    }

    fn line(&mut self, ends: &[[u32; 4]]) {
        if let [a, b] = *ends
            && self.position(&a).is_some()
            && self.position(&b).is_some()
        {
            if let (Some(a), Some(b)) = (self.vertex(a), self.vertex(b)) {
                self.data.triangles.push([a, b, b]);
            }
        } else {
            self.bad = self.bad.saturating_add(1);
        }
    }

    /// The vertex of a corner: one that is there, or a new one.
    fn vertex(&mut self, corner: [u32; 4]) -> Option<u32> {
        let [place, normal, uv, color] = corner;
        let (number, is_new) = self.vertices.number(place as usize, [normal, uv, color])?;
        if is_new {
            let position = self.position(&corner)?;
            self.data.positions.push(position);
            if let Some((source, _)) = self.normal {
                let found = source.get::<3>(normal).filter(|normal| normal.iter().all(|v| v.is_finite()));
                self.data.normals.push(found.unwrap_or_default());
            }
            if let Some((source, _)) = self.uv {
                let found = source.get::<2>(uv).filter(|uv| uv.iter().all(|v| v.abs() <= 1e9));
                self.data.uvs[0].push(found.map_or([0.0; 2], |[u, v]| [u, 1.0 - v]));
            }
            if let Some((source, _)) = self.color {
                let rgb = source.get::<3>(color).unwrap_or([1.0; 3]);
                let part = |v: f32| if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 };
                let [r, g, b] = rgb.map(|v| overcoat_core::color::srgb::srgb_to_linear(part(v)));
                self.data.colors.push([r, g, b, 1.0]);
            }
        }
        Some(number)
    }
}
