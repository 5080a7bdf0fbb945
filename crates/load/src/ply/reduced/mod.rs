//! Files of more vertices or faces than may be kept: read in parts. Meshes are reduced to clusters of vertices, of points one in
//! so many is drawn.

mod items;
#[cfg(test)]
mod tests;

use self::items::{Items, color};
use super::body::{INDICES, Slots, cut, settled, skip_property};
use super::edges::EDGES;
use super::header::{Element, Encoding, Header, Kind};
use super::stream::{Source, Stream};
use super::values::Values;
use super::{FACES, FORMAT, VERTICES, add_normals, load_read, splats};
use crate::clusters::Clusters;
use crate::mesh_formats::{add_object, default_material, drawable, finish, white_material};
use crate::origin::{Origin, load_about};
use crate::point_clouds;
use crate::polygon::Triangulator;
use crate::shares::Shares;
use crate::vertices::PositionTable;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded, TextureLoading};
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{Bounds, Scene};
use std::fs::File;
use std::io::{Cursor, Read};

/// Bytes in which the header of a large file ends.
const HEAD: u64 = 1 << 16;

/// Bytes of a point that is kept and drawn, beside those of the file.
const POINT: u64 = 64;

/// Limits that a reduced model is within.
const REDUCED: [&str; 5] = ["triangles", "vertices", "decoded_bytes", "input_bytes", "memory"];

/// Reads a file that is larger than the limits allow, in parts. `None` for others, and for what cannot be reduced.
///
/// # Errors
/// [`LoadError::Io`], [`LoadError::Limit`].
pub(crate) fn load_file(mut file: File, context: &Context<'_>) -> Result<Option<Loaded>, LoadError> {
    let size = file.metadata()?.len();
    let mut head = Vec::new();
    (&mut file).take(HEAD).read_to_end(&mut head)?;
    let Ok(header) = Header::read(&head, &mut Warnings::default()) else { return Ok(None) };
    if size <= context.limits.input_bytes && !is_large(&header, context.limits) {
        return Ok(None);
    }
    reduce(&head, size, &mut file, context)
}

/// Reads a file in memory for which the limits do not suffice; the error if it cannot be reduced.
pub(super) fn load_bytes(
    bytes: &[u8],
    error: LimitExceeded,
    context: &Context<'_>,
) -> Result<Loaded, LoadError> {
    if !REDUCED.contains(&error.field) {
        return Err(error.into());
    }
    reduce(bytes, bytes.len() as u64, &mut Cursor::new(bytes), context)?.ok_or(error.into())
}

/// True for a file that the limits do not suffice for. Each face has a triangle at least.
fn is_large(header: &Header<'_>, limits: &Limits) -> bool {
    let count = |names: &[&str]| {
        let named = header.elements.iter().filter(|e| names.contains(&e.name.as_str()));
        named.map(|e| e.count).fold(0, u64::saturating_add)
    };
    let (vertices, faces) = (count(&VERTICES), count(&FACES));
    vertices > limits.vertices
        || faces > limits.triangles
        || vertices.saturating_add(faces).saturating_mul(24) > limits.decoded_bytes
}

/// Reduces a file with this beginning.
fn reduce(
    head: &[u8],
    size: u64,
    source: &mut dyn Source,
    context: &Context<'_>,
) -> Result<Option<Loaded>, LoadError> {
    let mut warnings = Warnings::default();
    let Ok(mut header) = Header::read(head, &mut warnings) else { return Ok(None) };
    let place = (head.len() as u64).saturating_sub(header.body.len() as u64);
    splats::take_prefixes_away(&mut header);
    let is_of =
        |names: &[&str], element: &Element| names.contains(&element.name.as_str()) && element.count > 0;
    // A count that the file cannot hold by far says nothing of what is to be reduced.
    let least = |element: &Element| element.count.saturating_mul(element.min_size(header.encoding));
    let claimed = header.elements.iter().map(least).fold(0, u64::saturating_add);
    // Sizes of `long` are told by the whole file; splats cannot be joined.
    if claimed / 4 > size || !header.longs.is_empty() || splats::layout(&header).is_some() {
        return Ok(None);
    }
    let Some(at) = header.elements.iter().position(|e| is_of(&VERTICES, e)) else { return Ok(None) };
    let Some((before, [vertices, after @ ..])) = header.elements.split_at_checked(at) else {
        return Ok(None);
    };
    let has = |names: &[&str]| header.elements.iter().any(|e| is_of(names, e));
    if before.iter().any(|e| e.count > 0) || has(&EDGES) || !Slots::new(vertices).has(0..3) {
        return Ok(None);
    }
    let file = Large { encoding: header.encoding, place, size, vertices, after };
    if !has(&FACES) {
        return file.points(&header, source, context, warnings);
    }
    match file.after.iter().find(|e| is_of(&FACES, e)) {
        Some(faces) if indices(faces).is_some() && !is_of(&["tristrips"], faces) => {
            file.mesh(!header.textures.is_empty(), source, context, warnings)
        }
        _ => Ok(None),
    }
}

/// The list of a face's corners.
fn indices(faces: &Element) -> Option<usize> {
    faces.properties.iter().position(|property| {
        matches!(property.kind, Kind::List(_, scalar) if !scalar.is_float())
            && INDICES.contains(&property.name.as_str())
    })
}

/// A file that is read in parts.
struct Large<'a> {
    encoding: Encoding,
    /// First byte behind the header, and number of bytes of the file.
    place: u64,
    size: u64,
    vertices: &'a Element,
    /// Elements behind the vertices.
    after: &'a [Element],
}

impl Large<'_> {
    /// A few of the points; `None` if there are none.
    fn points(
        &self,
        header: &Header<'_>,
        source: &mut dyn Source,
        context: &Context<'_>,
        mut warnings: Warnings,
    ) -> Result<Option<Loaded>, LoadError> {
        let element = self.vertices;
        let bytes = element.min_size(self.encoding).saturating_add(POINT).saturating_mul(2);
        let most = context.limits.decoded_bytes.checked_div(bytes).unwrap_or(0);
        let stride = point_clouds::stride(FORMAT, context, element.count, most, &mut warnings)?;
        let (mut kept, mut number, mut count) = (Vec::new(), 0_u64, 0_u64);
        let mut stream = Stream::new(source, self.place, self.encoding)?;
        let (read, missing) = stream.each(element.count, |values| {
            let before = values.rest();
            element.properties.iter().try_for_each(|property| skip_property(property.kind, values))?;
            if number.is_multiple_of(stride) {
                let length = before.len().saturating_sub(values.rest().len());
                kept.extend_from_slice(before.get(..length).unwrap_or_default());
                if self.encoding == Encoding::Ascii {
                    kept.push(b'\n');
                }
                count = count.saturating_add(1);
            }
            number = number.saturating_add(1);
            Ok(())
        })?;
        if let Some(missing) = missing {
            let cut = cut(element, read, missing);
            if read == 0 {
                return Ok(None);
            }
            warnings.add(|| format!("PLY: {cut}; what comes before is drawn"));
        }
        let vertices = Element { count, by_line: false, ..element.clone() };
        let few = Header {
            encoding: self.encoding,
            elements: vec![vertices],
            textures: Vec::new(),
            up: header.up,
            longs: Vec::new(),
            body: &kept,
        };
        let (loading, shares) = (TextureLoading::Whole, &Shares::default());
        load_about(|region| load_read(&few, region, context, loading, shares, warnings.clone())).map(Some)
    }

    /// A mesh of fewer triangles; `None` if the limits leave none.
    fn mesh(
        &self,
        has_textures: bool,
        source: &mut dyn Source,
        context: &Context<'_>,
        mut warnings: Warnings,
    ) -> Result<Option<Loaded>, LoadError> {
        let numbers = self.vertices.count.min(self.size).saturating_mul(4);
        let limit = context.limits.decoded_bytes;
        Limits::check(|| "PLY: the numbers of vertices".to_owned(), numbers, limit, "decoded_bytes")?;
        Limits::check_memory(|| "PLY: the numbers of vertices".to_owned(), numbers)?;
        let Survey { bounds, origin, has_codes } = self.survey(source)?;
        let limits = context.limits;
        // Positions, normals, triangles and what they are made from: less than a hundred bytes.
        let most = limits.triangles.min(limits.vertices).min(limits.decoded_bytes / 128);
        let seed = PositionTable::seed(bytemuck::bytes_of(&[bounds.min, bounds.max]));
        let mut reading = Reading {
            clusters: Clusters::new(&bounds, most, seed),
            origin,
            has_codes,
            losses: Losses { textures: has_textures, ..Losses::default() },
            triangles: 0,
        };
        let mut stream = Stream::new(source, self.place, self.encoding)?;
        let vertices = Items::new(self.vertices, self.encoding);
        let with_colors = vertices.has_colors();
        let mut end = reading.vertices(&vertices, with_colors, &mut stream)?;
        // Items of nothing take no bytes, and a file may claim any number of them.
        for element in self.after.iter().filter(|element| !element.properties.is_empty()) {
            if end.is_some() {
                break;
            }
            let faces = indices(element).filter(|_| FACES.contains(&element.name.as_str()));
            end = match faces {
                Some(at) => {
                    reading.faces(&Items::new(element, self.encoding), at, with_colors, &mut stream)?
                }
                None => {
                    let skip = |values: &mut Values<'_>| {
                        element
                            .properties
                            .iter()
                            .try_for_each(|property| skip_property(property.kind, values))
                    };
                    let (read, missing) = stream.each(element.count, skip)?;
                    missing.map(|missing| cut(element, read, missing))
                }
            };
        }
        if let Some(cut) = end {
            if reading.triangles == 0 {
                return Ok(None);
            }
            warnings.add(|| format!("PLY: {cut}; what comes before is drawn"));
        }
        reading.finish(context, warnings)
    }

    /// Goes through the vertices once.
    fn survey(&self, source: &mut dyn Source) -> Result<Survey, LoadError> {
        let items = Items::new(self.vertices, self.encoding);
        let has_fractions = items.has_fractions();
        let (mut bounds, mut has_codes) = (Bounds::EMPTY, false);
        let mut stream = Stream::new(source, self.place, self.encoding)?;
        items.each_vertex(has_fractions, &mut stream, |position, item| {
            if drawable(position.map(|v| v as f32)) {
                bounds = bounds.union(&Bounds { min: position, max: position });
                has_codes |= has_fractions && color(item).iter().any(|&v| v > 2.0);
            }
        })?;
        let origin =
            Some(&bounds).filter(|bounds| bounds.is_far()).map(|bounds| Origin(bounds.round_center()));
        if let Some(Origin(origin)) = origin {
            for (v, origin) in bounds.min.iter_mut().chain(&mut bounds.max).zip(origin.iter().cycle()) {
                *v -= origin;
            }
        }
        Ok(Survey { bounds, origin, has_codes })
    }
}

/// Facts of the vertices that have to be known before the first is placed.
struct Survey {
    /// About the origin.
    bounds: Bounds,
    /// Origin of a model far away.
    origin: Option<Origin>,
    /// Fractions of colours are codes of 8 bits.
    has_codes: bool,
}

/// Parts of a file that a reduced mesh does not have.
#[derive(Default)]
struct Losses {
    bad: u64,
    short: u64,
    textures: bool,
}

/// A mesh that is read.
struct Reading {
    clusters: Clusters,
    origin: Option<Origin>,
    has_codes: bool,
    losses: Losses,
    /// Triangles of the file.
    triangles: u64,
}

impl Reading {
    /// Reads the vertices. Returns the reason if there are fewer than the header says.
    fn vertices(
        &mut self,
        items: &Items<'_>,
        with_colors: bool,
        stream: &mut Stream<'_>,
    ) -> Result<Option<String>, LoadError> {
        let Self { clusters, origin, has_codes, .. } = self;
        let fractions = items.has_fractions();
        Ok(items.each_vertex(with_colors, stream, |position, item| {
            let single = position.map(|v| v as f32);
            let place = drawable(single).then(|| origin.map_or(single, |origin| origin.relative(position)));
            clusters.add_vertex(place);
            if with_colors {
                let number = clusters.vertices().saturating_sub(1);
                clusters.add_color(number, linear(color(item), fractions, *has_codes));
            }
        })?)
    }

    /// Reads the faces. `with_colors`: those of the vertices are known, and count. Returns the reason if there are fewer than the
    /// header says.
    fn faces(
        &mut self,
        items: &Items<'_>,
        at: usize,
        with_colors: bool,
        stream: &mut Stream<'_>,
    ) -> Result<Option<String>, LoadError> {
        let Self { clusters, losses, triangles, has_codes, .. } = self;
        let paints = !with_colors && items.has_colors();
        let fractions = items.has_fractions();
        let mut polygon: Vec<(u32, [f32; 3])> = Vec::new();
        let mut triangulator = Triangulator::default();
        Ok(items.each_face(at, paints, stream, |corners, item| {
            if corners.len() < 3 {
                losses.short = losses.short.saturating_add(1);
                return;
            }
            if !corners.iter().all(|&corner| clusters.has(corner)) {
                losses.bad = losses.bad.saturating_add(1);
                return;
            }
            if paints {
                let color = linear(color(item), fractions, *has_codes);
                corners.iter().for_each(|&corner| clusters.add_color(corner as usize, color));
            }
            if let &[a, b, c] = corners {
                *triangles = triangles.saturating_add(1);
                clusters.add_triangle([a, b, c].map(|corner| corner as u32));
                return;
            }
            // Positions matter to the triangulation of larger polygons alone.
            polygon.clear();
            let near = |&corner: &i64| Some((corner as u32, clusters.near(corner)?));
            polygon.extend(corners.iter().filter_map(near));
            triangulator.triangulate(
                &polygon,
                |(_, position)| position,
                |t| {
                    *triangles = triangles.saturating_add(1);
                    clusters.add_triangle(t.map(|(corner, _)| corner));
                },
            );
        })?)
    }

    /// The scene; `None` if no triangle is left.
    fn finish(self, context: &Context<'_>, mut warnings: Warnings) -> Result<Option<Loaded>, LoadError> {
        let Self { clusters, origin, losses, triangles, .. } = self;
        let cells = clusters.cells();
        let mut data = clusters.finish([0.0; 3]);
        let left = data.triangles.len();
        if left == 0 {
            return Ok(None);
        }
        let textures = if losses.textures { "; textures are left out" } else { "" };
        warnings.add(|| {
            format!(
                "PLY: {} are drawn as {left}, with vertices joined within 1/{cells} of the model's size: the limits \
                 allow no more (triangles, vertices, input_bytes, decoded_bytes){textures}",
                counted(triangles, "triangle")
            )
        });
        for (count, why) in [
            (losses.bad, "left out: vertices missing, not finite or beyond 1e15"),
            (losses.short, "of less than three vertices left out"),
        ] {
            if count > 0 {
                warnings.add(|| format!("PLY: {} {why}", counted(count, "face")));
            }
        }
        let mut scene = Scene::new();
        scene.set_origin(origin.unwrap_or_default().0);
        add_normals(&mut data, context.jobs);
        let material = if data.colors.is_empty() { default_material() } else { white_material() };
        let material = scene.add_material(material).map_err(LoadError::scene("PLY: material"))?;
        add_object(&mut scene, "PLY: mesh", data, material, 0)?;
        Ok(Some(finish(scene, warnings.finish())))
    }
}

/// A linear colour of what [`store`] has left: fractions may be codes, as those above 2 are.
fn linear(color: [f32; 3], are_fractions: bool, are_codes: bool) -> [f32; 3] {
    let are_codes = are_codes || color.iter().any(|&v| v > 2.0);
    if are_fractions { color.map(|v| settled(v, are_codes)) } else { color }
}
